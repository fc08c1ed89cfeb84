//! Polygons and meshes to test with, from a seeded generator: a seed names the same shapes in every
//! run. (Between platforms the last bits of a place may differ, as their sines and logarithms do.)
//!
//! Vertices are given in clip space. Where a shape is meant for a place on the screen, its places
//! are pixels of a window, y down, as in the oracle. Unless said otherwise w is at least about 1
//! and z = w/2 - 1/4, so that nothing is cut by the near or the far plane of either depth
//! convention.

use std::array::from_fn;
use std::f64::consts::TAU;

use num_integer::Integer;

use super::oracle::{Position, Window};

/// Random numbers: splitmix64, whose whole state is one word.
#[derive(Clone, Debug)]
pub(crate) struct Rng(u64);

impl Rng {
    /// The generator that a seed names.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub(crate) fn bits(&mut self) -> u64 {
        // The constants are those of Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
        // Generators" (2014).
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number of `low..high`.
    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits fill the fraction of an f64.
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    }

    /// A number of `low..high`, every octave equally often.
    pub(crate) fn octaves(&mut self, low: f64, high: f64) -> f64 {
        self.range(low.ln(), high.ln()).exp()
    }

    /// A whole number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        // The bias of the remainder is end / 2^64: nothing a test could see.
        (self.bits() % end as u64) as usize
    }

    /// A whole number from `low` to `high`, both included.
    pub(crate) fn whole(&mut self, low: i64, high: i64) -> i64 {
        low + self.below((high - low + 1) as usize) as i64
    }

    /// True once in `times`.
    pub(crate) fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// Puts the items in random order.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A polygon with N parameters at each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Shape<const N: usize> {
    pub(crate) positions: Vec<Position>,
    pub(crate) parameters: Vec<[f32; N]>,
}

/// Faces that share vertices.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Position>,
    /// For each face its vertices, in either direction, beginning anywhere.
    pub(crate) faces: Vec<Vec<usize>>,
}

impl Mesh {
    /// The faces as polygons.
    pub(crate) fn polygons(&self) -> Vec<Vec<Position>> {
        self.faces.iter().map(|face| face.iter().map(|&i| self.positions[i]).collect()).collect()
    }
}

/// What the cells of a grid become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cells {
    /// Two triangles, along either diagonal.
    Triangles,
    /// One quad.
    Quads,
    /// Now one, now the other.
    Mixed,
}

// ------------------------------------------------------------------------------------------ places

/// The vertex that appears at a place of the screen, with a w of at least about 1.
pub(crate) fn at_pixel(place: [f64; 2], w: f64, window: Window) -> Position {
    let x = 2.0 * place[0] / f64::from(window.width) - 1.0;
    let y = 1.0 - 2.0 * place[1] / f64::from(window.height);
    at_ndc([x, y], w)
}

fn at_ndc(place: [f64; 2], w: f64) -> Position {
    // Rounding w first lets x/w and y/w err by their own rounding only.
    let w = f64::from(w as f32);
    [(place[0] * w) as f32, (place[1] * w) as f32, (w / 2.0 - 0.25) as f32, w as f32]
}

fn at_pixels(rng: &mut Rng, places: &[[f64; 2]], w_ratio: f64, window: Window) -> Vec<Position> {
    places.iter().map(|&place| at_pixel(place, rng.octaves(1.0, w_ratio), window)).collect()
}

fn size(window: Window) -> [f64; 2] {
    [window.width, window.height].map(f64::from)
}

fn somewhere(rng: &mut Rng, window: Window) -> [f64; 2] {
    size(window).map(|size| rng.range(0.0, size))
}

fn on_circle(centre: [f64; 2], radius: f64, angle: f64) -> [f64; 2] {
    [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
}

/// Half the diagonal of the viewport: a circle of this radius around its middle holds it.
fn half_diagonal(window: Window) -> f64 {
    let [width, height] = size(window);
    width.hypot(height) / 2.0
}

fn middle(window: Window) -> [f64; 2] {
    size(window).map(|size| size / 2.0)
}

// --------------------------------------------------------------------------------- planar polygons

/// A triangle with w from exactly 1 to exactly `w_ratio` and vertices within `reach` of the middle
/// of the screen, in normalized device coordinates (1 is the viewport's border). Parameters are of
/// -1..1.
pub(crate) fn random_triangle<const N: usize>(rng: &mut Rng, w_ratio: f64, reach: f64) -> Shape<N> {
    let mut w = [1.0, w_ratio, rng.octaves(1.0, w_ratio)];
    rng.shuffle(&mut w);
    let positions = w.map(|w| at_ndc(from_fn(|_| rng.range(-reach, reach)), w)).to_vec();
    let parameters = (0..3).map(|_| from_fn(|_| rng.range(-1.0, 1.0) as f32)).collect();
    Shape { positions, parameters }
}

/// A convex polygon of 3 to 64 sides (above 12 an even number) in a plane of random tilt, with w from about 1 to about
/// `w_ratio` (at most 1000) and vertices within 4 of the middle of the screen, in normalized device
/// coordinates.
///
/// Exactly planar, with exactly affine parameters, in f32: see [`Frame`].
pub(crate) fn random_convex<const N: usize>(rng: &mut Rng, sides: usize, w_ratio: f64) -> Shape<N> {
    loop {
        let disc = round_polygon(rng, sides);
        let frame = tilted_frame(rng, &disc, 1.0, w_ratio);
        let on_screen = |p: &Position| p[0].abs() <= 4.0 * p[3] && p[1].abs() <= 4.0 * p[3];
        let shape = frame.shape(rng, &disc).filter(|shape| shape.positions.iter().all(on_screen));
        if let Some(shape) = shape {
            return shape;
        }
    }
}

/// A convex polygon through the plane w = 0: some vertices have w > 0, the others w < 0 or
/// sometimes w = 0. Exactly planar with affine parameters. In one of two z = w/2, so that the near
/// plane is w = 0 itself.
pub(crate) fn through_eye<const N: usize>(rng: &mut Rng, sides: usize) -> Shape<N> {
    loop {
        let disc = round_polygon(rng, sides);
        let behind = if rng.once_in(3) { 0.0 } else { -rng.octaves(0.1, 8.0) };
        let ahead = rng.octaves(0.5, 8.0);
        let mut frame = tilted_frame(rng, &disc, behind, ahead);
        if rng.once_in(2) {
            frame.near = 0.0;
        }
        let both_sides = |shape: &Shape<N>| {
            let is_ahead = |p: &Position| p[3] > 0.0;
            shape.positions.iter().any(is_ahead) && !shape.positions.iter().all(is_ahead)
        };
        if let Some(shape) = frame.shape(rng, &disc).filter(both_sides) {
            return shape;
        }
    }
}

/// A convex polygon seen nearly from the side: its plane passes by the eye, and it is about twice
/// `tilt` thick on the screen, in normalized device coordinates. Exactly planar with affine
/// parameters, so a tilt below 1/16384 becomes 0, and the plane then runs through the eye.
pub(crate) fn edge_on<const N: usize>(rng: &mut Rng, sides: usize, tilt: f64) -> Shape<N> {
    let disc = round_polygon(rng, sides);
    let scale = 256.0;
    let angle = rng.range(0.0, TAU);
    let even = |c: f64| (c * 32.0).round() / 32.0;
    // Half of the origin has to be as exact as the origin, or the rounding would tilt the plane.
    let origin = [even(scale * rng.range(-0.6, 0.6)), even(scale * rng.range(-0.6, 0.6)), scale];
    let along =
        [scale * 0.4 * angle.cos(), scale * 0.4 * angle.sin(), scale * rng.range(-0.3, 0.3)];
    let aside = [-angle.sin(), angle.cos(), 0.0].map(|c| c * tilt * scale);
    let frame =
        Frame { origin, along, across: from_fn(|k| origin[k] / 2.0 + aside[k]), scale, near: 0.5 };
    frame.shape(rng, &disc).expect("coordinates of at most 512")
}

/// A plane in clip space: the point (s, t) of the unit disc lies at (x, y, w) = origin + s along +
/// t across.
///
/// s, t, `along` and `across` are rounded to multiples of 1/64 and `origin` to multiples of 1/4096,
/// so positions are multiples of 2^-12. Below 2^12 these fit the 24 bits of an f32 exactly, and the
/// polygon is planar to the bit. Dividing by `scale`, a power of two, costs no bits. z = (w - near
/// scale) / 2 has its last bit one place further down, but w is at most 2^10.
#[derive(Clone, Debug)]
struct Frame {
    origin: [f64; 3],
    along: [f64; 3],
    across: [f64; 3],
    scale: f64,
    near: f64,
}

impl Frame {
    /// The polygon over the disc's, with random parameters affine in s and t. `None` when it
    /// exceeds the bits.
    fn shape<const N: usize>(&self, rng: &mut Rng, disc: &[[f64; 2]]) -> Option<Shape<N>> {
        let origin = self.origin.map(to_4096ths);
        let [along, across] = [self.along, self.across].map(|v| v.map(to_64ths));
        // Eight bits each, times the seven of s and t: exact as well.
        let planes: [[f64; 3]; N] = from_fn(|_| from_fn(|_| rng.whole(-128, 127) as f64 / 256.0));
        let position = |[s, t]: [f64; 2]| {
            let [x, y, w] = from_fn(|k| origin[k] + s * along[k] + t * across[k]);
            [x, y, (w - self.near * self.scale) / 2.0, w].map(|c| c / self.scale)
        };
        let fits = |c: f64| f64::from(c as f32) == c;
        let positions: Vec<[f64; 4]> = disc.iter().map(|&p| position(p)).collect();
        positions.iter().flatten().all(|&c| fits(c)).then(|| Shape {
            positions: positions.iter().map(|p| p.map(|c| c as f32)).collect(),
            parameters: disc
                .iter()
                .map(|[s, t]| planes.map(|[r, ds, dt]| (r + s * ds + t * dt) as f32))
                .collect(),
        })
    }
}

/// A frame in which w runs over the disc's polygon from `least` to `most`, times a power of two
/// that fills the bits, and three of the vertices appear at random places of the screen when their
/// w is positive.
fn tilted_frame(rng: &mut Rng, disc: &[[f64; 2]], least: f64, most: f64) -> Frame {
    let scale = (1024.0 / most.max(-least)).log2().floor().exp2();
    let direction = on_circle([0.0; 2], 1.0, rng.range(0.0, TAU));
    let height = |p: [f64; 2]| p[0] * direction[0] + p[1] * direction[1];
    let by_height = |i: &usize, j: &usize| height(disc[*i]).total_cmp(&height(disc[*j]));
    let low = (0..disc.len()).min_by(by_height).unwrap_or(0);
    let high = (0..disc.len()).max_by(by_height).unwrap_or(0);
    let area = |i: usize| doubled_area(disc[low], disc[high], disc[i]);
    let aside =
        (0..disc.len()).max_by(|&i, &j| area(i).abs().total_cmp(&area(j).abs())).unwrap_or(0);

    let slope = scale * (most - least) / (height(disc[high]) - height(disc[low]));
    let w_at = |i: usize| scale * least + slope * (height(disc[i]) - height(disc[low]));
    let triple = [low, high, aside];
    // Without a screen place to go by (w <= 0) the place is measured at w = 1.
    let reach = triple.map(|i| if w_at(i) > 0.0 { w_at(i) } else { scale });
    let places = [disc[low], disc[high], disc[aside]];
    let x = affine(places, reach.map(|w| w * rng.range(-1.0, 1.0)));
    let y = affine(places, reach.map(|w| w * rng.range(-1.0, 1.0)));
    let w = affine(places, triple.map(w_at));
    let [origin, along, across] = from_fn(|k| [x[k], y[k], w[k]]);
    Frame { origin, along, across, scale, near: 0.5 }
}

/// The coefficients [c, ds, dt] of the function c + s ds + t dt with the given values at three
/// points, rounded as [`Frame`] wants them: exactly the first value, if that is a multiple of
/// 1/4096, and nearly the others.
fn affine(points: [[f64; 2]; 3], values: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = points;
    let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let (to_b, to_c) = (values[1] - values[0], values[2] - values[0]);
    let area = doubled_area(a, b, c);
    let ds = to_64ths((to_b * ac[1] - to_c * ab[1]) / area);
    let dt = to_64ths((to_c * ab[0] - to_b * ac[0]) / area);
    [to_4096ths(values[0] - a[0] * ds - a[1] * dt), ds, dt]
}

fn doubled_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// A strictly convex polygon of 3 to 12 vertices near the unit circle, or of an even number up to
/// 64 inside it, at multiples of 1/64, in either direction.
fn round_polygon(rng: &mut Rng, sides: usize) -> Vec<[f64; 2]> {
    if sides > 12 {
        return zonogon(rng, sides);
    }
    // Angles are off by a quarter of the regular gap at most, so two sides differ by half a gap: 15
    // degrees of 12 sides stand 0.03 above the chord, twice what rounding can take.
    assert!((3..=12).contains(&sides), "with more sides rounding to 1/64 would dent the polygon");
    let gap = TAU / sides as f64;
    let turn = rng.range(0.0, gap);
    let angle = |rng: &mut Rng, i: usize| turn + gap * (i as f64 + rng.range(-0.25, 0.25));
    let mut disc: Vec<[f64; 2]> =
        (0..sides).map(|i| on_circle([0.0; 2], 1.0, angle(rng, i)).map(to_64ths)).collect();
    if rng.once_in(2) {
        disc.reverse();
    }
    disc
}

/// A strictly convex polygon of an even number of sides up to 64, with vertices at multiples of
/// 1/64 inside the unit circle: the sum of half as many segments, no two of which are parallel.
fn zonogon(rng: &mut Rng, sides: usize) -> Vec<[f64; 2]> {
    // One of each pair of opposite directions: 40 of them.
    let directions = (-5..=5).flat_map(|x: i64| (0..=5).map(move |y: i64| (x, y)));
    let is_primitive = |&(x, y): &(i64, i64)| x.gcd(&y) == 1 && (y > 0 || x > 0);
    let mut segments: Vec<_> = directions.filter(is_primitive).collect();
    assert!(sides.is_multiple_of(2) && sides <= 2 * segments.len(), "{sides} sides");
    rng.shuffle(&mut segments);
    segments.truncate(sides / 2);
    segments.sort_by(|a, b| (b.0 * a.1).cmp(&(a.0 * b.1)));
    let opposite: Vec<_> = segments.iter().map(|&(x, y)| (-x, -y)).collect();
    // Begin so that the middle is at the origin, up to half a unit.
    let sum = segments.iter().fold((0, 0), |sum, s| (sum.0 + s.0, sum.1 + s.1));
    let mut at = (-sum.0 / 2, -sum.1 / 2);
    let mut polygon = Vec::new();
    for (x, y) in segments.into_iter().chain(opposite) {
        polygon.push([at.0 as f64 / 64.0, at.1 as f64 / 64.0]);
        at = (at.0 + x, at.1 + y);
    }
    if rng.once_in(2) {
        polygon.reverse();
    }
    polygon
}

fn to_4096ths(value: f64) -> f64 {
    (value * 4096.0).round() / 4096.0
}

fn to_64ths(value: f64) -> f64 {
    (value * 64.0).round() / 64.0
}

// ------------------------------------------------------------------------------ difficult polygons

/// A triangle along a random line of the viewport, `thickness` pixels wide, with w of 1..`w_ratio`.
pub(crate) fn sliver(rng: &mut Rng, window: Window, thickness: f64, w_ratio: f64) -> Vec<Position> {
    let (a, b) = (somewhere(rng, window), somewhere(rng, window));
    let t = rng.range(0.0, 1.0);
    let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1.0);
    let off = [-(b[1] - a[1]), b[0] - a[0]].map(|c| c * thickness / length);
    let c = from_fn(|k| a[k] + t * (b[k] - a[k]) + off[k]);
    at_pixels(rng, &[a, b, c], w_ratio, window)
}

/// A convex polygon of 3 to `most` vertices, each exactly on a pixel centre once rounded to 1/256
/// pixel, with w a power of two.
pub(crate) fn on_pixel_centres(rng: &mut Rng, window: Window, most: usize) -> Vec<Position> {
    loop {
        let mut pixel = |size: u32| rng.whole(0, i64::from(size) - 1);
        let mut points: Vec<_> =
            (0..most).map(|_| [pixel(window.width), pixel(window.height)]).collect();
        let mut hull = convex_hull(&mut points);
        if hull.len() < 3 {
            continue;
        }
        if rng.once_in(2) {
            hull.reverse();
        }
        let vertex = |p: [i64; 2]| {
            at_pixel(p.map(|c| c as f64 + 0.5), (rng.whole(0, 8) as f64).exp2(), window)
        };
        return hull.into_iter().map(vertex).collect();
    }
}

/// A triangle with vertices a quarter of `pixels` to `pixels` away and one edge through the viewport.
pub(crate) fn far_outside(
    rng: &mut Rng,
    window: Window,
    pixels: f64,
    w_ratio: f64,
) -> Vec<Position> {
    let (through, angle) = (somewhere(rng, window), rng.range(0.0, TAU));
    let mut leg = |turn: f64| on_circle(through, rng.range(pixels / 4.0, pixels), angle + turn);
    let places = [leg(0.0), leg(TAU / 2.0), leg(TAU / 4.0)];
    at_pixels(rng, &places, w_ratio, window)
}

/// A convex polygon around the whole viewport, `pixels` further out than it needs to be, with w of
/// 1..`w_ratio`: each vertex has its own, so from four sides on it has no plane and serves coverage
/// only.
pub(crate) fn surrounding(
    rng: &mut Rng,
    window: Window,
    sides: usize,
    pixels: f64,
    w_ratio: f64,
) -> Vec<Position> {
    let places = ring(rng, window, sides, pixels);
    at_pixels(rng, &places, w_ratio, window)
}

/// A regular polygon around the viewport, in screen places.
fn ring(rng: &mut Rng, window: Window, sides: usize, pixels: f64) -> Vec<[f64; 2]> {
    let gap = TAU / sides as f64;
    let turn = rng.range(0.0, gap);
    // The middles of the sides are cos(gap / 2) times as far out as the corners.
    let radius = half_diagonal(window) / (gap / 2.0).cos() + pixels + 1.0;
    (0..sides).map(|i| on_circle(middle(window), radius, turn + gap * i as f64)).collect()
}

/// A triangle with all coordinates whole and of -3..=3: equal vertices, edges through the eye,
/// planes touched exactly.
pub(crate) fn integer_triangle(rng: &mut Rng) -> Vec<Position> {
    (0..3).map(|_| from_fn(|_| rng.whole(-3, 3) as f32)).collect()
}

// ---------------------------------------------------------------------------------------- outlines

/// A star of `points` points inside the viewport: concave, its edges do not cross. Its w is of 1..4
/// at random, so it has no plane: for coverage only.
pub(crate) fn star(rng: &mut Rng, window: Window, points: usize) -> Vec<Position> {
    let radius = size(window)[0].min(size(window)[1]) * rng.range(0.3, 0.49);
    let inner = radius * rng.range(0.2, 0.6);
    let (gap, turn) = (TAU / (2 * points) as f64, rng.range(0.0, TAU));
    let corner = |i: usize| {
        on_circle(
            middle(window),
            if i.is_multiple_of(2) { radius } else { inner },
            turn + gap * i as f64,
        )
    };
    at_pixels(rng, &(0..2 * points).map(corner).collect::<Vec<_>>(), 4.0, window)
}

/// A star drawn in one stroke, joining every `step`-th of `points` places on a circle: its edges
/// cross, and it winds `step` times around its middle. For coverage only.
pub(crate) fn crossed_star(
    rng: &mut Rng,
    window: Window,
    points: usize,
    step: usize,
) -> Vec<Position> {
    let radius = size(window)[0].min(size(window)[1]) * rng.range(0.3, 0.49);
    let turn = rng.range(0.0, TAU);
    let corner = |i: usize| {
        on_circle(middle(window), radius, turn + TAU * (i * step) as f64 / points as f64)
    };
    at_pixels(rng, &(0..points).map(corner).collect::<Vec<_>>(), 4.0, window)
}

/// `vertices` places on the grid of half pixels joined in random order: crossings, overlaps, edges
/// through pixel centres. For coverage only.
pub(crate) fn tangle(rng: &mut Rng, window: Window, vertices: usize) -> Vec<Position> {
    let mut halves = |size: u32| rng.whole(0, 2 * i64::from(size)) as f64 / 2.0;
    let places: Vec<_> =
        (0..vertices).map(|_| [halves(window.width), halves(window.height)]).collect();
    at_pixels(rng, &places, 4.0, window)
}

/// The contours of one polygon that lie in one plane, exactly, with exactly affine parameters.
#[derive(Clone, Debug)]
pub(crate) struct Contours<const N: usize> {
    /// The vertices in coordinates of the plane.
    pub(crate) places: Vec<Vec<[f64; 2]>>,
    pub(crate) positions: Vec<Vec<Position>>,
    pub(crate) parameters: Vec<Vec<[f32; N]>>,
}

/// Contours given by places in the unit circle, on a plane of random tilt: see [`Frame`]. w runs
/// from about `least`, which may be negative, to about `most`.
pub(crate) fn tilted<const N: usize>(
    rng: &mut Rng,
    contours: &[Vec<[f64; 2]>],
    least: f64,
    most: f64,
) -> Contours<N> {
    let places: Vec<Vec<_>> =
        contours.iter().map(|contour| contour.iter().map(|p| p.map(to_64ths)).collect()).collect();
    let all = places.concat();
    loop {
        let frame = tilted_frame(rng, &all, least, most);
        let Some(shape) = frame.shape(rng, &all) else { continue };
        let (mut positions, mut parameters) = (&shape.positions[..], &shape.parameters[..]);
        return Contours {
            positions: places.iter().map(|contour| take(&mut positions, contour.len())).collect(),
            parameters: places.iter().map(|contour| take(&mut parameters, contour.len())).collect(),
            places,
        };
    }
}

/// Cuts the first items off a list.
fn take<T: Clone>(list: &mut &[T], count: usize) -> Vec<T> {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first.to_vec()
}

/// A polygon of any shape in the unit circle: a star, a ring, a comb, a spiral, a letter, a tangle,
/// several of each.
pub(crate) fn any_contours(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    let mut contours = match rng.below(8) {
        0 => vec![flat_star(rng)],
        1 => {
            let (points, step) = (5 + 2 * rng.below(4), 2 + rng.below(2));
            let corner =
                |i: usize| on_circle([0.0; 2], 0.9, TAU * (i * step) as f64 / points as f64);
            vec![(0..points).map(corner).collect()]
        }
        2 => ring_contours(rng),
        3 => vec![comb(rng)],
        4 => vec![spiral(rng)],
        5 => letter(rng),
        6 => vec![loose(rng, 24)],
        _ => (0..2 + rng.below(3)).map(|_| loose(rng, 6)).collect(),
    };
    if rng.once_in(4) {
        contours.push(loose(rng, 5));
    }
    let (turn, size) = (rng.range(0.0, TAU), rng.range(0.5, 1.0));
    let (sin, cos) = turn.sin_cos();
    for [s, t] in contours.iter_mut().flatten() {
        (*s, *t) = (size * (*s * cos - *t * sin), size * (*s * sin + *t * cos));
    }
    contours
}

/// Random places joined in random order.
fn loose(rng: &mut Rng, most: usize) -> Vec<[f64; 2]> {
    let place = |rng: &mut Rng| [rng.range(-0.7, 0.7), rng.range(-0.7, 0.7)];
    (0..3 + rng.below(most - 2)).map(|_| place(rng)).collect()
}

fn flat_star(rng: &mut Rng) -> Vec<[f64; 2]> {
    let (points, inner) = (4 + rng.below(9), rng.range(0.2, 0.6));
    let corner = |i: usize| {
        let radius = if i.is_multiple_of(2) { 0.9 } else { inner };
        on_circle([0.0; 2], radius, TAU / (2 * points) as f64 * i as f64)
    };
    (0..2 * points).map(corner).collect()
}

/// A round contour with a hole and sometimes an island in it, the hole in either direction.
fn ring_contours(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    let circle = |rng: &mut Rng, radius: f64| {
        let sides = 3 + rng.below(10);
        let mut circle: Vec<_> = (0..sides)
            .map(|i| on_circle([0.0; 2], radius, TAU * i as f64 / sides as f64))
            .collect();
        if rng.once_in(2) {
            circle.reverse();
        }
        circle
    };
    let radii = [0.95, 0.45, 0.2];
    radii[..2 + rng.below(2)].iter().map(|&radius| circle(rng, radius)).collect()
}

/// A back with teeth: a line across them meets each twice.
pub(crate) fn comb(rng: &mut Rng) -> Vec<[f64; 2]> {
    let teeth = 3 + rng.below(12);
    let pitch = 1.2 / teeth as f64;
    let mut comb = vec![[0.6, -0.6], [-0.6, -0.6]];
    for i in 0..teeth {
        let s = -0.6 + pitch * i as f64;
        let tip = 0.6 + rng.range(-0.2, 0.1);
        comb.extend([[s, tip], [s + pitch * 0.5, tip], [s + pitch * 0.5, -0.3], [s + pitch, -0.3]]);
    }
    comb.pop();
    comb
}

/// A band wound up several times.
fn spiral(rng: &mut Rng) -> Vec<[f64; 2]> {
    let (turns, steps) = (2 + rng.below(3), 9);
    let pitch = 0.8 / turns as f64;
    let all = turns * steps;
    let at = |i: usize, inwards: f64| {
        let radius = 0.95 - pitch * i as f64 / steps as f64 - inwards;
        on_circle([0.0; 2], radius.max(0.0), TAU * i as f64 / steps as f64)
    };
    let outer = (0..=all).map(|i| at(i, 0.0));
    outer.chain((0..=all).rev().map(|i| at(i, 0.5 * pitch))).collect()
}

/// A, B and E, in units of 1/8.
fn letter(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    type Contour = &'static [[i8; 2]];
    const A: [Contour; 2] = [
        &[[-5, -6], [-2, -6], [-1, -3], [1, -3], [2, -6], [5, -6], [1, 6], [-1, 6]],
        &[[-1, -1], [0, 3], [1, -1]],
    ];
    const B: [Contour; 3] = [
        &[[-4, -6], [3, -6], [5, -4], [5, -2], [3, 0], [5, 2], [5, 4], [3, 6], [-4, 6]],
        &[[-2, -4], [-2, -1], [2, -1], [3, -3], [2, -4]],
        &[[-2, 1], [-2, 4], [2, 4], [3, 3], [2, 1]],
    ];
    const E: [Contour; 1] = [&[
        [-4, -6],
        [4, -6],
        [4, -4],
        [-2, -4],
        [-2, -1],
        [2, -1],
        [2, 1],
        [-2, 1],
        [-2, 4],
        [4, 4],
        [4, 6],
        [-4, 6],
    ]];
    let letter: &[Contour] = [&A[..], &B, &E][rng.below(3)];
    let place = |p: &[i8; 2]| p.map(|c| f64::from(c) / 8.0);
    letter.iter().map(|contour| contour.iter().map(place).collect()).collect()
}

/// The corners of the convex hull, by Andrew's monotone chain. Fewer than three when all points lie
/// on one line.
fn convex_hull(points: &mut Vec<[i64; 2]>) -> Vec<[i64; 2]> {
    points.sort_unstable();
    points.dedup();
    let mut hull = half_hull(points.iter());
    hull.extend(half_hull(points.iter().rev()));
    hull
}

/// One side of the hull, without its last point, which begins the other side.
fn half_hull<'a>(points: impl Iterator<Item = &'a [i64; 2]>) -> Vec<[i64; 2]> {
    let mut chain: Vec<[i64; 2]> = Vec::new();
    for &p in points {
        let turns = |a: [i64; 2], b: [i64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0
        };
        while chain.len() >= 2 && !turns(chain[chain.len() - 2], chain[chain.len() - 1]) {
            chain.pop();
        }
        chain.push(p);
    }
    chain.pop();
    chain
}

// ------------------------------------------------------------------------------------------ meshes

/// A grid of cells over the viewport and `margin` pixels around, so that each pixel is covered
/// once. Inner vertices are moved by up to a fifth of a cell, which leaves all cells convex; in
/// cells of more than 16 pixels one in four sits on a pixel centre. w is of 1..`w_ratio`, for each
/// vertex its own: quads have no plane and serve coverage only.
pub(crate) fn jittered_grid(
    rng: &mut Rng,
    window: Window,
    [columns, rows]: [usize; 2],
    cells: Cells,
    w_ratio: f64,
    margin: f64,
) -> Mesh {
    let [width, height] = size(window).map(|size| size + 2.0 * margin);
    let cell = [width / columns as f64, height / rows as f64];
    let mut positions = Vec::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let mut place = [column as f64 * cell[0] - margin, row as f64 * cell[1] - margin];
        let mut w = rng.octaves(1.0, w_ratio);
        if (1..columns).contains(&column) && (1..rows).contains(&row) {
            place = from_fn(|k| place[k] + cell[k] * rng.range(-0.2, 0.2));
            if cell[0].min(cell[1]) > 16.0 && rng.once_in(4) {
                place = place.map(|c| c.floor() + 0.5);
                w = w.log2().floor().exp2();
            }
        }
        positions.push(at_pixel(place, w, window));
    }
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// The same, but z of each vertex is of -0.3 w..1.3 w: the near and the far plane cut many cells,
/// and a pixel is covered at most once.
pub(crate) fn cut_grid(
    rng: &mut Rng,
    window: Window,
    counts: [usize; 2],
    cells: Cells,
    w_ratio: f64,
) -> Mesh {
    let mut mesh = jittered_grid(rng, window, counts, cells, w_ratio, 8.0);
    for p in &mut mesh.positions {
        p[2] = p[3] * rng.range(-0.3, 1.3) as f32;
    }
    mesh
}

/// A level floor seen in perspective, from behind the eye (w = -2) to far away (w = `far`), 4 wide
/// to either side and 1 below the eye. z = w - 1/4, so that the near plane is at w = 1/4 when depth
/// begins at 0. A pixel is covered at most once.
pub(crate) fn floor(rng: &mut Rng, [columns, rows]: [usize; 2], cells: Cells, far: f64) -> Mesh {
    let cell = [8.0 / columns as f64, (far + 2.0) / rows as f64];
    let mut positions = Vec::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let jitter = if rng.once_in(2) { 0.0 } else { 0.2 };
        let [x, w] = [(column, -4.0, cell[0]), (row, -2.0, cell[1])]
            .map(|(i, start, cell)| start + cell * (i as f64 + rng.range(-jitter, jitter)));
        let w = w as f32;
        positions.push([x as f32, -1.0, w - 0.25, w]);
    }
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// A planar grid: the vertex of row j and column i is origin + i along + j across, all in clip space
/// and whole. It may pass the eye, be seen edge-on, or be no more than a line.
pub(crate) fn whole_grid(
    rng: &mut Rng,
    [origin, along, across]: [[i64; 4]; 3],
    [columns, rows]: [usize; 2],
    cells: Cells,
) -> Mesh {
    let places = (0..=rows as i64).flat_map(|j| (0..=columns as i64).map(move |i| (i, j)));
    let position = |(i, j)| from_fn(|k| (origin[k] + i * along[k] + j * across[k]) as f32);
    let positions = places.map(position).collect();
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// A convex quad of any size up to the window's, somewhere around it, with a w of its own at each
/// vertex, up to 30 or all 1. In one of three each z is of -0.3 w..1.3 w, so that the near or the far
/// plane may cut the quad.
pub(crate) fn split_quad(rng: &mut Rng, window: Window) -> [Position; 4] {
    let w_ratio = if rng.once_in(3) { 1.0 } else { 30.0 };
    let (centre, turn) = (somewhere(rng, window), rng.range(0.0, TAU));
    let radius = rng.octaves(0.5, half_diagonal(window));
    let is_cut = rng.once_in(3);
    // Corners a quarter turn apart, an eighth off at most: of the same radius, they are convex.
    from_fn(|i| {
        let angle = turn + TAU / 4.0 * (i as f64 + rng.range(-0.5, 0.5));
        let place = on_circle(centre, radius, angle);
        let mut p = at_pixel(place, rng.octaves(1.0, w_ratio), window);
        if is_cut {
            p[2] = p[3] * rng.range(-0.3, 1.3) as f32;
        }
        p
    })
}

/// Triangles around a vertex on the pixel centre in the middle, to a ring outside the viewport.
/// Each pixel is covered once. Ring vertices are on pixel centres too, so that spokes meet many.
pub(crate) fn fan(rng: &mut Rng, window: Window, spokes: usize, w_ratio: f64) -> Mesh {
    let mut places = ring(rng, window, spokes, 2.0);
    places.push(middle(window));
    // Powers of two keep the places exact where the window's sides are powers of two.
    let w = |rng: &mut Rng| rng.octaves(1.0, w_ratio).log2().floor().exp2();
    let positions = places
        .iter()
        .map(|place| at_pixel(place.map(|c| c.floor() + 0.5), w(rng), window))
        .collect();
    let mut faces: Vec<_> = (0..spokes).map(|i| vec![spokes, i, (i + 1) % spokes]).collect();
    disguise(rng, &mut faces);
    Mesh { positions, faces }
}

/// The faces of a grid of (columns + 1) (rows + 1) vertices, row by row.
fn grid_faces(rng: &mut Rng, columns: usize, rows: usize, cells: Cells) -> Vec<Vec<usize>> {
    let mut faces = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let a = row * (columns + 1) + column;
        let quad = [a, a + 1, a + columns + 2, a + columns + 1];
        let whole = cells == Cells::Quads || (cells == Cells::Mixed && rng.once_in(2));
        let first = rng.below(2);
        if whole {
            faces.push(quad.to_vec());
        } else {
            faces.extend([0, 2].map(|k| [0, 1, 2].map(|i| quad[(first + k + i) % 4]).to_vec()));
        }
    }
    disguise(rng, &mut faces);
    faces
}

/// Puts the faces in random order, each in a random direction, beginning anywhere.
fn disguise(rng: &mut Rng, faces: &mut [Vec<usize>]) {
    for face in faces.iter_mut() {
        let start = rng.below(face.len());
        face.rotate_left(start);
        if rng.once_in(2) {
            face.reverse();
        }
    }
    rng.shuffle(faces);
}
