//! Values along the rows of a polygon: z, s_1 .. s_n and s_{n+1} = 1/w at one pixel of each run, and
//! their change per pixel.
//!
//! # Why f32 is enough along a run, and where it begins
//!
//! The pixel where the values are given is the one at that end of the run where s_{n+1} = 1/w is
//! smallest, the farthest from the eye. Then f32 is enough, however long the run and whatever the ratio
//! of w. For a value v = a + d l at l pixels from there is off by no more than
//!
//! ```text
//! 2^-24 (|a| + 2 |d l| + |v|)  <=  2^-24 * 3 (|a| + |v|)
//! ```
//!
//! by the rounding of a, of d, of the product and of the sum. Since |s| <= R / w for the largest
//! parameter R, and 1/w at the pixel is no less than at the end, this is at most 2^-24 * 6 R / w for
//! s; for 1/w, which is positive and grows from a, it is 2^-24 * 3 / w. With their quotient's own
//! rounding r = s / (1/w) is off by less than 2^-24 * 11 R, or 7e-7 R. Starting from the near end
//! instead, the error would grow with the ratio of w: by this choice there is nothing to restart.
//!
//! ```text
//!        near end                              far end: the values are given here
//!           |<------------- l pixels ------------->|
//!     ------[][][][][][][][][][][][][][][][][][][][]------   v = a + d l, for each pixel alone
//! ```

use std::ops::Range;

use crate::coverage::Run;
use crate::coverage::run::{AT_EDGE, ROWS, RunGroup};
use crate::surface::base::{Divide, SurfaceBase};
use crate::surface::mixed::{AcrossRun, AlongEdge, Component, Mixed};
use crate::surface::plane::{BatchPlane, ScreenPlane};

/// How the parameters of a polygon run over the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceView<'a> {
    pub(crate) base: &'a SurfaceBase,
    /// The planes of s_1 .. s_n, those of a batch of triangles side by side.
    pub(crate) params: &'a [BatchPlane],
    /// Which of them are this polygon's.
    pub(crate) lane: usize,
    /// What it has besides planes, if it has.
    pub(crate) mixed: Option<&'a Mixed>,
}

/// A value along the runs of a group of rows: what it is at one pixel of each, and its change per
/// pixel. Within one cache line: what is stored there as a whole can be loaded in parts at once.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct RowLine {
    pub(crate) at: [f32; ROWS],
    pub(crate) delta: f32,
}

/// The visible columns of the runs of a group of rows.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct VisibleColumns {
    /// The first of each run, relative to the viewport.
    pub(crate) start: [i32; ROWS],
    /// How many there are; 0 in rows that the group does not have.
    pub(crate) width: [i32; ROWS],
    /// How far the first is from the one where the values are given: whole numbers, exact in f32.
    pub(crate) steps: [f32; ROWS],
}

/// The values along the runs of a group of rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowValues {
    /// The column, relative to the viewport, where the values are given.
    pub(crate) x: [i32; ROWS],
    pub(crate) z: RowLine,
    pub(crate) inv_w: RowLine,
    pub(crate) s: Vec<RowLine>,
    /// Whether `inv_w` and `s` are those of this group.
    has_params: bool,
    /// Where the values are given, relative to the planes' origin.
    from_origin: [[f64; ROWS]; 2],
}

/// How far from the viewport, in pixels, values may be given.
const MARGIN: i32 = 1024;

impl RowValues {
    /// A copy without the parameters' values.
    pub(crate) fn without_params(&self) -> Self {
        Self { s: Vec::new(), ..*self }
    }
}

impl<'a> SurfaceView<'a> {
    /// Whether some values have no plane, so that the edges of each run are needed, and runs must come
    /// one by one.
    #[inline(always)]
    pub(crate) fn needs_edges(&self) -> bool {
        self.mixed.is_some_and(|mixed| mixed.any_by_edges)
    }

    /// Whether a parameter is multiplied by w at each pixel.
    pub(crate) fn times_w(&self, param: usize) -> bool {
        match (self.base.divide, self.mixed) {
            (Divide::PerPixel, _) => true,
            (Divide::Mixed, Some(mixed)) => mixed.times_w[param],
            _ => false,
        }
    }

    /// Finds the depths along the runs of a group, and which of the given columns are in each run.
    #[inline(always)]
    pub(crate) fn start_rows(
        &self,
        runs: &RunGroup,
        columns: &Range<i32>,
        values: &mut RowValues,
    ) -> VisibleColumns {
        if self.needs_edges() {
            self.row_by_edges(runs, values);
        } else {
            self.start_on_planes(runs, values);
        }
        // Plain loops without branches over arrays of their own, which become SIMD.
        let (x, mut start, mut width, mut steps) = (values.x, runs.start, runs.end, [0.0; ROWS]);
        let len = runs.len as i32;
        for start in &mut start {
            *start = (*start).max(columns.start);
        }
        for (row, width) in width.iter_mut().enumerate() {
            // All ones in the rows that there are.
            let exists = (row as i32 - len) >> 31;
            *width = ((*width).min(columns.end) - start[row]).max(0) & exists;
        }
        for (row, steps) in steps.iter_mut().enumerate() {
            *steps = (start[row] - x[row]) as f32;
        }
        VisibleColumns { start, width, steps }
    }

    /// Finds where the values of each run are given, and the depths there.
    #[inline(always)]
    fn start_on_planes(&self, runs: &RunGroup, values: &mut RowValues) {
        let base = self.base;
        let is_falling = (base.inv_w.dx as f32) < 0.0;
        let (mut x, mut xs, mut ys) = (runs.start, [0.0; ROWS], [0.0; ROWS]);
        if is_falling {
            for (x, end) in x.iter_mut().zip(&runs.end) {
                *x = end - 1;
            }
        }
        for x in &mut x {
            *x = self.near_viewport(*x);
        }
        for (xs, x) in xs.iter_mut().zip(&x) {
            *xs = f64::from(*x) + 0.5 - base.origin[0];
        }
        for (row, ys) in ys.iter_mut().enumerate() {
            *ys = f64::from(runs.y) + row as f64 + 0.5 - base.origin[1];
        }
        values.x = x;
        values.from_origin = [xs, ys];
        values.z = line(&[xs, ys], base.z);
        values.has_params = false;
    }

    /// A column not so far outside of the viewport that the steps to it would cost digits.
    #[inline(always)]
    fn near_viewport(&self, x: i32) -> i32 {
        x.max(-MARGIN).min(self.base.last_column + MARGIN)
    }

    /// Finds 1/w along the runs of the group that [`start_rows`](Self::start_rows) began.
    #[inline(always)]
    pub(crate) fn find_inv_w(&self, values: &mut RowValues) {
        if !values.has_params {
            values.inv_w = line(&values.from_origin, self.base.inv_w);
        }
    }

    /// Finds all other values along the runs of the group, if they are not yet known.
    #[inline(always)]
    pub(crate) fn find_params(&self, values: &mut RowValues) {
        if values.has_params {
            return;
        }
        values.has_params = true;
        values.inv_w = line(&values.from_origin, self.base.inv_w);
        if values.s.len() != self.params.len() {
            values.s.resize(self.params.len(), RowLine::default());
        }
        // A copy, which need not be read again after each store.
        let from_origin = values.from_origin;
        for (line_of, planes) in values.s.iter_mut().zip(self.params) {
            *line_of = line(&from_origin, planes.of(self.lane));
        }
    }

    /// The changes of depth, or of 1/w, per pixel to the right and downwards; none where it is found by edges.
    #[inline(always)]
    pub(crate) fn change(&self, component: Component) -> [f32; 2] {
        let plane = self.plane(component);
        let is_by_edges = self.mixed.is_some_and(|mixed| mixed.is_by_edges(component));
        if is_by_edges { [0.0; 2] } else { [plane.dx as f32, plane.dy as f32] }
    }

    /// The values along one run, found by the edges on its sides.
    #[cold]
    fn row_by_edges(&self, runs: &RunGroup, values: &mut RowValues) {
        let Run { x, .. } = runs.run(0);
        let run = self.in_run(&runs.run(0));
        let (inv_w, delta) = run.along(Component::InvW);
        let far_end = if delta < 0.0 { x.end - 1 } else { x.start };
        values.x = [self.near_viewport(far_end); ROWS];
        let steps = f64::from(values.x[0]) - f64::from(x.start);
        let line = |(start, delta): (f64, f64)| RowLine {
            at: [(start + delta * steps) as f32; ROWS],
            delta: delta as f32,
        };
        values.inv_w = line((inv_w, delta));
        values.z = line(run.along(Component::Z));
        values.s.clear();
        let params = 0..self.params.len();
        values.s.extend(params.map(|i| line(run.along(Component::S(i)))));
        values.has_params = true;
    }

    /// The plane of a value.
    #[inline(always)]
    pub(crate) fn plane(&self, component: Component) -> ScreenPlane {
        match component {
            Component::Z => self.base.z,
            Component::InvW => self.base.inv_w,
            Component::S(i) => self.params[i].of(self.lane),
        }
    }

    /// A value at a pixel's centre, and its slopes, by its plane.
    #[inline(always)]
    pub(crate) fn at_pixel(&self, component: Component, column: i32, row: i32) -> ScreenPlane {
        let (plane, [x, y]) = (self.plane(component), self.base.origin);
        let [column, row] = [column, row].map(|centre| f64::from(centre) + 0.5);
        ScreenPlane { value: plane.at(column - x, row - y), ..plane }
    }

    /// A run of this polygon.
    pub(crate) fn in_run(&self, run: &Run) -> InRun<'_> {
        let mixed = self.mixed.filter(|mixed| mixed.any_by_edges);
        let first = [run.x.start, run.y];
        if run.edges[1] == AT_EDGE {
            let at = mixed.map(|mixed| &mixed.vertices);
            let at = at.map(|vertices| AlongEdge::nearest(vertices, run.edges[0], first));
            return InRun { surface: self, first, across: None, at };
        }
        let across = mixed.map(|mixed| (mixed, AcrossRun::new(&mixed.vertices, run)));
        InRun { surface: self, first, across, at: None }
    }
}

/// A run of a polygon, in which values are found by their planes or by the edges on its sides, whichever
/// they have.
pub(crate) struct InRun<'s> {
    surface: &'s SurfaceView<'s>,
    /// Column and row of the first pixel.
    first: [i32; 2],
    across: Option<(&'s Mixed, AcrossRun<'s>)>,
    /// The point of an edge that a pixel has its values from, if its centre is outside.
    at: Option<AlongEdge<'s>>,
}

impl InRun<'_> {
    /// What a value is found by, if not by its plane.
    fn across(&self, component: Component) -> Option<&AcrossRun<'_>> {
        let (mixed, across) = self.across.as_ref()?;
        mixed.is_by_edges(component).then_some(across)
    }

    /// A value at the centre of the first pixel, and its change per pixel.
    pub(crate) fn along(&self, component: Component) -> (f64, f64) {
        if let Some(at) = &self.at {
            return (at.value(component), 0.0);
        }
        if let Some(across) = self.across(component) {
            return (across.start(component), across.delta(component));
        }
        let plane = self.surface.plane(component);
        let [x, y] = self.surface.base.origin;
        let [column, row] = self.first.map(|centre| f64::from(centre) + 0.5);
        (plane.at(column - x, row - y), plane.dx)
    }

    /// A value at the centre of a column.
    pub(crate) fn at(&self, component: Component, x: i32) -> f64 {
        let (start, delta) = self.along(component);
        start + delta * (f64::from(x) - f64::from(self.first[0]))
    }

    /// The change of a value per pixel to the right.
    fn slope(&self, component: Component) -> f64 {
        match &self.at {
            Some(_) => self.surface.plane(component).dx,
            None => self.along(component).1,
        }
    }

    /// A value at the centres of neighbouring columns, with its slopes, whatever it is found by.
    pub(crate) fn with_slopes(&self, component: Component, x: i32, found: &mut [ScreenPlane]) {
        let ((start, delta), dx) = (self.along(component), self.slope(component));
        let first = f64::from(self.first[0]);
        for (x, found) in (x..).zip(found) {
            let value = start + delta * (f64::from(x) - first);
            *found = ScreenPlane { value, dx, dy: self.downwards(component, x) };
        }
    }

    /// The change of a value per pixel downwards, at a column.
    fn downwards(&self, component: Component, x: i32) -> f64 {
        match self.across(component) {
            Some(across) => across.downwards(component, x),
            None => self.surface.plane(component).dy,
        }
    }
}

/// What the derivatives of a parameter r = s / q come from: the numerators of the quotient rule for the
/// planes of s and q, which are linear along the screen's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slopes {
    /// s_x q - s q_x in the row of the origin, and its change per row.
    x: (f64, f64),
    /// s_y q - s q_y in the column of the origin, and its change per column.
    y: (f64, f64),
    origin: [f64; 2],
}

impl Slopes {
    /// q^2 dr/dx, all along a row of pixels.
    #[inline(always)]
    pub(crate) fn numerator_x(&self, row: i32) -> f32 {
        (self.x.0 + self.x.1 * (f64::from(row) + 0.5 - self.origin[1])) as f32
    }

    /// q^2 dr/dy, all along a column of pixels.
    #[inline(always)]
    pub(crate) fn numerator_y(&self, column: i32) -> f32 {
        (self.y.0 + self.y.1 * (f64::from(column) + 0.5 - self.origin[0])) as f32
    }
}

impl SurfaceView<'_> {
    /// Whether a parameter, or the 1/w that it is divided by, has no plane.
    #[inline(always)]
    pub(crate) fn is_by_edges(&self, param: usize) -> bool {
        self.mixed.is_some_and(|mixed| {
            mixed.any_by_edges && (mixed.inv_w_by_edges || mixed.is_by_edges(Component::S(param)))
        })
    }

    /// What the derivatives of a parameter come from that is divided by 1/w at each pixel.
    #[inline(always)]
    pub(crate) fn slopes(&self, param: usize) -> Slopes {
        let (s, q) = (self.params[param].of(self.lane), self.base.inv_w);
        let cross = s.dx * q.dy - s.dy * q.dx;
        Slopes {
            x: (s.dx * q.value - s.value * q.dx, cross),
            y: (s.dy * q.value - s.value * q.dy, -cross),
            origin: self.base.origin,
        }
    }

    /// The derivatives of a parameter where all w are equal.
    #[inline(always)]
    pub(crate) fn undivided_slopes(&self, param: usize) -> [f32; 2] {
        let plane = self.params[param].of(self.lane);
        [plane.dx as f32, plane.dy as f32]
    }

    /// The derivatives of a parameter at a column of a run, whatever it is found by.
    #[cold]
    pub(crate) fn mixed_slopes(&self, param: usize, x: i32, run: &Run) -> [f32; 2] {
        let (run, s) = (self.in_run(run), Component::S(param));
        let s_dx = run.slope(s);
        let s_dy = run.downwards(s, x);
        if !self.times_w(param) {
            return [s_dx as f32, s_dy as f32];
        }
        let inv_w = run.at(Component::InvW, x);
        let inv_w_dx = run.slope(Component::InvW);
        let inv_w_dy = run.downwards(Component::InvW, x);
        let r = run.at(s, x) / inv_w;
        [(s_dx - r * inv_w_dx) / inv_w, (s_dy - r * inv_w_dy) / inv_w].map(|slope| slope as f32)
    }
}

/// A value with a plane, at a place in each row.
#[inline(always)]
fn line([xs, ys]: &[[f64; ROWS]; 2], plane: ScreenPlane) -> RowLine {
    let mut at = [0.0; ROWS];
    for row in 0..ROWS {
        at[row] = plane.at(xs[row], ys[row]) as f32;
    }
    RowLine { at, delta: plane.dx as f32 }
}
