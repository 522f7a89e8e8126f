//! The header of a PLY file.

use super::text::{number, quoted, words};
use crate::error::Fault;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A PLY number type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes it takes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of a color channel of this type at full intensity.
    pub fn full_scale(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::U16 | Self::I16 => 65535.0,
            _ => 255.0,
        }
    }

    /// The number in `raw`, which has [`size`](Self::size) bytes.
    pub fn value(self, raw: &[u8], big_endian: bool) -> f64 {
        let mut bytes = [0; 8];
        for (i, &b) in raw.iter().take(8).enumerate() {
            bytes[if big_endian { raw.len() - 1 - i } else { i }] = b;
        }
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// One property of an element; a list where it has a type for its length.
#[derive(Clone, Debug)]
pub(crate) struct Property {
    pub name: String,
    pub list: Option<Scalar>,
    pub scalar: Scalar,
}

/// One kind of element.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Rows that take bytes: 0 if the element has no property, whatever its stated count.
    pub fn rows(&self) -> usize {
        if self.properties.is_empty() { 0 } else { self.count }
    }
}

/// The header, up to `end_header`.
pub(crate) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// MeshLab's `comment TextureFile NAME`, in order.
    pub textures: Vec<String>,
    /// Bytes up to the first value.
    pub length: usize,
    /// Lines of the header.
    pub lines: usize,
}

impl Header {
    pub fn read(bytes: &[u8]) -> Result<Self, Fault> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut textures = Vec::new();
        let (mut start, mut line) = (0, 0);
        loop {
            line += 1;
            // Lines end with \n, \r\n or, seldom, \r alone.
            let Some(length) = bytes[start..].iter().position(|&b| b == b'\n' || b == b'\r') else {
                return Err(Fault::line(
                    line,
                    if line == 1 { NOT_PLY } else { "the header has no 'end_header'" },
                ));
            };
            let text = &bytes[start..start + length];
            let crlf = bytes[start + length..].starts_with(b"\r\n");
            start += length + 1 + usize::from(crlf);
            let mut parts = words(text);
            let keyword = parts.next().unwrap_or_default();
            if line == 1 {
                if keyword != b"ply" {
                    return Err(Fault::line(1, NOT_PLY));
                }
                continue;
            }
            match keyword {
                b"format" => encoding = Some(read_encoding(parts.next().unwrap_or_default(), line)?),
                b"element" => {
                    let name = String::from_utf8_lossy(parts.next().unwrap_or_default()).into_owned();
                    let count = number(parts.next().unwrap_or_default(), line, "a number of elements")?;
                    if elements.iter().any(|known| known.name == name) {
                        let name = quoted(name.as_bytes());
                        return Err(Fault::line(line, format!("{name} is there a second time")));
                    }
                    elements.push(Element { name, count, properties: Vec::new() });
                }
                b"property" => {
                    let Some(element) = elements.last_mut() else {
                        return Err(Fault::line(line, "a property before the first element"));
                    };
                    element.properties.push(read_property(parts, line)?);
                }
                b"comment" => {
                    let rest = text.trim_ascii()[keyword.len()..].trim_ascii_start();
                    if let Some(name) = rest.strip_prefix(b"TextureFile") {
                        textures.push(String::from_utf8_lossy(name.trim_ascii()).into_owned());
                    }
                }
                b"obj_info" | b"" => {}
                b"end_header" => break,
                _ => {
                    return Err(Fault::line(line, format!("{} is no word of a PLY header", quoted(keyword))));
                }
            }
        }
        let encoding = encoding.ok_or_else(|| Fault::line(line, "the header has no 'format'"))?;
        Ok(Self { encoding, elements, textures, length: start, lines: line })
    }
}

const NOT_PLY: &str = "the first line is not 'ply'";

fn read_encoding(word: &[u8], line: usize) -> Result<Encoding, Fault> {
    Ok(match word {
        b"ascii" => Encoding::Ascii,
        b"binary_little_endian" => Encoding::LittleEndian,
        b"binary_big_endian" => Encoding::BigEndian,
        _ => return Err(Fault::line(line, format!("{} is no PLY format", quoted(word)))),
    })
}

fn read_property<'a>(mut parts: impl Iterator<Item = &'a [u8]>, line: usize) -> Result<Property, Fault> {
    let scalar = |word: Option<&'a [u8]>| {
        let word = word.unwrap_or_default();
        Scalar::named(word).ok_or_else(|| Fault::line(line, format!("{} is no PLY type", quoted(word))))
    };
    let first = parts.next();
    let (list, kind) = if first == Some(b"list") {
        (Some(scalar(parts.next())?), scalar(parts.next())?)
    } else {
        (None, scalar(first)?)
    };
    let Some(name) = parts.next() else {
        return Err(Fault::line(line, "a property without a name"));
    };
    let name = String::from_utf8_lossy(name).into_owned();
    Ok(Property { name, list, scalar: kind })
}
