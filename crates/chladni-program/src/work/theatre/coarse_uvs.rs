//! Texture coordinates for fewer triangles.

/// Two neighbors lie on one piece of the image unless they are this many times as far apart there as the surface around
/// them is stretched.
const LEAP: f32 = 3.0;

/// Coordinates for the corners of `coarse` triangles, three each, over the vertices of `triangles`, whose corners have `uvs`.
///
/// A vertex at a seam of the image has several: those are taken with which the triangle is smallest there. Where even so it
/// reaches across a seam, it has the color of one point, as it would show all that lies between.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn coarse_uvs(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    uvs: &[[f32; 2]],
    coarse: &[[u32; 3]],
) -> Vec<[f32; 2]> {
    let places = places(positions.len(), triangles, uvs);
    let stretch = stretch(positions, triangles, uvs);
    let of_triangle = |corners: &[u32; 3]| {
        let corners = corners.map(|v| v as usize);
        let [a, b, c] = corners.map(|v| &places[v][..]);
        let all = a.iter().flat_map(|a| b.iter().flat_map(move |b| c.iter().map(move |c| [*a, *b, *c])));
        let size = |uvs: &[[f32; 2]; 3]| (0..3).map(|i| distance(&uvs[i], &uvs[(i + 1) % 3])).sum::<f32>();
        let Some(best) = all.min_by(|a, b| size(a).total_cmp(&size(b))) else { return [[0.0; 2]; 3] };
        let leaps = (0..3).any(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            let usual = stretch[from].max(stretch[to]) * distance(&positions[from], &positions[to]);
            distance(&best[i], &best[(i + 1) % 3]) > LEAP * usual
        });
        if leaps { [best[0]; 3] } else { best }
    };
    coarse.iter().flat_map(of_triangle).collect()
}

/// The coordinates that each vertex has.
fn places(vertices: usize, triangles: &[[u32; 3]], uvs: &[[f32; 2]]) -> Vec<Vec<[f32; 2]>> {
    let mut places = vec![Vec::new(); vertices];
    for (v, uv) in triangles.iter().flatten().zip(uvs) {
        let known = &mut places[*v as usize];
        if !known.contains(uv) {
            known.push(*uv);
        }
    }
    places
}

/// How much longer an edge at each vertex is in the image than on the surface, at most.
fn stretch(positions: &[[f32; 3]], triangles: &[[u32; 3]], uvs: &[[f32; 2]]) -> Vec<f32> {
    let mut stretch = vec![0.0_f32; positions.len()];
    for (corners, uvs) in triangles.iter().zip(uvs.as_chunks::<3>().0) {
        for i in 0..3 {
            let j = (i + 1) % 3;
            let [from, to] = [corners[i], corners[j]].map(|v| v as usize);
            let long = distance(&positions[from], &positions[to]).max(f32::MIN_POSITIVE);
            let ratio = distance(&uvs[i], &uvs[j]) / long;
            (stretch[from], stretch[to]) = (stretch[from].max(ratio), stretch[to].max(ratio));
        }
    }
    stretch
}

fn distance<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use chladni_mesh::surface::details;

    use super::*;

    /// Positions, triangles, and coordinates of their corners.
    type Unrolled = (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<[f32; 2]>);

    /// A tube of `around` by `along` squares, unrolled onto an image: its seam has two places in it.
    fn tube(around: u32, along: u32) -> Unrolled {
        let place = |i: u32| f64::from(i) / f64::from(around);
        let positions = (0..=along).flat_map(|j| {
            (0..around).map(move |i| {
                let (sin, cos) = (std::f64::consts::TAU * place(i)).sin_cos();
                [cos as f32, 6.0 * j as f32 / along as f32, sin as f32]
            })
        });
        let (mut triangles, mut uvs) = (Vec::new(), Vec::new());
        for (i, j) in (0..along).flat_map(|j| (0..around).map(move |i| (i, j))) {
            let at = |i: u32, j: u32| j * around + i % around;
            let uv = |i: u32, j: u32| [place(i) as f32, j as f32 / along as f32];
            for corners in [[(i, j), (i, j + 1), (i + 1, j)], [(i + 1, j), (i, j + 1), (i + 1, j + 1)]] {
                triangles.push(corners.map(|(i, j)| at(i, j)));
                uvs.extend(corners.map(|(i, j)| uv(i, j)));
            }
        }
        (positions.collect(), triangles, uvs)
    }

    #[test]
    fn fewer_triangles_show_the_image_where_all_of_them_do() {
        let (positions, triangles, uvs) = tube(48, 96);
        assert_eq!(coarse_uvs(&positions, &triangles, &uvs, &triangles), uvs);
        let fewer = details(&positions, &triangles, &[700]).remove(0).triangles;
        let (mut flat, coarse) = (0, coarse_uvs(&positions, &triangles, &uvs, &fewer));
        for (corners, uvs) in fewer.iter().zip(coarse.as_chunks::<3>().0) {
            flat += usize::from(uvs[0] == uvs[1] && uvs[1] == uvs[2]);
            for (v, uv) in corners.iter().zip(uvs) {
                // No place of the image is far from where its vertex is on the tube.
                let p = positions[*v as usize];
                let turn = (p[2].atan2(p[0]) / std::f32::consts::TAU - uv[0]).rem_euclid(1.0);
                assert!(turn.min(1.0 - turn) < 0.2 && (uv[1] - p[1] / 6.0).abs() < 0.1, "{p:?} shows {uv:?}");
            }
            let wide = uvs.iter().map(|uv| uv[0]).fold(0.0, f32::max)
                - uvs.iter().map(|uv| uv[0]).fold(1.0, f32::min);
            assert!(wide < 0.5, "the whole image between two neighbors: {uvs:?}");
        }
        // Those at the seam.
        assert!(flat > 0 && 8 * flat < fewer.len(), "{flat} of {}", fewer.len());
    }
}
