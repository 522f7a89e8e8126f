//! The work itself, for the window and the commands alike: from the name of a shape to its harmonics, a
//! caricature, a dance and a film. It depends neither on a window nor on a command line, and prints nothing:
//! it reports to a [`Watcher`].

mod back_film;
mod bars;
pub mod body;
#[cfg(feature = "desktop")]
mod caption;
mod cast;
mod clock;
#[cfg(feature = "desktop")]
mod cover;
mod dance_text;
pub mod dancer;
#[cfg(feature = "desktop")]
mod deformed;
pub mod drawn_curve;
mod ear;
mod error;
mod exhibition;
mod files;
#[cfg(feature = "desktop")]
pub mod film;
pub mod formats;
mod frame_guard;
mod furthest;
mod health;
mod hearing;
mod heat;
mod held;
mod ink;
pub mod knobs;
mod lag;
pub mod landmarks;
pub mod left_out;
#[cfg(feature = "desktop")]
mod lettering;
mod live_back_film;
pub mod mask;
mod mood;
mod opening_look;
pub mod outputs;
mod own_look;
mod parts;
mod piece;
mod place_colors;
pub mod playlist;
mod programme;
mod recent;
mod region_look;
mod sand;
pub mod scale_plot;
mod scenery;
mod sculpture;
mod sitter;
pub mod source;
mod stance;
mod starting_point;
mod subject;
mod swelling;
mod symmetry_figure;
#[cfg(feature = "desktop")]
mod system_fonts;
mod template;
mod template_name;
mod template_text;
mod theatre;
#[cfg(feature = "desktop")]
mod titles;
mod tuning;
mod watcher;
mod writing;

pub use back_film::FILMS;
pub use bars::{bar_lines, read_beats};
#[cfg(feature = "desktop")]
pub use caption::Caption;
pub use cast::Cast;
pub use clock::{Playing, ShowClock};
#[cfg(feature = "desktop")]
pub use cover::cover_of;
pub use dance_text::is_like_a_show;
#[cfg(feature = "desktop")]
pub use deformed::Deformed;
pub use ear::{BeatCount, Ear};
pub use error::{Error, Warning};
pub use exhibition::{Exhibition, FIRST_SEED, Step, hung};
pub use files::{
    changed_since, file_hash, find, is_far, is_hidden, is_lost, known_hash, name_in, placed, refer,
    refer_looks, resolve, resolve_looks, shown_name, unread,
};
pub use frame_guard::FrameGuard;
pub use furthest::{MAY_FOLD, furthest_mu};
pub use health::{HealthRow, digits, health_rows, is_sound, laplacian_row};
pub use hearing::{Heard, Hearing, KnownSong, bands_of};
pub use heat::{Coating, Quantity, Seen, coating};
pub use ink::{Depth, Inked, Pen, USUAL_TONES, pen, plate};
pub use lag::Lag;
#[cfg(feature = "desktop")]
pub use lettering::Lettering;
pub use live_back_film::LiveBackFilm;
pub use opening_look::{look_under_sand, opening_looks, opening_view};
pub use own_look::{OwnLook, OwnPaint, texture_colors};
pub use parts::{Parts, body_of_limbs, twins_of};
pub use piece::{Piece, Share};
pub use place_colors::place_colors;
pub use programme::Programme;
pub use recent::Recent;
pub use region_look::{MARKED, PAINTED, RING, lay_ring, tints, with_pointed};
pub use sand::SandTable;
pub use scenery::{PANORAMAS, PICTURES, Scenery};
pub use sculpture::{Made, Sculpture, make, settled};
pub use sitter::{HEADLIKE, head_parts, sitter};
pub use stance::Stance;
pub use starting_point::{STARTING_POINTS, StartingPoint, layer_against, layer_since, results};
pub use subject::Subject;
pub use swelling::{Swelling, swollen_at};
pub use symmetry_figure::figure_markers;
#[cfg(feature = "desktop")]
pub use system_fonts::system_fonts;
pub use template::{check_template, check_templates, is_namesake, matched, matched_with, template_mesh};
pub use template_name::template_name;
pub use template_text::{template_from, template_text};
pub use theatre::{
    FIRST_VIEW, OWN_COLORS, Staged, Staging, Wardrobe, along, blur, cautions, chooses_shots, dots,
    first_looks, is_flat, look_named, look_on_stage, reaction,
};
#[cfg(feature = "desktop")]
pub use titles::{COVER, GAP, TITLE, halo_offsets, halo_opacity, title_opacity};
pub use watcher::{Aside, Watcher};
pub use writing::{make_folder, write_file};

/// The default K, in the window and on the command line.
pub const HARMONICS: usize = 512;
