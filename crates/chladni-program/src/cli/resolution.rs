//! How finely a shape is worked on: the way in which commands say it.

use chladni_caricature::{ProxyKey, Resolution};

use super::number::number;
use crate::work::Error;

/// How finely a shape is worked on.
#[derive(clap::Args, Clone, Debug)]
pub struct ResolutionOptions {
    /// Work on about this many of the shape's vertices, chosen so that its surface stays; meshes are written with all of
    /// them. 0 works on all [default: 150000 where the shape has more than 400000, else all].
    #[arg(long, value_name = "VERTICES", value_parser = vertices)]
    proxy: Option<usize>,
}

impl ResolutionOptions {
    /// The resolution asked for; by default, all vertices if `--match same` needs them.
    ///
    /// # Errors
    /// [`Error::Input`] where fewer are asked for than are needed.
    pub fn or_all(&self, are_needed: bool) -> Result<Resolution, Error> {
        match self.wanted() {
            Resolution::Usual if are_needed => Ok(Resolution::Whole),
            Resolution::Proxy(_) if are_needed => {
                Err(Error::input("--match same needs all vertices: leave out --proxy, or give 0"))
            }
            wanted => Ok(wanted),
        }
    }

    /// The resolution asked for.
    pub fn wanted(&self) -> Resolution {
        match self.proxy {
            None => Resolution::Usual,
            Some(0) => Resolution::Whole,
            Some(vertices) => Resolution::Proxy(ProxyKey { vertices, fingerprint: None }),
        }
    }
}

fn vertices(text: &str) -> Result<usize, Error> {
    number(text, |n| *n == 0 || *n >= ProxyKey::FEWEST, format_args!("0, or {} or more", ProxyKey::FEWEST))
}
