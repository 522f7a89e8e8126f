//! OBJ material libraries and the pictures they name.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::beside::Beside;
use super::draft::Draft;
use super::text::{Lines, words};
use crate::appearance::linear_from_srgb;
use crate::read::Mended;
use crate::{Material, Texture};

/// Reads library `name` into the materials that the faces of `draft` use. Unreadable parts are skipped and
/// reported.
pub(crate) fn read_into(draft: &mut Draft, name: &str, beside: &Beside<'_>) {
    let bytes = match beside(name) {
        Ok(bytes) => bytes,
        Err(reason) => {
            draft.mended.push(Mended::MissingFile(name.to_owned(), reason));
            return;
        }
    };
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let picture = |name: &str| {
        let bytes = beside(&folder.join(name.replace('\\', "/")).to_string_lossy())?;
        if is_picture(&bytes) { Ok(Arc::from(bytes)) } else { Err("it is neither PNG nor JPEG".into()) }
    };
    let mut joined = Vec::new();
    let mut lines = Lines::new(&bytes, Some(b'#'), true);
    let mut current = None;
    let mut pictures = HashMap::new();
    while let Some(line) = lines.next(&mut joined) {
        let keyword = words(line).next().unwrap_or_default();
        let rest = String::from_utf8_lossy(line[keyword.len()..].trim_ascii()).into_owned();
        if keyword == b"newmtl" {
            current = draft.known_material(&rest);
            // A second definition replaces the first.
            if let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) {
                material.other_statements.clear();
            }
            continue;
        }
        let Some(material) = current.and_then(|i| draft.materials.get_mut(i)) else { continue };
        if let Err(missing) = statement(material, keyword, &rest, &mut pictures, &picture) {
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
    pictures: &mut HashMap<String, Picture>,
    picture: &dyn Fn(&str) -> Picture,
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
            // Many materials may share one picture; it is read once.
            let found = pictures.entry(name.to_owned()).or_insert_with(|| picture(name)).clone();
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

/// Whether `bytes` begin like a PNG or JPEG file.
pub(crate) fn is_picture(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") || bytes.starts_with(b"\xff\xd8\xff")
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
