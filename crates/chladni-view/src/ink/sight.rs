//! Which parts of a plate are visible, and where on the paper.

use chladni_mesh::surface::vec3::{Vec3, add, dot, length, scaled, sub, unit};
use glam::Vec3 as Single;

use super::Plate;
use crate::pick::{Hit, Ray};
use crate::{Camera, Projection, Rect};

/// A plate in the eyes of a viewer.
pub(super) struct Sight<'a> {
    pub plate: &'a Plate,
    pub camera: Camera,
    pub cell: Rect,
    /// The unit of lengths on paper, in pixels: 1 where the cell's shorter side has 900.
    pub unit: f64,
    /// Right, up and toward the viewer.
    pub axes: [Vec3; 3],
    eye: Vec3,
    /// Nearest and farthest along the axis toward the viewer.
    reach: [f64; 2],
}

/// How far from the surface visibility is tested, as a share of the size: more than a triangle's sagitta, less than
/// the distance of anything that could lie before it.
const CLEARANCE: f64 = 0.004;
/// How far beside a contour the surface is looked at, in units of paper.
const BESIDE: f64 = 1.5;
/// How far behind it that must lie to make it a contour, as a share of the size.
const BEHIND: f64 = 0.03;

impl<'a> Sight<'a> {
    pub fn new(plate: &'a Plate, camera: &Camera, cell: Rect) -> Self {
        let double = |v: Single| v.as_dvec3().to_array();
        let axes = camera.axes().map(double);
        let depths = plate.positions.iter().map(|p| dot(*p, axes[2]));
        let reach =
            depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)]);
        let unit = f64::from(cell.width.min(cell.height).max(1)) / 900.0;
        let eye = camera.eye().map(f64::from);
        Self { plate, camera: *camera, cell, unit, axes, eye, reach }
    }

    /// From `p` toward the viewer, unit.
    pub fn toward(&self, p: Vec3) -> Vec3 {
        match self.camera.projection {
            Projection::Perspective => unit(sub(self.eye, p)),
            Projection::Orthographic => self.axes[2],
        }
    }

    /// The pixel of `p`; `None` behind the eye.
    pub fn project(&self, p: Vec3) -> Option<[f64; 2]> {
        let [x, y, back] = self.axes.map(|axis| dot(sub(p, self.eye), axis));
        let depth = match self.camera.projection {
            Projection::Perspective => -back,
            Projection::Orthographic => f64::from(self.camera.distance),
        };
        let (w, h) = (f64::from(self.cell.width), f64::from(self.cell.height));
        let scale = 0.5 * h / (depth * (0.5 * f64::from(self.camera.fov_y_rad)).tan());
        let corner = [f64::from(self.cell.x), f64::from(self.cell.y)];
        (depth > 0.0).then(|| [corner[0] + 0.5 * w + x * scale, corner[1] + 0.5 * h - y * scale])
    }

    /// Whether nothing lies between the viewer and `p`, a point of the surface with this normal.
    pub fn sees(&self, p: Vec3, normal: Vec3) -> bool {
        let toward = self.toward(p);
        let normal = if dot(normal, toward) < 0.0 { scaled(normal, -1.0) } else { normal };
        let clearance = CLEARANCE * self.plate.size;
        // Things behind the eye hide nothing.
        let eye = match self.camera.projection {
            Projection::Perspective => length(sub(self.eye, p)),
            Projection::Orthographic => f64::INFINITY,
        };
        self.blocked(p, normal, toward, clearance).is_none_or(|far| far >= eye + clearance)
    }

    /// How far behind `p`, a point of a line that passes `at` in direction `along` on paper, lies what is seen beside
    /// it, on the side where that is farther off: from 1 on it is a contour. Negative where it is hidden.
    pub fn step(&self, p: Vec3, at: [f64; 2], along: [f64; 2]) -> f64 {
        let behind = [-BESIDE, BESIDE].map(|beside| {
            let beside = beside * self.unit;
            let ray = self.camera.ray(
                (at[0] - beside * along[1]) as f32,
                (at[1] + beside * along[0]) as f32,
                self.cell,
            );
            let hit = self.plate.tree.pick(&ray, &self.plate.single, &self.plate.triangles);
            hit.map_or(f64::INFINITY, |hit| dot(sub(p, hit.point(&ray).map(f64::from)), self.axes[2]))
        });
        behind[0].max(behind[1]) / (BEHIND * self.plate.size)
    }

    /// Whether nothing lies in a direction (unit) from a point of the surface, on the side of `normal`.
    pub fn is_free(&self, p: Vec3, normal: Vec3, direction: Vec3) -> bool {
        self.blocked(p, normal, direction, CLEARANCE * self.plate.size).is_none()
    }

    /// How far from `p`, lifted by `clearance`, the first thing in a direction lies.
    fn blocked(&self, p: Vec3, normal: Vec3, direction: Vec3, clearance: f64) -> Option<f64> {
        let start = add(p, scaled(normal, clearance));
        let ray = Ray { origin: start.map(|x| x as f32), direction: direction.map(|x| x as f32) };
        let hit = self.plate.tree.pick(&ray, &self.plate.single, &self.plate.triangles);
        hit.map(|hit| f64::from(hit.distance))
    }

    /// The point of the surface seen at a pixel.
    pub fn look(&self, [x, y]: [f64; 2]) -> Option<Hit> {
        let ray = self.camera.ray(x as f32, y as f32, self.cell);
        self.plate.tree.pick(&ray, &self.plate.single, &self.plate.triangles)
    }

    /// 0 at the shape's far side, 1 at its near side.
    pub fn nearness(&self, p: Vec3) -> f64 {
        let [low, high] = self.reach;
        (dot(p, self.axes[2]) - low) / (high - low).max(1e-9 * self.plate.size)
    }
}
