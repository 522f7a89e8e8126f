//! Regions of a shape, by part and by mask.

use super::*;

#[test]
fn a_part_of_a_head_is_a_region() {
    let desk = Desk::new();
    let parts = desk.ok("parts sample:head --json -o parts.npz");
    assert!(parts.contains("\"nose\"") && parts.contains("confidence"), "{parts}");
    // The sample is modeled of them.
    let head = samples::sample("head").unwrap();
    let known = samples::head_parts("head", &head.positions).unwrap();
    let found = archive::array(&desk.path("parts.npz"), "part").unwrap().values;
    let known: Vec<f64> = known.into_iter().map(f64::from).collect();
    assert_eq!(found, known);
    desk.ok("caricature sample:head ellipsoid -k 48 --part nose -o nose.ply");
    let (before, after) = (samples::sample("head").unwrap().positions, desk.mesh("nose.ply").positions);
    let moved = |v: usize| (0..3).map(|i| (after[v][i] - before[v][i]).powi(2)).sum::<f64>().sqrt();
    let back = (0..before.len()).filter(|v| before[*v][2] < -0.3).map(moved).fold(0.0, f64::max);
    let most = (0..before.len()).max_by(|a, b| moved(*a).total_cmp(&moved(*b))).unwrap();
    assert!(before[most][2] > 0.4 && back < 0.02 * moved(most), "{:?}, {back}", before[most]);
    let said = desk.refused("caricature sample:head ellipsoid --part elbow -o nose.ply");
    assert!(said.contains("nose, brow"), "{said}");
}

#[test]
fn the_limbs_of_any_shape_are_its_parts_at_a_level() {
    let desk = Desk::new();
    let drawn = "--render parts.png --size 320x200 --view 0,20";
    let printed = desk.ok(&format!("parts sample:octopus --level 0.3 --json -o parts.npz {drawn}"));
    let parts: serde_json::Value = serde_json::from_str(&printed).unwrap();
    let parts = parts.as_array().unwrap();
    let arms: Vec<_> = parts.iter().filter(|part| !part["twin"].is_null()).collect();
    assert_eq!(arms.len(), 8, "{printed}");
    assert!(arms.iter().all(|arm| parts[arm["twin"].as_u64().unwrap() as usize]["twin"] == arm["part"]));
    let total: f64 = parts.iter().map(|part| part["share"].as_f64().unwrap()).sum();
    assert!((total - 1.0).abs() < 1e-9);
    let picture = std::fs::read(desk.path("parts.png")).unwrap();
    assert_eq!(chladni_view::Picture::size_of(&picture).unwrap(), [320, 200]);
    assert!(desk.ok("parts shape.obj --level 0").contains("% of the surface"));
    assert!(desk.refused("parts shape.obj --level 2").contains("from 0 to 1"));
    let line = "caricature sample:octopus ellipsoid -k 64 --mu -1 -o arm.ply --limb";
    let moved = |limb: &str| {
        desk.ok(&format!("{line} {limb}"));
        load_mesh(&desk.path("arm.ply")).unwrap().mesh.positions
    };
    let (one, other) = (moved("1"), moved("2,3"));
    assert!(largest(&one, &other) > 0.01, "limbs are regions");
    assert!(desk.refused(&format!("{line} 99")).contains("there is no 99"));
    assert!(desk.refused("caricature shape.obj ellipsoid -o x.ply --level 0.1").contains("--limb"));
    // The same parts as a mask, whose numbers another program could have written.
    let parts = archive::array(&desk.path("parts.npz"), "part").unwrap().values;
    write_npz(&desk.path("mask.npz"), |npz| {
        npz.array("mask", &[parts.len() as u64], parts.iter().map(|part| f32::from(u8::from(*part == 1.0))))
    })
    .unwrap();
    let line = "caricature sample:octopus ellipsoid -k 64 --mu -1 -o masked.ply --mask";
    desk.ok(&format!("{line} mask.npz"));
    let masked = load_mesh(&desk.path("masked.ply")).unwrap().mesh.positions;
    assert_eq!(masked, one);
    assert!(desk.refused(&format!("{line} parts.npz")).contains("a mask lies in [0, 1]"));
    assert!(
        desk.refused("caricature shape.obj ellipsoid -o x.ply --mask mask.npz").contains("a number for each")
    );
}

#[test]
fn a_mask_goes_out_and_comes_in_again_by_every_kind_of_file() {
    let desk = Desk::new();
    let moved = |region: &str| {
        desk.ok(&format!("caricature shape.obj ellipsoid -k 32 --mu -1 -o moved.ply {region}"));
        desk.mesh("moved.ply").positions
    };
    let expected = moved("--curved bumps:30%");
    assert!(largest(&expected, &moved("--curved hollows:30%")) > 1e-3);
    for out in ["m.npy", "m.npz", "m.ply", "m.obj", "m.glb", "gray.ply --as-colors"] {
        let said = desk.ok(&format!("mask shape.obj --curved bumps:30% -o {out}"));
        assert!(said.contains("of 642 vertices"), "{said}");
        let file = out.split(' ').next().unwrap();
        assert_eq!(moved(&format!("--mask {file}")), expected, "{out}");
    }
    assert_eq!(moved("--mask gray.ply --mask-channel green"), expected);
    assert!(
        largest(&moved("--mask gray.ply --mask-channel alpha"), &expected) > 1e-3,
        "alpha is 1 everywhere"
    );
    let line = "caricature shape.obj ellipsoid -o x.ply --mask m.ply --mask-channel weight";
    assert!(desk.refused(line).contains("no weight; they have mask"));
    // A project's layer takes a mask, and gives it back.
    desk.ok("project new shape.obj -k 32 -o me.chladni");
    assert!(desk.refused("mask me.chladni -o back.npy").contains("has no layer"));
    desk.ok("project add-layer me.chladni --template ellipsoid --mu -1 --mask m.npy");
    desk.ok("project add-layer me.chladni --template sphere --name all");
    desk.ok("mask me.chladni --layer ellipsoid -o back.npy");
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert_eq!(read("back.npy"), read("m.npy"));
    desk.ok("mask me.chladni -o all.npy");
    assert_ne!(read("all.npy"), read("m.npy"));
    for (line, said) in [
        ("mask shape.obj -o x.npy", "say which region"),
        ("mask shape.obj --curved bumps -o x.stl", "ends in one of"),
        ("mask me.chladni --layer none -o x.npy", "no layer called none"),
        ("mask me.chladni --curved bumps -o x.npy", "brings its regions along"),
        ("mask shape.obj --curved bumps:0% -o x.npy", "share of the surface"),
        ("mask shape.obj --mask-channel red -o x.npy", "--mask"),
        ("mask shape.obj --curved bumps --mask-channel red -o x.npy", "--mask-channel"),
        ("mask shape.obj --limb 1 --mask-channel red -o x.npy", "--mask-channel"),
        ("mask shape.obj --region 13,0,0,2 --level 0.1 -o x.npy", "--level"),
        ("mask shape.obj --mask m.npy --level 0.1 -o x.npy", "--level"),
    ] {
        assert!(desk.refused(line).contains(said), "{line}");
    }
}

#[test]
fn a_region_beside_the_shape_is_warned_of() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid --harmonics 16 -o out.obj --region";
    let beside = desk.run(&format!("{line} 0,0,0,0.1"));
    let message = String::from_utf8(beside.stderr).unwrap();
    assert!(beside.status.success() && message.contains("its region holds no vertex"), "{message}");
    let on_it = desk.run(&format!("{line} 10,0,0,20"));
    assert!(!String::from_utf8(on_it.stderr).unwrap().contains("its region"));
    desk.ok("project new shape.obj -k 16 -o p.chladni");
    for line in ["mask shape.obj -o m.npy", "project add-layer p.chladni --template ellipsoid"] {
        let said = |ball: &str| {
            let run = desk.run(&format!("{line} --region {ball}"));
            assert!(run.status.success());
            String::from_utf8(run.stderr).unwrap()
        };
        assert!(said("0,0,0,0.1").contains("region holds no vertex"), "{line}");
        assert!(!said("10,0,0,20").contains("region holds"), "{line}");
    }
}
