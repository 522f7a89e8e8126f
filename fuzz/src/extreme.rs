//! Meshes with coordinates of any size, or none, through every format.

use std::fmt::Write;

use arbitrary::Arbitrary;
use chladni_mesh::{Format, MeshError, TriMesh, read_mesh};

use crate::export::{GREATEST, exported, same_corners};
use crate::pipeline::Geometry;
use crate::promised;

/// A coordinate, or an entry of a matrix.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub(crate) enum Number {
    Eighths(i8),
    /// From denormals to infinity.
    Power(i16),
    Bits(u64),
}

impl Number {
    pub fn value(self) -> f64 {
        match self {
            Self::Eighths(eighths) => f64::from(eighths) / 8.0,
            Self::Power(exponent) => f64::from(exponent % 1100).exp2(),
            Self::Bits(bits) => f64::from_bits(bits),
        }
    }
}

/// A small mesh, and coordinates in it that are replaced: a vertex, an axis and a number.
#[derive(Arbitrary, Debug)]
pub struct ExtremeMesh {
    geometry: Geometry,
    replaced: Vec<(u8, u8, Number)>,
}

impl ExtremeMesh {
    fn mesh(&self) -> Option<TriMesh> {
        let mut mesh = self.geometry.mesh().filter(|mesh| !mesh.triangles.is_empty())?;
        let n = mesh.positions.len();
        for (vertex, axis, number) in self.replaced.iter().take(64) {
            mesh.positions[usize::from(*vertex) % n][usize::from(*axis) % 3] = number.value();
        }
        Some(mesh)
    }
}

/// Writes a mesh in each format, by the program and by hand, where infinity and what is no number are written too. What is
/// read is what was written; what is refused holds a coordinate that must be.
pub fn extreme_mesh(extreme: ExtremeMesh) {
    let Some(mesh) = extreme.mesh() else { return };
    exported(&mesh);
    for dialect in DIALECTS {
        let kept = dialect.kept(&mesh);
        match read_mesh(&dialect.bytes(&kept), dialect.format()) {
            Ok(loaded) => {
                promised(&loaded);
                if dialect.format() == Format::Stl {
                    same_corners(&loaded.mesh, &kept);
                } else {
                    assert_eq!(loaded.mesh.positions, kept.positions, "{dialect:?}");
                    assert_eq!(loaded.mesh.triangles, kept.triangles, "{dialect:?}");
                }
            }
            Err(MeshError::Malformed { .. }) => {
                let all = kept.positions.as_flattened();
                assert!(
                    all.iter().any(|x| x.is_nan() || x.abs() > GREATEST),
                    "{dialect:?} refused a good file"
                );
            }
            Err(error) => panic!("{dialect:?}: {error}"),
        }
    }
}

/// How a file may be written.
#[derive(Clone, Copy, Debug)]
enum Dialect {
    Obj,
    Medit,
    Off,
    OffBinary,
    Ply,
    PlyLittle,
    PlyBig,
    Stl,
    StlBinary,
}

const DIALECTS: [Dialect; 9] = [
    Dialect::Obj,
    Dialect::Medit,
    Dialect::Off,
    Dialect::OffBinary,
    Dialect::Ply,
    Dialect::PlyLittle,
    Dialect::PlyBig,
    Dialect::Stl,
    Dialect::StlBinary,
];

impl Dialect {
    fn format(self) -> Format {
        match self {
            Self::Obj => Format::Obj,
            Self::Medit => Format::Medit,
            Self::Off | Self::OffBinary => Format::Off,
            Self::Ply | Self::PlyLittle | Self::PlyBig => Format::Ply,
            Self::Stl | Self::StlBinary => Format::Stl,
        }
    }

    /// What this holds of `mesh`.
    fn kept(self, mesh: &TriMesh) -> TriMesh {
        let mut kept = mesh.clone();
        if matches!(self, Self::OffBinary | Self::StlBinary) {
            kept.positions.as_flattened_mut().iter_mut().for_each(|x| *x = f64::from(*x as f32));
        }
        kept
    }

    fn bytes(self, mesh: &TriMesh) -> Vec<u8> {
        match self {
            Self::Obj => rows("", mesh, "v ", "f ", 1, "").into_bytes(),
            Self::Medit => medit(mesh).into_bytes(),
            Self::Off => {
                let counts = format!("OFF\n{} {} 0\n", mesh.positions.len(), mesh.triangles.len());
                rows(&counts, mesh, "", "3 ", 0, "").into_bytes()
            }
            Self::OffBinary => off_binary(mesh),
            Self::Ply => rows(&ply_header(mesh, "ascii"), mesh, "", "3 ", 0, "").into_bytes(),
            Self::PlyLittle => ply(mesh, "binary_little_endian", f64::to_le_bytes, u32::to_le_bytes),
            Self::PlyBig => ply(mesh, "binary_big_endian", f64::to_be_bytes, u32::to_be_bytes),
            Self::Stl => stl(mesh).into_bytes(),
            Self::StlBinary => stl_binary(mesh),
        }
    }
}

/// Text with a row for each vertex and for each triangle, whose corners count from `first`; `end` ends each row.
fn rows(header: &str, mesh: &TriMesh, vertex: &str, triangle: &str, first: u32, end: &str) -> String {
    let mut text = header.to_owned();
    for [x, y, z] in &mesh.positions {
        let _ = writeln!(text, "{vertex}{x:e} {y:e} {z:e}{end}");
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| v + first);
        let _ = writeln!(text, "{triangle}{a} {b} {c}{end}");
    }
    text
}

fn medit(mesh: &TriMesh) -> String {
    let only = |positions: bool| TriMesh {
        positions: if positions { mesh.positions.clone() } else { Vec::new() },
        triangles: if positions { Vec::new() } else { mesh.triangles.clone() },
        ..TriMesh::default()
    };
    let vertices = format!("Dimension 3\nVertices {}\n", mesh.positions.len());
    let vertices = rows(&vertices, &only(true), "", "", 1, " 0");
    rows(&format!("{vertices}Triangles {}\n", mesh.triangles.len()), &only(false), "", "", 1, " 0")
}

fn off_binary(mesh: &TriMesh) -> Vec<u8> {
    let counts = [mesh.positions.len() as u32, mesh.triangles.len() as u32, 0];
    let positions = mesh.positions.as_flattened().iter().map(|x| (*x as f32).to_bits());
    let triangles = mesh.triangles.iter().flat_map(|[a, b, c]| [3, *a, *b, *c]);
    let words = counts.into_iter().chain(positions).chain(triangles);
    b"OFF BINARY\n".iter().copied().chain(words.flat_map(u32::to_le_bytes)).collect()
}

fn ply_header(mesh: &TriMesh, encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
}

fn ply(mesh: &TriMesh, encoding: &str, double: fn(f64) -> [u8; 8], word: fn(u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = ply_header(mesh, encoding).into_bytes();
    bytes.extend(mesh.positions.as_flattened().iter().flat_map(|x| double(*x)));
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| word(*v)));
    }
    bytes
}

fn stl(mesh: &TriMesh) -> String {
    let mut text = String::from("solid\n");
    for triangle in &mesh.triangles {
        text.push_str("facet normal 0 0 nan\nouter loop\n");
        for [x, y, z] in triangle.map(|v| mesh.positions[v as usize]) {
            let _ = writeln!(text, "vertex {x:e} {y:e} {z:e}");
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid\n"
}

fn stl_binary(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| mesh.positions[v as usize].map(|x| x as f32));
        let numbers = [[f32::NAN; 3]].into_iter().chain(corners).flatten();
        bytes.extend(numbers.flat_map(f32::to_le_bytes).chain([0; 2]));
    }
    bytes
}
