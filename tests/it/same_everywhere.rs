//! Contract 6: the same image to the bit, however it is cut into tiles.

use crate::common::generators::{self, Rng};
use crate::common::vertices;
use glam::vec4;
use polyscan::{Framebuffer, Rect, Vertex, Viewport, ZBufferRenderer};

const WIDTH: u32 = 333;
const HEIGHT: u32 = 217;

/// Polygons of all kinds, some through the eye, some with values that are not affine.
fn scene() -> Vec<Vec<Vertex<3>>> {
    let rng = &mut Rng::new(11);
    let mut scene = Vec::new();
    for _ in 0..40 {
        let sides = 3 + rng.below(10);
        let w_ratio = rng.octaves(1.0, 1000.0);
        scene.push(vertices(&generators::random_triangle(rng, w_ratio, 1.5)));
        scene.push(vertices(&generators::random_convex(rng, sides, w_ratio)));
        scene.push(vertices(&generators::through_eye(rng, sides)));
        let quad = [(-0.4, -0.4), (0.5, -0.3), (0.4, 0.6), (-0.5, 0.3)].map(|(x, y)| {
            let (dx, dy) = (rng.range(-1.0, 1.0) as f32, rng.range(-1.0, 1.0) as f32);
            let w = rng.octaves(1.0, 9.0) as f32;
            let color = std::array::from_fn(|_| rng.range(0.0, 1.0) as f32);
            Vertex::new(vec4((x + dx) * w, (y + dy) * w, rng.range(0.0, 1.0) as f32 * w, w), color)
        });
        scene.push(quad.to_vec());
    }
    scene
}

/// Colour and depth of a pixel, as bits.
type Bits = ([u32; 3], u32);

fn bits(frame: &Framebuffer<[f32; 3]>, x: u32, y: u32) -> Bits {
    let (color, depth) = frame.pixel(x, y).expect("inside the frame");
    (color.map(f32::to_bits), depth.to_bits())
}

fn draw(frame: &mut Framebuffer<[f32; 3]>, renderer: &mut ZBufferRenderer<3>) {
    for polygon in scene() {
        renderer.draw(frame, &polygon, |fragment| {
            let (dx, dy) = fragment.derivatives();
            let [r, g, b] = fragment.params;
            [r + fragment.w, g + dx[1], b + dy[2]]
        });
    }
}

fn whole() -> Framebuffer<[f32; 3]> {
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, [0.0; 3]).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    draw(&mut frame, &mut renderer);
    frame
}

#[test]
fn a_tile_drawn_alone_equals_the_crop_of_the_whole() {
    let whole = whole();
    assert!(whole.depth().iter().filter(|&&depth| depth < 1.0).count() > 30_000);
    let viewport = Viewport::new(WIDTH, HEIGHT).expect("small");
    for (tile_width, tile_height) in [(31, 29), (16, 64), (61, 217), (333, 7), (100, 64)] {
        for top in (0..HEIGHT).step_by(tile_height as usize) {
            for left in (0..WIDTH).step_by(tile_width as usize) {
                let mut tile =
                    Framebuffer::new(tile_width, tile_height, [0.0; 3]).expect("a small frame");
                let mut renderer =
                    ZBufferRenderer::new(viewport.with_corner(-(left as i32), -(top as i32)));
                draw(&mut tile, &mut renderer);
                for y in 0..tile_height.min(HEIGHT - top) {
                    for x in 0..tile_width.min(WIDTH - left) {
                        assert_eq!(bits(&tile, x, y), bits(&whole, left + x, top + y));
                    }
                }
            }
        }
    }
}

#[test]
fn a_scissor_changes_nothing_inside() {
    let whole = whole();
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, [0.0; 3]).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    let columns = [0, 1, 18, 50, 51, 200, 333];
    for pair in columns.windows(2) {
        let [left, right] = [pair[0], pair[1]];
        renderer.settings.scissor =
            Some(Rect { x: left, y: 0, width: (right - left) as u32, height: HEIGHT });
        draw(&mut frame, &mut renderer);
    }
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            assert_eq!(bits(&frame, x, y), bits(&whole, x, y), "pixel {x}, {y}");
        }
    }
}
