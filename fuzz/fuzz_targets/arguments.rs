#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| chladni_fuzz::arguments(text));
