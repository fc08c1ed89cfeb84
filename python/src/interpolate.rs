//! Attributes of vertices at pixels, by barycentrics.

use numpy::{PyArray1, PyArray2, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::threads::work;

/// Pixels that a thread does at a time.
const PART: usize = 4096;

/// Fills `out`, `channels` numbers a pixel, with the attributes (n, channels) of the corners of each pixel's face,
/// weighted by `weights`: 3 numbers a pixel, or 3 * 2 for the two derivatives, which `out` then has pairs of.
/// `corners` are those of each face, or those of each pixel. Pixels without a face are left as they are.
#[pyfunction]
pub(crate) fn interpolate<'py>(
    py: Python<'py>,
    attributes: &Bound<'py, PyArray2<f32>>,
    corners: (Bound<'py, PyArray2<u32>>, bool),
    face: &Bound<'py, PyArray1<i32>>,
    weights: (Bound<'py, PyArray1<f32>>, bool),
    out: &Bound<'py, PyArray1<f32>>,
    threads: Option<usize>,
) -> PyResult<()> {
    let (weights, is_derivative) = weights;
    let (corners, are_of_pixels) = corners;
    let (attributes, corners) = (attributes.try_readonly()?, corners.try_readonly()?);
    let (face, weights) = (face.try_readonly()?, weights.try_readonly()?);
    let mut out = out.try_readwrite()?;
    let channels = attributes.shape()[1];
    let corners = Corners {
        attributes: attributes.as_slice()?,
        channels,
        corners: corners.as_slice()?.as_chunks().0,
        are_of_pixels,
    };
    let (face, weights, out) = (face.as_slice()?, weights.as_slice()?, out.as_slice_mut()?);
    if channels == 0 {
        return Ok(());
    }
    work(py, threads, || {
        if is_derivative {
            let out = out.as_chunks_mut::<2>().0;
            let weights = weights.as_chunks::<2>().0.as_chunks::<3>().0;
            corners.fill(face, weights, out, |[a, b, c], [d, e, f]| {
                [0, 1].map(|i| (a * d[i] + b * e[i] + c * f[i]) as f32)
            });
        } else {
            let weights = weights.as_chunks::<3>().0;
            corners.fill(face, weights, out, |[a, b, c], [d, e, f]| (a * d + b * e + c * f) as f32);
        }
    })
}

/// What the corners of faces have.
struct Corners<'a> {
    attributes: &'a [f32],
    channels: usize,
    corners: &'a [[u32; 3]],
    /// Whether those are of pixels, not of faces.
    are_of_pixels: bool,
}

/// A weight, or a pair of them.
trait Weight: Copy + Sync {
    type Wide: Copy;

    fn wide(self) -> Self::Wide;
}

impl Weight for f32 {
    type Wide = f64;

    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Weight for [f32; 2] {
    type Wide = [f64; 2];

    fn wide(self) -> [f64; 2] {
        self.map(f64::from)
    }
}

impl Corners<'_> {
    fn fill<W: Weight, T: Send>(
        &self,
        face: &[i32],
        weights: &[[W; 3]],
        out: &mut [T],
        mix: impl Fn([f64; 3], [W::Wide; 3]) -> T + Sync,
    ) {
        let parts = out.par_chunks_mut(PART * self.channels);
        let parts = parts.zip(face.par_chunks(PART).zip(weights.par_chunks(PART)));
        parts.enumerate().for_each(|(part, (out, (faces, weights)))| {
            let pixels = out.chunks_exact_mut(self.channels).zip(faces.iter().zip(weights));
            for (i, (out, (&face, weights))) in pixels.enumerate() {
                let pixel = part * PART + i;
                let Some(of_corners) = self.of_corners(face, pixel) else { continue };
                let weights = weights.map(W::wide);
                for (channel, out) in out.iter_mut().enumerate() {
                    let values = of_corners.map(|values| f64::from(values[channel]));
                    *out = mix(values, weights);
                }
            }
        });
    }

    #[inline]
    fn of_corners(&self, face: i32, pixel: usize) -> Option<[&[f32]; 3]> {
        let face = usize::try_from(face).ok()?;
        let [a, b, c] = *self.corners.get(if self.are_of_pixels { pixel } else { face })?;
        let get = |i: u32| {
            let start = i as usize * self.channels;
            self.attributes.get(start..start + self.channels)
        };
        Some([get(a)?, get(b)?, get(c)?])
    }
}
