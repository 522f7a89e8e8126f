//! A table of everything that a knob, a pad or an OSC message may turn, press or
//! choose.
//!
//! OSC addresses, the targets that can be learned, and the page `docs/controls.md` are generated from it.

use serde::{Deserialize, Serialize};

use crate::{Choir, Form, Parameter, Parameters, Switch};

/// Anything that a control may turn, press or choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the table says what they are")]
pub enum Target {
    Parameter(Parameter),
    Switch(Switch),
    Harmonics,
    Form,
    Choir,
    Look,
    Palette,
    Material,
    Lights,
    Background,
    Shot,
    Preset,
    Song,
    Choose,
    #[serde(alias = "favourite")]
    Favorite,
    Lock,
    Mutate,
    Stage,
    Cue,
    Breed,
    Back,
    Forth,
    #[serde(alias = "next-favourite")]
    NextFavorite,
    #[serde(alias = "previous-favourite")]
    PreviousFavorite,
    LeaveStage,
    Go,
    Blackout,
    Freeze,
    RandomPreset,
    Autopilot,
    Stay,
    Sweep,
    Tap,
    Halve,
    Double,
    HoldTempo,
    NudgeLater,
    NudgeSooner,
    PlayPause,
    NextSong,
    PreviousSong,
    Crossfade,
    Volume,
    SongFade,
    Blur,
    Repeat,
    Shuffle,
    Live,
    FollowClock,
    Record,
}

/// How a target is controlled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number in a range.
    Level,
    /// On or off; a press toggles it.
    Switch,
    /// One of several choices, by number or name; a press takes the next one.
    Choice,
    /// An action on a dance of the gallery, by its number; a press takes the dance that is marked.
    Dance,
    /// An action that a press performs.
    Button,
}

/// Target, kind, name in files and addresses, and description.
type Row = (Target, Kind, &'static str, &'static str);

/// All targets except the knobs and switches, which have tables of their own.
const TABLE: [Row; 48] = [
    (Target::Harmonics, Kind::Level, "harmonics", "Harmonics in use"),
    (Target::Crossfade, Kind::Level, "crossfade", "From the dance on stage to the next"),
    (Target::Volume, Kind::Level, "volume", "Loudness of the songs"),
    (Target::SongFade, Kind::Level, "song-fade", "Crossfade between songs, up to 12 s"),
    (Target::Blur, Kind::Level, "blur", "Depth of field"),
    (Target::Form, Kind::Choice, "form", "Form"),
    (Target::Choir, Kind::Choice, "choir", "Which harmonics sound"),
    (Target::Look, Kind::Choice, "look", "Look"),
    (Target::Palette, Kind::Choice, "palette", "Palette; own: the shape's colors"),
    (Target::Material, Kind::Choice, "material", "Material"),
    (Target::Lights, Kind::Choice, "lights", "Light"),
    (Target::Background, Kind::Choice, "background", "Background"),
    (Target::Shot, Kind::Choice, "shot", "Camera shot"),
    (Target::Preset, Kind::Choice, "preset", "Preset of the shelf"),
    (Target::Song, Kind::Choice, "song", "Song of the list"),
    (Target::Repeat, Kind::Choice, "repeat", "What is repeated"),
    (Target::Choose, Kind::Dance, "choose", "Choose as a parent, or no longer"),
    (Target::Favorite, Kind::Dance, "favorite", "Favorite, or no longer"),
    (Target::Lock, Kind::Dance, "lock", "Lock in its place, or unlock"),
    (Target::Mutate, Kind::Dance, "mutate", "Change it a little"),
    (Target::Stage, Kind::Dance, "stage", "Put it on stage"),
    (Target::Cue, Kind::Dance, "cue", "Next on stage"),
    (Target::Breed, Kind::Button, "breed", "Breed the chosen ones"),
    (Target::Back, Kind::Button, "back", "The generation of the parents"),
    (Target::Forth, Kind::Button, "forth", "The generation after"),
    (Target::NextFavorite, Kind::Button, "next", "Next favorite on stage"),
    (Target::PreviousFavorite, Kind::Button, "previous", "The favorite before"),
    (Target::LeaveStage, Kind::Button, "leave", "Leave the stage"),
    (Target::Go, Kind::Button, "go", "Bring the next dance on stage"),
    (Target::Blackout, Kind::Button, "blackout", "Black, or back"),
    (Target::Freeze, Kind::Button, "freeze", "Freeze the picture, or go on"),
    (Target::RandomPreset, Kind::Button, "random", "A preset at random"),
    (Target::Autopilot, Kind::Button, "autopilot", "Lean back, or no longer"),
    (Target::Stay, Kind::Button, "stay", "The autopilot stays, or goes on"),
    (Target::Sweep, Kind::Button, "sweep", "Sweep the sand"),
    (Target::Tap, Kind::Button, "tap", "Tap the beat"),
    (Target::Halve, Kind::Button, "halve", "The beat half as fast"),
    (Target::Double, Kind::Button, "double", "The beat twice as fast"),
    (Target::HoldTempo, Kind::Button, "hold-tempo", "Hold the tempo, or listen again"),
    (Target::NudgeLater, Kind::Button, "later", "The beat a little later"),
    (Target::NudgeSooner, Kind::Button, "sooner", "The beat a little sooner"),
    (Target::PlayPause, Kind::Button, "play", "Play or pause"),
    (Target::NextSong, Kind::Button, "next-song", "Next song"),
    (Target::PreviousSong, Kind::Button, "previous-song", "The song before"),
    (Target::Shuffle, Kind::Button, "shuffle", "The songs in another order"),
    (Target::Live, Kind::Button, "live", "Live input, or the songs again"),
    (Target::FollowClock, Kind::Button, "follow-clock", "Follow MIDI clock and OSC, or the music again"),
    (Target::Record, Kind::Button, "record", "Record the set, or end that"),
];

impl Target {
    /// All targets: knobs, switches, then the others.
    pub fn all() -> impl Iterator<Item = Self> {
        let knobs = Parameter::ALL.into_iter().map(Self::Parameter);
        let switches = Switch::ALL.into_iter().map(Self::Switch);
        knobs.chain(switches).chain(TABLE.iter().map(|row| row.0))
    }

    /// The name, with which its OSC address ends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.name(),
            Self::Switch(switch) => switch.name(),
            _ => self.row().map_or("", |row| row.2),
        }
    }

    /// How it is controlled.
    pub fn kind(self) -> Kind {
        match self {
            Self::Parameter(_) => Kind::Level,
            Self::Switch(_) => Kind::Switch,
            _ => self.row().map_or(Kind::Button, |row| row.1),
        }
    }

    /// A short description.
    pub fn about(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.about(),
            Self::Switch(switch) => switch.about(),
            _ => self.row().map_or("", |row| row.3),
        }
    }

    fn row(self) -> Option<&'static Row> {
        TABLE.iter().find(|row| row.0 == self)
    }

    /// The target with that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|target| target.name() == name)
    }

    /// The position of the target, in [0, 1], if the instrument knows it. For a choice, 1 if it is choice
    /// `number` (from 1), otherwise 0.
    pub fn standing(self, number: Option<u32>, parameters: &Parameters) -> Option<f32> {
        let is = |at: Option<usize>| number.map(|n| f32::from(u8::from(at == (n as usize).checked_sub(1))));
        match self {
            Self::Parameter(parameter) => Some(parameter.share(parameters.get(parameter))),
            Self::Switch(switch) => Some(f32::from(u8::from(parameters.is_on(switch)))),
            Self::Harmonics => {
                Some(parameters.harmonics.map_or(1.0, |k| (k as f32 / MOST_HARMONICS).clamp(0.0, 1.0)))
            }
            Self::Form => is(FORMS.iter().position(|(_, form)| *form == parameters.form)),
            Self::Choir => is(CHOIRS.iter().position(|(_, choir)| *choir == parameters.choir)),
            _ => None,
        }
    }
}

/// All forms with their names, in the order of their numbers.
pub const FORMS: [(&str, Form); 3] =
    [("filter", Form::Filter), ("modal", Form::Modal), ("half-mask", Form::HalfMask)];
/// All choirs with their names, in the order of their numbers.
pub const CHOIRS: [(&str, Choir); 3] =
    [("all", Choir::All), ("symmetric", Choir::Symmetric), ("antisymmetric", Choir::Antisymmetric)];
/// What can be repeated, in the order of its numbers.
pub const REPEATS: [&str; 3] = ["nothing", "song", "list"];
/// The number of harmonics at the top of a fader.
pub(crate) const MOST_HARMONICS: f32 = 512.0;

/// The page that lists all controls, in Markdown.
pub fn controls_page() -> String {
    let mut page = String::from(
        "# Controls\n\n\
         All that can be learned in the drawer *Remote* or addressed over OSC ([stage](stage.md)). \
         `chladni controls` writes this page.\n",
    );
    let begins = Parameters::default();
    let numbers = |target: Target| match target {
        Target::Parameter(parameter) => {
            let (low, high) = parameter.range();
            format!("{low} to {high}; at first {}", parameter.initial())
        }
        Target::Switch(switch) => format!("0 or 1; at first {}", u8::from(begins.is_on(switch))),
        Target::Harmonics => "how many; 0 is all".into(),
        Target::Form => FORMS.map(|(name, _)| name).join(", "),
        Target::Choir => CHOIRS.map(|(name, _)| name).join(", "),
        Target::Repeat => REPEATS.join(", "),
        Target::Song => "number from 1, or name (file, title, *artist – title*); none: the next".into(),
        _ => match target.kind() {
            Kind::Level => "0 to 1".into(),
            Kind::Switch => "0 or 1".into(),
            Kind::Choice => "number from 1, or name; none: the next".into(),
            Kind::Dance => "number from 1; none: the marked one".into(),
            Kind::Button => "none, or not 0".into(),
        },
    };
    let groups = [
        (
            "Levels",
            Kind::Level,
            "A knob or fader maps its way evenly, or in even factors where the range spans more than three powers of ten.",
        ),
        ("Switches", Kind::Switch, "A press turns it over."),
        ("Choices", Kind::Choice, "A press takes the next; a binding with a number takes that one."),
        (
            "Dances",
            Kind::Dance,
            "A press acts on the dance that is marked; a binding with a number on that one.",
        ),
        ("Buttons", Kind::Button, "A fader presses where it passes its middle, a pad at any touch."),
    ];
    for (heading, kind, about) in groups {
        page += &format!("\n## {heading}\n{about}\n\n| OSC | value | what |\n|---|---|---|\n");
        for target in Target::all().filter(|target| target.kind() == kind) {
            let about = match target {
                // Turned from outside, it also switches off that each has its own.
                Target::Parameter(Parameter::StereoMu) => {
                    "How much middle and sides mix, of all dances: none has a µ of its own from then on"
                }
                _ => target.about(),
            };
            page += &format!("| `/chladni/{}` | {} | {about} |\n", target.name(), numbers(target));
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cue, osc_cue};
    use std::collections::HashSet;

    fn cue(address: &str, value: Option<f32>) -> Option<Cue> {
        osc_cue(address, value, None, &Parameters::default())
    }

    #[test]
    fn every_target_has_one_name_and_its_address_reaches_it() {
        let mut names = HashSet::new();
        for target in Target::all() {
            assert!(!target.name().is_empty() && names.insert(target.name()), "{target:?}");
            assert_eq!(Target::named(target.name()), Some(target));
            let address = format!("/chladni/{}", target.name());
            let reached = cue(&address, Some(1.0)).or_else(|| cue(&address, None));
            assert!(reached.is_some(), "{target:?}");
            assert!(controls_page().contains(&format!("`{address}`")));
        }
    }

    #[test]
    fn the_page_says_of_each_control_itself() {
        let page = controls_page();
        assert!(!page.contains("see [music]"));
        for target in Target::all().filter(|&target| target != Target::Parameter(Parameter::StereoMu)) {
            assert!(!target.about().is_empty(), "{target:?}");
            assert!(page.contains(&format!(" | {} |\n", target.about())), "{target:?}");
        }
        assert!(page.contains("| `/chladni/gain` | 0 to 20; at first 1 |"));
        assert!(page.contains("| `/chladni/own-mu` | 0 or 1; at first 1 |"));
    }
}
