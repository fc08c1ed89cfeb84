//! The order of faces by their depths, from back to front.

use glam::{DMat4, DVec4};

use crate::render::faces::FaceList;
use crate::settings::{DepthMode, DrawCall};
use crate::vertices::Vertices;
use crate::view_volume::{ClipSpace, MIN_W};

/// The depths of faces in clip space.
pub(crate) struct Depths<'a> {
    measure: Measure,
    vertices: &'a dyn Vertices,
}

/// What a vertex's distance is.
#[derive(Clone, Copy)]
enum Measure {
    /// How far z/w is from the nearest that the view volume has.
    FromNearest(f64),
    /// The w of clip space.
    W,
}

/// The z/w of the view volume that is nearest; if it is 1, greater ones are nearer.
fn nearest(call: &DrawCall<'_>) -> f64 {
    let [near, far] = call.viewport.depth();
    let is_least = call.depth.is_reversed() == (near > far);
    match call.clip_space {
        _ if !is_least => 1.0,
        ClipSpace::ZeroToOne => 0.0,
        ClipSpace::MinusOneToOne => -1.0,
    }
}

/// Whether greater z/w is farther, where planes of object space are brought to clip space by `planes`,
/// the transpose of an inverse matrix M^-1.
///
/// With [`DepthMode::InverseW`] the matrix says it: 1/w of a visible point is its (X, Y, d, 1) times the
/// last row of M^-1, since the last coordinate in object space is 1.
pub(crate) fn is_greater_farther(call: &DrawCall<'_>, planes: &DMat4) -> bool {
    let change_of_inv_w = planes.w_axis.z;
    if call.depth == DepthMode::InverseW && change_of_inv_w != 0.0 {
        return change_of_inv_w < 0.0;
    }
    nearest(call) <= 0.0
}

impl<'a> Depths<'a> {
    pub(crate) fn new(call: &DrawCall<'_>, vertices: &'a dyn Vertices) -> Self {
        let measure = match call.depth {
            DepthMode::InverseW => Measure::W,
            _ => Measure::FromNearest(nearest(call)),
        };
        Self { measure, vertices }
    }

    /// What grows with a face's distance: the distance of its farthest vertex, and the mean.
    pub(crate) fn key(&self, face: &[u32]) -> [f64; 2] {
        let distance = |&i: &u32| {
            let position =
                self.vertices.get(i).map_or(DVec4::W, |(position, _)| position.as_dvec4());
            match self.measure {
                Measure::W => position.w,
                Measure::FromNearest(nearest) if position.w >= MIN_W => {
                    let z = (position.z / position.w).clamp(-1.0, 1.0);
                    if nearest > 0.0 { nearest - z } else { z - nearest }
                }
                // At the eye, and behind it, z/w says nothing.
                Measure::FromNearest(_) => 0.0,
            }
        };
        let [farthest, sum] = face.iter().map(distance).fold([0.0, 0.0], |[farthest, sum], d| {
            [if d > farthest { d } else { farthest }, sum + d]
        });
        [farthest, sum / face.len().max(1) as f64]
    }
}

/// Items by their keys, the greatest first, of equals the last first.
pub(crate) fn sorted<T: Copy + Ord>(keys: &mut [([f64; 2], T)]) -> impl Iterator<Item = T> {
    keys.sort_unstable_by(|([a, b], item), ([c, d], other)| {
        a.total_cmp(c).then(b.total_cmp(d)).then(item.cmp(other))
    });
    keys.iter().rev().map(|(_, item)| *item)
}

/// Faces in the order of their depths, with the memory that sorting takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct SortedFaces {
    keys: Vec<([f64; 2], u32)>,
    faces: FaceList,
}

impl SortedFaces {
    /// Sorts faces.
    pub(crate) fn sort(
        &mut self,
        call: &DrawCall<'_>,
        vertices: &dyn Vertices,
        faces: &FaceList,
    ) -> &FaceList {
        let depths = Depths::new(call, vertices);
        self.keys.clear();
        let keys = (0..faces.len()).map(|face| (depths.key(faces.get(face)), face as u32));
        self.keys.extend(keys);
        self.faces.take_in_order(faces, sorted(&mut self.keys));
        &self.faces
    }
}
