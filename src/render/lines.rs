//! Lines and points as geometry: polylines, the edges of meshes, the outlines of polygons.

use std::collections::HashMap;

use crate::outline::Outline;
use crate::render::faces::FaceIndices;
use crate::render::geometry::{Batch, GeometryMemory, Mesh, Order, Submit};
use crate::render::stroke_style::{Cap, Figure, Join, LineStyle, PointStyle};
use crate::vertex::Vertex;
use crate::vertices::Vertices;

/// Lines in clip space, drawn by any renderer as polygons are: clipped before the division, their
/// parameters in perspective, each fragment with its depth (Low, "Perspective-Correct Interpolation",
/// 2002, which takes lines first).
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Lines, Vertex, ZBufferRenderer};
///
/// let zigzag = [(-0.9, 0.75), (0.4, 0.75), (-0.4, -0.75), (0.9, -0.75)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut frame = Framebuffer::new(10, 4, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// renderer.draw(&mut frame, Lines::polyline(&zigzag), |_| '#');
/// let rows: Vec<String> = frame.color().chunks(10).map(|row| row.iter().collect()).collect();
/// assert_eq!(rows, ["#######...", ".....#....", "....#.....", "..#######."]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// # Which pixels
///
/// Without a [width](Self::with_width) a line has one pixel in each column, or in each row where it is
/// higher than wide, by the diamond-exit rule of OpenGL and Direct3D, exactly: a pixel is drawn if the
/// line leaves the diamond around its centre (|dx| + |dy| < 1/2). The pixel in whose diamond the line ends
/// is left to the line that goes on from there, so a polyline draws the pixels of its joints once. A plane
/// that cuts the line, the near plane or one of [`Settings::planes`](crate::Settings::planes), moves no
/// pixel: what is on one side of it and what is on the other are the pixels of the whole line, each once.
/// A pixel has the values that the line has where it crosses the centre line of the column, or of the row.
///
/// With a width a segment is a polygon on the screen, and neighbours share the edge on which they meet, so
/// that no pixel is drawn twice, unless a segment is shorter than the width at a sharp corner. Its values
/// change along it alone and do not leave the range of its ends.
///
/// [`Fragment::face`](crate::Fragment::face) is the number of the line, counted as faces are.
///
/// # Hidden lines
///
/// A line on a face has not quite the face's depth: the centre of its pixel lies beside it. So the faces
/// are drawn first, moved back by their slope:
///
/// ```
/// use polyscan::{DepthBias, Framebuffer, Lines, Mesh, Vertex, ZBufferRenderer};
///
/// /// The edges of a mesh, each once, without those that its faces hide.
/// fn wireframe(frame: &mut Framebuffer<[u8; 4]>, vertices: &[Vertex<0>], faces: &[[u32; 4]]) {
///     let mesh = Mesh::new(vertices, faces);
///     let mut renderer = ZBufferRenderer::new(frame.viewport());
///     renderer.settings.depth_bias = DepthBias { constant: 1e-5, slope: 1.0 };
///     renderer.draw_depth(frame, mesh);
///     renderer.settings.depth_bias = DepthBias::default();
///     renderer.draw(frame, Lines::edges_of(&mesh), |_| [0, 0, 0, 255]);
/// }
/// ```
///
/// With [reversed depth](crate::DepthMode::Reversed) both numbers of the bias are negative.
#[derive(Clone, Copy, Debug)]
#[must_use = "lines are drawn by a renderer"]
pub struct Lines<S> {
    source: S,
    style: LineStyle,
}

/// One line through all vertices; see [`Lines::polyline`].
#[derive(Clone, Copy, Debug)]
pub struct Polyline<'a, const N: usize>(&'a [Vertex<N>]);

/// Lines through vertices with given indices; see [`Lines::new`].
#[derive(Clone, Copy, Debug)]
pub struct Strips<'a, L, const N: usize> {
    vertices: &'a [Vertex<N>],
    lists: L,
}

/// The contours of a polygon; see [`Lines::outline`].
#[derive(Clone, Copy, Debug)]
pub struct Contours<'a, O: ?Sized>(&'a O);

impl<'a, const N: usize> Lines<Polyline<'a, N>> {
    /// One line through all the vertices, in their order.
    pub fn polyline(vertices: &'a [Vertex<N>]) -> Self {
        Self::of(Polyline(vertices))
    }
}

impl<'a, L, const N: usize> Lines<Strips<'a, L, N>> {
    /// Lines through some of the vertices, each a list of indices as a mesh's faces are: `[u32; 2]` for
    /// single segments, or longer ones. A line with an index out of range is left out.
    pub fn new(vertices: &'a [Vertex<N>], lines: L) -> Self
    where
        L: IntoIterator<Item: FaceIndices>,
    {
        Self::of(Strips { vertices, lists: lines })
    }
}

impl<'a, const N: usize> Lines<Strips<'a, Vec<[u32; 2]>, N>> {
    /// The edges of a mesh's faces, each once: one that faces share, in either direction, is one, also if
    /// each face has vertices of its own there, in the same positions. Faces are not triangulated, so of
    /// a face with many sides these are all there are. The edges have the order in which the faces have
    /// them first.
    pub fn edges_of<F>(mesh: &Mesh<'a, F, N>) -> Self
    where
        F: Clone + IntoIterator<Item: FaceIndices>,
    {
        let (vertices, faces) = mesh.parts();
        Self::of(Strips { vertices, lists: edges(vertices, faces.clone()) })
    }
}

impl<'a, O: ?Sized> Lines<Contours<'a, O>> {
    /// The outline of a polygon, each of its contours a closed line.
    pub fn outline<const N: usize>(polygon: &'a O) -> Self
    where
        O: Outline<N>,
    {
        Self::of(Contours(polygon)).closed()
    }
}

impl<S> Lines<S> {
    fn of(source: S) -> Self {
        Self { source, style: LineStyle::THIN }
    }

    /// The same lines, each with a last segment from its last vertex to its first.
    pub fn closed(self) -> Self {
        Self { style: LineStyle { is_closed: true, ..self.style }, ..self }
    }

    /// The same lines as polygons of a width in pixels, up to 4096, instead of by the diamond-exit rule.
    /// Of a width that is not more than 0, or not a number, nothing is drawn.
    pub fn with_width(self, width: f32) -> Self {
        Self { style: LineStyle { width: Some(width), ..self.style }, ..self }
    }

    /// The same lines with another join of their segments, where they have a width: a
    /// [miter](Join::Miter) unless changed.
    pub fn with_join(self, join: Join) -> Self {
        Self { style: LineStyle { join, ..self.style }, ..self }
    }

    /// The same lines with other ends, where they have a width: [butt](Cap::Butt) unless changed.
    pub fn with_cap(self, cap: Cap) -> Self {
        Self { style: LineStyle { cap, ..self.style }, ..self }
    }
}

/// Points in clip space, one at each vertex, drawn by any renderer: one that is inside of all planes, at
/// its depth, with its own parameters.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Points, Vertex, ZBufferRenderer};
///
/// let stars = [(-0.75, 0.5), (0.5, 0.0)].map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut frame = Framebuffer::new(8, 4, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// renderer.draw(&mut frame, Points::new(&stars).with_size(2.0), |f| ['a', 'b'][f.face as usize]);
/// let rows: Vec<String> = frame.color().chunks(8).map(|row| row.iter().collect()).collect();
/// assert_eq!(rows, ["aa......", "aa...bb.", ".....bb.", "........"]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// A square point covers the pixels whose centres it covers as a polygon does: of size 1, without
/// [a size](Self::with_size), exactly one. A [round](Self::round) one covers those whose centres are
/// nearer than half its size, and in any case the pixel that it lies in.
/// [`Fragment::face`](crate::Fragment::face) is the number of the point.
#[derive(Clone, Copy, Debug)]
#[must_use = "points are drawn by a renderer"]
pub struct Points<'a, const N: usize> {
    vertices: &'a [Vertex<N>],
    style: PointStyle,
}

impl<'a, const N: usize> Points<'a, N> {
    /// A point at each vertex, of one pixel.
    pub fn new(vertices: &'a [Vertex<N>]) -> Self {
        Self { vertices, style: PointStyle { size: 1.0, is_round: false } }
    }

    /// The same points with a width and height in pixels, up to 4096. Of a size that is not more than 0,
    /// or not a number, nothing is drawn.
    pub fn with_size(self, size: f32) -> Self {
        Self { style: PointStyle { size, ..self.style }, ..self }
    }

    /// The same points, round.
    pub fn round(self) -> Self {
        Self { style: PointStyle { is_round: true, ..self.style }, ..self }
    }
}

impl<const N: usize> Submit<N> for Lines<Polyline<'_, N>> {
    fn submit(self, memory: &mut GeometryMemory<N>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let Polyline(vertices) = self.source;
        memory.faces.take_lists([vertices.len()].into_iter());
        submit_all(&vertices, memory, Figure::Lines(self.style), draw);
    }
}

impl<const N: usize, O: Outline<N> + ?Sized> Submit<N> for Lines<Contours<'_, O>> {
    fn submit(self, memory: &mut GeometryMemory<N>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let Contours(polygon) = self.source;
        let mut vertices = std::mem::take(&mut memory.vertices);
        vertices.clear();
        vertices.extend(polygon.contours().flatten());
        memory.faces.take_lists(polygon.contours().map(<[_]>::len));
        submit_all(&vertices.as_slice(), memory, Figure::Lines(self.style), draw);
        memory.vertices = vertices;
    }
}

impl<const N: usize> Submit<N> for Points<'_, N> {
    fn submit(self, memory: &mut GeometryMemory<N>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        memory.faces.take_lists([self.vertices.len()].into_iter());
        submit_all(&self.vertices, memory, Figure::Points(self.style), draw);
    }
}

/// Hands over all that there is at once.
fn submit_all<const N: usize>(
    vertices: &dyn Vertices,
    memory: &GeometryMemory<N>,
    figure: Figure,
    draw: &mut dyn FnMut(&Batch<'_>),
) {
    let (faces, order) = (&memory.faces, Order::AsGiven);
    draw(&Batch { vertices, faces, order, figure, transparent: None, is_first: true });
}

impl<const N: usize, L: IntoIterator<Item: FaceIndices>> Submit<N> for Lines<Strips<'_, L, N>> {
    fn submit(self, memory: &mut GeometryMemory<N>, most: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        let Self { source: Strips { vertices, lists }, style } = self;
        let faces = &mut memory.faces;
        faces.restart();
        let mut rest = lists.into_iter().fuse();
        let mut is_first = true;
        while faces.collect(&mut rest, most) || is_first {
            let (vertices, figure) = (&vertices, Figure::Lines(style));
            let order = Order::AsGiven;
            draw(&Batch { vertices, faces, order, figure, transparent: None, is_first });
            is_first = false;
        }
    }
}

/// The edges of faces, each once, in the order in which the faces have them first.
fn edges<const N: usize>(
    vertices: &[Vertex<N>],
    faces: impl IntoIterator<Item: FaceIndices>,
) -> Vec<[u32; 2]> {
    // Of vertices in the same position the first stands for all.
    let mut places = HashMap::with_capacity(vertices.len());
    let number_at = |(vertex, number): (&Vertex<N>, u32)| {
        *places.entry(vertex.position.to_array().map(f32::to_bits)).or_insert(number)
    };
    let places: Vec<u32> = vertices.iter().zip(0..).map(number_at).collect();
    let mut edges = Vec::new();
    for face in faces {
        let indices = face.indices();
        let Some(&last) = indices.last() else { continue };
        if indices.len() < 3 || indices.iter().any(|&i| i as usize >= vertices.len()) {
            continue;
        }
        let mut before = last;
        for &i in indices {
            let [a, b] = [before, i].map(|i| places[i as usize]);
            if a != b {
                let number = edges.len();
                edges.push(([a.min(b), a.max(b)], number, [before, i]));
            }
            before = i;
        }
    }
    edges.sort_unstable_by_key(|&(places, number, _)| (places, number));
    edges.dedup_by_key(|(places, ..)| *places);
    edges.sort_unstable_by_key(|&(_, number, _)| number);
    edges.into_iter().map(|(.., edge)| edge).collect()
}
