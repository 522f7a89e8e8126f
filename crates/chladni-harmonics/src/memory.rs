//! Estimates the memory that a solve needs, and compares it with what is available.

use std::path::Path;

use crate::platform::MOST_BYTES;
use crate::values::{self, Keep};
use crate::{BasisSettings, HarmonicsError, ShortOfMemory, Values};

/// Bytes per vertex: for the mesh, the operator and its analysis; for a factor; for a Krylov space and
/// the pairs that come of it. Measured on surfaces of 100,000 to 800,000 vertices, where the sum is right to a quarter
/// (docs/scale.md).
const SURFACE: u64 = 800;
const FACTOR: u64 = 1100;
const SPACE: u64 = 3000;
/// Bytes per value of a harmonic.
const VALUE: u64 = 8;
/// The number of matrices of a dense solve.
const DENSE: u64 = 4;

/// The approximate number of bytes of memory needed to solve for `harmonics` of `vertices` with `slices` at
/// once; those on disk do not count.
fn of_solve(vertices: usize, harmonics: usize, slices: usize, on_disk: bool) -> u64 {
    let vectors = if on_disk { 0 } else { VALUE.saturating_mul(harmonics as u64) };
    let each = (SURFACE + slices as u64 * (FACTOR + SPACE)).saturating_add(vectors);
    each.saturating_mul(vertices as u64)
}

/// The same when the first `slices` are solved and `kept` factors, theirs included, wait for their slices.
fn of_plan(vertices: usize, slices: usize, kept: usize) -> u64 {
    (SURFACE + kept as u64 * FACTOR + slices as u64 * SPACE).saturating_mul(vertices as u64)
}

/// The approximate number of bytes needed for harmonics that were solved elsewhere: the mesh, and the vectors.
fn of_harmonics(vertices: usize, harmonics: usize, on_disk: bool) -> u64 {
    let vectors = if on_disk { 64 * VALUE } else { VALUE.saturating_mul(harmonics as u64 + 64) };
    vectors.saturating_add(SURFACE).saturating_mul(vertices as u64)
}

impl Keep<'_> {
    /// How solving `slices` at once, with vectors kept here, differs from solving `of_slices` at once in memory;
    /// `None` if it does not.
    pub(crate) fn short_of(
        self,
        slices: usize,
        of_slices: usize,
        vertices: usize,
        harmonics: usize,
    ) -> Option<ShortOfMemory> {
        let scratch = match self {
            Keep::Memory => None,
            Keep::Folder(folder) => Some((folder.to_owned(), on_disk(vertices, harmonics))),
        };
        (slices < of_slices || scratch.is_some()).then_some(ShortOfMemory { slices, of_slices, scratch })
    }
}

/// The bytes that the harmonics take on disk at most: those of all slices, and in the order of the mesh.
fn on_disk(vertices: usize, harmonics: usize) -> u64 {
    (2 * VALUE).saturating_mul(vertices as u64).saturating_mul(harmonics as u64)
}

/// How a solve fits in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room<'a> {
    /// The number of slices that are solved at once.
    pub slices: usize,
    /// Where the harmonics are kept.
    pub keep: Keep<'a>,
    /// Whether there is no room for the factors of slices that wait.
    pub frugal: bool,
}

/// The room for a solve of up to `slices` at once, with a plan that has `kept` factors at its end. The disk
/// is used only where that allows more slices. Where it has no room for them, the solve takes fewer in memory.
pub(crate) fn room_for_solve<'a>(
    vertices: usize,
    slices: usize,
    kept: usize,
    settings: &'a BasisSettings,
) -> Result<Room<'a>, HarmonicsError> {
    let harmonics = settings.harmonics;
    let Some(free) = free(settings) else {
        check_promise(vertices, harmonics)?;
        return Ok(Room { slices, keep: Keep::Memory, frugal: false });
    };
    let scratch = settings.scratch.as_deref();
    let (slices, keep) = fitting(slices.max(1), Keep::Memory, scratch, vertices, harmonics, 0, free)?;
    if keep == Keep::Memory {
        check_promise(vertices, harmonics)?;
    }
    Ok(Room { slices, keep, frugal: of_plan(vertices, slices, kept) > free })
}

/// How many of up to `slices` at once fit in the `free` bytes, if each takes `more` than one of a surface, and where the
/// harmonics are kept then.
fn fitting<'a>(
    slices: usize,
    mut keep: Keep<'a>,
    scratch: Option<&'a Path>,
    vertices: usize,
    harmonics: usize,
    more: u64,
    free: u64,
) -> Result<(usize, Keep<'a>), HarmonicsError> {
    let needed = |slices: usize, keep: Keep| {
        let solve = of_solve(vertices, harmonics, slices, keep != Keep::Memory);
        solve.saturating_add(more.saturating_mul(slices as u64))
    };
    let most = |keep: Keep| (1..=slices).rev().find(|slices| needed(*slices, keep) <= free);
    if let (Keep::Memory, Some(folder)) = (keep, scratch)
        && most(Keep::Folder(folder)) > most(keep)
    {
        match check_disk(folder, on_disk(vertices, harmonics)) {
            Ok(()) => keep = Keep::Folder(folder),
            Err(why) if most(keep).is_none() => return Err(why),
            Err(_) => {}
        }
    }
    let Some(slices) = most(keep) else {
        let least = needed(1, scratch.map_or(keep, Keep::Folder));
        return Err(too_large(vertices, harmonics, least, free));
    };
    Ok((slices, keep))
}

/// The `room` that is left with factors of this many `bytes` each, with their fronts. Those of surfaces are what was
/// expected; those of graphs and solids may be far larger. The disk is used as in [`room_for_solve`].
pub(crate) fn room_for_factors<'a>(
    room: Room<'a>,
    scratch: Option<&'a Path>,
    vertices: usize,
    harmonics: usize,
    kept: usize,
    bytes: u64,
    free: u64,
) -> Result<Room<'a>, HarmonicsError> {
    let more = bytes.saturating_sub(FACTOR.saturating_mul(vertices as u64));
    if more == 0 {
        return Ok(room);
    }
    let (slices, keep) = fitting(room.slices, room.keep, scratch, vertices, harmonics, more, free)?;
    let planned = of_plan(vertices, slices, kept).saturating_add(more.saturating_mul(kept as u64));
    Ok(Room { slices, keep, frugal: room.frugal || planned > free })
}

/// Where harmonics are kept that were solved elsewhere, in this number of `copies` at once.
pub(crate) fn room_for_harmonics(
    vertices: usize,
    copies: usize,
    settings: &BasisSettings,
) -> Result<Keep<'_>, HarmonicsError> {
    let harmonics = settings.harmonics;
    let columns = harmonics.saturating_mul(copies);
    let needed = |on_disk| of_harmonics(vertices, columns, on_disk);
    match (free(settings), &settings.scratch) {
        (Some(free), Some(folder)) if needed(false) > free && needed(true) <= free => {
            check_disk(folder, on_disk(vertices, columns) / 2)?;
            Ok(Keep::Folder(folder))
        }
        (Some(free), scratch) if needed(false) > free => {
            Err(too_large(vertices, harmonics, needed(scratch.is_some()), free))
        }
        _ => check_promise(vertices, columns).map(|()| Keep::Memory),
    }
}

/// Zeros for `count` vectors, which may be more than K where the last group of equal eigenvalues is whole. Refused where they
/// take more than the `free` bytes, if the system says how many there are.
pub(crate) fn vectors(
    vertices: usize,
    count: usize,
    keep: Keep<'_>,
    free: Option<u64>,
) -> Result<Values, HarmonicsError> {
    let needed = VALUE.saturating_mul(vertices as u64).saturating_mul(count as u64);
    if let (Keep::Memory, Some(free)) = (keep, free)
        && needed > free
    {
        return Err(too_large(vertices, count, needed, free));
    }
    Values::zeroed(vertices * count, keep).map_err(|error| keep.refused(&error))
}

/// Refuses a dense solve whose matrices take more than the `free` bytes.
pub(crate) fn check_dense(vertices: usize, harmonics: usize, free: u64) -> Result<(), HarmonicsError> {
    let needed = (DENSE * VALUE).saturating_mul(vertices as u64).saturating_mul(vertices as u64);
    if needed > free { Err(too_large(vertices, harmonics, needed, free)) } else { Ok(()) }
}

/// The bytes that a solve may take; `None` if there is no telling.
pub(crate) fn free(settings: &BasisSettings) -> Option<u64> {
    settings.memory_bytes.or_else(available)
}

fn check_disk(folder: &Path, bytes: u64) -> Result<(), HarmonicsError> {
    values::check_folder(folder, bytes).map_err(|e| {
        let reason = format!("{}: {e}", size(bytes));
        HarmonicsError::NoScratch { folder: folder.to_owned(), reason }
    })
}

fn too_large(vertices: usize, harmonics: usize, needed: u64, free: u64) -> HarmonicsError {
    let (needed, free) = (size(needed), size(free));
    let reason = format!("it takes at least about {needed} of memory, and {free} may be used");
    HarmonicsError::TooMany { harmonics, vertices, reason }
}

/// A number of bytes in words, with a tenth of its unit.
pub(crate) fn size(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes < 1e9 { format!("{:.1} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

/// Refuses a size that the system would not even promise.
fn check_promise(vertices: usize, harmonics: usize) -> Result<(), HarmonicsError> {
    if Vec::<f64>::new().try_reserve_exact(vertices.saturating_mul(harmonics)).is_err() {
        let reason = "they are more than this machine's memory".into();
        return Err(HarmonicsError::TooMany { harmonics, vertices, reason });
    }
    Ok(())
}

/// The bytes that are available without swapping out other programs; `None` if the system does not say.
pub fn available() -> Option<u64> {
    available_below(Path::new("/"))
}

/// The same where the system's own files are below `root`.
fn available_below(root: &Path) -> Option<u64> {
    let read = |name: &str| std::fs::read_to_string(root.join(name)).ok();
    let system = read("proc/meminfo").and_then(|text| in_meminfo(&text));
    let groups = read("proc/self/cgroup").unwrap_or_default();
    let left = groups.lines().filter_map(|line| left_in_group(root, line));
    let left = left.chain(left_of_addresses(root)).min();
    match (system, left) {
        (Some(system), Some(left)) => Some(system.min(left)),
        (system, left) => system.or(left).or(MOST_BYTES),
    }
}

/// The bytes that are left in the control group of a `line` of `/proc/self/cgroup` and in those around it, as containers,
/// services and the jobs of a cluster have them; `None` where none has a limit.
fn left_in_group(root: &Path, line: &str) -> Option<u64> {
    let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
    let (top, [most, used, files]) = if controllers.is_empty() {
        ("sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file "])
    } else if controllers.split(',').any(|controller| controller == "memory") {
        let names = ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "];
        ("sys/fs/cgroup/memory", names)
    } else {
        return None;
    };
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let left = |group: &Path| {
        let read = |name: &str| std::fs::read_to_string(group.join(name)).ok();
        let (limit, used) = (number(&read(most)?)?, number(&read(used)?)?);
        // The file cache counts as used but can be reclaimed.
        let cached = read("memory.stat")
            .and_then(|text| number(text.lines().find_map(|line| line.strip_prefix(files))?))
            .unwrap_or(0);
        Some(limit.saturating_sub(used.saturating_sub(cached)))
    };
    // In a container, the path may be that of the system outside: then of these folders only the top is there.
    let top = root.join(top);
    let group = top.join(path.trim_start_matches('/'));
    group.ancestors().take_while(|group| group.starts_with(&top)).filter_map(left).min()
}

/// The bytes that the program may still have addresses for; `None` where `ulimit -v` sets no limit.
fn left_of_addresses(root: &Path) -> Option<u64> {
    let read = |name: &str| std::fs::read_to_string(root.join("proc/self").join(name)).ok();
    let limits = read("limits")?;
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let most: u64 = limit.split_whitespace().next()?.parse().ok()?;
    Some(most.saturating_sub(1024 * kilobytes(&read("status")?, "VmSize")?))
}

fn in_meminfo(text: &str) -> Option<u64> {
    Some(1024 * (kilobytes(text, "MemAvailable")? + kilobytes(text, "SwapFree").unwrap_or(0)))
}

/// The number of this name in a file that the system has for people, too.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    line.split_whitespace().next()?.parse::<u64>().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(harmonics: usize, memory_bytes: u64, scratch: Option<&Path>) -> BasisSettings {
        let (memory_bytes, scratch) = (Some(memory_bytes), scratch.map(Path::to_owned));
        BasisSettings { memory_bytes, scratch, ..BasisSettings::new(harmonics) }
    }

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        let free = 22_000_000_000;
        let error = room_for_solve(50_000_000, 2, 4, &settings(256, free, None)).unwrap_err().to_string();
        assert!(error.contains("347.4 GB") && error.contains("22.0 GB may be used"), "{error}");
        let whole = Room { slices: 2, keep: Keep::Memory, frugal: false };
        assert_eq!(room_for_solve(800_000, 2, 4, &settings(256, free, None)).unwrap(), whole);
        assert_eq!(Keep::Memory.short_of(2, 2, 800_000, 256), None);
        let tight = settings(256, 8_850_000_000, None);
        assert_eq!(room_for_solve(800_000, 2, 4, &tight).unwrap(), Room { frugal: true, ..whole });
        let mut unlimited = settings(usize::MAX / 8, 0, None);
        unlimited.memory_bytes = None;
        assert!(room_for_solve(usize::MAX, 1, 1, &unlimited).is_err());
        assert!(check_promise(3, usize::MAX / 8).unwrap_err().to_string().contains("this machine's memory"));
        assert!(room_for_harmonics(1 << 60, 1, &settings(1 << 10, free, None)).is_err());
    }

    #[test]
    fn factors_larger_than_those_of_a_surface_take_slices_away_before_they_are_refused() {
        // A slice of 1000 vertices takes 4.9 MB without vectors, and two take 9.0 MB, if a factor is that of a surface.
        let whole = Room { slices: 2, keep: Keep::Memory, frugal: false };
        let room = |megabytes: u64, free: u64| {
            room_for_factors(whole, None, 1000, 0, 2, megabytes * 1_000_000, free * 1_000_000)
        };
        assert_eq!(room(1, 1).unwrap(), whole);
        assert_eq!(room(11, 29).unwrap(), whole);
        assert_eq!(room(11, 28).unwrap(), Room { slices: 1, frugal: false, ..whole });
        assert_eq!(room(11, 15).unwrap(), Room { slices: 1, frugal: true, ..whole });
        let refused = room(11, 14).unwrap_err().to_string();
        assert!(refused.contains("14.8 MB") && refused.contains("14.0 MB may be used"), "{refused}");
    }

    #[cfg(not(target_family = "wasm"))]
    #[test]
    fn fewer_slices_come_before_a_refusal_and_the_disk_only_where_it_allows_more() {
        let folder = tempfile::tempdir().unwrap();
        let (n, k) = (1000, 512);
        let room = |tenths: u64, scratch| {
            let settings = settings(k, 100_000 * tenths, scratch);
            room_for_solve(n, 2, 8, &settings).map(|room| (room.slices, room.keep != Keep::Memory)).ok()
        };
        // In memory 9.0 MB for one slice, 13.1 for two; on disk 4.9 and 9.0.
        assert_eq!(
            [room(132, None), room(100, None), room(89, None)],
            [Some((2, false)), Some((1, false)), None]
        );
        let scratch = Some(folder.path());
        assert_eq!([room(132, scratch), room(100, scratch)], [Some((2, false)), Some((2, true))]);
        assert_eq!([room(60, scratch), room(48, scratch)], [Some((1, true)), None]);
        if !cfg!(unix) {
            // The room of a folder that is not there is that of its disk.
            return;
        }
        let nowhere = folder.path().join("none");
        // Without room on disk two slices become one, as long as that fits in memory.
        assert_eq!(room(100, Some(&nowhere)), Some((1, false)));
        let settings = settings(k, 6_000_000, Some(&nowhere));
        assert!(matches!(room_for_solve(n, 2, 8, &settings), Err(HarmonicsError::NoScratch { .. })));
        assert!(matches!(room_for_harmonics(n, 1, &settings), Ok(Keep::Memory)));
        assert!(matches!(room_for_harmonics(n, 2, &settings), Err(HarmonicsError::NoScratch { .. })));
    }

    #[cfg(not(target_family = "wasm"))]
    #[test]
    fn beside_large_factors_harmonics_go_to_disk_where_that_allows_more_slices() {
        let folder = tempfile::tempdir().unwrap();
        let whole = Room { slices: 2, keep: Keep::Memory, frugal: false };
        // One slice takes 8.9 MB beside 2 MB of harmonics, two take 17.0 MB.
        let room = |tenths: u64, scratch| {
            room_for_factors(whole, scratch, 1000, 250, 2, 5_100_000, 100_000 * tenths)
                .map(|room| (room.slices, room.keep != Keep::Memory))
                .ok()
        };
        let scratch = Some(folder.path());
        assert_eq!([room(190, scratch), room(189, scratch)], [Some((2, false)), Some((2, true))]);
        assert_eq!([room(169, scratch), room(108, scratch)], [Some((1, false)), Some((1, true))]);
        assert_eq!([room(88, scratch), room(108, None), room(189, None)], [None, None, Some((1, false))]);
        if !cfg!(unix) {
            // As above.
            return;
        }
        let nowhere = folder.path().join("none");
        assert_eq!(room(189, Some(&nowhere)), Some((1, false)));
        let refused = room_for_factors(whole, Some(&nowhere), 1000, 250, 2, 5_100_000, 10_800_000);
        assert!(matches!(refused, Err(HarmonicsError::NoScratch { .. })));
    }

    #[cfg(not(target_family = "wasm"))]
    #[test]
    fn the_narrowest_limit_around_the_program_counts() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let write = |name: &str, text: &str| {
            let path = root.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let groups = |text: &str| write("proc/self/cgroup", text);
        write("proc/meminfo", "MemAvailable: 1000 kB\n");
        groups("0::/job/step\n");
        assert_eq!(available_below(root), Some(1_024_000));
        // The job's limit is that of its step, too.
        write("sys/fs/cgroup/job/step/memory.max", "max\n");
        write("sys/fs/cgroup/job/step/memory.current", "1\n");
        write("sys/fs/cgroup/job/memory.max", "900000\n");
        write("sys/fs/cgroup/job/memory.current", "300000\n");
        write("sys/fs/cgroup/job/memory.stat", "anon 7\ninactive_file 100000\n");
        assert_eq!(available_below(root), Some(700_000));
        write("sys/fs/cgroup/memory.max", "500000\n");
        write("sys/fs/cgroup/memory.current", "0\n");
        assert_eq!(available_below(root), Some(500_000));
        // The older interface, in a container whose own path is not seen inside.
        groups("5:cpu,cpuacct:/a\n4:memory:/a/b\n");
        assert_eq!(available_below(root), Some(1_024_000));
        write("sys/fs/cgroup/memory/memory.limit_in_bytes", "400000\n");
        write("sys/fs/cgroup/memory/memory.usage_in_bytes", "200000\n");
        write("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 50000\n");
        assert_eq!(available_below(root), Some(250_000));
        // That of the shell counts what is mapped, not only what is used.
        let limits = |soft: &str| {
            let line = format!("Max address space         {soft:<20} unlimited            bytes     \n");
            write("proc/self/limits", &format!("Limit  Soft Limit  Hard Limit  Units\n{line}"));
        };
        write("proc/self/status", "Name:\tchladni\nVmSize:\t     100 kB\n");
        limits("unlimited");
        assert_eq!(available_below(root), Some(250_000));
        limits("302400");
        assert_eq!(available_below(root), Some(200_000));
        limits("1024");
        assert_eq!(available_below(root), Some(0));
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
