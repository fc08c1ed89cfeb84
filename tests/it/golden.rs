//! Golden pictures. Each was looked at, and each is computed here a second time, pixel by pixel,
//! from the oracle's coverage and rays, without any of the library's stages.
//!
//! `POLYSCAN_BLESS=1 cargo test --test it golden::` writes them anew, for somebody to look at.

use std::path::Path;

use crate::common::generators::Shape;
use crate::common::oracle::{self, Depth, FillRule, Window};
use crate::common::{vertices, viewport};
use image::{Rgb, RgbImage};
use polyscan::{Framebuffer, ZBufferRenderer};

const WINDOW: Window = Window { width: 120, height: 90 };
const PAPER: [u8; 3] = [236, 232, 220];

/// What a picture shows: shapes, and a colour for the parameters of each.
struct Scene {
    name: &'static str,
    shapes: Vec<Shape<3>>,
    shader: fn([f64; 3]) -> [u8; 3],
}

/// A quad with (u, v) at its corners, at clip-space positions made by hand: w = 1 + x / 2 + y / 4
/// for corners (±1, ±1), seen from aside. The uneven numbers keep pixel centres off the lines of the
/// checkers, where f32 and f64 may disagree.
fn quad() -> Scene {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let shape = Shape {
        positions: corners
            .map(|(x, y)| {
                let w = 1.0 + 0.5 * x + 0.25 * y;
                [0.731 * x - 0.117 * y, 0.523 * y + 0.271 * x + 0.0173, 0.5 * w, w]
            })
            .to_vec(),
        parameters: corners.map(|(x, y)| [0.5 + 0.5 * x, 0.5 - 0.5 * y, 0.0]).to_vec(),
    };
    fn checker([u, v, _]: [f64; 3]) -> [u8; 3] {
        let [column, row] = [u, v].map(|c| (c * 8.0).floor());
        match (column + row).rem_euclid(2.0) {
            _ if column == 0.0 && row == 0.0 => [200, 40, 30],
            0.0 => [30, 40, 80],
            _ => [240, 200, 110],
        }
    }
    Scene { name: "quad", shapes: vec![shape], shader: checker }
}

/// Three triangles that run through each other, with a colour at each corner; one comes from behind
/// the eye.
fn crossing() -> Scene {
    let triangle = |positions: [[f32; 4]; 3]| Shape {
        positions: positions.to_vec(),
        parameters: vec![[1.0, 0.1, 0.1], [0.1, 0.9, 0.2], [0.2, 0.3, 1.0]],
    };
    Scene {
        name: "crossing",
        shapes: vec![
            triangle([[-0.9, -0.7, 0.2, 1.0], [1.8, 0.2, 1.6, 2.0], [-0.4, 0.9, 0.6, 1.0]]),
            triangle([[0.9, -0.8, 0.3, 1.0], [0.8, 0.9, 0.5, 1.0], [-2.4, 0.1, 2.2, 3.0]]),
            triangle([[-3.0, -2.5, 3.2, 4.0], [3.0, -2.0, 3.6, 4.0], [0.2, -1.4, -0.5, -0.25]]),
        ],
        shader: |rgb| rgb.map(|c| (c * 255.0).round() as u8),
    }
}

/// What the library draws.
fn drawn(scene: &Scene) -> RgbImage {
    let mut frame = Framebuffer::new(WINDOW.width, WINDOW.height, PAPER).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(viewport(WINDOW));
    for shape in &scene.shapes {
        renderer.draw(&mut frame, &vertices(shape), |f| (scene.shader)(f.params.map(f64::from)));
    }
    image::DynamicImage::from(frame.to_image()).into_rgb8()
}

/// The same from the oracle: for each pixel, the nearest of the planes that the ray through its
/// centre meets where the shape's outline covers it.
fn computed(scene: &Scene) -> RgbImage {
    let masks: Vec<_> = scene
        .shapes
        .iter()
        .map(|shape| {
            let guard = f64::from(polyscan::viewport::GUARD_BAND);
            oracle::coverage(&shape.positions, WINDOW, Depth::ZeroToOne, guard, FillRule::NonZero)
        })
        .collect();
    RgbImage::from_fn(WINDOW.width, WINDOW.height, |x, y| {
        let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let hits = scene.shapes.iter().zip(&masks).filter(|(_, mask)| mask.contains(x, y));
        let samples = hits.filter_map(|(shape, _)| {
            oracle::sample(&shape.positions, &shape.parameters, [0, 1, 2], WINDOW, at)
        });
        let nearest = samples.min_by(|a, b| a.z_over_w.total_cmp(&b.z_over_w));
        Rgb(nearest.map_or(PAPER, |sample| (scene.shader)(sample.values)))
    })
}

fn check(scene: &Scene) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/{}.png", scene.name));
    let drawn = drawn(scene);
    if std::env::var_os("POLYSCAN_BLESS").is_some() {
        drawn.save(&path).expect("tests/data can be written");
    }
    let golden = image::open(&path).expect("the golden picture is there").into_rgb8();
    for (x, y, pixel) in drawn.enumerate_pixels() {
        assert_eq!(pixel, golden.get_pixel(x, y), "{}: pixel {x}, {y}", scene.name);
    }
    let computed = computed(scene);
    for (x, y, pixel) in computed.enumerate_pixels() {
        let other = golden.get_pixel(x, y);
        // The last code may round differently: f32 here, f64 there.
        let near = pixel.0.iter().zip(other.0).all(|(a, b)| a.abs_diff(b) <= 1);
        assert!(near, "{}: pixel {x}, {y} is computed as {pixel:?}, not {other:?}", scene.name);
    }
}

#[test]
fn a_quad_in_perspective() {
    check(&quad());
}

#[test]
fn triangles_that_cross_and_come_from_behind_the_eye() {
    check(&crossing());
}
