//! One picture of several, side by side: a figure is drawn with one image.

use chladni_view::Picture;

/// Pixels around each picture, in which it goes on as if repeated: smaller levels do not mix it with its neighbors soon.
const GUTTER: u32 = 16;
/// The pixels that all pictures have together, nearly.
pub const MOST_PIXELS: u64 = 16 << 20;
/// The longest side.
const MOST_SIDE: u32 = 8192;
/// How far a triangle may reach over a picture that is repeated.
const MOST_COPIES: f32 = 256.0;

/// Lays `pictures` side by side and moves the places of corners, three a triangle, v upward, from a picture of their own
/// to there: `pictures[of_triangle[t]]` for triangle t. Beyond its edges a picture is repeated. Also returns whether pictures
/// had to be made smaller.
///
/// # Panics
/// If `of_triangle` names a picture that is not there.
pub fn atlas(
    mut pictures: Vec<Picture>,
    of_triangle: &[usize],
    uvs: &mut [[[f32; 2]; 3]],
) -> (Picture, bool) {
    let copies = copies(&pictures, of_triangle, uvs);
    let textures = pictures.iter().filter(|picture| !is_plain(picture)).count() as u64;
    let share = MOST_PIXELS / textures.max(1);
    let mut is_coarse = false;
    for (picture, copies) in pictures.iter_mut().zip(&copies) {
        is_coarse |= shrink(picture, share / (u64::from(copies[0]) * u64::from(copies[1])));
    }
    let sizes: Vec<[u32; 2]> =
        pictures.iter().zip(&copies).map(|(p, [i, j])| [p.width * i, p.height * j]).collect();
    let (places, [width, height]) = in_rows(&sizes);
    let mut sheet = Picture::filled(width, height, [128, 128, 128, 255]);
    for ((picture, size), place) in pictures.iter().zip(&sizes).zip(&places) {
        lay(picture, *size, *place, &mut sheet);
    }
    for (corners, &of) in uvs.iter_mut().zip(of_triangle) {
        let (picture, [left, top], rows) = (&pictures[of], places[of], copies[of][1]);
        for [u, v] in corners {
            let x = (left + GUTTER) as f32 + *u * picture.width as f32;
            let y = (top + GUTTER) as f32 + (rows as f32 - *v) * picture.height as f32;
            (*u, *v) = (x / width as f32, 1.0 - y / height as f32);
        }
    }
    is_coarse |= width.max(height) > MOST_SIDE;
    (sheet.thumbnail(MOST_SIDE), is_coarse)
}

/// Whether it has one color only, wherever on it a corner lies.
fn is_plain(picture: &Picture) -> bool {
    picture.width == 1 && picture.height == 1
}

/// How often each picture has to be repeated to the right and upward, so that every triangle finds its part at once. Moves
/// every triangle by whole pictures to the first that it touches.
fn copies(pictures: &[Picture], of_triangle: &[usize], uvs: &mut [[[f32; 2]; 3]]) -> Vec<[u32; 2]> {
    let mut copies = vec![[1; 2]; pictures.len()];
    for (corners, &of) in uvs.iter_mut().zip(of_triangle) {
        if is_plain(&pictures[of]) || !corners.as_flattened().iter().all(|x| x.is_finite()) {
            *corners = [[0.5; 2]; 3];
            continue;
        }
        for (axis, copies) in copies[of].iter_mut().enumerate() {
            let first = corners.iter().map(|uv| uv[axis]).fold(f32::INFINITY, f32::min).floor();
            for uv in corners.iter_mut() {
                uv[axis] = (uv[axis] - first).clamp(0.0, MOST_COPIES);
                *copies = (*copies).max(uv[axis].ceil() as u32);
            }
        }
    }
    copies
}

/// Makes `picture` smaller if it has more than `pixels`; returns whether it had.
pub fn shrink(picture: &mut Picture, pixels: u64) -> bool {
    let has = u64::from(picture.width) * u64::from(picture.height);
    if has <= pixels.max(1) {
        return false;
    }
    let side = f64::from(picture.width.max(picture.height)) * (pixels as f64 / has as f64).sqrt();
    *picture = std::mem::take(picture).thumbnail((side as u32).max(1));
    true
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
        let row = 4 * (u64::from((from_y + j) % picture.height) * u64::from(picture.width)) as usize;
        let mut pixels = picture.rgba[row..row + 4 * picture.width as usize].chunks_exact(4).cycle();
        let mut pixels = pixels.by_ref().skip(from_x as usize);
        let at = 4 * (u64::from(top + j) * u64::from(sheet.width) + u64::from(left)) as usize;
        let target = &mut sheet.rgba[at..at + 4 * (size[0] + 2 * GUTTER) as usize];
        for (to, from) in target.chunks_exact_mut(4).zip(&mut pixels) {
            to.copy_from_slice(from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{middle, pixel_at};
    use super::*;

    #[test]
    fn every_triangle_sees_the_part_of_its_own_picture() {
        let [red, green, blue, gray] =
            [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 128], [90, 90, 90, 255]];
        // Upper row: red, green; lower row: blue, gray. And a plain one, and one that is wide.
        let four = Picture { width: 2, height: 2, rgba: [red, green, blue, gray].concat() };
        let wide = Picture { width: 40, height: 1, rgba: [blue.repeat(20), red.repeat(20)].concat() };
        let pictures = vec![four, Picture::filled(1, 1, gray), wide];
        let small = |u: f32, v: f32| [[u - 0.1, v - 0.1], [u + 0.2, v - 0.1], [u - 0.1, v + 0.2]];
        let expected = [
            (0, small(0.25, 0.75), red),
            (0, small(0.75, 0.75), green),
            (0, small(0.25, 0.25), blue),
            (0, small(0.75, 0.25), gray),
            // Copies to the left and below, and far away.
            (0, small(-0.75, -0.25), red),
            (0, small(41.75, 7.25), gray),
            // Over several copies at once, with its middle in the second to the right and the third upward.
            (0, [[0.25, 0.25], [1.75, 2.25], [1.75, 4.5]], blue),
            (1, small(0.3, 0.3), gray),
            (1, [[f32::NAN; 2]; 3], gray),
            (2, small(0.25, 0.5), blue),
            (2, small(-0.25, 0.5), red),
        ];
        let of_triangle: Vec<usize> = expected.iter().map(|(of, _, _)| *of).collect();
        let mut uvs: Vec<[[f32; 2]; 3]> = expected.iter().map(|(_, corners, _)| *corners).collect();
        let (sheet, is_coarse) = atlas(pictures, &of_triangle, &mut uvs);
        assert!(!is_coarse && sheet.width < 200 && sheet.height < 200, "{}×{}", sheet.width, sheet.height);
        for (nth, (corners, (_, _, color))) in uvs.iter().zip(&expected).enumerate() {
            assert_eq!(pixel_at(&sheet, middle(*corners)), *color, "triangle {nth}: {corners:?}");
        }
        // A picture goes on beyond its edges.
        let beyond = [uvs[1][1][0] + 1.0 / sheet.width as f32, uvs[1][1][1]];
        assert_eq!(pixel_at(&sheet, beyond), red);
    }

    #[test]
    fn many_and_large_pictures_share_the_pixels() {
        let mut pictures = vec![Picture::filled(3000, 2000, [9, 8, 7, 255]); 6];
        pictures.extend((0..1000).map(|i| Picture::filled(1, 1, [(i % 256) as u8, (i / 256) as u8, 0, 255])));
        let of_triangle: Vec<usize> = (0..pictures.len()).collect();
        // The last texture is repeated very often.
        let mut uvs = vec![[[0.2, 0.2], [0.8, 0.2], [0.2, 0.8]]; pictures.len()];
        uvs[5] = [[0.0, 0.0], [1e6, 0.0], [0.0, 1e6]];
        let (sheet, is_coarse) = atlas(pictures, &of_triangle, &mut uvs);
        assert!(is_coarse && sheet.width.max(sheet.height) <= MOST_SIDE);
        let pixels = u64::from(sheet.width) * u64::from(sheet.height);
        assert!(pixels < 2 * MOST_PIXELS, "{}×{}", sheet.width, sheet.height);
        for (t, corners) in uvs.iter().enumerate() {
            let color =
                if t < 6 { [9, 8, 7, 255] } else { [((t - 6) % 256) as u8, ((t - 6) / 256) as u8, 0, 255] };
            assert_eq!(pixel_at(&sheet, middle(*corners)), color, "{t}");
        }
    }
}
