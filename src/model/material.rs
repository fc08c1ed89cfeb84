//! How the faces of a model look.

use glam::{Vec2, Vec3, Vec4};

use crate::fragment::Footprint;
use crate::texture::Texture;

/// How a face looks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// The name in the file that defines it; "default" for the default material. Bytes of a name in an
    /// encoding that is not known are U+F780 to U+F7FF.
    pub name: String,
    /// Diffuse reflectance of red, green and blue in linear light, from 0 to 1 in real materials. At 1
    /// all light is reflected.
    pub diffuse: Vec3,
    /// How much of what is behind is hidden, from 0 (nothing) to 1 (all).
    pub alpha: f32,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture that multiplies
    /// `diffuse`, and `alpha` by its own, if there is one.
    pub texture: Option<usize>,
    /// How that picture lies on the faces.
    pub mapping: TextureMapping,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture whose red channel multiplies
    /// `alpha`, if there is one.
    pub alpha_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub alpha_mapping: TextureMapping,
    /// What is to be done with alpha.
    pub alpha_mode: AlphaMode,
}

/// What the alpha of a material means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum AlphaMode {
    /// Everything is opaque.
    #[default]
    Opaque,
    /// Where alpha is below the threshold there is a hole, elsewhere the face is opaque: leaves, fences.
    Cutout {
        /// From 0 to 1.
        threshold: f32,
    },
    /// Faces cover what is behind them by their alpha: glass.
    Blend,
}

/// How a picture lies on faces, and how its colours change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TextureMapping {
    /// How often the picture is repeated along u and v where texture coordinates go from 0 to 1.
    pub scale: Vec2,
    /// What is added to scaled coordinates, u to the right and v UP.
    pub offset: Vec2,
    /// Whether the picture's edge goes on beyond it, instead of the picture being repeated. The texture
    /// of a loaded model wraps so already.
    pub clamp: bool,
    /// What is added to colours, after the gain; in linear light.
    pub base: f32,
    /// What multiplies colours.
    pub gain: f32,
}

impl Default for TextureMapping {
    /// The picture once, as it is.
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO, clamp: false, base: 0.0, gain: 1.0 }
    }
}

impl TextureMapping {
    /// The coordinate in the picture, with v down, for a vertex's.
    #[inline]
    #[must_use]
    pub fn uv(&self, uv: Vec2) -> Vec2 {
        // Of coordinates with v up: 1 - ((1 - v) scale + offset).
        let down = Vec2::new(self.offset.x, 1.0 - self.scale.y - self.offset.y);
        uv * self.scale + down
    }

    /// What is seen of the picture, with v down, where so much is seen of a vertex's coordinates.
    #[inline]
    fn footprint(&self, seen: &Footprint) -> Footprint {
        Footprint { uv: self.uv(seen.uv), dx: seen.dx * self.scale, dy: seen.dy * self.scale }
    }

    /// A colour of the picture, premultiplied by alpha, after gain and base.
    #[inline]
    fn changed(&self, color: Vec4) -> Vec4 {
        (color.truncate() * self.gain + self.base * color.w).extend(color.w)
    }
}

impl Default for Material {
    /// The material of faces that name none: 0.8 grey, no texture.
    fn default() -> Self {
        Self::new("default", Vec3::splat(0.8))
    }
}

impl Material {
    /// An opaque material without a texture; `diffuse` is its reflectance in linear light.
    #[must_use]
    pub fn new(name: impl Into<String>, diffuse: Vec3) -> Self {
        Self {
            name: name.into(),
            diffuse,
            alpha: 1.0,
            texture: None,
            mapping: TextureMapping::default(),
            alpha_texture: None,
            alpha_mapping: TextureMapping::default(),
            alpha_mode: AlphaMode::Opaque,
        }
    }

    /// Whether what is behind a face may be seen. Such faces are to be drawn as transparent
    /// ([`Mesh::with_transparent`](crate::Mesh::with_transparent)), cut-outs among them.
    #[must_use]
    pub fn is_transparent(&self) -> bool {
        self.alpha_mode != AlphaMode::Opaque
    }

    /// The colour of a face at a point: linear light, premultiplied by alpha, as
    /// [`Over`](crate::render::Over) takes it once its light is multiplied.
    ///
    /// `textures` are those of the model; `seen` is the fragment's
    /// [footprint](crate::Fragment::footprint) in texture coordinates, `color` the colour of the vertices,
    /// interpolated. Where a cut-out has a hole, the colour is zero.
    #[inline]
    #[must_use]
    pub fn color_at(&self, textures: &[Texture], seen: &Footprint, color: Vec4) -> Vec4 {
        let sample = |texture: Option<usize>, mapping: &TextureMapping| {
            let texture = texture.and_then(|index| textures.get(index));
            texture.map(|t| mapping.changed(t.sample_footprint(&mapping.footprint(seen))))
        };
        let mut all = color.truncate().extend(1.0) * color.w * self.diffuse.extend(1.0);
        if let Some(texel) = sample(self.texture, &self.mapping) {
            all *= texel;
        }
        if self.alpha_mode == AlphaMode::Opaque && all.w == 1.0 {
            return all;
        }
        all *= self.alpha;
        if let Some(texel) = sample(self.alpha_texture, &self.alpha_mapping) {
            all *= texel.x;
        }
        match self.alpha_mode {
            AlphaMode::Blend => all,
            AlphaMode::Cutout { threshold } if all.w < threshold || all.w <= 0.0 => Vec4::ZERO,
            // What is left is opaque, in the colour that it has before alpha.
            _ if all.w > 0.0 => (all.truncate() / all.w).extend(1.0),
            _ => Vec3::ZERO.extend(1.0),
        }
    }
}
