// Markers.

struct Marker {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
    @location(1) color: vec4f,
    @location(2) radius: f32,
}

// A disc that always faces the viewer, `radius` pixels.
@vertex
fn marker_vertex(
    @builtin(vertex_index) i: u32,
    @location(0) position: vec3f,
    @location(1) radius: f32,
    @location(2) color: vec4f,
) -> Marker {
    let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    var at = cell.view * vec4f(position, 1.0);
    var clip = cell.projection * at;
    // Half a disc towards the viewer, so that the surface below does not cut it.
    let lift = radius * clip.w / (cell.viewport.w * cell.projection[1][1]);
    let lifted = cell.projection * vec4f(at.xyz + vec3f(0.0, 0.0, 2.0 * lift), 1.0);
    clip.z = lifted.z / lifted.w * clip.w;
    let grown = radius + 1.0;
    clip = vec4f(clip.xy + corner * grown * 2.0 / cell.viewport.zw * clip.w, clip.zw);
    return Marker(clip, corner * grown, color, radius);
}

fn marker(in: Marker) -> vec4f {
    let r = length(in.at);
    let cover = 1.0 - smoothstep(in.radius - 0.7, in.radius + 0.7, r);
    let rim = smoothstep(in.radius * 0.68 - 0.6, in.radius * 0.68 + 0.6, r);
    var c = mix(in.color.rgb, vec3f(1.0), rim);
    if cell.output.x < 0.5 { c = to_linear(c); }
    return vec4f(c, 1.0) * cover * in.color.a;
}

@fragment
fn marker_fragment(in: Marker) -> @location(0) vec4f {
    return marker(in);
}

// A marker behind the surface shows through faintly.
@fragment
fn hidden_marker_fragment(in: Marker) -> @location(0) vec4f {
    return marker(in) * 0.22;
}
