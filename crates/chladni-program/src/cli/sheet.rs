//! Several shapes in one picture, in rows and columns and all to one scale: what `--show` and
//! `--sweep` ask for.

use chladni_caricature::MAX_MU;
use chladni_view::{
    Camera, ColorMap, Device, Marker, Picture, PictureRequest, PictureShape, Rect, Renderer, Scale, Style,
    render_placed,
};

use crate::work::{Error, OwnLook};

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
    pub dots: Vec<Marker>,
    /// Where its vertices lie on the template.
    pub ghost: Option<Vec<[f32; 3]>>,
}

impl Portrayed {
    /// A shape as it is.
    pub fn plain(positions: &[[f64; 3]]) -> Self {
        Self::of(positions.iter().map(|p| p.map(|c| c as f32)).collect())
    }

    /// The same in single precision.
    pub fn of(positions: Vec<[f32; 3]>) -> Self {
        Self { positions, shares: None, dots: Vec::new(), ghost: None }
    }
}

/// Where the panels of `rows` go, row by row, seen from where `camera` looks, fitted to all.
pub fn placed(rows: &[Vec<Portrayed>], mut camera: Camera, [width, height]: [u32; 2]) -> Vec<(Rect, Camera)> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as u32;
    let (cell_width, cell_height) = ((width / columns).max(1), (height / rows.len().max(1) as u32).max(1));
    let all = rows
        .iter()
        .flatten()
        .flat_map(|panel| panel.positions.iter().chain(panel.ghost.iter().flatten()).copied());
    camera.fit(all, cell_width as f32 / cell_height as f32, 0.92);
    let cell = |row: u32, column: u32| Rect {
        x: column * cell_width,
        y: row * cell_height,
        width: cell_width,
        height: cell_height,
    };
    let cells =
        (0..).zip(rows).flat_map(|(row, panels)| (0..).zip(panels).map(move |(column, _)| (row, column)));
    cells.map(|(row, column)| (cell(row, column), camera)).collect()
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
        let shape = PictureShape {
            positions: &panel.positions,
            triangles,
            values: panel.shares.as_deref().map(|shares| (shares, scale)),
            colors: own.and(colors.as_deref()),
            image: own.and_then(OwnLook::image),
            markers: &panel.dots,
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
