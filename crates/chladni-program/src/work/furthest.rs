//! How far a layer goes before it folds the surface.

use chladni_caricature::{EvaluatedLayer, Layer, Surface, furthest};

/// The share of the triangles that may fold where μ goes as far as it goes, unless another is asked for: one triangle of
/// 2000, since a sliver of a scan folds at once.
pub const MAY_FOLD: f64 = 5e-4;

/// The μ with the strongest exaggeration before `layer`, as it was `evaluated`, folds more than this share of the triangles
/// of `surface`; `None` where nothing moves or it never folds.
pub fn furthest_mu(
    evaluated: &EvaluatedLayer,
    layer: &Layer,
    surface: &Surface,
    may_fold: f64,
) -> Option<f64> {
    // What keeps triangles holds it back further and further: only without that is it proportional to μ.
    let displacement = evaluated.unlimited.as_ref()?;
    let mu = layer.effective_mu();
    if mu == 0.0 || layer.strength == 0.0 {
        return None;
    }
    let unit: Vec<[f64; 3]> = displacement.iter().map(|d| d.map(|c| c / mu)).collect();
    let allowed = (may_fold * surface.whole_triangles() as f64) as usize;
    let reach = furthest(surface, &evaluated.base.positions, &unit, mu.signum(), allowed)?;
    // Just before the next fold.
    Some((0.999 * reach / layer.strength).clamp(-100.0, 100.0))
}
