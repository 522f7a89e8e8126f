//! The dense part of the factorization: eliminates the first columns of one front.

use crate::simd::Lanes;

/// The number of columns eliminated at a time, which is also the number of columns of an update tile: two
/// vectors.
pub(super) const TILE: usize = 16;
/// The number of rows of an update tile.
const TALL: usize = 8;

/// A pivot so small that, in f64, the shift is indistinguishable from an eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ZeroPivot;

/// The distance between the rows of a front of `size` rows, and the number of rows to allocate.
pub(super) fn stride(size: usize) -> usize {
    size.next_multiple_of(TILE)
}

/// Eliminates the first `width` columns of the symmetric front `f` (row-major, lower triangle, rows
/// [`stride`] apart). Afterwards column k < width holds L below the diagonal, `pivots[k]` = D_kk, and the
/// rest of the front holds its Schur complement. Within each [`TILE`] of columns the largest diagonal value
/// is eliminated first, which keeps L from growing if a shift inside the spectrum makes a pivot small:
/// position k is column `order[k]` of the front. Values above the diagonal or beyond `size` are
/// meaningless. `packed` is scratch memory of `stride · width` values.
#[inline(always)]
pub(super) fn eliminate<L: Lanes>(
    lanes: L,
    f: &mut [f64],
    size: usize,
    width: usize,
    pivots: &mut [f64],
    order: &mut [u32],
    packed: &mut [f64],
    smallest: f64,
) -> Result<(), ZeroPivot> {
    let ld = stride(size);
    let mut k0 = 0;
    while k0 < width {
        let k1 = (k0 + TILE).min(width);
        let block = eliminate_diagonal_block(lanes, f, ld, k0, k1, pivots, smallest)?;
        for (k, &from) in block.order[..k1 - k0].iter().enumerate() {
            order[k0 + k] = (k0 + from) as u32;
        }
        for tile in k1 / TILE..ld / TILE {
            solve_rows_below(
                lanes,
                f,
                ld,
                tile,
                size,
                (k0, k1),
                &block,
                pivots,
                &mut packed[tile * width * TILE..],
            );
        }
        // The columns that remain to be eliminated.
        if k1 < width {
            update(lanes, f, ld, size, (k1, width), (k0, k1), width, packed);
        }
        k0 = k1;
    }
    if width < size {
        update(lanes, f, ld, size, (width, size), (0, width), width, packed);
    }
    Ok(())
}

/// An eliminated diagonal block.
struct Eliminated {
    /// The block's L, in elimination order.
    lower: [[f64; TILE]; TILE],
    /// For each position, the eliminated column of the block.
    order: [usize; TILE],
}

/// L D Lᵀ of the block [k0, k1)², in place.
#[inline(always)]
fn eliminate_diagonal_block<L: Lanes>(
    lanes: L,
    f: &mut [f64],
    ld: usize,
    k0: usize,
    k1: usize,
    pivots: &mut [f64],
    smallest: f64,
) -> Result<Eliminated, ZeroPivot> {
    let kb = k1 - k0;
    let mut block = [[[0.0_f64; 8]; 2]; TILE];
    let mut lower = [[0.0_f64; TILE]; TILE];
    let mut order: [usize; TILE] = std::array::from_fn(|k| k);
    // Mirrored: the update of a row then runs over contiguous columns.
    for i in 0..kb {
        for j in 0..=i {
            let value = f[(k0 + i) * ld + k0 + j];
            block[i][j / 8][j % 8] = value;
            block[j][i / 8][i % 8] = value;
        }
    }
    for k in 0..kb {
        let mut largest = k;
        for i in k + 1..kb {
            if block[i][i / 8][i % 8].abs() > 1.5 * block[largest][largest / 8][largest % 8].abs() {
                largest = i;
            }
        }
        if largest != k {
            order.swap(k, largest);
            lower.swap(k, largest);
            block.swap(k, largest);
            for row in &mut block {
                let kept = row[k / 8][k % 8];
                row[k / 8][k % 8] = row[largest / 8][largest % 8];
                row[largest / 8][largest % 8] = kept;
            }
            // The same two rows of L in the earlier blocks.
            let (upper, low) = f.split_at_mut((k0 + largest) * ld);
            upper[(k0 + k) * ld..(k0 + k) * ld + k0].swap_with_slice(&mut low[..k0]);
        }
        let pivot = block[k][k / 8][k % 8];
        if pivot.is_nan() || pivot.abs() <= smallest {
            return Err(ZeroPivot);
        }
        pivots[k0 + k] = pivot;
        let inverse = 1.0 / pivot;
        let source = [lanes.load(&block[k][0]), lanes.load(&block[k][1])];
        for i in k + 1..kb {
            let l = block[k][i / 8][i % 8] * inverse;
            let l_lanes = lanes.splat(l);
            for half in 0..2 {
                let row = &mut block[i][half];
                let value = lanes.mul_sub_from(l_lanes, source[half], lanes.load(row));
                lanes.store(value, row);
            }
            lower[i][k] = l;
        }
    }
    for i in 1..kb {
        f[(k0 + i) * ld + k0..(k0 + i) * ld + k0 + i].copy_from_slice(&lower[i][..i]);
    }
    Ok(Eliminated { lower, order })
}

/// L for one tile of rows below the block `ks`², and its product D Lᵀ, packed column by column.
#[inline(always)]
fn solve_rows_below<L: Lanes>(
    lanes: L,
    f: &mut [f64],
    ld: usize,
    tile: usize,
    size: usize,
    (k0, k1): (usize, usize),
    block: &Eliminated,
    pivots: &[f64],
    packed: &mut [f64],
) {
    let kb = k1 - k0;
    let first = tile * TILE;
    for half in 0..2 {
        let row = first + 8 * half;
        if row + 8 <= k1 || row >= size {
            continue;
        }
        let mut y = [lanes.splat(0.0); TILE];
        for part in 0..kb.div_ceil(8) {
            let rows = std::array::from_fn(|r| lanes.load(eight(&f[(row + r) * ld + k0 + 8 * part..])));
            y[8 * part..8 * part + 8].copy_from_slice(&lanes.transpose(rows));
        }
        let unordered = y;
        for k in 0..kb {
            y[k] = unordered[block.order[k]];
        }
        for k in 1..kb {
            let mut sum = y[k];
            for j in 0..k {
                sum = lanes.mul_sub_from(lanes.splat(block.lower[k][j]), y[j], sum);
            }
            y[k] = sum;
        }
        for k in 0..kb {
            lanes.store(y[k], eight_mut(&mut packed[(k0 + k) * TILE + 8 * half..]));
            y[k] = lanes.mul(y[k], lanes.splat(1.0 / pivots[k0 + k]));
        }
        for part in 0..kb.div_ceil(8) {
            let columns = std::array::from_fn(|k| y[8 * part + k]);
            let rows = lanes.transpose(columns);
            let valid = (kb - 8 * part).min(8);
            for r in 0..8 {
                if row + r < k1 || row + r >= size {
                    continue;
                }
                let target = &mut f[(row + r) * ld + k0 + 8 * part..];
                if valid == 8 {
                    lanes.store(rows[r], eight_mut(target));
                } else {
                    let mut values = [0.0; 8];
                    lanes.store(rows[r], &mut values);
                    target[..valid].copy_from_slice(&values[..valid]);
                }
            }
        }
    }
}

#[inline(always)]
fn eight(x: &[f64]) -> &[f64; 8] {
    x.first_chunk().expect("rows are padded to whole tiles")
}

#[inline(always)]
fn eight_mut(x: &mut [f64]) -> &mut [f64; 8] {
    x.first_chunk_mut().expect("rows are padded to whole tiles")
}

/// F[i, j] −= Σ_{k in ks} L[i, k] D_k L[j, k] for j in `columns` and i ≥ j from the first of them.
#[inline(always)]
fn update<L: Lanes>(
    lanes: L,
    f: &mut [f64],
    ld: usize,
    size: usize,
    columns: (usize, usize),
    ks: (usize, usize),
    width: usize,
    packed: &[f64],
) {
    for tile in columns.0 / TILE..columns.1.div_ceil(TILE) {
        let j0 = tile * TILE;
        let valid = (columns.0.max(j0) - j0, columns.1.min(j0 + TILE) - j0);
        // Beyond the last row, only meaningless values are overwritten.
        let valid = if j0 + TILE >= size && valid.1 == size - j0 { (valid.0, TILE) } else { valid };
        let p = packed[(tile * width + ks.0) * TILE..(tile * width + ks.1) * TILE]
            .as_chunks::<8>()
            .0
            .as_chunks::<2>()
            .0;
        let mut i = columns.0.max(j0);
        while i + TALL <= size {
            update_tile::<L, TALL>(lanes, f, ld, i, j0, valid, ks.0, p);
            i += TALL;
        }
        while i + 2 <= size {
            update_tile::<L, 2>(lanes, f, ld, i, j0, valid, ks.0, p);
            i += 2;
        }
        if i < size {
            update_tile::<L, 1>(lanes, f, ld, i, j0, valid, ks.0, p);
        }
    }
}

#[inline(always)]
fn update_tile<L: Lanes, const R: usize>(
    lanes: L,
    f: &mut [f64],
    ld: usize,
    i: usize,
    j0: usize,
    valid: (usize, usize),
    k0: usize,
    p: &[[[f64; 8]; 2]],
) {
    let mut sum = [[lanes.splat(0.0); 2]; R];
    {
        let l: [&[f64]; R] = std::array::from_fn(|r| &f[(i + r) * ld + k0..][..p.len()]);
        for (k, p) in p.iter().enumerate() {
            let p = [lanes.load(&p[0]), lanes.load(&p[1])];
            for r in 0..R {
                let l = lanes.splat(l[r][k]);
                sum[r][0] = lanes.mul_add(l, p[0], sum[r][0]);
                sum[r][1] = lanes.mul_add(l, p[1], sum[r][1]);
            }
        }
    }
    for r in 0..R {
        let row = &mut f[(i + r) * ld + j0..(i + r) * ld + j0 + TILE];
        let (low, high) = row.split_at_mut(8);
        if valid == (0, TILE) {
            let (low, high) = (eight_mut(low), eight_mut(high));
            lanes.store(lanes.sub(lanes.load(low), sum[r][0]), low);
            lanes.store(lanes.sub(lanes.load(high), sum[r][1]), high);
        } else {
            let mut values = [[0.0; 8]; 2];
            lanes.store(sum[r][0], &mut values[0]);
            lanes.store(sum[r][1], &mut values[1]);
            for lane in valid.0..valid.1 {
                row[lane] -= values[lane / 8][lane % 8];
            }
        }
    }
}
