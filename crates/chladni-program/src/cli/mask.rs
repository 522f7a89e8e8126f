//! `chladni mask SHAPE -o M.npy`: a region as numbers, for other programs.

use std::path::{Path, PathBuf};

use chladni_caricature::Painted;
use chladni_mesh::{Format, ShapeSource};

use super::Terminal;
use super::region::RegionOptions;
use crate::work::formats::is_project;
use crate::work::left_out::left_of_gltf;
use crate::work::outputs::{check_apart, check_file};
use crate::work::{Error, Subject, Warning, Watcher, mask, source};

/// Write a region as a number from 0 to 1 for each vertex of the shape's file.
#[derive(clap::Args)]
pub struct MaskCommand {
    /// The shape, a mesh file or sample:NAME; or a project, whose layer's region is written as it was painted.
    shape: PathBuf,
    /// Where it goes: .npy, .npz (array `mask`), .ply (attribute `mask`), or .glb or .obj (gray vertices).
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Of a project, the layer of this name [default: the top one].
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Paint the vertices of a .ply gray, too, in place of the attribute.
    #[arg(long)]
    as_colors: bool,
    #[command(flatten)]
    region: RegionOptions,
}

impl MaskCommand {
    /// Writes it.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        mask::check(&self.output)?;
        if self.as_colors && Format::of_path(&self.output) != Some(Format::Ply) {
            return Err(Error::input("--as-colors is for a .ply: other meshes are gray anyway"));
        }
        check_file(&self.output)?;
        let read = [Some(self.shape.as_path()), self.region.mask_file()];
        check_apart(&self.output, &read.into_iter().flatten().collect::<Vec<_>>())?;
        let (shape, subject, painted) =
            if is_project(&self.shape) { self.of_project(terminal)? } else { self.of_mesh(terminal)? };
        let masked = mask::write(&self.output, &painted, &subject, self.as_colors)?;
        if masked.inside == 0 {
            terminal.warn(Warning::empty_region(None, subject.whole()));
        }
        terminal.warn_each(shape.file().and_then(|shape| left_of_gltf(shape, &self.output)));
        terminal.result(format_args!("{} of {} vertices", masked.inside, masked.vertices))?;
        terminal.wrote(&self.output)
    }

    fn of_mesh(&self, terminal: &Terminal) -> Result<(ShapeSource, Subject, Painted), Error> {
        if self.layer.is_some() {
            return Err(Error::input("--layer names a layer of a project, and this is a mesh"));
        }
        if !self.region.is_given() {
            let ways = "--region, --part, --limb, --curved or --mask";
            return Err(Error::input(format_args!("say which region of the shape: by {ways}")));
        }
        let shape = ShapeSource::named(&self.shape);
        let subject = Subject::open(&shape, terminal)?;
        let painted = self.region.painted(&self.shape.display().to_string(), &subject, terminal)?;
        Ok((shape, subject, painted))
    }

    fn of_project(&self, terminal: &Terminal) -> Result<(ShapeSource, Subject, Painted), Error> {
        if self.region.is_given() {
            return Err(Error::input("a project brings its regions along: name a --layer"));
        }
        let mut project = source::project(&self.shape, terminal)?;
        check_apart(&self.output, &project.files())?;
        let wanted = |name: &String| self.layer.as_ref().is_none_or(|wanted| wanted == name);
        let found = project.layers().iter().rev().find(|(_, layer)| wanted(&layer.name));
        let Some((_, layer)) = found else {
            return Err(Error::input(no_layer(&self.shape, self.layer.as_deref())));
        };
        let painted = layer.region.painted.clone();
        let subject = Subject::of(&mut project, terminal)?;
        Ok((project.shape, subject, painted))
    }
}

fn no_layer(path: &Path, name: Option<&str>) -> String {
    let path = path.display();
    name.map_or_else(|| format!("{path}: has no layer"), |name| format!("{path}: has no layer called {name}"))
}
