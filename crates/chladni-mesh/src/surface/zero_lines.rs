//! Lines on a surface where a function is zero.

use super::vec3::{Vec3, add, scaled};

/// A point on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// The edge's vertices, the lesser first.
    pub ends: [u32; 2],
    /// How far it lies from the first to the second, in [0, 1].
    pub along: f64,
}

impl EdgePoint {
    /// A quantity of the vertices at this point, interpolated linearly along the edge.
    pub fn mixed(&self, at: impl Fn(u32) -> Vec3) -> Vec3 {
        let [a, b] = self.ends.map(at);
        add(scaled(a, 1.0 - self.along), scaled(b, self.along))
    }

    /// As [`mixed`](Self::mixed), of numbers.
    pub fn number(&self, at: impl Fn(u32) -> f64) -> f64 {
        let [a, b] = self.ends.map(at);
        a * (1.0 - self.along) + b * self.along
    }
}

/// The lines where a function that is linear on each of `triangles` is zero, as chains of points on edges, each from
/// triangle to triangle as far as it goes. A closed line ends with its first point.
///
/// `values` gives the function at a triangle's corners, or `None` where no line is wanted. Its signs may differ between
/// triangles (as those of principal directions do), but not the ratio of sizes along an edge. Zero counts as positive.
pub fn zero_lines(
    triangles: &[[u32; 3]],
    values: impl Fn(usize, [u32; 3]) -> Option<[f64; 3]>,
) -> Vec<Vec<EdgePoint>> {
    let mut segments = Vec::new();
    for (t, corners) in triangles.iter().enumerate() {
        let Some(at) = values(t, *corners) else { continue };
        let crossing = |i: usize| {
            let j = (i + 1) % 3;
            ((at[i] >= 0.0) != (at[j] >= 0.0)).then(|| {
                let (a, b) = if corners[i] < corners[j] { (i, j) } else { (j, i) };
                let along = at[a].abs() / (at[a].abs() + at[b].abs());
                EdgePoint { ends: [corners[a], corners[b]], along }
            })
        };
        let mut found = (0..3).filter_map(crossing);
        // Of three signs either none or two differ.
        if let (Some(a), Some(b)) = (found.next(), found.next()) {
            segments.push([a, b]);
        }
    }
    chained(&segments)
}

/// Joins segments that end on the same edge into lines, closed ones ending with their first point. Where more than two
/// segments end on one edge, its first two go together.
pub fn chained(segments: &[[EdgePoint; 2]]) -> Vec<Vec<EdgePoint>> {
    let mut ends: Vec<([u32; 2], u32)> =
        (0..).zip(segments).flat_map(|(s, [a, b])| [(a.ends, 2 * s), (b.ends, 2 * s + 1)]).collect();
    ends.sort_unstable();
    let mut across = vec![None; ends.len()];
    for edge in ends.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b), ..] = edge {
            (across[*a as usize], across[*b as usize]) = (Some(*b), Some(*a));
        }
    }
    let mut used = vec![false; segments.len()];
    let mut lines = Vec::new();
    let open = (0..across.len() as u32).filter(|end| across[*end as usize].is_none());
    // First the lines that have an end, from it; the rest are closed.
    for start in open.chain((0..segments.len() as u32).map(|s| 2 * s)) {
        let mut line = Vec::new();
        let mut next = Some(start);
        while let Some(end) = next.filter(|end| !std::mem::replace(&mut used[*end as usize / 2], true)) {
            let [a, b] = segments[end as usize / 2];
            let (here, there) = if end % 2 == 0 { (a, b) } else { (b, a) };
            if line.is_empty() {
                line.push(here);
            }
            line.push(there);
            next = across[(end ^ 1) as usize];
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use crate::surface::vec3::length;

    #[test]
    fn a_plane_cuts_a_ball_in_one_closed_circle() {
        let ball = samples::icosphere(4);
        let height = |v: u32| ball.positions[v as usize][1] - 0.6;
        let lines = zero_lines(&ball.triangles, |_, t| Some(t.map(height)));
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert!(line.len() > 60 && line.first() == line.last());
        for point in line {
            let [x, y, z] = point.mixed(|v| ball.positions[v as usize]);
            assert!((y - 0.6).abs() < 1e-12 && point.number(height).abs() < 1e-12);
            assert!((length([x, 0.0, z]) - 0.8).abs() < 0.005);
        }
    }

    #[test]
    fn a_line_ends_where_it_is_not_wanted_and_signs_may_differ_between_triangles() {
        let ball = samples::icosphere(3);
        let values = |t: usize, corners: [u32; 3]| {
            let sign = if t.is_multiple_of(3) { -1.0 } else { 1.0 };
            let wanted = corners.iter().all(|v| ball.positions[*v as usize][0] > 0.2);
            wanted.then(|| corners.map(|v| sign * (ball.positions[v as usize][1] - 0.013)))
        };
        let lines = zero_lines(&ball.triangles, values);
        assert_eq!(lines.len(), 1);
        assert_ne!(lines[0].first(), lines[0].last());
        assert_eq!(zero_lines(&ball.triangles, |_, _| Some([1.0, 0.0, 2.0])), Vec::<Vec<EdgePoint>>::new());
    }
}
