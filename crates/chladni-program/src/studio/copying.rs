//! How often copies against a crash are written.

/// The least time between two copies.
pub const INTERVAL_SECS: f64 = 2.0;
/// Where a copy takes long to write, no more than this share of the time goes to that, as long as no change waits too long.
const WRITING: f64 = 0.05;
/// A change is in a copy, and that on the disk, within this time, unless writing alone takes longer. No more than five seconds are
/// to be lost; the rest is left for a window that looks late. Copies are written on a thread of their own, so that one that takes
/// long costs the window nothing, even where most of the time goes to copies.
pub const WITHIN_SECS: f64 = 4.5;

/// How long after a copy, which took `took_secs` to write, the next one may be due, in seconds: at least `least`, and later by
/// `more` where the window has other reasons, but early enough to be written `within` that time, too.
pub fn pause_secs(took_secs: f64, more: f64, [least, within]: [f64; 2]) -> f64 {
    ((took_secs / WRITING).max(least) + more).min(within - took_secs).max(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_disk_gets_fewer_copies_and_loses_no_more_than_five_seconds() {
        let pause_secs = |took_secs: f64| pause_secs(took_secs, 0.0, [INTERVAL_SECS, WITHIN_SECS]);
        assert!(pause_secs(0.0) < 2.1 && pause_secs(0.2) > 3.9 && pause_secs(1e3) < 2.1);
        for took_secs in [0.01, 0.1, 0.22, 0.25, 0.5, 1.0, 2.0, 2.5] {
            let oldest_secs = pause_secs(took_secs) + took_secs;
            assert!(oldest_secs < 5.0, "a change of {oldest_secs} s is in no copy that took {took_secs} s");
        }
    }
}
