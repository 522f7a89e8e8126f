//! The result of a film, and where the time went.

use chladni_task::counted;
use chladni_view::Samples;
use serde::Serialize;

use super::Approximation;

/// Where the time went, in seconds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading mesh and song.
    pub reading: f64,
    /// Harmonics, symmetry and all that is prepared once.
    pub preparing: f64,
    /// Beats of the whole song.
    pub beats: f64,
    /// Spectra.
    pub analysis: f64,
    /// From spectrum to coefficients.
    pub mapping: f64,
    /// Deformed positions.
    pub synthesis: f64,
    /// Normals.
    pub normals: f64,
    /// Drawing and fetching the pictures.
    pub drawing: f64,
    /// The flash guard's look at the frames.
    pub guarding: f64,
    /// Waiting for the encoder, which runs beside all this.
    pub encoding: f64,
    /// All.
    pub total: f64,
}

/// The output of `--json`.
#[derive(Serialize)]
pub struct Report {
    pub(super) vertices: usize,
    pub(super) harmonics: usize,
    /// Those that were made: fewer than the film has where only a piece of it, or the rest, was wanted.
    pub(super) frames: u64,
    /// How long those are.
    pub(super) film_secs: f64,
    pub(super) times_real_time: f64,
    pub(super) tempo_bpm: f64,
    pub(super) beat_confidence: f64,
    /// The farthest any vertex went, as a share of the bounding box's diagonal; unknown (null) where
    /// the shapes are deformed on a graphics card.
    pub(super) largest_displacement: Option<f32>,
    /// How a processor drew, where no graphics card did.
    #[serde(skip)]
    pub(super) by_processor: Option<Samples>,
    /// The adapter that drew, samples a pixel, and who deformed the shapes; null where nothing is drawn.
    pub(super) device: Option<String>,
    pub(super) samples: Option<u32>,
    pub(super) synthesis: Option<String>,
    pub(super) flashes_in_worst_second: usize,
    /// The longest time for which bright stripes covered more than a quarter of the picture.
    pub(super) longest_stripes_secs: f64,
    pub(super) frames_damped: usize,
    /// The part of the dance that a GLB holds; null for films.
    pub(super) approximation: Option<Approximation>,
    pub(super) seconds: Seconds,
}

impl Report {
    /// Whether no frame was left to make.
    pub fn made_nothing(&self) -> bool {
        self.frames == 0
    }

    /// The device that drew and its samples a pixel, if it is a processor rather than a graphics card.
    pub fn drawn_by_processor(&self) -> Option<(&str, Samples)> {
        self.device.as_deref().zip(self.by_processor)
    }

    /// Where the time went and, before it, how near the morph targets of a GLB come to the film, in a line each.
    pub fn lines(&self) -> Vec<String> {
        let near = self.approximation.as_ref().map(|approximation| {
            format!(
                "{} morph targets: {:.3} % of the size from the film on average, {:.2} % at most",
                approximation.targets,
                100.0 * approximation.mean_deviation,
                100.0 * approximation.largest_deviation
            )
        });
        let s = &self.seconds;
        let times = format!(
            "{} in {:.1} s: reading {:.1}, harmonics {:.1}, beats {:.1}, spectra {:.1}, mapping {:.2}, \
             synthesis {:.1}, normals {:.1}, drawing {:.1}, flash guard {:.1}, waiting for the encoder {:.1}",
            counted(self.frames, "frame", "frames"),
            s.total,
            s.reading,
            s.preparing,
            s.beats,
            s.analysis,
            s.mapping,
            s.synthesis,
            s.normals,
            s.drawing,
            s.guarding,
            s.encoding
        );
        near.into_iter().chain([times]).collect()
    }
}
