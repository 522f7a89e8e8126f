//! Each limit of WCAG 2.3.1 and of ITU-R BT.1702 between two neighboring colors, areas and rates. The numbers in comments
//! are computed by hand from the definition of sRGB.

use crate::{FlashArea, FlashCount, FlashGuard, Histogram, MAX_FLASHES, Veil};

/// As many pixels as cells.
const SIZE: [u32; 2] = [48, 32];
/// Ten changes a second.
const FAST_SECS: f64 = 0.1;

/// Two colors in turn in a part of a picture that is else black, one each `every_secs`.
struct Strobe<Part: Fn([u32; 2]) -> bool> {
    colors: [[u8; 3]; 2],
    part: Part,
    every_secs: f64,
}

impl<Part: Fn([u32; 2]) -> bool> Strobe<Part> {
    /// Flashes in the worst second of four, guarded or not.
    fn flashes(&self, area: FlashArea, guarded: bool) -> usize {
        let (mut guard, mut count) = (FlashGuard::default(), FlashCount::of(area));
        guard.set_area(area);
        let mut picture = Histogram::default();
        let changes = (4.0 / self.every_secs) as u32;
        for (change, color) in (0..changes).zip(self.colors.iter().cycle()) {
            picture.clear();
            for at in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y])) {
                picture.add(at, SIZE, if (self.part)(at) { *color } else { [0; 3] });
            }
            let time_secs = f64::from(change) * self.every_secs;
            let veil = if guarded { guard.veil(time_secs, &picture) } else { Veil::Clear };
            count.note(time_secs, &picture, veil);
        }
        count.most_per_second()
    }
}

/// All of the picture.
fn whole(colors: [[u8; 3]; 2]) -> usize {
    let strobe = Strobe { colors, part: |_| true, every_secs: FAST_SECS };
    let guarded = strobe.flashes(FlashArea::Screen, true);
    assert!(guarded <= MAX_FLASHES, "{guarded} of {colors:?}");
    strobe.flashes(FlashArea::Screen, false)
}

fn gray(value: u8) -> [u8; 3] {
    [value; 3]
}

#[test]
fn a_tenth_of_the_range_of_luminance_is_a_flash() {
    // 0.0999 and 0.1022.
    assert_eq!(whole([gray(0), gray(89)]), 0);
    assert_eq!(whole([gray(0), gray(90)]), 5);
    // From 0.3050, by 0.0970 and 0.1023.
    assert_eq!(whole([gray(150), gray(170)]), 0);
    assert_eq!(whole([gray(150), gray(171)]), 5);
}

#[test]
fn the_darker_image_of_a_flash_is_below_eight_tenths() {
    // 0.7991 and 0.9047; 0.8070 and 0.9131.
    assert_eq!(whole([gray(231), gray(244)]), 5);
    assert_eq!(whole([gray(232), gray(245)]), 0);
}

#[test]
fn red_flashes_where_its_excess_changes_by_more_than_twenty() {
    // 320 · 0.0612 = 19.6 and 320 · 0.0630 = 20.2, and hardly any luminance.
    assert_eq!(whole([gray(0), [70, 0, 0]]), 0);
    assert_eq!(whole([gray(0), [71, 0, 0]]), 5);
}

#[test]
fn red_flashes_where_four_fifths_of_the_light_are_red() {
    // 1 / (1 + 0.2462) = 0.802 and 1 / (1 + 0.2502) = 0.7999, beside a gray of the same luminance.
    assert_eq!(whole([gray(168), [255, 136, 0]]), 5);
    assert_eq!(whole([gray(168), [255, 137, 0]]), 0);
}

/// Too faint for the mean: a quarter of 0.2159 is 0.054.
fn part_flashes(area: FlashArea, part: impl Fn([u32; 2]) -> bool) -> bool {
    let strobe = Strobe { colors: [gray(0), gray(128)], part, every_secs: FAST_SECS };
    let guarded = strobe.flashes(area, true);
    assert!(guarded <= MAX_FLASHES, "{guarded}");
    strobe.flashes(area, false) > MAX_FLASHES
}

#[test]
fn more_than_a_quarter_flashes_of_the_picture_or_of_a_field() {
    // 12 of 48 columns; one cell more.
    assert!(!part_flashes(FlashArea::Screen, |[x, _]| x < 12));
    assert!(part_flashes(FlashArea::Screen, |[x, y]| x < 12 || x == 12 && y == 0));
    // 44 of the 176 cells of a field; one more.
    let block = |[x, y]: [u32; 2]| (20..31).contains(&x) && (10..14).contains(&y);
    assert!(!part_flashes(FlashArea::Field, block));
    assert!(part_flashes(FlashArea::Field, |[x, y]| block([x, y]) || [x, y] == [20, 14]));
    assert!(!part_flashes(FlashArea::Screen, |[x, y]| block([x, y]) || [x, y] == [20, 14]));
}

#[test]
fn eight_changes_in_a_second_are_four_flashes_and_seven_are_three() {
    let flashes = |changes_hz: f64| {
        let strobe = Strobe { colors: [gray(0), gray(255)], part: |_| true, every_secs: changes_hz.recip() };
        strobe.flashes(FlashArea::Screen, false)
    };
    // Six and seven pauses between changes fit in a second.
    assert_eq!((flashes(6.9), flashes(7.1)), (3, 4));
}
