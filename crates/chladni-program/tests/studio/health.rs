//! What the window says of the state of a file.

use chladni_mesh::save_mesh;
use egui_kittest::kittest::NodeT;

use crate::driving::person::{Desk, lump};
use crate::driving::{Window, control};

#[test]
fn what_was_found_in_a_file_is_said_where_its_vertices_are_counted() {
    let desk = Desk::new();
    let mut mesh = lump(0.5);
    let ([a, b, _], tip) = (mesh.triangles[0], mesh.positions.len() as u32);
    let outside = mesh.positions[a as usize].map(|c| 1.5 * c);
    mesh.positions.push(outside);
    mesh.triangles.push([a, b, tip]);
    save_mesh(&mesh, &desk.path("fin.obj")).unwrap();
    // And a face that has two corners.
    let obj = std::fs::read_to_string(desk.path("fin.obj")).unwrap();
    std::fs::write(desk.path("fin.obj"), obj + "f 1 2\n").unwrap();
    let mut person = desk.sit_down(&["fin.obj"]);
    person.wait_to_see("643 vertices");
    let is_said = |window: &Window, text: &str| {
        let description = control(window, "vertices").accesskit_node().description();
        description.is_some_and(|description| description.contains(text))
    };
    person.wait("the report", |window| is_said(window, "1 non-manifold edge"));
    assert!(is_said(&person.0, "mended: 1 face has fewer than three corners"));
    // It waits until it is asked for.
    assert!(!person.sees("non-manifold"));
    control(&person.0, "vertices").hover();
    person.wait_to_see("1 boundary loop, 1 non-manifold edge");
    person.screenshot("studio-health.png");
}
