//! The kinematics of all bodies: reference positions, supports, and the map from u to x.

use std::ops::Range;

use contact_core::LinearGaps;

use super::Body;
use super::courses::Supports;
use crate::assembly::{Dof, DofMap};
use crate::tensor::Vector;

/// The nodes and dofs of all bodies, one body after the other, at one load factor.
pub(super) struct Kinematics<const D: usize> {
    /// X of all nodes (UL); the number of each body's first node, and the number of all nodes last.
    pub X: Vec<Vector<D>>,
    first_node: Vec<usize>,
    /// Free and prescribed dofs.
    pub dofs: DofMap,
    /// The prescribed displacements of each body, and those at the present load factor (UL).
    supports: Vec<Supports<D>>,
    pub prescribed: Vec<f64>,
    /// The present load factor.
    pub factor: f64,
}

impl<const D: usize> Kinematics<D> {
    /// At load factor 0.
    pub fn new(bodies: &[Body<D>]) -> Self {
        let (mut X, mut first_node) = (Vec::new(), vec![0]);
        let (mut dofs, mut supports) = (DofMap::default(), Vec::new());
        for body in bodies {
            let first = D * X.len();
            X.extend_from_slice(body.mesh().nodes());
            first_node.push(X.len());
            dofs.extend(&body.is_prescribed());
            for (dof, others) in body.ties() {
                let others = others.iter().map(|(other, c)| (first + other, *c));
                dofs.tie(first + dof, others);
            }
            supports.push(body.supports().clone());
        }
        Kinematics {
            X,
            first_node,
            prescribed: vec![0.0; dofs.prescribed()],
            dofs,
            supports,
            factor: 0.0,
        }
    }

    /// Sets the prescribed displacements to those at `factor`.
    pub fn set_load(&mut self, factor: f64) {
        self.factor = factor;
        self.prescribed = self.prescribed_at(factor);
        #[cfg(planted)]
        if contact_core::planted!("prescribed displacements are a hundredth short") {
            self.prescribed.iter_mut().for_each(|u| *u *= 0.99);
        }
    }

    fn prescribed_at(&self, factor: f64) -> Vec<f64> {
        self.supports
            .iter()
            .flat_map(|own| own.at(factor))
            .collect()
    }

    /// The largest displacement at `u` and the present load (UL).
    pub fn largest(&self, u: &[f64]) -> f64 {
        let tied = self.dofs.ties().iter();
        let tied: Vec<f64> = tied
            .map(|tie| self.dofs.value(tie.dof, u, &self.prescribed))
            .collect();
        let all = u.iter().chain(&self.prescribed).chain(&tied);
        all.fold(0.0, |largest: f64, u| match u.is_nan() {
            true => f64::INFINITY,
            false => largest.max(u.abs()),
        })
    }

    /// The diagonal of the box around all bodies in the reference configuration (UL).
    pub fn diagonal(&self) -> f64 {
        let low = self.X.iter().fold(self.X[0], |m, x| m.inf(x));
        let high = self.X.iter().fold(self.X[0], |m, x| m.sup(x));
        (high - low).norm()
    }

    /// The nodes of a body.
    pub fn nodes(&self, body: usize) -> Range<usize> {
        self.first_node[body]..self.first_node[body + 1]
    }

    /// One vector for each node, from the free and the prescribed components.
    fn nodal(&self, free: &[f64], prescribed: &[f64]) -> Vec<Vector<D>> {
        let all = self.dofs.expand(free, prescribed);
        all.chunks_exact(D).map(Vector::from_column_slice).collect()
    }

    /// The displacements of all nodes (UL) at the present load.
    pub fn displacements(&self, u: &[f64]) -> Vec<Vector<D>> {
        self.nodal(u, &self.prescribed)
    }

    /// x = X + u of all nodes (UL) at the present load.
    pub fn positions(&self, u: &[f64]) -> Vec<Vector<D>> {
        self.displaced(self.displacements(u))
    }

    /// As [`Kinematics::positions`], at the given load factor.
    pub fn positions_at(&self, u: &[f64], factor: f64) -> Vec<Vector<D>> {
        self.displaced(self.nodal(u, &self.prescribed_at(factor)))
    }

    fn displaced(&self, U: Vec<Vector<D>>) -> Vec<Vector<D>> {
        #[cfg(planted)]
        if contact_core::planted!("positions are a thousandth off") {
            return self.X.iter().zip(U).map(|(X, u)| X + u * 1.001).collect();
        }
        #[cfg(planted)]
        if contact_core::planted!("every fifth node is where it was at rest") {
            let all = self.X.iter().zip(U).enumerate();
            return all
                .map(|(a, (X, u))| if a % 5 == 0 { *X } else { X + u })
                .collect();
        }
        self.X.iter().zip(U).map(|(X, u)| X + u).collect()
    }

    /// Cᵀλ on all nodes (UF).
    pub fn contact_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vector<D>> {
        let mut free = vec![0.0; self.dofs.free()];
        let mut prescribed = vec![0.0; self.dofs.prescribed()];
        gaps.add_forces(lambda, &mut free);
        gaps.add_prescribed_forces(lambda, &mut prescribed);
        let all = self.dofs.forces(&free, &prescribed);
        #[cfg(planted)]
        let all: Vec<f64> = match contact_core::planted!("contact forces are a hundredth larger") {
            true => all.iter().map(|force| 1.01 * force).collect(),
            false => all,
        };
        all.chunks_exact(D).map(Vector::from_column_slice).collect()
    }

    /// Adds the free components of a body's `increments`, one for each of its dofs (UL), to u.
    pub fn add_free(&self, body: usize, increments: &[f64], u: &mut [f64]) {
        for (dof, increment) in (D * self.first_node[body]..).zip(increments) {
            if let Dof::Free(i) = self.dofs.get(dof) {
                u[i] += increment;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use contact_core::gaps::{Row, RowKey};

    use super::*;
    use crate::LinearElastic;
    use crate::mesh::generators::{Diagonals, rectangle};

    /// Two unit squares, one on top of the other; the lower one is supported at its bottom, the
    /// upper one pushed down.
    fn squares() -> Kinematics<2> {
        let body = |y: f64, side: &str, components| {
            let mesh = rectangle(&[0.0, 1.0], &[y, y + 1.0], Diagonals::Rising).expect("mesh");
            let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.0).expect("law"));
            body.prescribe(side, components).expect("support");
            body
        };
        let lower = body(0.0, "bottom", [Some(0.0); 2]);
        Kinematics::new(&[lower, body(1.0, "top", [None, Some(-0.5)])])
    }

    #[test]
    fn displacements_of_free_and_prescribed_dofs() {
        let mut squares = squares();
        assert_eq!((squares.nodes(0), squares.nodes(1)), (0..4, 4..8));
        let dofs = &squares.dofs;
        assert_eq!((dofs.free(), dofs.prescribed()), (16 - 4 - 2, 4 + 2));
        assert_eq!(squares.diagonal(), 5.0_f64.sqrt());
        squares.set_load(0.5);
        let u: Vec<f64> = (1..=10).map(f64::from).collect();
        let U = squares.displacements(&u);
        // free dofs in the order of the nodes; a rectangle numbers its nodes row by row
        let expected = [
            0., 0., 0., 0., 1., 2., 3., 4., 5., 6., 7., 8., 9., -0.25, 10., -0.25,
        ];
        let all: Vec<f64> = U.iter().flat_map(|u| [u[0], u[1]]).collect();
        assert_eq!(all, expected);
        let tops = [squares.positions(&u), squares.positions_at(&u, 1.0)].map(|x| x[6][1]);
        assert_eq!(tops, [2.0 - 0.25, 2.0 - 0.5]);
        let mut lifted = u.clone();
        squares.add_free(1, &[1.0; 8], &mut lifted);
        assert_eq!(lifted[..4], u[..4]);
        assert!(lifted[4..].iter().zip(&u[4..]).all(|(a, b)| *a == b + 1.0));
    }

    /// A row that pushes a free component of one body against a prescribed one of the other.
    #[test]
    fn forces_go_where_the_rows_take_hold() {
        let squares = squares();
        let mut gaps = LinearGaps::new(true);
        let row = Row {
            free: vec![(3, -1.0)],
            prescribed: vec![(4, 1.0)],
            ..Row::default()
        };
        gaps.push(RowKey { pass: 0, node: 3 }, &row);
        let forces = squares.contact_forces(&gaps, &[7.0]);
        let loaded: Vec<usize> = (0..8).filter(|&a| forces[a].norm() > 0.0).collect();
        assert_eq!(loaded, [3, 6]);
        assert_eq!((forces[3][1], forces[6][1]), (-7.0, 7.0));
    }
}
