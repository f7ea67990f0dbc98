//! The foot of a point's projection, and its effect on the derivatives of g.

use crate::contact::moving::Moving;
use crate::contact::normals::Direction;
use crate::contact::projection::Projection;
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
    pub mu: Vector<D>,
    pub q: Vector<D>,
    pub w: Vector<D>,
    pub by: Projection,
    follows: Follows<D>,
}

/// δλ = R (δx_q − Σ N_b δx_b) + K Σ_b N_b,k p·δx_b + M Σ N_b δn_b.
#[derive(Clone, Copy)]
struct Follows<const D: usize> {
    R: Matrix<D>,
    K: Matrix<D>,
    M: Matrix<D>,
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
        let mut foot = Foot {
            master,
            nodes,
            x,
            normals,
            normal_slopes,
            N: facet_shapes(order, lambda),
            slopes,
            p,
            q: m.n,
            m,
            t,
            m_slopes,
            mu: Vector::zeros(),
            w: Vector::zeros(),
            by: stencil.projection().by,
            follows: Follows {
                R: Matrix::zeros(),
                K: Matrix::zeros(),
                M: Matrix::zeros(),
            },
        };
        match foot.by {
            Projection::AlongNormals => foot.follow_along_normals(),
            Projection::Closest => foot.follow_as_closest(lambda),
        }
        foot
    }

    /// λ solves p·t_k v_k = 0.
    fn follow_as_closest(&mut self, lambda: &Vector<D>) {
        let (p, t) = (self.p, &self.t);
        self.w = self.m.slope() * p;
        let K = inverse_within(&(t.tr_mul(t) - self.x.curvature(&p)), lambda);
        self.mu = K * (self.m_slopes.tr_mul(&self.w) - t.tr_mul(&self.m.n));
        self.q = self.m.n + t * self.mu;
        self.follows = Follows {
            R: K * t.transpose(),
            K,
            M: Matrix::zeros(),
        };
    }

    /// λ and g solve p − g n = 0. Where the facet does not sweep space, the foot is held.
    fn follow_along_normals(&mut self) {
        let (A, n) = (self.m.slope(), self.m.n);
        let g = self.p.dot(&n);
        let slopes = self.t + A * self.m_slopes * g;
        let mut swept = Matrix::<D>::zeros();
        for k in 1..D {
            swept.set_column(k - 1, &(slopes.column(k) - slopes.column(0)));
        }
        swept.set_column(D - 1, &n);
        let Some(inverse) = swept.try_inverse() else {
            return;
        };
        self.q = inverse.row(D - 1).transpose();
        self.w = A * self.q * -g;
        let mut R = Matrix::<D>::zeros();
        for k in 1..D {
            R.set_row(k, &inverse.row(k - 1));
            R.set_row(0, &(R.row(0) - inverse.row(k - 1)));
        }
        self.follows = Follows {
            R,
            K: Matrix::zeros(),
            M: R * A * -g,
        };
    }

    /// δλ by the position of a node with these shape function and slopes, normals held.
    pub fn lambda(&self, shape: f64, slopes: &Vector<D>) -> Matrix<D> {
        self.follows.R * shape + self.follows.K * slopes * self.p.transpose()
    }

    /// δλ by Σ N_b δn_b.
    pub fn lambda_by_normals(&self) -> Matrix<D> {
        self.follows.M
    }

    /// S, the second derivative of the gap by δm alone.
    pub fn curvature(&self) -> Matrix<D> {
        match self.by {
            Projection::AlongNormals => self.m.curvature(&self.q) * -self.p.dot(&self.m.n),
            Projection::Closest => self.m.curvature(&self.p),
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
