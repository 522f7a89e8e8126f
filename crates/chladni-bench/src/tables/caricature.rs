//! A row of the caricature paper's table: harmonics, match and filter elements once, then strokes of
//! the brush with the three models side by side.

use std::sync::Arc;
use std::time::Instant;

use chladni_caricature::{
    Base, Brush, Dab, Difference, History, Layer, MatchRequest, PaintEdit, Painted, Project, Seen,
    ShapeSource, Stack, SurfacePoint, Target, Template,
};
use chladni_synth::{Item, SynthModel};
use chladni_view::PickTree;
use serde::Serialize;

use super::frame::{Easel, Projector, Secs};
use super::{BenchTables, median_ms};
use chladni_program::cli::Terminal;
use chladni_program::work::body::laplacian;
use chladni_program::work::{Error, Watcher};
use chladni_program::work::{source, template_mesh};

/// Radius of the brush in the working frame, where a shape is 2 wide.
const BRUSH: f64 = 0.15;

#[derive(Serialize)]
pub struct Row {
    shape: String,
    template: String,
    vertices: usize,
    harmonics: usize,
    /// H_k.
    harmonics_secs: f64,
    /// Correspondences; none where the template is the shape itself.
    match_secs: Option<f64>,
    /// X̃: x̃^δ, ξ̃ and ψ with their residuals.
    difference_secs: f64,
    /// From the pointer to the point of the deformed shape under it.
    picking_ms: f64,
    /// A dab of the brush.
    painting_ms: f64,
    /// χ by the sharp cut at 96, alone.
    smoothing_ms: f64,
    /// From what is painted to the terms of the three models: smoothing and filters.
    filters_ms: f64,
    synthesis_ms: f64,
    normals_ms: f64,
    drawing_ms: f64,
    fps: f64,
}

impl BenchTables {
    pub fn caricature_row(
        &self,
        shape: &str,
        template: &str,
        easel: &mut Easel,
        terminal: &Terminal,
    ) -> Result<Row, Error> {
        let mesh = source::mesh(shape, terminal)?;
        let (body, harmonics_secs) = self.solve(shape, &mesh, self.harmonics, terminal)?;
        let triangles = body.triangles.clone();
        let model = SynthModel::new(&body)?;
        let mut projector = Projector::new(easel, &model, &triangles)?;
        let mut stack = Stack::new(Arc::new(body))?;
        let source: ShapeSource = shape.parse()?;
        let mut project = Project::new(source, self.harmonics);
        project.laplacian = laplacian(self.paper);
        let template: Template = template.parse()?;
        let layer = Layer::paper("row", template.clone());
        let (smoothing, request) = (layer.region.smoothing, MatchRequest::of(&layer));
        let id = project.push(layer)?;
        let mut match_secs = None;
        let mut difference_secs = 0.0;
        if let Some(request) = request {
            let against = template_mesh(&template, terminal)?;
            let start = Instant::now();
            let body = stack.body().clone();
            let matched =
                terminal.watch("matching", |task| request.run(&mesh, &body, against.as_ref(), task));
            let matched = matched?;
            match_secs = Some(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let base = Base::new(body.basis.clone(), stack.surface().clone(), body.positions.clone());
            let base = Arc::new(base?);
            let target = Target::new(body.basis.clone(), matched.points.clone())?;
            Difference::new(base, Arc::new(target))?.prepare();
            difference_secs = start.elapsed().as_secs_f64();
            stack.install(request, Ok(matched));
        }
        let mut history = History::new(project);
        let surface = stack.surface().clone();
        let mut shown = single(&stack.body().positions);
        let mut tree = PickTree::new(&shown, &triangles);
        let mut painted = Painted::Vertices(vec![0.0; shown.len()].into());
        let mut parts: [Vec<f64>; 8] = std::array::from_fn(|_| Vec::new());
        for frame in 0..=self.frames.max(1) {
            let (camera, viewport) = projector.view(3);
            let start = Instant::now();
            tree.refit(&shown, &triangles);
            let turn = frame as f32;
            let middle = [viewport.width as f32 * 0.5, viewport.height as f32 * 0.5];
            let (x, y) = (middle[0] * (1.0 + 0.2 * turn.sin()), middle[1] * (1.0 + 0.2 * turn.cos()));
            let ray = camera.ray(x, y, chladni_view::Rect { x: 0, y: 0, ..viewport });
            let hit = tree.pick(&ray, &shown, &triangles);
            let picked = start.elapsed().as_secs_f64();
            if let Some(hit) = hit {
                let at = SurfacePoint { triangle: hit.triangle, weights: hit.barycentric.map(f64::from) };
                let eye = Some(ray.origin.map(f64::from));
                let blocked = |eye, point| tree.blocks(eye, point, &shown, &triangles);
                let seen = Seen { surface: &surface, positions: &shown, eye, blocked: Some(&blocked) };
                let reach = Brush { radius: BRUSH, mirror: None }.reach(&seen, &at);
                let dab = PaintEdit::Dab(Dab::of(&reach, 1.0, false));
                painted = dab.apply(&painted, &surface)?;
            }
            let dabbed = start.elapsed().as_secs_f64();
            let to = PaintEdit::Set(painted.clone());
            let action = chladni_caricature::Action::Paint { layer: id, edit: to };
            history.apply_live(&action, Some(&surface))?;
            let terms = stack.terms(history.project(), id);
            let terms = terms.ok_or_else(|| Error::other("the layer does not act"))?;
            let items = terms.map(|term| Item { terms: vec![term] });
            let filtered = start.elapsed().as_secs_f64();
            let secs = projector.show(easel, &items)?;
            let total = start.elapsed().as_secs_f64();
            shown = single(&stack.evaluate(history.project()).result.positions);
            // The same once more, beside the frame, to tell its share of the filters.
            let start = Instant::now();
            if let Painted::Vertices(values) = &painted {
                std::hint::black_box(smoothing.apply(stack.body(), values)?);
            }
            let smoothing = start.elapsed().as_secs_f64();
            if frame > 0 {
                let Secs { synthesis, normals, drawing } = secs;
                let measured = [
                    picked,
                    dabbed - picked,
                    smoothing,
                    filtered - dabbed,
                    synthesis,
                    normals,
                    drawing,
                    total,
                ];
                parts.iter_mut().zip(measured).for_each(|(part, secs)| part.push(secs));
            }
        }
        let basis = &stack.body().basis;
        let [
            picking_ms,
            painting_ms,
            smoothing_ms,
            filters_ms,
            synthesis_ms,
            normals_ms,
            drawing_ms,
            total_ms,
        ] = parts.map(median_ms);
        Ok(Row {
            shape: shape.to_owned(),
            template: template.to_string(),
            vertices: basis.vertices(),
            harmonics: basis.harmonics(),
            harmonics_secs,
            match_secs,
            difference_secs,
            picking_ms,
            painting_ms,
            smoothing_ms,
            filters_ms,
            synthesis_ms,
            normals_ms,
            drawing_ms,
            fps: 1e3 / total_ms,
        })
    }
}

fn single(positions: &[[f64; 3]]) -> Vec<[f32; 3]> {
    positions.iter().map(|p| p.map(|c| c as f32)).collect()
}
