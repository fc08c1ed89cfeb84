//! For each corner whether the picture lies on its face as it is, or as in a mirror.

use glam::{Vec2, Vec3};

use crate::model::corners::Corners;
use crate::model::faces::range_before;
use crate::tangent::{PictureAxes, TangentVertex};

/// How the picture lies on the faces of a model that needs tangents.
pub(super) struct Hands {
    /// For each face, unless its part of the picture has no area.
    axes: Vec<Option<PictureAxes>>,
    /// For each corner its face.
    face: Vec<u32>,
}

impl Hands {
    pub(super) fn of(corners: &Corners) -> Self {
        let mut hands = Self { axes: Vec::new(), face: Vec::with_capacity(corners.point.len()) };
        let mut vertices = Vec::new();
        for face in 0..corners.ends.len() {
            let places = range_before(&corners.ends, face);
            hands.face.resize(places.end, face as u32);
            vertices.clear();
            vertices.extend(places.map(|corner| TangentVertex {
                position: corners.points[corners.point[corner] as usize],
                normal: Vec3::ZERO,
                // A difference of NaN has no area.
                uv: corners.uv.get(corner).map_or(Vec2::NAN, |uv| Vec2::new(uv.x, 1.0 - uv.y)),
            }));
            hands.axes.push(PictureAxes::of(&vertices));
        }
        hands
    }

    /// 1 for a corner with this normal, or -1 where the picture is mirrored.
    pub(super) fn sign(&self, corner: u32, normal: Vec3) -> f32 {
        let axes = &self.axes[self.face[corner as usize] as usize];
        let is_mirrored = axes.as_ref().is_some_and(|axes| axes.is_mirrored(normal.as_dvec3()));
        if is_mirrored { -1.0 } else { 1.0 }
    }
}
