//! The natural vibrations of triangle meshes: this crate re-exports, under one name, the engines of the
//! `chladni` program. Depend on it for all of them, or on a single engine if you need only that.
//!
//! # A tour
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
//! assert_eq!(body.basis.certificate.inertia_counts_match, Some(true));
//! # Ok::<(), chladni::harmonics::HarmonicsError>(())
//! ```
//!
//! Instead of the mesh's Laplacian you can use your own, or any other symmetric positive semidefinite
//! matrix ([`harmonics::Pencil`]). `examples/` has a short program for each step of this tour.
//!
//! Coefficients of the harmonics deform the body ([`synth`]); here the second harmonic, along the normal:
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
//! Two instruments compute the coefficients. [`caricature`] derives them from the differences between a
//! shape and a template, after [`matching`] has found corresponding points. [`music`] derives them from the
//! frequency bands of sound that [`sound`] analyzes. The galleries of both are bred by [`breeding`]. [`view`]
//! renders pictures and films of the results.
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
//! Not guaranteed: anything beyond what the page of each crate promises. Before version 1, minor versions
//! may rename items.

pub use chladni_breeding as breeding;
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
