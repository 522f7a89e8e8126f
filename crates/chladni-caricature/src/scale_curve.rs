//! Φ: how much each scale of the difference contributes.

use chladni_harmonics::Basis;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Φ_k and Φ_d: a gain over normalised frequency u = ω_k / ω_{K−1} ∈ [0, 1], and a gain for all
/// that lies above K.
///
/// The curve passes through its points and is monotone between neighbours (Fritsch & Carlson
/// 1980), so it never overshoots what was drawn; outside the outermost points it is constant.
/// Gains run from 0 (drop) over 1 (as is) to [`MAX_GAIN`](Self::MAX_GAIN). Since it is defined over normalised
/// frequency, the same curve means the same on another mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleCurve {
    /// (u, gain), ascending in u, no u twice.
    pub points: Vec<[f64; 2]>,
    /// Φ_d, the gain of the residual.
    pub residual: f64,
}

impl Default for ScaleCurve {
    fn default() -> Self {
        Self::flat(1.0)
    }
}

impl ScaleCurve {
    /// The largest gain; twice what the paper's interface offers.
    pub const MAX_GAIN: f64 = 4.0;

    /// The same gain for every harmonic and the residual.
    pub fn flat(gain: f64) -> Self {
        Self { points: vec![[0.0, gain], [1.0, gain]], residual: gain }
    }

    /// All but the finest: what a match of two meshes leaves rough lies there.
    pub fn smooth() -> Self {
        Self { points: vec![[0.0, 1.0], [0.5, 1.0], [1.0, 0.0]], residual: 0.0 }
    }

    /// Large forms only: full gain at low frequency, nothing above a third of the range.
    pub fn broad() -> Self {
        Self { points: vec![[0.0, 1.0], [0.15, 1.0], [0.35, 0.0], [1.0, 0.0]], residual: 0.0 }
    }

    /// The middle: features of the size of a nose or a chin, amplified.
    pub fn mid() -> Self {
        Self { points: vec![[0.0, 0.2], [0.15, 1.0], [0.3, 1.8], [0.5, 1.0], [0.8, 0.0]], residual: 0.0 }
    }

    /// Fine detail: wrinkles and edges, amplified; the large forms stay.
    pub fn fine() -> Self {
        Self { points: vec![[0.0, 0.0], [0.3, 0.1], [0.6, 1.0], [1.0, 1.8]], residual: 1.8 }
    }

    /// Whether every harmonic and the residual have the same gain.
    pub fn is_flat(&self) -> bool {
        self.points.iter().all(|p| p[1] == self.residual)
    }

    /// Checks that points ascend and gains lie in 0..=[`MAX_GAIN`](Self::MAX_GAIN).
    pub fn validate(&self) -> Result<(), Error> {
        for (i, &[u, gain]) in self.points.iter().enumerate() {
            if !(0.0..=1.0).contains(&u) {
                return Err(Error::Range {
                    what: "a frequency of the scale curve",
                    value: u,
                    range: "0 to 1",
                });
            }
            if i > 0 && u <= self.points[i - 1][0] {
                let range = "above the point before it";
                return Err(Error::Range { what: "a frequency of the scale curve", value: u, range });
            }
            check_gain(gain)?;
        }
        check_gain(self.residual)
    }

    /// The gain at normalised frequency `u`.
    pub fn at(&self, u: f64) -> f64 {
        let p = &self.points;
        let right = p.partition_point(|q| q[0] <= u);
        match (right.checked_sub(1).and_then(|i| p.get(i)), p.get(right)) {
            (None, None) => self.residual,
            (Some(q), None) | (None, Some(q)) => q[1],
            (Some(a), Some(b)) => {
                let i = right - 1;
                let width = b[0] - a[0];
                let t = (u - a[0]) / width;
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * a[1]
                    + (t3 - 2.0 * t2 + t) * width * self.slope(i)
                    + (3.0 * t2 - 2.0 * t3) * b[1]
                    + (t3 - t2) * width * self.slope(right)
            }
        }
    }

    /// The tangent at point `i`: the weighted harmonic mean of its neighbours' slopes, and level
    /// at extrema and ends, which keeps the curve monotone between points.
    fn slope(&self, i: usize) -> f64 {
        let p = &self.points;
        if i == 0 || i + 1 >= p.len() {
            return 0.0;
        }
        let (w0, w1) = (p[i][0] - p[i - 1][0], p[i + 1][0] - p[i][0]);
        let (s0, s1) = ((p[i][1] - p[i - 1][1]) / w0, (p[i + 1][1] - p[i][1]) / w1);
        if s0 * s1 <= 0.0 {
            return 0.0;
        }
        let (a, b) = (2.0 * w1 + w0, w1 + 2.0 * w0);
        (a + b) / (a / s0 + b / s1)
    }

    /// Φ_k for every harmonic of `basis`.
    pub fn gains(&self, basis: &Basis) -> Vec<f64> {
        (0..basis.harmonics()).map(|k| self.at(normalised_frequency(basis, k))).collect()
    }

    /// Puts a point at (u, gain), clamped into range, in place of one that lies within
    /// `tolerance` of u. Returns the point's index.
    pub fn set_point(&mut self, u: f64, gain: f64, tolerance: f64) -> usize {
        let point = [u.clamp(0.0, 1.0), gain.clamp(0.0, Self::MAX_GAIN)];
        let near = self.points.iter().position(|p| (p[0] - point[0]).abs() <= tolerance);
        match near {
            Some(i) => {
                self.points[i][1] = point[1];
                i
            }
            None => {
                let i = self.points.partition_point(|p| p[0] < point[0]);
                self.points.insert(i, point);
                i
            }
        }
    }

    /// Draws freely from (u, gain) to (u, gain): the points between are replaced by the two ends.
    pub fn draw(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (low, high) = (from[0].min(to[0]), from[0].max(to[0]));
        self.points.retain(|p| p[0] < low || p[0] > high);
        self.set_point(from[0], from[1], 0.0);
        self.set_point(to[0], to[1], 0.0);
    }
}

/// u = ω_k / ω_{K−1}; 0 where the basis has no frequency above 0.
pub fn normalised_frequency(basis: &Basis, k: usize) -> f64 {
    let omega = |k: usize| basis.eigenvalues.get(k).map_or(0.0, |l| l.max(0.0).sqrt());
    let top = omega(basis.harmonics().saturating_sub(1));
    if top > 0.0 { (omega(k) / top).min(1.0) } else { 0.0 }
}

fn check_gain(gain: f64) -> Result<(), Error> {
    if (0.0..=ScaleCurve::MAX_GAIN).contains(&gain) {
        Ok(())
    } else {
        Err(Error::Range { what: "a gain of the scale curve", value: gain, range: "0 to 4" })
    }
}

/// `flat`, `smooth`, `broad`, `mid`, `fine`, or points `u:gain,u:gain,…` and optionally `d:gain` for the
/// residual (the last point's gain where it is not given).
impl std::str::FromStr for ScaleCurve {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text.trim() {
            "flat" => return Ok(Self::flat(1.0)),
            "smooth" => return Ok(Self::smooth()),
            "broad" => return Ok(Self::broad()),
            "mid" => return Ok(Self::mid()),
            "fine" => return Ok(Self::fine()),
            _ => {}
        }
        let bad = |why: &str| Error::syntax("scale curve", text, why);
        let number = |t: &str| t.trim().parse::<f64>().map_err(|_| bad(&format!("`{t}` is not a number")));
        let mut curve = Self { points: Vec::new(), residual: f64::NAN };
        for part in text.split(',') {
            let (u, gain) = part.split_once(':').ok_or_else(|| {
                bad("write flat, smooth, broad, mid, fine or points as frequency:gain,… with frequency from 0 to 1")
            })?;
            if u.trim() == "d" {
                curve.residual = number(gain)?;
            } else {
                curve.points.push([number(u)?, number(gain)?]);
            }
        }
        if curve.residual.is_nan() {
            curve.residual = curve.points.last().map_or(1.0, |p| p[1]);
        }
        curve.validate()?;
        Ok(curve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_through_its_points_and_never_overshoots() {
        for curve in [ScaleCurve::smooth(), ScaleCurve::broad(), ScaleCurve::mid(), ScaleCurve::fine()] {
            curve.validate().unwrap();
            for p in &curve.points {
                assert!((curve.at(p[0]) - p[1]).abs() < 1e-12);
            }
            for pair in curve.points.windows(2) {
                for i in 0..=50 {
                    let u = pair[0][0] + (pair[1][0] - pair[0][0]) * i as f64 / 50.0;
                    let (low, high) = (pair[0][1].min(pair[1][1]), pair[0][1].max(pair[1][1]));
                    assert!((low - 1e-12..=high + 1e-12).contains(&curve.at(u)), "{u}");
                }
            }
        }
    }

    #[test]
    fn is_parsed_as_typed_and_refused_with_a_reason() {
        let curve: ScaleCurve = "0:0, 0.5:2, 1:1, d:0.25".parse().unwrap();
        assert_eq!(curve.points, vec![[0.0, 0.0], [0.5, 2.0], [1.0, 1.0]]);
        assert_eq!(curve.residual, 0.25);
        assert_eq!("broad".parse::<ScaleCurve>().unwrap(), ScaleCurve::broad());
        for bad in ["", "loud", "0:1,0:2", "0:9", "2:1", "0:x", "0.5:1,0.2:1", "0:NaN"] {
            assert!(bad.parse::<ScaleCurve>().is_err(), "{bad}");
        }
    }

    #[test]
    fn drawing_replaces_what_lies_between() {
        let mut curve = ScaleCurve::mid();
        curve.draw([0.7, 0.5], [0.1, 3.0]);
        curve.validate().unwrap();
        assert_eq!(curve.points, vec![[0.0, 0.2], [0.1, 3.0], [0.7, 0.5], [0.8, 0.0]]);
        curve.set_point(0.71, 9.0, 0.02);
        assert_eq!(curve.points[2], [0.7, ScaleCurve::MAX_GAIN]);
        curve.validate().unwrap();
    }
}
