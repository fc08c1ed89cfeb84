//! What a shader is given: one fragment, or a block of them as arrays.

use crate::coverage::Run;
use crate::coverage::run::RunGroup;
use crate::fragment::block::{HALF_BLOCK, LANES, Lanes};
use crate::surface::mixed::Component;
use crate::surface::rows::SurfaceView;

/// A pixel that a polygon covers.
#[derive(Clone, Copy, Debug)]
pub struct Fragment<'a, const N: usize> {
    /// The column on the framebuffer.
    pub x: i32,
    /// The row on the framebuffer.
    pub y: i32,
    /// The number of the polygon among the faces of its mesh, from 0 in the order in which they were
    /// given; 0 for a polygon that is drawn alone.
    pub face: u32,
    /// Whether the polygon's front is seen, by [`Settings::front_face`](crate::Settings::front_face).
    pub front_facing: bool,
    /// z/w after the viewport's depth range, between the depths of the polygon's vertices. It is that
    /// whatever the [`DepthMode`](crate::DepthMode): with 1/w as depth a renderer stores another number.
    pub depth: f32,
    /// The w of clip space, between those of the polygon's vertices. With the usual matrices this is
    /// the distance from the eye along the direction of view, in the units of object space.
    pub w: f32,
    /// The parameters r_1 .. r_N.
    pub params: [f32; N],
    origin: Origin<'a>,
}

/// Where a fragment comes from.
#[derive(Clone, Copy, Debug)]
struct Origin<'a> {
    surface: &'a SurfaceView<'a>,
    runs: &'a RunGroup,
    row: usize,
}

impl Origin<'_> {
    fn run(&self) -> Run {
        self.runs.run(self.row)
    }
}

impl<const N: usize> Fragment<'_, N> {
    /// The parameters' exact derivatives with respect to screen x (to the right) and screen y
    /// (down), per pixel, from the planes of s and 1/w by the quotient rule; no neighbouring pixel is
    /// involved.
    #[must_use]
    pub fn derivatives(&self) -> ([f32; N], [f32; N]) {
        let Origin { surface, .. } = self.origin;
        let run = self.origin.run();
        let x = self.x.wrapping_sub(surface.base.corner.0);
        let inv_w = surface.at(Component::InvW, x, &run);
        let (_, inv_w_dx) = surface.along(Component::InvW, &run);
        let inv_w_dy = surface.downwards(Component::InvW, x, &run);
        let (mut dx, mut dy) = ([0.0; N], [0.0; N]);
        for (i, (dx, dy)) in dx.iter_mut().zip(&mut dy).enumerate() {
            let component = Component::S(i);
            let (_, s_dx) = surface.along(component, &run);
            let s_dy = surface.downwards(component, x, &run);
            if surface.times_w(i) {
                let r = surface.at(component, x, &run) / inv_w;
                *dx = ((s_dx - r * inv_w_dx) / inv_w) as f32;
                *dy = ((s_dy - r * inv_w_dy) / inv_w) as f32;
            } else {
                (*dx, *dy) = (s_dx as f32, s_dy as f32);
            }
        }
        (dx, dy)
    }
}

/// [`LANES`] pixels of a polygon as arrays, for shaders that work on all of them at once. They are
/// neighbours in a row, or one half of them in a row and the other in another.
#[derive(Clone, Debug)]
pub struct FragmentBlock<'a, const N: usize> {
    /// The number of the polygon, as [`Fragment::face`].
    pub face: u32,
    /// Whether the polygon's front is seen, as [`Fragment::front_facing`].
    pub front_facing: bool,
    /// Which lanes are drawn, a bit a lane, bit 0 for lane 0. The values of other lanes mean
    /// nothing. A shader discards fragments by clearing their bits.
    pub visible: u32,
    /// Depths, as [`Fragment::depth`].
    pub depth: Lanes,
    /// The w of clip space, as [`Fragment::w`].
    pub w: Lanes,
    /// The parameters r_1 .. r_N, as [`Fragment::params`].
    pub params: [Lanes; N],
    surface: &'a SurfaceView<'a>,
    runs: &'a RunGroup,
    /// Of each half, the column of its first lane, relative to the viewport, and its row in `runs`.
    halves: [(i32, usize); 2],
}

impl<'a, const N: usize> FragmentBlock<'a, N> {
    /// A block without values: whoever makes it fills in the depths, w and parameters.
    #[inline(always)]
    pub(crate) fn new(
        surface: &'a SurfaceView<'a>,
        runs: &'a RunGroup,
        halves: [(i32, usize); 2],
        visible: u32,
    ) -> Self {
        Self {
            face: surface.base.face,
            front_facing: surface.base.is_front,
            visible,
            depth: [0.0; LANES],
            w: [surface.base.w.range().0; LANES],
            params: [[0.0; LANES]; N],
            surface,
            runs,
            halves,
        }
    }

    /// The column and the row of a lane on the framebuffer, as [`Fragment::x`] and [`Fragment::y`].
    /// Lanes beyond the last count as the last.
    #[inline(always)]
    #[must_use]
    pub fn position(&self, lane: usize) -> (i32, i32) {
        let lane = lane.min(LANES - 1);
        let (x, row) = self.halves[lane / HALF_BLOCK];
        let (left, top) = self.surface.base.corner;
        let x = x.wrapping_add((lane % HALF_BLOCK) as i32).wrapping_add(left);
        (x, self.runs.y + row as i32 + top)
    }

    /// One of the fragments. Lanes beyond the last count as the last.
    #[inline(always)]
    #[must_use]
    pub fn fragment(&self, lane: usize) -> Fragment<'a, N> {
        let lane = lane.min(LANES - 1);
        let mut params = [0.0; N];
        for (param, lanes) in params.iter_mut().zip(&self.params) {
            *param = lanes[lane];
        }
        let (x, y) = self.position(lane);
        let (_, row) = self.halves[lane / HALF_BLOCK];
        Fragment {
            x,
            y,
            face: self.face,
            front_facing: self.front_facing,
            depth: self.depth[lane],
            w: self.w[lane],
            params,
            origin: Origin { surface: self.surface, runs: self.runs, row },
        }
    }
}
