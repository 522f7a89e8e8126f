//! The health report of the open shape, made once in the background, and seen where its vertices are counted.

use std::sync::Arc;

use chladni_harmonics::{CoverReport, Laplacian};
use chladni_mesh::{HealthReport, Mended, TriMesh};
use egui::{Context, Response, RichText};

use super::evaluating::on_own_threads;
use crate::studio::job::Job;
use crate::studio::theme;
use crate::work::{Error, HealthRow, health_rows, is_sound, laplacian_row};

/// A shape as it was read.
#[derive(Default)]
pub struct Unexamined {
    /// All that its file holds.
    pub whole: Arc<TriMesh>,
    /// Its positions before the nodes of a glTF file moved them.
    pub stored_positions: Option<Vec<[f64; 3]>>,
    /// Repairs of its reader.
    pub mended: Vec<Mended>,
    /// What was done for its Laplacian; `None` where that is not known.
    pub cover: Option<CoverReport>,
}

/// What is known of the open shape.
#[derive(Default)]
pub struct Health {
    running: Option<Job<Found>>,
    found: Option<Found>,
    /// What was done for the usual Laplacian.
    laplacian: Option<HealthRow>,
}

struct Found {
    rows: Vec<HealthRow>,
    /// Nothing that a person should know.
    is_sound: bool,
}

impl Unexamined {
    /// Begins to examine it.
    pub fn begin(self, ctx: &Context) -> Health {
        let Self { whole, stored_positions, mended, cover } = self;
        let running = Job::start("Examining the shape", ctx, move |task| {
            task.check()?;
            let report = on_own_threads(|| HealthReport::of_placed(&whole, stored_positions.as_deref()))?;
            let repairs = mended.iter().map(|mended| ("mended", mended.to_string()));
            let rows = repairs.chain(health_rows(&report)).collect();
            Ok(Found { rows, is_sound: mended.is_empty() && is_sound(&report) })
        });
        let laplacian = cover.map(|cover| laplacian_row(Ok(&cover)));
        Health { running: Some(running), found: None, laplacian }
    }
}

impl Health {
    /// Takes in a finished report; an error says why there is none.
    pub fn poll(&mut self) -> Result<(), Error> {
        if let Some(outcome) = self.running.as_ref().and_then(Job::ended) {
            self.running = None;
            self.found = Some(outcome?);
        }
        Ok(())
    }

    /// Whether something was found that a person should know.
    pub fn is_worth_a_look(&self) -> bool {
        self.found.as_ref().is_some_and(|found| !found.is_sound)
    }

    /// Shows the report, once it is there, where `count` is hovered; `laplacian` is that of the harmonics.
    pub fn show_on(&self, count: Response, laplacian: Laplacian) {
        let Some(found) = &self.found else { return };
        let rows = || {
            let done = self.laplacian.iter().filter(move |_| laplacian == Laplacian::Delaunay);
            found.rows.iter().chain(done)
        };
        count.ctx.accesskit_node_builder(count.id, |node| {
            let lines: Vec<String> = rows().map(|(name, value)| format!("{name}: {value}")).collect();
            node.set_description(lines.join("\n"));
        });
        count.on_hover_ui(|ui| {
            let weak = theme::palette(ui).weak;
            ui.set_max_width(520.0);
            let grid = egui::Grid::new("health").num_columns(2).max_col_width(400.0).min_row_height(0.0);
            grid.show(ui, |ui| {
                for (name, value) in rows() {
                    ui.label(RichText::new(*name).small().color(weak));
                    ui.label(RichText::new(value).small());
                    ui.end_row();
                }
            });
        });
    }
}
