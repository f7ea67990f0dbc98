//! An independent evaluation of the gap from its definition, on bumpy surfaces, and difference
//! formulas.

use crate::contact::Projection;
use crate::element::{Order, facet_edge, facet_shapes};
use crate::tensor::Vector;

/// A facet of a slave over a master, with the positions of all nodes.
pub(super) struct Case<const D: usize> {
    pub order: Order,
    pub x: Vec<Vector<D>>,
    pub slave: Vec<Vec<usize>>,
    pub master: Vec<Vec<usize>>,
    pub by: Projection,
}

/// The definition; of the tested code it uses only the shape functions.
impl<const D: usize> Case<D> {
    pub fn point(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        let N = facet_shapes(self.order, lambda);
        facet.iter().zip(N).map(|(&a, N)| self.x[a] * N).sum()
    }

    /// The derivative along λ_b − λ_a, by a difference that is exact for quadratics.
    fn along(&self, facet: &[usize], lambda: &Vector<D>, [a, b]: [usize; 2]) -> Vector<D> {
        let mut step = Vector::zeros();
        (step[a], step[b]) = (-0.5, 0.5);
        self.point(facet, &(lambda + step)) - self.point(facet, &(lambda - step))
    }

    pub fn facet_normal(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        self.measure(facet, lambda).normalize()
    }

    /// The outward normal; its length is the measure of the tangent facet.
    pub fn measure(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
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

    /// n at λ on a facet.
    pub fn normal(&self, facet: &[usize], lambda: &Vector<D>) -> Vector<D> {
        let N = facet_shapes(self.order, lambda);
        let normals = facet.iter().zip(N).map(|(&b, N)| self.averaged(b) * N);
        normals.sum::<Vector<D>>().normalize()
    }

    /// g, λ* and n of a point x_q over a facet of the master. λ* may leave the facet, so that g stays smooth; as the closest point
    /// it stays on the side of the facet on which `start` is. Along normals, no part of p is across n; that part is
    /// across the facet only where n is along it.
    pub fn gap(
        &self,
        x: &Vector<D>,
        facet: &[usize],
        start: &Vector<D>,
    ) -> (f64, Vector<D>, Vector<D>) {
        let is_free = |k: &usize| start[*k] != 0.0 || self.by == Projection::AlongNormals;
        let free: Vec<usize> = (0..D).filter(is_free).collect();
        let sides: Vec<_> = free[1..].iter().map(|&k| [free[0], k]).collect();
        let slopes = |lambda: &Vector<D>| -> Vec<f64> {
            let mut p = x - self.point(facet, lambda);
            if self.by == Projection::AlongNormals {
                let n = self.normal(facet, lambda);
                p -= n * n.dot(&p);
            }
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
        let n = self.normal(facet, &lambda);
        ((x - self.point(facet, &lambda)).dot(&n), lambda, n)
    }
}

/// Differences of fourth order: (coefficient, multiple of the step).
pub(super) const STEP: f64 = 3e-4;
pub(super) const DIFFERENCE: [(f64, f64); 4] = [
    (1.0 / 12.0, -2.0),
    (-2.0 / 3.0, -1.0),
    (2.0 / 3.0, 1.0),
    (-1.0 / 12.0, 2.0),
];

/// A random number within `size` of 0.
pub(super) fn bump(k: usize, size: f64) -> f64 {
    size * ((5 * k + 2) as f64).sin()
}

/// A bumpy master with facets of unequal size, curved if quadratic.
pub(super) fn master<const D: usize>(order: Order) -> (Vec<Vector<D>>, Vec<Vec<usize>>) {
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

pub(super) fn add_middles<const D: usize>(x: &mut Vec<Vector<D>>, facets: &mut [Vec<usize>]) {
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
