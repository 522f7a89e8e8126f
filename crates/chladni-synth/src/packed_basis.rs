//! The basis as 16-bit integers in panels of vertices.

use rayon::prelude::*;

use crate::SynthError;

/// Vertices per panel: in 16 bits each, one harmonic on one panel fills one cache line.
pub(crate) const PANEL: usize = 32;

/// The values of one harmonic on the vertices of a panel.
pub(crate) type Line = [i16; PANEL];

/// H, N×K, as H_k(v) ≈ scale_k · q_k(v) with q in ±32767 and scale_k = max |H_k| / 32767.
///
/// Against f16 this costs the same bytes and conversions, but its error is at most
/// scale_k / 2 everywhere, where f16 errs up to 32 times as much at the peaks of a harmonic.
/// Layout: panel p holds vertices 32p … 32p+31, harmonic after harmonic; the last panel is padded with
/// zeros.
#[derive(Debug)]
pub(crate) struct PackedBasis {
    lines: Vec<Line>,
    scales: Vec<f64>,
    vertices: usize,
}

impl PackedBasis {
    /// Packs an N×K column-major matrix.
    pub fn new(vertices: usize, basis: &[f64]) -> Result<Self, SynthError> {
        if vertices == 0 && basis.is_empty() {
            return Ok(Self { lines: Vec::new(), scales: Vec::new(), vertices });
        }
        if vertices == 0 || !basis.len().is_multiple_of(vertices) {
            return Err(SynthError::BasisShape { vertices, found: basis.len() });
        }
        let scales: Vec<f64> = basis
            .par_chunks(vertices)
            .enumerate()
            .map(|(index, h)| {
                let finite = h.iter().all(|h| h.is_finite());
                let peak = h.iter().fold(0.0_f64, |peak, h| peak.max(h.abs()));
                if finite {
                    Ok(peak / f64::from(i16::MAX))
                } else {
                    Err(SynthError::NotFinite { what: "harmonic", index })
                }
            })
            .collect::<Result<_, _>>()?;
        let harmonics = scales.len();
        let inverse: Vec<f64> = scales.iter().map(|&s| if s > 0.0 { 1.0 / s } else { 0.0 }).collect();
        let mut lines = vec![[0; PANEL]; vertices.div_ceil(PANEL) * harmonics];
        lines.par_chunks_mut(harmonics.max(1)).enumerate().for_each(|(panel, lines)| {
            let first = panel * PANEL;
            let count = PANEL.min(vertices - first);
            for (k, line) in lines.iter_mut().enumerate() {
                let h = &basis[k * vertices + first..][..count];
                // `as` saturates: rounding beyond the range is harmless.
                line.iter_mut().zip(h).for_each(|(q, h)| *q = (h * inverse[k]).round() as i16);
            }
        });
        Ok(Self { lines, scales, vertices })
    }

    pub fn harmonics(&self) -> usize {
        self.scales.len()
    }

    /// The number of panels of [`PANEL`] vertices, including the padded last one.
    pub fn panels(&self) -> usize {
        self.vertices.div_ceil(PANEL)
    }

    /// The K lines of one panel.
    pub fn panel(&self, panel: usize) -> &[Line] {
        let harmonics = self.harmonics();
        &self.lines[panel * harmonics..][..harmonics]
    }

    /// The lines of a range of panels.
    #[cfg(feature = "gpu")]
    pub fn lines(&self, panels: std::ops::Range<usize>) -> &[Line] {
        let harmonics = self.harmonics();
        &self.lines[panels.start * harmonics..panels.end * harmonics]
    }

    /// scale_k, K values.
    pub fn scales(&self) -> &[f64] {
        &self.scales
    }

    pub fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
    }
}
