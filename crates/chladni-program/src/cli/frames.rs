//! Sizes and rates of pictures, as a user writes them.

use std::str::FromStr;

use chladni_view::FrameRate;

use crate::work::Error;

/// Width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Size {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |t: &str| t.parse::<u32>().ok().filter(|n| (1..=16_384).contains(n));
        let (width, height) = text
            .split_once(['x', 'X'])
            .ok_or_else(|| Error::input("expected WIDTHxHEIGHT, such as 1280x720"))?;
        match (number(width), number(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err(Error::input("width and height are whole numbers from 1 to 16384")),
        }
    }
}

/// Frames per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fps(pub FrameRate);

impl FromStr for Fps {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || {
            let (least, most) = FrameRate::WANTED_PER_SECOND.into_inner();
            Error::input(format!(
                "expected frames per second from {least} to {most}, such as 30, 29.97 or 30000/1001"
            ))
        };
        let rate = if let Some((n, d)) = text.split_once('/') {
            FrameRate {
                numerator: n.parse().map_err(|_| wrong())?,
                denominator: d.parse().map_err(|_| wrong())?,
            }
        } else {
            FrameRate::decimal(text.parse().map_err(|_| wrong())?)
        };
        let fps = f64::from(rate.numerator) / f64::from(rate.denominator.max(1));
        let is_wanted = FrameRate::WANTED_PER_SECOND.contains(&fps);
        if rate.denominator > 0 && is_wanted { Ok(Self(rate)) } else { Err(wrong()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_sizes() {
        let fps = |t: &str| t.parse::<Fps>().ok().map(|f| (f.0.numerator, f.0.denominator));
        assert_eq!(fps("30"), Some((30, 1)));
        assert_eq!(fps("29.97"), Some((30000, 1001)));
        assert_eq!(fps("23.976"), Some((24000, 1001)));
        assert_eq!(fps("12.5"), Some((12500, 1000)));
        assert_eq!(fps("4.99"), Some((4990, 1000)));
        assert_eq!(fps("5.0"), Some((5, 1)));
        assert!(["0", "1/0", "-3", "nan"].into_iter().all(|wrong| fps(wrong).is_none()));
        assert_eq!("640x360".parse::<Size>().unwrap(), Size { width: 640, height: 360 });
        assert!("640".parse::<Size>().is_err() && "0x5".parse::<Size>().is_err());
    }
}
