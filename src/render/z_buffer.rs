//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use fearless_simd::{
    Level, Select, Simd, SimdBase, SimdFrom, SimdMask, dispatch, f32x16, mask32x16,
};

use crate::fragment::{Block, Fragment, FragmentBlock, LANES, Lanes};
use crate::project::Viewport;
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::mesh::MeshScratch;
use crate::render::shader::{DepthOnly, Paint, PerBlock, PerFragment, Shader};
use crate::scan::ScanConverter;
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
    pub fn draw<C, R>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &[Vertex<N>],
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
        polygon: &[Vertex<N>],
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
    ) {
        self.draw_polygon(frame, polygon, &PerBlock(shader));
    }

    /// Draws the depth of a polygon alone: nothing is shaded, no parameter is evaluated.
    pub fn draw_depth<C: Copy>(&mut self, frame: &mut Framebuffer<C>, polygon: &[Vertex<N>]) {
        self.draw_polygon(frame, polygon, &DepthOnly);
    }

    fn draw_polygon<C: Copy>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &[Vertex<N>],
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct Raster {
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) source: DepthSource,
}

impl Raster {
    /// Draws spans into a band of the framebuffer that holds all of their rows.
    #[inline(always)]
    pub(crate) fn draw<'a, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        spans: impl Iterator<Item = Span<'a, N>>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        // Pixels from the beginning of a cache line to the first depth.
        let line_offset = band.depth.as_ptr().addr() / size_of::<f32>() % LANES;
        spans.for_each(|span| {
            let row = band.row(span.y());
            let first = row.wrapping_add_signed(span.column() as isize);
            for block in span.blocks(first.wrapping_add(line_offset)) {
                // Blocks may reach over the sides of the framebuffer: into the next row, whose
                // pixels they put back, or out of the band.
                let at = row.wrapping_add_signed(block.column() as isize);
                let colors = band.color.get_mut(at..).and_then(<[C]>::first_chunk_mut);
                let depths = band.depth.get_mut(at..).and_then(<[f32]>::first_chunk_mut);
                if let (Some(colors), Some(depths)) = (colors, depths) {
                    self.draw_block(simd, &block, colors, depths, shader);
                } else {
                    self.draw_at_the_end(simd, &block, at, band, shader);
                }
            }
        });
    }

    /// Draws a block that reaches out of the band, on a copy of its pixels.
    #[cold]
    fn draw_at_the_end<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        block: &Block<'_, N>,
        at: usize,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let pixel = |lane: usize| at.wrapping_add(lane);
        let Some(&any) = band.color.first() else { return };
        let mut colors =
            std::array::from_fn(|lane| band.color.get(pixel(lane)).copied().unwrap_or(any));
        let mut depths =
            std::array::from_fn(|lane| band.depth.get(pixel(lane)).copied().unwrap_or(0.0));
        self.draw_block(simd, block, &mut colors, &mut depths, shader);
        for lane in 0..LANES {
            if let Some(color) = band.color.get_mut(pixel(lane)) {
                *color = colors[lane];
            }
            if let Some(depth) = band.depth.get_mut(pixel(lane)) {
                *depth = depths[lane];
            }
        }
    }

    /// The depth test, and if a lane passes, the shader.
    #[inline(always)]
    fn draw_block<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        block: &Block<'_, N>,
        colors: &mut [C; LANES],
        depths: &mut Lanes,
        shader: &impl Shader<N, C>,
    ) {
        let steps = block.steps(simd);
        let depth = match self.source {
            DepthSource::Z => block.depth(steps),
            DepthSource::InverseW => block.inverse_w(steps),
        };
        let stored = f32x16::simd_from(simd, *depths);
        let visible = self.test.passes(depth, stored) & block.lanes();
        if visible == 0 {
            return;
        }
        let drawn = shader.shade(block, steps, depth, visible, colors);
        if self.write {
            let drawn = mask32x16::from_bitmask(simd, drawn.into());
            *depths = drawn.select(depth, stored).into();
        }
    }
}
