//! Samples and meshes that are ready to dance.

use std::sync::Arc;

use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::TriMesh;
use chladni_music::{Bands, Dancer, Mapping, Player, Playing};
use chladni_program::cli::Terminal;
use chladni_program::work::dancer::{Dancing, classes};
use chladni_program::work::{Error, Watcher, body, source};
use chladni_synth::displacements_f64;

pub const HARMONICS: usize = 128;

pub const RATE_HZ: u32 = 44_100;

/// A sample or mesh that is ready to dance.
pub struct Ready {
    pub name: String,
    pub body: Body,
    pub dancer: Arc<Dancer>,
}

impl Ready {
    /// The sample called `name`.
    pub fn sample(name: &str, terminal: &Terminal) -> Result<Self, Error> {
        Self::new(name, &source::mesh(source::sample_path(name), terminal)?, HARMONICS, terminal)
    }

    /// A mesh with this many harmonics.
    pub fn new(name: &str, mesh: &TriMesh, harmonics: usize, terminal: &Terminal) -> Result<Self, Error> {
        let (body, _) = body::build(name, mesh, harmonics, Laplacian::Delaunay, terminal)?;
        let symmetry = terminal.watch("finding the mirror", |task| classes(&body, false, task))?;
        let Dancing { body, dancer, .. } =
            Dancing::new(&body, symmetry, &chladni_mesh::Orientation::default())?;
        Ok(Self { name: name.to_owned(), body, dancer })
    }

    /// The displacements by `mapping`.
    pub fn displacements(
        &self,
        mapping: &Mapping,
        bands: &Bands<'_>,
        playing: Playing,
    ) -> Result<Vec<[f64; 3]>, Error> {
        let mut player = Player::new(mapping, &self.dancer, bands.mid.len(), playing)?;
        let mut item = player.item();
        player.play(bands, &mut item)?;
        Ok(displacements_f64(&self.body, &item)?)
    }
}

/// The farthest that any vertex goes.
pub fn farthest(moved: &[[f64; 3]]) -> f64 {
    moved.iter().map(|d| d.iter().map(|c| c * c).sum::<f64>().sqrt()).fold(0.0, f64::max)
}
