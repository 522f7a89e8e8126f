//! The viewpoint of the dance, by hand or by the camera's own choice.

use chladni_mesh::Orientation;
use chladni_music::{Framing, Viewpoint, smooth};
use chladni_view::Camera;
use egui::Ui;

use crate::studio::keys;
use crate::studio::viewport;

/// A camera at a viewpoint, for a picture whose size is not known yet.
pub fn camera_at(viewpoint: &Viewpoint, stands: Orientation) -> Camera {
    let Viewpoint { yaw_rad, pitch_rad, .. } = *viewpoint;
    let camera = Camera { yaw_rad, pitch_rad, stands, ..Camera::default() };
    let mut camera = Camera { distance: viewpoint.distance * camera.distance, ..camera };
    camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
    camera
}

/// Moves the viewer by pointer and keys on `response`, given how many cells high it is.
pub fn navigate(ui: &Ui, response: &egui::Response, viewpoint: &mut Viewpoint, cells_high: f32) {
    // A viewpoint is relative to how the shape stands: any stance gives the same.
    let before = camera_at(viewpoint, Orientation::Y_UP);
    let mut camera = before;
    if viewport::navigate(ui, response, &mut camera) {
        *viewpoint = moved(viewpoint, &before, &camera, cells_high);
    }
    let asks = response.hovered() || response.has_focus();
    if asks && keys::view::FIT.pressed(ui.ctx()) {
        *viewpoint = Viewpoint { distance: 1.0, shift: [0.0; 2], ..*viewpoint };
    }
}

/// The picture is shifted at most so far, in heights of a cell: coming nearer, which widens a shift, leads to no viewpoint
/// that a show file may not have.
const MOST_SHIFT: f32 = 100.0;

/// The viewpoint after the camera has moved from `before`.
fn moved(viewpoint: &Viewpoint, before: &Camera, camera: &Camera, cells_high: f32) -> Viewpoint {
    let shift = camera.shift_since(before.target);
    // It comes nearer to the middle of the picture, not to that of the shape.
    let nearer = before.distance / camera.distance;
    let shifted = |i: usize| nearer * viewpoint.shift[i] + cells_high * shift[i];
    Viewpoint {
        yaw_rad: camera.yaw_rad,
        pitch_rad: camera.pitch_rad,
        distance: camera.distance / Camera::default().distance,
        shift: std::array::from_fn(|i| shifted(i).clamp(-MOST_SHIFT, MOST_SHIFT)),
    }
}

/// Whether a hand is at pointer, wheel or keys in this frame.
pub fn touches(ui: &Ui) -> bool {
    ui.input(|input| {
        let is_hand = |event: &egui::Event| {
            use egui::Event;
            matches!(
                event,
                Event::MouseWheel { .. } | Event::Zoom(_) | Event::Key { .. } | Event::Touch { .. }
            )
        };
        input.pointer.any_down()
            || input.keys_down.iter().next().is_some()
            || input.events.iter().any(is_hand)
    })
}

/// A camera that was taken by hand chooses its shots again after this time.
const LET_GO_SECS: f64 = 6.0;
/// It glides back in this time.
const RETURN_SECS: f64 = 2.5;

/// A hand on the camera that else chooses its own shots.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hand {
    /// The framing that was shown last.
    shown: Framing,
    hold: Option<Hold>,
}

#[derive(Clone, Copy, Debug)]
struct Hold {
    /// When the hand last moved it.
    at_secs: f64,
    /// Where the viewer stood before, and where the hand has brought him.
    home: Viewpoint,
    left: Viewpoint,
    /// The shot that the hand has stopped.
    framing: Framing,
}

impl Hand {
    /// The framing to be shown where the camera has chosen `framing`, and `viewpoint` was `before`. If a hand that
    /// `touches` has moved the viewpoint, it returns once the hand has let go. Movement that is left in the wheel
    /// after that, or from before the stage was taken, does not count as a hand.
    pub fn over(
        &mut self,
        now_secs: f64,
        (before, touches): (Viewpoint, bool),
        viewpoint: &mut Viewpoint,
        framing: Framing,
    ) -> Framing {
        if *viewpoint != before && !touches {
            if let Some(hold) = &mut self.hold {
                hold.left = *viewpoint;
            }
        } else if *viewpoint != before {
            let home = self.hold.map_or(before, |hold| hold.home);
            let stopped = self.hold.map_or(self.shown, |hold| hold.framing);
            // A hand that takes hold while the camera returns begins where it has come to.
            let framing = if self.is_returning(now_secs) { self.shown } else { stopped };
            self.hold = Some(Hold { at_secs: now_secs, home, left: *viewpoint, framing });
        }
        self.shown = match self.hold {
            None => framing,
            Some(hold) => {
                let x = ((now_secs - hold.at_secs - LET_GO_SECS) / RETURN_SECS).clamp(0.0, 1.0) as f32;
                let share = smooth(x);
                *viewpoint = between(hold.left, hold.home, share);
                if x >= 1.0 {
                    self.hold = None;
                }
                hold.framing.toward(framing, share)
            }
        };
        self.shown
    }

    /// The camera no longer chooses here: whatever the hand has moved is where it was before.
    pub fn let_go(&mut self, viewpoint: &mut Viewpoint) {
        if let Some(hold) = self.hold.take() {
            *viewpoint = hold.home;
        }
    }

    /// The camera no longer chooses on stage: the view stays as the hand has moved it.
    pub fn keep(&mut self) {
        self.hold = None;
    }

    /// Where the viewer stands once the hand has given the view back, which is at `viewpoint` now.
    pub fn home(&self, viewpoint: Viewpoint) -> Viewpoint {
        self.hold.map_or(viewpoint, |hold| hold.home)
    }

    fn is_returning(&self, now_secs: f64) -> bool {
        self.hold.is_some_and(|hold| now_secs - hold.at_secs > LET_GO_SECS)
    }
}

fn between(from: Viewpoint, to: Viewpoint, share: f32) -> Viewpoint {
    use std::f32::consts::{PI, TAU};
    let mix = |from: f32, to: f32| from + share * (to - from);
    // The shorter way round.
    let turn_rad = (to.yaw_rad - from.yaw_rad + PI).rem_euclid(TAU) - PI;
    Viewpoint {
        yaw_rad: if share < 1.0 { from.yaw_rad + share * turn_rad } else { to.yaw_rad },
        pitch_rad: mix(from.pitch_rad, to.pitch_rad),
        distance: mix(from.distance.ln(), to.distance.ln()).exp(),
        shift: std::array::from_fn(|i| mix(from.shift[i], to.shift[i])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_that_widens_as_the_viewer_comes_nearer_stays_within_bounds() {
        let far = Viewpoint { distance: 20.0, shift: [0.6, -0.6], ..Viewpoint::default() };
        let before = camera_at(&far, Orientation::Y_UP);
        let mut camera = before;
        camera.zoom(1000.0);
        assert_eq!(moved(&far, &before, &camera, 1.0).shift, [MOST_SHIFT, -MOST_SHIFT]);
    }

    #[test]
    fn a_hand_that_left_the_stage_moves_nothing_later() {
        let (home, mut hand) = (Viewpoint::default(), Hand::default());
        let mut viewpoint = Viewpoint { yaw_rad: 1.0, ..home };
        hand.over(2.0, (home, true), &mut viewpoint, Framing::default());
        // What a show keeps.
        assert_eq!((viewpoint.yaw_rad, hand.home(viewpoint)), (1.0, home));
        hand.let_go(&mut viewpoint);
        assert_eq!(viewpoint, home);
        // Of the gallery.
        let mut turned = Viewpoint { yaw_rad: 0.5, ..home };
        hand.let_go(&mut turned);
        hand.over(4.0, (turned, false), &mut turned.clone(), Framing::default());
        let mut staged = turned;
        hand.over(20.0, (turned, false), &mut staged, Framing::default());
        assert_eq!(staged, turned);
    }

    #[test]
    fn a_hand_stops_the_camera_and_it_comes_back_without_a_jump() {
        let (mut hand, mut viewpoint) = (Hand::default(), Viewpoint::default());
        let chosen = |secs: f64| Framing { yaw_rad: 0.1 * secs as f32, ..Framing::default() };
        let (mut last, mut steps) = (None, 0.0f32);
        for i in 0..1200 {
            let secs = f64::from(i) / 60.0;
            let before = viewpoint;
            if (2.0..3.0).contains(&secs) {
                viewpoint.yaw_rad -= 0.02;
            }
            let framing = hand.over(secs, (before, true), &mut viewpoint, chosen(secs));
            let yaw_rad = viewpoint.yaw_rad + framing.yaw_rad;
            if let Some(last) = last.replace(yaw_rad) {
                steps = steps.max((yaw_rad - last).abs());
            }
            if (3.1..8.0).contains(&secs) {
                assert_eq!(framing.yaw_rad, chosen(2.0 - 1.0 / 60.0).yaw_rad, "{secs}");
            }
        }
        assert!(steps < 0.05, "{steps}");
        assert_eq!(viewpoint, Viewpoint::default());
        let framing = hand.over(20.0, (viewpoint, false), &mut viewpoint.clone(), chosen(20.0));
        assert_eq!(framing, chosen(20.0));
        // A wheel runs out.
        let mut nearer = Viewpoint { distance: 0.9, ..viewpoint };
        let framing = hand.over(20.1, (viewpoint, false), &mut nearer, chosen(20.1));
        assert_eq!((framing, nearer.distance), (chosen(20.1), 0.9));
    }
}
