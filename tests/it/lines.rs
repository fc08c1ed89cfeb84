//! Lines and points: their pixels exactly, their values in perspective, hidden lines.

use std::collections::BTreeMap;

use crate::common::generators::Rng;
use crate::common::oracle::diamonds;
use crate::common::{LONG_SEED, dynamic, dynamic_mut, in_threads};
use glam::{DVec2, Vec2, Vec4, vec4};
use polyscan::render::{Cap, Geometry, Join};
use polyscan::subpixel::SubpixelPoint;
use polyscan::{
    ClipPlane, DepthBias, DepthTest, Framebuffer, Level, Lines, Mesh, PainterRenderer, Points,
    ScanlineRenderer, Vertex, Viewport, ZBufferRenderer,
};

const SIDE: u32 = 32;

type Pixel = [i64; 2];

/// A vertex at a place in subpixels of a picture of `SIDE` pixels, exactly.
fn at(p: Pixel, w: f32) -> Vertex<0> {
    let unit = f64::from(SIDE) * 128.0;
    let [x, y] = p.map(|c| c as f64 / unit);
    Vertex::new(vec4((x - 1.0) as f32, (1.0 - y) as f32, 0.5, 1.0) * w, [])
}

fn renderer<const N: usize>() -> ZBufferRenderer<N> {
    let mut renderer = ZBufferRenderer::new(Viewport::new(SIDE, SIDE).expect("small"));
    renderer.depth_test = DepthTest::Always;
    renderer
}

/// How often each pixel is drawn.
fn drawn<const N: usize>(
    renderer: &mut ZBufferRenderer<N>,
    geometry: impl Geometry<N>,
) -> BTreeMap<Pixel, u32> {
    let mut frame = Framebuffer::new(SIDE, SIDE, ()).expect("small");
    let mut pixels = BTreeMap::new();
    renderer.on_one_thread().draw(
        &mut frame,
        geometry,
        dynamic_mut(|fragment| {
            *pixels.entry([fragment.x.into(), fragment.y.into()]).or_insert(0) += 1;
        }),
    );
    pixels
}

/// The pixels of a line by the oracle.
fn exact(a: Pixel, b: Pixel) -> Vec<Pixel> {
    let range = |axis: usize| {
        let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
        (low.div_euclid(256) - 1).max(0)..(high.div_euclid(256) + 2).min(SIDE.into())
    };
    diamonds::pixels(a, b, range(0), range(1))
}

/// A place, often on what borders diamonds and pixels.
fn place(rng: &mut Rng, reach: i64) -> Pixel {
    let unit = [1, 1, 16, 64, 128, 128, 256][rng.below(7)];
    [0; 2].map(|_| rng.whole(-reach / unit, (256 * i64::from(SIDE) + reach) / unit) * unit)
}

fn line(rng: &mut Rng) -> [Pixel; 2] {
    let a = place(rng, 1000);
    let b = match rng.below(4) {
        // Short, or along a row, a column or a diagonal.
        0 => a.map(|c| c + rng.whole(-300, 300)),
        1 => {
            let length = rng.whole(-4000, 4000);
            let direction = [[1, 0], [0, 1], [1, 1], [1, -1]][rng.below(4)];
            [a[0] + direction[0] * length, a[1] + direction[1] * length]
        }
        2 => place(rng, 100_000),
        _ => place(rng, 1000),
    };
    [a, b]
}

fn check_line(seed: u64) -> u64 {
    let rng = &mut Rng::new(seed);
    let (mut renderer, mut pixels) = (renderer(), 0);
    for number in 0..64 {
        let [a, b] = line(rng);
        let w = [1.0, 0.5, 4.0][rng.below(3)];
        let vertices = [at(a, w), at(b, 1.0)];
        let found = drawn(&mut renderer, Lines::polyline(&vertices));
        let expected = exact(a, b);
        assert!(found.values().all(|&n| n == 1), "seed {seed}, line {number}: {a:?} {b:?}");
        let mut found: Vec<_> = found.into_keys().collect();
        found.sort_unstable_by_key(|[x, y]| [*y, *x]);
        assert_eq!(found, expected, "seed {seed}, line {number}: {a:?} to {b:?}");
        pixels += expected.len() as u64;
    }
    pixels
}

#[test]
fn a_line_leaves_the_diamonds_of_its_pixels() {
    let pixels = in_threads(0..400, check_line);
    assert!(pixels > 100_000, "only {pixels} pixels");
}

#[test]
#[ignore = "long: 10^6 lines, a minute"]
fn long_lines() {
    println!("{} pixels", in_threads(LONG_SEED..LONG_SEED + 15_625, check_line));
}

#[test]
fn a_polyline_has_each_segments_pixels_and_its_joints_once() {
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        let count = 2 + rng.below(8);
        let places: Vec<_> = (0..count).map(|_| place(rng, 600)).collect();
        let vertices: Vec<_> = places.iter().map(|&p| at(p, 1.0)).collect();
        for is_closed in [false, true] {
            let ends = places.iter().skip(1).chain(places.first().filter(|_| is_closed));
            let mut expected = BTreeMap::new();
            for (&a, &b) in places.iter().zip(ends) {
                exact(a, b).into_iter().for_each(|pixel| *expected.entry(pixel).or_insert(0) += 1);
            }
            let lines = Lines::polyline(&vertices);
            let lines = if is_closed { lines.closed() } else { lines };
            assert_eq!(drawn(&mut renderer(), lines), expected, "seed {seed}");
        }
    }
    // Along a smooth curve, which does not come back to a pixel, each is drawn once.
    let curve: Vec<_> = (0..100)
        .map(|i| at([i * 80 + 3, 4096 + (3000.0 * (i as f64 * 0.06).sin()) as i64], 1.0))
        .collect();
    let pixels = drawn(&mut renderer(), Lines::polyline(&curve));
    assert!(pixels.len() > 30 && pixels.values().all(|&n| n == 1));
}

/// A vertex of any w, some behind the eye, some before the near plane or behind the far one.
fn wild(rng: &mut Rng) -> Vertex<0> {
    let w = if rng.once_in(4) { rng.range(-1.0, 1.0) } else { rng.octaves(0.1, 30.0) };
    let [x, y] = [0; 2].map(|_| rng.range(-1.5, 1.5));
    let z = rng.range(-0.3, 1.3);
    Vertex::new(vec4((x * w) as f32, (y * w) as f32, (z * w) as f32, w as f32), [])
}

fn check_cuts(seed: u64) -> u64 {
    let rng = &mut Rng::new(seed);
    let (mut cut_in_two, mut renderer) = (0, renderer::<0>());
    for _ in 0..40 {
        let vertices: Vec<_> = (0..3).map(|_| wild(rng)).collect();
        let whole = drawn(&mut renderer, Lines::polyline(&vertices));
        let form = Vec4::from_array([0; 4].map(|_| rng.range(-1.0, 1.0) as f32));
        // Some planes through a vertex, or parallel to the screen.
        let form = match rng.below(4) {
            0 => {
                let p = vertices[1].position;
                form - p * (form.dot(p) / p.length_squared())
            }
            1 => vec4(0.0, 0.0, form.z, -form.z * 0.5),
            _ => form,
        };
        let mut parts = BTreeMap::new();
        let mut sides = 0;
        for form in [form, -form] {
            renderer.settings.planes = vec![ClipPlane::new(form)];
            let part = drawn(&mut renderer, Lines::polyline(&vertices));
            sides += u64::from(!part.is_empty());
            part.into_iter().for_each(|(pixel, n)| *parts.entry(pixel).or_insert(0) += n);
        }
        renderer.settings.planes.clear();
        assert_eq!(parts, whole, "seed {seed}: {vertices:?} cut by {form}");
        cut_in_two += u64::from(sides == 2);
    }
    cut_in_two
}

#[test]
fn a_cut_by_any_plane_moves_no_pixel() {
    let cut = in_threads(0..300, check_cuts);
    assert!(cut > 1500, "only {cut} lines were cut");
}

#[test]
fn near_and_far_leave_the_whole_lines_pixels_as_far_as_they_reach() {
    let mut shortened = 0;
    for seed in 0..2000 {
        let rng = &mut Rng::new(seed);
        let [a, b] = [place(rng, 1000), place(rng, 1000)];
        let [za, zb] = [0; 2].map(|_| rng.range(-0.7, 1.7) as f32);
        let mut vertices = [at(a, 1.0), at(b, 1.0)];
        (vertices[0].position.z, vertices[1].position.z) = (za, zb);
        let found = drawn(&mut renderer(), Lines::polyline(&vertices));
        let is_wide = (a[0] - b[0]).abs() >= (a[1] - b[1]).abs();
        let axis = usize::from(!is_wide);
        let whole = exact(a, b);
        for pixel in &whole {
            // Where the line is on the centre line of the pixel's column or row.
            let centre = pixel[axis] as f64 * 256.0 + 128.0;
            let t = (centre - a[axis] as f64) / (b[axis] - a[axis]) as f64;
            let z = f64::from(za) + f64::from(zb - za) * t.clamp(0.0, 1.0);
            // Rounding of where it is cut may take half a subpixel.
            let margin = f64::from((zb - za).abs()) / (b[axis] - a[axis]).abs() as f64 + 1e-6;
            let is_drawn = found.contains_key(pixel);
            if z > margin && z < 1.0 - margin {
                assert!(is_drawn, "seed {seed}: {pixel:?} of {a:?} to {b:?}");
            } else if z < -margin || z > 1.0 + margin {
                assert!(!is_drawn, "seed {seed}: {pixel:?} of {a:?} to {b:?}");
            }
        }
        assert!(found.keys().all(|pixel| whole.contains(pixel)), "seed {seed}");
        shortened += usize::from(found.len() < whole.len());
    }
    assert!(shortened > 500);
}

#[test]
fn values_are_those_of_the_line_in_perspective() {
    let viewport = Viewport::new(SIDE, SIDE).expect("small");
    let (mut seen, mut worst) = (0, 0.0f64);
    for seed in 0..3000 {
        let rng = &mut Rng::new(seed);
        let ratio = rng.octaves(1.0, 1000.0);
        let mut renderer = renderer::<2>();
        renderer.depth_test = DepthTest::Nearer;
        let ends = [1.0, ratio].map(|w| {
            let ([x, y], z) = ([0; 2].map(|_| rng.range(-1.2, 1.2)), rng.range(0.0, 1.0));
            let params = [0; 2].map(|_| rng.range(-1.0, 1.0) as f32);
            Vertex::new(vec4((x * w) as f32, (y * w) as f32, (z * w) as f32, w as f32), params)
        });
        let points = ends.map(|end| SubpixelPoint::project(end.position.as_dvec4(), &viewport));
        let [dx, dy] = [points[1].x - points[0].x, points[1].y - points[0].y];
        let is_wide = dx.abs() >= dy.abs();
        let screen = ends.map(|end| {
            let [x, y, z, w] = end.position.as_dvec4().to_array();
            let half = f64::from(SIDE) / 2.0;
            let place = if is_wide { half * (1.0 + x / w) } else { half * (1.0 - y / w) };
            (place, z / w, w)
        });
        let mut frame = Framebuffer::new(SIDE, SIDE, ()).expect("small");
        let mut fragments = Vec::new();
        renderer.on_one_thread().draw(&mut frame, Lines::polyline(&ends), |f| {
            fragments.push((f.x, f.y, f.depth, f.w, f.params));
        });
        let [(pa, za, wa), (pb, zb, wb)] = screen;
        if (pb - pa).abs() < 0.5 {
            continue;
        }
        for (x, y, depth, w, params) in fragments {
            let centre = f64::from(if is_wide { x } else { y }) + 0.5;
            let t = ((centre - pa) / (pb - pa)).clamp(0.0, 1.0);
            let inv_w = (1.0 - t) / wa + t / wb;
            assert!((f64::from(w) * inv_w - 1.0).abs() < 2e-6, "seed {seed}: w {w}");
            assert!((za + (zb - za) * t - f64::from(depth)).abs() < 1e-6, "seed {seed}: {depth}");
            for (i, param) in params.into_iter().enumerate() {
                let [a, b] = ends.map(|end| f64::from(end.params[i]));
                let exact = ((1.0 - t) * a / wa + t * b / wb) / inv_w;
                let off = (f64::from(param) - exact).abs() / a.abs().max(b.abs());
                worst = worst.max(off);
                let range = ends.map(|end| end.params[i]);
                assert!(param >= range[0].min(range[1]) && param <= range[0].max(range[1]));
            }
            seen += 1;
        }
    }
    assert!(seen > 20_000 && worst < 1e-5, "{seen} fragments, off by {worst:e}");
}

/// How far a point is from a segment, and whether its foot is between the ends.
fn distance(p: DVec2, [a, b]: [DVec2; 2]) -> (f64, bool) {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared();
    (p.distance(a + along * t.clamp(0.0, 1.0)), (0.0..=1.0).contains(&t))
}

#[test]
fn wide_lines_cover_what_is_near_and_no_pixel_twice() {
    // Corners are rounded to 1/256 pixel, arcs are chords that are off by 1/16.
    const ROUNDING: f64 = 0.01;
    const ARC: f64 = 1.0 / 16.0 + ROUNDING;
    let mut pixels = 0;
    for seed in 0..400 {
        let rng = &mut Rng::new(seed);
        let width = rng.range(0.5, 5.0);
        let join = [Join::Miter { limit: 3.0 }, Join::Bevel, Join::Round][rng.below(3)];
        let cap = [Cap::Butt, Cap::Square, Cap::Round][rng.below(3)];
        let mut places = vec![DVec2::splat(16.0)];
        let mut angle = rng.range(0.0, 6.3);
        for _ in 0..1 + rng.below(4) {
            angle += rng.range(-1.5, 1.5);
            let length = rng.range(1.2, 3.0) * width.max(2.0) + width;
            places.push(*places.last().expect("the first") + DVec2::from_angle(angle) * length);
        }
        let vertices: Vec<_> =
            places.iter().map(|p| at([(p.x * 256.0) as i64, (p.y * 256.0) as i64], 1.0)).collect();
        let places: Vec<_> = places.iter().map(|p| (*p * 256.0).trunc() / 256.0).collect();
        let lines = Lines::polyline(&vertices).with_width(width as f32);
        let found = drawn(&mut renderer(), lines.with_join(join).with_cap(cap));
        let segments: Vec<_> = places.windows(2).map(|ends| [ends[0], ends[1]]).collect();
        let apart = |i: usize, j: usize| i + 1 < j || j + 1 < i;
        for (y, x) in (0..i64::from(SIDE)).flat_map(|y| (0..i64::from(SIDE)).map(move |x| (y, x))) {
            let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let near: Vec<_> = segments.iter().map(|&s| distance(centre, s)).collect();
            let half = width / 2.0;
            let count = found.get(&[x, y]).copied().unwrap_or(0);
            if near.iter().any(|&(d, is_between)| is_between && d < half - ROUNDING) {
                assert!(count > 0, "seed {seed}, {x} {y}: {join:?} {cap:?}");
            }
            let reach = match (join, cap) {
                (Join::Miter { limit }, _) => half * f64::from(limit),
                (_, Cap::Square) => half * 2.0f64.sqrt(),
                _ => half,
            };
            if near.iter().all(|&(d, _)| d > reach + ROUNDING) {
                assert!(count == 0, "seed {seed}, {x} {y}: {join:?} {cap:?}");
            }
            if join == Join::Round && cap == Cap::Round && near.iter().any(|n| n.0 < half - ARC) {
                assert!(count > 0, "seed {seed}, {x} {y}: round");
            }
            // Segments that do not meet at a corner may cross.
            let close = |i: usize| near[i].0 < reach + 1.0;
            let crosses =
                (0..near.len()).any(|i| (0..i).any(|j| apart(i, j) && close(i) && close(j)));
            assert!(count <= 1 || crosses, "seed {seed}, {x} {y}: {count} times");
            pixels += count;
        }
    }
    assert!(pixels > 10_000);
}

#[test]
fn points_are_squares_and_disks() {
    let (mut seen, mut renderer) = (0, renderer());
    for seed in 0..3000 {
        let rng = &mut Rng::new(seed);
        let p = place(rng, 2000);
        let size = if rng.once_in(4) { 1.0 } else { rng.whole(1, 2000) as f32 / 256.0 };
        let subpixels = (size * 256.0) as i64;
        let vertices = [at(p, 2.0)];
        let points = Points::new(&vertices).with_size(size);
        let (square, disk) = (drawn(&mut renderer, points), drawn(&mut renderer, points.round()));
        let own = p.map(|c| (c - 1).div_euclid(256));
        for (y, x) in (0..i64::from(SIDE)).flat_map(|y| (0..i64::from(SIDE)).map(move |x| (y, x))) {
            let [dx, dy] = [x * 256 + 128 - p[0], y * 256 + 128 - p[1]];
            let inside = |d: i64| -(subpixels / 2) <= d && d < subpixels - subpixels / 2;
            let is_square = inside(dx) && inside(dy);
            assert_eq!(square.contains_key(&[x, y]), is_square, "seed {seed}: {x} {y}");
            let is_disk = 4 * (dx * dx + dy * dy) < subpixels * subpixels || own == [x, y];
            let is_disk = if subpixels <= 256 { is_square } else { is_disk };
            assert_eq!(disk.contains_key(&[x, y]), is_disk, "seed {seed}: {x} {y}, size {size}");
        }
        if size == 1.0 && own.iter().all(|c| (0..i64::from(SIDE)).contains(c)) {
            assert!(square.into_keys().eq([own]), "seed {seed}");
        }
        seen += disk.len();
    }
    assert!(seen > 15_000, "only {seen} pixels of disks");
}

#[test]
fn each_edge_of_a_mesh_is_drawn_once() {
    let count = |vertices: &[Vertex<0>], faces: &[Vec<u32>]| {
        let mut frame = Framebuffer::new(SIDE, SIDE, ()).expect("small");
        let mut edges = std::collections::BTreeSet::new();
        let lines = Lines::edges_of(&Mesh::new(vertices, faces));
        renderer().on_one_thread().draw(
            &mut frame,
            lines,
            dynamic_mut(|f| {
                edges.insert(f.face);
            }),
        );
        edges.len()
    };
    let at = |x: i64, y: i64| at([x * 256, y * 256], 1.0);
    let grid: Vec<_> = (0..9).map(|i| at(4 + 10 * (i % 3), 4 + 10 * (i / 3))).collect();
    let quads: Vec<Vec<u32>> = [0, 1, 3, 4].map(|i| vec![i, i + 1, i + 4, i + 3]).to_vec();
    assert_eq!(count(&grid, &quads), 12);
    // The same quads with vertices of their own each.
    let own: Vec<_> = quads.iter().flatten().map(|&i| grid[i as usize]).collect();
    let apart: Vec<Vec<u32>> = (0..4).map(|i| (4 * i..4 * i + 4).collect()).collect();
    assert_eq!(count(&own, &apart), 12);
    // A face out of range, one with too few corners, one that is listed twice, the other way round.
    let faces = [vec![0, 1, 99], vec![0, 1], vec![0, 1, 4, 3], vec![3, 4, 1, 0], vec![8, 8, 8]];
    assert_eq!(count(&grid, &faces), 4);
}

#[test]
fn an_outline_has_its_contours_and_no_inner_edge() {
    let square = |from: i64, to: i64| {
        [[from, from], [to, from], [to, to], [from, to]].map(|p| at(p.map(|c| c * 256 + 128), 1.0))
    };
    let polygon = [square(2, 20), square(6, 12)];
    let pixels = drawn(&mut renderer(), Lines::outline(&polygon));
    assert_eq!(pixels.len(), 4 * 18 + 4 * 6);
    assert!(pixels.values().all(|&n| n == 1));
}

/// A tilted grid of quads.
fn tilted() -> (Vec<Vertex<0>>, Vec<[u32; 4]>) {
    let turn = Vec2::from_angle(0.3);
    let vertex = |i: u32| {
        let p = (Vec2::new((i % 6) as f32, (i / 6) as f32) / 2.5 - 1.0) * 0.9;
        let p = p.rotate(turn);
        let w = 2.0 + p.x + 0.5 * p.y;
        Vertex::new(vec4(p.x * w, p.y * w, 0.3 * w + 0.5, w), [])
    };
    let quad = |i: u32| [i, i + 1, i + 7, i + 6];
    let faces = (0..30).filter(|i| i % 6 != 5).map(quad).collect();
    ((0..36).map(vertex).collect(), faces)
}

#[test]
fn lines_on_faces_are_seen_and_those_behind_are_not() {
    let (vertices, faces) = tilted();
    let (mut alone, mut on_faces) = (renderer(), renderer());
    let mesh = Mesh::new(&vertices, &faces);
    let all = drawn(&mut alone, Lines::edges_of(&mesh));
    let mut frame = Framebuffer::new(SIDE, SIDE, 0).expect("small");
    on_faces.depth_test = DepthTest::Nearer;
    on_faces.settings.depth_bias = DepthBias { constant: 1e-5, slope: 1.0 };
    on_faces.draw_depth(&mut frame, mesh);
    on_faces.settings.depth_bias = DepthBias::default();
    on_faces.draw(&mut frame, Lines::edges_of(&mesh), dynamic(|_| 1));
    let seen = frame.color().iter().filter(|&&c| c == 1).count();
    assert_eq!(seen, all.len());
    // The same lines, farther from the eye.
    let behind: Vec<_> = vertices
        .iter()
        .map(|v| Vertex::new(v.position + vec4(0.0, 0.0, 0.05 * v.position.w, 0.0), []))
        .collect();
    on_faces.draw(&mut frame, Lines::edges_of(&Mesh::new(&behind, &faces)), dynamic(|_| 2));
    let inside = |x: i64, y: i64| frame.pixel(x as u32, y as u32).is_some_and(|(c, _)| c == 2);
    // Only at the outer border, where pixels' centres lie beside the faces.
    let wrong = all.keys().filter(|[x, y]| inside(*x, *y)).count();
    assert_eq!(wrong, 0, "where a line was drawn another behind it is not");
    let outside = frame.color().iter().filter(|&&c| c == 2).count();
    assert!(outside < 40, "{outside} pixels of hidden lines");
}

/// A picture with lines and points of all kinds.
fn scene(draw: &mut dyn FnMut(u32, &[Vertex<3>])) {
    for seed in 0..60 {
        let rng = &mut Rng::new(seed);
        let vertices: Vec<_> = (0..5)
            .map(|_| {
                let params = [0; 3].map(|_| rng.range(0.0, 1.0) as f32);
                Vertex { position: wild(rng).position, params }
            })
            .collect();
        draw(seed as u32, &vertices);
    }
}

fn picture(level: Level, corner: (i32, i32), [width, height]: [u32; 2]) -> Vec<([u32; 3], u32)> {
    let mut frame = Framebuffer::new(width, height, [0; 3]).expect("small");
    let viewport = Viewport::new(150, 100).expect("small").with_corner(corner.0, corner.1);
    let mut renderer = ZBufferRenderer::<3>::new(viewport);
    renderer.simd_level = level;
    let color = |f: &polyscan::Fragment<'_, 3>| {
        let (dx, dy) = f.derivatives();
        let [r, g, b] = f.params;
        [r + f.w, g + dx[1], b + dy[2]].map(f32::to_bits)
    };
    scene(&mut |number, vertices| match number % 4 {
        0 => renderer.draw(&mut frame, Lines::polyline(vertices), dynamic(color)),
        1 => renderer.draw(&mut frame, Lines::polyline(vertices).with_width(3.3), dynamic(color)),
        2 => {
            let points = Points::new(vertices).with_size(9.0).round();
            renderer.draw(&mut frame, points, dynamic(color));
        }
        _ => {
            let lines = Lines::new(vertices, [[0, 1, 2], [2, 3, 4]]).closed().with_width(6.0);
            renderer.draw(
                &mut frame,
                lines.with_join(Join::Round).with_cap(Cap::Round),
                dynamic(color),
            );
        }
    });
    frame.color().iter().copied().zip(frame.depth().iter().map(|d| d.to_bits())).collect()
}

#[test]
fn the_picture_is_the_same_everywhere() {
    let whole = picture(Level::new(), (0, 0), [150, 100]);
    let drawn = whole.iter().filter(|(color, _)| *color != [0; 3]).count();
    assert!(drawn > 3000, "only {drawn} pixels are drawn");
    assert!(whole == picture(Level::baseline(), (0, 0), [150, 100]));
    let threads = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build();
    for n in [1, 3] {
        let pool = threads(n).expect("threads");
        assert!(whole == pool.install(|| picture(Level::new(), (0, 0), [150, 100])));
    }
    for (x, y) in [(0, 0), (37, 23), (90, 61)] {
        let tile = picture(Level::new(), (-x, -y), [60, 39]);
        for (i, pixel) in tile.iter().enumerate() {
            let (tile_x, tile_y) = (i % 60 + x as usize, i / 60 + y as usize);
            assert!(*pixel == whole[tile_y * 150 + tile_x], "{tile_x} {tile_y}");
        }
    }
}

#[test]
fn all_renderers_draw_lines_and_points() {
    let viewport = Viewport::new(150, 100).expect("small");
    let frame = || Framebuffer::new(150, 100, [0; 3]).expect("small");
    let color = |f: &polyscan::Fragment<'_, 3>| f.params.map(f32::to_bits);
    scene(&mut |number, vertices| {
        let (mut z_buffer, mut scanline, mut painter) = (frame(), frame(), frame());
        let (mut a, mut b, mut c) = (
            ZBufferRenderer::<3>::new(viewport),
            ScanlineRenderer::<3>::new(viewport),
            PainterRenderer::<3>::new(viewport),
        );
        let mut streamed = Vec::new();
        let sink = |_: u32, row: &[[u32; 3]]| {
            streamed.extend_from_slice(row);
            Ok::<(), std::fmt::Error>(())
        };
        // One segment or point, so that the depth test has nothing to decide.
        let vertices = &vertices[..2];
        if number % 2 == 0 {
            let lines = Lines::polyline(vertices).with_width(2.0);
            let lines = if number % 4 == 0 { lines } else { Lines::polyline(vertices) };
            a.draw(&mut z_buffer, lines, dynamic(color));
            b.draw(&mut scanline, lines, dynamic(color));
            c.draw(&mut painter, lines, dynamic(color));
            b.stream(lines, [0; 3], dynamic(color), sink).expect("the sink takes all");
        } else {
            let points = Points::new(&vertices[..1]).with_size(7.0);
            a.draw(&mut z_buffer, points, dynamic(color));
            b.draw(&mut scanline, points, dynamic(color));
            c.draw(&mut painter, points, dynamic(color));
            b.stream(points, [0; 3], dynamic(color), sink).expect("the sink takes all");
        }
        assert!(z_buffer == scanline);
        assert_eq!(z_buffer.color(), painter.color());
        assert_eq!(z_buffer.color(), streamed);
    });
}
