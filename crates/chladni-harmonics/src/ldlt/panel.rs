//! The memory layout of L: panels of eight rows, stored column by column. A solve reads one cache line for
//! eight products.

/// Rows of a panel; the last one of a block may have fewer.
pub(super) const PANEL: usize = 8;

/// The number of values that the diagonal block of a supernode of this width takes: for each panel of rows,
/// the remaining rectangle and then the triangle, stored as a square.
pub(super) fn diagonal_len(width: usize) -> usize {
    let (panels, last) = (width / PANEL, width % PANEL);
    PANEL * PANEL * (panels * (panels + 1) / 2) + last * width
}

/// Writes the first `width` columns of a front of `size` rows, which are `ld` apart, to `values`.
#[inline(always)]
pub(super) fn pack(front: &[f64], ld: usize, width: usize, size: usize, values: &mut [f64]) {
    let mut rest = values;
    let blocks = [(0, width), (width, size)];
    for (start, end) in blocks {
        for first in (start..end).step_by(PANEL) {
            let rows = (end - first).min(PANEL);
            let columns = (first + rows).min(width);
            let (panel, after) = rest.split_at_mut(rows * columns);
            rest = after;
            if let Some(front) = (rows == PANEL).then(|| &front[first * ld..(first + PANEL) * ld]) {
                let rows: [&[f64]; PANEL] = std::array::from_fn(|r| &front[r * ld..r * ld + columns]);
                for (k, panel) in panel.as_chunks_mut::<PANEL>().0.iter_mut().enumerate() {
                    for r in 0..PANEL {
                        panel[r] = rows[r][k];
                    }
                }
            } else {
                for (k, panel) in panel.chunks_exact_mut(rows).enumerate() {
                    for (r, value) in panel.iter_mut().enumerate() {
                        *value = front[(first + r) * ld + k];
                    }
                }
            }
        }
    }
}
