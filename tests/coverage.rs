//! Contracts 1 and 2: coverage is exact, and the sides of the viewport do not move edges.

mod common;

use common::generators::{self, Cells, Rng};
use common::oracle::{self, Depth, FillRule, Window};
use common::{at_pixels, bare, counts, digits, picture, viewport};
use glam::vec4;
use polyscan::{Cull, Rect, ScanConverter, Vertex, Viewport};

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
    for (cull, drawn) in
        [(Cull::None, [30, 30]), (Cull::Clockwise, [0, 30]), (Cull::CounterClockwise, [30, 0])]
    {
        let mut scan = ScanConverter::new(viewport(SMALL));
        scan.cull = cull;
        for (polygon, expected) in [&clockwise, &counter_clockwise].into_iter().zip(drawn) {
            let pixels: usize = scan.spans(polygon).map(|span| span.x().len()).sum();
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
        scan.scissor = scissor;
        let spans: Vec<_> = scan.spans(&all).map(|span| (span.y(), span.x())).collect();
        spans
    };
    let at = Viewport::new(3, 2).map(|viewport| viewport.at(10, -20)).expect("a small viewport");
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
            let pixels: usize = scan.spans(&triangle).map(|span| span.x().len()).sum();
            assert_eq!(pixels, 30);
        }
    }
}

/// Draws shapes of one kind and holds them against the oracle, pixel for pixel.
fn agrees_with_the_oracle(
    window: Window,
    times: u64,
    shape: impl Fn(&mut Rng) -> Vec<oracle::Position>,
) {
    let mut scan = ScanConverter::new(viewport(window));
    for seed in 0..times {
        let polygon = shape(&mut Rng::new(seed));
        let expected =
            oracle::coverage(&polygon, window, Depth::ZeroToOne, GUARD, FillRule::NonZero);
        let drawn = digits(&counts(&mut scan, &[bare(&polygon)], window), window.width);
        let wanted = expected.picture(window).replace('#', "1");
        assert_eq!(drawn.join("\n") + "\n", wanted, "seed {seed}: {polygon:?}");
    }
}

/// The guard band that the oracle clips by, in pixels; the one that the library states.
const GUARD: f64 = polyscan::project::GUARD_BAND as f64;

const MIDDLE: Window = Window { width: 37, height: 29 };

#[test]
fn triangles_are_exact() {
    agrees_with_the_oracle(MIDDLE, 300, |rng| {
        generators::random_triangle::<0>(rng, 10.0, 2.0).positions
    });
    agrees_with_the_oracle(MIDDLE, 200, generators::integer_triangle);
    agrees_with_the_oracle(MIDDLE, 200, |rng| generators::sliver(rng, MIDDLE, 0.02, 4.0));
    agrees_with_the_oracle(MIDDLE, 200, |rng| generators::far_outside(rng, MIDDLE, 15e3, 4.0));
    agrees_with_the_oracle(MIDDLE, 100, |rng| generators::far_outside(rng, MIDDLE, 1e6, 4.0));
}

#[test]
fn convex_polygons_are_exact() {
    agrees_with_the_oracle(MIDDLE, 200, |rng| {
        let sides = 3 + rng.below(10);
        generators::random_convex::<0>(rng, sides, 100.0).positions
    });
    agrees_with_the_oracle(MIDDLE, 200, |rng| generators::on_pixel_centres(rng, MIDDLE, 12));
    agrees_with_the_oracle(MIDDLE, 50, |rng| generators::surrounding(rng, MIDDLE, 7, 900.0, 9.0));
    agrees_with_the_oracle(MIDDLE, 200, |rng| {
        let sides = 3 + rng.below(10);
        generators::through_eye::<0>(rng, sides).positions
    });
}

#[test]
fn concave_and_crossed_outlines_are_exact() {
    agrees_with_the_oracle(MIDDLE, 100, |rng| generators::star(rng, MIDDLE, 7));
    agrees_with_the_oracle(MIDDLE, 100, |rng| generators::crossed_star(rng, MIDDLE, 7, 3));
    agrees_with_the_oracle(MIDDLE, 300, |rng| {
        let corners = 4 + rng.below(9);
        generators::tangle(rng, MIDDLE, corners)
    });
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
            scan.scissor = Some(part);
            let rows: Vec<_> = scan.spans(polygon).map(|span| (span.y(), span.x())).collect();
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
        let small_viewport = viewport(small).at(part.x, part.y);
        let on_large = rows(viewport(large), &in_window(0.0, 0.0, large));
        let on_small = rows(small_viewport, &in_window(137.0, 71.0, small));
        assert_eq!(on_large, on_small, "seed {seed}");
    }
}
