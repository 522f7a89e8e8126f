//! Grains of sand: the twin of `gpu/shader/grains.wgsl`.

use glam::{Mat4, Vec3, Vec4, vec3};
use rayon::prelude::*;

use super::curves::{clamp, max, min, mix, smoothstep};
use super::markers::touched;
use super::project::Grid;
use super::shade::{self, rgb};
use super::shadow::ShadowMap;
use super::subjects::Subject;
use crate::scene::{Grain, Grains};
use crate::uniforms::{CellUniform, FigureUniform};

/// No disc is smaller; a smaller grain is fainter instead.
const LEAST_GRAIN_PX: f32 = 0.7;

/// Grains that one thread takes at a time.
const CHUNK: usize = 2048;

/// The grains of a cell on its screen, sorted into tiles.
#[derive(Debug, Default)]
pub(super) struct GrainDiscs {
    discs: Vec<GrainDisc>,
    /// Where each tile's grains begin in `sorted`.
    starts: Vec<u32>,
    sorted: Vec<u32>,
}

/// A grain on the screen.
#[derive(Clone, Copy, Debug)]
struct GrainDisc {
    center: [f32; 2],
    depth: f32,
    radius: f32,
    opacity: f32,
    /// Encoded.
    color: [f32; 3],
}

impl GrainDiscs {
    pub(super) fn clear(&mut self) {
        self.discs.clear();
    }

    /// Adds those of a figure.
    pub(super) fn add(
        &mut self,
        cell: &CellUniform,
        map: Option<&ShadowMap>,
        (figure, subject, grains): (&FigureUniform, &Subject<'_>, Grains<'_>),
    ) {
        let projector = Projector::new(cell, figure, map);
        let discs = grains.grains.par_iter().enumerate().with_min_len(CHUNK);
        self.discs.par_extend(discs.filter_map(|(i, grain)| projector.disc(i, grain, subject)));
    }

    /// Sorts them into the tiles of `grid`, in their order.
    pub(super) fn sort(&mut self, grid: &Grid) {
        self.starts.clear();
        self.starts.resize(grid.tiles() + 1, 0);
        for disc in &self.discs {
            disc.tiles(grid, |tile| self.starts[tile + 1] += 1);
        }
        for tile in 1..self.starts.len() {
            self.starts[tile] += self.starts[tile - 1];
        }
        let mut next = self.starts.clone();
        self.sorted.clear();
        self.sorted.resize(self.starts.last().map_or(0, |count| *count as usize), 0);
        for (i, disc) in self.discs.iter().enumerate() {
            disc.tiles(grid, |tile| {
                self.sorted[next[tile] as usize] = i as u32;
                next[tile] += 1;
            });
        }
    }

    /// Whether there is none in a tile.
    pub(super) fn is_empty(&self, tile: usize) -> bool {
        self.discs.is_empty() || self.starts[tile] == self.starts[tile + 1]
    }

    /// Those of a tile, in their order: `lay` gets pixel and premultiplied color of each that lies between
    /// `low` and `high`, whose samples' depths `depths` tells.
    pub(super) fn draw(
        &self,
        tile: usize,
        (low, high): ([i32; 2], [i32; 2]),
        mut lay: impl FnMut([i32; 2], &dyn Fn([f32; 4]) -> [f32; 4]),
        toward_key: [f32; 2],
    ) {
        if self.is_empty(tile) {
            return;
        }
        for i in &self.sorted[self.starts[tile] as usize..self.starts[tile + 1] as usize] {
            let disc = &self.discs[*i as usize];
            let [[left, right], [top, bottom]] = [0, 1].map(|axis| touched(disc.center, disc.radius, axis));
            for y in top.max(low[1])..=bottom.min(high[1]) {
                for x in left.max(low[0])..=right.min(high[0]) {
                    let (dx, dy) = (x as f32 + 0.5 - disc.center[0], disc.center[1] - y as f32 - 0.5);
                    let cover = 1.0 - smoothstep(disc.radius - 0.7, disc.radius + 0.7, dx.hypot(dy));
                    if cover > 0.0 {
                        lay([x, y], &|depths| disc.color(cover, [dx, dy], toward_key, depths));
                    }
                }
            }
        }
    }
}

impl GrainDisc {
    /// The tiles that it may touch.
    fn tiles(&self, grid: &Grid, mut each: impl FnMut(usize)) {
        let spans: [[i32; 2]; 2] = [0, 1].map(|axis| {
            let [first, last] = touched(self.center, self.radius, axis);
            [first.max(grid.low[axis]), last.min(grid.high[axis])]
        });
        if spans.iter().any(|[first, last]| first > last) {
            return;
        }
        let [columns, rows] = [0, 1].map(|axis| spans[axis].map(|at| at >> grid.bits[axis]));
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                each(grid.tile(column, row));
            }
        }
    }

    fn color(&self, cover: f32, [dx, dy]: [f32; 2], toward_key: [f32; 2], depths: [f32; 4]) -> [f32; 4] {
        let before = depths.iter().filter(|depth| self.depth <= **depth).count() as f32 / 4.0;
        let alpha = cover * self.opacity * before;
        let out = self.radius + 0.7;
        let round = 0.86 + 0.30 * (dx * toward_key[0] + dy * toward_key[1]) / out;
        let [r, g, b] = self.color.map(|c| clamp(c * round * alpha, 0.0, alpha));
        [r, g, b, alpha]
    }
}

/// From grains to discs.
struct Projector<'a> {
    cell: &'a CellUniform,
    figure: &'a FigureUniform,
    map: Option<&'a ShadowMap>,
    model: Mat4,
    view: Mat4,
    projection: Mat4,
    shadow: Mat4,
}

impl<'a> Projector<'a> {
    fn new(cell: &'a CellUniform, figure: &'a FigureUniform, map: Option<&'a ShadowMap>) -> Self {
        let matrix = |columns: &[[f32; 4]; 4]| Mat4::from_cols_array_2d(columns);
        Self {
            model: matrix(&figure.model),
            view: matrix(&cell.view),
            projection: matrix(&cell.projection),
            shadow: matrix(&cell.shadow),
            cell,
            figure,
            map,
        }
    }

    /// `None` on a side that looks away, and before or behind all that is drawn.
    fn disc(&self, index: usize, grain: &Grain, subject: &Subject<'_>) -> Option<GrainDisc> {
        let (cell, [_, _, _, radius]) = (self.cell, self.figure.grain);
        let mixed = |of: &[[f32; 3]]| -> Vec3 {
            (0..3).map(|c| Vec3::from(of[grain.corners[c] as usize]) * grain.weights[c]).sum()
        };
        let normal = mixed(subject.normals);
        let normal = normal / max(normal.length(), 1e-12);
        let place = mixed(subject.positions) + normal * (radius + grain.lift);
        let scene = self.model * place.extend(1.0);
        let scene_normal = self.model * normal.extend(0.0);
        let at = self.view * scene;
        let turned = (self.view * scene_normal).truncate();
        let orthographic = cell.output[2] > 0.5;
        let viewer = if orthographic { Vec3::Z } else { shade::normalized(-at.truncate(), Vec3::Z) };
        let clip = self.projection * at;
        let depth = clip.z / clip.w;
        if turned.dot(viewer) <= 0.0 || clip.w <= 0.0 || !(0.0..=1.0).contains(&depth) {
            return None;
        }
        let [left, top, width, height] = cell.viewport;
        let similarity = self.model.x_axis.truncate().length();
        let scale = if orthographic { 1.0 } else { max(-at.z, 1e-6) };
        let radius_px = 0.5 * height * cell.projection[1][1] * radius * similarity / scale;
        let drawn = max(radius_px, LEAST_GRAIN_PX);
        let bits = (index as u32 ^ (index as u32 >> 7)).wrapping_mul(2_654_435_761) >> 16;
        let own = 0.8 + 0.4 * bits as f32 / 65535.0;
        let center =
            [left + (0.5 + 0.5 * clip.x / clip.w) * width, top + (0.5 - 0.5 * clip.y / clip.w) * height];
        let there = center.iter().all(|c| c.is_finite()) && drawn < width.max(height);
        let lit = rgb(self.figure.grain)
            * own
            * self.light(turned, self.key(scene, scene_normal, turned), clip.x / clip.w);
        there.then(|| GrainDisc {
            center,
            depth,
            radius: drawn,
            opacity: (radius_px / drawn).powi(2),
            color: shade::finished(lit).to_array(),
        })
    }

    /// The key light's share there.
    fn key(&self, scene: Vec4, scene_normal: Vec4, turned: Vec3) -> f32 {
        let Some(map) = self.map else { return 1.0 };
        let size = self.cell.shadow_map[1];
        let texels = vec3(0.5 * size, -0.5 * size, 1.0);
        let on = (self.shadow * scene).truncate() * texels + vec3(0.5 * size, 0.5 * size, 0.0);
        let on = vec3(clamp(on.x, 6.0, size - 6.0), clamp(on.y, 6.0, size - 6.0), on.z);
        let length = max(turned.length(), 1e-12);
        let grazing = 1.0 - min(turned.dot(rgb(self.cell.lights[0][0])).abs() / length, 1.0);
        let step = self.cell.shadow_map[2] * (1.0 + 3.0 * grazing) / length;
        let off = (self.shadow * scene_normal).truncate() * texels * step;
        mix(1.0, map.lit_disc((on + off).to_array()), self.cell.shadow_map[0])
    }

    fn light(&self, n: Vec3, key: f32, x: f32) -> Vec3 {
        let cell = self.cell;
        let mut c = rgb(cell.ground).lerp(rgb(cell.sky), 0.5 + 0.5 * n.y);
        for (i, [direction, color]) in cell.lights.into_iter().enumerate() {
            let facing = clamp(0.35 + 0.65 * n.dot(rgb(direction)), 0.0, 1.0);
            c += rgb(color) * if i == 0 { key } else { 1.0 } * facing;
        }
        c * shade::wing(cell.wings[0], cell.wings[1], x)
    }
}
