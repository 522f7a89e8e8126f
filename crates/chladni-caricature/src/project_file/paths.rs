//! Paths in a project file: written from its folder on, read as absolute ones.

use std::path::{Component, Path, PathBuf};

use chladni_task::{folder_of, where_it_leads};

use crate::{CaricatureError, Template};

/// `file` as it is written into the file of a project: relative to its folder, with forward slashes.
pub(super) fn relative_text(file: &Path, project: &Path) -> Result<String, CaricatureError> {
    let relative = relative_path(file, project).unwrap_or_else(|| tidy(file));
    let parts = relative.iter().map(|part| part.to_str());
    let parts: Option<Vec<&str>> = parts.collect();
    let parts = parts.ok_or_else(|| CaricatureError::NotUnicode(file.into()))?;
    let text = if relative.has_root() { relative.display().to_string() } else { parts.join("/") };
    // A file may be called like a template.
    let is_file = matches!(text.parse(), Ok(Template::File(_)));
    Ok(if is_file { text } else { format!("./{text}") })
}

/// The way from the folder of `project` to `file`, as it is spelled. Where links make that lead elsewhere, it is the way
/// between their real places, by which the file is found however the project is opened.
fn relative_path(file: &Path, project: &Path) -> Option<PathBuf> {
    let spelled = relative(file, folder_of(project));
    let Some((folder, file)) = real_folder(project).zip(real_place(file)) else { return spelled };
    let leads_there = |way: &PathBuf| real_place(&tidy(&folder.join(way))).as_ref() == Some(&file);
    spelled.filter(leads_there).or_else(|| relative(&file, &folder))
}

/// `file` as the file of a project names it, as an absolute path: spelled like that of the project, unless links make that
/// lead elsewhere.
pub(super) fn resolved(file: &Path, project: &Path) -> PathBuf {
    let spelled = tidy(&whole(&folder_of(project).join(file)));
    let Some(folder) = real_folder(project) else { return spelled };
    let real = tidy(&folder.join(file));
    let is_elsewhere = real_place(&real) != real_place(&spelled);
    // Projects of older versions may have names that are right as they are spelled.
    if is_elsewhere && (real.exists() || !spelled.exists()) { real } else { spelled }
}

/// The folder of the file that `project` leads to, without links; `None` where none can be asked for. On Windows, such a
/// name begins in a way that people do not write.
fn real_folder(project: &Path) -> Option<PathBuf> {
    if cfg!(unix) { folder_of(&where_it_leads(project)).canonicalize().ok() } else { None }
}

/// The place of `file`, in a folder without links.
fn real_place(file: &Path) -> Option<PathBuf> {
    Some(folder_of(file).canonicalize().ok()?.join(file.file_name()?))
}

/// `path` from the root on. In a page there are no folders, so that it stays as it was written.
pub(super) fn whole(path: &Path) -> PathBuf {
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
        let text = |file: &str, project: &str| relative_text(Path::new(file), Path::new(project)).unwrap();
        assert_eq!(text("/a/b/head.obj", "/a/b/p.chladni"), "head.obj");
        assert_eq!(text("/a/c/./x/../head.obj", "/a/b/d/p.chladni"), "../../c/head.obj");
        assert_eq!(text("head.obj", "p.chladni"), "head.obj");
        assert_eq!(text("/a/ellipsoid", "/a/p.chladni"), "./ellipsoid");
        assert_eq!(text("/a/self:scale=2", "/a/p.chladni"), "./self:scale=2");
    }

    #[cfg(unix)]
    #[test]
    fn a_mesh_is_found_through_links_and_at_its_real_place() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["data/scans/proj", "home"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for name in ["data/scans/head.obj", "data/scans/proj/p.chladni"] {
            std::fs::write(at(name), "").unwrap();
        }
        symlink("../data/scans/proj", at("home/proj")).unwrap();
        symlink("../data/scans/proj/p.chladni", at("home/linked.chladni")).unwrap();
        let head = at("data/scans/head.obj");
        for name in
            ["data/scans/proj/p.chladni", "home/proj/p.chladni", "home/linked.chladni", "home/proj/new"]
        {
            assert_eq!(relative_text(&head, &at(name)).unwrap(), "../head.obj", "{name}");
            let found = resolved(Path::new("../head.obj"), &at(name));
            assert_eq!(found.canonicalize().unwrap(), head.canonicalize().unwrap(), "{name}");
        }
        // As it was written before, and beside the project as it is spelled.
        let project = at("home/proj/p.chladni");
        assert_eq!(resolved(Path::new("../../data/scans/head.obj"), &project), head);
        assert_eq!(resolved(Path::new("mean.obj"), &project), at("home/proj/mean.obj"));
        assert_eq!(relative_text(&at("home/proj/mean.obj"), &project).unwrap(), "mean.obj");
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
