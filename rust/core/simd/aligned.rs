//! Numbers aligned to a line of the cache, so that no vector crosses two.

use std::ops::{Deref, DerefMut};

/// Processors first compare the lowest bits of addresses: a load waits for an earlier store a multiple of this away [bytes].
const PAGE: usize = 4096;

/// Numbers of which the first has an address that is a multiple of [`PAGE`], or so many bytes more.
#[derive(Debug)]
pub(crate) struct Aligned<T> {
    values: Vec<T>,
    start: usize,
    count: usize,
}

impl<T: Copy> Aligned<T> {
    /// So many of the same number.
    pub(crate) fn new(value: T, count: usize, bytes: usize) -> Aligned<T> {
        let values = vec![value; count + (PAGE + bytes) / size_of::<T>()];
        let start = values.as_ptr().align_offset(PAGE) + bytes / size_of::<T>();
        Aligned { values, start, count }
    }
}

impl<T> Default for Aligned<T> {
    fn default() -> Aligned<T> {
        Aligned { values: Vec::new(), start: 0, count: 0 }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.values[self.start..][..self.count]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values[self.start..][..self.count]
    }
}
