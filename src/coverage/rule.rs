//! The rule that says which pixels a polygon covers.

/// Which pixels a polygon covers: by their centres, all that it touches, or those that it covers wholly.
///
/// The latter two, conservative coverage, are for bakers, which must not miss a texel, and for tests of
/// what may be hidden. All are exact: a pixel is a square without its border, a polygon is what lies
/// within its outline, rounded to 1/256 pixel.
///
/// ```
/// use glam::vec4;
/// use polyscan::{CoverageRule, OutsidePolygon, ScanConverter, Vertex, Viewport};
///
/// let triangle = [(-0.9, 0.9), (-0.9, -0.7), (0.7, 0.9)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut scan = ScanConverter::new(Viewport::new(5, 5)?);
/// let mut pixels = |rule| {
///     scan.settings.coverage_rule = rule;
///     scan.spans(&triangle).map(|span| span.columns().len()).sum::<usize>()
/// };
/// assert_eq!(pixels(CoverageRule::Centre), 10);
/// assert_eq!(pixels(CoverageRule::Outer(OutsidePolygon::Clamp)), 15);
/// assert_eq!(pixels(CoverageRule::Inner), 1);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CoverageRule {
    /// Those whose centres lie inside; of polygons that meet at an edge through a centre one has the
    /// pixel, by the top-left rule.
    #[default]
    Centre,
    /// Those that it touches: whose centre is inside, or through which its outline passes. So a polygon
    /// without area covers the pixels that it lies in.
    Outer(OutsidePolygon),
    /// Those that it covers wholly: whose centre is inside, and through which no part of its outline
    /// passes. An edge between two parts that both count as inside is part of the outline, too.
    Inner,
}

impl CoverageRule {
    /// Whether it covers pixels whose centres are not covered.
    pub(crate) fn is_outer(self) -> bool {
        matches!(self, Self::Outer(_))
    }

    /// Whether values are extrapolated to centres outside of the polygon.
    pub(crate) fn extrapolates(self) -> bool {
        self == Self::Outer(OutsidePolygon::Extrapolate)
    }
}

/// What is interpolated at pixels that a polygon touches without covering their centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OutsidePolygon {
    /// Depth, w and parameters of the polygon's nearest point: of those on the edges that pass through the
    /// pixel, the one that is nearest to its centre. Nothing leaves the range of the vertices, and a
    /// position that is interpolated lies on the polygon.
    #[default]
    Clamp,
    /// Those of the polygon's plane at the pixel's centre: they go on smoothly, and leave the range of the
    /// vertices by what changes within a pixel. w leaves it by no more than a factor of two, and where it
    /// changes so much within a pixel, parameters keep to the range. So do values that have no plane.
    Extrapolate,
}
