//! From clip space to the 256ths of a pixel.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive};

use super::clipping::clip_to_view;
use super::{Depth, Exact, Position, STEPS, Snapped, Window};

/// Where the vertex falls on the screen, in pixels, y down, exactly.
pub(crate) fn project(p: &Exact, window: Window) -> [BigRational; 2] {
    let half = |size: u32| BigRational::new(size.into(), 2.into());
    let x = (&p[0] / &p[3] + BigRational::one()) * half(window.width);
    let y = (BigRational::one() - &p[1] / &p[3]) * half(window.height);
    [x, y]
}

/// Where the vertex falls on the screen, rounded to 1/256 pixel, half to even.
pub(crate) fn snap(p: &Exact, window: Window) -> Snapped {
    let [x, y] = project(p, window).map(|c| round_half_even(&(c * BigInt::from(STEPS))));
    (x, y)
}

/// The nearest whole number, of two equally near ones the even one.
pub(crate) fn round_half_even(value: &BigRational) -> i64 {
    let below = value.floor().to_integer();
    let rest = value - BigRational::from_integer(below.clone());
    let up = match rest.cmp(&BigRational::new(1.into(), 2.into())) {
        Ordering::Less => false,
        Ordering::Equal => below.is_odd(),
        Ordering::Greater => true,
    };
    (below + i32::from(up)).to_i64().expect("a screen position inside the guard band")
}

/// The polygon's outline on the screen: clipped, projected, rounded.
pub(crate) fn outline(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<Snapped> {
    clip_to_view(polygon, window, depth, guard).iter().map(|p| snap(p, window)).collect()
}

/// The same outline before the rounding, in pixels, each coordinate the nearest f64.
pub(crate) fn unrounded_outline(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<[f64; 2]> {
    let clipped = clip_to_view(polygon, window, depth, guard);
    clipped.iter().map(|p| project(p, window).map(|c| nearest(&c))).collect()
}

pub(super) fn nearest(value: &BigRational) -> f64 {
    value.to_f64().expect("every rational number has a nearest f64")
}
