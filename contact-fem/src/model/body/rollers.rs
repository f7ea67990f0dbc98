//! Supports along a direction: nodes that slide along planes of any normal.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::Body;
use super::supports::{name_of_nodes, some};
use crate::assembly::DofMap;
use crate::error::Error;
use crate::jacobi::orthogonal_columns;
use crate::model::courses::{Course, Part};
use crate::program::{Amplitude, samples};
use crate::tensor::Vector;

/// Directions as close to an axis (sine of the angle) are that axis.
const AXIS: f64 = 1e-14;
/// What is left of a unit normal beside those of other supports of a node is nothing below this share.
const PARALLEL: f64 = 1e-9;
/// Two supports that hold a node in one direction may differ by this share of their values.
const SAME: f64 = 1e-12;
/// Supports of a node may together move it by so many times what each of them does. By values that do not fit, planes at an angle
/// of 6° do.
const APART: f64 = 20.0;

/// The nodes that planes hold, and what follows from that.
#[derive(Clone, Default)]
pub(in crate::model) struct Rollers<const D: usize> {
    planes: BTreeMap<usize, Vec<Plane<D>>>,
    /// Of each tied dof those that add to it, with coefficients.
    pub(super) ties: BTreeMap<usize, Vec<(usize, f64)>>,
    /// Of each node what its supports do.
    pub(super) shares: BTreeMap<usize, Vec<Share>>,
}

/// u·n is prescribed.
#[derive(Clone)]
struct Plane<const D: usize> {
    /// Of length 1.
    n: Vector<D>,
    /// The value (UL), and the number of its course.
    value: (f64, usize),
    /// The number of its boundary's name.
    name: usize,
}

/// A share of a prescribed dof's reaction in what a support does at a dof.
#[derive(Clone, Copy)]
pub(in crate::model) struct Share {
    /// The number of the support's boundary.
    pub name: usize,
    pub dof: usize,
    pub prescribed: usize,
    pub share: f64,
}

/// a·u = Σ parts, where a has a 1 at its pivot, and 0 at those of the others.
struct Row<const D: usize> {
    a: Vector<D>,
    parts: Vec<Part>,
    pivot: usize,
    /// What it was at first, and its value.
    given: Vector<D>,
    value: Part,
    name: usize,
}

impl<const D: usize> Body<D> {
    /// Prescribes the displacement along a direction n (UL, at full load) of all nodes of a boundary: u·n = value, with n of length
    /// 1 along `direction`. Across it they are free: rollers on a plane that is not perpendicular to an axis, or that moves; a plane of
    /// symmetry of any direction. The reaction is along n.
    ///
    /// A block slides down a slope of 30° on rollers until a spring of stiffness 10 stops it:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = rectangle(&linspace(0.0, 1.0, 2), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
    /// let mut block = Body::new(mesh, LinearElastic::new(1e5, 0.3)?);
    /// // gravity is vertical and the slope is not: n is the normal of the slope
    /// let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    /// block.prescribe_along("bottom", [sin, cos], 0.0)?.foundation("left", 10.0)?;
    /// block.body_force([0.0, -2.0])?;
    /// let mut scene = Scene::new();
    /// let block = scene.add("block", block);
    /// let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    /// let of = |boundary: &str| {
    ///     let mut own = history.steps[0].support_reactions.iter();
    ///     own.find(|(side, _)| side.boundary == boundary).expect("known").1
    /// };
    /// assert!((of("bottom")[0] * cos - of("bottom")[1] * sin).abs() < 1e-9, "along n");
    /// assert!((history.steps[0].reaction(block)[1] - 2.0).abs() < 1e-9, "the weight");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, the direction has no length, the value is not finite, supports prescribe different
    /// values, or some of a node's supports do not hold at all times.
    pub fn prescribe_along(
        &mut self,
        boundary: &str,
        direction: [f64; D],
        value: f64,
    ) -> Result<&mut Self, Error> {
        self.prescribe_along_in_time(boundary, direction, value, Amplitude::default())
    }

    /// As [`Body::prescribe_along`], with the value times an amplitude in place of the load factor.
    ///
    /// # Errors
    /// As [`Body::prescribe_along`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn prescribe_along_in_time(
        &mut self,
        boundary: &str,
        direction: [f64; D],
        value: f64,
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        self.hold_plane((boundary, &nodes), direction, (value, amplitude.into()))
    }

    /// As [`Body::prescribe_along`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe_along`], and if there is no node, or one that does not exist.
    pub fn prescribe_nodes_along(
        &mut self,
        nodes: &[usize],
        direction: [f64; D],
        value: f64,
    ) -> Result<&mut Self, Error> {
        self.prescribe_nodes_along_in_time(nodes, direction, value, Amplitude::default())
    }

    /// As [`Body::prescribe_along_in_time`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe_along_in_time`], and if there is no node, or one that does not exist.
    pub fn prescribe_nodes_along_in_time(
        &mut self,
        nodes: &[usize],
        direction: [f64; D],
        value: f64,
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        some("number of supported nodes", nodes)?;
        let name = name_of_nodes(nodes);
        self.hold_plane((&name, nodes), direction, (value, amplitude.into()))
    }

    pub(super) fn hold_plane(
        &mut self,
        (boundary, nodes): (&str, &[usize]),
        direction: [f64; D],
        (value, amplitude): (f64, Amplitude),
    ) -> Result<&mut Self, Error> {
        let n = Vector::<D>::from(direction);
        // without the squares of large or small numbers
        let unit = n / n.amax();
        let unit = unit / unit.norm();
        if !unit.iter().all(|n| n.is_finite()) {
            return Err(Error::Setting {
                name: "length of the direction of a support",
                value: n.norm(),
                remedy: "give a direction with finite components, not all of them 0",
            });
        }
        Error::check_finite("prescribed displacement", &[value])?;
        self.check_nodes(nodes)?;
        let course = self.course(amplitude);
        let axis = unit.iamax();
        let across = (0..D).filter(|i| *i != axis).map(|i| unit[i].abs());
        if across.fold(0.0, f64::max) <= AXIS {
            let mut components = [None; D];
            components[axis] = Some(value * unit[axis].signum());
            return self.hold((boundary, nodes), components, course);
        }
        self.always("a support along a direction")?;
        if self.is_rigid() {
            return Err(Error::NotRigid {
                what: "a support along a direction that is not an axis",
                remedy: "turn the scene so that it is along an axis",
            });
        }
        if nodes.iter().any(|node| self.is_switched_at(*node)) {
            return Err(Error::NotSwitched {
                what: "a support of nodes that slide along a direction",
            });
        }
        self.or_not(|body| {
            let plane = Plane {
                n: unit,
                value: (value, course),
                name: body.named(boundary),
            };
            for node in nodes {
                let own = body.rollers.planes.entry(*node).or_default();
                own.push(plane.clone());
            }
            body.resolve_all(nodes)
        })
    }

    /// The normal of the plane that nodes are in, and the thickness of what they are in (UL).
    pub(super) fn normal_of_plane(&self, nodes: &[usize]) -> (Vector<D>, f64) {
        let X = |k: usize| self.mesh.nodes()[nodes[k]];
        let centre = (0..nodes.len()).map(X).sum::<Vector<D>>() / nodes.len().max(1) as f64;
        let arms = DMatrix::from_fn(nodes.len(), D, |k, i| X(k)[i] - centre[i]);
        let (turned, turns) = orthogonal_columns(arms);
        let norms = (0..D).map(|i| (i, turned.column(i).norm()));
        let least = norms.min_by(|a, b| a.1.total_cmp(&b.1));
        let n = Vector::<D>::from_fn(|i, _| turns[(i, least.map_or(0, |(k, _)| k))]);
        let heights = (0..nodes.len()).map(|k| (X(k) - centre).dot(&n));
        let [low, high] = heights.fold([0.0_f64; 2], |[low, high], h| [low.min(h), high.max(h)]);
        (n, high - low)
    }

    /// Whether planes hold a node.
    pub(super) fn slides(&self, node: usize) -> bool {
        self.rollers.planes.contains_key(&node)
    }

    /// Whether planes hold some node.
    pub(in crate::model) fn has_rollers(&self) -> bool {
        !self.rollers.planes.is_empty()
    }

    /// The dofs that others add to, and these, with coefficients.
    pub(crate) fn ties(&self) -> &BTreeMap<usize, Vec<(usize, f64)>> {
        &self.rollers.ties
    }

    /// What is prescribed where a dof is: a sum of dofs of its node, with coefficients.
    pub(in crate::model) fn held_by(&self, dof: usize) -> Vec<(usize, f64)> {
        let others = self.rollers.ties.get(&dof).into_iter().flatten();
        let others = others.map(|(other, c)| (*other, -c));
        std::iter::once((dof, 1.0)).chain(others).collect()
    }

    /// What the supports of nodes that planes hold do: shares of the reactions of prescribed dofs.
    pub(in crate::model) fn shares_of_rollers(&self) -> impl Iterator<Item = &Share> {
        self.rollers.shares.values().flatten()
    }

    /// Whether the supports of a node are by planes, and each component's reaction is none of theirs.
    pub(in crate::model) fn has_shares(&self, node: usize) -> bool {
        self.rollers.shares.contains_key(&node)
    }

    /// The dofs without those that are tied, which the body's own energy has as unknowns, and the values of the prescribed ones at
    /// load factor 1 (UL).
    pub(super) fn eliminated(&self) -> (DofMap, Vec<f64>) {
        let own = self.prescribed.iter().enumerate();
        let own = own.map(|(dof, value)| value.filter(|_| !self.rollers.ties.contains_key(&dof)));
        let own: Vec<Option<f64>> = own.collect();
        let is_prescribed: Vec<bool> = own.iter().map(Option::is_some).collect();
        (
            DofMap::new(&is_prescribed),
            own.into_iter().flatten().collect(),
        )
    }

    /// The free and the prescribed dofs, with ties.
    pub(super) fn dofs(&self) -> DofMap {
        let mut dofs = DofMap::new(&self.is_prescribed());
        for (dof, others) in &self.rollers.ties {
            dofs.tie(*dof, others.iter().copied());
        }
        dofs
    }

    /// Which dofs move by how much (UL) where the prescribed ones move by `increments`: nodes that planes move go along the normal, and
    /// those on planes at rest go along with the others.
    pub(in crate::model) fn lifted_by(&self, increments: Vec<f64>) -> (DofMap, Vec<f64>) {
        if self.rollers.ties.is_empty() || self.is_rigid() {
            return (DofMap::new(&self.is_prescribed()), increments);
        }
        let held = self.prescribed.iter().enumerate();
        let held = held.filter(|(_, value)| value.is_some());
        let moved = held.map(|(dof, _)| dof).zip(increments);
        let mut all = vec![None; self.prescribed.len()];
        for (dof, increment) in moved {
            let sum = self.held_by(dof);
            if sum.len() == 1 {
                all[dof] = Some(increment);
            } else if increment != 0.0 {
                let square: f64 = sum.iter().map(|(_, c)| c * c).sum();
                for (dof, c) in sum {
                    *all[dof].get_or_insert(0.0) += c * increment / square;
                }
            }
        }
        let is_held: Vec<bool> = all.iter().map(Option::is_some).collect();
        (DofMap::new(&is_held), all.into_iter().flatten().collect())
    }

    /// Finds anew what follows from the supports of these nodes, if planes hold them.
    pub(super) fn resolve_all(&mut self, nodes: &[usize]) -> Result<(), Error> {
        for node in nodes {
            if let Some(planes) = self.rollers.planes.get(node).cloned() {
                self.resolve(*node, &planes)?;
            }
        }
        Ok(())
    }

    /// Eliminates components by the supports of one node.
    fn resolve(&mut self, node: usize, planes: &[Plane<D>]) -> Result<(), Error> {
        let mut rows = Vec::<Row<D>>::new();
        for i in 0..D {
            let dof = D * node + i;
            if let Some((value, name)) = self.declared_at_all_times(dof) {
                let a = Vector::from_fn(|k, _| f64::from(u8::from(k == i)));
                let value = Part {
                    factor: 1.0,
                    dof,
                    value,
                };
                rows.push(Row {
                    a,
                    parts: vec![value],
                    pivot: i,
                    given: a,
                    value,
                    name,
                });
            }
        }
        for plane in planes {
            let (mut a, dof) = (plane.n, D * node);
            let own = Part {
                factor: 1.0,
                dof,
                value: plane.value,
            };
            let mut parts = vec![own];
            for row in &rows {
                let factor = a[row.pivot];
                a -= row.a * factor;
                a[row.pivot] = 0.0;
                parts.extend(row.parts.iter().map(|part| part.times(-factor)));
            }
            let pivot = a.iamax();
            if a[pivot].abs() < PARALLEL {
                self.agree(node, plane, &rows, &parts)?;
                continue;
            }
            let factor = 1.0 / a[pivot];
            a *= factor;
            let parts: Vec<Part> = parts.iter().map(|part| part.times(factor)).collect();
            self.fit(node, plane, &rows, &parts)?;
            for row in &mut rows {
                let factor = row.a[pivot];
                row.a -= a * factor;
                row.a[pivot] = 0.0;
                if factor != 0.0 {
                    row.parts
                        .extend(parts.iter().map(|part| part.times(-factor)));
                }
            }
            rows.push(Row {
                a,
                parts,
                pivot,
                given: plane.n,
                value: own,
                name: plane.name,
            });
        }
        self.take(node, &rows);
        Ok(())
    }

    /// # Errors
    /// If a plane that other supports hold a node along is elsewhere: `parts` are not zero.
    fn agree(
        &self,
        node: usize,
        plane: &Plane<D>,
        rows: &[Row<D>],
        parts: &[Part],
    ) -> Result<(), Error> {
        for t in samples().rev() {
            let values = parts.iter().map(|part| self.supports.part_at(part, t));
            let (sum, size) = values.fold((0.0, 0.0), |(sum, size), v| (sum + v, size + v.abs()));
            if sum.abs() > SAME * size {
                let second = self.supports.course_at(D * node, plane.value, t);
                let on = self.names_of(nearest(plane, rows), plane);
                return Err(self.conflict((node, plane.n), on, [second - sum, second], t));
            }
        }
        Ok(())
    }

    /// # Errors
    /// If a plane, together with the other supports of a node, moves it much further than each of them: `parts` are the component that
    /// follows from all of them.
    fn fit(
        &self,
        node: usize,
        plane: &Plane<D>,
        rows: &[Row<D>],
        parts: &[Part],
    ) -> Result<(), Error> {
        let Some(other) = nearest(plane, rows) else {
            return Ok(());
        };
        for t in samples().rev() {
            let at = |part: &Part| self.supports.part_at(part, t);
            let sum: f64 = parts.iter().map(at).sum();
            let second = self.supports.course_at(D * node, plane.value, t);
            let others = rows.iter().map(|row| at(&row.value).abs());
            let largest = others.fold(second.abs(), f64::max);
            if sum.abs() > APART * largest {
                let sine = (plane.n - other.given * other.given.dot(&plane.n)).norm();
                return Err(Error::NearlyParallel {
                    node,
                    x: self.mesh.nodes()[node].iter().copied().collect(),
                    on: Box::new(self.names_of(Some(other), plane).map(str::to_string)),
                    angle: sine.min(1.0).asin().to_degrees(),
                    first: at(&other.value),
                    second,
                    displacement: sum.abs(),
                    at: t,
                });
            }
        }
        Ok(())
    }

    /// The boundaries of two supports.
    fn names_of(&self, row: Option<&Row<D>>, plane: &Plane<D>) -> [&str; 2] {
        let first = row.map(|row| self.supported[row.name].as_str());
        [first.unwrap_or_default(), &self.supported[plane.name]]
    }

    /// Prescribes the pivots of a node's rows, and ties them to its other components.
    fn take(&mut self, node: usize, rows: &[Row<D>]) {
        let is_pivot = |i: usize| rows.iter().any(|row| row.pivot == i);
        for i in 0..D {
            let dof = D * node + i;
            self.rollers.ties.remove(&dof);
            self.supports.values[dof] = None;
            self.prescribed[dof] = None;
            self.support_of[dof] = None;
        }
        for row in rows {
            let dof = D * node + row.pivot;
            let value = self.supports.combined(&row.parts);
            self.supports.values[dof] = Some(value);
            self.prescribed[dof] = Some(self.supports.value(dof, value, 1.0));
            self.support_of[dof] = Some(row.name);
            let others = (0..D).filter(|i| !is_pivot(*i) && row.a[*i] != 0.0);
            let others: Vec<_> = others.map(|i| (D * node + i, -row.a[i])).collect();
            if !others.is_empty() {
                self.rollers.ties.insert(dof, others);
            }
        }
        // r = Σ λ_j n_j, and the pivots' components of r are known
        let m = rows.len();
        let at_pivots = DMatrix::from_fn(m, m, |j, p| rows[j].given[rows[p].pivot]);
        let inverse = at_pivots
            .try_inverse()
            .unwrap_or_else(|| DMatrix::zeros(m, m));
        let mut shares = Vec::new();
        for (j, row) in rows.iter().enumerate() {
            for (p, other) in rows.iter().enumerate() {
                for i in (0..D).filter(|i| row.given[*i] != 0.0) {
                    shares.push(Share {
                        name: row.name,
                        dof: D * node + i,
                        prescribed: D * node + other.pivot,
                        share: row.given[i] * inverse[(p, j)],
                    });
                }
            }
        }
        self.rollers.shares.insert(node, shares);
    }
}

/// The support of a node whose direction is closest to that of a plane.
fn nearest<'a, const D: usize>(plane: &Plane<D>, rows: &'a [Row<D>]) -> Option<&'a Row<D>> {
    let cosine = |row: &&Row<D>| row.given.dot(&plane.n).abs();
    rows.iter().max_by(|a, b| cosine(a).total_cmp(&cosine(b)))
}

impl<const D: usize> super::Supports<D> {
    /// A value and a course for a sum of parts, which may belong to dofs of different nodes; zero without parts.
    pub(super) fn combined(&mut self, parts: &[Part]) -> (f64, usize) {
        match parts {
            [] => (0.0, 0),
            [
                Part {
                    factor,
                    value: (value, course),
                    ..
                },
            ] if matches!(self.courses[*course], Course::Scaled(_)) => (factor * value, *course),
            _ => {
                self.courses.push(Course::Sum(parts.to_vec()));
                (0.0, self.courses.len() - 1)
            }
        }
    }
}
