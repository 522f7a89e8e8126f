//! What every backend does.

use crate::{Item, SynthError, SynthModel};

/// Settings for all items of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameSettings {
    /// The weight of the rest normal in the drawn normal, in [0, 1]: 0 is the exact normal of
    /// the deformed mesh, ½ the music paper's "normal enhancement", 1 the rest normal.
    pub normal_blending: f32,
}

impl FrameSettings {
    pub(crate) fn check(&self) -> Result<(), SynthError> {
        if (0.0..=1.0).contains(&self.normal_blending) {
            Ok(())
        } else {
            Err(SynthError::NormalBlending(self.normal_blending))
        }
    }
}

/// Turns items into S·N deformed positions and as many normals, where its backend keeps them.
///
/// All items of a frame are computed in one pass over the basis; items may differ in form and
/// in number of terms. On an error the last frame may be partly overwritten.
pub trait Synthesizer {
    /// The shape that is deformed.
    fn model(&self) -> &SynthModel;

    /// Deforms another shape from now on. There is no frame until the next call.
    ///
    /// # Errors
    /// A device that has no room for it; the old shape then stays.
    fn replace_model(&mut self, model: SynthModel) -> Result<(), SynthError>;

    /// S, the number of items of the last frame.
    fn items(&self) -> usize;

    /// Positions of all items.
    ///
    /// # Errors
    /// A coefficient or a gain that is NaN or infinite, more coefficients than harmonics, a mask or a residual that is
    /// not N values of the right form. Masks and residuals themselves are not searched for NaN.
    fn synthesize_positions(&mut self, items: &[Item]) -> Result<(), SynthError>;

    /// Normals of the positions that were last synthesized.
    ///
    /// # Errors
    /// A blending that is not in [0, 1].
    fn synthesize_normals(&mut self, settings: &FrameSettings) -> Result<(), SynthError>;

    /// A whole frame: positions, then normals.
    ///
    /// # Errors
    /// As [`synthesize_positions`](Self::synthesize_positions) and [`synthesize_normals`](Self::synthesize_normals).
    fn synthesize(&mut self, items: &[Item], settings: &FrameSettings) -> Result<(), SynthError> {
        settings.check()?;
        self.synthesize_positions(items)?;
        self.synthesize_normals(settings)
    }
}
