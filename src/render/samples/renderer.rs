//! The renderer of several samples a pixel: a z-buffer's.

use fearless_simd::Level;

use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::render::band::Band;
use crate::render::by_depth::SortedFaces;
use crate::render::depth::DepthTest;
use crate::render::faces::MOST_AT_ONCE;
use crate::render::geometry::{Geometry, GeometryMemory, Order};
use crate::render::mesh::MeshMemory;
use crate::render::paint::Paint;
use crate::render::parallel::Shading;
use crate::render::raster::plan::Plan;
use crate::render::samples::frame::MultisampleFramebuffer;
use crate::render::samples::pattern::REACH;
use crate::render::samples::raster::{SampleMemory, SampleRaster};
use crate::render::samples::shade::SamplePainter;
use crate::render::samples::shader::{NoShader, SampleShader, ToCoverage};
use crate::render::shader::{PerBlock, PerFragment, Shared};
use crate::settings::Settings;
use crate::simd::for_level;
use crate::vertices::Vertices;
use crate::view_volume::ClipPlane;
use crate::viewport::{Rect, Viewport};

/// Where in a pixel a polygon is shaded that covers only some of the samples. Where it covers all, that is
/// the pixel's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadingPlace {
    /// At the mean of the samples that are covered, on a convex polygon always inside of it.
    #[default]
    Centroid,
    /// At the pixel's centre, which may lie outside: parameters are continued beyond the polygon, by up
    /// to what they change over half a pixel.
    Centre,
}

/// Draws polygons as a [`ZBufferRenderer`](crate::ZBufferRenderer) does, with several samples a pixel:
/// coverage and depth for each, a shader's call for each pixel of a polygon.
///
/// ```
/// use glam::{Vec4, vec4};
/// use polyscan::Vertex;
/// use polyscan::render::{MultisampleFramebuffer, MultisampleRenderer, Samples};
///
/// let mut frame = MultisampleFramebuffer::new(2, 1, Samples::Eight, Vec4::ZERO)?;
/// let mut renderer = MultisampleRenderer::new(frame.viewport());
/// // White, over half of the left pixel.
/// let quad = [(-1.0, -1.0), (-0.5, -1.0), (-0.5, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// renderer.draw(&mut frame, &quad, |_| Vec4::ONE);
/// let picture = frame.resolve()?;
/// assert_eq!(picture.color(), [Vec4::splat(0.5), Vec4::ZERO]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// A picture on a transparent background is one of `Vec4` that begins with [`Vec4::ZERO`](glam::Vec4::ZERO):
/// linear light premultiplied by alpha, which averages right, and which is saved with straight alpha.
///
/// What is covered is said by the samples, whatever the [rule](Settings::coverage_rule) is. Faces that have no plane for depth, as of four corners with a w of their own each, have the depth of the
/// pixel's centre at all samples.
#[derive(Clone, Debug)]
pub struct MultisampleRenderer<const N: usize> {
    /// Where and how polygons are brought to the screen.
    pub settings: Settings<N>,
    /// When a sample is drawn.
    pub depth_test: DepthTest,
    /// Whether the depth of a sample that is drawn is stored.
    pub depth_write: bool,
    /// Where pixels are shaded.
    pub shading: ShadingPlace,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is the
    /// same with any.
    pub simd_level: Level,
    geometry: GeometryMemory<N>,
    planes: Vec<ClipPlane>,
    sorted: SortedFaces,
    mesh: MeshMemory<SampleMemory>,
}

impl<const N: usize> MultisampleRenderer<N> {
    /// A renderer to a viewport, with the settings of [`Settings::new`], that draws what is nearer and
    /// stores its depth.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            depth_test: DepthTest::default(),
            depth_write: true,
            shading: ShadingPlace::default(),
            simd_level: Level::new(),
            geometry: GeometryMemory::default(),
            planes: Vec::new(),
            sorted: SortedFaces::default(),
            mesh: MeshMemory::default(),
        }
    }

    /// Draws [geometry](Geometry). `shader` is called once for each pixel of a polygon of which a sample is
    /// to be seen, and what it returns is painted on each of these; see [`Paint`].
    pub fn draw<C: Copy + Send, R: Paint<C> + Copy>(
        &mut self,
        frame: &mut MultisampleFramebuffer<C>,
        geometry: impl Geometry<N>,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) {
        self.draw_by(frame, geometry, PerFragment::new(Shared(&shader)));
    }

    /// Draws by a shader of [`LANES`] pixels at a time, as
    /// [`ZBufferRenderer::draw_blocks`](crate::ZBufferRenderer::draw_blocks). The colours that it is given are
    /// those of each pixel's first sample; those that it leaves are every visible sample's.
    pub fn draw_blocks<C: Copy + Send>(
        &mut self,
        frame: &mut MultisampleFramebuffer<C>,
        geometry: impl Geometry<N>,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        self.draw_by(frame, geometry, PerBlock(Shared(&shader)));
    }

    /// Draws by a shader that returns a colour and alpha from 0 to 1, which becomes coverage: of s samples the
    /// first alpha s, rounded, may be drawn, the others are discarded. So what has soft borders needs
    /// no order.
    pub fn draw_alpha_to_coverage<C: Copy + Send, R: Paint<C> + Copy>(
        &mut self,
        frame: &mut MultisampleFramebuffer<C>,
        geometry: impl Geometry<N>,
        shader: impl Fn(&Fragment<'_, N>) -> (R, f32) + Sync,
    ) {
        self.draw_by(frame, geometry, ToCoverage::new(Shared(&shader)));
    }

    /// Draws depth alone: nothing is shaded.
    pub fn draw_depth<C: Copy + Send>(
        &mut self,
        frame: &mut MultisampleFramebuffer<C>,
        geometry: impl Geometry<N>,
    ) {
        self.draw_by::<C, _, 0>(frame, geometry, NoShader);
    }

    /// Fills a target with a colour, and its depth with that which is behind everything by
    /// [`Settings::depth`].
    pub fn clear<C: Copy>(&self, frame: &mut MultisampleFramebuffer<C>, color: C) {
        frame.clear(color, self.settings.depth.farthest());
    }

    /// Draws by a shader of `M` parameters: all, or none.
    fn draw_by<C: Copy + Send, K, const M: usize>(
        &mut self,
        frame: &mut MultisampleFramebuffer<C>,
        geometry: impl Geometry<N>,
        shader: K,
    ) where
        K: SampleShader<C, M> + Copy + Send,
    {
        let (samples, stride, rect) = (frame.samples(), frame.stride(), frame.rect());
        let at_centroid = self.shading == ShadingPlace::Centroid;
        let raster = SampleRaster { samples, stride, at_centroid };
        let (colors, tiles, depth) = frame.memory();
        if depth.is_empty() {
            return;
        }
        let mut geometry = Some(geometry);
        for_level!(self.simd_level, simd => {
            let mut painter =
                SamplePainter::<_, _, _, M> { simd, colors, tiles, row: samples.count() * stride, rows_before: 0, shader };
            self.submit(geometry.take(), (raster, rect), depth, Shading::OnThreads(&mut painter));
        });
    }

    /// Hands geometry over, once for each kind of geometry, not for each shader.
    #[inline(never)]
    fn submit(
        &mut self,
        geometry: Option<impl Geometry<N>>,
        (raster, rect): (SampleRaster, Rect),
        depth: &mut [f32],
        mut shading: Shading<'_>,
    ) {
        let Some(geometry) = geometry else { return };
        let Self { settings, planes, sorted, mesh, .. } = self;
        settings.collect_planes(planes);
        let mut call = settings.call(rect, planes).by_centres();
        if call.window.is_empty() {
            return;
        }
        call.window.reach = REACH;
        let drawing =
            (self.simd_level, Plan::new(self.depth_test, self.depth_write, settings.depth));
        let mut target = Band::new((0, 0), raster.stride * raster.samples.count(), depth);
        geometry.submit(&mut self.geometry, MOST_AT_ONCE, &mut |batch| {
            let vertices: &dyn Vertices = batch.vertices;
            if batch.is_first {
                mesh.project(&call, drawing.0, vertices);
            }
            let faces = match batch.order {
                Order::BackToFront => sorted.sort(&call, vertices, batch.faces),
                Order::AsGiven | Order::Tree(..) => batch.faces,
            };
            let faces = (vertices, faces);
            mesh.draw_by(&raster, &call, drawing, faces, &mut target, shading.reborrow());
        });
    }
}
