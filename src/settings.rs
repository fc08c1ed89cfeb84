//! Settings: how polygons are brought to the screen. Plain data, apart from all memory that work takes.

use crate::coverage::{CoverageRule, FillRule};
use crate::project::Projection;
use crate::subpixel::HALF_PIXEL;
use crate::vertex::Interpolation;
use crate::view_volume::{ClipPlane, ClipSpace};
use crate::viewport::{Rect, Viewport};
use crate::window::Window;

/// Which faces are left out, by the side that is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// None.
    #[default]
    None,
    /// Those whose front is seen.
    Front,
    /// Those whose back is seen, as usual for closed surfaces.
    Back,
}

/// From which side of a face its vertices run in which direction, as seen on the screen. Of several
/// contours the one of the largest area decides: areas are summed with their signs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrontFace {
    /// From the front they run counter-clockwise, as in OBJ and glTF files.
    #[default]
    CounterClockwise,
    /// From the front they run clockwise.
    Clockwise,
}

impl FrontFace {
    /// Whether the front is seen of a polygon, by the direction in which it runs.
    #[inline(always)]
    pub(crate) fn is_front(self, is_clockwise: bool) -> bool {
        is_clockwise == (self == Self::Clockwise)
    }
}

/// The direction in which polygons run that are left out, if any are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Culled {
    None,
    Clockwise,
    CounterClockwise,
}

impl Cull {
    fn direction(self, front: FrontFace) -> Culled {
        let is_clockwise = match self {
            Self::None => return Culled::None,
            Self::Front => front == FrontFace::Clockwise,
            Self::Back => front != FrontFace::Clockwise,
        };
        if is_clockwise { Culled::Clockwise } else { Culled::CounterClockwise }
    }
}

impl Culled {
    /// Whether a polygon is left out, by the sign of its signed area, which is positive if it runs
    /// clockwise. One without area has no side.
    #[inline(always)]
    pub(crate) fn leaves_out(self, signed_area: i128) -> bool {
        match self {
            Self::None => false,
            Self::Clockwise => signed_area > 0,
            Self::CounterClockwise => signed_area < 0,
        }
    }
}

/// What is compared and stored as depth, and which of two depths is nearer. This one setting gives all
/// renderers their test, the value that depth is cleared to, and the order of sorting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DepthMode {
    /// z/w in the viewport's depth range; what is smaller is nearer. Right for any projection. Cleared
    /// to 1.
    #[default]
    Standard,
    /// z/w in the viewport's depth range; what is greater is nearer. For projections with reversed
    /// depth, such as `glam`'s `perspective_infinite_reverse`: near is at 1. Cleared to 0.
    Reversed,
    /// 1/w, which is interpolated anyway (Low, "Perspective-Correct Interpolation", 2002); what is
    /// greater is nearer. It tells nothing in an orthographic projection, where all w are equal.
    /// Cleared to 0.
    InverseW,
}

impl DepthMode {
    /// The depth that is behind everything, to clear a framebuffer to.
    #[must_use]
    pub fn farthest(self) -> f32 {
        if self.is_greater_nearer() { 0.0 } else { 1.0 }
    }

    /// Whether the greater of two depths is nearer.
    #[must_use]
    pub fn is_greater_nearer(self) -> bool {
        self != Self::Standard
    }

    /// Whether the greater of two z/w is nearer.
    pub(crate) fn is_reversed(self) -> bool {
        self == Self::Reversed
    }
}

/// What is added to the depth of a polygon, so that lines and decals lie before the surface that they
/// are on, or shadows do not fall on what throws them. It moves z/w: [`DepthMode::InverseW`] is not
/// changed by it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthBias {
    /// Added everywhere, in units of depth.
    pub constant: f32,
    /// Added times the polygon's slope: the greater of |dz/dx| and |dz/dy| per pixel.
    pub slope: f32,
}

/// How polygons are brought to the screen, for vertices with `N` parameters.
///
/// ```
/// use polyscan::{Cull, Rect, Settings, Viewport};
///
/// let mut settings = Settings::<2>::new(Viewport::new(640, 480)?);
/// settings.cull = Cull::Back;
/// settings.scissor = Some(Rect { x: 0, y: 0, width: 320, height: 480 });
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings<const N: usize> {
    /// Where on the framebuffer the view volume goes.
    pub viewport: Viewport,
    /// The only pixels to visit, if given.
    pub scissor: Option<Rect>,
    /// The depth convention of the vertices' positions.
    pub clip_space: ClipSpace,
    /// Planes to clip by besides those of the view volume.
    pub planes: Vec<ClipPlane>,
    /// Which side of a face is its front.
    pub front_face: FrontFace,
    /// Which faces to leave out.
    pub cull: Cull,
    /// What is inside an outline that is not convex.
    pub fill_rule: FillRule,
    /// Which pixels a polygon covers. The [`ScanlineRenderer`](crate::ScanlineRenderer) knows the rule of
    /// centres alone.
    pub coverage_rule: CoverageRule,
    /// How each parameter is interpolated.
    pub interpolation: [Interpolation; N],
    /// What is depth, and which depth is nearer.
    pub depth: DepthMode,
    /// What is added to depth.
    pub depth_bias: DepthBias,
}

impl<const N: usize> Settings<N> {
    /// All the pixels of a viewport: no scissor, no extra planes, no culling, the non-zero rule,
    /// 0 <= z <= w, pixels by their centres, all parameters in perspective, smaller depth nearer.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            scissor: None,
            clip_space: ClipSpace::default(),
            planes: Vec::new(),
            front_face: FrontFace::default(),
            cull: Cull::default(),
            fill_rule: FillRule::default(),
            coverage_rule: CoverageRule::default(),
            interpolation: [Interpolation::default(); N],
            depth: DepthMode::default(),
            depth_bias: DepthBias::default(),
        }
    }

    /// The rows to visit, from the viewport's top: all of them, or those within the
    /// [`scissor`](Self::scissor). This is what an [edge table](crate::coverage::EdgeTable) is filled
    /// for.
    #[must_use]
    pub fn rows(&self) -> std::ops::Range<i32> {
        Window::new(&self.viewport, self.scissor, self.viewport.rect()).rows
    }

    /// All planes that polygons are clipped by: near, far, the sides of the guard band, and the
    /// [`planes`](Self::planes) given.
    #[must_use]
    pub fn all_planes(&self) -> Vec<ClipPlane> {
        let mut planes = Vec::new();
        self.collect_planes(&mut planes);
        planes
    }

    /// Replaces `planes` by all planes to clip by.
    pub(crate) fn collect_planes(&self, planes: &mut Vec<ClipPlane>) {
        planes.clear();
        planes.extend(self.clip_space.drawable(&self.viewport));
        planes.extend(&self.planes);
    }

    /// What follows for one draw call into a rectangle of pixels. `planes` are all planes to clip by.
    pub(crate) fn call<'a>(&'a self, bounds: Rect, planes: &'a [ClipPlane]) -> DrawCall<'a> {
        let mut window = Window::new(&self.viewport, self.scissor, bounds);
        if self.coverage_rule.is_outer() {
            window.reach = HALF_PIXEL as i32;
        }
        DrawCall {
            viewport: self.viewport,
            clip_space: self.clip_space,
            planes,
            front_face: self.front_face,
            culled: self.cull.direction(self.front_face),
            fill_rule: self.fill_rule,
            coverage_rule: self.coverage_rule,
            interpolation: &self.interpolation,
            is_all_perspective: self.interpolation == [Interpolation::Perspective; N],
            depth: self.depth,
            depth_bias: self.depth_bias,
            projection: Projection::new(&self.viewport, self.clip_space),
            window,
        }
    }
}

/// What follows from the settings for one draw call.
#[derive(Clone, Debug)]
pub(crate) struct DrawCall<'a> {
    pub(crate) viewport: Viewport,
    pub(crate) clip_space: ClipSpace,
    /// All planes to clip by.
    pub(crate) planes: &'a [ClipPlane],
    pub(crate) front_face: FrontFace,
    pub(crate) culled: Culled,
    pub(crate) fill_rule: FillRule,
    pub(crate) coverage_rule: CoverageRule,
    pub(crate) interpolation: &'a [Interpolation],
    pub(crate) is_all_perspective: bool,
    pub(crate) depth: DepthMode,
    pub(crate) depth_bias: DepthBias,
    pub(crate) projection: Projection,
    /// The columns and rows to visit.
    pub(crate) window: Window,
}

impl DrawCall<'_> {
    /// The same, with pixels that are covered by their centres.
    pub(crate) fn by_centres(mut self) -> Self {
        self.coverage_rule = CoverageRule::Centre;
        self.window.reach = 0;
        self
    }

    /// The number of parameters.
    pub(crate) fn params(&self) -> usize {
        self.interpolation.len()
    }

    /// Whether all values are known to be affine on a polygon of so many sides, clipped or not. On a
    /// triangle they are, also after it was clipped; but what is linear on the screen has no linear
    /// continuation behind the eye.
    pub(crate) fn is_affine(&self, sides: usize, is_clipped: bool) -> bool {
        sides == 3 && !(is_clipped && self.interpolation.contains(&Interpolation::Linear))
    }
}
