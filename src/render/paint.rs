//! What a shader may return for a pixel.

use std::ops::Add;

use glam::{Vec3, Vec4};

use crate::color::{Color, decode};
use crate::fragment::LANES;
use crate::render::pixel::Buffers;

/// What a shader may return for a pixel of colour `C`: a colour, which replaces the pixel's; an
/// `Option` of one, where `None` discards the fragment; or a colour in [`Over`] or [`Additive`], which
/// is blended with the pixel's. For a pixel of several [`Buffers`] it is a tuple of these, of which `None`
/// leaves its buffer as it is there, or an `Option` of such a tuple.
///
/// ```
/// use glam::{Vec4, vec4};
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer, render::Over};
///
/// let mut frame = Framebuffer::new(1, 1, vec4(0.0, 0.0, 1.0, 1.0))?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// // Red glass that lets half of the light through.
/// renderer.draw(&mut frame, &quad, |_| Over(vec4(0.5, 0.0, 0.0, 0.5)));
/// assert_eq!(frame.color(), [vec4(0.5, 0.0, 0.5, 1.0)]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "a shader cannot return `{Self}` for a picture whose colours are `{C}`",
    label = "the shader returns `{Self}`",
    note = "return a `{C}`, an `Option<{C}>`, or a blended colour such as `render::Over`"
)]
pub trait Paint<C>: Sized {
    /// Changes the pixel's colour, or returns `false` to discard the fragment, so that neither
    /// colour nor depth is written.
    fn paint(self, pixel: &mut C) -> bool;

    /// Whether [`paint_block`](Self::paint_block) is called in place of [`paint`](Self::paint) where there are
    /// many pixels: when the shader has been called for all of them. What is painted must not depend on the
    /// pixels' colours then.
    const IN_BLOCKS: bool = false;

    /// Changes those of a block's pixels for which there is something, and returns a bit for each, but for
    /// those that are discarded.
    fn paint_block(paints: [Option<Self>; LANES], pixels: &mut [C; LANES]) -> u32 {
        let mut drawn = 0;
        for (lane, (paint, pixel)) in paints.into_iter().zip(pixels).enumerate() {
            drawn |= u32::from(paint.is_some_and(|paint| paint.paint(pixel))) << lane;
        }
        drawn
    }
}

impl<C> Paint<C> for C {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        *pixel = self;
        true
    }
}

impl<C> Paint<C> for Option<C> {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        self.is_some_and(|color| color.paint(pixel))
    }
}

/// A colour that lies over the pixel's: Porter and Duff's "over" ("Compositing Digital Images",
/// 1984, section 4.3), in linear light premultiplied by the alpha in `w`. The pixel's colour shows
/// through by 1 - alpha.
///
/// Pixels may be `Vec4` (premultiplied linear light), `Vec3` (opaque linear light) or `[u8; 4]` (sRGB
/// with straight alpha, which is decoded, blended in linear light, and encoded again).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over(pub Vec4);

impl Paint<Vec4> for Over {
    #[inline(always)]
    fn paint(self, pixel: &mut Vec4) -> bool {
        *pixel = self.0 + *pixel * (1.0 - self.0.w);
        true
    }
}

impl Paint<Vec3> for Over {
    #[inline(always)]
    fn paint(self, pixel: &mut Vec3) -> bool {
        *pixel = self.0.truncate() + *pixel * (1.0 - self.0.w);
        true
    }
}

impl Paint<[u8; 4]> for Over {
    fn paint(self, pixel: &mut [u8; 4]) -> bool {
        let mut color = to_linear(*pixel);
        self.paint(&mut color);
        *pixel = color.to_srgb8();
        true
    }
}

/// A colour that is added to the pixel's: Porter and Duff's "plus", for light that is emitted. The
/// order of drawing does not matter but for rounding.
///
/// Pixels may be of the same type, or `[u8; 4]` for an `Additive<Vec4>` in linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Additive<C>(pub C);

impl<C: Copy + Add<Output = C>> Paint<C> for Additive<C> {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        *pixel = *pixel + self.0;
        true
    }
}

impl Paint<[u8; 4]> for Additive<Vec4> {
    fn paint(self, pixel: &mut [u8; 4]) -> bool {
        let mut color = to_linear(*pixel);
        self.paint(&mut color);
        *pixel = color.to_srgb8();
        true
    }
}

macro_rules! paint_buffers {
    ($($value:ident $paint:ident $i:tt),+) => {
        impl<$($value: Copy, $paint: Paint<$value>),+> Paint<Buffers<($($value,)+)>> for ($($paint,)+) {
            const IN_BLOCKS: bool = $($paint::IN_BLOCKS)||+;

            #[inline(always)]
            fn paint(self, Buffers(pixel): &mut Buffers<($($value,)+)>) -> bool {
                // What is not painted stays as it is in its buffer, whatever becomes of the others.
                $(let _ = self.$i.paint(&mut pixel.$i);)+
                true
            }

            fn paint_block(
                paints: [Option<Self>; LANES],
                pixels: &mut [Buffers<($($value,)+)>; LANES],
            ) -> u32 {
                let mut drawn = 0;
                let mut by_buffer = ($([const { None::<$paint> }; LANES],)+);
                for (lane, paint) in paints.into_iter().enumerate() {
                    if let Some(paint) = paint {
                        drawn |= 1 << lane;
                        $(by_buffer.$i[lane] = Some(paint.$i);)+
                    }
                }
                $({
                    let mut values = std::array::from_fn(|lane| pixels[lane].0.$i);
                    $paint::paint_block(by_buffer.$i, &mut values);
                    for (Buffers(pixel), value) in pixels.iter_mut().zip(values) {
                        pixel.$i = value;
                    }
                })+
                drawn
            }
        }

        impl<$($value: Copy, $paint: Paint<$value>),+> Paint<Buffers<($($value,)+)>>
            for Option<($($paint,)+)>
        {
            const IN_BLOCKS: bool = $($paint::IN_BLOCKS)||+;

            #[inline(always)]
            fn paint(self, pixel: &mut Buffers<($($value,)+)>) -> bool {
                self.is_some_and(|paints| paints.paint(pixel))
            }

            fn paint_block(
                paints: [Option<Self>; LANES],
                pixels: &mut [Buffers<($($value,)+)>; LANES],
            ) -> u32 {
                <($($paint,)+)>::paint_block(paints.map(Option::flatten), pixels)
            }
        }
    };
}

paint_buffers!(A P 0);
paint_buffers!(A P 0, B Q 1);
paint_buffers!(A P 0, B Q 1, C R 2);
paint_buffers!(A P 0, B Q 1, C R 2, D S 3);
paint_buffers!(A P 0, B Q 1, C R 2, D S 3, E T 4);
paint_buffers!(A P 0, B Q 1, C R 2, D S 3, E T 4, F U 5);

/// Premultiplied linear light of an sRGB colour with straight alpha.
fn to_linear([r, g, b, a]: [u8; 4]) -> Vec4 {
    let alpha = f32::from(a) / 255.0;
    (Vec3::new(decode(r), decode(g), decode(b)) * alpha).extend(alpha)
}
