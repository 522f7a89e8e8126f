//! Cameras, lights, drawing meshes and heat maps, picking, off-screen pictures and film.
//!
//! ```
//! use chladni_view::{
//!     Camera, Device, Draw, PictureRequest, PictureShape, Style, View, ViewError, render_picture,
//! };
//!
//! let positions = [[0.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, -1.0, -1.0]];
//! let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
//! // A graphics card where there is one, else the processor.
//! let device = Device::open(Draw::Auto)?;
//! let picture = render_picture(&device, &PictureRequest {
//!     shapes: &[PictureShape { positions: &positions, triangles: &triangles, ..Default::default() }],
//!     width: 320,
//!     height: 240,
//!     from: Camera::looking(View::ThreeQuarter),
//!     style: Style::default(),
//! })?;
//! let png = picture.to_png()?;
//! assert!(png.starts_with(b"\x89PNG"));
//! # Ok::<(), ViewError>(())
//! ```
//!
//! Windows and films keep a [`Renderer`], [`Topology`] and [`ItemBuffers`] and draw [`Cell`]s of
//! [`Figure`]s on a [`Canvas`], all made for one [`Device`]; the buffers may belong to a synthesizer on
//! the same graphics device.
//!
//! Not guaranteed: pixels differ in their last bits from driver to driver, and from the processor. Translucent figures
//! are not sorted. Only the key light casts shadows, within a cell.

#![warn(clippy::missing_errors_doc)]
#![cfg_attr(
    not(feature = "gpu"),
    allow(
        dead_code,
        unreachable_code,
        unused_variables,
        reason = "what is kept for devices that nobody can have"
    )
)]

mod buffers;
mod camera;
mod canvas;
mod colormap;
mod cpu;
mod device;
mod error;
pub mod filling;
pub mod film;
mod finish;
mod focus;
pub mod framing;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
mod gpu;
pub mod ink;
pub mod layout;
mod look;
mod looks;
mod palette;
mod pick;
mod picture;
mod renderer;
mod request;
mod rest;
mod samples;
mod scene;
#[cfg(feature = "gpu")]
mod sharing;
mod style;
mod surroundings;
mod uniforms;

pub use buffers::{BrushRing, ItemBuffers, Skin, Topology, VertexPaint};
pub use camera::{Camera, Projection, Turntable, View};
pub use canvas::{Canvas, Readback};
pub use colormap::{ColorMap, Scale};
pub use device::{Device, Draw};
pub use error::ViewError;
pub use film::{Film, FilmFormat, FilmSettings, FrameRate, ffmpeg_is_there};
pub use finish::{Effect, Finish};
pub use gpu::Gpu;
pub use layout::Rect;
pub use look::{Look, Mood, Response};
pub use palette::{Answer, NodalLines, Palette};
pub use pick::{Hit, PickTree, Ray};
pub use picture::Picture;
pub use renderer::Renderer;
pub use request::{
    PictureRequest, PictureShape, Style, film_turntable, render_picture, render_picture_with, render_placed,
    smooth_normals,
};
pub use rest::{RestShape, bends};
pub use samples::Samples;
pub use scene::{Cell, Figure, Grain, Grains, IDENTITY, Marker, Paint, Wire};
pub use style::{Background, Curve, Floor, Gradient, Light, Lights, Material, srgb_bytes};
pub use surroundings::{Panorama, Surroundings};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
