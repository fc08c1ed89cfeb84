//! How the values of a line or a point run over the screen (Low 2002, section 2: lines before polygons).
//!
//! Along a line z, s_1 .. s_n and s_{n+1} = 1/w are linear on the screen. Across it they do not change:
//! so they are planes, as those of a polygon are, whose slope lies along the line. A line of width 1 has
//! one pixel in each column or row, and its values there are those where it crosses the centre line of
//! that column or row: its slope lies along the screen's axis. Nothing leaves the range of its ends.

use crate::project::ScreenPoint;
use crate::scalar::Scalar as _;
use crate::settings::DrawCall;
use crate::surface::base::{Divide, SurfaceBase, WRange};
use crate::surface::mixed::{Mixed, extent};
use crate::surface::plane::{BatchPlane, ScreenPlane};
use crate::surface::rows::SurfaceView;
use crate::surface::triangle::is_divided;

/// How far apart, in pixels, the ends must be for what changes between them to have a slope.
const MIN_LENGTH: f64 = 1.0 / (1 << 20) as f64;

/// A line that is set up, with the memory that this takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineSurface {
    base: SurfaceBase,
    params: Vec<BatchPlane>,
    mixed: Mixed,
}

/// The direction in which the values of a line change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slope {
    /// From column to column.
    Columns,
    /// From row to row.
    Rows,
    /// Along the line itself.
    Along,
    /// They do not: a point's.
    Nowhere,
}

/// What is known at an end of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineValues<'a> {
    /// Its place on the screen, and its depth and 1/w.
    pub(crate) point: ScreenPoint,
    pub(crate) w: f64,
    /// The parameters, not divided.
    pub(crate) params: &'a [f64],
}

impl LineSurface {
    /// How the parameters run.
    pub(crate) fn view(&self) -> SurfaceView<'_> {
        let Self { base, params, mixed } = self;
        SurfaceView { base, params, lane: 0, mixed: Some(mixed) }
    }

    /// Sets up a line between two ends.
    pub(crate) fn set_up(
        &mut self,
        call: &DrawCall<'_>,
        face: u32,
        [a, b]: [LineValues<'_>; 2],
        slope: Slope,
    ) {
        let (min, max) = extent([a.w, b.w].into_iter());
        let unit = min.power_of_two_below();
        let w = WRange::new([min, max], [unit / max, unit / min]);
        let gradient = gradient(&a.point, &b.point, slope);
        let plane = |[a, b]: [f64; 2]| ScreenPlane {
            value: a,
            dx: (b - a) * gradient[0],
            dy: (b - a) * gradient[1],
        };
        let [az, bz] = [a, b].map(|end| within(end.point.z, call.projection.depth_range()));
        let inv_w = [a, b].map(|end| end.point.inv_w * unit);
        let (near, far) = extent([az, bz].into_iter());
        self.base = SurfaceBase {
            corner: call.projection.corner,
            last_column: call.projection.last_column,
            face,
            is_front: true,
            origin: [a.point.x, a.point.y],
            z: plane([az, bz]),
            inv_w: plane(inv_w),
            z_range: (near as f32, far as f32),
            w_unit: unit,
            w,
            divide: Divide::Mixed,
        };
        let Self { params, mixed, .. } = self;
        params.clear();
        mixed.times_w.clear();
        mixed.limits.clear();
        mixed.has_limits = true;
        mixed.s_by_edges.clear();
        mixed.s_by_edges.resize(call.params(), false);
        for (i, (&ra, &rb)) in a.params.iter().zip(b.params).enumerate() {
            let times_w = w.varies() && is_divided(call, i);
            let s = if times_w { [ra * inv_w[0], rb * inv_w[1]] } else { [ra, rb] };
            let ScreenPlane { value, dx, dy } = plane(s);
            let mut lanes = BatchPlane::default();
            (lanes.0.value[0], lanes.0.dx[0], lanes.0.dy[0]) = (value, dx, dy);
            params.push(lanes);
            mixed.times_w.push(times_w);
            let (min, max) = extent([ra, rb].into_iter());
            // Of NaN alone there is no extent.
            let is_any = min <= max;
            mixed.limits.push(if is_any { (min as f32, max as f32) } else { (f32::NAN, f32::NAN) });
        }
        self.base.add_bias(call);
    }
}

/// The change per pixel, to the right and downwards, of what is 0 at `a` and 1 at `b`.
fn gradient(a: &ScreenPoint, b: &ScreenPoint, slope: Slope) -> [f64; 2] {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let [gx, gy] = match slope {
        Slope::Columns if dx.abs() >= MIN_LENGTH => [1.0 / dx, 0.0],
        Slope::Rows if dy.abs() >= MIN_LENGTH => [0.0, 1.0 / dy],
        Slope::Along if dx.abs() + dy.abs() >= MIN_LENGTH => {
            let square = dx * dx + dy * dy;
            [dx / square, dy / square]
        }
        _ => [0.0; 2],
    };
    if gx.is_finite() && gy.is_finite() { [gx, gy] } else { [0.0; 2] }
}

fn within(value: f64, (least, greatest): (f64, f64)) -> f64 {
    let raised = if value > least { value } else { least };
    if raised < greatest { raised } else { greatest }
}
