//! The materials and textures of glTF files.

use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec4};
use gltf::image::Source;
use gltf::texture::{MagFilter, WrappingMode};
use image::{ImageReader, Limits};

use super::data::{Data, resource};
use crate::formats::found::Found;
use crate::model::{AlphaMode, Material, TextureMapping};
use crate::texture::{Filter, MAX_DECODE_BYTES, MAX_FILE_TEXELS, MAX_SIDE, Texture, Wrap};

/// The most pictures that are opened.
const MAX_TEXTURES: usize = 1024;

/// The set of texture coordinates that the base colour of a material uses.
pub(super) fn uv_set(material: &gltf::Material<'_>) -> u32 {
    material.pbr_metallic_roughness().base_color_texture().map_or(0, |info| {
        info.texture_transform().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord())
    })
}

/// Adds all materials, after the default one, and the textures that they use.
pub(super) fn open(document: &gltf::Document, data: &Data, path: &Path, found: &mut Found) {
    let mut left = MAX_FILE_TEXELS;
    let mut indices = vec![None; document.textures().len()];
    let mut unused = [0_u64; 3];
    // Where there is no material, the specification has a white one.
    found.materials[0].diffuse = glam::Vec3::ONE;
    for material in document.materials() {
        let base = material.pbr_metallic_roughness();
        let color = Vec4::from_array(base.base_color_factor());
        let name = material.name().unwrap_or("unnamed");
        let mut made = Material::new(name, color.truncate());
        made.alpha_mode = match material.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => {
                AlphaMode::Cutout { threshold: material.alpha_cutoff().unwrap_or(0.5) }
            }
            gltf::material::AlphaMode::Blend => AlphaMode::Blend,
        };
        if made.alpha_mode != AlphaMode::Opaque {
            made.alpha = color.w.clamp(0.0, 1.0);
        }
        if let Some(info) = base.base_color_texture() {
            let texture = info.texture();
            let index = *indices[texture.index()].get_or_insert_with(|| {
                let opened = if found.textures.len() < MAX_TEXTURES {
                    texture_of(&texture, data, path, left)
                } else {
                    Err(format!("at most {MAX_TEXTURES} are opened"))
                };
                match opened {
                    Ok(texture) => {
                        left -= u64::from(texture.width()) * u64::from(texture.height());
                        found.textures.push(texture);
                        Some(found.textures.len() - 1)
                    }
                    Err(cause) => {
                        let name = name.replace(char::is_control, "");
                        let sentence =
                            format!("the material `{name}` stays without its texture: {cause}");
                        found.warnings.push(sentence);
                        None
                    }
                }
            });
            made.texture = index;
            made.mapping = mapping_of(&info);
        }
        unused[0] += u64::from(material.normal_texture().is_some());
        unused[1] += u64::from(material.emissive_texture().is_some());
        unused[2] += u64::from(material.occlusion_texture().is_some());
        found.materials.push(made);
    }
    for (what, count) in ["normals", "emitted light", "occlusion"].into_iter().zip(unused) {
        if count > 0 {
            found.warnings.push(format!("pictures of {what} are not used ({count} in the file)"));
        }
    }
}

/// How a texture lies on the faces (KHR_texture_transform), but for its rotation.
fn mapping_of(info: &gltf::texture::Info<'_>) -> TextureMapping {
    let mut mapping = TextureMapping::default();
    if let Some(transform) = info.texture_transform() {
        let [u, v] = transform.offset();
        mapping.scale = Vec2::from_array(transform.scale());
        // Given with v down, kept with v up.
        mapping.offset = Vec2::new(u, 1.0 - mapping.scale.y - v);
    }
    mapping
}

fn texture_of(
    texture: &gltf::Texture<'_>,
    data: &Data,
    path: &Path,
    most: u64,
) -> Result<Texture, String> {
    let decoded = match texture.source().source() {
        Source::View { view, .. } => decode(data.view(&view)?, most)?,
        Source::Uri { uri, .. } => decode(&resource(uri, path, MAX_DECODE_BYTES)?, most)?,
    };
    let made = Texture::from_image(&decoded).map_err(|error| error.to_string())?;
    let sampler = texture.sampler();
    let wrap = |mode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    let made = made.with_wraps(wrap(sampler.wrap_s()), wrap(sampler.wrap_t()));
    let is_nearest = sampler.mag_filter() == Some(MagFilter::Nearest);
    Ok(if is_nearest { made.with_filter(Filter::Nearest) } else { made })
}

/// Decodes a picture of at most so many texels.
fn decode(bytes: &[u8], most: u64) -> Result<image::DynamicImage, String> {
    let reader = || ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let size = reader().map_err(|error| error.to_string())?.into_dimensions();
    let (width, height) = size.map_err(|error| error.to_string())?;
    if u64::from(width) * u64::from(height) > most || width.max(height) > MAX_SIDE {
        return Err(format!("{width} x {height} texels are more than the {most} that are left"));
    }
    let mut limited = reader().map_err(|error| error.to_string())?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    limited.limits(limits);
    limited.decode().map_err(|error| error.to_string())
}
