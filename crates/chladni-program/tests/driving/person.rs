//! A person at the window, and the files on the desk.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::PathBuf;
use std::time::Duration;

use chladni_mesh::{TriMesh, samples, save_mesh};
use chladni_program::studio::{Folders, Opening};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2, pos2, vec2};
use egui_kittest::kittest::Queryable;

use super::{self as driving, Answers, Window};

/// A folder with `shape.obj` and `template.obj`, two lumps of 642 vertices, and preferences that
/// ask for few harmonics.
pub struct Desk {
    pub folder: tempfile::TempDir,
    pub answers: Answers,
}

/// Harmonics that windows on a [`Desk`] solve for.
pub const HARMONICS: usize = 48;

impl Desk {
    pub fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap(), answers: Answers::default() };
        save_mesh(&lump(0.5), &desk.path("shape.obj")).unwrap();
        save_mesh(&lump(0.2), &desk.path("template.obj")).unwrap();
        std::fs::write(desk.path("settings.toml"), format!("harmonics = {HARMONICS}\n")).unwrap();
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn sit_down(&self, files: &[&str]) -> Person {
        Person::new(self.opening(files))
    }

    /// A person at the shape, with a layer against each of these kinds of template, of which the last is chosen.
    pub fn with_layers(&self, templates: &[&str]) -> Person {
        let mut person = self.sit_down(&["shape.obj"]);
        person.wait_to_see("Layers");
        templates.iter().for_each(|template| person.add_layer(template));
        person
    }

    pub fn opening(&self, files: &[&str]) -> Opening {
        Opening {
            folders: Folders {
                settings: Some(self.path("settings.toml")),
                recovery: Some(self.path("recovery")),
                pictures: Some(self.path("pictures")),
                ..Folders::default()
            },
            chooser: Box::new(self.answers.clone()),
            files: files.iter().map(|name| self.path(name)).collect(),
            patience: Duration::MAX,
            now: driving::no_time,
            ..Opening::default()
        }
    }
}

/// The shape of a [`Desk`] with 2,562 vertices.
pub fn finer_lump() -> TriMesh {
    lump_of(samples::icosphere(4), 0.5)
}

/// An asymmetric lump, smooth enough to be matched.
pub fn lump(size: f64) -> TriMesh {
    lump_of(samples::icosphere(3), size)
}

fn lump_of(mut mesh: TriMesh, size: f64) -> TriMesh {
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = 3.0 + size * ((2.0 * x + 0.5).sin() + 0.7 * y * z + 0.4 * (3.0 * z).cos());
        *p = [r * x, 1.3 * r * y, 0.8 * r * z];
    }
    mesh
}

/// How many pixels differ visibly between two pictures of one size. Small differences do not count: edges may still be
/// refined.
pub fn differing(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 24)).count()
}

/// The window and the person in front of it.
pub struct Person(pub Window);

impl Person {
    pub fn new(opening: Opening) -> Self {
        let mut person = Self(driving::open(opening, [1280.0, 800.0]));
        person.0.run_steps(3);
        person
    }

    /// Steps until `ready`, as a person waits.
    pub fn wait(&mut self, what: &str, ready: impl Fn(&Window) -> bool) {
        driving::wait(&mut self.0, what, ready);
    }

    pub fn sees(&self, text: &str) -> bool {
        driving::shows(&self.0, text)
    }

    pub fn wait_to_see(&mut self, text: &str) {
        self.wait(text, |window| driving::shows(window, text));
    }

    pub fn wait_until_gone(&mut self, text: &str) {
        self.wait(&format!("the end of “{text}”"), |window| !driving::shows(window, text));
    }

    /// Drops files on the window, all at once.
    pub fn drop_files(&mut self, paths: &[PathBuf]) {
        driving::drop_files(&mut self.0, paths);
    }

    /// The part of the window at `area`, as it is painted.
    pub fn picture_of(&mut self, area: Rect) -> image::RgbaImage {
        let picture = self.0.render().unwrap();
        let [x, y, width, height] =
            [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
        image::imageops::crop_imm(&picture, x, y, width, height).to_image()
    }

    /// Clicks the control that is known as `id`.
    pub fn click(&mut self, id: &str) {
        driving::control(&self.0, id).click();
        self.0.run_steps(3);
    }

    /// Clicks twice in one moment, some time after all clicks before.
    pub fn double_click(&mut self, id: &str) {
        let later = self.0.ctx.input(|input| input.time) + 10.0;
        self.0.input_mut().time = Some(later);
        for _ in 0..2 {
            driving::control(&self.0, id).click();
        }
        self.0.run_steps(3);
        self.0.input_mut().time = None;
    }

    pub fn press(&mut self, key: Key) {
        self.press_with(Modifiers::NONE, key);
    }

    pub fn press_with(&mut self, modifiers: Modifiers, key: Key) {
        self.0.key_press_modifiers(modifiers, key);
        self.0.run_steps(2);
    }

    /// Drags with the left button along `path`.
    pub fn drag(&mut self, path: &[Pos2]) {
        self.hold(path);
        self.release(path[path.len() - 1]);
    }

    /// Presses the left button where `path` begins, and holds it along it.
    pub fn hold(&mut self, path: &[Pos2]) {
        self.0.hover_at(path[0]);
        self.0.run_steps(1);
        self.0.event(left_button(path[0], true));
        for pos in path {
            self.0.hover_at(*pos);
            self.0.run_steps(1);
        }
    }

    pub fn release(&mut self, pos: Pos2) {
        self.0.event(left_button(pos, false));
        self.0.run_steps(2);
    }

    pub fn click_at(&mut self, pos: Pos2) {
        self.drag(&[pos]);
    }

    pub fn place_of(&self, id: &str) -> Rect {
        driving::control(&self.0, id).rect()
    }

    /// Adds a layer against a template of this kind.
    pub fn add_layer(&mut self, template: &str) {
        self.click("add");
        self.click(&format!("template/{template}"));
    }

    /// Scrolls to a control that may lie beyond the edge of its panel.
    pub fn scroll_to(&mut self, id: &str) {
        driving::control(&self.0, id).scroll_to_me();
        self.0.run_steps(20);
    }

    /// Gives the slider called `name` a value, as assistive technology does.
    pub fn slide(&mut self, name: &str, value: f64) {
        self.0.get_by_role_and_label(Role::Slider, name).set_value_accesskit(value);
        self.0.run_steps(3);
    }

    /// Draws the middle of the scale curve of the chosen layer upward.
    pub fn bend_scale_curve(&mut self) {
        self.scroll_to("scale-curve");
        let curve = self.place_of("scale-curve");
        let at = |u: f32, v: f32| curve.lerp_inside(vec2(u, v));
        self.drag(&[at(0.5, 0.5), at(0.5, 0.3), at(0.5, 0.15)]);
    }

    /// Asks the window to close, as its frame's cross does.
    pub fn close(&mut self) {
        let viewports = &mut self.0.input_mut().viewports;
        viewports.entry(egui::ViewportId::ROOT).or_default().events.push(egui::ViewportEvent::Close);
        self.0.run_steps(1);
        let viewports = &mut self.0.input_mut().viewports;
        viewports.entry(egui::ViewportId::ROOT).or_default().events.clear();
        self.0.run_steps(2);
    }

    /// The pixels of `area` that look otherwise when the pointer is `at` a place than when it is `away`.
    pub fn what_changes(&mut self, area: Rect, away: Pos2, at: Pos2) -> Vec<Vec2> {
        let [before, after] = [away, at].map(|at| {
            self.0.hover_at(at);
            self.0.run_steps(2);
            self.0.render().unwrap()
        });
        let changed = after.enumerate_pixels().filter(|(x, y, pixel)| {
            area.contains(pos2(*x as f32, *y as f32)) && **pixel != *before.get_pixel(*x, *y)
        });
        changed.map(|(x, y, _)| vec2(x as f32 + 0.5, y as f32 + 0.5)).collect()
    }

    /// See [`driving::screenshot`].
    pub fn screenshot(&mut self, name: &str) {
        driving::screenshot(&mut self.0, name);
    }
}

fn left_button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}
