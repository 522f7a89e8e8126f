//! A body that can dance, as bytes, which a worker hands to the page, or `scripts/web` puts beside it.
//!
//! Positions are f32, and each harmonic is 16-bit integers of a scale of its own, just as pictures are
//! synthesized: a tenth of the bytes that a solve has. The way back to the file's vertices stays behind, so
//! that nothing can be exported from it.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body, Certificate, Laplacian};
use chladni_mesh::{Frame, Orientation};
use chladni_music::Class;
use chladni_program::work::OwnLook;
use chladni_view::Picture;
use serde::{Deserialize, Serialize};

use crate::numbers::{Damaged, head, headed, numbers};

/// A body with all that a concert needs to know of it.
pub struct Parcel {
    /// As the command line calls it.
    pub name: String,
    /// Its harmonics have classes already.
    pub body: Body,
    pub classes: Vec<Class>,
    pub stands: Orientation,
    /// The colors that its file brings.
    pub own: Option<OwnLook>,
}

/// The text before the numbers.
#[derive(Serialize, Deserialize)]
struct Head {
    name: String,
    stands: Orientation,
    center: [f64; 3],
    scale: f64,
    vertices: usize,
    triangles: usize,
    classes: Vec<Class>,
    eigenvalues: Vec<f64>,
    /// The value of one unit in each harmonic's integers.
    units: Vec<f64>,
    certificate: Certificate,
    /// Samples have no colors of their own.
    #[serde(default)]
    own: Own,
}

/// The numbers at the end: a shape's own colors.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
enum Own {
    #[default]
    None,
    /// One color a vertex.
    Colors,
    /// Three places a triangle, and the pixels of a picture of this size.
    Image { width: u32, height: u32 },
}

impl Own {
    fn of(look: Option<&OwnLook>) -> Self {
        match look {
            None => Self::None,
            Some(OwnLook::Colors(_)) => Self::Colors,
            Some(OwnLook::Image { picture, .. }) => {
                Self::Image { width: picture.width, height: picture.height }
            }
        }
    }

    /// Reads what [`write_own`] wrote.
    fn read(self, rest: &mut &[u8], vertices: usize, triangles: usize) -> Result<Option<OwnLook>, Damaged> {
        let byte = |[byte]: [u8; 1]| byte;
        Ok(match self {
            Self::None => None,
            Self::Colors => Some(OwnLook::Colors(numbers(rest, vertices, 4, byte)?.as_chunks().0.to_vec())),
            Self::Image { width, height } => {
                let corners = numbers(rest, triangles, 6, f32::from_le_bytes)?;
                let rgba = numbers(rest, width as usize, 4 * height as usize, byte)?;
                let picture = Picture { width, height, rgba };
                Some(OwnLook::Image { corner_uvs: corners.as_chunks().0.to_vec(), picture })
            }
        })
    }
}

fn write_own(look: Option<&OwnLook>, bytes: &mut Vec<u8>) {
    match look {
        None => {}
        Some(OwnLook::Colors(colors)) => bytes.extend(colors.as_flattened()),
        Some(OwnLook::Image { corner_uvs, picture }) => {
            bytes.extend(corner_uvs.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
            bytes.extend(&picture.rgba);
        }
    }
}

impl Parcel {
    /// The length of the head in four bytes, the head as JSON, then positions, areas, triangles, harmonics and the
    /// colors that the file brings, all little-endian.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Damaged> {
        let Body { frame, positions, triangles, basis, .. } = &self.body;
        let n = positions.len();
        let columns = || basis.vectors.chunks_exact(n.max(1));
        let unit = |h: &[f64]| h.iter().fold(0.0_f64, |most, h| most.max(h.abs())) / f64::from(i16::MAX);
        let units: Vec<f64> = columns().map(unit).collect();
        let mut bytes = headed(&Head {
            name: self.name.clone(),
            stands: self.stands,
            center: frame.center,
            scale: frame.scale,
            vertices: n,
            triangles: triangles.len(),
            classes: self.classes.clone(),
            eigenvalues: basis.eigenvalues.clone(),
            units: units.clone(),
            certificate: basis.certificate,
            own: Own::of(self.own.as_ref()),
        })?;
        bytes.extend(positions.iter().flatten().flat_map(|c| (*c as f32).to_le_bytes()));
        bytes.extend(basis.mass.iter().flat_map(|area| (*area as f32).to_le_bytes()));
        bytes.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        for (h, unit) in columns().zip(&units) {
            let unit = if *unit > 0.0 { *unit } else { 1.0 };
            bytes.extend(h.iter().flat_map(|h| ((h / unit).round() as i16).to_le_bytes()));
        }
        write_own(self.own.as_ref(), &mut bytes);
        Ok(bytes)
    }

    /// Reads the output of [`to_bytes`](Self::to_bytes).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Damaged> {
        let mut rest = bytes;
        let head: Head = head(&mut rest)?;
        let (n, k) = (head.vertices, head.eigenvalues.len());
        if head.units.len() != k || head.classes.len() != k {
            return Err(Damaged("its harmonics are not as many as their eigenvalues".into()));
        }
        let positions: Vec<f64> = numbers(&mut rest, n, 3, |bytes| f32::from_le_bytes(bytes).into())?;
        let mass = numbers(&mut rest, n, 1, |bytes| f32::from_le_bytes(bytes).into())?;
        let corners = numbers(&mut rest, head.triangles, 3, u32::from_le_bytes)?;
        if corners.iter().any(|v| *v as usize >= n) {
            return Err(Damaged("a triangle names a vertex that is not there".into()));
        }
        let mut vectors = Vec::new();
        for unit in &head.units {
            vectors.extend(numbers(&mut rest, n, 1, |b| unit * f64::from(i16::from_le_bytes(b)))?);
        }
        let own = head.own.read(&mut rest, n, head.triangles)?;
        let certificate = Certificate { laplacian: Laplacian::Delaunay, ..head.certificate };
        let body = Body {
            frame: Frame { center: head.center, scale: head.scale },
            positions: positions.as_chunks().0.to_vec(),
            triangles: corners.as_chunks().0.to_vec(),
            operator_vertex: (0..n as u32).map(Some).collect(),
            basis: Arc::new(Basis {
                eigenvalues: head.eigenvalues,
                vectors: vectors.into(),
                mass,
                certificate,
            }),
        };
        Ok(Self { name: head.name, body, classes: head.classes, stands: head.stands, own })
    }
}
