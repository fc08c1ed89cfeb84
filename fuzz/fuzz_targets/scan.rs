//! Any polygon through the clipper and the scan converter: contract 3, "any input is safe".
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/scan
//! cargo +nightly fuzz run -s none scan fuzz/corpus/scan fuzz/seeds/scan -- \
//!     -max_len=600 -timeout=5 -rss_limit_mb=1024
//! ```
//!
//! `-s none` leaves the address sanitizer out, for speed: the library has no unsafe code. Debug
//! assertions and overflow checks stay on. `--no-trace-compares` makes runs up to twice as fast once
//! new inputs have become rare; the fuzzer is then not told what numbers are compared with. 600 bytes
//! make two polygons of some 30 vertices each. A failed assertion prints the polygon and what was
//! promised for it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use polyscan::clip::{Clipped, Clipper};
use polyscan::{ClipPlane, FillRule, Fragment, Interpolation, Rect, ScanConverter, Span, Vertex};
use polyscan_fuzz::{Bytes, N};

/// How many rows are scanned, spans and fragments are looked at: what bounds the time of a run.
const ROWS: u32 = 256;
const SPANS: usize = 128;
const FRAGMENTS: usize = 300;

/// How far a parameter may be off by rounding, as a part of its greatest value: s and 1/w are both
/// rounded, in blocks along which 1/w may fall to a quarter, where the library says less than 1e-6.
const TOLERANCE: f64 = 1e-6;

/// How far the vertices of a polygon of four sides or more may lie from the plane that stands for
/// them, as the library says, with the same measure.
const PLANE: f64 = 1.0 / (1 << 19) as f64;

/// A pixel centre may lie outside the polygon, so far that a parameter leaves the range of the
/// vertices' values by its change over this part of a pixel, in x and in y.
const OUTSIDE: f64 = 1.0 / 256.0;

/// What may be said of any fragment of a polygon.
struct Promise<'a> {
    polygon: &'a [Vertex<N>],
    w: (f32, f32),
    depth: (f32, f32),
    params: [Option<ParamRange>; N],
}

/// Where the values of a parameter may lie.
#[derive(Clone, Copy, Debug)]
struct ParamRange {
    /// The least and the greatest value at the vertices.
    values: (f32, f32),
    /// How far off it may be by rounding.
    rounding: f64,
}

impl ParamRange {
    /// The range of parameter `i`, where something may be said about it.
    fn new(scan: &ScanConverter<N>, polygon: &[Vertex<N>], i: usize) -> Option<Self> {
        let corners = match scan.settings.interpolation[i] {
            Interpolation::Flat => polygon.get(..1)?,
            _ => polygon,
        };
        if !corners.iter().all(|v| v.params[i].is_finite()) {
            return None;
        }
        let values = extent(corners.iter().map(|v| v.params[i]));
        let largest = f64::from(values.0.abs().max(values.1.abs()));
        if values.0 == values.1 && !is_divided(scan, polygon, i) {
            return Some(Self { values, rounding: 0.0 });
        }
        // s = r / w in units of the least w must be a normal number, and nothing may overflow. And a new
        // vertex is off by 2^-53 of the far end's w, which may be no more than a part of a subpixel at
        // the near end, of 2^24 in the width of the largest viewport: else the plane is not known.
        let (near, far) = visible_w(scan, polygon);
        let ratio = f64::from(far) / f64::from(near);
        let fits = largest / ratio > 1e-30 && largest < 1e30 && ratio < (1u64 << 28) as f64;
        let off = if polygon.len() > 3 { TOLERANCE + PLANE } else { TOLERANCE };
        fits.then_some(Self { values, rounding: largest * off })
    }

    /// Whether a fragment may have this value where it changes by `change` per pixel.
    fn contains(&self, value: f32, change: f64) -> bool {
        let (min, max) = self.values;
        // What is constant has no change, whatever rounding makes of it.
        let change = if min == max { 0.0 } else { change };
        let off = self.rounding + change * OUTSIDE;
        let value = f64::from(value);
        !(value < f64::from(min) - off || value > f64::from(max) + off || value.is_nan())
    }
}

/// Whether parameter `i` is divided by w and multiplied by it again.
fn is_divided(scan: &ScanConverter<N>, polygon: &[Vertex<N>], i: usize) -> bool {
    let w = extent(polygon.iter().map(|v| v.position.w));
    scan.settings.interpolation[i] == Interpolation::Perspective && w.0 != w.1
}

impl<'a> Promise<'a> {
    fn new(scan: &ScanConverter<N>, polygon: &'a [Vertex<N>]) -> Self {
        let [near, far] = scan.settings.viewport.depth();
        let w = extent(polygon.iter().map(|v| v.position.w));
        let params = std::array::from_fn(|i| ParamRange::new(scan, polygon, i));
        Self { polygon, w, depth: (near.min(far), near.max(far)), params }
    }

    fn check(&self, fragment: &Fragment<'_, N>) {
        let &Fragment { x, y, w, depth, ref params, .. } = fragment;
        let polygon = self.polygon;
        let (w_range, depth_range) = (self.w, self.depth);
        assert!(
            w > 0.0 && w >= w_range.0 && w <= w_range.1,
            "w {w}, not in {w_range:?}, at {x}, {y} of {polygon:?}"
        );
        assert!(
            depth >= depth_range.0 && depth <= depth_range.1,
            "depth {depth}, not in {depth_range:?}, at {x}, {y} of {polygon:?}"
        );
        let (dx, dy) = fragment.derivatives();
        for (i, range) in self.params.iter().enumerate() {
            let Some(range) = range else { continue };
            let (value, change) = (params[i], f64::from(dx[i].abs()) + f64::from(dy[i].abs()));
            assert!(
                range.contains(value, change),
                "{value}, not in {range:?} + {change} / 256, at {x}, {y}, w {w} of {polygon:?}"
            );
        }
    }
}

/// The least and the greatest w of what the near, the far and the user's planes leave.
fn visible_w(scan: &ScanConverter<N>, polygon: &[Vertex<N>]) -> (f32, f32) {
    let mut planes: Vec<ClipPlane> = scan.settings.clip_space.frustum()[..2].to_vec();
    planes.extend(&scan.settings.planes);
    let mut clipper = Clipper::new();
    match clipper.clip(polygon, &planes) {
        Clipped::Polygon(visible) => extent(visible.iter().map(|v| v.rounded().position.w)),
        Clipped::Inside | Clipped::Outside => extent(polygon.iter().map(|v| v.position.w)),
    }
}

fn extent(values: impl Iterator<Item = f32>) -> (f32, f32) {
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)))
}

/// Whatever the six planes and the user's leave is before the eye.
fn clip(scan: &ScanConverter<N>, polygon: &[Vertex<N>]) {
    let mut planes = scan.settings.clip_space.frustum().to_vec();
    planes.extend(&scan.settings.planes);
    let mut clipper = Clipper::new();
    match clipper.clip_with(polygon, &planes, &scan.settings.interpolation) {
        Clipped::Outside => {}
        Clipped::Inside => assert!(polygon.iter().all(|v| v.position.w > 0.0)),
        Clipped::Polygon(clipped) => {
            assert!(clipped.len() >= 3);
            for vertex in clipped {
                assert!(vertex.position.is_finite() && vertex.position.w > 0.0, "{vertex:?}");
            }
        }
    }
}

/// Whether a pixel from `first` to `last` lies within `rect` along both axes.
fn inside(rect: Rect, span: &Span<'_, N>) -> bool {
    let within = |pixel: i32, start: i32, size: u32| {
        pixel >= start && i64::from(pixel) < i64::from(start) + i64::from(size)
    };
    within(span.columns().start, rect.x, rect.width)
        && within(span.columns().end - 1, rect.x, rect.width)
        && within(span.row(), rect.y, rect.height)
}

fuzz_target!(|data: &[u8]| {
    let bytes = &mut Bytes(data);
    let size = bytes.size();
    let viewport = bytes.viewport(size);
    let mut scan = ScanConverter::new(viewport);
    scan.settings = bytes.settings(viewport);
    if size[1] > ROWS {
        // A part of a large viewport, so that the time stays bounded.
        let mut rect = scan.settings.scissor.unwrap_or_else(|| bytes.scissor(&viewport));
        rect.height = rect.height.min(ROWS);
        scan.settings.scissor = Some(rect);
    }
    // The second polygon meets a scan converter that has been used.
    for _ in 0..2 {
        let polygon = bytes.polygon(&viewport);
        clip(&scan, &polygon);
        let promise = Promise::new(&scan, &polygon);
        let scissor = scan.settings.scissor.unwrap_or(viewport.rect());
        let mut before = (i32::MIN, i32::MIN);
        let mut fragments = FRAGMENTS;
        // With enough vertices, one contour or two, by the last bytes.
        let kind = usize::from(bytes.byte());
        scan.settings.fill_rule = if kind & 1 == 0 { FillRule::NonZero } else { FillRule::EvenOdd };
        let cut = if kind & 2 == 0 || polygon.len() < 6 {
            0
        } else {
            3 + (kind >> 2) % (polygon.len() - 5)
        };
        let (hole, outer) = polygon.split_at(cut);
        for span in scan.spans(&[hole, outer]).take(SPANS) {
            assert!(!span.columns().is_empty());
            assert!(inside(viewport.rect(), &span) && inside(scissor, &span), "{span:?}");
            assert!((span.row(), span.columns().start) >= before, "{span:?} after {before:?}");
            before = (span.row(), span.columns().end);
            let mut columns = span.columns();
            for fragment in span.fragments().take(fragments.min(40)) {
                assert_eq!((Some(fragment.x), fragment.y), (columns.next(), span.row()));
                promise.check(&fragment);
                fragments -= 1;
            }
            let _ = (span.start(), span.delta());
        }
    }
});
