//! The front of the renderers: any geometry, by any way of drawing, by any renderer, on any target, in
//! any mode of depth gives the picture that the z-buffer draws fragment by fragment.
//!
//! The scenes have one face in each of some layers of depth, so nothing crosses and nothing ties: there
//! all three renderers owe the same picture to the bit, the painter by any order that it knows.

use std::array::from_fn;

use crate::common::generators::{self, Rng};
use crate::common::{dynamic, dynamic_blocks, dynamic_blocks_mut, dynamic_mut};
use glam::camera::rh::proj::directx::perspective;
use glam::{Mat4, Vec2, Vec4, vec4};
use polyscan::fragment::LANES;
use polyscan::render::{Geometry, RenderTarget};
use polyscan::{
    BspTree, DepthMode, Fragment, FragmentBlock, Framebuffer, Mesh, PainterRenderer,
    ScanlineRenderer, Settings, Target, TargetError, Vertex, ZBufferRenderer,
};

const WIDTH: u32 = 150;
const HEIGHT: u32 = 110;

/// What a fragment tells: its face from 1 on, and the bits of its depth, w and parameters.
type Told = (u32, [u32; 4]);
const NOTHING: Told = (0, [0; 4]);
type Frame = Framebuffer<Told>;

fn told(f: &Fragment<'_, 2>) -> Told {
    (f.face + 1, [f.depth, f.w, f.params[0], f.params[1]].map(f32::to_bits))
}

/// The same of each fragment of a block.
fn told_by_block(block: &mut FragmentBlock<'_, 2>, colors: &mut [Told; LANES]) {
    for (lane, color) in colors.iter_mut().enumerate() {
        *color = told(&block.fragment(lane));
    }
}

// ------------------------------------------------------------------------------------------ scenes

/// Faces in object space with w = 1, the farthest first or in any other order.
struct Scene {
    vertices: Vec<Vertex<2>>,
    faces: Vec<Vec<u32>>,
    /// How far each is behind the others: the order from back to front is that of falling layers.
    layers: Vec<usize>,
    matrix: Mat4,
}

impl Scene {
    /// Faces of so many layers in any order, each within its own. `outline` gives a face's places.
    fn new(rng: &mut Rng, count: usize, outline: impl Fn(&mut Rng) -> Vec<Vec2>) -> Self {
        let mut layers: Vec<usize> = (0..count).collect();
        rng.shuffle(&mut layers);
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for &layer in &layers {
            // The middle half of the layer, whatever the slopes: |x| + |y| is at most 4.
            let slope = Vec2::from_array(from_fn(|_| rng.range(-0.02, 0.02) as f32));
            let first = vertices.len() as u32;
            for place in outline(rng) {
                let z = -2.0 - 0.4 * layer as f32 + slope.dot(place);
                let params = [0; 2].map(|_| rng.range(-1.0, 1.0) as f32);
                vertices.push(Vertex::new(place.extend(z).extend(1.0), params));
            }
            faces.push((first..vertices.len() as u32).collect());
        }
        let matrix = perspective(0.9, WIDTH as f32 / HEIGHT as f32, 1.0, 20.0);
        Self { vertices, faces, layers, matrix }
    }

    fn in_clip_space(&self) -> Vec<Vertex<2>> {
        let vertex = |v: &Vertex<2>| Vertex { position: self.matrix * v.position, ..*v };
        self.vertices.iter().map(vertex).collect()
    }

    /// The numbers of the faces from the farthest to the nearest.
    fn back_to_front(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.faces.len()).collect();
        order.sort_by_key(|&face| std::cmp::Reverse(self.layers[face]));
        order
    }
}

fn triangle(rng: &mut Rng) -> Vec<Vec2> {
    (0..3).map(|_| Vec2::from_array(from_fn(|_| rng.range(-1.6, 1.6) as f32))).collect()
}

/// A triangle, a convex polygon, or one that is concave.
fn any_outline(rng: &mut Rng) -> Vec<Vec2> {
    if rng.once_in(3) {
        return triangle(rng);
    }
    let centre = Vec2::from_array(from_fn(|_| rng.range(-0.8, 0.8) as f32));
    if rng.once_in(2) {
        let place = |p: &[f64; 2]| centre + Vec2::new(p[0] as f32, p[1] as f32);
        return generators::comb(rng).iter().map(place).collect();
    }
    let (sides, size) = (4 + rng.below(6), rng.range(0.2, 1.0) as f32);
    let corner = |i| Vec2::from_angle(i as f32 * std::f32::consts::TAU / sides as f32);
    (0..sides).map(|i| centre + corner(i) * size).collect()
}

// ------------------------------------------------------------------------------ every way of drawing

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Draw,
    Blocks,
    Depth,
}

/// A way of drawing, and whether it is on one thread.
const WAYS: [(Way, bool); 6] = [
    (Way::Draw, false),
    (Way::Blocks, false),
    (Way::Depth, false),
    (Way::Draw, true),
    (Way::Blocks, true),
    (Way::Depth, true),
];

/// A renderer with the methods that all have.
trait Draws {
    const NAME: &'static str;

    fn new(settings: Settings<2>) -> Self;

    fn clear(&self, frame: &mut Frame);

    fn draw_by<T: RenderTarget<Color = Told>>(
        &mut self,
        frame: &mut T,
        geometry: impl Geometry<2>,
        way: (Way, bool),
    );
}

macro_rules! draws {
    ($renderer:ident, $set_up:expr) => {
        impl Draws for $renderer<2> {
            const NAME: &'static str = stringify!($renderer);

            fn new(settings: Settings<2>) -> Self {
                let mut renderer = Self::new(settings.viewport);
                renderer.settings = settings;
                $set_up(&mut renderer);
                renderer
            }

            fn clear(&self, frame: &mut Frame) {
                self.clear(frame, NOTHING);
            }

            fn draw_by<T: RenderTarget<Color = Told>>(
                &mut self,
                frame: &mut T,
                geometry: impl Geometry<2>,
                way: (Way, bool),
            ) {
                match way {
                    (Way::Draw, false) => self.draw(frame, geometry, dynamic(told)),
                    (Way::Blocks, false) => {
                        self.draw_blocks(frame, geometry, dynamic_blocks(told_by_block))
                    }
                    (Way::Depth, false) => self.draw_depth(frame, geometry),
                    (Way::Draw, true) => {
                        self.on_one_thread().draw(frame, geometry, dynamic_mut(told))
                    }
                    (Way::Blocks, true) => {
                        self.on_one_thread().draw_blocks(
                            frame,
                            geometry,
                            dynamic_blocks_mut(told_by_block),
                        );
                    }
                    (Way::Depth, true) => self.on_one_thread().draw_depth(frame, geometry),
                }
            }
        }
    };
}

draws!(ZBufferRenderer, |_: &mut Self| ());
draws!(ScanlineRenderer, |_: &mut Self| ());
draws!(PainterRenderer, |renderer: &mut Self| renderer.depth_write = true);

fn empty() -> Frame {
    Framebuffer::new(WIDTH, HEIGHT, NOTHING).expect("a small frame")
}

fn bits(depth: &[f32]) -> Vec<u32> {
    depth.iter().map(|d| d.to_bits()).collect()
}

/// Each kind of geometry by each way: the picture of the z-buffer.
fn check_renderer<R: Draws>(scene: &Scene, expected: &Frame, name: &str) {
    let vertices = scene.in_clip_space();
    let tree = BspTree::new(&scene.vertices, &scene.faces);
    let flat = scene.faces.concat();
    let is_triangles = scene.faces.iter().all(|face| face.len() == 3);
    let mut renderer = R::new(Settings::new(expected.viewport()));
    for way in WAYS {
        let mut check = |kind: &str, draw: &dyn Fn(&mut R, &mut Frame)| {
            let mut frame = empty();
            renderer.clear(&mut frame);
            draw(&mut renderer, &mut frame);
            let what = format!("{name}: {kind} by {}, {way:?}", R::NAME);
            assert_eq!(bits(frame.depth()), bits(expected.depth()), "depths of {what}");
            for (pixel, (color, expected)) in frame.color().iter().zip(expected.color()).enumerate()
            {
                let expected = match (way.0, kind) {
                    (Way::Depth, _) => NOTHING,
                    // A polygon that is drawn alone is face 0.
                    (_, "polygons") => (expected.0.min(1), expected.1),
                    _ => *expected,
                };
                assert_eq!(*color, expected, "pixel {pixel} of {what}");
            }
        };
        check("polygons", &|renderer, frame| {
            for face in scene.back_to_front() {
                let corners = scene.faces[face].iter().map(|&i| vertices[i as usize]);
                renderer.draw_by(frame, &corners.collect::<Vec<_>>(), way);
            }
        });
        check("mesh", &|renderer, frame| {
            renderer.draw_by(frame, Mesh::new(&vertices, &scene.faces), way);
        });
        check("sorted mesh", &|renderer, frame| {
            renderer.draw_by(frame, Mesh::new(&vertices, &scene.faces).back_to_front(), way);
        });
        check("tree", &|renderer, frame| {
            renderer.draw_by(frame, tree.seen_by(scene.matrix), way);
        });
        if is_triangles {
            check("triangles", &|renderer, frame| {
                renderer.draw_by(frame, Mesh::triangles(&vertices, &flat), way);
            });
            check("sorted triangles", &|renderer, frame| {
                renderer.draw_by(frame, Mesh::triangles(&vertices, &flat).back_to_front(), way);
            });
        }
    }
}

fn by_z_buffer(scene: &Scene) -> Frame {
    let mut expected = empty();
    let mesh_vertices = scene.in_clip_space();
    let mesh = Mesh::new(&mesh_vertices, &scene.faces);
    ZBufferRenderer::new(expected.viewport()).draw(&mut expected, mesh, dynamic(told));
    expected
}

fn seen(frame: &Frame) -> usize {
    let mut faces: Vec<u32> = frame.color().iter().map(|color| color.0).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.len() - usize::from(faces.contains(&0))
}

#[test]
fn every_geometry_by_every_way_and_renderer_gives_the_same_picture() {
    for seed in 0..6 {
        let rng = &mut Rng::new(seed);
        let count = 10 + rng.below(20);
        let scene = if seed % 2 == 0 {
            Scene::new(rng, count, any_outline)
        } else {
            Scene::new(rng, count, triangle)
        };
        let expected = by_z_buffer(&scene);
        assert!(seen(&expected) > 5, "seed {seed}: {} faces are seen", seen(&expected));
        let name = format!("seed {seed}");
        check_renderer::<ZBufferRenderer<2>>(&scene, &expected, &name);
        check_renderer::<ScanlineRenderer<2>>(&scene, &expected, &name);
        check_renderer::<PainterRenderer<2>>(&scene, &expected, &name);
    }
}

/// A hole in a polygon of two contours shows what is behind, by every way and renderer.
#[test]
fn polygons_of_several_contours_are_drawn_by_every_way_and_renderer() {
    let rng = &mut Rng::new(1);
    let square = |size: f32, z: f32| {
        [(-size, -size), (size, -size), (size, size), (-size, size)]
            .map(|(x, y)| Vec4::from((Vec2::new(x, y), z + 0.05 * x, 1.0)))
    };
    let mut with_params = |corners: [Vec4; 4]| {
        corners.map(|p| Vertex::new(p, [0; 2].map(|_| rng.range(-1.0, 1.0) as f32)))
    };
    let wall = with_params(square(0.9, 0.7));
    let (outer, mut hole) = (with_params(square(0.8, 0.3)), with_params(square(0.31, 0.3)));
    hole.reverse();
    let frame_with_hole = [outer, hole];
    let mut expected = empty();
    let mut z_buffer = ZBufferRenderer::new(expected.viewport());
    z_buffer.draw(&mut expected, &wall, dynamic(told));
    z_buffer.draw(&mut expected, &frame_with_hole, dynamic(told));
    fn check<R: Draws>(expected: &Frame, wall: &[Vertex<2>; 4], with_hole: &[[Vertex<2>; 4]; 2]) {
        let mut renderer = R::new(Settings::new(expected.viewport()));
        for way in WAYS {
            let mut frame = empty();
            renderer.draw_by(&mut frame, wall, way);
            renderer.draw_by(&mut frame, with_hole, way);
            assert_eq!(bits(frame.depth()), bits(expected.depth()), "{} {way:?}", R::NAME);
            if way.0 != Way::Depth {
                assert!(frame.color() == expected.color(), "{} {way:?}", R::NAME);
            }
        }
    }
    let middle = expected.pixel(WIDTH / 2, HEIGHT / 2).map(|(_, depth)| depth);
    assert!(middle.is_some_and(|depth| (0.65..0.75).contains(&depth)), "the wall is seen");
    check::<ZBufferRenderer<2>>(&expected, &wall, &frame_with_hole);
    check::<ScanlineRenderer<2>>(&expected, &wall, &frame_with_hole);
    check::<PainterRenderer<2>>(&expected, &wall, &frame_with_hole);
}

/// A shader on one thread is called for each pixel that is shaded, and no other.
#[test]
fn a_shader_that_counts_sees_each_pixel_once() {
    let rng = &mut Rng::new(9);
    let scene = Scene::new(rng, 8, any_outline);
    let vertices = scene.in_clip_space();
    let expected = by_z_buffer(&scene);
    let covered = expected.color().iter().filter(|color| color.0 > 0).count();
    let mut fragments = 0;
    let mut frame = empty();
    let mut scanline = ScanlineRenderer::new(frame.viewport());
    scanline.on_one_thread().draw(
        &mut frame,
        Mesh::new(&vertices, &scene.faces),
        dynamic_mut(|f| {
            fragments += 1;
            told(f)
        }),
    );
    assert_eq!(fragments, covered);
    let mut lanes = 0;
    let mut frame = empty();
    scanline.on_one_thread().draw_blocks(
        &mut frame,
        Mesh::new(&vertices, &scene.faces),
        dynamic_blocks_mut(|b, c| {
            lanes += b.visible.count_ones() as usize;
            told_by_block(b, c);
        }),
    );
    assert_eq!(lanes, covered);
    assert!(frame == expected);
}

// ----------------------------------------------------------------------------------------- targets

fn check_target<R: Draws>(scene: &Scene) {
    let vertices = scene.in_clip_space();
    for way in WAYS {
        let mut frame = empty();
        let mut renderer = R::new(Settings::new(frame.viewport()));
        renderer.draw_by(&mut frame, Mesh::new(&vertices, &scene.faces), way);

        let pixels = (WIDTH * HEIGHT) as usize;
        let (mut colors, mut depths) = (vec![NOTHING; pixels], vec![1.0; pixels]);
        let mut target = Target::new(WIDTH, &mut colors, &mut depths).expect("whole rows");
        assert_eq!((target.width(), target.height()), (WIDTH, HEIGHT));
        assert_eq!(target.viewport(), frame.viewport());
        renderer.draw_by(&mut target, Mesh::new(&vertices, &scene.faces), way);
        assert!(colors == frame.color(), "{} {way:?}", R::NAME);
        assert_eq!(bits(&depths), bits(frame.depth()), "{} {way:?}", R::NAME);
    }
}

#[test]
fn borrowed_memory_gets_the_bits_of_a_framebuffer() {
    let scene = Scene::new(&mut Rng::new(4), 20, any_outline);
    check_target::<ZBufferRenderer<2>>(&scene);
    check_target::<ScanlineRenderer<2>>(&scene);
    check_target::<PainterRenderer<2>>(&scene);
}

#[test]
fn a_renderer_clears_memory_that_is_borrowed_or_owned() {
    let mut frame = empty();
    for mode in [DepthMode::Standard, DepthMode::Reversed, DepthMode::InverseW] {
        let color = (7, [1, 2, 3, 4]);
        let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
        renderer.settings.depth = mode;
        frame.clear(NOTHING, 0.5);
        renderer.clear(&mut frame, color);
        let farthest = if mode == DepthMode::Standard { 1.0 } else { 0.0 };
        assert_eq!(mode.farthest(), farthest);
        assert!(frame.color().iter().all(|&c| c == color));
        assert!(frame.depth().iter().all(|&d| d == farthest));
        let (mut colors, mut depths) = ([NOTHING; 6], [0.5; 6]);
        renderer.clear(&mut Target::new(3, &mut colors, &mut depths).expect("two rows"), color);
        assert_eq!((colors, depths), ([color; 6], [farthest; 6]));
    }
}

#[test]
fn a_framebuffer_is_made_of_parts_and_taken_apart() {
    let scene = Scene::new(&mut Rng::new(8), 12, any_outline);
    let frame = by_z_buffer(&scene);
    let (colors, depths) = frame.clone().into_parts();
    assert_eq!((colors.len(), depths.len()), ((WIDTH * HEIGHT) as usize, colors.len()));
    let again = Framebuffer::from_parts(WIDTH, colors, depths).expect("the same parts");
    assert!(again == frame);
    assert_eq!((again.width(), again.height()), (WIDTH, HEIGHT));
    // Colours need not be `Copy` for that.
    let names = vec!["a".to_string(), "b".to_string()];
    let frame = Framebuffer::from_parts(1, names.clone(), vec![0.25, 0.5]).expect("two rows");
    assert_eq!(frame.into_parts(), (names, vec![0.25, 0.5]));
    // No pixels are no rows, of any width.
    for width in [0, 5] {
        let frame = Framebuffer::from_parts(width, Vec::<u8>::new(), Vec::new()).expect("empty");
        assert_eq!((frame.width(), frame.height()), (width, 0));
    }
}

#[test]
fn memory_that_cannot_be_drawn_to_is_an_error_that_says_why() {
    let text = |width: u32, colors: usize, depths: usize| {
        let (mut color, mut depth) = (vec![0u8; colors], vec![0.0; depths]);
        let error = Target::new(width, &mut color, &mut depth).expect_err("it does not fit");
        let of_parts = Framebuffer::from_parts(width, color, depth).expect_err("nor so");
        assert_eq!(error, of_parts);
        (error, error.to_string())
    };
    let (error, why) = text(3, 6, 5);
    assert_eq!(error, TargetError::Lengths { colors: 6, depths: 5 });
    assert_eq!(why, "there are 6 colours and 5 depths: each pixel needs one of both");
    for width in [4, 7, 0] {
        let (error, why) = text(width, 6, 6);
        assert_eq!(error, TargetError::NotWholeRows { width, pixels: 6 });
        assert_eq!(why, format!("6 pixels do not fill rows of {width}: give whole rows"));
    }
    let limit = "width and height may be at most 65536; draw in tiles with `Viewport::with_corner`";
    for (width, height) in [(65_537, 0), (65_537, 1), (1, 65_537)] {
        let (error, why) = text(width, (width * height) as usize, (width * height) as usize);
        assert!(matches!(error, TargetError::Size(_)), "{error:?}");
        let size = format!("a size of {width} x {height} pixels is not possible");
        assert_eq!(why, format!("{size}: {limit}"));
    }
}

// ------------------------------------------------------------------------------------ modes of depth

const SIDE: u32 = 64;

/// Right triangles with legs that are powers of two along the pixels, and depths that are multiples of
/// 2^-13 on each pixel: all of their depths are exact, and so is 1 - z. `slab` gives the range of depth
/// of the i-th of them: its lower end, and its size.
fn exact_scene(
    rng: &mut Rng,
    count: usize,
    slab: impl Fn(&mut Rng, usize) -> [f64; 2],
) -> (Vec<Vertex<2>>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    let mut order: Vec<usize> = (0..count).collect();
    rng.shuffle(&mut order);
    for i in order {
        let [low, size] = slab(rng, i);
        let corner = [0; 2].map(|_| rng.whole(-16, i64::from(SIDE) - 8) as f64);
        let legs = [0; 2].map(|_| f64::from(1 << (3 + rng.below(4))) * [-1.0, 1.0][rng.below(2)]);
        // A change of at most size / 4 along each leg, around the middle.
        let rise = [0; 2].map(|_| size * rng.whole(-4, 4) as f64 / 16.0);
        let middle = low + size / 2.0;
        let places = [
            (corner, middle),
            ([corner[0] + legs[0], corner[1]], middle + rise[0]),
            ([corner[0], corner[1] + legs[1]], middle + rise[1]),
        ];
        for ([x, y], z) in places {
            let half = f64::from(SIDE) / 2.0;
            let position = [x / half - 1.0, 1.0 - y / half, z, 1.0].map(|c| c as f32);
            vertices.push(Vertex::new(position.into(), [i as f32, 0.5]));
        }
    }
    let faces = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (vertices, faces)
}

/// The face that is seen, and the bits of w and the parameters; the depth is in the framebuffer.
fn without_depth(f: &Fragment<'_, 2>) -> Told {
    (f.face + 1, [0, f.w.to_bits(), f.params[0].to_bits(), f.params[1].to_bits()])
}

fn drawn<R: Draws>(mode: DepthMode, draw: impl FnOnce(&mut R, &mut Frame)) -> Frame {
    let mut frame = Framebuffer::new(SIDE, SIDE, NOTHING).expect("a small frame");
    let mut settings = Settings::new(frame.viewport());
    settings.depth = mode;
    let mut renderer = R::new(settings);
    renderer.clear(&mut frame);
    draw(&mut renderer, &mut frame);
    let untold = |color: &mut Told| color.1[0] = 0;
    frame.color_mut().iter_mut().for_each(untold);
    frame
}

/// Whether two pictures are the same but for depth, which is mirrored.
fn assert_mirrored(reversed: &Frame, standard: &Frame, name: &str) {
    assert!(reversed.color() == standard.color(), "{name}: colours");
    let mirrored: Vec<f32> = standard.depth().iter().map(|depth| 1.0 - depth).collect();
    assert_eq!(reversed.depth(), mirrored, "{name}: depths");
}

/// z becomes w - z.
fn reversal() -> Mat4 {
    Mat4::from_cols(Vec4::X, Vec4::Y, -Vec4::Z, vec4(0.0, 0.0, 1.0, 1.0))
}

fn check_reversed<R: Draws>(vertices: &[Vertex<2>], faces: &[[u32; 3]], name: &str) -> Frame {
    let mirrored: Vec<_> =
        vertices.iter().map(|v| Vertex { position: reversal() * v.position, ..*v }).collect();
    let [standard, reversed] =
        [(DepthMode::Standard, vertices), (DepthMode::Reversed, &mirrored[..])].map(
            |(mode, vertices)| {
                drawn(mode, |renderer: &mut R, frame| {
                    renderer.draw_by(frame, Mesh::new(vertices, faces), (Way::Draw, false));
                })
            },
        );
    assert_mirrored(&reversed, &standard, &format!("{name}: mesh by {}", R::NAME));
    let tree = BspTree::new(vertices, faces);
    let [by_tree, reversed_by_tree] =
        [(DepthMode::Standard, Mat4::IDENTITY), (DepthMode::Reversed, reversal())].map(
            |(mode, matrix)| {
                drawn(mode, |renderer: &mut R, frame| {
                    renderer.draw_by(frame, tree.seen_by(matrix), (Way::Blocks, false));
                })
            },
        );
    assert_mirrored(&reversed_by_tree, &by_tree, &format!("{name}: tree by {}", R::NAME));
    assert!(by_tree == standard, "{name}: tree and mesh by {}", R::NAME);
    let [sorted, reversed_sorted] =
        [(DepthMode::Standard, vertices), (DepthMode::Reversed, &mirrored[..])].map(
            |(mode, vertices)| {
                drawn(mode, |renderer: &mut R, frame| {
                    let mesh = Mesh::new(vertices, faces).back_to_front();
                    renderer.draw_by(frame, mesh, (Way::Draw, true));
                })
            },
        );
    assert_mirrored(&reversed_sorted, &sorted, &format!("{name}: sorted by {}", R::NAME));
    standard
}

#[test]
fn reversed_depth_gives_the_same_colours_and_mirrored_depths() {
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        // One in each of 32 layers.
        let layer = |_: &mut Rng, i: usize| [i as f64 / 32.0, 1.0 / 32.0];
        let (vertices, faces) = exact_scene(rng, 32, layer);
        let name = format!("seed {seed}, layers");
        let by_z = check_reversed::<ZBufferRenderer<2>>(&vertices, &faces, &name);
        let by_row = check_reversed::<ScanlineRenderer<2>>(&vertices, &faces, &name);
        let painted = check_reversed::<PainterRenderer<2>>(&vertices, &faces, &name);
        assert!(by_row == by_z && painted == by_z, "{name}");
        assert!(seen(&by_z) > 10);
    }
}

#[test]
fn reversed_depth_gives_the_same_faces_where_they_cross_and_tie() {
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        // Through each other, often at the same depth.
        let any = |rng: &mut Rng, _: usize| [rng.below(4) as f64 / 16.0, 0.25];
        let (vertices, faces) = exact_scene(rng, 40, any);
        let name = format!("seed {seed}, crossing");
        let mirrored: Vec<_> =
            vertices.iter().map(|v| Vertex { position: reversal() * v.position, ..*v }).collect();
        fn pair<R: Draws>(vertices: [&[Vertex<2>]; 2], faces: &[[u32; 3]], name: &str) -> Frame {
            let modes = [DepthMode::Standard, DepthMode::Reversed];
            let [standard, reversed] = [0, 1].map(|i| {
                drawn(modes[i], |renderer: &mut R, frame| {
                    renderer.draw_by(frame, Mesh::new(vertices[i], faces), (Way::Draw, false));
                })
            });
            assert_mirrored(&reversed, &standard, &format!("{name} by {}", R::NAME));
            standard
        }
        let both = [&vertices[..], &mirrored[..]];
        let by_z = pair::<ZBufferRenderer<2>>(both, &faces, &name);
        let by_row = pair::<ScanlineRenderer<2>>(both, &faces, &name);
        assert!(by_row == by_z, "{name}");
    }
}

#[test]
fn one_over_w_shows_the_same_faces() {
    for seed in 0..12 {
        let rng = &mut Rng::new(100 + seed);
        let scene = Scene::new(rng, 25, any_outline);
        let vertices = scene.in_clip_space();
        let expected = by_z_buffer(&scene);
        let mut frame = empty();
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.settings.depth = DepthMode::InverseW;
        for is_block in [false, true] {
            renderer.clear(&mut frame, NOTHING);
            let mesh = Mesh::new(&vertices, &scene.faces);
            if is_block {
                renderer.draw_blocks(
                    &mut frame,
                    mesh,
                    dynamic_blocks(|block, colors| {
                        for (lane, color) in colors.iter_mut().enumerate() {
                            *color = without_depth(&block.fragment(lane));
                        }
                    }),
                );
            } else {
                renderer.draw(&mut frame, mesh, dynamic(without_depth));
            }
            for (pixel, (color, expected)) in frame.color().iter().zip(expected.color()).enumerate()
            {
                let [_, w, u, v] = expected.1;
                assert_eq!(*color, (expected.0, [0, w, u, v]), "seed {seed}, pixel {pixel}");
                let depth = f64::from(frame.depth()[pixel]);
                let w = f64::from(f32::from_bits(w));
                let exact = if expected.0 == 0 { 0.0 } else { 1.0 / w };
                assert!((depth - exact).abs() <= 3e-7 * exact, "1/w is the depth: {depth} {exact}");
            }
        }
    }
}

/// The scanline renderer documents that 1/w counts as z there.
#[test]
fn one_over_w_counts_as_z_by_rows() {
    let scene = Scene::new(&mut Rng::new(31), 25, any_outline);
    let vertices = scene.in_clip_space();
    let expected = by_z_buffer(&scene);
    let mut renderer = ScanlineRenderer::new(expected.viewport());
    renderer.settings.depth = DepthMode::InverseW;
    let mut rows = Vec::new();
    let sink = |_, row: &[Told]| {
        rows.extend_from_slice(row);
        Ok::<(), ()>(())
    };
    let drawn = renderer.stream(Mesh::new(&vertices, &scene.faces), NOTHING, dynamic(told), sink);
    drawn.expect("no error");
    assert!(rows == expected.color(), "streamed");
    let mut frame = empty();
    renderer.clear(&mut frame, NOTHING);
    renderer.draw(&mut frame, Mesh::new(&vertices, &scene.faces), dynamic(told));
    assert!(frame == expected, "on a framebuffer");
}
