//! Supersampling: pictures whose pixels are means of many samples, each shaded by itself.
//!
//! It is the slow and sure way to a picture without aliases, whatever a shader computes, and what the filters of
//! textures are compared with. Two calls draw with whatever draws to a [`Framebuffer`]:
//!
//! - [`Framebuffer::supersampled_by_grid`]: k by k samples, those of a picture k times as large;
//! - [`Framebuffer::supersampled_by_points`]: any number, well distributed.

use std::ops::{Add, Mul};

use glam::{Mat4, Vec3};

use crate::render::framebuffer::Framebuffer;
use crate::viewport::{SizeError, Viewport};

/// So many samples are drawn at a time, but for pictures whose one row has more.
const STRIP: u64 = 1 << 22;

impl<C: Copy + Add<Output = C> + Mul<f32, Output = C>> Framebuffer<C> {
    /// A picture each pixel of which is the mean of `k` by `k` samples: what
    /// [`downsampled`](Self::downsampled) makes of a picture `k` times as wide and as high, to the bit, but in
    /// the memory of a part of it.
    ///
    /// `draw` is called several times, for strips from top to bottom. It gets a framebuffer that has been cleared
    /// to `clear`, with the depth 1, and the viewport to draw to. A pixel there is a sample here, so that
    /// [footprints](crate::Fragment::footprint) are those of samples. A `k` of 0 counts as 1.
    ///
    /// ```
    /// use glam::{Vec3, vec4};
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// // The left third of a pixel.
    /// let quad = [(-1.0, 1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (-1.0, -1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
    /// let picture = Framebuffer::supersampled_by_grid((1, 1), 3, Vec3::ZERO, |frame, viewport| {
    ///     ZBufferRenderer::new(viewport).draw(frame, &quad, |_| Vec3::ONE);
    /// })?;
    /// assert!((picture.color()[0].x - 1.0 / 3.0).abs() < 1e-6);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    ///
    /// # Errors
    /// When a side of the large picture is above [`MAX_SIZE`](crate::viewport::MAX_SIZE), or there is not enough
    /// memory for a strip of it.
    pub fn supersampled_by_grid(
        (width, height): (u32, u32),
        k: u32,
        clear: C,
        mut draw: impl FnMut(&mut Self, Viewport),
    ) -> Result<Self, SizeError> {
        let k = k.max(1);
        let (wide, high) = (width.saturating_mul(k), height.saturating_mul(k));
        let viewport = Viewport::new(wide, high)?;
        let mut picture = Self::new(width, height, clear)?;
        let row = u64::from(wide) * u64::from(k);
        let rows = (STRIP / row.max(1)).clamp(1, u64::from(height).max(1)) as u32;
        let mut strip = Self::new(wide, rows * k, clear)?;
        for top in (0..height).step_by(rows as usize) {
            strip.clear(clear, 1.0);
            draw(&mut strip, viewport.with_corner(0, -((top * k) as i32)));
            let means = strip.downsampled(k)?;
            let (start, len) = (top as usize * width as usize, rows.min(height - top) * width);
            let (start, len) = (start, len as usize);
            picture.color_mut()[start..start + len].copy_from_slice(&means.color()[..len]);
            picture.depth_mut()[start..start + len].copy_from_slice(&means.depth()[..len]);
        }
        Ok(picture)
    }

    /// A picture each pixel of which is the mean of `count` samples that fill it evenly: Hammersley's points
    /// (Wong, Luk and Heng, "Sampling with Hammersley and Halton Points", 1997), the same in each pixel.
    ///
    /// `draw` is called `count` times, each time for one sample of all pixels. It gets a framebuffer that has
    /// been cleared to `clear`, with the depth 1, and a matrix, by which all positions in clip space are to be
    /// multiplied: it moves the picture by a part of a pixel. [Footprints](crate::Fragment::footprint) are
    /// those of whole pixels; a shader that is to be averaged samples its textures at points, by
    /// [`Texture::sample`](crate::Texture::sample). A count of 0 counts as 1, which is the pixels' centres. Depths
    /// are the least of the samples'.
    ///
    /// ```
    /// use glam::{Vec3, vec4};
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// // Half a pixel, cut along its diagonal.
    /// let triangle = [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| vec4(x, y, 0.5, 1.0));
    /// let picture = Framebuffer::supersampled_by_points((1, 1), 300, Vec3::ZERO, |frame, moved| {
    ///     let triangle = triangle.map(|position| Vertex::new(moved * position, []));
    ///     ZBufferRenderer::new(frame.viewport()).draw(frame, &triangle, |_| Vec3::ONE);
    /// })?;
    /// assert!((picture.color()[0].x - 0.5).abs() < 0.01);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    ///
    /// # Errors
    /// When a side is above [`MAX_SIZE`](crate::viewport::MAX_SIZE), or there is not enough memory for two pictures.
    pub fn supersampled_by_points(
        (width, height): (u32, u32),
        count: u32,
        clear: C,
        mut draw: impl FnMut(&mut Self, Mat4),
    ) -> Result<Self, SizeError> {
        let count = count.max(1);
        let weight = 1.0 / count as f32;
        let mut mean = Self::new(width, height, clear)?;
        let mut sample = Self::new(width, height, clear)?;
        for i in 0..count {
            if i > 0 {
                sample.clear(clear, 1.0);
            }
            let [x, y] = hammersley(i, count);
            // A sample to the right of the centre sees what is further right: the picture moves to the left.
            let by = [(0.5 - x) / f64::from(width), (y - 0.5) / f64::from(height)];
            let [x, y] = by.map(|part| (2.0 * part) as f32);
            draw(&mut sample, Mat4::from_translation(Vec3::new(x, y, 0.0)));
            for (mean, sample) in mean.color_mut().iter_mut().zip(sample.color()) {
                *mean = if i == 0 { *sample * weight } else { *mean + *sample * weight };
            }
            for (least, depth) in mean.depth_mut().iter_mut().zip(sample.depth()) {
                *least = least.min(*depth);
            }
        }
        Ok(mean)
    }
}

/// Point `i` of `count`, in the unit square: evenly spaced along x, and along y the bits of `i` mirrored at the
/// point, moved so that a single one is in the middle.
fn hammersley(i: u32, count: u32) -> [f64; 2] {
    let part = 1.0 / f64::from(count);
    let mirrored = f64::from(i.reverse_bits()) / 4_294_967_296.0;
    let y = mirrored + 0.5 * part;
    [(f64::from(i) + 0.5) * part, if y < 1.0 { y } else { y - 1.0 }]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part of the points in a box from the corner is its area, to within what the points can tell.
    #[test]
    fn points_fill_the_square_evenly() {
        assert_eq!(hammersley(0, 1), [0.5, 0.5]);
        for count in [4, 16, 60, 256, 511, 512] {
            let points: Vec<_> = (0..count).map(|i| hammersley(i, count)).collect();
            let most = (f64::from(count).log2() + 2.0) / f64::from(count);
            for (x, y) in (1..=40).flat_map(|x| (1..=40).map(move |y| (x, y))) {
                let (x, y) = (f64::from(x) / 40.0, f64::from(y) / 40.0);
                let inside = points.iter().filter(|p| p[0] < x && p[1] < y).count();
                let error = (inside as f64 / f64::from(count) - x * y).abs();
                assert!(error <= most, "{count}: {x} {y} {error}");
            }
        }
    }
}
