// Drawing of shapes, backgrounds and markers. Lighting happens in the viewer's axes, in linear
// light; colours leave premultiplied by their opacity.

struct Light { direction: vec4f, color: vec4f }

struct Cell {
    view: mat4x4f,
    projection: mat4x4f,
    lights: array<Light, 3>,
    // w: brightness of the upright softboxes.
    sky: vec4f,
    // w: how bright a panorama is.
    ground: vec4f,
    // Colours as sRGB numbers; w of the first: opacity; of the second: 1 where they run
    // upright, 2 for a halo.
    background_center: vec4f,
    background_corner: vec4f,
    // x, y, width, height in pixels.
    viewport: vec4f,
    // x: 1 where the target wants sRGB-encoded numbers; y: width over height of a picture behind, 0 for none; z: 1 in orthographic views; w: 1 for the curve
    // of film.
    output: vec4f,
    // From the scene to the key light's clip space.
    shadow: mat4x4f,
    // Strength, texels of a side of the map, size of a texel in the scene, -.
    shadow_map: vec4f,
    // The map's first texel among those of all maps, and the size of a texel in texture coordinates.
    shadow_place: vec4f,
    // Linear light of the bright line around.
    horizon: vec4f,
    // sRGB of the floor; w: how dark its shadow is.
    floor: vec4f,
    // The floor in the viewer's axes: normal and height of the eye; no normal where there is no floor.
    floor_plane: vec4f,
    // Along the floor from the shadow's middle, 1 at its edge.
    floor_axes: array<vec4f, 2>,
    // Exposure in the picture's left and right; strength of the background's middle in the left and right.
    wings: vec4f,
}

struct Figure {
    model: mat4x4f,
    // Linear light; w: opacity.
    color: vec4f,
    // Tint of back faces; w: paint (0 material, 1 values, 2 colours, 3 texture, 4 answer).
    back: vec4f,
    // Roughness, metal, softness, iridescence.
    material: vec4f,
    // Low, 1 / (high − low), row of the map, gloss of painted surfaces.
    scale: vec4f,
    // sRGB, opacity in w.
    wire: vec4f,
    // Width of the wire in pixels; first vertex; ambient share; -.
    wire_width: vec4f,
    // sRGB of a brush's ring; w: its radius.
    brush: vec4f,
    // Linear light at grazing angles.
    edge: vec4f,
    // Of a palette: offset, along the shape, by a unit outward, by a unit in any direction.
    answer: vec4f,
    // Own light, more of it by a unit of length; saturation; 1 for palettes that are a circle.
    glow: vec4f,
    // Of a palette: by a unit of lag; light of its own by a unit of lag; turns in one vibration; by the bend.
    figured: vec4f,
    // sRGB of nodal lines, opacity in w.
    lines: vec4f,
    // Half their width as a share of the picture's height, and how far the surface may go.
    line: vec4f,
    // Linear light of its grains; w: their radius.
    grain: vec4f,
}

// What a pipeline can do without is left out when it is compiled: a software device computes both
// sides of every branch.
override SHADOWS = true;
// Whether shadows are filtered between the texels of their map: without, a pixel must be no smaller.
override FILTERED = true;
// Whether a panorama shines in the place of sky, ground and softboxes.
override AROUND = false;
// Half the width, of 2, in which the picture's left passes into its right.
const WING = 0.3;

@group(0) @binding(0) var<uniform> cell: Cell;
@group(1) @binding(0) var<uniform> figure: Figure;
@group(2) @binding(0) var maps: texture_2d<f32>;
@group(2) @binding(1) var map_sampler: sampler;
@group(2) @binding(2) var skin: texture_2d<f32>;
@group(2) @binding(3) var skin_sampler: sampler;
@group(2) @binding(4) var shadows: texture_depth_2d;
@group(2) @binding(5) var shadow_sampler: sampler_comparison;
@group(2) @binding(6) var around: texture_2d<f32>;
@group(2) @binding(7) var around_sampler: sampler;
@group(3) @binding(0) var<storage, read> positions: array<f32>;
@group(3) @binding(1) var<storage, read> normals: array<f32>;
@group(3) @binding(2) var<storage, read> corners: array<u32>;
@group(3) @binding(3) var<storage, read> corner_uvs: array<vec2f>;
@group(3) @binding(4) var<storage, read> paints: array<u32>;

// Position and normal in the viewer's axes; all that bare surfaces hand on. Where it lies in the key
// light's map, in texels and depth, and how far from there is a step off its front.
struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

struct ValuedSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
}

struct ColoredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// Answers: place of the palette, and own light.
struct AnsweredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) answer: vec2f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// The same, and the ways outward from the rest and from where it was lately.
struct FiguredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) answer: vec4f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// Corners carry whatever their paint needs: a value in x, a colour, a (u, v) or an answer.
struct CornerSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) paint: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
    @location(5) barycentric: vec3f,
}

fn surface(position: vec3f, normal: vec3f) -> Surface {
    let scene = figure.model * vec4f(position, 1.0);
    let at = cell.view * scene;
    // The model matrix is a similarity: normals turn with it.
    let scene_normal = figure.model * vec4f(normal, 0.0);
    let turned = (cell.view * scene_normal).xyz;
    var s = Surface(cell.projection * at, at.xyz, turned, vec3f(0.0), vec3f(0.0));
    if SHADOWS {
        let texels = vec3f(vec2f(0.5, -0.5) * cell.shadow_map.y, 1.0);
        let first = cell.shadow_place.xy;
        let map = (cell.shadow * scene).xyz * texels + vec3f(first + 0.5 * cell.shadow_map.y, 0.0);
        // A disc around it stays in the map; what the camera cannot reach is beyond its edge.
        let inside = clamp(map.xy, first + 6.0, first + cell.shadow_map.y - 6.0);
        s.map_at = vec3f(inside, map.z);
        // More where the light grazes the surface.
        let length_of_normal = max(length(turned), 1e-12);
        let grazing = 1.0 - abs(dot(turned, cell.lights[0].direction.xyz)) / length_of_normal;
        let step = cell.shadow_map.z * (1.0 + 3.0 * grazing) / length_of_normal;
        s.map_step = (cell.shadow * scene_normal).xyz * texels * step;
    }
    return s;
}

@vertex
fn plain_vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Surface {
    return surface(position, normal);
}

@vertex
fn value_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
) -> ValuedSurface {
    let s = surface(position, normal);
    return ValuedSurface(s.clip, s.at, s.normal, value);
}

@vertex
fn color_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
) -> ColoredSurface {
    let s = surface(position, normal);
    return ColoredSurface(s.clip, s.at, s.normal, color.rgb, s.map_at, s.map_step);
}

// What a palette makes of a vertex that has left its rest.
fn answered(position: vec3f, normal: vec3f, rest: vec4f, bend: f32) -> vec2f {
    let d = position - rest.xyz;
    let way = length(d);
    let outward = dot(d, normal) / max(length(normal), 1e-12);
    let by = figure.answer;
    let place = by.x + by.y * rest.w + by.z * outward + by.w * way + figure.figured.w * bend;
    return vec2f(place, figure.glow.y * way);
}

@vertex
fn answer_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec4f,
    @location(3) bend: f32,
) -> AnsweredSurface {
    let s = surface(position, normal);
    let answer = answered(position, normal, rest, bend);
    return AnsweredSurface(s.clip, s.at, s.normal, answer, s.map_at, s.map_step);
}

@vertex
fn figured_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec4f,
    @location(3) bend: f32,
    @location(4) lagging: vec3f,
) -> FiguredSurface {
    let s = surface(position, normal);
    let lag = lagging - rest.xyz;
    let off = normal / max(length(normal), 1e-12);
    let by_speed = figure.figured.xy * length(lag);
    let answer = answered(position, normal, rest, bend) + by_speed;
    let outward = vec2f(dot(position - rest.xyz, off), dot(lag, off));
    return FiguredSurface(s.clip, s.at, s.normal, vec4f(answer, outward), s.map_at, s.map_step);
}

// What the key light sees.
@vertex
fn shadow_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return cell.shadow * figure.model * vec4f(position, 1.0);
}

// One vertex per corner, for what lives on corners: UVs with seams, and wires.
@vertex
fn corner_vertex(@builtin(vertex_index) corner: u32) -> CornerSurface {
    let v = corners[corner];
    let i = 3u * (v + u32(figure.wire_width.y));
    let position = vec3f(positions[i], positions[i + 1u], positions[i + 2u]);
    let normal = vec3f(normals[i], normals[i + 1u], normals[i + 2u]);
    let s = surface(position, normal);
    let kind = u32(figure.back.w);
    var paint = vec3f(0.0);
    if kind == 1u { paint.x = bitcast<f32>(paints[v]); }
    if kind == 2u { paint = unpack4x8unorm(paints[v]).rgb; }
    // Images begin at the top, v at the bottom.
    if kind == 3u { paint = vec3f(corner_uvs[corner].x, 1.0 - corner_uvs[corner].y, 0.0); }
    if kind == 4u {
        let r = vec4u(paints[5u * v], paints[5u * v + 1u], paints[5u * v + 2u], paints[5u * v + 3u]);
        let bend = bitcast<f32>(paints[5u * v + 4u]);
        paint = vec3f(answered(position, normal, bitcast<vec4f>(r), bend), 0.0);
    }
    let which = corner % 3u;
    let barycentric = vec3f(f32(which == 0u), f32(which == 1u), f32(which == 2u));
    return CornerSurface(s.clip, s.at, s.normal, paint, s.map_at, s.map_step, barycentric);
}

fn to_linear(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn to_srgb(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3f(0.0031308));
}

// The target's numbers of a linear-light colour.
fn encoded(c: vec3f) -> vec3f {
    let bounded = clamp(c, vec3f(0.0), vec3f(1.0));
    if cell.output.x > 0.5 { return to_srgb(bounded); }
    return bounded;
}

// Khronos PBR Neutral tone mapper (2024): colours below the shoulder stay true.
fn toned(linear: vec3f) -> vec3f {
    let start = 0.76;
    let low = min(linear.r, min(linear.g, linear.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    var c = linear - offset;
    let peak = max(c.r, max(c.g, c.b));
    if peak < start { return c; }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    c = c * (new_peak / peak);
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(c, vec3f(new_peak), g);
}

// As film: Narkowicz' fit of the ACES curve (2015), after a little of each channel went to the others, so that
// bright colours turn to white.
fn filmed(linear: vec3f) -> vec3f {
    let grey = dot(linear, vec3f(0.2126, 0.7152, 0.0722));
    let x = mix(linear, vec3f(grey), 0.06) * 0.6;
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

fn curved(linear: vec3f) -> vec3f {
    return select(toned(linear), filmed(linear), cell.output.w > 0.5);
}

// What `sides` makes at `x`, -1 at the left edge of the picture and 1 at the right.
fn wing(sides: vec2f, x: f32) -> f32 {
    return mix(sides.x, sides.y, smoothstep(-WING, WING, x));
}

// Where in the picture, from -1 to 1, something lies whose viewer is towards `v`.
fn across(v: vec3f) -> f32 {
    return -cell.projection[0][0] * v.x / max(v.z, 1e-3);
}

// What the studio looks like along `d`: a floor, a ceiling, a horizon, two upright softboxes and one per light.
fn studio(d: vec3f, roughness: f32) -> vec3f {
    let blur = mix(0.18, 0.9, roughness);
    var c = mix(cell.ground.rgb, cell.sky.rgb * 1.25, smoothstep(-blur, blur, d.y));
    c += cell.horizon.rgb * exp(-mix(90.0, 5.0, roughness) * d.y * d.y);
    let strip = (abs(d.x) - 0.68) / mix(0.1, 0.5, roughness);
    let high = 1.0 - smoothstep(0.7 - blur, 0.7 + blur, abs(d.y));
    c += cell.sky.w * exp(-strip * strip) * high * mix(1.6, 0.5, roughness);
    let tight = mix(26.0, 2.5, roughness);
    for (var i = 0; i < 3; i++) {
        let near = exp(tight * (dot(d, cell.lights[i].direction.xyz) - 1.0));
        c += cell.lights[i].color.rgb * near * mix(1.3, 0.45, roughness);
    }
    return c;
}

// Light of a panorama towards `d`, at one of its levels, or between two.
fn panorama(d: vec3f, level: f32) -> vec3f {
    let rows = f32(textureDimensions(around).y) / exp2(floor(level));
    let down = acos(clamp(d.y, -1.0, 1.0)) / 3.1415927;
    let uv = vec2f(0.5 + atan2(d.x, -d.z) / 6.2831853, clamp(down, 0.5 / rows, 1.0 - 0.5 / rows));
    let c = textureSampleLevel(around, around_sampler, uv, level).rgb;
    return c / max(1.0 - c, vec3f(1e-3)) * cell.ground.w;
}

// What comes from all around to a surface, and what it mirrors.
fn ambient(n: vec3f) -> vec3f {
    if AROUND { return panorama(n, 4.0); }
    return mix(cell.ground.rgb, cell.sky.rgb, 0.5 + 0.5 * n.y);
}

fn mirrored(d: vec3f, roughness: f32) -> vec3f {
    if AROUND { return panorama(d, 3.0 * clamp(roughness, 0.0, 1.0)); }
    return studio(d, roughness);
}

// Share of the key light that reaches a place in its map.
fn lit_by_key(map_at: vec3f, map_step: vec3f, pixel: vec2f) -> f32 {
    if !SHADOWS { return 1.0; }
    return mix(1.0, lit_disc(map_at + map_step, pixel), cell.shadow_map.x);
}

// Share of a disc around `at`, in texels, that the key light reaches. The disc is Vogel's spiral,
// written out, as devices are slow at looking up constants.
fn lit_disc(at: vec3f, pixel: vec2f) -> f32 {
    if FILTERED {
        return (
            lit_at(at, vec2f(0.1768, 0.0000))
            + lit_at(at, vec2f(-0.2258, 0.2068))
            + lit_at(at, vec2f(0.0346, -0.3938))
            + lit_at(at, vec2f(0.2846, 0.3712))
            + lit_at(at, vec2f(-0.5222, -0.0924))
            + lit_at(at, vec2f(0.4947, -0.3147))
            + lit_at(at, vec2f(-0.1655, 0.6155))
            + lit_at(at, vec2f(-0.3156, -0.6076))
            + lit_at(at, vec2f(0.6846, 0.2500))
            + lit_at(at, vec2f(-0.7123, 0.2940))
            + lit_at(at, vec2f(0.3434, -0.7337))
            + lit_at(at, vec2f(0.2537, 0.8089))
            + lit_at(at, vec2f(-0.7647, -0.4432))
            + lit_at(at, vec2f(0.8971, -0.1972))
            + lit_at(at, vec2f(-0.5475, 0.7788))
            + lit_at(at, vec2f(-0.1265, -0.9761))
        ) / 16.0;
    }
    // A quarter of the disc for each of four pixels side by side: a fine pattern where light fades.
    let p = vec2u(pixel) & vec2u(1u);
    let turn = 1.5707963 * (0.25 * f32(2u * (p.x ^ p.y) + p.y));
    let arm = vec2f(cos(turn), sin(turn)) * (1.4 + 0.8 * f32(p.x));
    let across = vec2f(-arm.y, arm.x);
    return 0.25 * (unfiltered(at, arm) + unfiltered(at, -arm) + unfiltered(at, across) + unfiltered(at, -across));
}

fn lit_at(at: vec3f, offset: vec2f) -> f32 {
    let tap = (at.xy + 3.6 * offset) * cell.shadow_place.zw;
    return textureSampleCompareLevel(shadows, shadow_sampler, tap, at.z);
}

fn unfiltered(at: vec3f, offset: vec2f) -> f32 {
    return select(0.0, 1.0, at.z <= textureLoad(shadows, vec2i(at.xy + offset), 0));
}

fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    return x2 * x2 * x;
}

fn shaded(base: vec3f, n: vec3f, v: vec3f, key: f32, glow: f32) -> vec3f {
    let roughness = figure.material.x;
    let metal = figure.material.y;
    let softness = figure.material.z;
    let nv = clamp(dot(n, v), 0.0, 1.0);
    var tint = base;
    if figure.material.w > 0.0 {
        // Thin-film hues by the angle of view (a cosine palette, not a simulation).
        let phase = vec3f(0.0, 0.33, 0.67) + 1.15 * nv + 0.25 * n.y;
        let film = 0.5 + 0.5 * cos(6.2832 * phase);
        tint = mix(base, base * (0.62 + 0.62 * film), figure.material.w * (1.0 - 0.55 * nv));
    }
    let f0 = mix(vec3f(0.04), tint, metal);
    let a = min(roughness * roughness + 0.05, 1.0);
    var diffuse = ambient(n);
    var gloss = vec3f(0.0);
    for (var i = 0; i < 3; i++) {
        let l = cell.lights[i].direction.xyz;
        let light = cell.lights[i].color.rgb * select(1.0, key, i == 0);
        let wrap = 0.45 * softness;
        let nl = dot(n, l);
        let lit = max((nl + wrap) / (1.0 + wrap), 0.0);
        diffuse += light * lit * mix(1.0, lit, wrap);
        // Cook–Torrance with GGX and Kelemen's visibility.
        let h = normalize(l + v);
        let nh = max(dot(n, h), 0.0);
        let vh = max(dot(v, h), 1e-3);
        let d = nh * nh * (a * a - 1.0) + 1.0;
        let fresnel = f0 + (1.0 - f0) * fifth(1.0 - vh);
        gloss += light * fresnel * max(nl, 0.0) * (a * a / (d * d)) * 0.25 / (vh * vh);
    }
    // Karis, "Physically Based Shading on Mobile" (2014): the environment's share.
    let r = roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let k = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    let share = f0 * (-1.04 * k + r.z) + (1.04 * k + r.w);
    let mirror = mirrored(reflect(-v, n), roughness) * share;
    let grazing = 1.0 - nv;
    let own = tint * glow + figure.edge.rgb * (grazing * grazing * grazing);
    return (tint * (1.0 - metal) * diffuse + gloss + mirror + own) * wing(cell.wings.xy, across(v));
}

// Painted values must stay readable against their legend: light only darkens, and gently.
fn painted(color: vec3f, n: vec3f, v: vec3f) -> vec3f {
    var light = 0.62 + 0.16 * n.y;
    light += 0.42 * max(dot(n, cell.lights[0].direction.xyz), 0.0);
    light += 0.16 * max(dot(n, cell.lights[1].direction.xyz), 0.0);
    return color * min(light, 1.08) * mix(0.8, 1.0, smoothstep(0.0, 0.5, dot(n, v)));
}

// The normal that faces the side seen.
fn facing(normal: vec3f, v: vec3f, front: bool) -> vec3f {
    let length_of_normal = length(normal);
    let n = select(v, normal / length_of_normal, length_of_normal > 0.0);
    return select(-n, n, front);
}

fn towards_viewer(at: vec3f) -> vec3f {
    return select(normalize(-at), vec3f(0.0, 0.0, 1.0), cell.output.z > 0.5);
}

// A surface of its own colour under the lamps, as the target's numbers.
fn modelled(color: vec3f, at: vec3f, normal: vec3f, front: bool, key: f32, glow: f32) -> vec3f {
    let v = towards_viewer(at);
    let n = facing(normal, v, front);
    let base = select(color * figure.back.rgb, color, front);
    return encoded(curved(shaded(base, n, v, key, glow)));
}

// A heat map.
fn mapped(color: vec3f, at: vec3f, normal: vec3f, front: bool) -> vec3f {
    let v = towards_viewer(at);
    let base = select(color * figure.back.rgb, color, front);
    return encoded(painted(base, facing(normal, v, front), v));
}

fn map_color(value: f32) -> vec3f {
    return row_color(clamp((value - figure.scale.x) * figure.scale.y, 0.0, 1.0));
}

// Of palettes: around, or there and back.
fn palette_color(at: f32) -> vec3f {
    let around = at - floor(at);
    let back = 1.0 - abs(at - 2.0 * floor(0.5 * at) - 1.0);
    let c = row_color(select(back, around, figure.glow.w > 0.5));
    let grey = dot(c, vec3f(0.2126, 0.7152, 0.0722));
    return max(mix(vec3f(grey), c, figure.glow.z), vec3f(0.0));
}

fn row_color(t: f32) -> vec3f {
    let row = (figure.scale.z + 0.5) / f32(textureDimensions(maps).y);
    return textureSampleLevel(maps, map_sampler, vec2f((t * 255.0 + 0.5) / 256.0, row), 0.0).rgb;
}

// The part of a surface under a brush, with the distance from the brush's centre along it.
struct Brushed {
    @builtin(position) clip: vec4f,
    @location(0) reach: f32,
}

@vertex
fn brush_vertex(@location(0) position: vec3f, @location(1) reach: f32) -> Brushed {
    return Brushed(cell.projection * (cell.view * (figure.model * vec4f(position, 1.0))), reach);
}

// The brush's ring and a breath of its colour inside.
@fragment
fn brush_fragment(in: Brushed) -> @location(0) vec4f {
    let step = fwidth(in.reach);
    let ring = 1.0 - smoothstep(0.7, 1.7, abs(in.reach - figure.brush.w) / max(step, 1e-9));
    let inside = select(0.0, 0.13, in.reach < figure.brush.w);
    var c = figure.brush.rgb;
    if cell.output.x < 0.5 { c = to_linear(c); }
    return vec4f(c, 1.0) * max(ring, inside);
}

@fragment
fn plain_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let c = modelled(figure.color.rgb, in.at, in.normal, front, key, figure.glow.x);
    return vec4f(c, 1.0) * figure.color.a;
}

@fragment
fn value_fragment(in: ValuedSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let c = mapped(map_color(in.value), in.at, in.normal, front);
    return vec4f(c, 1.0) * figure.color.a;
}

@fragment
fn color_fragment(in: ColoredSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let c = modelled(in.color, in.at, in.normal, front, key, figure.glow.x);
    return vec4f(c, 1.0) * figure.color.a;
}

@fragment
fn answer_fragment(in: AnsweredSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let c = modelled(palette_color(in.answer.x), in.at, in.normal, front, key, figure.glow.x + in.answer.y);
    return vec4f(c, 1.0) * figure.color.a;
}

// What is smaller than this share of the farthest way has less and less of a phase.
const PHASED = 0.04;
// A way that changes by less than these shares of the farthest from pixel to pixel has no nodal lines, or faint ones.
const STILL = 2e-5;
const STIRRED = 1e-4;

// The angle of (x, y) in turns, by the way along a square; 0 at the middle of it.
fn turns_of(x: f32, y: f32) -> f32 {
    let size = abs(x) + abs(y);
    let p = y / max(size, 1e-12);
    return 0.25 * select(2.0 - p, p, x >= 0.0) * min(size / (PHASED * figure.line.y), 1.0);
}

@fragment
fn figured_fragment(in: FiguredSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    // Derivatives first, while all neighbours run.
    let slope = fwidth(in.answer.z);
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let place = in.answer.x + figure.figured.z * turns_of(in.answer.z, in.answer.w);
    var c = modelled(palette_color(place), in.at, in.normal, front, key, figure.glow.x + in.answer.y);
    let width = max(figure.line.x * cell.viewport.w, 0.6);
    let near = 1.0 - smoothstep(width - 0.5, width + 0.5, abs(in.answer.z) / max(slope, 1e-12));
    let stirred = smoothstep(STILL * figure.line.y, STIRRED * figure.line.y, slope);
    var lines = figure.lines.rgb;
    if cell.output.x < 0.5 { lines = to_linear(lines); }
    c = mix(c, lines, figure.lines.w * near * stirred);
    return vec4f(c, 1.0) * figure.color.a;
}

@fragment
fn corner_fragment(in: CornerSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    // Derivatives first, while all neighbours run.
    let edge = fwidth(in.barycentric);
    let skin_color = textureSample(skin, skin_sampler, in.paint.xy).rgb;
    let kind = u32(figure.back.w);
    var c: vec3f;
    if kind == 1u {
        c = mapped(map_color(in.paint.x), in.at, in.normal, front);
    } else {
        var base = figure.color.rgb;
        if kind == 2u { base = in.paint; }
        if kind == 3u { base = skin_color; }
        var glow = figure.glow.x;
        if kind == 4u {
            base = palette_color(in.paint.x);
            glow += in.paint.y;
        }
        let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
        c = modelled(base, in.at, in.normal, front, key, glow);
    }
    if figure.wire_width.x > 0.0 {
        let d = in.barycentric / max(edge, vec3f(1e-9));
        let near = min(d.x, min(d.y, d.z));
        let line = 1.0 - smoothstep(figure.wire_width.x - 0.5, figure.wire_width.x + 0.5, near);
        c = mix(c, figure.wire.rgb, figure.wire.a * line);
    }
    return vec4f(c, 1.0) * figure.color.a;
}

struct Screen { @builtin(position) clip: vec4f, @location(0) at: vec2f }

// One triangle that covers the viewport.
@vertex
fn screen_vertex(@builtin(vertex_index) i: u32) -> Screen {
    let corner = vec2f(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0;
    return Screen(vec4f(corner, 0.0, 1.0), corner);
}

// The floor over a background of colour `behind`: light around the shape, its shadow, and a rim that fades.
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
    var c = textureSample(skin, skin_sampler, 0.5 + scale * in.at).rgb;
    if cell.output.x > 0.5 { c = to_srgb(c); }
    return vec4f(c, 1.0) * cell.background_center.w;
}

@fragment
fn backdrop_fragment(in: Screen) -> @location(0) vec4f {
    let r = length(in.at * vec2f(1.0, 1.0) + vec2f(0.0, -0.1));
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

// What is behind the surface shows through faintly.
@fragment
fn hidden_marker_fragment(in: Marker) -> @location(0) vec4f {
    return marker(in) * 0.22;
}

@group(0) @binding(0) var rough: texture_2d<f32>;

// How bright a premultiplied colour looks, transparency being grey.
fn brightness(c: vec4f) -> f32 {
    return dot(c.rgb, vec3f(0.299, 0.587, 0.114)) + 0.5 * (1.0 - c.a);
}

fn rough_at(p: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(rough)) - 1;
    return textureLoad(rough, clamp(p, vec2i(0), last), 0);
}

// Smooths edges by blurring along them (Lottes, FXAA, 2009; without its search for their ends, and
// from whole pixels, which cost a software device a third of filtered ones).
@fragment
fn smooth_fragment(in: Screen) -> @location(0) vec4f {
    let p = vec2i(in.clip.xy);
    let here = textureLoad(rough, p, 0);
    let m = brightness(here);
    let nw = brightness(rough_at(p + vec2i(-1, -1)));
    let ne = brightness(rough_at(p + vec2i(1, -1)));
    let sw = brightness(rough_at(p + vec2i(-1, 1)));
    let se = brightness(rough_at(p + vec2i(1, 1)));
    let low = min(m, min(min(nw, ne), min(sw, se)));
    let high = max(m, max(max(nw, ne), max(sw, se)));
    // Across the steepest slope, and longer where it is flatter.
    var along = vec2f((sw + se) - (nw + ne), (nw + sw) - (ne + se));
    let flat = max((nw + ne + sw + se) * (0.25 / 8.0), 1.0 / 128.0);
    along = clamp(along / (min(abs(along.x), abs(along.y)) + flat), vec2f(-8.0), vec2f(8.0));
    let one = vec2i(round(along / 6.0));
    let two = vec2i(round(along / 2.0));
    let near = 0.5 * (rough_at(p - one) + rough_at(p + one));
    let far = 0.5 * near + 0.25 * (rough_at(p - two) + rough_at(p + two));
    let reached = brightness(far);
    let smoothed = select(far, near, reached < low || reached > high);
    return select(smoothed, here, high - low < max(1.0 / 24.0, high / 8.0));
}
