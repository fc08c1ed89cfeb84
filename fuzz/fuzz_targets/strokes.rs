//! Lines, points and conservative coverage by the z-buffer renderer: any input is safe, and a tile drawn
//! alone equals the crop of the whole (contract 6), by whatever SIMD instructions.
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/strokes
//! cargo +nightly fuzz run -s none strokes fuzz/corpus/strokes fuzz/seeds/draw -- \
//!     -max_len=400 -timeout=5 -rss_limit_mb=1024
//! ```
//!
//! For `-s none` see the target `scan`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use polyscan::render::{Cap, Join};
use polyscan::{
    CoverageRule, Fragment, Framebuffer, Level, Lines, Mesh, OutsidePolygon, Points, Rect, Settings,
    Vertex, Viewport, ZBufferRenderer,
};
use polyscan_fuzz::{Bytes, N};

/// The framebuffer that is drawn whole, and the tile of it.
const WHOLE: [u32; 2] = [40, 37];
const TILE: Rect = Rect { x: 11, y: 7, width: 19, height: 23 };

type Color = [u32; N + 1];

/// What is drawn of some vertices.
#[derive(Clone, Copy, Debug)]
enum Figure {
    Lines { width: Option<f32>, join: Join, cap: Cap, is_closed: bool },
    Edges,
    Points { size: f32, is_round: bool },
    Polygon,
    Mesh,
}

impl Figure {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        match bytes.byte() {
            0..0x80 => Self::Lines {
                width: bytes.once(0x80).then(|| 4.0 * bytes.number()),
                join: match bytes.byte() % 3 {
                    0 => Join::Miter { limit: bytes.number() },
                    1 => Join::Bevel,
                    _ => Join::Round,
                },
                cap: bytes.one_of([Cap::Butt, Cap::Square, Cap::Round]),
                is_closed: bytes.once(0x40),
            },
            0x80..0xa0 => Self::Edges,
            0xa0..0xc0 => Self::Points { size: 4.0 * bytes.number(), is_round: bytes.once(0x80) },
            0xc0..0xe0 => Self::Polygon,
            0xe0..=0xff => Self::Mesh,
        }
    }

    fn draw(
        self,
        renderer: &mut ZBufferRenderer<N>,
        frame: &mut Framebuffer<Color>,
        vertices: &[Vertex<N>],
    ) {
        let count = vertices.len() as u32;
        let faces: Vec<[u32; 3]> = (2..count).map(|i| [0, i - 1, i]).collect();
        let shader = |fragment: &Fragment<'_, N>| {
            let mut color = [bits(fragment.w); N + 1];
            for (color, param) in color[1..].iter_mut().zip(fragment.params) {
                *color = bits(param);
            }
            color
        };
        match self {
            Self::Lines { width, join, cap, is_closed } => {
                let lines = Lines::polyline(vertices).with_join(join).with_cap(cap);
                let lines = if is_closed { lines.closed() } else { lines };
                let lines = width.map_or(lines, |width| lines.with_width(width));
                renderer.draw(frame, lines, shader);
            }
            Self::Edges => {
                renderer.draw(frame, Lines::edges_of(&Mesh::new(vertices, &faces)), shader);
            }
            Self::Points { size, is_round } => {
                let points = Points::new(vertices).with_size(size);
                let points = if is_round { points.round() } else { points };
                renderer.draw(frame, points, shader);
            }
            Self::Polygon => renderer.draw(frame, vertices, shader),
            Self::Mesh => renderer.draw(frame, Mesh::new(vertices, &faces), shader),
        }
    }
}

/// The bits of a number, one for all kinds of NaN.
fn bits(number: f32) -> u32 {
    if number.is_nan() { f32::NAN.to_bits() } else { number.to_bits() }
}

fuzz_target!(|data: &[u8]| {
    let bytes = &mut Bytes(data);
    let viewport = Viewport::new(WHOLE[0], WHOLE[1]).expect("small");
    let mut settings: Settings<N> = bytes.settings(viewport);
    settings.scissor = None;
    settings.coverage_rule = bytes.one_of([
        CoverageRule::Centre,
        CoverageRule::Outer(OutsidePolygon::Clamp),
        CoverageRule::Outer(OutsidePolygon::Extrapolate),
        CoverageRule::Inner,
    ]);
    let mut calls = Vec::new();
    while !bytes.is_empty() && calls.len() < 4 {
        calls.push((Figure::new(bytes), bytes.polygon(&viewport)));
    }
    let draw = |level: Level, corner: (i32, i32), [width, height]: [u32; 2]| {
        let mut frame = Framebuffer::new(width, height, [0; N + 1]).expect("a small frame");
        let mut renderer = ZBufferRenderer::new(viewport);
        renderer.settings = settings.clone();
        renderer.settings.viewport = viewport.with_corner(corner.0, corner.1);
        renderer.simd_level = level;
        for (figure, vertices) in &calls {
            figure.draw(&mut renderer, &mut frame, vertices);
        }
        frame
    };
    let whole = draw(Level::new(), (0, 0), WHOLE);
    let tile = draw(Level::baseline(), (-TILE.x, -TILE.y), [TILE.width, TILE.height]);
    for (y, x) in (0..TILE.height).flat_map(|y| (0..TILE.width).map(move |x| (y, x))) {
        let (color, depth) = tile.pixel(x, y).expect("inside the tile");
        let same = whole.pixel(x + TILE.x as u32, y + TILE.y as u32).expect("inside the frame");
        assert_eq!((color, bits(depth)), (same.0, bits(same.1)), "pixel {x}, {y} of the tile");
    }
});
