//! One of the two shapes that landmarks are picked on.

use chladni_mesh::{Frame, Orientation, TriMesh};
use chladni_view::{
    Camera, ColorMap, Device, Figure, ItemBuffers, Material, Paint, PickTree, Rect, Scale, Topology,
    VertexPaint, View, ViewError,
};

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
    pub fn new(device: &Device, mesh: &TriMesh, stands: Orientation) -> Result<Self, ViewError> {
        let frame = Frame::of(mesh);
        let positions: Vec<[f32; 3]> =
            mesh.positions.iter().map(|p| frame.to_working(*p).map(|c| c as f32)).collect();
        let topology = Topology::new(device, positions.len(), &mesh.triangles)?;
        let buffers = ItemBuffers::new(device, positions.len(), 1);
        let normals = chladni_view::smooth_normals(&positions, &mesh.triangles);
        buffers.write(device, 0, &positions, &normals)?;
        Ok(Self {
            camera: Camera::on(stands, View::Front),
            tree: PickTree::new(&positions, &mesh.triangles),
            confidence: VertexPaint::new(device, positions.len()),
            shows_confidence: false,
            triangles: mesh.triangles.clone(),
            positions,
            topology,
            buffers,
            fitted: false,
        })
    }

    /// Shows how far each vertex's match is to be trusted; nothing where there is none.
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

    /// The vertex nearest to what lies under the pixel (x, y).
    pub fn vertex_at(&self, x: f32, y: f32, cell: Rect) -> Option<u32> {
        let ray = self.camera.ray(x, y, cell);
        let hit = self.tree.pick(&ray, &self.positions, &self.triangles)?;
        Some(self.triangles.get(hit.triangle as usize)?[hit.nearest_corner()])
    }

    /// The pixel of a vertex, and whether nothing hides it.
    pub fn pixel(&self, vertex: u32, cell: Rect) -> Option<([f32; 2], bool)> {
        let point = self.position(vertex)?;
        let (pixel, _) = self.camera.project(point, cell)?;
        let ray = self.camera.ray(pixel[0], pixel[1], cell);
        let distance = (0..3).map(|i| (point[i] - ray.origin[i]) * ray.direction[i]).sum::<f32>();
        let hit = self.tree.pick(&ray, &self.positions, &self.triangles);
        Some((pixel, hit.is_none_or(|hit| hit.distance > distance - 0.02)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
