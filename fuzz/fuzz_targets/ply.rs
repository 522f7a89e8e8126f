#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| chladni_fuzz::mesh(bytes, chladni_mesh::Format::Ply));
