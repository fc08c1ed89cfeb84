//! A shader's answer that a pixel is to have a texture's colour, which is looked up later, for many pixels at
//! once.

use glam::{Vec3, Vec4};

use crate::color::Color;
use crate::fragment::{Footprint, FootprintBlock, LANES};
use crate::render::Paint;
use crate::texture::build::Texture;
use crate::texture::level::MipFilter;

/// A pixel painted by a texture, as [`Texture::paint`] returns it to a shader that returns it to the renderer,
/// which looks the colours up sixteen at a time. They are those of
/// [`sample_footprint`](Texture::sample_footprint), to the bit.
///
/// Pixels may be `[u8; 4]` (sRGB with straight alpha), `Vec4` (premultiplied linear light) or `Vec3` (opaque
/// linear light).
#[derive(Clone, Copy, Debug)]
#[must_use = "a shader returns this to the renderer"]
pub struct TexturePaint<'t> {
    texture: &'t Texture,
    footprint: Footprint,
}

impl Texture {
    /// What a shader returns to have its pixel painted by the texture: in the colour that
    /// [`sample_footprint`](Self::sample_footprint) gives, of a footprint or of a point.
    ///
    /// The renderer looks colours up for sixteen pixels at once, two to three times as fast as a
    /// shader does that samples them itself.
    ///
    /// ```
    /// use glam::{Vec4, vec4};
    /// use polyscan::texture::Texture;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// let board = |x: u32, y: u32| if (x + y) % 2 == 0 { Vec4::ONE } else { Vec4::W };
    /// let texture = Texture::from_fn(64, 64, board)?.with_mipmaps()?;
    /// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// let mut frame = Framebuffer::new(4, 4, [0u8; 4])?;
    /// let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// renderer.draw(&mut frame, &quad, |fragment| texture.paint(fragment.footprint(0, 1)));
    /// assert_eq!(frame.color(), [[188, 188, 188, 255]; 16]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline]
    pub fn paint(&self, footprint: impl Into<Footprint>) -> TexturePaint<'_> {
        TexturePaint { texture: self, footprint: footprint.into() }
    }
}

impl TexturePaint<'_> {
    fn color(&self) -> Vec4 {
        self.texture.sample_footprint(&self.footprint)
    }
}

/// Calls `f` for each texture among paints, with the footprints and a bit for each lane that is painted by it.
/// Returns the bits of all.
#[inline(never)]
fn by_texture<'t>(
    paints: &[Option<TexturePaint<'t>>; LANES],
    f: &mut dyn FnMut(&'t Texture, &FootprintBlock, u32),
) -> u32 {
    let mut of = FootprintBlock::default();
    let (mut painted, mut has_sides) = (0, false);
    for (lane, paint) in paints.iter().enumerate() {
        if let Some(TexturePaint { texture, footprint }) = paint {
            of.set_uv(lane, footprint.uv);
            painted |= 1 << lane;
            has_sides |= texture.mip_filter() != MipFilter::Off;
        }
    }
    if has_sides {
        for (lane, paint) in paints.iter().enumerate() {
            if let Some(TexturePaint { footprint, .. }) = paint {
                of.set_sides(lane, footprint);
            }
        }
    }
    let mut left: u32 = painted;
    while let Some(Some(first)) = paints.get(left.trailing_zeros() as usize) {
        let mut same = 0;
        for (lane, paint) in paints.iter().enumerate() {
            let is_same = paint.is_some_and(|paint| std::ptr::eq(paint.texture, first.texture));
            same |= u32::from(is_same) << lane;
        }
        f(first.texture, &of, same);
        left &= !same;
    }
    painted
}

macro_rules! paint {
    ($pixel:ty, $color:ident => $one:expr, $texture:ident, $of:ident, $mask:ident => $all:expr) => {
        impl Paint<$pixel> for TexturePaint<'_> {
            const IN_BLOCKS: bool = true;

            fn paint(self, pixel: &mut $pixel) -> bool {
                let $color = self.color();
                *pixel = $one;
                true
            }

            fn paint_block(paints: [Option<Self>; LANES], pixels: &mut [$pixel; LANES]) -> u32 {
                by_texture(&paints, &mut |$texture, $of, $mask| {
                    for (lane, (pixel, color)) in pixels.iter_mut().zip($all).enumerate() {
                        if $mask >> lane & 1 != 0 {
                            *pixel = color;
                        }
                    }
                })
            }
        }
    };
}

paint!([u8; 4], color => color.to_srgb8(), texture, of, mask => texture.srgb8_block(of, mask));
paint!(Vec4, color => color, texture, of, mask => texture.sample_footprint_block(of, mask));
paint!(
    Vec3, color => color.truncate(),
    texture, of, mask => texture.sample_footprint_block(of, mask).map(Vec4::truncate)
);
