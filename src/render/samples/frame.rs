//! Memory for pictures of several samples a pixel, and the picture that they make.

use std::ops::{Deref, DerefMut};

use glam::{Vec2, Vec3, Vec4};

use crate::color::{Color, decode};
use crate::fragment::LANES;
use crate::render::framebuffer::{Framebuffer, filled};
use crate::render::mesh::bins::BAND;
use crate::render::parallel::for_each_part;
use crate::render::samples::pattern::Samples;
use crate::render::shader::MOST_SAMPLES;
use crate::viewport::{Rect, SizeError, Viewport};

/// A colour of which a pixel's can be found from its samples'.
///
/// Linear light is averaged as it is: numbers, `glam` vectors, arrays of `f32`. `[u8; 4]`, sRGB with straight
/// alpha, is decoded, averaged as light premultiplied by alpha, and encoded again.
///
/// ```
/// use polyscan::render::Average;
///
/// // Half the light of white; and half covered white is white of half the alpha, without a dark fringe.
/// assert_eq!(<[u8; 4]>::average(&[[0, 0, 0, 255], [255; 4]]), [188, 188, 188, 255]);
/// assert_eq!(<[u8; 4]>::average(&[[0; 4], [255; 4]]), [255, 255, 255, 128]);
/// ```
pub trait Average: Copy {
    /// The mean of one or more colours; of equal ones, the same.
    #[must_use]
    fn average(colors: &[Self]) -> Self;
}

/// The mean of numbers, added in pairs, so that the mean of equal ones is exact.
fn mean<T: Copy>(
    values: &[T],
    add: impl Fn(T, T) -> T + Copy,
    scale: impl Fn(T, f32) -> T + Copy,
) -> Option<T> {
    let sum = sum(values, add)?;
    Some(scale(sum, 1.0 / values.len() as f32))
}

fn sum<T: Copy>(values: &[T], add: impl Fn(T, T) -> T + Copy) -> Option<T> {
    match values {
        [] => None,
        [value] => Some(*value),
        _ => {
            let (a, b) = values.split_at(values.len() / 2);
            Some(add(sum(a, add)?, sum(b, add)?))
        }
    }
}

macro_rules! averaged_as_it_is {
    ($($color:ty: $zero:expr),*) => {$(
        impl Average for $color {
            #[inline]
            fn average(colors: &[Self]) -> Self {
                mean(colors, |a, b| a + b, |sum, scale| sum * scale).unwrap_or($zero)
            }
        }
    )*};
}

averaged_as_it_is!(f32: 0.0, Vec2: Vec2::ZERO, Vec3: Vec3::ZERO, Vec4: Vec4::ZERO);

impl<const K: usize> Average for [f32; K] {
    #[inline]
    fn average(colors: &[Self]) -> Self {
        let add = |a: Self, b: Self| std::array::from_fn(|i| a[i] + b[i]);
        mean(colors, add, |sum, scale| sum.map(|value| value * scale)).unwrap_or([0.0; K])
    }
}

impl Average for [u8; 4] {
    #[inline]
    fn average(colors: &[Self]) -> Self {
        match colors {
            [] => [0; 4],
            [first, rest @ ..] if rest.iter().all(|color| color == first) => *first,
            _ => average_srgb8(colors),
        }
    }
}

#[inline(never)]
fn average_srgb8(colors: &[[u8; 4]]) -> [u8; 4] {
    let light = colors.iter().map(|&[r, g, b, a]| {
        let alpha = f32::from(a) / 255.0;
        (Vec3::new(decode(r), decode(g), decode(b)) * alpha).extend(alpha)
    });
    (light.sum::<Vec4>() / colors.len() as f32).to_srgb8()
}

/// A picture with several samples a pixel, each with a colour and an f32 depth, to be drawn by a
/// [`MultisampleRenderer`](crate::render::MultisampleRenderer) and then [resolved](Self::resolve).
#[derive(Clone, Debug)]
pub struct MultisampleFramebuffer<C> {
    width: u32,
    height: u32,
    samples: Samples,
    /// In [bands](BAND) of rows from the top, in each band sample by sample, of each sample row by row, and
    /// then some of which nobody asks. So first samples, which are all that there is of most pixels, fill pages of
    /// memory by themselves.
    color: CacheLines<C>,
    depth: CacheLines<f32>,
    /// Row by row, for each 16 pixels of a row one.
    tiles: Vec<Tile>,
}

/// What is known of [`LANES`] neighbouring pixels of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Whether all samples of each pixel show the same polygon. Then the first sample's colour is that
    /// of all, and its depth that of the pixel's centre; what is kept of the other samples means nothing.
    pub(crate) is_whole: bool,
    /// The change of depth per pixel to the right and downwards, if it is whole.
    pub(crate) change: [f32; 2],
}

impl Tile {
    pub(crate) const CLEAR: Self = Self { is_whole: true, change: [0.0; 2] };

    /// How much more or less the depth is at most at any place in a pixel than at its centre.
    #[inline(always)]
    pub(crate) fn reach(change: [f32; 2]) -> f32 {
        change[0].abs() * 0.5 + change[1].abs() * 0.5
    }

    /// How much more the depth is at a place than at the pixel's centre.
    #[inline(always)]
    pub(crate) fn change_at(change: [f32; 2], [x, y]: [f32; 2]) -> f32 {
        change[0] * x + change[1] * y
    }
}

/// Elements the first of which is at the beginning of a cache line, if their size allows it: blocks of [`LANES`] then lie
/// in whole lines. A copy need not.
#[derive(Clone, Debug)]
struct CacheLines<T> {
    elements: Vec<T>,
    /// How many there are before the first.
    before: usize,
}

impl<T: Copy> CacheLines<T> {
    fn new(len: usize, value: T) -> Option<Self> {
        const LINE: usize = 64;
        let size = size_of::<T>().max(1);
        let elements = filled(len.checked_add(LINE / size)?, value)?;
        let after = elements.as_ptr().addr() % LINE;
        let before = (0..LINE / size).find(|before| (after + before * size).is_multiple_of(LINE));
        Some(Self { elements, before: before.unwrap_or(0) })
    }
}

impl<T> Deref for CacheLines<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.elements[self.before..]
    }
}

impl<T> DerefMut for CacheLines<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.elements[self.before..]
    }
}

/// How many elements a row has for each sample, for so many columns: room for a block that begins at the
/// last, for half a block beside it, and for what samples are moved by.
fn stride(width: u32, samples: Samples) -> usize {
    const SPARE: usize = 31;
    let moves = (samples.count().min(MOVED) - 1) * LANES;
    if width == 0 { 0 } else { (width as usize + SPARE + moves).next_multiple_of(LANES) }
}

/// Samples that are moved by a cache line each against the one before, so that those of a pixel are not in the
/// same part of the cache.
const MOVED: usize = 8;

/// Where a sample of a pixel is, from the first one on, where each has so many elements in a band.
#[inline(always)]
pub(crate) fn offset(sample: usize, plane: usize) -> usize {
    sample * plane + sample % MOVED * LANES
}

impl<C: Copy> MultisampleFramebuffer<C> {
    /// A framebuffer filled with a colour, its depth with 1.0, the depth of the far plane.
    ///
    /// # Errors
    /// As [`Framebuffer::new`]; it takes as much memory as there are samples times that, and up to 128 pixels more a row.
    pub fn new(width: u32, height: u32, samples: Samples, color: C) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        let reason = "there is not enough memory for its samples; draw in tiles with \
                      `Viewport::with_corner`, or with fewer samples";
        let error = SizeError::new(width, height, reason);
        let stride = stride(width, samples);
        let len = stride.checked_mul(samples.count() * height as usize).ok_or(error)?;
        let color = CacheLines::new(len, color).ok_or(error)?;
        let depth = CacheLines::new(len, 1.0).ok_or(error)?;
        let tiles = stride / LANES * height as usize;
        let tiles = filled(tiles, Tile::CLEAR).ok_or(error)?;
        Ok(Self { width, height, samples, color, depth, tiles })
    }

    /// Fills the picture with a colour and a depth: the
    /// [farthest](crate::DepthMode::farthest), which is 1.0 unless depth is reversed or 1/w.
    pub fn clear(&mut self, color: C, depth: f32) {
        for band in (0..self.height as usize).step_by(BAND as usize) {
            let (first, plane) = self.first_sample(band, 0);
            self.color[first..first + plane].fill(color);
            self.depth[first..first + plane].fill(depth);
        }
        self.tiles.fill(Tile::CLEAR);
    }

    /// The colour and the depth of a sample of a pixel, by its number in
    /// [`Samples::places`]; `None` if there is no such sample.
    #[must_use]
    pub fn sample(&self, x: u32, y: u32, sample: usize) -> Option<(C, f32)> {
        let is_there = x < self.width && y < self.height && sample < self.samples.count();
        is_there.then(|| self.sample_at(y as usize, x as usize, sample))
    }

    /// A sample that is there.
    #[inline(always)]
    fn sample_at(&self, row: usize, x: usize, sample: usize) -> (C, f32) {
        let tile = self.tiles[row * (self.stride() / LANES) + x / LANES];
        let (at, plane) = self.first_sample(row, x);
        if tile.is_whole {
            let place = self.samples.in_pixels()[sample];
            return (self.color[at], self.depth[at] + Tile::change_at(tile.change, place));
        }
        let at = at + offset(sample, plane);
        (self.color[at], self.depth[at])
    }
}

impl<C: Copy + PartialEq> PartialEq for MultisampleFramebuffer<C> {
    /// Whether all samples have the same colours and depths.
    fn eq(&self, other: &Self) -> bool {
        let size = |frame: &Self| (frame.width, frame.height, frame.samples);
        let mut rows = 0..self.height as usize;
        size(self) == size(other)
            && rows.all(|row| {
                (0..self.width as usize).all(|x| {
                    let mut samples = 0..self.samples.count();
                    samples.all(|sample| {
                        self.sample_at(row, x, sample) == other.sample_at(row, x, sample)
                    })
                })
            })
    }
}

impl<C> MultisampleFramebuffer<C> {
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

    /// How many samples a pixel has.
    #[must_use]
    pub fn samples(&self) -> Samples {
        self.samples
    }

    /// The viewport that covers the whole framebuffer.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        Viewport::whole(self.rect())
    }

    pub(crate) fn rect(&self) -> Rect {
        Rect { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// How many elements a row has for each sample.
    pub(crate) fn stride(&self) -> usize {
        stride(self.width, self.samples)
    }

    /// Where the first sample of a pixel is, and how many elements each sample has in that band.
    #[inline(always)]
    fn first_sample(&self, row: usize, x: usize) -> (usize, usize) {
        let (stride, in_band) = (self.stride(), row % BAND as usize);
        let rows = (self.height as usize - (row - in_band)).min(BAND as usize);
        let start = (row - in_band) * self.samples.count() * stride;
        (start + in_band * stride + x, rows * stride)
    }

    /// Colours, tiles and depths.
    pub(crate) fn memory(&mut self) -> (&mut [C], &mut [Tile], &mut [f32]) {
        (&mut self.color, &mut self.tiles, &mut self.depth)
    }
}

impl<C: Average + Send + Sync> MultisampleFramebuffer<C> {
    /// The picture that the samples make: each colour is the [mean](Average) of its samples', each depth the
    /// least.
    ///
    /// # Errors
    /// When there is not enough memory for the pixels.
    pub fn resolve(&self) -> Result<Framebuffer<C>, SizeError> {
        let (width, height) = (self.width, self.height);
        let Some(&first) = self.color.first() else {
            let error = SizeError::new(width, height, "a picture without pixels has no colour");
            let empty = Framebuffer::from_parts(width, Vec::new(), Vec::new());
            return empty.map_err(|_| error);
        };
        let reason = "there is not enough memory for it";
        let error = SizeError::new(width, height, reason);
        let len = width as usize * height as usize;
        let mut color = filled(len, first).ok_or(error)?;
        let mut depth = filled(len, 1.0).ok_or(error)?;
        let parts = (&mut color[..], width as usize);
        for_each_part(parts, (&mut depth, width as usize), |row, colors, depths| {
            self.resolve_row(row, colors, depths);
        });
        Framebuffer::from_parts(width, color, depth).map_err(|_| error)
    }

    fn resolve_row(&self, row: usize, colors: &mut [C], depths: &mut [f32]) {
        let count = self.samples.count();
        let (stride, (start, plane)) = (self.stride(), self.first_sample(row, 0));
        let mut samples = [self.color[start]; MOST_SAMPLES];
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let least = (0..count).map(|sample| self.sample_at(row, x, sample).1);
            *depth = least.fold(f32::INFINITY, f32::min);
            if self.tiles[row * (stride / LANES) + x / LANES].is_whole {
                *color = self.color[start + x];
                continue;
            }
            for (sample, color) in samples[..count].iter_mut().enumerate() {
                *color = self.color[start + x + offset(sample, plane)];
            }
            *color = C::average(&samples[..count]);
        }
    }
}
