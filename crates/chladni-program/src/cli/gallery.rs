//! `chladni caricature SHAPE --gallery`: twelve caricatures on a sheet, bred by their numbers.

use std::path::Path;
use std::str::FromStr;

use chladni_caricature::{
    GALLERY_SIZE, Group, Layer, Portrait as Drawn, Sitter, Variant, VariantGallery, surprise,
};
use chladni_task::write_atomic;
use chladni_view::{Camera, Picture};

use super::Terminal;
use super::sheet::{self, Portrayed};
use crate::work::Error;

/// Which caricatures of the gallery.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct GalleryOptions {
    /// Draw twelve caricatures that differ, numbered, on a sheet (-o sheet.png); TEMPLATE may be left out. --seed makes
    /// others.
    #[arg(long, conflicts_with_all = ["recipe", "render", "part", "limb", "mask", "region"])]
    pub gallery: bool,
    /// Breed on from these of the sheet, such as 3,7; once more from those of the next sheet.
    #[arg(long, value_name = "N,N…", requires = "gallery")]
    choose: Vec<Chosen>,
    /// Breed without changing these: strength, model, scales, parts, templates.
    #[arg(long, value_name = "GROUP", requires = "gallery", value_delimiter = ',')]
    lock: Vec<Group>,
    /// Write this one as a mesh (-o out.glb) in place of the sheet.
    #[arg(long, value_name = "N", requires = "gallery", value_parser = number)]
    variant: Option<usize>,
    /// Write a random good one as a mesh.
    #[arg(long, requires = "gallery", conflicts_with_all = ["variant", "choose"])]
    surprise: bool,
}

/// Numbers on the sheet, from 1.
#[derive(Clone, Debug)]
struct Chosen(Vec<usize>);

impl FromStr for Chosen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split(',').map(|one| number(one.trim())).collect::<Result<_, _>>().map(Self)
    }
}

fn number(text: &str) -> Result<usize, String> {
    let parsed = text.parse().ok().filter(|n| (1..=GALLERY_SIZE).contains(n));
    parsed.ok_or_else(|| format!("must be a number from 1 to {GALLERY_SIZE}"))
}

impl GalleryOptions {
    /// Whether a single caricature is asked for, as a mesh.
    pub fn is_single(&self) -> bool {
        self.surprise || self.variant.is_some()
    }

    /// The layers of the one that is asked for.
    ///
    /// # Errors
    /// What the gallery refuses.
    pub fn single(&self, sitter: &Sitter, seed: u64, terminal: &Terminal) -> Result<Vec<Layer>, Error> {
        let (variant, drawn) = match self.variant {
            None => surprise(seed, sitter)?,
            Some(number) => {
                let gallery = self.bred(sitter, seed)?;
                let variant = gallery.variants()[number - 1].clone();
                let mut drawn = sitter.portray(&[&variant])?;
                (variant, drawn.remove(0))
            }
        };
        terminal.result(format_args!("{}", described(sitter, &variant, &drawn)))?;
        Ok(drawn.layers)
    }

    /// Draws all twelve and prints what each is.
    ///
    /// # Errors
    /// What the gallery or the renderer refuses.
    pub fn sheet(
        &self,
        sitter: &Sitter,
        seed: u64,
        (camera, size): (Camera, [u32; 2]),
        path: &Path,
        terminal: &Terminal,
    ) -> Result<(), Error> {
        let gallery = self.bred(sitter, seed)?;
        let variants = gallery.variants();
        let drawn = sitter.portray(&variants)?;
        for (number, (variant, drawn)) in (1..).zip(variants.iter().zip(&drawn)) {
            terminal.result(format_args!("{number:>2}  {}", described(sitter, variant, drawn)))?;
        }
        let all: Vec<Portrayed> = drawn.into_iter().map(|drawn| Portrayed::of(drawn.positions)).collect();
        let mut all = all.into_iter();
        let rows: Vec<Vec<Portrayed>> = std::iter::from_fn(|| {
            Some(all.by_ref().take(COLUMNS).collect::<Vec<_>>()).filter(|row| !row.is_empty())
        })
        .collect();
        let mut picture = sheet::draw(&terminal.device()?, &rows, &sitter.body().triangles, camera, size)?;
        let cell = [size[0] / COLUMNS as u32, size[1] / (GALLERY_SIZE / COLUMNS) as u32];
        for place in 0..GALLERY_SIZE as u32 {
            let at = [place % COLUMNS as u32 * cell[0], place / COLUMNS as u32 * cell[1]];
            write_number(&mut picture, place + 1, at, (cell[1] / 70).max(2));
        }
        write_atomic(path, &picture.to_png()?).map_err(|error| Error::unwritten(path, error))
    }

    /// The gallery after all that was chosen.
    fn bred(&self, sitter: &Sitter, seed: u64) -> Result<VariantGallery, Error> {
        let mut gallery = VariantGallery::new(seed, sitter)?;
        self.lock.iter().for_each(|group| gallery.lock(*group, true));
        for Chosen(chosen) in &self.choose {
            chosen.iter().try_for_each(|number| gallery.choose(number - 1, true))?;
            gallery.breed(sitter)?;
        }
        Ok(gallery)
    }
}

/// Cells beside each other.
const COLUMNS: usize = 4;

fn described(sitter: &Sitter, variant: &Variant, drawn: &Drawn) -> String {
    let held = if drawn.kept < 0.995 {
        format!(", {:.0} % of its strength", 100.0 * drawn.kept)
    } else {
        String::new()
    };
    let mu = drawn.layers.first().map_or(0.0, |layer| layer.mu);
    format!("{}, μ = {mu:.2}{held}, {} triangles folded", sitter.title(variant), drawn.folded)
}

/// Digits of three by five dots, a row each, the highest bit at the left.
const DIGITS: [[u8; 5]; 10] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 3, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 2, 2],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
];

/// Writes a number in the upper left corner of the cell at `at`, each dot `dot` pixels wide.
fn write_number(picture: &mut Picture, number: u32, at: [u32; 2], dot: u32) {
    let digits = number.to_string();
    let black = Picture::filled(dot, dot, [60, 60, 66, 255]);
    for (place, digit) in (0..).zip(digits.bytes()) {
        let Some(rows) = DIGITS.get(usize::from(digit.wrapping_sub(b'0'))) else { continue };
        for (y, row) in (0..).zip(rows) {
            for x in (0..3).filter(|x| row >> (2 - x) & 1 == 1) {
                picture.paste(&black, at[0] + (2 + 4 * place + x) * dot, at[1] + (2 + y) * dot);
            }
        }
    }
}
