//! Visibility: which face is seen at each pixel, how far away, and where on the face.

use numpy::PyArray1;
use polyscan::glam::DVec4;
use polyscan::render::{FaceIndices, Product, Samples, Visibility, VisibilityRenderer};
use polyscan::{ClipSpace, Cull, DepthMode, Mesh, Settings, Vertex, Viewport};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::polygons::{PolygonArray, Polygons};
use crate::positions::{PositionArray, Positions, matrix, not_finite};
use crate::threads::work;

/// How a camera sees.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct How {
    clip_from_object: [[f64; 4]; 4],
    /// The depth of a point is the product with this.
    depth_row: [f64; 4],
    /// Whether that is the w of clip space times a number, and which.
    depth_per_w: Option<f32>,
    /// Whether clip space is -w <= z <= w.
    is_opengl: bool,
    /// Whether greater z are nearer.
    is_reversed: bool,
    /// -1 to leave out faces that show their backs, 1 their fronts, 0 none.
    cull: i8,
    /// The width and height of the whole picture.
    size: [u32; 2],
    /// What is drawn of it: left column, top row, width and height.
    tile: [u32; 4],
    layers: u32,
    /// 4, 8 or 16; or 1 for the pixel's centre.
    samples: u32,
    /// What is wanted: barycentrics, derivatives, corners.
    products: [bool; 3],
    threads: Option<usize>,
}

impl How {
    fn viewport(&self) -> Result<Viewport, String> {
        let [width, height] = self.size;
        let viewport = Viewport::new(width, height).map_err(|error| format!("size: {error}"))?;
        // At most 65536, since the tile is within the picture.
        Ok(viewport.with_corner(-(self.tile[0] as i32), -(self.tile[1] as i32)))
    }

    /// A buffer for what has to be found.
    fn buffer(&self) -> Result<Visibility, String> {
        let [_, _, width, height] = self.tile;
        let found = self.found();
        let seen = match samples(self.samples) {
            Some(samples) => Visibility::with_samples(width, height, samples, &found),
            None => Visibility::with_layers(width, height, self.layers, &found),
        };
        seen.map_err(|error| format!("size: {error}"))
    }

    /// What has to be found for what is wanted.
    fn found(&self) -> Vec<Product> {
        let [has_barycentrics, has_derivatives, has_corners] = self.products;
        let is_parallel = self.depth_per_w.is_none();
        let mut found = Vec::new();
        let mut add = |product, is_needed| {
            if is_needed {
                found.push(product);
            }
        };
        add(Product::W, !is_parallel);
        // Without w depths are those of the corners, by their weights.
        add(Product::Barycentrics, has_barycentrics || is_parallel);
        add(Product::Derivatives, has_derivatives);
        add(Product::Corners, has_corners || is_parallel);
        found
    }
}

/// The places of so many samples a pixel; `None` for its centre.
fn samples(count: u32) -> Option<Samples> {
    match count {
        4 => Some(Samples::Four),
        8 => Some(Samples::Eight),
        16 => Some(Samples::Sixteen),
        _ => None,
    }
}

/// Where samples are: two numbers each, in pixels to the right of a pixel's centre, and below it.
#[pyfunction]
pub(crate) fn sample_places(count: u32) -> Vec<[f64; 2]> {
    let places = samples(count).map_or(&[[0; 2]][..], Samples::places);
    places.iter().map(|place| place.map(|distance| f64::from(distance) / 256.0)).collect()
}

/// Brings the conventions of a camera to a renderer.
pub(crate) fn set<const N: usize>(
    settings: &mut Settings<N>,
    is_opengl: bool,
    is_reversed: bool,
    cull: i8,
) {
    if is_opengl {
        settings.clip_space = ClipSpace::MinusOneToOne;
    }
    if is_reversed {
        settings.depth = DepthMode::Reversed;
    }
    settings.cull = match cull {
        0 => Cull::None,
        1.. => Cull::Front,
        _ => Cull::Back,
    };
}

/// Flat arrays of what is seen, row by row, the layers or samples of a pixel one after the other: faces, depths, barycentrics,
/// derivatives, corners. Those that are not wanted are empty.
type Arrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<u32>>,
);

/// Finds what is seen of a mesh.
#[pyfunction]
pub(crate) fn rasterize<'py>(
    py: Python<'py>,
    vertices: &Bound<'py, PyAny>,
    faces: (Bound<'py, PyAny>, Option<Bound<'py, PyAny>>),
    how: How,
) -> PyResult<Arrays<'py>> {
    let positions = PositionArray::new(vertices)?;
    let faces = PolygonArray::new(&faces.0, faces.1.as_ref())?;
    let (positions, faces) = (positions.get()?, faces.get()?);
    let seen = work(py, how.threads, || see(positions, faces, &how))?;
    let (mut seen, depth) = seen.map_err(PyValueError::new_err)?;
    let array = |numbers: Vec<f32>| PyArray1::from_vec(py, numbers);
    let face = bytemuck::allocation::cast_vec(std::mem::take(&mut seen.face));
    let barycentrics = std::mem::take(&mut seen.barycentrics).into_flattened();
    let derivatives = std::mem::take(&mut seen.derivatives).into_flattened().into_flattened();
    let corners = std::mem::take(&mut seen.corners).into_flattened();
    Ok((
        PyArray1::from_vec(py, face),
        array(depth),
        array(barycentrics),
        array(derivatives),
        PyArray1::from_vec(py, corners),
    ))
}

/// What is seen, and its depths in the camera's unit; an error is a sentence.
fn see(
    positions: Positions<'_>,
    faces: Polygons<'_>,
    how: &How,
) -> Result<(Visibility, Vec<f32>), String> {
    let mut renderer = VisibilityRenderer::new(how.viewport()?);
    set(&mut renderer.settings, how.is_opengl, how.is_reversed, how.cull);
    let mut seen = how.buffer()?;
    let vertices = positions.in_clip_space(&matrix(how.clip_from_object)).map_err(not_finite)?;
    match faces {
        Polygons::Alike(indices, 3) => {
            draw(&mut renderer, &mut seen, &vertices, indices.as_chunks::<3>().0);
        }
        Polygons::Alike(indices, sides) => {
            draw(&mut renderer, &mut seen, &vertices, indices.chunks_exact(sides.max(1)));
        }
        Polygons::Ragged(indices, ends) => {
            let starts = std::iter::once(0).chain(ends.iter().copied());
            let face = |(start, &end): (u64, &u64)| indices.get(start as usize..end as usize);
            let faces = starts.zip(ends).map(face).map(Option::unwrap_or_default);
            draw(&mut renderer, &mut seen, &vertices, faces);
        }
    }
    drop((vertices, renderer));
    let depth = depths(&mut seen, positions, how);
    let [has_barycentrics, _, has_corners] = how.products;
    if !has_barycentrics {
        seen.barycentrics = Vec::new();
    }
    if !has_corners {
        seen.corners = Vec::new();
    }
    Ok((seen, depth))
}

fn draw<F: IntoIterator<Item: FaceIndices>>(
    renderer: &mut VisibilityRenderer,
    seen: &mut Visibility,
    vertices: &[Vertex<0>],
    faces: F,
) {
    renderer.draw(seen, Mesh::new(vertices, faces));
}

/// The depths in the camera's unit; 0 where there is no face.
fn depths(seen: &mut Visibility, positions: Positions<'_>, how: &How) -> Vec<f32> {
    let row = DVec4::from(how.depth_row);
    if let Some(per_w) = how.depth_per_w {
        let mut depth = std::mem::take(&mut seen.w);
        if per_w != 1.0 {
            depth.par_iter_mut().for_each(|depth| *depth *= per_w);
        }
        return depth;
    }
    let mut depth = std::mem::take(&mut seen.depth);
    let places = seen.corners.par_iter().zip(&seen.barycentrics).zip(&seen.face);
    depth.par_iter_mut().zip(places).for_each(|(depth, ((corners, weights), &face))| {
        let of =
            |(&i, &weight): (&u32, &f32)| row.dot(positions.get(i as usize)) * f64::from(weight);
        let is_seen = face != Visibility::NO_FACE;
        *depth =
            if is_seen { corners.iter().zip(weights).map(of).sum::<f64>() as f32 } else { 0.0 };
    });
    depth
}
