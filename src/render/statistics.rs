//! Statistics: what became of polygons and pixels.

use crate::coverage::area::signed_area_of;
use crate::primitive::ClippedPolygon;
use crate::render::counters::{Counters, PixelCounts};
use crate::render::geometry::Batch;
use crate::render::stroke_style::Figure;
use crate::settings::{Culled, DrawCall};

/// What became of the polygons and the pixels that a renderer was given, added up over draw calls.
///
/// Nothing is counted, and nothing is paid for it, until a renderer's field `statistics` has some. The counts
/// are facts about what is drawn: they are the same at every SIMD level and by any number of threads. To
/// find them each polygon is clipped once more, and none is left out unseen, so drawing takes longer.
///
/// Each polygon is one of `outside`, `culled`, `hidden` and `drawn`, and `polygons` is their sum.
///
/// ```
/// use glam::vec4;
/// use polyscan::render::Statistics;
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
///
/// let square = |z: f32| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []));
/// let mut frame = Framebuffer::new(8, 6, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// renderer.statistics = Some(Statistics::default());
/// for z in [0.5, 0.8, 0.2, 1.5] {
///     renderer.draw(&mut frame, &square(z), |_| '#');
/// }
/// let Statistics { polygons, outside, hidden, drawn, pixels_tested, pixels_drawn, .. } =
///     renderer.statistics.unwrap_or_default();
/// assert_eq!((polygons, outside, hidden, drawn), (4, 1, 1, 2));
/// assert_eq!((pixels_tested, pixels_drawn), (3 * 48, 2 * 48));
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Statistics {
    /// How many polygons were given: faces of meshes, and polygons that were drawn alone. Lines and points
    /// are counted by their pixels only.
    pub polygons: u64,
    /// Those of which nothing can be seen wherever the others are: they lie outside of the view volume or of
    /// the pixels to visit, are not finite, or have an index without a vertex.
    pub outside: u64,
    /// Those that are turned the wrong way, by [`Settings::cull`](crate::Settings::cull).
    pub culled: u64,
    /// Those that were cut by a plane: near, far, one of [`Settings::planes`](crate::Settings::planes), or
    /// the guard band's. They are counted among the hidden or the drawn as well.
    pub clipped: u64,
    /// Those that are neither outside nor culled, of which no pixel was drawn: others hide them, the shader
    /// discarded them, or they cover no pixel's centre.
    pub hidden: u64,
    /// Those of which at least one pixel was drawn, whatever was drawn over it later.
    pub drawn: u64,
    /// The pixels of polygons, lines and points that were compared with what their pixel held. By the
    /// z-buffer and the painter's renderer these are all that are covered; the scanline renderer compares
    /// those of the faces that are to be seen there.
    pub pixels_tested: u64,
    /// Those of them that passed the tests, and for which the shader was called. None where depth
    /// alone is drawn.
    pub pixels_shaded: u64,
    /// Those of them that were drawn: that passed the tests and were not discarded.
    pub pixels_drawn: u64,
}

impl Statistics {
    /// Counts what becomes of faces before there are pixels.
    pub(crate) fn count_faces(
        &mut self,
        call: &DrawCall<'_>,
        batch: &Batch<'_>,
        polygon: &mut ClippedPolygon,
    ) {
        if !matches!(batch.figure, Figure::Faces) {
            return;
        }
        let (vertices, faces) = (batch.vertices, batch.faces);
        let uncut = DrawCall { culled: Culled::None, ..call.clone() };
        self.polygons += faces.len() as u64;
        for face in 0..faces.len() {
            let contours = faces.contours(face).map(|c| c.iter().filter_map(|&i| vertices.get(i)));
            let has_all = |c: &[u32]| c.iter().all(|&i| (i as usize) < vertices.len());
            if !faces.contours(face).all(has_all) || !polygon.clip(&uncut, contours) {
                self.outside += 1;
            } else if call.culled.leaves_out(signed_area_of(polygon.points(), polygon.chains())) {
                self.culled += 1;
            } else if call.window.extent(polygon.points().iter().copied()).is_none() {
                self.outside += 1;
            } else {
                self.hidden += 1;
                self.clipped += u64::from(!polygon.is_whole());
            }
        }
    }

    /// Takes over what was counted while faces were drawn, among the hidden until now.
    pub(crate) fn take_seen(&mut self, batch: &Batch<'_>, counters: &Counters) {
        if matches!(batch.figure, Figure::Faces) {
            let seen = counters.seen();
            self.drawn += seen;
            self.hidden = self.hidden.saturating_sub(seen);
        }
    }

    /// Takes over the pixels that were counted.
    pub(crate) fn take_pixels(&mut self, counters: &Counters) {
        let PixelCounts { tested, shaded, drawn } = counters.pixels();
        self.pixels_tested += tested;
        self.pixels_shaded += shaded;
        self.pixels_drawn += drawn;
    }
}
