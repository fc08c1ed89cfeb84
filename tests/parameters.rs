//! Contract 4: parameters are exact to f32, and so are their derivatives.

mod common;

use common::generators::{self, Rng, Shape};
use common::oracle::{self, Depth, Window};
use common::{vertices, viewport};
use glam::{Mat3, Vec3, vec3, vec4};
use polyscan::{ClipPlane, Interpolation, ParameterMatrix, ScanConverter, Vertex, Viewport};

const WINDOW: Window = Window { width: 97, height: 61 };

/// The promise: a part of the polygon's largest parameter.
const PROMISED: f64 = 1e-5;

/// The largest |r_i| of each parameter.
fn largest<const N: usize>(polygon: &[Vertex<N>]) -> [f64; N] {
    std::array::from_fn(|i| {
        polygon.iter().map(|v| f64::from(v.params[i].abs())).fold(0.0, f64::max)
    })
}

/// Holds each fragment of a polygon against the plane through three of its vertices, at pixels
/// whose centres lie inside the unrounded polygon; gives the worst error as a part of the largest
/// parameter, and how many pixels were compared.
fn worst_error<const N: usize>(shape: &Shape<N>, window: Window) -> (f64, usize) {
    let polygon = vertices(shape);
    let largest = largest(&polygon);
    let Some(triple) = oracle::best_triple(&shape.positions) else { return (0.0, 0) };
    let outline = oracle::unrounded_outline(&shape.positions, window, Depth::ZeroToOne, 65536.0);
    let mut scan = ScanConverter::new(viewport(window));
    let (mut worst, mut pixels) = (0.0f64, 0);
    for span in scan.spans(&polygon) {
        for fragment in span.fragments() {
            let point = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
            if oracle::distance_outside(&outline, point) > 0.0 {
                continue;
            }
            let exact = oracle::sample(&shape.positions, &shape.parameters, triple, window, point);
            let Some(exact) = exact else { continue };
            pixels += 1;
            for (i, largest) in largest.iter().enumerate() {
                let error = (f64::from(fragment.params[i]) - exact.values[i]).abs();
                worst = worst.max(error / largest.max(f64::MIN_POSITIVE));
            }
            worst = worst.max((f64::from(fragment.depth) - exact.z_over_w).abs());
            worst = worst.max((f64::from(fragment.w) / exact.w - 1.0).abs());
        }
    }
    (worst, pixels)
}

/// Many shapes of a kind keep the promise, and have pixels to keep it on.
fn keeps_the_promise<const N: usize>(times: u64, shape: impl Fn(&mut Rng) -> Shape<N>) {
    let mut compared = 0;
    for seed in 0..times {
        let shape = shape(&mut Rng::new(seed));
        let (error, pixels) = worst_error(&shape, WINDOW);
        assert!(error <= PROMISED, "seed {seed}: {error:e} with {N} parameters in {shape:?}");
        compared += pixels;
    }
    assert!(compared > times as usize, "only {compared} pixels were compared");
}

#[test]
fn triangles_keep_the_promise_at_w_ratios_to_1000() {
    for w_ratio in [1.0, 1.5, 10.0, 100.0, 1000.0] {
        keeps_the_promise::<3>(60, |rng| generators::random_triangle(rng, w_ratio, 1.5));
    }
}

#[test]
fn polygons_keep_the_promise_for_any_number_of_parameters() {
    fn n<const N: usize>() {
        keeps_the_promise::<N>(40, |rng| {
            let (sides, w_ratio) = (3 + rng.below(10), rng.octaves(1.0, 1000.0));
            generators::random_convex(rng, sides, w_ratio)
        });
    }
    n::<0>();
    n::<1>();
    n::<2>();
    n::<3>();
    n::<4>();
    n::<8>();
    n::<16>();
    n::<37>();
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
        let (error, pixels) = worst_error(&shape, window);
        assert!(error <= PROMISED && pixels > 60_000, "seed {seed}: {error:e} at {pixels} pixels");
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
        let (error, _) = worst_error(&shape, window);
        assert!(error <= PROMISED, "seed {seed}: {error:e}");
    }
}

#[test]
fn spans_stepped_in_f64_agree_with_equation_1() {
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
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_the_plane() {
    let mut compared = 0;
    for seed in 0..100 {
        let rng = &mut Rng::new(seed);
        let shape = match seed % 3 {
            0 => generators::random_triangle::<2>(rng, 30.0, 1.5),
            1 => generators::random_convex(rng, 7, 30.0),
            _ => generators::through_eye(rng, 5),
        };
        let polygon = vertices(&shape);
        let largest = largest(&polygon);
        let triple = oracle::best_triple(&shape.positions).expect("not on a line");
        for span in ScanConverter::new(viewport(WINDOW)).spans(&polygon) {
            for fragment in span.fragments() {
                let point = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
                let sample =
                    oracle::sample(&shape.positions, &shape.parameters, triple, WINDOW, point);
                let Some(exact) = sample.filter(oracle::Sample::is_inside) else { continue };
                let (dx, dy) = fragment.derivatives();
                for i in 0..2 {
                    let scale = largest[i] + exact.dx[i].abs() + exact.dy[i].abs();
                    let error = (f64::from(dx[i]) - exact.dx[i]).abs()
                        + (f64::from(dy[i]) - exact.dy[i]).abs();
                    assert!(error <= PROMISED * scale, "seed {seed}: off by {error:e}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 10_000, "only {compared} derivatives were compared");
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
    for ((_, y), [perspective, linear, flat]) in drawn(&quad(), [Perspective, Linear, Flat]) {
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

#[test]
fn equal_w_gives_the_coverage_and_the_parameters_of_the_general_path() {
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
    }
}

#[test]
fn values_that_are_not_affine_stay_between_those_of_the_vertices() {
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
            }
        }
    }
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
