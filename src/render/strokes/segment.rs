//! One segment of a line: clipped in homogeneous space, and projected.
//!
//! Two kinds of planes cut it. Those that keep its places on the screen within bounds, w >= `MIN_W` and
//! the sides of the guard band, come first: what they leave is the line whose pixels are drawn. Near, far
//! and the user's planes then say which part of it is visible. They do not make a new line of it, whose
//! ends, once rounded, would lie beside the old one: each gives a point on the line, and pixels are
//! drawn up to there.

use glam::{DVec4, Vec3Swizzles, Vec4, Vec4Swizzles};

use crate::clip::records::{Cutter, EyePlane, Records};
use crate::coverage::line::LineEnd;
use crate::project::ScreenPoint;
use crate::settings::DrawCall;
use crate::subpixel::SubpixelPoint;
use crate::surface::line::LineValues;
use crate::view_volume::MIN_W;

/// Near and far come first among the planes of a draw call, then the four sides of the guard band.
const NEAR_AND_FAR: usize = 2;
const SIDES: usize = 4;

/// A segment being clipped, and the memory that it takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Segment {
    /// The ends of the line whose pixels are drawn.
    line: Records,
    next: Records,
    /// The points in which planes cut it.
    cuts: Records,
    /// Which of these bound the visible part, and how far along the line.
    bounds: [Option<(usize, f64)>; 2],
    /// Whether the ends are those that were given.
    is_whole: [bool; 2],
}

impl Segment {
    /// Clips a segment; whether there may be something to see.
    pub(crate) fn clip(&mut self, call: &DrawCall<'_>, ends: [(Vec4, &[f32]); 2]) -> bool {
        let Self { line, cuts, bounds, is_whole, .. } = self;
        line.clear(call.params());
        cuts.clear(call.params());
        (*bounds, *is_whole) = ([None; 2], [true; 2]);
        for (position, params) in ends {
            line.push(position, params, call.interpolation);
        }
        let positions = line.positions();
        if !positions.iter().all(|p| p.is_finite()) || is_seen_from_its_end(positions) {
            return false;
        }
        let (near_and_far, rest) = call.planes.split_at(NEAR_AND_FAR.min(call.planes.len()));
        let (sides, others) = rest.split_at(SIDES.min(rest.len()));
        self.shorten(call, &EyePlane)
            && sides.iter().all(|plane| self.shorten(call, plane))
            && near_and_far.iter().chain(others).all(|plane| self.bound(call, plane))
            && !self.bounds[0].zip(self.bounds[1]).is_some_and(|((_, a), (_, b))| a > b)
    }

    /// The distances of the ends from a plane.
    fn distances(&self, plane: &impl Cutter) -> [f64; 2] {
        [0, 1].map(|end| plane.distance(self.line.positions()[end]))
    }

    /// Keeps the inner part of the line; whether there is one.
    fn shorten(&mut self, call: &DrawCall<'_>, plane: &impl Cutter) -> bool {
        let distances @ [a, b] = self.distances(plane);
        if a >= 0.0 && b >= 0.0 {
            return true;
        }
        if a <= 0.0 && b <= 0.0 {
            return false;
        }
        let Self { line, next, .. } = self;
        next.clear(call.params());
        for (end, distance) in distances.into_iter().enumerate() {
            if distance < 0.0 {
                next.push_crossing(line, [0, 1], distances, plane, call.interpolation);
                self.is_whole[end] = false;
            } else {
                next.push_from(line, end);
            }
        }
        std::mem::swap(line, next);
        true
    }

    /// Bounds the visible part of the line by a plane; whether there is one.
    fn bound(&mut self, call: &DrawCall<'_>, plane: &impl Cutter) -> bool {
        let distances @ [a, b] = self.distances(plane);
        if a >= 0.0 && b >= 0.0 {
            return true;
        }
        if a <= 0.0 && b <= 0.0 {
            return false;
        }
        let along = a / (a - b);
        let number = self.cuts.len();
        self.cuts.push_crossing(&self.line, [0, 1], distances, plane, call.interpolation);
        let is_start = a < 0.0;
        let bound = &mut self.bounds[usize::from(!is_start)];
        if bound.is_none_or(|(_, so_far)| if is_start { so_far < along } else { along < so_far }) {
            *bound = Some((number, along));
        }
        true
    }

    /// The ends of the line whose pixels are drawn.
    pub(crate) fn points(&self, call: &DrawCall<'_>) -> [SubpixelPoint; 2] {
        let positions = self.line.positions();
        [0, 1].map(|end| SubpixelPoint::project(positions[end], &call.viewport))
    }

    /// Where its visible part ends.
    pub(crate) fn line_ends(&self, call: &DrawCall<'_>) -> [LineEnd; 2] {
        self.bounds.map(|bound| match bound {
            None => LineEnd::Own,
            Some((cut, _)) => {
                let position = self.cuts.positions()[cut];
                LineEnd::Cut(SubpixelPoint::project(position, &call.viewport))
            }
        })
    }

    /// Whether the visible part has the ends that were given.
    pub(crate) fn has_own_ends(&self) -> [bool; 2] {
        [0, 1].map(|end| self.is_whole[end] && self.bounds[end].is_none())
    }

    /// What is known at the ends of the visible part.
    pub(crate) fn values(&self, call: &DrawCall<'_>) -> [LineValues<'_>; 2] {
        [0, 1].map(|end| {
            let (records, record) = match self.bounds[end] {
                None => (&self.line, end),
                Some((cut, _)) => (&self.cuts, cut),
            };
            let position = records.positions()[record];
            LineValues {
                point: screen_point(call, position),
                w: position.w,
                params: records.params(record),
            }
        })
    }
}

/// The place on the screen of a position that was clipped.
pub(crate) fn screen_point(call: &DrawCall<'_>, position: DVec4) -> ScreenPoint {
    call.projection.point(position.to_array())
}

/// Whether a line that reaches the eye, or behind it, runs through the eye: all of it is seen at one
/// point, but clipping would make up places on the screen from rounding errors.
fn is_seen_from_its_end(positions: &[DVec4]) -> bool {
    let &[a, b] = positions else { return true };
    if a.w >= MIN_W && b.w >= MIN_W {
        return false;
    }
    let (a, b) = (a.xyw(), b.xyw());
    // The products are off by no more than this, at 2^-53 each.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    let size = a.abs().yzx() * b.abs().zxy() + a.abs().zxy() * b.abs().yzx();
    a.cross(b).abs().cmple(size * ROUNDING).all()
}
