//! Several shapes in one picture, in rows and columns and all to one scale: what `--show` and
//! `--sweep` ask for.

use chladni_caricature::MAX_MU;
use chladni_mesh::surface::vec3::single;
use chladni_view::{
    Camera, ColorMap, Device, Picture, PictureRequest, PictureShape, Rect, Renderer, Scale, Style, layout,
    render_placed,
};

use crate::work::{Error, OwnLook, dots};

/// Which panels a picture has; without either, the shape before and after.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct SheetOptions {
    /// The panels of a row of the picture, in this order.
    #[arg(long, value_delimiter = ',', value_name = "PANEL", requires = "render")]
    pub show: Vec<Panel>,
    /// A row of panels for each of these μ of the top layer, such as -0.3,-0.4,-0.6.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "MU",
        value_parser = mu,
        allow_hyphen_values = true,
        requires = "render"
    )]
    pub sweep: Vec<f64>,
}

fn mu(text: &str) -> Result<f64, Error> {
    let parsed = text.trim().parse().ok().filter(|mu: &f64| mu.abs() <= MAX_MU);
    parsed.ok_or_else(|| Error::input(format!("μ must be a number from -{MAX_MU} to {MAX_MU}")))
}

/// The content of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Panel {
    /// The shape.
    Before,
    /// The result.
    After,
    /// The result, and the shape as dots.
    Rest,
    /// The result, and over it the template of the top layer as a translucent ghost.
    Ghost,
    /// The shape, and the result of each layer on the ones below: a panel each.
    Steps,
    /// The top layer in the coordinate model.
    Coordinate,
    /// The top layer in the normal model.
    Normal,
    /// The top layer in the distance model.
    Distance,
    /// χ01 of the top layer, as painted.
    Painted,
    /// χ of the top layer, smoothed.
    Region,
}

impl Panel {
    /// Whether it shows a shape alone, which is all that ink draws.
    pub fn is_plain(self) -> bool {
        !matches!(self, Self::Rest | Self::Ghost | Self::Painted | Self::Region)
    }
}

/// A shape in a panel.
pub struct Portrayed {
    pub positions: Vec<[f32; 3]>,
    /// A share from 0 to 1 of each vertex, drawn as a heat map.
    pub shares: Option<Vec<f32>>,
    /// The shape at rest, of which dots are drawn.
    pub rest: Vec<[f32; 3]>,
    /// Where its vertices lie on the template.
    pub ghost: Option<Vec<[f32; 3]>>,
}

impl Portrayed {
    /// A shape as it is.
    pub fn plain(positions: &[[f64; 3]]) -> Self {
        Self::of(single(positions))
    }

    /// The same in single precision.
    pub fn of(positions: Vec<[f32; 3]>) -> Self {
        Self { positions, shares: None, rest: Vec::new(), ghost: None }
    }
}

/// Where the panels of `rows` go, row by row, seen from where `camera` looks, fitted to all.
pub fn placed(rows: &[Vec<Portrayed>], mut camera: Camera, [width, height]: [u32; 2]) -> Vec<(Rect, Camera)> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let area = Rect::of_size(width, height);
    // They fill the sheet: some may be a pixel wider or higher than others.
    let cells = layout::grid(area, rows.len(), columns, 0, rows.len() * columns);
    let cells: Vec<Rect> =
        cells.into_iter().map(|c| Rect { width: c.width.max(1), height: c.height.max(1), ..c }).collect();
    let narrowest = layout::narrowest(&cells);
    let lowest = cells.iter().map(|cell| cell.height).min().unwrap_or(1);
    let all = rows
        .iter()
        .flatten()
        .flat_map(|panel| panel.positions.iter().chain(panel.ghost.iter().flatten()).copied());
    camera.fit(all, narrowest, 0.92);
    // All at one scale.
    let seen = |cell: &Rect| {
        let distance = camera.distance * cell.height as f32 / lowest as f32;
        (*cell, Camera { distance, ..camera })
    };
    let filled = cells.chunks(columns).zip(rows).flat_map(|(cells, panels)| &cells[..panels.len()]);
    filled.map(seen).collect()
}

/// Draws rows of shapes with the same triangles in their `own` look, seen from where `camera` looks, fitted to all.
pub fn draw(
    device: &Device,
    rows: &[Vec<Portrayed>],
    triangles: &[[u32; 3]],
    own: Option<&OwnLook>,
    camera: Camera,
    [width, height]: [u32; 2],
) -> Result<Picture, Error> {
    let mut renderer = Renderer::new(device);
    let style = Style::default();
    let mut sheet = Picture::filled(width, height, [255; 4]);
    let colors = own.and_then(OwnLook::colors);
    for (panel, (cell, camera)) in rows.iter().flatten().zip(placed(rows, camera, [width, height])) {
        // A heat map takes the place of the shape's own colors.
        let own = own.filter(|_| panel.shares.is_none());
        let scale = Scale { map: ColorMap::Viridis, low: 0.0, high: 1.0 };
        let dots = dots(panel.rest.iter().copied(), cell);
        let shape = PictureShape {
            positions: &panel.positions,
            triangles,
            values: panel.shares.as_deref().map(|shares| (shares, scale)),
            colors: own.and(colors.as_deref()),
            image: own.and_then(OwnLook::image),
            markers: &dots,
            ghost: panel.ghost.as_deref(),
            ..PictureShape::default()
        };
        let request = PictureRequest {
            shapes: std::slice::from_ref(&shape),
            width: cell.width,
            height: cell.height,
            from: camera,
            style,
        };
        let alone = Rect::of_size(cell.width, cell.height);
        let picture = render_placed(&mut renderer, &request, &[(alone, camera)])?;
        sheet.paste(&picture, cell.x, cell.y);
    }
    Ok(sheet)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_fill_the_sheet_at_one_scale() {
        let panel = || Portrayed::of(vec![[-1.0, -2.0, 0.0], [1.0, 2.0, 0.5]]);
        for (shape, size) in [(vec![3], [1600, 900]), (vec![2, 2, 2, 1, 2, 2, 2], [300, 900])] {
            let rows: Vec<Vec<Portrayed>> =
                shape.iter().map(|panels| (0..*panels).map(|_| panel()).collect()).collect();
            let placed = placed(&rows, Camera::default(), size);
            assert_eq!(placed.len(), shape.iter().sum::<usize>());
            let (last, _) = placed.last().unwrap();
            assert_eq!([last.x + last.width, last.y + last.height], size);
            for (cell, camera) in &placed {
                let pixels_of_one = cell.height as f32 / camera.distance;
                let (first, seen) = &placed[0];
                assert!((pixels_of_one * seen.distance / first.height as f32 - 1.0).abs() < 1e-5);
            }
        }
        // More panels than pixels.
        let rows = vec![(0..18).map(|_| panel()).collect::<Vec<_>>()];
        let placed = placed(&rows, Camera::default(), [16, 16]);
        assert!(placed.iter().all(|(cell, _)| cell.width == 1 && cell.x < 16));
    }
}
