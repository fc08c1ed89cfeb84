//! Contract 4: parameters are exact to f32, and so are their derivatives.

use std::fmt;
use std::ops::{Add, Range};

use crate::common::generators::{self, Rng, Shape};
use crate::common::oracle::{self, Depth, Window};
use crate::common::{LONG_SEED, in_threads, vertices, viewport};
use glam::{Mat3, Vec3, vec3, vec4};
use polyscan::{
    ClipPlane, Fragment, Interpolation, ParameterMatrix, ScanConverter, Vertex, Viewport,
};

const WINDOW: Window = Window { width: 97, height: 61 };

/// The promise: a part of the polygon's largest parameter.
const PROMISED: f64 = 1e-5;

/// The largest |r_i| of each parameter.
fn largest<const N: usize>(polygon: &[Vertex<N>]) -> [f64; N] {
    std::array::from_fn(|i| {
        polygon.iter().map(|v| f64::from(v.params[i].abs())).fold(0.0, f64::max)
    })
}

/// The worst errors of some polygons, each as a part of the largest parameter (w as a part of
/// itself, depth as it is).
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    polygons: u64,
    /// Pixels whose centres lie inside the unrounded polygon.
    pixels: u64,
    parameter: f64,
    /// As a part of the largest parameter, or of the derivative where that is larger.
    derivative: f64,
    depth: f64,
    w: f64,
}

impl Add for Errors {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            polygons: self.polygons + other.polygons,
            pixels: self.pixels + other.pixels,
            parameter: self.parameter.max(other.parameter),
            derivative: self.derivative.max(other.derivative),
            depth: self.depth.max(other.depth),
            w: self.w.max(other.w),
        }
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { polygons, pixels, parameter, derivative, depth, w } = self;
        write!(
            f,
            "{polygons} polygons, {pixels} pixels, worst error of parameters {parameter:.1e}, "
        )?;
        write!(f, "derivatives {derivative:.1e}, depth {depth:.1e}, w {w:.1e}")
    }
}

/// Holds the fragments of a polygon against the plane through three of its vertices, at pixels
/// whose centres lie inside the unrounded polygon. `every` is the share of rows that are looked at.
fn errors<const N: usize>(shape: &Shape<N>, window: Window, every: i32) -> Errors {
    let polygon = vertices(shape);
    let largest = largest(&polygon);
    let mut errors = Errors { polygons: 1, ..Errors::default() };
    let Some(triple) = oracle::best_triple(&shape.positions) else { return errors };
    let outline = oracle::unrounded_outline(&shape.positions, window, Depth::ZeroToOne, 65536.0);
    let mut scan = ScanConverter::new(viewport(window));
    for span in scan.spans(&polygon).filter(|span| span.y() % every == 0) {
        for fragment in span.fragments() {
            let point = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
            if oracle::distance_outside(&outline, point) > 0.0 {
                continue;
            }
            let exact = oracle::sample(&shape.positions, &shape.parameters, triple, window, point);
            if let Some(exact) = exact {
                errors = errors + error(&fragment, &exact, &largest);
            }
        }
    }
    errors
}

/// The errors of one fragment.
fn error<const N: usize>(
    fragment: &Fragment<'_, N>,
    exact: &oracle::Sample<N>,
    largest: &[f64; N],
) -> Errors {
    let most = |error: &dyn Fn(usize) -> f64| (0..N).map(error).fold(0.0, f64::max);
    let off = |value: f32, exact: f64, scale: f64| {
        (f64::from(value) - exact).abs() / scale.max(f64::MIN_POSITIVE)
    };
    let (dx, dy) = fragment.derivatives();
    let derivative = |i: usize| {
        let scale = largest[i] + exact.dx[i].abs() + exact.dy[i].abs();
        off(dx[i], exact.dx[i], scale) + off(dy[i], exact.dy[i], scale)
    };
    Errors {
        polygons: 0,
        pixels: 1,
        parameter: most(&|i| off(fragment.params[i], exact.values[i], largest[i])),
        derivative: most(&derivative),
        depth: off(fragment.depth, exact.z_over_w, 1.0),
        w: off(fragment.w, exact.w, exact.w),
    }
}

/// The worst errors of the shapes that the seeds name; all keep the promise.
fn worst<const N: usize>(
    seeds: Range<u64>,
    window: Window,
    shape: impl Fn(&mut Rng) -> Shape<N> + Sync,
) -> Errors {
    in_threads(seeds, |seed| {
        let shape = shape(&mut Rng::new(seed));
        let errors = errors(&shape, window, 1);
        assert!(errors.keep_the_promise(), "seed {seed}: {errors} in {shape:?}");
        errors
    })
}

impl Errors {
    fn keep_the_promise(&self) -> bool {
        [self.parameter, self.derivative, self.depth, self.w].iter().all(|&e| e <= PROMISED)
    }
}

/// Many shapes of a kind keep the promise, and have pixels to keep it on.
fn keeps_the_promise<const N: usize>(times: u64, shape: impl Fn(&mut Rng) -> Shape<N> + Sync) {
    let errors = worst(0..times, WINDOW, shape);
    assert!(errors.pixels > times, "only {} pixels were compared", errors.pixels);
}

#[test]
fn triangles_keep_the_promise_at_w_ratios_to_1000() {
    for w_ratio in [1.0, 1.5, 10.0, 100.0, 1000.0] {
        keeps_the_promise::<3>(60, |rng| generators::random_triangle(rng, w_ratio, 1.5));
    }
}

/// Planar polygons of 3 to 64 sides with w ratios to 1000.
fn any_polygon<const N: usize>(rng: &mut Rng) -> Shape<N> {
    let sides = sides(rng);
    let w_ratio = rng.octaves(1.0, 1000.0);
    generators::random_convex(rng, sides, w_ratio)
}

/// 3 to 12, or an even number up to 64.
fn sides(rng: &mut Rng) -> usize {
    if rng.once_in(2) { 3 + rng.below(10) } else { 14 + 2 * rng.below(26) }
}

#[test]
fn polygons_keep_the_promise_for_any_number_of_parameters() {
    keeps_the_promise::<0>(40, any_polygon);
    keeps_the_promise::<1>(40, any_polygon);
    keeps_the_promise::<2>(40, any_polygon);
    keeps_the_promise::<3>(40, any_polygon);
    keeps_the_promise::<4>(40, any_polygon);
    keeps_the_promise::<8>(40, any_polygon);
    keeps_the_promise::<16>(40, any_polygon);
    keeps_the_promise::<37>(40, any_polygon);
}

#[test]
fn polygons_through_the_eye_keep_the_promise() {
    keeps_the_promise::<4>(100, |rng| {
        let sides = 3 + rng.below(10);
        generators::through_eye(rng, sides)
    });
}

#[test]
fn polygons_seen_nearly_edge_on_keep_the_promise() {
    for tilt in [0.3, 0.03, 0.01] {
        keeps_the_promise::<3>(60, |rng| generators::edge_on(rng, 5, tilt));
    }
}

#[test]
fn error_does_not_grow_along_a_span_of_16384_pixels() {
    let window = Window { width: 16384, height: 8 };
    for seed in 0..6 {
        let rng = &mut Rng::new(seed);
        let parameters = |rng: &mut Rng| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
        let corners = [([-1.0, -3.0], 1.0), ([1.0, -3.0], 1000.0), ([0.3, 5.0], 30.0)];
        let shape: Shape<2> = Shape {
            positions: corners
                .map(|([x, y], w)| [x * w, y * w, 0.5 * w, w].map(|c: f64| c as f32))
                .to_vec(),
            parameters: corners.iter().map(|_| parameters(rng)).collect(),
        };
        let errors = errors(&shape, window, 1);
        assert!(errors.keep_the_promise() && errors.pixels > 60_000, "seed {seed}: {errors}");
    }
}

#[test]
fn a_block_with_a_steep_fall_of_1_over_w_is_as_exact() {
    // w rises a thousandfold within a few pixels: f32 deltas from the near end miss the far end.
    let window = Window { width: 24, height: 24 };
    for seed in 0..100 {
        let rng = &mut Rng::new(seed);
        let mut shape = generators::random_triangle::<2>(rng, 1000.0, 0.9);
        if seed % 2 == 0 {
            shape.parameters = vec![[1.0, -1.0]; 3];
        }
        let errors = errors(&shape, window, 1);
        assert!(errors.keep_the_promise(), "seed {seed}: {errors}");
    }
}

#[test]
fn spans_stepped_in_f64_agree_with_equation_1() {
    let mut compared = 0;
    for seed in 0..100 {
        let rng = &mut Rng::new(seed);
        let polygon = vertices(&generators::random_triangle::<3>(rng, 50.0, 2.0));
        let triangle: [Vertex<3>; 3] = polygon.clone().try_into().expect("three vertices");
        let viewport = viewport(WINDOW);
        let Some(matrix) = ParameterMatrix::new(&triangle, &viewport) else { continue };
        let largest = largest(&polygon);
        for span in ScanConverter::new(viewport).spans(&polygon) {
            let (mut at, delta) = (span.start(), span.delta());
            for x in span.x() {
                let (params, w) = matrix.at(f64::from(x) + 0.5, f64::from(span.y()) + 0.5);
                assert!((at.inv_w * w - 1.0).abs() < 1e-9, "seed {seed}: {at:?} for w {w}");
                for i in 0..3 {
                    let stepped = at.s[i] / at.inv_w;
                    assert!((stepped - params[i]).abs() < 1e-9 * largest[i], "seed {seed}");
                }
                at.inv_w += delta.inv_w;
                (0..3).for_each(|i| at.s[i] += delta.s[i]);
                compared += 1;
            }
        }
    }
    assert!(compared > 50_000, "only {compared} pixels were compared");
}

/// The parameters at each pixel that a polygon covers.
fn drawn<const N: usize>(
    polygon: &[Vertex<N>],
    interpolation: [Interpolation; N],
) -> Vec<((i32, i32), [f32; N])> {
    let mut scan = ScanConverter::new(viewport(WINDOW));
    scan.interpolation = interpolation;
    let mut pixels = Vec::new();
    for span in scan.spans(polygon) {
        pixels.extend(span.fragments().map(|f| ((f.x, f.y), f.params)));
    }
    pixels
}

/// How much a quad's parameters at the same points of it differ after it is turned by a quarter in
/// its own plane with its parameters: the picture of a square on the screen, seen in perspective.
fn change_by_rotation(interpolation: Interpolation) -> f32 {
    let turned = |quarters: usize| {
        let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(1.0, 1.0, 0.0)];
        let corners = [corners[0], corners[1], corners[2], vec3(-1.0, 1.0, 0.0)];
        // Rotated about the line of sight: on the screen the quad turns by 30 degrees a step.
        let turn = Mat3::from_rotation_z(quarters as f32 * std::f32::consts::FRAC_PI_6);
        corners.map(|p| {
            let p: Vec3 = turn * (Mat3::from_rotation_y(0.9) * p * 0.8);
            let w = 3.0 - p.z;
            Vertex::new(vec4(2.0 * p.x, 2.0 * p.y, 0.5 * w, w), [p.x, p.y, 1.0])
        })
    };
    // A quad with (u, v) at its corners, and where on the screen its middle appears.
    let middle = |quarters: usize| {
        let mut quad = turned(quarters);
        for (vertex, uv) in quad.iter_mut().zip([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) {
            vertex.params = [uv[0], uv[1], 1.0];
        }
        let centre: Vec<_> = quad.iter().map(|v| v.position).collect();
        let centre = centre.iter().sum::<glam::Vec4>() / 4.0;
        let at = [
            (centre.x / centre.w + 1.0) * WINDOW.width as f32 / 2.0,
            (1.0 - centre.y / centre.w) * WINDOW.height as f32 / 2.0,
        ];
        // The parameters at the pixel there, less their change from its centre to the middle.
        let mut scan = ScanConverter::new(viewport(WINDOW));
        scan.interpolation = [interpolation; 3];
        let mut found = None;
        for span in scan.spans(&quad) {
            for f in span.fragments().filter(|f| (f.x, f.y) == (at[0] as i32, at[1] as i32)) {
                let (dx, dy) = f.derivatives();
                let off = [at[0] - f.x as f32 - 0.5, at[1] - f.y as f32 - 0.5];
                found = Some([0, 1].map(|i| f.params[i] + off[0] * dx[i] + off[1] * dy[i]));
            }
        }
        found.expect("the middle is visible")
    };
    let upright = middle(0);
    (1..12)
        .map(middle)
        .fold(0.0, |most, uv| most.max((uv[0] - upright[0]).abs()).max((uv[1] - upright[1]).abs()))
}

#[test]
fn perspective_is_invariant_under_rotation_and_linear_interpolation_is_not() {
    // The middle of the square has (u, v) = (1/2, 1/2), however it is turned on the screen; the
    // tolerance is what the second derivatives make of half a pixel.
    let perspective = change_by_rotation(Interpolation::Perspective);
    assert!(perspective < 2e-3, "perspective changes by {perspective}");
    let linear = change_by_rotation(Interpolation::Linear);
    assert!(linear > 0.03, "linear interpolation changes by {linear} only");
}

/// A quad in perspective with three equal parameters.
fn quad() -> [Vertex<3>; 4] {
    [(-0.9, -0.8, 1.0, 0.0), (0.9, -0.8, 1.0, 0.0), (0.6, 0.7, 5.0, 1.0), (-0.6, 0.7, 5.0, 1.0)]
        .map(|(x, y, w, r)| Vertex::new(vec4(x * w, y * w, 0.0, w), [r; 3]))
}

#[test]
fn each_parameter_has_its_own_interpolation() {
    use Interpolation::{Flat, Linear, Perspective};
    let window_height = f64::from(WINDOW.height);
    let drawn = drawn(&quad(), [Perspective, Linear, Flat]);
    assert!(drawn.len() > 3000, "only {} pixels were drawn", drawn.len());
    for ((_, y), [perspective, linear, flat]) in drawn {
        // Down the screen the quad runs from y = 0.7 to y = -0.8.
        let y = 1.0 - (f64::from(y) + 0.5) / window_height * 2.0;
        let t = (y + 0.8) / 1.5;
        assert!((f64::from(linear) - t).abs() < 1e-6);
        let (inv_near, inv_far) = (1.0 - t, t / 5.0);
        assert!((f64::from(perspective) - inv_far / (inv_near + inv_far)).abs() < 1e-6);
        assert_eq!(flat, 0.0);
    }
}

#[test]
fn linear_and_flat_parameters_are_not_changed_by_clipping() {
    use Interpolation::{Flat, Linear};
    let mut quad = quad();
    quad.rotate_left(2);
    let whole = drawn(&quad, [Linear, Linear, Flat]);
    let mut scan = ScanConverter::new(viewport(WINDOW));
    scan.interpolation = [Linear, Linear, Flat];
    // A plane through the middle of the quad, which takes the first vertex away.
    scan.planes = vec![ClipPlane::new(vec4(0.1, -1.0, 0.0, 0.0))];
    let mut clipped = 0;
    for span in scan.spans(&quad) {
        for f in span.fragments() {
            let (_, params) =
                whole.iter().find(|(at, _)| *at == (f.x, f.y)).expect("a part of the whole");
            assert!((f.params[0] - params[0]).abs() < 1e-6);
            assert_eq!(f.params[2], 1.0);
            clipped += 1;
        }
    }
    assert!(clipped > 100 && clipped < whole.len() - 100);
}

/// Two ways of the library against each other; the tests above hold each against exact values.
#[test]
fn equal_w_gives_the_coverage_and_the_parameters_of_the_general_path() {
    let mut compared = 0;
    for seed in 0..50 {
        let rng = &mut Rng::new(seed);
        let flat = vertices(&generators::random_triangle::<2>(rng, 1.0, 1.5));
        let flat: Vec<_> =
            flat.iter().map(|v| Vertex::new(v.position * (1.0 / v.position.w), v.params)).collect();
        // Scaled by powers of two, a homogeneous position stays exactly the same point.
        let mut general = flat.clone();
        for (vertex, scale) in general.iter_mut().zip([1.0, 2.0, 4.0]) {
            vertex.position *= scale;
        }
        let linear = drawn(&flat, [Interpolation::Perspective; 2]);
        let general = drawn(&general, [Interpolation::Linear; 2]);
        assert_eq!(linear.len(), general.len());
        for ((at, a), (other_at, b)) in linear.iter().zip(&general) {
            assert_eq!(at, other_at);
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} and {b:?}");
        }
        compared += linear.len();
    }
    assert!(compared > 20_000, "only {compared} pixels were compared");
}

#[test]
fn values_that_are_not_affine_stay_between_those_of_the_vertices() {
    let mut compared = 0;
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        // Not flat, concave or crossed, with any colours.
        let corners = 4 + rng.below(4);
        let polygon: Vec<Vertex<2>> = (0..corners)
            .map(|_| {
                let w = rng.octaves(1.0, 20.0) as f32;
                let [x, y, z] = std::array::from_fn(|_| rng.range(-1.2, 1.2) as f32);
                let color = std::array::from_fn(|_| rng.range(0.0, 1.0) as f32);
                Vertex::new(vec4(x * w, y * w, (0.5 + 0.3 * z) * w, w), color)
            })
            .collect();
        let range = |value: &dyn Fn(&Vertex<2>) -> f32| {
            let values = polygon.iter().map(value);
            values.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)))
        };
        let ranges = [0, 1].map(|i| range(&|v| v.params[i]));
        let w_range = range(&|v| v.position.w);
        for span in ScanConverter::new(viewport(WINDOW)).spans(&polygon) {
            for f in span.fragments() {
                for (r, (low, high)) in f.params.iter().zip(ranges) {
                    // The product and the two factors are rounded: three halves of a unit.
                    assert!(*r >= low - 2e-7 && *r <= high + 2e-7, "seed {seed}: {r}");
                }
                assert!(f.w >= w_range.0 && f.w <= w_range.1, "seed {seed}: w {}", f.w);
                compared += 1;
            }
        }
    }
    assert!(compared > 200_000, "only {compared} pixels were compared");
}

#[test]
fn colours_at_the_corners_of_a_square_are_bilinear() {
    // Upright, Heckbert's interpolation along edges and spans is the bilinear function.
    let colors = [0.0, 1.0, 0.25, 0.5];
    let square = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let square: Vec<_> = square
        .iter()
        .zip(colors)
        .map(|(&(x, y), color)| Vertex::new(vec4(x, y, 0.0, 1.0), [color]))
        .collect();
    for span in ScanConverter::new(Viewport::new(40, 30).expect("small")).spans(&square) {
        for f in span.fragments() {
            let (u, v) = ((f.x as f32 + 0.5) / 40.0, (f.y as f32 + 0.5) / 30.0);
            let (top, bottom) = (u, 0.5 - 0.25 * u);
            assert!((f.params[0] - (top + (bottom - top) * v)).abs() < 1e-6);
            let ([dx], [dy]) = f.derivatives();
            assert!((dx - (1.0 - 1.25 * v) / 40.0).abs() < 1e-6, "{dx} at {u}, {v}");
            assert!((dy - (bottom - top) / 30.0).abs() < 1e-6, "{dy} at {u}, {v}");
        }
    }
}

/// How far the parameters of a fragment may leave those of the polygon's nearest point, as contract
/// 3 has it, and how far they do.
///
/// The centre of a covered pixel lies within 1/256 pixel of the unrounded outline, or inside. Let q
/// be the nearest point of the polygon, r its parameter, and g_s and g_v the lengths of the
/// gradients of s = r/w and v = 1/w over the screen. On the way from q to the centre s changes by at
/// most g_s/256 and v by at most g_v/256, and the fragment's v, which is kept in the polygon's own
/// range, is 1/w. So r changes by at most (g_s + |r| g_v) w / 256; the promise of contract 4 is added
/// for the rounding to f32.
fn excess<const N: usize>(shape: &Shape<N>, window: Window) -> f64 {
    let polygon = vertices(shape);
    let largest = largest(&polygon);
    let Some(triple) = oracle::best_triple(&shape.positions) else { return 0.0 };
    let at = |p| oracle::sample(&shape.positions, &shape.parameters, triple, window, p);
    let outline = oracle::unrounded_outline(&shape.positions, window, Depth::ZeroToOne, 65536.0);
    let mut worst = 0.0f64;
    for span in ScanConverter::new(viewport(window)).spans(&polygon) {
        for fragment in span.fragments() {
            let centre = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
            let nearest = oracle::nearest_point(&outline, centre);
            let Some(inside) = at(nearest) else { continue };
            let w = f64::from(fragment.w);
            for (i, (&r, largest)) in fragment.params.iter().zip(largest).enumerate() {
                let (gs, gv) = gradients(&inside, i);
                let bound = (gs + inside.values[i].abs() * gv) * w / 256.0 + PROMISED * largest;
                let off = (f64::from(r) - inside.values[i]).abs();
                assert!(off.is_finite(), "parameter {r} in {shape:?}");
                worst = worst.max(off / bound.max(f64::MIN_POSITIVE));
            }
        }
    }
    worst
}

/// The lengths of the gradients of s and of 1/w, from those of r and w: s = r v, so that
/// grad s = v grad r + r grad v. The last parameter of the shape is to be w itself, whose gradient is
/// -w^2 grad v.
fn gradients<const N: usize>(sample: &oracle::Sample<N>, i: usize) -> (f64, f64) {
    let v = 1.0 / sample.w;
    let grad_v = [sample.dx[N - 1], sample.dy[N - 1]].map(|dw| -dw * v * v);
    let grad_r = [sample.dx[i], sample.dy[i]];
    let grad_s = [0, 1].map(|k| v * grad_r[k] + sample.values[i] * grad_v[k]);
    let length = |g: [f64; 2]| g[0].hypot(g[1]);
    (length(grad_s), length(grad_v))
}

/// A polygon that is thin, or smaller than a pixel, with w as its last parameter.
fn thin_or_small(rng: &mut Rng) -> Shape<3> {
    let mut shape: Shape<3> = match rng.below(4) {
        0 => {
            let tilt = rng.octaves(1e-4, 0.1);
            generators::edge_on(rng, 5, tilt)
        }
        1 => {
            let sides = sides(rng);
            generators::through_eye(rng, sides)
        }
        2 => generators::random_triangle(rng, 1000.0, 1.5),
        _ => {
            let (thickness, w_ratio) = (rng.octaves(1e-4, 2.0), rng.octaves(1.0, 1000.0));
            let positions = generators::sliver(rng, WINDOW, thickness, w_ratio);
            let parameters =
                positions.iter().map(|_| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32));
            Shape { parameters: parameters.collect(), positions }
        }
    };
    for (parameters, position) in shape.parameters.iter_mut().zip(&shape.positions) {
        parameters[2] = position[3];
    }
    shape
}

fn stays_near(seed: u64) -> Most {
    let shape = thin_or_small(&mut Rng::new(seed));
    let excess = excess(&shape, WINDOW);
    assert!(excess <= 1.0, "seed {seed}: {excess} times what is allowed, in {shape:?}");
    Most(excess)
}

/// The largest of some numbers.
#[derive(Clone, Copy, Debug, Default)]
struct Most(f64);

impl Add for Most {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
}

#[test]
fn parameters_leave_the_polygon_by_no_more_than_its_plane_over_a_256th_of_a_pixel() {
    let worst = in_threads(0..300, stays_near);
    assert!(worst.0 > 0.1, "the bound is near: {worst:?} of it");
}

/// A triangle across 16,384 columns with w from 1 to 1000.
fn long_spans(rng: &mut Rng) -> Shape<4> {
    let mut shape = generators::random_triangle::<4>(rng, 1000.0, 1.0);
    // One vertex on the left, one on the right, above and below the eight rows.
    for (p, [x, y]) in shape.positions.iter_mut().zip([[-1.0, -9.0], [1.0, -9.0], [0.0, 9.0]]) {
        let jitter = rng.range(-0.5, 0.5) as f32;
        (p[0], p[1]) = ((x + 0.1 * jitter) * p[3], (y + jitter) * p[3]);
    }
    shape
}

/// The classes of contract 4, with many more polygons, and their figures.
#[test]
#[ignore = "long: minutes in release"]
fn long_parameters() {
    let seeds = |n: u64| LONG_SEED..LONG_SEED + n;
    for w_ratio in [1.0, 1.5, 10.0, 100.0, 1000.0] {
        let triangle = |rng: &mut Rng| generators::random_triangle::<3>(rng, w_ratio, 1.5);
        println!("triangles, w ratio {w_ratio}: {}", worst(seeds(8000), WINDOW, triangle));
    }
    fn n<const N: usize>(seeds: Range<u64>) {
        println!("3 to 64 sides, N = {N}: {}", worst::<N>(seeds, WINDOW, any_polygon));
    }
    n::<0>(seeds(4000));
    n::<1>(seeds(4000));
    n::<4>(seeds(4000));
    n::<16>(seeds(2000));
    n::<37>(seeds(1000));
    for tilt in [0.1, 0.01, 0.001] {
        let edge_on = |rng: &mut Rng| generators::edge_on::<3>(rng, 7, tilt);
        println!("edge-on, {tilt} thick: {}", worst(seeds(20_000), WINDOW, edge_on));
    }
    let through_eye = |rng: &mut Rng| {
        let sides = sides(rng);
        generators::through_eye::<4>(rng, sides)
    };
    println!("through the eye: {}", worst(seeds(8000), WINDOW, through_eye));
    let window = Window { width: 16384, height: 8 };
    println!("spans of 16,384 pixels: {}", worst(seeds(400), window, long_spans));
}

#[test]
#[ignore = "long: a minute in release"]
fn long_range_of_parameters() {
    let most = in_threads(LONG_SEED..LONG_SEED + 100_000, stays_near);
    println!("parameters of 100,000 thin polygons outside of them: {:.2} of the bound", most.0);
}
