//! Opening, saving and exporting: the room's traffic with the disk.

use std::path::{Path, PathBuf};

use chladni_mesh::{Format, MorphTarget, TriMesh};

use super::CaricatureRoom;
use super::session::Session;
use crate::studio::room::Shared;

/// Extensions of meshes that can be read.
pub const MESHES: [&str; 7] = ["obj", "ply", "off", "stl", "gltf", "glb", "mesh"];

impl CaricatureRoom {
    /// Asks for a mesh or project and opens it.
    pub(super) fn choose_file(&mut self, shared: &mut Shared<'_>) {
        let mut extensions = vec!["chladni"];
        extensions.extend(MESHES);
        if let Some(path) = rfd::FileDialog::new().add_filter("Meshes and projects", &extensions).pick_file()
        {
            let project = path.extension().is_some_and(|extension| extension == "chladni");
            shared.settings.remember(&path);
            self.load(path, project, shared);
        }
    }

    /// Saves the project, asking for a name where it has none or another is wanted.
    pub(super) fn save(&mut self, ask: bool, shared: &mut Shared<'_>) {
        let Some(session) = &mut self.session else { return };
        let known = session.path.clone().filter(|_| !ask);
        let path = known.or_else(|| {
            rfd::FileDialog::new()
                .add_filter("Chladni project", &["chladni"])
                .set_file_name(format!("{}.chladni", session.name()))
                .save_file()
        });
        if let Some(path) = path {
            match save_to(session, &path) {
                Ok(()) => {
                    shared.settings.remember(&path);
                    shared.notices.done(format!("Saved {}", path.display()));
                }
                Err(why) => shared.notices.error(why),
            }
        }
    }

    /// Asks for a file and writes the result there; the extension chooses the format.
    pub(super) fn export(&mut self, shared: &mut Shared<'_>) {
        let Some(session) = &self.session else { return };
        let path = rfd::FileDialog::new()
            .add_filter("GLB with one slider per layer", &["glb"])
            .add_filter("OBJ", &["obj"])
            .add_filter("PLY", &["ply"])
            .add_filter("STL", &["stl"])
            .set_file_name(format!("{}.glb", session.name()))
            .save_file();
        if let Some(path) = path {
            match export_to(session, &path) {
                Ok(()) => shared.notices.done(format!("Exported {}", path.display())),
                Err(why) => shared.notices.error(why),
            }
        }
    }
}

/// Writes the project to `path`, whole or not at all.
pub fn save_to(session: &mut Session, path: &Path) -> Result<(), String> {
    session.project().save(path).map_err(|error| error.to_string())?;
    session.path = Some(PathBuf::from(path));
    session.history.mark_saved();
    Ok(())
}

/// Writes the result: GLB holds the original with one morph target per layer, other formats the
/// result itself.
pub fn export_to(session: &Session, path: &Path) -> Result<(), String> {
    let body = session.stack.body();
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let format = Format::from_extension(extension)
        .ok_or_else(|| format!("{}: choose .glb, .obj, .ply or .stl", path.display()))?;
    let bytes = if format == Format::Glb {
        let targets: Vec<MorphTarget> = session
            .evaluation
            .morph_targets(body)
            .into_iter()
            .map(|(name, displacements)| MorphTarget { name, displacements })
            .collect();
        chladni_mesh::write_glb(&session.mesh, &targets)
    } else {
        let positions = session.evaluation.file_positions(body, &session.mesh.positions);
        chladni_mesh::write_mesh(&TriMesh { positions, ..TriMesh::clone(&session.mesh) }, format)
    };
    let bytes = bytes.map_err(|error| format!("{}: {error}", path.display()))?;
    chladni_task::write_atomic(path, &bytes).map_err(|error| format!("{}: {error}", path.display()))
}
