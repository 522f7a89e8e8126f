//! Makes a scan of millions of vertices out of a smaller one.

use std::path::PathBuf;

use chladni_mesh::surface::{subdivided, vertex_normals};
use chladni_mesh::{TriMesh, save_mesh};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, source};

/// Divide each triangle of a mesh in four, a few times, and raise small bumps on it: a scan as large as one likes, with
/// detail that the mesh did not have.
#[derive(clap::Args)]
pub struct BenchScan {
    /// The mesh: a file or sample:NAME.
    shape: String,
    /// How often its triangles are divided.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=4))]
    times: u32,
    /// Where it goes.
    #[arg(short, long, value_name = "OUT.ply")]
    output: PathBuf,
}

/// How many waves of bumps lie along the longest side, and how high they are as a share of it.
const WAVES: f64 = 60.0;
const HEIGHT: f64 = 8e-4;

impl BenchScan {
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let mut mesh = source::mesh(&self.shape, terminal)?;
        mesh.appearance = chladni_mesh::Appearance::default();
        for _ in 0..self.times {
            mesh.triangles = subdivided(&mut mesh.positions, &mesh.triangles);
        }
        raise_bumps(&mut mesh);
        save_mesh(&mesh, &self.output).map_err(Error::unsaved)?;
        terminal.result(format_args!("{} vertices", mesh.positions.len()))
    }
}

fn raise_bumps(mesh: &mut TriMesh) {
    let side = |axis: usize| {
        let along = || mesh.positions.iter().map(|p| p[axis]);
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
    };
    let longest = (0..3).map(side).fold(0.0, f64::max);
    let normals = vertex_normals(&mesh.positions, &mesh.triangles);
    for (p, n) in mesh.positions.iter_mut().zip(normals) {
        let wave = p.map(|x| (std::f64::consts::TAU * WAVES * x / longest).sin()).iter().product::<f64>();
        *p = std::array::from_fn(|i| p[i] + HEIGHT * longest * wave * n[i]);
    }
}
