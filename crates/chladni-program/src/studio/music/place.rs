//! The screen that the stage fills, also when it is taken away and comes back.

use super::preferences::Screen;

/// A change of the window that holds the stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// It fills the screen with this index.
    Fill(usize),
    /// It fills none any more.
    Leave,
    /// The screen is not there: the window leaves full screen where it filled one.
    Missing { filled: bool, name: String },
}

impl Change {
    /// Message for the user.
    pub fn warning(&self) -> Option<String> {
        let Self::Missing { name, .. } = self else { return None };
        Some(format!("{name} is not connected: the stage stays in its window until it is."))
    }
}

/// Where the stage is.
#[derive(Debug, Default)]
pub struct Place {
    /// The screen that it fills.
    fills: Option<String>,
    /// The screen that is missing.
    missing: Option<String>,
}

impl Place {
    /// Follows the wanted screen, and the screens that there are now, in the system's order.
    pub fn follow(&mut self, wanted: &Screen, names: &[String]) -> Option<Change> {
        let Some(name) = wanted.name() else {
            self.missing = None;
            let filled = self.fills.take().is_some();
            return (filled && *wanted == Screen::Window).then_some(Change::Leave);
        };
        if let Some(index) = wanted.index(names) {
            self.missing = None;
            let is_new = self.fills.as_ref() != Some(&name);
            self.fills = Some(name);
            return is_new.then_some(Change::Fill(index));
        }
        let filled = self.fills.take().is_some();
        let is_new = self.missing.as_ref() != Some(&name);
        self.missing = Some(name.clone());
        is_new.then_some(Change::Missing { filled, name })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_screen_that_goes_is_said_once_and_filled_again_when_it_is_back() {
        let both: Vec<String> = ["eDP-1", "HDMI-1"].map(String::from).into();
        let (wanted, mut place) = (Screen::Named("HDMI-1".into()), Place::default());
        assert_eq!(place.follow(&wanted, &both), Some(Change::Fill(1)));
        assert_eq!(place.follow(&wanted, &both), None);
        // Others may change their order.
        assert_eq!(place.follow(&wanted, &both[1..]), None);
        let missing = Change::Missing { filled: true, name: "HDMI-1".into() };
        assert_eq!(place.follow(&wanted, &both[..1]), Some(missing));
        assert_eq!(place.follow(&wanted, &[]), None);
        assert_eq!(place.follow(&wanted, &both[1..]), Some(Change::Fill(0)));
        assert_eq!(place.follow(&Screen::Named("eDP-1".into()), &both), Some(Change::Fill(0)));
    }

    #[test]
    fn a_plain_window_leaves_the_screen_and_the_screen_is_filled_anew() {
        let names = ["eDP-1", "HDMI-1"].map(String::from);
        let named = Screen::Named("HDMI-1".into());
        for (between, leaves) in [(Screen::Window, Some(Change::Leave)), (Screen::Full, None)] {
            let mut place = Place::default();
            assert_eq!(place.follow(&named, &names), Some(Change::Fill(1)));
            assert_eq!(place.follow(&between, &names), leaves);
            assert_eq!(place.follow(&between, &names), None);
            assert_eq!(place.follow(&named, &names), Some(Change::Fill(1)));
        }
    }

    #[test]
    fn a_number_of_older_preferences_is_a_screen_too() {
        let names = vec!["eDP-1".to_owned()];
        let mut place = Place::default();
        assert_eq!(place.follow(&Screen::Monitor(0), &names), Some(Change::Fill(0)));
        let missing = Change::Missing { filled: true, name: "Screen 3".into() };
        let change = place.follow(&Screen::Monitor(2), &names);
        assert_eq!(change, Some(missing));
        assert!(change.and_then(|change| change.warning()).is_some_and(|text| text.contains("Screen 3")));
        for screen in [Screen::Window, Screen::Full] {
            assert_eq!(Place::default().follow(&screen, &names), None);
        }
    }
}
