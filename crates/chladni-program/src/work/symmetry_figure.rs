//! The music paper's figure of extrema and pairs, as markers on a body.

use chladni_harmonics::Body;
use chladni_music::Symmetry;
use chladni_view::Marker;

/// Colors of the pairs' markers, in turn.
const PAIR_COLORS: [[u8; 3]; 8] = [
    [230, 60, 60],
    [50, 120, 230],
    [40, 170, 90],
    [240, 160, 30],
    [150, 80, 200],
    [30, 180, 190],
    [220, 90, 170],
    [120, 110, 90],
];

/// The paper's figure: all extrema as small dots, both ends of a pair in one color.
pub fn figure_markers(body: &Body, symmetry: &Symmetry) -> Vec<Marker> {
    let marker = |v: u32, [r, g, b]: [u8; 3], radius_px| {
        let position = body.positions.get(v as usize)?.map(|c| c as f32);
        Some(Marker { position, radius_px, color: [r, g, b, 255] })
    };
    let dots = symmetry.extrema.iter().map(|&v| marker(v, [20, 20, 20], 3.0));
    let pairs = symmetry.pairs.iter().zip(PAIR_COLORS.iter().cycle());
    dots.chain(pairs.flat_map(|(pair, &color)| pair.map(|v| marker(v, color, 6.0)))).flatten().collect()
}
