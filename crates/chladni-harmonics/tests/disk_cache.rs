//! The cache on disk: intact entries are used, damaged ones are replaced and never trusted.

mod shapes;

use chladni_harmonics::{BasisCache, BasisSettings, Body, Laplacian};
use chladni_task::Task;

#[test]
fn entries_are_reused_and_damaged_ones_solved_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path().join("bases"));
    let mesh = shapes::icosphere(2);
    let build = |k| Body::load_or_build(&mesh, &BasisSettings::new(k), Some(&cache), &Task::new()).unwrap();
    let (fresh, report) = build(30);
    assert!(!report.cached && report.cache_warning.is_none());
    let (again, report) = build(30);
    assert!(report.cached);
    assert_eq!(fresh.basis, again.basis);
    assert_eq!((&fresh.positions, &fresh.triangles), (&again.positions, &again.triangles));
    // Another K uses another entry.
    assert!(!build(31).1.cached);

    let entry = std::fs::read_dir(cache.folder())
        .unwrap()
        .map(|e| e.unwrap().path())
        .find(|p| std::fs::metadata(p).unwrap().len() < 8 * (31 * 162 + 162))
        .unwrap();
    let sound = std::fs::read(&entry).unwrap();
    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 1;
    for damaged in [flipped, sound[..sound.len() - 9].to_vec(), b"chladni basis".to_vec(), Vec::new()] {
        std::fs::write(&entry, damaged).unwrap();
        let (body, report) = build(30);
        assert!(!report.cached && report.cache_warning.is_some());
        assert_eq!(body.basis, fresh.basis);
        assert_eq!(std::fs::read(&entry).unwrap(), sound);
    }
    assert!(build(30).1.cached);
}

#[test]
fn what_was_used_the_longest_time_ago_makes_room_and_other_files_stay() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = shapes::icosphere(1);
    let entry = 8 * (42 * 5 + 42 + 5) + 96;
    let cache = BasisCache::new(folder.path()).of_at_most(2 * entry + 9 * 42 * 8);
    let build =
        |k| Body::load_or_build(&mesh, &BasisSettings::new(k), Some(&cache), &Task::new()).unwrap().1.cached;
    let others = ["notes.basis", &format!("{}.txt", "a".repeat(64))].map(|name| folder.path().join(name));
    others.iter().for_each(|path| std::fs::write(path, vec![0; 9999]).unwrap());
    let entries = || -> Vec<_> {
        let paths = std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().path());
        paths.filter(|path| !others.contains(path)).collect()
    };
    let age = |path: &std::path::Path, secs| {
        let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(secs);
        std::fs::File::options().append(true).open(path).unwrap().set_modified(long_ago).unwrap();
    };
    assert!(!build(5));
    age(&entries()[0], 1000);
    assert!(!build(6));
    entries().iter().for_each(|path| age(path, 100));
    // Used: the other one is now the oldest.
    assert!(build(5));
    assert!(!build(7));
    assert_eq!(entries().len(), 2);
    assert!(build(5) && build(7));
    assert!(others.iter().all(|path| path.exists()));
    let small = BasisCache::new(folder.path()).of_at_most(0);
    Body::load_or_build(&mesh, &BasisSettings::new(8), Some(&small), &Task::new()).unwrap();
    assert_eq!(entries().len(), 1, "the newest stays");
}

#[test]
fn entries_of_any_date_are_used_and_make_room() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = shapes::icosphere(1);
    let most = 2 * (8 * (42 * 9 + 42 + 9) + 96);
    let cache = BasisCache::new(folder.path()).of_at_most(most);
    let build =
        |k| Body::load_or_build(&mesh, &BasisSettings::new(k), Some(&cache), &Task::new()).unwrap().1.cached;
    let ahead = std::time::SystemTime::now() + std::time::Duration::from_secs(1 << 25);
    for written in [ahead, std::time::SystemTime::UNIX_EPOCH] {
        for k in 5..9 {
            assert!(!build(k));
            assert!(build(k), "what was just written stays");
            let files = || std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap());
            let total: u64 = files().map(|file| file.metadata().unwrap().len()).sum();
            assert!(total <= most, "{total}");
            for file in files() {
                let file = std::fs::File::options().append(true).open(file.path()).unwrap();
                file.set_modified(written).unwrap();
            }
        }
        for file in std::fs::read_dir(folder.path()).unwrap() {
            std::fs::remove_file(file.unwrap().path()).unwrap();
        }
    }
}

#[test]
fn no_flipped_bit_and_no_cut_is_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path());
    let mesh = shapes::icosphere(0);
    let build = || Body::load_or_build(&mesh, &BasisSettings::new(3), Some(&cache), &Task::new()).unwrap();
    let (fresh, _) = build();
    let entry = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    let sound = std::fs::read(&entry).unwrap();
    let flipped = (0..sound.len()).step_by(3).map(|at| {
        let mut bytes = sound.clone();
        bytes[at] ^= 1 << (at % 8);
        bytes
    });
    let cut = (0..sound.len()).step_by(7).map(|length| sound[..length].to_vec());
    let longer = [[&sound[..], &[0]].concat(), [&sound[..], &sound].concat()];
    for damaged in flipped.chain(cut).chain(longer) {
        std::fs::write(&entry, &damaged).unwrap();
        let (body, report) = build();
        assert!(!report.cached && report.cache_warning.is_some());
        assert_eq!(body.basis, fresh.basis);
    }
    assert!(build().1.cached);
}

#[test]
fn many_at_once_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path());
    let mesh = shapes::icosphere(1);
    let settings = |k| BasisSettings { threads: Some(1), ..BasisSettings::new(k) };
    let alone: Vec<_> =
        (1..6).map(|k| Body::build(&mesh, &settings(k), &Task::new()).unwrap().basis).collect();
    std::thread::scope(|scope| {
        for first in 0..8 {
            let (cache, mesh, alone) = (&cache, &mesh, &alone);
            scope.spawn(move || {
                for round in first..first + 20 {
                    let k = 1 + round % 5;
                    let built = Body::load_or_build(mesh, &settings(k), Some(cache), &Task::new());
                    let (body, report) = built.unwrap();
                    assert!(report.cache_warning.is_none(), "{report:?}");
                    assert_eq!(body.basis, alone[k - 1]);
                    // Somebody clears the cache at the same time.
                    if round % 7 == 0 {
                        std::fs::read_dir(cache.folder())
                            .unwrap()
                            .filter_map(Result::ok)
                            .filter(|entry| entry.path().extension().is_some_and(|e| e == "basis"))
                            .for_each(|entry| drop(std::fs::remove_file(entry.path())));
                    }
                }
            });
        }
    });
    let left = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    assert!(left.into_iter().all(|path| path.extension().is_some_and(|e| e == "basis")));
}

#[test]
fn what_is_no_file_is_no_entry() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path());
    let mesh = shapes::icosphere(0);
    let build = || Body::load_or_build(&mesh, &BasisSettings::new(3), Some(&cache), &Task::new()).unwrap();
    build();
    let entry = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    std::fs::remove_file(&entry).unwrap();
    std::fs::create_dir(&entry).unwrap();
    let (_, report) = build();
    assert!(!report.cached && report.cache_warning.is_some());
    assert!(entry.is_dir() && std::fs::read_dir(folder.path()).unwrap().count() == 1);
}

#[cfg(unix)]
#[test]
fn a_file_that_an_entry_links_to_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path().join("bases"));
    let mesh = shapes::icosphere(0);
    let build = || Body::load_or_build(&mesh, &BasisSettings::new(3), Some(&cache), &Task::new()).unwrap().1;
    build();
    let entry = std::fs::read_dir(cache.folder()).unwrap().next().unwrap().unwrap().path();
    let other = folder.path().join("thesis");
    std::fs::write(&other, "years").unwrap();
    std::fs::remove_file(&entry).unwrap();
    std::os::unix::fs::symlink("../thesis", &entry).unwrap();
    assert!(!build().cached);
    assert_eq!(std::fs::read(&other).unwrap(), b"years");
    assert!(!entry.is_symlink() && build().cached);
}

#[test]
fn each_laplacian_has_entries_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path());
    let mut mesh = shapes::icosphere(2);
    mesh.positions.iter_mut().for_each(|p| p[0] *= 4.0);
    let build = |laplacian| {
        let settings = BasisSettings { laplacian, ..BasisSettings::new(20) };
        Body::load_or_build(&mesh, &settings, Some(&cache), &Task::new()).unwrap()
    };
    let (usual, _) = build(Laplacian::Delaunay);
    let (plain, report) = build(Laplacian::Cotangent);
    assert!(!report.cached, "another operator has other harmonics");
    assert_ne!(usual.basis.eigenvalues, plain.basis.eigenvalues);
    for (laplacian, basis) in [(Laplacian::Delaunay, usual.basis), (Laplacian::Cotangent, plain.basis)] {
        let (again, report) = build(laplacian);
        assert!(report.cached);
        assert_eq!((&again.basis, again.basis.certificate.laplacian), (&basis, laplacian));
    }
}

#[test]
fn a_cache_that_cannot_be_written_is_told_and_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("not a folder");
    std::fs::write(&file, b"").unwrap();
    let cache = BasisCache::new(&file);
    let settings = BasisSettings::new(5);
    let (body, report) =
        Body::load_or_build(&shapes::icosphere(1), &settings, Some(&cache), &Task::new()).unwrap();
    assert_eq!(body.basis.harmonics(), 5);
    assert!(report.cache_warning.is_some());
}

#[test]
fn a_cancelled_build_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let cache = BasisCache::new(folder.path().join("bases"));
    let task = Task::new();
    task.cancel();
    assert!(Body::load_or_build(&shapes::icosphere(2), &BasisSettings::new(5), Some(&cache), &task).is_err());
    assert!(!cache.folder().exists());
}
