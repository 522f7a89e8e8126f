//! Closed doors: by no name does a mesh reach a file outside its folder, or one that never ends.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::Path;
use std::sync::mpsc::channel;

use chladni_mesh::{Loaded, MeshError, load_mesh};
use chladni_testdata::HANGS;

/// In all that must not be read.
const SECRET: &str = "SECRET";
/// The first coordinate of a secret vertex, as its bytes.
const COORDINATE_BYTES: [u8; 4] = *b"SECR";

/// What names another file, and how that must begin to be read.
#[derive(Clone, Copy, Debug)]
enum Door {
    Buffer,
    Image,
    Library,
    LibraryPicture,
    PlyPicture,
}

const DOORS: [Door; 5] = [Door::Buffer, Door::Image, Door::Library, Door::LibraryPicture, Door::PlyPicture];

impl Door {
    /// The content of a file that would be read by this door.
    fn secret(self) -> Vec<u8> {
        match self {
            Self::Buffer => SECRET.bytes().cycle().take(36).collect(),
            Self::Library => format!("newmtl skin\nmap_Kd {SECRET}.png\n").into(),
            Self::Image | Self::LibraryPicture | Self::PlyPicture => {
                [b"\x89PNG\r\n\x1a\n", SECRET.as_bytes()].concat()
            }
        }
    }

    /// Writes the mesh that names `name` into `folder` and reads it.
    fn opened(self, folder: &Path, name: &str) -> Result<Loaded, MeshError> {
        let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl skin\nf 1/1 2/1 3/1\n";
        let (file, text) = match self {
            Self::Buffer => ("mesh.gltf", gltf(name, "x.png")),
            Self::Image => {
                let corners = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
                ("mesh.gltf", gltf(&format!("data:application/octet-stream;base64,{corners}"), name))
            }
            Self::Library => ("mesh.obj", format!("mtllib {name}\n{corners}")),
            Self::LibraryPicture => {
                fs::write(folder.join("own.mtl"), format!("newmtl skin\nmap_Kd {name}\n")).unwrap();
                ("mesh.obj", format!("mtllib own.mtl\n{corners}"))
            }
            Self::PlyPicture => {
                let xyz = "property float x\nproperty float y\nproperty float z\n";
                let faces = "element face 1\nproperty list uchar int vertex_indices\n";
                let rows = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
                let head = format!("ply\nformat ascii 1.0\ncomment TextureFile {name}\nelement vertex 3\n");
                ("mesh.ply", format!("{head}{xyz}{faces}end_header\n{rows}"))
            }
        };
        let path = folder.join(file);
        fs::write(&path, text).unwrap();
        let (done, waits) = channel();
        std::thread::spawn(move || done.send(load_mesh(&path)).ok());
        waits.recv_timeout(HANGS).expect("it is read or refused")
    }
}

fn gltf(buffer: &str, image: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}},
        "meshes": [{{"primitives": [{{"material": 0, "attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "buffers": [{{"byteLength": 36, "uri": {buffer:?}}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
        "textures": [{{"source": 0}}], "images": [{{"uri": {image:?}}}]}}"#
    )
}

/// Whether anything of a secret is in what was read, or in what is said of it.
fn holds_secret(read: &Result<Loaded, MeshError>) -> bool {
    let Ok(loaded) = read else { return format!("{read:?}").contains(SECRET) };
    let coordinate = f64::from(f32::from_le_bytes(COORDINATE_BYTES));
    let textures = || loaded.mesh.appearance.materials.iter().filter_map(|m| m.base_color_texture.as_ref());
    loaded.mesh.positions.iter().any(|p| p[0] == coordinate)
        || textures().any(|texture| texture.bytes.windows(SECRET.len()).any(|at| at == SECRET.as_bytes()))
        || textures().any(|texture| texture.name.contains(SECRET))
        || loaded.mended.iter().any(|mended| mended.to_string().contains(SECRET))
}

#[test]
fn each_door_reads_what_lies_in_the_folder() {
    for door in DOORS {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("inside"), door.secret()).unwrap();
        let read = door.opened(home.path(), "inside");
        assert!(read.is_ok() && holds_secret(&read), "{door:?}: {read:?}");
    }
}

#[test]
fn no_name_leads_out_of_the_folder() {
    for door in DOORS {
        let home = tempfile::tempdir().unwrap();
        let (folder, secret) = (home.path().join("mesh"), home.path().join("secret"));
        fs::create_dir_all(folder.join("below")).unwrap();
        fs::write(&secret, door.secret()).unwrap();
        let secret = secret.to_str().unwrap();
        let mut names: Vec<String> = [
            "../secret",
            "..\\secret",
            "below/../../secret",
            "%2e%2e/secret",
            "..%2Fsecret",
            "..%5csecret",
            r"\\server\share\s",
            "//server/share/s",
            r"\\?\C:\s",
            r"\\.\pipe\s",
            "C:s",
            "C:/s",
            "NUL",
        ]
        .map(str::to_owned)
        .into();
        names.extend([secret.to_owned(), format!("file://{secret}"), format!("file:{secret}")]);
        #[cfg(unix)]
        names.extend(unix::names(&folder));
        for name in names {
            let read = door.opened(&folder, &name);
            assert!(!holds_secret(&read), "{door:?} reads {name}: {read:?}");
            let is_silent = read.as_ref().is_ok_and(|loaded| loaded.mended.is_empty());
            assert!(!is_silent, "{door:?} says nothing of {name}: {read:?}");
        }
    }
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::symlink;
    use std::path::Path;
    use std::process::Command;

    /// Names in `folder` of links out of it, of a device, and of a pipe that nobody writes into, where mkfifo makes one.
    #[allow(clippy::print_stdout, reason = "a skipped part must say so")]
    pub fn names(folder: &Path) -> Vec<String> {
        let targets =
            [("../secret", "link"), ("../..", "below/up"), ("/dev/zero", "zero"), ("link", "chain")];
        for (target, link) in targets {
            symlink(target, folder.join(link)).unwrap();
        }
        let mut names = vec!["link", "below/up/secret", "zero", "chain", "/dev/zero"];
        let made = Command::new("mkfifo").arg(folder.join("pipe")).status();
        if made.is_ok_and(|made| made.success()) {
            names.push("pipe");
        } else {
            println!("skipped: a pipe, which mkfifo does not make here");
        }
        names.into_iter().map(str::to_owned).collect()
    }
}
