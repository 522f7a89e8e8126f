//! Boxes of an MP4 file.

/// The content of a box, as it is written.
#[derive(Default)]
pub struct Boxed {
    pub bytes: Vec<u8>,
}

impl Boxed {
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    pub fn u16s(&mut self, values: &[u16]) -> &mut Self {
        self.bytes.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        self
    }

    pub fn u32s(&mut self, values: &[u32]) -> &mut Self {
        self.bytes.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        self
    }

    /// Pictures neither turned nor stretched.
    pub fn matrix(&mut self) -> &mut Self {
        self.u32s(&[0x0001_0000, 0, 0, 0, 0x0001_0000, 0, 0, 0, 0x4000_0000])
    }
}

/// A box of this name.
pub fn boxed(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
    [&(content.len() as u32 + 8).to_be_bytes()[..], name, content].concat()
}

/// A box with a version and flags.
pub fn full(name: &[u8; 4], version: u8, flags: u32, content: &[u8]) -> Vec<u8> {
    let [_, a, b, c] = flags.to_be_bytes();
    boxed(name, &[&[version, a, b, c][..], content].concat())
}

/// A language by its three letters.
pub fn language(letters: &[u8; 3]) -> u16 {
    letters.iter().fold(0, |packed, letter| packed << 5 | u16::from(letter - 0x60))
}

/// A descriptor of AAC, whose own description is shorter than 64 bytes.
pub fn aac_descriptor(description: &[u8]) -> Vec<u8> {
    let tagged = |tag: u8, content: &[u8]| [&[tag, content.len() as u8][..], content].concat();
    // MPEG-4 sound; the size of its buffer and its bit rates stay 0, which says nothing of them.
    let decoder = [&[0x40, 0x15][..], &[0; 11], &tagged(5, description)].concat();
    tagged(3, &[&[0, 0, 0][..], &tagged(4, &decoder), &tagged(6, &[2])].concat())
}
