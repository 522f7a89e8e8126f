//! Frames as they are, for another program to read while they are drawn.

use std::io::Write;

use super::{Encode, FilmSettings};
use crate::{Picture, ViewError};

/// How frames are written one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RawFormat {
    /// Red, green, blue and alpha, 8 bits each, row by row from above; nothing between frames. The reader has to know
    /// size and rate.
    #[default]
    Rgba,
    /// YUV4MPEG2, which says size and rate: 4:4:4, 8 bits, BT.709, limited range, without alpha.
    Y4m,
}

impl RawFormat {
    /// All of them, by their names.
    pub const NAMED: [(&'static str, Self); 2] = [("rgba", Self::Rgba), ("y4m", Self::Y4m)];
}

/// Writes each frame at once.
pub(super) struct Raw<W> {
    to: W,
    format: RawFormat,
    planes: Vec<u8>,
}

impl<W: Write + Send> Raw<W> {
    pub(super) fn begin(mut to: W, format: RawFormat, settings: &FilmSettings) -> Result<Self, ViewError> {
        if format == RawFormat::Y4m {
            let FilmSettings { width, height, rate, .. } = settings;
            let (n, d) = (rate.numerator, rate.denominator);
            writeln!(to, "YUV4MPEG2 W{width} H{height} F{n}:{d} Ip A1:1 C444 XCOLORRANGE=LIMITED")
                .map_err(gone)?;
        }
        Ok(Self { to, format, planes: Vec::new() })
    }
}

fn gone(why: std::io::Error) -> ViewError {
    ViewError::Film(match why.kind() {
        std::io::ErrorKind::BrokenPipe => "whoever read its frames has gone".into(),
        _ => format!("its frames could not be written: {why}"),
    })
}

impl<W: Write + Send> Encode for Raw<W> {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let written = match self.format {
            RawFormat::Rgba => self.to.write_all(&picture.rgba),
            RawFormat::Y4m => {
                planes(&picture.rgba, &mut self.planes);
                self.to.write_all(b"FRAME\n").and_then(|()| self.to.write_all(&self.planes))
            }
        };
        // Standard output keeps what does not end in a line break, and the next frame may be long in coming.
        written.and_then(|()| self.to.flush()).map_err(gone)
    }

    fn finish(mut self: Box<Self>) -> Result<(), ViewError> {
        self.to.flush().map_err(gone)
    }
}

/// Y, then U, then V of each pixel (ITU-R BT.709, 8 bits, 16 to 235 and 16 to 240); transparent pixels become black.
fn planes(rgba: &[u8], out: &mut Vec<u8>) {
    let pixels = rgba.as_chunks::<4>().0;
    out.clear();
    out.resize(3 * pixels.len(), 0);
    let (y, uv) = out.split_at_mut(pixels.len());
    let (u, v) = uv.split_at_mut(pixels.len());
    for (((pixel, y), u), v) in pixels.iter().zip(y).zip(u).zip(v) {
        let alpha = f32::from(pixel[3]) / 255.0;
        let [r, g, b] = [0, 1, 2].map(|i| alpha * f32::from(pixel[i]) / 255.0);
        let luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        *y = (16.0 + 219.0 * luma).round() as u8;
        *u = (128.0 + 224.0 * (b - luma) / 1.8556).round() as u8;
        *v = (128.0 + 224.0 * (r - luma) / 1.5748).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Film, FrameRate};
    use super::*;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Pipe(Arc<Mutex<Vec<u8>>>, Option<usize>);

    impl Write for Pipe {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let mut kept = self.0.lock().unwrap();
            if self.1.is_some_and(|most| kept.len() + bytes.len() > most) {
                return Err(std::io::ErrorKind::BrokenPipe.into());
            }
            kept.extend(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn settings(frames: u64) -> FilmSettings {
        FilmSettings { width: 3, height: 2, rate: FrameRate::per_second(25), frames, first: 0, audio: None }
    }

    fn picture(shade: u8) -> Picture {
        Picture { width: 3, height: 2, rgba: vec![shade; 24] }
    }

    #[test]
    fn frames_come_out_as_they_went_in() {
        let pipe = Pipe::default();
        let mut film = Film::to_pipe(pipe.clone(), RawFormat::Rgba, settings(3)).unwrap();
        for shade in [0, 100, 255] {
            film.push(&picture(shade)).unwrap();
        }
        film.finish().unwrap();
        let bytes = pipe.0.lock().unwrap().clone();
        assert_eq!(bytes, [[0u8; 24], [100; 24], [255; 24]].concat());
    }

    #[test]
    fn each_frame_is_there_before_the_next_one_is_drawn() {
        for (format, head) in [(RawFormat::Rgba, 0), (RawFormat::Y4m, 6)] {
            let pipe = Pipe::default();
            // As standard output keeps what does not end in a line break.
            let lines = std::io::LineWriter::new(pipe.clone());
            let mut film = Film::to_pipe(lines, format, settings(2)).unwrap();
            let before = pipe.0.lock().unwrap().len();
            film.push(&picture(100)).unwrap();
            let there = pipe.0.lock().unwrap().len() - before;
            assert_eq!(there, head + if format == RawFormat::Rgba { 24 } else { 18 });
        }
    }

    #[test]
    fn y4m_says_its_size_and_has_the_colors_of_bt_709() {
        let pipe = Pipe::default();
        let mut film = Film::to_pipe(pipe.clone(), RawFormat::Y4m, settings(1)).unwrap();
        let rgba = [
            [0, 0, 0, 255],
            [255, 255, 255, 255],
            [255, 0, 0, 255],
            [0, 255, 0, 255],
            [0, 0, 255, 255],
            [9, 9, 9, 0],
        ];
        film.push(&Picture { width: 3, height: 2, rgba: rgba.concat() }).unwrap();
        film.finish().unwrap();
        let bytes = pipe.0.lock().unwrap().clone();
        let head = b"YUV4MPEG2 W3 H2 F25:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\nFRAME\n";
        assert_eq!(&bytes[..head.len()], head);
        // The corners of the cube as the recommendation tabulates them.
        let expected =
            [[16, 235, 63, 173, 32, 16], [128, 128, 102, 42, 240, 128], [128, 128, 240, 26, 118, 128]];
        assert_eq!(bytes[head.len()..], expected.concat());
    }

    #[test]
    fn a_reader_that_goes_ends_the_film_with_a_message() {
        let pipe = Pipe(Arc::default(), Some(60));
        let mut film = Film::to_pipe(pipe, RawFormat::Rgba, settings(100)).unwrap();
        let stopped =
            (0..100).find_map(|_| film.push(&picture(1)).err()).unwrap_or_else(|| film.finish().unwrap_err());
        assert!(stopped.to_string().contains("has gone"), "{stopped}");
    }
}
