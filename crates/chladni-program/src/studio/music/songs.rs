//! The playlist, and the live inputs to listen to instead.

use chladni_sound::{
    CaptureKind, CaptureSource, LONGEST_CROSSFADE_SECS, OutputDevice, PlayerState, PlayerStatus, Repeat,
    capture_sources, output_devices,
};
use egui::{RichText, Sense, TextStyle, TextWrapMode, Ui, pos2, vec2};

use super::listening::{Listening, MOST_GAIN_DB};
use super::meters;
use super::preferences::{MOST_LATE_MS, Preferences};
use super::wish::{Then, Wish};
use crate::studio::author_id::AuthorId;
use crate::studio::choose::takes_drops;
use crate::studio::icon::{self, Icon};
use crate::studio::job::Job;
use crate::studio::notices::Notices;
use crate::studio::theme;

/// Width of the word before the volume.
const VOLUME: f32 = 64.0;
/// The side of a cover before a song, and the height of its row.
const COVER: f32 = 26.0;
const ROW: f32 = 28.0;

/// Input and output devices, as last listed by the system.
type Found = (Vec<CaptureSource>, Vec<OutputDevice>);

/// The devices that were found when last looked for.
#[derive(Default)]
pub struct Devices {
    found: Vec<CaptureSource>,
    outputs: Vec<OutputDevice>,
    looking: Option<Job<Found>>,
    looked: bool,
}

impl Devices {
    fn look(&mut self, ctx: &egui::Context) {
        self.looked = true;
        let look = |_: &chladni_task::Task| Ok((capture_sources()?, output_devices()?));
        self.looking = Some(Job::start("Looking for devices", ctx, look));
    }

    fn poll(&mut self, notices: &mut Notices) {
        match self.looking.as_ref().and_then(Job::ended) {
            Some(Ok((found, outputs))) => (self.found, self.outputs) = (found, outputs),
            Some(Err(why)) => notices.warn(why),
            None => return,
        }
        self.looking = None;
    }
}

/// Draws the drawer.
pub fn show(
    ui: &mut Ui,
    listening: &mut Listening,
    inputs: &mut Devices,
    preferences: &mut Preferences,
    notices: &mut Notices,
    wishes: &mut Vec<Wish>,
) {
    inputs.poll(notices);
    if !inputs.looked {
        inputs.look(ui.ctx());
    }
    playlist(ui, listening, wishes);
    let tip =
        "Where a song is opened and nothing is touched, dances, looks and camera change with the music (A)";
    theme::checkbox(ui, &mut preferences.leans_back, "Lean back").on_hover_text(tip);
    let tip = "On stage, in its camera and in recordings, for some seconds after a song has begun";
    theme::checkbox(ui, &mut preferences.song_titles, "Show titles of songs").on_hover_text(tip);
    ui.add_space(theme::GAP_LARGE);
    sound(ui, listening, inputs, preferences);
    lateness(ui, listening, preferences, wishes);
    ui.add_space(theme::GAP_LARGE);
    live(ui, listening, inputs, preferences);
}

/// How loud, and where.
fn sound(ui: &mut Ui, listening: &mut Listening, devices: &Devices, preferences: &mut Preferences) {
    ui.label(RichText::new("Sound").strong());
    let mut volume = listening.volume();
    let tip = "How loud the songs are; the shapes dance the same";
    let slider = theme::slider(&mut volume, 0.0..=1.0).fixed_decimals(2);
    let slider = theme::wide_row(ui, VOLUME, "Volume", tip, |ui| ui.add(slider)).on_hover_text(tip);
    if slider.changed() {
        listening.set_volume(volume);
        preferences.volume = volume;
    }
    let mut fade_secs = listening.song_fade_secs();
    let tip =
        "How long the end of a song is heard under the beginning of the next; without one there is no gap";
    let slider = theme::slider(&mut fade_secs, 0.0..=LONGEST_CROSSFADE_SECS);
    let slider = theme::in_units(slider, 1.0, 1, " s");
    let slider = theme::wide_row(ui, VOLUME, "Crossfade", tip, |ui| ui.add(slider)).on_hover_text(tip);
    if slider.changed() {
        listening.set_song_fade_secs(fade_secs);
        preferences.song_fade_secs = fade_secs;
    }
    let chosen = listening.device().map(str::to_owned);
    let system = (None, "The system's own".to_owned());
    let rows = devices.outputs.iter().map(|device| (Some(device.id.clone()), device.name.clone()));
    // A chosen device that is missing now is still listed, so that it can be changed.
    let gone = chosen.clone().filter(|id| !devices.outputs.iter().any(|device| device.id == *id));
    let gone = gone.map(|id| (Some(id.clone()), format!("{id} (not there now)")));
    let mut wanted = None;
    theme::group(ui, "Output device", |ui| {
        for (id, name) in std::iter::once(system).chain(rows).chain(gone) {
            let on = chosen == id;
            let row = row(ui, ui.available_width(), on, icon::label(Icon::Volume2, &name));
            if row.on_hover_text(&name).clicked() && !on {
                wanted = Some(id);
            }
        }
    });
    if let Some(device) = wanted {
        preferences.output_device.clone_from(&device);
        listening.set_device(device);
        listening.show_ahead(preferences.late_secs());
    }
}

/// How much later the picture is seen than the sound is heard.
fn lateness(ui: &mut Ui, listening: &mut Listening, preferences: &mut Preferences, wishes: &mut Vec<Wish>) {
    let tip = "How much later the picture is seen than the sound of this device is heard, as through a projector or a \
               camera; less than 0 where the sound is the later one, as of wireless loudspeakers. Shapes dance so much \
               ahead.";
    let mut late_ms = preferences.late_ms();
    ui.horizontal(|ui| {
        let label = ui.label("Picture late by").on_hover_text(tip);
        let field = theme::number_in(&mut late_ms, " ms").range(-MOST_LATE_MS..=MOST_LATE_MS);
        let field = ui.add(field).labelled_by(label.id).author_id("picture-late");
        if field.on_hover_text(tip).changed() {
            preferences.set_late_ms(late_ms);
            listening.show_ahead(preferences.late_secs());
        }
        let tip = "Tap to clicks, then to flashes: the difference is measured. Watch the window that is where the picture is seen";
        if ui.button("Calibrate").author_id("calibrate").on_hover_text(tip).clicked() {
            wishes.push(Wish::Calibrate);
        }
    });
    if late_ms != 0 && listening.live().is_some() {
        let tip = "Not of live input, which nobody knows before it is heard.";
        theme::weak(ui, tip);
    }
}

fn playlist(ui: &mut Ui, listening: &mut Listening, wishes: &mut Vec<Wish>) {
    ui.label(RichText::new("Songs").strong());
    let status = listening.player().status();
    let (mut play, mut remove) = (None, None);
    for song in 0..listening.songs().len() {
        // Rows out of sight create fewer widgets: with an id for each row, the ids of the controls below stay the same.
        let (chosen, out) = ui.push_id(("song", song), |ui| song_row(ui, listening, &status, song)).inner;
        play = play.or(chosen.then_some(song));
        remove = remove.or(out.then_some(song));
    }
    if let Some(song) = play {
        listening.select(song);
    }
    if let Some(song) = remove {
        listening.remove(song);
    }
    ui.horizontal(|ui| {
        if ui.button(icon::label(Icon::Plus, "Add songs …")).author_id("songs-add").clicked() {
            wishes.push(Wish::Choose(Then::AddSongs));
        }
        let shuffle = ui.button(icon::text(Icon::Shuffle)).on_hover_text("Another order, by chance");
        if shuffle.clicked() {
            listening.shuffle((1e6 * ui.input(|input| input.time)) as u64);
        }
        for (repeat, mark, id, tip) in [
            (Repeat::List, Icon::Repeat, "repeat/list", "Play the list again and again"),
            (Repeat::Song, Icon::Repeat1, "repeat/song", "Play this song again and again"),
        ] {
            let on = listening.repeat() == repeat;
            let button = ui.selectable_label(on, icon::text(mark)).author_id(id);
            if button.on_hover_text(tip).clicked() {
                listening.set_repeat(if on { Repeat::Off } else { repeat });
            }
        }
    });
    if takes_drops() {
        theme::weak(ui, "Songs, folders and M3U lists can be dropped anywhere on the window.");
    }
}

/// A song of the list; whether it is to be played, and whether it is to be taken out.
fn song_row(ui: &mut Ui, listening: &Listening, status: &PlayerStatus, song: usize) -> (bool, bool) {
    let heard = song == status.song && listening.live().is_none();
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let name = || listening.name_of(song);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, heard, name()));
    let response = response.author_id(format!("song/{}", song + 1));
    // A long list is mostly out of sight.
    if !ui.is_rect_visible(rect) {
        return (response.clicked(), false);
    }
    let name = name();
    let visuals = ui.style().interact_selectable(&response, heard);
    if heard || response.hovered() || response.has_focus() {
        let line = if heard { theme::chosen_line(ui.visuals()) } else { egui::Stroke::NONE };
        let (corner, fill) = (visuals.corner_radius, visuals.weak_bg_fill);
        ui.painter().rect(rect, corner, fill, line, egui::StrokeKind::Inside);
    }
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    let inside = egui::UiBuilder::new().max_rect(rect.shrink2(vec2(4.0, 0.0)));
    let mut row = ui.new_child(inside.layout(layout));
    let out = row.small_button(icon::text(Icon::X)).accessible_name(format!("Remove {name}"));
    let out = out.author_id(format!("song-remove/{}", song + 1)).on_hover_text("Take it out of the list");
    row.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
        if let Some(cover) = listening.cover_of(song) {
            ui.add(egui::Image::new(&cover.texture).fit_to_exact_size(vec2(COVER, COVER)));
        }
        let mark = match (heard, status.state) {
            (true, PlayerState::Playing) => Icon::Volume2,
            (true, _) => Icon::Pause,
            (false, _) => Icon::Music,
        };
        let width = ui.available_width();
        let text = egui::WidgetText::from(icon::label(mark, &name));
        let text = text.into_galley(ui, Some(TextWrapMode::Truncate), width, TextStyle::Button);
        let at = pos2(ui.cursor().left(), rect.center().y - 0.5 * text.size().y);
        ui.painter().galley(at, text, visuals.text_color());
    });
    (response.clicked(), out.clicked())
}

fn live(ui: &mut Ui, listening: &mut Listening, inputs: &mut Devices, preferences: &mut Preferences) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Live").strong());
        if inputs.looking.is_some() {
            ui.spinner();
        } else if ui.small_button(icon::text(Icon::RefreshCw)).on_hover_text("Look again").clicked() {
            inputs.look(ui.ctx());
        }
    });
    if inputs.found.is_empty() && inputs.looking.is_none() {
        let none = "No microphone and nothing to record from here.";
        theme::weak(ui, none);
    }
    let mut chosen = None;
    for source in &inputs.found {
        let mark = match source.kind {
            CaptureKind::Loopback => Icon::Headphones,
            CaptureKind::Program => Icon::AppWindow,
            CaptureKind::Input => Icon::Mic,
        };
        let on = listening.listens_to(source);
        let row = row(ui, ui.available_width(), on, icon::label(mark, &source.name));
        if row.on_hover_text(&source.name).clicked() {
            chosen = Some((!on, source.clone()));
        }
    }
    match chosen {
        Some((true, source)) => {
            preferences.live_input = Some(source.name.clone());
            listening.listen_to(&source, ui.ctx());
        }
        Some((false, _)) => listening.toggle_live(None, ui.ctx()),
        None => {}
    }
    strength(ui, listening, preferences);
    if listening.live().is_some() {
        for (channel, level) in meters::CHANNELS.into_iter().zip(listening.levels()) {
            meters::level(ui, channel, level);
        }
    }
}

/// How strongly live input is heard.
fn strength(ui: &mut Ui, listening: &mut Listening, preferences: &mut Preferences) {
    let tip = "How much louder live input is made; the meter shows it";
    let slider = theme::slider(&mut preferences.live_gain_db, -MOST_GAIN_DB..=MOST_GAIN_DB);
    let slider = theme::in_units(slider, 1.0, 1, " dB");
    let louder =
        theme::wide_row(ui, VOLUME, "Gain", tip, |ui| ui.add(slider)).author_id("live-gain").changed();
    let tip = "What is soft looks soft: 0 dB moves the shapes fully. Otherwise the level is followed, and soft sound moves \
               them, too";
    let fixed = theme::checkbox(ui, &mut preferences.live_fixed_level, "Fixed level");
    let fixed = fixed.author_id("live-fixed-level").on_hover_text(tip);
    if louder || fixed.changed() {
        listening.set_input(preferences.input());
    }
}

/// A line of a list, cut to `width`.
fn row(ui: &mut Ui, width: f32, on: bool, text: String) -> egui::Response {
    let layout = egui::Layout::top_down_justified(egui::Align::LEFT);
    let button = egui::Button::selectable(on, text).truncate();
    ui.allocate_ui_with_layout(vec2(width, 26.0), layout, |ui| ui.add(button)).inner
}
