//! Depth of field: how far the light of each depth spreads on the picture, as behind a thin lens. Both renderers use
//! these numbers.

use bytemuck::{Pod, Zeroable};

use crate::{Cell, Finish, Projection};

/// Light spreads on a small picture of about this many rows.
const ROWS: u32 = 360;

/// How many pixels wide a pixel of the small picture is.
pub(crate) fn step(height: u32) -> u32 {
    ((height + 2 * ROWS / 3) / ROWS).max(1)
}

/// How far light spreads at most, as a share of the picture's height.
const MOST: f32 = 0.035;

/// Everything within this share of the camera's reach around the focus is sharp: a dancing shape would keep leaving
/// the focus of a real lens.
const SHARP: f32 = 0.2;

/// Places that are looked at around each pixel.
pub(crate) const TAPS: usize = 64;

/// Circles up to this radius, in pixels of the small picture, are drawn sharp.
pub(crate) const LEAST: f32 = 0.25;

/// How far into what is sharp the colors beside it are continued, pixels of the small picture: pixels of the large one that
/// lie between two of these take none of the sharp color.
pub(crate) const CONTINUED: f32 = 2.0;

/// The part of a disc that a pixel is, where the whole is the square of its radius.
pub(crate) const PIXEL: f32 = std::f32::consts::FRAC_1_PI;

/// The places next to a pixel, all of which are looked at.
const NEAR: [[f32; 2]; 12] = [
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, 1.0],
    [-1.0, -1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [2.0, 0.0],
    [-2.0, 0.0],
    [0.0, 2.0],
    [0.0, -2.0],
];

/// From depths of one cell to circles of light, as `focus.wgsl` describes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Circle {
    /// From a depth in [0, 1] to its distance beyond the focus, over its distance from the eye: the value at 0, and
    /// the slope.
    pub(crate) line: [f32; 2],
    /// Distances below this count as 0.
    pub(crate) sharp: f32,
    /// Radius of the circle per unit of distance beyond that, in pixels of the small picture.
    pub(crate) radius: f32,
    /// No circle is larger.
    pub(crate) most: f32,
    pub(crate) padding: [f32; 3],
}

impl Circle {
    /// The circles of a cell in a picture of `height` rows.
    pub(crate) fn new(finish: &Finish, cell: &Cell<'_>, height: u32) -> Self {
        let camera = &cell.camera;
        let projection = camera.projection_matrix(cell.viewport.aspect());
        let (a, b) = (projection.z_axis.z, projection.w_axis.z);
        let reach = camera.reach.max(1e-6);
        // A focus beside or behind the eye sees nothing.
        let focus = (camera.distance - finish.focus.clamp(-1.0, 1.0) * reach).max(0.1 * reach);
        // With the distance d, depth is b / d - a of a perspective, and b - a d of parallel lines.
        let (line, scale) = match camera.projection {
            Projection::Perspective => ([1.0 - focus * a / b, -focus / b], projection.y_axis.y / focus),
            Projection::Orthographic => ([b / (a * focus) - 1.0, -1.0 / (a * focus)], projection.y_axis.y),
        };
        let rows = cell.viewport.height as f32 / step(height) as f32;
        Self {
            line,
            sharp: SHARP * reach / focus,
            radius: 0.25 * finish.blur.clamp(0.0, 1.0) * reach * scale * rows,
            most: most(height),
            padding: [0.0; 3],
        }
    }

    /// The radius of the circle of light at this depth, in pixels of the small picture; below 0 before the focus.
    /// Depth 1 is behind all figures, infinitely far away.
    #[inline(always)]
    pub(crate) fn at(&self, depth: f32) -> f32 {
        let way = if depth >= 1.0 { 1.0 } else { self.line[0] + self.line[1] * depth };
        let beyond = way.abs() - self.sharp;
        let beyond = if beyond > 0.0 { beyond * self.radius } else { 0.0 };
        let beyond = if beyond < self.most { beyond } else { self.most };
        if way < 0.0 { -beyond } else { beyond }
    }
}

/// How far light spreads at most, in pixels of the small picture.
pub(crate) fn most(height: u32) -> f32 {
    (MOST * height as f32 / step(height) as f32).max(1.0)
}

/// How light spreads on a picture of one size, as `focus.wgsl` describes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Spread {
    pub(crate) size: [f32; 2],
    pub(crate) step: u32,
    pub(crate) padding: u32,
    /// Taps: offset right and down in whole pixels, its length, and the area that the tap stands for (all areas sum
    /// to the squared radius of the disc). Even and odd rows have different taps, which are averaged later.
    pub(crate) taps: [[[f32; 4]; TAPS]; 2],
}

impl Spread {
    /// On a picture of this size.
    pub(crate) fn new([width, height]: [u32; 2]) -> Self {
        const GOLDEN: f32 = 0.618_034;
        let most = most(height);
        let taps = [0.25, 0.75].map(|first| {
            let mut taps = [[0.0; 4]; TAPS];
            for (tap, [x, y]) in taps.iter_mut().zip(NEAR) {
                *tap = [x, y, x.hypot(y), PIXEL];
            }
            // In pairs opposite each other, so that nothing is moved, and denser in the middle, so that small circles have
            // some too.
            let pairs = (TAPS - NEAR.len()) / 2;
            let (least, share) = ((13.0 * PIXEL).sqrt(), |i: usize| (i as f32 + first) / pairs as f32);
            let radius = |i: usize| least + (most - least).max(0.0) * share(i).powf(0.75);
            let area = |i: usize| radius(i) * share(i).powf(-0.25);
            let all: f32 = (0..pairs).map(|i| 2.0 * area(i)).sum();
            for i in 0..pairs {
                let (sin, cos) = (std::f32::consts::PI * (GOLDEN * i as f32 + first)).sin_cos();
                let [x, y] = [cos, sin].map(|c| (radius(i) * c).round());
                let area = area(i) / all * (most * most - least * least).max(0.0);
                taps[NEAR.len() + 2 * i] = [x, y, x.hypot(y), area];
                taps[NEAR.len() + 2 * i + 1] = [-x, -y, x.hypot(y), area];
            }
            taps
        });
        Self { size: [width as f32, height as f32], step: step(height), padding: 0, taps }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Background, Camera, Lights, Rect};

    fn cell(camera: Camera) -> Cell<'static> {
        Cell {
            viewport: Rect::of_size(1280, 720),
            camera,
            lights: Lights::STUDIO,
            background: Background::PAPER,
            figures: &[],
            markers: &[],
        }
    }

    /// The circle of a point this far beyond the target, along the view.
    fn at(finish: &Finish, camera: Camera, beyond: f32) -> f32 {
        let cell = cell(camera);
        let [_, _, back] = camera.axes();
        let point = glam::Vec3::from(camera.target) - back * beyond;
        let (_, depth) = camera.project(point.to_array(), cell.viewport).unwrap_or(([0.0; 2], 1.0));
        Circle::new(finish, &cell, 720).at(depth)
    }

    #[test]
    fn circles_are_those_of_a_thin_lens() {
        let finish = Finish { blur: 0.4, focus: 0.25, ..Finish::NOTHING };
        let camera = Camera { distance: 5.0, reach: 1.2, ..Camera::default() };
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = Camera { projection, ..camera };
            let focus = 5.0 - 0.25 * 1.2;
            for beyond in [-1.1, -0.7, -0.31, -0.2, 0.0, 0.3, 0.9, 1.4] {
                let d = 5.0 + beyond;
                let whole = if projection == Projection::Perspective { d } else { focus };
                let way = (d - focus) / whole;
                let pixels = 0.5 * 0.4 * 1.2 * 360.0
                    / (13.5_f32.to_radians().tan())
                    / if projection == Projection::Perspective { focus } else { 5.0 };
                let sharp = 0.2 * 1.2 / focus;
                let wanted = (way.signum() * (way.abs() - sharp).max(0.0) * pixels / 2.0).clamp(-12.6, 12.6);
                let found = at(&finish, camera, beyond);
                assert!((found - wanted).abs() < 1e-2, "{projection:?} {beyond}: {found} for {wanted}");
            }
        }
        let behind = Circle::new(&finish, &cell(camera), 720);
        assert_eq!(behind.at(1.0), behind.most);
    }

    #[test]
    fn what_is_out_of_focus_is_as_soft_in_every_size() {
        let finish = Finish { blur: 0.5, ..Finish::NOTHING };
        let camera = Camera { distance: 5.0, reach: 1.2, ..Camera::default() };
        let share = |height: u32| {
            let cell = Cell { viewport: Rect::of_size(16 * height / 9, height), ..cell(camera) };
            Circle::new(&finish, &cell, height).at(0.99) * step(height) as f32 / height as f32
        };
        for height in [240, 480, 1080, 2160] {
            assert!((share(height) / share(720) - 1.0).abs() < 0.01, "{height}");
        }
    }

    #[test]
    fn taps_cover_the_disc_and_move_nothing() {
        for height in [48, 360, 720, 1080] {
            let spread = Spread::new([2 * height, height]);
            let most = most(height);
            for taps in &spread.taps {
                let sum = |k: usize| taps.iter().map(|tap| tap[k] * tap[3]).sum::<f32>();
                assert!(sum(0).abs() < 1e-3 && sum(1).abs() < 1e-3);
                let area: f32 = PIXEL + taps.iter().map(|tap| tap[3]).sum::<f32>();
                assert!((area / (most * most).max(13.0 * PIXEL) - 1.0).abs() < 1e-4, "{height}: {area}");
                assert!(taps.iter().all(|tap| tap[2] <= most.max(2.0) + 1.0));
            }
        }
    }
}
