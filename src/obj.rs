//! OBJ and MTL files to polygons, materials and textures.
//!
//! What flows in is the name of an OBJ file; what flows out is a [`Model`]: vertices that are
//! transformed once each, faces that keep their sides, materials, and the textures they name. On
//! the way (`obj::read`):
//!
//! - `obj::file` reads texts, within the bounds of `obj::limits`, and `obj::lines` parts them;
//! - `obj::plain` checks the text line by line and rewrites it in the one plain form that `tobj`
//!   reads without surprise; `obj::mtl` does the same for MTL files, which it looks for at the
//!   `obj::paths` that names stand for;
//! - `tobj` parses the plain text;
//! - `obj::materials` opens the textures;
//! - [`model`](crate::model) finds the normals that the file does not give, and makes one vertex of
//!   all corners that agree in position, texture coordinate and normal.
//!
//! What the geometry needs must be right, or there is an [`ObjError`] (`obj::error`) that names file,
//! line and cause. What only the looks need may be missing: then the model has the default material or
//! a plain colour there, and comes with a [`Warning`] (`obj::warning`) that says why.
//!
//! The statements `v`, `vt`, `vn`, `f`, `usemtl` and `mtllib` are read, and from MTL files `newmtl`,
//! `Kd` and `map_Kd`. Points, lines, curves, groups, smoothing groups and vertex colours are ignored.
//!
//! - Texture coordinates have v up in the file and v DOWN in the model: v is turned to 1 - v.
//! - The numbers of `Kd` are taken as linear light, as Blender writes them. One number stands for all
//!   three channels, as the format says. Without `Kd` the colour is 0.8 grey, or white under a texture.
//! - `map_Kd` names the picture that multiplies this colour. Its options, such as `-s`, have no effect.
//! - Only regular files in the OBJ file's folder and the folders below it are opened. If a name leads
//!   elsewhere, as `C:\art\wood.png` does, its last part is looked for in the folder. Nothing is
//!   written.
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

use std::path::Path;

use crate::model::Model;

mod limits;
mod error;
mod warning;
mod file;
mod lines;
mod plain;
mod paths;
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
/// // Every computed normal is its face's own.
/// let flat = Loader::new().with_crease_angle(0.0);
/// assert!(flat.load("no-such-file.obj").is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Loader {
    crease_angle: f32,
}

impl Model {
    /// Loads an OBJ file with the default crease angle, [`DEFAULT_CREASE_ANGLE`].
    ///
    /// # Errors
    /// As [`Loader::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        Loader::new().load(path)
    }
}

impl Default for Loader {
    fn default() -> Self {
        Self { crease_angle: DEFAULT_CREASE_ANGLE }
    }
}

impl Loader {
    /// The default loader, with the crease angle [`DEFAULT_CREASE_ANGLE`].
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the crease angle, in radians from 0 to pi.
    ///
    /// Where the file gives no normal, a face's normal at a corner is the mean, weighted by angle, of
    /// the faces there whose own normals are within this angle of its own. 0 keeps every face flat,
    /// pi smooths every edge. Angles outside the range are clamped; NaN counts as 0.
    pub fn with_crease_angle(self, radians: f32) -> Self {
        let radians = if radians > 0.0 { radians.min(std::f32::consts::PI) } else { 0.0 };
        Self { crease_angle: radians }
    }

    /// Loads an OBJ file and the files it refers to.
    ///
    /// # Errors
    /// - [`ObjError::Read`] if the file cannot be read, or has more than [`MAX_OBJ_BYTES`];
    /// - [`ObjError::Line`] for a line that is wrong: a number that cannot be read or is not finite, an
    ///   index that refers to nothing, a face of fewer than three corners, more than [`MAX_CORNERS`]
    ///   corners or [`MAX_MATERIALS`] materials;
    /// - [`ObjError::NoFaces`] if there is nothing to draw.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        let (model, warnings) = read::read(path.as_ref(), self.crease_angle)?;
        Ok(Loaded { model, warnings })
    }
}
