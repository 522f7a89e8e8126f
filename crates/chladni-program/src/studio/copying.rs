//! How often copies against a crash are written.

/// The least time between two copies.
pub const INTERVAL_SECS: f64 = 2.0;
/// Where a copy takes long to write, no more than this share of the time goes to that.
const WRITING: f64 = 0.05;
/// On the slowest disk no copy waits longer for that.
pub const LONGEST_SECS: f64 = 60.0;

/// How long after a copy, which took `took_secs` to write, the next one may be due, in seconds; at least
/// `least` and at most `most`.
pub fn pause_secs(took_secs: f64, [least, most]: [f64; 2]) -> f64 {
    (took_secs / WRITING).clamp(least, most)
}
