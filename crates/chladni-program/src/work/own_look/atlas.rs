//! One picture of several, side by side: a figure is drawn with one image.

use chladni_view::Picture;

/// Pixels around each picture, in which it goes on as if repeated: smaller levels do not mix it with its neighbors soon.
const GUTTER: u32 = 16;
/// The pixels that all pictures and their gutters have together, but for those that would vanish.
const MOST_PIXELS: u64 = 20 << 20;
/// The longest side of a picture with its copies.
const LONGEST: u32 = 4096;
/// The longest side of all.
const MOST_SIDE: u32 = 8192;
/// Triangles reach over so many copies of a picture, those that reach over more are drawn with fewer.
const MOST_COPIES: f32 = 8.0;
/// So far a triangle may reach beyond a picture without a copy, as numbers are rounded.
const SLACK: f32 = 1e-3;

/// How several pictures share one.
pub struct Atlas {
    /// How often each is repeated to the right and upward.
    copies: Vec<[u32; 2]>,
    /// The longest side of each without its copies.
    sides: Vec<u32>,
    /// Whether pictures have to be made smaller, or are repeated less often.
    pub is_coarse: bool,
}

impl Atlas {
    /// For pictures of these `sizes`, of which `of_triangle` names one for each triangle. Moves `uvs`, where the triangles'
    /// corners lie on a picture that is repeated beyond its edges (v upward), to its first copies.
    ///
    /// # Panics
    /// If `of_triangle` names a picture that is not there.
    pub fn of(sizes: &[[u32; 2]], of_triangle: &[usize], uvs: &mut [[[f32; 2]; 3]]) -> Self {
        let (mut copies, mut is_coarse) = (vec![[1; 2]; sizes.len()], false);
        for (corners, &of) in uvs.iter_mut().zip(of_triangle) {
            if sizes[of] == [1, 1] || !corners.as_flattened().iter().all(|x| x.is_finite()) {
                *corners = [[0.5; 2]; 3];
                continue;
            }
            for (axis, copies) in copies[of].iter_mut().enumerate() {
                let (needed, fits) = to_first_copies(corners, axis);
                *copies = needed.max(*copies);
                is_coarse |= !fits;
            }
        }
        let sides = sides(sizes, &copies);
        is_coarse |= sizes.iter().zip(&sides).any(|([width, height], side)| side < width.max(height));
        Self { copies, sides, is_coarse }
    }

    /// The longest side that picture `i` may have.
    pub fn side(&self, i: usize) -> u32 {
        self.sides[i]
    }

    /// Lays the pictures side by side and moves `uvs` from a picture of their own to there.
    ///
    /// # Panics
    /// If there are fewer pictures than sizes.
    pub fn lay_out(self, pictures: &[Picture], of_triangle: &[usize], uvs: &mut [[[f32; 2]; 3]]) -> Picture {
        let inner = |i: usize| {
            let [right, up] = self.copies[i];
            [pictures[i].width * right, pictures[i].height * up]
        };
        let sizes: Vec<[u32; 2]> = (0..self.copies.len()).map(inner).collect();
        let (places, [width, height]) = in_rows(&sizes);
        let mut sheet = Picture::filled(width, height, [128, 128, 128, 255]);
        for ((picture, size), place) in pictures.iter().zip(&sizes).zip(&places) {
            lay(picture, *size, *place, &mut sheet);
        }
        for (corners, &of) in uvs.iter_mut().zip(of_triangle) {
            let (picture, [inner_width, inner_height], [left, top]) = (&pictures[of], sizes[of], places[of]);
            // Not nearer to an edge than half a pixel: beyond it lies the gutter, with the opposite edge's colors.
            let within = |pixels: f32, side: u32| pixels.clamp(0.5, side as f32 - 0.5);
            for [u, v] in corners {
                let x = within(*u * picture.width as f32, inner_width);
                let y = within(inner_height as f32 - *v * picture.height as f32, inner_height);
                *u = ((left + GUTTER) as f32 + x) / width as f32;
                *v = 1.0 - ((top + GUTTER) as f32 + y) / height as f32;
            }
        }
        sheet.thumbnail(MOST_SIDE)
    }
}

/// Moves a triangle along one axis by whole pictures to the first copy that it touches. Returns how many it touches, and
/// whether these are all that it touched.
fn to_first_copies(corners: &mut [[f32; 2]; 3], axis: usize) -> (u32, bool) {
    let all = || corners.iter().map(|uv| uv[axis]);
    let least = all().fold(f32::INFINITY, f32::min);
    let most = all().fold(f32::NEG_INFINITY, f32::max);
    let first = (least + SLACK).floor();
    let fits = most - first <= MOST_COPIES + SLACK;
    // Drawn as if it were smaller.
    let scale = if fits { 1.0 } else { (MOST_COPIES - (least - first)) / (most - least) };
    for uv in corners.iter_mut() {
        uv[axis] = (least - first) + (uv[axis] - least) * scale;
    }
    let reach = corners.iter().map(|uv| uv[axis]).fold(0.0, f32::max);
    (((reach - SLACK).ceil() as u32).max(1), fits)
}

/// The longest side that each of several pictures of these sizes may have, so that with copies and gutters they share
/// [`MOST_PIXELS`]: what small ones leave is for the large.
fn sides(sizes: &[[u32; 2]], copies: &[[u32; 2]]) -> Vec<u32> {
    let pixels = |i: usize, size: [u32; 2]| {
        let outer = |axis: usize| u64::from(size[axis]) * u64::from(copies[i][axis]) + u64::from(2 * GUTTER);
        outer(0) * outer(1)
    };
    let textures = || (0..sizes.len()).filter(|i| sizes[*i] != [1, 1]);
    let mut smallest_first: Vec<usize> = textures().collect();
    smallest_first.sort_by_key(|&i| pixels(i, sizes[i]));
    let (mut left, mut others) = (MOST_PIXELS, smallest_first.len() as u64);
    let mut sides = vec![1; sizes.len()];
    for i in smallest_first {
        let share = left / others.max(1);
        let is_short = |size: [u32; 2]| (0..2).all(|axis| size[axis] * copies[i][axis] <= LONGEST);
        let (mut scale, mut size) = (1.0, sizes[i]);
        while size != [1, 1] && (!is_short(size) || pixels(i, size) > share) {
            scale *= 0.98;
            size = sizes[i].map(|side| ((f64::from(side) * scale) as u32).max(1));
        }
        sides[i] = size[0].max(size[1]);
        (left, others) = (left.saturating_sub(pixels(i, size)), others - 1);
    }
    sides
}

/// Upper left corners of rectangles of these sizes and a gutter around each, side by side in rows, the highest first; and the
/// size of all of them.
fn in_rows(sizes: &[[u32; 2]]) -> (Vec<[u32; 2]>, [u32; 2]) {
    let outer = |i: usize| sizes[i].map(|side| side + 2 * GUTTER);
    let mut by_height: Vec<usize> = (0..sizes.len()).collect();
    by_height.sort_by_key(|&i| std::cmp::Reverse(sizes[i][1]));
    let area: f64 = by_height.iter().map(|&i| outer(i).map(f64::from).iter().product::<f64>()).sum();
    let widest = by_height.iter().map(|&i| outer(i)[0]).max().unwrap_or(1);
    let width = widest.max(area.sqrt().ceil() as u32);
    let mut places = vec![[0; 2]; sizes.len()];
    let ([mut left, mut top], mut bottom) = ([0, 0], 0);
    for i in by_height {
        let [w, h] = outer(i);
        if left + w > width {
            (left, top) = (0, bottom);
        }
        places[i] = [left, top];
        left += w;
        bottom = bottom.max(top + h);
    }
    (places, [width, bottom.max(1)])
}

/// Fills `size` pixels of `sheet` and the gutter around them with copies of `picture`; `[left, top]` is where the gutter begins.
fn lay(picture: &Picture, size: [u32; 2], [left, top]: [u32; 2], sheet: &mut Picture) {
    // The pixel where the gutter begins, as if copies went on forever.
    let begins = |side: u32| (side - GUTTER % side) % side;
    let [from_x, from_y] = [begins(picture.width), begins(picture.height)];
    for j in 0..size[1] + 2 * GUTTER {
        let row = 4 * ((from_y + j) % picture.height) as usize * picture.width as usize;
        let row = &picture.rgba[row..row + 4 * picture.width as usize];
        let pixels = row.chunks_exact(4).cycle().skip(from_x as usize);
        let at = 4 * ((top + j) as usize * sheet.width as usize + left as usize);
        let target = &mut sheet.rgba[at..at + 4 * (size[0] + 2 * GUTTER) as usize];
        for (to, from) in target.chunks_exact_mut(4).zip(pixels) {
            to.copy_from_slice(from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{middle, pixel_at};
    use super::*;
    use proptest::prelude::*;

    const RED: [u8; 4] = [255, 0, 0, 255];
    const GREEN: [u8; 4] = [0, 255, 0, 255];
    const BLUE: [u8; 4] = [0, 0, 255, 128];
    const GRAY: [u8; 4] = [90, 90, 90, 255];

    fn sizes(pictures: &[Picture]) -> Vec<[u32; 2]> {
        pictures.iter().map(|picture| [picture.width, picture.height]).collect()
    }

    #[test]
    fn every_triangle_sees_the_part_of_its_own_picture() {
        let four = Picture { width: 2, height: 2, rgba: [RED, GREEN, BLUE, GRAY].concat() };
        let wide = Picture { width: 40, height: 1, rgba: [BLUE.repeat(20), RED.repeat(20)].concat() };
        let pictures = [four, Picture::filled(1, 1, GRAY), wide];
        let small = |u: f32, v: f32| [[u - 0.1, v - 0.1], [u + 0.2, v - 0.1], [u - 0.1, v + 0.2]];
        let expected = [
            (0, small(0.25, 0.75), RED),
            (0, small(0.75, 0.75), GREEN),
            (0, small(0.25, 0.25), BLUE),
            (0, small(0.75, 0.25), GRAY),
            // Copies to the left and below, and far away.
            (0, small(-0.75, -0.25), RED),
            (0, small(41.75, 7.25), GRAY),
            // Over several copies at once, with its middle in the second to the right and the third upward.
            (0, [[0.25, 0.25], [1.75, 2.25], [1.75, 4.5]], BLUE),
            (1, small(0.3, 0.3), GRAY),
            (1, [[f32::NAN; 2]; 3], GRAY),
            (2, small(0.25, 0.5), BLUE),
            (2, small(-0.25, 0.5), RED),
        ];
        let of_triangle: Vec<usize> = expected.iter().map(|(of, _, _)| *of).collect();
        let mut uvs: Vec<[[f32; 2]; 3]> = expected.iter().map(|(_, corners, _)| *corners).collect();
        let atlas = Atlas::of(&sizes(&pictures), &of_triangle, &mut uvs);
        assert!(!atlas.is_coarse && atlas.copies == [[2, 5], [1, 1], [1, 1]], "{:?}", atlas.copies);
        let sheet = atlas.lay_out(&pictures, &of_triangle, &mut uvs);
        assert!(sheet.width < 200 && sheet.height < 200, "{}×{}", sheet.width, sheet.height);
        for (nth, (corners, (_, _, color))) in uvs.iter().zip(&expected).enumerate() {
            assert_eq!(pixel_at(&sheet, middle(*corners)), *color, "triangle {nth}: {corners:?}");
        }
        // The wide one goes on beyond its left edge: its leftmost corner lies 0.15 of 40 pixels from there.
        let beyond = [uvs[9][0][0] - 10.0 / sheet.width as f32, uvs[9][0][1]];
        assert_eq!(pixel_at(&sheet, beyond), RED);
    }

    #[test]
    fn edges_are_the_pictures_own_and_need_no_copy() {
        let pictures = [
            Picture { width: 2, height: 2, rgba: [RED, GREEN, BLUE, GRAY].concat() },
            Picture::filled(1, 1, [7, 7, 7, 255]),
        ];
        // The whole picture, as numbers are rounded.
        let mut uvs = [[[-1e-7, 1.000_000_1], [1.0, 1.0], [0.0, 0.0]], [[0.0; 2]; 3]];
        let atlas = Atlas::of(&sizes(&pictures), &[0, 1], &mut uvs);
        assert!(!atlas.is_coarse && atlas.copies == [[1, 1], [1, 1]], "{:?}", atlas.copies);
        let sheet = atlas.lay_out(&pictures, &[0, 1], &mut uvs);
        assert_eq!(uvs[0].map(|uv| pixel_at(&sheet, uv)), [RED, GREEN, BLUE]);
    }

    #[test]
    fn large_pictures_share_what_small_ones_leave() {
        let color = |i: usize| [(i % 250) as u8, (i / 250) as u8, 9, 255];
        let mut pictures: Vec<Picture> = (0..6).map(|i| Picture::filled(3000, 2000, color(i))).collect();
        pictures.extend((6..60).map(|i| Picture::filled(64, 64, color(i))));
        pictures.extend((60..1000).map(|i| Picture::filled(1, 1, color(i))));
        let of_triangle: Vec<usize> = (0..pictures.len()).collect();
        let mut uvs = vec![[[0.2, 0.2], [0.8, 0.2], [0.2, 0.8]]; pictures.len()];
        // A large one is repeated very often.
        uvs[5] = [[0.5, 0.5], [1e6, 0.5], [0.5, 1e6]];
        let atlas = Atlas::of(&sizes(&pictures), &of_triangle, &mut uvs);
        assert!(atlas.is_coarse && atlas.copies[5] == [8, 8], "{:?}", atlas.copies[5]);
        assert!((1800..3000).contains(&atlas.side(0)) && atlas.side(6) == 64, "{:?}", &atlas.sides[..7]);
        let pictures: Vec<Picture> =
            pictures.into_iter().enumerate().map(|(i, picture)| picture.thumbnail(atlas.side(i))).collect();
        let sheet = atlas.lay_out(&pictures, &of_triangle, &mut uvs);
        assert!(sheet.width.max(sheet.height) <= MOST_SIDE, "{}×{}", sheet.width, sheet.height);
        for (t, corners) in uvs.iter().enumerate() {
            assert_eq!(pixel_at(&sheet, middle(*corners)), color(t), "{t}");
        }
    }

    #[test]
    fn the_thinnest_and_most_repeated_pictures_stay_small() {
        let (long, few) = ([[0.0, 0.0], [1e9, 0.0], [0.0, 1e9]], [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]]);
        for (sizes, corners) in [
            (vec![[16_384, 1], [1, 16_384]], long),
            (vec![[16_384, 1]; 1024], few),
            (vec![[16_384, 1]; 1024], long),
            (vec![[16_384, 4096]; 1024], long),
            (vec![[1024, 4], [2048, 2048]], long),
            (vec![[16_384, 64], [64, 16_384], [1, 1]], few),
        ] {
            let of_triangle: Vec<usize> = (0..sizes.len()).collect();
            let atlas = Atlas::of(&sizes, &of_triangle, &mut vec![corners; sizes.len()]);
            let inner = |(i, [width, height]): (usize, &[u32; 2])| {
                let shrunk = |side: &u32| (side * atlas.side(i) / width.max(height)).max(1);
                [shrunk(width) * atlas.copies[i][0], shrunk(height) * atlas.copies[i][1]]
            };
            let inner: Vec<[u32; 2]> = sizes.iter().enumerate().map(inner).collect();
            let (_, [width, height]) = in_rows(&inner);
            let pixels = u64::from(width) * u64::from(height);
            assert!(atlas.is_coarse && pixels < 4 * MOST_PIXELS, "{:?}: {width}×{height}", &sizes[..2]);
        }
    }

    /// The color of the pixel (x, y) of picture `i`.
    fn color(i: usize, x: u32, y: u32) -> [u8; 4] {
        [i as u8, x as u8, y as u8, 255]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn each_point_of_a_triangle_is_where_it_was_on_its_repeated_picture(
            sizes in prop::collection::vec([1_u32..40, 1_u32..40], 1..6),
            // A picture, the copy of it where a triangle begins, and its corners over seven copies from there.
            triangles in prop::collection::vec(
                (0_usize..6, [-3_i32..4, -3..4], prop::array::uniform3([0.0_f32..1.0, 0.0..1.0])),
                1..20,
            ),
            [a, b] in [0.05_f32..0.45, 0.05_f32..0.45],
        ) {
            let pictures: Vec<Picture> = sizes.iter().enumerate().map(|(i, &[width, height])| {
                let pixels = (0..height).flat_map(|y| (0..width).map(move |x| color(i, x, y)));
                Picture { width, height, rgba: pixels.flatten().collect() }
            }).collect();
            let of_triangle: Vec<usize> = triangles.iter().map(|(of, ..)| of % sizes.len()).collect();
            // In the middle of a pixel.
            let corner = |of: usize, copy: [i32; 2], at: [f32; 2]| [0, 1].map(|axis| {
                let side = sizes[of][axis] as f32;
                copy[axis] as f32 + ((7.0 * side * at[axis]).floor() + 0.5) / side
            });
            let mut uvs: Vec<[[f32; 2]; 3]> = triangles
                .iter()
                .zip(&of_triangle)
                .map(|((_, copy, corners), &of)| corners.map(|at| corner(of, *copy, at)))
                .collect();
            let inside = |corners: &[[f32; 2]; 3]| {
                [0, 1].map(|axis| a * corners[0][axis] + b * corners[1][axis] + (1.0 - a - b) * corners[2][axis])
            };
            let expected: Vec<[f32; 2]> = uvs.iter().map(inside).collect();
            let atlas = Atlas::of(&sizes, &of_triangle, &mut uvs);
            prop_assert!(!atlas.is_coarse);
            let sheet = atlas.lay_out(&pictures, &of_triangle, &mut uvs);
            for ((corners, &of), was) in uvs.iter().zip(&of_triangle).zip(&expected) {
                // Where it is clear in which pixel.
                let is_near_edge = |axis: usize| {
                    let pixels = was[axis] * sizes[of][axis] as f32;
                    (pixels - pixels.round()).abs() < 0.02
                };
                if !is_near_edge(0) && !is_near_edge(1) {
                    prop_assert_eq!(pixel_at(&sheet, inside(corners)), pixel_at(&pictures[of], *was));
                }
            }
        }
    }
}
