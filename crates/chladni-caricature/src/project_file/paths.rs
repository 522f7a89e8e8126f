//! Paths in a project file: written from its folder on, read as absolute ones.

use std::path::{Component, Path, PathBuf};

use crate::{CaricatureError, Template};

/// The folder of a project file.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => PathBuf::from("."),
    }
}

/// `file` as it is written into a project in `folder`: relative, with forward slashes.
pub(super) fn relative_text(file: &Path, folder: &Path) -> Result<String, CaricatureError> {
    let relative = relative(file, folder).unwrap_or_else(|| tidy(file));
    let parts = relative.iter().map(|part| part.to_str());
    let parts: Option<Vec<&str>> = parts.collect();
    let parts = parts.ok_or_else(|| CaricatureError::NotUnicode(file.into()))?;
    let text = if relative.has_root() { relative.display().to_string() } else { parts.join("/") };
    // A file may be called like a template.
    let is_file = matches!(text.parse(), Ok(Template::File(_)));
    Ok(if is_file { text } else { format!("./{text}") })
}

/// `file` of a project in `folder` as an absolute path, without asking the file system.
pub(super) fn resolved(file: &Path, folder: &Path) -> PathBuf {
    tidy(&whole(&folder.join(file)))
}

/// `path` from the root on. In a page there are no folders, so that it stays as it was written.
fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// The way from `folder` to `file`; `None` where there is none, as between two drives.
fn relative(file: &Path, folder: &Path) -> Option<PathBuf> {
    let (file, folder) = (tidy(&whole(file)), tidy(&whole(folder)));
    let (file, folder): (Vec<_>, Vec<_>) = (file.components().collect(), folder.components().collect());
    let shared = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let up = folder[shared..].iter().map(|_| Component::ParentDir);
    Some(up.chain(file[shared..].iter().copied()).collect())
}

/// Removes `.` and `..` from a path without asking the file system; what leads out of a relative one stays.
fn tidy(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir
                if out.has_root() || matches!(out.components().next_back(), Some(Component::Normal(_))) =>
            {
                out.pop();
            }
            Component::CurDir => {}
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_project() {
        let text = |file: &str, folder: &str| relative_text(Path::new(file), Path::new(folder)).unwrap();
        assert_eq!(text("/a/b/head.obj", "/a/b"), "head.obj");
        assert_eq!(text("/a/c/./x/../head.obj", "/a/b/d"), "../../c/head.obj");
        assert_eq!(text("head.obj", "."), "head.obj");
        assert_eq!(text("/a/ellipsoid", "/a"), "./ellipsoid");
        assert_eq!(text("/a/self:scale=2", "/a"), "./self:scale=2");
    }

    /// A path is only tidied where the program has no current folder, as in a page.
    #[test]
    fn a_path_that_cannot_be_made_whole_is_only_tidied() {
        for (written, tidied) in [
            ("./head.obj", "head.obj"),
            ("./../a/head.obj", "../a/head.obj"),
            ("a/../../b", "../b"),
            ("/..", "/"),
        ] {
            assert_eq!(tidy(Path::new(written)), Path::new(tidied));
        }
    }
}
