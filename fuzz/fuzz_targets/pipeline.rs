#![no_main]

libfuzzer_sys::fuzz_target!(|shape: chladni_fuzz::Shape| chladni_fuzz::pipeline(shape));
