//! Builds the stiffness and mass of the welded surface of a mesh.

use std::num::NonZeroUsize;

use chladni_mesh::surface::{Weld, components, delaunay_stars, flat_components, leave_out_flat, weld};
use chladni_mesh::{Frame, TriMesh};

use crate::laplacian::{
    MOLLIFY, Refusal, cotangent_laplacian, cover_laplacian, delaunay_cover, delaunay_laplacian,
};
use crate::{CoverReport, HarmonicsError, Laplacian, SymmetricSparse};

/// The discrete Laplacian of a mesh in the working frame: S and a of S h = λ diag(a) h.
#[derive(Clone, Debug)]
pub struct Operator {
    /// Which Laplacian this is.
    pub laplacian: Laplacian,
    /// The similarity between file and working frame.
    pub frame: Frame,
    /// N positions in the working frame.
    pub positions: Vec<[f64; 3]>,
    /// Triangles over operator vertices, only those with three different corners.
    pub triangles: Vec<[u32; 3]>,
    /// For each file vertex its operator vertex; `None` if no triangle uses it.
    pub operator_vertex: Vec<Option<u32>>,
    /// S, N×N, symmetric, positive semi-definite; its rows sum to zero. It has no positive value off the
    /// diagonal unless plain cotangents were requested. It does not depend on the scale of the mesh.
    pub stiffness: SymmetricSparse,
    /// a(v), N positive areas in working units².
    pub mass: Vec<f64>,
    /// The connected component of each operator vertex; components are numbered from 0 in order of
    /// appearance.
    pub component: Vec<u32>,
    /// The number of connected components of the mesh that were left out, since they have no area.
    pub without_area: usize,
    /// How the intrinsic triangulation was made; `None` for plain cotangents.
    pub cover: Option<CoverReport>,
}

impl CoverReport {
    /// That of the intrinsic Delaunay Laplacian of `mesh`, without the Laplacian itself.
    ///
    /// # Errors
    /// Those of [`Operator::of`].
    pub fn of(mesh: &TriMesh) -> Result<Self, HarmonicsError> {
        let domain = Domain::of(mesh)?;
        domain.components()?;
        Ok(delaunay_cover(&domain.positions, &domain.triangles, MOLLIFY)?.report())
    }
}

/// The welded surface of a mesh in the working frame, before its operator is built.
#[derive(Clone)]
pub(crate) struct Domain {
    pub frame: Frame,
    pub positions: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub operator_vertex: Vec<Option<u32>>,
    /// Components that were left out, since they have no area.
    pub without_area: usize,
}

impl Domain {
    pub(crate) fn of(mesh: &TriMesh) -> Result<Self, HarmonicsError> {
        check_mesh(mesh)?;
        let Weld { mut positions, triangles, operator_vertex, without_area } = weld(mesh);
        if triangles.is_empty() {
            return Err(HarmonicsError::NoTriangle);
        }
        let frame = Frame::of_welded(mesh, &operator_vertex);
        for p in &mut positions {
            *p = frame.to_working(*p);
        }
        Ok(Self { frame, positions, triangles, operator_vertex, without_area })
    }

    /// The connected component of each vertex; an error if none has an area.
    pub(crate) fn components(&self) -> Result<Vec<u32>, HarmonicsError> {
        let component = components(self.positions.len(), &self.triangles);
        refuse_zero_area(&self.positions, &self.triangles, &component, &self.operator_vertex)?;
        Ok(component)
    }
}

/// S and the diagonal of M of `mesh` as it is, in its own units: the intrinsic Delaunay Laplacian on its n
/// vertices, which are not welded. A vertex that no triangle uses has 1 in S and a thousandth of the least area in M, as in
/// robust_laplacian, and so has one that only a component without area uses, which robust_laplacian gives an area: its
/// eigenvalue is above all that matter.
///
/// Lengths are mollified: in every triangle the sum of two sides exceeds the third by at least `mollify` ≥
/// 0 mean edge lengths (Sharp & Crane 2020, §4.5); 1e-5 is usual.
///
/// # Errors
/// Those of [`Operator::of`], and a `mollify` outside [0, 1].
pub fn mesh_laplacian(mesh: &TriMesh, mollify: f64) -> Result<(SymmetricSparse, Vec<f64>), HarmonicsError> {
    check_mesh(mesh)?;
    if !(0.0..=1.0).contains(&mollify) {
        let reason = format!("lengths cannot be mollified by {mollify} of the mean");
        return Err(HarmonicsError::bad_pencil(reason));
    }
    let whole = |[a, b, c]: &&[u32; 3]| a != b && b != c && c != a;
    let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(whole).copied().collect();
    if triangles.is_empty() {
        return Err(HarmonicsError::NoTriangle);
    }
    leave_out_flat(&mesh.positions, &mut triangles);
    // The vertices in use, renumbered.
    let mut local = vec![None; mesh.positions.len()];
    triangles.as_flattened().iter().for_each(|v| local[*v as usize] = Some(0));
    let used: Vec<usize> = (0..local.len()).filter(|v| local[*v].is_some()).collect();
    used.iter().enumerate().for_each(|(i, v)| local[*v] = Some(i as u32));
    let triangles: Vec<[u32; 3]> =
        triangles.iter().map(|t| t.map(|v| local[v as usize].unwrap_or_default())).collect();
    let frame = Frame::of(mesh);
    let positions: Vec<[f64; 3]> = used.iter().map(|v| frame.to_working(mesh.positions[*v])).collect();
    refuse_zero_area(&positions, &triangles, &components(positions.len(), &triangles), &local)?;
    let (own, areas) = delaunay_laplacian(&positions, &triangles, mollify)?;
    let entries = (0..own.size()).flat_map(|j| {
        let used = &used;
        own.column(j).filter(move |(i, _)| *i >= j).map(move |(i, value)| (used[i], used[j], value))
    });
    let mut stiffness = SymmetricSparse::from_entries(local.len(), entries)?;
    let mut mass = vec![0.0; local.len()];
    used.iter().zip(areas).for_each(|(v, a)| mass[*v] = a / (frame.scale * frame.scale));
    fill_unused(&mut stiffness, &mut mass);
    Ok((stiffness, mass))
}

/// Gives each vertex without area a 1 in S and a thousandth of the least area in M: the pencil
/// can then be solved, and it makes no difference to other vertices. Such a vertex is in no triangle, or only in those of
/// parts without area and those whose three corners lie in one place.
fn fill_unused(stiffness: &mut SymmetricSparse, mass: &mut [f64]) {
    let least = mass.iter().copied().filter(|a| *a > 0.0).fold(f64::INFINITY, f64::min);
    for (v, own) in mass.iter_mut().enumerate().filter(|(_, own)| **own == 0.0) {
        *own = 1e-3 * least;
        // Only such triangles lead from here to others, with weights of 0.
        let range = stiffness.column_starts[v]..stiffness.column_starts[v + 1];
        for (row, value) in stiffness.rows[range.clone()].iter().zip(&mut stiffness.values[range]) {
            *value = if *row as usize == v { 1.0 } else { 0.0 };
        }
    }
}

/// S and the diagonal of M of points on a surface that has no triangles, in their own units: a third of
/// [`mesh_laplacian`] of the stars that [`delaunay_stars`](chladni_mesh::surface::delaunay_stars) finds among the `neighbors` ≥ 2 nearest of each point (Sharp &
/// Crane 2020, on point clouds; 30 is usual). A point without a star, such as one in the place of
/// another, is as a vertex that no triangle uses.
///
/// # Errors
/// As [`mesh_laplacian`]; and fewer than two neighbors, or points that all lie in one line.
pub fn point_cloud_laplacian(
    points: &[[f64; 3]],
    neighbors: usize,
    mollify: f64,
) -> Result<(SymmetricSparse, Vec<f64>), HarmonicsError> {
    let mut cloud = TriMesh { positions: points.to_vec(), ..TriMesh::default() };
    check_mesh(&cloud)?;
    let Some(neighbors) = NonZeroUsize::new(neighbors).filter(|count| count.get() >= 2) else {
        return Err(HarmonicsError::bad_pencil(format!(
            "{neighbors} neighbors of a point have no triangles: two or more do"
        )));
    };
    cloud.triangles = delaunay_stars(points, neighbors);
    if cloud.triangles.is_empty() {
        return Err(HarmonicsError::bad_pencil(format!(
            "{} points that lie in one line have no surface",
            points.len()
        )));
    }
    let (mut stiffness, mut mass) = mesh_laplacian(&cloud, mollify)?;
    // Each triangle comes from all three of its corners. Points without one stay as they are.
    let mut has_star = vec![false; points.len()];
    cloud.triangles.as_flattened().iter().for_each(|v| has_star[*v as usize] = true);
    for v in 0..points.len() {
        let range = stiffness.column_starts[v]..stiffness.column_starts[v + 1];
        if has_star[v] {
            stiffness.values[range].iter_mut().for_each(|value| *value /= 3.0);
        }
        mass[v] /= 3.0;
    }
    Ok((stiffness, mass))
}

/// Refuses triangles that name a vertex that is not there.
pub(crate) fn check_corners(triangles: &[[u32; 3]], vertices: usize) -> Result<(), HarmonicsError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(HarmonicsError::IndexOutOfRange { triangle, vertex, vertices });
        }
    }
    Ok(())
}

fn check_mesh(mesh: &TriMesh) -> Result<(), HarmonicsError> {
    check_corners(&mesh.triangles, mesh.positions.len())?;
    // Squared lengths must neither overflow nor underflow before the frame scales them.
    let measurable = |x: &f64| x.is_finite() && x.abs() < 1e150;
    match mesh.positions.iter().position(|p| !p.iter().all(measurable)) {
        Some(vertex) => Err(HarmonicsError::NotFinite { vertex }),
        None => check_size(mesh),
    }
}

/// Refuses a surface for which areas times lengths, or eigenvalues in its units, would overflow or underflow.
fn check_size(mesh: &TriMesh) -> Result<(), HarmonicsError> {
    let corners = || mesh.triangles.as_flattened().iter().map(|v| mesh.positions[*v as usize]);
    let Some(first) = corners().next() else { return Ok(()) };
    let size =
        corners().fold(0.0_f64, |size, p| (0..3).fold(size, |size, i| size.max((p[i] - first[i]).abs())));
    // A surface without any extent is refused for its area.
    if size == 0.0 || (1e-100..1e100).contains(&size) {
        Ok(())
    } else {
        Err(HarmonicsError::ExtremeSize { size })
    }
}

impl Operator {
    /// Builds the intrinsic Delaunay operator of `mesh`.
    ///
    /// # Errors
    /// No usable triangle, coordinates that are not finite, an index out of range, or a mesh without area.
    pub fn of(mesh: &TriMesh) -> Result<Self, HarmonicsError> {
        Self::with(mesh, Laplacian::Delaunay)
    }

    /// Builds an operator of `mesh`.
    ///
    /// # Errors
    /// Those of [`of`](Self::of); for the plain cotangent Laplacian, also an edge with more than two
    /// triangles or a triangle without area.
    pub fn with(mesh: &TriMesh, laplacian: Laplacian) -> Result<Self, HarmonicsError> {
        Self::on(&Domain::of(mesh)?, laplacian)
    }

    pub(crate) fn on(domain: &Domain, laplacian: Laplacian) -> Result<Self, HarmonicsError> {
        let component = domain.components()?;
        let Domain { frame, positions, triangles, operator_vertex, without_area } = domain.clone();
        let ((stiffness, mass), cover) = match laplacian {
            Laplacian::Delaunay => {
                let cover = delaunay_cover(&positions, &triangles, MOLLIFY)?;
                (cover_laplacian(&cover, positions.len()), Some(cover.report()))
            }
            Laplacian::Cotangent => {
                let plain = cotangent_laplacian(&positions, &triangles);
                (plain.map_err(|refusal| refused(refusal, &operator_vertex))?, None)
            }
        };
        Ok(Self {
            laplacian,
            frame,
            positions,
            triangles,
            operator_vertex,
            stiffness,
            mass,
            component,
            without_area,
            cover,
        })
    }

    /// The surface on which the operator was built.
    pub(crate) fn domain(&self) -> Domain {
        Domain {
            frame: self.frame,
            positions: self.positions.clone(),
            triangles: self.triangles.clone(),
            operator_vertex: self.operator_vertex.clone(),
            without_area: self.without_area,
        }
    }

    /// Refuses a mesh that this cannot be the operator of.
    pub(crate) fn check_belongs_to(&self, mesh: &TriMesh) -> Result<(), HarmonicsError> {
        check_mesh(mesh)?;
        let (harmonics_of, vertices) = (self.operator_vertex.len(), mesh.positions.len());
        if harmonics_of == vertices {
            Ok(())
        } else {
            Err(HarmonicsError::OtherShape { harmonics_of, vertices })
        }
    }

    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// The number of connected components: the multiplicity of λ = 0.
    pub fn components(&self) -> usize {
        self.component.iter().max().map_or(0, |c| *c as usize + 1)
    }
}

/// The error for a mesh that has no plain cotangent Laplacian, in terms of the file's vertices.
fn refused(refusal: Refusal, operator_vertex: &[Option<u32>]) -> HarmonicsError {
    let file = |v: u32| operator_vertex.iter().position(|o| *o == Some(v)).unwrap_or_default();
    match refusal {
        Refusal::CrowdedEdge { ends, triangles } => {
            HarmonicsError::CrowdedEdge { ends: ends.map(file), triangles }
        }
        Refusal::FlatTriangle { corners } => HarmonicsError::FlatTriangle { corners: corners.map(file) },
    }
}

/// Returns an error if no component has an area. One that only rounding has flattened is no reason to refuse the others.
fn refuse_zero_area(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    component: &[u32],
    operator_vertex: &[Option<u32>],
) -> Result<(), HarmonicsError> {
    let flat = flat_components(positions, triangles, component);
    if flat.contains(&false) {
        return Ok(());
    }
    let inside = |v: &Option<u32>| v.is_some_and(|v| component[v as usize] == 0);
    Err(HarmonicsError::ZeroArea {
        vertices: component.iter().filter(|c| **c == 0).count(),
        vertex: operator_vertex.iter().position(inside).unwrap_or_default(),
    })
}
