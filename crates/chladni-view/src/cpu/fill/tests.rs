use super::*;

const SIZE: i32 = 40;

/// How often each sample is covered by triangles of these corners, in sub-pixels.
fn covered(triangles: &[[[i32; 2]; 3]]) -> Vec<u32> {
    let stride = SIZE as usize + MARGIN;
    let mut counts = vec![0; 4 * stride * SIZE as usize];
    for t in triangles {
        let (mut depth, mut seen) = (vec![1.0; counts.len()], vec![NONE; counts.len()]);
        let mut target = Target {
            depth: &mut depth,
            seen: &mut seen,
            stride,
            origin: [0; 2],
            low: [0; 2],
            high: [SIZE - 1; 2],
        };
        let corners = t.map(|[x, y]| Corner { x, y, z: 0.5 });
        FillOne { target: &mut target, corners, id: 7, bias: Bias::default() }.run();
        for (count, seen) in counts.iter_mut().zip(&seen) {
            *count += u32::from(*seen == 7);
        }
    }
    counts.chunks(4 * stride).flat_map(|row| row[..4 * SIZE as usize].to_vec()).collect()
}

/// A fan around a point, its rim far outside: every sample of the square once.
#[test]
fn a_fan_covers_every_sample_once() {
    // In the middle of a sample, on a corner, beside everything; near and far rims.
    for middle in [[96 + 20 * 256, 32 + 20 * 256], [5120, 5120], [4711, 3333]] {
        for reach in [1 << 14, 1 << 22] {
            let rim: Vec<[i32; 2]> = (0..11)
                .map(|i| (f64::from(i) * std::f64::consts::TAU / 11.0).sin_cos())
                .map(|(s, c)| [(c * f64::from(reach)) as i32 + 5000, (s * f64::from(reach)) as i32 + 5000])
                .collect();
            let fan: Vec<_> = (0..11).map(|i| [middle, rim[i], rim[(i + 1) % 11]]).collect();
            assert!(covered(&fan).iter().all(|count| *count == 1), "{middle:?} {reach}");
        }
    }
}

/// Small cells of a jittered grid, whose corners lie on samples, too.
#[test]
fn a_fine_mesh_has_neither_gaps_nor_overlaps() {
    let mut state = 12345_u32;
    let mut chance = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as i32
    };
    let side = 24;
    let points: Vec<[i32; 2]> = (0..side * side)
        .map(|i| [(i % side) * 512 - 512 + chance() / 32 * 32, (i / side) * 512 - 512 + chance() / 32 * 32])
        .collect();
    let at = |x: i32, y: i32| points[(y * side + x) as usize];
    let mesh: Vec<_> = (0..side - 1)
        .flat_map(|y| (0..side - 1).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            let quad = [at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)];
            // Both windings.
            [[quad[0], quad[1], quad[2]], [quad[3], quad[2], quad[1]]]
        })
        .collect();
    assert!(covered(&mesh).iter().all(|count| *count == 1));
}

#[test]
fn what_has_no_area_is_not_seen_and_nearer_goes_before() {
    assert!(covered(&[[[0, 0], [9000, 9000], [4500, 4500]], [[7, 7]; 3]]).iter().all(|c| *c == 0));
    let (mut depth, mut seen) = (vec![1.0_f32; 4 * 17 * 4], vec![NONE; 4 * 17 * 4]);
    let mut target =
        Target { depth: &mut depth, seen: &mut seen, stride: 17, origin: [0; 2], low: [0; 2], high: [0, 3] };
    let corners = |z| [[-9000, -9000], [9000, -9000], [0, 9000]].map(|[x, y]| Corner { x, y, z });
    for (id, z) in [(1, 0.5), (2, 0.25), (3, 0.75), (4, f32::NAN), (5, 1.0)] {
        FillOne { target: &mut target, corners: corners(z), id, bias: Bias::default() }.run();
    }
    assert_eq!((seen[0], depth[0]), (2, 0.25));
}
