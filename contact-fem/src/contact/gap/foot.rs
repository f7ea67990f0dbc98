//! The foot of a point's projection, and its effect on the derivatives of g.

use crate::contact::moving::Moving;
use crate::contact::normals::Direction;
use crate::contact::stencil::Stencil;
use crate::element::{Facet, FacetShapes, MAX_FACET_NODES, facet_shapes, facet_slopes};
use crate::tensor::{Matrix, Vector};

/// The foot λ* of one point, and the quantities that the derivatives of its gap share.
pub(in crate::contact) struct Foot<'a, const D: usize> {
    pub master: &'a Moving<D>,
    /// The facet's nodes, as positions in the surface's nodes.
    pub nodes: &'a [usize],
    pub x: Facet<D>,
    pub normals: Facet<D>,
    /// ∂n_b/∂s_b.
    pub normal_slopes: [Matrix<D>; MAX_FACET_NODES],
    pub N: FacetShapes,
    pub slopes: [FacetShapes; D],
    pub p: Vector<D>,
    pub m: Direction<D>,
    /// t_k and m,k as columns.
    pub t: Matrix<D>,
    pub m_slopes: Matrix<D>,
    pub K: Matrix<D>,
    pub mu: Vector<D>,
    pub q: Vector<D>,
    pub w: Vector<D>,
}

impl<'a, const D: usize> Foot<'a, D> {
    /// Of a point that is against the surface `master`.
    pub fn new(stencil: &Stencil<'a, D>, master: &'a Moving<D>) -> Self {
        let lambda = &stencil.projection().lambda;
        let (surface, order) = (master.surface(), master.surface().order());
        let nodes = surface.facet(stencil.projection().facet);
        let x = Facet::gather(order, nodes, master.positions());
        let normals = Facet::gather(order, nodes, master.normals());
        let mut normal_slopes = [Matrix::zeros(); MAX_FACET_NODES];
        for (slope, &b) in normal_slopes.iter_mut().zip(nodes) {
            *slope = master.normal(b).slope();
        }
        let slopes = facet_slopes(order, lambda);
        let (t, m_slopes) = (combine(&slopes, &x), combine(&slopes, &normals));
        let p = stencil.point() - x.point(lambda);
        let m = Direction::of(normals.point(lambda));
        let w = m.slope() * p;
        let K = inverse_within(&(t.tr_mul(&t) - x.curvature(&p)), lambda);
        let mu = K * (m_slopes.tr_mul(&w) - t.tr_mul(&m.n));
        Foot {
            master,
            nodes,
            x,
            normals,
            normal_slopes,
            N: facet_shapes(order, lambda),
            slopes,
            p,
            q: m.n + t * mu,
            m,
            t,
            m_slopes,
            K,
            mu,
            w,
        }
    }
}

/// Σ_b slopes_kb value_b, as columns k.
fn combine<const D: usize>(slopes: &[FacetShapes; D], values: &Facet<D>) -> Matrix<D> {
    let mut columns = Matrix::<D>::zeros();
    for (mut column, slopes) in columns.column_iter_mut().zip(slopes) {
        for (slope, value) in slopes.iter().zip(values.nodes()) {
            column.axpy(*slope, value, 1.0);
        }
    }
    columns
}

/// K = V (VᵀHV)⁻¹ Vᵀ for the directions V in which λ may move, by conjugating them one after the
/// other. In a direction in which the foot is not a minimum, it is held.
fn inverse_within<const D: usize>(H: &Matrix<D>, lambda: &Vector<D>) -> Matrix<D> {
    let mut K = Matrix::<D>::zeros();
    let mut free = (0..D).filter(|&k| lambda[k] != 0.0);
    let Some(first) = free.next() else {
        return K;
    };
    for k in free {
        let mut v = Vector::<D>::zeros();
        (v[first], v[k]) = (-1.0, 1.0);
        v -= K * (H * v);
        let curvature = v.dot(&(H * v));
        if curvature > 0.0 {
            K += v * v.transpose() / curvature;
        }
    }
    K
}
