//! The end of one song under the beginning of the next.

use std::collections::VecDeque;

use crate::crossfade::crossfade_gain;
use crate::history::Frame;

/// The remaining frames of a song that has ended.
#[derive(Default)]
pub(super) struct Tail {
    frames: VecDeque<Frame>,
    /// Frames of the whole crossfade: its last ones.
    length: usize,
}

impl Tail {
    pub fn of(frames: impl Iterator<Item = Frame>) -> Self {
        let frames: VecDeque<Frame> = frames.collect();
        Self { length: frames.len(), frames }
    }

    /// Frames of the whole crossfade.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Makes the crossfade no longer than `most` frames: those before it are heard alone.
    pub fn shorten(&mut self, most: usize) {
        self.length = self.length.min(most);
    }

    /// Frames that are heard before the next song begins.
    pub fn alone(&self) -> usize {
        self.frames.len().saturating_sub(self.length)
    }

    /// Mixed with the rest of the song before it.
    pub fn over(mut self, mut before: Self) -> Self {
        let longer = self.frames.len().max(before.frames.len());
        Self::of((0..longer).map(|_| {
            let frame = self.next().unwrap_or_default();
            before.mix(frame)
        }))
    }

    pub fn is_over(&self) -> bool {
        self.frames.is_empty()
    }

    /// The next frame, as it is where no song follows, or before it begins.
    pub fn next(&mut self) -> Option<Frame> {
        self.frames.pop_front()
    }

    /// A frame of the next song, with this one's.
    pub fn mix(&mut self, frame: Frame) -> Frame {
        let left = self.frames.len();
        let Some(old) = self.frames.pop_front() else { return frame };
        let share = (self.length as f64 - left as f64 + 0.5) / self.length as f64;
        let (begins, ends) = (crossfade_gain(share), crossfade_gain(1.0 - share));
        [0, 1].map(|side| begins * frame[side] + ends * old[side])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_song_is_heard_alone_before_a_shorter_crossfade() {
        let mut tail = Tail::of((0..10).map(|n| [n as f32, 0.0]));
        tail.shorten(4);
        assert_eq!((tail.len(), tail.alone()), (4, 6));
        let alone: Vec<_> = (0..6).map(|_| tail.next()).collect();
        assert!(alone.iter().enumerate().all(|(n, frame)| *frame == Some([n as f32, 0.0])));
        assert_eq!(tail.alone(), 0);
        let ends = [6.0, 7.0, 8.0, 9.0].map(|old| tail.mix([0.0, 1.0])[0] / old);
        assert!(ends[0] > 0.9 && ends[3] < 0.3 && ends.is_sorted_by(|one, next| one > next), "{ends:?}");
        assert!(tail.is_over());
    }

    #[test]
    fn one_song_fades_into_the_other() {
        let mut tail = Tail::of((0..1000).map(|_| [1.0, 0.0]));
        let mixed: Vec<Frame> = (0..1001).map(|_| tail.mix([0.0, 1.0])).collect();
        assert!(mixed[..1000].iter().all(|[old, new]| (old * old + new * new - 1.0).abs() < 1e-6));
        assert!(mixed.windows(2).all(|pair| pair[0][0] > pair[1][0] && pair[0][1] < pair[1][1]));
        assert!(mixed[0][0] > 0.999 && mixed[999][1] > 0.999 && mixed[1000] == [0.0, 1.0]);
        assert!(tail.is_over());
    }
}
