//! Integrals of pressures over surfaces, and their errors.

use contact_fem::contact::Surface;
use contact_fem::element::{FacetRule, facet_shapes};
use contact_fem::tensor::Vector;

/// Σ of what `add` makes of the weight, the pressure, X and the unit normal at quadrature points of the reference surface; the nodal
/// pressures are interpolated by the facets' shape functions.
pub fn integral<const D: usize>(
    surface: &Surface<D>,
    pressure: &[f64],
    add: impl Fn(f64, f64, &Vector<D>, &Vector<D>) -> f64,
) -> f64 {
    let rule = FacetRule::<D>::gauss(8);
    let mut sum = 0.0;
    for (nodes, facet) in surface.facets().zip(surface.reference()) {
        for (weight, lambda) in rule.points() {
            let shapes = nodes.iter().zip(facet_shapes(surface.order(), lambda));
            let p = shapes.map(|(&a, N)| N * pressure[a]).sum();
            let n = facet.normal(lambda);
            sum += add(weight * n.norm(), p, &facet.point(lambda), &(n / n.norm()));
        }
    }
    sum
}

/// The relative error in L² of a pressure.
pub fn error<const D: usize>(
    surface: &Surface<D>,
    pressure: &[f64],
    exact: impl Fn(&Vector<D>) -> f64,
) -> f64 {
    let off = integral(surface, pressure, |w, p, X, _| w * (p - exact(X)).powi(2));
    let size = integral(surface, pressure, |w, _, X, _| w * exact(X).powi(2));
    (off / size).sqrt()
}

/// The amplitude A of A f(X) that is nearest to a pressure in the mean square where `counts`.
pub fn amplitude<const D: usize>(
    surface: &Surface<D>,
    pressure: &[f64],
    f: impl Fn(&Vector<D>) -> f64,
    counts: impl Fn(&Vector<D>) -> bool,
) -> f64 {
    let with = |X: &Vector<D>| if counts(X) { f(X) } else { 0.0 };
    let product = integral(surface, pressure, |w, p, X, _| w * p * with(X));
    product / integral(surface, pressure, |w, _, X, _| w * with(X).powi(2))
}
