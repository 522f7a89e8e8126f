//! Estimates the memory that a solve needs, and compares it with what is available.

use crate::HarmonicsError;

/// Bytes per vertex: for the mesh, the operator and its analysis; for a factor; for the vectors of a Krylov
/// space. Measured on surfaces of 100,000 to 800,000 vertices, where the sum is right to a quarter
/// (docs/scale.md).
const SURFACE: u64 = 800;
const FACTOR: u64 = 1100;
const SPACE: u64 = 2048;
/// Bytes per value of a harmonic.
const VALUE: u64 = 8;

/// The approximate number of bytes needed to solve for `harmonics` of `vertices`, with `slices` at once.
fn of_solve(vertices: usize, harmonics: usize, slices: usize) -> u64 {
    let vectors = VALUE.saturating_mul(harmonics as u64);
    let each = (SURFACE + slices as u64 * (FACTOR + SPACE)).saturating_add(vectors);
    each.saturating_mul(vertices as u64)
}

/// The approximate number of bytes needed here if other processes solve: the mesh, and the vectors.
#[cfg(not(target_family = "wasm"))]
fn of_ranks(vertices: usize, harmonics: usize) -> u64 {
    VALUE.saturating_mul(harmonics as u64 + 64).saturating_add(SURFACE).saturating_mul(vertices as u64)
}

/// Refuses a solve with `slices` at once if there is not enough memory.
pub(crate) fn check_solve(vertices: usize, harmonics: usize, slices: usize) -> Result<(), HarmonicsError> {
    check(vertices, harmonics, of_solve(vertices, harmonics, slices), available())
}

/// Refuses a solve by other processes if there is not enough memory here for its harmonics.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn check_ranks(vertices: usize, harmonics: usize) -> Result<(), HarmonicsError> {
    check(vertices, harmonics, of_ranks(vertices, harmonics), available())
}

fn check(
    vertices: usize,
    harmonics: usize,
    needed: u64,
    available: Option<u64>,
) -> Result<(), HarmonicsError> {
    let too_many = |reason: String| Err(HarmonicsError::TooMany { harmonics, vertices, reason });
    if let Some(available) = available.filter(|available| needed > *available) {
        let gigabytes = |bytes: u64| bytes as f64 / 1e9;
        return too_many(format!(
            "it takes about {:.1} GB of memory, and {:.1} GB are free: ask for fewer harmonics or threads",
            gigabytes(needed),
            gigabytes(available)
        ));
    }
    // If the available memory is unknown, refuse only what the system would not even promise.
    if Vec::<f64>::new().try_reserve_exact(vertices.saturating_mul(harmonics)).is_err() {
        return too_many("they are more than this machine's memory".into());
    }
    Ok(())
}

/// The bytes that are available without swapping out other programs; `None` if the system does not say.
fn available() -> Option<u64> {
    let system = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| in_meminfo(&text));
    let read = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok();
    let number = |text: String| text.trim().parse::<u64>().ok();
    // In a container, its limit if it has one. Its file cache counts as used but can be reclaimed.
    let files = read("stat")
        .and_then(|text| number(text.lines().find_map(|l| l.strip_prefix("inactive_file "))?.into()));
    let used = read("current").and_then(number).map(|used| used.saturating_sub(files.unwrap_or(0)));
    let left = read("max").and_then(number).zip(used).map(|(limit, used)| limit.saturating_sub(used));
    match (system, left) {
        (Some(system), Some(left)) => Some(system.min(left)),
        (system, left) => system.or(left),
    }
}

fn in_meminfo(text: &str) -> Option<u64> {
    let kilobytes = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    };
    Some(1024 * (kilobytes("MemAvailable")? + kilobytes("SwapFree").unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        let needed = of_solve(50_000_000, 256, 2);
        let error = check(50_000_000, 256, needed, Some(22_000_000_000)).unwrap_err().to_string();
        assert!(error.contains("457.2 GB") && error.contains("22.0 GB are free"), "{error}");
        assert!(check(800_000, 256, of_solve(800_000, 256, 2), Some(22_000_000_000)).is_ok());
        assert!(check(3, usize::MAX / 8, 1, None).unwrap_err().to_string().contains("this machine's memory"));
        assert!(check_solve(usize::MAX, usize::MAX / 8, 1).is_err());
        #[cfg(not(target_family = "wasm"))]
        assert!(check_ranks(1 << 60, 1 << 10).is_err());
    }

    #[test]
    fn the_system_s_own_words_are_understood() {
        let text = "MemTotal:  100 kB\nMemFree:  1 kB\nMemAvailable:      20 kB\nSwapFree:   2 kB\n";
        assert_eq!(in_meminfo(text), Some(22 * 1024));
        assert_eq!(in_meminfo("MemAvailable: many"), None);
        if cfg!(target_os = "linux") {
            assert!(available().is_some_and(|bytes| bytes > 1 << 20));
        }
    }
}
