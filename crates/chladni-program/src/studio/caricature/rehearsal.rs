//! The caricature room without its window: everything between an action and the figures drawn next, so that
//! it can be timed.

use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use chladni_caricature::{Action, Project, Surface};
use chladni_mesh::MirrorPlane;
use chladni_mesh::surface::vec3::single;
use chladni_task::Task;
use chladni_view::Device;

use super::center::update_stage;
use super::edits::Edit;
use super::evaluating::Sight;
use super::heat::{Heat, Painting};
use super::loading::{self, Candidate};
use super::look::{Portrayal, Show};
use super::session::Session;
use super::stage::Stage;
use crate::studio::screen::Screen;
use crate::work::Error;

/// An open project whose pictures nobody draws.
pub struct Rehearsal {
    session: Session,
    stage: Stage,
    heat: Heat,
    look: Portrayal,
    screen: Screen,
    nobody: egui::Context,
}

impl Rehearsal {
    /// Opens the shape of `project` and matches what its layers wait for.
    pub fn of(project: Project, device: &Device, task: &Task) -> Result<Self, Error> {
        let candidate = Candidate::new(project);
        let loaded = loading::load(candidate, &channel().0, task)?;
        let mut session = Session::new(loaded);
        let nobody = egui::Context::default();
        while !session.stack.missing(session.project()).is_empty() {
            if let (Some(why), _) = session.pump_matches(&nobody) {
                return Err(Error::Input(why.to_string()));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        session.refresh();
        session.catch_up(&nobody)?;
        let screen = Screen::unseen(device);
        let body = session.stack.body();
        let stage = Stage::new(&screen, &single(&body.positions), &body.triangles, None);
        let stage = stage?;
        Ok(Self { session, stage, heat: Heat::default(), look: Portrayal::default(), screen, nobody })
    }

    /// Applies the user's actions of one frame, and waits until the figures of the shape that they make are there. Returns
    /// how long the window's own thread was busy with it.
    pub fn act(&mut self, actions: Vec<Action>) -> Result<Duration, Error> {
        let began = Instant::now();
        self.session.apply(actions.into_iter().map(Edit::Live).collect())?;
        self.session.hand_over(&self.nobody, Sight::of(self.session.selected, self.look));
        let handed_over = began.elapsed();
        self.session.wait(Duration::MAX);
        let began = Instant::now();
        self.session.take_in()?;
        update_stage(&mut self.session, &mut self.stage, &mut self.heat, self.look, &mut true)?;
        // Drawing would send off the work queued for the device.
        if let Some(gpu) = self.screen.device().gpu() {
            gpu.queue.submit([]);
        }
        Ok(handed_over + began.elapsed())
    }

    /// Ends the drag or the stroke.
    pub fn release(&mut self) -> Result<(), Error> {
        self.session.apply(vec![Edit::Finish]).map(|_| ())
    }

    /// Waits until it is known how far layers that keep triangles may go.
    pub fn settle(&mut self) -> Result<(), Error> {
        loop {
            self.session.catch_up(&self.nobody)?;
            if !self.session.pump_keeping(&self.nobody, true) && !self.session.is_settling() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Shows the selected layer in all three models, or the result alone.
    pub fn show_models(&mut self, all: bool) {
        self.look.show = if all { Show::Models } else { Show::Result };
    }

    /// Shows the region, smoothed or as painted, as while the brush is in hand.
    pub fn show_region(&mut self, smoothed: bool) {
        self.heat.paint(Some(if smoothed { Painting::Smoothed } else { Painting::Raw }));
    }

    /// The surface that is painted on.
    pub fn surface(&self) -> &Surface {
        self.session.stack.surface()
    }

    /// The plane that mirrored strokes are mirrored in.
    pub fn mirror(&self) -> Option<MirrorPlane> {
        self.session.mirror()
    }
}
