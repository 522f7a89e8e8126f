//! Samples that are ready to dance, and presets that move from shape to shape.

use chladni_music::{Action, GalleryShape, Instrument, Moment, Preset};
use chladni_sound::{SpectrumSettings, sample_tune};
use serde::Serialize;

use super::gallery::{ITEMS, moved};
use super::ready::{RATE_HZ, Ready};
use chladni_program::work::Error;

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
        let text = own.preset(bred, Vec::new()).to_text()?;
        let preset = Preset::from_text(&text)?;
        let mapping = preset.mapping_on(other.shape());
        let load = Action::Load { item, name: preset.name, mapping };
        other.apply(Moment::default(), load)?;
    }
    let (there, here) = (moved(to, &other, &sample_tune())?.ways, moved(from, &own, &sample_tune())?.ways);
    let mut ratio: Vec<f64> = there.iter().zip(&here).map(|(t, h)| t / h.max(f64::MIN_POSITIVE)).collect();
    ratio.sort_by(f64::total_cmp);
    let ratio = [0, ITEMS / 2, ITEMS - 1].map(|i| ratio.get(i).copied().unwrap_or(0.0));
    Ok(Transfer { presets: ITEMS, ratio })
}
