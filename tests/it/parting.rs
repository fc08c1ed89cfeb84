//! A plane and its opposite part a polygon: together they cover each of its pixels once.

use crate::common::generators::Rng;
use crate::common::oracle::Window;
use crate::common::{counts, in_threads, tally, viewport};
use glam::{Vec4, vec4};
use polyscan::{ClipPlane, FillRule, ScanConverter, Vertex, Viewport};

/// How often each pixel is covered by what planes leave of a polygon, each alone.
fn covered(
    polygon: &[Vertex<0>],
    planes: &[Option<Vec4>],
    rule: FillRule,
    window: Window,
) -> Vec<u32> {
    let mut sum = vec![0; (window.width * window.height) as usize];
    let mut scan = ScanConverter::new(viewport(window));
    scan.settings.fill_rule = rule;
    for plane in planes {
        scan.settings.planes = plane.iter().map(|&plane| ClipPlane::new(plane)).collect();
        let polygons = [polygon.to_vec()];
        let counts = counts(&mut scan, &polygons, window);
        sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    sum
}

/// How far the centre of a pixel is from the outline, in pixels.
fn distance_to_outline(polygon: &[Vertex<0>], pixel: [f64; 2], window: Window) -> f64 {
    let place = |v: &Vertex<0>| {
        let p = v.position.as_dvec4();
        let [width, height] = [window.width, window.height].map(f64::from);
        [(p.x / p.w + 1.0) * width / 2.0, (1.0 - p.y / p.w) * height / 2.0]
    };
    let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let distance = |(a, b): (&Vertex<0>, &Vertex<0>)| {
        let (a, b) = (place(a), place(b));
        let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [pixel[0] - a[0], pixel[1] - a[1]]);
        let along = (ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1]).max(1e-300);
        let along = along.clamp(0.0, 1.0);
        (ap[0] - along * ab[0]).hypot(ap[1] - along * ab[1])
    };
    ends.map(distance).fold(f64::INFINITY, f64::min)
}

/// The side of a pixel that rounding may move: half a subpixel in each direction, of the outline's
/// corners and of those on the plane.
const ROUNDING: f64 = std::f64::consts::SQRT_2 / 256.0;

tally! {
    struct Tally {
        polygons: u64,
        /// Polygons that the plane cuts.
        cut: u64,
        /// Those with a vertex exactly on the plane.
        touching: u64,
        pixels: u64,
        /// Pixels within rounding of the outline that one side or the other gains or loses, since the
        /// cut's ends are rounded to subpixels of their own.
        at_outline: u64,
    }
}

/// A polygon of whole numbers, all with w = 128, and a plane, through one of its vertices or along one
/// of its sides at times.
fn any(rng: &mut Rng) -> (Vec<Vertex<0>>, Vec4, Window) {
    let window = Window { width: 1 + rng.below(40) as u32, height: 1 + rng.below(40) as u32 };
    let polygon: Vec<_> = (0..3 + rng.below(5))
        .map(|_| vec4(rng.whole(-160, 160) as f32, rng.whole(-160, 160) as f32, 64.0, 128.0))
        .map(|position| Vertex::new(position, []))
        .collect();
    let most = [3, 200, 16_000][rng.below(3)];
    let a = rng.whole(1, most) * [-1, 1][rng.below(2)];
    let b = rng.whole(-most, most);
    let first = rng.below(polygon.len());
    let on = polygon[first].position;
    let (a, b) = match rng.below(4) {
        // Along a side.
        0 => {
            let next = polygon[(first + 1) % polygon.len()].position;
            ((next.y - on.y) as i64, (on.x - next.x) as i64)
        }
        _ => (a, b),
    };
    // An exact f32: a whole number of less than 2^23, over a power of two.
    let through = -(a as f64 * f64::from(on.x) + b as f64 * f64::from(on.y)) / 128.0;
    let d = if rng.once_in(2) { through } else { 0.5 + rng.whole(-most, most) as f64 };
    assert_eq!(f64::from(d as f32), d);
    (polygon, vec4(a as f32, b as f32, 0.0, d as f32), window)
}

fn check(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let (polygon, plane, window) = any(rng);
    let rule = [FillRule::NonZero, FillRule::EvenOdd][rng.below(2)];
    let whole = covered(&polygon, &[None], rule, window);
    let parts = covered(&polygon, &[Some(plane), Some(-plane)], rule, window);
    let side = |v: &Vertex<0>| v.position.as_dvec4().dot(plane.as_dvec4());
    let sides: Vec<f64> = polygon.iter().map(side).collect();
    let mut tally = Tally { polygons: 1, ..Tally::default() };
    tally.touching = u64::from(sides.contains(&0.0));
    tally.cut = u64::from(sides.iter().any(|&d| d < 0.0) && sides.iter().any(|&d| d > 0.0));
    for (pixel, (&parts, &whole)) in parts.iter().zip(&whole).enumerate() {
        let (x, y) = (pixel as u32 % window.width, pixel as u32 / window.width);
        let what = || format!("seed {seed}, pixel {x}, {y}: {polygon:?} by {plane} in {window:?}");
        assert!(parts <= 1, "{parts} times, {}", what());
        tally.pixels += u64::from(whole);
        if parts != whole {
            let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let distance = distance_to_outline(&polygon, centre, window);
            assert!(distance <= ROUNDING, "{parts} for {whole}, {distance} inside, {}", what());
            tally.at_outline += 1;
        }
    }
    tally
}

#[test]
fn a_plane_and_its_opposite_cover_each_pixel_once() {
    let tally = in_threads(0..20_000, check);
    println!("parting: {tally:?}");
    assert!(tally.cut > 8000 && tally.touching > 8000, "{tally:?}");
    assert!(tally.pixels > 1_000_000, "{tally:?}");
}

/// A polygon and planes of which an earlier version covered a pixel by both sides.
#[test]
fn a_crossing_is_the_same_from_both_sides() {
    let polygon = [(68, 116), (81, 105), (66, -15), (-32, 117), (-67, 118)]
        .map(|(a, b)| Vertex::new(vec4(a as f32, b as f32, 64.0, 128.0), []));
    let plane = vec4(1536.0, 14464.0, 0.0, -12837.0);
    let window = Window { width: 17, height: 40 };
    assert_eq!(viewport(window), Viewport::new(17, 40).expect("small"));
    for rule in [FillRule::NonZero, FillRule::EvenOdd] {
        let whole = covered(&polygon, &[None], rule, window);
        let parts = covered(&polygon, &[Some(plane), Some(-plane)], rule, window);
        assert_eq!(parts, whole);
        assert_eq!(parts[2 * 17 + 9], 1);
    }
}
