//! Occlusion queries: how much of what is not drawn would be seen.

use fearless_simd::Level;

use crate::render::front::{self, Counting, Parts, Renderer};
use crate::render::geometry::Geometry;
use crate::render::stencil::Stencil;
use crate::render::target::RenderTarget;
use crate::render::z_buffer::{Drawer, ZBufferRenderer};
use crate::settings::DepthMode;

/// A renderer that draws nothing, and counts the pixels that it would draw.
struct Query<'a, const N: usize> {
    renderer: &'a mut ZBufferRenderer<N>,
    until_first: bool,
    pixels: u64,
}

impl<const N: usize> Renderer<N> for Query<'_, N> {
    type Drawer = Drawer;

    fn parts(&mut self) -> Parts<'_, Drawer, N> {
        let Self { renderer, until_first, pixels } = self;
        let counting = if *until_first { Counting::Any(pixels) } else { Counting::Drawn(pixels) };
        let mut parts = renderer.parts();
        parts.plan.writes = false;
        let stencil = parts.stencil.map(|stencil| Stencil { write_mask: 0, ..stencil });
        Parts { stencil, counting, ..parts }
    }

    fn level(&self) -> Level {
        self.renderer.simd_level
    }

    fn depth_mode(&self) -> DepthMode {
        self.renderer.settings.depth
    }
}

impl<const N: usize> ZBufferRenderer<N> {
    /// How many pixels of geometry pass the tests of depth, and of the stencil if there is one: those that
    /// `draw_depth` would draw, where polygons behind each other count one by one. Nothing is drawn, and
    /// nothing on the target changes.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// let square = |size: f32, z: f32| [(-size, -size), (size, -size), (size, size), (-size, size)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []));
    /// let mut frame = Framebuffer::new(8, 8, ())?;
    /// let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// renderer.draw_depth(&mut frame, &square(0.5, 0.4));
    /// assert_eq!(renderer.count_visible(&mut frame, &square(1.0, 0.6)), 64 - 16);
    /// assert!(!renderer.is_any_visible(&mut frame, &square(0.5, 0.6)));
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn count_visible(
        &mut self,
        frame: &mut impl RenderTarget,
        geometry: impl Geometry<N>,
    ) -> u64 {
        let mut query = Query { renderer: self, until_first: false, pixels: 0 };
        front::draw_depth(&mut query, frame, geometry);
        query.pixels
    }

    /// Whether a pixel of geometry passes the tests, as [`count_visible`](Self::count_visible) counts them. What
    /// is left after the first is not looked at.
    pub fn is_any_visible(
        &mut self,
        frame: &mut impl RenderTarget,
        geometry: impl Geometry<N>,
    ) -> bool {
        let mut query = Query { renderer: self, until_first: true, pixels: 0 };
        front::draw_depth(&mut query, frame, geometry);
        query.pixels > 0
    }
}
