//! How far a point of the screen lies from an outline.

use super::coverage::edges;

/// How far a point of the screen lies outside a convex outline, in pixels; 0 inside.
///
/// Meant for the centre of a covered pixel and [`unrounded_outline`]: rounding moves no vertex by
/// more than 1/512 pixel in x and in y, and hence no edge by more than sqrt(2)/512.
pub(crate) fn distance_outside(outline: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let area: f64 = edges(outline).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let side = |(a, b): ([f64; 2], [f64; 2])| {
        (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    };
    if area != 0.0 && edges(outline).all(|edge| side(edge) * area >= 0.0) {
        return 0.0;
    }
    distance_to_edges(outline, point)
}

/// The point of a convex outline, inside or on it, that is nearest to a point of the screen.
pub(crate) fn nearest_point(outline: &[[f64; 2]], point: [f64; 2]) -> [f64; 2] {
    if distance_outside(outline, point) == 0.0 {
        return point;
    }
    let distance = |p: &[f64; 2]| (p[0] - point[0]).hypot(p[1] - point[1]);
    let on_edges = edges(outline).map(|(a, b)| nearest_on_edge(a, b, point));
    on_edges.min_by(|p, q| distance(p).total_cmp(&distance(q))).unwrap_or(point)
}

fn nearest_on_edge(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> [f64; 2] {
    let ([ex, ey], [px, py]) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let length_squared = ex * ex + ey * ey;
    let t = if length_squared > 0.0 { (px * ex + py * ey) / length_squared } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    [a[0] + t * ex, a[1] + t * ey]
}

/// How far a point of the screen is from the nearest edge of an outline, in pixels; infinite
/// without edges.
pub(crate) fn distance_to_edges(outline: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let to_edge = |(a, b): ([f64; 2], [f64; 2])| {
        let nearest = nearest_on_edge(a, b, point);
        (nearest[0] - point[0]).hypot(nearest[1] - point[1])
    };
    edges(outline).map(to_edge).fold(f64::INFINITY, f64::min)
}
