//! Many planes make nothing large of a polygon, however little of it is flat.

use glam::Vec3;
use polyscan::{ClipPlane, ScanConverter, Vertex, Viewport};
use stats_alloc::Region;

use crate::{COUNTING, alone};

#[test]
fn what_many_planes_make_of_a_polygon_far_from_planar_stays_small() {
    let _alone = alone();
    // Every other vertex is near a point that the planes approach from all sides: each of them cuts
    // about half of all edges, those along the planes before it among them.
    let mut state = 1u64;
    let mut coordinate = || {
        // Knuth's MMIX generator (The Art of Computer Programming 2, 3.3.4), its 24 highest bits.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut direction = || Vec3::from([0; 3].map(|_| coordinate()));
    let middle = Vec3::new(0.0, 0.0, 0.5);
    let polygon: Vec<_> = (0..2000)
        .map(|i| if i % 2 == 0 { 1e-6 } else { 0.4 })
        .map(|size: f32| Vertex::new((middle + size * direction()).extend(1.0), []))
        .collect();
    let planes: Vec<_> = (0..60)
        .map(|i| {
            let normal = direction().normalize_or_zero();
            ClipPlane::new(normal.extend(0.2 * 0.85f32.powi(i) - normal.dot(middle)))
        })
        .collect();

    // The bytes that a scan converter has taken for itself when it has drawn the polygon.
    let used = |planes: &[ClipPlane]| {
        let mut scan = ScanConverter::<0>::new(Viewport::new(64, 64).expect("small"));
        scan.planes = planes.to_vec();
        let region = Region::new(COUNTING);
        // All of the polygon is thinner than a subpixel.
        assert_eq!(scan.spans(&polygon).count(), 0);
        let change = region.change();
        change.bytes_allocated - change.bytes_deallocated
    };
    let (whole, cut) = (used(&[]), used(&planes));
    println!("{whole} bytes whole, {cut} bytes cut by 60 planes");
    assert!(cut < 8 * whole, "{whole} bytes whole, {cut} bytes cut by 60 planes");
}
