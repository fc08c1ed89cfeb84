//! Contract 6, pinned: scenes with a hash of all their colour and depth bits.
//!
//! The expected hashes were copied from the output of the library itself, so they are no evidence
//! that a picture is right; that is what the tests against the oracles are for. They pin that the
//! picture is the *same*, to the bit: on every machine, in debug and release, at every SIMD level,
//! whole or in tiles, and from version to version. When a change is meant to change bits, the
//! failing test prints the new hash.
//!
//! For that the scenes have to be the same bits everywhere. They are made of whole numbers, divided
//! or scaled by powers of two; nothing here calls a sine, a logarithm or anything else whose last
//! bit a platform may choose.
//!
//! This is a crate of its own, small enough to be compiled for other processors and run under an
//! emulator.

mod in_python;

#[path = "../it/common/generators/rng.rs"]
#[allow(dead_code, reason = "other tests need more of it")]
mod rng;

use fearless_simd::Level;
use glam::{Vec4, vec2, vec4};
use polyscan::texture::{Filter, Wrap};
use polyscan::{
    ClipPlane, ClipSpace, Cull, DepthMode, DepthTest, Fragment, Framebuffer,
    Interpolation::{Flat, Linear, Perspective},
    Mesh, Texture, Vertex, Viewport, ZBufferRenderer,
};
use rng::Rng;

const WIDTH: u32 = 203;
const HEIGHT: u32 = 151;

type Polygon = Vec<Vertex<3>>;
type Color = [f32; 3];
type Frame = Framebuffer<Color>;
type Shader = fn(&Fragment<'_, 3>) -> Color;

/// A scene: polygons, the settings that they are drawn with, and what its bits hash to.
struct Scene {
    name: &'static str,
    polygons: fn(&mut Rng) -> Vec<Polygon>,
    settings: fn(&mut ZBufferRenderer<3>),
    shader: Shader,
    hash: u64,
}

// ---------------------------------------------------------------------------------------- numbers

/// A multiple of 1/1024 in `low..=high`.
fn number(rng: &mut Rng, low: i64, high: i64) -> f32 {
    rng.whole(low * 1024, high * 1024) as f32 / 1024.0
}

/// A vertex at (x, y) in normalized device coordinates, at a depth of 0..1, with random parameters.
fn vertex(rng: &mut Rng, [x, y]: [f32; 2], w: f32) -> Vertex<3> {
    let z = number(rng, 0, 1);
    Vertex::new(vec4(x * w, y * w, z * w, w), [0; 3].map(|_| number(rng, -1, 1)))
}

/// Places on a square's outline in their order, clockwise: convex, for polygons of many sides.
fn around(rng: &mut Rng, sides: usize) -> Vec<[f32; 2]> {
    let mut turns: Vec<i64> = (0..sides).map(|_| rng.whole(0, 4095)).collect();
    turns.sort_unstable();
    let [x, y, size] = [number(rng, -1, 1), number(rng, -1, 1), number(rng, 0, 1)];
    let place = |turn: i64| {
        let (side, t) = (turn / 1024, (turn % 1024) as f32 / 512.0 - 1.0);
        let [u, v] = [[t, 1.0], [1.0, -t], [-t, -1.0], [-1.0, t]][side as usize];
        // Bent outwards: a corner cut by u v.
        let bend = 1.25 - 0.25 * (u * u + v * v);
        [x + size * u * bend, y + size * v * bend]
    };
    turns.into_iter().map(place).collect()
}

// ----------------------------------------------------------------------------------------- scenes

/// Rectangles in space, with parameters affine on them: origin + s along + t across.
fn perspective_quads(rng: &mut Rng) -> Vec<Polygon> {
    let quad = |rng: &mut Rng| {
        let mut vector = |size: i64| Vec4::from_array([0; 4].map(|_| number(rng, -size, size)));
        let (origin, along, across) = (vector(1), vector(1), vector(1));
        let origin = origin + vec4(0.0, 0.0, 1.5, 3.0);
        let corner = |(s, t): (f32, f32)| {
            Vertex::new(origin + along * s + across * t, [s, t, 0.5 * s - 0.25 * t])
        };
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(corner).to_vec()
    };
    (0..60).map(|_| quad(rng)).collect()
}

/// Polygons of up to 64 sides, all w equal, and so all planes but those of the parameters.
fn many_sides(rng: &mut Rng) -> Vec<Polygon> {
    let polygon = |rng: &mut Rng| {
        let (sides, w) = (3 + rng.below(62), 1.0 + number(rng, 0, 3));
        let places = around(rng, sides);
        places.into_iter().map(|place| vertex(rng, place, w)).collect()
    };
    (0..40).map(|_| polygon(rng)).collect()
}

/// The same places, a w and a colour of its own at each vertex: no planes at all.
fn not_affine(rng: &mut Rng) -> Vec<Polygon> {
    let polygon = |rng: &mut Rng| {
        let sides = 4 + rng.below(9);
        let places = around(rng, sides);
        places
            .into_iter()
            .map(|place| {
                let w = 1.0 + number(rng, 0, 8);
                vertex(rng, place, w)
            })
            .collect()
    };
    (0..60).map(|_| polygon(rng)).collect()
}

/// Corners anywhere, in any order: concave and crossed outlines.
fn tangles(rng: &mut Rng) -> Vec<Polygon> {
    let polygon = |rng: &mut Rng| {
        let corners = 4 + rng.below(8);
        let corner = |rng: &mut Rng| {
            let (place, w) = ([0; 2].map(|_| number(rng, -1, 1)), 1.0 + number(rng, 0, 2));
            vertex(rng, place, w)
        };
        (0..corners).map(|_| corner(rng)).collect()
    };
    (0..30).map(|_| polygon(rng)).collect()
}

/// Triangles with w ratios up to 1024.
fn steep(rng: &mut Rng) -> Vec<Polygon> {
    let corner = |rng: &mut Rng| {
        let (place, octave) = ([0; 2].map(|_| number(rng, -2, 2)), rng.below(11));
        let w = (1u32 << octave) as f32 * (1.0 + number(rng, 0, 1));
        vertex(rng, place, w)
    };
    (0..120).map(|_| (0..3).map(|_| corner(rng)).collect()).collect()
}

/// Any positions: all planes cut, many polygons pass the eye.
fn clipped(rng: &mut Rng) -> Vec<Polygon> {
    let corner = |rng: &mut Rng| {
        let position = Vec4::from_array([0; 4].map(|_| number(rng, -4, 4)));
        Vertex::new(position, [0; 3].map(|_| number(rng, -1, 1)))
    };
    let polygon = |rng: &mut Rng| {
        let corners = 3 + rng.below(4);
        (0..corners).map(|_| corner(rng)).collect()
    };
    (0..80).map(|_| polygon(rng)).collect()
}

/// A landscape of triangles and quads that share their vertices.
fn mesh(rng: &mut Rng) -> Vec<Polygon> {
    const SIDE: usize = 24;
    let mut vertices = Vec::new();
    for (row, column) in (0..=SIDE).flat_map(|row| (0..=SIDE).map(move |column| (row, column))) {
        let [x, y] = [column, row].map(|i| (i as f32 - SIDE as f32 / 2.0) / 8.0);
        let height = number(rng, 0, 1) / 4.0;
        let w = y + 2.25;
        let position = vec4(x, height - 1.0 + y / 4.0, w - 0.25, w);
        vertices.push(Vertex::new(position, [x / 2.0, y / 2.0, height]));
    }
    let mut polygons = Vec::new();
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let a = row * (SIDE + 1) + column;
        let face = [a, a + 1, a + SIDE + 2, a + SIDE + 1].map(|i| vertices[i]);
        if rng.once_in(2) {
            polygons.push(face.to_vec());
        } else {
            polygons.push(vec![face[0], face[1], face[2]]);
            polygons.push(vec![face[0], face[2], face[3]]);
        }
    }
    polygons
}

/// One polygon that reaches far out of the window and beyond the guard band, over another.
fn huge(rng: &mut Rng) -> Vec<Polygon> {
    let triangle = |rng: &mut Rng, size: f32| -> Polygon {
        [[-1.0, -1.5], [1.5, 0.25], [-0.25, 1.25]]
            .map(|p: [f32; 2]| vertex(rng, p.map(|c| c * size), 1.0))
            .to_vec()
    };
    [3.0, 100.0, 65536.0, 1e20].map(|size| triangle(rng, size)).to_vec()
}

// ---------------------------------------------------------------------------------------- shaders

fn params(fragment: &Fragment<'_, 3>) -> Color {
    fragment.params
}

/// w and the derivatives as well.
fn everything(fragment: &Fragment<'_, 3>) -> Color {
    let (dx, dy) = fragment.derivatives();
    let [r, g, b] = fragment.params;
    [r + fragment.w, g + dx[0], b + dy[1]]
}

/// A colour of a texture of 13 x 7 texels, at three times the parameters.
fn sampled(fragment: &Fragment<'_, 3>, filter: Filter, wrap: Wrap) -> Color {
    thread_local! {
        static TEXTURE: Texture = Texture::from_fn(13, 7, |x, y| {
            vec4(x as f32 / 16.0, y as f32 / 8.0, (x * y % 5) as f32 / 4.0, 1.0)
        })
        .expect("a small texture");
    }
    let [u, v, _] = fragment.params;
    let texture = TEXTURE.with(Clone::clone).with_filter(filter).with_wrap(wrap);
    texture.sample(vec2(u, v) * 3.0).truncate().to_array()
}

fn nearest(fragment: &Fragment<'_, 3>) -> Color {
    sampled(fragment, Filter::Nearest, Wrap::Repeat)
}

fn bilinear(fragment: &Fragment<'_, 3>) -> Color {
    sampled(fragment, Filter::Bilinear, Wrap::Mirror)
}

// ---------------------------------------------------------------------------------------- drawing

/// The viewport of the scenes: smaller than the picture, off its corner.
fn viewport() -> Viewport {
    Viewport::new(WIDTH - 19, HEIGHT - 23).expect("small").with_corner(11, 9)
}

/// How polygons reach the framebuffer.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Each by itself.
    Polygons,
    /// As the faces of one mesh.
    Mesh,
    /// As the faces of one mesh, whose shader takes blocks.
    MeshBlocks,
}

/// Draws the part of a scene from (left, top) on.
fn draw(scene: &Scene, part: (u32, u32), size: (u32, u32)) -> Frame {
    draw_in(Way::Polygons, Level::new(), scene, part, size)
}

fn draw_in(
    way: Way,
    level: Level,
    scene: &Scene,
    (left, top): (u32, u32),
    (width, height): (u32, u32),
) -> Frame {
    let mut frame = Framebuffer::new(width, height, [0.0; 3]).expect("a small frame");
    let rect = viewport().rect();
    let tile = viewport().with_corner(rect.x - left as i32, rect.y - top as i32);
    let mut renderer = ZBufferRenderer::new(tile);
    (scene.settings)(&mut renderer);
    renderer.clear(&mut frame, [0.0; 3]);
    if renderer.depth_test == DepthTest::FartherOrEqual {
        frame.clear([0.0; 3], 0.0);
    }
    renderer.simd_level = level;
    let polygons = (scene.polygons)(&mut Rng::new(2024));
    let mut indices = 0..;
    let faces: Vec<Vec<u32>> =
        polygons.iter().map(|polygon| indices.by_ref().take(polygon.len()).collect()).collect();
    let vertices = polygons.concat();
    match way {
        Way::Polygons => {
            polygons.iter().for_each(|polygon| renderer.draw(&mut frame, polygon, scene.shader));
        }
        Way::Mesh => renderer.draw(&mut frame, Mesh::new(&vertices, &faces), scene.shader),
        Way::MeshBlocks => {
            renderer.draw_blocks(&mut frame, Mesh::new(&vertices, &faces), |block, colors| {
                for lane in (0..colors.len()).filter(|lane| block.visible >> lane & 1 != 0) {
                    colors[lane] = (scene.shader)(&block.fragment(lane));
                }
            });
        }
    }
    frame
}

/// The SIMD levels that this machine has, and with the feature `fallback` none.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(feature = "fallback")]
    levels.push(Level::fallback());
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse2().map(fearless_simd::Simd::level));
        levels.extend(best.as_sse4_2().map(fearless_simd::Simd::level));
        levels.extend(best.as_avx2().map(fearless_simd::Simd::level));
    }
    levels.extend([best, Level::baseline()]);
    levels
}

/// A scene drawn tile by tile.
fn assembled(scene: &Scene, (width, height): (u32, u32)) -> Frame {
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, [0.0; 3]).expect("a small frame");
    for top in (0..HEIGHT).step_by(height as usize) {
        for left in (0..WIDTH).step_by(width as usize) {
            let tile = draw(scene, (left, top), (width, height));
            for y in 0..height.min(HEIGHT - top) {
                for x in 0..width.min(WIDTH - left) {
                    let (color, depth) = tile.pixel(x, y).expect("inside the tile");
                    let at = ((top + y) * WIDTH + left + x) as usize;
                    frame.color_mut()[at] = color;
                    frame.depth_mut()[at] = depth;
                }
            }
        }
    }
    frame
}

/// The bits of colours and depths, row by row.
fn bits(frame: &Frame) -> impl Iterator<Item = u32> {
    let pixels = frame.color().iter().zip(frame.depth());
    pixels.flat_map(|(&[r, g, b], &depth)| [r, g, b, depth]).map(f32::to_bits)
}

/// FNV-1a in 64 bits over the bits, low byte first.
fn hash(frame: &Frame) -> u64 {
    let bytes = bits(frame).flat_map(u32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

const SCENES: &[Scene] = &[
    Scene {
        name: "quads in perspective",
        polygons: perspective_quads,
        settings: |_| {},
        shader: everything,
        hash: 0x02ac_e293_4e74_17d7,
    },
    Scene {
        name: "up to 64 sides, equal w",
        polygons: many_sides,
        settings: |_| {},
        shader: everything,
        hash: 0x07c9_59c8_ad29_eb0d,
    },
    Scene {
        name: "values without a plane",
        polygons: not_affine,
        settings: |_| {},
        shader: everything,
        hash: 0x8cf6_ff85_8819_ca52,
    },
    Scene {
        name: "linear and flat parameters, clipped",
        polygons: clipped,
        settings: |renderer| renderer.settings.interpolation = [Perspective, Linear, Flat],
        shader: everything,
        hash: 0x10a4_381a_5042_aa35,
    },
    Scene {
        name: "concave and crossed outlines",
        polygons: tangles,
        settings: |renderer| renderer.depth_test = DepthTest::FartherOrEqual,
        shader: params,
        hash: 0xcd4f_6147_2897_aa9e,
    },
    Scene {
        name: "w ratios of 1000",
        polygons: steep,
        settings: |_| {},
        shader: params,
        hash: 0x5ef6_eb64_083a_6516,
    },
    Scene {
        name: "the clip space of OpenGL, a depth range, counter-clockwise polygons left out",
        polygons: clipped,
        settings: |renderer| {
            renderer.settings.clip_space = ClipSpace::MinusOneToOne;
            renderer.settings.viewport = renderer.settings.viewport.with_depth(0.75, 0.125);
            renderer.settings.cull = Cull::Front;
        },
        shader: params,
        hash: 0xe50d_5c28_ca0c_5d2a,
    },
    Scene {
        name: "planes of the user's",
        polygons: clipped,
        settings: |renderer| {
            let planes = [vec4(1.0, 0.5, 0.25, 0.5), vec4(-0.25, -1.0, 0.5, 0.75)];
            renderer.settings.planes = planes.map(ClipPlane::new).to_vec();
        },
        shader: everything,
        hash: 0x8fe4_9879_d1f7_72a2,
    },
    Scene {
        name: "a mesh",
        polygons: mesh,
        settings: |_| {},
        shader: everything,
        hash: 0xde98_c58d_fe4b_c5de,
    },
    Scene {
        name: "a mesh, 1/w as depth",
        polygons: mesh,
        settings: |renderer| {
            renderer.settings.depth = DepthMode::InverseW;
        },
        shader: params,
        hash: 0xc3ab_38ef_f996_2b5e,
    },
    Scene {
        name: "a texture, nearest texels",
        polygons: mesh,
        settings: |_| {},
        shader: nearest,
        hash: 0xa06a_c808_86a5_87d4,
    },
    Scene {
        name: "a texture, bilinear",
        polygons: perspective_quads,
        settings: |_| {},
        shader: bilinear,
        hash: 0x2ac4_f023_7060_a8ad,
    },
    Scene {
        name: "far beyond the window",
        polygons: huge,
        settings: |renderer| renderer.depth_test = DepthTest::NearerOrEqual,
        shader: everything,
        hash: 0x9bee_cfaf_6c1e_f61c,
    },
];

#[test]
fn every_scene_has_its_hash() {
    let mut changed = Vec::new();
    for scene in SCENES {
        let frame = draw(scene, (0, 0), (WIDTH, HEIGHT));
        let drawn = frame.color().iter().filter(|color| **color != [0.0; 3]).count();
        assert!(drawn > 1000, "{}: only {drawn} pixels are drawn", scene.name);
        // The bits of a NaN depend on the machine.
        assert!(frame.color().iter().flatten().all(|c| !c.is_nan()), "{}", scene.name);
        if hash(&frame) != scene.hash {
            changed.push(format!("{}: {:#018x}", scene.name, hash(&frame)));
        }
    }
    assert!(changed.is_empty(), "these have another hash now:\n{}", changed.join("\n"));
}

#[test]
fn every_simd_level_and_every_way_of_drawing_gives_the_same_bits() {
    for scene in SCENES {
        let all = |way, level| draw_in(way, level, scene, (0, 0), (WIDTH, HEIGHT));
        let first = all(Way::Polygons, Level::new());
        assert_eq!(hash(&first), scene.hash, "{}", scene.name);
        for level in levels() {
            for way in [Way::Polygons, Way::Mesh, Way::MeshBlocks] {
                let same = bits(&all(way, level)).eq(bits(&first));
                assert!(same, "{}: {way:?}, {level:?}", scene.name);
            }
        }
    }
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a few threads").install(|| {
            for scene in SCENES {
                let frame = draw_in(Way::Mesh, Level::new(), scene, (0, 0), (WIDTH, HEIGHT));
                assert_eq!(hash(&frame), scene.hash, "{}: {threads} threads", scene.name);
            }
        });
    }
}

#[test]
fn a_picture_of_tiles_has_the_hash_of_the_whole() {
    for scene in SCENES {
        for size in [(37, 41), (203, 13), (17, 151), (1, 151)] {
            let tiles = assembled(scene, size);
            assert_eq!(hash(&tiles), scene.hash, "{} in tiles of {size:?}", scene.name);
        }
    }
}
