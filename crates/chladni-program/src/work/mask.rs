//! Regions in files: a number from 0 to 1 for each vertex of a mesh's file, as other programs paint and read them.

use std::path::Path;

use chladni_caricature::Painted;
use chladni_harmonics::npz::{MOST_BYTES, array_names, npy_of, npz_of, numbers_in};
use chladni_mesh::surface::places;
use chladni_mesh::{
    Attribute, Format, Loaded, Mended, ShapeSource, TriMesh, nothing_beside, read_named_mesh, save_mesh,
    weld, write_mesh,
};

use super::formats::ends_in;
use super::sculpture::leave_out_materials;
use super::{Error, Subject};

/// The default name of masks in archives and meshes.
pub const MASK: &str = "mask";

/// Endings of the files that masks are read from.
pub const READ: [&str; 6] = ["npy", "npz", "ply", "obj", "off", "glb"];
/// Endings of the files that masks are written to.
pub const WRITTEN: [&str; 5] = ["npy", "npz", "ply", "obj", "glb"];

/// How much of a shape a mask takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Masked {
    /// Vertices above 0.
    pub inside: usize,
    /// All.
    pub vertices: usize,
}

fn refused(path: &Path, why: impl std::fmt::Display) -> Error {
    Error::input(format_args!("{}: {why}", path.display()))
}

/// χ01 from the file at `path`, for a shape: of an array, of the array `channel` of an archive, or of the attribute or
/// color channel `channel` of a mesh with as many vertices. Without a name it is `mask`, or, of a mesh that has none, red;
/// where there is neither, the only one of the file.
///
/// # Errors
/// [`Error::Input`] where that is not there, has another number of values, or one outside [0, 1].
pub fn read(path: &Path, channel: Option<&str>, subject: &Subject) -> Result<Painted, Error> {
    let vertices = subject.whole().positions.len();
    let values = match Format::of_path(path) {
        Some(format) => of_mesh(path, &ShapeSource::named(path).load(None)?, format, channel)?,
        None if channel.is_some() && ends_in(path, &["npy"]) => {
            return Err(refused(path, "is one array: --mask-channel is for an .npz or a mesh"));
        }
        None => {
            let bytes = chladni_task::read_file(path, MOST_BYTES);
            let bytes = bytes.map_err(|why| unreadable(path, vertices, why))?;
            of_array(path, &bytes, vertices, channel)?
        }
    };
    painted(values, subject).map_err(|why| refused(path, why))
}

/// χ01 from the `bytes` of a file called `name`, as [`read`] finds it without a channel. Files that it names are not there.
///
/// # Errors
/// As [`read`].
pub fn read_in(name: &Path, bytes: &[u8], subject: &Subject) -> Result<Painted, Error> {
    let vertices = subject.whole().positions.len();
    let values = match Format::of_path(name) {
        Some(format) => of_mesh(name, &read_named_mesh(name, bytes, &nothing_beside)?, format, None)?,
        None => of_array(name, bytes, vertices, None)?,
    };
    painted(values, subject).map_err(|why| refused(name, why))
}

/// A channel of a mesh whose file's name says `format`.
fn of_mesh(path: &Path, loaded: &Loaded, format: Format, channel: Option<&str>) -> Result<Vec<f64>, Error> {
    let misnamed = |mended: &Mended| match mended {
        Mended::Misnamed(format) => Some(*format),
        _ => None,
    };
    let format = loaded.mended.iter().find_map(misnamed).unwrap_or(format);
    let mesh = &loaded.mesh;
    let known: Vec<&str> = mesh.channels().collect();
    let found = match (channel, &known[..]) {
        (Some(channel), _) | (None, &[channel]) => mesh.channel(channel, format),
        (None, _) => mesh.channel(MASK, format).or_else(|| mesh.channel("red", format)),
    };
    found.ok_or_else(|| refused(path, no_channel(mesh, channel)))
}

/// An array of a file.
fn of_array(path: &Path, bytes: &[u8], vertices: usize, channel: Option<&str>) -> Result<Vec<f64>, Error> {
    let names = array_names(bytes);
    let name = match (channel, &names[..]) {
        (Some(channel), _) => channel,
        (None, [only]) => only.as_str(),
        (None, _) => MASK,
    };
    numbers_in(bytes, name, vertices).map_err(|why| {
        if names.is_empty() || names.iter().any(|known| known == name) {
            return unreadable(path, vertices, why);
        }
        let known = names.join(", ");
        unreadable(path, vertices, format_args!("{why}; it has {known}{}", how_to_choose(channel)))
    })
}

fn unreadable(path: &Path, vertices: usize, why: impl std::fmt::Display) -> Error {
    let mask = format_args!("no mask, a number for each of the {vertices} vertices, can be read from it");
    refused(path, format_args!("{mask}: {why}"))
}

fn no_channel(mesh: &TriMesh, channel: Option<&str>) -> String {
    let known: Vec<&str> = mesh.channels().collect();
    let known =
        if known.is_empty() { "nothing".to_owned() } else { known.join(", ") + how_to_choose(channel) };
    format!("its vertices have no {}; they have {known}", channel.unwrap_or("mask or color"))
}

/// How one of several is chosen, where none was named.
fn how_to_choose(channel: Option<&str>) -> &'static str {
    if channel.is_none() { " (on the command line, --mask-channel chooses)" } else { "" }
}

/// χ01 from a channel of the shape's own, whose file is of this `format`.
///
/// # Errors
/// As [`read`].
pub fn own(channel: &str, subject: &Subject, format: Format) -> Result<Painted, Error> {
    let mesh = subject.whole();
    let values = mesh.channel(channel, format);
    let values = values.ok_or_else(|| Error::input(no_channel(mesh, Some(channel))))?;
    painted(values, subject).map_err(|why| Error::input(format_args!("{channel}: {why}")))
}

/// `values` at the vertices of the whole shape, on those that are worked on.
fn painted(values: Vec<f64>, subject: &Subject) -> Result<Painted, Error> {
    let whole = subject.whole();
    let vertices = whole.positions.len();
    if values.len() != vertices {
        let found = values.len();
        let why = format_args!("a mask has a number for each of the {vertices} vertices, this has {found}");
        return Err(Error::input(why));
    }
    if let Some((vertex, value)) = values.iter().enumerate().find(|(_, x)| !(0.0..=1.0).contains(*x)) {
        return Err(Error::input(format_args!("a mask lies in [0, 1], at vertex {vertex} it is {value}")));
    }
    let own = weld(&subject.mesh).operator_vertex;
    let operator_vertex: Vec<Option<u32>> = match &subject.proxy {
        None => own,
        Some(proxy) => {
            // Each vertex of the whole shape is the one of the proxy in its place, if there is one.
            let place = places(&whole.positions);
            let mut there = vec![None; vertices];
            for (vertex, of) in proxy.whole_vertex().iter().zip(own) {
                there[place[*vertex as usize] as usize] = of;
            }
            place.iter().map(|first| there[*first as usize]).collect()
        }
    };
    let takes_some = values.iter().any(|x| *x > 0.0);
    let painted = Painted::of_file(values.into_iter().map(|x| x as f32), &operator_vertex);
    if subject.proxy.is_some()
        && takes_some
        && let Painted::Vertices(values) = &painted
        && !values.iter().any(|x| *x > 0.0)
    {
        return Err(Error::input(
            "none of its vertices above 0 is among those that are worked on: work on more of them (--proxy)",
        ));
    }
    Ok(painted)
}

/// Whether no vertex that is worked on is above 0.
pub fn is_empty(painted: &Painted, subject: &Subject) -> bool {
    !matches!(painted, Painted::Everywhere)
        && !painted.values(&weld(&subject.mesh).positions).iter().any(|x| *x > 0.0)
}

/// Writes χ01 of a shape to `path`: an array, an archive with the array `mask`, a PLY with the attribute `mask`, or, as OBJ
/// and GLB, and as PLY where `as_colors`, a mesh without materials whose vertices are gray, from black (0) to white (1). 0
/// where no triangle uses a vertex.
///
/// # Errors
/// [`Error::Input`] for another ending, or a region that was painted on another number of vertices;
/// [`Error::Unwritten`] and [`Error::Unsaved`] with the file's name.
pub fn write(path: &Path, painted: &Painted, subject: &Subject, as_colors: bool) -> Result<Masked, Error> {
    check(path)?;
    let (values, masked) = on_whole(painted, subject)?;
    let Some(format) = Format::of_path(path) else {
        let bytes = if ends_in(path, &["npz"]) { archive_of(&values) } else { npy_of(&values) };
        let written = bytes.and_then(|bytes| chladni_task::write_atomic(path, &bytes));
        return written.map(|()| masked).map_err(|error| Error::unwritten(path, error));
    };
    let mesh = mesh_with(values, subject, format, as_colors);
    save_mesh(&mesh, path).map(|()| masked).map_err(Error::unsaved)
}

/// The same in memory, as an array (`npy`), an archive (`npz`) or a mesh (`ply`, `obj`, `glb`).
///
/// # Errors
/// As [`write()`].
pub fn to_bytes(ending: &str, painted: &Painted, subject: &Subject) -> Result<(Vec<u8>, Masked), Error> {
    let (values, masked) = on_whole(painted, subject)?;
    let bytes = match Format::from_extension(ending).filter(|_| WRITTEN.contains(&ending)) {
        Some(format) => write_mesh(&mesh_with(values, subject, format, false), format)?,
        None if ending == "npy" => npy_of(&values).map_err(|error| refused(Path::new(MASK), error))?,
        None if ending == "npz" => archive_of(&values).map_err(|error| refused(Path::new(MASK), error))?,
        None => return Err(Error::input(format_args!("masks are not written as {ending} in memory"))),
    };
    Ok((bytes, masked))
}

/// An archive of one array.
fn archive_of(values: &[f32]) -> std::io::Result<Vec<u8>> {
    npz_of(|npz| npz.array(MASK, &[values.len() as u64], values.iter().copied()))
}

/// χ01 at the vertices of all of the shape.
fn on_whole(painted: &Painted, subject: &Subject) -> Result<(Vec<f32>, Masked), Error> {
    let welded = weld(&subject.mesh);
    let values = painted.values(&welded.positions);
    let vertices = welded.positions.len();
    if values.len() != vertices {
        let found = values.len();
        let why = format_args!("the region was painted on {found} vertices, the shape has {vertices}");
        return Err(Error::input(why));
    }
    let of = |vertex: &Option<u32>| vertex.and_then(|v| values.get(v as usize)).copied().unwrap_or(0.0);
    let on_mesh: Vec<f32> = welded.operator_vertex.iter().map(of).collect();
    let on_whole = subject.proxy.as_ref().map(|proxy| proxy.spread(&on_mesh));
    let counted = on_whole.as_deref().unwrap_or(&on_mesh);
    let masked = Masked { inside: counted.iter().filter(|x| **x > 0.0).count(), vertices: counted.len() };
    Ok((on_whole.unwrap_or(on_mesh), masked))
}

/// The shape with these numbers as its attribute, or its colors.
fn mesh_with(values: Vec<f32>, subject: &Subject, format: Format, as_colors: bool) -> TriMesh {
    let values: Vec<f64> = values.into_iter().map(f64::from).collect();
    let mut mesh = TriMesh::clone(subject.whole());
    if as_colors || format != Format::Ply {
        mesh.set_gray(&values, format);
        // Viewers would multiply the gray with their pictures, and an OBJ in memory has no library.
        leave_out_materials(&mut mesh);
        mesh.appearance.uvs = None;
    } else {
        mesh.appearance.attributes.retain(|attribute| attribute.name != MASK);
        mesh.appearance.attributes.push(Attribute { name: MASK.into(), values });
    }
    mesh
}

/// Whether a mask can be written at a path of that name.
///
/// # Errors
/// [`Error::Input`] where not.
pub fn check(path: &Path) -> Result<(), Error> {
    match ends_in(path, &WRITTEN) {
        true => Ok(()),
        false => Err(refused(path, format_args!("a mask ends in one of {}", WRITTEN.join(", ")))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_caricature::{Project, ProxyKey, Resolution};
    use chladni_mesh::samples::{icosphere, sample};
    use chladni_task::Task;

    use crate::work::Aside;

    #[test]
    fn masks_come_back_from_every_kind_of_file() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = Subject::from(sample("template").unwrap());
        let welded = weld(&mesh.mesh);
        let values: Vec<f32> = (0..welded.positions.len()).map(|v| (v % 256) as f32 / 255.0).collect();
        let painted = Painted::Vertices(values.as_slice().into());
        for (name, as_colors, off) in [
            ("a.npy", false, 0.0),
            ("a.npz", false, 0.0),
            ("a.ply", false, 0.0),
            ("b.ply", true, 1e-6),
            ("a.obj", false, 1e-6),
            ("a.glb", false, 0.0),
        ] {
            let path = folder.path().join(name);
            write(&path, &painted, &mesh, as_colors).unwrap();
            let back = read(&path, None, &mesh).unwrap().values(&welded.positions);
            let farthest = values.iter().zip(&*back).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(farthest <= off, "{name}: {farthest}");
            let bytes = std::fs::read(&path).unwrap();
            let in_memory = read_in(Path::new(name), &bytes, &mesh).unwrap();
            assert_eq!(in_memory.values(&welded.positions), back, "{name}");
            if !as_colors {
                let ending = path.extension().unwrap().to_str().unwrap();
                assert_eq!(to_bytes(ending, &painted, &mesh).unwrap().0, bytes, "{name}");
            }
            let other = Subject::from(sample("octopus").unwrap());
            assert!(
                read(&path, None, &other).unwrap_err().to_string().contains("a number for each"),
                "{name}"
            );
        }
        let why = |name: &str, channel| read(&folder.path().join(name), Some(channel), &mesh).unwrap_err();
        assert!(why("a.ply", "weight").to_string().contains("no weight; they have mask"));
        assert!(why("a.npz", "weight").to_string().contains("no array \"weight\""));
        let odd = write(&folder.path().join("a.stl"), &painted, &mesh, false);
        assert!(odd.unwrap_err().to_string().contains("ends in one of"));
    }

    #[test]
    fn the_only_numbers_of_a_file_are_the_mask_and_several_are_named() {
        let mut mesh = icosphere(1);
        let ramp: Vec<f64> = (0..mesh.positions.len()).map(|v| f64::from(u8::from(v % 2 == 0))).collect();
        let subject = Subject::from(mesh.clone());
        let expected = Painted::of_file(ramp.iter().map(|x| *x as f32), &weld(&mesh).operator_vertex);
        let attribute = |name: &str| Attribute { name: name.into(), values: ramp.clone() };
        let ply = |mesh: &TriMesh| write_mesh(mesh, Format::Ply).unwrap();
        let npz = |names: &[&str]| {
            let shape = [ramp.len() as u64];
            npz_of(|npz| names.iter().try_for_each(|name| npz.array(name, &shape, ramp.iter().copied())))
                .unwrap()
        };
        let read = |name: &str, bytes: &[u8]| read_in(Path::new(name), bytes, &subject);
        mesh.appearance.attributes = vec![attribute("nosey")];
        assert_eq!(read("a.ply", &ply(&mesh)).unwrap(), expected);
        assert_eq!(read("a.npz", &npz(&["nosey"])).unwrap(), expected);
        mesh.appearance.attributes.push(attribute("chin"));
        for why in [read("a.ply", &ply(&mesh)), read("a.npz", &npz(&["nosey", "chin"]))] {
            let why = why.unwrap_err().to_string();
            assert!(why.contains("nosey, chin") && why.contains("--mask-channel"), "{why}");
        }
        assert_eq!(read("a.npz", &npz(&["nosey", "mask"])).unwrap(), expected);
    }

    #[test]
    fn counts_are_those_of_the_file() {
        // A vertex of a seam is there twice.
        let mut mesh = icosphere(1);
        let welded = mesh.positions.len();
        mesh.positions.push(mesh.positions[0]);
        *mesh.triangles.iter_mut().flatten().find(|v| **v == 0).unwrap() = welded as u32;
        let painted = Painted::Vertices(vec![1.0; welded].into());
        let (_, masked) = to_bytes("npy", &painted, &Subject::from(mesh)).unwrap();
        assert_eq!(masked, Masked { inside: welded + 1, vertices: welded + 1 });
    }

    #[test]
    fn a_gray_mesh_has_no_materials() {
        let mut mesh = icosphere(1);
        let count = mesh.triangles.len();
        mesh.appearance.materials = vec![chladni_mesh::Material::named("skin")];
        mesh.appearance.face_materials = vec![Some(0); count];
        let painted = Painted::Vertices(vec![0.5; mesh.positions.len()].into());
        let subject = Subject::from(mesh);
        let (bytes, _) = to_bytes("obj", &painted, &subject).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.contains("mtllib") && !text.contains("usemtl"), "{text}");
        let mesh = mesh_with(vec![0.5; 42], &subject, Format::Glb, false);
        assert!(mesh.appearance.materials.is_empty() && mesh.appearance.colors.is_some());
    }

    #[test]
    fn vertices_in_one_place_take_the_largest_value_on_a_proxy_too() {
        // Every vertex twice; only the second of each is masked.
        let mut mesh = icosphere(3);
        let n = mesh.positions.len();
        mesh.positions.extend(mesh.positions.clone());
        mesh.triangles.iter_mut().step_by(2).flatten().for_each(|v| *v += n as u32);
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 4);
        project.resolution = Resolution::Proxy(ProxyKey { vertices: 200, fingerprint: None });
        let task = Task::new();
        let subject = Subject::of_mesh(mesh, &mut project, &Aside::new(&task)).unwrap();
        let values = (0..2 * n).map(|v| if v < n { 0.0 } else { 1.0 }).collect();
        let Painted::Vertices(painted) = painted(values, &subject).unwrap() else { panic!() };
        assert!(subject.proxy.is_some() && painted.iter().all(|x| *x == 1.0));
    }

    #[test]
    fn a_mask_that_the_proxy_misses_is_refused_and_an_empty_one_is_not() {
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 4);
        project.resolution = Resolution::Proxy(ProxyKey { vertices: 200, fingerprint: None });
        let task = Task::new();
        let subject = Subject::of_mesh(icosphere(3), &mut project, &Aside::new(&task)).unwrap();
        let kept = subject.proxy.as_ref().unwrap().whole_vertex();
        let n = subject.whole().positions.len();
        let missed = (0..n).find(|v| !kept.contains(&(*v as u32))).unwrap();
        let of = |inside: Option<usize>| {
            let values = (0..n).map(|v| f64::from(u8::from(inside == Some(v)))).collect();
            painted(values, &subject)
        };
        let why = of(Some(missed)).unwrap_err().to_string();
        assert!(why.contains("--proxy"), "{why}");
        assert!(of(Some(kept[0] as usize)).is_ok() && of(None).is_ok());
    }

    #[test]
    fn a_mesh_is_masked_by_its_own_numbers_where_they_are_shares() {
        let mut mesh = sample("template").unwrap();
        let ramp: Vec<f64> = (0..mesh.positions.len()).map(|v| f64::from(u8::from(v % 2 == 0))).collect();
        let attribute = |name: &str, values: Vec<f64>| Attribute { name: name.into(), values };
        mesh.appearance.attributes = vec![
            attribute("weight", ramp.clone()),
            attribute("quality", ramp.iter().map(|x| 7.0 * x).collect()),
        ];
        let mesh = Subject::from(mesh);
        let expected = Painted::of_file(ramp.iter().map(|x| *x as f32), &weld(&mesh.mesh).operator_vertex);
        assert_eq!(own("weight", &mesh, Format::Ply).unwrap(), expected);
        assert!(own("quality", &mesh, Format::Ply).unwrap_err().to_string().contains("it is 7"));
        assert!(own("red", &mesh, Format::Ply).is_err());
    }
}
