//! Media keys and the desktop's players: state for them and requests from them, by MPRIS 2.2 on the session bus
//! (Linux).
//!
//! Without a bus nothing happens. The window reports its state and collects requests; it never waits.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use chladni_sound::PlayerState;
use zbus::block_on;
use zbus::blocking::Connection;
use zbus::blocking::connection::Builder;
use zbus::fdo::RequestNameFlags;

use self::bus::{Player, Root, micros};
use super::MusicRoom;
use crate::studio::room::Shared;

mod bus;

const NAME: &str = "org.mpris.MediaPlayer2.chladni";
const PATH: &str = "/org/mpris/MediaPlayer2";
/// A song that is farther than this from where it was expected has jumped.
const JUMP_SECS: f64 = 1.0;
/// More requests than this between two frames are ignored.
const MOST_ASKED: usize = 64;

/// A request to the player.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// Play, where it does not.
    Play,
    /// Pause, where it plays.
    Pause,
    /// Pause, and play from the beginning of the song the next time.
    Stop,
    /// The other of the two.
    PlayPause,
    /// The next song.
    Next,
    /// The one before.
    Previous,
    /// So many seconds on, or back.
    SeekBy(f64),
    /// To this second of the song.
    SeekTo(f64),
    /// Loudness in [0, 1].
    Volume(f32),
}

/// The state of the player.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Playing {
    /// Whether time passes in the song.
    pub state: PlayerState,
    /// A number of its file: the place in the list is another song's as soon as one is taken out.
    pub song: u64,
    /// Of its tags, or the file's name.
    pub title: String,
    /// Of its tags.
    pub artist: Option<String>,
    /// The picture that lies beside it.
    pub cover: Option<PathBuf>,
    /// Where it is known.
    pub duration_secs: Option<f64>,
    /// In [0, 1].
    pub volume: f32,
}

/// The player on the bus. Dropped, it is gone from there.
pub struct MediaKeys {
    asked: Receiver<Asked>,
    told: Sender<Told>,
    place: Arc<Mutex<Place>>,
    playing: Playing,
}

enum Told {
    Playing(Playing),
    Jumped(i64),
}

/// Where the song is; asked for now and then, and signaled only where it jumps.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    song: u64,
    at_secs: f64,
}

impl MediaKeys {
    /// On the bus of the session. `wake` is called from another thread where something is asked.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self::on(Builder::session, wake)
    }

    fn on(
        bus: impl FnOnce() -> zbus::Result<Builder<'static>> + Send + 'static,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (asks, asked) = sync_channel(MOST_ASKED);
        let (told, tells) = channel();
        let place = Arc::new(Mutex::new(Place::default()));
        let player =
            Player { asks, wake: Box::new(wake), place: Arc::clone(&place), playing: Playing::default() };
        // Connecting may take long. Without a bus or this thread there are no media keys, and nobody who asked for
        // them.
        let _ = std::thread::Builder::new().name("media keys".into()).spawn(move || {
            let connection = bus()?.serve_at(PATH, Root)?.serve_at(PATH, player)?.build()?;
            take_name(&connection)?;
            let player = connection.object_server().interface::<_, Player>(PATH)?;
            for told in tells {
                let emitter = player.signal_emitter();
                match told {
                    Told::Jumped(micros) => block_on(Player::seeked(emitter, micros))?,
                    Told::Playing(playing) => {
                        let before = std::mem::replace(&mut player.get_mut().playing, playing.clone());
                        let player = player.get();
                        if before.state != playing.state {
                            block_on(player.playback_status_changed(emitter))?;
                        }
                        if before.volume != playing.volume {
                            block_on(player.volume_changed(emitter))?;
                        }
                        // Neither state nor volume is of the song.
                        let of = |playing: Playing| Playing { state: before.state, volume: 0.0, ..playing };
                        if of(before.clone()) != of(playing.clone()) {
                            block_on(player.metadata_changed(emitter))?;
                        }
                    }
                }
            }
            Ok::<(), zbus::Error>(())
        });
        Self { asked, told, place, playing: Playing::default() }
    }

    /// Requests since the last frame.
    pub fn asked(&self) -> impl Iterator<Item = Asked> {
        self.asked.try_iter()
    }

    /// Reports the state of the player, and the second of the song.
    pub fn tell(&mut self, playing: Playing, at_secs: f64) {
        let before = std::mem::replace(&mut *lock(&self.place), Place { song: playing.song, at_secs });
        // A thread that has ended has nobody to tell.
        if (at_secs - before.at_secs).abs() > JUMP_SECS && before.song == playing.song {
            let _ = self.told.send(Told::Jumped(micros(at_secs)));
        }
        if playing != self.playing {
            self.playing.clone_from(&playing);
            let _ = self.told.send(Told::Playing(playing));
        }
    }
}

impl MusicRoom {
    /// Does the requests of media keys, and reports the player to the desktop.
    pub(super) fn follow_media_keys(&mut self, shared: &mut Shared<'_>) {
        let Some(listening) = &mut self.listening else { return };
        let keys = self.media_keys.get_or_insert_with(|| {
            let ctx = shared.ctx.clone();
            MediaKeys::start(move || ctx.request_repaint())
        });
        // Seeks add up: the player may not have done one by the next.
        let mut sought_secs = None;
        for asked in keys.asked() {
            let status = listening.status();
            let plays = listening.plays_songs();
            match asked {
                Asked::Play if !plays => listening.toggle(),
                Asked::Pause if plays => listening.toggle(),
                Asked::Stop if listening.live().is_none() && status.state != PlayerState::Stopped => {
                    sought_secs = Some(0.0);
                    listening.player().pause();
                    listening.player().seek(0.0);
                }
                Asked::Play | Asked::Pause | Asked::Stop => {}
                Asked::PlayPause => listening.toggle(),
                // MPRIS: where playback is paused or stopped, as while live input is heard, it remains that way.
                Asked::Next => {
                    sought_secs = Some(0.0);
                    listening.next_song(false);
                }
                Asked::Previous => {
                    sought_secs = Some(0.0);
                    listening.previous_song(false);
                }
                Asked::SeekBy(secs) => {
                    let to_secs = sought_secs.unwrap_or_else(|| listening.heard_secs()) + secs;
                    // Beyond the end it acts like Next.
                    if status.duration_secs.is_some_and(|end| to_secs >= end) {
                        sought_secs = Some(0.0);
                        listening.next_song(false);
                    } else {
                        sought_secs = Some(to_secs.max(0.0));
                        listening.player().seek(to_secs.max(0.0));
                    }
                }
                Asked::SeekTo(secs) => {
                    sought_secs = Some(secs);
                    listening.player().seek(secs);
                }
                Asked::Volume(volume) => {
                    listening.set_volume(volume);
                    shared.settings.music.volume = volume;
                }
            }
        }
        let status = listening.status();
        let is_live = listening.live().is_some();
        let playing = Playing {
            state: if is_live { PlayerState::Stopped } else { status.state },
            song: listening.songs().get(status.song).map_or(0, |file| number_of(file)),
            title: listening.title_of(status.song),
            artist: listening.artist_of(status.song).map(str::to_owned),
            cover: listening.cover_file_of(status.song).map(Path::to_owned),
            duration_secs: status.duration_secs,
            volume: listening.volume(),
        };
        keys.tell(playing, listening.heard_secs());
    }
}

/// Takes the player's name on the bus. Where another window has it, that one stays the player, and this one adds the number
/// of its process to the name, as MPRIS asks.
fn take_name(connection: &Connection) -> zbus::Result<()> {
    let take = |name: &str| connection.request_name_with_flags(name, RequestNameFlags::DoNotQueue.into());
    match take(NAME) {
        Err(zbus::Error::NameTaken) => take(&second_name())?,
        taken => taken?,
    };
    Ok(())
}

fn second_name() -> String {
    format!("{NAME}.instance{}", std::process::id())
}

fn number_of(file: &Path) -> u64 {
    let mut hasher = DefaultHasher::new();
    file.hash(&mut hasher);
    hasher.finish()
}

fn lock(place: &Mutex<Place>) -> MutexGuard<'_, Place> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

    use std::collections::HashMap;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    use zbus::blocking::{Proxy, proxy};
    use zbus::proxy::CacheProperties;
    use zbus::zvariant::ObjectPath;

    use super::*;

    fn until(what: &str, mut ready: impl FnMut() -> bool) {
        let began = Instant::now();
        while !ready() {
            assert!(began.elapsed() < chladni_testdata::HANGS, "{what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// A bus of our own and its address; `None` where there is no daemon for it.
    fn bus() -> Option<(Child, String)> {
        let daemon = Command::new("dbus-daemon")
            .args(["--session", "--nofork", "--print-address=1"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut daemon) = daemon else {
            println!("skipped: no dbus-daemon");
            return None;
        };
        let mut address = String::new();
        BufReader::new(daemon.stdout.take().unwrap()).read_line(&mut address).unwrap();
        Some((daemon, address.trim().to_owned()))
    }

    #[test]
    fn a_second_window_leaves_the_keys_to_the_first() {
        let Some((mut daemon, address)) = bus() else { return };
        let client = Builder::address(address.as_str()).unwrap().build().unwrap();
        let bus = zbus::blocking::fdo::DBusProxy::new(&client).unwrap();
        let is_there = |name: &str| bus.name_has_owner(name.try_into().unwrap()).unwrap();
        let owner = || bus.get_name_owner(NAME.try_into().unwrap()).unwrap();
        let window = |address: String| MediaKeys::on(move || Builder::address(address.as_str()), || {});
        let _first = window(address.clone());
        until("the first is there", || is_there(NAME));
        let first = owner();
        let second = window(address.clone());
        until("the second is there", || is_there(&second_name()));
        assert_eq!(owner(), first);
        drop(second);
        until("the second is gone", || !is_there(&second_name()));
        assert_eq!(owner(), first);
        let _ = daemon.kill();
        let _ = daemon.wait();
    }

    #[test]
    fn others_see_what_plays_and_ask_for_another_song() {
        let Some((mut daemon, address)) = bus() else { return };
        let bus = address.clone();
        let mut keys = MediaKeys::on(move || Builder::address(bus.as_str()), || {});
        let mut playing = Playing {
            state: PlayerState::Playing,
            song: 2,
            title: "Tide".into(),
            artist: Some("Anna Lindal".into()),
            cover: Some("/music/été #1/cover.jpg".into()),
            duration_secs: Some(90.0),
            volume: 0.5,
        };
        keys.tell(playing.clone(), 10.0);
        let client = Builder::address(address.as_str()).unwrap().build().unwrap();
        // A proxy that keeps properties remembers, too, that nobody was there at first.
        let other = proxy::Builder::<Proxy<'_>>::new(&client)
            .destination(NAME)
            .and_then(|proxy| proxy.path(PATH)?.interface("org.mpris.MediaPlayer2.Player"))
            .and_then(|proxy| proxy.cache_properties(CacheProperties::No).build())
            .unwrap();
        let state =
            |state: &str| other.get_property::<String>("PlaybackStatus").is_ok_and(|seen| seen == state);
        until("it is there", || state("Playing"));
        assert_eq!(other.get_property::<i64>("Position").unwrap(), 10_000_000);
        let seen: HashMap<String, zbus::zvariant::OwnedValue> = other.get_property("Metadata").unwrap();
        assert_eq!(<&str>::try_from(&seen["xesam:title"]).unwrap(), playing.title);
        let artists = Vec::<String>::try_from(seen["xesam:artist"].try_clone().unwrap()).unwrap();
        assert_eq!(artists, ["Anna Lindal"]);
        let art = <&str>::try_from(&seen["mpris:artUrl"]).unwrap();
        assert_eq!(art, "file:///music/%C3%A9t%C3%A9%20%231/cover.jpg");
        assert_eq!(i64::try_from(&seen["mpris:length"]).unwrap(), 90_000_000);
        let jumps = other.receive_signal("Seeked").unwrap();
        // Requests arrive in order; positions in another song, and beyond the end, are ignored.
        let place = |song: &str, micros: i64| (ObjectPath::try_from(song.to_owned()).unwrap(), micros);
        other.call_method("SetPosition", &place("/org/chladni/song/1", 5_000_000)).unwrap();
        other.call_method("SetPosition", &place("/org/chladni/song/2", 95_000_000)).unwrap();
        other.call_method("SetPosition", &place("/org/chladni/song/2", 5_000_000)).unwrap();
        other.call_method("Stop", &()).unwrap();
        other.call_method("PlayPause", &()).unwrap();
        other.call_method("Next", &()).unwrap();
        other.call_method("Seek", &(-2_500_000i64)).unwrap();
        other.set_property("Volume", f64::NAN).unwrap();
        other.set_property("Volume", 7.0).unwrap();
        let asked: Vec<Asked> = keys.asked().collect();
        let expected = [
            Asked::SeekTo(5.0),
            Asked::Stop,
            Asked::PlayPause,
            Asked::Next,
            Asked::SeekBy(-2.5),
            Asked::Volume(1.0),
        ];
        assert_eq!(asked, expected);
        playing.state = PlayerState::Paused;
        keys.tell(playing, 60.0);
        until("it is paused", || state("Paused"));
        let jump = jumps.into_iter().next().unwrap();
        assert_eq!(jump.body().deserialize::<i64>().unwrap(), 60_000_000);
        drop(keys);
        let bus = zbus::blocking::fdo::DBusProxy::new(&client).unwrap();
        until("it is gone", || !bus.name_has_owner(NAME.try_into().unwrap()).unwrap());
        let _ = daemon.kill();
        let _ = daemon.wait();
    }

    #[test]
    fn without_a_bus_nothing_happens() {
        let mut keys = MediaKeys::on(|| Builder::address("unix:path=/nonexistent"), || {});
        keys.tell(Playing { song: 1, ..Playing::default() }, 1.0);
        assert_eq!(keys.asked().count(), 0);
    }
}
