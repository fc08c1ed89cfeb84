//! How surfaces look: the shaders.

use polyscan::fragment::{FootprintBlock, LANES, Lanes};
use polyscan::glam::{Vec3, Vec4};
use polyscan::model::Material;
use polyscan::{Fragment, FragmentBlock, Texture};

use crate::draw::{BENT, BentSurface, FULL, PLAIN, Scene, Surface};
use crate::view::View;

/// How a surface looks whose vertices carry `N` numbers.
pub(crate) trait Look<const N: usize>: Sync {
    /// Lays the colours of a block over those that are there: linear light, premultiplied by alpha.
    fn shade(&self, block: &mut FragmentBlock<'_, N>, colors: &mut [Vec4; LANES]);

    /// The normal at a fragment, of any length; `None` in a hole.
    fn normal(&self, fragment: &Fragment<'_, N>) -> Option<Vec3>;
}

/// The light from everywhere.
const AMBIENT: f32 = 0.2;

/// Lit alike from both sides, for many files have faces that are turned over.
#[inline(always)]
fn lit([x, y, z]: [&Lanes; 3], lamp: Vec3) -> Lanes {
    let mut light = [0.0; LANES];
    // A loop becomes SIMD instructions, where a closure for each lane would become a function of its own.
    for lane in 0..LANES {
        let (x, y, z) = (x[lane], y[lane], z[lane]);
        let dot = x * lamp.x + y * lamp.y + z * lamp.z;
        let square = x * x + y * y + z * z;
        // Where there is no normal there is no light but that from everywhere.
        let cosine = if square > 0.0 { dot.abs() / square.sqrt() } else { 0.0 };
        light[lane] = AMBIENT + (1.0 - AMBIENT) * cosine;
    }
    light
}

/// The look of models that have no textures, and no colours but their materials'.
pub(crate) struct PlainLook<'a> {
    scene: &'a Scene<'a>,
    lamp: Vec3,
    /// Of each material, the colour that is lit, premultiplied by its alpha.
    colors: Vec<Vec4>,
    /// Of each material, the light that is added.
    emissions: Vec<Vec4>,
}

impl<'a> PlainLook<'a> {
    pub(crate) fn new(scene: &'a Scene<'a>, lamp: Vec3) -> Self {
        let materials = &scene.model.materials;
        let nowhere = Default::default();
        let colors: Vec<_> =
            materials.iter().map(|m| m.color_at(&[], &nowhere, Vec4::ONE)).collect();
        let emissions = materials.iter().zip(&colors);
        let emissions =
            emissions.map(|(m, color)| (m.emission_at(&[], &nowhere) * color.w).extend(0.0));
        let emissions = emissions.collect();
        Self { scene, lamp, colors, emissions }
    }
}

impl Look<PLAIN> for PlainLook<'_> {
    #[inline(always)]
    fn shade(&self, block: &mut FragmentBlock<'_, PLAIN>, colors: &mut [Vec4; LANES]) {
        let material = self.scene.material_number(block.face);
        let (color, emission) = (self.colors[material], self.emissions[material]);
        let [x, y, z] = &block.params;
        let light = lit([x, y, z], self.lamp);
        let behind = 1.0 - color.w;
        if behind <= 0.0 {
            for (pixel, light) in colors.iter_mut().zip(light) {
                *pixel = color * Vec4::new(light, light, light, 1.0) + emission;
            }
            return;
        }
        for (pixel, light) in colors.iter_mut().zip(light) {
            *pixel = color * Vec4::new(light, light, light, 1.0) + emission + *pixel * behind;
        }
    }

    fn normal(&self, fragment: &Fragment<'_, PLAIN>) -> Option<Vec3> {
        let material = self.scene.material_number(fragment.face);
        (self.colors[material].w > 0.0).then(|| Vec3::from_array(fragment.params))
    }
}

/// The look of all other models.
pub(crate) struct FullLook<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) textures: &'a [Texture],
    pub(crate) view: View,
}

impl FullLook<'_> {
    /// Lays colours over those of a block, where the surface has the normals.
    #[inline(always)]
    fn lay<const N: usize>(
        &self,
        block: &mut FragmentBlock<'_, N>,
        (material, seen): (&Material, &FootprintBlock),
        [x, y, z]: [&Lanes; 3],
        colors: &mut [Vec4; LANES],
    ) {
        let [r, g, b, a] = [5, 6, 7, 8].map(|i| &block.params[i]);
        let all = material.colors_at(self.textures, seen, [r, g, b, a], block.visible);
        let lamp = self.view.lamp();
        let mut light = lit([x, y, z], lamp);
        if material.occlusion_texture.is_some() {
            for (lane, light) in light.iter_mut().enumerate() {
                *light -= AMBIENT * (1.0 - material.occlusion_at(self.textures, &seen.get(lane)));
            }
        }
        let has_highlights = material.specular != Vec3::ZERO;
        let halfway = (lamp + self.view.axes.z_axis).normalize_or_zero();
        for (lane, (pixel, color)) in colors.iter_mut().zip(all).enumerate() {
            let mut reflected = color.truncate() * light[lane];
            if material.is_emissive() {
                reflected += material.emission_at(self.textures, &seen.get(lane)) * color.w;
            }
            if has_highlights {
                let normal = Vec3::new(x[lane], y[lane], z[lane]).normalize_or_zero();
                let strength = power(normal.dot(halfway).abs(), material.shininess) * color.w;
                reflected += material.specular_at(self.textures, &seen.get(lane)) * strength;
            }
            *pixel = reflected.extend(color.w) + *pixel * (1.0 - color.w);
        }
    }
}

/// A power to the nearest whole exponent, by multiplications: the same on every machine.
fn power(base: f32, exponent: f32) -> f32 {
    let (mut rest, mut square, mut product) = (exponent.round() as u32, base, 1.0);
    while rest > 0 {
        if rest % 2 == 1 {
            product *= square;
        }
        square *= square;
        rest /= 2;
    }
    product
}

impl Look<FULL> for FullLook<'_> {
    #[inline(always)]
    fn shade(&self, block: &mut FragmentBlock<'_, FULL>, colors: &mut [Vec4; LANES]) {
        let material = self.scene.material(block.face);
        // The order of the surface's numbers.
        let seen = if material.has_textures() { block.footprint(0, 1) } else { Default::default() };
        let [_, _, x, y, z, ..] = block.params;
        self.lay(block, (material, &seen), [&x, &y, &z], colors);
    }

    fn normal(&self, fragment: &Fragment<'_, FULL>) -> Option<Vec3> {
        let Surface { normal, color, .. } = fragment.params.into();
        let material = self.scene.material(fragment.face);
        let color = material.color_at(self.textures, &fragment.footprint(0, 1), color);
        (color.w > 0.0).then_some(normal)
    }
}

/// That of models with normal maps. What is said of normals is said of the surface without them.
impl Look<BENT> for FullLook<'_> {
    #[inline(always)]
    fn shade(&self, block: &mut FragmentBlock<'_, BENT>, colors: &mut [Vec4; LANES]) {
        let material = self.scene.material(block.face);
        // The order of the surface's numbers.
        let seen = if material.has_textures() { block.footprint(0, 1) } else { Default::default() };
        let [_, _, x, y, z, .., tx, ty, tz, tw] = &block.params;
        let tangent = [tx, ty, tz, tw];
        let [x, y, z] =
            material.normals_at(self.textures, &seen, [x, y, z], tangent, block.visible);
        self.lay(block, (material, &seen), [&x, &y, &z], colors);
    }

    fn normal(&self, fragment: &Fragment<'_, BENT>) -> Option<Vec3> {
        let BentSurface { normal, color, .. } = fragment.params.into();
        let material = self.scene.material(fragment.face);
        let color = material.color_at(self.textures, &fragment.footprint(0, 1), color);
        (color.w > 0.0).then_some(normal)
    }
}
