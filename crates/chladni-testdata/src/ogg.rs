//! Ogg files (RFC 3533) byte by byte, for what no encoder writes.

/// The remainder of `bytes` by a polynomial of `bits` bits, the highest first.
pub fn crc(bytes: &[u8], bits: u32, polynomial: u32) -> u32 {
    let top = 1 << (bits - 1);
    let mask = top | (top - 1);
    bytes.iter().fold(0, |crc: u32, &byte| {
        (0..8).fold(crc ^ (u32::from(byte) << (bits - 8)), |crc, _| {
            ((crc << 1) ^ if crc & top == 0 { 0 } else { polynomial }) & mask
        })
    })
}

/// A page that holds a packet, or a part of one that is long; `kind` is 2 for the first page and 4 for the last one.
pub fn ogg_page(number: u32, kind: u8, position: u64, packet: &[u8], ends: bool) -> Vec<u8> {
    let mut lacing = vec![255; packet.len() / 255];
    if ends {
        lacing.push((packet.len() % 255) as u8);
    }
    let mut page = [b"OggS", &[0, kind][..], &position.to_le_bytes(), &[1, 0, 0, 0]].concat();
    page.extend(number.to_le_bytes());
    page.extend([0, 0, 0, 0, lacing.len() as u8]);
    page.extend(lacing);
    page.extend(packet);
    let check = crc(&page, 32, 0x04c1_1db7).to_le_bytes();
    for (at, byte) in page.iter_mut().skip(22).zip(check) {
        *at = byte;
    }
    page
}

/// A file whose sound cannot be decoded, of Vorbis in stereo: `count` times the same code book, given as numbers and how
/// many bits each has.
pub fn vorbis_of_books(count: u32, book: &[(u32, u32)]) -> Vec<u8> {
    let rate_hz = 44_100_u32.to_le_bytes();
    let identification = [b"\x01vorbis\0\0\0\0\x02", &rate_hz[..], &[0; 12], &[0xb8, 1]].concat();
    let books: Vec<_> = std::iter::once((count - 1, 8)).chain(book.repeat(count as usize)).collect();
    let setup = [&b"\x05vorbis"[..], &packed(&books)].concat();
    [
        ogg_page(0, 2, 0, &identification, true),
        ogg_page(1, 0, 0, b"\x03vorbis\0\0\0\0\0\0\0\0\x01", true),
        ogg_page(2, 0, 0, &setup, true),
        ogg_page(3, 4, 64, &[0; 8], true),
    ]
    .concat()
}

/// Numbers of so many bits each, the lowest bit first.
fn packed(numbers: &[(u32, u32)]) -> Vec<u8> {
    let bits: Vec<bool> =
        numbers.iter().flat_map(|(number, count)| (0..*count).map(move |i| (number >> i) & 1 == 1)).collect();
    bits.chunks(8).map(|byte| (0..).zip(byte).map(|(i, bit)| u8::from(*bit) << i).sum()).collect()
}
