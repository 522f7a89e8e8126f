//! The `chladni` program. Everything it does lives in the library of the same name, where tests reach it.

use std::process::ExitCode;

fn main() -> ExitCode {
    chladni::cli::main()
}
