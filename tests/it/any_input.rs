//! Contract 3: any input is safe, and fragments keep to the range of their polygon.

use crate::common::generators::{Rng, number};
use crate::common::{LONG_SEED, dynamic, in_threads};
use glam::{Vec4, vec4};
use polyscan::render::{
    AreaOrder, AreaRenderer, Cap, Join, MultisampleFramebuffer, MultisampleRenderer, Product,
    Samples, Visibility, VisibilityRenderer,
};
use polyscan::{
    ClipPlane, ClipSpace, CoverageRule, Cull, DepthMode, DepthTest, FillRule, Framebuffer,
    Interpolation, Lines, Mesh, OutsidePolygon, Points, Rect, ScanConverter, Vertex, Viewport,
    ZBufferRenderer,
};

fn polygon<const N: usize>(rng: &mut Rng) -> Vec<Vertex<N>> {
    let sides = if rng.once_in(50) { rng.below(300) } else { rng.below(8) };
    let oddness = [3, 6, 20, 60][rng.below(4)];
    let vertex = |rng: &mut Rng| {
        let position = Vec4::from_array(std::array::from_fn(|_| number(rng, oddness)));
        Vertex::new(position, std::array::from_fn(|_| number(rng, oddness)))
    };
    let mut polygon: Vec<_> = (0..sides).map(|_| vertex(rng)).collect();
    if rng.once_in(3) && !polygon.is_empty() {
        // All w alike.
        let w = polygon[0].position.w;
        polygon.iter_mut().for_each(|v| v.position.w = w);
    }
    polygon
}

fn viewport(rng: &mut Rng) -> Viewport {
    let side = |rng: &mut Rng| [0, 1, 2, 7, 64, 65_536][rng.below(6)];
    let (width, height) = (side(rng), if rng.once_in(20) { 65_536 } else { side(rng).min(64) });
    let viewport = Viewport::new(width, height).expect("at most 65536");
    if rng.once_in(2) {
        viewport
    } else {
        viewport.with_corner(rng.bits() as i32, rng.bits() as i32)
    }
}

fn scan<const N: usize>(rng: &mut Rng) -> ScanConverter<N> {
    let mut scan = ScanConverter::new(viewport(rng));
    let any = |rng: &mut Rng| rng.bits() as u32;
    if rng.once_in(3) {
        let [x, y, width, height] = std::array::from_fn(|_| any(rng));
        scan.settings.scissor = Some(Rect { x: x as i32, y: y as i32, width, height });
    }
    scan.settings.clip_space = [ClipSpace::ZeroToOne, ClipSpace::MinusOneToOne][rng.below(2)];
    scan.settings.cull = [Cull::None, Cull::Back, Cull::Front][rng.below(3)];
    scan.settings.fill_rule = [FillRule::NonZero, FillRule::EvenOdd][rng.below(2)];
    scan.settings.interpolation = std::array::from_fn(|_| {
        [Interpolation::Perspective, Interpolation::Linear, Interpolation::Flat][rng.below(3)]
    });
    if rng.once_in(4) {
        let plane = |rng: &mut Rng| {
            ClipPlane::new(Vec4::from_array(std::array::from_fn(|_| number(rng, 6))))
        };
        scan.settings.planes = (0..rng.below(40)).map(|_| plane(rng)).collect();
    }
    scan
}

/// Draws a polygon and checks what may be said of any fragment. Returns the number of fragments that
/// were checked, which is at most `fragments`.
fn check<const N: usize>(
    scan: &mut ScanConverter<N>,
    polygon: &[Vertex<N>],
    fragments: usize,
) -> u64 {
    check_contours(scan, &[polygon], fragments)
}

/// The same of several contours.
fn check_contours<const N: usize, C: polyscan::outline::Contour<N> + std::fmt::Debug>(
    scan: &mut ScanConverter<N>,
    polygon: &[C],
    fragments: usize,
) -> u64 {
    let rect = scan.settings.viewport.rect();
    let vertices = || polygon.iter().flat_map(polyscan::outline::Contour::vertices);
    let w = vertices().map(|v| v.position.w);
    let w_range = (w.clone().fold(f32::MAX, f32::min), w.fold(f32::MIN, f32::max));
    // Planes may be anything here, and a plane of infinities cuts nowhere in particular.
    let is_finite =
        scan.settings.planes.is_empty() && vertices().flat_map(|v| v.params).all(f32::is_finite);
    let mut left = fragments;
    for span in scan.spans(polygon) {
        let (x, y) = (span.columns(), span.row());
        assert!(!x.is_empty(), "an empty span");
        let inside = |pixel: i32, start: i32, size: u32| {
            pixel >= start && i64::from(pixel) < i64::from(start) + i64::from(size)
        };
        assert!(inside(x.start, rect.x, rect.width) && inside(x.end - 1, rect.x, rect.width));
        assert!(inside(y, rect.y, rect.height));
        for fragment in span.fragments().take(left.min(40)) {
            assert!(x.contains(&fragment.x) && fragment.y == y);
            assert!((0.0..=1.0).contains(&fragment.depth), "depth {}", fragment.depth);
            assert!(
                fragment.w > 0.0 && fragment.w >= w_range.0 && fragment.w <= w_range.1,
                "w {} of {w_range:?} in {polygon:?}",
                fragment.w
            );
            let params = fragment.params;
            assert!(!is_finite || !params.iter().any(|r| r.is_nan()), "{params:?} in {polygon:?}");
            // Each parameter but the last divided by the last, and by one that is not there.
            let last = N.wrapping_sub(1);
            let quotients = fragment.divided([0], last).into_iter().flatten();
            let slopes = fragment.divided_derivatives([0], last).into_iter().flatten().flatten();
            let is_nan = quotients.chain(slopes).any(f32::is_nan);
            assert!(!is_finite || !is_nan, "a cluster of {polygon:?}");
            assert_eq!(fragment.divided([0], N), None);
            left -= 1;
        }
        let _ = span.fragments().next().map(|fragment| fragment.derivatives());
    }
    (fragments - left) as u64
}

/// Anything: odd positions and parameters, viewports, scissors, planes. Returns the number of
/// fragments.
fn anything(seed: u64) -> u64 {
    let rng = &mut Rng::new(seed);
    let one_by_one = check::<2>(&mut scan(rng), &polygon(rng), 300)
        + check::<0>(&mut scan(rng), &polygon(rng), 300)
        + check::<5>(&mut scan(rng), &polygon(rng), 300);
    let contours: Vec<_> = (0..rng.below(5)).map(|_| polygon::<2>(rng)).collect();
    one_by_one + check_contours(&mut scan(rng), &contours, 300)
}

#[test]
fn nothing_panics_and_fragments_keep_their_range() {
    let fragments: u64 = (0..4000).map(anything).sum();
    assert!(fragments > 40_000, "only {fragments} fragments were checked");
}

/// A polygon about the middle of the screen, of usual directions, whose w are on the verge of what
/// is drawn, and whose parameters are on the verge of f32.
fn verge(rng: &mut Rng) -> Vec<Vertex<2>> {
    const W: [f32; 10] =
        [0.0, -0.0, 1e-45, 1e-40, 1.1754942e-38, f32::MIN_POSITIVE, 2e-38, 1e-37, 1.0, f32::MAX];
    let [near, far] = [W[rng.below(10)], W[rng.below(10)]];
    let size = if rng.once_in(2) { 1.0 } else { 0.01 };
    let vertex = |rng: &mut Rng| {
        let w = if rng.once_in(2) { near } else { far };
        let [x, y] = [0; 2].map(|_| size * rng.range(-1.0, 1.0) as f32);
        let params = [0; 2].map(|_| [f32::MAX, f32::MIN, 3e38, 1e-45, 1.0][rng.below(5)]);
        Vertex::new(vec4(x * w, y * w, 0.5 * w, w), params)
    };
    (0..3 + rng.below(3)).map(|_| vertex(rng)).collect()
}

/// The same for what lies on the verge.
fn anything_on_the_verge(seed: u64) -> u64 {
    let rng = &mut Rng::new(seed);
    let polygon = verge(rng);
    let [width, height] = [0; 2].map(|_| [0, 1, 3, 50, 65_536][rng.below(5)]);
    let mut scan = ScanConverter::new(Viewport::new(width, height).expect("at most 65536"));
    scan.settings.interpolation = [Interpolation::Perspective, Interpolation::Linear];
    // A window into the middle, where all of it is.
    let corner = |size: u32| (size / 2).saturating_sub(10) as i32;
    scan.settings.scissor =
        Some(Rect { x: corner(width), y: corner(height), width: 20, height: 20 });
    check(&mut scan, &polygon, 1000)
}

#[test]
fn positions_and_parameters_on_the_verge_keep_their_range() {
    let fragments: u64 = (0..10_000).map(anything_on_the_verge).sum();
    assert!(fragments > 40_000, "only {fragments} fragments were checked");
}

#[test]
#[ignore = "long: a minute in release"]
fn long_any_input() {
    let (any, verge) = (200_000, 1_000_000);
    let fragments_of = |test: fn(u64) -> u64, seeds: u64| {
        let fragments = in_threads(LONG_SEED..LONG_SEED + seeds, test);
        assert!(fragments > 4 * seeds, "only {fragments} fragments were checked");
        fragments
    };
    println!("{} polygons of any input, {} fragments", 4 * any, fragments_of(anything, any));
    println!("{verge} on the verge, {} fragments", fragments_of(anything_on_the_verge, verge));
}

#[test]
fn w_stays_in_its_range_where_clipping_leaves_less_than_f32_can_tell_apart() {
    // The guard band leaves an edge whose w are both 1.883726 in f32, but not in f64; and no v in
    // f32 has 1 / v there.
    let polygon = [
        [0.5572991, -4.7557986e31, 1.4367645, 1.491164],
        [1.9266688, -0.023565268, -0.70754766, -2212221.8],
        [-1.1031615e18, -0.54762924, 1.8517627, 0.9812155],
        [1.647419, -0.06297093, 1.0388434, 1.883726],
    ]
    .map(|p: [f32; 4]| Vertex::new(p.into(), []));
    let mut fragments = 0;
    for size in [1, 2, 7, 64] {
        for clip_space in [ClipSpace::ZeroToOne, ClipSpace::MinusOneToOne] {
            let mut scan = ScanConverter::<0>::new(Viewport::new(size, size).expect("small"));
            scan.settings.clip_space = clip_space;
            fragments += check(&mut scan, &polygon, 5000);
        }
    }
    assert!(fragments > 1000, "only {fragments} fragments were checked");
}

#[test]
fn parameters_of_any_size_near_the_eye_stay_finite() {
    for w in [1e-37, 1e-20, 1.0, 1e20, 1e37] {
        let corners = [(-1.0, -1.0, 1.0), (1.0, -1.0, 1.5), (0.0, 1.0, 3.0)];
        let triangle =
            corners.map(|(x, y, k)| Vertex::new(vec4(x, y, 0.5, 1.0) * (w * k), [1e37, -1e37 * k]));
        let mut scan = ScanConverter::new(Viewport::new(16, 16).expect("small"));
        let mut seen = 0;
        for span in scan.spans(&triangle) {
            for f in span.fragments() {
                assert!((f.params[0] / 1e37 - 1.0).abs() < 1e-6, "{} at w {w}", f.params[0]);
                assert!((f.params[1] / -1e37 - f.w / w).abs() < 1e-5, "{} at w {w}", f.params[1]);
                seen += 1;
            }
        }
        assert!(seen > 100);
    }
}

/// Faces of few vertices, of vertices that are not there, and of one vertex.
fn odd_faces() -> [Vec<u32>; 5] {
    [vec![], vec![0, 1], vec![0, 1, 2], vec![2, 1, 9_999_999], vec![3, 3, 3, 3]]
}

fn small_size(rng: &mut Rng) -> (u32, u32) {
    (rng.below(40) as u32, rng.below(30) as u32)
}

fn any_samples(rng: &mut Rng) -> Samples {
    [Samples::Four, Samples::Eight, Samples::Sixteen][rng.below(3)]
}

#[test]
fn areas_take_anything_and_white_stays_white() {
    let mut covered = 0;
    for seed in 0..1000 {
        let rng = &mut Rng::new(seed);
        let (width, height) = small_size(rng);
        let mut frame = Framebuffer::new(width, height, Vec4::ZERO).expect("a small frame");
        let mut renderer = AreaRenderer::<2>::new(frame.viewport());
        if rng.once_in(2) {
            renderer.settings = scan(rng).settings;
        }
        renderer.order = [AreaOrder::BackToFront, AreaOrder::FrontToBack][rng.below(2)];
        for _ in 0..4 {
            let polygon = polygon(rng);
            renderer.draw(&mut frame, &polygon, |_| Vec4::ONE);
            renderer.draw_mesh(&mut frame, Mesh::new(&polygon, &odd_faces()), |_| Vec4::ONE);
        }
        // White that covers a part is a part of white.
        for color in frame.color() {
            let off = (*color - Vec4::splat(color.w)).abs().max_element();
            assert!((0.0..1.000_01).contains(&color.w) && off < 1e-5, "seed {seed}: {color}");
            covered += u32::from(color.w > 0.0);
        }
    }
    assert!(covered > 10_000, "{covered}");
}

#[test]
fn samples_and_visibility_take_anything() {
    let (mut drawn, mut seen) = (0, 0);
    for seed in 0..1000 {
        let rng = &mut Rng::new(seed);
        let ((width, height), samples) = (small_size(rng), any_samples(rng));
        let mut frame =
            MultisampleFramebuffer::new(width, height, samples, 7u8).expect("a small frame");
        let mut renderer = MultisampleRenderer::<2>::new(frame.viewport());
        let mut visibility = VisibilityRenderer::new(frame.viewport());
        if rng.once_in(2) {
            renderer.settings = scan(rng).settings;
        }
        let products = [Product::W, Product::Barycentrics, Product::Corners, Product::Derivatives];
        let mut found =
            Visibility::with_samples(width, height, samples, &products).expect("a small buffer");
        for _ in 0..4 {
            let polygon = polygon(rng);
            let mesh = Mesh::new(&polygon, odd_faces());
            renderer.draw(&mut frame, &polygon, dynamic(|f| (f.params[0] < 0.5).then_some(1)));
            renderer.draw(&mut frame, mesh.clone(), dynamic(|_| 2));
            visibility.draw(&mut found, mesh);
            let shown = found.face.iter().zip(&found.barycentrics);
            for (_, weights) in shown.filter(|(face, _)| **face != Visibility::NO_FACE) {
                let sum: f32 = weights.iter().sum();
                assert!(weights.iter().all(|weight| *weight >= 0.0), "seed {seed}: {weights:?}");
                assert!((sum - 1.0).abs() < 1e-5, "seed {seed}: {weights:?}");
                seen += 1;
            }
        }
        for pixel in 0..width * height {
            for sample in 0..samples.count() {
                let color = frame.sample(pixel % width, pixel / width, sample);
                let color = color.expect("a sample of the frame").0;
                assert!([1, 2, 7].contains(&color), "seed {seed}: {color}");
                drawn += u32::from(color != 7);
            }
        }
    }
    assert!(drawn > 10_000 && seen > 10_000, "{drawn} {seen}");
}

#[test]
fn the_renderer_takes_anything_and_stays_on_the_framebuffer() {
    for seed in 0..2000 {
        let rng = &mut Rng::new(seed);
        let mut frame = Framebuffer::new(rng.below(40) as u32, rng.below(30) as u32, 7u8)
            .expect("a small frame");
        let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
        if rng.once_in(2) {
            renderer.settings = scan(rng).settings;
        }
        renderer.depth_test =
            [DepthTest::Nearer, DepthTest::Always, DepthTest::FartherOrEqual][rng.below(3)];
        renderer.settings.depth =
            [DepthMode::Standard, DepthMode::Reversed, DepthMode::InverseW][rng.below(3)];
        for _ in 0..4 {
            let polygon = polygon(rng);
            renderer.draw(&mut frame, &polygon, dynamic(|f| (f.params[0] < 0.5).then_some(1)));
            renderer.draw_depth(&mut frame, &polygon);
            renderer.draw(
                &mut frame,
                &[&polygon[..], &polygon[polygon.len() / 2..]],
                dynamic(|_| 1),
            );
        }
        let faces = odd_faces();
        renderer.draw(&mut frame, Mesh::new(&polygon(rng), &faces), dynamic(|_| 2));
        renderer.settings.coverage_rule = [
            CoverageRule::Outer(OutsidePolygon::Clamp),
            CoverageRule::Outer(OutsidePolygon::Extrapolate),
            CoverageRule::Inner,
        ][rng.below(3)];
        for _ in 0..2 {
            let polygon = polygon(rng);
            renderer.draw(&mut frame, &polygon, dynamic(|f| (f.params[0] < 0.5).then_some(1)));
            renderer.draw(
                &mut frame,
                &[&polygon[..], &polygon[polygon.len() / 2..]],
                dynamic(|_| 1),
            );
            renderer.draw(&mut frame, Mesh::new(&polygon, &faces), dynamic(|_| 2));
        }
        strokes(rng, &mut renderer, &mut frame, &faces);
        assert!(frame.color().iter().all(|c| [1, 2, 7].contains(c)));
    }
}

/// Lines and points at anything, of any width.
fn strokes(
    rng: &mut Rng,
    renderer: &mut ZBufferRenderer<2>,
    frame: &mut Framebuffer<u8>,
    faces: &[Vec<u32>],
) {
    let odd = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e30];
    for _ in 0..4 {
        let vertices = polygon(rng);
        let width = if rng.once_in(4) { odd[rng.below(6)] } else { rng.range(0.1, 40.0) as f32 };
        let join = match rng.below(3) {
            0 => Join::Miter { limit: if rng.once_in(3) { odd[rng.below(6)] } else { 3.0 } },
            1 => Join::Bevel,
            _ => Join::Round,
        };
        let cap = [Cap::Butt, Cap::Square, Cap::Round][rng.below(3)];
        let color = |f: &polyscan::Fragment<'_, 2>| (f.params[0] < 0.5).then_some(1);
        let thin = Lines::polyline(&vertices);
        renderer.draw(frame, thin, dynamic(color));
        renderer.draw(
            frame,
            thin.closed().with_width(width).with_join(join).with_cap(cap),
            dynamic(color),
        );
        renderer.draw(frame, Lines::outline(&vertices).with_width(2.0), dynamic(color));
        renderer.draw(frame, Lines::new(&vertices, faces), dynamic(color));
        renderer.draw_depth(frame, Lines::edges_of(&Mesh::new(&vertices, faces)));
        let points = Points::new(&vertices).with_size(width);
        renderer.draw(frame, points, dynamic(|_| 2));
        renderer.draw(frame, points.round(), dynamic(|_| 2));
    }
}

#[test]
fn a_viewport_of_65536_pixels_is_drawn_like_any_other() {
    let viewport = Viewport::new(65_536, 65_536).expect("the largest");
    assert!(Viewport::new(65_537, 1).is_err() && Framebuffer::new(1, 65_537, 0u8).is_err());
    let mut scan = ScanConverter::new(viewport);
    let corners = [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0)];
    let triangle = corners.map(|(x, y)| Vertex::new(vec4(x, y, 0.0, 1.0), [x, y]));
    let (mut pixels, mut rows) = (0u64, 0);
    for span in scan.spans(&triangle) {
        pixels += span.columns().len() as u64;
        rows += 1;
        if rows % 500 != 0 {
            continue;
        }
        let last = span.fragments().last().expect("spans are not empty");
        let exact = (f64::from(last.x) + 0.5) / 32_768.0 - 1.0;
        assert!((f64::from(last.params[0]) - exact).abs() < 1e-6);
    }
    // The diagonal runs through pixel centres, which belong to what is on its right.
    assert_eq!((pixels, rows), (65_536 * 65_535 / 2, 65_535));
}
