//! Materials from what `tobj` finds in MTL text, with their textures.

use std::collections::HashMap;
use std::path::Path;

use glam::Vec3;

use crate::model::Material;
use crate::obj::file::check_regular;
use crate::obj::limits::MAX_TEXTURES;
use crate::obj::paths::beside;
use crate::obj::warning::{Warning, Warnings};
use crate::texture::{MAX_FILE_TEXELS, Texture, TextureError};

/// The default material and those that `tobj` found, with the textures that can be opened.
pub(super) fn open(
    obj: &Path,
    named: Vec<tobj::Material>,
    warnings: &mut Warnings,
) -> (Vec<Material>, Vec<Texture>) {
    let mut cache = TextureCache::default();
    let mut materials = vec![Material::default()];
    for tobj::Material { name, diffuse, diffuse_texture, .. } in named {
        let texture = diffuse_texture.and_then(|file| cache.get(obj, &file, &name, warnings));
        let diffuse = match (diffuse, texture) {
            (Some(diffuse), _) => Vec3::from_array(diffuse),
            (None, Some(_)) => Vec3::ONE,
            (None, None) => Material::default().diffuse,
        };
        materials.push(Material { name, diffuse, texture });
    }
    (materials, cache.textures)
}

/// Textures, each file once.
#[derive(Default)]
struct TextureCache {
    textures: Vec<Texture>,
    /// Number of texels of all textures.
    texels: u64,
    /// The index of each file in `textures`; `None` for those that cannot be opened.
    indices: HashMap<String, Option<usize>>,
}

impl TextureCache {
    /// The index of the texture in a file, which is opened unless it was before. `None` if it cannot
    /// be opened, of which the first call warns, or if there are too many.
    fn get(
        &mut self,
        obj: &Path,
        file: &str,
        material: &str,
        warnings: &mut Warnings,
    ) -> Option<usize> {
        if let Some(index) = self.indices.get(file) {
            return *index;
        }
        let material = material.to_owned();
        if self.indices.len() == MAX_TEXTURES {
            warnings.add(Warning::TooManyTextures { material });
            return None;
        }
        let index = match self.open(&beside(obj, file)) {
            Ok(index) => Some(index),
            Err(source) => {
                warnings.add(Warning::Texture { material, source });
                None
            }
        };
        self.indices.insert(file.to_owned(), index);
        index
    }

    fn open(&mut self, path: &Path) -> Result<usize, TextureError> {
        check_regular(path)
            .map_err(|source| TextureError::Read { path: path.to_owned(), source })?;
        let texture = Texture::open_within(path, MAX_FILE_TEXELS - self.texels)?;
        self.texels += u64::from(texture.width()) * u64::from(texture.height());
        self.textures.push(texture);
        Ok(self.textures.len() - 1)
    }
}
