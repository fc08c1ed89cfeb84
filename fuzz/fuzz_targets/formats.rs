//! Bytes read as an STL, PLY or glTF file.
//!
//! ```text
//! mkdir -p fuzz/corpus/formats
//! cargo +nightly fuzz run -s none formats fuzz/corpus/formats fuzz/seeds/formats -- \
//!     -max_len=4096 -timeout=10 -rss_limit_mb=2048
//! ```
//!
//! An input is one byte that chooses the name, and the bytes of the file.

#![no_main]

use libfuzzer_sys::fuzz_target;
use polyscan::formats::Loader;

fuzz_target!(|data: &[u8]| {
    let Some((&name, bytes)) = data.split_first() else { return };
    let name = ["a.stl", "a.ply", "a.gltf", "a.obj", "a"][usize::from(name) % 5];
    match Loader::new().read(bytes, name) {
        Ok(loaded) => {
            let model = loaded.model;
            for vertex in &model.vertices {
                assert!(vertex.position.is_finite() && vertex.uv.is_finite(), "{vertex:?}");
                assert!((vertex.normal.length() - 1.0).abs() < 1e-5, "{vertex:?}");
            }
            for face in model.faces() {
                assert!(face.indices.len() >= 3 && face.material < model.materials.len());
                assert!(face.indices.iter().all(|&i| (i as usize) < model.vertices.len()));
            }
            assert!(model.face_count() > 0 && model.bounds().is_some());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
