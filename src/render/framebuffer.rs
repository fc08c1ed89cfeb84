//! The framebuffer: a colour of any type and an f32 depth for each pixel.

use std::hint::black_box;
use std::ops::{Add, Mul, Range};

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::fragment::{HALF, LANES};
use crate::project::{Rect, SizeError, Viewport};
use crate::render::coarse_depth::CoarseDepth;
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;

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
    /// When a side is longer than [`MAX_SIZE`](crate::project::MAX_SIZE), or there is not enough
    /// memory for the pixels.
    pub fn new(width: u32, height: u32, color: C) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        let reason = "there is not enough memory for it; draw in tiles with `Viewport::at`";
        let error = SizeError { width, height, reason };
        let len = usize::try_from(u64::from(width) * u64::from(height)).map_err(|_| error)?;
        Ok(Self {
            width,
            height,
            color: filled(len, color).ok_or(error)?,
            depth: filled(len, 1.0).ok_or(error)?,
        })
    }

    /// The number of columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The viewport that covers the whole framebuffer.
    pub fn viewport(&self) -> Viewport {
        Viewport::whole(self.rect())
    }

    /// Fills the picture with a colour and a depth: 1.0 for depths that are nearer when smaller,
    /// 0.0 for those that are nearer when greater.
    pub fn clear(&mut self, color: C, depth: f32) {
        self.color.fill(color);
        self.depth.fill(depth);
    }

    /// The colours, row by row from the top.
    pub fn color(&self) -> &[C] {
        &self.color
    }

    /// The colours, to be changed.
    pub fn color_mut(&mut self) -> &mut [C] {
        &mut self.color
    }

    /// The depths, row by row from the top.
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// The depths, to be changed.
    pub fn depth_mut(&mut self) -> &mut [f32] {
        &mut self.depth
    }

    /// The colour and the depth of a pixel; `None` outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> Option<(C, f32)> {
        let index = (y as usize).checked_mul(self.width as usize)?.checked_add(x as usize)?;
        let inside = x < self.width && y < self.height;
        inside.then(|| self.color.get(index).copied().zip(self.depth.get(index).copied())).flatten()
    }

    pub(crate) fn rect(&self) -> Rect {
        Rect { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// All rows as one band.
    pub(crate) fn band(&mut self) -> Band<'_, C> {
        let corner = (0, 0);
        Band::new(corner, self.width as usize, &mut self.color, &mut self.depth)
    }

    /// Some rows, all of which it must have.
    pub(crate) fn band_of(&mut self, rows: Range<u32>) -> Band<'_, C> {
        let width = self.width as usize;
        let pixels = rows.start as usize * width..rows.end as usize * width;
        let (color, depth) = (&mut self.color[pixels.clone()], &mut self.depth[pixels]);
        Band::new((0, rows.start as i32), width, color, depth)
    }
}

impl<C: Copy + Send> Framebuffer<C> {
    /// The rows in bands of `height`, the last with those that are left. The framebuffer must have
    /// pixels.
    pub(crate) fn par_bands(
        &mut self,
        height: u32,
    ) -> impl IndexedParallelIterator<Item = Band<'_, C>> {
        let width = self.width as usize;
        let len = width * height as usize;
        let bands = self.color.par_chunks_mut(len).zip(self.depth.par_chunks_mut(len));
        bands.enumerate().map(move |(i, (color, depth))| {
            Band::new((0, i as i32 * height as i32), width, color, depth)
        })
    }
}

/// Some neighbouring rows of a framebuffer, or of a part of its columns.
#[derive(Debug)]
pub(crate) struct Band<'a, C> {
    /// The first row.
    pub(crate) first: i32,
    /// The first column.
    column: i32,
    width: usize,
    pub(crate) color: &'a mut [C],
    pub(crate) depth: &'a mut [f32],
    /// Pixels from the beginning of a cache line to the first depth. Memory is faster in whole
    /// lines.
    pub(crate) line_offset: usize,
    /// The coarse depths, where there are any.
    pub(crate) coarse: Option<&'a mut CoarseDepth>,
}

impl<'a, C> Band<'a, C> {
    /// A band whose top left pixel is the one at column and row `corner` of the framebuffer. Its
    /// slices hold whole rows of `width` pixels, which is not 0.
    pub(crate) fn new(
        (column, first): (i32, i32),
        width: usize,
        color: &'a mut [C],
        depth: &'a mut [f32],
    ) -> Self {
        let line_offset = depth.as_ptr().addr() / size_of::<f32>() % LANES;
        Self { first, column, width, color, depth, line_offset, coarse: None }
    }

    /// Where a row of the framebuffer begins in the band's slices.
    #[inline(always)]
    pub(crate) fn row(&self, y: i32) -> usize {
        (y - self.first) as usize * self.width
    }

    /// Where pixel (x, y) of the framebuffer is in the band's slices. If it is outside of the band, that
    /// is of use in sums only.
    #[inline(always)]
    pub(crate) fn index(&self, x: i32, y: i32) -> usize {
        let row = (y - self.first) as usize;
        row.wrapping_mul(self.width).wrapping_add((x - self.column) as usize)
    }

    /// How far a column of the framebuffer is from the left of the band.
    #[inline(always)]
    pub(crate) fn column(&self, x: i32) -> usize {
        (x - self.column) as usize
    }

    /// A copy of the pixels of half a block that begins at `at`, which may reach out of the band;
    /// `None` if the band has no pixels.
    #[cold]
    pub(crate) fn copy(&self, at: usize) -> Option<([C; HALF], [f32; HALF])>
    where
        C: Copy,
    {
        let any = *self.color.first()?;
        let place = |lane: usize| at.wrapping_add(lane);
        let color = |lane| self.color.get(place(lane)).copied().unwrap_or(any);
        let depth = |lane| self.depth.get(place(lane)).copied().unwrap_or(0.0);
        Some((std::array::from_fn(color), std::array::from_fn(depth)))
    }

    /// Puts back a copy that was changed.
    #[cold]
    pub(crate) fn put_back(&mut self, at: usize, colors: &[C; HALF], depths: &[f32; HALF])
    where
        C: Copy,
    {
        for lane in 0..HALF {
            let place = at.wrapping_add(lane);
            if let (Some(color), Some(depth)) =
                (self.color.get_mut(place), self.depth.get_mut(place))
            {
                (*color, *depth) = (colors[lane], depths[lane]);
            }
        }
    }

    /// Brings the pixels of some columns into the cache in their order, which is faster than from all
    /// over the band.
    pub(crate) fn read_through(&self, columns: &Range<usize>)
    where
        C: Copy,
    {
        const LINE: usize = 64;
        let colors_in_line = (LINE / size_of::<C>().max(1)).max(1);
        let row = |row: usize| row * self.width + columns.start..row * self.width + columns.end;
        for row in (0..self.rows().len()).map(row) {
            let depths = self.depth.get(row.clone()).unwrap_or_default();
            for depth in depths.iter().step_by(LINE / size_of::<f32>()) {
                black_box(*depth);
            }
            let colors = self.color.get(row).unwrap_or_default();
            for color in colors.iter().step_by(colors_in_line) {
                black_box(*color);
            }
        }
    }

    /// The number of columns.
    #[inline(always)]
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// The rows of the framebuffer that it holds.
    #[inline(always)]
    pub(crate) fn rows(&self) -> Range<i32> {
        self.first..self.first + (self.color.len() / self.width) as i32
    }
}

impl<C: Send> Band<'_, C> {
    /// The band in lower ones of `height` rows, the last with those that are left.
    pub(crate) fn par_bands(
        &mut self,
        height: u32,
    ) -> impl IndexedParallelIterator<Item = Band<'_, C>> {
        let Self { first, column, width, .. } = *self;
        let len = width * height as usize;
        let bands = self.color.par_chunks_mut(len).zip(self.depth.par_chunks_mut(len));
        bands.enumerate().map(move |(i, (color, depth))| {
            let first = first + i as i32 * height as i32;
            Band::new((column, first), width, color, depth)
        })
    }
}

impl<C: Copy + Add<Output = C> + Mul<f32, Output = C>> Framebuffer<C> {
    /// The picture at 1/`factor` of the width and height: each colour is the mean of a block of
    /// `factor` x `factor` pixels, each depth the least of the block. Drawn large and reduced, a
    /// picture in linear light is antialiased. Columns and rows that fill no block are left out; a
    /// factor of 0 counts as 1.
    ///
    /// # Errors
    /// When there is not enough memory for the pixels.
    pub fn reduced(&self, factor: u32) -> Result<Self, SizeError> {
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
fn filled<T: Copy>(len: usize, value: T) -> Option<Vec<T>> {
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
    pub fn save_png(&self, path: impl AsRef<std::path::Path>) -> Result<(), super::PngError> {
        let mut file = super::PngFile::new(path, self.width, self.height)?;
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
