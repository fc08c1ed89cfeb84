//! The painter's renderer: polygons are drawn from back to front, each over what is there.
//!
//! It needs no depth, and blends as light does: what is transparent is drawn after all that is seen
//! through it. The order comes from a [`BspTree`](crate::BspTree), which splits polygons where no order exists
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

mod cut_line;

use std::ops::Range;

use fearless_simd::{Level, Simd};
use glam::{DMat4, DVec4};

use crate::coverage::run::RunGroup;
use crate::coverage::shape::Coverage;
use crate::primitive::Primitive;
use crate::project::ScreenPoint;
use crate::render::band::Band;
use crate::render::bsp::{Group, NONE, Partition, Piece};
use crate::render::by_depth::{Depths, is_greater_farther, sorted};
use crate::render::corners::ProjectedVertices;
use crate::render::depth::DepthTest;
use crate::render::faces::FaceList;
use crate::render::front::{Counting, DrawFaces, FrontMemory, Parts, Renderer, drawing_methods};
use crate::render::geometry::{Batch, Order};
use crate::render::mesh::bins::{BAND, bands_of};
use crate::render::painter::cut_line::CutLine;
use crate::render::parallel::{Bands, Shading, first, for_each_band};
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::shader::ShadeBlocks;
use crate::render::statistics::Statistics;
use crate::render::stencil::Stencil;
use crate::render::strokes::Strokes;
use crate::settings::{DepthMode, DrawCall, Settings};
use crate::simd::for_level;
use crate::surface::rows::SurfaceView;
use crate::vertices::Vertices;
use crate::view_volume::Outcome;
use crate::viewport::Viewport;

/// Draws polygons into a framebuffer, from back to front.
///
/// What it is for is transparency: every pixel's polygons are blended in their true order, also where
/// they cross, to the pixel. For opaque polygons it gives the picture of the
/// [z-buffer](crate::ZBufferRenderer), to the bit except where surfaces meet within 1/512 pixel of a pixel's
/// centre, and takes some four times as long, and longer the more polygons lie behind each other,
/// since all of them are shaded.
///
/// The order is found by a [`BspTree`](crate::BspTree). Build one and keep it: of a plain
/// [`Mesh`](crate::Mesh) a tree is built anew for each picture, which takes much longer than drawing, and
/// whether z grows with the distance cannot be seen from its vertices, so that
/// [`DepthMode::InverseW`](crate::DepthMode::InverseW) counts as
/// [`DepthMode::Standard`](crate::DepthMode::Standard) there. A mesh that is sorted
/// [`back_to_front`](crate::Mesh::back_to_front) needs no tree.
///
/// ```
/// use glam::{Mat4, Vec4, vec4};
/// use polyscan::{BspTree, Framebuffer, PainterRenderer, Vertex, render::Over};
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
/// let mut painter = PainterRenderer::new(frame.viewport());
/// painter.draw(&mut frame, tree.seen_by(Mat4::IDENTITY), |fragment| match fragment.face {
///     0 => Over(vec4(0.5, 0.0, 0.0, 0.5)),
///     _ => Over(vec4(0.0, 0.0, 0.5, 0.5)),
/// });
/// assert_eq!(frame.pixel(31, 20).map(|(color, _)| color), Some(vec4(0.5, 0.0, 0.25, 1.0)));
/// assert_eq!(frame.pixel(32, 20).map(|(color, _)| color), Some(vec4(0.25, 0.0, 0.5, 1.0)));
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PainterRenderer<const N: usize> {
    /// Where and how polygons are brought to the screen.
    pub settings: Settings<N>,
    /// Whether the depth of a fragment that is drawn is stored. It is never compared.
    pub depth_write: bool,
    /// What is done with the stencil of a [target that has one](crate::Target::with_stencil).
    pub stencil: Option<Stencil>,
    /// Counts what becomes of polygons and pixels, from now on, if there is something to count in: see
    /// [`Statistics`].
    pub statistics: Option<Statistics>,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub simd_level: Level,
    front: FrontMemory<N>,
    drawer: Drawer,
}

/// What draws faces, with memory that is kept.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drawer {
    corners: ProjectedVertices,
    order: Vec<Piece>,
    keys: Vec<([f64; 2], Piece)>,
    bins: Vec<Vec<Piece>>,
    workers: Vec<Worker>,
    strokes: Strokes,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker {
    primitive: Primitive,
    outline: Vec<ScreenPoint>,
    cuts: Vec<CutLine>,
    raster: RasterMemory,
}

impl<const N: usize> PainterRenderer<N> {
    /// A renderer to a viewport, with the settings of [`Settings::new`], that stores no depth.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            depth_write: false,
            stencil: None,
            statistics: None,
            simd_level: Level::new(),
            front: FrontMemory::default(),
            drawer: Drawer::default(),
        }
    }
}

drawing_methods!(PainterRenderer);

impl<const N: usize> Renderer<N> for PainterRenderer<N> {
    type Drawer = Drawer;

    fn parts(&mut self) -> Parts<'_, Drawer, N> {
        let Self { settings, stencil, statistics, simd_level: level, front, drawer, .. } = self;
        let plan = Plan::new(DepthTest::Always, self.depth_write, settings.depth);
        let counting = Counting::of(statistics.as_mut());
        Parts { settings, level: *level, plan, stencil: *stencil, counting, front, drawer }
    }

    fn level(&self) -> Level {
        self.simd_level
    }

    fn depth_mode(&self) -> DepthMode {
        self.settings.depth
    }
}

impl DrawFaces for Drawer {
    /// All must be there before the first can be drawn.
    const MOST_FACES: usize = usize::MAX;

    fn draw(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        batch: &Batch<'_>,
        band: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        if self.strokes.prepare(call, batch) {
            return self.strokes.draw(call, (level, plan), band, shading);
        }
        let built;
        let (partition, planes) = match batch.order {
            Order::Tree(partition, planes) => (Some(partition), planes),
            Order::AsGiven => {
                built = Partition::new(batch.vertices, batch.faces);
                (Some(&built), Some(DMat4::IDENTITY))
            }
            Order::BackToFront => (None, None),
        };
        let tree = partition.zip(planes);
        self.put_in_order(call, batch, tree);
        self.corners.project(call, level, batch.vertices);
        self.bin(call, batch.faces, band.rows().len());
        let Self { bins, workers, .. } = self;
        let bands = band.rows().len().div_ceil(BAND as usize);
        let workers = first(workers, bands);
        let (bins, batch) = (&*bins, (batch.vertices, batch.faces));
        let bands = Bands::of(band, BAND as usize);
        for_each_band(band, bands, workers, shading, &|i, band, worker, shader| {
            let rows = call.window.rows_within(&band.rows());
            let mut drawing = BandDrawing { call, plan, batch, tree, worker, band, shader };
            for_level!(level, simd => for piece in &bins[i] {
                drawing.draw_piece(simd, *piece, &rows);
            });
        });
    }
}

impl Drawer {
    /// Puts the pieces in their order from back to front.
    fn put_in_order(
        &mut self,
        call: &DrawCall<'_>,
        batch: &Batch<'_>,
        tree: Option<(&Partition, DMat4)>,
    ) {
        let Self { order, keys, .. } = self;
        let depths = Depths::new(call, batch.vertices);
        let key = |piece: &Piece| (depths.key(batch.faces.get(piece.face as usize)), *piece);
        order.clear();
        let Some((partition, planes)) = tree else {
            keys.clear();
            keys.extend((0..batch.faces.len()).map(|i| key(&Piece { face: i as u32, cut: NONE })));
            order.extend(sorted(keys));
            return;
        };
        let towards_z = planes.row(2);
        let is_greater_farther = is_greater_farther(call, &planes);
        let is_front_far = |plane: DVec4| (plane.dot(towards_z) > 0.0) == is_greater_farther;
        partition.back_to_front(is_front_far, |group| match group {
            Group::Coplanar(pieces) => order.extend(pieces.iter().rev()),
            Group::Unordered(pieces) => {
                keys.clear();
                keys.extend(pieces.iter().map(key));
                order.extend(sorted(keys));
            }
        });
    }

    /// Sorts the pieces into bins, one a band, that keep their order.
    fn bin(&mut self, call: &DrawCall<'_>, faces: &FaceList, height: usize) {
        let Self { bins, order, corners, .. } = self;
        let bands = height.div_ceil(BAND as usize);
        let bins = first(bins, bands);
        bins.iter_mut().for_each(Vec::clear);
        for piece in order {
            let indices = faces.get(piece.face as usize);
            let rows = match corners.outcome(indices) {
                Outcome::Outside => continue,
                Outcome::Inside if !faces.has_contours() => {
                    let Some((_, rows)) = call.window.extent(corners.points_of(indices)) else {
                        continue;
                    };
                    rows
                }
                // Where it will be once it is clipped is found by who clips it.
                _ => call.window.rows.clone(),
            };
            bins[bands_of(call, &rows)].iter_mut().for_each(|bin| bin.push(*piece));
        }
    }
}

/// A band of a picture being drawn.
struct BandDrawing<'d, 'b> {
    call: &'d DrawCall<'d>,
    plan: Plan,
    batch: (&'d dyn Vertices, &'d FaceList),
    /// The tree that cut the faces, and the matrix that brings its planes to clip space.
    tree: Option<(&'d Partition, DMat4)>,
    worker: &'d mut Worker,
    band: &'d mut Band<'b>,
    shader: &'d mut dyn ShadeBlocks,
}

impl BandDrawing<'_, '_> {
    /// Draws a piece: what its cuts leave of its face.
    #[inline(always)]
    fn draw_piece<S: Simd>(&mut self, simd: S, piece: Piece, rows: &Range<i32>) {
        let Self { call, plan, batch: (vertices, faces), tree, .. } = *self;
        let Worker { primitive, outline, cuts, raster } = &mut *self.worker;
        let contours =
            faces.contours(piece.face as usize).map(|c| c.iter().filter_map(|&i| vertices.get(i)));
        if !primitive.prepare(call, faces.number(piece.face), contours, rows) {
            return;
        }
        cuts.clear();
        if let Some((partition, planes)) = tree
            && piece.cut != NONE
        {
            let polygon = primitive.clipped().vertices().positions();
            outline.clear();
            outline.extend(polygon.iter().map(|p| call.projection.point(p.to_array())));
            let lines = partition.cuts(piece);
            cuts.extend(lines.filter_map(|(plane, front)| {
                CutLine::new(planes * plane, front, polygon, outline)
            }));
        }
        let (surface, coverage) = primitive.parts();
        let (columns, band, shader) = (&call.window.columns, &mut *self.band, &mut *self.shader);
        if cuts.is_empty() {
            raster::draw(simd, plan, (&surface, coverage), columns, band, raster, shader);
        } else {
            draw_cut(simd, plan, (&surface, coverage, cuts), columns, band, raster, shader);
        }
    }
}

/// Draws the parts of runs that are on the right sides of all cuts.
fn draw_cut<S: Simd>(
    simd: S,
    plan: Plan,
    (surface, coverage, cuts): (&SurfaceView<'_>, Coverage<'_>, &[CutLine]),
    columns: &Range<i32>,
    band: &mut Band<'_>,
    memory: &mut RasterMemory,
    shader: &mut dyn ShadeBlocks,
) {
    coverage.for_each_group(surface.needs_edges(), |group| {
        for row in 0..group.len {
            let run = group.run(row);
            let columns = cuts.iter().fold(columns.clone(), |columns, cut| {
                let side = cut.columns(run.y);
                columns.start.max(side.start)..columns.end.min(side.end)
            });
            if run.x.start.max(columns.start) < run.x.end.min(columns.end) {
                let runs = RunGroup::of(&run);
                raster::draw_runs(simd, plan, (surface, &runs), &columns, band, memory, shader);
            }
        }
    });
}
