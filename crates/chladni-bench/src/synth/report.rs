//! The output of a measurement.

use chladni_synth::SynthModel;
use serde::Serialize;

use super::BackendName;
use super::rows::Row;

/// One line of the result. Times are medians per frame.
#[derive(Serialize)]
pub struct Measured {
    model: &'static str,
    vertices: usize,
    harmonics: usize,
    items: usize,
    backend: BackendName,
    device: String,
    synthesis_ms: f64,
    normals_ms: f64,
    /// Null if nothing was drawn. Includes the upload of a frame made on the CPU.
    draw_ms: Option<f64>,
    /// The device that drew.
    drawn_by: Option<String>,
    /// Of synthesis and normals.
    fps: f64,
    /// With drawing.
    drawn_fps: Option<f64>,
    /// The paper's figure, if it gives one.
    published_fps: Option<f64>,
    /// Bytes of the basis read and of positions written.
    bytes_moved: usize,
    /// Bytes moved per second of synthesis, over those of a copy of the basis in the same run.
    bandwidth_share: f64,
}

/// Times of one frame, in seconds.
pub struct Times {
    pub device: String,
    pub synthesis: f64,
    pub normals: f64,
    /// Where it was drawn; with the upload of a frame made on the CPU.
    pub draw: Option<f64>,
    /// The device that drew.
    pub drawn_by: Option<String>,
    /// A copy of as many bytes as the basis.
    pub copy: f64,
}

impl Times {
    /// The line that this makes.
    pub fn report(
        self,
        row: &Row,
        items: usize,
        backend: BackendName,
        published_fps: Option<f64>,
        model: &SynthModel,
    ) -> Measured {
        let bytes_moved = model.basis_bytes() + 12 * items * row.vertices;
        // A copy reads and writes.
        let copied_per_sec = 2.0 * model.basis_bytes() as f64 / self.copy;
        Measured {
            model: row.model,
            vertices: row.vertices,
            harmonics: row.harmonics,
            items,
            backend,
            device: self.device,
            synthesis_ms: 1e3 * self.synthesis,
            normals_ms: 1e3 * self.normals,
            draw_ms: self.draw.map(|draw| 1e3 * draw),
            drawn_by: self.drawn_by,
            fps: 1.0 / (self.synthesis + self.normals),
            drawn_fps: self.draw.map(|draw| 1.0 / (self.synthesis + self.normals + draw)),
            published_fps,
            bytes_moved,
            bandwidth_share: bytes_moved as f64 / self.synthesis / copied_per_sec,
        }
    }
}

/// Names of the columns of [`Measured::line`].
pub const HEAD: &str = "model                n     K   S  backend  synthesis   normals   drawing       fps  published  bandwidth";

impl Measured {
    /// For people.
    pub fn line(&self) -> String {
        let backend = match self.backend {
            BackendName::Cpu => "cpu",
            BackendName::Gpu => "gpu",
        };
        let draw = self.draw_ms.map_or("-".into(), |draw| format!("{draw:.2} ms"));
        let published = self.published_fps.map_or("-".into(), |fps| format!("{fps:.1}"));
        format!(
            "{:<14} {:>7} {:>5} {:>3}  {backend:<7} {:>7.2} ms {:>6.2} ms {draw:>9} {:>9.1} {published:>10} {:>8.0} %",
            self.model,
            self.vertices,
            self.harmonics,
            self.items,
            self.synthesis_ms,
            self.normals_ms,
            self.fps,
            100.0 * self.bandwidth_share,
        )
    }
}
