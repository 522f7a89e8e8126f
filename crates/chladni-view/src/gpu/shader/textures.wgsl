// Data that vertex stages look up by index, in textures, for devices without storage. They hold one item, so its
// first vertex is their first. ROW is the width of all of them.

@group(3) @binding(0) var positions: texture_2d<f32>;
@group(3) @binding(1) var normals: texture_2d<f32>;
@group(3) @binding(2) var corners: texture_2d<u32>;
@group(3) @binding(3) var corner_uvs: texture_2d<f32>;
@group(3) @binding(4) var paints: texture_2d<u32>;

fn texel(i: u32) -> vec2u {
    return vec2u(i % ROW, i / ROW);
}

fn position_of(vertex: u32) -> vec3f {
    let i = 3u * vertex;
    let x = textureLoad(positions, texel(i), 0).r;
    let y = textureLoad(positions, texel(i + 1u), 0).r;
    return vec3f(x, y, textureLoad(positions, texel(i + 2u), 0).r);
}

fn normal_of(vertex: u32) -> vec3f {
    let i = 3u * vertex;
    let x = textureLoad(normals, texel(i), 0).r;
    let y = textureLoad(normals, texel(i + 1u), 0).r;
    return vec3f(x, y, textureLoad(normals, texel(i + 2u), 0).r);
}

fn vertex_of(corner: u32) -> u32 {
    return textureLoad(corners, texel(corner), 0).r;
}

fn uv_of(corner: u32) -> vec2f {
    return textureLoad(corner_uvs, texel(corner), 0).rg;
}

fn paint_at(i: u32) -> u32 {
    return textureLoad(paints, texel(i), 0).r;
}

// GL compares the depths of a texture or loads them, not both.
fn texel_lit(at: vec3f, offset: vec2f) -> f32 {
    return lit_at(at, offset / DISC);
}
