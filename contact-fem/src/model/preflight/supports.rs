//! Rigid motions that supports leave free.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;

use super::limits::HOLDS;
use super::{Finding, FindingKind, Report, Severity, meshes, pieces, resisted};
use crate::error::Error;
use crate::jacobi::orthogonal_columns;
use crate::model::{Body, Pair, Scene};
use crate::tensor::Vector;

/// The smallest part of a unit vector along a coordinate axis that is outside the motions it belongs to (no unit).
const ALONG: f64 = 1e-6;
/// How much of a motion contact resists, as a share of what it resists most. Meshes of discs and balls are a little off them.
const RESISTS: f64 = 0.02;

/// Checks that every part of every body is supported, has a foundation or may touch another body or an obstacle, and that at least
/// one displacement is prescribed if there is no obstacle; names the motions that contact alone holds.
pub(super) fn check<const D: usize>(scene: &Scene<D>, pairs: &[Pair], report: &mut Report) {
    let held = |body: &Body<D>| {
        // of revolution, the axis holds nodes that nobody has supported; nodes of rigid bodies follow their leaders
        let follows = |dof: usize| body.is_rigid() && body.ties().contains_key(&dof);
        let counts = |dof: usize| !(follows(dof) || body.mesh().is_of_revolution() && dof % D != 1);
        let mut prescribed = body.prescribed().iter().enumerate();
        prescribed.any(|(dof, value)| value.is_some() && counts(dof))
            || !body.foundations().is_empty()
    };
    if !scene.bodies().iter().any(held) && scene.obstacles().is_empty() {
        report.take::<()>(Err(Error::NoSupport));
        return;
    }
    let is_free = |body: &Body<D>| body.prescribed().iter().any(Option::is_none);
    if !scene.bodies().iter().any(is_free) {
        report.take::<()>(Err(Error::NothingFree));
    }
    let deforms = |body: &Body<D>| is_free(body) && !body.is_rigid();
    if scene.bodies().iter().any(is_free) && !scene.bodies().iter().any(deforms) {
        report.take::<()>(Err(Error::NothingDeforms));
    }
    let touches = touched(scene, pairs);
    let mut unmerged_bodies = BTreeSet::new();
    for cluster in clusters(scene) {
        let motions = cluster.free_motions(scene);
        if motions.is_empty() {
            continue;
        }
        let free = motions.len();
        let (body, part) = &cluster.parts[0];
        let name = &scene.names()[*body];
        let touches = |(body, part): &(usize, Vec<usize>)| part.iter().any(|&a| touches[*body][a]);
        if !cluster.parts.iter().any(touches) {
            // of a body whose cells are all apart, once for all
            if unmerged_bodies.contains(body) {
                continue;
            }
            let mesh = scene.bodies()[*body].mesh();
            let unmerged = meshes::coinciding(mesh);
            let is_own = |nodes: &&[usize; 2]| nodes.iter().any(|a| part.binary_search(a).is_ok());
            report.take::<()>(Err(match unmerged.iter().find(is_own) {
                Some(&nodes) => {
                    unmerged_bodies.insert(*body);
                    Error::Unmerged {
                        body: name.clone(),
                        count: unmerged.len(),
                        nodes,
                    }
                }
                None => Error::Unsupported {
                    body: name.clone(),
                    node: part[0],
                    free,
                    modes: modes::<D>(mesh.is_of_revolution()),
                    motions: motions.join(", "),
                },
            }));
            continue;
        }
        note_motions(&cluster, scene, pairs, &motions, report);
    }
    let bodies = scene.bodies().iter().zip(scene.names());
    for (body, name) in bodies.filter(|(body, _)| !body.is_rigid()) {
        pieces::check(body, name, &body.mesh().parts(), report);
    }
}

/// Notes which of the free motions of a cluster contact alone holds, and which nothing does.
fn note_motions<const D: usize>(
    cluster: &Cluster,
    scene: &Scene<D>,
    pairs: &[Pair],
    motions: &[String],
    report: &mut Report,
) {
    let name = &scene.names()[cluster.parts[0].0];
    let others = match cluster.parts.len() {
        1 => "",
        _ => " and what is tied to it",
    };
    let mut parts = cluster.parts.iter();
    let has_forces = parts.any(|(body, _)| scene.bodies()[*body].largest().1 > 0.0);
    let loose = resisted::unresisted(cluster, scene, pairs);
    let held: Vec<String> = motions
        .iter()
        .filter(|name| !loose.contains(name))
        .cloned()
        .collect();
    let mut note = |kind, motions: &[String], what: &str, remedy: &str| {
        if !motions.is_empty() {
            let finding = Finding::new(Severity::Note, kind, &[name]);
            report.add(finding.measured(motions.len() as f64, 0.0).says(
                format!("{what} body `{name}`{others}: {}", motions.join(", ")),
                remedy,
            ));
        }
    };
    note(
        FindingKind::HeldByNothing,
        &loose,
        "neither supports nor contact hold",
        "prescribe a displacement if loads act along this motion; without them, it stays where it is, and the certificate may tell that other places are as good",
    );
    note(
        FindingKind::HeldByContact,
        &held,
        "only contact holds",
        match has_forces {
            true => {
                "leave it so if its forces press it against what it touches; otherwise prescribe displacements in place of forces"
            }
            false => "leave it so if it stays in contact; otherwise support these motions, too",
        },
    );
}

/// For each body the nodes that may touch something.
fn touched<const D: usize>(scene: &Scene<D>, pairs: &[Pair]) -> Vec<Vec<bool>> {
    let bodies = scene.bodies().iter();
    let mut touches: Vec<_> = bodies
        .map(|body| vec![false; body.mesh().nodes().len()])
        .collect();
    let surfaces = pairs.iter().flat_map(|pair| [&pair.first, &pair.second]);
    for side in surfaces.chain(scene.obstructed().iter().map(|(side, _)| side)) {
        let body = side.body.index();
        // the side was checked when the pair was declared
        let nodes = scene.bodies()[body].mesh().boundary_nodes(&side.boundary);
        nodes
            .into_iter()
            .flatten()
            .for_each(|node| touches[body][node] = true);
    }
    touches
}

/// Parts of bodies that ties hold together; the nodes of each part.
pub(in crate::model) struct Cluster {
    /// (body, nodes numbered within it).
    pub parts: Vec<(usize, Vec<usize>)>,
}

impl Cluster {
    /// The rigid motions that supports and springs leave free.
    fn free_motions<const D: usize>(&self, scene: &Scene<D>) -> Vec<String> {
        match &self.parts[..] {
            [(body, part)] => free_motions(&scene.bodies()[*body], part),
            _ => self.unheld(scene, Vec::new()),
        }
    }

    /// The rigid motions that neither supports and springs nor `others` resist, by name; nodes of `others` count through all bodies.
    pub(super) fn unheld<const D: usize>(&self, scene: &Scene<D>, others: Vec<Row>) -> Vec<String> {
        let first = scene.first_nodes();
        let place = |node: usize| {
            let body = first.partition_point(|first| *first <= node) - 1;
            scene.bodies()[body].mesh().nodes()[node - first[body]]
        };
        let own = self.parts.iter().flat_map(|(body, part)| {
            let first = first[*body];
            part.iter().map(move |a| first + a)
        });
        let rows = self
            .parts
            .iter()
            .flat_map(|(body, part)| held_rows(&scene.bodies()[*body], first[*body], part));
        let first_body = &scene.bodies()[self.parts[0].0];
        let is_revolved = first_body.mesh().is_of_revolution();
        let modes = Modes::new(&place, &own.collect(), is_revolved);
        let free = null_space(rows.map(|row| modes.of(&row)), modes.width(), HOLDS);
        if others.is_empty() || free.ncols() == 0 {
            return names::<D>(&free);
        }
        let along_free = others.iter().map(|row| {
            let row = DMatrix::from_row_slice(1, modes.width(), &modes.of(row));
            (row * &free).iter().copied().collect()
        });
        let left = null_space(along_free, free.ncols(), RESISTS);
        names::<D>(&(&free * left))
    }

    /// Whether a part of this body belongs to it.
    pub(super) fn has_body(&self, body: usize) -> bool {
        self.parts.iter().any(|(own, _)| *own == body)
    }

    /// Whether this node of a body belongs to it.
    pub(super) fn has(&self, body: usize, node: usize) -> bool {
        let holds =
            |(own, part): &(usize, Vec<usize>)| *own == body && part.binary_search(&node).is_ok();
        self.parts.iter().any(holds)
    }
}

/// A sum of displacements: node, component and coefficient.
pub(in crate::model) type Row = Vec<(usize, usize, f64)>;

/// What supports and springs of a part hold; nodes count from `first`.
pub(in crate::model) fn held_rows<const D: usize>(
    body: &Body<D>,
    first: usize,
    part: &[usize],
) -> Vec<Row> {
    let dofs = part.iter().flat_map(|node| D * node..D * (node + 1));
    let held = dofs.filter(|&dof| body.prescribed()[dof].is_some());
    let row = |own: &[(usize, f64)]| -> Vec<_> {
        let own = own.iter();
        own.map(|(dof, c)| (first + dof / D, dof % D, *c)).collect()
    };
    let held = held.map(|dof| row(&body.held_by(dof)));
    let springs = body.stretches();
    let springs = springs.filter(|own| part.binary_search(&(own[0].0 / D)).is_ok());
    let springs = springs.map(row);
    held.chain(springs).collect()
}

/// The parts of all bodies, joined where ties hold them.
pub(in crate::model) fn clusters<const D: usize>(scene: &Scene<D>) -> Vec<Cluster> {
    let bodies = scene.bodies().iter().enumerate();
    let parts = bodies.flat_map(|(index, body)| {
        let parts = match body.is_rigid() {
            // wherever its cells are, they move as one
            true => vec![(0..body.mesh().nodes().len()).collect()],
            false => body.mesh().parts(),
        };
        parts.into_iter().map(move |part| (index, part))
    });
    let parts: Vec<(usize, Vec<usize>)> = parts.collect();
    let mut root: Vec<usize> = (0..parts.len()).collect();
    for tie in scene.ties() {
        let mut tied = Vec::new();
        for side in [&tie.first, &tie.second] {
            let body = side.body.index();
            let nodes = scene.bodies()[body].mesh().boundary_nodes(&side.boundary);
            let nodes: BTreeSet<usize> = nodes.into_iter().flatten().collect();
            let has_side = |(_, (owner, part)): &(usize, &(usize, Vec<usize>))| {
                *owner == body && part.iter().any(|a| nodes.contains(a))
            };
            tied.extend(
                parts
                    .iter()
                    .enumerate()
                    .filter(has_side)
                    .map(|(k, _)| root[k]),
            );
        }
        let Some(&least) = tied.iter().min() else {
            continue;
        };
        let own = root.iter_mut().filter(|root| tied.contains(root));
        own.for_each(|root| *root = least);
    }
    let mut clusters = BTreeMap::<usize, Vec<_>>::new();
    for (part, root) in parts.into_iter().zip(root) {
        clusters.entry(root).or_default().push(part);
    }
    clusters
        .into_values()
        .map(|parts| Cluster { parts })
        .collect()
}

/// Whether supports, with those of what is tied to it, hold every part of each body.
pub(in crate::model) fn held<const D: usize>(scene: &Scene<D>) -> Vec<bool> {
    let mut held = vec![true; scene.bodies().len()];
    for cluster in clusters(scene) {
        if !cluster.free_motions(scene).is_empty() {
            cluster
                .parts
                .iter()
                .for_each(|(body, _)| held[*body] = false);
        }
    }
    held
}

/// The number of rigid motions in ℝᴰ; of a body of revolution the one along its axis.
pub(in crate::model) const fn modes<const D: usize>(is_revolved: bool) -> usize {
    if is_revolved { 1 } else { D * (D + 1) / 2 }
}

/// The displacement of component `component` at `arm` from the centre of mode `k` of a body that may be one of revolution.
pub(super) fn mode_of<const D: usize>(
    is_revolved: bool,
    k: usize,
    arm: &Vector<D>,
    component: usize,
) -> f64 {
    motion::<D>(if is_revolved { 1 } else { k }, arm, component)
}

/// The displacement of component `component` at `arm` from the centre of mode `k`: translations, then
/// rotations.
pub(in crate::model) fn motion<const D: usize>(k: usize, arm: &Vector<D>, component: usize) -> f64 {
    if k < D {
        return f64::from(u8::from(component == k));
    }
    let mut planes = (0..D).flat_map(|i| (0..i).map(move |j| (i, j)));
    match planes.nth(k - D) {
        Some((i, j)) if component == i => -arm[j],
        Some((i, j)) if component == j => arm[i],
        _ => 0.0,
    }
}

/// The names of independent rigid motions of a part of a body that its prescribed dofs and its springs leave free: the null
/// space of the modes restricted to these dofs, and to what stretches springs.
///
/// Lever arms are measured from the centroid of the supported nodes in units of their extent, so
/// that the result does not depend on position and size.
fn free_motions<const D: usize>(body: &Body<D>, part: &[usize]) -> Vec<String> {
    let is_held = |&dof: &usize| body.prescribed()[dof].is_some();
    let dofs = part.iter().flat_map(|node| D * node..D * (node + 1));
    let held: Vec<usize> = dofs.filter(is_held).collect();
    let springs: Vec<&[(usize, f64)]> = body
        .stretches()
        .filter(|own| part.binary_search(&(own[0].0 / D)).is_ok())
        .collect();
    let nodes = body.mesh().nodes();
    let held_nodes = || {
        let of_springs = springs
            .iter()
            .flat_map(|own| own.iter().map(|(dof, _)| dof));
        held.iter().chain(of_springs).map(|dof| nodes[dof / D])
    };
    let centre = held_nodes().sum::<Vector<D>>() / held_nodes().count().max(1) as f64;
    let extent = held_nodes()
        .map(|X| (X - centre).norm())
        .fold(f64::MIN_POSITIVE, f64::max);
    let is_revolved = body.mesh().is_of_revolution();
    let row = |shares: &[(usize, f64)]| {
        let of_mode = |k: usize| {
            let terms = shares.iter().map(|(dof, share)| {
                let arm = (nodes[dof / D] - centre) / extent;
                share * mode_of(is_revolved, k, &arm, dof % D)
            });
            terms.sum()
        };
        (0..modes::<D>(is_revolved)).map(of_mode).collect()
    };
    let of_dofs = held.iter().map(|dof| row(&body.held_by(*dof)));
    let of_springs = springs.iter().map(|own| row(own));
    let width = modes::<D>(is_revolved);
    let free = null_space(of_dofs.chain(of_springs), width, HOLDS);
    names::<D>(&free)
}

/// The names of independent rigid motions of the part with these `nodes` that all `rows` annul. `place` tells the position of a node (UL), the flag whether the body is one of revolution.
pub(in crate::model) fn unheld_motions<const D: usize>(
    rows: impl Iterator<Item = Row>,
    place: &dyn Fn(usize) -> Vector<D>,
    nodes: &BTreeSet<usize>,
    is_revolved: bool,
) -> Vec<String> {
    let modes = Modes::new(place, nodes, is_revolved);
    names::<D>(&null_space(
        rows.map(|row| modes.of(&row)),
        modes.width(),
        HOLDS,
    ))
}

/// Rigid motions about the centre of some nodes, in units of their extent.
struct Modes<'a, const D: usize> {
    place: &'a dyn Fn(usize) -> Vector<D>,
    centre: Vector<D>,
    extent: f64,
    is_revolved: bool,
}

impl<'a, const D: usize> Modes<'a, D> {
    fn new(
        place: &'a dyn Fn(usize) -> Vector<D>,
        nodes: &BTreeSet<usize>,
        is_revolved: bool,
    ) -> Self {
        let count = nodes.len().max(1) as f64;
        let centre = nodes.iter().map(|&a| place(a)).sum::<Vector<D>>() / count;
        let arms = nodes.iter().map(|&a| (place(a) - centre).norm());
        Modes {
            place,
            centre,
            extent: arms.fold(f64::MIN_POSITIVE, f64::max),
            is_revolved,
        }
    }

    fn width(&self) -> usize {
        modes::<D>(self.is_revolved)
    }

    /// What each motion does to a row.
    fn of(&self, row: &Row) -> Vec<f64> {
        let of_mode = |k: usize| {
            let terms = row.iter().map(|&(node, component, c)| {
                let arm = ((self.place)(node) - self.centre) / self.extent;
                c * mode_of(self.is_revolved, k, &arm, component)
            });
            terms.sum()
        };
        (0..self.width()).map(of_mode).collect()
    }
}

/// An orthonormal basis, column by column, of the vectors that all `rows` of `width` numbers annul. Singular
/// values up to `least` times the largest count as zero.
pub(super) fn null_space(
    rows: impl Iterator<Item = Vec<f64>>,
    width: usize,
    least: f64,
) -> DMatrix<f64> {
    // only R of a QR factorisation is kept: it is small for any number of rows
    let mut R = DMatrix::zeros(0, width);
    let mut rows = rows.peekable();
    while rows.peek().is_some() {
        let next: Vec<f64> = rows.by_ref().take(100).flatten().collect();
        let below = DMatrix::from_row_slice(next.len() / width, width, &next);
        let stacked = DMatrix::from_fn(R.nrows() + below.nrows(), width, |row, k| {
            match row < R.nrows() {
                true => R[(row, k)],
                false => below[(row - R.nrows(), k)],
            }
        });
        R = stacked.qr().r();
    }
    let (turned, turns) = orthogonal_columns(R);
    let values: Vec<f64> = turned.column_iter().map(|column| column.norm()).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let free: Vec<_> = (0..width)
        .filter(|&k| values[k] <= least * largest)
        .collect();
    turns.select_columns(&free)
}

/// Names of the motions with these modes, column by column: along and about coordinate axes where possible.
fn names<const D: usize>(free: &DMatrix<f64>) -> Vec<String> {
    if free.nrows() == 1 {
        let along = (0..free.ncols()).map(|_| "translation along the axis".to_string());
        return along.collect();
    }
    let turns = free.rows(D, free.nrows() - D).into_owned();
    let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        matrix
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect()
    };
    // combinations of the modes without rotation, and the rotations of the others
    let still = match free.ncols() {
        0 => return Vec::new(),
        count => null_space(rows(&turns).into_iter(), count, ALONG),
    };
    let still = match turns.amax() <= ALONG {
        true => DMatrix::identity(free.ncols(), free.ncols()),
        false => still,
    };
    let moving = null_space(rows(&still.transpose()).into_iter(), free.ncols(), ALONG);
    let translations = free.rows(0, D) * &still;
    let mut names = directions::<D>(&translations, "translation ", "translation along ");
    if moving.ncols() == 0 {
        return names;
    }
    if D == 2 {
        names.push("rotation".into());
        return names;
    }
    // modes turn from the j-th to the i-th axis: about −z, y and −x
    let turns = turns * moving;
    let about = DMatrix::from_fn(3, turns.ncols(), |axis, k| match axis {
        0 => -turns[(2, k)],
        1 => turns[(1, k)],
        _ => -turns[(0, k)],
    });
    names.extend(directions::<D>(
        &about,
        "rotation about ",
        "rotation about ",
    ));
    names
}

/// Names of the directions that these columns span, with one word before the name of an axis and another one before the
/// components of a direction.
fn directions<const D: usize>(columns: &DMatrix<f64>, axis: &str, other: &str) -> Vec<String> {
    let count = columns.ncols();
    // what is orthogonal to all columns
    let columns = columns.transpose();
    let rows = columns.row_iter().map(|row| row.iter().copied().collect());
    let outside = null_space(rows, D, ALONG);
    let is_spanned = |i: &usize| outside.row(*i).norm() <= ALONG;
    let axes: Vec<usize> = (0..D).filter(is_spanned).take(count).collect();
    let word = |i: &usize| format!("{axis}{}", ["x", "y", "z"][*i]);
    let mut names: Vec<String> = axes.iter().map(word).collect();
    // the rest is orthogonal to these axes and to what is outside
    let unit = |i: &usize| {
        (0..D)
            .map(|k| f64::from(u8::from(k == *i)))
            .collect::<Vec<f64>>()
    };
    let outside = outside.transpose();
    let outside = outside.row_iter().map(|row| row.iter().copied().collect());
    let rest = null_space(axes.iter().map(unit).chain(outside), D, ALONG);
    names.extend(rest.column_iter().map(|column| {
        let largest = column.iamax();
        let sign = column[largest].signum();
        // without −0
        let parts = column.iter().map(|v| format!("{:.3}", sign * v + 0.0));
        format!("{other}({})", parts.collect::<Vec<_>>().join(", "))
    }));
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LinearElastic;
    use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};

    fn plane(held: &[usize], components: [Option<f64>; 2]) -> Vec<String> {
        let sides = linspace(3.0, 4.0, 2);
        let mesh = rectangle(&sides, &sides, Diagonals::Rising).expect("mesh");
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("law"));
        if !held.is_empty() {
            body.prescribe_nodes(held, components).expect("support");
        }
        free_motions(&body, &(0..9).collect::<Vec<_>>())
    }

    #[test]
    fn motions_in_the_plane() {
        let both = [Some(0.0); 2];
        let all = ["translation x", "translation y", "rotation"];
        assert_eq!(plane(&[], both), all);
        assert_eq!(plane(&[0], both), ["rotation"]);
        assert!(plane(&[0, 1], both).is_empty());
        assert_eq!(plane(&[0, 1], [None, Some(0.0)]), ["translation x"]);
        assert_eq!(
            plane(&[0, 1], [Some(0.0), None]),
            ["translation y", "rotation"]
        );
    }

    fn space(holds: impl Fn(&Vector<3>) -> bool, components: [Option<f64>; 3]) -> Vec<String> {
        let mesh = cuboid([2.0, 0.0, 0.0], [1.0; 3], [1, 1, 1]).expect("mesh");
        let nodes = mesh.nodes().iter().enumerate();
        let held: Vec<usize> = nodes.filter(|(_, X)| holds(X)).map(|(a, _)| a).collect();
        let all: Vec<usize> = (0..mesh.nodes().len()).collect();
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("law"));
        if !held.is_empty() {
            body.prescribe_nodes(&held, components).expect("support");
        }
        free_motions(&body, &all)
    }

    #[test]
    fn motions_in_space() {
        let all = [Some(0.0); 3];
        assert_eq!(space(|_| false, all).len(), 6);
        let turns = ["rotation about x", "rotation about y", "rotation about z"];
        assert_eq!(space(|X| X.norm() == 2.0, all), turns);
        let hinge = |X: &Vector<3>| X[0] == 2.0 && X[1] == 0.0;
        assert_eq!(space(hinge, all), ["rotation about z"]);
        let diagonal = |X: &Vector<3>| X[2] == 0.0 && X[0] - 2.0 == X[1];
        assert_eq!(
            space(diagonal, all),
            ["rotation about (0.707, 0.707, 0.000)"]
        );
        let rollers = space(|X| X[2] == 0.0, [None, None, Some(0.0)]);
        assert_eq!(
            rollers,
            ["translation x", "translation y", "rotation about z"]
        );
    }
}
