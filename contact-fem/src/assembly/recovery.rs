//! The error of each cell, estimated by recovery: gradients of displacements are fitted around each corner, and the difference between the
//! fitted gradient and the cell's is taken as the cell's error.

use std::collections::BTreeMap;

use nalgebra::{SMatrix, SVector};

use super::kinematics::Kinematics;
use super::strain_energy::gathered;
use crate::element::cell_rule::{degree_2, degree_5};
use crate::element::{Element, Order};
use crate::mesh::Mesh;
use crate::parallel;
use crate::tensor::{Matrix, Vector, inverse_transpose};

/// The fewest samples of a fit, as a multiple of its coefficients.
const SAMPLES: usize = 2;
/// A fit needs the cells around its corner, and at least this number more than a cell has corners; on a border, where they are on one
/// side, more still.
const CELLS: usize = 2;
const CELLS_ON_BORDERS: usize = 4;
/// A monomial belongs to a fit if so much of its square is independent of the monomials before it.
const INDEPENDENT: f64 = 1e-6;
/// The largest variance of the value of a fit at its corner, as a multiple of the variance of a sample there, if weights are the inverse of variances. It is
/// at most 16 on meshes of equal cells, and 500 and more where all samples are on one side in a thin wedge.
const VARIANCE: f64 = 64.0;
/// Samples at the distance d of the corner, relative to the farthest one, count 1/(this + d²).
const NEARBY: f64 = 0.1;

/// What an estimate knows of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellError {
    /// The square of its error in the energy norm (UF·UL): ∫ (G − ∇u) : A : (G − ∇u) dX of the recovered gradient G, with the
    /// stiffness A of the law at u. Zero where A is not positive, and in cells whose nodes are all prescribed.
    pub square: f64,
    /// The energy that the cell stores, ∫ ψ(I + ∇u) − ψ(I) dX (UF·UL).
    pub energy: f64,
}

/// The errors of all cells of a mesh whose nodes are displaced by `U`. Of each cell `law` gives the law and the part of the body: fits do
/// not cross borders of parts, where gradients jump. Cells without a law have no error.
pub(super) fn errors_of_cells<'a, const D: usize, E: Element<D>, M, K>(
    mesh: &Mesh<D>,
    U: &[Vector<D>],
    law: impl Fn(usize) -> Option<(&'a M, usize)> + Send + Sync,
) -> Vec<CellError>
where
    M: Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    let recovered = Recovered::new::<E>(mesh, U, |k| law(k).map(|(_, part)| part));
    let rule = rule::<D>(E::ORDER);
    let mut errors = vec![CellError::default(); mesh.len()];
    parallel::fill(&mut errors, 1, |k, error| {
        let Some((law, _)) = law(k) else {
            return;
        };
        let (nodes, local) = gathered::<D, E>(mesh.cell(k), U);
        let at_rest = K::energy_density(law, &K::rest());
        for (point, (_, xi)) in K::points_in(mesh, &nodes, &rule).zip(&rule) {
            let (at, weight) = (K::at(&point, &local), K::weight(&point));
            let xi = Vector::from(*xi);
            let X = place::<D, E>(mesh, k, &xi);
            let mut apart = recovered.gradient(k, &xi, &X);
            for (v, dN) in local.as_ref().iter().zip(K::gradients(&point).as_ref()) {
                apart.ger(-1.0, v, dN, 1.0);
            }
            error[0].square += weight * K::square(law, &at, &apart);
            error[0].energy += weight * (K::energy_density(law, &at) - at_rest);
        }
        if error[0].square < 0.0 {
            error[0].square = 0.0;
        }
    });
    errors
}

/// Quadrature for squares of errors, (weight, ξ): more points than the samples of a cell, which do not see all of its error.
fn rule<const D: usize>(order: Order) -> Vec<(f64, [f64; D])> {
    let flat = |(weight, xi): (f64, Vector<D>)| (weight, xi.into());
    match order {
        Order::Linear => degree_2().map(flat).collect(),
        Order::Quadratic => degree_5().map(flat).collect(),
    }
}

/// X at ξ in a cell.
fn place<const D: usize, E: Element<D>>(mesh: &Mesh<D>, k: usize, xi: &Vector<D>) -> Vector<D> {
    let shapes = E::shapes(xi);
    let terms = mesh.cell(k).iter().zip(shapes.as_ref());
    terms.map(|(&a, N)| mesh.nodes()[a] * *N).sum()
}

/// A field G near ∇u. Each corner has a polynomial of the displacements' degree, fitted by least squares to the gradients of the cells around it. A cell
/// has the polynomials of its corners, weighted by barycentric coordinates. After O. C. Zienkiewicz and J. Z. Zhu, The
/// superconvergent patch recovery and a posteriori error estimates, Int. J. Numer. Meth. Engng 33 (1992) 1331–1382, and, for
/// the weights, N.-E. Wiberg and F. Abdulwahab, ibid. 36 (1993) 2703–2724.
struct Recovered<const D: usize> {
    fits: Vec<Fit<D>>,
    /// The fit at each corner, cell by cell; the entries of cells without a part have no meaning.
    of_corners: Vec<usize>,
}

/// The gradient of the displacements at a point.
#[derive(Clone, Copy)]
struct Sample<const D: usize> {
    X: Vector<D>,
    gradient: Matrix<D>,
}

/// The corner of a part of a body, with the cells of the part around it.
struct Corner {
    node: usize,
    cells: Vec<usize>,
    is_on_border: bool,
}

impl<const D: usize> Recovered<D> {
    fn new<E: Element<D>>(
        mesh: &Mesh<D>,
        U: &[Vector<D>],
        part: impl Fn(usize) -> Option<usize> + Send + Sync,
    ) -> Self {
        let mut numbers: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let (mut corners, mut of_corners) = (Vec::<Corner>::new(), vec![0; (D + 1) * mesh.len()]);
        let mut is_on_border = vec![false; mesh.nodes().len()];
        mesh.exterior()
            .flatten()
            .for_each(|&a| is_on_border[a] = true);
        for (k, part) in (0..mesh.len()).filter_map(|k| Some((k, part(k)?))) {
            for (place, &node) in mesh.corners(k).iter().enumerate() {
                let number = *numbers.entry((node, part)).or_insert_with(|| {
                    corners.push(Corner {
                        node,
                        cells: Vec::new(),
                        is_on_border: is_on_border[node],
                    });
                    corners.len() - 1
                });
                corners[number].cells.push(k);
                of_corners[(D + 1) * k + place] = number;
            }
        }
        // a node of several parts is on their border
        let owners: Vec<(usize, usize)> = numbers.iter().map(|(key, n)| (key.0, *n)).collect();
        for pair in owners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            pair.iter()
                .for_each(|(_, n)| corners[*n].is_on_border = true);
        }
        let places = places::<D>(E::ORDER).into_iter();
        let places = places.map(|xi| (E::shapes(&xi), E::shape_gradients(&xi)));
        let places: Vec<_> = places.collect();
        let per_cell = places.len();
        let none = Sample {
            X: Vector::zeros(),
            gradient: Matrix::zeros(),
        };
        let mut samples = vec![none; per_cell * mesh.len()];
        parallel::fill(&mut samples, per_cell, |k, samples| {
            for (sample, (shapes, gradients)) in samples.iter_mut().zip(&places) {
                let (mut dX, mut du) = (Matrix::<D>::zeros(), Matrix::<D>::zeros());
                let own = shapes.as_ref().iter().zip(gradients.as_ref());
                for (&a, (N, dN)) in mesh.cell(k).iter().zip(own) {
                    sample.X += mesh.nodes()[a] * *N;
                    dX.ger(1.0, &mesh.nodes()[a], dN, 1.0);
                    du.ger(1.0, &U[a], dN, 1.0);
                }
                sample.gradient = du * inverse_transpose(&dX).transpose();
            }
        });
        let neighbours = |k: usize| {
            let own = &of_corners[(D + 1) * k..(D + 1) * (k + 1)];
            own.iter()
                .flat_map(|&number| corners[number].cells.iter().copied())
        };
        let mut fits = vec![Fit::default(); corners.len()];
        parallel::fill(&mut fits, 1, |number, fit| {
            let corner = &corners[number];
            let of_cell = |k: &usize| &samples[per_cell * k..per_cell * (k + 1)];
            let least = D
                + 1
                + match corner.is_on_border {
                    true => CELLS_ON_BORDERS,
                    false => CELLS,
                };
            let count = coefficients::<D>(E::ORDER);
            let mut patch = corner.cells.clone();
            fit[0] = loop {
                let centre = mesh.nodes()[corner.node];
                let own: Vec<Sample<D>> = patch.iter().flat_map(of_cell).copied().collect();
                let found = Fit::new(centre, &own, count);
                let is_enough = patch.len() >= least
                    && own.len() >= SAMPLES * count
                    && found.coefficients.len() == count
                    && found.variance <= VARIANCE;
                if is_enough {
                    break found;
                }
                let mut wider: Vec<usize> = patch.iter().copied().flat_map(neighbours).collect();
                wider.sort_unstable();
                wider.dedup();
                if wider.len() == patch.len() {
                    break found;
                }
                patch = wider;
            };
        });
        Recovered { fits, of_corners }
    }

    /// G at ξ, which is X, in a cell of a part.
    fn gradient(&self, k: usize, xi: &Vector<D>, X: &Vector<D>) -> Matrix<D> {
        let own = &self.of_corners[(D + 1) * k..(D + 1) * (k + 1)];
        let first = 1.0 - xi.sum();
        let weights = std::iter::once(&first).chain(xi.iter());
        own.iter()
            .zip(weights)
            .map(|(&number, weight)| self.fits[number].at(X) * *weight)
            .sum()
    }
}

/// A polynomial with matrices for coefficients.
#[derive(Clone)]
struct Fit<const D: usize> {
    centre: Vector<D>,
    /// The distance of the farthest sample (UL).
    radius: f64,
    /// Those of the first monomials of [`monomials`], in (X − centre)/radius.
    coefficients: Vec<Matrix<D>>,
    /// See [`VARIANCE`].
    variance: f64,
}

impl<const D: usize> Default for Fit<D> {
    fn default() -> Self {
        Fit {
            centre: Vector::zeros(),
            radius: 1.0,
            coefficients: Vec::new(),
            variance: 0.0,
        }
    }
}

impl<const D: usize> Fit<D> {
    /// The polynomial of `count` coefficients, or of the largest degree below that the samples determine.
    fn new(centre: Vector<D>, samples: &[Sample<D>], count: usize) -> Self {
        let distances = samples.iter().map(|sample| (sample.X - centre).norm());
        let radius = distances.fold(0.0, f64::max);
        let fit = |count: &usize| match count {
            1 => least_squares::<D, 1>(centre, radius, samples),
            3 => least_squares::<D, 3>(centre, radius, samples),
            4 => least_squares::<D, 4>(centre, radius, samples),
            6 => least_squares::<D, 6>(centre, radius, samples),
            _ => least_squares::<D, 10>(centre, radius, samples),
        };
        let degrees = [coefficients::<D>(Order::Quadratic), D + 1, 1];
        let mut lower = degrees.iter().filter(|degree| **degree <= count);
        let (coefficients, variance) = lower.find_map(fit).unwrap_or_default();
        Fit {
            centre,
            radius,
            coefficients,
            variance,
        }
    }

    fn at(&self, X: &Vector<D>) -> Matrix<D> {
        let monomials = monomials(&((X - self.centre) / self.radius));
        let terms = self.coefficients.iter().zip(monomials);
        terms.fold(Matrix::zeros(), |sum, (coefficient, monomial)| {
            sum + coefficient * monomial
        })
    }
}

/// The N coefficients of the polynomial in (X − centre)/radius that is closest to the samples, and the variance at the centre; `None` if samples do
/// not determine it.
fn least_squares<const D: usize, const N: usize>(
    centre: Vector<D>,
    radius: f64,
    samples: &[Sample<D>],
) -> Option<(Vec<Matrix<D>>, f64)> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = [Matrix::<D>::zeros(); N];
    for Sample { X, gradient } in samples {
        let r = (X - centre) / radius;
        let all = monomials(&r);
        let own = SVector::<f64, N>::from_fn(|i, _| all[i]);
        let weight = 1.0 / (NEARBY + r.norm_squared());
        normal.ger(weight, &own, &own, 1.0);
        let terms = right.iter_mut().zip(own.iter());
        terms.for_each(|(sum, a)| *sum += gradient * (weight * a));
    }
    let factor = normal.cholesky()?;
    let pivot = |i: usize| factor.l_dirty()[(i, i)].powi(2);
    if (0..N).any(|i| pivot(i) <= INDEPENDENT * normal[(i, i)]) {
        return None;
    }
    let mut coefficients = vec![Matrix::zeros(); N];
    for c in 0..D * D {
        let solution = factor.solve(&SVector::<f64, N>::from_fn(|i, _| right[i][c]));
        let own = coefficients.iter_mut().zip(solution.iter());
        own.for_each(|(matrix, value)| matrix[c] = *value);
    }
    let at_centre = SVector::<f64, N>::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 });
    let variance = factor.solve(&at_centre)[0] / NEARBY;
    Some((coefficients, variance))
}

/// 1, r_i, and r_i r_j; unused ones are zero.
fn monomials<const D: usize>(r: &Vector<D>) -> [f64; 10] {
    let mut all = [0.0; 10];
    all[0] = 1.0;
    all[1..=D].copy_from_slice(r.as_slice());
    let mut next = D + 1;
    for i in 0..D {
        for j in i..D {
            all[next] = r[i] * r[j];
            next += 1;
        }
    }
    all
}

/// The number of monomials up to the degree of the displacements.
fn coefficients<const D: usize>(order: Order) -> usize {
    match order {
        Order::Linear => D + 1,
        Order::Quadratic => (D + 1) * (D + 2) / 2,
    }
}

/// Where the gradient of a cell is sampled: at the centre of a linear cell, at the points of the rule of degree 2 in a quadratic one.
fn places<const D: usize>(order: Order) -> Vec<Vector<D>> {
    match order {
        Order::Linear => vec![Vector::repeat(1.0 / (D + 1) as f64)],
        Order::Quadratic => degree_2().map(|(_, xi)| xi).collect(),
    }
}

#[cfg(test)]
mod tests;
