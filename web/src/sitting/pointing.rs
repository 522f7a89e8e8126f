//! The pointer on the figure: it shows and takes parts, and paints.

use chladni_caricature::{Action, Brush, Dab, PaintEdit, Reach, Seen, SurfacePoint};
use chladni_mesh::MirrorPlane;
use chladni_program::work::{Coating, Error, with_pointed};
use chladni_view::Hit;
use wasm_bindgen::prelude::*;

use super::Sitting;

/// The effect of a press on the figure.
#[derive(Default)]
pub struct Tool {
    pub mode: Mode,
    /// The parts under the pointer.
    pub pointed: Vec<usize>,
    /// Radius of the brush, working frame.
    radius: f64,
    /// The share of it that is painted in full.
    hardness: f64,
    /// How much of the layer acts there.
    intensity: f32,
    erase: bool,
    both_sides: bool,
    /// It takes all that is connected.
    fill: bool,
    /// Where the brush was pressed last.
    at: Option<[f32; 2]>,
}

#[derive(Clone, Copy, Default, PartialEq)]
pub enum Mode {
    /// It turns the viewer.
    #[default]
    Turn,
    /// It takes the part that it is on.
    Parts,
    /// It paints.
    Brush,
}

/// Presses of a brush on a fast drag at most, as many as are needed for dabs that overlap.
const MOST_DABS: f32 = 32.0;

#[wasm_bindgen]
impl Sitting {
    /// Chooses the effect of a press on the figure from now on: `turn`, `parts` or `brush`.
    ///
    /// # Errors
    /// A name of no tool.
    pub fn hold(&mut self, tool: &str) -> Result<(), JsError> {
        self.tool.mode = match tool {
            "turn" => Mode::Turn,
            "parts" => Mode::Parts,
            "brush" => Mode::Brush,
            _ => return Err(JsError::new("there is no such tool")),
        };
        self.tool.pointed.clear();
        self.stage.lay_ring(None, &self.stack.surface().clone())?;
        Ok(self.recoat()?)
    }

    /// The brush from now on: its radius as a share of the shape's half size, the share of that which is painted in full,
    /// and how much of the layer acts there, from 0 to 1; or it fills all that is connected.
    pub fn set_brush(
        &mut self,
        radius: f64,
        hardness: f64,
        intensity: f32,
        erase: bool,
        both_sides: bool,
        fill: bool,
    ) {
        (self.tool.radius, self.tool.hardness, self.tool.intensity) = (radius, hardness, intensity);
        (self.tool.erase, self.tool.both_sides, self.tool.fill) = (erase, both_sides, fill);
    }

    /// The pointer is over a pixel of the last picture; whether something there answers.
    ///
    /// # Errors
    /// Bugs only.
    pub fn point(&mut self, x: f32, y: f32) -> Result<bool, JsError> {
        let hit = self.stage.hit(x, y);
        match self.tool.mode {
            Mode::Turn => {}
            Mode::Parts => {
                let vertex = hit.and_then(|hit| self.corner(&hit));
                let pointed = vertex.map_or_else(Vec::new, |v| self.parts.around(v));
                self.point_at(pointed)?;
            }
            Mode::Brush => {
                let reach = hit.map(|hit| self.reach(&hit, x, y)).transpose()?;
                let surface = self.stack.surface().clone();
                self.stage.lay_ring(reach.as_ref(), &surface)?;
            }
        }
        Ok(hit.is_some())
    }

    /// The pointer has left the picture.
    ///
    /// # Errors
    /// Bugs only.
    pub fn point_nowhere(&mut self) -> Result<(), JsError> {
        let surface = self.stack.surface().clone();
        self.stage.lay_ring(None, &surface)?;
        Ok(self.point_at(Vec::new())?)
    }

    /// Points at a part by its number, as keys do; at none beyond the last.
    ///
    /// # Errors
    /// Bugs only.
    pub fn point_at_part(&mut self, part: usize) -> Result<(), JsError> {
        let pointed = if part < self.parts.names.len() { self.parts.with_twin(part) } else { Vec::new() };
        Ok(self.point_at(pointed)?)
    }

    /// Takes the parts under the pointer as the region of the selected layer, alone or `besides` what it has, or takes
    /// them away from it.
    ///
    /// # Errors
    /// Bugs only.
    pub fn take_part(&mut self, besides: bool, erase: bool) -> Result<(), JsError> {
        let Some(layer) = self.selected.filter(|_| !self.tool.pointed.is_empty()) else { return Ok(()) };
        let edit = PaintEdit::taking(&self.tool.pointed, &self.parts.part, besides, erase);
        Ok(self.act_once(&Action::Paint { layer, edit })?)
    }

    /// Presses the brush on a pixel, as part of a stroke that ends with [`finish`](Self::finish).
    ///
    /// # Errors
    /// Bugs only.
    pub fn press(&mut self, x: f32, y: f32) -> Result<(), JsError> {
        let Some(layer) = self.selected else { return Ok(()) };
        // A press fills: dragging on adds nothing.
        if self.tool.fill && self.tool.at.is_some() {
            return Ok(());
        }
        let places = if self.tool.fill { vec![[x, y]] } else { self.trail([x, y]) };
        for [x, y] in places {
            let Some(hit) = self.stage.hit(x, y) else { continue };
            let reach = self.reach(&hit, x, y)?;
            let surface = self.stack.surface().clone();
            for edit in self.edits(&hit, &reach)? {
                self.history.apply_live(&Action::Paint { layer, edit }, Some(&surface))?;
            }
            self.stage.lay_ring(Some(&reach), &surface)?;
        }
        self.tool.at = Some([x, y]);
        Ok(self.recoat()?)
    }
}

impl Sitting {
    /// The stroke has ended.
    pub(super) fn lift_brush(&mut self) {
        self.tool.at = None;
    }

    /// Pixels on the way from the last press, so near each other that dabs overlap.
    fn trail(&mut self, to: [f32; 2]) -> Vec<[f32; 2]> {
        let Some(from) = self.tool.at else { return vec![to] };
        let (began, ends) = (self.point_under(from), self.point_under(to));
        let Some((began, ends)) = began.zip(ends) else { return vec![to] };
        let apart = (0..3).map(|i| (began[i] - ends[i]).powi(2)).sum::<f32>().sqrt();
        let spacing = self.brush(None).spacing().max(5e-4) as f32;
        let steps = (apart / spacing).ceil().clamp(1.0, MOST_DABS) as u16;
        let along = |i: u16| f32::from(i) / f32::from(steps);
        (1..=steps).map(|i| std::array::from_fn(|c| from[c] + (to[c] - from[c]) * along(i))).collect()
    }

    fn point_under(&mut self, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
        let ray = self.stage.camera.ray(x, y, self.stage.area());
        self.stage.hit(x, y).map(|hit| hit.point(&ray))
    }

    fn corner(&self, hit: &Hit) -> Option<u32> {
        let corners = self.stage.triangles().get(hit.triangle as usize)?;
        Some(corners[hit.nearest_corner()])
    }

    fn point_at(&mut self, pointed: Vec<usize>) -> Result<(), Error> {
        if pointed == self.tool.pointed {
            return Ok(());
        }
        self.tool.pointed = pointed;
        self.recoat()
    }

    fn brush(&self, mirror: Option<MirrorPlane>) -> Brush {
        Brush { radius: self.tool.radius, hardness: self.tool.hardness, mirror }
    }

    /// The effect of a press of the brush, which reaches so far.
    fn edits(&mut self, hit: &Hit, reach: &Reach) -> Result<Vec<PaintEdit>, Error> {
        let Tool { intensity, erase, fill, .. } = self.tool;
        if !fill {
            return Ok(vec![PaintEdit::Dab(Dab::of(reach, intensity, erase))]);
        }
        let brush = self.brush_in_hand()?;
        let intensity = if erase { 0.0 } else { intensity };
        Ok(PaintEdit::fills(&brush, place(hit), self.stack.surface(), intensity).collect())
    }

    fn brush_in_hand(&mut self) -> Result<Brush, Error> {
        let mirror = if self.tool.both_sides { self.mirror()? } else { None };
        Ok(self.brush(mirror))
    }

    /// The part of the figure under the brush.
    fn reach(&mut self, hit: &Hit, x: f32, y: f32) -> Result<Reach, Error> {
        let brush = self.brush_in_hand()?;
        let eye = self.stage.camera.eye_at(x, y, self.stage.area());
        let (tree, positions, triangles) = self.stage.pick_tree();
        let blocked = |eye: [f64; 3], point: [f64; 3]| tree.blocks(eye, point, positions, triangles);
        let surface = self.stack.surface();
        let seen = Seen { surface, positions, eye: Some(eye), blocked: Some(&blocked) };
        Ok(brush.reach(&seen, &place(hit)))
    }

    /// Colors the figure: while parts are chosen or painted by the region of the selected layer, with what is pointed at,
    /// unless a heat map was chosen.
    pub(super) fn recoat(&mut self) -> Result<(), Error> {
        let layer = self.selected.and_then(|id| self.history.project().layer(id));
        let tool = self.tool.mode != Mode::Turn && self.heat.is_off();
        let shown = layer.filter(|_| tool).and_then(|layer| {
            let region = layer.region.painted.values(&self.stack.surface().file_positions());
            let pointed = self.parts.shown(&self.tool.pointed);
            let is_whole = self.tool.pointed.is_empty() && region.iter().all(|x| *x == 1.0);
            // A region that was painted on another mesh lies nowhere on this one.
            if is_whole || region.len() != self.stack.surface().vertices() {
                return None;
            }
            Some(if pointed.len() == region.len() {
                with_pointed(&region, &pointed)
            } else {
                region.to_vec()
            })
        });
        let coating = match shown {
            Some(region) => Coating::Region(region),
            None => self.heated()?,
        };
        self.stage.coat(coating)
    }
}

/// The place on the surface that was hit.
fn place(hit: &Hit) -> SurfacePoint {
    SurfacePoint { triangle: hit.triangle, weights: hit.barycentric.map(f64::from) }
}
