//! The laws of a body's quadrature points: one for all, one for each region, or one for each point.

use crate::element::Element;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// Laws of one type, and which of them holds where.
#[derive(Clone, Debug)]
pub struct Laws<M> {
    laws: Vec<M>,
    /// The law of each quadrature point, cell by cell, and of each cell's centre; both empty if there is one law.
    of_points: Vec<usize>,
    of_centres: Vec<usize>,
}

impl<M> From<M> for Laws<M> {
    /// One law everywhere.
    fn from(law: M) -> Self {
        Laws {
            laws: vec![law],
            of_points: Vec::new(),
            of_centres: Vec::new(),
        }
    }
}

impl<M> Laws<M> {
    /// A law for each of the named regions of a mesh with elements `E`, which have each cell once.
    ///
    /// # Errors
    /// A region that does not exist, and a cell in none of them or in several.
    pub fn of_regions<const D: usize, E: Element<D>>(
        mesh: &Mesh<D>,
        laws: impl IntoIterator<Item = (impl AsRef<str>, M)>,
    ) -> Result<Self, Error> {
        let mut own = Vec::new();
        let mut of_centres: Vec<Option<usize>> = vec![None; mesh.len()];
        for (k, (region, law)) in laws.into_iter().enumerate() {
            for &cell in mesh.region_cells(region.as_ref())? {
                if of_centres[cell].replace(k).is_some() {
                    return Err(Error::LawsOfCell {
                        cell,
                        several: true,
                    });
                }
            }
            own.push(law);
        }
        let missed = |(cell, k): (usize, Option<usize>)| {
            let several = false;
            k.ok_or(Error::LawsOfCell { cell, several })
        };
        let of_centres = of_centres.into_iter().enumerate().map(missed);
        let of_centres = of_centres.collect::<Result<Vec<usize>, Error>>()?;
        let of_cell = |&k| std::iter::repeat_n(k, E::QUADRATURE.len());
        Ok(Laws {
            laws: own,
            of_points: of_centres.iter().flat_map(of_cell).collect(),
            of_centres,
        })
    }

    /// The law as a function of X (UL), at each quadrature point and at the centre of each cell of a mesh with elements `E`.
    ///
    /// # Errors
    /// Those of the function.
    pub fn graded<const D: usize, E: Element<D>>(
        mesh: &Mesh<D>,
        law: impl Fn(&Vector<D>) -> Result<M, Error>,
    ) -> Result<Self, Error> {
        let centre = Vector::repeat(1.0 / (D + 1) as f64);
        let (mut laws, mut of_points, mut of_centres) = (Vec::new(), Vec::new(), Vec::new());
        for cell in mesh.cells() {
            let mut add = |xi: &Vector<D>| {
                let shapes = E::shapes(xi);
                let terms = cell.iter().zip(shapes.as_ref());
                laws.push(law(&terms.map(|(&a, N)| mesh.nodes()[a] * *N).sum())?);
                Ok::<usize, Error>(laws.len() - 1)
            };
            for (_, xi) in E::QUADRATURE {
                of_points.push(add(&Vector::from(*xi))?);
            }
            of_centres.push(add(&centre)?);
        }
        Ok(Laws {
            laws,
            of_points,
            of_centres,
        })
    }

    /// The law of a quadrature point.
    pub(super) fn at(&self, point: usize) -> &M {
        &self.laws[self.of_points.get(point).copied().unwrap_or(0)]
    }

    /// The law of a cell's centre.
    pub(super) fn at_centre(&self, cell: usize) -> &M {
        &self.laws[self.of_centres.get(cell).copied().unwrap_or(0)]
    }

    /// The part of the body that a cell is of: that of its law, or 0 where laws vary from point to point.
    pub(super) fn part(&self, cell: usize) -> usize {
        match self.laws.len() > self.of_centres.len() {
            true => 0,
            false => self.of_centres[cell],
        }
    }

    /// All laws.
    pub fn all(&self) -> &[M] {
        &self.laws
    }
}

impl<M: Clone> Laws<M> {
    /// The laws for a list of quadrature points of these cells alone, `per_cell` each; centres are those of all cells.
    pub(super) fn of_assembled(&self, cells: &[usize], per_cell: usize) -> Self {
        let mut own = self.clone();
        if !self.of_points.is_empty() {
            let points = cells.iter().flat_map(|k| k * per_cell..(k + 1) * per_cell);
            own.of_points = points.map(|point| self.of_points[point]).collect();
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use contact_core::Energy;

    use super::*;
    use crate::LinearElastic;
    use crate::assembly::{BodyEnergy, DofMap, StrainEnergy};
    use crate::element::P1;
    use crate::mesh::generators::{Diagonals, rectangle};
    use crate::tensor::Matrix;

    /// Two columns, of which the first is held and therefore not assembled: the other has its own law, and stresses of cells have
    /// theirs.
    #[test]
    fn held_cells_keep_their_law() {
        let mesh = rectangle(&[0.0, 1.0, 2.0], &[0.0, 1.0], Diagonals::Rising);
        let mut mesh = mesh.expect("a mesh");
        mesh.name_region("held", |X| X[0] < 1.0);
        mesh.name_region("free", |X| X[0] > 1.0);
        let law = |E: f64| LinearElastic::new(E, 0.25).expect("a law");
        let regions = [("held", law(1.0)), ("free", law(5.0))];
        let laws = Laws::of_regions::<2, P1>(&mesh, regions).expect("laws");
        let graded = Laws::graded::<2, P1>(&mesh, |X| {
            LinearElastic::new(if X[0] < 1.0 { 1.0 } else { 5.0 }, 0.25)
        });
        let held: Vec<bool> = mesh.nodes().iter().map(|X| X[0] < 1.5).collect();
        let held: Vec<bool> = held.iter().flat_map(|&held| [held; 2]).collect();
        let (dofs, n) = (DofMap::new(&held), held.len());
        let (none, forces) = (vec![0.0; dofs.prescribed()], vec![0.0; n]);
        let twin = StrainEnergy::<2, P1, _>::new(
            &mesh,
            law(5.0),
            dofs.clone(),
            none.clone(),
            forces.clone(),
        );
        let u: Vec<f64> = (0..dofs.free()).map(|k| 0.1 + k as f64).collect();
        let strain = Matrix::<2>::new(0.1, 0.0, 0.0, 0.2);
        let U: Vec<Vector<2>> = mesh.nodes().iter().map(|X| strain * X).collect();
        for laws in [laws, graded.expect("laws")] {
            let (none, forces) = (none.clone(), forces.clone());
            let energy =
                StrainEnergy::<2, P1, _>::with_laws(&mesh, &laws, dofs.clone(), none, forces);
            assert_eq!(energy.assembled_cells(), 2);
            assert_eq!(energy.value(&u), twin.value(&u));
            let states = energy.cell_states(&mesh, &U);
            for (cell, state) in states.iter().enumerate() {
                let centre = mesh.corners(cell).iter().map(|&a| mesh.nodes()[a][0]);
                let E = if centre.sum::<f64>() < 3.0 { 1.0 } else { 5.0 };
                let expected = E * (0.4 * 0.3 + 0.8 * 0.1);
                assert!((state.sigma[(0, 0)] - expected).abs() < 1e-14, "{state:?}");
            }
        }
    }
}
