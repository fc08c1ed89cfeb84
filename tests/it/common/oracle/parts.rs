//! Clipping an outline of several contours, which planes may cut into parts.

use std::array::from_fn;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::clipping::{depth_planes, dot, exact, guard_planes, rational};
use super::projection::snap;
use super::{Depth, Exact, Plane, Position, Snapped, Window};

/// A directed edge, and how often it counts.
pub(crate) type Edge<P> = (P, P, i32);

/// The edges of closed contours.
fn contour_edges<T: Clone>(contours: &[Vec<T>]) -> Vec<Edge<T>> {
    let edges = |contour: &Vec<T>| {
        let next = contour.iter().cycle().skip(1);
        contour.iter().cloned().zip(next.cloned()).map(|(a, b)| (a, b, 1)).collect::<Vec<_>>()
    };
    contours.iter().filter(|contour| contour.len() >= 3).flat_map(edges).collect()
}

/// The border, on the screen and rounded, of what is left of contours inside every plane: for
/// polygons of any shape, which planes may cut into parts. A polygon that is not planar meets a
/// clipping plane in points off any line; they are joined in their order on the screen.
pub(crate) fn border(
    contours: &[Vec<Position>],
    window: Window,
    depth: Depth,
    guard: f64,
    planes: &[Plane],
) -> Vec<Edge<Snapped>> {
    let exact: Vec<_> = contours.iter().map(|contour| exact(contour)).collect();
    let all = planes.iter().cloned().chain(depth_planes(depth)).chain(guard_planes(window, guard));
    let edges = all.fold(contour_edges(&exact), |edges, plane| clip_edges(edges, &plane));
    let is_visible = |(a, b, _): &Edge<Exact>| !a[3].is_zero() && !b[3].is_zero();
    let snapped = |(a, b, n): &Edge<Exact>| (snap(a, window), snap(b, window), *n);
    edges.iter().filter(|edge| is_visible(edge)).map(snapped).collect()
}

/// Cuts every edge, and closes the border along the plane from each point where it meets the plane
/// to the next.
fn clip_edges(edges: Vec<Edge<Exact>>, plane: &Plane) -> Vec<Edge<Exact>> {
    let zero = BigRational::zero();
    if edges.iter().all(|(a, b, _)| dot(plane, a) >= zero && dot(plane, b) >= zero) {
        return edges;
    }
    let mut clipped = Vec::new();
    let mut met: Vec<(Exact, i32)> = Vec::new();
    for (mut a, mut b, n) in edges {
        let (da, db) = (dot(plane, &a), dot(plane, &b));
        if da <= zero && db <= zero {
            continue;
        }
        let t = if da == db { zero.clone() } else { &da / (&da - &db) };
        let cut: Exact = from_fn(|k| &a[k] + (&b[k] - &a[k]) * &t);
        if da <= zero {
            a = cut.clone();
            met.push((a.clone(), -n));
        }
        if db <= zero {
            b = cut;
            met.push((b.clone(), n));
        }
        clipped.push((a, b, n));
    }
    let on_screen = met.iter().all(|(p, _)| p[3] > zero);
    let coordinate = |p: &Exact, k: usize| if on_screen { &p[k] / &p[3] } else { p[k].clone() };
    let extent = |k: usize| {
        let all = || met.iter().map(|(p, _)| coordinate(p, k));
        all().max().unwrap_or_default() - all().min().unwrap_or_default()
    };
    let axis = (0..if on_screen { 2 } else { 4 }).max_by_key(|&k| extent(k)).unwrap_or(0);
    met.sort_by_cached_key(|(p, _)| coordinate(p, axis));
    let mut winding = 0;
    for pair in met.windows(2) {
        winding += pair[0].1;
        if winding != 0 {
            clipped.push((pair[0].0.clone(), pair[1].0.clone(), winding));
        }
    }
    clipped
}

/// The same border, found in another way, for contours that lie in one plane: nothing is clipped
/// there. `places` are the vertices in coordinates of that plane. Every plane is a straight line
/// there, and the part of it that belongs to the border is where the contours wind around it,
/// which is looked up between all the points where something meets it.
///
/// `None` for what this cannot tell: a vertex exactly on a plane, planes that coincide, a border at
/// w = 0.
pub(crate) fn planar_border(
    places: &[Vec<[f64; 2]>],
    contours: &[Vec<Position>],
    window: Window,
    depth: Depth,
    guard: f64,
    planes: &[Plane],
) -> Option<Vec<Edge<Snapped>>> {
    let places: Vec<Vec<Place>> =
        places.iter().map(|contour| contour.iter().map(|p| p.map(rational)).collect()).collect();
    let position = PlaneMap::new(&places.concat(), &exact(&contours.concat()))?;
    let all = planes.iter().cloned().chain(depth_planes(depth)).chain(guard_planes(window, guard));
    let lines: Vec<Place3> = all.map(|plane| position.line(&plane)).collect();
    let outline = contour_edges(&places);
    if lines.iter().any(|line| places.iter().flatten().any(|p| height(line, p).is_zero())) {
        return None;
    }
    let mut border = Vec::new();
    for (a, b, n) in &outline {
        let stretch =
            lines.iter().try_fold([BigRational::zero(), BigRational::one()], |t, line| {
                narrowed(t, &height(line, a), &(height(line, b) - height(line, a)))
            });
        if let Some(stretch) = stretch {
            let [from, to] = stretch.map(|t| along(a, b, &t));
            border.push((from, to, *n));
        }
    }
    for (i, line) in lines.iter().enumerate() {
        border.extend(border_along(line, &lines[..i], &lines[i + 1..], &outline)?);
    }
    let snapped = |p: &Place| {
        let p = position.at(p);
        (p[3] > BigRational::zero()).then(|| snap(&p, window))
    };
    border.iter().map(|(a, b, n)| Some((snapped(a)?, snapped(b)?, *n))).collect()
}

/// A point of a polygon's plane.
type Place = [BigRational; 2];
/// The function c + a s + b t of a place (s, t), as [a, b, c].
type Place3 = [BigRational; 3];

fn height([a, b, c]: &Place3, p: &Place) -> BigRational {
    a * &p[0] + b * &p[1] + c
}

fn along(a: &Place, b: &Place, t: &BigRational) -> Place {
    from_fn(|k| &a[k] + (&b[k] - &a[k]) * t)
}

/// The part of a stretch of numbers u where start + slope u is not negative; `None` if it is empty.
fn narrowed(
    [mut low, mut high]: [BigRational; 2],
    start: &BigRational,
    slope: &BigRational,
) -> Option<[BigRational; 2]> {
    if slope.is_zero() {
        return (*start >= BigRational::zero()).then_some([low, high]);
    }
    let at = -start / slope;
    if *slope > BigRational::zero() {
        low = low.max(at);
    } else {
        high = high.min(at);
    }
    (low < high).then_some([low, high])
}

/// The border along a line, with what is inside to its left.
fn border_along(
    line: &Place3,
    before: &[Place3],
    after: &[Place3],
    outline: &[Edge<Place>],
) -> Option<Vec<Edge<Place>>> {
    let [a, b, c] = line;
    let square = a * a + b * b;
    if square.is_zero() {
        // All of the polygon's plane lies on one side.
        return Some(Vec::new());
    }
    let origin: Place = [-a * c / &square, -b * c / &square];
    let ahead: Place = [&origin[0] + b, &origin[1] - a];
    let mut meetings = Vec::new();
    for (p, q, _) in outline {
        let (hp, hq) = (height(line, p), height(line, q));
        if (hp > BigRational::zero()) != (hq > BigRational::zero()) {
            let x = along(p, q, &(&hp / (&hp - &hq)));
            meetings.push(((&x[0] - &origin[0]) * b - (&x[1] - &origin[1]) * a) / &square);
        }
    }
    let (Some(least), Some(most)) = (meetings.iter().min(), meetings.iter().max()) else {
        return Some(Vec::new());
    };
    let mut stretch = Some([least.clone(), most.clone()]);
    for other in before.iter().chain(after) {
        let start = height(other, &origin);
        let slope = height(other, &ahead) - &start;
        if slope.is_zero() && start.is_zero() {
            return None;
        }
        stretch = stretch.and_then(|stretch| narrowed(stretch, &start, &slope));
    }
    let Some([low, high]) = stretch else { return Some(Vec::new()) };
    meetings.retain(|u| low < *u && *u < high);
    meetings.extend([low, high]);
    meetings.sort();
    let at = |u: &BigRational| along(&origin, &ahead, u);
    let two = BigRational::from_integer(2.into());
    let edge = |pair: &[BigRational]| {
        let winding = winding_about(outline, &at(&((&pair[0] + &pair[1]) / &two)));
        (at(&pair[0]), at(&pair[1]), winding)
    };
    Some(meetings.windows(2).map(edge).filter(|edge| edge.2 != 0).collect())
}

/// How often edges wind around a place that lies on none, counter-clockwise with t up.
fn winding_about(outline: &[Edge<Place>], p: &Place) -> i32 {
    let turn = |(a, b, n): &Edge<Place>| {
        let side = (&b[0] - &a[0]) * (&p[1] - &a[1]) - (&b[1] - &a[1]) * (&p[0] - &a[0]);
        match (a[1] <= p[1], b[1] <= p[1]) {
            (true, false) if side > BigRational::zero() => *n,
            (false, true) if side < BigRational::zero() => -n,
            _ => 0,
        }
    };
    outline.iter().map(turn).sum()
}

/// The affine map from places to clip space that takes some places to their positions.
struct PlaneMap([Place3; 4]);

impl PlaneMap {
    /// `None` when all places lie on one line.
    ///
    /// # Panics
    /// When there is no such map: the polygon is not planar.
    fn new(places: &[Place], positions: &[Exact]) -> Option<Self> {
        let from = |i: usize, j: usize, k: usize| &places[j][k] - &places[i][k];
        let area = |i, j, l| from(i, j, 0) * from(i, l, 1) - from(i, j, 1) * from(i, l, 0);
        let j = (1..places.len()).find(|&j| places[j] != places[0])?;
        let l = (1..places.len()).find(|&l| !area(0, j, l).is_zero())?;
        let all = area(0, j, l);
        let map = Self(from_fn(|k| {
            let to = |i: usize| &positions[i][k] - &positions[0][k];
            let s = (to(j) * from(0, l, 1) - to(l) * from(0, j, 1)) / &all;
            let t = (to(l) * from(0, j, 0) - to(j) * from(0, l, 0)) / &all;
            let c = &positions[0][k] - &s * &places[0][0] - &t * &places[0][1];
            [s, t, c]
        }));
        assert!(places.iter().zip(positions).all(|(p, q)| map.at(p) == *q), "not planar");
        Some(map)
    }

    fn at(&self, p: &Place) -> Exact {
        from_fn(|k| height(&self.0[k], p))
    }

    /// The line on which a plane meets the polygon's.
    fn line(&self, plane: &Plane) -> Place3 {
        from_fn(|i| (0..4).map(|k| &plane[k] * &self.0[k][i]).sum())
    }
}
