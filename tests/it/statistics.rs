//! Statistics, stencil and occlusion queries: against counts and models that are made pixel by pixel and
//! face by face, of what single faces cover when each is drawn alone.

use std::array::from_fn;

use crate::common::generators::Rng;
use crate::common::{dynamic, dynamic_mut};
use glam::Vec4;
use polyscan::render::{RenderTarget, Statistics, Stencil, StencilFace, StencilOp, StencilTest};
use polyscan::{
    Cull, DepthTest, Framebuffer, Level, Mesh, PainterRenderer, Rect, ScanlineRenderer,
    TargetError, Vertex, ZBufferRenderer,
};

const SIZE: (u32, u32) = (93, 61);
const PIXELS: usize = (SIZE.0 * SIZE.1) as usize;

/// Triangles and convex quads in planes of their own; some lie outside, some reach through the near plane.
fn scene(rng: &mut Rng, count: usize) -> (Vec<Vertex<0>>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let sides = 3 + rng.below(2);
        let middle: [f64; 2] = from_fn(|_| rng.range(-1.6, 1.6));
        let [size, turn] = [rng.octaves(0.02, 1.0), rng.range(0.0, 6.0)];
        let [near, slope_x, slope_y] =
            [rng.range(-0.3, 1.2), rng.range(-0.4, 0.4), rng.range(-0.4, 0.4)];
        let direction = if rng.once_in(2) { 1.0 } else { -1.0 };
        let first = vertices.len() as u32;
        for side in 0..sides {
            let angle =
                turn + direction * std::f64::consts::TAU * f64::from(side as u32) / sides as f64;
            let [x, y] = [middle[0] + size * angle.cos(), middle[1] + size * angle.sin()];
            let z = near + slope_x * (x - middle[0]) + slope_y * (y - middle[1]);
            let w = 2.0;
            let position = Vec4::from_array([x * w, y * w, z * w, w].map(|c| c as f32));
            vertices.push(Vertex::new(position, []));
        }
        faces.push((first..vertices.len() as u32).collect());
    }
    (vertices, faces)
}

fn frame<C: Copy>(color: C) -> Framebuffer<C> {
    Framebuffer::new(SIZE.0, SIZE.1, color).expect("a small frame")
}

/// The depths of a face alone, where it covers pixels.
fn depths_of(
    vertices: &[Vertex<0>],
    face: &[u32],
    set_up: &dyn Fn(&mut ZBufferRenderer<0>),
) -> Vec<Option<f32>> {
    let mut frame = frame(false);
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    set_up(&mut renderer);
    renderer.depth_test = DepthTest::Always;
    renderer.draw(&mut frame, Mesh::new(vertices, [face]), dynamic(|_| true));
    let (covered, depths) = frame.into_parts();
    covered.into_iter().zip(depths).map(|(covered, depth)| covered.then_some(depth)).collect()
}

/// Whether some pixels are discarded.
fn is_discarded(x: i32, y: i32, face: u32) -> bool {
    (x + 2 * y + face as i32) % 5 == 0
}

/// What the statistics should be of faces drawn by the z-buffer in their order.
fn expected(
    vertices: &[Vertex<0>],
    faces: &[Vec<u32>],
    discards: bool,
    set_up: &dyn Fn(&mut ZBufferRenderer<0>),
) -> [u64; 9] {
    let mut renderer = ZBufferRenderer::new(frame(()).viewport());
    set_up(&mut renderer);
    let scissor =
        renderer.settings.scissor.unwrap_or(Rect { x: 0, y: 0, width: SIZE.0, height: SIZE.1 });
    let mut stored = vec![1.0; PIXELS];
    let mut counts = [0; 9];
    for (face, number) in faces.iter().zip(0..) {
        let positions: Vec<Vec4> = face.iter().map(|&i| vertices[i as usize].position).collect();
        counts[0] += 1;
        // All w are 2: what of it is between near and far.
        let is_cut = |beyond: &dyn Fn(&Vec4) -> bool| positions.iter().any(beyond);
        let is_out = |beyond: &dyn Fn(&Vec4) -> bool| positions.iter().all(beyond);
        let (near, far) = (|p: &Vec4| p.z < 0.0, |p: &Vec4| p.z > p.w);
        let area: f64 = (0..positions.len())
            .map(|i| {
                let [a, b] = [i, (i + 1) % positions.len()].map(|i| positions[i].as_dvec4());
                a.x * b.y - b.x * a.y
            })
            .sum();
        // The extent of what is left, from the edges cut at the planes.
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for i in 0..positions.len() {
            let [a, b] =
                [positions[i], positions[(i + 1) % positions.len()]].map(|p| p.as_dvec4() / 2.0);
            for t in 0..=2000 {
                let at = a + (b - a) * f64::from(t) / 2000.0;
                if (0.0..=1.0).contains(&at.z) {
                    let place = [
                        (at.x * 0.5 + 0.5) * f64::from(SIZE.0),
                        (0.5 - at.y * 0.5) * f64::from(SIZE.1),
                    ];
                    for (extent, place) in extent.iter_mut().zip(place) {
                        *extent = [extent[0].min(place), extent[1].max(place)];
                    }
                }
            }
        }
        let has_centres = |[first, last]: [f64; 2], start: i32, len: u32| {
            let (first, end) = ((first - 0.5).ceil(), (last - 0.5).floor() + 1.0);
            first.max(f64::from(start)) < end.min(f64::from(start) + f64::from(len))
        };
        let is_on_screen = has_centres(extent[0], scissor.x, scissor.width)
            && has_centres(extent[1], scissor.y, scissor.height);
        if is_out(&near) || is_out(&far) {
            counts[1] += 1;
            continue;
        }
        if renderer.settings.cull == Cull::Back && area < 0.0 {
            counts[2] += 1;
            continue;
        }
        if !is_on_screen {
            counts[1] += 1;
            continue;
        }
        counts[3] += u64::from(is_cut(&near) || is_cut(&far));
        let mut seen = false;
        for (i, depth) in depths_of(vertices, face, set_up).into_iter().enumerate() {
            let Some(depth) = depth else { continue };
            counts[6] += 1;
            if depth < stored[i] {
                counts[7] += 1;
                let (x, y) = (i as i32 % SIZE.0 as i32, i as i32 / SIZE.0 as i32);
                if !(discards && is_discarded(x, y, number)) {
                    counts[8] += 1;
                    stored[i] = depth;
                    seen = true;
                }
            }
        }
        counts[if seen { 5 } else { 4 }] += 1;
    }
    counts
}

fn in_order(statistics: &Statistics) -> [u64; 9] {
    let Statistics { polygons, outside, culled, clipped, hidden, drawn, .. } = *statistics;
    let Statistics { pixels_tested, pixels_shaded, pixels_drawn, .. } = *statistics;
    [polygons, outside, culled, clipped, hidden, drawn, pixels_tested, pixels_shaded, pixels_drawn]
}

#[test]
fn statistics_are_what_is_counted_face_by_face() {
    let mut rng = Rng::new(0x57A7);
    let mut sums = [0; 9];
    for round in 0..24 {
        let (vertices, faces) = scene(&mut rng, 60);
        let discards = round % 3 == 0;
        let set_up = |renderer: &mut ZBufferRenderer<0>| {
            renderer.settings.cull = if round % 2 == 0 { Cull::Back } else { Cull::None };
            renderer.settings.scissor =
                (round % 4 == 1).then_some(Rect { x: 11, y: 7, width: 40, height: 31 });
        };
        let expected = expected(&vertices, &faces, discards, &set_up);
        for (level, threads) in [(Level::new(), 1), (Level::new(), 3), (Level::baseline(), 2)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| {
                let (mut counted, mut plain) = (frame(0u32), frame(0u32));
                let mut renderer = ZBufferRenderer::new(counted.viewport());
                set_up(&mut renderer);
                renderer.simd_level = level;
                let mesh = || Mesh::new(&vertices, &faces);
                let draw = |renderer: &mut ZBufferRenderer<0>, frame: &mut Framebuffer<u32>| {
                    renderer.draw(
                        frame,
                        mesh(),
                        dynamic(|f| {
                            (!(discards && is_discarded(f.x, f.y, f.face))).then_some(f.face + 1)
                        }),
                    );
                };
                draw(&mut renderer, &mut plain);
                renderer.statistics = Some(Statistics::default());
                draw(&mut renderer, &mut counted);
                assert!(counted == plain, "counting changes nothing");
                let statistics = renderer.statistics.expect("it was asked for");
                assert_eq!(in_order(&statistics), expected, "scene {round}, {level:?}, {threads}");
            });
        }
        for (sum, count) in sums.iter_mut().zip(expected) {
            *sum += count;
        }
    }
    assert!(sums.iter().all(|&sum| sum > 20), "{sums:?}");
}

/// By the other renderers: of the painter's renderer all pixels are drawn, of the scanline renderer those
/// that are seen.
#[test]
fn statistics_of_the_other_renderers() {
    let mut rng = Rng::new(0x57A8);
    let (vertices, faces) = scene(&mut rng, 80);
    let by_face = expected(&vertices, &faces, false, &|_| ());
    let mesh = || Mesh::new(&vertices, &faces);

    let mut picture = frame(0u32);
    let mut painter = PainterRenderer::new(picture.viewport());
    painter.statistics = Some(Statistics::default());
    painter.draw(&mut picture, mesh(), dynamic(|f| f.face + 1));
    let statistics = painter.statistics.expect("it was asked for");
    let covered = by_face[6];
    assert_eq!(
        [statistics.pixels_tested, statistics.pixels_shaded, statistics.pixels_drawn],
        [covered; 3]
    );
    assert_eq!(
        [statistics.polygons, statistics.outside, statistics.clipped],
        [by_face[0], by_face[1], by_face[3]]
    );

    let mut picture = frame(0u32);
    let mut scanline = ScanlineRenderer::new(picture.viewport());
    scanline.statistics = Some(Statistics::default());
    scanline.draw(&mut picture, mesh(), dynamic(|f| f.face + 1));
    let statistics = scanline.statistics.expect("it was asked for");
    let mut seen: Vec<u32> = picture.color().iter().copied().filter(|&face| face > 0).collect();
    let pixels = seen.len() as u64;
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(
        [statistics.pixels_tested, statistics.pixels_shaded, statistics.pixels_drawn],
        [pixels; 3]
    );
    assert_eq!(
        [statistics.polygons, statistics.outside, statistics.drawn],
        [by_face[0], by_face[1], seen.len() as u64]
    );
    assert_eq!(statistics.hidden, statistics.polygons - statistics.outside - statistics.drawn);
}

// ---------------------------------------------------------------------------------------- queries

#[test]
fn a_query_counts_the_pixels_that_would_be_drawn_and_changes_nothing() {
    let mut rng = Rng::new(0x0C1E);
    let (mut some, mut none) = (0, 0);
    for _ in 0..150 {
        let (vertices, faces) = scene(&mut rng, 12);
        let mut picture = frame(0u32);
        let mut renderer = ZBufferRenderer::new(picture.viewport());
        renderer.draw(&mut picture, Mesh::new(&vertices, &faces), dynamic(|f| f.face));
        let before = picture.clone();
        for depth_test in [DepthTest::Nearer, DepthTest::NearerOrEqual, DepthTest::Farther] {
            renderer.depth_test = depth_test;
            let (vertices, faces) = scene(&mut rng, 2);
            let passes = |new: f32, old: f32| match depth_test {
                DepthTest::Nearer => new < old,
                DepthTest::NearerOrEqual => new <= old,
                _ => new > old,
            };
            let mut expected = 0;
            for face in &faces {
                let depths = depths_of(&vertices, face, &|_| ());
                let both = depths.into_iter().zip(picture.depth());
                expected +=
                    both.filter(|(new, old)| new.is_some_and(|new| passes(new, **old))).count();
            }
            let mesh = || Mesh::new(&vertices, &faces);
            assert_eq!(renderer.count_visible(&mut picture, mesh()), expected as u64);
            assert_eq!(renderer.is_any_visible(&mut picture, mesh()), expected > 0);
            assert!(picture == before);
            (some, none) = (some + u32::from(expected > 0), none + u32::from(expected == 0));
        }
    }
    assert!(some > 50 && none > 50, "{some} seen, {none} hidden");
    assert!(ZBufferRenderer::<0>::new(frame(()).viewport()).statistics.is_none());
}

// ---------------------------------------------------------------------------------------- stencil

const OPS: [StencilOp; 8] = [
    StencilOp::Keep,
    StencilOp::Zero,
    StencilOp::Replace,
    StencilOp::Invert,
    StencilOp::IncrementClamp,
    StencilOp::DecrementClamp,
    StencilOp::IncrementWrap,
    StencilOp::DecrementWrap,
];

const TESTS: [StencilTest; 8] = [
    StencilTest::Never,
    StencilTest::Less,
    StencilTest::Equal,
    StencilTest::LessOrEqual,
    StencilTest::Greater,
    StencilTest::NotEqual,
    StencilTest::GreaterOrEqual,
    StencilTest::Always,
];

/// The model: OpenGL 4.6, section 17.3.3, in whole numbers.
fn model(stencil: &Stencil, front: bool, stored: u8, passes_depth: bool) -> (bool, u8) {
    let side = if front { stencil.front } else { stencil.back };
    let (read, write) = (i32::from(stencil.read_mask), i32::from(stencil.write_mask));
    let (reference, old) = (i32::from(stencil.reference), i32::from(stored));
    let order = (reference & read).cmp(&(old & read)) as i32;
    let passes = match side.test {
        StencilTest::Never => &[][..],
        StencilTest::Less => &[-1],
        StencilTest::Equal => &[0],
        StencilTest::LessOrEqual => &[-1, 0],
        StencilTest::Greater => &[1],
        StencilTest::NotEqual => &[-1, 1],
        StencilTest::GreaterOrEqual => &[0, 1],
        StencilTest::Always => &[-1, 0, 1],
    }
    .contains(&order);
    let op = match (passes, passes_depth) {
        (false, _) => side.fail,
        (true, false) => side.depth_fail,
        (true, true) => side.pass,
    };
    let new = match op {
        StencilOp::Keep => old,
        StencilOp::Zero => 0,
        StencilOp::Replace => reference,
        StencilOp::Invert => 255 - old,
        StencilOp::IncrementClamp => (old + 1).min(255),
        StencilOp::DecrementClamp => (old - 1).max(0),
        StencilOp::IncrementWrap => (old + 1) % 256,
        StencilOp::DecrementWrap => (old + 255) % 256,
    };
    let bits =
        (0..8).map(|bit| if write >> bit & 1 != 0 { new & 1 << bit } else { old & 1 << bit });
    (passes && passes_depth, bits.sum::<i32>() as u8)
}

fn any_stencil(rng: &mut Rng) -> Stencil {
    let mut byte = || [0, 1, 2, 254, 255, rng.below(256) as u8][rng.below(6)];
    let [reference, read_mask, write_mask] = [byte(), byte() | 0xf0, byte() | 0x0f];
    let mut side = || StencilFace {
        test: TESTS[[rng.below(8), 7][rng.below(2)]],
        fail: OPS[rng.below(8)],
        depth_fail: OPS[rng.below(8)],
        pass: OPS[rng.below(8)],
    };
    let [front, back] = [side(), side()];
    Stencil { reference, read_mask, write_mask, front, back }
}

/// What a model makes of faces in their order, on stored depths and bytes.
struct Model {
    colors: Vec<u32>,
    depths: Vec<f32>,
    bytes: Vec<u8>,
}

impl Model {
    fn draw(
        &mut self,
        vertices: &[Vertex<0>],
        faces: &[Vec<u32>],
        stencil: &Stencil,
        compares: bool,
    ) {
        for (face, number) in faces.iter().zip(0..) {
            let corners: Vec<_> =
                face.iter().map(|&i| vertices[i as usize].position.as_dvec4()).collect();
            let pairs = (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
            let front = pairs.map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() > 0.0;
            for (i, depth) in depths_of(vertices, face, &|_| ()).into_iter().enumerate() {
                let Some(depth) = depth else { continue };
                let passes_depth = !compares || depth < self.depths[i];
                let (passes, byte) = model(stencil, front, self.bytes[i], passes_depth);
                let (x, y) = (i as i32 % SIZE.0 as i32, i as i32 / SIZE.0 as i32);
                if !passes {
                    self.bytes[i] = byte;
                } else if !is_discarded(x, y, number) {
                    self.bytes[i] = byte;
                    self.colors[i] = number + 1;
                    self.depths[i] = if compares { depth } else { self.depths[i] };
                }
            }
        }
    }
}

#[test]
fn the_stencil_does_what_the_model_does() {
    let mut rng = Rng::new(0x57E7);
    let (mut marked, mut drawn) = (0, 0);
    for round in 0..300 {
        let (vertices, faces) = scene(&mut rng, 14);
        let stencil = any_stencil(&mut rng);
        let bytes: Vec<u8> =
            (0..PIXELS).map(|_| [0, 1, 2, 255, rng.below(256) as u8][rng.below(5)]).collect();
        let mut model =
            Model { colors: vec![0; PIXELS], depths: vec![1.0; PIXELS], bytes: bytes.clone() };
        let by_painter = round % 5 == 4;
        let (mut picture, mut stored) = (frame(0u32), bytes.clone());
        let mut target = picture.target().with_stencil(&mut stored).expect("as many bytes");
        let shader =
            |f: &polyscan::Fragment<'_, 0>| (!is_discarded(f.x, f.y, f.face)).then_some(f.face + 1);
        if by_painter {
            // In their order: each face of its own.
            let mut renderer = PainterRenderer::new(target.viewport());
            renderer.stencil = Some(stencil);
            for (face, number) in faces.iter().zip(0..) {
                let of_face = |f: &polyscan::Fragment<'_, 0>| {
                    (!is_discarded(f.x, f.y, number)).then_some(number + 1)
                };
                renderer.draw(&mut target, Mesh::new(&vertices, [face]), dynamic(of_face));
            }
        } else {
            let mut renderer = ZBufferRenderer::new(target.viewport());
            renderer.stencil = Some(stencil);
            renderer.simd_level = if round % 2 == 0 { Level::new() } else { Level::baseline() };
            if round % 3 == 0 {
                renderer.on_one_thread().draw(
                    &mut target,
                    Mesh::new(&vertices, &faces),
                    dynamic_mut(shader),
                );
            } else {
                renderer.draw(&mut target, Mesh::new(&vertices, &faces), dynamic(shader));
            }
        }
        model.draw(&vertices, &faces, &stencil, !by_painter);
        assert!(picture.color() == model.colors, "colours of scene {round}: {stencil:?}");
        assert!(picture.depth() == model.depths, "depths of scene {round}: {stencil:?}");
        assert!(stored == model.bytes, "stencil of scene {round}: {stencil:?}");
        marked += stored.iter().zip(&bytes).filter(|(new, old)| new != old).count();
        drawn += model.colors.iter().filter(|&&color| color > 0).count();
    }
    assert!(marked > 100_000 && drawn > 100_000, "{marked} bytes change, {drawn} pixels are drawn");
}

#[test]
fn without_bytes_all_fragments_pass_and_a_query_changes_none() {
    let mut rng = Rng::new(0x57E8);
    let (vertices, faces) = scene(&mut rng, 40);
    let mesh = || Mesh::new(&vertices, &faces);
    let (mut plain, mut with_none) = (frame(0u32), frame(0u32));
    let mut renderer = ZBufferRenderer::new(plain.viewport());
    renderer.draw(&mut plain, mesh(), dynamic(|f| f.face + 1));
    renderer.stencil = Some(Stencil::only(3));
    renderer.draw(&mut with_none, mesh(), dynamic(|f| f.face + 1));
    assert!(plain == with_none);

    let mut bytes: Vec<u8> = (0..PIXELS).map(|i| if i % 3 == 0 { 3 } else { 0 }).collect();
    let before = bytes.clone();
    let mut picture = frame(0u32);
    let mut target = picture.target().with_stencil(&mut bytes).expect("as many bytes");
    let face = (0..faces.len())
        .find(|&i| depths_of(&vertices, &faces[i], &|_| ()).iter().flatten().count() > 300);
    let face = &faces[face.expect("one of them is large")];
    let depths = depths_of(&vertices, face, &|_| ());
    let expected = (0..PIXELS).filter(|i| i % 3 == 0 && depths[*i].is_some()).count();
    renderer.stencil = Some(Stencil { write_mask: 0xff, ..Stencil::only(3) });
    let one = || Mesh::new(&vertices, [face]);
    assert_eq!(renderer.count_visible(&mut target, one()), expected as u64);
    let always = StencilFace { pass: StencilOp::Invert, ..StencilFace::default() };
    renderer.stencil = Some(Stencil { front: always, back: always, ..Stencil::default() });
    assert!(renderer.is_any_visible(&mut target, one()));
    assert!(bytes == before);
}

#[test]
fn a_stencil_of_another_length_is_refused() {
    let mut picture = frame(0u32);
    let mut bytes = [0; 7];
    let error = picture.target().with_stencil(&mut bytes).expect_err("it does not fit");
    assert_eq!(error, TargetError::StencilLength { bytes: 7, depths: PIXELS });
    assert_eq!(
        error.to_string(),
        format!(
            "the stencil has 7 bytes and there are {PIXELS} depths: each pixel needs one of both"
        )
    );
}
