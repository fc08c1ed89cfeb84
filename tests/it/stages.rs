//! The stages joined by hand, clipper, projection, edge table and surface, are the scan converter, to
//! the bit; and blocks are their fragments.

use crate::common::generators::{self, Cells, Rng, number};
use crate::common::oracle::Window;
use crate::common::{in_threads, tally, vertices, viewport};
use glam::{DVec4, Vec4};
use polyscan::clip::{ClipVertex, ClippedOutline, Clipper};
use polyscan::coverage::{EdgeTable, Run};
use polyscan::outline::Chain;
use polyscan::subpixel::SubpixelPoint;
use polyscan::{
    ClipPlane, ClipSpace, Cull, DepthBias, FillRule, Fragment, FrontFace, Interpolation, Level,
    Outline, Rect, ScanConverter, Settings, Span, Surface, Vertex,
};

const WINDOW: Window = Window { width: 61, height: 47 };

/// All that a fragment has, as bits.
#[derive(Clone, Debug, PartialEq)]
struct Bits {
    at: (i32, i32),
    face: u32,
    front_facing: bool,
    values: Vec<u32>,
}

fn bits<const N: usize>(f: &Fragment<'_, N>) -> Bits {
    let (dx, dy) = f.derivatives();
    let values = [&[f.depth, f.w][..], &f.params, &dx, &dy].concat();
    // Not a number has many bit patterns, and which one is of no importance.
    let bits = |value: f32| if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() };
    Bits {
        at: (f.x, f.y),
        face: f.face,
        front_facing: f.front_facing,
        values: values.into_iter().map(bits).collect(),
    }
}

/// A span: its place, its values at the start and per pixel, its fragments.
#[derive(Clone, Debug, PartialEq)]
struct SpanBits {
    place: (i32, std::ops::Range<i32>),
    values: Vec<u64>,
    fragments: Vec<Bits>,
}

/// Takes a span down, and checks that its blocks hold its fragments.
fn take_down<const N: usize>(span: &Span<'_, N>) -> SpanBits {
    let fragments: Vec<_> = span.fragments().map(|f| bits(&f)).collect();
    for level in [Level::new(), Level::baseline()] {
        let mut by_block = Vec::new();
        span.for_each_block(level, |block| {
            let lanes = (0..32).filter(|lane| block.visible >> lane & 1 != 0);
            by_block.extend(lanes.map(|lane| bits(&block.fragment(lane))));
        });
        assert_eq!(by_block, fragments, "blocks are the fragments");
    }
    let values = [span.start(), span.delta()]
        .map(|values| [&[values.z, values.inv_w][..], &values.s].concat());
    SpanBits {
        place: (span.row(), span.columns()),
        values: values.concat().into_iter().map(f64::to_bits).collect(),
        fragments,
    }
}

/// The spans of a polygon by all stages, one after the other.
fn by_hand<const N: usize>(
    settings: &Settings<N>,
    polygon: &(impl Outline<N> + ?Sized),
) -> Vec<SpanBits> {
    let mut clipper = Clipper::new();
    let planes = settings.all_planes();
    let clipped = clipper.clip_outline(polygon, &planes, &settings.interpolation);
    let ClippedOutline::Chains { vertices, chains } = clipped else { return Vec::new() };
    let project = |position| SubpixelPoint::project(position, &settings.viewport);
    let points: Vec<_> = vertices.iter().map(|v| project(v.position)).collect();
    let Rect { y, height, .. } = settings.viewport.rect();
    let mut rows = 0..height as i32;
    if let Some(scissor) = settings.scissor {
        rows = rows.start.max(scissor.y - y)..rows.end.min(scissor.y - y + scissor.height as i32);
    }
    let mut edges = EdgeTable::new();
    edges.fill_rule = settings.fill_rule;
    edges.fill_chains(&points, chains, rows);
    let mut surface = Surface::new();
    if !surface.fit(settings, vertices, chains) {
        return Vec::new();
    }
    let mut spans = Vec::new();
    for run in edges.runs() {
        spans.extend(surface.span(&run).map(|span| take_down(&span)));
    }
    spans
}

tally! {
    struct Tally {
        polygons: u64,
        visible: u64,
        spans: u64,
        pixels: u64,
    }
}

fn check<const N: usize>(
    settings: &Settings<N>,
    polygon: &(impl Outline<N> + ?Sized),
    name: &str,
) -> Tally {
    let mut scan = ScanConverter::new(settings.viewport);
    scan.settings = settings.clone();
    let expected: Vec<_> = scan.spans(polygon).map(|span| take_down(&span)).collect();
    let found = by_hand(settings, polygon);
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected, "{name}: {settings:?}");
    }
    assert_eq!(found.len(), expected.len(), "{name}: spans, {settings:?}");
    let pixels = expected.iter().map(|span| span.fragments.len() as u64).sum();
    let visible = u64::from(!expected.is_empty());
    Tally { polygons: 1, visible, spans: expected.len() as u64, pixels }
}

/// Settings of all kinds.
fn any_settings<const N: usize>(rng: &mut Rng) -> Settings<N> {
    let mut settings = Settings::new(viewport(WINDOW));
    settings.fill_rule = [FillRule::NonZero, FillRule::EvenOdd][rng.below(2)];
    settings.front_face = [FrontFace::CounterClockwise, FrontFace::Clockwise][rng.below(2)];
    if rng.once_in(2) {
        return settings;
    }
    settings.clip_space = [ClipSpace::ZeroToOne, ClipSpace::MinusOneToOne][rng.below(2)];
    settings.cull = [Cull::None, Cull::None, Cull::Front, Cull::Back][rng.below(4)];
    for _ in 0..rng.below(3) {
        let plane = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
        settings.planes.push(ClipPlane::new(Vec4::from_array(plane)));
    }
    for interpolation in &mut settings.interpolation {
        let ways = [Interpolation::Perspective, Interpolation::Linear, Interpolation::Flat];
        *interpolation = ways[rng.below(3)];
    }
    if rng.once_in(3) {
        settings.scissor = Some(Rect { x: 5, y: 7, width: 40, height: 30 });
    }
    if rng.once_in(3) {
        settings.viewport = settings.viewport.with_corner(-7, 11).with_depth(0.75, 0.25);
        settings.depth_bias = DepthBias { constant: 0.01, slope: 1.5 };
    }
    settings
}

fn with_params<const N: usize>(rng: &mut Rng, positions: &[[f32; 4]]) -> Vec<Vertex<N>> {
    let params = |rng: &mut Rng| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
    positions.iter().map(|&p| Vertex::new(p.into(), params(rng))).collect()
}

/// Polygons of one contour from all generators.
fn polygons<const N: usize>(rng: &mut Rng) -> Vec<Vec<Vertex<N>>> {
    let w_ratio = if rng.once_in(3) { 1.0 } else { rng.octaves(1.0, 100.0) };
    let sides = 3 + rng.below(8);
    let mut polygons = vec![
        vertices(&generators::random_triangle(rng, w_ratio, 1.5)),
        vertices(&generators::random_triangle(rng, 1e4, 20.0)),
        vertices(&generators::random_convex(rng, sides, w_ratio)),
        vertices(&generators::through_eye(rng, sides)),
        vertices(&generators::through_eye(rng, 3)),
        vertices(&generators::edge_on(rng, sides, 1e-3)),
    ];
    let positions = [
        generators::sliver(rng, WINDOW, 1.5, w_ratio),
        generators::star(rng, WINDOW, 2 + sides),
        generators::crossed_star(rng, WINDOW, 7, 3),
        generators::tangle(rng, WINDOW, sides),
        generators::integer_triangle(rng),
        generators::on_pixel_centres(rng, WINDOW, 9),
        generators::far_outside(rng, WINDOW, 60_000.0, w_ratio),
        generators::far_outside(rng, WINDOW, 1e6, 30.0),
        generators::surrounding(rng, WINDOW, sides, 100.0, w_ratio),
    ];
    polygons.extend(positions.iter().map(|positions| with_params(rng, positions)));
    for _ in 0..3 {
        // Values that have no plane.
        let mut polygon = vertices(&generators::random_convex(rng, sides, w_ratio));
        for vertex in &mut polygon {
            vertex.params = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
            vertex.position.z = rng.range(-0.1, 1.1) as f32 * vertex.position.w;
        }
        polygons.push(polygon);
    }
    let mesh = generators::jittered_grid(rng, WINDOW, [3, 3], Cells::Mixed, w_ratio, 8.0);
    polygons.extend(mesh.polygons().iter().map(|positions| with_params(rng, positions)));
    polygons
}

/// Polygons of one or more contours, flat and tilted.
fn outlines<const N: usize>(rng: &mut Rng) -> Vec<Vec<Vertex<N>>> {
    let contours = generators::any_contours(rng);
    let (least, most) = if rng.once_in(3) { (-0.5, 3.0) } else { (1.0, rng.octaves(1.0, 20.0)) };
    let shape = generators::tilted::<N>(rng, &contours, least, most);
    let contour = |(positions, params): (&Vec<[f32; 4]>, &Vec<[f32; N]>)| {
        let vertex = |(&p, &params): (&[f32; 4], &[f32; N])| Vertex::new(p.into(), params);
        positions.iter().zip(params).map(vertex).collect()
    };
    shape.positions.iter().zip(&shape.parameters).map(contour).collect()
}

fn check_seed<const N: usize>(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let mut tally = Tally::default();
    for (i, polygon) in polygons::<N>(rng).iter().enumerate() {
        let settings = any_settings(rng);
        tally = tally + check(&settings, polygon, &format!("seed {seed}, polygon {i}"));
    }
    let outline = outlines::<N>(rng);
    tally + check(&any_settings(rng), &outline, &format!("seed {seed}, contours"))
}

#[test]
fn stages_joined_by_hand_are_the_scan_converter() {
    let tally = in_threads(0..300, |seed| match seed % 3 {
        0 => check_seed::<0>(seed),
        1 => check_seed::<2>(seed),
        _ => check_seed::<5>(seed),
    });
    println!("stages by hand: {tally:?}");
    assert!(tally.visible > 3000 && tally.pixels > 500_000, "{tally:?}");
}

/// Whoever joins the stages by hand may hand over runs that no edge table made.
#[test]
fn a_surface_takes_any_run() {
    let edge_cases = [i32::MIN, i32::MIN + 1, -70_000, -1, 0, 3, 70_000, i32::MAX - 1, i32::MAX];
    // Not affine, and w falls to the right or to the left: values are given at either end of a run.
    for w in [[1.0, 4.0], [4.0, 1.0]] {
        let quad = [(-1.0, -1.0, w[0]), (1.0, -1.0, w[1]), (1.0, 1.0, w[1]), (-1.0, 1.0, w[0])];
        for twist in [0.0, 1.0] {
            let quad = quad.map(|(x, y, w)| {
                Vertex::new(Vec4::new(x * w, y * w, 0.5 * w, w), [x + twist * x * y])
            });
            let settings = Settings::new(viewport(WINDOW));
            let (mut clipper, planes) = (Clipper::new(), settings.all_planes());
            let clipped = clipper.clip_outline(&quad, &planes, &settings.interpolation);
            let ClippedOutline::Chains { vertices, chains } = clipped else {
                panic!("the quad is visible")
            };
            let mut surface = Surface::new();
            assert!(surface.fit(&settings, vertices, chains));
            let mut spans = 0;
            for (start, end) in edge_cases.iter().flat_map(|a| edge_cases.map(|b| (*a, b))) {
                for y in edge_cases {
                    let run = Run { y, x: start..end, edges: [3, 1] };
                    let Some(span) = surface.span(&run) else { continue };
                    spans += 1;
                    assert_eq!(span.row(), y);
                    let columns = span.columns();
                    assert!(0 <= columns.start && columns.end <= WINDOW.width as i32);
                    assert_eq!(take_down(&span).fragments.len(), columns.len());
                }
            }
            assert!(spans > 0);
        }
    }
}

/// Whoever joins the stages by hand may also hand over vertices that no clipper made.
#[test]
fn stages_take_anything() {
    let rng = &mut Rng::new(77);
    let (mut edges, mut surface) = (EdgeTable::new(), Surface::<2>::new());
    let (mut runs, mut spans) = (0, 0);
    for _ in 0..20_000 {
        let settings = any_settings::<2>(rng);
        let oddness = [3, 6, 20, 1000][rng.below(4)];
        let len = rng.below(9);
        let any = |rng: &mut Rng| match rng.below(oddness) {
            0 => f64::from_bits(rng.bits()),
            _ => f64::from(number(rng, oddness)),
        };
        let vertices: Vec<_> = (0..len)
            .map(|_| ClipVertex {
                position: DVec4::from_array([0; 4].map(|_| any(rng))),
                params: [0; 2].map(|_| any(rng)),
            })
            .collect();
        let mut points: Vec<_> = vertices
            .iter()
            .map(|v| SubpixelPoint::project(v.position, &settings.viewport))
            .collect();
        if rng.once_in(3) {
            points.iter_mut().for_each(|p| {
                let far = 1 << rng.below(31);
                *p = SubpixelPoint { x: rng.bits() as i32 % far, y: rng.bits() as i32 % far };
            });
        }
        let mut chains = Vec::new();
        for _ in 0..rng.below(3) {
            let end = if rng.once_in(4) { rng.bits() as usize } else { rng.below(10) };
            chains.push(Chain { end, winding: rng.bits() as i32 });
        }
        edges.fill_rule = settings.fill_rule;
        edges.fill_chains(&points, &chains, settings.rows());
        let is_drawn = surface.fit(&settings, &vertices, &chains);
        for run in edges.runs().take(50) {
            runs += 1;
            let Some(span) = surface.span(&run) else { continue };
            assert!(is_drawn);
            spans += 1;
            assert_eq!(span.fragments().count(), span.columns().len());
        }
    }
    assert!(runs > 10_000 && spans > 1000, "{runs} runs, {spans} spans");
}
