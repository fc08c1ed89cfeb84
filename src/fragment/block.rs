//! Blocks: sixteen pixels of a polygon, evaluated at once.
//!
//! ```text
//!     in the row of a long run:       [0 1 2 3 4 5 6 7 8 9 . . . . . 15]
//!
//!     in two rows of short runs:      [0 1 2 3 4 5 6 7]
//!                                     [8 9 . . . .  15]
//! ```
//!
//! Each value is what it is at one pixel of its run, plus a multiple of its change per pixel.

use fearless_simd::{Select, Simd, SimdBase, SimdFrom, SimdMask, f32x16, mask32x16};

use crate::coverage::run::ROWS;
use crate::surface::base::{Divide, WRange};
use crate::surface::mixed::{Component, Mixed};
use crate::surface::plane::ScreenPlane;
use crate::surface::rows::{RowLine, RowValues, SurfaceView};

/// The number of pixels in a block.
pub const LANES: usize = 16;

/// One value for each pixel of a block.
pub type Lanes = [f32; LANES];

/// All lanes of a block, a bit a lane.
pub(crate) const ALL: u32 = (1 << LANES) - 1;

/// The number of pixels in each half of a block.
pub(crate) const HALF_BLOCK: usize = LANES / 2;

/// Which rows of a group the pixels of a block are in.
pub(crate) trait BlockRows: Copy {
    /// The value of each lane's row.
    fn at<S: Simd>(self, simd: S, line: &RowLine) -> f32x16<S>;
}

/// All pixels are in one row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneRow(pub(crate) usize);

/// Each half of the pixels is in a row of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwoRows(pub(crate) [usize; 2]);

impl BlockRows for OneRow {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, line: &RowLine) -> f32x16<S> {
        f32x16::splat(simd, line.at[self.0 % ROWS])
    }
}

impl BlockRows for TwoRows {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, line: &RowLine) -> f32x16<S> {
        let [lower, upper] = self.0;
        halves(simd, [line.at[lower % ROWS], line.at[upper % ROWS]])
    }
}

/// A value along one row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SpanLine {
    /// What it is at one pixel.
    pub(crate) at: f32,
    /// Its change per pixel.
    pub(crate) delta: f32,
}

impl SpanLine {
    /// A value along one of a group of rows.
    #[inline(always)]
    pub(crate) fn of(line: &RowLine, row: usize) -> Self {
        Self { at: line.at[row % ROWS], delta: line.delta }
    }
}

/// Values that blocks are made of: each along the rows of the block's pixels.
pub(crate) trait Lines: Copy {
    /// The rows that their values are given for.
    type Rows: BlockRows;

    /// What a value is at one pixel of each lane's row, and its change per pixel.
    fn get<S: Simd>(&self, simd: S, rows: Self::Rows) -> (f32x16<S>, f32);
}

impl Lines for RowLine {
    type Rows = TwoRows;

    #[inline(always)]
    fn get<S: Simd>(&self, simd: S, rows: TwoRows) -> (f32x16<S>, f32) {
        (rows.at(simd, self), self.delta)
    }
}

impl Lines for SpanLine {
    type Rows = OneRow;

    #[inline(always)]
    fn get<S: Simd>(&self, simd: S, _: OneRow) -> (f32x16<S>, f32) {
        (f32x16::splat(simd, self.at), self.delta)
    }
}

/// Some pixels of a polygon: their rows, and how far each is from the pixel of its run where values are
/// given: whole numbers, exact in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<S: Simd, R> {
    rows: R,
    steps: f32x16<S>,
}

impl<S: Simd> Block<S, OneRow> {
    /// Neighbours in a row, the first of which is `steps` from the pixel where values are given.
    #[inline(always)]
    pub(crate) fn in_row(simd: S, row: usize, steps: f32) -> Self {
        const LANE: Lanes = [0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.];
        Self { rows: OneRow(row), steps: f32x16::simd_from(simd, LANE) + steps }
    }

    /// Goes on to the next block in the row.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.steps += LANES as f32;
    }
}

impl<S: Simd> Block<S, TwoRows> {
    /// The first pixels of two rows, or of two places in one.
    #[inline(always)]
    pub(crate) fn in_two_rows(simd: S, rows: [usize; 2], steps: [f32; 2]) -> Self {
        const LANE: Lanes = [0., 1., 2., 3., 4., 5., 6., 7., 0., 1., 2., 3., 4., 5., 6., 7.];
        Self { rows: TwoRows(rows), steps: f32x16::simd_from(simd, LANE) + halves(simd, steps) }
    }
}

impl<S: Simd, R: BlockRows> Block<S, R> {
    #[inline(always)]
    pub(crate) fn simd(&self) -> S {
        self.steps.simd
    }

    /// A value that is linear along the rows.
    #[inline(always)]
    fn linear(&self, line: &RowLine) -> f32x16<S> {
        self.steps * line.delta + self.rows.at(self.simd(), line)
    }

    /// The depths, of one row's line.
    #[inline(always)]
    pub(crate) fn depth_along<L: Lines<Rows = R>>(&self, z: &L, z_range: (f32, f32)) -> f32x16<S> {
        clamped(self.along(z), z_range)
    }

    /// The depths.
    #[inline(always)]
    pub(crate) fn depth(&self, surface: &SurfaceView<'_>, values: &RowValues) -> f32x16<S> {
        clamped(self.linear(&values.z), surface.base.z_range)
    }

    /// 1/w as depth: what grows towards the eye.
    #[inline(always)]
    pub(crate) fn depth_by_inv_w(
        &self,
        surface: &SurfaceView<'_>,
        values: &RowValues,
    ) -> f32x16<S> {
        match surface.base.w {
            WRange::Constant { inv_w, .. } => f32x16::splat(self.simd(), inv_w),
            WRange::Varying { inv_w, .. } => {
                let per_unit = clamped(self.linear(&values.inv_w), inv_w);
                per_unit * (1.0 / surface.base.w_unit) as f32
            }
        }
    }

    /// A value that is linear along the rows.
    #[inline(always)]
    pub(crate) fn along<L: Lines<Rows = R>>(&self, line: &L) -> f32x16<S> {
        let (at, delta) = line.get(self.simd(), self.rows);
        self.steps * delta + at
    }

    /// The w of clip space and the parameters, where all are divided: one reciprocal a pixel.
    #[inline(always)]
    pub(crate) fn divided<L: Lines<Rows = R>, const N: usize>(
        &self,
        surface: &SurfaceView<'_>,
        inv_w: &L,
        s: &[L; N],
        found: Found<'_, N>,
    ) {
        let Found { w, per_w, params } = found;
        // Where a pixel centre lies outside the polygon, by the rounding of its outline, 1/w may
        // leave its range. It is not brought back: s is not either, so that r keeps to its plane.
        let per_unit = reciprocal(self.along(inv_w));
        *w = clamped(per_unit * surface.base.w_unit as f32, surface.base.w.range()).into();
        *per_w = per_unit.into();
        for (param, line) in params.iter_mut().zip(s) {
            *param = (self.along(line) * per_unit).into();
        }
    }

    /// The parameters where all w are equal: nothing is divided.
    #[inline(always)]
    pub(crate) fn undivided<L: Lines<Rows = R>, const N: usize>(
        &self,
        s: &[L; N],
        params: &mut [Lanes; N],
    ) {
        for (param, line) in params.iter_mut().zip(s) {
            *param = self.along(line).into();
        }
    }

    /// What is compared as depth at a place off the pixels' centres: z, or 1/w, which is by `change` more there.
    #[inline(always)]
    pub(crate) fn compared(
        &self,
        surface: &SurfaceView<'_>,
        values: &RowValues,
        change: f32,
        is_inverse_w: bool,
    ) -> f32x16<S> {
        if !is_inverse_w {
            return clamped(self.linear(&values.z) + change, surface.base.z_range);
        }
        match surface.base.w {
            WRange::Constant { inv_w, .. } => f32x16::splat(self.simd(), inv_w),
            WRange::Varying { inv_w, .. } => {
                let per_unit = clamped(self.linear(&values.inv_w) + change, inv_w);
                per_unit * (1.0 / surface.base.w_unit) as f32
            }
        }
    }

    /// Depth, the w of clip space and the parameters at places off the pixels' centres, in pixels to the
    /// right and downwards. 1/w is kept within the range that it has on the polygon. What is found by edges
    /// is what it is at the centres.
    #[inline(always)]
    pub(crate) fn off_centre<const N: usize>(
        &self,
        surface: &SurfaceView<'_>,
        values: &RowValues,
        s: &[RowLine; N],
        [x, y]: [f32x16<S>; 2],
        (depth, found): (&mut Lanes, Found<'_, N>),
    ) where
        R: BlockRows,
        RowLine: Lines<Rows = R>,
    {
        let simd = self.simd();
        let moves = Moves { x, y, mixed: surface.mixed };
        let base = surface.base;
        let z = moves.of(self.along(&values.z), &base.z, Component::Z);
        *depth = clamped(z, base.z_range).into();
        let Found { w, per_w, params } = found;
        *w = [base.w.range().0; LANES];
        let mut per_unit = f32x16::splat(simd, 1.0);
        if let WRange::Varying { w: w_range, inv_w: inv_w_range } = base.w {
            let inv_w = moves.of(self.along(&values.inv_w), &base.inv_w, Component::InvW);
            per_unit = reciprocal(clamped(inv_w, inv_w_range));
            *w = clamped(per_unit * base.w_unit as f32, w_range).into();
            *per_w = per_unit.into();
        }
        for (i, (param, line)) in params.iter_mut().zip(s).enumerate() {
            let plane = surface.params[i].of(surface.lane);
            let s = moves.of(self.along(line), &plane, Component::S(i));
            let Some(mixed) = moves.mixed else {
                *param = (s * per_unit).into();
                continue;
            };
            *param = if mixed.times_w[i] { s * per_unit } else { s }.into();
            if mixed.has_limits {
                *param = limited(*param, mixed.limits[i]);
            }
        }
    }

    /// The w of clip space and the parameters, whatever [`Divide`] is.
    #[inline(always)]
    pub(crate) fn any<L: Lines<Rows = R>, const N: usize>(
        &self,
        surface: &SurfaceView<'_>,
        inv_w: &L,
        s: &[L; N],
        found: Found<'_, N>,
    ) {
        let Found { w, per_w, params } = found;
        *w = [surface.base.w.range().0; LANES];
        let mixed = match (surface.base.divide, surface.mixed) {
            (Divide::PerPixel, _) => {
                return self.divided(surface, inv_w, s, Found { w, per_w, params });
            }
            (Divide::Mixed, Some(mixed)) => mixed,
            _ => return self.undivided(s, params),
        };
        let has_limits = mixed.has_limits;
        let mut per_unit = f32x16::splat(self.simd(), 1.0);
        if let WRange::Varying { w: w_range, inv_w: inv_w_range } = surface.base.w {
            let mut per_w = self.along(inv_w);
            if has_limits {
                per_w = clamped(per_w, inv_w_range);
            }
            per_unit = reciprocal(per_w);
            *w = clamped(per_unit * surface.base.w_unit as f32, w_range).into();
        }
        for (i, (param, line)) in params.iter_mut().zip(s).enumerate() {
            let s = self.along(line);
            let r = if mixed.times_w[i] { s * per_unit } else { s };
            *param = r.into();
            if has_limits {
                *param = limited(*param, mixed.limits[i]);
            }
        }
    }
}

/// The values along one row of a polygon that has planes, at the pixels' centres: as
/// [`Block::off_centre`] has them there, to the bit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AtCentres<const N: usize> {
    pub(crate) z: SpanLine,
    inv_w: SpanLine,
    s: [SpanLine; N],
    /// The zeros that are added for a place that is the centre.
    zeros: [f32; N],
    zero: f32,
}

impl<const N: usize> AtCentres<N> {
    #[inline(always)]
    pub(crate) fn new(surface: &SurfaceView<'_>, values: &RowValues, row: usize) -> Option<Self> {
        if surface.mixed.is_some() {
            return None;
        }
        let zero = |plane: &ScreenPlane| 0.0 * plane.dx as f32 + 0.0 * plane.dy as f32;
        let (mut s, mut zeros) = ([SpanLine::default(); N], [0.0; N]);
        let lines = values.s.first_chunk::<N>()?;
        for (i, (s, zeros)) in s.iter_mut().zip(&mut zeros).enumerate() {
            *s = SpanLine::of(&lines[i], row);
            *zeros = zero(&surface.params[i].of(surface.lane));
        }
        let [z, inv_w] = [SpanLine::of(&values.z, row), SpanLine::of(&values.inv_w, row)];
        Some(Self { z, inv_w, s, zeros, zero: zero(&surface.base.inv_w) })
    }
}

impl<S: Simd> Block<S, OneRow> {
    /// The w of clip space and the parameters at the centres.
    #[inline(always)]
    pub(crate) fn at_centres<const N: usize>(
        &self,
        surface: &SurfaceView<'_>,
        along: &AtCentres<N>,
        found: Found<'_, N>,
    ) {
        let Found { w, per_w, params } = found;
        let mut per_unit = f32x16::splat(self.simd(), 1.0);
        if let WRange::Varying { w: w_range, inv_w: inv_w_range } = surface.base.w {
            let inv_w = self.along(&along.inv_w) + along.zero;
            per_unit = reciprocal(clamped(inv_w, inv_w_range));
            *w = clamped(per_unit * surface.base.w_unit as f32, w_range).into();
            *per_w = per_unit.into();
        }
        for (param, (line, zero)) in params.iter_mut().zip(along.s.iter().zip(along.zeros)) {
            *param = ((self.along(line) + zero) * per_unit).into();
        }
    }
}

/// How far the places where values are wanted are from the pixels' centres.
struct Moves<'m, S: Simd> {
    x: f32x16<S>,
    y: f32x16<S>,
    mixed: Option<&'m Mixed>,
}

impl<S: Simd> Moves<'_, S> {
    /// What a value that has a plane is there. Where the moves are 0 this adds 0 only, so that a zero has
    /// one sign whatever is beside it.
    #[inline(always)]
    fn of(&self, at_centre: f32x16<S>, plane: &ScreenPlane, component: Component) -> f32x16<S> {
        if self.mixed.is_some_and(|mixed| mixed.is_by_edges(component)) {
            return at_centre;
        }
        at_centre + (self.x * plane.dx as f32 + self.y * plane.dy as f32)
    }
}

/// Where the values of a block's pixels go.
pub(crate) struct Found<'f, const N: usize> {
    /// The w of clip space.
    pub(crate) w: &'f mut Lanes,
    /// The reciprocal of 1/w, in the polygon's unit, as it is.
    pub(crate) per_w: &'f mut Lanes,
    pub(crate) params: &'f mut [Lanes; N],
}

/// One value in the lower half of the lanes, another in the upper.
#[inline(always)]
fn halves<S: Simd>(simd: S, [lower, upper]: [f32; 2]) -> f32x16<S> {
    let is_upper = mask32x16::from_bitmask(simd, (ALL << HALF_BLOCK & ALL).into());
    is_upper.select(f32x16::splat(simd, upper), f32x16::splat(simd, lower))
}

/// Values brought into a range.
#[inline(always)]
fn clamped<S: Simd>(values: f32x16<S>, (min, max): (f32, f32)) -> f32x16<S> {
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
    RECIPROCALS.with(|count| count.set(count.get() + 1));
    f32x16::splat(values.simd, 1.0) / values
}

#[cfg(test)]
thread_local! {
    /// How many blocks were divided on this thread.
    pub(crate) static RECIPROCALS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}
