//! Stability, from the inertia of the tangent on the motions that rows with a force permit.

use std::collections::BTreeMap;

use contact_core::linear::SymmetricPattern;
use contact_core::{ContactProblem, LinearGaps};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{MatMut, Side};
use nalgebra::{DMatrix, DVector, DVectorView};

use super::Measured;
use crate::assembly::Dof;
use crate::model::{Geometry, Problem};
use crate::tensor::{Matrix, Vector, unit_vector};

/// The stiffness of rows with a force, and of ties, in units of the largest of the unknowns that they move.
const HOLDS: f64 = 1e5;
/// What is added to the diagonal, as a share of itself: round-off of the factorisation.
const ROUND_OFF: f64 = 1e-12;
/// The number of motions that are looked at, where some release energy: the first number and the rigid motions of all bodies, but at most the second.
const MOTIONS: [usize; 2] = [8, 64];
/// Rounds of the inverse iteration.
const ROUNDS: usize = 12;
/// The largest share that is looked for, by what factor shifts grow, and how often the interval of the shift is halved.
const LARGEST: f64 = 1e6;
const SPREAD: f64 = 4.0;
const HALVINGS: usize = 6;
/// A body deforms if its motion is farther from a translation and a rotation than this share of it, by root mean squares over its nodes. Bodies are
/// looked at that move by more than the second share of the one that moves most.
const RIGID: f64 = 0.07;
const TAKES_PART: f64 = 0.1;
/// The step of differences of gradients, as a share of the smallest height of cells, and by how much the Hessian's product may differ from them.
const STEP: f64 = 1e-5;
const SLOPE: f64 = 1e-3;
/// The step of differences of the distance from an obstacle, as a share of a facet.
const DISTANCE: f64 = 1e-3;

/// A motion of the unknowns along which energy is released.
#[derive(Debug)]
pub(in crate::certificate) struct Release {
    /// −vᵀKv, by the unit.
    pub share: f64,
    /// Whether a body deforms along v.
    pub deforms: bool,
}

/// The motions that release energy.
#[derive(Debug, Default)]
pub(in crate::certificate) struct Releases {
    /// Those that release most first.
    pub motions: Vec<Release>,
    /// Whether these are all.
    pub are_all: bool,
}

/// K = ∇²E − sym D, with the slopes D of contact forces, and stiff springs on the rows with a force and on ties. K is positive
/// on the motions that these permit if it has a Cholesky factor.
struct Tangent {
    pattern: SymmetricPattern,
    held: Vec<f64>,
    /// One entry for each unknown (UF/UL).
    unit: Vec<f64>,
    symbolic: SymbolicLlt<usize>,
}

/// Where nodes are, and the free unknowns.
pub(in crate::certificate) type State<'a, const D: usize> = (&'a [Vector<D>], &'a [f64]);

/// The motions that release more than the share `limit` of the unit. The unit is the curvature of a force that turns with the body: the sum
/// of the forces on a body's nodes, at least `noticed`, divided by the longest side of the box around the body, times the mean square of
/// the motion. `None` where the tangent is not that of the energy's gradient.
pub(in crate::certificate) fn releases<const D: usize>(
    problem: &Problem<D>,
    measured: &[Measured<'_, D>],
    (x, u): State<'_, D>,
    (gaps, lambda): (&LinearGaps, &[f64]),
    (noticed, limit): (f64, f64),
) -> Option<Releases> {
    if problem.geometry() == Geometry::Reference && problem.energy().is_quadratic() {
        // rows at X do not vary, and a law for small strains has a positive tangent
        return Some(Releases::none());
    }
    let tangent = Tangent::new(problem, measured, (x, u), (gaps, lambda), noticed)?;
    if tangent.factor(limit).is_some() {
        return Some(Releases::none());
    }
    let mut shift = 2.0 * limit;
    while tangent.factor(shift).is_none() {
        shift *= SPREAD;
        if shift > LARGEST {
            return None;
        }
    }
    // between a shift that fails and one that holds
    let (mut fails, mut holds) = (limit, shift);
    for _ in 0..HALVINGS {
        let middle = (fails * holds).sqrt();
        match tangent.factor(middle) {
            Some(_) => holds = middle,
            None => fails = middle,
        }
    }
    let factor = tangent.factor(holds)?;
    let rigid = D * (D + 1) / 2 * problem.scene().bodies().len();
    let count = (MOTIONS[0] + rigid).min(MOTIONS[1]).min(u.len());
    let softest = tangent.softest(&factor, count);
    let releasing = softest.into_iter().filter(|(share, _)| *share > limit);
    let mut motions: Vec<Release> = releasing
        .map(|(share, v)| Release {
            share,
            deforms: deformation(problem, x, &v) > RIGID,
        })
        .collect();
    motions.sort_by(|a, b| b.share.total_cmp(&a.share));
    let are_all = motions.len() < count || count == u.len();
    Some(Releases { motions, are_all })
}

impl Releases {
    fn none() -> Self {
        Releases {
            motions: Vec::new(),
            are_all: true,
        }
    }
}

impl Tangent {
    fn new<const D: usize>(
        problem: &Problem<D>,
        measured: &[Measured<'_, D>],
        (x, u): State<'_, D>,
        (gaps, lambda): (&LinearGaps, &[f64]),
        noticed: f64,
    ) -> Option<Self> {
        let energy = problem.energy();
        let n = u.len();
        let own = energy.hessian_pattern();
        let mut hessian = vec![0.0; own.len()];
        energy.hessian(u, &mut hessian);
        if n == 0 || !agrees(problem, u, &hessian) {
            return None;
        }
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        let places = own.iter().zip(&hessian);
        entries.extend(places.map(|((i, j), value)| (i, j, *value)));
        let mut curvature = |row: usize, column: usize, value: f64| {
            for (i, a) in problem.dofs().slopes(row) {
                for (j, b) in problem.dofs().slopes(column) {
                    entries.push(symmetric(i, j, -a * b * value));
                }
            }
        };
        // D + Dᵀ by blocks of two nodes, of which the second is not the larger
        let mut blocks: BTreeMap<[usize; 2], Matrix<D>> = BTreeMap::new();
        for own in measured {
            let pushes = own.pass.pushes(&own.lambda);
            let loaded = own.pass.loaded(&pushes, x);
            own.pass.slopes_of_forces(&loaded, |nodes, slopes| {
                for (b, &second) in nodes.iter().enumerate() {
                    for (a, &first) in nodes.iter().enumerate().skip(b) {
                        let [lower, upper] =
                            [(a, b), (b, a)].map(|(a, b)| slopes.fixed_view::<D, D>(D * a, D * b));
                        let both: Matrix<D> = lower + upper.transpose();
                        if both.iter().any(|value| *value != 0.0) {
                            *blocks.entry([first, second]).or_insert_with(Matrix::zeros) += both;
                        }
                    }
                }
            });
        }
        for ([a, b], slopes) in &blocks {
            for i in 0..D {
                for j in 0..D {
                    let (row, column) = (D * a + i, D * b + j);
                    if row >= column {
                        let share = if row == column { 0.5 } else { 1.0 };
                        curvature(row, column, share * slopes[(i, j)]);
                    }
                }
            }
        }
        slopes_on_obstacles(problem, x, (gaps, lambda), &mut curvature);
        let mut stiffest = vec![0.0_f64; n];
        for &(i, _, value) in entries.iter().filter(|(i, j, _)| i == j) {
            stiffest[i] += value.abs();
        }
        let mut hold = |row: &[(usize, f64)]| {
            let square: f64 = row.iter().map(|(_, c)| c * c).sum();
            let stiff = row.iter().map(|(i, _)| stiffest[*i]).fold(0.0, f64::max);
            if !(square > 0.0) {
                return;
            }
            for (k, (i, a)) in row.iter().enumerate() {
                let each = row[..=k].iter();
                let product =
                    |(j, b): &(usize, f64)| (*i.max(j), *i.min(j), HOLDS * stiff / square * a * b);
                entries.extend(each.map(product));
            }
        };
        for (i, _) in lambda.iter().enumerate().filter(|(_, l)| **l > 0.0) {
            hold(&gaps.matrix().row(i).collect::<Vec<_>>());
        }
        if let Some(reduction) = problem.reduction() {
            let map = &reduction.map;
            for &dependent in map.dependents() {
                let mut unit = vec![0.0; n];
                unit[dependent] = 1.0;
                let mut row = map.spread(&map.transposed(&unit));
                row[dependent] -= 1.0;
                let row = row.into_iter().enumerate().filter(|(_, c)| *c != 0.0);
                hold(&row.collect::<Vec<_>>());
            }
        }
        let places: Vec<_> = entries.iter().map(|&(i, j, _)| (i, j)).collect();
        let (pattern, slots) = SymmetricPattern::from_entries(n, &places).ok()?;
        let mut held = vec![0.0; pattern.len()];
        for (slot, entry) in slots.iter().zip(&entries) {
            held[*slot] += entry.2;
        }
        let symbolic = SymbolicLlt::try_new(columns(&pattern), Side::Lower).ok()?;
        let unit = units(problem, u, noticed);
        let is_known = held.iter().chain(&unit).all(|value| value.is_finite())
            && unit.iter().all(|unit| *unit > 0.0);
        is_known.then_some(Tangent {
            pattern,
            held,
            unit,
            symbolic,
        })
    }

    /// The factor of the matrix with rows that hold and `shift` units more; `None` where it is not positive definite.
    fn factor(&self, shift: f64) -> Option<Llt<usize, f64>> {
        let mut values = self.held.clone();
        for (j, unit) in self.unit.iter().enumerate() {
            let diagonal = self.pattern.slot(j, j)?;
            values[diagonal] += shift * unit + ROUND_OFF * self.held[diagonal].abs();
        }
        let matrix = SparseColMatRef::new(columns(&self.pattern), &values[..]);
        Llt::try_new_with_symbolic(self.symbolic.clone(), matrix, Side::Lower).ok()
    }

    /// The `count` softest motions, each with the share that it releases, by inverse iteration with a factor of the shifted matrix.
    fn softest(&self, factor: &Llt<usize, f64>, count: usize) -> Vec<(f64, Vec<f64>)> {
        let n = self.unit.len();
        // scaled by the square root of the unit, motions have the length 1
        let root = DVector::from_iterator(n, self.unit.iter().map(|unit| unit.sqrt()));
        let mut scaled = DMatrix::from_fn(n, count, |i, k| noise(i + n * k));
        let mut shares = DVector::zeros(count);
        for _ in 0..ROUNDS {
            for mut motion in scaled.column_iter_mut() {
                motion.component_mul_assign(&root);
                let b = MatMut::from_column_major_slice_mut(motion.as_mut_slice(), n, 1);
                factor.solve_in_place(b);
                motion.component_mul_assign(&root);
            }
            scaled = scaled.qr().q();
            let mut products = scaled.clone();
            for mut product in products.column_iter_mut() {
                product.component_div_assign(&root);
                let v: Vec<f64> = product.iter().copied().collect();
                self.pattern.product(&self.held, &v, product.as_mut_slice());
                product.component_div_assign(&root);
            }
            let small = scaled.transpose() * products;
            let eigen = ((&small + small.transpose()) * 0.5).symmetric_eigen();
            scaled *= eigen.eigenvectors;
            shares = eigen.eigenvalues;
        }
        let motion =
            |y: DVectorView<'_, f64>| y.iter().zip(&root).map(|(y, root)| y / root).collect();
        let motions = scaled.column_iter().zip(&shares);
        motions.map(|(y, share)| (-share, motion(y))).collect()
    }
}

/// How far a motion of the free unknowns is from translations and rotations of bodies: the largest share of a body that takes part.
fn deformation<const D: usize>(problem: &Problem<D>, x: &[Vector<D>], v: &[f64]) -> f64 {
    let rate = |dof: usize| {
        problem
            .dofs()
            .slopes(dof)
            .map(|(k, a)| a * v[k])
            .sum::<f64>()
    };
    let planes = (0..D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let planes: Vec<(usize, usize)> = planes.collect();
    let bodies = 0..problem.scene().bodies().len();
    let of_body = |body: usize| {
        let nodes = problem.nodes(body);
        let count = nodes.len();
        let centre = x[nodes.clone()].iter().sum::<Vector<D>>() / count as f64;
        let moved = DVector::from_fn(D * count, |k, _| rate(D * nodes.start + k));
        // one column for each direction and for each plane of rotation
        let rigid = DMatrix::from_fn(D * count, D + planes.len(), |k, column| {
            let (arm, component) = (x[nodes.start + k / D] - centre, k % D);
            match column.checked_sub(D).map(|plane| planes[plane]) {
                None => f64::from(u8::from(component == column)),
                Some((i, j)) if component == i => arm[j],
                Some((i, j)) if component == j => -arm[i],
                Some(_) => 0.0,
            }
        });
        let rigid = rigid.qr().q().tr_mul(&moved).norm_squared();
        let whole = moved.norm_squared();
        ((whole - rigid).max(0.0) / whole, whole / count as f64)
    };
    let found: Vec<(f64, f64)> = bodies.map(of_body).collect();
    let most = found.iter().map(|(_, moved)| *moved).fold(0.0, f64::max);
    let part = found
        .iter()
        .filter(|(_, moved)| *moved > TAKES_PART * TAKES_PART * most);
    part.map(|(share, _)| share.sqrt()).fold(0.0, f64::max)
}

fn columns(pattern: &SymmetricPattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.dim();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows())
}

/// An entry of the symmetric part of a matrix, on or below the diagonal, of an entry of the matrix.
fn symmetric(i: usize, j: usize, value: f64) -> (usize, usize, f64) {
    let share = if i == j { 1.0 } else { 0.5 };
    (i.max(j), i.min(j), share * value)
}

/// Numbers between −1 and 1 without a pattern.
fn noise(k: usize) -> f64 {
    (1.0 + 2.4 * k as f64 + 0.7 * (k as f64).powi(2)).sin()
}

/// The force on each body over its extent and its number of nodes, for each free unknown.
fn units<const D: usize>(problem: &Problem<D>, u: &[f64], noticed: f64) -> Vec<f64> {
    let residuals = problem.residuals(u);
    let mut units = vec![0.0; u.len()];
    for (body, owner) in problem.scene().bodies().iter().enumerate() {
        let (low, high) = owner.mesh().bounding_box();
        let extent = (high - low).max();
        let nodes = problem.nodes(body);
        let forces = residuals[body].chunks_exact(D);
        let norms = forces.map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt());
        let force = norms.sum::<f64>().max(noticed);
        let unit = force / (extent * nodes.len() as f64);
        for node in nodes {
            for i in 0..D {
                if let Dof::Free(k) = problem.dofs().get(D * node + i) {
                    units[k] = unit;
                }
            }
        }
    }
    units
}

/// The slopes of forces on obstacles, λ ∇²d of the signed distance d at the node of each row. What is more than its facets resolve is a kink,
/// and is left out.
fn slopes_on_obstacles<const D: usize>(
    problem: &Problem<D>,
    x: &[Vector<D>],
    (gaps, lambda): (&LinearGaps, &[f64]),
    add: &mut impl FnMut(usize, usize, f64),
) {
    let obstacles = problem.scene().obstacles();
    for (key, lambda) in gaps.keys().iter().zip(lambda).filter(|(_, l)| **l > 0.0) {
        let pass = problem.passes()[key.pass as usize];
        let node = key.node as usize;
        let Some(obstacle) = problem.obstacle_of(pass).and_then(|k| obstacles.get(k)) else {
            continue;
        };
        let Some(x) = x.get(node) else { continue };
        let size = problem.surfaces()[pass.slave].facet_size();
        let pose = obstacle.pose(problem.load());
        let distance = |a: Vector<D>| obstacle.distance(&pose.back(&(x + a)));
        let step = DISTANCE * size;
        for i in 0..D {
            for j in 0..D {
                let [a, b] = [i, j].map(|k| unit_vector::<D>(k) * step);
                let sum = distance(a + b) - distance(a - b) - distance(b - a) + distance(-a - b);
                let slope = sum / (4.0 * step * step);
                if slope.abs() * size < 1.0 {
                    add(D * node + i, D * node + j, lambda * slope);
                }
            }
        }
    }
}

/// Whether the Hessian's product with a random motion is the difference of gradients.
fn agrees<const D: usize>(problem: &Problem<D>, u: &[f64], hessian: &[f64]) -> bool {
    let energy = problem.energy();
    let heights =
        (0..problem.scene().bodies().len()).map(|body| problem.height_and_volume(body)[0]);
    let step = STEP * heights.fold(f64::INFINITY, f64::min);
    let n = u.len();
    let v: Vec<f64> = (0..n).map(noise).collect();
    let mut product = vec![0.0; n];
    energy.hessian_pattern().product(hessian, &v, &mut product);
    let [on, back] = [step, -step].map(|step| {
        let moved: Vec<f64> = u.iter().zip(&v).map(|(u, v)| u + step * v).collect();
        let mut gradient = vec![0.0; n];
        energy.gradient(&moved, &mut gradient);
        gradient
    });
    let (mut apart, mut size) = (0.0, 0.0);
    for ((on, back), product) in on.iter().zip(&back).zip(&product) {
        let slope = (on - back) / (2.0 * step);
        apart += (slope - product) * (slope - product);
        size += slope * slope;
    }
    apart <= SLOPE * SLOPE * size
}
