//! Baking: which face is at each texel of a texture, and where on it.

use numpy::PyArray1;
use polyscan::bake::{self, Baked, Baker};
use polyscan::{Mesh, SizeError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::polygons::{PolygonArray, Polygons};
use crate::positions::{PositionArray, Positions, not_finite};
use crate::threads::work;

/// Flat arrays: the face of each texel, its weights, 3 each, and whether the face covers or touches the texel; and
/// pairs of faces that cover the same texels, with how many these are.
type Arrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<bool>>,
    Vec<[u32; 3]>,
);

/// What is at each texel.
type Texel = (i32, [f32; 3]);

/// Bakes triangles whose corners have texture coordinates (n, 2).
#[pyfunction]
pub(crate) fn bake_weights<'py>(
    py: Python<'py>,
    uv: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    size: [u32; 2],
    margin: u32,
    threads: Option<usize>,
) -> PyResult<Arrays<'py>> {
    let uv = PositionArray::new(uv)?;
    let faces = PolygonArray::new(faces, None)?;
    let (uv, faces) = (uv.get()?, faces.get()?);
    let Polygons::Alike(indices, _) = faces else {
        return Err(PyValueError::new_err("faces must be triangles"));
    };
    let baked = work(py, threads, || baked(uv, indices, size, margin))?;
    let Baked { texels, overlaps, .. } = baked.map_err(PyValueError::new_err)?;
    let (texels, depths) = texels.into_parts();
    let overlaps = overlaps.iter().map(|overlap| {
        let [first, second] = overlap.faces;
        [first, second, overlap.texels]
    });
    Ok((
        PyArray1::from_vec(py, texels.iter().map(|(face, _)| *face).collect()),
        PyArray1::from_vec(py, texels.iter().flat_map(|(_, weights)| *weights).collect()),
        PyArray1::from_vec(py, depths.iter().map(|&depth| depth < 1.0).collect()),
        overlaps.collect(),
    ))
}

/// The faces and weights at texels; an error is a sentence.
fn baked(
    uv: Positions<'_>,
    indices: &[u32],
    [width, height]: [u32; 2],
    margin: u32,
) -> Result<Baked<Texel>, String> {
    let size = |error: SizeError| format!("size: {error}");
    // Corners of their own, each of which weighs 1 at itself.
    let weights = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    let mut corners = Vec::with_capacity(indices.len());
    for (&i, weights) in indices.iter().zip(weights.iter().cycle()) {
        let place = uv.get(i as usize);
        if !place.is_finite() {
            return Err(not_finite(i as usize).replace("vertices", "uv"));
        }
        corners.push(bake::vertex(place.truncate().truncate().as_vec2(), *weights));
    }
    let numbers: Vec<u32> = (0..corners.len() as u32).collect();
    let mesh: Mesh<'_, &[[u32; 3]], 2> = Mesh::triangles(&corners, &numbers);
    let mut baker = Baker::<2>::new(width, height).map_err(size)?;
    baker.margin = margin;
    let texel = |face: u32, [a, b]: [f32; 2]| (face as i32, inside([a, b, 1.0 - a - b]));
    baker.bake(mesh, (-1, [0.0; 3]), |fragment| texel(fragment.face, fragment.params)).map_err(size)
}

/// Weights within a face, although a texel's centre may lie outside by 1/256 texel.
fn inside(weights: [f32; 3]) -> [f32; 3] {
    let weights = weights.map(|weight| weight.max(0.0));
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
