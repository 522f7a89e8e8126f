//! OSC messages over UDP.

use std::collections::VecDeque;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chladni_music::{ClockMessage, LONGEST_OSC_PACKET, OscMessage};

/// Touches that may wait for the next frame, and as many messages of a clock.
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
    touches: Receiver<OscMessage>,
    clock: Arc<Clock>,
    counts: Arc<Counts>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Counts {
    taken: AtomicU64,
    crowded_out: AtomicU64,
    bad: AtomicU64,
    closed: AtomicBool,
}

/// How many packets came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packets {
    /// Those that were taken.
    pub taken: u64,
    /// Those that found no room, or not for all of their messages: more came than a frame takes.
    pub crowded_out: u64,
    /// Those that are not OSC, too long, or of others than may be heard.
    pub bad: u64,
}

/// Messages of a clock, and when they came. Touches cannot fill this queue: nothing empties theirs while another room is
/// open.
#[derive(Default)]
struct Clock(Mutex<VecDeque<(ClockMessage, Instant)>>);

impl Clock {
    /// Adds a message. In a full queue the oldest beat makes room, or else the oldest tempo: later ones replace them.
    fn hear(&self, message: ClockMessage, came: Instant) {
        let mut waiting = self.lock();
        if waiting.len() >= MOST_MESSAGES {
            let oldest = |is: fn(&ClockMessage) -> bool| waiting.iter().position(|(known, _)| is(known));
            let beat = oldest(|known| matches!(known, ClockMessage::Beat { .. }));
            let least = beat.or_else(|| oldest(|known| matches!(known, ClockMessage::Tempo { .. })));
            waiting.remove(least.unwrap_or(0));
        }
        waiting.push_back((message, came));
    }

    /// All of them, which then no longer wait.
    fn take(&self) -> VecDeque<(ClockMessage, Instant)> {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(ClockMessage, Instant)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Osc {
    /// Listens on a UDP port; port 0 takes any free one.
    pub fn listen(port: u16, from: Senders) -> io::Result<Self> {
        let network = if from == Senders::Here { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
        let socket = UdpSocket::bind((network, port))?;
        // The thread looks this often whether the port is to be closed.
        socket.set_read_timeout(Some(Duration::from_millis(200)))?;
        let address = socket.local_addr()?;
        let (touch, touches) = sync_channel(MOST_MESSAGES);
        let (clock, counts) = (Arc::new(Clock::default()), Arc::new(Counts::default()));
        let (ticking, counted) = (Arc::clone(&clock), Arc::clone(&counts));
        let receiver = move || receive(&socket, &from, &touch, &ticking, &counted);
        let thread = Some(std::thread::Builder::new().name("osc".into()).spawn(receiver)?);
        Ok(Self { address, touches, clock, counts, thread })
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// Messages since the last call, without those of a clock.
    pub fn touches(&self) -> impl Iterator<Item = OscMessage> {
        self.touches.try_iter().take(MOST_MESSAGES)
    }

    /// Messages of a clock since the last call, and when they came.
    pub fn clock(&self) -> impl Iterator<Item = (ClockMessage, Instant)> + use<> {
        self.clock.take().into_iter()
    }

    /// The packets so far.
    pub fn packets(&self) -> Packets {
        let Counts { taken, crowded_out, bad, .. } = &*self.counts;
        let [taken, crowded_out, bad] = [taken, crowded_out, bad].map(|count| count.load(Ordering::Relaxed));
        Packets { taken, crowded_out, bad }
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

/// One more packet of that kind.
fn count(kind: &AtomicU64) {
    kind.fetch_add(1, Ordering::Relaxed);
}

fn receive(
    socket: &UdpSocket,
    from: &Senders,
    touch: &SyncSender<OscMessage>,
    clock: &Clock,
    counts: &Counts,
) {
    let mut packet = [0u8; LONGEST_OSC_PACKET + 1];
    while !counts.closed.load(Ordering::Relaxed) {
        let length = match socket.recv_from(&mut packet) {
            Ok((length, sender)) if from.allows(sender.ip()) => length,
            Ok(_) => {
                count(&counts.bad);
                continue;
            }
            Err(why) if matches!(why.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => continue,
            // Such as an unreachable port; wait a little before reading again.
            Err(_) => {
                count(&counts.bad);
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        let Some(messages) = packet.get(..length).and_then(OscMessage::in_packet) else {
            count(&counts.bad);
            continue;
        };
        let (came, mut has_room) = (Instant::now(), true);
        for message in messages {
            match pass_on(message, came, touch, clock) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => has_room = false,
                Err(TrySendError::Disconnected(_)) => return,
            }
        }
        count(if has_room { &counts.taken } else { &counts.crowded_out });
    }
}

/// Sends a message to its queue; fails where it is a touch and finds no room.
fn pass_on(
    message: OscMessage,
    came: Instant,
    touch: &SyncSender<OscMessage>,
    clock: &Clock,
) -> Result<(), TrySendError<OscMessage>> {
    match ClockMessage::from_osc(&message.address, message.value) {
        Some(said) => {
            clock.hear(said, came);
            Ok(())
        }
        None => touch.try_send(message),
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
            got.extend(osc.touches());
            let Packets { taken, bad, .. } = osc.packets();
            if !got.is_empty() && taken >= 1 && bad >= 2 {
                break;
            }
        }
        assert_eq!(got[0], OscMessage { address: "/1/fader1".into(), value: Some(0.75), text: None });
        let packets = osc.packets();
        assert!(packets.taken >= 1 && packets.bad >= 2 && packets.crowded_out == 0, "{packets:?}");
    }

    #[test]
    fn packets_that_find_no_room_are_not_bad() {
        let osc = Osc::listen(0, Senders::Here).unwrap();
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let packet = encoder::encode(&message("/1/fader1", vec![OscType::Float(0.75)])).unwrap();
        let began = Instant::now();
        // Nobody takes them.
        while osc.packets().crowded_out == 0 {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            sender.send_to(&packet, (Ipv4Addr::LOCALHOST, osc.port())).unwrap();
        }
        assert_eq!((osc.touches().count(), osc.packets().bad), (MOST_MESSAGES, 0));
    }

    #[test]
    fn a_clock_is_heard_however_many_touches_and_beats_wait() {
        let ((touch, touches), clock) = (sync_channel(MOST_MESSAGES), Clock::default());
        let hear = |address: &str, value| {
            let message = OscMessage { address: address.into(), value, text: None };
            pass_on(message, Instant::now(), &touch, &clock).is_ok()
        };
        assert_eq!((0..300).filter(|_| hear("/1/fader1", Some(0.5))).count(), MOST_MESSAGES);
        assert!(hear("/start", None) && hear("/tempo", Some(140.0)));
        assert!((0..300).all(|_| hear("/beat", None)) && hear("/stop", None));
        let said: Vec<ClockMessage> = clock.take().into_iter().map(|(message, _)| message).collect();
        assert_eq!(said.len(), MOST_MESSAGES);
        assert_eq!(said[..2], [ClockMessage::Start, ClockMessage::Tempo { bpm: 140.0 }]);
        assert_eq!(said.last(), Some(&ClockMessage::Stop));
        assert_eq!((clock.take().len(), touches.try_iter().count()), (0, MOST_MESSAGES));
        // Of tempos alone the last ones count.
        assert!((20..400).all(|bpm: u16| hear("/tempo", Some(f32::from(bpm)))));
        assert_eq!(clock.take().back().map(|said| said.0), Some(ClockMessage::Tempo { bpm: 399.0 }));
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
    fn it_listens_on_this_machine_only_unless_others_are_wanted() {
        assert_eq!(Senders::default(), Senders::Here);
        assert!(Osc::listen(0, Senders::default()).unwrap().address.ip().is_loopback());
        assert!(Osc::listen(0, Senders::Network(Vec::new())).unwrap().address.ip().is_unspecified());
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
            let count = osc.touches().count();
            assert!(count <= MOST_MESSAGES, "{count}");
            (taken, frames) = (taken + count, frames + 1);
            std::thread::sleep(Duration::from_millis(16));
        }
        let secs = flood.join().unwrap();
        let packets = osc.packets();
        println!("{:.0} packets/s sent; {packets:?}; {taken} messages in {frames} frames", 2e5 / secs);
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let packet = encoder::encode(&message("/after", vec![])).unwrap();
        let (began, mut came) = (Instant::now(), false);
        // The flood may have drowned all packets of one kind.
        while !came || osc.packets().taken == 0 || osc.packets().bad == 0 {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            for bytes in [&packet[..], b"no osc at all"] {
                sender.send_to(bytes, (Ipv4Addr::LOCALHOST, port)).unwrap();
            }
            std::thread::sleep(Duration::from_millis(20));
            came |= osc.touches().any(|message| message.address == "/after");
        }
    }
}
