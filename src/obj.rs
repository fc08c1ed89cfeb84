//! OBJ and MTL files to polygons, materials and textures.
//!
//! What flows in is the name of an OBJ file; what flows out is a [`Model`]: vertices that are
//! transformed once each, faces that keep their sides, materials, and the textures they name. On
//! the way:
//!
//! - `plain` checks the text line by line and rewrites it in the one plain form that `tobj` reads
//!   without surprise; `materials` does the same for MTL files and opens textures;
//! - `tobj` parses the plain text;
//! - `normals` finds the normals that the file does not give;
//! - corners that agree in position, texture coordinate and normal become one vertex.
//!
//! What the geometry needs must be right, or there is an [`ObjError`] that names file, line and
//! cause. What only the looks need may be missing: the model comes with the default material or a
//! plain colour, and with a [`Warning`] that says why.
//!
//! Read are `v`, `vt`, `vn`, `f`, `usemtl` and `mtllib`, and from MTL files `newmtl`, `Kd` and
//! `map_Kd`. Points, lines, curves, groups, smoothing groups and vertex colours are passed over.
//! Only regular files in the OBJ file's folder and the folders below it are opened: of a name that
//! leads elsewhere, such as `C:\art\wood.png`, the last part is looked for in the folder. Nothing is
//! written. Textures in other formats than PNG need the feature `image`; without it they are missing,
//! with a warning that says so.
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("square.obj");
//! use polyscan::{Framebuffer, ZBuffer, obj::Model};
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
//! let mut renderer = ZBuffer::new(frame.viewport());
//! for (i, material) in model.materials.iter().enumerate() {
//!     renderer.draw_mesh(&mut frame, &vertices, model.faces_of(i), |_| material.diffuse);
//! }
//! assert_eq!(frame.color()[120 * 320 + 160], model.materials[0].diffuse);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::HashMap;
use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{Mat4, Vec2, Vec3};

use crate::camera::{Camera, Sphere};
use crate::texture::{MAX_FILE_TEXELS, Texture, TextureError};
use crate::vertex::Vertex;

mod plain;
mod materials;
mod normals;

/// The most bytes in an OBJ file: 1 GiB.
pub const MAX_OBJ_BYTES: u64 = 1 << 30;

/// The most face corners in an OBJ file: 2^26, some 22 million triangles.
///
/// Reading takes up to about 150 bytes a corner at the worst moment (`tobj` spends 104 on the
/// smallest face, and lists grow by doubling), so this bounds memory near 10 GiB.
pub const MAX_CORNERS: u64 = 1 << 26;

/// The most bytes in the MTL files of a model together: 64 MiB.
pub const MAX_MTL_BYTES: u64 = 64 << 20;

/// The most materials that a model's MTL files may define, and that its faces may name.
pub const MAX_MATERIALS: usize = 65_536;

/// The most MTL files that are opened for one model. What they would have defined counts as unknown.
pub const MAX_LIBRARIES: usize = 1024;

/// The most texture files that are tried for one model. Together they may have as many texels as
/// one file by itself, [`MAX_FILE_TEXELS`].
pub const MAX_TEXTURES: usize = 1024;

/// The most warnings that are kept apart; the rest are counted in [`Warning::More`].
pub const MAX_WARNINGS: usize = 100;

/// The crease angle unless [`Loader::with_crease_angle`] sets another: 60 degrees, in radians. It
/// keeps the edges of boxes and smooths a cylinder of six sides.
pub const DEFAULT_CREASE_ANGLE: f32 = std::f32::consts::FRAC_PI_3;

/// A model from an OBJ file.
///
/// The indices of its faces refer to `vertices` as they were loaded: change a vertex, but leave it
/// in its place.
#[derive(Clone, Debug)]
pub struct Model {
    /// Each combination of position, normal and texture coordinate that a face has at a corner, once.
    pub vertices: Vec<ModelVertex>,
    /// The default material, then those of the MTL files in their order.
    pub materials: Vec<Material>,
    /// The pictures that materials refer to, each file once. They repeat and are filtered.
    pub textures: Vec<Texture>,
    faces: Faces,
}

/// A corner that faces share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelVertex {
    /// Position in object space, as in the file.
    pub position: Vec3,
    /// Normal in object space, of length 1.
    pub normal: Vec3,
    /// Texture coordinate with v DOWN, as [`Texture`] has it: the file's v is turned to 1 - v. (0, 0)
    /// where the file gives none.
    pub uv: Vec2,
}

/// How a face looks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// The name in the MTL file; "default" for the default material.
    pub name: String,
    /// Diffuse reflectance in linear light, 1 reflecting all.
    ///
    /// The numbers of `Kd` are taken as linear light, as Blender writes them. One number stands for
    /// all three channels, as the format says. Without `Kd` it is 0.8 grey, or white under a
    /// texture.
    pub diffuse: Vec3,
    /// Index into [`Model::textures`] of the picture that `map_Kd` names, which multiplies
    /// `diffuse`. Options of `map_Kd` such as `-s` are read past and have no effect.
    pub texture: Option<usize>,
}

impl Default for Material {
    /// The material of faces that name none: 0.8 grey, no texture.
    fn default() -> Self {
        Self::new("default", Vec3::splat(0.8))
    }
}

impl Material {
    /// A material without a texture; `diffuse` is its reflectance in linear light.
    #[must_use]
    pub fn new(name: impl Into<String>, diffuse: Vec3) -> Self {
        Self { name: name.into(), diffuse, texture: None }
    }
}

/// A polygon of a [`Model`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Face<'a> {
    /// At least three indices into [`Model::vertices`], counter-clockwise seen from outside.
    pub indices: &'a [u32],
    /// Index into [`Model::materials`].
    pub material: usize,
    /// Whether the file gives a texture coordinate at every corner.
    pub has_uv: bool,
}

/// The indices, so that whatever draws lists of indices takes faces as they are.
impl crate::render::FaceIndices for Face<'_> {
    fn indices(&self) -> &[u32] {
        self.indices
    }
}

/// Faces of any number of sides, sorted by material, in one list of indices.
#[derive(Clone, Debug, Default)]
struct Faces {
    indices: Vec<u32>,
    /// Where each face's indices end; they begin where those of the face before end.
    ends: Vec<u32>,
    has_uv: Vec<bool>,
    /// Where the faces of each material end in `ends`.
    material_ends: Vec<u32>,
}

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

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file cannot be read, or is over [`MAX_OBJ_BYTES`].
    #[error("cannot read the model {}: {source}; check its name, permissions and size", path.display())]
    Read {
        /// The OBJ file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line is wrong.
    #[error("{}:{line}: {cause}", path.display())]
    Line {
        /// The OBJ file.
        path: PathBuf,
        /// The line, counted from 1; where it is continued, the first.
        line: usize,
        /// What is wrong with it.
        #[source]
        cause: LineError,
    },
    /// No line is a face.
    #[error("{} has no faces (lines that begin with `f`): is it an OBJ file of polygons?", path.display())]
    NoFaces {
        /// The OBJ file.
        path: PathBuf,
    },
    /// `tobj` refuses what was found right here.
    #[error("{} passed every check, but tobj says: {source}; please report it", path.display())]
    Parser {
        /// The OBJ file.
        path: PathBuf,
        /// What `tobj` said.
        source: tobj::LoadError,
    },
}

/// What is wrong with a line of an OBJ or MTL file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// A word stands where a number should.
    #[error("`{word}` in a {what} is not a number: write it like 0.5 or 1e-3")]
    NotANumber {
        /// What the number belongs to.
        what: &'static str,
        /// The word, shortened if long.
        word: String,
    },
    /// A number is NaN, infinite, or too large for `f32`.
    #[error("`{word}` in a {what} is not finite: use numbers up to 3.4e38")]
    NotFinite {
        /// What the number belongs to.
        what: &'static str,
        /// The number as written.
        word: String,
    },
    /// The line ends too early.
    #[error("a {what} needs {needed} numbers, and here are {found}")]
    TooFewNumbers {
        /// What the numbers belong to.
        what: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// A face has fewer than three corners.
    #[error(
        "a face needs at least 3 corners, and here are {found}: use `l` for lines, `p` for points"
    )]
    TooFewCorners {
        /// How many there are.
        found: usize,
    },
    /// A corner cannot be read.
    #[error("`{word}` is no face corner: write v, v/vt, v//vn or v/vt/vn with whole numbers")]
    Corner {
        /// The corner, shortened if long.
        word: String,
    },
    /// An index is 0.
    #[error(
        "`{word}` has the index 0: the first {what} is 1, and the one just above the line is -1"
    )]
    ZeroIndex {
        /// What the index refers to.
        what: &'static str,
        /// The corner.
        word: String,
    },
    /// An index refers to nothing.
    #[error("a face refers to {what} {index}, but there are only {count} {}", range_of(*index))]
    IndexOutOfRange {
        /// What the index refers to.
        what: &'static str,
        /// The index as written: from 1 on, or back from -1.
        index: i64,
        /// How many there are: in the file, or above the line for a negative index.
        count: u64,
    },
    /// A name is missing.
    #[error("`{keyword}` needs a name after it")]
    NoName {
        /// The first word of the line.
        keyword: &'static str,
    },
    /// The file goes over a limit.
    #[error("more than {limit} {what}: split the model")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many are allowed.
        limit: u64,
    },
}

fn range_of(index: i64) -> &'static str {
    if index < 0 { "above the line" } else { "in the file" }
}

/// What a model's files lack. The model is there without it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// An MTL file cannot be read, or the MTL files are over [`MAX_MTL_BYTES`].
    #[error("cannot read the material file {}: {source}; its materials become the default", path.display())]
    MaterialFile {
        /// The MTL file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line of an MTL file is wrong and was skipped.
    #[error("{}:{line}: {cause}; the line is skipped", path.display())]
    MaterialLine {
        /// The MTL file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        cause: LineError,
    },
    /// Faces name a material that no MTL file defines, and got the default one.
    #[error("{}:{line}: no material file defines `{name}`; its faces get the default", path.display())]
    UnknownMaterial {
        /// The OBJ file.
        path: PathBuf,
        /// The first line that names it, counted from 1.
        line: usize,
        /// The name.
        name: String,
    },
    /// A texture is missing, broken or too large, and the material keeps its plain colour.
    #[error("the material `{material}` stays without its texture: {source}")]
    Texture {
        /// The first material that names it.
        material: String,
        /// The file and the cause.
        source: TextureError,
    },
    /// More than [`MAX_TEXTURES`] texture files are named, and the material keeps its plain colour.
    #[error(
        "the material `{material}` stays without its texture: at most {MAX_TEXTURES} are opened"
    )]
    TooManyTextures {
        /// The material.
        material: String,
    },
    /// More than [`MAX_WARNINGS`].
    #[error("{count} more warnings")]
    More {
        /// How many are not listed.
        count: usize,
    },
}

impl Model {
    /// Loads an OBJ file with the default crease angle, [`DEFAULT_CREASE_ANGLE`].
    ///
    /// # Errors
    /// As [`Loader::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        Loader::new().load(path)
    }

    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.faces.ends.len()
    }

    /// All faces, material by material, those of a material in the order of the file.
    pub fn faces(&self) -> impl Iterator<Item = Face<'_>> + Clone {
        (0..self.faces.material_ends.len()).flat_map(|material| self.faces_of(material))
    }

    /// The faces of one material, in the order of the file; none for a material that is not there.
    pub fn faces_of(&self, material: usize) -> impl Iterator<Item = Face<'_>> + Clone {
        let faces = &self.faces;
        faces.range_of(material).map(move |face| Face {
            indices: &faces.indices[range_before(&faces.ends, face)],
            material,
            has_uv: faces.has_uv[face],
        })
    }

    /// The least and the greatest coordinates of the vertices; `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let positions = self.positions();
        positions.clone().reduce(Vec3::min).zip(positions.reduce(Vec3::max))
    }

    /// A small sphere that holds all vertices; `None` if there are none. It is found anew at each call,
    /// in some milliseconds for 100,000 vertices.
    #[must_use]
    pub fn bounding_sphere(&self) -> Option<Sphere> {
        Sphere::around(self.positions())
    }

    /// A camera that sees the whole model, for pictures whose width is `aspect` times their height. It
    /// looks along the z axis, with y up, until it is [`turned`](Camera::turned).
    pub fn camera(&self, aspect: f32) -> Camera {
        let nothing = Sphere { centre: Vec3::ZERO, radius: 1.0 };
        Camera::around(self.bounding_sphere().unwrap_or(nothing), aspect)
    }

    /// The vertices as renderers take them: their positions transformed by a matrix, and with the
    /// parameters that the shader is to have.
    ///
    /// They are in the order of [`vertices`](Self::vertices), so the faces' indices fit.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("triangle.obj");
    /// # std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
    /// use glam::{Vec2, Vec3};
    /// use polyscan::{obj::Model, record};
    ///
    /// record! {
    ///     struct Surface {
    ///         uv: Vec2,
    ///         normal: Vec3,
    ///     }
    /// }
    ///
    /// let model = Model::load(&path)?.model;
    /// let clip_from_object = model.camera(4.0 / 3.0).clip_from_object();
    /// let vertices =
    ///     model.vertices_with(clip_from_object, |v| Surface { uv: v.uv, normal: v.normal });
    /// assert_eq!(vertices[0].params, [0.0, 0.0, 0.0, 0.0, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn vertices_with<P, const N: usize>(
        &self,
        clip_from_object: Mat4,
        params: impl FnMut(&ModelVertex) -> P,
    ) -> Vec<Vertex<N>>
    where
        P: Into<[f32; N]>,
    {
        let positions = self.positions().map(|position| clip_from_object * position.extend(1.0));
        let params = self.vertices.iter().map(params);
        positions.zip(params).map(|(position, params)| Vertex::new(position, params)).collect()
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> + Clone {
        self.vertices.iter().map(|vertex| vertex.position)
    }
}

impl Faces {
    fn range_of(&self, material: usize) -> Range<usize> {
        if material < self.material_ends.len() {
            range_before(&self.material_ends, material)
        } else {
            0..0
        }
    }
}

/// Item `i` of a list that is cut by `ends`.
fn range_before(ends: &[u32], i: usize) -> Range<usize> {
    let start = if i == 0 { 0 } else { ends[i - 1] };
    start as usize..ends[i] as usize
}

impl Default for Loader {
    fn default() -> Self {
        Self { crease_angle: DEFAULT_CREASE_ANGLE }
    }
}

impl Loader {
    /// The default: creases from [`DEFAULT_CREASE_ANGLE`] on.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the crease angle, in radians from 0 to pi.
    ///
    /// Where the file gives no normal, a face's normal at a corner is the mean, weighted by angle, of
    /// the faces there whose own normals are within this angle of its own. 0 keeps every face flat,
    /// pi smooths every edge. What is outside the range is clamped; NaN counts as 0.
    pub fn with_crease_angle(self, radians: f32) -> Self {
        let radians = if radians > 0.0 { radians.min(std::f32::consts::PI) } else { 0.0 };
        Self { crease_angle: radians }
    }

    /// Loads an OBJ file and what it refers to.
    ///
    /// # Errors
    /// [`ObjError::Read`] if the file cannot be read, [`ObjError::Line`] for a line that is wrong:
    /// a number that cannot be read or is not finite, an index that refers to nothing, a face of
    /// fewer than three corners, too many corners; [`ObjError::NoFaces`] if there is nothing to draw.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Loaded, ObjError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_OBJ_BYTES)
            .map_err(|source| ObjError::Read { path: path.to_owned(), source })?;
        let plain = plain::rewrite(&text).map_err(|(line, cause)| ObjError::Line {
            path: path.to_owned(),
            line,
            cause,
        })?;
        drop(text);
        if !plain.has_faces() {
            return Err(ObjError::NoFaces { path: path.to_owned() });
        }

        let refused = |source| ObjError::Parser { path: path.to_owned(), source };
        let mut warnings = Warnings::default();
        let library = materials::rewrite(path, &plain.libraries, &mut warnings);
        // Materials that tobj refuses after all do not cost the model: each that a face names is then
        // unknown, with a warning.
        let (named, indices) = tobj::load_mtl_buf(&mut library.as_bytes()).unwrap_or_default();
        for (line, name) in plain.materials() {
            if !indices.contains_key(name) {
                let (path, name) = (path.to_owned(), name.to_owned());
                warnings.add(Warning::UnknownMaterial { path, line, name });
            }
        }
        let options = tobj::LoadOptions::default();
        // The materials are at hand; for the faces it takes only their indices.
        let (meshes, _) = tobj::load_obj_buf(&mut plain.into_text().as_bytes(), &options, |_| {
            Ok((Vec::new(), indices.clone()))
        })
        .map_err(refused)?;

        let (materials, textures) = materials::open(path, named, &mut warnings);
        let (vertices, faces) = self.assemble(meshes, materials.len());
        let model = Model { vertices, materials, textures, faces };
        Ok(Loaded { model, warnings: warnings.into_list() })
    }

    /// Joins the meshes, one per material, into vertices and faces.
    fn assemble(
        &self,
        models: Vec<tobj::Model>,
        material_count: usize,
    ) -> (Vec<ModelVertex>, Faces) {
        let mut meshes: Vec<tobj::Mesh> = models.into_iter().map(|model| model.mesh).collect();
        meshes.sort_by_key(material_of);

        let mut corners = Corners::default();
        let mut ends_of = vec![0; material_count];
        for mesh in meshes {
            corners.append(&mesh);
            ends_of[material_of(&mesh)] = corners.ends.len() as u32;
        }
        // Materials without faces end where the one before them ends.
        let mut end = 0;
        for material_end in &mut ends_of {
            end = end.max(*material_end);
            *material_end = end;
        }
        normals::complete(&mut corners, self.crease_angle);
        corners.into_shared(ends_of)
    }
}

/// The place of a mesh's material in [`Model::materials`], where the default comes first.
fn material_of(mesh: &tobj::Mesh) -> usize {
    mesh.material_id.map_or(0, |id| id + 1)
}

/// All face corners, one after the other, before equal ones are joined.
#[derive(Default)]
struct Corners {
    /// Positions, each once, whether the file repeats it or not: there faces meet.
    points: Vec<Vec3>,
    /// Which point has a position of these bits.
    point_of: HashMap<[u32; 3], u32>,
    /// For each corner, its point.
    point: Vec<u32>,
    /// For each corner, the file's texture coordinate, v up; NaN where it gives none.
    uv: Vec<Vec2>,
    /// For each corner, the file's normal; zero where it gives none.
    normal: Vec<Vec3>,
    /// Where each face's corners end.
    ends: Vec<u32>,
}

impl Corners {
    fn append(&mut self, mesh: &tobj::Mesh) {
        let points: Vec<u32> = triples(&mesh.positions).map(|p| self.point_at(p)).collect();
        let normals: Vec<Vec3> = triples(&mesh.normals).collect();
        let uvs: Vec<Vec2> = mesh.texcoords.chunks_exact(2).map(Vec2::from_slice).collect();

        let mut end = self.point.len() as u32;
        self.point.extend(mesh.indices.iter().map(|&i| points[i as usize]));
        self.uv.extend(mesh.texcoord_indices.iter().map(|&i| uvs[i as usize]));
        self.normal.extend(mesh.normal_indices.iter().map(|&i| normals[i as usize]));
        if mesh.face_arities.is_empty() {
            // `tobj` leaves the list out where all are triangles.
            self.ends.extend((end..self.point.len() as u32).skip(2).step_by(3).map(|i| i + 1));
        } else {
            self.ends.extend(mesh.face_arities.iter().map(|&sides| {
                end += sides;
                end
            }));
        }
    }

    fn point_at(&mut self, position: Vec3) -> u32 {
        let next = self.points.len() as u32;
        let index = *self.point_of.entry(bits(position)).or_insert(next);
        if index == next {
            self.points.push(position);
        }
        index
    }

    /// One vertex for all corners that are alike.
    fn into_shared(self, material_ends: Vec<u32>) -> (Vec<ModelVertex>, Faces) {
        let mut vertices = Vec::new();
        let mut vertex_of = HashMap::new();
        let mut faces = Faces { material_ends, ..Faces::default() };
        faces.has_uv = (0..self.ends.len())
            .map(|face| !self.uv[range_before(&self.ends, face)].iter().any(|uv| uv.is_nan()))
            .collect();
        faces.indices = (self.point.iter().zip(&self.uv).zip(&self.normal))
            .map(|((&point, &uv), &normal)| {
                let uv = if uv.is_nan() { Vec2::ZERO } else { Vec2::new(uv.x, 1.0 - uv.y) };
                let next = vertices.len() as u32;
                *vertex_of.entry((point, bits(uv.extend(0.0)), bits(normal))).or_insert_with(|| {
                    vertices.push(ModelVertex {
                        position: self.points[point as usize],
                        normal,
                        uv,
                    });
                    next
                })
            })
            .collect();
        faces.ends = self.ends;
        (vertices, faces)
    }
}

fn triples(numbers: &[f32]) -> impl Iterator<Item = Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice)
}

/// Equal for equal vectors: adding 0 makes the two zeros one.
fn bits(v: Vec3) -> [u32; 3] {
    (v + 0.0).to_array().map(f32::to_bits)
}

/// Warnings, up to a number that a person might read.
#[derive(Default)]
struct Warnings {
    list: Vec<Warning>,
    unlisted: usize,
}

impl Warnings {
    fn add(&mut self, warning: Warning) {
        if self.list.len() < MAX_WARNINGS {
            self.list.push(warning);
        } else {
            self.unlisted += 1;
        }
    }

    fn into_list(mut self) -> Vec<Warning> {
        if self.unlisted > 0 {
            self.list.push(Warning::More { count: self.unlisted });
        }
        self.list
    }
}

/// The text of a regular file of at most `limit` bytes. Names in an old 8-bit encoding become
/// replacement characters, alike in all files.
fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    check_regular(path)?;
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has more than the {limit} bytes that are allowed"),
        ));
    }
    Ok(String::from_utf8(bytes)
        .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned()))
}

/// Devices and pipes, which might never end, are refused before they are opened.
fn check_regular(path: &Path) -> io::Result<()> {
    if std::fs::metadata(path)?.is_file() {
        Ok(())
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"))
    }
}
