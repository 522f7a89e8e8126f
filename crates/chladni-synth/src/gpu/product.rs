//! Generates the shader of the product for each shape of tile.

use crate::packed_basis::PANEL;

/// The sums that one thread keeps in registers: some columns of a few neighboring vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// A multiple of four.
    pub columns: usize,
    /// Two or four.
    vertices: usize,
}

/// Ascending by columns. Tiles with few columns have more vertices, which gives a thread enough work for
/// each value that it reads.
pub(super) const TILES: [Tile; 9] = [
    Tile { columns: 4, vertices: 4 },
    Tile { columns: 8, vertices: 4 },
    Tile { columns: 12, vertices: 4 },
    Tile { columns: 16, vertices: 2 },
    Tile { columns: 20, vertices: 2 },
    Tile { columns: 24, vertices: 2 },
    Tile { columns: 28, vertices: 2 },
    Tile { columns: 32, vertices: 2 },
    Tile { columns: 36, vertices: 2 },
];

/// Which tiles a [`GpuSynthesizer`](crate::GpuSynthesizer) uses for the product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tiles {
    /// Up to 12 columns, of four vertices each.
    Narrow,
    /// Also tiles with up to 36 columns, of two vertices each: the basis is read once for twelve items in
    /// vector form.
    Wide,
}

impl Tiles {
    /// The numbers of columns of the [`TILES`] in use.
    pub(super) fn widths(self) -> &'static [usize] {
        match self {
            Self::Narrow => &[4, 8, 12],
            Self::Wide => &[4, 8, 12, 16, 20, 24, 28, 32, 36],
        }
    }
}

/// The number of harmonics whose values are requested before the first is used; a multiple of four. The
/// memory of a graphics card has a high latency, which small shapes have too few threads to hide.
pub(super) const BATCH: usize = 8;

impl Tile {
    /// The number of threads that share a panel.
    pub fn threads_per_panel(&self) -> usize {
        PANEL / self.vertices
    }

    /// The source code of the shader. Sums are separate variables, because an array stays in registers only
    /// if the driver unrolls every loop over it.
    pub fn source(&self) -> String {
        let Self { columns, vertices } = *self;
        let (words, values) = if vertices == 2 { (PAIR, "vec2<f32>") } else { (QUAD, "vec4<f32>") };
        let constants = format!(
            "alias Values = {values};\n{words}\
             const VERTICES = {vertices}u;\nconst THREADS_PER_PANEL = {}u;\n\
             const WIDTH = {columns}u;\nconst BATCH = {BATCH}u;\n",
            self.threads_per_panel()
        );
        let load = each(BATCH / 4, |i| format!("let ks{i} = active_harmonics[i + {i}u];"))
            + &each(BATCH, |i| {
                let k = format!("ks{}.{}", i / 4, lane(i));
                format!("let words{i} = basis[line + {k} * THREADS_PER_PANEL];")
            });
        let add = each(BATCH, |i| {
            let weights = each(columns / 4, |j| {
                format!("let c{i}_{j} = coefficients[row + {}u];", i * columns / 4 + j)
            });
            let sums =
                each(columns, |c| format!("sum{c} = fma(h{i}, Values(c{i}_{}.{}), sum{c});", c / 4, lane(c)));
            format!("let h{i} = values(words{i});{weights}{sums}")
        });
        let template = include_str!("shaders/product.wgsl")
            .replace("{sums = 0}", &each(columns, |c| format!("var sum{c} = Values();")))
            .replace("{load the batch}", &load)
            .replace("{add the batch}", &add)
            .replace(
                "{store the sums}",
                &each(columns, |c| format!("columns[first + {c}u * stride] = sum{c};")),
            );
        constants + &template
    }
}

/// Two values of the basis in a word. They are 65536 times too large; the coefficients contain the
/// reciprocal.
const PAIR: &str = "alias Words = i32;
fn values(words: Words) -> Values {
    return Values(vec2<i32>(words << 16u, words & -65536));
}
";

/// Four values in two words.
const QUAD: &str = "alias Words = vec2<i32>;
fn values(words: Words) -> Values {
    let low = words << vec2<u32>(16u);
    let high = words & vec2<i32>(-65536);
    return Values(vec4<i32>(low.x, high.x, low.y, high.y));
}
";

fn each(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(|i| line(i) + "\n").collect()
}

fn lane(index: usize) -> char {
    ['x', 'y', 'z', 'w'][index % 4]
}
