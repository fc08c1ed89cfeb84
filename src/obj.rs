//! OBJ and MTL files to polygons, materials and textures.
//!
//! What flows in is the name of an OBJ file; what flows out is a [`Model`]: vertices that are
//! transformed once each, faces that keep their sides, materials, and the textures they name. On
//! the way (`obj::read`):
//!
//! - `obj::file` reads bytes as text, within the bounds of `obj::limits`, and `obj::lines` parts it;
//! - `obj::geometry` reads the OBJ text in one pass, with the colours of vertices
//!   (`obj::vertex_color`), and `obj::notes` what it leaves out;
//! - `obj::paths` finds the files that names stand for, `obj::mtl` reads those of materials;
//! - `obj::materials` opens the textures, by the options that `obj::map_options` reads;
//! - [`model`](crate::model) finds the normals that the file does not give, and makes one vertex of
//!   all corners that agree in position, texture coordinate, normal and colour.
//!
//! What the geometry needs must be right, or there is an [`ObjError`] (`obj::error`) that names file,
//! line and cause. What only the looks need may be wrong or missing: then the model has the default
//! material, a plain colour or a computed normal there, and comes with a [`Warning`] (`obj::warning`) that
//! says why. So does what a file has and the reader does not use, once for each kind.
//!
//! The statements `v`, `vt`, `vn`, `f`, `s`, `usemtl` and `mtllib` are read, and from MTL files
//! `newmtl`, `Kd`, `Ke`, `Ks`, `Ns`, `d`, `Tr`, `map_Kd`, `map_Ka`, `map_d`, `map_Ke`, `map_Ks`, `map_Bump` (or `bump`),
//! `norm` (or `map_Kn`) and `disp` (or `map_disp`). Groups and names of objects say nothing about
//! looks, and neither do the numbers of lighting models that go beyond these: they are passed over without a
//! warning.
//!
//! - Positions are read as `f64`; those of a model far from the origin are brought near
//!   ([`Model::origin`]).
//! - Three numbers behind a position are its colour, and so are ZBrush's `#MRGB` lines: sRGB, from 0 to 1
//!   or, if any number is above 1, from 0 to 255.
//! - Without `vn`, `s off` makes faces flat and `s 1` smooth with others of the group; the crease angle is
//!   for faces before the first `s`.
//! - Texture coordinates have v up in the file and v DOWN in the model: v is turned to 1 - v.
//! - The numbers of `Kd` are taken as linear light, as Blender writes them. One number stands for all
//!   three channels, as the format says. Without `Kd` the colour is 0.8 grey, or white under a texture or
//!   under colours of vertices.
//! - `map_Kd` names the picture that multiplies this colour, `map_Ka` does where it is alone. Of the options
//!   `-s`, `-o`, `-clamp` and `-mm` are used ([`TextureMapping`](crate::model::TextureMapping)). A `Kd` of
//!   0 0 0 under a picture counts as white.
//! - `Ke` is light that is sent out, times the picture of `map_Ke`.
//! - `norm` names a normal map, whose green is up. So does `map_Bump` where it looks like one, as
//!   many programs write it; other pictures there are heights, which become
//!   [normals](crate::Texture::normals_of_heights). White is as high as a 64th of the picture is wide, since the
//!   format gives no unit; `-bm` and the gain of `-mm` multiply it.
//! - Highlights have the colour `Ks` times the picture of `map_Ks`, and the exponent `Ns`. Without a picture there
//!   are none, for most programs write those numbers whatever they draw.
//! - `disp` names heights over the faces, in the model's units after `-mm` and `-bm`;
//!   [`Model::displaced`] makes geometry of them.
//! - Alpha is `d`, or 1 - `Tr` where there is no `d` (but `Tr 1` alone is opaque, as MeshLab means it), times that of the picture, times `map_d`: the alpha of
//!   that picture if it has one, else its grey. A picture whose alpha is 0 or 1 nearly everywhere cuts
//!   out ([`AlphaMode`](crate::model::AlphaMode)). A TGA file whose alpha is 0 everywhere is opaque: old
//!   programs write it so.
//! - Text may be UTF-8 or UTF-16, with any ends of lines. Names in other encodings stay apart, and their bytes
//!   lead to files.
//! - Files are found in another case of letters, with a comment or escapes in the name, by the last part of
//!   a path that leads nowhere, and a material file by the name of the OBJ file.
//! - Only regular files in the OBJ file's folder and the folders below it are opened, or those below
//!   [`Loader::with_root`]. If a name leads elsewhere, as `C:\art\wood.png` does, its last part is looked
//!   for in the folder. Nothing is written.
//! - Textures in other formats than PNG need the feature `image`. Without it they are missing, with a
//!   warning that says so.
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("square.obj");
//! use polyscan::{Framebuffer, Mesh, Model, ZBufferRenderer};
//!
//! std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")?;
//! let model = Model::load(&path)?.model;
//! for face in model.faces() {
//!     let corners: Vec<_> = face.indices.iter().map(|&i| model.vertices[i as usize]).collect();
//!     assert_eq!(corners.len(), 4);
//!     assert_eq!(corners[0].normal, glam::Vec3::Z);
//! }
//!
//! // Seen from 30 degrees to the right, each face in the colour of its material.
//! let mut frame = Framebuffer::new(320, 240, glam::Vec3::ONE)?;
//! let camera = model.camera(320.0 / 240.0).turned(30_f32.to_radians(), 0.0);
//! let vertices = model.vertices_with(camera.clip_from_object(), |vertex| vertex.uv);
//! let mut renderer = ZBufferRenderer::new(frame.viewport());
//! for (i, material) in model.materials.iter().enumerate() {
//!     let faces = Mesh::new(&vertices, model.faces_of(i));
//!     renderer.draw(&mut frame, faces, |_| material.diffuse);
//! }
//! assert_eq!(frame.color()[120 * 320 + 160], model.materials[0].diffuse);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::path::{Path, PathBuf};

use crate::model::Model;

mod limits;
mod error;
mod lines;
mod notes;
mod vertex_color;
mod geometry;
mod file;
mod warning;
mod paths;
mod map_options;
mod mtl;
mod materials;
mod read;

pub use self::error::{LineError, ObjError};
pub use self::limits::{
    MAX_CORNERS, MAX_LIBRARIES, MAX_MATERIALS, MAX_MTL_BYTES, MAX_OBJ_BYTES, MAX_TEXTURES,
    MAX_WARNINGS,
};
pub use self::warning::Warning;

/// The crease angle unless [`Loader::with_crease_angle`] sets another: 60 degrees, in radians. It
/// keeps the edges of boxes sharp, and smooths a cylinder of six sides.
pub const DEFAULT_CREASE_ANGLE: f32 = std::f32::consts::FRAC_PI_3;

/// A model, and what its files lack.
#[derive(Debug)]
#[must_use]
pub struct Loaded {
    /// The model, complete as to geometry.
    pub model: Model,
    /// What was replaced or skipped, in the order in which it was met.
    pub warnings: Vec<Warning>,
}

/// How to load a model.
///
/// ```
/// use polyscan::obj::Loader;
///
/// // Every computed normal is its face's own, unless the file says otherwise.
/// let flat = Loader::new().with_crease_angle(0.0);
/// assert!(flat.load("no-such-file.obj").is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Loader {
    crease_angle: f32,
    root: Option<PathBuf>,
}

impl Model {
    /// Loads an OBJ file with the default crease angle, [`DEFAULT_CREASE_ANGLE`]. For files of any format
    /// there is `Model::open`, which one of the other formats' features brings.
    ///
    /// # Errors
    /// As [`Loader::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        Loader::new().load(path)
    }
}

impl Default for Loader {
    fn default() -> Self {
        Self { crease_angle: DEFAULT_CREASE_ANGLE, root: None }
    }
}

impl Loader {
    /// The default loader, with the crease angle [`DEFAULT_CREASE_ANGLE`].
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the crease angle, in radians from 0 to pi.
    ///
    /// Where the file gives neither a normal nor a smoothing group, a face's normal at a corner is the
    /// mean, weighted by angle, of the faces there whose own normals are within this angle of its own. 0
    /// keeps every face flat, pi smooths every edge. Angles outside the range are clamped; NaN counts as 0.
    pub fn with_crease_angle(self, radians: f32) -> Self {
        let radians = if radians > 0.0 { radians.min(std::f32::consts::PI) } else { 0.0 };
        Self { crease_angle: radians, ..self }
    }

    /// Sets a folder above the OBJ file's below which materials and textures may lie. Names may then lead up
    /// to it, as in downloads that have a folder `source` and a folder `textures` beside it.
    ///
    /// If the OBJ file is not below the folder, it has no effect.
    pub fn with_root(self, folder: impl Into<PathBuf>) -> Self {
        Self { root: Some(folder.into()), ..self }
    }

    /// Loads an OBJ file and the files it refers to.
    ///
    /// # Errors
    /// - [`ObjError::Read`] if the file cannot be read, or has more than [`MAX_OBJ_BYTES`];
    /// - [`ObjError::Line`] for a line without which there is no geometry: a face that refers to no position,
    ///   or to one whose numbers cannot be read or are not finite; and for more than [`MAX_CORNERS`]
    ///   corners or [`MAX_MATERIALS`] materials;
    /// - [`ObjError::NoFaces`] if there is nothing to draw.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        let (model, warnings) = read::read(path.as_ref(), self.crease_angle, self.root.as_deref())?;
        Ok(Loaded { model, warnings })
    }

    /// Loads the bytes of an OBJ file, and the files it refers to.
    ///
    /// `name` stands for the file in messages, and what the text refers to is looked for beside it. The bytes
    /// may be in any of the encodings that files are.
    ///
    /// # Errors
    /// As [`load`](Self::load), but for those of reading.
    pub fn read_bytes(&self, bytes: Vec<u8>, name: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        let (name, root) = (name.as_ref(), self.root.as_deref());
        let (model, warnings) = read::read_bytes(bytes, name, self.crease_angle, root)?;
        Ok(Loaded { model, warnings })
    }
}
