//! The contact pressure, recovered from nodal contact forces; `docs/pressure.md` derives and compares it.

mod consistent;
mod offsets;

use nalgebra::{SMatrix, SVector};
use rstar::RTree;
use rstar::primitives::GeomWithData;

use self::consistent::{shares, test_nodes};
use super::surface::Surface;
use crate::element::{FacetRule, facet_shapes};
use crate::jacobi::orthogonal_columns;
use crate::tensor::Vector;

pub use self::consistent::tractions;
pub use self::offsets::row_offsets;

/// What the recovery takes of one surface of a pair, or of several pairs whose contact zones meet on it. Slices have one entry for each
/// of the surface's nodes, but for `facing`.
#[derive(Clone, Copy, Debug)]
pub struct Pressed<'a, const D: usize> {
    /// The surface.
    pub surface: &'a Surface<D>,
    /// Where contact is searched (UL).
    pub x: &'a [Vector<D>],
    /// Its averaged normals there.
    pub normals: &'a [Vector<D>],
    /// The contact forces (UF).
    pub forces: &'a [Vector<D>],
    /// Those of the passes in which the surface is the slave (UF).
    pub own: &'a [Vector<D>],
    /// The gaps to the nearest other surface (UL), positive = open, beyond what they are where both surfaces touch all along; `None` where
    /// there is none in reach.
    pub gaps: &'a [Option<f64>],
    /// The nodes of the other surface, with the distance between nodes there (UL); empty where that surface does not deform.
    pub facing: &'a [(Vector<D>, f64)],
    /// At each node E* of the two bodies (UF/UL²): 1/E* = Σ (1 − ν²)/E over those that are not rigid. It is infinite, and gaps
    /// do not matter, if both are.
    pub moduli: &'a [f64],
}

/// r h/E*: what a node's gap weighs against the mean pressure around it, as a share of the stiffness of a half-space to a
/// pressure that changes from node to node.
const GAP_WEIGHT: f64 = 0.7;
/// The largest share of a mean pressure that a gap adds.
const LARGEST_ADDITION: f64 = 0.25;
/// α: the part of what a mean of the means would take away that is given back where quadratic facets have linear test functions.
const SHARPENING: f64 = 0.5;
/// The mean pressure from which a node is loaded in full, as a share of the largest one. Below it a node counts in proportion, so that
/// no pressure jumps where a force begins.
const LOADED: f64 = 4e-4;
/// Rigid motions that move the loaded nodes along their normals by less than this share of what others do leave no trace in the
/// pressure.
const TANGENTIAL: f64 = 1e-2;
/// Below this share of the sum of all forces their resultant balances nothing and has no direction.
pub(crate) const BALANCED: f64 = 1e-3;
/// Below this share the normal components of forces on a surface of revolution have hardly any resultant along the axis.
const STEEP: f64 = 0.1;
/// What forces have more than their components along the normals is borne along each motion up to this share of those.
const OBLIQUE: f64 = 0.25;
/// Iterations for the resultants; most take one or two.
const ITERATIONS: usize = 60;
/// Translations and rotations, as many as there are in D dimensions; the rest is zero.
type Motion = SVector<f64, 6>;
type Motions = SMatrix<f64, 6, 6>;

impl<const D: usize> Pressed<'_, D> {
    /// The pressure at the nodes (UF/UL², of the area where contact is searched). It is nowhere negative there, zero at
    /// nodes without a contact force, and grows from zero where a force begins. If the forces are those of a constant pressure on a
    /// smooth surface and the surfaces touch, it is that one. Its
    /// own nodal forces, p_a ∫ N_a n ds, have the resultant and the moment of the forces' components along the normals, and of what
    /// forces have beside these up to a quarter more along each motion: a shallow cap bears nothing in its plane, and an arc no
    /// moment about its centre. Half of a cylinder of which a strip of a/R = 0.12 presses along the normals of a flat block has 0.28 %
    /// less than the resultant for that. Where the forces cancel, as around a pin, the sum of their normal components is kept. The resultant
    /// is also that of the field interpolated by the facets' shape functions N. A node whose force or gap is no number has a
    /// pressure that is none.
    ///
    /// p = max(0, p̄ − r g + m): p̄ is the mean of the pressure with each test function, r g what the gap of the node is worth, and m
    /// the normal component of one rigid motion of the whole surface, chosen for resultant and moment; it adds at most p̄.
    pub fn pressures(&self) -> Vec<f64> {
        let weights = Weights::new(self);
        let (means, loads) = weights.means(self, self.forces);
        let (own, _) = weights.means(self, self.own);
        let sizes = self.surface.node_sizes();
        let degree = self.surface.order().degree() as f64;
        let at_node = |a: usize| {
            let mean = means[a];
            if mean == 0.0 || !mean.is_finite() {
                return mean;
            }
            let gap = self.gaps[a].filter(|_| self.moduli[a].is_finite());
            let share = (own[a] / mean).clamp(0.0, 1.0);
            let stiffness = GAP_WEIGHT * self.moduli[a] * degree / sizes[a];
            let worth = gap.map_or(0.0, |gap| share * stiffness * gap);
            let size = mean.abs();
            mean - worth.clamp(-LARGEST_ADDITION * size, size)
        };
        let mut trial: Vec<f64> = (0..means.len()).map(at_node).collect();
        // where gaps would take all pressure of a surface, its forces alone count
        if !trial.iter().any(|p| *p > 0.0) {
            trial.clone_from(&means);
        }
        let trial = self.resolved(trial, &loads);
        weights.balanced(self, &trial, &means)
    }

    /// The mean of `trial` over the nodes around, as far as they are loaded, with a hat function as wide as those of the other
    /// surface at the nearest of its nodes: what changes faster is how a fine surface meets the facets of a coarser one.
    /// Where nodes of the other surface are closer together than the own ones, nothing changes; neither does a constant, or a node
    /// without a load.
    fn resolved(&self, trial: Vec<f64>, loads: &[f64]) -> Vec<f64> {
        let facing = self.facing.iter();
        let facing = facing.filter(|(x, _)| x.iter().all(|x| x.is_finite()));
        let facing: Vec<GeomWithData<[f64; D], f64>> = facing
            .map(|(x, spacing)| GeomWithData::new((*x).into(), *spacing))
            .collect();
        if facing.is_empty() {
            return trial;
        }
        let facing = RTree::bulk_load(facing);
        let neighbours = self.surface.neighbours();
        let areas = self.surface.node_areas(self.x);
        let mut seen_from = vec![usize::MAX; trial.len()];
        let mut within = Vec::new();
        let of_node = |(a, &own): (usize, &f64)| {
            if loads[a] == 0.0 || !own.is_finite() {
                return own;
            }
            let nearest = facing.nearest_neighbor(self.x[a].into());
            let radius = nearest.map_or(0.0, |node| node.data);
            within.clear();
            within.push((a, 1.0));
            seen_from[a] = a;
            let mut next = 0;
            while let Some(&(b, _)) = within.get(next) {
                next += 1;
                for &c in &neighbours[b] {
                    let weight = 1.0 - (self.x[c] - self.x[a]).norm() / radius;
                    if weight > 0.0 && seen_from[c] != a {
                        seen_from[c] = a;
                        within.push((c, weight));
                    }
                }
            }
            let [mut sum, mut size] = [0.0; 2];
            for &(b, weight) in within.iter().filter(|(b, _)| trial[*b].is_finite()) {
                sum += weight * areas[b] * loads[b] * trial[b];
                size += weight * areas[b] * loads[b];
            }
            own + loads[a] * (sum / size - own)
        };
        trial.iter().enumerate().map(of_node).collect()
    }
}

/// Integrals over a surface.
struct Weights<const D: usize> {
    /// ∫ N_a n ds and ∫ N_a² n ds / |∫ N_a² n ds| for each node.
    areas: Vec<Vector<D>>,
    normals: Vec<Vector<D>>,
    /// For each node the number of its test function; for the others the ends of their edge.
    tests: Vec<Option<usize>>,
    ends: Vec<[usize; 2]>,
}

impl<const D: usize> Weights<D> {
    fn new(of: &Pressed<'_, D>) -> Self {
        let surface = of.surface;
        let (tests, ends) = test_nodes(surface);
        let mut areas = vec![Vector::zeros(); of.x.len()];
        let mut normals = areas.clone();
        let rule = FacetRule::<D>::gauss(3);
        for (nodes, facet) in surface.facets().zip(surface.facets_at(of.x)) {
            for (w, lambda) in rule.points() {
                let n = facet.normal(lambda) * (w * surface.ring(&facet, lambda));
                for (&a, N) in nodes.iter().zip(facet_shapes(surface.order(), lambda)) {
                    areas[a] += n * N;
                    normals[a] += n * (N * N);
                }
            }
        }
        // on an axis of revolution what points away from it cancels around
        for a in (0..areas.len()).filter(|a| surface.is_on_axis(*a)) {
            areas[a][0] = 0.0;
            normals[a][0] = 0.0;
        }
        for (n, averaged) in normals.iter_mut().zip(of.normals) {
            let size = n.norm();
            *n = if size > 0.0 { *n / size } else { *averaged };
        }
        Weights {
            areas,
            normals,
            tests,
            ends,
        }
    }

    /// At every node the mean of the pressure with the test functions, from nodal `forces`, and from 0 to 1 how far the node is
    /// loaded: as the means of its test functions are before they are sharpened and, if it has none of its own, as its force is.
    fn means(&self, of: &Pressed<'_, D>, forces: &[Vector<D>]) -> (Vec<f64>, Vec<f64>) {
        let count = self.tests.iter().flatten().count();
        let [mut force, mut area] = [0, 1].map(|_| vec![Vector::<D>::zeros(); count]);
        for (a, (f, A)) in forces.iter().zip(&self.areas).enumerate() {
            for (row, share) in shares(&self.tests, &self.ends, a) {
                force[row] += f * share;
                area[row] += A * share;
            }
        }
        let mut means = vec![0.0; count];
        for (a, test) in self.tests.iter().enumerate() {
            // a fold without a force has no pressure, whatever its area
            if let Some(row) = test.filter(|&row| force[row].norm() != 0.0) {
                let n = &self.normals[a];
                means[row] = -force[row].dot(n) / area[row].dot(n);
            }
        }
        let sizes: Vec<f64> = means.iter().map(|mean| mean.abs()).collect();
        let of_tests = loads(&sizes);
        let of_nodes = loads(&forces.iter().map(Vector::norm).collect::<Vec<_>>());
        let load = |a: usize| {
            let shares = shares(&self.tests, &self.ends, a);
            let load = shares.map(|(row, _)| of_tests[row]).fold(0.0, f64::max);
            match self.tests[a] {
                Some(_) => load,
                None => load.min(of_nodes[a]),
            }
        };
        let loads: Vec<f64> = (0..of.x.len()).map(load).collect();
        let is_sharpened = count < self.tests.len();
        if is_sharpened {
            self.sharpen(of, &mut means);
        }
        let at_node = |a: usize| {
            let shares = shares(&self.tests, &self.ends, a);
            match loads[a] {
                0.0 => 0.0,
                load => {
                    let mean: f64 = shares.map(|(row, share)| share * means[row]).sum();
                    // what is sharpened may press where no force is
                    if is_sharpened { load * mean } else { mean }
                }
            }
        };
        ((0..of.x.len()).map(at_node).collect(), loads)
    }

    /// Takes from the mean at each test function a part of what a further mean would add: p̄ + α (p̄ − M p̄).
    fn sharpen(&self, of: &Pressed<'_, D>, means: &mut [f64]) {
        let surface = of.surface;
        let [mut sums, mut sizes] = [0, 1].map(|_| vec![0.0; means.len()]);
        let rule = FacetRule::<D>::gauss(3);
        for (nodes, facet) in surface.facets().zip(surface.facets_at(of.x)) {
            let rows = nodes[..surface.test_nodes()].iter();
            let rows: Vec<usize> = rows.filter_map(|&a| self.tests[a]).collect();
            for (w, lambda) in rule.points() {
                let w = w * facet.normal(lambda).norm() * surface.ring(&facet, lambda);
                let tests = || rows.iter().zip(surface.test_functions(lambda));
                let finite = tests().filter(|(row, _)| means[**row].is_finite());
                let mean: f64 = finite.map(|(&row, phi)| means[row] * phi).sum();
                for (&row, phi) in tests() {
                    sums[row] += w * phi * mean;
                    sizes[row] += w * phi;
                }
            }
        }
        for (mean, (sum, size)) in means.iter_mut().zip(sums.iter().zip(&sizes)) {
            *mean += SHARPENING * (*mean - sum / size);
        }
    }

    /// max(0, `trial` + m), m being a rigid motion's normal components, with the resultant and the moment of the forces, unless
    /// these are mostly tangential. At no node m adds more than the mean pressure, so that it adds nothing where no force is. The
    /// motion is found by Newton's method.
    fn balanced(&self, of: &Pressed<'_, D>, trial: &[f64], means: &[f64]) -> Vec<f64> {
        let finite = |f: &Vector<D>| match f.iter().all(|f| f.is_finite()) {
            true => *f,
            false => Vector::zeros(),
        };
        let forces: Vec<Vector<D>> = of.forces.iter().map(finite).collect();
        let magnitude: Vec<f64> = forces.iter().map(Vector::norm).collect();
        let total = magnitude.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let weighted = |of_node: &dyn Fn(usize) -> f64| -> f64 {
            let nodes = magnitude.iter().enumerate();
            nodes.map(|(a, f)| f * of_node(a)).sum::<f64>() / total
        };
        let centre = Vector::<D>::from_fn(|i, _| weighted(&|a| of.x[a][i]));
        let radius = weighted(&|a| (of.x[a] - centre).norm_squared()).sqrt();
        let length = radius.max(of.surface.smallest_facet());
        let is_revolved = of.surface.is_of_revolution();
        let motion = |a: usize, v: &Vector<D>| match is_revolved {
            // the one rigid motion is that along the axis
            true => {
                let mut motion = Motion::zeros();
                motion[1] = v[1];
                motion
            }
            false => moment_of(&((of.x[a] - centre) / length), v),
        };
        let nodes = 0..trial.len();
        let along: Vec<Motion> = nodes.clone().map(|a| motion(a, &self.normals[a])).collect();
        let weight: Vec<Motion> = nodes.clone().map(|a| motion(a, &self.areas[a])).collect();
        let whole: Motion = nodes.clone().map(|a| motion(a, &-forces[a])).sum();
        let normal: Motion = nodes
            .map(|a| along[a] * -forces[a].dot(&self.normals[a]))
            .sum();
        let mut shift = Motion::zeros();
        let added = |a: usize, shift: &Motion| along[a].dot(shift).min(means[a].max(0.0));
        let at = |shift: &Motion| -> Vec<f64> {
            let nodes = trial.iter().enumerate();
            let pressure = |(a, trial): (usize, &f64)| match trial.is_finite() {
                true => (trial + added(a, shift)).max(0.0),
                false => f64::NAN,
            };
            nodes.map(pressure).collect()
        };
        for iteration in 0..ITERATIONS {
            let pressures = at(&shift);
            let (mut field, mut slope) = (Motion::zeros(), Motions::zeros());
            for (a, p) in pressures.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                field += weight[a] * *p;
                if added(a, &shift) < means[a] {
                    slope += weight[a] * along[a].transpose();
                }
            }
            // without end on numbers that are not finite
            if !slope.iter().all(|entry| entry.is_finite()) {
                break;
            }
            let (turned, turns) = orthogonal_columns(slope);
            let values = turned.column_iter().map(|column| column.norm());
            let largest = match is_revolved {
                // what the motion would be worth on a surface across the axis
                true => {
                    let pressing = pressures.iter().zip(&self.areas);
                    let pressing = pressing.filter(|(p, _)| **p > 0.0);
                    pressing.map(|(_, area)| area.norm()).sum()
                }
                false => values.clone().fold(0.0, f64::max),
            };
            let mut change = Motion::zeros();
            let mut reachable = Motion::zeros();
            for (k, value) in values.enumerate() {
                if value > TANGENTIAL * largest {
                    let along = |m: &Motion| turned.column(k).dot(m) / value;
                    let most = OBLIQUE * along(&normal).abs();
                    let oblique = along(&(whole - normal)).max(-most).min(most);
                    let component = along(&(normal - field)) + oblique;
                    reachable[k] = component;
                    change += turns.column(k) * (component / value);
                }
            }
            if !(reachable.norm() > 1e-12 * total) {
                break;
            }
            // a cycle of nodes that are loaded in turn is broken by shorter steps
            shift += change * if iteration < ITERATIONS / 3 { 1.0 } else { 0.5 };
        }
        let mut pressures = at(&shift);
        // around a pin or in a fold, forces cancel: what is kept is the sum of their normal components
        let is_steep = is_revolved && normal.norm() < STEEP * total;
        if whole.norm() < BALANCED * total || is_steep {
            let nodes = || self.normals.iter().enumerate();
            let wanted: f64 = nodes().map(|(a, n)| -forces[a].dot(n)).sum();
            let own = nodes().map(|(a, n)| (a, self.areas[a].dot(n)));
            let own = own.filter(|(a, _)| pressures[*a].is_finite());
            let sum: f64 = own.map(|(a, area)| pressures[a] * area).sum();
            let factor = wanted / sum;
            if factor > 0.0 && factor.is_finite() {
                pressures.iter_mut().for_each(|p| *p *= factor);
            }
        }
        pressures
    }
}

/// From none to 1, how far each size is what counts in full.
fn loads(sizes: &[f64]) -> Vec<f64> {
    let finite = sizes.iter().filter(|size| size.is_finite());
    let full = LOADED * finite.fold(0.0, |m: f64, size| m.max(*size));
    let load = |&size: &f64| match size {
        0.0 => 0.0,
        _ => (size / full).min(1.0),
    };
    sizes.iter().map(load).collect()
}

/// v and its moment about the origin at `x`; in the plane the moment has one component.
fn moment_of<const D: usize>(x: &Vector<D>, v: &Vector<D>) -> Motion {
    let mut motion = Motion::zeros();
    (0..D).for_each(|i| motion[i] = v[i]);
    let pairs: &[(usize, usize)] = match D {
        2 => &[(0, 1)],
        _ => &[(0, 1), (1, 2), (2, 0)],
    };
    for (k, &(i, j)) in pairs.iter().enumerate() {
        motion[D + k] = x[i] * v[j] - x[j] * v[i];
    }
    motion
}

#[cfg(test)]
mod tests;
