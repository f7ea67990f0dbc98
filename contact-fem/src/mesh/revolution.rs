//! Sections of bodies of revolution.

use std::f64::consts::TAU;

use super::Mesh;
use crate::element::cell_rule::degree_5;
use crate::element::{Element, Order, P1, P2};
use crate::error::Error;
use crate::tensor::Vector;

/// Nodes are on the axis up to this share of the mesh's size.
const ON_AXIS: f64 = 1e-9;

impl<const D: usize> Mesh<D> {
    /// Whether it is the section of a body of revolution, as that of [`Body::of_revolution`](crate::Body::of_revolution).
    pub fn is_of_revolution(&self) -> bool {
        self.is_revolved
    }

    /// 2πR at a point of the section of a body of revolution (UL), by which lengths and areas there are to be multiplied; else 1.
    pub(crate) fn ring(&self, X: &Vector<D>) -> f64 {
        match self.is_revolved {
            true => TAU * X[0],
            false => 1.0,
        }
    }
}

impl Mesh<2> {
    /// The mesh as the section of a body of revolution about the axis r = 0, and its nodes on the axis. Nodes closer to it than
    /// 1e-9 of the mesh's size are moved there.
    ///
    /// # Errors
    /// A node with r < 0.
    pub(crate) fn revolved(mut self) -> Result<(Self, Vec<usize>), Error> {
        let (low, high) = self.bounding_box();
        let near = ON_AXIS * (high - low).norm();
        let mut axis = Vec::new();
        for (node, X) in self.nodes.iter_mut().enumerate() {
            if X[0].abs() <= near {
                X[0] = 0.0;
                axis.push(node);
            } else if X[0] < 0.0 {
                return Err(Error::NegativeRadius { node, radius: X[0] });
            }
        }
        // moved by round-off at most, which no valid cell notices
        self.is_revolved = true;
        Ok((self, axis))
    }

    /// The volume of the body of revolution with this section (UL³), or the area of a section in the plane (UL²).
    pub(crate) fn revolved_volume(&self) -> f64 {
        let of_cell = |k: usize| -> f64 {
            let points = degree_5::<2>().map(|(weight, xi)| {
                let shapes = match self.order {
                    Order::Linear => <P1 as Element<2>>::shapes(&xi).as_ref().to_vec(),
                    Order::Quadratic => <P2 as Element<2>>::shapes(&xi).as_ref().to_vec(),
                };
                let nodes = self.cell(k).iter().zip(shapes);
                let X = nodes.map(|(&a, N)| self.nodes[a] * N).sum::<Vector<2>>();
                weight * self.jacobian(k, &xi) * self.ring(&X)
            });
            points.sum()
        };
        (0..self.len()).map(of_cell).sum()
    }
}
