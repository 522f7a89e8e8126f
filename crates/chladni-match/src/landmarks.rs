//! Landmarks: pairs of vertices that belong together, and the file format for them.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;

use chladni_task::read_text_file;
use glam::DVec3;

use crate::similarity::fit_pairs;
use crate::surface::UnitSurface;
use crate::{MatchError, Scaling, Side};

/// The largest size of a landmark file, enough for a million pairs.
const MOST_BYTES: u64 = 16 << 20;

/// Vertex `shape` of the shape belongs to vertex `template` of the template. Indices are zero-based, in the
/// order of the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Landmark {
    /// Index of a vertex in the shape's file.
    pub shape: u32,
    /// Index of a vertex in the template's file.
    pub template: u32,
}

/// Reads the landmark file at `path`; see [`read_landmarks`].
///
/// # Errors
/// [`MatchError::InLandmarkFile`], with the file and the reason.
pub fn load_landmarks(path: &Path) -> Result<Vec<Landmark>, MatchError> {
    let in_file = |why: String| MatchError::InLandmarkFile { path: path.to_owned(), why };
    let text = read_text_file(path, MOST_BYTES).map_err(|error| in_file(error.to_string()))?;
    read_landmarks(&text).map_err(|error| in_file(error.to_string()))
}

/// Reads landmarks from text: one `shape_vertex template_vertex` per line, with blanks, a comma or a semicolon between them;
/// `#` starts a comment.
///
/// # Errors
/// A line that does not hold two vertex numbers, or that repeats a shape vertex; the error states the line.
pub fn read_landmarks(text: &str) -> Result<Vec<Landmark>, MatchError> {
    let (mut landmarks, mut known) = (Vec::new(), HashSet::new());
    for (index, line) in text.lines().enumerate() {
        let line_number = index + 1;
        let content = line.split('#').next().unwrap_or_default();
        let is_gap = |c: char| c.is_whitespace() || [',', ';'].contains(&c);
        let words: Vec<&str> = content.split(is_gap).filter(|word| !word.is_empty()).collect();
        let problem = |problem: String| MatchError::LandmarkFile { line: line_number, problem };
        match words[..] {
            [] => {}
            [shape, template] => {
                let number = |word: &str| {
                    word.parse::<u32>().map_err(|e| problem(format!("“{word}” is not a vertex number ({e})")))
                };
                let landmark = Landmark { shape: number(shape)?, template: number(template)? };
                if !known.insert(landmark.shape) {
                    return Err(problem(format!("shape vertex {} has a landmark already", landmark.shape)));
                }
                landmarks.push(landmark);
            }
            _ => return Err(problem(format!("expected two vertex numbers, found {} words", words.len()))),
        }
    }
    Ok(landmarks)
}

/// Landmarks as text, in the format that [`read_landmarks`] reads.
pub fn write_landmarks(landmarks: &[Landmark]) -> String {
    let mut text = String::from("# shape_vertex template_vertex, zero-based\n");
    for l in landmarks {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{} {}", l.shape, l.template);
    }
    text
}

/// A landmark as a pair of welded vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pinned {
    pub shape: u32,
    pub template: u32,
}

/// Finds the landmarks on both surfaces.
pub(crate) fn pin(
    landmarks: &[Landmark],
    shape: &UnitSurface,
    template: &UnitSurface,
) -> Result<Vec<Pinned>, MatchError> {
    let find = |landmark: usize, surface: &UnitSurface, side: Side, vertex: u32| {
        let problem = match surface.point_of_vertex.get(vertex as usize) {
            Some(Some(point)) => return Ok(*point),
            Some(None) => "belongs to no triangle, so it is not on the surface",
            None => "does not exist",
        };
        Err(MatchError::Landmark { landmark, side, vertex, problem })
    };
    landmarks
        .iter()
        .enumerate()
        .map(|(i, l)| {
            Ok(Pinned {
                shape: find(i, shape, Side::Shape, l.shape)?,
                template: find(i, template, Side::Template, l.template)?,
            })
        })
        .collect()
}

/// The landmarks as pairs of points of the two surfaces.
pub(crate) fn points(pinned: &[Pinned], shape: &UnitSurface, template: &UnitSurface) -> Vec<(DVec3, DVec3)> {
    pinned.iter().map(|l| (shape.points[l.shape as usize], template.points[l.template as usize])).collect()
}

/// Warnings about landmarks, given as pairs (shape point, template point): that no similarity brings some
/// pairs together, or that a mirrored template would fit much better.
pub(crate) fn doubts(pairs: &[(DVec3, DVec3)]) -> Vec<String> {
    let misfit = |mirror: DVec3| {
        let moved = pairs.iter().map(|(p, q)| (*q * mirror, *p, 1.0));
        let fit = fit_pairs(moved.clone(), Scaling::Free).ok()?;
        let sum: f64 = moved.map(|(q, p, _)| fit.at(q).distance_squared(p)).sum();
        Some((sum / pairs.len() as f64).sqrt())
    };
    let Some(straight) = misfit(DVec3::ONE) else { return Vec::new() };
    let mirrored = misfit(DVec3::new(-1.0, 1.0, 1.0)).unwrap_or(f64::INFINITY);
    if pairs.len() >= 4 && straight > 0.03 && mirrored < 0.5 * straight {
        vec!["the landmarks fit a mirrored template much better: left and right may be swapped".into()]
    } else if straight > 0.15 {
        vec![format!(
            "the landmarks stay {:.0} % of the diagonal apart after alignment: some pairs may be wrong",
            100.0 * straight
        )]
    } else {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_comes_back_as_it_was_written() {
        let landmarks = vec![Landmark { shape: 177, template: 1633 }, Landmark { shape: 0, template: 9 }];
        assert_eq!(read_landmarks(&write_landmarks(&landmarks)).unwrap(), landmarks);
        let text = "# nose\n  177\t1633  # tip\n\n0 9\r\n";
        assert_eq!(read_landmarks(text).unwrap(), landmarks);
        assert_eq!(read_landmarks("177, 1633\n0;9\n").unwrap(), landmarks, "as tables have them");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, line) in [("1 2\n3", 2), ("1 2 3", 1), ("\n1 -2", 2), ("1 2\n1 3", 2), ("a b", 1)] {
            match read_landmarks(text) {
                Err(MatchError::LandmarkFile { line: found, .. }) => assert_eq!(found, line, "{text:?}"),
                other => panic!("{text:?}: {other:?}"),
            }
        }
    }

    #[test]
    fn two_hundred_thousand_landmarks_are_not_each_compared_with_all_before() {
        // That would be twenty billion comparisons: minutes of a test that otherwise takes a moment.
        let count = 200_000;
        let landmarks: Vec<Landmark> =
            (0..count).map(|i| Landmark { shape: count - i, template: i }).collect();
        let text = write_landmarks(&landmarks);
        assert_eq!(read_landmarks(&text).unwrap(), landmarks);
        let last = read_landmarks(&format!("{text}{count} 7\n"));
        assert!(matches!(last, Err(MatchError::LandmarkFile { line: 200_002, .. })), "{last:?}");
    }
}
