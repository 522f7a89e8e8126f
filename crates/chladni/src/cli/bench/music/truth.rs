//! Samples that are ready to dance, and presets that move from shape to shape.

use std::sync::Arc;

use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::samples;
use chladni_music::{
    Action, Bands, Dancer, GalleryShape, Instrument, Mapping, Moment, Player, Playing, Preset, Symmetry,
};
use chladni_sound::SpectrumSettings;
use chladni_synth::displacements_f64;
use serde::Serialize;

use crate::cli::inputs::build_body;
use crate::cli::{Failure, Terminal};

const HARMONICS: usize = 128;
pub const RATE_HZ: u32 = 44_100;

/// A sample that is ready to dance.
pub struct Ready {
    pub name: &'static str,
    pub body: Body,
    pub dancer: Arc<Dancer>,
}

impl Ready {
    /// The sample called `name`.
    pub fn sample(name: &'static str, terminal: &Terminal) -> Result<Self, Failure> {
        let mesh = samples::sample(name).ok_or_else(|| Failure::BadInput(format!("no sample {name}")))?;
        let (body, _) = build_body(name, &mesh, HARMONICS, Laplacian::Delaunay, terminal)?;
        let symmetry =
            terminal.watch("finding the mirror", |task| Symmetry::of(&body, task)).map_err(Failure::other)?;
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(Failure::other)?);
        Ok(Self { name, body, dancer })
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

/// Smallest and largest displacement of a full-scale band over the calibrated amount.
#[derive(Serialize)]
pub struct Transfer {
    pub presets: usize,
    pub own: [f64; 2],
    pub other: [f64; 2],
}

/// Breeds a generation on `from` and plays its presets, as their files say, on both shapes.
pub fn transfer(from: &Ready, to: &Ready) -> Result<Transfer, Failure> {
    let bands = SpectrumSettings::new(RATE_HZ).bands;
    let shape = GalleryShape { eigenvalues: from.dancer.eigenvalues.clone(), bands };
    let mut instrument = Instrument::new(11, 12, shape).map_err(Failure::other)?;
    let mut act = |action| instrument.apply(Moment::default(), action).map_err(Failure::other);
    for item in [0, 1, 3, 6, 10] {
        act(Action::Choose { item, on: true })?;
    }
    act(Action::Breed)?;
    let mut transfer = Transfer { presets: 0, own: [f64::MAX, 0.0], other: [f64::MAX, 0.0] };
    for item in instrument.gallery().items() {
        let text = Preset::of(&instrument, item, Vec::new()).to_text().map_err(Failure::other)?;
        let mapping = Preset::from_text(&text).map_err(Failure::other)?.mapping;
        for (ready, range) in [(from, &mut transfer.own), (to, &mut transfer.other)] {
            let share =
                loudest(ready, &mapping, bands)? / f64::from(Playing::default().calibration * mapping.gain);
            *range = [range[0].min(share), range[1].max(share)];
        }
        transfer.presets += 1;
    }
    Ok(transfer)
}

/// The farthest that any full-scale band, in the middle or in the sides, moves a vertex, as a share
/// of the box's diagonal.
fn loudest(ready: &Ready, mapping: &Mapping, bands: usize) -> Result<f64, Failure> {
    let silence = vec![0.0; bands];
    let mut most = 0.0f64;
    for band in 0..bands {
        let mut full = silence.clone();
        full[band] = 1.0;
        for (mid, side) in [(&full, &silence), (&silence, &full)] {
            let heard = Bands { left: &full, right: &full, mid, side, side_gain: 1.0 };
            most = most.max(farthest(&ready.displacements(mapping, &heard, Playing::default())?));
        }
    }
    Ok(most / f64::from(ready.dancer.box_diagonal))
}
