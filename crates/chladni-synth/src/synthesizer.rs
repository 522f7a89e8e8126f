//! The interface of all backends.

use crate::{Item, SynthError, SynthModel};

/// Settings for all items of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameSettings {
    /// The weight of the rest normal in the drawn normal, in [0, 1]: 0 gives the exact normal of the
    /// deformed mesh, ½ the music paper's "normal enhancement", 1 the rest normal.
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

/// Computes S·N deformed positions and as many normals from S items. Where the results are stored depends
/// on the backend.
///
/// All items of a frame are computed in one pass over the basis. Items may differ in form and in the number
/// of terms. After an error, the last frame may be partly overwritten.
pub trait Synthesizer {
    /// The shape that is deformed.
    fn model(&self) -> &SynthModel;

    /// Deforms another shape from now on. The next frame exists after the next call of a `synthesize`
    /// function.
    ///
    /// # Errors
    /// The device has no room for the model; the old shape then stays.
    fn replace_model(&mut self, model: SynthModel) -> Result<(), SynthError>;

    /// S, the number of items in the last frame.
    fn items(&self) -> usize;

    /// Computes the positions of all items.
    ///
    /// # Errors
    /// A coefficient or gain that is NaN or infinite, more coefficients than harmonics, or a mask or
    /// residual that does not have N values of the right form. The values of masks and residuals are not
    /// checked for NaN.
    fn synthesize_positions(&mut self, items: &[Item]) -> Result<(), SynthError>;

    /// Computes the normals of the positions that were synthesized last.
    ///
    /// # Errors
    /// A blending outside [0, 1].
    fn synthesize_normals(&mut self, settings: &FrameSettings) -> Result<(), SynthError>;

    /// Computes a whole frame: positions, then normals.
    ///
    /// # Errors
    /// Those of [`synthesize_positions`](Self::synthesize_positions) and
    /// [`synthesize_normals`](Self::synthesize_normals).
    fn synthesize(&mut self, items: &[Item], settings: &FrameSettings) -> Result<(), SynthError> {
        settings.check()?;
        self.synthesize_positions(items)?;
        self.synthesize_normals(settings)
    }
}
