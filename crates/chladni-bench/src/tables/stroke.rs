//! A stroke of the brush over a shape, with the three models side by side.

use std::time::Instant;

use chladni_caricature::{
    Action, Brush, Dab, History, LayerId, PaintEdit, Painted, Project, Seen, Smoothing, Stack, SurfacePoint,
};
use chladni_mesh::surface::vec3::single;
use chladni_program::work::Error;
use chladni_synth::Item;
use chladni_view::PickTree;

use super::frame::{Projector, Secs};
use crate::easel::Easel;

/// Radius of the brush in the working frame, where a shape is 2 wide.
const BRUSH: f64 = 0.15;

/// A brush stroke and the state that it changes frame by frame.
pub struct Stroke {
    layer: LayerId,
    smoothing: Smoothing,
    projector: Projector,
    stack: Stack,
    history: History,
    /// The shape as it is seen.
    shown: Vec<[f32; 3]>,
    tree: PickTree,
    painted: Painted,
}

impl Stroke {
    /// Of `layer`, which is the project's, on the shape of `stack`.
    pub fn new(
        layer: LayerId,
        smoothing: Smoothing,
        projector: Projector,
        stack: Stack,
        project: Project,
    ) -> Self {
        let shown = single(&stack.body().positions);
        let tree = PickTree::new(&shown, &stack.body().triangles);
        let painted = Painted::Vertices(vec![0.0; shown.len()].into());
        Self { layer, smoothing, projector, stack, history: History::new(project), shown, tree, painted }
    }

    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// Paints and draws the frame of this number; the seconds of picking, painting, smoothing, filters, synthesis, normals
    /// and drawing, and of all.
    pub fn frame(&mut self, frame: usize, easel: &mut Easel) -> Result<[f64; 8], Error> {
        let start = Instant::now();
        let picked = self.dab(frame)?;
        let dabbed = start.elapsed().as_secs_f64();
        let to = PaintEdit::Set(self.painted.clone());
        let action = Action::Paint { layer: self.layer, edit: to };
        self.history.apply_live(&action, Some(self.stack.surface()))?;
        let terms = self.stack.terms(self.history.project(), self.layer);
        let terms = terms.ok_or_else(|| Error::other("the layer does not act"))?;
        let items = terms.map(|term| Item { terms: vec![term] });
        let filtered = start.elapsed().as_secs_f64();
        let Secs { synthesis, normals, drawing } = self.projector.show(easel, &items)?;
        let total = start.elapsed().as_secs_f64();
        self.shown = single(&self.stack.evaluate(self.history.project()).result.positions);
        // The same once more, beside the frame, to tell its share of the filters.
        let start = Instant::now();
        if let Painted::Vertices(values) = &self.painted {
            std::hint::black_box(self.smoothing.apply(self.stack.body(), values)?);
        }
        let smoothing = start.elapsed().as_secs_f64();
        Ok([picked, dabbed - picked, smoothing, filtered - dabbed, synthesis, normals, drawing, total])
    }

    /// Finds the place under the pointer and dabs there; the seconds until it was found.
    fn dab(&mut self, frame: usize) -> Result<f64, Error> {
        let (camera, viewport) = self.projector.view(3);
        let (shown, triangles) = (&self.shown, &self.stack.body().triangles);
        let start = Instant::now();
        self.tree.refit(shown, triangles);
        let turn = frame as f32;
        let middle = [viewport.width as f32 * 0.5, viewport.height as f32 * 0.5];
        let (x, y) = (middle[0] * (1.0 + 0.2 * turn.sin()), middle[1] * (1.0 + 0.2 * turn.cos()));
        let ray = camera.ray(x, y, chladni_view::Rect { x: 0, y: 0, ..viewport });
        let hit = self.tree.pick(&ray, shown, triangles);
        let picked = start.elapsed().as_secs_f64();
        if let Some(hit) = hit {
            let at = SurfacePoint { triangle: hit.triangle, weights: hit.barycentric.map(f64::from) };
            let eye = Some(ray.origin.map(f64::from));
            let blocked = |eye, point| self.tree.blocks(eye, point, shown, triangles);
            let surface = self.stack.surface();
            let seen = Seen { surface, positions: shown, eye, blocked: Some(&blocked) };
            let reach = Brush { radius: BRUSH, hardness: 1.0, mirror: None }.reach(&seen, &at);
            let dab = PaintEdit::Dab(Dab::of(&reach, 1.0, false));
            self.painted = dab.apply(&self.painted, surface)?;
        }
        Ok(picked)
    }
}
