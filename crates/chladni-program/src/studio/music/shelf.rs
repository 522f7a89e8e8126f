//! The shelf: favorites of this show, and the dances that are kept in files for the next.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use chladni_music::{Action, Instrument, ItemId, Mapping, Preset, repertoire};
use egui::{RichText, Sense, Stroke, TextEdit, Ui, vec2};

use super::curve;
use super::lineage;
use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::context_menu;
use crate::studio::icon::{self, Icon};
use crate::studio::notices::Notices;
use crate::studio::theme;
use crate::work::{Error, is_hidden, make_folder};

/// At most this many presets are read.
const MOST: usize = 2000;

/// The presets of a folder, and the form that adds one.
#[derive(Debug, Default)]
pub struct Shelf {
    folder: Option<PathBuf>,
    kept: Vec<(PathBuf, Preset)>,
    /// Dances that come with the program.
    built_in: Vec<Preset>,
    read: bool,
    search: String,
    form: Option<Form>,
}

#[derive(Debug)]
struct Form {
    item: ItemId,
    name: String,
    tags: String,
}

impl Shelf {
    /// Closes the form.
    pub fn forget_form(&mut self) {
        self.form = None;
    }

    /// Reads the folder when it is first needed; a file that is not a preset is reported and left alone.
    pub fn ready(&mut self, folder: Option<&Path>, notices: &mut Notices) {
        if self.read {
            return;
        }
        self.read = true;
        self.folder = folder.map(Path::to_owned);
        self.kept.clear();
        match repertoire() {
            Ok(built_in) => self.built_in = built_in,
            Err(why) => notices.warn(why.to_string()),
        }
        let Some(folder) = self.folder.as_deref() else { return };
        let (paths, warning) = files_in(folder);
        if let Some(why) = warning {
            notices.warn(format!("{}: {why}", folder.display()));
        }
        for path in paths {
            match Preset::load(&path) {
                Ok(preset) => self.kept.push((path, preset)),
                Err(why) => notices.warn(format!("{}: {why}", path.display())),
            }
        }
        self.kept.sort_by_key(|(_, preset)| preset.name.to_lowercase());
    }

    /// Opens the form that keeps an item.
    pub fn ask(&mut self, instrument: &Instrument, item: ItemId) {
        let name = instrument.item(item).map_or_else(String::new, |item| item.name.clone());
        self.form = Some(Form { item, name, tags: instrument.tags(item).join(", ") });
    }

    /// All dances of the shelf, in its order: first those that are kept in files.
    pub fn presets(&self) -> impl Iterator<Item = &Preset> {
        self.kept.iter().map(|(_, preset)| preset).chain(&self.built_in)
    }

    /// The dances that are kept in files.
    pub fn kept(&self) -> Vec<Preset> {
        self.kept.iter().map(|(_, preset)| preset.clone()).collect()
    }

    /// Deletes a file of the shelf.
    pub fn discard(&mut self, path: &Path) -> Result<(), Error> {
        if !self.kept.iter().any(|(known, _)| known == path) {
            return Err(Error::Input(format!("{}: is not on the shelf", path.display())));
        }
        std::fs::remove_file(path).map_err(|why| Error::unwritten(path, why))?;
        self.read = false;
        Ok(())
    }

    /// Draws the drawer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        instrument: &Instrument,
        notices: &mut Notices,
        wishes: &mut Vec<Wish>,
    ) {
        self.show_form(ui, instrument, notices);
        favorites(ui, instrument, wishes);
        ui.add_space(theme::GAP);
        let search = TextEdit::singleline(&mut self.search).hint_text("Search names and tags");
        ui.add(search.desired_width(f32::INFINITY)).author_id("shelf/search");
        let wanted: Vec<String> = self.search.to_lowercase().split_whitespace().map(str::to_owned).collect();
        let is_wanted = |preset: &Preset| {
            let text = format!("{} {}", preset.name, preset.tags.join(" ")).to_lowercase();
            wanted.iter().all(|word| text.contains(word))
        };
        ui.label(RichText::new("Kept").strong());
        if self.kept.is_empty() {
            theme::weak(ui, "Nothing yet. What you keep here is there the next time, for any shape.");
        }
        let mut found = 0;
        for (path, preset) in self.kept.iter().filter(|(_, preset)| is_wanted(preset)) {
            preset_row(ui, Some(path), preset, wishes);
            found += 1;
        }
        ui.add_space(theme::GAP);
        ui.label(RichText::new("Built in").strong());
        for preset in self.built_in.iter().filter(|preset| is_wanted(preset)) {
            preset_row(ui, None, preset, wishes);
            found += 1;
        }
        if found == 0 {
            theme::weak(ui, "Nothing here is called that.");
        }
    }

    fn show_form(&mut self, ui: &mut Ui, instrument: &Instrument, notices: &mut Notices) {
        let Some(form) = &mut self.form else { return };
        let (mut keep, mut cancel) = (false, false);
        egui::Frame::group(ui.style()).show(ui, |ui| {
            ui.label(RichText::new("Keep this dance").strong());
            let width = ui.available_width();
            let name = ui.add(TextEdit::singleline(&mut form.name).hint_text("Name").desired_width(width));
            let name = name.author_id("shelf/name");
            let tags = TextEdit::singleline(&mut form.tags).hint_text("Tags, with commas");
            let tags = ui.add(tags.desired_width(width)).author_id("shelf/tags");
            for (field, label) in [(&name, "Name of the dance"), (&tags, "Tags")] {
                field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, label));
            }
            let entered = (name.lost_focus() || tags.lost_focus())
                && ui.input(|input| input.key_pressed(egui::Key::Enter));
            ui.horizontal(|ui| {
                let named = !form.name.trim().is_empty();
                let button = ui.add_enabled(named, egui::Button::new("Keep")).author_id("shelf/keep");
                keep = button.clicked() || (entered && named);
                cancel = ui.button("Cancel").clicked();
            });
        });
        ui.add_space(theme::GAP);
        if keep {
            match self.keep(instrument) {
                Ok(name) => {
                    self.form = None;
                    notices.done(format!("Kept {name}"));
                }
                Err(why) => notices.failed(why),
            }
        } else if cancel {
            self.form = None;
        }
    }

    /// Writes the form's item into the folder, under a name that is still free.
    fn keep(&mut self, instrument: &Instrument) -> Result<String, Error> {
        let form = self.form.as_ref().ok_or_else(|| Error::input("nothing to keep"))?;
        let folder = self.folder.as_ref();
        let folder = folder.ok_or_else(|| Error::other("this system has no folder for preferences"))?;
        let item = instrument.item(form.item).ok_or_else(|| Error::input("this dance is no longer there"))?;
        let tags = form.tags.split(',').map(str::trim).filter(|tag| !tag.is_empty());
        let mut preset = instrument.preset(item, tags.map(str::to_owned).collect());
        preset.name = form.name.trim().to_owned();
        make_folder(folder)?;
        let path = free_path(folder, &preset.name);
        preset.save(&path).map_err(Error::unsaved)?;
        self.read = false;
        Ok(preset.name)
    }
}

/// The presets' files in `folder`, by name, and a warning where these are not all.
fn files_in(folder: &Path) -> (Vec<PathBuf>, Option<String>) {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        // A folder that is not there yet holds nothing.
        Err(why) if why.kind() == ErrorKind::NotFound => return (Vec::new(), None),
        Err(why) => return (Vec::new(), Some(why.to_string())),
    };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| !is_hidden(path) && path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    let too_many = paths.len() > MOST;
    paths.truncate(MOST);
    (paths, too_many.then(|| format!("only the first {MOST} dances of the shelf are shown")))
}

/// A file name for `name` that no file has yet.
fn free_path(folder: &Path, name: &str) -> PathBuf {
    let plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { ' ' }).take(60).collect();
    let plain = plain.split_whitespace().collect::<Vec<_>>().join("-").to_lowercase();
    let stem = if plain.is_empty() { "dance".to_owned() } else { plain };
    let numbered = (1..).map(|n| if n == 1 { stem.clone() } else { format!("{stem}-{n}") });
    let mut paths = numbered.map(|stem| folder.join(format!("{stem}.toml")));
    paths.find(|path| !path.exists()).unwrap_or_else(|| folder.join("dance.toml"))
}

fn favorites(ui: &mut Ui, instrument: &Instrument, wishes: &mut Vec<Wish>) {
    ui.label(RichText::new("Favorites of this show").strong());
    if instrument.favorites().is_empty() {
        theme::weak(ui, "None yet: point at a dance and press F.");
    }
    for (index, item) in instrument.favorites().iter().enumerate() {
        let name = lineage::called(instrument, item);
        ui.horizontal(|ui| {
            thumbnail(ui, &item.genome);
            ui.label(&name);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let mut button = |mark, does: &str| {
                    let button = ui.small_button(icon::text(mark)).on_hover_text(does);
                    button.accessible_name(format!("{does}: {name}")).clicked()
                };
                if button(Icon::BookmarkPlus, "Keep on the shelf") {
                    wishes.push(Wish::Keep(item.id));
                }
                if button(Icon::Presentation, "Put on stage") {
                    wishes.push(Wish::Do(Action::PerformFavorites { first: index }));
                }
            });
        });
    }
}

/// A preset, and its file where it has one.
fn preset_row(ui: &mut Ui, path: Option<&Path>, preset: &Preset, wishes: &mut Vec<Wish>) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 40.0), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &preset.name));
    let response = response.author_id(format!("preset/{}", preset.name));
    // A screen reader also clicks on what is out of sight.
    if response.clicked() {
        wishes.push(Wish::Take(Box::new(preset.clone())));
    }
    // A long shelf is mostly out of sight.
    if !ui.is_rect_visible(rect) {
        return;
    }
    let palette = theme::palette(ui);
    if response.hovered() {
        ui.painter().rect_filled(rect, 6.0, palette.card);
        wishes.push(Wish::TryOut(Box::new(preset.clone())));
    }
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut row = ui.new_child(egui::UiBuilder::new().max_rect(rect.shrink(4.0)).layout(layout));
    thumbnail(&mut row, &preset.mapping);
    row.vertical(|ui| {
        ui.add(egui::Label::new(&preset.name).truncate().selectable(false));
        let tags = RichText::new(preset.tags.join(", ")).small().color(palette.weak);
        ui.add(egui::Label::new(tags).truncate().selectable(false));
    });
    let response =
        response.on_hover_text("It dances while you point at it; a click takes it into the gallery");
    let Some(path) = path else { return };
    context_menu::show(&response, |ui| {
        if context_menu::entry(ui, true, icon::label(Icon::Trash2, "Delete from the shelf")).clicked() {
            wishes.push(Wish::Discard(path.to_owned()));
        }
    });
}

/// t and a, one above the other.
fn thumbnail(ui: &mut Ui, mapping: &Mapping) {
    let (rect, _) = ui.allocate_exact_size(vec2(44.0, 30.0), Sense::hover());
    let (upper, lower) = rect.shrink(2.0).split_top_bottom_at_fraction(0.5);
    ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    curve::line(
        ui.painter(),
        upper,
        &mapping.transfer,
        (0.0, 1.0),
        Stroke::new(1.2, curve::transfer_color(ui)),
    );
    let accent = theme::palette(ui).accent;
    curve::line(ui.painter(), lower, &mapping.amplification, (-1.0, 1.0), Stroke::new(1.2, accent));
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;

    #[test]
    fn a_screen_reader_takes_a_dance_that_is_out_of_sight() {
        let preset = repertoire().unwrap().remove(0);
        let name = preset.name.clone();
        let panel = move |ui: &mut Ui, wishes: &mut Vec<Wish>| {
            ui.add_space(1000.0);
            preset_row(ui, None, &preset, wishes);
        };
        let mut window = Harness::builder().with_size(vec2(200.0, 100.0)).build_ui_state(panel, Vec::new());
        window.get_by_label(&name).click_accesskit();
        window.run_steps(2);
        assert!(matches!(window.state()[..], [Wish::Take(_)]));
    }

    #[test]
    fn a_shelf_that_is_not_read_whole_says_so() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(files_in(&folder.path().join("not yet")), (Vec::new(), None));
        let write = |name: String| std::fs::write(folder.path().join(name), "").unwrap();
        (0..MOST).for_each(|i| write(format!("{i:04}.toml")));
        write(".0000.toml".to_owned());
        let (paths, warning) = files_in(folder.path());
        assert_eq!((paths.len(), warning), (MOST, None));
        write("last.toml".to_owned());
        let (paths, warning) = files_in(folder.path());
        assert!(paths.len() == MOST && warning.unwrap().contains("only the first 2000"));
        let (paths, warning) = files_in(&folder.path().join("last.toml"));
        assert!(paths.is_empty() && warning.is_some(), "no folder");
    }
}
