//! How the faces of a model look.

use glam::{Vec2, Vec3, Vec4};

use crate::fragment::{Footprint, FootprintBlock, LANES, Lanes};
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
    /// Light that the face sends out by itself: red, green and blue, linear, mostly zero.
    pub emission: Vec3,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture that multiplies `emission`, if
    /// there is one.
    pub emission_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub emission_mapping: TextureMapping,
    /// Index into [`Model::textures`](crate::Model::textures) of the normal map, if there is one: numbers from 0
    /// to 1 that stand for x, y UP in the picture, and z out of the surface, from -1 to 1.
    pub normal_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub normal_mapping: TextureMapping,
    /// What multiplies x and y of its normals, mostly 1.
    pub normal_strength: f32,
    /// The colour of highlights in linear light; zero for none.
    pub specular: Vec3,
    /// How sharp highlights are: the exponent of the cosine between the normal and the direction halfway
    /// from the lamp to the eye (Blinn, "Models of Light Reflection", SIGGRAPH 1977).
    pub shininess: f32,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture that multiplies `specular`, if
    /// there is one.
    pub specular_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub specular_mapping: TextureMapping,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture whose red channel multiplies light
    /// from everywhere, if there is one.
    pub occlusion_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub occlusion_mapping: TextureMapping,
    /// How much of that counts, from 0 to 1.
    pub occlusion_strength: f32,
    /// Index into [`Model::textures`](crate::Model::textures) of the picture whose red channel, after gain and
    /// base of its mapping, is a height over the faces in the model's units, if there is one.
    pub displacement_texture: Option<usize>,
    /// How that picture lies on the faces.
    pub displacement_mapping: TextureMapping,
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
    /// How scaled coordinates are turned counter-clockwise, u to the right and v UP: the cosine and the
    /// sine of the angle. The picture is seen turned the other way.
    pub turn: Vec2,
    /// What is added to scaled and turned coordinates, u to the right and v UP.
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
        let (scale, turn, offset) = (Vec2::ONE, Vec2::X, Vec2::ZERO);
        Self { scale, turn, offset, clamp: false, base: 0.0, gain: 1.0 }
    }
}

impl TextureMapping {
    /// The coordinate in the picture, with v down, for a vertex's.
    #[inline]
    #[must_use]
    pub fn uv(&self, uv: Vec2) -> Vec2 {
        let (x, y, at_zero) = self.columns();
        x * uv.x + y * uv.y + at_zero
    }

    /// The mapping of coordinates with v down: its two columns, and what zero is mapped to.
    #[inline]
    fn columns(&self) -> (Vec2, Vec2, Vec2) {
        let Self { scale, turn: Vec2 { x: cosine, y: sine }, offset, .. } = *self;
        // Of coordinates with v up: (u, 1 - v) is scaled, turned and moved, and v taken from 1 again.
        let x = Vec2::new(cosine, -sine) * scale.x;
        let y = Vec2::new(sine, cosine) * scale.y;
        (x, y, Vec2::new(offset.x, 1.0 - offset.y) - y)
    }

    /// What is seen of the picture, with v down, where so much is seen of a vertex's coordinates.
    #[inline]
    pub(super) fn footprint(&self, seen: &Footprint) -> Footprint {
        let (x, y, at_zero) = self.columns();
        let along = |d: Vec2| x * d.x + y * d.y;
        Footprint { uv: along(seen.uv) + at_zero, dx: along(seen.dx), dy: along(seen.dy) }
    }

    /// The same for a block.
    #[inline(always)]
    pub(super) fn footprint_block(&self, seen: &FootprintBlock) -> FootprintBlock {
        let (x, y, at_zero) = self.columns();
        let along = |[u, v]: &[Lanes; 2], at: Vec2| {
            let sum = |x: f32, y: f32, at: f32| {
                std::array::from_fn(|lane| x * u[lane] + y * v[lane] + at)
            };
            [sum(x.x, y.x, at.x), sum(x.y, y.y, at.y)]
        };
        let (dx, dy) = (along(&seen.dx, Vec2::ZERO), along(&seen.dy, Vec2::ZERO));
        FootprintBlock { uv: along(&seen.uv, at_zero), dx, dy }
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
            emission: Vec3::ZERO,
            emission_texture: None,
            emission_mapping: TextureMapping::default(),
            normal_texture: None,
            normal_mapping: TextureMapping::default(),
            normal_strength: 1.0,
            specular: Vec3::ZERO,
            shininess: 32.0,
            specular_texture: None,
            specular_mapping: TextureMapping::default(),
            occlusion_texture: None,
            occlusion_mapping: TextureMapping::default(),
            occlusion_strength: 1.0,
            displacement_texture: None,
            displacement_mapping: TextureMapping::default(),
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
            sampled_at(textures, texture, mapping, seen)
        };
        let mut all = self.plain_color(color);
        if let Some(texel) = sample(self.texture, &self.mapping) {
            all *= texel;
        }
        if self.is_opaque(all) {
            return all;
        }
        all *= self.alpha;
        if let Some(texel) = sample(self.alpha_texture, &self.alpha_mapping) {
            all *= texel.x;
        }
        self.with_alpha(all)
    }

    /// The colours at the pixels of a block, as [`color_at`](Self::color_at) has them one by one, to the bit.
    /// Those of lanes that have no bit in `mask` mean nothing.
    ///
    /// `color` has red, green, blue and alpha of the vertices' colours, interpolated.
    #[inline]
    #[must_use]
    pub fn colors_at(
        &self,
        textures: &[Texture],
        seen: &FootprintBlock,
        color: [&Lanes; 4],
        mask: u32,
    ) -> [Vec4; LANES] {
        let [r, g, b, a] = color;
        let mut all = std::array::from_fn(|lane| {
            self.plain_color(Vec4::new(r[lane], g[lane], b[lane], a[lane]))
        });
        if let Some(texels) = sampled(textures, self.texture, &self.mapping, seen, mask) {
            for (color, texel) in all.iter_mut().zip(texels) {
                *color *= texel;
            }
        }
        let opaque = all.map(|color| self.is_opaque(color));
        if opaque == [true; LANES] {
            return all;
        }
        let alphas = sampled(textures, self.alpha_texture, &self.alpha_mapping, seen, mask);
        for (lane, color) in all.iter_mut().enumerate() {
            if !opaque[lane] {
                let product = *color * self.alpha;
                let product = alphas.as_ref().map_or(product, |texels| product * texels[lane].x);
                *color = self.with_alpha(product);
            }
        }
        all
    }

    /// Whether faces send out light by themselves.
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        self.emission != Vec3::ZERO
    }

    /// The light that a face sends out by itself at a point, to be added to what it reflects: linear.
    /// `textures` and `seen` are those of [`color_at`](Self::color_at).
    #[inline]
    #[must_use]
    pub fn emission_at(&self, textures: &[Texture], seen: &Footprint) -> Vec3 {
        let texel = sampled_at(textures, self.emission_texture, &self.emission_mapping, seen);
        texel.map_or(self.emission, |texel| self.emission * texel.truncate())
    }

    /// The colour of the vertices under that of the material.
    #[inline]
    fn plain_color(&self, color: Vec4) -> Vec4 {
        color.truncate().extend(1.0) * color.w * self.diffuse.extend(1.0)
    }

    /// Whether a colour stays as it is, before its alpha is looked at.
    #[inline]
    fn is_opaque(&self, color: Vec4) -> bool {
        self.alpha_mode == AlphaMode::Opaque && color.w == 1.0
    }

    /// A colour after what its alpha means.
    #[inline]
    fn with_alpha(&self, color: Vec4) -> Vec4 {
        match self.alpha_mode {
            AlphaMode::Blend => color,
            AlphaMode::Cutout { threshold } if color.w < threshold || color.w <= 0.0 => Vec4::ZERO,
            // What is left is opaque, in the colour that it has before alpha.
            _ if color.w > 0.0 => (color.truncate() / color.w).extend(1.0),
            _ => Vec3::ZERO.extend(1.0),
        }
    }
}

/// The colour of a picture at a point, if there is a picture.
#[inline]
pub(super) fn sampled_at(
    textures: &[Texture],
    texture: Option<usize>,
    mapping: &TextureMapping,
    seen: &Footprint,
) -> Option<Vec4> {
    let texture = texture.and_then(|index| textures.get(index))?;
    Some(mapping.changed(texture.sample_footprint(&mapping.footprint(seen))))
}

/// The colours of a picture at the pixels of a block, if there is a picture.
#[inline]
pub(super) fn sampled(
    textures: &[Texture],
    texture: Option<usize>,
    mapping: &TextureMapping,
    seen: &FootprintBlock,
    mask: u32,
) -> Option<[Vec4; LANES]> {
    let texture = texture.and_then(|index| textures.get(index))?;
    let texels = texture.sample_footprint_block(&mapping.footprint_block(seen), mask);
    Some(texels.map(|texel| mapping.changed(texel)))
}
