//! The part of a synthesis that is computed once per shape and read in every frame.

use std::sync::Arc;

use chladni_harmonics::Body;

use crate::normals::{Rings, area_weighted_normals};
use crate::packed_basis::PackedBasis;
use crate::{Item, SynthError, exact};

/// A shape prepared for synthesis: rest positions and normals, rings of triangles around vertices, and the
/// basis packed for fast reading. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct SynthModel {
    pub(crate) rest_positions: Arc<[[f32; 3]]>,
    pub(crate) rest_normals: Arc<[[f32; 3]]>,
    pub(crate) rings: Arc<Rings>,
    pub(crate) basis: Arc<PackedBasis>,
}

impl SynthModel {
    /// The model of a body: N operator vertices, K harmonics, working frame.
    ///
    /// # Errors
    /// Those of [`from_parts`](Self::from_parts).
    pub fn new(body: &Body) -> Result<Self, SynthError> {
        Self::from_parts(&body.positions, &body.triangles, &body.basis.vectors)
    }

    /// The model of N `positions`, `triangles` over them, and an N×K column-major `basis`.
    ///
    /// # Errors
    /// A basis whose size is not a multiple of the number of positions, a triangle that refers to a vertex
    /// that does not exist, or a value that is NaN or infinite.
    pub fn from_parts(
        positions: &[[f64; 3]],
        triangles: &[[u32; 3]],
        basis: &[f64],
    ) -> Result<Self, SynthError> {
        if u32::try_from(positions.len()).is_err() {
            return Err(SynthError::TooLarge { items: 1, vertices: positions.len() });
        }
        let rings = Arc::new(Rings::new(positions.len(), triangles)?);
        let basis = Arc::new(PackedBasis::new(positions.len(), basis)?);
        let (rest_positions, rest_normals) = rest(positions, triangles)?;
        Ok(Self { rest_positions, rest_normals, rings, basis })
    }

    /// N, the number of vertices of every item.
    pub fn vertices(&self) -> usize {
        self.rest_positions.len()
    }

    /// K, the number of harmonics.
    pub fn harmonics(&self) -> usize {
        self.basis.harmonics()
    }

    /// x(v), N rest positions.
    pub fn rest_positions(&self) -> &[[f32; 3]] {
        &self.rest_positions
    }

    /// n(v), N rest normals of unit length.
    pub fn rest_normals(&self) -> &[[f32; 3]] {
        &self.rest_normals
    }

    /// Size of the packed basis in bytes: one frame reads all of it if every harmonic has weight.
    pub fn basis_bytes(&self) -> usize {
        self.basis.bytes()
    }
}

type Rest = (Arc<[[f32; 3]]>, Arc<[[f32; 3]]>);

fn rest(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Rest, SynthError> {
    if let Some(index) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(SynthError::NotFinite { what: "rest position", index });
    }
    let normals = area_weighted_normals(positions, triangles)?;
    let narrow = |p: &[f64; 3]| p.map(|c| c as f32);
    Ok((positions.iter().map(narrow).collect(), normals.iter().map(narrow).collect()))
}

/// The displacements x' − x of one item in double precision, for exports: N values in the working frame.
/// They are computed from the basis of the body, not from the packed one, and are exactly zero wherever the
/// item does nothing.
///
/// # Errors
/// Those of [`crate::Synthesizer::synthesize_positions`].
pub fn displacements_f64(body: &Body, item: &Item) -> Result<Vec<[f64; 3]>, SynthError> {
    exact::displacements(body, item)
}
