//! The vertices of a model.

use glam::{Vec2, Vec3, Vec4};

/// A vertex of a model, which the corners of several faces may share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelVertex {
    /// Position in object space, in the units of the file, relative to
    /// [`Model::origin`](crate::Model::origin).
    pub position: Vec3,
    /// Normal in object space, of length 1.
    pub normal: Vec3,
    /// Texture coordinate with u to the right and v DOWN, as a [`Texture`](crate::Texture) has it:
    /// (0, 0) is the top left corner of the picture, (1, 1) the bottom right one. It is (0, 0) where
    /// the file gives none.
    pub uv: Vec2,
    /// Colour that multiplies that of the material: linear light, not multiplied by the alpha in `w`.
    /// It is white where the file gives none.
    pub color: Vec4,
    /// Where u grows, across the normal, of length 1, and in `w` whether the picture lies on the faces as it is
    /// (1) or as in a mirror (-1): for a [`TangentFrame`](crate::tangent::TangentFrame). It is that of the file where
    /// that has one, as a glTF file may, and else [computed](crate::tangent::tangents). It is zero unless one of the
    /// model's materials has a normal map.
    pub tangent: Vec4,
}

impl Default for ModelVertex {
    /// White, at the origin, without a normal.
    fn default() -> Self {
        let (position, normal, uv) = (Vec3::ZERO, Vec3::ZERO, Vec2::ZERO);
        Self { position, normal, uv, color: Vec4::ONE, tangent: Vec4::ZERO }
    }
}
