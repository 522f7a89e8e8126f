//! Shade as evenly spaced strokes along the principal directions of curvature.
//!
//! The visible surface is sampled on a grid of places. Light, and the two principal directions as they look on paper,
//! are averaged there, and strokes run along them at even distances (Jobard & Lefer, "Creating evenly-spaced
//! streamlines of arbitrary density", 1997), wider where it is darker.

use std::collections::VecDeque;

use chladni_mesh::surface::vec3::{Vec3, add, dot, scaled, unit};
use chladni_mesh::surface::{Principal, Tensor, mixed};
use rayon::prelude::*;

use super::lines::smooth_step;
use super::sight::Sight;
use super::strokes::simplified;
use super::{Ink, Mark, Stroke, StrokePoint};

/// All lengths are in units of paper, a nine-hundredth of the cell's shorter side: between places,
const GRID: f64 = 3.0;
/// between strokes,
const APART: f64 = 6.5;
/// of a step along a stroke,
const STEP: f64 = 1.5;
/// of the shortest stroke and the longest,
const SHORT: f64 = 22.0;
const LONG: f64 = 420.0;
/// and over which a stroke grows from its end to its width.
const TAPER: f64 = 20.0;
/// How near a stroke may come to others, as a share of the distance at which it begins.
const CROWDED: f64 = 0.62;
/// How often light and directions are averaged with those of neighboring places.
const LIGHT_PASSES: usize = 3;
const DIRECTION_PASSES: usize = 24;
/// A step in depth between two places that one surface does not make, as a share of the size.
const LEAP: f64 = 0.03;
/// Toward the lamp: right, up and toward the viewer.
const LAMP: Vec3 = [-0.52, 0.6, 0.61];
/// Share of the light that remains in a cast shadow.
const SHADOW: f64 = 0.45;

/// The visible surface at a place.
#[derive(Clone, Copy)]
pub(super) struct Place {
    depth: f64,
    /// 0 in full light, 1 in the dark.
    pub dark: f64,
    /// The two principal directions on paper, as cosine and sine of twice their angle: they have no sign.
    along: [[f64; 2]; 2],
}

/// Places, row by row.
pub(super) struct Field {
    corner: [f64; 2],
    step: f64,
    pub columns: usize,
    pub rows: usize,
    places: Vec<Option<Place>>,
    /// A step in depth that no surface makes between two places.
    leap: f64,
}

pub(super) fn strokes(sight: &Sight<'_>, ink: &Ink) -> Vec<Stroke> {
    if ink.hatching <= 0.0 {
        return Vec::new();
    }
    let mut field = Field::lit(sight, GRID);
    for _ in 0..DIRECTION_PASSES {
        field.average(|place, mean| place.along = mean.along);
    }
    let mut strokes = Vec::new();
    // A second layer crosses the first where it is darkest.
    for (layer, from) in [(0, 1.0 - ink.hatching), (1, 1.0 - 0.5 * ink.hatching)] {
        let mut layer = Layer::new(&field, layer, from, sight.unit);
        layer.fill();
        strokes.extend(layer.lines.iter().map(|line| layer.stroke(line, ink.pen_px(sight.cell))));
    }
    strokes
}

impl Field {
    /// Places `grid` units apart, their light averaged.
    pub fn lit(sight: &Sight<'_>, grid: f64) -> Self {
        let step = grid * sight.unit;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let cell = sight.cell;
        let edges = [[cell.x, cell.x + cell.width], [cell.y, cell.y + cell.height]].map(|e| e.map(f64::from));
        for at in sight.plate.positions.iter().filter_map(|p| sight.project(*p)) {
            for i in 0..2 {
                low[i] = low[i].min(at[i]).max(edges[i][0]);
                high[i] = high[i].max(at[i]).min(edges[i][1]);
            }
        }
        let count = |i: usize| ((high[i] - low[i]) / step).max(0.0).ceil() as usize + 1;
        let (columns, rows) = (count(0), count(1));
        let place = |i: usize| {
            let (x, y) = ((i % columns) as f64, (i / columns) as f64);
            place(sight, [low[0] + x * step, low[1] + y * step])
        };
        let places = (0..columns * rows).into_par_iter().map(place).collect();
        let leap = LEAP * sight.plate.size;
        let mut field = Self { corner: low, step, columns, rows, places, leap };
        for _ in 0..LIGHT_PASSES {
            field.average(|place, mean| place.dark = mean.dark);
        }
        field
    }

    /// Whether there is a place in that column and row.
    pub fn has(&self, [x, y]: [i64; 2]) -> bool {
        (0..self.columns as i64).contains(&x) && (0..self.rows as i64).contains(&y)
    }

    /// The place in that column and row, where a surface is visible.
    pub fn place(&self, [x, y]: [i64; 2]) -> Option<&Place> {
        self.has([x, y]).then(|| self.places[y as usize * self.columns + x as usize].as_ref())?
    }

    /// Where that column and row is, in pixels.
    pub fn point(&self, at: [i64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| self.corner[i] + at[i] as f64 * self.step)
    }

    /// Replaces something of each place by the mean over it and the four beside it on the same surface.
    fn average(&mut self, put: impl Fn(&mut Place, Place) + Sync) {
        let before = &self.places;
        let (columns, rows) = (self.columns, self.rows);
        let averaged = |i: usize| {
            let mut own = before[i]?;
            let (x, y) = (i % columns, i / columns);
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < columns).then(|| i + 1),
                (y > 0).then(|| i - columns),
                (y + 1 < rows).then(|| i + columns),
            ];
            let others = beside.into_iter().flatten().filter_map(|j| before[j]);
            let (mut sum, mut count) = (own, 1.0);
            for other in others.filter(|other| (other.depth - own.depth).abs() < self.leap) {
                sum.dark += other.dark;
                for (a, b) in sum.along.iter_mut().flatten().zip(other.along.iter().flatten()) {
                    *a += b;
                }
                count += 1.0;
            }
            let along = sum.along.map(|a| a.map(|x| x / count));
            let mean = Place { dark: sum.dark / count, along, ..own };
            put(&mut own, mean);
            Some(own)
        };
        self.places = (0..self.places.len()).into_par_iter().map(averaged).collect();
    }

    fn at(&self, p: [f64; 2]) -> Option<&Place> {
        let [x, y] = [0, 1].map(|i| ((p[i] - self.corner[i]) / self.step).round());
        self.place([x as i64, y as i64])
    }
}

fn place(sight: &Sight<'_>, at: [f64; 2]) -> Option<Place> {
    let plate = sight.plate;
    let hit = sight.look(at)?;
    let corners = plate.triangles[hit.triangle as usize].map(|v| v as usize);
    let weights = hit.barycentric.map(f64::from);
    let p = mixed(corners.map(|v| plate.positions[v]), weights);
    let toward = sight.toward(p);
    let normal = unit(mixed(corners.map(|v| plate.normals[v]), weights));
    let normal = if dot(normal, toward) < 0.0 { scaled(normal, -1.0) } else { normal };
    let lamp = unit((0..3).fold([0.0; 3], |sum, i| add(sum, scaled(sight.axes[i], LAMP[i]))));
    let shine = dot(normal, lamp);
    let free = shine > 0.0 && sight.is_free(p, normal, lamp);
    // Wrapped a little around the edge of the light, as by a large lamp.
    let light = ((shine + 0.35) / 1.35).max(0.0) * if free { 1.0 } else { SHADOW };
    let tensor: Tensor =
        std::array::from_fn(|i| (0..3).map(|c| weights[c] * plate.grain[corners[c]][i]).sum());
    let Principal { values: [a, b], directions } = Principal::of(tensor, normal);
    let sure = if a + b > 0.0 { (a - b) / (a + b) } else { 0.0 };
    let along = directions.map(|direction| {
        let ends = [-1.0, 1.0].map(|s| sight.project(add(p, scaled(direction, s * 1e-3 * plate.size))));
        let [Some(from), Some(to)] = ends else { return [0.0; 2] };
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let squared = x * x + y * y;
        // As a complex number, (x + i·y)² has twice the angle.
        if squared > 0.0 {
            [sure * (x * x - y * y) / squared, sure * 2.0 * x * y / squared]
        } else {
            [0.0; 2]
        }
    });
    Some(Place { depth: dot(p, sight.axes[2]), dark: 1.0 - light.min(1.0), along })
}

/// A stroke as it is traced: places and how dark it is there.
type Traced = Vec<([f64; 2], f64)>;

/// Strokes in one of the two directions where it is darker than `from`.
struct Layer<'a> {
    field: &'a Field,
    which: usize,
    from: f64,
    unit: f64,
    lines: Vec<Traced>,
    /// Points of all lines, by squares as wide as lines are apart.
    squares: Vec<Vec<[f64; 2]>>,
    columns: usize,
}

impl<'a> Layer<'a> {
    fn new(field: &'a Field, which: usize, from: f64, unit: f64) -> Self {
        let squares = |n: usize| (n as f64 * field.step / (APART * unit)) as usize + 2;
        let (columns, rows) = (squares(field.columns), squares(field.rows));
        Self {
            field,
            which,
            from,
            unit,
            lines: Vec::new(),
            squares: vec![Vec::new(); columns * rows],
            columns,
        }
    }

    /// Traces lines beside lines, and where no line is near, from the first place that is dark enough.
    fn fill(&mut self) {
        let field = self.field;
        for i in 0..field.places.len() {
            let (x, y) = ((i % field.columns) as f64, (i / field.columns) as f64);
            let mut seeds =
                VecDeque::from([[field.corner[0] + x * field.step, field.corner[1] + y * field.step]]);
            while let Some(seed) = seeds.pop_front() {
                let Some(line) = self.trace(seed) else { continue };
                seeds.extend(self.beside(&line));
                for (at, _) in &line {
                    let square = self.square(*at);
                    self.squares[square].push(*at);
                }
                self.lines.push(line);
            }
        }
    }

    fn square(&self, at: [f64; 2]) -> usize {
        let side = APART * self.unit;
        let [x, y] = [0, 1].map(|i| ((at[i] - self.field.corner[i]) / side + 0.5).max(0.0) as usize);
        (y * self.columns + x.min(self.columns - 1)).min(self.squares.len() - 1)
    }

    fn is_free(&self, at: [f64; 2], distance: f64) -> bool {
        let own = self.square(at) as i64;
        let columns = self.columns as i64;
        let around = [-1, 0, 1].into_iter().flat_map(|y| [-1, 0, 1].map(|x| own + y * columns + x));
        let near = |p: &[f64; 2]| (p[0] - at[0]).hypot(p[1] - at[1]) < distance;
        !around.filter_map(|s| self.squares.get(usize::try_from(s).ok()?)).flatten().any(near)
    }

    /// The direction of a line there, that agrees with the one before.
    fn direction(&self, place: &Place, before: Option<[f64; 2]>) -> Option<[f64; 2]> {
        let [cos, sin] = place.along[self.which];
        if cos.hypot(sin) < 1e-3 {
            return None;
        }
        let angle = 0.5 * sin.atan2(cos);
        let way = [angle.cos(), angle.sin()];
        match before {
            Some([x, y]) if way[0] * x + way[1] * y < 0.0 => Some([-way[0], -way[1]]),
            _ => Some(way),
        }
    }

    /// The line through `seed`, in both directions as far as it goes; `None` where there is no room or it is short.
    fn trace(&self, seed: [f64; 2]) -> Option<Traced> {
        let place = self.field.at(seed).filter(|place| place.dark > self.from)?;
        if !self.is_free(seed, APART * self.unit) {
            return None;
        }
        let way = self.direction(place, None)?;
        let mut line = self.half(seed, place, [-way[0], -way[1]]);
        line.reverse();
        line.push((seed, place.dark));
        line.extend(self.half(seed, place, way));
        (line.len() as f64 * STEP >= SHORT).then_some(line)
    }

    fn half(&self, seed: [f64; 2], place: &'a Place, way: [f64; 2]) -> Traced {
        let (mut at, mut way, mut depth) = (seed, way, place.depth);
        let mut line = Traced::new();
        let step = STEP * self.unit;
        while (line.len() as f64) * STEP < 0.5 * LONG {
            // The midpoint's direction is that of the step.
            let middle = [at[0] + 0.5 * step * way[0], at[1] + 0.5 * step * way[1]];
            let Some(turned) = self.field.at(middle).and_then(|p| self.direction(p, Some(way))) else {
                break;
            };
            // A sharp turn is a place where directions meet.
            if turned[0] * way[0] + turned[1] * way[1] < 0.8 {
                break;
            }
            way = turned;
            at = [at[0] + step * way[0], at[1] + step * way[1]];
            let Some(place) = self.field.at(at) else { break };
            let bright = place.dark < self.from - 0.04;
            if bright
                || (place.depth - depth).abs() > self.field.leap
                || !self.is_free(at, CROWDED * APART * self.unit)
            {
                break;
            }
            depth = place.depth;
            line.push((at, place.dark));
        }
        line
    }

    /// Places to either side of a line from which others may begin.
    fn beside(&self, line: &Traced) -> Vec<[f64; 2]> {
        let apart = APART * self.unit * 1.001;
        let every = (APART / STEP).ceil() as usize;
        let ways = line.windows(2).step_by(every);
        ways.flat_map(|pair| {
            let [(a, _), (b, _)] = [pair[0], pair[1]];
            let l = (b[0] - a[0]).hypot(b[1] - a[1]).max(1e-12);
            let across = [-(b[1] - a[1]) / l * apart, (b[0] - a[0]) / l * apart];
            [[a[0] + across[0], a[1] + across[1]], [a[0] - across[0], a[1] - across[1]]]
        })
        .collect()
    }

    /// A line as wide as it is dark, up to about half the distance between lines.
    fn stroke(&self, line: &Traced, pen: f64) -> Stroke {
        let last = line.len() - 1;
        let point = |(i, (at, dark)): (usize, &([f64; 2], f64))| {
            let shade = smooth_step((dark - self.from + 0.04) / (1.04 - self.from).max(1e-9));
            let end = i.min(last - i) as f64 * STEP / TAPER;
            let width = pen * (0.3 + 0.75 * shade) * (0.2 + 0.8 * smooth_step(end));
            StrokePoint { at: *at, width: width.min(0.6 * APART * self.unit) }
        };
        let points: Vec<StrokePoint> = line.iter().enumerate().map(point).collect();
        Stroke { mark: Mark::Hatching, points: simplified(&points) }
    }
}
