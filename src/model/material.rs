//! How the faces of a model look.

use glam::Vec3;

/// How a face looks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// The name in the file that defines it; "default" for the default material.
    pub name: String,
    /// Diffuse reflectance of red, green and blue in linear light, from 0 to 1 in real materials. At 1
    /// all light is reflected.
    pub diffuse: Vec3,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture that multiplies
    /// `diffuse`, if there is one.
    pub texture: Option<usize>,
}

impl Default for Material {
    /// The material of faces that name none: 0.8 grey, no texture.
    fn default() -> Self {
        Self::new("default", Vec3::splat(0.8))
    }
}

impl Material {
    /// A material without a texture; `diffuse` is its reflectance in linear light.
    #[must_use]
    pub fn new(name: impl Into<String>, diffuse: Vec3) -> Self {
        Self { name: name.into(), diffuse, texture: None }
    }
}
