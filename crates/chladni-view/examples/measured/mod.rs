//! The shapes of the measuring examples, and the cost of drawing them.

/// A closed sphere with waves, of about `vertices` vertices, wound outwards.
pub fn bumpy(vertices: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    use std::f32::consts::{PI, TAU};
    let rows = ((vertices / 2) as f32).sqrt() as u32;
    let columns = 2 * rows;
    let at_angles = |polar: f32, around: f32| {
        let r = 0.4 * (1.0 + 0.15 * (5.0 * polar).sin() * (4.0 * around).cos());
        [r * polar.sin() * around.sin(), r * polar.cos(), r * polar.sin() * around.cos()]
    };
    // One vertex for each pole, at the end.
    let rings = rows - 1;
    let angles = (0..rings).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let mut positions: Vec<[f32; 3]> = angles
        .map(|(i, j)| at_angles(PI * (i + 1) as f32 / rows as f32, TAU * j as f32 / columns as f32))
        .collect();
    positions.extend([at_angles(0.0, 0.0), at_angles(PI, 0.0)]);
    let at = |i: u32, j: u32| match i {
        0 => rings * columns,
        i if i == rows => rings * columns + 1,
        i => (i - 1) * columns + j % columns,
    };
    let triangles = (0..rows)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]]
        })
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    (positions, triangles)
}

/// User and system time of this process, milliseconds; 0 where /proc does not say.
pub fn cpu_ms() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    // Fields 14 and 15 of the line, in hundredths of a second.
    let ticks = |i: usize| fields.get(i).and_then(|field| field.parse::<f64>().ok()).unwrap_or(0.0);
    10.0 * (ticks(11) + ticks(12))
}
