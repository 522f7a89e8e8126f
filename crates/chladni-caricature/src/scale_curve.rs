//! Φ: how much each scale of the difference contributes.

use chladni_harmonics::Basis;
use serde::{Deserialize, Serialize};

use crate::CaricatureError;
use crate::wavelength::{parse_wavelength, wavelengths};

/// Φ_k and Φ_d: a gain over the wavelength, as a share of the shape's [`size`](crate::size), and a gain for
/// all detail finer than the last harmonic.
///
/// The curve passes through its points and is monotone between neighbors (Fritsch & Carlson
/// 1980, over the logarithm of the wavelength), so it never overshoots what was drawn; beyond the outermost
/// points it is constant. Gains run from 0 (drop) over 1 (as is) to [`MAX_GAIN`](Self::MAX_GAIN). It means the
/// same whatever the number of harmonics, and the same on another mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Written")]
pub struct ScaleCurve {
    /// (wavelength, gain) from broad to fine: wavelengths fall, none twice.
    pub points: Vec<[f64; 2]>,
    /// Φ_d, the gain of the residual.
    pub residual: f64,
}

/// A curve in a file, where either may be missing.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    points: Option<Vec<[f64; 2]>>,
    residual: Option<f64>,
}

impl From<Written> for ScaleCurve {
    fn from(written: Written) -> Self {
        let points = written.points.unwrap_or_else(|| Self::default().points);
        let residual = written.residual.unwrap_or_else(|| last_gain(&points));
        Self { points, residual }
    }
}

/// The gain of the finest point, which the residual has where nothing else is said.
fn last_gain(points: &[[f64; 2]]) -> f64 {
    points.last().map_or(1.0, |p| p[1])
}

impl Default for ScaleCurve {
    fn default() -> Self {
        Self::flat(1.0)
    }
}

impl ScaleCurve {
    /// The largest gain; twice that of the paper's interface.
    pub const MAX_GAIN: f64 = 4.0;
    /// The longest wave a point may stand at: beyond the lowest harmonics of a ball (2.2).
    pub const BROADEST: f64 = 3.2;
    /// The shortest: near harmonic 6000 (Weyl).
    pub const FINEST: f64 = 0.04;

    /// The same gain for every harmonic and the residual.
    pub fn flat(gain: f64) -> Self {
        Self { points: vec![[Self::BROADEST, gain], [Self::FINEST, gain]], residual: gain }
    }

    /// All but the finest scales, where a match of two meshes is rough.
    pub fn smooth() -> Self {
        Self { points: vec![[0.28, 1.0], [0.14, 0.0]], residual: 0.0 }
    }

    /// Large forms only.
    pub fn broad() -> Self {
        Self { points: vec![[0.9, 1.0], [0.4, 0.0]], residual: 0.0 }
    }

    /// The middle: features of the size of a nose or a chin, amplified.
    pub fn mid() -> Self {
        Self {
            points: vec![[Self::BROADEST, 0.2], [0.9, 1.0], [0.46, 1.8], [0.28, 1.0], [0.17, 0.0]],
            residual: 0.0,
        }
    }

    /// Fine detail: wrinkles and edges, amplified; the large forms stay.
    pub fn fine() -> Self {
        Self { points: vec![[1.0, 0.0], [0.46, 0.1], [0.23, 1.0], [0.14, 1.8]], residual: 1.8 }
    }

    /// Whether every harmonic and the residual have the same gain.
    pub fn is_flat(&self) -> bool {
        self.points.iter().all(|p| p[1] == self.residual)
    }

    /// Checks that wavelengths fall within their range and gains lie in 0..=[`MAX_GAIN`](Self::MAX_GAIN).
    ///
    /// # Errors
    /// The first number that is out of its range.
    pub fn validate(&self) -> Result<(), CaricatureError> {
        let what = "a wavelength of the scale curve";
        for (i, &[wavelength, gain]) in self.points.iter().enumerate() {
            if !(Self::FINEST..=Self::BROADEST).contains(&wavelength) {
                return Err(CaricatureError::Range {
                    what,
                    value: wavelength,
                    range: "0.04 to 3.2 of the size",
                });
            }
            if i > 0 && wavelength >= self.points[i - 1][0] {
                return Err(CaricatureError::Range {
                    what,
                    value: wavelength,
                    range: "below the point before it",
                });
            }
            check_gain(gain)?;
        }
        check_gain(self.residual)
    }

    /// The gain at a wavelength.
    pub fn at(&self, wavelength: f64) -> f64 {
        let octaves_finer = |wavelength: f64| -wavelength.log2();
        let points = self.points.iter().map(|p| [octaves_finer(p[0]), p[1]]);
        monotone(points, octaves_finer(wavelength)).unwrap_or(self.residual)
    }

    /// Φ_k for every harmonic of `basis`.
    pub fn gains(&self, basis: &Basis) -> Vec<f64> {
        wavelengths(basis).into_iter().map(|wavelength| self.at(wavelength)).collect()
    }

    /// Puts a point at (wavelength, gain), clamped into range, in place of one at the same wavelength.
    /// Returns the point's index.
    pub fn set_point(&mut self, wavelength: f64, gain: f64) -> usize {
        let point = [wavelength.clamp(Self::FINEST, Self::BROADEST), gain.clamp(0.0, Self::MAX_GAIN)];
        let i = self.points.partition_point(|p| p[0] > point[0]);
        match self.points.get_mut(i).filter(|p| p[0] == point[0]) {
            Some(there) => *there = point,
            None => self.points.insert(i, point),
        }
        i
    }

    /// Draws freely from one (wavelength, gain) to another: the points between are replaced by the two ends.
    pub fn draw(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (low, high) = (from[0].min(to[0]), from[0].max(to[0]));
        self.points.retain(|p| p[0] < low || p[0] > high);
        self.set_point(from[0], from[1]);
        self.set_point(to[0], to[1]);
    }
}

/// The value at `x` of the curve through `points`, whose x ascend, that is monotone between neighbors and
/// constant beyond the outermost; `None` without points.
pub(crate) fn monotone(points: impl Iterator<Item = [f64; 2]> + Clone, x: f64) -> Option<f64> {
    let right = points.clone().take_while(|p| p[0] <= x).count();
    // The neighbors, and theirs.
    let from = right.saturating_sub(2);
    let mut near = [None; 4];
    points.skip(from).zip(&mut near[from + 2 - right..]).for_each(|(p, place)| *place = Some(p));
    let [before, left, right, after] = near;
    let (Some(left), Some(right)) = (left, right) else { return left.or(right).map(|p| p[1]) };
    let width = right[0] - left[0];
    let t = (x - left[0]) / width;
    let (t2, t3) = (t * t, t * t * t);
    Some(
        (2.0 * t3 - 3.0 * t2 + 1.0) * left[1]
            + (t3 - 2.0 * t2 + t) * width * tangent(before, left, Some(right))
            + (3.0 * t2 - 2.0 * t3) * right[1]
            + (t3 - t2) * width * tangent(Some(left), right, after),
    )
}

/// The weighted harmonic mean of the slopes to both neighbors, or 0 at extrema and ends, which keeps the
/// curve monotone between points.
fn tangent(before: Option<[f64; 2]>, here: [f64; 2], after: Option<[f64; 2]>) -> f64 {
    let (Some(before), Some(after)) = (before, after) else { return 0.0 };
    let (w0, w1) = (here[0] - before[0], after[0] - here[0]);
    let (s0, s1) = ((here[1] - before[1]) / w0, (after[1] - here[1]) / w1);
    if s0 * s1 <= 0.0 {
        return 0.0;
    }
    let (a, b) = (2.0 * w1 + w0, w1 + 2.0 * w0);
    (a + b) / (a / s0 + b / s1)
}

fn check_gain(gain: f64) -> Result<(), CaricatureError> {
    if (0.0..=ScaleCurve::MAX_GAIN).contains(&gain) {
        Ok(())
    } else {
        Err(CaricatureError::Range { what: "a gain of the scale curve", value: gain, range: "0 to 4" })
    }
}

/// `flat`, `smooth`, `broad`, `mid`, `fine`, or points `wavelength%:gain,…` from broad to fine and optionally
/// `d:gain` for the residual (the last point's gain where it is not given).
impl std::str::FromStr for ScaleCurve {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        match text.trim() {
            "flat" => return Ok(Self::flat(1.0)),
            "smooth" => return Ok(Self::smooth()),
            "broad" => return Ok(Self::broad()),
            "mid" => return Ok(Self::mid()),
            "fine" => return Ok(Self::fine()),
            _ => {}
        }
        let bad = |why: &str| CaricatureError::syntax("scale curve", text, why);
        let number = |t: &str| t.trim().parse::<f64>().map_err(|_| bad(&format!("`{t}` is not a number")));
        let mut curve = Self { points: Vec::new(), residual: 1.0 };
        let mut residual = None;
        for part in text.split(',') {
            let (at, gain) = part.split_once(':').ok_or_else(|| {
                bad("write flat, smooth, broad, mid, fine or points as wavelength:gain,… such as 90%:1,40%:0,d:0")
            })?;
            if at.trim() == "d" {
                residual = Some(number(gain)?);
                continue;
            }
            let wavelength = parse_wavelength(at).ok_or_else(|| {
                bad(&format!("`{at}` is no wavelength: write percent of the size, such as 40%"))
            })?;
            curve.points.push([wavelength, number(gain)?]);
        }
        curve.residual = residual.unwrap_or_else(|| last_gain(&curve.points));
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
                    let wavelength = pair[0][0] * (pair[1][0] / pair[0][0]).powf(i as f64 / 50.0);
                    let (low, high) = (pair[0][1].min(pair[1][1]), pair[0][1].max(pair[1][1]));
                    assert!((low - 1e-12..=high + 1e-12).contains(&curve.at(wavelength)), "{wavelength}");
                }
            }
            assert_eq!(curve.at(f64::INFINITY), curve.points[0][1]);
        }
    }

    #[test]
    fn is_parsed_as_typed_and_refused_with_a_reason() {
        let curve: ScaleCurve = "200%:0, 50%:2, 10 %:1, d:0.25".parse().unwrap();
        assert_eq!(curve.points, vec![[2.0, 0.0], [0.5, 2.0], [0.1, 1.0]]);
        assert_eq!(curve.residual, 0.25);
        assert_eq!("broad".parse::<ScaleCurve>().unwrap(), ScaleCurve::broad());
        // Including the syntax from before wavelengths.
        let refused = [
            "",
            "loud",
            "0:1,0.4:2,1:0,d:0",
            "50%:1,50%:2",
            "50%:9",
            "400%:1",
            "50%:x",
            "20%:1,50%:1",
            "50%:1,d:nan",
            "50%:nan",
        ];
        for bad in refused {
            assert!(bad.parse::<ScaleCurve>().is_err(), "{bad}");
        }
    }

    #[test]
    fn drawing_replaces_what_lies_between() {
        let mut curve = ScaleCurve::mid();
        curve.draw([0.25, 0.5], [1.5, 3.0]);
        curve.validate().unwrap();
        assert_eq!(curve.points, vec![[ScaleCurve::BROADEST, 0.2], [1.5, 3.0], [0.25, 0.5], [0.17, 0.0]]);
        assert_eq!(curve.set_point(0.25, 9.0), 2);
        assert_eq!(curve.points[2], [0.25, ScaleCurve::MAX_GAIN]);
        assert_eq!(curve.set_point(0.0, 1.0), 4);
        curve.validate().unwrap();
    }

    #[test]
    fn a_curve_means_the_same_with_twice_as_many_harmonics() {
        let (body, _) = crate::fixture::bumpy_sphere();
        let many = body.basis.clone();
        let few = crate::fixture::fewer(&many, 25);
        for curve in [ScaleCurve::smooth(), ScaleCurve::mid(), ScaleCurve::fine()] {
            assert_eq!(curve.gains(&few), curve.gains(&many)[..25]);
        }
    }
}
