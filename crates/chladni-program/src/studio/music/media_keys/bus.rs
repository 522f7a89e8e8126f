//! The program as a player on the bus, as MPRIS 2.2 describes it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex};

use chladni_sound::PlayerState;
use zbus::interface;
use zbus::zvariant::{ObjectPath, Value};

use super::{Asked, Place, Playing, lock};

/// A song is known by a number of its file.
const SONGS: &str = "/org/chladni/song";

/// A time as the bus counts it.
pub(super) fn micros(secs: f64) -> i64 {
    (1e6 * secs) as i64
}

/// A file as the bus names it: bytes that an address cannot have are numbers (RFC 3986).
fn address(file: &Path) -> String {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let mut address = "file://".to_owned();
    for byte in file.as_os_str().as_encoded_bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => address.push(char::from(*byte)),
            _ if byte.is_ascii_alphanumeric() => address.push(char::from(*byte)),
            _ => address += &format!("%{byte:02X}"),
        }
    }
    address
}

fn track(song: u64) -> String {
    format!("{SONGS}/{song}")
}

/// The program as a whole.
pub(super) struct Root;

#[interface(name = "org.mpris.MediaPlayer2")]
impl Root {
    fn raise(&self) {}
    fn quit(&self) {}

    #[zbus(property)]
    fn can_quit(&self) -> bool {
        false
    }

    #[zbus(property)]
    fn can_raise(&self) -> bool {
        false
    }

    #[zbus(property)]
    fn has_track_list(&self) -> bool {
        false
    }

    #[zbus(property)]
    fn identity(&self) -> &str {
        "Chladni"
    }

    #[zbus(property)]
    fn supported_uri_schemes(&self) -> Vec<String> {
        Vec::new()
    }

    #[zbus(property)]
    fn supported_mime_types(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The player, as the bus sees it.
pub(super) struct Player {
    pub(super) asks: SyncSender<Asked>,
    pub(super) wake: Box<dyn Fn() + Send + Sync>,
    pub(super) place: Arc<Mutex<Place>>,
    pub(super) playing: Playing,
}

impl Player {
    fn ask(&self, asked: Asked) {
        // The window may have closed, or requests may come faster than it takes them.
        if self.asks.try_send(asked).is_ok() {
            (self.wake)();
        }
    }
}

#[interface(name = "org.mpris.MediaPlayer2.Player")]
impl Player {
    fn play(&self) {
        self.ask(Asked::Play);
    }

    fn pause(&self) {
        self.ask(Asked::Pause);
    }

    fn stop(&self) {
        self.ask(Asked::Stop);
    }

    fn play_pause(&self) {
        self.ask(Asked::PlayPause);
    }

    fn next(&self) {
        self.ask(Asked::Next);
    }

    fn previous(&self) {
        self.ask(Asked::Previous);
    }

    fn seek(&self, offset: i64) {
        self.ask(Asked::SeekBy(1e-6 * offset as f64));
    }

    fn set_position(&self, track_id: ObjectPath<'_>, position: i64) {
        // The specification wants places in another song, or outside the song, to be ignored.
        let length = self.playing.duration_secs.map_or(i64::MAX, micros);
        if track_id.as_str() == track(self.playing.song) && (0..=length).contains(&position) {
            self.ask(Asked::SeekTo(1e-6 * position as f64));
        }
    }

    fn open_uri(&self, _uri: &str) {}

    #[zbus(signal)]
    pub(super) async fn seeked(
        emitter: &zbus::object_server::SignalEmitter<'_>,
        position: i64,
    ) -> zbus::Result<()>;

    #[zbus(property)]
    fn playback_status(&self) -> &str {
        match self.playing.state {
            PlayerState::Playing => "Playing",
            PlayerState::Paused => "Paused",
            PlayerState::Stopped => "Stopped",
        }
    }

    #[zbus(property)]
    fn metadata(&self) -> HashMap<&'static str, Value<'_>> {
        let mut told = HashMap::from([("xesam:title", Value::from(self.playing.title.as_str()))]);
        if let Ok(path) = ObjectPath::try_from(track(self.playing.song)) {
            told.insert("mpris:trackid", path.into());
        }
        if let Some(secs) = self.playing.duration_secs {
            told.insert("mpris:length", micros(secs).into());
        }
        if let Some(artist) = &self.playing.artist {
            told.insert("xesam:artist", vec![artist.as_str()].into());
        }
        if let Some(cover) = &self.playing.cover {
            told.insert("mpris:artUrl", address(cover).into());
        }
        told
    }

    #[zbus(property(emits_changed_signal = "false"))]
    fn position(&self) -> i64 {
        micros(lock(&self.place).at_secs)
    }

    #[zbus(property)]
    fn volume(&self) -> f64 {
        f64::from(self.playing.volume)
    }

    #[zbus(property)]
    fn set_volume(&mut self, volume: f64) {
        // Such as NaN, which no player could take back.
        if volume.is_finite() {
            self.ask(Asked::Volume(volume.clamp(0.0, 1.0) as f32));
        }
    }

    #[zbus(property)]
    fn rate(&self) -> f64 {
        1.0
    }

    #[zbus(property)]
    fn minimum_rate(&self) -> f64 {
        1.0
    }

    #[zbus(property)]
    fn maximum_rate(&self) -> f64 {
        1.0
    }

    #[zbus(property)]
    fn can_go_next(&self) -> bool {
        true
    }

    #[zbus(property)]
    fn can_go_previous(&self) -> bool {
        true
    }

    #[zbus(property)]
    fn can_play(&self) -> bool {
        true
    }

    #[zbus(property)]
    fn can_pause(&self) -> bool {
        true
    }

    #[zbus(property)]
    fn can_seek(&self) -> bool {
        true
    }

    #[zbus(property)]
    fn can_control(&self) -> bool {
        true
    }
}
