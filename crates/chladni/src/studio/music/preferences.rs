//! What the music room remembers between runs.

use chladni_music::Binding;
use chladni_view::{Background, Lights, Material};
use serde::{Deserialize, Serialize};

/// Looks, the stage's screen, and what turns what. Names that are not known any more fall back
/// to the first look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// One of [`Material::PRESETS`].
    pub material: String,
    /// One of [`Lights::PRESETS`].
    pub lights: String,
    /// One of [`Background::PRESETS`].
    pub background: String,
    /// Where the stage appears.
    pub screen: Screen,
    /// The UDP port on which OSC messages are heard; `None` is off.
    pub osc_port: Option<u16>,
    /// Which controls turn what.
    pub bindings: Vec<Binding>,
}

/// Where the stage appears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Screen {
    /// Within the window.
    #[default]
    Window,
    /// The whole screen that the window is on.
    Full,
    /// The whole of another screen, counted from 0 as the system counts them.
    Monitor(usize),
}

impl Default for Preferences {
    fn default() -> Self {
        let [material, lights, background] = ["pearl", "stage", "night"].map(str::to_owned);
        Self { material, lights, background, screen: Screen::default(), osc_port: None, bindings: Vec::new() }
    }
}

impl Preferences {
    /// The looks by their names.
    pub fn look(&self) -> Look {
        Look {
            material: Material::named(&self.material).unwrap_or(Material::PEARL),
            lights: Lights::named(&self.lights).unwrap_or(Lights::STAGE),
            background: Background::named(&self.background).unwrap_or(Background::NIGHT),
        }
    }
}

/// What the shapes are made of and what shines on them.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The shapes'.
    pub material: Material,
    /// On them.
    pub lights: Lights,
    /// Behind them.
    pub background: Background,
}
