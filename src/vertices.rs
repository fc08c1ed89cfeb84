//! Vertices whose number of parameters is known at run time only.
//!
//! A user's vertices have their number of parameters in their type, which makes their code short and
//! safe. What the library does between a vertex and a pixel is the same for any number, so it is not
//! compiled again for each: it asks for vertices through [`Vertices`], many at a time, and keeps
//! parameters in lists.

use glam::Vec4;
use prefetch_index::prefetch_index;

use crate::scalar::{BATCH, PerTriangle};
use crate::vertex::Vertex;

/// A list of vertices.
pub(crate) trait Vertices: Sync {
    /// How many there are.
    fn len(&self) -> usize;

    /// The position of a vertex, and its parameters; `None` if there is no such vertex.
    fn get(&self, index: u32) -> Option<(Vec4, &[f32])>;

    /// The positions of the vertices from `first` on, as many as there is room for.
    fn copy_positions(&self, first: usize, positions: &mut [Vec4]);

    /// Copies the corners of up to [`BATCH`] triangles side by side. Indices must be in range.
    fn gather(
        &self,
        triangles: &[[u32; 3]],
        positions: &mut [PerTriangle<[f32; 4]>; 3],
        params: &mut [[PerTriangle<f32>; 3]],
    );

    /// Asks for the corners of triangles, so that they are in the cache when they are gathered.
    fn prefetch(&self, triangles: &[[u32; 3]]);
}

impl<const N: usize> Vertices for &[Vertex<N>] {
    fn len(&self) -> usize {
        (**self).len()
    }

    fn get(&self, index: u32) -> Option<(Vec4, &[f32])> {
        let vertex = <[_]>::get(self, index as usize)?;
        Some((vertex.position, &vertex.params))
    }

    fn copy_positions(&self, first: usize, positions: &mut [Vec4]) {
        for (position, vertex) in positions.iter_mut().zip(&self[first..]) {
            *position = vertex.position;
        }
    }

    fn gather(
        &self,
        triangles: &[[u32; 3]],
        positions: &mut [PerTriangle<[f32; 4]>; 3],
        params: &mut [[PerTriangle<f32>; 3]],
    ) {
        let Some(params) = params.first_chunk_mut::<N>() else { return };
        for (lane, triangle) in triangles.iter().enumerate().take(BATCH) {
            for (corner, &index) in triangle.iter().enumerate() {
                let vertex = &self[index as usize];
                positions[corner][lane] = vertex.position.to_array();
                for (param, value) in params.iter_mut().zip(&vertex.params) {
                    param[corner][lane] = *value;
                }
            }
        }
    }

    fn prefetch(&self, triangles: &[[u32; 3]]) {
        for &index in triangles.as_flattened() {
            // A vertex may reach into the cache line in which the next begins.
            prefetch_index(self, index as usize);
            prefetch_index(self, (index as usize).saturating_add(1));
        }
    }
}

/// The positions of vertices, as vertices without parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Positions<'a, const N: usize>(pub(crate) &'a [Vertex<N>]);

impl<const N: usize> Vertices for Positions<'_, N> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn get(&self, index: u32) -> Option<(Vec4, &[f32])> {
        self.0.get(index as usize).map(|vertex| (vertex.position, &[][..]))
    }

    fn copy_positions(&self, first: usize, positions: &mut [Vec4]) {
        self.0.copy_positions(first, positions);
    }

    fn gather(
        &self,
        triangles: &[[u32; 3]],
        positions: &mut [PerTriangle<[f32; 4]>; 3],
        _: &mut [[PerTriangle<f32>; 3]],
    ) {
        for (lane, triangle) in triangles.iter().enumerate().take(BATCH) {
            for (corner, &index) in triangle.iter().enumerate() {
                positions[corner][lane] = self.0[index as usize].position.to_array();
            }
        }
    }

    fn prefetch(&self, triangles: &[[u32; 3]]) {
        self.0.prefetch(triangles);
    }
}
