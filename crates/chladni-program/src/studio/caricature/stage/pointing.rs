//! What the pointer and the brush touch on the stage.

use chladni_caricature::{Brush, Reach, Seen, Surface, SurfacePoint};
use chladni_view::{PickTree, Projection, Rect, ViewError};
use egui::Ui;

use super::Stage;
use crate::studio::viewport;

/// A point under the pointer.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// The triangle.
    pub triangle: u32,
    /// Its weights, summing to 1.
    pub barycentric: [f32; 3],
    /// The point, working frame.
    pub point: [f32; 3],
}

impl Touch {
    /// The same place on the surface at rest.
    pub fn on_surface(&self) -> SurfacePoint {
        SurfacePoint { triangle: self.triangle, weights: self.barycentric.map(f64::from) }
    }
}

/// A brush in hand and the surface that it paints.
#[derive(Clone, Copy)]
pub struct BrushInHand<'a> {
    /// The brush.
    pub brush: Brush,
    /// The surface at rest.
    pub surface: &'a Surface,
}

/// One press of the brush.
pub struct Press {
    /// Its center.
    pub touch: Touch,
    /// What it covers of the figure under the pointer, as it is seen.
    pub reach: Reach,
}

impl Stage {
    /// What the brush covers where it touches the figure that is `pointed` at.
    pub(super) fn press(&self, hand: BrushInHand<'_>, pointed: &Pointed, touch: Touch) -> Press {
        let [x, y] = pointed.at;
        let ray = self.camera.ray(x, y, pointed.cell);
        let far = match self.camera.projection {
            Projection::Perspective => 0.0,
            // Everything is seen along the same direction.
            Projection::Orthographic => 1e6,
        };
        let eye = std::array::from_fn(|i| f64::from(ray.origin[i]) - far * f64::from(ray.direction[i]));
        let positions = &self.poses[pointed.figure].0;
        let tree = self.pick.as_ref().filter(|(picked, _)| *picked == pointed.figure).map(|(_, tree)| tree);
        let triangles = &self.triangles;
        let blocked = |eye: [f64; 3], point: [f64; 3]| {
            tree.is_some_and(|tree| tree.blocks(eye, point, positions, triangles))
        };
        let seen = Seen { surface: hand.surface, positions, eye: Some(eye), blocked: Some(&blocked) };
        Press { touch, reach: hand.brush.reach(&seen, &touch.on_surface()) }
    }

    /// Lays the ring where `press` would paint.
    pub(super) fn ring_around(&mut self, press: Option<&Press>, surface: &Surface) -> Result<(), ViewError> {
        let Some(Press { reach, .. }) = press else {
            self.ring.lift();
            return Ok(());
        };
        let triangles: Vec<[u32; 3]> =
            reach.triangles.iter().filter_map(|t| surface.triangles.get(*t as usize)).copied().collect();
        let distances = reach.distances.iter().map(|(v, d)| (*v, *d as f32));
        self.ring.lay(self.viewport.gpu(), reach.radius as f32, distances, &triangles)
    }

    /// What lies under the way `from` a pixel to where `pointed` is, about `step` apart, without
    /// its end, which is at `touch`.
    pub(super) fn trail(
        &mut self,
        from: [f32; 2],
        pointed: &Pointed,
        touch: Option<Touch>,
        step: f32,
    ) -> Vec<Touch> {
        const MOST: f32 = 32.0;
        let on_the_way = |along: f32| Pointed {
            at: std::array::from_fn(|i| from[i] + (pointed.at[i] - from[i]) * along),
            ..*pointed
        };
        let Some((start, end)) = self.touch(&on_the_way(0.0)).zip(touch) else { return Vec::new() };
        let apart: f32 = (0..3).map(|i| (end.point[i] - start.point[i]).powi(2)).sum::<f32>().sqrt();
        let steps = (apart / step).ceil().clamp(1.0, MOST) as u16;
        let places = (0..steps).map(|i| on_the_way(f32::from(i) / f32::from(steps)));
        places.filter_map(|place| self.touch(&place)).collect()
    }

    /// Where `pointed` meets its figure.
    pub(super) fn touch(&mut self, pointed: &Pointed) -> Option<Touch> {
        let Pointed { at: [x, y], cell, figure } = *pointed;
        let positions = &self.poses[figure].0;
        match &mut self.pick {
            Some((picked, _)) if *picked == figure => {}
            Some((picked, tree)) => {
                tree.refit(positions, &self.triangles);
                *picked = figure;
            }
            None => self.pick = Some((figure, PickTree::new(positions, &self.triangles))),
        }
        let (_, tree) = self.pick.as_ref()?;
        let ray = self.camera.ray(x, y, cell);
        let hit = tree.pick(&ray, positions, &self.triangles)?;
        Some(Touch { triangle: hit.triangle, barycentric: hit.barycentric, point: hit.point(&ray) })
    }
}

/// What the pointer is on.
pub(super) struct Pointed {
    /// Pixels of the canvas.
    pub at: [f32; 2],
    pub cell: Rect,
    pub figure: usize,
}

impl Pointed {
    pub fn of(
        ui: &Ui,
        response: &egui::Response,
        rect: egui::Rect,
        figures: &[usize],
        cells: &[Rect],
    ) -> Option<Self> {
        let at = response.interact_pointer_pos().or(response.hover_pos())?;
        let [x, y] = viewport::to_pixels(ui, rect, at);
        let (cell, figure) = cells.iter().zip(figures).find(|(cell, _)| cell.contains(x, y))?;
        Some(Self { at: [x, y], cell: *cell, figure: *figure })
    }
}
