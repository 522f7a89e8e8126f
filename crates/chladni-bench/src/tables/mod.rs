//! `chladni-bench tables`: the rows of Table 1 of both papers, end to end, on real meshes and with
//! their own harmonics.

mod caricature;
mod frame;
mod music;
mod stroke;

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::TriMesh;
use serde::Serialize;

use crate::easel::Easel;
use chladni_program::cli::Terminal;
use chladni_program::work::body::laplacian;
use chladni_program::work::{Error, Watcher};

/// Time what Table 1 of each paper times, on meshes.
#[derive(clap::Args)]
pub struct BenchTables {
    /// A row of the caricature paper's table: SHAPE=TEMPLATE, each as `chladni caricature` takes it.
    #[arg(long, value_name = "SHAPE=TEMPLATE", value_parser = pair)]
    caricature: Vec<(String, String)>,
    /// A row of the music paper's table: MESH=K.
    #[arg(long, value_name = "MESH=K", value_parser = pair)]
    music: Vec<(String, String)>,
    /// K of the caricature rows.
    #[arg(long, value_name = "K", default_value_t = 512)]
    harmonics: usize,
    /// The papers' plain cotangent Laplacian, which not every mesh can have.
    #[arg(long)]
    paper: bool,
    /// Frames measured; medians count.
    #[arg(long, default_value_t = 9)]
    frames: usize,
}

fn pair(text: &str) -> Result<(String, String), Error> {
    let (name, with) = text.rsplit_once('=').ok_or_else(|| Error::input("write it as NAME=WHAT"))?;
    Ok((name.to_owned(), with.to_owned()))
}

/// The output, as JSON.
#[derive(Serialize)]
struct Tables {
    threads: usize,
    device: String,
    caricature: Vec<caricature::Row>,
    music: Vec<music::Row>,
}

impl BenchTables {
    /// Measures all rows and prints them.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let mut easel = Easel::new()?;
        let (mut caricature, mut music) = (Vec::new(), Vec::new());
        for (shape, template) in &self.caricature {
            caricature.push(self.caricature_row(shape, template, &mut easel, terminal)?);
        }
        for (mesh, harmonics) in &self.music {
            let harmonics = harmonics
                .parse()
                .map_err(|_| Error::input(format_args!("{mesh}={harmonics}: K is a number")))?;
            music.extend(self.music_rows(mesh, harmonics, &mut easel, terminal)?);
        }
        let device = easel.device.description();
        terminal.json(&Tables { threads: rayon::current_num_threads(), device, caricature, music })
    }

    /// A body solved here and now, whatever lies in the cache, and the seconds it took.
    fn solve(
        &self,
        name: &str,
        mesh: &TriMesh,
        harmonics: usize,
        terminal: &Terminal,
    ) -> Result<(Body, f64), Error> {
        let settings = BasisSettings { laplacian: laplacian(self.paper), ..BasisSettings::new(harmonics) };
        let built =
            terminal.watch("solving for harmonics", |task| Body::load_or_build(mesh, &settings, None, task));
        let (body, report) = built.map_err(|error| Error::from(error).of(name))?;
        Ok((body, report.seconds.total))
    }
}

/// The median of what was measured, in milliseconds.
fn median_ms(mut secs: Vec<f64>) -> f64 {
    secs.sort_by(f64::total_cmp);
    1e3 * secs.get(secs.len() / 2).copied().unwrap_or(0.0)
}
