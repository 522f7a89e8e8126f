//! From lines on the surface to strokes on paper: their visible parts, joined, smoothed and given a width.

use std::collections::HashMap;
use std::ops::Range;

use rayon::prelude::*;

use super::lines::{Line, LinePoint, between, smooth_step, way};
use super::sight::Sight;
use super::{Ink, Mark, Stroke, StrokePoint};

/// All lengths are in units of paper, a nine-hundredth of the cell's shorter side: between samples of a line,
const STEP: f64 = 2.0;
/// of gaps that are closed, outside and inside,
const GAP: [f64; 2] = [20.0, 6.0];
/// of the shortest strokes that are kept, outside and inside,
const SHORT: [f64; 2] = [12.0, 24.0];
/// between strokes' ends that are joined, outside and inside: where one leads into the other, and in any case,
const JOIN: [f64; 2] = [12.0, 7.0];
const MEET: [f64; 2] = [6.0, 2.0];
/// between two strokes that would show the same, outside and inside,
const SAME: [f64; 2] = [3.0, 5.0];
/// and over which a stroke's width falls off to its ends.
const TAPER: f64 = 26.0;
/// The cosine of the turn up to which ends are joined, outside and inside.
const TURN: [f64; 2] = [0.5, 0.8];
/// How often places are averaged with their neighbors'.
const SMOOTHINGS: usize = 6;
/// How far a simplified stroke lies from the traced one at most, in pixels.
const TOLERANCE_PX: f64 = 0.1;

/// A sample of a line.
#[derive(Clone, Copy)]
struct Sample {
    at: [f64; 2],
    on: LinePoint,
    seen: bool,
}

/// The strokes in which `lines` are seen.
pub(super) fn visible(sight: &Sight<'_>, ink: &Ink, lines: Vec<Line>) -> Vec<Stroke> {
    let runs: Vec<Vec<(Mark, Vec<Sample>)>> = lines
        .into_par_iter()
        .map(|line| {
            let samples = sampled(sight, &line);
            seen_runs(line.mark, samples, sight.unit).into_iter().map(|run| (line.mark, run)).collect()
        })
        .collect();
    // Contours of a scan are in crumbs before they are joined.
    let mut runs = joined(by_length(runs.into_iter().flatten().collect()), sight.unit);
    runs.retain(|(mark, run)| says(*mark, run, sight.unit));
    // Lines beside an earlier one are left out.
    let runs = without_doubles(by_length(runs), sight.unit);
    let runs = joined(runs, sight.unit);
    runs.into_iter().filter_map(|(mark, run)| stroke(sight, ink, mark, run)).collect()
}

/// Sorted as they are drawn: by mark, the longest first.
fn by_length(mut runs: Vec<(Mark, Vec<Sample>)>) -> Vec<(Mark, Vec<Sample>)> {
    runs.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.len().cmp(&a.1.len())));
    runs
}

/// Which of two values holds for a line, outside or inside.
fn inside(mark: Mark) -> usize {
    usize::from(mark != Mark::Contour)
}

/// Whether a run is long and strong enough.
fn says(mark: Mark, run: &[Sample], unit: f64) -> bool {
    let least = SHORT[inside(mark)] * unit;
    extent(run) >= least && run.iter().any(|s| s.seen && s.on.strength >= 1.0)
}

/// Places on the line, evenly spaced on paper; a line that goes behind the eye ends there.
fn sampled(sight: &Sight<'_>, line: &Line) -> Vec<Sample> {
    let sample = |on: LinePoint, at: [f64; 2]| {
        let inside = sight.cell.contains(at[0] as f32, at[1] as f32);
        Sample { at, on, seen: inside && (line.mark == Mark::Contour || sight.sees(on.at, on.normal)) }
    };
    let mut samples: Vec<Sample> = Vec::new();
    let Some(first) = line.points.first() else { return samples };
    samples.extend(sight.project(first.at).map(|at| sample(*first, at)));
    for pair in line.points.windows(2) {
        let (Some(a), Some(b)) = (sight.project(pair[0].at), sight.project(pair[1].at)) else { continue };
        let steps = (apart(a, b) / (STEP * sight.unit)).ceil().clamp(1.0, 1000.0) as u32;
        for i in 1..=steps {
            let on = between(&pair[0], &pair[1], f64::from(i) / f64::from(steps));
            let Some(at) = sight.project(on.at) else { continue };
            // Vertices much closer than a step would only be noise.
            if i < steps || samples.last().is_none_or(|last| apart(last.at, at) > 0.5 * STEP * sight.unit) {
                samples.push(sample(on, at));
            }
        }
    }
    if line.mark == Mark::Contour {
        let places: Vec<[f64; 2]> = samples.iter().map(|s| s.at).collect();
        let last = places.len().saturating_sub(1);
        for (i, Sample { at, on, .. }) in samples.iter_mut().enumerate().filter(|(_, s)| s.seen) {
            let along = way(places[i.saturating_sub(2)], places[(i + 2).min(last)]);
            let border = if on.strength > 0.0 && sight.sees(on.at, on.normal) { on.strength } else { 0.0 };
            on.strength = sight.step(on.at, *at, along).max(border);
        }
    }
    if line.points.len() > 3 && line.points.first().map(|p| p.at) == line.points.last().map(|p| p.at) {
        close(&mut samples, STEP * sight.unit);
    }
    samples
}

/// Lets a line that goes around end exactly where it begins, and begin where it is not seen, so that no visible piece
/// is cut in two.
fn close(samples: &mut Vec<Sample>, step: f64) {
    let Some(first) = samples.first().map(|s| s.at) else { return };
    while samples.len() > 1 && samples.last().is_some_and(|last| apart(last.at, first) < 0.5 * step) {
        samples.pop();
    }
    let hidden = samples.iter().position(|s| !s.seen || s.on.strength < 0.5);
    samples.rotate_left(hidden.unwrap_or(0));
    samples.extend(samples.first().copied());
}

/// The pieces of a line that are seen and strong enough, without short gaps; inside, without short bits.
fn seen_runs(mark: Mark, samples: Vec<Sample>, unit: f64) -> Vec<Vec<Sample>> {
    let drawn: Vec<bool> = samples.iter().map(|s| s.seen && s.on.strength >= 0.5).collect();
    let gap = GAP[inside(mark)] * unit;
    let mut pieces: Vec<Range<usize>> = Vec::new();
    for (_, piece) in ranges(&drawn).into_iter().filter(|(drawn, _)| *drawn) {
        match pieces.last_mut() {
            Some(last) if extent(&samples[last.end - 1..=piece.start]) < gap => last.end = piece.end,
            _ => pieces.push(piece),
        }
    }
    let kept = |run: &[Sample]| if mark == Mark::Contour { run.len() > 1 } else { says(mark, run, unit) };
    pieces.into_iter().map(|piece| samples[piece].to_vec()).filter(|run| kept(run)).collect()
}

fn apart([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (a - c).hypot(b - d)
}

fn extent(run: &[Sample]) -> f64 {
    run.windows(2).map(|pair| apart(pair[0].at, pair[1].at)).sum()
}

fn dot([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * c + b * d
}

/// Things on paper, by squares.
struct Squares<T> {
    side: f64,
    things: HashMap<[i64; 2], Vec<T>>,
}

impl<T> Squares<T> {
    fn new(side: f64) -> Self {
        Self { side, things: HashMap::new() }
    }

    fn square(&self, at: [f64; 2]) -> [i64; 2] {
        at.map(|x| (x / self.side).floor() as i64)
    }

    fn put(&mut self, at: [f64; 2], thing: T) {
        self.things.entry(self.square(at)).or_default().push(thing);
    }

    /// All that are nearer to `at` than a square's side, and some that are not.
    fn around(&self, at: [f64; 2]) -> impl Iterator<Item = &T> {
        let [x, y] = self.square(at);
        let squares = (x - 1..=x + 1).flat_map(move |x| (y - 1..=y + 1).map(move |y| [x, y]));
        squares.filter_map(move |square| self.things.get(&square)).flatten()
    }
}

/// Places of strokes and their directions there.
type Occupied = Squares<[[f64; 2]; 2]>;

impl Occupied {
    /// Whether another stroke passes in the same direction nearer than `near`, at most a square's side.
    fn has_like(&self, at: [f64; 2], along: [f64; 2], near: f64) -> bool {
        self.around(at)
            .any(|[place, direction]| apart(at, *place) < near && dot(along, *direction).abs() > 0.8)
    }
}

/// Leaves out where a line runs beside one that was drawn before, or beside itself.
fn without_doubles(runs: Vec<(Mark, Vec<Sample>)>, unit: f64) -> Vec<(Mark, Vec<Sample>)> {
    let mut occupied = Occupied::new(SAME[0].max(SAME[1]) * unit);
    let mut kept = Vec::with_capacity(runs.len());
    for (mark, run) in runs {
        let inside = inside(mark);
        let near = SAME[inside] * unit;
        let last = run.len() - 1;
        let along: Vec<[f64; 2]> =
            (0..=last).map(|i| way(run[i.saturating_sub(1)].at, run[(i + 1).min(last)].at)).collect();
        // Beyond this distance along itself, a line that comes near is no longer its own smooth continuation.
        let behind = (2.0 * near / (STEP * unit)).ceil() as usize + 1;
        let mut drawn = Vec::with_capacity(run.len());
        for i in 0..=last {
            drawn.push(!occupied.has_like(run[i].at, along[i], near));
            if let Some(past) = i.checked_sub(behind).filter(|past| drawn[*past]) {
                occupied.put(run[past].at, [run[past].at, along[past]]);
            }
        }
        for past in (run.len().saturating_sub(behind)..run.len()).filter(|past| drawn[*past]) {
            occupied.put(run[past].at, [run[past].at, along[past]]);
        }
        // A line that only meets or crosses another goes on, and no scraps are left.
        for (kind, least) in [(false, 3.0 * near), (true, SHORT[inside] * unit * 0.6)] {
            for piece in ranges(&drawn).into_iter().filter(|(like, _)| *like == kind).map(|(_, piece)| piece)
            {
                if extent(&run[piece.clone()]) < least && piece.len() < run.len() {
                    drawn[piece].fill(!kind);
                }
            }
        }
        let pieces = ranges(&drawn).into_iter().filter(|(like, _)| *like);
        kept.extend(pieces.map(|(_, piece)| (mark, run[piece].to_vec())));
    }
    kept
}

/// Runs of equal values.
fn ranges(values: &[bool]) -> Vec<(bool, Range<usize>)> {
    let mut from = 0;
    let range = |same: &[bool]| {
        let piece = from..from + same.len();
        from = piece.end;
        (same[0], piece)
    };
    values.chunk_by(|a, b| a == b).map(range).collect()
}

/// Joins pieces of the same kind whose ends meet and go on in the same direction, the longest first, the nearest to it.
fn joined(runs: Vec<(Mark, Vec<Sample>)>, unit: f64) -> Vec<(Mark, Vec<Sample>)> {
    // Noisy scans have thousands of pieces: only those with an end nearby are compared.
    let mut ends = Squares::new(JOIN[0].max(JOIN[1]) * unit);
    for (j, (_, run)) in runs.iter().enumerate() {
        for end in [run.first(), run.last()].into_iter().flatten() {
            ends.put(end.at, j);
        }
    }
    let mut left: Vec<Option<(Mark, Vec<Sample>)>> = runs.into_iter().map(Some).collect();
    let mut joined = Vec::new();
    for i in 0..left.len() {
        let Some((mark, mut own)) = left[i].take() else { continue };
        loop {
            let nearby = [own.first(), own.last()].into_iter().flatten().flat_map(|end| ends.around(end.at));
            let fits = nearby.filter_map(|&j| {
                let (_, other) = left[j].as_ref().filter(|(other, _)| *other == mark)?;
                fit(mark, &own, other, unit).map(|(gap, turns)| (j, gap, turns))
            });
            let next = fits.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let Some((j, _, [turn_own, turn_other])) = next else { break };
            let Some((_, mut other)) = left[j].take() else { break };
            if turn_own {
                own.reverse();
            }
            if turn_other {
                other.reverse();
            }
            own.append(&mut other);
        }
        let closes = |(gap, turns): (f64, [bool; 2])| gap > 0.0 && turns == [false, false];
        let around = own.len() > 12 && fit(mark, &own, &own, unit).is_some_and(closes);
        own.extend(own.first().copied().filter(|_| around));
        joined.push((mark, own));
    }
    joined
}

/// Whether, turned or not, the end of `a` leads into the beginning of `b`, and over how wide a gap.
fn fit(mark: Mark, a: &[Sample], b: &[Sample], unit: f64) -> Option<(f64, [bool; 2])> {
    const LOOK_BACK: usize = 4;
    let inside = inside(mark);
    // The place of an end, and one a little before it.
    let end = |run: &[Sample], last: bool| {
        let n = run.len() - 1;
        let back = LOOK_BACK.min(n);
        if last { (run[n].at, run[n - back].at) } else { (run[0].at, run[back].at) }
    };
    [[false, false], [false, true], [true, false], [true, true]].into_iter().find_map(|turns| {
        let ((p, before), (q, after)) = (end(a, !turns[0]), end(b, turns[1]));
        let gap = apart(p, q);
        if gap >= JOIN[inside] * unit {
            return None;
        }
        let (out, toward) = (way(before, p), way(after, q));
        let leads = gap < MEET[inside] * unit || dot(out, way(p, q)) > TURN[inside] - 0.1;
        (dot(out, toward) < -TURN[inside] && leads).then_some((gap, turns))
    })
}

/// A run as it is drawn: smoothed, wide where it is near and says much, thin at its ends.
fn stroke(sight: &Sight<'_>, ink: &Ink, mark: Mark, run: Vec<Sample>) -> Option<Stroke> {
    let n = run.len();
    let is_closed = n > 3 && apart(run[0].at, run[n - 1].at) < 1e-6;
    let mut places: Vec<[f64; 2]> = run.iter().map(|s| s.at).collect();
    for _ in 0..SMOOTHINGS {
        places = smoothed(&places, is_closed);
    }
    let mut strengths: Vec<[f64; 2]> = run.iter().map(|s| [s.on.strength.min(4.0), s.on.weight]).collect();
    for _ in 0..SMOOTHINGS {
        strengths = smoothed(&strengths, is_closed);
    }
    let lengths: Vec<f64> = std::iter::once(0.0)
        .chain(places.windows(2).scan(0.0, |sum, pair| {
            *sum += apart(pair[0], pair[1]);
            Some(*sum)
        }))
        .collect();
    // Smoothed, what went to and fro is short.
    let whole = lengths.last().copied().filter(|whole| *whole >= SHORT[0] * sight.unit)?;
    let taper = (TAPER * sight.unit).min(0.4 * whole);
    let pen = ink.pen_px(sight.cell);
    let share = match mark {
        Mark::Contour => 1.0,
        Mark::Suggestive => 0.85,
        Mark::Valley => 0.8,
        Mark::Ridge | Mark::Hatching => 0.5,
    };
    let points = (0..n).map(|i| {
        let [strength, weight] = strengths[i];
        let says =
            if mark == Mark::Contour { 1.0 } else { 0.35 + 0.65 * smooth_step((strength - 0.5) / 2.5) };
        let depth = 0.6 + 0.8 * sight.nearness(run[i].on.at);
        let end = lengths[i].min(whole - lengths[i]);
        let thin = if is_closed { 1.0 } else { 0.25 + 0.75 * smooth_step(end / taper.max(1e-9)) };
        StrokePoint { at: places[i], width: pen * share * says * depth * thin * weight }
    });
    Some(Stroke { mark, points: simplified(&points.collect::<Vec<_>>()) })
}

/// Averages each with its neighbors; ends stay.
fn smoothed(values: &[[f64; 2]], is_closed: bool) -> Vec<[f64; 2]> {
    let n = values.len();
    let mean = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        std::array::from_fn(|k| 0.25 * a[k] + 0.5 * b[k] + 0.25 * c[k])
    };
    let at = |i: usize| match (i == 0 || i + 1 == n, is_closed) {
        (false, _) => mean(values[i - 1], values[i], values[i + 1]),
        (true, true) => mean(values[n - 2], values[0], values[1]),
        (true, false) => values[i],
    };
    (0..n).map(at).collect()
}

/// Leaves out points without which the stroke changes nowhere by more than the tolerance, in place and in width
/// (Douglas & Peucker 1973).
pub(super) fn simplified(points: &[StrokePoint]) -> Vec<StrokePoint> {
    let mut kept = vec![false; points.len()];
    let mut pending = vec![(0, points.len().saturating_sub(1))];
    while let Some((from, to)) = pending.pop() {
        let (Some(a), Some(b)) = (points.get(from), points.get(to)) else { continue };
        (kept[from], kept[to]) = (true, true);
        let farthest = (from + 1..to)
            .map(|i| (i, deviation(&points[i], a, b)))
            .max_by(|x, y| x.1.total_cmp(&y.1))
            .filter(|(_, far)| *far > TOLERANCE_PX);
        if let Some((i, _)) = farthest {
            pending.extend([(from, i), (i, to)]);
        }
    }
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(p, _)| *p).collect()
}

/// How far `p` is from the piece between `a` and `b`, in place or width.
fn deviation(p: &StrokePoint, a: &StrokePoint, b: &StrokePoint) -> f64 {
    let d: [f64; 2] = std::array::from_fn(|i| b.at[i] - a.at[i]);
    let e: [f64; 2] = std::array::from_fn(|i| p.at[i] - a.at[i]);
    let squared = dot(d, d);
    let t = if squared > 0.0 { (dot(d, e) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let place = std::array::from_fn(|i| a.at[i] + t * d[i]);
    apart(p.at, place).max((p.width - (a.width + t * (b.width - a.width))).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const CRUMBS: usize = 60;

    /// Six samples from each sixtieth of a circle, with a gap after it, every third piece backward.
    fn crumb(piece: usize) -> Vec<Sample> {
        let sample = |k: usize| {
            let angle = TAU * (piece as f64 + k as f64 / 7.0) / CRUMBS as f64;
            let at = [300.0 * angle.cos(), 300.0 * angle.sin()];
            let on = LinePoint { at: [0.0; 3], normal: [0.0; 3], strength: 1.0, weight: 1.0 };
            Sample { at, on, seen: true }
        };
        let run = (0..6).map(sample);
        if piece.is_multiple_of(3) { run.rev().collect() } else { run.collect() }
    }

    #[test]
    fn crumbs_of_a_circle_become_one_closed_run_in_any_order() {
        let runs: Vec<(Mark, Vec<Sample>)> =
            (0..CRUMBS).map(|i| (Mark::Contour, crumb(i * 23 % CRUMBS))).collect();
        let joined = joined(runs, 1.0);
        assert_eq!(joined.len(), 1);
        let (_, circle) = &joined[0];
        assert_eq!(circle.len(), 6 * CRUMBS + 1);
        assert_eq!(circle[0].at, circle[6 * CRUMBS].at);
        let widest = circle.windows(2).map(|pair| apart(pair[0].at, pair[1].at)).fold(0.0, f64::max);
        assert!(widest < 10.0, "{widest}");
    }

    #[test]
    fn only_lines_of_one_kind_are_joined() {
        let runs = vec![(Mark::Contour, crumb(1)), (Mark::Valley, crumb(2)), (Mark::Contour, crumb(3))];
        let kinds: Vec<Mark> = joined(runs, 1.0).into_iter().map(|(mark, _)| mark).collect();
        assert_eq!(kinds, [Mark::Contour, Mark::Valley, Mark::Contour]);
    }
}
