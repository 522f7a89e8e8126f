#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| chladni_fuzz::mesh_beside(bytes, chladni_mesh::Format::Gltf));
