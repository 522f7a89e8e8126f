//! What Symphonia asserts and a damaged file contradicts, such as how many values a lattice of Vorbis has in Ogg.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::SoundError;

/// Does a part of the decoding; a panic in it is damage of the file. What panicked is not to be trusted with more than being
/// dropped, or asked again.
pub(super) fn caught<T>(name: &str, work: impl FnOnce() -> T) -> Result<T, SoundError> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| SoundError::Damaged {
        name: name.to_owned(),
        what: "its headers contradict each other".to_owned(),
    })
}
