//! The beat for other programs: OSC messages to an address, and MIDI clock to a device.

use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use chladni_music::{Beat, ClockOut};
use rosc::{OscMessage, OscPacket, OscType, encoder};

use super::midi::Outputs;
use crate::studio::music::listening::Progress;
use crate::work::Error;

/// How often bands are sent, and how many.
const BANDS_SECS: f64 = 1.0 / 30.0;
const BANDS: usize = 8;
/// Below this confidence the beat is a guess, and the outgoing clock stops.
const SURE: f32 = 0.1;

/// What is sent at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a> {
    /// By any steadily running clock.
    pub at_secs: f64,
    pub beat: Beat,
    /// 0 where none is known.
    pub tempo_bpm: f64,
    pub progress: Progress,
    /// The middle of the sound, from low to high.
    pub bands: &'a [f32],
}

/// What was sent last.
#[derive(Debug, Default)]
pub struct Sent {
    /// Bars are known one frame after the beat that they begin with, so beats are sent one frame late.
    beat: f64,
    beats: Option<i64>,
    bar_begins: i64,
    bars: u32,
    sections: Option<u32>,
    tempo_bpm: f64,
    bands_secs: f64,
}

impl Sent {
    /// What is new: `/bar` and `/beat`, each with its number, `/tempo`, `/energy`, `/section`, and `/bands`.
    pub fn messages(&mut self, now: &Now<'_>) -> Vec<OscMessage> {
        let mut messages = Vec::new();
        let mut tell = |address: &str, args: Vec<OscType>| {
            messages.push(OscMessage { addr: address.to_owned(), args });
        };
        let beats = std::mem::replace(&mut self.beat, now.beat.count).floor() as i64;
        let progress = now.progress;
        if (now.tempo_bpm - self.tempo_bpm).abs() > 0.05 {
            self.tempo_bpm = now.tempo_bpm;
            tell("/tempo", vec![OscType::Float(now.tempo_bpm as f32)]);
        }
        if self.sections.replace(progress.sections) != Some(progress.sections) {
            tell("/section", vec![OscType::Int(progress.sections as i32)]);
        }
        if std::mem::replace(&mut self.bars, progress.bars) != progress.bars {
            self.bar_begins = beats;
            tell("/bar", vec![OscType::Int(progress.bars as i32)]);
            tell("/energy", vec![OscType::Float(progress.energy)]);
        }
        if self.beats.replace(beats).is_some_and(|last| last != beats) {
            let in_bar = 1 + (beats - self.bar_begins).max(0);
            tell("/beat", vec![OscType::Int(in_bar as i32)]);
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

/// The loudest of each eighth of the bands.
fn octaves(bands: &[f32]) -> [f32; BANDS] {
    std::array::from_fn(|i| {
        let share = |i: usize| i * bands.len() / BANDS;
        let part = bands.get(share(i)..share(i + 1)).unwrap_or_default();
        part.iter().fold(0.0, |loudest: f32, level| loudest.max(*level))
    })
}

/// Sends OSC messages to one address.
pub struct BeatOut {
    socket: UdpSocket,
    to: SocketAddr,
    last: Sent,
    /// Why the last packet could not be sent.
    pub failure: Option<Error>,
}

impl BeatOut {
    /// To `address`, such as `192.168.1.20:7700` or `localhost:9000`.
    pub fn to(address: &str) -> std::io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        // A network that is busy costs a message, not a frame.
        socket.set_nonblocking(true)?;
        let to = address.to_socket_addrs()?.find(SocketAddr::is_ipv4);
        let to = to.ok_or_else(|| std::io::Error::other("no such address"))?;
        Ok(Self { socket, to, last: Sent::default(), failure: None })
    }

    /// Sends what is new.
    pub fn tell(&mut self, now: &Now<'_>) {
        for message in self.last.messages(now) {
            let packet = encoder::encode(&OscPacket::Message(message));
            let sent = packet
                .map_err(|why| Error::other(why.to_string()))
                .and_then(|packet| self.socket.send_to(&packet, self.to).map_err(Error::other));
            self.failure = sent.err();
        }
    }
}

/// Where a MIDI clock goes, and the beat as the last frame knew it.
#[derive(Clone, Debug)]
struct Given {
    device: String,
    count: f64,
    per_sec: f64,
    at: Instant,
}

/// The beat of a frame is good for so long.
const STALE: Duration = Duration::from_secs(2);

/// Sends MIDI clock from a thread of its own, since frames are too far apart for it.
pub struct ClockSender {
    given: Arc<Mutex<Option<Given>>>,
    closed: Arc<AtomicBool>,
}

impl ClockSender {
    /// Starts to send; nothing is sent before the first [`tell`](Self::tell).
    pub fn start(outputs: Outputs) -> std::io::Result<Self> {
        let given = Arc::new(Mutex::new(None));
        let closed = Arc::new(AtomicBool::new(false));
        let (last, ended) = (Arc::clone(&given), Arc::clone(&closed));
        std::thread::Builder::new().name("clock out".into()).spawn(move || {
            let mut out = ClockOut::default();
            let mut device = String::new();
            loop {
                let closes = ended.load(Ordering::Relaxed);
                let now: Option<Given> = last.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let now = now.filter(|now| !closes && now.at.elapsed() < STALE);
                // One device stops before another starts.
                let goes_on = now.as_ref().filter(|now| device.is_empty() || now.device == device);
                let count = goes_on.map(|now| now.count + now.per_sec * now.at.elapsed().as_secs_f64());
                if let Some(now) = goes_on {
                    device.clone_from(&now.device);
                }
                out.due(count).into_iter().for_each(|message| outputs.send(&device, &[message]));
                if count.is_none() {
                    device.clear();
                }
                if closes {
                    return;
                }
                std::thread::sleep(Duration::from_millis(if count.is_some() { 1 } else { 20 }));
            }
        })?;
        Ok(Self { given, closed })
    }

    /// The beat now; it is sent to `device`, or to none.
    pub fn tell(&self, device: Option<&str>, now: &Now<'_>) {
        let device = device.filter(|_| now.tempo_bpm > 0.0 && now.beat.confidence >= SURE);
        let given = device.map(|device| Given {
            device: device.to_owned(),
            count: now.beat.count,
            per_sec: now.tempo_bpm / 60.0,
            at: Instant::now(),
        });
        *self.given.lock().unwrap_or_else(PoisonError::into_inner) = given;
    }
}

impl Drop for ClockSender {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
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
                tempo_bpm: 120.0,
                progress,
                bands: &bands,
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
        assert_eq!(beats.len(), 19, "{beats:?}");
        for (i, (at_secs, message)) in beats.iter().enumerate() {
            let due_secs = 0.5 * (i + 1) as f64;
            assert!((at_secs - due_secs).abs() < 0.035, "{at_secs} {message:?}");
            assert_eq!(message.args, [OscType::Int(1 + (i as i32 + 1) % 4)], "{at_secs}");
        }
        let bands = of("/bands");
        assert!((295..=305).contains(&bands.len()), "{}", bands.len());
        let OscType::Float(highest) = bands[0].1.args[BANDS - 1] else { panic!("no number") };
        assert_eq!((bands[0].1.args.len(), highest), (BANDS, 127.0 / 128.0));
        assert_eq!(octaves(&[]), [0.0; BANDS]);
    }

    #[test]
    fn messages_arrive_where_they_are_sent() {
        let ear = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        ear.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let port = ear.local_addr().unwrap().port();
        let mut out = BeatOut::to(&format!("localhost:{port}")).unwrap();
        let beat = Beat { count: 3.5, confidence: 1.0 };
        let now =
            Now { at_secs: 1.0, beat, tempo_bpm: 98.5, progress: Progress::default(), bands: &[0.25; 16] };
        out.tell(&now);
        let mut packet = [0u8; 1500];
        let length = ear.recv(&mut packet).unwrap();
        let (_, read) = rosc::decoder::decode_udp(&packet[..length]).unwrap();
        let tempo = OscMessage { addr: "/tempo".into(), args: vec![OscType::Float(98.5)] };
        assert_eq!(read, OscPacket::Message(tempo));
        assert!(BeatOut::to("nowhere").is_err() && out.failure.is_none());
    }
}
