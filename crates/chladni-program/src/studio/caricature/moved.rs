//! Projects whose meshes have moved: opened together with them, a project finds them again by their names.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use chladni_caricature::{Action, Project, Property, ShapeSource, Template};

use crate::work::Error;

/// A mesh that a project names and that is not there, and the one that it names instead.
#[derive(Debug)]
pub struct Found {
    /// The mesh that is not there.
    pub missing: PathBuf,
    /// The mesh in its place.
    pub mesh: PathBuf,
    /// Whether paths leave open if it is the right one.
    pub is_in_doubt: bool,
}

/// Reads the project at `path`. Where a mesh that it names is not there, it names one of the same file name among
/// `meshes` instead, which is taken out of them and returned; so, too, where that is on another machine, which is asked only
/// for what is `known` to the user.
///
/// # Errors
/// A file that is no project, or one whose shape is neither there nor among `meshes`, or that names an unknown file of
/// another machine.
pub fn open(
    path: &Path,
    meshes: &mut Vec<PathBuf>,
    known: impl Fn(&Path) -> bool,
) -> Result<(Project, Vec<Found>), Error> {
    let mut project = Project::read(path)?;
    let found = replace(&mut project, path, meshes, known)?;
    meshes.retain(|mesh| found.iter().all(|found| found.mesh != *mesh));
    Ok((project, found))
}

/// Replaces what the `project` at `path` misses.
fn replace(
    project: &mut Project,
    path: &Path,
    meshes: &[PathBuf],
    known: impl Fn(&Path) -> bool,
) -> Result<Vec<Found>, Error> {
    let mut far = project.far_files(path);
    far.retain(|file| !known(file));
    let found = found(project, &far, meshes);
    let in_place_of = |named: Option<&Path>| {
        let of_it = found.iter().find(|found| named == Some(found.missing.as_path()))?;
        Some(of_it.mesh.clone())
    };
    if let Some(mesh) = in_place_of(project.shape.file()) {
        project.shape = ShapeSource::File(mesh);
    }
    let mut templates = Vec::new();
    for (layer, of) in project.layers() {
        templates.extend(in_place_of(of.template.file()).map(|mesh| (*layer, Template::File(mesh))));
    }
    for (layer, template) in templates {
        project.apply(&Action::Set { layer, to: Property::Template(template) }, None)?;
    }
    // What was opened by hand may be anywhere.
    project.check_near(path, |file| known(file) || found.iter().any(|found| found.mesh == file))?;
    if let Some(shape) = project.shape.file().filter(|shape| !shape.exists()) {
        let why = "is not there; open the project together with its mesh";
        return Err(Error::Input(format!("{}: its shape {} {why}", path.display(), shape.display())));
    }
    Ok(found)
}

/// For the files of `project` that are not there, or are `far`, those of `meshes` that share the most of their paths,
/// counted from the file name. No mesh is found twice: two heads of the same name are two heads.
fn found(project: &Project, far: &[&Path], meshes: &[PathBuf]) -> Vec<Found> {
    let mut missing: Vec<&Path> = Vec::new();
    for file in project.files() {
        if !missing.contains(&file) && (far.contains(&file) || !file.exists()) {
            missing.push(file);
        }
    }
    let of = |missing| meshes.iter().map(move |mesh| (common(missing, mesh), missing, mesh.as_path()));
    let mut pairs: Vec<(usize, &Path, &Path)> = missing.into_iter().flat_map(of).collect();
    pairs.retain(|(common, ..)| *common > 0);
    pairs.sort_by_key(|(common, ..)| Reverse(*common));
    let (mut found, mut doubtful): (Vec<Found>, Vec<&Path>) = (Vec::new(), Vec::new());
    while let Some(&(common, missing, mesh)) = pairs.first() {
        pairs.retain(|pair| *pair != (common, missing, mesh));
        let touches = |pair: &&(usize, &Path, &Path)| pair.1 == missing || pair.2 == mesh;
        let rivals = pairs.iter().filter(|pair| pair.0 == common).filter(touches);
        // They may have to be the other way round.
        doubtful.extend(rivals.flat_map(|&(_, missing, mesh)| [missing, mesh]));
        let is_in_doubt = doubtful.contains(&missing) || doubtful.contains(&mesh);
        pairs.retain(|pair| !touches(&pair));
        found.push(Found { missing: missing.into(), mesh: mesh.into(), is_in_doubt });
    }
    found
}

/// How many of the last components of two paths are the same. A project may have come from Windows.
fn common(a: &Path, b: &Path) -> usize {
    let [a, b] = [a, b].map(|path| path.as_os_str().as_encoded_bytes());
    let is_between = |byte: &u8| matches!(byte, b'/' | b'\\');
    a.rsplit(is_between).zip(b.rsplit(is_between)).take_while(|(a, b)| a == b).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_caricature::Layer;

    #[test]
    fn a_project_takes_what_it_misses_from_the_meshes_of_those_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("elsewhere")).unwrap();
        let ball = chladni_mesh::samples::icosphere(1);
        let names = ["elsewhere/head.ply", "elsewhere/mean.ply", "elsewhere/kept.ply", "more.ply"];
        for name in names.into_iter().chain(["kept.ply"]) {
            chladni_mesh::save_mesh(&ball, &at(name)).unwrap();
        }
        let mut project = Project::new(ShapeSource::File(at("head.ply")), 10);
        for name in ["mean.ply", "kept.ply"] {
            project.push(Layer::new(name, Template::File(at(name)))).unwrap();
        }
        project.save(&at("p.chladni")).unwrap();
        let why = open(&at("p.chladni"), &mut vec![at("more.ply")], |_| false).unwrap_err().to_string();
        assert!(why.contains("head.ply is not there; open the project together"), "{why}");

        let mut meshes = names.map(at).to_vec();
        let (found, moved) = open(&at("p.chladni"), &mut meshes, |_| false).unwrap();
        assert_eq!(moved.len(), 2);
        assert_eq!(found.files(), [at("elsewhere/head.ply"), at("elsewhere/mean.ply"), at("kept.ply")]);
        assert_eq!(meshes, [at("elsewhere/kept.ply"), at("more.ply")]);
    }

    #[test]
    fn a_mesh_of_another_machine_is_named_instead_where_it_is_opened_too() {
        let (folder, named) = (tempfile::tempdir().unwrap(), r"\\.\nowhere\head.ply");
        let at = |name: &str| folder.path().join(name);
        chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(1), &at("head.ply")).unwrap();
        let mut project = Project::new(ShapeSource::File(named.into()), 10);
        let path = at("p.chladni");
        let why = replace(&mut project, &path, &[], |_| false).unwrap_err().to_string();
        assert!(why.contains(named) && why.contains("together with that mesh"), "{why}");
        // It was opened itself, on the share.
        let mut same = project.clone();
        let why = replace(&mut same, &path, &[PathBuf::from(named)], |_| false).unwrap_err().to_string();
        assert!(why.contains("is not there"), "{why}");
        replace(&mut project, &path, &[at("head.ply")], |_| false).unwrap();
        assert_eq!(project.files(), [at("head.ply")]);
    }

    #[test]
    fn paths_have_names_in_common_whatever_stands_between_them() {
        let common = |a: &str, b: &str| common(Path::new(a), Path::new(b));
        assert_eq!(common(r"/home/D:\Shapes\anna\head.ply", "/new/anna/head.ply"), 2);
        assert_eq!(common("/old/anna/head.ply", "/new/anna/head.ply"), 2);
        assert_eq!(common("/old/head.ply", "/old/ahead.ply"), 0);
    }

    #[test]
    fn of_meshes_of_one_name_each_path_takes_the_one_in_the_folder_of_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut project = Project::new(ShapeSource::Sample("head".into()), 10);
        // One of them twice.
        for name in ["old/ben/head.ply", "old/anna/head.ply", "old/ben/head.ply"] {
            project.push(Layer::new(name, Template::File(at(name)))).unwrap();
        }
        project.save(&at("p.chladni")).unwrap();
        let mut meshes = vec![at("new/anna/head.ply"), at("new/ben/head.ply")];
        let (there, moved) = open(&at("p.chladni"), &mut meshes, |_| false).unwrap();
        let [anna, ben] = [at("new/anna/head.ply"), at("new/ben/head.ply")];
        assert_eq!(there.files(), [&ben, &anna, &ben]);
        assert!(meshes.is_empty() && moved.iter().all(|found| !found.is_in_doubt));

        let mut meshes = vec![at("a/head.ply"), at("new/anna/head.ply"), at("b/head.ply")];
        let (there, moved) = open(&at("p.chladni"), &mut meshes, |_| false).unwrap();
        assert_eq!(there.files(), [&at("a/head.ply"), &anna, &at("a/head.ply")]);
        let doubts: Vec<_> =
            moved.iter().filter(|found| found.is_in_doubt).map(|found| &found.mesh).collect();
        assert_eq!((doubts, meshes), (vec![&at("a/head.ply")], vec![at("b/head.ply")]));

        // Each of these may be either.
        let mut meshes = vec![at("a/head.ply"), at("b/head.ply")];
        let (_, moved) = open(&at("p.chladni"), &mut meshes, |_| false).unwrap();
        assert!(moved.len() == 2 && moved.iter().all(|found| found.is_in_doubt));
    }
}
