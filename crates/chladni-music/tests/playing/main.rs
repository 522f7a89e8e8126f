//! From bands to moving shapes: rest, mirror, true stereo, calibration, sessions that replay.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod favorites;
mod limits;
mod shows;

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{Orientation, TriMesh, samples};
use chladni_music::{
    Action, Bands, Beat, BeatReading, Dancer, Ensemble, Form, GalleryShape, Instrument, Mapping, Moment,
    Parameters, Player, Playing, Preset, Resonators, Show, SongRef, Switch, Symmetry, TappedBeats, Timbre,
    react, repertoire,
};
use chladni_sound::{Spectrum, SpectrumAnalyzer, SpectrumSettings, sample_tune};
use chladni_synth::{Item, displacements_f64};
use chladni_task::Task;

use limits::calibrated_share;

const K: usize = 64;
const BANDS: usize = 128;

struct Ready {
    body: Body,
    dancer: Arc<Dancer>,
}

fn ready(name: &str) -> Ready {
    ready_of(&samples::sample(name).unwrap())
}

fn ready_of(mesh: &TriMesh) -> Ready {
    let body = Body::build(mesh, &BasisSettings::new(K), &Task::new()).unwrap();
    let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
    let body = symmetry.rotated(&body);
    let dancer = Arc::new(Dancer::new(&body, &symmetry.classes, &Orientation::default()).unwrap());
    Ready { body, dancer }
}

fn octopus() -> &'static Ready {
    static READY: OnceLock<Ready> = OnceLock::new();
    READY.get_or_init(|| ready("octopus"))
}

fn head() -> &'static Ready {
    static READY: OnceLock<Ready> = OnceLock::new();
    READY.get_or_init(|| ready("head"))
}

fn only(band: usize) -> Vec<f32> {
    (0..BANDS).map(|b| f32::from(u8::from(b == band))).collect()
}

fn bands_of(spectrum: &Spectrum) -> Bands<'_> {
    Bands {
        left: &spectrum.left,
        right: &spectrum.right,
        mid: &spectrum.mid,
        side: &spectrum.side,
        side_gain: spectrum.side_gain,
        ringing: None,
    }
}

fn displacements(ready: &Ready, mapping: &Mapping, bands: &Bands<'_>, playing: Playing) -> Vec<[f64; 3]> {
    let mut player = Player::new(mapping, &ready.dancer, BANDS, playing).unwrap();
    let mut item = player.item();
    player.play(bands, &mut item).unwrap();
    displacements_f64(&ready.body, &item).unwrap()
}

fn farthest(d: &[[f64; 3]]) -> f64 {
    d.iter().map(|d| d.iter().map(|c| c * c).sum::<f64>().sqrt()).fold(0.0, f64::max)
}

#[test]
fn no_amplification_leaves_every_form_at_rest_exactly() {
    let full = vec![1.0; BANDS];
    let bands = Bands { left: &full, right: &full, mid: &full, side: &full, side_gain: 1.0, ringing: None };
    for form in [Form::Filter, Form::Modal, Form::HalfMask] {
        let d = displacements(
            octopus(),
            &Mapping::rest(BANDS, K),
            &bands,
            Playing { form, ..Playing::default() },
        );
        assert!(d.iter().all(|d| *d == [0.0; 3]), "{form:?}");
    }
}

/// Displacement energies of the left and the right half under a tone in either channel or in both, as the
/// spectrum hears it.
fn energies(ready: &Ready, form: Form, tone_hz: f32, left: f32, right: f32) -> [f64; 2] {
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, BANDS);
    let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings::new(44_100)).unwrap();
    let tone = |gain: f32| -> Vec<f32> {
        let wave = |i: usize| gain * (std::f32::consts::TAU * tone_hz * i as f32 / 44_100.0).sin();
        (0..analyzer.window_frames()).map(wave).collect()
    };
    let (left, right) = (tone(left), tone(right));
    let s = analyzer.analyze(&left, &right, 1.0);
    let bands = bands_of(s);
    let d = displacements(ready, &mapping, &bands, Playing { form, ..Playing::default() });
    let mut energy = [0.0; 2];
    for ((d, x), a) in d.iter().zip(&ready.body.positions).zip(&ready.body.basis.mass) {
        // Vertices in the middle belong to both halves.
        let share = if x[0].abs() < 1e-6 { 0.5 } else { f64::from(u8::from(x[0] > 0.0)) };
        let own = a * d.iter().map(|c| c * c).sum::<f64>();
        energy = [energy[0] + (1.0 - share) * own, energy[1] + share * own];
    }
    energy
}

#[test]
fn a_channel_alone_moves_its_own_half_and_both_move_both_alike() {
    for (ready, name) in [(octopus(), "octopus"), (head(), "head")] {
        for (form, least) in [(Form::HalfMask, 5.0), (Form::Modal, 2.0)] {
            for tone_hz in [110.0, 440.0, 1760.0] {
                let [left, right] = energies(ready, form, tone_hz, 0.5, 0.0);
                assert!(left >= least * right, "{name}, {form:?}, {tone_hz} Hz left: {left} {right}");
                let [left, right] = energies(ready, form, tone_hz, 0.0, 0.5);
                assert!(right >= least * left, "{name}, {form:?}, {tone_hz} Hz right: {left} {right}");
                let [left, right] = energies(ready, form, tone_hz, 0.5, 0.5);
                assert!(left > 0.0 && (left / right - 1.0).abs() < 0.02, "{name}, {form:?}: {left} {right}");
            }
        }
    }
}

#[test]
fn the_first_of_two_terms_is_the_left_half_also_where_sides_are_exchanged() {
    let ready = octopus();
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, BANDS);
    let (loud, half, silence) = (vec![1.0; BANDS], vec![0.5; BANDS], vec![0.0; BANDS]);
    let bands =
        Bands { left: &loud, right: &silence, mid: &half, side: &half, side_gain: 1.0, ringing: None };
    for flip_sides in [false, true] {
        let playing = Playing { flip_sides, ..Playing::default() };
        let mut player = Player::new(&mapping, &ready.dancer, BANDS, playing).unwrap();
        let mut item = player.item();
        player.play(&bands, &mut item).unwrap();
        let sides = &ready.dancer.sides;
        let halves = [(&sides.left, !flip_sides), (&sides.right, flip_sides)];
        for (term, (mask, moves)) in item.terms.iter().zip(halves) {
            let chladni_synth::Coefficients::Vector(c) = &term.coefficients else { panic!() };
            assert!(term.mask.as_ref() == Some(mask));
            assert_eq!(c.iter().any(|c| *c != [0.0; 3]), moves, "exchanged {flip_sides}");
        }
    }
}

#[test]
fn the_filter_form_keeps_a_mirror_symmetric_shape_symmetric() {
    let ready = octopus();
    let key = |p: [f64; 3]| p.map(|c| (c * 1e5).round() as i64);
    let at: HashMap<[i64; 3], usize> =
        ready.body.positions.iter().enumerate().map(|(v, p)| (key(*p), v)).collect();
    let mirror = |v: usize| {
        let [x, y, z] = key(ready.body.positions[v]);
        // Rounding may put the mirror image into a neighboring cell.
        (0..27)
            .map(|i: i64| [-x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])
            .find_map(|k| at.get(&k).copied())
    };
    let tone: Vec<f32> = (0..BANDS).map(|b| 1.0 / (1.0 + b as f32)).collect();
    let silence = vec![0.0; BANDS];
    let bands =
        Bands { left: &tone, right: &silence, mid: &tone, side: &tone, side_gain: 1.0, ringing: None };
    let mapping = Mapping { stereo_mu: 0.3, ..Mapping::direct(&ready.dancer.eigenvalues, BANDS) };
    let playing = Playing { form: Form::Filter, ..Playing::default() };
    let d = displacements(ready, &mapping, &bands, playing);
    let most = farthest(&d);
    let mut pairs = 0;
    let mut worst = 0.0f64;
    for v in 0..d.len() {
        if let Some(w) = mirror(v) {
            pairs += 1;
            let e = [d[v][0] + d[w][0], d[v][1] - d[w][1], d[v][2] - d[w][2]];
            worst = worst.max(e.iter().map(|c| c.abs()).fold(0.0, f64::max));
        }
    }
    assert!(most > 0.0 && pairs * 10 > d.len() * 9, "{most} {pairs}");
    assert!(worst < 1e-3 * most, "{worst} of {most}");
}

#[test]
fn a_loud_side_does_not_still_the_middle() {
    let ready = octopus();
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, BANDS);
    let mid = vec![0.3; BANDS];
    let middle = |side: f32| {
        let side = vec![side; BANDS];
        let bands = Bands { left: &mid, right: &mid, mid: &mid, side: &side, side_gain: 1.0, ringing: None };
        let playing = Playing { form: Form::Filter, ..Playing::default() };
        let mut player = Player::new(&mapping, &ready.dancer, BANDS, playing).unwrap();
        let mut item = player.item();
        player.play(&bands, &mut item).unwrap();
        let chladni_synth::Coefficients::Vector(c) = &item.terms[0].coefficients else { panic!() };
        let symmetric = c.iter().zip(&ready.dancer.classes).filter(|(_, class)| class.sign() > 0);
        symmetric.flat_map(|(c, _)| c.iter()).map(|c| c * c).sum::<f32>().sqrt()
    };
    let (alone, beside) = (middle(0.0), middle(10.0));
    assert!(alone > 0.0 && beside > 0.5 * alone, "{beside} of {alone}");
}

#[test]
fn a_preset_bred_on_the_octopus_plays_on_the_head() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut instrument = Instrument::new(11, 12, shape).unwrap();
    for item in [0, 1, 6] {
        instrument.apply(Moment::default(), Action::Choose { item, on: true }).unwrap();
    }
    instrument.apply(Moment::default(), Action::Breed).unwrap();
    let bred = instrument.gallery().items()[3].clone();
    let preset = Preset::from_text(&instrument.preset(&bred, vec![]).to_text().unwrap()).unwrap();
    assert_eq!(preset.mapping, bred.genome);
    assert_eq!(preset.name, format!("item {}", bred.id + 1));
    assert!(preset.lineage.len() >= 3);
    for ready in [octopus(), head()] {
        let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands: BANDS };
        let share = calibrated_share(ready, &preset.mapping_on(&shape));
        assert!(share >= 0.6 && share * f64::from(preset.mapping.gain) <= 2.7, "{share}");
    }
}

#[test]
fn a_preset_moves_a_shape_alike_with_half_and_twice_as_many_harmonics() {
    let fewer = {
        let mesh = samples::sample("octopus").unwrap();
        let body = Body::build(&mesh, &BasisSettings::new(K / 2), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes, &Orientation::default()).unwrap());
        Ready { body, dancer }
    };
    let more = octopus();
    let shape = |ready: &Ready| GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands: BANDS };
    // How far two movements are apart, as a share of the larger one.
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        let difference = |i: usize| std::array::from_fn(|axis| a[i][axis] - b[i][axis]);
        let differences: Vec<[f64; 3]> = (0..a.len()).map(difference).collect();
        farthest(&differences) / farthest(a).max(farthest(b))
    };
    // Once so soft that nothing is limited, and once far into the limit.
    for (made_on, level) in [(&fewer, 0.03), (more, 0.03), (&fewer, 0.6), (more, 0.6)] {
        let loud = vec![level; BANDS];
        let bands =
            Bands { left: &loud, right: &loud, mid: &loud, side: &loud, side_gain: 1.0, ringing: None };
        let mut instrument = Instrument::new(3, 6, shape(made_on)).unwrap();
        // Waves that both have.
        let top = K as f32 / 2.0 / made_on.dancer.harmonics() as f32;
        let transfer = (0..BANDS).map(|b| 0.9 * top * b as f32 / BANDS as f32).collect();
        let amplification =
            (0..made_on.dancer.harmonics()).map(|k| if k % 3 == 0 { -0.5 } else { 0.7 }).collect();
        let mapping = Mapping { transfer, amplification, stereo_mu: 0.0, gain: 0.4 };
        let load = Action::Load { item: 1, name: "made".into(), mapping: mapping.clone() };
        instrument.apply(Moment::default(), load).unwrap();
        let item = &instrument.gallery().items()[1];
        let text = instrument.preset(item, vec![]).to_text().unwrap();
        let preset = Preset::from_text(&text).unwrap();
        let moved = |ready: &Ready| {
            displacements(ready, &preset.mapping_on(&shape(ready)), &bands, Playing::default())
        };
        let own = displacements(made_on, &mapping, &bands, Playing::default());
        assert!(apart(&own, &moved(made_on)) < 1e-6);
        let by_waves = apart(&moved(&fewer), &moved(more));
        // As shares of K the same numbers mean other waves.
        let by_share = apart(
            &displacements(&fewer, &preset.mapping, &bands, Playing::default()),
            &displacements(more, &preset.mapping, &bands, Playing::default()),
        );
        assert!(
            by_waves < 0.02 && by_share > 0.2,
            "{by_waves} by waves, {by_share} by shares of K ({level})"
        );
    }
}

#[test]
fn left_is_the_left_of_the_viewer_however_the_shape_stands() {
    let Ready { body, dancer } = octopus();
    let on_the_left = |dancer: &Dancer, v: usize| dancer.sides.left[v] > 0.5;
    let turned = Orientation::new([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]).unwrap();
    let seen_from_behind = dancer.standing(body, &turned);
    let prepared_again = Dancer::new(body, &dancer.classes, &turned).unwrap();
    assert!(format!("{seen_from_behind:?}") == format!("{prepared_again:?}"), "only the halves are others");
    for (v, x) in body.positions.iter().enumerate().filter(|(_, x)| x[0].abs() > 0.3) {
        assert_eq!(on_the_left(dancer, v), x[0] < 0.0);
        assert_eq!(on_the_left(&seen_from_behind, v), x[0] > 0.0);
    }
}

#[test]
fn a_stroke_in_one_channel_rings_in_its_half_and_one_in_both_rings_alike() {
    let ready = octopus();
    let mapping = Mapping::direct(&ready.dancer.eigenvalues, BANDS);
    let (loud, silence) = (vec![0.5; BANDS], vec![0.0; BANDS]);
    let timbre = Timbre::NAMED[0].1;
    let energies = |form, left: &[f32], right: &[f32]| {
        let of = |alpha: f32, beta: f32| -> Vec<f32> {
            left.iter().zip(right).map(|(l, r)| (alpha * l + beta * r).abs()).collect()
        };
        let (mid, side) = (of(0.5, 0.5), of(5.0, -5.0));
        let struck = Bands { left, right, mid: &mid, side: &side, side_gain: 10.0, ringing: None };
        let mut bank = Resonators::new(&timbre, BANDS);
        bank.hear(&struck, 0.0);
        let playing = Playing { form, ..Playing::default() };
        let bands = Bands { ringing: Some(bank.ring(0.05)), ..struck };
        let d = displacements(ready, &mapping, &bands, playing);
        let mut energies = [0.0; 2];
        for (d, x) in d.iter().zip(&ready.body.positions) {
            // The seam belongs to neither half.
            let weight = f64::from(u8::from(x[0].abs() > 1e-6));
            energies[usize::from(x[0] > 0.0)] += weight * d.iter().map(|c| c * c).sum::<f64>();
        }
        energies
    };
    for form in [Form::HalfMask, Form::Modal] {
        let [left, right] = energies(form, &loud, &silence);
        assert!(left > 2.0 * right, "{form:?}: {left} {right}");
        let [left, right] = energies(form, &silence, &loud);
        assert!(right > 2.0 * left, "{form:?}: {left} {right}");
    }
    for form in [Form::HalfMask, Form::Modal, Form::Filter] {
        let [left, right] = energies(form, &loud, &loud);
        assert!(left > 0.0 && (left / right - 1.0).abs() < 0.01, "{form:?}: {left} {right}");
    }
}
