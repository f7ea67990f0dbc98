//! Tests of rows and of the derivatives of weak gaps against their definition.

use std::sync::Arc;

use std::collections::BTreeMap;

use contact_core::gaps::{LinearGaps, Sampling};

use super::definition::{Case, DIFFERENCE, STEP, bump, master};
use super::*;
use crate::assembly::DofMap;
use crate::contact::rows::{PassRows, Unknowns};
use crate::contact::stencil::projected;
use crate::contact::{Integration, Master, Projection, Surface};
use crate::element::{FacetRule, Order, facet_shapes};

/// Two bumpy surfaces with many points.
struct Pair<const D: usize> {
    case: Case<D>,
    slave: Arc<Surface<D>>,
    master: Arc<Surface<D>>,
    X: Vec<Vector<D>>,
}

/// The number of a point, and the corners of the smallest part of the facet that contains its foot.
type Feet = Vec<(usize, Vec<usize>)>;

impl<const D: usize> Pair<D> {
    /// A smaller reversed copy of [`master`] above it.
    fn new(order: Order, by: Projection) -> Self {
        let (mut x, master) = master::<D>(order);
        let (count, middle) = (x.len(), x.iter().sum::<Vector<D>>() / x.len() as f64);
        let mut slave = master.clone();
        for a in 0..count {
            let mut copy = middle + (x[a] - middle) * 0.45;
            copy[0] += if D == 2 { 1.6 } else { 1.0 }; // beyond the rim
            copy[D - 1] = 0.27 - 0.2 * x[a][D - 1];
            x.push(copy);
        }
        for facet in &mut slave {
            facet.iter_mut().for_each(|a| *a += count);
            facet[..D].swap(0, 1);
            if D == 3 && order == Order::Quadratic {
                facet.swap(4, 5); // the middles of the other two sides
            }
        }
        let mut X = x.clone();
        X[count..].iter_mut().for_each(|X| X[D - 1] += 2.0);
        let [own, other] = [(0, &slave), (1, &master)].map(|(body, facets)| {
            Arc::new(Surface::new(
                body,
                order,
                facets.iter().map(Vec::as_slice),
                &X,
            ))
        });
        let case = Case {
            order,
            x,
            slave,
            master,
            by,
        };
        Pair {
            case,
            slave: own,
            master: other,
            X,
        }
    }

    /// The foot along normals by exhaustive search over facets: facet, λ and n.
    fn along_normals(&self, x: &Vector<D>) -> Option<(usize, Vector<D>, Vector<D>)> {
        let feet = self
            .case
            .master
            .iter()
            .enumerate()
            .filter_map(|(f, facet)| {
                let middle = Vector::repeat(1.0 / D as f64);
                let (gap, lambda, n) = self.case.gap(x, facet, &middle);
                (lambda.min() >= 0.0).then_some((gap, (f, lambda, n)))
            });
        let nearest = feet.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        nearest.map(|(_, foot)| foot)
    }

    fn foot(&self, x: &Vector<D>) -> Option<(usize, Vector<D>, Vector<D>)> {
        match self.case.by {
            Projection::AlongNormals => self.along_normals(x),
            Projection::Closest => self.closest(x),
        }
    }

    /// The closest point by exhaustive search over facets, sides and corners: facet, λ and n;
    /// `None` at the rim.
    fn closest(&self, x: &Vector<D>) -> Option<(usize, Vector<D>, Vector<D>)> {
        let mut best = (f64::INFINITY, None);
        for (index, facet) in self.case.master.iter().enumerate() {
            for zeros in 0..(1usize << D) - 1 {
                let mut start = Vector::<D>::from_fn(|k, _| f64::from(zeros >> k & 1 == 0));
                start /= start.sum();
                let (_, lambda, n) = self.case.gap(x, facet, &start);
                let distance = (x - self.case.point(facet, &lambda)).norm();
                if lambda.min() >= 0.0 && distance < best.0 - 1e-9 {
                    best = (distance, Some((index, lambda, n)));
                }
            }
        }
        let (facet, lambda, n) = best.1?;
        let nodes = self.master.facet(facet);
        let is_on_rim = self.master.rim().has(facet, nodes, &lambda);
        (!is_on_rim).then_some((facet, lambda, n))
    }

    /// The share of its weight with which a Gauss point of a facet counts whose foot is at λ: the foot's depth inside the rim over that of the
    /// outermost of the rule's points on its facet, if facets there were as long as this one. The depth is linear on the parts of a facet between a corner, the
    /// middle of a side and the centre: 0 at each of these three that is on the rim, 1 at each that is not. Lengths of the master are means around
    /// corners, and linear between corners.
    fn share(&self, slave: &[usize], (facet, lambda): (usize, &Vector<D>), points: usize) -> f64 {
        if self.case.by == Projection::Closest {
            return 1.0;
        }
        let nodes = self.case.master[facet][..D].to_vec();
        let is_on_rim = |corners: &[usize]| {
            let of_sides = (0..D).map(|k| (0..D).filter(|c| *c != k).map(|c| nodes[c]).collect());
            let sharers = |side: &Vec<usize>| {
                let facets = self.case.master.iter();
                let with = facets.filter(|f| side.iter().all(|a| f[..D].contains(a)));
                with.count()
            };
            let has = |side: &Vec<usize>| corners.iter().all(|a| side.contains(a));
            match corners.len() {
                // a corner is on the rim if any side at it is, of any facet
                1 => self.case.master.iter().any(|f| {
                    (0..D).any(|k| {
                        let side: Vec<usize> = (0..D).filter(|c| *c != k).map(|c| f[c]).collect();
                        has(&side) && sharers(&side) == 1
                    })
                }),
                n if n < D => of_sides
                    .into_iter()
                    .any(|side| has(&side) && sharers(&side) == 1),
                _ => false,
            }
        };
        let mut order: Vec<usize> = (0..D).collect();
        order.sort_by(|a, b| lambda[*b].total_cmp(&lambda[*a]));
        // columns: the corner, the middle of the side, the centre
        let part = Matrix::<D>::from_fn(|i, k| {
            let is_in = order[..=k].contains(&i);
            f64::from(u8::from(is_in)) / (k + 1) as f64
        });
        let within = part.try_inverse().expect("a simplex") * lambda;
        let depth: f64 = (0..D)
            .filter(|k| !is_on_rim(&order[..=*k].iter().map(|c| nodes[*c]).collect::<Vec<_>>()))
            .map(|k| within[k])
            .sum();
        let rule = FacetRule::<D>::gauss(points);
        let outermost = rule.points().iter().map(|(_, xi)| xi.min());
        let outermost = outermost.fold(1.0, f64::min) * 2.0;
        let X = Case {
            x: self.X.clone(),
            slave: vec![],
            master: vec![],
            ..self.case
        };
        let middle = Vector::repeat(1.0 / D as f64);
        let length = |facet: &[usize]| {
            X.measure(facet, &middle)
                .norm()
                .powf(1.0 / (D as f64 - 1.0))
        };
        let around = |node: usize| {
            let facets = self.case.master.iter().filter(|f| f.contains(&node));
            let lengths: Vec<f64> = facets.map(|f| length(f)).collect();
            lengths.iter().sum::<f64>() / lengths.len() as f64
        };
        let there: f64 = (0..D).map(|k| lambda[k] * around(nodes[k])).sum();
        let full = outermost * length(slave) / there;
        (depth / full.min(1.0)).min(1.0)
    }

    /// a_i and the coefficients of all nodes in a_i c_i; and how many rows lean on their neighbours.
    fn rows(&self, points: usize) -> (BTreeMap<usize, (f64, Vec<Vector<D>>)>, usize) {
        let Case { order, x, .. } = &self.case;
        let tests = if D == 2 { *order } else { Order::Linear };
        let mut whole = BTreeMap::<usize, f64>::new();
        let mut rows = BTreeMap::new();
        let X = Case {
            x: self.X.clone(),
            slave: vec![],
            master: vec![],
            ..self.case
        };
        for facet in &self.case.slave {
            for (weight, xi) in FacetRule::<D>::gauss(points).points() {
                let w = weight * X.measure(facet, xi).norm();
                for (&i, phi) in facet.iter().zip(facet_shapes(tests, xi)) {
                    *whole.entry(i).or_default() += w * phi;
                }
                let at = self.case.point(facet, xi);
                let Some((foot, lambda, n)) = self.foot(&at) else {
                    continue;
                };
                let w = w * self.share(facet, (foot, &lambda), points);
                let own = facet.iter().zip(facet_shapes(*order, xi));
                let nodes = self.case.master[foot].iter();
                let foot = nodes.zip(facet_shapes(*order, &lambda).map(|N| -N));
                let terms = own.chain(foot);
                for (&i, phi) in facet.iter().zip(facet_shapes(tests, xi)) {
                    if phi == 0.0 {
                        continue;
                    }
                    let row = rows.entry(i);
                    let (a, row) = row.or_insert((0.0, vec![Vector::zeros(); x.len()]));
                    *a += w * phi;
                    terms
                        .clone()
                        .for_each(|(&b, N)| row[b] += n * (N * w * phi));
                }
            }
        }
        self.leant(&rows, &whole)
    }

    /// s_i row_i + (1 − s_i) Σ_j s_j row_j.
    fn leant(
        &self,
        rows: &BTreeMap<usize, (f64, Vec<Vector<D>>)>,
        whole: &BTreeMap<usize, f64>,
    ) -> (BTreeMap<usize, (f64, Vec<Vector<D>>)>, usize) {
        let s = |i: &usize| {
            rows.get(i)
                .map_or(0.0, |(a, _)| (4.0 * a / whole[i]).clamp(0.0, 1.0))
        };
        let mut leaning = 0;
        let mut leant = BTreeMap::new();
        for (&i, (a, row)) in rows {
            let near = self.case.slave.iter().filter(|f| f.contains(&i)).flatten();
            let near: std::collections::BTreeSet<usize> =
                near.copied().filter(|&j| j != i).collect();
            let (mut a, mut row) = (a * s(&i), row.iter().map(|c| c * s(&i)).collect::<Vec<_>>());
            for (other, share) in near
                .iter()
                .filter_map(|j| Some((rows.get(j)?, (1.0 - s(&i)) * s(j))))
            {
                a += share * other.0;
                row.iter_mut()
                    .zip(&other.1)
                    .for_each(|(sum, c)| *sum += c * share);
            }
            leaning += usize::from(s(&i) < 1.0);
            leant.insert(i, (a, row));
        }
        leant.retain(|_, (a, _)| *a > 0.0);
        (leant, leaning)
    }

    /// The largest difference, and how many rows lean.
    fn are_rows(&self, points: usize) -> (f64, usize) {
        let master = Master::new(&self.master, &self.case.x, self.case.by);
        let x = &self.case.x;
        let integration = Integration::Gauss(points);
        let found = projected(&self.slave, &master, x, integration, 1.0);
        let rows = PassRows::new(&self.slave, &master, &found, Sampling::Nodes);
        let all_free = DofMap::new(&vec![false; D * x.len()]);
        let unknowns = Unknowns {
            dofs: &all_free,
            supports: &all_free,
            prescribed: &[],
        };
        let mut gaps = LinearGaps::new(false);
        // with X = 0, the unknowns are the positions
        rows.append(0, &vec![Vector::zeros(); x.len()], &unknowns, &mut gaps);
        let (expected, leaning) = self.rows(points);
        let counting = rows.stencils().count();
        assert!(counting > 5 && counting < points.pow(D as u32 - 1) * self.slave.len());
        let named: Vec<usize> = gaps.keys().iter().map(|key| key.node as usize).collect();
        assert_eq!(named, expected.keys().copied().collect::<Vec<_>>());
        let mut error = 0.0f64;
        for (i, (area, coefficients)) in expected.values().enumerate() {
            let row = gaps.row(i);
            error = error.max((row.weight - area).abs());
            let mut difference: Vec<f64> =
                coefficients.iter().flatten().map(|c| c / area).collect();
            row.free.iter().for_each(|&(j, c)| difference[j] -= c);
            error = difference.iter().fold(error, |m, d| m.max(d.abs()));
        }
        (error, leaning)
    }

    /// Multipliers λ_i and the forces Σ_i λ_i ∇c_i of the moving gaps; with `along`, the derivative
    /// of the forces in that direction; and the positions of the feet.
    fn forces(&self, x: &[Vector<D>], along: Option<&[Vector<D>]>) -> (f64, Vec<Vector<D>>, Feet) {
        let master = Master::new(&self.master, x, self.case.by);
        let integration = Integration::Gauss(2);
        let found = projected(&self.slave, &master, x, integration, 1.0);
        let rows = PassRows::new(&self.slave, &master, &found, Sampling::Nodes);
        let multiplier = |node: usize| 1.0 + 0.7 * (node as f64).sin();
        let mut forces = vec![Vector::zeros(); x.len()];
        let (mut energy, mut feet) = (0.0, Vec::new());
        let mut gap = MovingGap::default();
        let case = Case {
            x: x.to_vec(),
            slave: vec![],
            master: self.case.master.clone(),
            ..self.case
        };
        for (stencil, shares) in rows.stencils() {
            let force: f64 = shares.map(|(i, share)| multiplier(i) * share).sum();
            let p = stencil.projection();
            let facet = &case.master[p.facet];
            let (g, foot, _) = case.gap(&stencil.point(), facet, &p.lambda);
            energy += force * g;
            assert_eq!(p.by, self.case.by);
            let mut corners: Vec<usize> = (0..D)
                .filter(|&k| p.lambda[k] != 0.0)
                .map(|k| facet[k])
                .collect();
            corners.sort_unstable();
            feet.push((stencil.number(), corners));
            gap.second(&stencil.moved(stencil.master(), stencil.point(), foot));
            for (l, &a) in gap.nodes().iter().enumerate() {
                match along {
                    None => forces[a] += gap.gradient()[l] * force,
                    Some(along) => {
                        let of_m = |(m, &b): (usize, &usize)| gap.hessian(l, m) * along[b];
                        forces[a] +=
                            gap.nodes().iter().enumerate().map(of_m).sum::<Vector<D>>() * force;
                    }
                }
            }
        }
        (energy, forces, feet)
    }

    fn are_derivatives(&self) {
        let x = &self.case.x;
        let along: Vec<_> = (0..x.len())
            .map(|a| Vector::from_fn(|i, _| bump(3 * a + i, 0.25)))
            .collect();
        let (_, gradient, feet) = self.forces(x, None);
        let (_, second, _) = self.forces(x, Some(&along));
        assert!(feet.len() > 5, "{feet:?}");
        let (mut slope, mut difference) = (0.0, vec![Vector::zeros(); x.len()]);
        for (coefficient, steps) in DIFFERENCE {
            let moved = x.iter().zip(&along).map(|(x, d)| x + d * (steps * STEP));
            let (energy, forces, others) = self.forces(&moved.collect::<Vec<_>>(), None);
            assert_eq!(others, feet, "the same side of every kink");
            slope += energy * coefficient / STEP;
            let all = difference.iter_mut().zip(&forces);
            all.for_each(|(sum, force)| *sum += force * (coefficient / STEP));
        }
        let products = gradient.iter().zip(&along).map(|(f, d)| f.dot(d));
        let error = (products.sum::<f64>() - slope).abs();
        let errors = second.iter().zip(&difference).map(|(a, b)| (a - b).amax());
        let second_error = errors.fold(0.0, f64::max);
        println!(
            "{:?} {D}: weak gaps {error:e}, their forces {second_error:e}",
            self.case.order
        );
        assert!(
            error < 1e-9 && second_error < 1e-8,
            "{error:e} {second_error:e}"
        );
    }
}

/// Agreement up to round-off on flat facets; on curved ones up to the accuracy of the feet.
#[test]
fn rows_and_their_forces() {
    for by in [Projection::Closest, Projection::AlongNormals] {
        for (order, most) in [(Order::Linear, 1e-14), (Order::Quadratic, 1e-8)] {
            let (plane, space) = (Pair::<2>::new(order, by), Pair::<3>::new(order, by));
            let all = [plane.are_rows(4), plane.are_rows(3), space.are_rows(2)];
            println!("{order:?} {by:?}: rows, leaning {all:?}");
            assert!(all.iter().all(|(error, _)| *error < most), "{all:?}");
            assert!(all.iter().any(|(_, leaning)| *leaning > 0), "{all:?}");
            plane.are_derivatives();
            space.are_derivatives();
        }
    }
}
