//! Left and right, and presets that move from shape to shape.

use std::collections::HashMap;
use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::samples;
use chladni_music::{
    Action, Bands, Dancer, Form, GalleryShape, Instrument, Mapping, Moment, Player, Playing, Preset, Symmetry,
};
use chladni_sound::{SpectrumAnalyser, SpectrumSettings};
use chladni_synth::displacements_f64;
use serde::Serialize;

use crate::cli::inputs::build_body;
use crate::cli::{Failure, Terminal};

const HARMONICS: usize = 128;
const RATE_HZ: u32 = 44_100;

/// A sample that is ready to dance.
pub struct Ready {
    body: Body,
    dancer: Arc<Dancer>,
}

impl Ready {
    /// The sample called `name`.
    pub fn sample(name: &str, terminal: &Terminal) -> Result<Self, Failure> {
        let mesh = samples::sample(name).ok_or_else(|| Failure::BadInput(format!("no sample {name}")))?;
        let (body, _) = build_body(name, &mesh, HARMONICS, terminal)?;
        let symmetry =
            terminal.watch("finding the mirror", |task| Symmetry::of(&body, task)).map_err(Failure::other)?;
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(Failure::other)?);
        Ok(Self { body, dancer })
    }

    fn displacements(
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

/// What a tone in one channel does.
#[derive(Serialize)]
pub struct Stereo {
    pub form: Form,
    pub channel: &'static str,
    pub tone_hz: f64,
    /// Area-weighted displacement energy of the tone's half over that of the other.
    pub energy_ratio: f64,
    /// How far the deformed shape is from its own mirror image, over the largest displacement.
    pub mirror_error: f64,
}

/// Tones hard left and hard right, through the real spectrum, on the octopus.
pub fn stereo(ready: &Ready) -> Result<Vec<Stereo>, Failure> {
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, SpectrumSettings::new(RATE_HZ).bands);
    let mirror = mirror(&ready.body.positions);
    let mut rows = Vec::new();
    for form in [Form::HalfMask, Form::Modal, Form::Filter] {
        for tone_hz in [110.0, 440.0, 1760.0] {
            for (side, channel) in ["left", "right"].into_iter().enumerate() {
                let mut analyser =
                    SpectrumAnalyser::new(SpectrumSettings::new(RATE_HZ)).map_err(Failure::other)?;
                let n = analyser.window_frames();
                let wave = |i: usize| {
                    0.5 * (std::f64::consts::TAU * tone_hz * i as f64 / f64::from(RATE_HZ)).sin() as f32
                };
                let tone: Vec<f32> = (0..n).map(wave).collect();
                let silence = vec![0.0; n];
                let [left, right] = if side == 0 { [&tone, &silence] } else { [&silence, &tone] };
                let heard = analyser.analyse(left, right, 1.0);
                let bands = Bands {
                    left: &heard.left,
                    right: &heard.right,
                    mid: &heard.mid,
                    side: &heard.side,
                    side_gain: heard.side_gain,
                };
                let moved = ready.displacements(&mapping, &bands, Playing { form, ..Playing::default() })?;
                let mut energy = [0.0; 2];
                for ((d, x), a) in moved.iter().zip(&ready.body.positions).zip(&ready.body.basis.mass) {
                    energy[usize::from(x[0] > 0.0)] += a * d.iter().map(|c| c * c).sum::<f64>();
                }
                let energy_ratio = energy[side] / energy[1 - side].max(f64::MIN_POSITIVE);
                let mirror_error = asymmetry(&moved, &mirror);
                rows.push(Stereo { form, channel, tone_hz, energy_ratio, mirror_error });
            }
        }
    }
    Ok(rows)
}

/// The vertex at the mirror image of each vertex in x = 0, where there is one.
fn mirror(positions: &[[f64; 3]]) -> Vec<Option<usize>> {
    let key = |p: [f64; 3]| p.map(|c| (c * 1e5).round() as i64);
    let at: HashMap<[i64; 3], usize> = positions.iter().enumerate().map(|(v, p)| (key(*p), v)).collect();
    let image = |p: &[f64; 3]| {
        let [x, y, z] = key(*p);
        // Rounding may put the mirror image into a neighbouring cell.
        (0..27)
            .map(|i: i64| [-x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])
            .find_map(|k| at.get(&k).copied())
    };
    positions.iter().map(image).collect()
}

fn asymmetry(moved: &[[f64; 3]], mirror: &[Option<usize>]) -> f64 {
    let mut worst = 0.0f64;
    for (d, image) in moved.iter().zip(mirror) {
        let Some(e) = image.and_then(|w| moved.get(w)) else { continue };
        worst = worst.max((d[0] + e[0]).abs()).max((d[1] - e[1]).abs()).max((d[2] - e[2]).abs());
    }
    worst / farthest(moved).max(f64::MIN_POSITIVE)
}

fn farthest(moved: &[[f64; 3]]) -> f64 {
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
