//! Wide lines: the polygons of segments, joins and caps on the screen.
//!
//! ```text
//!               corner   tip
//!     ------------+-------+          two segments that meet at v. Each goes as far as v: to the line
//!     a's side    | join   \         from v to its corner on the outer side, and to that from v to
//!     - - - - - - v ------- +        where the inner sides meet. What is left outside is the join.
//!                /  \ corner \       All share their edges, so no pixel is drawn twice.
//!     ----------+    \        \
//!              inner
//! ```

use glam::DVec2;

use crate::render::stroke_style::{Cap, Join};

/// A corner of a line that has a width.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    at: DVec2,
    /// Where the sides of both segments meet to which the line turns; `None` if one ends before.
    inner: Option<DVec2>,
    /// The directions from there to both corners on the outer side.
    outwards: [DVec2; 2],
    /// 1 if the line turns towards its [normal], else -1.
    turn: f64,
}

/// How a segment ends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum End {
    Corner(Corner),
    /// The line goes on no farther.
    Last,
}

/// A normal of a direction.
fn normal(direction: DVec2) -> DVec2 {
    DVec2::new(-direction.y, direction.x)
}

impl Corner {
    /// The corner at a point between segments of given directions and lengths, with half the width.
    pub(crate) fn new(at: DVec2, [a, b]: [DVec2; 2], lengths: [f64; 2], half: f64) -> Self {
        let (cross, dot) = (a.perp_dot(b), a.dot(b));
        let turn = if cross >= 0.0 { 1.0 } else { -1.0 };
        let fits = half * cross.abs() <= 0.5 * lengths[0].min(lengths[1]) * (1.0 + dot);
        let inwards = to_sides(normal(a), normal(b)).filter(|_| fits);
        let inner = inwards.map(|inwards| at + inwards * (half * turn));
        Self { at, inner, outwards: [normal(a) * -turn, normal(b) * -turn], turn }
    }

    /// The same corner as the segment after it sees it that runs towards it.
    pub(crate) fn reversed(self) -> Self {
        let [a, b] = self.outwards;
        Self { turn: -self.turn, outwards: [b, a], ..self }
    }

    /// Adds the outline of the join.
    pub(crate) fn push_join(&self, outline: &mut Vec<DVec2>, half: f64, join: Join) {
        let (at, [a, b]) = (self.at, self.outwards);
        outline.extend([at, at + a * half]);
        match join {
            Join::Bevel => {}
            Join::Miter { limit } => {
                let tip = to_sides(a, b).filter(|tip| tip.length() <= f64::from(limit));
                outline.extend(tip.map(|tip| at + tip * half));
            }
            // Of half a circle the middle is where the line came to.
            Join::Round if (a + b).length() < 1e-3 => {
                let forward = normal(a) * self.turn;
                push_arc(outline, at, [a, forward], half);
                outline.push(at + forward * half);
                push_arc(outline, at, [forward, b], half);
            }
            Join::Round => push_arc(outline, at, [a, b], half),
        }
        outline.push(at + b * half);
    }
}

/// From a corner to where two sides meet, in halves of the width, by the directions from the corner to
/// the sides; `None` if the sides are parallel and run back.
fn to_sides(a: DVec2, b: DVec2) -> Option<DVec2> {
    let square = 1.0 + a.dot(b);
    (square > 1e-6).then(|| (a + b) / square)
}

/// Adds the points of a segment's end, which runs in a direction towards `at`, from the side of its
/// normal to the other.
pub(crate) fn push_end(
    outline: &mut Vec<DVec2>,
    at: DVec2,
    direction: DVec2,
    half: f64,
    end: &End,
) {
    let side = normal(direction) * half;
    match end {
        End::Last => outline.extend([at + side, at - side]),
        End::Corner(corner) => {
            let outer = corner.at + corner.outwards[0] * half;
            let inner = corner.inner.unwrap_or(corner.at - corner.outwards[0] * half);
            let is_inner_first = corner.turn > 0.0;
            let [first, last] = if is_inner_first { [inner, outer] } else { [outer, inner] };
            outline.extend([first, corner.at, last]);
        }
    }
}

/// Adds the outline of a cap, if it has one, at the end of a segment that runs in a direction.
pub(crate) fn push_cap(outline: &mut Vec<DVec2>, at: DVec2, direction: DVec2, half: f64, cap: Cap) {
    let side = normal(direction);
    let [left, right] = [at + side * half, at - side * half];
    match cap {
        Cap::Butt => {}
        Cap::Square => {
            outline.extend([left, left + direction * half, right + direction * half, right]);
        }
        Cap::Round => {
            outline.push(left);
            push_arc(outline, at, [side, direction], half);
            outline.push(at + direction * half);
            push_arc(outline, at, [direction, -side], half);
            outline.push(right);
        }
    }
}

/// Adds points between two directions, less than half a turn apart, so many that none of the chords is
/// more than 1/16 pixel inside of the arc.
fn push_arc(outline: &mut Vec<DVec2>, at: DVec2, [from, to]: [DVec2; 2], radius: f64) {
    const ERROR: f64 = 1.0 / 16.0;
    let middle = from + to;
    let length = middle.length();
    // Half the sum of two directions lies as far inside as the chord does.
    if length < 1e-6 || radius * (1.0 - length * 0.5) <= ERROR {
        return;
    }
    let middle = middle / length;
    push_arc(outline, at, [from, middle], radius);
    outline.push(at + middle * radius);
    push_arc(outline, at, [middle, to], radius);
}
