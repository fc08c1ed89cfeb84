//! Angles, by arithmetic that is the same everywhere: the platform's functions are not.

use std::f64::consts::PI;
#[cfg(any(test, feature = "gltf"))]
use std::f64::consts::{FRAC_PI_2, TAU};

#[cfg(any(test, feature = "gltf"))]
use glam::Vec2;

/// The cosine of an angle from 0 to pi, by its power series. The first term left out is pi^32 / 32!,
/// or 3e-20.
#[cfg(any(test, feature = "model"))]
pub(crate) fn cosine(angle: f64) -> f64 {
    let terms = (1..=15).scan(1.0, |term, k| {
        let even = 2.0 * f64::from(k);
        *term *= -angle * angle / ((even - 1.0) * even);
        Some(*term)
    });
    1.0 + terms.sum::<f64>()
}

/// The angle of a cosine, to 7e-5, which is plenty for a weight (Abramowitz and Stegun, 4.4.45).
pub(crate) fn arc_cosine(cosine: f64) -> f64 {
    let x = cosine.abs().min(1.0);
    let series = 1.570_728_8 + x * (-0.212_114_4 + x * (0.074_261 + x * -0.018_729_3));
    let angle = (1.0 - x).sqrt() * series;
    if cosine < 0.0 { PI - angle } else { angle }
}

/// The cosine and the sine of any angle in radians, to the precision of `f32`; those of 0 for one that is
/// not finite.
#[cfg(any(test, feature = "gltf"))]
pub(crate) fn direction(angle: f32) -> Vec2 {
    if angle == 0.0 || !angle.is_finite() {
        return Vec2::X;
    }
    // Cosines are those of the distance from the nearest whole turn.
    let of = |angle: f64| {
        let angle = angle.rem_euclid(TAU);
        cosine(if angle > PI { TAU - angle } else { angle }) as f32
    };
    let angle = f64::from(angle);
    Vec2::new(of(angle), of(angle - FRAC_PI_2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_the_cosine_and_the_sine() {
        for i in -2000..2000 {
            let angle = i as f32 * 0.01;
            let expected = glam::DVec2::from_angle(f64::from(angle)).as_vec2();
            assert!((direction(angle) - expected).length() < 1e-7, "{angle}");
        }
        assert_eq!(direction(f32::NAN), Vec2::X);
        assert_eq!(direction(f32::INFINITY), Vec2::X);
    }
}
