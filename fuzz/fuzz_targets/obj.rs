//! Files in a folder, read as an OBJ file, an MTL file and a texture.
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/obj
//! TMPDIR=/dev/shm cargo +nightly fuzz run -s none obj fuzz/corpus/obj fuzz/seeds/obj -- \
//!     -dict=fuzz/obj.dict -max_len=4096 -timeout=10 -rss_limit_mb=2048
//! ```
//!
//! For `-s none` see the target `scan`. `TMPDIR` should be in memory, as `/dev/shm` is on Linux. An
//! input is one byte of settings, the OBJ text, a zero byte, the MTL text, a zero byte, and the
//! texture's bytes; `model.obj`, `model.mtl` and `t.png` (or `t.tga`) are what the files are called.
//! Pictures that claim to be large are not written: the limits for those would only cost time.

#![no_main]

use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use image::{ImageFormat, ImageReader};
use libfuzzer_sys::fuzz_target;
use polyscan::obj::{Loaded, Loader, Model, ObjError};

/// The most texels of a picture that is tried.
const TEXELS: u64 = 1 << 14;

/// A folder of this process alone.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("polyscan-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the temporary folder can be written");
    folder
});

/// Whether a file holds a picture that would be decoded although it is large.
fn is_large(bytes: &[u8], format: Option<ImageFormat>) -> bool {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Some(format) = format {
        reader.set_format(format);
    }
    let size = reader.with_guessed_format().ok().and_then(|reader| reader.into_dimensions().ok());
    size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) > TEXELS)
}

/// Writes one of the files, empty if it is a large picture.
fn write(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.join(name);
    let format = ImageFormat::from_path(name).ok();
    let bytes = if is_large(bytes, format) { &[] } else { bytes };
    std::fs::write(&path, bytes).expect("the temporary folder can be written");
    path
}

fn load(path: &Path, settings: u8) -> Result<Loaded, ObjError> {
    let angle = [None, Some(0.0), Some(4.0), Some(f32::NAN), Some(0.5)][usize::from(settings) % 5];
    angle.map_or(Loader::new(), |angle| Loader::new().with_crease_angle(angle)).load(path)
}

/// What a caller relies on without looking.
fn check(model: &Model) {
    for vertex in &model.vertices {
        assert!(vertex.position.is_finite() && vertex.uv.is_finite(), "{vertex:?}");
        assert!((vertex.normal.length() - 1.0).abs() < 1e-5, "{vertex:?}");
    }
    let mut used: BTreeSet<u32> = BTreeSet::new();
    for face in model.faces() {
        assert!(face.indices.len() >= 3 && face.material < model.materials.len(), "{face:?}");
        assert!(face.indices.iter().all(|&i| (i as usize) < model.vertices.len()), "{face:?}");
        used.extend(face.indices);
    }
    assert_eq!(used.len(), model.vertices.len(), "vertices that no face has");
    let by_material = (0..model.materials.len()).map(|i| model.faces_of(i).count());
    assert_eq!(by_material.sum::<usize>(), model.face_count());
    assert!(model.face_count() > 0 && model.bounds().is_some());
    for material in &model.materials {
        assert!(material.diffuse.is_finite(), "{material:?}");
        assert!(material.texture.is_none_or(|i| i < model.textures.len()), "{material:?}");
    }
    for texture in &model.textures {
        let texels = u64::from(texture.width()) * u64::from(texture.height());
        assert!(texels > 0 && texture.texels().len() as u64 == texels);
        assert!(texture.texels().iter().all(|texel| texel.is_finite()));
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((&settings, files)) = data.split_first() else { return };
    let mut files = files.splitn(3, |&byte| byte == 0);
    let [obj, mtl, picture] = std::array::from_fn(|_| files.next().unwrap_or_default());
    let path = write("model.obj", obj);
    write("model.mtl", mtl);
    write(["t.png", "t.tga"][usize::from(settings >> 7)], picture);
    match load(&path, settings) {
        Ok(Loaded { model, warnings }) => {
            check(&model);
            assert!(warnings.iter().all(|warning| !warning.to_string().is_empty()));
        }
        // The library has checked all that the parser checks.
        Err(error @ ObjError::Parser { .. }) => panic!("{error}"),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
