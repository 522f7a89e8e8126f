//! `chladni match SHAPE TEMPLATE`: which point of a template belongs to each vertex of a shape.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use chladni_caricature::{GivenEllipsoid, self_low_passed};
use chladni_harmonics::npz::write_npz;
use chladni_harmonics::{BasisSettings, Body, HarmonicsError};
use chladni_match::{
    Correspondence, Ellipsoid, Match, MatchError, MatchReport, MatchSettings, Method, NEAR_TIE,
    load_landmarks, match_shapes, onto_ellipsoid, self_scaled,
};
use chladni_mesh::surface::drawn_triangles;
use chladni_mesh::surface::vec3::single;
use chladni_mesh::{HealthReport, TriMesh};
use chladni_task::Task;
use chladni_view::{Camera, ColorMap, PictureRequest, PictureShape, Scale, Style, View, render_picture};
use serde::Serialize;

use super::Terminal;
use super::layer_options::{check_landmarks, check_seed, scaling};
use crate::work::outputs::{check_arrays, check_no_texture, check_picture};
use crate::work::{Error, Stance, Warning, Watcher, place_colors, source, write_file};

/// Find the point of a template that belongs to each vertex of a shape, and say how good it is.
#[derive(clap::Args)]
pub struct MatchShapes {
    /// The shape: a mesh file or sample:NAME.
    shape: PathBuf,
    /// The template: a mesh file or sample:NAME; none for ellipsoid, sphere and self.
    template: Option<PathBuf>,
    /// How: same (connectivity), icp, fit, map (through a sphere, led by landmarks), ellipsoid,
    /// sphere, a given one (sphere:x,y,z,radius, ellipsoid:x,y,z,a,b,c and, turned, three angles), self:scale=S,
    /// self:lowpass=K.
    #[arg(long, default_value = "fit")]
    method: How,
    /// Pairs that belong together: `shape_vertex template_vertex` a line, from zero, # comments.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    /// Keep the template's own size, as the paper does, instead of fitting it to the shape's.
    #[arg(long)]
    rigid: bool,
    /// Seed of all sampling [default: 0].
    #[arg(long)]
    seed: Option<u64>,
    /// Write the correspondence here (NumPy archive: point, confidence, similarity and, on
    /// template meshes, triangle and barycentric, all described in docs/match.md).
    #[arg(short, long, value_name = "M.npz")]
    output: Option<PathBuf>,
    /// Print the quality report as JSON.
    #[arg(long)]
    json: bool,
    /// Draw the shape with its confidence, and the shape laid onto the template (μ = 1).
    #[arg(long, value_name = "P.png")]
    render: Option<PathBuf>,
}

/// The choice that `--method` makes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum How {
    Mesh(Method),
    Ellipsoid,
    Sphere,
    Given(Ellipsoid),
    SelfScaled(f64),
    SelfLowPassed(usize),
}

impl FromStr for How {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |n: &str| Error::input(format!("“{n}” is not a number"));
        Ok(match text {
            "same" => Self::Mesh(Method::Same),
            "icp" => Self::Mesh(Method::Icp),
            "fit" => Self::Mesh(Method::Fit),
            "map" => Self::Mesh(Method::Map),
            "ellipsoid" => Self::Ellipsoid,
            "sphere" => Self::Sphere,
            _ if text.starts_with("sphere:") || text.starts_with("ellipsoid:") => {
                let given: GivenEllipsoid = text.parse()?;
                Self::Given(given.ellipsoid()?)
            }
            _ => match text.strip_prefix("self:").and_then(|rest| rest.split_once('=')) {
                Some(("scale", s)) => Self::SelfScaled(s.parse().map_err(|_| number(s))?),
                Some(("lowpass", k)) => Self::SelfLowPassed(k.parse().map_err(|_| number(k))?),
                _ => {
                    return Err(Error::input(
                        "expected same, icp, fit, map, ellipsoid, sphere, sphere:x,y,z,radius, \
                         ellipsoid:x,y,z,a,b,c (and, turned, three angles), self:scale=S or self:lowpass=K",
                    ));
                }
            },
        })
    }
}

/// The output of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    report: &'a MatchReport,
    seconds: f64,
}

impl MatchShapes {
    /// Matches, writes the files asked for and prints the report.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.check()?;
        let shape = source::mesh(&self.shape, terminal)?;
        self.check_textures(&self.shape, &shape)?;
        let start = Instant::now();
        let found = terminal.watch("matching", |task| self.find(&shape, terminal, task))?;
        let seconds = start.elapsed().as_secs_f64();
        if let Some(path) = &self.output {
            save(path, &found.correspondence).map_err(|error| Error::unwritten(path, error))?;
        }
        if let Some(path) = &self.render {
            draw(path, &self.shape.display().to_string(), &shape, &found.correspondence, terminal)?;
        }
        for warning in &found.report.warnings {
            let way_out =
                if warning == NEAR_TIE { " (--render P.png shows it; --landmarks leads it)" } else { "" };
            terminal.warn(Warning::Plain(format!("{warning}{way_out}")));
        }
        if self.json {
            return terminal.json(&Printed { report: &found.report, seconds });
        }
        lines(&found.report, seconds).into_iter().try_for_each(|line| terminal.result(line))?;
        [&self.output, &self.render].into_iter().flatten().try_for_each(|path| terminal.wrote(path))
    }

    /// Checks, before any work, that the request is possible and the results can be written.
    fn check(&self) -> Result<(), Error> {
        let of_mesh =
            self.template.is_some() || self.landmarks.is_some() || self.rigid || self.seed.is_some();
        let word = self.template.as_deref().filter(|path| !path.exists()).and_then(Path::to_str);
        if let Some(word @ ("ellipsoid" | "sphere")) = word {
            return Err(Error::Input(format!(
                "{word} is no file: match SHAPE --method {word} takes it as a template"
            )));
        }
        if !matches!(self.method, How::Mesh(_)) && of_mesh {
            return Err(Error::input("this method takes neither a template, landmarks, --rigid nor --seed"));
        }
        if let How::Mesh(method) = self.method {
            check_landmarks(method, self.landmarks.as_deref())?;
            check_seed(method, self.seed)?;
        }
        self.output.as_deref().map_or(Ok(()), check_arrays)?;
        self.render.as_deref().map_or(Ok(()), check_picture)
    }

    /// Checks that the picture replaces no texture of `mesh`, which was read from the file `path`.
    fn check_textures(&self, path: &Path, mesh: &TriMesh) -> Result<(), Error> {
        self.render.as_deref().map_or(Ok(()), |picture| check_no_texture(picture, path, mesh))
    }

    fn find(&self, shape: &TriMesh, terminal: &Terminal, task: &Task) -> Result<Match, Error> {
        let failed = |error: MatchError| Error::from(error).of(self.names());
        let alone = |correspondence: Result<Correspondence, MatchError>| {
            let correspondence = correspondence.map_err(failed)?;
            let report = MatchReport::without_template(shape, &correspondence).map_err(failed)?;
            Ok(Match { correspondence, report })
        };
        match self.method {
            How::Mesh(method) => {
                let path = self.template.as_ref().ok_or_else(|| {
                    Error::input("this method needs a template: chladni match SHAPE TEMPLATE")
                })?;
                let template = source::mesh(path, terminal)?;
                self.check_textures(path, &template)?;
                let landmarks = match &self.landmarks {
                    Some(path) => load_landmarks(path)?,
                    None => Vec::new(),
                };
                let scaling = scaling(self.rigid);
                let seed = self.seed.unwrap_or(MatchSettings::default().seed);
                let settings = MatchSettings { method, landmarks, seed, scaling };
                match_shapes(shape, &template, &settings, task).map_err(failed)
            }
            How::Ellipsoid => alone(Ellipsoid::fitted(shape).and_then(|e| onto_ellipsoid(shape, &e))),
            How::Sphere => alone(Ellipsoid::fitted_sphere(shape).and_then(|e| onto_ellipsoid(shape, &e))),
            How::Given(given) => alone(onto_ellipsoid(shape, &given)),
            How::SelfScaled(scale) => alone(self_scaled(shape, scale)),
            How::SelfLowPassed(k0) => {
                // The constants of all pieces count as one harmonic.
                let welded = HealthReport::of(shape).welded;
                let (pieces, vertices) = (welded.topology.components, welded.vertices);
                // One more than the constants shows that none of these is missing.
                let harmonics = k0.max(2).saturating_add(pieces.saturating_sub(1));
                if harmonics > vertices {
                    return Err(HarmonicsError::BadHarmonicCount { harmonics, vertices }.into());
                }
                let body = Body::build(shape, &BasisSettings::new(harmonics), task)?;
                alone(Ok(self_low_passed(&body, &shape.positions, k0)?))
            }
        }
    }

    fn names(&self) -> String {
        match &self.template {
            Some(template) => format!("{} and {}", self.shape.display(), template.display()),
            None => self.shape.display().to_string(),
        }
    }
}

fn save(path: &Path, found: &Correspondence) -> std::io::Result<()> {
    let n = found.vertices() as u64;
    write_npz(path, |npz| {
        if let Some(on) = &found.on_template {
            npz.array("triangle", &[n], on.iter().map(|on| on.triangle))?;
            npz.array("barycentric", &[n, 3], on.iter().flat_map(|on| on.weights))?;
        }
        npz.array("point", &[n, 3], found.point.iter().flatten().copied())?;
        npz.array("confidence", &[n], found.confidence.iter().copied())?;
        npz.array("similarity", &[4, 4], found.similarity.to_matrix().into_iter().flatten())
    })
}

/// Confidence on the shape beside the shape at μ = 1, colored by where on the shape it came from.
fn draw(
    path: &Path,
    name: &str,
    shape: &TriMesh,
    found: &Correspondence,
    terminal: &Terminal,
) -> Result<(), Error> {
    let (rest, laid) = (single(&shape.positions), single(&found.target));
    let confidence: Vec<f32> = found.confidence.iter().map(|c| *c as f32).collect();
    let colors = place_colors(&shape.positions);
    let triangles = &drawn_triangles(shape);
    let shown = |positions| PictureShape { positions, triangles, ..PictureShape::default() };
    let shapes = [
        PictureShape {
            values: Some((&confidence, Scale { map: ColorMap::Viridis, low: 0.0, high: 1.0 })),
            ..shown(&rest)
        },
        PictureShape { colors: Some(&colors), ..shown(&rest) },
        PictureShape { colors: Some(&colors), ..shown(&laid) },
        shown(&laid),
    ];
    let device = terminal.device()?;
    let stands = Stance::default().of(name, shape, None, None, terminal)?;
    let from = Camera::on(stands, View::ThreeQuarter);
    let request = PictureRequest { shapes: &shapes, width: 1600, height: 500, from, style: Style::default() };
    let png = render_picture(&device, &request).and_then(|picture| picture.to_png())?;
    write_file(path, &png)
}

fn lines(report: &MatchReport, seconds: f64) -> Vec<String> {
    let mut lines = Vec::new();
    let mut row = |name: &str, value: String| lines.push(format!("{name:<22} {value}"));
    row("median distance", format!("{:.3} % of the diagonal", 100.0 * report.median_distance));
    row("p95 distance", format!("{:.3} % of the diagonal", 100.0 * report.p95_distance));
    if let (Some(median), Some(p95)) = (report.residual_median, report.residual_p95) {
        row("residual", format!("{:.3} % of the diagonal (p95 {:.3} %)", 100.0 * median, 100.0 * p95));
    }
    row("coverage", format!("{:.1} % of the area", 100.0 * report.coverage));
    row("mean confidence", format!("{:.3}", report.mean_confidence));
    row("flipped triangles", format!("{} of {}", report.flipped_triangles, report.triangles));
    row("stretch (median)", format!("{:.3}", report.stretch));
    row("strongly stretched", format!("{} of {}", report.strongly_stretched, report.triangles));
    if let Some(misfit) = report.misfit {
        let second = report.runner_up_misfit.map_or(String::new(), |m| format!(" (next pose {m:.3})"));
        row("misfit", format!("{misfit:.3}{second}"));
        row("near tie", if report.near_tie { "yes" } else { "no" }.into());
    }
    row("seconds", format!("{seconds:.2}"));
    lines
}
