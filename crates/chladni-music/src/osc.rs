//! OSC packets: what controllers and clocks send over the network.

use rosc::{OscPacket, OscType};

/// Longer packets are bad: controllers send a few dozen bytes.
pub const LONGEST_OSC_PACKET: usize = 1536;
/// Messages that are read of one packet at most.
const MOST_MESSAGES: usize = 256;
/// Bundles within bundles deeper than this are bad.
const DEEPEST_BUNDLE: usize = 8;

/// One message: where it goes and its first number.
#[derive(Clone, Debug, PartialEq)]
pub struct OscMessage {
    /// Such as `/1/fader3`.
    pub address: String,
    /// `None` where it has no argument that is a number.
    pub value: Option<f32>,
    /// Its first text.
    pub text: Option<String>,
}

impl OscMessage {
    /// The messages of one packet, at most 256; `None` if it is not OSC.
    pub fn in_packet(packet: &[u8]) -> Option<Vec<Self>> {
        if packet.len() > LONGEST_OSC_PACKET {
            return None;
        }
        let (rest, packet) = rosc::decoder::decode_udp(packet).ok()?;
        let mut messages = Vec::new();
        (rest.is_empty() && collect(packet, 0, &mut messages)).then_some(messages)
    }
}

fn collect(packet: OscPacket, depth: usize, messages: &mut Vec<OscMessage>) -> bool {
    match packet {
        OscPacket::Message(message) => {
            if messages.len() >= MOST_MESSAGES {
                return false;
            }
            let value = message.args.iter().find_map(number);
            let text = message.args.into_iter().find_map(OscType::string);
            messages.push(OscMessage { address: message.addr, value, text });
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
    use rosc::{OscBundle, OscMessage as Packet, OscTime, encoder};

    fn message(addr: &str, args: Vec<OscType>) -> OscPacket {
        OscPacket::Message(Packet { addr: addr.into(), args })
    }

    fn bundle(content: Vec<OscPacket>) -> OscPacket {
        OscPacket::Bundle(OscBundle { timetag: OscTime { seconds: 0, fractional: 1 }, content })
    }

    fn read_packet(packet: &OscPacket) -> Option<Vec<OscMessage>> {
        OscMessage::in_packet(&encoder::encode(packet).unwrap())
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
                Some(vec![OscMessage { address, value, text: None }])
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
            let cut = OscMessage::in_packet(&good[..length]);
            assert!(cut.is_none_or(|m| m.iter().all(|m| m.value.is_none())), "cut to {length}");
        }
        good.extend([0; LONGEST_OSC_PACKET]);
        assert_eq!(OscMessage::in_packet(&good), None);
    }

    #[test]
    fn damaged_packets_neither_panic_nor_hang() {
        let inner = bundle(vec![message("/a/b", vec![OscType::Float(1.0), OscType::String("text".into())])]);
        let good =
            encoder::encode(&bundle(vec![inner, message("/c", vec![OscType::Blob(vec![7; 9])])])).unwrap();
        let mut chance = chladni_testdata::chance(7);
        for _ in 0..20_000 {
            let mut packet = good.clone();
            for _ in 0..3 {
                let bits = chance();
                let at = (bits >> 33) as usize % packet.len();
                packet[at] = (bits >> 24) as u8;
            }
            let _ = OscMessage::in_packet(&packet);
        }
    }
}
