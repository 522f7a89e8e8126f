//! Which way a shape stands: where up and front are in its file's axes.

mod cloud;
mod estimate;
mod evidence;
mod likeness;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::MeshError;
use crate::surface::vec3::{Vec3, cross, dot, length, scaled, sub, unit};
pub use estimate::{Estimate, Evidence, Known};

/// A direction along an axis of the file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Axis {
    /// 0, 1 or 2 for x, y or z.
    index: usize,
    negative: bool,
}

impl Axis {
    /// x, y, z, −x, −y and −z.
    pub const ALL: [Self; 6] = [
        Self { index: 0, negative: false },
        Self { index: 1, negative: false },
        Self { index: 2, negative: false },
        Self { index: 0, negative: true },
        Self { index: 1, negative: true },
        Self { index: 2, negative: true },
    ];

    /// As a unit vector.
    pub fn direction(self) -> [f64; 3] {
        let mut direction = [0.0; 3];
        direction[self.index] = if self.negative { -1.0 } else { 1.0 };
        direction
    }

    /// Whether the two lie on one line.
    pub fn is_along(self, other: Self) -> bool {
        self.index == other.index
    }

    /// The axis that `direction` follows to a thousandth of its length, where it follows one.
    pub fn of(direction: [f64; 3]) -> Option<Self> {
        let direction = unit(direction);
        Self::ALL.into_iter().find(|axis| length(sub(axis.direction(), direction)) < 1e-3)
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", if self.negative { "-" } else { "" }, ["x", "y", "z"][self.index])
    }
}

impl FromStr for Axis {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        let bare = text.strip_prefix('+').unwrap_or(text);
        let named = |axis: &Self| axis.to_string().eq_ignore_ascii_case(bare);
        Self::ALL.into_iter().find(named).ok_or_else(|| MeshError::Direction(text.to_owned()))
    }
}

/// How a shape stands: its up and front directions, in the axes of its file (and of the working
/// frame, which are the same). Pictures are turned by it, and which half is the left one: files are read and written as they
/// are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Orientation {
    up: Vec3,
    front: Vec3,
}

impl Orientation {
    /// y is up and z comes toward the viewer: OBJ, glTF.
    pub const Y_UP: Self = Self { up: [0.0, 1.0, 0.0], front: [0.0, 0.0, 1.0] };
    /// z is up and −y comes toward the viewer: Blender, CAD, most scanners.
    pub const Z_UP: Self = Self { up: [0.0, 0.0, 1.0], front: [0.0, -1.0, 0.0] };

    /// `None` where the two are nearly parallel, or either has no direction. `up` is kept, `front` made
    /// perpendicular to it.
    pub fn new(up: [f64; 3], front: [f64; 3]) -> Option<Self> {
        let up = unit(up);
        let front = unit(front);
        let level = sub(front, scaled(up, dot(front, up)));
        let sound = up.iter().chain(&front).all(|c| c.is_finite()) && length(level) > 0.1 && length(up) > 0.5;
        sound.then(|| Self { up, front: unit(level) })
    }

    /// Where up is; a unit vector.
    pub fn up(&self) -> [f64; 3] {
        self.up
    }

    /// The side that faces a viewer who stands in front; a unit vector perpendicular to up.
    pub fn front(&self) -> [f64; 3] {
        self.front
    }

    /// To the right of that viewer; a unit vector.
    pub fn right(&self) -> [f64; 3] {
        cross(self.up, self.front)
    }

    /// The same shape after `turn`, the columns of a rotation matrix.
    #[must_use]
    pub fn turned(&self, turn: [[f64; 3]; 3]) -> Option<Self> {
        let of = |v: Vec3| std::array::from_fn(|i| (0..3).map(|j| turn[j][i] * v[j]).sum());
        Self::new(of(self.up), of(self.front))
    }

    /// The same with another axis up. Where the front would no longer be level, the former up is the front.
    #[must_use]
    pub fn with_up(&self, up: Axis) -> Self {
        let fronts = [self.front, self.up];
        fronts.into_iter().find_map(|front| Self::new(up.direction(), front)).unwrap_or(*self)
    }

    /// Turned about up by quarters, counted as seen from above, so that another side is the front.
    #[must_use]
    pub fn quarters(&self, quarters: i32) -> Self {
        let front = match quarters.rem_euclid(4) {
            0 => self.front,
            1 => self.right(),
            2 => scaled(self.front, -1.0),
            _ => scaled(self.right(), -1.0),
        };
        Self { front, ..*self }
    }

    /// The angle of the turn that leads from one to the other, in radians.
    pub fn angle_to(&self, other: &Self) -> f64 {
        let trace = dot(self.up, other.up) + dot(self.front, other.front) + dot(self.right(), other.right());
        (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
    }
}

impl Default for Orientation {
    fn default() -> Self {
        Self::Y_UP
    }
}

/// An axis by its name, any other direction by its components.
fn direction_text(direction: Vec3) -> String {
    match Axis::of(direction) {
        Some(axis) => axis.to_string(),
        None => direction.map(|c| format!("{c:.4}")).join(" "),
    }
}

fn direction(text: &str) -> Result<Vec3, MeshError> {
    if let Ok(axis) = text.trim().parse::<Axis>() {
        return Ok(axis.direction());
    }
    let wrong = || MeshError::Direction(text.to_owned());
    let parts: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let components: Vec3 = parts.map_err(|_| wrong())?.try_into().map_err(|_| wrong())?;
    let sound = components.iter().all(|c| c.is_finite()) && length(components) > 1e-6;
    if sound { Ok(components) } else { Err(wrong()) }
}

/// `up y, front z`, as the command line prints it.
impl fmt::Display for Orientation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "up {}, front {}", direction_text(self.up), direction_text(self.front))
    }
}

/// Reads what [`Display`](fmt::Display) writes.
impl FromStr for Orientation {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        let wrong = || MeshError::Direction(text.to_owned());
        let (up, front) = text.split_once(',').ok_or_else(wrong)?;
        let up = up.trim().strip_prefix("up").ok_or_else(wrong)?;
        let front = front.trim().strip_prefix("front").ok_or_else(wrong)?;
        Self::new(direction(up)?, direction(front)?).ok_or_else(wrong)
    }
}

impl TryFrom<String> for Orientation {
    type Error = MeshError;

    fn try_from(text: String) -> Result<Self, MeshError> {
        text.parse()
    }
}

impl From<Orientation> for String {
    fn from(orientation: Orientation) -> Self {
        orientation.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_read_as_they_are_written() {
        for axis in Axis::ALL {
            assert_eq!(axis.to_string().parse::<Axis>().unwrap(), axis);
            assert_eq!(Axis::of(axis.direction()), Some(axis));
        }
        assert_eq!("+Z".parse::<Axis>().unwrap().direction(), [0.0, 0.0, 1.0]);
        assert!(
            "w".parse::<Axis>().is_err() && "".parse::<Axis>().is_err() && "--x".parse::<Axis>().is_err()
        );
        for orientation in [
            Orientation::Y_UP,
            Orientation::Z_UP,
            Orientation::new([0.3, -0.8, 0.1], [1.0, 0.2, 0.0]).unwrap(),
        ] {
            let back: Orientation = orientation.to_string().parse().unwrap();
            assert!(back.angle_to(&orientation) < 1e-3, "{orientation} {back}");
        }
        for wrong in [
            "up y",
            "up 0 1 0 oops, front z",
            "up 0 1 0 0, front z",
            "up y, front y",
            "up 0 0 0, front z",
            "up nan 0 1, front x",
            "y, z",
        ] {
            assert!(wrong.parse::<Orientation>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn right_is_right_and_quarters_go_around() {
        assert_eq!(Orientation::Y_UP.right(), [1.0, 0.0, 0.0]);
        assert_eq!(Orientation::Z_UP.right(), [1.0, 0.0, 0.0]);
        let once = Orientation::Y_UP.quarters(1);
        assert_eq!((once.up(), once.front()), ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]));
        assert_eq!((0..4).fold(once, |o, _| o.quarters(1)), once);
        assert!((Orientation::Y_UP.angle_to(&once) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        // Another axis is up: the front stays where it can.
        let [x_up, z_up] = ["x", "z"].map(|up| Orientation::Y_UP.with_up(up.parse().unwrap()));
        assert_eq!((x_up.up(), x_up.front()), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert_eq!((z_up.up(), z_up.front()), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]));
        // A quarter about x takes y to z.
        let turned = Orientation::Y_UP.turned([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]).unwrap();
        assert_eq!(turned, Orientation::Z_UP);
    }
}
