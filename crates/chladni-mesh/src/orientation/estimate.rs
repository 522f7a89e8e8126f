//! The most likely orientation, judged from the surface: candidates come from the mirror plane, the file's
//! axes, the bases and the likeness to a head.

use std::f64::consts::{PI, TAU};

use chladni_task::{Cancelled, Task};

use super::cloud::Cloud;
use super::evidence::{base, detail, is_shallow, opening, rotated, weight};
use super::likeness::{Likeness, likenesses};
use super::{Axis, Orientation};
use crate::surface::vec3::{Vec3, cross, dot, length, scaled, sub, unit};
use crate::{MirrorPlane, MirrorSearch, TriMesh, weld};

/// The strongest evidence for an orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// It was given.
    Told,
    /// It looks like a human head.
    Head,
    /// It stands firmly.
    Base,
    /// It is open below or behind.
    Opening,
    /// Its details lie in front.
    Detail,
    /// Only that files are usually so.
    Custom,
}

impl Evidence {
    /// In words that follow "because".
    pub fn words(self) -> &'static str {
        match self {
            Self::Told => "you said so",
            Self::Head => "it looks like a head",
            Self::Base => "it stands firmly so",
            Self::Opening => "of where it is open",
            Self::Detail => "of where its details are",
            Self::Custom => "files usually are so",
        }
    }
}

/// The part of an orientation that is known before the surface is examined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Where up is.
    pub up: Option<[f64; 3]>,
    /// Where the front is.
    pub front: Option<[f64; 3]>,
    /// Where it should be by the rules of the file's format: it counts, and is taken where the surface leaves it in doubt.
    pub usual_front: Option<[f64; 3]>,
}

impl From<Orientation> for Known {
    fn from(stands: Orientation) -> Self {
        Self { up: Some(stands.up()), front: Some(stands.front()), usual_front: None }
    }
}

/// How a shape most probably stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Up and front.
    pub orientation: Orientation,
    /// Another one is nearly as probable: a person should look.
    pub in_doubt: bool,
    /// The strongest evidence for it.
    pub evidence: Evidence,
    /// The plane in which the shape comes closest to its mirror image.
    pub mirror: Option<MirrorPlane>,
}

/// Points by which a surface is judged.
const POINTS: usize = 6000;
/// A plane with a larger misfit, as a share of the diagonal, is not a mirror plane.
const NO_MIRROR: f64 = 0.02;
/// Directions nearer than this are taken for the same.
const SAME_RAD: f64 = 22.0 * PI / 180.0;
/// A direction so near to an axis of the file is that axis.
const SNAP_RAD: f64 = 10.0 * PI / 180.0;
/// Misfits up to which a likeness counts fully, and from which it does not count.
const LIKE: (f64, f64) = (0.038, 0.043);
/// A candidate whose misfit is larger by this much no longer counts as head-like.
const LESS_LIKE: f64 = 0.006;
/// The weight of a file format's rules: more than details that differ a little between two sides.
const USUAL: f64 = 1.0;
/// Below this lead over another orientation a person should look.
const CLEAR_LEAD: f64 = 0.5;

/// The evidence for a candidate, in units that can be added; in the order of [`KINDS`].
type Votes = [f64; 5];
const CUSTOM: usize = 4;
const KINDS: [Evidence; 5] =
    [Evidence::Head, Evidence::Base, Evidence::Opening, Evidence::Detail, Evidence::Custom];

impl Estimate {
    /// How `mesh` stands, within what is `known`. A mesh without a surface stands as most files do.
    ///
    /// # Errors
    /// [`Cancelled`] through `task`.
    pub fn of(mesh: &TriMesh, known: Known, task: &Task) -> Result<Self, Cancelled> {
        let welded = weld(mesh);
        Self::of_surface(&welded.positions, &welded.triangles, known, task)
    }

    /// As [`of`](Self::of), of welded positions that are all used by triangles.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn of_surface(
        positions: &[[f64; 3]],
        triangles: &[[u32; 3]],
        known: Known,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        if let (Some(up), Some(front)) = (known.up, known.front)
            && let Some(orientation) = Orientation::new(up, front)
        {
            return Ok(Self { orientation, in_doubt: false, evidence: Evidence::Told, mirror: None });
        }
        let mirror = match MirrorSearch::of(positions, triangles) {
            Some(search) => search.best(&[], task)?,
            None => None,
        };
        task.check()?;
        let Some(cloud) = Cloud::of(positions, triangles, POINTS) else {
            let orientation = by_custom(known);
            return Ok(Self { orientation, in_doubt: true, evidence: Evidence::Custom, mirror });
        };
        let witness = Witness::of(&cloud, mirror.filter(|plane| plane.misfit < NO_MIRROR));
        task.check()?;
        let mut judged: Vec<(f64, Votes, Orientation)> = witness
            .candidates(known)
            .into_iter()
            .map(|candidate| {
                let mut votes = witness.votes(&candidate);
                let usual = known.usual_front.and_then(|front| Orientation::new(candidate.up(), front));
                if usual.is_some_and(|usual| candidate.angle_to(&usual) < SAME_RAD) {
                    votes[CUSTOM] += USUAL;
                }
                (votes.iter().sum(), votes, candidate)
            })
            .collect();
        judged.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some(&(best, votes, orientation)) = judged.first() else {
            let orientation = by_custom(known);
            return Ok(Self { orientation, in_doubt: true, evidence: Evidence::Custom, mirror });
        };
        let rival = judged.iter().find(|(_, _, other)| orientation.angle_to(other) > 2.0 * SAME_RAD);
        let lead = rival.map_or(f64::INFINITY, |(sum, _, _)| best - sum);
        // The evidence that distinguishes it from its rival, without the evidence that they share.
        let apart = |i: usize| votes[i] - rival.map_or(0.0, |(_, votes, _)| votes[i]);
        let strongest = (0..votes.len()).max_by(|i, j| apart(*i).total_cmp(&apart(*j))).unwrap_or(CUSTOM);
        let in_doubt = lead < CLEAR_LEAD;
        let usual = known.usual_front.and_then(|front| Orientation::new(orientation.up(), front));
        match usual.filter(|usual| in_doubt && agrees(usual, known)) {
            Some(usual) => Ok(Self { orientation: usual, in_doubt, evidence: Evidence::Custom, mirror }),
            None => Ok(Self { orientation, in_doubt, evidence: KINDS[strongest], mirror }),
        }
    }
}

/// When nothing can be determined.
fn by_custom(known: Known) -> Orientation {
    let all = frames(&Axis::ALL.map(Axis::direction)).into_iter().filter(|frame| agrees(frame, known));
    let like = all.max_by(|a, b| custom(a).total_cmp(&custom(b)));
    like.unwrap_or_default()
}

/// A surface under examination.
struct Witness<'a> {
    cloud: &'a Cloud,
    /// Normal of its mirror plane, where it has one.
    side: Option<Vec3>,
    heads: Vec<Likeness>,
    /// Outward, and the share of the outline.
    opening: Option<(Vec3, f64)>,
    shallow: bool,
    roughness: Vec<f64>,
}

impl<'a> Witness<'a> {
    fn of(cloud: &'a Cloud, mirror: Option<MirrorPlane>) -> Self {
        let side = mirror.map(|plane| snapped(plane.normal));
        // The cloud is centered, and a mirror keeps the center.
        let heads = side.map_or_else(Vec::new, |side| likenesses(cloud, side, 0.0));
        let opening = opening(cloud);
        Self {
            cloud,
            side,
            heads,
            opening,
            shallow: opening.is_some_and(|(direction, _)| is_shallow(cloud, direction)),
            roughness: cloud.roughness(0.03),
        }
    }

    /// The orientations to choose between.
    fn candidates(&self, known: Known) -> Vec<Orientation> {
        let axes = Axis::ALL.map(Axis::direction);
        let mut ups: Vec<Vec3> = Vec::new();
        let Some(side) = self.side else {
            let mut ups = axes.to_vec();
            ups.extend(known.up.map(unit));
            ups.extend(known.front.map(unit));
            return frames(&ups).into_iter().filter(|frame| agrees(frame, known)).collect();
        };
        let level = |v: Vec3| unit(sub(v, scaled(side, dot(v, side))));
        let lies_in = |v: &Vec3| dot(*v, side).abs() < SNAP_RAD.sin();
        // Up must be perpendicular to a known front, and the other way round.
        let given = known.up.or(known.front.map(|front| cross(side, unit(front)))).map(level);
        if let Some(given) = given.filter(|given| length(*given) > 0.5) {
            ups.extend([given, scaled(given, -1.0)]);
        } else if axes.iter().any(lies_in) {
            for axis in axes.into_iter().filter(lies_in) {
                ups.extend([level(axis), cross(side, level(axis)), scaled(cross(side, level(axis)), -1.0)]);
            }
        } else {
            ups.extend(self.firmest(side));
        }
        // A shape need not be aligned with its file's axes.
        let near = |v: Vec3, ups: &[Vec3]| ups.iter().any(|up| angle(*up, v) < SAME_RAD);
        if given.is_none() {
            for head in self.heads.iter().filter(|head| head.misfit < LIKE.0).take(3) {
                if !near(head.up, &ups) {
                    ups.push(head.up);
                }
            }
        }
        let mut candidates: Vec<Orientation> = Vec::new();
        for up in ups {
            for front in [cross(side, up), cross(up, side)] {
                let new = Orientation::new(up, front).filter(|new| agrees(new, known));
                candidates.extend(new.filter(|new| candidates.iter().all(|c| c.angle_to(new) > 0.01)));
            }
        }
        if candidates.is_empty() {
            // The known axes do not fit the mirror plane.
            let mut all = axes.to_vec();
            all.extend(known.up.map(unit));
            all.extend(known.front.map(unit));
            candidates = frames(&all).into_iter().filter(|frame| agrees(frame, known)).collect();
        }
        candidates
    }

    /// Directions of the mirror plane in which it stands most firmly, as up.
    fn firmest(&self, side: Vec3) -> Vec<Vec3> {
        const STEPS: usize = 120;
        let (start, _) = super::evidence::across(side);
        let up = |i: usize| rotated(start, side, TAU * i as f64 / STEPS as f64);
        let firm: Vec<f64> = (0..STEPS).map(|i| base(self.cloud, scaled(up(i), -1.0)).firmness()).collect();
        let is_peak = |i: &usize| {
            (1..=4).all(|d| firm[*i] >= firm[(i + d) % STEPS] && firm[*i] >= firm[(i + STEPS - d) % STEPS])
        };
        let mut peaks: Vec<usize> = (0..STEPS).filter(|i| firm[*i] > 0.0).filter(is_peak).collect();
        peaks.sort_by(|i, j| firm[*j].total_cmp(&firm[*i]));
        peaks.truncate(6);
        let mut ups: Vec<Vec3> = peaks.into_iter().map(up).collect();
        ups.extend(self.opening.map(|(direction, _)| scaled(direction, -1.0)));
        ups.extend(self.heads.iter().take(4).map(|head| head.up));
        if ups.is_empty() {
            ups.extend((0..8).map(|i| up(i * STEPS / 8)));
        }
        ups
    }

    fn votes(&self, candidate: &Orientation) -> Votes {
        let (up, front) = (candidate.up(), candidate.front());
        let (towards_front, _) = detail(self.cloud, &self.roughness, up, front);
        let carried = 2.0 * weight(self.cloud, up, front).clamp(-0.2, 0.2);
        let head = self.head(candidate);
        [head, self.base(candidate), self.open(candidate), 6.0 * towards_front + carried, custom(candidate)]
    }

    fn head(&self, candidate: &Orientation) -> f64 {
        let Some(best) = self.heads.first() else { return 0.0 };
        let counts = ((LIKE.1 - best.misfit) / (LIKE.1 - LIKE.0)).clamp(0.0, 1.0);
        let alike = |head: &Likeness| {
            Orientation::new(head.up, head.front)
                .filter(|pose| pose.angle_to(candidate) < 1.5 * SAME_RAD)
                .map(|_| (1.0 - (head.misfit - best.misfit) / LESS_LIKE).max(0.0))
        };
        4.0 * counts * self.heads.iter().filter_map(alike).fold(0.0, f64::max)
    }

    /// How firmly it stands, tilted a little if needed.
    fn base(&self, candidate: &Orientation) -> f64 {
        let tilts = match self.side {
            Some(side) => vec![side],
            None => vec![candidate.right(), candidate.front()],
        };
        let mut firmest = 0.0_f64;
        for axis in tilts {
            for step in -5..=5 {
                let down = rotated(scaled(candidate.up(), -1.0), axis, f64::from(step) * SAME_RAD / 5.0);
                firmest = firmest.max(base(self.cloud, down).firmness());
            }
        }
        // An open shape was cut off somewhere and may seem to stand on any flat side.
        4.0 * firmest * if self.opening.is_some() { 0.3 } else { 1.0 }
    }

    /// A neck is open below, a mask behind, a trophy's neck in between; nothing is open in front or above.
    fn open(&self, candidate: &Orientation) -> f64 {
        let Some((direction, share)) = self.opening else { return 0.0 };
        let (down, behind) = (-dot(direction, candidate.up()), -dot(direction, candidate.front()));
        let weigh = |along: f64, good: f64| if along > 0.0 { good * along } else { along };
        let found = if self.shallow { behind } else { weigh(down, 1.0) + weigh(behind, 0.8) };
        2.0 * (share / 0.3).min(1.0) * found
    }
}

/// Which orientations files are in, where nothing else is known.
fn custom(candidate: &Orientation) -> f64 {
    let is = |direction: Vec3, axis: Vec3| angle(direction, axis) < 0.02;
    let up = match candidate.up() {
        up if is(up, Orientation::Y_UP.up()) => 0.6,
        up if is(up, Orientation::Z_UP.up()) => 0.4,
        _ => 0.0,
    };
    let usual = [Orientation::Y_UP, Orientation::Z_UP];
    let front =
        usual.iter().any(|usual| is(candidate.up(), usual.up()) && is(candidate.front(), usual.front()));
    up + if front { 0.25 } else { 0.0 }
}

fn agrees(candidate: &Orientation, known: Known) -> bool {
    let near = |known: Option<Vec3>, found: Vec3| known.is_none_or(|known| angle(known, found) < 0.02);
    near(known.up, candidate.up()) && near(known.front, candidate.front())
}

/// All pairs of perpendicular directions as up and front.
fn frames(directions: &[Vec3]) -> Vec<Orientation> {
    let pairs = directions.iter().flat_map(|up| directions.iter().map(move |front| (*up, *front)));
    let upright = pairs.filter(|(up, front)| dot(*up, *front).abs() < 0.02);
    upright.filter_map(|(up, front)| Orientation::new(up, front)).collect()
}

fn angle(a: Vec3, b: Vec3) -> f64 {
    length(cross(unit(a), unit(b))).atan2(dot(a, b))
}

/// `direction`, or the axis of the file that it nearly follows.
fn snapped(direction: Vec3) -> Vec3 {
    let axes = Axis::ALL.map(Axis::direction).into_iter();
    axes.min_by(|a, b| angle(*a, direction).total_cmp(&angle(*b, direction)))
        .filter(|axis| angle(*axis, direction) < SNAP_RAD)
        .unwrap_or(direction)
}
