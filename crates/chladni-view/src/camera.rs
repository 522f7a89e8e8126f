//! A turntable camera: orbit, pan, zoom, and the ray through a pixel.

mod fitting;

use chladni_mesh::Orientation;
use glam::{DVec3, Mat4, Vec3};

pub use self::fitting::Turntable;
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
    /// Whether the camera has jumped since the picture `before`: by more than a third of a radian, or a quarter of its
    /// distance. A hand that moves it takes several pictures for that.
    pub(crate) fn is_cut_from(&self, before: &Self) -> bool {
        let turned = |now: f32, before: f32| {
            let full = std::f32::consts::TAU;
            let turn = (now - before).rem_euclid(full);
            turn.min(full - turn) > 0.33
        };
        let moved: f32 =
            self.target.iter().zip(before.target).map(|(now, before)| (now - before).powi(2)).sum();
        turned(self.yaw_rad, before.yaw_rad)
            || turned(self.pitch_rad, before.pitch_rad)
            || (self.distance - before.distance).abs() > 0.25 * before.distance
            || moved.sqrt() > 0.25 * before.distance
    }

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

    /// The [`pan`](Self::pan), in a viewport of height 1, that moves `target` to the current one.
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

    /// Right, up and front of the shapes in the scene.
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

    /// The eye that sees the place under the point (x, y) of `viewport`: far away in a parallel view, where everything is
    /// seen along the same direction.
    pub fn eye_at(&self, x: f32, y: f32, viewport: Rect) -> [f64; 3] {
        let ray = self.ray(x, y, viewport);
        let far = match self.projection {
            Projection::Perspective => 0.0,
            Projection::Orthographic => 1e6,
        };
        std::array::from_fn(|i| f64::from(ray.origin[i]) - far * f64::from(ray.direction[i]))
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
