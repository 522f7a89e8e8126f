//! Light as a few flat tones, as a woodcut or a cartoon has it.

use std::collections::BTreeMap;

use super::hatching::Field;
use super::sight::Sight;
use super::strokes::simplified;
use super::{Ink, StrokePoint};

/// A flat tone on paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// The share of ink in its color, the rest being paper; in (0, 1).
    pub shade: f64,
    /// Its closed borders in pixels; what an odd number of them go around belongs to it.
    pub rings: Vec<Vec<[f64; 2]>>,
}

/// Between places at which light is sampled, in nine-hundredths of the cell's shorter side.
const GRID: f64 = 2.0;
/// The smallest spot of a tone, in squares of that unit.
const SPECK: f64 = 60.0;
/// Halvings that find where the shape ends between two places.
const HALVINGS: usize = 6;

/// A side between two neighboring places: the first one's column and row, and whether it runs down.
type Side = ([i64; 2], bool);

/// The tones darker than the paper, the lightest first; each lies on the one before.
pub(super) fn areas(sight: &Sight<'_>, ink: &Ink) -> Vec<Area> {
    if ink.tones < 2 {
        return Vec::new();
    }
    let field = Field::lit(sight, GRID);
    let tones = ink.tones.min(Ink::MOST_TONES);
    let area = |k: usize| {
        let share = k as f64 / tones as f64;
        let rings = Border { sight, field: &field, from: 0.15 + 0.7 * share }.rings();
        Area { shade: 0.6 * share, rings }
    };
    (1..tones).map(area).filter(|area| !area.rings.is_empty()).collect()
}

/// Where a field becomes darker than a threshold.
struct Border<'a> {
    sight: &'a Sight<'a>,
    field: &'a Field,
    from: f64,
}

impl Border<'_> {
    fn dark(&self, at: [i64; 2]) -> Option<f64> {
        self.field.place(at).map(|place| place.dark)
    }

    fn is_inside(&self, at: [i64; 2]) -> bool {
        self.dark(at).is_some_and(|dark| dark > self.from)
    }

    /// Marching squares. Borders are walked with the tone on the same hand everywhere, so that from each side that one
    /// crosses exactly one goes on.
    fn rings(&self) -> Vec<Vec<[f64; 2]>> {
        let mut next: BTreeMap<Side, Side> = BTreeMap::new();
        for y in -1..self.field.rows as i64 {
            for x in -1..self.field.columns as i64 {
                let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
                let sides = [([x, y], false), ([x + 1, y], true), ([x, y + 1], false), ([x, y], true)];
                let inside = corners.map(|corner| self.is_inside(corner));
                let leaves = |i: usize| inside[i] && !inside[(i + 1) % 4];
                let enters = |i: usize| !inside[i] && inside[(i + 1) % 4];
                for i in (0..4).filter(|i| leaves(*i)) {
                    let back = (1..4).map(|step| (i + 4 - step) % 4).find(|j| enters(*j));
                    next.extend(back.map(|back| (sides[i], sides[back])));
                }
            }
        }
        let mut rings = Vec::new();
        while let Some((first, mut side)) = next.pop_first() {
            let mut ring = vec![self.crossing(first)];
            while let Some(after) = next.remove(&side) {
                ring.push(self.crossing(side));
                side = after;
            }
            ring.push(ring[0]);
            if area(&ring).abs() >= SPECK * self.sight.unit * self.sight.unit {
                let points: Vec<StrokePoint> =
                    ring.into_iter().map(|at| StrokePoint { at, width: 0.0 }).collect();
                rings.push(simplified(&points).into_iter().map(|point| point.at).collect());
            }
        }
        rings
    }

    /// Where the border crosses a side.
    fn crossing(&self, (at, down): Side) -> [f64; 2] {
        let other = if down { [at[0], at[1] + 1] } else { [at[0] + 1, at[1]] };
        let (inner, outer) = if self.is_inside(at) { (at, other) } else { (other, at) };
        let (a, b) = (self.field.point(inner), self.field.point(outer));
        let between = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        match (self.dark(inner), self.dark(outer)) {
            (Some(dark), Some(light)) => between(((dark - self.from) / (dark - light)).clamp(0.0, 1.0)),
            // Beside the sheet there is nothing to look for.
            _ if !self.field.has(outer) => a,
            _ => {
                let (mut seen, mut bare) = (0.0, 1.0);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (seen + bare);
                    let end = if self.sight.look(between(middle)).is_some() { &mut seen } else { &mut bare };
                    *end = middle;
                }
                between(0.5 * (seen + bare))
            }
        }
    }
}

/// Signed, of a closed ring.
fn area(ring: &[[f64; 2]]) -> f64 {
    ring.windows(2).map(|pair| 0.5 * (pair[0][0] * pair[1][1] - pair[1][0] * pair[0][1])).sum()
}

/// Lays the colors of `areas`, mixed of paper and ink, over `pixels`, rows of `width` from the top.
pub(super) fn fill(pixels: &mut [[f32; 3]], width: usize, areas: &[(&Area, [f32; 3])]) {
    /// Lines in which each row of pixels is measured; along a line coverage is exact.
    const LINES: usize = 4;
    let height = pixels.len() / width.max(1);
    for (area, color) in areas {
        let mut cuts: Vec<Vec<f64>> = vec![Vec::new(); height * LINES];
        for pair in area.rings.iter().flat_map(|ring| ring.windows(2)) {
            let [a, b] = [pair[0], pair[1]];
            let (low, high) = if a[1] < b[1] { (a, b) } else { (b, a) };
            let line = |y: f64| (y * LINES as f64 - 0.5).ceil().clamp(0.0, cuts.len() as f64) as usize;
            for i in line(low[1])..line(high[1]) {
                let t = ((i as f64 + 0.5) / LINES as f64 - low[1]) / (high[1] - low[1]);
                cuts[i].push(low[0] + t * (high[0] - low[0]));
            }
        }
        for (row, lines) in pixels.chunks_mut(width.max(1)).zip(cuts.chunks_mut(LINES)) {
            let mut cover = vec![0.0_f32; row.len()];
            for line in lines {
                line.sort_by(f64::total_cmp);
                for span in line.chunks_exact(2) {
                    let [from, to] = [span[0], span[1]].map(|x| x.clamp(0.0, row.len() as f64));
                    for (x, cover) in
                        cover.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize)
                    {
                        let x = x as f64;
                        *cover += ((to.min(x + 1.0) - from.max(x)).max(0.0) / LINES as f64) as f32;
                    }
                }
            }
            for (pixel, cover) in row.iter_mut().zip(cover) {
                *pixel = std::array::from_fn(|i| pixel[i] + (color[i] - pixel[i]) * cover.min(1.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Drawing, Plate};
    use super::*;
    use crate::{Camera, Rect, View};
    use chladni_mesh::samples::icosphere;

    fn ball(tones: usize) -> Drawing {
        let ball = icosphere(4);
        let plate = Plate::new(&ball.positions, &ball.triangles, 0.01).unwrap();
        let ink = Ink { tones, hatching: 0.0, detail: 0.0, ..Ink::default() };
        let mut camera = Camera::looking(View::Front);
        let points = ball.positions.iter().map(|p| p.map(|x| x as f32));
        camera.fit(points, 1.0, 0.8);
        let mut drawing = Drawing::new(300, 300, &ink).unwrap();
        drawing.add(&plate, &ink, &camera, Rect::of_size(300, 300));
        drawing
    }

    #[test]
    fn a_ball_has_as_many_flat_tones_as_are_asked_for_and_is_dark_away_from_the_lamp() {
        for tones in 2..=4 {
            let drawing = ball(tones);
            assert_eq!(drawing.areas.len(), tones - 1);
            let picture = drawing.to_picture();
            let pixel = |x: u32, y: u32| picture.pixel(x, y).unwrap();
            let mut counts = BTreeMap::new();
            for at in (0..300 * 300).map(|i| (i % 300, i / 300)) {
                let far = (f64::from(at.0) - 149.5).hypot(f64::from(at.1) - 149.5);
                if far < 110.0 {
                    *counts.entry(pixel(at.0, at.1)).or_insert(0) += 1;
                }
            }
            let whole: i32 = counts.values().sum();
            let flat: Vec<i32> = counts.values().copied().filter(|count| *count > whole / 50).collect();
            assert_eq!(flat.len(), tones, "{counts:?}");
            assert!(flat.iter().sum::<i32>() > whole * 9 / 10, "{flat:?} of {whole}");
            let (lit, dark) = (pixel(105, 95), pixel(205, 215));
            assert!(lit[0] > dark[0] + 60 && lit[..3] == drawing.paper, "{lit:?} {dark:?}");
            // Outside the ball there is paper, right up to its contour.
            assert_eq!(pixel(8, 8)[..3], drawing.paper);
            let svg = drawing.to_svg();
            assert_eq!(svg.matches("fill-rule=\"evenodd\"").count(), tones - 1);
            assert_eq!(svg, ball(tones).to_svg());
        }
        assert!(ball(0).areas.is_empty() && !ball(0).to_svg().contains("tones"));
    }

    #[test]
    fn a_square_covers_its_pixels_exactly_and_its_hole_none() {
        let square =
            |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high], [low, low]];
        let area = Area { shade: 0.5, rings: vec![square(1.5, 8.0), square(3.0, 5.0)] };
        let mut pixels = vec![[0.0; 3]; 100];
        fill(&mut pixels, 10, &[(&area, [1.0; 3])]);
        let total: f32 = pixels.iter().map(|p| p[0]).sum();
        assert!((total - (6.5 * 6.5 - 4.0)).abs() < 1e-4, "{total}");
        assert_eq!([pixels[0][0], pixels[66][0], pixels[44][0]], [0.0, 1.0, 0.0]);
        assert!((pixels[61][0] - 0.5).abs() < 1e-6);
    }
}
