//! The command line: one file per command, each with its arguments and its `run`.

mod basis;
mod beats;
mod caricature;
mod choice;
mod choose_file;
mod controls;
mod dance;
mod demo;
mod frames;
mod gallery;
mod info;
mod ink;
mod layer_options;
mod limbs;
mod mask;
mod match_shapes;
mod mean;
mod movement;
mod number;
mod open;
mod part_output;
mod parts;
mod portrait;
mod project;
mod region;
mod resolution;
mod sheet;
mod spectrum;
mod stance;
mod symmetry;
mod terminal;
mod threads;
mod transfer;
mod turntable;

use std::ffi::OsString;
use std::path::Path;

use chladni_view::Draw;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};

pub use caricature::meshes_listed;
pub use terminal::Terminal;

use crate::work::formats::is_project;
use crate::work::{Error, Watcher};

/// Plays the natural vibrations of 3D shapes.
///
/// Without a command the window opens.
#[derive(Parser)]
#[command(name = "chladni", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Draw no progress bars.
    #[arg(long, global = true, display_order = 900)]
    quiet: bool,
    /// Who draws pictures, films and the window: cpu, gpu, or auto, which is a graphics card where there is
    /// one and else the processor, which needs no driver.
    #[arg(long, global = true, value_name = "WHO", default_value = "auto", display_order = 901)]
    draw: Draw,
}

#[derive(Subcommand)]
enum Command {
    Open(open::Open),
    Demo(demo::Demo),
    Info(info::Info),
    Caricature(Box<caricature::Caricature>),
    #[command(subcommand)]
    Project(project::ProjectCommand),
    Dance(Box<dance::Dance>),
    Match(match_shapes::MatchShapes),
    Mean(mean::Mean),
    Transfer(transfer::TransferCommand),
    Parts(parts::Parts),
    Mask(mask::MaskCommand),
    Basis(basis::Args),
    Beats(beats::Beats),
    Spectrum(spectrum::Spectrum),
    Symmetry(symmetry::SymmetryCommand),
    Controls(controls::Controls),
    #[command(hide = true, name = crate::window::CHOOSE_FILE)]
    ChooseFile(choose_file::ChooseFile),
}

/// Runs the program with the process's own arguments.
pub fn main() -> std::process::ExitCode {
    if let Some(warning) = threads::start() {
        Terminal::new(false).warn(warning);
    }
    std::process::ExitCode::from(run(std::env::args_os()))
}

/// Runs one command line, first the program's name, and returns its exit code:
/// 0 done, 2 bad input or arguments, 1 anything else.
pub fn run<I, T>(arguments: I) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            let error = Error::Input(in_one_line(&error, &arguments));
            Terminal::new(false).error(&error);
            return exit_code(&error);
        }
        Err(help_or_version) => {
            let _ = help_or_version.print();
            return 0;
        }
    };
    let takes_stance = cli.command.as_ref().is_some_and(Command::takes_stance);
    let terminal = Terminal::new(cli.quiet).drawing(cli.draw).taking_stance(takes_stance);
    let done = match cli.command {
        Some(command) => command.run(&terminal),
        None => open::Open::default().run(&terminal),
    };
    match done {
        Ok(()) => 0,
        Err(error) => {
            terminal.error(&error);
            exit_code(&error)
        }
    }
}

/// Whether a command line is understood, of which nothing is done.
///
/// # Errors
/// [`Error::Input`], as [`run`] prints it. Asking for help or the version is understood.
pub fn understand<I, T>(arguments: I) -> Result<(), Error>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    match Cli::try_parse_from(&arguments) {
        Err(error) if error.use_stderr() => Err(Error::Input(in_one_line(&error, &arguments))),
        _ => Ok(()),
    }
}

/// 2 for bad input or arguments, 1 for anything else.
pub fn exit_code(error: &Error) -> u8 {
    if error.is_of_input() { 2 } else { 1 }
}

/// The error in the arguments and clap's suggestion, without the usage that follows.
fn in_one_line(error: &clap::Error, arguments: &[OsString]) -> String {
    if error.kind() == ErrorKind::InvalidUtf8 {
        // Its own text names none.
        let odd = arguments.iter().skip(1).filter(|argument| argument.to_str().is_none());
        let odd: Vec<_> = odd.map(|argument| argument.to_string_lossy()).collect();
        let which = if odd.len() == 1 { "is" } else { "one of these is" };
        return format!("{}: {which} not valid Unicode, which is needed here", odd.join(", "));
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "a subcommand is missing (--help lists what there is)".into();
    }
    if let Some(why) = misplaced(error, arguments) {
        return why;
    }
    let text = error.to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty())
        // A value with a minus sign is not made right by `--`.
        .filter(|line| !line.starts_with("tip:") || !line.contains("'-- -"));
    let mut said = String::new();
    for line in lines {
        match said.chars().last() {
            None => {}
            Some(':') => said.push(' '),
            Some(_) if line.starts_with("tip:") => said.push_str("; "),
            Some(_) => said.push_str(", "),
        }
        said.push_str(line);
    }
    format!("{} (--help lists what there is)", said.strip_prefix("error: ").unwrap_or(&said))
}

/// Why a file in the place of a command, or a project in that of a shape, is refused.
fn misplaced(error: &clap::Error, arguments: &[OsString]) -> Option<String> {
    match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand) else {
                return None;
            };
            // Below `project` one of its own commands is missing.
            let is_nested = arguments.iter().skip(1).any(|argument| argument == "project");
            let is_meant = !is_nested && Path::new(name).is_file();
            is_meant.then(|| format!("{name} is a file, not a command: chladni open {name} opens it"))
        }
        ErrorKind::MissingRequiredArgument if arguments.iter().any(|argument| argument == "caricature") => {
            // After an option it may be that one's value.
            let is_option = |argument: &OsString| argument.to_string_lossy().starts_with('-');
            let mut pairs = arguments.iter().zip(arguments.iter().skip(1));
            let (_, project) =
                pairs.find(|(before, argument)| !is_option(before) && is_project(Path::new(argument)))?;
            let path = project.to_string_lossy();
            Some(format!("{path}: is a caricature project: give it as --recipe {path}"))
        }
        _ => None,
    }
}

impl Command {
    /// Whether it has the options --up and --front.
    fn takes_stance(&self) -> bool {
        matches!(self, Self::Caricature(_) | Self::Project(_) | Self::Dance(_) | Self::Parts(_))
    }

    fn run(self, terminal: &Terminal) -> Result<(), Error> {
        match self {
            Self::Open(command) => command.run(terminal),
            Self::ChooseFile(command) => command.run(terminal),
            Self::Basis(args) => args.run(terminal),
            Self::Match(command) => command.run(terminal),
            Self::Mean(command) => command.run(terminal),
            Self::Transfer(command) => command.run(terminal),
            Self::Parts(command) => command.run(terminal),
            Self::Mask(command) => command.run(terminal),
            Self::Info(info) => info.run(terminal),
            Self::Demo(demo) => demo.run(terminal),
            Self::Beats(command) => command.run(terminal),
            Self::Spectrum(command) => command.run(terminal),
            Self::Caricature(command) => command.run(terminal),
            Self::Dance(command) => command.run(terminal),
            Self::Symmetry(command) => command.run(terminal),
            Self::Controls(command) => command.run(terminal),
            Self::Project(command) => command.run(terminal),
        }
    }
}
