//! Mortar interpolation between two surfaces that are tied: ∫ ψ_i (u − ū) = 0 for the slave's nodes i.
//!
//! ψ_i are dual to the slave's shape functions, ∫ ψ_i φ_k = δ_ik ∫ φ_k on each facet, so that the slave's displacements are
//! explicit in those of the master (B. I. Wohlmuth, *A mortar finite element method using dual spaces for the Lagrange
//! multiplier*, SIAM J. Numer. Anal. 38, 2000). The integrals are those of the reference configuration, over the pieces into
//! which both meshes cut each other.
//!
//! Quadratic triangles, whose corner functions have mean zero, get a basis of other functions first: φ_v + α Σ φ_e over the
//! edges e at the corner v, and (1 − 2α) φ_e (A. Popp, B. I. Wohlmuth, M. W. Gee and W. A. Wall, *Dual quadratic mortar finite
//! element methods for 3D finite deformation contact*, SIAM J. Sci. Comput. 34, 2012). α = 1/12 lets the corners' ψ integrate
//! linear functions as their value there.
//!
//! Nodes that something else determines, such as supports, have no ψ. On facets with such nodes the ψ of the others are
//! dual within a space that still has the constants, so that constant stresses pass; a facet all of whose nodes are such ones is
//! added to the ψ of a node nearby.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::cut::Points;
use super::search::{Master, Seeker};
use super::surface::Surface;
use crate::element::{FacetShapes, MAX_FACET_NODES, Order, facet_edge, facet_shapes};
use crate::tensor::Vector;

/// The part of a corner in the functions of the edges of a quadratic triangle.
const ALPHA: f64 = 1.0 / 12.0;

/// A point of the slave with its closest point of the master.
struct Point<const D: usize> {
    weight: f64,
    /// N_a of the slave's facet, and N_b of the master's.
    own: FacetShapes,
    other: FacetShapes,
    facet: usize,
}

/// Both surfaces in the reference configuration, with all points of their common pieces.
pub(crate) struct Tied<'a, const D: usize> {
    slave: &'a Surface<D>,
    master: &'a Surface<D>,
    points: Vec<Vec<Point<D>>>,
    /// The largest distance of a point from the master, and where (UL).
    pub apart: (f64, Vector<D>),
    /// The smallest share of a facet that has points of the master in reach, and where.
    pub covered: (f64, Vector<D>),
}

/// The displacement of a slave's node: Σ c u of the master's nodes, and of the slave's own that have no ψ.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interpolated {
    /// The node, by its scene number.
    pub node: usize,
    /// (scene node, coefficient); the coefficients sum to 1.
    pub terms: Vec<(usize, f64)>,
}

impl<'a, const D: usize> Tied<'a, D> {
    /// Points further than `reach` (UL) from the master are without a counterpart.
    pub fn new(slave: &'a Surface<D>, master: &'a Master<D>, reach: f64) -> Self {
        let facet_size = slave.facet_size();
        let other = master.surface();
        let shapes = slave.order().degree().max(other.order().degree());
        let is_flat = |surface: &Surface<D>| surface.reference().iter().all(|f| f.is_flat());
        // curved facets have measures that are not constant
        let more = if is_flat(slave) && is_flat(other) {
            0
        } else {
            2
        };
        let mut rule = Points::exact(slave.order().degree() + shapes + more);
        let (mut apart, mut covered) = ((0.0, Vector::zeros()), (1.0, Vector::zeros()));
        let mut points = Vec::with_capacity(slave.len());
        for facet in slave.reference() {
            let seeker = |lambda: &Vector<D>| Seeker {
                x: facet.point(lambda),
                facing: facet.normal(lambda),
                reach,
                X: facet.point(lambda),
                N: facet.normal(lambda),
                facet_size,
                own: None,
                reaches_beyond: false,
            };
            let (mut own, mut found, mut all) = (Vec::new(), 0.0, 0.0);
            rule.cut(facet, master, &seeker);
            for place in rule.places() {
                let (seeker, lambda) = (seeker(&place.lambda), &place.lambda);
                let weight = place.weight * seeker.N.norm();
                all += weight;
                let Some(foot) = master.find(&seeker) else {
                    continue;
                };
                found += weight;
                if foot.distance > apart.0 {
                    apart = (foot.distance, seeker.x);
                }
                own.push(Point {
                    weight,
                    own: facet_shapes(slave.order(), lambda),
                    other: facet_shapes(other.order(), &foot.lambda),
                    facet: foot.facet,
                });
            }
            if !(found >= covered.0 * all) {
                covered = (found / all, facet.point(&Vector::repeat(1.0 / D as f64)));
            }
            points.push(own);
        }
        Tied {
            slave,
            master: other,
            points,
            apart,
            covered,
        }
    }

    /// The displacements of the slave's nodes, for one component; `is_out` tells of a scene node of the slave whether
    /// something else determines it. The middle of an edge is only out together with its ends.
    ///
    /// # Errors
    /// The position (UL) of a facet without a node that is not out, on it or around it, or that no rule resolves.
    pub fn interpolation(
        &self,
        is_out: impl Fn(usize) -> bool,
    ) -> Result<Vec<Interpolated>, Vector<D>> {
        let nodes = self.slave.nodes();
        let mut out: Vec<bool> = nodes.iter().map(|&node| is_out(node)).collect();
        let is_changed = D == 3 && self.slave.order() == Order::Quadratic;
        if is_changed {
            for facet in self.slave.facets() {
                for (e, &middle) in facet[D..].iter().enumerate() {
                    if out[middle] {
                        facet_edge::<D>(e)
                            .into_iter()
                            .for_each(|k| out[facet[k]] = true);
                    }
                }
            }
        }
        let mut diagonal = vec![0.0; nodes.len()];
        // by scene nodes of the master, and by own nodes without ψ
        let mut of_master = vec![BTreeMap::<usize, f64>::new(); nodes.len()];
        let mut of_own = vec![BTreeMap::<usize, f64>::new(); nodes.len()];
        for (index, (facet, points)) in self.slave.facets().zip(&self.points).enumerate() {
            let dual = dual::<D>(points, facet, &out, is_changed);
            let dual = dual.or_else(|| self.of_neighbour(facet, &out));
            let Some((kept, dual)) = dual else {
                return Err(self.slave.reference()[index].point(&Vector::repeat(1.0 / D as f64)));
            };
            for point in points {
                let own = basis::<D>(&point.own, facet.len(), is_changed);
                let psi = values(&dual, &own, facet.len());
                let master = self.master.facet(point.facet);
                for (&k, psi) in kept.iter().zip(&psi) {
                    let weighted = point.weight * psi;
                    for (&b, N) in master.iter().zip(&point.other) {
                        let node = self.master.nodes()[b];
                        *of_master[k].entry(node).or_default() += weighted * N;
                    }
                    for (&a, phi) in facet.iter().zip(&own) {
                        if out[a] {
                            *of_own[k].entry(a).or_default() += weighted * phi;
                        } else if a == k {
                            diagonal[k] += point.weight * phi;
                        }
                    }
                }
            }
        }
        let ends = match is_changed {
            true => self.ends(),
            false => vec![None; nodes.len()],
        };
        // coefficients of the changed basis by scene nodes
        let changed: Vec<BTreeMap<usize, f64>> = (0..nodes.len())
            .map(|a| {
                let mut terms = BTreeMap::new();
                let mut add = |node: usize, c: f64| *terms.entry(node).or_default() += c;
                if out[a] {
                    unchanged(a, ends[a])
                        .into_iter()
                        .for_each(|(b, c)| add(nodes[b], c));
                    return terms;
                }
                of_master[a]
                    .iter()
                    .for_each(|(&node, c)| add(node, c / diagonal[a]));
                for (&b, c) in &of_own[a] {
                    let own = unchanged(b, ends[b]).into_iter();
                    own.for_each(|(b, share)| add(nodes[b], -share * c / diagonal[a]));
                }
                terms
            })
            .collect();
        let kept = (0..nodes.len()).filter(|&a| !out[a]);
        let interpolated = kept.map(|a| {
            let mut terms = BTreeMap::<usize, f64>::new();
            let shares = match ends[a] {
                Some([v, w]) => vec![(a, 1.0 - 2.0 * ALPHA), (v, ALPHA), (w, ALPHA)],
                None => vec![(a, 1.0)],
            };
            for (b, share) in shares {
                for (&node, c) in &changed[b] {
                    *terms.entry(node).or_default() += share * c;
                }
            }
            // round-off of integrals that vanish
            let terms = terms.into_iter().filter(|(_, c)| c.abs() > 1e-15);
            Interpolated {
                node: nodes[a],
                terms: terms.collect(),
            }
        });
        Ok(interpolated.collect())
    }

    /// ψ = 1 on a facet without a node of its own, for the nearest node with a ψ on the facets around it.
    fn of_neighbour(&self, facet: &[usize], out: &[bool]) -> Option<(Vec<usize>, DMatrix<f64>)> {
        if !facet.iter().all(|&a| out[a]) {
            return None;
        }
        let X = self.slave.reference_nodes();
        let centre = facet[..D].iter().map(|&a| X[a]).sum::<Vector<D>>() / D as f64;
        let around = facet.iter().flat_map(|&a| self.slave.facets_around(a));
        let nodes = around.flat_map(|(f, _)| self.slave.facet(f).iter().copied());
        let kept = nodes.filter(|&a| !out[a]);
        let nearest = kept.min_by(|&a, &b| {
            let [a, b] = [a, b].map(|a| (X[a] - centre).norm());
            a.total_cmp(&b)
        });
        Some((vec![nearest?], DMatrix::repeat(1, facet.len(), 1.0)))
    }

    /// The ends of the edge that each node is the middle of.
    fn ends(&self) -> Vec<Option<[usize; 2]>> {
        let mut ends = vec![None; self.slave.nodes().len()];
        for facet in self.slave.facets() {
            for (e, &middle) in facet[D..].iter().enumerate() {
                ends[middle] = Some(facet_edge::<D>(e).map(|k| facet[k]));
            }
        }
        ends
    }
}

/// The coefficient of the changed basis at a node by the displacements of nodes.
fn unchanged(a: usize, ends: Option<[usize; 2]>) -> Vec<(usize, f64)> {
    let own = 1.0 / (1.0 - 2.0 * ALPHA);
    match ends {
        Some([v, w]) => vec![(a, own), (v, -ALPHA * own), (w, -ALPHA * own)],
        None => vec![(a, 1.0)],
    }
}

/// The functions of the basis at a point with shape functions N.
fn basis<const D: usize>(N: &FacetShapes, len: usize, is_changed: bool) -> FacetShapes {
    let mut phi = *N;
    if is_changed {
        for e in 0..len - D {
            facet_edge::<D>(e)
                .into_iter()
                .for_each(|k| phi[k] += ALPHA * N[D + e]);
            phi[D + e] *= 1.0 - 2.0 * ALPHA;
        }
    }
    phi
}

/// ψ of the nodes with one.
fn values(dual: &DMatrix<f64>, phi: &FacetShapes, len: usize) -> [f64; MAX_FACET_NODES] {
    let mut psi = [0.0; MAX_FACET_NODES];
    for (k, psi) in psi.iter_mut().enumerate().take(dual.nrows()) {
        *psi = (0..len).map(|a| dual[(k, a)] * phi[a]).sum();
    }
    psi
}

/// The nodes of a facet that have a ψ (positions in the surface), and the coefficients of each in the functions of all nodes; `None` if there is none.
fn dual<const D: usize>(
    points: &[Point<D>],
    facet: &[usize],
    out: &[bool],
    is_changed: bool,
) -> Option<(Vec<usize>, DMatrix<f64>)> {
    let len = facet.len();
    let kept: Vec<usize> = (0..len).filter(|&k| !out[facet[k]]).collect();
    let gone: Vec<usize> = (0..len).filter(|&k| out[facet[k]]).collect();
    if kept.is_empty() {
        return None;
    }
    // the functions of the kept nodes, with those of the others shared out, sum to 1
    let mut shared = DMatrix::zeros(kept.len(), len);
    for (row, &k) in kept.iter().enumerate() {
        shared[(row, k)] = 1.0;
        for &e in &gone {
            shared[(row, e)] = match (D, len, gone.len()) {
                // all linear functions on a quadratic segment without one end
                (2, 3, 1) if e < 2 => {
                    if k == 2 {
                        2.0
                    } else {
                        -1.0
                    }
                }
                _ => 1.0 / kept.len() as f64,
            };
        }
    }
    let mut mixed = DMatrix::<f64>::zeros(kept.len(), kept.len());
    let mut integrals = vec![0.0; kept.len()];
    for point in points {
        let phi = basis::<D>(&point.own, len, is_changed);
        let test = values(&shared, &phi, len);
        for (l, &k) in kept.iter().enumerate() {
            integrals[l] += point.weight * phi[k];
            (0..kept.len()).for_each(|m| mixed[(m, l)] += point.weight * test[m] * phi[k]);
        }
    }
    let inverse = mixed.try_inverse()?;
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |k, m| {
        integrals[k] * inverse[(k, m)]
    });
    let is_finite = scaled.iter().all(|c: &f64| c.is_finite());
    let nodes = kept.iter().map(|&k| facet[k]).collect();
    is_finite.then(|| (nodes, scaled * shared))
}
