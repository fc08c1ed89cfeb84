//! The diamond-exit rule as OpenGL states it (4.6, section 14.5.1), on exact numbers.
//!
//! Both ends are moved by (-e, -e^2) for an e that is smaller than any number; a pixel is drawn if the
//! segment between them meets the open diamond around its centre, unless the second end lies in it.
//! A number is a + b e + c e^2 here, compared term by term. In u = x + y and v = x - y a diamond is an
//! open square.

use std::cmp::Ordering;

/// a + b e + c e^2.
type Number = [i128; 3];

fn minus(a: Number, b: i128) -> Number {
    [a[0] - b, a[1], a[2]]
}

/// What a quotient of a number and a positive integer is, beside another.
fn compare((a, da): (Number, i128), (b, db): (Number, i128)) -> Ordering {
    a.map(|a| a * db).cmp(&b.map(|b| b * da))
}

/// The pixels of the line from `a` to `b`, in subpixels (1/256), among those in a rectangle of columns
/// and rows: found by asking each of them.
pub(crate) fn pixels(
    a: [i64; 2],
    b: [i64; 2],
    columns: std::ops::Range<i64>,
    rows: std::ops::Range<i64>,
) -> Vec<[i64; 2]> {
    let each = rows.flat_map(|y| columns.clone().map(move |x| [x, y]));
    each.filter(|&pixel| is_drawn(a, b, pixel)).collect()
}

/// Whether the line from `a` to `b` draws a pixel.
pub(crate) fn is_drawn(a: [i64; 2], b: [i64; 2], pixel: [i64; 2]) -> bool {
    let centre = pixel.map(|c| i128::from(c) * 256 + 128);
    let turned = |[x, y]: [i128; 2]| [x + y, x - y];
    let [cu, cv] = turned(centre);
    let moved = |p: [i64; 2]| {
        let [u, v] = turned(p.map(i128::from));
        [[u, -1, -1], [v, -1, 1]]
    };
    let (start, end) = (moved(a), moved(b));
    // The times at which the segment is within the square: after the one, before the other.
    let mut after = vec![];
    let mut before = vec![];
    let mut ends_inside = true;
    for (axis, c) in [cu, cv].into_iter().enumerate() {
        let (low, high) = (c - 128, c + 128);
        let (from, to) = (start[axis], end[axis]);
        let is_inside = |n: Number| minus(n, low) > [0; 3] && minus(n, high) < [0; 3];
        ends_inside &= is_inside(to);
        let step = to[0] - from[0];
        let times = [low, high].map(|bound| minus(from, bound).map(|n| -n));
        match step.cmp(&0) {
            Ordering::Equal if !is_inside(from) => return false,
            Ordering::Equal => {}
            Ordering::Greater => {
                after.push((times[0], step));
                before.push((times[1], step));
            }
            Ordering::Less => {
                after.push((times[1].map(|n| -n), -step));
                before.push((times[0].map(|n| -n), -step));
            }
        }
    }
    let (zero, one) = (([0; 3], 1), ([1, 0, 0], 1));
    let meets = after
        .iter()
        .all(|&t| compare(t, one).is_lt() && before.iter().all(|&s| compare(t, s).is_lt()))
        && before.iter().all(|&s| compare(zero, s).is_lt());
    meets && !ends_inside
}
