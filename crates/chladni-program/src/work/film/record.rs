//! The coefficients of every frame, for scripts: those of the mapping, without voices.

use std::path::Path;
use std::sync::Arc;

use chladni_music::Form;
use chladni_synth::{Coefficients, Item};

use chladni_harmonics::npz::write_npz;

/// Coefficients of the first item, frame by frame.
#[derive(Default)]
pub struct Recording {
    times_secs: Vec<f64>,
    /// Per term, K×3 or K numbers a frame.
    terms: Vec<Vec<f32>>,
    /// χ of each term that has one.
    masks: Vec<Option<Arc<[f32]>>>,
    channels: u64,
    /// Terms, channels and numbers of the first frame, and whether another has others.
    first: Option<[usize; 3]>,
    is_uneven: bool,
}

impl Recording {
    /// Adds the frame of `time_secs`, played in `form`.
    pub fn push(&mut self, time_secs: f64, form: Form, item: &Item) {
        let before: usize = self.terms.iter().map(Vec::len).sum();
        self.times_secs.push(time_secs);
        let own = &item.terms[..form.terms().min(item.terms.len())];
        self.terms.resize(own.len().max(self.terms.len()), Vec::new());
        if self.masks.is_empty() {
            self.masks = own.iter().map(|term| term.mask.clone()).collect();
        }
        for (values, term) in self.terms.iter_mut().zip(own) {
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    self.channels = 3;
                    values.extend(c.iter().flatten());
                }
                Coefficients::Normal(c) => {
                    self.channels = 1;
                    values.extend(c);
                }
            }
        }
        let numbers = self.terms.iter().map(Vec::len).sum::<usize>() - before;
        let shape = [own.len(), self.channels as usize, numbers];
        self.is_uneven |= *self.first.get_or_insert(shape) != shape;
    }

    /// Writes `times_secs` and `coefficients` (frames×K×3, or frames×K in the modal form). The
    /// half-mask form's are those of the left half; `coefficients_right` stands beside. `mask` and `mask_right` are
    /// what the movement by each is multiplied with at the N vertices of the harmonics.
    ///
    /// Fails where the form or the number of harmonics changed within the film.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let frames = self.times_secs.len() as u64;
        let per_frame = |values: &[f32]| values.len() as u64 / frames.max(1);
        if self.is_uneven {
            return Err(std::io::Error::other(
                "the form changed within the film, so that frames have no common shape",
            ));
        }
        write_npz(path, |npz| {
            npz.array("times_secs", &[frames], self.times_secs.iter().copied())?;
            for (values, name) in self.terms.iter().zip(["coefficients", "coefficients_right"]) {
                let k = per_frame(values) / self.channels.max(1);
                let shape = [frames, k, 3];
                let shape = if self.channels == 3 { &shape[..] } else { &shape[..2] };
                npz.array(name, shape, values.iter().copied())?;
            }
            for (mask, name) in self.masks.iter().zip(["mask", "mask_right"]) {
                if let Some(mask) = mask {
                    npz.array(name, &[mask.len() as u64], mask.iter().copied())?;
                }
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use chladni_synth::Term;

    use super::*;

    #[test]
    fn frames_of_other_forms_or_sizes_have_no_common_shape() {
        let item = |coefficients| Item {
            terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }],
        };
        let [filter, modal] =
            [Coefficients::Vector(vec![[0.5; 3]; 4]), Coefficients::Normal(vec![0.5; 4])].map(item);
        let short = item(Coefficients::Normal(vec![0.5; 2]));
        let folder = tempfile::tempdir().unwrap();
        let written = |frames: &[(Form, &Item)]| {
            let mut recording = Recording::default();
            for (i, (form, item)) in frames.iter().enumerate() {
                recording.push(i as f64, *form, item);
            }
            recording.write(&folder.path().join("c.npz"))
        };
        assert!(written(&[(Form::Filter, &filter), (Form::Filter, &filter)]).is_ok());
        // 32 numbers in four frames: as many as four of 4 × 2, or of 8.
        let changed =
            [(Form::Filter, &filter), (Form::Filter, &filter), (Form::Modal, &modal), (Form::Modal, &modal)];
        assert!(written(&changed).unwrap_err().to_string().contains("form changed"));
        assert!(written(&[(Form::Modal, &modal), (Form::Modal, &short), (Form::Modal, &short)]).is_err());
        assert!(written(&[]).is_ok());
    }
}
