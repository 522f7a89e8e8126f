//! What commands write is the same on any number of threads, to the last byte.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use chladni_mesh::{TriMesh, samples, save_mesh};

/// Of small shapes, so that it takes seconds; each number of threads solves them anew. The mapping of a dance is bred.
const STEPS: &[&str] = &[
    "basis shape.obj -k 300 -o basis.npz --operator operator.npz",
    "match shape.obj template.obj --method same -o same.npz",
    "match shape.obj --method ellipsoid -o ellipsoid.npz",
    "match small.obj small-template.obj --method icp --landmarks pairs.txt -o icp.npz",
    "match small.obj small-template.obj --method fit --landmarks pairs.txt -o fit.npz",
    "match shape.obj template.obj --method map --landmarks pairs.txt -o map.npz",
    "project new shape.obj -k 48 -o me.chladni",
    "project add-layer me.chladni --template template.obj --match map --landmarks pairs.txt --model normal --mu -0.5",
    "project add-layer me.chladni --template ellipsoid --model distance --mu -1.5",
    "project add-layer me.chladni --template self:scale=0.9 --mu -1 --region 10,0,0,2",
    "caricature --recipe me.chladni -o me.glb --render me.png --size 160x120 --draw cpu",
    "mean shape.obj template.obj --match same -o mean.ply",
    "transfer shape.obj template.obj shape.obj --match same -o transferred.ply",
    "symmetry shape.obj -k 24 --render symmetry.png --draw cpu",
    "dance shape.obj sample:tune -k 48 --duration 0.3 --fps 10 --gallery 6 --size 96x72 --frames frames \
     --coefficients dance.npz --presets presets --draw cpu --synthesis cpu",
    "dance small.obj sample:tune -k 48 --duration 0.3 --fps 10 -o dance.glb --targets 6",
];

#[test]
fn threads_change_no_byte() {
    let one = written("1");
    assert!(one.len() > STEPS.len(), "{:?}", one.keys());
    for threads in ["2", "5"] {
        let more = written(threads);
        assert!(more.keys().eq(one.keys()), "{threads} threads: {:?}, not {:?}", more.keys(), one.keys());
        let differing: Vec<&PathBuf> = one.keys().filter(|name| more[*name] != one[*name]).collect();
        assert!(differing.is_empty(), "{threads} threads change {differing:?}");
    }
}

/// All files that the steps leave.
fn written(threads: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let path = |name: &str| folder.path().join(name);
    for (levels, shape, template) in
        [(3, "small.obj", "small-template.obj"), (4, "shape.obj", "template.obj")]
    {
        save_mesh(&lump(levels, 0.6), &path(shape)).unwrap();
        save_mesh(&lump(levels, 0.3), &path(template)).unwrap();
    }
    std::fs::write(path("pairs.txt"), "0 0\n10 10\n40 40\n100 100\n300 300\n").unwrap();
    for line in STEPS {
        let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args(line.split_whitespace())
            .arg("--quiet")
            .current_dir(folder.path())
            .env("CHLADNI_CACHE", cache.path())
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let mut files = BTreeMap::new();
    collect(folder.path(), folder.path(), &mut files);
    files
}

/// A shape without symmetry.
fn lump(levels: u32, bumps: f64) -> TriMesh {
    let mut mesh = samples::icosphere(levels);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = 3.0 + bumps * (3.0 * x).sin() + 0.4 * y * z;
        *p = [10.0 + r * x, r * y, 0.7 * r * z];
    }
    mesh
}

fn collect(folder: &Path, root: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, root, files);
        } else {
            files.insert(path.strip_prefix(root).unwrap().to_owned(), std::fs::read(&path).unwrap());
        }
    }
}
