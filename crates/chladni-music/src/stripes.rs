//! Where a picture has stripes: light and dark in turn, in any direction, at about equal distances.
//!
//! Regular patterns provoke seizures even where nothing flashes. The consensus of the Epilepsy Foundation of America (Harding,
//! Wilkins, Erba, Barkley and Fisher, Epilepsia 46, 2005) and Wilkins, Emmett and Harding (ibid.) advise against more than five
//! light-dark pairs of clearly discernible stripes in any orientation that cover more than a quarter of the screen for half
//! a second or longer, their lightest brighter than 50 cd/m². Checkerboards, rings and rays count, as rows of alike elements.

use chladni_mesh::srgb_from_linear;

use crate::flash::{GUARDED, Swings};
use crate::flash_field::{FlashArea, are_too_many};
use crate::histogram::{CELLS, COLUMNS, FINE, Histogram, ROWS};
use crate::{FLASH_STEP, Veil};

const WIDE: usize = FINE * COLUMNS;
const HIGH: usize = FINE * ROWS;
/// More pairs than this are a pattern.
const MAX_PAIRS: usize = 5;
/// Where no stripe is brighter than this there is none: 50 cd/m² of the 200 cd/m² for which WCAG's steps of 0.1 are the 20
/// cd/m² of the guidelines.
const BRIGHT: f64 = 0.25;
/// Stripes that differ by as much as states of a flash do are clearly discernible.
const STEP: f32 = GUARDED * FLASH_STEP;
/// Distances of neighboring pairs differ by no more than this share of the shorter and these dots.
const UNEVEN: (f32, f32) = (0.25, 0.5);
/// A change of light that is this many times as large as the one before belongs to something else.
const UNLIKE: f32 = 2.0;
/// A cell has stripes where this many of its 16 dots do.
const DOTS_OF_CELL: u8 = 12;
/// Along rows, columns and both diagonals: any stripes cross one of these lines at 67° or more.
const DIRECTIONS: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// The stripes of one picture, cell by cell.
#[derive(Clone, Debug)]
pub(crate) struct Stripes {
    luminances: Vec<f32>,
    /// For each cell its dots that lie in stripes, and the light of these.
    found: Vec<(u8, f32)>,
    /// The brightest stripe of each cell, sRGB-encoded; 0 where there are no stripes.
    light: Vec<u8>,
    edges: Vec<Edge>,
}

/// From dark to light, along a line.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Where it is half done.
    at: f32,
    dark: f32,
    light: f32,
}

impl Default for Stripes {
    fn default() -> Self {
        Self {
            luminances: vec![0.0; WIDE * HIGH],
            found: vec![(0, 0.0); CELLS],
            light: vec![0; CELLS],
            edges: Vec::with_capacity(WIDE),
        }
    }
}

impl Stripes {
    /// Looks for the stripes of `picture`.
    pub(crate) fn look(&mut self, picture: &Histogram) {
        picture.write_luminances(&mut self.luminances);
        self.light.fill(0);
        let [low, high] =
            [f32::min, f32::max].map(|pick| self.luminances.iter().copied().reduce(pick).unwrap_or_default());
        if f64::from(high) <= BRIGHT || high - low < STEP {
            return;
        }
        for direction in DIRECTIONS {
            self.found.fill((0, 0.0));
            lines(direction).for_each(|(start, length)| self.follow(start, direction, length));
            for (light, &(dots, brightest)) in self.light.iter_mut().zip(&self.found) {
                if dots >= DOTS_OF_CELL {
                    *light = (*light).max(encoded(brightest.into()));
                }
            }
        }
    }

    /// Whether stripes cover more than a quarter of `area` behind `veil`, the picture being the one that was looked at.
    pub(crate) fn are_too_many(&self, picture: &Histogram, veil: Veil, area: FlashArea) -> bool {
        let most = encoded(BRIGHT);
        are_too_many(picture, area, |cell| self.light[cell] > 0 && veil.over(self.light[cell]) > most)
    }

    /// Marks the dots of a line that lie in stripes.
    fn follow(&mut self, [x, y]: [usize; 2], [dx, dy]: [isize; 2], length: usize) {
        let dot = |i: usize| [x.wrapping_add_signed(dx * i as isize), y.wrapping_add_signed(dy * i as isize)];
        let luminance = |i: usize| {
            let [x, y] = dot(i);
            self.luminances[y * WIDE + x]
        };
        self.edges.clear();
        note_edges(length, luminance, &mut self.edges);
        let mut unmarked = 0;
        for run in runs(&self.edges) {
            let (first, last) = (run[0].at, run[run.len() - 1].at);
            let pair = (last - first) / (run.len() - 1) as f32;
            let brightest = run.iter().fold(0.0, |most: f32, edge| most.max(edge.light));
            // The first dark and the last light belong to it.
            let end = ((last + pair).ceil() as usize).min(length);
            for i in unmarked.max((first - pair).max(0.0) as usize)..end {
                let [x, y] = dot(i);
                let (dots, light) = &mut self.found[y / FINE * COLUMNS + x / FINE];
                *dots += 1;
                *light = light.max(brightest);
            }
            unmarked = end;
        }
    }
}

/// Finds where a line gets light after it was dark.
fn note_edges(length: usize, luminance: impl Fn(usize) -> f32, edges: &mut Vec<Edge>) {
    let mut swings = Swings::of(STEP, f32::INFINITY);
    let [mut low, mut high] = [(0, luminance(0)); 2];
    let mut risen_from = None;
    for i in 0..length {
        let value = luminance(i);
        let change = swings.change(value);
        swings.take(value, change);
        if change > 0 {
            risen_from = Some(low);
        } else if change < 0 {
            edges.extend(risen_from.take().map(|dark| Edge::between(dark, high, &luminance)));
        }
        if change < 0 || value < low.1 {
            low = (i, value);
        }
        if change > 0 || value > high.1 {
            high = (i, value);
        }
    }
    edges.extend(risen_from.map(|dark| Edge::between(dark, high, luminance)));
}

impl Edge {
    fn between(
        (begin, dark): (usize, f32),
        (end, light): (usize, f32),
        luminance: impl Fn(usize) -> f32,
    ) -> Self {
        let half = (dark + light) / 2.0;
        let i = (begin + 1..end).find(|&i| luminance(i) >= half).unwrap_or(end);
        let (before, after) = (luminance(i.saturating_sub(1)), luminance(i));
        Self { at: i as f32 - (after - half) / (after - before).max(f32::EPSILON), dark, light }
    }

    /// Whether it is about as strong as the one before.
    fn is_like(&self, before: &Self) -> bool {
        let [own, other] = [self, before].map(|edge| edge.light - edge.dark);
        own.max(other) <= UNLIKE * own.min(other)
    }
}

/// Edges that follow each other as those of stripes do, enough of them to be a pattern.
fn runs(edges: &[Edge]) -> impl Iterator<Item = &[Edge]> {
    let goes_on = |run: &[Edge]| match run {
        [.., a, b, c] => {
            let (one, other) = (b.at - a.at, c.at - b.at);
            c.is_like(b) && (one - other).abs() <= UNEVEN.0 * one.min(other) + UNEVEN.1
        }
        [a, b] => b.is_like(a),
        _ => true,
    };
    let mut start = 0;
    std::iter::from_fn(move || {
        while start + MAX_PAIRS < edges.len() {
            let end = (start + 1..edges.len()).find(|&end| !goes_on(&edges[start..=end]));
            let run = &edges[start..end.unwrap_or(edges.len())];
            // The last pair of one may be the first of the next.
            start += (run.len() - 1).max(1);
            if run.len() > MAX_PAIRS {
                return Some(run);
            }
        }
        None
    })
}

/// The first dot and the length of each line in a direction.
fn lines([dx, dy]: [isize; 2]) -> impl Iterator<Item = ([usize; 2], usize)> {
    let first_row = if dy < 0 { HIGH - 1 } else { 0 };
    let from_side = (0..HIGH).filter(move |_| dx != 0).map(|y| [0, y]);
    let from_end = (0..WIDE).filter(move |&x| dy != 0 && (dx == 0 || x > 0)).map(move |x| [x, first_row]);
    from_side.chain(from_end).map(move |[x, y]| {
        let across = if dx == 0 { usize::MAX } else { WIDE - x };
        let down = match dy {
            0 => usize::MAX,
            1 => HIGH - y,
            _ => y + 1,
        };
        ([x, y], across.min(down))
    })
}

fn encoded(luminance: f64) -> u8 {
    (255.0 * srgb_from_linear(luminance)).round() as u8
}

#[cfg(test)]
mod tests;
