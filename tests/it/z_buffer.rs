//! The z-buffer renderer: depth tests, discarding, depth without colour, any colour type.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::generators::{self, Rng};
use crate::common::{dynamic, dynamic_blocks, vertices};
use glam::vec4;
use polyscan::render::{Additive, Over};
use polyscan::{
    DepthMode, DepthTest, Fragment, Framebuffer, ScanConverter, Vertex, Viewport, ZBufferRenderer,
};

const TESTS: [DepthTest; 8] = [
    DepthTest::Never,
    DepthTest::Nearer,
    DepthTest::Equal,
    DepthTest::NearerOrEqual,
    DepthTest::Farther,
    DepthTest::NotEqual,
    DepthTest::FartherOrEqual,
    DepthTest::Always,
];

/// A square over the whole view at a depth.
fn square(z: f32) -> [Vertex<0>; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []))
}

fn frame<C: Copy>(color: C) -> Framebuffer<C> {
    Framebuffer::new(20, 2, color).expect("a small frame")
}

#[test]
fn the_eight_comparisons() {
    // Whether nearer, equal and farther depths pass each test.
    let passes = [
        [false, false, false],
        [true, false, false],
        [false, true, false],
        [true, true, false],
        [false, false, true],
        [true, false, true],
        [false, true, true],
        [true, true, true],
    ];
    for (test, passes) in TESTS.into_iter().zip(passes) {
        for (z, pass) in [0.25, 0.5, 0.75].into_iter().zip(passes) {
            check_comparison(DepthMode::Standard, test, z, pass);
            // What is nearer if less was less is nearer if greater is.
            check_comparison(DepthMode::Reversed, test, 1.0 - z, pass);
        }
    }
}

/// Whether a square passes a test against a depth of 1/2.
fn check_comparison(mode: DepthMode, test: DepthTest, z: f32, pass: bool) {
    for depth_write in [true, false] {
        let mut frame = frame(0u32);
        frame.clear(0, 0.5);
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.settings.depth = mode;
        (renderer.depth_test, renderer.depth_write) = (test, depth_write);
        renderer.draw(&mut frame, &square(z), dynamic(|_| 1));
        let color = u32::from(pass);
        let depth = if pass && depth_write { z } else { 0.5 };
        assert!(frame.color().iter().all(|&c| c == color), "{mode:?}, {test:?} at {z}");
        assert!(frame.depth().iter().all(|&d| d == depth), "{mode:?}, {test:?} at {z}");
    }
}

#[test]
fn a_discarded_fragment_leaves_colour_and_depth() {
    let mut frame = frame('.');
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw(&mut frame, &square(0.5), |f| (f.x % 3 == 0).then_some('#'));
    for (i, (&color, &depth)) in frame.color().iter().zip(frame.depth()).enumerate() {
        let expected = if i % 20 % 3 == 0 { ('#', 0.5) } else { ('.', 1.0) };
        assert_eq!((color, depth), expected);
    }
}

#[test]
fn depth_alone_is_never_shaded_and_hides_what_is_behind() {
    let mut frame = frame(0u8);
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw_depth(&mut frame, &square(0.5));
    assert!(frame.color().iter().all(|&c| c == 0) && frame.depth().iter().all(|&d| d == 0.5));
    let shaded = Cell::new(0);
    let mut draw = |z, test| {
        renderer.depth_test = test;
        shaded.set(0);
        renderer.on_one_thread().draw(&mut frame, &square(z), |_| {
            shaded.set(shaded.get() + 1);
            1
        });
        shaded.get()
    };
    assert_eq!(draw(0.6, DepthTest::Nearer), 0);
    assert_eq!(draw(0.5, DepthTest::Equal), 40);
}

#[test]
fn the_depth_range_and_reversed_depth() {
    let viewport = Viewport::new(20, 2).expect("small").with_depth(1.0, 0.0);
    // The mode says which depth is nearer; without it the test has to ask for what is farther.
    for (mode, test) in
        [(DepthMode::Reversed, DepthTest::Nearer), (DepthMode::Standard, DepthTest::Farther)]
    {
        let mut frame = frame(7u8);
        let mut renderer = ZBufferRenderer::new(viewport);
        (renderer.settings.depth, renderer.depth_test) = (mode, test);
        renderer.clear(&mut frame, 0);
        assert_eq!(frame.pixel(3, 1), Some((0, mode.farthest())));
        frame.clear(0, 0.0);
        for (z, color) in [(0.75, 1), (0.25, 2), (0.5, 3)] {
            renderer.draw(&mut frame, &square(z), dynamic(|_| color));
        }
        assert_eq!(frame.pixel(3, 1), Some((2, 0.75)), "{mode:?}");
        assert_eq!(frame.pixel(20, 1), None);
    }
}

/// The number of the visible triangle at each pixel, with depth from z or from 1/w.
fn visible(mode: DepthMode, scene: &[Vec<Vertex<0>>]) -> Vec<usize> {
    let mut frame = Framebuffer::new(80, 60, usize::MAX).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.settings.depth = mode;
    renderer.clear(&mut frame, usize::MAX);
    for (number, polygon) in scene.iter().enumerate() {
        renderer.draw(&mut frame, polygon, dynamic(|_| number));
    }
    frame.color().to_vec()
}

#[test]
fn one_over_w_as_depth_gives_the_same_picture_in_perspective() {
    let rng = &mut Rng::new(5);
    let scene: Vec<_> = (0..30)
        .map(|_| {
            let mut triangle = vertices(&generators::random_triangle::<0>(rng, 20.0, 1.2));
            // What a perspective matrix with near plane 1/2 and an infinite far plane gives.
            triangle.iter_mut().for_each(|v| v.position.z = v.position.w - 0.5);
            triangle
        })
        .collect();
    let [by_z, by_w] = [DepthMode::Standard, DepthMode::InverseW].map(|s| visible(s, &scene));
    let different = by_z.iter().zip(&by_w).filter(|(a, b)| a != b).count();
    // The two round differently where triangles cross.
    assert!(different <= 3, "{different} pixels differ");
    assert!(by_z.iter().filter(|&&n| n < 30).count() > 1000);
}

#[test]
fn orthographic_scenes_are_right_with_the_default_depth() {
    let near_last = [square(0.9).to_vec(), square(0.1).to_vec()];
    let near_first = [square(0.1).to_vec(), square(0.9).to_vec()];
    assert!(visible(DepthMode::Standard, &near_last).iter().all(|&n| n == 1));
    assert!(visible(DepthMode::Standard, &near_first).iter().all(|&n| n == 0));
}

#[test]
fn a_mesh_is_drawn_face_by_face() {
    let vertices = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
    let mut frame = frame('.');
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    let shaded = AtomicUsize::new(0);
    let faces: [&[u32]; 4] = [&[0, 1, 2], &[0, 2, 3], &[0, 1, 7], &[0, 1]];
    renderer.draw(
        &mut frame,
        polyscan::Mesh::new(&vertices, faces),
        dynamic(|_| {
            shaded.fetch_add(1, Ordering::Relaxed);
            '#'
        }),
    );
    assert_eq!(shaded.into_inner(), 40, "the two triangles share an edge and nothing else");
    assert!(frame.color().iter().all(|&c| c == '#'));
}

#[test]
fn a_fragment_knows_its_face() {
    // A face that draws nothing has a number all the same; the last one reaches behind the eye.
    let vertices: Vec<_> = [(-2.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-2.0, 1.0), (2.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
        .into_iter()
        .chain([Vertex::new(vec4(0.0, 3.0, -0.5, -1.0), [])])
        .collect();
    let faces: [&[u32]; 4] = [&[0, 1, 9], &[0, 1, 2, 3], &[1, 2], &[1, 4, 5]];
    let mut frame = frame(u32::MAX);
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw(
        &mut frame,
        polyscan::Mesh::new(&vertices, faces),
        dynamic(|fragment| fragment.face),
    );
    assert_eq!(frame.pixel(5, 1).map(|(face, _)| face), Some(1));
    assert_eq!(frame.pixel(12, 1).map(|(face, _)| face), Some(3));
    let by_fragments = frame.clone();
    frame.clear(u32::MAX, 1.0);
    renderer.draw_blocks(
        &mut frame,
        polyscan::Mesh::new(&vertices, faces),
        dynamic_blocks(|block, colors| {
            *colors = [block.face; polyscan::fragment::LANES];
        }),
    );
    assert_eq!(frame, by_fragments);
    renderer.draw(&mut frame, &square(0.25), dynamic(|fragment| fragment.face));
    assert!(frame.color().iter().all(|&face| face == 0));
}

/// Layers of glass and light, against the same sums in f64.
#[test]
fn blending_is_over_and_plus() {
    let layers = [[0.5, 0.25, 0.0, 0.5], [0.0, 0.1, 0.2, 0.3], [0.7, 0.7, 0.7, 1.0], [0.0; 4]];
    let mut rng = Rng::new(7);
    for _ in 0..100 {
        let mut frame = frame(vec4(0.125, 0.25, 0.5, 1.0));
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.depth_test = DepthTest::Always;
        let mut expected = [0.125f64, 0.25, 0.5, 1.0];
        for _ in 0..6 {
            let color = layers[rng.below(4)];
            let glass = rng.below(2) == 0;
            if glass {
                renderer.draw(&mut frame, &square(0.5), |_| Over(color.into()));
            } else {
                renderer.draw(&mut frame, &square(0.5), |_| Additive(color.into()));
            }
            let through = if glass { 1.0 - f64::from(color[3]) } else { 1.0 };
            for (expected, color) in expected.iter_mut().zip(color) {
                *expected = f64::from(color) + *expected * through;
            }
        }
        for pixel in frame.color() {
            for (found, expected) in pixel.to_array().into_iter().zip(expected) {
                assert!((f64::from(found) - expected).abs() <= 1e-6, "{found} {expected}");
            }
        }
    }
}

#[test]
fn a_reduced_picture_has_the_means_of_its_blocks() {
    let mut frame = Framebuffer::new(5, 4, 0.0f32).expect("a small frame");
    for (i, (color, depth)) in (0u8..).zip(frame.color_mut().iter_mut().zip([0.5; 20])) {
        *color = f32::from(i) + depth - 0.5;
    }
    frame.depth_mut()[6] = 0.25;
    let half = frame.downsampled(2).expect("smaller");
    assert_eq!((half.width(), half.height()), (2, 2));
    assert_eq!(half.color(), [3.0, 5.0, 13.0, 15.0]);
    assert_eq!(half.depth(), [0.25, 1.0, 1.0, 1.0]);
    assert_eq!(frame.downsampled(0).expect("as it is"), frame);
    assert_eq!(frame.downsampled(9).expect("nothing left").color(), [0.0_f32; 0]);
}

#[cfg(feature = "image")]
#[test]
fn pictures_go_in_and_come_out() {
    let picture = image::RgbaImage::from_fn(6, 4, |x, y| {
        image::Rgba([x as u8 * 40, y as u8 * 60, 7, 255 - x as u8])
    });
    let mut frame = Framebuffer::try_from(&picture).expect("a small picture");
    assert_eq!(frame.to_image(), picture);
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw(&mut frame, &square(0.5)[..3], |_| [1, 2, 3, 4]);
    let drawn = frame.to_image();
    assert_eq!(drawn.get_pixel(5, 3).0, [1, 2, 3, 4]);
    assert_eq!(drawn.get_pixel(0, 0), picture.get_pixel(0, 0));
}

/// What a shader is told of a pixel: column, row, face, and the bits of w and the parameters.
type Told = (i32, i32, u32, u32, [u32; 3]);

/// Polygons a few pixels large, in and around a frame, some with values that have no plane.
fn small_polygons(rng: &mut Rng, width: u32, height: u32) -> Vec<Vec<Vertex<3>>> {
    let polygon = |rng: &mut Rng, sides: usize| {
        let size = rng.octaves(0.5, 20.0);
        let centre = [width, height].map(|pixels| rng.range(-2.0, f64::from(pixels) + 2.0));
        let start = rng.range(0.0, 6.3);
        let vertex = |corner: usize| {
            let angle = start + corner as f64 * 6.3 / sides as f64;
            let [x, y] = [centre[0] + size * angle.cos(), centre[1] + size * angle.sin()];
            let [x, y] = [2.0 * x / f64::from(width) - 1.0, 1.0 - 2.0 * y / f64::from(height)];
            let (w, z) = (rng.octaves(1.0, 10.0), rng.range(0.1, 0.9));
            let position = [x * w, y * w, z * w, w].map(|coordinate| coordinate as f32);
            Vertex::new(position.into(), [0; 3].map(|_| rng.range(-1.0, 1.0) as f32))
        };
        (0..sides).map(vertex).collect()
    };
    (0..12).map(|i| polygon(rng, if i % 4 == 0 { 4 } else { 3 })).collect()
}

#[test]
fn small_polygons_are_drawn_as_their_fragments_say_in_frames_of_any_width() {
    let rng = &mut Rng::new(77);
    let (mut pixels, mut shared) = (0, 0);
    for width in 1..=40 {
        for height in [1, 2, 5, 33, 70] {
            let scene = small_polygons(rng, width, height);
            let empty = (-1, -1, u32::MAX, 0, [0; 3]);
            let frame = || Framebuffer::<Told>::new(width, height, empty).expect("a small frame");
            let told = |f: &Fragment<'_, 3>, face: u32| {
                (f.x, f.y, face, f.w.to_bits(), f.params.map(f32::to_bits))
            };
            // One fragment after the other, as the scan converter gives them.
            let (mut colors, mut depths) = (frame().color().to_vec(), frame().depth().to_vec());
            let mut scan = ScanConverter::new(frame().viewport());
            for (face, polygon) in scene.iter().enumerate() {
                for span in scan.spans(polygon) {
                    for f in span.fragments() {
                        let pixel = f.y as usize * width as usize + f.x as usize;
                        shared += u32::from(colors[pixel] != empty);
                        if f.depth < depths[pixel] {
                            (colors[pixel], depths[pixel]) = (told(&f, face as u32), f.depth);
                        }
                    }
                }
            }
            pixels += colors.iter().filter(|&&color| color != empty).count();

            let vertices = scene.concat();
            let mut next = 0;
            let faces: Vec<Vec<u32>> = scene
                .iter()
                .map(|polygon| {
                    next += polygon.len() as u32;
                    (next - polygon.len() as u32..next).collect()
                })
                .collect();
            let mut by_fragment = frame();
            let mut renderer = ZBufferRenderer::new(by_fragment.viewport());
            renderer.draw(&mut by_fragment, polyscan::Mesh::new(&vertices, &faces), |f| {
                told(f, f.face)
            });
            assert_eq!((by_fragment.color(), by_fragment.depth()), (&colors[..], &depths[..]));
            let mut by_block = frame();
            renderer.draw_blocks(
                &mut by_block,
                polyscan::Mesh::new(&vertices, &faces),
                |block, colors| {
                    for (lane, color) in colors.iter_mut().enumerate() {
                        let (x, y) = block.position(lane);
                        let params = std::array::from_fn(|i| block.params[i][lane].to_bits());
                        *color = (x, y, block.face, block.w[lane].to_bits(), params);
                    }
                },
            );
            assert_eq!((by_block.color(), by_block.depth()), (&colors[..], &depths[..]));
        }
    }
    // There was something to see, and something hidden.
    assert!(pixels > 30_000 && shared > 10_000, "{pixels} pixels, {shared} drawn again");
}
