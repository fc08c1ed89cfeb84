//! Normal maps of height maps (Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978).

use glam::{Vec3, vec3};

use crate::texture::build::Texture;
use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::light::to_word;
use crate::texture::texels::with_texels;
use crate::texture::wrap::wrapped_index;

impl Texture {
    /// The normal map of a picture of heights, such as a bump map that
    /// [`open_data`](Self::open_data) opened; of a texel with several channels, red, green and blue count alike.
    ///
    /// `height` says how many texels are as wide as a value of 1 is high; below 0 for dents. Slopes are half the
    /// difference of the two neighbours along each axis, beyond the edges by the picture's wrap. The normal
    /// leans from what is higher: x to the right, y UP in the picture, z out of it, of length 1; each of
    /// them is stored as 0.5 + 0.5 x, of 16 bits. [`TangentFrame`](crate::tangent::TangentFrame) takes
    /// such texels.
    ///
    /// Filter and wrap stay as they are. There are no mipmaps, for they are to be made of the normals.
    ///
    /// ```
    /// use polyscan::glam::{Vec3, Vec4, vec3};
    /// use polyscan::texture::{Texture, Wrap};
    ///
    /// // A ramp that rises to the right, by one for each texel.
    /// let ramp = Texture::from_fn(3, 1, |x, _| Vec4::splat(x as f32))?.with_wrap(Wrap::Clamp);
    /// let texel = ramp.normals_of_heights(1.0)?.texel(1, 0).truncate();
    /// assert!((texel * 2.0 - 1.0 - vec3(-1.0, 0.0, 1.0).normalize()).length() < 1e-4);
    /// # Ok::<(), polyscan::texture::TextureError>(())
    /// ```
    ///
    /// # Errors
    /// [`TextureError::Memory`] if the machine has no room for it, of 8 bytes a texel.
    pub fn normals_of_heights(&self, height: f32) -> Result<Self, TextureError> {
        let (width, rows) = (self.width(), self.height());
        let count = width as usize * rows as usize * 4;
        let mut samples = Vec::new();
        samples.try_reserve_exact(count).map_err(|_| TextureError::Memory {
            width,
            height: rows,
            bytes_per_texel: 8,
        })?;
        let around = self.how.around;
        with_texels!(&self.texels, self.texels.base(), base => {
            let at = |x: i32, y: i32| {
                let (x, y) = (wrapped_index(x, width, around.u), wrapped_index(y, rows, around.v));
                base.get(x, y).unwrap_or(around.border).truncate().element_sum() / 3.0
            };
            for (y, x) in (0..rows as i32).flat_map(|y| (0..width as i32).map(move |x| (y, x))) {
                let right = at(x + 1, y) - at(x - 1, y);
                let down = at(x, y + 1) - at(x, y - 1);
                samples.extend(encoded(vec3(-0.5 * right * height, 0.5 * down * height, 1.0)));
            }
        });
        let made = Self::from_samples(width, rows, 4, Samples::Unorm16(samples))?;
        Ok(Self { how: self.how, ..made }.with_simd_level(self.simd_level))
    }
}

/// A direction as a texel.
fn encoded(direction: Vec3) -> [u16; 4] {
    // What is not finite is flat.
    let normal = direction.try_normalize().unwrap_or(Vec3::Z);
    let [x, y, z] = (normal * 0.5 + 0.5).to_array().map(to_word);
    [x, y, z, u16::MAX]
}
