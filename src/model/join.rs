//! Corners that are alike become one vertex.
//!
//! Alike are corners of one point whose texture coordinates, normals and colours agree, and the side that a picture is seen from if that matters. Each point has its
//! vertices by itself, so that the points are shared among processors.

use std::collections::HashMap;
use std::ops::Range;

use foldhash::fast::RandomState;
use glam::{Vec2, Vec3, Vec4};

use crate::model::corners::Corners;
use crate::model::faces::{FacesByMaterial, range_before};
use crate::model::fans::Fans;
use crate::model::hands::Hands;
use crate::model::normals::{self, Normals};
use crate::model::vertex::ModelVertex;
use crate::render::parallel::for_each;

/// So many points are one thread's at a time.
const PART: usize = 2048;

/// Up to this many vertices of a point are compared one by one; points of real meshes have one to six.
const MAX_COMPARED: usize = 16;

/// All vertices, point by point, and the faces. Normals that the corners lack are computed, smooth where faces
/// meet at less than the crease angle, in radians from 0 to pi. For tangents to be found, corners are not alike if
/// the picture lies on one face as it is and on the other as in a mirror, or if their files give them other tangents. The
/// vertices' tangents are then those that are given, or else have nothing but `w`, which says the side.
pub(super) fn join(
    corners: Corners,
    crease_angle: f32,
    has_tangents: bool,
) -> (Vec<ModelVertex>, FacesByMaterial) {
    let fans = Fans::new(&corners);
    let normals = Normals::new(&corners, &fans, crease_angle);
    let hands = has_tangents.then(|| Hands::of(&corners));
    let starts = (0..fans.len()).step_by(PART);
    let mut parts: Vec<_> =
        starts.map(|start| Part::of(start..fans.len().min(start + PART))).collect();
    for_each(&mut parts, |_, part| part.fill(&corners, &fans, (&normals, hands.as_ref())));

    let mut vertices = Vec::with_capacity(parts.iter().map(|part| part.vertices.len()).sum());
    let mut indices = vec![0; corners.point.len()];
    let mut places = fans.corners().iter();
    for part in parts {
        let before = vertices.len() as u32;
        vertices.extend(part.vertices);
        for (index, &corner) in part.indices.iter().zip(&mut places) {
            indices[corner as usize] = before + index;
        }
    }
    let has_uv = has_uv(&corners);
    let Corners { ends, material_ends, .. } = corners;
    (vertices, FacesByMaterial { indices, ends, has_uv, sources: Vec::new(), material_ends })
}

/// For each face, whether the file gives a texture coordinate at every corner.
fn has_uv(corners: &Corners) -> Vec<bool> {
    let faces = 0..corners.ends.len();
    if corners.uv.is_empty() {
        return vec![false; faces.len()];
    }
    let has_uv = |corner: usize| corners.uv.get(corner).is_some_and(|uv| !uv.is_nan());
    faces.map(|face| range_before(&corners.ends, face).all(has_uv)).collect()
}

/// The vertices of some points.
struct Part {
    points: Range<usize>,
    vertices: Vec<ModelVertex>,
    /// For each of the points' corners its vertex in the part.
    indices: Vec<u32>,
}

impl Part {
    fn of(points: Range<usize>) -> Self {
        Self { points, vertices: Vec::new(), indices: Vec::new() }
    }

    fn fill(
        &mut self,
        corners: &Corners,
        fans: &Fans,
        (normals, hands): (&Normals<'_>, Option<&Hands>),
    ) {
        let Self { points, vertices, indices } = self;
        vertices.reserve(points.len());
        indices.reserve(7 * points.len());
        let mut memory = normals::Memory::default();
        let mut others = HashMap::default();
        for point in points.clone() {
            let (fan, position) = (fans.of(point), corners.points[point]);
            normals.fill(point, &mut memory);
            let first = vertices.len();
            others.clear();
            for (&corner, &normal) in fan.iter().zip(&memory.normals) {
                let uv = corners.uv.get(corner as usize).copied().unwrap_or(Vec2::NAN);
                let uv = if uv.is_nan() { Vec2::ZERO } else { Vec2::new(uv.x, 1.0 - uv.y) };
                let color = corners.color.get(corner as usize).copied().unwrap_or(Vec4::ONE);
                let given = corners.tangent.get(corner as usize).copied().unwrap_or(Vec4::ZERO);
                let tangent = match hands {
                    Some(_) if given != Vec4::ZERO => given,
                    Some(hands) => Vec4::W * hands.sign(corner, normal),
                    None => Vec4::ZERO,
                };
                let vertex = ModelVertex { position, normal, uv, color, tangent };
                indices.push(index_of(vertex, first, vertices, &mut others));
            }
        }
    }
}

/// The vertices of a point beyond those that are compared one by one.
type Others = HashMap<[u32; 13], u32, RandomState>;

/// The index of a vertex among those of its point, of which `first` is the first; it is added unless it is there.
fn index_of(
    vertex: ModelVertex,
    first: usize,
    vertices: &mut Vec<ModelVertex>,
    others: &mut Others,
) -> u32 {
    let of_point = &vertices[first..];
    // As numbers, which makes the two zeros equal; none of them is NaN.
    let is_same = |other: &ModelVertex| {
        (other.normal, other.uv, other.color) == (vertex.normal, vertex.uv, vertex.color)
            && other.tangent == vertex.tangent
    };
    let compared = &of_point[..of_point.len().min(MAX_COMPARED)];
    if let Some(place) = compared.iter().position(is_same) {
        return (first + place) as u32;
    }
    let next = vertices.len() as u32;
    if of_point.len() >= MAX_COMPARED {
        let ModelVertex { normal, uv, color, tangent, .. } = vertex;
        let [nx, ny, nz] = bits(normal);
        let [u, v, hand] = bits(uv.extend(tangent.w));
        let [tx, ty, tz] = bits(tangent.truncate());
        let [r, g, b, a] = color.to_array().map(|channel| (channel + 0.0).to_bits());
        let index = *others.entry([nx, ny, nz, u, v, r, g, b, a, tx, ty, tz, hand]).or_insert(next);
        if index != next {
            return index;
        }
    }
    vertices.push(vertex);
    next
}

/// A key that is equal for equal vectors: adding 0 makes the two zeros one.
fn bits(v: Vec3) -> [u32; 3] {
    (v + 0.0).to_array().map(f32::to_bits)
}
