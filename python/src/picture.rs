//! Pictures of models, as the tool draws them: framed, lit from both sides, antialiased.

use std::path::PathBuf;

use numpy::{PyArray1, PyReadonlyArray2};
use polyscan::color::Color as _;
use polyscan::formats::{Format, Loaded, Loader};
use polyscan::glam::{DMat4, DVec3, Mat3, Mat4, Vec2, Vec3, Vec4, vec3};
use polyscan::model::{AlphaMode, Face};
use polyscan::render::Over;
use polyscan::texture::MipFilter;
use polyscan::{
    Fragment, Framebuffer, Mesh, Model, ScanlineRenderer, Vertex, Viewport, ZBufferRenderer, record,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::polygons::{PolygonArray, Polygons};
use crate::positions::{PositionArray, Positions, matrix, not_finite};
use crate::texture::Texture;
use crate::threads::work;
use crate::visibility::set;

record! {
    /// What goes from the vertices to the pixels.
    struct Surface {
        uv: Vec2,
        normal: Vec3,
        color: Vec4,
    }
}

const N: usize = Surface::LEN;

/// How a picture is drawn.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct How {
    size: [u32; 2],
    /// What is drawn of it: left column, top row, width and height.
    tile: [u32; 4],
    /// A pixel has so many samples in x, and in y.
    samples: u32,
    /// Linear light, premultiplied by alpha.
    background: [f32; 4],
    /// In radians.
    crease: f32,
    /// Turn and height of the camera and its angle of view, in radians.
    yaw: f32,
    pitch: f32,
    field_of_view: f32,
    /// What is up, if it is not what the format says.
    up: Option<[f32; 3]>,
    /// A camera instead: its matrix, whether clip space is -w <= z <= w, and whether greater z are nearer.
    camera: Option<([[f64; 4]; 4], bool, bool)>,
    threads: Option<usize>,
}

/// A picture, four bytes a pixel, and what its file lacks.
type Picture<'py> = (Bound<'py, PyArray1<u8>>, Vec<String>);

/// The picture of a model's file.
#[pyfunction]
pub(crate) fn render_file(py: Python<'_>, path: PathBuf, how: How) -> PyResult<Picture<'_>> {
    let made = work(py, how.threads, || {
        let loaded = how.loader().load(path);
        let mut loaded = loaded.map_err(|error| format!("model: {error}"))?;
        let filter = MipFilter::Anisotropic { probes: 16 };
        let model = loaded.model.with_mip_filter(filter);
        loaded.model = model.map_err(|error| format!("model: {error}"))?;
        picture(&loaded, &how)
    })?;
    let (bytes, warnings) = made.map_err(PyValueError::new_err)?;
    Ok((PyArray1::from_vec(py, bytes), warnings))
}

/// How arrays look. All of it may be left out.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Look<'py> {
    /// sRGB and alpha, four bytes a vertex.
    colors: Option<PyReadonlyArray2<'py, u8>>,
    /// The same of faces, instead.
    face_colors: Option<PyReadonlyArray2<'py, u8>>,
    /// Texture coordinates of vertices, with v down.
    uv: Option<PyReadonlyArray2<'py, f32>>,
    texture: Option<PyRef<'py, Texture>>,
    /// Whether what is behind may be seen.
    is_glass: bool,
}

/// The same, as it lies in memory.
#[derive(Clone, Copy, Default)]
struct Parts<'a> {
    colors: Option<&'a [[u8; 4]]>,
    face_colors: Option<&'a [[u8; 4]]>,
    uv: Option<&'a [[f32; 2]]>,
}

/// The picture of a mesh.
#[pyfunction]
pub(crate) fn render_mesh<'py>(
    py: Python<'py>,
    vertices: &Bound<'py, PyAny>,
    faces: (Bound<'py, PyAny>, Option<Bound<'py, PyAny>>),
    look: Look<'py>,
    how: How,
) -> PyResult<Picture<'py>> {
    let positions = PositionArray::new(vertices)?;
    let faces = PolygonArray::new(&faces.0, faces.1.as_ref())?;
    let (positions, faces) = (positions.get()?, faces.get()?);
    let colors = look.colors.as_ref().map(|colors| colors.as_slice()).transpose()?;
    let face_colors = look.face_colors.as_ref().map(|colors| colors.as_slice()).transpose()?;
    let uv = look.uv.as_ref().map(|uv| uv.as_slice()).transpose()?;
    let parts = Parts {
        colors: colors.map(|numbers| numbers.as_chunks().0),
        face_colors: face_colors.map(|numbers| numbers.as_chunks().0),
        uv: uv.map(|numbers| numbers.as_chunks().0),
    };
    let (is_glass, texture) = (look.is_glass, look.texture.as_ref().map(|texture| texture.inner()));
    let made = work(py, how.threads, || {
        let file = ply(positions, faces, parts)?;
        let loaded = how.loader().read(&file[..], "faces");
        drop(file);
        let mut loaded = loaded.map_err(|error| error.to_string())?;
        if let Some(material) = loaded.model.materials.first_mut() {
            if let Some(texture) = texture {
                // The picture has all colours there are, and is filtered as it says.
                (material.texture, material.diffuse) = (Some(0), Vec3::ONE);
                loaded.model.textures = vec![texture.clone()];
            }
            if is_glass {
                material.alpha_mode = AlphaMode::Blend;
            }
        }
        picture(&loaded, &how)
    })?;
    let (bytes, warnings) = made.map_err(PyValueError::new_err)?;
    Ok((PyArray1::from_vec(py, bytes), warnings))
}

/// A mesh as a PLY file: the way of all meshes into a model, with normals as the tool finds them.
fn ply(positions: Positions<'_>, faces: Polygons<'_>, parts: Parts<'_>) -> Result<Vec<u8>, String> {
    let mut file = header(positions.len(), count(faces), parts).into_bytes();
    for i in 0..positions.len() {
        let position = positions.get(i);
        if !position.is_finite() {
            return Err(not_finite(i));
        }
        for number in position.truncate().to_array() {
            file.extend(number.to_le_bytes());
        }
        if let Some(colors) = parts.colors {
            file.extend(colors.get(i).unwrap_or(&[255; 4]));
        }
        if let Some(uv) = parts.uv {
            let [u, v] = uv.get(i).copied().unwrap_or_default();
            // Files have v up.
            file.extend([u, 1.0 - v].iter().flat_map(|number| number.to_le_bytes()));
        }
    }
    let mut number = 0;
    let mut add = |face: &[u32]| {
        file.extend((face.len() as u32).to_le_bytes());
        file.extend(face.iter().flat_map(|i| i.to_le_bytes()));
        if let Some(colors) = parts.face_colors {
            file.extend(colors.get(number).unwrap_or(&[255; 4]));
        }
        number += 1;
    };
    match faces {
        Polygons::Alike(indices, sides) => indices.chunks_exact(sides.max(1)).for_each(add),
        Polygons::Ragged(indices, ends) => {
            let mut start = 0;
            for end in ends.iter().map(|&end| end as usize) {
                add(indices.get(start..end).unwrap_or_default());
                start = end;
            }
        }
    }
    Ok(file)
}

fn count(faces: Polygons<'_>) -> usize {
    match faces {
        Polygons::Alike(indices, sides) => indices.len() / sides.max(1),
        Polygons::Ragged(_, ends) => ends.len(),
    }
}

/// The text of a PLY file: what its vertices and its faces have.
fn header(vertices: usize, faces: usize, parts: Parts<'_>) -> String {
    let properties = |kind: &str, names: &[&str], is_there: bool| -> String {
        let names = names.iter().filter(|_| is_there);
        names.map(|name| format!("property {kind} {name}\n")).collect()
    };
    let colors = ["red", "green", "blue", "alpha"];
    [
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n"),
        properties("double", &["x", "y", "z"], true),
        properties("uchar", &colors, parts.colors.is_some()),
        properties("float", &["s", "t"], parts.uv.is_some()),
        format!("element face {faces}\nproperty list uint uint vertex_indices\n"),
        properties("uchar", &colors, parts.face_colors.is_some()),
        "end_header\n".into(),
    ]
    .concat()
}

/// A view of a model.
struct View {
    clip_from_object: Mat4,
    /// To the right, up, and towards the camera, in the model's space.
    axes: Mat3,
}

impl How {
    fn loader(&self) -> Loader {
        Loader::new().with_crease_angle(self.crease)
    }

    fn view(&self, model: &Model, format: Format) -> View {
        if let Some((rows, is_opengl, is_reversed)) = self.camera {
            let clip_from_object = matrix(rows) * DMat4::from_translation(model.origin);
            return View::by_matrix(clip_from_object, is_opengl, is_reversed);
        }
        let default = if format == Format::Stl { Vec3::Z } else { Vec3::Y };
        let [width, height] = self.size.map(|side| side as f32);
        let camera = model
            .camera(width / height)
            .with_up(self.up.map_or(default, Vec3::from))
            .with_field_of_view(self.field_of_view)
            .turned(self.yaw, self.pitch);
        View { clip_from_object: camera.clip_from_object(), axes: camera.axes() }
    }
}

impl View {
    fn by_matrix(clip_from_object: DMat4, is_opengl: bool, is_reversed: bool) -> Self {
        let back = clip_from_object.inverse();
        let near_and_far = |z: f64| if is_opengl { 2.0 * z - 1.0 } else { z };
        let [near, far] = if is_reversed { [0.9, 0.1] } else { [0.1, 0.9] }.map(near_and_far);
        let place = |x, y, z| back.project_point3(DVec3::new(x, y, z));
        let ahead = (place(0.0, 0.0, far) - place(0.0, 0.0, near)).normalize_or(DVec3::NEG_Z);
        let right = (place(1.0, 0.0, near) - place(0.0, 0.0, near)).normalize_or(DVec3::X);
        let up = right.cross(ahead).normalize_or(DVec3::Y);
        let axes = Mat3::from_cols(right.as_vec3(), up.as_vec3(), -ahead.as_vec3());
        Self { clip_from_object: clip_from_object.as_mat4(), axes }
    }
}

/// The bytes of a model's picture, and what its files lack; an error is a sentence.
fn picture(loaded: &Loaded, how: &How) -> Result<(Vec<u8>, Vec<String>), String> {
    let Loaded { model, format, warnings } = loaded;
    let view = how.view(model, *format);
    let size = |error: polyscan::SizeError| format!("size: {error}");
    let [width, height] = how.size.map(|side| side * how.samples);
    let [left, top, wide, high] = how.tile.map(|side| side * how.samples);
    let viewport = Viewport::new(width, height).map_err(size)?;
    // At most 65536, since the tile is within the picture.
    let viewport = viewport.with_corner(-(left as i32), -(top as i32));
    let mut frame = Framebuffer::new(wide, high, how.background.into()).map_err(size)?;
    Scene::new(model, &view).draw(&mut frame, viewport, how);
    let frame = frame.downsampled(how.samples).map_err(size)?;
    Ok((frame.color().iter().flat_map(|color| color.to_srgb8()).collect(), warnings.clone()))
}

/// A model as one view of it is drawn.
struct Scene<'a> {
    model: &'a Model,
    vertices: Vec<Vertex<N>>,
    faces: Vec<Face<'a>>,
    lamp: Vec3,
}

impl<'a> Scene<'a> {
    fn new(model: &'a Model, view: &View) -> Self {
        let vertices = model.vertices_with(view.clip_from_object, |v| Surface {
            uv: v.uv,
            normal: v.normal,
            color: v.color,
        });
        // Beside the camera, above its right shoulder.
        let lamp = (view.axes * vec3(0.6, 0.7, 1.0)).normalize_or(Vec3::Z);
        Self { model, vertices, faces: model.faces().collect(), lamp }
    }

    /// The colour of a surface: lit alike from both sides, for many files have faces that are turned over.
    fn shade(&self, fragment: &Fragment<'_, N>) -> Over {
        let Surface { normal, color, .. } = fragment.params.into();
        let material = &self.model.materials[self.faces[fragment.face as usize].material];
        // The texture coordinates are the first two of the surface's values.
        let (seen, textures) = (fragment.footprint(0, 1), &self.model.textures);
        let color = material.color_at(textures, &seen, color);
        let light = 0.2 + 0.8 * normal.normalize_or_zero().dot(self.lamp).abs();
        let mut sent = color.truncate() * light;
        if material.is_emissive() {
            sent += material.emission_at(textures, &seen) * color.w;
        }
        Over(sent.extend(color.w))
    }

    fn draw(&self, frame: &mut Framebuffer<Vec4>, viewport: Viewport, how: &How) {
        let (_, is_opengl, is_reversed) = how.camera.unwrap_or_default();
        let mesh = Mesh::new(&self.vertices, &self.faces);
        let background = Vec4::from(how.background);
        if self.model.has_transparency() {
            // Glass and cut-outs in their true order, which a z-buffer does not know.
            let is_transparent = |face: u32| {
                self.model.materials[self.faces[face as usize].material].is_transparent()
            };
            let mesh = mesh.with_transparent(&is_transparent);
            let mut renderer = ScanlineRenderer::new(viewport);
            set(&mut renderer.settings, is_opengl, is_reversed, 0);
            renderer.clear(frame, background);
            renderer.draw(frame, mesh, |fragment| self.shade(fragment));
        } else {
            let mut renderer = ZBufferRenderer::new(viewport);
            set(&mut renderer.settings, is_opengl, is_reversed, 0);
            renderer.clear(frame, background);
            renderer.draw(frame, mesh, |fragment| self.shade(fragment));
        }
    }
}
