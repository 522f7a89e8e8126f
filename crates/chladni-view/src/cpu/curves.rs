//! Powers, cosines and pixels without branches or calls, so that loops of them become vectors. The bits are the
//! same with every instruction set.

/// The smaller one; `b` where `a` is not a number.
#[inline(always)]
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Maps each item. An array's own `map` may be compiled to a call, without the kernel's instructions, so kernels use
/// this.
#[inline(always)]
pub(super) fn each<T: Copy, U: Copy + Default, const N: usize>(items: [T; N], of: impl Fn(T) -> U) -> [U; N] {
    let mut all = [U::default(); N];
    for i in 0..N {
        all[i] = of(items[i]);
    }
    all
}

/// The larger one; `b` where `a` is not a number.
#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Between `low` and `high`; `low` where `x` is not a number.
#[inline(always)]
pub(super) fn clamp(x: f32, low: f32, high: f32) -> f32 {
    min(max(x, low), high)
}

#[inline(always)]
pub(super) fn mix(a: f32, b: f32, share: f32) -> f32 {
    a * (1.0 - share) + b * share
}

#[inline(always)]
pub(super) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = clamp((x - low) / (high - low), 0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 1.5 · 2²³: added, it leaves a number of less than 2²² rounded to a whole one in the low bits.
const WHOLE: f32 = 12_582_912.0;

/// The whole part of a number in [0, 2²²); of a whole one it, or the one below.
#[inline(always)]
pub(super) fn whole(x: f32) -> i32 {
    // Conversions that hold every number to the bounds of i32 do not become vectors.
    ((x - 0.5) + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits()) as i32
}

/// 2ˣ, to 2 · 10⁻⁷ of it; x is clamped so that the result is a normal number.
#[inline(always)]
pub(super) fn exp2(x: f32) -> f32 {
    let x = clamp(x, -126.0, 126.0);
    let rounded = x + WHOLE;
    let power = rounded.to_bits().wrapping_sub(WHOLE.to_bits());
    let f = x - (rounded - WHOLE);
    // Taylor's series of e^(f ln 2), |f| ≤ ½.
    let series = 1.540_353e-4;
    let series = series * f + 1.333_355_8e-3;
    let series = series * f + 9.618_129e-3;
    let series = series * f + 5.550_411e-2;
    let series = series * f + 2.402_265e-1;
    let series = series * f + 6.931_472e-1;
    let series = series * f + 1.0;
    f32::from_bits(series.to_bits().wrapping_add(power << 23))
}

#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    exp2(x * std::f32::consts::LOG2_E)
}

/// The binary logarithm of a positive normal number, to 2 · 10⁻⁷.
#[inline(always)]
pub(super) fn log2(x: f32) -> f32 {
    const HALF_ROOT: u32 = 0x3f35_04f3;
    let bits = x.to_bits();
    let power = bits.wrapping_sub(HALF_ROOT) as i32 >> 23;
    // Between √½ and √2.
    let m = f32::from_bits(bits.wrapping_sub((power << 23) as u32));
    // 2 artanh t / ln 2.
    let t = (m - 1.0) / (m + 1.0);
    let t2 = t * t;
    let series = 0.320_599;
    let series = series * t2 + 0.412_198_6;
    let series = series * t2 + 0.577_078_03;
    let series = series * t2 + 0.961_796_7;
    let series = series * t2 + 2.885_39;
    power as f32 + series * t
}

/// x to a positive power, x ≥ 0.
#[inline(always)]
pub(super) fn pow(x: f32, power: f32) -> f32 {
    if x > 1e-30 { exp2(power * log2(max(x, 1e-30))) } else { 0.0 }
}

/// The cosine of an angle below 10⁶, to 10⁻⁵.
#[inline(always)]
pub(super) fn cos(angle: f32) -> f32 {
    let turns = angle * (0.5 * std::f32::consts::FRAC_1_PI);
    let part = (turns - ((turns + WHOLE) - WHOLE)).abs();
    // The sine of the remainder to a quarter turn, in [−π/2, π/2].
    let s = (0.25 - part) * std::f32::consts::TAU;
    let s2 = s * s;
    let series = 2.755_731_9e-6;
    let series = series * s2 - 1.984_127e-4;
    let series = series * s2 + 8.333_333e-3;
    let series = series * s2 - 1.666_666_7e-1;
    s + s * s2 * series
}

/// The channels of a pixel, in [0, 1].
#[inline(always)]
pub(super) fn unpacked(pixel: [u8; 4]) -> [f32; 4] {
    // One word a pixel: bytes by themselves do not become vectors.
    let word = u32::from_le_bytes(pixel);
    each([word, word >> 8, word >> 16, word >> 24], |byte| (byte & 255) as i32 as f32 * (1.0 / 255.0))
}

/// The pixel of channels in [0, 1].
#[inline(always)]
pub(super) fn packed(channels: [f32; 4]) -> [u8; 4] {
    let [r, g, b, a] = each(channels, |c| (c * 255.0 + WHOLE).to_bits() & 255);
    (r | g << 8 | b << 16 | a << 24).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_parts_are_below() {
        for i in 0..10_000 {
            let x = 0.37 * i as f32;
            let below = x - whole(x) as f32;
            assert!((0.0..=1.0).contains(&below), "{x}");
        }
        assert_eq!((whole(0.0), whole(6.75)), (0, 6));
    }

    #[test]
    fn pixels_are_what_was_packed() {
        for value in 0..=255 {
            let pixel = [value, 255 - value, 7, 200];
            assert_eq!(packed(unpacked(pixel)), pixel);
        }
        assert_eq!(packed([0.0019, 0.002, 1.0, 0.5]), [0, 1, 255, 128]);
    }

    #[test]
    fn they_are_the_functions_that_they_say() {
        for i in -4000..=4000 {
            let x = i as f32 * 0.01;
            assert!((exp2(x) / x.exp2() - 1.0).abs() < 1e-6, "2^{x}");
            assert!((cos(x) - x.cos()).abs() < 2e-5, "cos {x}");
            let y = (0.2 * x).exp2();
            assert!((log2(y) - y.log2()).abs() < 1e-6, "log2 {y}");
            assert!((pow(y, 1.0 / 2.4) / y.powf(1.0 / 2.4) - 1.0).abs() < 3e-6, "{y}^(1/2.4)");
        }
        assert_eq!((pow(0.0, 2.4), exp(-1e9), clamp(f32::NAN, 0.0, 1.0)), (0.0, exp2(-126.0), 0.0));
    }
}
