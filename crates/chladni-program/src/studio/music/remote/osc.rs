//! OSC messages over UDP.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chladni_music::{LONGEST_OSC_PACKET, OscMessage};

/// Messages that may wait for the next frame.
const MOST_MESSAGES: usize = 256;

/// Whose messages are heard.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Senders {
    /// Those of this machine.
    #[default]
    Here,
    /// Those of other machines, too: of these, or of any where none is named.
    Network(Vec<IpAddr>),
}

impl Senders {
    fn allows(&self, address: IpAddr) -> bool {
        address.is_loopback()
            || matches!(self, Self::Network(allowed) if allowed.is_empty() || allowed.contains(&address))
    }
}

/// A port that is listened to. Dropping it closes the port.
pub struct Osc {
    address: SocketAddr,
    messages: Receiver<(OscMessage, Instant)>,
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
    pub fn listen(port: u16, from: Senders) -> io::Result<Self> {
        let network = if from == Senders::Here { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
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

    /// Messages since the last call, and when they came.
    pub fn messages(&self) -> impl Iterator<Item = (OscMessage, Instant)> {
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

fn receive(socket: &UdpSocket, from: &Senders, sender: &SyncSender<(OscMessage, Instant)>, counts: &Counts) {
    let mut packet = [0u8; LONGEST_OSC_PACKET + 1];
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
        let Some(messages) = packet.get(..length).and_then(OscMessage::in_packet) else {
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

#[cfg(test)]
mod tests {
    use super::*;
    use rosc::{OscMessage as Packet, OscPacket, OscType, encoder};

    fn message(addr: &str, args: Vec<OscType>) -> OscPacket {
        OscPacket::Message(Packet { addr: addr.into(), args })
    }

    #[test]
    fn packets_come_in_over_udp_and_bad_ones_are_counted() {
        let osc = Osc::listen(0, Senders::Here).unwrap();
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let to = (Ipv4Addr::LOCALHOST, osc.port());
        let packet = encoder::encode(&message("/1/fader1", vec![OscType::Float(0.75)])).unwrap();
        let mut got = Vec::new();
        // Loopback may drop packets under load; a controller would be moved on, too.
        for _ in 0..10_000 {
            sender.send_to(b"no osc at all", to).unwrap();
            sender.send_to(&[b'/'; 4000], to).unwrap();
            sender.send_to(&packet, to).unwrap();
            std::thread::sleep(Duration::from_millis(20));
            got.extend(osc.messages().map(|(message, _)| message));
            if !got.is_empty() && osc.counts().1 >= 2 {
                break;
            }
        }
        assert_eq!(got[0], OscMessage { address: "/1/fader1".into(), value: Some(0.75), text: None });
        let (good, bad) = osc.counts();
        assert!(good >= 1 && bad >= 2, "{good} {bad}");
    }

    #[test]
    fn a_port_that_is_closed_can_be_opened_at_once() {
        let mut osc = Osc::listen(0, Senders::Here).unwrap();
        let port = osc.port();
        for _ in 0..5 {
            drop(osc);
            osc = Osc::listen(port, Senders::Network(Vec::new())).unwrap();
        }
    }

    #[test]
    fn only_those_are_heard_who_may() {
        let [here, near, far] =
            ["127.0.0.1", "192.168.1.20", "10.0.0.9"].map(|ip| ip.parse::<IpAddr>().unwrap());
        let heard = |from: Senders| [here, near, far].map(|address| from.allows(address));
        assert_eq!(heard(Senders::Here), [true, false, false]);
        assert_eq!(heard(Senders::Network(vec![near])), [true, true, false]);
        assert_eq!(heard(Senders::Network(Vec::new())), [true; 3]);
    }

    /// Prints how many packets a second come and go; a person who measures passes `--nocapture`.
    #[test]
    fn a_flood_is_bounded_and_leaves_the_next_message_through() {
        let osc = Osc::listen(0, Senders::Here).unwrap();
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
        let began = Instant::now();
        while !osc.messages().any(|(message, _)| message.address == "/after") {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            sender.send_to(&packet, (Ipv4Addr::LOCALHOST, port)).unwrap();
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(good > 0 && bad > 0);
    }
}
