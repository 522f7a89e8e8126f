//! What results lack that are of another format than the shape, and which files are shapes.

use super::*;

#[test]
fn a_batch_makes_glb_of_gltf_and_leaves_hidden_files_out() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir(desk.path("many")).unwrap();
    // By its content it is a GLB.
    save_mesh(&lump(1.0), &desk.path("many/a.glb")).unwrap();
    std::fs::rename(desk.path("many/a.glb"), desk.path("many/a.gltf")).unwrap();
    std::fs::write(desk.path("many/._a.gltf"), "from a Mac").unwrap();
    desk.ok("caricature --recipe p.chladni --batch many -o out");
    let made = std::fs::read_dir(desk.path("out")).unwrap().map(|file| file.unwrap().file_name());
    assert_eq!(made.collect::<Vec<_>>(), ["a.glb"]);
}

#[test]
fn pictures_that_an_obj_lacks_are_named() {
    let desk = Desk::new();
    let text = std::fs::read_to_string(desk.path("shape.obj")).unwrap();
    std::fs::write(desk.path("shape.obj"), format!("mtllib skin.mtl\nusemtl skin\n{text}")).unwrap();
    std::fs::write(desk.path("skin.mtl"), "newmtl skin\nmap_Bump -bm 0.5 dent.png\n").unwrap();
    std::fs::write(desk.path("dent.png"), "").unwrap();
    std::fs::create_dir(desk.path("out")).unwrap();
    for (out, is_left) in [("out/a.obj", true), ("a.obj", false), ("out/a.ply", false)] {
        let output = desk.run(&format!("caricature shape.obj ellipsoid -k 16 -o {out}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{out}: {said}");
        assert_eq!(said.contains("its materials name dent.png"), is_left, "{out}: {said}");
    }
}

#[test]
fn a_mesh_that_is_written_anew_says_what_its_gltf_file_had() {
    let desk = Desk::new();
    save_mesh(&lump(2.0), &desk.path("rigged.glb")).unwrap();
    for line in [
        "transfer shape.obj shape.obj rigged.glb --match same -o",
        "mean rigged.glb shape.obj --match same -o",
        "mask rigged.glb --curved bumps -o",
    ] {
        for (out, is_left) in [("out.glb", true), ("out.obj", false)] {
            let output = desk.run(&format!("{line} {out}"));
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.success(), "{line} {out}: {said}");
            assert_eq!(said.contains("rigged.glb: rigs, animations"), is_left, "{line} {out}: {said}");
        }
    }
}

#[test]
fn a_shape_far_from_the_origin_that_is_written_as_stl_is_warned_of() {
    let desk = Desk::new();
    let mut far = lump(1.0);
    far.positions.iter_mut().for_each(|p| p[1] += 5_654_321.0);
    save_mesh(&far, &desk.path("far.ply")).unwrap();
    for line in
        ["transfer shape.obj shape.obj far.ply --match same -o", "mean far.ply far.ply --match same -o"]
    {
        for (out, is_rounded) in [("out.stl", true), ("out.ply", false)] {
            let output = desk.run(&format!("{line} {out}"));
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.success(), "{line} {out}: {said}");
            assert_eq!(said.contains("STL rounds them"), is_rounded, "{line} {out}: {said}");
        }
    }
}
