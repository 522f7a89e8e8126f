//! The stage as a drawing in ink. It is drawn beside the window: lines while something moves, with hatching once it
//! rests; until a drawing is there, the one before is seen.

use std::sync::Arc;

use chladni_view::ink::{Drawing, Plate};
use chladni_view::{Camera, Picture, Rect};
use egui::{ColorImage, TextureHandle, TextureOptions, Ui};

use super::super::shot::Pose;
use super::figures::moved;
use crate::studio::job::Job;
use crate::studio::theme;
use crate::work::{Depth, Error, Inked, Pen};

/// After this time without a change the shade is drawn, too.
const REST_SECS: f64 = 0.25;

/// The drawing that is wanted, and the last one.
#[derive(Default)]
pub struct InkedStage {
    wanted: Option<Scene>,
    /// When the wanted drawing last changed.
    changed_secs: f64,
    running: Option<(Scene, Job<Drawn>)>,
    /// What could not be drawn, which is not tried again before something changes.
    failed: Option<Scene>,
    shown: Option<(TextureHandle, Scene, Depth)>,
    /// Shapes that were made ready before, by figure.
    plates: Vec<(Pictured, Arc<Plate>)>,
}

/// A figure, and how often it had been changed.
type Pictured = (usize, u64);

/// A drawing: its figures and viewpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub camera: Camera,
    pub pen: Pen,
    pub size: [u32; 2],
    pub figures: Vec<(Pictured, Rect)>,
}

/// What the plates of a scene depend on beside each figure: of lines as wide as it is exaggerated, all figures, which
/// have one measure.
#[derive(Clone, Debug, PartialEq)]
struct Making {
    smoothing: f64,
    weighted: Option<Vec<Pictured>>,
}

impl Scene {
    fn making(&self) -> Making {
        let all = || self.figures.iter().map(|(pictured, _)| *pictured).collect();
        Making { smoothing: self.pen.smoothing, weighted: self.pen.exaggeration.then(all) }
    }
}

struct Drawn {
    picture: Picture,
    scene: Scene,
    depth: Depth,
    plates: Vec<(Pictured, Arc<Plate>)>,
}

impl InkedStage {
    /// Shows the newest drawing in the rectangle of the stage, and has the next one drawn where `scene` is another. Meanwhile the stage
    /// is busy, for those who cannot see that.
    pub fn show(
        &mut self,
        ui: &Ui,
        (rect, stage): (egui::Rect, egui::Id),
        scene: Scene,
        poses: &[Pose],
        triangles: &Arc<[[u32; 3]]>,
    ) -> Result<(), Error> {
        let now_secs = ui.input(|input| input.time);
        if let Some(ended) = self.running.as_ref().and_then(|(_, job)| job.ended()) {
            let begun = self.running.take().map(|(scene, _)| scene);
            match ended {
                Ok(drawn) => self.take(ui, drawn),
                Err(why) => {
                    self.failed = begun;
                    return Err(why);
                }
            }
        }
        if self.wanted.as_ref() != Some(&scene) {
            (self.wanted, self.changed_secs, self.failed) = (Some(scene.clone()), now_secs, None);
        }
        let rests = now_secs - self.changed_secs >= REST_SECS;
        let depth = if rests { Depth::Shade } else { Depth::Lines };
        let is_shown = self
            .shown
            .as_ref()
            .is_some_and(|(_, shown, has)| *shown == scene && (*has == depth || *has == Depth::Shade));
        let is_done = is_shown || self.failed.as_ref() == Some(&scene);
        if self.running.is_none() && !is_done {
            self.start(ui, scene, depth, poses, triangles);
        }
        if !is_done || !rests {
            ui.ctx().accesskit_node_builder(stage, egui::accesskit::Node::set_busy);
        }
        if !rests {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(REST_SECS));
        }
        if let Some((texture, ..)) = &self.shown {
            ui.painter().image(texture.id(), rect, theme::WHOLE_IMAGE, egui::Color32::WHITE);
        }
        Ok(())
    }

    fn take(&mut self, ui: &Ui, drawn: Drawn) {
        let Drawn { picture, scene, depth, plates } = drawn;
        let size = [picture.width as usize, picture.height as usize];
        let image = ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
        let texture = match self.shown.take() {
            Some((mut texture, ..)) => {
                texture.set(image, TextureOptions::LINEAR);
                texture
            }
            None => ui.ctx().load_texture("ink", image, TextureOptions::LINEAR),
        };
        (self.shown, self.plates) = (Some((texture, scene, depth)), plates);
    }

    fn start(&mut self, ui: &Ui, scene: Scene, depth: Depth, poses: &[Pose], triangles: &Arc<[[u32; 3]]>) {
        let as_made = self.shown.as_ref().is_some_and(|(_, shown, _)| shown.making() == scene.making());
        let ready = scene.figures.iter().map(|(pictured, _)| {
            let known = self.plates.iter().find(|(known, _)| as_made && known == pictured);
            known.map_or_else(
                || {
                    let positions = poses.get(pictured.0).map_or_else(Vec::new, |pose| pose.0.clone());
                    Ready::Shape(positions, moved(poses, pictured.0, scene.pen))
                },
                |(_, plate)| Ready::Plate(Arc::clone(plate)),
            )
        });
        let (ready, triangles) = (ready.collect::<Vec<Ready>>(), Arc::clone(triangles));
        let begun = scene.clone();
        let job = Job::start("Drawing in ink", ui.ctx(), move |_| {
            let ink = scene.pen.ink;
            let mut drawing = Drawing::new(scene.size[0], scene.size[1], &ink)?;
            let plates = plates(&ready, scene.pen, &triangles)?;
            for (plate, (_, cell)) in plates.iter().zip(&scene.figures) {
                depth.draw(&mut drawing, plate, &ink, &scene.camera, *cell);
            }
            let pictured = scene.figures.iter().map(|(pictured, _)| *pictured);
            let plates = pictured.zip(plates).collect();
            Ok(Drawn { picture: drawing.to_picture(), scene, depth, plates })
        });
        self.running = Some((begun, job));
    }
}

/// A shape that is ready to be drawn, or its vertices and how far they are exaggerated.
enum Ready {
    Plate(Arc<Plate>),
    Shape(Vec<[f32; 3]>, Vec<f64>),
}

/// All of them ready. Where lines have weights, either all are, or none.
fn plates(ready: &[Ready], pen: Pen, triangles: &[[u32; 3]]) -> Result<Vec<Arc<Plate>>, Error> {
    let raw = ready.iter().filter_map(|ready| match ready {
        Ready::Shape(positions, moved) => Some(Inked { positions, moved: moved.clone() }),
        Ready::Plate(_) => None,
    });
    let mut made = pen.plates(&raw.collect::<Vec<_>>(), triangles)?.into_iter();
    let plate = |ready: &Ready| match ready {
        Ready::Plate(plate) => Some(Arc::clone(plate)),
        Ready::Shape(..) => made.next().map(Arc::new),
    };
    Ok(ready.iter().filter_map(plate).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_drawn_at_once_and_shade_when_the_shape_rests() {
        let ball = chladni_mesh::samples::icosphere(3);
        let positions = chladni_mesh::surface::vec3::single(&ball.positions);
        let (poses, triangles) = (vec![(positions.clone(), positions)], ball.triangles.into());
        let (ctx, mut stage) = (egui::Context::default(), InkedStage::default());
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(200.0, 200.0));
        let mut drawn_at = |secs: f64, yaw_rad: f32, wanted: Depth, pen: Pen| {
            let camera = Camera { yaw_rad, distance: 6.0, ..Camera::default() };
            let figures = vec![((0, 1), Rect::of_size(200, 200))];
            let scene = Scene { camera, pen, size: [200; 2], figures };
            let start = std::time::Instant::now();
            loop {
                let input = egui::RawInput { time: Some(secs), ..egui::RawInput::default() };
                let _ = ctx.run_ui(input, |ui| {
                    stage.show(ui, (rect, egui::Id::NULL), scene.clone(), &poses, &triangles).unwrap();
                });
                let shown = stage.shown.as_ref().filter(|(_, shown, _)| *shown == scene);
                if shown.is_some_and(|(.., depth)| *depth == wanted) {
                    return Arc::clone(&stage.plates[0].1);
                }
                assert!(start.elapsed() < chladni_testdata::HANGS, "{wanted:?} was never drawn");
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        };
        let usual = Pen::default();
        let first = drawn_at(1.0, 0.0, Depth::Lines, usual);
        let second = drawn_at(2.0, 0.0, Depth::Shade, usual);
        assert!(Arc::ptr_eq(&first, &second), "made ready once");
        let third = drawn_at(2.1, 0.5, Depth::Lines, Pen { exaggeration: true, ..usual });
        assert!(!Arc::ptr_eq(&first, &third), "its lines have other widths");
        let fourth = drawn_at(2.5, 0.5, Depth::Lines, Pen { exaggeration: true, smoothing: 0.05, ..usual });
        assert!(!Arc::ptr_eq(&third, &fourth), "its lines are others");
    }

    #[test]
    fn a_drawing_that_fails_is_not_begun_again_before_something_changes() {
        let poses = vec![(vec![[f32::NAN; 3]; 3], vec![[0.0; 3]; 3])];
        let triangles: Arc<[[u32; 3]]> = [[0, 1, 2]].into();
        let (ctx, mut stage) = (egui::Context::default(), InkedStage::default());
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(200.0, 200.0));
        // Whether it went well, and whether a drawing is under way.
        let mut show = |yaw_rad: f32| {
            let camera = Camera { yaw_rad, ..Camera::default() };
            let figures = vec![((0, 1), Rect::of_size(200, 200))];
            let scene = Scene { camera, pen: Pen::default(), size: [200; 2], figures };
            let mut shown = Ok(());
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                shown = stage.show(ui, (rect, egui::Id::NULL), scene.clone(), &poses, &triangles);
            });
            (shown.is_ok(), stage.running.is_some())
        };
        let start = std::time::Instant::now();
        for yaw_rad in [0.0, 0.5] {
            while show(yaw_rad).0 {
                assert!(start.elapsed() < chladni_testdata::HANGS, "it never failed");
                std::thread::yield_now();
            }
            assert_eq!([show(yaw_rad), show(yaw_rad)], [(true, false); 2]);
        }
    }
}
