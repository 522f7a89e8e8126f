//! The `chladni` program. Everything it does lives in the library of the same name, where tests reach it.

use std::process::ExitCode;

fn main() -> ExitCode {
    silence_wayland_lookup();
    give_memory_back();
    silence_decoders();
    chladni_program::cli::main()
}

/// A damaged song can contradict what its decoder asserts. `chladni-sound` catches that and says which file is damaged.
fn silence_decoders() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !chladni_sound::is_decoding() {
            usual(panic);
        }
    }));
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

/// glibc gives each thread a heap of its own, and keeps in it all memory of the thread's peaks. In a show of hours, where knobs
/// take memory and leave it again, the program would grow by that: it has two heaps instead, large blocks go back to
/// the system when they are free, and free pages between blocks that are in use every now and then.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn give_memory_back() {
    const LARGE_BYTES: libc::c_int = 1 << 20;
    const EVERY: std::time::Duration = std::time::Duration::from_secs(10);
    #[expect(unsafe_code, reason = "numbers that the allocator takes at any time")]
    // SAFETY: no memory of ours is touched.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 2);
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE_BYTES);
        libc::mallopt(libc::M_TRIM_THRESHOLD, 4 * LARGE_BYTES);
    }
    let trim = || {
        loop {
            std::thread::sleep(EVERY);
            #[expect(unsafe_code, reason = "a function that the allocator offers at any time")]
            // SAFETY: no memory that is in use is touched.
            unsafe {
                libc::malloc_trim(0);
            }
        }
    };
    // Without that thread, the program works as well, but takes more memory.
    let _ = std::thread::Builder::new().name("memory".into()).spawn(trim);
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn give_memory_back() {}
