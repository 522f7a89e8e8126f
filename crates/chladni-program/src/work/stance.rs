//! Which way a shape stands in pictures: given by the user or a project, else estimated.

use chladni_mesh::{Axis, Estimate, Known, Orientation, ShapeSource, TriMesh};

use super::{Error, Warning, Watcher};

/// Up and front as given by the user; missing ones are those of the show, the project or the sample, else
/// estimated.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stance {
    /// The axis of the file that points up.
    pub up: Option<Axis>,
    /// The axis that points to a viewer in front.
    pub front: Option<Axis>,
}

fn is_along(axis: Axis, direction: [f64; 3]) -> bool {
    Axis::of(direction).is_some_and(|other| axis.is_along(other))
}

impl Stance {
    /// Whether anything was given.
    pub fn is_given(&self) -> bool {
        self.up.is_some() || self.front.is_some()
    }

    /// Checks, before any work, that up and front are compatible.
    ///
    /// # Errors
    /// [`Error::Input`] where up and front lie on one line.
    pub fn check(&self) -> Result<(), Error> {
        match (self.up, self.front) {
            (Some(up), Some(front)) if up.is_along(front) => {
                Err(Error::Input(format!("--up {up} and --front {front} lie on one line")))
            }
            _ => Ok(()),
        }
    }

    /// `kept`, with the axes given here in the place of its own; `None` where the half that stays lies along the one given.
    fn completed(&self, kept: Orientation) -> Option<Orientation> {
        if !self.is_given() {
            return Some(kept);
        }
        let up = self.up.map_or(kept.up(), Axis::direction);
        let front = self.front.map_or(kept.front(), Axis::direction);
        Orientation::new(up, front)
    }

    /// The axes given here, completed by those known of the source.
    fn known(&self, source: &ShapeSource) -> Known {
        let given = Known {
            up: self.up.map(Axis::direction),
            front: self.front.map(Axis::direction),
            ..Known::default()
        };
        match source {
            ShapeSource::File(_) if self.up.is_none() => {
                let of_source = source.known();
                let is_free = |up: &[f64; 3]| self.front.is_none_or(|front| !is_along(front, *up));
                Known { up: of_source.up.filter(is_free), usual_front: of_source.usual_front, ..given }
            }
            _ => given,
        }
    }

    /// The orientation of the mesh called `name`: as given here; else, or for the half that was not given, as `kept`;
    /// else, for a sample, as modeled; else as estimated from its surface; or, if the estimate is in doubt, that of the
    /// template that it was `matched` with. Warns if the doubt remains.
    ///
    /// # Errors
    /// As [`check`](Self::check) does, and [`Error::Cancelled`].
    pub fn of(
        &self,
        name: &str,
        mesh: &TriMesh,
        kept: Option<Orientation>,
        matched: Option<Orientation>,
        watcher: &impl Watcher,
    ) -> Result<Orientation, Error> {
        self.check()?;
        let kept = kept.or_else(|| ShapeSource::named(name).stands());
        if let Some(stands) = kept.and_then(|kept| self.completed(kept)) {
            return Ok(stands);
        }
        let known = self.known(&ShapeSource::named(name));
        let found = watcher.watch("finding which way is up", |task| Estimate::of(mesh, known, task))?;
        if !found.in_doubt {
            return Ok(found.orientation);
        }
        if let Some(matched) = matched.filter(|_| !self.is_given()) {
            return Ok(matched);
        }
        watcher.warn(Warning::InDoubt { name: name.to_owned(), stands: found.orientation });
        Ok(found.orientation)
    }
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples;
    use chladni_task::Task;

    use super::*;
    use crate::work::Aside;

    #[test]
    fn one_axis_leaves_the_other_as_it_was() {
        let task = Task::new();
        let mesh = samples::icosphere(1);
        let stands = |name: &str, [up, front]: [Option<&str>; 2], kept: Option<&str>| {
            let [up, front] = [up, front].map(|axis| axis.map(|axis| axis.parse().unwrap()));
            let kept = kept.map(|kept| kept.parse().unwrap());
            Stance { up, front }.of(name, &mesh, kept, None, &Aside::new(&task)).unwrap().to_string()
        };
        let kept = Some("up x, front z");
        assert_eq!(stands("a.obj", [None, None], kept), "up x, front z");
        assert_eq!(stands("a.obj", [None, Some("-z")], kept), "up x, front -z");
        assert_eq!(stands("a.obj", [Some("y"), None], kept), "up y, front z");
        assert_eq!(stands("sample:ring", [None, Some("x")], None), "up y, front x");
        assert_eq!(stands("sample:ring", [Some("-y"), None], None), "up -y, front z");
        // The half that was kept cannot stay.
        for given in [[Some("z"), None], [None, Some("-x")]] {
            assert_eq!(stands("a.obj", given, kept), stands("a.obj", given, None));
        }
    }
}
