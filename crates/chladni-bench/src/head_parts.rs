//! `chladni-bench head-parts`: how well the named parts of heads are found whose parts are known, and whether confidence
//! says so.

use chladni_caricature::HeadParts;
use chladni_mesh::TriMesh;
use chladni_mesh::samples::{HEAD_PARTS, head_parts, sample};
use chladni_mesh::surface::vertex_areas;

use super::limbs::{overlap, shared_areas};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Watcher};

/// Measure how well the named parts of heads are found whose parts are known, and whether confidence says so.
#[derive(clap::Args)]
pub struct BenchHeadParts {
    /// The heads: `head`, or `portrait` with sliders.
    #[arg(default_values = [
        "head", "portrait", "portrait?age=-1.00", "portrait?age=1.00",
        "portrait?width=0.90,cheeks=0.50,jaw=0.80,neck=0.80", "portrait?width=-0.90,length=0.60,jaw=-0.60",
        "portrait?brow=-0.60,eyes=0.50,nose=-0.50,lips=0.60,jaw=-0.70,neck=-0.60",
        "portrait?brow=0.90,nose=0.60,bridge=0.80,jaw=0.90,chin=0.70",
    ])]
    heads: Vec<String>,
    /// Heads that are bent in a way that no slider bends one.
    #[arg(long, value_delimiter = ';', default_values = ["head", "portrait?age=-0.50"])]
    bent: Vec<String>,
    /// Samples that are no heads.
    #[arg(long, value_delimiter = ';', default_values = ["cat", "octopus"])]
    others: Vec<String>,
}

impl BenchHeadParts {
    /// Prints a row of a Markdown table for each head: for each part, intersection over union by area and confidence;
    /// then one for each shape that is no head; then the rank correlation of the two.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let mut pairs = Vec::new();
        let heads = self.heads.iter().map(|name| (name, false));
        for (name, is_bent) in heads.chain(self.bent.iter().map(|name| (name, true))) {
            let missing = || Error::input(format!("sample:{name} has no known parts"));
            let mesh = sample(name).ok_or_else(missing)?;
            let known = head_parts(name, &mesh.positions).ok_or_else(missing)?;
            let mesh = if is_bent { bent(mesh) } else { mesh };
            let found = found(&mesh, terminal)?;
            let overlaps = overlaps(&mesh, &found.part, &known);
            let sure = confidence(&found);
            pairs.extend(overlaps.iter().copied().zip(sure.iter().copied()));
            let cells = overlaps.iter().zip(&sure).map(|(overlap, sure)| format!("{overlap:.2} {sure:.2}"));
            let cells: Vec<String> = cells.collect();
            let change = if is_bent { ", bent" } else { "" };
            let (mean, sure) = (mean(&overlaps), mean(&sure));
            terminal
                .result(format_args!("| `{name}`{change} | {} | {mean:.2} {sure:.2} |", cells.join(" | ")))?;
        }
        for name in &self.others {
            let mesh = sample(name).ok_or_else(|| Error::input(format!("there is no sample:{name}")))?;
            let sure = confidence(&found(&mesh, terminal)?);
            let cells: Vec<String> = sure.iter().map(|sure| format!("– {sure:.2}")).collect();
            let sure = mean(&sure);
            terminal.result(format_args!("| `{name}`, no head | {} | – {sure:.2} |", cells.join(" | ")))?;
        }
        let (count, correlation) = (pairs.len(), rank_correlation(&pairs));
        terminal.result(format_args!(
            "\nRank correlation (Spearman) of intersection over union and confidence over these {count} parts: {correlation:.2}."
        ))
    }
}

fn found(mesh: &TriMesh, terminal: &Terminal) -> Result<HeadParts, Error> {
    let found = terminal.watch("parts", |task| HeadParts::of(mesh, task));
    found.map_err(|why| Error::other(why.to_string()))
}

fn overlaps(mesh: &TriMesh, found: &[u8], known: &[u8]) -> Vec<f64> {
    let areas = vertex_areas(&mesh.positions, &mesh.triangles);
    let [found, known]: [Vec<u32>; 2] =
        [found, known].map(|parts| parts.iter().copied().map(u32::from).collect());
    let count = HEAD_PARTS.len();
    let shared = shared_areas(&found, count, &known, count, &areas);
    (0..count).map(|part| overlap(&shared, part, part)).collect()
}

/// Of each part; 0 where it was not found.
fn confidence(found: &HeadParts) -> Vec<f64> {
    (0..HEAD_PARTS.len()).map(|part| found.extent(part).1.unwrap_or(0.0)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Moves each point by waves whose lengths are about that of the head, each coordinate by up to an eighth of half its
/// height. The two sides are not alike afterward.
fn bent(mut mesh: TriMesh) -> TriMesh {
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let wave = |a: f64, b: f64, c: f64, shift: f64| (a * x + b * y + c * z + shift).sin();
        let by = [
            wave(2.1, -1.3, 0.7, 0.4) + wave(-0.9, 2.6, 1.8, 2.0) + wave(1.2, 0.8, -2.4, 4.1),
            wave(-1.6, 1.1, 2.2, 1.3) + wave(2.5, 0.6, -1.1, 3.2) + wave(0.5, -2.0, 1.4, 5.0),
            wave(1.8, 2.3, -0.4, 2.7) + wave(-2.2, 0.9, 1.5, 0.9) + wave(0.7, 1.9, 2.0, 3.8),
        ];
        *p = [x + 0.04 * by[0], y + 0.04 * by[1], z + 0.04 * by[2]];
    }
    mesh
}

/// Spearman's: the correlation of ranks.
fn rank_correlation(pairs: &[(f64, f64)]) -> f64 {
    let ranks = |value: fn(&(f64, f64)) -> f64| {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| value(&pairs[*a]).total_cmp(&value(&pairs[*b])));
        let mut ranks = vec![0.0; pairs.len()];
        let mut first = 0;
        for tied in order.chunk_by(|a, b| value(&pairs[*a]) == value(&pairs[*b])) {
            // Those that are equal share the mean of their ranks.
            let mean = first as f64 + (tied.len() as f64 - 1.0) / 2.0;
            tied.iter().for_each(|i| ranks[*i] = mean);
            first += tied.len();
        }
        ranks
    };
    let (a, b) = (ranks(|pair| pair.0), ranks(|pair| pair.1));
    let middle = (pairs.len() as f64 - 1.0) / 2.0;
    let product =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - middle) * (b - middle)).sum::<f64>();
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_share_a_rank() {
        // Whatever their order, ties say nothing: ranks 0.5, 0.5, 2, 3 beside 0, 1, 2, 3.
        let (a, b) = ([(1.0, 1.0), (1.0, 2.0)], [(2.0, 3.0), (3.0, 4.0)]);
        let forward = rank_correlation(&[a[0], a[1], b[0], b[1]]);
        assert!((forward - 0.948_683_298).abs() < 1e-9, "{forward}");
        assert_eq!(forward, rank_correlation(&[a[1], a[0], b[0], b[1]]));
    }
}
