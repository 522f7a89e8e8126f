//! The body's harmonics in color, their classes, and the paper's figure of extrema and pairs.

use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::single;
use chladni_music::{Class, Symmetry, SymmetryMethod};
use chladni_view::{
    Background, Camera, Cell, ColorMap, Figure, ItemBuffers, Lights, Marker, Material, Paint, Rect, Scale,
    Topology, VertexPaint, layout, smooth_normals,
};
use egui::{Color32, RichText, Ui};

use crate::studio::viewport::{self, Viewport};
use crate::work::{Error, figure_markers};

/// Cells of the view: the figure, then harmonics.
pub const CELLS: usize = 12;

/// A body's harmonics, with the buffers to draw them.
pub struct Harmonics {
    body: Body,
    symmetry: Symmetry,
    /// The body's vertices.
    points: Vec<[f32; 3]>,
    /// The viewer's camera and the aspect of a cell, and the camera in which the body fills that.
    fitted: Option<((Camera, f32), Camera)>,
    figure_markers: Vec<Marker>,
    drawn: Option<Drawn>,
    /// The page, who looked and the cells of the last picture.
    shown: Option<(usize, Camera, Vec<Rect>)>,
}

/// Buffers on the device for one page.
struct Drawn {
    first: usize,
    rest: ItemBuffers,
    paints: Vec<(VertexPaint, Scale)>,
}

impl Harmonics {
    /// The harmonics of `body`, mixed as `symmetry` says.
    pub fn new(body: Body, symmetry: Symmetry) -> Self {
        let figure_markers = figure_markers(&body, &symmetry);
        let points = single(&body.positions);
        Self { body, symmetry, points, fitted: None, figure_markers, drawn: None, shown: None }
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Triangles of the body, by its vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.body.triangles
    }

    /// Forgets everything on a lost device.
    pub fn forget_device(&mut self) {
        (self.drawn, self.shown) = (None, None);
    }

    /// Something else is shown: the next picture is a new one.
    pub fn leave(&mut self) {
        self.shown = None;
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.symmetry.classes.len()
    }

    /// The first that is not constant.
    pub fn first_waving(&self) -> usize {
        let eigenvalues = &self.body.basis.eigenvalues;
        let largest = eigenvalues.last().copied().unwrap_or(0.0);
        eigenvalues.partition_point(|&l| l <= 1e-9 * largest).min(self.count())
    }

    /// How many are symmetric, antisymmetric and neither.
    pub fn class_counts(&self) -> [usize; 3] {
        [Class::Symmetric, Class::Antisymmetric, Class::Undecided]
            .map(|class| self.symmetry.classes.iter().filter(|c| **c == class).count())
    }

    /// In words, how the classes were found.
    pub fn method(&self) -> String {
        match self.symmetry.method {
            SymmetryMethod::Mirror(plane) => {
                let share = 100.0 * plane.misfit;
                format!("By its mirror plane, which misses the shape by {share:.2} % of its size.")
            }
            SymmetryMethod::Vote => {
                "The shape has no mirror plane: classes are by the vote of the pairs, and rough.".into()
            }
        }
    }

    /// Draws the figure of extrema and pairs, and the harmonics from `first` on; says whether the picture
    /// is another than the last one.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        viewport: &mut Viewport,
        topology: &Topology,
        camera: Camera,
        rect: egui::Rect,
        first: usize,
    ) -> Result<bool, Error> {
        let first = first.clamp(self.first_waving(), self.count());
        let shown = (self.count() - first).min(CELLS - 1) + 1;
        if self.drawn.as_ref().is_none_or(|drawn| drawn.first != first) {
            self.drawn = Some(self.prepare(viewport, first, shown)?);
        }
        let area = viewport::area(ui, rect);
        let cells = layout::arranged(area, shown, 1.0, 6);
        let fitted = self.fitted(camera, layout::narrowest(&cells));
        let Some(drawn) = &self.drawn else { return Ok(false) };
        let figures: Vec<Figure<'_>> = drawn
            .paints
            .iter()
            .map(|(paint, scale)| Figure {
                material: Material::PORCELAIN,
                paint: Paint::Values(paint, *scale),
                ..Figure::new(topology, &drawn.rest, 0)
            })
            .collect();
        let shown = Some((first, fitted, cells.clone()));
        let new = self.shown != shown;
        if new {
            viewport.invalidate();
        }
        let places: Vec<egui::Rect> = cells.iter().map(|cell| viewport::to_points(ui, rect, *cell)).collect();
        viewport.show(ui, rect, |_| {
            let cell = |(i, (cell, figure)): (usize, (&Rect, _))| Cell {
                viewport: *cell,
                camera: fitted,
                lights: Lights::SOFT,
                background: Background::SLATE,
                figures: std::slice::from_ref(figure),
                markers: if i == 0 { &self.figure_markers } else { &[] },
            };
            cells.iter().zip(&figures).enumerate().map(cell).collect()
        })?;
        self.shown = shown;
        self.captions(ui, &places, first);
        Ok(new)
    }

    /// The viewer's camera, moved so that the body fills cells of this aspect.
    fn fitted(&mut self, camera: Camera, aspect: f32) -> Camera {
        match self.fitted {
            Some((of, fitted)) if of == (camera, aspect) => fitted,
            _ => {
                let mut fitted = camera;
                fitted.fit_turntable(&self.points, aspect, 0.8);
                fitted.distance *= camera.distance / Camera::default().distance;
                self.fitted = Some(((camera, aspect), fitted));
                fitted
            }
        }
    }

    fn prepare(
        &self,
        viewport: &Viewport,
        first: usize,
        shown: usize,
    ) -> Result<Drawn, chladni_view::ViewError> {
        let device = viewport.device();
        let count = self.body.positions.len();
        let rest = ItemBuffers::new(device, count, 1);
        rest.write(device, 0, &self.points, &smooth_normals(&self.points, &self.body.triangles))?;
        let paint = |values: &[f32], scale: Scale| {
            let paint = VertexPaint::new(device, count);
            paint.write_values(device, values).map(|()| (paint, scale))
        };
        let extrema: Vec<f32> = self.symmetry.extrema_counts.iter().map(|&c| f32::from(c)).collect();
        let mut paints = vec![paint(&extrema, Scale::of(ColorMap::Viridis, &extrema))?];
        for k in first..first + shown - 1 {
            let values: Vec<f32> = self.body.basis.harmonic(k).iter().map(|h| *h as f32).collect();
            paints.push(paint(&values, Scale::of(ColorMap::BlueRed, &values))?);
        }
        Ok(Drawn { first, rest, paints })
    }

    fn captions(&self, ui: &mut Ui, places: &[egui::Rect], first: usize) {
        for (i, place) in places.iter().enumerate() {
            let row = egui::Rect::from_min_size(
                place.left_top() + egui::vec2(10.0, 8.0),
                egui::vec2(place.width() - 20.0, 20.0),
            );
            let mut ui = ui.new_child(
                egui::UiBuilder::new().max_rect(row).layout(egui::Layout::left_to_right(egui::Align::Center)),
            );
            let Some(k) = (i > 0).then(|| first + i - 1) else {
                let pairs = self.symmetry.pairs.len();
                let text = format!("Extrema and their {pairs} pairs");
                ui.label(RichText::new(text).color(Color32::WHITE));
                continue;
            };
            let (name, color) = class_name(self.symmetry.classes.get(k).copied());
            ui.label(RichText::new(format!("{k}")).strong().color(Color32::WHITE));
            let response = ui.label(RichText::new(name).color(color));
            if let Some(score) = self.symmetry.scores.get(k) {
                response.on_hover_text(format!("Agreement with its mirror image: {score:+.2}"));
            }
        }
    }
}

fn class_name(class: Option<Class>) -> (&'static str, Color32) {
    match class {
        Some(Class::Symmetric) => ("symmetric", Color32::from_rgb(240, 170, 90)),
        Some(Class::Antisymmetric) => ("antisymmetric", Color32::from_rgb(130, 180, 245)),
        Some(Class::Undecided) | None => ("undecided", Color32::from_gray(190)),
    }
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::samples::icosphere;
    use chladni_task::Task;

    use super::*;

    #[test]
    fn the_camera_is_fitted_only_where_it_or_the_cells_have_changed() {
        let body = Body::build(&icosphere(2), &BasisSettings::new(8), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let mut harmonics = Harmonics::new(body, symmetry);
        let camera = Camera::default();
        let before = harmonics.fitted(camera, 1.0);
        let larger: Vec<[f32; 3]> = harmonics.points.iter().map(|p| p.map(|c| 2.0 * c)).collect();
        harmonics.points = larger;
        assert_eq!(harmonics.fitted(camera, 1.0), before, "nobody has moved it");
        assert!(harmonics.fitted(camera, 1.5).distance > before.distance);
        let turned = Camera { yaw_rad: 0.5, ..camera };
        assert_eq!(harmonics.fitted(turned, 1.5).yaw_rad, 0.5);
    }
}
