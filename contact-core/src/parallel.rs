//! Work on independent items: one after the other, or with the feature `threads` on rayon's pool.

/// What `compute` makes of each item, in their order, or the first error in that order.
///
/// Without a second thread, the items that follow an error are left out.
pub(crate) fn try_map<T: Send, R: Send, E: Send>(
    items: impl IntoIterator<Item = T>,
    compute: impl Fn(T) -> Result<R, E> + Send + Sync,
) -> Result<Vec<R>, E> {
    #[cfg(feature = "threads")]
    let items = {
        use rayon::prelude::*;
        let items: Vec<T> = items.into_iter().collect();
        if items.len() > 1 && rayon::current_num_threads() > 1 {
            let computed: Vec<_> = items.into_par_iter().map(compute).collect();
            return computed.into_iter().collect();
        }
        items
    };
    items.into_iter().map(compute).collect()
}
