//! What the examples that show a model share: its options, a light, and its colours.

use std::error::Error;
use std::path::{Path, PathBuf};

use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec3};
use polyscan::model::Model;
use polyscan::obj::Loader;
use polyscan::render::Over;
use polyscan::tangent::TangentFrame;
use polyscan::texture::MipFilter;
use polyscan::{Camera, Fragment, Vertex, record};

use crate::cli;

/// A model, and from where it is seen.
#[derive(Clone)]
pub(crate) struct View {
    pub(crate) model: PathBuf,
    /// Turn of the camera around the model, in degrees, to the right.
    pub(crate) yaw: f32,
    /// Height of the camera over the model's level, in degrees.
    pub(crate) pitch: f32,
    /// The direction in the model that is up.
    pub(crate) up: Vec3,
}

impl Default for View {
    fn default() -> Self {
        Self { model: "examples/assets/cottage.obj".into(), yaw: 30.0, pitch: 20.0, up: Vec3::Y }
    }
}

impl View {
    /// A camera around the model turned as the options say.
    pub(crate) fn turned(&self, camera: Camera) -> Camera {
        camera.with_up(self.up).turned(self.yaw.to_radians(), self.pitch.to_radians())
    }
}

/// A number that is one.
pub(crate) fn parse_degrees(text: &str) -> Result<f32, &'static str> {
    let degrees = text.parse().ok().filter(|degrees: &f32| degrees.is_finite());
    degrees.ok_or("give a number of degrees, such as 30 or -12.5")
}

/// A direction along an axis, such as z or -y.
pub(crate) fn parse_up(text: &str) -> Result<Vec3, &'static str> {
    let (sign, axis) = text.strip_prefix('-').map_or((1.0, text), |axis| (-1.0, axis));
    match axis.to_ascii_lowercase().as_str() {
        "x" => Ok(Vec3::X * sign),
        "y" => Ok(Vec3::Y * sign),
        "z" => Ok(Vec3::Z * sign),
        _ => Err("name an axis: x, y, z, -x, -y or -z"),
    }
}

/// Width and height, such as 800x600, of at most `most` pixels each.
pub(crate) fn parse_size(text: &str, most: u32) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').ok_or("write it as 800x600")?;
    Ok((cli::number(width, 1..=most)?, cli::number(height, 1..=most)?))
}

/// Loads a model, whose textures are to be filtered; what is strange about it goes to the standard error.
pub(crate) fn load(loader: &Loader, path: &Path) -> Result<Model, Box<dyn Error>> {
    let loaded = loader.load(path)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(loaded.model.with_mip_filter(MipFilter::Anisotropic { probes: 16 })?)
}

record! {
    /// What goes from the vertices to the pixels.
    pub(crate) struct Surface {
        pub(crate) uv: Vec2,
        pub(crate) normal: Vec3,
        pub(crate) color: Vec4,
        /// Where u grows, or zero where nothing has a normal map.
        pub(crate) tangent: Vec4,
    }
}

/// The model's vertices in clip space.
pub(crate) fn vertices(model: &Model, clip_from_object: Mat4) -> Vec<Vertex<{ Surface::LEN }>> {
    model.vertices_with(clip_from_object, |v| Surface {
        uv: v.uv,
        normal: v.normal,
        color: v.color,
        tangent: v.tangent,
    })
}

/// A lamp beside the camera, above its right shoulder.
pub(crate) struct Lamp {
    direction: Vec3,
    /// Between the lamp and the eye, which is taken for far away.
    halfway: Vec3,
}

impl Lamp {
    pub(crate) fn beside(camera: &Camera) -> Self {
        let axes = camera.axes();
        let direction = (axes * vec3(0.6, 0.7, 1.0)).normalize();
        Self { direction, halfway: (direction + axes.z_axis).normalize() }
    }

    /// How much light a surface with this normal sends back, where so much of the light from everywhere
    /// reaches it: alike from both sides, for many files have faces that are turned over.
    pub(crate) fn lit(&self, normal: Vec3, occlusion: f32) -> f32 {
        0.15 * occlusion + 0.85 * normal.dot(self.direction).abs()
    }

    /// How bright a highlight is, by Blinn's exponent.
    pub(crate) fn highlight(&self, normal: Vec3, shininess: f32) -> f32 {
        normal.dot(self.halfway).abs().powf(shininess)
    }
}

/// The colour of a fragment of a material under a lamp: linear light, premultiplied by alpha.
pub(crate) fn shade(
    model: &Model,
    material: usize,
    fragment: &Fragment<'_, { Surface::LEN }>,
    lamp: &Lamp,
) -> Over {
    let Surface { normal, color, tangent, .. } = fragment.params.into();
    // The texture coordinates are the first two of the surface's values.
    let seen = fragment.footprint(0, 1);
    let color = model.color_at(material, &seen, color);
    let (material, textures) = (&model.materials[material], &model.textures);
    let normal = material.normal_at(textures, &seen, &TangentFrame::new(normal, tangent));
    let mut light = color.truncate() * lamp.lit(normal, material.occlusion_at(textures, &seen));
    if material.specular != Vec3::ZERO {
        let highlight = lamp.highlight(normal, material.shininess) * color.w;
        light += material.specular_at(textures, &seen) * highlight;
    }
    Over(light.extend(color.w))
}
