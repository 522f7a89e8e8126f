//! How much of a picture may flash: a quarter of it, and of any field of view in it.

use crate::histogram::{CELLS, COLUMNS, Histogram, ROWS};

/// Cells that flash together may be one in this many: a quarter, of the screen (ITU-R BT.1702) and of any field of view of
/// 10° (WCAG 2.3.1).
const PART: u32 = 4;
/// A field of 10° is a third of the picture across and down, as WCAG takes it: 341 × 256 of 1024 × 768 pixels.
const FIELD: [usize; 2] = [COLUMNS.div_ceil(3), ROWS.div_ceil(3)];

/// Where no more than a quarter may flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlashArea {
    /// In the whole picture (ITU-R BT.1702).
    #[default]
    Screen,
    /// In any field of a third of its width and height, too: what WCAG 2.3.1 takes for 10° of view. A body that swings over a
    /// dark ground flashes along its way, so that many dances are darkened.
    Field,
}

/// How many cells of everything above and to the left of a corner are chosen, and have pixels.
type Sums = [[[u32; 2]; COLUMNS + 1]; ROWS + 1];

/// Whether more than a quarter of the cells of `area` that have pixels are `chosen`.
pub(crate) fn are_too_many(picture: &Histogram, area: FlashArea, chosen: impl Fn(usize) -> bool) -> bool {
    let mut sums: Sums = [[[0; 2]; COLUMNS + 1]; ROWS + 1];
    let mut any = false;
    for cell in 0..CELLS {
        let (row, column) = (cell / COLUMNS, cell % COLUMNS);
        let has_pixels = picture.has(cell);
        let is_chosen = has_pixels && chosen(cell);
        any |= is_chosen;
        for (i, here) in [is_chosen, has_pixels].into_iter().enumerate() {
            let around = sums[row][column + 1][i] + sums[row + 1][column][i] - sums[row][column][i];
            sums[row + 1][column + 1][i] = u32::from(here) + around;
        }
    }
    let is_over = |[top, left]: [usize; 2], [rows, columns]: [usize; 2]| {
        let [chosen, all] = [0, 1].map(|i| {
            let (bottom, right) = (top + rows, left + columns);
            sums[bottom][right][i] + sums[top][left][i] - sums[top][right][i] - sums[bottom][left][i]
        });
        PART * chosen > all
    };
    let [across, down] = FIELD;
    let mut fields = (0..=ROWS - down).flat_map(|top| (0..=COLUMNS - across).map(move |left| [top, left]));
    any && (is_over([0, 0], [ROWS, COLUMNS])
        || area == FlashArea::Field && fields.any(|corner| is_over(corner, [down, across])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_any_field_is_as_much_as_may_flash() {
        let mut picture = Histogram::default();
        let size = [COLUMNS as u32, ROWS as u32];
        (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| [x, y]))
            .for_each(|at| picture.add(at, size, [0; 3]));
        let block = |left: usize, top: usize, columns: usize, rows: usize| {
            are_too_many(&picture, FlashArea::Field, |cell| {
                (left..left + columns).contains(&(cell % COLUMNS))
                    && (top..top + rows).contains(&(cell / COLUMNS))
            })
        };
        // A field has 16 × 11 cells.
        assert!(!block(20, 10, 11, 4) && block(20, 10, 9, 5));
        assert!(block(0, 0, 7, 7) && block(41, 25, 7, 7) && !block(0, 0, 48, 2));
        for area in [FlashArea::Screen, FlashArea::Field] {
            assert!(!are_too_many(&picture, area, |cell| cell % 5 == 0));
            assert!(are_too_many(&picture, area, |cell| cell % 3 == 0));
            assert!(!are_too_many(&Histogram::default(), area, |_| true));
        }
        let left = |columns: usize| move |cell: usize| cell % COLUMNS < columns;
        assert!(!are_too_many(&picture, FlashArea::Screen, left(12)));
        assert!(are_too_many(&picture, FlashArea::Screen, left(13)));
    }
}
