//! Materials from what MTL files say, with their textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{Vec3, Vec4};

use crate::color::decode;
use crate::model::{AlphaMode, Material, TextureMapping};
use crate::obj::file::check_regular;
use crate::obj::limits::MAX_TEXTURES;
use crate::obj::map_options::readings;
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
        let [diffuse_map, ambient_map, alpha_map, emission_map] = &entry.maps;
        let mut material = Material::new(entry.name.clone(), default.diffuse);
        // Some programs write the picture of a material as that of its ambient light alone.
        let color_map = diffuse_map.as_ref().or(ambient_map.as_ref());
        if let Some((index, mapping)) = cache.map(color_map, Use::Colour, &entry, finder, warnings)
        {
            (material.texture, material.mapping) = (Some(index), mapping);
            material.diffuse = Vec3::ONE;
        }
        if let Some((index, mapping)) =
            cache.map(alpha_map.as_ref(), Use::Alpha, &entry, finder, warnings)
        {
            (material.alpha_texture, material.alpha_mapping) = (Some(index), mapping);
        }
        if let Some((index, mapping)) =
            cache.map(emission_map.as_ref(), Use::Colour, &entry, finder, warnings)
        {
            (material.emission_texture, material.emission_mapping) = (Some(index), mapping);
            material.emission = Vec3::ONE;
        }
        material.emission = entry.emission.unwrap_or(material.emission);
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

fn transparency(texture: &Texture, channel: Use) -> Transparency {
    let (width, height) = (texture.width(), texture.height());
    let step = (1..).find(|&s| u64::from(width / s) * u64::from(height / s) <= LOOKS).unwrap_or(1);
    let (mut between, mut clear, mut all) = (0_u64, 0_u64, 0_u64);
    for y in (0..height).step_by(step as usize) {
        for x in (0..width).step_by(step as usize) {
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
    ) -> Option<(usize, TextureMapping)> {
        let mut missing = None;
        for (name, mapping) in readings(line?) {
            match finder.find(&entry.folder, &name) {
                Some(Ok(path)) => {
                    let index = self.get(path, for_what, mapping.clamp, &entry.name, warnings)?;
                    return Some((index, mapping));
                }
                Some(Err(path)) if !name.starts_with('-') => {
                    missing = missing.or(Some((path, mapping)));
                }
                _ => {}
            }
        }
        let (path, mapping) = missing?;
        // It is opened all the same, for the system to say what is wrong.
        self.get(path, for_what, mapping.clamp, &entry.name, warnings).map(|index| (index, mapping))
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
        let mut texture = Texture::open_within(path, MAX_FILE_TEXELS - self.texels)?;
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
        if clamp {
            texture = texture.with_wrap(Wrap::Clamp);
        }
        self.texels += u64::from(texture.width()) * u64::from(texture.height());
        self.textures.push((texture, transparency));
        Ok(self.textures.len() - 1)
    }
}
