//! OBJ material libraries and the pictures they name.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::beside::{Beside, plain_name};
use super::draft::Draft;
use super::text::{Lines, text_after, words};
use crate::appearance::linear_from_srgb;
use crate::read::Mended;
use crate::{Material, Texture};

/// The libraries that one statement is taken to name.
const MOST_LIBRARIES: usize = 64;

/// Reads what `mtllib` statements name into the materials that the faces of `draft` use. A statement is first taken as one
/// name, which may hold blanks; if there is no such file, as several names. A library that is named again, as some programs
/// do before each group, is read once. Unreadable parts are skipped and reported.
///
/// Names in `statements`, and those of the materials of `draft`, may end in comments: they do where there is no library or
/// material of the whole name.
pub(crate) fn read_into(draft: &mut Draft, statements: &[String], beside: &Beside<'_>) {
    let (mut known, mut libraries) = (HashSet::new(), Vec::new());
    let mut read = |name: &str| -> Result<(), String> {
        let plain = plain_name(name);
        if known.insert(plain.clone()) {
            libraries.push((plain, beside(name)?));
        }
        Ok(())
    };
    for statement in statements {
        let Err(reason) = read(statement) else { continue };
        let name = before_comment(statement);
        if name.len() < statement.len() && !name.is_empty() && read(name).is_ok() {
            continue;
        }
        let names = name.split_ascii_whitespace().filter(|part| *part != name);
        let tried: Vec<_> = names.take(MOST_LIBRARIES).map(|name| (name, read(name))).collect();
        if tried.iter().any(|(_, outcome)| outcome.is_ok()) {
            let missing = |(name, outcome): (&str, Result<(), String>)| {
                Some(Mended::MissingFile(name.to_owned(), outcome.err()?))
            };
            draft.mended.extend(tried.into_iter().filter_map(missing));
        } else {
            let bare = Some(without_comment_apart(statement)).filter(|bare| !bare.is_empty());
            draft.mended.push(Mended::MissingFile(bare.unwrap_or(statement).to_owned(), reason));
        }
    }
    let defined: HashSet<String> = libraries.iter().flat_map(|(_, bytes)| defined_names(bytes)).collect();
    if draft.materials.iter().any(|material| material.name.contains('#')) {
        draft.rename_materials(|name| {
            let kept = if defined.contains(name) { name } else { before_comment(name) };
            kept.to_owned()
        });
    }
    let mut pictures = HashMap::new();
    for (name, bytes) in &libraries {
        read_library(draft, name, bytes, &defined, &mut pictures, beside);
    }
}

/// A name without the comment that it may end in.
fn before_comment(name: &str) -> &str {
    name.split('#').next().unwrap_or_default().trim_end()
}

/// The names of the materials of a library, which may end in comments.
fn defined_names(bytes: &[u8]) -> Vec<String> {
    let (mut names, mut joined) = (Vec::new(), Vec::new());
    let mut lines = Lines::new(bytes, Some(b'#'), true);
    while let Some([line, whole]) = lines.next_and_whole(&mut joined) {
        if words(line).next() == Some(NEW_MATERIAL) {
            names.push(text_after(whole, NEW_MATERIAL));
        }
    }
    names
}

const NEW_MATERIAL: &[u8] = b"newmtl";

/// Reads the library called `name`; `defined` are the names of the materials of all libraries.
fn read_library(
    draft: &mut Draft,
    name: &str,
    bytes: &[u8],
    defined: &HashSet<String>,
    pictures: &mut HashMap<String, Picture>,
    beside: &Beside<'_>,
) {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let mut picture = |name: &str| {
        // Many materials may share one picture; it is read once.
        let path = plain_name(&folder.join(name.replace('\\', "/")).to_string_lossy());
        // A texture is called as the mesh would call it.
        let is_beside = folder.as_os_str().is_empty() || name.is_empty();
        let texture = if is_beside { name.to_owned() } else { path.clone() };
        let read = |path: &String| beside(path).and_then(|bytes| checked_picture(&bytes).map(Arc::from));
        (texture, pictures.entry(path).or_insert_with_key(read).clone())
    };
    let mut joined = Vec::new();
    let mut lines = Lines::new(bytes, Some(b'#'), true);
    let mut current = None;
    while let Some([line, whole]) = lines.next_and_whole(&mut joined) {
        let keyword = words(line).next().unwrap_or_default();
        let [rest, whole] = [line, whole].map(|line| text_after(line, keyword));
        if keyword == NEW_MATERIAL {
            // One that is defined without a comment is another material.
            let is_whole = draft.known_material(&whole).is_some() || defined.contains(&rest);
            let name = if is_whole { whole } else { rest };
            current = draft.known_material(&name);
            // A second definition replaces the first.
            if let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) {
                *material = Material::named(&name);
            }
            continue;
        }
        let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) else { continue };
        if let Err(missing) = statement(material, keyword, [&rest, &whole], &mut picture) {
            draft.mended.push(missing);
        }
    }
}

/// A picture's bytes, or why there are none.
type Picture = Result<Arc<[u8]>, String>;

/// Takes a statement, whose values are `rest`, and `whole` with the comment after them. `picture` gives the name that a
/// texture has from now on, and its bytes.
fn statement(
    material: &mut Material,
    keyword: &[u8],
    [rest, whole]: [&str; 2],
    picture: &mut dyn FnMut(&str) -> (String, Picture),
) -> Result<(), Mended> {
    let mut values = rest.split_ascii_whitespace().map_while(|word| word.parse::<f64>().ok());
    let other = || format!("{} {}", String::from_utf8_lossy(keyword), without_comment_apart(whole));
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
            // A number sign may be of the name.
            let bare = without_comment_apart(whole);
            let found = [whole, bare, rest].into_iter().find(|text| picture(picture_name(text)).1.is_ok());
            let text = found.unwrap_or(bare).trim();
            let name = picture_name(text);
            material.texture_options = text[..text.len() - name.len()].trim_end().to_owned();
            let (name, found) = picture(name);
            let bytes = found.clone().unwrap_or_default();
            material.base_color_texture = Some(Texture { name: name.clone(), bytes });
            found.map_err(|reason| Mended::MissingFile(name, reason))?;
        }
        _ => material.other_statements.push(other()),
    }
    Ok(())
}

/// `text` without a comment that stands apart: names of files may hold number signs.
fn without_comment_apart(text: &str) -> &str {
    let begins = |at: usize| text[..at].is_empty() || text[..at].ends_with(char::is_whitespace);
    let comment = text.match_indices('#').map(|(at, _)| at).find(|at| begins(*at));
    text[..comment.unwrap_or(text.len())].trim_end()
}

/// The file's name, which may hold blanks, in a texture statement of an OBJ's material library: `rest` is all after the
/// keyword, and may begin with options such as `-s 1 1 1`.
pub fn picture_name(rest: &str) -> &str {
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
        assert_eq!(picture_name("fuze uv.jpg"), "fuze uv.jpg");
        assert_eq!(picture_name("-s 1 1 1 -clamp on a b.png"), "a b.png");
        assert_eq!(picture_name("-s 1"), "1");
        assert_eq!(picture_name("-"), "");
    }
}
