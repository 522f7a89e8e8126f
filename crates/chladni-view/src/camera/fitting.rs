//! Where a camera stands so that points fill its frame, stay in it, or stay in front of the eye.

use glam::Vec3;

use super::{Camera, Projection};

impl Camera {
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
        let needed = (0.5 * (high[0] + low[0]) / tan_x).max(0.5 * (high[1] + low[1]) / tan_y);
        let distance = match self.projection {
            Projection::Perspective => needed - middle,
            Projection::Orthographic => needed,
        };
        self.target = (right * eye[0] + up * eye[1] + back * middle).to_array();
        self.reach_all(points);
        // A shape that is much deeper than wide stays in front of the eye.
        self.distance = distance.max(near - middle + self.reach * 0.1);
    }

    /// Shifts the view, neither turned nor nearer, so that `points` leave as much room on the left as on the right,
    /// and above as below. Points beside or behind the eye do not count.
    pub fn center(&mut self, points: impl IntoIterator<Item = [f32; 3]> + Clone) {
        // Newton's method; after three steps hardly a case is off by more than rounding.
        const STEPS: usize = 5;
        let [right, up, back] = self.axes();
        for _ in 0..STEPS {
            let target = Vec3::from(self.target);
            // How far out the outermost points are seen, and their depths: a shift moves each by as much over its depth.
            let (mut low, mut high) = ([(f32::INFINITY, 1.0_f32); 2], [(f32::NEG_INFINITY, 1.0_f32); 2]);
            for p in points.clone().into_iter().map(|p| Vec3::from(p) - target).filter(|p| p.is_finite()) {
                let depth = match self.projection {
                    Projection::Perspective => 1.0 - p.dot(back) / self.distance,
                    Projection::Orthographic => 1.0,
                };
                for (i, axis) in [right, up].into_iter().enumerate().filter(|_| depth > 0.0) {
                    let seen = (p.dot(axis) / depth, depth);
                    if seen.0 < low[i].0 {
                        low[i] = seen;
                    }
                    if seen.0 > high[i].0 {
                        high[i] = seen;
                    }
                }
            }
            let [x, y]: [f32; 2] =
                std::array::from_fn(|i| (low[i].0 + high[i].0) / (low[i].1.recip() + high[i].1.recip()));
            if x.is_finite() && y.is_finite() {
                self.target = (target + right * x + up * y).to_array();
            }
        }
        self.reach_all(points);
    }

    /// Sets the depth range to reach all `points`, wherever the camera stands.
    pub fn reach_all(&mut self, points: impl IntoIterator<Item = [f32; 3]>) {
        let target = Vec3::from(self.target);
        let finite = points.into_iter().map(Vec3::from).filter(|p| p.is_finite());
        self.reach = finite.fold(1e-6, |reach, p| reach.max(p.distance(target)));
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
    /// middle; parts that do not fit are then cut off below.
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
        self.fit_around(center, ring.iter().copied(), aspect, fill);
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
        self.fit_around(center, turned, aspect, fill);
    }

    /// Fits `points` with a turntable's axis, which runs through `center`, in the middle of the frame.
    fn fit_around(
        &mut self,
        center: Vec3,
        points: impl IntoIterator<Item = [f32; 3]> + Clone,
        aspect: f32,
        fill: f32,
    ) {
        self.fit(points.clone(), aspect, fill);
        let (target, up) = (Vec3::from(self.target), self.up());
        self.target = (center + up * (target - center).dot(up)).to_array();
        self.hold(points, aspect, fill);
    }
}

/// A camera that goes once around in as many frames as a film has; nothing leaves its frame at any angle.
#[derive(Clone, Copy, Debug)]
pub struct Turntable {
    start: Camera,
    frames: u64,
}

impl Turntable {
    const FILL: f32 = 0.92;

    /// Begins where `from` stands, moved so that all `points` stay in a frame of `aspect` (width over height).
    pub fn new(from: Camera, points: &[[f32; 3]], aspect: f32, frames: u64) -> Self {
        let mut start = from;
        start.fit_turntable(points, aspect, Self::FILL);
        Self { start, frames }
    }

    /// The camera of a frame, counted from 0.
    pub fn at(&self, frame: u64) -> Camera {
        let turn = std::f32::consts::TAU * frame as f32 / self.frames as f32;
        Camera { yaw_rad: self.start.yaw_rad - turn, ..self.start }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rect, View};

    #[test]
    fn nothing_is_cut_off_after_the_view_was_shifted() {
        let corners = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let points: Vec<[f32; 3]> = corners.map(|[x, y, z]: [f32; 3]| [0.5 * x, 0.5 * y, 2.0 * z]).collect();
        let cell = Rect::of_size(200, 200);
        let mut camera = Camera::looking(View::Right);
        camera.fit(points.iter().copied(), 1.0, 0.9);
        camera.pan(90.0, 0.0, 200.0);
        let is_seen = |camera: &Camera| {
            [View::Back, View::Front].into_iter().all(|view| {
                let mut camera = *camera;
                camera.look(view);
                points.iter().all(|p| camera.project(*p, cell).is_some_and(|(_, z)| (0.0..=1.0).contains(&z)))
            })
        };
        assert!(!is_seen(&camera));
        camera.reach_all(points.iter().copied());
        assert!(is_seen(&camera));
    }
}
