//! Subdivision: the bound on the error of linear interpolation, and that triangles meet.

use std::array::from_fn;
use std::collections::HashMap;

use crate::common::generators::{self, Rng, number};
use crate::common::vertices;
use glam::{DVec2, Vec2, Vec4, dvec2, vec2, vec4};
use polyscan::parameters::{ParameterError, Subdivision};
use polyscan::{Interpolation, ParameterMatrix, ScanConverter, Settings, Vertex, Viewport};

fn settings<const N: usize>(width: u32, height: u32) -> Settings<N> {
    Settings::new(Viewport::new(width, height).expect("small"))
}

/// The (u, v) of a triangle where its barycentric coordinates on the screen are `b`: by linear interpolation, and in
/// perspective; in texels.
fn both(triangle: &[Vertex<2>; 3], b: [f64; 3], size: Vec2) -> [DVec2; 2] {
    let texels = |v: &Vertex<2>| (Vec2::from(v.params) * size).as_dvec2();
    let mix = |weights: [f64; 3]| (0..3).map(|i| texels(&triangle[i]) * weights[i]).sum::<DVec2>();
    let per_w: [f64; 3] = from_fn(|i| b[i] / f64::from(triangle[i].position.w));
    let total: f64 = per_w.iter().sum();
    [mix(b), mix(per_w.map(|c| c / total))]
}

/// The worst error of some triangles, at many points of each.
fn worst(rng: &mut Rng, triangles: &[[Vertex<2>; 3]], size: Vec2) -> f64 {
    let mut worst = 0.0f64;
    for triangle in triangles {
        for point in 0..12 {
            let mut b: [f64; 3] = from_fn(|_| rng.range(0.0, 1.0));
            if point < 6 {
                // On an edge, where the error is greatest as a rule, and near its greatest there.
                let [i, j, k] = [point % 3, (point + 1) % 3, (point + 2) % 3];
                let [p, q] = [i, j].map(|i| f64::from(triangle[i].position.w).sqrt());
                b[k] = 0.0;
                (b[i], b[j]) = if point < 3 { (p, q) } else { (b[i], b[j]) };
            }
            let total: f64 = b.iter().sum();
            let [linear, exact] = both(triangle, b.map(|c| c / total), size);
            worst = worst.max((linear - exact).length());
        }
    }
    worst
}

#[test]
fn the_bound_is_never_exceeded() {
    let (mut triangles, mut nearest) = (0, 0.0f64);
    for seed in 0..150 {
        let rng = &mut Rng::new(seed);
        let sides = 3 + rng.below(5);
        let shape = match rng.below(3) {
            0 => generators::random_convex::<2>(rng, sides, 100.0),
            1 => generators::random_triangle::<2>(rng, 30.0, 1.5),
            _ => generators::through_eye::<2>(rng, sides),
        };
        let polygon = vertices(&shape);
        let size = vec2(rng.octaves(4.0, 200.0) as f32, rng.octaves(4.0, 200.0) as f32);
        let error = rng.octaves(0.3, 8.0) as f32;
        let settings = settings(90, 60);
        let within = Subdivision::Within { error, params: [0, 1], size };
        let Ok(found) = within.triangles(&polygon, &settings) else { continue };
        let found_worst = worst(rng, &found, size);
        assert!(found_worst <= f64::from(error), "seed {seed}: {found_worst} for {error}");
        nearest = nearest.max(found_worst / f64::from(error));
        triangles += found.len();
        // What is cut has to be: where the bound on an edge says so, the error comes to that bound.
        let whole = Subdivision::Times(0).triangles(&polygon, &settings).expect("few");
        if found.len() > whole.len() {
            assert!(worst(rng, &whole, size) > f64::from(error) / 2.001, "seed {seed}");
        }
    }
    println!("{triangles} triangles, the error comes to {nearest:.2} of the bound");
    assert!(triangles > 5_000 && nearest > 0.4, "{triangles} triangles, {nearest} of the bound");
}

/// On the screen, by the scan converter: what is interpolated linearly on the pieces is within the bound of the exact
/// planes, but for what changes over the 1/256 pixel that a centre may lie outside of a piece.
#[test]
fn what_is_drawn_keeps_the_bound() {
    let mut pixels = 0;
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        let shape = generators::random_triangle::<2>(rng, 20.0, 1.2);
        let polygon: [Vertex<2>; 3] = vertices(&shape).try_into().expect("a triangle");
        let mut scan = ScanConverter::new(Viewport::new(80, 60).expect("small"));
        scan.settings.interpolation = [Interpolation::Linear; 2];
        let (size, error) = (Vec2::splat(100.0), 0.5);
        let within = Subdivision::Within { error, params: [0, 1], size };
        let triangles = within.triangles(&polygon, &scan.settings).expect("some");
        let Some(matrix) = ParameterMatrix::new(&polygon, &scan.settings.viewport) else {
            continue;
        };
        for triangle in &triangles {
            for span in scan.spans(triangle) {
                for fragment in span.fragments() {
                    let (x, y) = (f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5);
                    let (exact, _) = matrix.at(x, y);
                    let (dx, dy) = matrix.derivatives_at(x, y);
                    let off = (Vec2::from(fragment.params).as_dvec2() - DVec2::from(exact)) * 100.0;
                    let steep =
                        (dvec2(dx[0], dx[1]).length() + dvec2(dy[0], dy[1]).length()) * 100.0;
                    assert!(off.length() <= 0.5 + steep / 128.0 + 1e-3, "seed {seed}: {off}");
                    pixels += 1;
                }
            }
        }
    }
    assert!(pixels > 10_000, "only {pixels} pixels");
}

/// Edges are shared by two triangles or lie on the outline: no triangle has a corner within another's edge, within a
/// polygon and between polygons that share an edge.
#[test]
fn triangles_meet() {
    let mut inner = 0;
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        // Two quads of a floor that share an edge.
        let w = |x: f64, z: f64| 1.5 + 0.2 * x + z;
        let z: [f64; 6] = from_fn(|i| if i < 3 { 0.0 } else { rng.range(2.0, 30.0) });
        let corner = |i: usize| {
            let x = [-1.0, 0.0, 1.0, -1.0, 0.0, 1.0][i];
            let w = w(x, z[i]);
            let params = [x as f32 * 3.0, z[i] as f32];
            Vertex::new(vec4(x as f32, (0.3 * z[i] - 1.0) as f32, 0.5 * w as f32, w as f32), params)
        };
        let faces = [[0, 1, 4, 3], [1, 2, 5, 4]].map(|face| face.map(corner));
        let within = Subdivision::Within { error: 0.2, params: [0, 1], size: Vec2::splat(16.0) };
        let mut edges: HashMap<[[u32; 4]; 2], i32> = HashMap::new();
        for face in faces {
            for triangle in within.triangles(&face, &settings(64, 64)).expect("some") {
                for i in 0..3 {
                    let [a, b] =
                        [i, (i + 1) % 3].map(|i| triangle[i].position.to_array().map(f32::to_bits));
                    *edges.entry([a, b]).or_default() += 1;
                }
            }
        }
        let is_outline = |[a, b]: [[u32; 4]; 2]| {
            let corners: [Vec4; 6] = from_fn(|i| corner(i).position);
            let on = |p: [u32; 4], q: Vec4, r: Vec4| {
                let p = Vec4::from_array(p.map(f32::from_bits));
                let t = (p - q).length() / (r - q).length();
                (q.lerp(r, t) - p).length() < 1e-3
            };
            let sides = [[0, 1], [1, 2], [2, 5], [5, 4], [4, 3], [3, 0]];
            sides
                .iter()
                .any(|&[i, j]| on(a, corners[i], corners[j]) && on(b, corners[i], corners[j]))
        };
        for (&[a, b], &count) in &edges {
            assert_eq!(count, 1, "seed {seed}: an edge twice in one direction");
            let is_shared = edges.contains_key(&[b, a]);
            assert!(is_shared || is_outline([a, b]), "seed {seed}: an edge with a corner on it");
            inner += i32::from(is_shared);
        }
    }
    assert!(inner > 5_000, "only {inner} inner edges");
}

#[test]
fn fixed_subdivision_makes_four_of_one() {
    let triangle = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    for times in 0..5 {
        let found = Subdivision::Times(times).triangles(&triangle, &settings(9, 9)).expect("few");
        assert_eq!(found.len(), 4usize.pow(times));
    }
    let error = Subdivision::Times(11).triangles(&triangle, &settings(9, 9)).err();
    assert!(matches!(error, Some(ParameterError::TooManyTriangles { .. })));
}

#[test]
fn anything_is_cut_or_an_error() {
    let mut cut = 0;
    for seed in 0..3000 {
        let rng = &mut Rng::new(seed);
        let oddness = [4, 10, 1000][rng.below(3)];
        let polygon: Vec<Vertex<2>> = (0..rng.below(6))
            .map(|_| {
                let position = Vec4::from_array(from_fn(|_| number(rng, oddness)));
                Vertex::new(position, from_fn(|_| number(rng, oddness)))
            })
            .collect();
        // Not so fine that a million triangles come of it each time.
        let error = if rng.once_in(50) { number(rng, 3) } else { 3.0 };
        let within = Subdivision::Within { error, params: [0, rng.below(3)], size: Vec2::ONE };
        match within.triangles(&polygon, &settings(20, 20)) {
            Ok(triangles) => cut += usize::from(!triangles.is_empty()),
            Err(error) => assert!(matches!(error, ParameterError::TooManyTriangles { .. })),
        }
    }
    assert!(cut > 300, "only {cut} polygons were cut");
}
