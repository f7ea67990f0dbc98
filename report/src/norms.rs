//! Errors in L² and H¹ by quadrature of higher order than the elements.

use ipopt_contact::contact_fem::Mesh;
use ipopt_contact::contact_fem::contact::Surface;
use ipopt_contact::contact_fem::element::{Element, FacetRule, Order, P1, P2, facet_shapes};
use ipopt_contact::contact_fem::tensor::{Matrix, Vector, determinant, inverse_transpose};
use ipopt_contact::prelude::*;

/// u and ∇u at a point.
pub type Jet<const D: usize> = (Vector<D>, Matrix<D>);

/// Sums of squares of an error and of what it is relative to.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    error: f64,
    size: f64,
}

impl Squares {
    fn add(&mut self, weight: f64, error: f64, size: f64) {
        self.error += weight * error;
        self.size += weight * size;
    }

    fn relative(self) -> f64 {
        (self.error / self.size).sqrt()
    }
}

/// The relative errors ‖u − u_h‖ in L² and |u − u_h| in the H¹ seminorm ‖∇·‖, over the bodies that have an
/// exact solution: `exact(body, X)`. Points at which it is not known, outside of a refined solution's mesh, are
/// left out.
pub fn of_displacement<const D: usize>(
    problem: &Problem<D>,
    u: &[Vector<D>],
    bodies: &[usize],
    exact: impl Fn(usize, &Vector<D>) -> Option<Jet<D>>,
) -> [f64; 2]
where
    P1: Element<D>,
    P2: Element<D>,
{
    let mut sums = [Squares::default(); 2];
    for &body in bodies {
        let mesh = problem.scene().bodies()[body].mesh();
        let own = &u[problem.nodes(body)];
        let exact = |X: &Vector<D>| exact(body, X);
        match mesh.order() {
            Order::Linear => add::<D, P1>(mesh, own, &exact, &mut sums),
            Order::Quadratic => add::<D, P2>(mesh, own, &exact, &mut sums),
        }
    }
    sums.map(Squares::relative)
}

fn add<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    u: &[Vector<D>],
    exact: &dyn Fn(&Vector<D>) -> Option<Jet<D>>,
    sums: &mut [Squares; 2],
) {
    let rule = simplex_rule::<D>(5);
    for cell in mesh.cells() {
        for (weight, xi) in &rule {
            let at = Local::new::<E>(mesh, cell, u, xi);
            let Some((v, dv)) = exact(&at.X) else {
                continue;
            };
            let w = weight * at.jacobian;
            sums[0].add(w, (at.u - v).norm_squared(), v.norm_squared());
            sums[1].add(w, (at.gradient - dv).norm_squared(), dv.norm_squared());
        }
    }
}

/// A finite element function at a point of a cell.
pub struct Local<const D: usize> {
    /// X(ξ) (UL).
    pub X: Vector<D>,
    /// ∂X/∂ξ.
    pub dX: Matrix<D>,
    /// u.
    pub u: Vector<D>,
    /// ∇u.
    pub gradient: Matrix<D>,
    /// det ∂X/∂ξ.
    pub jacobian: f64,
}

impl<const D: usize> Local<D> {
    /// At ξ of a cell of `mesh`, `u` being the values at the mesh's nodes.
    pub fn new<E: Element<D>>(
        mesh: &Mesh<D>,
        cell: &[usize],
        u: &[Vector<D>],
        xi: &Vector<D>,
    ) -> Self {
        let (N, dN) = (E::shapes(xi), E::shape_gradients(xi));
        let (mut X, mut value) = (Vector::zeros(), Vector::zeros());
        let (mut dX, mut du) = (Matrix::zeros(), Matrix::zeros());
        for ((&a, N), dN) in cell.iter().zip(N.as_ref()).zip(dN.as_ref()) {
            X += mesh.nodes()[a] * *N;
            value += u[a] * *N;
            dX += mesh.nodes()[a] * dN.transpose();
            du += u[a] * dN.transpose();
        }
        Local {
            X,
            dX,
            u: value,
            gradient: du * inverse_transpose(&dX).transpose(),
            jacobian: determinant(&dX),
        }
    }
}

/// Gauss points of a collapsed cube on the unit simplex, n a direction, exact to degree 2n − D; the weights sum to
/// 1/D!.
pub fn simplex_rule<const D: usize>(n: usize) -> Vec<(f64, Vector<D>)> {
    let line = FacetRule::<2>::gauss(n);
    // ξ of the first directions, the share that is left for the others, weight
    let mut points = vec![(Vector::<D>::zeros(), 1.0, 1.0)];
    for i in 0..D {
        let mut next = Vec::new();
        for (xi, left, weight) in &points {
            for (w, lambda) in line.points() {
                let mut xi = *xi;
                xi[i] = left * lambda[0];
                next.push((xi, left * lambda[1], weight * w * left));
            }
        }
        points = next;
    }
    points.into_iter().map(|(xi, _, w)| (w, xi)).collect()
}

/// The relative error of the pressure in L² over a contact surface, `pressure` being its nodal values.
pub fn of_pressure<const D: usize>(
    surface: &Surface<D>,
    pressure: &[f64],
    exact: impl Fn(&Vector<D>) -> f64,
) -> f64 {
    let rule = FacetRule::<D>::gauss(8);
    let mut sum = Squares::default();
    for (nodes, facet) in surface.facets().zip(surface.reference()) {
        for (weight, lambda) in rule.points() {
            let N = facet_shapes(surface.order(), lambda);
            let p: f64 = nodes.iter().zip(N).map(|(&a, N)| N * pressure[a]).sum();
            let q = exact(&facet.point(lambda));
            let w = weight * facet.normal(lambda).norm();
            sum.add(w, (p - q).powi(2), q * q);
        }
    }
    sum.relative()
}

/// The factor by which `shape` carries the same force as the pressure over the facets all of whose corners are
/// `within`: a peak that does not hang on one node.
pub fn amplitude<const D: usize>(
    surface: &Surface<D>,
    pressure: &[f64],
    shape: impl Fn(&Vector<D>) -> f64,
    within: impl Fn(&Vector<D>) -> bool,
) -> f64 {
    let rule = FacetRule::<D>::gauss(8);
    let (mut force, mut of_shape) = (0.0, 0.0);
    let facets = surface.facets().zip(surface.reference());
    for (nodes, facet) in facets.filter(|(_, facet)| facet.corners().iter().all(&within)) {
        for (weight, lambda) in rule.points() {
            let N = facet_shapes(surface.order(), lambda);
            let p: f64 = nodes.iter().zip(N).map(|(&a, N)| N * pressure[a]).sum();
            let w = weight * facet.normal(lambda).norm();
            force += w * p;
            of_shape += w * shape(&facet.point(lambda));
        }
    }
    force / of_shape
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipopt_contact_scenes::alone;

    /// ∫ Π ξ_i^{p_i} over the unit simplex is Π p_i! / (D + Σ p_i)!.
    fn integrates<const D: usize>(powers: [u32; D]) {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        let exact = powers.map(factorial).iter().product::<f64>()
            / factorial(D as u32 + powers.iter().sum::<u32>());
        let power = |xi: &Vector<D>, i: usize| xi[i].powi(powers[i] as i32);
        let monomial = |xi: &Vector<D>| (0..D).map(|i| power(xi, i)).product::<f64>();
        let sum: f64 = simplex_rule::<D>(5)
            .iter()
            .map(|(w, xi)| w * monomial(xi))
            .sum();
        assert!((sum / exact - 1.0).abs() < 1e-12, "{powers:?}");
    }

    #[test]
    fn the_rule_is_exact_to_its_degree() {
        let plane = [[0, 0], [8, 0], [0, 8], [3, 5], [4, 4]];
        plane.into_iter().for_each(integrates::<2>);
        let space = [[0, 0, 0], [7, 0, 0], [0, 0, 7], [2, 2, 3], [1, 5, 1]];
        space.into_iter().for_each(integrates::<3>);
    }

    #[test]
    fn norms_of_a_known_error() {
        // u_h = 0 against u = (x, 0): all of it is error; against u_h = u none is
        let grid = [0.0, 0.5, 1.0];
        let mesh = rectangle(&grid, &grid, Diagonals::Rising).expect("mesh");
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.0).expect("law"));
        body.prescribe("left", [Some(0.0); 2]).expect("a side");
        let problem = alone(body).problem().expect("a scene");
        let exact = |X: &Vector<2>| {
            (
                Vector::<2>::new(X[0], 0.0),
                Matrix::<2>::new(1.0, 0.0, 0.0, 0.0),
            )
        };
        let norms = |scale: f64| {
            let nodes = problem.reference().iter();
            let u: Vec<_> = nodes.map(|X| exact(X).0 * scale).collect();
            of_displacement(&problem, &u, &[0], |_, X| Some(exact(X)))
        };
        assert!(norms(1.0).iter().all(|e| *e < 1e-15));
        assert!(norms(0.0).iter().all(|e| (e - 1.0).abs() < 1e-14));
        assert!(norms(1.25).iter().all(|e| (e - 0.25).abs() < 1e-14));
    }
}
