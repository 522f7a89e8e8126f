//! NEON: half a panel is four registers, six columns of sums are twenty-four.
#![allow(unsafe_code, reason = "vector instructions that the compiler does not find by itself")]

use std::arch::aarch64::*;

use super::{Lanes, Product, with_width};

pub(super) const WIDTHS: &[usize] = &[1, 2, 3, 4, 5, 6];

pub(super) fn product(product: &Product<'_>, out: &mut [Lanes]) {
    // SAFETY: `CpuPath::available` offers this path only where the processor has NEON.
    unsafe {
        with_width!(columns, product, out, [1, 2, 3, 4, 5, 6]);
    }
}

#[target_feature(enable = "neon")]
fn columns<const W: usize>(product: &Product<'_>, out: &mut [Lanes]) {
    let (rows, _) = product.coefficients.as_chunks::<W>();
    for half in 0..2 {
        let mut sums = [[vdupq_n_f32(0.0); 4]; W];
        for (row, &k) in rows.iter().zip(product.active) {
            let line: &[i16; 16] = &product.panel[k as usize].as_chunks().0[half];
            // SAFETY: half a line is 16 values of 16 bits: two registers of 16 bytes.
            let (low, high) = unsafe { (vld1q_s16(line.as_ptr()), vld1q_s16(line.as_ptr().add(8))) };
            let h = [
                vcvtq_f32_s32(vmovl_s16(vget_low_s16(low))),
                vcvtq_f32_s32(vmovl_high_s16(low)),
                vcvtq_f32_s32(vmovl_s16(vget_low_s16(high))),
                vcvtq_f32_s32(vmovl_high_s16(high)),
            ];
            for c in 0..W {
                for part in 0..4 {
                    sums[c][part] = vfmaq_n_f32(sums[c][part], h[part], row[c]);
                }
            }
        }
        for (out, sums) in out.iter_mut().zip(&sums) {
            let out: &mut [[f32; 4]; 4] = &mut out.as_chunks_mut::<4>().0.as_chunks_mut().0[half];
            for (out, &sum) in out.iter_mut().zip(sums) {
                // SAFETY: `out` is 4 floats: one register.
                unsafe { vst1q_f32(out.as_mut_ptr(), sum) };
            }
        }
    }
}
