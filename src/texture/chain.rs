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

use crate::render::parallel::for_each;
use crate::texture::cutout::Cutout;
use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::light::{to_byte, to_f16, to_srgb8, to_srgb16, to_word};
use crate::texture::texels::{Texels, with_texels};

/// The texels of a level before they are rounded to a format.
struct Means {
    size: (u32, u32),
    texels: Vec<Vec4>,
}

/// The texture's texels with those of all smaller levels after them, perhaps with the alpha of cut-outs.
pub(super) fn with_chain(
    mut texels: Texels,
    cutout: Option<Cutout>,
) -> Result<Texels, TextureError> {
    let covered = cutout.map(|cutout| {
        let size = (texels.base().width, texels.base().height);
        let part = with_texels!(&texels, texels.base(), base => {
            cutout.coverage(size, 1.0, |x, y| base.get(x, y).unwrap_or_default())
        });
        (cutout, part)
    });
    let mut before: Option<Means> = None;
    let mut size = (texels.base().width, texels.base().height);
    texels.drop_smaller();
    texels.reserve_chain()?;
    while size != (1, 1) {
        let smaller = (half(size.0), half(size.1));
        let means = match &before {
            None => with_texels!(&texels, texels.base(), base => {
                reduced(size, smaller, |x, y| base.get(x, y).unwrap_or_default())?
            }),
            Some(Means { texels, .. }) => reduced(size, smaller, |x, y| {
                texels.get(y as usize * size.0 as usize + x as usize).copied().unwrap_or_default()
            })?,
        };
        let channels = texels.channels();
        let changed = covered.map(|(cutout, part)| cutout.scaled(means.size, part, &means.texels));
        let kept = changed.as_ref().unwrap_or(&means.texels);
        texels.push_level(means.size, |samples| push(samples, channels, kept));
        before = Some(means);
        size = smaller;
    }
    Ok(texels)
}

/// The next smaller size.
fn half(size: u32) -> u32 {
    (size / 2).max(1)
}

/// A picture of another size; `texel` gives those of the old one.
fn reduced(
    old: (u32, u32),
    size: (u32, u32),
    texel: impl Fn(u32, u32) -> Vec4 + Sync,
) -> Result<Means, TextureError> {
    let (width, height) = size;
    let mut texels = Vec::new();
    texels
        .try_reserve_exact(width as usize * height as usize)
        .map_err(|_| TextureError::Memory { width, height, bytes_per_texel: 16 })?;
    texels.resize(width as usize * height as usize, Vec4::ZERO);
    let band = |number: usize, texels: &mut [Vec4]| {
        let rows = ((number * BAND) as u32..).zip(texels.chunks_exact_mut(width as usize));
        if old == (2 * width, 2 * height) {
            for (y, row) in rows {
                for (x, mean) in (0..).zip(row) {
                    // Halves are exact, so these are the sums of the parts.
                    let column = |x| (texel(x, 2 * y) + texel(x, 2 * y + 1)) * 0.5;
                    *mean = (column(2 * x) + column(2 * x + 1)) * 0.5;
                }
            }
            return;
        }
        let mut sum = vec![Vec4::ZERO; old.0 as usize];
        for (y, row) in rows {
            sum.fill(Vec4::ZERO);
            for (from, weight) in Parts::of(y, old.1, height) {
                (0..).zip(&mut sum).for_each(|(x, sum)| *sum += texel(x, from) * weight);
            }
            reduce_row(&sum, row);
        }
    };
    let mut bands: Vec<_> = texels.chunks_mut(BAND * width as usize).collect();
    for_each(&mut bands, |number, texels| band(number, texels));
    Ok(Means { size, texels })
}

/// The rows that a thread makes at a time.
const BAND: usize = 64;

/// Means along a row.
fn reduce_row(sum: &[Vec4], row: &mut [Vec4]) {
    if sum.len() == 2 * row.len() {
        for (texel, [left, right]) in row.iter_mut().zip(sum.as_chunks().0) {
            *texel = (*left + *right) * 0.5;
        }
        return;
    }
    let (old, new) = (sum.len() as u32, row.len() as u32);
    for (x, texel) in (0..).zip(row) {
        *texel = Parts::of(x, old, new)
            .map(|(from, weight)| sum[from as usize] * weight)
            .fold(Vec4::ZERO, |sum, part| sum + part);
    }
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

/// Adds texels to samples of a format.
fn push(samples: &mut Samples, channels: usize, texels: &[Vec4]) {
    match samples {
        Samples::Srgb8(list) => append(list, channels, texels, to_srgb8),
        Samples::Srgb16(list) => append(list, channels, texels, to_srgb16),
        Samples::Unorm8(list) => append(list, channels, texels, |t| t.to_array().map(to_byte)),
        Samples::Unorm16(list) => append(list, channels, texels, |t| t.to_array().map(to_word)),
        Samples::F16(list) => append(list, channels, texels, |t| t.to_array().map(to_f16)),
        Samples::F32(list) => append(list, channels, texels, |t| t.to_array()),
    }
}

/// Adds the channels of texels that are kept: grey is red.
fn append<T: Copy + Default + Send>(
    list: &mut Vec<T>,
    channels: usize,
    texels: &[Vec4],
    samples: impl Fn(Vec4) -> [T; 4] + Sync,
) {
    /// The texels that a thread takes at a time.
    const PART: usize = 1 << 14;
    let start = list.len();
    list.resize(start + texels.len() * channels, T::default());
    let convert = |(list, texels): &mut (&mut [T], &[Vec4])| {
        for (kept, texel) in list.chunks_exact_mut(channels).zip(*texels) {
            let [r, g, b, alpha] = samples(*texel);
            match kept {
                [x] => *x = r,
                [x, y] => (*x, *y) = (r, alpha),
                [x, y, z] => (*x, *y, *z) = (r, g, b),
                _ => kept.copy_from_slice(&[r, g, b, alpha]),
            }
        }
    };
    let parts = list[start..].chunks_mut(PART * channels).zip(texels.chunks(PART));
    for_each(&mut parts.collect::<Vec<_>>(), |_, part| convert(part));
}
