//! Small triangles: which samples they cover, a block of pixels at once, by the functions of their edges.
//!
//! The function of an edge is 0 on its line, greater on the inner side, and linear: it changes by the same
//! from pixel to pixel, and from sample to sample (J. Pineda, "A Parallel Algorithm for Polygon
//! Rasterization", SIGGRAPH 1988). In units of square subpixels it is a whole number, so this is the coverage
//! that an [`Edge`](crate::coverage) finds: on the line, what is on a left edge or on a horizontal one at the top is
//! inside. For that, 1 is taken off the functions of the other edges, and inside is where none is negative.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdFrom, SimdMask, i32x16};

use crate::fragment::block::{HALF_BLOCK, LANES};
use crate::render::shader::MOST_SAMPLES;
use crate::scalar::{BATCH, PerTriangle};
use crate::subpixel::{HALF_PIXEL, SUBPIXELS, SubpixelPoint};

/// The most columns and rows of pixels that a small triangle touches. A function is of
/// two differences of corners, times two of a place and a corner, in subpixels: within 2^12 times 2^16 and
/// 2^11 times 2^17, as lanes are at most 16 columns from the first, less than 2^30 in all.
const MOST_COLUMNS: i32 = HALF_BLOCK as i32;
const MOST_ROWS: i32 = 256;

/// A batch of triangles by the functions of their edges.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct SmallTriangles {
    /// What the functions are at the centre of the first pixel.
    at: [PerTriangle<i32>; 3],
    /// Their changes per pixel to the right and downwards.
    right: [PerTriangle<i32>; 3],
    down: [PerTriangle<i32>; 3],
    /// How much more they are at each sample than at the centre.
    more: [[PerTriangle<i32>; 3]; MOST_SAMPLES],
    /// The first column and row of pixels that a triangle touches, and the one after the last row.
    left: PerTriangle<i32>,
    top: PerTriangle<i32>,
    bottom: PerTriangle<i32>,
    /// Whether it is small.
    is_small: PerTriangle<bool>,
}

impl Default for SmallTriangles {
    fn default() -> Self {
        let zeros = [[0; BATCH]; 3];
        Self {
            at: zeros,
            right: zeros,
            down: zeros,
            more: [zeros; MOST_SAMPLES],
            left: [0; BATCH],
            top: [0; BATCH],
            bottom: [0; BATCH],
            is_small: [false; BATCH],
        }
    }
}

impl SmallTriangles {
    /// Sets triangles up, by their corners and the samples' places. Plain loops over the triangles, which become
    /// SIMD; of those that are not small the numbers mean nothing.
    #[inline(always)]
    pub(crate) fn set_up(
        &mut self,
        points: &[PerTriangle<SubpixelPoint>; 3],
        places: &'static [[i32; 2]],
    ) {
        let [a, b, c] = points;
        let mut clockwise = [0; BATCH];
        for lane in 0..BATCH {
            let (a, b, c) = (a[lane], b[lane], c[lane]);
            let [left, right] = [a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)];
            let [top, bottom] = [a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y)];
            let (left, right) = (pixel(left), pixel(right - 1) + 1);
            let (top, bottom) = (pixel(top), pixel(bottom - 1) + 1);
            self.is_small[lane] = (right - left <= MOST_COLUMNS) & (bottom - top <= MOST_ROWS);
            (self.left[lane], self.top[lane], self.bottom[lane]) = (left, top, bottom);
            let area = sum((b.x - a.x, a.y - b.y), (c.y - a.y, c.x - a.x));
            clockwise[lane] = area.signum();
        }
        for (edge, [a, b]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            for lane in 0..BATCH {
                let (a, b, sign) = (a[lane], b[lane], clockwise[lane]);
                let (right, down) = (sign * (a.y - b.y), sign * (b.x - a.x));
                let is_on = (right > 0) | (right == 0) & (down > 0);
                let [x, y] = [centre(self.left[lane]) - a.x, centre(self.top[lane]) - a.y];
                self.at[edge][lane] = sum((right, down), (x, y)).wrapping_sub((!is_on).into());
                self.right[edge][lane] = right.wrapping_mul(SUBPIXELS);
                self.down[edge][lane] = down.wrapping_mul(SUBPIXELS);
                for (more, [x, y]) in self.more.iter_mut().zip(places) {
                    more[edge][lane] = sum((right, down), (*x, *y));
                }
            }
        }
    }

    /// Whether all triangles of the batch are small.
    #[inline(always)]
    pub(crate) fn are_all_small(&self) -> bool {
        self.is_small.iter().all(|is_small| *is_small)
    }

    /// The first column of pixels that a small triangle touches, and the rows; `None` if it is not small.
    #[inline(always)]
    pub(crate) fn extent(&self, lane: usize) -> Option<(i32, Range<i32>)> {
        let lane = lane % BATCH;
        let rows = self.top[lane]..self.bottom[lane];
        self.is_small[lane].then_some((self.left[lane], rows))
    }

    /// The pixels of a small triangle, two rows at a time, beginning at one of its rows.
    #[inline(always)]
    pub(crate) fn rows_from<S: Simd>(&self, simd: S, lane: usize, row: i32) -> SmallRows<'_, S> {
        const COLUMN: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7];
        const ROW: [i32; LANES] = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1];
        let lane = lane % BATCH;
        let (column, below) = (i32x16::simd_from(simd, COLUMN), i32x16::simd_from(simd, ROW));
        let mut edges = [i32x16::splat(simd, 0); 3];
        for (edge, functions) in edges.iter_mut().enumerate() {
            let down = self.down[edge][lane];
            let at = self.at[edge][lane] + down * (row - self.top[lane]);
            *functions = column * self.right[edge][lane] + below * down + at;
        }
        SmallRows { triangle: self, lane, edges }
    }
}

/// The pixels of a small triangle, from two rows to the next two.
pub(crate) struct SmallRows<'t, S: Simd> {
    triangle: &'t SmallTriangles,
    lane: usize,
    /// The functions of the edges at the pixels' centres.
    edges: [i32x16<S>; 3],
}

impl<S: Simd> SmallRows<'_, S> {
    /// The pixels of two rows, from the first column on, that are covered at each sample; of the lower row the
    /// upper eight bits. Returns those that any sample covers.
    #[inline(always)]
    pub(crate) fn next_pair(&mut self, samples: &mut [u16]) -> u32 {
        let SmallTriangles { more, down, .. } = self.triangle;
        let (lane, [a, b, c]) = (self.lane % BATCH, &mut self.edges);
        let mut any = 0;
        for (covered, more) in samples.iter_mut().zip(more) {
            let functions = (*a + more[0][lane]) | (*b + more[1][lane]) | (*c + more[2][lane]);
            *covered = functions.simd_ge(0).to_bitmask() as u16;
            any |= u32::from(*covered);
        }
        *a += 2 * down[0][lane];
        *b += 2 * down[1][lane];
        *c += 2 * down[2][lane];
        any
    }
}

/// The pixel that a place in subpixels lies in.
#[inline(always)]
fn pixel(subpixels: i32) -> i32 {
    subpixels.div_euclid(SUBPIXELS)
}

/// A pixel's centre in subpixels.
#[inline(always)]
fn centre(pixel: i32) -> i32 {
    pixel * SUBPIXELS + HALF_PIXEL as i32
}

/// a times x and b times y, without regard to what is too large.
#[inline(always)]
fn sum((a, b): (i32, i32), (x, y): (i32, i32)) -> i32 {
    a.wrapping_mul(x).wrapping_add(b.wrapping_mul(y))
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::SmallTriangles;
    use crate::coverage::EdgeTable;
    use crate::render::samples::pattern::Samples;
    use crate::scalar::BATCH;
    use crate::subpixel::SubpixelPoint;
    use crate::test_rng::Rng;

    /// A small triangle, some of it on samples or centres, without area, thin or high.
    fn triangle(rng: &mut Rng) -> [SubpixelPoint; 3] {
        let height = [256, 1024, 2048, 65_000][rng.below(4) as usize];
        let width = [256, 1024, 1800][rng.below(3) as usize];
        let corner = [0; 2].map(|_| rng.within(-(1 << 24)..1 << 24));
        let unit = [1, 1, 16, 128][rng.below(4) as usize];
        let place = |rng: &mut Rng, corner: i32, size: i32| {
            (corner + rng.within(0..size)).div_euclid(unit) * unit
        };
        [0; 3].map(|_| SubpixelPoint {
            x: place(rng, corner[0], width),
            y: place(rng, corner[1], height),
        })
    }

    /// The pixels of a triangle's rows that are covered at each sample, by the edge table.
    fn by_edges(points: &[SubpixelPoint; 3], samples: Samples) -> Vec<[i32; 3]> {
        let mut table = EdgeTable::new();
        let mut covered = Vec::new();
        for (sample, [x, y]) in samples.places().iter().enumerate() {
            let moved = points.map(|p| SubpixelPoint { x: p.x - x, y: p.y - y });
            table.fill(&moved, i32::MIN / 512..i32::MAX / 512);
            let pixels = table.runs().flat_map(|run| run.x.map(move |x| (x, run.y)));
            covered.extend(pixels.map(|(x, y)| [sample as i32, y, x]));
        }
        covered.sort_unstable();
        covered
    }

    #[test]
    fn small_triangles_cover_the_samples_that_their_edges_say() {
        let mut rng = Rng(0x9e37_79b9_7f4a_7c15);
        let (mut small, mut pixels) = (0, 0);
        for round in 0..3000 {
            let samples = [Samples::Four, Samples::Eight, Samples::Sixteen][round % 3];
            let triangles = [0; BATCH].map(|_| triangle(&mut rng));
            let points = [0, 1, 2].map(|corner| triangles.map(|points| points[corner]));
            let mut batch = SmallTriangles::default();
            batch.set_up(&points, samples.places());
            for (lane, points) in triangles.iter().enumerate() {
                let Some((left, rows)) = batch.extent(lane) else { continue };
                let mut covered = Vec::new();
                dispatch!(Level::new(), simd => {
                    let mut found = batch.rows_from(simd, lane, rows.start);
                    for y in rows.step_by(2) {
                        let mut bits = [0; 16];
                        let any = found.next_pair(&mut bits[..samples.count()]);
                        assert_eq!(any, bits.iter().fold(0, |any, bits| any | u32::from(*bits)));
                        for (sample, bits) in bits.iter().enumerate() {
                            let lanes = (0..16).filter(|lane| bits >> lane & 1 != 0);
                            covered.extend(lanes.map(|lane| {
                                [sample as i32, y + lane / 8, left + lane % 8]
                            }));
                        }
                    }
                });
                covered.sort_unstable();
                assert_eq!(covered, by_edges(points, samples), "{points:?}, {samples:?}");
                (small, pixels) = (small + 1, pixels + covered.len());
            }
        }
        assert!(small > 15_000 && pixels > 1_000_000, "{small} triangles, {pixels} samples");
    }
}
