//! dbg
use chladni_match::*;
use chladni_mesh::load_mesh;
use chladni_task::Task;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let m = "/work/shared/data/meshes/heads/";
    for (p, x, y) in [
        ("A", "igea.ply", "decimated-max.obj"),
        ("B", "face.obj", "demosthenes-low-res.obj"),
        ("C", "face.obj", "target.obj"),
        ("D", "reference.obj", "target.obj"),
        ("E", "generic_neutral_mesh.obj", "identity005.obj"),
    ] {
        if !a[1].contains(p) {
            continue;
        }
        let s = load_mesh(format!("{m}{x}").as_ref()).unwrap().mesh;
        let t = load_mesh(format!("{m}{y}").as_ref()).unwrap().mesh;
        let t0 = std::time::Instant::now();
        let f = match_shapes(
            &s,
            &t,
            &Settings { method: Method::Fit, seed: 1, ..Default::default() },
            &Task::new(),
        )
        .unwrap();
        let r = &f.report;
        println!(
            "{p} flips {} misfit {:?} {:?} tie {} conf {:.4} cover {:.4} stretch {:.3} {:.2} s",
            r.flipped_triangles,
            r.misfit,
            r.runner_up_misfit,
            r.near_tie,
            r.mean_confidence,
            r.coverage,
            r.stretch,
            t0.elapsed().as_secs_f64()
        );
        let mut o = String::new();
        let c = &f.correspondence;
        let on = c.on_template.as_ref().unwrap();
        for v in 0..c.point.len() {
            let p = c.point[v];
            o += &format!("{} {} {} {} {}\n", p[0], p[1], p[2], on.triangle[v], c.confidence[v]);
        }
        std::fs::write(format!("/tmp/match-dbg-{p}.txt"), o).unwrap();
    }
}
