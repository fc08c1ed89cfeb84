//! Materials from what MTL files say, with their textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DVec4, Vec3, Vec4};

use crate::color::decode;
use crate::model::{AlphaMode, Material, TextureMapping};
use crate::obj::file::check_regular;
use crate::obj::limits::MAX_TEXTURES;
use crate::obj::map_options::{MapOptions, readings};
use crate::obj::mtl::Entry;
use crate::obj::paths::Finder;
use crate::obj::warning::{Warning, Warnings};
use crate::texture::{MAX_FILE_TEXELS, Texture, TextureError, Wrap};

/// The default material and those of the entries, with the textures that can be opened.
///
/// Materials without a colour of their own are white under colours of vertices.
pub(super) fn open(
    entries: Vec<Entry>,
    has_colors: bool,
    finder: &mut Finder,
    warnings: &mut Warnings,
) -> (Vec<Material>, Vec<Texture>) {
    let mut cache = TextureCache::default();
    let mut default = Material::default();
    if has_colors {
        default.diffuse = Vec3::ONE;
    }
    let mut materials = vec![default.clone()];
    for entry in entries {
        let [diffuse_map, ambient_map, alpha_map, emission_map, ..] = &entry.maps;
        let mut material = Material::new(entry.name.clone(), default.diffuse);
        // Some programs write the picture of a material as that of its ambient light alone.
        let color_map = diffuse_map.as_ref().or(ambient_map.as_ref());
        let mut map =
            |map: Option<&String>, for_what| cache.map(map, for_what, &entry, finder, warnings);
        if let Some((index, options)) = map(color_map, Use::Colour) {
            (material.texture, material.mapping) = (Some(index), options.mapping);
            material.diffuse = Vec3::ONE;
        }
        if let Some((index, options)) = map(alpha_map.as_ref(), Use::Alpha) {
            (material.alpha_texture, material.alpha_mapping) = (Some(index), options.mapping);
        }
        if let Some((index, options)) = map(emission_map.as_ref(), Use::Colour) {
            (material.emission_texture, material.emission_mapping) = (Some(index), options.mapping);
            material.emission = Vec3::ONE;
        }
        material.emission = entry.emission.unwrap_or(material.emission);
        open_other_maps(&mut material, &entry, &mut map);
        match entry.diffuse {
            Some(Vec3::ZERO) if material.texture.is_some() => {
                warnings.add(Warning::BlackTexture { material: entry.name.clone() });
            }
            // A picture that is missing, of which a warning tells, was to give the colour.
            Some(Vec3::ZERO) if color_map.is_some() => {}
            Some(diffuse) => material.diffuse = diffuse,
            None => {}
        }
        // `d` is the one that the format has; where both are written, `Tr` follows from it.
        material.alpha = entry.dissolve.unwrap_or(1.0 - entry.transparency.unwrap_or(0.0));
        if material.alpha == 0.0 && entry.dissolve.is_none() {
            material.alpha = 1.0;
            warnings.add(Warning::Opaque { material: entry.name });
        } else if material.alpha == 0.0 {
            warnings.add(Warning::Invisible { material: entry.name });
        }
        material.alpha_mode = alpha_mode(&material, &cache.textures);
        materials.push(material);
    }
    (materials, cache.textures.into_iter().map(|(texture, _)| texture).collect())
}

/// Opens the pictures of highlights, normals and heights.
fn open_other_maps(
    material: &mut Material,
    entry: &Entry,
    map: &mut impl FnMut(Option<&String>, Use) -> Option<(usize, MapOptions)>,
) {
    let [.., specular_map, bump_map, normal_map, height_map] = &entry.maps;
    // Most files have the numbers of highlights, whether they mean them or not; one with a picture does.
    if let Some((index, options)) = map(specular_map.as_ref(), Use::Colour) {
        (material.specular_texture, material.specular_mapping) = (Some(index), options.mapping);
        let specular = entry.specular.filter(|&specular| specular != Vec3::ZERO);
        material.specular = specular.unwrap_or(Vec3::ONE);
        material.shininess = entry.shininess.unwrap_or(material.shininess);
    }
    let normals = map(normal_map.as_ref(), Use::Normals);
    if let Some((index, options)) = normals.or_else(|| map(bump_map.as_ref(), Use::Bumps)) {
        let MapOptions { mapping, bump } = options;
        material.normal_texture = Some(index);
        material.normal_mapping = TextureMapping { base: 0.0, gain: 1.0, ..mapping };
        material.normal_strength = bump * mapping.gain;
    }
    if let Some((index, options)) = map(height_map.as_ref(), Use::Numbers) {
        material.displacement_texture = Some(index);
        let MapOptions { mapping, bump } = options;
        let (base, gain) = (mapping.base * bump, mapping.gain * bump);
        material.displacement_mapping = TextureMapping { base, gain, ..mapping };
    }
}

/// What alpha means: pictures that are nearly all holes and no glass cut out.
fn alpha_mode(material: &Material, textures: &[(Texture, Transparency)]) -> AlphaMode {
    let of = |index: Option<usize>| index.map_or(Transparency::None, |index| textures[index].1);
    if material.alpha < 1.0 {
        return AlphaMode::Blend;
    }
    match of(material.texture).max(of(material.alpha_texture)) {
        Transparency::None => AlphaMode::Opaque,
        Transparency::Holes => AlphaMode::Cutout { threshold: 0.5 },
        Transparency::Glass => AlphaMode::Blend,
    }
}

/// What the alpha of a picture is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Transparency {
    None,
    Holes,
    Glass,
}

/// The most texels whose alpha is looked at; of larger pictures they are taken at even distances.
const LOOKS: u64 = 1 << 20;

/// The distance of the texels that are looked at.
fn step_of(texture: &Texture) -> usize {
    let count = |step| u64::from(texture.width() / step) * u64::from(texture.height() / step);
    (1..).find(|&step| count(step) <= LOOKS).unwrap_or(1) as usize
}

fn transparency(texture: &Texture, channel: Use) -> Transparency {
    let (width, height) = (texture.width(), texture.height());
    let step = step_of(texture);
    let (mut between, mut clear, mut all) = (0_u64, 0_u64, 0_u64);
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let texel = texture.texel(x, y);
            let alpha = if channel == Use::Alpha { texel.x } else { texel.w };
            all += 1;
            clear += u64::from(alpha < 0.95);
            between += u64::from(alpha > 0.05 && alpha < 0.95);
        }
    }
    // The rims of leaves are between; a tenth of the picture is more than rims.
    match (clear, between) {
        (0, _) => Transparency::None,
        _ if between * 10 > all => Transparency::Glass,
        _ => Transparency::Holes,
    }
}

/// Whether the name is that of a TGA file. Old programs write 32 bits a texel into them, the last 8 of which
/// are zero and mean nothing.
fn is_tga(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("tga"))
}

/// Whether all texels have an alpha of 0.
fn is_clear(texture: &Texture) -> bool {
    let (width, height) = (texture.width(), texture.height());
    (0..height).all(|y| (0..width).all(|x| texture.texel(x, y).w == 0.0))
}

/// The texture of a file whose alpha counts for nothing.
fn without_alpha(path: &Path) -> Result<Texture, TextureError> {
    let numbers = Texture::open_data(path)?;
    Texture::from_fn(numbers.width(), numbers.height(), |x, y| {
        let code = |number: f32| decode((number * 255.0).round() as u8);
        let [r, g, b, _] = numbers.texel(x, y).to_array();
        Vec4::new(code(r), code(g), code(b), 1.0)
    })
}

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Use {
    Colour,
    /// Its numbers are alpha, in the red channel.
    Alpha,
    /// Its numbers are what they are.
    Numbers,
    /// Its numbers are normals.
    Normals,
    /// Its numbers are normals if it looks like that, or else heights.
    Bumps,
}

impl Use {
    /// The texture of a file that is opened for other uses than colours and alpha.
    fn open(self, path: &Path, limit: u64, clamp: bool) -> Result<Texture, TextureError> {
        let numbers = Texture::open_data_within(path, limit)?;
        if self != Self::Bumps || looks_like_normals(&numbers) {
            return Ok(numbers);
        }
        // The slopes at the edges depend on what is beyond.
        let heights = if clamp { numbers.with_wrap(Wrap::Clamp) } else { numbers };
        heights.normals_of_heights(heights.width() as f32 / BUMPS)
    }
}

/// Where a bump map's picture is so many times as wide as white is high, for the format says nothing of it.
const BUMPS: f32 = 64.0;

/// Whether numbers are those of a normal map, which some programs write as bumps: their mean points out of the
/// surface, and they are no greys.
fn looks_like_normals(numbers: &Texture) -> bool {
    let mean = mean(numbers);
    mean.z > 0.7 && mean.z > mean.x + 0.15 && mean.z > mean.y + 0.15
}

/// The mean of a picture, of large ones that of texels at even distances.
fn mean(texture: &Texture) -> Vec4 {
    let (width, height) = (texture.width(), texture.height());
    let step = step_of(texture);
    let places =
        (0..height).step_by(step).flat_map(|y| (0..width).step_by(step).map(move |x| (x, y)));
    let (mut sum, mut count) = (DVec4::ZERO, 0.0);
    for (x, y) in places {
        sum += texture.texel(x, y).as_dvec4();
        count += 1.0;
    }
    (sum / count).as_vec4()
}

/// Textures, each file once for each use and wrap.
#[derive(Default)]
struct TextureCache {
    textures: Vec<(Texture, Transparency)>,
    /// Number of texels of all textures.
    texels: u64,
    /// The index of each file in `textures`; `None` for those that cannot be opened.
    indices: HashMap<(PathBuf, Use, bool), Option<usize>>,
}

impl TextureCache {
    /// The texture that a map line names, and how it lies on faces.
    fn map(
        &mut self,
        line: Option<&String>,
        for_what: Use,
        entry: &Entry,
        finder: &mut Finder,
        warnings: &mut Warnings,
    ) -> Option<(usize, MapOptions)> {
        let mut missing = None;
        for (name, options) in readings(line?) {
            match finder.find(&entry.folder, &name) {
                Some(Ok(path)) => {
                    let index =
                        self.get(path, for_what, options.mapping.clamp, &entry.name, warnings)?;
                    return Some((index, options));
                }
                Some(Err(path)) if !name.starts_with('-') => {
                    missing = missing.or(Some((path, options)));
                }
                _ => {}
            }
        }
        let (path, options) = missing?;
        // It is opened all the same, for the system to say what is wrong.
        self.get(path, for_what, options.mapping.clamp, &entry.name, warnings)
            .map(|index| (index, options))
    }

    /// The index of the texture in a file, which is opened unless it was before. `None` if it cannot
    /// be opened, of which the first call warns, or if there are too many.
    fn get(
        &mut self,
        path: PathBuf,
        for_what: Use,
        clamp: bool,
        material: &str,
        warnings: &mut Warnings,
    ) -> Option<usize> {
        let key = (path, for_what, clamp);
        if let Some(index) = self.indices.get(&key) {
            return *index;
        }
        let material = material.to_owned();
        if self.indices.len() == MAX_TEXTURES {
            warnings.add(Warning::TooManyTextures { material });
            return None;
        }
        let index = match self.open(&key.0, for_what, clamp) {
            Ok(index) => Some(index),
            Err(source) => {
                warnings.add(Warning::Texture { material, source });
                None
            }
        };
        self.indices.insert(key, index);
        index
    }

    fn open(&mut self, path: &Path, for_what: Use, clamp: bool) -> Result<usize, TextureError> {
        check_regular(path)
            .map_err(|source| TextureError::Read { path: path.to_owned(), source })?;
        let limit = MAX_FILE_TEXELS - self.texels;
        if !matches!(for_what, Use::Colour | Use::Alpha) {
            return Ok(self.add(for_what.open(path, limit, clamp)?, Transparency::None, clamp));
        }
        let mut texture = Texture::open_within(path, limit)?;
        if is_tga(path) && is_clear(&texture) {
            texture = without_alpha(path)?;
        }
        let mut transparency = transparency(&texture, Use::Colour);
        if for_what == Use::Alpha {
            let numbers = Texture::open_data(path)?;
            // A picture with an alpha channel means that, one without means its grey.
            if transparency == Transparency::None {
                texture = numbers;
            } else {
                texture = Texture::from_fn(numbers.width(), numbers.height(), |x, y| {
                    Vec4::splat(numbers.texel(x, y).w)
                })?;
            }
            transparency = self::transparency(&texture, Use::Alpha);
        }
        Ok(self.add(texture, transparency, clamp))
    }

    /// The index of a texture that is added.
    fn add(&mut self, texture: Texture, transparency: Transparency, clamp: bool) -> usize {
        self.texels += u64::from(texture.width()) * u64::from(texture.height());
        let wrapped = if clamp { texture.with_wrap(Wrap::Clamp) } else { texture };
        self.textures.push((wrapped, transparency));
        self.textures.len() - 1
    }
}
