//! The rows of c(u) = C u + c₀ ≥ 0 from one pass, and how their nodes slip.

use std::collections::HashMap;

use contact_core::friction::{SlipRow, SlipRows};
use contact_core::gaps::{LinearGaps, Row, RowKey, Sampling};

use super::corner::Corner;
use super::edge::Crossing;
use super::moving::Moving;
use super::search::FootPoint;
use super::stencil::{Against, Projected, Stencil};
use super::surface::Surface;
use super::weighing::{self, Weighing};
use crate::assembly::{Dof, DofMap};
use crate::tensor::{Vector, turned};

/// One pass of a pair: `slave` must not penetrate `master`. Both are indices of surfaces. The obstacles of a scene are numbered
/// after its surfaces; they are never slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// The surface whose nodes carry the constraints and whose facets carry the integration points.
    pub slave: usize,
    /// The surface, or the obstacle, on which the points are projected.
    pub master: usize,
}

/// The dofs of all bodies, as the rows need them.
#[derive(Clone, Copy, Debug)]
pub struct Unknowns<'a> {
    /// For each dof, whether it is an unknown of the optimiser or eliminated.
    pub dofs: &'a DofMap,
    /// For each dof, whether it is prescribed, eliminated or not.
    pub supports: &'a DofMap,
    /// The values of the eliminated dofs (UL).
    pub prescribed: &'a [f64],
}

impl Unknowns<'_> {
    /// What varies with a dof that is prescribed but for those that add to it.
    fn tied(&self, dof: usize) -> impl Iterator<Item = (usize, f64)> {
        let is_any = !self.dofs.ties().is_empty();
        is_any.then(|| self.dofs.slopes(dof)).into_iter().flatten()
    }

    /// Adds Σ coefficient · (X + u) of these nodes to a row.
    fn split<const D: usize>(&self, terms: &[(usize, Vector<D>)], X: &[Vector<D>], row: &mut Row) {
        let mut is_tied = false;
        for (a, coefficient) in terms {
            row.constant += coefficient.dot(&X[*a]);
            #[cfg(planted)]
            if contact_core::planted!("rows take places at rest a thousandth off") {
                row.constant += 0.001 * coefficient.dot(&X[*a]);
            }
            for (i, &c) in coefficient.iter().enumerate() {
                #[cfg(planted)]
                let c = match i {
                    0 if contact_core::planted!(
                        "the first component of rows is a hundredth larger"
                    ) =>
                    {
                        1.01 * c
                    }
                    _ => c,
                };
                match self.dofs.get(D * a + i) {
                    Dof::Free(j) => row.free.push((j, c)),
                    Dof::Prescribed(j) => {
                        row.constant += c * self.prescribed[j];
                        row.prescribed.push((j, c));
                        for (j, slope) in self.tied(D * a + i) {
                            row.free.push((j, slope * c));
                            is_tied = true;
                        }
                    }
                }
            }
        }
        if is_tied {
            merge(&mut row.free);
        }
    }

    /// Whether all these dofs are prescribed, and none of them varies with a free dof.
    fn holds(&self, mut dofs: std::ops::Range<usize>) -> bool {
        let is_held = |dof| matches!(self.supports.get(dof), Dof::Prescribed(_));
        dofs.all(|dof| is_held(dof) && self.tied(dof).next().is_none())
    }
}

/// Rows lean on their neighbours where less than this share of their test function is opposite the master.
const LEANS: f64 = 0.25;

/// One constraint during summation, in terms of nodes: c = Σ_a coefficient_a · (X_a + u_a) + constant.
#[derive(Clone, Debug, Default)]
struct NodalRow<const D: usize> {
    /// (scene node, coefficient); a node may appear more than once until they are merged.
    terms: Vec<(usize, Vector<D>)>,
    /// a_i = Σ_q w_q φ_i(q) over the points that count.
    area: f64,
    /// What the terms leave out of the gap (UL).
    constant: f64,
    /// What is added to the gap (UL).
    widening: f64,
}

/// For each scene node, one more than the place of its term in the row that is being merged; 0 elsewhere.
#[derive(Default)]
struct Places(Vec<u32>);

impl Places {
    /// Adds up the terms of each node, sorted by node.
    fn merge<const D: usize>(&mut self, terms: &mut Vec<(usize, Vector<D>)>) {
        let most = terms.iter().map(|(a, _)| *a).max();
        let nodes = most.map_or(0, |most| most + 1);
        if self.0.len() < nodes {
            self.0.resize(nodes, 0);
        }
        let mut kept = 0;
        for k in 0..terms.len() {
            let (a, c) = terms[k];
            match self.0[a] {
                0 => {
                    terms[kept] = (a, c);
                    kept += 1;
                    self.0[a] = kept as u32;
                }
                place => terms[place as usize - 1].1 += c,
            }
        }
        terms.truncate(kept);
        terms.iter().for_each(|(a, _)| self.0[*a] = 0);
        terms.sort_unstable_by_key(|(a, _)| *a);
    }
}

/// The derivatives of a row by the weight w of one of its points, whose unit is that of its area (UL in the plane, UL² in space).
pub(super) struct Weighed<const D: usize> {
    /// The row's [`RowKey::node`].
    pub name: usize,
    /// ∂c_i/∂w, with c_i of equation (5) (UL divided by the unit of w).
    pub gap: f64,
    /// ∂/∂w of the coefficients of c_i, by scene node (1 divided by the unit of w). A node may occur more than once: its terms add up.
    pub terms: Vec<(usize, Vector<D>)>,
}

/// The constraints of one pass, linearised at current positions `x` of all scene nodes.
///
/// c_i(u) = 1/a_i Σ_q w_q φ_i(q) (x_q(u) − x̄_q(u))·n_q, equation (5) of the paper, with η*_q and
/// n_q frozen at `x` and w_q the weight times the reference measure. With sampling at points, each
/// row is the gap of one point, and a_i its w_q.
///
/// # Rims
///
/// Where the master ends, a_i is less than A_i = ∫ φ_i, and it may fall to zero as the bodies slide. A row that left then would
/// leave with its force. Below a_i = A_i/4, therefore, a row leans on its neighbours j: with s_i = 4 a_i/A_i, from 0 to 1, its test function
/// is
///
/// s_i φ_i + (1 − s_i) Σ_j s_j φ_j,
///
/// so that a row that leaves has become one of its neighbours. Corner functions of a quadratic segment are negative on its far half,
/// where a_i may be negative and s_i is 0.
pub struct PassRows<'a, const D: usize> {
    sampling: Sampling,
    stencils: Vec<Stencil<'a, D>>,
    /// The keys of the rows: scene nodes, or numbers of integration points.
    names: Vec<usize>,
    rows: Vec<NodalRow<D>>,
    leaning: Leaning<D>,
    /// Stencils from this one on are corners; their rows follow the rows that are means over facets.
    first_corner: usize,
    /// Edges that cross; the last rows are theirs.
    crossings: Vec<Crossing<D>>,
}

/// The rows that lean on their neighbours.
#[derive(Default)]
struct Leaning<const D: usize> {
    /// s_i of every row; empty where none leans.
    own: Vec<f64>,
    /// ds_i/da_i.
    slopes: Vec<f64>,
    /// The rows without leaning, not divided by a_i.
    bare: Vec<NodalRow<D>>,
    /// (j, i, (1 − s_i) s_j): test function j is a part of row i. Ascending.
    on: Vec<(usize, usize, f64)>,
}

impl<const D: usize> Leaning<D> {
    /// For rows with these a_i.
    fn new(slave: &Surface<D>, rows: &[NodalRow<D>]) -> Self {
        let areas = rows.iter().zip(slave.test_areas());
        let own = areas.map(|(row, whole)| (row.area / (LEANS * whole)).clamp(0.0, 1.0));
        let own: Vec<f64> = own.collect();
        let mut on = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            if own[i] < 1.0 && !row.terms.is_empty() {
                let others = slave.test_neighbours(i).into_iter();
                let others = others.map(|j| (j, i, (1.0 - own[i]) * own[j]));
                on.extend(others.filter(|(.., share)| *share > 0.0));
            }
        }
        on.sort_unstable_by_key(|(j, i, _)| (*j, *i));
        let slopes = own.iter().zip(slave.test_areas());
        let slopes = slopes.map(|(s, whole)| match 0.0 < *s && *s < 1.0 {
            true => 1.0 / (LEANS * whole),
            false => 0.0,
        });
        match own
            .iter()
            .zip(rows)
            .all(|(s, row)| *s == 1.0 || row.terms.is_empty())
        {
            true => Leaning::default(),
            false => Leaning {
                slopes: slopes.collect(),
                bare: Vec::new(),
                own,
                on,
            },
        }
    }

    /// The rows of which test function `j` is a part, and with what factors.
    fn rows_of(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let own = self.own.get(j).copied().unwrap_or(1.0);
        let first = self.on.partition_point(|(k, ..)| *k < j);
        let others = self.on[first..].iter().take_while(move |(k, ..)| *k == j);
        let others = others.map(|(_, i, share)| (*i, *share));
        std::iter::once((j, own))
            .filter(|(_, s)| *s > 0.0)
            .chain(others)
    }
}

impl<'a, const D: usize> PassRows<'a, D> {
    /// Of the `points` projected from `slave` to what it is `against`.
    pub fn new(
        slave: &'a Surface<D>,
        against: impl Into<Against<'a, D>>,
        points: &[Projected<D>],
        sampling: Sampling,
    ) -> Self {
        let (against, points) = (against.into(), points.iter());
        let stencils: Vec<_> = points
            .map(|point| Stencil::new(slave, against, *point))
            .collect();
        let names = match sampling {
            Sampling::Nodes => slave.nodes().to_vec(),
            Sampling::Points => stencils.iter().map(Stencil::number).collect(),
        };
        let mut rows = vec![NodalRow::default(); names.len()];
        let mut terms = Vec::new();
        for (q, stencil) in stencils.iter().enumerate() {
            terms.clear();
            terms.extend(stencil.frozen_gradient());
            let constant = stencil.frozen_constant();
            for (i, w) in shares(sampling, q, stencil) {
                rows[i].add(w, terms.iter().copied(), constant);
            }
        }
        let mut leaning = match sampling {
            Sampling::Nodes => Leaning::new(slave, &rows),
            Sampling::Points => Leaning::default(),
        };
        #[cfg(planted)]
        if contact_core::planted!("rows do not lean") {
            leaning = Leaning::default();
        }
        if !leaning.own.is_empty() {
            let mut leant = vec![NodalRow::default(); rows.len()];
            for (j, row) in rows.iter().enumerate() {
                let parts = leaning.rows_of(j);
                parts.for_each(|(i, share)| leant[i].add_row(row, share));
            }
            leaning.bare = std::mem::replace(&mut rows, leant);
        }
        let mut places = Places::default();
        rows.iter_mut().for_each(|row| row.normalize(&mut places));
        PassRows {
            sampling,
            first_corner: stencils.len(),
            crossings: Vec::new(),
            stencils,
            names,
            rows,
            leaning,
        }
    }

    /// Whether each row is a node's.
    pub fn is_of_nodes(&self) -> bool {
        self.sampling == Sampling::Nodes
    }

    /// With a row for each of these corners: of the slave, which is where `own` says, or of the obstacle in front of it.
    pub fn with_corners(
        mut self,
        own: &'a Moving<D>,
        against: impl Into<Against<'a, D>>,
        corners: &[Corner<D>],
    ) -> Self {
        let against = against.into();
        let mut places = Places::default();
        for corner in corners {
            let stencil = corner.stencil(own, against);
            let mut row = NodalRow::default();
            let terms = stencil.frozen_gradient();
            row.add(stencil.weight(), terms, stencil.frozen_constant());
            row.normalize(&mut places);
            row.widening = corner.slack();
            self.names.push(stencil.number());
            self.rows.push(row);
            self.stencils.push(stencil);
        }
        self
    }

    /// With a row for each pair of edges that cross.
    pub fn with_crossings(mut self, crossings: Vec<Crossing<D>>) -> Self {
        let mut places = Places::default();
        for crossing in &crossings {
            let mut row = NodalRow::default();
            row.add(crossing.weight(), crossing.gradient(), 0.0);
            row.normalize(&mut places);
            row.widening = crossing.slack();
            self.names.push(crossing.name());
            self.rows.push(row);
        }
        self.crossings = crossings;
        self
    }

    /// The edges that cross, each of which has a row of its own.
    pub fn crossings(&self) -> &[Crossing<D>] {
        &self.crossings
    }

    /// Adds widths (UL) to the gaps: to the rows of nodes `of_row`, and to those of points what their test functions
    /// interpolate of `of_node`, if that is positive. Both are by position among the slave's nodes.
    pub fn widen(&mut self, of_row: impl Fn(usize) -> f64, of_node: impl Fn(usize) -> f64) {
        let weak = self.weak_rows();
        for (i, row) in self.rows[..weak].iter_mut().enumerate() {
            row.widening = match self.sampling {
                Sampling::Nodes => of_row(i),
                Sampling::Points => {
                    let shares = self.stencils[i].test_functions();
                    let width: f64 = shares.map(|(k, phi)| phi * of_node(k)).sum();
                    width.max(0.0)
                }
            };
        }
    }

    /// Takes a distance that the surfaces keep (UL) from the gaps of all rows.
    pub fn keep_off(&mut self, distance: f64) {
        let rows = self.rows.iter_mut();
        rows.for_each(|row| row.widening -= distance);
    }

    /// The integration points that count. Each comes with its rows as (the row's [`RowKey::node`],
    /// its share w_q φ_i(q)/a_i in the row): c_i = Σ_q share_iq g_q. φ_i is the test function that a leaning row has; such a row
    /// may come twice. Rows without support are left out.
    ///
    /// With one multiplier λ_i for each row, a point carries the force π_q = Σ_i λ_i share_iq (UF),
    /// and Cᵀλ = Σ_q π_q ∇g_q.
    pub fn stencils(
        &self,
    ) -> impl Iterator<Item = (&Stencil<'a, D>, impl Iterator<Item = (usize, f64)> + '_)> {
        self.stencils.iter().enumerate().map(move |(q, stencil)| {
            let corner = q.checked_sub(self.first_corner);
            let corner = corner.map(|k| (self.weak_rows() + k, stencil.weight()));
            let shares = corner.is_none().then(|| shares(self.sampling, q, stencil));
            let shares = shares.into_iter().flatten().flat_map(|(j, w)| {
                let rows = self.leaning.rows_of(j);
                rows.map(move |(i, share)| (i, w * share))
            });
            let shares = corner.into_iter().chain(shares);
            let supported = shares.filter(|&(i, _)| self.rows[i].has_support());
            let of_row = |(i, w): (usize, f64)| (self.names[i], w / self.rows[i].area);
            (stencil, supported.map(of_row))
        })
    }

    /// Where the part of the slave that is opposite the master ends, with what is gained there; see [`weighing`].
    pub(super) fn ends(&self, x: &[Vector<D>]) -> Vec<(Stencil<'a, D>, Weighing<D>)> {
        weighing::ends(&self.stencils, x)
    }

    /// How rows vary with the weight of a point, for positions `x` of all scene nodes: the row's [`RowKey::node`], and by the weight the derivatives of its
    /// gap and of its coefficients at the nodes. With α_i = φ_i at the point, whose gap is g, a leaning row a_i c_i = s_i a'_i c'_i + (1 − s_i) Σ_j s_j a'_j c'_j
    /// gains
    ///
    /// W g + Σ_k B_k a'_k c'_k,  W = s_i α_i + (1 − s_i) Σ_j s_j α_j,
    /// B_i = s'_i α_i,  B_j = (1 − s_i) s'_j α_j − s'_i α_i s_j,
    ///
    /// and its a_i likewise; c_i is their ratio. So do coefficients.
    pub(super) fn weighed(&self, point: &Stencil<'a, D>, x: &[Vector<D>]) -> Vec<Weighed<D>> {
        if self.sampling == Sampling::Points {
            return Vec::new(); // a row of one point does not depend on its weight
        }
        let tests: Vec<(usize, f64)> = point.test_functions().collect();
        let alpha = |j: usize| {
            let own = tests.iter().find(|(k, _)| *k == j);
            own.map_or(0.0, |(_, phi)| *phi)
        };
        let leaning = &self.leaning;
        let mut affected: Vec<usize> = tests.iter().map(|(i, _)| *i).collect();
        let on = leaning.on.iter().filter(|(j, ..)| alpha(*j) != 0.0);
        affected.extend(on.map(|(_, i, _)| *i));
        affected.sort_unstable();
        affected.dedup();
        affected.retain(|&i| self.rows[i].has_support());
        let weigh = |i: usize| {
            let row = &self.rows[i];
            let (mut W, mut B) = (alpha(i), Vec::new());
            if let Some(&s) = leaning.own.get(i) {
                W *= s;
                B.push((i, leaning.slopes[i] * alpha(i)));
                for &(j, _, share) in leaning.on.iter().filter(|(_, k, _)| *k == i) {
                    W += share * alpha(j);
                    let gains = (1.0 - s) * leaning.slopes[j] * alpha(j);
                    B.push((j, gains - leaning.slopes[i] * alpha(i) * leaning.own[j]));
                }
                B.retain(|(_, b)| *b != 0.0);
            }
            let bare = |(k, b): &(usize, f64)| (&leaning.bare[*k], *b);
            let area = W + B.iter().map(bare).map(|(row, b)| b * row.area).sum::<f64>();
            let gap = W * point.projection().gap - area * row.gap(x);
            let gap = gap
                + B.iter()
                    .map(bare)
                    .map(|(row, b)| b * row.gap(x))
                    .sum::<f64>();
            let mut terms: Vec<_> = point.frozen_gradient().map(|(a, c)| (a, c * W)).collect();
            terms.extend(row.terms.iter().map(|(a, c)| (*a, c * -area)));
            for (row, b) in B.iter().map(bare) {
                terms.extend(row.terms.iter().map(|(a, c)| (*a, c * b)));
            }
            terms.iter_mut().for_each(|(_, c)| *c /= row.area);
            Weighed {
                name: self.names[i],
                gap: gap / row.area,
                terms,
            }
        };
        affected.into_iter().map(weigh).collect()
    }

    /// The number of rows that are means over facets; the rows of corners and edges follow.
    fn weak_rows(&self) -> usize {
        let corners = self.stencils.len() - self.first_corner;
        self.rows.len() - corners - self.crossings.len()
    }

    /// Appends to `gaps` the rows that have support and at least one dof that is not prescribed,
    /// split into free and prescribed unknowns.
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
            row.constant = nodal.constant + nodal.widening;
            row.weight = nodal.area;
            #[cfg(planted)]
            {
                let size = nodal.area.powf(1.0 / (D as f64 - 1.0));
                if contact_core::planted!("rows are a hundredth of a facet open") {
                    row.constant += 0.01 * size;
                }
                if contact_core::planted!("rows are a thousandth of a facet open") {
                    row.constant += 0.001 * size;
                }
                if contact_core::planted!("every fifth row is a hundredth of a facet closed")
                    && node % 5 == 0
                {
                    row.constant -= 0.01 * size;
                }
            }
            #[cfg(planted)]
            if contact_core::planted!("every fifth row is left out") && node % 5 == 0 {
                continue;
            }
            unknowns.split(&nodal.terms, X, &mut row);
            let node = node as u32;
            #[cfg(planted)]
            let node = match contact_core::planted!("rows have the names of the next nodes") {
                true => node + 1,
                false => node,
            };
            gaps.push(RowKey { pass, node }, &row);
        }
    }
}

impl<const D: usize> PassRows<'_, D> {
    /// Appends the slips of the rows that `has_row` names by their [`RowKey::node`] to `slips`. A slip is a mean as
    /// the gap of its row is, with the tangent of each point for its normal:
    ///
    /// s_i = 1/a_i Σ_q w_q φ_i(q) ((x_q − x̄_q) − (x_q − x̄_q)_before)·t_q.
    ///
    /// The tangent is the normal turned by a right angle in the first two directions, and so are the coefficients. `before` has the positions of all scene nodes to which
    /// slips are relative; `dragged` tells how far an obstacle has moved since then at a place.
    pub fn append_slips(
        &self,
        pass: u32,
        X: &[Vector<D>],
        (before, dragged): (&[Vector<D>], impl Fn(&Vector<D>) -> Vector<D>),
        unknowns: &Unknowns<'_>,
        has_row: impl Fn(usize) -> bool,
        (friction, slips): (f64, &mut SlipRows),
    ) {
        let places: HashMap<usize, usize> = self
            .names
            .iter()
            .enumerate()
            .map(|(k, name)| (*name, k))
            .collect();
        let mut of_obstacle = vec![0.0; self.rows.len()];
        for (stencil, shares) in self.stencils() {
            if let Against::Obstacle(_) = stencil.against() {
                let FootPoint { foot, normal, .. } = stencil.projection();
                let way = dragged(foot).dot(&turned(normal));
                shares.for_each(|(name, share)| of_obstacle[places[&name]] += share * way);
            }
        }
        for ((&node, nodal), dragged) in self.names.iter().zip(&self.rows).zip(of_obstacle) {
            if !nodal.has_support() || !has_row(node) {
                continue;
            }
            let terms = nodal.terms.iter().map(|(a, c)| (*a, turned(c)));
            let terms: Vec<_> = terms.collect();
            let mut row = Row::default();
            unknowns.split(&terms, X, &mut row);
            let then = terms.iter().map(|(a, c)| c.dot(&before[*a]));
            let node = node as u32;
            slips.push(
                RowKey { pass, node },
                &SlipRow {
                    constant: row.constant - then.sum::<f64>() - dragged,
                    free: row.free,
                    prescribed: row.prescribed,
                    coefficient: friction,
                    ..SlipRow::default()
                },
            );
        }
    }
}

/// Adds up entries of one unknown.
fn merge(entries: &mut Vec<(usize, f64)>) {
    entries.sort_by_key(|(j, _)| *j);
    entries.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        kept.1 += if is_same { next.1 } else { 0.0 };
        is_same
    });
}

/// The rows (by position) of the `q`-th stencil, and its weights in them before the division by
/// a_i: w φ_i, or w in the point's own row.
fn shares<const D: usize>(
    sampling: Sampling,
    q: usize,
    stencil: &Stencil<'_, D>,
) -> impl Iterator<Item = (usize, f64)> {
    let w = stencil.weight();
    let count = match sampling {
        Sampling::Nodes => usize::MAX,
        Sampling::Points => 1,
    };
    let tests = stencil.test_functions().take(count);
    tests.map(move |(i, phi)| match sampling {
        Sampling::Nodes => (i, w * phi),
        Sampling::Points => (q, w),
    })
}

impl<const D: usize> NodalRow<D> {
    /// Adds a point with weight `w` and the gap Σ `terms` + `constant`.
    fn add(&mut self, w: f64, terms: impl Iterator<Item = (usize, Vector<D>)>, constant: f64) {
        self.area += w;
        self.constant += w * constant;
        self.terms.extend(terms.map(|(a, c)| (a, c * w)));
    }

    /// Adds a share of another row.
    fn add_row(&mut self, other: &NodalRow<D>, share: f64) {
        let terms = other.terms.iter().map(|(a, c)| (*a, c * share));
        self.terms.extend(terms);
        self.area += share * other.area;
        self.constant += share * other.constant;
    }

    /// The gap at positions `x` of all scene nodes (UL), not widened; a_i times the gap before [`NodalRow::normalize`].
    fn gap(&self, x: &[Vector<D>]) -> f64 {
        let terms = self.terms.iter().map(|(a, c)| c.dot(&x[*a]));
        self.constant + terms.sum::<f64>()
    }

    /// Whether a_i, that of the test function which a leaning row has, is positive, so that c_i is a mean of gaps.
    fn has_support(&self) -> bool {
        self.area > 0.0
    }

    /// Merges the terms of each node and divides by a_i: c_i is then a length and λ_i a force.
    fn normalize(&mut self, places: &mut Places) {
        places.merge(&mut self.terms);
        #[cfg(planted)]
        if contact_core::planted!("rows are not divided by their area") {
            return;
        }
        if self.has_support() {
            self.terms.iter_mut().for_each(|term| term.1 /= self.area);
            self.constant /= self.area;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::contact::stencil::projected;
    use crate::contact::{Integration, Master, Projection};
    use crate::element::Order;

    /// One quadratic segment from x = 0 to 1 on a longer one, with points at ξ. A width of 1 at its first
    /// end is (1 − ξ)(1 − 2 ξ) at a point, and nothing on the far half, where that is negative.
    #[test]
    fn widths_of_points_are_interpolated_and_positive() {
        let x = [
            [1.0, 0.0],
            [0.0, 0.0],
            [0.5, 0.0],
            [-1.0, 0.0],
            [2.0, 0.0],
            [0.5, 0.0],
        ];
        let x = x.map(Vector::<2>::from);
        let surface = |body: usize, facet: [usize; 3]| {
            let facets = [&facet[..]];
            Surface::new(body, Order::Quadratic, facets.into_iter(), &x)
        };
        let (slave, master) = (surface(0, [0, 1, 2]), Arc::new(surface(1, [3, 4, 5])));
        let master = Master::new(&master, &x, Projection::AlongNormals);
        let points = projected(&slave, &master, &x, Integration::Gauss(6), 1.0);
        assert_eq!(points.len(), 6);
        let all_free = DofMap::new(&[false; 12]);
        let unknowns = Unknowns {
            dofs: &all_free,
            supports: &all_free,
            prescribed: &[],
        };
        let mut rows = PassRows::new(&slave, &master, &points, Sampling::Points);
        // the surface's nodes are in the order of the scene's: x = 1, 0, ½
        rows.widen(|_| 99.0, |k| if k == 0 { 1.0 } else { 0.0 });
        let mut gaps = LinearGaps::new(true);
        rows.append(0, &x, &unknowns, &mut gaps);
        assert_eq!(gaps.len(), 6);
        for (stencil, constant) in rows.stencils.iter().zip(gaps.constant()) {
            let xi = 1.0 - stencil.point()[0];
            let width = ((1.0 - xi) * (1.0 - 2.0 * xi)).max(0.0);
            assert!((constant - width).abs() < 1e-14, "{constant} at {xi}");
        }
        rows.widen(|_| 99.0, |_| 1.0);
        let mut gaps = LinearGaps::new(true);
        rows.append(0, &x, &unknowns, &mut gaps);
        assert!(gaps.constant().iter().all(|c| (c - 1.0).abs() < 1e-14));
    }
}
