//! Stanford PLY, ascii and binary.

use std::sync::Arc;

use super::beside::Beside;
use super::draft::{Draft, coordinate, full_channel, is_texture_point, vertex_index};
use super::mtl::checked_picture;
use super::ply_header::{Element, Encoding, Header, Property, Scalar};
use super::text::Words;
use crate::error::Fault;
use crate::read::Mended;
use crate::{Attribute, CornerUvs, Material, Texture};

/// Reads vertices (with colors, texture coordinates and other numbers by their names), faces (with a list of texture
/// coordinates) and triangle strips with −1 between them. Other elements and properties, normals and face
/// colors among them, are left out.
pub(crate) fn read(bytes: &[u8], beside: &Beside<'_>) -> Result<Draft, Fault> {
    let header = Header::read(bytes)?;
    let body = &bytes[header.length..];
    let source = match header.encoding {
        Encoding::Ascii => Source::Ascii(Words::new(body, header.lines + 1, None)),
        Encoding::LittleEndian => Source::Binary { bytes, at: header.length, big_endian: false },
        Encoding::BigEndian => Source::Binary { bytes, at: header.length, big_endian: true },
    };
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut ply = Ply { draft: Draft::default(), source, vertices, bad_uvs: 0, long_rows: 0 };
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => ply.vertices(element)?,
            "face" => ply.faces(element)?,
            "tristrips" => ply.strips(element)?,
            _ => ply.skip(element)?,
        }
    }
    let mut draft = ply.draft;
    if ply.bad_uvs > 0 {
        draft.mended.push(Mended::Uvs(ply.bad_uvs));
    }
    if ply.long_rows > 0 {
        let what = format!("what {} rows hold beyond the header's properties", ply.long_rows);
        draft.mended.push(Mended::LeftOut(what));
    }
    let mut textures = header.textures.into_iter();
    if let Some(name) = textures.next() {
        add_texture(&mut draft, name, beside);
    }
    if textures.len() > 0 {
        draft.mended.push(Mended::LeftOut("all textures but the first".into()));
    }
    Ok(draft)
}

fn add_texture(draft: &mut Draft, name: String, beside: &Beside<'_>) {
    let found = beside(&name).and_then(|bytes| checked_picture(&bytes).map(Arc::from));
    let bytes = found.unwrap_or_else(|reason| {
        draft.mended.push(Mended::MissingFile(name.clone(), reason));
        Arc::default()
    });
    let base_color_texture = Some(Texture { name, bytes });
    draft.materials.push(Material { base_color_texture, ..Material::named("") });
    draft.face_materials = vec![Some(0); draft.face_count()];
}

/// Where the values come from.
enum Source<'a> {
    Ascii(Words<'a>),
    Binary { bytes: &'a [u8], at: usize, big_endian: bool },
}

impl Source<'_> {
    fn next(&mut self, scalar: Scalar, what: &str) -> Result<f64, Fault> {
        match self {
            Self::Ascii(words) => words.number(what),
            Self::Binary { bytes, at, big_endian } => {
                let Some(raw) = bytes.get(*at..*at + scalar.size()) else {
                    return Err(Fault::byte(
                        bytes.len(),
                        format!("the file ends where {what} should follow"),
                    ));
                };
                *at += raw.len();
                Ok(scalar.value(raw, *big_endian))
            }
        }
    }

    fn fault(&self, reason: impl Into<String>) -> Fault {
        match self {
            Self::Ascii(words) => Fault::line(words.line(), reason),
            Self::Binary { at, .. } => Fault::byte(*at, reason),
        }
    }

    /// An upper bound on the number of values that follow.
    fn at_most(&self) -> usize {
        match self {
            Self::Ascii(words) => words.at_most(),
            Self::Binary { bytes, at, .. } => bytes.len() - at,
        }
    }

    /// In ascii a row is a line: anything on it after the properties is dropped. Returns whether there was
    /// any.
    fn end_row(&mut self) -> bool {
        match self {
            Self::Ascii(words) => words.end_line(),
            Self::Binary { .. } => false,
        }
    }

    /// A property's values: one, or the entries of a list.
    fn property(&mut self, property: &Property, values: &mut Vec<f64>) -> Result<(), Fault> {
        values.clear();
        let count = match property.list {
            None => 1,
            Some(scalar) => {
                let count = self.next(scalar, "the length of a list")?;
                if !(count >= 0.0 && count.fract() == 0.0 && count <= self.at_most() as f64) {
                    return Err(self.fault(format!("a list of length {count} is not possible here")));
                }
                count as usize
            }
        };
        for _ in 0..count {
            values.push(self.next(property.scalar, &property.name)?);
        }
        Ok(())
    }
}

struct Ply<'a> {
    draft: Draft,
    source: Source<'a>,
    /// The number of vertices that the header promises.
    vertices: usize,
    bad_uvs: usize,
    /// Rows of an ascii file that hold more than the header says.
    long_rows: usize,
}

/// The meaning of a vertex property.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Role {
    Position(usize),
    Color(usize),
    Uv(usize),
    /// A number that is kept under its name.
    Attribute(usize),
    Other,
}

/// Numbers of a vertex that are kept, at most: a damaged header may name any number of them.
const MOST_ATTRIBUTES: usize = 64;

/// The meaning that the name of a vertex property has; `Attribute` where it has none.
pub(crate) fn named_role(name: &str) -> Role {
    match name {
        "x" => Role::Position(0),
        "y" => Role::Position(1),
        "z" => Role::Position(2),
        "red" | "r" | "diffuse_red" => Role::Color(0),
        "green" | "g" | "diffuse_green" => Role::Color(1),
        "blue" | "b" | "diffuse_blue" => Role::Color(2),
        "alpha" | "a" => Role::Color(3),
        "s" | "u" | "texture_u" => Role::Uv(0),
        "t" | "v" | "texture_v" => Role::Uv(1),
        // Normals are wrong as soon as the shape moves.
        "nx" | "ny" | "nz" => Role::Other,
        _ => Role::Attribute(0),
    }
}

/// The meanings of vertex properties, and the attributes among them. A channel of a color, or a texture coordinate, is an
/// attribute where its partners are missing.
fn vertex_roles(properties: &[Property]) -> (Vec<Role>, Vec<Attribute>) {
    let named: Vec<Role> = properties.iter().map(|property| named_role(&property.name)).collect();
    let has = |role: Role| named.contains(&role);
    let has_colors = (0..3).all(|channel| has(Role::Color(channel)));
    let has_uvs = (0..2).all(|i| has(Role::Uv(i)));
    let mut attributes: Vec<Attribute> = Vec::new();
    let role = |(property, named): (&Property, &Role)| match *named {
        Role::Color(_) if has_colors => *named,
        Role::Uv(_) if has_uvs => *named,
        Role::Position(_) | Role::Other => *named,
        _ if property.list.is_some()
            || attributes.len() >= MOST_ATTRIBUTES
            || attributes.iter().any(|known| known.name == property.name) =>
        {
            Role::Other
        }
        _ => {
            attributes.push(Attribute { name: property.name.clone(), values: Vec::new() });
            Role::Attribute(attributes.len() - 1)
        }
    };
    let roles = properties.iter().zip(&named).map(role).collect();
    (roles, attributes)
}

impl Ply<'_> {
    fn vertices(&mut self, element: &Element) -> Result<(), Fault> {
        let (roles, mut attributes) = vertex_roles(&element.properties);
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            if !roles.contains(&Role::Position(i)) && element.count > 0 {
                return Err(Fault::part("header", format!("the vertices have no property {axis}")));
            }
        }
        let mut full = [1.0; 4];
        for (property, role) in element.properties.iter().zip(&roles) {
            if let Role::Color(channel) = *role {
                full[channel] = property.scalar.full_scale();
            }
        }
        let has_colors = roles.contains(&Role::Color(0));
        let has_uvs = roles.contains(&Role::Uv(0));
        let mut colors = Vec::new();
        let mut values = Vec::new();
        for _ in 0..element.rows() {
            let mut position = [0.0; 3];
            let mut color = [0.0, 0.0, 0.0, full[3]];
            let mut uv = [0.0; 2];
            for (property, role) in element.properties.iter().zip(&roles) {
                self.source.property(property, &mut values)?;
                let Some(&value) = values.first() else { continue };
                match *role {
                    Role::Position(i) => position[i] = coordinate(value, |reason| self.source.fault(reason))?,
                    Role::Color(i) => color[i] = value,
                    Role::Uv(i) => uv[i] = value,
                    Role::Attribute(i) => attributes[i].values.push(value),
                    Role::Other => {}
                }
            }
            self.draft.positions.push(position);
            if has_colors {
                colors.push(color);
            }
            if has_uvs {
                self.draft.uvs.push(uv);
            }
            self.end_row();
        }
        // Some programs write bytes as floats.
        for channels in [0..3_usize, 3..4] {
            if full[channels.clone()].iter().all(|full| *full == 1.0) {
                let values = colors.iter().flat_map(|color| &color[channels.clone()]);
                let scale = full_channel(values);
                full[channels].fill(scale);
            }
        }
        self.draft.set_srgb_colors(colors, full);
        self.draft.attributes = attributes;
        Ok(())
    }

    fn index(&self, value: f64) -> Result<u32, Fault> {
        // NaN and fractions become −1, which is never a valid index.
        let index = if value.fract() == 0.0 { value as i64 } else { -1 };
        vertex_index(index, self.vertices, |reason| self.source.fault(reason))
    }

    fn faces(&mut self, element: &Element) -> Result<(), Fault> {
        let is_indices =
            |p: &Property| p.list.is_some() && matches!(&*p.name, "vertex_indices" | "vertex_index");
        if element.count > 0 && !element.properties.iter().any(is_indices) {
            return Err(Fault::part("header", "the faces have no list vertex_indices"));
        }
        let vertex_uvs = self.draft.uvs.len();
        let (mut values, mut uvs) = (Vec::new(), Vec::new());
        let mut face_colors = false;
        for _ in 0..element.rows() {
            let start = self.draft.corners.len();
            uvs.clear();
            for property in &element.properties {
                let target = if property.name == "texcoord" { &mut uvs } else { &mut values };
                self.source.property(property, target)?;
                face_colors |= property.name == "red";
                if is_indices(property) {
                    for &value in &values {
                        self.draft.corners.push(self.index(value)?);
                    }
                }
            }
            let corners = self.draft.corners.len() - start;
            for corner in 0..corners {
                let v = self.draft.corners[start + corner];
                let uv = match uvs.get(2 * corner..2 * corner + 2) {
                    Some(&[u, v]) if is_texture_point([u, v]) => {
                        self.draft.uvs.push([u, v]);
                        self.draft.uvs.len() as u32 - 1
                    }
                    // Our writer gives corners without a texture point NaN.
                    Some(&[u, v]) if u.is_nan() && v.is_nan() => CornerUvs::NONE,
                    None if (v as usize) < vertex_uvs && is_texture_point(self.draft.uvs[v as usize]) => v,
                    None if uvs.is_empty() && v as usize >= vertex_uvs => CornerUvs::NONE,
                    _ => {
                        self.bad_uvs += 1;
                        CornerUvs::NONE
                    }
                };
                self.draft.corner_uvs.push(uv);
            }
            self.draft.end_face();
            self.end_row();
        }
        if face_colors {
            self.draft.mended.push(Mended::LeftOut("face colors".into()));
        }
        Ok(())
    }

    fn strips(&mut self, element: &Element) -> Result<(), Fault> {
        let mut values = Vec::new();
        for _ in 0..element.rows() {
            for property in &element.properties {
                self.source.property(property, &mut values)?;
                if property.name == "vertex_indices" || property.name == "vertex_index" {
                    let mut strip = Vec::with_capacity(values.len());
                    for &value in &values {
                        strip.push(if value < 0.0 { None } else { Some(self.index(value)?) });
                    }
                    self.draft.push_strip(strip.into_iter().map(Ok))?;
                }
            }
            self.end_row();
        }
        let vertex_uvs = self.draft.uvs.len();
        let has_uvs = vertex_uvs == self.vertices && vertex_uvs > 0;
        for corner in self.draft.corner_uvs.len()..self.draft.corners.len() {
            let v = self.draft.corners[corner];
            let uv = match has_uvs {
                true if is_texture_point(self.draft.uvs[v as usize]) => v,
                true => {
                    self.bad_uvs += 1;
                    CornerUvs::NONE
                }
                false => CornerUvs::NONE,
            };
            self.draft.corner_uvs.push(uv);
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        let mut values = Vec::new();
        for _ in 0..element.rows() {
            for property in &element.properties {
                self.source.property(property, &mut values)?;
            }
            self.end_row();
        }
        Ok(())
    }

    fn end_row(&mut self) {
        self.long_rows += usize::from(self.source.end_row());
    }
}
