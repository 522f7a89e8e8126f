#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| chladni_fuzz::whole_dance(bytes));
