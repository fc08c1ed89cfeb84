//! Several buffers in one pass: to the bit what separate passes draw, one for each buffer.

use std::sync::Mutex;

use crate::common::generators::{self, Rng};
use crate::common::{dynamic, vertices};
use glam::{Vec3, Vec4, vec3, vec4};
use polyscan::fragment::LANES;
use polyscan::render::{Buffers, Over, Paint};
use polyscan::{
    Fragment, FragmentBlock, Framebuffer, Level, Mesh, PainterRenderer, ScanlineRenderer, Target,
    TargetError, Texture, Vertex, Viewport, ZBufferRenderer,
};

const SIZE: (u32, u32) = (150, 110);

/// Four buffers of different sizes and types: linear light, texture coordinates, ids, and whether the front
/// is seen.
type Pixel = (Vec4, [f32; 2], u32, bool);

const NOTHING: Pixel = (Vec4::W, [-9.0; 2], u32::MAX, false);

/// One buffer's value in a pass of its own: it is written or not, and the fragment is drawn in any case.
struct Written<P>(Option<P>);

/// A pixel of a separate pass. Its type is none of those that the library has rules for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Alone<C>(C);

impl<C, P: Paint<C>> Paint<Alone<C>> for Written<P> {
    fn paint(self, pixel: &mut Alone<C>) -> bool {
        if let Some(value) = self.0 {
            value.paint(&mut pixel.0);
        }
        true
    }
}

impl<C, P: Paint<C>> Paint<Alone<C>> for Option<Written<P>> {
    fn paint(self, pixel: &mut Alone<C>) -> bool {
        self.is_some_and(|written| written.paint(pixel))
    }
}

// ---------------------------------------------------------------------------------------- shaders

/// Whether a fragment is discarded, and which buffers are written.
fn choice(f: &Fragment<'_, 3>) -> (bool, [bool; 4]) {
    let hash = (f.x as u32).wrapping_mul(0x9E37_79B9) ^ (f.y as u32).wrapping_mul(0x85EB_CA6B);
    let hash = (hash ^ f.face).wrapping_mul(0xC2B2_AE35) >> 20;
    (hash.is_multiple_of(11), [0, 1, 2, 3].map(|i| hash >> i & 3 != 0))
}

fn glass(f: &Fragment<'_, 3>) -> Over {
    let [u, v, w] = f.params;
    Over(vec4(u, v, w, 1.0) * (0.25 + 0.5 * (u - u.floor())))
}

/// A pane, or a hole in it.
struct Glass(Option<Over>);

impl Paint<Vec4> for Glass {
    fn paint(self, pixel: &mut Vec4) -> bool {
        self.0.is_some_and(|over| over.paint(pixel))
    }
}

type Painted = (Glass, Option<[f32; 2]>, Option<u32>, Option<bool>);
type Block = ([Vec4; LANES], [[f32; 2]; LANES], [u32; LANES], [bool; LANES]);

/// Shaders of one type each for all renderers, so that the loops around them are compiled once.
type Shader<'s> = dyn Fn(&Fragment<'_, 3>) -> Option<Painted> + Sync + 's;
type BlockShader<'s> = dyn Fn(&mut FragmentBlock<'_, 3>, &mut Block) + Sync + 's;

/// What is painted on each buffer.
fn shade(f: &Fragment<'_, 3>) -> Option<Painted> {
    let (is_discarded, [color, uv, id, front]) = choice(f);
    let [u, v, _] = f.params;
    (!is_discarded).then(|| {
        (
            Glass(color.then(|| glass(f))),
            uv.then_some([u, v]),
            id.then_some(f.face),
            front.then_some(f.front_facing),
        )
    })
}

/// A fragment of a tile as it is in the whole.
fn moved<'a>(f: &Fragment<'a, 3>, (x, y): (i32, i32)) -> Fragment<'a, 3> {
    let mut f = *f;
    (f.x, f.y) = (f.x + x, f.y + y);
    f
}

fn shade_block(
    corner: (i32, i32),
    block: &mut FragmentBlock<'_, 3>,
    (colors, uvs, ids, fronts): &mut Block,
) {
    for lane in 0..LANES {
        let f = moved(&block.fragment(lane), corner);
        let (is_discarded, [color, uv, id, front]) = choice(&f);
        if is_discarded {
            block.visible &= !(1 << lane);
        }
        if color {
            glass(&f).paint(&mut colors[lane]);
        }
        uvs[lane] = if uv { [f.params[0], f.params[1]] } else { uvs[lane] };
        ids[lane] = if id { f.face } else { ids[lane] };
        fronts[lane] = if front { f.front_facing } else { fronts[lane] };
    }
}

// ------------------------------------------------------------------------------------------ scenes

struct Scene {
    vertices: Vec<Vertex<3>>,
    faces: Vec<Vec<u32>>,
}

/// Small and large polygons through each other and through the eye.
fn scene(rng: &mut Rng, count: usize) -> Scene {
    let mut scene = Scene { vertices: Vec::new(), faces: Vec::new() };
    for _ in 0..count {
        let shape = match rng.below(4) {
            0 => generators::through_eye::<3>(rng, 4),
            1 => {
                let sides = 3 + rng.below(4);
                generators::random_convex(rng, sides, 20.0)
            }
            _ => generators::random_triangle(rng, 5.0, 1.2),
        };
        let first = scene.vertices.len() as u32;
        scene.vertices.extend(vertices(&shape));
        // Most are small.
        if rng.below(4) > 0 {
            let shift = vec3(rng.range(-0.9, 0.9) as f32, rng.range(-0.9, 0.9) as f32, 0.0);
            for vertex in &mut scene.vertices[first as usize..] {
                let w = vertex.position.w;
                vertex.position =
                    (vertex.position.truncate() * vec3(0.1, 0.1, 1.0) + shift * w).extend(w);
            }
        }
        scene.faces.push((first..scene.vertices.len() as u32).collect());
    }
    scene
}

// ------------------------------------------------------------------------------------- the passes

/// The buffers and the depths.
#[derive(Debug, PartialEq)]
struct Picture {
    colors: Vec<Vec4>,
    uvs: Vec<[f32; 2]>,
    ids: Vec<u32>,
    fronts: Vec<bool>,
    depths: Vec<f32>,
}

impl Picture {
    fn new((width, height): (u32, u32)) -> Self {
        let count = (width * height) as usize;
        let (color, uv, id, front) = NOTHING;
        Self {
            colors: vec![color; count],
            uvs: vec![uv; count],
            ids: vec![id; count],
            fronts: vec![front; count],
            depths: vec![1.0; count],
        }
    }

    fn target(&mut self, width: u32) -> Target<'_, Buffers<Pixel>> {
        let buffers = (&mut self.colors, &mut self.uvs, &mut self.ids, &mut self.fronts);
        Target::of_buffers(width, buffers, &mut self.depths).expect("buffers of one length")
    }

    fn tile(&self, width: usize, (x, y): (usize, usize), (columns, rows): (usize, usize)) -> Self {
        let pixels = || (y..y + rows).flat_map(|y| (x..x + columns).map(move |x| y * width + x));
        Self {
            colors: pixels().map(|i| self.colors[i]).collect(),
            uvs: pixels().map(|i| self.uvs[i]).collect(),
            ids: pixels().map(|i| self.ids[i]).collect(),
            fronts: pixels().map(|i| self.fronts[i]).collect(),
            depths: pixels().map(|i| self.depths[i]).collect(),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Way {
    Fragments,
    Blocks,
    FragmentsOnOneThread,
    BlocksOnOneThread,
    /// Each face in a call of its own.
    FaceByFace,
}

const WAYS: [Way; 5] = [
    Way::Fragments,
    Way::Blocks,
    Way::FragmentsOnOneThread,
    Way::BlocksOnOneThread,
    Way::FaceByFace,
];

/// Draws a scene in one pass, and in separate ones.
macro_rules! passes {
    ($one_pass:ident, $separately:ident, $renderer:ident, $set_up:expr) => {
        fn $one_pass(
            scene: &Scene,
            way: Way,
            level: Level,
            corner: (i32, i32),
            size: (u32, u32),
        ) -> Picture {
            let mut picture = Picture::new(size);
            let viewport = Viewport::new(SIZE.0, SIZE.1).expect("a small one");
            let mut renderer = $renderer::new(viewport.with_corner(-corner.0, -corner.1));
            renderer.simd_level = level;
            $set_up(&mut renderer);
            let mut target = picture.target(size.0);
            let mesh = Mesh::new(&scene.vertices, &scene.faces);
            let one: &Shader<'_> = &|f| shade(&moved(f, corner));
            let by_block: &BlockShader<'_> = &|block, values| shade_block(corner, block, values);
            match way {
                Way::Fragments => renderer.draw(&mut target, mesh, one),
                Way::Blocks => renderer.draw_blocks(&mut target, mesh, by_block),
                Way::FragmentsOnOneThread => {
                    renderer.on_one_thread().draw(&mut target, mesh, one);
                }
                Way::BlocksOnOneThread => {
                    renderer.on_one_thread().draw_blocks(&mut target, mesh, by_block);
                }
                Way::FaceByFace => {
                    for (face, number) in scene.faces.iter().zip(0..) {
                        let mesh = Mesh::new(&scene.vertices, [face]);
                        let numbered: &Shader<'_> = &|f| {
                            let mut f = *f;
                            f.face = number;
                            shade(&f)
                        };
                        renderer.draw(&mut target, mesh, numbered);
                    }
                }
            }
            picture
        }

        fn $separately(scene: &Scene) -> Picture {
            fn pass<C: Copy + Send, P: Paint<C>>(
                scene: &Scene,
                nothing: C,
                shader: impl Fn(&Fragment<'_, 3>) -> Option<Option<P>> + Sync,
            ) -> (Vec<C>, Vec<f32>) {
                let frame = Framebuffer::new(SIZE.0, SIZE.1, Alone(nothing));
                let mut frame = frame.expect("a small frame");
                let mut renderer = $renderer::new(frame.viewport());
                $set_up(&mut renderer);
                let mesh = Mesh::new(&scene.vertices, &scene.faces);
                renderer.draw(&mut frame, mesh, dynamic(|f| shader(f).map(Written)));
                let (values, depths) = frame.into_parts();
                (values.into_iter().map(|Alone(value)| value).collect(), depths)
            }
            let (colors, depths) = pass(scene, NOTHING.0, |f| shade(f).map(|all| Some(all.0)));
            let (uvs, depths_of_uv) = pass(scene, NOTHING.1, |f| shade(f).map(|all| all.1));
            let (ids, _) = pass(scene, NOTHING.2, |f| shade(f).map(|all| all.2));
            let (fronts, _) = pass(scene, NOTHING.3, |f| shade(f).map(|all| all.3));
            assert!(depths == depths_of_uv);
            Picture { colors, uvs, ids, fronts, depths }
        }
    };
}

passes!(by_z_buffer, by_z_buffer_separately, ZBufferRenderer, |_: &mut ZBufferRenderer<3>| ());
passes!(by_scanline, by_scanline_separately, ScanlineRenderer, |_: &mut ScanlineRenderer<3>| ());
passes!(by_painter, by_painter_separately, PainterRenderer, |painter: &mut PainterRenderer<3>| {
    painter.depth_write = true;
});

fn levels() -> [Level; 2] {
    [Level::baseline(), Level::new()]
}

/// Bits, so that NaN is itself.
fn check(picture: &Picture, expected: &Picture, what: &str) {
    let bits = |picture: &Picture, i: usize| {
        (
            picture.colors[i].to_array().map(f32::to_bits),
            picture.uvs[i].map(f32::to_bits),
            picture.ids[i],
            picture.fronts[i],
            picture.depths[i].to_bits(),
        )
    };
    assert_eq!(picture.ids.len(), expected.ids.len(), "{what}");
    let pixels = 0..expected.ids.len();
    let differs = pixels.filter(|&i| bits(picture, i) != bits(expected, i)).count();
    assert_eq!(differs, 0, "{what}: pixels that differ");
}

#[test]
fn one_pass_draws_what_separate_passes_do() {
    let mut rng = Rng::new(0x0B0F);
    let mut drawn = [0; 4];
    for round in 0..6 {
        let scene = scene(&mut rng, 8 << round);
        let expected = by_z_buffer_separately(&scene);
        let scanline = by_scanline_separately(&scene);
        for way in WAYS {
            for level in levels() {
                let what = format!("scene {round}, {way:?}, {level:?}");
                check(&by_z_buffer(&scene, way, level, (0, 0), SIZE), &expected, &what);
                if !matches!(way, Way::FaceByFace) {
                    // A scene at once.
                    let picture = by_scanline(&scene, way, level, (0, 0), SIZE);
                    check(&picture, &scanline, &format!("{what}, scanline"));
                }
            }
        }
        let painter = by_painter_separately(&scene);
        for way in [Way::Fragments, Way::Blocks, Way::BlocksOnOneThread] {
            let picture = by_painter(&scene, way, Level::new(), (0, 0), SIZE);
            check(&picture, &painter, &format!("scene {round}, {way:?}, painter"));
        }
        drawn[0] += expected.colors.iter().filter(|color| **color != NOTHING.0).count();
        drawn[1] += expected.uvs.iter().filter(|uv| **uv != NOTHING.1).count();
        drawn[2] += expected.ids.iter().filter(|id| **id != NOTHING.2).count();
        drawn[3] += expected.fronts.iter().filter(|front| **front).count();
    }
    assert!(drawn.iter().all(|&drawn| drawn > 10_000), "only {drawn:?} pixels are drawn");
}

#[test]
fn in_tiles_and_by_any_number_of_threads() {
    let mut rng = Rng::new(0x0B10);
    let scene = scene(&mut rng, 200);
    let whole = by_z_buffer_separately(&scene);
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        for way in [Way::Fragments, Way::Blocks] {
            let picture = pool.install(|| by_z_buffer(&scene, way, Level::new(), (0, 0), SIZE));
            check(&picture, &whole, &format!("{way:?} by {threads} threads"));
        }
    }
    // Narrow ones, where the halves of a block lie over each other, and wide ones.
    for (x, y, columns, rows) in
        [(0, 0, 60, 40), (60, 40, 90, 70), (31, 17, 5, 60), (80, 3, 1, 100), (9, 50, 11, 1)]
    {
        for way in [Way::Fragments, Way::Blocks] {
            let tile = by_z_buffer(&scene, way, Level::new(), (x, y), (columns, rows));
            let size = (columns as usize, rows as usize);
            let expected = whole.tile(SIZE.0 as usize, (x as usize, y as usize), size);
            check(&tile, &expected, &format!("tile at {x}, {y} of {columns} x {rows}"));
        }
    }
}

#[test]
fn a_texture_paints_one_of_several_buffers() {
    let mut rng = Rng::new(0x0B11);
    let scene = scene(&mut rng, 60);
    let color = |x: u32, y: u32| vec3(x as f32, y as f32, (x * y) as f32).extend(40.0) / 40.0;
    let texture =
        Texture::from_fn(40, 40, color).and_then(Texture::with_mipmaps).expect("a texture");
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let viewport = Viewport::new(SIZE.0, SIZE.1).expect("a small one");
    let mut renderer = ZBufferRenderer::new(viewport);
    let mesh = Mesh::new(&scene.vertices, &scene.faces);

    let mut alone = Framebuffer::new(SIZE.0, SIZE.1, Vec4::ZERO).expect("a small frame");
    renderer.draw(&mut alone, mesh, dynamic(|f| Texture::paint(&texture, f.footprint(0, 1))));
    let mut ids_alone = Framebuffer::new(SIZE.0, SIZE.1, 0u32).expect("a small frame");
    renderer.draw(&mut ids_alone, mesh, dynamic(|f| (f.x % 3 > 0).then_some(f.face)));
    let id = |f: &Fragment<'_, 3>| (f.x % 3 > 0).then_some(f.face);

    let (mut colors, mut ids) = (vec![Vec4::ZERO; pixels], vec![0u32; pixels]);
    let mut depths = vec![1.0; pixels];
    let mut target =
        Target::of_buffers(SIZE.0, (&mut colors, &mut ids), &mut depths).expect("one length");
    renderer.draw(
        &mut target,
        mesh,
        dynamic(|f| (Texture::paint(&texture, f.footprint(0, 1)), f.face)),
    );
    assert!(colors == alone.color());
    assert!(depths == alone.depth());

    // Discarded as a whole.
    let mut target =
        Target::of_buffers(SIZE.0, (&mut colors, &mut ids), &mut depths).expect("one length");
    renderer.clear(&mut target, Buffers((Vec4::ZERO, 0)));
    renderer.draw(
        &mut target,
        mesh,
        dynamic(|f| id(f).map(|id| (Texture::paint(&texture, f.footprint(0, 1)), id))),
    );
    assert!(ids == ids_alone.color());
    assert!(depths == ids_alone.depth());
    let painted = |(color, id): (&Vec4, &u32)| (*color != Vec4::ZERO) == (*id != 0);
    assert!(colors.iter().zip(&ids).filter(|pair| painted(*pair)).count() > pixels / 2);
}

/// What a shader of blocks leaves in the lanes that are not visible reaches no buffer.
#[test]
fn a_block_writes_its_visible_lanes_alone() {
    let triangle =
        [(-0.9, -0.8), (0.7, -0.6), (0.1, 0.9)].map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
    let mut coverage = Framebuffer::new(40, 30, false).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(coverage.viewport());
    renderer.draw(&mut coverage, &triangle, dynamic(|_| true));
    let (mut bytes, mut normals) = (vec![0u8; 1200], vec![Vec3::ZERO; 1200]);
    let mut depths = vec![1.0; 1200];
    let mut target = Target::of_buffers(40, (&mut bytes, &mut normals), &mut depths).expect("rows");
    let blocks = Mutex::new(0);
    renderer.draw_blocks(&mut target, &triangle, |_, (bytes, normals)| {
        *blocks.lock().expect("not poisoned") += 1;
        *bytes = [7; LANES];
        *normals = [Vec3::ONE; LANES];
    });
    assert!(*blocks.lock().expect("not poisoned") > 10);
    for (i, covered) in coverage.color().iter().enumerate() {
        let expected = if *covered { (7, Vec3::ONE) } else { (0, Vec3::ZERO) };
        assert_eq!((bytes[i], normals[i]), expected, "pixel {i}");
    }
}

#[test]
fn buffers_of_other_lengths_are_refused() {
    let error = |lengths: [usize; 3], width| {
        let [mut a, mut b, mut depths] = lengths.map(|len| vec![1.0f32; len]);
        let target = Target::of_buffers(width, (&mut a, &mut b[..]), &mut depths);
        target.expect_err("it does not fit")
    };
    let length = |number, values| TargetError::BufferLength { number, values, depths: 12 };
    assert_eq!(error([11, 12, 12], 4), length(1, 11));
    assert_eq!(error([12, 13, 12], 4), length(2, 13));
    assert_eq!(
        length(2, 13).to_string(),
        "buffer 2 has 13 values and there are 12 depths: each pixel needs one of both"
    );
    assert_eq!(error([12, 12, 12], 5), TargetError::NotWholeRows { width: 5, pixels: 12 });
}
