//! A contact surface at current positions.

use std::sync::Arc;

use super::normals::{self, Addend, Direction};
use super::surface::Surface;
use crate::element::Facet;
use crate::tensor::Vector;

/// The positions x of a surface's own nodes and their averaged normals, both in the order of
/// [`Surface::nodes`].
#[derive(Clone, Debug)]
pub struct Moving<const D: usize> {
    surface: Arc<Surface<D>>,
    x: Vec<Vector<D>>,
    normals: Vec<Vector<D>>,
    /// |s_a| of the sums s_a whose directions are the normals; 0 on an axis of revolution, where they do not turn.
    lengths: Vec<f64>,
}

impl<const D: usize> Moving<D> {
    /// For positions `x` of all scene nodes.
    pub fn new(surface: &Arc<Surface<D>>, x: &[Vector<D>]) -> Self {
        let x = surface.gather(x);
        let sums = normals::sums(surface, &x);
        #[cfg(planted)]
        let sums = super::planted::normals(surface, sums);
        Moving {
            surface: Arc::clone(surface),
            x,
            lengths: sums
                .iter()
                .enumerate()
                .map(|(a, sum)| match surface.is_on_axis(a) {
                    true => 0.0,
                    false => sum.norm(),
                })
                .collect(),
            normals: sums.into_iter().map(normals::unit).collect(),
        }
    }

    /// The surface in the reference configuration.
    pub fn surface(&self) -> &Surface<D> {
        &self.surface
    }

    /// The nodes' positions (UL).
    pub fn positions(&self) -> &[Vector<D>] {
        &self.x
    }

    /// The averaged unit normals n_a.
    pub fn normals(&self) -> &[Vector<D>] {
        &self.normals
    }

    /// n_a as the direction s_a/|s_a| of the sum of [`Moving::addends`].
    pub(super) fn normal(&self, a: usize) -> Direction<D> {
        Direction {
            n: self.normals[a],
            length: self.lengths[a],
        }
    }

    /// The contributions of the facets around node `a` to its normal, with the facets' indices.
    pub(super) fn addends(&self, a: usize) -> impl Iterator<Item = (usize, Addend<D>)> + '_ {
        let facets = self.surface.facets_around(a);
        facets.map(|(f, k)| {
            let nodes = self.surface.facet(f);
            let facet = Facet::gather(self.surface.order(), nodes, &self.x);
            (f, Addend::new(&facet, k))
        })
    }
}
