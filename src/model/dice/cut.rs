//! Polygons cut into triangles by taking off ears (G. Meisters, "Polygons Have Ears", 1975).

use glam::{DVec2, DVec3};

/// So many corners are looked at, for each of the polygon, before what is left is taken for convex. A polygon of
/// 4096 corners or fewer hardly needs as many.
const LOOKS: usize = 4096;

/// The triangles of a polygon, by the numbers of its corners, each as the polygon goes round. It may be concave and bent; one
/// that crosses itself, or has no area, is cut somehow.
pub(super) fn triangles(polygon: &[DVec3]) -> Vec<[usize; 3]> {
    let flat = flattened(polygon);
    let mut left: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::with_capacity(polygon.len());
    if let [_, _, _, _] = polygon {
        // At the shorter of its diagonals, if either will do.
        let is_shorter =
            polygon[1].distance_squared(polygon[3]) < polygon[0].distance_squared(polygon[2]);
        left.rotate_left(usize::from(!is_shorter));
    }
    let mut looks = LOOKS * polygon.len();
    let (mut at, mut refused) = (0, 0);
    while left.len() > 3 {
        let count = left.len();
        at %= count;
        let ear = [left[(at + count - 1) % count], left[at], left[(at + 1) % count]];
        let is_ear = refused >= count || is_ear(&flat, ear, &left, &mut looks);
        if is_ear {
            triangles.push(ear);
            left.remove(at);
            refused = 0;
        } else {
            refused += 1;
        }
        // Ears that are neighbours would make a fan.
        at += 1;
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// Whether a corner, between its neighbours, can be cut off.
fn is_ear(flat: &[DVec2], [a, b, c]: [usize; 3], left: &[usize], looks: &mut usize) -> bool {
    let side = |from: usize, to: usize, point: usize| {
        (flat[to] - flat[from]).perp_dot(flat[point] - flat[from])
    };
    if side(a, b, c) <= 0.0 {
        return false;
    }
    if *looks < left.len() {
        return true;
    }
    *looks -= left.len();
    let is_inside = |&point: &usize| {
        // A corner that the polygon passes twice is no obstacle.
        ![a, b, c].iter().any(|&corner| flat[corner] == flat[point])
            && [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| side(from, to, point) >= 0.0)
    };
    !left.iter().any(is_inside)
}

/// The polygon in the plane of two axes, counter-clockwise: what is left without the axis that is nearest to its normal, by
/// Newell's method.
fn flattened(polygon: &[DVec3]) -> Vec<DVec2> {
    let first = polygon.first().copied().unwrap_or_default();
    let spokes = polygon.iter().map(|&position| position - first);
    let normal: DVec3 = spokes.clone().zip(spokes.clone().skip(1)).map(|(a, b)| a.cross(b)).sum();
    let axis = normal.abs().max_position();
    let [x, y] = if normal[axis] < 0.0 {
        [(axis + 2) % 3, (axis + 1) % 3]
    } else {
        [(axis + 1) % 3, (axis + 2) % 3]
    };
    spokes.map(|spoke| DVec2::new(spoke[x], spoke[y])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area in the plane, by the sides.
    fn area(polygon: &[DVec3]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum()
    }

    /// A comb is concave at every second corner: its triangles have its area, none is turned over, and each of its sides is
    /// one of theirs.
    #[test]
    fn a_concave_polygon_is_covered_once() {
        for count in [3, 4, 5, 12, 200] {
            let comb = |i: usize| {
                let i = i as f64;
                DVec3::new(
                    i,
                    if (i as usize).is_multiple_of(2) { 9.0 } else { 1.0 + 0.01 * i * i },
                    0.0,
                )
            };
            let mut polygon: Vec<_> = (0..count).rev().map(comb).collect();
            polygon.push(DVec3::new(0.0, -5.0, 0.0));
            polygon.push(DVec3::new(count as f64 - 1.0, -5.0, 0.0));
            let cut = triangles(&polygon);
            assert_eq!(cut.len(), polygon.len() - 2);
            let areas = cut.iter().map(|triangle| area(&triangle.map(|corner| polygon[corner])));
            assert!(areas.clone().all(|area| area > 0.0), "{count}");
            let sum: f64 = areas.sum();
            assert!((sum - area(&polygon)).abs() < 1e-9 * sum, "{count}: {sum}");
        }
    }

    #[test]
    fn any_polygon_is_cut() {
        let flat = [DVec3::ZERO; 7];
        let nan = [DVec3::NAN; 5];
        let bow =
            [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        assert_eq!(triangles(&flat).len(), 5);
        assert_eq!(triangles(&nan).len(), 3);
        assert_eq!(triangles(&bow).len(), 2);
        assert_eq!(triangles(&bow[..2]).len(), 0);
    }
}
