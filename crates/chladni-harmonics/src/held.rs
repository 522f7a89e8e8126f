//! Harmonics that vanish along the border of a surface.

use std::sync::Arc;

use chladni_mesh::TriMesh;
use chladni_mesh::surface::boundary_vertices;
use chladni_task::Task;

use crate::operator::Domain;
use crate::{
    Basis, BasisSettings, Body, BuildReport, Certificate, HarmonicsError, Operator, Pencil, SymmetricSparse,
    canonical, memory,
};

impl Body {
    /// As [`build`](Self::build), with the border held (Dirichlet) instead of free (Neumann): S and M without the rows
    /// and columns of the vertices at edges of one triangle, where all harmonics are 0.
    ///
    /// On a connected surface with a border every eigenvalue is above 0, and the constant function is not among the
    /// harmonics; a surface without a border has its usual ones. `mass` still has the areas of all N vertices, and
    /// harmonics are orthonormal under it. Bases like this are not cached.
    ///
    /// # Errors
    /// As [`build`](Self::build), and a surface all of whose vertices are held.
    pub fn with_held_border(
        mesh: &TriMesh,
        settings: &BasisSettings,
        task: &Task,
    ) -> Result<(Self, BuildReport), HarmonicsError> {
        let domain = Domain::of(mesh)?;
        let n = domain.positions.len();
        let held = boundary_vertices(n, &domain.triangles);
        let free: Vec<usize> = (0..n).filter(|v| !held[*v]).collect();
        if free.is_empty() {
            let reason = format!("all {n} vertices of the surface lie on its border, which is held");
            return Err(HarmonicsError::bad_pencil(reason));
        }
        let clamped = BasisSettings { harmonics: settings.clamped(free.len())?, ..settings.clone() };
        // The operator takes a while, too.
        memory::room_for_solve(free.len(), 1, 1, &clamped)?;
        let operator = Operator::on(&domain, settings.laplacian)?;
        drop(domain);
        let mut place = vec![None; n];
        free.iter().enumerate().for_each(|(i, v)| place[*v] = Some(i));
        let entries = free.iter().enumerate().flat_map(|(j, v)| {
            let place = &place;
            let column = operator.stiffness.column(*v);
            column.filter_map(move |(u, s)| place[u].filter(|i| *i >= j).map(|i| (i, j, s)))
        });
        let stiffness = SymmetricSparse::from_entries(free.len(), entries)?;
        let mass: Vec<f64> = free.iter().map(|v| operator.mass[*v]).collect();
        let positions: Vec<[f64; 3]> = free.iter().map(|v| operator.positions[*v]).collect();
        let choose = |basis: &mut Basis| canonical::choose(basis, &positions, &stiffness, task);
        // For a moment there are the harmonics of the free vertices and those of all.
        let keep = memory::room_for_harmonics(n, 2, &clamped)?;
        let (inner, mut report) = Pencil::new(&stiffness, &mass)?.solve_and_choose(settings, choose, task)?;
        let mut vectors = memory::vectors(n, inner.harmonics(), keep, memory::free(settings))?;
        (report.vertices, report.held) = (n, n - free.len());
        (report.cover, report.without_area) = (operator.cover, operator.without_area);
        if report.short_of_memory.is_none() {
            report.short_of_memory = keep.short_of(1, 1, n, inner.harmonics());
        }
        for (k, h) in vectors.chunks_exact_mut(n).enumerate() {
            free.iter().zip(inner.harmonic(k)).for_each(|(v, value)| h[*v] = *value);
        }
        let certificate = Certificate { laplacian: settings.laplacian, ..inner.certificate };
        let basis = Basis { eigenvalues: inner.eigenvalues, vectors, mass: operator.mass, certificate };
        let mut body = Self::unsolved(mesh)?;
        body.basis = Arc::new(basis);
        Ok((body, report))
    }
}
