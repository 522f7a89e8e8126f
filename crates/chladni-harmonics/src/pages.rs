//! Large memory that is fast to touch for the first time.
#![allow(unsafe_code, reason = "advice about pages, for which there is no safe interface")]

/// The size in bytes from which the advice pays.
pub(crate) const LARGE: usize = 4 << 20;

/// A vector of `len` zeros. Fresh memory costs a page fault per page, which with pages of 4 KiB adds up to
/// a tenth of a solve. The system is therefore asked for large pages, which it may or may not provide.
pub(crate) fn zeroed<T: bytemuck::Zeroable + Clone>(len: usize) -> Vec<T> {
    let memory = vec![T::zeroed(); len];
    advise(&memory);
    memory
}

#[cfg(target_os = "linux")]
fn advise<T>(memory: &[T]) {
    const PAGE: usize = 4096;
    let bytes = size_of_val(memory);
    let start = memory.as_ptr().cast::<u8>();
    let skipped = start.align_offset(PAGE);
    if bytes < LARGE || skipped > bytes {
        return;
    }
    // SAFETY: the range lies inside of `memory` and starts at a page; MADV_HUGEPAGE changes how
    // it is backed, never what is in it. Where the system has no large pages it only says so.
    unsafe {
        libc::madvise(start.add(skipped).cast_mut().cast(), bytes - skipped, libc::MADV_HUGEPAGE);
    }
}

#[cfg(not(target_os = "linux"))]
fn advise<T>(_: &[T]) {}
