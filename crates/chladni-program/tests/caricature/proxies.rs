//! Shapes that are worked on through a proxy.

use chladni_mesh::Material;

use super::projects::morph_sum;
use super::*;

/// A desk with a larger lump, `large.ply`, of 10,242 vertices.
fn desk() -> Desk {
    let desk = Desk::new();
    let mut mesh = samples::icosphere(5);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = 3.0 + 0.6 * (3.0 * x).sin() + 0.4 * y * z;
        *p = [10.0 + r * x, r * y, 0.7 * r * z];
    }
    save_mesh(&mesh, &desk.path("large.ply")).unwrap();
    desk
}

#[test]
fn the_whole_shape_moves_nearly_as_it_does_without_a_proxy() {
    let desk = desk();
    let line = "caricature large.ply ellipsoid -k 24 --mu -1 --region 13,0,0,2";
    let said = desk.run(&format!("{line} --proxy 2000 -o through.ply"));
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(said.contains("of 10242 vertices 2000 are worked on"), "{said}");
    let said = desk.run(&format!("{line} -o whole.ply")).stderr;
    assert!(!String::from_utf8(said).unwrap().contains("worked on"));
    let [large, through, whole] = ["large.ply", "through.ply", "whole.ply"].map(|name| desk.mesh(name));
    assert_eq!(through.triangles, large.triangles);
    let (moved, off) =
        (largest(&large.positions, &whole.positions), largest(&through.positions, &whole.positions));
    assert!(moved > 0.2 && off < 0.1 * moved, "{moved} {off}");
    let nothing = "caricature large.ply ellipsoid -k 24 --mu 0 --proxy 2000 -o still.ply";
    desk.ok(nothing);
    assert_eq!(desk.mesh("still.ply").positions, large.positions);
}

#[test]
fn the_sliders_of_a_glb_add_up_to_the_result() {
    let desk = desk();
    desk.ok("project new large.ply -o p.chladni -k 24 --proxy 1500");
    desk.ok("project add-layer p.chladni --template ellipsoid --mu -1.2");
    desk.ok("project add-layer p.chladni --template self:lowpass=4 --mu -1");
    desk.ok("caricature --recipe p.chladni -o out.ply");
    desk.ok("caricature --recipe p.chladni -o out.glb");
    let (large, result) = (desk.mesh("large.ply"), desk.mesh("out.ply"));
    let (names, moved) = morph_sum(&desk.path("out.glb"), large.positions.len());
    assert_eq!(names.len(), 2);
    let sum: Vec<[f64; 3]> =
        large.positions.iter().zip(&moved).map(|(p, d)| std::array::from_fn(|i| p[i] + d[i])).collect();
    let off = largest(&sum, &result.positions);
    assert!(off < 1e-5, "{off}");
}

#[test]
fn a_dance_as_a_glb_has_only_the_proxy_with_the_colors_of_its_materials_and_says_so() {
    let desk = desk();
    let mut mesh = desk.mesh("large.ply");
    let material = |name, base_color| Material { base_color, ..Material::named(name) };
    mesh.appearance.materials =
        vec![material("left", [1.0, 0.0, 0.0, 1.0]), material("right", [0.0, 0.0, 1.0, 1.0])];
    let is_right = |t: &[u32; 3]| mesh.positions[t[0] as usize][0] > 10.0;
    mesh.appearance.face_materials = mesh.triangles.iter().map(|t| Some(is_right(t).into())).collect();
    save_mesh(&mesh, &desk.path("painted.obj")).unwrap();
    desk.ok("project new painted.obj -o p.chladni -k 24 --proxy 1500");
    let dance = desk.run("dance p.chladni sample:tune -k 24 --duration 1 -o dance.glb");
    let message = String::from_utf8(dance.stderr).unwrap();
    assert!(dance.status.success() && message.contains("only the vertices that are worked on"), "{message}");
    let dance = desk.mesh("dance.glb");
    assert!(dance.positions.len() < 10_000);
    let colors = dance.appearance.colors.unwrap();
    for (p, color) in dance.positions.iter().zip(colors).filter(|(p, _)| (p[0] - 10.0).abs() > 0.5) {
        let expected = if p[0] > 10.0 { [0.0, 0.0, 1.0, 1.0] } else { [1.0, 0.0, 0.0, 1.0] };
        assert_eq!(color, expected, "at {p:?}");
    }
}

#[test]
fn a_project_keeps_its_proxy_and_is_refused_where_its_regions_belong_to_another() {
    let desk = desk();
    desk.ok("project new large.ply -o p.chladni -k 24 --proxy 1500");
    let text = std::fs::read_to_string(desk.path("p.chladni")).unwrap();
    assert!(text.contains("format_version = 5") && text.contains("vertices = 1500"), "{text}");
    desk.ok("project add-layer p.chladni --template ellipsoid --mu -1 --curved bumps");
    desk.ok("caricature --recipe p.chladni -o once.ply");
    desk.ok("mask p.chladni -o region.npy");
    assert!(desk.ok("mask p.chladni -o region.ply").contains("of 10242 vertices"));
    // The same region from the file of all vertices.
    desk.ok("caricature large.ply ellipsoid -k 24 --mu -1 --proxy 1500 --mask region.npy -o again.ply");
    let off = largest(&desk.mesh("once.ply").positions, &desk.mesh("again.ply").positions);
    assert!(off < 1e-6, "{off}");

    let text = std::fs::read_to_string(desk.path("p.chladni")).unwrap();
    let fingerprint = text.split("fingerprint = \"").nth(1).unwrap().split('"').next().unwrap();
    std::fs::write(desk.path("q.chladni"), text.replace(fingerprint, "0123456789abcdef")).unwrap();
    let refused = desk.refused("caricature --recipe q.chladni -o out.ply");
    assert!(refused.contains("another selection of its vertices"), "{refused}");
    let refused = desk.refused("caricature --recipe p.chladni --proxy 900 -o out.ply");
    assert!(refused.contains("as the recipe says"), "{refused}");
    // Another shape takes the layers over, whole.
    desk.ok("caricature shape.obj --recipe p.chladni -o other.ply");
    assert_eq!(desk.mesh("other.ply").positions.len(), desk.mesh("shape.obj").positions.len());
}

#[test]
fn a_match_vertex_by_vertex_takes_all_of_them_from_a_proxy_too() {
    let desk = desk();
    desk.ok("project new large.ply -o p.chladni -k 24 --proxy 1500");
    let path = desk.path("p.chladni");
    let text = std::fs::read_to_string(&path).unwrap();
    let layer =
        "[[layer]]\nname = \"same\"\ntemplate = \"large.ply\"\nmu = 0.5\n[layer.match]\nmethod = \"same\"\n";
    std::fs::write(&path, format!("{}\n{layer}", text.replace("layer = []\n", ""))).unwrap();
    let output = desk.run("caricature --recipe p.chladni -o out.ply");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("all vertices are taken"), "{said}");
    let said = desk.refused("caricature large.ply large.ply --match same --proxy 1500 -o out.ply");
    assert!(said.contains("--match same needs all vertices"), "{said}");
}

#[test]
fn limbs_are_counted_on_the_proxy_on_which_they_are_taken() {
    let desk = Desk::new();
    desk.ok("parts sample:octopus --level 0.3 --proxy 1500 -o parts.npz");
    let parts = archive::array(&desk.path("parts.npz"), "part").unwrap().values;
    assert_eq!(parts.len(), samples::sample("octopus").unwrap().positions.len());
    for limb in 0..2_u32 {
        let project = format!("{limb}.chladni");
        desk.ok(&format!("project new sample:octopus -k 8 --proxy 1500 -o {project}"));
        desk.ok(&format!("project add-layer {project} --template sphere --limb {limb} --level 0.3"));
        desk.ok(&format!("mask {project} -o mask.npz"));
        let mask = archive::array(&desk.path("mask.npz"), "mask").unwrap().values;
        // A mask is mixed across a triangle, a part is that of its nearest corner: they agree where all corners do, but
        // also differ where an obtuse corner is nearest and has no weight.
        let belongs = |part: f64| if part == f64::from(limb) { 1.0 } else { 0.0 };
        let sure = || parts.iter().zip(&mask).filter(|(_, x)| (**x).min(1.0 - **x).abs() < 1e-6);
        let apart = sure().filter(|(part, x)| (belongs(**part) - **x).abs() > 0.5).count();
        assert!(apart * 500 < parts.len(), "{limb}: {apart} of {}", parts.len());
        assert!(sure().count() * 2 > parts.len() && sure().any(|(part, _)| belongs(*part) > 0.5));
    }
}

#[test]
fn what_cannot_be_a_proxy_is_said() {
    let desk = desk();
    let refused =
        |option: &str| desk.refused(&format!("caricature large.ply ellipsoid -k 8 -o out.ply {option}"));
    assert!(refused("--proxy 12").contains("must be 0, or 100 or more"));
    assert!(
        refused("--proxy 9000").contains("through about 9000 vertices, as it has fewer than twice as many")
    );
    let matched = "caricature large.ply sample:octopus --match map -k 8 -o out.ply --proxy 1500 --landmarks";
    assert!(desk.refused(&format!("{matched} none.txt")).contains("none.txt"));
    std::fs::write(desk.path("marks.txt"), "99999 0\n").unwrap();
    let refused = desk.refused(&format!("{matched} marks.txt"));
    assert!(refused.contains("no vertex 99999"), "{refused}");
}
