//! The natural vibrations of triangle meshes, under one name: this crate re-exports the engines
//! that the `chladni` program is made of. Depend on it to have all of them, or on the one you need.
//!
//! # A walk through the rooms
//!
//! A mesh is read exactly as its file stores it ([`mesh`]), and becomes a body with harmonics
//! ([`harmonics`]):
//!
//! ```
//! use chladni::harmonics::{BasisSettings, Body};
//! use chladni::mesh::samples;
//! use chladni::task::Task;
//!
//! let ring = samples::torus(0.4, 24, 12); // or chladni::mesh::load_mesh(path)
//! let body = Body::build(&ring, &BasisSettings::new(32), &Task::new())?;
//! assert!(body.basis.certificate.inertia_counts_match);
//! # Ok::<(), chladni::harmonics::HarmonicsError>(())
//! ```
//!
//! A Laplacian, or any other symmetric positive semidefinite matrix, may be your own
//! ([`harmonics::Pencil`]). `examples/` has a short program for each stop of this walk.
//!
//! Coefficients of the harmonics deform it ([`synth`]): here the second harmonic, along the normal.
//!
//! ```
//! # use chladni::{harmonics::{BasisSettings, Body}, mesh::samples, task::Task};
//! # let ring = samples::torus(0.4, 24, 12);
//! # let body = Body::build(&ring, &BasisSettings::new(32), &Task::new())?;
//! use chladni::synth::{Coefficients, CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer, Term};
//!
//! let mut along_normal = vec![0.0; 32];
//! along_normal[1] = 0.1;
//! let wave = Term { coefficients: Coefficients::Normal(along_normal), residual: None, residual_gain: 0.0, mask: None };
//! let mut synthesizer = CpuSynthesizer::new(SynthModel::new(&body)?);
//! synthesizer.synthesize(&[Item { terms: vec![wave] }], &FrameSettings::default())?;
//! assert_eq!(synthesizer.positions(0).len(), body.positions.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Two instruments decide what the coefficients are. [`caricature`] takes them from what makes a shape
//! differ from a template, which [`matching`] lays on it; [`music`] takes them from the bands of sound
//! that [`sound`] hears. [`view`] makes pictures and films of either.
//!
//! ```
//! # use chladni::{harmonics::{BasisSettings, Body}, mesh::samples, task::Task};
//! # let ring = samples::torus(0.4, 24, 12);
//! # let body = Body::build(&ring, &BasisSettings::new(32), &Task::new())?;
//! use chladni::caricature::{Layer, Project, ShapeSource, Stack, Template};
//!
//! let mut project = Project::new(ShapeSource::File("ring.obj".into()), 32);
//! project.push(Layer { mu: -0.4, ..Layer::new("plump", Template::Ellipsoid) })?;
//! let body = std::sync::Arc::new(body);
//! let mut stack = Stack::new(body.clone())?;
//! for request in stack.missing(&project) {
//!     let matched = request.run(&ring, &body, None, &Task::new());
//!     stack.install(request, matched);
//! }
//! let plump = stack.evaluate(&project).file_positions(&body, &ring.positions);
//! assert_ne!(plump, ring.positions);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not guaranteed: anything beyond what the page of each engine promises. Before version 1, minor
//! versions may rename items.

pub use chladni_caricature as caricature;
pub use chladni_harmonics as harmonics;
pub use chladni_match as matching;
pub use chladni_mesh as mesh;
pub use chladni_music as music;
pub use chladni_sound as sound;
pub use chladni_synth as synth;
pub use chladni_task as task;
pub use chladni_view as view;

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
