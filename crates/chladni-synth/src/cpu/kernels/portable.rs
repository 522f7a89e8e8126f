//! Plain Rust, which the compiler translates to the vector instructions of the baseline target.

use super::{Lanes, Product, with_width};

pub(super) const WIDTHS: &[usize] = &[1, 2, 3, 4];

/// The number of lanes whose sums fit, together with the harmonic, into the 16 registers of SSE2.
const LANES: usize = 8;

pub(super) fn product(product: &Product<'_>, out: &mut [Lanes]) {
    with_width!(columns, product, out, [1, 2, 3, 4]);
}

fn columns<const W: usize>(product: &Product<'_>, out: &mut [Lanes]) {
    let (rows, _) = product.coefficients.as_chunks::<W>();
    for part in 0..size_of::<Lanes>() / size_of::<[f32; LANES]>() {
        let mut sums = [[0.0_f32; LANES]; W];
        for (row, &k) in rows.iter().zip(product.active) {
            let line = &product.panel[k as usize].as_chunks::<LANES>().0[part];
            let h = line.map(f32::from);
            for c in 0..W {
                for lane in 0..LANES {
                    sums[c][lane] += h[lane] * row[c];
                }
            }
        }
        for (out, sums) in out.iter_mut().zip(&sums) {
            out.as_chunks_mut::<LANES>().0[part] = *sums;
        }
    }
}
