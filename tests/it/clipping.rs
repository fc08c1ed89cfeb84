//! The clipper on its own: planes, corners, the eye, and what becomes of shared edges.

use crate::common::generators::{self, Rng};
use crate::common::vertices;
use glam::{Vec4, vec4};
use polyscan::clip::{ClipVertex, Clipped, Clipper};
use polyscan::view_volume::MIN_W;
use polyscan::{ClipPlane, ClipSpace, Interpolation, Vertex};

/// A polygon with its own positions as parameters, so that interpolation can be checked anywhere.
fn labelled(positions: &[[f32; 4]]) -> Vec<Vertex<4>> {
    positions.iter().map(|&p| Vertex::new(p.into(), p)).collect()
}

fn clip(polygon: &[Vertex<4>], planes: &[ClipPlane]) -> Option<Vec<Vertex<4>>> {
    match Clipper::new().clip(polygon, planes) {
        Clipped::Outside => None,
        Clipped::Inside => Some(polygon.to_vec()),
        Clipped::Polygon(clipped) => Some(clipped.iter().map(ClipVertex::rounded).collect()),
    }
}

const SQUARE: [[f32; 4]; 4] =
    [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.5, 0.5, 0.5, 1.0], [-0.5, 0.5, 0.5, 1.0]];

/// The square moved by some vector.
fn moved(by: Vec4) -> Vec<Vertex<4>> {
    labelled(&SQUARE.map(|p| (Vec4::from(p) + by).to_array()))
}

/// Directions out of the view volume through each of its planes.
const OUT: [Vec4; 6] = [
    vec4(0.0, 0.0, -1.0, 0.0),
    vec4(0.0, 0.0, 1.0, 0.0),
    vec4(-1.0, 0.0, 0.0, 0.0),
    vec4(1.0, 0.0, 0.0, 0.0),
    vec4(0.0, -1.0, 0.0, 0.0),
    vec4(0.0, 1.0, 0.0, 0.0),
];

#[test]
fn outcodes_accept_and_reject_at_once() {
    let mut clipper = Clipper::new();
    for space in [ClipSpace::ZeroToOne, ClipSpace::MinusOneToOne] {
        assert_eq!(clipper.clip(&moved(Vec4::ZERO), &space.frustum()), Clipped::Inside);
        for out in OUT {
            assert_eq!(clipper.clip(&moved(out * 2.1), &space.frustum()), Clipped::Outside);
        }
    }
    assert_eq!(clipper.clip(&moved(vec4(0.0, 0.0, 0.0, -1.0)), &[]), Clipped::Outside);
}

#[test]
fn each_side_plane_cuts_the_square_in_half() {
    for (out, plane) in OUT.into_iter().zip(ClipSpace::ZeroToOne.frustum()).skip(2) {
        let cut = clip(&moved(out), &[plane]).expect("a half is inside");
        let area = |polygon: &[Vertex<4>]| -> f32 {
            let next = polygon.iter().cycle().skip(1);
            let cross = |(a, b): (&Vertex<4>, &Vertex<4>)| {
                a.position.x * b.position.y - b.position.x * a.position.y
            };
            polygon.iter().zip(next).map(cross).sum::<f32>() / 2.0
        };
        assert_eq!((cut.len(), area(&cut)), (4, 0.5));
    }
}

#[test]
fn near_and_far_follow_the_depth_convention() {
    let slope = labelled(&[[-0.5, 0.0, -2.0, 1.0], [0.5, 0.0, -2.0, 1.0], [0.0, 0.5, 2.0, 1.0]]);
    for (space, near) in [(ClipSpace::ZeroToOne, 0.0), (ClipSpace::MinusOneToOne, -1.0)] {
        let cut = clip(&slope, &space.frustum()).expect("the middle is inside");
        let depths: Vec<_> = cut.iter().map(|v| v.position.z).collect();
        assert_eq!(cut.len(), 4);
        assert_eq!(depths.iter().filter(|&&z| z == near).count(), 2, "{depths:?}");
        assert_eq!(depths.iter().filter(|&&z| z == 1.0).count(), 2, "{depths:?}");
    }
}

#[test]
fn a_corner_of_the_view_volume_adds_a_vertex_for_each_plane() {
    let triangle = labelled(&[[0.0, 0.0, 0.5, 1.0], [2.5, 0.0, 0.5, 1.0], [0.0, 2.5, 0.5, 1.0]]);
    let cut = clip(&triangle, &ClipSpace::ZeroToOne.frustum()).expect("a part is inside");
    let positions: Vec<_> = cut.iter().map(|v| [v.position.x, v.position.y]).collect();
    assert_eq!(positions, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

#[test]
fn a_polygon_around_the_view_volume_becomes_its_cross_section() {
    let around = labelled(&[[-9.0, -7.0, 0.5, 1.0], [8.0, -9.0, 0.5, 1.0], [1.0, 20.0, 0.5, 1.0]]);
    let cut = clip(&around, &ClipSpace::ZeroToOne.frustum()).expect("the middle is inside");
    assert_eq!(cut.len(), 4);
    for vertex in &cut {
        assert_eq!((vertex.position.x.abs(), vertex.position.y.abs()), (1.0, 1.0));
    }
}

#[test]
fn vertices_on_a_plane_are_kept_and_not_doubled() {
    let right = &ClipSpace::ZeroToOne.frustum()[3..4];
    let on = [1.0, 0.0, 0.5, 1.0];
    let through = labelled(&[[0.0, -0.5, 0.5, 1.0], on, [0.0, 0.5, 0.5, 1.0]]);
    assert_eq!(Clipper::new().clip(&through, right), Clipped::Inside);
    let pointed = labelled(&[on, [2.0, 0.5, 0.5, 1.0], [2.0, -0.5, 0.5, 1.0]]);
    assert_eq!(clip(&pointed, right), None, "only a vertex touches");
    let edge = labelled(&[on, [1.0, 0.5, 0.5, 1.0], [2.0, 0.0, 0.5, 1.0]]);
    assert_eq!(clip(&edge, right), None, "only an edge touches");
    let diamond = labelled(&[
        [0.0, 0.0, 0.5, 1.0],
        [1.0, -0.5, 0.5, 1.0],
        [2.0, 0.0, 0.5, 1.0],
        [1.0, 0.5, 0.5, 1.0],
    ]);
    let cut = clip(&diamond, right).expect("the left half is inside");
    assert_eq!(cut.len(), 3, "{cut:?}");
}

#[test]
fn w_stays_positive() {
    let planes = ClipSpace::MinusOneToOne.frustum();
    let mut checked = 0;
    for seed in 0..2000 {
        let rng = &mut Rng::new(seed);
        let polygon = if seed % 2 == 0 {
            let sides = 3 + rng.below(9);
            vertices(&generators::through_eye::<1>(rng, sides))
        } else {
            let triangle = generators::integer_triangle(rng);
            triangle.iter().map(|&p| Vertex::new(p.into(), [p[3]])).collect()
        };
        let mut clipper = Clipper::new();
        for planes in [&[], &planes[..1], &planes[..]] {
            if let Clipped::Polygon(cut) = clipper.clip(&polygon, planes) {
                assert!(cut.len() >= 3 && cut.len() <= polygon.len() + planes.len() + 1);
                assert!(cut.iter().all(|v| v.position.w >= MIN_W), "{cut:?}");
                checked += 1;
            }
        }
    }
    assert!(checked > 2000, "only {checked} polygons were left to check");
    // An edge through the eye itself.
    let eye = labelled(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, -1.0], [1.0, 0.0, 0.0, 1.0]]);
    let cut = clip(&eye, &[]).expect("a part is in front");
    assert_eq!(cut.iter().map(|v| v.position.w).fold(9.0, f32::min), f32::MIN_POSITIVE);
}

#[test]
fn new_vertices_on_a_shared_edge_are_the_same_to_the_bit() {
    let mut planes = ClipSpace::ZeroToOne.frustum().to_vec();
    planes.push(ClipPlane::new(vec4(0.3, -0.7, 0.2, 0.1)));
    let mut compared = 0;
    for seed in 0..3000 {
        let rng = &mut Rng::new(seed);
        let mut point = || {
            let w = rng.range(-1.0, 4.0);
            let [x, y, z] = std::array::from_fn(|_| rng.range(-6.0, 6.0) as f32);
            Vertex::new(vec4(x, y, z, w as f32), [rng.range(-1.0, 1.0) as f32, x, y])
        };
        let [a, b, c, d] = std::array::from_fn(|_| point());
        for interpolation in [Interpolation::Perspective, Interpolation::Linear] {
            let (mut one, mut other) = (Clipper::new(), Clipper::new());
            let one = one.clip_with(&[a, b, c], &planes, &[interpolation; 3]);
            let other = other.clip_with(&[b, a, d], &planes, &[interpolation; 3]);
            let (Clipped::Polygon(one), Clipped::Polygon(other)) = (one, other) else { continue };
            // The vertices of the one that lie on the line through a and b must be vertices of the
            // other. Those are at the ends of the shared edge, if any of it is visible.
            let bits = |v: &ClipVertex<3>| {
                (v.position.to_array().map(f64::to_bits), v.params.map(f64::to_bits))
            };
            let on_edge = |v: &&ClipVertex<3>| {
                let along = (b.position - a.position).as_dvec4();
                let off = v.position - a.position.as_dvec4();
                (off - along * (off.dot(along) / along.length_squared())).length() < 1e-6
            };
            let mut ends =
                [one, other].map(|cut| cut.iter().filter(on_edge).map(bits).collect::<Vec<_>>());
            ends.iter_mut().for_each(|ends| ends.sort_unstable());
            let [one, other] = ends;
            if one.len() == 2 && other.len() == 2 {
                assert_eq!(one, other, "seed {seed}");
                compared += 1;
            }
        }
    }
    assert!(compared > 300, "only {compared} edges were compared");
}

#[test]
fn all_parameters_are_interpolated_in_homogeneous_space() {
    let mut made = 0;
    for seed in 0..500 {
        let rng = &mut Rng::new(seed);
        let positions: Vec<[f32; 4]> =
            (0..5).map(|_| std::array::from_fn(|_| rng.range(-3.0, 3.0) as f32)).collect();
        if let Some(cut) = clip(&labelled(&positions), &ClipSpace::ZeroToOne.frustum()) {
            for vertex in cut {
                let off = Vec4::from(vertex.params) - vertex.position;
                assert!(off.abs().max_element() < 1e-6, "seed {seed}: {vertex:?}");
                made += usize::from(!positions.contains(&vertex.position.to_array()));
            }
        }
    }
    assert!(made > 500, "only {made} vertices were made by clipping");
}

#[test]
fn any_number_of_sides_and_planes() {
    let sides = 1000;
    let circle: Vec<_> = (0..sides)
        .map(|i| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
            [cos, sin, 0.5, 1.0]
        })
        .collect();
    // Planes all around that leave a smaller circle.
    let planes: Vec<_> = (0..100)
        .map(|i| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / 100.0).sin_cos();
            ClipPlane::new(vec4(-cos, -sin, 0.0, 0.5))
        })
        .collect();
    let cut = clip(&labelled(&circle), &planes).expect("the middle is inside");
    assert_eq!(cut.len(), 100);
    for vertex in &cut {
        let radius = vertex.position.truncate().truncate().length();
        assert!((0.499..0.501).contains(&radius), "{radius}");
    }
    let comb: Vec<_> = (0..500)
        .flat_map(|i| {
            let x = i as f32 / 250.0 - 1.0;
            [[x, -0.5, 0.5, 1.0], [x + 0.002, 3.0, 0.5, 1.0]]
        })
        .collect();
    let cut = clip(&labelled(&comb), &ClipSpace::ZeroToOne.frustum()).expect("teeth are inside");
    assert!(cut.len() > 1400 && cut.iter().all(|v| v.position.y <= 1.0));
}
