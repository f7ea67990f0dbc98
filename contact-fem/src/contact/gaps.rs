//! One role of one pair → rows of c(u) = C u + c₀ ≥ 0.

use contact_core::gaps::{LinearGaps, Row, RowKey, Sampling};

use super::cut::{Integration, Points};
use super::search::{Master, Own, Seeker};
use super::surface::Surface;
use crate::assembly::{Dof, DofMap};
use crate::element::facet_shapes;
use crate::tensor::Vector;

/// One role of a pair: `slave` must not penetrate `master`. Both are indices of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Whose nodes carry the constraints and whose facets the integration points.
    pub slave: usize,
    /// Whose surface is projected on.
    pub master: usize,
}

/// The dofs of all bodies as rows see them.
#[derive(Clone, Copy, Debug)]
pub struct Unknowns<'a> {
    /// Which dofs are unknowns of the optimiser, and which were eliminated.
    pub dofs: &'a DofMap,
    /// Which dofs the supports prescribe, eliminated or not.
    pub supports: &'a DofMap,
    /// The values of those eliminated (UL).
    pub prescribed: &'a [f64],
}

impl Unknowns<'_> {
    /// Whether all these dofs are prescribed.
    fn holds(&self, mut dofs: std::ops::Range<usize>) -> bool {
        dofs.all(|dof| matches!(self.supports.get(dof), Dof::Prescribed(_)))
    }
}

/// One constraint while it is being summed, over nodes: c = Σ_a coefficient_a · (X_a + u_a).
#[derive(Clone, Debug, Default)]
struct NodalRow<const D: usize> {
    /// (scene node, coefficient); a node may appear more than once until they are merged.
    terms: Vec<(usize, Vector<D>)>,
    /// a_i = Σ_q w_q φ_i(q) and Σ_q w_q |φ_i(q)| over the points that count.
    area: f64,
    magnitude: f64,
}

/// The constraints of one pass, linearised at current positions `x` of all scene nodes.
///
/// c_i(u) = 1/a_i Σ_q w_q φ_i(q) (x_q(u) − x̄_q(u))·n_q, equation (5) of the paper, with η*_q and
/// n_q frozen at `x` and w_q the weight times the reference measure. Sampled at points it is the
/// gap of one point, and a_i its w_q.
pub struct PassRows<const D: usize> {
    /// Scene nodes, or numbers of integration points.
    names: Vec<usize>,
    rows: Vec<NodalRow<D>>,
}

impl<const D: usize> PassRows<D> {
    /// Projects every point of `integration` on `slave` on `master`.
    pub fn new(
        slave: &Surface<D>,
        master: &Master<'_, D>,
        x: &[Vector<D>],
        integration: Integration,
        reach: f64,
        sampling: Sampling,
    ) -> Self {
        let mut names = match sampling {
            Sampling::Nodes => slave.nodes().to_vec(),
            Sampling::Points => Vec::new(),
        };
        let mut rows = vec![NodalRow::default(); names.len()];
        let mut number = 0;
        let same_body = slave.body() == master.surface().body();
        let positions = slave.gather(x);
        let facets = slave.facets_at(&positions);
        let mut rule = Points::new(integration, slave, master.surface());
        let facet_size = slave.facet_size();
        for ((nodes, facet), reference) in slave.facets().zip(facets).zip(slave.reference()) {
            let seeker = |lambda: &Vector<D>| Seeker {
                x: facet.point(lambda),
                facing: facet.normal(lambda),
                reach,
                X: reference.point(lambda),
                N: reference.normal(lambda),
                facet_size,
                own: same_body.then_some(Own {
                    surface: slave,
                    nodes,
                }),
            };
            for (weight, lambda) in rule.on(&facet, master, &seeker) {
                number += 1;
                let Some(p) = master.find(&seeker(lambda)) else {
                    continue;
                };
                // x_q − x̄_q as a sum over nodes
                let own = nodes.iter().map(|&a| slave.nodes()[a]);
                let own = own.zip(facet_shapes(slave.order(), lambda));
                let surface = master.surface();
                let other = surface.facet(p.facet).iter().map(|&b| surface.nodes()[b]);
                let other = other.zip(facet_shapes(surface.order(), &p.lambda).map(|N| -N));
                let terms = own.chain(other).map(|(a, N)| (a, p.normal * N));
                let w = weight * reference.normal(lambda).norm();
                match sampling {
                    Sampling::Nodes => {
                        let tests = nodes.iter().zip(slave.test_functions(lambda));
                        for (&i, phi) in tests.take(slave.test_nodes()) {
                            rows[i].add(w * phi, terms.clone());
                        }
                    }
                    Sampling::Points => {
                        let mut row = NodalRow::default();
                        row.add(w, terms);
                        names.push(number - 1);
                        rows.push(row);
                    }
                }
            }
        }
        rows.iter_mut().for_each(NodalRow::normalize);
        PassRows { names, rows }
    }

    /// Appends the rows that have support and can move to `gaps`, split into free and prescribed
    /// unknowns.
    pub fn append(
        &self,
        pass: u32,
        X: &[Vector<D>],
        unknowns: &Unknowns<'_>,
        gaps: &mut LinearGaps,
    ) {
        let mut row = Row::default();
        for (&node, nodal) in self.names.iter().zip(&self.rows) {
            let held = |(a, _): &(usize, _)| unknowns.holds(D * a..D * (a + 1));
            if !nodal.has_support() || nodal.terms.iter().all(held) {
                continue;
            }
            row.free.clear();
            row.prescribed.clear();
            row.constant = 0.0;
            row.weight = nodal.area;
            for (a, coefficient) in &nodal.terms {
                row.constant += coefficient.dot(&X[*a]);
                for (i, &c) in coefficient.iter().enumerate() {
                    match unknowns.dofs.get(D * a + i) {
                        Dof::Free(j) => row.free.push((j, c)),
                        Dof::Prescribed(j) => {
                            row.constant += c * unknowns.prescribed[j];
                            row.prescribed.push((j, c));
                        }
                    }
                }
            }
            let node = node as u32;
            gaps.push(RowKey { pass, node }, &row);
        }
    }
}

impl<const D: usize> NodalRow<D> {
    /// Adds a point of weight `w`, whose gap is the sum of `terms`.
    fn add(&mut self, w: f64, terms: impl Iterator<Item = (usize, Vector<D>)>) {
        self.area += w;
        self.magnitude += w.abs();
        self.terms.extend(terms.map(|(a, c)| (a, c * w)));
    }

    /// Whether enough points count for a_i to be a weight. A corner's quadratic function is
    /// negative on the far half of a segment: where the master ends between, its mean there is no
    /// mean of gaps. Over a whole segment area and magnitude are as 2 to 3.
    fn has_support(&self) -> bool {
        self.area > self.magnitude / 3.0
    }

    /// Merges the terms of each node and divides by a_i, so that c_i is a length and λ_i a force.
    fn normalize(&mut self) {
        self.terms.sort_unstable_by_key(|term| term.0);
        self.terms.dedup_by(|term, kept| {
            let same = term.0 == kept.0;
            if same {
                kept.1 += term.1;
            }
            same
        });
        for term in &mut self.terms {
            term.1 /= self.area;
        }
    }
}

/// The nodes of `slave` inside `master` as (position in [`Surface::nodes`], gap < 0). They are
/// projected at positions `x`, those of `master`; the gaps are between positions `now`, which are
/// others where the geometry is frozen. On its own body a node looks no further than `reach`.
pub fn nodes_inside<const D: usize>(
    slave: &Surface<D>,
    slave_normals: &[Vector<D>],
    master: &Master<'_, D>,
    x: &[Vector<D>],
    now: &[Vector<D>],
    reach: f64,
) -> Vec<(usize, f64)> {
    let same_body = slave.body() == master.surface().body();
    let numbers: Vec<usize> = (0..slave.nodes().len()).collect();
    let facet_size = slave.facet_size();
    let gap = |(k, facing): (usize, &Vector<D>)| {
        let node = slave.nodes()[k];
        let p = master.find(&Seeker {
            x: x[node],
            facing: *facing,
            reach: if same_body { reach } else { f64::INFINITY },
            X: slave.reference_nodes()[k],
            N: slave.reference_normals()[k],
            facet_size,
            own: same_body.then_some(Own {
                surface: slave,
                nodes: &numbers[k..=k],
            }),
        })?;
        let surface = master.surface();
        let nodes = surface.facet(p.facet).iter().map(|&b| surface.nodes()[b]);
        let shapes = facet_shapes(surface.order(), &p.lambda);
        let foot: Vector<D> = nodes.zip(shapes).map(|(b, N)| now[b] * N).sum();
        let gap = (now[node] - foot).dot(&p.normal);
        (gap < 0.0).then_some((k, gap))
    };
    slave_normals.iter().enumerate().filter_map(gap).collect()
}
