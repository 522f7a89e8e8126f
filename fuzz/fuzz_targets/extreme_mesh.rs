#![no_main]

libfuzzer_sys::fuzz_target!(|mesh: chladni_fuzz::ExtremeMesh| chladni_fuzz::extreme_mesh(mesh));
