//! What can be wrong with what parameters are to be made of.

/// What can be wrong with points or corners that parameters are to be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// Fewer pairs of points than a projective mapping has freedom for.
    #[error(
        "a projective mapping takes four pairs of points, and there are only {count}: give more"
    )]
    TooFewPairs {
        /// How many there are.
        count: usize,
    },
    /// Fewer corners than a polygon has.
    #[error("a polygon has three corners or more, and this one has {count}: leave it out")]
    TooFewCorners {
        /// How many there are.
        count: usize,
    },
    /// A number that is infinite or none.
    #[error("number {index} has a coordinate or a value that is not finite: leave it out")]
    NotFinite {
        /// The number of the pair or corner, from 0.
        index: usize,
    },
    /// Points on a line, or corners without an area between them.
    #[error(
        "the points lie on a line, or all but one of them do: no mapping follows from them; take others that \
         are spread out"
    )]
    Degenerate,
    /// A mapping that would bring some points from in front of the horizon, and others from behind.
    #[error(
        "the mapping folds over: its horizon runs between the points; check that both lists have the same order, \
         or cut the quad into triangles"
    )]
    Folded,
    /// More triangles than subdivision may make.
    #[error(
        "subdivision would make more than {most} triangles: allow a larger error, or interpolate in perspective, \
         which needs none"
    )]
    TooManyTriangles {
        /// The most that it may make.
        most: usize,
    },
}
