//! Arithmetic on eight numbers at a time, compiled for the widest vectors that the processor has.
//!
//! With the compiler's own vectorizer, the same loops over `[f64; 8]` ran between 3 and 10 times slower
//! than with these few intrinsics (measured on the triangular solves).

#![allow(
    unsafe_code,
    reason = "vector intrinsics, and calling code compiled for them after testing for them"
)]

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Proves that the processor has some vector instructions, and computes with them.
pub(crate) trait Lanes: Copy {
    /// Eight f64.
    type V: Copy;
    fn splat(self, x: f64) -> Self::V;
    fn load(self, x: &[f64; 8]) -> Self::V;
    fn store(self, v: Self::V, x: &mut [f64; 8]);
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// a · b + c, with a single rounding.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a · b, with a single rounding.
    fn mul_sub_from(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;

    /// Prefetches data that will be read soon into the first-level cache.
    #[inline(always)]
    fn prefetch(self, _x: &[f64; 8]) {}

    /// Transposes the 8×8 matrix of these rows.
    #[inline(always)]
    fn transpose(self, rows: [Self::V; 8]) -> [Self::V; 8] {
        let mut m = [[0.0; 8]; 8];
        for (row, m) in rows.into_iter().zip(&mut m) {
            self.store(row, m);
        }
        let mut columns = rows;
        for (i, column) in columns.iter_mut().enumerate() {
            let mut of = [0.0; 8];
            for j in 0..8 {
                of[j] = m[j][i];
            }
            *column = self.load(&of);
        }
        columns
    }
}

/// Work that is compiled for each kind of [`Lanes`]. Functions that its inner loops call must be
/// `#[inline(always)]`, otherwise they are not compiled for that kind.
pub(crate) trait Kernel {
    /// The result of the work.
    type Output;
    /// Does the work.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Runs `kernel` with the widest vectors that the processor has: AVX-512, AVX2, or the baseline of the
/// target (which is slow on x86 without FMA).
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx512() {
            // SAFETY: every feature that `avx512` is compiled for was detected.
            return unsafe { avx512(kernel) };
        }
        if has_avx2() {
            // SAFETY: every feature that `avx2` is compiled for was detected.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run(Portable)
}

/// Whether this processor has what [`avx2`] is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

/// Whether this processor has what [`avx512`] is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f") && has_avx2()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

/// Kinds of processors, by what kernels are compiled for.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) enum Processor {
    Any,
    Avx2,
    Avx512,
}

/// Runs a kernel for one kind of processor, if this one is of that kind, too.
#[cfg(test)]
pub(crate) fn run_for<K: Kernel>(processor: Processor, kernel: K) -> Option<K::Output> {
    match processor {
        Processor::Any => Some(kernel.run(Portable)),
        #[cfg(target_arch = "x86_64")]
        Processor::Avx2 if has_avx2() => {
            // SAFETY: every feature that `avx2` is compiled for was detected.
            Some(unsafe { avx2(kernel) })
        }
        #[cfg(target_arch = "x86_64")]
        Processor::Avx512 if has_avx512() => {
            // SAFETY: every feature that `avx512` is compiled for was detected.
            Some(unsafe { avx512(kernel) })
        }
        Processor::Avx2 | Processor::Avx512 => None,
    }
}

/// The result of `work`, which must be the same to the last bit for every kind of processor that this one is: all lanes
/// add in one order and round a multiply-add once.
#[cfg(test)]
pub(crate) fn alike<T: PartialEq>(mut work: impl FnMut(Processor) -> Option<T>) -> T {
    let portable = work(Processor::Any).expect("every processor runs it");
    for processor in [Processor::Avx2, Processor::Avx512] {
        if let Some(result) = work(processor) {
            assert!(result == portable, "{processor:?} gives other bits");
        }
    }
    portable
}

/// a b + c. It has a single rounding, except on targets where that would be a function call per number
/// (WebAssembly).
#[inline(always)]
fn mul_add(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_family = "wasm") { a * b + c } else { a.mul_add(b, c) }
}

/// Eight numbers. An array's own `from_fn` may be compiled to a call, without the instructions of the kernel around it.
#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> [f64; 8] {
    let mut all = [0.0; 8];
    for (i, x) in all.iter_mut().enumerate() {
        *x = of(i);
    }
    all
}

#[derive(Clone, Copy)]
struct Portable;

impl Lanes for Portable {
    type V = [f64; 8];
    #[inline(always)]
    fn splat(self, x: f64) -> [f64; 8] {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, x: &[f64; 8]) -> [f64; 8] {
        *x
    }
    #[inline(always)]
    fn store(self, v: [f64; 8], x: &mut [f64; 8]) {
        *x = v;
    }
    #[inline(always)]
    fn add(self, a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        each(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        each(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        each(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn mul_add(self, a: [f64; 8], b: [f64; 8], c: [f64; 8]) -> [f64; 8] {
        each(|i| mul_add(a[i], b[i], c[i]))
    }
    #[inline(always)]
    fn mul_sub_from(self, a: [f64; 8], b: [f64; 8], c: [f64; 8]) -> [f64; 8] {
        each(|i| mul_add(-a[i], b[i], c[i]))
    }
}

/// Created only by [`dispatch`], after AVX-512F was detected.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Avx512(());

// SAFETY of every block below: an `Avx512` exists only where AVX-512F was detected, and loads
// and stores go through references to eight f64.
#[cfg(target_arch = "x86_64")]
impl Lanes for Avx512 {
    type V = __m512d;
    #[inline(always)]
    fn prefetch(self, x: &[f64; 8]) {
        // SAFETY: a hint about an address that may be read.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(x.as_ptr().cast()) }
    }
    #[inline(always)]
    fn splat(self, x: f64) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_set1_pd(x) }
    }
    #[inline(always)]
    fn load(self, x: &[f64; 8]) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_loadu_pd(x.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, v: __m512d, x: &mut [f64; 8]) {
        // SAFETY: see above.
        unsafe { _mm512_storeu_pd(x.as_mut_ptr(), v) }
    }
    #[inline(always)]
    fn add(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_add_pd(a, b) }
    }
    #[inline(always)]
    fn sub(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_sub_pd(a, b) }
    }
    #[inline(always)]
    fn mul(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_mul_pd(a, b) }
    }
    #[inline(always)]
    fn mul_add(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_fmadd_pd(a, b, c) }
    }
    #[inline(always)]
    fn mul_sub_from(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_fnmadd_pd(a, b, c) }
    }
    #[inline(always)]
    fn transpose(self, r: [__m512d; 8]) -> [__m512d; 8] {
        // SAFETY: see above.
        unsafe {
            let mut pair = r;
            for i in 0..4 {
                pair[2 * i] = _mm512_unpacklo_pd(r[2 * i], r[2 * i + 1]);
                pair[2 * i + 1] = _mm512_unpackhi_pd(r[2 * i], r[2 * i + 1]);
            }
            // Lane pairs of 128 bits: rows (0,1), (2,3), (4,5), (6,7) of even and odd columns.
            let mut out = [_mm512_setzero_pd(); 8];
            for odd in 0..2 {
                let (p, q, s, t) = (pair[odd], pair[2 + odd], pair[4 + odd], pair[6 + odd]);
                let pq_low = _mm512_shuffle_f64x2::<0x88>(p, q);
                let pq_high = _mm512_shuffle_f64x2::<0xdd>(p, q);
                let st_low = _mm512_shuffle_f64x2::<0x88>(s, t);
                let st_high = _mm512_shuffle_f64x2::<0xdd>(s, t);
                out[odd] = _mm512_shuffle_f64x2::<0x88>(pq_low, st_low);
                out[4 + odd] = _mm512_shuffle_f64x2::<0xdd>(pq_low, st_low);
                out[2 + odd] = _mm512_shuffle_f64x2::<0x88>(pq_high, st_high);
                out[6 + odd] = _mm512_shuffle_f64x2::<0xdd>(pq_high, st_high);
            }
            out
        }
    }
}

/// Created only by [`dispatch`], after AVX2 and FMA were detected.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Avx2(());

// SAFETY of every block below: an `Avx2` exists only where AVX2 and FMA were detected, and
// loads and stores go through references to eight f64.
#[cfg(target_arch = "x86_64")]
impl Lanes for Avx2 {
    type V = [__m256d; 2];
    #[inline(always)]
    fn prefetch(self, x: &[f64; 8]) {
        // SAFETY: a hint about an address that may be read.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(x.as_ptr().cast()) }
    }
    #[inline(always)]
    fn splat(self, x: f64) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_set1_pd(x); 2] }
    }
    #[inline(always)]
    fn load(self, x: &[f64; 8]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_loadu_pd(x.as_ptr()), _mm256_loadu_pd(x[4..].as_ptr())] }
    }
    #[inline(always)]
    fn store(self, v: [__m256d; 2], x: &mut [f64; 8]) {
        // SAFETY: see above.
        unsafe {
            _mm256_storeu_pd(x.as_mut_ptr(), v[0]);
            _mm256_storeu_pd(x[4..].as_mut_ptr(), v[1]);
        }
    }
    #[inline(always)]
    fn add(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_add_pd(a[0], b[0]), _mm256_add_pd(a[1], b[1])] }
    }
    #[inline(always)]
    fn sub(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_sub_pd(a[0], b[0]), _mm256_sub_pd(a[1], b[1])] }
    }
    #[inline(always)]
    fn mul(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1])] }
    }
    #[inline(always)]
    fn mul_add(self, a: [__m256d; 2], b: [__m256d; 2], c: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_fmadd_pd(a[0], b[0], c[0]), _mm256_fmadd_pd(a[1], b[1], c[1])] }
    }
    #[inline(always)]
    fn mul_sub_from(self, a: [__m256d; 2], b: [__m256d; 2], c: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_fnmadd_pd(a[0], b[0], c[0]), _mm256_fnmadd_pd(a[1], b[1], c[1])] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Transpose([[f64; 8]; 8]);

    impl Kernel for Transpose {
        type Output = [[f64; 8]; 8];
        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let rows = lanes.transpose(std::array::from_fn(|i| lanes.load(&self.0[i])));
            let mut out = [[0.0; 8]; 8];
            for (row, out) in rows.into_iter().zip(&mut out) {
                lanes.store(row, out);
            }
            out
        }
    }

    #[test]
    fn a_transpose_is_one_on_every_kind_of_processor() {
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| (8 * i + j) as f64));
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| (8 * j + i) as f64));
        assert_eq!(alike(|processor| run_for(processor, Transpose(matrix))), transposed);
    }
}
