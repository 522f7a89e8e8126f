//! `chladni caricature SHAPE TEMPLATE -o OUT`: exaggerate the difference between a shape and a
//! template, or play a whole recipe on one or many shapes.

mod batch;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use chladni_caricature::{
    Base, Crossings, DEFAULT_HARMONICS, Project, Resolution, ShapeSource, Stack, Template,
};
use chladni_match::MatchSettings;
use chladni_mesh::{Format, TriMesh};
use chladni_task::counted;

pub use self::batch::meshes_listed;
use super::Terminal;
use super::gallery::GalleryOptions;
use super::ink::{InkOptions, check_drawing};
use super::layer_options::LayerOptions;
use super::movement::say_movement;
use super::portrait::{self, Portrait};
use super::region::RegionOptions;
use super::resolution::ResolutionOptions;
use super::sheet::SheetOptions;
use super::turntable::TurntableOptions;
use crate::work::body::{self, laplacian};
use crate::work::outputs::{
    check_distinct, check_film, check_fits, check_mesh, check_picture, check_textures,
};
use crate::work::{
    Error, FIRST_SEED, Made, OwnLook, Sculpture, Share, Subject, Warning, Watcher, check_template,
    check_templates, make, settled, sitter, source,
};

/// Exaggerate what makes a shape differ from a template.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("picture").args(["render", "turntable"]).multiple(true))]
#[command(group = clap::ArgGroup::new("result").args(["output", "render", "turntable"]).multiple(true).required(true))]
pub struct Caricature {
    /// The shape: a mesh file or sample:NAME. With --recipe it replaces the recipe's own.
    #[arg(required_unless_present = "recipe")]
    shape: Option<PathBuf>,
    /// The template, to compare it with: a mesh file, sample:NAME, ellipsoid, sphere, a given one
    /// (sphere:x,y,z,radius, ellipsoid:x,y,z,a,b,c and, turned, three angles), self:scale=0.9 or self:lowpass=20.
    #[arg(required_unless_present_any = ["recipe", "gallery", "choose", "variant", "surprise"],
        conflicts_with = "recipe")]
    template: Option<Template>,
    /// Where the result goes: .obj, .ply, .stl or .glb (with a slider per layer). With --batch a
    /// folder. May be left out where --render or --turntable draws, but not with --batch.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// K, the number of harmonics [default: 512].
    #[arg(short = 'k', long, value_name = "K", conflicts_with = "recipe")]
    harmonics: Option<usize>,
    /// Paper mode: the plain cotangent Laplacian, which not every mesh can have, and the settings that
    /// the paper prints (sharp cut of the region at about 96, every scale alike, μ = -0.8 or -8); with --gallery
    /// the Laplacian alone.
    #[arg(long, conflicts_with = "recipe")]
    paper: bool,
    #[command(flatten)]
    resolution: ResolutionOptions,
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
    /// Apply the recipe to every mesh in this folder, or to those that a text file lists, one in each line that does not
    /// begin with #: as seen from the current folder, or else from that of the list.
    #[arg(long, value_name = "DIR|LIST", requires = "recipe", conflicts_with = "shape")]
    batch: Option<PathBuf>,
    /// Of the meshes of --batch, only piece I of N, in order of name or of the list: what many machines share
    /// (docs/scale.md).
    #[arg(long, value_name = "I/N", requires = "batch")]
    piece: Option<Share>,
    /// Leave results of --batch that are there already, which are whole or missing.
    #[arg(long, requires = "batch")]
    resume: bool,
}

impl Caricature {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.check_options()?;
        if self.gallery.gallery {
            return self.gallery(terminal);
        }
        let Some(recipe) = &self.recipe else { return self.single(terminal) };
        let mut project = source::project(recipe, terminal)?;
        check_templates(&project, terminal)?;
        project.keep_triangles |= self.keep_triangles;
        match (&self.batch, &self.shape) {
            (Some(folder), _) => self.batch(project, folder, terminal),
            (None, Some(shape)) => {
                self.check(&project.files())?;
                let from = made_on(&mut project, terminal)?;
                self.one_of(Some(&ShapeSource::named(shape)), &project, from.as_deref(), terminal)
            }
            (None, None) => {
                self.check(&project.files())?;
                if self.resolution.wanted() != Resolution::Usual {
                    return Err(Error::input(
                        "--proxy is for another shape: its own is worked on as the recipe says",
                    ));
                }
                self.one_of(None, &project, None, terminal)
            }
        }
    }

    /// Checks that no option is without effect.
    fn check_options(&self) -> Result<(), Error> {
        // Clap waives what an option requires where that conflicts with what is given.
        if self.batch.is_none() && (self.resume || self.piece.is_some()) {
            return Err(Error::input("--resume and --piece are for --batch"));
        }
        if self.gallery.is_missing() {
            return Err(Error::input("--choose, --variant and --surprise are for --gallery"));
        }
        self.layer.check_for(self.template.as_ref(), self.gallery.gallery)?;
        self.layer.check_edge(self.region.is_given(), self.paper)?;
        let in_ink = self.render.as_deref().is_some_and(|path| self.ink.wanted(path));
        if in_ink && !self.sheet.show.iter().all(|panel| panel.is_plain()) {
            return Err(Error::input(
                "ink draws shapes alone: leave out the panels rest, ghost, painted and region",
            ));
        }
        let draws_sheet = self.gallery.gallery && !self.gallery.is_single();
        if draws_sheet && self.keep_triangles {
            return Err(Error::input(
                "--keep-triangles is for one of the gallery as a mesh: --variant N or --surprise",
            ));
        }
        self.portrait.check_used(draws_sheet || self.render.is_some() || self.turntable.turntable.is_some())
    }

    /// Checks, before any work, that the results can be written, and replace none of the files that are read: those of
    /// the arguments and `of_recipe`.
    fn check(&self, of_recipe: &[&Path]) -> Result<(), Error> {
        if let Some(output) = &self.output {
            check_mesh(output, &[&self.read()[..], of_recipe].concat())?;
        }
        self.portrait.check()?;
        if let Some(film) = &self.turntable.turntable {
            check_film(film, ".gif, .png and folders of pictures")?;
        }
        self.render.as_deref().map_or(Ok(()), check_drawing)?;
        let files = [&self.output, &self.render, &self.turntable.turntable];
        check_distinct(&files.into_iter().flatten().map(PathBuf::as_path).collect::<Vec<_>>())
    }

    /// The meshes that the arguments name.
    fn read(&self) -> Vec<&Path> {
        let template = self.template.as_ref().and_then(Template::file);
        let shape = self.shape.as_deref();
        shape.into_iter().chain(template).chain(self.region.mask_file()).collect()
    }

    fn pictures<'a>(&'a self, path: Option<&'a Path>) -> Pictures<'a> {
        let Self { portrait, sheet, ink, turntable, .. } = self;
        let usual_curve = self.recipe.is_none() && !self.layer.names_curve();
        Pictures { path, turntable, portrait, sheet, usual_curve, ink }
    }

    /// The project that the arguments ask for, without layers.
    fn bare_project(&self, shape: &Path) -> Result<Project, Error> {
        let mut project =
            Project::new(ShapeSource::named(shape), self.harmonics.unwrap_or(DEFAULT_HARMONICS));
        project.laplacian = laplacian(self.paper);
        project.keep_triangles = self.keep_triangles;
        project.resolution = self.resolution.or_all(self.layer.needs_all_vertices())?;
        Ok(project)
    }

    fn single(&self, terminal: &Terminal) -> Result<(), Error> {
        let (Some(shape), Some(template)) = (&self.shape, &self.template) else {
            return Err(Error::input("a shape and a template are needed"));
        };
        self.check(&[])?;
        if self.harmonics == Some(0) {
            return Err(Error::input("the number of harmonics must be 1 or more"));
        }
        check_template(template, terminal)?;
        let mut project = self.bare_project(shape)?;
        let subject = Subject::of(&mut project, terminal)?;
        let painted = self.region.painted(&project.shape.to_string(), &subject, terminal)?;
        let layer =
            self.layer.layer("caricature", template.clone(), painted, &project, &subject, terminal)?;
        project.push(layer)?;
        let pictures = self.pictures(self.render.as_deref());
        finish(&project.shape, subject, &project, self.output.as_deref(), pictures, terminal)
    }

    /// The recipe `project` on one shape, as in [`one`].
    fn one_of(
        &self,
        other: Option<&ShapeSource>,
        project: &Project,
        from: Option<&TriMesh>,
        terminal: &Terminal,
    ) -> Result<(), Error> {
        let (output, pictures) = (self.output.as_deref(), self.pictures(self.render.as_deref()));
        one(other, project, from, self.resolution.wanted(), output, pictures, terminal)
    }

    /// A sheet of twelve caricatures, or one of them as a mesh.
    fn gallery(&self, terminal: &Terminal) -> Result<(), Error> {
        let (Some(shape), Some(output)) = (&self.shape, &self.output) else {
            return Err(Error::input("a shape and where the sheet goes (-o sheet.png) are needed"));
        };
        self.portrait.check()?;
        if self.gallery.is_single() {
            check_mesh(output, &self.read())?;
        } else {
            check_picture(output)?;
        }
        self.template.iter().try_for_each(|template| check_template(template, terminal))?;
        let mut project = self.bare_project(shape)?;
        let name = project.shape.to_string();
        let subject = Subject::of(&mut project, terminal)?;
        let mesh = &subject.mesh;
        let whole = (&project.shape, &**subject.whole());
        check_textures(&[output.as_path()], whole, self.template.iter())?;
        // Without targets: the layers are yet to be chosen.
        check_fits(output, whole, 0)?;
        let (body, _) = body::build(&name, mesh, project.harmonics, project.laplacian, terminal)?;
        let body = Arc::new(body);
        let mut stack = Stack::new(body.clone())?;
        let given = match &self.template {
            Some(template) => {
                // The seed is the gallery's: matched as in the window, the same caricatures come.
                let seed = MatchSettings::default().seed;
                let matching = MatchSettings { seed, ..self.layer.matching(&subject, terminal)? };
                Some((template.clone(), matching))
            }
            None => None,
        };
        let seed = self.layer.seed().unwrap_or(FIRST_SEED);
        let sitter = sitter(mesh, &mut stack, given, terminal)?;
        if self.gallery.is_single() {
            for layer in self.gallery.single(&sitter, seed, terminal)? {
                project.push(layer)?;
            }
            let evaluation = settled(&mut stack, &project, terminal)?;
            let source = project.shape.clone();
            return save(&Sculpture { source, subject, body, evaluation }, output, terminal);
        }
        let from = self.portrait.camera(&name, mesh, None, None, terminal)?;
        self.gallery.sheet(&sitter, seed, (from, self.portrait.size()), output, terminal)?;
        terminal.wrote(output)
    }
}

/// The pictures that are asked for.
#[derive(Clone, Copy)]
struct Pictures<'a> {
    path: Option<&'a Path>,
    turntable: &'a TurntableOptions,
    portrait: &'a Portrait,
    sheet: &'a SheetOptions,
    /// The top layer has the usual scale curve of its μ.
    usual_curve: bool,
    ink: &'a InkOptions,
}

/// Writes the mesh and says what did not come along.
fn save(sculpture: &Sculpture, output: &Path, terminal: &Terminal) -> Result<(), Error> {
    if let Some(warning) = sculpture.save(output, terminal.task())? {
        terminal.warn(warning);
    }
    terminal.wrote(output)
}

/// The shape that `project` was made on, where its layers name places of that: only then has its file to be there.
fn made_on(project: &mut Project, terminal: &Terminal) -> Result<Option<Arc<TriMesh>>, Error> {
    if !project.names_places() {
        return Ok(None);
    }
    Ok(Some(Subject::of(project, terminal)?.mesh))
}

/// One shape, from its name to its files: the recipe's own, or the `other` one, which is worked on as is `wanted`. Places
/// that the layers name are carried over to it from the shape that they were [made on](made_on), `from`.
fn one(
    other: Option<&ShapeSource>,
    project: &Project,
    from: Option<&TriMesh>,
    wanted: Resolution,
    output: Option<&Path>,
    pictures: Pictures<'_>,
    terminal: &Terminal,
) -> Result<(), Error> {
    let mut own = project.clone();
    let Some(shape) = other else {
        let subject = Subject::of(&mut own, terminal)?;
        return finish(&own.shape, subject, &own, output, pictures, terminal);
    };
    // Another shape need not stand as the project's own does.
    (own.shape, own.resolution, own.stands) = (shape.clone(), wanted, None);
    let subject = Subject::before_carrying(source::shape(shape, terminal)?, &mut own, terminal)?;
    if let Some(from) = from {
        own = carry(project, from, &shape.to_string(), &subject.mesh, terminal)?;
    }
    finish(shape, subject, &own, output, pictures, terminal)
}

/// `project` on `subject`, which is called `shape`, to its files.
fn finish(
    shape: &ShapeSource,
    subject: Subject,
    project: &Project,
    output: Option<&Path>,
    pictures: Pictures<'_>,
    terminal: &Terminal,
) -> Result<(), Error> {
    let Pictures { path, turntable, sheet, .. } = pictures;
    let templates = project.layers().iter().map(|(_, layer)| &layer.template);
    let paths: Vec<&Path> = path.into_iter().chain(turntable.turntable.as_deref()).collect();
    check_textures(&paths, (shape, subject.whole()), templates)?;
    if let Some(output) = output {
        check_fits(output, (shape, subject.whole()), project.acting().count())?;
    }
    let name = shape.to_string();
    let (body, _) = body::build(&name, &subject.mesh, project.harmonics, project.laplacian, terminal)?;
    let mut made = make(subject, Arc::new(body), project, false, terminal)?;
    made.sculpture.source = shape.clone();
    // A sweep draws other results, which are described as they are made.
    if output.is_some() || turntable.turntable.is_some() || sheet.sweep.is_empty() {
        describe(&made, terminal)?;
    }
    // An OBJ comes last: its textures take names that the pictures have left free.
    let is_last = output.is_some_and(|output| Format::of_path(output) == Some(Format::Obj));
    let save = |sculpture: &Sculpture, now: bool| match output {
        Some(output) if now => save(sculpture, output, terminal),
        _ => Ok(()),
    };
    save(&made.sculpture, !is_last)?;
    // A picture that fails does not take the mesh with it.
    let drawn = draw(&mut made, &name, project, pictures, terminal);
    save(&made.sculpture, is_last)?;
    drawn
}

/// Draws the pictures of `made`, whose shape is called `name`.
fn draw(
    made: &mut Made,
    name: &str,
    project: &Project,
    pictures: Pictures<'_>,
    terminal: &Terminal,
) -> Result<(), Error> {
    let Pictures { path, turntable, portrait, sheet, usual_curve, ink } = pictures;
    if path.is_none() && turntable.turntable.is_none() {
        return Ok(());
    }
    // Ink has colors of its own.
    let is_colored =
        path.is_some_and(|path| !ink.wanted(path)) || (turntable.turntable.is_some() && !ink.is_asked_for());
    let Sculpture { subject, body, .. } = &made.sculpture;
    let look = if is_colored { OwnLook::of_subject(name, subject, body, terminal) } else { None };
    let look = look.as_ref();
    // One for both: doubts about how the shape stands are said once.
    let from = portrait.camera(name, &subject.mesh, project.stands, made.stands, terminal)?;
    let size = portrait.size();
    if let Some(path) = path {
        let sheet = (sheet, usual_curve);
        portrait::render(made, look, project, path, (from, size), sheet, ink, terminal)?;
        terminal.wrote(path)?;
    }
    if let Some(path) = &turntable.turntable {
        turntable.film(path, &made.sculpture, look, from, size, ink, terminal)?;
        terminal.wrote(path)?;
    }
    Ok(())
}

/// Prints for every acting layer how far it moves the shape and how many triangles it folds.
fn describe(made: &Made, terminal: &Terminal) -> Result<(), Error> {
    let Made { sculpture, stack, .. } = made;
    for layer in &sculpture.evaluation.layers {
        say_movement(&layer.name, layer, stack, terminal)?;
    }
    let crossings = Crossings::of(stack.surface().clone());
    let crossing = |base: &Base| {
        let found = terminal.watch("counting crossings", |task| crossings.triangles(&base.positions, task));
        found.map(|found| found.len())
    };
    let (now, before) = (crossing(&sculpture.evaluation.result)?, crossing(stack.original())?);
    let now = counted(now, "triangle passes", "triangles pass");
    terminal.result(format_args!("{now} through others ({before} did before)"))
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
