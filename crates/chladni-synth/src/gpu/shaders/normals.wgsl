// Area-weighted normals: for each vertex v, the sum of (a − v) × (b − v) over its ring.

struct Shape {
    vertices: u32,
    padded_vertices: u32,
}

struct Blending {
    // The weight of the rest normal, in [0, 1].
    weight: f32,
}

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> rest_normals: array<f32>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(1) @binding(0) var<uniform> blending: Blending;
@group(1) @binding(1) var<storage, read> positions: array<f32>;
@group(1) @binding(2) var<storage, read_write> normals: array<f32>;

fn position(first: u32, v: u32) -> vec3<f32> {
    let i = first + 3u * v;
    return vec3<f32>(positions[i], positions[i + 1u], positions[i + 2u]);
}

// Below this the square is subnormal and the direction is noise.
const SHORTEST = 1e-18;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3<u32>) {
    let v = id.x;
    if (v >= shape.vertices) {
        return;
    }
    let first = 3u * id.y * shape.vertices;
    let x = position(first, v);
    var sum = vec3<f32>();
    for (var i = offsets[v]; i < offsets[v + 1u]; i++) {
        let pair = pairs[i];
        sum += cross(position(first, pair.x) - x, position(first, pair.y) - x);
    }
    let rest = vec3<f32>(rest_normals[3u * v], rest_normals[3u * v + 1u], rest_normals[3u * v + 2u]);
    var normal = rest;
    let len = length(sum);
    if (len > SHORTEST) {
        let exact = sum / len;
        let mean = mix(exact, rest, blending.weight);
        let mean_len = length(mean);
        normal = select(exact, mean / mean_len, blending.weight != 0.0 && mean_len > SHORTEST);
    }
    let out = first + 3u * v;
    normals[out] = normal.x;
    normals[out + 1u] = normal.y;
    normals[out + 2u] = normal.z;
}
