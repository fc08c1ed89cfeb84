//! What is used of `rayon`, without threads: the same names for the standard iterators.

pub(crate) use std::iter::Iterator as IndexedParallelIterator;

/// Slices, a part or an element at a time.
pub(crate) trait ParallelSlice<T> {
    fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T>;
    fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T>;
    fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T>;
}

impl<T> ParallelSlice<T> for [T] {
    fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T> {
        self.chunks(size)
    }
    fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T> {
        self.chunks_mut(size)
    }
    fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.iter_mut()
    }
}
