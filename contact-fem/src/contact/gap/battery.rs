//! Tests of g, ∇g and ∇²g at single points: against the definition and its differences, and under
//! motions that leave them unchanged.

use std::sync::Arc;

use super::definition::{Case, DIFFERENCE, STEP, add_middles, bump, master};
use super::*;
use crate::contact::stencil::stencils;
use crate::contact::{Integration, Master, Moving, Projection, Surface};
use crate::element::{FacetRule, Order, facet_edge, facet_shapes};

/// The largest differences from the expected values.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    gap: f64,
    /// The distance between the found foot and the expected one.
    foot: f64,
    gradient: f64,
    hessian: f64,
    frozen: f64,
    rigid: f64,
    /// The number of compared points.
    points: usize,
}

impl Errors {
    fn add(&mut self, other: Errors) {
        self.gap = self.gap.max(other.gap);
        self.foot = self.foot.max(other.foot);
        self.gradient = self.gradient.max(other.gradient);
        self.hessian = self.hessian.max(other.hessian);
        self.frozen = self.frozen.max(other.frozen);
        self.rigid = self.rigid.max(other.rigid);
        self.points += other.points;
    }

    fn assert_small(&self, what: &str, points: usize) {
        println!("{what}: {self:?}");
        assert!(self.points >= points, "{what}: {self:?}");
        // Newton's method on a curved facet stops when distances no longer differ
        assert!(self.gap < 1e-9 && self.foot < 1e-7, "{what}: {self:?}");
        assert!(self.gradient < 1e-9, "{what}: {self:?}");
        assert!(self.hessian < 1e-8, "{what}: {self:?}");
        assert!(self.frozen < 1e-8, "{what}: {self:?}");
        assert!(self.rigid < 1e-12, "{what}: {self:?}");
    }
}

/// Compares all derivatives of one stencil, whose slave point is `xi` on facet 0.
fn compare<const D: usize>(
    case: &Case<D>,
    surface: &Arc<Surface<D>>,
    stencil: &Stencil<'_, D>,
    xi: &Vector<D>,
) -> Errors {
    let facet = &case.master[stencil.projection().facet];
    let mut errors = Errors {
        points: 1,
        ..Errors::default()
    };
    let start = stencil.projection().lambda;
    let (g, foot, _) = case.gap(&stencil.point(), facet, &start);
    errors.gap = (g - stencil.projection().gap).abs();
    errors.foot = (foot - start).amax();
    let mut own = MovingGap::default();
    own.second(&stencil.moved(stencil.master(), stencil.point(), foot));
    let nodes = own.nodes().to_vec();
    let mut other = MovingGap::default();
    for (m, &node) in nodes.iter().enumerate() {
        for j in 0..D {
            let mut slope = 0.0;
            let mut second = vec![Vector::<D>::zeros(); nodes.len()];
            let mut frozen = vec![Vector::<D>::zeros(); nodes.len()];
            for (coefficient, steps) in DIFFERENCE {
                let mut moved = Case {
                    x: case.x.clone(),
                    slave: case.slave.clone(),
                    master: case.master.clone(),
                    ..*case
                };
                moved.x[node][j] += steps * STEP;
                let x = moved.point(&case.slave[0], xi);
                let (g, lambda, n) = moved.gap(&x, facet, &start);
                let share = coefficient / STEP;
                slope += g * share;
                let master = Moving::new(surface, &moved.x);
                other.first(&stencil.moved(&master, x, lambda));
                assert_eq!(other.nodes(), nodes);
                let all = second.iter_mut().zip(other.gradient());
                all.for_each(|(sum, gradient)| *sum += gradient * share);
                let own = case.slave[0].iter().zip(facet_shapes(case.order, xi));
                let foot = facet
                    .iter()
                    .zip(facet_shapes(case.order, &lambda).map(|N| -N));
                for (a, N) in own.chain(foot) {
                    let l = nodes.iter().position(|b| b == a).expect("numbered");
                    frozen[l] += n * (N * share);
                }
            }
            errors.gradient = errors.gradient.max((own.gradient()[m][j] - slope).abs());
            for l in 0..nodes.len() {
                let of = |block: Matrix<D>, by: &Vector<D>| (block.column(j) - by).amax();
                errors.hessian = errors.hessian.max(of(own.hessian(l, m), &second[l]));
                errors.frozen = errors.frozen.max(of(own.frozen_jacobian(l, m), &frozen[l]));
            }
        }
    }
    errors.rigid = rigid(&own, &case.x);
    errors
}

/// Translations and rotations W of all nodes: Σ ∇_l g = 0, Σ ∇_l g·W x_l = 0, Σ_m ∇²_lm g = 0 and
/// Σ_m ∇²_lm g W x_m = W ∇_l g.
fn rigid<const D: usize>(gap: &MovingGap<D>, x: &[Vector<D>]) -> f64 {
    let nodes = || gap.nodes().iter().map(|&a| x[a]).enumerate();
    let mut error = gap.gradient().iter().sum::<Vector<D>>().amax();
    for (a, b) in [(0, 1), (1, D - 1), (D - 1, 0)] {
        let mut W = Matrix::<D>::zeros();
        (W[(a, b)], W[(b, a)]) = (1.0, -1.0);
        if a == b {
            continue;
        }
        let turned = nodes().map(|(l, x)| gap.gradient()[l].dot(&(W * x)));
        error = error.max(turned.sum::<f64>().abs());
        for l in 0..gap.nodes().len() {
            let sum: Vector<D> = nodes().map(|(m, x)| gap.hessian(l, m) * (W * x)).sum();
            error = error.max((sum - W * gap.gradient()[l]).amax());
            let sum: Matrix<D> = nodes().map(|(m, _)| gap.hessian(l, m)).sum();
            error = error.max(sum.amax());
        }
    }
    error
}

/// A reversed slave facet whose point `xi` is at a distance of `height` from `foot` along `up`.
fn over<const D: usize>(
    order: Order,
    foot: Vector<D>,
    up: Vector<D>,
    height: f64,
    xi: &Vector<D>,
    by: Projection,
) -> Case<D> {
    let (mut x, master) = master::<D>(order);
    let first = x.len();
    let corners = [[0.4, 0.1, 0.0], [-0.3, 0.4, 0.0], [-0.1, -0.5, 0.0]];
    let flat = |k: usize| {
        Vector::<D>::from_fn(|i, _| {
            if i + 1 == D {
                0.05 * k as f64
            } else {
                corners[k][i]
            }
        })
    };
    // counter-clockwise as seen from above faces up; in the plane, left to right faces down
    let turned = if D == 2 { [1, 0, 2] } else { [0, 2, 1] };
    x.extend((0..D).map(|k| flat(turned[k])));
    if D == 2 {
        x.swap(first, first + 1);
        x[first + 1][0] = x[first][0] + 0.7;
    }
    if order == Order::Quadratic {
        for e in 0..D * (D - 1) / 2 {
            let [a, b] = facet_edge::<D>(e).map(|k| x[first + k]);
            x.push((a + b) * 0.5 + Vector::repeat(0.02 * (e as f64 - 0.7)));
        }
    }
    let mut case = Case {
        order,
        slave: vec![(first..x.len()).collect()],
        x,
        master,
        by,
    };
    let shift = foot + up * height - case.point(&case.slave[0], xi);
    case.x[first..].iter_mut().for_each(|x| *x += shift);
    case
}

/// Projects the slave's only point, checks the position of the foot, and compares.
fn compare_at<const D: usize>(case: &Case<D>, wanted: &Vector<D>, facet: usize) -> Option<Errors> {
    let rule = FacetRule::<D>::gauss(1);
    let xi = rule.points()[0].1;
    let [slave, master] = [(0, &case.slave), (1, &case.master)].map(|(body, facets)| {
        let mut X = case.x.clone();
        // in the reference configuration the slave was outside
        case.slave[0].iter().for_each(|&a| X[a][D - 1] += 2.0);
        Arc::new(Surface::new(
            body,
            case.order,
            facets.iter().map(Vec::as_slice),
            &X,
        ))
    });
    let at = Master::new(&master, &case.x, case.by);
    let all = stencils(&slave, &at, &case.x, Integration::Gauss(1), 1.0);
    let found = all.first()?.projection();
    let same_pattern = (0..D).all(|k| (found.lambda[k] == 0.0) == (wanted[k] == 0.0));
    let on_a_side = wanted.iter().any(|&l| l == 0.0);
    // two facets share a side
    let same_foot = (found.foot - case.point(&case.master[facet], wanted)).norm() < 1e-7;
    let same_facet = found.facet == facet || on_a_side;
    let counts_zeros = |v: &Vector<D>| v.iter().filter(|&&l| l == 0.0).count();
    let same = same_pattern || on_a_side && counts_zeros(&found.lambda) == counts_zeros(wanted);
    (same && same_foot && same_facet).then(|| compare(case, &master, &all[0], &xi))
}

/// Every point λ of every facet, with slave points above and below it in directions for which the
/// foot stays there.
fn battery<const D: usize>(
    (order, by): (Order, Projection),
    what: &str,
    lambdas: &[[f64; 3]],
    least: usize,
) {
    let mut errors = Errors::default();
    let rule = FacetRule::<D>::gauss(1);
    let xi = rule.points()[0].1;
    let (x, facets) = master::<D>(order);
    let plain = Case {
        order,
        x,
        slave: vec![],
        master: facets,
        by,
    };
    for lambda in lambdas {
        let mut wanted = Vector::<D>::from_fn(|k, _| lambda[k]);
        wanted /= wanted.sum();
        for (index, facet) in plain.master.iter().enumerate() {
            let foot = plain.point(facet, &wanted);
            let mut up = match by {
                Projection::AlongNormals => plain.normal(facet, &wanted),
                Projection::Closest => plain.facet_normal(facet, &wanted),
            };
            if by == Projection::Closest && wanted.iter().any(|&l| l == 0.0) {
                // between the normals of the facets that meet there
                let corners: Vec<usize> = (0..D)
                    .filter(|&k| wanted[k] > 0.0)
                    .map(|k| facet[k])
                    .collect();
                let meets = |f: &&Vec<usize>| corners.iter().all(|a| f[..D].contains(a));
                let around = plain.master.iter().filter(meets);
                let at = |f: &Vec<usize>| {
                    let place = |k: usize| facet.iter().position(|&a| a == f[k]).filter(|&k| k < D);
                    let there = Vector::<D>::from_fn(|k, _| place(k).map_or(0.0, |k| wanted[k]));
                    plain.facet_normal(f, &there)
                };
                up = around.map(at).sum::<Vector<D>>().normalize();
            }
            for height in [0.08, -0.05] {
                let case = over(order, foot, up, height, &xi, by);
                if let Some(found) = compare_at(&case, &wanted, index) {
                    errors.add(found);
                }
            }
        }
    }
    errors.assert_small(what, least);
}

const INSIDE: [[f64; 3]; 2] = [[0.4, 0.35, 0.25], [0.7, 0.2, 0.1]];
const NEAR_A_SIDE: [[f64; 3]; 3] = [[0.4, 0.6, 1e-6], [1e-4, 0.7, 0.3], [0.5, 1e-3, 0.5]];
const NEAR_AN_END: [[f64; 3]; 3] = [[1.0, 1e-6, 0.0], [1e-4, 1.0, 0.0], [1.0, 1e-3, 0.0]];

#[test]
fn segments() {
    for order in [Order::Linear, Order::Quadratic] {
        for by in [Projection::Closest, Projection::AlongNormals] {
            let how = (order, by);
            battery::<2>(how, &format!("{how:?} inside"), &INSIDE, 14);
            battery::<2>(how, &format!("{how:?} near an end"), &NEAR_AN_END, 12);
        }
        let how = (order, Projection::Closest);
        let ends = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        battery::<2>(how, &format!("{how:?} at an end"), &ends, 6);
    }
}

#[test]
fn linear_triangles() {
    triangles(Order::Linear);
}

#[test]
fn quadratic_triangles() {
    triangles(Order::Quadratic);
}

fn triangles(order: Order) {
    for by in [Projection::Closest, Projection::AlongNormals] {
        let how = (order, by);
        battery::<3>(how, &format!("{how:?} inside"), &INSIDE[..1], 12);
        battery::<3>(how, &format!("{how:?} near a side"), &NEAR_A_SIDE, 12);
    }
    let how = (order, Projection::Closest);
    let sides = [[0.4, 0.6, 0.0], [0.0, 0.3, 0.7]];
    battery::<3>(how, &format!("{how:?} on a side"), &sides, 10);
    battery::<3>(how, &format!("{how:?} in a corner"), &[[1.0, 0.0, 0.0]], 2);
}

/// A channel with facing sides: facets around the foot share nodes with the slave's facet.
fn in_a_channel<const D: usize>((order, by): (Order, Projection), least: usize) {
    let profile = [[0.55, 0.9], [0.5, 0.0], [0.0, 0.1], [-0.05, 1.0]];
    let levels: &[f64] = if D == 2 { &[0.0] } else { &[0.0, 0.8, 1.7] };
    let mut x = Vec::new();
    for (k, z) in levels.iter().enumerate() {
        for (i, at) in profile.iter().enumerate() {
            let at = [at[0], at[1], z + bump(i, 0.1)];
            x.push(Vector::<D>::from_fn(|j, _| {
                at[j] + bump(4 * k + i + 2 * j, 0.03)
            }));
        }
    }
    let mut master: Vec<Vec<usize>> = Vec::new();
    for k in (0..x.len()).filter(|k| k % 4 < 3) {
        if D == 2 {
            master.push(vec![k, k + 1]);
        } else if k + 4 < x.len() {
            master.push(vec![k, k + 1, k + 5]);
            master.push(vec![k, k + 5, k + 4]);
        }
    }
    if order == Order::Quadratic {
        add_middles(&mut x, &mut master);
    }
    let facets = master.iter().map(Vec::as_slice);
    let surface = Arc::new(Surface::new(0, order, facets, &x));
    let at = Master::new(&surface, &x, by);
    let xi = FacetRule::<D>::gauss(1).points()[0].1;
    let mut errors = Errors::default();
    for stencil in stencils(&surface, &at, &x, Integration::Gauss(1), 1.0) {
        let own: Vec<usize> = stencil.slave_shapes().map(|(a, _)| a).collect();
        let case = Case {
            order,
            x: x.clone(),
            slave: vec![own],
            master: master.clone(),
            // too deep in a corner, there is no foot along normals
            by: stencil.projection().by,
        };
        let mut gap = MovingGap::default();
        gap.first(&stencil);
        let mut nodes = gap.nodes().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        assert_eq!(nodes.len(), gap.nodes().len());
        let around = |a: &usize| {
            let foot = &master[stencil.projection().facet];
            let meets = |f: &&Vec<usize>| f.iter().any(|b| foot.contains(b));
            master.iter().filter(meets).any(|f| f.contains(a))
        };
        if case.slave[0].iter().any(around) {
            errors.add(compare(&case, &surface, &stencil, &xi));
        }
    }
    errors.assert_small(&format!("{order:?} {by:?} in a channel"), least);
}

#[test]
fn self_contact() {
    for order in [Order::Linear, Order::Quadratic] {
        for by in [Projection::Closest, Projection::AlongNormals] {
            in_a_channel::<2>((order, by), 2);
            in_a_channel::<3>((order, by), 4);
        }
    }
}
