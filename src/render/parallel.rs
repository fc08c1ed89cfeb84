//! Work on all processors: by `rayon`, or on one thread without the feature `parallel`.

use crate::render::band::Band;
use crate::render::shader::{ShadeBlocks, ShadeOnThreads};

/// Calls `f` for each item, on all processors.
pub(crate) fn for_each<T: Send>(items: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.par_iter_mut().enumerate().for_each(|(i, item)| f(i, item));
    }
    #[cfg(not(feature = "parallel"))]
    items.iter_mut().enumerate().for_each(|(i, item)| f(i, item));
}

/// Calls `f` for parts of two lists, on all processors: with the number of the part, `a_len` elements
/// of the one and `b_len` of the other.
pub(crate) fn for_each_part<A: Send, B: Send>(
    (a, a_len): (&mut [A], usize),
    (b, b_len): (&mut [B], usize),
    f: impl Fn(usize, &mut [A], &mut [B]) + Sync,
) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let parts = a.par_chunks_mut(a_len).zip(b.par_chunks_mut(b_len));
        parts.enumerate().for_each(|(i, (a, b))| f(i, a, b));
    }
    #[cfg(not(feature = "parallel"))]
    {
        let parts = a.chunks_mut(a_len).zip(b.chunks_mut(b_len));
        parts.enumerate().for_each(|(i, (a, b))| f(i, a, b));
    }
}

/// How many threads take part.
pub(crate) fn threads() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    1
}

/// Does both, on two threads if there are two.
fn both(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    #[cfg(feature = "parallel")]
    rayon::join(a, b);
    #[cfg(not(feature = "parallel"))]
    {
        a();
        b();
    }
}

/// Does both: `deliver` on this thread, and `draw` where there is time for it.
pub(crate) fn beside<R>(draw: impl FnOnce() + Send, deliver: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    return rayon::in_place_scope(|scope| {
        scope.spawn(|_| draw());
        deliver()
    });
    #[cfg(not(feature = "parallel"))]
    {
        let result = deliver();
        draw();
        result
    }
}

/// What shades: on all threads, or on this one alone.
pub(crate) enum Shading<'a> {
    OnThreads(&'a mut dyn ShadeOnThreads),
    OnOneThread(&'a mut dyn ShadeBlocks),
}

impl Shading<'_> {
    /// The same, borrowed.
    pub(crate) fn reborrow(&mut self) -> Shading<'_> {
        match self {
            Self::OnThreads(shader) => Shading::OnThreads(&mut **shader),
            Self::OnOneThread(shader) => Shading::OnOneThread(&mut **shader),
        }
    }

    /// What shades on this thread.
    pub(crate) fn on_one_thread(&mut self) -> &mut dyn ShadeBlocks {
        match self {
            Self::OnThreads(shader) => &mut **shader,
            Self::OnOneThread(shader) => &mut **shader,
        }
    }
}

/// A function that draws one of the bands, given its number.
pub(crate) type DrawBand<'a, W> =
    dyn Fn(usize, &mut Band<'_>, &mut W, &mut dyn ShadeBlocks) + Sync + 'a;

/// Cuts a band into bands of `height` rows, the last with those that are left, and draws each with a
/// worker of its own. There must be enough of these.
pub(crate) fn for_each_band<W: Send>(
    band: &mut Band<'_>,
    height: usize,
    workers: &mut [W],
    shading: Shading<'_>,
    draw: &DrawBand<'_, W>,
) {
    match shading {
        Shading::OnThreads(shader) => halve(0, band, height, workers, shader, draw),
        Shading::OnOneThread(shader) => {
            let count = band.rows().len().div_ceil(height);
            for (number, worker) in workers.iter_mut().enumerate().take(count) {
                let (_, mut rest) = band.split(number * height);
                let rows = rest.rows().len().min(height);
                draw(number, &mut rest.split(rows).0, worker, shader);
            }
        }
    }
}

/// Draws the bands of one half beside those of the other.
fn halve<W: Send>(
    first: usize,
    band: &mut Band<'_>,
    height: usize,
    workers: &mut [W],
    shader: &mut dyn ShadeOnThreads,
    draw: &DrawBand<'_, W>,
) {
    let count = band.rows().len().div_ceil(height);
    if count <= 1 {
        if let Some(worker) = workers.first_mut() {
            draw(first, band, worker, shader);
        }
        return;
    }
    let half = count / 2;
    let (mut upper, mut lower) = band.split(half * height);
    let (upper_workers, lower_workers) = workers.split_at_mut(half.min(workers.len()));
    shader.split(lower.pixels_before, &mut |above, below| {
        both(
            || halve(first, &mut upper, height, upper_workers, above, draw),
            || halve(first + half, &mut lower, height, lower_workers, below, draw),
        );
    });
}

/// The first elements of a list that grows to have them and keeps what it has.
pub(crate) fn first<T: Default>(list: &mut Vec<T>, len: usize) -> &mut [T] {
    if list.len() < len {
        list.resize_with(len, T::default);
    }
    &mut list[..len]
}
