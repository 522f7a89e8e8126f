//! A project evaluated on a mesh, and what can be made of it: files and pictures.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{
    Action, Base, Crossings, Evaluation, LayerId, LayerState, MatchRequest, Model, Project, Property, Stack,
    Template,
};
use chladni_harmonics::Body;
use chladni_mesh::{Format, MorphTarget, Orientation, TriMesh, save_mesh, write_glb};
use chladni_synth::Term;
use chladni_task::write_atomic;
use chladni_view::{Camera, Picture, PictureRequest, PictureShape, Style, render_picture};

use super::inputs::{build_body, open_mesh};
use super::sheet::{self, Panel, Portrayed, SheetOptions};
use super::stance::Stance;
use super::{Failure, Terminal};
use crate::own_look::OwnLook;

/// A shape with its harmonics and a project evaluated on it.
pub struct Sculpture {
    mesh: TriMesh,
    stack: Stack,
    evaluation: Evaluation,
    /// How it stands if it stands as a template that it was matched with.
    matched: Option<Orientation>,
}

impl Sculpture {
    /// Solves and matches what `project` asks for on the mesh called `name`, and evaluates it.
    pub fn make(name: &str, mesh: TriMesh, project: &Project, terminal: &Terminal) -> Result<Self, Failure> {
        let body = Arc::new(harmonics(name, &mesh, project, terminal)?);
        let mut stack = Stack::new(body.clone()).map_err(Failure::other)?;
        let mut as_matched = None;
        for request in stack.missing(project) {
            let template = match &request.template {
                Template::File(path) => Some(open_mesh(&path.display().to_string(), terminal)?),
                sample @ Template::Sample(_) => Some(open_mesh(&sample.to_string(), terminal)?),
                _ => None,
            };
            let matched = matched(&request, &mesh, &body, template.as_ref(), terminal)?;
            as_matched = as_matched.or(matched.stands);
            stack.install(request, Ok(matched));
        }
        let evaluation = stack.evaluate(project);
        for layer in &evaluation.layers {
            if let LayerState::Failed(why) = &layer.state {
                return Err(Failure::input(format_args!("layer {}: {why}", layer.name)));
            }
        }
        for layer in &evaluation.layers {
            if layer.mask.as_ref().is_some_and(|mask| mask.iter().all(|share| *share == 0.0)) {
                terminal.warn(format_args!(
                    "layer {}: its region holds no vertex, so it moves nothing; the shape reaches from {}",
                    layer.name,
                    reach(&mesh)
                ));
            }
        }
        Ok(Self { mesh, stack, evaluation, matched: as_matched })
    }

    /// The acting layers as voices of an instrument, by name.
    pub fn voices(&self) -> Vec<(String, Term)> {
        self.evaluation.voices()
    }

    /// Tells of every acting layer how far it moves the shape and what it folds.
    pub fn describe(&self, terminal: &Terminal) -> Result<(), Failure> {
        let body = self.stack.body();
        for layer in &self.evaluation.layers {
            let Some(displacement) = &layer.displacement else {
                terminal.result(format_args!("{}: off", layer.name))?;
                continue;
            };
            let farthest = displacement.iter().map(|d| d[0].hypot(d[1]).hypot(d[2])).fold(0.0, f64::max);
            let folded = layer.folds(self.stack.surface());
            let name = &layer.name;
            let by = farthest / body.frame.scale;
            terminal.result(format_args!("{name}: moves up to {by:.4} units, {folded} triangles folded"))?;
        }
        let crossings = Crossings::of(self.stack.surface().clone());
        let crossing = |base: &Base| {
            let found =
                terminal.watch("counting crossings", |task| crossings.triangles(&base.positions, task));
            found.map(|found| found.len()).map_err(|_| Failure::Cancelled)
        };
        let (now, before) = (crossing(&self.evaluation.result)?, crossing(self.stack.original())?);
        terminal.result(format_args!("{now} triangles pass through others ({before} did before)"))
    }

    /// Writes the result, in the format of the extension: GLB with a morph target per layer, the
    /// others with the layers baked in.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        let body = self.stack.body();
        if format_of(path)? == Format::Glb {
            let targets = self.evaluation.morph_targets(body).into_iter();
            let targets: Vec<MorphTarget> =
                targets.map(|(name, displacements)| MorphTarget { name, displacements }).collect();
            let bytes = write_glb(&self.mesh, &targets).map_err(|error| Failure::writing(path, error))?;
            return write_atomic(path, &bytes).map_err(|error| Failure::writing(path, error));
        }
        let positions = self.evaluation.file_positions(body, &self.mesh.positions);
        let result = TriMesh { positions, ..self.mesh.clone() };
        save_mesh(&result, path).map_err(Failure::other)
    }

    /// Draws the panels that `sheet` asks for; the shape before and after, side by side, where it asks
    /// for none. The shape is called `name`; `kept` is how its project says that it stands.
    pub fn render(
        &mut self,
        name: &str,
        project: &Project,
        path: &Path,
        portrait: &Portrait,
        sheet: &SheetOptions,
        kept: Option<Orientation>,
        terminal: &Terminal,
    ) -> Result<(), Failure> {
        let Portrait { view: [yaw, pitch], size, stance } = *portrait;
        let stands = stance.of(name, &self.mesh, kept, self.matched, terminal)?;
        let (yaw_rad, pitch_rad) = (yaw.to_radians(), pitch.to_radians());
        let from = Camera { yaw_rad, pitch_rad, stands, ..Camera::default() };
        let picture = if sheet.show.is_empty() && sheet.sweep.is_empty() {
            self.before_and_after(name, from, size, terminal)?
        } else {
            sheet::draw(
                &terminal.device()?,
                &self.rows(project, sheet)?,
                &self.stack.body().triangles,
                from,
                size,
            )?
        };
        let png = picture.to_png().map_err(Failure::other)?;
        write_atomic(path, &png).map_err(|error| Failure::writing(path, error))
    }

    /// The panels of a picture: a row for each μ of the top layer.
    fn rows(&mut self, project: &Project, sheet: &SheetOptions) -> Result<Vec<Vec<Portrayed>>, Failure> {
        let Some((top, layer)) = project.layers().last() else {
            return Err(Failure::input("there is no layer to show"));
        };
        let panels: &[Panel] =
            if sheet.show.is_empty() { &[Panel::Before, Panel::After] } else { &sheet.show };
        let sweep: &[f64] = if sheet.sweep.is_empty() { &[layer.mu] } else { &sheet.sweep };
        let mut project = project.clone();
        let mut rows = Vec::with_capacity(sweep.len());
        for &mu in sweep {
            let action = Action::Set { layer: *top, to: Property::Mu(mu) };
            project.apply(&action, None).map_err(Failure::input)?;
            let evaluation = self.stack.evaluate(&project);
            let mut row = Vec::new();
            for &panel in panels {
                row.extend(self.panel(panel, &project, *top, &evaluation));
            }
            rows.push(row);
        }
        Ok(rows)
    }

    fn panel(
        &mut self,
        panel: Panel,
        project: &Project,
        top: LayerId,
        evaluation: &Evaluation,
    ) -> Vec<Portrayed> {
        let original = &self.stack.original().positions;
        let result = &evaluation.result.positions;
        // The top layer may be off; then it shows nothing but the shape.
        let base = evaluation.layers.last().map_or(original, |layer| &layer.base.positions);
        match panel {
            Panel::Before => vec![Portrayed::plain(original)],
            Panel::After => vec![Portrayed::plain(result)],
            Panel::Rest => {
                let dots = sheet::dots(original.iter().map(|p| p.map(|c| c as f32)));
                vec![Portrayed { dots, ..Portrayed::plain(result) }]
            }
            Panel::Steps => {
                let acting = evaluation.layers.iter().filter(|layer| layer.displacement.is_some());
                let bases = acting.map(|layer| &layer.base.positions);
                bases.chain([result]).map(|positions| Portrayed::plain(positions)).collect()
            }
            Panel::Painted => {
                let shares = project.layer(top).map(|layer| {
                    layer.region.painted.values(&self.stack.surface().file_positions()).to_vec()
                });
                vec![Portrayed { shares, ..Portrayed::plain(base) }]
            }
            Panel::Region => {
                let mask = evaluation.layers.last().and_then(|layer| layer.mask.as_deref());
                let shares = mask.map_or_else(|| vec![1.0; base.len()], <[f32]>::to_vec);
                vec![Portrayed { shares: Some(shares), ..Portrayed::plain(base) }]
            }
            Panel::Coordinate | Panel::Normal | Panel::Distance => {
                let model = match panel {
                    Panel::Coordinate => Model::Coordinate,
                    Panel::Normal => Model::Normal,
                    _ => Model::Distance,
                };
                let base = Portrayed::plain(base);
                let models = self.stack.three_models(project, top);
                let at = Model::ALL.iter().position(|m| *m == model);
                let moved = models.zip(at).map(|(models, at)| Portrayed::plain(&models[at]));
                vec![moved.unwrap_or(base)]
            }
        }
    }

    /// Both with the colours that the shape brought along.
    fn before_and_after(
        &self,
        name: &str,
        from: Camera,
        [width, height]: [u32; 2],
        terminal: &Terminal,
    ) -> Result<Picture, Failure> {
        let body = self.stack.body();
        let single = |positions: &[[f64; 3]]| -> Vec<[f32; 3]> {
            positions.iter().map(|p| p.map(|c| c as f32)).collect()
        };
        let (before, after) = (single(&body.positions), single(&self.evaluation.result.positions));
        let mut warnings = Vec::new();
        let own = OwnLook::of(&self.mesh, body, &mut warnings);
        warnings.iter().for_each(|warning| terminal.warn(format_args!("{name}: {warning}")));
        let colors = match &own {
            Some(OwnLook::Colors(bytes)) => {
                Some(bytes.iter().map(|c| c.map(|c| f32::from(c) / 255.0)).collect())
            }
            _ => None::<Vec<[f32; 4]>>,
        };
        let image = match &own {
            Some(OwnLook::Image { corner_uvs, picture }) => Some((picture, &corner_uvs[..])),
            _ => None,
        };
        let shapes = [&before, &after].map(|positions| PictureShape {
            positions,
            triangles: &body.triangles,
            colors: colors.as_deref(),
            image,
            ..PictureShape::default()
        });
        let request = PictureRequest { shapes: &shapes, width, height, from, style: Style::default() };
        render_picture(&terminal.device()?, &request).map_err(Failure::other)
    }
}

/// Where the viewer of a picture stands, and how large the picture is.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Portrait {
    /// Where the picture is seen from: degrees to the right of the front and above the horizon.
    #[arg(long, value_name = "YAW,PITCH", default_value = "30,10", allow_hyphen_values = true, value_parser = angles)]
    view: [f32; 2],
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1600x900", value_parser = pixels)]
    size: [u32; 2],
    #[command(flatten)]
    stance: Stance,
}

impl Portrait {
    /// Before any work: can it be drawn so?
    pub fn check(&self) -> Result<(), Failure> {
        self.stance.check()
    }
}

fn angles(text: &str) -> Result<[f32; 2], String> {
    let parsed =
        text.split_once(',').and_then(|(y, p)| Some([y.trim().parse().ok()?, p.trim().parse().ok()?]));
    let within = |a: &[f32; 2]| a[0].abs() <= 360.0 && a[1].abs() <= 90.0;
    parsed.filter(within).ok_or_else(|| "write it as yaw,pitch in degrees, such as 30,10".into())
}

fn pixels(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let within = |s: &[u32; 2]| s.iter().all(|s| (16..=16_384).contains(s));
    parsed.filter(within).ok_or_else(|| "write it as WIDTHxHEIGHT in pixels, 16 to 16384 each".into())
}

/// The format of `path`, if it is one that results are written in.
pub fn format_of(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match Format::from_extension(extension) {
        Some(format @ (Format::Obj | Format::Ply | Format::Stl | Format::Glb)) => Ok(format),
        _ => Err(Failure::input(format_args!(
            "{}: results are written as obj, ply, stl or glb",
            path.display()
        ))),
    }
}

fn harmonics(name: &str, mesh: &TriMesh, project: &Project, terminal: &Terminal) -> Result<Body, Failure> {
    let (body, _) = build_body(name, mesh, project.harmonics, project.laplacian, terminal)?;
    if !body.basis.certificate.inertia_counts_match {
        terminal.warn(format_args!("{name}: the harmonics are not certified complete"));
    }
    Ok(body)
}

/// From where to where a mesh goes, as one would write the centre of a region.
fn reach(mesh: &TriMesh) -> String {
    let extreme = |of: fn(f64, f64) -> f64| -> String {
        let all = mesh.positions.iter().copied();
        let corner = all.reduce(|a, b| std::array::from_fn(|i| of(a[i], b[i]))).unwrap_or_default();
        corner.map(|c| format!("{c:.4}")).join(",")
    };
    format!("{} to {}", extreme(f64::min), extreme(f64::max))
}

fn matched(
    request: &MatchRequest,
    mesh: &TriMesh,
    body: &Body,
    template: Option<&TriMesh>,
    terminal: &Terminal,
) -> Result<chladni_caricature::Matched, Failure> {
    let found = terminal.watch("matching", |task| request.run(mesh, body, template, task));
    let found = found.map_err(|error| match error {
        chladni_caricature::Error::Cancelled(_) => Failure::Cancelled,
        error => Failure::input(error),
    })?;
    for warning in found.report.iter().flat_map(|report| &report.warnings) {
        terminal.warn(format_args!("{}: {warning}", request.template));
    }
    Ok(found)
}
