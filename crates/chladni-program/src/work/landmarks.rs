//! Landmarks picked on a shape and its template, side by side: the effect of a press, and the look of both shapes.

use chladni_match::Landmark;
use chladni_mesh::surface::{SurfacePoint, drawn_triangles};
use chladni_mesh::{Frame, Orientation, TriMesh};
use chladni_view::{
    Camera, ColorMap, Device, Figure, ItemBuffers, Marker, Material, Paint, PickTree, Rect, Scale, Topology,
    VertexPaint, View, ViewError,
};

use super::Error;

/// Colors that people with any color vision can tell apart (Okabe & Ito 2008), repeated.
const COLORS: [[u8; 3]; 7] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
];

/// The color of landmark `index`, sRGB.
pub fn color(index: usize) -> [u8; 3] {
    COLORS[index % COLORS.len()]
}

/// Which of the two shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The shape that is exaggerated.
    Shape,
    /// The shape that it is compared with.
    Template,
}

impl Which {
    /// The vertex of a landmark here.
    pub fn end(self, landmark: &Landmark) -> u32 {
        match self {
            Self::Shape => landmark.shape,
            Self::Template => landmark.template,
        }
    }

    fn end_mut(self, landmark: &mut Landmark) -> &mut u32 {
        match self {
            Self::Shape => &mut landmark.shape,
            Self::Template => &mut landmark.template,
        }
    }
}

/// A gesture on one of the shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// A vertex is pressed, where no landmark is.
    Pick(u32),
    /// A landmark is held over a vertex.
    Hold(usize, u32),
    /// The landmark that is held is let go.
    Drop,
    /// A landmark is taken away.
    Remove(usize),
}

/// Landmarks that are on their way into a project.
#[derive(Clone, Copy, Debug, Default)]
pub struct Picks {
    /// Half a pair: picked on one shape, not yet on the other.
    pending: Option<(Which, u32)>,
    /// The landmark that the pointer holds, and where it is now.
    held: Option<(Which, usize, u32)>,
}

/// The name of half a pair, where it can be undone.
pub const HALF_A_LANDMARK: &str = "half a landmark";

impl Picks {
    /// Where half a pair is.
    pub fn pending(&self) -> Option<Which> {
        self.pending.map(|(which, _)| which)
    }

    /// The landmark that is held on a shape, and where it is now.
    pub fn held(&self, which: Which) -> Option<(usize, u32)> {
        self.held.filter(|(side, ..)| *side == which).map(|(_, index, vertex)| (index, vertex))
    }

    /// Forgets half a pair; false where there was none.
    pub fn drop_pending(&mut self) -> bool {
        self.pending.take().is_some()
    }

    /// `landmarks` after a gesture; `None` where they do not change.
    ///
    /// # Errors
    /// [`Error::Input`] where a vertex of the shape would have two, which no file could hold.
    pub fn act(
        &mut self,
        which: Which,
        gesture: Gesture,
        landmarks: &[Landmark],
    ) -> Result<Option<Vec<Landmark>>, Error> {
        let mut landmarks = landmarks.to_vec();
        let touched = match gesture {
            Gesture::Hold(index, vertex) => {
                self.held = Some((which, index, vertex));
                return Ok(None);
            }
            Gesture::Drop => {
                let Some((_, index, vertex)) = self.held.take() else { return Ok(None) };
                let Some(landmark) = landmarks.get_mut(index) else { return Ok(None) };
                if std::mem::replace(which.end_mut(landmark), vertex) == vertex {
                    return Ok(None);
                }
                (which == Which::Shape).then_some(vertex)
            }
            Gesture::Remove(index) => {
                if index >= landmarks.len() {
                    return Ok(None);
                }
                landmarks.remove(index);
                None
            }
            Gesture::Pick(vertex) => {
                let landmark = match (self.pending.take(), which) {
                    (Some((Which::Shape, shape)), Which::Template) => Landmark { shape, template: vertex },
                    (Some((Which::Template, template)), Which::Shape) => Landmark { shape: vertex, template },
                    _ => {
                        self.pending = Some((which, vertex));
                        return Ok(None);
                    }
                };
                landmarks.push(landmark);
                Some(landmark.shape)
            }
        };
        // An older project may hold two in one place already: they can be moved apart or removed.
        if let Some(touched) = touched
            && landmarks.iter().filter(|landmark| landmark.shape == touched).count() > 1
        {
            return Err(Error::input("That vertex of the shape has a landmark already."));
        }
        Ok(Some(landmarks))
    }

    /// The landmarks on one shape with their numbers: those of the project, the one that is held where it is now, and
    /// half a pair.
    pub fn ends(&self, which: Which, landmarks: &[Landmark]) -> Vec<(usize, u32)> {
        let mut ends: Vec<(usize, u32)> = landmarks.iter().map(|l| which.end(l)).enumerate().collect();
        if let Some((index, vertex)) = self.held(which)
            && let Some(held) = ends.get_mut(index)
        {
            held.1 = vertex;
        }
        let pending = self.pending.filter(|(side, _)| *side == which);
        ends.extend(pending.map(|(_, vertex)| (landmarks.len(), vertex)));
        ends
    }

    /// Hint at the next step when there are `count` landmarks.
    pub fn hint(&self, count: usize) -> String {
        match (self.pending(), count) {
            (Some(Which::Shape), _) => "Now click the same place on the template.".to_owned(),
            (Some(Which::Template), _) => "Now click the same place on the shape.".to_owned(),
            (None, 0) => {
                "Click a place on the shape, such as the tip of the nose, then the same place on the template."
                    .to_owned()
            }
            (None, 1 | 2) => format!("{} more, and the landmarks lead the alignment.", 3 - count),
            (None, _) => "Drag a landmark to move it, right-click to remove it. The match follows.".to_owned(),
        }
    }
}

/// A mesh with the vertices of its file, in its own working frame.
pub struct Side {
    /// The camera.
    pub camera: Camera,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    topology: Topology,
    buffers: ItemBuffers,
    confidence: VertexPaint,
    shows_confidence: bool,
    tree: PickTree,
    fitted: bool,
}

impl Side {
    /// Puts `mesh`, with its orientation, on the device.
    ///
    /// # Errors
    /// Triangles that name no vertex, or a device that was lost.
    pub fn new(device: &Device, mesh: &TriMesh, stands: Orientation) -> Result<Self, ViewError> {
        let frame = Frame::of(mesh);
        let positions: Vec<[f32; 3]> =
            mesh.positions.iter().map(|p| frame.to_working(*p).map(|c| c as f32)).collect();
        let triangles = drawn_triangles(mesh);
        let topology = Topology::new(device, positions.len(), &triangles)?;
        let buffers = ItemBuffers::new(device, positions.len(), 1);
        let normals = chladni_view::smooth_normals(&positions, &triangles);
        buffers.write(device, 0, &positions, &normals)?;
        Ok(Self {
            camera: Camera::on(stands, View::Front),
            tree: PickTree::new(&positions, &triangles),
            confidence: VertexPaint::new(device, positions.len()),
            shows_confidence: false,
            triangles,
            positions,
            topology,
            buffers,
            fitted: false,
        })
    }

    /// Shows how far each vertex's match is to be trusted; nothing where there is none.
    ///
    /// # Errors
    /// Another number of values than of vertices, or a device that was lost.
    pub fn set_confidence(&mut self, device: &Device, confidence: Option<&[f64]>) -> Result<(), ViewError> {
        self.shows_confidence = false;
        if let Some(confidence) = confidence {
            let values: Vec<f32> = confidence.iter().map(|c| *c as f32).collect();
            self.confidence.write_values(device, &values)?;
            self.shows_confidence = true;
        }
        Ok(())
    }

    /// Moves the camera so that all of it is seen in a cell of this aspect, once.
    pub fn fit(&mut self, aspect: f32) {
        if !self.fitted {
            // Vertices that no triangle uses are not visible.
            let seen = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
            self.camera.fit(seen, aspect, 0.82);
            self.fitted = true;
        }
    }

    /// Fits again the next time.
    pub fn refit(&mut self) {
        self.fitted = false;
    }

    /// As the renderer draws it.
    pub fn figure(&self, material: Material) -> Figure<'_> {
        let scale = Scale { map: ColorMap::Cividis, low: 0.0, high: 1.0 };
        let paint =
            if self.shows_confidence { Paint::Values(&self.confidence, scale) } else { Paint::Material };
        Figure { material, paint, ..Figure::new(&self.topology, &self.buffers, 0) }
    }

    /// Where vertex `vertex` of the file lies; `None` where there is none.
    pub fn position(&self, vertex: u32) -> Option<[f32; 3]> {
        self.positions.get(vertex as usize).copied()
    }

    /// The vertex nearest to the place under the pixel (x, y).
    pub fn vertex_at(&self, x: f32, y: f32, cell: Rect) -> Option<u32> {
        let ray = self.camera.ray(x, y, cell);
        let hit = self.tree.pick(&ray, &self.positions, &self.triangles)?;
        Some(self.triangles.get(hit.triangle as usize)?[hit.nearest_corner()])
    }

    /// Where a point of its surface lies; `None` where there is no such triangle.
    fn place(&self, on: &SurfacePoint) -> Option<[f32; 3]> {
        let at = |v: u32| self.positions[v as usize].map(f64::from);
        Some(on.position(&self.triangles, at)?.map(|c| c as f32))
    }

    /// The pixel of a vertex, and whether nothing hides it.
    pub fn pixel(&self, vertex: u32, cell: Rect) -> Option<([f32; 2], bool)> {
        self.pixel_of(self.position(vertex)?, cell)
    }

    /// The pixel of a point of its surface, and whether nothing hides it.
    pub fn pixel_of(&self, point: [f32; 3], cell: Rect) -> Option<([f32; 2], bool)> {
        let (pixel, _) = self.camera.project(point, cell)?;
        let ray = self.camera.ray(pixel[0], pixel[1], cell);
        let distance = (0..3).map(|i| (point[i] - ray.origin[i]) * ray.direction[i]).sum::<f32>();
        let hit = self.tree.pick(&ray, &self.positions, &self.triangles);
        Some((pixel, hit.is_none_or(|hit| hit.distance > distance - 0.02)))
    }

    /// The landmark that is seen nearest to the pixel (x, y), within `grip_px` of it, and its vertex.
    pub fn near(
        &self,
        which: Which,
        landmarks: &[Landmark],
        [x, y]: [f32; 2],
        grip_px: f32,
        cell: Rect,
    ) -> Option<(usize, u32)> {
        let distance = |vertex: u32| {
            let ([px, py], _) = self.camera.project(self.position(vertex)?, cell)?;
            let d = (px - x).hypot(py - y);
            // Whether anything hides it is found last: that takes long where landmarks are many.
            (d <= grip_px && self.pixel(vertex, cell)?.1).then_some(d)
        };
        let all = landmarks.iter().map(|landmark| which.end(landmark)).enumerate();
        let near = all.filter_map(|(i, vertex)| Some((i, vertex, distance(vertex)?)));
        near.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(i, vertex, _)| (i, vertex))
    }

    /// Landmarks as the renderer draws them. Their radii are points of the window, or pixels of the page.
    pub fn dots(&self, ends: &[(usize, u32)]) -> Vec<Marker> {
        let dot = |(index, vertex): &(usize, u32)| {
            let [r, g, b] = color(*index);
            Some(Marker { position: self.position(*vertex)?, radius_px: 6.0, color: [r, g, b, 255] })
        };
        ends.iter().filter_map(dot).collect()
    }
}

/// Where a match puts `vertex` of one side on the other: the shape's vertices lie `on_template`.
pub fn counterpart(
    which: Which,
    vertex: u32,
    on_template: &[SurfacePoint],
    [shape, template]: [&Side; 2],
) -> Option<[f32; 3]> {
    if which == Which::Shape {
        return template.place(on_template.get(vertex as usize)?);
    }
    let from = template.position(vertex)?;
    let apart = |on: &SurfacePoint| {
        let to = template.place(on)?;
        Some((0..3).map(|i| (to[i] - from[i]).powi(2)).sum::<f32>())
    };
    let all = on_template.iter().enumerate().filter_map(|(v, on)| Some((v, apart(on)?)));
    let (nearest, _) = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
    shape.position(nearest as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_match_puts_together_is_found_from_either_side() {
        let mesh = chladni_mesh::samples::icosphere(2);
        let flipped = TriMesh {
            positions: mesh.positions.iter().map(|p| [-p[0], p[1], p[2]]).collect(),
            ..mesh.clone()
        };
        let side = |mesh| Side::new(&Device::Processor, mesh, Orientation::Y_UP).unwrap();
        let sides = [&side(&mesh), &side(&flipped)];
        let corner_of = |v: usize| {
            let found = mesh.triangles.iter().enumerate().find_map(|(t, corners)| {
                Some(SurfacePoint::at_corner(t as u32, corners.iter().position(|c| *c as usize == v)?))
            });
            found.unwrap()
        };
        // Every vertex of the template belongs to one of the shape, with another number.
        let n = mesh.positions.len() as u32;
        let partner = |v: u32| (5 * v + 3) % n;
        let on_template: Vec<SurfacePoint> = (0..n).map(|v| corner_of(partner(v) as usize)).collect();
        for v in [0, 7, 100] {
            let found = counterpart(Which::Shape, v, &on_template, sides);
            assert_eq!(found, sides[1].position(partner(v)));
            let found = counterpart(Which::Template, partner(v), &on_template, sides);
            assert_eq!(found, sides[0].position(v));
        }
        assert_eq!(counterpart(Which::Shape, 9999, &on_template, sides), None);
        assert_eq!(counterpart(Which::Template, 0, &[], sides), None);
    }

    #[test]
    fn a_vertex_is_found_where_it_is_drawn_and_known_to_be_hidden_behind() {
        let mesh = chladni_mesh::samples::icosphere(3);
        let mut side = Side::new(&Device::Processor, &mesh, Orientation::Y_UP).unwrap();
        let cell = Rect { x: 40, y: 10, width: 300, height: 400 };
        side.fit(cell.aspect());
        let mut seen = 0;
        for vertex in 0..mesh.positions.len() as u32 {
            let ([x, y], visible) = side.pixel(vertex, cell).unwrap();
            let z = mesh.positions[vertex as usize][2];
            if z > 0.5 {
                assert!(visible);
                assert_eq!(side.vertex_at(x, y, cell), Some(vertex));
                seen += 1;
            } else if z < -0.2 {
                assert!(!visible);
            }
        }
        assert!(seen > 50);
        assert_eq!(side.vertex_at(41.0, 11.0, cell), None);
    }

    #[test]
    fn normals_of_two_sided_faces_do_not_cancel() {
        let ball = chladni_mesh::samples::icosphere(1);
        let mut both = ball.clone();
        both.triangles.extend(ball.triangles.iter().map(|[a, b, c]| [*b, *a, *c]));
        let side = Side::new(&Device::Processor, &both, Orientation::Y_UP).unwrap();
        let (positions, triangles) = (&side.positions, &side.triangles);
        assert_eq!(triangles.len(), both.triangles.len());
        let normals = chladni_view::smooth_normals(positions, triangles);
        assert_eq!(normals, chladni_view::smooth_normals(positions, &ball.triangles));
    }

    #[test]
    fn pairs_are_picked_moved_and_removed_and_no_vertex_has_two() {
        let mut picks = Picks::default();
        let mut act = |which, gesture, landmarks: &[Landmark]| picks.act(which, gesture, landmarks);
        assert_eq!(act(Which::Template, Gesture::Pick(7), &[]).unwrap(), None);
        let first = Landmark { shape: 3, template: 7 };
        assert_eq!(act(Which::Shape, Gesture::Pick(3), &[]).unwrap(), Some(vec![first]));
        assert_eq!(act(Which::Shape, Gesture::Pick(3), &[first]).unwrap(), None);
        assert!(act(Which::Template, Gesture::Pick(8), &[first]).is_err());
        assert_eq!(act(Which::Shape, Gesture::Hold(0, 4), &[first]).unwrap(), None);
        let moved = Landmark { shape: 4, template: 7 };
        assert_eq!(act(Which::Shape, Gesture::Drop, &[first]).unwrap(), Some(vec![moved]));
        assert_eq!(act(Which::Shape, Gesture::Remove(0), &[moved]).unwrap(), Some(Vec::new()));
        assert_eq!(act(Which::Shape, Gesture::Remove(1), &[moved]).unwrap(), None);
        // Two that are in one place can be moved apart.
        let twice = [first, first];
        assert_eq!(act(Which::Shape, Gesture::Hold(0, 4), &twice).unwrap(), None);
        assert_eq!(act(Which::Shape, Gesture::Drop, &twice).unwrap(), Some(vec![moved, first]));
        assert_eq!(act(Which::Shape, Gesture::Remove(1), &twice).unwrap(), Some(vec![first]));
    }
}
