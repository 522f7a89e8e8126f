//! `chladni dance` and `chladni symmetry` as a script runs them.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::Path;

use chladni_sound::{Song, WavSample, write_wav};

fn run(arguments: &[&str]) -> u8 {
    chladni::cli::run(["chladni", "--quiet"].iter().chain(arguments))
}

fn array(path: &Path, name: &str) -> (Vec<u64>, Vec<f64>) {
    let mut npz = npyz::npz::NpzArchive::open(path).unwrap();
    let array = npz.by_name(name).unwrap().unwrap();
    let shape = array.shape().to_vec();
    let values = if name == "times_secs" {
        array.into_vec::<f64>().unwrap()
    } else {
        array.into_vec::<f32>().unwrap().into_iter().map(f64::from).collect()
    };
    (shape, values)
}

#[test]
fn a_click_moves_the_shape_within_one_frame_and_repeats_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let wav = folder.path().join("clicks.wav");
    let rate_hz = 44_100;
    let mut left = vec![0.0f32; 4 * rate_hz as usize];
    (1..4).for_each(|secs| left[secs * rate_hz as usize] = 0.9);
    write_wav(&wav, &Song { rate_hz, right: left.clone(), left }, WavSample::Int16).unwrap();
    let film = |name: &str| {
        let npz = folder.path().join(name);
        let arguments = ["dance", "sample:octopus", wav.to_str().unwrap(), "-k", "24", "--coefficients"];
        assert_eq!(run(&[&arguments[..], &[npz.to_str().unwrap()]].concat()), 0);
        npz
    };
    let npz = film("a.npz");
    let (shape, coefficients) = array(&npz, "coefficients");
    let (_, times_secs) = array(&npz, "times_secs");
    assert_eq!(shape, [120, 24, 3]);
    let moved: Vec<f64> = coefficients.chunks(72).map(|c| c.iter().map(|x| x * x).sum()).collect();
    for secs in 1..4 {
        let near = (0..120).filter(|&f| (times_secs[f] - f64::from(secs)).abs() < 0.4);
        let peak = near.max_by(|&a, &b| moved[a].total_cmp(&moved[b])).unwrap();
        assert!((times_secs[peak] - f64::from(secs)).abs() <= 1.0 / 30.0 + 1e-9, "{}", times_secs[peak]);
    }
    assert_eq!(coefficients, array(&film("b.npz"), "coefficients").1);
}

#[test]
fn bad_input_is_refused_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let gif = folder.path().join("x.gif");
    let gif = gif.to_str().unwrap();
    for arguments in [
        &["dance", "nowhere.obj", "sample:tune", "-o", gif][..],
        &["dance", "sample:octopus", "nowhere.ogg", "-o", gif],
        &["dance", "sample:octopus", "sample:tune", "-o", gif, "--preset", "nowhere.toml"],
        &["dance", "sample:octopus", "sample:tune", "-o", "x.avi"],
        &["dance", "sample:octopus", "sample:tune"],
        &["dance", "sample:octopus", "sample:tune", "-o", gif, "--start", "-1"],
        &["symmetry", "nowhere.obj"],
    ] {
        assert_eq!(run(arguments), 2, "{arguments:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
