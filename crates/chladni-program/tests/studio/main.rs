//! The caricature room, used as a person would.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "../archive/mod.rs"]
mod archive;
mod clicked;
mod drawing;
#[path = "../driving/mod.rs"]
mod driving;
mod export;
mod file_window;
mod files;
mod first_hour;
mod following;
mod gallery;
mod health;
mod layers;
mod lost_device;
mod menus;
mod named_parts;
mod numbers;
mod painters;
mod screens;
mod scripts;
#[allow(dead_code, reason = "each test program uses a part")]
#[path = "../recorded/summary.rs"]
mod summary;
mod templates;
mod tour;

/// Runs frames on a screen of this size, in points without zoom, until the zoom has settled.
fn settle_on_screen<State>(window: &mut egui_kittest::Harness<'_, State>, screen: egui::Vec2) {
    for _ in 0..8 {
        let points = screen / window.ctx.zoom_factor();
        let viewports = &mut window.input_mut().viewports;
        viewports.entry(egui::ViewportId::ROOT).or_default().monitor_size = Some(points);
        window.run_steps(1);
    }
}

const CTRL: egui::Modifiers = egui::Modifiers::COMMAND;
