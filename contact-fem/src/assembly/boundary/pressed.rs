//! Boundaries under a pressure that follows them.

use std::f64::consts::TAU;

use crate::element::{Facet, FacetRule, FacetShapes, Order, facet_shapes, facet_slopes};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector};

/// The facets of a boundary on which a pressure acts where they are.
///
/// Their vector areas a_k = ∫ N_k n da at the nodes are polynomials in x. A pressure p does the forces −p a_k. They have a
/// potential p V if the a_k are the derivatives of some V: where the rim is closed, held, or slides in planes perpendicular
/// to an axis. V is then the volume that the boundary sweeps, the integral of a·dU along any path.
///
/// Areas and volumes of a body of revolution are those of the whole circumference, 2πr times the ones in the half-plane.
#[derive(Clone, Debug)]
pub(crate) struct Pressed<const D: usize> {
    order: Order,
    is_revolved: bool,
    /// The nodes of each facet, and X there (UL), flat.
    nodes: Vec<usize>,
    X: Vec<Vector<D>>,
    /// Exact for N n, of degree 4 at most, and for r N n, of degree 5.
    rule: FacetRule<D>,
    /// On a path between two states; exact for squares.
    path: FacetRule<2>,
}

impl<const D: usize> Pressed<D> {
    /// Facets given by their nodes.
    pub fn new(mesh: &Mesh<D>, facets: &[&[usize]]) -> Self {
        let nodes = facets.concat();
        Pressed {
            order: mesh.order(),
            is_revolved: mesh.is_of_revolution(),
            X: nodes.iter().map(|&a| mesh.nodes()[a]).collect(),
            nodes,
            rule: FacetRule::gauss(3),
            path: FacetRule::gauss(2),
        }
    }

    /// The nodes of each facet, and its position at the displacements U (UL).
    fn facets<'a>(&'a self, U: &'a [f64]) -> impl Iterator<Item = (&'a [usize], Facet<D>)> {
        let size = self.order.facet_nodes::<D>();
        let facets = self.nodes.chunks_exact(size).zip(self.X.chunks_exact(size));
        facets.map(move |(nodes, X)| {
            let mut x = [Vector::zeros(); crate::element::MAX_FACET_NODES];
            for ((x, X), a) in x.iter_mut().zip(X).zip(nodes) {
                *x = X + Vector::from_column_slice(&U[D * a..D * (a + 1)]);
            }
            const OWN: [usize; 6] = [0, 1, 2, 3, 4, 5];
            (nodes, Facet::gather(self.order, &OWN[..size], &x))
        })
    }

    /// Adds `factor` times the vector areas a_k at the displacements U of all dofs (UL) to `forces`.
    pub fn add_areas(&self, U: &[f64], factor: f64, forces: &mut [f64]) {
        for (nodes, facet) in self.facets(U) {
            for (weight, lambda) in self.rule.points() {
                let area = facet.normal(lambda) * (factor * weight * self.ring(&facet, lambda));
                for (a, N) in nodes.iter().zip(facet_shapes(self.order, lambda)) {
                    (0..D).for_each(|i| forces[D * a + i] += N * area[i]);
                }
            }
        }
    }

    /// 2πr at a point of a body of revolution, else 1.
    fn ring(&self, facet: &Facet<D>, lambda: &Vector<D>) -> f64 {
        match self.is_revolved {
            true => TAU * facet.point(lambda)[0],
            false => 1.0,
        }
    }

    /// The volume V (UL²/UL³) that the boundary sweeps outwards on its way to U: first the dofs that are not free go to
    /// their place, and then the free ones.
    pub fn volume(&self, U: &[f64], is_free: impl Fn(usize) -> bool) -> f64 {
        let held = U.iter().enumerate();
        let held = held.map(|(dof, u)| if is_free(dof) { 0.0 } else { *u });
        let held: Vec<f64> = held.collect();
        self.swept(&vec![0.0; U.len()], &held) + self.swept(&held, U)
    }

    /// ∫ a·dU on the line between two displacements.
    fn swept(&self, from: &[f64], to: &[f64]) -> f64 {
        if from == to {
            return 0.0;
        }
        let along = |(weight, lambda): &(f64, Vector<2>)| {
            let between = from.iter().zip(to);
            let between = between.map(|(from, to)| lambda[0] * from + lambda[1] * to);
            let mut areas = vec![0.0; to.len()];
            self.add_areas(&between.collect::<Vec<_>>(), *weight, &mut areas);
            let ways = to.iter().zip(from).zip(areas);
            ways.map(|((to, from), area)| (to - from) * area)
                .sum::<f64>()
        };
        self.path.points().iter().map(along).sum()
    }

    /// The pairs of dofs whose entries [`Pressed::slopes`] tells, in its order; the first one has the larger number.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let size = self.order.facet_nodes::<D>();
        let facets = self.nodes.chunks_exact(size);
        facets.flat_map(|nodes| {
            let dofs = move || nodes.iter().flat_map(|a| D * a..D * (a + 1));
            dofs().flat_map(move |r| dofs().filter(move |c| *c <= r).map(move |c| (r, c)))
        })
    }

    /// Calls `add` with the symmetric part of ∂a/∂x for each of [`Pressed::pairs`]. The sum over facets is symmetric for free
    /// dofs where V exists.
    pub fn slopes(&self, U: &[f64], mut add: impl FnMut(f64)) {
        for (nodes, facet) in self.facets(U) {
            let mut blocks = [[Matrix::<D>::zeros(); 6]; 6];
            for (weight, lambda) in self.rule.points() {
                let N = facet_shapes(self.order, lambda);
                let mut by_node = normal_slopes(&facet, &facet_slopes(self.order, lambda));
                if self.is_revolved {
                    let (ring, normal) = (self.ring(&facet, lambda), facet.normal(lambda));
                    for (slope, N) in by_node.iter_mut().zip(&N).take(nodes.len()) {
                        *slope *= ring;
                        // the radius grows with r of the node
                        (0..D).for_each(|i| slope[(i, 0)] += TAU * N * normal[i]);
                    }
                }
                for (row, N) in blocks.iter_mut().zip(N).take(nodes.len()) {
                    for (block, slope) in row.iter_mut().zip(&by_node) {
                        *block += slope * (weight * N);
                    }
                }
            }
            for (k, a) in nodes.iter().enumerate() {
                for i in 0..D {
                    for (l, b) in nodes.iter().enumerate() {
                        for j in (0..D).filter(|j| D * b + j <= D * a + i) {
                            add(0.5 * (blocks[k][l][(i, j)] + blocks[l][k][(j, i)]));
                        }
                    }
                }
            }
        }
    }
}

/// The derivatives of a facet's normal, as long as its measure, with respect to its nodes.
fn normal_slopes<const D: usize>(facet: &Facet<D>, slopes: &[FacetShapes; D]) -> [Matrix<D>; 6] {
    let nodes = facet.nodes();
    let along = |k: usize, b: usize| slopes[k][b] - slopes[0][b];
    let tangent = |k: usize| -> Vector<D> {
        let terms = nodes.iter().enumerate();
        terms.map(|(b, x)| x * along(k, b)).sum()
    };
    let edges: [Vector<D>; D] =
        std::array::from_fn(|k| if k == 0 { Vector::zeros() } else { tangent(k) });
    std::array::from_fn(|b| {
        if b >= nodes.len() {
            Matrix::zeros()
        } else if D == 2 {
            // the normal is (t_y, −t_x)
            let mut slope = Matrix::zeros();
            (slope[(0, 1)], slope[(1, 0)]) = (along(1, b), -along(1, b));
            slope
        } else {
            // ½ s × t, by s and t
            (cross(&edges[1]) * along(2, b) - cross(&edges[D - 1]) * along(1, b)) * 0.5
        }
    })
}

/// The matrix of the vector product with `v` in space.
fn cross<const D: usize>(v: &Vector<D>) -> Matrix<D> {
    Matrix::from_fn(|i, j| match (3 + j - i) % 3 {
        0 => 0.0,
        1 => -v[3 - i - j],
        _ => v[3 - i - j],
    })
}
