//! Textures: pictures that are sampled.

use numpy::{PyArray1, PyArray3, PyArrayMethods, PyUntypedArrayMethods as _};
use polyscan::fragment::{FootprintBlock, LANES};
use polyscan::glam::Vec4;
use polyscan::texture::{Cubic, Filter, MipFilter, Samples, Wrap};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::threads::work;

/// Blocks of samples that a thread takes at a time.
const PART: usize = 64;

/// How a picture is sampled.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct How {
    filter: String,
    /// The parameters of a bicubic filter.
    cubic: (f32, f32),
    mip_filter: String,
    /// Probes, or the greatest eccentricity.
    most: u32,
    wrap: (String, String),
    border: [f32; 4],
    level_bias: f32,
    level_range: (f32, f32),
}

/// A picture that is sampled.
#[pyclass(frozen, module = "polyscan._polyscan")]
pub(crate) struct Texture {
    texture: polyscan::Texture,
    #[pyo3(get)]
    channels: usize,
}

#[pymethods]
impl Texture {
    /// A texture of a picture (height, width, channels) of `uint8`, `uint16`, `uint16` with the bits of `float16`, or
    /// `float32`, as `format` says.
    #[new]
    fn new(py: Python<'_>, picture: &Bound<'_, PyAny>, format: &str, how: How) -> PyResult<Self> {
        let (shape, samples) = match format {
            "srgb8" | "unorm8" => {
                let (shape, bytes) = taken::<u8>(picture)?;
                (
                    shape,
                    if format == "srgb8" { Samples::Srgb8(bytes) } else { Samples::Unorm8(bytes) },
                )
            }
            "f32" => {
                let (shape, floats) = taken::<f32>(picture)?;
                (shape, Samples::F32(floats))
            }
            _ => {
                let (shape, words) = taken::<u16>(picture)?;
                let samples = match format {
                    "srgb16" => Samples::Srgb16(words),
                    "unorm16" => Samples::Unorm16(words),
                    _ => Samples::F16(words),
                };
                (shape, samples)
            }
        };
        let [height, width, channels] = shape;
        let side = |len: usize| u32::try_from(len).unwrap_or(u32::MAX);
        let (width, height) = (side(width), side(height));
        let made = work(py, None, || {
            let texture = polyscan::Texture::from_samples(width, height, channels, samples)?;
            how.apply(texture)
        })?;
        let wrong = |error| PyValueError::new_err(format!("picture: {error}"));
        Ok(Self { texture: made.map_err(wrong)?, channels })
    }

    /// Width and height in texels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.texture.width(), self.texture.height())
    }

    /// Fills `out`, `channels` numbers a sample, with the colours at `uv`, 2 numbers each; or of the footprints that
    /// have the `derivatives`, 2 * 2 numbers each: of u, then of v.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyArray1<f32>>,
        derivatives: Option<&Bound<'py, PyArray1<f32>>>,
        out: &Bound<'py, PyArray1<f32>>,
        threads: Option<usize>,
    ) -> PyResult<()> {
        let uv = uv.try_readonly()?;
        let derivatives = derivatives.map(PyArrayMethods::try_readonly).transpose()?;
        let mut out = out.try_readwrite()?;
        let (uv, out) = (uv.as_slice()?.as_chunks().0, out.as_slice_mut()?);
        let derivatives = match &derivatives {
            Some(array) => Some(array.as_slice()?.as_chunks().0.as_chunks().0),
            None => None,
        };
        let len = LANES * PART;
        work(py, threads, || {
            out.par_chunks_mut(len * self.channels).enumerate().for_each(|(part, out)| {
                let points = part * len..uv.len().min((part + 1) * len);
                let derivatives = derivatives.and_then(|all| all.get(points.clone()));
                self.sample_part(uv.get(points).unwrap_or_default(), derivatives, out);
            });
        })
    }
}

impl Texture {
    pub(crate) fn inner(&self) -> &polyscan::Texture {
        &self.texture
    }

    fn sample_part(&self, uv: &[[f32; 2]], derivatives: Option<&[[[f32; 2]; 2]]>, out: &mut [f32]) {
        for (i, uv) in uv.chunks(LANES).enumerate() {
            let mask = u32::MAX >> (u32::BITS as usize - uv.len());
            let mut of = FootprintBlock::default();
            for (lane, &[u, v]) in uv.iter().enumerate() {
                (of.uv[0][lane], of.uv[1][lane]) = (u, v);
            }
            let colors = match derivatives.and_then(|all| all.get(i * LANES..)) {
                None => self.texture.sample_block(&of.uv, mask),
                Some(derivatives) => {
                    for (lane, [u, v]) in derivatives.iter().take(LANES).enumerate() {
                        (of.dx[0][lane], of.dx[1][lane]) = (u[0], v[0]);
                        (of.dy[0][lane], of.dy[1][lane]) = (u[1], v[1]);
                    }
                    self.texture.sample_footprint_block(&of, mask)
                }
            };
            let out = out.chunks_exact_mut(self.channels).skip(i * LANES);
            for (out, color) in out.zip(&colors[..uv.len()]) {
                out.copy_from_slice(&channels(*color)[self.channels - 1][..self.channels]);
            }
        }
    }
}

/// The channels of a colour, for textures of 1, 2, 3 and 4.
fn channels(color: Vec4) -> [[f32; 4]; 4] {
    let [x, y, z, w] = color.to_array();
    [[x; 4], [x, w, w, w], [x, y, z, w], [x, y, z, w]]
}

/// The shape and a copy of a picture.
fn taken<T: numpy::Element + Copy>(picture: &Bound<'_, PyAny>) -> PyResult<([usize; 3], Vec<T>)> {
    let picture = picture.cast::<PyArray3<T>>()?.try_readonly()?;
    let shape = picture.shape();
    Ok(([shape[0], shape[1], shape[2]], picture.as_slice()?.to_vec()))
}

impl How {
    fn apply(
        &self,
        texture: polyscan::Texture,
    ) -> Result<polyscan::Texture, polyscan::texture::TextureError> {
        let wrap = |name: &str| match name {
            "clamp" => Wrap::Clamp,
            "mirror" => Wrap::Mirror,
            "border" => Wrap::Border,
            _ => Wrap::Repeat,
        };
        let filter = match self.filter.as_str() {
            "nearest" => Filter::Nearest,
            "bicubic" => Filter::Bicubic(Cubic { b: self.cubic.0, c: self.cubic.1 }),
            _ => Filter::Bilinear,
        };
        let mip_filter = match self.mip_filter.as_str() {
            "nearest" => MipFilter::Nearest,
            "linear" => MipFilter::Linear,
            "anisotropic" => MipFilter::Anisotropic { probes: self.most },
            "ewa" => MipFilter::Ewa { eccentricity: self.most },
            _ => MipFilter::Off,
        };
        let texture =
            if mip_filter == MipFilter::Off { texture } else { texture.with_mipmaps()? };
        Ok(texture
            .with_filter(filter)
            .with_mip_filter(mip_filter)
            .with_wraps(wrap(&self.wrap.0), wrap(&self.wrap.1))
            .with_border(self.border.into())
            .with_level_bias(self.level_bias)
            .with_level_range(self.level_range.0, self.level_range.1))
    }
}
