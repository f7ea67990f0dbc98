//! The order in which MUMPS eliminates unknowns: the driver's default, and what takes the place of an order that would
//! end the process.

use super::super::Ordering;
use super::{OptionValue, Options};
use crate::nlp::{Bounds, Structure};

/// The option and that of the restoration phase.
const NAMES: [&str; 2] = ["mumps_pivot_order", "resto.mumps_pivot_order"];

/// The number of variables above which the driver chooses MUMPS' ordering.
const LARGE: usize = 10_000;

/// The number of entries per variable in the Hessian's lower triangle from which a problem is treated as spatial:
/// elasticity has 7 on triangles, 22 and more on tetrahedra.
const DENSE: usize = 15;

/// As [`DENSE`], to tell quadratic tetrahedra (40 entries per variable and more) from linear ones.
const DENSER: usize = 32;

/// The number of variables above which PORD is slower than METIS on linear tetrahedra.
const LARGER: usize = 20_000;

/// The default ordering of MUMPS for a large problem.
///
/// In space PORD, since the factors of minimum fill are far larger there. On large meshes of linear tetrahedra METIS,
/// which shortens solves by a fifth; MUMPS takes SCOTCH where it lacks METIS. Elsewhere minimum fill: its factors are
/// as small as others and its analysis is the fastest; that of SCOTCH takes several times as long, in waiting threads.
pub(super) fn default_for(structure: &Structure) -> Option<Ordering> {
    let variables = structure.variables();
    if variables <= LARGE {
        return None;
    }
    let entries = structure.hessian().map_or(0, |hessian| hessian.len());
    Some(match entries / variables {
        0..DENSE => Ordering::Amf,
        DENSE..DENSER if variables > LARGER => Ordering::Metis,
        _ => Ordering::Pord,
    })
}

/// The orders to set before a solve, by option: those asked for, or the default, with minimum fill in place of
/// dissections that are of no use for the problem with its bounds of now.
///
/// MUMPS' dissections may be that of PORD, also where others were asked for that it lacks.
pub(in crate::ipopt) fn orders(
    structure: &Structure,
    options: &Options,
) -> Vec<(&'static str, OptionValue)> {
    let fits = has_distinct_unknowns(structure);
    let order = |name: &'static str| {
        let default = default_for(structure).filter(|_| name == NAMES[0]);
        let default = default.map(|order| order.code().into());
        let asked = options.get(name).cloned().or(default)?;
        let is_dissection = |order: Ordering| asked == order.code().into();
        let dissections = [Ordering::Scotch, Ordering::Pord, Ordering::Metis];
        Some(match dissections.into_iter().any(is_dissection) && !fits {
            true => (name, Ordering::Amf.code().into()),
            false => (name, asked),
        })
    };
    NAMES.into_iter().filter_map(order).collect()
}

/// Whether some unknowns of Ipopt's linear system have other neighbours than the rest have. PORD ends the process where
/// all have the same.
///
/// It looks at a graph whose N vertices are unknowns, or pairs of them that MUMPS makes pivots of two. If all have the
/// same neighbours, each two of them are neighbours, by an entry of their own: N (N − 1) / 2 entries at least. Of f free
/// variables and the others, N is f / 2 at least. So it is enough that there are fewer entries than f (f − 2) / 8. Slacks and
/// rows, and the entries they add, leave this true.
fn has_distinct_unknowns(structure: &Structure) -> bool {
    let Bounds { lower, upper } = structure.variable_bounds();
    let free = lower.iter().zip(upper).filter(|(l, u)| l != u).count();
    let hessian = structure.hessian().map_or(0, |hessian| hessian.len());
    let entries = hessian + structure.jacobian().len();
    entries.saturating_mul(8) < free.saturating_mul(free.saturating_sub(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nlp::Pattern;

    fn structure(n: usize, band: usize) -> Structure {
        let row = |i: usize| (i.saturating_sub(band)..=i).map(move |j| (i, j));
        let hessian = Some((0..n).flat_map(row).collect());
        Structure::new(
            Bounds::free(n),
            Bounds::default(),
            Pattern::empty(),
            hessian,
        )
        .expect("well formed")
    }

    #[test]
    fn a_dissection_stays_where_there_is_something_to_dissect() {
        for (n, band, order, expected) in [
            (1, 0, 4, 2),
            (1200, 1199, 4, 2),
            (1200, 1199, 5, 2),
            (1200, 1199, 6, 6),
            (1200, 10, 4, 4),
            (50, 1, 3, 3),
        ] {
            let asked = Options::new().with("mumps_pivot_order", order);
            let orders = orders(&structure(n, band), &asked);
            assert_eq!(orders, [("mumps_pivot_order", expected.into())]);
        }
        assert_eq!(orders(&structure(50, 1), &Options::new()), []);
    }
}
