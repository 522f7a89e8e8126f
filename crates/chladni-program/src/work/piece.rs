//! Pieces of work that many machines share: disjoint, and together the whole.

use std::ops::Range;
use std::str::FromStr;

use super::Error;

/// Piece `number` of `of`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: u64,
    of: u64,
}

impl Share {
    /// Which of `total` things are in it: a run of neighbors, of the same length as in every other piece or
    /// one more or less.
    pub fn range(self, total: u64) -> Range<u64> {
        let end = |number: u64| (u128::from(total) * u128::from(number) / u128::from(self.of)) as u64;
        end(self.number - 1)..end(self.number)
    }
}

impl FromStr for Share {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |t: &str| t.parse::<u64>().ok().filter(|n| (1..=1_000_000).contains(n));
        text.split_once('/')
            .and_then(|(i, n)| Some(Self { number: number(i)?, of: number(n)? }))
            .filter(|share| share.number <= share.of)
            .ok_or_else(|| Error::input("expected I/N, such as 2/8: the second of eight pieces"))
    }
}

/// Some of the frames of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// From the first one to before the second, counted from 0.
    Frames(Range<u64>),
    /// A piece of all.
    Share(Share),
}

impl Piece {
    /// The frames it has of a film of `total`; `None` where it goes beyond its end or is empty.
    pub fn frames(&self, total: u64) -> Option<Range<u64>> {
        let range = match self {
            Self::Frames(range) => range.clone(),
            Self::Share(share) => share.range(total),
        };
        (!range.is_empty() && range.end <= total).then_some(range)
    }
}

impl FromStr for Piece {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        if text.contains('/') {
            return text.parse().map(Self::Share);
        }
        text.split_once("..")
            .and_then(|(from, to)| Some(from.parse().ok()?..to.parse().ok()?))
            .filter(|range| !range.is_empty())
            .map(Self::Frames)
            .ok_or_else(|| {
                Error::input("expected frames A..B (B itself is not among them), or I/N, such as 2/8")
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_read_as_they_are_written() {
        assert_eq!("10..30".parse::<Piece>().unwrap(), Piece::Frames(10..30));
        assert_eq!("10..30".parse::<Piece>().unwrap().frames(30), Some(10..30));
        assert_eq!("10..31".parse::<Piece>().unwrap().frames(30), None);
        assert_eq!("2/3".parse::<Piece>().unwrap().frames(9), Some(3..6));
        assert_eq!("3/4".parse::<Piece>().unwrap().frames(1), None);
        for text in [
            "",
            "3",
            "5..5",
            "7..2",
            "a..b",
            "-1..4",
            "..4",
            "4..",
            "0/3",
            "4/3",
            "1/0",
            "1/2/3",
            "1/9999999",
        ] {
            assert!(text.parse::<Piece>().is_err(), "{text}");
        }
    }

    #[test]
    fn shares_follow_each_other_and_are_alike() {
        for (total, of) in [(0, 3), (1, 4), (7, 7), (100, 7), (100, 1), (99_999, 300), (u64::MAX, 999)] {
            let mut next = 0;
            for number in 1..=of {
                let range = Share { number, of }.range(total);
                assert_eq!(range.start, next);
                let size = range.end - range.start;
                assert!(size == total / of || size == total.div_ceil(of), "{size} of {total} in {of}");
                next = range.end;
            }
            assert_eq!(next, total);
        }
    }
}
