// Effects on a finished picture. Colors are its own numbers, sRGB-encoded and premultiplied; light spreads on small
// pictures of their squares.

struct Finish {
    // Pixels of the picture.
    size: vec2f,
    // Share of the last picture that is left, and the part of its size that is seen.
    trail: vec2f,
    // Strength and threshold.
    bloom: vec2f,
    vignette: f32,
    grain: f32,
    moment: u32,
    // Pixels in one of the small picture.
    step: u32,
    // The 255ths that trails lose besides. WebGL2 wants uniforms of a multiple of 16 bytes.
    @size(8) fade: f32,
}

@group(0) @binding(0) var<uniform> finish: Finish;
@group(0) @binding(1) var smooth_sampler: sampler;
@group(0) @binding(2) var picture: texture_2d<f32>;
@group(0) @binding(3) var near: texture_2d<f32>;
@group(0) @binding(4) var far: texture_2d<f32>;
@group(0) @binding(5) var last: texture_2d<f32>;

@vertex
fn screen_vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}

// The mean, over a square of pixels, of each pixel's light above the threshold.
@fragment
fn bright_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let first = vec2u(clip.xy) * finish.step;
    let end = min(first + finish.step, vec2u(finish.size));
    var sum = vec3f(0.0);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let c = textureLoad(picture, vec2u(x, y), 0).rgb;
            let peak = max(c.r, max(c.g, c.b));
            sum += c * c * (max(peak - finish.bloom.y, 0.0) / (1.0 - finish.bloom.y));
        }
    }
    return vec4f(sum / f32((end.x - first.x) * (end.y - first.y)), 1.0);
}

// The mean of 4 × 4 pixels.
@fragment
fn smaller_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let first = vec2u(clip.xy) * 4u;
    let end = min(first + 4u, textureDimensions(picture));
    var sum = vec3f(0.0);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) { sum += textureLoad(picture, vec2u(x, y), 0).rgb; }
    }
    return vec4f(sum / f32((end.x - first.x) * (end.y - first.y)), 1.0);
}

fn spread(clip: vec4f, along: vec2i) -> vec4f {
    let end = vec2i(textureDimensions(picture)) - 1;
    let p = vec2i(clip.xy);
    var weights = array<f32, 5>(0.2042, 0.1802, 0.1238, 0.0663, 0.0276);
    var sum = textureLoad(picture, p, 0).rgb * weights[0];
    for (var i = 1; i < 5; i++) {
        let before = textureLoad(picture, clamp(p - i * along, vec2i(0), end), 0).rgb;
        let after = textureLoad(picture, clamp(p + i * along, vec2i(0), end), 0).rgb;
        sum += (before + after) * weights[i];
    }
    return vec4f(sum, 1.0);
}

@fragment
fn across_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return spread(clip, vec2i(1, 0));
}

@fragment
fn down_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return spread(clip, vec2i(0, 1));
}

// A number in [−½, ½) for a pixel and a moment (O'Neill's PCG, 2014).
fn chance(x: u32, y: u32, moment: u32) -> f32 {
    let seed = (x * 1664525u + y * 1013904223u + moment * 69069u) * 747796405u + 2891336453u;
    var word = ((seed >> ((seed >> 28u) + 4u)) ^ seed) * 277803737u;
    word = (word >> 22u) ^ word;
    return f32(word >> 8u) / 16777216.0 - 0.5;
}

@fragment
fn finish_fragment(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let p = vec2u(clip.xy);
    var c = textureLoad(picture, p, 0);
    let small = clip.xy / f32(finish.step);
    let spread_light = textureSampleLevel(near, smooth_sampler, small / vec2f(textureDimensions(near)), 0.0).rgb
        + textureSampleLevel(far, smooth_sampler, 0.25 * small / vec2f(textureDimensions(far)), 0.0).rgb;
    c = vec4f(min(sqrt(c.rgb * c.rgb + finish.bloom.x * spread_light), vec3f(1.0)), c.a);
    let seen = (clip.xy / finish.size - 0.5) * finish.trail.y + 0.5;
    // A little less than is left, so that eight bits come to nothing.
    c = max(c, textureSampleLevel(last, smooth_sampler, seen, 0.0) * finish.trail.x - finish.fade / 255.0);
    let off = (2.0 * clip.xy / finish.size - 1.0) * vec2f(0.72, 0.72);
    let rim = smoothstep(0.25, 1.05, dot(off, off));
    let noise = finish.grain * chance(p.x, p.y, finish.moment) * c.a;
    let rgb = clamp(c.rgb * (1.0 - finish.vignette * rim) + noise, vec3f(0.0), vec3f(1.0));
    return vec4f(rgb, max(c.a, max(rgb.r, max(rgb.g, rgb.b))));
}
