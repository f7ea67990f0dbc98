//! How gaps and forces of points vary with positions, while feet and normals follow.

use std::collections::{BTreeMap, HashMap};

use nalgebra::DMatrix;

use super::faces::{Faces, MOST, Patch, Placed, shape_slopes, shapes, swept};
use super::rows::Pass;
use super::rule::Held;
use crate::element::Order;
use crate::tensor::{Matrix, Vector, unit_vector};

/// The step of differences of normals, as a share of a facet.
const STEP: f64 = 1e-6;
/// A foot is along its normal if the point is no further from the line, as a share of a facet.
const ALONG: f64 = 1e-6;

/// A point with a force.
pub(super) struct Loaded<'a, const D: usize> {
    pub point: &'a Held<D>,
    pub push: f64,
    /// s of x = x̄(λ) + s m(λ), and the inverse of the slopes of the right side by λ and s; `None` for a foot that is not along normals,
    /// which is held.
    along: Option<(f64, Matrix<D>)>,
}

impl<'a, const D: usize> Loaded<'a, D> {
    fn new(
        point: &'a Held<D>,
        push: f64,
        place: Vector<D>,
        (patches, size): (&[Patch<D>; 2], f64),
    ) -> Self {
        let lambda = &point.foot.lambda;
        let s = point.foot.gap / patches[1].at(lambda).norm();
        let rest = place - patches[0].at(lambda) - patches[1].at(lambda) * s;
        let inverse = swept(patches, lambda, s).try_inverse();
        let inverse = inverse.filter(|_| rest.norm() < ALONG * size);
        Loaded {
            point,
            push,
            along: inverse.map(|inverse| (s, inverse)),
        }
    }

    /// The gap after a small change of the master or of the place: Newton's method, one step.
    fn gap_after(&self, patches: &[Patch<D>; 2], place: &Vector<D>) -> f64 {
        let mut lambda = self.point.foot.lambda;
        let Some((s, inverse)) = &self.along else {
            return (place - patches[0].at(&lambda)).dot(&self.point.foot.normal);
        };
        let rest = place - patches[0].at(&lambda) - patches[1].at(&lambda) * *s;
        let step = inverse * rest;
        for k in 1..D {
            lambda[k] += step[k - 1];
            lambda[0] -= step[k - 1];
        }
        (s + step[D - 1]) * patches[1].at(&lambda).norm()
    }
}

impl<const D: usize> Pass<'_, D> {
    /// The points with a force, where the scene's nodes are at `x`, at which the feet were looked for.
    pub fn loaded(&self, pushes: &[f64], x: &[Vector<D>]) -> Vec<Loaded<'_, D>> {
        let size = self.slave.size().min(self.master.faces.size());
        let own: Vec<Vector<D>> = self.slave.nodes.iter().map(|&a| x[a]).collect();
        let points = self.held.iter().zip(pushes);
        let points = points
            .filter(|(_, push)| **push != 0.0)
            .map(|(point, push)| {
                let place = self.slave.patch(point.facet, &own).at(&point.lambda);
                let patches = self.master.patches(point.foot.facet);
                Loaded::new(point, *push, place, (&patches, size))
            });
        points.collect()
    }

    /// Σ π_q g_q with feet and normals that follow the nodes of the scene to `x`, nearby (UF·UL).
    pub fn work(&self, loaded: &[Loaded<'_, D>], x: &[Vector<D>]) -> f64 {
        let slave: Vec<Vector<D>> = self.slave.nodes.iter().map(|&a| x[a]).collect();
        let master = self.master.faces;
        let places = master.nodes.iter().map(|&b| &x[b]);
        let moved = (!places.eq(&self.master.x)).then(|| {
            let mut is_needed = vec![false; master.nodes.len()];
            for own in loaded {
                let nodes = master.facet(own.point.foot.facet).iter();
                nodes.for_each(|&b| is_needed[b] = true);
            }
            Placed::unsorted(master, x, |b| is_needed[b])
        });
        let moved = moved.as_ref().unwrap_or(self.master);
        let works = loaded.iter().map(|own| {
            let point = own.point;
            let place = self.slave.patch(point.facet, &slave).at(&point.lambda);
            let patches = moved.patches(point.foot.facet);
            own.push * own.gap_after(&patches, &place)
        });
        works.sum()
    }

    /// Gives the slopes of forces by positions to `add`, one matrix for each facet of the master that has points, with the nodes of the scene
    /// whose components its rows and columns belong to, ascending. Matrices of several facets add up. Pushes, and the points that count, are held.
    pub fn slopes_of_forces(
        &self,
        loaded: &[Loaded<'_, D>],
        mut add: impl FnMut(&[usize], &DMatrix<f64>),
    ) {
        let (slave, master) = (self.slave, self.master.faces);
        let there = &self.master.x;
        let (around, sums) = (master.around(), master.normal_sums(there, |_| true));
        let step = STEP * slave.size().min(master.size());
        let mut normal_rates: HashMap<usize, Vec<Vector<D>>> = HashMap::new();
        let mut changes: Vec<(usize, f64)> = Vec::new();
        let mut by_facet: BTreeMap<usize, Vec<&Loaded<'_, D>>> = BTreeMap::new();
        for own in loaded.iter().filter(|own| own.along.is_some()) {
            by_facet.entry(own.point.foot.facet).or_default().push(own);
        }
        for (facet, loaded) in by_facet {
            let corners = master.facet(facet);
            let facets = || corners.iter().flat_map(|&a| &around[a]).copied();
            // the nodes of the scene on which forces of these points act or depend
            let mut nodes: Vec<usize> = facets()
                .flat_map(|f| master.facet(f))
                .map(|&b| master.nodes[b])
                .collect();
            for own in &loaded {
                let corners = slave.facet(own.point.facet).iter();
                nodes.extend(corners.map(|&a| slave.nodes[a]));
            }
            nodes.sort_unstable();
            nodes.dedup();
            let place_of = |faces: &Faces<D>, a: usize| {
                D * nodes.binary_search(&faces.nodes[a]).unwrap_or_default()
            };
            let places_of = |faces: &Faces<D>, f: usize| -> Vec<usize> {
                let own = faces.facet(f).iter();
                own.map(|&a| place_of(faces, a)).collect()
            };
            let rows = D * nodes.len();
            let mut slopes = DMatrix::<f64>::zeros(rows, rows);
            // by the averaged normals at the facet's nodes
            let mut by_normals = DMatrix::<f64>::zeros(rows, D * corners.len());
            let patches = self.master.patches(facet);
            let on_master = places_of(master, facet);
            for own in loaded {
                let on_slave = places_of(slave, own.point.facet);
                let Some(rates) = Rates::new(own, &patches, [slave.order(), master.order()]) else {
                    continue;
                };
                let places = [&on_slave[..], &on_master];
                for i in 0..D {
                    rates.spread(&rates.moved[i], places, &mut changes);
                    for (a, N) in on_slave.iter().zip(rates.N[0]) {
                        add_to_column(&mut slopes, a + i, N, &changes);
                    }
                    for (k, (b, N)) in on_master.iter().zip(rates.N[1]).enumerate() {
                        add_to_column(&mut slopes, b + i, -N, &changes);
                        add_to_column(&mut by_normals, D * k + i, -rates.s * N, &changes);
                    }
                    rates.spread(&rates.turned[i], places, &mut changes);
                    for (k, N) in (0..corners.len()).zip(rates.N[1]) {
                        add_to_column(&mut by_normals, D * k + i, N, &changes);
                    }
                }
            }
            let mut turns = DMatrix::<f64>::zeros(D * corners.len(), rows);
            for (k, &a) in corners.iter().enumerate() {
                let length = sums[a].norm();
                let normal = sums[a] / length;
                if !(length > 0.0) {
                    continue;
                }
                for &f in &around[a] {
                    let rates = normal_rates
                        .entry(f)
                        .or_insert_with(|| master.normal_rates(f, there, step));
                    let own = master.facet(f);
                    let at = own.iter().position(|b| *b == a).unwrap_or_default();
                    for (j, &b) in own.iter().enumerate() {
                        for i in 0..D {
                            let rate = rates[(D * j + i) * own.len() + at];
                            let rate = across(&rate, &normal) / length;
                            let mut own =
                                turns.fixed_view_mut::<D, 1>(D * k, place_of(master, b) + i);
                            own += rate;
                        }
                    }
                }
            }
            slopes.gemm(1.0, &by_normals, &turns, 1.0);
            add(&nodes, &slopes);
        }
    }
}

/// Adds a share of these entries to a column.
fn add_to_column(matrix: &mut DMatrix<f64>, column: usize, share: f64, entries: &[(usize, f64)]) {
    let rows = matrix.nrows();
    let column = &mut matrix.as_mut_slice()[rows * column..rows * (column + 1)];
    for (row, entry) in entries {
        column[*row] += share * entry;
    }
}

/// The part of a vector across a unit normal.
fn across<const D: usize>(v: &Vector<D>, normal: &Vector<D>) -> Vector<D> {
    v - normal * normal.dot(v)
}

/// A change of the unit normal at a foot, and of N_b there.
type Change<const D: usize> = (Vector<D>, [f64; MOST]);

/// How the forces of a point vary: x = x̄(λ) + s m(λ) holds, and the forces are π N_a n at the slave, and −π N_b(λ) n at the master, n = m/|m|.
struct Rates<const D: usize> {
    push: f64,
    s: f64,
    n: Vector<D>,
    /// N_a of the point on the slave, and N_b of its foot on the master.
    N: [[f64; MOST]; 2],
    /// While the point moves along axis i, or what is at rest against it the other way.
    moved: [Change<D>; D],
    /// While m is lengthened along axis i, and λ is held.
    turned: [Change<D>; D],
}

impl<const D: usize> Rates<D> {
    /// `None` if the foot is held.
    fn new(
        own: &Loaded<'_, D>,
        [_, normals]: &[Patch<D>; 2],
        [on_slave, on_master]: [Order; 2],
    ) -> Option<Self> {
        let (s, inverse) = own.along?;
        let lambda = &own.point.foot.lambda;
        let m = normals.at(lambda);
        let length = m.norm();
        let n = m / length;
        let slopes: [Change<D>; D] = std::array::from_fn(|k| match k {
            0 => (Vector::zeros(), [0.0; MOST]),
            _ => (normals.slope(lambda, k), shape_slopes(on_master, lambda, k)),
        });
        let moved = std::array::from_fn(|i| {
            // ∂(λ_1, …, s)/∂x_i
            let step = inverse.column(i);
            let mut change: Change<D> = (Vector::zeros(), [0.0; MOST]);
            for k in 1..D {
                change.0 += slopes[k].0 * step[k - 1];
                let own = change.1.iter_mut().zip(slopes[k].1);
                own.for_each(|(change, slope)| *change += slope * step[k - 1]);
            }
            (across(&change.0, &n) / length, change.1)
        });
        let turned = std::array::from_fn(|i| {
            let turn = across(&unit_vector(i), &n) / length;
            (turn, [0.0; MOST])
        });
        let N = [
            shapes(on_slave, &own.point.lambda),
            shapes(on_master, lambda),
        ];
        Some(Rates {
            push: own.push,
            s,
            n,
            N,
            moved,
            turned,
        })
    }

    /// Sets `changes` to the changes of the forces on the nodes at these places, component by component.
    fn spread(
        &self,
        (turn, shift): &Change<D>,
        [on_slave, on_master]: [&[usize]; 2],
        changes: &mut Vec<(usize, f64)>,
    ) {
        changes.clear();
        let turn = turn * self.push;
        for (row, N) in on_slave.iter().zip(self.N[0]) {
            changes.extend((0..D).map(|i| (row + i, turn[i] * N)));
        }
        for ((row, N), shift) in on_master.iter().zip(self.N[1]).zip(shift) {
            let change = turn * N + self.n * (shift * self.push);
            changes.extend((0..D).map(|i| (row + i, -change[i])));
        }
    }
}
