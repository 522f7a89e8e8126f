//! Pictures of a caricature: which, from where, how large.

use std::path::Path;

use chladni_caricature::{Action, Evaluation, LayerId, Model, Painted, Project, Property, Stack};
use chladni_mesh::surface::vec3::single;
use chladni_mesh::{Orientation, TriMesh};
use chladni_view::{
    Camera, Device, Picture, PictureRequest, PictureShape, Rect, Style, framing, render_picture,
};

use super::Terminal;
use super::ink::InkOptions;
use super::movement::say_movement;
use super::sheet::{self, Panel, Portrayed, SheetOptions};
use super::stance::StanceOptions;
use crate::work::outputs::check_size;
use crate::work::{Error, Inked, Made, OwnLook, Sculpture, Stance, settled, write_file};

/// Where the viewer of a picture stands, and how large the picture is.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Portrait {
    /// Where the picture is seen from: degrees to the right of the front and above the horizon [default: 30,10].
    #[arg(long, value_name = "YAW,PITCH", allow_hyphen_values = true, value_parser = angles)]
    view: Option<[f32; 2]>,
    /// Size of the picture in pixels [default: 1600x900].
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = pixels)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    stance: StanceOptions,
}

/// Refuses the `option` of pictures that was given, where there is one and no picture `is_drawn`.
///
/// # Errors
/// [`Error::Input`] with its name.
pub fn check_drawn(option: Option<&str>, is_drawn: bool) -> Result<(), Error> {
    match option {
        Some(option) if !is_drawn => {
            Err(Error::Input(format!("{option} is for a picture, and none is drawn here")))
        }
        _ => Ok(()),
    }
}

impl Portrait {
    /// Width and height of the picture, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size.unwrap_or([1600, 900])
    }

    /// Refuses these options where no picture `is_drawn`.
    ///
    /// # Errors
    /// [`Error::Input`] with the first of them.
    pub fn check_used(&self, is_drawn: bool) -> Result<(), Error> {
        let given = self.view.map(|_| "--view").or(self.size.map(|_| "--size"));
        check_drawn(given.or_else(|| self.stance.given()), is_drawn)
    }

    /// From where the shape called `name` is seen; `kept` is how its project says that it stands, `matched` how
    /// the template does that it was matched with.
    ///
    /// # Errors
    /// As [`Stance::of`].
    pub fn camera(
        &self,
        name: &str,
        mesh: &TriMesh,
        kept: Option<Orientation>,
        matched: Option<Orientation>,
        terminal: &Terminal,
    ) -> Result<Camera, Error> {
        let stands = Stance::from(self.stance).of(name, mesh, kept, matched, terminal)?;
        let [yaw_rad, pitch_rad] = self.view.unwrap_or([30.0, 10.0]).map(f32::to_radians);
        Ok(Camera { yaw_rad, pitch_rad, stands, ..Camera::default() })
    }

    /// Checks, before any work, that it can be drawn.
    pub fn check(&self) -> Result<(), Error> {
        Stance::from(self.stance).check()
    }
}

fn angles(text: &str) -> Result<[f32; 2], Error> {
    let parsed =
        text.split_once(',').and_then(|(y, p)| Some([y.trim().parse().ok()?, p.trim().parse().ok()?]));
    let within = |a: &[f32; 2]| a[0].abs() <= 360.0 && a[1].abs() <= 90.0;
    parsed.filter(within).ok_or_else(|| Error::input("write it as yaw,pitch in degrees, such as 30,10"))
}

fn pixels(text: &str) -> Result<[u32; 2], Error> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let within = |s: &[u32; 2]| s.iter().all(|s| (16..=16_384).contains(s));
    let wrong = || Error::input("write it as WIDTHxHEIGHT in pixels, 16 to 16384 each");
    let [width, height] = parsed.filter(within).ok_or_else(wrong)?;
    check_size(width, height)?;
    Ok([width, height])
}

/// Draws the panels that `sheet` asks for; the shape before and after, side by side, where it asks
/// for none. The picture is of this size and seen from where `from` stands; the shape has its `own` look except in ink. Each
/// μ of a sweep is described; the top layer has the scale curve that is usual for it, where `usual_curve` says so.
pub fn render(
    made: &mut Made,
    own: Option<&OwnLook>,
    project: &Project,
    path: &Path,
    (from, size): (Camera, [u32; 2]),
    (sheet, usual_curve): (&SheetOptions, bool),
    ink: &InkOptions,
    terminal: &Terminal,
) -> Result<(), Error> {
    let rows = if sheet.show.is_empty() && sheet.sweep.is_empty() {
        None
    } else {
        Some(rows(&mut made.stack, project, (sheet, usual_curve), terminal)?)
    };
    let triangles = &made.sculpture.body.triangles;
    if ink.wanted(path) {
        let rest = &made.sculpture.body.positions;
        let (panels, placed): (Vec<Portrayed>, _) = match rows {
            Some(rows) => {
                let placed = sheet::placed(&rows, from, size);
                (rows.into_iter().flatten().collect(), placed)
            }
            None => pair(&made.sculpture, from, size),
        };
        let moved = panels.iter().map(|panel| Inked::moved(&panel.positions, rest.iter().copied()));
        let shapes: Vec<Inked<'_>> = moved.collect();
        return ink.write(path, &shapes, &placed, triangles, size);
    }
    let device = terminal.device()?;
    let picture = match rows {
        Some(rows) => sheet::draw(&device, &rows, triangles, own, from, size)?,
        None => before_and_after(&made.sculpture, own, from, size, &device)?,
    };
    let png = picture.to_png()?;
    write_file(path, &png)
}

/// The shape before and after, and where they go.
fn pair(
    Sculpture { body, evaluation, .. }: &Sculpture,
    from: Camera,
    [width, height]: [u32; 2],
) -> (Vec<Portrayed>, Vec<(Rect, Camera)>) {
    let both = [&body.positions[..], &evaluation.result.positions].map(Portrayed::plain);
    let shapes = both.each_ref().map(|panel| &panel.positions[..]);
    let placed = framing::side_by_side(from, &shapes, Rect::of_size(width, height), framing::FILL);
    (both.into(), placed)
}

/// The panels of a picture: a row for each μ of the top layer, with its `usual_curve` if that is wanted.
fn rows(
    stack: &mut Stack,
    project: &Project,
    (sheet, usual_curve): (&SheetOptions, bool),
    terminal: &Terminal,
) -> Result<Vec<Vec<Portrayed>>, Error> {
    let Some((top, layer)) = project.layers().last() else {
        return Err(Error::input("there is no layer to show"));
    };
    let panels: &[Panel] = if sheet.show.is_empty() { &[Panel::Before, Panel::After] } else { &sheet.show };
    let sweep: &[f64] = if sheet.sweep.is_empty() { &[layer.mu] } else { &sheet.sweep };
    let mut project = project.clone();
    let mut rows = Vec::with_capacity(sweep.len());
    for &mu in sweep {
        project.apply(&Action::Set { layer: *top, to: Property::Mu(mu) }, None)?;
        if usual_curve {
            let curve = project.usual_curve(&layer.template, layer.matching.method, mu);
            project.apply(&Action::Set { layer: *top, to: Property::Curve(curve) }, None)?;
        }
        let evaluation = settled(stack, &project, terminal)?;
        if let Some(layer) = evaluation.layers.last().filter(|_| !sheet.sweep.is_empty()) {
            say_movement(format_args!("μ = {mu}"), layer, stack, terminal)?;
        }
        let mut row = Vec::new();
        for &panel in panels {
            row.extend(panel_of(stack, panel, &project, *top, &evaluation));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn panel_of(
    stack: &mut Stack,
    panel: Panel,
    project: &Project,
    top: LayerId,
    evaluation: &Evaluation,
) -> Vec<Portrayed> {
    let original = &stack.original().positions;
    let result = &evaluation.result.positions;
    // The top layer may be off; then it shows nothing but the shape.
    let base = evaluation.layers.last().map_or(original, |layer| &layer.base.positions);
    match panel {
        Panel::Before => vec![Portrayed::plain(original)],
        Panel::After => vec![Portrayed::plain(result)],
        Panel::Rest => vec![Portrayed { rest: single(original), ..Portrayed::plain(result) }],
        Panel::Ghost => {
            // A layer that is off has no template.
            let difference = evaluation.layers.last().and_then(|layer| layer.difference.as_ref());
            let ghost = difference.map(|difference| Portrayed::plain(&difference.target.points).positions);
            vec![Portrayed { ghost, ..Portrayed::plain(result) }]
        }
        Panel::Steps => {
            let acting = evaluation.layers.iter().filter(|layer| layer.displacement.is_some());
            let bases = acting.map(|layer| &layer.base.positions);
            bases.chain([result]).map(|positions| Portrayed::plain(positions)).collect()
        }
        Panel::Painted => {
            let shares = project
                .layer(top)
                .map(|layer| layer.region.painted.values(&stack.surface().file_positions()).to_vec());
            vec![Portrayed { shares, ..Portrayed::plain(base) }]
        }
        Panel::Region => {
            // A layer that does not act has none.
            let anew = || {
                let region = &project.layer(top)?.region;
                let painted = region.painted.values(&stack.surface().file_positions());
                let is_everywhere = region.painted == Painted::Everywhere;
                if is_everywhere {
                    Some(painted)
                } else {
                    region.smoothing.apply(stack.body(), &painted).ok()
                }
            };
            let mask = evaluation.layers.last().and_then(|layer| layer.mask.clone()).or_else(anew);
            vec![Portrayed { shares: mask.map(|mask| mask.to_vec()), ..Portrayed::plain(base) }]
        }
        Panel::Coordinate | Panel::Normal | Panel::Distance => {
            let model = match panel {
                Panel::Coordinate => Model::Coordinate,
                Panel::Normal => Model::Normal,
                _ => Model::Distance,
            };
            let base = Portrayed::plain(base);
            let models = stack.three_models(project, top);
            let at = Model::ALL.iter().position(|m| *m == model);
            let moved = models.zip(at).map(|(models, at)| Portrayed::plain(&models[at]));
            vec![moved.unwrap_or(base)]
        }
    }
}

/// Both in the shape's `own` look.
fn before_and_after(
    Sculpture { body, evaluation, .. }: &Sculpture,
    own: Option<&OwnLook>,
    from: Camera,
    [width, height]: [u32; 2],
    device: &Device,
) -> Result<Picture, Error> {
    let (before, after) = (single(&body.positions), single(&evaluation.result.positions));
    let colors = own.and_then(OwnLook::colors);
    let shapes = [&before, &after].map(|positions| PictureShape {
        positions,
        triangles: &body.triangles,
        colors: colors.as_deref(),
        image: own.and_then(OwnLook::image),
        ..PictureShape::default()
    });
    let request = PictureRequest { shapes: &shapes, width, height, from, style: Style::default() };
    Ok(render_picture(device, &request)?)
}
