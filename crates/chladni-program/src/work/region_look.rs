//! The look of a region on the shape while it is chosen.

use chladni_view::Material;

/// Color of painted places, sRGB: distinct from clay with any color vision.
pub const PAINTED: [u8; 3] = [52, 122, 190];
/// Color of the brush's ring, sRGB.
pub const RING: [u8; 3] = [236, 170, 70];
/// Color of marked places, sRGB.
pub const MARKED: [u8; 3] = [214, 40, 30];

/// The material's color where `values` are 0, `tint` where they are 1; linear light.
pub fn tints(values: &[f32], tint: [u8; 3], material: Material) -> Vec<[u8; 4]> {
    let linear = |c: u8| (f32::from(c) / 255.0).powf(2.2);
    let (bare, painted) = (material.color.map(linear), tint.map(linear));
    let mixed = |share: &f32| {
        let share = share.clamp(0.0, 1.0) * 0.85;
        let channel = |i: usize| ((bare[i] + (painted[i] - bare[i]) * share) * 255.0).round() as u8;
        [channel(0), channel(1), channel(2), 255]
    };
    values.iter().map(mixed).collect()
}

/// A region with the part under the pointer, fainter. A region that is everywhere would hide it.
pub fn with_pointed(region: &[f32], pointed: &[f32]) -> Vec<f32> {
    let everywhere = region.iter().all(|x| *x == 1.0);
    let both = |(region, pointed): (&f32, &f32)| {
        if everywhere { 0.6 * pointed } else { region.max(0.6 * pointed) }
    };
    region.iter().zip(pointed).map(both).collect()
}
