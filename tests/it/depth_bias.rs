//! The depth bias: added exactly, by all ways of setting polygons up, and enough to lift a decal off
//! the wall that it is on.

use crate::common::dynamic;
use crate::common::generators::Rng;
use glam::vec4;
use polyscan::render::Geometry;
use polyscan::{
    DepthBias, DepthMode, DepthTest, Framebuffer, Mesh, PainterRenderer, ScanConverter,
    ScanlineRenderer, Settings, Vertex, Viewport, ZBufferRenderer,
};

const SIDE: u32 = 64;

fn bias(constant: f32, slope: f32) -> DepthBias {
    DepthBias { constant, slope }
}

/// A vertex at a pixel's corner, y down.
fn at(x: f64, y: f64, z: f64) -> Vertex<0> {
    let half = f64::from(SIDE) / 2.0;
    Vertex::new(vec4((x / half - 1.0) as f32, (1.0 - y / half) as f32, z as f32, 1.0), [])
}

/// The plane whose depth is 1/2 in the middle and changes by multiples of 2^-10 per pixel: its depth is
/// exact at each pixel of polygons with sides of powers of two.
fn exact(x: f64, y: f64) -> Vertex<0> {
    at(x, y, 0.5 + (2.0 * (x - 32.0) - 3.0 * (y - 32.0)) / 1024.0)
}

/// Polygons on the exact plane that are set up in all ways: triangles one by one and eight at a time, a
/// quad, one that is clipped at the sides of the guard band or by a plane.
fn parts() -> (Vec<Vertex<0>>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (x, y) in (0..8).flat_map(|i| (0..8).map(move |j| (8.0 * f64::from(i), 8.0 * f64::from(j))))
    {
        let first = vertices.len() as u32;
        vertices.extend([
            exact(x, y),
            exact(x + 8.0, y),
            exact(x + 8.0, y + 8.0),
            exact(x, y + 8.0),
        ]);
        let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
        if y < 32.0 {
            faces.extend([vec![a, b, c], vec![a, c, d]]);
        } else {
            faces.push(vec![a, b, c, d]);
        }
    }
    (vertices, faces)
}

/// The depths that a renderer stores, of what is drawn whatever its depth.
fn depths(renderer: usize, settings: &Settings<0>, geometry: impl Geometry<0>) -> Vec<f32> {
    let mut frame = Framebuffer::new(SIDE, SIDE, 0u8).expect("a small frame");
    match renderer {
        0 => {
            let mut renderer = ZBufferRenderer::new(settings.viewport);
            renderer.settings = settings.clone();
            renderer.depth_test = DepthTest::Always;
            renderer.draw_depth(&mut frame, geometry);
        }
        1 => {
            let mut renderer = ScanlineRenderer::new(settings.viewport);
            renderer.settings = settings.clone();
            // Nothing is nearer than the farthest depth but what is.
            frame.clear(0, 2.0);
            renderer.draw_depth(&mut frame, geometry);
        }
        _ => {
            let mut renderer = PainterRenderer::new(settings.viewport);
            renderer.settings = settings.clone();
            renderer.depth_write = true;
            renderer.draw_depth(&mut frame, geometry);
        }
    }
    frame.depth().to_vec()
}

/// What the exact plane's depth is at a pixel.
fn expected(pixel: usize) -> f64 {
    let (x, y) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
    0.5 + (2.0 * (f64::from(x) + 0.5 - 32.0) - 3.0 * (f64::from(y) + 0.5 - 32.0)) / 1024.0
}

#[test]
fn the_bias_is_added_exactly_and_kept_in_range() {
    let (vertices, faces) = parts();
    // Per pixel the plane changes by 2/1024 to the right and 3/1024 upwards.
    let steepest = 3.0 / 1024.0;
    let quarter = 0.25f64;
    let cases = [
        (bias(0.0, 0.0), 0.0),
        (bias(-0.125, 0.0), -0.125),
        (bias(1.0 / 4096.0, 0.0), 1.0 / 4096.0),
        (bias(0.0, 2.0), 2.0 * steepest),
        (bias(0.25, -8.0), quarter - 8.0 * steepest),
        (bias(0.5, 0.0), 0.5),
        (bias(-0.5, 0.0), -0.5),
        (bias(2.0, 0.0), 2.0),
        (bias(-2.0, 0.0), -2.0),
        (bias(f32::MAX, f32::MAX), 1.0),
        // No numbers to add.
        (bias(f32::NAN, 0.0), 0.0),
        (bias(f32::INFINITY, 1.0), 0.0),
    ];
    for (depth_bias, added) in cases {
        let mut settings = Settings::new(Viewport::new(SIDE, SIDE).expect("small"));
        settings.depth_bias = depth_bias;
        for renderer in 0..3 {
            let found = depths(renderer, &settings, Mesh::new(&vertices, &faces));
            for (pixel, found) in found.into_iter().enumerate() {
                let expected = (expected(pixel) + added).clamp(0.0, 1.0);
                let what = format!("{depth_bias:?}, renderer {renderer}, pixel {pixel}");
                assert_eq!(f64::from(found), expected, "{what}");
            }
        }
        // Alone, and by the scan converter.
        let mut scan = ScanConverter::new(settings.viewport);
        scan.settings = settings;
        for face in &faces {
            let polygon: Vec<_> = face.iter().map(|&i| vertices[i as usize]).collect();
            for span in scan.spans(&polygon) {
                for f in span.fragments() {
                    let expected = expected(f.y as usize * SIDE as usize + f.x as usize) + added;
                    assert_eq!(f64::from(f.depth), expected.clamp(0.0, 1.0), "{depth_bias:?}");
                }
            }
        }
    }
}

#[test]
fn a_clipped_polygon_is_moved_as_well() {
    // A constant depth: exact wherever it is cut.
    let huge = [at(-1e7, -1e7, 0.5), at(1e7, -1e7, 0.5), at(0.0, 1e7, 0.5)];
    let concave = [at(0.0, 0.0, 0.5), at(1e6, 0.0, 0.5), at(64.0, 64.0, 0.5), at(0.0, 1e6, 0.5)];
    for renderer in 0..3 {
        let mut settings = Settings::new(Viewport::new(SIDE, SIDE).expect("small"));
        settings.depth_bias = bias(-0.375, 5.0);
        for polygon in [&huge[..], &concave[..]] {
            let found = depths(renderer, &settings, polygon);
            assert!(found.iter().all(|&depth| depth == 0.125), "renderer {renderer}");
        }
    }
}

#[test]
fn one_over_w_is_not_moved() {
    let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0) * 4.0, []));
    let mut settings = Settings::new(Viewport::new(SIDE, SIDE).expect("small"));
    (settings.depth, settings.depth_bias) = (DepthMode::InverseW, bias(0.125, 1.0));
    assert!(depths(0, &settings, &quad).iter().all(|&depth| depth == 0.25));
}

// ------------------------------------------------------------------------------------------ a decal

/// How many pixels of a decal are seen on a wall, and how many it covers.
fn decal_on_wall(
    wall: &[Vertex<0>],
    wall_faces: &[[u32; 3]],
    decal: &[Vertex<0>],
    mode: DepthMode,
    depth_bias: DepthBias,
) -> (usize, usize) {
    let mut frame = Framebuffer::new(SIDE, SIDE, '.').expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.settings.depth = mode;
    renderer.clear(&mut frame, '.');
    renderer.draw(&mut frame, decal, dynamic(|_| '#'));
    let covered = frame.color().iter().filter(|&&c| c == '#').count();
    renderer.clear(&mut frame, '.');
    renderer.draw(&mut frame, Mesh::new(wall, wall_faces), dynamic(|_| 'w'));
    assert!(frame.color().iter().all(|&c| c == 'w'), "the wall is everywhere");
    renderer.settings.depth_bias = depth_bias;
    renderer.draw(&mut frame, decal, dynamic(|_| '#'));
    (frame.color().iter().filter(|&&c| c == '#').count(), covered)
}

/// The wall as two triangles.
fn wall(place: impl Fn(f64, f64) -> Vertex<0>) -> ([Vertex<0>; 4], [[u32; 3]; 2]) {
    (
        [place(0.0, 0.0), place(64.0, 0.0), place(64.0, 64.0), place(0.0, 64.0)],
        [[0, 1, 2], [0, 2, 3]],
    )
}

#[test]
fn an_exact_decal_is_seen_with_a_bias_and_not_without() {
    // All depths are exact, so wall and decal tie, and the first wins.
    let (vertices, faces) = wall(exact);
    let decal = [exact(16.0, 8.0), exact(48.0, 8.0), exact(48.0, 40.0), exact(16.0, 40.0)];
    for (small, mode) in [(-1e-6, DepthMode::Standard), (1e-6, DepthMode::Reversed)] {
        let seen = |depth_bias| decal_on_wall(&vertices, &faces, &decal, mode, depth_bias);
        assert_eq!(seen(DepthBias::default()), (0, 32 * 32), "{mode:?}");
        assert_eq!(seen(bias(small, 0.0)), (32 * 32, 32 * 32), "{mode:?}");
        assert_eq!(seen(bias(0.0, small)), (0, 32 * 32), "less than depths can tell: {mode:?}");
        assert_eq!(seen(bias(0.0, 1e3 * small)), (32 * 32, 32 * 32), "{mode:?}");
        assert_eq!(seen(bias(-small, 0.0)), (0, 32 * 32), "behind: {mode:?}");
    }
}

#[test]
fn any_decal_is_seen_whole_with_a_small_bias() {
    let mut without = 0;
    for seed in 0..200 {
        let rng = &mut Rng::new(seed);
        let slopes = [0; 2].map(|_| rng.range(-0.3, 0.3) / f64::from(SIDE));
        // In perspective, so that nothing is exact.
        let tilt = [0; 2].map(|_| rng.range(-0.4, 0.4) / f64::from(SIDE));
        let place = |x: f64, y: f64| {
            let (dx, dy) = (x - 32.0, y - 32.0);
            let w = 1.0 / (1.0 + tilt[0] * dx + tilt[1] * dy);
            let mut vertex = at(x, y, 0.5 + slopes[0] * dx + slopes[1] * dy);
            vertex.position *= w as f32;
            vertex
        };
        let (vertices, faces) = wall(place);
        let decal: Vec<_> = (0..3 + rng.below(5))
            .map(|i| {
                let angle = f64::from(i as u32) * 0.9 + rng.range(0.0, 0.8);
                place(32.0 + 25.0 * angle.cos(), 32.0 + 25.0 * angle.sin())
            })
            .collect();
        // Half a pixel of slope moves more than the corners' rounding to f32 does.
        let (seen, covered) =
            decal_on_wall(&vertices, &faces, &decal, DepthMode::Standard, bias(-1e-6, 0.0));
        assert_eq!(seen, covered, "seed {seed}");
        let none = DepthBias::default();
        let (seen, covered) = decal_on_wall(&vertices, &faces, &decal, DepthMode::Standard, none);
        without += usize::from(seen < covered);
    }
    assert!(without > 150, "{without} of 200 decals fight with the wall");
}
