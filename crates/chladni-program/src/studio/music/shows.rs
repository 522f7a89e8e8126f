//! Opening, continuing and saving presets and shows.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use chladni_music::{
    Action, BeatReading, FileRef, GalleryItem, Instrument, ItemId, Moment, Preset, Recording, Show, SongRef,
    heard_again,
};

use super::concert::Concert;
use super::hands::Taken;
use super::listening::{Listening, ShowSong};
use super::recorder::Recorder;
use super::view::View;
use super::wish::Then;
use super::{Coming, MusicRoom};
use crate::studio::choose::ask_where_to_save;
use crate::studio::room::Shared;
use crate::studio::unsaved::{Answer, Question};
use crate::work::formats::TEXT;
use crate::work::{
    Error, cautions, find, is_far, is_like_a_show, is_lost, name_in, placed, playlist, refer, refer_looks,
    resolve, resolve_looks, unread,
};

/// The most harmonics that dance live.
pub const MOST_HARMONICS: usize = 512;

impl MusicRoom {
    /// A preset goes into the gallery, a show replaces it, with its shape and its songs.
    pub(super) fn open_text(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let Some(concert) = &mut self.concert else { return };
        let opened = match Preset::load(&path) {
            Ok(preset) => take(concert, preset, shared).map(|_| ()),
            Err(not_preset) => match Show::load(&path) {
                Ok(show) => return self.open_show(path, show, shared),
                Err(not_show) => {
                    let unread = matches!(not_preset, chladni_music::MusicError::File { .. });
                    let text = || std::fs::read_to_string(&path).unwrap_or_default();
                    let why = if !unread && is_like_a_show(&text()) { not_show } else { not_preset };
                    Err(Error::from(why).of(path.display()))
                }
            },
        };
        if let Err(why) = opened {
            shared.notices.failed(why);
        }
    }

    /// Adds songs that were opened, once no show is to come that would replace them.
    pub(super) fn add_songs(&mut self, shared: &mut Shared<'_>) {
        if self.show_comes() || self.late_songs.is_empty() {
            return;
        }
        let songs = std::mem::take(&mut self.late_songs);
        let follow = std::mem::take(&mut self.late_songs_follow);
        self.take_songs(songs, |_| follow, shared);
    }

    /// Adds songs, and those of lists, at the end of the list. What is heard goes on, unless it is the sample tune.
    pub(super) fn append_songs(&mut self, files: &[PathBuf], shared: &mut Shared<'_>) {
        let mut songs = Vec::new();
        for file in files {
            if playlist::is_list(file) {
                songs.extend(songs_of_list(file, shared));
            } else {
                songs.push(file.clone());
            }
            shared.settings.remember(file);
        }
        if self.show_comes() {
            return self.late_songs.extend(songs);
        }
        let goes_on = |listening: &Listening| !listening.has_only_the_tune() || listening.live().is_some();
        self.take_songs(songs, goes_on, shared);
    }

    /// Adds songs: at the end of the list where what is heard `goes_on`, else the first of them plays.
    fn take_songs(
        &mut self,
        songs: Vec<PathBuf>,
        goes_on: impl Fn(&Listening) -> bool,
        shared: &mut Shared<'_>,
    ) {
        match self.listening(shared) {
            Some(listening) if goes_on(listening) => {
                listening.append(songs);
            }
            Some(listening) => {
                listening.add(songs);
                // The clicks would go on over them.
                self.end_calibrating();
                self.leaning.begin(&shared.ctx);
            }
            None => shared.notices.warn("There is no player for these songs."),
        }
    }

    /// Whether a show was opened whose songs are still to come.
    fn show_comes(&self) -> bool {
        let waits = !self.waiting.is_empty() && !self.refused;
        waits || self.replacing.is_some() || self.coming.is_some()
    }

    /// Opens a show, once it was asked about unsaved dances.
    fn open_show(&mut self, path: PathBuf, show: Show, shared: &mut Shared<'_>) {
        if self.unsaved_show().is_some() {
            self.replacing = Some((path, show));
        } else {
            self.begin_show(path, show, shared);
        }
    }

    /// Begins another gallery by `action`, once it was asked about unsaved dances of the one there is.
    pub(super) fn begin_gallery(&mut self, action: Action, shared: &mut Shared<'_>) {
        let Some(concert) = &mut self.concert else { return };
        if concert.has_unsaved_gallery() {
            self.renewing = Some(action);
        } else if let Err(why) = concert.act(action) {
            shared.notices.warn(why);
        }
    }

    /// Asks what to do with unsaved dances when a show is opened, or another gallery begins.
    pub(super) fn ask_to_replace(&mut self, shared: &mut Shared<'_>) {
        // A person is being asked where to save.
        if self.asking == Some(Then::SaveShowFirst) {
            return;
        }
        let (question, unsaved) = if self.replacing.is_some() {
            (Question::OPENING, self.unsaved_show())
        } else if self.renewing.is_some() {
            let line = "What was bred or changed by hand in this gallery is not saved. Favorites stay.";
            (Question::BREEDING_ANEW, Some(line.to_owned()))
        } else {
            return;
        };
        match question.ask(&shared.ctx, unsaved.as_slice()) {
            None => {}
            Some(Answer::Save) => self.ask_for(Then::SaveShowFirst, shared),
            Some(Answer::Discard) => self.replace(shared),
            Some(Answer::Stay) => (self.replacing, self.renewing) = (None, None),
        }
    }

    /// Opens the show that has waited for what becomes of unsaved dances, or begins the gallery that has.
    pub(super) fn replace(&mut self, shared: &mut Shared<'_>) {
        let renewing = self.renewing.take();
        if let Some((path, show)) = self.replacing.take() {
            // It brings its own gallery.
            self.begin_show(path, show, shared);
        } else if let (Some(action), Some(concert)) = (renewing, &mut self.concert)
            && let Err(why) = concert.act(action)
        {
            shared.notices.warn(why);
        }
    }

    /// Saves the show where it has unsaved work, before the window closes; false where it was not saved.
    pub(super) fn save_dances(&mut self, shared: &mut Shared<'_>) -> bool {
        if self.listening.is_none() || !self.concert.as_ref().is_some_and(Concert::has_unsaved_work) {
            return true;
        }
        let asked = ask_where_to_save(shared.chooser, &[("Text", &[TEXT])], &[TEXT], Path::new("show.toml"));
        let Some(path) = asked else { return false };
        // The show hears live input again from it.
        if self.end_recording(shared) {
            shared.notices.warn("The recording was ended, so that the show can name it.");
        }
        let saved = self.write_show(&path, shared);
        saved.map_err(|why| shared.notices.failed(why)).is_ok()
    }

    /// The show so far, whose files are named by `refer`.
    pub(super) fn the_show(&self, shared: &Shared<'_>, refer: impl Fn(&Path) -> FileRef) -> Option<Show> {
        let (concert, listening) = (self.concert.as_ref()?, self.listening.as_ref()?);
        let (heard, songs) = listening.heard();
        let song = |song: &ShowSong| SongRef { reading: song.reading, ..SongRef::of(refer(&song.path)) };
        let mut songs: Vec<SongRef> = songs.iter().map(song).collect();
        // What came in live is heard again from the recordings of the set.
        let mut heard = heard;
        let being_written = concert.outgoing.recorder.as_ref().and_then(Recorder::set);
        let written = concert.outgoing.recorded.iter().map(|set| (set, true));
        for (set, is_written) in written.chain(being_written.iter().map(|set| (set, false))) {
            let (song, begins, duration_secs) = (songs.len(), &set.begins, set.duration_secs);
            let again = heard_again(&heard, Recording { song, begins, duration_secs });
            if again != heard {
                let file = refer(&set.path);
                // While a recording is being written, an older file may still lie at its path: its hash must not go into
                // the show.
                songs.push(SongRef::of(if is_written { file } else { FileRef { blake3: None, ..file } }));
                heard = again;
            }
        }
        Some(Show {
            stands: concert.standing().given,
            body: Some(refer(&self.body)),
            looks: Some(shared.settings.music.looks()),
            viewpoint: concert.viewpoint(),
            songs,
            heard,
            clock: listening.clock().clone(),
            duration_secs: Some(listening.at_secs()),
            ..Show::of(concert.instrument())
        })
    }

    /// The show as a copy against a crash has it: with whole paths, and how it names files of other machines.
    pub(super) fn the_copy(&self, shared: &Shared<'_>) -> Option<Show> {
        let far = self.far.iter().map(|(place, named)| (unread(place).path, named.clone())).collect();
        Some(Show { far, ..self.the_show(shared, unread)? })
    }

    /// How the show that was opened names `file`, where that is of another machine and still not beside the show.
    fn far_name(&self, file: &Path) -> Option<FileRef> {
        self.far.get(file).filter(|_| !file.is_file()).cloned()
    }

    /// Saves the show, and warns of a file that it names and cannot find again.
    pub(super) fn write_show(&mut self, path: &Path, shared: &mut Shared<'_>) -> Result<(), Error> {
        let (folder, lost) = (path.parent(), RefCell::new(None));
        let heed = |file: &Path, named: FileRef| {
            if is_lost(file, &named) || is_far(Path::new(&named.path), folder) {
                *lost.borrow_mut() = Some(named.path.clone());
            }
            named
        };
        let named = |file: &Path| heed(file, self.far_name(file).unwrap_or_else(|| refer(file, folder)));
        let Some(mut show) = self.the_show(shared, named) else { return Ok(()) };
        // Unlike songs, they have no hash: one may be a long film.
        let unhashed = |file: &Path| FileRef { path: name_in(file, folder), blake3: None };
        let seen = |file: &Path| heed(file, self.far_name(file).unwrap_or_else(|| unhashed(file))).path;
        show.looks = show.looks.map(|looks| refer_looks(looks, seen));
        show.save(path).map_err(Error::unsaved)?;
        match lost.into_inner() {
            Some(file) => shared.notices.warn(format_args!(
                "Saved {}, which will not find {file}: its name is not valid Unicode, or that of another machine. \
                 Rename it, and its name in the show, or keep it beside the show",
                path.display()
            )),
            None => shared.notices.done(format!("Saved {}", path.display())),
        }
        self.concert.iter_mut().for_each(Concert::mark_saved);
        Ok(())
    }

    /// The folder from which the show at `path` names its files; `None` for a copy of our own, which has whole paths.
    fn folder_of_names<'a>(&self, path: &'a Path) -> Option<&'a Path> {
        path.parent().filter(|_| !self.keepsake.is_opening(path))
    }

    /// Opens a show's shape first where another one dances.
    fn begin_show(&mut self, path: PathBuf, show: Show, shared: &mut Shared<'_>) {
        let Some(concert) = &self.concert else { return };
        for caution in cautions(&show) {
            shared.notices.warn(format!("{}: {caution}", path.display()));
        }
        let given = concert.standing().given;
        // On a shape that is not its own, a show changes nothing about how that stands.
        let elsewhere = |show: Show| Show { stands: given, ..show };
        let Some(body) = show.body.clone() else {
            return self.go_on_with(&path, &elsewhere(show), shared);
        };
        match resolve(&body, self.folder_of_names(&path)) {
            Ok((body, warning)) => {
                warning.into_iter().for_each(|warning| shared.notices.warn(warning));
                let dances = concert.instrument().shape().eigenvalues.len();
                let wanted = show.harmonics.map_or(dances, |harmonics| harmonics.min(MOST_HARMONICS));
                if self.body == body && dances == wanted {
                    return self.go_on_with(&path, &show, shared);
                }
                if show.harmonics.is_some_and(|harmonics| harmonics > MOST_HARMONICS) {
                    let message =
                        format!("{}: more harmonics than dance live; films have all.", path.display());
                    shared.notices.warn(message);
                }
                let since = concert.instrument().log().len();
                self.coming = Some(Coming { path, show, since });
                self.load(body, shared);
            }
            // On another shape, a new copy would take the place of the one that names this.
            Err(why) if self.keepsake.is_opening(&path) => {
                shared.notices.error(format!("{why}. The next start offers the show again."));
            }
            Err(why) => {
                shared.notices.warn(format!("{why}. It goes on with the shape that dances now."));
                self.go_on_with(&path, &elsewhere(show), shared);
            }
        }
    }

    /// Continues the show that has waited for its shape, unless work that was done meanwhile is in its way: then it is asked
    /// about.
    pub(super) fn go_on_with_coming(&mut self, shared: &mut Shared<'_>) {
        let Some(Coming { path, show, since }) = self.coming.take() else { return };
        if self.concert.as_ref().is_some_and(|concert| concert.has_unsaved_work_since(since)) {
            self.replacing = Some((path, show));
        } else {
            self.go_on_with(&path, &show, shared);
        }
    }

    /// Continues a show on the shape that dances.
    fn go_on_with(&mut self, path: &Path, show: &Show, shared: &mut Shared<'_>) {
        self.end_calibrating();
        let folder = self.folder_of_names(path);
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        if let Err(why) = concert.replay(show) {
            return shared.notices.error(format!("{}: {why}", path.display()));
        }
        if let Some(caution) = show.caution_on(concert.instrument().shape().eigenvalues.len()) {
            shared.notices.warn(format!("{}: {caution}", path.display()));
        }
        // What was begun with the show before: items and songs of this one may have the same numbers.
        (self.taken, self.renewing) = (Taken::default(), None);
        self.filming.forget_song();
        self.drawers.shelf.forget_form();
        self.asking = self.asking.filter(|then| !matches!(then, Then::SavePreset(_) | Then::SaveShow));
        if self.keepsake.opened(path) {
            concert.mark_unsaved();
        }
        // Each file that is not found, by the place that it is given.
        let mut gone: Vec<(PathBuf, FileRef)> = Vec::new();
        if let Some(looks) = &show.looks {
            // One that is not found keeps its place: its disk may come back. The stage says that it is missing.
            let (mut found, _) = resolve_looks(looks.clone(), folder);
            for (found, named) in
                [(&mut found.picture, &looks.picture), (&mut found.panorama, &looks.panorama)]
            {
                if found.is_empty() && !named.is_empty() {
                    let place = placed(named, folder);
                    *found = place.to_string_lossy().into_owned();
                    gone.push((place, FileRef { path: named.clone(), blake3: None }));
                }
            }
            shared.settings.music.look_like(&found);
        }
        let (mut songs, mut found) = (Vec::new(), Vec::new());
        for song in &show.songs {
            let named = song.file();
            let file = match find(&named, folder) {
                Ok(file) => {
                    found.push((file.clone(), named));
                    file
                }
                Err(why) => {
                    shared.notices.warn(why);
                    let place = placed(&song.path, folder);
                    gone.push((place.clone(), named));
                    place
                }
            };
            songs.push(ShowSong::new(file, song.reading));
        }
        gone.retain(|(_, named)| is_far(Path::new(&named.path), folder));
        // A copy of our own has whole paths, and says beside them what the show calls files of other machines.
        let kept = show.far.iter().filter(|_| folder.is_none());
        gone.extend(kept.map(|(place, named)| (PathBuf::from(place), named.clone())));
        self.far = gone.into_iter().collect();
        self.late_songs_follow = !songs.is_empty() && !self.late_songs.is_empty();
        // The stretches are numbered by these songs; an older file has none, and the current song goes on.
        if show.body.is_some() || !songs.is_empty() {
            let at_beat = show.actions.last().map_or(0.0, |line| line.moment.at_beat);
            let ends = Moment { at_secs: show.ends_secs(), at_beat };
            listening.go_on(songs, &show.heard, show.clock.clone(), ends);
            listening.compare(found);
            concert.go_on_at(ends);
        }
    }
}

/// The songs of a list; none where it cannot be read.
pub fn songs_of_list(path: &Path, shared: &mut Shared<'_>) -> Vec<PathBuf> {
    match playlist::songs_of(path) {
        Ok(found) => {
            found.warning.into_iter().for_each(|warning| shared.notices.warn(warning));
            found.songs
        }
        Err(why) => {
            shared.notices.failed(why);
            Vec::new()
        }
    }
}

/// Puts a preset in the last place whose item is neither chosen, locked nor a favorite, or else the last that is not locked.
/// The previous generation is kept; the knobs are set to those of the preset. Returns the dance that it became.
pub fn take(concert: &mut Concert, preset: Preset, shared: &mut Shared<'_>) -> Result<ItemId, Error> {
    // Where there is no place, the autopilot goes on.
    place_in(concert.instrument())?;
    // The autopilot ends with the gallery and the knobs that there were before it: not with those of the preset.
    concert.end_piloting()?;
    let instrument = concert.instrument();
    let item = place_in(instrument)?;
    let (caution, before) = (preset.caution(), instrument.parameters().clone());
    let on_stage = concert.on_stage();
    concert.look_at(View::Gallery);
    concert.act(Action::Take { item, preset: Box::new(preset) })?;
    let became = concert.instrument().gallery().items().get(item).map(|item| item.id);
    let became = became.ok_or_else(|| Error::other("the gallery is empty"))?;
    if on_stage {
        concert.act(Action::PerformGallery { first: item })?;
    }
    if let Some(caution) = caution {
        shared.notices.warn(caution);
    } else if *concert.instrument().parameters() != before {
        shared.notices.done("Form and knobs are those of the preset now.".to_owned());
    }
    Ok(became)
}

/// The place in the gallery that a preset takes.
fn place_in(instrument: &Instrument) -> Result<usize, Error> {
    let items = instrument.gallery().items();
    let free = |item: &GalleryItem| !item.chosen && !item.locked && !instrument.is_favorite(item.id);
    let place = items.iter().rposition(free).or_else(|| items.iter().rposition(|item| !item.locked));
    place.ok_or_else(|| Error::input("All dances are locked: unlock one first"))
}

/// The songs of a show as the command line calls them.
pub fn songs_of(show: &Show) -> Vec<(String, BeatReading)> {
    show.songs.iter().map(|song| (song.path.clone(), song.reading)).collect()
}

#[cfg(test)]
mod tests {
    use chladni_music::GalleryShape;

    use super::*;

    #[test]
    fn a_preset_takes_no_place_of_a_dance_that_is_locked() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let mut act = |action| {
            instrument.apply(Moment::default(), action).unwrap();
            place_in(&instrument).ok()
        };
        assert_eq!(act(Action::Lock { item: 5, on: true }), Some(4));
        let places: Vec<_> = (0..5).map(|item| act(Action::Choose { item, on: true })).collect();
        assert_eq!(places.last(), Some(&Some(4)), "all others are chosen");
        let places: Vec<_> = (0..5).rev().map(|item| act(Action::Lock { item, on: true })).collect();
        assert_eq!(places, [Some(3), Some(2), Some(1), Some(0), None]);
    }
}
