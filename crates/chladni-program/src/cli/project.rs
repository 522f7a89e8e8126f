//! `chladni project`: make, change and read caricature projects without the window.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use chladni_caricature::{DEFAULT_HARMONICS, Layer, Painted, Project, Resolution, ShapeSource, Template};
use chladni_harmonics::{Laplacian, Operator};
use chladni_mesh::Orientation;
use chladni_task::{alone, counted};
use serde::Serialize;

use super::Terminal;
use super::layer_options::LayerOptions;
use super::region::RegionOptions;
use super::resolution::ResolutionOptions;
use super::stance::StanceOptions;
use crate::work::body::laplacian;
use crate::work::outputs::check_file;
use crate::work::{Error, Stance, Subject, Warning, Watcher, mask, source, template_mesh};

/// Make, change and read caricature projects.
#[derive(clap::Subcommand)]
pub enum ProjectCommand {
    /// Start a project on a shape.
    New(New),
    /// Put a layer on top.
    AddLayer(Box<AddLayer>),
    /// Tell what is in a project.
    Show(Show),
}

/// Arguments of `project new`.
#[derive(clap::Args)]
pub struct New {
    /// The shape: a mesh file or sample:NAME.
    shape: PathBuf,
    /// The project file; must end in .chladni and not exist yet.
    #[arg(short, long, value_name = "P.chladni")]
    output: PathBuf,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = DEFAULT_HARMONICS)]
    harmonics: usize,
    #[command(flatten)]
    resolution: ResolutionOptions,
    #[command(flatten)]
    stance: StanceOptions,
    /// Paper mode: the papers' plain cotangent Laplacian, which not every mesh can have; its layers
    /// begin with the caricature paper's settings.
    #[arg(long)]
    paper: bool,
    /// Hold layers back where they would fold the surface or pass it through itself.
    #[arg(long)]
    keep_triangles: bool,
}

/// Arguments of `project add-layer`.
#[derive(clap::Args)]
pub struct AddLayer {
    /// The project file.
    project: PathBuf,
    /// The template, to compare the shape with: a mesh file, sample:NAME, ellipsoid, sphere, a given one
    /// (sphere:x,y,z,radius, ellipsoid:x,y,z,a,b,c and, turned, three angles), self:scale=0.9 (magnifies all),
    /// self:lowpass=20, self:original (magnifies the layers below) or self:layer=2 (the shape after the second layer from
    /// below: magnifies those above it).
    #[arg(long)]
    template: Template,
    /// The layer's name; its template's where none is given.
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    layer: LayerOptions,
    #[command(flatten)]
    region: RegionOptions,
}

/// Arguments of `project show`.
#[derive(clap::Args)]
pub struct Show {
    /// The project file.
    project: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl ProjectCommand {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        match self {
            Self::New(new) => new.run(terminal),
            Self::AddLayer(add) => add.run(terminal),
            Self::Show(show) => show.run(terminal),
        }
    }
}

impl New {
    fn run(self, terminal: &Terminal) -> Result<(), Error> {
        if self.output.extension().is_none_or(|e| e != "chladni") {
            return Err(Error::input(format_args!("{}: a project ends in .chladni", self.output.display())));
        }
        if self.output.exists() {
            return Err(exists_already(&self.output));
        }
        check_file(&self.output)?;
        if self.harmonics == 0 {
            return Err(Error::input("the number of harmonics must be 1 or more"));
        }
        // Refuse a shape that cannot be read before making a project on it.
        let stance = Stance::from(self.stance);
        stance.check()?;
        let shape = ShapeSource::named(&self.shape);
        let name = shape.to_string();
        let mut project = Project::new(shape, self.harmonics);
        project.resolution = self.resolution.wanted();
        let mesh = Subject::of(&mut project, terminal)?.mesh;
        if stance.is_given() {
            project.stands = Some(stance.of(&name, &mesh, None, None, terminal)?);
        }
        project.laplacian = laplacian(self.paper);
        project.keep_triangles = self.keep_triangles;
        if self.paper {
            // Reported now rather than with the first layer.
            Operator::with(&mesh, project.laplacian).map_err(|error| Error::from(error).of(&name))?;
        }
        save_new(&project, &self.output)?;
        terminal.warn_each(source::far(&self.output, &project));
        terminal.wrote(&self.output)
    }
}

impl AddLayer {
    fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.layer.check_for(Some(&self.template), false)?;
        let mut project = source::project_alone(&self.project, terminal)?;
        project.check_near(&self.project, |file| terminal.knows(&self.project, file))?;
        let before = project.clone();
        self.layer.check_clamp(project.laplacian == Laplacian::Cotangent)?;
        template_mesh(&self.template, terminal)?;
        let name = self.name.clone().unwrap_or_else(|| own_name(&self.template));
        let shape = project.shape.to_string();
        let needs_all = self.layer.needs_all_vertices();
        if needs_all && matches!(project.resolution, Resolution::Proxy(_)) {
            if project.names_vertices() {
                return Err(Error::input(format_args!(
                    "{}: is worked on with a part of its vertices, and --match same needs all: begin anew with --proxy 0",
                    self.project.display()
                )));
            }
            project.resolution = Resolution::Whole;
        }
        let subject = if needs_all {
            Subject::whole_of(&mut project, terminal)?
        } else {
            Subject::of(&mut project, terminal)?
        };
        let painted = self.region.painted(&shape, &subject, terminal)?;
        if mask::is_empty(&painted, &subject) {
            terminal.warn(Warning::empty_region(Some(&name), &subject.mesh));
        }
        let layer = self.layer.layer(&name, self.template, painted, &project, &subject, terminal)?;
        project.push(layer)?;
        save_over(&before, &project, &self.project)?;
        terminal.warn_each(source::far(&self.project, &project));
        let layers = counted(project.layers().len(), "layer", "layers");
        terminal.result(format_args!("{} has {layers}", self.project.display()))
    }
}

/// Saves a project where nothing is yet, nor has come there while its shape was read.
fn save_new(project: &Project, path: &Path) -> Result<(), Error> {
    let text = project.to_text(path, None).map_err(Error::unsaved)?;
    chladni_task::write_new(path, text.as_bytes()).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => exists_already(path),
        _ => Error::unwritten(path, error),
    })
}

/// The refusal of a place where a file is: hours of painting may be in it.
fn exists_already(path: &Path) -> Error {
    Error::input(format_args!("{}: exists already", path.display()))
}

/// Saves `project` at `path` in the place of the one that was `read` there.
fn save_over(read: &Project, project: &Project, path: &Path) -> Result<(), Error> {
    alone(path, || {
        check_unchanged(path, read)?;
        project.save(path).map_err(Error::unsaved)
    })
}

/// Checks that the file at `path` still holds the project that was `read`: a window may have saved its work meanwhile.
fn check_unchanged(path: &Path, read: &Project) -> Result<(), Error> {
    if Project::read(path)? == *read {
        return Ok(());
    }
    Err(Error::input(format_args!("{}: has changed meanwhile; run this again", path.display())))
}

fn own_name(template: &Template) -> String {
    match template {
        Template::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        other => other.to_string(),
    }
}

/// The output of `show --json`.
#[derive(Serialize)]
struct Shown {
    format_version: i64,
    shape: String,
    harmonics: usize,
    laplacian: Laplacian,
    keep_triangles: bool,
    /// About how many vertices it is worked on with, 0 for always all; `None` where that is as usual.
    proxy: Option<usize>,
    /// How it stands, where that was set by hand.
    stands: Option<Orientation>,
    layers: Vec<ShownLayer>,
}

#[derive(Serialize)]
struct ShownLayer {
    name: String,
    template: String,
    model: String,
    mu: f64,
    strength: f64,
    enabled: bool,
    solo: bool,
    /// Whether it is enabled, and soloed where any layer is.
    acts: bool,
    /// `everywhere`, `spheres` or `painted`.
    region: &'static str,
    spheres: Vec<String>,
    painted_vertices: Option<usize>,
    wavelength: f64,
    roll_off: chladni_caricature::RollOff,
    clamp: bool,
    scale_curve: chladni_caricature::ScaleCurve,
    #[serde(rename = "match")]
    matching: chladni_match::MatchSettings,
    infill: f64,
}

impl ShownLayer {
    fn of(layer: &Layer, project: &Project) -> Self {
        let (region, spheres, painted_vertices) = match &layer.region.painted {
            Painted::Everywhere => ("everywhere", Vec::new(), None),
            Painted::Spheres(spheres) => ("spheres", spheres.iter().map(ToString::to_string).collect(), None),
            Painted::Vertices(values) => {
                ("painted", Vec::new(), Some(values.iter().filter(|x| **x > 0.0).count()))
            }
        };
        let smoothing = layer.region.smoothing;
        Self {
            name: layer.name.clone(),
            template: layer.template.to_string(),
            model: layer.model.to_string(),
            mu: layer.mu,
            strength: layer.strength,
            enabled: layer.enabled,
            solo: layer.solo,
            acts: project.acts(layer),
            region,
            spheres,
            painted_vertices,
            wavelength: smoothing.wavelength,
            roll_off: smoothing.roll_off,
            clamp: smoothing.clamp,
            scale_curve: layer.curve.clone(),
            matching: layer.matching.clone(),
            infill: layer.infill,
        }
    }
}

impl Show {
    fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let project = source::project_alone(&self.project, terminal)?;
        let shown = Shown {
            format_version: project.format_version(),
            shape: project.shape.to_string(),
            harmonics: project.harmonics,
            laplacian: project.laplacian,
            keep_triangles: project.keep_triangles,
            proxy: match &project.resolution {
                Resolution::Usual => None,
                Resolution::Whole => Some(0),
                Resolution::Proxy(key) => Some(key.vertices),
            },
            stands: project.stands,
            layers: project.layers().iter().map(|(_, l)| ShownLayer::of(l, &project)).collect(),
        };
        if self.json {
            return terminal.json(&shown);
        }
        let Shown { shape, laplacian, .. } = &shown;
        let harmonics = counted(shown.harmonics, "harmonic", "harmonics");
        let keeps = if shown.keep_triangles { ", keeps triangles" } else { "" };
        let proxy = match shown.proxy {
            None => String::new(),
            Some(0) => ", all of its vertices".to_owned(),
            Some(vertices) => format!(", about {vertices} of its vertices"),
        };
        let stands = shown.stands.map_or_else(String::new, |stands| format!(", {stands}"));
        terminal.result(format_args!(
            "{shape}, {harmonics} of the {laplacian} Laplacian{keeps}{proxy}{stands}"
        ))?;
        for (i, layer) in shown.layers.iter().enumerate() {
            let (off, solo) = (if layer.acts { "" } else { ", off" }, if layer.solo { ", solo" } else { "" });
            let ShownLayer { name, template, model, mu, region, .. } = layer;
            terminal.result(format_args!(
                "{}. {name}: {template}, {model}, μ = {mu}, {region}{solo}{off}",
                i + 1
            ))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_was_saved_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        let shape = ShapeSource::Sample("bell".into());
        save_new(&Project::new(shape.clone(), 8), &path).unwrap();
        let read = Project::load(&path).unwrap();
        check_unchanged(&path, &read).unwrap();
        Project::new(shape, 9).save(&path).unwrap();
        let why = check_unchanged(&path, &read).unwrap_err().to_string();
        assert!(why.contains("p.chladni") && why.contains("changed meanwhile"), "{why}");
        assert!(save_new(&read, &path).unwrap_err().to_string().contains("exists already"));
        assert_eq!(Project::load(&path).unwrap().harmonics, 9);
    }

    #[cfg(unix)]
    #[test]
    fn of_commands_that_change_one_project_at_once_no_work_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        save_new(&Project::new(ShapeSource::Sample("bell".into()), 8), &path).unwrap();
        let read = Project::load(&path).unwrap();
        let start = std::sync::Barrier::new(4);
        let add = |number: usize| {
            let mut project = read.clone();
            let name = format!("layer {number}");
            project.push(Layer::new(name, Template::Ellipsoid)).unwrap();
            start.wait();
            save_over(&read, &project, &path).is_ok()
        };
        let saved: Vec<bool> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|number| scope.spawn(move || add(number))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let layers = Project::load(&path).unwrap().layers().len();
        assert_eq!((saved.iter().filter(|saved| **saved).count(), layers), (1, 1));
    }
}
