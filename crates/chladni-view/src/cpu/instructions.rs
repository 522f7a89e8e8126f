//! One body for every instruction set: compiled once for each, chosen at run time.
#![allow(unsafe_code, reason = "what the processor has is known at run time only")]

use std::fmt;
use std::sync::OnceLock;

/// The instructions that kernels are compiled for. All compute the same bits: nothing is fused and no
/// sum is reordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// The instructions that every processor of the architecture has.
    Baseline,
}

/// A loop to be compiled for every instruction set. `run` must be `#[inline(always)]`, and so must all
/// that its loop calls.
pub(super) trait Kernel {
    fn run(self);
}

impl Instructions {
    /// The instruction sets of this processor, fastest first.
    pub(crate) fn available() -> &'static [Self] {
        static AVAILABLE: OnceLock<Vec<Instructions>> = OnceLock::new();
        AVAILABLE.get_or_init(|| {
            let mut available = Vec::new();
            #[cfg(target_arch = "x86_64")]
            {
                let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
                let avx512 = is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl");
                available.extend((avx2 && avx512).then_some(Self::Avx512));
                available.extend(avx2.then_some(Self::Avx2));
            }
            available.push(Self::Baseline);
            available
        })
    }

    pub(crate) fn fastest() -> Self {
        Self::available()[0]
    }

    /// Runs `kernel` with these instructions.
    pub(super) fn run(self, kernel: impl Kernel) {
        match self {
            // SAFETY: `available` offers these only where the processor has them, and nothing else
            // makes them.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { avx512(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { avx2(kernel) },
            Self::Baseline => kernel.run(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,avx512f,avx512bw,avx512dq,avx512vl")]
fn avx512(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2(kernel: impl Kernel) {
    kernel.run();
}

impl fmt::Display for Instructions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "AVX2",
            Self::Baseline => "baseline",
        })
    }
}
