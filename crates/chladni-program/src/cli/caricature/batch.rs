//! One recipe on many shapes.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use chladni_caricature::Project;
use chladni_mesh::{Format, ShapeSource};

use super::{Caricature, made_on, one};
use crate::cli::Terminal;
use crate::work::formats::is_project;
use crate::work::outputs::{check_apart, check_folders, is_one_place, mesh_format};
use crate::work::{Error, Warning, Watcher, is_hidden, make_folder};

impl Caricature {
    /// Every mesh of `batch`, or the piece of it that is asked for. One that fails does not stop the others.
    pub(super) fn batch(&self, mut project: Project, batch: &Path, terminal: &Terminal) -> Result<(), Error> {
        let Some(results) = &self.output else {
            return Err(Error::input("--batch needs a folder for the results: -o"));
        };
        self.portrait.check()?;
        let shapes = if batch.is_dir() { meshes_in(batch)? } else { meshes_listed(batch)? };
        // Whether results would collide depends on all of them, whichever of them are made here.
        let planned = self.planned(results, &shapes, &project.files())?;
        let piece = self.piece.map_or(0..shapes.len() as u64, |piece| piece.range(shapes.len() as u64));
        let piece = piece.start as usize..piece.end as usize;
        let (shapes, planned) = (&shapes[piece.clone()], &planned[piece]);
        let folders = [Some(results), self.render.as_ref()].into_iter().flatten();
        folders.clone().try_for_each(|folder| check_folders(folder))?;
        let from = made_on(&mut project, terminal)?;
        for folder in folders {
            make_folder(folder)?;
        }
        let (mut failed, mut kept, mut is_of_input) = (0, 0, true);
        for (shape, (output, render)) in shapes.iter().zip(planned) {
            terminal.task().check()?;
            if self.resume && output.is_file() && render.as_ref().is_none_or(|render| render.is_file()) {
                kept += 1;
                continue;
            }
            let name = shape.display().to_string();
            let (wanted, pictures) = (self.resolution.wanted(), self.pictures(render.as_deref()));
            let source = ShapeSource::named(shape);
            match one(Some(&source), &project, from.as_deref(), wanted, Some(output), pictures, terminal) {
                Ok(()) => {}
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(failure) => {
                    failed += 1;
                    is_of_input &= failure.is_of_input();
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
        let message = format!("{failed} of {} shapes failed", shapes.len());
        match failed {
            0 => Ok(()),
            _ if is_of_input => Err(Error::Input(message)),
            _ => Err(Error::other(message)),
        }
    }

    /// The mesh in `results` and the picture that each of `shapes` becomes; refused where one would replace another, a
    /// shape, or one of the files `of_recipe`.
    fn planned(
        &self,
        results: &Path,
        shapes: &[PathBuf],
        of_recipe: &[&Path],
    ) -> Result<Vec<(PathBuf, Option<PathBuf>)>, Error> {
        let real = |path: &Path| {
            let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
            std::fs::canonicalize(path).ok()
        };
        let is_sample = |shape: &Path| ShapeSource::sample_name(shape).is_some();
        let files = || shapes.iter().filter(|shape| !is_sample(shape));
        let folders: HashSet<&Path> = files().filter_map(|shape| shape.parent()).collect();
        // Also where a link leads there.
        let read: HashSet<PathBuf> = files().filter_map(|shape| shape.canonicalize().ok()).collect();
        let asked = [
            (Some(results), "results there would replace the shapes"),
            (self.render.as_deref(), "pictures there would replace those of the shapes"),
        ];
        for (asked, why) in asked {
            let asked = asked.and_then(real);
            if let Some(folder) = folders.iter().find(|folder| asked.is_some() && real(folder) == asked) {
                return Err(Error::input(format_args!("{}: {why}", folder.display())));
            }
        }
        let mut owners: HashMap<PathBuf, &Path> = HashMap::new();
        let mut planned = Vec::with_capacity(shapes.len());
        for shape in shapes {
            // A format that can be written is kept; glTF becomes GLB, and the others PLY, which keeps every digit.
            let (stem, extension) = match mesh_format(shape) {
                _ if is_sample(shape) => (shape.as_os_str(), "ply".as_ref()),
                Ok(_) => (shape.file_stem().unwrap_or_default(), shape.extension().unwrap_or_default()),
                Err(_) if Format::of_path(shape) == Some(Format::Gltf) => {
                    (shape.file_stem().unwrap_or_default(), "glb".as_ref())
                }
                Err(_) => (shape.file_stem().unwrap_or_default(), "ply".as_ref()),
            };
            let output = named(results, stem, extension);
            let render = self.render.as_ref().map(|folder| named(folder, stem, "png".as_ref()));
            for path in std::iter::once(&output).chain(&render) {
                check_apart(path, of_recipe)?;
                if path.canonicalize().is_ok_and(|place| read.contains(&place)) {
                    let path = path.display();
                    return Err(Error::input(format_args!(
                        "{path}: is one of the shapes; choose another folder"
                    )));
                }
                if let Some(other) = owners.insert(path.clone(), shape) {
                    let (path, other, shape) = (path.display(), other.display(), shape.display());
                    return Err(Error::input(format_args!("{other} and {shape} would both become {path}")));
                }
            }
            planned.push((output, render));
        }
        // Beside an OBJ lie its textures, under names of their own.
        let is_obj = |path: &Path| mesh_format(path).is_ok_and(|format| format == Format::Obj);
        if let Some(pictures) = self.render.as_deref().filter(|pictures| is_one_place(results, pictures))
            && planned.iter().any(|(output, _)| is_obj(output))
        {
            let why = "pictures there could take the place of textures of the OBJ results: choose another folder for them";
            return Err(Error::input(format_args!("{}: {why}", pictures.display())));
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

/// The largest list of meshes that is read.
const MOST_BYTES: u64 = 64 << 20;

/// The meshes that a text file names, in its order; empty lines and comments are left out. A name that is not found from the
/// current folder is one beside the list, as in playlists, if it is there.
///
/// # Errors
/// [`Error::Input`] where it cannot be read, is a mesh or a project, or lists none.
pub fn meshes_listed(list: &Path) -> Result<Vec<PathBuf>, Error> {
    let why = match Format::of_path(list) {
        Some(_) => Some("is a mesh: --batch takes a folder or a list of meshes; for one, give it as SHAPE"),
        None if is_project(list) => {
            Some("is a caricature project: --batch takes a folder or a list of meshes, --recipe the project")
        }
        None => None,
    };
    if let Some(why) = why.filter(|_| list.is_file()) {
        return Err(Error::input(format_args!("{}: {why}", list.display())));
    }
    let text = chladni_task::read_text_file(list, MOST_BYTES);
    let text = text.map_err(|error| Error::input(format_args!("{}: {error}", list.display())))?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let found = |name: &str| {
        let mesh = PathBuf::from(name);
        // Lists of other systems.
        let other = name.replace('\\', "/");
        let places = [mesh.clone(), folder.join(name), PathBuf::from(&other), folder.join(&other)];
        let is_sample = ShapeSource::sample_name(&mesh).is_some();
        places.into_iter().find(|place| !is_sample && place.exists()).unwrap_or(mesh)
    };
    let names = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let meshes: Vec<PathBuf> = names.map(found).collect();
    if meshes.is_empty() {
        return Err(Error::input(format_args!("{}: lists no mesh", list.display())));
    }
    Ok(meshes)
}

/// The meshes in a folder, less hidden files.
fn meshes_in(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |error| Error::input(format_args!("{}: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let is_mesh = |path: &PathBuf| !is_hidden(path) && path.is_file() && Format::of_path(path).is_some();
    let mut meshes: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_mesh).collect();
    meshes.sort();
    if meshes.is_empty() {
        return Err(Error::input(format_args!("{}: holds no mesh", folder.display())));
    }
    Ok(meshes)
}
