//! A surface at current positions.

use std::sync::Arc;

use super::normals;
use super::surface::Surface;
use crate::tensor::Vector;

/// The positions x of a surface's own nodes and the averaged normals there, both in the order of
/// [`Surface::nodes`].
#[derive(Clone, Debug)]
pub struct Moving<const D: usize> {
    surface: Arc<Surface<D>>,
    x: Vec<Vector<D>>,
    normals: Vec<Vector<D>>,
}

impl<const D: usize> Moving<D> {
    /// For positions `x` of all scene nodes.
    pub fn new(surface: &Arc<Surface<D>>, x: &[Vector<D>]) -> Self {
        let x = surface.gather(x);
        let normals = normals::averaged(surface, &x);
        Moving {
            surface: Arc::clone(surface),
            x,
            normals,
        }
    }

    /// The surface it was made from.
    pub fn surface(&self) -> &Surface<D> {
        &self.surface
    }

    /// The nodes' positions (UL).
    pub fn positions(&self) -> &[Vector<D>] {
        &self.x
    }

    /// The averaged unit normals.
    pub fn normals(&self) -> &[Vector<D>] {
        &self.normals
    }
}
