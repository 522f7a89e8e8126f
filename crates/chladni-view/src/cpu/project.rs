//! From items to the screen: vertices projected, triangles clipped and sorted into tiles.

use super::instructions::Kernel;

/// Where sub-pixels begin: the screen is a grid of 1/256 of a pixel, on which edges are exact.
pub(super) const SUBPIXEL_BITS: u32 = 8;
pub(super) const SUBPIXELS: i32 = 1 << SUBPIXEL_BITS;

/// How far from the screen's origin a vertex may lie, sub-pixels; what leaves it is clipped.
const GUARD: f32 = (1 << 23) as f32;

/// Triangles that are sorted together.
pub(super) const CHUNK: usize = 2048;

/// A projected vertex: sub-pixels from the canvas's (or map's) corner, y down, and depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Corner {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) z: f32,
}

/// The x of a vertex that is not on the grid: before the near plane, far outside, or no number.
const OFF: i32 = i32::MIN;

/// From an item's coordinates to the screen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lens {
    /// Rows of the matrix to clip space.
    pub(super) rows: [[f32; 4]; 4],
    /// From clip space to sub-pixels, x and y.
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
}

impl Lens {
    /// Clip space of `matrix` (column-major) onto a rectangle of pixels.
    pub(super) fn new(matrix: glam::Mat4, [x, y, width, height]: [f32; 4]) -> Self {
        let half = 0.5 * SUBPIXELS as f32;
        Self {
            rows: matrix.transpose().to_cols_array_2d(),
            scale: [half * width, -half * height],
            offset: [2.0 * half * x + half * width, 2.0 * half * y + half * height],
        }
    }

    // Written out: the array's own `map` is called for each vertex and keeps the loop from becoming vectors.
    #[inline(always)]
    fn clip(&self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        let [a, b, c, d] = &self.rows;
        let row = |r: &[f32; 4]| r[0] * x + r[1] * y + r[2] * z + r[3];
        [row(a), row(b), row(c), row(d)]
    }

    #[inline(always)]
    fn corner(&self, [x, y, z, w]: [f32; 4]) -> Corner {
        let sx = self.offset[0] + self.scale[0] * (x / w);
        let sy = self.offset[1] + self.scale[1] * (y / w);
        // Comparisons with NaN are false.
        let on = (z >= 0.0) & (w > 0.0) & (sx.abs() <= GUARD) & (sy.abs() <= GUARD);
        let whole = |s: f32| (s + 0.5).floor() as i32;
        Corner { x: if on { whole(sx) } else { OFF }, y: whole(sy), z: z / w }
    }
}

/// Projects positions to corners.
pub(super) struct Project<'a> {
    pub(super) lens: &'a Lens,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) corners: &'a mut [Corner],
}

impl Kernel for Project<'_> {
    #[inline(always)]
    fn run(self) {
        for (corner, p) in self.corners.iter_mut().zip(self.positions) {
            *corner = self.lens.corner(self.lens.clip(*p));
        }
    }
}

/// Twice the area of a triangle in sub-pixels; negative on fronts, which are wound counter-clockwise where
/// y goes up, and here it goes down.
#[inline(always)]
pub(super) fn area([a, b, c]: &[Corner; 3]) -> i64 {
    let wide = |a: i32, b: i32| i64::from(b) - i64::from(a);
    wide(a.x, b.x) * wide(a.y, c.y) - wide(a.y, b.y) * wide(a.x, c.x)
}

/// Binary logarithms of a tile's width and height: its samples fit the first cache.
pub(super) const TILE_BITS: [u32; 2] = [5, 5];

/// Tiles that cover a rectangle of pixels; they lie on one grid for the whole canvas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Grid {
    /// First and last pixels, inclusive.
    pub(super) low: [i32; 2],
    pub(super) high: [i32; 2],
    /// Binary logarithms of a tile's width and height.
    pub(super) bits: [u32; 2],
}

impl Grid {
    fn first(&self) -> [i32; 2] {
        [self.low[0] >> self.bits[0], self.low[1] >> self.bits[1]]
    }

    fn columns(&self) -> i32 {
        (self.high[0] >> self.bits[0]) - self.first()[0] + 1
    }

    pub(super) fn tiles(&self) -> usize {
        (self.columns() * ((self.high[1] >> self.bits[1]) - self.first()[1] + 1)) as usize
    }

    /// Index of the tile in this column and row of the canvas.
    pub(super) fn tile(&self, column: i32, row: i32) -> usize {
        let [first_column, first_row] = self.first();
        ((row - first_row) * self.columns() + column - first_column) as usize
    }
}

/// Part of a triangle that was clipped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) corners: [Corner; 3],
    pub(super) triangle: u32,
}

/// Set in a reference to a [`Piece`] instead of a triangle.
const PIECE: u32 = 1 << 31;

/// Some triangles, sorted into tiles.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    /// Place and reference, as they come; each tile has a place for fronts and one for backs.
    found: Vec<(u32, u32)>,
    /// Where each place's references begin in `sorted`.
    starts: Vec<u32>,
    sorted: Vec<u32>,
    pieces: Vec<Piece>,
}

impl Chunk {
    /// Sorts `triangles`, the first of which has index `first`.
    pub(super) fn sort(
        &mut self,
        (lens, grid): (&Lens, &Grid),
        (first, triangles): (usize, &[[u32; 3]]),
        positions: &[[f32; 3]],
        corners: &[Corner],
    ) {
        self.found.clear();
        self.pieces.clear();
        for (i, triangle) in (first as u32..).zip(triangles) {
            // Written out: copies through memory would wait for themselves.
            let [a, b, c] = *triangle;
            let all = [corners[a as usize], corners[b as usize], corners[c as usize]];
            if all.iter().any(|corner| corner.x == OFF) {
                for corners in pieces(lens, triangle.map(|v| positions[v as usize]), all) {
                    let reference = PIECE | self.pieces.len() as u32;
                    self.pieces.push(Piece { corners, triangle: i });
                    self.find(grid, &corners, reference);
                }
            } else {
                self.find(grid, &all, i);
            }
        }
        self.count(2 * grid.tiles());
    }

    #[inline(always)]
    fn find(&mut self, grid: &Grid, corners: &[Corner; 3], reference: u32) {
        let [a, b, c] = corners;
        // Triangles without area cover nothing.
        let area = area(corners);
        if area == 0 {
            return;
        }
        let back = u32::from(area > 0);
        let span = |a: i32, b: i32, c: i32, axis: usize| {
            let low = (a.min(b).min(c) >> SUBPIXEL_BITS).max(grid.low[axis]);
            let high = (a.max(b).max(c) >> SUBPIXEL_BITS).min(grid.high[axis]);
            (low, high)
        };
        let ((left, right), (top, bottom)) = (span(a.x, b.x, c.x, 0), span(a.y, b.y, c.y, 1));
        if left > right || top > bottom {
            return;
        }
        let [columns, rows] = grid.bits;
        let (left, right, top, bottom) = (left >> columns, right >> columns, top >> rows, bottom >> rows);
        for row in top..=bottom {
            for column in left..=right {
                self.found.push((2 * grid.tile(column, row) as u32 + back, reference));
            }
        }
    }

    /// Sorts the triangles found by place, in the order in which they came.
    fn count(&mut self, places: usize) {
        self.starts.clear();
        self.starts.resize(places + 1, 0);
        for (place, _) in &self.found {
            self.starts[*place as usize + 1] += 1;
        }
        for place in 0..places {
            self.starts[place + 1] += self.starts[place];
        }
        self.sorted.clear();
        self.sorted.resize(self.found.len(), 0);
        for (place, reference) in &self.found {
            let at = &mut self.starts[*place as usize];
            self.sorted[*at as usize] = *reference;
            *at += 1;
        }
        // Each now holds where its place ends, which is where the next one begins.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// The fronts that lie in a tile, or the backs.
    pub(super) fn tile(&self, tile: usize, front: bool) -> &[u32] {
        let place = 2 * tile + usize::from(!front);
        &self.sorted[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// Whether nothing lies in a tile.
    pub(super) fn is_empty(&self, tile: usize) -> bool {
        self.starts[2 * tile] == self.starts[2 * tile + 2]
    }

    /// The corners of a reference, and its triangle.
    #[inline(always)]
    pub(super) fn resolve(
        &self,
        reference: u32,
        triangles: &[[u32; 3]],
        corners: &[Corner],
    ) -> ([Corner; 3], u32) {
        if reference & PIECE == 0 {
            let [a, b, c] = triangles[reference as usize];
            ([corners[a as usize], corners[b as usize], corners[c as usize]], reference)
        } else {
            let piece = self.pieces[(reference ^ PIECE) as usize];
            (piece.corners, piece.triangle)
        }
    }
}

/// The parts on the grid of a triangle whose positions project to `corners`: the whole triangle, or pieces of it.
pub(super) fn pieces(
    lens: &Lens,
    positions: [[f32; 3]; 3],
    corners: [Corner; 3],
) -> impl Iterator<Item = [Corner; 3]> {
    let whole = corners.iter().all(|corner| corner.x != OFF);
    let clipped = (!whole).then(|| Clipped::new(positions.map(|p| lens.clip(p)), lens).pieces(lens));
    whole.then_some(corners).into_iter().chain(clipped.into_iter().flatten())
}

/// A triangle in clip space, cut at the near plane and at the edges of the grid.
struct Clipped {
    corners: [[f32; 4]; 8],
    count: usize,
}

impl Clipped {
    fn new(triangle: [[f32; 4]; 3], lens: &Lens) -> Self {
        let mut all = Self { corners: [[0.0; 4]; 8], count: 0 };
        if !triangle.iter().flatten().all(|c| c.is_finite()) {
            return all;
        }
        all.corners[..3].copy_from_slice(&triangle);
        all.count = 3;
        all.cut(|[_, _, z, _]| z);
        // A little in front of the eye: w is positive from here on.
        all.cut(|[_, _, _, w]| w - 1e-6);
        for axis in 0..2 {
            let (scale, offset) = (lens.scale[axis], lens.offset[axis]);
            let limit = 0.999 * GUARD;
            all.cut(|c| (limit - offset) * c[3] - scale * c[axis]);
            all.cut(|c| (limit + offset) * c[3] + scale * c[axis]);
        }
        all
    }

    /// Keeps the part on the side where `distance` is not negative (Sutherland & Hodgman 1974).
    fn cut(&mut self, distance: impl Fn([f32; 4]) -> f32) {
        let (before, count) = (self.corners, self.count);
        self.count = 0;
        for i in 0..count {
            let (a, b) = (before[i], before[(i + 1) % count]);
            let (da, db) = (distance(a), distance(b));
            if da >= 0.0 {
                self.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                let share = da / (da - db);
                self.push(std::array::from_fn(|k| a[k] + share * (b[k] - a[k])));
            }
        }
    }

    fn push(&mut self, corner: [f32; 4]) {
        // Six planes cut a triangle to nine corners at most, of which rounding alone needs the ninth.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// The fan of triangles that is left.
    fn pieces(self, lens: &Lens) -> impl Iterator<Item = [Corner; 3]> {
        let (lens, count) = (*lens, self.count);
        let corner = move |i: usize| {
            let [x, y, z, w] = self.corners[i];
            // The cut itself may round to just before the plane.
            lens.corner([x, y, z.max(0.0), w])
        };
        (2..count.max(2))
            .map(move |i| [corner(0), corner(i - 1), corner(i)])
            .filter(|corners| corners.iter().all(|corner| corner.x != OFF))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_through_the_eye_is_cut_in_front_of_it() {
        let lens = Lens::new(crate::Camera::default().projection_matrix(1.0), [0.0, 0.0, 100.0, 100.0]);
        let clip = |p| lens.clip(p);
        let cut = Clipped::new([clip([0.0, 0.0, -2.0]), clip([0.5, 0.0, 1.0]), clip([0.0, 0.5, 1.0])], &lens);
        assert_eq!(cut.count, 3);
        let pieces: Vec<[Corner; 3]> = cut.pieces(&lens).collect();
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].iter().all(|c| (0.0..=1.0).contains(&c.z)), "{pieces:?}");
        let lost = Clipped::new([[f32::NAN; 4], [0.0; 4], [1.0; 4]], &lens);
        assert_eq!(lost.pieces(&lens).count(), 0);
    }

    #[test]
    fn every_tile_gets_what_touches_it_in_order() {
        let grid = Grid { low: [10, 5], high: [150, 90], bits: [6, 5] };
        assert_eq!(grid.tiles(), 9);
        let at = |x: i32, y: i32| Corner { x: x << SUBPIXEL_BITS, y: y << SUBPIXEL_BITS, z: 0.5 };
        let corners = [at(0, 0), at(140, 3), at(60, 60), at(62, 40), at(66, 44), at(70, 42), at(900, 900)];
        let lens = Lens::new(glam::Mat4::IDENTITY, [0.0; 4]);
        let mut chunk = Chunk::default();
        let triangles = [[0, 1, 2], [3, 4, 5], [3, 5, 4], [6, 6, 6]];
        chunk.sort((&lens, &grid), (0, &triangles), &[], &corners);
        let tile =
            |column, row| [true, false].map(|front| chunk.tile(grid.tile(column, row), front).to_vec());
        assert_eq!(tile(0, 0), [vec![], vec![0]]);
        assert_eq!(tile(0, 1), [vec![1], vec![0, 2]]);
        assert_eq!(tile(1, 1), [vec![1], vec![0, 2]]);
        assert!(chunk.is_empty(grid.tile(2, 2)) && !chunk.is_empty(grid.tile(0, 0)));
    }
}
