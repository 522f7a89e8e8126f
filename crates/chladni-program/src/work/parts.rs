//! The parts of a shape that a click takes, in the window and on the page: those of a head, which have names, or whatever
//! stands out.

use std::sync::Arc;

use chladni_caricature::{HEAD_PARTS, Limbs, Painted};
use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::{MirrorPlane, MirrorSearch, ShapeSource, TriMesh, samples};

use super::{Error, Watcher, body};

/// Where each vertex belongs.
#[derive(Default)]
pub struct Parts {
    /// For each operator vertex its part.
    pub part: Vec<u32>,
    /// The names of all parts, by their numbers.
    pub names: Vec<String>,
    /// For each part that on the other side, where it is one of a pair.
    twins: Vec<Option<usize>>,
    /// The level at which they were found; none of the parts of a head.
    pub level: Option<f64>,
}

impl Parts {
    /// Those of a sample head; none of other shapes, whose parts have to be found.
    pub fn known(name: &str, mesh: &TriMesh, body: &Body) -> Self {
        match ShapeSource::named(name) {
            ShapeSource::Sample(sample) => samples::head_parts(&sample, &mesh.positions)
                .map_or_else(Self::default, |part| Self::of_head(&part, body)),
            ShapeSource::File(_) => Self::default(),
        }
    }

    /// Those of a head, from the part of each vertex of its file.
    pub fn of_head(part: &[u8], body: &Body) -> Self {
        let part = body.on_operator_vertices(part.iter().map(|part| u32::from(*part)), 0);
        let names: Vec<String> = HEAD_PARTS.iter().map(ToString::to_string).collect();
        Self { part, twins: vec![None; names.len()], names, level: None }
    }

    /// The limbs at `level`.
    pub fn at_level(body: &Body, level: f64, mirror: Option<MirrorPlane>) -> Self {
        let limbs = Limbs::of(body, level);
        let twins = twins_in(&limbs, mirror);
        let named = |(i, limb): (usize, &chladni_caricature::Limb)| {
            let kind = if limb.is_trunk() { "trunk" } else { "part" };
            // The number that `parts --level` prints and --limb takes, where the body has as many harmonics.
            format!("{kind} {i}, {:.0} %", 100.0 * limb.share)
        };
        Self {
            names: limbs.parts.iter().enumerate().map(named).collect(),
            part: limbs.part,
            twins,
            level: Some(level),
        }
    }

    /// The part of a vertex, and that on the other side.
    pub fn around(&self, vertex: u32) -> Vec<usize> {
        let part = self.part.get(vertex as usize).map(|part| *part as usize);
        part.map_or_else(Vec::new, |part| self.with_twin(part))
    }

    /// A part, and that on the other side.
    pub fn with_twin(&self, part: usize) -> Vec<usize> {
        std::iter::once(part).chain(self.twins.get(part).copied().flatten()).collect()
    }

    /// The values to show for them: 1 on the `pointed` ones.
    pub fn shown(&self, pointed: &[usize]) -> Vec<f32> {
        self.part.iter().map(|part| f32::from(u8::from(pointed.contains(&(*part as usize))))).collect()
    }

    /// The parts that are wholly in a region.
    pub fn in_region(&self, painted: &Painted) -> Vec<usize> {
        let Painted::Vertices(values) = painted else { return Vec::new() };
        let mut within: Vec<bool> = vec![values.len() == self.part.len(); self.names.len()];
        for (part, value) in self.part.iter().zip(values.iter()) {
            if let Some(within) = within.get_mut(*part as usize) {
                *within &= *value > 0.5;
            }
        }
        (0..within.len()).filter(|i| within[*i] && self.part.contains(&(*i as u32))).collect()
    }
}

/// The body whose limbs are found: `own`, made of the mesh called `name`, where its harmonics are those of the commands,
/// or the mesh with these. So commands, the window and their galleries find the same limbs. It is `own` where the mesh has
/// no such harmonics, and limbs may then have other numbers than in the commands.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn body_of_limbs(
    own: &Arc<Body>,
    (name, mesh): (&str, &TriMesh),
    watcher: &impl Watcher,
) -> Result<Arc<Body>, Error> {
    let basis = &own.basis;
    let enough = Limbs::HARMONICS.min(basis.vertices());
    if basis.certificate.laplacian == Laplacian::Delaunay && basis.harmonics() >= enough {
        return Ok(Arc::clone(own));
    }
    match body::build(name, mesh, Limbs::HARMONICS, Laplacian::Delaunay, watcher) {
        Ok((body, _)) => Ok(Arc::new(body)),
        Err(error) if error.is_cancelled() => Err(error),
        Err(_) => Ok(Arc::clone(own)),
    }
}

/// For each of the `limbs` of `body` its mirror image; none where the shape is not symmetric.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn twins_of(limbs: &Limbs, body: &Body, watcher: &impl Watcher) -> Result<Vec<Option<usize>>, Error> {
    let search = MirrorSearch::of(&body.positions, &body.triangles);
    let plane = search.map(|search| watcher.watch("looking for the mirror", |task| search.best(&[], task)));
    Ok(twins_in(limbs, plane.transpose()?.flatten()))
}

fn twins_in(limbs: &Limbs, mirror: Option<MirrorPlane>) -> Vec<Option<usize>> {
    match mirror.filter(MirrorPlane::fits) {
        Some(plane) => limbs.twins(&plane),
        None => vec![None; limbs.parts.len()],
    }
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::BasisSettings;
    use chladni_task::Task;

    use super::*;
    use crate::work::Aside;

    #[test]
    fn limbs_are_found_by_the_same_harmonics_whatever_the_body_has() {
        let (mesh, task) = (samples::icosphere(2), Task::new());
        let of = |settings: BasisSettings| {
            let own = Arc::new(Body::build(&mesh, &settings, &task).unwrap());
            let found = body_of_limbs(&own, ("ball", &mesh), &Aside::new(&task)).unwrap();
            (own, found)
        };
        let (all, found) = of(BasisSettings::new(Limbs::HARMONICS));
        assert!(Arc::ptr_eq(&all, &found));
        let paper = BasisSettings { laplacian: Laplacian::Cotangent, ..BasisSettings::new(Limbs::HARMONICS) };
        for settings in [BasisSettings::new(20), paper] {
            let (_, found) = of(settings);
            assert_eq!(found.basis.harmonics(), all.basis.harmonics());
            assert_eq!(found.basis.certificate.laplacian, Laplacian::Delaunay);
        }
    }
}
