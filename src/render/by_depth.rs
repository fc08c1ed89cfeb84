//! The order of faces by their depths, from back to front.

use glam::DVec4;

use crate::render::faces::FaceList;
use crate::settings::DrawCall;
use crate::vertices::Vertices;
use crate::view_volume::{ClipSpace, MIN_W};

/// The depths of faces in clip space.
pub(crate) struct Depths<'a> {
    /// The z/w of the view volume that is nearest; if it is 1, greater ones are nearer.
    pub(crate) nearest: f64,
    vertices: &'a dyn Vertices,
}

impl<'a> Depths<'a> {
    pub(crate) fn new(call: &DrawCall<'_>, vertices: &'a dyn Vertices) -> Self {
        let [near, far] = call.viewport.depth();
        let is_least = call.depth.is_reversed() == (near > far);
        let nearest = match call.clip_space {
            _ if !is_least => 1.0,
            ClipSpace::ZeroToOne => 0.0,
            ClipSpace::MinusOneToOne => -1.0,
        };
        Self { nearest, vertices }
    }

    /// What grows with a face's distance: the distance of its farthest vertex, and the mean.
    pub(crate) fn key(&self, face: &[u32]) -> [f64; 2] {
        let distance = |&i: &u32| {
            let position =
                self.vertices.get(i).map_or(DVec4::W, |(position, _)| position.as_dvec4());
            let z = if position.w >= MIN_W { position.z / position.w } else { self.nearest };
            let z = z.clamp(-1.0, 1.0);
            if self.nearest > 0.0 { self.nearest - z } else { z - self.nearest }
        };
        let [farthest, sum] = face.iter().map(distance).fold([0.0, 0.0], |[farthest, sum], d| {
            [if d > farthest { d } else { farthest }, sum + d]
        });
        [farthest, sum / face.len().max(1) as f64]
    }
}

/// Items by their keys, the greatest first, of equals the last first.
pub(crate) fn sorted<T: Copy>(keys: &mut [([f64; 2], T)]) -> impl Iterator<Item = T> {
    keys.sort_by(|([a, b], _), ([c, d], _)| a.total_cmp(c).then(b.total_cmp(d)));
    keys.iter().rev().map(|(_, item)| *item)
}

/// Replaces `sorted_faces` by faces in the order of their depths.
pub(crate) fn sort_by_depth(
    call: &DrawCall<'_>,
    vertices: &dyn Vertices,
    faces: &FaceList,
    sorted_faces: &mut FaceList,
) {
    let depths = Depths::new(call, vertices);
    let mut keys: Vec<_> =
        (0..faces.len()).map(|face| (depths.key(faces.get(face)), face as u32)).collect();
    sorted_faces.take_in_order(faces, sorted(&mut keys));
}
