//! Mip chains: a picture in ever smaller sizes (Williams, "Pyramidal Parametrics", SIGGRAPH 1983).
//!
//! Each level has half the width and half the height of the one before, rounded down, and at least 1. A
//! texel of a level is the mean of the area that it covers on the one before: of n texels made m, texel i
//! covers [i n/m, (i+1) n/m). Of an odd number those are three, two of them in part:
//!
//! ```text
//!     n = 7    |---0---|---1---|---2---|---3---|---4---|---5---|---6---|
//!     m = 3    |---------0--------|--------1---------|--------2--------|
//! ```
//!
//! So every texel weighs the same, and the mean of a picture is that of all its levels, whatever its size.
//! Means are taken in linear light, premultiplied by alpha, of `f32`s from level to level; each is rounded
//! once to the texture's own format.

use glam::Vec4;

use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::light::{to_byte, to_f16, to_srgb8, to_srgb16, to_word};
use crate::texture::texels::{Fetch, LevelTexels, Texels, with_texels};

/// The texels of a level before they are rounded to a format.
struct Means {
    size: (u32, u32),
    texels: Vec<Vec4>,
}

/// The texture's texels with those of all smaller levels after them.
pub(super) fn with_chain(mut texels: Texels) -> Result<Texels, TextureError> {
    let mut before: Option<Means> = None;
    let mut size = (texels.base().width, texels.base().height);
    texels.drop_smaller();
    while size != (1, 1) {
        let smaller = (half(size.0), half(size.1));
        let means = match &before {
            None => with_texels!(&texels, texels.base(), base => {
                reduced(size, smaller, |y, row| decode_row(&base, y, row))?
            }),
            Some(Means { texels, .. }) => reduced(size, smaller, |y, row| {
                let start = y as usize * size.0 as usize;
                row.copy_from_slice(&texels[start..start + size.0 as usize]);
            })?,
        };
        let channels = texels.channels();
        texels.push_level(means.size, |samples| {
            means.texels.iter().for_each(|&texel| push(samples, channels, texel));
        })?;
        before = Some(means);
        size = smaller;
    }
    Ok(texels)
}

/// The next smaller size.
fn half(size: u32) -> u32 {
    (size / 2).max(1)
}

fn decode_row(base: &LevelTexels<impl Fetch>, y: u32, row: &mut [Vec4]) {
    for (x, texel) in row.iter_mut().enumerate() {
        *texel = base.get(x as u32, y).unwrap_or_default();
    }
}

/// A picture of another size, whose rows are asked for from top to bottom.
fn reduced(
    (width, height): (u32, u32),
    size: (u32, u32),
    row: impl Fn(u32, &mut [Vec4]),
) -> Result<Means, TextureError> {
    let out_of_memory = |_| TextureError::Memory { width, height, bytes_per_texel: 16 };
    let mut texels = Vec::new();
    texels.try_reserve_exact(size.0 as usize * size.1 as usize).map_err(out_of_memory)?;
    let mut rows = vec![Vec4::ZERO; 2 * width as usize];
    let (sum, one) = rows.split_at_mut(width as usize);
    for y in 0..size.1 {
        sum.fill(Vec4::ZERO);
        for (from, weight) in Parts::of(y, height, size.1) {
            row(from, one);
            for (sum, texel) in sum.iter_mut().zip(&*one) {
                *sum += *texel * weight;
            }
        }
        texels.extend((0..size.0).map(|x| {
            Parts::of(x, width, size.0)
                .map(|(from, weight)| sum[from as usize] * weight)
                .fold(Vec4::ZERO, |sum, part| sum + part)
        }));
    }
    Ok(Means { size, texels })
}

/// The texels of a line of n that texel i of m covers, and their weights, whose sum is 1; m is n / 2
/// rounded down, or 1.
struct Parts {
    next: u32,
    end: u32,
    first: u32,
    weights: [f32; 3],
}

impl Parts {
    fn of(i: u32, n: u32, m: u32) -> Self {
        let part = |count: u32| (f64::from(count) / f64::from(n)) as f32;
        let (count, weights) = match n - 2 * m.min(n / 2) {
            0 => (2, [0.5, 0.5, 0.0]),
            // From i n/m = 2 i + i/m on, as far as 2 i + 2 + (i+1)/m, in parts of n/m.
            _ if n > 1 => (3, [part(m - i), part(m), part(i + 1)]),
            _ => (1, [1.0, 0.0, 0.0]),
        };
        let first = 2 * i;
        Self { next: first, end: first + count, first, weights }
    }
}

impl Iterator for Parts {
    type Item = (u32, f32);

    #[inline]
    fn next(&mut self) -> Option<(u32, f32)> {
        let i = self.next;
        self.next += 1;
        (i < self.end).then(|| (i, self.weights[(i - self.first) as usize % 3]))
    }
}

/// Adds a texel to samples of a format.
fn push(samples: &mut Samples, channels: usize, texel: Vec4) {
    /// The channels that are kept: grey is red.
    fn kept<T: Copy>(list: &mut Vec<T>, channels: usize, [r, g, b, alpha]: [T; 4]) {
        match channels {
            1 => list.push(r),
            2 => list.extend([r, alpha]),
            3 => list.extend([r, g, b]),
            _ => list.extend([r, g, b, alpha]),
        }
    }
    match samples {
        Samples::Srgb8(list) => kept(list, channels, to_srgb8(texel)),
        Samples::Srgb16(list) => kept(list, channels, to_srgb16(texel)),
        Samples::Unorm8(list) => kept(list, channels, texel.to_array().map(to_byte)),
        Samples::Unorm16(list) => kept(list, channels, texel.to_array().map(to_word)),
        Samples::F16(list) => kept(list, channels, texel.to_array().map(to_f16)),
        Samples::F32(list) => kept(list, channels, texel.to_array()),
    }
}
