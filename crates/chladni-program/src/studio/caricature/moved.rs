//! Projects whose meshes have moved: opened together with them, a project finds them again by their names.

use std::path::{Path, PathBuf};

use chladni_caricature::{Action, Project, Property, ShapeSource, Template};

use crate::work::Error;

/// Reads the project at `path`. Where a mesh that it names is not there, it names the one of the same file name among
/// `meshes` instead, which is taken out of them. True where it took one.
///
/// # Errors
/// A file that is no project, or one whose shape is neither there nor among `meshes`.
pub fn open(path: &Path, meshes: &mut Vec<PathBuf>) -> Result<(Project, bool), Error> {
    let mut project = Project::load(path)?;
    let mut taken = Vec::new();
    let mut found = |named: Option<&Path>| {
        let missing = named.filter(|named| !named.exists())?;
        let mesh = meshes.iter().find(|mesh| mesh.file_name() == missing.file_name())?;
        taken.push(mesh.clone());
        Some(mesh.clone())
    };
    if let Some(mesh) = found(project.shape.file()) {
        project.shape = ShapeSource::File(mesh);
    }
    let mut templates = Vec::new();
    for (layer, of) in project.layers() {
        templates.extend(found(of.template.file()).map(|mesh| (*layer, Template::File(mesh))));
    }
    for (layer, template) in templates {
        project.apply(&Action::Set { layer, to: Property::Template(template) }, None)?;
    }
    if let Some(shape) = project.shape.file().filter(|shape| !shape.exists()) {
        let why = "is not there; drop the project together with its mesh";
        return Err(Error::Input(format!("{}: its shape {} {why}", path.display(), shape.display())));
    }
    meshes.retain(|mesh| !taken.contains(mesh));
    Ok((project, !taken.is_empty()))
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
        let why = open(&at("p.chladni"), &mut vec![at("more.ply")]).unwrap_err().to_string();
        assert!(why.contains("head.ply is not there; drop the project together"), "{why}");

        let mut meshes = names.map(at).to_vec();
        let (found, moved) = open(&at("p.chladni"), &mut meshes).unwrap();
        assert!(moved);
        assert_eq!(found.files(), [at("elsewhere/head.ply"), at("elsewhere/mean.ply"), at("kept.ply")]);
        assert_eq!(meshes, [at("elsewhere/kept.ply"), at("more.ply")]);
    }
}
