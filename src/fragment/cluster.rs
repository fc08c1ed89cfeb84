//! Clusters: parameters with a denominator of their own.
//!
//! Parameters that are affine on the polygon share the polygon's w. Others are affine only after another
//! projection: where a slide projector throws its picture, say, or where a light's map of shadows is looked
//! up. Parameters that are affine together form a cluster, with a homogeneous variable w_r of its own
//! (Heckbert and Moreton 1991, section 3.4). In the vertices a cluster is (r_1 w_r, .., r_k w_r, w_r): ordinary
//! parameters, clipped and interpolated as all others. At the pixel
//!
//! ```text
//! r_i = (r_i w_r / w) / (w_r / w)
//! ```
//!
//! is found from the undivided values, so that 1/w cancels: one reciprocal a cluster and pixel, and none for a
//! polygon whose shader asks for no cluster. Numerators that share a denominator share its reciprocal.
//!
//! The undivided values are evaluated in f64, each at its pixel. In f32 the quotient would lose as many digits
//! as w_r varies over the polygon, three where its ratio is 1000.

use glam::Vec2;

use crate::fragment::block::{HALF_BLOCK, LANES, Lanes};
use crate::fragment::footprint::{Footprint, FootprintBlock};
use crate::fragment::pixel::{Fragment, FragmentBlock};
use crate::surface::base::Divide;
use crate::surface::mixed::Component;
use crate::surface::plane::ScreenPlane;

/// The least denominator that is divided by. What positive f32 leave when they are divided by w is greater,
/// 2^-149 by 2^127 at the least; and quotients and their slopes are finite down to this, in f64.
const LEAST: f64 = 1e-200;

/// The product of two values with their slopes.
fn product(a: ScreenPlane, b: ScreenPlane) -> ScreenPlane {
    ScreenPlane {
        value: a.value * b.value,
        dx: a.dx * b.value + a.value * b.dx,
        dy: a.dy * b.value + a.value * b.dy,
    }
}

/// The reciprocal of a denominator; `None` if it is not positive.
#[inline(always)]
fn reciprocal(denominator: f64) -> Option<f64> {
    (denominator >= LEAST).then(|| 1.0 / denominator)
}

/// The slopes of a quotient r = s / q by the quotient rule.
#[inline(always)]
fn slopes(s: ScreenPlane, q: ScreenPlane, per_q: f64) -> [f32; 2] {
    let r = s.value * per_q;
    [(s.dx - r * q.dx) * per_q, (s.dy - r * q.dy) * per_q].map(|slope| slope as f32)
}

impl<const N: usize> Fragment<'_, N> {
    /// A cluster: each of `params` divided by parameter `by`, which is the cluster's own homogeneous variable
    /// w_r (Heckbert and Moreton 1991, section 3.4). The vertices carry (r_1 w_r, .., r_k w_r) and w_r; what comes
    /// out is r_1 .. r_k. `None` where w_r is not positive, such as behind a slide projector, and if there is no
    /// such parameter.
    ///
    /// ```
    /// use glam::{Mat4, Vec3, camera::rh::proj::directx::perspective};
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// let (camera, projector) = (perspective(1.0, 1.0, 0.1, 10.0), perspective(0.4, 1.0, 0.1, 10.0));
    /// // A wall, partly behind the projector. Its place in the slide is the projector's clip space.
    /// let wall = [(-1.0, -1.0, -1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 1.0, -1.0)];
    /// let wall = wall.map(|(x, y, z)| Vec3::new(x, y, z).extend(1.0));
    /// let wall = wall.map(|p| Vertex::new(camera * Mat4::from_translation(-2.0 * Vec3::Z) * p, projector * p));
    ///
    /// let mut frame = Framebuffer::new(100, 100, 0.0)?;
    /// let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// renderer.draw(&mut frame, &wall, |fragment| match fragment.divided([0, 1], 3) {
    ///     Some([x, y]) if x.abs() < 1.0 && y.abs() < 1.0 => 1.0,
    ///     _ => 0.1,
    /// });
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    ///
    /// It is within 1e-5 of the largest |r_i| of exact arithmetic, with ratios of w and of w_r up to 1000. Near the
    /// place where w_r is 0 the quotients are as large as they are; infinite where f32 ends. It may be that
    /// `by` and the numerators are interpolated in different ways.
    #[inline(always)]
    #[must_use]
    pub fn divided<const K: usize>(&self, params: [usize; K], by: usize) -> Option<[f32; K]> {
        let (numerators, _, per) = self.cluster(params, by)?;
        Some(numerators.map(|s| (s.value * per) as f32))
    }

    /// The derivatives of a [cluster](Self::divided): of each r_i with respect to screen x (to the right) and
    /// screen y (down), per pixel, by the quotient rule.
    #[inline(always)]
    #[must_use]
    pub fn divided_derivatives<const K: usize>(
        &self,
        params: [usize; K],
        by: usize,
    ) -> Option<[[f32; 2]; K]> {
        let (numerators, denominators, per) = self.cluster(params, by)?;
        let mut denominators = denominators.into_iter();
        Some(numerators.map(|s| slopes(s, denominators.next().unwrap_or_default(), per)))
    }

    /// The footprint of a texture coordinate that is a [cluster](Self::divided): parameters `u` and `v` divided
    /// by parameter `by`.
    #[inline(always)]
    #[must_use]
    pub fn divided_footprint(&self, [u, v]: [usize; 2], by: usize) -> Option<Footprint> {
        let (s, q, per) = self.cluster([u, v], by)?;
        let [[dudx, dudy], [dvdx, dvdy]] = [slopes(s[0], q[0], per), slopes(s[1], q[1], per)];
        Some(Footprint {
            uv: Vec2::from(s.map(|s| (s.value * per) as f32)),
            dx: Vec2::new(dudx, dvdx),
            dy: Vec2::new(dudy, dvdy),
        })
    }

    /// The numerators and denominators of a cluster, and the reciprocal of the denominators' one value.
    #[inline(always)]
    fn cluster<const K: usize>(
        &self,
        params: [usize; K],
        by: usize,
    ) -> Option<([ScreenPlane; K], [ScreenPlane; K], f64)> {
        if by >= N || params.iter().any(|&i| i >= N) {
            return None;
        }
        if self.origin.surface.base.divide == Divide::Mixed {
            return self.mixed_cluster(params, by);
        }
        let q = self.undivided(Component::S(by));
        Some((params.map(|i| self.undivided(Component::S(i))), [q; K], reciprocal(q.value)?))
    }

    /// The same where some parameters are divided by 1/w, and others are not: those that are not are
    /// multiplied by it, if the others are.
    #[cold]
    fn mixed_cluster<const K: usize>(
        &self,
        params: [usize; K],
        by: usize,
    ) -> Option<([ScreenPlane; K], [ScreenPlane; K], f64)> {
        let surface = self.origin.surface;
        let is_alike = params.iter().all(|&i| surface.times_w(i) == surface.times_w(by));
        let s = |i: usize| match self.undivided(Component::S(i)) {
            s if is_alike || surface.times_w(i) => s,
            s => product(s, self.undivided(Component::InvW)),
        };
        let q = s(by);
        Some((params.map(s), [q; K], reciprocal(q.value)?))
    }

    /// A value as it is interpolated, before any division, with its slopes.
    #[inline(always)]
    fn undivided(&self, component: Component) -> ScreenPlane {
        let surface = self.origin.surface;
        let x = self.x.wrapping_sub(surface.base.corner.0);
        if surface.needs_edges() {
            return self.undivided_by_edges(component, x);
        }
        let row = self.origin.runs.y + self.origin.row as i32;
        surface.at_pixel(component, x, row)
    }

    /// The same where some values have no planes.
    #[cold]
    fn undivided_by_edges(&self, component: Component, x: i32) -> ScreenPlane {
        let mut found = [ScreenPlane::default()];
        let run = self.origin.surface.in_run(&self.origin.run());
        run.with_slopes(component, x, &mut found);
        found[0]
    }
}

impl<const N: usize> FragmentBlock<'_, N> {
    /// A cluster, as [`Fragment::divided`], for each lane: r_1 .. r_k, and a bit for each lane that is visible and
    /// where the denominator is positive. The values of other lanes mean nothing.
    ///
    /// ```
    /// # use glam::vec4;
    /// # use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    /// # let mut frame = Framebuffer::new(16, 16, 0.0f32)?;
    /// # let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// # let corners = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)];
    /// # let triangle = corners.map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y, 2.0 + x]));
    /// renderer.draw_blocks(&mut frame, &triangle, |block, colors| {
    ///     let ([u, v], lit) = block.divided([0, 1], 2);
    ///     for lane in 0..16 {
    ///         colors[lane] = if lit >> lane & 1 != 0 { u[lane] + v[lane] } else { 0.0 };
    ///     }
    /// });
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    #[inline(always)]
    #[must_use]
    pub fn divided<const K: usize>(&self, params: [usize; K], by: usize) -> ([Lanes; K], u32) {
        let mut values = [[0.0; LANES]; K];
        if by >= N || params.iter().any(|&i| i >= N) {
            return (values, 0);
        }
        if self.surface.base.divide == Divide::Mixed {
            return self.mixed_divided(params, by);
        }
        let (per, lit) = self.reciprocals(by);
        for (values, i) in values.iter_mut().zip(params) {
            let s = self.undivided(i);
            for lane in 0..LANES {
                values[lane] = (s[lane] * per[lane]) as f32;
            }
        }
        (values, lit)
    }

    /// The footprints of texture coordinates that are a [cluster](Self::divided), as
    /// [`Fragment::divided_footprint`], with a bit for each lane where they are.
    #[inline(always)]
    #[must_use]
    pub fn divided_footprint(&self, [u, v]: [usize; 2], by: usize) -> (FootprintBlock, u32) {
        let mut found = FootprintBlock::default();
        if by >= N || u >= N || v >= N {
            return (found, 0);
        }
        if self.surface.base.divide == Divide::Mixed {
            return self.mixed_divided_footprint([u, v], by);
        }
        if self.surface.needs_edges() {
            return self.divided_footprint_by_edges([u, v], by);
        }
        let (per, lit) = self.reciprocals(by);
        let q = self.surface.plane(Component::S(by));
        for (axis, i) in [u, v].into_iter().enumerate() {
            let (s, plane) = (self.undivided(i), self.surface.plane(Component::S(i)));
            for lane in 0..LANES {
                let (s, per) = (ScreenPlane { value: s[lane], ..plane }, per[lane]);
                found.uv[axis][lane] = (s.value * per) as f32;
                [found.dx[axis][lane], found.dy[axis][lane]] = slopes(s, q, per);
            }
        }
        (found, lit)
    }

    /// The reciprocals of a denominator, and where it is positive, of the visible lanes.
    #[inline(always)]
    fn reciprocals(&self, by: usize) -> ([f64; LANES], u32) {
        let (mut per, mut lit) = (self.undivided(by), 0);
        for (lane, per) in per.iter_mut().enumerate() {
            let is_lit = *per >= LEAST;
            *per = 1.0 / if is_lit { *per } else { 1.0 };
            lit |= u32::from(is_lit) << lane;
        }
        (per, lit & self.visible)
    }

    /// The same where some parameters have no planes.
    #[cold]
    fn divided_footprint_by_edges(&self, uv: [usize; 2], by: usize) -> (FootprintBlock, u32) {
        let mut found = FootprintBlock::default();
        let (per, lit) = self.reciprocals(by);
        let q = self.undivided_by_edges(by);
        for (axis, i) in uv.into_iter().enumerate() {
            let s = self.undivided_by_edges(i);
            for lane in 0..LANES {
                found.uv[axis][lane] = (s[lane].value * per[lane]) as f32;
                [found.dx[axis][lane], found.dy[axis][lane]] = slopes(s[lane], q[lane], per[lane]);
            }
        }
        (found, lit)
    }

    /// A parameter as it is interpolated, before any division, with its slopes, whatever it is found by.
    #[cold]
    fn undivided_by_edges(&self, i: usize) -> [ScreenPlane; LANES] {
        let mut found = [ScreenPlane::default(); LANES];
        for ((x, row), found) in self.halves.into_iter().zip(found.chunks_mut(HALF_BLOCK)) {
            let run = self.surface.in_run(&self.runs.run(row));
            run.with_slopes(Component::S(i), x, found);
        }
        found
    }

    /// A parameter as it is interpolated, before any division.
    #[inline(always)]
    fn undivided(&self, i: usize) -> [f64; LANES] {
        if self.surface.needs_edges() {
            return self.undivided_by_edges(i).map(|found| found.value);
        }
        let (base, plane) = (self.surface.base, self.surface.plane(Component::S(i)));
        let mut s = [0.0; LANES];
        for (half, (x, row)) in self.halves.into_iter().enumerate() {
            let y = f64::from(self.runs.y + row as i32) + 0.5 - base.origin[1];
            for lane in 0..HALF_BLOCK {
                let x = f64::from(x.wrapping_add(lane as i32)) + 0.5 - base.origin[0];
                s[half * HALF_BLOCK + lane] = plane.at(x, y);
            }
        }
        s
    }

    #[cold]
    fn mixed_divided<const K: usize>(&self, params: [usize; K], by: usize) -> ([Lanes; K], u32) {
        let (mut values, mut lit) = ([[0.0; LANES]; K], 0);
        for lane in (0..LANES).filter(|lane| self.visible >> lane & 1 != 0) {
            let Some(found) = self.fragment(lane).divided(params, by) else { continue };
            values.iter_mut().zip(found).for_each(|(values, found)| values[lane] = found);
            lit |= 1 << lane;
        }
        (values, lit)
    }

    #[cold]
    fn mixed_divided_footprint(&self, uv: [usize; 2], by: usize) -> (FootprintBlock, u32) {
        let (mut footprints, mut lit) = (FootprintBlock::default(), 0);
        for lane in (0..LANES).filter(|lane| self.visible >> lane & 1 != 0) {
            let Some(found) = self.fragment(lane).divided_footprint(uv, by) else { continue };
            for axis in 0..2 {
                footprints.uv[axis][lane] = found.uv[axis];
                footprints.dx[axis][lane] = found.dx[axis];
                footprints.dy[axis][lane] = found.dy[axis];
            }
            lit |= 1 << lane;
        }
        (footprints, lit)
    }
}
