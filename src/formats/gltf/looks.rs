//! The materials and textures of glTF files.

use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};
use gltf::image::Source;
use gltf::json::Value;
use gltf::texture::{MagFilter, WrappingMode};
use image::{ImageReader, Limits};

use super::data::{Data, resource};
use crate::angle::direction;
use crate::formats::found::Found;
use crate::model::{AlphaMode, Material, TextureMapping};
use crate::texture::{Filter, MAX_DECODE_BYTES, MAX_FILE_TEXELS, MAX_SIDE, Texture, Wrap};

/// The most pictures that are opened.
const MAX_TEXTURES: usize = 1024;

/// The set of texture coordinates that a material uses: that of its base colour, or else of its emitted
/// light, its normals or its occlusion.
pub(super) fn uv_set(material: &gltf::Material<'_>) -> u32 {
    let base = material.pbr_metallic_roughness().base_color_texture();
    let normals = material.normal_texture().map(|normals| normals.tex_coord());
    let others = normals.or(material.occlusion_texture().map(|occlusion| occlusion.tex_coord()));
    base.or(material.emissive_texture()).map(|info| set_of(&info)).or(others).unwrap_or(0)
}

fn set_of(info: &gltf::texture::Info<'_>) -> u32 {
    info.texture_transform().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord())
}

/// Adds all materials, after the default one, and the textures that they use.
pub(super) fn open(document: &gltf::Document, data: &Data, path: &Path, found: &mut Found) {
    let indices = vec![[None; 2]; document.textures().len()];
    let mut opener = Opener { data, path, left: MAX_FILE_TEXELS, indices };
    let mut unused = Unused::default();
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
            made.texture = opener.open(&info.texture(), Meaning::Colours, &made.name, found);
            made.mapping = mapping_of(&info);
        }
        made.emission = Vec3::from_array(material.emissive_factor());
        made.emission *= material.emissive_strength().unwrap_or(1.0);
        if let Some(info) = material.emissive_texture().filter(|_| made.is_emissive()) {
            if set_of(&info) == uv_set(&material) {
                made.emission_texture =
                    opener.open(&info.texture(), Meaning::Colours, &made.name, found);
                made.emission_mapping = mapping_of(&info);
            }
            if made.emission_texture.is_none() {
                // Without its picture, which is dark nearly everywhere, all would glow.
                made.emission = Vec3::ZERO;
                unused.emission += u64::from(set_of(&info) != uv_set(&material));
            }
        }
        open_numbers(&material, &mut made, &mut opener, (found, &mut unused));
        found.materials.push(made);
    }
    let Unused { normals, occlusion, emission } = unused;
    for (what, count) in
        [("normals", normals), ("occlusion", occlusion), ("emitted light", emission)]
            .into_iter()
            .filter(|&(_, count)| count > 0)
    {
        found.warnings.push(format!(
            "pictures of {what} with texture coordinates of their own are not used ({count} in the file)"
        ));
    }
}

/// How many pictures are not used since their texture coordinates are not those of the base colour.
#[derive(Default)]
struct Unused {
    normals: u64,
    occlusion: u64,
    emission: u64,
}

/// Opens the pictures of normals and of occlusion, which hold numbers.
fn open_numbers(
    material: &gltf::Material<'_>,
    made: &mut Material,
    opener: &mut Opener<'_>,
    (found, unused): (&mut Found, &mut Unused),
) {
    let set = uv_set(material);
    if let Some(normals) = material.normal_texture() {
        let transform = normals.extension_value("KHR_texture_transform");
        let (mapping, own_set) = mapping_of_json(transform);
        if own_set.unwrap_or(normals.tex_coord()) == set {
            let texture = normals.texture();
            made.normal_texture = opener.open(&texture, Meaning::Numbers, &made.name, found);
            (made.normal_mapping, made.normal_strength) = (mapping, normals.scale());
        } else {
            unused.normals += 1;
        }
    }
    if let Some(occlusion) = material.occlusion_texture() {
        let transform = occlusion.extension_value("KHR_texture_transform");
        let (mapping, own_set) = mapping_of_json(transform);
        if own_set.unwrap_or(occlusion.tex_coord()) == set {
            let texture = occlusion.texture();
            made.occlusion_texture = opener.open(&texture, Meaning::Numbers, &made.name, found);
            made.occlusion_mapping = mapping;
            made.occlusion_strength = occlusion.strength().clamp(0.0, 1.0);
        } else {
            unused.occlusion += 1;
        }
    }
}

/// What the numbers of a picture mean.
#[derive(Clone, Copy)]
enum Meaning {
    /// Colours, in sRGB.
    Colours,
    /// Numbers that are taken as they stand.
    Numbers,
}

/// Opens textures, each once.
struct Opener<'a> {
    data: &'a Data,
    path: &'a Path,
    /// How many texels there may still be.
    left: u64,
    /// For each texture of the document that was asked for, by its [`Meaning`], its place among those found;
    /// `None` for those that cannot be opened.
    indices: Vec<[Option<Option<usize>>; 2]>,
}

impl Opener<'_> {
    /// The place of a texture, which a warning says if it cannot be opened.
    fn open(
        &mut self,
        texture: &gltf::Texture<'_>,
        meaning: Meaning,
        material: &str,
        found: &mut Found,
    ) -> Option<usize> {
        if let Some(index) = self.indices[texture.index()][meaning as usize] {
            return index;
        }
        let opened = if found.textures.len() < MAX_TEXTURES {
            texture_of(texture, meaning, (self.data, self.path), self.left)
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
        self.indices[texture.index()][meaning as usize] = Some(index);
        index
    }
}

/// How a texture lies on the faces (KHR_texture_transform).
///
/// The extension's text gives a matrix that turns the other way than its example of the lower left quadrant;
/// programs follow the example.
fn mapping_of(info: &gltf::texture::Info<'_>) -> TextureMapping {
    info.texture_transform().map_or_else(TextureMapping::default, |transform| {
        mapping(transform.offset(), transform.rotation(), transform.scale())
    })
}

/// The same from the extension's JSON, for pictures where the crate does not read it, with the set of texture
/// coordinates if it names one. What is no number counts as missing.
fn mapping_of_json(transform: Option<&Value>) -> (TextureMapping, Option<u32>) {
    let number = |value: Option<&Value>, default: f32| {
        value.and_then(Value::as_f64).map_or(default, |number| number as f32)
    };
    let member = |name: &str| transform.and_then(|transform| transform.get(name));
    let pair = |name: &str, default: f32| {
        [0, 1].map(|i| number(member(name).and_then(|list| list.get(i)), default))
    };
    let rotation = number(member("rotation"), 0.0);
    let set = member("texCoord").and_then(Value::as_u64).map(|set| set as u32);
    (mapping(pair("offset", 0.0), rotation, pair("scale", 1.0)), set)
}

fn mapping([u, v]: [f32; 2], rotation: f32, scale: [f32; 2]) -> TextureMapping {
    let scale = Vec2::from_array(scale);
    let turn = direction(rotation);
    // Turned and moved around the corner that v down begins at, kept with v up.
    let Vec2 { x: cosine, y: sine } = turn;
    let offset = Vec2::new(u + sine * scale.y, 1.0 - cosine * scale.y - v);
    TextureMapping { scale, turn, offset, ..TextureMapping::default() }
}

fn texture_of(
    texture: &gltf::Texture<'_>,
    meaning: Meaning,
    (data, path): (&Data, &Path),
    most: u64,
) -> Result<Texture, String> {
    let decoded = match texture.source().source() {
        Source::View { view, .. } => decode(data.view(&view)?, most)?,
        Source::Uri { uri, .. } => decode(&resource(uri, path, MAX_DECODE_BYTES)?, most)?,
    };
    let made = match meaning {
        Meaning::Colours => Texture::from_image(&decoded),
        Meaning::Numbers => Texture::from_data(&decoded),
    };
    let made = made.map_err(|error| error.to_string())?;
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
