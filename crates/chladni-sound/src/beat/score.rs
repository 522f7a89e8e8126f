//! A measure of how well beats agree with the truth.

/// Precision, recall and their harmonic mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeatScore {
    /// Share of the found beats that are true.
    pub precision: f64,
    /// Share of the true beats that were found.
    pub recall: f64,
    /// 2 · precision · recall / (precision + recall).
    pub f_measure: f64,
}

/// Compares found and true beats (both ascending, in seconds), which are matched one to one within
/// ±`window_secs`. The customary window is 0.07.
pub fn beat_score(found: &[f64], truth: &[f64], window_secs: f64) -> BeatScore {
    let (mut i, mut j, mut hits) = (0, 0, 0usize);
    while i < found.len() && j < truth.len() {
        let off = found[i] - truth[j];
        if off.abs() <= window_secs {
            hits += 1;
            i += 1;
            j += 1;
        } else if off < 0.0 {
            i += 1;
        } else {
            j += 1;
        }
    }
    let share = |of: usize| if of == 0 { 0.0 } else { hits as f64 / of as f64 };
    let (precision, recall) = (share(found.len()), share(truth.len()));
    let f_measure = if hits == 0 { 0.0 } else { 2.0 * precision * recall / (precision + recall) };
    BeatScore { precision, recall, f_measure }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_by_hand() {
        let score = beat_score(&[0.0, 0.55, 1.02, 1.04], &[0.0, 0.5, 1.0, 1.5], 0.07);
        assert_eq!(score.precision, 0.75);
        assert_eq!(score.recall, 0.75);
        assert_eq!(score.f_measure, 0.75);
        assert_eq!(beat_score(&[], &[1.0], 0.07).f_measure, 0.0);
    }
}
