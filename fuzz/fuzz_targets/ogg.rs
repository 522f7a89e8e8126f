#![no_main]

libfuzzer_sys::fuzz_target!(|file: chladni_fuzz::Ogg<'_>| chladni_fuzz::ogg(&file));
