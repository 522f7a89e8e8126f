//! The last look at a picture: the veil that keeps it from flashing, and a count of the flashes that are left.

use crate::flash::WorstSecond;
use crate::flash_area::{Places, Quantity};
use crate::flash_field::FlashArea;
use crate::histogram::Histogram;
use crate::stripes::Stripes;
use crate::{FlashLimiter, Veil};

/// Keeps the pictures of a film or a window from flashing more than three times a second: in their mean luminance and, in
/// luminance or saturated red, in more than a quarter of an area. Bright stripes in more than a quarter are darkened, too.
///
/// ```
/// use chladni_music::{FlashGuard, Histogram, Veil};
///
/// let (mut guard, mut picture) = (FlashGuard::default(), Histogram::default());
/// picture.add([0, 0], [1, 1], [0, 0, 0]);
/// assert_eq!(guard.veil(0.0, &picture), Veil::Clear);
/// // White a frame later is more than is let through at once.
/// picture.clear();
/// picture.add([0, 0], [1, 1], [255, 255, 255]);
/// assert!(matches!(guard.veil(1.0 / 60.0, &picture), Veil::Black(_)));
/// ```
#[derive(Clone, Debug)]
pub struct FlashGuard {
    limiter: FlashLimiter,
    places: [Places; 4],
    area: FlashArea,
    stripes: Stripes,
    /// How black places and stripes made it, and when. Of 255, and with its fraction: a step of a fast screen is less than
    /// one.
    held: Option<(f64, f64)>,
}

impl Default for FlashGuard {
    fn default() -> Self {
        let [luminance, red] = [Quantity::Luminance, Quantity::Red].map(Places::guarding);
        let [exact_luminance, exact_red] = [Quantity::Luminance, Quantity::Red].map(Places::rising);
        let places = [luminance, red, exact_luminance, exact_red];
        let (limiter, area, stripes) = Default::default();
        Self { limiter, places, area, stripes, held: None }
    }
}

/// Black because of a part of the picture goes within this time.
const LIFT_SECS: f64 = 1.0;
/// Black because of stripes comes within this time; they may be seen for half a second.
const LOWER_SECS: f64 = 0.4;

impl FlashGuard {
    /// Where no more than a quarter may flash from now on.
    pub fn set_area(&mut self, area: FlashArea) {
        self.area = area;
    }

    /// The veil with which the picture may be shown at `time_secs`, which must not fall from call to call. It is no
    /// denser than flashes need, but black that parts of the picture needed goes only within a second. Allocates
    /// nothing, except where more changes fall into a second than ever before.
    pub fn veil(&mut self, time_secs: f64, picture: &Histogram) -> Veil {
        self.veil_over_dark(time_secs, picture, 0)
    }

    /// The [`veil`](Self::veil) of a picture that somebody darkens: black of at least the opacity `dark`, which stays where
    /// less of it would flash.
    pub fn veil_over_dark(&mut self, time_secs: f64, picture: &Histogram, dark: u8) -> Veil {
        self.places.iter_mut().for_each(|places| places.forget(time_secs));
        let (least, held) = self.least(time_secs, picture, dark);
        self.held = Some((time_secs, held));
        let veil = self.mean_veil(time_secs, picture, least);
        self.limiter.show(time_secs, picture.luminance(veil));
        self.places.iter_mut().for_each(|places| places.show(time_secs, picture, veil));
        veil
    }

    /// How black parts of the picture need it, at least `dark`, and from where that goes on.
    fn least(&mut self, time_secs: f64, picture: &Histogram, dark: u8) -> (u8, f64) {
        let (since_secs, held) = self.held.unwrap_or((time_secs, 0.0));
        let gone_secs = (time_secs - since_secs).max(0.0);
        let kept = (held - 255.0 * gone_secs / LIFT_SECS).max(0.0);
        let soon = (held + 255.0 * gone_secs / LOWER_SECS).min(255.0);
        let clearest = (kept.ceil() as u8).max(dark);
        let blackest = (soon as u8).max(clearest);
        self.stripes.look(picture);
        let striped = |opacity| self.stripes.are_too_many(picture, Veil::black(opacity), self.area);
        let for_stripes = thinnest(clearest, |opacity| opacity >= blackest || !striped(opacity));
        let least = thinnest(for_stripes, |opacity| !self.would_flash(picture, Veil::black(opacity)));
        let goes_on = if least > for_stripes {
            f64::from(least)
        } else if least == blackest && striped(least) {
            soon
        } else if least == clearest {
            kept
        } else {
            f64::from(least)
        };
        (least, goes_on)
    }

    /// The veil that the mean luminance needs, at least as black as `least`. Where parts need black, the mean may
    /// fall at once.
    fn mean_veil(&self, time_secs: f64, picture: &Histogram, least: u8) -> Veil {
        let clearest = Veil::black(least);
        let wanted = picture.luminance(clearest);
        let allowed = self.limiter.allowed(time_secs, wanted);
        // The luminance falls or rises steadily with the opacity.
        if allowed < wanted {
            Veil::black(thinnest(least, |opacity| picture.luminance(Veil::black(opacity)) <= allowed))
        } else if allowed > wanted && least == 0 {
            let white =
                Veil::White(thinnest(0, |opacity| picture.luminance(Veil::White(opacity)) >= allowed));
            if self.would_flash(picture, white) { clearest } else { white }
        } else {
            clearest
        }
    }

    fn would_flash(&self, picture: &Histogram, veil: Veil) -> bool {
        self.places.iter().any(|places| places.would_flash(picture, veil, self.area))
    }

    /// Whether a change that no veil can soften, such as panels of the window appearing, may happen now. If
    /// so, it is counted as one of a flash's two changes.
    pub fn may_step(&mut self, time_secs: f64) -> bool {
        self.limiter.may_step(time_secs)
    }
}

/// The lowest opacity, not below `least`, that is `enough`, as all above it are; 255 where none is.
fn thinnest(least: u8, enough: impl Fn(u8) -> bool) -> u8 {
    if enough(least) {
        return least;
    }
    let (mut thin, mut dense) = (least, 255u8);
    while thin < dense {
        let middle = thin + (dense - thin) / 2;
        if enough(middle) { dense = middle } else { thin = middle + 1 }
    }
    dense
}

/// Counts flashes of the shown pictures, of the mean luminance and of luminance and saturated red in more than a
/// quarter of an area, and how long stripes were seen in more than a quarter of it.
#[derive(Clone, Debug)]
pub struct FlashCount {
    area: FlashArea,
    mean: WorstSecond,
    places: [Places; 2],
    most_in_places: usize,
    stripes: Stripes,
    striped_since_secs: Option<f64>,
    longest_stripes_secs: f64,
}

impl Default for FlashCount {
    fn default() -> Self {
        Self::of(FlashArea::default())
    }
}

impl FlashCount {
    /// Where more than a quarter must flash to be counted.
    pub fn of(area: FlashArea) -> Self {
        Self {
            area,
            mean: WorstSecond::default(),
            places: [Quantity::Luminance, Quantity::Red].map(Places::counting),
            most_in_places: 0,
            stripes: Stripes::default(),
            striped_since_secs: None,
            longest_stripes_secs: 0.0,
        }
    }

    /// Notes the picture shown at `time_secs`: `picture` behind `veil`.
    pub fn note(&mut self, time_secs: f64, picture: &Histogram, veil: Veil) {
        self.mean.show(time_secs, picture.luminance(veil));
        for places in &mut self.places {
            places.show(time_secs, picture, veil);
            self.most_in_places = self.most_in_places.max(places.flashes(picture, self.area));
        }
        self.stripes.look(picture);
        let since_secs = self.striped_since_secs.unwrap_or(time_secs);
        let is_striped = self.stripes.are_too_many(picture, veil, self.area);
        self.striped_since_secs = is_striped.then_some(since_secs);
        if is_striped {
            self.longest_stripes_secs = self.longest_stripes_secs.max(time_secs - since_secs);
        }
    }

    /// Flashes in the worst second.
    pub fn most_per_second(&self) -> usize {
        self.mean.flashes().max(self.most_in_places)
    }

    /// The longest time for which bright stripes covered more than a quarter.
    pub fn longest_stripes_secs(&self) -> f64 {
        self.longest_stripes_secs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flat(value: u8) -> Histogram {
        let mut picture = Histogram::default();
        picture.add([0, 0], [1, 1], [value; 3]);
        picture
    }

    fn flashes(rate: f64, levels: &[u8], guarded: bool) -> (usize, Vec<f32>) {
        let (mut guard, mut count) = (FlashGuard::default(), FlashCount::default());
        let mut luminances = Vec::new();
        for (i, &level) in levels.iter().enumerate() {
            let (time_secs, picture) = (i as f64 / rate, flat(level));
            let veil = if guarded { guard.veil(time_secs, &picture) } else { Veil::Clear };
            count.note(time_secs, &picture, veil);
            luminances.push(picture.luminance(veil));
        }
        (count.most_per_second(), luminances)
    }

    #[test]
    fn veils_mix_as_a_window_does() {
        assert_eq!([Veil::Black(255), Veil::White(255), Veil::Clear].map(|veil| veil.over(77)), [0, 255, 77]);
        assert_eq!((Veil::Black(51).over(200), Veil::White(51).over(200)), (160, 211));
        assert!((flat(255).luminance(Veil::Black(0)) - 1.0).abs() < 1e-6);
        assert_eq!(Histogram::default().luminance(Veil::Clear), 0.0);
    }

    #[test]
    fn black_and_white_in_turn_are_tamed_and_what_is_slow_stays_clear() {
        let strobe: Vec<u8> = (0..180).map(|i| if i / 3 % 2 == 0 { 255 } else { 0 }).collect();
        assert!(flashes(30.0, &strobe, false).0 >= 4);
        assert!((1..=3).contains(&flashes(30.0, &strobe, true).0));
        let slow: Vec<u8> = (0..300).map(|i| (127.0 + 60.0 * (f64::from(i) * 0.05).sin()) as u8).collect();
        assert_eq!(flashes(30.0, &slow, true).1, flashes(30.0, &slow, false).1);
    }

    #[test]
    fn panels_may_come_and_go_five_times_a_second() {
        let mut guard = FlashGuard::default();
        let done = (0..40).filter(|i| guard.may_step(0.1 * f64::from(*i))).count();
        assert!((15..=20).contains(&done), "{done} of 40 in four seconds");
    }

    proptest! {
        #[test]
        fn no_row_of_pictures_flashes_more_than_three_times_a_second(
            levels in prop::collection::vec(any::<u8>(), 1..300), rate in 10.0f64..240.0)
        {
            prop_assert!(flashes(rate, &levels, true).0 <= crate::MAX_FLASHES);
        }
    }
}
