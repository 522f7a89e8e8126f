//! Names of files at which Windows asks another machine, or a device.

use std::path::Path;

/// Whether to look for the file `named` by a document in `folder` would have Windows ask another machine, or a device:
/// `\\server\share\…`, `\\?\…`, `\\.\…`. The question alone shows that machine who asks. What lies on the share that the
/// document itself lies on is as near as the document.
///
/// Only the text is looked at. Names with backslashes are known on every system, as documents move between them.
///
/// ```
/// use std::path::Path;
///
/// let asks = |named: &str, folder: &str| chladni_task::asks_another_machine(Path::new(named), Path::new(folder));
/// assert!(asks(r"\\server\share\a.obj", r"C:\shapes"));
/// assert!(!asks(r"\\server\share\a.obj", r"\\server\share\shapes"));
/// assert!(!asks("shapes/a.obj", "/home/ernst"));
/// ```
pub fn asks_another_machine(named: &Path, folder: &Path) -> bool {
    let place = |path: &Path| place_of(&path.to_string_lossy());
    place(named).is_some_and(|there| place(folder) != Some(there))
}

/// The server and the share, or the device, that a path begins with, in one spelling; `None` where it begins with neither.
fn place_of(path: &str) -> Option<String> {
    let path = if cfg!(windows) { path.replace('/', r"\") } else { path.to_owned() };
    let path = path.to_lowercase();
    if !path.starts_with(r"\\") && !path.starts_with(r"\??\") {
        return None;
    }
    let parts: Vec<&str> = path.split('\\').filter(|part| !part.is_empty()).collect();
    let place = match parts[..] {
        ["?" | "??" | ".", "unc", ..] => &parts[2..],
        _ => &parts[..],
    };
    Some(place.iter().take(2).copied().collect::<Vec<_>>().join(r"\"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asks(named: &str, folder: &str) -> bool {
        asks_another_machine(Path::new(named), Path::new(folder))
    }

    #[test]
    fn other_machines_and_devices_are_known_by_their_names() {
        for named in [
            r"\\server\share\a.obj",
            r"\\server@SSL\share\a.obj",
            r"\\127.0.0.1\c$\a.obj",
            r"\\?\UNC\server\share\a.obj",
            r"\??\UNC\server\share\a.obj",
            r"\\?\C:\a.obj",
            r"\\.\pipe\a",
            r"\\",
        ] {
            for folder in ["", "/home/ernst", r"C:\shapes", r"\\server\other", r"\\other\share"] {
                assert!(asks(named, folder), "{named} in {folder}");
            }
        }
        for named in ["", "a.obj", r"..\a.obj", r"C:\a.obj", "C:a.obj", "/a.obj", r"\a.obj", r"a\\server\b"] {
            assert!(!asks(named, r"C:\shapes"), "{named}");
        }
        assert_eq!(asks("//server/share/a.obj", r"C:\shapes"), cfg!(windows));
    }

    #[test]
    fn the_share_of_the_document_is_no_other_machine() {
        for folder in [r"\\server\share", r"\\SERVER\Share\shapes", r"\\?\UNC\server\share\shapes"] {
            assert!(!asks(r"\\Server\share\songs\a.wav", folder), "{folder}");
        }
        assert!(asks(r"\\server\share2\a.wav", r"\\server\share"));
        assert!(!asks(r"\\?\C:\a.obj", r"\\?\C:\shapes"));
    }
}
