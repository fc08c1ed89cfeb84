//! Rounding an f64 to an integer by one addition.
//!
//! An f64 has 52 fraction bits. Near 1.5 * 2^52 its last bit therefore counts ones, so adding that
//! number rounds what it is added to, half to even, and leaves the integer in the lowest bits of the
//! sum. This holds for numbers below 2^51, of either sign. A conversion by `as` would saturate, which
//! takes several instructions and keeps the compiler from using SIMD.

/// Added to a number below 2^51, this leaves the nearest integer in the lowest bits.
pub(crate) const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

/// The integer that [`ROUND`] was added to.
#[inline(always)]
pub(crate) fn integer(rounded: f64) -> i32 {
    rounded.to_bits() as i32
}
