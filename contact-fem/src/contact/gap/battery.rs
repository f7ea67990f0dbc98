//! g, ∇g and ∇²g against a gap that is written down once more, straight from its definition, and its
//! differences; and against motions that do not change it.

use std::sync::Arc;

use super::*;
use crate::contact::stencil::stencils;
use crate::contact::{Integration, Master, Surface};
use crate::element::{FacetRule, Order, facet_edge};

/// A facet of a slave over a master, with all nodes' positions.
struct Case<const D: usize> {
    order: Order,
    x: Vec<Vector<D>>,
    slave: Vec<Vec<usize>>,
    master: Vec<Vec<usize>>,
}

/// The definition, with nothing of what is tested but shape functions.
impl<const D: usize> Case<D> {
    fn point(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        let N = facet_shapes(self.order, lambda);
        facet.iter().zip(N).map(|(&a, N)| self.x[a] * N).sum()
    }

    /// The derivative along λ_b − λ_a, by a difference that is exact for quadratics.
    fn along(&self, facet: &[usize], lambda: &Vector<D>, [a, b]: [usize; 2]) -> Vector<D> {
        let mut step = Vector::zeros();
        (step[a], step[b]) = (-0.5, 0.5);
        self.point(facet, &(lambda + step)) - self.point(facet, &(lambda - step))
    }

    fn facet_normal(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        self.measure(facet, lambda).normalize()
    }

    /// The outward normal, as long as the measure of the tangent facet.
    fn measure(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        let a = self.along(facet, lambda, [0, 1]);
        let mut n = Vector::<D>::zeros();
        if D == 2 {
            (n[0], n[1]) = (a[1], -a[0]);
        } else {
            let b = self.along(facet, lambda, [0, 2]);
            for i in 0..3 {
                n[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
            }
            n *= 0.5;
        }
        n
    }

    fn averaged(&self, node: usize) -> Vector<D> {
        let mut sum = Vector::zeros();
        for facet in &self.master {
            let Some(k) = facet.iter().position(|&a| a == node) else {
                continue;
            };
            let mut lambda = Vector::zeros();
            if k < D {
                lambda[k] = 1.0;
            } else {
                let [a, b] = facet_edge::<D>(k - D);
                (lambda[a], lambda[b]) = (0.5, 0.5);
            }
            let mut weight = 1.0;
            if D == 3 && k < D {
                let sides = [1, 2].map(|i| [k, (k + i) % D]);
                let [a, b] = sides.map(|side| self.along(facet, &lambda, side).normalize());
                weight = a.dot(&b).acos();
            }
            sum += self.facet_normal(facet, &lambda) * weight;
        }
        sum.normalize()
    }

    /// g, λ* and n of a point x_q over a facet of the master: λ* stays on the side of the facet where
    /// `start` is, but may leave the facet along it, so that g goes on smoothly.
    fn gap(
        &self,
        x: &Vector<D>,
        facet: &[usize],
        start: &Vector<D>,
    ) -> (f64, Vector<D>, Vector<D>) {
        let free: Vec<usize> = (0..D).filter(|&k| start[k] != 0.0).collect();
        let sides: Vec<_> = free[1..].iter().map(|&k| [free[0], k]).collect();
        let slopes = |lambda: &Vector<D>| -> Vec<f64> {
            let p = x - self.point(facet, lambda);
            let of = sides
                .iter()
                .map(|&side| p.dot(&self.along(facet, lambda, side)));
            of.collect()
        };
        let mut lambda = *start;
        for _ in 0..12 {
            let now = slopes(&lambda);
            let columns = sides.iter().map(|&[a, b]| {
                let mut step = Vector::<D>::zeros();
                (step[a], step[b]) = (-1e-5, 1e-5);
                let (after, before) = (slopes(&(lambda + step)), slopes(&(lambda - step)));
                let difference = after.iter().zip(&before).map(|(a, b)| (a - b) / 2e-5);
                difference.collect::<Vec<_>>()
            });
            let J: Vec<Vec<f64>> = columns.collect();
            let step = match J.len() {
                0 => vec![],
                1 => vec![-now[0] / J[0][0]],
                _ => {
                    let det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
                    let first = (now[0] * J[1][1] - now[1] * J[1][0]) / -det;
                    vec![first, (now[1] * J[0][0] - now[0] * J[0][1]) / -det]
                }
            };
            for (&[a, b], s) in sides.iter().zip(step) {
                lambda[a] -= s;
                lambda[b] += s;
            }
        }
        let N = facet_shapes(self.order, &lambda);
        let normals = facet.iter().zip(N).map(|(&b, N)| self.averaged(b) * N);
        let n = normals.sum::<Vector<D>>().normalize();
        ((x - self.point(facet, &lambda)).dot(&n), lambda, n)
    }
}

/// The largest differences from what is expected.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    gap: f64,
    /// How far the search is from the foot.
    foot: f64,
    gradient: f64,
    hessian: f64,
    frozen: f64,
    rigid: f64,
    /// How many points were compared.
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
        // Newton's method on a curved facet ends where distances no longer differ
        assert!(self.gap < 1e-9 && self.foot < 1e-7, "{what}: {self:?}");
        assert!(self.gradient < 1e-9, "{what}: {self:?}");
        assert!(self.hessian < 1e-8, "{what}: {self:?}");
        assert!(self.frozen < 1e-8, "{what}: {self:?}");
        assert!(self.rigid < 1e-12, "{what}: {self:?}");
    }
}

/// Differences of fourth order: (coefficient, steps of this length).
const STEP: f64 = 3e-4;
const DIFFERENCE: [(f64, f64); 4] = [
    (1.0 / 12.0, -2.0),
    (-2.0 / 3.0, -1.0),
    (2.0 / 3.0, 1.0),
    (-1.0 / 12.0, 2.0),
];

/// Compares all derivatives of one stencil; its slave point is `xi` of facet 0.
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

/// Some number within `size` of 0.
fn bump(k: usize, size: f64) -> f64 {
    size * ((5 * k + 2) as f64).sin()
}

/// A bumpy, uneven master, whose facets are curved if quadratic.
fn master<const D: usize>(order: Order) -> (Vec<Vector<D>>, Vec<Vec<usize>>) {
    let mut x = Vec::new();
    let mut facets: Vec<Vec<usize>> = Vec::new();
    let count: usize = if D == 2 { 6 } else { 4 };
    for k in 0..count.pow(D as u32 - 1) {
        let at = [k % count, k / count];
        // a peak and a pit
        let height = match at {
            [1, 1] => 0.2,
            [2, 2] => -0.2,
            _ => bump(k, 0.15),
        };
        x.push(Vector::<D>::from_fn(|i, _| match i + 1 == D {
            true => height,
            false => at[i] as f64 + bump(k + 7 * i, 0.15),
        }));
    }
    for k in 0..x.len() {
        let (i, j) = (k % count, k / count);
        if D == 2 && i > 0 {
            facets.push(vec![k, k - 1]); // outward is up
        } else if D == 3 && i > 0 && j > 0 {
            facets.push(vec![k - count - 1, k - count, k]);
            facets.push(vec![k - count - 1, k, k - 1]);
        }
    }
    if order == Order::Quadratic {
        add_middles(&mut x, &mut facets);
    }
    (x, facets)
}

fn add_middles<const D: usize>(x: &mut Vec<Vector<D>>, facets: &mut [Vec<usize>]) {
    let mut middles = std::collections::HashMap::new();
    for facet in facets {
        for e in 0..D * (D - 1) / 2 {
            let [a, b] = facet_edge::<D>(e).map(|k| facet[k]);
            let node = *middles.entry([a.min(b), a.max(b)]).or_insert(x.len());
            if node == x.len() {
                let shift = Vector::from_fn(|i, _| bump(node + 3 * i, 0.06));
                x.push((x[a] + x[b]) * 0.5 + shift);
            }
            facet.push(node);
        }
    }
}

/// A slave facet, turned over, whose point `xi` is `height` away from `foot` along `up`.
fn over<const D: usize>(
    order: Order,
    foot: Vector<D>,
    up: Vector<D>,
    height: f64,
    xi: &Vector<D>,
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
    // counter-clockwise from above faces up; in the plane, left to right faces down
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
    };
    let shift = foot + up * height - case.point(&case.slave[0], xi);
    case.x[first..].iter_mut().for_each(|x| *x += shift);
    case
}

/// Projects the slave's one point, asks for the foot where it should be, and compares.
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
    let at = Master::new(&master, &case.x);
    let all = stencils(&slave, &at, &case.x, Integration::Gauss(1), 1.0);
    let found = all.first()?.projection();
    let same_pattern = (0..D).all(|k| (found.lambda[k] == 0.0) == (wanted[k] == 0.0));
    let on_a_side = wanted.iter().any(|&l| l == 0.0);
    // a side belongs to two facets
    let same_foot = (found.foot - case.point(&case.master[facet], wanted)).norm() < 1e-7;
    let same_facet = found.facet == facet || on_a_side;
    let counts_zeros = |v: &Vector<D>| v.iter().filter(|&&l| l == 0.0).count();
    let same = same_pattern || on_a_side && counts_zeros(&found.lambda) == counts_zeros(wanted);
    (same && same_foot && same_facet).then(|| compare(case, &master, &all[0], &xi))
}

/// The points λ of facets, each with what keeps the foot there: above and below.
fn battery<const D: usize>(order: Order, what: &str, lambdas: &[[f64; 3]], least: usize) {
    let mut errors = Errors::default();
    let rule = FacetRule::<D>::gauss(1);
    let xi = rule.points()[0].1;
    let (x, facets) = master::<D>(order);
    let plain = Case {
        order,
        x,
        slave: vec![],
        master: facets,
    };
    for lambda in lambdas {
        let mut wanted = Vector::<D>::from_fn(|k, _| lambda[k]);
        wanted /= wanted.sum();
        for (index, facet) in plain.master.iter().enumerate() {
            let foot = plain.point(facet, &wanted);
            let mut up = plain.facet_normal(facet, &wanted);
            if wanted.iter().any(|&l| l == 0.0) {
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
                let case = over(order, foot, up, height, &xi);
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
        battery::<2>(order, &format!("{order:?} inside"), &INSIDE, 14);
        battery::<2>(order, &format!("{order:?} near an end"), &NEAR_AN_END, 12);
        let ends = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        battery::<2>(order, &format!("{order:?} at an end"), &ends, 6);
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
    battery::<3>(order, &format!("{order:?} inside"), &INSIDE[..1], 12);
    battery::<3>(order, &format!("{order:?} near a side"), &NEAR_A_SIDE, 12);
    let sides = [[0.4, 0.6, 0.0], [0.0, 0.3, 0.7]];
    battery::<3>(order, &format!("{order:?} on a side"), &sides, 10);
    battery::<3>(
        order,
        &format!("{order:?} in a corner"),
        &[[1.0, 0.0, 0.0]],
        2,
    );
}

/// A channel whose sides face each other: facets around the foot share nodes with the slave's.
fn in_a_channel<const D: usize>(order: Order, least: usize) {
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
    let at = Master::new(&surface, &x);
    let xi = FacetRule::<D>::gauss(1).points()[0].1;
    let mut errors = Errors::default();
    for stencil in stencils(&surface, &at, &x, Integration::Gauss(1), 1.0) {
        let own: Vec<usize> = stencil.slave_shapes().map(|(a, _)| a).collect();
        let case = Case {
            order,
            x: x.clone(),
            slave: vec![own],
            master: master.clone(),
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
    errors.assert_small(&format!("{order:?} in a channel"), least);
}

#[test]
fn self_contact() {
    for order in [Order::Linear, Order::Quadratic] {
        in_a_channel::<2>(order, 2);
        in_a_channel::<3>(order, 4);
    }
}
