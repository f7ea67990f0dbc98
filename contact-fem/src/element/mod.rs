//! Reference elements on simplices: shape functions, their gradients, quadrature, and facets.

#[cfg(test)]
mod battery;
pub(crate) mod cell_rule;
mod facet;
mod facet_rule;
mod p1;
pub(crate) mod p2;
mod ring;
pub(crate) mod volume;

pub use facet::{
    Facet, FacetShapes, MAX_FACET_NODES, Order, facet_edge, facet_shapes, facet_slopes,
};
pub use facet_rule::FacetRule;
pub use p1::P1;
pub(crate) use p2::CELL_EDGES;
pub use p2::P2;
pub use ring::RingP2;

use crate::tensor::Vector;

/// A Lagrange element on the unit simplex of ℝᴰ: nodes at the D + 1 corners, followed by the
/// middles of [`Element::EDGES`].
///
/// `PerNode<T>` is the array type with one `T` for each node, so that the data of a cell live on
/// the stack.
pub trait Element<const D: usize>: Send + Sync + 'static {
    /// One `T` for each node of a cell.
    type PerNode<T: Copy + Send + Sync>: AsRef<[T]> + AsMut<[T]> + Copy + Send + Sync;
    /// The polynomial degree.
    const ORDER: Order;
    /// The edges, as pairs of corners, that have a node each.
    const EDGES: &'static [[usize; 2]];
    /// Quadrature points for the strain energy as (weight, ξ); the weights sum to the simplex's
    /// volume 1/D!.
    const QUADRATURE: &'static [(f64, [f64; D])];

    /// An array with `value` for every node.
    fn per_node<T: Copy + Send + Sync>(value: T) -> Self::PerNode<T>;
    /// N_a(ξ).
    fn shapes(xi: &Vector<D>) -> Self::PerNode<f64>;
    /// ∂N_a/∂ξ at ξ.
    fn shape_gradients(xi: &Vector<D>) -> Self::PerNode<Vector<D>>;
}
