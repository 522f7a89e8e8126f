//! The state of the file window: a folder, the typed text, and the result.

use std::fs::DirEntry;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::studio::folders::whole_path;

/// The purpose of the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Purpose {
    /// A file to read.
    Open,
    /// Files to read.
    OpenSeveral,
    /// A file to write.
    Save,
}

/// The question, as it travels to the process that asks it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// The purpose.
    pub purpose: Purpose,
    /// Kinds of files: name and extensions without dots; a folder that is to be named has none.
    pub kinds: Vec<(String, Vec<String>)>,
    /// Where to begin: a folder, or the file to be written.
    pub start: PathBuf,
}

/// One line of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The file's or folder's name.
    pub name: String,
    /// Whether it is a folder.
    pub is_folder: bool,
}

/// The contents of a folder, as shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// Folders and fitting files, folders first.
    pub entries: Vec<Entry>,
    /// Whether there are more.
    pub is_cut: bool,
}

/// The outcome of confirming.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// These are the files.
    Done(Vec<PathBuf>),
    /// It was a folder, which is now shown.
    Entered,
    /// The file exists: confirm once more to replace it.
    Replaces(PathBuf),
    /// Why not.
    Refused(String),
}

/// Lines that are shown of a folder.
pub const MAX_ENTRIES: usize = 5000;

/// The state of the window.
#[derive(Debug)]
pub struct Browser {
    request: Request,
    folder: PathBuf,
    /// The typed text: a name, or a path from the folder, from `~` or from the root. After changing it, call
    /// [`Self::retyped`].
    pub typed: String,
    /// Names that were picked in the list.
    picked: Vec<String>,
    listing: Result<Listing, String>,
    agreed_to_replace: Option<PathBuf>,
}

impl Browser {
    /// Begins where `request` says, or in the current folder.
    pub fn new(request: Request) -> Self {
        let start = std::path::absolute(&request.start).unwrap_or_else(|_| PathBuf::from("/"));
        let mut start = whole_path(&start);
        let names_folder = request.purpose == Purpose::Save
            && request.kinds.iter().all(|(_, extensions)| extensions.is_empty());
        // A new folder has a name that nothing has yet.
        if let Some(name) = request.start.file_name().filter(|_| names_folder && start.exists()) {
            let name = name.to_string_lossy();
            let free =
                (2_u32..).map(|n| start.with_file_name(format!("{name}-{n}"))).find(|path| !path.exists());
            if let Some(free) = free {
                start = free;
            }
        }
        let (folder, typed) = if start.is_dir() {
            (start, String::new())
        } else {
            let name = start.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (start.parent().map_or_else(|| PathBuf::from("/"), Path::to_owned), name)
        };
        let typed = if request.purpose == Purpose::Save { typed } else { String::new() };
        let (listing, picked) = (Ok(Listing::default()), Vec::new());
        let mut browser = Self { request, folder, typed, picked, listing, agreed_to_replace: None };
        browser.read();
        browser
    }

    /// The question.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The folder that is shown.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The contents of the folder, or why it cannot be read.
    pub fn listing(&self) -> Result<&Listing, &str> {
        self.listing.as_ref().map_err(String::as_str)
    }

    /// Shows another folder.
    pub fn enter(&mut self, folder: &Path) {
        self.folder = whole_path(folder);
        self.retyped();
        if self.request.purpose != Purpose::Save {
            self.typed.clear();
        }
        self.read();
    }

    /// Shows the folder around this one.
    pub fn leave(&mut self) {
        if let Some(parent) = self.folder.parent().map(Path::to_owned) {
            self.enter(&parent);
        }
    }

    fn read(&mut self) {
        let listing = self.list(&self.folder, "", MAX_ENTRIES);
        self.listing = listing.map_err(|error| format!("{}: {error}", self.folder.display()));
    }

    /// Entries of `folder` that begin with `begun`; if there are more than `most`, any `most` of them.
    fn list(&self, folder: &Path, begun: &str, most: usize) -> io::Result<Listing> {
        let entry = |found: DirEntry| {
            let name = found.file_name().into_string().ok()?;
            if name.starts_with('.') || !name.starts_with(begun) {
                return None;
            }
            let kind = found.file_type().ok()?;
            // Follow links.
            let is_folder = kind.is_dir() || (kind.is_symlink() && found.path().is_dir());
            (is_folder || self.fits(&name)).then_some(Entry { name, is_folder })
        };
        let found = std::fs::read_dir(folder)?.flatten().filter_map(entry);
        let mut entries: Vec<Entry> = found.take(most + 1).collect();
        let is_cut = entries.len() > most;
        entries.truncate(most);
        entries.sort_by_cached_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
        Ok(Listing { entries, is_cut })
    }

    fn fits(&self, name: &str) -> bool {
        let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        let mut extensions = self.request.kinds.iter().flat_map(|(_, extensions)| extensions);
        extensions.any(|known| known.eq_ignore_ascii_case(extension))
    }

    /// The typed text has changed: it alone counts, and an earlier confirmation is void.
    pub fn retyped(&mut self) {
        self.picked.clear();
        self.agreed_to_replace = None;
    }

    /// Takes a file of the list, or one more of them; one that was taken `besides` is put back.
    pub fn pick(&mut self, name: &str, besides: bool) {
        let mut picked = std::mem::take(&mut self.picked);
        self.retyped();
        let besides = besides && self.request.purpose == Purpose::OpenSeveral;
        if !besides {
            picked.clear();
        }
        match picked.iter().position(|known| known == name) {
            Some(known) => drop(picked.remove(known)),
            None => picked.push(name.to_owned()),
        }
        self.typed = match &picked[..] {
            [] => String::new(),
            [one] => one.clone(),
            more => format!("{} files", more.len()),
        };
        self.picked = picked;
    }

    /// Whether `name` in the list is among what will be chosen.
    pub fn is_chosen(&self, name: &str) -> bool {
        self.typed == name || self.picked.iter().any(|picked| picked == name)
    }

    /// How many characters of the typed name come before its extension.
    pub fn stem_length(&self) -> usize {
        let stem = Path::new(&self.typed).file_stem().filter(|_| self.fits(&self.typed));
        let stem = stem.map_or_else(|| self.typed.as_str().into(), |stem| stem.to_string_lossy());
        stem.chars().count()
    }

    /// The path that `typed` means.
    fn path_of(&self, typed: &str) -> PathBuf {
        let home = directories::UserDirs::new().map(|user| user.home_dir().to_owned());
        whole_path(&match (typed.strip_prefix('~'), home) {
            (Some(rest), Some(home)) if rest.is_empty() || rest.starts_with('/') => {
                home.join(rest.trim_start_matches('/'))
            }
            _ => self.folder.join(typed),
        })
    }

    /// Completes the typed text as far as all files that begin with it agree.
    pub fn complete(&mut self) {
        let (before, begun) = match self.typed.rsplit_once('/') {
            Some((before, begun)) => (format!("{before}/"), begun),
            None => (String::new(), self.typed.as_str()),
        };
        let Ok(listing) = self.list(&self.path_of(before.trim()), begun, MAX_ENTRIES) else { return };
        let Some((first, others)) = listing.entries.split_first() else { return };
        let mut agreed = first.name.clone();
        for other in others {
            let shared = agreed.chars().zip(other.name.chars()).take_while(|(a, b)| a == b);
            agreed = shared.map(|(a, _)| a).collect();
        }
        let slash = if others.is_empty() && first.is_folder { "/" } else { "" };
        self.typed = format!("{before}{agreed}{slash}");
        self.retyped();
    }

    /// Confirms the typed or picked files.
    pub fn go_ahead(&mut self) -> Verdict {
        if self.picked.len() > 1 {
            return Verdict::Done(self.picked.iter().map(|name| self.folder.join(name)).collect());
        }
        // A picked name counts as it is, with blanks around it.
        let mut path = match (self.picked.first(), self.typed.trim()) {
            (Some(name), _) => self.folder.join(name),
            (None, "") => return Verdict::Refused("Type a name or a path, or click a file.".into()),
            (None, typed) => self.path_of(typed),
        };
        if path.is_dir() {
            self.typed.clear();
            self.enter(&path);
            return Verdict::Entered;
        }
        if self.request.purpose != Purpose::Save {
            return if path.is_file() {
                Verdict::Done(vec![path])
            } else {
                Verdict::Refused(format!("{} is not there.", path.display()))
            };
        }
        let first = self.request.kinds.iter().flat_map(|(_, extensions)| extensions).next();
        if let Some(extension) = first.filter(|_| path.extension().is_none()) {
            path.set_extension(extension);
        }
        if !path.parent().is_some_and(Path::is_dir) {
            let folder = path.parent().unwrap_or(&path).display();
            return Verdict::Refused(format!("The folder {folder} is not there."));
        }
        if path.exists() && self.agreed_to_replace.as_ref() != Some(&path) {
            self.agreed_to_replace = Some(path.clone());
            return Verdict::Replaces(path);
        }
        Verdict::Done(vec![path])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in ["Heads", "heads-old"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        for name in ["igea.ply", "igea-2.PLY", "song.mp3", ".hidden.ply", "Heads/max.obj"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        folder
    }

    fn browser(purpose: Purpose, start: &Path) -> Browser {
        let kinds = vec![("Meshes".into(), vec!["obj".into(), "ply".into()])];
        Browser::new(Request { purpose, kinds, start: start.to_owned() })
    }

    #[test]
    fn folders_come_first_and_other_kinds_not_at_all() {
        let folder = folder();
        let names = |browser: &Browser| -> Vec<String> {
            browser.listing().unwrap().entries.iter().map(|entry| entry.name.clone()).collect()
        };
        let mut browser = browser(Purpose::Open, folder.path());
        assert_eq!(names(&browser), ["Heads", "heads-old", "igea-2.PLY", "igea.ply"]);
        browser.enter(&folder.path().join("Heads"));
        assert_eq!(names(&browser), ["max.obj"]);
        browser.leave();
        assert_eq!(names(&browser).len(), 4);
        browser.enter(&folder.path().join("nowhere"));
        assert!(browser.listing().unwrap_err().contains("nowhere"));
    }

    #[test]
    fn what_is_typed_is_completed_and_followed() {
        let folder = folder();
        let mut browser = browser(Purpose::Open, folder.path());
        let mut completed = |typed: &str| {
            browser.typed = typed.into();
            browser.complete();
            browser.typed.clone()
        };
        assert_eq!(completed("ig"), "igea");
        assert_eq!(completed("igea-"), "igea-2.PLY");
        assert_eq!(completed("He"), "Heads/");
        assert_eq!(completed("Heads/"), "Heads/max.obj");
        assert_eq!(completed("nothing"), "nothing");
        let absolute = format!("{}/He", folder.path().display());
        assert_eq!(completed(&absolute), format!("{absolute}ads/"));

        let mut go = |typed: &str| {
            browser.typed = typed.into();
            browser.go_ahead()
        };
        assert!(matches!(go("  "), Verdict::Refused(_)));
        assert!(matches!(go("nothing.ply"), Verdict::Refused(_)));
        assert_eq!(go("igea.ply"), Verdict::Done(vec![folder.path().join("igea.ply")]));
        assert_eq!(go("Heads"), Verdict::Entered);
        assert_eq!(go("max.obj"), Verdict::Done(vec![folder.path().join("Heads/max.obj")]));
    }

    #[test]
    fn a_way_back_up_is_no_part_of_a_path() {
        let folder = folder();
        let name = folder.path().file_name();
        let mut browser = browser(Purpose::Save, &folder.path().join("Heads"));
        browser.typed = "..".into();
        assert_eq!(browser.go_ahead(), Verdict::Entered);
        assert_eq!(browser.folder().file_name(), name);
        browser.typed = "Heads/../new".into();
        let Verdict::Done(files) = browser.go_ahead() else { panic!("it is no folder") };
        assert_eq!(files[0].parent().unwrap().file_name(), name);
        browser.enter(&folder.path().join("Heads/.."));
        browser.leave();
        assert_eq!(browser.folder().file_name(), folder.path().parent().unwrap().file_name());
    }

    #[test]
    fn what_does_not_fit_takes_no_place_and_a_cut_list_says_so() {
        let folder = folder();
        for index in 0..20 {
            std::fs::write(folder.path().join(format!("a{index}.mp3")), "").unwrap();
        }
        let browser = browser(Purpose::Open, folder.path());
        let whole = browser.list(folder.path(), "", 4).unwrap();
        assert_eq!((whole.entries.len(), whole.is_cut), (4, false));
        let cut = browser.list(folder.path(), "", 3).unwrap();
        assert_eq!((cut.entries.len(), cut.is_cut), (3, true));
        assert!(cut.entries.iter().all(|entry| whole.entries.contains(entry)));
        let begun = browser.list(folder.path(), "ig", 2).unwrap();
        assert_eq!((begun.entries.len(), begun.is_cut), (2, false));
    }

    #[test]
    fn files_are_picked_put_back_and_forgotten_when_something_is_typed() {
        let folder = folder();
        let mut browser = browser(Purpose::OpenSeveral, folder.path());
        browser.pick("igea.ply", false);
        browser.pick("igea-2.PLY", true);
        assert_eq!(browser.typed, "2 files");
        let both = ["igea.ply", "igea-2.PLY"].map(|name| folder.path().join(name)).to_vec();
        assert_eq!(browser.go_ahead(), Verdict::Done(both));
        browser.pick("igea.ply", true);
        assert_eq!(browser.typed, "igea-2.PLY");
        browser.pick("igea.ply", true);
        browser.typed = "Heads/max.obj".into();
        browser.retyped();
        assert!(!browser.is_chosen("igea.ply"));
        assert_eq!(browser.go_ahead(), Verdict::Done(vec![folder.path().join("Heads/max.obj")]));
    }

    #[test]
    fn a_picked_file_may_begin_with_a_blank() {
        let folder = folder();
        for name in [" head.obj", "\u{3000}head.ply"] {
            let path = folder.path().join(name);
            std::fs::write(&path, "").unwrap();
            let mut browser = browser(Purpose::Open, folder.path());
            browser.pick(name, false);
            assert_eq!(browser.go_ahead(), Verdict::Done(vec![path]), "{name:?}");
        }
    }

    #[test]
    fn a_new_folder_is_named_without_an_extension() {
        let folder = folder();
        let kinds = vec![("Frames".into(), Vec::new())];
        let start = folder.path().join("film");
        let mut browser = Browser::new(Request { purpose: Purpose::Save, kinds, start: start.clone() });
        assert!(browser.listing().unwrap().entries.iter().all(|entry| entry.is_folder));
        assert_eq!(browser.go_ahead(), Verdict::Done(vec![start]));
    }

    #[test]
    fn a_file_is_replaced_only_when_asked_twice() {
        let folder = folder();
        let mut browser = browser(Purpose::Save, &folder.path().join("new"));
        assert_eq!(browser.typed, "new");
        assert_eq!(browser.go_ahead(), Verdict::Done(vec![folder.path().join("new.obj")]));
        browser.typed = "igea.ply".into();
        assert_eq!(browser.go_ahead(), Verdict::Replaces(folder.path().join("igea.ply")));
        browser.typed = "Heads/max".into();
        assert_eq!(browser.go_ahead(), Verdict::Replaces(folder.path().join("Heads/max.obj")));
        assert_eq!(browser.go_ahead(), Verdict::Done(vec![folder.path().join("Heads/max.obj")]));
        // Typed anew or looked for elsewhere, it is asked about again.
        browser.retyped();
        assert!(matches!(browser.go_ahead(), Verdict::Replaces(_)));
        browser.enter(folder.path());
        assert!(matches!(browser.go_ahead(), Verdict::Replaces(_)));
        browser.typed = "nowhere/x.obj".into();
        assert!(matches!(browser.go_ahead(), Verdict::Refused(_)));
    }
}
