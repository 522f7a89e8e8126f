//! From a difference to a displacement: model, scale curve, region and μ put together.

use std::sync::Arc;

use chladni_synth::{Coefficients, Residual, Term};
use rayon::prelude::*;

use crate::{Difference, Model, ScaleCurve};
use chladni_mesh::surface::vec3::{Vec3, scaled};

/// Σ_k H_k(v) Φ_k X̃_k + Φ_d dX(v): the filtered difference, before χ and μ.
#[derive(Clone, Debug)]
pub enum Field {
    /// A displacement per vertex, N.
    Vector(Vec<Vec3>),
    /// An amplitude along the base's normal, N.
    Normal(Vec<f64>),
}

/// How much of the whole signal X a field holds, and what its harmonics add:
/// X filtered = whole·X + Σ_k H_k c_k.
///
/// With dX = X − Σ_k H_k X̃_k the paper's Σ_k H_k Φ_k X̃_k + Φ_d dX is Φ_d X + Σ_k H_k (Φ_k − Φ_d) X̃_k. In
/// this form no residual is ever formed, a constant curve reads no harmonic at all, and μ = 1 gives the
/// template to within rounding whatever the precision of H.
struct Split<const C: usize> {
    whole: f64,
    coefficients: Vec<[f64; C]>,
}

fn split_vector(difference: &Difference, model: Model, curve: &ScaleCurve) -> Split<3> {
    let gains = curve.gains(difference.base.basis());
    let d = curve.residual;
    if model == Model::Distance {
        let filter = difference.psi();
        let whole = d * filter.residual;
        let x = difference.base.spectrum().iter().zip(&filter.psi).zip(&gains);
        let coefficients = x.map(|((x, psi), phi)| scaled(*x, phi * psi - whole)).collect();
        return Split { whole, coefficients };
    }
    if curve.is_flat() {
        return Split { whole: d, coefficients: Vec::new() };
    }
    let spectrum = difference.delta_spectrum().iter().zip(&gains);
    Split { whole: d, coefficients: spectrum.map(|(c, phi)| scaled(*c, phi - d)).collect() }
}

fn split_normal(difference: &Difference, curve: &ScaleCurve) -> Split<1> {
    let d = curve.residual;
    if curve.is_flat() {
        return Split { whole: d, coefficients: Vec::new() };
    }
    let gains = curve.gains(difference.base.basis());
    let spectrum = difference.xi_spectrum().iter().zip(&gains);
    Split { whole: d, coefficients: spectrum.map(|(c, phi)| [c * (phi - d)]).collect() }
}

impl Difference {
    /// The signal X that `model` filters in vector form.
    fn signal(&self, model: Model) -> &[Vec3] {
        if model == Model::Distance { &self.base.positions } else { &self.delta }
    }

    /// The filtered difference of `model` under `curve`, in f64: one pass over H, or none where
    /// the curve is flat (coordinate and normal model).
    pub fn field(&self, model: Model, curve: &ScaleCurve) -> Field {
        let basis = self.base.basis();
        if model == Model::Normal {
            let split = split_normal(self, curve);
            let mut out: Vec<f64> = self.xi().iter().map(|xi| split.whole * xi).collect();
            if !split.coefficients.is_empty() {
                basis.synthesize_each(&split.coefficients, &mut out, |_, [sum], f| *f += sum);
            }
            return Field::Normal(out);
        }
        let split = split_vector(self, model, curve);
        let mut out: Vec<Vec3> = self.signal(model).iter().map(|x| scaled(*x, split.whole)).collect();
        if !split.coefficients.is_empty() {
            basis.synthesize_each(&split.coefficients, &mut out, |_, sum, f| {
                (0..3).for_each(|c| f[c] += sum[c]);
            });
        }
        Field::Vector(out)
    }

    /// The fields of all three models, in the order of [`Model::ALL`], in one pass over H.
    pub fn fields(&self, curve: &ScaleCurve) -> [Field; 3] {
        if curve.is_flat() {
            // Two of the three read no harmonic at all.
            return Model::ALL.map(|model| self.field(model, curve));
        }
        self.prepare();
        let [along, by] = [Model::Coordinate, Model::Distance].map(|model| split_vector(self, model, curve));
        let normal = split_normal(self, curve);
        let together = along.coefficients.iter().zip(&normal.coefficients).zip(&by.coefficients);
        let together: Vec<[f64; 7]> =
            together.map(|(([a, b, c], [n]), [d, e, f])| [*a, *b, *c, *n, *d, *e, *f]).collect();
        let signals = self.delta.par_iter().zip(self.xi()).zip(&self.base.positions);
        let whole = |((delta, xi), x): ((&Vec3, &f64), &Vec3)| {
            let ([a, b, c], [d, e, f]) = (scaled(*delta, along.whole), scaled(*x, by.whole));
            [a, b, c, normal.whole * xi, d, e, f]
        };
        let mut out: Vec<[f64; 7]> = signals.map(whole).collect();
        self.base.basis().synthesize_each(&together, &mut out, |_, sum, f| {
            (0..7).for_each(|c| f[c] += sum[c]);
        });
        [
            Field::Vector(out.par_iter().map(|f| [f[0], f[1], f[2]]).collect()),
            Field::Normal(out.par_iter().map(|f| f[3]).collect()),
            Field::Vector(out.par_iter().map(|f| [f[4], f[5], f[6]]).collect()),
        ]
    }

    /// The same exaggeration as a term of the one formula, for a synthesizer whose rest shape is
    /// this difference's base. `signals` are shared with the terms and made once per difference.
    pub fn term(
        &self,
        signals: &Signals,
        model: Model,
        curve: &ScaleCurve,
        mu: f64,
        mask: Option<Arc<[f32]>>,
    ) -> Term {
        let (coefficients, residual, whole) = if model == Model::Normal {
            let split = split_normal(self, curve);
            let c = split.coefficients.iter().map(|[c]| (c * mu) as f32).collect();
            (Coefficients::Normal(c), Residual::Normal(signals.xi.clone()), split.whole)
        } else {
            let split = split_vector(self, model, curve);
            let c = split.coefficients.iter().map(|c| c.map(|c| (c * mu) as f32)).collect();
            let signal = if model == Model::Distance { &signals.shape } else { &signals.delta };
            (Coefficients::Vector(c), Residual::Vector(signal.clone()), split.whole)
        };
        Term { coefficients, residual: Some(residual), residual_gain: (mu * whole) as f32, mask }
    }
}

/// The signals of a difference as a synthesizer takes them.
#[derive(Clone, Debug)]
pub struct Signals {
    /// x(v), N×3.
    pub shape: Arc<[[f32; 3]]>,
    /// x^δ(v), N×3.
    pub delta: Arc<[[f32; 3]]>,
    /// ξ(v), N.
    pub xi: Arc<[f32]>,
}

impl Signals {
    /// Single-precision copies of the signals of `difference`.
    pub fn of(difference: &Difference) -> Self {
        Self {
            shape: single(&difference.base.positions),
            delta: single(&difference.delta),
            xi: difference.xi().iter().map(|x| *x as f32).collect(),
        }
    }
}

/// `signal` in single precision, to be shared with a synthesizer.
pub(crate) fn single(signal: &[Vec3]) -> Arc<[[f32; 3]]> {
    signal.iter().map(|p| p.map(|c| c as f32)).collect()
}

impl Field {
    /// μ χ(v) times the field, N displacements; `normals` are those of the base. χ is 1
    /// everywhere where `mask` is `None`.
    pub fn displacement(&self, normals: &[Vec3], mu: f64, mask: Option<&[f32]>) -> Vec<Vec3> {
        let gain = |v: usize| mu * mask.map_or(1.0, |m| f64::from(m[v]));
        match self {
            Self::Vector(field) => field.par_iter().enumerate().map(|(v, f)| scaled(*f, gain(v))).collect(),
            Self::Normal(field) => {
                let pairs = field.par_iter().zip(normals).enumerate();
                pairs.map(|(v, (f, n))| scaled(*n, f * gain(v))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::base_and_target;
    use chladni_mesh::surface::vec3::{add, distance, length};

    /// The formulas as the paper prints them, with residuals formed one by one.
    fn by_the_paper(d: &Difference, model: Model, curve: &ScaleCurve) -> Vec<Vec3> {
        let basis = d.base.basis();
        let phi = curve.gains(basis);
        let vector = |c: Vec<Vec3>, r: Vec<Vec3>, gain: f64| -> Vec<Vec3> {
            basis.synthesize3(&c).iter().zip(r).map(|(f, r)| add(*f, scaled(r, gain))).collect()
        };
        match model {
            Model::Coordinate => {
                let c = d.delta_spectrum().iter().zip(&phi).map(|(c, p)| scaled(*c, *p)).collect();
                vector(c, d.delta_residual(), curve.residual)
            }
            Model::Distance => {
                let psi = d.psi();
                let c = d.base.spectrum().iter().zip(&phi).zip(&psi.psi);
                let c = c.map(|((x, p), s)| scaled(*x, p * s)).collect();
                vector(c, d.shape_residual(), curve.residual * psi.residual)
            }
            Model::Normal => {
                let c: Vec<f64> = d.xi_spectrum().iter().zip(&phi).map(|(c, p)| c * p).collect();
                let low = basis.synthesize(&c);
                let dxi = d.xi_residual();
                let along = low.iter().zip(dxi).zip(d.base.normals());
                along.map(|((f, r), n)| scaled(*n, f + curve.residual * r)).collect()
            }
        }
    }

    fn curves() -> [ScaleCurve; 4] {
        let drawn = ScaleCurve { points: vec![[0.0, 0.5], [0.6, 2.0], [1.0, 0.1]], residual: 0.7 };
        [ScaleCurve::flat(1.0), ScaleCurve::broad(), ScaleCurve::fine(), drawn]
    }

    #[test]
    fn the_field_is_what_the_paper_sums() {
        let (_, _, base, target) = base_and_target();
        let d = Difference::new(base.clone(), target).unwrap();
        for model in Model::ALL {
            for curve in curves() {
                let ours = d.field(model, &curve).displacement(base.normals(), -1.3, None);
                for (a, b) in ours.iter().zip(by_the_paper(&d, model, &curve)) {
                    assert!(distance(*a, scaled(b, -1.3)) < 1e-12, "{model}");
                }
            }
        }
    }

    #[test]
    fn the_three_fields_together_are_those_one_by_one() {
        let (_, _, base, target) = base_and_target();
        for curve in curves() {
            let d = Difference::new(base.clone(), target.clone()).unwrap();
            for (model, together) in Model::ALL.into_iter().zip(d.fields(&curve)) {
                let alone = d.field(model, &curve).displacement(base.normals(), -1.3, None);
                let together = together.displacement(base.normals(), -1.3, None);
                assert!(alone.iter().zip(together).all(|(a, b)| distance(*a, b) < 1e-12), "{model}");
            }
        }
    }

    #[test]
    fn a_term_gives_the_displacement_of_the_field() {
        let (_, _, base, target) = base_and_target();
        let d = Difference::new(base.clone(), target).unwrap();
        let signals = Signals::of(&d);
        let mask: Arc<[f32]> = (0..base.positions.len()).map(|v| (v % 7) as f32 / 6.0).collect();
        for model in Model::ALL {
            for curve in curves() {
                let ours = d.field(model, &curve).displacement(base.normals(), -1.3, Some(&mask));
                let term = d.term(&signals, model, &curve, -1.3, Some(mask.clone()));
                let gain = f64::from(term.residual_gain);
                for v in 0..base.positions.len() {
                    let f: Vec3 = match (&term.coefficients, term.residual.as_ref().unwrap()) {
                        (Coefficients::Vector(c), Residual::Vector(r)) => std::array::from_fn(|i| {
                            let low = c
                                .iter()
                                .enumerate()
                                .map(|(k, c)| d.base.basis().harmonic(k)[v] * f64::from(c[i]));
                            low.sum::<f64>() + gain * f64::from(r[v][i])
                        }),
                        (Coefficients::Normal(c), Residual::Normal(r)) => {
                            let low = c
                                .iter()
                                .enumerate()
                                .map(|(k, c)| d.base.basis().harmonic(k)[v] * f64::from(*c));
                            scaled(base.normals()[v], low.sum::<f64>() + gain * f64::from(r[v]))
                        }
                        _ => panic!("a term mixes forms"),
                    };
                    assert!(distance(scaled(f, f64::from(mask[v])), ours[v]) < 2e-6, "{model}");
                }
            }
        }
    }

    #[test]
    fn mu_one_is_the_template_and_mu_zero_the_file_bit_for_bit() {
        let (body, _, base, target) = base_and_target();
        let d = Difference::new(base.clone(), target.clone()).unwrap();
        let field = d.field(Model::Coordinate, &ScaleCurve::flat(1.0));
        let one = field.displacement(base.normals(), 1.0, None);
        for ((x, d), r) in base.positions.iter().zip(&one).zip(&target.points) {
            assert!(distance(add(*x, *d), *r) <= 4.0 * f64::EPSILON);
        }
        let file: Vec<Vec3> = body.positions.iter().map(|p| body.frame.to_file(*p)).collect();
        for model in Model::ALL {
            let zero = d.field(model, &ScaleCurve::mid()).displacement(base.normals(), 0.0, None);
            let back = body.displaced_file_positions(&file, &zero);
            let bits = |p: &[Vec3]| p.iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&back), bits(&file));
        }
    }

    #[test]
    fn parseval_holds_for_the_difference() {
        let (body, _, base, target) = base_and_target();
        let d = Difference::new(base, target).unwrap();
        let energy =
            |f: &[Vec3]| f.iter().zip(&body.basis.mass).map(|(f, a)| a * length(*f).powi(2)).sum::<f64>();
        let along = |n: &[f64]| -> Vec<Vec3> { n.iter().map(|n| [*n, 0.0, 0.0]).collect() };
        let by = |psi: f64| -> Vec<Vec3> { d.shape_residual().iter().map(|x| scaled(*x, psi)).collect() };
        let filtered: Vec<Vec3> =
            d.base.spectrum().iter().zip(&d.psi().psi).map(|(x, p)| scaled(*x, *p)).collect();
        let filtered = energy(&body.basis.synthesize3(&filtered)) + energy(&by(d.psi().residual));
        let models = [
            (Model::Coordinate, energy(&d.delta), d.delta_residual()),
            (Model::Normal, energy(&along(d.xi())), along(&d.xi_residual())),
            (Model::Distance, filtered, by(d.psi().residual)),
        ];
        for (model, whole, residual) in models {
            let bars = d.amplitudes(model);
            let harmonics: f64 = bars.harmonics.iter().map(|a| a * a).sum();
            assert!((bars.residual.powi(2) - energy(&residual)).abs() < 1e-12 * whole, "{model}");
            assert!((harmonics + bars.residual.powi(2) - whole).abs() < 1e-12 * whole, "{model}");
            assert!(harmonics > 0.5 * whole, "most of a smooth difference lies below K");
        }
    }

    #[test]
    fn psi_is_the_minimum_of_its_functional() {
        let (body, _, base, target) = base_and_target();
        let d = Difference::new(base, target).unwrap();
        let dx = d.shape_residual();
        let best = d.psi().clone();
        // ½ Σ a ‖φx − x^δ‖², from its definition.
        let functional = |psi: &[f64], psi_d: f64| -> f64 {
            let c: Vec<Vec3> = d.base.spectrum().iter().zip(psi).map(|(x, p)| scaled(*x, *p)).collect();
            let filtered = body.basis.synthesize3(&c);
            let terms = (0..dx.len()).map(|v| {
                let f = add(filtered[v], scaled(dx[v], psi_d));
                body.basis.mass[v] * distance(f, d.delta[v]).powi(2)
            });
            0.5 * terms.sum::<f64>()
        };
        let least = functional(&best.psi, best.residual);
        for step in [1e-2, -1e-2] {
            assert!(functional(&best.psi, best.residual + step) > least);
            for k in 1..best.psi.len() {
                let mut psi = best.psi.clone();
                psi[k] += step;
                assert!(functional(&psi, best.residual) > least, "k = {k}");
            }
        }
    }

    #[test]
    fn psi_does_not_divide_noise_by_noise() {
        let (points, triangles) = crate::fixture::icosphere(3);
        let (body, ..) = base_and_target();
        let surface = crate::Surface::of(points.clone(), triangles, body.frame);
        // A round sphere has amplitude in its three harmonics of degree 1 only.
        let mass = vec![1.0 / points.len() as f64; points.len()];
        let basis = crate::fixture::polynomials(&points, mass);
        assert_eq!(basis.harmonics(), body.basis.harmonics());
        let basis = Arc::new(basis);
        let base = Arc::new(crate::Base::new(basis.clone(), Arc::new(surface), points.clone()).unwrap());
        let lump = points.iter().map(|p| scaled(*p, 1.0 + 0.3 * p[0] * p[1] * p[2])).collect();
        let target = Arc::new(crate::Target::new(basis, lump).unwrap());
        let psi = Difference::new(base, target).unwrap().psi().clone();
        for (k, p) in psi.psi.iter().enumerate() {
            assert!(if (1..4).contains(&k) { p.is_finite() } else { *p == 0.0 }, "ψ_{k} = {p}");
        }
        assert_eq!(psi.residual, 0.0);
    }

    #[test]
    fn the_self_templates_know_their_transform() {
        let (body, _, base, _) = base_and_target();
        let plain = |points: &[Vec3]| body.basis.transform3(points);
        let low_passed = crate::Target::low_passed(base.clone(), 20).unwrap();
        for target in [crate::Target::scaled(base.clone(), 0.9), low_passed] {
            for (a, b) in target.spectrum().iter().zip(plain(&target.points)) {
                assert!(distance(*a, b) < 1e-12);
            }
        }
    }
}
