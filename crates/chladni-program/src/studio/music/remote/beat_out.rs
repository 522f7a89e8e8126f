//! The beat for other programs, as OSC messages to an address.

use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};

use chladni_music::Beat;
use rosc::{OscMessage, OscPacket, OscType, encoder};

use crate::studio::job::Job;
use crate::studio::music::listening::Progress;
use crate::work::Error;

/// How often bands are sent, and how many.
const BANDS_SECS: f64 = 1.0 / 30.0;
const BANDS: usize = 8;
/// An address that was not found is looked up again after this time: the network may come later.
const LOOK_AGAIN: Duration = Duration::from_secs(5);

/// The state to send at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a> {
    /// By any steadily running clock.
    pub at_secs: f64,
    pub beat: Beat,
    /// When that was the beat.
    pub beat_at: Instant,
    /// 0 where none is known.
    pub tempo_bpm: f64,
    pub progress: Progress,
    /// The middle of the sound, from low to high.
    pub bands: &'a [f32],
    /// How far ahead of what is heard all this is, since the picture is seen late. Others see no picture.
    pub ahead_secs: f64,
}

/// How the beats are counted in one frame.
#[derive(Clone, Copy, Debug, Default)]
struct Counted {
    beats: i64,
    /// The bars of a clock ([`Progress::bar_offset`]).
    bar_offset: Option<i64>,
    at_secs: f64,
}

/// The last state that was sent.
#[derive(Debug, Default)]
pub struct Sent {
    /// Bars are known one frame after the beat that they begin with, so beats are sent one frame late.
    next: Counted,
    /// The beats that were sent last.
    last: Option<Counted>,
    /// The beat with which the bar began; where that is not known, no beat has a number.
    bar_begins: Option<i64>,
    bars: u32,
    sections: Option<u32>,
    tempo_bpm: f64,
    bands_secs: f64,
}

impl Sent {
    /// Messages for whatever changed: `/bar` and `/beat`, each with its number, `/tempo`, `/energy`, `/section`, and
    /// `/bands`.
    pub fn messages(&mut self, now: &Now<'_>) -> Vec<OscMessage> {
        let mut messages = Vec::new();
        let mut tell = |address: &str, args: Vec<OscType>| {
            messages.push(OscMessage { addr: address.to_owned(), args });
        };
        let progress = now.progress;
        let next = Counted {
            beats: now.beat.count.floor() as i64,
            bar_offset: progress.bar_offset.map(|offset| offset as i64),
            at_secs: now.at_secs,
        };
        if self.last.is_none() {
            // Where the show goes on already, nothing begins now.
            (self.next, self.bars) = (next, progress.bars);
        }
        let counted = std::mem::replace(&mut self.next, next);
        let last = self.last.replace(counted).unwrap_or(counted);
        let Counted { beats, bar_offset, at_secs } = counted;
        let steps = beats - last.beats;
        // A frame may take longer than a beat.
        let most_steps = 1.0 + 1.5 * (at_secs - last.at_secs).max(0.0) * now.tempo_bpm / 60.0;
        if let Some(bar_offset) = bar_offset {
            self.bar_begins = Some(beats - (beats - bar_offset).rem_euclid(4));
        } else if last.bar_offset.is_some() || !(0.0..=most_steps).contains(&(steps as f64)) {
            // The beats are counted otherwise: they have no number until a bar begins.
            self.bar_begins = None;
        }
        if (now.tempo_bpm - self.tempo_bpm).abs() > 0.05 {
            self.tempo_bpm = now.tempo_bpm;
            tell("/tempo", vec![OscType::Float(now.tempo_bpm as f32)]);
        }
        if self.sections.replace(progress.sections) != Some(progress.sections) {
            tell("/section", vec![OscType::Int(progress.sections as i32)]);
        }
        let new_bar = std::mem::replace(&mut self.bars, progress.bars) != progress.bars;
        if new_bar {
            // In a frame of more than one beat only a clock knows with which of them the bar began.
            if steps <= 1 {
                self.bar_begins = Some(beats);
            } else if bar_offset.is_none() {
                self.bar_begins = None;
            }
            tell("/bar", vec![OscType::Int(progress.bars as i32)]);
            tell("/energy", vec![OscType::Float(progress.energy)]);
        }
        // A clock that starts just after a beat begins its bar with that one.
        if (steps != 0 || new_bar)
            && let Some(bar_begins) = self.bar_begins
        {
            tell("/beat", vec![OscType::Int((1 + beats - bar_begins) as i32)]);
        }
        let waited = now.at_secs - self.bands_secs;
        if !(0.0..BANDS_SECS).contains(&waited) {
            // Where frames come late, the bands do not come in a burst.
            self.bands_secs = if (0.0..2.0 * BANDS_SECS).contains(&waited) {
                self.bands_secs + BANDS_SECS
            } else {
                now.at_secs
            };
            tell("/bands", octaves(now.bands).map(OscType::Float).to_vec());
        }
        messages
    }
}

/// The loudest of each eighth of the bands, at most 1: with a fixed level, loud bands exceed that.
fn octaves(bands: &[f32]) -> [f32; BANDS] {
    std::array::from_fn(|i| {
        let share = |i: usize| i * bands.len() / BANDS;
        let part = bands.get(share(i)..share(i + 1)).unwrap_or_default();
        part.iter().fold(0.0, |loudest: f32, level| loudest.max(*level)).min(1.0)
    })
}

/// Sends OSC messages to one address.
pub struct BeatOut {
    address: String,
    socket: UdpSocket,
    found: Found,
    last: Sent,
    /// What is sent once it is heard.
    waiting: VecDeque<(f64, OscMessage)>,
    /// Why nothing is sent, or why the last packet could not be.
    pub failure: Option<Error>,
}

/// Where an address is. A name is looked up beside the window, since that may take seconds.
enum Found {
    At(SocketAddr),
    NotYet(Job<SocketAddr>),
    Nowhere { since: Instant },
}

impl BeatOut {
    /// To `address`, such as `192.168.1.20:7700` or `localhost:9000`.
    pub fn to(address: &str, ctx: &egui::Context) -> std::io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        // A network that is busy costs a message, not a frame.
        socket.set_nonblocking(true)?;
        let found = Found::NotYet(look_up(address, ctx));
        let (last, waiting) = (Sent::default(), VecDeque::new());
        Ok(Self { address: address.to_owned(), socket, found, last, waiting, failure: None })
    }

    /// Sends all changes that are heard by now, once the address is found.
    pub fn tell(&mut self, now: &Now<'_>, ctx: &egui::Context) {
        let Some(to) = self.found(ctx) else { return };
        let due_secs = now.at_secs + now.ahead_secs.max(0.0);
        self.waiting.extend(self.last.messages(now).into_iter().map(|message| (due_secs, message)));
        while let Some((_, message)) = self.waiting.pop_front_if(|(due_secs, _)| *due_secs <= now.at_secs) {
            let packet = encoder::encode(&OscPacket::Message(message));
            let sent = packet
                .map_err(|why| Error::other(why.to_string()))
                .and_then(|packet| self.socket.send_to(&packet, to).map_err(Error::other));
            self.failure = sent.err();
        }
    }

    fn found(&mut self, ctx: &egui::Context) -> Option<SocketAddr> {
        match &self.found {
            Found::At(to) => return Some(*to),
            Found::NotYet(job) => match job.ended()? {
                Ok(to) => {
                    self.failure = None;
                    self.found = Found::At(to);
                    return Some(to);
                }
                Err(why) => {
                    self.failure = Some(why.of(&self.address));
                    self.found = Found::Nowhere { since: Instant::now() };
                }
            },
            Found::Nowhere { since } if since.elapsed() > LOOK_AGAIN => {
                self.found = Found::NotYet(look_up(&self.address, ctx));
            }
            Found::Nowhere { .. } => {}
        }
        None
    }
}

fn look_up(address: &str, ctx: &egui::Context) -> Job<SocketAddr> {
    let address = address.to_owned();
    Job::start("Looking up an address", ctx, move |_| {
        let mut found = address.to_socket_addrs().map_err(Error::other)?;
        found.find(SocketAddr::is_ipv4).ok_or_else(|| Error::other("no such address"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seconds at 120 beats a minute, 60 frames a second, with a bar every four beats.
    fn evening() -> Vec<(f64, OscMessage)> {
        let (mut last, mut progress, mut sent) = (Sent::default(), Progress::default(), Vec::new());
        let bands: Vec<f32> = (0..128).map(|i| i as f32 / 128.0).collect();
        for frame in 0..600u32 {
            let at_secs = f64::from(frame) / 60.0;
            let count = 2.0 * at_secs + 1e-9;
            // As in the window: bars of the frame before are sent in this one.
            let before = 2.0 * (at_secs - 1.0 / 60.0) + 1e-9;
            progress.bars = (before / 4.0).floor().max(-1.0) as i32 as u32;
            progress.energy = 0.5;
            let now = Now {
                at_secs,
                beat: Beat { count, confidence: 1.0 },
                beat_at: Instant::now(),
                tempo_bpm: 120.0,
                progress,
                bands: &bands,
                ahead_secs: 0.0,
            };
            sent.extend(last.messages(&now).into_iter().map(|message| (at_secs, message)));
        }
        sent
    }

    #[test]
    fn beats_bars_and_bands_are_told_in_time() {
        let sent = evening();
        let of = |address: &str| -> Vec<&(f64, OscMessage)> {
            sent.iter().filter(|(_, message)| message.addr == address).collect()
        };
        assert_eq!(of("/tempo").len(), 1);
        assert_eq!((of("/section").len(), of("/energy").len()), (1, of("/bar").len()));
        let beats = of("/beat");
        assert_eq!(beats.len(), 20, "{beats:?}");
        for (i, (at_secs, message)) in beats.iter().enumerate() {
            let due_secs = 0.5 * i as f64;
            assert!((at_secs - due_secs).abs() < 0.035, "{at_secs} {message:?}");
            assert_eq!(message.args, [OscType::Int(1 + i as i32 % 4)], "{at_secs}");
        }
        let bands = of("/bands");
        assert!((295..=305).contains(&bands.len()), "{}", bands.len());
        let OscType::Float(highest) = bands[0].1.args[BANDS - 1] else { panic!("no number") };
        assert_eq!((bands[0].1.args.len(), highest), (BANDS, 127.0 / 128.0));
        assert_eq!(octaves(&[]), [0.0; BANDS]);
        assert_eq!(octaves(&[15.8; 2 * BANDS]), [1.0; BANDS]);
    }

    #[test]
    fn a_show_that_goes_on_already_is_joined_at_its_next_bar() {
        let (mut sent, mut said) = (Sent::default(), Vec::new());
        for frame in 0..12 {
            // Two frames a beat; the third of these beats begins the 38th bar, which is known a frame later.
            let beat = f64::from(frame / 2);
            let progress = Progress { bars: 37 + u32::from(frame >= 5), ..Progress::default() };
            let now = Now {
                at_secs: 0.25 * f64::from(frame),
                beat: Beat { count: 145.0 + beat + 1e-9, confidence: 1.0 },
                beat_at: Instant::now(),
                tempo_bpm: 120.0,
                progress,
                bands: &[],
                ahead_secs: 0.0,
            };
            said.extend(sent.messages(&now));
        }
        let counted = said.iter().filter(|message| ["/bar", "/beat"].contains(&&*message.addr));
        let counted: Vec<_> = counted.map(|message| (&*message.addr, message.args[0].clone())).collect();
        let expected = [("/bar", 38), ("/beat", 1), ("/beat", 2), ("/beat", 3), ("/beat", 4)];
        let expected = expected.map(|(address, number)| (address, OscType::Int(number)));
        assert_eq!(counted, expected);
    }

    /// The numbers of `/bar` and `/beat` in frames with these counts, bars so far, and bars of a clock.
    fn counted(frames: &[(f64, u32, Option<f64>)]) -> Vec<(&'static str, i32)> {
        let frames = frames.iter().enumerate();
        counted_at(frames.map(|(frame, seen)| (0.1 * frame as f64, *seen)))
    }

    /// The same, in frames at these times.
    fn counted_at(
        frames: impl IntoIterator<Item = (f64, (f64, u32, Option<f64>))>,
    ) -> Vec<(&'static str, i32)> {
        let (mut sent, mut counted) = (Sent::default(), Vec::new());
        for (at_secs, (count, bars, bar_offset)) in frames {
            let now = Now {
                at_secs,
                beat: Beat { count, confidence: 1.0 },
                beat_at: Instant::now(),
                tempo_bpm: 120.0,
                progress: Progress { bars, bar_offset, ..Progress::default() },
                bands: &[],
                ahead_secs: 0.0,
            };
            for message in sent.messages(&now) {
                let name = ["/bar", "/beat"].into_iter().find(|name| message.addr == *name);
                if let (Some(name), OscType::Int(number)) = (name, &message.args[0]) {
                    counted.push((name, *number));
                }
            }
        }
        counted
    }

    #[test]
    fn beats_that_are_counted_otherwise_have_no_number_until_a_bar_begins() {
        let song =
            [(3.0, 0), (4.0, 0), (5.0, 1), (25.0, 1), (26.0, 1), (27.0, 1), (28.0, 2), (13.0, 2), (14.0, 2)];
        let said = counted(&song.map(|(count, bars)| (count, bars, None)));
        assert_eq!(said, [("/bar", 1), ("/beat", 1), ("/beat", 2), ("/bar", 2), ("/beat", 1), ("/beat", 2)]);
    }

    #[test]
    fn beats_keep_their_numbers_where_a_frame_takes_longer_than_a_beat() {
        let frames = [(0.05, 0), (0.55, 1), (1.55, 1), (2.05, 1), (2.55, 2)];
        let said = counted_at(frames.map(|(secs, bars)| (secs, (2.0 * secs, bars, None))));
        let begun = [("/bar", 1), ("/beat", 1), ("/beat", 2), ("/beat", 4)];
        assert_eq!(said, [&begun[..], &[("/bar", 2), ("/beat", 1)]].concat());
        // A bar has begun within that frame: a clock knows with which beat.
        let frames = [(1.95, 0), (2.95, 0), (3.0, 1), (3.5, 1), (4.0, 1), (4.5, 2)];
        let said = |bars_of_clock: Option<f64>| {
            counted_at(frames.map(|(secs, bars)| (secs, (2.0 * secs, bars, bars_of_clock))))
        };
        let (bar, next) = (("/bar", 1), [("/bar", 2), ("/beat", 1)]);
        assert_eq!(said(None), [bar, next[0], next[1]]);
        assert_eq!(said(Some(0.0)), [bar, ("/beat", 2), ("/beat", 3), ("/beat", 4), next[0], next[1]]);
    }

    #[test]
    fn the_beats_of_a_clock_have_its_numbers_and_a_start_is_the_first() {
        // It starts just after a beat, is given another place in its bar, and is left for a song.
        let clock = [(8.5, 0), (9.0, 0), (9.1, 0)].map(|(count, bars)| (count, bars, Some(0.0)));
        let started = [(9.2, 0), (9.7, 1), (10.0, 1)].map(|(count, bars)| (count, bars, Some(1.0)));
        let moved = [(10.6, 1), (11.0, 1)].map(|(count, bars)| (count, bars, Some(0.0)));
        let song = [(11.5, 1), (12.0, 1), (13.0, 1), (14.0, 2)].map(|(count, bars)| (count, bars, None));
        let said = counted(&[&clock[..], &started, &moved, &song].concat());
        let begun = [("/beat", 2), ("/bar", 1), ("/beat", 1), ("/beat", 2)];
        assert_eq!(said, [&begun[..], &[("/beat", 4), ("/bar", 2), ("/beat", 1)]].concat());
    }

    #[test]
    fn messages_arrive_where_they_are_sent() {
        let ear = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        ear.set_read_timeout(Some(chladni_testdata::HANGS)).unwrap();
        let port = ear.local_addr().unwrap().port();
        let ctx = egui::Context::default();
        let mut out = BeatOut::to(&format!("localhost:{port}"), &ctx).unwrap();
        let beat = Beat { count: 3.5, confidence: 1.0 };
        let progress = Progress::default();
        // The picture is a quarter of a second ahead: what it shows is sent when it is heard.
        let (beat_at, bands) = (Instant::now(), &[0.25; 16]);
        let now = Now { at_secs: 1.0, beat, beat_at, tempo_bpm: 98.5, progress, bands, ahead_secs: 0.25 };
        until_found(&mut out, &now);
        let waiting = out.waiting.len();
        assert!(waiting > 0 && out.waiting.iter().all(|(due_secs, _)| *due_secs == 1.25));
        out.tell(&Now { at_secs: 1.25, ..now }, &ctx);
        assert!(out.waiting.iter().all(|(due_secs, _)| *due_secs == 1.5));
        let mut packet = [0u8; 1500];
        let length = ear.recv(&mut packet).unwrap();
        let (_, read) = rosc::decoder::decode_udp(&packet[..length]).unwrap();
        let tempo = OscMessage { addr: "/tempo".into(), args: vec![OscType::Float(98.5)] };
        assert_eq!(read, OscPacket::Message(tempo));
        assert!(out.failure.is_none());
    }

    #[test]
    fn an_address_that_is_not_found_is_looked_up_again() {
        let ctx = egui::Context::default();
        let mut out = BeatOut::to("nowhere", &ctx).unwrap();
        let now = Now {
            at_secs: 1.0,
            beat: Beat::default(),
            beat_at: Instant::now(),
            tempo_bpm: 98.5,
            progress: Progress::default(),
            bands: &[],
            ahead_secs: 0.0,
        };
        until_found(&mut out, &now);
        assert!(out.failure.as_ref().is_some_and(|why| why.to_string().starts_with("nowhere: ")));
        // However long a busy machine takes from here on.
        out.found = Found::Nowhere { since: Instant::now() + Duration::from_secs(3600) };
        out.tell(&now, &ctx);
        assert!(matches!(out.found, Found::Nowhere { .. }));
        out.found = Found::Nowhere { since: Instant::now().checked_sub(2 * LOOK_AGAIN).unwrap() };
        out.address = "localhost:9".into();
        until_found(&mut out, &now);
        assert!(matches!(out.found, Found::At(_)));
    }

    /// Tells of `now` until the address is found, or is known to be none.
    fn until_found(out: &mut BeatOut, now: &Now<'_>) {
        loop {
            out.tell(now, &egui::Context::default());
            match out.found {
                Found::NotYet(_) => std::thread::sleep(Duration::from_millis(5)),
                Found::At(_) | Found::Nowhere { .. } => return,
            }
        }
    }
}
