//! The scalar type that polygon set-up is generic over: an `f64` for one polygon, or eight lanes for
//! eight triangles that are set up at once. Both are rounded alike, so both ways lead to the same bits.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f64x8, mask64x8};

/// The number of triangles in a batch that is set up at once.
pub(crate) const BATCH: usize = 8;

/// One value for each triangle of a batch.
pub(crate) type PerTriangle<T = f64> = [T; BATCH];

/// A number of one polygon, or of each triangle of a batch.
pub(crate) trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// The given value in every lane.
    fn splat(self, value: f64) -> Self;

    fn abs(self) -> Self;

    /// The greatest power of two that is not greater than a positive normal number.
    fn power_of_two_below(self) -> Self;

    fn is_less(self, other: Self) -> Self::Mask;

    /// The first where the mask is set, the second elsewhere.
    fn select(mask: Self::Mask, first: Self, second: Self) -> Self;

    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().is_less(self.splat(f64::INFINITY))
    }

    /// The lesser; `other` if either is NaN, or if both are zeros.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::select(self.is_less(other), self, other)
    }

    /// The greater; `other` if either is NaN, or if both are zeros.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self::select(other.is_less(self), self, other)
    }

    /// The least and the greatest of three.
    #[inline(always)]
    fn range([a, b, c]: [Self; 3]) -> [Self; 2] {
        [a.lesser(b).lesser(c), a.greater(b).greater(c)]
    }
}

/// What is left of an f64's bits in a power of two.
const EXPONENT: u64 = 0x7ff << 52;

impl Scalar for f64 {
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn power_of_two_below(self) -> Self {
        Self::from_bits(self.to_bits() & EXPONENT)
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn select(mask: bool, first: Self, second: Self) -> Self {
        if mask { first } else { second }
    }
}

impl<S: Simd> Scalar for f64x8<S> {
    type Mask = mask64x8<S>;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        <Self as SimdBase<S>>::splat(self.simd, value)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        <Self as SimdBase<S>>::abs(self)
    }

    #[inline(always)]
    fn power_of_two_below(self) -> Self {
        Self::from_bits(<Self as SimdFloat<S>>::to_bits(self) & EXPONENT)
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> mask64x8<S> {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn select(mask: mask64x8<S>, first: Self, second: Self) -> Self {
        mask.select(first, second)
    }
}
