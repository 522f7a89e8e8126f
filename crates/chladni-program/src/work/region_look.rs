//! The look of a region on the shape while it is chosen.

use chladni_caricature::{Reach, Surface};
use chladni_mesh::linear_from_srgb;
use chladni_view::{BrushRing, Device, Material, ViewError, srgb_bytes};

/// Color of painted places, sRGB: distinct from clay with any color vision.
pub const PAINTED: [u8; 3] = [52, 122, 190];
/// Color of the brush's ring, sRGB.
pub const RING: [u8; 3] = [236, 170, 70];
/// Color of marked places, sRGB.
pub const MARKED: [u8; 3] = [214, 40, 30];

/// The material's color where `values` are 0, `tint` where they are 1; sRGB.
pub fn tints(values: &[f32], tint: [u8; 3], material: Material) -> Vec<[u8; 4]> {
    let linear = |c: u8| linear_from_srgb(f64::from(c) / 255.0) as f32;
    let (bare, painted) = (material.color.map(linear), tint.map(linear));
    // While somebody paints, for every vertex: from a table.
    let mixed: [[u8; 4]; 256] = std::array::from_fn(|step| {
        let share = step as f32 / 255.0 * 0.85;
        let [r, g, b] = [0, 1, 2].map(|i| bare[i] + (painted[i] - bare[i]) * share);
        srgb_bytes([r, g, b, 1.0])
    });
    values.iter().map(|share| mixed[usize::from((share.clamp(0.0, 1.0) * 255.0).round() as u8)]).collect()
}

/// A region with the part under the pointer, fainter. A region that is everywhere would hide it.
pub fn with_pointed(region: &[f32], pointed: &[f32]) -> Vec<f32> {
    let everywhere = region.iter().all(|x| *x == 1.0);
    let both = |(region, pointed): (&f32, &f32)| {
        if everywhere { 0.6 * pointed } else { region.max(0.6 * pointed) }
    };
    region.iter().zip(pointed).map(both).collect()
}

/// Lays the ring where a brush with this `reach` would paint; lifts it where there is none.
///
/// # Errors
/// As [`BrushRing::lay`].
pub fn lay_ring(
    ring: &mut BrushRing,
    on: &Device,
    reach: Option<&Reach>,
    surface: &Surface,
) -> Result<(), ViewError> {
    let Some(reach) = reach else {
        ring.lift();
        return Ok(());
    };
    let triangles = reach.triangles.iter().filter_map(|t| surface.triangles.get(*t as usize));
    let triangles: Vec<[u32; 3]> = triangles.copied().collect();
    let distances = reach.distances.iter().map(|(v, distance)| (*v, *distance as f32));
    ring.lay(on, reach.radius as f32, distances, &triangles)
}
