//! A snapshot of the stage, independent of later edits, for exports and thumbnails.

use std::path::Path;
use std::sync::Arc;

use chladni_task::Task;
use chladni_view::ink::{self, Drawing, Plate};
use chladni_view::{
    Background, Camera, Canvas, Cell, Device, Figure, Film, FilmSettings, ItemBuffers, Paint, Picture, Rect,
    Renderer, Scale, Topology, Turntable, VertexPaint, ViewError, film, layout,
};

use super::look::Portrayal;
use crate::work::{Error, Inked, OwnPaint};

/// The source of the figures' color, with shared ownership.
#[derive(Clone, Debug)]
pub enum Coat {
    /// The material's own.
    Material,
    /// A heat map.
    Values(VertexPaint, Scale),
    /// One color a vertex.
    Colors(VertexPaint),
    /// The colors that the shape brought along.
    Own(OwnPaint),
}

impl Coat {
    /// As the renderer takes it.
    pub fn paint(&self) -> Paint<'_> {
        match self {
            Self::Material => Paint::Material,
            Self::Values(values, scale) => Paint::Values(values, *scale),
            Self::Colors(colors) => Paint::Colors(colors),
            Self::Own(own) => own.paint(),
        }
    }
}

/// Positions and normals of one figure, N each.
pub type Pose = (Vec<[f32; 3]>, Vec<[f32; 3]>);

/// Everything that a picture needs, on its own.
pub struct Shot {
    /// The device; may be used on any thread.
    pub device: Device,
    /// The connectivity that all figures share.
    pub topology: Topology,
    /// The triangles of all figures.
    pub triangles: Arc<[[u32; 3]]>,
    /// The figures, side by side.
    pub poses: Vec<Pose>,
    /// How far the vertices of each are exaggerated; empty where none is.
    pub moved: Vec<Vec<f64>>,
    /// Their color; must not be written any more.
    pub coat: Coat,
    /// The viewer's camera.
    pub camera: Camera,
    /// Width by height of the view that the camera fills; a narrower picture shows as much from side to side.
    pub aspect: f32,
    /// Height of that view in points: edges of triangles are as wide on the shape in a picture of any size.
    pub height: f32,
    /// Material, light, edges.
    pub look: Portrayal,
    /// The background.
    pub background: Background,
}

impl Shot {
    /// Draws it once, in ink where that is its look.
    pub fn picture(&self, width: u32, height: u32) -> Result<Picture, Error> {
        if self.look.ink {
            return Ok(self.drawing(width, height)?.to_picture());
        }
        let canvas = Canvas::new(&self.device, width, height)?;
        self.draw(&mut Renderer::new(&self.device), &canvas, &self.upload()?, self.seen_in(width, height))?;
        Ok(canvas.read(&self.device)?)
    }

    /// Draws it in ink, whatever its look.
    pub fn drawing(&self, width: u32, height: u32) -> Result<Drawing, Error> {
        let ink = &self.look.pen.ink;
        let mut drawing = Drawing::new(width, height, ink)?;
        let camera = self.seen_in(width, height);
        for (plate, cell) in self.plates()?.iter().zip(self.cells(width, height)) {
            drawing.add(plate, ink, &camera, cell);
        }
        Ok(drawing)
    }

    /// The figures made ready to be drawn in ink.
    fn plates(&self) -> Result<Vec<Plate>, ViewError> {
        let moved = self.moved.iter().cloned().chain(std::iter::repeat_with(Vec::new));
        let shapes: Vec<Inked<'_>> =
            self.poses.iter().zip(moved).map(|((positions, _), moved)| Inked { positions, moved }).collect();
        self.look.pen.plates(&shapes, &self.triangles)
    }

    /// Draws it on a canvas that is there, without waiting.
    pub fn draw_on(&self, renderer: &mut Renderer, canvas: &Canvas) -> Result<(), ViewError> {
        self.draw(renderer, canvas, &self.upload()?, self.camera)
    }

    /// Films the figures turning once around, into the file at `path`, in ink where that is its look.
    pub fn turntable(&self, path: &Path, settings: FilmSettings, task: &Task) -> Result<(), ViewError> {
        if self.look.ink {
            let cells = self.cells(settings.width, settings.height);
            let plates: Vec<_> = self.plates()?.into_iter().zip(cells).collect();
            let film = Film::create(path, settings)?;
            return ink::film_turntable(&plates, &self.look.pen.ink, self.camera, film, task);
        }
        let (width, height, frames) = (settings.width, settings.height, settings.frames);
        let canvas = Canvas::new(&self.device, width, height)?;
        let buffers = self.upload()?;
        let points: Vec<[f32; 3]> = self.poses.iter().flat_map(|(positions, _)| positions).copied().collect();
        let turntable = Turntable::new(self.camera, &points, self.narrowest(width, height), frames);
        let film = Film::create(path, settings)?;
        film::shoot(&mut Renderer::new(&self.device), &canvas, film, task, |renderer, canvas, frame| {
            self.draw(renderer, canvas, &buffers, turntable.at(frame))
        })
    }

    fn upload(&self) -> Result<ItemBuffers, ViewError> {
        let vertices = self.poses.first().map_or(0, |(positions, _)| positions.len());
        let buffers = ItemBuffers::new(&self.device, vertices, self.poses.len());
        for (item, (positions, normals)) in self.poses.iter().enumerate() {
            buffers.write(&self.device, item, positions, normals)?;
        }
        Ok(buffers)
    }

    /// The viewer's camera, with a wider angle where the picture's cells are narrower than the view: the angle is that from
    /// bottom to top, and from side to side all stays in sight.
    fn seen_in(&self, width: u32, height: u32) -> Camera {
        let wider = (self.aspect / self.narrowest(width, height)).max(1.0);
        let fov_y_rad = 2.0 * ((0.5 * self.camera.fov_y_rad).tan() * wider).atan();
        if wider > 1.0 { Camera { fov_y_rad, ..self.camera } } else { self.camera }
    }

    /// Width by height of its narrowest cell.
    fn narrowest(&self, width: u32, height: u32) -> f32 {
        layout::narrowest(&self.cells(width, height))
    }

    /// Pixels of a picture for each point of the view.
    fn scale(&self, width: u32, height: u32) -> f32 {
        let of_cell = |cell: &Rect| (cell.height as f32).min(cell.width as f32 / self.aspect) / self.height;
        self.cells(width, height).iter().map(of_cell).fold(f32::INFINITY, f32::min)
    }

    fn cells(&self, width: u32, height: u32) -> Vec<Rect> {
        layout::arranged(Rect::of_size(width, height), self.poses.len(), 0.8, 0)
    }

    fn draw(
        &self,
        renderer: &mut Renderer,
        canvas: &Canvas,
        buffers: &ItemBuffers,
        camera: Camera,
    ) -> Result<(), ViewError> {
        let (width, height) = (canvas.width(), canvas.height());
        let scale = self.scale(width, height);
        let figures: Vec<Figure<'_>> = (0..self.poses.len())
            .map(|item| self.look.figure(&self.topology, buffers, item, self.coat.paint(), scale))
            .collect();
        let placed = self.cells(width, height).into_iter().zip(&figures);
        let cells =
            Cell::gallery(Rect::of_size(width, height), self.background, camera, self.look.lights(), placed);
        renderer.draw(canvas, &cells)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::surface::vec3::single;
    use chladni_view::{FrameRate, View};

    fn shot() -> Shot {
        let device = Device::Processor;
        let mesh = chladni_mesh::samples::icosphere(2);
        let positions = single(&mesh.positions);
        let topology = Topology::new(&device, positions.len(), &mesh.triangles).unwrap();
        let mut camera = Camera::looking(View::Front);
        camera.fit(positions.iter().copied(), 4.0 / 3.0, 0.8);
        let poses = vec![(positions.clone(), positions)];
        let triangles = mesh.triangles.into();
        let (coat, look, background) = (Coat::Material, Portrayal::default(), Background::TRANSPARENT);
        let (moved, aspect, height) = (Vec::new(), 4.0 / 3.0, 60.0);
        Shot { device, topology, triangles, poses, moved, coat, camera, aspect, height, look, background }
    }

    #[test]
    fn a_picture_has_any_size_and_nothing_behind_the_shape() {
        let shot = shot();
        let picture = shot.picture(160, 120).unwrap();
        assert_eq!(picture.pixel(0, 0).unwrap()[3], 0);
        assert_eq!(picture.pixel(80, 60).unwrap()[3], 255);
        assert!(shot.picture(0, 120).is_err());
    }

    #[test]
    fn edges_are_as_wide_on_the_shape_in_a_picture_of_any_size() {
        let mut shot = shot();
        shot.look.wire = true;
        for ([width, height], scale) in
            [([80, 60], 1.0), ([320, 240], 4.0), ([80, 240], 1.0), ([320, 60], 1.0)]
        {
            assert!((shot.scale(width, height) - scale).abs() < 1e-6, "{width} × {height}");
        }
        let buffers = shot.upload().unwrap();
        let width = |scale| {
            let figure = shot.look.figure(&shot.topology, &buffers, 0, Paint::Material, scale);
            figure.wire.unwrap().width_px
        };
        assert_eq!([0.1, 1.0, 4.0].map(width), [0.5, 1.0, 4.0]);
    }

    #[test]
    fn a_picture_narrower_than_the_view_shows_as_much_from_side_to_side() {
        let mut shot = shot();
        for (positions, _) in &mut shot.poses {
            positions.iter_mut().for_each(|p| p[0] *= 3.0);
        }
        shot.aspect = 2.0;
        shot.camera.fit(shot.poses[0].0.iter().copied(), shot.aspect, 0.9);
        for ink in [false, true] {
            shot.look.ink = ink;
            let is_shape = |picture: &Picture, x: u32| {
                let paper = picture.pixel(0, 0);
                (0..picture.height).any(|y| picture.pixel(x, y) != paper)
            };
            for (width, height) in [(200, 200), (100, 200), (200, 100)] {
                let picture = shot.picture(width, height).unwrap();
                let [left, inner, right] = [0, width / 10, width - 1].map(|x| is_shape(&picture, x));
                assert!(!left && !right, "{width} × {height}: cut off");
                assert!(inner, "{width} × {height}: far away");
            }
        }
    }

    #[test]
    fn a_turntable_is_a_film_and_a_cancelled_one_leaves_nothing() {
        let shot = shot();
        let shot = Shot { background: Background::PAPER, ..shot };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn.gif");
        let rate = FrameRate::per_second(10);
        let settings = FilmSettings { width: 64, height: 48, rate, frames: 5, first: 0, audio: None };
        let task = Task::new();
        task.cancel();
        assert!(matches!(shot.turntable(&path, settings.clone(), &task), Err(ViewError::Cancelled(_))));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        shot.turntable(&path, settings, &Task::new()).unwrap();
        let gif = std::fs::read(&path).unwrap();
        assert_eq!((&gif[..6], &gif[6..10]), (&b"GIF89a"[..], &[64, 0, 48, 0][..]));
        // A graphic control extension comes before each frame.
        assert_eq!(gif.windows(4).filter(|w| *w == [0x21, 0xF9, 4, gif_flags(&gif)]).count(), 5);
    }

    /// The flags of the first graphic control extension; all frames of one film have the same.
    fn gif_flags(gif: &[u8]) -> u8 {
        gif.windows(4).find(|w| w[..3] == [0x21, 0xF9, 4]).map_or(0, |w| w[3])
    }
}
