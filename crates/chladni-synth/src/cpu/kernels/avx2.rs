//! AVX2 and FMA: half a panel is two registers, six columns of sums are twelve.
#![allow(unsafe_code, reason = "vector instructions that the compiler does not find by itself")]

use std::arch::x86_64::*;

use super::{Lanes, Product, with_width};

pub(super) const WIDTHS: &[usize] = &[1, 2, 3, 4, 5, 6];

pub(super) fn product(product: &Product<'_>, out: &mut [Lanes]) {
    // SAFETY: `CpuPath::available` offers this path only where the processor has AVX2 and FMA.
    unsafe {
        with_width!(columns, product, out, [1, 2, 3, 4, 5, 6]);
    }
}

#[target_feature(enable = "avx2,fma")]
fn columns<const W: usize>(product: &Product<'_>, out: &mut [Lanes]) {
    let (rows, _) = product.coefficients.as_chunks::<W>();
    for half in 0..2 {
        let mut sums = [[_mm256_setzero_ps(); 2]; W];
        for (row, &k) in rows.iter().zip(product.active) {
            let line: &[i16; 16] = &product.panel[k as usize].as_chunks().0[half];
            // SAFETY: half a line is 16 values of 16 bits: two registers of 16 bytes.
            let (low, high) = unsafe {
                (_mm_loadu_si128(line.as_ptr().cast()), _mm_loadu_si128(line.as_ptr().add(8).cast()))
            };
            let low = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(low));
            let high = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(high));
            for c in 0..W {
                let weight = _mm256_set1_ps(row[c]);
                sums[c][0] = _mm256_fmadd_ps(low, weight, sums[c][0]);
                sums[c][1] = _mm256_fmadd_ps(high, weight, sums[c][1]);
            }
        }
        for (out, sums) in out.iter_mut().zip(&sums) {
            let out: &mut [f32; 16] = &mut out.as_chunks_mut().0[half];
            // SAFETY: half of `out` is 16 floats: two registers of 8.
            unsafe {
                _mm256_storeu_ps(out.as_mut_ptr(), sums[0]);
                _mm256_storeu_ps(out.as_mut_ptr().add(8), sums[1]);
            }
        }
    }
}
