//! Targets: memory that is drawn to.

use std::fmt;

use crate::render::canvas::Canvas;
use crate::render::pixel::{BufferList, BufferSet, Buffers, Pixel};
use crate::viewport::{MAX_SIZE, Rect, SizeError, Viewport};

/// Borrowed memory that a renderer draws to: a colour of any type and an f32 depth for each pixel, row
/// by row from the top.
///
/// A [`Framebuffer`](crate::Framebuffer) is such memory that owns its pixels. A target is for pixels
/// that lie elsewhere, in a window's buffer or a picture of the `image` crate:
///
/// ```
/// use glam::vec4;
/// use polyscan::{Target, Vertex, ZBufferRenderer};
///
/// let mut colors = vec![0u32; 8 * 6];
/// let mut depths = vec![1.0; 8 * 6];
/// let mut target = Target::new(8, &mut colors, &mut depths)?;
/// let triangle = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// ZBufferRenderer::new(target.viewport()).draw(&mut target, &triangle, |_| 0xff_ff_ff);
/// assert_eq!(colors[5 * 8], 0xff_ff_ff);
/// # Ok::<(), polyscan::TargetError>(())
/// ```
///
/// Several values a pixel, each in a buffer of its own, are [`Buffers`].
pub struct Target<'a, C: Pixel + 'a> {
    pub(crate) width: u32,
    pub(crate) color: C::Memory<'a>,
    pub(crate) depth: &'a mut [f32],
    pub(crate) stencil: Option<&'a mut [u8]>,
}

impl<C: Pixel> fmt::Debug for Target<'_, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (width, height) = (self.width, self.height());
        f.debug_struct("Target").field("width", &width).field("height", &height).finish()
    }
}

/// Why memory cannot be drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TargetError {
    /// The numbers of colours and depths differ.
    #[error("there are {colors} colours and {depths} depths: each pixel needs one of both")]
    Lengths {
        /// How many colours there are.
        colors: usize,
        /// How many depths there are.
        depths: usize,
    },
    /// One of several buffers has not as many values as there are depths.
    #[error(
        "buffer {number} has {values} values and there are {depths} depths: each pixel needs one of both"
    )]
    BufferLength {
        /// Which buffer, from 1 in their order.
        number: usize,
        /// How many values it has.
        values: usize,
        /// How many depths there are.
        depths: usize,
    },
    /// The stencil has not as many bytes as there are depths.
    #[error(
        "the stencil has {bytes} bytes and there are {depths} depths: each pixel needs one of both"
    )]
    StencilLength {
        /// How many bytes the stencil has.
        bytes: usize,
        /// How many depths there are.
        depths: usize,
    },
    /// The pixels do not fill rows of the given width.
    #[error("{pixels} pixels do not fill rows of {width}: give whole rows")]
    NotWholeRows {
        /// The width asked for, in pixels.
        width: u32,
        /// How many pixels there are.
        pixels: usize,
    },
    /// The picture is too large.
    #[error(transparent)]
    Size(#[from] SizeError),
}

impl<'a, C: Copy> Target<'a, C> {
    /// A target of rows of `width` pixels. Before the first polygon the depths must be
    /// [the farthest](crate::DepthMode::farthest), 1.0 by default: fill them, or call a renderer's
    /// `clear`. On zeros nothing is drawn.
    ///
    /// # Errors
    /// When there are not as many depths as colours, when they do not fill whole rows, or when a side
    /// is longer than [`MAX_SIZE`].
    pub fn new(width: u32, color: &'a mut [C], depth: &'a mut [f32]) -> Result<Self, TargetError> {
        height_of(width, color.len(), depth.len())?;
        Ok(Self { width, color, depth, stencil: None })
    }
}

impl<'a, B: BufferSet> Target<'a, Buffers<B>> {
    /// A target of rows of `width` pixels with several [`Buffers`]: a tuple of up to six, each `&mut [A]` or
    /// `&mut Vec<A>`. Of the depths holds what [`Target::new`] says.
    ///
    /// # Errors
    /// When a buffer has not as many values as there are depths, when they do not fill whole rows, or
    /// when a side is longer than [`MAX_SIZE`].
    pub fn of_buffers(
        width: u32,
        buffers: impl BufferList<'a, Set = B>,
        depth: &'a mut [f32],
    ) -> Result<Self, TargetError> {
        let (lengths, color) = buffers.slices();
        let depths = depth.len();
        let others = lengths.as_ref().iter().zip(1..).find(|(values, _)| **values != depths);
        if let Some((&values, number)) = others {
            return Err(TargetError::BufferLength { number, values, depths });
        }
        height_of(width, depths, depths)?;
        Ok(Self { width, color, depth, stencil: None })
    }
}

/// The height of a picture of so many colours and depths, if they fill rows of a width.
pub(crate) fn height_of(width: u32, colors: usize, depths: usize) -> Result<u32, TargetError> {
    if colors != depths {
        return Err(TargetError::Lengths { colors, depths });
    }
    let height = if colors == 0 { 0 } else { colors.checked_div(width as usize).unwrap_or(0) };
    if height * width as usize != colors {
        return Err(TargetError::NotWholeRows { width, pixels: colors });
    }
    let height = u32::try_from(height).unwrap_or(u32::MAX);
    SizeError::check(width, height)?;
    Ok(height)
}

impl<'a, C: Pixel> Target<'a, C> {
    /// A target whose sizes were checked.
    pub(crate) fn from_checked(width: u32, color: C::Memory<'a>, depth: &'a mut [f32]) -> Self {
        Self { width, color, depth, stencil: None }
    }

    /// The same target with a stencil, a byte for each pixel, for a renderer's
    /// [`Stencil`](crate::render::Stencil). Without one all
    /// fragments pass.
    ///
    /// # Errors
    /// When there are not as many bytes as depths.
    pub fn with_stencil(mut self, stencil: &'a mut [u8]) -> Result<Self, TargetError> {
        let (bytes, depths) = (stencil.len(), self.depth.len());
        if bytes != depths {
            return Err(TargetError::StencilLength { bytes, depths });
        }
        self.stencil = Some(stencil);
        Ok(self)
    }

    /// The number of columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        // At most `MAX_SIZE`, which was checked.
        const { assert!(MAX_SIZE < u32::MAX) };
        self.depth.len().checked_div(self.width as usize).unwrap_or(0) as u32
    }

    /// The viewport that covers the whole target.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        Viewport::whole(self.rect())
    }

    pub(crate) fn rect(&self) -> Rect {
        Rect { x: 0, y: 0, width: self.width, height: self.height() }
    }
}

/// What a renderer can draw to: a [`Framebuffer`](crate::Framebuffer) or a [`Target`].
#[expect(private_bounds, reason = "how shaders paint pixels is the renderers' own business")]
pub trait RenderTarget {
    /// The type of a pixel's colour, or [`Buffers`] if it has several values.
    type Color: Canvas;

    /// The memory to draw to.
    fn target(&mut self) -> Target<'_, Self::Color>;
}

impl<C: Canvas> RenderTarget for Target<'_, C> {
    type Color = C;

    fn target(&mut self) -> Target<'_, C> {
        let color = C::reborrow(&mut self.color);
        let stencil = self.stencil.as_deref_mut();
        Target { width: self.width, color, depth: self.depth, stencil }
    }
}
