//! A frame of the CPU backend does not allocate after the first one.
#![allow(unsafe_code, reason = "counting allocations takes an allocator")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use chladni_synth::{Coefficients, CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer, Term};

struct Counting;

static ALLOCATED_BYTES: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all calls are passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED_BYTES.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn warm_frames_allocate_nothing() {
    let n: i32 = 5000;
    let positions: Vec<[f64; 3]> = (0..n).map(|v| [f64::from(v).cos(), f64::from(v).sin(), 0.1]).collect();
    let triangles: Vec<[u32; 3]> = (0..n as u32 - 2).map(|v| [v, v + 1, v + 2]).collect();
    let basis: Vec<f64> = (0..n * 40).map(|i: i32| f64::from(i).sin()).collect();
    let mut synthesizer =
        CpuSynthesizer::new(SynthModel::from_parts(&positions, &triangles, &basis).unwrap());
    let coefficients = Coefficients::Vector(vec![[0.01; 3]; 40]);
    let term = Term { coefficients, residual: None, residual_gain: 0.0, mask: None };
    let items = vec![Item { terms: vec![term] }; 12];
    let mut frames = |count: usize| {
        let before = ALLOCATED_BYTES.load(Ordering::Relaxed);
        for s in (1..=12).cycle().take(count) {
            synthesizer.synthesize(&items[..s], &FrameSettings { normal_blending: 0.5 }).unwrap();
        }
        ALLOCATED_BYTES.load(Ordering::Relaxed) - before
    };
    frames(24);
    let bytes = frames(600);
    // Rayon's queue allocates a block of some 1.5 kB once in 60 calls from outside its pool.
    assert!(bytes < 600 * 200, "{bytes} bytes in 600 frames");
}
