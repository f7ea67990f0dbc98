//! The moving gap of one integration point, and its derivatives.
//!
//! A linearisation holds the foot and the normal (equations (3)–(5) of the paper, step 3 of
//! Algorithm 2). Here both follow the positions x of the nodes. For a point with fixed coordinates
//! ξ on its facet,
//!
//! g(x) = p·n,  p = x_q − x̄(λ*),  n = m/|m|,  m = Σ_b N_b(λ*) n_b(x),
//!
//! where x̄(λ) = Σ_b N_b(λ) x_b is the master's facet, n_b(x) its averaged normals (see
//! [`normals`](super::normals)) and λ*(x) the foot. Write ,k for ∂/∂λ_k, t_k = x̄,k and
//! δ for the derivative along a change of x. A = (I − n nᵀ)/|m| is the derivative of n by m.
//!
//! # The closest point
//!
//! p·∂x̄/∂λ·v = 0 for all v with Σv = 0 that keep λ* on the side of the facet or in the corner where it is.
//!
//! **Foot.** H_kj = t_k·t_j − p·x̄,kj is the Hessian of ½|p|², and K = V (VᵀHV)⁻¹ Vᵀ its inverse on the
//! span of the v. The implicit function theorem gives δλ = Kρ with
//! ρ_k = t_k·(δx_q − Σ N_b δx_b) + p·Σ N_b,k δx_b.
//!
//! **First derivative.** With w = Ap, the slope γ_k = w·m,k − n·t_k of p·n along the
//! facet, μ = Kγ and q = n + Σ μ_k t_k:
//!
//! δg = q·(δx_q − Σ N_b δx_b) + p·Σ μ_k N_b,k δx_b + w·Σ N_b δn_b.
//!
//! On a facet with n normal to it and p along n, μ = 0 and w = 0: this is the frozen gradient.
//!
//! **Second derivative.** μ makes L = p·n + Σ μ_k p·t_k, of independent x and λ, stationary in λ, so that
//! δ²λ drops out and δ²g is that of L along (δx, Kρ), μ held:
//!
//! δ²g = 2 δp·(A δm + Σ μ_k δt_k) + δm·S δm + Σ N_b w·δ²n_b
//!     + 2 Σ_j δλ_j Σ_b (−N_b,j q·δx_b + Σ_k μ_k N_b,kj p·δx_b + N_b,j w·δn_b)
//!     + Σ_kj δλ_k δλ_j (w·m,kj − q·x̄,kj),
//!
//! where S = −(p nᵀ + n pᵀ + p·n (I − 3 n nᵀ))/|m|² is the second derivative of p·m/|m|, and δp, δm and
//! δt_k are of first order and with δλ in them.
//!
//! While the foot stays on one facet, and in its interior, on one side or in one corner, g is as smooth as the surface,
//! unless a facet has no area or normals cancel. g is discontinuous where the foot jumps to another
//! facet; ∇g is where the foot crosses a common side to a neighbour.
//!
//! # Along normals
//!
//! p − g n = 0. Let B have the columns (t_k + g A m,k) v_k and n, for a basis v of the changes of λ, and let the rows of B⁻¹ be R_k
//! and, for n, q: q·n = 1, and q is orthogonal to what the foot sweeps.
//!
//! **Foot.** δλ = R (δx_q − Σ N_b δx_b − g A Σ N_b δn_b).
//!
//! **First derivative.** With w = −g A q,
//!
//! δg = q·(δx_q − Σ N_b δx_b) + w·Σ N_b δn_b.
//!
//! **Second derivative.** q makes L = g + q·(p − g n) stationary in λ and g:
//!
//! δ²g = −2 δg q·A δm + δm·S δm + Σ N_b w·δ²n_b
//!     + 2 Σ_j δλ_j Σ_b (−N_b,j q·δx_b + N_b,j w·δn_b)
//!     + Σ_kj δλ_k δλ_j (w·m,kj − q·x̄,kj),
//!
//! where S is −g times the second derivative of q·m/|m|. g is continuous across sides; ∇g is not, by the gap times the change of slope.
//!
//! # Both
//!
//! ∇²g is symmetric. The derivative of the frozen gradient is not: contact forces with held
//! projections, as in the paper, are not the gradient of a potential of x. Exact integration cuts the
//! slave's facets at positions that move with x; the derivatives of ξ and of the weight are not
//! part of ∇g.

pub(super) mod foot;

use foot::Foot;

use super::obstacle::Placed;
use super::projection::Projection;
use super::stencil::{Against, Stencil};
use crate::element::{FacetShapes, MAX_FACET_NODES, facet_slopes};
use crate::tensor::{Matrix, Vector};

/// g of one integration point after the other, as a function of the nodes that it depends on: those
/// of the slave's facet and of the master's facets around the foot's facet. The buffers are reused
/// from point to point.
#[derive(Clone, Debug)]
pub struct MovingGap<const D: usize> {
    nodes: Vec<usize>,
    gradient: Vec<Vector<D>>,
    /// Blocks (l, m ≤ l), row by row.
    hessian: Vec<Matrix<D>>,
    forms: Vec<Forms<D>>,
    /// ∂s_b/∂x_l of the normals' sums, for every node b of the master's facet and all l.
    sums: Vec<Matrix<D>>,
    /// The number of nodes on the two facets, which come first. The other nodes affect the normals
    /// only.
    near: usize,
    n: Vector<D>,
}

/// Linear forms in the position of one node.
#[derive(Clone, Copy, Debug)]
struct Forms<const D: usize> {
    /// The node's shape function in x_q − x̄, and its derivatives in x̄.
    shape: f64,
    slopes: Vector<D>,
    /// Σ_k μ_k N_,kj by j.
    bends: Vector<D>,
    /// δp, A δm + Σ μ_k δt_k, δm, S δm, δn, δλ.
    p: Matrix<D>,
    r: Matrix<D>,
    m: Matrix<D>,
    s: Matrix<D>,
    n: Matrix<D>,
    lambda: Matrix<D>,
    /// The factor of δλ_j in δ²g, by j.
    c: Matrix<D>,
}

impl<const D: usize> MovingGap<D> {
    /// The scene nodes on which g depends, each once. They define the order of the derivatives.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// ∂g/∂x_l of every node.
    pub fn gradient(&self) -> &[Vector<D>] {
        &self.gradient
    }

    /// ∂²g/∂x_l∂x_m (1/UL); the block (m, l) is its transpose. Requires [`MovingGap::second`].
    pub fn hessian(&self, l: usize, m: usize) -> Matrix<D> {
        match l >= m {
            true => self.hessian[block(l, m)],
            false => self.hessian[block(m, l)].transpose(),
        }
    }

    /// ∂f_l/∂x_m (1/UL) of the frozen gradient f, which is N_a n at the slave's nodes and −N_b n at
    /// the master's. Not symmetric. Requires [`MovingGap::second`].
    pub fn frozen_jacobian(&self, l: usize, m: usize) -> Matrix<D> {
        let (own, other) = (&self.forms[l], &self.forms[m]);
        other.n * own.shape - self.n * other.lambda.tr_mul(&own.slopes).transpose()
    }

    /// Evaluates the nodes and ∇g of `stencil`.
    pub fn first(&mut self, stencil: &Stencil<'_, D>) {
        self.differentiate(stencil, false);
    }

    /// As [`MovingGap::first`], with the second derivatives.
    pub fn second(&mut self, stencil: &Stencil<'_, D>) {
        self.differentiate(stencil, true);
    }

    fn differentiate(&mut self, stencil: &Stencil<'_, D>, second: bool) {
        let foot = match stencil.against() {
            Against::Surface(master) | Against::Corner(master) => Foot::new(stencil, master),
            Against::Obstacle(obstacle) => return self.on_obstacle(stencil, obstacle, second),
        };
        self.n = foot.m.n;
        self.number(stencil, &foot);
        self.add_normals(&foot, second);
        self.gradient.clear();
        for (l, forms) in self.forms.iter_mut().enumerate() {
            let mut gradient = foot.q * forms.shape + foot.p * forms.slopes.dot(&foot.mu);
            let sums = self.sums[l..].iter().step_by(self.nodes.len());
            for (b, sum) in sums.enumerate() {
                let n_b = foot.normal_slopes[b] * sum;
                forms.m += n_b * foot.N[b];
                let w_n = n_b.tr_mul(&foot.w);
                gradient += w_n * foot.N[b];
                for j in 0..D {
                    let mut row = forms.c.row_mut(j);
                    row += w_n.transpose() * foot.slopes[j][b];
                }
            }
            self.gradient.push(gradient);
        }
        if second {
            self.follow_the_foot(&foot);
            self.multiply();
        }
    }

    /// g = d(x_q): ∇g has N_a n, ∇²g and the frozen gradient's derivative N_a N_b ∇²d.
    fn on_obstacle(&mut self, stencil: &Stencil<'_, D>, obstacle: &Placed<D>, second: bool) {
        self.nodes.clear();
        self.forms.clear();
        self.gradient.clear();
        self.hessian.clear();
        self.n = stencil.projection().normal;
        for (a, N) in stencil.slave_shapes() {
            let l = self.place(a);
            self.forms[l].shape += N;
        }
        self.near = self.nodes.len();
        let shapes = self.forms.iter().map(|forms| self.n * forms.shape);
        self.gradient.extend(shapes);
        if !second {
            return;
        }
        let H = obstacle.curvature(&stencil.point());
        for forms in &mut self.forms {
            forms.n = H * forms.shape;
        }
        for (l, a) in self.forms.iter().enumerate() {
            let row = self.forms[..=l].iter().map(|b| a.n * b.shape);
            self.hessian.extend(row);
        }
    }

    /// The position of a scene node among those of the point.
    fn place(&mut self, node: usize) -> usize {
        let known = self.nodes.iter().position(|&other| other == node);
        known.unwrap_or_else(|| {
            self.nodes.push(node);
            self.forms.push(Forms::zeros());
            self.nodes.len() - 1
        })
    }

    /// Numbers the nodes and evaluates the shape functions of the two facets.
    fn number(&mut self, stencil: &Stencil<'_, D>, foot: &Foot<'_, D>) {
        self.nodes.clear();
        self.forms.clear();
        let surface = foot.master.surface();
        // derivatives of quadratic shape functions are linear in λ
        let [at_mu, at_zero] =
            [foot.mu, Vector::zeros()].map(|mu| facet_slopes(surface.order(), &mu));
        for (b, &node) in foot.nodes.iter().enumerate() {
            let l = self.place(surface.nodes()[node]);
            let forms = &mut self.forms[l];
            forms.shape = -foot.N[b];
            forms.slopes = Vector::from_fn(|j, _| foot.slopes[j][b]);
            forms.bends = Vector::from_fn(|j, _| at_mu[j][b] - at_zero[j][b]);
        }
        for (a, N) in stencil.slave_shapes() {
            let l = self.place(a);
            self.forms[l].shape += N;
        }
        self.near = self.nodes.len();
        for &b in foot.nodes {
            for (f, _) in surface.facets_around(b) {
                for &c in surface.facet(f) {
                    self.place(surface.nodes()[c]);
                }
            }
        }
    }

    /// ∂s_b/∂x_l; if requested, also N_b w·∇²n_b in the Hessian.
    fn add_normals(&mut self, foot: &Foot<'_, D>, second: bool) {
        let count = self.nodes.len();
        let surface = foot.master.surface();
        self.sums.clear();
        self.sums.resize(foot.nodes.len() * count, Matrix::zeros());
        self.hessian.clear();
        if second {
            self.hessian.resize(block(count, 0), Matrix::zeros());
        }
        for (b, &node) in foot.nodes.iter().enumerate() {
            let normal = foot.master.normal(node);
            let v = foot.normal_slopes[b] * foot.w * foot.N[b];
            for (f, addend) in foot.master.addends(node) {
                let mut places = [0; MAX_FACET_NODES];
                for (place, &c) in places.iter_mut().zip(surface.facet(f)) {
                    *place = self.place(surface.nodes()[c]);
                }
                let places = &places[..surface.facet(f).len()];
                for (j, by_y) in addend.jacobian().iter().enumerate() {
                    for (l, slope) in places.iter().zip(&addend.slopes[j]) {
                        self.sums[b * count + l] += by_y * *slope;
                    }
                }
                if second {
                    self.spread(&addend.hessian(&v), &addend.slopes, places);
                }
            }
            if second {
                self.add_quadratic(b, &(normal.curvature(&foot.w) * foot.N[b]));
            }
        }
    }

    /// Adds the second derivatives by the corners y, transformed to those by the nodes.
    fn spread(&mut self, by_y: &[[Matrix<D>; D]; D], slopes: &[FacetShapes; D], places: &[usize]) {
        for (i, rows) in by_y.iter().enumerate() {
            for (j, by_y) in rows.iter().enumerate() {
                let of = |k: usize| places.iter().zip(&slopes[k]).filter(|(_, s)| **s != 0.0);
                for (&l, slope_l) in of(i) {
                    for (&m, slope_m) in of(j).filter(|(m, _)| **m <= l) {
                        self.hessian[block(l, m)] += by_y * (slope_l * slope_m);
                    }
                }
            }
        }
    }

    /// Adds δs_b·S δs_b.
    fn add_quadratic(&mut self, b: usize, S: &Matrix<D>) {
        let sums = &self.sums[b * self.nodes.len()..];
        let zero = Matrix::<D>::zeros();
        for l in 0..self.nodes.len() {
            if sums[l] == zero {
                continue;
            }
            let row = S * sums[l];
            for m in (0..=l).filter(|&m| sums[m] != zero) {
                self.hessian[block(l, m)] += row.tr_mul(&sums[m]);
            }
        }
    }

    /// The forms that contain δλ.
    fn follow_the_foot(&mut self, foot: &Foot<'_, D>) {
        let (A, S) = (foot.m.slope(), foot.curvature());
        let along_normals = foot.by == Projection::AlongNormals;
        if along_normals {
            self.near = self.nodes.len();
        }
        // Σ_k μ_k x̄,kj as columns, and half of the factor of δλ_k δλ_j
        let mut t_bends = Matrix::<D>::zeros();
        for (forms, x) in self.forms.iter().zip(foot.x.nodes()) {
            t_bends += x * forms.bends.transpose();
        }
        let half = (foot.normals.curvature(&foot.w) - foot.x.curvature(&foot.q)) * 0.5;
        for (forms, gradient) in self.forms.iter_mut().zip(&self.gradient) {
            forms.lambda = foot.lambda(forms.shape, &forms.slopes);
            forms.lambda += foot.lambda_by_normals() * forms.m;
            forms.m += foot.m_slopes * forms.lambda;
            forms.n = A * forms.m;
            forms.s = S * forms.m;
            if along_normals {
                forms.p = self.n * gradient.transpose();
                // the product is −δg q·A δm
                forms.r = -self.n * forms.n.tr_mul(&foot.q).transpose();
            } else {
                forms.p = Matrix::identity() * forms.shape - foot.t * forms.lambda;
                let t = Matrix::identity() * forms.slopes.dot(&foot.mu) + t_bends * forms.lambda;
                forms.r = forms.n + t;
            }
            forms.c -= forms.slopes * foot.q.transpose();
            forms.c += forms.bends * foot.p.transpose() + half * forms.lambda;
        }
    }

    /// Adds the products of the forms to the Hessian.
    fn multiply(&mut self) {
        for (l, a) in self.forms.iter().enumerate() {
            for (m, b) in self.forms[..=l].iter().enumerate() {
                let mut h = a.s.tr_mul(&b.m);
                // δp and δλ are 0 for nodes that are on neither of the two facets
                if m < self.near {
                    h += a.r.tr_mul(&b.p) + a.c.tr_mul(&b.lambda);
                }
                if l < self.near {
                    h += a.p.tr_mul(&b.r) + a.lambda.tr_mul(&b.c);
                }
                self.hessian[block(l, m)] += h;
            }
        }
    }
}

impl<const D: usize> Default for MovingGap<D> {
    fn default() -> Self {
        MovingGap {
            nodes: Vec::new(),
            gradient: Vec::new(),
            hessian: Vec::new(),
            forms: Vec::new(),
            sums: Vec::new(),
            near: 0,
            n: Vector::zeros(),
        }
    }
}

impl<const D: usize> Forms<D> {
    fn zeros() -> Self {
        let (none, zero) = (Vector::zeros(), Matrix::zeros());
        Forms {
            shape: 0.0,
            slopes: none,
            bends: none,
            p: zero,
            r: zero,
            m: zero,
            s: zero,
            n: zero,
            lambda: zero,
            c: zero,
        }
    }
}

/// The index of block (l, m ≤ l) in the lower triangle.
fn block(l: usize, m: usize) -> usize {
    l * (l + 1) / 2 + m
}

#[cfg(test)]
mod battery;
#[cfg(test)]
mod definition;
#[cfg(test)]
mod weak;
