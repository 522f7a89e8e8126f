//! Parts of a surface that have no area.

use super::vec3::{Vec3, dot, sub};
use super::{components, corners, doubled_area_normal};

/// Whether a triangle names one position twice: it then has neither area nor a normal, and welding leaves it out.
///
/// # Panics
/// If it names a vertex that is not there.
pub fn is_collapsed(positions: &[Vec3], triangle: &[u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    a == b || b == c || c == a
}

/// The area of a triangle, or of several, and the square of their longest edge.
#[derive(Clone, Copy, Default)]
struct Extent {
    area: f64,
    longest: f64,
}

impl Extent {
    fn of(positions: &[Vec3], triangle: &[u32; 3]) -> Self {
        let points = corners(positions, triangle);
        // The squares of areas might underflow.
        let [x, y, z] = doubled_area_normal(points);
        let edges = (0..3).map(|i| sub(points[i], points[(i + 1) % 3]));
        Self { area: 0.5 * x.hypot(y).hypot(z), longest: edges.map(|e| dot(e, e)).fold(0.0, f64::max) }
    }

    /// The area is compared with the longest edge, which accepts tiny parts.
    fn is_flat(self) -> bool {
        self.area <= 1e-14 * self.longest
    }
}

/// Whether some triangle has no area, of those whose corners lie in three places.
pub(crate) fn has_flat_triangle(positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let is_flat =
        |triangle: &[u32; 3]| !is_collapsed(positions, triangle) && Extent::of(positions, triangle).is_flat();
    triangles.iter().any(is_flat)
}

/// For each of the components that `component` numbers, whether it has triangles, but no area.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn flat_components(positions: &[Vec3], triangles: &[[u32; 3]], component: &[u32]) -> Vec<bool> {
    let count = component.iter().max().map_or(0, |c| *c as usize + 1);
    let mut extents: Vec<Option<Extent>> = vec![None; count];
    for triangle in triangles {
        let own = Extent::of(positions, triangle);
        let all = extents[component[triangle[0] as usize] as usize].get_or_insert_default();
        all.area += own.area;
        all.longest = all.longest.max(own.longest);
    }
    extents.into_iter().map(|extent| extent.is_some_and(Extent::is_flat)).collect()
}

/// Leaves out the triangles of components that have no area, and returns how many components those were. Where none has an
/// area, all stay.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn leave_out_flat(positions: &[Vec3], triangles: &mut Vec<[u32; 3]>) -> usize {
    // The triangle with the longest edge of such a component has no area, either.
    if !triangles.iter().any(|triangle| Extent::of(positions, triangle).is_flat()) {
        return 0;
    }
    let component = components(positions.len(), triangles);
    let flat = flat_components(positions, triangles, &component);
    let is_flat = |[v, ..]: &[u32; 3]| flat[component[*v as usize] as usize];
    if triangles.iter().all(is_flat) {
        return 0;
    }
    triangles.retain(|triangle| !is_flat(triangle));
    flat.iter().filter(|flat| **flat).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_without_area_go_unless_there_is_nothing_else() {
        let mut positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        positions.extend([[9.0, 0.0, 0.0], [9.0, 1.0, 1.0], [9.0, 3.0, 3.0]]);
        // So small that the squares of areas are 0.
        positions.extend([[5.0, 0.0, 0.0], [5.0, 1e-90, 0.0], [5.0, 0.0, 1e-90]]);
        let all = vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]];
        let mut triangles = all.clone();
        assert_eq!(leave_out_flat(&positions, &mut triangles), 1);
        assert_eq!(triangles, [[0, 1, 2], [6, 7, 8]]);
        let mut flat = vec![[3, 4, 5]];
        assert_eq!((leave_out_flat(&positions, &mut flat), flat.len()), (0, 1));
        // A flat triangle of a part with an area belongs to it.
        let mut joined = vec![[0, 1, 2], [2, 1, 0], [0, 0, 1]];
        assert_eq!((leave_out_flat(&positions, &mut joined), joined.len()), (0, 3));
        // Three vertices in one place.
        positions.extend([[7.0; 3]; 3]);
        let mut collapsed = vec![[0, 1, 2], [9, 10, 11]];
        assert_eq!((leave_out_flat(&positions, &mut collapsed), collapsed.len()), (1, 1));
    }
}
