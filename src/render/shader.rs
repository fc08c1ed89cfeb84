//! Shaders: functions from a fragment to its colour.

/// What a shader may return: a colour of type `C`, or an `Option` of one, where `None` discards the
/// fragment, so that neither its colour nor its depth is written.
pub trait IntoColor<C> {
    /// The colour, or `None` to discard the fragment.
    fn into_color(self) -> Option<C>;
}

impl<C> IntoColor<C> for C {
    #[inline(always)]
    fn into_color(self) -> Option<C> {
        Some(self)
    }
}

impl<C> IntoColor<C> for Option<C> {
    #[inline(always)]
    fn into_color(self) -> Self {
        self
    }
}
