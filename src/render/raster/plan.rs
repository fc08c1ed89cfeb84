//! What is done with fragments, and which code does it.

use crate::render::band::Band;
use crate::render::coarse_depth::CoarseDepth;
use crate::render::depth::{Comparison, DepthTest};
use crate::settings::DepthMode;

/// What to do with fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Plan {
    pub(crate) comparison: Comparison,
    /// Whether depth is stored.
    pub(crate) writes: bool,
    /// Whether depth is 1/w, not z.
    pub(crate) is_inverse_w: bool,
    /// Whether pixels are counted, or have a stencil: the band has what that takes.
    pub(crate) has_extras: bool,
}

impl Plan {
    /// The settings of nearly all draw calls: for them the loops are compiled on their own.
    pub(crate) const COMMON: Self =
        Self { comparison: Comparison::Less, writes: true, is_inverse_w: false, has_extras: false };

    pub(crate) fn new(test: DepthTest, writes: bool, mode: DepthMode) -> Self {
        let is_inverse_w = mode == DepthMode::InverseW;
        Self { comparison: test.comparison(mode), writes, is_inverse_w, has_extras: false }
    }

    /// Prepares a coarse depth for a band; whether it helps. What it hides would not be counted, and would
    /// leave the stencil as it is.
    pub(crate) fn restart(self, coarse: &mut CoarseDepth, band: &Band<'_>) -> bool {
        !self.is_inverse_w
            && !self.has_extras
            && coarse.restart(self.comparison, band.width, band.rows().len())
    }
}

/// A plan, as a constant where the code is compiled for one.
pub(crate) trait PlanFor {
    fn of(plan: Plan) -> Plan;
}

/// Code that is compiled for [`Plan::COMMON`].
pub(crate) struct ForCommon;

/// Code that does for all plans.
pub(crate) struct ForAny;

impl PlanFor for ForCommon {
    #[inline(always)]
    fn of(_: Plan) -> Plan {
        Plan::COMMON
    }
}

impl PlanFor for ForAny {
    #[inline(always)]
    fn of(plan: Plan) -> Plan {
        plan
    }
}
