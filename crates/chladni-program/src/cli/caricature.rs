//! `chladni caricature SHAPE TEMPLATE -o OUT`: exaggerate what makes a shape differ from a
//! template, or play a whole recipe on one or many shapes.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use chladni_caricature::{Base, Crossings, DEFAULT_HARMONICS, Project, ShapeSource, Stack, Template};
use chladni_mesh::{Format, TriMesh};
use chladni_view::FilmFormat;

use super::Terminal;
use super::gallery::GalleryOptions;
use super::ink::{InkOptions, check_drawing};
use super::layer_options::LayerOptions;
use super::portrait::{self, Portrait};
use super::region::RegionOptions;
use super::sheet::SheetOptions;
use super::turntable::TurntableOptions;
use crate::work::body::{self, laplacian};
use crate::work::outputs::{check_file, check_picture};
use crate::work::{Error, Made, Sculpture, Share, Warning, Watcher, make, settled, sitter, source};

/// Exaggerate what makes a shape differ from a template.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("picture").args(["render", "turntable"]).multiple(true))]
pub struct Caricature {
    /// The shape: a mesh file or sample:NAME. With --recipe it replaces the recipe's own.
    #[arg(required_unless_present = "recipe")]
    shape: Option<String>,
    /// What it is compared with: a mesh file, sample:NAME, ellipsoid, sphere, a given one
    /// (sphere:x,y,z,radius, ellipsoid:x,y,z,a,b,c and, turned, three angles), self:scale=0.9 or self:lowpass=20.
    #[arg(required_unless_present_any = ["recipe", "gallery"], conflicts_with = "recipe")]
    template: Option<Template>,
    /// Where the result goes: .obj, .ply, .stl or .glb (with a slider per layer). With --batch a
    /// folder. May be left out where --render or --turntable draws.
    #[arg(short, long, value_name = "OUT", required_unless_present = "picture")]
    output: Option<PathBuf>,
    /// K, the number of harmonics [default: 512].
    #[arg(short = 'k', long, value_name = "K", conflicts_with = "recipe")]
    harmonics: Option<usize>,
    /// Paper mode: the plain cotangent Laplacian, which not every mesh can have, and the settings that
    /// the paper prints (sharp cut of the region at 96, every scale alike, μ = -0.8 or -8).
    #[arg(long, conflicts_with = "recipe")]
    paper: bool,
    /// Hold the exaggeration back where it would fold the surface or pass it through itself, and carry detail along
    /// with what it sits on. Of a recipe, too.
    #[arg(long)]
    keep_triangles: bool,
    #[command(flatten)]
    layer: LayerOptions,
    #[command(flatten)]
    region: RegionOptions,
    #[command(flatten)]
    gallery: GalleryOptions,
    /// Draw the shape before and after, side by side: a PNG, or, in ink, an SVG. With --batch a folder.
    #[arg(long, value_name = "P.png|P.svg")]
    render: Option<PathBuf>,
    #[command(flatten)]
    portrait: Portrait,
    #[command(flatten)]
    turntable: TurntableOptions,
    #[command(flatten)]
    sheet: SheetOptions,
    #[command(flatten)]
    ink: InkOptions,
    /// A project whose layers are applied instead.
    #[arg(long, value_name = "P.chladni", conflicts_with_all = ["LayerOptions", "RegionOptions"])]
    recipe: Option<PathBuf>,
    /// Apply the recipe to every mesh in this folder, or to those that a text file lists, one in each line.
    #[arg(long, value_name = "DIR|LIST", requires = "recipe", conflicts_with = "shape")]
    batch: Option<PathBuf>,
    /// Of the meshes of --batch, only piece I of N, in order of name: what many machines share (docs/scale.md).
    #[arg(long, value_name = "I/N", requires = "batch")]
    piece: Option<Share>,
    /// Leave results of --batch that are there already, which are whole or missing.
    #[arg(long, requires = "batch")]
    resume: bool,
}

impl Caricature {
    /// Makes what was asked for.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        if self.gallery.gallery {
            return self.gallery(terminal);
        }
        let Some(recipe) = &self.recipe else { return self.single(terminal) };
        let mut project = source::project(recipe, terminal)?;
        project.keep_triangles |= self.keep_triangles;
        match (&self.batch, &self.shape) {
            (Some(folder), _) => self.batch(&project, folder, terminal),
            (None, Some(shape)) => {
                self.check()?;
                let from = source::shape(&project.shape, terminal)?;
                one(
                    shape,
                    &project,
                    Some(&from),
                    self.output.as_deref(),
                    self.pictures(self.render.as_deref()),
                    terminal,
                )
            }
            (None, None) => {
                self.check()?;
                let shape = project.shape.to_string();
                one(
                    &shape,
                    &project,
                    None,
                    self.output.as_deref(),
                    self.pictures(self.render.as_deref()),
                    terminal,
                )
            }
        }
    }

    /// Checks, before any work, that the results can be written.
    fn check(&self) -> Result<(), Error> {
        if let Some(output) = &self.output {
            format_of(output)?;
            check_file(output)?;
        }
        self.portrait.check()?;
        if let Some(film) = &self.turntable.turntable {
            FilmFormat::of(film).map_err(Error::input)?;
        }
        self.render.as_deref().map_or(Ok(()), check_drawing)
    }

    fn pictures<'a>(&'a self, path: Option<&'a Path>) -> Pictures<'a> {
        let Self { portrait, sheet, ink, turntable, .. } = self;
        Pictures { path, turntable, portrait, sheet, ink }
    }

    fn single(&self, terminal: &Terminal) -> Result<(), Error> {
        let (Some(shape), Some(template)) = (&self.shape, &self.template) else {
            return Err(Error::input("a shape and a template are needed"));
        };
        self.check()?;
        if self.harmonics == Some(0) {
            return Err(Error::input("the number of harmonics must be 1 or more"));
        }
        let source: ShapeSource = shape.parse()?;
        let mut project = Project::new(source, self.harmonics.unwrap_or(DEFAULT_HARMONICS));
        project.laplacian = laplacian(self.paper);
        project.keep_triangles = self.keep_triangles;
        let painted = self.region.painted(shape, || source::mesh(shape, terminal), terminal)?;
        let layer = self.layer.layer("caricature", template.clone(), painted, &project)?;
        project.push(layer)?;
        one(shape, &project, None, self.output.as_deref(), self.pictures(self.render.as_deref()), terminal)
    }

    /// A sheet of twelve caricatures, or one of them as a mesh.
    fn gallery(&self, terminal: &Terminal) -> Result<(), Error> {
        let (Some(shape), Some(output)) = (&self.shape, &self.output) else {
            return Err(Error::input("a shape and where the sheet goes (-o sheet.png) are needed"));
        };
        self.portrait.check()?;
        if self.gallery.is_single() {
            format_of(output)?;
            check_file(output)?;
        } else {
            check_picture(output)?;
        }
        let mesh = Arc::new(source::mesh(shape, terminal)?);
        let (harmonics, laplacian) = (self.harmonics.unwrap_or(DEFAULT_HARMONICS), laplacian(self.paper));
        let (body, _) = body::build(shape, &mesh, harmonics, laplacian, terminal)?;
        let mut project = Project::new(shape.parse()?, harmonics);
        (project.laplacian, project.keep_triangles) = (laplacian, self.keep_triangles);
        let body = Arc::new(body);
        let mut stack = Stack::new(body.clone())?;
        let given = self.template.clone().map(|template| Ok::<_, Error>((template, self.layer.matching()?)));
        let sitter = sitter(&mesh, &mut stack, given.transpose()?, terminal)?;
        if self.gallery.is_single() {
            for layer in self.gallery.single(&sitter, self.layer.seed(), terminal)? {
                project.push(layer)?;
            }
            let evaluation = settled(&mut stack, &project, terminal)?;
            let source = project.shape.clone();
            return save(&Sculpture { source, mesh, body, evaluation }, output, terminal);
        }
        let from = self.portrait.camera(shape, &mesh, None, None, terminal)?;
        self.gallery.sheet(&sitter, self.layer.seed(), (from, self.portrait.size), output, terminal)?;
        terminal.wrote(output)
    }

    /// Every mesh of `batch`, or the piece of it that is asked for. One that fails does not stop the others.
    fn batch(&self, project: &Project, batch: &Path, terminal: &Terminal) -> Result<(), Error> {
        let Some(results) = &self.output else {
            return Err(Error::input("--batch needs a folder for the results: -o"));
        };
        let shapes = if batch.is_dir() { meshes_in(batch)? } else { meshes_listed(batch)? };
        // Whether results would collide depends on all of them, whichever of them are made here.
        let planned = self.planned(results, &shapes)?;
        let piece = self.piece.map_or(0..shapes.len() as u64, |piece| piece.range(shapes.len() as u64));
        let piece = piece.start as usize..piece.end as usize;
        let (shapes, planned) = (&shapes[piece.clone()], &planned[piece]);
        let from = source::shape(&project.shape, terminal)?;
        for out in [Some(results), self.render.as_ref()].into_iter().flatten() {
            std::fs::create_dir_all(out).map_err(|error| Error::unwritten(out, error))?;
        }
        let (mut failed, mut kept) = (0, 0);
        for (shape, (output, render)) in shapes.iter().zip(planned) {
            terminal.task().check()?;
            if self.resume && output.is_file() && render.as_ref().is_none_or(|render| render.is_file()) {
                kept += 1;
                continue;
            }
            let name = shape.display().to_string();
            match one(&name, project, Some(&from), Some(output), self.pictures(render.as_deref()), terminal) {
                Ok(()) => {}
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(failure) => {
                    failed += 1;
                    match failure.to_string() {
                        message if message.starts_with(&name) => terminal.warn(Warning::Plain(message)),
                        message => terminal.warn(Warning::of(&name, message)),
                    }
                }
            }
        }
        if kept > 0 {
            terminal.note(format_args!("{kept} of {} results were there already", shapes.len()));
        }
        match failed {
            0 => Ok(()),
            _ => Err(Error::input(format_args!("{failed} of {} shapes failed", shapes.len()))),
        }
    }

    /// The mesh in `results` and the picture that each of `shapes` becomes; refused where one would replace another or
    /// a shape.
    fn planned(&self, results: &Path, shapes: &[PathBuf]) -> Result<Vec<(PathBuf, Option<PathBuf>)>, Error> {
        let real = |path: &Path| {
            let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
            std::fs::canonicalize(path).ok()
        };
        let output = real(results);
        let folders: HashSet<&Path> = shapes.iter().filter_map(|shape| shape.parent()).collect();
        if let Some(folder) = folders.into_iter().find(|folder| output.is_some() && real(folder) == output) {
            let folder = folder.display();
            return Err(Error::input(format_args!("{folder}: results there would replace the shapes")));
        }
        let mut owners: HashMap<PathBuf, &Path> = HashMap::new();
        let mut planned = Vec::with_capacity(shapes.len());
        for shape in shapes {
            let stem = shape.file_stem().unwrap_or_default();
            // A format that can be written is kept; the others become PLY, which keeps every digit.
            let extension = match format_of(shape) {
                Ok(_) => shape.extension().unwrap_or_default(),
                Err(_) => "ply".as_ref(),
            };
            let output = named(results, stem, extension);
            let render = self.render.as_ref().map(|folder| named(folder, stem, "png".as_ref()));
            for path in std::iter::once(&output).chain(&render) {
                if let Some(other) = owners.insert(path.clone(), shape) {
                    let (path, other, shape) = (path.display(), other.display(), shape.display());
                    return Err(Error::input(format_args!("{other} and {shape} would both become {path}")));
                }
            }
            planned.push((output, render));
        }
        Ok(planned)
    }
}

/// `STEM.EXTENSION` in `folder`; the stem may hold dots.
fn named(folder: &Path, stem: &OsStr, extension: &OsStr) -> PathBuf {
    let mut name = stem.to_owned();
    name.push(".");
    name.push(extension);
    folder.join(name)
}

/// The pictures that are asked for.
#[derive(Clone, Copy)]
struct Pictures<'a> {
    path: Option<&'a Path>,
    turntable: &'a TurntableOptions,
    portrait: &'a Portrait,
    sheet: &'a SheetOptions,
    ink: &'a InkOptions,
}

/// Writes the mesh and says what did not come along.
fn save(sculpture: &Sculpture, output: &Path, terminal: &Terminal) -> Result<(), Error> {
    if let Some(warning) = sculpture.save(output)? {
        terminal.warn(warning);
    }
    terminal.wrote(output)
}

/// One shape, from its name to its files. `from` is the recipe's own shape where this is another:
/// regions and landmarks are carried over.
fn one(
    shape: &str,
    project: &Project,
    from: Option<&TriMesh>,
    output: Option<&Path>,
    pictures: Pictures<'_>,
    terminal: &Terminal,
) -> Result<(), Error> {
    let mesh = source::mesh(shape, terminal)?;
    // Another shape need not stand as the project's own does.
    let kept = project.stands.filter(|_| from.is_none());
    let carried = from.map(|from| carry(project, from, shape, &mesh, terminal)).transpose()?;
    let project = carried.as_ref().unwrap_or(project);
    let (body, _) = body::build(shape, &mesh, project.harmonics, project.laplacian, terminal)?;
    let mut made = make(mesh, Arc::new(body), project, false, terminal)?;
    made.sculpture.source = shape.parse()?;
    describe(&made, terminal)?;
    if let Some(output) = output {
        save(&made.sculpture, output, terminal)?;
    }
    let Pictures { path, turntable, portrait, sheet, ink } = pictures;
    if let Some(path) = path {
        portrait::render(&mut made, shape, project, path, portrait, sheet, ink, kept, terminal)?;
        terminal.wrote(path)?;
    }
    if let Some(path) = &turntable.turntable {
        let from = portrait.camera(shape, &made.sculpture.mesh, kept, made.stands, terminal)?;
        turntable.film(path, &made.sculpture, from, portrait.size, ink, terminal)?;
        terminal.wrote(path)?;
    }
    Ok(())
}

/// Prints for every acting layer how far it moves the shape and what it folds.
fn describe(made: &Made, terminal: &Terminal) -> Result<(), Error> {
    let Made { sculpture, stack, .. } = made;
    for layer in &sculpture.evaluation.layers {
        let Some(displacement) = &layer.displacement else {
            terminal.result(format_args!("{}: off", layer.name))?;
            continue;
        };
        let farthest = displacement.iter().map(|d| d[0].hypot(d[1]).hypot(d[2])).fold(0.0, f64::max);
        let folded = layer.folds(stack.surface());
        let name = &layer.name;
        let by = farthest / sculpture.body.frame.scale;
        terminal.result(format_args!("{name}: moves up to {by:.4} units, {folded} triangles folded"))?;
        if let Some(kept) = &layer.kept {
            let (share, crossing) = (100.0 * kept.share, kept.crossing);
            terminal.result(format_args!(
                "{name}: keeps {share:.0} % of its movement, {crossing} triangles newly crossing"
            ))?;
        }
    }
    let crossings = Crossings::of(stack.surface().clone());
    let crossing = |base: &Base| {
        let found = terminal.watch("counting crossings", |task| crossings.triangles(&base.positions, task));
        found.map(|found| found.len())
    };
    let (now, before) = (crossing(&sculpture.evaluation.result)?, crossing(stack.original())?);
    terminal.result(format_args!("{now} triangles pass through others ({before} did before)"))
}

/// The format of `path`, if it is one that results are written in.
fn format_of(path: &Path) -> Result<Format, Error> {
    match Format::of_path(path) {
        Some(format @ (Format::Obj | Format::Ply | Format::Stl | Format::Glb)) => Ok(format),
        _ => {
            Err(Error::input(format_args!("{}: results are written as obj, ply, stl or glb", path.display())))
        }
    }
}

/// The recipe for `mesh`, which is called `name`; warns if the two shapes hardly match.
fn carry(
    project: &Project,
    from: &TriMesh,
    name: &str,
    mesh: &TriMesh,
    terminal: &Terminal,
) -> Result<Project, Error> {
    let carried = terminal.watch("carrying regions over", |task| project.carried(from, mesh, task));
    let carried = carried.map_err(|error| Error::from(error).of(name))?;
    for warning in carried.report.iter().flat_map(|report| &report.warnings) {
        terminal.warn(Warning::of(format_args!("{name}, matched with {}", project.shape), warning));
    }
    Ok(carried.project)
}

/// The largest list of meshes that is read.
const MOST_BYTES: u64 = 64 << 20;

/// The meshes that a text file names, in its order; empty lines are left out.
fn meshes_listed(list: &Path) -> Result<Vec<PathBuf>, Error> {
    let text = chladni_task::read_text_file(list, MOST_BYTES);
    let text = text.map_err(|error| Error::input(format_args!("{}: {error}", list.display())))?;
    let meshes: Vec<PathBuf> =
        text.lines().map(str::trim).filter(|line| !line.is_empty()).map(PathBuf::from).collect();
    if meshes.is_empty() {
        return Err(Error::input(format_args!("{}: lists no mesh", list.display())));
    }
    Ok(meshes)
}

fn meshes_in(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |error| Error::input(format_args!("{}: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let is_mesh = |path: &PathBuf| path.is_file() && Format::of_path(path).is_some();
    let mut meshes: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_mesh).collect();
    meshes.sort();
    if meshes.is_empty() {
        return Err(Error::input(format_args!("{}: holds no mesh", folder.display())));
    }
    Ok(meshes)
}
