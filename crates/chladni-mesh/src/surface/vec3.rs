//! Three-vectors as plain arrays.

/// x, y and z.
pub type Vec3 = [f64; 3];

/// a − b.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] - b[i])
}

/// a + b.
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] + b[i])
}

/// s a.
pub fn scaled(a: Vec3, s: f64) -> Vec3 {
    a.map(|x| x * s)
}

/// ⟨a, b⟩.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// ‖a‖.
pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// ‖a − b‖.
pub fn distance(a: Vec3, b: Vec3) -> f64 {
    length(sub(a, b))
}

/// `a` scaled to length 1, or zero if its squared length is zero or not finite in f64.
pub fn unit(a: Vec3) -> Vec3 {
    let l = length(a);
    if l > 1e-150 { scaled(a, 1.0 / l) } else { [0.0; 3] }
}

/// Points in the precision of pictures.
pub fn single(points: &[Vec3]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|c| c as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        [-10.0..10.0, -10.0..10.0, -10.0..10.0]
    }

    proptest! {
        #[test]
        fn a_cross_product_is_at_right_angles_and_as_long_as_the_parallelogram(a in vector(), b in vector()) {
            let c = cross(a, b);
            prop_assert!(dot(a, c).abs() < 1e-10 && dot(b, c).abs() < 1e-10);
            // Lagrange: ‖a × b‖² = ‖a‖²‖b‖² − ⟨a, b⟩².
            let squared = dot(a, a) * dot(b, b) - dot(a, b).powi(2);
            prop_assert!((dot(c, c) - squared).abs() < 1e-9 * (1.0 + dot(a, a) * dot(b, b)));
        }

        #[test]
        fn a_unit_is_of_length_one(a in vector()) {
            prop_assume!(length(a) > 1e-3);
            prop_assert!((length(unit(a)) - 1.0).abs() < 1e-15);
            prop_assert!(distance(scaled(unit(a), length(a)), a) < 1e-14);
        }
    }

    #[test]
    fn nothing_has_no_direction() {
        assert_eq!(unit([0.0; 3]), [0.0; 3]);
    }
}
