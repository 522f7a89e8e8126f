//! A turntable camera: orbit, pan, zoom, fit, and the ray through a pixel.

use chladni_mesh::Orientation;
use glam::{DVec3, Mat4, Vec3};

use crate::Rect;
use crate::pick::Ray;

/// How depth is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Projection {
    /// Near is larger.
    #[default]
    Perspective,
    /// Parallel lines stay parallel; the scale is that of the perspective at the target.
    Orthographic,
}

/// The views of the number pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From the front (1).
    Front,
    /// From the back (Ctrl 1).
    Back,
    /// From the viewer's right (3).
    Right,
    /// From the viewer's left (Ctrl 3).
    Left,
    /// From above (7).
    Top,
    /// From below (Ctrl 7).
    Bottom,
    /// From the front, turned and raised a little: what portraits use.
    ThreeQuarter,
}

/// Where the viewer stands. Angles turn about the up axis (turntable), so that the horizon
/// stays level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point looked at.
    pub target: [f32; 3],
    /// Turn about the up axis; 0 looks at the front, positive moves the viewer to the right.
    pub yaw_rad: f32,
    /// Height above the horizon, in [−π/2, π/2].
    pub pitch_rad: f32,
    /// From the eye to the target; positive.
    pub distance: f32,
    /// Radius about the target of all that is drawn; sets the depth range.
    pub reach: f32,
    /// Vertical angle of view.
    pub fov_y_rad: f32,
    /// How depth is drawn.
    pub projection: Projection,
    /// Where up and front are in the scene: the turntable stands on it.
    pub stands: Orientation,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            target: [0.0; 3],
            yaw_rad: 0.0,
            pitch_rad: 0.0,
            distance: 4.0,
            reach: 2.0,
            // A 50 mm lens on a full frame: close to how a portrait is seen.
            fov_y_rad: 27.0_f32.to_radians(),
            projection: Projection::Perspective,
            stands: Orientation::Y_UP,
        }
    }
}

impl Camera {
    /// Radians per pixel of an orbiting drag, as Blender's default.
    const ORBIT_RAD_PER_PIXEL: f32 = 0.4 * std::f32::consts::PI / 180.0;

    /// The default camera turned to `view` of a shape that stands so.
    pub fn on(stands: Orientation, view: View) -> Self {
        Self { stands, ..Self::looking(view) }
    }

    /// The default camera turned to `view`.
    pub fn looking(view: View) -> Self {
        let mut camera = Self::default();
        camera.look(view);
        camera
    }

    /// Turns to one of the standard views; target and distance stay.
    pub fn look(&mut self, view: View) {
        use std::f32::consts::{FRAC_PI_2, PI};
        (self.yaw_rad, self.pitch_rad) = match view {
            View::Front => (0.0, 0.0),
            View::Back => (PI, 0.0),
            View::Right => (FRAC_PI_2, 0.0),
            View::Left => (-FRAC_PI_2, 0.0),
            View::Top => (0.0, FRAC_PI_2),
            View::Bottom => (0.0, -FRAC_PI_2),
            View::ThreeQuarter => (0.5, 0.14),
        };
    }

    /// Turns by a drag of (dx, dy) pixels; y points down.
    pub fn orbit(&mut self, dx: f32, dy: f32) {
        use std::f32::consts::{FRAC_PI_2, PI, TAU};
        let yaw = self.yaw_rad - dx * Self::ORBIT_RAD_PER_PIXEL;
        self.yaw_rad = (yaw + PI).rem_euclid(TAU) - PI;
        self.pitch_rad = (self.pitch_rad + dy * Self::ORBIT_RAD_PER_PIXEL).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Shifts by a drag of (dx, dy) pixels in a viewport `height` pixels high: the point under
    /// the pointer, at the target's depth, follows it.
    pub fn pan(&mut self, dx: f32, dy: f32, height: f32) {
        let [right, up, _] = self.axes();
        let per_pixel = 2.0 * self.distance * (0.5 * self.fov_y_rad).tan() / height.max(1.0);
        self.target = (Vec3::from(self.target) + (up * dy - right * dx) * per_pixel).to_array();
    }

    /// What [`pan`](Self::pan) in a viewport of height 1 has brought the target here from `target`.
    pub fn shift_since(&self, target: [f32; 3]) -> [f32; 2] {
        let [right, up, _] = self.axes();
        let moved = Vec3::from(self.target) - Vec3::from(target);
        let height = 2.0 * self.distance * (0.5 * self.fov_y_rad).tan();
        [-moved.dot(right) / height, moved.dot(up) / height]
    }

    /// Comes nearer by `steps` of the wheel (negative: goes away), a tenth of the distance each.
    pub fn zoom(&mut self, steps: f32) {
        let nearest = self.reach * 0.02;
        self.distance =
            (self.distance * 0.9_f32.powf(steps)).clamp(nearest.max(1e-6), self.reach.max(1e-6) * 100.0);
    }

    /// Moves target and distance so that `points` take up the share `fill` of a frame of `aspect` (width over
    /// height): 0.9 leaves a margin of 5 % on each side. The direction stays. Without a finite point nothing
    /// changes.
    pub fn fit(&mut self, points: impl IntoIterator<Item = [f32; 3]> + Clone, aspect: f32, fill: f32) {
        let [right, up, back] = self.axes();
        let fill = fill.clamp(0.05, 1.0);
        let tan_y = (0.5 * self.fov_y_rad).tan() * fill;
        let tan_x = tan_y * aspect.max(1e-3);
        // A point (x, y, z) in the camera's axes is inside while |x − eye.x| ≤ tan_x (eye.z − z),
        // and so in y: two half-spaces per side, whose extremes fix the eye.
        let slope = match self.projection {
            Projection::Perspective => [tan_x, tan_y],
            Projection::Orthographic => [0.0; 2],
        };
        let (mut high, mut low) = ([f32::NEG_INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for point in points.clone() {
            let p = Vec3::from(point);
            if !p.is_finite() {
                continue;
            }
            let (xy, z) = ([p.dot(right), p.dot(up)], p.dot(back));
            for i in 0..2 {
                high[i] = high[i].max(xy[i] + slope[i] * z);
                low[i] = low[i].max(-xy[i] + slope[i] * z);
            }
            (near, far) = (near.max(z), far.min(z));
        }
        if near < far {
            return;
        }
        let eye: [f32; 2] = std::array::from_fn(|i| 0.5 * (high[i] - low[i]));
        let middle = 0.5 * (near + far);
        let distance = match self.projection {
            Projection::Perspective => {
                let eye_z = (0.5 * (high[0] + low[0]) / tan_x).max(0.5 * (high[1] + low[1]) / tan_y);
                eye_z - middle
            }
            Projection::Orthographic => {
                (0.5 * (high[0] + low[0]) / tan_x).max(0.5 * (high[1] + low[1]) / tan_y)
            }
        };
        let target = right * eye[0] + up * eye[1] + back * middle;
        let reach = points
            .into_iter()
            .map(Vec3::from)
            .filter(|p| p.is_finite())
            .fold(0.0_f32, |reach, p| reach.max(p.distance(target)));
        self.reach = reach.max(1e-6);
        // A shape that is much deeper than wide stays in front of the eye.
        self.distance = distance.max(near - middle + self.reach * 0.1);
        self.target = target.to_array();
    }

    /// Goes back, without turning or shifting, until `points` lie in a frame of `aspect` to `fill` of its
    /// sides; true where they did not yet.
    pub fn hold(&mut self, points: impl IntoIterator<Item = [f32; 3]>, aspect: f32, fill: f32) -> bool {
        let [right, up, back] = self.axes();
        let target = Vec3::from(self.target);
        let tan_y = (0.5 * self.fov_y_rad).tan() * fill.clamp(0.05, 1.0);
        let tan_x = tan_y * aspect.max(1e-3);
        let (mut distance, mut reach) = (0.0_f32, 0.0_f32);
        for p in points.into_iter().map(|p| Vec3::from(p) - target).filter(|p| p.is_finite()) {
            let depth = if self.projection == Projection::Perspective { p.dot(back) } else { 0.0 };
            let needed = (p.dot(right).abs() / tan_x).max(p.dot(up).abs() / tan_y) + depth;
            distance = distance.max(needed);
            reach = reach.max(p.length());
        }
        self.reach = self.reach.max(reach);
        let leaves = distance > self.distance;
        self.distance = self.distance.max(distance);
        leaves
    }

    /// Goes back until all `points` are in front of the eye, with some distance, and sets the depth range to reach
    /// all of them.
    pub fn keep_outside(&mut self, points: impl IntoIterator<Item = [f32; 3]>) {
        const CLEARANCE: f32 = 0.12;
        let [_, _, back] = self.axes();
        let target = Vec3::from(self.target);
        let (mut near, mut reach) = (0.0_f32, 1e-6_f32);
        for p in points.into_iter().map(|p| Vec3::from(p) - target).filter(|p| p.is_finite()) {
            (near, reach) = (near.max(p.dot(back)), reach.max(p.length()));
        }
        self.reach = reach;
        self.distance = self.distance.max(near + CLEARANCE * reach);
    }

    /// Looks higher until no point, raised by `rises` in the picture, is more than `top` of half a picture above its
    /// middle; what does not fit is then cut off below.
    pub fn keep_below(&mut self, points: impl IntoIterator<Item = [f32; 3]>, rises: f32, top: f32) {
        let [_, up, back] = self.axes();
        let target = Vec3::from(self.target);
        let edge = top * (0.5 * self.fov_y_rad).tan();
        let above = |p: Vec3| p.dot(up) + rises - edge * (self.distance - p.dot(back));
        let finite = points.into_iter().map(|p| Vec3::from(p) - target).filter(|p| p.is_finite());
        let most = finite.map(above).fold(0.0, f32::max);
        self.target = (target + up * most).to_array();
    }

    /// As [`fit`](Self::fit), but so that `points` stay in the frame at every yaw: for turntables.
    pub fn fit_turntable(&mut self, points: &[[f32; 3]], aspect: f32, fill: f32) {
        // Only the profile counts: the widest radius about the vertical through the center at each height.
        const HEIGHTS: usize = 128;
        const TURNS: usize = 32;
        let [x, up, y] = self.ground();
        let finite = points.iter().copied().map(Vec3::from).filter(|p| p.is_finite());
        let on_ground = |p: Vec3| Vec3::new(p.dot(x), p.dot(up), p.dot(y));
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in finite.clone().map(on_ground) {
            (low, high) = (low.min(p), high.max(p));
        }
        if low.x > high.x {
            return;
        }
        let middle = 0.5 * (low + high);
        let center = x * middle.x + up * middle.y + y * middle.z;
        let (bottom, span) = (low.y, (high.y - low.y).max(1e-12));
        let mut radius = [-1.0_f32; HEIGHTS];
        for p in finite {
            let slot = (((p.dot(up) - bottom) / span) * (HEIGHTS - 1) as f32).round() as usize;
            let d = p - center;
            let slot = &mut radius[slot.min(HEIGHTS - 1)];
            *slot = slot.max(d.dot(x).hypot(d.dot(y)));
        }
        let mut ring = Vec::with_capacity(HEIGHTS * TURNS);
        for (i, r) in radius.into_iter().enumerate().filter(|(_, r)| *r >= 0.0) {
            let height = bottom + span * i as f32 / (HEIGHTS - 1) as f32;
            for turn in 0..TURNS {
                let (sin, cos) = (turn as f32 * std::f32::consts::TAU / TURNS as f32).sin_cos();
                let flat = center - up * center.dot(up);
                ring.push((flat + up * height + (x * cos + y * sin) * r).to_array());
            }
        }
        self.fit(ring.iter().copied(), aspect, fill);
        // The axis of the turntable runs through the middle of the frame.
        let target = Vec3::from(self.target);
        self.target = (center + up * (target - center).dot(up)).to_array();
        self.hold(ring, aspect, fill);
    }

    /// As [`fit_turntable`](Self::fit_turntable), but only for turns of up to `swing_rad` to either side: a
    /// long shape that shows its narrow side may then be seen from nearer.
    pub fn fit_swing(&mut self, points: &[[f32; 3]], aspect: f32, fill: f32, swing_rad: f32) {
        // To either side, seen from the front and from behind: as wide to the left of the axis as to the right.
        const TURNS: [f32; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
        if swing_rad.abs() >= std::f32::consts::FRAC_PI_2 {
            return self.fit_turntable(points, aspect, fill);
        }
        let [x, up, y] = self.ground();
        let on_ground = |p: &[f32; 3]| [x, up, y].map(|axis| Vec3::from(*p).dot(axis));
        let finite: Vec<Vec3> =
            points.iter().map(|p| Vec3::from(on_ground(p))).filter(|p| p.is_finite()).collect();
        let (low, high) = finite
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        if low.x > high.x {
            return;
        }
        let middle = 0.5 * (low + high);
        let center = x * middle.x + up * middle.y + y * middle.z;
        let turned = TURNS.into_iter().flat_map(|turn| {
            let (sin, cos) = (turn * swing_rad).sin_cos();
            finite.iter().flat_map(move |p| {
                let d = *p - middle;
                let flat = x * (cos * d.x - sin * d.z) + y * (sin * d.x + cos * d.z);
                let level = center + up * d.y;
                [(level + flat).to_array(), (level - flat).to_array()]
            })
        });
        self.fit(turned.clone(), aspect, fill);
        let target = Vec3::from(self.target);
        self.target = (center + up * (target - center).dot(up)).to_array();
        self.hold(turned, aspect, fill);
    }

    /// Right, up and back (towards the viewer) of the view, in the scene.
    pub(crate) fn axes(&self) -> [Vec3; 3] {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_rad.sin_cos();
        let right = Vec3::new(cos_yaw, 0.0, -sin_yaw);
        let back = Vec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let up = back.cross(right);
        let [x, y, z] = self.ground();
        [right, up, back].map(|v| x * v.x + y * v.y + z * v.z)
    }

    /// Right, up and front of what stands in the scene.
    fn ground(&self) -> [Vec3; 3] {
        let stands = &self.stands;
        [stands.right(), stands.up(), stands.front()].map(|v| DVec3::from(v).as_vec3())
    }

    /// Up in the scene, whatever the pitch.
    pub(crate) fn up(&self) -> Vec3 {
        self.ground()[1]
    }

    /// Where the eye is.
    pub fn eye(&self) -> [f32; 3] {
        (Vec3::from(self.target) + self.axes()[2] * self.distance).to_array()
    }

    /// From the scene to the camera's axes.
    pub(crate) fn view_matrix(&self) -> Mat4 {
        let [right, up, back] = self.axes();
        let eye = Vec3::from(self.eye());
        Mat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0)).inverse()
    }

    /// From the camera's axes to clip space, depth in [0, 1].
    pub(crate) fn projection_matrix(&self, aspect: f32) -> Mat4 {
        let far = self.distance + self.reach * 1.5;
        let scale = 1.0 / (0.5 * self.fov_y_rad).tan();
        // How much a length shrinks with its distance: as in a lens, or not at all.
        let (y, near, depth, lens) = match self.projection {
            Projection::Perspective => {
                let near = (self.distance - self.reach * 1.5).max(far * 1e-3);
                (scale, near, far / (near - far), 1.0)
            }
            Projection::Orthographic => {
                let near = self.distance - self.reach * 1.5;
                (scale / self.distance, near, 1.0 / (near - far), 0.0)
            }
        };
        Mat4::from_cols_array_2d(&[
            [y / aspect, 0.0, 0.0, 0.0],
            [0.0, y, 0.0, 0.0],
            [0.0, 0.0, depth, -lens],
            [0.0, 0.0, near * depth, 1.0 - lens],
        ])
    }

    /// The pixel (x, y) of `point` in `viewport` and its depth in [0, 1]; `None` behind the eye.
    pub fn project(&self, point: [f32; 3], viewport: Rect) -> Option<([f32; 2], f32)> {
        let clip =
            self.projection_matrix(viewport.aspect()) * self.view_matrix() * Vec3::from(point).extend(1.0);
        (clip.w > 0.0).then(|| {
            let x = viewport.x as f32 + (0.5 + 0.5 * clip.x / clip.w) * viewport.width as f32;
            let y = viewport.y as f32 + (0.5 - 0.5 * clip.y / clip.w) * viewport.height as f32;
            ([x, y], clip.z / clip.w)
        })
    }

    /// The ray through the point (x, y) of `viewport`, pixels with y down.
    pub fn ray(&self, x: f32, y: f32, viewport: Rect) -> Ray {
        let [right, up, back] = self.axes();
        let tan = (0.5 * self.fov_y_rad).tan();
        let u =
            (2.0 * (x - viewport.x as f32) / viewport.width.max(1) as f32 - 1.0) * tan * viewport.aspect();
        let v = (1.0 - 2.0 * (y - viewport.y as f32) / viewport.height.max(1) as f32) * tan;
        let eye = Vec3::from(self.eye());
        match self.projection {
            Projection::Perspective => {
                let direction = (right * u + up * v - back).normalize();
                Ray { origin: eye.to_array(), direction: direction.to_array() }
            }
            Projection::Orthographic => {
                // Rays start in front of all that is drawn, even if the eye does not.
                let origin = eye + (right * u + up * v) * self.distance + back * self.reach * 2.0;
                Ray { origin: origin.to_array(), direction: (-back).to_array() }
            }
        }
    }
}
