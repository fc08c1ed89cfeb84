//! Places on the screen.

use super::rng::Rng;
use crate::common::oracle::{Position, Window};

/// The vertex that appears at a place of the screen, with a w of at least about 1.
pub(crate) fn at_pixel(place: [f64; 2], w: f64, window: Window) -> Position {
    let x = 2.0 * place[0] / f64::from(window.width) - 1.0;
    let y = 1.0 - 2.0 * place[1] / f64::from(window.height);
    at_ndc([x, y], w)
}

pub(super) fn at_ndc(place: [f64; 2], w: f64) -> Position {
    // Rounding w first lets x/w and y/w err by their own rounding only.
    let w = f64::from(w as f32);
    [(place[0] * w) as f32, (place[1] * w) as f32, (w / 2.0 - 0.25) as f32, w as f32]
}

pub(super) fn at_pixels(
    rng: &mut Rng,
    places: &[[f64; 2]],
    w_ratio: f64,
    window: Window,
) -> Vec<Position> {
    places.iter().map(|&place| at_pixel(place, rng.octaves(1.0, w_ratio), window)).collect()
}

pub(super) fn size(window: Window) -> [f64; 2] {
    [window.width, window.height].map(f64::from)
}

pub(super) fn somewhere(rng: &mut Rng, window: Window) -> [f64; 2] {
    size(window).map(|size| rng.range(0.0, size))
}

pub(super) fn on_circle(centre: [f64; 2], radius: f64, angle: f64) -> [f64; 2] {
    [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
}

/// Half the diagonal of the viewport: a circle of this radius around its middle holds it.
pub(super) fn half_diagonal(window: Window) -> f64 {
    let [width, height] = size(window);
    width.hypot(height) / 2.0
}

pub(super) fn middle(window: Window) -> [f64; 2] {
    size(window).map(|size| size / 2.0)
}
