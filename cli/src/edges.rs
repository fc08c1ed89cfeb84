//! The edges of a model, and which of them a view shows as lines.
//!
//! An edge is a pair of positions, however many vertices a file has there. Where exactly two faces meet, bent by no
//! more than an angle, it is smooth, and a line only where one of the faces is seen from the front and the other from
//! behind: there the surface ends for the eye. All other edges are lines from everywhere.

use std::collections::HashMap;

use polyscan::Model;
use polyscan::glam::{DMat4, DVec3, DVec4, Mat4};
use rayon::prelude::*;

/// The cosine of 30 degrees, above which faces meet smoothly.
const SMOOTH: f64 = 0.866;

/// The edges of a model, by pairs of its vertices.
pub(crate) struct Edges {
    /// All of them.
    pub(crate) all: Vec<[u32; 2]>,
    /// Those where the surface bends or ends.
    sharp: Vec<[u32; 2]>,
    smooth: Vec<Smooth>,
}

/// An edge where two faces meet smoothly.
struct Smooth {
    ends: [u32; 2],
    /// A place is before a face where the product of both is positive. The faces are turned alike.
    planes: [DVec4; 2],
}

/// A side of a face.
#[derive(Clone, Copy)]
struct Side {
    /// The positions that it joins, the lesser number first.
    places: [u32; 2],
    /// In the order of the model, so that of equal ones the first stands for all.
    number: u32,
    face: u32,
    ends: [u32; 2],
    /// Whether it runs from the greater number to the lesser.
    is_turned: bool,
}

impl Edges {
    pub(crate) fn of(model: &Model) -> Self {
        let mut sides = sides(model);
        sides.par_sort_unstable_by_key(|side| (side.places, side.number));
        let planes: Vec<DVec4> = model.faces().map(|face| plane(model, face.indices)).collect();
        let mut edges = Self { all: Vec::new(), sharp: Vec::new(), smooth: Vec::new() };
        for sides in sides.chunk_by(|a, b| a.places == b.places) {
            let ends = sides[0].ends;
            edges.all.push(ends);
            match smooth_planes(sides, &planes) {
                Some(planes) => edges.smooth.push(Smooth { ends, planes }),
                None => edges.sharp.push(ends),
            }
        }
        edges
    }

    /// Those that are lines for an eye, given by its matrix from the model's space to clip space.
    pub(crate) fn seen_by(&self, clip_from_object: Mat4, lines: &mut Vec<[u32; 2]>) {
        let eye = eye(clip_from_object.as_dmat4());
        let is_line = |edge: &&Smooth| {
            let [first, second] = edge.planes.map(|plane| plane.dot(eye) > 0.0);
            first != second
        };
        lines.clear();
        lines.extend_from_slice(&self.sharp);
        lines.extend(self.smooth.iter().filter(is_line).map(|edge| edge.ends));
    }
}

fn sides(model: &Model) -> Vec<Side> {
    let mut numbers = HashMap::with_capacity(model.vertices.len());
    let number_at = |(vertex, number): (&polyscan::model::ModelVertex, u32)| {
        let bits = vertex.position.to_array().map(|n| (n + 0.0).to_bits());
        *numbers.entry(bits).or_insert(number)
    };
    let places: Vec<u32> = model.vertices.iter().zip(0..).map(number_at).collect();
    let mut sides = Vec::new();
    for (face, of_face) in (0..).zip(model.faces()) {
        let after = of_face.indices.iter().cycle().skip(1);
        for (&a, &b) in of_face.indices.iter().zip(after) {
            let [from, to] = [a, b].map(|vertex| places[vertex as usize]);
            if from != to {
                let (places, number) = ([from.min(to), from.max(to)], sides.len() as u32);
                let is_turned = from > to;
                sides.push(Side { places, number, face, ends: [a, b], is_turned });
            }
        }
    }
    sides
}

/// The plane of a face, by Newell's sum: a normal of length 1, and what makes it zero on the plane. All zero
/// for a face without area.
fn plane(model: &Model, indices: &[u32]) -> DVec4 {
    let position = |&i: &u32| model.vertices[i as usize].position.as_dvec3();
    let first = indices.first().map_or(DVec3::ZERO, position);
    let spokes = || indices.iter().map(|i| position(i) - first);
    let sum: DVec3 = spokes().zip(spokes().skip(1)).map(|(a, b)| a.cross(b)).sum();
    let normal = sum.normalize_or_zero();
    normal.extend(-normal.dot(first))
}

/// The planes of the faces at an edge, turned alike, if two meet there smoothly.
fn smooth_planes(sides: &[Side], planes: &[DVec4]) -> Option<[DVec4; 2]> {
    let &[first, second] = sides else { return None };
    let [a, b] = [first, second].map(|side| planes[side.face as usize]);
    // Faces that are turned alike run along their edge in opposite directions.
    let b = if first.is_turned == second.is_turned { -b } else { b };
    // What has no area is no bend.
    let is_flat = a == DVec4::ZERO || b == DVec4::ZERO;
    (is_flat || a.truncate().dot(b.truncate()) >= SMOOTH).then_some([a, b])
}

/// The place of the eye, homogeneous, up to its sign: where x, y and w of clip space are zero. It is the cross
/// product, in four dimensions, of the matrix's rows for them.
fn eye(clip_from_object: DMat4) -> DVec4 {
    let rows = clip_from_object.transpose();
    let [x, y, w] = [rows.x_axis, rows.y_axis, rows.w_axis];
    let minor = |pick: fn(DVec4) -> DVec3| pick(x).dot(pick(y).cross(pick(w)));
    DVec4::new(
        minor(|row| DVec3::new(row.y, row.z, row.w)),
        -minor(|row| DVec3::new(row.x, row.z, row.w)),
        minor(|row| DVec3::new(row.x, row.y, row.w)),
        -minor(|row| DVec3::new(row.x, row.y, row.z)),
    )
}

#[cfg(test)]
mod tests {
    use polyscan::formats::Loader;
    use polyscan::glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
    use polyscan::glam::{Vec3, vec3};

    use super::*;

    fn model(text: &str) -> Model {
        Loader::new().read(text.as_bytes(), "m.obj").expect("a model").model
    }

    fn count_seen(edges: &Edges, from: Vec3) -> usize {
        let view = look_at_mat4(from, Vec3::ZERO, vec3(0.1, 1.0, 0.2).normalize());
        let mut lines = Vec::new();
        edges.seen_by(perspective(0.5, 1.5, 0.1, 100.0) * view, &mut lines);
        lines.len()
    }

    const CUBE: &str =
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    const SIDES: [&str; 6] =
        ["f 4 3 2 1\n", "f 5 6 7 8\n", "f 1 2 6 5\n", "f 2 3 7 6\n", "f 3 4 8 7\n", "f 4 1 5 8\n"];

    #[test]
    fn a_cube_has_twelve_edges_from_everywhere() {
        let edges = Edges::of(&model(&format!("{CUBE}{}", SIDES.concat())));
        assert_eq!((edges.all.len(), edges.sharp.len()), (12, 12));
        // Without its front the four edges around it are where the surface ends.
        let open = Edges::of(&model(&format!("{CUBE}{}", SIDES[1..].concat())));
        assert_eq!((open.all.len(), open.sharp.len()), (12, 12));
    }

    /// The diagonals of a square's triangles are flat, whichever way the faces are turned; the outline is not.
    #[test]
    fn edges_within_a_flat_part_are_smooth() {
        let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        for faces in ["f 1 2 3\nf 1 3 4\n", "f 1 2 3\nf 1 4 3\n"] {
            let edges = Edges::of(&model(&format!("{points}{faces}")));
            assert_eq!((edges.all.len(), edges.sharp.len()), (5, 4));
            assert_eq!(count_seen(&edges, vec3(3.0, 2.0, 5.0)), 4, "{faces}");
            assert_eq!(count_seen(&edges, vec3(3.0, 2.0, -5.0)), 4, "{faces}");
        }
    }

    /// A drum of 24 sides: from beside it the rims, and the two edges where its round side ends for the eye; from above,
    /// on the axis, all round sides are seen from one side only.
    #[test]
    fn round_sides_end_where_the_eye_sees_them_end() {
        let mut text = String::new();
        for i in 0..24 {
            let angle = f64::from(i) * std::f64::consts::TAU / 24.0;
            text += &format!("v {0} 1 {1}\nv {0} -1 {1}\n", angle.sin(), angle.cos());
        }
        for i in 0..24 {
            let [a, b] = [i, (i + 1) % 24].map(|i| 2 * i + 1);
            // Every third is turned over.
            text += &if i % 3 == 0 {
                format!("f {a} {b} {} {}\n", b + 1, a + 1)
            } else {
                format!("f {a} {} {} {b}\n", a + 1, b + 1)
            };
        }
        let edges = Edges::of(&model(&text));
        assert_eq!((edges.all.len(), edges.sharp.len()), (72, 48));
        assert_eq!(count_seen(&edges, vec3(5.0, 0.3, 4.0)), 50);
        assert_eq!(count_seen(&edges, vec3(0.0, 9.0, 0.0)), 48);
    }
}
