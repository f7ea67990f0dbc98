//! In which order unknowns are eliminated.

use super::{FactorError, SymmetricPattern};

/// The order of elimination, which decides how many entries the factor has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ordering {
    /// Minimum degree, or nested dissection where the factor is large for its unknowns and that makes it smaller.
    #[default]
    Automatic,
    /// As the unknowns are numbered.
    Natural,
    /// Approximate minimum degree (AMD).
    MinimumDegree,
    /// Nested dissection by METIS; minimum degree without the feature `metis`.
    NestedDissection,
    /// The k-th unknown eliminated is the k-th of these.
    Given(Vec<usize>),
}

/// The same elimination by a postorder of its tree: columns of the factor with the same entries then follow each
/// other, and are computed as one dense block. The factor has as many entries as before.
///
/// # Errors
/// `order` does not name each unknown once.
pub fn postordered(pattern: &SymmetricPattern, order: &[usize]) -> Result<Vec<usize>, FactorError> {
    let parents = elimination_tree(pattern, order)?;
    // children in ascending order, as two linked lists
    let n = order.len();
    let (mut first_child, mut next) = (vec![n; n], vec![n; n]);
    let mut roots = n;
    for k in (0..n).rev() {
        let head = match parents[k] {
            parent if parent < n => &mut first_child[parent],
            _ => &mut roots,
        };
        next[k] = std::mem::replace(head, k);
    }
    let mut postorder = Vec::with_capacity(n);
    let mut k = roots;
    while k < n {
        while first_child[k] < n {
            k = std::mem::replace(&mut first_child[k], n); // down, once
        }
        postorder.push(order[k]);
        k = match next[k] {
            sibling if sibling < n => sibling,
            _ => parents[k],
        };
    }
    Ok(postorder)
}

/// The inverse of a permutation.
pub(super) fn inverse(order: &[usize]) -> Result<Vec<usize>, FactorError> {
    let n = order.len();
    let mut inverse = vec![n; n];
    for (k, &unknown) in order.iter().enumerate() {
        match inverse.get_mut(unknown) {
            Some(place) if *place == n => *place = k,
            _ => return Err(FactorError::Order { n }),
        }
    }
    Ok(inverse)
}

/// The parent of each step of the elimination: the row of the first entry below the diagonal of its
/// column of the factor; n at the roots (Liu's algorithm with compressed paths).
fn elimination_tree(
    pattern: &SymmetricPattern,
    order: &[usize],
) -> Result<Vec<usize>, FactorError> {
    let n = order.len();
    if n != pattern.dim() {
        return Err(FactorError::Order { n: pattern.dim() });
    }
    let step = inverse(order)?;
    let steps = || pattern.iter().map(|(i, j)| (step[i], step[j]));
    let entries = || steps().map(|(a, b)| (a.max(b), a.min(b)));
    // the columns of the entries row by row; starts[row + 1] is where the next of a row goes
    let mut starts = vec![0; n + 2];
    entries().for_each(|(row, _)| starts[row + 2] += 1);
    (2..n + 2).for_each(|k| starts[k] += starts[k - 1]);
    let mut columns = vec![0; pattern.len()];
    for (row, col) in entries() {
        columns[starts[row + 1]] = col;
        starts[row + 1] += 1;
    }
    let (mut parents, mut ancestors) = (vec![n; n], vec![n; n]);
    for row in 0..n {
        for &col in &columns[starts[row]..starts[row + 1]] {
            let mut k = col;
            while k < row {
                let above = std::mem::replace(&mut ancestors[k], row);
                if above == n {
                    parents[k] = row;
                }
                k = above;
            }
        }
    }
    Ok(parents)
}

/// Nested dissection of the pattern's graph, postordered; nothing where METIS is not there or fails.
#[cfg(not(feature = "metis"))]
pub(super) fn nested_dissection(_: &SymmetricPattern) -> Option<Vec<usize>> {
    None
}

/// Nested dissection of the pattern's graph, postordered; nothing where METIS is not there or fails.
#[cfg(feature = "metis")]
#[allow(unsafe_code)] // the call of METIS
pub(super) fn nested_dissection(pattern: &SymmetricPattern) -> Option<Vec<usize>> {
    use std::sync::Mutex;

    /// METIS draws from the process's one source of random numbers, seeded at its start.
    static METIS: Mutex<()> = Mutex::new(());

    let mut n = metis_sys::idx_t::try_from(pattern.dim()).ok()?;
    let (mut starts, mut neighbours) = graph(pattern)?;
    if neighbours.is_empty() {
        return Some((0..pattern.dim()).collect());
    }
    let (mut order, mut inverse) = (vec![0; pattern.dim()], vec![0; pattern.dim()]);
    let status = {
        let _one_at_a_time = METIS.lock();
        // SAFETY: `starts` has n + 1 ascending entries from 0 to the length of `neighbours`, whose entries are below n
        // and name each edge from both ends; `order` and `inverse` have n entries; METIS takes null for defaults.
        unsafe {
            metis_sys::METIS_NodeND(
                &mut n,
                starts.as_mut_ptr(),
                neighbours.as_mut_ptr(),
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                order.as_mut_ptr(),
                inverse.as_mut_ptr(),
            )
        }
    };
    if status != metis_sys::rstatus_et_METIS_OK {
        return None;
    }
    let order: Vec<usize> = order.into_iter().map(|k| k as usize).collect();
    postordered(pattern, &order).ok()
}

/// The neighbours of each unknown, one after the other, and where they start; nothing if METIS cannot count them.
#[cfg(feature = "metis")]
fn graph(pattern: &SymmetricPattern) -> Option<(Vec<metis_sys::idx_t>, Vec<metis_sys::idx_t>)> {
    let mut starts = vec![0usize; pattern.dim() + 2];
    let edges = || pattern.iter().filter(|(i, j)| i != j);
    for (i, j) in edges() {
        starts[i + 2] += 1;
        starts[j + 2] += 1;
    }
    for k in 2..starts.len() {
        starts[k] += starts[k - 1];
    }
    let mut neighbours = vec![0; starts[starts.len() - 1]];
    metis_sys::idx_t::try_from(neighbours.len()).ok()?;
    // starts[k + 1] is where the next neighbour of k goes, and ends up where those of k + 1 start
    for (i, j) in edges() {
        for (from, to) in [(i, j), (j, i)] {
            neighbours[starts[from + 1]] = to as metis_sys::idx_t;
            starts[from + 1] += 1;
        }
    }
    starts.pop();
    Some((starts.into_iter().map(|s| s as _).collect(), neighbours))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path 0 – 1 – 2 – 3 – 4 eliminated from both ends, and an unknown of its own.
    #[test]
    fn postorders_put_subtrees_together() {
        let path: Vec<_> = (0..4).map(|k| (k + 1, k)).collect();
        let (pattern, _) = SymmetricPattern::from_entries(6, &path).expect("in range");
        let order = [0, 4, 5, 1, 3, 2];
        // steps 0 → 3 → 5 ← 4 ← 1, step 2 alone
        let parents = elimination_tree(&pattern, &order).expect("a permutation");
        assert_eq!(parents, [3, 4, 6, 5, 5, 6]);
        let post = postordered(&pattern, &order).expect("a permutation");
        assert_eq!(post, [5, 0, 1, 4, 3, 2]);
        assert_eq!(
            elimination_tree(&pattern, &post).expect("a permutation"),
            [6, 2, 5, 4, 5, 6]
        );
    }

    /// The middle line of a grid separates its halves: METIS eliminates about so many unknowns last, and every one once.
    #[cfg(feature = "metis")]
    #[test]
    fn metis_dissects_a_grid() {
        let (width, height) = (9, 41);
        let mut edges = Vec::new();
        for k in 0..width * height {
            edges.extend((k % width > 0).then(|| (k, k - 1)));
            edges.extend((k >= width).then(|| (k, k - width)));
        }
        let (pattern, _) =
            SymmetricPattern::from_entries(width * height, &edges).expect("in range");
        let order = nested_dissection(&pattern).expect("METIS is there");
        assert!(inverse(&order).is_ok());
        assert_eq!(postordered(&pattern, &order).expect("a permutation"), order);
        let separator = order[order.len() - width..].iter().map(|k| k / width);
        assert!(
            separator
                .clone()
                .all(|row| row.abs_diff(height / 2) < height / 4)
        );
        let none = SymmetricPattern::from_entries(3, &[(1, 1)])
            .expect("in range")
            .0;
        assert_eq!(nested_dissection(&none), Some(vec![0, 1, 2]));
    }

    #[test]
    fn orders_that_are_none_are_errors() {
        let (pattern, _) = SymmetricPattern::from_entries(3, &[(1, 0)]).expect("in range");
        for order in [&[0, 1][..], &[0, 1, 1], &[0, 1, 3], &[0, 1, 2, 3]] {
            let found = postordered(&pattern, order);
            assert!(matches!(found, Err(FactorError::Order { .. })), "{order:?}");
        }
    }
}
