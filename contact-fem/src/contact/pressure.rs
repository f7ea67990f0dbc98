//! The contact pressure, recovered from nodal contact forces; `docs/pressure.md` derives and compares it.

use contact_core::linear::{
    Analysis, Cholesky, Factor, FactorError, Kind, Ordering, SymmetricPattern,
};
use nalgebra::{SMatrix, SVector};
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::surface::Surface;
use crate::element::{FacetRule, facet_edge, facet_shapes};
use crate::error::Error;
use crate::jacobi::orthogonal_columns;
use crate::tensor::Vector;

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
    /// The gaps to the nearest other surface, taken as a smooth one (UL), positive = open; `None` where there is none in reach.
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
    /// The pressure at the nodes (UF/UL or UF/UL², of the area where contact is searched). It is nowhere negative there, zero at
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
        let trial: Vec<f64> = (0..means.len()).map(at_node).collect();
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

/// The nodal tractions t (reference area, UF/UL or UF/UL²) of a surface, in the order of its nodes,
/// from the nodal contact forces f = Cᵀλ at those nodes: Σ_j ∫ φ_i φ_j ds t_j = Σ_a φ_i(X_a) f_a
/// with the test functions φ of the constraints, which are in the span of the shape functions.
///
/// If both passes constrain the same contact, the multipliers are not unique; the forces are.
///
/// # Errors
/// If the surface mass matrix cannot be factorised, which requires a facet without measure.
pub fn tractions<const D: usize>(
    surface: &Surface<D>,
    forces: &[Vector<D>],
) -> Result<Vec<Vector<D>>, Error> {
    // nodes without a test function are in the middle of edges, which `ends` stores
    let (tests, ends) = test_nodes(surface);
    let n = tests.iter().flatten().count();
    let numbers = |facet: &[usize]| -> Vec<usize> {
        let facet = facet[..surface.test_nodes()].iter();
        facet.filter_map(|&a| tests[a]).collect()
    };
    let rule = FacetRule::<D>::gauss(3);
    let mut mass = Vec::new();
    for (f, facet) in surface.facets().enumerate() {
        let numbers = numbers(facet);
        for (w, lambda) in rule.points() {
            let w = w * surface.measure(f, lambda);
            let phi = surface.test_functions(lambda);
            for (k, &row) in numbers.iter().enumerate() {
                for (l, &col) in numbers[..=k].iter().enumerate() {
                    mass.push((row, col, w * phi[k] * phi[l]));
                }
            }
        }
    }
    let singular = |_| Error::Setting {
        name: "surface mass",
        value: 0.0,
        remedy: "remove the contact surface's facets of zero measure",
    };
    let mut t = vec![0.0; D * n]; // component by component
    for (a, force) in forces.iter().enumerate() {
        for (row, share) in shares(&tests, &ends, a) {
            (0..D).for_each(|i| t[n * i + row] += share * force[i]);
        }
    }
    solve_mass(n, &mass, &mut t).map_err(singular)?;
    let at_node = |a: usize| {
        let mut traction = Vector::zeros();
        for (row, share) in shares(&tests, &ends, a) {
            (0..D).for_each(|i| traction[i] += share * t[n * i + row]);
        }
        traction
    };
    Ok((0..forces.len()).map(at_node).collect())
}

/// Solves with the matrix of these entries for right-hand sides stored one after the other.
fn solve_mass(n: usize, mass: &[(usize, usize, f64)], b: &mut [f64]) -> Result<(), FactorError> {
    let (pattern, mass) = SymmetricPattern::from_sums(n, mass).expect("numbered so");
    let mut factor = Cholesky::new(&Analysis::new(&pattern, &Ordering::Automatic)?, Kind::Llt)?;
    factor.refactor(&mass)?;
    factor.solve(b)
}

/// For each node the number of its test function, if it has one; for the others the nodes at the
/// ends of their edge.
fn test_nodes<const D: usize>(surface: &Surface<D>) -> (Vec<Option<usize>>, Vec<[usize; 2]>) {
    let mut has_test = vec![false; surface.nodes().len()];
    let mut ends = vec![[0; 2]; surface.nodes().len()];
    for facet in surface.facets() {
        let (with, without) = facet.split_at(surface.test_nodes());
        with.iter().for_each(|&a| has_test[a] = true);
        for (e, &a) in without.iter().enumerate() {
            ends[a] = facet_edge::<D>(e).map(|corner| facet[corner]);
        }
    }
    let mut count = 0..;
    let number = |has: bool| if has { count.next() } else { None };
    (has_test.into_iter().map(number).collect(), ends)
}

/// The non-zero test functions at node `a`, with their values there.
fn shares(
    tests: &[Option<usize>],
    ends: &[[usize; 2]],
    a: usize,
) -> impl Iterator<Item = (usize, f64)> {
    let corners = match tests[a] {
        Some(own) => [Some((own, 1.0)), None],
        None => ends[a].map(|end| tests[end].map(|number| (number, 0.5))),
    };
    corners.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// What nodal forces give without gaps, all in passes of the surface.
    fn recovered(surface: &Surface<2>, forces: &[Vector<2>], gaps: &[Option<f64>]) -> Vec<f64> {
        let pressed = Pressed {
            surface,
            x: surface.reference_nodes(),
            normals: surface.reference_normals(),
            forces,
            own: forces,
            gaps,
            facing: &[],
            moduli: &vec![1.0; gaps.len()],
        };
        pressed.pressures()
    }

    /// A surface with nodes at distances 1 whose every other node carries the force of two, on one with nodes at distances 2.
    #[test]
    fn what_the_other_surface_cannot_resolve_is_averaged() {
        let x: Vec<Vector<2>> = (0..=12)
            .map(|k| Vector::<2>::new(f64::from(k), 0.0))
            .collect();
        let surface = polyline(&x);
        let force = |a: usize| if a % 2 == 0 { 2.0 } else { 1e-3 };
        let inside = |a: usize| (3..=9).contains(&a);
        let forces = |a: usize| Vector::<2>::new(0.0, if inside(a) { force(a) } else { 0.0 });
        let forces: Vec<Vector<2>> = (0..x.len()).map(forces).collect();
        let at = |spacing: f64| {
            let facing: Vec<_> = (1..7)
                .map(|k| (Vector::<2>::new(2.0 * f64::from(k), 0.0), spacing))
                .collect();
            let pressed = Pressed {
                surface: &surface,
                x: &x,
                normals: surface.reference_normals(),
                forces: &forces,
                own: &forces,
                gaps: &vec![None; x.len()],
                facing: &facing,
                moduli: &vec![1.0; x.len()],
            };
            pressed.pressures()
        };
        let own = at(1.0);
        assert!(own[6] > 1.9 && own[7] < 0.1, "{own:?}");
        let wider = at(2.0);
        // by hand: a half of the node and a quarter of each of its neighbours
        let middle = wider[6];
        assert!((middle - 1.0005).abs() < 0.05, "{wider:?}");
        assert!(
            (4..9).all(|a| (wider[a] - middle).abs() < 1e-2),
            "{wider:?}"
        );
        assert!(
            (wider.iter().sum::<f64>() - forces.iter().map(|f| f[1]).sum::<f64>()).abs() < 1e-9
        );
        assert_eq!(wider[2], 0.0);
    }

    fn polyline(x: &[Vector<2>]) -> Surface<2> {
        let facets: Vec<[usize; 2]> = (1..x.len()).map(|k| [k - 1, k]).collect();
        Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), x)
    }

    /// Half of the normal times the length of each segment goes to either end.
    #[test]
    fn a_constant_pressure_on_a_polygon_is_exact() {
        let x = [0.0, 0.2, 0.5, 0.6, 1.0].map(|t: f64| Vector::<2>::new(t.cos(), t.sin()));
        let surface = polyline(&x);
        let mut forces = [Vector::<2>::zeros(); 5];
        for (facet, reference) in surface.facets().zip(surface.reference()) {
            let half = reference.normal(&Vector::<2>::repeat(0.5)) * 0.5;
            facet.iter().for_each(|&a| forces[a] -= half * 3.0);
        }
        for gap in [None, Some(0.0)] {
            for p in recovered(&surface, &forces, &[gap; 5]) {
                assert!((p - 3.0).abs() < 1e-12, "{p}");
            }
        }
        let none = recovered(&surface, &[Vector::zeros(); 5], &[None; 5]);
        assert_eq!(none, [0.0; 5]);
    }

    /// The force of one node is no number: its pressure is none, too, and those of others are what they are.
    #[test]
    fn a_force_that_is_no_number() {
        let x: Vec<Vector<2>> = (0..=6)
            .map(|k| Vector::<2>::new(f64::from(k), 0.0))
            .collect();
        let surface = polyline(&x);
        let force = |k: usize| match k {
            1 => f64::NAN,
            3..=5 => 2.0,
            _ => 0.0,
        };
        let forces: Vec<_> = (0..7).map(|k| Vector::<2>::new(0.0, force(k))).collect();
        let p = recovered(&surface, &forces, &[None; 7]);
        let expected = [0.0, f64::NAN, 0.0, 2.0, 2.0, 2.0, 0.0];
        for (p, expected) in p.iter().zip(expected) {
            assert!((p - expected).abs() < 1e-12 || p.is_nan() && expected.is_nan());
        }
    }

    /// A constant pressure over a part of a fine surface: facets of the other one that are four times as large leave it what it is.
    #[test]
    fn a_constant_pressure_on_a_part_stays_constant() {
        let x: Vec<Vector<2>> = (0..=20)
            .map(|k| Vector::<2>::new(f64::from(k), 0.0))
            .collect();
        let surface = polyline(&x);
        let inside = |a: usize| (5..=15).contains(&a);
        let forces: Vec<_> = (0..x.len())
            .map(|a| Vector::<2>::new(0.0, if inside(a) { 3.0 } else { 0.0 }))
            .collect();
        let facing: Vec<_> = (0..=5)
            .map(|k| (Vector::<2>::new(4.0 * f64::from(k), 0.0), 4.0))
            .collect();
        let pressed = Pressed {
            surface: &surface,
            x: &x,
            normals: surface.reference_normals(),
            forces: &forces,
            own: &forces,
            gaps: &vec![None; x.len()],
            facing: &facing,
            moduli: &vec![1.0; x.len()],
        };
        for (a, p) in pressed.pressures().iter().enumerate() {
            let expected = if inside(a) { 3.0 } else { 0.0 };
            assert!((p - expected).abs() < 1e-12, "{p} at {a}");
        }
    }

    /// Forces that are not along a curved surface's normals, without a moment about its centre: the field has their resultant.
    #[test]
    fn a_curved_surface_bears_whole_forces() {
        let angle = |k: usize| -0.6 + 0.1 * k as f64;
        let x: Vec<Vector<2>> = (0..=12)
            .map(|k| Vector::<2>::new(angle(k).sin(), -angle(k).cos()))
            .collect();
        let surface = polyline(&x);
        let forces: Vec<_> = (0..=12)
            .map(|k| Vector::<2>::new(0.0, 1.0 + 0.1 * k.min(12 - k) as f64))
            .collect();
        let p = recovered(&surface, &forces, &[None; 13]);
        let mut resultant = Vector::<2>::zeros();
        for (facet, reference) in surface.facets().zip(surface.reference()) {
            let n = reference.normal(&Vector::<2>::repeat(0.5));
            resultant -= n * (0.5 * (p[facet[0]] + p[facet[1]]));
        }
        let wanted: Vector<2> = forces.iter().sum();
        assert!((resultant - wanted).norm() < 1e-9, "{resultant} {wanted}");
    }

    /// A ring under an alternating pressure of mean 1.25: some of it is taken away by gaps, and given back as a whole.
    #[test]
    fn a_closed_surface_keeps_the_sum_of_its_forces() {
        let x: Vec<Vector<2>> = (0..16)
            .map(|k| f64::from(k) * std::f64::consts::PI / 8.0)
            .map(|t| Vector::<2>::new(t.cos(), t.sin()))
            .collect();
        let facets: Vec<[usize; 2]> = (0..16).map(|k| [k, (k + 1) % 16]).collect();
        let surface = Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), &x);
        let push = |a: usize| if a % 2 == 0 { 1.0 } else { 1.5 };
        let normals = surface.reference_normals();
        let forces: Vec<_> = (0..16).map(|a| normals[a] * -push(a)).collect();
        let gaps: Vec<_> = (0..16)
            .map(|a| Some(if a % 2 == 0 { 0.4 } else { -0.4 }))
            .collect();
        let p = recovered(&surface, &forces, &gaps);
        assert!(p[0] < 0.9 * p[1], "{p:?}");
        // half of the normals times the lengths of the segments beside each node, along its own
        let area = 2.0 * (std::f64::consts::PI / 16.0).sin() * (std::f64::consts::PI / 16.0).cos();
        let sum: f64 = p.iter().map(|p| p * area).sum();
        assert!((sum - 16.0 * 1.25).abs() < 1e-9, "{sum}");
    }

    /// Linear multipliers on quadratic triangles: corners and middles of edges without a force have no pressure.
    #[test]
    fn quadratic_triangles_are_open_where_nothing_presses() {
        let n = 8;
        let at = |i: usize, j: usize| i * (2 * n + 1) + j;
        let x: Vec<Vector<3>> = (0..=2 * n)
            .flat_map(|i| (0..=2 * n).map(move |j| Vector::<3>::new(i as f64, j as f64, 0.0)))
            .collect();
        let mut facets = Vec::new();
        for i in (0..2 * n).step_by(2) {
            for j in (0..2 * n).step_by(2) {
                let corners = |k: [[usize; 2]; 3]| k.map(|[a, b]| [i + 2 * a, j + 2 * b]);
                for [a, b, c] in [
                    corners([[0, 0], [1, 0], [1, 1]]),
                    corners([[0, 0], [1, 1], [0, 1]]),
                ] {
                    let middle =
                        |p: [usize; 2], q: [usize; 2]| at((p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
                    let [p, q, r] = [a, b, c].map(|[i, j]| at(i, j));
                    facets.push([p, q, r, middle(a, b), middle(b, c), middle(c, a)]);
                }
            }
        }
        let surface = Surface::new(0, Order::Quadratic, facets.iter().map(|f| &f[..]), &x);
        // a multiplier of 1 at corners within 5 of the middle
        let centre = Vector::<3>::new(n as f64, n as f64, 0.0);
        let lambda = |a: usize| {
            if (x[a] - centre).norm() < 5.0 {
                1.0
            } else {
                0.0
            }
        };
        let mut forces = vec![Vector::<3>::zeros(); x.len()];
        for facet in &facets {
            for (w, l) in FacetRule::<3>::gauss(4).points() {
                let p: f64 = (0..3).map(|k| lambda(facet[k]) * l[k]).sum();
                let shapes = facet_shapes(Order::Quadratic, l);
                for (&a, N) in facet.iter().zip(shapes) {
                    forces[a][2] += 2.0 * w * p * N;
                }
            }
        }
        let normals: Vec<_> = vec![Vector::<3>::new(0.0, 0.0, -1.0); x.len()];
        let facing = [(centre, 4.0)];
        for facing in [&facing[..0], &facing[..]] {
            let pressed = Pressed {
                surface: &surface,
                x: &x,
                normals: &normals,
                forces: &forces,
                own: &forces,
                gaps: &vec![None; x.len()],
                facing,
                moduli: &vec![1.0; x.len()],
            };
            for (a, p) in pressed.pressures().iter().enumerate() {
                let is_corner = (x[a][0] as usize % 2, x[a][1] as usize % 2) == (0, 0);
                // the multiplier of a corner reaches to the next ones
                let is_open =
                    is_corner && lambda(a) == 0.0 || forces[a].norm() < 1e-12 && !is_corner;
                assert!(!is_open || *p == 0.0, "{p} at {:?}", x[a]);
            }
        }
    }

    /// Forces whose sums overflow end the search for balance.
    #[test]
    fn forces_beyond_all_bounds() {
        let x = [0.0, 1.0, 2.0].map(|x| Vector::<2>::new(x, 0.0));
        let forces = [Vector::<2>::new(0.0, 1e308); 3];
        assert_eq!(recovered(&polyline(&x), &forces, &[None; 3]).len(), 3);
    }

    /// Forces of which one pulls: the field does not, and has their resultant and moment, by hand for segments of length 1.
    #[test]
    fn the_field_does_not_pull_and_keeps_resultant_and_moment() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|x| Vector::<2>::new(x, 0.0));
        let surface = polyline(&x);
        let n = surface.reference_normals()[0];
        let pushes = [0.5, 1.0, 0.6, 0.4, -0.1, 0.0];
        let forces = pushes.map(|push| n * -push);
        let areas = [0.5, 1.0, 1.0, 1.0, 1.0, 0.5];
        let sums = |of: &dyn Fn(usize) -> f64| -> [f64; 2] {
            [0, 1].map(|power| (0..6).map(|a| of(a) * x[a][0].powi(power)).sum())
        };
        let wanted = sums(&|a| pushes[a]);
        for gap in [0.0, 0.05] {
            // the gap of one node is worth something
            let gaps = [None, Some(gap), None, None, None, None];
            let p = recovered(&surface, &forces, &gaps);
            assert!(p.iter().all(|p| *p >= 0.0) && p[4..] == [0.0; 2], "{p:?}");
            let found = sums(&|a| areas[a] * p[a]);
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
            }
        }
        let at = |gap: f64| {
            recovered(
                &surface,
                &forces,
                &[None, Some(gap), None, None, None, None],
            )[1]
        };
        assert!(at(0.05) < at(0.0) && at(-0.05) > at(0.0));
    }

    /// The force of a node beside the loaded ones grows from nothing: no pressure jumps, though one gap takes much of what presses
    /// and all nodes are moved for it.
    #[test]
    fn pressures_begin_without_a_jump() {
        let x: Vec<Vector<2>> = (0..=8)
            .map(|k| Vector::<2>::new(f64::from(k), 0.0))
            .collect();
        let surface = polyline(&x);
        let mut gaps = vec![Some(0.0); x.len()];
        gaps[3] = Some(2.0);
        let coarse = [(Vector::<2>::new(4.0, 0.0), 3.0)];
        for facing in [&coarse[..0], &coarse[..]] {
            let at = |force: f64| {
                let push = |a: usize| match a {
                    2..=5 => 2.0,
                    6 => force,
                    _ => 0.0,
                };
                let forces: Vec<_> = (0..x.len())
                    .map(|a| Vector::<2>::new(0.0, push(a)))
                    .collect();
                let pressed = Pressed {
                    surface: &surface,
                    x: &x,
                    normals: surface.reference_normals(),
                    forces: &forces,
                    own: &forces,
                    gaps: &gaps,
                    facing,
                    moduli: &vec![1.0; x.len()],
                };
                pressed.pressures()
            };
            let apart = |a: &[f64], b: &[f64]| {
                let pairs = a.iter().zip(b).map(|(a, b)| (a - b).abs());
                pairs.fold(0.0, f64::max)
            };
            let none = at(0.0);
            assert!((none[3] - 2.0).abs() > 0.05, "{none:?}");
            for force in [-1e-9, 1e-15, 1e-12, 1e-9] {
                let off = apart(&at(force), &none);
                assert!(off < 1e-5, "{off} under {force}");
            }
            for step in 0..1000 {
                let [force, next] = [step, step + 1].map(|k| 1e-6 * f64::from(k));
                let off = apart(&at(force), &at(next));
                assert!(off < 1e-2, "{off} from {force}");
            }
        }
    }

    /// The recovery returns a linear traction from its nodal forces on facets of unequal length.
    #[test]
    fn recovers_linear_tractions() {
        let x = [0.0, 0.3, 1.0, 1.2, 2.0].map(|x| Vector::<2>::new(x, 0.0));
        let facets: Vec<[usize; 2]> = (0..4).map(|k| [k, k + 1]).collect();
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Linear, facets, &x);
        let traction = |s: f64| Vector::<2>::new(0.2 - s, 3.0 + 2.0 * s);
        let mut forces = vec![Vector::<2>::zeros(); 5];
        for k in 0..4 {
            let (a, b) = (x[k][0], x[k + 1][0]);
            // ∫ N t over a segment of length h: h/6 (2 t_a + t_b), h/6 (t_a + 2 t_b)
            forces[k] += (2.0 * traction(a) + traction(b)) * ((b - a) / 6.0);
            forces[k + 1] += (traction(a) + 2.0 * traction(b)) * ((b - a) / 6.0);
        }
        for (t, x) in tractions(&surface, &forces)
            .expect("regular")
            .iter()
            .zip(&x)
        {
            assert!((t - traction(x[0])).norm() < 1e-13);
        }
    }

    /// A linear traction on one quadratic triangle, from its consistent nodal forces. The corner
    /// shape functions of a quadratic triangle have mean zero.
    #[test]
    fn quadratic_triangles_use_the_functions_of_the_corners() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::<3>::from);
        let middle = |a: usize, b: usize| (corners[a] + corners[b]) * 0.5;
        let mut x = corners.to_vec();
        x.extend([middle(0, 1), middle(1, 2), middle(2, 0)]);
        let facets = [[0, 1, 2, 3, 4, 5]];
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Quadratic, facets, &x);
        let traction = |X: &Vector<3>| Vector::<3>::new(0.0, 1.0 + X[0], 5.0 - X[0] + 2.0 * X[1]);
        let mut forces = vec![Vector::<3>::zeros(); 6];
        for (w, lambda) in FacetRule::<3>::gauss(4).points() {
            let X = surface.reference()[0].point(lambda);
            let N = crate::element::facet_shapes(Order::Quadratic, lambda);
            for (f, N) in forces.iter_mut().zip(N) {
                *f += traction(&X) * (w * N); // the triangle's area is 1
            }
        }
        for (t, X) in tractions(&surface, &forces)
            .expect("regular")
            .iter()
            .zip(&x)
        {
            assert!((t - traction(X)).norm() < 1e-13);
        }
    }
}
