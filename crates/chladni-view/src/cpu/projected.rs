//! A figure as one eye sees it, the viewer's or the key light's.

use rayon::prelude::*;

use super::instructions::Instructions;
use super::project::{CHUNK, Chunk, Corner, Grid, Lens, Project, pieces};

/// Vertices that are projected together.
const VERTICES: usize = 4096;

/// Corners of all vertices, and the triangles sorted into tiles. Kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Projected {
    pub(super) corners: Vec<Corner>,
    pub(super) chunks: Vec<Chunk>,
}

impl Projected {
    pub(super) fn project(
        &mut self,
        with: Instructions,
        (lens, grid): (&Lens, &Grid),
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) {
        self.corners.resize(positions.len(), Corner::default());
        let parts = self.corners.par_chunks_mut(VERTICES).zip(positions.par_chunks(VERTICES));
        parts.for_each(|(corners, positions)| with.run(Project { lens, positions, corners }));
        self.chunks.resize_with(triangles.len().div_ceil(CHUNK), Chunk::default);
        let corners = &self.corners;
        let parts = self.chunks.par_iter_mut().zip(triangles.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(i, (chunk, triangles))| {
            chunk.sort((lens, grid), (i * CHUNK, triangles), positions, corners);
        });
    }

    /// The parts of one triangle that lie on the grid.
    pub(super) fn pieces(
        &self,
        lens: &Lens,
        positions: &[[f32; 3]],
        triangle: [u32; 3],
    ) -> impl Iterator<Item = [Corner; 3]> {
        pieces(lens, triangle.map(|v| positions[v as usize]), triangle.map(|v| self.corners[v as usize]))
    }
}
