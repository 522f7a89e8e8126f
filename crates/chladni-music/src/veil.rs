//! A veil toward black or white over a picture.

/// A film of black or white over the whole picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Veil {
    /// Nothing.
    #[default]
    Clear,
    /// Black of this opacity.
    Black(u8),
    /// White of this opacity.
    White(u8),
}

impl Veil {
    /// Black of this opacity, or nothing.
    pub fn black(opacity: u8) -> Self {
        if opacity == 0 { Self::Clear } else { Self::Black(opacity) }
    }

    /// An sRGB-encoded value under the veil; blended on the encoded values, as windows do.
    pub fn over(self, value: u8) -> u8 {
        let mix = |opacity: u8, with: u32| {
            let opacity = u32::from(opacity);
            ((opacity * with + (255 - opacity) * u32::from(value) + 127) / 255) as u8
        };
        match self {
            Self::Clear => value,
            Self::Black(opacity) => mix(opacity, 0),
            Self::White(opacity) => mix(opacity, 255),
        }
    }
}
