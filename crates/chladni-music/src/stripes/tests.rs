//! Stripes of all kinds are found and darkened in time; pictures without any are left alone.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::{FlashCount, FlashGuard};

const SIZE: [u32; 2] = [480, 320];

/// A picture of a gray at each column and row.
fn picture(gray: impl Fn(f64, f64) -> u8) -> Histogram {
    let mut picture = Histogram::default();
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            picture.add([x, y], SIZE, [gray(f64::from(x), f64::from(y)); 3]);
        }
    }
    picture
}

fn has_stripes(picture: &Histogram) -> bool {
    let mut stripes = Stripes::default();
    stripes.look(picture);
    stripes.are_too_many(picture, Veil::Clear, FlashArea::Screen)
}

/// Light and dark of a pair that is 1 long, a share of it light.
fn bar(at: f64, share: f64, [light, dark]: [u8; 2]) -> u8 {
    if at.rem_euclid(1.0) < share { light } else { dark }
}

const BRIGHT_AND_DARK: [u8; 2] = [230, 20];

/// x, y and angle of a picture's place around its middle.
fn polar(x: f64, y: f64) -> (f64, f64) {
    let (x, y) = (x - 240.0, y - 160.0);
    (x.hypot(y), y.atan2(x) / std::f64::consts::TAU)
}

#[test]
fn more_than_five_pairs_are_a_pattern_and_five_are_none() {
    let bars = |pairs: f64| picture(move |x, _| bar(x / 480.0 * pairs + 0.5, 0.5, BRIGHT_AND_DARK));
    assert!(has_stripes(&bars(6.0)) && has_stripes(&bars(40.0)));
    assert!(!has_stripes(&bars(5.0)) && !has_stripes(&bars(2.0)));
}

#[test]
fn stripes_of_any_direction_are_found() {
    for degrees in (0..180).step_by(5) {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        for pair in [9.0, 14.0, 25.0, 40.0] {
            for share in [0.3, 0.5, 0.7] {
                let shown = picture(|x, y| bar((x * cos + y * sin) / pair, share, BRIGHT_AND_DARK));
                assert!(has_stripes(&shown), "{degrees}°, a pair of {pair} pixels, {share} of it light");
            }
        }
    }
}

#[test]
fn rings_rays_waves_and_checkerboards_are_found() {
    let both = |one: u8, other: u8| if one == other { 230 } else { 20 };
    for pair in [12.0, 20.0, 30.0] {
        let rings = picture(|x, y| bar(polar(x, y).0 / pair, 0.5, BRIGHT_AND_DARK));
        let waves = picture(|x, y| bar((x + 20.0 * (y / 40.0).sin()) / pair, 0.5, BRIGHT_AND_DARK));
        let checks =
            picture(|x, y| both(bar(x / pair, 0.5, BRIGHT_AND_DARK), bar(y / pair, 0.5, BRIGHT_AND_DARK)));
        let soft =
            picture(|x, y| (128.0 + 100.0 * ((x + 0.3 * y) / pair * std::f64::consts::TAU).sin()) as u8);
        let found = [&rings, &waves, &checks, &soft].map(has_stripes);
        assert_eq!(found, [true; 4], "a pair of {pair} pixels");
    }
    let rays = picture(|x, y| bar(36.0 * polar(x, y).1, 0.5, BRIGHT_AND_DARK));
    assert!(has_stripes(&rays));
}

#[test]
fn stripes_that_are_dim_faint_or_cover_less_than_a_quarter_may_stay() {
    let bars = |colors: [u8; 2], share: f64| {
        picture(move |x, y| if y < share * 320.0 { bar(x / 16.0, 0.5, colors) } else { 60 })
    };
    assert!(has_stripes(&bars(BRIGHT_AND_DARK, 0.3)) && !has_stripes(&bars(BRIGHT_AND_DARK, 0.22)));
    // A luminance of 0.258 and of 0.246: 50 cd/m² are 0.25.
    assert!(has_stripes(&bars([139, 20], 1.0)) && !has_stripes(&bars([136, 0], 1.0)));
    assert!(has_stripes(&bars([230, 205], 1.0)) && !has_stripes(&bars([230, 222], 1.0)));
}

#[test]
fn pictures_without_stripes_are_left_alone() {
    let body = |x: f64, y: f64| if polar(x, y).0 < 120.0 { 220u8 } else { 30 };
    let lit = |x: f64, y: f64| (230.0 * (1.0 - polar(x, y).0 / 300.0)) as u8;
    // A gallery of twelve bodies: four across, three down.
    let gallery = |x: f64, y: f64| {
        let (x, y) = (x.rem_euclid(120.0) - 60.0, y.rem_euclid(107.0) - 53.0);
        if x.hypot(y) < 40.0 { 220u8 } else { 30 }
    };
    for (name, gray) in [
        ("a body", &body as &dyn Fn(f64, f64) -> u8),
        ("a light", &lit),
        ("a gallery", &gallery),
        ("one color", &|_, _| 200),
    ] {
        assert!(!has_stripes(&picture(gray)), "{name}");
    }
}

#[test]
fn noise_of_any_grain_is_no_pattern() {
    for grain in [1, 2, 3, 5, 8, 13, 20, 40] {
        let mut random = ChaCha8Rng::seed_from_u64(grain);
        let columns = SIZE[0] as usize / grain as usize + 1;
        let grays: Vec<u8> = (0..columns * columns).map(|_| random.random()).collect();
        let at = |x: f64| x as usize / grain as usize;
        let noise = picture(|x, y| grays[at(y) * columns + at(x)]);
        assert!(!has_stripes(&noise), "grain {grain}");
    }
}

/// How long the stripes of `pictures` are seen, and by how much the last is darkened.
fn guarded(rate: f64, pictures: &[&Histogram]) -> (f64, Veil) {
    let (mut guard, mut count) = (FlashGuard::default(), FlashCount::default());
    let mut last = Veil::Clear;
    for (i, picture) in pictures.iter().enumerate() {
        let time_secs = i as f64 / rate;
        last = guard.veil(time_secs, picture);
        count.note(time_secs, picture, last);
    }
    assert!(count.most_per_second() <= crate::MAX_FLASHES);
    (count.longest_stripes_secs(), last)
}

/// A step of theirs is less than one of a veil.
#[test]
fn fast_screens_are_darkened_and_clear_again_in_the_same_time() {
    let bars = picture(|x, _| bar(x / 16.0, 0.5, [255, 0]));
    let plain = picture(|_, _| 120);
    for rate in [144.0, 400.0, 1000.0] {
        let (striped, over) = (vec![&bars; rate as usize], vec![&plain; 2 * rate as usize]);
        let (secs, veil) = guarded(rate, &striped);
        assert!(secs < 0.5 && matches!(veil, Veil::Black(_)), "{rate} a second: seen for {secs} s, {veil:?}");
        assert_eq!(guarded(rate, &[striped, over].concat()).1, Veil::Clear, "{rate} a second");
    }
}

#[test]
fn stripes_are_darkened_within_half_a_second_and_no_more_than_they_must() {
    let bars = [0.0, 0.25, 0.5, 0.75].map(|phase| picture(|x, _| bar(x / 16.0 + phase, 0.5, [255, 0])));
    let plain = picture(|_, _| 120);
    for rate in [10.0, 24.0, 60.0] {
        let still: Vec<&Histogram> = [&bars[0]; 90].into();
        let drifting: Vec<&Histogram> = bars.iter().cycle().take(90).collect();
        for (name, pictures) in [("still", still), ("drifting", drifting)] {
            let (secs, veil) = guarded(rate, &pictures);
            assert!(secs < 0.5, "{name}, {rate} pictures a second: seen for {secs} s");
            let Veil::Black(opacity) = veil else { panic!("{name}: {veil:?}") };
            assert!(name == "drifting" || (100..140).contains(&opacity), "{name}: {opacity}");
        }
        let over: Vec<&Histogram> = [[&bars[0]; 30].as_slice(), &[&plain; 90]].concat();
        assert_eq!(guarded(rate.min(24.0), &over).1, Veil::Clear);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    /// Whatever stripes do, they are not seen for half a second.
    #[test]
    fn no_show_of_stripes_gets_past(
        shows in prop::collection::vec((0.0f64..180.0, 9.0f64..40.0, 0.35f64..0.65, 0u8..90, 170u8..=255), 1..5),
        drift in -2.0f64..2.0, hold in 1usize..12,
    ) {
        let pictures: Vec<Histogram> = (0..30).map(|frame| {
            let (degrees, pair, share, dark, light) = shows[frame / hold % shows.len()];
            let (sin, cos) = degrees.to_radians().sin_cos();
            picture(|x, y| bar((x * cos + y * sin + drift * frame as f64) / pair, share, [light, dark]))
        }).collect();
        prop_assert!(pictures.iter().all(has_stripes));
        prop_assert!(guarded(24.0, &pictures.iter().collect::<Vec<_>>()).0 < 0.5);
    }
}
