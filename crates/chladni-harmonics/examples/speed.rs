//! Times one solve: `speed LEVELS K [THREADS]` on a dented icosphere.
#![allow(clippy::print_stdout, missing_docs)]
#[path = "../tests/shapes/mod.rs"]
mod shapes;
use chladni_harmonics::{BasisSettings, Body};
fn main() {
    let arg = |i: usize| std::env::args().nth(i).and_then(|a| a.parse::<usize>().ok());
    let mut mesh = shapes::icosphere(arg(1).unwrap_or(5) as u32);
    for p in &mut mesh.positions {
        let f = 1.0 + 0.2 * (3.0 * p[0] + 2.0 * p[1]).sin() * (2.0 * p[2] - p[0]).cos();
        *p = [p[0] * f, p[1] * f * 1.3, p[2] * f * 0.8];
    }
    let settings = BasisSettings { threads: arg(3), ..BasisSettings::new(arg(2).unwrap_or(64)) };
    for _ in 0..arg(4).unwrap_or(1) {
        let (body, report) = Body::load_or_build(&mesh, &settings, None, &chladni_task::Task::new()).unwrap();
        println!(
            "n {} K {} {:?}\n{:?}\n{:?}",
            body.positions.len(),
            body.basis.harmonics(),
            report.seconds,
            report.profile,
            body.basis.certificate
        );
    }
}
