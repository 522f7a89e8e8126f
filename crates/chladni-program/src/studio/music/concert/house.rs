//! Black and stillness on stage, by hand.

/// Light goes and comes back within this time.
const FADE_SECS: f64 = 0.6;
/// The least time between two changes: no more than three flashes a second, however fast a hand is.
const LEAST_SECS: f64 = 0.7;

/// Whether the stage is black, and whether its picture stands still.
#[derive(Debug, Default)]
pub struct House {
    black: bool,
    /// The state that it fades to: it follows `black` with a delay, since a hand may be faster than the fade.
    falls: bool,
    changed_secs: f64,
    /// How black it was then, and is now.
    from: f32,
    level: f32,
    /// The picture that is shown stays.
    pub frozen: bool,
}

impl House {
    /// Black, or back.
    pub fn toggle_black(&mut self) {
        self.black = !self.black;
    }

    /// Whether it is black, or will be.
    pub fn is_black(&self) -> bool {
        self.black
    }

    /// How light it was when last looked at, in [0, 1].
    pub fn light(&self) -> f32 {
        1.0 - self.level
    }

    /// Light again at once, for a stage that is left.
    pub fn open(&mut self) {
        *self = Self::default();
    }

    /// How black it is, of 255, and whether that changes.
    pub fn opacity(&mut self, now_secs: f64) -> (u8, bool) {
        let (level, changes) = self.level(now_secs);
        ((255.0 * level).round() as u8, changes)
    }

    /// How black it is, in [0, 1], and whether that changes.
    fn level(&mut self, now_secs: f64) -> (f32, bool) {
        if self.black != self.falls && now_secs - self.changed_secs >= LEAST_SECS {
            (self.falls, self.from, self.changed_secs) = (self.black, self.level, now_secs);
        }
        let gone = ((now_secs - self.changed_secs) / FADE_SECS).clamp(0.0, 1.0) as f32;
        let to = f32::from(u8::from(self.falls));
        self.level = self.from + gone * (to - self.from);
        (self.level, gone < 1.0 || self.black != self.falls)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::{FlashCount, FlashGuard, Histogram, MAX_FLASHES, Veil, most_flashes_per_second};

    #[test]
    fn it_goes_black_and_comes_back() {
        let mut house = House::default();
        assert_eq!(house.level(10.0), (0.0, false));
        house.toggle_black();
        assert!(house.level(10.1).1);
        assert_eq!(house.level(11.0), (1.0, false));
        house.toggle_black();
        assert!(house.is_black() != house.level(11.1).1);
        assert_eq!(house.level(12.0), (0.0, false));
    }

    #[test]
    fn a_fast_hand_makes_no_flashes() {
        for every in 1..40 {
            let mut house = House::default();
            let (mut times_secs, mut light) = (Vec::new(), Vec::new());
            for frame in 0..600 {
                if frame % every == 0 {
                    house.toggle_black();
                }
                let now_secs = 10.0 + f64::from(frame) / 60.0;
                times_secs.push(now_secs);
                light.push(1.0 - house.level(now_secs).0);
            }
            assert!(most_flashes_per_second(&times_secs, &light) <= MAX_FLASHES, "every {every}");
        }
    }

    /// Flashes in the worst second of a picture whose halves strobe in turn or together, `hz` times a second, where a hand
    /// wants black or light again `every` so many of 60 frames a second.
    fn flashes_beside_a_strobe(hz: f64, in_turn: bool, every: u32) -> usize {
        let (mut guard, mut count, mut house) =
            (FlashGuard::default(), FlashCount::default(), House::default());
        let mut picture = Histogram::default();
        for frame in 0..300 {
            if frame % every == 0 {
                house.toggle_black();
            }
            let now_secs = 10.0 + f64::from(frame) / 60.0;
            let is_on = (now_secs * hz + 1e-9).fract() < 0.5;
            picture.clear();
            for (x, y) in (0..48).flat_map(|x| (0..32).map(move |y| (x, y))) {
                let is_light = is_on != (in_turn && x < 24);
                picture.add([x, y], [48, 32], [if is_light { 255 } else { 0 }; 3]);
            }
            let (dark, _) = house.opacity(now_secs);
            let veil = guard.veil_over_dark(now_secs, &picture, dark);
            count.note(now_secs, &picture, veil);
            let is_dark = matches!(veil, Veil::Black(opacity) if opacity >= dark);
            assert!(is_dark || dark == 0, "{veil:?} is lighter than {dark}");
        }
        count.most_per_second()
    }

    #[test]
    fn black_by_hand_adds_no_flashes_to_those_of_a_strobe() {
        for (hz, every) in [(4.0, 12), (5.0, 26), (6.0, 24)] {
            for in_turn in [false, true] {
                let flashes = flashes_beside_a_strobe(hz, in_turn, every);
                assert!((1..=MAX_FLASHES).contains(&flashes), "{hz} Hz, {every}, {in_turn}: {flashes}");
            }
        }
    }
}
