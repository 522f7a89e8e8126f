// What lies behind all shapes.

struct Screen { @builtin(position) clip: vec4f, @location(0) at: vec2f }

// One triangle that covers the viewport.
@vertex
fn screen_vertex(@builtin(vertex_index) i: u32) -> Screen {
    let corner = vec2f(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0;
    return Screen(vec4f(corner, 0.0, 1.0), corner);
}

// The floor over a background of color `behind`: light around the shape, its shadow, and a rim that fades.
fn floored(behind: vec3f, at: vec2f) -> vec3f {
    let ray = vec3f(at.x / cell.projection[0][0], at.y / cell.projection[1][1], -1.0);
    let down = -dot(cell.floor_plane.xyz, ray);
    let way = cell.floor_plane.w / max(down, 1e-6);
    let p = ray * way;
    let x = dot(cell.floor_axes[0].xyz, p) + cell.floor_axes[0].w;
    let z = dot(cell.floor_axes[1].xyz, p) + cell.floor_axes[1].w;
    let away = min(x * x + z * z, 1e6);
    let shadow = 1.0 / (1.0 + 4.0 * away * away);
    let lit = cell.floor.rgb * (1.0 - cell.floor.w * shadow);
    let there = select(0.0, 1.0 / (1.0 + 0.06 * away), down > 1e-6);
    return mix(behind, lit, there);
}

// A picture that fills the viewport.
@fragment
fn pictured_fragment(in: Screen) -> @location(0) vec4f {
    let ratio = cell.viewport.z / (cell.viewport.w * cell.output.y);
    let scale = 0.5 * vec2f(min(ratio, 1.0), -min(1.0 / ratio, 1.0));
    var c = textureSample(skin, map_sampler, 0.5 + scale * in.at).rgb;
    if cell.output.x > 0.5 { c = to_srgb(c); }
    return vec4f(c, 1.0) * cell.background_center.w;
}

@fragment
fn backdrop_fragment(in: Screen) -> @location(0) vec4f {
    let r = length(in.at + vec2f(0.0, -0.1));
    let gradient = cell.background_corner.w;
    var away = select(smoothstep(0.1, 1.5, r), smoothstep(0.0, 1.1, r), gradient > 1.5);
    away = select(away, 0.5 + 0.5 * in.at.y, abs(gradient - 1.0) < 0.5);
    away = 1.0 - (1.0 - away) * wing(cell.wings.zw, in.at.x);
    var c = mix(cell.background_center.rgb, cell.background_corner.rgb, away);
    c = floored(c, in.at);
    // An ordered dither hides the steps of eight bits, and unlike noise it compresses well.
    let p = vec2u(in.clip.xy) & vec2u(1u);
    c += (f32(2u * (p.x ^ p.y) + p.y) - 1.5) / (4.0 * 255.0);
    if cell.output.x < 0.5 { c = to_linear(max(c, vec3f(0.0))); }
    return vec4f(c, 1.0) * cell.background_center.w;
}
