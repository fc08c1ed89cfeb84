//! Depth tests: when a fragment passes.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x16, mask32x16};

use crate::fragment::LANES;
use crate::settings::DepthMode;

/// When a fragment passes, by its depth and the depth stored for its pixel. Which of two depths is
/// nearer, [`DepthMode`] says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthTest {
    /// Never.
    Never,
    /// If it is nearer: the nearest wins, and the first of equals.
    #[default]
    Nearer,
    /// If its depth is equal.
    Equal,
    /// If it is nearer, or as near.
    NearerOrEqual,
    /// If it is farther.
    Farther,
    /// If its depth is different.
    NotEqual,
    /// If it is farther, or as far.
    FartherOrEqual,
    /// Always.
    Always,
}

/// A depth test in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comparison {
    Never,
    Less,
    Equal,
    LessEqual,
    Greater,
    NotEqual,
    GreaterEqual,
    Always,
}

impl DepthTest {
    /// What the test means for the numbers.
    pub(crate) fn comparison(self, mode: DepthMode) -> Comparison {
        let is_greater_nearer = mode.is_greater_nearer();
        match self {
            Self::Never => Comparison::Never,
            Self::Equal => Comparison::Equal,
            Self::NotEqual => Comparison::NotEqual,
            Self::Always => Comparison::Always,
            Self::Nearer if is_greater_nearer => Comparison::Greater,
            Self::Nearer => Comparison::Less,
            Self::NearerOrEqual if is_greater_nearer => Comparison::GreaterEqual,
            Self::NearerOrEqual => Comparison::LessEqual,
            Self::Farther if is_greater_nearer => Comparison::Less,
            Self::Farther => Comparison::Greater,
            Self::FartherOrEqual if is_greater_nearer => Comparison::LessEqual,
            Self::FartherOrEqual => Comparison::GreaterEqual,
        }
    }
}

impl Comparison {
    /// Which lanes pass, a bit a lane.
    #[inline(always)]
    pub(crate) fn passes<S: Simd>(self, new: f32x16<S>, old: f32x16<S>) -> u32 {
        // Less, equal or greater, and whether it is the others that pass, as NaN does then. All three
        // are less code than a branch for each test.
        let (less, equal, greater, others) = match self {
            Self::Never => (false, false, false, false),
            Self::Less => (true, false, false, false),
            Self::Equal => (false, true, false, false),
            Self::LessEqual => (true, true, false, false),
            Self::Greater => (false, false, true, false),
            Self::NotEqual => (false, true, false, true),
            Self::GreaterEqual => (false, true, true, false),
            Self::Always => (false, false, false, true),
        };
        let bits = |wanted: bool, mask: mask32x16<S>| {
            if wanted { bitmask(new.simd, mask) } else { 0 }
        };
        let mut passes = bits(less, new.simd_lt(old));
        passes |= bits(equal, new.simd_eq(old));
        passes |= bits(greater, new.simd_gt(old));
        if others { !passes } else { passes }
    }
}

/// The lanes that are set, a bit a lane.
#[inline(always)]
fn bitmask<S: Simd>(simd: S, mask: mask32x16<S>) -> u32 {
    if !simd.level().is_fallback() {
        return mask.to_bitmask() as u32;
    }
    // Without SIMD a loop that the compiler may turn into it: a lane that is set has all bits.
    let lanes = <[i32; LANES]>::from(mask);
    lanes.iter().enumerate().fold(0, |bits, (lane, all)| bits | *all as u32 & 1 << lane)
}
