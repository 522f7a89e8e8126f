//! Samples that are ready to dance, and presets that move from shape to shape.

use std::sync::Arc;

use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::{TriMesh, samples};
use chladni_music::{
    Action, Bands, Dancer, GalleryShape, Instrument, Mapping, Moment, Player, Playing, Preset, Symmetry,
};
use chladni_sound::{SpectrumSettings, sample_tune};
use chladni_synth::displacements_f64;
use serde::Serialize;

use super::gallery::{ITEMS, moved};
use crate::cli::inputs::build_body;
use crate::cli::{Failure, Terminal};

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
    pub fn sample(name: &str, terminal: &Terminal) -> Result<Self, Failure> {
        let mesh = samples::sample(name).ok_or_else(|| Failure::BadInput(format!("no sample {name}")))?;
        Self::new(name, &mesh, terminal)
    }

    /// A mesh.
    pub fn new(name: &str, mesh: &TriMesh, terminal: &Terminal) -> Result<Self, Failure> {
        let (body, _) = build_body(name, mesh, HARMONICS, Laplacian::Delaunay, terminal)?;
        let symmetry =
            terminal.watch("finding the mirror", |task| Symmetry::of(&body, task)).map_err(Failure::other)?;
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(Failure::other)?);
        Ok(Self { name: name.to_owned(), body, dancer })
    }

    /// What `mapping` does to it.
    pub fn displacements(
        &self,
        mapping: &Mapping,
        bands: &Bands<'_>,
        playing: Playing,
    ) -> Result<Vec<[f64; 3]>, Failure> {
        let mut player =
            Player::new(mapping, &self.dancer, bands.mid.len(), playing).map_err(Failure::other)?;
        let mut item = player.item();
        player.play(bands, &mut item).map_err(Failure::other)?;
        displacements_f64(&self.body, &item).map_err(Failure::other)
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
pub fn transfer(from: &Ready, to: &Ready) -> Result<Transfer, Failure> {
    let bands = SpectrumSettings::new(RATE_HZ).bands;
    let begin = |ready: &Ready| {
        let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands };
        Instrument::new(11, ITEMS, shape).map_err(Failure::other)
    };
    let (mut own, mut other) = (begin(from)?, begin(to)?);
    for item in [0, 1, 3, 6, 10] {
        own.apply(Moment::default(), Action::Choose { item, on: true }).map_err(Failure::other)?;
    }
    own.apply(Moment::default(), Action::Breed).map_err(Failure::other)?;
    for (item, bred) in own.gallery().items().iter().enumerate() {
        let text = Preset::of(&own, bred, Vec::new()).to_text().map_err(Failure::other)?;
        let preset = Preset::from_text(&text).map_err(Failure::other)?;
        let mapping = preset.mapping_on(other.shape());
        let load = Action::Load { item, name: preset.name, mapping };
        other.apply(Moment::default(), load).map_err(Failure::other)?;
    }
    let (there, here) = (moved(to, &other, &sample_tune())?.0, moved(from, &own, &sample_tune())?.0);
    let mut ratio: Vec<f64> = there.iter().zip(&here).map(|(t, h)| t / h.max(f64::MIN_POSITIVE)).collect();
    ratio.sort_by(f64::total_cmp);
    let ratio = [0, ITEMS / 2, ITEMS - 1].map(|i| ratio.get(i).copied().unwrap_or(0.0));
    Ok(Transfer { presets: ITEMS, ratio })
}
