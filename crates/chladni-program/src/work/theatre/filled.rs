//! How far a camera stays away from a shape, so that the shape fills the picture.

use chladni_mesh::Orientation;
use chladni_music::{Dancer, Framing};
use chladni_view::Camera;
use chladni_view::filling::{CROPPED_HEIGHTS, Filling, Headroom, NEAR_HEIGHTS, TOP, WHOLE_HEIGHTS};
use chladni_view::framing::extremes;

use super::{axes, component, ends};

/// The shares of the picture that the figure covers, seen as a whole and near.
const COVERS: [f32; 2] = [0.3, 0.43];
/// A figure that covers less than this as a whole is slim: it may be cut off below until it covers as much.
const SLIM_COVERS: f32 = 0.2;
/// How far from the middle the sides of a figure are when they have moved outward, in halves of the picture, whether
/// all of it is seen or it is cut off below: the rest is air.
const WHOLE_WIDTHS: f32 = 0.92;
/// How far the sides of a figure that is seen from near are beyond the edges at rest, in halves of the picture.
const NEAR_BEYOND: f32 = 0.5;
/// In pictures narrower than this aspect it is less, in proportion: faces would be cut in half.
const NEAR_ASPECT: f32 = 16.0 / 9.0;
/// The part of a figure that is cut off, as a share of its height.
const LOWER: f32 = 0.33;
/// How far that part may reach to the sides, in comparison with the rest: a figure that stands on its widest part, as
/// a bell does, is seen as a whole.
const LOWER_REACHES: f32 = 0.8;
/// The share of the largest displacement by which a figure rises in loud music.
const RISES: f32 = 0.9;
/// How far the lower end of a slim figure sinks, as a share of how far the upper one rises.
const SINKS: f32 = 0.3;
/// The same by which its sides move outward: the loudest dances of a gallery grow by about half of that displacement.
const SPREADS: f32 = 0.55;
/// How far from the middle of the shape to the part that moves most a camera looks that comes near it.
const PART: f32 = 0.4;

/// From how far the shape fills pictures of about one aspect.
pub(super) struct Filled {
    pub aspect: f32,
    /// The limit of displacement for which there is room, and by how much the shape may rise.
    pub limit: f32,
    rises: f32,
    /// The points that reach farthest.
    ends: Vec<[f32; 3]>,
    /// The middle of the shape, and where the whole of it is seen from.
    middle: [f32; 3],
    whole: Filling,
    /// Where it fills the picture as well without its lower part, if it is slim and stands on a narrow part.
    cropped: Option<Filling>,
    /// The same near the part that moves most.
    part: [f32; 3],
    near: Filling,
}

impl Filled {
    /// For points of the surface, which is `flat` if it is that of a sheet.
    pub fn new(
        (surface, flat): (&[[f32; 3]], bool),
        dancer: &Dancer,
        stands: Orientation,
        aspect: f32,
        limit: f32,
    ) -> Self {
        let (low, high) = surface.iter().fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        });
        let middle: [f32; 3] =
            std::array::from_fn(|i| if low[i] <= high[i] { 0.5 * (low[i] + high[i]) } else { 0.0 });
        let part = std::array::from_fn(|i| middle[i] + PART * (dancer.liveliest[i] - middle[i]));
        let largest = limit * dancer.box_diagonal;
        let rises = RISES * largest;
        let is_slim = stands_on_a_narrow_part(surface, stands);
        let moving = |most_heights| Headroom {
            rises,
            sinks: SINKS * rises,
            // A sheet moves along its normal.
            spreads: if flat { 0.0 } else { SPREADS * largest },
            most_heights,
            most_widths: WHOLE_WIDTHS,
        };
        // The lower end of a ring or a bell moves as far as the upper one.
        let sinks = if is_slim { SINKS * rises } else { rises };
        let whole = Headroom { sinks, ..moving(WHOLE_HEIGHTS) };
        let close = Headroom { spreads: 0.0, most_widths: near_widths(aspect), ..moving(NEAR_HEIGHTS) };
        let filling = |target, share, room| Filling::new(surface, stands, target, aspect, share, room);
        Self {
            aspect,
            limit,
            rises,
            ends: extremes(surface),
            middle,
            whole: filling(middle, COVERS[0], whole),
            cropped: is_slim.then(|| filling(middle, SLIM_COVERS, moving(CROPPED_HEIGHTS))),
            part,
            near: filling(part, COVERS[1], close),
        }
    }

    /// A camera that sees it so, before the viewer's own distance and shift.
    pub fn camera(&self, yaw_rad: f32, pitch_rad: f32, framing: &Framing, stands: Orientation) -> Camera {
        let mix = |from: f32, to: f32, share: f32| from + share * (to - from);
        let from = |filling: &Filling| filling.from(yaw_rad, pitch_rad).ln();
        let target =
            std::array::from_fn(|i| mix(self.middle[i], self.part[i], framing.toward_part.clamp(0.0, 1.0)));
        let whole = from(&self.whole);
        // A figure that is not slim is seen as a whole.
        let far =
            self.cropped.as_ref().map_or(whole, |cropped| mix(whole, from(cropped).min(whole), framing.crop));
        let distance = mix(far, from(&self.near).min(far), framing.closeness).exp();
        let mut camera = Camera { yaw_rad, pitch_rad, target, distance, stands, ..Camera::default() };
        camera.keep_below(self.ends.iter().copied(), self.rises, TOP);
        camera
    }
}

/// How far from the middle the sides of a figure that is seen from near are at rest, in halves of the picture.
fn near_widths(aspect: f32) -> f32 {
    1.0 + NEAR_BEYOND * (aspect / NEAR_ASPECT).min(1.0)
}

/// Whether the lower part of a figure reaches less far to the sides than the rest.
fn stands_on_a_narrow_part(surface: &[[f32; 3]], stands: Orientation) -> bool {
    let [right, up, front] = axes(stands);
    let [bottom, top] = ends(surface, up);
    let edge = bottom + LOWER * (top - bottom);
    let from_middle = |axis: [f32; 3]| {
        let [low, high] = ends(surface, axis);
        move |p: &[f32; 3]| component(p, axis) - 0.5 * (low + high)
    };
    let (across, ahead) = (from_middle(right), from_middle(front));
    let reach = |lower: bool| {
        let part = surface.iter().filter(|p| (component(p, up) < edge) == lower);
        part.map(|p| across(p).hypot(ahead(p))).fold(0.0, f32::max)
    };
    reach(true) < LOWER_REACHES * reach(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples;
    use chladni_mesh::surface::vec3::single;

    #[test]
    fn a_close_up_cuts_off_less_at_the_sides_of_a_narrow_picture() {
        let [narrow, square, wide, wider] = [9.0 / 16.0, 1.0, 16.0 / 9.0, 2.4].map(near_widths);
        assert!(1.0 < narrow && narrow < 1.2 && narrow < square && square < wide, "{narrow} {square} {wide}");
        assert_eq!((wide, wider), (1.5, 1.5));
    }

    #[test]
    fn a_human_may_be_cut_off_at_the_knees_and_a_bell_may_not() {
        for (name, may) in [("human", true), ("bell", false), ("cat", false), ("octopus", false)] {
            let mesh = samples::sample(name).unwrap();
            let points = single(&mesh.positions);
            assert_eq!(stands_on_a_narrow_part(&points, Orientation::Y_UP), may, "{name}");
        }
    }
}
