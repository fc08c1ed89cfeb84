//! The signed area of an outline on the screen: in which direction it runs.

use crate::outline::Chain;
use crate::subpixel::SubpixelPoint;

/// Twice the signed area of an outline in square subpixels; positive when it runs clockwise as seen
/// on the screen.
#[inline(always)]
pub(crate) fn signed_area<V>(outline: &[V], point: impl Fn(&V) -> SubpixelPoint) -> i128 {
    let [o, rest @ ..] = outline else { return 0 };
    let o = point(o);
    // Within the guard band each product has at most 54 bits.
    let from_o = |v: &V| {
        let p = point(v);
        (i64::from(p.x - o.x), i64::from(p.y - o.y))
    };
    let twice = |a: (i64, i64), b: (i64, i64)| a.0 * b.1 - b.0 * a.1;
    match rest {
        [a, b] => twice(from_o(a), from_o(b)).into(),
        _ => rest
            .iter()
            .zip(rest.iter().skip(1))
            .fold(0, |sum, (a, b)| sum + i128::from(twice(from_o(a), from_o(b)))),
    }
}

/// Twice the signed area of an outline that is one contour, or, if there are any, of its chains.
pub(crate) fn signed_area_of(outline: &[SubpixelPoint], chains: &[Chain]) -> i128 {
    if chains.is_empty() {
        return signed_area(outline, |point| *point);
    }
    let Some(&o) = outline.first() else { return 0 };
    // All chains together are closed, so any point will do as the origin.
    let from_o = |p: &SubpixelPoint| (i64::from(p.x - o.x), i64::from(p.y - o.y));
    let cross = |(a, b): ((i64, i64), (i64, i64))| i128::from(a.0 * b.1 - b.0 * a.1);
    chain_edges(outline, chains)
        .map(|(a, b, _, winding)| i128::from(winding) * cross((from_o(a), from_o(b))))
        .sum()
}

/// The edges of chains: both ends, the index of the first one, and the winding.
pub(crate) fn chain_edges<'a>(
    points: &'a [SubpixelPoint],
    chains: &'a [Chain],
) -> impl Iterator<Item = (&'a SubpixelPoint, &'a SubpixelPoint, u32, i32)> {
    let mut start = 0;
    chains.iter().flat_map(move |&Chain { end, winding }| {
        let first = std::mem::replace(&mut start, end);
        let points = points.get(first..end).unwrap_or_default();
        let edges = points.iter().zip(points.iter().skip(1)).zip(first as u32..);
        edges.map(move |((a, b), index)| (a, b, index, winding))
    })
}
