//! The output and files of a command, summarized in few numbers.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::archive;

/// Numbers and texts by where they were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    entries: BTreeMap<String, Value>,
}

/// Cells of the grid that a picture is averaged in.
const GRID: [u32; 2] = [8, 6];
/// Colors may differ by so much, of 255: edges are smoothed differently by different devices.
const COLOR_TOLERANCE: f64 = 6.0;
/// All other numbers by this share of the larger one.
const TOLERANCE: f64 = 2e-4;
/// What is smaller, or has this root mean square, may be rounding errors.
const NOISE: f64 = 1e-9;
/// Samples kept of a long list.
const SAMPLES: usize = 8;
/// Lines of text that begin like this: times, the machine, and a count that rounding moves by one.
const VOLATILE_LINES: [&str; 3] = ["seconds ", "no graphics card: ", "strongly stretched "];

/// The names under which something is recorded in `folder`.
pub fn recorded_names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    files.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect()
}

impl Summary {
    pub fn number(&mut self, key: &str, value: f64) {
        // Rounded, so that a record stays legible and does not change where it is made again.
        let rounded = if value == 0.0 { 0.0 } else { format!("{value:.6e}").parse().unwrap() };
        self.entries.insert(key.into(), Value::from(rounded));
    }

    fn text(&mut self, key: &str, value: impl Into<String>) {
        self.entries.insert(key.into(), Value::from(value.into()));
    }

    /// JSON leaf by leaf, anything else line by line; what takes time is left out.
    pub fn printed(&mut self, key: &str, text: &str) {
        match serde_json::from_str::<Value>(text) {
            Ok(value) if value.is_object() || value.is_array() => self.json(key, &value),
            _ => self.lines(key, text),
        }
    }

    fn json(&mut self, key: &str, value: &Value) {
        match value {
            Value::Object(fields) => {
                for (name, value) in fields.iter().filter(|(name, _)| !is_volatile(name)) {
                    self.json(&format!("{key}.{name}"), value);
                }
            }
            Value::Array(items) if items.iter().all(Value::is_number) => {
                let numbers: Vec<f64> = items.iter().filter_map(Value::as_f64).collect();
                self.numbers(key, &numbers);
            }
            Value::Array(items) => {
                self.number(&format!("{key}: items"), items.len() as f64);
                let kept = SAMPLES.min(items.len());
                for at in (0..kept).map(|i| i * items.len() / kept) {
                    self.json(&format!("{key}[{at}]"), &items[at]);
                }
            }
            Value::Number(number) => self.number(key, number.as_f64().unwrap_or(f64::NAN)),
            other => self.text(key, other.to_string()),
        }
    }

    /// Words and numbers of each line, the numbers apart.
    fn lines(&mut self, key: &str, text: &str) {
        for (i, line) in text.lines().enumerate().filter_map(|(i, line)| Some((i, lasting(line)?))) {
            let mut words = Vec::new();
            let mut count = 0;
            for word in line.split_whitespace() {
                match word.trim_matches(',').parse::<f64>() {
                    Ok(number) => {
                        self.number(&format!("{key}, line {i}, number {count}"), number);
                        count += 1;
                        words.push("#");
                    }
                    Err(_) => words.push(word),
                }
            }
            self.text(&format!("{key}, line {i}"), words.join(" "));
        }
    }

    fn numbers(&mut self, key: &str, numbers: &[f64]) {
        let size = (numbers.iter().map(|x| x * x).sum::<f64>() / numbers.len().max(1) as f64).sqrt();
        self.number(&format!("{key}: count"), numbers.len() as f64);
        self.number(&format!("{key}: root mean square"), size);
        // Zeros and rounding errors say little: from each place on, the next value that is not small beside the others.
        let is_large = |at: &usize| size > NOISE && numbers[*at].abs() >= 0.5 * size;
        let Some(first) = (0..numbers.len()).find(is_large) else { return };
        let rest = numbers.len() - first;
        for i in 0..SAMPLES.min(rest) {
            // Not in step with rows of a round number.
            let from = first + (i * rest / SAMPLES + 17 * i) % rest;
            if let Some(at) = (from..numbers.len()).chain(first..from).find(is_large) {
                self.number(&format!("{key}[{at}]"), numbers[at]);
            }
        }
    }

    /// Every file below `folder`.
    pub fn files(&mut self, folder: &Path) {
        let mut pending = vec![folder.to_owned()];
        while let Some(next) = pending.pop() {
            for entry in std::fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    pending.push(path);
                } else {
                    let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                    self.file(&name, &path);
                }
            }
        }
    }

    /// One file, by what it holds.
    pub fn file(&mut self, name: &str, path: &Path) {
        match path.extension().and_then(|extension| extension.to_str()).unwrap_or_default() {
            "obj" | "ply" | "stl" | "glb" => self.mesh(name, path),
            "npz" => {
                let mut names = archive::names(path);
                names.sort();
                self.text(name, names.join(" "));
                for array in names {
                    if let Some(read) = archive::array(path, &array) {
                        self.text(&format!("{name}/{array}: shape"), format!("{:?}", read.shape));
                        self.numbers(&format!("{name}/{array}"), &read.values);
                    }
                }
            }
            "png" => self.picture(name, path),
            "wav" | "mp4" | "gif" => self.number(&format!("{name}: is there"), 1.0),
            _ => match std::fs::read_to_string(path) {
                Ok(text) => self.printed(name, &text),
                Err(_) => self.text(name, "no text"),
            },
        }
    }

    fn mesh(&mut self, name: &str, path: &Path) {
        let mesh = chladni_mesh::load_mesh(path).unwrap().mesh;
        self.number(&format!("{name}: triangles"), mesh.triangles.len() as f64);
        let flat: Vec<f64> = mesh.positions.iter().flatten().copied().collect();
        self.numbers(&format!("{name}: coordinates"), &flat);
    }

    fn picture(&mut self, name: &str, path: &Path) {
        let picture = chladni_view::Picture::decode(&std::fs::read(path).unwrap()).unwrap();
        let (width, height) = (picture.width, picture.height);
        self.text(&format!("{name}: size"), format!("{width}×{height}"));
        for row in 0..GRID[1] {
            for column in 0..GRID[0] {
                let (x, y) = (span(column, GRID[0], width), span(row, GRID[1], height));
                let mut sum = [0.0; 3];
                let pixels = (x.len() * y.len()).max(1) as f64;
                for at in y.flat_map(|y| x.clone().map(move |x| 4 * (y * width + x) as usize)) {
                    for (sum, value) in sum.iter_mut().zip(&picture.rgba[at..at + 3]) {
                        *sum += f64::from(*value) / pixels;
                    }
                }
                for (sum, channel) in sum.into_iter().zip(["red", "green", "blue"]) {
                    self.number(&format!("{name}: {channel} of cell {column}, {row}"), sum.round());
                }
            }
        }
    }

    /// The first entries that are not those recorded in `folder` under `name`; records them instead where
    /// `CHLADNI_RECORD` is set.
    pub fn differs_from_record(&self, folder: &Path, name: &str) -> Vec<String> {
        let path = folder.join(format!("{name}.json"));
        if std::env::var_os("CHLADNI_RECORD").is_some() {
            std::fs::write(&path, serde_json::to_string_pretty(&self.entries).unwrap() + "\n").unwrap();
            return Vec::new();
        }
        let Ok(text) = std::fs::read_to_string(&path) else {
            return vec![format!("{name}: was never recorded")];
        };
        let recorded = Self { entries: serde_json::from_str(&text).unwrap() };
        recorded.differences(self).iter().take(5).map(|line| format!("{name}: {line}")).collect()
    }

    /// The entries that differ in `now`, one per line.
    pub fn differences(&self, now: &Self) -> Vec<String> {
        let mut lines = Vec::new();
        for (key, before) in &self.entries {
            match now.entries.get(key) {
                None => lines.push(format!("{key}: was {before}, is missing")),
                Some(after) if !is_alike(key, before, after) => {
                    lines.push(format!("{key}: was {before}, is {after}"));
                }
                Some(_) => {}
            }
        }
        let new = now.entries.keys().filter(|key| !self.entries.contains_key(*key));
        lines.extend(new.map(|key| format!("{key}: is new")));
        lines
    }
}

fn span(cell: u32, cells: u32, length: u32) -> std::ops::Range<u32> {
    let size = (length / cells).max(1);
    (cell * size).min(length)..((cell + 1) * size).min(length)
}

fn is_alike(key: &str, before: &Value, after: &Value) -> bool {
    match (before.as_f64(), after.as_f64()) {
        (Some(a), Some(b)) => {
            let relative = || TOLERANCE * a.abs().max(b.abs()).max(NOISE);
            (a - b).abs() <= if key.contains(" of cell ") { COLOR_TOLERANCE } else { relative() }
        }
        _ => before == after,
    }
}

/// Fields with times and what depends on the machine, such as counts that rounding moves by one.
fn is_volatile(name: &str) -> bool {
    ["seconds", "certificate", "residual", "orthogonality", "threads", "device", "error", "strongly"]
        .iter()
        .any(|word| name.contains(word))
}

/// The beginning of a line of text that is the same on every machine.
fn lasting(line: &str) -> Option<&str> {
    if VOLATILE_LINES.iter().any(|start| line.starts_with(start)) || line.contains(" threads are used: ") {
        return None;
    }
    // Up to how long it took, or to the system's own words.
    let took = line.match_indices(" in ").map(|(at, _)| at).find(|at| begins_with_seconds(&line[at + 4..]));
    let system = || if line.contains(" (os error ") { line.rfind(": ") } else { None };
    Some(&line[..took.or_else(system).unwrap_or(line.len())])
}

/// Whether it is like "0.43 s; residual 6e-11".
fn begins_with_seconds(text: &str) -> bool {
    text.split_once(" s")
        .is_some_and(|(number, rest)| number.parse::<f64>().is_ok() && !rest.starts_with(char::is_alphabetic))
}
