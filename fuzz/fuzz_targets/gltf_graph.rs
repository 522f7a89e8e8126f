#![no_main]

libfuzzer_sys::fuzz_target!(|graph: chladni_fuzz::GltfGraph| chladni_fuzz::gltf_graph(graph));
