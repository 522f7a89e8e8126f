// Positions from columns: x + Σ_terms χ (column + r g) [· n].

struct Shape {
    // N, and N padded to whole panels.
    vertices: u32,
    padded_vertices: u32,
}

struct Item {
    first_term: u32,
    terms: u32,
}

struct Term {
    first_column: u32,
    // 3 in vector form, 1 in normal form.
    channels: u32,
    residual_gain: f32,
    // First scalar of the residual (vertex after vertex) and of the mask in `signals`; NONE if there is none.
    residual: u32,
    mask: u32,
}

const NONE = 0xffffffffu;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> rest_positions: array<f32>;
@group(0) @binding(2) var<storage, read> rest_normals: array<f32>;
@group(1) @binding(0) var<storage, read> items: array<Item>;
@group(1) @binding(1) var<storage, read> terms: array<Term>;
@group(1) @binding(2) var<storage, read> signals: array<f32>;
@group(1) @binding(3) var<storage, read> columns: array<f32>;
@group(1) @binding(4) var<storage, read_write> positions: array<f32>;

@compute @workgroup_size(64)
fn place(@builtin(global_invocation_id) id: vec3<u32>) {
    let v = id.x;
    if (v >= shape.vertices) {
        return;
    }
    let n = vec3<f32>(rest_normals[3u * v], rest_normals[3u * v + 1u], rest_normals[3u * v + 2u]);
    var x = vec3<f32>(rest_positions[3u * v], rest_positions[3u * v + 1u], rest_positions[3u * v + 2u]);
    let item = items[id.y];
    for (var t = item.first_term; t < item.first_term + item.terms; t++) {
        let term = terms[t];
        let column = term.first_column * shape.padded_vertices + v;
        var mask = 1.0;
        if (term.mask != NONE) {
            mask = signals[term.mask + v];
        }
        if (term.channels == 3u) {
            var sum = vec3<f32>(
                columns[column],
                columns[column + shape.padded_vertices],
                columns[column + 2u * shape.padded_vertices],
            );
            if (term.residual != NONE) {
                let r = term.residual + 3u * v;
                sum += term.residual_gain * vec3<f32>(signals[r], signals[r + 1u], signals[r + 2u]);
            }
            x += mask * sum;
        } else {
            var sum = columns[column];
            if (term.residual != NONE) {
                sum += term.residual_gain * signals[term.residual + v];
            }
            x += mask * sum * n;
        }
    }
    let out = 3u * (id.y * shape.vertices + v);
    positions[out] = x.x;
    positions[out + 1u] = x.y;
    positions[out + 2u] = x.z;
}
