//! One role of one pair → rows of c(u) = C u + c₀ ≥ 0.

use contact_core::gaps::{LinearGaps, Row, RowKey};

use super::integration::FacetRule;
use super::projection::interpolate;
use super::search::{Master, Projection};
use super::surface::Surface;
use crate::assembly::{Dof, DofMap};
use crate::tensor::{Vector, facet_normal};

/// One role of a pair: `slave` must not penetrate `master`. Both are indices of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Whose nodes carry the constraints and whose facets the integration points.
    pub slave: usize,
    /// Whose surface is projected on.
    pub master: usize,
}

/// One constraint while it is being summed, over nodes: c = Σ_a coefficient_a · (X_a + u_a).
#[derive(Clone, Debug, Default)]
struct NodalRow<const D: usize> {
    /// (scene node, coefficient); a node may appear more than once until they are merged.
    terms: Vec<(usize, Vector<D>)>,
    /// a_i = Σ_q w_q φ_i(q) over the points that count.
    area: f64,
}

/// Whether an integration point on a slave facet with unit normal `facing` counts: its projection
/// is within `reach`, not off the master's end, and faces it.
fn counts<const D: usize>(p: &Projection<D>, facing: &Vector<D>, reach: f64) -> bool {
    p.distance <= reach && !p.off_the_end && facing.dot(&p.normal) < 0.0
}

/// The constraints of one pass, linearised at current positions `x` of all scene nodes.
///
/// c_i(u) = 1/a_i Σ_q w_q φ_i(q) (x_q(u) − x̄_q(u))·n_q, equation (5) of the paper, with η*_q and
/// n_q frozen at `x` and w_q the weight times the reference measure.
pub struct PassRows<const D: usize> {
    rows: Vec<NodalRow<D>>,
    /// Integration points in all, and those that counted.
    points: (usize, usize),
}

impl<const D: usize> PassRows<D> {
    /// Projects every integration point of `slave` on `master`.
    pub fn new(
        slave: &Surface<D>,
        master: &Master<'_, D>,
        x: &[Vector<D>],
        rule: &FacetRule<D>,
        reach: f64,
    ) -> Self {
        let mut rows = vec![NodalRow::default(); slave.nodes().len()];
        let mut points = (0, 0);
        for (facet, &measure) in slave.facets().iter().zip(slave.measures()) {
            let corners = facet.map(|a| x[a]);
            let facing = facet_normal(&corners);
            let local = facet.map(|a| slave.local(a));
            for (weight, N) in rule.points() {
                points.0 += 1;
                let x_q = interpolate(N, &corners);
                let projection = master.project(&x_q).filter(|p| counts(p, &facing, reach));
                let Some(p) = projection else { continue };
                points.1 += 1;
                let across = &master.surface().facets()[p.facet];
                for i in 0..D {
                    // linear facets: the test functions φ_i are the shape functions N_i
                    let w = weight * measure * N[i];
                    let row = &mut rows[local[i]];
                    row.area += w;
                    let own = facet.iter().zip(N.iter());
                    row.terms
                        .extend(own.map(|(&a, N_a)| (a, p.normal * (w * N_a))));
                    let other = across.iter().zip(p.lambda.iter());
                    row.terms
                        .extend(other.map(|(&b, N_b)| (b, p.normal * (-w * N_b))));
                }
            }
        }
        rows.iter_mut().for_each(NodalRow::normalize);
        PassRows { rows, points }
    }

    /// Integration points in all, and those that counted.
    pub fn points(&self) -> (usize, usize) {
        self.points
    }

    /// Appends the rows that have support to `gaps`, split into free and prescribed unknowns.
    pub fn append(
        &self,
        pass: u32,
        slave: &Surface<D>,
        X: &[Vector<D>],
        dofs: &DofMap,
        prescribed: &[f64],
        gaps: &mut LinearGaps,
    ) {
        let mut row = Row::default();
        for (&node, nodal) in slave.nodes().iter().zip(&self.rows) {
            if nodal.terms.is_empty() {
                continue;
            }
            row.free.clear();
            row.prescribed.clear();
            row.constant = 0.0;
            for (a, coefficient) in &nodal.terms {
                row.constant += coefficient.dot(&X[*a]);
                for (i, &c) in coefficient.iter().enumerate() {
                    match dofs.get(D * a + i) {
                        Dof::Free(j) => row.free.push((j, c)),
                        Dof::Prescribed(j) => {
                            row.constant += c * prescribed[j];
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

/// The nodes of `slave` inside `master`: the deepest one as (scene node, gap < 0), or `None`.
pub fn deepest_node<const D: usize>(
    slave: &Surface<D>,
    slave_normals: &[Vector<D>],
    master: &Master<'_, D>,
    x: &[Vector<D>],
) -> Option<(usize, f64)> {
    let gap = |(&node, facing): (&usize, &Vector<D>)| {
        let p = master.project(&x[node])?;
        (counts(&p, facing, f64::INFINITY) && p.gap < 0.0).then_some((node, p.gap))
    };
    let inside = slave.nodes().iter().zip(slave_normals).filter_map(gap);
    inside.min_by(|a, b| a.1.total_cmp(&b.1))
}
