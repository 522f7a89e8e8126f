//! The matrix product of one panel, for each instruction set.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;

use std::fmt;

use super::Lanes;
use crate::packed_basis::Line;

/// The instruction set that computes the product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CpuPath {
    /// x86-64 with AVX-512F and AVX-512BW.
    Avx512,
    /// x86-64 with AVX2 and FMA.
    Avx2,
    /// AArch64.
    Neon,
    /// Plain Rust; available on every processor.
    Portable,
}

impl CpuPath {
    /// The paths that this processor supports, fastest first; never empty.
    pub fn available() -> &'static [Self] {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 && is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512bw") {
                return &[Self::Avx512, Self::Avx2, Self::Portable];
            }
            if avx2 {
                return &[Self::Avx2, Self::Portable];
            }
        }
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            return &[Self::Neon, Self::Portable];
        }
        &[Self::Portable]
    }

    /// The numbers of columns that a kernel can sum at once, as far as registers suffice.
    pub(super) fn widths(self) -> &'static [usize] {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => avx512::WIDTHS,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::WIDTHS,
            #[cfg(target_arch = "aarch64")]
            Self::Neon => neon::WIDTHS,
            _ => portable::WIDTHS,
        }
    }

    /// Computes `product` into the columns of one block.
    ///
    /// The path must be available; `CpuSynthesizer` ensures this.
    pub(super) fn product(self, product: &Product<'_>, out: &mut [Lanes]) {
        debug_assert_eq!(product.coefficients.len(), product.active.len() * out.len());
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => avx512::product(product, out),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::product(product, out),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => neon::product(product, out),
            _ => portable::product(product, out),
        }
    }
}

/// Σ_k q_k(v) coefficients\[k\]\[c\] over the active harmonics of a panel, for the columns c
/// of one block.
pub(super) struct Product<'a> {
    /// The K lines of the panel.
    pub panel: &'a [Line],
    /// The harmonics that take part; each below K.
    pub active: &'a [u32],
    /// active × width.
    pub coefficients: &'a [f32],
    /// The panel that is computed next, and those of its harmonics that should be prefetched meanwhile.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "only AVX-512 fetches ahead"))]
    pub next_panel: &'a [Line],
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "only AVX-512 fetches ahead"))]
    pub fetch: &'a [u32],
}

impl fmt::Display for CpuPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Avx512 => "AVX-512",
            Self::Avx2 => "AVX2",
            Self::Neon => "NEON",
            Self::Portable => "portable",
        })
    }
}

/// Calls `$kernel::<W>` for the width that `$out` has at run time.
macro_rules! with_width {
    ($kernel:ident, $product:ident, $out:ident, [$($width:literal),*]) => {
        match $out.len() {
            $($width => $kernel::<$width>($product, $out),)*
            width => unreachable!("no kernel sums {width} columns"),
        }
    };
}
use with_width;
