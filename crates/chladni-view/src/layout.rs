//! Where pictures go on the canvas.

/// A rectangle of pixels; (x, y) is its upper left corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rect {
    /// Left edge, pixels.
    pub x: u32,
    /// Upper edge, pixels.
    pub y: u32,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
}

impl Rect {
    /// A rectangle at the origin.
    pub fn of_size(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Width over height.
    pub fn aspect(&self) -> f32 {
        self.width.max(1) as f32 / self.height.max(1) as f32
    }

    /// Whether the pixel at (x, y) lies inside.
    pub fn contains(&self, x: f32, y: f32) -> bool {
        x >= self.x as f32
            && y >= self.y as f32
            && x < (self.x + self.width) as f32
            && y < (self.y + self.height) as f32
    }
}

/// Rows and columns that give `count` cells of `cell_aspect` (width over height) the most room
/// in `width` × `height`.
pub fn rows_and_columns(width: u32, height: u32, count: usize, cell_aspect: f32) -> (usize, usize) {
    let count = count.max(1);
    let side = |columns: usize| {
        let rows = count.div_ceil(columns);
        (width as f32 / columns as f32).min(height as f32 / rows as f32 * cell_aspect)
    };
    let empty = |columns: usize| count.div_ceil(columns) * columns - count;
    let columns =
        (1..=count).max_by(|a, b| side(*a).total_cmp(&side(*b)).then(empty(*b).cmp(&empty(*a)))).unwrap_or(1);
    (count.div_ceil(columns), columns)
}

/// `count` cells in `area`, row by row, `gap` pixels between them; the last row may be short.
pub fn grid(area: Rect, rows: usize, columns: usize, gap: u32, count: usize) -> Vec<Rect> {
    let edge = |length: u32, parts: usize, i: usize| {
        let room = length.saturating_sub(gap * (parts as u32).saturating_sub(1));
        (u64::from(room) * i as u64 / parts as u64) as u32 + gap * i as u32
    };
    let (rows, columns) = (rows.max(1), columns.max(1));
    (0..count.min(rows * columns))
        .map(|i| {
            let (row, column) = (i / columns, i % columns);
            let (x, y) = (edge(area.width, columns, column), edge(area.height, rows, row));
            Rect {
                x: area.x + x,
                y: area.y + y,
                width: (edge(area.width, columns, column + 1) - x).saturating_sub(gap),
                height: (edge(area.height, rows, row + 1) - y).saturating_sub(gap),
            }
        })
        .collect()
}

/// Cells of `cell_aspect` (width over height) for `count` things, as large as `area` allows, `gap` pixels apart.
pub fn arranged(area: Rect, count: usize, cell_aspect: f32, gap: u32) -> Vec<Rect> {
    let (rows, columns) = rows_and_columns(area.width, area.height, count, cell_aspect);
    grid(area, rows, columns, gap, count)
}

/// Width over height of the narrowest of `cells`.
pub fn narrowest(cells: &[Rect]) -> f32 {
    cells.iter().map(Rect::aspect).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_share_the_area_without_overlap() {
        let cells = grid(Rect { x: 5, y: 7, width: 1000, height: 501 }, 3, 4, 10, 11);
        assert_eq!(cells.len(), 11);
        assert_eq!((cells[0].x, cells[0].y), (5, 7));
        assert_eq!(cells[3].x + cells[3].width, 1005);
        assert_eq!(cells[8].y + cells[8].height, 508);
        for pair in cells[..4].windows(2) {
            assert_eq!(pair[0].x + pair[0].width + 10, pair[1].x);
        }
    }

    #[test]
    fn a_wide_canvas_gets_more_columns_than_rows() {
        assert_eq!(rows_and_columns(1600, 900, 12, 1.0), (3, 4));
        assert_eq!(rows_and_columns(1600, 900, 6, 1.0), (2, 3));
        assert_eq!(rows_and_columns(900, 1600, 2, 1.0), (2, 1));
        assert_eq!(rows_and_columns(100, 100, 1, 1.0), (1, 1));
        assert_eq!(rows_and_columns(0, 0, 0, 1.0), (1, 1));
    }
}
