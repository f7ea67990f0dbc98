//! What faults make of normals and feet.

use contact_core::planted;

use super::along_normals::Foot;
use super::surface::Surface;
use crate::tensor::Vector;

/// The sums of the facets' normals at the nodes.
pub(super) fn normals<const D: usize>(
    surface: &Surface<D>,
    mut sums: Vec<Vector<D>>,
) -> Vec<Vector<D>> {
    if planted!("normals are those at rest") {
        return surface.reference_normals().to_vec();
    }
    if planted!("normals are a tenth those of the next node") {
        let next = sums.iter().cycle().skip(1).copied();
        let next: Vec<_> = next.take(sums.len()).collect();
        sums.iter_mut()
            .zip(next)
            .for_each(|(sum, next)| *sum += 0.1 * next);
    }
    if planted!("the last normal is that of the first node") {
        let first = sums[0];
        sums.iter_mut().rev().take(1).for_each(|last| *last = first);
    }
    let (sin, cos) = 0.05_f64.sin_cos();
    for (k, sum) in sums.iter_mut().enumerate() {
        if planted!("normals are turned by 0.05") {
            let [a, b] = [sum[0], sum[D - 1]];
            (sum[0], sum[D - 1]) = (cos * a - sin * b, sin * a + cos * b);
        }
        if planted!("every seventh normal is reversed") && k % 7 == 3 {
            *sum = -*sum;
        }
        if planted!("components of normals are exchanged") {
            sum.swap_rows(0, D - 1);
        }
    }
    sums
}

/// A foot.
pub(super) fn foot<const D: usize>(surface: &Surface<D>, foot: Foot<D>) -> Foot<D> {
    let Foot::On(facet, mut lambda) = foot else {
        return match planted!("points beyond the end count") {
            true => Foot::None,
            false => foot,
        };
    };
    if planted!("coordinates of feet are permuted") {
        lambda.swap_rows(0, 1);
    }
    if planted!("feet are in the middle of facets") {
        lambda = Vector::repeat(1.0 / D as f64);
    }
    if planted!("feet are shifted by 0.05") {
        (lambda[0], lambda[1]) = (lambda[0] + 0.05, lambda[1] - 0.05);
    }
    if planted!("feet are shifted by 0.005") {
        (lambda[0], lambda[1]) = (lambda[0] + 0.005, lambda[1] - 0.005);
    }
    if planted!("feet are at the nearest corner") {
        lambda = crate::tensor::unit_vector(lambda.imax());
    }
    if planted!("the feet on every third facet are in its middle") && facet % 3 == 0 {
        lambda = Vector::repeat(1.0 / D as f64);
    }
    match planted!("feet are on the next facet") {
        true => Foot::On((facet + 1) % surface.len(), lambda),
        false => Foot::On(facet, lambda),
    }
}

/// The place at which test functions are taken.
pub(super) fn tests<const D: usize>(mut lambda: Vector<D>) -> Vector<D> {
    if planted!("test functions are constant") {
        lambda = Vector::repeat(1.0 / D as f64);
    }
    if planted!("test functions are a tenth constant") {
        lambda = lambda * 0.9 + Vector::repeat(0.1 / D as f64);
    }
    if planted!("test functions are exchanged") {
        lambda.swap_rows(0, 1);
    }
    lambda
}
