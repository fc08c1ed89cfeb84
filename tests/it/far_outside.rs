//! Polygons that reach thousands of pixels outside of the viewport keep the digits of the parameters of
//! their visible pixels, against the paper's matrix in f64.

use crate::common::generators::{self, Rng};
use crate::common::oracle::Window;
use crate::common::{in_threads, viewport};
use polyscan::{ParameterMatrix, ScanConverter, Vertex};

/// Half a unit in the last place of a number.
fn half_ulp(value: f64) -> f64 {
    let value = value.abs() as f32;
    f64::from(value.next_up() - value) / 2.0
}

/// The worst error that was measured, in half units in the last place of the value itself, and where.
#[derive(Clone, Debug, Default)]
struct Worst {
    error: f64,
    seed: u64,
    pixels: u64,
    polygons: u64,
}

impl std::ops::Add for Worst {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (pixels, polygons) = (self.pixels + other.pixels, self.polygons + other.polygons);
        let worse = if other.error > self.error { other } else { self };
        Self { pixels, polygons, ..worse }
    }
}

/// Values this near to zero, as a part of the largest, have no digits to keep.
const NEAR_ZERO: f64 = 0.25;

fn check(seed: u64) -> Worst {
    let rng = &mut Rng::new(seed);
    let window = Window { width: [16, 100, 700][rng.below(3)], height: [16, 50][rng.below(2)] };
    let reach = rng.octaves(2000.0, 60_000.0);
    let w_ratio = if rng.once_in(4) { 1.0 } else { rng.octaves(1.0, 10.0) };
    let positions = generators::far_outside(rng, window, reach, w_ratio);
    let params = |rng: &mut Rng| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
    let triangle: [Vertex<2>; 3] =
        std::array::from_fn(|i| Vertex::new(positions[i].into(), params(rng)));
    let mut worst = Worst { seed, ..Worst::default() };
    let Some(matrix) = ParameterMatrix::new(&triangle, &viewport(window)) else { return worst };
    let mut scan = ScanConverter::new(viewport(window));
    for span in scan.spans(&triangle) {
        for f in span.fragments() {
            worst.pixels += 1;
            let (params, w) = matrix.at(f64::from(f.x) + 0.5, f64::from(f.y) + 0.5);
            let values = f.params.into_iter().zip(params);
            for (found, exact) in values.filter(|(_, exact)| exact.abs() > NEAR_ZERO) {
                let error = (f64::from(found) - exact).abs() / half_ulp(exact);
                worst.error = worst.error.max(error);
            }
            let error = (f64::from(f.w) - w).abs() / half_ulp(w);
            worst.error = worst.error.max(error);
        }
    }
    worst.polygons = u64::from(worst.pixels > 0);
    worst
}

#[test]
fn parameters_keep_their_digits_where_they_are_seen() {
    let worst = in_threads(0..3000, check);
    println!("far outside: {worst:?}");
    assert!(worst.polygons > 2000 && worst.pixels > 1_000_000, "{worst:?}");
    assert!(worst.error < 16.0, "seed {}: {worst:?}", worst.seed);
}
