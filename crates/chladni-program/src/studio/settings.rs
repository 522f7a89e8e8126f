//! Settings of the window, kept between runs.

use std::io;
use std::path::{Path, PathBuf};

use chladni_music::Binding;
use chladni_sound::LONGEST_CROSSFADE_SECS;
use chladni_task::{alone, read_file, read_text_file};
use serde::{Deserialize, Serialize};
use toml::Value;

use super::folders::whole_path;
use super::music::MOST_GAIN_DB;
use crate::work::HARMONICS;

/// The largest file of preferences, in bytes.
const LARGEST: u64 = 1 << 20;

/// Files of preferences that could not be read and are kept.
const MOST_UNREAD: usize = 100;

/// Recent files that the start screen shows at most.
const RECENT: usize = 8;

/// Preferences that are lists, of which each window may add and remove some; other arrays are one value.
const LISTS: [&str; 3] = ["recent", "osc_allowed", "bindings"];

/// Preferences and recent files: a small text file in the user's configuration folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Light instead of dark.
    pub light: bool,
    /// UI scale in [0.5, 3]; 1 is the system's own.
    pub zoom: f32,
    /// Harmonics solved for a newly opened shape.
    pub harmonics: usize,
    /// Projects and shapes, most recent first.
    pub recent: Vec<PathBuf>,
    /// The music room's own.
    pub music: super::music::Preferences,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            light: false,
            zoom: 1.0,
            harmonics: HARMONICS,
            recent: Vec::new(),
            music: super::music::Preferences::default(),
        }
    }
}

impl Settings {
    /// Reads `path`. A missing file gives the defaults; a damaged one is an error that says why.
    pub fn load(path: &Path) -> io::Result<Self> {
        Ok(Self::read(path)?.0)
    }

    /// The same, with the names of preferences whose values are not understood, as those of a newer version: they have
    /// their defaults.
    ///
    /// # Errors
    /// Those of [`load`](Self::load).
    pub fn read(path: &Path) -> io::Result<(Self, Vec<String>)> {
        match read_text_file(path, LARGEST) {
            Ok(text) => Self::understood(&text),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok((Self::default(), Vec::new())),
            Err(error) => Err(error),
        }
    }

    /// The preferences that a file has, with numbers in their bounds; defaults in the place of values that are not
    /// understood.
    ///
    /// # Errors
    /// Text that is not TOML; the error says where.
    pub fn from_text(text: &str) -> io::Result<Self> {
        Ok(Self::understood(text)?.0)
    }

    fn understood(text: &str) -> io::Result<(Self, Vec<String>)> {
        let (settings, unread) = match toml::from_str::<Self>(text) {
            Ok(settings) => (settings, Vec::new()),
            Err(_) => Self::of_table(text.parse::<toml::Table>().map_err(io::Error::other)?)?,
        };
        Ok((settings.bounded(), unread))
    }

    /// The preferences of a table, and the names of those that are not understood.
    fn of_table(table: toml::Table) -> io::Result<(Self, Vec<String>)> {
        let (mut all, mut unread) = (Value::Table(table), Vec::new());
        sift("", &mut all, &|value: Value| value.try_into::<Self>().is_ok(), &mut unread);
        unread.sort_unstable();
        unread.dedup();
        let mut settings: Self = all.try_into().map_err(io::Error::other)?;
        // Where no machine is named any would be heard.
        let music = &mut settings.music;
        if music.osc_allowed.is_empty() && unread.iter().any(|name| name == "music.osc_allowed") {
            music.osc_network = false;
        }
        Ok((settings, unread))
    }

    /// The text of a file of preferences.
    ///
    /// # Errors
    /// A value that the file cannot hold.
    pub fn to_text(&self) -> io::Result<String> {
        toml::to_string_pretty(self).map_err(io::Error::other)
    }

    /// Keeps a file that could not be read beside `path`, where the next preferences do not replace it; returns where.
    pub fn set_aside(path: &Path) -> io::Result<PathBuf> {
        let unread = read_file(path, LARGEST)?;
        // What was set aside before stays, unless it is the same.
        let is_free =
            |name: &PathBuf| !name.exists() || read_file(name, LARGEST).is_ok_and(|old| old == unread);
        let numbered = (2..MOST_UNREAD).map(|number| path.with_extension(format!("toml.unread-{number}")));
        let mut names = std::iter::once(path.with_extension("toml.unread")).chain(numbered);
        let aside = names.find(is_free).ok_or_else(|| io::Error::other("too many such files are there"))?;
        chladni_task::write_atomic(&aside, &unread)?;
        Ok(aside)
    }

    /// Writes `path`, whole or not at all, making its folder where it is missing.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        if let Some(folder) = path.parent() {
            chladni_task::create_folder(folder)?;
        }
        chladni_task::write_atomic(path, self.to_text()?.as_bytes())
    }

    /// Writes to `path` what was changed since `before`; all else stays as another window, or a newer version, may have
    /// written it there. A file that cannot be read is [set aside](Self::set_aside); returns where.
    ///
    /// # Errors
    /// Those of [`save`](Self::save) and [`set_aside`](Self::set_aside).
    pub fn save_beside(&self, before: &Self, path: &Path) -> io::Result<Option<PathBuf>> {
        alone(path, || {
            if !path.exists() {
                return self.save(path).map(|()| None);
            }
            let read = read_text_file(path, LARGEST)
                .and_then(|text| text.parse::<toml::Table>().map_err(io::Error::other));
            let Ok(there) = read else {
                let aside = Self::set_aside(path)?;
                return self.save(path).map(|()| Some(aside));
            };
            let merged = toml::to_string_pretty(&self.over(before, there)?).map_err(io::Error::other)?;
            chladni_task::write_atomic(path, merged.as_bytes()).map(|()| None)
        })
    }

    /// What was changed here since `before`, and all else as `there`, in a file that another window may have written
    /// meanwhile: a newer version has keys and values in it that are not known here.
    ///
    /// # Errors
    /// A value that the file cannot hold.
    fn over(&self, before: &Self, mut there: toml::Table) -> io::Result<toml::Table> {
        rename_targets(&mut there);
        change(&mut there, &before.table()?, self.table()?);
        let (merged, _) = Self::of_table(there.clone())?;
        change(&mut there, &merged.table()?, merged.bounded().table()?);
        Ok(there)
    }

    /// As a file holds it: numbers have no more digits than a person would write.
    fn table(&self) -> io::Result<toml::Table> {
        self.to_text()?.parse::<toml::Table>().map_err(io::Error::other)
    }

    /// Puts `path` first among the recent files.
    pub fn remember(&mut self, path: &Path) {
        // The next run may start in another folder.
        let path = whole_path(path);
        // Preferences are text, which cannot name it.
        if path.to_str().is_none() {
            return;
        }
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    /// Whether the user has opened or saved the document at `document` or the `file` that it names of late.
    pub fn knows(&self, document: &Path, file: &Path) -> bool {
        [document, file].into_iter().any(|path| self.recent.contains(&whole_path(path)))
    }

    /// A file edited by hand may hold anything.
    fn bounded(mut self) -> Self {
        self.zoom = if self.zoom.is_finite() { self.zoom.clamp(0.5, 3.0) } else { 1.0 };
        self.harmonics = self.harmonics.clamp(2, 4096);
        self.recent.truncate(RECENT);
        self.music.projection = self.music.projection.sane();
        let volume = self.music.volume;
        self.music.volume = if volume.is_finite() { volume.clamp(0.0, 1.0) } else { 1.0 };
        let gain_db = self.music.live_gain_db;
        self.music.live_gain_db =
            if gain_db.is_finite() { gain_db.clamp(-MOST_GAIN_DB, MOST_GAIN_DB) } else { 0.0 };
        let fade_secs = self.music.song_fade_secs;
        self.music.song_fade_secs =
            if fade_secs.is_finite() { fade_secs.clamp(0.0, LONGEST_CROSSFADE_SECS) } else { 0.0 };
        self
    }
}

/// Takes out of `value`, the preference `name`, what is not understood, and adds the names of that to `unread`. Returns
/// whether the rest is understood, as `is_read` says of a value in this place.
fn sift(name: &str, value: &mut Value, is_read: &dyn Fn(Value) -> bool, unread: &mut Vec<String>) -> bool {
    if is_read(value.clone()) {
        return true;
    }
    let before = unread.len();
    match value {
        Value::Table(parts) => parts.retain(|key, part| {
            // Keys further in may be any text.
            let name = match name {
                "" => key.to_owned(),
                "music" => format!("music.{key}"),
                _ => name.to_owned(),
            };
            let is_part_read =
                |part: Value| is_read(Value::Table(toml::Table::from_iter([(key.to_owned(), part)])));
            sift(&name, part, &is_part_read, unread)
        }),
        Value::Array(parts) => {
            parts.retain(|part| is_read(Value::Array(vec![part.clone()])));
            unread.push(name.to_owned());
        }
        _ => {}
    }
    let is_rest_read = is_read(value.clone());
    if !is_rest_read {
        unread.truncate(before);
        unread.push(name.to_owned());
    }
    is_rest_read
}

/// Writes bindings with the names of now, by which they are compared: an older version may have written others.
fn rename_targets(there: &mut toml::Table) {
    let bindings = there.get_mut("music").and_then(|music| music.get_mut("bindings"));
    for binding in bindings.and_then(Value::as_array_mut).into_iter().flatten() {
        if let Ok(known) = binding.clone().try_into::<Binding>()
            && let Ok(renamed) = Value::try_from(known)
        {
            *binding = renamed;
        }
    }
}

/// Changes `there` in what differs between `before` and `now`.
fn change(there: &mut toml::Table, before: &toml::Table, mut now: toml::Table) {
    there.retain(|key, _| now.contains_key(key) || !before.contains_key(key));
    now.retain(|key, value| before.get(key) != Some(value));
    for (key, value) in now {
        match (value, there.get_mut(&key), before.get(&key)) {
            (Value::Table(now), Some(Value::Table(there)), Some(Value::Table(before))) => {
                change(there, before, now);
            }
            (Value::Array(now), Some(Value::Array(there)), before) if LISTS.contains(&key.as_str()) => {
                let before = before.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
                *there = changed_list(there, before, now);
            }
            (value, ..) => {
                there.insert(key, value);
            }
        }
    }
}

/// The list as it is `now`, with what was added to the one `there` since `before`, and without what was removed from it.
fn changed_list(there: &[Value], before: &[Value], mut now: Vec<Value>) -> Vec<Value> {
    now.retain(|value| there.contains(value) || !before.contains(value));
    for (place, value) in there.iter().enumerate() {
        if !before.contains(value) && !now.contains(value) {
            now.insert(place.min(now.len()), value.clone());
        }
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(now: &Settings, before: &Settings, others: &Settings) -> Settings {
        now.over(before, others.table().unwrap()).unwrap().try_into().unwrap()
    }

    #[test]
    fn a_window_writes_only_what_was_changed_in_it() {
        let before = Settings::default();
        let (mut one, mut other) = (before.clone(), before.clone());
        one.zoom = 1.5;
        one.music.volume = 0.25;
        other.harmonics = 128;
        other.music.live_gain_db = 6.0;
        let both = over(&other, &before, &one);
        assert_eq!((both.zoom, both.music.volume), (1.5, 0.25));
        assert_eq!((both.harmonics, both.music.live_gain_db), (128, 6.0));
        // What is changed back is changed; what is taken away goes.
        let again = over(&before, &one, &both);
        assert_eq!(
            (again.zoom, again.music.volume, again.harmonics),
            (before.zoom, before.music.volume, 128)
        );
        one.remember(Path::new("/a.chladni"));
        assert_eq!(over(&before, &one, &one), before);
    }

    #[test]
    fn of_lists_a_window_writes_only_what_it_added_and_removed() {
        let list = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let with = |names: &[&str]| {
            let mut settings = Settings { recent: list(names), ..Settings::default() };
            settings.music.osc_allowed = names.iter().filter_map(|name| name[1..].parse().ok()).collect();
            settings
        };
        let before = with(&["/10.0.0.1", "/10.0.0.2", "/10.0.0.3"]);
        // One adds 4 and removes 1, the other adds 5 and removes 2.
        let one = with(&["/10.0.0.4", "/10.0.0.2", "/10.0.0.3"]);
        let other = with(&["/10.0.0.5", "/10.0.0.1", "/10.0.0.3"]);
        assert_eq!(over(&other, &before, &one), with(&["/10.0.0.4", "/10.0.0.5", "/10.0.0.3"]));
        // A file that is opened again comes first.
        let again = with(&["/10.0.0.3", "/10.0.0.1", "/10.0.0.2"]);
        let meanwhile = with(&["/10.0.0.9", "/10.0.0.1", "/10.0.0.2", "/10.0.0.3"]);
        let both = over(&again, &before, &meanwhile);
        let expected = with(&["/10.0.0.9", "/10.0.0.3", "/10.0.0.1", "/10.0.0.2"]);
        assert_eq!(both.recent, expected.recent);
        // What stands for one value is taken as a whole.
        let mut wider = before.clone();
        wider.music.projection.trim = [0.25, 0.5, 0.75];
        let mut narrower = before.clone();
        narrower.music.projection.trim = [0.125; 3];
        let merged = over(&wider, &before, &narrower);
        assert_eq!(merged.music.projection, wider.music.projection);
    }

    #[test]
    fn preferences_that_cannot_be_read_are_set_aside_before_others_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let (before, settings) = (Settings::default(), Settings { light: true, ..Settings::default() });
        assert_eq!(settings.save_beside(&before, &path).unwrap(), None);
        std::fs::write(&path, "zoom = [").unwrap();
        let aside = settings.save_beside(&before, &path).unwrap().unwrap();
        assert_eq!(std::fs::read_to_string(aside).unwrap(), "zoom = [");
        assert_eq!(Settings::load(&path).unwrap(), settings);
        assert_eq!(before.save_beside(&settings, &path).unwrap(), None);
        assert_eq!(Settings::load(&path).unwrap(), before);
    }

    #[test]
    fn preferences_of_a_newer_version_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let text =
            "invented = 1\nzoom = 9.0\n[music]\nvolume = 0.5\nof_later = [\"a\"]\n[later]\nkey = true\n";
        std::fs::write(&path, text).unwrap();
        let before = Settings::load(&path).unwrap();
        let mut settings = before.clone();
        settings.music.volume = 0.1;
        assert_eq!(settings.save_beside(&before, &path).unwrap(), None);
        let kept: toml::Table = std::fs::read_to_string(&path).unwrap().parse().unwrap();
        assert_eq!(kept["invented"].as_integer(), Some(1));
        assert_eq!(kept["later"]["key"].as_bool(), Some(true));
        assert_eq!(kept["music"]["of_later"][0].as_str(), Some("a"));
        assert_eq!((kept["zoom"].as_float(), kept["music"]["volume"].as_float()), (Some(3.0), Some(0.1)));
        assert_eq!(Settings::load(&path).unwrap(), settings);
    }

    #[test]
    fn values_that_are_not_understood_leave_all_others_and_stay_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let pad = |number: u8, target: &str| {
            let control = format!("{{ kind = \"note\", channel = 0, number = {number} }}");
            format!("[[music.bindings]]\ncontrol = {control}\ntarget = \"{target}\"\n")
        };
        let text = "zoom = 1.5\nharmonics = \"many\"\n[music]\ncamera = \"ndi\"\nvolume = 0.5\n\
                    osc_network = true\nosc_allowed = [\"desk.local\"]\n";
        std::fs::write(&path, [text, &pad(1, "strobe"), &pad(2, "favourite")].concat()).unwrap();
        let (before, unread) = Settings::read(&path).unwrap();
        assert_eq!(unread, ["harmonics", "music.bindings", "music.camera", "music.osc_allowed"]);
        assert_eq!((before.zoom, before.harmonics, before.music.volume), (1.5, HARMONICS, 0.5));
        assert_eq!(before.music.bindings.len(), 1);
        assert!(!before.music.osc_network, "none is heard where those that may be are not understood");
        let mut settings = before.clone();
        settings.zoom = 2.0;
        settings.music.bindings.clear();
        assert_eq!(settings.save_beside(&before, &path).unwrap(), None);
        let kept: toml::Table = std::fs::read_to_string(&path).unwrap().parse().unwrap();
        let music = &kept["music"];
        assert_eq!((kept["harmonics"].as_str(), music["camera"].as_str()), (Some("many"), Some("ndi")));
        assert_eq!(music["osc_network"].as_bool(), Some(true));
        let bindings = music["bindings"].as_array().unwrap();
        assert_eq!((bindings.len(), bindings[0]["target"].as_str()), (1, Some("strobe")));
        assert_eq!(Settings::read(&path).unwrap(), (settings, unread));
    }

    #[cfg(unix)]
    #[test]
    fn windows_that_write_at_once_keep_what_each_has_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let before = Settings::default();
        before.save(&path).unwrap();
        let start = std::sync::Barrier::new(4);
        let write = |number: usize| {
            let mut settings = before.clone();
            settings.remember(Path::new(&format!("/{number}.chladni")));
            start.wait();
            settings.save_beside(&before, &path).unwrap();
        };
        std::thread::scope(|scope| {
            for number in 0..4 {
                scope.spawn(move || write(number));
            }
        });
        assert_eq!(Settings::load(&path).unwrap().recent.len(), 4);
    }

    #[test]
    fn recent_files_are_unique_and_few() {
        let mut settings = Settings::default();
        for i in 0..20 {
            settings.remember(Path::new(&format!("{}.chladni", i % 12)));
        }
        assert_eq!(settings.recent.len(), RECENT);
        assert_eq!(settings.recent[0], std::path::absolute("7.chladni").unwrap());
        settings.remember(Path::new("5.chladni"));
        assert_eq!(settings.recent.len(), RECENT);
        assert_eq!(settings.recent[0], std::path::absolute("5.chladni").unwrap());
        settings.remember(Path::new("src/../6.chladni"));
        assert!(settings.recent[0].parent().unwrap().ends_with("chladni-program"));
    }

    #[test]
    fn settings_survive_a_restart_and_damage_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chladni/settings.toml");
        assert_eq!(Settings::load(&path).unwrap(), Settings::default());
        let settings = Settings { light: true, zoom: 1.25, ..Settings::default() };
        settings.save(&path).unwrap();
        assert_eq!(Settings::load(&path).unwrap(), settings);
        std::fs::write(&path, "zoom = [\n").unwrap();
        assert!(Settings::load(&path).is_err());
        let aside = Settings::set_aside(&path).unwrap();
        assert!(aside != path && std::fs::read_to_string(&aside).unwrap() == "zoom = [\n");
        assert_eq!(Settings::set_aside(&path).unwrap(), aside, "the same again");
        std::fs::write(&path, "zoom = {\n").unwrap();
        let second = Settings::set_aside(&path).unwrap();
        assert_eq!(std::fs::read_to_string(second).unwrap(), "zoom = {\n");
        assert_eq!(std::fs::read_to_string(aside).unwrap(), "zoom = [\n");
        std::fs::write(&path, "zoom = inf\n").unwrap();
        assert_eq!(Settings::load(&path).unwrap().zoom, 1.0);
        std::fs::write(&path, "zoom = [").unwrap();
        assert!(Settings::load(&path).is_err());
    }

    #[test]
    fn whatever_is_in_the_file_the_settings_are_sound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let good = toml::to_string_pretty(&Settings::default()).unwrap();
        let numbers = ["nan", "-inf", "1e308", "-1", "9223372036854775807", "0", "\"x\"", "[]", "true"];
        let (mut whole, mut in_part) = (0, 0);
        // Each value of the file in turn is something else.
        for (at, line) in good.lines().enumerate().filter(|(_, line)| line.contains(" = ")) {
            let key = line.split(" = ").next().unwrap();
            for number in numbers {
                let changed = format!("{key} = {number}");
                let lines = good.lines().enumerate().map(|(i, own)| if i == at { &changed } else { own });
                let text = lines.collect::<Vec<_>>().join("\n");
                std::fs::write(&path, &text).unwrap();
                let Ok((settings, unread)) = Settings::read(&path) else {
                    assert!(text.parse::<toml::Table>().is_err(), "{changed}");
                    continue;
                };
                *(if unread.is_empty() { &mut whole } else { &mut in_part }) += 1;
                assert!((0.5..=3.0).contains(&settings.zoom) && (2..=4096).contains(&settings.harmonics));
                assert!((0.0..=1.0).contains(&settings.music.volume), "{changed}");
                assert!(settings.music.live_gain_db.abs() <= MOST_GAIN_DB, "{changed}");
                settings.save(&path).unwrap();
                assert_eq!(Settings::load(&path).unwrap(), settings, "{changed}");
            }
        }
        assert!(whole > 10 && in_part > 10, "{whole} {in_part}");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_whose_name_is_no_text_keeps_no_preferences_from_being_written() {
        use std::os::unix::ffi::OsStrExt;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let before = Settings::default();
        before.save(&path).unwrap();
        let mut settings = Settings { light: true, ..before.clone() };
        settings.remember(Path::new(std::ffi::OsStr::from_bytes(b"/caf\xe9.ogg")));
        assert_eq!(settings.save_beside(&before, &path).unwrap(), None);
        assert!(Settings::load(&path).unwrap().light);
    }
}
