//! Writing the result.

use std::path::Path;

use chladni_mesh::{Format, MorphTarget, TriMesh};

use super::CaricatureRoom;
use super::session::Session;
use crate::studio::room::Shared;

impl CaricatureRoom {
    /// Asks for a file and writes the result there; the extension chooses the format.
    pub(super) fn export(&mut self, shared: &mut Shared<'_>) {
        let Some(session) = &self.session else { return };
        let kinds: [(&str, &[&str]); 4] = [
            ("GLB with one slider per layer", &["glb"]),
            ("OBJ", &["obj"]),
            ("PLY", &["ply"]),
            ("STL", &["stl"]),
        ];
        let path = shared.chooser.save(&kinds, &session.beside("glb"));
        if let Some(path) = path {
            match export_to(session, &path) {
                Ok(()) => shared.notices.done(format!("Exported {}", path.display())),
                Err(why) => shared.notices.error(why),
            }
        }
    }
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
