//! An oracle for coverage and parameters: polygons in clip space in, covered pixels and parameter
//! values out.
//!
//! Written from the conventions and the contracts alone, and the slow way on purpose. Coverage
//! clips and projects in rational numbers, rounds once, and asks pixel by pixel whether the centre
//! lies in the outline: no edge is stepped, no span is built. Parameters come from meeting the ray
//! of a pixel centre with the plane of the polygon in clip space: no screen-space plane, nothing
//! divided by w beforehand, nothing carried from pixel to pixel.
//!
//! Clip space has x right and y up, screen space x right and y down with pixel (0, 0) top left.
//! Positions are finite; the oracle panics on others, as exact arithmetic has no word for them.

use std::array::from_fn;
use std::cmp::Ordering;
use std::ops::{Neg, Range};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{Num, One, ToPrimitive, Zero};

/// A vertex in clip space: x right, y up, z, w.
pub(crate) type Position = [f32; 4];
/// A vertex in clip space, exactly.
pub(crate) type Exact = [BigRational; 4];
/// The half space a x + b y + c z + d w >= 0.
pub(crate) type Plane = [BigRational; 4];
/// A point of the screen in steps of 1/256 pixel, y down.
pub(crate) type Snapped = (i64, i64);

/// Steps per pixel: positions are rounded to 8 fractional bits.
const STEPS: i64 = 256;

/// A viewport in pixels whose top left pixel is (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Which depths the view volume holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// 0 <= z <= w.
    ZeroToOne,
    /// -w <= z <= w.
    MinusOneToOne,
}

/// Which winding numbers are inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FillRule {
    /// All but 0.
    NonZero,
    /// The odd ones.
    EvenOdd,
}

// ---------------------------------------------------------------------------------------- clipping

/// The value as a rational number, exactly.
///
/// # Panics
/// When the value is infinite or not a number.
pub(crate) fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("the oracle takes finite numbers")
}

/// The vertices as rational numbers, exactly.
pub(crate) fn exact(polygon: &[Position]) -> Vec<Exact> {
    polygon.iter().map(|p| p.map(|c| rational(f64::from(c)))).collect()
}

/// A half space from small whole coefficients.
pub(crate) fn plane(coefficients: [i32; 4]) -> Plane {
    coefficients.map(|c| BigRational::from_integer(c.into()))
}

/// The near plane, the far plane, and w >= 0, which only a depth convention with more room would
/// need.
pub(crate) fn depth_planes(depth: Depth) -> [Plane; 3] {
    let near = match depth {
        Depth::ZeroToOne => [0, 0, 1, 0],
        Depth::MinusOneToOne => [0, 0, 1, 1],
    };
    [near, [0, 0, -1, 1], [0, 0, 0, 1]].map(plane)
}

/// The four sides of the viewport, moved outwards by `guard` pixels: screen x from -guard to
/// width + guard, and so for y.
pub(crate) fn guard_planes(window: Window, guard: f64) -> [Plane; 4] {
    // (x/w + 1) width/2 >= -guard  <=>  x + (1 + 2 guard/width) w >= 0; the other side mirrors it.
    let reach = |size: u32| BigRational::one() + rational(2.0 * guard) / rational(f64::from(size));
    let (x, y) = (reach(window.width), reach(window.height));
    let mut planes = [[1, 0, 0, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, -1, 0, 0]].map(plane);
    planes.iter_mut().zip([&x, &x, &y, &y]).for_each(|(plane, reach)| plane[3] = reach.clone());
    planes
}

/// The part of the polygon inside every plane, by Sutherland and Hodgman.
///
/// An outline that is not convex may fall into parts; they stay joined by edges that run to and fro
/// along the plane, which no winding number sees. Rounded to the screen such a pair may part by
/// 1/256 pixel, unless the plane is a side of the guard band: see [`border`].
pub(crate) fn clip(polygon: &[Exact], planes: &[Plane]) -> Vec<Exact> {
    planes.iter().fold(polygon.to_vec(), |polygon, plane| clip_by(&polygon, plane))
}

fn clip_by(polygon: &[Exact], plane: &Plane) -> Vec<Exact> {
    let side: Vec<BigRational> = polygon.iter().map(|p| dot(plane, p)).collect();
    let mut clipped = Vec::new();
    for i in 0..polygon.len() {
        let j = (i + 1) % polygon.len();
        if side[i] >= BigRational::zero() {
            clipped.push(polygon[i].clone());
        }
        if (side[i] >= BigRational::zero()) != (side[j] >= BigRational::zero()) {
            let t = &side[i] / (&side[i] - &side[j]);
            clipped.push(from_fn(|k| &polygon[i][k] + (&polygon[j][k] - &polygon[i][k]) * &t));
        }
    }
    clipped
}

fn dot(plane: &Plane, p: &Exact) -> BigRational {
    let terms = plane.iter().zip(p).filter(|(coefficient, _)| !coefficient.is_zero());
    terms.fold(BigRational::zero(), |sum, (coefficient, c)| sum + coefficient * c)
}

/// What is left of the polygon between near and far plane and inside the guard band, with w > 0
/// everywhere.
///
/// The sides of the viewport itself cut nothing. A vertex that survives with w = 0 is the eye
/// itself (the guard band drops all others); its two edges project to points, so it leaves without
/// a trace.
pub(crate) fn clip_to_view(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<Exact> {
    clip_exact_to_view(&exact(polygon), window, depth, guard)
}

fn clip_exact_to_view(polygon: &[Exact], window: Window, depth: Depth, guard: f64) -> Vec<Exact> {
    let clipped = clip(&clip(polygon, &depth_planes(depth)), &guard_planes(window, guard));
    clipped.into_iter().filter(|p| !p[3].is_zero()).collect()
}

// ------------------------------------------------------------------------------- clipping, in parts

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

// -------------------------------------------------------------------------------------- projection

/// Where the vertex falls on the screen, in pixels, y down, exactly.
pub(crate) fn project(p: &Exact, window: Window) -> [BigRational; 2] {
    let half = |size: u32| BigRational::new(size.into(), 2.into());
    let x = (&p[0] / &p[3] + BigRational::one()) * half(window.width);
    let y = (BigRational::one() - &p[1] / &p[3]) * half(window.height);
    [x, y]
}

/// Where the vertex falls on the screen, rounded to 1/256 pixel, half to even.
pub(crate) fn snap(p: &Exact, window: Window) -> Snapped {
    let [x, y] = project(p, window).map(|c| round_half_even(&(c * BigInt::from(STEPS))));
    (x, y)
}

/// The nearest whole number, of two equally near ones the even one.
pub(crate) fn round_half_even(value: &BigRational) -> i64 {
    let below = value.floor().to_integer();
    let rest = value - BigRational::from_integer(below.clone());
    let up = match rest.cmp(&BigRational::new(1.into(), 2.into())) {
        Ordering::Less => false,
        Ordering::Equal => below.is_odd(),
        Ordering::Greater => true,
    };
    (below + i32::from(up)).to_i64().expect("a screen position inside the guard band")
}

/// The polygon's outline on the screen: clipped, projected, rounded.
pub(crate) fn outline(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<Snapped> {
    clip_to_view(polygon, window, depth, guard).iter().map(|p| snap(p, window)).collect()
}

/// The same outline before the rounding, in pixels, each coordinate the nearest f64.
pub(crate) fn unrounded_outline(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<[f64; 2]> {
    let clipped = clip_to_view(polygon, window, depth, guard);
    clipped.iter().map(|p| project(p, window).map(|c| nearest(&c))).collect()
}

fn nearest(value: &BigRational) -> f64 {
    value.to_f64().expect("every rational number has a nearest f64")
}

// ---------------------------------------------------------------------------------------- coverage

/// The centre of a pixel.
pub(crate) fn centre(x: u32, y: u32) -> Snapped {
    (i64::from(x) * STEPS + STEPS / 2, i64::from(y) * STEPS + STEPS / 2)
}

/// How often the outline winds around the point, clockwise on the screen counting -1.
///
/// Counts the edges that meet the horizontal line through the point at or left of it. An edge owns
/// its upper end and not its lower one, so a point on a top edge is inside and one on a bottom edge
/// outside; a meeting exactly at the point counts, so a point on a left edge is inside and one on a
/// right edge outside: the top-left rule, for any outline.
pub(crate) fn winding(outline: &[Snapped], point: Snapped) -> i32 {
    edges(outline).map(|(a, b)| turn((a, b, 1), point)).sum()
}

/// What one edge adds to the winding number.
fn turn((a, b, n): Edge<Snapped>, point: Snapped) -> i32 {
    let (x, y) = wide(point);
    let ((ax, ay), (bx, by)) = (wide(a), wide(b));
    let (upper, lower, turn) =
        if ay <= by { ((ax, ay), (bx, by), n) } else { ((bx, by), (ax, ay), -n) };
    let spans = upper.1 <= y && y < lower.1;
    // The edge is at x = upper.x + (y - upper.y) (lower.x - upper.x) / (lower.y - upper.y).
    let is_left = (y - upper.1) * (lower.0 - upper.0) <= (x - upper.0) * (lower.1 - upper.1);
    if spans && is_left { turn } else { 0 }
}

/// Whether the point is inside the outline by the fill rule, and by the top-left rule when it lies
/// on an edge.
pub(crate) fn covers(outline: &[Snapped], point: Snapped, rule: FillRule) -> bool {
    is_inside(winding(outline, point), rule)
}

fn is_inside(winding: i32, rule: FillRule) -> bool {
    match rule {
        FillRule::NonZero => winding != 0,
        FillRule::EvenOdd => winding % 2 != 0,
    }
}

/// The same question for a convex outline, answered in another way: the point is on the inner side
/// of every edge, or on an edge that is a top or a left one.
///
/// The outline has to be convex on the screen, after the rounding: see [`is_convex`].
pub(crate) fn covers_convex(outline: &[Snapped], point: Snapped) -> bool {
    let area = doubled_area(outline);
    area != 0
        && edges(outline).filter(|(a, b)| a != b).all(|(a, b)| {
            // Walk every outline clockwise on the screen: the top edges then run right and the left
            // ones up.
            let (a, b) = if area > 0 { (a, b) } else { (b, a) };
            let top_or_left = b.1 < a.1 || (b.1 == a.1 && b.0 > a.0);
            let side = edge_function(a, b, point);
            side > 0 || (side == 0 && top_or_left)
        })
}

/// Whether no vertex lies on the outer side of any edge. An outline without an area is not convex.
pub(crate) fn is_convex(outline: &[Snapped]) -> bool {
    let sign = doubled_area(outline).signum();
    let keeps_side =
        |(a, b): (Snapped, Snapped)| outline.iter().all(|&p| edge_function(a, b, p) * sign >= 0);
    sign != 0 && edges(outline).all(keeps_side)
}

/// Twice the area, positive when the outline runs clockwise on the screen.
pub(crate) fn doubled_area(outline: &[Snapped]) -> i128 {
    let cross = |((ax, ay), (bx, by)): ((i128, i128), (i128, i128))| ax * by - ay * bx;
    edges(outline).map(|(a, b)| cross((wide(a), wide(b)))).sum()
}

fn edge_function(a: Snapped, b: Snapped, p: Snapped) -> i128 {
    let ((ax, ay), (bx, by), (px, py)) = (wide(a), wide(b), wide(p));
    (bx - ax) * (py - ay) - (by - ay) * (px - ax)
}

fn edges<T: Copy>(outline: &[T]) -> impl Iterator<Item = (T, T)> {
    (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()]))
}

fn wide((x, y): Snapped) -> (i128, i128) {
    (x.into(), y.into())
}

/// The pixels that an outline covers, kept for the pixels of its bounding box inside the viewport.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mask {
    x: Range<u32>,
    y: Range<u32>,
    inside: Vec<bool>,
}

impl Mask {
    /// Whether the pixel is covered.
    pub(crate) fn contains(&self, x: u32, y: u32) -> bool {
        self.x.contains(&x) && self.y.contains(&y) && self.inside[self.index(x, y)]
    }

    /// The covered pixels as (x, y), row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> {
        let all = self.y.clone().flat_map(|y| self.x.clone().map(move |x| (x, y)));
        all.filter(|&(x, y)| self.inside[self.index(x, y)])
    }

    /// How many pixels are covered.
    pub(crate) fn count(&self) -> usize {
        self.inside.iter().filter(|&&inside| inside).count()
    }

    /// The viewport drawn with `#` and `.`, one line a row.
    pub(crate) fn picture(&self, window: Window) -> String {
        let row = |y| {
            (0..window.width)
                .map(|x| if self.contains(x, y) { '#' } else { '.' })
                .collect::<String>()
                + "\n"
        };
        (0..window.height).map(row).collect()
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y - self.y.start) as usize * self.x.len() + (x - self.x.start) as usize
    }
}

/// The pixels of the viewport whose centres are inside the outline.
pub(crate) fn fill(outline: &[Snapped], window: Window, rule: FillRule) -> Mask {
    let edges: Vec<_> = edges(outline).map(|(a, b)| (a, b, 1)).collect();
    fill_border(&edges, window, rule)
}

/// The pixels of the viewport whose centres are inside a border.
pub(crate) fn fill_border(border: &[Edge<Snapped>], window: Window, rule: FillRule) -> Mask {
    let points = || border.iter().flat_map(|edge| [edge.0, edge.1]);
    let x = centres_between(points().map(|p| p.0), window.width);
    let y = centres_between(points().map(|p| p.1), window.height);
    let covers = |x, y| is_inside(border.iter().map(|&edge| turn(edge, centre(x, y))).sum(), rule);
    let pixels = y.clone().flat_map(|y| x.clone().map(move |x| (x, y)));
    Mask { inside: pixels.map(|(x, y)| covers(x, y)).collect(), x, y }
}

/// The pixels, of `size` in a row, whose centres lie between the smallest and the largest
/// coordinate, both included.
fn centres_between(coordinates: impl Iterator<Item = i64> + Clone, size: u32) -> Range<u32> {
    let bounded = |pixel: i64| {
        u32::try_from(pixel.clamp(0, size.into())).expect("a pixel of the viewport, or its end")
    };
    let Some(least) = coordinates.clone().min() else { return 0..0 };
    let most = coordinates.max().unwrap_or(least);
    let first = Integer::div_ceil(&(least - STEPS / 2), &STEPS);
    let last = Integer::div_floor(&(most - STEPS / 2), &STEPS);
    bounded(first)..bounded(last + 1).max(bounded(first))
}

/// The pixels of the viewport that the polygon covers.
///
/// `guard` is how many pixels around the viewport a polygon may leave it before it is cut.
pub(crate) fn coverage(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
    rule: FillRule,
) -> Mask {
    fill(&outline(polygon, window, depth, guard), window, rule)
}

/// How many of the polygons cover each pixel, row by row.
pub(crate) fn coverage_counts<'a>(
    polygons: impl IntoIterator<Item = &'a [Position]>,
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<u32> {
    let mut counts = vec![0; window.width as usize * window.height as usize];
    for polygon in polygons {
        for (x, y) in coverage(polygon, window, depth, guard, FillRule::NonZero).pixels() {
            counts[y as usize * window.width as usize + x as usize] += 1;
        }
    }
    counts
}

// -------------------------------------------------------------------------------------- parameters

/// What the plane of a polygon holds where the ray through one point of the screen meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const N: usize, T = f64> {
    /// The weights of the three vertices. They sum to 1; outside the triangle one is negative.
    pub(crate) barycentric: [T; 3],
    /// w, interpolated as the parameters are. Not positive where the ray meets the plane behind the
    /// eye.
    pub(crate) w: T,
    /// z/w, before the viewport's depth range: see [`window_depth`].
    pub(crate) z_over_w: T,
    /// The parameters.
    pub(crate) values: [T; N],
    /// Their derivatives per pixel to the right.
    pub(crate) dx: [T; N],
    /// Their derivatives per pixel down.
    pub(crate) dy: [T; N],
}

impl<const N: usize> Sample<N> {
    /// Whether the point lies in the triangle of the three vertices, in front of the eye, borders
    /// included.
    pub(crate) fn is_inside(&self) -> bool {
        self.w > 0.0 && self.barycentric.iter().all(|&weight| weight >= 0.0)
    }
}

/// Three vertices that span the polygon's plane well: of nearly the largest triangle in (x, y, w).
/// All triangles of a plane have the same normal, so the largest suffers least from rounding.
/// `None` when the vertices lie on one line.
pub(crate) fn best_triple(polygon: &[Position]) -> Option<[usize; 3]> {
    let from =
        |i: usize, j: usize| [0, 1, 3].map(|k| f64::from(polygon[j][k]) - f64::from(polygon[i][k]));
    let length = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
    let farthest = |measure: &dyn Fn(usize) -> f64| {
        let most = (0..polygon.len()).max_by(|&i, &j| measure(i).total_cmp(&measure(j)));
        most.filter(|&i| measure(i) > 0.0)
    };
    let a = farthest(&|i| length(from(0, i)))?;
    let b = farthest(&|i| length(from(a, i)))?;
    let c = farthest(&|i| length(cross(&from(a, b), &from(a, i))))?;
    Some([a, b, c])
}

/// The polygon's plane, through the vertices `triple`, at a point of the screen in pixels (x right,
/// y down), in f64.
///
/// `None` when the plane runs through the eye, or when the ray runs along it or meets it at w = 0.
pub(crate) fn sample<const N: usize>(
    polygon: &[Position],
    parameters: &[[f32; N]],
    triple: [usize; 3],
    window: Window,
    point: [f64; 2],
) -> Option<Sample<N>> {
    let size = [window.width, window.height].map(f64::from);
    meet(
        triple.map(|i| polygon[i].map(f64::from)),
        triple.map(|i| parameters[i].map(f64::from)),
        point,
        size,
    )
}

/// The same in rational numbers, rounded to f64 at the very end: the last word.
pub(crate) fn sample_exact<const N: usize>(
    polygon: &[Position],
    parameters: &[[f32; N]],
    triple: [usize; 3],
    window: Window,
    point: [f64; 2],
) -> Option<Sample<N>> {
    let number = |value: f32| rational(f64::from(value));
    let (vertices, values) =
        (triple.map(|i| polygon[i].map(number)), triple.map(|i| parameters[i].map(number)));
    let size = [window.width, window.height].map(|size| rational(f64::from(size)));
    let met = meet(vertices, values, point.map(rational), size)?;
    Some(Sample {
        barycentric: met.barycentric.map(|c| nearest(&c)),
        w: nearest(&met.w),
        z_over_w: nearest(&met.z_over_w),
        values: met.values.map(|c| nearest(&c)),
        dx: met.dx.map(|c| nearest(&c)),
        dy: met.dy.map(|c| nearest(&c)),
    })
}

/// Meets the ray of the screen point with the plane of three vertices.
///
/// The ray is where x = X w and y = Y w, (X, Y) being the point in normalized device coordinates.
/// For every vertex u = x - X w and v = y - Y w say how far it is off the ray. The weights that
/// bring both to 0 at once are orthogonal to (u) and (v), so they are their cross product, up to
/// the scale that makes them sum to 1. Whatever is affine on the plane is the mean under these
/// weights. One pixel to the right X grows by 2/width, one pixel down Y shrinks by 2/height: the
/// derivatives follow by the product rule in the weights and the quotient rule in the mean.
fn meet<T: Num + Clone + Neg<Output = T>, const N: usize>(
    vertices: [[T; 4]; 3],
    parameters: [[T; N]; 3],
    point: [T; 2],
    size: [T; 2],
) -> Option<Sample<N, T>> {
    let [x, y, z, w]: [[T; 3]; 4] = from_fn(|k| from_fn(|i| vertices[i][k].clone()));
    let two = || T::one() + T::one();
    let [pixel_x, pixel_y] = size.map(|size| two() / size);
    let [point_x, point_y] = point;
    let (ray_x, ray_y) =
        (pixel_x.clone() * point_x - T::one(), T::one() - pixel_y.clone() * point_y);

    let u = from_fn(|i| x[i].clone() - ray_x.clone() * w[i].clone());
    let v = from_fn(|i| y[i].clone() - ray_y.clone() * w[i].clone());
    let weights = cross(&u, &v);
    let weights_dx = cross(&w.clone().map(|w| -(pixel_x.clone() * w)), &v);
    let weights_dy = cross(&u, &w.clone().map(|w| pixel_y.clone() * w));

    let total = sum(&weights);
    let w_total = mix(&weights, &w);
    if total.is_zero() || w_total.is_zero() {
        return None;
    }
    let per_parameter: [[T; 3]; N] = from_fn(|n| from_fn(|i| parameters[i][n].clone()));
    let values: [T; N] = from_fn(|n| mix(&weights, &per_parameter[n]) / total.clone());
    let derivative = |change: &[T; 3]| {
        from_fn(|n| {
            (mix(change, &per_parameter[n]) - values[n].clone() * sum(change)) / total.clone()
        })
    };
    Some(Sample {
        dx: derivative(&weights_dx),
        dy: derivative(&weights_dy),
        w: w_total.clone() / total.clone(),
        z_over_w: mix(&weights, &z) / w_total,
        barycentric: weights.map(|weight| weight / total.clone()),
        values,
    })
}

fn cross<T: Num + Clone>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].clone() * b[k].clone() - a[k].clone() * b[j].clone()
    })
}

fn mix<T: Num + Clone>(weights: &[T; 3], values: &[T; 3]) -> T {
    sum(&from_fn(|i| weights[i].clone() * values[i].clone()))
}

fn sum<T: Num + Clone>(terms: &[T; 3]) -> T {
    terms[0].clone() + terms[1].clone() + terms[2].clone()
}

/// Depth in the framebuffer: z/w brought to 0..1 by the depth convention, then to the viewport's
/// depth range.
pub(crate) fn window_depth(z_over_w: f64, depth: Depth, range: [f32; 2]) -> f64 {
    let [near, far] = range.map(f64::from);
    let unit = match depth {
        Depth::ZeroToOne => z_over_w,
        Depth::MinusOneToOne => (z_over_w + 1.0) / 2.0,
    };
    near + unit * (far - near)
}

// --------------------------------------------------------------------------------------- distances

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
