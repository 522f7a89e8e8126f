//! AVX-512: a panel is two registers, twelve columns of sums are twenty-four.
#![allow(unsafe_code, reason = "vector instructions that the compiler does not find by itself")]

use std::arch::x86_64::*;

use super::{Lanes, Product, with_width};

pub(super) const WIDTHS: &[usize] = &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];

pub(super) fn product(product: &Product<'_>, out: &mut [Lanes]) {
    // SAFETY: `CpuPath::available` offers this path only where the processor has AVX-512F and BW.
    unsafe {
        with_width!(columns, product, out, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    }
}

#[target_feature(enable = "avx512f,avx512bw")]
fn columns<const W: usize>(product: &Product<'_>, out: &mut [Lanes]) {
    let (rows, _) = product.coefficients.as_chunks::<W>();
    let mut sums = [[_mm512_setzero_ps(); 2]; W];
    for (i, (row, &k)) in rows.iter().zip(product.active).enumerate() {
        if let Some(&next) = product.fetch.get(i) {
            let line = product.next_panel[next as usize].as_ptr();
            _mm_prefetch::<_MM_HINT_T1>(line.cast());
        }
        let line = product.panel[k as usize].as_ptr();
        // SAFETY: a line is 32 values of 16 bits: one register of 64 bytes.
        let line = unsafe { _mm512_loadu_si512(line.cast()) };
        let low = _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(_mm512_castsi512_si256(line)));
        let high = _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(_mm512_extracti64x4_epi64::<1>(line)));
        for c in 0..W {
            let weight = _mm512_set1_ps(row[c]);
            sums[c][0] = _mm512_fmadd_ps(low, weight, sums[c][0]);
            sums[c][1] = _mm512_fmadd_ps(high, weight, sums[c][1]);
        }
    }
    for (out, sums) in out.iter_mut().zip(&sums) {
        // SAFETY: `out` is 32 floats: two registers of 16.
        unsafe {
            _mm512_storeu_ps(out.as_mut_ptr(), sums[0]);
            _mm512_storeu_ps(out.as_mut_ptr().add(16), sums[1]);
        }
    }
}
