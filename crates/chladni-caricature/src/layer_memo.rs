//! The memo of a layer in a stack, and the evaluation of a layer with it.

use std::sync::Arc;

use crate::keeping::{KeepRequest, Kept, SharedKeeper};
use crate::matching::own_target;
use crate::memo::{Memo, Same};
use crate::painted_spectrum::PaintedSpectrum;
use crate::softening::Softening;
use crate::{
    Base, CaricatureError, Difference, Field, Layer, LayerId, MatchRequest, Matched, Model, Painted,
    ScaleCurve, Signals, Smoothing, Target, Template,
};
use chladni_mesh::surface::vec3::Vec3;

pub(crate) type Mask = Option<Arc<[f32]>>;
/// A result from another thread, or why there is none; kept so that nothing is computed twice.
pub(crate) type Answer<T> = Result<Arc<T>, Arc<CaricatureError>>;
type FieldMemo = Memo<(Same<Difference>, ScaleCurve), Arc<Field>>;
/// The field, μ and χ it came from.
type DisplacementMemo = Memo<(Same<Field>, f64, Option<Same<[f32]>>), Arc<Vec<Vec3>>>;
/// The displacement that is capped, and the limit.
type CapMemo = Memo<(Same<Vec<Vec3>>, Same<Kept>), Arc<Vec<Vec3>>>;
/// A displacement, and how far it was limited, once that is known.
type Limited = (Arc<Vec<Vec3>>, Option<Arc<Kept>>);
type ResultMemo = Memo<(Same<Base>, Same<Vec<Vec3>>), Arc<Base>>;

/// The last results of one layer.
#[derive(Clone, Debug, Default)]
pub(crate) struct LayerMemo {
    painted: PaintedSpectrum,
    mask: Memo<(Painted, Smoothing), Mask>,
    /// The shape that it is made from, and how.
    own_target: Memo<(Same<Base>, Template), Arc<Target>>,
    /// The match and how far it is filled in.
    matched_target: Memo<(Same<Matched>, f64), Arc<Target>>,
    difference: Memo<(Same<Base>, Same<Target>), Arc<Difference>>,
    /// One per model, so that the three can be chosen between.
    fields: [FieldMemo; 3],
    displacement: DisplacementMemo,
    capped: CapMemo,
    result: ResultMemo,
    pub signals: Memo<Same<Difference>, Signals>,
}

/// The parts of a stack that a layer reads.
pub(crate) struct Scene<'a> {
    pub matches: &'a [(MatchRequest, Answer<Matched>)],
    /// The shape of the stack that its template is made from, where it is not a matched one.
    pub template: Option<&'a Arc<Base>>,
    pub places: &'a [Vec3],
    /// Whether the layer is to be seen in all three models.
    pub all_models: bool,
    /// Where layers are limited.
    pub keeper: Option<&'a Arc<SharedKeeper>>,
    /// How far the layer was limited last.
    pub kept: Option<&'a (KeepRequest, Answer<Kept>)>,
    /// The layer.
    pub id: LayerId,
}

/// A layer that acts.
pub(crate) struct Acting {
    pub outdated: bool,
    pub mask: Mask,
    pub difference: Arc<Difference>,
    pub unlimited: Arc<Vec<Vec3>>,
    pub displacement: Arc<Vec<Vec3>>,
    pub kept: Option<Arc<Kept>>,
    pub result: Arc<Base>,
}

impl LayerMemo {
    /// `None` while the template is not matched.
    pub fn evaluate(
        &mut self,
        scene: &Scene<'_>,
        softening: &mut Softening,
        layer: &Layer,
        base: &Arc<Base>,
    ) -> Result<Option<Acting>, CaricatureError> {
        let Some((target, outdated)) = self.target(scene, layer, base)? else { return Ok(None) };
        let inputs = (Same::from(base), Same::from(&target));
        let new = || Difference::new(base.clone(), target.clone()).map(Arc::new);
        let difference = self.difference.get(inputs, new)?;
        let region = &layer.region;
        let painted = &mut self.painted;
        let smooth = || region.smoothed(base.basis(), scene.places, painted, softening);
        let mask = self.mask.get((region.painted.clone(), region.smoothing), smooth)?;
        let field = if scene.all_models {
            let [coordinate, normal, distance] = self.all_fields(&difference, &layer.curve);
            match layer.model {
                Model::Coordinate => coordinate,
                Model::Normal => normal,
                Model::Distance => distance,
            }
        } else {
            self.field(&difference, layer.model, &layer.curve)
        };
        let mu = layer.effective_mu();
        let inputs = (Same::from(&field), mu, mask.as_ref().map(Same::from));
        let normals = || if layer.model == Model::Normal { base.normals() } else { &[] };
        let displace =
            || Ok::<_, CaricatureError>(Arc::new(field.displacement(normals(), mu, mask.as_deref())));
        let unlimited = self.displacement.get(inputs, displace)?;
        let (displacement, kept) = self.limited(scene, base, &mask, &unlimited)?;
        let inputs = (Same::from(base), Same::from(&displacement));
        let result =
            self.result.get(inputs, || Ok::<_, CaricatureError>(Arc::new(base.moved(&displacement))))?;
        Ok(Some(Acting { outdated, mask, difference, unlimited, displacement, kept, result }))
    }

    /// The limited displacement, or, until there is one, the displacement capped by the last limit.
    fn limited(
        &mut self,
        scene: &Scene<'_>,
        base: &Arc<Base>,
        mask: &Mask,
        unlimited: &Arc<Vec<Vec3>>,
    ) -> Result<Limited, CaricatureError> {
        let (Some(keeper), Some((request, kept))) = (scene.keeper, scene.kept) else {
            return Ok((unlimited.clone(), None));
        };
        let (base, mask, keeper) = (base.clone(), mask.clone(), keeper.clone());
        let wanted = KeepRequest { layer: scene.id, base, unlimited: unlimited.clone(), mask, keeper };
        match kept {
            Ok(kept) if request.is_same(&wanted) => Ok((kept.displacement.clone(), Some(kept.clone()))),
            Ok(kept) => {
                let cap = || Ok::<_, CaricatureError>(Arc::new(kept.cap(&request.unlimited, unlimited)));
                Ok((self.capped.get((Same::from(unlimited), Same::from(kept)), cap)?, None))
            }
            Err(why) if request.is_same(&wanted) => Err(CaricatureError::Unkept(why.clone())),
            Err(_) => Ok((unlimited.clone(), None)),
        }
    }

    /// The template's points, and whether they come from an older match than the one asked for.
    fn target(
        &mut self,
        scene: &Scene<'_>,
        layer: &Layer,
        base: &Arc<Base>,
    ) -> Result<Option<(Arc<Target>, bool)>, CaricatureError> {
        if let Some(request) = MatchRequest::of(layer) {
            let older = || {
                let newest_first = scene.matches.iter().rev();
                newest_first
                    .filter(|(known, _)| known.template.alike(&request.template))
                    .find_map(|(_, m)| m.as_ref().ok())
            };
            let (matched, outdated) = match scene.matches.iter().find(|(known, _)| *known == request) {
                None => (older(), true),
                Some((_, Ok(matched))) => (Some(matched), false),
                Some((_, Err(why))) => return Err(CaricatureError::Unmatched(why.clone())),
            };
            let Some(matched) = matched else { return Ok(None) };
            let inputs = (Same::from(matched), layer.infill);
            let make = || matched.target(base.basis(), layer.infill).map(Arc::new);
            return Ok(Some((self.matched_target.get(inputs, make)?, outdated)));
        }
        let missing =
            |why: &str| CaricatureError::Template { template: layer.template.to_string(), why: why.into() };
        let shape = scene.template.ok_or_else(|| missing("is not below this layer"))?;
        let inputs = (Same::from(shape), layer.template.clone());
        let make = || {
            let own = own_target(&layer.template, shape)?.map(Arc::new);
            own.ok_or_else(|| missing("needs a match"))
        };
        Ok(Some((self.own_target.get(inputs, make)?, false)))
    }

    fn field(&mut self, difference: &Arc<Difference>, model: Model, curve: &ScaleCurve) -> Arc<Field> {
        let slot = &mut self.fields[model as usize];
        let compute = || Ok::<_, std::convert::Infallible>(Arc::new(difference.field(model, curve)));
        let Ok(field) = slot.get((Same::from(difference), curve.clone()), compute);
        field
    }

    /// The fields of all three models, in the order of [`Model::ALL`]: those that are not known yet are computed together.
    pub fn all_fields(&mut self, difference: &Arc<Difference>, curve: &ScaleCurve) -> [Arc<Field>; 3] {
        let mut together = None;
        Model::ALL.map(|model| {
            let compute = || {
                let together = together.get_or_insert_with(|| difference.fields(curve).map(Arc::new));
                Ok::<_, std::convert::Infallible>(together[model as usize].clone())
            };
            let slot = &mut self.fields[model as usize];
            let Ok(field) = slot.get((Same::from(difference), curve.clone()), compute);
            field
        })
    }
}
