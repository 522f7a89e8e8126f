//! Dances that come with the program: a line or two of text each, which play on any shape.

use serde::Deserialize;

use crate::text_file::FORMAT_VERSION;
use crate::{
    Action, Choir, Form, Mapping, MusicError, Parameter, Preset, Settings, Switch, Timbre, text_file,
};

/// One dance, as `repertoire.toml` describes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    tags: Vec<String>,
    form: Form,
    timbre: String,
    /// How many waves fit into the size of the shape, from the lowest sounds to the highest, in even steps.
    waves: Vec<f32>,
    /// The waves that are amplified, from and to; the ends are soft.
    sounding: [f32; 2],
    /// The amplification of the longest and of the shortest of these waves.
    #[serde(default = "full")]
    amplified: [f32; 2],
    /// How much stronger it is than a dance usually is.
    #[serde(default = "one")]
    strength: f32,
    #[serde(default)]
    stereo_mu: f32,
    #[serde(default)]
    choir: Choir,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Repertoire {
    dance: Vec<Entry>,
}

fn full() -> [f32; 2] {
    [1.0; 2]
}

fn one() -> f32 {
    1.0
}

/// Bands of sound of each dance.
const BANDS: usize = 128;
/// The harmonics that a dance is written for: their waves grow as those of any surface do (Weyl's law).
const HARMONICS: usize = 320;
const MOST_WAVES: f32 = 12.0;

fn ladder() -> Vec<f32> {
    let top = (HARMONICS - 1) as f32;
    (0..HARMONICS).map(|k| MOST_WAVES * (k as f32 / top).sqrt()).collect()
}

impl Entry {
    fn preset(self) -> Result<Preset, MusicError> {
        let bad = |why: String| MusicError::Parse {
            kind: "repertoire",
            why: format!("“{}”: {why}", self.name),
        };
        let timbre =
            Timbre::named(&self.timbre).ok_or_else(|| bad(format!("there is no timbre {}", self.timbre)))?;
        let waves_per_size = ladder();
        let last = self.waves.len().checked_sub(1).ok_or_else(|| bad("has no waves".into()))?;
        let waves_at = |share: f32| {
            let at = share * last as f32;
            let (low, high) = (at as usize, (at as usize + 1).min(last));
            self.waves[low] + (at - low as f32) * (self.waves[high] - self.waves[low])
        };
        // Number k of the ladder has MOST_WAVES √(k / top) waves.
        let transfer =
            (0..BANDS).map(|band| (waves_at(band as f32 / (BANDS - 1) as f32) / MOST_WAVES).powi(2));
        let [from, to] = self.sounding;
        let amplification = waves_per_size.iter().map(|waves| {
            let share = ((waves - from) / (to - from).max(1e-3)).clamp(0.0, 1.0);
            let soft = 0.15 * (to - from);
            let inside = ((waves - from + soft) / soft).min((to + soft - waves) / soft).clamp(0.0, 1.0);
            inside * (self.amplified[0] + share * (self.amplified[1] - self.amplified[0]))
        });
        let mapping = Mapping {
            transfer: transfer.map(|t| t.clamp(0.0, 1.0)).collect(),
            amplification: amplification.collect(),
            stereo_mu: self.stereo_mu,
            gain: 1.0,
        };
        let gain = self.strength * mapping.even_gain();
        let knobs = Action::for_timbre(&timbre).into_iter().filter_map(|action| match action {
            Action::Set { parameter, value } => Some((parameter, value)),
            _ => None,
        });
        let settings = Settings {
            form: Some(self.form),
            choir: Some(self.choir),
            knobs: knobs.chain([(Parameter::Detail, 1.0)]).collect(),
            switches: [(Switch::Resonate, true), (Switch::LogBands, true), (Switch::OwnMu, true)].into(),
            ..Settings::default()
        };
        let preset = Preset {
            format_version: FORMAT_VERSION,
            name: self.name,
            tags: self.tags,
            seed: 0,
            lineage: Vec::new(),
            mapping: Mapping { gain, ..mapping },
            waves_per_size,
            settings,
        };
        preset.validate()?;
        Ok(preset)
    }
}

/// All of them, as presets.
///
/// # Errors
/// Where the text that they are written in is wrong, which tests rule out.
pub fn repertoire() -> Result<Vec<Preset>, MusicError> {
    let Repertoire { dance } = text_file::parse("repertoire", include_str!("repertoire.toml"))?;
    dance.into_iter().map(Entry::preset).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GalleryShape;
    use std::collections::HashSet;

    #[test]
    fn there_are_forty_and_each_has_a_name_and_says_what_it_suits() {
        let all = repertoire().unwrap();
        assert!(all.len() >= 40, "{}", all.len());
        let names: HashSet<&str> = all.iter().map(|preset| preset.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        for preset in &all {
            assert!(preset.tags.len() >= 2 && preset.caution().is_none(), "{}", preset.name);
            let text = preset.to_text().unwrap();
            assert_eq!(&Preset::from_text(&text).unwrap(), preset);
        }
        let tagged = |word: &str| all.iter().filter(|preset| preset.tags.iter().any(|t| t == word)).count();
        assert!(tagged("calm") >= 10 && tagged("lively") >= 10, "{} {}", tagged("calm"), tagged("lively"));
    }

    #[test]
    fn each_is_heard_on_any_shape_and_no_two_are_alike() {
        for growth in [0.6, 1.0, 3.0] {
            let eigenvalues = (0..256).map(|k| growth * f64::from(k)).collect();
            let shape = GalleryShape { eigenvalues, bands: 128 };
            let mappings: Vec<(String, Mapping)> = repertoire()
                .unwrap()
                .into_iter()
                .map(|preset| (preset.name.clone(), preset.mapping_on(&shape)))
                .collect();
            for (i, (name, mapping)) in mappings.iter().enumerate() {
                mapping.validate().unwrap();
                assert!(mapping.loudness() > 0.3, "{name}: {}", mapping.loudness());
                assert!(mappings[..i].iter().all(|(_, other)| other != mapping), "{name}");
            }
        }
    }
}
