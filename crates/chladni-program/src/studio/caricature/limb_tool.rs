//! Whole parts of the shape as a region: the one under the pointer is shown, a click takes it.

use std::sync::Arc;

use chladni_caricature::{Limbs, PaintEdit};
use chladni_harmonics::Body;
use chladni_mesh::{MirrorPlane, TriMesh};
use egui::{Modifiers, Ui};

use super::stage::Press;
use crate::studio::author_id::AuthorId;
use crate::studio::job::Job;
use crate::studio::theme;
use crate::work::{Aside, Error, body_of_limbs};

/// How parts are taken.
#[derive(Debug)]
pub struct LimbTool {
    /// Whether a click takes a part.
    pub active: bool,
    /// From 0 (whole limbs) to 1 (small features).
    pub level: f64,
    /// Parts of this level are being looked for.
    pub searching: bool,
    /// The parts under the pointer: one, or two that are mirror images.
    pointed: Vec<usize>,
}

impl Default for LimbTool {
    fn default() -> Self {
        Self { active: false, level: Limbs::USUAL_LEVEL, searching: false, pointed: Vec::new() }
    }
}

impl LimbTool {
    /// Draws what turns it on.
    pub fn show_switch(&mut self, ui: &mut Ui) {
        theme::checkbox(ui, &mut self.active, "Parts").author_id("parts").on_hover_text(
            "A click takes the part under the pointer as the region; Shift adds it, Erase or Ctrl takes it away",
        );
    }

    /// Draws the level where it is on.
    pub fn show_level(&mut self, ui: &mut Ui) {
        if self.active {
            let tip = "From whole limbs (0) to small features (1)";
            theme::row(ui, "Level", tip, |ui| {
                ui.add(theme::slider(&mut self.level, 0.0..=1.0).fixed_decimals(2));
            });
            let state = if self.searching { "Finding parts…" } else { "Click a part of the shape" };
            theme::weak(ui, state);
        }
    }

    /// The values of `limbs` to show: 1 on the parts under the pointer.
    pub fn shown(&self, limbs: &Limbs) -> Vec<f32> {
        let value = |part: &u32| f32::from(u8::from(self.pointed.contains(&(*part as usize))));
        limbs.part.iter().map(value).collect()
    }

    /// Takes in the part under the pointer, with its mirror image in `plane`; true when that has changed.
    pub fn point(
        &mut self,
        press: Option<&Press>,
        triangles: &[[u32; 3]],
        limbs: &Limbs,
        plane: Option<MirrorPlane>,
    ) -> bool {
        let vertex = press.and_then(|press| {
            let hit = press.touch.hit;
            let corners = triangles.get(hit.triangle as usize)?;
            let nearest = (0..3).max_by(|a, b| hit.barycentric[*a].total_cmp(&hit.barycentric[*b]))?;
            Some(corners[nearest])
        });
        let part = vertex.and_then(|v| limbs.part.get(v as usize)).map(|part| *part as usize);
        let twin = part.zip(plane).and_then(|(part, plane)| limbs.twins(&plane).get(part).copied().flatten());
        let pointed: Vec<usize> = part.into_iter().chain(twin).collect();
        let changed = pointed != self.pointed;
        self.pointed = pointed;
        changed
    }

    /// Takes the part under the pointer with this intensity: alone, or, with Shift, besides the painted region; `erase` takes
    /// it away. `None` where there is none.
    pub fn taken(
        &self,
        limbs: &Limbs,
        erase: bool,
        intensity: f32,
        modifiers: Modifiers,
    ) -> Option<PaintEdit> {
        let taking = || PaintEdit::taking(&self.pointed, &limbs.part, modifiers.shift, erase);
        (!self.pointed.is_empty()).then(taking).map(|edit| edit.with_intensity(intensity))
    }
}

/// The parts that were found last, and the search for others.
#[derive(Default)]
pub struct KnownLimbs {
    found: Option<(Sought, Arc<Limbs>)>,
    /// One at a time; when it ends, the newest request is the next.
    running: Option<(Sought, Search)>,
    /// A body, and that whose harmonics they were found by.
    solved: Option<(Arc<Body>, Arc<Body>)>,
}

/// Ends with the parts, and the body whose harmonics they were found by.
type Search = Job<(Arc<Body>, Limbs)>;

/// Of which body at which level.
#[derive(Clone)]
struct Sought {
    body: Arc<Body>,
    level: f64,
}

impl Sought {
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.body, &other.body) && self.level == other.level
    }
}

impl KnownLimbs {
    /// Those of `body`, made of this mesh, at `level`, or, until they are found, those that were found last.
    pub fn of(
        &mut self,
        body: &Arc<Body>,
        mesh: &Arc<TriMesh>,
        level: f64,
        ctx: &egui::Context,
    ) -> Result<Option<Arc<Limbs>>, Error> {
        let sought = Sought { body: Arc::clone(body), level };
        if let Some((of, ended)) =
            self.running.as_ref().and_then(|(of, job)| Some((of.clone(), job.ended()?)))
        {
            self.running = None;
            let (solved, limbs) = ended?;
            self.solved = Some((Arc::clone(&of.body), solved));
            self.found = Some((of, Arc::new(limbs)));
        }
        if self.running.is_none() && !self.found.as_ref().is_some_and(|(of, _)| of.is_same(&sought)) {
            let solved = self.solved.as_ref().filter(|(of, _)| Arc::ptr_eq(of, body));
            let solved = solved.map(|(_, solved)| Arc::clone(solved));
            let (body, mesh) = (Arc::clone(body), Arc::clone(mesh));
            let job = Job::start("Finding parts", ctx, move |task| {
                let solved = match solved {
                    Some(solved) => solved,
                    None => body_of_limbs(&body, ("the shape", &mesh), &Aside::new(task))?,
                };
                let limbs = Limbs::of(&solved, level);
                Ok((solved, limbs))
            });
            self.running = Some((sought, job));
        }
        Ok(self.found.as_ref().map(|(_, limbs)| Arc::clone(limbs)))
    }

    /// Whether others than those that are shown are being looked for.
    pub fn is_searching(&self) -> bool {
        self.running.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_caricature::{Dab, Limb, Painted};
    use chladni_task::Task;

    #[test]
    fn a_click_takes_a_part_alone_shift_adds_it_and_erasing_takes_it_away() {
        let part = Limb { share: 0.5, persistence: 1.0, middle: [0.0; 3] };
        let limbs = Limbs { part: vec![0, 1, 1, 0], parts: vec![part; 2] };
        let taken = |pointed: &[usize], erase: bool, modifiers: Modifiers| {
            let tool = LimbTool { pointed: pointed.to_vec(), ..LimbTool::default() };
            tool.taken(&limbs, erase, 0.5, modifiers)
        };
        let alone = PaintEdit::Set(Painted::Vertices([0.0, 0.5, 0.5, 0.0].into()));
        assert_eq!(taken(&[1], false, Modifiers::NONE), Some(alone));
        let dab = |erase: bool| Some(PaintEdit::Dab(Dab::even(vec![1, 2], 0.5, erase)));
        assert_eq!(taken(&[1], false, Modifiers::SHIFT), dab(false));
        assert_eq!(taken(&[1], true, Modifiers::NONE), dab(true));
        assert_eq!(taken(&[], false, Modifiers::NONE), None);
        let tool = LimbTool { pointed: vec![0], ..LimbTool::default() };
        assert_eq!(tool.shown(&limbs), [1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn parts_are_found_beside_the_window_and_the_newest_request_is_found_last() {
        use chladni_harmonics::BasisSettings;

        let mesh = Arc::new(chladni_mesh::samples::sample("octopus").unwrap());
        let body = Body::build(&mesh, &BasisSettings::new(Limbs::HARMONICS), &Task::new()).unwrap();
        let (body, ctx, mut known) = (Arc::new(body), egui::Context::default(), KnownLimbs::default());
        // As a slider that is dragged asks: never more than one search.
        for level in [0.0, 0.1, 0.5] {
            known.of(&body, &mesh, level, &ctx).unwrap();
            assert!(known.is_searching());
        }
        let start = std::time::Instant::now();
        let mut seen: Vec<Limbs> = Vec::new();
        while seen.is_empty() || known.is_searching() {
            assert!(start.elapsed() < chladni_testdata::HANGS, "the search never ended");
            let found = known.of(&body, &mesh, 1.0, &ctx).unwrap();
            seen.extend(found.map(|limbs| (*limbs).clone()).filter(|limbs| seen.last() != Some(limbs)));
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        assert_eq!(seen.last(), Some(&Limbs::of(&body, 1.0)));
        assert_ne!(seen.last(), Some(&Limbs::of(&body, 0.0)));
        // What is known is there at once, and looked for once.
        assert_eq!(known.of(&body, &mesh, 1.0, &ctx).unwrap().as_deref(), seen.last());
        assert!(!known.is_searching());
    }
}
