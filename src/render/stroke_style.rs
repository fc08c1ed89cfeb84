//! How lines and points look: their width, their joins and ends.

/// What stands where two segments of a wide line meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Join {
    /// The sides go on until they meet, unless that is farther from the corner than `limit` times half the
    /// width: then it is a bevel. 4 is usual.
    Miter {
        /// The largest distance, in halves of the width.
        limit: f32,
    },
    /// The corners of the sides are joined by a straight edge.
    Bevel,
    /// An arc around the corner.
    Round,
}

impl Default for Join {
    /// A miter, up to four times half the width.
    fn default() -> Self {
        Self::Miter { limit: 4.0 }
    }
}

/// How a wide line ends that is not closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cap {
    /// At its end.
    #[default]
    Butt,
    /// Half a width beyond its end.
    Square,
    /// In half a circle around its end.
    Round,
}

/// How lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineStyle {
    /// In pixels; `None` by the diamond-exit rule.
    pub(crate) width: Option<f32>,
    pub(crate) join: Join,
    pub(crate) cap: Cap,
    /// Whether each line goes on from its last vertex to its first.
    pub(crate) is_closed: bool,
}

impl LineStyle {
    pub(crate) const THIN: Self =
        Self { width: None, join: Join::Miter { limit: 4.0 }, cap: Cap::Butt, is_closed: false };
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointStyle {
    /// Width and height, in pixels.
    pub(crate) size: f32,
    pub(crate) is_round: bool,
}

/// What the lists of indices are that a renderer is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Figure {
    /// Faces.
    #[default]
    Faces,
    /// Lines through their vertices.
    Lines(LineStyle),
    /// Points, one at each vertex.
    Points(PointStyle),
}
