//! Lets one task write the same vertices of every item.
#![allow(
    unsafe_code,
    reason = "a task owns a range of vertices in every item: a pattern of slices that safe splitting cannot express without allocating"
)]

use std::marker::PhantomData;
use std::ops::Range;

/// S rows of N positions each. Tasks claim ranges of vertices that never overlap.
pub(super) struct DisjointRows<'a> {
    start: *mut [f32; 3],
    len: usize,
    row: usize,
    lent: PhantomData<&'a mut [[f32; 3]]>,
}

// SAFETY: the pointer comes from a unique borrow that lives as long as `self`, f32 may be
// written from any thread, and `claim` asks its callers for disjoint ranges.
unsafe impl Sync for DisjointRows<'_> {}

impl<'a> DisjointRows<'a> {
    pub fn new(all: &'a mut [[f32; 3]], row: usize) -> Self {
        Self { start: all.as_mut_ptr(), len: all.len(), row, lent: PhantomData }
    }

    /// Vertices `range` of item `item`.
    ///
    /// # Safety
    /// While the slice lives, no other may be claimed that overlaps it.
    #[allow(clippy::mut_from_ref, reason = "ranges are disjoint by the caller's promise")]
    pub unsafe fn claim(&self, item: usize, range: Range<usize>) -> &mut [[f32; 3]] {
        assert!(range.start <= range.end && range.end <= self.row);
        let first = item * self.row + range.start;
        assert!(first + range.len() <= self.len);
        // SAFETY: in bounds by the assertions, unique by the caller's promise.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(first), range.len()) }
    }
}
