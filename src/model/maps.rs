//! What the pictures of a material say besides its colour: normals, highlights, light that is kept off, heights.

use glam::{Vec2, Vec3, Vec4};

use crate::fragment::{Footprint, FootprintBlock, LANES, Lanes};
use crate::model::material::{Material, TextureMapping, sampled, sampled_at};
use crate::tangent::TangentFrame;
use crate::texture::{Filter, Texture};

impl Material {
    /// Whether any picture belongs to the material, so that [footprints](crate::Fragment::footprint) are
    /// needed.
    #[must_use]
    pub fn has_textures(&self) -> bool {
        let colors = [self.texture, self.alpha_texture, self.emission_texture];
        let others = [self.normal_texture, self.specular_texture, self.occlusion_texture];
        colors.iter().chain(&others).any(Option::is_some) || self.displacement_texture.is_some()
    }

    /// The normal of a face at a point, of length 1: that of the frame, bent by the material's normal map.
    ///
    /// `textures` and `seen` are those of [`color_at`](Self::color_at); the frame has the normals and the
    /// [tangents](crate::model::ModelVertex::tangent) of the vertices, interpolated.
    #[inline]
    #[must_use]
    pub fn normal_at(&self, textures: &[Texture], seen: &Footprint, frame: &TangentFrame) -> Vec3 {
        match sampled_at(textures, self.normal_texture, &self.normal_mapping, seen) {
            Some(texel) => self.bent(frame, texel),
            None => frame.normal.normalize_or_zero(),
        }
    }

    /// The normals at the pixels of a block, x, y and z, as [`normal_at`](Self::normal_at) has them one by
    /// one, to the bit. Those of lanes that have no bit in `mask` mean nothing.
    #[inline]
    #[must_use]
    pub fn normals_at(
        &self,
        textures: &[Texture],
        seen: &FootprintBlock,
        normal: [&Lanes; 3],
        tangent: [&Lanes; 4],
        mask: u32,
    ) -> [Lanes; 3] {
        let texels = sampled(textures, self.normal_texture, &self.normal_mapping, seen, mask);
        let mut normals = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let frame = TangentFrame {
                normal: Vec3::from_array(normal.map(|axis| axis[lane])),
                tangent: Vec4::from_array(tangent.map(|axis| axis[lane])),
            };
            let bent = match &texels {
                Some(texels) => self.bent(&frame, texels[lane]),
                None => frame.normal.normalize_or_zero(),
            };
            for (axis, value) in normals.iter_mut().zip(bent.to_array()) {
                axis[lane] = value;
            }
        }
        normals
    }

    /// The normal that a texel of the normal map stands for.
    #[inline(always)]
    fn bent(&self, frame: &TangentFrame, texel: Vec4) -> Vec3 {
        let [x, y, z] = (texel.truncate() * 2.0 - 1.0).to_array();
        let along = self.normal_mapping.direction(Vec2::new(x, y)) * self.normal_strength;
        frame.direction([along.x, along.y, z])
    }

    /// The colour of highlights at a point, in linear light.
    /// `textures` and `seen` are those of [`color_at`](Self::color_at).
    #[inline]
    #[must_use]
    pub fn specular_at(&self, textures: &[Texture], seen: &Footprint) -> Vec3 {
        let texel = sampled_at(textures, self.specular_texture, &self.specular_mapping, seen);
        texel.map_or(self.specular, |texel| self.specular * texel.truncate())
    }

    /// How much of the light from everywhere comes to a point, from 0 to 1: ambient light is to be multiplied by
    /// it, that of a lamp not. `textures` and `seen` are those of [`color_at`](Self::color_at).
    #[inline]
    #[must_use]
    pub fn occlusion_at(&self, textures: &[Texture], seen: &Footprint) -> f32 {
        let texel = sampled_at(textures, self.occlusion_texture, &self.occlusion_mapping, seen);
        texel.map_or(1.0, |texel| 1.0 + self.occlusion_strength * (texel.x - 1.0))
    }

    /// How far the surface is to be moved along its normal at a point, in the model's units.
    /// `textures` and `seen` are those of [`color_at`](Self::color_at).
    #[inline]
    #[must_use]
    pub fn displacement_at(&self, textures: &[Texture], seen: &Footprint) -> f32 {
        let mapping = &self.displacement_mapping;
        let texture = self.displacement_texture.and_then(|index| textures.get(index));
        texture.map_or(0.0, |texture| {
            // A height that is 0 is no clear black: the base is added all the same.
            let texel = texture.sample_footprint(&mapping.footprint(seen));
            texel.x * mapping.gain + mapping.base
        })
    }
}

impl Material {
    /// The heights at the points of a block, as [`displacement_at`](Self::displacement_at) has them one by one, to the
    /// bit. What is not finite is 0.
    pub(super) fn displacements_at(
        &self,
        textures: &[Texture],
        seen: &FootprintBlock,
        mask: u32,
    ) -> Lanes {
        let mapping = &self.displacement_mapping;
        let texture = self.displacement_texture.and_then(|index| textures.get(index));
        texture.map_or([0.0; LANES], |texture| {
            let texels = texture.sample_footprint_block(&mapping.footprint_block(seen), mask);
            texels.map(|texel| {
                let height = texel.x * mapping.gain + mapping.base;
                if height.is_finite() { height } else { 0.0 }
            })
        })
    }

    /// How far the material's displacement map moves a surface at the most: zero if there is none.
    pub(super) fn most_displacement(&self, textures: &[Texture]) -> f32 {
        let Some(texture) = self.displacement_texture.and_then(|index| textures.get(index)) else {
            return 0.0;
        };
        let TextureMapping { gain, base, .. } = self.displacement_mapping;
        let amounts = texture.texels().map(|texel| (texel.x * gain + base).abs());
        let most = amounts.filter(|amount| amount.is_finite()).fold(0.0, f32::max);
        // Cubic filters go beyond what they filter.
        if matches!(texture.filter(), Filter::Bicubic(_)) { 1.5 * most } else { most }
    }
}

impl TextureMapping {
    /// A direction in the picture, x to the right and y up, as a direction along the axes of the vertices'
    /// texture coordinates: turned back. Scales are passed over, for a normal map that is repeated
    /// bends normals as before, but for their signs.
    #[inline(always)]
    fn direction(&self, Vec2 { x, y }: Vec2) -> Vec2 {
        let Self { scale, turn: Vec2 { x: cosine, y: sine }, .. } = *self;
        let sign = |scale: f32| if scale < 0.0 { -1.0 } else { 1.0 };
        Vec2::new((x * cosine + y * sine) * sign(scale.x), (y * cosine - x * sine) * sign(scale.y))
    }
}
