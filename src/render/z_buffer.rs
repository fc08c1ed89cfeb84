//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use std::ops::Range;

use fearless_simd::{
    Level, Select, Simd, SimdBase, SimdFrom, SimdMask, dispatch, f32x16, mask32x16,
};

use crate::fragment::{Block, Fragment, FragmentBlock, LANES, Lanes};
use crate::outline::Outline;
use crate::polygon::Method;
use crate::project::Viewport;
use crate::render::coarse_depth::{CoarseDepth, TILE_WIDTH};
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::mesh::MeshScratch;
use crate::render::shader::{ALL, DepthOnly, Paint, PerBlock, PerFragment, Shader};
use crate::scan::{ScanConverter, Spans};
use crate::span::Span;
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
    fn passes<S: Simd>(self, new: f32x16<S>, old: f32x16<S>) -> u32 {
        let mask = match self {
            Self::Never => return 0,
            Self::Always => return u32::MAX,
            Self::Less => new.simd_lt(old),
            Self::Equal => new.simd_eq(old),
            Self::LessEqual => new.simd_le(old),
            Self::Greater => new.simd_gt(old),
            Self::NotEqual => new.simd_ne(old),
            Self::GreaterEqual => new.simd_ge(old),
        };
        mask.to_bitmask() as u32
    }
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

/// What to do with fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Raster {
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) source: DepthSource,
}

impl Raster {
    /// Prepares a coarse depth for a band; whether it helps.
    pub(crate) fn restart<C>(self, coarse: &mut CoarseDepth, band: &Band<'_, C>) -> bool {
        self.source == DepthSource::Z && coarse.restart(self.test, band.width(), band.rows().len())
    }

    /// The usual settings, for which the code is specialised.
    const USUAL: Self = Self { test: DepthTest::Less, write: true, source: DepthSource::Z };

    /// Draws spans into a band of the framebuffer that holds all of their rows.
    #[inline(always)]
    pub(crate) fn draw<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        spans: Spans<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        // Code for the usual cases, in a loop of its own. All of it must be inlined: only then is it
        // compiled for the instructions that `simd` stands for.
        match (self == Self::USUAL, spans.polygon.method) {
            (true, Method::Perspective) => spans.for_each_of_convex(
                #[inline(always)]
                |span| Self::USUAL.draw_span(simd, &span, Method::Perspective, band, shader),
            ),
            (true, Method::Constant) => spans.for_each_of_convex(
                #[inline(always)]
                |span| Self::USUAL.draw_span(simd, &span, Method::Constant, band, shader),
            ),
            _ => Some(spans),
        }
        .into_iter()
        .flatten()
        .for_each(|span| self.draw_any(simd, span, band, shader));
    }

    /// Draws any span.
    #[inline(never)]
    pub(crate) fn draw_any<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: Span<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.draw_span(simd, &span, span.place.polygon.method, band, shader),
        );
    }

    /// Draws a span, if it is long without the parts that the coarse depth hides.
    #[inline(always)]
    fn draw_span<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: &Span<'_, N>,
        method: Method,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let in_band = (span.y() - band.first()) as usize;
        let row = band.row(span.y());
        let first = band.column(span.column());
        let columns = first..first + span.x.len();
        let mut visible = columns.clone();
        loop {
            if columns.len() > TILE_WIDTH
                && let Some(coarse) = &mut band.coarse
            {
                let depth = |column: usize| span.depth_at((column - first) as i32);
                let left = visible.start..columns.end;
                visible = coarse.next_visible(band.depth, in_band, left, depth);
            }
            if !visible.is_empty() {
                let x = span.x.start + (visible.start - first) as i32;
                let pixels = row + visible.start..row + visible.end;
                self.draw_columns(simd, Block { span, x }, pixels, method, band, shader);
            }
            if visible.end == columns.end {
                return;
            }
            visible.start = visible.end;
        }
    }

    /// Draws a part of a span, whose first column `block` begins with, to these pixels of the band:
    /// in blocks that begin at cache lines, a first one that may have lanes before the part, then
    /// whole ones, then what is left.
    #[inline(always)]
    fn draw_columns<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        mut block: Block<'_, '_, N>,
        Range { start, end }: Range<usize>,
        method: Method,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let before = (start + band.line_offset) % LANES;
        let mut at = start.wrapping_sub(before);
        block.x -= before as i32;
        let mut lanes = ALL << before;
        loop {
            let left = end.wrapping_sub(at);
            if left < LANES {
                lanes &= ALL >> (LANES - left);
            }
            self.draw_part(simd, &block, method, lanes & ALL, at, band, shader);
            if left <= LANES {
                return;
            }
            at = at.wrapping_add(LANES);
            block.x += LANES as i32;
            let done = self.draw_whole_blocks(simd, block, method, at..end, band, shader);
            if at + done == end {
                return;
            }
            // What is left is the end, or a block that is seen in part.
            at += done;
            block.x += done as i32;
            lanes = ALL;
        }
    }

    /// Draws blocks, the first of which is given, as long as all of their pixels are seen or none;
    /// how many pixels that are.
    #[inline(always)]
    fn draw_whole_blocks<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        mut block: Block<'_, '_, N>,
        method: Method,
        pixels: Range<usize>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) -> usize {
        let colors = band.color.get_mut(pixels.clone()).unwrap_or_default();
        let depths = band.depth.get_mut(pixels).unwrap_or_default();
        let first = block.x;
        let mut steps = block.steps(simd);
        for (colors, depths) in colors.as_chunks_mut().0.iter_mut().zip(depths.as_chunks_mut().0) {
            let depth = self.depth(&block, steps);
            let stored = f32x16::simd_from(simd, *depths);
            let visible = self.test.passes(depth, stored) & ALL;
            if visible == ALL {
                let drawn = shader.shade_all(&block, steps, method, depth, colors);
                if self.write {
                    *depths = chosen(drawn, depth, stored);
                }
            } else if visible != 0 {
                break;
            }
            // Whole numbers, exact in f32.
            steps += LANES as f32;
            block.x += LANES as i32;
        }
        (block.x - first) as usize
    }

    /// Draws a block that may have lanes outside the span. It may reach over the sides of the
    /// framebuffer: into the next row, whose pixels are put back, or out of the band.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "all that there is about a block")]
    fn draw_part<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        block: &Block<'_, '_, N>,
        method: Method,
        lanes: u32,
        at: usize,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let steps = block.steps(simd);
        let colors = band.color.get_mut(at..).and_then(<[C]>::first_chunk_mut);
        let depths = band.depth.get_mut(at..).and_then(<[f32]>::first_chunk_mut);
        let mut copy = None;
        let (colors, depths) = match (colors, depths) {
            (Some(colors), Some(depths)) => (colors, depths),
            _ => {
                let Some(pixels) = band.copy(at) else { return };
                let (colors, depths) = copy.insert(pixels);
                (colors, depths)
            }
        };
        self.draw_block(block, steps, method, lanes, colors, depths, shader);
        if let Some((colors, depths)) = &copy {
            band.put_back(at, colors, depths);
        }
    }

    /// The depth test, and if a lane passes, the shader.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "all that there is about a block")]
    fn draw_block<S: Simd, C: Copy, const N: usize>(
        self,
        block: &Block<'_, '_, N>,
        steps: f32x16<S>,
        method: Method,
        lanes: u32,
        colors: &mut [C; LANES],
        depths: &mut Lanes,
        shader: &impl Shader<N, C>,
    ) {
        let depth = self.depth(block, steps);
        let stored = f32x16::simd_from(steps.simd, *depths);
        let visible = self.test.passes(depth, stored) & lanes;
        if visible == 0 {
            return;
        }
        let drawn = shader.shade(block, steps, method, depth, visible, colors);
        if self.write {
            *depths = chosen(drawn, depth, stored);
        }
    }

    /// What is compared and stored.
    #[inline(always)]
    fn depth<S: Simd, const N: usize>(
        self,
        block: &Block<'_, '_, N>,
        steps: f32x16<S>,
    ) -> f32x16<S> {
        match self.source {
            DepthSource::Z => block.depth(steps),
            DepthSource::InverseW => block.inverse_w(steps),
        }
    }
}

/// The new depths of the lanes that were drawn, the old ones of the others.
#[inline(always)]
fn chosen<S: Simd>(drawn: u32, new: f32x16<S>, old: f32x16<S>) -> Lanes {
    if drawn == ALL {
        return new.into();
    }
    mask32x16::from_bitmask(new.simd, drawn.into()).select(new, old).into()
}
