//! Refactoring and solving again take no memory.
#![allow(unsafe_code)] // an allocator

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use contact_core::linear::{Analysis, Cholesky, Factor, Kind, Ordering, SymmetricPattern};

/// The system's allocator, which counts for every thread.
struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: all work is the system allocator's, called with what this one is called with.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        // SAFETY: as for this function.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as for this function.
        unsafe { System.dealloc(place, layout) }
    }
}

/// The Laplacian of a cube of n³ points: its factor is stored by columns for small n, by blocks for large n.
fn laplacian(n: usize) -> (SymmetricPattern, Vec<f64>) {
    let mut entries = Vec::new();
    for k in 0..n.pow(3) {
        entries.push((k, k, 6.5));
        let steps = [1, n, n * n].into_iter().filter(|step| k / step % n > 0);
        entries.extend(steps.map(|step| (k, k - step, -1.0)));
    }
    SymmetricPattern::from_sums(n.pow(3), &entries).expect("in range")
}

#[test]
fn refactoring_and_solving_take_no_memory() {
    for (n, has_blocks) in [(4, false), (10, true)] {
        let (pattern, mut values) = laplacian(n);
        let analysis = Analysis::new(&pattern, &Ordering::Natural).expect("a fine pattern");
        for kind in [Kind::Llt, Kind::Ldlt] {
            let mut factor = Cholesky::new(&analysis, kind).expect("memory");
            assert_eq!(factor.panels().any(|panel| panel.size > 1), has_blocks);
            let mut b = vec![1.0; 100 * pattern.dim()];
            factor.refactor(&values).expect("definite");
            factor.solve(&mut b).expect("factored"); // so many sides want more memory, once
            values[0] += 1.0;
            let before = COUNT.get();
            factor.refactor(&values).expect("definite");
            factor.solve(&mut b).expect("factored");
            factor.solve(&mut b[..pattern.dim()]).expect("factored");
            assert_eq!(COUNT.get() - before, 0, "{kind:?}, n = {n}");
        }
    }
}
