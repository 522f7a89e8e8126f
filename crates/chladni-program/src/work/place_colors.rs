//! Colors that show where a point of one shape lies on another.

use chladni_mesh::surface::Bounds;

/// A color for each place in the bounding box, linear light from 0 to 1: the same color means the same vertex, wherever a match
/// puts it.
pub fn place_colors(positions: &[[f64; 3]]) -> Vec<[f32; 4]> {
    let Bounds { low, high } = Bounds::of(positions.iter().copied());
    let color = |p: &[f64; 3]| {
        let [r, g, b] = std::array::from_fn(|i| {
            let share = (p[i] - low[i]) / (high[i] - low[i]).max(f64::MIN_POSITIVE);
            (0.08 + 0.72 * share) as f32
        });
        [r, g, b, 1.0]
    };
    positions.iter().map(color).collect()
}
