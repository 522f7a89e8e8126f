// Edges of pictures that were sampled once.

@group(0) @binding(0) var rough: texture_2d<f32>;

// How bright a premultiplied color looks, transparency being gray.
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
