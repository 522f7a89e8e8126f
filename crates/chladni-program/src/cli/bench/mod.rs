//! `chladni bench`: measures the program against published numbers.

mod caricature;
mod music;
mod sphere;
mod synth;
mod tables;

use clap::{Args, Subcommand};

use super::{Failure, Terminal};

/// Measure the program on this machine.
#[derive(Args)]
pub struct Bench {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Caricature(caricature::BenchCaricature),
    Music(music::BenchMusic),
    Synth(synth::BenchSynth),
    Tables(tables::BenchTables),
}

impl Bench {
    /// Runs the benchmark.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        match self.what {
            What::Caricature(caricature) => caricature.run(terminal),
            What::Music(music) => music.run(terminal),
            What::Synth(synth) => synth.run(terminal),
            What::Tables(tables) => tables.run(terminal),
        }
    }
}
