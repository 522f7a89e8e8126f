//! The region of a layer, as commands take it.

use std::path::{Path, PathBuf};

use chladni_caricature::{Curved, HEAD_PARTS, Limbs, Painted, Sphere};
use chladni_mesh::{TriMesh, weld};

use super::number::number;
use super::{Terminal, limbs, parts};
use crate::work::{Error, Subject, mask};

/// A region, given in one of several ways; without any it is everywhere.
#[derive(clap::Args, Clone, Debug)]
pub struct RegionOptions {
    /// Act only within this ball, x,y,z,radius in the shape's own units; may be repeated.
    #[arg(long, value_name = "X,Y,Z,RADIUS", allow_hyphen_values = true)]
    region: Vec<Sphere>,
    /// Act only on this part of a head: nose, brow, eyes, mouth, chin, jaw, cheeks, ears, crown or neck, found by a match
    /// with a head of known parts (those of sample heads are known); may be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "region", value_parser = part)]
    part: Vec<String>,
    /// Act only on this part of any shape, by the number that `parts --level` prints; may be repeated, or several with
    /// commas between.
    #[arg(long, value_name = "N", conflicts_with_all = ["region", "part"], value_delimiter = ',',
        value_parser = limb)]
    limb: Vec<usize>,
    /// Which parts --limb counts, from 0 (whole limbs) to 1 (small features).
    // Clap waives what an option requires where that conflicts with what is given: such options are named, too.
    #[arg(long, value_name = "X", requires = "limb", conflicts_with_all = ["region", "part", "curved", "mask"],
        default_value_t = Limbs::USUAL_LEVEL, allow_negative_numbers = true, value_parser = parts::level)]
    level: f64,
    /// Act only where the surface bends most: outward (bumps), inward (hollows) or either way (both), and the share of
    /// the surface that this is [default share: 20%].
    #[arg(long, value_name = "bumps|hollows|both[:P%]", conflicts_with_all = ["region", "part", "limb"])]
    curved: Option<Curved>,
    /// Act where this mask says: a number from 0 to 1 for each vertex of the shape's file. An array (.npy, or `mask` of an
    /// .npz), or a mesh with as many vertices, the shape itself or another, by --mask-channel.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["region", "part", "limb", "curved"])]
    mask: Option<PathBuf>,
    /// Which numbers --mask takes: the array of an .npz, an attribute of a PLY, or red, green, blue or alpha of vertex
    /// colors [default: mask; of a mesh that has none, red; else the only one of the file].
    // As for the level.
    #[arg(long, value_name = "NAME", requires = "mask",
        conflicts_with_all = ["region", "part", "limb", "curved"])]
    mask_channel: Option<String>,
}

fn limb(text: &str) -> Result<usize, Error> {
    number(text, |_| true, "a number that parts --level prints")
}

fn part(text: &str) -> Result<String, Error> {
    let known = HEAD_PARTS.contains(&text).then(|| text.to_owned());
    known.ok_or_else(|| Error::input(format!("must be one of {}", HEAD_PARTS.join(", "))))
}

impl RegionOptions {
    /// Whether any region is given.
    pub fn is_given(&self) -> bool {
        let lists = self.region.is_empty() && self.part.is_empty() && self.limb.is_empty();
        !lists || self.curved.is_some() || self.mask.is_some()
    }

    /// The file of --mask.
    pub fn mask_file(&self) -> Option<&Path> {
        self.mask.as_deref()
    }

    /// χ01 on the shape that is called `name`.
    pub fn painted(&self, name: &str, subject: &Subject, terminal: &Terminal) -> Result<Painted, Error> {
        if !self.region.is_empty() {
            return Ok(Painted::Spheres(self.region.clone()));
        }
        if !self.is_given() {
            return Ok(Painted::Everywhere);
        }
        let mesh: &TriMesh = &subject.mesh;
        if let Some(path) = &self.mask {
            return mask::read(path, self.mask_channel.as_deref(), subject);
        }
        if !self.limb.is_empty() {
            return limbs::region((name, mesh), self.level, &self.limb, terminal);
        }
        let welded = weld(mesh);
        if let Some(curved) = &self.curved {
            return Ok(curved.painted(&welded.positions, &welded.triangles));
        }
        let found = parts::found(name, mesh, terminal)?;
        Ok(found.painted(&welded.operator_vertex, &self.part)?)
    }
}
