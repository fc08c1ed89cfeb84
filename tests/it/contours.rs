//! Contracts 1, 3 and 4 for outlines of any shape: concave ones, holes, crossings, either fill rule,
//! and all of that cut by planes.
//!
//! `cargo test --profile proof --test it -- contours:: --include-ignored --nocapture` runs the long
//! versions and prints their figures.

use crate::common::generators::{self, Contours, Rng};
use crate::common::oracle::{self, Depth, Position, Window};
use crate::common::{LONG_SEED, Tally, at_pixels, bare, digits, dynamic, in_threads, viewport};
use glam::{Vec4, vec4};
use polyscan::{
    ClipPlane, Cull, FillRule, Framebuffer, Outline, ScanConverter, Vertex, ZBufferRenderer,
};

const GUARD: f64 = polyscan::viewport::GUARD_BAND as f64;
const MIDDLE: Window = Window { width: 37, height: 29 };
const RULES: [(FillRule, oracle::FillRule); 2] = [
    (FillRule::NonZero, oracle::FillRule::NonZero),
    (FillRule::EvenOdd, oracle::FillRule::EvenOdd),
];

/// How often each pixel is covered.
fn count<const N: usize>(
    scan: &mut ScanConverter<N>,
    polygon: &(impl Outline<N> + ?Sized),
    window: Window,
    counts: &mut [u32],
) {
    for span in scan.spans(polygon) {
        let row = span.row() as usize * window.width as usize;
        span.columns().for_each(|x| counts[row + x as usize] += 1);
    }
}

fn none(window: Window) -> Vec<u32> {
    vec![0; window.width as usize * window.height as usize]
}

fn picture(polygon: &[Vec<Vertex<0>>], rule: FillRule, window: Window) -> Vec<String> {
    let mut scan = ScanConverter::new(viewport(window));
    scan.settings.fill_rule = rule;
    let mut counts = none(window);
    count(&mut scan, polygon, window, &mut counts);
    digits(&counts, window.width)
}

// ---------------------------------------------------------------------------------------- pictures

const SMALL: Window = Window { width: 8, height: 6 };

fn rectangle(left: f32, top: f32, right: f32, bottom: f32) -> Vec<Vertex<0>> {
    at_pixels(&[[left, top], [right, top], [right, bottom], [left, bottom]], SMALL)
}

#[test]
fn a_hole_is_open_by_either_rule_if_it_runs_the_other_way() {
    let outer = rectangle(0.0, 0.0, 8.0, 6.0);
    let mut hole = rectangle(2.5, 1.5, 5.5, 3.5);
    let ring = ["11111111", "11...111", "11...111", "11111111", "11111111", "11111111"];
    let full = ["11111111"; 6];
    assert_eq!(picture(&[outer.clone(), hole.clone()], FillRule::NonZero, SMALL), full);
    assert_eq!(picture(&[outer.clone(), hole.clone()], FillRule::EvenOdd, SMALL), ring);
    hole.reverse();
    for rule in [FillRule::NonZero, FillRule::EvenOdd] {
        assert_eq!(picture(&[outer.clone(), hole.clone()], rule, SMALL), ring);
        assert_eq!(picture(&[hole.clone(), outer.clone()], rule, SMALL), ring);
    }
}

#[test]
fn parts_may_lie_apart_and_overlap() {
    let parts = [rectangle(0.0, 0.0, 5.0, 4.0), rectangle(3.0, 2.0, 8.0, 6.0)];
    let both = ["11111...", "11111...", "11111111", "11111111", "...11111", "...11111"];
    let either = ["11111...", "11111...", "111..111", "111..111", "...11111", "...11111"];
    assert_eq!(picture(&parts, FillRule::NonZero, SMALL), both);
    assert_eq!(picture(&parts, FillRule::EvenOdd, SMALL), either);
    let apart = [rectangle(0.0, 0.0, 2.0, 2.0), rectangle(4.0, 1.0, 6.0, 3.0)];
    for rule in [FillRule::NonZero, FillRule::EvenOdd] {
        let expected = ["11......", "11..11..", "....11..", "........", "........", "........"];
        assert_eq!(picture(&apart, rule, SMALL), expected);
    }
}

#[test]
fn a_contour_run_twice_is_no_contour_by_the_even_odd_rule() {
    let twice = [rectangle(1.0, 1.0, 7.0, 5.0).repeat(2)];
    assert_eq!(picture(&twice, FillRule::EvenOdd, SMALL), ["........"; 6]);
    let thrice = [rectangle(1.0, 1.0, 7.0, 2.0).repeat(3)];
    let expected = ["........", ".111111.", "........", "........", "........", "........"];
    assert_eq!(picture(&thrice, FillRule::EvenOdd, SMALL), expected);
}

#[test]
fn contours_of_less_than_three_vertices_bound_nothing() {
    let outer = rectangle(1.0, 1.0, 7.0, 5.0);
    let alone = picture(std::slice::from_ref(&outer), FillRule::NonZero, SMALL);
    let short = [vec![], outer[..1].to_vec(), outer[1..3].to_vec()];
    let [a, b, c] = short.clone();
    assert_eq!(picture(&[a, b, outer.clone(), c], FillRule::EvenOdd, SMALL), alone);
    assert_eq!(picture(&short, FillRule::EvenOdd, SMALL), ["........"; 6]);
    assert_eq!(picture(&[], FillRule::NonZero, SMALL), ["........"; 6]);
    // One position that is not finite takes all of the polygon away.
    let lost = vec![Vertex::new(vec4(f32::NAN, 0.0, 0.0, 1.0), [])];
    assert_eq!(picture(&[outer, lost], FillRule::NonZero, SMALL), ["........"; 6]);
}

#[test]
fn any_list_of_lists_is_an_outline() {
    let (outer, hole) = (rectangle(0.0, 0.0, 8.0, 6.0), rectangle(2.0, 2.0, 4.0, 4.0));
    let mut scan = ScanConverter::<0>::new(viewport(SMALL));
    scan.settings.fill_rule = FillRule::EvenOdd;
    let mut pixels = |n: usize, polygon: &dyn Fn(&mut ScanConverter<0>) -> usize| {
        assert_eq!(polygon(&mut scan), n);
    };
    fn sum(spans: polyscan::scan::Spans<'_, 0>) -> usize {
        spans.map(|span| span.columns().len()).sum()
    }
    pixels(44, &|scan| sum(scan.spans(&[&outer[..], &hole[..]])));
    pixels(44, &|scan| sum(scan.spans(&vec![outer.clone(), hole.clone()])));
    pixels(44, &|scan| sum(scan.spans([outer.clone(), hole.clone()].as_slice())));
    pixels(44, &|scan| sum(scan.spans(&[&outer, &hole])));
    pixels(48, &|scan| sum(scan.spans(&outer)));
    pixels(48, &|scan| sum(scan.spans(&&outer[..])));
}

#[test]
fn the_larger_contour_decides_which_side_is_seen() {
    let outer = rectangle(0.0, 0.0, 8.0, 6.0);
    let mut hole = rectangle(2.0, 2.0, 4.0, 4.0);
    for _ in 0..2 {
        hole.reverse();
        for (cull, pixels) in [(Cull::Back, 0), (Cull::Front, 44)] {
            let mut scan = ScanConverter::new(viewport(SMALL));
            scan.settings.fill_rule = FillRule::EvenOdd;
            scan.settings.cull = cull;
            let mut counts = none(SMALL);
            count(&mut scan, &[&hole[..], &outer[..]], SMALL, &mut counts);
            assert_eq!(counts.iter().sum::<u32>(), pixels);
            // And so when a plane cuts through both.
            scan.settings.planes = vec![ClipPlane::new(vec4(-1.0, 0.0, 0.0, -0.25))];
            let mut counts = none(SMALL);
            count(&mut scan, &[&hole[..], &outer[..]], SMALL, &mut counts);
            assert_eq!(counts.iter().sum::<u32>(), if pixels == 0 { 0 } else { 16 });
        }
    }
}

// ---------------------------------------------------------------------------------------- coverage

/// Up to three planes of whole coefficients.
fn some_planes(rng: &mut Rng) -> Vec<[i32; 4]> {
    (0..rng.below(4)).map(|_| std::array::from_fn(|_| rng.whole(-9, 9) as i32)).collect()
}

fn clip_planes(planes: &[[i32; 4]]) -> Vec<ClipPlane> {
    planes.iter().map(|p| ClipPlane::new(p.map(|c| c as f32).into())).collect()
}

fn exact_planes(planes: &[[i32; 4]]) -> Vec<oracle::Plane> {
    planes.iter().map(|&p| oracle::plane(p)).collect()
}

/// A planar polygon of any shape: before the eye, or through the near plane and the eye.
fn planar<const N: usize>(rng: &mut Rng) -> Contours<N> {
    let shape = generators::any_contours(rng);
    let (least, most) = match rng.below(3) {
        0 => (1.0, 1.0 + rng.octaves(0.1, 100.0)),
        // The near plane is at w = 1/2.
        1 => (rng.range(0.0, 0.4), rng.octaves(1.0, 8.0)),
        _ => (-rng.octaves(0.1, 8.0), rng.octaves(0.7, 8.0)),
    };
    generators::tilted(rng, &shape, least, most)
}

fn bare_contours(contours: &[Vec<Position>]) -> Vec<Vec<Vertex<0>>> {
    contours.iter().map(|contour| bare(contour)).collect()
}

/// Holds what is drawn of contours by either rule against a border.
fn compared(
    window: Window,
    contours: &[Vec<Position>],
    planes: &[[i32; 4]],
    border: &[oracle::Edge<oracle::Snapped>],
    seed: u64,
) -> Tally {
    let mut scan = ScanConverter::new(viewport(window));
    scan.settings.planes = clip_planes(planes);
    let mut tally = Tally { polygons: 1, ..Tally::default() };
    for (rule, exact) in RULES {
        scan.settings.fill_rule = rule;
        let mut counts = none(window);
        count(&mut scan, &bare_contours(contours), window, &mut counts);
        let expected = oracle::fill_border(border, window, exact);
        let drawn = digits(&counts, window.width).join("\n") + "\n";
        let wanted = expected.picture(window).replace('#', "1");
        assert_eq!(drawn, wanted, "{rule:?}, seed {seed}: {contours:?} {planes:?}");
        tally.pixels += counts.iter().map(|&n| u64::from(n)).sum::<u64>();
    }
    tally
}

/// Planar polygons against the oracle that clips nothing.
fn planar_coverage(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let polygon = planar::<0>(rng);
    let planes = some_planes(rng);
    let Contours { places, positions, .. } = &polygon;
    let exact = exact_planes(&planes);
    let border = oracle::planar_border(places, positions, MIDDLE, Depth::ZeroToOne, GUARD, &exact);
    border.map_or(Tally::default(), |border| compared(MIDDLE, positions, &planes, &border, seed))
}

/// Polygons whose vertices have each a w of its own, and no plane.
fn coverage_without_a_plane(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let shape = |rng: &mut Rng| match rng.below(3) {
        0 => generators::star(rng, MIDDLE, 7),
        1 => generators::crossed_star(rng, MIDDLE, 7, 3),
        _ => {
            let corners = 4 + rng.below(12);
            generators::tangle(rng, MIDDLE, corners)
        }
    };
    let contours: Vec<_> = (0..1 + rng.below(3)).map(|_| shape(rng)).collect();
    let planes = some_planes(rng);
    let exact = exact_planes(&planes);
    let border = oracle::border(&contours, MIDDLE, Depth::ZeroToOne, GUARD, &exact);
    compared(MIDDLE, &contours, &planes, &border, seed)
}

#[test]
fn planar_outlines_of_any_shape_are_exact() {
    let tally = in_threads(0..600, planar_coverage);
    assert!(tally.polygons > 400, "{tally}");
}

#[test]
fn outlines_without_a_plane_are_exact() {
    in_threads(0..300, coverage_without_a_plane);
}

/// Combs cut across their teeth: along the plane, between the teeth, nothing may be left.
fn combs(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let comb = [generators::comb(rng)];
    let w_ratio = 1.0 + rng.octaves(0.1, 10.0);
    let Contours { places, positions, .. } = generators::tilted::<0>(rng, &comb, 1.0, w_ratio);
    // Through the middle of the screen, or a little beside it.
    let mut whole = |most: i64| rng.whole(-most, most) as i32;
    let planes = [[whole(99), whole(99), 0, whole(30)]];
    let exact = exact_planes(&planes);
    let border = oracle::planar_border(&places, &positions, LARGE, Depth::ZeroToOne, GUARD, &exact);
    border.map_or(Tally::default(), |border| compared(LARGE, &positions, &planes, &border, seed))
}

#[test]
fn between_the_teeth_of_a_comb_nothing_is_left() {
    in_threads(0..150, combs);
}

const SQUARE: Window = Window { width: 32, height: 32 };

/// Contours of horizontal and vertical edges between whole pixels, cut along whole rows, columns
/// and diagonals, so that vertices and edges often lie on the planes and several contours share
/// them. Nothing is rounded: what is cut has to be exactly the uncut on one side.
fn on_the_planes(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let contour = |rng: &mut Rng| {
        let corners = 2 + rng.below(5);
        let places: Vec<[f32; 2]> =
            (0..corners).map(|_| [0; 2].map(|_| 2.0 * rng.whole(2, 14) as f32)).collect();
        // Along the row to the next column, and down that to the next row.
        let next = places.iter().cycle().skip(1);
        places.iter().zip(next).flat_map(|(p, q)| [*p, [q[0], p[1]]]).collect::<Vec<_>>()
    };
    let contours: Vec<_> =
        (0..1 + rng.below(3)).map(|_| at_pixels(&contour(rng), SQUARE)).collect();
    // a x + b y + c >= 0 in pixels.
    let sides: Vec<[i64; 3]> = (0..1 + rng.below(3))
        .map(|_| {
            let [a, b] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]]
                [rng.below(8)];
            [a, b, -(2 * rng.whole(4, 12) * (a + b) + 2 * rng.whole(-2, 2))]
        })
        .collect();
    let mut scan = ScanConverter::new(viewport(SQUARE));
    let mut tally = Tally { polygons: 1, ..Tally::default() };
    for (rule, _) in RULES {
        scan.settings.fill_rule = rule;
        scan.settings.planes.clear();
        let mut whole = none(SQUARE);
        count(&mut scan, &contours, SQUARE, &mut whole);
        // x = 16 (X + 1) and y = 16 (1 - Y) in normalized device coordinates.
        let plane = |&[a, b, c]: &[i64; 3]| {
            let [x, y, w] = [16 * a, -16 * b, 16 * (a + b) + c].map(|c| c as f32);
            ClipPlane::new(vec4(x, y, 0.0, w))
        };
        scan.settings.planes = sides.iter().map(plane).collect();
        let mut cut = none(SQUARE);
        count(&mut scan, &contours, SQUARE, &mut cut);
        for (i, (&whole, &cut)) in whole.iter().zip(&cut).enumerate() {
            let (x, y) = (i as i64 % 32, i as i64 / 32);
            // At the centre, twice. One on a diagonal belongs to what is on its right.
            let is_inside = |&[a, b, c]: &[i64; 3]| {
                let side = a * (2 * x + 1) + b * (2 * y + 1) + 2 * c;
                side > 0 || side == 0 && a > 0
            };
            let expected = whole * u32::from(sides.iter().all(is_inside));
            assert_eq!(
                cut, expected,
                "({x}, {y}) by {rule:?}, seed {seed}: {sides:?} {contours:?}"
            );
            tally.pixels += u64::from(cut);
        }
    }
    tally
}

#[test]
fn vertices_and_edges_on_planes_are_exact() {
    in_threads(0..3000, on_the_planes);
}

// ------------------------------------------------------------------------------------ shared edges

const LARGE: Window = Window { width: 160, height: 120 };

/// A polygon around the window with holes, and what fills the holes, on one plane: together they
/// cover each pixel once. Planes cut them, and the pieces on all sides of them are drawn.
fn holes_and_their_fillings(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let holes = generators::any_contours(rng);
    // The window's corners, 1.2 |s| = 1.2 |t| = w, are at |s| <= 1 / 0.8, within the outer square.
    let tilt = [0; 2].map(|_| rng.range(-0.2, 0.2));
    let vertex = |p: &[f64; 2]| {
        let w = 1.0 + tilt[0] * p[0] + tilt[1] * p[1];
        let position = [1.2 * p[0], 1.2 * p[1], 0.5 * w, w].map(|c| c as f32);
        Vertex::new(Vec4::from(position), [])
    };
    let outer = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
    // By the even-odd rule the outer square takes what the holes leave, whatever they are.
    let holes: Vec<Vec<Vertex<0>>> =
        holes.iter().map(|hole| hole.iter().map(vertex).collect()).collect();
    let around: Vec<_> =
        std::iter::once(outer.iter().map(vertex).collect()).chain(holes.iter().cloned()).collect();
    let planes: Vec<Vec4> = (0..rng.below(4))
        .map(|_| {
            let [a, b, c, d] = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
            vec4(a, b, c, 0.4 * d - 0.5 * c)
        })
        .collect();
    let mut scan = ScanConverter::new(viewport(LARGE));
    scan.settings.fill_rule = FillRule::EvenOdd;
    let mut counts = none(LARGE);
    for sides in 0..1usize << planes.len() {
        let side = |(i, &plane): (usize, &Vec4)| {
            ClipPlane::new(if sides >> i & 1 == 0 { plane } else { -plane })
        };
        scan.settings.planes = planes.iter().enumerate().map(side).collect();
        count(&mut scan, &around, LARGE, &mut counts);
        count(&mut scan, &holes, LARGE, &mut counts);
    }
    let wrong = counts.iter().filter(|&&n| n != 1).count();
    assert_eq!(wrong, 0, "seed {seed}: {planes:?}");
    Tally { polygons: 2 << planes.len(), pixels: counts.len() as u64, ..Tally::default() }
}

/// The same in perspective through the near plane and the eye, one side of it: no pixel is covered
/// twice, and together they cover what the square covers without a hole, but for pixels along the
/// near plane, where holes have vertices that the square has not.
fn holes_through_the_eye(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let mut shape = generators::any_contours(rng);
    shape.iter_mut().flatten().for_each(|p| *p = p.map(|c| 0.7 * c));
    shape.insert(0, vec![[-0.75, -0.75], [0.75, -0.75], [0.75, 0.75], [-0.75, 0.75]]);
    let (least, most) = (-rng.octaves(0.1, 4.0), rng.octaves(0.7, 8.0));
    let polygon = bare_contours(&generators::tilted::<0>(rng, &shape, least, most).positions);
    let mut scan = ScanConverter::new(viewport(LARGE));
    scan.settings.fill_rule = FillRule::EvenOdd;
    let (mut whole, mut parts) = (none(LARGE), none(LARGE));
    count(&mut scan, &polygon[0], LARGE, &mut whole);
    count(&mut scan, &polygon, LARGE, &mut parts);
    count(&mut scan, &polygon[1..], LARGE, &mut parts);
    let mut tally = Tally { polygons: 2, ..Tally::default() };
    let width = LARGE.width as usize;
    for (i, &n) in parts.iter().enumerate() {
        assert!(n <= 1, "seed {seed}: pixel {i} is covered {n} times");
        let (x, y) = (i % width, i / width);
        let is_inner = (1..width - 1).contains(&x) && (1..LARGE.height as usize - 1).contains(&y);
        let around = [0, 1, 2].map(|row| (i + row * width).wrapping_sub(width + 1));
        if is_inner && around.iter().all(|&start| whole[start..start + 3] == [1; 3]) {
            assert_eq!(n, 1, "seed {seed}: pixel {i} is not covered");
        }
        tally.pixels += u64::from(n);
    }
    tally
}

#[test]
fn holes_and_their_fillings_cover_each_pixel_once() {
    in_threads(0..300, holes_and_their_fillings);
}

#[test]
fn holes_and_their_fillings_through_the_eye_cover_no_pixel_twice() {
    in_threads(0..300, holes_through_the_eye);
}

#[test]
#[ignore = "long: minutes in release"]
fn long_contours() {
    type Kind = (&'static str, fn(u64) -> Tally, u64);
    let kinds: [Kind; 7] = [
        ("combs, by either rule", combs, 2_000),
        ("concave faces of meshes, by either rule", mesh_coverage, 10_000),
        ("planar outlines, by either rule", planar_coverage, 20_000),
        ("outlines without a plane, by either rule", coverage_without_a_plane, 10_000),
        ("vertices and edges on planes, by either rule", on_the_planes, 200_000),
        ("holes and their fillings", holes_and_their_fillings, 10_000),
        ("holes and their fillings through the eye", holes_through_the_eye, 20_000),
    ];
    for (name, kind, seeds) in kinds {
        println!("{name}: {}", in_threads(LONG_SEED..LONG_SEED + seeds, kind));
    }
}

// -------------------------------------------------------------------------------------- parameters

/// The largest error of the parameters of a planar polygon, as a part of the largest parameter, and
/// the fragments looked at.
fn parameter_error(seed: u64) -> (f64, usize) {
    let rng = &mut Rng::new(seed);
    let polygon = planar::<3>(rng);
    let (positions, parameters) = (polygon.positions.concat(), polygon.parameters.concat());
    let Some(triple) = oracle::best_triple(&positions) else { return (0.0, 0) };
    let vertices: Vec<Vec<Vertex<3>>> = polygon
        .positions
        .iter()
        .zip(&polygon.parameters)
        .map(|(p, r)| p.iter().zip(r).map(|(&p, &r)| Vertex::new(p.into(), r)).collect())
        .collect();
    let mut scan = ScanConverter::new(viewport(MIDDLE));
    scan.settings.fill_rule = RULES[rng.below(2)].0;
    scan.settings.planes = clip_planes(&some_planes(rng));
    let largest = |i: usize| parameters.iter().map(|r| f64::from(r[i].abs())).fold(0.0, f64::max);
    let (mut worst, mut seen) = (0.0f64, 0);
    for span in scan.spans(&vertices) {
        for fragment in span.fragments() {
            let centre = [fragment.x, fragment.y].map(|c| f64::from(c) + 0.5);
            let Some(exact) = oracle::sample(&positions, &parameters, triple, MIDDLE, centre)
            else {
                continue;
            };
            // A centre just outside the unrounded outline may be out of the plane's range.
            if exact.w < 0.5 {
                continue;
            }
            for (i, value) in exact.values.iter().enumerate() {
                let off = (f64::from(fragment.params[i]) - value).abs();
                worst = worst.max(off / largest(i).max(1e-9));
            }
            seen += 1;
        }
    }
    (worst, seen)
}

#[test]
fn parameters_lie_on_the_plane_of_all_contours() {
    let mut all = 0;
    for seed in 0..2000 {
        let (worst, seen) = parameter_error(seed);
        assert!(worst <= 1e-5, "seed {seed}: {worst}");
        all += seen;
    }
    assert!(all > 50_000, "{all} fragments");
}

#[test]
fn flat_parameters_are_those_of_the_first_vertex() {
    let square = |size: f32, value: f32| {
        [[-size, -size], [size, -size], [size, size], [-size, size]]
            .map(|[x, y]| Vertex::new(vec4(x, y, 0.5, 1.0), [value]))
    };
    let mut scan = ScanConverter::new(viewport(SMALL));
    scan.settings.interpolation = [polyscan::Interpolation::Flat];
    scan.settings.fill_rule = FillRule::EvenOdd;
    for planes in [vec![], vec![ClipPlane::new(vec4(1.0, 0.3, 0.0, 0.0))]] {
        scan.settings.planes = planes;
        let mut seen = 0;
        for span in scan.spans(&[square(1.0, 7.0), square(0.5, 3.0)]) {
            span.fragments().for_each(|fragment| assert_eq!(fragment.params, [7.0]));
            seen += 1;
        }
        assert!(seen > 0);
    }
}

/// Values that lie on no plane go along the edges of their own contour, and stay in range.
#[test]
fn values_without_a_plane_keep_their_range() {
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        let polygon = planar::<1>(rng);
        let vertices: Vec<Vec<Vertex<1>>> = polygon
            .positions
            .iter()
            .map(|p| {
                p.iter().map(|&p| Vertex::new(p.into(), [rng.range(2.0, 3.0) as f32])).collect()
            })
            .collect();
        let mut scan = ScanConverter::new(viewport(MIDDLE));
        scan.settings.fill_rule = FillRule::EvenOdd;
        scan.settings.planes = clip_planes(&some_planes(rng));
        for fragment in scan.spans(&vertices).flat_map(|span| {
            span.fragments().map(|fragment| fragment.params[0]).collect::<Vec<_>>()
        }) {
            assert!((1.99999..3.00001).contains(&fragment), "{fragment}, seed {seed}");
        }
    }
}

// ------------------------------------------------------------------------------------------ meshes

/// A prism over a concave polygon: two n-gons and the sides between, in perspective.
fn prism(rng: &mut Rng) -> (Vec<Vertex<2>>, Vec<Vec<u32>>) {
    let base = loop {
        let contours = generators::any_contours(rng);
        if contours.len() == 1 {
            break contours.concat();
        }
    };
    let sides = base.len() as u32;
    let shift: [f64; 4] = std::array::from_fn(|_| rng.range(-0.5, 0.5));
    let vertices = [0.0, 1.0].iter().flat_map(|&height| {
        base.iter().map(move |[s, t]| {
            // Before, at and behind the eye.
            let w = 0.6 + 0.8 * t + height * (0.5 + shift[0]) + shift[1] * s;
            let (x, y) = (s + shift[2] * height, 0.7 * t + (0.6 + shift[3]) * height - 0.3);
            let position = [x, y, w - 0.3, w].map(|c| c as f32);
            Vertex::new(Vec4::from(position), [*s as f32, *t as f32])
        })
    });
    let mut faces = vec![(0..sides).collect::<Vec<_>>(), (sides..2 * sides).rev().collect()];
    faces.extend((0..sides).map(|i| {
        let j = (i + 1) % sides;
        vec![i, i + sides, j + sides, j]
    }));
    (vertices.collect(), faces)
}

#[test]
fn meshes_of_concave_faces_are_drawn_like_their_faces() {
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        let (vertices, faces) = prism(rng);
        let frame = || Framebuffer::new(90, 70, [0.0f32; 3]).expect("a small frame");
        let (mut one_by_one, mut at_once) = (frame(), frame());
        let mut renderer = ZBufferRenderer::new(one_by_one.viewport());
        renderer.settings.fill_rule = RULES[rng.below(2)].0;
        renderer.settings.cull = [Cull::None, Cull::Back, Cull::Front][rng.below(3)];
        renderer.settings.planes = clip_planes(&some_planes(rng));
        for face in &faces {
            let polygon: Vec<_> = face.iter().map(|&i| vertices[i as usize]).collect();
            renderer.draw(&mut one_by_one, &polygon, dynamic(|f| [f.params[0], f.params[1], f.w]));
        }
        renderer.draw(
            &mut at_once,
            polyscan::Mesh::new(&vertices, &faces),
            dynamic(|f| [f.params[0], f.params[1], f.w]),
        );
        assert!(one_by_one.color() == at_once.color(), "seed {seed}");
        assert!(one_by_one.depth() == at_once.depth(), "seed {seed}");
    }
}

/// The n-gons of a mesh against the oracle.
fn mesh_coverage(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let polygon = planar::<0>(rng);
    let contour = &polygon.positions[0];
    let planes = some_planes(rng);
    let exact = exact_planes(&planes);
    let border = oracle::border(&polygon.positions[..1], MIDDLE, Depth::ZeroToOne, GUARD, &exact);
    let mut frame = Framebuffer::new(MIDDLE.width, MIDDLE.height, 0u32).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.settings.planes = clip_planes(&planes);
    let face: Vec<u32> = (0..contour.len() as u32).collect();
    let mut tally = Tally { polygons: 1, ..Tally::default() };
    for (rule, exact) in RULES {
        renderer.settings.fill_rule = rule;
        frame.clear(0, 1.0);
        renderer.draw(&mut frame, polyscan::Mesh::new(&bare(contour), [&face]), dynamic(|_| 1));
        let expected = oracle::fill_border(&border, MIDDLE, exact);
        let drawn = digits(frame.color(), MIDDLE.width).join("\n") + "\n";
        assert_eq!(drawn, expected.picture(MIDDLE).replace('#', "1"), "{rule:?}, seed {seed}");
        tally.pixels += expected.count() as u64;
    }
    tally
}

#[test]
fn concave_faces_of_meshes_are_exact() {
    in_threads(0..300, mesh_coverage);
}
