//! Binary STL.

use super::narrowed;
use crate::surface::vec3::unit;
use crate::surface::{corners, doubled_area_normal};
use crate::{Format, MeshError, TriMesh};

/// The bytes of `mesh`: its triangles and their normals, nothing else.
pub(crate) fn write(mesh: &TriMesh) -> Result<Vec<u8>, MeshError> {
    let format = Format::Stl;
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| MeshError::Unwritable { format, reason: "too many triangles".into() })?;
    let mut bytes = Vec::with_capacity(84 + 50 * mesh.triangles.len());
    bytes.extend_from_slice(b"binary STL, units as in the original");
    bytes.resize(80, b' ');
    bytes.extend_from_slice(&count.to_le_bytes());
    for triangle in &mesh.triangles {
        let points = corners(&mesh.positions, triangle);
        let normal = unit(doubled_area_normal(points));
        for vector in [normal, points[0], points[1], points[2]] {
            narrowed(vector, format)?.iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
        }
        bytes.extend_from_slice(&[0; 2]);
    }
    Ok(bytes)
}
