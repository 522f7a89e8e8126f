// Colors: linear light, sRGB, and the curves between.

fn to_linear(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn to_srgb(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3f(0.0031308));
}

// The target's numbers of a linear-light color.
fn encoded(c: vec3f) -> vec3f {
    let bounded = clamp(c, vec3f(0.0), vec3f(1.0));
    if cell.output.x > 0.5 { return to_srgb(bounded); }
    return bounded;
}

// Khronos PBR Neutral tone mapper (2024): colors below the shoulder stay true.
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
// bright colors turn to white.
fn filmed(linear: vec3f) -> vec3f {
    let gray = dot(linear, vec3f(0.2126, 0.7152, 0.0722));
    let x = mix(linear, vec3f(gray), 0.06) * 0.6;
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

fn curved(linear: vec3f) -> vec3f {
    return select(toned(linear), filmed(linear), cell.output.w > 0.5);
}
