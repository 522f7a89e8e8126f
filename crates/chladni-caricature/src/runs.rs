//! Painted values as run-length text: `1200*0 35*1 0.5` is 1200 zeros, 35 ones and a half.

use std::fmt::Write;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serializer};

use crate::CaricatureError;

/// The most values of a text, and of all layers of a project: 256 MiB, since a few bytes may stand for any number.
/// A longer text is refused before anything is allocated for it.
pub(crate) const MOST_VALUES: usize = 1 << 26;

/// `values` as text. Every value is read back bit for bit.
pub(crate) fn to_text(values: &[f32]) -> String {
    let mut text = String::new();
    for run in values.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
        if !text.is_empty() {
            text.push(' ');
        }
        // Writing to a String cannot fail.
        let _ = if run.len() == 1 {
            write!(text, "{}", run[0])
        } else {
            write!(text, "{}*{}", run.len(), run[0])
        };
    }
    text
}

/// The values of a run-length text; each must lie in [0, 1].
pub(crate) fn from_text(text: &str) -> Result<Arc<[f32]>, CaricatureError> {
    let bad = |run: &str, why: &str| CaricatureError::syntax("painted region", run, why);
    let mut values: Vec<f32> = Vec::new();
    for run in text.split_whitespace() {
        let (count, value) = run.split_once('*').unwrap_or(("1", run));
        let count: usize = count.parse().map_err(|_| bad(run, "the count is not a number"))?;
        let value: f32 = value.parse().map_err(|_| bad(run, "the value is not a number"))?;
        if !(0.0..=1.0).contains(&value) {
            return Err(bad(run, "values lie between 0 and 1"));
        }
        if count > MOST_VALUES - values.len() {
            return Err(bad(run, "more painted values than are read"));
        }
        values.resize(values.len() + count, value);
    }
    Ok(values.into())
}

pub(crate) fn serialize<S: Serializer>(values: &Arc<[f32]>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&to_text(values))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<[f32]>, D::Error> {
    let text = String::deserialize(deserializer)?;
    from_text(&text).map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_was_painted_is_read_back(runs in prop::collection::vec((0_f32..=1.0, 1..9_usize), 0..40)) {
            let values: Vec<f32> = runs.iter().flat_map(|(v, n)| std::iter::repeat_n(*v, *n)).collect();
            prop_assert_eq!(&*from_text(&to_text(&values)).unwrap(), &values[..]);
        }

        #[test]
        fn any_text_is_an_answer_or_an_error(text in "[-0-9.*eE nainf]{0,40}") {
            if let Ok(values) = from_text(&text) {
                prop_assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
            }
        }
    }

    #[test]
    fn a_count_beyond_all_meshes_is_refused() {
        assert!(from_text("99999999999*0.5").is_err());
        assert!(from_text("67108864*1 1").is_err());
        assert!(from_text("3*NaN").is_err());
        assert_eq!(to_text(&[0.0, 0.0, 1.0, 0.5, 0.5]), "2*0 1 2*0.5");
    }
}
