//! How the body stands, which can be corrected while it dances.

use std::sync::Arc;

use chladni_mesh::Orientation;

use super::Concert;
use crate::studio::standing::Standing;

impl Concert {
    /// How the body stands.
    pub fn standing(&self) -> Standing {
        self.standing
    }

    /// The body stands as `given` from now on, or as it was found where nothing is given. All goes on, seen from there;
    /// the half that is the viewer's left then hears the left channel.
    pub fn stand(&mut self, given: Option<Orientation>) {
        let (before, standing) = (self.standing.now(), Standing { given, ..self.standing });
        let stands = standing.now();
        if stands != before {
            let dancer = Arc::new(self.ensemble.dancer().standing(self.harmonics.body(), &stands));
            self.ensemble.give_to(Arc::clone(&dancer));
            self.apart.iter_mut().for_each(|apart| apart.give_to(Arc::clone(&dancer)));
            self.staging.stand(dancer, stands);
        }
        self.standing = standing;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::{Action, Show};

    /// How far to the viewer's right the vertices of the left half lie, in the mean.
    fn left_half(concert: &Concert) -> f64 {
        let right = concert.standing().now().right();
        let across = |p: &[f64; 3]| (0..3).map(|i| right[i] * p[i]).sum::<f64>();
        let left = &concert.ensemble.dancer().sides.left;
        let points = &concert.harmonics.body().positions;
        let weighed: f64 = points.iter().zip(left.iter()).map(|(p, l)| f64::from(*l) * across(p)).sum();
        weighed / left.iter().map(|l| f64::from(*l)).sum::<f64>()
    }

    #[test]
    fn a_body_that_is_turned_round_is_seen_from_there_and_keeps_its_dances() {
        let mut concert = Concert::of_ball(32).unwrap();
        concert.act(Action::Favorite { item: 2, on: true }).unwrap();
        let show = Show::of(concert.instrument());
        assert!(left_half(&concert) < 0.0);
        let behind = Orientation::Y_UP.quarters(2);
        concert.stand(Some(behind));
        assert_eq!((concert.staging.stands(), concert.standing().given), (behind, Some(behind)));
        assert!(left_half(&concert) < 0.0);
        assert_eq!(concert.instrument().log(), show.actions);
        // Another body stands by itself, until a show says how.
        let mut other = Concert::of_ball(32).unwrap();
        other.go_on_from(&concert).unwrap();
        assert_eq!(other.staging.stands(), Orientation::Y_UP);
        other.replay(&Show { stands: Some(behind), ..show }).unwrap();
        assert_eq!(other.staging.stands(), behind);
        other.stand(None);
        assert_eq!(other.staging.stands(), Orientation::Y_UP);
    }
}
