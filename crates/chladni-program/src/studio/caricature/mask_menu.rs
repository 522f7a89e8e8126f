//! Regions read from files or from the shape's own numbers, and written to files.

use chladni_caricature::{Action, Bend, Curved, LayerId, PaintEdit, Painted};
use chladni_mesh::Format;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{PopupCloseBehavior, RichText, Ui};

use super::edits::Edits;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::choose::ask_where_to_save;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::outputs::check_apart;
use crate::work::{Error, mask};

/// A wish about a region.
#[derive(Clone, Debug, PartialEq)]
pub enum MaskWish {
    /// From a file.
    Open,
    /// To a file.
    Save,
    /// The mesh's own numbers of this name.
    Own(String),
    /// Where the surface bends.
    Curved(Curved),
}

/// State of the menus.
#[derive(Debug)]
pub struct MaskMenu {
    share_percent: f64,
}

impl Default for MaskMenu {
    fn default() -> Self {
        Self { share_percent: 100.0 * Curved::USUAL_SHARE }
    }
}

impl MaskMenu {
    /// Draws the menus; `channels` are the names of the mesh's own numbers.
    pub fn show(&mut self, ui: &mut Ui, channels: &[String]) -> Option<MaskWish> {
        let mut wish = None;
        let mask = ui.menu_button("Mask", |ui| {
            let mut offer = |ui: &mut Ui, id: &str, name: &str, tip: &str, wanted: MaskWish| {
                if ui.button(name).author_id(id).on_hover_text(tip).clicked() {
                    wish = Some(wanted);
                    ui.close();
                }
            };
            let tip = "A number from 0 to 1 for each vertex: a NumPy array, or a mesh with as many vertices whose \
                       attribute “mask” or vertex colors hold it";
            offer(ui, "mask/open", "Open mask…", tip, MaskWish::Open);
            let tip = "As a NumPy array, a PLY with the attribute “mask”, or gray vertex colors (GLB, OBJ)";
            offer(ui, "mask/save", "Save mask…", tip, MaskWish::Save);
            if !channels.is_empty() {
                ui.separator();
                ui.label(RichText::new("The shape's own").color(theme::palette(ui).weak));
                for name in channels {
                    let (id, tip) = (format!("mask/own/{name}"), "What the shape's file says of each vertex");
                    offer(ui, &id, name, tip, MaskWish::Own(name.clone()));
                }
            }
        });
        mask.response.author_id("mask").on_hover_text("The region from a file, or into one");
        // The slider is set before one of the entries is clicked.
        let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        let (curved, _) = MenuButton::new("By curvature").config(stays).ui(ui, |ui| {
            let share = theme::slider(&mut self.share_percent, 1.0..=60.0).fixed_decimals(0);
            let share = theme::in_units(share, 1.0, 0, " % of it");
            let tip = "How much of the surface is taken";
            ui.add(share).accessible_name("Share of the surface").on_hover_text(tip);
            for (name, tip, bend) in [
                ("bumps", "Where the surface bends outward most, as at a nose", Bend::Bumps),
                ("hollows", "Where it bends inward most, as in the corner of an eye", Bend::Hollows),
                ("both", "Where it bends most, either way", Bend::Both),
            ] {
                let button = ui.button(theme::capitalized(name)).author_id(format!("curvature/{name}"));
                if button.on_hover_text(tip).clicked() {
                    let share = self.share_percent / 100.0;
                    wish = Some(MaskWish::Curved(Curved { bend, share }));
                    ui.close();
                }
            }
        });
        curved.author_id("curvature").on_hover_text("The places that bend most");
        wish
    }
}

/// Fulfills a wish about the region of `layer`.
pub fn fulfil(
    wish: MaskWish,
    layer: LayerId,
    session: &Session,
    edits: &mut Edits,
    shared: &mut Shared<'_>,
) -> Result<(), Error> {
    let painted = match wish {
        MaskWish::Open => {
            let Some(path) = shared.chooser.open(&[("Masks", &mask::READ)]) else { return Ok(()) };
            mask::read(&path, None, &session.subject)?
        }
        MaskWish::Save => return save(layer, session, shared),
        MaskWish::Own(name) => mask::own(&name, &session.subject, format(session))?,
        MaskWish::Curved(curved) => {
            let surface = session.stack.surface();
            curved.painted(&surface.positions, &surface.triangles)
        }
    };
    edits.once(Action::Paint { layer, edit: PaintEdit::Set(painted) });
    Ok(())
}

fn save(layer: LayerId, session: &Session, shared: &mut Shared<'_>) -> Result<(), Error> {
    let kinds = mask::WRITTEN.map(|ending| (ending.to_uppercase(), [ending]));
    let kinds: Vec<(&str, &[&str])> = kinds.iter().map(|(name, endings)| (&**name, &endings[..])).collect();
    let suggested = session.beside_named("mask", "npy");
    let asked = ask_where_to_save(shared.chooser, &kinds, &mask::WRITTEN, &suggested);
    let Some(path) = asked else { return Ok(()) };
    check_apart(&path, &session.project().files())?;
    let painted = session.project().layer(layer).map_or(Painted::Everywhere, |l| l.region.painted.clone());
    mask::write(&path, &painted, &session.subject, false)?;
    shared.notices.done(format!("Wrote {}", path.display()));
    Ok(())
}

/// The format of the shape's file; samples have neither colors nor attributes.
fn format(session: &Session) -> Format {
    session.project().shape.file().and_then(Format::of_path).unwrap_or(Format::Ply)
}
