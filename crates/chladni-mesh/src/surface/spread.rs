//! Vertices that are far from each other.

use super::vec3::{Vec3, dot, sub};

/// Adds the position farthest from all chosen ones, again and again, until `count` are chosen (farthest-first traversal;
/// T. Gonzalez, *Theoretical Computer Science* 38, 1985); of several that are equally far the last. Where fewer places differ,
/// some are chosen twice.
pub fn spread(positions: &[Vec3], chosen: &mut Vec<u32>, count: usize) {
    let squared = |a: Vec3, b: Vec3| dot(sub(a, b), sub(a, b));
    let from_chosen =
        |p: &Vec3| chosen.iter().map(|&c| squared(*p, positions[c as usize])).fold(f64::MAX, f64::min);
    let mut nearest: Vec<f64> = positions.iter().map(from_chosen).collect();
    while chosen.len() < count {
        let Some(next) = (0..positions.len()).max_by(|&i, &j| nearest[i].total_cmp(&nearest[j])) else {
            return;
        };
        chosen.push(next as u32);
        for (d, p) in nearest.iter_mut().zip(positions) {
            *d = d.min(squared(*p, positions[next]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_line_come_first_and_then_its_middle() {
        let line: Vec<Vec3> = (0..9).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let mut chosen = vec![0];
        spread(&line, &mut chosen, 3);
        assert_eq!(chosen, [0, 8, 4]);
        spread(&[], &mut Vec::new(), 3);
    }
}
