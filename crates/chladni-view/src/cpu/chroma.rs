//! Pixels as films take them: brightness of each, and two differences of color of each square of four.

use super::curves::each;
use super::instructions::{Instructions, Kernel};

/// Y of each pixel, then U and V of each square of four pixels (ITU-R BT.709, 8 bits, 16 to 235 and 16 to 240). Sides
/// are even: an odd picture loses its last column or row. Alpha is left aside.
pub(crate) fn halved(rgba: &[u8], [width, height]: [usize; 2], out: &mut Vec<u8>) {
    let with = Instructions::fastest();
    let (columns, rows) = (width / 2, height / 2);
    out.resize(6 * columns * rows, 0);
    let (y, uv) = out.split_at_mut(4 * columns * rows);
    let (u, v) = uv.split_at_mut(columns * rows);
    let lines = rgba.chunks_exact((8 * width).max(1)).zip(y.chunks_exact_mut((4 * columns).max(1)));
    let chroma = u.chunks_exact_mut(columns.max(1)).zip(v.chunks_exact_mut(columns.max(1)));
    for ((lines, y), (u, v)) in lines.zip(chroma) {
        let (above, below) = lines.as_chunks::<4>().0.split_at(width);
        for (line, y) in [above, below].into_iter().zip(y.chunks_exact_mut(2 * columns)) {
            with.run(Luma { line, y });
        }
        with.run(Chroma { above, below, u, v });
    }
}

/// The share of 65,536 that red, green and blue have in 8 bits of Y, U and V.
const Y: [i32; 3] = [11_966, 40_254, 4_064];
const U: [i32; 3] = [-6_596, -22_188, 28_784];
const V: [i32; 3] = [28_784, -26_145, -2_639];

#[inline(always)]
fn channels(pixel: [u8; 4]) -> [i32; 3] {
    let word = u32::from_le_bytes(pixel);
    each([word, word >> 8, word >> 16], |byte| (byte & 255) as i32)
}

#[inline(always)]
fn sum([r, g, b]: [i32; 3], of: [i32; 3]) -> i32 {
    r * of[0] + g * of[1] + b * of[2]
}

struct Luma<'a> {
    line: &'a [[u8; 4]],
    y: &'a mut [u8],
}

impl Kernel for Luma<'_> {
    #[inline(always)]
    fn run(self) {
        for (pixel, y) in self.line.iter().zip(self.y) {
            *y = ((sum(channels(*pixel), Y) + (16 << 16) + (1 << 15)) >> 16) as u8;
        }
    }
}

struct Chroma<'a> {
    above: &'a [[u8; 4]],
    below: &'a [[u8; 4]],
    u: &'a mut [u8],
    v: &'a mut [u8],
}

impl Kernel for Chroma<'_> {
    #[inline(always)]
    fn run(self) {
        let squares = self.above.as_chunks::<2>().0.iter().zip(self.below.as_chunks::<2>().0);
        for (([a, b], [c, d]), (u, v)) in squares.zip(self.u.iter_mut().zip(self.v)) {
            let [a, b, c, d] = [*a, *b, *c, *d].map(channels);
            let four = [a[0] + b[0] + c[0] + d[0], a[1] + b[1] + c[1] + d[1], a[2] + b[2] + c[2] + d[2]];
            let byte = |of| ((sum(four, of) + (128 << 18) + (1 << 17)) >> 18) as u8;
            (*u, *v) = (byte(U), byte(V));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of the cube as the recommendation tabulates them, and pictures of odd sides.
    #[test]
    fn colors_are_those_of_bt_709() {
        let cube = [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
        ];
        for ([r, g, b], [y, u, v]) in cube {
            for [width, height] in [[2, 2], [4, 2], [5, 3], [35, 2]] {
                let mut out = vec![7; 3];
                halved(&[r, g, b, 255].repeat(width * height), [width, height], &mut out);
                let squares = width / 2 * (height / 2);
                let expected = [vec![y; 4 * squares], vec![u; squares], vec![v; squares]].concat();
                assert_eq!(out, expected, "{r} {g} {b}, {width}×{height}");
            }
        }
    }

    #[test]
    fn each_square_has_the_mean_of_its_four() {
        let mut out = Vec::new();
        let line = |shades: [u8; 4]| shades.map(|shade| [shade, shade, shade, 255]).concat();
        halved(&[line([0, 255, 255, 0]), line([255, 0, 0, 255])].concat(), [4, 2], &mut out);
        assert_eq!(out, [16, 235, 235, 16, 235, 16, 16, 235, 128, 128, 128, 128]);
        halved(&[], [0, 0], &mut out);
        assert!(out.is_empty());
    }
}
