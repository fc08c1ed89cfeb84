//! Faces: polygons by the numbers of their vertices.

use numpy::{
    PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;

/// Arrays of faces, held: of as many corners each, or of the corners of all and where each face ends.
pub(crate) enum PolygonArray<'py> {
    Alike(PyReadonlyArray2<'py, u32>),
    Ragged(PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u64>),
}

/// Faces.
#[derive(Clone, Copy)]
pub(crate) enum Polygons<'a> {
    /// The corners of all, and how many each has.
    Alike(&'a [u32], usize),
    /// The corners of all, and where each ends.
    Ragged(&'a [u32], &'a [u64]),
}

impl<'py> PolygonArray<'py> {
    pub(crate) fn new(
        indices: &Bound<'py, PyAny>,
        ends: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        Ok(match ends {
            None => Self::Alike(indices.cast::<PyArray2<u32>>()?.try_readonly()?),
            Some(ends) => Self::Ragged(
                indices.cast::<PyArray1<u32>>()?.try_readonly()?,
                ends.cast::<PyArray1<u64>>()?.try_readonly()?,
            ),
        })
    }

    pub(crate) fn get(&self) -> PyResult<Polygons<'_>> {
        Ok(match self {
            Self::Alike(indices) => Polygons::Alike(indices.as_slice()?, indices.shape()[1]),
            Self::Ragged(indices, ends) => Polygons::Ragged(indices.as_slice()?, ends.as_slice()?),
        })
    }
}
