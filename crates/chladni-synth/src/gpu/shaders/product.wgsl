// Columns = H × coefficients, for the vertices of one chunk of the basis.
//
// Each thread sums WIDTH columns of four vertices; the workgroups of all blocks of columns of
// the same vertices follow each other, so that the basis comes from memory once.
// `WIDTH` is prepended when the module is made.

const PANEL = 32u;
// Four values of 16 bits per thread.
const THREADS_PER_LINE = 8u;

struct Chunk {
    // The first panel of the chunk and their number.
    first_panel: u32,
    panels: u32,
}

struct Frame {
    // K.
    harmonics: u32,
    // Harmonics with weight, and the runs they form.
    active_harmonics: u32,
    runs: u32,
    // Vertices padded to whole panels.
    padded_vertices: u32,
}

// Harmonics with weight that follow each other.
struct Run {
    first: u32,
    end: u32,
}

@group(0) @binding(0) var<storage, read> basis: array<vec2<i32>>;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> runs: array<Run>;
@group(1) @binding(2) var<storage, read> coefficients: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> columns: array<vec4<f32>>;

@compute @workgroup_size(64)
fn product(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = workgroup.x;
    let thread = workgroup.y * 64u + local;
    let panel = thread / THREADS_PER_LINE;
    if (panel >= chunk.panels) {
        return;
    }
    let line = panel * frame.harmonics * THREADS_PER_LINE + thread % THREADS_PER_LINE;
    var row = block * frame.active_harmonics * (WIDTH / 4u);
    var sums: array<vec4<f32>, WIDTH>;
    for (var r = 0u; r < frame.runs; r++) {
        let run = runs[r];
        for (var k = run.first; k < run.end; k++) {
            let words = basis[line + k * THREADS_PER_LINE];
            // 65536 q: the coefficients have the reciprocal in them.
            let low = words << vec2<u32>(16u);
            let high = words & vec2<i32>(-65536);
            let h = vec4<f32>(vec4<i32>(low.x, high.x, low.y, high.y));
            for (var c = 0u; c < WIDTH / 4u; c++) {
                let weights = coefficients[row + c];
                sums[4u * c] += h * weights.x;
                sums[4u * c + 1u] += h * weights.y;
                sums[4u * c + 2u] += h * weights.z;
                sums[4u * c + 3u] += h * weights.w;
            }
            row += WIDTH / 4u;
        }
    }
    let first = chunk.first_panel * THREADS_PER_LINE + thread;
    for (var c = 0u; c < WIDTH; c++) {
        columns[(block * WIDTH + c) * (frame.padded_vertices / 4u) + first] = sums[c];
    }
}
