//! Looks by their names, as shows keep them.

use chladni_music::{Action, Instrument, Looks, Show};
use chladni_view::{Answer, Background, Effect, Lights, Look, Material, Palette};

/// The default look.
pub fn first_looks() -> Looks {
    Looks { look: "aurora".into(), ..Looks::default() }
}

/// The palette of this name is the shape's own colors.
pub const OWN_COLORS: &str = "own";

/// The look of the dance on stage in place of the show's, as far as this version knows it. Shapes that show their own
/// colors keep them, effects that are left out stay so, and so does a blur that is kept.
pub fn look_on_stage(instrument: &Instrument, of_show: Look) -> Look {
    let staged = instrument.look().and_then(Look::named);
    staged.map_or(of_show, |look| look.in_place_of(&of_show))
}

/// Warnings when a show is opened: that it is old, or names looks, or parts of them, which this version does not
/// know.
pub fn cautions(show: &Show) -> impl Iterator<Item = String> {
    show.caution().map(str::to_owned).into_iter().chain(unknown_looks(show))
}

fn unknown_looks(show: &Show) -> Option<String> {
    let mut unknown = show.looks.as_ref().map_or_else(Vec::new, |looks| look_named(looks).1);
    for line in &show.actions {
        if let Action::SetLook { look } = &line.action
            && !look.is_empty()
            && Look::named(look).is_none()
            && !unknown.contains(look)
        {
            unknown.push(look.clone());
        }
    }
    (!unknown.is_empty()).then(|| {
        format!("looks that this version does not have: {}. Others stand in for them.", unknown.join(", "))
    })
}

/// The look of those names, and which of them are unknown: the look's own part is taken instead, or the plain
/// look. A material or a background that is named takes the place of the palette or the floor, too.
pub fn look_named(looks: &Looks) -> (Look, Vec<String>) {
    let mut missing = Vec::new();
    let mut found = |name: &String, is_known: bool| {
        if !name.is_empty() && !is_known {
            missing.push(name.clone());
        }
    };
    let whole = Look::named(&looks.look);
    found(&looks.look, whole.is_some());
    let mut look = whole.unwrap_or(Look::PLAIN);
    let material = Material::named(&looks.material);
    found(&looks.material, material.is_some());
    if let Some(material) = material {
        look = Look { material, answer: None, ..look };
    }
    let palette = Palette::named(&looks.palette);
    look.own_colors = looks.palette == OWN_COLORS;
    found(&looks.palette, palette.is_some() || look.own_colors);
    if let Some(palette) = palette {
        look.answer = Some(Answer { palette, ..look.answer.unwrap_or(Answer::MOVED) });
    }
    let lights = Lights::named(&looks.lights);
    found(&looks.lights, lights.is_some());
    look.lights = lights.unwrap_or(look.lights);
    let background = Background::named(&looks.background);
    found(&looks.background, background.is_some());
    look.background = background.unwrap_or(look.background);
    if let Some(percent) = looks.blur_percent {
        look.finish.blur = blur(percent);
    }
    for name in &looks.without {
        let effect = Effect::named(name);
        found(name, effect.is_some());
        look.finish = effect.map_or(look.finish, |effect| look.finish.without(effect));
    }
    (look, missing)
}

/// The blur of a finish that is chosen in percent.
pub fn blur(percent: u8) -> f32 {
    f32::from(percent.min(100)) / 100.0
}

#[cfg(test)]
mod tests {
    use chladni_music::{GalleryShape, Moment};
    use chladni_view::Finish;

    use super::*;

    #[test]
    fn names_make_a_look_and_unknown_ones_are_told() {
        let names = |[look, material, lights, background]: [&str; 4]| Looks {
            look: look.into(),
            material: material.into(),
            lights: lights.into(),
            background: background.into(),
            ..Looks::default()
        };
        assert_eq!(look_named(&names(["ember", "", "", ""])), (Look::EMBER, vec![]));
        assert_eq!(look_named(&first_looks()), (Look::AURORA, vec![]));
        // Shows of before looks had names.
        let (old, missing) = look_named(&names(["", "pearl", "stage", "night"]));
        assert_eq!((old, missing), (Look::PLAIN, vec![]));
        let (mixed, missing) = look_named(&names(["ember", "bronze", "candle", ""]));
        assert_eq!((mixed.material, mixed.answer), (Material::BRONZE, None));
        assert_eq!((mixed.lights, mixed.finish), (Look::EMBER.lights, Look::EMBER.finish));
        assert_eq!(missing, ["candle"]);
        let soft = Looks { look: "ember".into(), blur_percent: Some(60), ..Looks::default() };
        assert_eq!(look_named(&soft).0.finish, Finish { blur: 0.6, ..Look::EMBER.finish });
        let without = ["trails", "grain", "sparkle"].map(str::to_owned).to_vec();
        let calm = Looks { look: "ember".into(), without, ..Looks::default() };
        let finish = Look::EMBER.finish.without(Effect::Trails).without(Effect::Grain);
        assert_eq!(look_named(&calm), (Look { finish, ..Look::EMBER }, vec!["sparkle".to_owned()]));
        assert!(Look::EMBER.finish.has(Effect::Trails) && !finish.has(Effect::Trails));
        let gold = Looks { look: "ember".into(), palette: "gold".into(), ..Looks::default() };
        assert_eq!(look_named(&gold).0.answer.map(|answer| answer.palette), Some(Palette::Gold));
        let own = Looks { look: "ember".into(), palette: OWN_COLORS.into(), ..Looks::default() };
        assert_eq!(look_named(&own), (Look { own_colors: true, ..Look::EMBER }, vec![]));
        assert!(Palette::named(OWN_COLORS).is_none());
        assert_eq!(look_named(&names(["dawn", "", "", ""])), (Look::PLAIN, vec!["dawn".to_owned()]));
    }

    #[test]
    fn a_look_that_comes_on_stage_lacks_what_is_left_out() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        instrument.apply(Moment::default(), Action::SetLook { look: "ember".into() }).unwrap();
        let without = vec!["trails".to_owned()];
        let (of_show, _) = look_named(&Looks { look: "aurora".into(), without, ..Looks::default() });
        let finish = Look::EMBER.finish.without(Effect::Trails);
        assert_eq!(look_on_stage(&instrument, of_show), Look { finish, ..Look::EMBER });
        // A blur belongs to its look, unless it is kept.
        let mut soft = Look { finish: Finish { blur: 0.9, ..Look::AURORA.finish }, ..Look::AURORA };
        assert_eq!(look_on_stage(&instrument, soft), Look::EMBER);
        soft.finish.keeps_blur = true;
        let finish = Finish { blur: 0.9, keeps_blur: true, ..Look::EMBER.finish };
        assert_eq!(look_on_stage(&instrument, soft), Look { finish, ..Look::EMBER });
    }
}
