//! How a sample looks when it is shown first: its material, and from where it is seen.

use std::path::Path;

use chladni_mesh::ShapeSource;
use chladni_music::{Looks, Viewpoint};
use chladni_view::Look;

use super::{FIRST_VIEW, first_looks, look_named};

/// Samples that are not seen in the default way: a look, or material, lights and background; yaw and pitch in
/// radians.
const OWN: [(&str, &[&str], [f32; 2]); 8] = [
    ("plate", &["dark", "studio", "paper"], [0.30, 0.88]),
    ("disc", &["dark", "studio", "paper"], [0.0, 0.85]),
    ("drum", &["ember"], [0.0, 0.52]),
    ("bell", &["gold"], [0.25, 0.12]),
    ("ring", &["chrome"], [0.45, 0.25]),
    ("jellyfish", &["abyss"], [0.15, 0.05]),
    ("human", &["neon"], [0.30, 0.10]),
    ("cat", &["opal"], [0.55, 0.18]),
];

/// Where the viewer of a body stands first, as the command line calls it.
pub fn opening_view(body: &str) -> Viewpoint {
    own(body).map_or(FIRST_VIEW, |(_, _, [yaw_rad, pitch_rad])| Viewpoint {
        yaw_rad,
        pitch_rad,
        ..FIRST_VIEW
    })
}

/// Its look.
pub fn opening_looks(body: &str) -> Looks {
    match own(body) {
        Some((_, [look], _)) => Looks { look: (*look).into(), ..Looks::default() },
        Some((_, [material, lights, background], _)) => Looks {
            material: (*material).into(),
            lights: (*lights).into(),
            background: (*background).into(),
            ..Looks::default()
        },
        _ => first_looks(),
    }
}

/// The look of a film's flat sheet on which sand lies: that of the sample plate in the place of the one in which most shapes
/// open, whose colors change below the sand; any other stays.
pub fn look_under_sand(look: Look) -> Look {
    let (first, _) = look_named(&first_looks());
    if look != (Look { finish: look.finish, ..first }) {
        return look;
    }
    let (plate, _) = look_named(&opening_looks("sample:plate"));
    plate.in_place_of(&look)
}

fn own(body: &str) -> Option<(&'static str, &'static [&'static str], [f32; 2])> {
    let name = ShapeSource::sample_name(Path::new(body))?;
    OWN.into_iter().find(|(known, ..)| *known == name)
}

#[cfg(test)]
mod tests {
    use chladni_view::Effect;

    use super::*;

    #[test]
    fn every_own_look_is_of_a_sample_and_there() {
        for (name, ..) in OWN {
            assert!(chladni_mesh::samples::SAMPLES.contains(&name), "{name}");
            let (_, missing) = look_named(&opening_looks(&format!("sample:{name}")));
            assert!(missing.is_empty(), "{name}: {missing:?}");
        }
        assert_eq!(opening_view("sample:octopus"), FIRST_VIEW);
        assert_eq!(opening_looks("plate.obj"), first_looks());
    }

    #[test]
    fn sand_on_a_sheet_lies_in_the_look_of_the_plate_unless_another_is_chosen() {
        let plate = look_named(&opening_looks("sample:plate")).0;
        assert_eq!(look_under_sand(Look::AURORA), plate);
        assert_eq!((look_under_sand(plate), look_under_sand(Look::EMBER)), (plate, Look::EMBER));
        let own = Look { own_colors: true, ..Look::AURORA };
        assert_eq!(look_under_sand(own), own);
        // What is left out of all looks is left out of this one, too.
        let finish = Look::AURORA.finish.without(Effect::Trails);
        let calm = look_under_sand(Look { finish, ..Look::AURORA });
        assert_eq!((calm.material, calm.finish.left_out), (plate.material, finish.left_out));
    }
}
