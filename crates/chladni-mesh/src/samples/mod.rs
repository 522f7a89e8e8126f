//! Shapes of our own.

mod cat;
mod field;
mod head;
mod head_parts;
mod human;
mod instruments;
mod jellyfish;
mod octopus;
mod plates;
mod portrait;
mod surface_nets;
mod surfaces;

use portrait::Face;
use rayon::prelude::*;

pub(crate) use head::coarse_template;
pub use portrait::{FitPoint, FittedPortrait, SLIDERS, fitted_portrait, portrait_name, portrait_sliders};
pub use surfaces::{grid_square, icosphere, moebius, torus, uv_sphere};

use crate::TriMesh;

/// The names that [`sample`] knows.
pub const SAMPLES: [&str; 11] =
    ["head", "template", "octopus", "plate", "disc", "drum", "bell", "ring", "jellyfish", "human", "cat"];

/// A modeled shape by name, the same bits on every run of one machine, with 5,000 to 21,000 vertices:
/// `head`, a bald man of character, and `template`, a plain head in the same pose; `octopus`, `jellyfish`,
/// `human` and `cat`; `bell` and `drum`; `ring`, a torus; and `plate` and `disc`, sheets that lie flat.
/// All mirror x, look along +z and stand along y. The sheets have one border, the others are closed; the ring
/// has a hole, the others have none. Besides these, `portrait`, a head of 50,000 vertices with [`SLIDERS`]:
/// `portrait?jaw=0.5,nose=-1`.
pub fn sample(name: &str) -> Option<TriMesh> {
    match name {
        "head" => Some(head::head()),
        "template" => Some(head::template()),
        "octopus" => Some(octopus::octopus()),
        "plate" => Some(plates::square_plate()),
        "disc" => Some(plates::round_plate()),
        "drum" => Some(instruments::drum()),
        "bell" => Some(instruments::bell()),
        "ring" => Some(torus(0.36, 150, 68)),
        "jellyfish" => Some(jellyfish::jellyfish()),
        "human" => Some(human::human()),
        "cat" => Some(cat::cat()),
        _ => portrait_sliders(name)?.ok().map(|values| Face::of(values).mesh()),
    }
}

/// The names of the parts of a head, in the order of their numbers in [`head_parts`].
pub const HEAD_PARTS: [&str; 10] = head_parts::PARTS;

/// For each point on the sample `head`, `template` or `portrait` the part on which it lies, an index of [`HEAD_PARTS`]; `None`
/// of other samples. Eyes, nose, mouth and ears are where they are modeled; the other parts are the same regions of the plain
/// head whatever the sliders are.
pub fn head_parts(name: &str, points: &[[f64; 3]]) -> Option<Vec<u8>> {
    Some(head_borders(name, points)?.iter().map(head_parts::within).collect())
}

/// For each point on such a sample about how far it is from the border of each of [`HEAD_PARTS`], negative within it, in
/// units of half a head's height; `None` of other samples.
pub fn head_borders(name: &str, points: &[[f64; 3]]) -> Option<Vec<[f64; HEAD_PARTS.len()]>> {
    match name {
        "head" => Some(points.par_iter().map(|p| head::borders(*p, true)).collect()),
        "template" => Some(points.par_iter().map(|p| head::borders(*p, false)).collect()),
        _ => {
            let face = Face::of(portrait_sliders(name)?.ok()?);
            Some(points.par_iter().map(|p| face.borders(*p)).collect())
        }
    }
}

/// The part within whose borders, as [`head_borders`] gives them, a point lies: an index of [`HEAD_PARTS`].
pub fn head_part_within(borders: &[f64; HEAD_PARTS.len()]) -> u8 {
    head_parts::within(borders)
}

/// For each vertex of the sample `octopus` 0 on its body or the number of its arm, from 1 to 8; `None` of other samples.
/// The forms that it is modeled of are its limbs.
pub fn limbs(name: &str, mesh: &TriMesh) -> Option<Vec<u8>> {
    (name == "octopus").then(|| octopus::limbs(mesh))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HealthReport;

    #[test]
    fn samples_are_sound_even_and_mirrored() {
        for name in SAMPLES {
            let is_sheet = ["plate", "disc"].contains(&name);
            let mesh = sample(name).unwrap();
            let report = HealthReport::of(&mesh);
            assert!((5_000..=21_000).contains(&report.vertices), "{name}: {}", report.vertices);
            assert_eq!(report.topology.components, 1, "{name}");
            let genus = usize::from(name == "ring");
            let loops = usize::from(is_sheet);
            assert_eq!(
                (report.topology.genus, report.topology.boundary_loops),
                (Some(genus), loops),
                "{name}"
            );
            assert_eq!(
                report.degenerate_triangles + report.duplicate_vertices + report.unreferenced_vertices,
                0
            );
            if is_sheet {
                let up = mesh.triangles.iter().all(|t| {
                    crate::surface::doubled_area_normal(crate::surface::corners(&mesh.positions, t))[1] > 0.0
                });
                assert!(up, "{name} is upside down");
            } else {
                assert!(report.volume.unwrap() > 0.0, "{name} is inside out");
            }
            let narrow = mesh.triangles.iter().filter(|t| narrowest_angle(&mesh, t) < 15.0).count();
            assert!(narrow * 200 < mesh.triangles.len(), "{name}: {narrow} narrow triangles");
            assert!(mirror_error(&mesh) < 1e-6, "{name}: {}", mirror_error(&mesh));
        }
    }

    #[test]
    fn heads_have_all_parts_where_they_belong() {
        for name in ["head", "template"] {
            let mesh = sample(name).unwrap();
            let parts = head_parts(name, &mesh.positions).unwrap();
            let mean = |part: &str| {
                let part = HEAD_PARTS.iter().position(|p| *p == part).unwrap() as u8;
                let of: Vec<_> =
                    (0..parts.len()).filter(|v| parts[*v] == part).map(|v| mesh.positions[v]).collect();
                assert!(of.len() * 200 > parts.len(), "{name}: {} vertices", of.len());
                [0, 1, 2].map(|i| {
                    of.iter().map(|p| p[i].abs() * if i == 0 { 1.0 } else { p[i].signum() }).sum::<f64>()
                        / of.len() as f64
                })
            };
            let all = HEAD_PARTS.map(mean);
            let [nose, brow, eyes, mouth, chin, jaw, cheeks, ears, crown, neck] = all;
            assert!(crown[1] > brow[1] && brow[1] > eyes[1] && eyes[1] > nose[1], "{all:?}");
            assert!(nose[1] > mouth[1] && mouth[1] > chin[1] && chin[1] > neck[1], "{all:?}");
            assert!(nose[2] > cheeks[2] && cheeks[2] > ears[2] && ears[0] > jaw[0], "{all:?}");
        }
        assert!(head_parts("octopus", &[]).is_none());
    }

    #[test]
    fn a_slider_moves_the_jaw_and_hardly_makes_it_less() {
        let share = |name: &str, part: &str| {
            let mesh = sample(name).unwrap();
            let areas = crate::surface::vertex_areas(&mesh.positions, &mesh.triangles);
            let number = HEAD_PARTS.iter().position(|p| *p == part).unwrap();
            let parts = head_parts(name, &mesh.positions).unwrap();
            let own = parts.iter().zip(&areas).filter(|(p, _)| usize::from(**p) == number);
            own.map(|(_, area)| area).sum::<f64>() / areas.iter().sum::<f64>()
        };
        for (name, part) in [("portrait?jaw=-1", "jaw"), ("portrait?brow=-1", "brow")] {
            let (weak, plain) = (share(name, part), share("portrait", part));
            assert!(weak > 0.8 * plain, "{part}: {weak} of {plain}");
        }
    }

    fn narrowest_angle(mesh: &TriMesh, triangle: &[u32; 3]) -> f64 {
        use crate::surface::corners;
        use crate::surface::vec3::{dot, sub, unit};
        let p = corners(&mesh.positions, triangle);
        let angle = |i: usize| {
            let (u, v) = (unit(sub(p[(i + 1) % 3], p[i])), unit(sub(p[(i + 2) % 3], p[i])));
            dot(u, v).clamp(-1.0, 1.0).acos().to_degrees()
        };
        angle(0).min(angle(1)).min(angle(2))
    }

    /// How far the worst vertex is from a mirror image of another.
    fn mirror_error(mesh: &TriMesh) -> f64 {
        let key = |p: [f64; 3]| p.map(|x| (x * 1e4).round() as i64);
        let mut cells = std::collections::HashMap::new();
        for p in &mesh.positions {
            cells.insert(key(*p), *p);
        }
        let distance = |p: &[f64; 3]| {
            let image = [-p[0], p[1], p[2]];
            let [i, j, k] = key(image);
            let around = (-1..=1)
                .flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [i + a, j + b, k + c])));
            let near = around.filter_map(|cell| cells.get(&cell));
            near.map(|q| crate::surface::vec3::length(crate::surface::vec3::sub(*q, image)))
                .fold(1.0, f64::min)
        };
        mesh.positions.iter().map(distance).fold(0.0, f64::max)
    }
}
