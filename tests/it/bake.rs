//! Baking: no texel that a face touches is missed, values lie on the surface, overlaps are found, borders
//! are continued.

use std::collections::BTreeSet;
use std::time::Instant;

use crate::common::dynamic;
use crate::common::generators::Rng;
use glam::{Vec2, Vec3, vec2};
use polyscan::bake::{self, Baker, Overlap};
use polyscan::{
    CoverageRule, DepthTest, Framebuffer, Mesh, OutsidePolygon, Vertex, Viewport, ZBufferRenderer,
};

/// A grid of triangles in the unit square, jittered inside, with a margin around it, and the places of
/// its vertices.
fn grid(cells: u32, seed: u64) -> (Vec<Vec2>, Vec<[u32; 3]>) {
    let rng = &mut Rng::new(seed);
    let mut jitter = || rng.range(-0.3, 0.3) as f32;
    let place = |i: u32| {
        let (x, y) = (i % (cells + 1), i / (cells + 1));
        0.1 + (vec2(x as f32 + jitter(), y as f32 + jitter()) / cells as f32) * 0.8
    };
    let places = (0..(cells + 1).pow(2)).map(place).collect();
    let quads = (0..cells).flat_map(|y| (0..cells).map(move |x| y * (cells + 1) + x));
    let triangles = quads.flat_map(|i| {
        let below = i + cells + 1;
        [[i, i + 1, below], [below, i + 1, below + 1]]
    });
    (places, triangles.collect())
}

/// A surface over the texture: its height is a function that is affine on no more than one face.
fn lifted(uv: Vec2) -> Vec3 {
    uv.extend((uv.x * 7.0).sin() * (uv.y * 5.0).cos())
}

fn vertices(places: &[Vec2]) -> Vec<Vertex<3>> {
    places.iter().map(|&uv| bake::vertex(uv, lifted(uv))).collect()
}

#[test]
fn every_face_has_texels_and_their_values_lie_on_it() {
    const SIZE: u32 = 64;
    // Triangles of less than half a texel each.
    let (places, faces) = grid(100, 7);
    let vertices = vertices(&places);
    let mesh = Mesh::new(&vertices, &faces);
    let mut baker = Baker::<3>::new(SIZE, SIZE).expect("small");
    baker.margin = 0;
    let baked = baker.bake(mesh, (u32::MAX, Vec3::ZERO), |f| (f.face, f.params.into()));
    let baked = baked.expect("memory");
    assert!(baked.overlaps.is_empty());
    let (mut covered, mut worst) = (0, 0.0f32);
    for (i, &(face, place)) in baked.texels.color().iter().enumerate() {
        let centre = vec2(i as f32 % SIZE as f32, (i as u32 / SIZE) as f32) + 0.5;
        let uv = centre / SIZE as f32;
        if face == u32::MAX {
            continue;
        }
        covered += 1;
        let [a, b, c] = faces[face as usize].map(|i| places[i as usize]);
        // The place in the texture that the parameters are of: on the face, less than a texel away.
        let at = place.truncate();
        let area = (b - a).perp_dot(c - a);
        let weights =
            [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)];
        let weights = weights.map(|w| w / area);
        // By 1/256 texel the face may be rounded.
        let rounding = 2.0 / 256.0 / SIZE as f32 / (area.abs().sqrt());
        assert!(weights.iter().all(|w| *w > -4.0 * rounding), "texel {i}: {weights:?}");
        assert!(at.distance(uv) < 0.72 / SIZE as f32, "texel {i}: {at} for {uv}");
        let height = weights[0] * lifted(a).z + weights[1] * lifted(b).z + weights[2] * lifted(c).z;
        worst = worst.max((height - place.z).abs());
    }
    assert!(covered > 2500 && worst < 1e-4, "{covered} texels, off by {worst}");
    // All that lie within the grid, which has a margin of a tenth around it, and a third of a cell.
    for (y, x) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (y, x))) {
        let uv = vec2(x as f32 + 0.5, y as f32 + 0.5) / SIZE as f32;
        let (pixel, depth) = baked.texels.pixel(x, y).expect("inside");
        if uv.min_element() > 0.11 && uv.max_element() < 0.89 {
            assert!(pixel.0 != u32::MAX && depth < 1.0, "{x} {y}");
        }
    }
}

#[test]
fn faces_that_share_texels_are_reported() {
    let square = |from: f32, to: f32| {
        [vec2(from, from), vec2(to, from), vec2(to, to), vec2(from, to)]
            .map(|uv| bake::vertex(uv / 32.0, []))
    };
    let vertices = [square(2.0, 12.0), square(8.0, 20.0), square(20.0, 30.0)].concat();
    let faces = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]];
    let mut baker = Baker::<0>::new(32, 32).expect("small");
    let baked = baker.bake(Mesh::new(&vertices, faces), 9, |f| f.face).expect("memory");
    assert_eq!(baked.overlaps, [Overlap { faces: [0, 1], texels: 16 }]);
    // The first has them.
    assert_eq!(baked.texels.pixel(9, 9), Some((0, 0.5)));
    assert_eq!(baked.covered(), 100 + 144 - 16 + 100);
    // The same face twice.
    let twice = Mesh::new(&vertices, [faces[0], faces[0]]);
    let baked = baker.bake(twice, 9, |f| f.face).expect("memory");
    assert_eq!(baked.overlaps, [Overlap { faces: [0, 1], texels: 100 }]);
}

#[test]
fn borders_are_continued_by_so_many_texels() {
    const SIZE: u32 = 48;
    for seed in 0..20 {
        let rng = &mut Rng::new(seed);
        let corners = (0..6).map(|_| [0; 2].map(|_| rng.range(0.0, 1.0) as f32));
        let vertices: Vec<_> = corners.map(|uv| bake::vertex(uv.into(), [])).collect();
        let mut baker = Baker::<0>::new(SIZE, SIZE).expect("small");
        baker.margin = rng.below(7) as u32;
        let mesh = Mesh::new(&vertices, [[0, 1, 2], [3, 4, 5]]);
        let baked = baker.bake(mesh, [-1, -1], |f| [f.x, f.y]).expect("memory");
        let covered: Vec<[i32; 2]> = (0..SIZE)
            .flat_map(|y| (0..SIZE).map(move |x| (x, y)))
            .filter(|&(x, y)| baked.texels.pixel(x, y).is_some_and(|(_, depth)| depth < 1.0))
            .map(|(x, y)| [x as i32, y as i32])
            .collect();
        // All that the faces touch, by the renderer whose coverage is tested elsewhere.
        let mut renderer = ZBufferRenderer::<0>::new(Viewport::new(SIZE, SIZE).expect("small"));
        renderer.settings.coverage_rule = CoverageRule::Outer(OutsidePolygon::Clamp);
        let mut touched = Framebuffer::new(SIZE, SIZE, false).expect("small");
        renderer.draw(&mut touched, mesh, dynamic(|_| true));
        let count = touched.color().iter().filter(|is_touched| **is_touched).count();
        assert!(covered.len() == count && baked.covered() == count, "seed {seed}");
        for &[x, y] in &covered {
            assert_eq!(touched.pixel(x as u32, y as u32).map(|(color, _)| color), Some(true));
        }
        let distances = |[x, y]: [i32; 2]| {
            let off = covered.iter().map(move |c| [(c[0] - x).abs(), (c[1] - y).abs()]);
            off.map(|[dx, dy]| (dx.max(dy), dx * dx + dy * dy))
        };
        for (y, x) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (y, x))) {
            let (source, depth) = baked.texels.pixel(x, y).expect("inside");
            let place = [x as i32, y as i32];
            if depth < 1.0 {
                assert_eq!(source, place);
                continue;
            }
            let steps = distances(place).map(|d| d.0).min().expect("some");
            assert_eq!(source != [-1, -1], steps <= baker.margin as i32, "seed {seed}: {place:?}");
            if source != [-1, -1] {
                assert!(covered.contains(&source), "seed {seed}");
                let [dx, dy] = [source[0] - place[0], source[1] - place[1]];
                let in_reach = distances(place).filter(|d| d.0 <= baker.margin as i32);
                let least = in_reach.map(|d| d.1).min();
                assert_eq!(Some(dx * dx + dy * dy), least, "seed {seed}: {place:?}");
            }
        }
    }
}

#[test]
fn of_a_dense_atlas_centres_miss_faces_and_touched_texels_do_not() {
    const SIZE: u32 = 64;
    let (places, faces) = grid(40, 3);
    let vertices = vertices(&places);
    let seen = |is_outer: bool| {
        let mut renderer = ZBufferRenderer::<3>::new(Viewport::new(SIZE, SIZE).expect("small"));
        if is_outer {
            renderer.settings.coverage_rule = CoverageRule::Outer(OutsidePolygon::Clamp);
        }
        renderer.depth_test = DepthTest::Always;
        let mut frame = Framebuffer::new(SIZE, SIZE, ()).expect("small");
        let mut seen = BTreeSet::new();
        renderer.on_one_thread().draw(&mut frame, Mesh::new(&vertices, &faces), |f| {
            seen.insert(f.face);
        });
        seen.len()
    };
    let (by_centres, by_touch) = (seen(false), seen(true));
    assert!(by_centres * 4 < faces.len() * 3, "{by_centres} of {}", faces.len());
    assert_eq!(by_touch, faces.len());
}

#[test]
#[ignore = "for its time, in release"]
fn long_bake_of_200_000_triangles() {
    let (places, faces) = grid(317, 1);
    let vertices: Vec<Vertex<6>> =
        places.iter().map(|&uv| bake::vertex(uv, [uv.x, uv.y, 0.5, 0.0, 0.0, 1.0])).collect();
    let mut baker = Baker::<6>::new(2048, 2048).expect("fits");
    for _ in 0..5 {
        let start = Instant::now();
        let baked = baker.bake(Mesh::new(&vertices, &faces), [0.0; 6], |f| f.params);
        let covered = baked.expect("memory").covered();
        println!("{} triangles, {covered} texels: {:?}", faces.len(), start.elapsed());
    }
}
