//! Pictures whose pixels are means of many samples: those of larger pictures, and areas.

use glam::{Mat4, Vec2, Vec3, Vec4, vec4};
use polyscan::texture::Texture;
use polyscan::{Framebuffer, Mesh, Vertex, Viewport, ZBufferRenderer};

use crate::common::dynamic;
use crate::common::generators::Rng;

type Scene = (Vec<Vertex<2>>, Vec<[u32; 3]>);

/// Triangles in perspective, with texture coordinates.
fn scene(rng: &mut Rng) -> Scene {
    let mut number = |most: f64| rng.range(-most, most) as f32;
    let vertices = (0..60).map(|_| {
        let w = 2.0 + number(1.0);
        let position = vec4(number(1.4) * w, number(1.4) * w, (0.5 + number(0.5)) * w, w);
        Vertex::new(position, [number(3.0), number(3.0)])
    });
    (vertices.collect(), (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn picture() -> Texture {
    Texture::from_fn(7, 5, |x, y| vec4(x as f32 / 7.0, y as f32 / 5.0, 0.3, 1.0)).expect("texels")
}

fn draw(frame: &mut Framebuffer<Vec4>, viewport: Viewport, (vertices, faces): &Scene) {
    let texture = picture();
    ZBufferRenderer::new(viewport).draw(
        frame,
        Mesh::new(vertices, faces),
        dynamic(|fragment| texture.sample_footprint(&fragment.footprint(0, 1))),
    );
}

/// To the bit, colours and depths, in one strip and in many.
#[test]
fn a_grid_of_samples_is_a_larger_picture_made_smaller() {
    let rng = &mut Rng::new(64);
    let clear = vec4(0.1, 0.2, 0.3, 1.0);
    for (size, k) in [((40, 30), 1), ((41, 29), 2), ((33, 17), 3), ((300, 260), 8), ((5, 4), 0)] {
        let scene = scene(rng);
        let large = k.max(1);
        let mut expected = Framebuffer::new(size.0 * large, size.1 * large, clear).expect("pixels");
        let viewport = expected.viewport();
        draw(&mut expected, viewport, &scene);
        let expected = expected.downsampled(large).expect("pixels");
        let mut calls = 0;
        let found = Framebuffer::supersampled_by_grid(size, k, clear, |frame, viewport| {
            calls += 1;
            draw(frame, viewport, &scene);
        });
        let found = found.expect("pixels");
        assert_eq!(found.color(), expected.color(), "{size:?} {k}");
        assert_eq!(found.depth(), expected.depth(), "{size:?} {k}");
        assert_eq!(calls > 1, k == 8, "{calls}");
    }
}

/// The mean over points is the part of each pixel that is covered: by clipping in f64.
#[test]
fn many_points_see_the_area() {
    let rng = &mut Rng::new(512);
    let size = (6, 5);
    for (count, most) in [(64, 0.09), (512, 0.02)] {
        let mut worst = 0.0_f64;
        for _ in 0..20 {
            let corners: [[f64; 2]; 3] =
                std::array::from_fn(|_| [rng.range(0.0, 6.0), rng.range(0.0, 5.0)]);
            let found =
                Framebuffer::supersampled_by_points(size, count, 0.0_f32, |frame, moved: Mat4| {
                    let vertices = corners.map(|[x, y]| {
                        let ndc = vec4(x as f32 / 3.0 - 1.0, 1.0 - y as f32 / 2.5, 0.5, 1.0);
                        Vertex::new(moved * ndc, [])
                    });
                    ZBufferRenderer::new(frame.viewport()).draw(frame, &vertices, dynamic(|_| 1.0));
                });
            for (i, &part) in (0..).zip(found.expect("pixels").color()) {
                let area = area_in_pixel(&corners, f64::from(i % 6), f64::from(i / 6));
                worst = worst.max((f64::from(part) - area).abs());
            }
        }
        assert!(worst < most, "{count}: {worst}");
    }
}

/// The area of a triangle within a pixel (Sutherland and Hodgman).
fn area_in_pixel(corners: &[[f64; 2]; 3], left: f64, top: f64) -> f64 {
    let mut polygon = corners.to_vec();
    for (axis, bound, sign) in
        [(0, left, 1.0), (0, left + 1.0, -1.0), (1, top, 1.0), (1, top + 1.0, -1.0)]
    {
        let inside = |p: &[f64; 2]| (p[axis] - bound) * sign;
        let mut cut = Vec::new();
        for (i, from) in polygon.iter().enumerate() {
            let to = &polygon[(i + 1) % polygon.len()];
            let (a, b) = (inside(from), inside(to));
            if a >= 0.0 {
                cut.push(*from);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let t = a / (a - b);
                cut.push([0, 1].map(|k| from[k] + (to[k] - from[k]) * t));
            }
        }
        polygon = cut;
    }
    let cross = |(i, p): (usize, &[f64; 2])| {
        let q = polygon[(i + 1) % polygon.len()];
        p[0] * q[1] - p[1] * q[0]
    };
    (polygon.iter().enumerate().map(cross).sum::<f64>() / 2.0).abs()
}

/// One point is the pixel's centre, and a ramp has at its mean what it has there.
#[test]
fn points_lie_evenly_around_the_centre() {
    let rng = &mut Rng::new(3);
    let scene = scene(rng);
    let clear = Vec4::ZERO;
    let mut expected = Framebuffer::new(50, 40, clear).expect("pixels");
    let viewport = expected.viewport();
    draw(&mut expected, viewport, &scene);
    let found = Framebuffer::supersampled_by_points((50, 40), 1, clear, |frame, moved| {
        let vertices = scene.0.iter().map(|v| Vertex::new(moved * v.position, v.params));
        let viewport = frame.viewport();
        draw(frame, viewport, &(vertices.collect(), scene.1.clone()));
    });
    assert_eq!(found.expect("pixels").color(), expected.color());

    for count in [16, 64, 512] {
        let mean =
            Framebuffer::supersampled_by_points((8, 4), count, Vec3::ZERO, |frame, moved| {
                let quad = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
                    .map(|(x, y)| Vertex::new(moved * vec4(x, y, 0.5, 1.0), [4.0 * x, -2.0 * y]));
                ZBufferRenderer::new(frame.viewport()).draw(
                    frame,
                    &quad,
                    dynamic(|fragment| Vec2::from(fragment.params).extend(1.0)),
                );
            });
        for (i, mean) in (0..).zip(mean.expect("pixels").color()) {
            // In pixels from the middle of the picture.
            let at = Vec2::new((i % 8) as f32 - 3.5, (i / 8) as f32 - 1.5);
            assert!((mean.truncate() - at).length() < 1.5 / 256.0, "{count}: {mean} {at}");
        }
    }
}
