//! The coefficients of every frame, for scripts: those of the mapping, without voices.

use std::path::Path;

use chladni_music::Form;
use chladni_synth::{Coefficients, Item};

use chladni_harmonics::npz::write_npz;

/// Coefficients of the first item, frame by frame.
#[derive(Default)]
pub struct Recording {
    times_secs: Vec<f64>,
    /// Per term, K×3 or K numbers a frame.
    terms: Vec<Vec<f32>>,
    channels: u64,
}

impl Recording {
    /// Adds the frame of `time_secs`, played in `form`.
    pub fn push(&mut self, time_secs: f64, form: Form, item: &Item) {
        self.times_secs.push(time_secs);
        let own = &item.terms[..form.terms().min(item.terms.len())];
        self.terms.resize(own.len().max(self.terms.len()), Vec::new());
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
    }

    /// Writes `times_secs` and `coefficients` (frames×K×3, or frames×K in the modal form). The
    /// half-mask form's are those of the left half; `coefficients_right` stands beside.
    ///
    /// Fails where the form or the number of harmonics changed within the film.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let frames = self.times_secs.len() as u64;
        let per_frame = |values: &[f32]| values.len() as u64 / frames.max(1);
        let uneven =
            self.terms.iter().any(|v| !(v.len() as u64).is_multiple_of(frames.max(1) * self.channels.max(1)));
        if uneven || self.terms.windows(2).any(|pair| pair[0].len() != pair[1].len()) {
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
            Ok(())
        })
    }
}
