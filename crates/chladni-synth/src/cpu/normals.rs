//! Exact normals of deformed positions, from the triangles around each vertex.
#![allow(unsafe_code, reason = "vector instructions that the compiler does not find by itself")]

use crate::normals::Rings;

/// The data from which the normals of every item are computed.
pub(super) struct Gather<'a> {
    pub rings: &'a Rings,
    pub rest_normals: &'a [[f32; 3]],
    /// The weight of the rest normal, in [0, 1].
    pub blending: f32,
    /// Uses four lanes at once if the processor has them.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "elsewhere the compiler finds them"))]
    pub simd: bool,
}

impl Gather<'_> {
    /// Computes the normals of vertices `first .. first + out.len()` of one item. `positions` holds the N
    /// positions of the item as 3N scalars, followed by at least one more scalar.
    pub fn run(&self, positions: &[f32], first: usize, out: &mut [[f32; 3]]) {
        #[cfg(target_arch = "x86_64")]
        if self.simd {
            // SAFETY: every x86-64 has SSE2.
            return self.run_with(|p, ring, v| unsafe { sse2::ring_sum(p, ring, v) }, positions, first, out);
        }
        self.run_with(ring_sum, positions, first, out);
    }

    #[inline(always)]
    fn run_with(
        &self,
        ring_sum: impl Fn(&[f32], &[[u32; 2]], usize) -> [f32; 3],
        positions: &[f32],
        first: usize,
        out: &mut [[f32; 3]],
    ) {
        for (i, (out, &rest)) in out.iter_mut().zip(&self.rest_normals[first..]).enumerate() {
            let sum = ring_sum(positions, self.rings.around(first + i), first + i);
            *out = blend(sum, rest, self.blending);
        }
    }
}

/// Σ (a − v) × (b − v) over the ring of v: twice the area vectors of its triangles.
#[inline(always)]
fn ring_sum(positions: &[f32], ring: &[[u32; 2]], v: usize) -> [f32; 3] {
    let at = |v: usize| [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
    let x = at(v);
    let mut sum = [0.0; 3];
    for &[a, b] in ring {
        let (pa, pb) = (at(a as usize), at(b as usize));
        // Written out: what an array makes of a closure may be a call in the middle of a kernel.
        let u = [pa[0] - x[0], pa[1] - x[1], pa[2] - x[2]];
        let w = [pb[0] - x[0], pb[1] - x[1], pb[2] - x[2]];
        sum[0] += u[1] * w[2] - u[2] * w[1];
        sum[1] += u[2] * w[0] - u[0] * w[2];
        sum[2] += u[0] * w[1] - u[1] * w[0];
    }
    sum
}

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use std::arch::x86_64::*;

    /// `ring_sum` in four lanes.
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn ring_sum(positions: &[f32], ring: &[[u32; 2]], v: usize) -> [f32; 3] {
        let at = |v: usize| {
            // The fourth lane belongs to the next vertex and is ignored.
            let lanes: &[f32] = &positions[3 * v..3 * v + 4];
            // SAFETY: four floats, as the slice before it has checked.
            unsafe { _mm_loadu_ps(lanes.as_ptr()) }
        };
        let x = at(v);
        let mut turned = _mm_setzero_ps();
        for &[a, b] in ring {
            let (u, w) = (_mm_sub_ps(at(a as usize), x), _mm_sub_ps(at(b as usize), x));
            // Lanes in the order y z x; the cross product results in the order z x y.
            let (u_yzx, w_yzx) =
                (_mm_shuffle_ps::<0b11_00_10_01>(u, u), _mm_shuffle_ps::<0b11_00_10_01>(w, w));
            let cross = _mm_sub_ps(_mm_mul_ps(u, w_yzx), _mm_mul_ps(u_yzx, w));
            turned = _mm_add_ps(turned, cross);
        }
        let mut lanes = [0.0_f32; 4];
        // SAFETY: `lanes` is four floats.
        unsafe { _mm_storeu_ps(lanes.as_mut_ptr(), turned) };
        let [z, x, y, _] = lanes;
        [x, y, z]
    }
}

/// The weighted mean of an exact normal (of any length) and the rest normal, normalized.
#[inline(always)]
fn blend(sum: [f32; 3], rest: [f32; 3], blending: f32) -> [f32; 3] {
    let Some(exact) = unit(sum) else { return rest };
    if blending == 0.0 {
        return exact;
    }
    let mut mean = exact;
    for c in 0..3 {
        mean[c] += blending * (rest[c] - exact[c]);
    }
    unit(mean).unwrap_or(exact)
}

/// The direction of `v`; `None` if `v` is too short for f32.
#[inline(always)]
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    // Also excludes NaN. Below this length the square is subnormal and the direction is noise.
    if length > 1e-18 { Some([v[0] / length, v[1] / length, v[2] / length]) } else { None }
}
