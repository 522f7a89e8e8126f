//! Preferences of the music room, kept between runs.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::path::PathBuf;

use chladni_music::{Binding, Looks};
use chladni_sound::MOST_AHEAD_SECS;
use chladni_view::Look;
use chladni_view::film::CameraTarget;
use serde::{Deserialize, Serialize};

use super::listening::Input;
use super::projection::Projection;
use crate::work::{first_looks, look_named};

/// The picture is at most this much later than the sound, or earlier.
pub const MOST_LATE_MS: i32 = (1e3 * MOST_AHEAD_SECS) as i32;

/// Looks, the stage's screen, and what turns what. Unknown names fall back to the first look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// The whole scene, by its name; older files knew none but the plain one.
    #[serde(default)]
    pub look: String,
    /// By its name; empty is the look's own, as the next three.
    pub palette: String,
    /// By its name.
    pub material: String,
    /// By their name.
    pub lights: String,
    /// By its name.
    pub background: String,
    /// The file of a picture that stands behind all; none where it is empty.
    pub picture: String,
    /// The file of a panorama that shines on it.
    pub panorama: String,
    /// Depth of field: softness out of focus; `None` is the look's own.
    pub blur_percent: Option<u8>,
    /// Effects that are left out of any look, by their names.
    pub without: Vec<String>,
    /// Where the stage appears.
    pub screen: Screen,
    /// The stage has a window of its own, and the gallery goes on in the first.
    pub own_window: bool,
    /// The camera through which other programs see the stage.
    pub camera: Camera,
    /// The size of its pictures.
    pub camera_size: CameraSize,
    /// The UDP port on which OSC messages are heard; `None` is off.
    pub osc_port: Option<u16>,
    /// OSC of other machines is heard, too: of these, by their addresses, or of any where none is named.
    pub osc_network: bool,
    /// Such as `192.168.1.20`.
    pub osc_allowed: Vec<IpAddr>,
    /// The beat is that of MIDI clock or OSC, where one is heard.
    pub follows_clock: bool,
    /// Where the beat is sent by OSC, as `HOST:PORT`, and the MIDI device that its clock goes to.
    pub beat_out: Option<String>,
    /// By its name.
    pub clock_out: Option<String>,
    /// How the picture of the stage is projected.
    pub projection: Projection,
    /// Loudness of the songs, in [0, 1].
    pub volume: f32,
    /// How long one song fades into the next.
    pub song_fade_secs: f64,
    /// The device that plays them; `None` is the system's own.
    pub output_device: Option<String>,
    /// The live input that was chosen last, by its name.
    pub live_input: Option<String>,
    /// How much louder live input is made, in decibels.
    pub live_gain_db: f32,
    /// Live input is heard as loud as it is, instead of its level being followed.
    pub live_fixed_level: bool,
    /// How much later the picture is seen than the sound of each output device is heard, in milliseconds; the system's own
    /// has no name.
    pub picture_late_ms: BTreeMap<String, i32>,
    /// The autopilot begins where a song is opened and nothing is touched.
    pub leans_back: bool,
    /// A song is named on stage when it begins.
    pub song_titles: bool,
    /// Which controls turn what.
    pub bindings: Vec<Binding>,
}

/// Where the stage appears.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Screen {
    /// Within the window.
    #[default]
    Window,
    /// The whole screen that the window is on.
    Full,
    /// The whole of another screen, counted from 0 as the system counts them, as older preferences have it.
    Monitor(usize),
    /// The whole of the screen that the system calls so.
    Named(String),
}

impl Screen {
    /// The name of a screen that was chosen by itself.
    pub fn name(&self) -> Option<String> {
        match self {
            Self::Window | Self::Full => None,
            Self::Monitor(index) => Some(format!("Screen {}", index + 1)),
            Self::Named(name) => Some(name.clone()),
        }
    }

    /// Its place among the screens that there are; `None` where it is not there.
    pub fn index(&self, names: &[String]) -> Option<usize> {
        match self {
            Self::Window | Self::Full => None,
            // Where the system tells of none, a number is taken at its word.
            Self::Monitor(index) => Some(*index).filter(|index| names.is_empty() || *index < names.len()),
            Self::Named(wanted) => names.iter().position(|name| name == wanted),
        }
    }
}

/// Where other programs find the picture of the stage.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Camera {
    /// Nowhere.
    #[default]
    Off,
    /// Among PipeWire's cameras.
    PipeWire,
    /// In a video device.
    Device(PathBuf),
    /// Among Syphon's servers.
    Syphon,
}

impl Camera {
    /// The device to open for it.
    pub fn target(&self) -> Option<CameraTarget> {
        match self {
            Self::Off => None,
            Self::PipeWire => Some(CameraTarget::PipeWire),
            Self::Device(path) => Some(CameraTarget::Device(path.clone())),
            Self::Syphon => Some(CameraTarget::Syphon),
        }
    }
}

/// The size of the camera's pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CameraSize {
    /// That of the stage, or of the window, when the camera begins.
    #[default]
    AsSeen,
    /// 720p.
    Hd,
    /// 1080p.
    FullHd,
}

impl CameraSize {
    /// All of them and their labels.
    pub const ALL: [(Self, &str); 3] =
        [(Self::AsSeen, "As seen"), (Self::Hd, "1280 × 720"), (Self::FullHd, "1920 × 1080")];

    /// Width and height; `None` where it is as seen.
    pub fn pixels(self) -> Option<[u32; 2]> {
        match self {
            Self::AsSeen => None,
            Self::Hd => Some([1280, 720]),
            Self::FullHd => Some([1920, 1080]),
        }
    }
}

impl Default for Preferences {
    fn default() -> Self {
        let Looks { look, palette, material, lights, background, picture, panorama, blur_percent, without } =
            first_looks();
        Self {
            look,
            palette,
            material,
            lights,
            background,
            picture,
            panorama,
            blur_percent,
            without,
            screen: Screen::default(),
            own_window: false,
            camera: Camera::default(),
            camera_size: CameraSize::default(),
            osc_port: None,
            osc_network: false,
            osc_allowed: Vec::new(),
            follows_clock: false,
            beat_out: None,
            clock_out: None,
            projection: Projection::default(),
            volume: 1.0,
            song_fade_secs: 0.0,
            output_device: None,
            live_input: None,
            live_gain_db: 0.0,
            live_fixed_level: false,
            picture_late_ms: BTreeMap::new(),
            leans_back: true,
            song_titles: true,
            bindings: Vec::new(),
        }
    }
}

impl Preferences {
    /// How much later the picture is seen than the sound of the output device that is chosen is heard.
    pub fn late_ms(&self) -> i32 {
        self.picture_late_ms.get(self.device_name()).map_or(0, |ms| (*ms).clamp(-MOST_LATE_MS, MOST_LATE_MS))
    }

    /// The same, in seconds.
    pub fn late_secs(&self) -> f64 {
        1e-3 * f64::from(self.late_ms())
    }

    /// Keeps that for this device.
    pub fn set_late_ms(&mut self, ms: i32) {
        self.picture_late_ms.insert(self.device_name().to_owned(), ms.clamp(-MOST_LATE_MS, MOST_LATE_MS));
    }

    /// How live input is heard.
    pub fn input(&self) -> Input {
        Input::new(self.live_gain_db, self.live_fixed_level)
    }

    fn device_name(&self) -> &str {
        self.output_device.as_deref().unwrap_or_default()
    }

    /// The looks by their names.
    pub fn looks(&self) -> Looks {
        let [look, palette, material, lights, background] =
            [&self.look, &self.palette, &self.material, &self.lights, &self.background].map(String::clone);
        let [picture, panorama] = [&self.picture, &self.panorama].map(String::clone);
        let (blur_percent, without) = (self.blur_percent, self.without.clone());
        Looks { look, palette, material, lights, background, picture, panorama, blur_percent, without }
    }

    /// Looks like a show.
    pub fn look_like(&mut self, looks: &Looks) {
        let Looks { look, palette, material, lights, background, picture, panorama, blur_percent, without } =
            looks.clone();
        (self.look, self.palette, self.material) = (look, palette, material);
        (self.lights, self.background) = (lights, background);
        (self.picture, self.panorama) = (picture, panorama);
        (self.blur_percent, self.without) = (blur_percent, without);
    }

    /// Chooses a look by its name. It is a whole: parts that were chosen for another one go. Pictures around the stage are
    /// the user's own, as are the effects that are left out, and both stay.
    pub fn put_on(&mut self, look: String) {
        self.look_like(&with_lasting(Looks { look, ..Looks::default() }, &self.looks()));
    }

    /// The look that those names describe.
    pub fn look(&self) -> Look {
        look_named(&self.looks()).0
    }
}

/// `looks` with what stays under any look, as `own` has it: pictures around the stage, and the effects that are left out.
pub fn with_lasting(looks: Looks, own: &Looks) -> Looks {
    let (picture, panorama, without) = (own.picture.clone(), own.panorama.clone(), own.without.clone());
    Looks { picture, panorama, without, ..looks }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_look_drops_parts_and_keeps_pictures_and_what_is_left_out() {
        let pictured = Preferences {
            picture: "wall.png".into(),
            panorama: "sky.hdr".into(),
            without: vec!["grain".into()],
            ..Preferences::default()
        };
        let mut preferences =
            Preferences { material: "gold".into(), blur_percent: Some(40), ..pictured.clone() };
        preferences.put_on("ember".into());
        assert_eq!(preferences, Preferences { look: "ember".into(), ..pictured });
        let kept: Preferences = toml::from_str(&toml::to_string(&preferences).unwrap()).unwrap();
        assert_eq!(kept, preferences);
    }

    #[test]
    fn the_camera_has_the_size_that_was_chosen_in_each_run() {
        let size = |text: &str| toml::from_str::<Preferences>(text).unwrap().camera_size.pixels();
        assert_eq!(size("camera = \"pipe-wire\""), None);
        let chosen = Preferences { camera_size: CameraSize::FullHd, ..Preferences::default() };
        assert_eq!(size(&toml::to_string(&chosen).unwrap()), Some([1920, 1080]));
    }

    #[test]
    fn each_output_device_has_a_picture_of_its_own_lateness() {
        let mut preferences = Preferences::default();
        assert_eq!(preferences.late_ms(), 0);
        preferences.set_late_ms(80);
        preferences.output_device = Some("alsa:wireless".into());
        assert_eq!(preferences.late_ms(), 0);
        preferences.set_late_ms(-9_999);
        assert_eq!(preferences.late_ms(), -MOST_LATE_MS);
        let kept: Preferences = toml::from_str(&toml::to_string(&preferences).unwrap()).unwrap();
        assert_eq!(kept, preferences);
        assert_eq!(Preferences { output_device: None, ..kept }.late_ms(), 80);
        assert_eq!(toml::from_str::<Preferences>("volume = 0.5").unwrap().late_ms(), 0);
    }
}
