//! The painter's renderer: polygons are drawn from back to front, each over what is there.
//!
//! It needs no depth, and blends as light does: what is transparent is drawn after all that is seen
//! through it. The order comes from a [`BspTree`], which splits polygons where no order exists
//! (Fuchs, Kedem and Naylor 1980), or, fast and not always right, from the polygons' depths.
//!
//! # Which side of a plane is far
//!
//! Let q be a plane in clip space, a linear form on (x, y, z, w) that is positive on its front. At the
//! point (X, Y) of the screen, in normalised device coordinates, all that is visible has the position
//! w (X, Y, d, 1) with w > 0 and d = z/w, and is on the plane's front where
//!
//! ```text
//! q_x X + q_y Y + q_z d + q_w > 0.
//! ```
//!
//! Going to greater d at the same point leads from back to front if q_z > 0, from front to back if
//! q_z < 0. So where smaller depth is nearer, the front is far if q_z > 0, and where greater depth is
//! nearer, if q_z < 0. No eye is asked for: this holds in perspective, for w > 0 in front of the eye,
//! and in orthographic projections, for any range of depth, finite or infinite. If q_z = 0 the plane
//! is seen edge-on, its two sides share no pixel, and either may be first.
//!
//! A matrix M that brings points p to clip space brings planes q, with q p = (q M^-1) (M p), to
//! q M^-1. Its z is the product of q and M^-1 (0, 0, 1, 0), the point where x = y = w = 0: that is the
//! eye of a perspective matrix, and an orthographic one's direction of view, at infinity.
//!
//! # Pieces
//!
//! A piece of a split polygon keeps the outline and the parameters of the whole, and leaves out the
//! pixels that are on the wrong side of its cuts. On the polygon, the left side of the inequality
//! above is the product of q and the position, divided by w: like depth it is affine on the screen.
//! So in each row it changes its sign at one column, which is computed in f64 from polygon, plane and
//! row alone. Both sides of the cut find the same column, hence the pieces have the pixels of the
//! whole, each once, and the same fragments to the bit. Their outlines meet no new vertex whose
//! rounding would open a gap to a neighbour that is not split.

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use fearless_simd::{Level, Simd, dispatch};
use glam::{DMat4, DVec4, Mat4};

use crate::clip::{ClipSpace, ClipVertex, W_MIN};
use crate::edge_table::first_centre;
use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::gradient::Gradient;
use crate::polygon::widest_triangle;
use crate::project::{FixedPoint, Projection, Rect, ScreenVertex, Viewport};
use crate::render::bsp::{BspTree, FaceList, Group, NONE, Piece};
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::raster::Raster;
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;
use crate::render::shader::{Paint, PerBlock, PerFragment, Shader};
use crate::render::z_buffer::{DepthSource, DepthTest};
use crate::scan::{ScanConverter, Spans};
use crate::span::Span;
use crate::vertex::Vertex;

/// Rows in a band, the part of the framebuffer that one thread draws.
const BAND: u32 = 32;

/// Draws polygons into a framebuffer, from back to front.
///
/// What it is for is transparency: every pixel's polygons are blended in their true order, also where
/// they cross, to the pixel. For opaque polygons it gives the picture of the
/// [z-buffer](crate::ZBuffer), to the bit except where surfaces meet within 1/512 pixel of a pixel's
/// centre, and takes some four times as long, and longer the more polygons lie behind each other,
/// since all of them are shaded.
///
/// ```
/// use glam::{Mat4, Vec4, vec4};
/// use polyscan::{BspTree, Framebuffer, Painter, Vertex, render::Over};
///
/// // Two panes of glass that cross in the middle of the picture: the red one, the even vertices, is
/// // in front on the left, the blue one on the right.
/// let vertices: Vec<_> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| [vec4(x, y, 0.5 + 0.4 * x, 1.0), vec4(x, y, 0.5 - 0.4 * x, 1.0)])
///     .as_flattened()
///     .iter()
///     .map(|&position| Vertex::new(position, []))
///     .collect();
/// let tree = BspTree::new(&vertices, [[0, 2, 4, 6], [1, 3, 5, 7]]);
///
/// let mut frame = Framebuffer::new(64, 48, Vec4::W)?;
/// let mut painter = Painter::new(frame.viewport());
/// painter.draw(&mut frame, &tree, Mat4::IDENTITY, |fragment| match fragment.face {
///     0 => Over(vec4(0.5, 0.0, 0.0, 0.5)),
///     _ => Over(vec4(0.0, 0.0, 0.5, 0.5)),
/// });
/// assert_eq!(frame.pixel(31, 20).map(|(color, _)| color), Some(vec4(0.5, 0.0, 0.25, 1.0)));
/// assert_eq!(frame.pixel(32, 20).map(|(color, _)| color), Some(vec4(0.25, 0.0, 0.5, 1.0)));
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Painter<const N: usize> {
    /// Where and how polygons are scan-converted: viewport, scissor, culling, interpolation.
    pub scan: ScanConverter<N>,
    /// Whether greater depth, as it would be stored in the framebuffer, is nearer: for reversed
    /// depth, where a z-buffer tests with [`DepthTest::Greater`].
    pub reversed_depth: bool,
    /// Whether the depth of a fragment that is drawn is stored. It is never compared.
    pub depth_write: bool,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub level: Level,
    vertices: Vec<Vertex<N>>,
    face_list: FaceList,
    order: Vec<Piece>,
    keys: Vec<([f64; 2], Piece)>,
    bins: Vec<Vec<Piece>>,
    workers: Vec<Worker<N>>,
}

impl<const N: usize> Painter<N> {
    /// A renderer to a viewport, with the settings of [`ScanConverter::new`], for which smaller depth
    /// is nearer and which stores none.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            scan: ScanConverter::new(viewport),
            reversed_depth: false,
            depth_write: false,
            level: Level::new(),
            vertices: Vec::new(),
            face_list: FaceList::default(),
            order: Vec::new(),
            keys: Vec::new(),
            bins: Vec::new(),
            workers: Vec::new(),
        }
    }

    /// Draws a tree from back to front, as `clip_from_object` brings it to clip space, each vertex as
    /// `clip_from_object * position`. `shader` is called for all fragments; see
    /// [`ZBuffer::draw`](crate::ZBuffer::draw) for what it may return.
    ///
    /// Polygons that cross, and those that hide each other in a circle, come out right. Of polygons in
    /// one plane the last is drawn first, so the first is seen, as with [`DepthTest::Less`].
    ///
    /// With the feature `parallel` all processors that `rayon` knows of take part; the picture is the
    /// same.
    ///
    /// A matrix without an inverse says nothing of what is far: the polygons are drawn in the order
    /// of [`draw_sorted`](Self::draw_sorted).
    pub fn draw<C, R>(
        &mut self,
        frame: &mut Framebuffer<C>,
        tree: &BspTree<N>,
        clip_from_object: Mat4,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) where
        C: Copy + Send,
        R: Paint<C>,
    {
        self.draw_tree(frame, tree, clip_from_object, &PerFragment(shader));
    }

    /// Draws a tree by a shader of [`LANES`] pixels at a time, as
    /// [`ZBuffer::draw_blocks`](crate::ZBuffer::draw_blocks) does a polygon.
    pub fn draw_blocks<C: Copy + Send>(
        &mut self,
        frame: &mut Framebuffer<C>,
        tree: &BspTree<N>,
        clip_from_object: Mat4,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        self.draw_tree(frame, tree, clip_from_object, &PerBlock(shader));
    }

    /// Draws the faces of a mesh in clip space, each a list of indices into `vertices`, from back to
    /// front, by a tree that is built for this picture alone. Building it takes much longer than
    /// drawing; for more than one picture of a mesh keep a [`BspTree`] and [`draw`](Self::draw) it.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{Framebuffer, Painter, Vertex};
    ///
    /// // A triangle in front, and one behind it that is given later.
    /// let vertices: Vec<_> = [0.25, 0.75]
    ///     .map(|z| [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)].map(|(x, y)| vec4(x, y, z, 1.0)))
    ///     .as_flattened()
    ///     .iter()
    ///     .map(|&position| Vertex::new(position, []))
    ///     .collect();
    /// let mut frame = Framebuffer::new(4, 2, 9)?;
    /// let mut painter = Painter::new(frame.viewport());
    /// painter.draw_mesh(&mut frame, &vertices, [[0, 1, 2], [3, 4, 5]], |f| f.face);
    /// assert_eq!(frame.color(), [0, 9, 9, 9, 0, 0, 0, 9]);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn draw_mesh<C, R, F>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) where
        C: Copy + Send,
        R: Paint<C>,
        F: AsRef<[u32]>,
    {
        let tree = BspTree::new(vertices, faces);
        self.draw_as_it_is(frame, &tree, &PerFragment(shader));
    }

    /// Draws a mesh by a shader of blocks, as [`draw_blocks`](Self::draw_blocks) does a tree.
    pub fn draw_mesh_blocks<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        let tree = BspTree::new(vertices, faces);
        self.draw_as_it_is(frame, &tree, &PerBlock(shader));
    }

    /// Draws the faces of a mesh in clip space in the order of their depths: that with the farthest
    /// vertex first, of equals that with the farther mean, of equals the last. Nothing is split.
    ///
    /// This is fast, and right where polygons do not overlap in depth, such as those of a height
    /// field; small polygons of about one size come out right for the most part. It fails where a
    /// large polygon lies beside small ones, where polygons cross, and where they hide each other in
    /// a circle; the tests that Newell, Newell and Sancha (1972) go on to are left to the tree. It is
    /// called like [`draw_mesh`](Self::draw_mesh).
    pub fn draw_sorted<C, R, F>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) where
        C: Copy + Send,
        R: Paint<C>,
        F: AsRef<[u32]>,
    {
        self.draw_by_depth(frame, vertices, faces, &PerFragment(shader));
    }

    /// Draws a mesh in the order of its depths by a shader of blocks.
    pub fn draw_sorted_blocks<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        self.draw_by_depth(frame, vertices, faces, &PerBlock(shader));
    }

    fn draw_tree<C: Copy + Send>(
        &mut self,
        frame: &mut Framebuffer<C>,
        tree: &BspTree<N>,
        clip_from_object: Mat4,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let mut vertices = std::mem::take(&mut self.vertices);
        vertices.clear();
        vertices.extend(tree.vertices.iter().map(|vertex| Vertex {
            position: clip_from_object * vertex.position,
            params: vertex.params,
        }));
        if let Some(object_from_clip) = clip_from_object.as_dmat4().try_inverse() {
            self.draw_ordered(frame, tree, object_from_clip.transpose(), &vertices, shader);
        } else {
            let faces = (0..tree.faces() as u32).map(|face| tree.face_list.get(face));
            self.draw_by_depth(frame, &vertices, faces, shader);
        }
        self.vertices = vertices;
    }

    /// Draws a tree that is in clip space.
    fn draw_as_it_is<C: Copy + Send>(
        &mut self,
        frame: &mut Framebuffer<C>,
        tree: &BspTree<N>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        self.draw_ordered(frame, tree, DMat4::IDENTITY, &tree.vertices, shader);
    }

    /// Draws a tree in its order; `planes` brings its planes to clip space, where `vertices` are.
    fn draw_ordered<C: Copy + Send>(
        &mut self,
        frame: &mut Framebuffer<C>,
        tree: &BspTree<N>,
        planes: DMat4,
        vertices: &[Vertex<N>],
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let depths = Depths { nearest: self.nearest(), vertices };
        let (order, keys) = (&mut self.order, &mut self.keys);
        order.clear();
        let towards_z = planes.row(2);
        let is_front_far = |plane: DVec4| (plane.dot(towards_z) > 0.0) != (depths.nearest > 0.0);
        tree.back_to_front(is_front_far, |group| match group {
            Group::Coplanar(pieces) => order.extend(pieces.iter().rev()),
            Group::Unordered(pieces) => {
                keys.clear();
                keys.extend(pieces.iter().map(|&p| (depths.key(tree.face_list.get(p.face)), p)));
                order.extend(sorted(keys));
            }
        });
        let cuts = |piece| tree.cuts(piece).map(|(plane, front)| (planes * plane, front));
        self.draw_in_order(frame, vertices, &tree.face_list, cuts, shader);
    }

    fn draw_by_depth<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let mut face_list = std::mem::take(&mut self.face_list);
        face_list.collect(faces);
        let depths = Depths { nearest: self.nearest(), vertices };
        self.keys.clear();
        self.keys.extend(
            (0..face_list.len() as u32)
                .map(|face| (depths.key(face_list.get(face)), Piece { face, cut: NONE })),
        );
        self.order.clear();
        self.order.extend(sorted(&mut self.keys));
        self.draw_in_order(frame, vertices, &face_list, |_| std::iter::empty(), shader);
        self.face_list = face_list;
    }

    /// The z/w of the view volume that is nearest.
    fn nearest(&self) -> f64 {
        let [near, far] = self.scan.viewport.depth();
        let is_least = self.reversed_depth == (near > far);
        match self.scan.clip_space {
            _ if !is_least => 1.0,
            ClipSpace::ZeroToOne => 0.0,
            ClipSpace::MinusOneToOne => -1.0,
        }
    }

    /// Draws the pieces of [`order`](Self::order), each without what is on the wrong side of its
    /// cuts: planes in clip space, and whether the piece is on their front.
    fn draw_in_order<C: Copy + Send, I: Iterator<Item = (DVec4, bool)>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: &FaceList,
        cuts: impl Fn(Piece) -> I + Sync,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let (level, width) = (self.level, frame.width());
        if self.scan.window(frame.rect()).iter().any(Range::is_empty) {
            return;
        }
        let raster =
            Raster { test: DepthTest::Always, write: self.depth_write, source: DepthSource::Z };
        let bands = frame.height().div_ceil(BAND) as usize;
        self.bin(vertices, faces, bands);
        self.workers.resize_with(bands.max(self.workers.len()), || Worker::new(&self.scan));
        self.workers.iter_mut().for_each(|worker| worker.scan.adopt(&self.scan));
        let job = Job { level, raster, width, vertices, faces };
        let workers = self.workers[..bands].par_iter_mut().zip(self.bins[..bands].par_iter_mut());
        frame.par_bands(BAND).zip(workers).for_each(|(mut band, (worker, pieces))| {
            job.draw(&mut band, worker, pieces, &cuts, shader);
        });
    }

    /// Sorts the pieces into bins, one a band, that keep their order.
    fn bin(&mut self, vertices: &[Vertex<N>], faces: &FaceList, bands: usize) {
        self.bins.resize_with(bands.max(self.bins.len()), Vec::new);
        self.bins.iter_mut().for_each(Vec::clear);
        let Rect { y: corner, .. } = self.scan.viewport.rect();
        for piece in &self.order {
            let Some([first, end]) = rows(faces.get(piece.face), vertices, &self.scan) else {
                continue;
            };
            let band = |row: i32| (row + corner).max(0) as usize / BAND as usize;
            let touched = band(first)..(band(end) + 1).min(bands);
            self.bins.get_mut(touched).into_iter().flatten().for_each(|bin| bin.push(*piece));
        }
    }
}

/// The first and the last row that a face may cover, relative to the viewport, within those to
/// visit; `None` if there are none.
fn rows<const N: usize>(
    face: &[u32],
    vertices: &[Vertex<N>],
    scan: &ScanConverter<N>,
) -> Option<[i32; 2]> {
    let mut rows = [i32::MAX, i32::MIN];
    for &i in face {
        let position = vertices.get(i as usize)?.position.as_dvec4();
        if !position.is_finite() {
            return None;
        }
        if position.w < W_MIN {
            rows = [i32::MIN / 2, i32::MAX / 2];
            continue;
        }
        // Clipping may round across one row.
        let row = first_centre(FixedPoint::project(position, &scan.viewport).y);
        rows = [rows[0].min(row - 1), rows[1].max(row + 1)];
    }
    let [_, visible] = scan.window(scan.viewport.rect());
    let (first, last) = (rows[0].max(visible.start), rows[1].min(visible.end - 1));
    (first <= last).then_some([first, last])
}

/// The pieces by their keys, the greatest first, of equals the last first.
fn sorted(keys: &mut [([f64; 2], Piece)]) -> impl Iterator<Item = Piece> {
    keys.sort_by(|([a, b], _), ([c, d], _)| a.total_cmp(c).then(b.total_cmp(d)));
    keys.iter().rev().map(|(_, piece)| *piece)
}

/// The depths of faces in clip space.
struct Depths<'a, const N: usize> {
    /// The z/w of the view volume that is nearest; if it is 1, greater ones are nearer.
    nearest: f64,
    vertices: &'a [Vertex<N>],
}

impl<const N: usize> Depths<'_, N> {
    /// What grows with a face's distance: that of its farthest vertex, and the mean.
    fn key(&self, face: &[u32]) -> [f64; 2] {
        let distance = |&i: &u32| {
            let position =
                self.vertices.get(i as usize).map_or(DVec4::W, |v| v.position.as_dvec4());
            let z = if position.w >= W_MIN { position.z / position.w } else { self.nearest };
            let z = z.clamp(-1.0, 1.0);
            if self.nearest > 0.0 { self.nearest - z } else { z - self.nearest }
        };
        let [farthest, sum] = face.iter().map(distance).fold([0.0, 0.0], |[farthest, sum], d| {
            [if d > farthest { d } else { farthest }, sum + d]
        });
        [farthest, sum / face.len().max(1) as f64]
    }
}

/// The memory for drawing one band.
#[derive(Clone, Debug)]
struct Worker<const N: usize> {
    scan: ScanConverter<N>,
    polygon: Vec<Vertex<N>>,
    outline: Vec<ScreenVertex<0>>,
    lines: Vec<Dividing>,
}

impl<const N: usize> Worker<N> {
    fn new(scan: &ScanConverter<N>) -> Self {
        Self {
            scan: ScanConverter::new(scan.viewport),
            polygon: Vec::new(),
            outline: Vec::new(),
            lines: Vec::new(),
        }
    }
}

/// A picture being drawn: everything that is only read.
struct Job<'a, const N: usize> {
    level: Level,
    raster: Raster,
    width: u32,
    vertices: &'a [Vertex<N>],
    faces: &'a FaceList,
}

impl<const N: usize> Job<'_, N> {
    /// Draws pieces in a band.
    fn draw<C: Copy, I: Iterator<Item = (DVec4, bool)>>(
        &self,
        band: &mut Band<'_, C>,
        worker: &mut Worker<N>,
        pieces: &[Piece],
        cuts: &impl Fn(Piece) -> I,
        shader: &impl Shader<N, C>,
    ) {
        let rows = band.rows();
        let bounds = Rect { x: 0, y: rows.start, width: self.width, height: rows.len() as u32 };
        dispatch!(self.level, simd => for piece in pieces {
            self.draw_piece(simd, band, bounds, worker, (*piece, cuts), shader);
        });
    }

    #[inline(always)]
    fn draw_piece<S: Simd, C: Copy, I: Iterator<Item = (DVec4, bool)>>(
        &self,
        simd: S,
        band: &mut Band<'_, C>,
        bounds: Rect,
        worker: &mut Worker<N>,
        (piece, cuts): (Piece, &impl Fn(Piece) -> I),
        shader: &impl Shader<N, C>,
    ) {
        let Worker { scan, polygon, outline, lines } = worker;
        polygon.clear();
        // A face with an index out of range is in no bin.
        let corner = |&i: &u32| self.vertices.get(i as usize);
        polygon.extend(self.faces.get(piece.face).iter().filter_map(corner));
        let viewport = scan.viewport;
        let (spans, vertices) = scan.face_within(piece.face, polygon, bounds);
        if piece.cut == NONE {
            self.raster.draw(simd, spans, band, shader);
            return;
        }
        project(vertices, &viewport, outline);
        lines.clear();
        lines.extend(
            cuts(piece).filter_map(|(plane, front)| Dividing::new(plane, front, vertices, outline)),
        );
        within(spans, lines).for_each(|span| self.raster.draw_any(simd, span, band, shader));
    }
}

/// The parts of spans that are on the right sides of all lines.
#[inline(always)]
fn within<'a, const N: usize>(
    spans: Spans<'a, N>,
    lines: &[Dividing],
) -> impl Iterator<Item = Span<'a, N>> {
    let Spans { polygon, runs, columns } = spans;
    runs.filter_map(move |run| {
        let intersect = |columns: Range<i32>, line: &Dividing| {
            let side = line.columns(run.y);
            columns.start.max(side.start)..columns.end.min(side.end)
        };
        let columns = lines.iter().fold(columns.clone(), intersect);
        Span::new(polygon, &run, &columns)
    })
}

/// The places of clipped vertices on the screen, not rounded.
fn project<const N: usize>(
    vertices: &[ClipVertex<N>],
    viewport: &Viewport,
    outline: &mut Vec<ScreenVertex<0>>,
) {
    let clip_space = ClipSpace::default();
    let projection = Projection::new(viewport, clip_space);
    outline.clear();
    outline.extend(vertices.iter().map(|&ClipVertex { position, .. }| {
        projection.vertex(position.to_array(), 1.0, |_, inv_w| inv_w)
    }));
}

/// The line in which a plane meets a polygon, on the screen: where an affine function of the position
/// is zero.
#[derive(Clone, Copy, Debug)]
struct Dividing {
    /// A point, in pixels from the viewport's corner.
    at: (f64, f64),
    /// The value there.
    value: f64,
    /// Its change per pixel to the right and downwards.
    slope: (f64, f64),
    /// Whether the pixels are wanted where the value is not negative; else those where it is.
    front: bool,
}

impl Dividing {
    /// The line for a plane in clip space and a clipped polygon, whose places on the screen are in
    /// `outline`; `None` if there is no polygon.
    fn new<const N: usize>(
        plane: DVec4,
        front: bool,
        polygon: &[ClipVertex<N>],
        outline: &mut [ScreenVertex<0>],
    ) -> Option<Self> {
        for (vertex, ClipVertex { position, .. }) in outline.iter_mut().zip(polygon) {
            vertex.values.z = plane.dot(*position) / position.w;
        }
        let triangle = widest_triangle(outline)?;
        let slope = match Gradient::through(triangle) {
            Some(gradient) => (gradient.dx.z, gradient.dy.z),
            None => slope_along(outline),
        };
        let [origin, ..] = triangle;
        Some(Self { at: (origin.x, origin.y), value: origin.values.z, slope, front })
    }

    /// The columns of a row on the wanted side. Whatever the numbers are, those of both sides are all
    /// columns once.
    fn columns(&self, y: i32) -> Range<i32> {
        const ALL: Range<i32> = i32::MIN..i32::MAX;
        let value = self.value + self.slope.1 * (f64::from(y) + 0.5 - self.at.1);
        let (slope, _) = self.slope;
        if slope == 0.0 {
            return if (value >= 0.0) == self.front { ALL } else { 0..0 };
        }
        // The first column whose centre is at the line or on its right.
        let column = (self.at.0 - value / slope - 0.5).ceil() as i32;
        if (slope > 0.0) == self.front { column..ALL.end } else { ALL.start..column }
    }
}

/// The change of the value along a polygon that is too thin to have planes: from one end to the
/// other, and none across.
#[cold]
fn slope_along(vertices: &[ScreenVertex<0>]) -> (f64, f64) {
    let Some(a) = vertices.first() else { return (0.0, 0.0) };
    let from_a = |v: &ScreenVertex<0>| (v.x - a.x, v.y - a.y, v.values.z - a.values.z);
    let length = |v: &ScreenVertex<0>| {
        let (x, y, _) = from_a(v);
        x * x + y * y
    };
    let farthest = vertices.iter().max_by(|v, w| length(v).total_cmp(&length(w))).unwrap_or(a);
    let ((x, y, z), square) = (from_a(farthest), length(farthest));
    if square > 0.0 { (x * z / square, y * z / square) } else { (0.0, 0.0) }
}
