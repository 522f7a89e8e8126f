//! Transfers colors between shapes: each vertex of the head gets the color of the corresponding point of
//! the template, which is colored by height. Writes transfer.ply.
#![allow(clippy::print_stdout, reason = "a program")]

use chladni::matching::{MatchSettings, match_shapes};
use chladni::mesh::{samples, save_mesh};
use chladni::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut shape = samples::sample("head").ok_or("there is a head")?;
    let template = samples::sample("template").ok_or("there is a template")?;
    let found = match_shapes(&shape, &template, &MatchSettings::default(), &Task::new())?;
    println!("{:.0} % of the head has a partner", 100.0 * found.report.coverage);

    let on_template = found.correspondence.on_template.ok_or("the template is a mesh")?;
    let height = |v: u32| template.positions[v as usize][1];
    let (low, high) =
        template.positions.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[1]), h.max(p[1])));
    let color = |on: &chladni::mesh::surface::SurfacePoint| {
        let corners = template.triangles[on.triangle as usize];
        let mixed: f64 = corners.iter().zip(on.weights).map(|(v, w)| w * height(*v)).sum();
        let share = ((mixed - low) / (high - low)) as f32;
        [share, 0.2, 1.0 - share, 1.0]
    };
    shape.appearance.colors = Some(on_template.iter().map(color).collect());
    save_mesh(&shape, "transfer.ply".as_ref())?;
    Ok(())
}
