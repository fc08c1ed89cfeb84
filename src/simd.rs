//! Which SIMD instructions code is compiled for.

/// Runs code for the SIMD instructions of a level, as `fearless_simd::dispatch!` does, for fewer levels:
/// what SSE4.2 adds to SSE2 gains nothing here, and each level is compiled once for every shader.
macro_rules! for_level {
    ($level:expr, $simd:ident => $code:expr) => {{
        let level: ::fearless_simd::Level = $level;
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let level = if level.as_avx2().is_none()
            && let Some(sse2) = level.as_sse2()
        {
            ::fearless_simd::Simd::level(sse2)
        } else {
            level
        };
        ::fearless_simd::dispatch!(level, $simd => $code)
    }};
}

pub(crate) use for_level;
