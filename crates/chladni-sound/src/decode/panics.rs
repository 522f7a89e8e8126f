//! What Symphonia asserts and a damaged file contradicts, such as how many values a lattice of Vorbis has in Ogg.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::SoundError;

thread_local! {
    static DECODES: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread decodes a song just now, where a panic is caught and becomes [`SoundError::Damaged`]. A program's panic
/// hook may ask this, to say nothing then.
pub fn is_decoding() -> bool {
    DECODES.get()
}

/// Does a part of the decoding; a panic in it is damage of the file. What panicked is not to be trusted with more than being
/// dropped, or asked again.
pub(super) fn caught<T>(name: &str, work: impl FnOnce() -> T) -> Result<T, SoundError> {
    let was = DECODES.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    DECODES.set(was);
    done.map_err(|_| SoundError::Damaged { name: name.to_owned(), what: "it contradicts itself".to_owned() })
}
