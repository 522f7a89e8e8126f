//! Samples that are ready to dance, and presets that move from shape to shape.

use std::sync::Arc;

use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::TriMesh;
use chladni_music::{
    Action, Bands, Dancer, GalleryShape, Instrument, Mapping, Moment, Player, Playing, Preset,
};
use chladni_sound::{SpectrumSettings, sample_tune};
use chladni_synth::displacements_f64;
use serde::Serialize;

use super::gallery::{ITEMS, moved};
use chladni_program::cli::Terminal;
use chladni_program::work::dancer::{Dancing, classes};
use chladni_program::work::{Error, Watcher};
use chladni_program::work::{body, source};

pub const HARMONICS: usize = 128;
pub const RATE_HZ: u32 = 44_100;

/// A sample that is ready to dance.
pub struct Ready {
    pub name: String,
    pub body: Body,
    pub dancer: Arc<Dancer>,
}

impl Ready {
    /// The sample called `name`.
    pub fn sample(name: &str, terminal: &Terminal) -> Result<Self, Error> {
        Self::new(name, &source::mesh(source::sample_path(name), terminal)?, terminal)
    }

    /// A mesh.
    pub fn new(name: &str, mesh: &TriMesh, terminal: &Terminal) -> Result<Self, Error> {
        let (body, _) = body::build(name, mesh, HARMONICS, Laplacian::Delaunay, terminal)?;
        let symmetry = terminal.watch("finding the mirror", |task| classes(&body, false, task))?;
        let Dancing { body, dancer, .. } = Dancing::new(&body, symmetry)?;
        Ok(Self { name: name.to_owned(), body, dancer })
    }

    /// What `mapping` does to it.
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

/// How far presets that were bred on one shape move another.
#[derive(Serialize)]
pub struct Transfer {
    pub presets: usize,
    /// Mean movement there over that on their own shape, both as shares of the box: least, median, most.
    pub ratio: [f64; 3],
}

/// Breeds a generation on `from` and plays its presets, as their files say, on both shapes to the sample tune.
pub fn transfer(from: &Ready, to: &Ready) -> Result<Transfer, Error> {
    let bands = SpectrumSettings::new(RATE_HZ).bands;
    let begin = |ready: &Ready| {
        let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands };
        Ok::<_, Error>(Instrument::new(11, ITEMS, shape)?)
    };
    let (mut own, mut other) = (begin(from)?, begin(to)?);
    for item in [0, 1, 3, 6, 10] {
        own.apply(Moment::default(), Action::Choose { item, on: true })?;
    }
    own.apply(Moment::default(), Action::Breed)?;
    for (item, bred) in own.gallery().items().iter().enumerate() {
        let text = Preset::of(&own, bred, Vec::new()).to_text()?;
        let preset = Preset::from_text(&text)?;
        let mapping = preset.mapping_on(other.shape());
        let load = Action::Load { item, name: preset.name, mapping };
        other.apply(Moment::default(), load)?;
    }
    let (there, here) = (moved(to, &other, &sample_tune())?.0, moved(from, &own, &sample_tune())?.0);
    let mut ratio: Vec<f64> = there.iter().zip(&here).map(|(t, h)| t / h.max(f64::MIN_POSITIVE)).collect();
    ratio.sort_by(f64::total_cmp);
    let ratio = [0, ITEMS / 2, ITEMS - 1].map(|i| ratio.get(i).copied().unwrap_or(0.0));
    Ok(Transfer { presets: ITEMS, ratio })
}
