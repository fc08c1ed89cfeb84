//! What the test files share: seeded shapes, exact oracles, and pictures of digits.

pub(crate) mod crossing;
pub(crate) mod generators;
pub(crate) mod oracle;
mod shaders;

use std::fmt;
use std::ops::{Add, Range};
use std::thread;

use generators::Shape;
use glam::Vec4;
use oracle::{Position, Window};
use polyscan::{ScanConverter, Vertex, Viewport};
pub(crate) use shaders::{dynamic, dynamic_blocks, dynamic_blocks_mut, dynamic_mut};

/// The vertices of a shape from the generators.
pub(crate) fn vertices<const N: usize>(shape: &Shape<N>) -> Vec<Vertex<N>> {
    let vertex = |(&p, &params): (&Position, &[f32; N])| Vertex { position: p.into(), params };
    shape.positions.iter().zip(&shape.parameters).map(vertex).collect()
}

/// Vertices without parameters.
pub(crate) fn bare(positions: &[Position]) -> Vec<Vertex<0>> {
    positions.iter().map(|&p| Vertex::new(Vec4::from(p), [])).collect()
}

/// Vertices at screen positions in pixels, y down, with w = 1.
pub(crate) fn at_pixels(places: &[[f32; 2]], window: Window) -> Vec<Vertex<0>> {
    let place = |p: &[f32; 2]| generators::at_pixel(p.map(f64::from), 1.0, window);
    bare(&places.iter().map(place).collect::<Vec<_>>())
}

pub(crate) fn viewport(window: Window) -> Viewport {
    Viewport::new(window.width, window.height).expect("test windows are small")
}

/// How many of the polygons cover each pixel.
pub(crate) fn counts<const N: usize>(
    scan: &mut ScanConverter<N>,
    polygons: &[Vec<Vertex<N>>],
    window: Window,
) -> Vec<u32> {
    let mut counts = vec![0; window.width as usize * window.height as usize];
    for polygon in polygons {
        for span in scan.spans(polygon) {
            let row = span.row() as usize * window.width as usize;
            for x in span.columns() {
                counts[row + x as usize] += 1;
            }
        }
    }
    counts
}

/// A digit for each pixel, `.` for none: how often it is covered.
pub(crate) fn digits(counts: &[u32], width: u32) -> Vec<String> {
    let digit = |&n: &u32| if n == 0 { '.' } else { char::from_digit(n, 36).unwrap_or('+') };
    counts.chunks(width as usize).map(|row| row.iter().map(digit).collect()).collect()
}

/// The picture of some polygons in a window.
pub(crate) fn picture(polygons: &[Vec<Vertex<0>>], window: Window) -> Vec<String> {
    let mut scan = ScanConverter::new(viewport(window));
    digits(&counts(&mut scan, polygons, window), window.width)
}

/// The first seed of the long tests: none that the short ones use.
pub(crate) const LONG_SEED: u64 = 1_000_000;

/// A structure of numbers that a test counts, which add up.
macro_rules! tally {
    (
        $(#[$about:meta])*
        $vis:vis struct $name:ident {
            $($(#[$about_field:meta])* $field_vis:vis $field:ident: u64,)*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default)]
        $vis struct $name {
            $($(#[$about_field])* $field_vis $field: u64,)*
        }

        impl std::ops::Add for $name {
            type Output = Self;

            fn add(self, other: Self) -> Self {
                Self { $($field: self.$field + other.$field,)* }
            }
        }
    };
}
pub(crate) use tally;

tally! {
    /// What a test of coverage saw.
    pub(crate) struct Tally {
        pub(crate) polygons: u64,
        /// Covered pixels.
        pub(crate) pixels: u64,
        /// Pixels that should have been covered and were not.
        pub(crate) gaps: u64,
        /// Pixels covered twice, or once too often.
        pub(crate) doubles: u64,
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { polygons, pixels, gaps, doubles } = self;
        write!(f, "{polygons} polygons, {pixels} pixels, {gaps} gaps, {doubles} double hits")
    }
}

/// The sum of `one` over all seeds, which the machine's cores share.
pub(crate) fn in_threads<T: Add<Output = T> + Default + Send>(
    seeds: Range<u64>,
    one: impl Fn(u64) -> T + Sync,
) -> T {
    let cores = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let share = |core: u64| {
        let seeds = (seeds.start + core..seeds.end).step_by(cores as usize);
        seeds.fold(T::default(), |sum, seed| sum + one(seed))
    };
    thread::scope(|scope| {
        let share = &share;
        let workers: Vec<_> = (0..cores).map(|core| scope.spawn(move || share(core))).collect();
        let sums = workers.into_iter().map(thread::ScopedJoinHandle::join);
        sums.fold(T::default(), |all, sum| all + sum.expect("no worker has a finding"))
    })
}
