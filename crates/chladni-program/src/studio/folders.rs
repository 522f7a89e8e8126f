//! Where the window keeps its persistent files.

use std::path::PathBuf;

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
}

impl Folders {
    /// The user's folders as the system defines them; none if it knows no home folder.
    pub fn of_user() -> Self {
        let Some(user) = directories::ProjectDirs::from("", "", "chladni") else { return Self::default() };
        let state = user.state_dir().unwrap_or_else(|| user.data_local_dir());
        Self {
            settings: Some(user.config_dir().join("settings.toml")),
            recovery: Some(state.join("recovery")),
            pictures: Some(user.cache_dir().join("pictures")),
            dances: Some(user.data_dir().join("dances")),
        }
    }
}
