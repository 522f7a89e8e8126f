// Data that vertex stages look up by index, in storage. textures.wgsl has the same names.

@group(3) @binding(0) var<storage, read> positions: array<f32>;
@group(3) @binding(1) var<storage, read> normals: array<f32>;
@group(3) @binding(2) var<storage, read> corners: array<u32>;
@group(3) @binding(3) var<storage, read> corner_uvs: array<vec2f>;
@group(3) @binding(4) var<storage, read> paints: array<u32>;

fn first_vertex() -> u32 {
    return (u32(figure.wire_width.y) << 16u) + u32(figure.wire_width.z);
}

fn position_of(vertex: u32) -> vec3f {
    let i = 3u * (vertex + first_vertex());
    return vec3f(positions[i], positions[i + 1u], positions[i + 2u]);
}

fn normal_of(vertex: u32) -> vec3f {
    let i = 3u * (vertex + first_vertex());
    return vec3f(normals[i], normals[i + 1u], normals[i + 2u]);
}

fn vertex_of(corner: u32) -> u32 {
    return corners[corner];
}

fn uv_of(corner: u32) -> vec2f {
    return corner_uvs[corner];
}

fn paint_at(i: u32) -> u32 {
    return paints[i];
}

// Whether a texel of the key light's map is lit, unfiltered.
fn texel_lit(at: vec3f, offset: vec2f) -> f32 {
    return select(0.0, 1.0, at.z <= textureLoad(shadows, vec2i(at.xy + offset), 0));
}
