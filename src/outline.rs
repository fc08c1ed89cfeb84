//! Outlines: the contours that bound a polygon, and the chains that clipping makes of them.
//!
//! A polygon has one contour, or several: holes, islands in them, separate parts. Each contour is
//! closed by an edge from its last vertex to its first; it may be concave, and contours may cross
//! themselves and each other. How often they wind around a point says whether it is inside, by a
//! [`FillRule`](crate::FillRule).
//!
//! A winding number is a sum over edges, to which their order is of no importance. So what is left
//! of an outline after clipping is not put in order either: it is a set of [`Chain`]s, each with
//! the number of times that it counts.

use crate::vertex::Vertex;

/// The contours of one polygon.
///
/// One contour is a list of vertices; several are a list of such lists:
///
/// ```
/// use glam::vec4;
/// use polyscan::{Outline, Vertex};
///
/// let square = |size: f32| {
///     [(-size, -size), (size, -size), (size, size), (-size, size)]
///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]))
/// };
/// let (outer, hole) = (square(0.8), square(0.4));
/// assert_eq!(outer.contours().count(), 1);
/// assert_eq!([outer, hole].contours().count(), 2);
/// assert_eq!([&outer[..], &hole[..3]].contours().count(), 2);
/// assert_eq!(vec![outer.to_vec(), hole.to_vec()].contours().count(), 2);
/// ```
///
/// All contours are taken to lie in one plane. A contour of fewer than three vertices bounds
/// nothing and is passed over.
pub trait Outline<const N: usize> {
    /// The contours, in any order; each in either direction.
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]>;
}

/// One contour of an [`Outline`]: a list of vertices with `N` parameters each.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a contour of vertices with `{N}` parameters",
    label = "neither a vertex with {N} parameters nor a contour of them",
    note = "the vertices and the renderer or scan converter must have the same number of parameters, \
            here `{N}`"
)]
pub trait Contour<const N: usize> {
    /// The vertices, in the order in which the contour runs.
    fn vertices(&self) -> &[Vertex<N>];
}

impl<const N: usize> Contour<N> for [Vertex<N>] {
    fn vertices(&self) -> &[Vertex<N>] {
        self
    }
}

impl<const N: usize, const K: usize> Contour<N> for [Vertex<N>; K] {
    fn vertices(&self) -> &[Vertex<N>] {
        self
    }
}

impl<const N: usize> Contour<N> for Vec<Vertex<N>> {
    fn vertices(&self) -> &[Vertex<N>] {
        self
    }
}

impl<const N: usize, C: Contour<N> + ?Sized> Contour<N> for &C {
    fn vertices(&self) -> &[Vertex<N>] {
        (**self).vertices()
    }
}

impl<const N: usize> Outline<N> for [Vertex<N>] {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        std::iter::once(self)
    }
}

impl<const N: usize, const K: usize> Outline<N> for [Vertex<N>; K] {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        std::iter::once(self.as_slice())
    }
}

impl<const N: usize> Outline<N> for Vec<Vertex<N>> {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        std::iter::once(self.as_slice())
    }
}

impl<const N: usize, C: Contour<N>> Outline<N> for [C] {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        self.iter().map(Contour::vertices)
    }
}

impl<const N: usize, C: Contour<N>, const K: usize> Outline<N> for [C; K] {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        self.as_slice().contours()
    }
}

impl<const N: usize, C: Contour<N>> Outline<N> for Vec<C> {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        self.as_slice().contours()
    }
}

impl<const N: usize, O: Outline<N> + ?Sized> Outline<N> for &O {
    #[inline]
    fn contours(&self) -> impl Iterator<Item = &[Vertex<N>]> {
        (**self).contours()
    }
}

/// A polygonal chain: consecutive vertices of a list, joined by edges, and how often they count.
///
/// A list of chains shares a list of vertices: the first chain has the vertices up to its `end`,
/// the next one those from there on. A chain is open; a closed contour is one whose last vertex
/// repeats its first. All chains of an outline together are closed: in every place as many end as
/// begin, with their winding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// One past the index of its last vertex.
    pub end: usize,
    /// How often the chain is run through; negative if that is against its direction.
    pub winding: i32,
}
