//! Contract 7: nothing is allocated once the first polygons have been drawn.

use glam::vec4;
use polyscan::{ClipPlane, FillRule, Fragment, Framebuffer, Vertex, ZBufferRenderer};
use stats_alloc::Region;

use crate::{COUNTING, alone};

/// Triangles, n-gons, clipped and concave ones.
fn polygons() -> Vec<Vec<Vertex<3>>> {
    let circle = |sides: usize, radius: f32, dent: f32, z: f32| -> Vec<Vertex<3>> {
        (0..sides)
            .map(|i| {
                let angle = std::f32::consts::TAU * i as f32 / sides as f32;
                let r = if i % 2 == 0 { radius } else { radius * dent };
                let w = 1.0 + 0.4 * angle.cos();
                Vertex::new(
                    vec4(r * angle.cos(), r * angle.sin(), (0.4 + z) * w, w),
                    [angle.cos(), angle.sin(), i as f32],
                )
            })
            .collect()
    };
    vec![
        circle(3, 0.8, 1.0, 0.0),
        circle(9, 0.9, 1.0, 0.1),
        circle(12, 3.0, 1.0, 0.2),
        circle(10, 0.9, 0.3, 0.0),
        circle(7, 2.0, 0.5, 0.7),
        circle(4, 1.5, 1.0, -0.2),
    ]
}

/// One shader for all, so that the renderer is compiled for no other.
fn shade(fragment: &Fragment<'_, 3>) -> [f32; 3] {
    fragment.params
}

/// How many times `work` allocates or reallocates when it is done again: the least of three counts,
/// as the thread that runs the tests may allocate at the same time.
fn allocations(mut work: impl FnMut()) -> usize {
    work();
    let count = |_| {
        let region = Region::new(COUNTING);
        work();
        let change = region.change();
        change.allocations + change.reallocations
    };
    (0..3).map(count).min().unwrap_or(0)
}

#[test]
fn nothing_is_allocated_in_the_steady_state() {
    let _alone = alone();
    let polygons = polygons();
    let mut frame = Framebuffer::new(100, 80, [0.0f32; 3]).expect("a small frame");
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    let drawing = allocations(|| {
        frame.clear([0.0; 3], 1.0);
        for polygon in &polygons {
            renderer.draw(&mut frame, polygon, shade);
            renderer.draw_depth(&mut frame, polygon);
        }
    });
    assert_eq!(drawing, 0);

    // A comb with more teeth than the standard library sorts without a buffer, and all contours as
    // one polygon; whole and cut into parts.
    let comb: Vec<_> = (0..100)
        .flat_map(|i| {
            let x = i as f32 / 50.0 - 1.0;
            [[x, -0.9], [x + 0.01, 0.8]].map(|[x, y]| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y, x]))
        })
        .collect();
    let cuts = [vec4(0.1, -1.0, 0.0, 0.3), vec4(-1.0, 0.0, 0.0, 0.2)].map(ClipPlane::new);
    let contours = allocations(|| {
        for planes in [&cuts[..0], &cuts[..]] {
            renderer.settings.planes.clear();
            renderer.settings.planes.extend(planes);
            for rule in [FillRule::NonZero, FillRule::EvenOdd] {
                renderer.settings.fill_rule = rule;
                renderer.draw(&mut frame, &comb, shade);
                renderer.draw(&mut frame, &polygons, shade);
            }
        }
    });
    assert_eq!(contours, 0);

    // On one thread: handing work to others is rayon's, which may allocate for its queues.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let mut indices = 0u32..;
    let faces: Vec<Vec<u32>> =
        polygons.iter().map(|polygon| indices.by_ref().take(polygon.len()).collect()).collect();
    let vertices = polygons.concat();
    let meshes = pool.install(|| {
        allocations(|| {
            renderer.draw(&mut frame, polyscan::Mesh::new(&vertices, &faces), shade);
            renderer.draw(&mut frame, polyscan::Mesh::new(&vertices, &faces[..2]), shade);
        })
    });
    assert_eq!(meshes, 0);

    // More faces than the standard library sorts without a buffer.
    let many: Vec<_> = faces.iter().cycle().take(200).collect();
    let sorted = pool.install(|| {
        allocations(|| {
            let mesh = polyscan::Mesh::new(&vertices, &many).back_to_front();
            renderer.draw(&mut frame, mesh, shade);
        })
    });
    assert_eq!(sorted, 0);

    let collecting = allocations(|| drop(polygons.clone()));
    assert!(collecting > 0, "the count works");
}
