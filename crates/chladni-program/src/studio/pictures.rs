//! Small pictures of samples and recent files, for the start screen.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use chladni_mesh::{Frame, samples};
use chladni_view::{
    Background, Camera, Device, Picture, PictureRequest, PictureShape, Style, View, render_picture,
};

use super::folders::whole_path;
use super::job::Job;
use crate::work::is_flat;
use crate::work::source::sample_path;

/// Pixels of a picture, twice its size on an ordinary screen.
pub const SIZE: [u32; 2] = [328, 216];

/// Pictures that are shown, and those being loaded.
pub struct Pictures {
    device: Device,
    folder: Option<PathBuf>,
    /// `None` where there is no picture.
    held: HashMap<String, Option<egui::TextureHandle>>,
    /// One at a time: the start screen is not urgent.
    coming: Option<(String, Job<Option<Picture>>)>,
    /// Pictures on their way to the disk, by the keys of their files.
    keeping: Vec<(String, Job<()>)>,
}

impl Pictures {
    /// Pictures of files are kept in `folder`.
    pub fn new(device: Device, folder: Option<PathBuf>) -> Self {
        Self { device, folder, held: HashMap::new(), coming: None, keeping: Vec::new() }
    }

    /// The picture of a sample shape; drawn beside the window the first time.
    pub fn of_sample(&mut self, ctx: &egui::Context, name: &'static str) -> Option<egui::TextureHandle> {
        let device = self.device.clone();
        self.of(ctx, sample_path(name).to_string_lossy().into_owned(), move || portrait(&device, name))
    }

    /// Whether the picture of a sample is still to come.
    pub fn awaits_sample(&self, name: &str) -> bool {
        !self.held.contains_key(&*sample_path(name).to_string_lossy())
    }

    /// The picture that was kept of the file at `path`.
    pub fn of_file(&mut self, ctx: &egui::Context, path: &Path) -> Option<egui::TextureHandle> {
        let file = self.file(path)?;
        self.forget_old();
        let read = move || Picture::decode(&std::fs::read(file).ok()?).ok();
        self.of(ctx, key(path), read)
    }

    /// Keeps what `draw` draws, on a thread of its own, as the picture of the file at `path`. A
    /// picture that cannot be kept is not missed.
    pub fn keep(
        &mut self,
        ctx: &egui::Context,
        path: &Path,
        draw: impl FnOnce() -> Option<Picture> + Send + 'static,
    ) {
        let Some(file) = self.file(path) else { return };
        self.forget_old();
        let job = Job::start("Keeping a picture", ctx, move |_| {
            let kept = || {
                chladni_task::create_folder(file.parent()?).ok()?;
                chladni_task::write_atomic(&file, &draw()?.to_png().ok()?).ok()
            };
            kept();
            Ok(())
        });
        self.keeping.push((key(path), job));
    }

    /// Forgets what was read before a new picture of the same file was there.
    fn forget_old(&mut self) {
        let Self { held, coming, keeping, .. } = self;
        keeping.retain(|(kept, job)| {
            let ended = job.ended().is_some();
            if ended {
                held.remove(kept);
                coming.take_if(|(key, _)| key == kept);
            }
            !ended
        });
    }

    fn of(
        &mut self,
        ctx: &egui::Context,
        key: String,
        make: impl FnOnce() -> Option<Picture> + Send + 'static,
    ) -> Option<egui::TextureHandle> {
        if let Some(held) = self.held.get(&key) {
            return held.clone();
        }
        match self.coming.as_ref().map(|(_, job)| job.ended()) {
            None => self.coming = Some((key, Job::start("Drawing", ctx, move |_| Ok(make())))),
            Some(None) => {}
            Some(Some(drawn)) => {
                // A picture that cannot be drawn is not missed.
                let picture = drawn.ok().flatten();
                let (done, _) = self.coming.take()?;
                let texture = picture.map(|picture| upload(ctx, &done, &picture));
                self.held.insert(done, texture);
                ctx.request_repaint();
            }
        }
        None
    }

    fn file(&self, path: &Path) -> Option<PathBuf> {
        let path = whole_path(path);
        let mut hasher = DefaultHasher::new();
        path.hash(&mut hasher);
        Some(self.folder.as_ref()?.join(format!("{:016x}.png", hasher.finish())))
    }
}

/// The name of a file's picture among those that are held.
fn key(path: &Path) -> String {
    whole_path(path).to_string_lossy().into_owned()
}

/// A picture as a texture.
pub fn upload(ctx: &egui::Context, name: &str, picture: &Picture) -> egui::TextureHandle {
    let size = [picture.width as usize, picture.height as usize];
    let image = egui::ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
    ctx.load_texture(name, image, egui::TextureOptions::LINEAR)
}

fn portrait(device: &Device, name: &str) -> Option<Picture> {
    let mesh = samples::sample(name)?;
    let frame = Frame::of(&mesh);
    let positions: Vec<[f32; 3]> =
        mesh.positions.iter().map(|p| frame.to_working(*p).map(|c| c as f32)).collect();
    let [width, height] = SIZE;
    let shape = PictureShape { positions: &positions, triangles: &mesh.triangles, ..PictureShape::default() };
    let style = Style { background: Background::TRANSPARENT, ..Style::default() };
    let usual = Camera::looking(View::ThreeQuarter);
    // Sheets lie: they are seen from above, at an angle.
    let from = if is_flat(&positions) { Camera { pitch_rad: 0.85, ..usual } } else { usual };
    let request = PictureRequest { shapes: &[shape], width, height, from, style };
    render_picture(device, &request).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    /// Asks for the picture of a file as frames do, until `done`.
    fn ask(pictures: &mut Pictures, ctx: &egui::Context, path: &Path, done: impl Fn(&Pictures) -> bool) {
        let start = Instant::now();
        while !done(pictures) {
            assert!(start.elapsed() < chladni_testdata::HANGS, "it never came");
            pictures.of_file(ctx, path);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_picture_that_was_asked_for_before_it_was_kept_is_seen_once_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let (ctx, path) = (egui::Context::default(), folder.path().join("a.chladni"));
        let mut pictures = Pictures::new(Device::Processor, Some(folder.path().join("pictures")));
        // Those of four sizes, each drawn only when it is let go.
        for width in [2, 3, 4, 5] {
            let (go, waits) = channel::<()>();
            pictures.keep(&ctx, &path, move || {
                waits.recv().ok()?;
                Some(Picture { width, height: 1, rgba: vec![255; 4 * width as usize] })
            });
            // Meanwhile there is none, or the one before.
            ask(&mut pictures, &ctx, &path, |pictures| pictures.held.contains_key(&key(&path)));
            go.send(()).unwrap();
            let seen = |pictures: &Pictures| {
                let held = pictures.held.get(&key(&path)).and_then(Option::as_ref);
                held.is_some_and(|texture| texture.size() == [width as usize, 1])
            };
            ask(&mut pictures, &ctx, &path, seen);
        }
    }
}
