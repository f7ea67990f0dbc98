//! Contact measured a second time, from meshes, positions and multipliers alone.
//!
//! The solver and the conditions that take its rows share search, feet, normals, quadrature and sums; a fault in one of them is the same
//! in both. Here weak gaps and forces are computed from the meshes' boundaries by other ways to the same definitions: boxes sorted along
//! an axis instead of a tree, all facets around a point instead of a walk from the closest one, slopes by differences, points that are cut by bisection,
//! quadrature of another degree. Nothing of the solver's contact is imported, which a test holds.
//!
//! What the two ways share: the meshes and the declared pairs, which kinds of points count ([`rule`], [`feet`]), and the definition of a row.

mod boxes;
mod faces;
mod feet;
mod fields;
mod pairs;
mod rows;
mod rule;
mod slopes;
mod stability;
#[cfg(test)]
mod tests;

use std::collections::{HashMap, HashSet};

use contact_core::friction::Friction;
use contact_core::{LinearGaps, Multipliers, RowKey};

use super::worse;
use crate::assembly::Dof;
use crate::element::Order;
use crate::model::{Geometry, InitialGaps, Integration, Pair, Passes, Problem, Projection, Side};
use crate::tensor::Vector;
use faces::{Faces, Placed};
use feet::Reach;
use rows::{Pass, Search};
use rule::Places;
pub(super) use stability::Releases;

/// The units in which gaps and forces are told.
pub(super) struct Units<'a> {
    /// The expected displacement of a facet as a share of its length.
    pub strain: f64,
    /// The unit of lengths in products of gaps and forces (UL).
    pub resolution: f64,
    /// For each body the largest force on a node (UF).
    pub forces: &'a [f64],
    /// Weak gaps below this one are closed, in units of the displacement of a facet.
    pub closed: f64,
    /// The smallest force on a body (UF), and the share of the unit above which a motion releases energy.
    pub releases: (f64, f64),
}

/// What the second measurement finds. Each is a residual as those of the conditions of the same name.
#[derive(Debug, Default)]
pub(super) struct Remeasured {
    pub penetration: f64,
    pub complementarity: f64,
    /// The largest difference of the area of a row that is opposite the master as a whole.
    pub areas: f64,
    /// Closed rows that the solver did not have.
    pub missing: usize,
    /// The largest difference of the forces on a node; `None` where multipliers do not belong to nodes, and where forces are not judged.
    pub forces: Option<f64>,
    /// The largest difference of virtual works; `None` likewise, and where rows are frozen at X.
    pub work: Option<f64>,
    /// The same of the forces of friction; `None` without, too.
    pub friction: Option<f64>,
    /// Motions that release energy; `None` where that is not known, as with friction.
    pub releases: Option<Releases>,
}

/// How far two sound measurements may differ.
struct Differs {
    /// Rows with a smaller share of their test function opposite the master are not judged by their gaps.
    covered: f64,
    /// How much of what gaps vary by within a row counts as their unit; and what is added, in units of the square of the sine of the angle
    /// between averaged normals and normals of facets.
    varies: [f64; 2],
    /// The same of the difference of the forces on a node, as a share of the largest on the body; `None` if forces are not judged.
    forces: Option<[f64; 2]>,
    /// The difference of virtual works, added to the sine of that angle.
    works: f64,
    /// Whether the areas of rows are the same, of which all points count in full.
    areas: bool,
}

/// Where both take the same points, those of a Gauss rule with feet along normals, and where both cut facets in the plane and integrate by rules of
/// degrees 5 and 7. Forces of the scenes of `make extremes` differ by up to 4e-6, forces of balls in bowls of 2 facets by up to 1e-3.
const CUT: Differs = Differs {
    covered: 0.1,
    varies: [0.1, 150.0],
    forces: Some([1e-4, 0.05]),
    works: 2e-3,
    areas: true,
};
/// The same with quadratic cells, whose facets are curved at present: forces of the scenes of `make extremes` differ by up to 4e-5, at the edge of
/// a punch by 2e-3. Where one facet is opposite three that are inclined by 20 degrees, they differed by up to 3e-2, and gaps by 7e-3 of what they vary by.
const CURVED: Differs = Differs {
    varies: [50.0, 1e3],
    forces: Some([1e-2, 0.5]),
    works: 1e-2,
    ..CUT
};
/// With closest points, where the solver's feet differ from the feet here. Single points decide how much of a row at the end of the master counts.
const CLOSEST: Differs = Differs {
    covered: 0.99,
    varies: [250.0, 0.0],
    forces: Some([0.5, 0.0]),
    works: 5e-2,
    areas: false,
};
/// In space with exact integration, where facets are divided here into parts that do not follow the master's facets: forces of coarse blocks whose
/// facets do not match differ by as much as they are.
const PARTS: Differs = Differs {
    forces: None,
    ..CLOSEST
};
/// The round-off of gaps as a share of the largest coordinate: gaps are differences of positions.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

/// In method (39), rows of nodes are not the solver's, and its penalty leaves gaps: their unit is so many times as large.
const OF_POINTS: f64 = 10.0;

fn differs<const D: usize>(problem: &Problem<D>) -> &'static Differs {
    let scene = problem.scene();
    let mut bodies = scene.bodies().iter();
    let is_quadratic = bodies.any(|body| body.mesh().order() == Order::Quadratic);
    match (scene.integration(), scene.projection) {
        (Integration::Exact, _) if D == 3 => &PARTS,
        (_, Projection::Closest) => &CLOSEST,
        _ if is_quadratic => &CURVED,
        _ => &CUT,
    }
}

/// A pass of a declared pair, and its number among the solver's.
struct Declared {
    pair: usize,
    slave: usize,
    master: usize,
    number: Option<usize>,
}

/// The boundaries of all pairs, and the passes between them.
struct Contact<const D: usize> {
    boundaries: Vec<Faces<D>>,
    passes: Vec<Declared>,
}

impl<const D: usize> Contact<D> {
    fn new(problem: &Problem<D>) -> Self {
        let scene = problem.scene();
        let (mut sides, mut boundaries) = (Vec::<&Side>::new(), Vec::new());
        let mut passes = Vec::new();
        for (number, pair) in scene.pairs().iter().enumerate() {
            let Pair { first, second, .. } = pair;
            let both = [first, second].map(|side| {
                sides.iter().position(|known| *known == side).or_else(|| {
                    let body = side.body.index();
                    let mesh = scene.bodies()[body].mesh();
                    let place = (body, problem.first_node(body));
                    boundaries.push(Faces::new(mesh, place, &side.boundary)?);
                    sides.push(side);
                    Some(sides.len() - 1)
                })
            });
            let [Some(a), Some(b)] = both else { continue };
            let roles: &[[usize; 2]] = match pair.passes {
                _ if a == b => &[[a, b]],
                Passes::Both => &[[a, b], [b, a]],
                Passes::FirstIsSlave => &[[a, b]],
                Passes::SecondIsSlave => &[[b, a]],
            };
            passes.extend(roles.iter().map(|&[slave, master]| Declared {
                pair: number,
                slave,
                master,
                number: None,
            }));
        }
        let mut contact = Contact { boundaries, passes };
        contact.number(problem);
        contact
    }

    /// Finds the solver's passes between the same nodes.
    fn number(&mut self, problem: &Problem<D>) {
        let surfaces = problem.surfaces();
        let is_same = |k: usize, boundary: usize| {
            let own = surfaces.get(k).map(|surface| surface.nodes());
            own == Some(&self.boundaries[boundary].nodes[..])
        };
        let numbers = self.passes.iter().map(|own| {
            let mut all = problem.passes().iter();
            all.position(|pass| is_same(pass.slave, own.slave) && is_same(pass.master, own.master))
        });
        let numbers: Vec<_> = numbers.collect();
        let passes = self.passes.iter_mut().zip(numbers);
        passes.for_each(|(pass, number)| pass.number = number);
    }
}

/// What one pass was measured to be.
struct Measured<'a, const D: usize> {
    declared: &'a Declared,
    pass: Pass<'a, D>,
    /// One for each node of the slave.
    lambda: Vec<f64>,
}

impl<const D: usize> Measured<'_, D> {
    fn key(&self, i: usize) -> Option<RowKey> {
        let pass = self.declared.number? as u32;
        let node = self.pass.slave.nodes[i] as u32;
        Some(RowKey { pass, node })
    }
}

/// Measures contact at a state with these rows and multipliers of the solver.
pub(super) fn measure<const D: usize>(
    problem: &Problem<D>,
    u: &[f64],
    (gaps, lambda): (&LinearGaps, &[f64]),
    friction: Option<&Friction>,
    units: &Units<'_>,
) -> Remeasured {
    let contact = Contact::new(problem);
    let x = positions(problem, u);
    let searched = match problem.geometry() {
        Geometry::Reference => problem.reference(),
        Geometry::Current => &x[..],
    };
    let placed: Vec<_> = contact
        .boundaries
        .iter()
        .map(|own| Placed::new(own, searched))
        .collect();
    let of_nodes = gaps.sampling() == contact_core::gaps::Sampling::Nodes;
    let multipliers = Multipliers::new(gaps, lambda);
    let mut measured = Vec::new();
    for declared in contact
        .passes
        .iter()
        .filter(|own| problem.counts(own.number))
    {
        let slave = &contact.boundaries[declared.slave];
        let of_node = |node: &usize| match declared.number {
            Some(pass) if of_nodes => multipliers.of(RowKey {
                pass: pass as u32,
                node: *node as u32,
            }),
            _ => 0.0,
        };
        let lambda: Vec<f64> = slave.nodes.iter().map(of_node).collect();
        let has_force: Vec<bool> = lambda.iter().map(|l| *l != 0.0).collect();
        let master = &placed[declared.master];
        let places = places(problem, slave, master.faces);
        let search = Search {
            x: searched,
            places: &places,
            reach: reach(problem, slave, master.faces),
            is_one_body: slave.body == master.faces.body,
            has_force: &has_force,
        };
        let pass = Pass::new(slave, master, &search);
        measured.push(Measured {
            declared,
            pass,
            lambda,
        });
    }
    let mut found = Remeasured {
        // a pass that the solver does not have
        missing: contact
            .passes
            .iter()
            .filter(|own| own.number.is_none())
            .count(),
        ..Remeasured::default()
    };
    let mut claimed = vec![0.0; gaps.len()];
    gaps.value(u, &mut claimed);
    let claims = gaps.weights().iter().copied().zip(claimed);
    let claims: Claims<'_> = gaps
        .keys()
        .iter()
        .zip(claims)
        .filter(|_| of_nodes)
        .collect();
    for own in &measured {
        judge(problem, own, &x, (&claims, of_nodes, units), &mut found);
    }
    if of_nodes {
        let state = (&x[..], gaps, lambda);
        let differs = differs(problem);
        let follows = problem.geometry() == Geometry::Current;
        if let Some(forces) = differs.forces {
            let own = (units.forces, forces);
            found.forces = Some(pairs::forces_apart(problem, &measured, state, own));
            let own = (units.forces, differs.works);
            found.work = follows.then(|| pairs::works_apart(problem, &measured, state, own));
        }
        match friction {
            Some(friction) => {
                let own = differs.forces.map(|forces| (units.forces, forces));
                found.friction =
                    own.map(|own| pairs::friction_apart(problem, &measured, friction, own));
            }
            None => {
                let moving = if follows { &measured[..] } else { &[] };
                let (state, rows) = ((&x[..], u), (gaps, lambda));
                found.releases = stability::releases(problem, moving, state, rows, units.releases);
            }
        }
    }
    found
}

/// Where all nodes are: those of the meshes, moved by the unknowns and by what supports prescribe at the load.
fn positions<const D: usize>(problem: &Problem<D>, u: &[f64]) -> Vec<Vector<D>> {
    let mut x = Vec::new();
    // components that follow others do so by the ties of the scene
    let tied = problem.displacements(u);
    let ties = problem.dofs().ties().iter();
    let follow: HashSet<usize> = ties.map(|tie| tie.dof).collect();
    for (number, body) in problem.scene().bodies().iter().enumerate() {
        let prescribed = body.prescribed_values(problem.load());
        for X in body.mesh().nodes() {
            let node = x.len();
            let own = node - problem.first_node(number);
            x.push(Vector::from_fn(|i, _| {
                let moved = match (problem.dofs().get(D * node + i), prescribed[D * own + i]) {
                    (Dof::Free(k), _) => u[k],
                    (_, Some(value)) if !follow.contains(&(D * node + i)) => value,
                    _ => tied[node][i],
                };
                X[i] + moved
            }));
        }
    }
    x
}

fn places<const D: usize>(problem: &Problem<D>, slave: &Faces<D>, master: &Faces<D>) -> Places<D> {
    let scene = problem.scene();
    Places::new(scene.integration(), scene.projection, slave, master)
}

fn reach<const D: usize>(problem: &Problem<D>, slave: &Faces<D>, master: &Faces<D>) -> Reach {
    Reach {
        radius: problem.reach(),
        size: slave.size().max(master.size()),
        fit: problem.deepest_fit(master.body),
    }
}

/// The area and the gap of each row of a node, as the solver has them.
type Claims<'a> = HashMap<&'a RowKey, (f64, f64)>;

/// Judges the rows of one pass by their gaps. What the solver's own gaps are off by is judged by the conditions that take its rows.
fn judge<const D: usize>(
    problem: &Problem<D>,
    own: &Measured<'_, D>,
    x: &[Vector<D>],
    (claims, is_of_nodes, units): (&Claims<'_>, bool, &Units<'_>),
    found: &mut Remeasured,
) {
    let pass = &own.pass;
    let of_points = pass.point_gaps(x);
    let c = pass.gaps(&of_points);
    let widths = widths(problem, own);
    let offset = problem.scene().pairs()[own.declared.pair].offset;
    let sizes = pass.slave.node_sizes();
    let ranges = pass.ranges(&of_points);
    let at_search: Vec<f64> = pass.held.iter().map(|point| point.foot.gap).collect();
    let at_search = pass.ranges(&at_search);
    let sines = pass.node_sines();
    let moves = moves(problem, pass);
    let force = units.forces[pass.slave.body];
    let coordinates = x.iter().map(Vector::amax);
    let rounded = ROUNDED * coordinates.fold(0.0, f64::max);
    let differs = differs(problem);
    let leeway = if is_of_nodes { 1.0 } else { OF_POINTS };
    for (i, c) in c.iter().enumerate() {
        let is_judged = pass.is_known[i] && moves[i] && pass.is_covered(i, differs.covered);
        if !is_judged || c.is_nan() {
            continue;
        }
        let c = c + widths.get(i).copied().unwrap_or(0.0) - offset;
        // rows at X integrate gaps there, of which motions take nearly all away
        let range = [ranges[i], at_search[i]].map(|[least, most]| most - least);
        let [flat, inclined] = differs.varies;
        let varies = range[0].max(range[1]) * (flat + inclined * sines[i] * sines[i]);
        let claim = own.key(i).and_then(|key| claims.get(&key)).copied();
        let claimed = claim.map_or(0.0, |(_, c)| c);
        let beyond = |apart: f64| {
            if apart > rounded {
                apart - rounded
            } else {
                apart.min(0.0)
            }
        };
        let depth = beyond(claimed.min(0.0) - c) / (leeway * (units.strain * sizes[i] + varies));
        found.penetration = worse(found.penetration, depth);
        let unit = force * (units.resolution + varies);
        let product = (own.lambda[i] * beyond((c - claimed).abs())).abs() / unit;
        found.complementarity = worse(found.complementarity, product);
        let is_whole = differs.areas && pass.is_whole[i];
        if let Some((area, _)) = claim.filter(|_| is_whole) {
            found.areas = worse(found.areas, (area / pass.areas[i] - 1.0).abs());
        }
        // a row that is open by less than the accuracy of both may be open for the solver
        if depth > units.closed && is_of_nodes && claim.is_none() {
            found.missing += 1;
        }
    }
}

/// For each row, whether a node that it depends on is free.
fn moves<const D: usize>(problem: &Problem<D>, pass: &Pass<'_, D>) -> Vec<bool> {
    let varies = |dof: usize| problem.dofs().slopes(dof).next().is_some();
    let is_free = |node: usize| (D * node..D * (node + 1)).any(varies);
    let mut moves = vec![false; pass.slave.nodes.len()];
    for point in &pass.held {
        let own = pass
            .slave
            .facet(point.facet)
            .iter()
            .map(|&a| pass.slave.nodes[a]);
        let master = pass.master.faces;
        let other = master
            .facet(point.foot.facet)
            .iter()
            .map(|&b| master.nodes[b]);
        if own.chain(other).any(is_free) {
            pass.slave
                .tests(point.facet)
                .iter()
                .for_each(|&a| moves[a] = true);
        }
    }
    moves
}

/// What is left of the overlap with which the bodies started, for each row (UL); empty where none is taken.
fn widths<const D: usize>(problem: &Problem<D>, own: &Measured<'_, D>) -> Vec<f64> {
    let taken = problem.scene().initial_gaps;
    let left = match taken {
        InitialGaps::Refuse => return Vec::new(),
        InitialGaps::Resolve => (1.0 - problem.load()).clamp(0.0, 1.0),
        InitialGaps::Adjust => 1.0,
    };
    let X = problem.reference();
    let master = Placed::new(own.pass.master.faces, X);
    let has_force: Vec<bool> = own.lambda.iter().map(|l| *l != 0.0).collect();
    let places = places(problem, own.pass.slave, master.faces);
    let search = Search {
        x: X,
        places: &places,
        reach: reach(problem, own.pass.slave, master.faces),
        is_one_body: own.pass.slave.body == master.faces.body,
        has_force: &has_force,
    };
    let rest = Pass::new(own.pass.slave, &master, &search);
    let of_points = rest.point_gaps(X);
    let depths = rest
        .gaps(&of_points)
        .into_iter()
        .zip(rest.ranges(&of_points));
    let offset = problem.scene().pairs()[own.declared.pair].offset;
    // where nothing overlaps, the gap is positive or not a number
    let depth = |(c, [deepest, _]): (f64, [f64; 2])| (offset - c).min(offset - deepest);
    depths.map(|depths| left * depth(depths).max(0.0)).collect()
}
