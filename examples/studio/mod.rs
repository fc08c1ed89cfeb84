//! What the examples that show a model share: its options, a light, and its colours.

use std::error::Error;
use std::path::{Path, PathBuf};

use polyscan::glam::{Mat4, Vec2, Vec3, vec3};
use polyscan::model::{Material, Model};
use polyscan::obj::Loader;
use polyscan::texture::MipFilter;
use polyscan::{Camera, Footprint, Fragment, Vertex, record};

use crate::cli;

/// A model, and from where it is seen.
#[derive(Clone)]
pub(crate) struct View {
    pub(crate) model: PathBuf,
    /// Turn of the camera around the model, in degrees, to the right.
    pub(crate) yaw: f32,
    /// Height of the camera over the model's level, in degrees.
    pub(crate) pitch: f32,
}

impl Default for View {
    fn default() -> Self {
        Self { model: "examples/assets/cottage.obj".into(), yaw: 30.0, pitch: 20.0 }
    }
}

impl View {
    /// A camera around the model turned as the options say.
    pub(crate) fn turned(&self, camera: Camera) -> Camera {
        camera.turned(self.yaw.to_radians(), self.pitch.to_radians())
    }
}

/// A number that is one.
pub(crate) fn parse_degrees(text: &str) -> Result<f32, &'static str> {
    let degrees = text.parse().ok().filter(|degrees: &f32| degrees.is_finite());
    degrees.ok_or("give a number of degrees, such as 30 or -12.5")
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
    let mut model = loaded.model;
    for texture in std::mem::take(&mut model.textures) {
        let texture = texture.with_mipmaps()?;
        model.textures.push(texture.with_mip_filter(MipFilter::Anisotropic { probes: 16 }));
    }
    Ok(model)
}

record! {
    /// What goes from the vertices to the pixels.
    pub(crate) struct Surface {
        pub(crate) uv: Vec2,
        pub(crate) normal: Vec3,
    }
}

/// The model's vertices in clip space.
pub(crate) fn vertices(model: &Model, clip_from_object: Mat4) -> Vec<Vertex<{ Surface::LEN }>> {
    model.vertices_with(clip_from_object, |v| Surface { uv: v.uv, normal: v.normal })
}

/// A lamp beside the camera, above its right shoulder.
pub(crate) struct Lamp {
    direction: Vec3,
}

impl Lamp {
    pub(crate) fn beside(camera: &Camera) -> Self {
        Self { direction: (camera.axes() * vec3(0.6, 0.7, 1.0)).normalize() }
    }

    /// How much light a surface sends back. One seen from behind is lit from behind.
    pub(crate) fn lit(&self, surface: &Surface) -> f32 {
        let facing = surface.normal.normalize_or_zero().dot(self.direction);
        0.15 + 0.85 * if facing < 0.0 { -0.4 * facing } else { facing }
    }
}

/// The texture coordinate of a pixel whose parameters are a [`Surface`], and how it changes.
pub(crate) fn footprint(fragment: &Fragment<'_, { Surface::LEN }>) -> Footprint {
    fragment.footprint(0, 1)
}

/// The colour of a material where a pixel sees it, in linear light.
pub(crate) fn color_of(model: &Model, material: Option<&Material>, seen: &Footprint) -> Vec3 {
    let Some(material) = material else { return Vec3::ONE };
    let texture = material.texture.and_then(|i| model.textures.get(i));
    material.diffuse
        * texture.map_or(Vec3::ONE, |texture| texture.sample_footprint(seen).truncate())
}
