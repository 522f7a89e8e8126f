//! `chladni-bench gallery`: how much the twelve caricatures of a gallery differ, beside twelve random ones.

use std::sync::Arc;
use std::time::Instant;

use chladni_caricature::{DEFAULT_HARMONICS, GALLERY_SIZE, Portrait, Sitter, Stack, VariantGallery};
use chladni_harmonics::Laplacian;
use serde::Serialize;

use chladni_program::cli::Terminal;
use chladni_program::work::{Error, body, sitter, source};

/// Measure how much the caricatures of galleries differ, and how much they fold.
#[derive(clap::Args)]
pub struct BenchGallery {
    /// The shapes: mesh files or sample:NAME.
    #[arg(default_value = "sample:head")]
    shapes: Vec<String>,
    /// Galleries of each shape, of the seeds from 1 on.
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// The galleries of one shape.
#[derive(Serialize)]
struct Row {
    shape: String,
    vertices: usize,
    /// The least distance of two of twelve, the mean of all galleries: random ones, the first gallery, and their children.
    random: f64,
    first: f64,
    bred: f64,
    /// The largest share of triangles that any caricature folds.
    folded: f64,
    /// The mean distance that a vertex moves, as a share of the shape's size.
    moved: f64,
    /// Seconds until twelve children are there, the mean.
    secs: f64,
}

impl BenchGallery {
    /// Makes the galleries and prints a row for each shape.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let rows: Vec<Row> =
            self.shapes.iter().map(|shape| self.row(shape, terminal)).collect::<Result<_, _>>()?;
        if self.json {
            return terminal.json(&rows);
        }
        terminal.result(format_args!(
            "least distance of two of {GALLERY_SIZE} (0: the same but for their size)\n{:<28} {:>8} {:>8} {:>8} {:>8} {:>9} {:>7} {:>7}",
            "shape", "vertices", "random", "first", "bred", "folded %", "moved %", "s"
        ))?;
        rows.iter().try_for_each(|row| {
            terminal.result(format_args!(
                "{:<28} {:>8} {:>8.2} {:>8.2} {:>8.2} {:>9.2} {:>7.1} {:>7.1}",
                row.shape,
                row.vertices,
                row.random,
                row.first,
                row.bred,
                100.0 * row.folded,
                100.0 * row.moved,
                row.secs
            ))
        })
    }

    fn row(&self, shape: &str, terminal: &Terminal) -> Result<Row, Error> {
        let mesh = source::mesh(shape, terminal)?;
        let (body, _) = body::build(shape, &mesh, DEFAULT_HARMONICS, Laplacian::Delaunay, terminal)?;
        let mut stack = Stack::new(Arc::new(body))?;
        let sitter = sitter(&mesh, &mut stack, None, terminal)?;
        let rest = &stack.original().positions;
        let triangles = stack.body().triangles.len().max(1) as f64;
        let mut row = Row {
            shape: shape.rsplit('/').next().unwrap_or(shape).to_owned(),
            vertices: rest.len(),
            random: 0.0,
            first: 0.0,
            bred: 0.0,
            folded: 0.0,
            moved: 0.0,
            secs: 0.0,
        };
        let share = 1.0 / self.seeds.max(1) as f64;
        for seed in 1..=self.seeds {
            let random = drawn(&VariantGallery::random(seed, &sitter)?, &sitter)?;
            let mut gallery = VariantGallery::new(seed, &sitter)?;
            let first = drawn(&gallery, &sitter)?;
            [1, 4, 8].into_iter().try_for_each(|index| gallery.choose(index, true))?;
            let began = Instant::now();
            gallery.breed(&sitter)?;
            let bred = drawn(&gallery, &sitter)?;
            row.secs += share * began.elapsed().as_secs_f64();
            row.random += share * least_distance(rest, &random);
            row.first += share * least_distance(rest, &first);
            row.bred += share * least_distance(rest, &bred);
            for portrait in first.iter().chain(&bred) {
                row.folded = row.folded.max(portrait.folded as f64 / triangles);
                row.moved += share * portrait.moved / (first.len() + bred.len()) as f64;
            }
        }
        Ok(row)
    }
}

fn drawn(gallery: &VariantGallery, sitter: &Sitter) -> Result<Vec<Portrait>, Error> {
    Ok(sitter.portray(&gallery.variants())?)
}

/// The least mean distance of the vertices of two, each made as large as the other: as a share of what they move.
fn least_distance(rest: &[[f64; 3]], all: &[Portrait]) -> f64 {
    let length = |d: [f64; 3]| d[0].hypot(d[1]).hypot(d[2]);
    let moved = |portrait: &Portrait| -> Vec<[f64; 3]> {
        let by = portrait.positions.iter().zip(rest);
        let by: Vec<[f64; 3]> = by.map(|(p, x)| std::array::from_fn(|i| f64::from(p[i]) - x[i])).collect();
        let mean = by.iter().map(|d| length(*d)).sum::<f64>() / by.len().max(1) as f64;
        by.into_iter().map(|d| d.map(|c| c / mean.max(f64::MIN_POSITIVE))).collect()
    };
    let all: Vec<Vec<[f64; 3]>> = all.iter().map(moved).collect();
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let apart = |(i, j): (usize, usize)| {
        let both = all[i].iter().zip(&all[j]);
        both.map(|(a, b)| length([a[0] - b[0], a[1] - b[1], a[2] - b[2]])).sum::<f64>()
            / rest.len().max(1) as f64
    };
    pairs.map(apart).fold(f64::INFINITY, f64::min)
}
