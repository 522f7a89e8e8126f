//! The JSON and the binary chunk of a glTF file, binary or not.

use crate::Format;
use crate::error::Fault;

/// Which of both formats a glTF file has.
pub(crate) fn gltf_format(bytes: &[u8]) -> Format {
    if bytes.starts_with(b"glTF") { Format::Glb } else { Format::Gltf }
}

/// The JSON of a glTF file, and the buffer that a GLB brings along.
pub(crate) fn json_and_binary(bytes: &[u8], format: Format) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let (json, binary) = if format == Format::Glb { glb_chunks(bytes)? } else { (bytes, None) };
    Ok((json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json), binary))
}

/// The JSON chunk and the binary chunk, if any.
fn glb_chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |at: usize| {
        let raw = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
        raw.map(|raw| u32::from_le_bytes(*raw))
            .ok_or_else(|| Fault::byte(bytes.len(), "the file ends in a chunk's header"))
    };
    let version = word(4)?;
    if !bytes.starts_with(b"glTF") || version != 2 {
        return Err(Fault::byte(0, "not a binary glTF file of version 2"));
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let length = word(at)? as usize;
        if bytes.get(at + 4..at + 8) != Some(kind) {
            return Err(Fault::byte(at + 4, format!("no {} chunk", kind.escape_ascii())));
        }
        let start = at + 8;
        match start.checked_add(length).and_then(|end| bytes.get(start..end)) {
            Some(data) => Ok(data),
            None => Err(Fault::byte(bytes.len(), format!("the file ends inside a chunk of {length} bytes"))),
        }
    };
    let json = chunk(12, b"JSON")?;
    let next = 20 + json.len().next_multiple_of(4);
    let binary = if next + 8 <= bytes.len() { Some(chunk(next, b"BIN\0")?) } else { None };
    Ok((json, binary))
}
