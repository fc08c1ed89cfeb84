//! Positions of vertices: arrays of either precision, and what a camera makes of them.

use numpy::{PyArray2, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _};
use polyscan::Vertex;
use polyscan::glam::{DMat4, DVec4, dvec4};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// An array of positions, held.
pub(crate) enum PositionArray<'py> {
    F32(PyReadonlyArray2<'py, f32>),
    F64(PyReadonlyArray2<'py, f64>),
}

/// Positions: so many numbers each, 3 (in object space) or 4 (in clip space).
#[derive(Clone, Copy)]
pub(crate) enum Positions<'a> {
    F32(&'a [f32], usize),
    F64(&'a [f64], usize),
}

impl<'py> PositionArray<'py> {
    pub(crate) fn new(array: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = array.cast::<PyArray2<f32>>() {
            return Ok(Self::F32(array.try_readonly()?));
        }
        Ok(Self::F64(array.cast::<PyArray2<f64>>()?.try_readonly()?))
    }

    pub(crate) fn get(&self) -> PyResult<Positions<'_>> {
        Ok(match self {
            Self::F32(array) => Positions::F32(array.as_slice()?, array.shape()[1]),
            Self::F64(array) => Positions::F64(array.as_slice()?, array.shape()[1]),
        })
    }
}

impl Positions<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::F32(numbers, size) => numbers.len() / size.max(&1),
            Self::F64(numbers, size) => numbers.len() / size.max(&1),
        }
    }

    /// The position with the given number, which is homogeneous; zero if there is none.
    #[inline]
    pub(crate) fn get(&self, i: usize) -> DVec4 {
        let made = |found: Option<DVec4>| found.unwrap_or(DVec4::ZERO);
        match self {
            Self::F32(numbers, 3) => made(
                numbers
                    .as_chunks()
                    .0
                    .get(i)
                    .map(|&[x, y, z]| dvec4(f64::from(x), f64::from(y), f64::from(z), 1.0)),
            ),
            Self::F32(numbers, _) => made(
                numbers.as_chunks().0.get(i).map(|position| DVec4::from(position.map(f64::from))),
            ),
            Self::F64(numbers, 3) => {
                made(numbers.as_chunks().0.get(i).map(|&[x, y, z]| dvec4(x, y, z, 1.0)))
            }
            Self::F64(numbers, _) => {
                made(numbers.as_chunks().0.get(i).map(|position| DVec4::from_array(*position)))
            }
        }
    }

    /// The vertices in clip space; or the number of the first that is not finite.
    pub(crate) fn in_clip_space(&self, clip_from_object: &DMat4) -> Result<Vec<Vertex<0>>, usize> {
        let wrong = AtomicUsize::new(usize::MAX);
        let mut vertices = Vec::new();
        let vertex = |i: usize| {
            let position = self.get(i);
            if !position.is_finite() {
                wrong.fetch_min(i, Ordering::Relaxed);
            }
            Vertex::new((*clip_from_object * position).as_vec4(), [])
        };
        (0..self.len())
            .into_par_iter()
            .with_min_len(4096)
            .map(vertex)
            .collect_into_vec(&mut vertices);
        match wrong.into_inner() {
            usize::MAX => Ok(vertices),
            wrong => Err(wrong),
        }
    }
}

/// A matrix of 4 rows of 4 numbers.
pub(crate) fn matrix(rows: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&rows).transpose()
}

/// What is wrong with a vertex that is not finite.
pub(crate) fn not_finite(vertex: usize) -> String {
    format!(
        "vertices[{vertex}] is not finite: leave out the faces that have it, and put zeros in its place"
    )
}
