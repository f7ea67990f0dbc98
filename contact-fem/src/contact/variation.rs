//! How weak gaps and contact forces vary with the positions, for Newton's method.
//!
//! c_i = Σ_q share_iq g_q varies by Σ_q share_iq δg_q, and the forces Σ_q π_q f_q, π_q = Σ_i λ_i
//! share_iq, by Σ_q π_q δf_q, where f is the frozen gradient, N n at the nodes of the slave's facet and
//! −N n at those of the master's. The names are those of [`gap`](super::gap):
//!
//! δg = q·(δx_q − Σ N_b δx_b) + p·Σ μ_k N_b,k δx_b + w·Σ N_b δn_b,
//! δn = A (m,k δλ_k + Σ N_b δn_b).
//!
//! Along normals, δλ has a term with Σ N_b δn_b, too.
//!
//! Many points share the averaged normals n_b of a node, and each n_b depends on all facets around
//! it. Their variations are internal variables of a [`GapVariation`], so that a point has entries at its
//! own two facets only.

use std::collections::HashMap;
use std::ops::AddAssign;

use contact_core::GapVariation;
use contact_core::gaps::SparseRows;

use super::edge::Crossing;
use super::gap::foot::Foot;
use super::moving::Moving;
use super::obstacle::Placed;
use super::rows::{Pass, PassRows, Weighed};
use super::stencil::{Against, Stencil};
use super::weighing::{self, Weighing};
use crate::assembly::{Dof, DofMap};
use crate::tensor::{Matrix, Vector, turned};

/// A sum with one term a key. The keys are apart from the terms, so that a key is found by a short scan.
#[derive(Clone, Debug)]
struct Sum<T> {
    keys: Vec<usize>,
    terms: Vec<T>,
}

/// A linear form in the positions of nodes and in averaged normals.
#[derive(Clone, Debug)]
struct Form<T> {
    nodes: Sum<T>,
    normals: Sum<T>,
}

impl<T: AddAssign + Copy> Sum<T> {
    const EMPTY: Self = Sum {
        keys: Vec::new(),
        terms: Vec::new(),
    };

    /// Adds to the term of `key`.
    fn add(&mut self, key: usize, term: T) {
        match self.keys.iter().position(|other| *other == key) {
            Some(k) => self.terms[k] += term,
            None => {
                self.keys.push(key);
                self.terms.push(term);
            }
        }
    }

    fn add_all(&mut self, keys: &[usize], terms: &[T]) {
        let terms = keys.iter().zip(terms);
        terms.for_each(|(&key, &term)| self.add(key, term));
    }

    fn iter(&self) -> impl Iterator<Item = (usize, &T)> {
        self.keys.iter().copied().zip(&self.terms)
    }
}

impl<T: AddAssign + Copy> Form<T> {
    const ZERO: Self = Form {
        nodes: Sum::EMPTY,
        normals: Sum::EMPTY,
    };
}

/// The sums over the integration points of all passes.
pub struct Variation<const D: usize> {
    /// δc_i.
    gaps: Vec<Form<Vector<D>>>,
    /// δ(Cᵀλ)_a at each scene node a.
    forces: Vec<Form<Matrix<D>>>,
    /// The numbers of the normals by surface and node, and their forms in the positions.
    numbers: HashMap<(usize, usize), usize>,
    normals: Vec<Sum<Matrix<D>>>,
}

/// The sums over points that follow each other on the same two facets: dense, so that most points find no key.
struct Piece<const D: usize> {
    rows: Vec<usize>,
    nodes: Vec<usize>,
    normals: Vec<usize>,
    /// δc, rows by nodes and rows by normals.
    gaps: Vec<Vector<D>>,
    gaps_by_normals: Vec<Vector<D>>,
    /// δ(Cᵀλ), nodes by nodes and nodes by normals; zero unless some point pushes.
    forces: Vec<Matrix<D>>,
    forces_by_normals: Vec<Matrix<D>>,
    pushes: bool,
}

impl<const D: usize> Piece<D> {
    fn new(rows: Vec<usize>, nodes: Vec<usize>, normals: Vec<usize>) -> Self {
        Piece {
            gaps: vec![Vector::zeros(); rows.len() * nodes.len()],
            gaps_by_normals: vec![Vector::zeros(); rows.len() * normals.len()],
            forces: vec![Matrix::zeros(); nodes.len() * nodes.len()],
            forces_by_normals: vec![Matrix::zeros(); nodes.len() * normals.len()],
            pushes: false,
            rows,
            nodes,
            normals,
        }
    }

    fn is_of(&self, rows: &[Row], near: &[Near<D>]) -> bool {
        let same_rows = self.rows.iter().eq(rows.iter().map(|row| &row.index));
        same_rows && self.nodes.iter().eq(near.iter().map(|point| &point.node))
    }

    fn add(&mut self, foot: &Foot<'_, D>, rows: &[Row], near: &[Near<D>]) {
        let count = self.normals.len();
        let mut force = 0.0;
        for (r, row) in rows.iter().enumerate() {
            force += row.lambda * row.share;
            let sums = &mut self.gaps[r * near.len()..];
            for (sum, point) in sums.iter_mut().zip(near) {
                let mut gradient = foot.q * point.shape;
                if let Some(slopes) = &point.slopes {
                    gradient += foot.p * slopes.dot(&foot.mu);
                }
                *sum += gradient * row.share;
            }
            let sums = &mut self.gaps_by_normals[r * count..];
            for (sum, N) in sums.iter_mut().zip(&foot.N[..count]) {
                *sum += foot.w * (N * row.share);
            }
        }
        if force == 0.0 {
            return;
        }
        self.pushes = true;
        let A = foot.m.slope() * force;
        let by_normals = foot.lambda_by_normals();
        let A = A + A * foot.m_slopes * by_normals;
        let push = foot.m.n * force;
        for (a, own) in near.iter().enumerate() {
            let sums = &mut self.forces[a * near.len()..];
            for (sum, other) in sums.iter_mut().zip(near) {
                *sum += other.normal * (own.shape * force);
                if let Some(slopes) = &own.slopes {
                    *sum -= push * other.lambda.tr_mul(slopes).transpose();
                }
            }
            let sums = &mut self.forces_by_normals[a * count..];
            let mut by_normal = A * own.shape;
            if let Some(slopes) = &own.slopes {
                by_normal -= push * by_normals.tr_mul(slopes).transpose();
            }
            for (sum, N) in sums.iter_mut().zip(&foot.N[..count]) {
                *sum += by_normal * *N;
            }
        }
    }
}

/// A row at an integration point, with its multiplier and the point's share in it.
struct Row {
    index: usize,
    lambda: f64,
    share: f64,
}

/// A node of one of the two facets of a point.
struct Near<const D: usize> {
    node: usize,
    /// Its shape function in x_q − x̄.
    shape: f64,
    /// ∂(x_q − x̄)/∂λ_k of the master's node, with the opposite sign; `None` of the slave's, which is zero.
    slopes: Option<Vector<D>>,
    /// δλ and δn.
    lambda: Matrix<D>,
    normal: Matrix<D>,
}

impl<const D: usize> Variation<D> {
    /// Of `rows` rows over `nodes` scene nodes.
    pub fn new(rows: usize, nodes: usize) -> Self {
        Variation {
            gaps: vec![Form::ZERO; rows],
            forces: vec![Form::ZERO; nodes],
            numbers: HashMap::new(),
            normals: Vec::new(),
        }
    }

    /// Adds the points of one pass, for positions `x` of all scene nodes. `multiplier` maps the
    /// node that names a row to the row's index and λ, for the rows that matter. False as soon as `stops` says so, which is
    /// asked before each point; the variation is of no use then.
    pub fn add(
        &mut self,
        pass: &PassRows<'_, D>,
        of: Pass,
        x: &[Vector<D>],
        multiplier: impl Fn(usize) -> Option<(usize, f64)>,
        stops: impl Fn() -> bool,
    ) -> bool {
        let mut rows = Vec::new();
        let mut piece: Option<Piece<D>> = None;
        for (stencil, shares) in pass.stencils() {
            if stops() {
                return false;
            }
            rows.clear();
            rows.extend(shares.filter_map(|(name, share)| {
                let (index, lambda) = multiplier(name)?;
                Some(Row {
                    index,
                    lambda,
                    share,
                })
            }));
            if rows.is_empty() {
                continue;
            }
            let (foot, surface) = match stencil.against() {
                Against::Surface(master) => (Foot::new(stencil, master), of.master),
                Against::Corner(own) => (Foot::new(stencil, own), of.slave),
                Against::Obstacle(obstacle) => {
                    self.add_on_obstacle(stencil, obstacle, &rows);
                    continue;
                }
            };
            let near = near(stencil, &foot);
            let lambdas = near.iter().map(|point| (point.node, point.lambda));
            if let Some(weighing) = weighing::of_point(stencil, &foot, lambdas) {
                let rows = pass.weighed(stencil, x);
                self.weigh(rows, stencil, of, &weighing, &multiplier);
            }
            let known = piece.take().filter(|known| {
                let is_same = known.is_of(&rows, &near);
                if !is_same {
                    self.add_piece(known);
                }
                is_same
            });
            let known = piece.insert(known.unwrap_or_else(|| {
                let numbered = |&b: &usize| self.number(foot.master, surface, b);
                Piece::new(
                    rows.iter().map(|row| row.index).collect(),
                    near.iter().map(|point| point.node).collect(),
                    foot.nodes.iter().map(numbered).collect(),
                )
            }));
            known.add(&foot, &rows, &near);
        }
        if let Some(last) = &piece {
            self.add_piece(last);
        }
        for (end, weighing) in pass.ends(x) {
            self.weigh(pass.weighed(&end, x), &end, of, &weighing, &multiplier);
        }
        for crossing in pass.crossings() {
            if let Some((index, lambda)) = multiplier(crossing.name()) {
                self.add_crossing(crossing, index, lambda);
            }
        }
        true
    }

    /// Adds two edges that cross, whose row has this index and multiplier.
    fn add_crossing(&mut self, crossing: &Crossing<D>, index: usize, lambda: f64) {
        let nodes = &mut self.gaps[index].nodes;
        crossing
            .gradient()
            .for_each(|(a, slope)| nodes.add(a, slope));
        if lambda != 0.0 {
            for (a, b, curvature) in crossing.hessian() {
                self.forces[a].nodes.add(b, curvature * lambda);
            }
        }
    }

    /// Adds what `rows` vary by with the weight of a point.
    fn weigh(
        &mut self,
        rows: Vec<Weighed<D>>,
        point: &Stencil<'_, D>,
        of: Pass,
        weighing: &Weighing<D>,
        multiplier: &impl Fn(usize) -> Option<(usize, f64)>,
    ) {
        let Against::Surface(master) = point.against() else {
            return;
        };
        let normals = weighing.normals.iter();
        let normals: Vec<(usize, Vector<D>)> = normals
            .map(|(b, form)| (self.number(master, of.master, *b), *form))
            .collect();
        for row in rows {
            let Some((index, lambda)) = multiplier(row.name) else {
                continue;
            };
            let form = &mut self.gaps[index];
            for (a, v) in &weighing.nodes {
                form.nodes.add(*a, v * row.gap);
            }
            for (k, v) in &normals {
                form.normals.add(*k, v * row.gap);
            }
            if lambda == 0.0 {
                continue;
            }
            for (a, c) in &row.terms {
                let form = &mut self.forces[*a];
                for (b, v) in &weighing.nodes {
                    form.nodes.add(*b, c * (v * lambda).transpose());
                }
                for (k, v) in &normals {
                    form.normals.add(*k, c * (v * lambda).transpose());
                }
            }
        }
    }

    fn add_piece(&mut self, piece: &Piece<D>) {
        let (nodes, normals) = (&piece.nodes, &piece.normals);
        let terms = |all: usize, count: usize| all * count..(all + 1) * count;
        for (r, &row) in piece.rows.iter().enumerate() {
            let form = &mut self.gaps[row];
            form.nodes
                .add_all(nodes, &piece.gaps[terms(r, nodes.len())]);
            let by_normals = &piece.gaps_by_normals[terms(r, normals.len())];
            form.normals.add_all(normals, by_normals);
        }
        for (a, &node) in nodes.iter().enumerate().filter(|_| piece.pushes) {
            let form = &mut self.forces[node];
            form.nodes
                .add_all(nodes, &piece.forces[terms(a, nodes.len())]);
            let by_normals = &piece.forces_by_normals[terms(a, normals.len())];
            form.normals.add_all(normals, by_normals);
        }
    }

    fn add_on_obstacle(&mut self, stencil: &Stencil<'_, D>, obstacle: &Placed<D>, rows: &[Row]) {
        let n = stencil.projection().normal;
        let mut force = 0.0;
        for row in rows {
            force += row.lambda * row.share;
            for (a, N) in stencil.slave_shapes() {
                self.gaps[row.index].nodes.add(a, n * (N * row.share));
            }
        }
        if force == 0.0 {
            return;
        }
        let H = obstacle.curvature(&stencil.point()) * force;
        for (a, N_a) in stencil.slave_shapes() {
            for (b, N_b) in stencil.slave_shapes() {
                self.forces[a].nodes.add(b, H * (N_a * N_b));
            }
        }
    }

    /// The number of the averaged normal at node `b` of a surface.
    fn number(&mut self, surface: &Moving<D>, index: usize, b: usize) -> usize {
        let normals = &mut self.normals;
        *self.numbers.entry((index, b)).or_insert_with(|| {
            let slope = surface.normal(b).slope();
            let mut form = Sum::EMPTY;
            for (facet, addend) in surface.addends(b) {
                let nodes = surface.surface().facet(facet);
                for (by_corner, slopes) in addend.jacobian().iter().zip(&addend.slopes) {
                    for (&c, share) in nodes.iter().zip(slopes).filter(|(_, s)| **s != 0.0) {
                        let node = surface.surface().nodes()[c];
                        form.add(node, slope * by_corner * *share);
                    }
                }
            }
            normals.push(form);
            normals.len() - 1
        })
    }

    /// Of the forces along the tangents, which are those along the normals turned by a right angle in the first two directions.
    pub fn turned(mut self) -> Self {
        let terms = self.forces.iter_mut().flat_map(|form| {
            let nodes = form.nodes.terms.iter_mut();
            nodes.chain(&mut form.normals.terms)
        });
        for term in terms {
            let columns: Vec<Vector<D>> = term.column_iter().map(|v| turned(&v.into())).collect();
            *term = Matrix::from_columns(&columns);
        }
        self
    }

    /// In terms of the free unknowns.
    pub fn finish(self, dofs: &DofMap) -> GapVariation {
        if dofs.ties().is_empty() {
            let free = |a: usize, i: usize| match dofs.get(D * a + i) {
                Dof::Free(j) => Some((j, 1.0)).into_iter(),
                Dof::Prescribed(_) => None.into_iter(),
            };
            return self.finish_with(free);
        }
        self.finish_with(|a, i| dofs.slopes(D * a + i))
    }

    /// Likewise; `free` are the unknowns that a component varies with, and its slopes.
    fn finish_with<I: Iterator<Item = (usize, f64)>>(
        self,
        free: impl Fn(usize, usize) -> I + Copy,
    ) -> GapVariation {
        let mut variation = GapVariation::default();
        let mut row = Vec::new();
        for form in &self.gaps {
            let nodes = form.nodes.iter();
            collect(&mut row, nodes.flat_map(|(a, v)| components(a, v)), free);
            variation.gradients.push(&row);
            let normals = form.normals.iter();
            collect(
                &mut row,
                normals.flat_map(|(k, v)| components(k, v)),
                internal::<D>,
            );
            variation.internal_gradients.push(&row);
        }
        for form in &self.normals {
            push_rows(&mut variation.internal, form, free);
        }
        let (mut by_unknowns, mut by_internal) = (Vec::new(), Vec::new());
        let forms = self.forces.iter().enumerate();
        for (a, form) in forms.filter(|(_, form)| !form.nodes.keys.is_empty()) {
            for i in 0..D {
                let nodes = form.nodes.iter().flat_map(|(b, m)| line(b, m, i));
                collect(&mut by_unknowns, nodes, free);
                let normals = form.normals.iter().flat_map(|(k, m)| line(k, m, i));
                collect(&mut by_internal, normals, internal::<D>);
                for (unknown, c) in free(a, i) {
                    let times = |row: &[(usize, f64)]| -> Vec<_> {
                        row.iter().map(|(j, d)| (*j, c * d)).collect()
                    };
                    match c == 1.0 {
                        true => variation.push_force(unknown, &by_unknowns, &by_internal),
                        false => {
                            variation.push_force(
                                unknown,
                                &times(&by_unknowns),
                                &times(&by_internal),
                            );
                        }
                    }
                }
            }
        }
        variation
    }
}

/// The nodes of the two facets, with what they do to the foot and the normal.
fn near<const D: usize>(stencil: &Stencil<'_, D>, foot: &Foot<'_, D>) -> Vec<Near<D>> {
    let A = foot.m.slope();
    let near = |node: usize, shape: f64, slopes: Option<Vector<D>>| {
        let lambda = foot.lambda(shape, &slopes.unwrap_or_else(Vector::zeros));
        Near {
            node,
            shape,
            slopes,
            lambda,
            normal: A * foot.m_slopes * lambda,
        }
    };
    let surface = foot.master.surface();
    let own = stencil.slave_shapes().map(|(a, N)| near(a, N, None));
    let other = foot.nodes.iter().enumerate().map(|(b, &node)| {
        let slopes = Vector::from_fn(|k, _| foot.slopes[k][b]);
        near(surface.nodes()[node], -foot.N[b], Some(slopes))
    });
    own.chain(other).collect()
}

fn internal<const D: usize>(k: usize, i: usize) -> std::iter::Once<(usize, f64)> {
    std::iter::once((D * k + i, 1.0))
}

/// (key, component, value) of a vector.
fn components<const D: usize>(
    key: usize,
    v: &Vector<D>,
) -> impl Iterator<Item = (usize, usize, f64)> + use<D> {
    let v = *v;
    (0..D).map(move |i| (key, i, v[i]))
}

/// (key, component, value) of row `i` of a matrix.
fn line<const D: usize>(
    key: usize,
    m: &Matrix<D>,
    i: usize,
) -> impl Iterator<Item = (usize, usize, f64)> {
    let row = m.row(i).transpose();
    (0..D).map(move |j| (key, j, row[j]))
}

/// The terms in the columns that `places` finds, with coefficients.
fn collect<I: Iterator<Item = (usize, f64)>>(
    row: &mut Vec<(usize, f64)>,
    terms: impl Iterator<Item = (usize, usize, f64)>,
    places: impl Fn(usize, usize) -> I,
) {
    row.clear();
    for (key, i, v) in terms {
        row.extend(places(key, i).map(|(j, c)| (j, c * v)));
    }
}

/// One row for each component of a normal.
fn push_rows<const D: usize, I: Iterator<Item = (usize, f64)>>(
    rows: &mut SparseRows,
    form: &Sum<Matrix<D>>,
    place: impl Fn(usize, usize) -> I + Copy,
) {
    let mut row = Vec::new();
    for i in 0..D {
        collect(
            &mut row,
            form.iter().flat_map(|(b, m)| line(b, m, i)),
            place,
        );
        rows.push(&row);
    }
}
