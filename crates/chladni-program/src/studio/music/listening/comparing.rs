//! Songs of a show, compared with those that it was made with.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

use chladni_music::FileRef;

use super::Listening;
use crate::work::{Warning, changed_since};

/// Files that are read one after the other on a thread of their own: songs are long, and some disks slow. Dropped, it ends
/// behind the file that it reads.
pub(super) struct Comparison(Receiver<Option<Warning>>);

impl Comparison {
    fn begin(files: Vec<(PathBuf, FileRef)>) -> std::io::Result<Self> {
        let (send, warnings) = channel();
        let compare = move || {
            // Nobody listens any more where another show was opened.
            let _ = files.iter().try_for_each(|(found, named)| send.send(changed_since(found, named)));
        };
        std::thread::Builder::new().name("songs of a show".into()).spawn(compare)?;
        Ok(Self(warnings))
    }

    /// A warning for each changed file that was read since the last call.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        self.0.try_iter().flatten()
    }
}

impl Listening {
    /// Warns of songs, found at these paths, that are not those that a show names; as soon as they are read.
    pub fn compare(&mut self, files: Vec<(PathBuf, FileRef)>) {
        match Comparison::begin(files) {
            Ok(comparison) => self.comparison = Some(comparison),
            Err(why) => self.warnings.push(format!("Songs are not compared with those of the show: {why}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::work::refer;

    #[test]
    fn a_song_that_was_changed_since_the_show_was_saved_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["same.wav", "other.wav"].map(|name| {
            let path = folder.path().join(name);
            std::fs::write(&path, name).unwrap();
            let named = refer(&path, Some(folder.path()));
            (path, named)
        });
        std::fs::write(folder.path().join("other.wav"), "changed").unwrap();
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        listening.compare(Vec::from(files));
        let (began, mut said) = (Instant::now(), Vec::new());
        while said.is_empty() {
            assert!(began.elapsed() < chladni_testdata::HANGS, "they are not compared");
            std::thread::yield_now();
            said = listening.comparison.iter().flat_map(Comparison::warnings).collect();
        }
        let said: Vec<String> = said.iter().map(ToString::to_string).collect();
        assert!(said.len() == 1 && said[0].contains("other.wav"), "{said:?}");
    }
}
