//! The scanline renderer's memory grows with the width of the picture, not with its height.

use glam::vec4;
use polyscan::{Mesh, ScanlineRenderer, Vertex, Viewport};
use stats_alloc::Region;

use crate::{COUNTING, alone};

/// The most bytes in use at any row while a scene of so many faces is drawn.
fn peak(width: u32, height: u32, faces: usize) -> usize {
    let region = Region::new(COUNTING);
    let mut peak = 0;
    // Slabs across the view, one below the other and overlapping.
    let vertices: Vec<_> = (0..faces)
        .flat_map(|i| {
            let y = 1.0 - 2.0 * i as f32 / faces as f32;
            let corners = [(-1.0, y), (1.0, y), (1.0, y - 0.1), (-1.0, y - 0.1)];
            corners.map(|(x, y)| Vertex::new(vec4(x, y, 0.5 + 0.3 * x * y, 1.0), [x, y]))
        })
        .collect();
    let quads = (0..faces as u32).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]);
    let mut renderer = ScanlineRenderer::new(Viewport::new(width, height).expect("a size"));
    let drawn = renderer.stream(
        Mesh::new(&vertices, quads),
        [0.0; 2],
        |f| f.params,
        |_, _| {
            let change = region.change();
            peak = peak.max(change.bytes_allocated.saturating_sub(change.bytes_deallocated));
            Ok::<(), ()>(())
        },
    );
    assert_eq!(drawn, Ok(()));
    peak
}

#[test]
fn memory_grows_with_the_width_not_with_the_height() {
    let _alone = alone();
    // Of one thread, so that nothing depends on the machine.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    pool.install(|| {
        peak(100, 100, 40);
        let (low, high) = (peak(100, 1000, 40), peak(100, 20_000, 40));
        println!("{low} and {high} bytes");
        assert!(high < low + low / 8, "{low} bytes for 1000 rows, {high} for 20,000");
        let wide = peak(8000, 1000, 40);
        assert!(wide > 8 * low, "the count works: {wide} bytes for 8000 columns");
    });
}
