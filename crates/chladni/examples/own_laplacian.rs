//! A Laplacian of your own: here that of a graph in which every edge and every vertex has weight 1. Prints
//! its first eigenvalues and what is certified about them.
#![allow(clippy::print_stdout, reason = "a program")]

use chladni::harmonics::{BasisSettings, Pencil, SymmetricSparse};
use chladni::mesh::{samples, vertex_neighbors};
use chladni::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = samples::sample("octopus").ok_or("there is an octopus")?;
    let n = mesh.positions.len();
    let neighbors = vertex_neighbors(n, &mesh.triangles);

    let mut entries = Vec::new();
    for v in 0..n {
        let around = neighbors.row(v);
        entries.push((v, v, around.len() as f64));
        entries.extend(around.iter().filter(|w| (**w as usize) < v).map(|w| (v, *w as usize, -1.0)));
    }
    let stiffness = SymmetricSparse::from_entries(n, entries)?;
    let mass = vec![1.0; n];
    let (basis, report) = Pencil::new(&stiffness, &mass)?.solve(&BasisSettings::new(20), &Task::new())?;
    for (k, lambda) in basis.eigenvalues.iter().enumerate() {
        println!("{k:3}  {lambda:.9}");
    }
    println!("{:?}, {:.2} s", basis.certificate, report.seconds.total);
    Ok(())
}
