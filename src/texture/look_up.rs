//! The colours of a texture at points, and of what pixels see.

use glam::{Vec2, Vec4};

use crate::color::to_srgb8_block;
use crate::fragment::{Footprint, FootprintBlock, LANES, Lanes};
use crate::simd::for_level;
use crate::texture::block::Colors;
use crate::texture::build::Texture;
use crate::texture::level::MipFilter;
use crate::texture::minify::{Chain, Filtering};
use crate::texture::sample::{self, Filter};
use crate::texture::texels::with_texels;

impl Texture {
    /// The colour at `uv` by the texture's own filter: linear light, premultiplied by alpha.
    ///
    /// Any coordinate is safe, and is wrapped without a rounding error of its own. NaN counts as 0, and
    /// so does an infinity, unless the axis has [`Wrap::Clamp`](crate::texture::Wrap::Clamp), where it means that edge, or
    /// [`Wrap::Border`](crate::texture::Wrap::Border), where it is outside.
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::by_filter(self.how.filter, &texels, &self.how.around, uv)
        })
    }

    /// The colour of what a pixel sees: linear light, premultiplied by alpha. The picture is filtered by
    /// [`mip_filter`](Self::mip_filter) where it is made smaller, and by [`filter`](Self::filter) where it
    /// is magnified.
    ///
    /// Where `W` and `H` are the picture's width and height, the level of detail is
    /// log2 max(|(W du/dx, H dv/dx)|, |(W du/dy, H dv/dy)|); at 0 or less the picture is magnified.
    ///
    /// ```
    /// use glam::{Vec4, vec4};
    /// use polyscan::texture::Texture;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// // A checkerboard of 64 x 64 fields on 4 x 4 pixels is grey, and does not shimmer.
    /// let board = |x: u32, y: u32| if (x + y) % 2 == 0 { Vec4::ONE } else { Vec4::W };
    /// let texture = Texture::from_fn(64, 64, board)?.with_mipmaps()?;
    /// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// let mut frame = Framebuffer::new(4, 4, Vec4::ZERO)?;
    /// ZBufferRenderer::new(frame.viewport()).draw(&mut frame, &quad, |fragment| {
    ///     texture.sample_footprint(&fragment.footprint(0, 1))
    /// });
    /// assert_eq!(frame.color(), [vec4(0.5, 0.5, 0.5, 1.0); 16]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn sample_footprint(&self, footprint: &Footprint) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), base => {
            Chain::new(&self.texels, base, &self.how).sample(footprint)
        })
    }

    /// The colours at the points (u, v) of a block's lanes, as [`sample`](Self::sample), of lanes that
    /// have a bit in `mask`; 0 in others. Faster than one by one, and the same to the bit.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::color::Color;
    /// use polyscan::texture::Texture;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// let texture = Texture::from_fn(2, 1, |x, _| vec4(x as f32, 0.5, 0.0, 1.0))?;
    /// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// let mut frame = Framebuffer::new(40, 30, [0u8; 4])?;
    /// let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// renderer.draw_blocks(&mut frame, &quad, |block, colors| {
    ///     let texels = texture.sample_block(&block.params, block.visible);
    ///     for (color, texel) in colors.iter_mut().zip(texels) {
    ///         *color = texel.to_srgb8();
    ///     }
    /// });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn sample_block(&self, uv: &[Lanes; 2], mask: u32) -> [Vec4; LANES] {
        let mut colors = [Vec4::ZERO; LANES];
        self.magnify(uv, mask, &mut colors);
        colors
    }

    fn magnify(&self, uv: &[Lanes; 2], mask: u32, colors: &mut Colors) {
        for_level!(up to AVX2: self.simd_level, _simd => {
            with_texels!(&self.texels, self.texels.base(), base => {
                Chain::new(&self.texels, base, &self.how).magnified_block(uv, mask, colors);
            });
        });
    }

    /// The colours of the footprints of a block's lanes, as
    /// [`sample_footprint`](Self::sample_footprint), of lanes that have a bit in `mask`; 0 in others.
    /// Faster than one by one, and the same to the bit.
    #[must_use]
    pub fn sample_footprint_block(&self, of: &FootprintBlock, mask: u32) -> [Vec4; LANES] {
        let mut colors = [Vec4::ZERO; LANES];
        self.filter_footprints(of, mask, &mut colors);
        colors
    }

    fn filter_footprints(&self, of: &FootprintBlock, mask: u32, colors: &mut Colors) {
        if self.how.mip_filter == MipFilter::Off {
            return self.magnify(&of.uv, mask, colors);
        }
        for_level!(up to AVX2: self.simd_level, _simd => {
            with_texels!(&self.texels, self.texels.base(), base => {
                Chain::new(&self.texels, base, &self.how).minified_block(of, mask, colors);
            });
        });
    }

    /// The colours of the footprints of a block's lanes as 8-bit sRGB pixels with alpha, of lanes that have a
    /// bit in `mask`; others are of no meaning. It is what [`to_srgb8`](crate::color::Color::to_srgb8) makes of those that
    /// [`sample_footprint_block`](Self::sample_footprint_block) gives, in less time.
    #[must_use]
    pub fn srgb8_block(&self, of: &FootprintBlock, mask: u32) -> [[u8; 4]; LANES] {
        let Filtering { filter, mip_filter, around, .. } = &self.how;
        let opaque =
            if around.has_border() { None } else { self.texels.opaque_srgba8(self.texels.base()) };
        let is_copy = (*filter, *mip_filter) == (Filter::Nearest, MipFilter::Off)
            && self.texels.has_short_numbers();
        let mut pixels = [[0; 4]; LANES];
        match opaque {
            Some(base) if is_copy => {
                for_level!(up to AVX2: self.simd_level, _simd => {
                    let chain = Chain::new(&self.texels, base, &self.how);
                    chain.codes_block(&of.uv, mask, &mut pixels);
                });
            }
            _ => {
                let mut colors = [Vec4::ZERO; LANES];
                self.filter_footprints(of, mask, &mut colors);
                for_level!(up to AVX2: self.simd_level, _simd => {
                    to_srgb8_block(&colors, opaque.is_some(), &mut pixels);
                });
            }
        }
        pixels
    }

    /// The texel that `uv` lies in. On the line between two texels it is the right or lower one.
    #[must_use]
    pub fn nearest(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::nearest(&texels, &self.how.around, uv)
        })
    }

    /// The mean of the four texels around `uv`, weighted by nearness along each axis.
    #[must_use]
    pub fn bilinear(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::bilinear(&texels, &self.how.around, uv)
        })
    }
}
