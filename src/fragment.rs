//! Fragments: one pixel of one polygon, with depth, w and parameters.
//!
//! A span goes in. It is evaluated in blocks of [`LANES`] pixels: each of (z, s_1 .. s_n, s_{n+1})
//! is its value at one end of the span plus a multiple of its change per pixel, so error does not
//! build up along the span. Then comes the one reciprocal a pixel, w = 1 / s_{n+1}, and
//! r_i = s_i w (Heckbert and Moreton 1991, section 3.5); if all w are equal, there is nothing to
//! divide.
//!
//! The end is that of the polygon, visible or not. So a fragment is a function of the polygon and
//! the pixel alone, and a picture is the same to the bit however it is cut into tiles.

use fearless_simd::{
    Level, Select, Simd, SimdBase, SimdFrom, SimdMask, dispatch, f32x16, mask32x16,
};

use crate::polygon::{Method, ScreenPolygon, WRange};
use crate::project::Component;
use crate::scan::SpanPair;
use crate::span::{Place, Span};

/// The number of pixels in a block.
pub const LANES: usize = 16;

/// One value for each pixel of a block.
pub type Lanes = [f32; LANES];

/// All lanes of a block, a bit a lane.
pub(crate) const ALL: u32 = (1 << LANES) - 1;

/// The number of pixels in each half of a block.
pub(crate) const HALF: usize = LANES / 2;

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
    /// z/w after the viewport's depth range, between the depths of the polygon's vertices.
    pub depth: f32,
    /// The w of clip space, between those of the polygon's vertices.
    pub w: f32,
    /// The parameters r_1 .. r_N.
    pub params: [f32; N],
    place: Place<'a, N>,
}

impl<const N: usize> Fragment<'_, N> {
    /// The parameters' exact derivatives with respect to screen x (to the right) and screen y
    /// (down), per pixel, from the planes of s and 1/w; no neighbouring pixel is involved.
    pub fn derivatives(&self) -> ([f32; N], [f32; N]) {
        self.place.derivatives(self.x.wrapping_sub(self.place.polygon.corner.0))
    }
}

/// Iterator over the fragments of a span.
#[derive(Clone, Debug)]
pub struct Fragments<'a, const N: usize> {
    span: &'a Span<'a, N>,
    /// The first column, relative to the viewport, that `block` does not have.
    next: i32,
    block: Option<FragmentBlock<'a, N>>,
}

impl<'a, const N: usize> Fragments<'a, N> {
    pub(crate) fn new(span: &'a Span<'a, N>) -> Self {
        Self { span, next: span.x.start, block: None }
    }
}

impl<'a, const N: usize> Iterator for Fragments<'a, N> {
    type Item = Fragment<'a, N>;

    fn next(&mut self) -> Option<Fragment<'a, N>> {
        loop {
            if let Some(block) = &mut self.block
                && block.visible != 0
            {
                let lane = block.visible.trailing_zeros() as usize;
                block.visible &= block.visible - 1;
                return Some(block.fragment(lane));
            }
            if self.next >= self.span.x.end {
                return None;
            }
            let x = self.next;
            self.next += LANES as i32;
            self.block = Some(dispatch!(Level::baseline(), simd => {
                let block = Block::new(simd, self.span, x);
                block.fragments(block.depth(), block.lanes(), self.span.place.polygon.method)
            }));
        }
    }
}

/// [`LANES`] pixels of a polygon as arrays, for shaders that work on all of them at once. They are
/// neighbours in a row, or one half of them in a row and the other in another.
#[derive(Clone, Debug)]
pub struct FragmentBlock<'a, const N: usize> {
    /// The number of the polygon, as [`Fragment::face`].
    pub face: u32,
    /// Which lanes are drawn, a bit a lane, bit 0 for lane 0. The values of other lanes mean
    /// nothing. A shader discards fragments by clearing their bits.
    pub visible: u32,
    /// Depths, as [`Fragment::depth`].
    pub depth: Lanes,
    /// The w of clip space, as [`Fragment::w`].
    pub w: Lanes,
    /// The parameters r_1 .. r_N, as [`Fragment::params`].
    pub params: [Lanes; N],
    /// Of each half, the column of its first lane on the framebuffer, and where it comes from.
    halves: [(i32, &'a Place<'a, N>); 2],
}

impl<'a, const N: usize> FragmentBlock<'a, N> {
    /// The column and the row of a lane on the framebuffer, as [`Fragment::x`] and [`Fragment::y`].
    /// Lanes from [`LANES`] on are none; they give the last.
    #[inline(always)]
    pub fn position(&self, lane: usize) -> (i32, i32) {
        let lane = lane.min(LANES - 1);
        let (x, place) = &self.halves[lane / HALF];
        (x.wrapping_add((lane % HALF) as i32), place.y())
    }

    /// One of the fragments. Lanes from [`LANES`] on are none; they give the last.
    #[inline(always)]
    pub fn fragment(&self, lane: usize) -> Fragment<'a, N> {
        let lane = lane.min(LANES - 1);
        let mut params = [0.0; N];
        for (param, lanes) in params.iter_mut().zip(&self.params) {
            *param = lanes[lane];
        }
        let (x, y) = self.position(lane);
        Fragment {
            x,
            y,
            face: self.face,
            depth: self.depth[lane],
            w: self.w[lane],
            params,
            place: *self.halves[lane / HALF].1,
        }
    }
}

/// Where the pixels of a block come from: a span, or two spans of the same polygon.
pub(crate) trait Source<'s, const N: usize>: Copy {
    fn polygon(self) -> &'s ScreenPolygon<N>;

    /// A value at the ends of the spans where they are given, for each lane, and its change per pixel.
    fn line<S: Simd>(self, simd: S, component: Component) -> (f32x16<S>, f32);

    /// The column of the first lane of a half, relative to the viewport, and its span's place. `x` is
    /// the column of lane 0, where that is in a span's row.
    fn half(self, half: usize, x: i32) -> (i32, &'s Place<'s, N>);
}

impl<'s, const N: usize> Source<'s, N> for &'s Span<'_, N> {
    #[inline(always)]
    fn polygon(self) -> &'s ScreenPolygon<N> {
        self.place.polygon
    }

    #[inline(always)]
    fn line<S: Simd>(self, simd: S, component: Component) -> (f32x16<S>, f32) {
        let at = *self.line.at.get(component);
        (f32x16::splat(simd, at), *self.line.delta.get(component))
    }

    #[inline(always)]
    fn half(self, half: usize, x: i32) -> (i32, &'s Place<'s, N>) {
        (x.wrapping_add((half * HALF) as i32), &self.place)
    }
}

impl<'s, const N: usize> Source<'s, N> for SpanPair<'s, N> {
    #[inline(always)]
    fn polygon(self) -> &'s ScreenPolygon<N> {
        self.group.polygon
    }

    #[inline(always)]
    fn line<S: Simd>(self, simd: S, component: Component) -> (f32x16<S>, f32) {
        let [lower, upper] = self.of(self.group.lines.at.get(component));
        (halves(simd, lower, upper), *self.group.polygon.delta.get(component))
    }

    #[inline(always)]
    fn half(self, half: usize, _: i32) -> (i32, &'s Place<'s, N>) {
        (self.of(&self.group.start)[half], &self.places[half])
    }
}

/// [`LANES`] pixels, some of which belong to a polygon: what is linear over the screen there, and
/// what follows from it. They are neighbours in the row of a span, or halves of them in those of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<S: Simd, P> {
    source: P,
    /// The column of lane 0, in a span.
    x: i32,
    /// How far the pixels are from the end of the span where its values are given: whole numbers,
    /// exact in f32.
    steps: f32x16<S>,
}

/// A block of neighbours in the row of a span.
pub(crate) type SpanBlock<'s, 'a, S, const N: usize> = Block<S, &'s Span<'a, N>>;

impl<'s, 'a, S: Simd, const N: usize> SpanBlock<'s, 'a, S, N> {
    /// The block whose lane 0 is at column `x` relative to the viewport. It may lie outside the span;
    /// visible lanes do not.
    #[inline(always)]
    pub(crate) fn new(simd: S, span: &'s Span<'a, N>, x: i32) -> Self {
        const LANE: Lanes = [0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.];
        let steps = f32x16::simd_from(simd, LANE) + (x - span.line.x) as f32;
        Self { source: span, x, steps }
    }

    /// Goes on to the next block.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.x += LANES as i32;
        self.steps += LANES as f32;
    }

    /// Which lanes belong to the span, a bit a lane.
    #[inline(always)]
    fn lanes(&self) -> u32 {
        let lane = |column: i32| (column - self.x).clamp(0, LANES as i32) as u32;
        (1 << lane(self.source.x.end)) - (1 << lane(self.source.x.start))
    }
}

impl<'s, S: Simd, const N: usize> Block<S, SpanPair<'s, N>> {
    /// The block of the first pixels in each of two spans.
    #[inline(always)]
    pub(crate) fn pair(simd: S, pair: SpanPair<'s, N>) -> Self {
        const LANE: Lanes = [0., 1., 2., 3., 4., 5., 6., 7., 0., 1., 2., 3., 4., 5., 6., 7.];
        let [lower, upper] = pair.of(&pair.group.steps);
        let steps = f32x16::simd_from(simd, LANE) + halves(simd, lower, upper);
        Self { source: pair, x: 0, steps }
    }
}

impl<S: Simd, P> Block<S, P> {
    #[inline(always)]
    pub(crate) fn simd(&self) -> S {
        self.steps.simd
    }

    /// A value that is linear along the spans.
    #[inline(always)]
    fn linear<'s, const N: usize>(&self, component: Component) -> f32x16<S>
    where
        P: Source<'s, N>,
    {
        let (at, change) = self.source.line(self.simd(), component);
        self.steps * change + at
    }

    /// The depths.
    #[inline(always)]
    pub(crate) fn depth<'s, const N: usize>(&self) -> f32x16<S>
    where
        P: Source<'s, N>,
    {
        within(self.linear(Component::Z), self.source.polygon().z)
    }

    /// 1/w as depth: what grows towards the eye.
    #[inline(always)]
    pub(crate) fn depth_by_inv_w<'s, const N: usize>(&self) -> f32x16<S>
    where
        P: Source<'s, N>,
    {
        let polygon = self.source.polygon();
        match polygon.w {
            WRange::Constant { inv_w, .. } => f32x16::splat(self.simd(), inv_w),
            WRange::Varying { inv_w, .. } => {
                within(self.linear(Component::InvW), inv_w) * (1.0 / polygon.w_unit) as f32
            }
        }
    }

    /// The fragments: one reciprocal a pixel, or none if w is constant. `method` is that of the
    /// polygon or [`Method::Other`]; where it is a constant, the compiler leaves out the rest.
    #[inline(always)]
    pub(crate) fn fragments<'s, const N: usize>(
        &self,
        depth: f32x16<S>,
        visible: u32,
        method: Method,
    ) -> FragmentBlock<'s, N>
    where
        P: Source<'s, N>,
    {
        let polygon = self.source.polygon();
        let half = |half: usize| {
            let (x, place) = self.source.half(half, self.x);
            (polygon.corner.0.wrapping_add(x), place)
        };
        let mut fragments = FragmentBlock {
            face: polygon.face,
            visible,
            depth: depth.into(),
            w: [polygon.w.range().0; LANES],
            params: [[0.0; LANES]; N],
            halves: [half(0), half(1)],
        };
        let w_unit = polygon.w_unit as f32;
        // Plain loops, which are inlined whole.
        let params = fragments.params.iter_mut().enumerate();
        match (method, polygon.w) {
            (Method::Constant, _) => {
                for (i, param) in params {
                    *param = self.linear(Component::S(i)).into();
                }
            }
            (Method::Perspective, w) => {
                // Where a pixel centre lies outside the polygon, by the rounding of its outline, 1/w may
                // leave its range. It is not brought back: s is not either, so that r keeps to its plane.
                let per_unit = reciprocal(self.linear(Component::InvW));
                fragments.w = within(per_unit * w_unit, w.range()).into();
                for (i, param) in params {
                    *param = (self.linear(Component::S(i)) * per_unit).into();
                }
            }
            (Method::Other, w) => {
                let mut per_unit = f32x16::splat(self.simd(), 1.0);
                if let WRange::Varying { w, inv_w } = w {
                    let mut per_w = self.linear(Component::InvW);
                    if polygon.limits.is_some() {
                        per_w = within(per_w, inv_w);
                    }
                    per_unit = reciprocal(per_w);
                    fragments.w = within(per_unit * w_unit, w).into();
                }
                for (i, param) in params {
                    let s = self.linear(Component::S(i));
                    let r = if polygon.times_w[i] { s * per_unit } else { s };
                    *param = r.into();
                    if let Some(limits) = &polygon.limits {
                        *param = limited(*param, limits[i]);
                    }
                }
            }
        }
        fragments
    }
}

/// One value in the lower half of the lanes, another in the upper.
#[inline(always)]
fn halves<S: Simd>(simd: S, lower: f32, upper: f32) -> f32x16<S> {
    let is_upper = mask32x16::from_bitmask(simd, (ALL << HALF & ALL).into());
    is_upper.select(f32x16::splat(simd, upper), f32x16::splat(simd, lower))
}

/// Values brought into a range.
#[inline(always)]
fn within<S: Simd>(values: f32x16<S>, (min, max): (f32, f32)) -> f32x16<S> {
    if !values.simd.level().is_fallback() {
        return values.max(min).min(max);
    }
    // Without SIMD what they do with NaN and zeros would cost more than the rest. This is what a
    // processor's instructions do.
    let mut lanes = Lanes::from(values);
    for value in &mut lanes {
        let raised = if *value > min { *value } else { min };
        *value = if raised < max { raised } else { max };
    }
    f32x16::simd_from(values.simd, lanes)
}

/// Values within limits. Of NaN, and of a zero's sign, the same is made on every machine.
#[cold]
fn limited(values: Lanes, (min, max): (f32, f32)) -> Lanes {
    values.map(|value| value.max(min).min(max) + 0.0)
}

/// The division of the rational linear method, once for each pixel of a block.
#[inline(always)]
fn reciprocal<S: Simd>(values: f32x16<S>) -> f32x16<S> {
    #[cfg(test)]
    tests::RECIPROCALS.with(|count| count.set(count.get() + 1));
    f32x16::splat(values.simd, 1.0) / values
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use glam::vec4;

    use super::LANES;
    use crate::{DepthTest, Framebuffer, Vertex, ZBuffer};

    thread_local! {
        /// How many blocks were divided on this thread.
        pub(super) static RECIPROCALS: Cell<usize> = const { Cell::new(0) };
    }

    const WIDTH: usize = 3 * LANES;
    const HEIGHT: usize = 8;

    /// The blocks that were divided, for each block that was drawn, and the calls of the shader that
    /// drawing a quad takes, with the given w on its left and its right.
    fn count(w: [f32; 2], depth_test: DepthTest) -> (f32, usize) {
        let quad = [(-1.0, -1.0, w[0]), (1.0, -1.0, w[1]), (1.0, 1.0, w[1]), (-1.0, 1.0, w[0])]
            .map(|(x, y, w)| Vertex::new(vec4(x * w, y * w, 0.5 * w, w), [x, y, 1.0]));
        let mut frame = Framebuffer::new(WIDTH as u32, HEIGHT as u32, 0u32).expect("a small frame");
        // Blocks begin at cache lines, wherever the allocator has put the rows.
        let blocks = HEIGHT * (frame.band().line_offset + WIDTH).div_ceil(LANES);
        let mut renderer = ZBuffer::new(frame.viewport());
        renderer.depth_test = depth_test;
        let shaded = Cell::new(0);
        RECIPROCALS.set(0);
        renderer.draw(&mut frame, &quad, |_| {
            shaded.set(shaded.get() + 1);
            1
        });
        (RECIPROCALS.get() as f32 / blocks as f32, shaded.get())
    }

    #[test]
    fn one_reciprocal_a_visible_pixel_whatever_the_number_of_parameters() {
        assert_eq!(count([1.0, 3.0], DepthTest::Less), (1.0, WIDTH * HEIGHT));
    }

    #[test]
    fn hidden_pixels_cost_no_reciprocal() {
        assert_eq!(count([1.0, 3.0], DepthTest::Greater), (0.0, 0));
        assert_eq!(count([1.0, 3.0], DepthTest::Never), (0.0, 0));
    }

    #[test]
    fn equal_w_costs_no_reciprocal() {
        assert_eq!(count([3.7, 3.7], DepthTest::Less), (0.0, WIDTH * HEIGHT));
    }
}
