//! Shows made to get past the guard. Their remaining flashes are counted on the pixels that are shown.

use proptest::prelude::*;

use crate::{FlashArea, FlashCount, FlashGuard, Histogram, MAX_FLASHES, Veil};

const SIZE: [u32; 2] = [96, 64];
const RATE: u32 = 30;

/// The outcome of a sequence: flashes in the worst second, how many pictures were veiled, and the last veil.
#[derive(Debug)]
struct Seen {
    flashes: usize,
    veiled: usize,
    last: Veil,
}

/// Shows `frames` pictures of `color` at column, row and time, guarded or not.
fn show(frames: u32, guarded: bool, area: FlashArea, color: impl Fn([u32; 2], f64) -> [u8; 3]) -> Seen {
    let (mut guard, mut count) = (FlashGuard::default(), FlashCount::of(area));
    guard.set_area(area);
    let (mut picture, mut shown) = (Histogram::default(), Histogram::default());
    let mut seen = Seen { flashes: 0, veiled: 0, last: Veil::Clear };
    for frame in 0..frames {
        let time_secs = f64::from(frame) / f64::from(RATE);
        let pixels = || (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        picture.clear();
        pixels().for_each(|at| picture.add(at, SIZE, color(at, time_secs)));
        seen.last = if guarded { guard.veil(time_secs, &picture) } else { Veil::Clear };
        seen.veiled += usize::from(seen.last != Veil::Clear);
        shown.clear();
        pixels().for_each(|at| shown.add(at, SIZE, color(at, time_secs).map(|value| seen.last.over(value))));
        count.note(time_secs, &shown, Veil::Clear);
    }
    seen.flashes = count.most_per_second();
    seen
}

/// On or off, `hz` times a second.
fn is_on(time_secs: f64, hz: f64) -> bool {
    (time_secs * hz + 1e-9).fract() < 0.5
}

/// It flashes unless it is guarded, and then no more than it may.
fn is_tamed(frames: u32, color: impl Fn([u32; 2], f64) -> [u8; 3]) {
    [FlashArea::Screen, FlashArea::Field].into_iter().for_each(|area| is_tamed_in(area, frames, &color));
}

fn is_tamed_in(area: FlashArea, frames: u32, color: impl Fn([u32; 2], f64) -> [u8; 3]) {
    let [free, guarded] = [false, true].map(|guarded| show(frames, guarded, area, &color));
    assert!(free.flashes > MAX_FLASHES, "nothing flashes: {free:?}");
    assert!(guarded.flashes <= MAX_FLASHES && guarded.veiled > 0, "{guarded:?}");
}

fn is_untouched(frames: u32, color: impl Fn([u32; 2], f64) -> [u8; 3]) {
    is_untouched_in(FlashArea::Screen, frames, color);
}

fn is_untouched_in(area: FlashArea, frames: u32, color: impl Fn([u32; 2], f64) -> [u8; 3]) {
    let seen = show(frames, true, area, color);
    assert_eq!((seen.veiled, seen.last), (0, Veil::Clear), "{seen:?}");
}

#[test]
fn half_the_picture_may_not_strobe() {
    is_tamed(
        120,
        |[x, _], t| if x < SIZE[0] / 2 { [if is_on(t, 5.0) { 255 } else { 0 }; 3] } else { [150; 3] },
    );
}

/// Too little for the mean: its luminance changes by 0.078.
#[test]
fn a_third_of_the_picture_may_not_strobe_faintly() {
    is_tamed(
        120,
        |[x, _], t| {
            if x < SIZE[0] / 3 { [if is_on(t, 6.0) { 150 } else { 90 }; 3] } else { [40; 3] }
        },
    );
}

#[test]
fn halves_that_strobe_in_turn_keep_the_mean_and_are_tamed() {
    is_tamed(120, |[x, _], t| [if (x < SIZE[0] / 2) == is_on(t, 5.0) { 255 } else { 0 }; 3]);
}

#[test]
fn a_checkerboard_that_strobes_keeps_the_mean_and_is_tamed() {
    is_tamed(120, |[x, y], t| [if ((x / 8 + y / 8) % 2 == 0) == is_on(t, 5.0) { 220 } else { 30 }; 3]);
}

#[test]
fn red_and_blue_in_turn_are_tamed() {
    // Both have a relative luminance of 0.07, so that only red flashes.
    is_tamed(120, |_, t| if is_on(t, 5.0) { [156, 0, 0] } else { [0, 0, 255] });
}

#[test]
fn red_in_half_of_a_picture_is_tamed() {
    is_tamed(120, |[_, y], t| if y < SIZE[1] / 2 && is_on(t, 4.0) { [150, 0, 0] } else { [30, 30, 30] });
}

#[test]
fn a_small_part_may_strobe() {
    is_untouched(120, |[x, y], t| {
        let inside = x < SIZE[0] / 4 && y < SIZE[1] / 4;
        [if inside && is_on(t, 6.0) { 255 } else { 40 }; 3]
    });
}

#[test]
fn a_small_part_may_not_strobe_where_it_fills_a_quarter_of_a_field() {
    let strobe = |columns: u32, rows: u32| {
        move |[x, y]: [u32; 2], t: f64| {
            let inside = (30..30 + columns).contains(&x) && (20..20 + rows).contains(&y);
            [if inside && is_on(t, 6.0) { 255 } else { 40 }; 3]
        }
    };
    is_tamed_in(FlashArea::Field, 120, strobe(24, 16));
    is_tamed_in(FlashArea::Field, 120, strobe(16, 14));
    is_untouched_in(FlashArea::Field, 120, strobe(12, 10));
    is_untouched(120, strobe(24, 16));
}

#[test]
fn a_part_may_flash_slowly() {
    is_untouched(
        150,
        |[x, _], t| {
            if x < SIZE[0] / 3 { [if is_on(t, 2.5) { 140 } else { 90 }; 3] } else { [40; 3] }
        },
    );
}

#[test]
fn slow_fades_and_slow_red_stay() {
    let slow = |t: f64, hz: f64| 0.5 + 0.5 * (std::f64::consts::TAU * hz * t).sin();
    is_untouched(150, |[x, _], t| {
        let level = (200.0 * slow(t + f64::from(x) / 96.0, 0.6)) as u8;
        if x < SIZE[0] / 2 { [level; 3] } else { [level, 0, 0] }
    });
}

/// A bright body that swings over a dark ground, as a dance does: in any one place few changes.
#[test]
fn a_body_that_swings_stays_clear() {
    is_untouched(150, |[x, y], t| {
        let at = 48.0 + 25.0 * (std::f64::consts::TAU * 2.0 * t).sin();
        let (dx, dy) = (f64::from(x) - at, f64::from(y) - 32.0);
        if dx * dx + dy * dy < 18.0 * 18.0 { [230, 200, 160] } else { [25, 25, 32] }
    });
}

#[test]
fn the_veil_goes_when_the_strobe_is_over() {
    let strobe =
        |[x, _]: [u32; 2], t: f64| [if x < SIZE[0] / 2 && (t > 3.0 || is_on(t, 5.0)) { 255 } else { 90 }; 3];
    assert_ne!(show(90, true, FlashArea::Screen, strobe).last, Veil::Clear);
    assert_eq!(show(180, true, FlashArea::Screen, strobe).last, Veil::Clear);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Four parts, each with its own row of colors.
    #[test]
    fn no_show_of_parts_flashes_more_than_three_times_a_second(
        colors in prop::collection::vec(prop::array::uniform4(prop::sample::select(vec![
            [0u8, 0, 0], [255, 255, 255], [255, 0, 0], [0, 0, 255], [120, 10, 0], [128, 128, 128], [200, 90, 20],
        ])), 10..90),
        hold in 1u32..5,
    ) {
        let color = |[x, y]: [u32; 2], t: f64| {
            let frame = (t * f64::from(RATE)).round() as usize / hold as usize;
            colors[frame % colors.len()][(x / 48 + 2 * (y / 32)) as usize]
        };
        for area in [FlashArea::Screen, FlashArea::Field] {
            let seen = show(90, true, area, color);
            prop_assert!(seen.flashes <= MAX_FLASHES, "{:?}: {:?}", area, seen);
        }
    }
}
