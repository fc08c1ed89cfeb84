//! What a shader is given: one fragment, or a block of them as arrays.

use glam::Vec2;

use crate::coverage::Run;
use crate::coverage::run::RunGroup;
use crate::fragment::block::{Found, HALF_BLOCK, LANES, Lanes};
use crate::fragment::footprint::{Footprint, FootprintBlock};
use crate::surface::base::Divide;
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
    /// The reciprocal of 1/w, in the polygon's unit, as it is.
    per_w: f32,
    pub(super) origin: Origin<'a>,
}

/// Where a fragment comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin<'a> {
    pub(super) surface: &'a SurfaceView<'a>,
    pub(super) runs: &'a RunGroup,
    pub(super) row: usize,
}

impl Origin<'_> {
    pub(super) fn run(&self) -> Run {
        self.runs.run(self.row)
    }
}

impl<const N: usize> Fragment<'_, N> {
    /// The parameters' derivatives with respect to screen x (to the right) and screen y (down), per
    /// pixel; see [`derivative`](Self::derivative).
    #[must_use]
    pub fn derivatives(&self) -> ([f32; N], [f32; N]) {
        let (mut dx, mut dy) = ([0.0; N], [0.0; N]);
        for (i, (dx, dy)) in dx.iter_mut().zip(&mut dy).enumerate() {
            [*dx, *dy] = self.derivative(i);
        }
        (dx, dy)
    }

    /// The derivatives of parameter `i` with respect to screen x (to the right) and screen y (down), per
    /// pixel; 0 if there is no such parameter.
    ///
    /// They come from the planes of s and 1/w by the quotient rule, without a neighbouring pixel, and
    /// are exact to 1e-5 of the larger of the two. For r = s / q and planes s and q,
    ///
    /// ```text
    /// dr/dx = (s_x q - s q_x) / q^2        dr/dy = (s_y q - s q_y) / q^2
    /// ```
    ///
    /// where the first numerator is the same all along a row, and the second all along a column.
    ///
    /// Where a polygon of four or more sides carries what is not affine on it, s and q are interpolated
    /// along the edges and across the row: s_x and q_x are then their changes along the row, exactly,
    /// and s_y and q_y their changes to the next row at the same x, as long as that row is between the
    /// same two edges.
    #[inline(always)]
    #[must_use]
    pub fn derivative(&self, i: usize) -> [f32; 2] {
        let Origin { surface, runs, row } = self.origin;
        if i >= N {
            return [0.0; 2];
        }
        let x = self.x.wrapping_sub(surface.base.corner.0);
        match surface.base.divide {
            _ if surface.is_by_edges(i) => surface.mixed_slopes(i, x, &self.origin.run()),
            Divide::PerPixel => {
                let slopes = surface.slopes(i);
                let along_x = slopes.numerator_x(runs.y + row as i32);
                let along_y = slopes.numerator_y(x);
                [along_x, along_y].map(|numerator| numerator * self.per_w * self.per_w)
            }
            Divide::Never => surface.undivided_slopes(i),
            Divide::Mixed => surface.mixed_slopes(i, x, &self.origin.run()),
        }
    }

    /// The texture coordinate (r_u, r_v) with its derivatives, of parameters `u` and `v`: what a texture
    /// has to know to filter.
    #[inline(always)]
    #[must_use]
    pub fn footprint(&self, u: usize, v: usize) -> Footprint {
        let param = |i: usize| self.params.get(i).copied().unwrap_or(0.0);
        let ([dudx, dudy], [dvdx, dvdy]) = (self.derivative(u), self.derivative(v));
        Footprint {
            uv: Vec2::new(param(u), param(v)),
            dx: Vec2::new(dudx, dvdx),
            dy: Vec2::new(dudy, dvdy),
        }
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
    /// The reciprocals of 1/w, in the polygon's unit, as they are.
    per_w: Lanes,
    pub(super) surface: &'a SurfaceView<'a>,
    pub(super) runs: &'a RunGroup,
    /// Of each half, the column of its first lane, relative to the viewport, and its row in `runs`.
    pub(super) halves: [(i32, usize); 2],
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
            per_w: [1.0; LANES],
            surface,
            runs,
            halves,
        }
    }

    /// Where values go that a [`Block`](crate::fragment::block::Block) finds.
    #[inline(always)]
    pub(crate) fn found(&mut self) -> Found<'_, N> {
        Found { w: &mut self.w, per_w: &mut self.per_w, params: &mut self.params }
    }

    /// The derivatives of parameter `i` with respect to screen x and screen y, per pixel: the same
    /// numbers as [`Fragment::derivative`]. A shader that does not ask for them pays nothing.
    #[inline(always)]
    #[must_use]
    pub fn derivative(&self, i: usize) -> [Lanes; 2] {
        let Self { surface, runs, .. } = *self;
        if i >= N {
            return [[0.0; LANES]; 2];
        }
        let (mut dx, mut dy) = ([0.0; LANES], [0.0; LANES]);
        match surface.base.divide {
            _ if surface.is_by_edges(i) => self.mixed_derivative(i, [&mut dx, &mut dy]),
            Divide::PerPixel => {
                let slopes = surface.slopes(i);
                for (half, (x, row)) in self.halves.into_iter().enumerate() {
                    let along_x = slopes.numerator_x(runs.y + row as i32);
                    for lane in 0..HALF_BLOCK {
                        let (column, lane) = (x + lane as i32, half * HALF_BLOCK + lane);
                        let per_w = self.per_w[lane];
                        dx[lane] = along_x * per_w * per_w;
                        dy[lane] = slopes.numerator_y(column) * per_w * per_w;
                    }
                }
            }
            Divide::Never => {
                let [x, y] = surface.undivided_slopes(i);
                (dx, dy) = ([x; LANES], [y; LANES]);
            }
            Divide::Mixed => self.mixed_derivative(i, [&mut dx, &mut dy]),
        }
        [dx, dy]
    }

    #[cold]
    fn mixed_derivative(&self, i: usize, [dx, dy]: [&mut Lanes; 2]) {
        for (lane, (dx, dy)) in dx.iter_mut().zip(dy).enumerate() {
            if self.visible >> lane & 1 != 0 {
                [*dx, *dy] = self.fragment(lane).derivative(i);
            }
        }
    }

    /// The texture coordinates (r_u, r_v) with their derivatives, as [`Fragment::footprint`].
    #[inline(always)]
    #[must_use]
    pub fn footprint(&self, u: usize, v: usize) -> FootprintBlock {
        let param = |i: usize| self.params.get(i).copied().unwrap_or([0.0; LANES]);
        let ([dudx, dudy], [dvdx, dvdy]) = (self.derivative(u), self.derivative(v));
        FootprintBlock { uv: [param(u), param(v)], dx: [dudx, dvdx], dy: [dudy, dvdy] }
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
            per_w: self.per_w[lane],
            origin: Origin { surface: self.surface, runs: self.runs, row },
        }
    }
}
