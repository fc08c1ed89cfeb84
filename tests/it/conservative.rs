//! Conservative coverage, exactly, and what is interpolated outside of polygons.

use std::collections::BTreeMap;

use crate::common::generators::Rng;
use crate::common::oracle::covers;
use crate::common::{LONG_SEED, dynamic, dynamic_mut, in_threads};
use glam::{DVec2, DVec3, vec4};
use polyscan::render::Geometry;
use polyscan::{
    CoverageRule, Cull, DepthTest, FillRule, Framebuffer, Level, Mesh, OutsidePolygon,
    PainterRenderer, ScanConverter, ScanlineRenderer, Vertex, Viewport, ZBufferRenderer,
};

const SIDE: i64 = 16;

/// A place on the screen in subpixels.
type Place = (i64, i64);

const CLAMP: CoverageRule = CoverageRule::Outer(OutsidePolygon::Clamp);
const EXTRAPOLATE: CoverageRule = CoverageRule::Outer(OutsidePolygon::Extrapolate);

/// A vertex at a place, exactly.
fn at<const N: usize>((x, y): Place, w: f32, params: [f32; N]) -> Vertex<N> {
    let unit = (SIDE * 128) as f64;
    let [x, y] = [x as f64 / unit - 1.0, 1.0 - y as f64 / unit].map(|c| c as f32);
    Vertex::new(vec4(x, y, 0.5, 1.0) * w, params)
}

fn viewport() -> Viewport {
    Viewport::new(SIDE as u32, SIDE as u32).expect("small")
}

/// The pixels of the picture in which an outline may have a part, and some around.
fn near(outline: &[Place]) -> Vec<Place> {
    let range = |axis: fn(&Place) -> i64| {
        let places = || outline.iter().map(axis);
        let (least, greatest) = (places().min().unwrap_or(0), places().max().unwrap_or(0));
        (least.div_euclid(256) - 1).max(0)..(greatest.div_euclid(256) + 2).min(SIDE)
    };
    let columns = range(|p| p.0);
    range(|p| p.1).flat_map(|y| columns.clone().map(move |x| (x, y))).collect()
}

fn edges(outline: &[Place]) -> impl Iterator<Item = (Place, Place)> {
    outline.iter().copied().zip(outline.iter().copied().cycle().skip(1)).take(outline.len())
}

/// Whether a segment has a point in the open square of a pixel: by the times at which it enters and
/// leaves the strip of the column and that of the row, as fractions.
fn passes(((ax, ay), (bx, by)): (Place, Place), (x, y): Place) -> bool {
    // Enter and leave as numerators over positive denominators.
    let (mut enter, mut leave) = (vec![], vec![]);
    for (a, b, low) in [(ax, bx, x * 256), (ay, by, y * 256)] {
        let (step, high) = (i128::from(b - a), low + 256);
        let [low, high] = [low, high].map(|bound| i128::from(bound - a));
        match step.signum() {
            0 if low < 0 && 0 < high => {}
            0 => return false,
            1 => {
                enter.push((low, step));
                leave.push((high, step));
            }
            _ => {
                enter.push((-high, -step));
                leave.push((-low, -step));
            }
        }
    }
    let less = |(a, b): (i128, i128), (c, d): (i128, i128)| a * d < c * b;
    enter.iter().all(|&e| less(e, (1, 1)) && leave.iter().all(|&l| less(e, l)))
        && leave.iter().all(|&l| less((0, 1), l))
}

/// What the rule asks of a pixel, for any outline: by its centre, and by what passes through it.
fn covered(outline: &[Place], pixel: Place, rule: CoverageRule, fill: FillRule) -> bool {
    let centre = (pixel.0 * 256 + 128, pixel.1 * 256 + 128);
    let is_inside = covers(outline, centre, oracle_rule(fill));
    let is_passed = edges(outline).any(|edge| passes(edge, pixel));
    match rule {
        CoverageRule::Centre => is_inside,
        CoverageRule::Outer(_) => is_inside || is_passed,
        CoverageRule::Inner => is_inside && !is_passed,
    }
}

fn oracle_rule(fill: FillRule) -> crate::common::oracle::FillRule {
    match fill {
        FillRule::EvenOdd => crate::common::oracle::FillRule::EvenOdd,
        _ => crate::common::oracle::FillRule::NonZero,
    }
}

/// The same for a convex outline with an area, by areas: whether what it has of the pixel's has one
/// (no line separates them: the pixel's sides and the outline's do not), or is all of it.
fn covered_area(outline: &[Place], (x, y): Place, rule: CoverageRule) -> bool {
    let corners = [(0, 0), (256, 0), (256, 256), (0, 256)].map(|(a, b)| (x * 256 + a, y * 256 + b));
    let side = |((ax, ay), (bx, by)): (Place, Place), (px, py): Place| {
        i128::from(bx - ax) * i128::from(py - ay) - i128::from(by - ay) * i128::from(px - ax)
    };
    let area: i128 = edges(outline).map(|edge| side(edge, outline[0])).sum();
    let inwards = |edge, corner| side(edge, corner) * area.signum();
    match rule {
        CoverageRule::Inner => {
            corners.iter().all(|&c| edges(outline).all(|edge| inwards(edge, c) >= 0))
        }
        _ => {
            edges(outline)
                .filter(|(a, b)| a != b)
                .all(|edge| corners.iter().any(|&c| inwards(edge, c) > 0))
                && outline.iter().any(|p| p.0 < x * 256 + 256)
                && outline.iter().any(|p| p.0 > x * 256)
                && outline.iter().any(|p| p.1 < y * 256 + 256)
                && outline.iter().any(|p| p.1 > y * 256)
        }
    }
}

fn place(rng: &mut Rng, reach: i64) -> Place {
    let unit = [1, 1, 16, 128, 128, 256][rng.below(6)];
    let [x, y] = [0; 2].map(|_| rng.whole(-reach / unit, (256 * SIDE + reach) / unit) * unit);
    (x, y)
}

/// An outline: a triangle, a sliver, any polygon that may cross itself, one without area.
fn outline(rng: &mut Rng) -> Vec<Place> {
    let reach = [300, 300, 5000][rng.below(3)];
    let count = [3, 3, 3, 4, 5, 9][rng.below(6)];
    let mut places: Vec<_> = (0..count).map(|_| place(rng, reach)).collect();
    match rng.below(6) {
        0 => {
            let (x, y) = places[0];
            let size = rng.whole(1, 700);
            for p in &mut places {
                *p = (x + rng.whole(-size, size), y + rng.whole(-size, size));
            }
        }
        1 => {
            let (a, b) = (places[0], places[1]);
            let off = rng.whole(-2, 2);
            places[2] = ((a.0 + b.0) / 2 + off, (a.1 + b.1) / 2);
        }
        _ => {}
    }
    places
}

/// The pixels of a polygon by the scan converter.
fn scanned(scan: &mut ScanConverter<0>, polygon: &[Vertex<0>]) -> BTreeMap<Place, u32> {
    let mut found = BTreeMap::new();
    for span in scan.spans(polygon) {
        for x in span.columns() {
            *found.entry((i64::from(x), i64::from(span.row()))).or_insert(0) += 1;
        }
    }
    found
}

/// Those by the z-buffer, as a mesh.
fn drawn(renderer: &mut ZBufferRenderer<0>, geometry: impl Geometry<0>) -> BTreeMap<Place, u32> {
    let mut frame = Framebuffer::new(SIDE as u32, SIDE as u32, ()).expect("small");
    let mut found = BTreeMap::new();
    renderer.on_one_thread().draw(
        &mut frame,
        geometry,
        dynamic_mut(|f| {
            *found.entry((f.x.into(), f.y.into())).or_insert(0) += 1;
        }),
    );
    found
}

fn check(seed: u64) -> u64 {
    let rng = &mut Rng::new(seed);
    let mut scan = ScanConverter::new(viewport());
    let mut renderer = ZBufferRenderer::new(viewport());
    renderer.depth_test = DepthTest::Always;
    let mut count = 0;
    for number in 0..16 {
        let outline = outline(rng);
        let polygon: Vec<_> = outline.iter().map(|&p| at(p, 1.0, [])).collect();
        let faces = [(0..polygon.len() as u32).collect::<Vec<_>>()];
        scan.settings.fill_rule = [FillRule::NonZero, FillRule::EvenOdd][rng.below(2)];
        let drawn_by = rng.below(4);
        let rules = [CLAMP, EXTRAPOLATE, CoverageRule::Inner, CoverageRule::Centre];
        for (i, rule) in rules.into_iter().enumerate() {
            scan.settings.coverage_rule = rule;
            renderer.settings = scan.settings.clone();
            let found = scanned(&mut scan, &polygon);
            let fill = scan.settings.fill_rule;
            let about = || format!("seed {seed}, {number}: {outline:?} by {rule:?}, {fill:?}");
            assert!(found.values().all(|&n| n == 1), "{}", about());
            let near = near(&outline);
            assert!(found.keys().all(|pixel| near.contains(pixel)), "{}", about());
            for pixel in near {
                let expected = covered(&outline, pixel, rule, fill);
                assert_eq!(found.contains_key(&pixel), expected, "{pixel:?}, {}", about());
                if rule != CoverageRule::Centre && outline.len() == 3 && has_area(&outline) {
                    let by_area = covered_area(&outline, pixel, rule);
                    assert_eq!(by_area, expected, "the oracles agree: {pixel:?}, {}", about());
                }
                count += u64::from(expected);
            }
            if i != drawn_by {
                continue;
            }
            assert_eq!(drawn(&mut renderer, &polygon), found, "{}", about());
            assert_eq!(drawn(&mut renderer, Mesh::new(&polygon, &faces)), found, "{}", about());
        }
    }
    count
}

fn has_area(outline: &[Place]) -> bool {
    let [(ax, ay), (bx, by), (cx, cy)] = [outline[0], outline[1], outline[2]];
    (bx - ax) * (cy - ay) != (cx - ax) * (by - ay)
}

#[test]
fn outer_and_inner_coverage_are_exact() {
    let pixels = in_threads(0..100, check);
    assert!(pixels > 100_000, "only {pixels} pixels");
}

#[test]
#[ignore = "long: 10^6 polygons by four rules, minutes"]
fn long_conservative_coverage() {
    println!("{} pixels", in_threads(LONG_SEED..LONG_SEED + 62_500, check));
}

#[test]
fn a_mesh_is_covered_by_its_faces_alike_at_every_level_and_by_other_renderers() {
    let rng = &mut Rng::new(5);
    let mut vertices = Vec::new();
    for _ in 0..100 {
        let outline: Vec<_> = (0..3).map(|_| place(rng, 1000)).collect();
        let w = [0; 3].map(|_| rng.octaves(1.0, 20.0) as f32);
        let params = || [0; 2].map(|_| rng_value(outline[0]));
        vertices.extend(outline.iter().zip(w).map(|(&p, w)| at(p, w, params())));
    }
    let faces: Vec<[u32; 3]> = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let picture = |level: Level, rule, is_mesh: bool| {
        let mut frame = Framebuffer::new(SIDE as u32, SIDE as u32, [0; 4]).expect("small");
        let mut renderer = ZBufferRenderer::<2>::new(viewport());
        renderer.settings.coverage_rule = rule;
        renderer.settings.cull = Cull::Back;
        renderer.simd_level = level;
        renderer.depth_test = DepthTest::Always;
        let color = |face: u32, f: &polyscan::Fragment<'_, 2>| {
            let [a, b] = f.params.map(f32::to_bits);
            [face, a, b, f.w.to_bits() ^ f.derivatives().0[0].to_bits()]
        };
        if is_mesh {
            renderer.draw(&mut frame, Mesh::new(&vertices, &faces), dynamic(|f| color(f.face, f)));
        } else {
            for (i, face) in (0..).zip(&faces) {
                renderer.draw(&mut frame, Mesh::new(&vertices, [face]), dynamic(|f| color(i, f)));
            }
        }
        frame
    };
    for rule in [CLAMP, EXTRAPOLATE, CoverageRule::Inner] {
        let mesh = picture(Level::new(), rule, true);
        assert!(mesh.color().iter().filter(|c| **c != [0; 4]).count() > 100);
        assert!(mesh == picture(Level::baseline(), rule, true), "{rule:?}: every level");
        assert!(mesh == picture(Level::new(), rule, false), "{rule:?}: faces alone");
    }
    // The painter's renderer has the same pixels, the scanline renderer the rule of centres.
    let polygon = &vertices[..3];
    let mut by_painter = Framebuffer::new(SIDE as u32, SIDE as u32, 0).expect("small");
    let (mut by_z_buffer, mut by_rows) = (by_painter.clone(), by_painter.clone());
    let mut painter = PainterRenderer::<2>::new(viewport());
    let mut z_buffer = ZBufferRenderer::<2>::new(viewport());
    let mut scanline = ScanlineRenderer::<2>::new(viewport());
    painter.settings.coverage_rule = CLAMP;
    z_buffer.settings.coverage_rule = CLAMP;
    scanline.settings.coverage_rule = CLAMP;
    painter.draw(&mut by_painter, polygon, dynamic(|_| 1));
    z_buffer.draw(&mut by_z_buffer, polygon, dynamic(|_| 1));
    scanline.draw(&mut by_rows, polygon, dynamic(|_| 1));
    assert!(by_painter.color() == by_z_buffer.color() && by_rows != by_z_buffer);
    z_buffer.settings.coverage_rule = CoverageRule::Centre;
    z_buffer.clear(&mut by_z_buffer, 0);
    z_buffer.draw(&mut by_z_buffer, polygon, dynamic(|_| 1));
    assert!(by_rows == by_z_buffer);
}

fn rng_value((x, y): Place) -> f32 {
    ((x * 31 + y * 17) % 101) as f32 / 101.0
}

/// A triangle with its w, whose parameters are its corners' places in space.
struct Lifted {
    outline: Vec<Place>,
    w: [f64; 3],
    corners: [DVec3; 3],
    vertices: Vec<Vertex<3>>,
}

fn lifted(rng: &mut Rng, ratio: f64) -> Lifted {
    let outline: Vec<_> = (0..3).map(|_| place(rng, 300)).collect();
    let w = [0; 3].map(|_| f64::from(rng.octaves(1.0, ratio) as f32));
    let corners =
        [0; 3].map(|_| DVec3::from_array([0; 3].map(|_| f64::from(rng.range(-1.0, 1.0) as f32))));
    let vertex = |i: usize| at(outline[i], w[i] as f32, corners[i].as_vec3().to_array());
    let vertices = (0..3).map(vertex).collect();
    Lifted { outline, w, corners, vertices }
}

impl Lifted {
    /// Where a corner is on the screen, in pixels, unrounded.
    fn screen(&self, i: usize) -> DVec2 {
        let p = self.vertices[i].position.as_dvec4();
        let half = SIDE as f64 / 2.0;
        DVec2::new(half * (1.0 + p.x / p.w), half * (1.0 - p.y / p.w))
    }

    /// The parameters at the point of an edge that is nearest to a place, and how far it is.
    fn nearest_on(&self, edge: usize, place: DVec2) -> (DVec3, f64) {
        let (i, j) = (edge, (edge + 1) % 3);
        let (a, b) = (self.screen(i), self.screen(j));
        let along = b - a;
        let t = (place - a).dot(along) / along.length_squared();
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let (p, q) = ((1.0 - t) / self.w[i], t / self.w[j]);
        let params = (self.corners[i] * p + self.corners[j] * q) / (p + q);
        (params, place.distance(a + along * t))
    }

    /// The parameters at a place by barycentric coordinates, and 1/w.
    fn extrapolated(&self, place: DVec2) -> (DVec3, f64) {
        let [a, b, c] = [0, 1, 2].map(|i| self.screen(i));
        let area = (b - a).perp_dot(c - a);
        let weights = [
            (b - place).perp_dot(c - place),
            (c - place).perp_dot(a - place),
            (a - place).perp_dot(b - place),
        ];
        let per_w = [0, 1, 2].map(|i| weights[i] / area / self.w[i]);
        let sum = per_w.iter().sum::<f64>();
        ((0..3).map(|i| self.corners[i] * per_w[i]).sum::<DVec3>() / sum, sum)
    }
}

#[test]
fn outside_of_a_polygon_values_are_those_of_its_nearest_point() {
    let (mut clamped, mut inside, mut worst) = (0, 0, 0.0f64);
    for seed in 0..1500 {
        let rng = &mut Rng::new(seed);
        let ratio = [1.0, 3.0, 1000.0][rng.below(3)];
        let triangle = lifted(rng, ratio);
        let mut scan = ScanConverter::<3>::new(viewport());
        scan.settings.coverage_rule = CLAMP;
        for span in scan.spans(&triangle.vertices) {
            for f in span.fragments() {
                let pixel = (i64::from(f.x), i64::from(f.y));
                let centre = (pixel.0 * 256 + 128, pixel.1 * 256 + 128);
                let fill = crate::common::oracle::FillRule::NonZero;
                let found = glam::Vec3::from(f.params).as_dvec3();
                if covers(&triangle.outline, centre, fill) {
                    inside += 1;
                    continue;
                }
                let place = DVec2::new(pixel.0 as f64 + 0.5, pixel.1 as f64 + 0.5);
                let passing = edges(&triangle.outline).enumerate().filter(|e| passes(e.1, pixel));
                let nearest: Vec<_> =
                    passing.map(|(edge, _)| triangle.nearest_on(edge, place)).collect();
                let least = nearest.iter().fold(f64::INFINITY, |least, n| least.min(n.1));
                // Of edges that are equally near but for rounding, either.
                let off = nearest.iter().filter(|n| n.1 < least + 0.01);
                let off = off.map(|n| (n.0 - found).abs().max_element());
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off < 1e-5, "seed {seed}, {pixel:?}: off by {off}");
                worst = worst.max(off);
                clamped += 1;
            }
        }
    }
    assert!(clamped > 10_000 && inside > 10_000, "{clamped} clamped, {inside} not, {worst:e}");
}

#[test]
fn outside_of_a_polygon_values_go_on_if_they_are_extrapolated() {
    let (mut outside, mut worst) = (0, 0.0f64);
    for seed in 0..1500 {
        let rng = &mut Rng::new(seed);
        let ratio = [1.0, 1.2, 3.0][rng.below(3)];
        let triangle = lifted(rng, ratio);
        let mut scan = ScanConverter::<3>::new(viewport());
        scan.settings.coverage_rule = EXTRAPOLATE;
        let [_, dx] = [0.0, 1.0].map(|x| triangle.extrapolated(DVec2::new(x, 0.0)).1);
        let [zero, dy] = [0.0, 1.0].map(|y| triangle.extrapolated(DVec2::new(0.0, y)).1);
        let least = triangle.w.iter().fold(f64::INFINITY, |least, w| least.min(1.0 / w));
        // Where 1/w changes much within a pixel, values keep to their range.
        let is_steep = (dx - zero).abs() + (dy - zero).abs() > 0.5 * least;
        for span in scan.spans(&triangle.vertices) {
            for f in span.fragments().filter(|_| !is_steep) {
                let place = DVec2::new(f64::from(f.x) + 0.5, f64::from(f.y) + 0.5);
                let (exact, inv_w) = triangle.extrapolated(place);
                let largest = exact.abs().max_element().max(1.0);
                // A triangle so thin that values change by thousands a pixel has no plane to speak of.
                if largest > 100.0 {
                    continue;
                }
                let off = (glam::Vec3::from(f.params).as_dvec3() - exact).abs().max_element();
                assert!(off < 1e-5 * largest, "seed {seed}: off by {off} of {exact}");
                assert!((f64::from(f.w) * inv_w - 1.0).abs() < 1e-5, "seed {seed}");
                worst = worst.max(off);
                outside += 1;
            }
        }
    }
    assert!(outside > 20_000, "{outside}, off by {worst:e}");
}
