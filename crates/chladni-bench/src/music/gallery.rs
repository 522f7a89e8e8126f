//! Do all items of a gallery move, and does none of them turn the surface over?

use chladni_caricature::{Surface, flipped_triangles};
use chladni_music::{
    Action, Bands, Beat, Ensemble, Form, GalleryShape, Instrument, Mapping, Moment, Parameters, Player,
    Playing, Resonators, repertoire,
};
use chladni_sound::{Song, SpectrumAnalyzer, SpectrumSettings};
use chladni_synth::{CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer, displacements_f64};
use serde::Serialize;

use super::ready::{HARMONICS, Ready};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, bands_of, source};

/// S.
pub const ITEMS: usize = 12;
/// Frames a second at which movement is measured.
const RATE_HZ: f64 = 10.0;
/// How much of each song.
const SECS: f64 = 20.0;

/// The share of a shape's triangles that are turned over in the worst item of a gallery and its worst moment.
#[derive(Serialize)]
pub struct Folds {
    pub shape: String,
    pub triangles: usize,
    pub form: Form,
    /// Which gallery, or the name of a built-in dance.
    pub gallery: String,
    /// Every band of both channels at full scale, and of one.
    pub all_bands: f64,
    /// One band at full scale.
    pub one_band: f64,
}

/// How far the items of a gallery move, as shares of the box's diagonal: root mean square over the surface, mean
/// over time and songs.
#[derive(Serialize)]
pub struct Movement {
    pub shape: String,
    pub gallery: &'static str,
    /// Of each item, in order.
    pub items: Vec<f64>,
    /// Of each item, how much changes within a tenth of a second.
    pub changes: Vec<f64>,
    /// Of each item, by how many degrees its normals are turned: what the eye reads of a ripple.
    pub turns_deg: Vec<f64>,
    /// The least moved item over the median one.
    pub least: f64,
    /// The least changing item over the median one.
    pub least_change: f64,
    /// The least turned item over the median one.
    pub least_turn: f64,
}

/// The mesh in a file, ready to dance.
pub fn shape(file: &str, terminal: &Terminal) -> Result<Ready, Error> {
    let name = std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
    Ready::new(&name, &source::mesh(file, terminal)?, HARMONICS, terminal)
}

/// The initial gallery of a seed, and one bred from all of it.
fn galleries(ready: &Ready, form: Form) -> Result<[(&'static str, Instrument); 2], Error> {
    let bands = SpectrumSettings::new(44_100).bands;
    let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands };
    let mut initial = Instrument::new(2012, ITEMS, shape)?;
    initial.apply(Moment::default(), Action::SetForm { form })?;
    let mut bred = initial.clone();
    let mut act = |action| bred.apply(Moment::default(), action);
    (0..ITEMS).try_for_each(|item| act(Action::Choose { item, on: true }))?;
    act(Action::Breed)?;
    Ok([("initial", initial), ("bred", bred)])
}

/// Folds in all forms, and of the built-in dances, each in its own.
pub fn folds(ready: &Ready) -> Result<Vec<Folds>, Error> {
    let bands = SpectrumSettings::new(44_100).bands;
    let mut rows = Vec::new();
    let row = |form, gallery: &str, [all_bands, one_band]: [f64; 2]| {
        let (shape, triangles) = (ready.name.clone(), ready.body.triangles.len());
        Folds { shape, triangles, form, gallery: gallery.to_owned(), all_bands, one_band }
    };
    for form in [Form::HalfMask, Form::Filter, Form::Modal] {
        let playing = Playing { form, ..Playing::default() };
        for (gallery, instrument) in galleries(ready, form)? {
            let mut worst = [0.0f64; 2];
            for shown in instrument.gallery().items() {
                let folded = worst_folds(ready, &shown.genome, playing)?;
                worst = std::array::from_fn(|i| worst[i].max(folded[i]));
            }
            rows.push(row(form, gallery, worst));
        }
    }
    let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands };
    for preset in repertoire()? {
        let mut parameters = Parameters::default();
        parameters.apply(&preset.settings)?;
        let worst = worst_folds(ready, &preset.mapping_on(&shape), parameters.playing())?;
        rows.push(row(parameters.form, &preset.name, worst));
    }
    Ok(rows)
}

/// The share of triangles that are turned over by all bands, and by one, at full scale.
fn worst_folds(ready: &Ready, mapping: &Mapping, playing: Playing) -> Result<[f64; 2], Error> {
    let surface = Surface::new(&ready.body);
    let folded = |item: &Item| -> Result<f64, Error> {
        let x = &ready.body.positions;
        let d = displacements_f64(&ready.body, item)?;
        let moved: Vec<[f64; 3]> =
            x.iter().zip(&d).map(|(x, d)| std::array::from_fn(|i| x[i] + d[i])).collect();
        Ok(flipped_triangles(&surface, x, &moved).len() as f64 / ready.body.triangles.len() as f64)
    };
    let bands = SpectrumSettings::new(44_100).bands;
    let (full, silence) = (vec![1.0; bands], vec![0.0; bands]);
    let mut player = Player::new(mapping, &ready.dancer, bands, playing)?;
    let mut item = player.item();
    let mut worst = |left: &[f32], right: &[f32], mid: &[f32], side: &[f32]| {
        let heard = Bands { left, right, mid, side, side_gain: 1.0, ringing: None };
        player.play(&heard, &mut item)?;
        folded(&item)
    };
    let (mut all_bands, mut one_band) = (0.0f64, 0.0f64);
    for (left, right, mid, side) in
        [(&full, &full, &full, &silence), (&full, &silence, &full, &full), (&full, &full, &full, &full)]
    {
        all_bands = all_bands.max(worst(left, right, mid, side)?);
    }
    // Bands that drive the same harmonic have the same effect.
    let targets = mapping.targets(bands, HARMONICS);
    for band in (0..bands).filter(|&b| !targets[..b].contains(&targets[b])) {
        let mut one = silence.clone();
        one[band] = 1.0;
        one_band = one_band.max(worst(&one, &one, &one, &one)?);
    }
    Ok([all_bands, one_band])
}

/// Movement in the default form.
pub fn movement(ready: &Ready, songs: &[Song]) -> Result<Vec<Movement>, Error> {
    let mut rows = Vec::new();
    for (gallery, instrument) in galleries(ready, Form::default())? {
        let mut sum = Moved::default();
        for song in songs {
            sum.add(&moved(ready, &instrument, song)?, 1.0 / songs.len() as f64);
        }
        let [least, least_change, least_turn] =
            [&sum.ways, &sum.changes, &sum.turns_deg].map(|values| least_over_median(values));
        let Moved { ways: items, changes, turns_deg } = sum;
        let shape = ready.name.clone();
        rows.push(Movement { shape, gallery, items, changes, turns_deg, least, least_change, least_turn });
    }
    Ok(rows)
}

/// Songs that are files or `sample:tune`, as much of each as is used.
pub fn songs(names: &[String], terminal: &Terminal) -> Result<Vec<Song>, Error> {
    names.iter().map(|name| source::song(name, 0.0, Some(SECS), terminal)).collect()
}

/// Of some values the least over the median.
pub fn least_over_median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |i: usize| sorted.get(i).copied().unwrap_or(0.0);
    let median = 0.5 * (at(sorted.len().saturating_sub(1) / 2) + at(sorted.len() / 2));
    if median > 0.0 { at(0) / median } else { 0.0 }
}

/// Means over time, for each item.
#[derive(Default)]
pub struct Moved {
    /// The displacement, as a share of the box's diagonal.
    pub ways: Vec<f64>,
    /// The change from one moment to the next, as such a share.
    pub changes: Vec<f64>,
    /// The turn of the normals.
    pub turns_deg: Vec<f64>,
}

impl Moved {
    fn add(&mut self, other: &Self, share: f64) {
        let pairs = [
            (&mut self.ways, &other.ways),
            (&mut self.changes, &other.changes),
            (&mut self.turns_deg, &other.turns_deg),
        ];
        for (sum, values) in pairs {
            sum.resize(values.len(), 0.0);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
        }
    }
}

/// How the items of a gallery move to a song, with all knobs as they are.
pub fn moved(ready: &Ready, instrument: &Instrument, song: &Song) -> Result<Moved, Error> {
    let settings = SpectrumSettings::new(song.rate_hz);
    let bands = settings.bands;
    let mut analyzer = SpectrumAnalyzer::new(settings)?;
    let mut bank = instrument.parameters().timbre().map(|timbre| Resonators::new(&timbre, bands));
    let mut ensemble = Ensemble::new(ready.dancer.clone());
    let mut synthesizer = CpuSynthesizer::new(SynthModel::new(&ready.body)?);
    let mut last: Vec<Vec<[f32; 3]>> = vec![synthesizer.model().rest_positions().to_vec(); ITEMS];
    let (rest, rest_normals) = (last[0].clone(), synthesizer.model().rest_normals().to_vec());
    let mut sum = Moved { ways: vec![0.0; ITEMS], changes: vec![0.0; ITEMS], turns_deg: vec![0.0; ITEMS] };
    let window = analyzer.window_frames();
    let (mut left, mut right) = (vec![0.0; window], vec![0.0; window]);
    // The spectrum is taken more often than the movement, as in a film.
    const STEPS: u32 = 3;
    const STEP_SECS: f64 = 1.0 / (RATE_HZ * STEPS as f64);
    let frames = (song.duration_secs() * RATE_HZ) as usize;
    for frame in 0..frames {
        for step in 0..STEPS {
            let secs = frame as f64 / RATE_HZ + f64::from(step) * STEP_SECS;
            let end = (secs * f64::from(song.rate_hz)) as i64 + window as i64 / 2;
            song.window_ending_at(end, &mut left, &mut right);
            analyzer.analyze(&left, &right, STEP_SECS);
            if let Some(bank) = &mut bank {
                bank.hear(&bands_of(analyzer.spectrum()), STEP_SECS as f32);
            }
        }
        let ringing = bank.as_mut().map(|bank| bank.ring(0.0));
        let bands = Bands { ringing, ..bands_of(analyzer.spectrum()) };
        let items = ensemble.play(instrument, &bands, Beat::default())?;
        synthesizer.synthesize(items, &FrameSettings::default())?;
        for (item, last) in last.iter_mut().enumerate() {
            let now = synthesizer.positions(item);
            sum.ways[item] += root_mean_square(ready, now, &rest);
            sum.changes[item] += root_mean_square(ready, now, last);
            // A chord of the unit sphere, about as long as the angle.
            let chord = root_mean_square(ready, synthesizer.normals(item), &rest_normals);
            sum.turns_deg[item] += (2.0 * (0.5 * chord).min(1.0).asin()).to_degrees();
            last.copy_from_slice(now);
        }
    }
    let count = frames.max(1) as f64;
    let share = 1.0 / (count * f64::from(ready.dancer.box_diagonal));
    sum.ways.iter_mut().chain(&mut sum.changes).for_each(|sum| *sum *= share);
    sum.turns_deg.iter_mut().for_each(|sum| *sum /= count);
    Ok(sum)
}

fn root_mean_square(ready: &Ready, a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let mass = &ready.body.basis.mass;
    let squared =
        |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>();
    let sum: f64 = a.iter().zip(b).map(squared).zip(mass).map(|(d, m)| m * d).sum();
    (sum / mass.iter().sum::<f64>()).sqrt()
}
