// The paint of a surface, and its pixels.

fn map_color(value: f32) -> vec3f {
    return row_color(clamp((value - figure.scale.x) * figure.scale.y, 0.0, 1.0));
}

// Of palettes: around, or there and back.
fn palette_color(at: f32) -> vec3f {
    let around = at - floor(at);
    let back = 1.0 - abs(at - 2.0 * floor(0.5 * at) - 1.0);
    let c = row_color(select(back, around, figure.glow.w > 0.5));
    let gray = dot(c, vec3f(0.2126, 0.7152, 0.0722));
    return max(mix(vec3f(gray), c, figure.glow.z), vec3f(0.0));
}

fn row_color(t: f32) -> vec3f {
    let row = (figure.scale.z + 0.5) / f32(textureDimensions(maps).y);
    return textureSampleLevel(maps, map_sampler, vec2f((t * 255.0 + 0.5) / 256.0, row), 0.0).rgb;
}

// The part of a surface under a brush, with the distance from the brush's center along it.
struct Brushed {
    @builtin(position) clip: vec4f,
    @location(0) reach: f32,
}

@vertex
fn brush_vertex(@location(0) position: vec3f, @location(1) reach: f32) -> Brushed {
    return Brushed(cell.projection * (cell.view * (figure.model * vec4f(position, 1.0))), reach);
}

// The brush's ring and a breath of its color inside.
@fragment
fn brush_fragment(in: Brushed) -> @location(0) vec4f {
    let step = fwidth(in.reach);
    let ring = 1.0 - smoothstep(0.7, 1.7, abs(in.reach - figure.brush.w) / max(step, 1e-9));
    let inside = select(0.0, 0.13, in.reach < figure.brush.w);
    var c = figure.brush.rgb;
    if cell.output.x < 0.5 { c = to_linear(c); }
    return vec4f(c, 1.0) * max(ring, inside);
}

// Only depths are drawn.
@fragment
fn no_fragment() -> @location(0) vec4f {
    return vec4f(0.0);
}

@fragment
fn plain_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let c = modeled(figure.color.rgb, in.at, in.normal, front, key, figure.glow.x);
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
    let c = modeled(in.color, in.at, in.normal, front, key, figure.glow.x);
    return vec4f(c, 1.0) * figure.color.a;
}

@fragment
fn answer_fragment(in: AnsweredSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let c = modeled(palette_color(in.answer.x), in.at, in.normal, front, key, figure.glow.x + in.answer.y);
    return vec4f(c, 1.0) * figure.color.a;
}

// Below this share of the farthest displacement, the phase fades out.
const PHASED = 0.04;
// A displacement that changes by less than these shares of the farthest from pixel to pixel has no nodal lines, or
// faint ones.
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
    // Derivatives first, while all neighbors run.
    let slope = fwidth(in.answer.z);
    let key = lit_by_key(in.map_at, select(-in.map_step, in.map_step, front), in.clip.xy);
    let place = in.answer.x + figure.figured.z * turns_of(in.answer.z, in.answer.w);
    var c = modeled(palette_color(place), in.at, in.normal, front, key, figure.glow.x + in.answer.y);
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
    // Derivatives first, while all neighbors run.
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
        c = modeled(base, in.at, in.normal, front, key, glow);
    }
    if figure.wire_width.x > 0.0 {
        let d = in.barycentric / max(edge, vec3f(1e-9));
        let near = min(d.x, min(d.y, d.z));
        let line = 1.0 - smoothstep(figure.wire_width.x - 0.5, figure.wire_width.x + 0.5, near);
        var wire = figure.wire.rgb;
        if cell.output.x < 0.5 { wire = to_linear(wire); }
        c = mix(c, wire, figure.wire.a * line);
    }
    return vec4f(c, 1.0) * figure.color.a;
}
