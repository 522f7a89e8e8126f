//! A film as the background of a dance, decoded by ffmpeg in its own process.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Stdio};

use chladni_view::Picture;
use chladni_view::film::{add_input, ffmpeg};

use super::Error;
use super::formats::ends_in;

/// The endings of films that may stand behind a shape.
pub const FILMS: [&str; 5] = ["mp4", "m4v", "mkv", "mov", "webm"];

/// How ffmpeg calls the formats of these files. It would also read lists of other files, whatever their names end in.
const FORMATS: [&str; 3] = ["mov", "matroska", "m4v"];

/// Pictures a second, whatever the film's own rate: which picture is shown depends on the time alone.
const RATE_HZ: f64 = 25.0;
/// Wider or higher films are scaled down to this many pixels, in films …
pub const LONGEST_SIDE: usize = 1920;
/// … and in the window, which is drawn while it is looked at.
pub const LONGEST_LIVE_SIDE: usize = 960;

/// Films whose shorter side has this many pixels are HD: players take BT.709 for their colors where they name no matrix.
const HD_SIDE: u32 = 720;

/// Whether a file is taken for a film, by its ending.
pub fn is_film(name: &str) -> bool {
    ends_in(Path::new(name), &FILMS)
}

/// A film in a loop. It holds one picture at a time.
pub struct BackFilm {
    path: PathBuf,
    longest_side: usize,
    /// Of its colors, as ffmpeg calls it.
    matrix: &'static str,
    decoder: Decoder,
    /// How many pictures were decoded since its beginning; the last of them is held.
    decoded: u64,
    picture: Picture,
    /// How many it has, once its end was reached.
    length: Option<u64>,
}

impl BackFilm {
    /// Opens a film at its first picture, of at most `longest_side` pixels either way.
    ///
    /// # Errors
    /// One line, where ffmpeg is not there or finds no film in the file.
    pub fn open(name: &str, longest_side: usize) -> Result<Self, Error> {
        let path = PathBuf::from(name);
        // ffmpeg would wait for the writer of a pipe.
        chladni_task::open_file(&path).map_err(|why| Error::Input(format!("{name}: {why}")))?;
        let matrix = matrix_of(&path);
        let mut decoder = Decoder::begin(&path, longest_side, matrix)?;
        let mut picture = Picture { width: 0, height: 0, rgba: Vec::new() };
        if !decoder.next(&mut picture).map_err(|why| Error::Input(format!("{name}: {why}")))? {
            return Err(Error::Input(format!("{name}: {}", decoder.complaint())));
        }
        Ok(Self { path, longest_side, matrix, decoder, decoded: 1, picture, length: None })
    }

    /// The first picture, or the one that was asked for last.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Goes to the picture at a time of the show; returns whether it is a different one. Where it is far ahead, pictures
    /// are decoded one by one only as long as it `goes_on`.
    ///
    /// # Errors
    /// Output of ffmpeg that cannot be read.
    pub fn go_to(&mut self, at_secs: f64, goes_on: impl Fn() -> bool) -> Result<bool, Error> {
        let index = (at_secs.max(0.0) * RATE_HZ + 1e-6) as u64;
        let mut wanted = 1 + self.length.map_or(index, |length| index % length);
        let before = self.decoded;
        while self.decoded != wanted && goes_on() {
            if self.decoded > wanted {
                let again = Decoder::begin(&self.path, self.longest_side, self.matrix)?;
                (self.decoder, self.decoded) = (again, 0);
            }
            let unread = |why| Error::Input(format!("{}: {why}", self.path.display()));
            if self.decoder.next(&mut self.picture).map_err(unread)? {
                self.decoded += 1;
            } else if self.decoded == 0 || self.length.is_some() {
                return Err(unread(std::io::Error::other("the film is shorter than it was")));
            } else {
                self.length = Some(self.decoded);
                wanted = 1 + index % self.decoded;
            }
        }
        Ok(self.decoded != before)
    }
}

/// The matrix of a film's colors, as ffmpeg calls it: the one that the film names, or else BT.709 for HD, where ffmpeg by
/// itself would take BT.601, too.
fn matrix_of(path: &Path) -> &'static str {
    let mut command = ffmpeg();
    command.args(["-nostdin", "-loglevel", "info"]);
    add_input(&mut command, path, &FORMATS);
    command.args(["-an", "-sn", "-vf", "showinfo", "-frames:v", "1", "-f", "null", "-"]);
    // Where nothing can be read of the film, its decoder says why.
    let said = command.stdin(Stdio::null()).output().map(|output| output.stderr).unwrap_or_default();
    if is_untagged_hd(&String::from_utf8_lossy(&said)) { "bt709" } else { "auto" }
}

/// Whether a picture is HD and names no matrix, by what ffmpeg's showinfo has `said` of it.
fn is_untagged_hd(said: &str) -> bool {
    let lines = said.lines().filter(|line| line.contains("Parsed_showinfo"));
    let mut words = lines.flat_map(str::split_whitespace);
    let is_long = |side: &str| side.parse::<u32>().is_ok_and(|side| side >= HD_SIDE);
    let sides = words.clone().find_map(|word| word.strip_prefix("s:")?.split_once('x'));
    sides.is_some_and(|(width, height)| is_long(width) && is_long(height))
        && words.any(|word| word == "color_space:unknown")
}

/// ffmpeg, writing one picture after the other as PPM, which says its size.
struct Decoder {
    child: Child,
    pictures: BufReader<ChildStdout>,
}

impl Decoder {
    fn begin(path: &Path, longest_side: usize, matrix: &str) -> Result<Self, Error> {
        // Pixels that are not square become wider or narrower; none of the sides may be 0, which stands for the film's own.
        let share = format!("min(1,{longest_side}/max(iw*sar,ih))");
        let side = |length: &str| format!("'max(1,round({length}*{share}))'");
        let (width, height) = (side("iw*sar"), side("ih"));
        let fits = format!("fps={RATE_HZ},scale=w={width}:h={height}:in_color_matrix={matrix}");
        let missing = |why| Error::other(format!("ffmpeg, which reads films, cannot be started: {why}"));
        let mut command = ffmpeg();
        command.args(["-nostdin", "-loglevel", "fatal"]);
        add_input(&mut command, path, &FORMATS);
        let mut child = command
            .args(["-an", "-sn", "-vf", &fits, "-f", "image2pipe", "-c:v", "ppm", "-pix_fmt", "rgb24", "-"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(missing)?;
        let pipe = child.stdout.take().ok_or_else(|| missing(std::io::Error::other("no pipe")))?;
        Ok(Self { child, pictures: BufReader::with_capacity(1 << 18, pipe) })
    }

    /// Reads the next picture into `picture`; false at the end.
    fn next(&mut self, picture: &mut Picture) -> std::io::Result<bool> {
        let broken = || std::io::Error::other("ffmpeg does not write pictures");
        let Some(kind) = self.word()? else { return Ok(false) };
        let mut number = || -> std::io::Result<usize> {
            self.word()?.and_then(|word| word.parse().ok()).ok_or_else(broken)
        };
        let [width, height, most] = [number()?, number()?, number()?];
        let sides = 1..=LONGEST_SIDE;
        if kind != "P6" || most != 255 || !sides.contains(&width) || !sides.contains(&height) {
            return Err(broken());
        }
        // Pixels come as three bytes; spreading them from the end needs only one buffer.
        let pixels = width * height;
        picture.rgba.resize(4 * pixels, 255);
        self.pictures.read_exact(&mut picture.rgba[..3 * pixels])?;
        for i in (0..pixels).rev() {
            picture.rgba.copy_within(3 * i..3 * i + 3, 4 * i);
            picture.rgba[4 * i + 3] = 255;
        }
        (picture.width, picture.height) = (width as u32, height as u32);
        Ok(true)
    }

    /// The next word of a header; `None` where nothing comes any more.
    fn word(&mut self) -> std::io::Result<Option<String>> {
        let mut word = String::new();
        loop {
            let Some(byte) = self.pictures.fill_buf()?.first().copied() else { return Ok(None) };
            self.pictures.consume(1);
            match (byte.is_ascii_whitespace(), word.is_empty()) {
                (true, false) => return Ok(Some(word)),
                (true, true) => {}
                (false, _) if word.len() < 16 => word.push(byte as char),
                (false, _) => return Err(std::io::Error::other("ffmpeg does not write pictures")),
            }
        }
    }

    /// The first line of what ffmpeg says.
    fn complaint(&mut self) -> String {
        let mut said = String::new();
        if let Some(errors) = self.child.stderr.take() {
            // Its message only explains; without it the file is still unreadable.
            let _ = errors.take(4096).read_to_string(&mut said);
        }
        let line = said.lines().map(str::trim).find(|line| !line.is_empty());
        line.map_or_else(|| "ffmpeg finds no picture in it".into(), |line| format!("ffmpeg: {line}"))
    }
}

impl Drop for Decoder {
    fn drop(&mut self) {
        // It may have ended by itself; waiting removes its process entry in either case.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_goes_around_and_its_picture_is_a_function_of_the_time() {
        let folder = tempfile::tempdir().unwrap();
        // Ten pictures.
        let film = chladni_testdata::brightening_film(folder.path(), [32, 16], 0.4, 20);
        let Some(path) = film else { return };
        let name = path.to_string_lossy();
        let brightness = |film: &BackFilm| film.picture().rgba[0];
        let mut film = BackFilm::open(&name, LONGEST_SIDE).unwrap();
        assert_eq!((film.picture().width, film.picture().height), (32, 16));
        let mut seen = Vec::new();
        for frame in 0..30 {
            film.go_to(f64::from(frame) / 25.0, || true).unwrap();
            seen.push(brightness(&film));
        }
        assert!(seen[..10].is_sorted() && seen[9] > seen[0] + 100, "{seen:?}");
        assert_eq!((&seen[10..20], &seen[20..]), (&seen[..10], &seen[..10]));
        assert!(!film.go_to(29.5 / 25.0, || true).unwrap());
        // Far ahead, it can be given up after any picture.
        let left = std::cell::Cell::new(2_u32);
        film.go_to(2.5, || left.replace(left.get().saturating_sub(1)) > 0).unwrap();
        assert_eq!(brightness(&film), seen[1]);
        // A film opened in the middle shows the same.
        let mut later = BackFilm::open(&name, LONGEST_SIDE).unwrap();
        for frame in [27, 3, 14] {
            later.go_to(f64::from(frame) / 25.0, || true).unwrap();
            assert_eq!(brightness(&later), seen[frame as usize], "{frame}");
        }
    }

    #[test]
    fn films_of_ten_bits_and_of_pixels_that_are_not_square_are_shown_as_players_do() {
        if !chladni_testdata::program("ffmpeg") {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wide.mkv");
        let made = ffmpeg()
            .args(["-nostdin", "-loglevel", "error", "-f", "lavfi", "-i", "color=gray:s=24x18:r=25:d=0.2"])
            .args(["-vf", "setsar=4/3", "-pix_fmt", "yuv420p10le", "-c:v", "ffv1"])
            .arg(&path)
            .status();
        assert!(made.unwrap().success());
        for (longest_side, size) in [(LONGEST_SIDE, (32, 18)), (16, (16, 9))] {
            let film = BackFilm::open(&path.to_string_lossy(), longest_side).unwrap();
            assert_eq!((film.picture().width, film.picture().height), size);
            assert!(film.picture().rgba[0].abs_diff(128) < 4, "{}", film.picture().rgba[0]);
        }
    }

    #[test]
    fn an_hd_film_that_names_no_matrix_has_the_colors_of_bt_709() {
        if !chladni_testdata::program("ffmpeg") {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let shown = |name: &str, tags: &[&str]| {
            let path = folder.path().join(name);
            let made = ffmpeg()
                .args(["-nostdin", "-loglevel", "error", "-f", "lavfi"])
                .args(["-i", "color=red:s=1280x720:r=25:d=0.04"])
                .args(["-vf", "format=rgb24,scale=out_color_matrix=bt709,format=yuv420p", "-c:v", "ffv1"])
                .args(tags)
                .arg(&path)
                .status();
            assert!(made.unwrap().success());
            let film = BackFilm::open(&path.to_string_lossy(), 160).unwrap();
            film.picture().rgba[..3].to_vec()
        };
        let tagged = shown("tagged.mkv", &["-colorspace", "bt709"]);
        assert!(tagged[0] > 245 && tagged[1] < 5, "{tagged:?}");
        assert_eq!(shown("untagged.mkv", &[]), tagged);
        let said = |size: &str, space: &str| {
            format!("[Parsed_showinfo_0 @ 0] n: 0 s:{size}\n[Parsed_showinfo_0 @ 0] color_space:{space}")
        };
        assert!(is_untagged_hd(&said("720x1280", "unknown")) && !is_untagged_hd(&said("720x576", "unknown")));
        assert!(!is_untagged_hd(&said("1280x720", "smpte170m")) && !is_untagged_hd(""));
    }

    #[test]
    fn a_list_of_other_files_is_no_film_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let Some(path) = chladni_testdata::brightening_film(folder.path(), [32, 16], 0.4, 20) else { return };
        let other = path.file_name().unwrap().to_string_lossy().into_owned();
        let lists = [
            format!("ffconcat version 1.0\nfile {other}\n"),
            format!("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:0.4,\n{other}\n#EXT-X-ENDLIST\n"),
        ];
        for ending in FILMS {
            let named = folder.path().join(format!("list.{ending}"));
            for list in &lists {
                std::fs::write(&named, list).unwrap();
                assert!(BackFilm::open(&named.to_string_lossy(), LONGEST_SIDE).is_err(), "{ending}: {list}");
            }
        }
        // ffmpeg by itself opens what the first one lists.
        let script = folder.path().join("list.mp4");
        std::fs::write(&script, &lists[0]).unwrap();
        let mut alone = ffmpeg();
        alone.args(["-nostdin", "-loglevel", "error", "-i"]).arg(&script).args(["-f", "null", "-"]);
        assert!(alone.status().unwrap().success());
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_refused_without_ffmpeg() {
        let Err(error) = BackFilm::open("/dev/null", LONGEST_SIDE) else { panic!("a film") };
        assert!(error.to_string().ends_with("a device or a pipe, not a file"), "{error}");
    }

    #[test]
    fn what_is_no_film_is_told_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text.mp4").to_string_lossy().into_owned();
        std::fs::write(&path, "no film").unwrap();
        for name in [&*path, "gone.mp4"] {
            let Err(error) = BackFilm::open(name, LONGEST_SIDE) else { panic!("{name}") };
            let line = error.to_string();
            assert!(!line.contains('\n') && !line.is_empty(), "{line}");
        }
        assert!(is_film("a/clouds.MP4") && !is_film("clouds.png") && !is_film("mp4"));
    }
}
