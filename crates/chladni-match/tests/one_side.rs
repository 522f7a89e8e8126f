//! Symmetric heads: the similarity of a fit must keep their common mirror plane, however much they differ.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{MatchSettings, Scaling, Similarity, match_shapes};
use chladni_mesh::TriMesh;
use chladni_mesh::samples::sample;
use chladni_task::Task;

/// A turn by 90° about y, then 30° about x, and a shift; grown by `scale`.
fn posed(mesh: &TriMesh, scale: f64) -> TriMesh {
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let pose = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [z, y, -x];
        [scale * x + 3.0, scale * (cos * y - sin * z) - 1.0, scale * (sin * y + cos * z) + 2.0]
    };
    TriMesh { positions: mesh.positions.iter().map(|p| pose(*p)).collect(), ..mesh.clone() }
}

/// The largest distance by which the similarity `found` misses the original position of a point of the mesh
/// `of`, which was `posed`, measured along the axes `along`; a share of the height, 2.5.
fn off(of: &TriMesh, posed: &TriMesh, found: &Similarity, along: &[usize]) -> f64 {
    let pairs = posed.positions.iter().zip(&of.positions);
    let far = pairs.map(|(posed, known)| {
        let back = found.apply(*posed);
        along.iter().map(|i| (back[*i] - known[*i]).powi(2)).sum::<f64>().sqrt()
    });
    far.fold(0.0, f64::max) / 2.5
}

#[test]
fn a_head_finds_itself_where_it_was_put() {
    let head = sample("portrait?nose=0.8,age=0.5").unwrap();
    for (scaling, scale) in [(Scaling::Rigid, 1.0), (Scaling::Free, 2.5)] {
        let template = posed(&head, scale);
        let settings = MatchSettings { scaling, ..MatchSettings::default() };
        let found = match_shapes(&head, &template, &settings, &Task::new()).unwrap();
        let off = off(&head, &template, &found.correspondence.similarity, &[0, 1, 2]);
        println!("{scaling:?}: off by {off:.1e} of the height");
        assert!(off < 1e-4, "{scaling:?}: {off}");
    }
}

/// A broad and a narrow head: the first alignment puts one side of each on the other, up to 8 % off the
/// middle.
#[test]
fn heads_as_different_as_broad_and_narrow_lie_on_each_other_and_not_to_one_side() {
    for (shape, other) in
        [("portrait?width=1", "portrait?width=-1"), ("portrait?width=-1", "portrait?width=1")]
    {
        let (shape, other) = (sample(shape).unwrap(), sample(other).unwrap());
        let template = posed(&other, 1.0);
        let settings = MatchSettings { scaling: Scaling::Rigid, ..MatchSettings::default() };
        let found = match_shapes(&shape, &template, &settings, &Task::new()).unwrap();
        // Both are symmetric in x: only y and z may move.
        let off = off(&other, &template, &found.correspondence.similarity, &[0]);
        println!("off by {off:.4} of the height to one side");
        assert!(off < 0.008, "{off}");
    }
}
