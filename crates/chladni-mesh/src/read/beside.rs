//! Files that a mesh file names: glTF buffers, material libraries, textures.

use std::borrow::Cow;
use std::io;
use std::path::{Component, Path};

use chladni_task::{percent_decoded, read_file};

/// Their bytes, or why there are none, by that name.
pub(crate) type Beside<'a> = dyn Fn(&str) -> Result<Vec<u8>, String> + 'a;

/// `name` with `/` between its parts, and without `.` and `part/..`: one for all spellings of it.
pub(crate) fn plain_name(name: &str) -> String {
    // Names from Windows have backslashes.
    let name = name.replace('\\', "/");
    let root = if name.starts_with('/') { "/" } else { "" };
    let mut parts: Vec<&str> = Vec::new();
    for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
        if part == ".." && parts.last().is_some_and(|last| *last != "..") {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    format!("{root}{}", parts.join("/"))
}

/// The [plain name](plain_name) of the file that a glTF `uri` names; a `data:` URI stays as it is.
pub(crate) fn plain_uri(uri: &str) -> Cow<'_, str> {
    if uri.starts_with("data:") { Cow::Borrowed(uri) } else { Cow::Owned(plain_name(&percent_decoded(uri))) }
}

/// The name of a file that a mesh names, with `/` between its parts, if the file is in the folder of the mesh or below;
/// `None` elsewhere. Links are not looked at.
pub fn name_within(name: &str) -> Option<String> {
    let name = plain_name(name);
    // A plain name has `..` only at its start.
    let is_within = Path::new(&name).components().all(|part| matches!(part, Component::Normal(_)));
    is_within.then_some(name)
}

/// Reads the file that a mesh in `folder` calls `name`. It must lie in that folder or below, links followed: a mesh may
/// come from anywhere, and what it names may end up in what is sent on.
pub(crate) fn read_within(folder: &Path, name: &str, most_bytes: u64) -> Result<Vec<u8>, String> {
    let outside =
        || Err("it lies outside the folder of the mesh, which may name files in there only".to_owned());
    let Some(name) = name_within(name) else { return outside() };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let read = || -> io::Result<Option<Vec<u8>>> {
        let file = folder.join(&name).canonicalize()?;
        if !file.starts_with(folder.canonicalize()?) {
            return Ok(None);
        }
        read_file(&file, most_bytes).map(Some)
    };
    match read() {
        Ok(Some(bytes)) => Ok(bytes),
        Ok(None) => outside(),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_one_plain_spelling() {
        for uri in ["a.bin", "./a.bin", "%61.bin", "b/../a.bin", ".//b\\.\\..\\a.bin"] {
            assert_eq!(plain_uri(uri), "a.bin", "{uri}");
        }
        for (name, plain) in
            [("../a/./../b", "../b"), ("/../a", "/../a"), ("a/../..", ".."), ("//a//b", "/a/b")]
        {
            assert_eq!(plain_name(name), plain);
        }
        assert_eq!(plain_uri("data:,a/../b"), "data:,a/../b");
    }

    #[test]
    fn a_mesh_names_files_in_its_folder_only() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("mesh");
        std::fs::create_dir_all(folder.join("textures")).unwrap();
        let secret = home.path().join("secret.png");
        for (path, text) in [(&secret, "secret"), (&folder.join("textures/skin.png"), "skin")] {
            std::fs::write(path, text).unwrap();
        }
        let read = |name: &str| read_within(&folder, name, 100);
        for name in ["textures/skin.png", "textures\\skin.png", "./textures/../textures/skin.png"] {
            assert_eq!(read(name).unwrap(), b"skin", "{name}");
        }
        let absolute = secret.display().to_string();
        for name in [
            "../secret.png",
            "textures/../../secret.png",
            "..\\secret.png",
            &absolute,
            "//server/share/x.png",
        ] {
            assert!(read(name).unwrap_err().contains("outside"), "{name}");
        }
        assert!(!read("textures/none.png").unwrap_err().contains("outside"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&secret, folder.join("link.png")).unwrap();
            std::os::unix::fs::symlink("textures/skin.png", folder.join("near.png")).unwrap();
            assert!(read("link.png").unwrap_err().contains("outside"));
            assert_eq!(read("near.png").unwrap(), b"skin");
        }
    }
}
