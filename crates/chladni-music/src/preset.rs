//! Presets: one dance as a small text file that can be played on any shape.

use std::path::Path;

use chladni_breeding::item_name;
use serde::{Deserialize, Serialize};

use crate::text_file;
use crate::{GalleryShape, Mapping, MusicError, Origin, Settings};

/// Wavelengths with a smaller relative difference count as equal: solves with different K agree to this.
const SAME_WAVE: f32 = 1e-3;

/// A mapping with a name, the wavelengths of its harmonics, and the knobs that change its look. It can be
/// played on any shape, with any number of harmonics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// The version of the file format; version 1 has no wavelengths.
    pub format_version: u32,
    /// The name of the preset.
    pub name: String,
    /// Keywords to find it by.
    #[serde(default)]
    pub tags: Vec<String>,
    /// The seed of the gallery from which it comes.
    pub seed: u64,
    /// The origin of the item, then those of its ancestors, each with its id; newest first.
    #[serde(default)]
    pub lineage: Vec<Ancestor>,
    /// The mapping, for the harmonics on which it was made.
    pub mapping: Mapping,
    /// For each of those harmonics, how many of its waves fit into the size of the shape
    /// ([`GalleryShape::waves_per_size`]); ascending. Empty in version 1, in which harmonics are shares of K.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waves_per_size: Vec<f32>,
    /// The form, and the knobs that change how the dance looks.
    #[serde(default, skip_serializing_if = "Settings::is_empty")]
    pub settings: Settings,
}

/// One line of a lineage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ancestor {
    /// Its id in the session.
    pub id: u32,
    /// Its name in the session; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Whether it was edited by hand.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub edited: bool,
    /// Where it comes from.
    #[serde(flatten)]
    pub origin: Origin,
}

impl Preset {
    /// The mapping for a body: each driven harmonic is replaced by the one with the same wavelength
    /// relative to the size of the shape. Waves finer than the finest one of the body are muted.
    pub fn mapping_on(&self, shape: &GalleryShape) -> Mapping {
        let (there, here) = (&self.waves_per_size, shape.waves_per_size());
        let (Some(last_there), Some(top)) = (there.len().checked_sub(1), here.len().checked_sub(1)) else {
            return self.mapping.clone();
        };
        if there.len() == here.len() && there.iter().zip(&here).all(|(a, b)| is_same_wave(*a, *b)) {
            return self.mapping.clone();
        }
        let mut finer = false;
        let transfer = self.mapping.transfer.iter().map(|t| {
            let k = (t.clamp(0.0, 1.0) * last_there as f32).round() as usize;
            let found = harmonic_of(&here, there[k.min(last_there)], k);
            finer |= found.is_none();
            found.unwrap_or(top) as f32 / top.max(1) as f32
        });
        let transfer = transfer.collect();
        let a = self.mapping.amplification_on(there.len());
        let amplification = here.iter().enumerate().map(|(k, &wave)| {
            // All finer waves are mapped to the finest harmonic, which is therefore muted.
            let muted = finer && k == top;
            harmonic_of(there, wave, k).filter(|_| !muted).map_or(0.0, |i| a[i])
        });
        Mapping { transfer, amplification: amplification.collect(), ..self.mapping.clone() }
    }

    /// A warning for the user who opens the preset; only old files have one.
    pub fn caution(&self) -> Option<String> {
        self.waves_per_size.is_empty().then(|| {
            format!(
                "“{}” is a preset of version {}: it moves the same only where as many harmonics are used as where \
                 it was made, and of its form and knobs only that nothing resonated is known. Keep it again to bring it \
                 up to date.",
                self.name, self.format_version
            )
        })
    }

    /// Reads the text of a preset file.
    ///
    /// # Errors
    /// Text that is not a preset (the error states the line), a newer format version, or a value out of its
    /// range.
    pub fn from_text(text: &str) -> Result<Self, MusicError> {
        let version = text_file::version("preset", text)?;
        let mut preset: Self = text_file::parse("preset", text)?;
        if version <= 2 {
            preset.settings = preset.settings.of_version_2();
        }
        preset.name = item_name(&preset.name);
        preset.validate()?;
        Ok(preset)
    }

    /// The text of a preset file.
    ///
    /// # Errors
    /// None in practice: every preset can be written.
    pub fn to_text(&self) -> Result<String, MusicError> {
        text_file::print("preset", self)
    }

    /// Reads a preset file of at most 16 MiB.
    ///
    /// # Errors
    /// A file that cannot be read or is too large, and the errors of [`from_text`](Self::from_text).
    pub fn load(path: &Path) -> Result<Self, MusicError> {
        Self::from_text(&text_file::read(path, 16)?)
    }

    /// Writes a preset file, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), MusicError> {
        text_file::write(path, &self.to_text()?)
    }

    pub(crate) fn validate(&self) -> Result<(), MusicError> {
        self.mapping.validate()?;
        self.settings.validate()?;
        let waves = &self.waves_per_size;
        let bad = |why: &str| Err(MusicError::BadMapping { what: "waves_per_size", why: why.into() });
        if waves.len() > crate::MAX_GENES {
            return bad("has more values than harmonics can be");
        }
        if waves.iter().any(|w| !(w.is_finite() && *w >= 0.0)) || waves.windows(2).any(|w| w[1] < w[0]) {
            return bad("must be ascending numbers, from 0 on");
        }
        Ok(())
    }
}

fn is_same_wave(a: f32, b: f32) -> bool {
    // The wavelengths of constant harmonics are only rounding noise.
    (a - b).abs() <= SAME_WAVE * (1.0 + a.max(b))
}

/// The harmonic of `waves` with the wave number `wave`: index `k` if it matches (which keeps the order of
/// equal waves), otherwise the nearest one; `None` if all are longer.
fn harmonic_of(waves: &[f32], wave: f32, k: usize) -> Option<usize> {
    if waves.get(k).is_some_and(|w| is_same_wave(*w, wave)) {
        return Some(k);
    }
    let last = waves.len().checked_sub(1)?;
    if wave > waves[last] && !is_same_wave(wave, waves[last]) {
        return None;
    }
    let after = waves.partition_point(|w| *w < wave).min(last);
    let before = after.saturating_sub(1);
    Some(if wave - waves[before] < waves[after] - wave { before } else { after })
}
