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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use chladni_caricature::{Project, ShapeSource, Stack, Template};
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_task::Task;

    use super::*;

    #[test]
    fn at_half_the_strength_mu_goes_twice_as_far() {
        let mut mesh = chladni_mesh::samples::icosphere(2);
        for p in &mut mesh.positions {
            let [x, y, z] = *p;
            let r = 1.0 + 0.2 * (3.0 * x).sin() + 0.15 * y * z;
            *p = [1.4 * r * x, r * y, 0.8 * r * z];
        }
        let body = Arc::new(Body::build(&mesh, &BasisSettings::new(32), &Task::new()).unwrap());
        let mut stack = Stack::new(body).unwrap();
        let mut at = |strength| {
            let mut project = Project::new(ShapeSource::Sample("lump".into()), 32);
            let layer = Layer { mu: -1.0, strength, ..Layer::new("detail", Template::LowPass(4)) };
            project.push(layer.clone()).unwrap();
            let evaluated = stack.evaluate(&project).layers.remove(0);
            furthest_mu(&evaluated, &layer, stack.surface(), 0.0).unwrap()
        };
        let (whole, half) = (at(1.0), at(0.5));
        assert!((-50.0..0.0).contains(&whole) && (half / whole - 2.0).abs() < 1e-9, "{whole}, {half}");
    }
}
