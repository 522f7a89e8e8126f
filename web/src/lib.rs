//! Chladni in a browser: the engines and the program's own `work`, as a page calls them.
//!
//! Two halves meet here. A worker makes shapes and songs ready ([`prepare`], [`decode`]) and solves and matches what is
//! caricatured ([`solve`]), which takes seconds; the page holds a [`Concert`] or a [`Sitting`] and asks it for one
//! picture after the other. What a worker hands to a concert is a [`Parcel`](parcel::Parcel). Neither half has a formula
//! of its own.
//!
//! The module is built twice. That with the feature `page` is all of it, for one thread; the other, with `threads`, has
//! only the worker's half, for browsers that share memory between workers (`pool.rs`).

#![cfg_attr(not(feature = "page"), allow(dead_code, reason = "the page reads what the worker's half writes"))]

use std::path::{Path, PathBuf};

mod decode;
mod gallery;
mod ink;
mod numbers;
mod parcel;
#[cfg(feature = "threads")]
mod pool;
mod prepare;
mod reporter;
mod solve;

#[cfg(feature = "page")]
mod coarse;
#[cfg(feature = "page")]
mod concert;
#[cfg(feature = "page")]
mod film;
#[cfg(feature = "page")]
mod screen;
#[cfg(feature = "page")]
mod sitting;

use chladni_program::work::{OWN_COLORS, formats, playlist};
use chladni_view::{Background, Lights, Material, Palette};
#[cfg(feature = "page")]
pub use concert::Concert;
pub use decode::{DecodedSong, decode};
#[cfg(feature = "page")]
pub use film::FilmFrame;
pub use gallery::Wall;
pub use ink::Inker;
pub use prepare::prepare;
#[cfg(feature = "page")]
pub use screen::{card_lost, close_card, open_card};
#[cfg(feature = "page")]
pub use sitting::{Sitting, color_maps, head_sliders, quantities};
use wasm_bindgen::prelude::*;

/// A project as the page has it: in no folder.
const PROJECT: &str = "project.chladni";

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn log_error(text: &str);

    /// The clock of the page, in milliseconds.
    #[cfg(feature = "page")]
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn now_ms() -> f64;
}

/// Runs when the module is loaded: what goes wrong inside is written to the browser's console.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|info| log_error(&info.to_string())));
}

/// The names of all sample shapes, each with the look that it has first, as JSON: `[["octopus", "aurora"], …]`.
#[wasm_bindgen]
pub fn samples() -> Result<String, JsError> {
    let names = chladni_mesh::samples::SAMPLES;
    let look = |name: &str| chladni_program::work::opening_looks(&format!("sample:{name}")).look;
    let all: Vec<(&str, String)> = names.iter().map(|name| (*name, look(name))).collect();
    Ok(serde_json::to_string(&all)?)
}

/// The kind of a file, by its name: `mesh`, `song`, `text` (a show or a preset), `list`, `project`, or `unknown`.
#[wasm_bindgen]
pub fn kind(name: &str) -> String {
    let path = Path::new(name);
    match formats::kind(path) {
        formats::Kind::Mesh if !formats::ends_in(path, &formats::MESHES) => "unknown".to_owned(),
        kind => format!("{kind:?}").to_lowercase(),
    }
}

/// Those of these file names that are opened by themselves; what lies beside a shape is read with it.
#[wasm_bindgen]
pub fn without_companions(names: Vec<String>) -> Vec<String> {
    let paths: Vec<PathBuf> = names.into_iter().map(PathBuf::from).collect();
    formats::without_companions(&paths).iter().map(|path| path.to_string_lossy().into_owned()).collect()
}

/// The names of the songs in a list (M3U), without their folders.
#[wasm_bindgen]
pub fn songs_in_list(bytes: &[u8]) -> Vec<String> {
    playlist::names_in(bytes)
}

/// The names of all looks, as JSON.
#[wasm_bindgen]
pub fn looks() -> Result<String, JsError> {
    let names: Vec<&str> = chladni_view::Look::PRESETS.iter().map(|(name, _)| *name).collect();
    Ok(serde_json::to_string(&names)?)
}

/// The parts of a look that can be chosen for themselves, with their names, as JSON: `[["material", ["clay", …]], …]`.
#[wasm_bindgen]
pub fn look_parts() -> Result<String, JsError> {
    let parts = [
        ("material", Material::PRESETS.iter().map(|(name, _)| *name).collect::<Vec<&str>>()),
        ("lights", Lights::PRESETS.iter().map(|(name, _)| *name).collect()),
        ("background", Background::PRESETS.iter().map(|(name, _)| *name).collect()),
        ("palette", Palette::ALL.iter().map(|palette| palette.name()).chain([OWN_COLORS]).collect()),
    ];
    Ok(serde_json::to_string(&parts)?)
}
