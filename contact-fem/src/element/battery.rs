//! The tests that every element passes.

use super::Element;
use crate::tensor::{Vector, unit_vector};

/// `degree` is the degree of the polynomials that the shape functions reproduce, `quadrature` that
/// of the polynomials that the quadrature integrates exactly.
pub fn battery<const D: usize, E: Element<D>>(degree: u32, quadrature: u32) {
    nodal_and_complete::<D, E>(degree);
    gradients::<D, E>();
    let points = E::QUADRATURE.iter().map(|&(w, xi)| (w, xi.into()));
    integrates::<D>(&points.collect::<Vec<_>>(), quadrature);
}

/// Corners of the unit simplex, then the middles of the edges.
fn nodes<const D: usize, E: Element<D>>() -> Vec<Vector<D>> {
    let mut nodes = vec![Vector::zeros()];
    nodes.extend((0..D).map(unit_vector::<D>));
    let middle = |edge: &[usize; 2]| (nodes[edge[0]] + nodes[edge[1]]) * 0.5;
    let middles: Vec<_> = E::EDGES.iter().map(middle).collect();
    nodes.extend(middles);
    nodes
}

/// Exponents of all monomials up to a degree.
fn monomials<const D: usize>(degree: u32) -> Vec<[u32; D]> {
    let all = (0..(degree + 1).pow(D as u32))
        .map(|k| std::array::from_fn(|i| k / (degree + 1).pow(i as u32) % (degree + 1)));
    all.filter(|powers: &[u32; D]| powers.iter().sum::<u32>() <= degree)
        .collect()
}

fn monomial<const D: usize>(powers: &[u32; D], xi: &Vector<D>) -> f64 {
    (0..D).map(|i| xi[i].powi(powers[i] as i32)).product()
}

/// N_a(ξ_b) = δ_ab, and Σ_a p(ξ_a) N_a = p for every polynomial p of the degree.
fn nodal_and_complete<const D: usize, E: Element<D>>(degree: u32) {
    let nodes = nodes::<D, E>();
    assert_eq!(E::per_node(0.0).as_ref().len(), nodes.len());
    for (b, xi) in nodes.iter().enumerate() {
        for (a, &N) in E::shapes(xi).as_ref().iter().enumerate() {
            assert_eq!(N, f64::from(u8::from(a == b)), "N_{a} at node {b}");
        }
    }
    let xi = Vector::<D>::from_fn(|i, _| 0.1 + 0.17 * i as f64);
    for powers in monomials::<D>(degree) {
        let values = nodes.iter().map(|node| monomial(&powers, node));
        let sum: f64 = values
            .zip(E::shapes(&xi).as_ref())
            .map(|(p, N)| p * N)
            .sum();
        assert!((sum - monomial(&powers, &xi)).abs() < 1e-15, "{powers:?}");
    }
}

/// ∂N_a/∂ξ against central differences, which are exact for quadratics up to round-off.
fn gradients<const D: usize, E: Element<D>>() {
    let xi = Vector::<D>::from_fn(|i, _| 0.1 + 0.07 * i as f64);
    let h = 1e-3;
    for i in 0..D {
        let step = unit_vector::<D>(i) * h;
        let (up, down) = (E::shapes(&(xi + step)), E::shapes(&(xi - step)));
        for (a, dN) in E::shape_gradients(&xi).as_ref().iter().enumerate() {
            let difference = (up.as_ref()[a] - down.as_ref()[a]) / (2.0 * h);
            assert!((dN[i] - difference).abs() < 1e-12, "gradient of node {a}");
        }
    }
}

/// Σ_q w_q p(ξ_q) = ∫ p for every polynomial of the degree: ∫ ξ^p = Π pᵢ! / (D + Σ pᵢ)!.
pub fn integrates<const D: usize>(rule: &[(f64, Vector<D>)], degree: u32) {
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    for powers in monomials::<D>(degree) {
        let numerator: f64 = powers.iter().map(|&p| factorial(p)).product();
        let exact = numerator / factorial(D as u32 + powers.iter().sum::<u32>());
        let sum: f64 = rule.iter().map(|(w, xi)| w * monomial(&powers, xi)).sum();
        assert!((sum - exact).abs() < 1e-15, "{powers:?}: {sum} for {exact}");
    }
    assert!(rule.iter().all(|q| q.0 > 0.0), "weights are positive");
}
