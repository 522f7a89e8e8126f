//! `chladni-bench`: measures the program against published numbers. The scripts in `bench/` run it and write
//! BENCHMARKS.md.

mod breeding;
mod caricature;
mod easel;
mod head_parts;
mod limbs;
mod music;
mod sand;
mod scan;
mod sphere;
mod synth;
mod tables;

use std::process::ExitCode;

use chladni_program::cli::{Terminal, exit_code};
use clap::{Parser, Subcommand};

/// Measure the program on this machine.
#[derive(Parser)]
#[command(name = "chladni-bench", version)]
struct Bench {
    #[command(subcommand)]
    what: What,
    /// Draw no progress bars.
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum What {
    Breeding(breeding::BenchBreeding),
    Caricature(caricature::BenchCaricature),
    Gallery(caricature::BenchGallery),
    HeadParts(head_parts::BenchHeadParts),
    Keeping(caricature::BenchKeeping),
    Limbs(limbs::BenchLimbs),
    Music(music::BenchMusic),
    Sand(sand::BenchSand),
    Scan(scan::BenchScan),
    Synth(synth::BenchSynth),
    Tables(tables::BenchTables),
}

fn main() -> ExitCode {
    let bench = Bench::parse();
    let terminal = Terminal::new(bench.quiet);
    let done = match bench.what {
        What::Breeding(breeding) => breeding.run(&terminal),
        What::Caricature(caricature) => caricature.run(&terminal),
        What::Gallery(gallery) => gallery.run(&terminal),
        What::HeadParts(parts) => parts.run(&terminal),
        What::Keeping(keeping) => keeping.run(&terminal),
        What::Limbs(limbs) => limbs.run(&terminal),
        What::Music(music) => music.run(&terminal),
        What::Sand(sand) => sand.run(&terminal),
        What::Scan(scan) => scan.run(&terminal),
        What::Synth(synth) => synth.run(&terminal),
        What::Tables(tables) => tables.run(&terminal),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal.error(&error);
            ExitCode::from(exit_code(&error))
        }
    }
}
