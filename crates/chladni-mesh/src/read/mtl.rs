//! OBJ material libraries and the pictures they name.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::beside::{Beside, plain_name};
use super::draft::Draft;
use super::text::{Lines, words};
use crate::appearance::linear_from_srgb;
use crate::read::Mended;
use crate::{Material, Texture};

/// The libraries that one statement is taken to name.
const MOST_LIBRARIES: usize = 64;

/// Reads what `mtllib` statements name into the materials that the faces of `draft` use. A statement is first taken as one
/// name, which may hold blanks; if there is no such file, as several names. A library that is named again, as some programs
/// do before each group, is read once. Unreadable parts are skipped and reported.
pub(crate) fn read_into(draft: &mut Draft, statements: &[String], beside: &Beside<'_>) {
    let (mut known, mut pictures) = (HashSet::new(), HashMap::new());
    let mut read = |draft: &mut Draft, name: &str| -> Result<(), String> {
        if known.insert(plain_name(name)) {
            let bytes = beside(name)?;
            read_library(draft, name, &bytes, &mut pictures, beside);
        }
        Ok(())
    };
    for statement in statements {
        let Err(reason) = read(draft, statement) else { continue };
        let names = statement.split_ascii_whitespace().filter(|name| *name != statement.as_str());
        let tried: Vec<_> = names.take(MOST_LIBRARIES).map(|name| (name, read(draft, name))).collect();
        if tried.iter().any(|(_, outcome)| outcome.is_ok()) {
            let missing = |(name, outcome): (&str, Result<(), String>)| {
                Some(Mended::MissingFile(name.to_owned(), outcome.err()?))
            };
            draft.mended.extend(tried.into_iter().filter_map(missing));
        } else {
            draft.mended.push(Mended::MissingFile(statement.clone(), reason));
        }
    }
}

fn read_library(
    draft: &mut Draft,
    name: &str,
    bytes: &[u8],
    pictures: &mut HashMap<String, Picture>,
    beside: &Beside<'_>,
) {
    let name = plain_name(name);
    let folder = Path::new(&name).parent().unwrap_or(Path::new(""));
    let mut picture = |name: &str| {
        // Many materials may share one picture; it is read once.
        let path = plain_name(&folder.join(name.replace('\\', "/")).to_string_lossy());
        let read = |path: &String| beside(path).and_then(|bytes| checked_picture(&bytes).map(Arc::from));
        pictures.entry(path).or_insert_with_key(read).clone()
    };
    let mut joined = Vec::new();
    let mut lines = Lines::new(bytes, Some(b'#'), true);
    let mut current = None;
    while let Some(line) = lines.next(&mut joined) {
        let keyword = words(line).next().unwrap_or_default();
        let rest = String::from_utf8_lossy(line[keyword.len()..].trim_ascii()).into_owned();
        if keyword == b"newmtl" {
            current = draft.known_material(&rest);
            // A second definition replaces the first.
            if let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) {
                *material = Material::named(&rest);
            }
            continue;
        }
        let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) else { continue };
        if let Err(missing) = statement(material, keyword, &rest, &mut picture) {
            draft.mended.push(missing);
        }
    }
}

/// A picture's bytes, or why there are none.
type Picture = Result<Arc<[u8]>, String>;

fn statement(
    material: &mut Material,
    keyword: &[u8],
    rest: &str,
    picture: &mut dyn FnMut(&str) -> Picture,
) -> Result<(), Mended> {
    let mut values = rest.split_ascii_whitespace().map_while(|word| word.parse::<f64>().ok());
    let other = || format!("{} {rest}", String::from_utf8_lossy(keyword));
    match keyword {
        b"Kd" => {
            let color: Vec<f64> = values.by_ref().take(3).collect();
            if let [r, g, b] = color[..]
                && color.iter().all(|c| c.is_finite())
            {
                let linear = [r, g, b].map(|c| linear_from_srgb(c.clamp(0.0, 1.0)) as f32);
                material.base_color[..3].copy_from_slice(&linear);
            } else {
                material.other_statements.push(other());
            }
        }
        b"d" => match values.next().filter(|d| d.is_finite()) {
            Some(opacity) => material.base_color[3] = opacity.clamp(0.0, 1.0) as f32,
            None => material.other_statements.push(other()),
        },
        b"map_Kd" => {
            let rest = rest.trim();
            let name = without_options(rest);
            material.texture_options = rest[..rest.len() - name.len()].trim_end().to_owned();
            let found = picture(name);
            let bytes = found.clone().unwrap_or_default();
            material.base_color_texture = Some(Texture { name: name.to_owned(), bytes });
            found.map_err(|reason| Mended::MissingFile(name.to_owned(), reason))?;
        }
        _ => material.other_statements.push(other()),
    }
    Ok(())
}

/// The end of a texture statement: its file name, which may hold blanks, after options such as
/// `-s 1 1 1`.
fn without_options(rest: &str) -> &str {
    let mut rest = rest.trim();
    while rest.starts_with('-') {
        let skip = |text: &str| {
            let end = text.find(char::is_whitespace).unwrap_or(text.len());
            text.len() - text[end..].trim_start().len()
        };
        rest = &rest[skip(rest)..];
        // An option's arguments are numbers, `on`, `off` or a channel.
        while let Some(word) = rest.split_ascii_whitespace().next() {
            let argument =
                word.parse::<f64>().is_ok() || ["on", "off", "r", "g", "b", "m", "l", "z"].contains(&word);
            if !argument || word.len() == rest.len() {
                break;
            }
            rest = &rest[skip(rest)..];
        }
    }
    rest
}

/// `bytes` if they begin like a PNG or JPEG file.
pub(crate) fn checked_picture(bytes: &[u8]) -> Result<&[u8], String> {
    let is_picture = bytes.starts_with(b"\x89PNG\r\n\x1a\n") || bytes.starts_with(b"\xff\xd8\xff");
    if is_picture { Ok(bytes) } else { Err("it is neither PNG nor JPEG".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_a_name_with_blanks() {
        assert_eq!(without_options("fuze uv.jpg"), "fuze uv.jpg");
        assert_eq!(without_options("-s 1 1 1 -clamp on a b.png"), "a b.png");
        assert_eq!(without_options("-s 1"), "1");
        assert_eq!(without_options("-"), "");
    }
}
