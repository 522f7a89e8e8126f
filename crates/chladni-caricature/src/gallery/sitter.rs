//! The sitter of a gallery: a shape with its parts and templates, on which variants become layers.

use std::sync::Arc;

use chladni_breeding::{Describe, Descriptor};
use chladni_harmonics::Body;
use chladni_match::MatchSettings;
use chladni_mesh::surface::spread;
use chladni_mesh::surface::vec3::{Vec3, add, distance, length, scaled, sub};
use chladni_synth::{Coefficients, CpuSynthesizer, Item, Residual, SynthModel, Synthesizer, Term};
use rayon::prelude::*;

use super::variant::{Group, Variant};
use super::weights::Weights;
use crate::exaggeration::single;
use crate::{
    Base, CaricatureError, Difference, Layer, Painted, Region, RollOff, ScaleCurve, Signals, Smoothing,
    Stack, Surface, Template, flipped_triangles, furthest, size,
};

/// A part that variants enlarge and diminish.
#[derive(Clone, Debug)]
pub struct SitterPart {
    /// The user's name for it.
    pub name: String,
    /// χ01, N values.
    pub painted: Arc<[f32]>,
}

/// The largest share of triangles that a variant may fold, and the share aimed at.
pub const MOST_FOLDS: f64 = 0.005;
const AIM: f64 = 0.0015;
/// Vertices at which variants are compared.
const PROBES: usize = 160;
/// How soft the edges of parts are.
const SOFT: Smoothing = Smoothing { wavelength: 0.22, roll_off: RollOff::Heat, clamp: true };
/// How far the strongest place of the main layer moves, in shares of the size: at strength 0 and at 1.
const REACH: [f64; 2] = [0.05, 0.2];
/// How much larger a part becomes at most, and how much smaller.
const GROW: f64 = 0.55;
const SHRINK: f64 = 0.45;
/// The factor of the template that magnifies.
const MAGNIFIED: f64 = 0.5;

/// A shape ready for variants.
pub struct Sitter {
    body: Arc<Body>,
    surface: Arc<Surface>,
    original: Arc<Base>,
    /// The original in single precision.
    places: Arc<[[f32; 3]]>,
    templates: Vec<Against>,
    parts: Vec<SitterPart>,
    /// χ of each part, N values.
    smooth: Vec<Arc<[f32]>>,
    probes: Probes,
    model: SynthModel,
}

/// A template that the shape was matched with.
struct Against {
    template: Template,
    matching: MatchSettings,
    difference: Arc<Difference>,
    signals: Signals,
}

/// Vertices that are far from each other, and H there: K rows.
struct Probes {
    vertices: Vec<usize>,
    harmonics: Vec<f64>,
}

/// A variant on its sitter.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// The layers that it becomes in a project, lowest first.
    pub layers: Vec<Layer>,
    /// The vertices of the result, N, working frame, to the precision of pictures.
    pub positions: Vec<[f32; 3]>,
    /// How many triangles are folded.
    pub folded: usize,
    /// The mean distance that a vertex moves, as a share of the shape's size.
    pub moved: f64,
    /// How much of the strength that was asked for is left, in (0, 1]: the rest would have folded.
    pub kept: f64,
}

/// The numbers that a variant's layers have here.
#[derive(Clone, Copy, Debug)]
struct Dose {
    mu: f64,
    grow: f64,
    shrink: f64,
}

impl std::fmt::Debug for Sitter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let templates: Vec<String> = self.templates.iter().map(|t| t.template.to_string()).collect();
        f.debug_struct("Sitter").field("templates", &templates).field("parts", &self.parts.len()).finish()
    }
}

impl Sitter {
    /// The shape of `stack`, compared with `templates`, which it has matched, and made of `parts`.
    ///
    /// # Errors
    /// No template, one that is not matched, a part of another number of vertices, a surface on which no heat flows.
    pub fn new(
        stack: &Stack,
        templates: &[(Template, MatchSettings)],
        parts: Vec<SitterPart>,
    ) -> Result<Self, CaricatureError> {
        let body = stack.body().clone();
        let against = templates.iter().map(|(template, matching)| {
            let difference = stack.difference(template, matching)?;
            difference.prepare();
            let signals = Signals::of(&difference);
            let (template, matching) = (template.clone(), matching.clone());
            Ok(Against { template, matching, difference, signals })
        });
        let templates: Vec<Against> = against.collect::<Result<_, CaricatureError>>()?;
        if templates.is_empty() {
            return Err(CaricatureError::Template { template: "none".into(), why: "one is needed".into() });
        }
        let smooth = parts.iter().map(|part| SOFT.apply(&body, &part.painted));
        let smooth = smooth.collect::<Result<_, CaricatureError>>()?;
        let original = stack.original().clone();
        let model = SynthModel::new(&body).map_err(|error| CaricatureError::Gallery(error.to_string()))?;
        Ok(Self {
            surface: stack.surface().clone(),
            places: single(&original.positions),
            probes: Probes::on(&body, PROBES),
            body,
            original,
            templates,
            parts,
            smooth,
            model,
        })
    }

    /// The number of templates.
    pub fn templates(&self) -> usize {
        self.templates.len()
    }

    /// Whether it is compared with `template`, matched so.
    pub fn compares_with(&self, template: &Template, matching: &MatchSettings) -> bool {
        self.templates.iter().any(|against| against.template == *template && against.matching == *matching)
    }

    /// Whether variants of `other` mean the same here: both have the same parts by name, and the same templates.
    pub fn understands(&self, other: &Self) -> bool {
        let templates = |sitter: &'_ Self| -> Vec<(Template, MatchSettings)> {
            sitter.templates.iter().map(|t| (t.template.clone(), t.matching.clone())).collect()
        };
        let names = self.parts.iter().map(|part| &part.name);
        names.eq(other.parts.iter().map(|part| &part.name)) && templates(self) == templates(other)
    }

    /// The parts.
    pub fn parts(&self) -> &[SitterPart] {
        &self.parts
    }

    /// The shape as a synthesizer deforms it.
    pub fn model(&self) -> &SynthModel {
        &self.model
    }

    /// N vertices and the triangles between them.
    pub fn body(&self) -> &Arc<Body> {
        &self.body
    }

    /// [All](Self::portray) where there is one.
    ///
    /// # Errors
    /// Errors of the synthesizer.
    pub fn portray_one(&self, variant: &Variant) -> Result<Portrait, CaricatureError> {
        let portrait = self.portray(&[variant])?.pop();
        portrait.ok_or_else(|| CaricatureError::Gallery("there are no variants".into()))
    }

    /// All of `variants`, each with as much of its strength as folds hardly any triangle. The synthesizer evaluates
    /// them together, a few times.
    ///
    /// # Errors
    /// Errors of the synthesizer.
    pub fn portray(&self, variants: &[&Variant]) -> Result<Vec<Portrait>, CaricatureError> {
        const ROUNDS: usize = 4;
        let mut doses: Vec<Dose> = variants.par_iter().map(|variant| self.dose(variant)).collect();
        let mut kept = vec![1.0; variants.len()];
        let mut synthesizer = CpuSynthesizer::new(self.model.clone());
        let mut folded = vec![usize::MAX; variants.len()];
        let most = (MOST_FOLDS * self.surface.whole_triangles() as f64) as usize;
        for round in 0..ROUNDS {
            let items: Vec<Item> =
                variants.iter().zip(&doses).map(|(variant, dose)| self.item(variant, dose)).collect();
            synthesizer
                .synthesize_positions(&items)
                .map_err(|error| CaricatureError::Gallery(error.to_string()))?;
            let limits: Vec<(usize, f64)> =
                (0..items.len()).into_par_iter().map(|i| self.limit(synthesizer.positions(i))).collect();
            for (i, (folds, most_kept)) in limits.into_iter().enumerate() {
                folded[i] = folds;
                if folds > most && round + 1 < ROUNDS {
                    let share = 0.95 * most_kept.min(1.0);
                    kept[i] *= share;
                    doses[i] = doses[i].times(share);
                }
            }
            if folded.iter().all(|folds| *folds <= most) {
                break;
            }
        }
        let all = variants.iter().zip(&doses).zip(kept).zip(folded).enumerate();
        Ok(all
            .map(|(i, (((variant, dose), kept), folded))| Portrait {
                layers: self.layers(variant, dose),
                positions: synthesizer.positions(i).to_vec(),
                moved: self.moved(synthesizer.positions(i)),
                folded,
                kept,
            })
            .collect())
    }

    fn moved(&self, positions: &[[f32; 3]]) -> f64 {
        // In one order: galleries of one seed are the same on any number of threads.
        let all = positions.iter().zip(&self.original.positions);
        let sum: f64 = all.map(|(a, b)| distance(a.map(f64::from), *b)).sum();
        sum / (positions.len().max(1) as f64 * size(&self.body.basis))
    }

    /// How many triangles are folded, and which share of the movement would fold hardly any.
    fn limit(&self, positions: &[[f32; 3]]) -> (usize, f64) {
        let rest = &self.original.positions;
        let moved: Vec<Vec3> = positions.iter().map(|p| p.map(f64::from)).collect();
        let folded = flipped_triangles(&self.surface, rest, &moved).len();
        let by: Vec<Vec3> = moved.iter().zip(rest).map(|(a, b)| sub(*a, *b)).collect();
        let allowed = (AIM * self.surface.whole_triangles() as f64) as usize;
        (folded, furthest(&self.surface, rest, &by, 1.0, allowed).unwrap_or(1.0))
    }

    /// μ such that the strongest place moves as far as the variant's strength says, and how much parts change.
    fn dose(&self, variant: &Variant) -> Dose {
        let strength = |i: usize| f64::from(variant.genes(Group::Strength).get(i).copied().unwrap_or(0.5));
        let share = f64::from(variant.magnification());
        let reach =
            size(&self.body.basis) * (REACH[0] + (REACH[1] - REACH[0]) * strength(0)) * (1.0 - 0.5 * share);
        let unit = Dose { mu: 1.0, grow: 0.0, shrink: 0.0 };
        let farthest = self.at_probes(variant, &unit).into_iter().map(length).fold(0.0, f64::max);
        let mu = if farthest > 1e-9 { (-reach / farthest).max(-12.0) } else { 0.0 };
        let stir = strength(1) * (0.3 + 0.7 * share);
        Dose { mu, grow: GROW * stir, shrink: SHRINK * stir }
    }

    /// The template of `variant`.
    pub(super) fn template_of(&self, variant: &Variant) -> &Template {
        &self.against(variant).template
    }

    fn against(&self, variant: &Variant) -> &Against {
        &self.templates[variant.template(self.templates.len())]
    }

    /// x' = (x + μ χ F)(1 + g χ₊)(1 − h χ₋) about the center: the main layer and two that magnify, in terms on the shape
    /// itself.
    fn item(&self, variant: &Variant, dose: &Dose) -> Item {
        let n = self.original.positions.len();
        let weights = Weights::of(variant, self.parts.len());
        let [main, more, less] = [&weights.main, &weights.more, &weights.less]
            .map(|weights| Weights::sum(weights, &self.smooth, n));
        let gain = |v: usize| (1.0 + dose.grow as f32 * more[v]) * (1.0 - dose.shrink as f32 * less[v]);
        let mask: Arc<[f32]> = (0..n).map(|v| main[v] * gain(v)).collect();
        let Against { difference, signals, .. } = self.against(variant);
        let term = difference.term(signals, variant.model(), &variant.curve(), dose.mu, Some(mask));
        let magnified = Term {
            coefficients: Coefficients::Vector(Vec::new()),
            residual: Some(Residual::Vector(self.places.clone())),
            residual_gain: 1.0,
            mask: Some((0..n).map(|v| gain(v) - 1.0).collect()),
        };
        Item { terms: vec![term, magnified] }
    }

    /// The displacement of the same at the probes.
    fn at_probes(&self, variant: &Variant, dose: &Dose) -> Vec<Vec3> {
        let weights = Weights::of(variant, self.parts.len());
        let Against { difference, signals, .. } = self.against(variant);
        let term = difference.term(signals, variant.model(), &variant.curve(), dose.mu, None);
        let count = self.probes.vertices.len();
        let place = |(i, &v): (usize, &usize)| {
            let column = |k: usize| self.probes.harmonics[k * count + i];
            let x = self.original.positions[v];
            let field = match &term.coefficients {
                Coefficients::Vector(c) => c
                    .iter()
                    .enumerate()
                    .fold([0.0; 3], |sum, (k, c)| add(sum, scaled(c.map(f64::from), column(k)))),
                Coefficients::Normal(c) => {
                    let sum: f64 = c.iter().enumerate().map(|(k, c)| f64::from(*c) * column(k)).sum();
                    scaled(self.original.normals()[v], sum)
                }
            };
            let residual = f64::from(term.residual_gain);
            let field = match &term.residual {
                Some(Residual::Vector(r)) => add(field, scaled(r[v].map(f64::from), residual)),
                Some(Residual::Normal(r)) => {
                    add(field, scaled(self.original.normals()[v], f64::from(r[v]) * residual))
                }
                None => field,
            };
            let at = |weights: &(f32, Vec<f32>)| f64::from(Weights::at(weights, &self.smooth, v));
            let gain = (1.0 + dose.grow * at(&weights.more)) * (1.0 - dose.shrink * at(&weights.less));
            add(scaled(field, at(&weights.main) * gain), scaled(x, gain - 1.0))
        };
        self.probes.vertices.iter().enumerate().map(place).collect()
    }

    /// The same as ordinary layers.
    fn layers(&self, variant: &Variant, dose: &Dose) -> Vec<Layer> {
        let weights = Weights::of(variant, self.parts.len());
        let n = self.original.positions.len();
        let painted: Vec<Arc<[f32]>> = self.parts.iter().map(|part| part.painted.clone()).collect();
        let region = |weights: &(f32, Vec<f32>)| match self.parts.is_empty() {
            true => Region { painted: Painted::Everywhere, smoothing: SOFT },
            false => {
                let values = Weights::sum(weights, &painted, n);
                let values = values.into_iter().map(|x| x.clamp(0.0, 1.0)).collect();
                Region { painted: Painted::Vertices(values), smoothing: SOFT }
            }
        };
        let Against { template, matching, .. } = self.against(variant);
        let main = Layer {
            matching: matching.clone(),
            model: variant.model(),
            mu: dose.mu,
            curve: variant.curve(),
            region: region(&weights.main),
            ..Layer::new("caricature", template.clone())
        };
        let magnify = |name: &str, by: f64, weights: &(f32, Vec<f32>)| {
            let stirred = by != 0.0 && weights.1.iter().any(|w| *w > 0.0);
            stirred.then(|| Layer {
                // x + μ (s − 1) x is x (1 + by).
                mu: by / (MAGNIFIED - 1.0),
                curve: ScaleCurve::flat(1.0),
                region: region(weights),
                ..Layer::new(name, Template::Scaled(MAGNIFIED))
            })
        };
        let more = magnify("larger", dose.grow, &weights.more);
        let less = magnify("smaller", -dose.shrink, &weights.less);
        [Some(main), more, less].into_iter().flatten().collect()
    }
}

impl Describe<Variant> for Sitter {
    type Error = CaricatureError;

    fn describe(&self, variant: &Variant) -> Result<Descriptor, CaricatureError> {
        let moved = self.at_probes(variant, &self.dose(variant));
        Ok(Descriptor::of(moved.as_flattened().iter().map(|x| *x as f32).collect()))
    }
}

impl Probes {
    /// Each is the vertex that is farthest from those before it.
    fn on(body: &Body, count: usize) -> Self {
        let from_middle = |a: &u32| length(body.positions[*a as usize]);
        let outermost =
            (0..body.positions.len() as u32).max_by(|a, b| from_middle(a).total_cmp(&from_middle(b)));
        let mut vertices: Vec<u32> = outermost.into_iter().collect();
        spread(&body.positions, &mut vertices, count.min(body.positions.len()));
        let vertices: Vec<usize> = vertices.into_iter().map(|v| v as usize).collect();
        let at = |k: usize| vertices.iter().map(move |v| body.basis.harmonic(k)[*v]);
        let harmonics = (0..body.basis.harmonics()).flat_map(|k| at(k).collect::<Vec<_>>()).collect();
        Self { vertices, harmonics }
    }
}

impl Dose {
    fn times(self, share: f64) -> Self {
        Self { mu: self.mu * share, grow: self.grow * share, shrink: self.shrink * share }
    }
}
