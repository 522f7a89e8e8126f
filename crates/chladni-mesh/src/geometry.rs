//! Lengths, areas and normals.

pub(crate) type Vec3 = [f64; 3];

pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] + b[i])
}

pub(crate) fn scaled(a: Vec3, s: f64) -> Vec3 {
    a.map(|x| x * s)
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// `a` at length 1, or zero where it has none.
pub(crate) fn unit(a: Vec3) -> Vec3 {
    let l = length(a);
    if l > 0.0 { scaled(a, 1.0 / l) } else { [0.0; 3] }
}

/// The normal of triangle (a, b, c), as long as twice its area.
pub(crate) fn doubled_area_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(sub(b, a), sub(c, a))
}

/// The corner positions of a triangle.
pub(crate) fn corners(positions: &[Vec3], triangle: &[u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| positions[v as usize])
}

/// Total area of the triangles, in squared units of `positions`.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn total_area(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    triangles.iter().map(|t| 0.5 * length(doubled_area_normal(corners(positions, t)))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_has_its_area() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [7.0; 3]];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!((total_area(&positions, &triangles) - (1.5 + 0.75_f64.sqrt())).abs() < 1e-15);
    }
}
