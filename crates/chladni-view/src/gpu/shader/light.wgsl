// Lamps, surroundings, the key light's shadow, and how a surface answers them.

// The mix of left and right in `sides` at `x`, which is -1 at the left edge of the picture and 1 at the right.
fn wing(sides: vec2f, x: f32) -> f32 {
    return mix(sides.x, sides.y, smoothstep(-WING, WING, x));
}

// The place across the picture, from -1 to 1, of a point whose viewer is towards `v`.
fn across(v: vec3f) -> f32 {
    return -cell.projection[0][0] * v.x / max(v.z, 1e-3);
}

// The studio as seen along `d`: a floor, a ceiling, a horizon, two upright softboxes and one per light.
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
    let uv = vec2f(0.5 + atan2(d.x, -d.z) / 6.2831853, acos(clamp(d.y, -1.0, 1.0)) / 3.1415927);
    let c = textureSampleLevel(around, around_sampler, uv, level).rgb;
    return c / max(1.0 - c, vec3f(1e-3)) * cell.ground.w;
}

// The light from all around that reaches a surface, and the light that it mirrors.
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

// Radius of the disc in which shadows are filtered, in texels.
const DISC = 3.6;

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
    return 0.25 * (texel_lit(at, arm) + texel_lit(at, -arm) + texel_lit(at, across) + texel_lit(at, -across));
}

fn lit_at(at: vec3f, offset: vec2f) -> f32 {
    let tap = (at.xy + DISC * offset) * cell.shadow_place.zw;
    return textureSampleCompareLevel(shadows, shadow_sampler, tap, at.z);
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

// A surface of its own color under the lamps, as the target's numbers.
fn modeled(color: vec3f, at: vec3f, normal: vec3f, front: bool, key: f32, glow: f32) -> vec3f {
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
