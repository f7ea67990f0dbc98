//! Work on independent items: one after the other, or with the feature `threads` on rayon's pool.
//!
//! Each item is computed by itself, and sums are taken in the items' order. Neither the feature nor the number of
//! threads changes a bit of the result.

use std::ops::Range;

/// Computes the items 0 to `count` − 1 and hands each to `take`, in this order.
///
/// Parts of [`BYTES`] are computed in parallel. The one before is taken meanwhile.
#[cfg(feature = "threads")]
pub(crate) fn in_order<T: Send + Sync>(
    count: usize,
    compute: impl Fn(usize) -> T + Send + Sync,
    mut take: impl FnMut(usize, &T) + Send,
) {
    use rayon::prelude::*;

    if is_serial::<T>(count) {
        return (0..count).for_each(|k| take(k, &compute(k)));
    }
    let part = (BYTES / size_of::<T>().max(1)).max(1);
    let fill = |first: usize, items: &mut Vec<T>| {
        let range = first.min(count)..(first + part).min(count);
        range.into_par_iter().map(&compute).collect_into_vec(items);
    };
    let (mut now, mut next) = (Vec::new(), Vec::new());
    fill(0, &mut now);
    for first in (0..count).step_by(part) {
        let take = || (first..).zip(&now).for_each(|(k, item)| take(k, item));
        rayon::join(take, || fill(first + part, &mut next));
        std::mem::swap(&mut now, &mut next);
    }
}

/// Computes the items 0 to `count` − 1 and hands each to `take`, in this order.
#[cfg(not(feature = "threads"))]
pub(crate) fn in_order<T>(
    count: usize,
    compute: impl Fn(usize) -> T,
    mut take: impl FnMut(usize, &T),
) {
    (0..count).for_each(|k| take(k, &compute(k)));
}

/// Calls `fill` with k and the k-th `size` entries of `into`, for all k.
pub(crate) fn fill<T: Send>(
    into: &mut [T],
    size: usize,
    fill: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    if !is_serial::<T>(into.len()) {
        use rayon::prelude::*;
        let chunks = into.par_chunks_mut(size).enumerate();
        return chunks.for_each(|(k, chunk)| fill(k, chunk));
    }
    let chunks = into.chunks_mut(size).enumerate();
    chunks.for_each(|(k, chunk)| fill(k, chunk));
}

/// What `compute` makes of neighbouring parts of 0 to `count` − 1, in their order. Parts have `size` items, the last
/// one fewer; where all is done by one thread, they are one.
pub(crate) fn parts<T: Send>(
    count: usize,
    size: usize,
    compute: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Vec<T> {
    #[cfg(feature = "threads")]
    if count > size && rayon::current_num_threads() > 1 {
        use rayon::prelude::*;
        let parts = (0..count.div_ceil(size)).into_par_iter();
        let part = |k: usize| compute(k * size..count.min((k + 1) * size));
        return parts.map(part).collect();
    }
    let _ = size;
    vec![compute(0..count)]
}

/// So many bytes of items are computed before they are taken: they stay in the caches.
#[cfg(feature = "threads")]
const BYTES: usize = 1 << 20;

/// Fewer bytes of items are left to the thread that asks.
///
/// Deformations, forces and stiffnesses, P1 in the plane to P2 in space, take 0.15 to 0.3 ns a byte, so that these take
/// 0.1 ms. To hand work to a second thread and wait for it takes 0.02 to 0.05 ms.
#[cfg(feature = "threads")]
const SMALL: usize = 400_000;

/// Whether `count` items are left to the thread that asks.
#[cfg(feature = "threads")]
fn is_serial<T>(count: usize) -> bool {
    count * size_of::<T>() < SMALL || rayon::current_num_threads() == 1
}

#[cfg(all(test, feature = "threads"))]
mod tests {
    use super::*;

    /// What `run` returns on pools of one, two and three threads.
    fn on_pools<T: Send>(run: impl Fn() -> T + Send + Sync) -> [T; 3] {
        [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().expect("threads").install(&run)
        })
    }

    /// Terms whose sum depends on their order.
    fn term(k: usize) -> f64 {
        (1.0 + k as f64).sin() * 10f64.powi(k as i32 % 9)
    }

    #[test]
    fn items_are_taken_in_their_order() {
        let count = 2 * BYTES / size_of::<f64>() + 7;
        let serial: f64 = (0..count).map(term).sum();
        let backwards: f64 = (0..count).rev().map(term).sum();
        assert_ne!(serial.to_bits(), backwards.to_bits());
        let sums = on_pools(|| {
            let (mut sum, mut next) = (0.0, 0);
            in_order(count, term, |k, term| {
                assert_eq!(k, next);
                next += 1;
                sum += term;
            });
            assert_eq!(next, count);
            sum
        });
        assert_eq!(sums.map(f64::to_bits), [serial.to_bits(); 3]);
        on_pools(|| in_order(0, term, |_, _| panic!("no item")));
    }

    #[test]
    fn entries_and_parts_have_their_places() {
        let count = SMALL / size_of::<f64>() + 5;
        let filled = on_pools(|| {
            let mut into = vec![0.0; count];
            fill(&mut into, 3, |k, part| {
                (3 * k..).zip(part).for_each(|(k, x)| *x = term(k));
            });
            into
        });
        let expected: Vec<f64> = (0..count).map(term).collect();
        assert!(filled.iter().all(|filled| *filled == expected));
        for count in [0, 1, 16, 17, 100] {
            let joined = on_pools(|| parts(count, 16, |part| part.collect::<Vec<_>>()).concat());
            assert!(
                joined
                    .iter()
                    .all(|joined| joined.iter().copied().eq(0..count))
            );
        }
    }
}
