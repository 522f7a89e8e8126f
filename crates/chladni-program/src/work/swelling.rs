//! Caricatures that swell out of their shape and back, all together, for the galleries of the window and of the page.

use std::f64::consts::TAU;
use std::sync::Arc;

use chladni_synth::{
    Coefficients, CpuSynthesizer, FrameSettings, Item, Residual, SynthModel, Synthesizer, Term,
};

use super::Error;

/// One swelling from the shape to the caricature and back.
const BREATH_SECS: f64 = 4.0;

/// How far figures have swollen at a time, from the shape (0) to the caricature (1).
pub fn swollen_at(at_secs: f64) -> f32 {
    (0.5 - 0.5 * (TAU * at_secs / BREATH_SECS).cos()) as f32
}

/// Caricatures of one shape, between it and themselves.
#[allow(missing_debug_implementations, reason = "it holds a synthesizer")]
pub struct Swelling {
    synthesizer: CpuSynthesizer,
    items: Vec<Item>,
    /// How far they have swollen in the last frame.
    swollen: Option<f32>,
}

impl Swelling {
    /// Caricatures of the shape in `model`; nothing swells yet.
    pub fn new(model: SynthModel) -> Self {
        Self { synthesizer: CpuSynthesizer::new(model), items: Vec::new(), swollen: None }
    }

    /// These swell from now on: the vertices of each.
    pub fn hang<'a>(&mut self, figures: impl IntoIterator<Item = &'a [[f32; 3]]>) {
        let rest = self.synthesizer.model().rest_positions();
        let item = |figure: &[[f32; 3]]| {
            let moved = figure.iter().zip(rest);
            let moved: Arc<[[f32; 3]]> =
                moved.map(|(a, b): (&[f32; 3], &[f32; 3])| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]).collect();
            let residual = Some(Residual::Vector(moved));
            let coefficients = Coefficients::Vector(Vec::new());
            Item { terms: vec![Term { coefficients, residual, residual_gain: 1.0, mask: None }] }
        };
        self.items = figures.into_iter().map(item).collect();
        self.swollen = None;
    }

    /// Others are to be hung.
    pub fn clear(&mut self) {
        (self.items, self.swollen) = (Vec::new(), None);
    }

    /// Whether nothing hangs.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The vertices of all of them, one after the other, as they were in the last frame.
    pub fn positions(&self) -> &[[f32; 3]] {
        self.synthesizer.all_positions()
    }

    /// Swells all of them to a share, in one frame of the synthesizer; none where they have swollen as far already.
    ///
    /// # Errors
    /// Errors of the synthesizer.
    pub fn swell(&mut self, share: f32) -> Result<Option<&CpuSynthesizer>, Error> {
        if self.swollen == Some(share) {
            return Ok(None);
        }
        self.items.iter_mut().flat_map(|item| &mut item.terms).for_each(|term| term.residual_gain = share);
        self.synthesizer.synthesize(&self.items, &FrameSettings::default())?;
        self.swollen = Some(share);
        Ok(Some(&self.synthesizer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_swell_from_the_shape_to_the_caricature_and_back() {
        let mesh = chladni_mesh::samples::icosphere(2);
        let model = SynthModel::from_parts(&mesh.positions, &mesh.triangles, &[]).unwrap();
        let rest = model.rest_positions().to_vec();
        let twice: Vec<[f32; 3]> = rest.iter().map(|p| p.map(|c| 2.0 * c)).collect();
        let mut swelling = Swelling::new(model);
        swelling.hang([rest.as_slice(), twice.as_slice()]);
        for (at_secs, size) in [(0.0, 1.0), (2.0, 2.0), (4.0, 1.0)] {
            let frame = swelling.swell(swollen_at(at_secs)).unwrap().unwrap();
            for (still, swollen) in rest.iter().zip(frame.positions(1)) {
                assert!((0..3).all(|i| (size * still[i] - swollen[i]).abs() < 1e-5), "{at_secs}");
            }
            assert_eq!(frame.positions(0)[5], rest[5]);
        }
        assert!(swelling.swell(swollen_at(8.0)).unwrap().is_none());
    }
}
