#![no_main]

libfuzzer_sys::fuzz_target!(|file: chladni_fuzz::Riff<'_>| chladni_fuzz::riff(&file));
