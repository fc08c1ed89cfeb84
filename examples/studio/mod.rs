//! What the examples that show a model share: its options, a camera that sees all of it, and a light.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3, vec3};
use polyscan::obj::{Loader, Material, Model};
use polyscan::record;

/// A model, and from where it is seen.
#[derive(Args)]
pub(crate) struct View {
    /// The model.
    #[arg(default_value = "examples/assets/cottage.obj")]
    pub(crate) model: PathBuf,
    /// Turn of the camera around the model, in degrees, to the right.
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    pub(crate) yaw: f32,
    /// Height of the camera over the model's level, in degrees, from -90 to 90.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    pub(crate) pitch: f32,
}

/// Width and height, such as 800x600, of at most `MOST` pixels each.
pub(crate) fn parse_size<const MOST: u32>(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').ok_or("write it as 800x600")?;
    let side = |side: &str| match side.parse() {
        Ok(pixels) if (1..=MOST).contains(&pixels) => Ok(pixels),
        _ => Err(format!("`{side}` is not a number of pixels from 1 to {MOST}")),
    };
    Ok((side(width)?, side(height)?))
}

/// Loads a model; what is strange about it goes to the standard error.
pub(crate) fn load(loader: &Loader, path: &Path) -> Result<Model, Box<dyn Error>> {
    let loaded = loader.load(path)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(loaded.model)
}

/// Makes the folder that a file goes to.
pub(crate) fn make_folder_of(file: &Path) -> std::io::Result<()> {
    file.parent().map_or(Ok(()), std::fs::create_dir_all)
}

record! {
    /// What goes from the vertices to the pixels.
    pub(crate) struct Surface {
        pub(crate) uv: Vec2,
        pub(crate) normal: Vec3,
    }
}

/// The middle of a model, and the radius of a sphere around that holds it.
pub(crate) fn sphere_around(model: &Model) -> (Vec3, f32) {
    let (low, high) = model.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
    let centre = (low + high) / 2.0;
    let distances = model.vertices.iter().map(|vertex| vertex.position.distance(centre));
    // A model that is a point is no reason to divide by zero.
    (centre, distances.fold(f32::MIN_POSITIVE.sqrt(), f32::max))
}

pub(crate) struct Camera {
    pub(crate) clip_from_object: Mat4,
    /// Direction to the light: beside the camera, above its right shoulder.
    light: Vec3,
}

impl Camera {
    const FIELD_OF_VIEW: f32 = 0.6;

    /// A camera that sees the whole of a sphere, from whatever side; angles in degrees.
    pub(crate) fn around((centre, radius): (Vec3, f32), aspect: f32, yaw: f32, pitch: f32) -> Self {
        let narrow = ((Self::FIELD_OF_VIEW / 2.0).tan() * aspect.min(1.0)).atan();
        let distance = radius / narrow.sin();
        let (sin_yaw, cos_yaw) = yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = pitch.clamp(-89.9, 89.9).to_radians().sin_cos();
        let direction = vec3(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = Vec3::Y.cross(direction).normalize();
        let light = (direction + 0.6 * right + 0.7 * direction.cross(right)).normalize();
        let view = look_at_mat4(centre + direction * distance, centre, Vec3::Y);
        let (near, far) = (distance - radius * 1.01, distance + radius * 1.01);
        let projection = perspective(Self::FIELD_OF_VIEW, aspect, near, far);
        Self { clip_from_object: projection * view, light }
    }

    /// How much light a surface sends back. One seen from behind is lit from behind.
    pub(crate) fn lit(&self, surface: &Surface) -> f32 {
        let facing = surface.normal.normalize_or_zero().dot(self.light);
        0.15 + 0.85 * if facing < 0.0 { -0.4 * facing } else { facing }
    }
}

/// The colour of a material, in linear light.
pub(crate) fn color_of(model: &Model, material: Option<&Material>, uv: Vec2) -> Vec3 {
    let Some(material) = material else { return Vec3::ONE };
    let texture = material.texture.and_then(|i| model.textures.get(i));
    material.diffuse * texture.map_or(Vec3::ONE, |texture| texture.sample(uv).truncate())
}
