//! A picture's cells before they are drawn: checked, projected, their shadows drawn.

use std::ops::Range;

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use super::Canvas;
use super::backdrop::Backdrop;
use super::grains::GrainDiscs;
use super::instructions::Instructions;
use super::markers::Disc;
use super::project::{Grid, Lens, TILE_BITS};
use super::projected::Projected;
use super::shadow::ShadowMap;
use super::subjects::{Coat, Subject};
use crate::uniforms::{
    CellUniform, FigureUniform, arrangement, casts_shadows, cell_uniform, check_cell, figure_uniform,
    key_light_view,
};
use crate::{Cell, Figure, Projection, Samples, Surroundings, ViewError};

/// All that is known of a picture before its pixels.
#[derive(Debug, Default)]
pub(super) struct Prepared {
    pub(super) cells: Vec<PreparedCell>,
    pub(super) figures: Vec<PreparedFigure>,
}

#[derive(Debug, Default)]
pub(super) struct PreparedCell {
    pub(super) uniform: CellUniform,
    pub(super) grid: Grid,
    /// Its figures among all.
    pub(super) figures: Range<usize>,
    pub(super) discs: Vec<Disc>,
    pub(super) grains: GrainDiscs,
    pub(super) backdrop: Backdrop,
    pub(super) shadows: bool,
    pub(super) map: ShadowMap,
    /// Depths in a pixel that differ by no more are those of one surface.
    pub(super) one_surface: f32,
}

#[derive(Debug, Default)]
pub(super) struct PreparedFigure {
    pub(super) uniform: FigureUniform,
    /// Rows x, y and w of the matrix from the item to clip space.
    pub(super) clip: [[f32; 4]; 3],
    /// Rows of the matrices from the item to the viewer's axes, and to the key light's map.
    pub(super) view: [[f32; 4]; 3],
    pub(super) map: [[f32; 4]; 3],
    pub(super) projected: Projected,
    /// The palette position and the glow of each vertex, where it has them.
    pub(super) answers: Vec<[f32; 2]>,
    /// Its outward displacement and its outward lag, where they are asked for.
    pub(super) outward: Vec<[f32; 2]>,
    shadow: Projected,
    pub(super) lens: Lens,
    shadow_lens: Option<Lens>,
}

/// Cells of fewer pixels show much in each: there every triangle is shaded for itself.
const SMALL: u32 = 10_000;

/// Texels of a side that all maps together may take.
const MAPS_SIDE: u32 = 8192;

impl Prepared {
    /// Takes `cells` in, whose figures are `subjects`.
    pub(super) fn prepare(
        &mut self,
        with: Instructions,
        canvas: &Canvas,
        (cells, surroundings): (&[Cell<'_>], &Surroundings),
        subjects: &[Subject<'_>],
    ) -> Result<(), ViewError> {
        self.cells.resize_with(cells.len(), PreparedCell::default);
        self.figures.resize_with(subjects.len(), PreparedFigure::default);
        let shadowed = cells.iter().filter(|cell| casts_shadows(cell)).count();
        let (size, ..) = arrangement(shadowed.max(1) as u32, Samples::Four, MAPS_SIDE);
        let mut first = 0;
        for (prepared, cell) in self.cells.iter_mut().zip(cells) {
            check_cell(cell, canvas.width, canvas.height)?;
            prepared.figures = first..first + cell.figures.len();
            first = prepared.figures.end;
            prepared.set(with, (cell, surroundings), size)?;
            for (figure, prepared_figure) in
                cell.figures.iter().zip(&mut self.figures[prepared.figures.clone()])
            {
                prepared_figure.set(figure, prepared);
            }
        }
        let grids = self.cells.iter().flat_map(|cell| std::iter::repeat_n(cell.grid, cell.figures.len()));
        let grids: Vec<Grid> = grids.collect();
        let map_grid = ShadowMap::grid(size);
        let figures = self.figures.par_iter_mut().zip(subjects).zip(grids);
        figures.for_each(|((figure, subject), grid)| {
            let (positions, triangles) = (subject.positions, subject.triangles);
            figure.projected.project(with, (&figure.lens, &grid), positions, triangles);
            figure.answer(subject);
            if let Some(lens) = &figure.shadow_lens {
                figure.shadow.project(with, (lens, &map_grid), positions, triangles);
            }
        });
        let figures = &self.figures;
        self.cells.par_iter_mut().filter(|cell| cell.shadows).for_each(|cell| {
            let all = figures[cell.figures.clone()].iter().zip(&subjects[cell.figures.clone()]);
            let casting = all.filter(|(figure, _)| figure.shadow_lens.is_some());
            let casting: Vec<_> =
                casting.map(|(figure, subject)| (&figure.shadow, subject.triangles)).collect();
            cell.map.draw(with, size, &casting);
        });
        for (prepared, cell) in self.cells.iter_mut().zip(cells) {
            let PreparedCell { grains, uniform, map, shadows, .. } = prepared;
            grains.clear();
            for (figure, i) in cell.figures.iter().zip(prepared.figures.clone()) {
                if let Some(of) = figure.grains {
                    let on = (&self.figures[i].uniform, &subjects[i], of);
                    grains.add(uniform, Some(&*map).filter(|_| *shadows), on);
                }
            }
            grains.sort(&prepared.grid);
        }
        Ok(())
    }
}

impl PreparedCell {
    fn set(
        &mut self,
        with: Instructions,
        (cell, surroundings): (&Cell<'_>, &Surroundings),
        map_size: u32,
    ) -> Result<(), ViewError> {
        let r = cell.viewport;
        self.uniform = cell_uniform(cell, true, surroundings);
        let low = [r.x as i32, r.y as i32];
        let high = [low[0] + r.width as i32 - 1, low[1] + r.height as i32 - 1];
        self.grid = Grid { low, high, bits: TILE_BITS };
        self.shadows = casts_shadows(cell);
        if self.shadows {
            (self.uniform.shadow, self.uniform.shadow_map) = key_light_view(cell, map_size);
        }
        self.discs.clear();
        self.discs.extend(cell.markers.iter().filter_map(|marker| Disc::new(marker, &self.uniform)));
        if cell.background.opacity > 0.0 {
            let behind = surroundings.behind.as_ref();
            self.backdrop.paint(with, &self.uniform, r, behind.map(|(skin, _)| skin.held.cpu()).transpose()?);
        }
        // Of surfaces at the target's distance that rise by four pixels in one.
        let camera = &cell.camera;
        let pixel = 2.0 * camera.distance * (0.5 * camera.fov_y_rad).tan() / r.height as f32;
        let [.., [_, _, shift, _]] = self.uniform.projection;
        let small = r.width.saturating_mul(r.height) < SMALL;
        self.one_surface = if small { 0.0 } else { 4.0 }
            * pixel
            * match camera.projection {
                Projection::Perspective => shift.abs() / (camera.distance * camera.distance),
                Projection::Orthographic => self.uniform.projection[2][2].abs(),
            };
        Ok(())
    }
}

impl PreparedFigure {
    /// Computes the palette position and the glow of each vertex, as `answered` of `gpu/shader` does.
    fn answer(&mut self, subject: &Subject<'_>) {
        let Coat::Answer(rest, lag) = subject.coat else { return };
        let [offset, span, swing, travel] = self.uniform.answer;
        let [haste, spark, phase, crease] = self.uniform.figured;
        let glow = self.uniform.glow[1];
        self.answers.clear();
        let vertices = subject.positions.iter().zip(subject.normals).zip(rest);
        self.answers.extend(vertices.clone().map(|((position, normal), [x, y, z, along, bend])| {
            let d = Vec3::from(*position) - Vec3::new(*x, *y, *z);
            let (way, normal) = (d.length(), Vec3::from(*normal));
            let outward = d.dot(normal) / normal.length().max(1e-12);
            [offset + span * along + swing * outward + travel * way + crease * bend, glow * way]
        }));
        self.outward.clear();
        if phase == 0.0 && haste == 0.0 && spark == 0.0 && self.uniform.lines[3] <= 0.0 {
            return;
        }
        // Without a lag, this stand-in has no effect.
        let lag = vertices.zip(lag.unwrap_or(subject.positions)).zip(&mut self.answers);
        self.outward.extend(lag.map(|((((position, normal), [x, y, z, ..]), lagging), [place, own])| {
            let (rest, normal) = (Vec3::new(*x, *y, *z), Vec3::from(*normal));
            let (d, lag) = (Vec3::from(*position) - rest, Vec3::from(*lagging) - rest);
            *place += haste * lag.length();
            *own += spark * lag.length();
            let off = normal / normal.length().max(1e-12);
            [d.dot(off), lag.dot(off)]
        }));
    }

    fn set(&mut self, figure: &Figure<'_>, cell: &PreparedCell) {
        self.uniform = figure_uniform(figure);
        let matrix = |columns: &[[f32; 4]; 4]| Mat4::from_cols_array_2d(columns);
        let model = matrix(&self.uniform.model);
        let view = matrix(&cell.uniform.view) * model;
        let clip = matrix(&cell.uniform.projection) * view;
        let rows = |matrix: Mat4, which: [usize; 3]| which.map(|row| matrix.row(row).to_array());
        self.clip = rows(clip, [0, 1, 3]);
        self.view = rows(view, [0, 1, 2]);
        self.lens = Lens::new(clip, cell.uniform.viewport);
        self.shadow_lens = None;
        if cell.shadows {
            let map = matrix(&cell.uniform.shadow) * model;
            self.map = rows(map, [0, 1, 2]);
            let size = cell.uniform.shadow_map[1];
            // Translucent figures cast no shadows.
            self.shadow_lens = (figure.opacity >= 1.0).then(|| Lens::new(map, [0.0, 0.0, size, size]));
        }
    }
}
