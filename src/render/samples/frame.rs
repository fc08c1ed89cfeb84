//! Memory for pictures of several samples a pixel, and the picture that they make.

use glam::{Vec2, Vec3, Vec4};

use crate::color::{Color, decode};
use crate::render::framebuffer::{Framebuffer, filled};
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
#[derive(Clone, Debug, PartialEq)]
pub struct MultisampleFramebuffer<C> {
    width: u32,
    height: u32,
    samples: Samples,
    /// Row by row from the top, in each row sample by sample, of each sample pixel by pixel, and
    /// then some of which nobody asks.
    color: Vec<C>,
    depth: Vec<f32>,
}

/// How many elements a row has for each sample, for so many columns: room for a block that begins at the
/// last, and for half a block beside it.
fn stride(width: u32) -> usize {
    const SPARE: usize = 32;
    if width == 0 { 0 } else { (width as usize + SPARE - 1).next_multiple_of(16) }
}

impl<C: Copy> MultisampleFramebuffer<C> {
    /// A framebuffer filled with a colour, its depth with 1.0, the depth of the far plane.
    ///
    /// # Errors
    /// As [`Framebuffer::new`]; it takes as much memory as there are samples times that.
    pub fn new(width: u32, height: u32, samples: Samples, color: C) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        let reason = "there is not enough memory for its samples; draw in tiles with \
                      `Viewport::with_corner`, or with fewer samples";
        let error = SizeError::new(width, height, reason);
        let len = stride(width).checked_mul(samples.count() * height as usize).ok_or(error)?;
        let (color, depth) = (filled(len, color).ok_or(error)?, filled(len, 1.0).ok_or(error)?);
        Ok(Self { width, height, samples, color, depth })
    }

    /// Fills the picture with a colour and a depth: the
    /// [farthest](crate::DepthMode::farthest), which is 1.0 unless depth is reversed or 1/w.
    pub fn clear(&mut self, color: C, depth: f32) {
        self.color.fill(color);
        self.depth.fill(depth);
    }

    /// The colour and the depth of a sample of a pixel, by its number in
    /// [`Samples::places`]; `None` if there is no such sample.
    #[must_use]
    pub fn sample(&self, x: u32, y: u32, sample: usize) -> Option<(C, f32)> {
        let is_there = x < self.width && y < self.height && sample < self.samples.count();
        let row = y as usize * self.samples.count() + sample;
        let at = row * self.stride() + x as usize;
        is_there.then(|| self.color.get(at).copied().zip(self.depth.get(at).copied())).flatten()
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

    /// How many elements are between two samples of a pixel.
    pub(crate) fn stride(&self) -> usize {
        stride(self.width)
    }

    /// Colours and depths.
    pub(crate) fn memory(&mut self) -> (&mut [C], &mut [f32]) {
        (&mut self.color, &mut self.depth)
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
        let (stride, count) = (self.stride(), self.samples.count());
        let start = row * stride * count;
        let mut samples = [self.color[start]; MOST_SAMPLES];
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let places = (start + x..).step_by(stride);
            for (sample, at) in samples[..count].iter_mut().zip(places.clone()) {
                *sample = self.color[at];
            }
            *color = C::average(&samples[..count]);
            *depth = places.take(count).map(|at| self.depth[at]).fold(f32::INFINITY, f32::min);
        }
    }
}
