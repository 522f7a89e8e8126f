//! Mesh → operator → harmonics → archives that NumPy and SciPy read, in the units of the mesh's file:
//! `cargo run --release -p chladni --example numpy_basis -- head.obj`, or `sample:octopus`.

use chladni::harmonics::{BasisSettings, Body, Operator, npz};
use chladni::mesh::ShapeSource;
use chladni::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("sample:head".into());
    let mesh = ShapeSource::named(name).load(None)?.mesh;
    let operator = Operator::of(&mesh)?;
    let settings = BasisSettings { harmonics: 64, ..BasisSettings::default() };
    let (body, _) = Body::of_operator(&mesh, &operator, &settings, None, &Task::new())?;
    assert!(body.basis.certificate.is_precise());
    npz::write_basis("basis.npz".as_ref(), &body, &Task::new())?;
    npz::write_operator("stiffness.npz".as_ref(), &operator, &Task::new())?;
    Ok(())
}
