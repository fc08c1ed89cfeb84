//! Models from files of any format that a feature is on for.
//!
//! What flows in is the name of a file, or its bytes; what flows out is a [`Model`] with warnings. The format
//! is recognised by the content, and only where that says nothing by the name. OBJ files are read by
//! [`obj`](crate::obj), STL files by `formats::stl`; `formats::ply` and `formats::gltf` give the others the same
//! form, `formats::found`. All keep to `formats::limits`. Files of more than [`MAX_BYTES`] or [`MAX_CORNERS`] face
//! corners are refused, so that no file can ask for a machine's whole memory.
//!
//! ```
//! # #[cfg(feature = "stl")] {
//! use polyscan::formats::Loader;
//!
//! let text = "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
//!             endloop\nendfacet\nendsolid\n";
//! let loaded = Loader::new().read(text.as_bytes(), "triangle.stl")?;
//! assert_eq!(loaded.model.face_count(), 1);
//! # }
//! # Ok::<(), polyscan::formats::LoadError>(())
//! ```

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::model::Model;
use crate::model::also::Also;

mod limits;
#[cfg(any(feature = "ply", feature = "gltf"))]
mod found;
#[cfg(feature = "stl")]
mod stl;
#[cfg(feature = "ply")]
mod ply;
#[cfg(feature = "gltf")]
mod gltf;

pub use self::limits::MAX_CORNERS;

/// The most bytes in a file: 1 GiB.
pub const MAX_BYTES: u64 = 1 << 30;

/// A format of model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, text.
    Obj,
    /// STL, text or binary.
    Stl,
    /// The Stanford format, text or binary.
    Ply,
    /// glTF 2.0, as JSON or as GLB.
    Gltf,
}

impl Format {
    /// The format of a file by its content and its name; `None` if neither tells it.
    #[must_use]
    pub fn of(content: &[u8], name: &Path) -> Option<Self> {
        let start = content.trim_ascii_start();
        if content.starts_with(b"glTF") {
            return Some(Self::Gltf);
        }
        if content.starts_with(b"ply\n") || content.starts_with(b"ply\r") {
            return Some(Self::Ply);
        }
        let ending = name.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("obj") => return Some(Self::Obj),
            Some("stl") => return Some(Self::Stl),
            Some("ply") => return Some(Self::Ply),
            Some("gltf" | "glb" | "vrm") => return Some(Self::Gltf),
            _ => {}
        }
        if start.starts_with(b"{") {
            return Some(Self::Gltf);
        }
        if limits::begins_solid(content) {
            return Some(Self::Stl);
        }
        if content.len() >= 84 {
            let count = [content[80], content[81], content[82], content[83]];
            if content.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(count)) {
                return Some(Self::Stl);
            }
        }
        let is_obj = |line: &[u8]| line.starts_with(b"v ") || line.starts_with(b"f ");
        let mut lines = start.split(|&byte| byte == b'\n').take(1000).map(<[u8]>::trim_ascii);
        lines.any(is_obj).then_some(Self::Obj)
    }

    /// The feature that the format needs, and the name that it goes by.
    fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Gltf => "gltf",
        }
    }
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read, or is over [`MAX_BYTES`].
    #[error("cannot read the model {}: {source}; check its name, permissions and size", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// An OBJ file is wrong.
    #[cfg(feature = "obj")]
    #[error(transparent)]
    Obj(#[from] crate::obj::ObjError),
    /// A file of another format is wrong.
    #[error("{}: {cause}", path.display())]
    Wrong {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, as a sentence.
        cause: String,
    },
    /// The file has no faces, or no corner of one is finite.
    #[error("{} has no faces: is it a model of polygons?{}", path.display(), Also(warnings))]
    NoFaces {
        /// The file.
        path: PathBuf,
        /// What else is wrong with it, or not used: sentences that name file and cause.
        warnings: Vec<String>,
    },
    /// Neither the content nor the name tells a format.
    #[error("{} is in no format that is known: convert it to glTF, OBJ, PLY or STL", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The library was built without the feature that reads the format.
    #[error("{} needs the feature `{feature}` of polyscan, which is not on", path.display())]
    FeatureNeeded {
        /// The file.
        path: PathBuf,
        /// The feature.
        feature: &'static str,
    },
}

/// A model of any format, and what its files lack.
#[derive(Debug)]
#[must_use]
pub struct Loaded {
    /// The model, complete as to geometry.
    pub model: Model,
    /// What its format is.
    pub format: Format,
    /// What was replaced, skipped or is not used: sentences that name file and cause.
    pub warnings: Vec<String>,
}

/// How to load a model of any format.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Loader {
    crease_angle: f32,
    root: Option<PathBuf>,
}

impl Model {
    /// Loads a file of any format that a feature is on for, with the default [`Loader`].
    ///
    /// ```no_run
    /// use polyscan::Model;
    ///
    /// let loaded = Model::open("part.stl")?;
    /// for warning in &loaded.warnings {
    ///     eprintln!("warning: {warning}");
    /// }
    /// println!("{} faces", loaded.model.face_count());
    /// # Ok::<(), polyscan::formats::LoadError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Loader::load`].
    pub fn open(path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        Loader::new().load(path)
    }
}

impl Default for Loader {
    fn default() -> Self {
        Self { crease_angle: std::f32::consts::FRAC_PI_3, root: None }
    }
}

impl Loader {
    /// The default loader, with a crease angle of 60 degrees.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the crease angle, in radians from 0 to pi: computed normals are smooth where faces meet at less.
    ///
    /// Angles outside the range are clamped; NaN counts as 0.
    pub fn with_crease_angle(self, radians: f32) -> Self {
        let crease_angle = if radians > 0.0 { radians.min(std::f32::consts::PI) } else { 0.0 };
        Self { crease_angle, ..self }
    }

    /// Sets a folder above the model's below which materials and textures of OBJ files may lie.
    pub fn with_root(self, folder: impl Into<PathBuf>) -> Self {
        Self { root: Some(folder.into()), ..self }
    }

    /// Loads a file and the files it refers to, which lie in its folder or below.
    ///
    /// # Errors
    /// [`LoadError`] says which file is wrong, and how.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        let path = path.as_ref();
        let open = || {
            // Devices and pipes might never end.
            if !fs::metadata(path)?.is_file() {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidInput,
                    "it is not a regular file",
                ));
            }
            File::open(path)
        };
        let file = open().map_err(|source| LoadError::Read { path: path.to_owned(), source })?;
        // All at once; a file that grows meanwhile is read all the same.
        let len = file.metadata().map_or(0, |metadata| metadata.len().min(MAX_BYTES) + 1);
        self.read_with_room(len as usize, file, path)
    }

    /// Loads a model from anywhere, such as the standard input.
    ///
    /// `name` stands for the file in messages; files that it refers to are looked for beside it.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn read(&self, reader: impl Read, name: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        self.read_with_room(0, reader, name.as_ref())
    }

    fn read_with_room(
        &self,
        room: usize,
        reader: impl Read,
        path: &Path,
    ) -> Result<Loaded, LoadError> {
        let path = path.to_owned();
        let mut bytes = Vec::with_capacity(room);
        let read = reader.take(MAX_BYTES + 1).read_to_end(&mut bytes).and_then(|length| {
            if length as u64 <= MAX_BYTES {
                return Ok(());
            }
            let sentence = format!("it has more than the {MAX_BYTES} bytes that are allowed");
            Err(io::Error::new(io::ErrorKind::FileTooLarge, sentence))
        });
        if let Err(source) = read {
            return Err(LoadError::Read { path, source });
        }
        match Format::of(&bytes, &path) {
            None => Err(LoadError::UnknownFormat { path }),
            #[cfg(feature = "obj")]
            Some(Format::Obj) => self.read_obj(bytes, &path),
            Some(format) => self.read_other(format, bytes, path),
        }
    }

    #[cfg(feature = "obj")]
    fn read_obj(&self, bytes: Vec<u8>, path: &Path) -> Result<Loaded, LoadError> {
        let mut loader = crate::obj::Loader::new().with_crease_angle(self.crease_angle);
        if let Some(root) = &self.root {
            loader = loader.with_root(root);
        }
        let loaded = loader.read_bytes(bytes, path)?;
        let warnings = loaded.warnings.iter().map(ToString::to_string).collect();
        Ok(Loaded { model: loaded.model, format: Format::Obj, warnings })
    }

    fn read_other(
        &self,
        format: Format,
        bytes: Vec<u8>,
        path: PathBuf,
    ) -> Result<Loaded, LoadError> {
        let crease_angle = self.crease_angle;
        let read = match format {
            #[cfg(feature = "stl")]
            Format::Stl => stl::read(bytes, crease_angle),
            #[cfg(feature = "ply")]
            Format::Ply => ply::read(&bytes, &path).map(|found| found.into_model(crease_angle)),
            #[cfg(feature = "gltf")]
            Format::Gltf => gltf::read(&bytes, &path).map(|found| found.into_model(crease_angle)),
            #[allow(
                unreachable_patterns,
                reason = "which formats are left depends on the features"
            )]
            format => {
                drop(bytes);
                return Err(LoadError::FeatureNeeded { path, feature: format.name() });
            }
        };
        #[allow(unreachable_code, reason = "without features there is no other format")]
        let (model, warnings): (Option<Model>, Vec<String>) = match read {
            Ok(read) => read,
            Err(cause) => return Err(LoadError::Wrong { path, cause }),
        };
        let name = |warning: String| format!("{}: {warning}", path.display());
        let warnings = warnings.into_iter().map(name).collect();
        match model {
            Some(model) => Ok(Loaded { model, format, warnings }),
            None => Err(LoadError::NoFaces { path, warnings }),
        }
    }
}
