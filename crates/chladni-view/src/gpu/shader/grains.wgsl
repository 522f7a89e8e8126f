// Grains of sand on a figure: lit discs that face the viewer, as far along the surface's normal as their
// radius and what they fly.

struct GrainDisc {
    @builtin(position) clip: vec4f,
    // Pixels from the middle, y up.
    @location(0) from_middle: vec2f,
    // Radius in pixels, how opaque, and how bright of its own.
    @location(1) @interpolate(flat) disc: vec3f,
    @location(2) @interpolate(flat) normal: vec3f,
    @location(3) @interpolate(flat) map_at: vec3f,
    @location(4) @interpolate(flat) map_step: vec3f,
}

// No disc is smaller; a smaller grain is fainter instead.
const LEAST_GRAIN_PX: f32 = 0.7;

fn mixed_corners(trio: vec3u, weights: vec3f) -> array<vec3f, 2> {
    var position = vec3f(0.0);
    var normal = vec3f(0.0);
    for (var c = 0; c < 3; c++) {
        position += weights[c] * position_of(trio[c]);
        normal += weights[c] * normal_of(trio[c]);
    }
    return array<vec3f, 2>(position, normal / max(length(normal), 1e-12));
}

@vertex
fn grain_vertex(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) index: u32,
    @location(0) trio: vec3u,
    @location(1) weights: vec3f,
    @location(2) lift: f32,
) -> GrainDisc {
    let place = mixed_corners(trio, weights);
    let radius = figure.grain.w;
    let s = surface(place[0] + (radius + lift) * place[1], place[1]);
    let similarity = length(figure.model[0].xyz);
    let scale = select(-s.at.z, 1.0, cell.output.z > 0.5);
    let radius_px = 0.5 * cell.viewport.w * cell.projection[1][1] * radius * similarity / max(scale, 1e-6);
    let drawn = max(radius_px, LEAST_GRAIN_PX);
    let share = radius_px / drawn;
    let corner = vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    let from_middle = corner * (drawn + 1.0);
    var clip = vec4f(s.clip.xy + from_middle * 2.0 / cell.viewport.zw * s.clip.w, s.clip.zw);
    // Grains on a side that faces away are not drawn: a sheet may be thinner than a grain.
    if dot(s.normal, towards_viewer(s.at)) <= 0.0 || s.clip.w <= 0.0 { clip = vec4f(0.0, 0.0, 2.0, 1.0); }
    let bits = ((index ^ (index >> 7u)) * 2654435761u) >> 16u;
    let own = 0.8 + 0.4 * f32(bits) / 65535.0;
    return GrainDisc(clip, from_middle, vec3f(drawn, share * share, own), s.normal, s.map_at, s.map_step);
}

// Light on grains at `x` of the picture on a surface of normal `n`, which are rough and scatter it.
fn grain_light(n: vec3f, key: f32, x: f32) -> vec3f {
    var c = mix(cell.ground.rgb, cell.sky.rgb, 0.5 + 0.5 * n.y);
    for (var i = 0; i < 3; i++) {
        let facing = clamp(0.35 + 0.65 * dot(n, cell.lights[i].direction.xyz), 0.0, 1.0);
        c += cell.lights[i].color.rgb * select(1.0, key, i == 0) * facing;
    }
    return c * wing(cell.wings.xy, x);
}

@fragment
fn grain_fragment(in: GrainDisc) -> @location(0) vec4f {
    let r = length(in.from_middle);
    let cover = 1.0 - smoothstep(in.disc.x - 0.7, in.disc.x + 0.7, r);
    let key = lit_by_key(in.map_at, in.map_step, in.clip.xy);
    let x = 2.0 * (in.clip.x - cell.viewport.x) / cell.viewport.z - 1.0;
    let lit = encoded(toned(figure.grain.rgb * in.disc.z * grain_light(in.normal, key, x)));
    // Each is round: brighter toward the key light.
    let across = in.from_middle / (in.disc.x + 0.7);
    var round = 0.86 + 0.30 * dot(across, cell.lights[0].direction.xy);
    if cell.output.x < 0.5 { round = pow(max(round, 0.0), 2.2); }
    return vec4f(lit * round, 1.0) * cover * in.disc.y;
}
