//! Contracts 1 and 2: coverage is exact, and the sides of the viewport do not move edges.

use crate::common::generators::{self, Cells, Rng};
use crate::common::oracle::{self, Depth, FillRule, Position, Window};
use crate::common::{
    LONG_SEED, Tally, at_pixels, bare, counts, digits, in_threads, picture, viewport,
};
use glam::{DVec4, Vec4Swizzles, vec4};
use polyscan::{ClipPlane, Cull, Rect, ScanConverter, Vertex, Viewport};

const SMALL: Window = Window { width: 6, height: 5 };

#[test]
fn a_rectangle_covers_the_centres_on_its_top_and_left_sides() {
    let centres = at_pixels(&[[1.5, 1.5], [4.5, 1.5], [4.5, 3.5], [1.5, 3.5]], SMALL);
    assert_eq!(picture(&[centres], SMALL), ["......", ".111..", ".111..", "......", "......"]);
    let corners = at_pixels(&[[1.0, 1.0], [4.0, 1.0], [4.0, 3.0], [1.0, 3.0]], SMALL);
    assert_eq!(picture(&[corners], SMALL), ["......", ".111..", ".111..", "......", "......"]);
    let between = at_pixels(&[[1.6, 1.6], [4.4, 1.6], [4.4, 3.4], [1.6, 3.4]], SMALL);
    assert_eq!(picture(&[between], SMALL), ["......", "......", "..11..", "......", "......"]);
}

#[test]
fn a_diagonal_through_centres_belongs_to_the_triangle_on_its_right() {
    let upper_right = at_pixels(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]], SMALL);
    let lower_left = at_pixels(&[[0.0, 0.0], [5.0, 5.0], [0.0, 5.0]], SMALL);
    let right = ["11111.", ".1111.", "..111.", "...11.", "....1."];
    let left = ["......", "1.....", "11....", "111...", "1111.."];
    assert_eq!(picture(std::slice::from_ref(&upper_right), SMALL), right);
    assert_eq!(picture(std::slice::from_ref(&lower_left), SMALL), left);
    assert_eq!(picture(&[lower_left, upper_right], SMALL), ["11111."; 5]);
}

#[test]
fn what_is_wound_around_is_inside() {
    let arrow = at_pixels(&[[0.0, 0.0], [3.0, 4.0], [6.0, 0.0], [3.0, 2.0]], SMALL);
    assert_eq!(picture(&[arrow], SMALL), ["1....1", ".1..1.", "..11..", "......", "......"]);
    let bow_tie = at_pixels(&[[0.0, 0.0], [6.0, 5.0], [6.0, 0.0], [0.0, 5.0]], SMALL);
    assert_eq!(picture(&[bow_tie], SMALL), ["1....1", "11..11", "111111", "11..11", "1....1"]);
    // A square run around twice is still covered once.
    let square = [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0], [1.0, 4.0]];
    let twice = at_pixels(&[square, square].concat(), SMALL);
    assert_eq!(picture(&[twice], SMALL), ["......", ".1111.", ".1111.", ".1111.", "......"]);
}

#[test]
fn polygons_without_area_cover_nothing() {
    for places in [
        vec![[0.5, 0.5], [5.5, 4.5]],
        vec![[0.5, 0.5], [5.5, 4.5], [0.5, 0.5]],
        vec![[0.5, 0.5], [5.5, 0.5], [3.5, 0.5]],
        vec![[2.5, 0.5], [2.5, 4.5], [2.5, 1.5], [2.5, 3.5]],
        vec![[2.5, 2.5]; 5],
        vec![],
    ] {
        assert_eq!(picture(&[at_pixels(&places, SMALL)], SMALL), ["......"; 5], "{places:?}");
    }
}

#[test]
fn culling_goes_by_the_direction_seen_on_the_screen() {
    let clockwise = at_pixels(&[[0.0, 0.0], [6.0, 0.0], [6.0, 5.0], [0.0, 5.0]], SMALL);
    let counter_clockwise: Vec<_> = clockwise.iter().rev().copied().collect();
    for (cull, drawn) in [(Cull::None, [30, 30]), (Cull::Back, [0, 30]), (Cull::Front, [30, 0])] {
        let mut scan = ScanConverter::new(viewport(SMALL));
        scan.settings.cull = cull;
        for (polygon, expected) in [&clockwise, &counter_clockwise].into_iter().zip(drawn) {
            let pixels: usize = scan.spans(polygon).map(|span| span.columns().len()).sum();
            assert_eq!(pixels, expected, "{cull:?}");
        }
    }
}

#[test]
fn scissor_and_viewport_keep_spans_inside() {
    let all = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.0, 1.0), []));
    let visited = |viewport: Viewport, scissor| {
        let mut scan = ScanConverter::<0>::new(viewport);
        scan.settings.scissor = scissor;
        let spans: Vec<_> = scan.spans(&all).map(|span| (span.row(), span.columns())).collect();
        spans
    };
    let at = Viewport::new(3, 2)
        .map(|viewport| viewport.with_corner(10, -20))
        .expect("a small viewport");
    assert_eq!(visited(at, None), [(-20, 10..13), (-19, 10..13)]);
    let scissor = |x, y, width, height| Some(Rect { x, y, width, height });
    assert_eq!(visited(at, scissor(12, -20, 5, 1)), [(-20, 12..13)]);
    assert_eq!(visited(at, scissor(0, -30, 11, 11)), [(-20, 10..11)]);
    assert_eq!(visited(at, scissor(i32::MIN, i32::MIN, u32::MAX, u32::MAX)).len(), 2);
    for nothing in [scissor(12, -20, 0, 1), scissor(13, -20, 1, 1), scissor(10, -30, 3, 10)] {
        assert_eq!(visited(at, nothing), []);
    }
    assert_eq!(visited(Viewport::new(0, 2).expect("small"), None), []);
    assert_eq!(visited(Viewport::new(2, 0).expect("small"), None), []);
}

#[test]
fn rows_and_columns_outside_are_skipped_at_once() {
    // Walking the rows outside would take these some 10^9 steps each.
    let mut scan = ScanConverter::<0>::new(viewport(SMALL));
    for big in [1e9, 1e20, 3e38] {
        let wedge = [[-big, big], [big, big], [0.0, -big]];
        let triangle = wedge.map(|[x, y]| Vertex::new(vec4(x, y, 0.0, 1.0), []));
        for _ in 0..1000 {
            let pixels: usize = scan.spans(&triangle).map(|span| span.columns().len()).sum();
            assert_eq!(pixels, 30);
        }
    }
}

/// The guard band that the oracle clips by, in pixels; the one that the library states.
const GUARD: f64 = polyscan::viewport::GUARD_BAND as f64;

const MIDDLE: Window = Window { width: 37, height: 29 };

/// A kind of polygon, one for each seed, and how many of them the short and the long test draw.
struct Kind {
    name: &'static str,
    shape: fn(&mut Rng) -> Vec<Position>,
    short: u64,
    long: u64,
}

const TRIANGLES: &[Kind] = &[
    Kind {
        name: "random triangles",
        shape: |rng| generators::random_triangle::<0>(rng, 10.0, 2.0).positions,
        short: 300,
        long: 100_000,
    },
    Kind {
        name: "triangles of whole numbers",
        shape: |rng| loop {
            let triangle = generators::integer_triangle(rng);
            if !(is_edge_on(&triangle) && triangle.iter().any(|p| p[3] <= 0.0)) {
                return triangle;
            }
        },
        short: 1000,
        long: 100_000,
    },
    Kind {
        name: "slivers",
        shape: |rng| {
            let thickness = rng.octaves(1e-4, 0.5);
            generators::sliver(rng, MIDDLE, thickness, 4.0)
        },
        short: 300,
        long: 100_000,
    },
    Kind {
        name: "triangles to 15,000 pixels outside",
        shape: |rng| generators::far_outside(rng, MIDDLE, 15e3, 4.0),
        short: 200,
        long: 50_000,
    },
    Kind {
        name: "triangles beyond the guard band",
        shape: |rng| {
            let pixels = rng.octaves(6e4, 1e12);
            generators::far_outside(rng, MIDDLE, pixels, 4.0)
        },
        short: 100,
        long: 20_000,
    },
    Kind { name: "zero area", shape: |rng| collinear(rng, MIDDLE), short: 200, long: 50_000 },
];

const CONVEX: &[Kind] = &[
    Kind {
        name: "planar polygons of 3 to 64 sides",
        shape: |rng| {
            let sides = sides(rng);
            generators::random_convex::<0>(rng, sides, 100.0).positions
        },
        short: 200,
        long: 40_000,
    },
    Kind {
        name: "vertices on pixel centres",
        shape: |rng| {
            let most = 3 + rng.below(60);
            generators::on_pixel_centres(rng, MIDDLE, most)
        },
        short: 200,
        long: 50_000,
    },
    Kind {
        name: "vertices on pixel edges and subpixel ties",
        shape: |rng| on_ties(rng, MIDDLE),
        short: 200,
        long: 50_000,
    },
    Kind {
        name: "surrounding the viewport",
        shape: |rng| {
            let (sides, pixels) = (3 + rng.below(62), rng.octaves(1.0, 15e3));
            generators::surrounding(rng, MIDDLE, sides, pixels, 9.0)
        },
        short: 60,
        long: 10_000,
    },
    Kind {
        name: "through the eye",
        shape: |rng| {
            let sides = sides(rng);
            generators::through_eye::<0>(rng, sides).positions
        },
        short: 150,
        long: 20_000,
    },
    Kind {
        name: "nearly edge-on",
        shape: |rng| {
            let (sides, tilt) = (sides(rng), rng.octaves(1e-4, 0.1));
            generators::edge_on::<0>(rng, sides, tilt).positions
        },
        short: 100,
        long: 40_000,
    },
];

const OUTLINES: &[Kind] = &[
    Kind { name: "stars", shape: |rng| generators::star(rng, MIDDLE, 7), short: 100, long: 20_000 },
    Kind {
        name: "crossed stars",
        shape: |rng| generators::crossed_star(rng, MIDDLE, 7, 3),
        short: 100,
        long: 20_000,
    },
    Kind {
        name: "tangles",
        shape: |rng| {
            let corners = 4 + rng.below(20);
            generators::tangle(rng, MIDDLE, corners)
        },
        short: 300,
        long: 50_000,
    },
];

/// 3 to 12, or an even number up to 64.
fn sides(rng: &mut Rng) -> usize {
    if rng.once_in(2) { 3 + rng.below(10) } else { 14 + 2 * rng.below(26) }
}

/// Whether the plane of a triangle of small whole numbers runs through the eye.
fn is_edge_on(triangle: &[Position]) -> bool {
    let vector = |i: usize| DVec4::from(triangle[i].map(f64::from)).xyw();
    vector(0).dot(vector(1).cross(vector(2))) == 0.0
}

/// A triangle whose plane runs through the eye has no area on the screen. If it reaches the eye as
/// well, no vertex of it may be made up there: rounding may give it a pixel or two at its tip, no more.
fn edge_on_through_the_eye(seed: u64) -> Tally {
    let triangle = generators::integer_triangle(&mut Rng::new(seed));
    if !is_edge_on(&triangle) || triangle.iter().all(|p| p[3] > 0.0) {
        return Tally::default();
    }
    let counts = counts(&mut ScanConverter::new(viewport(MIDDLE)), &[bare(&triangle)], MIDDLE);
    let pixels = counts.iter().filter(|&&n| n > 0).count();
    assert!(pixels <= 2, "seed {seed}: {pixels} pixels of {triangle:?}");
    Tally { polygons: 1, pixels: pixels as u64, ..Tally::default() }
}

#[test]
fn a_triangle_seen_edge_on_covers_nothing_though_it_reaches_the_eye() {
    let seen = in_threads(0..20_000, edge_on_through_the_eye);
    assert!(seen.polygons > 200, "{seen}");
}

/// 3 to 6 vertices on one line through the window, at multiples of a 1/64 pixel vector.
fn collinear(rng: &mut Rng, window: Window) -> Vec<Position> {
    let mut whole = |most: i64| rng.whole(-most, most) as f64;
    let (start, step) = ([whole(40), whole(40)], [whole(64) / 64.0, whole(64) / 64.0]);
    (0..3 + rng.below(4))
        .map(|_| {
            let t = rng.whole(-64, 64) as f64;
            let w = rng.whole(-3, 3) as f64;
            generators::at_pixel([0, 1].map(|k| start[k] + t * step[k]), w.exp2(), window)
        })
        .collect()
}

/// A triangle or a quad in any order, with vertices on the sides of pixels or half-way between two
/// multiples of 1/256 pixel, with a w of 1 to 5; or at the eye itself.
fn on_ties(rng: &mut Rng, window: Window) -> Vec<Position> {
    let step = if rng.once_in(2) { 1.0 } else { 1.0 / 512.0 };
    (0..3 + rng.below(2))
        .map(|_| {
            let place = [window.width, window.height].map(|size| {
                let most = i64::from(size) * 512;
                (rng.whole(0, most) as f64 / 512.0 / step).round() * step
            });
            generators::at_pixel(place, rng.whole(0, 5) as f64, window)
        })
        .collect()
}

/// Draws the polygon that a seed names and holds it against the oracle, pixel for pixel.
fn against_the_oracle(kind: &Kind, seed: u64) -> Tally {
    let polygon = (kind.shape)(&mut Rng::new(seed));
    compared(&polygon, &mut ScanConverter::new(viewport(MIDDLE)), &[], || {
        format!("{}, seed {seed}: {polygon:?}", kind.name)
    })
}

/// Holds a polygon cut by the planes, besides those of the view volume, against the oracle.
fn compared(
    polygon: &[Position],
    scan: &mut ScanConverter<0>,
    planes: &[[i32; 4]],
    name: impl Fn() -> String,
) -> Tally {
    scan.settings.planes =
        planes.iter().map(|p| ClipPlane::new(p.map(|c| c as f32).into())).collect();
    let planes: Vec<_> = planes.iter().map(|&p| oracle::plane(p)).collect();
    let border = oracle::border(&[polygon.to_vec()], MIDDLE, Depth::ZeroToOne, GUARD, &planes);
    let expected = oracle::fill_border(&border, MIDDLE, FillRule::NonZero);
    let drawn = digits(&counts(scan, &[bare(polygon)], MIDDLE), MIDDLE.width);
    let wanted = expected.picture(MIDDLE).replace('#', "1");
    assert_eq!(drawn.join("\n") + "\n", wanted, "{}", name());
    Tally { polygons: 1, pixels: expected.count() as u64, ..Tally::default() }
}

/// Convex polygons cut by one to three planes with whole coefficients.
fn cut_by_planes(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let sides = sides(rng);
    let shape = match seed % 3 {
        0 => generators::through_eye::<0>(rng, sides),
        1 => generators::random_convex(rng, sides, 100.0),
        _ => generators::random_triangle(rng, 10.0, 2.0),
    };
    let planes: Vec<[i32; 4]> =
        (0..1 + rng.below(3)).map(|_| std::array::from_fn(|_| rng.whole(-9, 9) as i32)).collect();
    let mut scan = ScanConverter::new(viewport(MIDDLE));
    compared(&shape.positions, &mut scan, &planes, || format!("seed {seed}: {shape:?} {planes:?}"))
}

fn short(kinds: &[Kind]) {
    for kind in kinds {
        in_threads(0..kind.short, |seed| against_the_oracle(kind, seed));
    }
}

#[test]
fn triangles_are_exact() {
    short(TRIANGLES);
}

#[test]
fn convex_polygons_are_exact() {
    short(CONVEX);
}

#[test]
fn ties_between_two_256ths_go_to_the_even_one() {
    // Sides 1/512 pixel beside columns and rows of pixel centres, half of them on the way to an odd
    // number of 1/256. In a window of powers of two these places are exact.
    let window = Window { width: 8, height: 8 };
    let mut scan = ScanConverter::new(viewport(window));
    for seed in 0..500 {
        let rng = &mut Rng::new(seed);
        let mut side = || rng.whole(-2, 9) as f64 + 0.5 + rng.whole(-1, 1) as f64 / 512.0;
        let [left, top, right, bottom] = std::array::from_fn(|_| side());
        let w = rng.whole(0, 3) as f64;
        let places = [[left, top], [right, top], [right, bottom], [left, bottom]];
        let quad = places.map(|place| generators::at_pixel(place, w.exp2(), window));
        let expected = oracle::coverage(&quad, window, Depth::ZeroToOne, GUARD, FillRule::NonZero);
        let drawn = digits(&counts(&mut scan, &[bare(&quad)], window), window.width);
        assert_eq!(drawn.join("\n") + "\n", expected.picture(window).replace('#', "1"), "{quad:?}");
    }
}

#[test]
fn concave_and_crossed_outlines_are_exact() {
    short(OUTLINES);
}

#[test]
fn polygons_cut_by_planes_are_exact() {
    in_threads(0..200, cut_by_planes);
}

#[test]
#[ignore = "long: 10^6 polygons against rational arithmetic, minutes in release"]
fn long_coverage() {
    for kind in [TRIANGLES, CONVEX, OUTLINES].into_iter().flatten() {
        let seeds = LONG_SEED..LONG_SEED + kind.long;
        let tally = in_threads(seeds, |seed| against_the_oracle(kind, seed));
        println!("{}: {tally}", kind.name);
    }
    let tally = in_threads(LONG_SEED..LONG_SEED + 50_000, cut_by_planes);
    println!("cut by 1 to 3 planes: {tally}");
    let seeds = LONG_SEED..LONG_SEED + 2_000_000;
    println!("edge-on through the eye: {}", in_threads(seeds, edge_on_through_the_eye));
}

/// Draws a mesh and finds each pixel covered once, or at most once.
fn once(mesh: &generators::Mesh, window: Window, complete: bool) {
    let mut scan = ScanConverter::new(viewport(window));
    let polygons: Vec<_> = mesh.polygons().iter().map(|polygon| bare(polygon)).collect();
    let counts = counts(&mut scan, &polygons, window);
    let wrong = counts.iter().position(|&n| n > 1 || complete && n == 0);
    assert_eq!(wrong, None, "pixel {wrong:?} is covered {:?} times", wrong.map(|i| counts[i]));
}

#[test]
fn shared_edges_leave_no_gap_and_no_overlap() {
    let window = Window { width: 160, height: 120 };
    for seed in 0..8 {
        let rng = &mut Rng::new(seed);
        for cells in [Cells::Triangles, Cells::Quads, Cells::Mixed] {
            let grid = generators::jittered_grid(rng, window, [24, 17], cells, 30.0, 5.0);
            once(&grid, window, true);
            once(&generators::jittered_grid(rng, window, [90, 80], cells, 9.0, 1.0), window, true);
            once(&generators::cut_grid(rng, window, [24, 17], cells, 30.0), window, false);
            once(&generators::floor(rng, [24, 40], cells, 60.0), window, false);
        }
        once(&generators::fan(rng, window, 300, 16.0), window, true);
    }
}

#[test]
fn the_sides_of_the_viewport_do_not_move_edges() {
    let large = Window { width: 400, height: 300 };
    let part = Rect { x: 137, y: 71, width: 90, height: 110 };
    for seed in 0..200 {
        let rng = &mut Rng::new(seed);
        let polygon = generators::far_outside(rng, large, 15_000.0, 8.0);
        let rows = |viewport: Viewport, polygon: &[Vertex<0>]| {
            let mut scan = ScanConverter::new(viewport);
            scan.settings.scissor = Some(part);
            let rows: Vec<_> =
                scan.spans(polygon).map(|span| (span.row(), span.columns())).collect();
            rows
        };
        let whole = rows(viewport(large), &bare(&polygon));
        // The same places on a viewport that is only as large as the part: exact in f32, since the
        // sizes are chosen so that all factors are, for places on the grid of 1/16 pixel.
        let snapped: Vec<[f32; 2]> = polygon
            .iter()
            .map(|p| {
                let x = (f64::from(p[0]) / f64::from(p[3]) + 1.0) * 200.0;
                let y = (1.0 - f64::from(p[1]) / f64::from(p[3])) * 150.0;
                [x, y].map(|c| (c * 16.0).round() as f32 / 16.0)
            })
            .collect();
        let in_window = |x0: f32, y0: f32, window: Window| {
            let moved: Vec<_> = snapped.iter().map(|p| [p[0] - x0, p[1] - y0]).collect();
            at_pixels(&moved, window)
        };
        assert!(whole.iter().all(|(y, _)| (71..181).contains(y)));
        let small = Window { width: part.width, height: part.height };
        let small_viewport = viewport(small).with_corner(part.x, part.y);
        let on_large = rows(viewport(large), &in_window(0.0, 0.0, large));
        let on_small = rows(small_viewport, &in_window(137.0, 71.0, small));
        assert_eq!(on_large, on_small, "seed {seed}");
    }
}
