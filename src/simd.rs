//! Which SIMD instructions code is compiled for.

use fearless_simd::Level;

/// Runs code for the SIMD instructions of a level, as `fearless_simd::dispatch!` does, but for three levels
/// of x86-64: what SSE4.2 adds to SSE2 gains nothing here, and each level is compiled once for every
/// shader.
///
/// Code that looks much up goes `up to AVX2`: of loops of look-ups the compiler makes gathers for AVX-512, which
/// take longer than one load after the other.
macro_rules! for_level {
    (up to AVX2: $level:expr, $simd:ident => $code:expr) => {
        $crate::simd::for_level!(@ as_avx2, as_sse2: $level, $simd => $code)
    };
    ($level:expr, $simd:ident => $code:expr) => {
        $crate::simd::for_level!(@ as_avx512, as_avx2, as_sse2: $level, $simd => $code)
    };
    (@ $($as_level:ident),+: $level:expr, $simd:ident => $code:expr) => {{
        let level: ::fearless_simd::Level = $level;
        #[cfg(all(target_arch = "x86_64", not(feature = "fallback")))]
        'drawn: {
            $(
                if let Some($simd) = level.$as_level() {
                    ::fearless_simd::Simd::vectorize(
                        $simd,
                        #[inline(always)]
                        || $code,
                    );
                    break 'drawn;
                }
            )+
        }
        #[cfg(not(all(target_arch = "x86_64", not(feature = "fallback"))))]
        ::fearless_simd::dispatch!(level, $simd => $code);
    }};
}

pub(crate) use for_level;

/// Whether a level has registers for masks, by which some lanes of a vector are stored as fast as all.
#[inline(always)]
pub(crate) fn has_mask_registers(level: Level) -> bool {
    #[cfg(target_arch = "x86_64")]
    return level.as_avx512().is_some();
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = level;
        false
    }
}
