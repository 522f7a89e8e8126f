//! The picture of the stage on a projector's wall: four corners to be pinned, and how bright each color is.

use std::sync::Arc;

use egui::{Color32, Galley, Key, Mesh, Pos2, Rect, Sense, Stroke, TextureId, Ui, Vec2, vec2};
use serde::{Deserialize, Serialize};

use crate::studio::author_id::AuthorId;
use crate::studio::{shortcut, theme};

/// Where the corners of the picture go, and its trim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Projection {
    /// As shares of the screen, clockwise from the upper left.
    pub corners: [[f32; 2]; 4],
    /// Factors on red, green and blue, in [0, 1].
    pub trim: [f32; 3],
}

const PLAIN: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// Cells on each side of the mesh that is drawn: within one the perspective is even to a fraction of a pixel.
const CELLS: usize = 48;
/// Corners may leave the screen by so much.
const BEYOND: f32 = 0.25;
/// Quadrangles flatter than this share of the screen are refused.
const FLATTEST: f32 = 0.01;
/// Size of the handles, in points.
const HANDLE: f32 = 26.0;

impl Default for Projection {
    fn default() -> Self {
        Self { corners: PLAIN, trim: [1.0; 3] }
    }
}

impl Projection {
    /// As in a file, or the plain picture if the file's values are not valid.
    pub fn sane(self) -> Self {
        let trim = self.trim.map(|share| if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 });
        Self { corners: if is_convex(&self.corners) { self.corners } else { PLAIN }, trim }
    }

    /// Whether the corners are those of the screen.
    pub fn is_pinned(&self) -> bool {
        self.corners != PLAIN
    }

    /// Where the point at shares (u, v) of the picture goes: the projective map of the unit square onto the corners
    /// (Heckbert, "Fundamentals of texture mapping and image warping", 1989, section 2.2.2).
    pub fn map(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [p0, p1, p2, p3] = self.corners.map(|corner| corner.map(f64::from));
        let (u, v) = (f64::from(u), f64::from(v));
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let (d1, d2) = (minus(p1, p2), minus(p3, p2));
        let d3 = [p0[0] - p1[0] + p2[0] - p3[0], p0[1] - p1[1] + p2[1] - p3[1]];
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let whole = cross(d1, d2);
        let (g, h) = (cross(d3, d2) / whole, cross(d1, d3) / whole);
        let depth = g * u + h * v + 1.0;
        std::array::from_fn(|i| {
            let (a, b) = (p1[i] - p0[i] + g * p1[i], p3[i] - p0[i] + h * p3[i]);
            ((a * u + b * v + p0[i]) / depth) as f32
        })
    }

    /// Where the point `at` of the picture of `rect` goes.
    fn place(&self, rect: Rect, at: Pos2) -> Pos2 {
        let [x, y] = self.map(((at - rect.min) / rect.size()).into());
        rect.min + vec2(x, y) * rect.size()
    }

    /// A color as it is on the wall.
    pub fn trimmed(&self, color: Color32) -> Color32 {
        let [r, g, b] = self.trim.map(|share| (255.0 * share).round() as u8);
        color * Color32::from_rgb(r, g, b)
    }

    /// Paints a texture as the picture of `rect`.
    pub fn paint(&self, ui: &Ui, rect: Rect, texture: TextureId) {
        if self.is_pinned() {
            ui.painter().rect_filled(rect, 0.0, Color32::BLACK);
        }
        self.paint_part(ui, (rect, rect), texture, Color32::WHITE);
    }

    /// Paints a texture onto `part` of the picture of `rect`.
    pub fn paint_part(&self, ui: &Ui, (rect, part): (Rect, Rect), texture: TextureId, tint: Color32) {
        let tint = self.trimmed(tint);
        if self.is_pinned() {
            ui.painter_at(rect).add(self.mesh((rect, part), texture, tint));
        } else {
            ui.painter().image(texture, part, theme::WHOLE_IMAGE, tint);
        }
    }

    /// A text whose corner is at `corner` of the picture of `rect`, so that it lies on the wall where it is painted there.
    pub fn bent(&self, rect: Rect, corner: Pos2, text: Arc<Galley>) -> Arc<Galley> {
        if !self.is_pinned() {
            return text;
        }
        let mut bent = Arc::unwrap_or_clone(text);
        bent.mesh_bounds = Rect::NOTHING;
        for row in &mut bent.rows {
            let offset = row.pos.to_vec2();
            let origin = corner + offset;
            let visuals = &mut Arc::make_mut(&mut row.row).visuals;
            for vertex in &mut visuals.mesh.vertices {
                vertex.pos = (self.place(rect, origin + vertex.pos.to_vec2()) - origin).to_pos2();
            }
            visuals.mesh_bounds = visuals.mesh.calc_bounds();
            bent.mesh_bounds |= visuals.mesh_bounds.translate(offset);
        }
        Arc::new(bent)
    }

    fn mesh(&self, (rect, part): (Rect, Rect), texture: TextureId, tint: Color32) -> Mesh {
        let mut mesh = Mesh::with_texture(texture);
        for row in 0..=CELLS {
            for column in 0..=CELLS {
                let uv = [column, row].map(|i| i as f32 / CELLS as f32);
                let pos = self.place(rect, part.min + Vec2::from(uv) * part.size());
                mesh.vertices.push(epaint::Vertex { pos, uv: uv.into(), color: tint });
            }
        }
        let at = |row: usize, column: usize| (row * (CELLS + 1) + column) as u32;
        for row in 0..CELLS {
            for column in 0..CELLS {
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
                mesh.add_triangle(a, b, c);
                mesh.add_triangle(c, b, d);
            }
        }
        mesh
    }

    /// Handles on the corners, to be dragged; arrows move the one that has the focus.
    pub fn adjust(&mut self, ui: &mut Ui, rect: Rect) {
        let accent = theme::palette(ui).accent;
        for corner in 0..4 {
            let [x, y] = self.corners[corner];
            let at = rect.min + vec2(x, y) * rect.size();
            // A corner in a corner of the screen must be within reach.
            let shown = rect.shrink(0.5 * HANDLE).clamp(at);
            let handle = Rect::from_center_size(shown, Vec2::splat(HANDLE));
            let response =
                ui.interact(handle, ui.scope_id().with(("corner", corner)), Sense::click_and_drag());
            let name = ["Upper left corner", "Upper right corner", "Lower right corner", "Lower left corner"];
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name[corner]));
            let mut by = response.drag_delta();
            if response.has_focus() {
                let lock = egui::EventFilter {
                    horizontal_arrows: true,
                    vertical_arrows: true,
                    ..egui::EventFilter::default()
                };
                ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, lock));
                by += vec2(
                    shortcut::steps(ui, Key::ArrowRight, Key::ArrowLeft),
                    shortcut::steps(ui, Key::ArrowDown, Key::ArrowUp),
                );
            }
            if by != Vec2::ZERO {
                let moved = [x + by.x / rect.width().max(1.0), y + by.y / rect.height().max(1.0)];
                self.pin(corner, moved);
            }
            let color = if response.hovered() || response.has_focus() { Color32::WHITE } else { accent };
            ui.painter().circle_stroke(shown, 0.4 * HANDLE, Stroke::new(2.0, color));
            ui.painter().circle_filled(shown, 3.0, color);
        }
    }

    /// Moves a corner, as long as the picture stays one.
    fn pin(&mut self, corner: usize, to: [f32; 2]) {
        let mut corners = self.corners;
        if let Some(at) = corners.get_mut(corner) {
            *at = to.map(|share| share.clamp(-BEYOND, 1.0 + BEYOND));
        }
        if is_convex(&corners) {
            self.corners = corners;
        }
    }

    /// Sliders and buttons for it.
    pub fn show(&mut self, ui: &mut Ui, adjusts: &mut bool) {
        ui.label(egui::RichText::new("Projector").strong());
        let tip = "On stage, drag the corners of the picture onto those of the wall; arrows move the one that has the focus";
        theme::checkbox(ui, adjusts, "Move the corners").on_hover_text(tip);
        for (trim, name) in self.trim.iter_mut().zip(["Red", "Green", "Blue"]) {
            let slider = theme::slider(trim, 0.0..=1.0).fixed_decimals(2);
            theme::row(ui, name, "How bright this color is on stage", |ui| ui.add(slider));
        }
        let reset = ui
            .add_enabled(*self != Self::default(), egui::Button::new("As it is"))
            .author_id("projection-reset");
        if reset.on_hover_text("Straight corners and full colors").clicked() {
            *self = Self::default();
        }
    }
}

/// Whether four finite corners, clockwise, are those of a convex quadrangle with some area at each.
fn is_convex(corners: &[[f32; 2]; 4]) -> bool {
    corners.as_flattened().iter().all(|share| (-BEYOND..=1.0 + BEYOND).contains(share))
        && (0..4).all(|i| {
            let [a, b, c] = [0, 1, 2].map(|step| corners[(i + step) % 4]);
            (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > FLATTEST
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    fn skewed() -> Projection {
        Projection { corners: [[0.1, 0.05], [0.9, 0.2], [1.0, 0.9], [-0.05, 0.8]], ..Projection::default() }
    }

    fn near(a: [f32; 2], b: [f32; 2]) -> bool {
        (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-5
    }

    #[test]
    fn corners_go_where_they_are_pinned_and_lines_stay_straight() {
        let projection = skewed();
        for (corner, to) in PLAIN.into_iter().zip(projection.corners) {
            assert!(near(projection.map(corner), to), "{corner:?}");
        }
        for uv in [[0.3, 0.8], [0.5, 0.5], [1.0, 0.2]] {
            assert!(near(Projection::default().map(uv), uv));
        }
        // The middle of a projective square is where its diagonals cross.
        let [x, y] = projection.map([0.5, 0.5]);
        for [from, to] in [[0, 2], [1, 3]] {
            let [a, b] = [projection.corners[from], projection.corners[to]];
            let off = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
            assert!(off.abs() < 1e-5, "{off}");
        }
        for v in [0.0, 0.37, 1.0] {
            let [a, b, c] = [0.0, 0.6, 1.0].map(|u| projection.map([u, v]));
            let off = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(off.abs() < 1e-5, "{off}");
        }
    }

    #[test]
    fn the_mesh_is_the_map_to_a_fraction_of_a_pixel() {
        let (projection, rect) = (skewed(), Rect::from_min_size(pos2(10.0, 20.0), vec2(1920.0, 1080.0)));
        let mesh = projection.mesh((rect, rect), TextureId::default(), Color32::WHITE);
        assert_eq!(mesh.indices.len(), 6 * CELLS * CELLS);
        let mut most = 0.0f32;
        for triangle in mesh.indices.chunks(3) {
            let corners = [0, 1, 2].map(|i| mesh.vertices[triangle[i] as usize]);
            let mean = |of: fn(&epaint::Vertex) -> Vec2| {
                corners.iter().map(of).fold(Vec2::ZERO, |sum, v| sum + v) / 3.0
            };
            let (drawn, uv) = (mean(|vertex| vertex.pos.to_vec2()), mean(|vertex| vertex.uv.to_vec2()));
            let [x, y] = projection.map([uv.x, uv.y]);
            most = most.max((rect.min.to_vec2() + vec2(x, y) * rect.size() - drawn).length());
        }
        assert!(most < 0.3, "{most} pixels");
    }

    #[test]
    fn arrows_move_the_corner_that_has_the_focus_and_nothing_after_it() {
        let (ctx, mut projection) = (egui::Context::default(), Projection::default());
        let rect = Rect::from_min_size(Pos2::ZERO, vec2(100.0, 50.0));
        let is_left_over = [Key::Tab, Key::Q, Key::ArrowRight].map(|key| {
            let modifiers = egui::Modifiers::NONE;
            let event = egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
            let input = egui::RawInput { events: vec![event], ..egui::RawInput::default() };
            let mut is_left_over = false;
            let _ = ctx.run_ui(input, |ui| {
                projection.adjust(ui, rect);
                is_left_over = ui.input(|input| input.key_pressed(key));
            });
            is_left_over
        });
        assert_eq!(is_left_over, [true, true, false]);
        assert!(near(projection.corners[0], [0.01, 0.0]), "{:?}", projection.corners);
    }

    #[test]
    fn no_drag_turns_the_picture_inside_out() {
        let mut projection = Projection::default();
        projection.pin(0, [0.9, 0.95]);
        assert!(!projection.is_pinned());
        projection.pin(0, [0.2, 0.1]);
        assert_eq!(projection.corners[0], [0.2, 0.1]);
        projection.pin(2, [9.0, 9.0]);
        assert_eq!(projection.corners[2], [1.25, 1.25]);
        let bad = Projection { corners: [[f32::NAN; 2]; 4], trim: [f32::INFINITY, -1.0, 0.5] };
        assert_eq!(bad.sane(), Projection { corners: PLAIN, trim: [1.0, 0.0, 0.5] });
    }
}
