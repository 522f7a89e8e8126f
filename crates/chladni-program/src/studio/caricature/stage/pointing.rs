//! Places on the stage under the pointer and the brush.

use chladni_caricature::{Brush, Reach, Seen, Surface, SurfacePoint};
use chladni_view::{Hit, PickTree, Rect};
use egui::Ui;

use super::super::lasso::encloses;
use super::super::look::Show;
use super::Stage;
use crate::studio::viewport;

/// A point under the pointer.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Its triangle and weights.
    pub hit: Hit,
    /// The point, working frame.
    pub point: [f32; 3],
}

impl Touch {
    /// The same place on the surface at rest.
    pub fn on_surface(&self) -> SurfacePoint {
        SurfacePoint { triangle: self.hit.triangle, weights: self.hit.barycentric.map(f64::from) }
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
    /// The part of the figure under the brush, as the figure is displayed.
    pub reach: Reach,
}

impl Stage {
    /// A press of the brush on the figure that is `pointed` at.
    pub(super) fn press(&self, hand: BrushInHand<'_>, pointed: &Pointed, touch: Touch) -> Press {
        let [x, y] = pointed.at;
        let eye = self.camera.eye_at(x, y, pointed.cell);
        let positions = &self.poses[pointed.figure].0;
        let tree = self.pick.as_ref().filter(|(picked, _)| *picked == pointed.figure).map(|(_, tree)| tree);
        let triangles = &self.triangles;
        let blocked = |eye: [f64; 3], point: [f64; 3]| {
            tree.is_some_and(|tree| tree.blocks(eye, point, positions, triangles))
        };
        let seen = Seen { surface: hand.surface, positions, eye: Some(eye), blocked: Some(&blocked) };
        Press { touch, reach: hand.brush.reach(&seen, &touch.on_surface()) }
    }

    /// The vertices of the figure in which `line` begins that lie within it, as they are seen, and those whose images in
    /// `mirror` do.
    pub fn encircled(
        &mut self,
        ui: &Ui,
        rect: egui::Rect,
        show: Show,
        line: &[egui::Pos2],
        hand: BrushInHand<'_>,
    ) -> Vec<u32> {
        let line: Vec<egui::Pos2> = line.iter().map(|at| viewport::to_pixels(ui, rect, *at).into()).collect();
        let (figures, cells) = self.arranged(ui, rect, show);
        let begins = line.first().and_then(|at| cells.iter().position(|cell| cell.contains(at.x, at.y)));
        let Some((cell, figure)) = begins.and_then(|i| Some((*cells.get(i)?, *figures.get(i)?))) else {
            return Vec::new();
        };
        self.refit_pick(figure);
        let [x, y] = [cell.x as f32 + 0.5 * cell.width as f32, cell.y as f32 + 0.5 * cell.height as f32];
        let eye = self.camera.eye_at(x, y, cell);
        let positions = &self.poses[figure].0;
        let tree = self.pick.as_ref().map(|(_, tree)| tree);
        let blocked = |eye: [f64; 3], point: [f64; 3]| {
            tree.is_some_and(|tree| tree.blocks(eye, point, positions, &self.triangles))
        };
        let seen_at = |eye: [f64; 3], point: [f64; 3]| {
            tree.and_then(|tree| tree.seen_at(eye, point, positions, &self.triangles))
        };
        let within = |point: [f64; 3]| {
            let pixel = self.camera.project(point.map(|x| x as f32), cell);
            pixel.is_some_and(|(at, _)| encloses(&line, at.into()))
        };
        let place = |v: &u32| positions[*v as usize].map(f64::from);
        let all = || 0..positions.len() as u32;
        let seen = |eye| Seen { surface: hand.surface, positions, eye: Some(eye), blocked: Some(&blocked) };
        let mut taken = seen(eye).shown(all().filter(|v| within(place(v))).collect(), &seen_at);
        if let Some(plane) = hand.brush.mirror {
            let twins = all().filter(|v| within(plane.image(place(v)))).collect();
            taken.extend(seen(plane.image(eye)).shown(twins, &seen_at));
            taken.sort_unstable();
            taken.dedup();
        }
        taken
    }

    /// The touches along the way `from` a pixel to where `pointed` is, about `step` apart, without its end, which is
    /// at `touch`.
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
        self.refit_pick(figure);
        let positions = &self.poses[figure].0;
        let (_, tree) = self.pick.as_ref()?;
        let ray = self.camera.ray(x, y, cell);
        let hit = tree.pick(&ray, positions, &self.triangles)?;
        Some(Touch { hit, point: hit.point(&ray) })
    }

    /// Brings the tree that picks up to date with `figure`.
    fn refit_pick(&mut self, figure: usize) {
        let positions = &self.poses[figure].0;
        match &mut self.pick {
            Some((picked, _)) if *picked == figure => {}
            Some((picked, tree)) => {
                tree.refit(positions, &self.triangles);
                *picked = figure;
            }
            None => self.pick = Some((figure, PickTree::new(positions, &self.triangles))),
        }
    }
}

/// The place under the pointer.
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
