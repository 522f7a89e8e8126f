//! How edges become smooth.

use std::str::FromStr;

use crate::ViewError;

/// How often a pixel is sampled, and with it how edges become smooth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Samples {
    /// Once. Edges are found in the finished picture and smoothed there (Lottes, FXAA, 2009).
    /// Several times faster on a software device.
    One,
    /// Four times, by the device.
    #[default]
    Four,
}

impl Samples {
    /// 1 or 4.
    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
}

impl FromStr for Samples {
    type Err = ViewError;

    fn from_str(text: &str) -> Result<Self, ViewError> {
        match text {
            "1" => Ok(Self::One),
            "4" => Ok(Self::Four),
            _ => Err(ViewError::Expected("1 or 4 samples a pixel")),
        }
    }
}

impl std::fmt::Display for Samples {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::One => "one sample a pixel, edges smoothed afterwards",
            Self::Four => "four samples a pixel",
        })
    }
}
