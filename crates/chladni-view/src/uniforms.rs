//! Cells and figures as numbers for both renderers, and the checks on them.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

use crate::style::{brightness, linear};
use crate::{Answer, Cell, Figure, NodalLines, Paint, Panorama, Samples, Surroundings, ViewError};

/// Texels of a side, columns and rows of `count` maps in a texture of at most `limit` texels a side.
pub(crate) fn arrangement(count: u32, samples: Samples, limit: u32) -> (u32, u32, u32) {
    let columns = count.isqrt() + u32::from(count.isqrt().pow(2) < count);
    let size = if count == 1 { 1024 } else { 512 } >> u32::from(samples == Samples::One);
    // So many that they would not fit are smaller.
    let size = size.min(limit / columns).max(1);
    (size, columns, count.div_ceil(columns))
}

/// A cell, as `scene.wgsl` describes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct CellUniform {
    pub(crate) view: [[f32; 4]; 4],
    pub(crate) projection: [[f32; 4]; 4],
    pub(crate) lights: [[[f32; 4]; 2]; 3],
    pub(crate) sky: [f32; 4],
    pub(crate) ground: [f32; 4],
    pub(crate) background_center: [f32; 4],
    pub(crate) background_corner: [f32; 4],
    pub(crate) viewport: [f32; 4],
    pub(crate) output: [f32; 4],
    pub(crate) shadow: [[f32; 4]; 4],
    pub(crate) shadow_map: [f32; 4],
    pub(crate) shadow_place: [f32; 4],
    pub(crate) horizon: [f32; 4],
    pub(crate) floor: [f32; 4],
    pub(crate) floor_plane: [f32; 4],
    pub(crate) floor_axes: [[f32; 4]; 2],
    pub(crate) wings: [f32; 4],
}

/// A figure, as `scene.wgsl` describes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct FigureUniform {
    pub(crate) model: [[f32; 4]; 4],
    pub(crate) color: [f32; 4],
    pub(crate) back: [f32; 4],
    pub(crate) material: [f32; 4],
    pub(crate) scale: [f32; 4],
    pub(crate) wire: [f32; 4],
    pub(crate) wire_width: [f32; 4],
    pub(crate) brush: [f32; 4],
    pub(crate) edge: [f32; 4],
    pub(crate) answer: [f32; 4],
    pub(crate) glow: [f32; 4],
    pub(crate) figured: [f32; 4],
    pub(crate) lines: [f32; 4],
    pub(crate) line: [f32; 4],
    pub(crate) grain: [f32; 4],
}

/// Heat maps and bare backgrounds have no shadows.
pub(crate) fn casts_shadows(cell: &Cell<'_>) -> bool {
    let shaded = |figure: &Figure<'_>| !matches!(figure.paint, Paint::Values(..));
    cell.lights.shadow > 0.0 && cell.figures.iter().any(shaded)
}

/// The key light's parallel view of all that the camera can reach, and how its map is read.
pub(crate) fn key_light_view(cell: &Cell<'_>, size: u32) -> ([[f32; 4]; 4], [f32; 4]) {
    let camera = &cell.camera;
    let [right, up, back] = camera.axes();
    let d = Vec3::from(cell.lights.lights[0].direction).normalize_or(Vec3::Y);
    let z = (right * d.x + up * d.y + back * d.z).normalize();
    let x = z.any_orthonormal_vector();
    let y = z.cross(x);
    // Deformed shapes may leave the rest pose's reach a little.
    let radius = camera.reach * 1.25;
    let target = Vec3::from(camera.target);
    let (x, y, z) = (x / radius, y / radius, -z / (2.0 * radius));
    let row = |axis: Vec3, offset: f32| axis.extend(offset - axis.dot(target));
    let matrix = Mat4::from_rows(row(x, 0.0), row(y, 0.0), row(z, 0.5), glam::Vec4::W);
    let scene_per_texel = 2.0 * radius / size as f32;
    (matrix.to_cols_array_2d(), [cell.lights.shadow, size as f32, scene_per_texel, 0.0])
}

/// Whether `cell` lies on a canvas of this size.
pub(crate) fn check_cell(cell: &Cell<'_>, width: u32, height: u32) -> Result<(), ViewError> {
    let r = cell.viewport;
    let fits = |start: u32, length: u32, limit: u32| {
        length > 0 && start.checked_add(length).is_some_and(|end| end <= limit)
    };
    if fits(r.x, r.width, width) && fits(r.y, r.height, height) {
        return Ok(());
    }
    Err(ViewError::Shape(format!("a cell at {r:?} on a canvas of {width}×{height}")))
}

/// Whether all that a figure is made of belongs together.
pub(crate) fn check_figure(figure: &Figure<'_>) -> Result<(), ViewError> {
    let Figure { topology, buffers, item, .. } = figure;
    if let Some(lag) = figure.lag.filter(|lag| *lag >= buffers.items) {
        return Err(ViewError::Shape(format!("item {lag} of {} for speed", buffers.items)));
    }
    if topology.vertices != buffers.vertices || *item >= buffers.items {
        return Err(ViewError::Shape(format!(
            "item {item} of {} with {} vertices, and triangles over {}",
            buffers.items, buffers.vertices, topology.vertices
        )));
    }
    if let Some(of) = figure.grains {
        let beyond = |v: &u32| *v as usize >= buffers.vertices;
        if of.grains.iter().any(|grain| grain.corners.iter().any(beyond)) {
            return Err(ViewError::Shape(format!("a grain beyond {} vertices", buffers.vertices)));
        }
    }
    if let Some(ring) = figure.brush.filter(|ring| ring.reach.vertices != buffers.vertices) {
        let (found, wanted) = (ring.reach.vertices, buffers.vertices);
        return Err(ViewError::Shape(format!("a brush on {found} vertices of {wanted}")));
    }
    match figure.paint {
        Paint::Values(paint, _) | Paint::Colors(paint) if paint.vertices != buffers.vertices => {
            Err(ViewError::Shape(format!("{} painted vertices of {}", paint.vertices, buffers.vertices)))
        }
        Paint::Answer(rest, _) if rest.vertices != buffers.vertices => {
            Err(ViewError::Shape(format!("a rest of {} vertices for {}", rest.vertices, buffers.vertices)))
        }
        Paint::Skin(_) if !topology.has_uvs => Err(ViewError::Shape("a skin on a shape without UVs".into())),
        _ => Ok(()),
    }
}

/// How much brighter a panorama is than the sky and ground in whose place it shines: they had softboxes beside them.
const PANORAMA: f32 = 1.8;

pub(crate) fn cell_uniform(cell: &Cell<'_>, encode: bool, surroundings: &Surroundings) -> CellUniform {
    let usual = 0.5 * (brightness(cell.lights.sky) + brightness(cell.lights.ground));
    let around = surroundings.around.as_ref().map_or(0.0, |_| PANORAMA * usual / Panorama::MEAN);
    let behind = surroundings.behind.as_ref().map_or(0.0, |(_, aspect)| *aspect);
    let rgb = |[r, g, b]: [f32; 3], w| [r, g, b, w];
    let srgb = |color: [u8; 3], w| rgb(color.map(|c| f32::from(c) / 255.0), w);
    let r = cell.viewport;
    let strength = cell.background.strength;
    let orthographic = cell.camera.projection == crate::Projection::Orthographic;
    CellUniform {
        view: cell.camera.view_matrix().to_cols_array_2d(),
        projection: cell.camera.projection_matrix(r.aspect()).to_cols_array_2d(),
        lights: cell.lights.lights.map(|light| {
            let direction = Vec3::from(light.direction).normalize_or(Vec3::Y);
            [rgb(direction.to_array(), 0.0), rgb(light.color, 0.0)]
        }),
        sky: rgb(cell.lights.sky, cell.lights.strips),
        ground: rgb(cell.lights.ground, around),
        background_center: srgb(cell.background.center, cell.background.opacity),
        background_corner: srgb(cell.background.corner, f32::from(cell.background.gradient as u8)),
        viewport: [r.x as f32, r.y as f32, r.width as f32, r.height as f32],
        output: [
            f32::from(u8::from(encode)),
            behind,
            f32::from(u8::from(orthographic)),
            f32::from(cell.lights.curve as u8),
        ],
        horizon: rgb(cell.lights.horizon, 0.0),
        wings: [cell.lights.exposure[0], cell.lights.exposure[1], strength[0], strength[1]],
        ..floor_uniform(cell, behind > 0.0)
    }
}

/// The floor in the viewer's axes: its plane, and two directions along it in which the shadow's edge is 1 away
/// from its middle. Before a picture there is none; parallel views, and floors that are seen from below or edge on, show none.
fn floor_uniform(cell: &Cell<'_>, is_hidden: bool) -> CellUniform {
    let nothing = CellUniform::zeroed();
    let (camera, Some(floor)) = (&cell.camera, cell.background.floor) else { return nothing };
    let view = camera.view_matrix();
    let up = view.transform_vector3(camera.up());
    let at = view.transform_point3(Vec3::from(floor.at));
    // The eye is the origin: it must be above the floor.
    let height = -up.dot(at);
    let flat = camera.projection == crate::Projection::Orthographic;
    if is_hidden || flat || height <= 0.0 || floor.radius <= 0.0 || !(height + floor.radius).is_finite() {
        return nothing;
    }
    let right = (Vec3::X - up * up.x).normalize_or(Vec3::Z);
    let along = |axis: Vec3| (axis / floor.radius).extend(-axis.dot(at) / floor.radius).to_array();
    let [r, g, b] = floor.color.map(|c| f32::from(c) / 255.0);
    CellUniform {
        floor: [r, g, b, floor.shadow.clamp(0.0, 1.0)],
        floor_plane: up.extend(height).to_array(),
        floor_axes: [along(right), along(up.cross(right))],
        ..nothing
    }
}

/// Rows of a picture in which the width of nodal lines is a number of pixels.
const LINES_HIGH: f32 = 720.0;

/// How a figure's palette answers. Under wires it knows neither speed nor nodal lines.
pub(crate) fn answer_of(figure: &Figure<'_>) -> Option<Answer> {
    let Paint::Answer(_, by) = figure.paint else { return None };
    let wired = Answer { haste: 0.0, spark: 0.0, phase: 0.0, lines: NodalLines::NONE, ..by };
    Some(if figure.wire.is_some() { wired } else { by })
}

pub(crate) fn figure_uniform(figure: &Figure<'_>) -> FigureUniform {
    let rgb = |[r, g, b]: [f32; 3], w| [r, g, b, w];
    let srgb = |color: [u8; 3], w| rgb(color.map(|c| f32::from(c) / 255.0), w);
    let (kind, scale) = match figure.paint {
        Paint::Material => (0.0, None),
        Paint::Values(_, scale) => (1.0, Some(scale)),
        Paint::Colors(_) => (2.0, None),
        Paint::Skin(_) => (3.0, None),
        Paint::Answer(..) => (4.0, None),
    };
    let mut scale = scale
        .map_or([0.0; 4], |scale| [scale.low, (scale.high - scale.low).recip(), scale.map.row() as f32, 0.0]);
    let (mut answer, mut answer_glow) = (Answer { travel: 0.0, ..Answer::MOVED }, [0.0, 1.0, 0.0]);
    if let Some(by) = answer_of(figure) {
        answer = by;
        answer_glow = [by.glow, by.saturation, f32::from(u8::from(by.palette.is_circle()))];
        scale[2] = by.palette.row() as f32;
    }
    let Answer { haste, spark, crease, lines, .. } = answer;
    let phase = answer.phase * answer.palette.period();
    let knows_speed = f32::from(u8::from(figure.lag.is_some()));
    let m = figure.material;
    // In two parts that are exact as f32, whatever the number of vertices.
    let first_vertex = figure.item * figure.buffers.vertices;
    let [first_high, first_low] = [first_vertex >> 16, first_vertex & 0xffff].map(|part| part as f32);
    FigureUniform {
        model: Mat4::from_cols_array_2d(&figure.model).to_cols_array_2d(),
        color: rgb(linear(m.color), figure.opacity),
        // Back faces are a shade redder and darker: one sees where a surface is open.
        back: [0.78, 0.62, 0.58, kind],
        material: [m.roughness, m.metal, m.softness, m.iridescence],
        scale,
        wire: figure.wire.map_or([0.0; 4], |wire| srgb(wire.color, wire.opacity)),
        wire_width: [figure.wire.map_or(0.0, |wire| wire.width_px), first_high, first_low, 0.0],
        brush: figure.brush.map_or([0.0; 4], |ring| srgb(ring.color, ring.radius)),
        edge: rgb(linear(m.edge), 0.0),
        answer: [answer.offset, answer.span, answer.swing, answer.travel],
        glow: [m.glow, answer_glow[0], answer_glow[1], answer_glow[2]],
        figured: [knows_speed * haste, knows_speed * spark, knows_speed * phase, crease],
        lines: srgb(lines.color, lines.opacity),
        line: [lines.width / LINES_HIGH, answer.farthest, 0.0, 0.0],
        grain: figure.grains.map_or([0.0; 4], |of| rgb(linear(of.color), of.radius)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadow_maps_fit_into_their_texture() {
        assert_eq!(arrangement(1, Samples::Four, 8192), (1024, 1, 1));
        assert_eq!(arrangement(12, Samples::One, 8192), (256, 4, 3));
        for count in [1, 2, 16, 17, 256, 257, 1000, 4096] {
            let (size, columns, rows) = arrangement(count, Samples::Four, 2048);
            assert!(size * columns.max(rows) <= 2048 && columns * rows >= count, "{count}: {size}");
        }
    }
}
