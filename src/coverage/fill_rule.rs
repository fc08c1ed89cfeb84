//! Fill rules: what is inside an outline.

/// What is inside an outline, by its winding number: how often it runs around a point, one
/// direction counted up and the other down.
///
/// ```
/// use glam::vec4;
/// use polyscan::{FillRule, ScanConverter, Vertex, Viewport};
///
/// // A square around another, both in the same direction.
/// let square = |size: f32| {
///     [(-size, -size), (size, -size), (size, size), (-size, size)]
///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
/// };
/// let squares = [square(1.0), square(0.5)];
/// let mut scan = ScanConverter::new(Viewport::new(4, 4)?);
/// for (rule, pixels) in [(FillRule::NonZero, 16), (FillRule::EvenOdd, 12)] {
///     scan.settings.fill_rule = rule;
///     assert_eq!(scan.spans(&squares).map(|span| span.columns().len()).sum::<usize>(), pixels);
/// }
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FillRule {
    /// Where the number is not 0. A contour makes a hole if it runs in the other direction than the
    /// one around it.
    #[default]
    NonZero,
    /// Where the number is odd. A contour makes a hole whatever its direction.
    EvenOdd,
}

impl FillRule {
    #[inline(always)]
    pub(crate) fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::EvenOdd => winding & 1 != 0,
        }
    }
}
