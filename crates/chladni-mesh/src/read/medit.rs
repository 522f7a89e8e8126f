//! INRIA Medit `.mesh`, ascii: its triangles and quadrilaterals.

use super::draft::{Draft, coordinate, vertex_index};
use super::text::{Words, quoted};
use crate::error::Fault;
use crate::read::Mended;

/// Reads vertices, triangles and quadrilaterals. Tetrahedra, hexahedra and all other sections
/// are left out; so are reference numbers.
pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut words = Words::new(bytes, 1, Some(b'#'));
    let mut draft = Draft::default();
    let mut dimension = 3;
    // Sections may come in any order, so faces are checked at the end.
    let mut faces: Vec<([i64; 4], usize, usize)> = Vec::new();
    while let Some(word) = words.next() {
        match word {
            b"MeshVersionFormatted" => drop(words.number::<u32>("the version")?),
            b"Dimension" => {
                dimension = words.number("the dimension")?;
                if !(2..=3).contains(&dimension) {
                    return Err(Fault::line(words.line(), "the dimension must be 2 or 3"));
                }
            }
            b"Vertices" => read_vertices(&mut words, dimension, &mut draft)?,
            b"Triangles" => read_faces(&mut words, 3, &mut faces)?,
            b"Quadrilaterals" => read_faces(&mut words, 4, &mut faces)?,
            b"End" => break,
            _ if word[0].is_ascii_alphabetic() => {
                // One that is not known may have no count: the next word may be another section.
                let has_count = words.peek().is_some_and(|next| !next[0].is_ascii_alphabetic());
                let count =
                    if has_count { words.number::<usize>("a number of entries").unwrap_or(0) } else { 0 };
                if count > 0 {
                    let name = String::from_utf8_lossy(word.get(..32).unwrap_or(word)).into_owned();
                    draft.mended.push(Mended::LeftOut(format!("{count} {name}")));
                }
                while words.peek().is_some_and(|next| !next[0].is_ascii_alphabetic()) {
                    words.next();
                }
            }
            _ => {
                return Err(Fault::line(
                    words.line(),
                    format!("{} where a section should begin", quoted(word)),
                ));
            }
        }
    }
    for (indices, corners, line) in faces {
        for &index in &indices[..corners] {
            // Medit counts from 1.
            let v = vertex_index(index.saturating_sub(1), draft.positions.len(), |_| {
                let count = draft.positions.len();
                Fault::line(
                    line,
                    format!("vertex index {index} is out of range (there are {count} vertices)"),
                )
            })?;
            draft.corners.push(v);
        }
        draft.end_face();
    }
    Ok(draft)
}

fn read_vertices(words: &mut Words<'_>, dimension: usize, draft: &mut Draft) -> Result<(), Fault> {
    for _ in 0..words.number::<usize>("the number of vertices")? {
        let mut position = [0.0; 3];
        for p in &mut position[..dimension] {
            *p = coordinate(words.number("a coordinate")?, |reason| Fault::line(words.line(), reason))?;
        }
        words.number::<f64>("a vertex's reference number")?;
        draft.positions.push(position);
    }
    Ok(())
}

fn read_faces(
    words: &mut Words<'_>,
    corners: usize,
    faces: &mut Vec<([i64; 4], usize, usize)>,
) -> Result<(), Fault> {
    for _ in 0..words.number::<usize>("the number of faces")? {
        let mut indices = [0; 4];
        for index in &mut indices[..corners] {
            *index = words.number("a vertex index")?;
        }
        let line = words.line();
        words.number::<i64>("a face's reference number")?;
        faces.push((indices, corners, line));
    }
    Ok(())
}
