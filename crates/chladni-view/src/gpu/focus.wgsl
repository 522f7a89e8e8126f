// Depth of field: light out of focus spreads on a small picture, which is laid over the sharp one. Colors are the
// picture's own numbers, sRGB-encoded and premultiplied; light spreads as their squares.

// The lens of a cell.
struct Circle {
    // From a depth to its distance beyond the focus, over its distance from the eye: the value at 0, and the slope.
    line: vec2f,
    // Distances below this count as 0.
    sharp: f32,
    // Radius per unit of distance beyond that, in pixels of the small picture, and the largest radius.
    radius: f32,
    @size(16) most: f32,
}

struct Spread {
    // Pixels of the picture.
    size: vec2f,
    // Pixels in one of the small picture.
    step: u32,
    // Taps: offset right and down in whole pixels, its length, and the area that the tap stands for. 64 for even
    // rows, and others for odd ones.
    taps: array<vec4f, 128>,
}

@group(0) @binding(0) var<uniform> spread: Spread;
@group(0) @binding(1) var smooth_sampler: sampler;
@group(0) @binding(2) var picture: texture_2d<f32>;
// Radius of each pixel's circle of light, pixels of the small picture; below 0 before the focus.
@group(0) @binding(3) var circles: texture_2d<f32>;
// The spread light, as `Layers` has it.
@group(0) @binding(4) var light: texture_2d<f32>;
@group(0) @binding(5) var before: texture_2d<f32>;
@group(0) @binding(6) var cover: texture_2d<f32>;

@group(0) @binding(0) var<uniform> circle: Circle;
@group(1) @binding(0) var depths: texture_depth_multisampled_2d;
@group(1) @binding(0) var one_depth: texture_2d<f32>;
// GL gives nothing of depths without one.
@group(1) @binding(1) var depth_sampler: sampler;

@vertex
fn screen_vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}

// The radius of the circle of light at this depth. Depth 1 is behind all figures, infinitely far away.
fn circle_at(depth: f32) -> f32 {
    let way = select(circle.line.x + circle.line.y * depth, 1.0, depth >= 1.0);
    let radius = min(max(abs(way) - circle.sharp, 0.0) * circle.radius, circle.most);
    return select(radius, -radius, way < 0.0);
}

// The circle of the nearest depth in a pixel.
@fragment
fn circles_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    var nearest = 1.0;
    for (var i = 0; i < 4; i++) { nearest = min(nearest, textureLoad(depths, vec2i(clip.xy), i)); }
    return vec4f(circle_at(nearest), 0.0, 0.0, 1.0);
}

// One of the depths that are no samples.
fn depth_at(p: vec2i) -> f32 {
    let at = (vec2f(p) + 0.5) / vec2f(textureDimensions(one_depth));
    return textureSampleLevel(one_depth, depth_sampler, at, 0.0).r;
}

// The same of one sample a pixel.
@fragment
fn circle_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return vec4f(circle_at(depth_at(vec2i(clip.xy))), 0.0, 0.0, 1.0);
}

// The same where each pixel has four depths side by side.
@fragment
fn fine_circle_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    var nearest = 1.0;
    for (var i = 0; i < 4; i++) {
        nearest = min(nearest, depth_at(2 * vec2i(clip.xy) + vec2i(i & 1, i >> 1u)));
    }
    return vec4f(circle_at(nearest), 0.0, 0.0, 1.0);
}

struct Small { @location(0) light: vec4f, @location(1) number: vec4f }

// Each square of pixels as one: the circle of the nearest thing in it, and the color of all pixels with such a
// circle.
@fragment
fn shrink_fragment(@builtin(position) clip: vec4f) -> Small {
    let first = vec2u(clip.xy) * spread.step;
    let end = min(first + spread.step, vec2u(spread.size));
    var nearest = 1e9;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            nearest = min(nearest, textureLoad(circles, vec2u(x, y), 0).r);
        }
    }
    var sum = vec4f(0.0);
    var all = 0.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let away = abs(textureLoad(circles, vec2u(x, y), 0).r - nearest);
            let weight = max(1.0 - away, 0.0) + 1.0 / 256.0;
            let c = textureLoad(picture, vec2u(x, y), 0);
            sum += c * c * weight;
            all += weight;
        }
    }
    return Small(sum / all, vec4f(nearest, 0.0, 0.0, 1.0));
}

// The part of a disc that a pixel is, where the whole is the square of its radius.
const PIXEL = 0.31830987;

// How far the colors beside sharp places are continued into them.
const CONTINUED = 2.0;

// The weight of a neighbor's color. Sharp neighbors weigh little, so that they do not spread onto soft ones, except
// for a pixel before the focus, where `whole` is 1 and all colors weigh the same.
fn soft(radius: f32, whole: f32) -> f32 {
    return mix(min(abs(radius), 1.0) + 1.0 / 64.0, 1.0, whole);
}

// Weight, in the far layer, of color before the focus: it counts there only where it covers all else.
const HIDDEN = 1e-3;

// Light after spreading: from in or behind the focus; from before it, times its cover; and that cover.
struct Layers { @location(0) far: vec4f, @location(1) near: vec4f, @location(2) cover: vec4f }

// How much of the sharp picture goes where the circle has this radius.
fn softness(radius: f32) -> f32 {
    return smoothstep(0.25, 1.0, radius);
}

// Gathers a pixel of the small picture from the circles around it.
@fragment
fn gather_fragment(@builtin(position) clip: vec4f) -> Layers {
    let end = vec2i(textureDimensions(picture)) - 1;
    let p = vec2i(clip.xy);
    let middle = textureLoad(circles, p, 0).r;
    let own = abs(middle);
    // Whether it is before the focus.
    let whole = softness(-middle);
    let reach = mix(max(own, CONTINUED * (1.0 - 2.0 * own)), own, whole);
    let mine = PIXEL / max(own * own, 1.0);
    // Weights of light from before the focus, and of all other light.
    var before = mine * whole;
    var behind = mine * (1.0 - whole) * soft(middle, whole);
    var near = textureLoad(picture, p, 0) * before;
    var far = textureLoad(picture, p, 0) * behind;
    for (var i = 0; i < 64; i++) {
        let tap = spread.taps[64 * (p.y & 1) + i];
        let at = clamp(p + vec2i(tap.xy), vec2i(0), end);
        let there = textureLoad(circles, at, 0).r;
        // A neighbor behind this pixel reaches as far as this pixel's own circle, and at least CONTINUED where the
        // pixel is sharp. A neighbor before it reaches as far as the neighbor's circle.
        let size = select(abs(there), reach, there > middle);
        let share = clamp(size - tap.z + 0.5, 0.0, 1.0) * tap.w / max(size * size, 1.0);
        let nearer = share * softness(-there);
        let weight = (share - nearer) * soft(there, whole);
        let c = textureLoad(picture, at, 0);
        near += c * nearer;
        far += c * weight;
        before += nearer;
        behind += weight;
    }
    let covered = mix(min(before, 1.0), before / (before + behind), whole);
    // Behind what covers all is taken to be the same.
    let base = (far + near * HIDDEN) / (behind + before * HIDDEN + 1e-9);
    return Layers(base, near * (covered / max(before, 1e-9)), vec4f(covered, 0.0, 0.0, 1.0));
}

// The mean of what has spread there and around, of like softness: of the taps of two rows.
@fragment
fn even_fragment(@builtin(position) clip: vec4f) -> Layers {
    let end = vec2i(textureDimensions(circles)) - 1;
    let p = vec2i(clip.xy);
    let own = abs(textureLoad(circles, p, 0).r);
    var sum = vec4f(0.0);
    var all = 0.0;
    var near = vec4f(0.0);
    var covered = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = clamp(p + vec2i(x, y), vec2i(0), end);
            let tent = 0.0625 * f32((2 - abs(x)) * (2 - abs(y)));
            let alike = clamp(min(own, abs(textureLoad(circles, at, 0).r)) - 1.0, 0.0, 1.0);
            let weight = tent * select(alike, 1.0, x == 0 && y == 0);
            sum += textureLoad(light, at, 0) * weight;
            all += weight;
            near += textureLoad(before, at, 0) * tent;
            covered += textureLoad(cover, at, 0).r * tent;
        }
    }
    return Layers(sum / all, near, vec4f(covered, 0.0, 0.0, 1.0));
}

// Lays the spread light over the sharp picture.
@fragment
fn compose_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let p = vec2u(clip.xy);
    let at = clip.xy / f32(spread.step) / vec2f(textureDimensions(light));
    let base = textureSampleLevel(light, smooth_sampler, at, 0.0);
    let near = textureSampleLevel(before, smooth_sampler, at, 0.0);
    let covered = textureSampleLevel(cover, smooth_sampler, at, 0.0).r;
    let own = softness(abs(textureLoad(circles, p, 0).r));
    // The dither of the background was averaged away.
    let q = p & vec2u(1u);
    let share = 1.0 - (1.0 - own) * (1.0 - covered);
    let dither = (f32(2u * (q.x ^ q.y) + q.y) - 1.5) / (4.0 * 255.0) * share;
    let sharp = textureLoad(picture, p, 0);
    let c = sqrt(mix(sharp * sharp, base, own) * (1.0 - covered) + near) + vec4f(vec3f(dither), 0.0);
    return clamp(c, vec4f(0.0), vec4f(1.0));
}
