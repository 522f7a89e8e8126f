#![no_main]

libfuzzer_sys::fuzz_target!(|file: chladni_fuzz::Mp4<'_>| chladni_fuzz::mp4(&file));
