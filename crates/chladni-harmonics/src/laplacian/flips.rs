//! Flips edges until the cover is intrinsically Delaunay.

use super::cover::{Cover, next, previous};
use super::intrinsic::cotangents;
use crate::HarmonicsError;

/// A cotangent sum above this counts as Delaunay; otherwise four points on a circle would be flipped
/// forever.
const TOLERANCE: f64 = -1e-10;
/// The most flips beyond a few for every side, however large the surface: they take a few seconds, and cannot be canceled.
const MOST_MORE: u64 = 1 << 26;

/// Flips edges whose opposite angles sum to more than π until there are none (Bobenko & Springborn 2007).
pub(super) fn flip_to_delaunay(cover: &mut Cover) -> Result<(), HarmonicsError> {
    let sides = cover.tail.len();
    let mut waiting: Vec<u32> = (0..sides as u32).filter(|&h| h < cover.twin[h as usize]).collect();
    let mut is_waiting: Vec<bool> = vec![false; sides];
    for &h in &waiting {
        is_waiting[h as usize] = true;
    }
    let mut budget = most_flips(sides as u64);
    while let Some(h) = waiting.pop() {
        is_waiting[h as usize] = false;
        let twin = cover.twin[h as usize];
        if h / 3 == twin / 3 || opposite_cotangent(cover, h) + opposite_cotangent(cover, twin) >= TOLERANCE {
            continue;
        }
        if budget == 0 {
            return Err(HarmonicsError::NotCertified { reason: "edge flips did not come to an end".into() });
        }
        budget -= 1;
        if !flip(cover, h) {
            continue;
        }
        cover.flips += 1;
        for outer in [next(h), previous(h), next(twin), previous(twin)] {
            if !is_waiting[outer as usize] {
                is_waiting[outer as usize] = true;
                waiting.push(outer);
            }
        }
    }
    Ok(())
}

/// The bound only stops rounding from flipping an edge back and forth. Most surfaces take a few flips for each edge, but
/// large fans may take as many as the square of their number.
pub(super) fn most_flips(sides: u64) -> u64 {
    200 * sides + 10_000 + (sides.saturating_mul(sides) / 8).min(MOST_MORE)
}

fn opposite_cotangent(cover: &Cover, h: u32) -> f64 {
    let f = h as usize / 3 * 3;
    cotangents([cover.length[f], cover.length[f + 1], cover.length[f + 2]]).1[h as usize % 3]
}

/// Replaces the diagonal of the quadrilateral formed by two triangles with the other one. Returns `false`
/// and changes nothing if rounding makes the new length unusable.
fn flip(cover: &mut Cover, h: u32) -> bool {
    let t = cover.twin[h as usize];
    let (h1, h2, t1, t2) = (next(h), previous(h), next(t), previous(t));
    let length = |s: u32| cover.length[s as usize];
    let tail = |s: u32| cover.tail[s as usize];
    // Unfold with u at the origin and v at (l, 0), w above and x below.
    let l = length(h);
    let place = |to_u: f64, to_v: f64| {
        let x = (l * l + to_u * to_u - to_v * to_v) / (2.0 * l);
        let y2 = (to_u - x) * (to_u + x);
        (x, y2.max(0.0).sqrt())
    };
    let (wx, wy) = place(length(h2), length(h1));
    let (xx, xy) = place(length(t1), length(t2));
    let diagonal = (wx - xx).hypot(wy + xy);
    if !(diagonal.is_finite() && diagonal > 0.0) {
        return false;
    }
    let (w, x) = (tail(h2), tail(t2));
    // The triangle of h becomes (w → x, x → v, v → w), that of t becomes (x → w, w → u, u → x).
    let moved = [(t2, h1), (h1, h2), (h2, t1), (t1, t2)];
    let renamed = |s: u32| moved.iter().find(|(old, _)| *old == s).map_or(s, |(_, new)| *new);
    let values = moved.map(|(old, _)| (tail(old), length(old), renamed(cover.twin[old as usize])));
    for ((_, new), (tail, length, twin)) in moved.into_iter().zip(values) {
        cover.tail[new as usize] = tail;
        cover.length[new as usize] = length;
        cover.twin[new as usize] = twin;
        cover.twin[twin as usize] = new;
    }
    cover.tail[h as usize] = w;
    cover.tail[t as usize] = x;
    cover.length[h as usize] = diagonal;
    cover.length[t as usize] = diagonal;
    true
}
