//! The pixels of pictures, on all processors: their memory, means of samples, and bytes.

use polyscan::Framebuffer;
use polyscan::color::Color;
use polyscan::glam::Vec4;
use rayon::prelude::*;

/// So many pixels are one thread's at a time.
const PART: usize = 1 << 15;

/// A framebuffer whose memory all processors touch first, which takes a while.
pub(crate) fn framebuffer(
    (width, height): (u32, u32),
    background: Vec4,
) -> Result<Framebuffer<Vec4>, String> {
    fn filled<T: Copy + Send>(value: T, len: usize) -> Vec<T> {
        let mut list = Vec::new();
        rayon::iter::repeat_n(value, len).with_min_len(PART).collect_into_vec(&mut list);
        list
    }
    let len = width as usize * height as usize;
    let (colors, depths) = (filled(background, len), filled(1.0, len));
    Framebuffer::from_parts(width, colors, depths).map_err(|error| error.to_string())
}

/// Fills a framebuffer on all processors.
pub(crate) fn clear(frame: &mut Framebuffer<Vec4>, background: Vec4) {
    frame.color_mut().par_chunks_mut(PART).for_each(|colors| colors.fill(background));
    frame.depth_mut().par_chunks_mut(PART).for_each(|depths| depths.fill(1.0));
}

/// The mean of each block of `n` by `n` samples; `width` is that of the result.
pub(crate) fn average(samples: &[Vec4], (width, n): (usize, usize), means: &mut Vec<Vec4>) {
    let weight = 1.0 / (n * n) as f32;
    means.resize(samples.len() / (n * n), Vec4::ZERO);
    let blocks = samples.par_chunks_exact(width * n * n);
    means.par_chunks_exact_mut(width).zip(blocks).for_each(|(means, block)| {
        means.fill(Vec4::ZERO);
        for row in block.chunks_exact(width * n) {
            for (mean, samples) in means.iter_mut().zip(row.chunks_exact(n)) {
                *mean += samples.iter().sum::<Vec4>();
            }
        }
        for mean in means {
            *mean *= weight;
        }
    });
}

/// The bytes of pixels, four each: sRGB, and alpha.
pub(crate) fn encode(pixels: &[Vec4], bytes: &mut Vec<u8>) {
    let start = bytes.len();
    bytes.resize(start + 4 * pixels.len(), 0);
    encode_to(pixels, bytes[start..].as_chunks_mut().0, |code| code);
}

/// Fills a list with what is made of each pixel's bytes.
pub(crate) fn encode_to<T: Copy + Send>(
    pixels: &[Vec4],
    codes: &mut [T],
    of: impl Fn([u8; 4]) -> T + Sync,
) {
    /// So many pixels are one thread's at a time.
    const PART: usize = 4096;
    let parts = codes.par_chunks_mut(PART).zip(pixels.par_chunks(PART));
    parts.for_each(|(codes, pixels)| {
        // Many pixels are those before them once more: the background's.
        let mut last = pixels[0];
        let mut last_code = of(last.to_srgb8());
        for (code, &pixel) in codes.iter_mut().zip(pixels) {
            if pixel != last {
                (last, last_code) = (pixel, of(pixel.to_srgb8()));
            }
            *code = last_code;
        }
    });
}
