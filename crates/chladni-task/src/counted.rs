//! Numbers of things in words.

use std::fmt::Display;

/// A number and what it counts: `one` of it, or `many`.
///
/// ```
/// assert_eq!(chladni_task::counted(1, "face", "faces"), "1 face");
/// assert_eq!(chladni_task::counted(0, "face", "faces"), "0 faces");
/// ```
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(number: N, one: &str, many: &str) -> String {
    let counts = if number == N::from(1) { one } else { many };
    format!("{number} {counts}")
}
