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
/// Contours are drawn on the averaged surface. Where it hardly bends along the line of sight, the exact surface may
/// rise just in front of its contour. So a blocker nearer than the first share of the size hides a contour only if it
/// also rises higher than the second.
const BEFORE_CONTOUR: [f64; 2] = [0.2, 0.012];

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

    /// Whether nothing lies between the viewer and `p`, a point of the surface with this normal that may lie on a
    /// contour.
    pub fn sees(&self, p: Vec3, normal: Vec3, contour: bool) -> bool {
        let toward = self.toward(p);
        let normal = if dot(normal, toward) < 0.0 { scaled(normal, -1.0) } else { normal };
        let [near, high] = BEFORE_CONTOUR.map(|share| share * self.plate.size);
        // Things behind the eye hide nothing.
        let eye = match self.camera.projection {
            Projection::Perspective => length(sub(self.eye, p)),
            _ => f64::INFINITY,
        };
        let hidden =
            |clearance: f64| self.blocked(p, normal, toward, clearance).filter(|far| *far < eye + clearance);
        match hidden(CLEARANCE * self.plate.size) {
            None => true,
            Some(before) => contour && before < near && hidden(high).is_none(),
        }
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
