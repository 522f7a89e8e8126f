// Columns = H × coefficients, for the vertices of one chunk of the basis.
//
// Each thread sums WIDTH columns of VERTICES neighboring vertices. What stands in braces is written out by
// product.rs for each WIDTH: the sums are variables sum0, sum1, … and the harmonics of a batch follow each other.

struct Chunk {
    // The first panel of the chunk and their number.
    first_panel: u32,
    panels: u32,
}

struct Frame {
    // K.
    harmonics: u32,
    // Harmonics with weight, padded to whole batches.
    active_harmonics: u32,
    // Vertices padded to whole panels.
    padded_vertices: u32,
}

@group(0) @binding(0) var<storage, read> basis: array<Words>;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> active_harmonics: array<vec4<u32>>;
@group(1) @binding(2) var<storage, read> coefficients: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> columns: array<Values>;

@compute @workgroup_size(64)
fn product(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = workgroup.x;
    let thread = workgroup.y * 64u + local;
    let panel = thread / THREADS_PER_PANEL;
    if (panel >= chunk.panels) {
        return;
    }
    let line = panel * frame.harmonics * THREADS_PER_PANEL + thread % THREADS_PER_PANEL;
    var row = block * frame.active_harmonics * (WIDTH / 4u);
    {sums = 0}
    for (var i = 0u; i < frame.active_harmonics / 4u; i += BATCH / 4u) {
        {load the batch}
        {add the batch}
        row += BATCH * WIDTH / 4u;
    }
    let stride = frame.padded_vertices / VERTICES;
    let first = block * WIDTH * stride + chunk.first_panel * THREADS_PER_PANEL + thread;
    {store the sums}
}
