//! Which SIMD instructions code is compiled for.

/// Runs code for the SIMD instructions of a level, as `fearless_simd::dispatch!` does, but for three levels
/// of x86-64: what SSE4.2 adds to SSE2 gains nothing here, and each level is compiled once for every
/// shader.
macro_rules! for_level {
    ($level:expr, $simd:ident => $code:expr) => {{
        let level: ::fearless_simd::Level = $level;
        #[cfg(all(target_arch = "x86_64", not(feature = "fallback")))]
        if let Some($simd) = level.as_avx512() {
            ::fearless_simd::Simd::vectorize(
                $simd,
                #[inline(always)]
                || $code,
            );
        } else if let Some($simd) = level.as_avx2() {
            ::fearless_simd::Simd::vectorize(
                $simd,
                #[inline(always)]
                || $code,
            );
        } else if let Some($simd) = level.as_sse2() {
            ::fearless_simd::Simd::vectorize(
                $simd,
                #[inline(always)]
                || $code,
            );
        }
        #[cfg(not(all(target_arch = "x86_64", not(feature = "fallback"))))]
        ::fearless_simd::dispatch!(level, $simd => $code);
    }};
}

pub(crate) use for_level;
