//! egui's triangles on the processor: which pixels of which rows they cover, and with what.
//!
//! Blending is that of egui's other painters: sums of premultiplied sRGB numbers. Textures are clamped at their edges.

use std::collections::HashMap;
use std::sync::Arc;

use egui::{ColorImage, ImageData, TextureFilter, TextureId, TexturesDelta};
use epaint::{ClippedPrimitive, ImageDelta, Mesh, Primitive, Vertex};
use rayon::prelude::*;

use super::span::{Gradient, Ink, Span, Texels};

/// Rows that one thread paints at a time.
const BAND: usize = 32;
/// Parts of a pixel to which corners are rounded, so that triangles that share an edge share no pixel and leave none.
const PARTS: i64 = 256;

/// Textures of a window, and the memory of its triangles. Keep it from frame to frame.
#[derive(Default)]
pub struct Painter {
    textures: HashMap<TextureId, Texture>,
    triangles: Vec<Triangle>,
    /// Which triangles touch each band, in their order.
    bands: Vec<Vec<u32>>,
}

struct Texture {
    image: Arc<ColorImage>,
    linear: bool,
}

/// A triangle in pixels.
struct Triangle {
    /// In parts of a pixel, clockwise as seen.
    corners: [[i64; 2]; 3],
    /// First and last but one of columns and rows.
    clip: [[i64; 2]; 2],
    texture: TextureId,
    ink: Ink,
}

impl Painter {
    /// Takes new and changed textures.
    pub fn update(&mut self, delta: &mut TexturesDelta) {
        for (id, changes) in delta.set.drain() {
            for change in changes {
                self.change(id, change);
            }
        }
    }

    /// Forgets the textures that nobody will show again.
    pub fn forget(&mut self, delta: &mut TexturesDelta) {
        for id in delta.free.drain() {
            self.textures.remove(&id);
        }
    }

    fn change(&mut self, id: TextureId, change: ImageDelta) {
        let ImageData::Color(image) = change.image;
        let linear = change.options.magnification == TextureFilter::Linear;
        let Some([left, top]) = change.pos else {
            self.textures.insert(id, Texture { image, linear });
            return;
        };
        let Some(texture) = self.textures.get_mut(&id) else { return };
        let whole = Arc::make_mut(&mut texture.image);
        let [width, _] = whole.size;
        let rows = image.pixels.chunks_exact(image.size[0].max(1));
        for (row, y) in rows.zip(top..) {
            let first = y * width + left;
            if let Some(place) = whole.pixels.get_mut(first..first + row.len()) {
                place.copy_from_slice(row);
            }
        }
    }

    /// Paints over `background` into `pixels`, `width` a row: 0xAARRGGBB.
    pub fn paint(
        &mut self,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
        width: usize,
        background: u32,
        pixels: &mut [u32],
    ) {
        let size = [width, pixels.len() / width.max(1)];
        self.triangles.clear();
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            // Nothing here can draw for others.
            let Primitive::Mesh(mesh) = primitive else { continue };
            let clip = clip(*clip_rect, pixels_per_point, size);
            if clip.iter().all(|[first, end]| first < end) {
                self.take(mesh, pixels_per_point, clip);
            }
        }
        self.sort(size[1]);
        let (textures, triangles) = (&self.textures, &self.triangles);
        pixels.par_chunks_mut((BAND * width).max(1)).zip(&self.bands).enumerate().for_each(
            |(band, (pixels, touching))| {
                pixels.fill(background);
                for index in touching {
                    if let Some(triangle) = triangles.get(*index as usize) {
                        triangle.paint(textures, (band * BAND) as i64, width, pixels);
                    }
                }
            },
        );
    }

    /// The triangles of `mesh` that cover anything.
    fn take(&mut self, mesh: &Mesh, pixels_per_point: f32, clip: [[i64; 2]; 2]) {
        let Some(texture) = self.textures.get(&mesh.texture_id) else { return };
        for corners in mesh.indices.as_chunks::<3>().0 {
            let [Some(a), Some(b), Some(c)] = corners.map(|index| mesh.vertices.get(index as usize)) else {
                continue;
            };
            let placed = |vertex: &Vertex| {
                [vertex.pos.x, vertex.pos.y]
                    .map(|points| (points * pixels_per_point * PARTS as f32).round() as i32 as i64)
            };
            let (mut corners, mut vertices) = ([a, b, c].map(placed), [a, b, c]);
            let area = edge(corners[0], corners[1], corners[2]);
            if area < 0 {
                corners.swap(1, 2);
                vertices.swap(1, 2);
            }
            let seen = |axis: usize| {
                let of = corners.map(|corner| corner[axis]);
                let [first, end] = clip[axis];
                let (low, high) = (of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2]));
                first * PARTS < high && low < end * PARTS
            };
            if area != 0 && seen(0) && seen(1) {
                let ink = ink(&corners, vertices, area.abs(), texture);
                self.triangles.push(Triangle { corners, clip, texture: mesh.texture_id, ink });
            }
        }
    }

    fn sort(&mut self, rows: usize) {
        self.bands.resize_with(rows.div_ceil(BAND), Vec::new);
        self.bands.iter_mut().for_each(Vec::clear);
        for (triangle, index) in self.triangles.iter().zip(0..) {
            let [first, end] = triangle.rows();
            for band in first as usize / BAND..(end.max(0) as usize).div_ceil(BAND) {
                self.bands[band].push(index);
            }
        }
    }
}

/// Columns and rows of a clip rectangle.
fn clip(rect: egui::Rect, pixels_per_point: f32, size: [usize; 2]) -> [[i64; 2]; 2] {
    let whole = |points: f32, most: usize| ((points * pixels_per_point).round() as i64).clamp(0, most as i64);
    [
        [whole(rect.min.x, size[0]), whole(rect.max.x, size[0])],
        [whole(rect.min.y, size[1]), whole(rect.max.y, size[1])],
    ]
}

/// Twice the area of a, b, c; above 0 where they are clockwise as seen.
fn edge(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The fill of a triangle.
fn ink(corners: &[[i64; 2]; 3], vertices: [&Vertex; 3], area: i64, texture: &Texture) -> Ink {
    let [a, b, c] = corners.map(|corner| corner.map(|parts| parts as f64 / PARTS as f64));
    let area = area as f64 / (PARTS * PARTS) as f64;
    let gradient = |values: [f32; 3]| {
        let [va, vb, vc] = values.map(f64::from);
        let (ab, ac) = (vb - va, vc - va);
        let x = (ab * (c[1] - a[1]) - ac * (b[1] - a[1])) / area;
        let y = (ac * (b[0] - a[0]) - ab * (c[0] - a[0])) / area;
        // At the middle of the first pixel.
        Gradient { x: x as f32, y: y as f32, at: (va + x * (0.5 - a[0]) + y * (0.5 - a[1])) as f32 }
    };
    let colors = vertices.map(|vertex| vertex.color.to_array());
    let color = |channel: usize| gradient(colors.map(|color| f32::from(color[channel])));
    let flat = (colors[0] == colors[1] && colors[1] == colors[2]).then_some(colors[0]);
    let [width, height] = texture.image.size.map(|length| length as f32);
    let uv = vertices.map(|vertex| [vertex.uv.x * width, vertex.uv.y * height]);
    let texels = if uv[0] == uv[1] && uv[1] == uv[2] {
        Texels::One(texel(&texture.image, uv[0]))
    } else {
        Texels::Many {
            across: gradient(uv.map(|uv| uv[0])),
            down: gradient(uv.map(|uv| uv[1])),
            linear: texture.linear,
        }
    };
    Ink::new(flat.ok_or_else(|| [0, 1, 2, 3].map(color)), texels)
}

fn texel(image: &ColorImage, uv: [f32; 2]) -> [u8; 4] {
    let [x, y] = [0, 1].map(|axis| (uv[axis] as usize).min(image.size[axis].saturating_sub(1)));
    image.pixels.get(y * image.size[0] + x).map_or([0; 4], |color| color.to_array())
}

impl Triangle {
    /// The first row that it may reach, and the first one below.
    fn rows(&self) -> [i64; 2] {
        let of = self.corners.map(|corner| corner[1]);
        let last = |parts: i64| (parts - PARTS / 2).div_euclid(PARTS);
        let [first, end] = self.clip[1];
        let (low, high) = (of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2]));
        [last(low).clamp(first, end), (last(high) + 1).clamp(first, end)]
    }

    /// Paints the rows that lie in a band from row `top` on.
    fn paint(&self, textures: &HashMap<TextureId, Texture>, top: i64, width: usize, pixels: &mut [u32]) {
        let Some(texture) = textures.get(&self.texture) else { return };
        let height = (pixels.len() / width) as i64;
        let [first, end] = self.rows();
        for y in first.max(top)..end.min(top + height) {
            let [left, right] = self.columns(y);
            if left < right {
                let row = (y - top) as usize * width;
                let pixels = &mut pixels[row + left as usize..row + right as usize];
                self.ink.paint(&texture.image, Span { x: left as f32, y: y as f32 }, pixels);
            }
        }
    }

    /// The columns whose middles it covers in row `y`, exactly: a middle on an edge belongs to the triangle for which
    /// that is a top or a left edge.
    fn columns(&self, y: i64) -> [i64; 2] {
        let [mut left, mut right] = self.clip[0];
        let middle = PARTS / 2;
        let yc = y * PARTS + middle;
        for i in 0..3 {
            let ([xa, ya], [xb, yb]) = (self.corners[i], self.corners[(i + 1) % 3]);
            let (dx, dy) = (xb - xa, yb - ya);
            let is_top_left = dy < 0 || dy == 0 && dx > 0;
            // Inside: dx (yc − ya) − dy (xc − xa) ≥ 0, or > 0.
            let n = dx * (yc - ya) + dy * xa - i64::from(!is_top_left);
            match dy.signum() {
                0 if n < 0 => return [0, 0],
                0 => {}
                // xc ≤ n / dy
                1 => right = right.min((n.div_euclid(dy) - middle).div_euclid(PARTS) + 1),
                // xc ≥ n / dy, where dy < 0
                _ => left = left.max((-n.div_euclid(-dy) - middle + PARTS - 1).div_euclid(PARTS)),
            }
        }
        [left, right.max(left)]
    }
}

#[cfg(test)]
mod tests;
