//! A dance as a GLB file: the shape with morph targets, and their weights as an animation.

use std::path::Path;

use chladni_harmonics::Body;
use chladni_mesh::{MeshError, MorphAnimation, MorphTarget, TriMesh, write_animated_glb};
use chladni_music::Form;
use chladni_synth::{Item, Morph, Movement, displacements_f64};
use chladni_task::Task;
use chladni_view::FrameRate;
use rayon::prelude::*;
use serde::Serialize;

use crate::work::{Error, write_file};

/// At most this many frames are compared with the film.
const JUDGED_FRAMES: u64 = 48;

/// A recorded dance.
pub struct Animation {
    movement: Movement,
    /// Some frames as they are filmed.
    judged: Vec<(usize, Item)>,
    judge_every: u64,
    form: Form,
    box_diagonal: f32,
}

/// How near a file with morph targets comes to a dance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Approximation {
    /// Morph targets.
    pub targets: usize,
    /// How far its positions are from those of the film, as a share of the bounding box's diagonal: mean over
    /// vertices and frames.
    pub mean_deviation: f64,
    /// The farthest.
    pub largest_deviation: f64,
}

impl Animation {
    /// An animation of this many frames, by a body whose box has this diagonal.
    pub fn new(frames: u64, box_diagonal: f32) -> Self {
        Self {
            movement: Movement::default(),
            judged: Vec::new(),
            judge_every: frames.div_ceil(JUDGED_FRAMES).max(1),
            form: Form::default(),
            box_diagonal,
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, form: Form, item: &Item) {
        let frame = self.movement.frames();
        if (frame as u64).is_multiple_of(self.judge_every) {
            self.judged.push((frame, item.clone()));
        }
        self.form = form;
        self.movement.push(item);
    }

    /// Writes `mesh`, whose body is `body`, with at most `most` targets and an offset.
    ///
    /// # Errors
    /// [`Error::Input`] where nothing moves, [`Error::Unwritten`] with the file's name,
    /// [`Error::Synth`], and cancelled.
    pub fn write(
        &self,
        path: &Path,
        mesh: &TriMesh,
        body: &Body,
        rate: FrameRate,
        most: usize,
        task: &Task,
    ) -> Result<Approximation, Error> {
        let found = self.movement.morphs(most, || task.check())?;
        if found.morphs.is_empty() {
            let path = path.display();
            return Err(Error::Input(format!(
                "{path}: nothing moves in this dance, so that it has no targets"
            )));
        }
        let displacements: Vec<Vec<[f64; 3]>> = found
            .morphs
            .par_iter()
            .map(|morph| {
                task.check()?;
                Ok(displacements_f64(body, &morph.item)?)
            })
            .collect::<Result<_, Error>>()?;
        let (displacements, weights) = from_zero_to_one(displacements, &found.weights);
        let approximation = self.approximation(body, &weights, &displacements, task)?;
        let names = found.morphs.iter().map(|morph| self.name(morph)).chain([OFFSET.to_owned()]);
        let targets: Vec<MorphTarget> = (names.zip(&displacements))
            .map(|(name, d)| MorphTarget { name, displacements: body.displacements_in_file(d) })
            .collect();
        let times_secs: Vec<f32> =
            (0..self.movement.frames()).map(|frame| rate.start_secs(frame as u64) as f32).collect();
        let animation = MorphAnimation { name: "dance", times_secs: &times_secs, weights: &weights };
        let bytes = write_animated_glb(mesh, &targets, animation, task).map_err(|error| match error {
            MeshError::Cancelled(cancelled) => Error::from(cancelled),
            error => Error::unwritten(path, error),
        })?;
        task.check()?;
        write_file(path, &bytes)?;
        Ok(approximation)
    }

    /// Compares with the film.
    fn approximation(
        &self,
        body: &Body,
        weights: &[f32],
        targets: &[Vec<[f64; 3]>],
        task: &Task,
    ) -> Result<Approximation, Error> {
        let count = targets.len();
        let frames: Vec<(f64, f64)> = self
            .judged
            .par_iter()
            .map(|(frame, item)| {
                task.check()?;
                let mut off = displacements_f64(body, item)?;
                for (target, w) in targets.iter().zip(&weights[frame * count..]) {
                    let w = f64::from(*w);
                    off.iter_mut().zip(target).for_each(|(d, t)| (0..3).for_each(|i| d[i] -= w * t[i]));
                }
                let lengths = off.iter().map(|d| d.iter().map(|c| c * c).sum::<f64>().sqrt());
                Ok(lengths.fold((0.0, 0.0), |(sum, most), d| (sum + d, f64::max(most, d))))
            })
            .collect::<Result<_, Error>>()?;
        let diagonal = f64::from(self.box_diagonal).max(f64::MIN_POSITIVE);
        let all = (self.judged.len() * body.positions.len()).max(1) as f64;
        let (sum, most) = frames.iter().fold((0.0, 0.0), |(s, m), frame| (s + frame.0, f64::max(m, frame.1)));
        Ok(Approximation {
            targets: count,
            mean_deviation: sum / all / diagonal,
            largest_deviation: most / diagonal,
        })
    }

    fn name(&self, morph: &Morph) -> String {
        let what = morph.harmonic.map_or_else(|| "detail".to_owned(), |k| format!("harmonic {k}"));
        match (self.form, &morph.terms[..]) {
            (Form::HalfMask, [0]) => format!("{what}, left"),
            (Form::HalfMask, [1]) => format!("{what}, right"),
            _ => what,
        }
    }
}

/// The target of weight 1 that makes up for the other weights being positive.
const OFFSET: &str = "offset";

/// The same movement with weights in [0, 1], as Blender cuts others off: each target spans what its weight
/// went through, and one more, of constant weight, holds where they begin.
fn from_zero_to_one(mut targets: Vec<Vec<[f64; 3]>>, weights: &[f32]) -> (Vec<Vec<[f64; 3]>>, Vec<f32>) {
    let count = targets.len();
    let mut offset = vec![[0.0; 3]; targets.first().map_or(0, Vec::len)];
    let mut positive = vec![1.0; weights.len() / count.max(1) * (count + 1)];
    for (j, target) in targets.iter_mut().enumerate() {
        let own = || weights.iter().skip(j).step_by(count).copied();
        let (least, most) = own().fold((f32::MAX, f32::MIN), |(least, most), w| (least.min(w), most.max(w)));
        let span = most - least;
        for (v, o) in target.iter_mut().zip(&mut offset) {
            (0..3).for_each(|i| o[i] += f64::from(least) * v[i]);
            *v = v.map(|x| f64::from(span) * x);
        }
        for (row, w) in positive.chunks_mut(count + 1).zip(own()) {
            row[j] = if span > 0.0 { (w - least) / span } else { 0.0 };
        }
    }
    targets.push(offset);
    (targets, positive)
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{Format, read_mesh, samples};
    use chladni_synth::{Coefficients, Term};

    use super::*;

    fn frame(f: usize) -> Item {
        let at = f as f32 / 7.0;
        let coefficients = (0..9).map(|k| [(at * k as f32).sin(), 0.1 * at, 0.03]).collect();
        let term = Term {
            coefficients: Coefficients::Vector(coefficients),
            residual: None,
            residual_gain: 0.0,
            mask: None,
        };
        Item { terms: vec![term] }
    }

    /// What a file holds of a dance.
    struct Dance {
        times_secs: Vec<f32>,
        weights: Vec<f32>,
        /// Of each target the three coordinates of every vertex.
        targets: Vec<Vec<f32>>,
    }

    impl Dance {
        fn read(glb: &[u8]) -> Self {
            let json_bytes = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
            let root: serde_json::Value = serde_json::from_slice(&glb[20..20 + json_bytes]).unwrap();
            let data = &glb[20 + json_bytes + 8..];
            let floats = |accessor: &serde_json::Value| -> Vec<f32> {
                let accessor = &root["accessors"][accessor.as_u64().unwrap() as usize];
                let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
                let [from, length] =
                    ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
                let bytes = data[from..from + length].chunks(4);
                bytes.map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
            };
            let sampler = &root["animations"][0]["samplers"][0];
            let targets = root["meshes"][0]["primitives"][0]["targets"].as_array().unwrap();
            Self {
                times_secs: floats(&sampler["input"]),
                weights: floats(&sampler["output"]),
                targets: targets.iter().map(|target| floats(&target["POSITION"])).collect(),
            }
        }
    }

    #[test]
    fn targets_times_weights_are_the_film() {
        let mut mesh = samples::icosphere(2);
        mesh.positions.iter_mut().for_each(|p| *p = [50.0 * p[0] + 3.0, 40.0 * p[1], 20.0 * p[2]]);
        let body = Body::build(&mesh, &BasisSettings::new(9), &Task::new()).unwrap();
        let mut animation = Animation::new(20, 2.0);
        (0..20).for_each(|f| animation.push(Form::Filter, &frame(f)));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let rate = FrameRate::per_second(10);
        let write = |most| animation.write(&path, &mesh, &body, rate, most, &Task::new()).unwrap();
        let cancelled = Task::new();
        cancelled.cancel();
        let stopped = animation.write(&path, &mesh, &body, rate, 1000, &cancelled).map(drop).unwrap_err();
        assert!(stopped.is_cancelled() && !path.exists());
        let all = write(1000);
        assert!(all.largest_deviation < 1e-6, "{all:?}");
        let dance = Dance::read(&std::fs::read(&path).unwrap());
        assert_eq!((dance.times_secs.len(), dance.targets.len()), (20, all.targets));
        for (f, weights) in dance.weights.chunks(all.targets).enumerate() {
            assert_eq!(dance.times_secs[f], f as f32 / 10.0);
            let filmed = body.displacements_in_file(&displacements_f64(&body, &frame(f)).unwrap());
            for (v, moved) in filmed.iter().enumerate() {
                for (i, wanted) in moved.iter().enumerate() {
                    let shares = weights.iter().zip(&dance.targets);
                    let found: f64 = shares.map(|(w, t)| f64::from(*w) * f64::from(t[3 * v + i])).sum();
                    assert!((found - wanted).abs() < 1e-3, "frame {f}: {found} for {wanted}");
                }
            }
        }
        let few = write(3);
        assert!(few.targets == 4 && few.largest_deviation > 1e-3, "{few:?}");
        assert!(few.mean_deviation < few.largest_deviation);
        let back = read_mesh(&std::fs::read(&path).unwrap(), Format::Glb).unwrap().mesh;
        assert!(back.positions.iter().zip(&mesh.positions).all(|(a, b)| (a[0] - b[0]).abs() < 1e-4));
    }

    #[test]
    fn a_dance_without_movement_is_refused() {
        let mesh = samples::icosphere(1);
        let body = Body::build(&mesh, &BasisSettings::new(4), &Task::new()).unwrap();
        let mut animation = Animation::new(1, 2.0);
        animation.push(Form::Filter, &Item::default());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let rate = FrameRate::per_second(10);
        let error = animation.write(&path, &mesh, &body, rate, 8, &Task::new()).map(drop).unwrap_err();
        assert!(error.to_string().contains("nothing moves"));
        assert!(!path.exists());
    }
}
