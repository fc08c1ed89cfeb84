//! The texels of a picture, in memory.

use glam::Vec4;

use crate::texture::error::TextureError;
use crate::texture::limits::MAX_SIDE;

/// A rectangle of texels in linear light, premultiplied by alpha.
#[derive(Clone)]
pub(super) struct Texels {
    width: u32,
    height: u32,
    /// Row by row from the top; `width * height` of them, both from 1 to [`MAX_SIDE`].
    texels: Vec<Vec4>,
}

impl Texels {
    /// Takes `width * height` texels, row by row from the top.
    pub(super) fn new(width: u32, height: u32, texels: Vec<Vec4>) -> Result<Self, TextureError> {
        check_size(width, height)?;
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(TextureError::Length { width, height, given: texels.len() });
        }
        Ok(Self { width, height, texels })
    }

    /// Collects texels that come row by row from the top.
    pub(super) fn collect(
        width: u32,
        height: u32,
        row_by_row: impl Iterator<Item = Vec4>,
    ) -> Result<Self, TextureError> {
        check_size(width, height)?;
        let mut texels = room(width, height)?;
        texels.extend(row_by_row);
        Self::new(width, height, texels)
    }

    /// Number of texels in a row.
    #[inline]
    pub(super) fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    #[inline]
    pub(super) fn height(&self) -> u32 {
        self.height
    }

    /// All texels, row by row from the top.
    #[inline]
    pub(super) fn as_slice(&self) -> &[Vec4] {
        &self.texels
    }

    /// The texel in column `x`, row `y`. Beyond the last column or row it is the last one.
    #[inline]
    pub(super) fn get(&self, x: u32, y: u32) -> Vec4 {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.texels[y as usize * self.width as usize + x as usize]
    }
}

fn check_size(width: u32, height: u32) -> Result<(), TextureError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(TextureError::Size { width, height })
    }
}

/// An empty list with room for all texels.
fn room(width: u32, height: u32) -> Result<Vec<Vec4>, TextureError> {
    let mut texels = Vec::new();
    usize::try_from(u64::from(width) * u64::from(height))
        .ok()
        .and_then(|count| texels.try_reserve_exact(count).ok())
        .map(|()| texels)
        .ok_or(TextureError::Memory { width, height })
}
