//! Left and right: what a tone in one channel does to either half of a shape.

use std::collections::HashMap;

use chladni_music::{Form, Mapping, Playing};
use chladni_sound::{SpectrumAnalyzer, SpectrumSettings};
use serde::Serialize;

use super::ready::{RATE_HZ, Ready, farthest};
use chladni_program::work::{Error, bands_of};

/// The effect of a tone in one channel, or in both.
#[derive(Serialize)]
pub struct Stereo {
    pub shape: String,
    pub form: Form,
    pub channel: &'static str,
    pub tone_hz: f64,
    /// Area-weighted displacement energy of the tone's half over that of the other; of both, left over right.
    pub energy_ratio: f64,
    /// Mean displacement outwards of the tone's half minus that of the other, over the root mean square.
    pub direction: f64,
    /// How far the deformed shape is from its own mirror image, over the largest displacement.
    pub mirror_error: f64,
}

/// Tones hard left, hard right and in the middle, through the real spectrum, on a sample.
pub fn stereo(ready: &Ready) -> Result<Vec<Stereo>, Error> {
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, SpectrumSettings::new(RATE_HZ).bands);
    let mirror = mirror(&ready.body.positions);
    let normals = chladni_mesh::surface::vertex_normals(&ready.body.positions, &ready.body.triangles);
    let mut rows = Vec::new();
    for form in [Form::HalfMask, Form::Modal, Form::Filter] {
        for tone_hz in [110.0, 440.0, 1760.0] {
            for channel in ["left", "right", "both"] {
                let moved = tone(ready, &mapping, form, tone_hz, channel)?;
                let (mut energy, mut outwards, mut area) = ([0.0; 2], [0.0; 2], [0.0; 2]);
                let vertices = ready.body.positions.iter().zip(&normals).zip(&ready.body.basis.mass);
                for (d, ((x, n), a)) in moved.iter().zip(vertices) {
                    // Vertices in the middle belong to both halves.
                    let right = if x[0].abs() < 1e-6 { 0.5 } else { f64::from(u8::from(x[0] > 0.0)) };
                    for (half, share) in [1.0 - right, right].into_iter().enumerate() {
                        energy[half] += share * a * d.iter().map(|c| c * c).sum::<f64>();
                        outwards[half] += share * a * d.iter().zip(n).map(|(d, n)| d * n).sum::<f64>();
                        area[half] += share * a;
                    }
                }
                let own = usize::from(channel == "right");
                let mean = |half: usize| outwards[half] / area[half].max(f64::MIN_POSITIVE);
                let rms = ((energy[0] + energy[1]) / (area[0] + area[1])).sqrt();
                rows.push(Stereo {
                    shape: ready.name.clone(),
                    form,
                    channel,
                    tone_hz,
                    energy_ratio: energy[own] / energy[1 - own].max(f64::MIN_POSITIVE),
                    direction: (mean(own) - mean(1 - own)) / rms.max(f64::MIN_POSITIVE),
                    mirror_error: asymmetry(&moved, &mirror),
                });
            }
        }
    }
    Ok(rows)
}

fn tone(
    ready: &Ready,
    mapping: &Mapping,
    form: Form,
    tone_hz: f64,
    channel: &str,
) -> Result<Vec<[f64; 3]>, Error> {
    let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings::new(RATE_HZ))?;
    let n = analyzer.window_frames();
    let wave =
        |i: usize| 0.5 * (std::f64::consts::TAU * tone_hz * i as f64 / f64::from(RATE_HZ)).sin() as f32;
    let tone: Vec<f32> = (0..n).map(wave).collect();
    let silence = vec![0.0; n];
    let [left, right] = match channel {
        "left" => [&tone, &silence],
        "right" => [&silence, &tone],
        _ => [&tone, &tone],
    };
    let heard = analyzer.analyze(left, right, 1.0);
    ready.displacements(mapping, &bands_of(heard), Playing { form, ..Playing::default() })
}

/// The vertex at the mirror image of each vertex in x = 0, where there is one.
fn mirror(positions: &[[f64; 3]]) -> Vec<Option<usize>> {
    let key = |p: [f64; 3]| p.map(|c| (c * 1e5).round() as i64);
    let at: HashMap<[i64; 3], usize> = positions.iter().enumerate().map(|(v, p)| (key(*p), v)).collect();
    let image = |p: &[f64; 3]| {
        let [x, y, z] = key(*p);
        // Rounding may put the mirror image into a neighboring cell.
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
