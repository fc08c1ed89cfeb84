//! The front of all renderers: the same three methods for any geometry, target and shader.

use fearless_simd::Level;

use crate::fragment::{Fragment, FragmentBlock};
use crate::primitive::ClippedPolygon;
use crate::render::band::Band;
use crate::render::canvas::Canvas;
use crate::render::counters::Counters;
use crate::render::geometry::{Batch, Geometry, GeometryMemory};
use crate::render::paint::Paint;
use crate::render::parallel::Shading;
use crate::render::pixel::Pixel;
use crate::render::raster::plan::Plan;
use crate::render::shader::{Alone, BlockFunction, DepthOnly, FragmentFunction};
use crate::render::statistics::Statistics;
use crate::render::stencil::Stencil;
use crate::render::target::{RenderTarget, Target};
use crate::settings::{DepthMode, DrawCall, Settings};
use crate::simd::for_level;
use crate::view_volume::ClipPlane;
use crate::viewport::Rect;

/// A renderer, taken apart for one draw call.
pub(crate) struct Parts<'a, D, const N: usize> {
    pub(crate) settings: &'a Settings<N>,
    pub(crate) level: Level,
    pub(crate) plan: Plan,
    /// What is done with the target's stencil, if it has one.
    pub(crate) stencil: Option<Stencil>,
    pub(crate) counting: Counting<'a>,
    pub(crate) front: &'a mut FrontMemory<N>,
    /// What draws faces once they are collected.
    pub(crate) drawer: &'a mut D,
}

/// What is counted while geometry is drawn.
#[derive(Debug)]
pub(crate) enum Counting<'a> {
    Nothing,
    /// What becomes of polygons and pixels.
    All(&'a mut Statistics),
    /// Pixels that are drawn.
    Drawn(&'a mut u64),
    /// Whether any is drawn; what comes after that is left out.
    Any(&'a mut u64),
}

impl<'a> Counting<'a> {
    /// What there is to be filled in.
    pub(crate) fn of(statistics: Option<&'a mut Statistics>) -> Self {
        statistics.map_or(Self::Nothing, Self::All)
    }
}

/// The memory of what all renderers do before they draw.
#[derive(Clone, Debug, Default)]
pub(crate) struct FrontMemory<const N: usize> {
    pub(crate) geometry: GeometryMemory<N>,
    pub(crate) planes: Vec<ClipPlane>,
    /// For statistics.
    polygon: ClippedPolygon,
}

/// What all renderers have.
pub(crate) trait Renderer<const N: usize> {
    type Drawer: DrawFaces;

    fn parts(&mut self) -> Parts<'_, Self::Drawer, N>;

    /// The SIMD instructions to use.
    fn level(&self) -> Level;

    /// What is compared as depth.
    fn depth_mode(&self) -> DepthMode;
}

/// What a renderer does with faces that are collected and a shader that is typed away.
pub(crate) trait DrawFaces {
    /// The most faces that are handed over at a time.
    const MOST_FACES: usize;

    /// Draws faces on a target, where some pixels are to be visited.
    fn draw(
        &mut self,
        call: &DrawCall<'_>,
        level_and_plan: (Level, Plan),
        batch: &Batch<'_>,
        target: &mut Band<'_>,
        shading: Shading<'_>,
    );
}

/// The width of a target, its depths, and its stencil.
type PixelTests<'a> = (u32, &'a mut [f32], Option<&'a mut [u8]>);

/// Hands geometry over to a renderer. Compiled once for each kind of geometry, not for each shader.
#[inline(never)]
fn submit<const N: usize, R: Renderer<N>>(
    renderer: &mut R,
    geometry: Option<impl Geometry<N>>,
    (width, depth, stencil): PixelTests<'_>,
    mut shading: Shading<'_>,
) {
    let Some(geometry) = geometry.filter(|_| !depth.is_empty()) else { return };
    let Parts { settings, level, mut plan, stencil: rule, mut counting, front, drawer } =
        renderer.parts();
    let FrontMemory { geometry: memory, planes, polygon } = front;
    settings.collect_planes(planes);
    let height = depth.len().checked_div(width as usize).unwrap_or(0) as u32;
    let call = settings.call(Rect { x: 0, y: 0, width, height }, planes);
    if call.window.is_empty() {
        return;
    }
    let mut target = Band::new((0, 0), width as usize, depth);
    target.extras.stencil = rule.zip(stencil);
    let counts = !matches!(counting, Counting::Nothing);
    plan.has_extras = counts || target.extras.stencil.is_some();
    let mut counters = Counters::new(matches!(counting, Counting::Any(_)));
    geometry.submit(memory, R::Drawer::MOST_FACES, &mut |batch| {
        if counts {
            counting.begin(&call, batch, polygon, &mut counters);
        }
        let mut target = target.with_counters(counts.then_some(&counters));
        drawer.draw(&call, (level, plan), batch, &mut target, shading.reborrow());
        counting.end(batch, &counters);
    });
    match counting {
        Counting::Nothing => {}
        Counting::All(statistics) => statistics.take_pixels(&counters),
        Counting::Drawn(pixels) | Counting::Any(pixels) => *pixels = counters.pixels().drawn,
    }
}

impl Counting<'_> {
    /// Counts faces that are to be drawn.
    fn begin(
        &mut self,
        call: &DrawCall<'_>,
        batch: &Batch<'_>,
        polygon: &mut ClippedPolygon,
        counters: &mut Counters,
    ) {
        if let Self::All(statistics) = self {
            counters.begin(batch.faces.number(0), batch.faces.len());
            statistics.count_faces(call, batch, polygon);
        }
    }

    /// Counts faces that were drawn.
    fn end(&mut self, batch: &Batch<'_>, counters: &Counters) {
        if let Self::All(statistics) = self {
            statistics.take_seen(batch, counters);
        }
    }
}

/// Draws by a shader for each fragment that threads share.
pub(crate) fn fragments_on_threads<const N: usize, T, R>(
    renderer: &mut impl Renderer<N>,
    frame: &mut T,
    geometry: impl Geometry<N>,
    shader: impl FragmentFunction<R, N> + Copy + Send,
) where
    T: RenderTarget<Color: Send>,
    R: Paint<T::Color>,
{
    let Target { width, color, depth, mut stencil } = frame.target();
    let mut all = Some((geometry, shader, color));
    for_level!(renderer.level(), simd => if let Some((geometry, shader, color)) = all.take() {
        let (mut geometry, memory) = (Some(geometry), (color, width as usize));
        T::Color::fragments_on_threads::<_, _, _, N>(simd, memory, shader, &mut |painter| {
            let tests = (width, &mut *depth, stencil.as_deref_mut());
            submit(renderer, geometry.take(), tests, Shading::OnThreads(painter));
        });
    });
}

/// Draws by a shader of blocks that threads share.
pub(crate) fn blocks_on_threads<const N: usize, T>(
    renderer: &mut impl Renderer<N>,
    frame: &mut T,
    geometry: impl Geometry<N>,
    shader: impl BlockFunction<<T::Color as Pixel>::Block, N> + Copy + Send,
) where
    T: RenderTarget<Color: Send>,
{
    let Target { width, color, depth, mut stencil } = frame.target();
    let mut all = Some((geometry, shader, color));
    for_level!(renderer.level(), simd => if let Some((geometry, shader, color)) = all.take() {
        let (mut geometry, memory) = (Some(geometry), (color, width as usize));
        T::Color::blocks_on_threads::<_, _, N>(simd, memory, shader, &mut |painter| {
            let tests = (width, &mut *depth, stencil.as_deref_mut());
            submit(renderer, geometry.take(), tests, Shading::OnThreads(painter));
        });
    });
}

/// Draws by a shader for each fragment that is called on this thread alone.
pub(crate) fn fragments_on_one_thread<const N: usize, T, R>(
    renderer: &mut impl Renderer<N>,
    frame: &mut T,
    geometry: impl Geometry<N>,
    shader: impl FragmentFunction<R, N>,
) where
    T: RenderTarget,
    R: Paint<T::Color>,
{
    let Target { width, color, depth, mut stencil } = frame.target();
    let mut all = Some((geometry, shader, color));
    for_level!(renderer.level(), simd => if let Some((geometry, shader, color)) = all.take() {
        let (mut geometry, memory) = (Some(geometry), (color, width as usize));
        T::Color::fragments_on_one_thread::<_, _, _, N>(simd, memory, shader, &mut |painter| {
            let tests = (width, &mut *depth, stencil.as_deref_mut());
            submit(renderer, geometry.take(), tests, Shading::OnOneThread(painter));
        });
    });
}

/// Draws by a shader of blocks that is called on this thread alone.
pub(crate) fn blocks_on_one_thread<const N: usize, T>(
    renderer: &mut impl Renderer<N>,
    frame: &mut T,
    geometry: impl Geometry<N>,
    shader: impl BlockFunction<<T::Color as Pixel>::Block, N>,
) where
    T: RenderTarget,
{
    let Target { width, color, depth, mut stencil } = frame.target();
    let mut all = Some((geometry, shader, color));
    for_level!(renderer.level(), simd => if let Some((geometry, shader, color)) = all.take() {
        let (mut geometry, memory) = (Some(geometry), (color, width as usize));
        T::Color::blocks_on_one_thread::<_, _, N>(simd, memory, shader, &mut |painter| {
            let tests = (width, &mut *depth, stencil.as_deref_mut());
            submit(renderer, geometry.take(), tests, Shading::OnOneThread(painter));
        });
    });
}

/// Draws depth alone.
pub(crate) fn draw_depth<const N: usize>(
    renderer: &mut impl Renderer<N>,
    frame: &mut impl RenderTarget,
    geometry: impl Geometry<N>,
) {
    let Target { width, depth, stencil, .. } = frame.target();
    let mut geometry = Some(geometry);
    for_level!(renderer.level(), simd => {
        let tests = (width, depth, stencil);
        submit(renderer, geometry.take(), tests, Shading::OnThreads(&mut DepthOnly(simd)));
    });
}

/// A renderer that calls its shader on this thread alone, so that it may change what it captures; from
/// [`ZBufferRenderer::on_one_thread`] and its like. What comes before the shader, other threads may
/// share: the faces of a mesh, for example, are sorted into bands by all processors.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
///
/// let mut frame = Framebuffer::new(4, 4, 0u32)?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// let triangle = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut pixels = 0;
/// renderer.on_one_thread().draw(&mut frame, &triangle, |_| {
///     pixels += 1;
///     pixels
/// });
/// assert_eq!(pixels, 6);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// [`ZBufferRenderer::on_one_thread`]: crate::ZBufferRenderer::on_one_thread
#[derive(Debug)]
pub struct OneThread<'a, R, const N: usize>(&'a mut R);

impl<'a, R, const N: usize> OneThread<'a, R, N> {
    pub(crate) fn new(renderer: &'a mut R) -> Self {
        Self(renderer)
    }
}

#[expect(private_bounds, reason = "the renderers are those of this crate")]
impl<R: Renderer<N>, const N: usize> OneThread<'_, R, N> {
    /// Draws by a shader that is called for each fragment, as the renderer's own `draw`.
    pub fn draw<T, P>(
        &mut self,
        frame: &mut T,
        geometry: impl Geometry<N>,
        shader: impl FnMut(&Fragment<'_, N>) -> P,
    ) where
        T: RenderTarget,
        P: Paint<T::Color>,
    {
        fragments_on_one_thread(self.0, frame, geometry, Alone(shader));
    }

    /// Draws by a shader of [`LANES`](crate::fragment::LANES) fragments at a time, as the renderer's own `draw_blocks`.
    pub fn draw_blocks<T: RenderTarget>(
        &mut self,
        frame: &mut T,
        geometry: impl Geometry<N>,
        shader: impl FnMut(&mut FragmentBlock<'_, N>, &mut <T::Color as Pixel>::Block),
    ) {
        blocks_on_one_thread(self.0, frame, geometry, Alone(shader));
    }

    /// Draws depth alone, as the renderer's own `draw_depth`.
    pub fn draw_depth(&mut self, frame: &mut impl RenderTarget, geometry: impl Geometry<N>) {
        let Target { width, depth, stencil, .. } = frame.target();
        let mut geometry = Some(geometry);
        for_level!(self.0.level(), simd => {
            let tests = (width, depth, stencil);
            submit(self.0, geometry.take(), tests, Shading::OnOneThread(&mut DepthOnly(simd)));
        });
    }
}

/// Gives a renderer the methods that all have.
macro_rules! drawing_methods {
    ($renderer:ident) => {
        use $crate::render::shader::Shared;

        impl<const N: usize> $renderer<N> {
            /// Draws [geometry](crate::render::Geometry): `&polygon`, a [`Mesh`](crate::Mesh), a
            /// [tree](crate::BspTree::seen_by). `shader` is called for each fragment that is to be
            /// seen; it returns a colour, an `Option` of one, where `None` discards the fragment, or
            /// a colour to be blended; see [`Paint`](crate::render::Paint).
            ///
            /// What does not lie on the target is left out. Any polygon is safe; see
            /// [`ScanConverter::spans`](crate::ScanConverter::spans) for what it covers. With the
            /// feature `parallel` threads share the shader; one that has to change what it captures
            /// goes to [`on_one_thread`](Self::on_one_thread).
            pub fn draw<T, R>(
                &mut self,
                frame: &mut T,
                geometry: impl $crate::render::Geometry<N>,
                shader: impl Fn(&$crate::Fragment<'_, N>) -> R + Sync,
            ) where
                T: $crate::render::RenderTarget<Color: Send>,
                R: $crate::render::Paint<T::Color>,
            {
                $crate::render::front::fragments_on_threads(self, frame, geometry, Shared(&shader));
            }

            /// Draws by a shader of [`LANES`](crate::fragment::LANES) pixels at a time: it is given a
            /// block of fragments and the colours that their pixels have, which it replaces: an array, or
            /// a tuple of arrays for several [`Buffers`](crate::render::Buffers). Those of lanes that
            /// are not visible are put back. The compiler can turn a loop over the lanes
            /// into SIMD instructions, for the best ones that the machine has.
            ///
            /// ```
            /// use glam::vec4;
            #[doc = concat!("use polyscan::{Framebuffer, Vertex, ", stringify!($renderer), "};")]
            ///
            /// let mut frame = Framebuffer::new(100, 100, 0.0f32)?;
            #[doc = concat!("let mut renderer = ", stringify!($renderer), "::new(frame.viewport());")]
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
            pub fn draw_blocks<T: $crate::render::RenderTarget<Color: Send>>(
                &mut self,
                frame: &mut T,
                geometry: impl $crate::render::Geometry<N>,
                shader: impl Fn(
                    &mut $crate::FragmentBlock<'_, N>,
                    &mut <T::Color as $crate::render::Pixel>::Block,
                ) + Sync,
            ) {
                $crate::render::front::blocks_on_threads(self, frame, geometry, Shared(&shader));
            }

            /// Draws depth alone: nothing is shaded, no parameter is evaluated.
            pub fn draw_depth(
                &mut self,
                frame: &mut impl $crate::render::RenderTarget,
                geometry: impl $crate::render::Geometry<N>,
            ) {
                $crate::render::front::draw_depth(self, frame, geometry);
            }

            /// The renderer with a shader that is called on this thread alone, and so may change what
            /// it captures.
            pub fn on_one_thread(&mut self) -> $crate::render::OneThread<'_, Self, N> {
                $crate::render::OneThread::new(self)
            }

            /// Fills a target with a colour, and its depth with that which is behind everything by
            /// [`Settings::depth`](crate::Settings::depth).
            pub fn clear<T: $crate::render::RenderTarget>(&self, frame: &mut T, color: T::Color) {
                let mut target = frame.target();
                <T::Color as $crate::render::Pixel>::fill(&mut target.color, color);
                let mode = $crate::render::front::Renderer::<N>::depth_mode(self);
                target.depth.fill(mode.farthest());
            }
        }
    };
}

pub(crate) use drawing_methods;
