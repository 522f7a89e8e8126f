//! The music room as a person plays it.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "../archive/mod.rs"]
mod archive;
mod autopilot;
mod calibrating;
mod clocks;
mod controls;
#[path = "../driving/mod.rs"]
mod driving;
mod far_files;
mod files;
mod films;
mod first_shape;
mod gallery;
mod hands;
mod lost_device;
#[cfg(target_os = "linux")]
mod media_keys;
mod own_colors;
mod stage;
mod stance;

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use chladni_music::{Preset, Show};
use chladni_program::studio::{Folders, Handover, Opening, Trace};
use chladni_sound::{Song, WavSample, write_wav};
use driving::{
    Answers, Window, are_hit_apart, control, drop_files, exhaust, is_there, lose, meanwhile, no_time,
    numbers_by_tab, open, open_with, open_with_device, screenshot, shows, takes_pictures, wait,
    wait_until_left,
};
use egui::accesskit::{Role, Toggled};
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

/// Few harmonics are solved quickly, and the autopilot does not take the stage while a busy machine opens a shape.
fn folders(folder: &Path) -> Folders {
    let settings = folder.join("settings.toml");
    std::fs::write(&settings, "harmonics = 96\n[music]\nleans_back = false\n").unwrap();
    Folders { settings: Some(settings), dances: Some(folder.join("dances")), ..Folders::default() }
}

fn enter(opening: Opening) -> Window {
    let opening = Opening { now: no_time, ..opening };
    let named = !opening.files.is_empty();
    // Pictures are for people: frames that come late would be drawn smaller. Without them fewer pixels are quicker.
    let builder = Harness::builder();
    let builder = if takes_pictures() {
        builder.with_size([1280.0, 800.0]).with_step_dt(1.0 / 60.0)
    } else {
        builder.with_size([1000.0, 640.0])
    };
    let mut window = open_with(opening, builder);
    window.run_steps(3);
    if !named {
        control(&window, "room/1").click();
    }
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    window.run_steps(3);
    window
}

/// Whether the player plays, as its button says.
fn plays(window: &Window) -> bool {
    control(window, "play").accesskit_node().label().as_deref() == Some("Pause")
}

/// A free UDP port below those that systems hand out by themselves, so that hardly another program takes it before the room
/// does.
fn free_port() -> u16 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    loop {
        let n = std::process::id().wrapping_mul(61).wrapping_add(NEXT.fetch_add(1, Ordering::Relaxed));
        let port = 10_000 + (n % 20_000) as u16;
        if UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).is_ok() {
            return port;
        }
    }
}

/// Saves the show in a file that is not there yet, and reads it.
fn saved_show(window: &mut Window, answers: &Answers, file: &Path) -> Show {
    answers.add(file);
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(window, "the show", |_| file.exists());
    Show::load(file).unwrap()
}

fn click(window: &mut Window, id: &str) {
    control(window, id).click();
    window.run_steps(2);
}

/// Points at a control, to press keys there.
fn point_at(window: &mut Window, id: &str) {
    control(window, id).hover();
    window.run_steps(2);
}

fn write(window: &mut Window, field: &str, text: &str) {
    click(window, field);
    control(window, field).type_text(text);
    window.run_steps(2);
}

fn is_chosen(window: &Window, dance: &str) -> bool {
    control(window, dance).accesskit_node().toggled() == Some(Toggled::True)
}

fn drag(window: &mut Window, points: &[Pos2]) {
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.event(Event::PointerMoved(points[0]));
    window.run_steps(1);
    window.event(button(points[0], true));
    for &point in points {
        window.event(Event::PointerMoved(point));
        window.run_steps(1);
    }
    window.event(button(points[points.len() - 1], false));
    window.run_steps(2);
}

/// Asks the window to close, as its frame's cross does.
fn ask_to_close(window: &mut Window) {
    for close in [true, false] {
        let viewport = window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.events.clear();
        viewport.events.extend(close.then_some(egui::ViewportEvent::Close));
        window.run_steps(2);
    }
}

/// Whether the window asked to be closed in its last frame.
fn closes(window: &Window) -> bool {
    let commands = &window.output().viewport_output[&egui::ViewportId::ROOT].commands;
    commands.contains(&egui::ViewportCommand::Close)
}

/// How long the window may wait for its next frame.
fn pause(window: &Window) -> std::time::Duration {
    window.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay
}

/// A ball that is quickly solved and drawn, and four seconds of a song with a beat, of which the channels differ.
fn ball_and_song(folder: &Path) -> [std::path::PathBuf; 2] {
    let [ball, wav] = ["ball.obj", "song.wav"].map(|name| folder.join(name));
    let mut mesh = chladni_mesh::samples::icosphere(2);
    for p in &mut mesh.positions {
        p[1] *= 1.3 + 0.2 * p[0];
        p[2] *= 0.9 + 0.1 * p[1];
    }
    chladni_mesh::save_mesh(&mesh, &ball).unwrap();
    let mut song = chladni_sound::sample_tune();
    let from = 6 * song.rate_hz as usize;
    song.left = song.left[from..from + 4 * song.rate_hz as usize].to_vec();
    song.right = song.right[from..from + 4 * song.rate_hz as usize].to_vec();
    write_wav(&wav, &song, WavSample::Int16).unwrap();
    [ball, wav]
}

/// A window on a ball and a song, which has been read, and where its shows go.
fn recorded(folder: &Path, trace: &Trace) -> (Window, Answers) {
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let files = ball_and_song(folder).to_vec();
    let opening = Opening {
        folders: folders(folder),
        chooser,
        files,
        trace: Some(trace.clone()),
        // A slow machine would leave harmonics out that films have.
        now: no_time,
        ..Opening::default()
    };
    // Frames that come late would be drawn smaller than a film's.
    let builder = Harness::builder().with_size([1000.0, 640.0]).with_step_dt(1.0 / 60.0);
    let mut window = open_with(opening, builder);
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    wait(&mut window, "the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    window.run_steps(5);
    (window, answers)
}

/// Steps for a while in the time that goes by for the song, too: with a clock of frames alone, a busy machine's window
/// would see the song leap in each of them.
fn run_for(window: &mut Window, secs: f64) {
    let (start, from_secs) = (Instant::now(), window.ctx.input(|input| input.time));
    let mut steps = 0.0;
    // Effects that take frames, such as a wheel that runs out, need their number of frames however late these come.
    while start.elapsed().as_secs_f64() < secs || steps < 20.0 * secs {
        std::thread::sleep(std::time::Duration::from_millis(20));
        window.input_mut().time = Some(from_secs + start.elapsed().as_secs_f64());
        window.run_steps(1);
        steps += 1.0;
    }
    window.input_mut().time = None;
}
