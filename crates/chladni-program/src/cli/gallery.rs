//! `chladni caricature SHAPE --gallery`: twelve caricatures on a sheet, bred by their numbers.

use std::path::Path;
use std::str::FromStr;

use chladni_caricature::{
    GALLERY_SIZE, Group, Layer, Portrait as Drawn, Sitter, Variant, VariantGallery, surprise,
};
use chladni_task::{Task, counted};
use chladni_view::{Camera, layout};

use super::Terminal;
use super::number::number;
use super::sheet::{self, Portrayed};
use crate::work::{Error, Lettering, Watcher, write_file};

/// Which caricatures of the gallery.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct GalleryOptions {
    /// Draw twelve caricatures that differ, numbered, on a sheet (-o sheet.png); TEMPLATE may be left out. --seed
    /// makes others: here it is the gallery's own [default: 1, as in the window].
    // Clap waives what an option requires where that conflicts with what is given: such options are named, too.
    #[arg(long, conflicts_with_all = ["recipe", "render", "show", "sweep", "turntable", "turn_secs", "resume",
        "piece", "RegionOptions", "model", "mu", "strength", "cutoff", "roll_off", "no_clamp", "scale_curve",
        "infill"])]
    pub gallery: bool,
    /// With --gallery: breed on from these of the sheet, such as 3,7; once more from those of the next sheet.
    #[arg(long, value_name = "N,N…")]
    choose: Vec<Chosen>,
    /// Breed without changing these: strength, model, scales, parts, templates.
    #[arg(
        long,
        value_name = "GROUP",
        requires = "choose",
        conflicts_with = "surprise",
        value_delimiter = ','
    )]
    lock: Vec<Group>,
    /// With --gallery: write this one as a mesh (-o out.glb) in place of the sheet.
    #[arg(long, value_name = "N", value_parser = of_sheet)]
    variant: Option<usize>,
    /// With --gallery: write a random good one as a mesh.
    #[arg(long, conflicts_with_all = ["variant", "choose"])]
    surprise: bool,
}

/// Numbers on the sheet, from 1.
#[derive(Clone, Debug)]
struct Chosen(Vec<usize>);

impl FromStr for Chosen {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        text.split(',').map(|one| of_sheet(one.trim())).collect::<Result<_, _>>().map(Self)
    }
}

fn of_sheet(text: &str) -> Result<usize, Error> {
    number(text, |n| (1..=GALLERY_SIZE).contains(n), format_args!("a number from 1 to {GALLERY_SIZE}"))
}

impl GalleryOptions {
    /// Whether a single caricature is asked for, as a mesh.
    pub fn is_single(&self) -> bool {
        self.surprise || self.variant.is_some()
    }

    /// Whether one of its options is given without the gallery.
    pub fn is_missing(&self) -> bool {
        !self.gallery && (self.is_single() || !self.choose.is_empty())
    }

    /// The layers of the one that is asked for.
    ///
    /// # Errors
    /// Errors of the gallery.
    pub fn single(&self, sitter: &Sitter, seed: u64, terminal: &Terminal) -> Result<Vec<Layer>, Error> {
        let (variant, drawn) = terminal.watch("breeding", |task| -> Result<_, Error> {
            let Some(number) = self.variant else { return Ok(surprise(seed, sitter)?) };
            let gallery = self.bred(sitter, seed, task)?;
            let variant = gallery.variants()[number - 1].clone();
            let drawn = sitter.portray_one(&variant)?;
            Ok((variant, drawn))
        })?;
        terminal.task().check()?;
        terminal.result(format_args!("{}", described(sitter, &variant, &drawn)))?;
        Ok(drawn.layers)
    }

    /// Draws all twelve and prints what each is.
    ///
    /// # Errors
    /// Errors of the gallery or the renderer.
    pub fn sheet(
        &self,
        sitter: &Sitter,
        seed: u64,
        (camera, size): (Camera, [u32; 2]),
        path: &Path,
        terminal: &Terminal,
    ) -> Result<(), Error> {
        let gallery = terminal.watch("breeding", |task| self.bred(sitter, seed, task))?;
        let variants = gallery.variants();
        let drawn = terminal.watch("exaggerating", |_| sitter.portray(&variants))?;
        terminal.task().check()?;
        for (number, (variant, drawn)) in (1..).zip(variants.iter().zip(&drawn)) {
            terminal.result(format_args!("{number:>2}  {}", described(sitter, variant, drawn)))?;
        }
        let panels = drawn.into_iter().map(|drawn| Portrayed::of(drawn.positions)).collect();
        let rows = in_rows(panels, size);
        // All in one material: only their forms are to be compared.
        let mut picture =
            sheet::draw(&terminal.device()?, &rows, &sitter.body().triangles, None, camera, size)?;
        for (number, (cell, _)) in (1..).zip(sheet::placed(&rows, camera, size)) {
            let size_px = (cell.width.min(cell.height) as f32 / NUMERALS).max(12.0);
            let [left, foot] = [cell.x as f32 + 0.3 * size_px, cell.y as f32 + size_px];
            let lettering = Lettering::new(&u32::to_string(&number), size_px);
            lettering.lay(&mut picture, [left as usize, foot as usize], [60, 60, 66], 1.0);
        }
        let png = picture.to_png()?;
        terminal.task().check()?;
        write_file(path, &png)
    }

    /// The gallery after all that was chosen.
    fn bred(&self, sitter: &Sitter, seed: u64, task: &Task) -> Result<VariantGallery, Error> {
        let mut gallery = VariantGallery::new(seed, sitter)?;
        task.check()?;
        self.lock.iter().for_each(|group| gallery.lock(*group, true));
        for Chosen(chosen) in &self.choose {
            chosen.iter().try_for_each(|number| gallery.choose(number - 1, true))?;
            gallery.breed(sitter)?;
            task.check()?;
        }
        Ok(gallery)
    }
}

/// Width over height of the cells that the sheet is divided into, as nearly as it can be: that of most heads.
const CELL_ASPECT: f32 = 0.9;
/// A cell's shorter side is as long as this many numerals are high.
const NUMERALS: f32 = 9.0;

/// The panels in the rows that show them largest on a sheet of this size.
fn in_rows(panels: Vec<Portrayed>, [width, height]: [u32; 2]) -> Vec<Vec<Portrayed>> {
    let (rows, columns) = layout::rows_and_columns(width, height, panels.len(), CELL_ASPECT);
    let mut panels = panels.into_iter();
    (0..rows).map(|_| panels.by_ref().take(columns).collect()).collect()
}

fn described(sitter: &Sitter, variant: &Variant, drawn: &Drawn) -> String {
    let held = if drawn.kept < 0.995 {
        format!(", {:.0} % of its strength", 100.0 * drawn.kept)
    } else {
        String::new()
    };
    let mu = drawn.layers.first().map_or(0.0, |layer| layer.mu);
    let folded = counted(drawn.folded, "triangle", "triangles");
    format!("{}, μ = {mu:.2}{held}, {folded} folded", sitter.title(variant))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use chladni_caricature::{SitterPart, Stack, Template};
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_match::MatchSettings;
    use chladni_mesh::samples::icosphere;

    use super::*;

    #[test]
    fn a_sheet_has_the_rows_that_suit_its_format() {
        let rows = |size| {
            let panels = (0..GALLERY_SIZE).map(|_| Portrayed::plain(&[])).collect();
            in_rows(panels, size).iter().map(Vec::len).collect::<Vec<_>>()
        };
        assert_eq!([rows([1600, 900]), rows([900, 1600])], [vec![4; 3], vec![3; 4]]);
    }

    #[test]
    fn a_gallery_that_is_canceled_writes_nothing() {
        let mut mesh = icosphere(2);
        mesh.positions.iter_mut().for_each(|p| *p = [1.5 * p[0], p[1], 0.7 * p[2] + 0.3 * p[0] * p[0]]);
        let body = Body::build(&mesh, &BasisSettings::new(12), &Task::new()).unwrap();
        let stack = Stack::new(Arc::new(body)).unwrap();
        let painted = (0..stack.body().positions.len()).map(|vertex| f32::from(u8::from(vertex < 40)));
        let part = SitterPart { name: "part".into(), painted: painted.collect() };
        let template = (Template::LowPass(4), MatchSettings::default());
        let sitter = Sitter::new(&stack, &[template], vec![part]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.png");
        let terminal = Terminal::new(true);
        terminal.task().cancel();
        let options = GalleryOptions::default();
        let drawn = options.sheet(&sitter, 1, (Camera::default(), [64, 64]), &path, &terminal);
        assert!(drawn.unwrap_err().is_cancelled());
        assert!(!path.exists());
        for variant in [None, Some(1)] {
            let single = GalleryOptions { variant, ..GalleryOptions::default() };
            assert!(single.single(&sitter, 1, &terminal).unwrap_err().is_cancelled());
        }
    }
}
