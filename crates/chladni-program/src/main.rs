//! The `chladni` program. Everything it does lives in the library of the same name, where tests reach it.

use std::process::ExitCode;

fn main() -> ExitCode {
    silence_wayland_lookup();
    chladni_program::cli::main()
}

/// Mesa's device-selection layer looks for a Wayland session whenever Vulkan lists its devices, and where
/// there is none libwayland prints an error that does not concern the user. Without a session the layer
/// selects nothing anyway.
#[cfg(target_os = "linux")]
fn silence_wayland_lookup() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none_or(|folder| !std::path::Path::new(&folder).is_dir()) {
        #[expect(unsafe_code, reason = "the first statement of the program: no other thread runs yet")]
        // SAFETY: the environment may be changed as long as no other thread reads it.
        unsafe {
            std::env::set_var("NODEVICE_SELECT", "1");
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn silence_wayland_lookup() {}
