//! Geometry: what is drawn. A polygon, a mesh, a mesh sorted by depth, a tree; lines and points are in
//! `render::lines`.
//!
//! Each renderer draws each of them, in each of three ways: fragment by fragment, in blocks, or depth
//! alone.

use glam::{DMat4, Mat4};

use crate::outline::Outline;
use crate::render::bsp::{BspTree, Partition};
use crate::render::faces::{FaceIndices, FaceList};
use crate::render::stroke_style::Figure;
use crate::vertex::Vertex;
use crate::vertices::Vertices;

/// What a renderer can draw:
///
/// - a reference to a polygon, an [`Outline`] of one or more contours in clip space;
/// - a [`Mesh`] of vertices in clip space and faces, lists of indices;
/// - a mesh [sorted by depth](Mesh::back_to_front);
/// - a [`BspTree`], [seen through a matrix](BspTree::seen_by);
/// - [`Lines`](crate::Lines) and [`Points`](crate::Points).
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be drawn by a renderer for vertices with `{N}` parameters",
    label = "this is no geometry for vertices with {N} parameters",
    note = "draw `&polygon` (vertices or lists of vertices), `Mesh::new(&vertices, &faces)` with faces \
            such as `[u32; 3]`, `Mesh::triangles(&vertices, &indices)`, or `tree.seen_by(matrix)`; the \
            vertices and the renderer must agree in N"
)]
#[expect(private_bounds, reason = "what geometry is made of is the renderers' own business")]
pub trait Geometry<const N: usize>: Submit<N> {}

impl<const N: usize, G: Submit<N>> Geometry<N> for G {}

/// Vertices and faces to be drawn.
pub(crate) struct Batch<'a> {
    pub(crate) vertices: &'a dyn Vertices,
    pub(crate) faces: &'a FaceList,
    pub(crate) order: Order<'a>,
    /// What the faces are, if not faces.
    pub(crate) figure: Figure,
    pub(crate) transparent: Option<&'a dyn Fn(u32) -> bool>,
    /// Whether these are the first faces of the geometry.
    pub(crate) is_first: bool,
}

/// What is known of the order of faces.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Order<'a> {
    /// They are in the order in which they were given.
    AsGiven,
    /// From back to front by their depths is asked for.
    BackToFront,
    /// A tree, and the matrix that brings its planes to clip space; `None` if there is none.
    Tree(&'a Partition, Option<DMat4>),
}

/// Memory in which geometry is made ready.
#[derive(Clone, Debug)]
pub(crate) struct GeometryMemory<const N: usize> {
    pub(crate) vertices: Vec<Vertex<N>>,
    pub(crate) faces: FaceList,
}

impl<const N: usize> Default for GeometryMemory<N> {
    fn default() -> Self {
        Self { vertices: Vec::new(), faces: FaceList::default() }
    }
}

/// What can be handed over to a renderer.
pub(crate) trait Submit<const N: usize> {
    /// Calls `draw` for all faces, at most `most` at a time.
    fn submit(self, memory: &mut GeometryMemory<N>, most: usize, draw: &mut dyn FnMut(&Batch<'_>));
}

impl<const N: usize, O: Outline<N> + ?Sized> Submit<N> for &O {
    fn submit(self, memory: &mut GeometryMemory<N>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let GeometryMemory { vertices, faces } = memory;
        vertices.clear();
        vertices.extend(self.contours().flatten());
        faces.take_polygon(self.contours().map(<[_]>::len));
        let vertices = vertices.as_slice();
        draw(&Batch {
            vertices: &vertices,
            faces,
            order: Order::AsGiven,
            figure: Figure::Faces,
            transparent: None,
            is_first: true,
        });
    }
}

/// Vertices in clip space and faces, each a list of indices into them, of three or more. A face with an
/// index out of range is left out.
///
/// Drawing a mesh is much faster than drawing its faces one by one: vertices are projected once each,
/// and with the feature `parallel` all processors that `rayon` knows of take part. The picture is the
/// same.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Mesh, Vertex, ZBufferRenderer};
///
/// let vertices = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut frame = Framebuffer::new(4, 2, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// renderer.draw(&mut frame, Mesh::new(&vertices, [[0, 1, 2, 3]]), |_| '#');
/// // The same square as two triangles, in a flat list.
/// renderer.draw(&mut frame, Mesh::triangles(&vertices, &[0, 1, 2, 0, 2, 3]), |_| '#');
/// assert_eq!(frame.color(), ['#'; 8]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy)]
pub struct Mesh<'a, F, const N: usize> {
    vertices: &'a [Vertex<N>],
    faces: F,
    transparent: Option<&'a dyn Fn(u32) -> bool>,
    order: MeshOrder,
}

#[derive(Clone, Copy, Debug)]
enum MeshOrder {
    AsGiven,
    BackToFront,
}

impl<F, const N: usize> std::fmt::Debug for Mesh<'_, F, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let vertices = self.vertices.len();
        f.debug_struct("Mesh").field("vertices", &vertices).finish_non_exhaustive()
    }
}

impl<'a, F, const N: usize> Mesh<'a, F, N> {
    /// A mesh of [faces](FaceIndices), each a list of indices: an array, vector or slice of `u32`.
    pub fn new(vertices: &'a [Vertex<N>], faces: F) -> Self
    where
        F: IntoIterator<Item: FaceIndices>,
    {
        Self { vertices, faces, transparent: None, order: MeshOrder::AsGiven }
    }

    /// The vertices and the faces, taken apart.
    pub(crate) fn into_parts(self) -> (&'a [Vertex<N>], F) {
        (self.vertices, self.faces)
    }

    /// The vertices and the faces.
    pub(crate) fn parts(&self) -> (&'a [Vertex<N>], &F) {
        (self.vertices, &self.faces)
    }

    /// The same mesh, with its faces in the order of their depths: that with the farthest vertex
    /// first, of equals that with the farther mean, of equals the last. Nothing is split.
    ///
    /// This is fast, and right where polygons do not overlap in depth, such as those of a height
    /// field; small polygons of about one size come out right for the most part. It fails where a
    /// large polygon lies beside small ones, where polygons cross, and where they hide each other in
    /// a circle; the tests that Newell, Newell and Sancha (1972) go on to are left to the
    /// [`BspTree`]. The scanline renderer, which has an order for each pixel, needs none.
    #[must_use]
    pub fn back_to_front(self) -> Self {
        Self { order: MeshOrder::BackToFront, ..self }
    }

    /// Declares which faces are transparent, or may have holes, by their numbers: 0 for the first
    /// that was given. The [`ScanlineRenderer`](crate::ScanlineRenderer) draws them in their true order
    /// at each pixel; the others, which draw faces in an order, take no notice.
    #[must_use]
    pub fn with_transparent(self, is_transparent: &'a dyn Fn(u32) -> bool) -> Self {
        Self { transparent: Some(is_transparent), ..self }
    }
}

impl<'a, const N: usize> Mesh<'a, &'a [[u32; 3]], N> {
    /// A mesh of triangles, three indices after the other. One or two that are left over are none.
    #[must_use]
    pub fn triangles(vertices: &'a [Vertex<N>], indices: &'a [u32]) -> Self {
        Self::new(vertices, indices.as_chunks().0)
    }
}

impl<const N: usize, F: IntoIterator<Item: FaceIndices>> Submit<N> for Mesh<'_, F, N> {
    fn submit(self, memory: &mut GeometryMemory<N>, most: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let (order, most) = match self.order {
            MeshOrder::AsGiven => (Order::AsGiven, most),
            MeshOrder::BackToFront => (Order::BackToFront, usize::MAX),
        };
        let faces = &mut memory.faces;
        faces.restart();
        let mut rest = self.faces.into_iter().fuse();
        let mut is_first = true;
        while faces.collect(&mut rest, most) || is_first {
            let (vertices, transparent) = (&self.vertices, self.transparent);
            let figure = Figure::Faces;
            draw(&Batch { vertices, faces, order, figure, transparent, is_first });
            is_first = false;
        }
    }
}

/// A tree as a matrix brings it to clip space; from [`BspTree::seen_by`].
#[derive(Clone, Copy, Debug)]
pub struct PosedTree<'a, const N: usize> {
    tree: &'a BspTree<N>,
    clip_from_object: Mat4,
}

impl<const N: usize> BspTree<N> {
    /// The tree as `clip_from_object` brings it to clip space, each vertex as
    /// `clip_from_object * position`.
    ///
    /// A matrix without an inverse says nothing of what is far: the polygons are drawn in the order
    /// of their depths.
    #[must_use]
    pub fn seen_by(&self, clip_from_object: Mat4) -> PosedTree<'_, N> {
        PosedTree { tree: self, clip_from_object }
    }
}

impl<const N: usize> Submit<N> for PosedTree<'_, N> {
    fn submit(self, memory: &mut GeometryMemory<N>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let (tree, matrix) = (self.tree, self.clip_from_object);
        let GeometryMemory { vertices, .. } = memory;
        vertices.clear();
        vertices.extend(
            tree.vertices()
                .iter()
                .map(|vertex| Vertex { position: matrix * vertex.position, params: vertex.params }),
        );
        let planes = matrix.as_dmat4().try_inverse().map(|inverse| inverse.transpose());
        let vertices = vertices.as_slice();
        draw(&Batch {
            vertices: &vertices,
            faces: tree.face_list(),
            order: Order::Tree(tree.partition(), planes),
            figure: Figure::Faces,
            transparent: None,
            is_first: true,
        });
    }
}
