//! Work on all processors: by `rayon`, or on one thread without the feature `parallel`.

use std::ops::Range;

use crate::render::band::Band;
use crate::render::shader::{ShadeBlocks, ShadeOnThreads};

/// Calls `f` for each item, on all processors.
pub(crate) fn for_each<T: Send>(items: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
    each(0, items, &f);
}

/// The items of one half beside those of the other.
fn each<T: Send>(first: usize, items: &mut [T], f: &(dyn Fn(usize, &mut T) + Sync)) {
    let half = items.len() / 2;
    match items {
        [] => {}
        [item] => f(first, item),
        items => {
            let (a, b) = items.split_at_mut(half);
            both(&mut || each(first, a, f), &mut || each(first + half, b, f));
        }
    }
}

/// A list, and how many of its elements are a part.
type InParts<'a, T> = (&'a mut [T], usize);

/// What is done with each part of two lists.
type DoPart<'a, A, B> = dyn Fn(usize, &mut [A], &mut [B]) + Sync + 'a;

/// Calls `f` for parts of two lists that have as many, on all processors, with the number of the part.
pub(crate) fn for_each_part<A: Send, B: Send>(
    a: InParts<'_, A>,
    b: InParts<'_, B>,
    f: impl Fn(usize, &mut [A], &mut [B]) + Sync,
) {
    each_part(0, a, b, &f);
}

/// The parts of one half beside those of the other.
fn each_part<A: Send, B: Send>(
    first: usize,
    (a, a_len): InParts<'_, A>,
    (b, b_len): InParts<'_, B>,
    f: &DoPart<'_, A, B>,
) {
    let count = a.len().div_ceil(a_len).min(b.len().div_ceil(b_len));
    if count <= 1 {
        if count == 1 {
            f(first, a, b);
        }
        return;
    }
    let half = count / 2;
    let ((a, next_a), (b, next_b)) = (a.split_at_mut(half * a_len), b.split_at_mut(half * b_len));
    let mut before = || each_part(first, (&mut *a, a_len), (&mut *b, b_len), f);
    let mut after = || each_part(first + half, (&mut *next_a, a_len), (&mut *next_b, b_len), f);
    both(&mut before, &mut after);
}

/// How many threads take part.
pub(crate) fn threads() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    1
}

/// Does both, on two threads if there are two. It is compiled once, whatever is done.
fn both(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    #[cfg(feature = "parallel")]
    if threads() > 1 {
        rayon::join(a, b);
        return;
    }
    // A pool's only thread does nothing sooner than this one, in whose caches the pixels may be.
    a();
    b();
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

/// Bands of as many rows each, but for the last.
#[derive(Clone, Debug)]
pub(crate) struct Bands {
    /// The rows of each.
    pub(crate) height: usize,
    /// The numbers of those to draw.
    pub(crate) numbers: Range<usize>,
    /// Whether they are so much work that handing it to threads pays.
    pub(crate) are_shared: bool,
}

impl Bands {
    /// All of a target.
    pub(crate) fn of(target: &Band<'_>, height: usize) -> Self {
        let numbers = 0..target.rows().len().div_ceil(height);
        Self { height, numbers, are_shared: true }
    }
}

/// Cuts a band into bands, and draws each with a worker of its own. There must be enough of these.
pub(crate) fn for_each_band<W: Send>(
    band: &mut Band<'_>,
    bands: Bands,
    workers: &mut [W],
    mut shading: Shading<'_>,
    draw: &DrawBand<'_, W>,
) {
    let Bands { height, numbers, are_shared } = bands;
    let Some(workers) = workers.get_mut(numbers.clone()).filter(|workers| !workers.is_empty())
    else {
        return;
    };
    let (_, mut rest) = band.split(numbers.start * height);
    let rows = rest.rows().len().min(numbers.len() * height);
    let mut band = rest.split(rows).0;
    if are_shared && let Shading::OnThreads(shader) = shading {
        return halve(numbers.start, &mut band, height, workers, shader, draw);
    }
    let shader = shading.on_one_thread();
    for (i, (number, worker)) in numbers.zip(workers).enumerate() {
        let (_, mut rest) = band.split(i * height);
        let rows = rest.rows().len().min(height);
        draw(number, &mut rest.split(rows).0, worker, shader);
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
        let mut draw_upper = || halve(first, &mut upper, height, upper_workers, above, draw);
        let first = first + half;
        let mut draw_lower = || halve(first, &mut lower, height, lower_workers, below, draw);
        both(&mut draw_upper, &mut draw_lower);
    });
}

/// The first elements of a list that grows to have them and keeps what it has.
pub(crate) fn first<T: Default>(list: &mut Vec<T>, len: usize) -> &mut [T] {
    if list.len() < len {
        list.resize_with(len, T::default);
    }
    &mut list[..len]
}
