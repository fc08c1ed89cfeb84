//! Faces: polygons by the numbers of their vertices.

use numpy::{
    PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods as _,
};
use polyscan::glam::DVec3;
use pyo3::prelude::*;

use crate::positions::Positions;

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

impl<'a> Polygons<'a> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Alike(indices, sides) => indices.len() / sides.max(&1),
            Self::Ragged(_, ends) => ends.len(),
        }
    }

    /// The corners of a face; none if there is no such face.
    #[inline]
    pub(crate) fn get(&self, face: usize) -> &'a [u32] {
        let (indices, range) = match *self {
            Self::Alike(indices, sides) => (indices, face * sides..(face + 1) * sides),
            Self::Ragged(indices, ends) => {
                let end = |face: usize| ends.get(face).map_or(0, |&end| end as usize);
                let start = face.checked_sub(1).map_or(0, end);
                (indices, start..end(face))
            }
        };
        indices.get(range).unwrap_or_default()
    }

    /// The places of the three corners that a face's barycentrics refer to: of the triangles that its first corner
    /// makes with two neighbours that of the largest area.
    #[inline]
    pub(crate) fn frame(&self, face: usize, positions: &Positions<'_>) -> [u32; 3] {
        let corners = self.get(face);
        let [first, rest @ ..] = corners else { return [0; 3] };
        let (mut frame, mut most) = ([*first; 3], -1.0);
        if let [a, b] = rest {
            return [*first, *a, *b];
        }
        let place = |i: u32| positions.get(i as usize).truncate();
        let origin = place(*first);
        for pair in rest.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let area = DVec3::cross(place(a) - origin, place(b) - origin).length_squared();
            if area > most {
                (frame, most) = ([*first, a, b], area);
            }
        }
        frame
    }
}
