//! What the fuzz targets share: polygons and settings from the bytes that the fuzzer gives.
//!
//! Every string of bytes means something, and a changed byte changes little: numbers are tame, odd
//! or raw bits by their first byte, vertices may repeat, and where the bytes end the polygon ends.

use polyscan::glam::{Vec4, vec4};
use polyscan::{
    ClipPlane, ClipSpace, Cull, FrontFace, Interpolation, Rect, Settings, Vertex, Viewport,
};

/// The number of parameters: one for each way of interpolation, and one more.
pub const N: usize = 4;

/// Numbers that break things.
const ODD: [f32; 32] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1e-20,
    -1e-20,
    1e10,
    -1e10,
    1e20,
    -1e20,
    1e37,
    -1e37,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::EPSILON,
    1.0 + f32::EPSILON,
    1.0 - f32::EPSILON / 2.0,
    65_536.0,
    16_777_216.0,
    1.0 / 256.0,
    1.0 / 512.0,
    0.5,
    255.5,
    1e-6,
    1e6,
];

/// Sizes of viewports, from nothing to the largest.
const SIZES: [u32; 16] = [0, 1, 2, 3, 5, 8, 16, 17, 33, 64, 100, 255, 1000, 4096, 65_535, 65_536];

/// Bytes that are used up from the front; beyond the end they are 0.
#[derive(Clone, Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// Whether none are left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// An index below `end`, of at most 256.
    pub fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    /// One of several values.
    pub fn one_of<T: Copy, const K: usize>(&mut self, values: [T; K]) -> T {
        values[self.below(K)]
    }

    /// Whether the next byte is one of those that say yes: `part` of 256.
    pub fn once(&mut self, part: u8) -> bool {
        // Beyond the end the answer is no.
        self.byte() > u8::MAX - part
    }

    /// Two bytes with a sign.
    pub fn short(&mut self) -> i16 {
        i16::from_le_bytes([self.byte(), self.byte()])
    }

    /// Four bytes.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    /// A number: tame, odd, of any bits, or a power of two.
    pub fn number(&mut self) -> f32 {
        let tag = self.byte();
        match tag {
            0..0x80 => f32::from(tag) / 32.0 - 1.5,
            0x80..0xa0 => ODD[usize::from(tag & 31)],
            0xa0..0xb0 => f32::from_bits(self.word()),
            0xb0..0xd0 => self.power(),
            _ => f32::from(self.short()) / 4096.0,
        }
    }

    /// A positive number, often a power of two, of any size.
    fn power(&mut self) -> f32 {
        let (exponent, mantissa) = (self.byte(), self.byte());
        f32::from_bits(u32::from(exponent) << 23 | u32::from(mantissa) << 15)
    }

    /// A place along an axis: coordinate and size of the axis in whole or fractional pixels.
    fn place(&mut self) -> f32 {
        let tag = self.byte();
        match tag {
            0..0x60 => f32::from(tag),
            0x60..0xc0 => f32::from(tag - 0x60) + 0.5,
            0xc0..0xf8 => f32::from(self.short()) / 256.0,
            _ => self.number(),
        }
    }

    /// A position in clip space: any four numbers, or a place on the screen times any w.
    fn position(&mut self, viewport: &Viewport) -> Vec4 {
        match self.byte() {
            0..0x30 => Vec4::from_array(std::array::from_fn(|_| self.number())),
            tag => {
                let Rect { width, height, .. } = viewport.rect();
                let (x, y) = (self.place(), self.place());
                let x = 2.0 * x / width.max(1) as f32 - 1.0;
                let y = 1.0 - 2.0 * y / height.max(1) as f32;
                let w = match tag {
                    0x30..0x80 => 1.0,
                    0x80..0xd0 => f32::from(self.byte()) / 16.0 + 0.0625,
                    0xd0..0xf0 => self.power(),
                    _ => self.number(),
                };
                vec4(x * w, y * w, f32::from(self.byte()) / 255.0 * w, w)
            }
        }
    }

    /// A viewport of `size` at any corner.
    pub fn viewport(&mut self, [width, height]: [u32; 2]) -> Viewport {
        let viewport = Viewport::new(width, height).expect("at most 65536");
        let viewport = match self.byte() {
            0..0x80 => viewport,
            0x80..0xf0 => viewport.with_corner(self.short().into(), self.short().into()),
            _ => viewport.with_corner(self.word() as i32, self.word() as i32),
        };
        if self.once(64) { viewport.with_depth(self.number(), self.number()) } else { viewport }
    }

    /// A viewport's size.
    pub fn size(&mut self) -> [u32; 2] {
        std::array::from_fn(|_| self.one_of(SIZES))
    }

    /// A rectangle near the viewport, or anywhere.
    pub fn scissor(&mut self, viewport: &Viewport) -> Rect {
        let Rect { x, y, .. } = viewport.rect();
        if self.once(32) {
            let [x, y, width, height] = std::array::from_fn(|_| self.word());
            return Rect { x: x as i32, y: y as i32, width, height };
        }
        let [right, down] = std::array::from_fn(|_| i32::from(self.short()));
        let [width, height] = std::array::from_fn(|_| u32::from(self.byte()));
        Rect { x: x.saturating_add(right), y: y.saturating_add(down), width, height }
    }

    /// Any settings but of depth; at most eight planes of the user's.
    pub fn settings(&mut self, viewport: Viewport) -> Settings<N> {
        use FrontFace::{Clockwise, CounterClockwise};
        let mut settings = Settings::new(viewport);
        settings.scissor = self.once(80).then(|| self.scissor(&viewport));
        settings.clip_space = self.one_of([ClipSpace::ZeroToOne, ClipSpace::MinusOneToOne]);
        (settings.cull, settings.front_face) = self.one_of([
            (Cull::None, CounterClockwise),
            (Cull::None, Clockwise),
            (Cull::Back, CounterClockwise),
            (Cull::Front, CounterClockwise),
            (Cull::None, CounterClockwise),
            (Cull::None, Clockwise),
            (Cull::Back, Clockwise),
            (Cull::Front, Clockwise),
        ]);
        settings.interpolation = std::array::from_fn(|_| {
            use Interpolation::{Flat, Linear, Perspective};
            self.one_of([Perspective, Perspective, Linear, Flat])
        });
        let planes = if self.once(40) { self.below(9) } else { 0 };
        settings.planes = (0..planes)
            .map(|_| ClipPlane::new(Vec4::from_array(std::array::from_fn(|_| self.number()))))
            .collect();
        settings
    }

    /// A polygon: up to 40 vertices, seldom more.
    pub fn polygon(&mut self, viewport: &Viewport) -> Vec<Vertex<N>> {
        let sides = match self.byte() {
            tag @ 0..0xf8 => usize::from(tag & 7),
            0xf8..0xfe => self.below(40),
            _ => self.below(256),
        };
        // Whether a parameter is the same everywhere, and what it is.
        let constant = self.byte();
        let common: [f32; N] =
            std::array::from_fn(|i| if constant >> i & 1 == 1 { self.number() } else { 0.0 });
        let one_w = (constant & 0x80 != 0).then(|| self.number());
        let mut polygon: Vec<Vertex<N>> = Vec::new();
        while polygon.len() < sides && !self.is_empty() {
            if !polygon.is_empty() && self.once(16) {
                polygon.push(polygon[self.below(polygon.len())]);
                continue;
            }
            let mut position = self.position(viewport);
            position.w = one_w.unwrap_or(position.w);
            let params =
                std::array::from_fn(
                    |i| {
                        if constant >> i & 1 == 1 { common[i] } else { self.number() }
                    },
                );
            polygon.push(Vertex { position, params });
        }
        polygon
    }
}
