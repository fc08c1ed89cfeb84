//! Draw calls of the z-buffer renderer: nothing outside the viewport is touched, every pixel has
//! what the spans' fragments say, and a tile drawn alone equals the crop of the whole (contract 6).
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/draw
//! cargo +nightly fuzz run -s none draw fuzz/corpus/draw fuzz/seeds/draw -- \
//!     -max_len=600 -timeout=5 -rss_limit_mb=1024
//! ```
//!
//! For `-s none` see the target `scan`. Polygons and meshes are drawn by fragments, by blocks, and
//! by depth alone.

#![no_main]

use libfuzzer_sys::fuzz_target;
use polyscan::fragment::LANES;
use polyscan::{
    DepthBias, DepthMode, DepthTest, Footprint, Fragment, FragmentBlock, Framebuffer, Mesh, Rect,
    ScanConverter, Settings, Vertex, Viewport, ZBufferRenderer,
};
use polyscan_fuzz::{Bytes, N};

/// The largest framebuffer but for tall ones; the columns make more than two blocks.
const WIDTH: u32 = 41;
const HEIGHT: u32 = 9;

/// The most pixels of a viewport whose every fragment is looked at.
const PIXELS: u64 = 1 << 22;

/// What a pixel has: bits, since those are what must agree.
type Color = [u32; N + 1];
const UNTOUCHED: Color = [0xABCD; N + 1];

/// A cluster: the numbers of two parameters, and of that which they are divided by.
const UV: [usize; 2] = [0, 1];
const BY: usize = 2;

const TESTS: [DepthTest; 8] = [
    DepthTest::Nearer,
    DepthTest::Always,
    DepthTest::NearerOrEqual,
    DepthTest::Farther,
    DepthTest::FartherOrEqual,
    DepthTest::Equal,
    DepthTest::NotEqual,
    DepthTest::Never,
];

/// One draw call.
#[derive(Debug)]
struct Call {
    polygon: Vec<Vertex<N>>,
    /// The faces, if the vertices are those of a mesh.
    faces: Option<Vec<Vec<u32>>>,
    depth_test: DepthTest,
    depth_write: bool,
    /// Which fragments are discarded.
    discard: Option<u32>,
    by: By,
}

/// How pixels are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Fragment,
    Block,
    DepthAlone,
}

impl Call {
    fn new(bytes: &mut Bytes<'_>, viewport: &Viewport) -> Self {
        let (is_mesh, by) = match bytes.byte() {
            0..0x70 => (false, By::Fragment),
            0x70..0xa0 => (false, By::Block),
            0xa0..0xb0 => (false, By::DepthAlone),
            0xb0..0xd0 => (true, By::Fragment),
            0xd0..0xf0 => (true, By::Block),
            0xf0..=0xff => (true, By::DepthAlone),
        };
        let faces = is_mesh.then(|| (0..bytes.below(4)).map(|_| face(bytes)).collect());
        let depth_test = bytes.one_of(TESTS);
        let depth_write = !bytes.once(64);
        let discard = bytes.once(64).then(|| u32::from(bytes.byte()));
        Self { polygon: bytes.polygon(viewport), faces, depth_test, depth_write, discard, by }
    }

    /// What the shader makes of a fragment of a picture whose corner is at `corner`.
    fn shade(&self, fragment: &Fragment<'_, N>, corner: (i32, i32)) -> Option<Color> {
        let (x, y) = (fragment.x.wrapping_sub(corner.0), fragment.y.wrapping_sub(corner.1));
        if self.discard.is_some_and(|mask| mask >> ((x ^ y) & 7) & 1 == 1) {
            return None;
        }
        let mut color = [bits(fragment.w) ^ cluster(fragment.divided_footprint(UV, BY)); N + 1];
        let (dx, dy) = fragment.derivatives();
        for i in 0..N {
            color[i + 1] =
                bits(fragment.params[i]) ^ bits(dx[i]).rotate_left(7) ^ bits(dy[i]).rotate_left(13);
        }
        Some(color)
    }

    fn draw(
        &self,
        renderer: &mut ZBufferRenderer<N>,
        frame: &mut Framebuffer<Color>,
        corner: (i32, i32),
    ) {
        renderer.depth_test = self.depth_test;
        renderer.depth_write = self.depth_write;
        let shader = |fragment: &Fragment<'_, N>| self.shade(fragment, corner);
        let block_shader = |block: &mut FragmentBlock<'_, N>, colors: &mut [Color; LANES]| {
            let visible = block.visible;
            let (footprints, lit) = block.divided_footprint(UV, BY);
            for lane in (0..LANES).filter(|lane| visible >> lane & 1 == 1) {
                let found = (lit >> lane & 1 == 1).then(|| footprints.get(lane));
                let alone = block.fragment(lane).divided_footprint(UV, BY);
                assert_eq!(cluster(found), cluster(alone), "lane {lane}");
                match self.shade(&block.fragment(lane), corner) {
                    Some(color) => colors[lane] = color,
                    None => block.visible &= !(1 << lane),
                }
            }
        };
        let vertices = &self.polygon;
        match (&self.faces, self.by) {
            (None, By::Fragment) => renderer.draw(frame, vertices, shader),
            (None, By::Block) => renderer.draw_blocks(frame, vertices, block_shader),
            (None, By::DepthAlone) => renderer.draw_depth(frame, vertices),
            (Some(faces), By::Fragment) => renderer.draw(frame, Mesh::new(vertices, faces), shader),
            (Some(faces), By::Block) => {
                renderer.draw_blocks(frame, Mesh::new(vertices, faces), block_shader);
            }
            (Some(faces), By::DepthAlone) => renderer.draw_depth(frame, Mesh::new(vertices, faces)),
        }
    }

    /// The polygons that the call draws: one, or the faces whose indices are all there.
    fn polygons(&self) -> Vec<Vec<Vertex<N>>> {
        let Some(faces) = &self.faces else { return vec![self.polygon.clone()] };
        let vertex = |&i: &u32| self.polygon.get(i as usize).copied();
        faces.iter().filter_map(|face| face.iter().map(vertex).collect()).collect()
    }

    /// The same as [`draw`](Self::draw), pixel by pixel, by the documentation's words.
    fn draw_plainly(&self, scan: &mut ScanConverter<N>, frame: &mut Framebuffer<Color>) {
        let (corner, mode) = ((0, 0), scan.settings.depth);
        for polygon in self.polygons() {
            for span in scan.spans(&polygon) {
                for fragment in span.fragments() {
                    let (Ok(x), Ok(y)) = (fragment.x.try_into(), fragment.y.try_into()) else {
                        continue;
                    };
                    let Some((_, old)) = frame.pixel(x, y) else { continue };
                    let index = y as usize * frame.width() as usize + x as usize;
                    if !passes(self.depth_test, mode, fragment.depth, old) {
                        continue;
                    }
                    if self.by != By::DepthAlone {
                        let Some(color) = self.shade(&fragment, corner) else { continue };
                        frame.color_mut()[index] = color;
                    }
                    if self.depth_write {
                        frame.depth_mut()[index] = fragment.depth;
                    }
                }
            }
        }
    }
}

/// A face of a mesh, some indices out of range.
fn face(bytes: &mut Bytes<'_>) -> Vec<u32> {
    let index = |bytes: &mut Bytes<'_>| match bytes.byte() {
        0xff => u32::MAX,
        index => u32::from(index % 10),
    };
    (0..bytes.below(7)).map(|_| index(bytes)).collect()
}

fn passes(test: DepthTest, mode: DepthMode, new: f32, old: f32) -> bool {
    let (is_nearer, is_farther) =
        if mode.is_greater_nearer() { (new > old, new < old) } else { (new < old, new > old) };
    match test {
        DepthTest::Never => false,
        DepthTest::Nearer => is_nearer,
        DepthTest::Equal => new == old,
        DepthTest::NearerOrEqual => is_nearer || new == old,
        DepthTest::Farther => is_farther,
        DepthTest::NotEqual => new != old,
        DepthTest::FartherOrEqual => is_farther || new == old,
        DepthTest::Always => true,
    }
}

/// The bits of a number, one for all kinds of NaN: of those arithmetic makes no promise.
fn bits(number: f32) -> u32 {
    if number.is_nan() { f32::NAN.to_bits() } else { number.to_bits() }
}

/// The bits of a cluster with its derivatives.
fn cluster(footprint: Option<Footprint>) -> u32 {
    footprint.map_or(0x5555, |Footprint { uv, dx, dy }| {
        let all = [uv.x, uv.y, dx.x, dx.y, dy.x, dy.y];
        all.into_iter().fold(0, |sum: u32, number| sum.rotate_left(5) ^ bits(number))
    })
}

/// A framebuffer in which nothing has been drawn, but whose depth has a pattern.
fn frame(width: u32, height: u32, depth: [f32; 2]) -> Framebuffer<Color> {
    let mut frame = Framebuffer::new(width, height, UNTOUCHED).expect("a small frame");
    frame.clear(UNTOUCHED, depth[0]);
    let rows = frame.depth_mut().chunks_mut(width.max(1) as usize);
    rows.skip(1).step_by(2).for_each(|row| row.fill(depth[1]));
    frame
}

/// The height of a framebuffer: few rows, seldom so many that a mesh is drawn in up to three bands.
fn height(bytes: &mut Bytes<'_>) -> u32 {
    match bytes.byte() {
        tag @ 0xf0.. => 30 + 3 * u32::from(tag - 0xf0),
        tag => u32::from(tag) % (HEIGHT + 1),
    }
}

/// Colour and depth of a pixel, as bits.
fn pixel(frame: &Framebuffer<Color>, x: u32, y: u32) -> (Color, u32) {
    let (color, depth) = frame.pixel(x, y).expect("inside the frame");
    (color, bits(depth))
}

/// Where a pixel is neither in the viewport nor in the scissor, nothing may be drawn.
fn check_outside(frame: &Framebuffer<Color>, settings: &Settings<N>, depth: [f32; 2]) {
    let within = |rect: Rect, x: u32, y: u32| {
        let one = |pixel: u32, start: i32, size: u32| {
            (0..i64::from(size)).contains(&(i64::from(pixel) - i64::from(start)))
        };
        one(x, rect.x, rect.width) && one(y, rect.y, rect.height)
    };
    let viewport = settings.viewport.rect();
    let scissor = settings.scissor.unwrap_or(viewport);
    for y in 0..frame.height() {
        for x in 0..frame.width() {
            if !within(viewport, x, y) || !within(scissor, x, y) {
                let untouched = (UNTOUCHED, bits(depth[y as usize % 2]));
                assert_eq!(pixel(frame, x, y), untouched, "pixel {x}, {y}");
            }
        }
    }
}

/// A viewport near the framebuffer: at most 2^16 pixels away, so that tiles of it are exact.
fn viewport(bytes: &mut Bytes<'_>, size: [u32; 2]) -> Viewport {
    let viewport = match bytes.byte() {
        0..0x60 => Viewport::new(size[0], size[1]),
        _ => {
            let [width, height] = bytes.size();
            Viewport::new(width, height)
        }
    };
    let viewport = viewport.expect("at most 65536");
    let corner = match bytes.byte() {
        0..0x80 => (0, 0),
        0x80..0xc0 => (i32::from(bytes.byte()) - 128, i32::from(bytes.byte()) - 128),
        _ => (i32::from(bytes.short()), i32::from(bytes.short())),
    };
    let viewport = viewport.with_corner(corner.0, corner.1);
    if bytes.once(64) { viewport.with_depth(bytes.number(), bytes.number()) } else { viewport }
}

fuzz_target!(|data: &[u8]| {
    let bytes = &mut Bytes(data);
    let size = [bytes.below(WIDTH as usize + 1) as u32, height(bytes)];
    let depth = if bytes.once(64) { [bytes.number(), bytes.number()] } else { [1.0, 0.5] };
    let viewport = viewport(bytes, size);
    let mut renderer = ZBufferRenderer::new(viewport);
    renderer.settings = bytes.settings(viewport);
    let tag = bytes.byte();
    renderer.settings.depth = match tag % 4 {
        0 | 1 => DepthMode::Standard,
        2 => DepthMode::Reversed,
        _ => DepthMode::InverseW,
    };
    if tag >= 0xe0 {
        renderer.settings.depth_bias =
            DepthBias { constant: bytes.number(), slope: bytes.number() };
    }
    let tile_size = [1 + bytes.below(17) as u32, 1 + bytes.below(HEIGHT as usize) as u32];
    let tile_corner =
        [bytes.below(WIDTH as usize) as u32, bytes.below(size[1].max(HEIGHT) as usize) as u32];
    let mut calls = Vec::new();
    while calls.len() < 4 && !bytes.is_empty() {
        calls.push(Call::new(bytes, &viewport));
    }

    let mut whole = frame(size[0], size[1], depth);
    let mut again = whole.clone();
    for call in &calls {
        call.draw(&mut renderer, &mut whole, (0, 0));
    }
    check_outside(&whole, &renderer.settings, depth);

    // The same calls in another way: by fragments where those tell all, else once more.
    let Rect { width, height, .. } = viewport.rect();
    let plain = renderer.settings.depth != DepthMode::InverseW
        && height <= 100
        && u64::from(width) * u64::from(height) <= PIXELS;
    let mut scan = ScanConverter::new(viewport);
    scan.settings = renderer.settings.clone();
    for call in &calls {
        if plain {
            call.draw_plainly(&mut scan, &mut again);
        } else {
            call.draw(&mut renderer, &mut again, (0, 0));
        }
    }
    for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
        assert_eq!(pixel(&again, x, y), pixel(&whole, x, y), "pixel {x}, {y} again");
    }

    // A tile: the viewport and the scissor move, the tile's corner comes to pixel (0, 0).
    let [left, top] = tile_corner.map(|pixel| pixel as i32);
    let rect = viewport.rect();
    renderer.settings.viewport = viewport.with_corner(rect.x - left, rect.y - top);
    if let Some(scissor) = &mut renderer.settings.scissor {
        scissor.x = scissor.x.saturating_sub(left);
        scissor.y = scissor.y.saturating_sub(top);
    }
    let depth = [depth[top as usize % 2], depth[(top as usize + 1) % 2]];
    let mut tile = frame(tile_size[0], tile_size[1], depth);
    for call in &calls {
        call.draw(&mut renderer, &mut tile, (-left, -top));
    }
    for y in 0..tile_size[1].min(size[1].saturating_sub(top as u32)) {
        for x in 0..tile_size[0].min(size[0].saturating_sub(left as u32)) {
            let (x_whole, y_whole) = (x + left as u32, y + top as u32);
            let expected = pixel(&whole, x_whole, y_whole);
            assert_eq!(pixel(&tile, x, y), expected, "pixel {x}, {y} of the tile");
        }
    }
});
