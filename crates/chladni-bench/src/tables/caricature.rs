//! A row of the caricature paper's table: harmonics, match and filter elements once, then strokes of
//! the brush with the three models side by side.

use std::sync::Arc;
use std::time::Instant;

use chladni_caricature::{
    Base, Difference, Layer, MatchRequest, Project, ShapeSource, Stack, Target, Template,
};
use chladni_synth::SynthModel;
use serde::Serialize;

use super::frame::Projector;
use super::stroke::Stroke;
use super::{BenchTables, median_ms};
use crate::easel::Easel;
use chladni_program::cli::Terminal;
use chladni_program::work::body::laplacian;
use chladni_program::work::{Error, Watcher};
use chladni_program::work::{source, template_mesh};

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
        let projector = Projector::new(easel, &SynthModel::new(&body)?, &body.triangles)?;
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
        let mut stroke = Stroke::new(id, smoothing, projector, stack, project);
        // The first frame warms up.
        stroke.frame(0, easel)?;
        let mut parts: [Vec<f64>; 8] = std::array::from_fn(|_| Vec::new());
        for frame in 1..=self.frames.max(1) {
            let measured = stroke.frame(frame, easel)?;
            parts.iter_mut().zip(measured).for_each(|(part, secs)| part.push(secs));
        }
        let basis = &stroke.stack().body().basis;
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
