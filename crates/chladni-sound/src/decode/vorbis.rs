//! How much memory the code books of a Vorbis stream take (Vorbis I specification, §3.2.1), before its decoder makes them: of
//! twenty bytes in a header, Symphonia 0.6 makes 16 MiB of vectors or 128 MiB of tables, and there may be 256 such books.

/// The identification header, which comes first in what containers hand on (§4.2.2).
const IDENTIFICATION: usize = 30;
/// What the setup header begins with (§4.2.1).
const SETUP: &[u8] = b"\x05vorbis";
/// The first bits of a book.
const SYNC: u32 = 0x0056_4342;
/// Symphonia refuses books of more entries or dimensions.
const MOST_ENTRIES: u32 = 1 << 17;
const MOST_DIMENSIONS: u32 = 32;
const LONGEST_WORD: usize = 32;

/// The bits of a packet, the lowest of each byte first (§2.1.4).
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Bits<'_> {
    fn take(&mut self, count: u32) -> Option<u32> {
        (0..count).try_fold(0, |number, i| Some(number | (u32::from(self.flag()?) << i)))
    }

    fn flag(&mut self) -> Option<bool> {
        let byte = self.bytes.get(self.at / 8)?;
        let flag = (byte >> (self.at % 8)) & 1 == 1;
        self.at += 1;
        Some(flag)
    }

    fn pass(&mut self, count: usize) -> Option<()> {
        self.at = self.at.checked_add(count)?;
        (self.at <= self.bytes.len().checked_mul(8)?).then_some(())
    }
}

/// The most bytes that the decoder takes at once for the code books of these headers: all up to the first that it refuses.
pub(super) fn bytes_of_books(headers: &[u8]) -> u64 {
    let Some(setup) = headers.get(IDENTIFICATION..).and_then(|rest| rest.strip_prefix(SETUP)) else {
        return 0;
    };
    let mut bits = Bits { bytes: setup, at: 0 };
    let count = bits.take(8).map_or(0, |more| more + 1);
    let books: Vec<Book> = (0..count).map_while(|_| Book::read(&mut bits)).collect();
    let growing = books.iter().map(|book| book.tables / 2).max().unwrap_or(0);
    books.iter().map(|book| book.vectors + book.words + book.tables).sum::<u64>() + growing
}

/// The bytes that a code book takes.
#[derive(Debug)]
struct Book {
    vectors: u64,
    words: u64,
    /// As they grow one by one, a list of half that size is there beside them for a while.
    tables: u64,
}

impl Book {
    /// That which begins here; `None` where it is refused before it takes anything.
    fn read(bits: &mut Bits) -> Option<Self> {
        let is_book = bits.take(24)? == SYNC;
        let (dimensions, entries) = (bits.take(16)?, bits.take(24)?);
        if !is_book || !(1..=MOST_DIMENSIONS).contains(&dimensions) || entries > MOST_ENTRIES {
            return None;
        }
        let lengths = word_lengths(bits, entries)?;
        let has_vectors = match bits.take(4)? {
            0 => false,
            kind @ (1 | 2) => {
                bits.pass(64)?;
                let bits_each = bits.take(4)? + 1;
                bits.pass(1)?;
                let values =
                    if kind == 1 { lookup1_values(entries, dimensions) } else { entries * dimensions };
                bits.pass(values as usize * bits_each as usize)?;
                true
            }
            _ => return None,
        };
        let vectors = if has_vectors { 4 * u64::from(entries) * u64::from(dimensions) } else { 0 };
        // Its length, itself, its entry and its place in the tree, which takes up to twice that while it grows.
        let words = 32 * lengths.iter().map(|count| u64::from(*count)).sum::<u64>();
        Some(Self { vectors, words, tables: bytes_of_tables(&lengths) })
    }
}

/// How many words there are of each length in bits, which the decoder keeps in a byte. Where it is above 32, the decoder panics,
/// but has made the vectors by then.
fn word_lengths(bits: &mut Bits, entries: u32) -> Option<[u32; LONGEST_WORD + 1]> {
    let mut lengths = [0; LONGEST_WORD + 1];
    let mut add = |length: u32, count: u32| {
        if let Some(words) = lengths.get_mut(usize::from(length as u8)) {
            *words += count;
        }
    };
    if bits.flag()? {
        let (mut length, mut left) = (bits.take(5)? + 1, entries);
        loop {
            let count = bits.take(u32::BITS - left.leading_zeros())?;
            add(length, count);
            left = left.checked_sub(count)?;
            if left == 0 {
                break;
            }
            length += 1;
        }
    } else {
        let is_sparse = bits.flag()?;
        for _ in 0..entries {
            if !is_sparse || bits.flag()? {
                add(bits.take(5)? + 1, 1);
            }
        }
    }
    Some(lengths)
}

/// The greatest number whose power of `dimensions` is not above `entries` (§9.2.3).
fn lookup1_values(entries: u32, dimensions: u32) -> u32 {
    let is_above = |value: u32| value.checked_pow(dimensions).is_none_or(|power| power > entries);
    let mut value = f64::from(entries).powf(1.0 / f64::from(dimensions)) as u32 + 1;
    while is_above(value) {
        value -= 1;
    }
    value
}

/// Of the tables in which words are looked up, each by as many bits as the longest has, from four to eight. In a complete
/// code, as many of them begin after d bits as the longer words take of all words of d bits; others are refused.
fn bytes_of_tables(lengths: &[u32; LONGEST_WORD + 1]) -> u64 {
    let longest = lengths.iter().rposition(|count| *count > 0).unwrap_or(0);
    let width = longest.clamp(4, 8);
    let tables = |depth: usize| {
        let longer = (0..)
            .zip(lengths)
            .skip(depth + 1)
            .map(|(length, count)| u64::from(*count) << (LONGEST_WORD - length));
        longer.sum::<u64>() >> (LONGEST_WORD - depth)
    };
    let count = (0..longest).step_by(width).map(tables).sum::<u64>();
    // Eight bytes for each place of a table in a list that doubles, and some hundred for what the table is made from.
    (8 << width) * count.next_power_of_two() + 128 * count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_counted_by_the_words_that_need_them() {
        let tables = |words: &[(usize, u32)]| {
            let mut lengths = [0; LONGEST_WORD + 1];
            for (length, count) in words {
                lengths[*length] = *count;
            }
            bytes_of_tables(&lengths)
        };
        // With room for as many tables as the next power of two.
        let large = |count: u64, room: u64| (8 << 8) * room + 128 * count;
        assert_eq!(tables(&[]), 8 << 4);
        assert_eq!(tables(&[(1, 2)]), (8 << 4) + 128);
        assert_eq!(tables(&[(8, 256)]), large(1, 1));
        // Of two tables, the second is behind the one word that is not used.
        assert_eq!(tables(&[(8, 255), (9, 2)]), large(2, 2));
        assert_eq!(tables(&[(9, 512)]), large(257, 512));
        assert_eq!(tables(&[(17, 1 << 17)]), large(1 + 256 + 65_536, 1 << 17));
    }

    #[test]
    fn lattices_have_as_many_values_as_fit() {
        for entries in [0, 1, 2, 3, 4, 8, 9, 80, 81, 82, 6561, 1 << 17] {
            for dimensions in [1, 2, 3, 4, 8, 17, 32] {
                let value = lookup1_values(entries, dimensions);
                let power = |value: u32| u64::from(value).checked_pow(dimensions).unwrap_or(u64::MAX);
                assert!(power(value) <= u64::from(entries), "{entries}, {dimensions}: {value}");
                assert!(power(value + 1) > u64::from(entries), "{entries}, {dimensions}: {value}");
            }
        }
    }
}
