//! The framebuffer: a colour of any type and an f32 depth for each pixel.

use std::ops::{Add, Mul};

use crate::render::target::{RenderTarget, Target, TargetError, height_of};
use crate::viewport::{Rect, SizeError, Viewport};

/// A picture being drawn. Row 0 is at the top, as in the `image` crate.
///
/// The colour may be anything that is `Copy`: 8-bit sRGB as `[u8; 4]`, linear light as
/// `glam::Vec4`, an object's number as `u32`.
#[derive(Clone, Debug, PartialEq)]
pub struct Framebuffer<C> {
    width: u32,
    height: u32,
    color: Vec<C>,
    depth: Vec<f32>,
}

impl<C: Copy> Framebuffer<C> {
    /// A framebuffer filled with a colour, its depth with 1.0, the depth of the far plane.
    ///
    /// # Errors
    /// When a side is longer than [`MAX_SIZE`](crate::viewport::MAX_SIZE), or there is not enough
    /// memory for the pixels.
    pub fn new(width: u32, height: u32, color: C) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        let reason =
            "there is not enough memory for it; draw in tiles with `Viewport::with_corner`";
        let error = SizeError::new(width, height, reason);
        let len = usize::try_from(u64::from(width) * u64::from(height)).map_err(|_| error)?;
        Ok(Self {
            width,
            height,
            color: filled(len, color).ok_or(error)?,
            depth: filled(len, 1.0).ok_or(error)?,
        })
    }

    /// The number of columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The viewport that covers the whole framebuffer.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        let (width, height) = (self.width, self.height);
        Viewport::whole(Rect { x: 0, y: 0, width, height })
    }

    /// Fills the picture with a colour and a depth: the [farthest](crate::DepthMode::farthest), which
    /// is 1.0 unless depth is reversed or 1/w. A renderer's own `clear` knows which it is.
    pub fn clear(&mut self, color: C, depth: f32) {
        self.color.fill(color);
        self.depth.fill(depth);
    }

    /// The colours, row by row from the top.
    #[must_use]
    pub fn color(&self) -> &[C] {
        &self.color
    }

    /// The colours, to be changed.
    pub fn color_mut(&mut self) -> &mut [C] {
        &mut self.color
    }

    /// The depths, row by row from the top.
    #[must_use]
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// The depths, to be changed.
    pub fn depth_mut(&mut self) -> &mut [f32] {
        &mut self.depth
    }

    /// The colour and the depth of a pixel; `None` outside the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<(C, f32)> {
        let index = (y as usize).checked_mul(self.width as usize)?.checked_add(x as usize)?;
        let inside = x < self.width && y < self.height;
        inside.then(|| self.color.get(index).copied().zip(self.depth.get(index).copied())).flatten()
    }
}

impl<C> Framebuffer<C> {
    /// A framebuffer of colours and depths that are there already, row by row from the top.
    ///
    /// # Errors
    /// As [`Target::new`].
    pub fn from_parts(width: u32, color: Vec<C>, depth: Vec<f32>) -> Result<Self, TargetError> {
        let height = height_of(width, color.len(), depth.len())?;
        Ok(Self { width, height, color, depth })
    }

    /// The colours and the depths, row by row from the top.
    #[must_use]
    pub fn into_parts(self) -> (Vec<C>, Vec<f32>) {
        (self.color, self.depth)
    }
}

impl<C: Copy> RenderTarget for Framebuffer<C> {
    type Color = C;

    fn target(&mut self) -> Target<'_, C> {
        Target::from_checked(self.width, self.color.as_mut_slice(), &mut self.depth)
    }
}

impl<C: Copy + Add<Output = C> + Mul<f32, Output = C>> Framebuffer<C> {
    /// The picture at 1/`factor` of the width and height: each colour is the mean of a block of
    /// `factor` x `factor` pixels, each depth the least of the block. Drawn large and downsampled, a
    /// picture in linear light is antialiased. Columns and rows that fill no block are left out; a
    /// factor of 0 counts as 1.
    ///
    /// # Errors
    /// When there is not enough memory for the pixels.
    pub fn downsampled(&self, factor: u32) -> Result<Self, SizeError> {
        let factor = factor.max(1);
        let Some(&color) = self.color.first() else { return Ok(self.clone()) };
        let mut picture = Self::new(self.width / factor, self.height / factor, color)?;
        let weight = 1.0 / (factor as f32 * factor as f32);
        let (from, to, n) = (self.width as usize, picture.width as usize, factor as usize);
        for (i, (color, depth)) in picture.color.iter_mut().zip(&mut picture.depth).enumerate() {
            let corner = i / to * n * from + i % to * n;
            let block = (0..n).flat_map(|row| (0..n).map(move |column| row * from + column));
            let mut block = block.map(|offset| corner + offset);
            let first = block.next().unwrap_or(corner);
            (*color, *depth) = (self.color[first] * weight, self.depth[first]);
            for pixel in block {
                *color = *color + self.color[pixel] * weight;
                *depth = depth.min(self.depth[pixel]);
            }
        }
        Ok(picture)
    }
}

/// A vector of `len` equal elements, if there is memory for it.
pub(crate) fn filled<T: Copy>(len: usize, value: T) -> Option<Vec<T>> {
    let mut elements = Vec::new();
    elements.try_reserve_exact(len).ok()?;
    elements.resize(len, value);
    Some(elements)
}

#[cfg(feature = "png")]
impl<C: crate::color::Color> Framebuffer<C> {
    /// Writes the picture to a PNG file of 8 bits a channel, sRGB with straight alpha.
    ///
    /// The file gets its name when it is whole, in place of one that had it before. After an error
    /// that one is as it was, or there is none.
    ///
    /// ```
    /// use glam::Vec3;
    /// use polyscan::Framebuffer;
    ///
    /// let grey = Framebuffer::new(320, 240, Vec3::splat(0.5))?;
    /// grey.save_png(std::env::temp_dir().join("grey.png"))?;
    ///
    /// let error = grey.save_png("no/such/folder/grey.png").unwrap_err();
    /// assert!(error.to_string().starts_with("cannot write no/such/folder/grey.png: "));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the folder is not there or may not be written to, or the disk is full. The error names
    /// the file.
    pub fn save_png(
        &self,
        path: impl AsRef<std::path::Path>,
    ) -> Result<(), crate::render::png_file::PngError> {
        let mut file = crate::render::png_file::PngFile::new(path, self.width, self.height)?;
        for row in self.color.chunks(self.width.max(1) as usize) {
            file.write_row(row)?;
        }
        file.finish()
    }
}

#[cfg(feature = "image")]
impl<C: crate::color::Color> Framebuffer<C> {
    /// The picture in 8 bits a channel, sRGB with straight alpha.
    #[must_use]
    pub fn to_image(&self) -> image::RgbaImage {
        image::RgbaImage::from_fn(self.width, self.height, |x, y| {
            let index = y as usize * self.width as usize + x as usize;
            image::Rgba(self.color[index].to_srgb8())
        })
    }
}

#[cfg(feature = "image")]
impl TryFrom<&image::RgbaImage> for Framebuffer<[u8; 4]> {
    type Error = SizeError;

    /// A framebuffer that shows a picture, to be drawn over.
    fn try_from(picture: &image::RgbaImage) -> Result<Self, SizeError> {
        let mut frame = Self::new(picture.width(), picture.height(), [0; 4])?;
        for (color, pixel) in frame.color.iter_mut().zip(picture.pixels()) {
            *color = pixel.0;
        }
        Ok(frame)
    }
}
