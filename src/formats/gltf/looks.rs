//! The materials and textures of glTF files.

use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};
use gltf::image::Source;
use gltf::texture::{MagFilter, WrappingMode};
use image::{ImageReader, Limits};

use super::data::{Data, resource};
use crate::formats::found::Found;
use crate::model::{AlphaMode, Material, TextureMapping, direction};
use crate::texture::{Filter, MAX_DECODE_BYTES, MAX_FILE_TEXELS, MAX_SIDE, Texture, Wrap};

/// The most pictures that are opened.
const MAX_TEXTURES: usize = 1024;

/// The set of texture coordinates that a material uses: that of its base colour, or else of its emitted
/// light.
pub(super) fn uv_set(material: &gltf::Material<'_>) -> u32 {
    let base = material.pbr_metallic_roughness().base_color_texture();
    base.or(material.emissive_texture()).map_or(0, |info| set_of(&info))
}

fn set_of(info: &gltf::texture::Info<'_>) -> u32 {
    info.texture_transform().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord())
}

/// Adds all materials, after the default one, and the textures that they use.
pub(super) fn open(document: &gltf::Document, data: &Data, path: &Path, found: &mut Found) {
    let indices = vec![None; document.textures().len()];
    let mut opener = Opener { data, path, left: MAX_FILE_TEXELS, indices };
    let mut unused = [0_u64; 3];
    // Where there is no material, the specification has a white one.
    found.materials[0].diffuse = Vec3::ONE;
    for material in document.materials() {
        let base = material.pbr_metallic_roughness();
        let color = Vec4::from_array(base.base_color_factor());
        let mut made = Material::new(material.name().unwrap_or("unnamed"), color.truncate());
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
            made.texture = opener.open(&info.texture(), &made.name, found);
            made.mapping = mapping_of(&info);
        }
        made.emission = Vec3::from_array(material.emissive_factor());
        made.emission *= material.emissive_strength().unwrap_or(1.0);
        if let Some(info) = material.emissive_texture().filter(|_| made.is_emissive()) {
            if set_of(&info) == uv_set(&material) {
                made.emission_texture = opener.open(&info.texture(), &made.name, found);
                made.emission_mapping = mapping_of(&info);
            }
            if made.emission_texture.is_none() {
                // Without its picture, which is dark nearly everywhere, all would glow.
                made.emission = Vec3::ZERO;
                unused[2] += u64::from(set_of(&info) != uv_set(&material));
            }
        }
        unused[0] += u64::from(material.normal_texture().is_some());
        unused[1] += u64::from(material.occlusion_texture().is_some());
        found.materials.push(made);
    }
    let what = ["normals", "occlusion", "emitted light with texture coordinates of their own"];
    for (what, count) in what.into_iter().zip(unused) {
        if count > 0 {
            found.warnings.push(format!("pictures of {what} are not used ({count} in the file)"));
        }
    }
}

/// Opens textures, each once.
struct Opener<'a> {
    data: &'a Data,
    path: &'a Path,
    /// How many texels there may still be.
    left: u64,
    /// For each texture of the document that was asked for, its place among those found; `None` for those
    /// that cannot be opened.
    indices: Vec<Option<Option<usize>>>,
}

impl Opener<'_> {
    /// The place of a texture, which a warning says if it cannot be opened.
    fn open(
        &mut self,
        texture: &gltf::Texture<'_>,
        material: &str,
        found: &mut Found,
    ) -> Option<usize> {
        if let Some(index) = self.indices[texture.index()] {
            return index;
        }
        let opened = if found.textures.len() < MAX_TEXTURES {
            texture_of(texture, self.data, self.path, self.left)
        } else {
            Err(format!("at most {MAX_TEXTURES} are opened"))
        };
        let index = match opened {
            Ok(texture) => {
                self.left -= u64::from(texture.width()) * u64::from(texture.height());
                found.textures.push(texture);
                Some(found.textures.len() - 1)
            }
            Err(cause) => {
                let name = material.replace(char::is_control, "");
                found
                    .warnings
                    .push(format!("the material `{name}` stays without its texture: {cause}"));
                None
            }
        };
        self.indices[texture.index()] = Some(index);
        index
    }
}

/// How a texture lies on the faces (KHR_texture_transform).
///
/// The extension's text gives a matrix that turns the other way than its example of the lower left quadrant;
/// programs follow the example.
fn mapping_of(info: &gltf::texture::Info<'_>) -> TextureMapping {
    let mut mapping = TextureMapping::default();
    if let Some(transform) = info.texture_transform() {
        let [u, v] = transform.offset();
        mapping.scale = Vec2::from_array(transform.scale());
        mapping.turn = direction(transform.rotation());
        // Turned and moved around the corner that v down begins at, kept with v up.
        let Vec2 { x: cosine, y: sine } = mapping.turn;
        let height = mapping.scale.y;
        mapping.offset = Vec2::new(u + sine * height, 1.0 - cosine * height - v);
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
