//! The harmonic extension of prescribed displacements into a body.

use contact_core::linear::{
    Analysis, Cholesky, Factor, FactorError, Kind, Ordering, SymmetricPattern,
};

use super::dofs::{Dof, DofMap};

/// Solves Δv = 0 in a body component by component, with prescribed values at its supports.
///
/// Components with the same supports share a factor. It is computed when the first of them has a
/// non-zero value, and kept.
pub(super) struct Extension<const D: usize> {
    supports: DofMap,
    /// K_ab = ∫ ∇N_a·∇N_b dX over all nodes, the same matrix for every component.
    pattern: SymmetricPattern,
    K: Vec<f64>,
    components: Vec<Component>,
}

/// The Laplacian restricted to the nodes at which a component is free.
struct Component {
    is_free: Vec<bool>,
    /// The free nodes, and the factor of the Laplacian for them.
    factor: Result<(Vec<usize>, Cholesky), FactorError>,
}

impl<const D: usize> Extension<D> {
    /// From the Laplacian's entries (row, column, value); entries at the same position are summed.
    pub fn new(supports: DofMap, entries: &[(usize, usize, f64)]) -> Self {
        let nodes = supports.len() / D;
        let (pattern, K) =
            SymmetricPattern::from_sums(nodes, entries).expect("nodes are below their number");
        Extension {
            supports,
            pattern,
            K,
            components: Vec::new(),
        }
    }

    /// The prescribed dofs.
    pub fn supports(&self) -> &DofMap {
        &self.supports
    }

    /// The values of all dofs for the `values` (UL) of the prescribed ones. A component is zero if
    /// it has no prescribed dofs, if its values are all zero, or if its matrix cannot be
    /// factorised: the extension only supplies an initial guess.
    pub fn extend(&mut self, values: &[f64]) -> Vec<f64> {
        let nodes = self.pattern.dim();
        let mut v = self
            .supports
            .expand(&vec![0.0; self.supports.free()], values);
        let mut load = vec![0.0; nodes];
        for i in 0..D {
            let at_node: Vec<f64> = (0..nodes).map(|a| v[D * a + i]).collect();
            if at_node.iter().all(|d| *d == 0.0) {
                continue;
            }
            self.pattern.product(&self.K, &at_node, &mut load);
            let Ok((free, factor)) = self.factor(i) else {
                continue;
            };
            let mut x: Vec<f64> = free.iter().map(|&a| -load[a]).collect();
            if factor.solve(&mut x).is_ok() {
                free.iter().zip(x).for_each(|(a, x)| v[D * a + i] = x);
            }
        }
        v
    }

    /// The free nodes of component `i` and the factor of their Laplacian.
    fn factor(&mut self, i: usize) -> &mut Result<(Vec<usize>, Cholesky), FactorError> {
        let nodes = 0..self.pattern.dim();
        let is_free = nodes.map(|a| matches!(self.supports.get(D * a + i), Dof::Free(_)));
        let is_free: Vec<bool> = is_free.collect();
        let known = self.components.iter().position(|c| c.is_free == is_free);
        let known = known.unwrap_or_else(|| {
            let factor = factor(&self.pattern, &self.K, &is_free);
            self.components.push(Component { is_free, factor });
            self.components.len() - 1
        });
        &mut self.components[known].factor
    }
}

/// The free nodes, and the factor of their submatrix of `K`.
fn factor(
    pattern: &SymmetricPattern,
    K: &[f64],
    is_free: &[bool],
) -> Result<(Vec<usize>, Cholesky), FactorError> {
    let free: Vec<usize> = (0..is_free.len()).filter(|&a| is_free[a]).collect();
    let mut number = vec![usize::MAX; is_free.len()];
    free.iter().enumerate().for_each(|(k, &a)| number[a] = k);
    let own = pattern
        .iter()
        .zip(K)
        .filter(|((a, b), _)| is_free[*a] && is_free[*b]);
    let (places, values): (Vec<_>, Vec<f64>) =
        own.map(|((a, b), k)| ((number[a], number[b]), k)).unzip();
    // the entries are sorted and unique, so that they correspond to the pattern's entries in order
    let (pattern, _) = SymmetricPattern::from_entries(free.len(), &places).expect("numbered so");
    let analysis = Analysis::new(&pattern, &Ordering::Automatic)?;
    let mut factor = Cholesky::new(&analysis, Kind::Llt)?;
    factor.refactor(&values)?;
    Ok((free, factor))
}
