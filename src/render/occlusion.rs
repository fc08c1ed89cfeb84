//! Occlusion culling without pixels: occluders are drawn into tiles that know how far what is seen in them
//! may be, and boxes are held against these, before what is in the boxes is drawn (J. Hasselgren, M. Andersson
//! and T. Akenine-Moeller, "Masked Software Occlusion Culling", High Performance Graphics 2016).
//!
//! ```text
//!     |<- 32 pixels ->|
//!     +---------------+
//!     |.......########|     8 rows: a bit for each pixel. Where it is set nothing is farther than the
//!     |.....##########|     tile's near bound, elsewhere nothing is farther than its far bound.
//!     |...############|     Once all are set the near bound becomes the far one.
//!     +---------------+
//! ```
//!
//! Depths are kept as what grows with the distance: z, or -z where greater depth is nearer.

mod tiles;

use fearless_simd::{Level, Simd};
use glam::{Mat4, Vec3};

use crate::coverage::shape::Coverage;
use crate::outline::Chain;
use crate::project::Projection;
use crate::render::band::Band;
use crate::render::faces::MOST_AT_ONCE;
use crate::render::geometry::{Geometry, GeometryMemory};
use crate::render::mesh::{FaceRaster, MeshMemory};
use crate::render::occlusion::tiles::Tiles;
use crate::render::parallel::Shading;
use crate::render::raster::plan::Plan;
use crate::render::shader::ShadeBlocks;
use crate::render::stroke_style::Figure;
use crate::settings::{DrawCall, Settings};
use crate::subpixel::SubpixelPoint;
use crate::surface::batch::GatheredTriangles;
use crate::surface::rows::SurfaceView;
use crate::view_volume::ClipPlane;
use crate::viewport::{Rect, SizeError, Viewport};

/// The rounding of `f32` on the way from a box to depths on the screen, as a part of the sums of magnitudes:
/// sixteen units in the last place.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// How far outside of its exact outline a polygon may cover a pixel's centre: corners are rounded to 1/256
/// pixel. More than that, for what is added up in `f64`.
const OUTSIDE: f64 = 1.0 / 64.0;

/// Draws occluders without pixels, and says which boxes are hidden behind them: before a scene is drawn, so
/// that what is hidden need not be. 40 bytes for each 32 x 8 pixels are all its memory.
///
/// It is conservative: what [`is_hidden`](Self::is_hidden) says is hidden is hidden at every pixel, in the
/// picture that a renderer with the same [`Settings`] draws of the occluders, under any
/// [`DepthTest`](crate::DepthTest) for what is nearer, or as near. Something that is hidden may be said to be
/// seen: bounds are kept for tiles, not for pixels.
///
/// ```
/// use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
/// use glam::{Vec3, vec3};
/// use polyscan::render::OcclusionRenderer;
/// use polyscan::{Mesh, Vertex, Viewport};
///
/// let camera = perspective(1.0, 4.0 / 3.0, 0.1, 100.0)
///     * look_at_mat4(vec3(0.0, 1.0, 5.0), Vec3::ZERO, Vec3::Y);
/// let wall = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)]
///     .map(|(x, y)| Vertex::new(camera * vec3(x, y, 0.0).extend(1.0), []));
/// let mut occlusion = OcclusionRenderer::new(Viewport::new(640, 480)?)?;
/// occlusion.draw(Mesh::new(&wall, [[0, 1, 2, 3]]));
/// // From one corner to the opposite one, in object space.
/// let chair = [vec3(-0.3, -0.5, -3.0), vec3(0.3, 0.4, -2.0)];
/// assert!(occlusion.is_hidden(camera, chair));
/// assert!(!occlusion.is_hidden(camera, chair.map(|corner| corner + Vec3::Z * 3.0)));
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// `N` is the number of parameters that the occluders' vertices have; none is looked at.
#[derive(Clone, Debug)]
pub struct OcclusionRenderer<const N: usize> {
    /// Where and how occluders are brought to the screen. [`DepthMode::InverseW`](crate::DepthMode::InverseW)
    /// counts as [`DepthMode::Standard`](crate::DepthMode::Standard) here, and pixels are covered by their
    /// centres.
    pub settings: Settings<N>,
    /// The SIMD instructions to use: the best that the machine has, unless changed.
    pub simd_level: Level,
    tiles: Tiles,
    /// A number for each row of pixels, in place of depths: by these rows are given to threads.
    rows: Vec<f32>,
    geometry: GeometryMemory<N>,
    planes: Vec<ClipPlane>,
    mesh: MeshMemory<()>,
}

impl<const N: usize> OcclusionRenderer<N> {
    /// A renderer to a viewport's size, with the settings of [`Settings::new`].
    ///
    /// # Errors
    /// When a side is longer than [`MAX_SIZE`](crate::viewport::MAX_SIZE), or there is not enough memory for
    /// the tiles.
    pub fn new(viewport: Viewport) -> Result<Self, SizeError> {
        let Rect { width, height, .. } = viewport.rect();
        SizeError::check(width, height)?;
        let error = SizeError::new(width, height, "there is not enough memory for its tiles");
        Ok(Self {
            settings: Settings::new(viewport),
            simd_level: Level::new(),
            tiles: Tiles::new(width as usize, height as usize).ok_or(error)?,
            rows: vec![0.0; height as usize],
            geometry: GeometryMemory::default(),
            planes: Vec::new(),
            mesh: MeshMemory::default(),
        })
    }

    /// Forgets all occluders.
    pub fn clear(&mut self) {
        self.tiles.clear();
    }

    /// Draws occluders: polygons and meshes, which hide what is behind them from now on. Lines and points hide
    /// nothing.
    pub fn draw(&mut self, geometry: impl Geometry<N>) {
        let Self { settings, simd_level: level, tiles, rows, geometry: memory, planes, mesh } =
            self;
        settings.collect_planes(planes);
        let (width, height) = tiles.size();
        let bounds = Rect { x: 0, y: 0, width: width as u32, height: height as u32 };
        let call = settings.call(bounds, planes).by_centres();
        if call.window.is_empty() {
            return;
        }
        let mut target = Band::new((0, 0), 1, rows);
        let mut painter = tiles.painter(call.depth.is_reversed());
        let drawing = (*level, Plan::COMMON);
        geometry.submit(memory, MOST_AT_ONCE, &mut |batch| {
            if !matches!(batch.figure, Figure::Faces) {
                return;
            }
            if batch.is_first {
                mesh.project(&call, *level, batch.vertices);
            }
            let faces = (batch.vertices, batch.faces);
            let shading = Shading::OnThreads(&mut painter);
            mesh.draw_by(&OcclusionRaster, &call, drawing, faces, &mut target, shading);
        });
    }

    /// Whether nothing of a box can be seen, wherever in it: the box from one corner to the opposite one, in
    /// object space, seen through `clip_from_object`, which must be finite. So is what lies beside the picture.
    /// A box that reaches through the near plane is never hidden.
    ///
    /// What is in the box is hidden if its vertices are `clip_from_object * position`, computed in `f32`, and
    /// if it is drawn without [bias](crate::DepthBias).
    #[must_use]
    pub fn is_hidden(&self, clip_from_object: Mat4, corners: [Vec3; 2]) -> bool {
        let projection = Projection::new(&self.settings.viewport, self.settings.clip_space);
        let is_reversed = self.settings.depth.is_reversed();
        let Some(seen) = BoxOnScreen::new(&projection, clip_from_object, corners, is_reversed)
        else {
            return false;
        };
        self.tiles.hides(seen.columns, seen.rows, seen.nearest)
    }
}

/// The pixels that a box may cover, and what its nearest depth is at least.
struct BoxOnScreen {
    /// The first and the one after the last, on the framebuffer.
    columns: [f64; 2],
    rows: [f64; 2],
    nearest: f64,
}

impl BoxOnScreen {
    /// `None` if it reaches through the near plane, or if nothing can be said of it.
    fn new(
        projection: &Projection,
        clip_from_object: Mat4,
        [from, to]: [Vec3; 2],
        is_reversed: bool,
    ) -> Option<Self> {
        let matrix = clip_from_object.as_dmat4();
        let least = if projection.has_negative_z() { -1.0 } else { 0.0 };
        let (mut columns, mut rows) =
            ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        let mut nearest = f64::INFINITY;
        for corner in 0..8 {
            let choose = |axis: usize| if corner >> axis & 1 != 0 { to[axis] } else { from[axis] };
            let corner = Vec3::new(choose(0), choose(1), choose(2)).as_dvec3().extend(1.0);
            let clip = matrix * corner;
            let magnitudes = [0, 1, 2, 3].map(|i| (matrix.row(i) * corner).abs().element_sum());
            let [off_x, off_y, off_z, off_w] = magnitudes.map(|sum| sum * ROUNDING);
            // In front of the eye and of the near plane, by more than rounding. This is false for NaN.
            let is_in_front =
                clip.w > 2.0 * off_w && clip.z - least * clip.w > off_z + off_w && clip.is_finite();
            if !is_in_front {
                return None;
            }
            let [x, y] = [clip.x, clip.y].map(|value| value / clip.w);
            let point = projection.point(clip.to_array());
            let [width, height] = projection.pixels();
            // Dividing by w takes its part of the error: w is off by less than half of itself.
            let off = |off: f64, value: f64| 2.0 * (off + value.abs() * off_w) / clip.w;
            let [off_x, off_y] =
                [off(off_x, x) * width, off(off_y, y) * height].map(|off| off + OUTSIDE);
            columns = [columns[0].min(point.x - off_x), columns[1].max(point.x + off_x)];
            rows = [rows[0].min(point.y - off_y), rows[1].max(point.y + off_y)];
            let depth = if is_reversed { -point.z } else { point.z };
            nearest = nearest.min(depth - off(off_z, clip.z / clip.w) - ROUNDING);
        }
        // The centres of pixels, on the framebuffer.
        let (left, top) = projection.corner;
        let centres = |[first, last]: [f64; 2], corner: i32| {
            [
                (first - 0.5).ceil() + f64::from(corner),
                (last - 0.5).floor() + 1.0 + f64::from(corner),
            ]
        };
        Some(Self { columns: centres(columns, left), rows: centres(rows, top), nearest })
    }
}

/// Draws faces into tiles.
struct OcclusionRaster;

impl FaceRaster for OcclusionRaster {
    type Memory = ();
    const HAS_COARSE_DEPTH: bool = false;

    #[inline(always)]
    fn take_batch<S: Simd>(
        &self,
        _: S,
        _: &GatheredTriangles,
        _: &std::ops::Range<i32>,
        (): &mut (),
    ) {
    }

    #[inline(always)]
    fn take_outline(&self, _: &[SubpixelPoint], _: &[Chain], (): &mut ()) {}

    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        _: S,
        (call, _): (&DrawCall<'_>, Plan),
        (surface, coverage): (&SurfaceView<'_>, Coverage<'_>),
        _: &mut Band<'_>,
        (): &mut (),
        shader: &mut dyn ShadeBlocks,
    ) {
        let columns = &call.window.columns;
        coverage.for_each_group(false, |runs| shader.cover(surface, runs, columns));
    }
}
