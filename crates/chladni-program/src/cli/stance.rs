//! Which way a shape stands in pictures: told by options or the project, else estimated.

use chladni_mesh::{Axis, Estimate, Known, Orientation, TriMesh};

use super::{Failure, Terminal};

/// Where up and front are; what is not said is estimated.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Stance {
    /// Which axis of the file points up in pictures: x, y, z, -x, -y or -z. Estimated unless given;
    /// results keep the file's axes in any case.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<Axis>,
    /// Which axis of the file points to a viewer in front.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    front: Option<Axis>,
}

impl Stance {
    /// Whether anything was said.
    pub fn is_told(&self) -> bool {
        self.up.is_some() || self.front.is_some()
    }

    /// Before any work: can it be so?
    pub fn check(&self) -> Result<(), Failure> {
        match (self.up, self.front) {
            (Some(up), Some(front)) if up.is_along(front) => {
                Err(Failure::input(format_args!("--up {up} and --front {front} lie on one line")))
            }
            _ => Ok(()),
        }
    }

    /// How the mesh called `name` stands: as was said here, or else as `kept` says, or else as its
    /// surface speaks for, or, where that is in doubt, as `matched` to a template does. Warns where it
    /// stays in doubt.
    pub fn of(
        &self,
        name: &str,
        mesh: &TriMesh,
        kept: Option<Orientation>,
        matched: Option<Orientation>,
        terminal: &Terminal,
    ) -> Result<Orientation, Failure> {
        self.check()?;
        if let Some(kept) = kept.filter(|_| !self.is_told()) {
            return Ok(kept);
        }
        let known = Known { up: self.up.map(Axis::direction), front: self.front.map(Axis::direction) };
        let found = terminal
            .watch("finding which way is up", |task| Estimate::of(mesh, known, task))
            .map_err(|_| Failure::Cancelled)?;
        if !found.in_doubt {
            return Ok(found.orientation);
        }
        if let Some(matched) = matched.filter(|_| !self.is_told()) {
            return Ok(matched);
        }
        terminal.warn(format_args!(
            "{name}: drawn with {}, which is in doubt: --up and --front say otherwise",
            found.orientation
        ));
        Ok(found.orientation)
    }
}
