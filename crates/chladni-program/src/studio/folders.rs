//! Where the window keeps its persistent files.

use std::path::{Component, Path, PathBuf};

/// Places on disk; `None` keeps nothing.
#[derive(Clone, Debug, Default)]
pub struct Folders {
    /// The file of preferences and recent files.
    pub settings: Option<PathBuf>,
    /// The folder of recovery copies, one for each running program.
    pub recovery: Option<PathBuf>,
    /// The folder of small pictures of recent files.
    pub pictures: Option<PathBuf>,
    /// The folder of the music room's shelf.
    pub dances: Option<PathBuf>,
    /// The folder of recordings for which a controller asks.
    pub recordings: Option<PathBuf>,
}

impl Folders {
    /// The user's folders as the system defines them; none if it knows no home folder.
    pub fn of_user() -> Self {
        let Some(user) = directories::ProjectDirs::from("", "", "chladni") else { return Self::default() };
        let recordings = directories::UserDirs::new().map(|own| {
            let videos = own.video_dir().filter(|folder| folder.is_dir());
            videos.unwrap_or_else(|| own.home_dir()).to_owned()
        });
        let state = user.state_dir().unwrap_or_else(|| user.data_local_dir());
        Self {
            settings: Some(user.config_dir().join("settings.toml")),
            recovery: Some(state.join("recovery")),
            pictures: Some(user.cache_dir().join("pictures")),
            dances: Some(user.data_dir().join("dances")),
            recordings,
        }
    }
}

/// `path` from the root and without `..`, so that the folder above it is its parent; as it is where its folder is not there.
pub fn whole_path(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    if !whole.components().any(|part| part == Component::ParentDir) {
        return whole;
    }
    // The system is asked: behind a link, `..` is not the folder before.
    let found = match (whole.parent(), whole.file_name()) {
        (Some(folder), Some(name)) => folder.canonicalize().map(|folder| folder.join(name)),
        _ => whole.canonicalize(),
    };
    found.unwrap_or(whole)
}
