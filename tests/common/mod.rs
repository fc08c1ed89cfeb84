//! What the test files share: seeded shapes, exact oracles, and pictures of digits.

#![allow(dead_code, reason = "each test file compiles this module and uses its own part of it")]

pub(crate) mod generators;
pub(crate) mod oracle;

use generators::Shape;
use glam::Vec4;
use oracle::{Position, Window};
use polyscan::{ScanConverter, Vertex, Viewport};

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
            let row = span.y() as usize * window.width as usize;
            for x in span.x() {
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
