//! How gaps and forces of points vary with positions, while feet and normals follow.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::faces::{Patch, Placed, shapes, swept};
use super::rows::Pass;
use super::rule::Held;
use crate::tensor::{Matrix, Vector};

/// The step of differences, as a share of a facet, and of a unit normal.
const STEP: f64 = 1e-6;
/// A foot is along its normal if the point is no further from the line, as a share of a facet.
const ALONG: f64 = 1e-6;

/// A point with a force.
pub(super) struct Loaded<'a, const D: usize> {
    pub point: &'a Held<D>,
    pub push: f64,
    place: Vector<D>,
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
            place,
            along: inverse.map(|inverse| (s, inverse)),
        }
    }

    /// λ of the foot, the unit normal there and the gap, after a small change of the master or of the place: Newton's method, one step.
    fn after(&self, patches: &[Patch<D>; 2], place: &Vector<D>) -> (Vector<D>, Vector<D>, f64) {
        let mut lambda = self.point.foot.lambda;
        let Some((s, inverse)) = &self.along else {
            let normal = self.point.foot.normal;
            return (
                lambda,
                normal,
                (place - patches[0].at(&lambda)).dot(&normal),
            );
        };
        let rest = place - patches[0].at(&lambda) - patches[1].at(&lambda) * *s;
        let step = inverse * rest;
        for k in 1..D {
            lambda[k] += step[k - 1];
            lambda[0] -= step[k - 1];
        }
        let normal = patches[1].at(&lambda);
        let length = normal.norm();
        (lambda, normal / length, (s + step[D - 1]) * length)
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
        let moved = Placed::unsorted(self.master.faces, x);
        let works = loaded.iter().map(|own| {
            let point = own.point;
            let place = self.slave.patch(point.facet, &slave).at(&point.lambda);
            let patches = moved.patches(point.foot.facet);
            let (_, _, gap) = own.after(&patches, &place);
            own.push * gap
        });
        works.sum()
    }

    /// Gives the slopes of forces by positions to `add`, one matrix for each facet of the master that has points, with the components of the
    /// scene's nodes that its rows and columns belong to. Those of one place add up. Pushes, and the points that count, are held.
    pub fn slopes_of_forces(
        &self,
        loaded: &[Loaded<'_, D>],
        x: &[Vector<D>],
        mut add: impl FnMut(&[usize], &DMatrix<f64>),
    ) {
        let master = self.master.faces;
        let around = master.around();
        let step = STEP * self.slave.size().min(master.size());
        let mut there: Vec<Vector<D>> = master.nodes.iter().map(|&b| x[b]).collect();
        let mut by_facet: BTreeMap<usize, Vec<&Loaded<'_, D>>> = BTreeMap::new();
        for own in loaded.iter().filter(|own| own.along.is_some()) {
            by_facet.entry(own.point.foot.facet).or_default().push(own);
        }
        for (facet, loaded) in by_facet {
            let mut facets = Vec::new();
            for &a in master.facet(facet) {
                facets.extend_from_slice(&around[a]);
            }
            facets.sort_unstable();
            facets.dedup();
            let sums = master.sums(facet, &facets, &there);
            let here = master.patches_of(facet, &there, &sums);
            // the nodes of the scene on which forces of these points act or depend
            let mut nearby: Vec<usize> = facets
                .iter()
                .flat_map(|&f| master.facet(f))
                .copied()
                .collect();
            nearby.sort_unstable();
            nearby.dedup();
            let mut nodes: Vec<usize> = nearby.iter().map(|&b| master.nodes[b]).collect();
            for own in &loaded {
                let corners = self.slave.facet(own.point.facet).iter();
                nodes.extend(corners.map(|&a| self.slave.nodes[a]));
            }
            nodes.sort_unstable();
            nodes.dedup();
            let place_of = |node: usize| D * nodes.binary_search(&node).unwrap_or_default();
            let rows = D * nodes.len();
            let mut slopes = DMatrix::<f64>::zeros(rows, rows);
            // by the places of the facet's nodes, and by the normals there
            let corners = master.facet(facet);
            let mut by_patch = [(); 2].map(|()| DMatrix::<f64>::zeros(rows, D * corners.len()));
            for own in &loaded {
                let before = own.after(&here, &own.place);
                let N = shapes(self.slave.order(), &own.point.lambda);
                for i in 0..D {
                    let mut moved = own.place;
                    moved[i] += step;
                    let after = own.after(&here, &moved);
                    self.add_change(own, [&after, &before], &place_of, |row, change| {
                        for (&a, N) in self.slave.facet(own.point.facet).iter().zip(N) {
                            let column = place_of(self.slave.nodes[a]) + i;
                            slopes[(row, column)] += N * change / step;
                        }
                    });
                    for k in 0..corners.len() {
                        for (which, step) in [(0, step), (1, STEP)] {
                            let mut moved = here;
                            moved[which].add(k, i, step);
                            let after = own.after(&moved, &own.place);
                            self.add_change(own, [&after, &before], &place_of, |row, change| {
                                by_patch[which][(row, D * k + i)] += change / step;
                            });
                        }
                    }
                }
            }
            for (k, &b) in corners.iter().enumerate() {
                let mut own = slopes.columns_mut(place_of(master.nodes[b]), D);
                own += by_patch[0].columns(D * k, D);
            }
            for b in nearby {
                // normals vary with this node on the facets around it alone
                let vary = master.sums(facet, &around[b], &there);
                for i in 0..D {
                    let kept = there[b][i];
                    there[b][i] = kept + step;
                    let mut moved = master.sums(facet, &around[b], &there);
                    let rest = sums.iter().zip(&vary).map(|(sum, vary)| sum - vary);
                    moved
                        .iter_mut()
                        .zip(rest)
                        .for_each(|(sum, rest)| *sum += rest);
                    let [_, normals] = master.patches_of(facet, &there, &moved);
                    there[b][i] = kept;
                    let change = normals.components().zip(here[1].components());
                    let rate = change.map(|(after, before)| (after - before) / step);
                    let rate = DVector::from_iterator(D * corners.len(), rate);
                    let mut column = slopes.column_mut(place_of(master.nodes[b]) + i);
                    column.gemv(1.0, &by_patch[1], &rate, 1.0);
                }
            }
            let dofs: Vec<usize> = (0..rows).map(|k| D * nodes[k / D] + k % D).collect();
            add(&dofs, &slopes);
        }
    }

    /// The difference of two forces of a point, component by component.
    fn add_change(
        &self,
        own: &Loaded<'_, D>,
        [after, before]: [&(Vector<D>, Vector<D>, f64); 2],
        place_of: &impl Fn(usize) -> usize,
        mut add: impl FnMut(usize, f64),
    ) {
        let turn = (after.1 - before.1) * own.push;
        let N = shapes(self.slave.order(), &own.point.lambda);
        for (&a, N) in self.slave.facet(own.point.facet).iter().zip(N) {
            let row = place_of(self.slave.nodes[a]);
            (0..D).for_each(|i| add(row + i, turn[i] * N));
        }
        let master = self.master.faces;
        let [on, from] = [after, before].map(|(lambda, ..)| shapes(master.order(), lambda));
        let nodes = master.facet(own.point.foot.facet).iter();
        for ((&b, from), on) in nodes.zip(from).zip(on) {
            let row = place_of(master.nodes[b]);
            let change = (before.1 * from - after.1 * on) * own.push;
            (0..D).for_each(|i| add(row + i, change[i]));
        }
    }
}
