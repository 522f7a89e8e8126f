//! The program: commands for scripts ([`cli`]), the window for people ([`studio`]), and the [`work`] that
//! both share.
//!
//! ```
//! // Every command can be called the way a shell would call it.
//! let code = chladni_program::cli::run(["chladni", "info", "no-such-file.obj"]);
//! assert_eq!(code, 2); // bad input
//! ```
//!
//! Not guaranteed: this library exists for the program, its benchmarks and its tests; its items may change
//! with any version. What scripts may rely on are the command line, the files and the exit codes.

#[cfg(feature = "desktop")]
pub mod cli;
#[cfg(feature = "desktop")]
pub mod studio;
#[cfg(feature = "desktop")]
mod window;
pub mod work;
