//! The options that say which way a shape stands in pictures.

use chladni_mesh::Axis;

use crate::work::Stance;

/// Where up and front are; the one that is not given is as the show, the project or the sample has it, else estimated.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct StanceOptions {
    /// Which axis of the file points up in pictures: x, y, z, -x, -y or -z. That of the show, the project
    /// or the sample unless given, else estimated; results keep the file's axes in any case, and viewers of a
    /// GLB take y for up.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<Axis>,
    /// Which axis of the file points to a viewer in front.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    front: Option<Axis>,
}

impl StanceOptions {
    /// One of these options that was given, by its name.
    pub fn given(&self) -> Option<&'static str> {
        self.up.map(|_| "--up").or(self.front.map(|_| "--front"))
    }
}

impl From<StanceOptions> for Stance {
    fn from(StanceOptions { up, front }: StanceOptions) -> Self {
        Self { up, front }
    }
}
