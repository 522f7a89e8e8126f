//! OSC messages over UDP.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rosc::{OscPacket, OscType};

/// Longer packets are bad: controllers send a few dozen bytes.
const LONGEST_PACKET: usize = 1536;
/// Messages that are read of one packet at most, and that may wait for the next frame.
const MOST_MESSAGES: usize = 256;
/// Bundles within bundles deeper than this are bad.
const DEEPEST_BUNDLE: usize = 8;

/// One message: where it goes and its first number.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Such as `/1/fader3`.
    pub address: String,
    /// `None` where it has no argument that is a number.
    pub value: Option<f32>,
    /// Its first text.
    pub text: Option<String>,
}

/// Whose messages are heard.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum From {
    /// Those of this machine.
    #[default]
    Here,
    /// Those of other machines, too: of these, or of any where none is named.
    Network(Vec<IpAddr>),
}

impl From {
    fn allows(&self, address: IpAddr) -> bool {
        address.is_loopback()
            || matches!(self, Self::Network(allowed) if allowed.is_empty() || allowed.contains(&address))
    }
}

/// A port that is listened to. Dropping it closes the port.
pub struct Osc {
    address: SocketAddr,
    messages: Receiver<(Message, Instant)>,
    counts: Arc<Counts>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Counts {
    good: AtomicU64,
    bad: AtomicU64,
    waiting: AtomicUsize,
    closed: AtomicBool,
}

impl Osc {
    /// Listens on a UDP port; port 0 takes any free one.
    pub fn listen(port: u16, from: From) -> io::Result<Self> {
        let network = if from == From::Here { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
        let socket = UdpSocket::bind((network, port))?;
        // The thread looks this often whether the port is to be closed.
        socket.set_read_timeout(Some(Duration::from_millis(200)))?;
        let address = socket.local_addr()?;
        let (sender, messages) = sync_channel(MOST_MESSAGES);
        let counts = Arc::new(Counts::default());
        let counted = Arc::clone(&counts);
        let receiver = move || receive(&socket, &from, &sender, &counted);
        let thread = Some(std::thread::Builder::new().name("osc".into()).spawn(receiver)?);
        Ok(Self { address, messages, counts, thread })
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// What has come in since the last call, and when.
    pub fn messages(&self) -> impl Iterator<Item = (Message, Instant)> {
        let messages = self.messages.try_iter().take(MOST_MESSAGES);
        messages.inspect(|_| {
            self.counts.waiting.fetch_sub(1, Ordering::Relaxed);
        })
    }

    /// Packets that were read, and packets that were rejected: not OSC, too long or too many.
    pub fn counts(&self) -> (u64, u64) {
        (self.counts.good.load(Ordering::Relaxed), self.counts.bad.load(Ordering::Relaxed))
    }
}

impl Drop for Osc {
    fn drop(&mut self) {
        self.counts.closed.store(true, Ordering::Relaxed);
        // A packet wakes the thread, so that the port is free when this returns.
        let wake = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0));
        let _ = wake.and_then(|socket| socket.send_to(&[], (Ipv4Addr::LOCALHOST, self.port())));
        self.thread.take().map(JoinHandle::join);
    }
}

fn receive(socket: &UdpSocket, from: &From, sender: &SyncSender<(Message, Instant)>, counts: &Counts) {
    let mut packet = [0u8; LONGEST_PACKET + 1];
    while !counts.closed.load(Ordering::Relaxed) {
        let length = match socket.recv_from(&mut packet) {
            // While nobody takes what waits, a flood is not even read.
            Ok((length, sender))
                if from.allows(sender.ip()) && counts.waiting.load(Ordering::Relaxed) < MOST_MESSAGES =>
            {
                length
            }
            Ok(_) => {
                counts.bad.fetch_add(1, Ordering::Relaxed);
                continue;
            }
            Err(why) if matches!(why.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => continue,
            // Such as an unreachable port; wait a little before reading again.
            Err(_) => {
                counts.bad.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        let Some(messages) = packet.get(..length).and_then(read) else {
            counts.bad.fetch_add(1, Ordering::Relaxed);
            continue;
        };
        counts.good.fetch_add(1, Ordering::Relaxed);
        let came = Instant::now();
        for message in messages {
            counts.waiting.fetch_add(1, Ordering::Relaxed);
            match sender.try_send((message, came)) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    counts.waiting.fetch_sub(1, Ordering::Relaxed);
                    counts.bad.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Disconnected(_)) => return,
            }
        }
    }
}

/// The messages of one packet; `None` if it is not OSC.
pub fn read(packet: &[u8]) -> Option<Vec<Message>> {
    if packet.len() > LONGEST_PACKET {
        return None;
    }
    let (rest, packet) = rosc::decoder::decode_udp(packet).ok()?;
    let mut messages = Vec::new();
    (rest.is_empty() && collect(packet, 0, &mut messages)).then_some(messages)
}

fn collect(packet: OscPacket, depth: usize, messages: &mut Vec<Message>) -> bool {
    match packet {
        OscPacket::Message(message) => {
            if messages.len() >= MOST_MESSAGES {
                return false;
            }
            let value = message.args.iter().find_map(number);
            let text = message.args.into_iter().find_map(OscType::string);
            messages.push(Message { address: message.addr, value, text });
            true
        }
        OscPacket::Bundle(bundle) => {
            depth < DEEPEST_BUNDLE
                && bundle.content.into_iter().all(|packet| collect(packet, depth + 1, messages))
        }
    }
}

fn number(argument: &OscType) -> Option<f32> {
    match *argument {
        OscType::Float(value) => Some(value),
        OscType::Double(value) => Some(value as f32),
        OscType::Int(value) => Some(value as f32),
        OscType::Long(value) => Some(value as f32),
        OscType::Bool(value) => Some(f32::from(u8::from(value))),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rosc::{OscBundle, OscMessage, OscTime, encoder};

    fn message(addr: &str, args: Vec<OscType>) -> OscPacket {
        OscPacket::Message(OscMessage { addr: addr.into(), args })
    }

    fn bundle(content: Vec<OscPacket>) -> OscPacket {
        OscPacket::Bundle(OscBundle { timetag: OscTime { seconds: 0, fractional: 1 }, content })
    }

    fn read_packet(packet: &OscPacket) -> Option<Vec<Message>> {
        read(&encoder::encode(packet).unwrap())
    }

    #[test]
    fn numbers_of_every_kind_are_read() {
        for (argument, value) in [
            (OscType::Float(0.5), Some(0.5)),
            (OscType::Double(0.25), Some(0.25)),
            (OscType::Int(3), Some(3.0)),
            (OscType::Bool(true), Some(1.0)),
            (OscType::Nil, None),
        ] {
            let address = "/1/fader3".to_owned();
            assert_eq!(
                read_packet(&message("/1/fader3", vec![argument])),
                Some(vec![Message { address, value, text: None }])
            );
        }
        let named = read_packet(&message("/chladni/preset", vec![OscType::String("slow tide".into())]));
        assert_eq!(named.unwrap()[0].text.as_deref(), Some("slow tide"));
        let inner = bundle(vec![message("/a", vec![]), message("/b", vec![OscType::Int(1)])]);
        assert_eq!(read_packet(&bundle(vec![inner])).map(|m| m.len()), Some(2));
    }

    #[test]
    fn what_is_no_osc_is_refused() {
        let deep = (0..20).fold(message("/a", vec![]), |packet, _| bundle(vec![packet]));
        assert_eq!(read_packet(&deep), None);
        let mut good = encoder::encode(&message("/chladni/gain", vec![OscType::Float(1.5)])).unwrap();
        for length in 0..good.len() {
            let cut = read(&good[..length]);
            assert!(cut.is_none_or(|m| m.iter().all(|m| m.value.is_none())), "cut to {length}");
        }
        good.extend([0; LONGEST_PACKET]);
        assert_eq!(read(&good), None);
    }

    #[test]
    fn damaged_packets_neither_panic_nor_hang() {
        let inner = bundle(vec![message("/a/b", vec![OscType::Float(1.0), OscType::String("text".into())])]);
        let good =
            encoder::encode(&bundle(vec![inner, message("/c", vec![OscType::Blob(vec![7; 9])])])).unwrap();
        let mut state = 7u64;
        for _ in 0..20_000 {
            let mut packet = good.clone();
            for _ in 0..3 {
                // Knuth's linear congruential generator.
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % packet.len();
                packet[at] = (state >> 24) as u8;
            }
            let _ = read(&packet);
        }
    }

    #[test]
    fn packets_come_in_over_udp_and_bad_ones_are_counted() {
        let osc = Osc::listen(0, From::Here).unwrap();
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let to = (Ipv4Addr::LOCALHOST, osc.port());
        let packet = encoder::encode(&message("/1/fader1", vec![OscType::Float(0.75)])).unwrap();
        let mut got = Vec::new();
        // Loopback may drop packets under load; a controller would be moved on, too.
        for _ in 0..100 {
            sender.send_to(b"no osc at all", to).unwrap();
            sender.send_to(&[b'/'; 4000], to).unwrap();
            sender.send_to(&packet, to).unwrap();
            std::thread::sleep(Duration::from_millis(20));
            got.extend(osc.messages().map(|(message, _)| message));
            if !got.is_empty() && osc.counts().1 >= 2 {
                break;
            }
        }
        assert_eq!(got[0], Message { address: "/1/fader1".into(), value: Some(0.75), text: None });
        let (good, bad) = osc.counts();
        assert!(good >= 1 && bad >= 2, "{good} {bad}");
    }

    #[test]
    fn a_port_that_is_closed_can_be_opened_at_once() {
        let mut osc = Osc::listen(0, From::Here).unwrap();
        let port = osc.port();
        for _ in 0..5 {
            drop(osc);
            osc = Osc::listen(port, From::Network(Vec::new())).unwrap();
        }
    }

    #[test]
    fn only_those_are_heard_who_may() {
        let [here, near, far] =
            ["127.0.0.1", "192.168.1.20", "10.0.0.9"].map(|ip| ip.parse::<IpAddr>().unwrap());
        let heard = |from: From| [here, near, far].map(|address| from.allows(address));
        assert_eq!(heard(From::Here), [true, false, false]);
        assert_eq!(heard(From::Network(vec![near])), [true, true, false]);
        assert_eq!(heard(From::Network(Vec::new())), [true; 3]);
    }

    /// Prints how many packets a second come and go; a person who measures passes `--nocapture`.
    #[test]
    fn a_flood_is_bounded_and_leaves_the_next_message_through() {
        let osc = Osc::listen(0, From::Here).unwrap();
        let port = osc.port();
        let flood = std::thread::spawn(move || {
            let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            let packet = encoder::encode(&message("/flood", vec![OscType::Float(0.5)])).unwrap();
            let began = Instant::now();
            for i in 0..200_000u32 {
                let bytes: &[u8] = if i % 7 == 0 { b"no osc at all" } else { &packet };
                // A full buffer of the system is a packet lost.
                let _ = sender.send_to(bytes, (Ipv4Addr::LOCALHOST, port));
            }
            began.elapsed().as_secs_f64()
        });
        let (mut taken, mut frames) = (0, 0u32);
        while !flood.is_finished() {
            let count = osc.messages().count();
            assert!(count <= MOST_MESSAGES, "{count}");
            (taken, frames) = (taken + count, frames + 1);
            std::thread::sleep(Duration::from_millis(16));
        }
        let secs = flood.join().unwrap();
        let (good, bad) = osc.counts();
        println!(
            "{:.0} packets/s sent; {good} read, {bad} left out, {taken} taken in {frames} frames",
            2e5 / secs
        );
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let packet = encoder::encode(&message("/after", vec![])).unwrap();
        let arrives = (0..500).any(|_| {
            sender.send_to(&packet, (Ipv4Addr::LOCALHOST, port)).unwrap();
            std::thread::sleep(Duration::from_millis(20));
            osc.messages().any(|(message, _)| message.address == "/after")
        });
        assert!(arrives && good > 0 && bad > 0);
    }
}
