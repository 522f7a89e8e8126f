//! Area-weighted vertex normals: exact for rest shapes, gathered over rings for every frame.

use crate::SynthError;

/// What a vertex gets when its triangles have no area: a direction, so that every normal has
/// unit length.
const NO_AREA: [f32; 3] = [0.0, 0.0, 1.0];

/// The triangles around each vertex: for triangle (v, a, b), turned so that v comes first, the pair (a, b).
#[derive(Debug)]
pub(crate) struct Rings {
    /// N+1 offsets into `pairs`.
    pub offsets: Vec<u32>,
    pub pairs: Vec<[u32; 2]>,
}

impl Rings {
    /// Triangles with repeated corners have no area and are left out.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Result<Self, SynthError> {
        check_corners(vertices, triangles)?;
        if u32::try_from(3 * triangles.len()).is_err() {
            return Err(SynthError::TooLarge { items: 1, vertices });
        }
        let proper = || triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a);
        let mut offsets = vec![0_u32; vertices + 1];
        proper().flatten().for_each(|&v| offsets[v as usize + 1] += 1);
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut pairs = vec![[0; 2]; offsets[vertices] as usize];
        for &[a, b, c] in proper() {
            for (v, pair) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                pairs[next[v as usize] as usize] = pair;
                next[v as usize] += 1;
            }
        }
        Ok(Self { offsets, pairs })
    }

    /// Area-weighted normals of vertices `first .. first + out.len()` of one item, blended
    /// with the rest normals by `blending` in [0, 1].
    pub fn gather(
        &self,
        positions: &[[f32; 3]],
        rest_normals: &[[f32; 3]],
        blending: f32,
        first: usize,
        out: &mut [[f32; 3]],
    ) {
        let rest_normals = &rest_normals[first..];
        for (i, (out, &rest)) in out.iter_mut().zip(rest_normals).enumerate() {
            let v = first + i;
            let x = positions[v];
            let ring = &self.pairs[self.offsets[v] as usize..self.offsets[v + 1] as usize];
            let mut sum = [0.0_f32; 3];
            for &[a, b] in ring {
                let (pa, pb) = (positions[a as usize], positions[b as usize]);
                let u: [f32; 3] = std::array::from_fn(|c| pa[c] - x[c]);
                let w: [f32; 3] = std::array::from_fn(|c| pb[c] - x[c]);
                sum[0] += u[1] * w[2] - u[2] * w[1];
                sum[1] += u[2] * w[0] - u[0] * w[2];
                sum[2] += u[0] * w[1] - u[1] * w[0];
            }
            *out = blend(sum, rest, blending);
        }
    }
}

/// The mean of an exact normal (any length) and the rest normal, by weight; unit length.
#[inline(always)]
fn blend(sum: [f32; 3], rest: [f32; 3], blending: f32) -> [f32; 3] {
    let Some(exact) = unit(sum) else { return rest };
    if blending == 0.0 {
        return exact;
    }
    let mean = std::array::from_fn(|c| exact[c] + blending * (rest[c] - exact[c]));
    unit(mean).unwrap_or(exact)
}

/// The direction of `v`; `None` where it has none that f32 can tell.
#[inline(always)]
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    // Also refuses NaN. Below this, the square is subnormal and the direction is noise.
    (length > 1e-18).then(|| v.map(|c| c / length))
}

/// Area-weighted unit normals n(v) of N positions: the direction of Σ (a − v) × (b − v) over
/// the triangles (v, a, b) around v.
///
/// A vertex whose triangles have no area gets (0, 0, 1), so that every normal has unit
/// length. Fails if a triangle names a vertex that is not there.
pub fn area_weighted_normals(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> Result<Vec<[f64; 3]>, SynthError> {
    check_corners(positions.len(), triangles)?;
    let mut normals = vec![[0.0; 3]; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let u: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let w: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
        let cross = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        for &v in t {
            (0..3).for_each(|i| normals[v as usize][i] += cross[i]);
        }
    }
    for n in &mut normals {
        let length = n[0].hypot(n[1]).hypot(n[2]);
        *n = if length > 1e-150 { n.map(|c| c / length) } else { NO_AREA.map(f64::from) };
    }
    Ok(normals)
}

fn check_corners(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), SynthError> {
    for (triangle, t) in triangles.iter().enumerate() {
        if let Some(&vertex) = t.iter().find(|&&v| v as usize >= vertices) {
            return Err(SynthError::TriangleCorner { triangle, vertex, vertices });
        }
    }
    Ok(())
}
