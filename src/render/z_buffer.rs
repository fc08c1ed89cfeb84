//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use fearless_simd::{Level, Simd, SimdBase, SimdMask, dispatch, f32x16, mask32x16};

use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::outline::Outline;
use crate::project::Viewport;
use crate::render::framebuffer::Framebuffer;
use crate::render::mesh::MeshScratch;
use crate::render::raster::Raster;
use crate::render::shader::{DepthOnly, Paint, PerBlock, PerFragment, Shader};
use crate::scan::ScanConverter;
use crate::vertex::Vertex;

/// When a fragment passes, by its depth and the depth stored for its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthTest {
    /// Never.
    Never,
    /// If its depth is less: the nearest wins, and the first of equals.
    #[default]
    Less,
    /// If its depth is equal.
    Equal,
    /// If its depth is less or equal.
    LessEqual,
    /// If its depth is greater: for reversed depth, and for [`DepthSource::InverseW`].
    Greater,
    /// If its depth is different.
    NotEqual,
    /// If its depth is greater or equal.
    GreaterEqual,
    /// Always.
    Always,
}

impl DepthTest {
    /// Which lanes pass, a bit a lane.
    #[inline(always)]
    pub(crate) fn passes<S: Simd>(self, new: f32x16<S>, old: f32x16<S>) -> u32 {
        // Less, equal or greater, and whether it is the others that pass, as NaN does then. All three
        // are less code than a branch for each test.
        let (less, equal, greater, others) = match self {
            Self::Never => (false, false, false, false),
            Self::Less => (true, false, false, false),
            Self::Equal => (false, true, false, false),
            Self::LessEqual => (true, true, false, false),
            Self::Greater => (false, false, true, false),
            Self::NotEqual => (false, true, false, true),
            Self::GreaterEqual => (false, true, true, false),
            Self::Always => (false, false, false, true),
        };
        let bits = |wanted: bool, mask: mask32x16<S>| {
            if wanted { bitmask(new.simd, mask) } else { 0 }
        };
        let mut passes = bits(less, new.simd_lt(old));
        passes |= bits(equal, new.simd_eq(old));
        passes |= bits(greater, new.simd_gt(old));
        if others { !passes } else { passes }
    }
}

/// The lanes that are set, a bit a lane.
#[inline(always)]
fn bitmask<S: Simd>(simd: S, mask: mask32x16<S>) -> u32 {
    if !simd.level().is_fallback() {
        return mask.to_bitmask() as u32;
    }
    // Without SIMD a loop that the compiler may turn into it: a lane that is set has all bits.
    let lanes = <[i32; LANES]>::from(mask);
    lanes.iter().enumerate().fold(0, |bits, (lane, all)| bits | *all as u32 & 1 << lane)
}

/// What is compared and stored as depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthSource {
    /// z/w in the viewport's depth range. Right for any projection.
    #[default]
    Z,
    /// 1/w, which is interpolated anyway (Low, "Perspective-Correct Interpolation", 2002). It grows
    /// towards the eye: clear the depth to 0 and test with [`DepthTest::Greater`]. It tells nothing
    /// in an orthographic projection, where all w are equal.
    InverseW,
}

/// Draws polygons into a framebuffer, hidden surfaces removed.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Vertex, ZBuffer};
///
/// let mut frame = Framebuffer::new(4, 2, '.')?;
/// let mut renderer = ZBuffer::new(frame.viewport());
/// let quad = [(-1.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// renderer.draw(&mut frame, &quad, |_| '#');
/// assert_eq!(frame.color(), ['#', '#', '.', '.', '#', '#', '.', '.']);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ZBuffer<const N: usize> {
    /// Where and how polygons are scan-converted: viewport, scissor, culling, interpolation.
    pub scan: ScanConverter<N>,
    /// When a fragment is drawn.
    pub depth_test: DepthTest,
    /// Whether the depth of a fragment that is drawn is stored.
    pub depth_write: bool,
    /// What is compared and stored.
    pub depth_source: DepthSource,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub level: Level,
    mesh: MeshScratch<N>,
}

impl<const N: usize> ZBuffer<N> {
    /// A renderer to a viewport, with the settings of [`ScanConverter::new`], that draws what has
    /// less depth and stores it.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            scan: ScanConverter::new(viewport),
            depth_test: DepthTest::default(),
            depth_write: true,
            depth_source: DepthSource::default(),
            level: Level::new(),
            mesh: MeshScratch::default(),
        }
    }

    /// Draws a polygon. `shader` is called once for each fragment that passes the depth test; it
    /// returns a colour, an `Option` of one, where `None` discards the fragment, or a colour to be
    /// blended; see [`Paint`].
    ///
    /// What does not lie on the framebuffer is left out. Any polygon is safe; see
    /// [`ScanConverter::spans`] for what it covers.
    ///
    /// A polygon may have several contours, and so holes:
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{FillRule, Framebuffer, Vertex, ZBuffer};
    ///
    /// let square = |size: f32| {
    ///     [(-size, -size), (size, -size), (size, size), (-size, size)]
    ///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
    /// };
    /// let (wall, window) = (square(1.0), square(0.5));
    /// let mut frame = Framebuffer::new(4, 4, '.')?;
    /// let mut renderer = ZBuffer::new(frame.viewport());
    /// // Both run in the same direction, which is no hole by the non-zero rule.
    /// renderer.scan.fill_rule = FillRule::EvenOdd;
    /// renderer.draw(&mut frame, &[&wall[..], &window[..]], |_| '#');
    /// let rows: Vec<String> = frame.color().chunks(4).map(|row| row.iter().collect()).collect();
    /// assert_eq!(rows, ["####", "#..#", "#..#", "####"]);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn draw<C, R>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &(impl Outline<N> + ?Sized),
        shader: impl Fn(&Fragment<'_, N>) -> R,
    ) where
        C: Copy,
        R: Paint<C>,
    {
        self.draw_polygon(frame, polygon, &PerFragment(shader));
    }

    /// Draws a polygon by a shader of [`LANES`] pixels at a time: it is given a block of fragments
    /// and the colours that their pixels have, which it replaces; those of lanes that are not
    /// visible are put back. The compiler can turn a loop over the lanes into SIMD instructions,
    /// for the best ones that the machine has.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{Framebuffer, Vertex, ZBuffer};
    ///
    /// let mut frame = Framebuffer::new(100, 100, 0.0f32)?;
    /// let mut renderer = ZBuffer::new(frame.viewport());
    /// let triangle = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// renderer.draw_blocks(&mut frame, &triangle, |block, colors| {
    ///     let [u, v] = &block.params;
    ///     for (color, (u, v)) in colors.iter_mut().zip(u.iter().zip(v)) {
    ///         *color = u * u + v * v;
    ///     }
    /// });
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn draw_blocks<C: Copy>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &(impl Outline<N> + ?Sized),
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
    ) {
        self.draw_polygon(frame, polygon, &PerBlock(shader));
    }

    /// Draws the depth of a polygon alone: nothing is shaded, no parameter is evaluated.
    pub fn draw_depth<C: Copy>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &(impl Outline<N> + ?Sized),
    ) {
        self.draw_polygon(frame, polygon, &DepthOnly);
    }

    fn draw_polygon<C: Copy>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &(impl Outline<N> + ?Sized),
        shader: &impl Shader<N, C>,
    ) {
        let raster = self.raster();
        let spans = self.scan.spans_within(polygon, frame.rect());
        let mut band = frame.band();
        dispatch!(self.level, simd => raster.draw(simd, spans, &mut band, shader));
    }

    /// Draws the faces of a mesh, each a list of indices into `vertices`, in their order. A face
    /// with an index out of range is left out.
    ///
    /// This is much faster than drawing the faces one by one: vertices are projected once each, and
    /// with the feature `parallel` all processors that `rayon` knows of take part. The picture is
    /// the same.
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
        let how = (self.level, self.raster());
        self.mesh.draw(&self.scan, how, frame, vertices, faces, &PerFragment(shader));
    }

    /// Draws a mesh by a shader of blocks, as [`draw_blocks`](Self::draw_blocks) does a polygon.
    pub fn draw_mesh_blocks<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        let how = (self.level, self.raster());
        self.mesh.draw(&self.scan, how, frame, vertices, faces, &PerBlock(shader));
    }

    /// Draws the depth of a mesh alone.
    pub fn draw_mesh_depth<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
    ) {
        let how = (self.level, self.raster());
        self.mesh.draw(&self.scan, how, frame, vertices, faces, &DepthOnly);
    }

    fn raster(&self) -> Raster {
        Raster { test: self.depth_test, write: self.depth_write, source: self.depth_source }
    }
}
