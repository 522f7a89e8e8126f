//! How a mapping is turned into movement.

use serde::{Deserialize, Serialize};

use crate::{Class, MusicError, Timbre};

/// How the gains of the harmonics move the shape (docs/music.md, "Forms").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// The paper's filter: C_k = (φ_k − 1) x̃_k. A mirror-symmetric shape stays so.
    Filter,
    /// H_k along the normal: c_k = ±(φ_k − 1), as on a vibrating plate. The middle signal moves symmetric
    /// harmonics, the side antisymmetric ones, which swing toward the louder channel.
    Modal,
    /// The filter twice: the left channel under χ_L, the right one under χ_R. The default, because it is the
    /// only form in which each channel is seen on its own side on every shape.
    #[default]
    HalfMask,
}

/// A control that some forms ignore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// μ, of one item or of all.
    StereoMu,
    /// The gain of the side.
    SideGain,
    /// φ_d.
    Detail,
}

impl Form {
    /// Why a control has no effect in this form, as a message to the user; `None` where it has one.
    pub fn ignores(self, control: Control) -> Option<&'static str> {
        match (self, control) {
            (Self::HalfMask, Control::StereoMu) => {
                Some("Without effect in halves: each half hears its own channel. Filter and modal mix by μ.")
            }
            (Self::HalfMask, Control::SideGain) => Some(
                "Without effect in halves: each half hears its own channel. Filter and modal amplify the side.",
            ),
            (Self::Modal, Control::Detail) => {
                Some("Without effect in modal: nothing finer than the last harmonic moves along the normals.")
            }
            _ => None,
        }
    }

    /// How many terms of an item belong to its mapping; voices come after them.
    pub fn terms(self) -> usize {
        if self == Self::HalfMask { 2 } else { 1 }
    }
}

/// Which harmonics may sound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Choir {
    /// All of them.
    #[default]
    All,
    /// Only those that are their own mirror image.
    Symmetric,
    /// Only those that change sign in the mirror.
    Antisymmetric,
}

impl Choir {
    pub(crate) fn admits(self, class: Class) -> bool {
        match self {
            Self::All => true,
            Self::Symmetric => class == Class::Symmetric,
            Self::Antisymmetric => class == Class::Antisymmetric,
        }
    }
}

/// Steepness limit per unit of displacement limit (a share of the diagonal): the slowest waves, about as long
/// as the shape, reach both limits at once; all others reach the steepness first. At the default limit
/// nothing turns over.
pub(crate) const STEEPNESS: f32 = 5.5;

/// How a mapping is turned into movement; the same for all items of a gallery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Playing {
    /// Filter, modal or half-mask.
    pub form: Form,
    /// Which harmonics may sound.
    pub choir: Choir,
    /// Overall strength, [0, 20]; multiplies every mapping's own gain.
    pub gain: f32,
    /// Exchanges left and right.
    pub flip_sides: bool,
    /// The movement that a full-scale band causes at gain 1: the path of the farthest-moving vertex, as a share of
    /// the bounding box's diagonal, (0, 1]; less where the steepness would exceed 5.5 times that number.
    pub calibration: f32,
    /// The largest displacement as a share of the diagonal, (0, 1], and 5.5 times that number as the largest
    /// steepness: a soft limit that starts to act at half its value, on each octave of harmonics by itself and
    /// then on their sum. It is measured at probes; vertices between them may go a little farther.
    pub limit: f32,
    /// φ_d in [−10, 10]: the gain of all detail above K; 1 leaves it unchanged.
    pub detail: f32,
    /// Number of harmonics in use; the others stay silent. `None` is all K.
    pub harmonics: Option<u32>,
    /// μ of all dances, in [0, 1]; `None` leaves each its own.
    pub stereo_mu: Option<f32>,
    /// How harmonics ring; `None` lets them follow the level of the sound, as in the paper.
    pub timbre: Option<Timbre>,
}

impl Default for Playing {
    fn default() -> Self {
        Self {
            form: Form::default(),
            choir: Choir::All,
            gain: 1.0,
            flip_sides: false,
            calibration: 0.08,
            limit: 0.18,
            detail: 1.0,
            harmonics: None,
            stereo_mu: None,
            timbre: Some(Timbre::NAMED[0].1),
        }
    }
}

impl Playing {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// Names the field that is out of its range.
    pub fn validate(&self) -> Result<(), MusicError> {
        let check = |name, value: f32, ok: bool, range| {
            if ok {
                Ok(())
            } else {
                Err(MusicError::OutOfRange { name, value: value.into(), range: String::from(range) })
            }
        };
        let share = |v: f32| v > 0.0 && v <= 1.0;
        check("gain", self.gain, (0.0..=20.0).contains(&self.gain), "[0, 20]")?;
        check("calibration", self.calibration, share(self.calibration), "(0, 1]")?;
        check("limit", self.limit, share(self.limit), "(0, 1]")?;
        let mu = self.stereo_mu.unwrap_or(0.0);
        check("stereo-mu", mu, (0.0..=1.0).contains(&mu), "[0, 1]")?;
        if let Some(timbre) = self.timbre {
            let Timbre { damping, tuning_hz, stretch, strike, hold } = timbre;
            check("damping", damping, (0.01..=2.0).contains(&damping), "[0.01, 2]")?;
            check("tuning-hz", tuning_hz, tuning_hz.is_finite() && tuning_hz > 0.0, "numbers above 0")?;
            check("stretch", stretch, stretch.is_finite(), "any number")?;
            check("strike", strike, strike.is_finite() && strike >= 0.0, "numbers from 0 on")?;
            check("hold", hold, hold.is_finite() && hold >= 0.0, "numbers from 0 on")?;
        }
        check("detail", self.detail, (-10.0..=10.0).contains(&self.detail), "[-10, 10]")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timbres_out_of_their_ranges_are_refused() {
        let named = Timbre::NAMED[0].1;
        let is_valid = |timbre| Playing { timbre: Some(timbre), ..Playing::default() }.validate().is_ok();
        assert!(Timbre::NAMED.into_iter().all(|(_, timbre)| is_valid(timbre)));
        for damping in [0.01, 2.0] {
            assert!(is_valid(Timbre { damping, strike: 0.0, hold: 0.0, ..named }));
        }
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            assert!(!is_valid(Timbre { damping: bad, ..named }), "{bad}");
            assert!(!is_valid(Timbre { tuning_hz: bad, ..named }), "{bad}");
            assert!(!is_valid(Timbre { strike: bad, ..named }), "{bad}");
            assert!(!is_valid(Timbre { hold: bad, ..named }), "{bad}");
        }
        assert!(!is_valid(Timbre { damping: 0.005, ..named }));
        assert!(!is_valid(Timbre { tuning_hz: 0.0, ..named }));
    }
}
