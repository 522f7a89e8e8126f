//! Numbers among the arguments.

use std::fmt::Display;
use std::str::FromStr;

use crate::work::Error;

/// A number that `fits`; others are refused with what it `must_be`.
pub fn number<T: FromStr>(
    text: &str,
    fits: impl FnOnce(&T) -> bool,
    must_be: impl Display,
) -> Result<T, Error> {
    let number = text.parse().ok().filter(fits);
    number.ok_or_else(|| Error::input(format_args!("must be {must_be}")))
}

/// Seconds, of whatever sign.
pub fn seconds(text: &str) -> Result<f64, Error> {
    number(text, |secs: &f64| secs.is_finite(), "a number of seconds, such as 90 or 1.5")
}
