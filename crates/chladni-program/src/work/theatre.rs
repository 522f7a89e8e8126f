//! How a dance looks at one moment: camera, lights and cells, from the beat and from where the viewer
//! stands.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::{Orientation, symmetric_eigen};
use chladni_music::{
    Beat, Class, Dancer, Form, Framing, Instrument, Parameter, Parameters, Reaction, Switch, Viewpoint, react,
};
use chladni_view::filling::surface_points;
use chladni_view::framing::extremes;
use chladni_view::{Camera, Cell, Figure, Floor, ItemBuffers, Look, Marker, Rect, Topology, bends, layout};

use self::filled::Filled;
pub use self::looks::{OWN_COLORS, blur, cautions, first_looks, look_named, look_on_stage};
pub use self::wardrobe::Wardrobe;
use super::{Heard, OwnLook};

mod coarse_uvs;
mod filled;
mod looks;
mod wardrobe;

/// How much of its cell the shape may fill where it is moved as far as the limit allows.
const FILL: f32 = 0.96;
/// The share of the limit for which a cell of a gallery has room: the liveliest dances come to within an eighth of the
/// limit, and small figures are hard to compare.
const GALLERY_ROOM: f32 = 0.9;
/// The floor is this share of the farthest movement below the shape, which seldom goes through it then.
const FLOOR_BELOW: f32 = 0.4;
/// The gap between cells is the picture's shorter side divided by this.
const GAP: u32 = 100;

/// The initial viewpoint.
pub const FIRST_VIEW: Viewpoint = Viewpoint { yaw_rad: 0.0, pitch_rad: 0.14, distance: 1.0, shift: [0.0; 2] };

/// The most dots that stand for a shape: more would be a black area.
const DOTS: usize = 2500;
/// The radius of a dot, as a share of its cell's shorter side: 1.2 pixels of 720.
const DOT: f32 = 1.2 / 720.0;
/// The rim of a smaller dot would leave nothing black.
const LEAST_DOT_PX: f32 = 0.7;

/// Some of `positions` as black dots, which cover the same share of a cell of any size.
pub fn dots(positions: impl ExactSizeIterator<Item = [f32; 3]>, cell: Rect) -> Vec<Marker> {
    let wanted_px = DOT * cell.width.min(cell.height) as f32;
    let radius_px = wanted_px.max(LEAST_DOT_PX);
    // Fewer, where they cannot be as small as wanted.
    let all = positions.len().min(DOTS) as f32;
    let most = (all * (wanted_px / radius_px).powi(2)).round().max(1.0) as u64;
    let len = positions.len() as u64;
    let dot = |(_, position)| Marker { position, radius_px, color: [0, 0, 0, 255] };
    // Every (len / most)th, which need not be a whole number.
    (0_u64..).zip(positions).filter(|(v, _)| v * most % len < most).map(dot).collect()
}

/// The effect of the beat on the picture; it fades together with a jump in the song.
pub fn reaction(instrument: &Instrument, beat: Beat, fading: Option<(Beat, f32)>) -> Reaction {
    let of = |beat| react(beat, |n| instrument.seed_of_beat(n), instrument.parameters());
    let to = of(beat);
    let Some((before, done)) = fading else { return to };
    let from = of(before);
    let mix = |from: f32, to: f32| from + done * (to - from);
    Reaction {
        turn_rad: mix(from.turn_rad, to.turn_rad),
        light_turn_rad: mix(from.light_turn_rad, to.light_turn_rad),
        light_gain: mix(from.light_gain, to.light_gain),
    }
}

/// Whether the camera chooses how the dance is seen: where it may, and one dance is on stage.
pub fn chooses_shots(instrument: &Instrument, beat: Beat) -> bool {
    instrument.parameters().is_on(Switch::Camera) && instrument.scene(beat.count).is_some()
}

impl Heard<'_> {
    /// The effect of the beat on the picture.
    pub fn reaction(&self, instrument: &Instrument) -> Reaction {
        reaction(instrument, self.beat, self.fading)
    }
}

/// A number in [0, 1] for each vertex of a body, from one end of the shape to the other: its lowest harmonic
/// that is the same left and right, where it has one, else its lowest.
pub fn along(body: &Body, dancer: &Dancer) -> Vec<f32> {
    let lowest = dancer.classes.iter().skip(1).position(|class| *class == Class::Symmetric);
    let k = 1 + lowest.unwrap_or(0);
    if k >= body.basis.harmonics() {
        return vec![0.0; body.positions.len()];
    }
    let harmonic = body.basis.harmonic(k);
    let (low, high) = harmonic
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(*h), high.max(*h)));
    harmonic.iter().map(|h| ((h - low) / (high - low).max(1e-12)) as f32).collect()
}

/// Whether all of `positions` lie in a plane, however it is tilted, or nearly.
pub fn is_flat(positions: &[[f32; 3]]) -> bool {
    let [(_, thickness), (_, side), _] = by_extent(positions);
    thickness < SHEET * side
}

/// Sets the stage for one body, frame after frame.
pub struct Staging {
    dancer: Arc<Dancer>,
    rest: Vec<[f32; 3]>,
    /// [`along`] the body, and how it is [bent](bends).
    along: Vec<f32>,
    bends: Vec<f32>,
    /// Where up and front are.
    stands: Orientation,
    /// From where to where the body at rest reaches along the [axes].
    reaches: [[f32; 2]; 3],
    /// Whether the body is a sheet.
    flat: bool,
    /// Of one shape, and of a gallery: two windows may show both in every frame, and the points take long to find.
    rooms: [Room; 2],
    /// Points of the surface, and from how far they fill a picture.
    surface: Vec<[f32; 3]>,
    filled: Option<Filled>,
    own: Option<OwnLook>,
}

/// The room for a displacement: the points that have to be seen.
#[derive(Default)]
struct Room {
    limit: f32,
    /// A sheet that moves along its normal needs none to its sides.
    along_normal: bool,
    points: Vec<[f32; 3]>,
}

/// A sheet is thinner than this share of its shorter side.
const SHEET: f32 = 0.02;
/// It is seen from at least so far above.
const SHEET_PITCH_RAD: f32 = 0.5;
/// Points that stand for the surface.
const SURFACE_POINTS: usize = 5000;
/// Distances are measured for aspects so far apart, and serve those between: how a window came to its size plays no part.
const ASPECT_STEP: f32 = 0.02;
/// The same for limits of displacement, upward: who drags that knob does not wait for them in every frame.
const LIMIT_STEP: f32 = 0.08;

/// The least gain that what sand lies on has room for: with none, room would be made for no movement at all.
const LEAST_GAIN: f32 = 0.05;

/// All that a picture shows beside the shapes themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Staged {
    area: Rect,
    /// The viewer's camera.
    pub camera: Camera,
    /// The look of shapes and light at this moment.
    pub look: Look,
    /// Where each item stands.
    pub viewports: Vec<Rect>,
    /// How many stand beside each other.
    pub columns: usize,
}

impl Staging {
    /// For a body at rest, its triangles, the numbers [`along`] it, and how it stands.
    pub fn new(
        dancer: Arc<Dancer>,
        rest: Vec<[f32; 3]>,
        triangles: &[[u32; 3]],
        along: Vec<f32>,
        stands: Orientation,
    ) -> Self {
        // Corners that no even spread reaches count, too.
        let mut surface = surface_points(&rest, triangles, SURFACE_POINTS);
        let corners = triangles.iter().flatten().filter_map(|v| rest.get(*v as usize)).copied();
        surface.extend(extremes(&corners.collect::<Vec<_>>()));
        let bends = bends(&rest, triangles);
        let flat = is_flat(&rest);
        let reaches = axes(stands).map(|axis| ends(&rest, axis));
        Self {
            dancer,
            rest,
            along,
            bends,
            stands,
            reaches,
            flat,
            rooms: Default::default(),
            surface,
            filled: None,
            own: None,
        }
    }

    /// The body stands otherwise from now on; `dancer` is of the same body, as it stands then.
    pub fn stand(&mut self, dancer: Arc<Dancer>, stands: Orientation) {
        self.reaches = axes(stands).map(|axis| ends(&self.rest, axis));
        (self.dancer, self.stands, self.filled) = (dancer, stands, None);
    }

    /// How the body stands.
    pub fn stands(&self) -> Orientation {
        self.stands
    }

    /// Whether the body is a flat sheet, in which forms that move it along its own coordinates show nothing.
    pub fn is_flat(&self) -> bool {
        self.flat
    }

    /// The body at rest.
    pub fn rest(&self) -> &[[f32; 3]] {
        &self.rest
    }

    /// The cells of `items` items in a picture of `area`.
    pub fn cells(area: Rect, items: usize) -> (Vec<Rect>, usize) {
        let (rows, columns) = layout::rows_and_columns(area.width, area.height, items, 1.0);
        let gap = area.width.min(area.height).div_ceil(GAP).min(area.width / 8);
        (layout::grid(area, rows, columns, gap, items), columns)
    }

    /// The picture of `items` items, seen from the viewpoint: as a whole, or as `framing` says.
    pub fn set(
        &mut self,
        area: Rect,
        items: usize,
        (viewpoint, framing): (&Viewpoint, Option<&Framing>),
        look: &Look,
        reaction: Reaction,
        instrument: &Instrument,
    ) -> Staged {
        let limit = instrument.parameters().get(Parameter::Limit);
        let is_gallery = items > 1 && framing.is_none();
        self.make_room(is_gallery, instrument.parameters());
        let (viewports, columns) = Self::cells(area, items);
        let aspect = layout::narrowest(&viewports);
        let camera = match framing {
            Some(framing) => self.chosen(aspect, viewpoint, framing, reaction),
            None => self.usual(is_gallery, aspect, viewpoint, instrument.parameters(), reaction),
        };
        let mut look = look.scaled(limit * self.dancer.box_diagonal);
        look.lights = look.lights.turned(reaction.light_turn_rad);
        look.lights.exposure = look.lights.exposure.map(|light| light * reaction.light_gain);
        // Exchanged sides move the other half: as if it were seen from behind.
        let exchanged = instrument.parameters().is_on(Switch::FlipSides);
        look = look.seen_from(camera.yaw_rad + if exchanged { std::f32::consts::PI } else { 0.0 });
        // They would grow from the middle of all cells, not of each.
        if viewports.len() > 1 {
            look.finish.trail_growth = 0.0;
        }
        // Many shapes do not stand on one floor.
        look.background.floor = look.background.floor.filter(|_| items == 1).and_then(|floor| {
            let (at, radius) = self.ground(FLOOR_BELOW * limit * self.dancer.box_diagonal)?;
            Some(Floor { at, radius, ..floor })
        });
        Staged { area, camera, look, viewports, columns }
    }

    /// Finds the points that have to be seen with these knobs, where others were wanted before.
    fn make_room(&mut self, is_gallery: bool, knobs: &Parameters) {
        // What sand lies on hardly moves.
        let gain = knobs.get(Parameter::Gain).clamp(LEAST_GAIN, 1.0);
        let share = if knobs.is_on(Switch::Sand) { stepped_up(gain).min(1.0) } else { 1.0 };
        let limit = knobs.get(Parameter::Limit) * if is_gallery { GALLERY_ROOM } else { share };
        let along_normal = self.flat && knobs.form == Form::Modal;
        let room = &mut self.rooms[usize::from(is_gallery)];
        if (room.limit, room.along_normal) != (limit, along_normal) {
            let points = if along_normal {
                moved_both_ways(&self.rest, limit * self.dancer.box_diagonal)
            } else {
                self.dancer.room(&self.rest, limit)
            };
            *room = Room { limit, along_normal, points: extremes(&points) };
        }
    }

    /// All of the shape, however the beat turns it.
    fn usual(
        &self,
        is_gallery: bool,
        aspect: f32,
        viewpoint: &Viewpoint,
        knobs: &Parameters,
        reaction: Reaction,
    ) -> Camera {
        let Viewpoint { yaw_rad, pitch_rad, .. } = *viewpoint;
        let mut camera = Camera { yaw_rad, pitch_rad, stands: self.stands, ..Camera::default() };
        let swing_rad = if knobs.is_on(Switch::BeatTurns) { knobs.get(Parameter::TurnRad) } else { 0.0 };
        camera.fit_swing(&self.rooms[usize::from(is_gallery)].points, aspect, FILL, swing_rad);
        camera.distance *= viewpoint.distance;
        // The shape turns about its own axis, wherever the picture is shifted to.
        camera.yaw_rad = viewpoint.yaw_rad - reaction.turn_rad;
        camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
        camera
    }

    /// A shot that fills the picture, from outside the shape.
    fn chosen(
        &mut self,
        aspect: f32,
        viewpoint: &Viewpoint,
        framing: &Framing,
        reaction: Reaction,
    ) -> Camera {
        let [Room { limit, points, .. }, _] = &self.rooms;
        let limit = stepped_up(*limit);
        let aspect = ((aspect.ln() / ASPECT_STEP).round() * ASPECT_STEP).exp();
        let known = self.filled.take().filter(|filled| filled.limit == limit && filled.aspect == aspect);
        let filled = known.unwrap_or_else(|| {
            Filled::new((&self.surface, self.flat), &self.dancer, self.stands, aspect, limit)
        });
        // Seen edge on a sheet is a line.
        let lowest = if self.flat { SHEET_PITCH_RAD } else { -1.2 };
        let pitch_rad = (viewpoint.pitch_rad + framing.pitch_rad).clamp(lowest, 1.4);
        let yaw_rad = viewpoint.yaw_rad + framing.yaw_rad - reaction.turn_rad;
        let mut camera = filled.camera(yaw_rad, pitch_rad, framing, self.stands);
        self.filled = Some(filled);
        camera.distance *= viewpoint.distance;
        camera.keep_outside(points.iter().copied());
        camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
        camera
    }

    /// The point so far below the middle of the body at rest, and half its width there.
    fn ground(&self, below: f32) -> Option<([f32; 3], f32)> {
        let axes = axes(self.stands);
        let [right, up, front] = self.reaches;
        let at = [0.5 * (right[0] + right[1]), up[0] - below, 0.5 * (front[0] + front[1])];
        let radius = 0.5 * (right[1] - right[0]).max(front[1] - front[0]);
        let point = std::array::from_fn(|i| (0..3).map(|a| at[a] * axes[a][i]).sum());
        (radius > 0.0 && radius.is_finite()).then_some((point, radius))
    }
}

/// Right, up and front in this orientation.
fn axes(stands: Orientation) -> [[f32; 3]; 3] {
    [stands.right(), stands.up(), stands.front()].map(|axis| axis.map(|c| c as f32))
}

/// How far along an axis a point lies.
fn component(p: &[f32; 3], axis: [f32; 3]) -> f32 {
    (0..3).map(|i| p[i] * axis[i]).sum()
}

/// The principal axes of points and how far they extend along each, the shortest first.
fn by_extent(points: &[[f32; 3]]) -> [([f32; 3], f32); 3] {
    let mut axes = principal_axes(points).map(|axis| {
        let [low, high] = ends(points, axis);
        (axis, high - low)
    });
    axes.sort_by(|a, b| a.1.total_cmp(&b.1));
    axes
}

/// The principal axes of points, of which each has the same weight.
fn principal_axes(points: &[[f32; 3]]) -> [[f32; 3]; 3] {
    let count = points.len().max(1) as f64;
    let mean: [f64; 3] = std::array::from_fn(|i| points.iter().map(|p| f64::from(p[i])).sum::<f64>() / count);
    let mut covariance = [[0.0; 3]; 3];
    for p in points {
        let d: [f64; 3] = std::array::from_fn(|i| f64::from(p[i]) - mean[i]);
        for i in 0..3 {
            (0..3).for_each(|j| covariance[i][j] += d[i] * d[j]);
        }
    }
    symmetric_eigen(covariance).1.map(|axis| axis.map(|c| c as f32))
}

/// A limit, or the next one for which room is made.
fn stepped_up(limit: f32) -> f32 {
    ((limit.ln() / LIMIT_STEP).ceil() * LIMIT_STEP).exp()
}

/// The points of a sheet that has moved so far along its normal, to either side.
fn moved_both_ways(sheet: &[[f32; 3]], far: f32) -> Vec<[f32; 3]> {
    let [(normal, _), ..] = by_extent(sheet);
    let moved = |by: f32| sheet.iter().map(move |p| std::array::from_fn(|i| p[i] + by * normal[i]));
    moved(far).chain(moved(-far)).collect()
}

/// From where to where points reach along an axis.
fn ends(points: &[[f32; 3]], axis: [f32; 3]) -> [f32; 2] {
    let all = points.iter().map(|p| component(p, axis)).filter(|c| c.is_finite());
    all.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)])
}

impl Staged {
    /// Width and height, in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.area.width, self.area.height]
    }

    /// Item `item` as it looks. Where there are twice as many items as cells, the second half are their
    /// [lags](super::Lag).
    pub fn figure<'a>(
        &self,
        topology: &'a Topology,
        buffers: &'a ItemBuffers,
        item: usize,
        wardrobe: &'a Wardrobe,
    ) -> Figure<'a> {
        let (material, paint) = (self.look.material, wardrobe.paint(&self.look));
        let lag = Some(self.viewports.len() + item).filter(|lag| *lag < buffers.items());
        Figure { material, paint, lag, ..Figure::new(topology, buffers, item) }
    }

    /// The cells that a renderer draws, for one figure each.
    pub fn cells<'a>(&self, figures: &'a [Figure<'a>]) -> Vec<Cell<'a>> {
        let placed = self.viewports.iter().copied().zip(figures);
        let Look { background, lights, .. } = self.look;
        Cell::gallery(self.area, background, self.camera, lights, placed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::surface::vec3::single;
    use chladni_music::{Action, GalleryShape, Moment, SAND_MODE};

    /// Of a ball, which stands upright.
    fn staging() -> Staging {
        use chladni_harmonics::BasisSettings;
        let mesh = chladni_mesh::samples::icosphere(2);
        let body = Body::build(&mesh, &BasisSettings::new(8), &chladni_task::Task::new()).unwrap();
        let stands = Orientation::Y_UP;
        let dancer = Arc::new(Dancer::new(&body, &[Class::Symmetric; 8], &stands).unwrap());
        let rest = single(&body.positions);
        let along = along(&body, &dancer);
        Staging::new(dancer, rest, &body.triangles, along, stands)
    }

    #[test]
    fn the_floor_lies_below_the_body_which_is_measured_once() {
        let mut staging = staging();
        let before = staging.ground(0.1);
        let lowest = staging.rest.iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
        assert!(before.is_some_and(|(at, _)| (at[1] - (lowest - 0.1)).abs() < 1e-6));
        staging.rest.clear();
        assert_eq!(staging.ground(0.1), before);
    }

    #[test]
    fn how_a_picture_came_to_its_size_plays_no_part() {
        let mut staging = staging();
        staging.rooms[0].limit = 1.0;
        let still = Reaction { turn_rad: 0.0, light_turn_rad: 0.0, light_gain: 1.0 };
        let (viewpoint, framing) = (Viewpoint::default(), Framing::default());
        let mut seen = |aspect: f32| staging.chosen(aspect, &viewpoint, &framing, still);
        let (at_once, near) = (seen(0.6), seen(0.61));
        for aspect in [0.55, 0.585, 0.595, 0.6] {
            let _ = seen(aspect);
        }
        assert_eq!(seen(0.6), at_once);
        assert!((near.distance / at_once.distance - 1.0).abs() < 2.0 * ASPECT_STEP);
    }

    #[test]
    fn the_sides_of_a_moving_figure_stay_in_a_narrow_picture() {
        let mut staging = staging();
        let limit = Parameter::Limit.initial();
        staging.rooms[0].limit = limit;
        let still = Reaction { turn_rad: 0.0, light_turn_rad: 0.0, light_gain: 1.0 };
        let picture = Rect::of_size(900, 1600);
        let camera = staging.chosen(picture.aspect(), &Viewpoint::default(), &Framing::default(), still);
        let outward = 0.5 * limit * staging.dancer.box_diagonal;
        let side = |p: &[f32; 3]| {
            let moved = [p[0] + outward * p[0].signum(), p[1], p[2]];
            let ([x, _], _) = camera.project(moved, picture).unwrap();
            (x / 450.0 - 1.0).abs()
        };
        let most = staging.rest.iter().map(side).fold(0.0, f32::max);
        assert!((0.8..0.95).contains(&most), "{most}");
    }

    #[test]
    fn a_sheet_keeps_no_room_at_its_sides() {
        let still = Reaction { turn_rad: 0.0, light_turn_rad: 0.0, light_gain: 1.0 };
        let distance = |flat: bool| {
            // A ball looks the same from above, where sheets are seen from.
            let mut staging = Staging { flat, ..staging() };
            staging.rooms[0].limit = Parameter::Limit.initial();
            staging.chosen(0.4, &Viewpoint::default(), &Framing::default(), still).distance
        };
        let share = distance(true) / distance(false);
        assert!((0.6..0.92).contains(&share), "{share}");
    }

    /// The picture of items from the viewpoint that is there first.
    fn staged(staging: &mut Staging, items: usize) -> Staged {
        staged_after(staging, items, &[])
    }

    /// The same after some actions.
    fn staged_after(staging: &mut Staging, items: usize, actions: &[Action]) -> Staged {
        let shape = GalleryShape { eigenvalues: (0..8).map(f64::from).collect(), bands: 8 };
        let mut instrument = Instrument::new(1, 9, shape).unwrap();
        for action in actions {
            instrument.apply(Moment::default(), action.clone()).unwrap();
        }
        let still = Reaction { turn_rad: 0.0, light_turn_rad: 0.0, light_gain: 1.0 };
        let from = (&Viewpoint::default(), None);
        staging.set(Rect::of_size(300, 300), items, from, &Look::PLAIN, still, &instrument)
    }

    #[test]
    fn figures_of_a_gallery_fill_a_little_more_of_their_cells_than_one_alone() {
        let mut staging = staging();
        let mut distance = |items| staged(&mut staging, items).camera.distance;
        let share = distance(9) / distance(1);
        assert!((0.93..0.99).contains(&share), "{share}");
    }

    #[test]
    fn what_sand_lies_on_and_sheets_that_move_along_their_normal_fill_more_of_the_picture() {
        let distance = |flat: bool, actions: &[Action]| {
            staged_after(&mut Staging { flat, ..staging() }, 1, actions).camera.distance
        };
        let modal = [Action::SetForm { form: Form::Modal }];
        assert!(distance(false, &SAND_MODE) < 0.9 * distance(false, &modal));
        // The ball has a normal in one direction only, if it is called flat.
        assert!(distance(true, &modal) < 0.95 * distance(false, &modal));
        assert!(distance(true, &SAND_MODE) <= distance(false, &SAND_MODE));
    }

    #[test]
    fn figures_of_a_gallery_stay_in_their_cells() {
        let mut staging = staging();
        let Staged { camera, viewports, .. } = staged(&mut staging, 9);
        let cell = Rect::of_size(viewports[0].width, viewports[0].height);
        // As far as the liveliest dances of the samples go.
        for p in staging.dancer.room(&staging.rest, 0.88 * Parameter::Limit.initial()) {
            let ([x, y], _) = camera.project(p, cell).unwrap();
            let is_inside = |at: f32, length: u32| (0.0..=length as f32).contains(&at);
            assert!(is_inside(x, cell.width) && is_inside(y, cell.height), "{x} {y}");
        }
    }

    #[test]
    fn a_stage_and_a_gallery_in_turn_are_each_measured_once() {
        let mut staging = staging();
        let before = [1, 9].map(|items| staged(&mut staging, items));
        staging.rest.clear();
        assert_eq!([1, 9].map(|items| staged(&mut staging, items)), before);
    }

    #[test]
    fn plates_are_flat_however_tilted_and_bodies_are_not() {
        let tilted = |name: &str, degrees: f32| {
            let mesh = chladni_mesh::samples::sample(name).unwrap();
            let (s, c) = degrees.to_radians().sin_cos();
            let turn = |[x, y, z]: [f32; 3]| [x, c * y - s * z, s * y + c * z];
            is_flat(&single(&mesh.positions).into_iter().map(turn).collect::<Vec<_>>())
        };
        for degrees in [0.0, 1.3, 5.0, 40.0, 90.0] {
            assert!(tilted("plate", degrees) && tilted("disc", degrees), "{degrees}°");
        }
        for body in ["octopus", "ring", "drum", "bell", "cat", "head"] {
            assert!(!tilted(body, 0.0) && !tilted(body, 30.0), "{body}");
        }
        // Neither nothing nor a line.
        assert!(!is_flat(&[]) && !is_flat(&[[0.0; 3], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0]]));
    }

    #[test]
    fn dots_cover_the_same_share_of_a_cell_of_any_size() {
        let share = |vertices: u16, side: u32| {
            let positions = (0..vertices).map(|i| [f32::from(i), 0.0, 0.0]);
            let dots = dots(positions, Rect::of_size(2 * side, side));
            assert!(dots.iter().all(|dot| dot.radius_px >= LEAST_DOT_PX));
            dots.iter().map(|dot| dot.radius_px.powi(2)).sum::<f32>() / (side as f32).powi(2)
        };
        // Few vertices, hardly more than there are dots, and many.
        for vertices in [400, 3000, 10_000] {
            for side in [60, 240, 480, 2160] {
                let ratio = share(vertices, side) / share(vertices, 720);
                assert!((ratio - 1.0).abs() < 0.03, "{vertices} at {side}: {ratio}");
            }
        }
        assert_eq!(dots([[0.0; 3]].into_iter(), Rect::default()).len(), 1);
    }
}
