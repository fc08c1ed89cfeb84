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
//! Pictures that claim to be large are not written: the limits for those would only cost time. In the
//! folder above lies `secret.png`, which must not be opened.

#![no_main]

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use polyscan::Model;
use polyscan::image::{self, ImageFormat, ImageReader};
use polyscan::obj::{Loaded, Loader, MAX_LIBRARIES, ObjError, Warning};
use polyscan::texture::{Texture, TextureError};

/// The most texels of a picture that is tried.
const TEXELS: u64 = 1 << 14;

/// A folder of this process alone.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let above = std::env::temp_dir().join(format!("polyscan-fuzz-{}", std::process::id()));
    let folder = above.join("in");
    std::fs::create_dir_all(&folder).expect("the temporary folder can be written");
    secret().save(above.join("secret.png")).expect("the temporary folder can be written");
    folder
});

/// The texels of the picture above the folder.
static SECRET: LazyLock<Texture> =
    LazyLock::new(|| Texture::from_image(&secret().into()).expect("a small picture"));

/// A picture that no input happens to hold.
fn secret() -> image::RgbImage {
    image::RgbImage::from_fn(9, 9, |x, y| image::Rgb([x as u8 * 27 + 5, y as u8 * 27 + 7, 211]))
}

thread_local! {
    /// What the files hold: writing is half of the time, and most inputs change one of them.
    static WRITTEN: RefCell<HashMap<&'static str, Vec<u8>>> = RefCell::default();
}

/// Whether a file holds a picture that would be decoded although it is large.
fn is_large(bytes: &[u8], format: Option<ImageFormat>) -> bool {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Some(format) = format {
        reader.set_format(format);
    }
    let size = reader.with_guessed_format().ok().and_then(|reader| reader.into_dimensions().ok());
    size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) > TEXELS)
}

/// Sees to it that one of the files holds `bytes`, or nothing if those are a large picture; what it
/// holds.
fn write<'a>(name: &'static str, bytes: &'a [u8]) -> &'a [u8] {
    let format = ImageFormat::from_path(name).ok();
    let bytes = if is_large(bytes, format) { &[] } else { bytes };
    WRITTEN.with_borrow_mut(|written| {
        if written.get(name).is_none_or(|before| before != bytes) {
            std::fs::write(FOLDER.join(name), bytes).expect("the temporary folder can be written");
            written.insert(name, bytes.to_owned());
        }
    });
    bytes
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
        assert!(texels > 0 && texture.texels().count() as u64 == texels);
        assert!(texture.texels().all(|texel| texel.is_finite()));
        assert!(!texture.texels().eq(SECRET.texels()), "a picture from the folder above");
    }
}

/// A file that cannot be read is named, and lies in the folder.
fn check_warning(warning: &Warning) {
    use TextureError::{Decode, Read, TooLarge};
    let path = match warning {
        Warning::MaterialFile { path, .. }
        | Warning::Texture {
            source: Decode { path, .. } | Read { path, .. } | TooLarge { path, .. },
            ..
        } => path,
        _ => return,
    };
    let below = path.strip_prefix(&*FOLDER).unwrap_or_else(|_| panic!("{warning}"));
    assert!(below.components().all(|part| matches!(part, Component::Normal(_))), "{warning}");
}

/// Whether the files define a material beyond doubt, so that the model must have one: the parser
/// drops all of them for a line that it does not like.
fn defines_material(obj: &[u8], mtl: &[u8]) -> bool {
    let [obj, mtl] = [obj, mtl].map(String::from_utf8_lossy);
    let has_line = |text: &str, is_wanted: fn(&str) -> bool| {
        // Backslashes join lines.
        !text.contains('\\') && text.lines().any(is_wanted)
    };
    has_line(&obj, |line| line == "mtllib model.mtl")
        && has_line(&mtl, |line| line.strip_prefix("newmtl ").is_some_and(|s| !s.trim().is_empty()))
        && obj.split_whitespace().count() < MAX_LIBRARIES
}

fuzz_target!(|data: &[u8]| {
    let Some((&settings, files)) = data.split_first() else { return };
    let mut files = files.splitn(3, |&byte| byte == 0);
    let [obj, mtl, picture] = std::array::from_fn(|_| files.next().unwrap_or_default());
    let obj = write("model.obj", obj);
    let mtl = write("model.mtl", mtl);
    let (used, unused) = if settings < 0x80 { ("t.png", "t.tga") } else { ("t.tga", "t.png") };
    write(used, picture);
    write(unused, &[]);
    match load(&FOLDER.join("model.obj"), settings) {
        Ok(Loaded { model, warnings }) => {
            check(&model);
            assert!(model.materials.len() > 1 || !defines_material(obj, mtl), "{warnings:?}");
            for warning in &warnings {
                assert!(!warning.to_string().is_empty());
                check_warning(warning);
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
