//! How a dance looks at one moment: camera, lights and cells, from what the beat does and where the viewer
//! stands.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_music::{
    Action, Beat, Class, Dancer, Framing, Instrument, Looks, Parameter, Parameters, Reaction, Show, Switch,
    Viewpoint, react,
};
use chladni_view::filling::{Filling, Headroom, NEAR_HEIGHTS, TOP, WHOLE_HEIGHTS, surface_points};
use chladni_view::framing::extremes;
use chladni_view::{
    Answer, Background, Camera, Cell, Device, Figure, Floor, ItemBuffers, Lights, Look, Marker, Material,
    Paint, Palette, Rect, RestShape, Topology, ViewError, bends, layout,
};

use super::Heard;

/// How much of its cell the shape may fill where it is moved as far as the limit allows.
const FILL: f32 = 0.96;
/// The floor is this share of the farthest movement below the shape, which seldom goes through it then.
const FLOOR_BELOW: f32 = 0.4;
/// The gap between cells is the picture's shorter side divided by this.
const GAP: u32 = 100;

/// The initial viewpoint.
pub const FIRST_VIEW: Viewpoint = Viewpoint { yaw_rad: 0.0, pitch_rad: 0.14, distance: 1.0, shift: [0.0; 2] };

/// The default look.
pub fn first_looks() -> Looks {
    Looks { look: "aurora".into(), ..Looks::default() }
}

/// The look that what is on stage wears in place of the show's own, as far as this version knows it.
pub fn look_on_stage(instrument: &Instrument) -> Option<Look> {
    instrument.look().and_then(Look::named)
}

/// What to say to whoever opens a show: that it is old, or names looks, or parts of them, which this version does not know.
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

/// The most dots that stand for a shape: more would be a black area.
const DOTS: usize = 2500;

/// Some of `positions` as black dots.
pub fn dots(positions: impl ExactSizeIterator<Item = [f32; 3]>) -> Vec<Marker> {
    let step = positions.len().div_ceil(DOTS).max(1);
    let dot = |position| Marker { position, radius_px: 1.2, color: [0, 0, 0, 255] };
    positions.step_by(step).map(dot).collect()
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
    found(&looks.palette, palette.is_some());
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
    (look, missing)
}

/// The blur of a finish that is chosen in percent.
pub fn blur(percent: u8) -> f32 {
    f32::from(percent.min(100)) / 100.0
}

/// What the beat does to the picture; while a jump in the song fades, so does its effect.
pub fn reaction(instrument: &Instrument, beat: Beat, fading: Option<(Beat, f32)>) -> Reaction {
    let of = |beat| react(beat, instrument.seed(), instrument.parameters());
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
    /// What the beat does to the picture.
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

/// Whether all of `positions` lie in a plane of two axes, or nearly.
pub fn is_flat(positions: &[[f32; 3]]) -> bool {
    let mut sides: [f32; 3] = std::array::from_fn(|axis| {
        let all = positions.iter().map(|p| p[axis]);
        all.clone().fold(f32::NEG_INFINITY, f32::max) - all.fold(f32::INFINITY, f32::min)
    });
    sides.sort_by(f32::total_cmp);
    sides[0] < SHEET * sides[1]
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
    /// Whether the body is a sheet.
    flat: bool,
    /// The limit of displacement, and what has to fit into a cell for it.
    room: (f32, Vec<[f32; 3]>),
    /// Points of the surface, and from how far they fill a picture.
    surface: Vec<[f32; 3]>,
    filled: Option<Filled>,
}

/// From how far the shape fills pictures of about one aspect.
struct Filled {
    aspect: f32,
    /// The limit of displacement for which there is room, and by how much the shape may rise.
    limit: f32,
    rises: f32,
    /// The points that reach farthest.
    ends: Vec<[f32; 3]>,
    /// The middle of the shape, and where the whole of it is seen from.
    middle: [f32; 3],
    whole: Filling,
    /// The same near the part that moves most.
    part: [f32; 3],
    near: Filling,
}

/// A sheet is thinner than this share of its shorter side.
const SHEET: f32 = 0.02;
/// It is seen from at least so far above.
const SHEET_PITCH_RAD: f32 = 0.5;
/// The shares of the picture that the figure covers, seen as a whole and near.
const COVERS: [f32; 2] = [0.27, 0.4];
/// The share of the largest displacement by which a figure rises in loud music.
const RISES: f32 = 0.75;
/// How far from the middle of the shape to the part that moves most a camera looks that comes near it.
const PART: f32 = 0.4;
/// Points that stand for the surface.
const SURFACE_POINTS: usize = 5000;
/// Distances are measured for aspects so far apart, and serve those between: how a window came to its size plays no part.
const ASPECT_STEP: f32 = 0.02;

impl Filled {
    fn new(surface: &[[f32; 3]], dancer: &Dancer, stands: Orientation, aspect: f32, limit: f32) -> Self {
        let (low, high) = surface.iter().fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        });
        let middle: [f32; 3] =
            std::array::from_fn(|i| if low[i] <= high[i] { 0.5 * (low[i] + high[i]) } else { 0.0 });
        let part = std::array::from_fn(|i| middle[i] + PART * (dancer.liveliest[i] - middle[i]));
        let rises = RISES * limit * dancer.box_diagonal;
        let [whole, near] = [(middle, WHOLE_HEIGHTS, COVERS[0]), (part, NEAR_HEIGHTS, COVERS[1])].map(
            |(target, most_heights, share)| {
                let room = Headroom { rises, most_heights };
                Filling::new(surface, stands, target, aspect, share, room)
            },
        );
        Self { aspect, limit, rises, ends: extremes(surface), middle, whole, part, near }
    }

    /// A camera that sees it so, before the viewer's own distance and shift.
    fn camera(&self, yaw_rad: f32, pitch_rad: f32, framing: &Framing, stands: Orientation) -> Camera {
        let mix = |from: f32, to: f32, share: f32| from + share * (to - from);
        let (whole, near) = (self.whole.from(yaw_rad, pitch_rad), self.near.from(yaw_rad, pitch_rad));
        let target =
            std::array::from_fn(|i| mix(self.middle[i], self.part[i], framing.toward_part.clamp(0.0, 1.0)));
        let distance = mix(whole.ln(), near.ln(), framing.closeness).exp();
        let mut camera = Camera { yaw_rad, pitch_rad, target, distance, stands, ..Camera::default() };
        camera.keep_below(self.ends.iter().copied(), self.rises, TOP);
        camera
    }
}

/// All that a picture shows beside the shapes themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Staged {
    area: Rect,
    /// Who looks.
    pub camera: Camera,
    /// What shapes and light are like, at this moment.
    pub look: Look,
    /// Where each item stands.
    pub viewports: Vec<Rect>,
    /// How many stand beside each other.
    pub columns: usize,
}

impl Staging {
    /// For a body at rest, its triangles, what is [`along`] it, and how it stands.
    pub fn new(
        dancer: Arc<Dancer>,
        rest: Vec<[f32; 3]>,
        triangles: &[[u32; 3]],
        along: Vec<f32>,
        stands: Orientation,
    ) -> Self {
        let surface = surface_points(&rest, triangles, SURFACE_POINTS);
        let bends = bends(&rest, triangles);
        let flat = is_flat(&rest);
        Self { dancer, rest, along, bends, stands, flat, room: (0.0, Vec::new()), surface, filled: None }
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

    /// The body at rest, for palettes.
    pub fn rest_on(&self, device: impl Into<Device>) -> Result<RestShape, ViewError> {
        RestShape::new(device, &self.rest, &self.along, &self.bends)
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
        if self.room.0 != limit {
            self.room = (limit, extremes(&self.dancer.room(&self.rest, limit)));
        }
        let (viewports, columns) = Self::cells(area, items);
        let aspect = viewports.iter().map(Rect::aspect).fold(f32::INFINITY, f32::min);
        let camera = match framing {
            Some(framing) => self.chosen(aspect, viewpoint, framing, reaction),
            None => self.usual(aspect, viewpoint, instrument.parameters(), reaction),
        };
        let mut look = look.scaled(limit * self.dancer.box_diagonal);
        look.lights = look.lights.turned(reaction.light_turn_rad);
        look.lights.exposure = look.lights.exposure.map(|light| light * reaction.light_gain);
        // Exchanged sides move the other half: as if it were seen from behind.
        let exchanged = instrument.parameters().is_on(Switch::FlipSides);
        look = look.seen_from(camera.yaw_rad + if exchanged { std::f32::consts::PI } else { 0.0 });
        // Many shapes do not stand on one floor.
        look.background.floor = look.background.floor.filter(|_| items == 1).and_then(|floor| {
            let (at, radius) = self.ground(FLOOR_BELOW * limit * self.dancer.box_diagonal)?;
            Some(Floor { at, radius, ..floor })
        });
        Staged { area, camera, look, viewports, columns }
    }

    /// All of the shape, however the beat turns it.
    fn usual(&self, aspect: f32, viewpoint: &Viewpoint, knobs: &Parameters, reaction: Reaction) -> Camera {
        let Viewpoint { yaw_rad, pitch_rad, .. } = *viewpoint;
        let mut camera = Camera { yaw_rad, pitch_rad, stands: self.stands, ..Camera::default() };
        let swing_rad = if knobs.is_on(Switch::BeatTurns) { knobs.get(Parameter::TurnRad) } else { 0.0 };
        camera.fit_swing(&self.room.1, aspect, FILL, swing_rad);
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
        let limit = self.room.0;
        let aspect = ((aspect.ln() / ASPECT_STEP).round() * ASPECT_STEP).exp();
        let known = self.filled.take().filter(|filled| filled.limit == limit && filled.aspect == aspect);
        let filled =
            known.unwrap_or_else(|| Filled::new(&self.surface, &self.dancer, self.stands, aspect, limit));
        // Seen edge on a sheet is a line.
        let lowest = if self.flat { SHEET_PITCH_RAD } else { -1.2 };
        let pitch_rad = (viewpoint.pitch_rad + framing.pitch_rad).clamp(lowest, 1.4);
        let yaw_rad = viewpoint.yaw_rad + framing.yaw_rad - reaction.turn_rad;
        let mut camera = filled.camera(yaw_rad, pitch_rad, framing, self.stands);
        self.filled = Some(filled);
        camera.distance *= viewpoint.distance;
        camera.keep_outside(self.room.1.iter().copied());
        camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
        camera
    }

    /// The point so far below the middle of the body at rest, and half its width there.
    fn ground(&self, below: f32) -> Option<([f32; 3], f32)> {
        let axes =
            [self.stands.right(), self.stands.up(), self.stands.front()].map(|axis| axis.map(|c| c as f32));
        let along = |p: &[f32; 3], axis: &[f32; 3]| (0..3).map(|i| p[i] * axis[i]).sum::<f32>();
        let ends = axes.map(|axis| {
            let all = self.rest.iter().map(|p| along(p, &axis)).filter(|c| c.is_finite());
            all.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
        });
        let [right, up, front] = ends;
        let middle = |(low, high): (f32, f32)| 0.5 * (low + high);
        let at = [middle(right), up.0 - below, middle(front)];
        let radius = 0.5 * (right.1 - right.0).max(front.1 - front.0);
        let point = std::array::from_fn(|i| (0..3).map(|a| at[a] * axes[a][i]).sum());
        (radius > 0.0 && radius.is_finite()).then_some((point, radius))
    }
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
        rest: &'a RestShape,
    ) -> Figure<'a> {
        let Look { material, answer, .. } = self.look;
        let paint = answer.map_or(Paint::Material, |answer| Paint::Answer(rest, answer));
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
    use chladni_view::Finish;

    use super::*;

    #[test]
    fn how_a_picture_came_to_its_size_plays_no_part() {
        use chladni_harmonics::{BasisSettings, Body};
        use chladni_music::Class;
        let mesh = chladni_mesh::samples::icosphere(2);
        let body = Body::build(&mesh, &BasisSettings::new(8), &chladni_task::Task::new()).unwrap();
        let stands = Orientation::Y_UP;
        let dancer = Arc::new(Dancer::new(&body, &[Class::Symmetric; 8], &stands).unwrap());
        let rest: Vec<[f32; 3]> = body.positions.iter().map(|p| p.map(|c| c as f32)).collect();
        let along = along(&body, &dancer);
        let mut staging = Staging::new(dancer, rest, &body.triangles, along, stands);
        staging.room.0 = 1.0;
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
    fn plates_are_flat_and_bodies_are_not() {
        let flat = |name: &str| {
            let mesh = chladni_mesh::samples::sample(name).unwrap();
            is_flat(&mesh.positions.iter().map(|p| p.map(|c| c as f32)).collect::<Vec<_>>())
        };
        assert!(flat("plate") && flat("disc"));
        assert!(!["octopus", "ring", "drum", "bell", "cat", "head"].into_iter().any(flat));
        assert!(!is_flat(&[]));
    }

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
        let gold = Looks { look: "ember".into(), palette: "gold".into(), ..Looks::default() };
        assert_eq!(look_named(&gold).0.answer.map(|answer| answer.palette), Some(Palette::Gold));
        assert_eq!(look_named(&names(["dawn", "", "", ""])), (Look::PLAIN, vec!["dawn".to_owned()]));
    }
}
