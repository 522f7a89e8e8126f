//! The formulas of `gpu/shader`, for a processor: the same names, the same order, no branches.

use glam::{Vec3, vec3};

use super::curves::{clamp, cos, exp, exp2, max, min, mix, pow, smoothstep};
use crate::buffers::Pyramid;
use crate::uniforms::{CellUniform, FigureUniform};

#[inline(always)]
pub(super) fn rgb([r, g, b, _]: [f32; 4]) -> Vec3 {
    vec3(r, g, b)
}

#[inline(always)]
fn each(a: Vec3, f: impl Fn(f32) -> f32) -> Vec3 {
    vec3(f(a.x), f(a.y), f(a.z))
}

#[inline(always)]
fn mixed(a: Vec3, b: Vec3, share: f32) -> Vec3 {
    a * (1.0 - share) + b * share
}

/// `a` over its length; `otherwise` where the length is not a positive number.
#[inline(always)]
pub(super) fn normalized(a: Vec3, otherwise: Vec3) -> Vec3 {
    let length = a.dot(a).sqrt();
    let there = length > 0.0;
    let scale = 1.0 / if there { length } else { 1.0 };
    let pick = |a: f32, b: f32| if there { a * scale } else { b };
    vec3(pick(a.x, otherwise.x), pick(a.y, otherwise.y), pick(a.z, otherwise.z))
}

#[inline(always)]
pub(super) fn to_srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * pow(c, 1.0 / 2.4) - 0.055 }
}

#[inline(always)]
fn encoded(c: Vec3) -> Vec3 {
    each(c, |c| to_srgb(clamp(c, 0.0, 1.0)))
}

#[inline(always)]
fn toned(linear: Vec3) -> Vec3 {
    let start = 0.76;
    let low = min(linear.x, min(linear.y, linear.z));
    let offset = if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let c = linear - Vec3::splat(offset);
    let peak = max(c.x, max(c.y, c.z));
    let d = 1.0 - start;
    let above = max(peak, start);
    let new_peak = 1.0 - d * d / (above + d - start);
    let g = 1.0 - 1.0 / (0.15 * (above - new_peak) + 1.0);
    let held = each(c * (new_peak / above), |c| mix(c, new_peak, g));
    let pick = |a: f32, b: f32| if peak < start { a } else { b };
    vec3(pick(c.x, held.x), pick(c.y, held.y), pick(c.z, held.z))
}

/// A pixel's color of light.
pub(super) fn finished(c: Vec3) -> Vec3 {
    encoded(toned(c))
}

#[inline(always)]
fn filmed(linear: Vec3) -> Vec3 {
    let gray = 0.2126 * linear.x + 0.7152 * linear.y + 0.0722 * linear.z;
    each(linear, |c| {
        let x = mix(c, gray, 0.06) * 0.6;
        (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
    })
}

#[inline(always)]
fn curved(cell: &CellUniform, linear: Vec3) -> Vec3 {
    let (neutral, film) = (toned(linear), filmed(linear));
    let pick = |a: f32, b: f32| if cell.output[3] > 0.5 { b } else { a };
    vec3(pick(neutral.x, film.x), pick(neutral.y, film.y), pick(neutral.z, film.z))
}

/// Half the width, of 2, in which the picture's left passes into its right.
const WING: f32 = 0.3;

/// The mix of left and right at `x`, which is -1 at the left edge of the picture and 1 at the right.
#[inline(always)]
pub(super) fn wing(left: f32, right: f32, x: f32) -> f32 {
    mix(left, right, smoothstep(-WING, WING, x))
}

/// Where in the picture, from -1 to 1, something lies whose viewer is towards `v`.
#[inline(always)]
fn across(cell: &CellUniform, v: Vec3) -> f32 {
    -cell.projection[0][0] * v.x / max(v.z, 1e-3)
}

#[inline(always)]
fn studio(cell: &CellUniform, d: Vec3, roughness: f32) -> Vec3 {
    let blur = mix(0.18, 0.9, roughness);
    let mut c = mixed(rgb(cell.ground), rgb(cell.sky) * 1.25, smoothstep(-blur, blur, d.y));
    c += rgb(cell.horizon) * exp(-mix(90.0, 5.0, roughness) * d.y * d.y);
    let strip = (d.x.abs() - 0.68) / mix(0.1, 0.5, roughness);
    let high = 1.0 - smoothstep(0.7 - blur, 0.7 + blur, d.y.abs());
    c += Vec3::splat(cell.sky[3] * exp(-strip * strip) * high * mix(1.6, 0.5, roughness));
    let tight = mix(26.0, 2.5, roughness);
    for [direction, color] in cell.lights {
        let near = exp(tight * (d.dot(rgb(direction)) - 1.0));
        c += rgb(color) * near * mix(1.3, 0.45, roughness);
    }
    c
}

/// The direction that is mirrored to the viewer.
#[inline(always)]
pub(super) fn reflected(n: Vec3, v: Vec3) -> Vec3 {
    n * (2.0 * n.dot(v)) - v
}

/// Light of a panorama as a surface of this roughness sees it towards `d`, as `panorama` of `gpu/shader`.
pub(super) fn panorama(cell: &CellUniform, around: &Pyramid, d: Vec3, level: f32) -> Vec3 {
    let turns = d.x.atan2(-d.z) / std::f32::consts::TAU;
    let down = clamp(d.y, -1.0, 1.0).acos() / std::f32::consts::PI;
    let light = around.level([0.5 + turns, down], level);
    Vec3::from(light.map(|c| c / (1.0 - c).max(1e-3))) * cell.ground[3]
}

/// The level of a panorama for chalk; mirrors use the first, and shining surfaces as rough as chalk the one before
/// the last.
pub(super) const CHALK: f32 = 4.0;

#[inline(always)]
fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}

/// How far light wraps around the terminator.
#[inline(always)]
pub(super) fn wrap(figure: &FigureUniform) -> f32 {
    0.45 * figure.material[2]
}

#[inline(always)]
fn shaded<const FILM: bool>(
    (cell, figure): (&CellUniform, &FigureUniform),
    base: Vec3,
    n: Vec3,
    v: Vec3,
    (key, glow, around): (f32, f32, Option<[Vec3; 2]>),
) -> Vec3 {
    let [roughness, metal, _, iridescence] = figure.material;
    let nv = clamp(n.dot(v), 0.0, 1.0);
    let mut tint = base;
    if FILM {
        let phase = vec3(0.0, 0.33, 0.67) + Vec3::splat(1.15 * nv + 0.25 * n.y);
        let film = each(phase, |phase| 0.5 + 0.5 * cos(std::f32::consts::TAU * phase));
        let share = iridescence * (1.0 - 0.55 * nv);
        tint = mixed(base, base * (Vec3::splat(0.62) + film * 0.62), share);
    }
    let f0 = mixed(Vec3::splat(0.04), tint, metal);
    let a = min(roughness * roughness + 0.05, 1.0);
    let mut diffuse = match around {
        Some([diffuse, _]) => diffuse,
        None => mixed(rgb(cell.ground), rgb(cell.sky), 0.5 + 0.5 * n.y),
    };
    let mut gloss = Vec3::ZERO;
    let wrap = wrap(figure);
    for (i, [direction, color]) in cell.lights.into_iter().enumerate() {
        let l = rgb(direction);
        let light = rgb(color) * if i == 0 { key } else { 1.0 };
        let nl = n.dot(l);
        let lit = max((nl + wrap) / (1.0 + wrap), 0.0);
        diffuse += light * (lit * mix(1.0, lit, wrap));
        let h = normalized(l + v, v);
        let nh = max(n.dot(h), 0.0);
        let vh = max(v.dot(h), 1e-3);
        let d = nh * nh * (a * a - 1.0) + 1.0;
        let fresnel = f0 + (Vec3::ONE - f0) * fifth(1.0 - vh);
        gloss += light * fresnel * (max(nl, 0.0) * (a * a / (d * d)) * 0.25 / (vh * vh));
    }
    let r =
        [1.0 - roughness, 0.0425 - 0.0275 * roughness, 1.04 - 0.572 * roughness, -0.04 + 0.022 * roughness];
    let k = min(r[0] * r[0], exp2(-9.28 * nv)) * r[0] + r[1];
    let share = f0 * (-1.04 * k + r[2]) + Vec3::splat(1.04 * k + r[3]);
    let mirror = match around {
        Some([_, mirror]) => mirror,
        None => studio(cell, reflected(n, v), roughness),
    };
    let mirror = mirror * share;
    let grazing = 1.0 - nv;
    let own = tint * glow + rgb(figure.edge) * (grazing * grazing * grazing);
    (tint * (1.0 - metal) * diffuse + gloss + mirror + own)
        * wing(cell.wings[0], cell.wings[1], across(cell, v))
}

#[inline(always)]
fn painted(cell: &CellUniform, color: Vec3, n: Vec3, v: Vec3) -> Vec3 {
    let light = 0.62
        + 0.16 * n.y
        + 0.42 * max(n.dot(rgb(cell.lights[0][0])), 0.0)
        + 0.16 * max(n.dot(rgb(cell.lights[1][0])), 0.0);
    color * (min(light, 1.08) * mix(0.8, 1.0, smoothstep(0.0, 0.5, n.dot(v))))
}

/// Back faces are tinted.
#[inline(always)]
fn base_of(figure: &FigureUniform, color: Vec3, front: bool) -> Vec3 {
    let tinted = color * rgb(figure.back);
    let pick = |a: f32, b: f32| if front { a } else { b };
    vec3(pick(color.x, tinted.x), pick(color.y, tinted.y), pick(color.z, tinted.z))
}

/// A surface of its own color under the lamps, sRGB-encoded. `FILM`: with the hues of thin films. `light`: share of
/// the key light, own light, and in a panorama the light from all around and the mirrored light.
#[inline(always)]
pub(super) fn modeled<const FILM: bool>(
    of: (&CellUniform, &FigureUniform),
    color: Vec3,
    n: Vec3,
    v: Vec3,
    front: bool,
    light: (f32, f32, Option<[Vec3; 2]>),
) -> Vec3 {
    encoded(curved(of.0, shaded::<FILM>(of, base_of(of.1, color, front), n, v, light)))
}

/// A heat map, sRGB-encoded.
#[inline(always)]
pub(super) fn mapped(
    (cell, figure): (&CellUniform, &FigureUniform),
    color: Vec3,
    n: Vec3,
    v: Vec3,
    front: bool,
) -> Vec3 {
    encoded(painted(cell, base_of(figure, color, front), n, v))
}
