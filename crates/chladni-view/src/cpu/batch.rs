//! Places on a figure's surface that are shaded together: fetched one by one, computed in vectors.

use glam::{Vec3, vec3};

use super::curves::{clamp, each, max, min, mix, packed, whole};
use super::instructions::Kernel;
use super::shade::{self, rgb};
use crate::buffers::Pyramid;
use crate::uniforms::{CellUniform, FigureUniform};

/// Places in a batch: their data fits the first-level cache.
pub(super) const PLACES: usize = 128;

type Places = [f32; PLACES];

/// Places to be shaded, an array for each number.
#[derive(Debug)]
pub(super) struct Batch {
    pub(super) count: usize,
    /// Pixel of the tile.
    pub(super) pixel: [u32; PLACES],
    pub(super) triangle: [u32; PLACES],
    /// Share of the pixel.
    pub(super) share: Places,
    /// The pixel on the canvas.
    pub(super) screen: [Places; 2],
    /// Positions and normals of the corners, in the item's coordinates.
    pub(super) positions: [[Places; 3]; 3],
    pub(super) normals: [[Places; 3]; 3],
    /// Weights of the corners here, and one pixel to the right and below without any bound.
    pub(super) weights: [Places; 3],
    pub(super) right: [Places; 3],
    pub(super) below: [Places; 3],
    /// Unit vectors in the viewer's axes: off the side that is seen, and towards the viewer.
    normal: [Places; 3],
    viewer: [Places; 3],
    /// 1 on fronts.
    front: Places,
    /// Where the key light's map is asked, in texels and depth.
    pub(super) map: [Places; 3],
    /// How much the key light's share matters: none on what looks away from it.
    pub(super) keyed: Places,
    /// Share of the key light.
    pub(super) key: Places,
    /// In a panorama: light from all around, and the mirrored light.
    ambient: [Places; 3],
    mirror: [Places; 3],
    /// Own light, as a share of the color.
    pub(super) glow: Places,
    /// Linear light; then sRGB-encoded.
    pub(super) color: [Places; 3],
    /// The colors to be added to the pixels.
    pub(super) packed: [[u8; 4]; PLACES],
}

impl Batch {
    pub(super) fn new() -> Box<Self> {
        let none = [0.0; PLACES];
        Box::new(Self {
            count: 0,
            pixel: [0; PLACES],
            triangle: [0; PLACES],
            share: none,
            screen: [none; 2],
            positions: [[none; 3]; 3],
            normals: [[none; 3]; 3],
            weights: [none; 3],
            right: [none; 3],
            below: [none; 3],
            normal: [none; 3],
            viewer: [none; 3],
            front: none,
            map: [none; 3],
            keyed: none,
            key: none,
            ambient: [none; 3],
            mirror: [none; 3],
            glow: none,
            color: [none; 3],
            packed: [[0; 4]; PLACES],
        })
    }

    /// Looks up the light of a panorama at each place.
    pub(super) fn surround(&mut self, cell: &CellUniform, around: &Pyramid, roughness: f32) {
        for i in 0..self.count {
            let (n, v) = (at(&self.normal, i), at(&self.viewer, i));
            let level = 3.0 * clamp(roughness, 0.0, 1.0);
            set(&mut self.ambient, i, shade::panorama(cell, around, n, shade::CHALK));
            set(&mut self.mirror, i, shade::panorama(cell, around, shade::reflected(n, v), level));
        }
    }

    /// What the values of the corners come to at place `i`, and how much that changes to the pixels beside it.
    #[inline(always)]
    pub(super) fn value_and_slope(&self, i: usize, corners: [f32; 3]) -> (f32, f32) {
        let at = |weights: &[Places; 3]| (0..3).map(|k| weights[k][i] * corners[k]).sum::<f32>();
        let here = at(&self.weights);
        (here, (at(&self.right) - here).abs() + (at(&self.below) - here).abs())
    }

    /// Whole vectors, so that no loop has a rest.
    #[inline(always)]
    fn padded(&self) -> usize {
        self.count.next_multiple_of(16).min(PLACES)
    }
}

#[inline(always)]
fn at(places: &[Places; 3], i: usize) -> Vec3 {
    vec3(places[0][i], places[1][i], places[2][i])
}

#[inline(always)]
fn set(places: &mut [Places; 3], i: usize, value: Vec3) {
    (places[0][i], places[1][i], places[2][i]) = (value.x, value.y, value.z);
}

/// Uniforms and matrices that all places of one figure share.
pub(super) struct Setting<'a> {
    pub(super) cell: &'a CellUniform,
    pub(super) figure: &'a FigureUniform,
    /// Rows x, y and w of the matrix from the item to clip space.
    pub(super) clip: [[f32; 4]; 3],
    /// Rows of the matrices from the item to the viewer's axes, and to the key light's map.
    pub(super) view: [[f32; 4]; 3],
    pub(super) map: [[f32; 4]; 3],
    pub(super) shadows: bool,
}

#[inline(always)]
fn row(row: &[f32; 4], p: Vec3, w: f32) -> f32 {
    row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3] * w
}

/// Weights of a triangle's corners in clip space at a place, each over w, and their sum.
#[inline(always)]
fn weights(clip: [[f32; 3]; 3], [sx, sy]: [f32; 2]) -> ([f32; 3], f32) {
    // From the place, so that small triangles lose no digits.
    let [p, q, r] = each(clip, |[x, y, w]| [x - sx * w, y - sy * w]);
    let all = [q[0] * r[1] - q[1] * r[0], r[0] * p[1] - r[1] * p[0], p[0] * q[1] - p[1] * q[0]];
    (all, all[0] + all[1] + all[2])
}

/// From corners to what light asks for. `EDGES`: with the weights of the pixels beside.
pub(super) struct Place<'a, 'b, const EDGES: bool>(pub(super) &'b Setting<'a>, pub(super) &'b mut Batch);

impl<const EDGES: bool> Kernel for Place<'_, '_, EDGES> {
    #[inline(always)]
    fn run(self) {
        let Self(setting, b) = self;
        let Setting { cell, figure, .. } = setting;
        let texel = [2.0 / cell.viewport[2], -2.0 / cell.viewport[3]];
        let [left, top, ..] = cell.viewport;
        let orthographic = cell.output[2] > 0.5;
        let key = rgb(cell.lights[0][0]);
        let wrap = shade::wrap(figure);
        let size = cell.shadow_map[1];
        let scale = vec3(0.5 * size, -0.5 * size, 1.0);
        for i in 0..b.padded() {
            let corners = [at(&b.positions[0], i), at(&b.positions[1], i), at(&b.positions[2], i)];
            let clip = each(corners, |p| each(setting.clip, |r| row(&r, p, 1.0)));
            // Its middle in clip space, over w.
            let x = texel[0] * (b.screen[0][i] + 0.5 - left) - 1.0;
            let y = texel[1] * (b.screen[1][i] + 0.5 - top) + 1.0;
            let (all, area) = weights(clip, [x, y]);
            let front = area > 0.0;
            // A sample may be covered where the middle is not: the nearest place that is.
            let inside = each(all, |w| max(if front { w } else { -w }, 0.0));
            let sum = inside[0] + inside[1] + inside[2];
            let there = sum > 0.0;
            let scale_of = 1.0 / if there { sum } else { 3.0 };
            let weight = each(inside, |w| if there { w } else { 1.0 } * scale_of);
            let p = corners[0] * weight[0] + corners[1] * weight[1] + corners[2] * weight[2];
            let normal = at(&b.normals[0], i) * weight[0]
                + at(&b.normals[1], i) * weight[1]
                + at(&b.normals[2], i) * weight[2];
            for k in 0..3 {
                b.weights[k][i] = weight[k];
            }
            if EDGES {
                for (places, [dx, dy]) in [(&mut b.right, [texel[0], 0.0]), (&mut b.below, [0.0, texel[1]])] {
                    let (all, sum) = weights(clip, [x + dx, y + dy]);
                    let sum = if sum == 0.0 { 1.0 } else { sum };
                    for k in 0..3 {
                        places[k][i] = all[k] / sum;
                    }
                }
            }
            let seen = vec3(
                row(&setting.view[0], p, 1.0),
                row(&setting.view[1], p, 1.0),
                row(&setting.view[2], p, 1.0),
            );
            let turned = vec3(
                row(&setting.view[0], normal, 0.0),
                row(&setting.view[1], normal, 0.0),
                row(&setting.view[2], normal, 0.0),
            );
            let towards = shade::normalized(-seen, Vec3::Z);
            let v = if orthographic { Vec3::Z } else { towards };
            let n = shade::normalized(turned, v);
            let side = if front { 1.0 } else { -1.0 };
            let n = n * side;
            set(&mut b.normal, i, n);
            set(&mut b.viewer, i, v);
            b.front[i] = if front { 1.0 } else { 0.0 };
            b.keyed[i] = n.dot(key) + wrap;
            if setting.shadows {
                let on = vec3(
                    row(&setting.map[0], p, 1.0),
                    row(&setting.map[1], p, 1.0),
                    row(&setting.map[2], p, 1.0),
                );
                let off = vec3(
                    row(&setting.map[0], normal, 0.0),
                    row(&setting.map[1], normal, 0.0),
                    row(&setting.map[2], normal, 0.0),
                );
                let on = on * scale + vec3(0.5 * size, 0.5 * size, 0.0);
                // A disc around it stays in the map; places beyond the camera's reach are beyond its edge.
                let on = vec3(clamp(on.x, 6.0, size - 6.0), clamp(on.y, 6.0, size - 6.0), on.z);
                let length = max(turned.dot(turned).sqrt(), 1e-12);
                let grazing = 1.0 - min(turned.dot(key).abs() / length, 1.0);
                let step = cell.shadow_map[2] * (1.0 + 3.0 * grazing) / length;
                set(&mut b.map, i, on + off * scale * (step * side));
            }
        }
    }
}

/// From a palette's answers to colors, linear light.
pub(super) struct Answered<'a, 'b> {
    pub(super) figure: &'a FigureUniform,
    pub(super) map: &'a [[f32; 3]; 256],
    /// The place of the palette, and how far the light of its own exceeds the figure's.
    pub(super) answers: &'b [Places; 2],
    pub(super) batch: &'b mut Batch,
}

impl Kernel for Answered<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self { figure, map, answers: [places, own], batch: b } = self;
        let [glow, _, saturation, circle] = figure.glow;
        let (mut row, mut share) = ([0; PLACES], [0.0; PLACES]);
        for i in 0..b.padded() {
            let at = clamp(palette_place(places[i], circle > 0.5), 0.0, 1.0) * 255.0;
            row[i] = whole(at);
            share[i] = at - row[i] as f32;
        }
        for i in 0..b.count.min(PLACES) {
            let row = (row[i] as usize).min(254);
            let (left, right) = (map[row], map[row + 1]);
            for k in 0..3 {
                b.color[k][i] = mix(left[k], right[k], share[i]);
            }
        }
        for i in 0..b.padded() {
            let c = at(&b.color, i);
            let gray = 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
            let c = each(c.to_array(), |c| max(mix(gray, c, saturation), 0.0));
            set(&mut b.color, i, c.into());
            b.glow[i] = glow + own[i];
        }
    }
}

/// A place in [0, 1] of a palette that runs around, or there and back.
#[inline(always)]
fn palette_place(at: f32, circle: bool) -> f32 {
    let (around, back) = (at - at.floor(), 1.0 - (at - 2.0 * (0.5 * at).floor() - 1.0).abs());
    if circle { around } else { back }
}

/// From places to colors. `FILM`: with the hues of thin films. `AROUND`: in a panorama.
pub(super) struct Light<'a, 'b, const FILM: bool, const AROUND: bool>(
    pub(super) &'b Setting<'a>,
    pub(super) &'b mut Batch,
);

impl<const FILM: bool, const AROUND: bool> Kernel for Light<'_, '_, FILM, AROUND> {
    #[inline(always)]
    fn run(self) {
        let Self(setting, b) = self;
        for i in 0..b.padded() {
            let (n, v) = (at(&b.normal, i), at(&b.viewer, i));
            let of = (setting.cell, setting.figure);
            let around = if AROUND { Some([at(&b.ambient, i), at(&b.mirror, i)]) } else { None };
            let light = (b.key[i], b.glow[i], around);
            let c = shade::modeled::<FILM>(of, at(&b.color, i), n, v, b.front[i] > 0.5, light);
            set(&mut b.color, i, c);
        }
    }
}

/// From places of a heat map to colors.
pub(super) struct LightMap<'a, 'b>(pub(super) &'b Setting<'a>, pub(super) &'b mut Batch);

impl Kernel for LightMap<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self(setting, b) = self;
        for i in 0..b.padded() {
            let (n, v) = (at(&b.normal, i), at(&b.viewer, i));
            let of = (setting.cell, setting.figure);
            let c = shade::mapped(of, at(&b.color, i), n, v, b.front[i] > 0.5);
            set(&mut b.color, i, c);
        }
    }
}

/// From colors to the bytes that are added to pixels.
pub(super) struct Pack<'b> {
    pub(super) opacity: f32,
    pub(super) batch: &'b mut Batch,
}

impl Kernel for Pack<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { opacity, batch: b } = self;
        for i in 0..b.padded() {
            let share = b.share[i] * opacity;
            b.packed[i] = packed(each([b.color[0][i], b.color[1][i], b.color[2][i], 1.0], |c| c * share));
        }
    }
}
