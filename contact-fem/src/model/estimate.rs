//! The discretisation error of a state: what the mesh costs, where the certificate tells what the solver leaves.

use contact_core::equilibrium::Solution;

use super::{Body, BodyId, Opposite, PairSide, PairState, Problem, Side, negligible};
use crate::assembly::CellError;
use crate::error::Error;
use crate::instances::instance;
use crate::tensor::Vector;

/// The depth of a node that is no round-off, as a share of the facets around it.
const UNFELT: f64 = 1e-6;
/// Energies below this share of the scene's are round-off: nothing is strained.
const NEGLIGIBLE: f64 = 1e-13;

/// An estimate of the discretisation error of a state, by recovery: gradients of displacements are fitted around each corner, and the difference between
/// the fitted gradient and a cell's is taken as the cell's error. `docs/error.md` tells how far it can be trusted.
///
/// It knows nothing of the error of the geometry, nor of a contact zone that no facet resolves, see [`ContactFacets`].
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate<const D: usize> {
    /// η/√(2W + η²): the error of the displacements in the energy norm as a share of that norm, with the stored energy W. 0 where
    /// nothing is strained beyond round-off, NaN where a cell is inverted.
    pub relative: f64,
    /// η²/2 (UF·UL): by how much the energy of the exact solution is lower.
    pub energy: f64,
    /// The share of each body.
    pub bodies: Vec<BodyError<D>>,
    /// The share of each cell, body by body: η²= Σ η_k², and this is η_k/√(2W + η²).
    pub cells: Vec<f64>,
    /// The facets in contact of each pair, and of each surface with an obstacle, in the order of their declaration.
    pub contacts: Vec<ContactFacets>,
}

/// What one body has of an [`ErrorEstimate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyError<const D: usize> {
    /// The body.
    pub body: BodyId,
    /// Its share of the error in the energy norm of all bodies. The squares of these shares add up to [`ErrorEstimate::relative`]².
    pub relative: f64,
    /// Its share of [`ErrorEstimate::energy`] (UF·UL).
    pub energy: f64,
    /// The cell with the largest error, and the mean of its corners in the reference configuration (UL).
    pub worst: usize,
    /// See `worst`.
    pub place: Vector<D>,
}

/// How many facets are in contact. Few of them do not resolve how the pressure varies.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactFacets {
    /// One surface as declared.
    pub first: Side,
    /// The other one, or the obstacle.
    pub second: Opposite,
    /// The number of facets with a pressed node, on the surface of a deformable body where it is smaller; `None` without a force, and
    /// without a deformable body.
    pub touching: Option<usize>,
    /// Whether the contact zone ends within the surfaces, so that its size and its pressures depend on how facets resolve it. Surfaces
    /// all of whose facets touch do not need several of them.
    pub is_inside: bool,
    /// The depth of the deepest node inside the other surface where no force acts at all (UL); else 0. Means over facets do not see what is
    /// shallower than the facets' other ends are away.
    pub unfelt: f64,
}

impl<const D: usize> ErrorEstimate<D> {
    /// The fewest cells that have at least this share of η², as a mark for each cell.
    pub fn marked(&self, share: f64) -> Vec<bool> {
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by(|&a, &b| self.cells[b].total_cmp(&self.cells[a]));
        let square = |k: &usize| self.cells[*k].powi(2);
        let goal = share * order.iter().map(square).sum::<f64>();
        let (mut marked, mut sum) = (vec![false; self.cells.len()], 0.0);
        for k in order {
            if sum >= goal || self.cells[k] == 0.0 {
                break;
            }
            marked[k] = true;
            sum += square(&k);
        }
        marked
    }
}

impl ContactFacets {
    /// Fewer facets in the plane, or along the diameter of a zone in space, do not resolve a contact zone. The number was chosen on half-cylinders on
    /// blocks and balls on planes, see `docs/error.md`.
    pub const FEWEST: usize = 4;

    /// Whether facets do not resolve the contact zone of a scene in space or in the plane.
    pub fn is_unresolved(&self, dimension: usize) -> bool {
        // a disc of this diameter, in triangles of which two are a square
        let across = Self::FEWEST as f64;
        let fewest = match dimension {
            2 => across,
            _ => 0.5 * std::f64::consts::PI * across * across,
        };
        let are_few = self.touching.is_some_and(|count| (count as f64) < fewest);
        self.unfelt > 0.0 || self.is_inside && are_few
    }
}

/// The errors of all cells, body by body.
pub(crate) struct CellErrors {
    bodies: Vec<Vec<CellError>>,
    /// η², and 2W + η² (UF·UL).
    square: f64,
    norm: f64,
}

impl CellErrors {
    /// At a state `u`.
    pub fn new<const D: usize>(problem: &Problem<D>, u: &[f64]) -> Self {
        let U = problem.displacements(u);
        let bodies = problem.scene().bodies().iter().enumerate();
        let of_body = |(b, body): (usize, &Body<D>)| {
            problem.body_energies()[b].cell_errors(body.mesh(), &U[problem.nodes(b)])
        };
        let bodies: Vec<Vec<CellError>> = bodies.map(of_body).collect();
        let (mut square, mut stored) = (0.0, 0.0);
        for cell in bodies.iter().flatten() {
            square += cell.square;
            stored += cell.energy;
        }
        // round-off may store less than nothing
        let norm = if stored < 0.0 {
            square
        } else {
            2.0 * stored + square
        };
        CellErrors {
            norm: match norm <= NEGLIGIBLE * problem.scale().energy {
                true => 0.0,
                false => norm,
            },
            square,
            bodies,
        }
    }

    /// The share of a square in the norm.
    fn share(&self, square: f64) -> f64 {
        match self.norm {
            0.0 => 0.0,
            norm if norm.is_finite() => (square / norm).sqrt(),
            _ => f64::NAN,
        }
    }

    /// Those of all cells.
    pub fn shares(&self) -> Vec<f64> {
        let cells = self.bodies.iter().flatten();
        cells.map(|cell| self.share(cell.square)).collect()
    }
}

impl<const D: usize> Problem<D> {
    /// Estimates the discretisation error of `solution`.
    ///
    /// # Errors
    /// If the solution is not of this problem.
    pub fn error_estimate(&self, solution: &Solution) -> Result<ErrorEstimate<D>, Error> {
        instance().error_estimate(self, solution)
    }

    /// [`Problem::error_estimate`].
    pub(crate) fn estimate(&self, solution: &Solution) -> Result<ErrorEstimate<D>, Error> {
        let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
        self.check_rows(u, gaps, lambda)?;
        let errors = CellErrors::new(self, u);
        let bodies = self.scene().bodies().iter().zip(&errors.bodies);
        let of_body = |(b, (body, own)): (usize, (&Body<D>, &Vec<CellError>))| {
            let sum: f64 = own.iter().map(|cell| cell.square).sum();
            let cells = own.iter().enumerate();
            let worst = cells.max_by(|a, b| a.1.square.total_cmp(&b.1.square));
            let worst = worst.map_or(0, |(k, _)| k);
            BodyError {
                body: BodyId(b),
                relative: errors.share(sum),
                energy: 0.5 * sum,
                worst,
                place: body.mesh().centre(worst),
            }
        };
        Ok(ErrorEstimate {
            relative: errors.share(errors.square),
            energy: 0.5 * errors.square,
            bodies: bodies.enumerate().map(of_body).collect(),
            cells: errors.shares(),
            contacts: self.contact_facets(solution)?,
        })
    }

    /// The facets in contact of each pair.
    fn contact_facets(&self, solution: &Solution) -> Result<Vec<ContactFacets>, Error> {
        let (gaps, lambda) = (&solution.gaps, &solution.lambda);
        let states = self.pair_states(&solution.state.u, gaps, lambda)?;
        let [_, roundoff, _] = negligible(&self.scale());
        let of_pair = |state: PairState<D>| {
            let deforms = |surface: usize| {
                let body = self.surfaces()[surface].body();
                self.body_energies()[body].assembled_cells() > 0
            };
            // after a load is let go, forces may be round-off
            let carries = |side: &&PairSide<D>| {
                side.forces.iter().map(|force| force.norm()).sum::<f64>() > roundoff
            };
            let sides = state.sides.iter().filter(|side| deforms(side.surface));
            let touching = sides.filter(carries).map(|side| {
                let surface = &self.surfaces()[side.surface];
                let presses = |nodes: &&[usize]| nodes.iter().any(|&a| side.pressures[a] > 0.0);
                (
                    surface.facets().filter(presses).count(),
                    surface.facets().len(),
                )
            });
            let touching: Vec<(usize, usize)> = touching.filter(|(count, _)| *count > 0).collect();
            let fewest = touching.iter().map(|(count, _)| *count).min();
            let depths = state.sides.iter().flat_map(|side| {
                let sizes = self.surfaces()[side.surface].node_sizes();
                let gaps = side.gaps.iter().zip(sizes);
                gaps.filter_map(|(gap, size)| gap.filter(|gap| *gap < -UNFELT * size))
            });
            let deepest = depths.fold(0.0, |most: f64, gap| most.max(-gap));
            ContactFacets {
                unfelt: if fewest.is_none() { deepest } else { 0.0 },
                first: state.record.first,
                second: state.record.second,
                touching: fewest,
                is_inside: touching.iter().all(|(count, all)| count < all),
            }
        };
        Ok(states.into_iter().map(of_pair).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fewest_cells_that_have_the_share_are_marked() {
        // squares .01, .25, .04 and 0
        let estimate = ErrorEstimate::<2> {
            relative: 0.3_f64.sqrt(),
            energy: 1.0,
            bodies: Vec::new(),
            cells: vec![0.1, 0.5, 0.2, 0.0],
            contacts: Vec::new(),
        };
        for (share, marked) in [
            (0.8, [false, true, false, false]),
            (0.9, [false, true, true, false]),
            (0.99, [true, true, true, false]),
        ] {
            assert_eq!(estimate.marked(share), marked, "{share}");
        }
    }
}
