//! Contact of a surface with itself beside a crease, where facets that have a node in common are no masters of each other.

use std::collections::{BTreeMap, BTreeSet};

use contact_core::RowKey;
use contact_core::equilibrium::Solution;

use super::{HOLDS, Problem, place_of_unknowns};
use crate::contact::{Pass, Surface};
use crate::tensor::Vector;

/// The share of the forces that is told.
const TOLD: f64 = 0.01;

/// A body that touches itself beside a crease, as [`Problem::creases`] finds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Crease<const D: usize> {
    /// The name of the body.
    pub body: String,
    /// The present position of the node whose row has the largest of these forces (UL).
    pub place: Vector<D>,
    /// The share of these rows in the forces of all rows with which the body touches itself, from 0 to 1.
    pub share: f64,
}

impl<const D: usize> std::fmt::Display for Crease<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let at: Vec<String> = self.place.iter().map(|x| format!("{x:.3e}")).collect();
        write!(
            f,
            "body `{}` touches itself beside a crease at ({}), where {:.0} % of its forces on itself act: facets that have a node in common do \
             not touch each other, so that what the crease does nearer to its tip is not seen; take finer facets there",
            self.body,
            at.join(", "),
            100.0 * self.share
        )
    }
}

/// The forces with which a body touches itself.
#[derive(Default)]
struct Own {
    all: f64,
    beside: f64,
    /// The largest force beside a crease, and the node of its row.
    largest: (f64, usize),
}

/// The bodies of which a hundredth of the forces on themselves, or more, acts beside a crease.
///
/// A row of node a has coefficients at the nodes of the facets around a, and opposite ones at those of its masters. The nearest masters that
/// count have a node in common with the neighbours of these facets.
pub(in crate::model) fn creases<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
) -> Vec<Crease<D>> {
    let forces = &solution.lambda;
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let places = place_of_unknowns(problem);
    let mut bodies: BTreeMap<usize, Own> = BTreeMap::new();
    let mut around: BTreeMap<usize, Around> = BTreeMap::new();
    for (row, key) in solution.gaps.keys().iter().enumerate() {
        let force = forces.get(row).copied().unwrap_or(0.0);
        let Some((body, surfaces)) = own_surfaces(problem, *key) else {
            continue;
        };
        if force <= HOLDS * largest {
            continue;
        }
        let node = key.node as usize;
        let around = around
            .entry(key.pass as usize)
            .or_insert_with(|| Around::new(surfaces));
        let mut coefficients: BTreeMap<usize, Vector<D>> = BTreeMap::new();
        for (unknown, c) in solution.gaps.matrix().row(row) {
            let (a, component) = places[unknown];
            coefficients.entry(a).or_insert_with(Vector::zeros)[component] += c;
        }
        let of_node = coefficients
            .get(&node)
            .copied()
            .unwrap_or_else(Vector::zeros);
        let near = around.second(node);
        let is_beside = coefficients
            .iter()
            .any(|(a, c)| near.contains(a) && c.dot(&of_node) < 0.0);
        let own = bodies.entry(body).or_default();
        own.all += force;
        if is_beside {
            own.beside += force;
            if force > own.largest.0 {
                own.largest = (force, node);
            }
        }
    }
    let x = problem.positions(&solution.state.u);
    let told = bodies
        .into_iter()
        .filter(|(_, own)| own.beside > TOLD * own.all);
    told.map(|(body, own)| Crease {
        body: problem.scene().names()[body].clone(),
        place: x[own.largest.1],
        share: own.beside / own.all,
    })
    .collect()
}

/// The body that a row is of if both of its surfaces are that body's, and the surfaces.
fn own_surfaces<const D: usize>(
    problem: &Problem<D>,
    key: RowKey,
) -> Option<(usize, [&Surface<D>; 2])> {
    let Pass { slave, master } = *problem.passes().get(key.pass as usize)?;
    let surfaces = problem.surfaces();
    // obstacles are numbered after surfaces
    let both = [&**surfaces.get(slave)?, &**surfaces.get(master)?];
    let body = both[0].body();
    (both[1].body() == body).then_some((body, both))
}

/// For each scene node of two surfaces the nodes of its facets, itself among them.
struct Around(BTreeMap<usize, BTreeSet<usize>>);

impl Around {
    fn new<const D: usize>(surfaces: [&Surface<D>; 2]) -> Self {
        let mut around: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for surface in surfaces {
            for facet in surface.facets() {
                let nodes = || facet.iter().map(|&k| surface.nodes()[k]);
                nodes().for_each(|a| around.entry(a).or_default().extend(nodes()));
            }
        }
        Around(around)
    }

    /// The nodes of the facets around the facets of a node, but for those of its own facets.
    fn second(&self, node: usize) -> BTreeSet<usize> {
        let empty = BTreeSet::new();
        let of = |a: usize| self.0.get(&a).unwrap_or(&empty);
        let first = of(node);
        let all = first.iter().flat_map(|&a| of(a).iter().copied());
        all.filter(|a| !first.contains(a)).collect()
    }
}

#[cfg(test)]
mod tests {
    use contact_core::ContactProblem;

    use super::super::tests::ended;
    use super::*;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::{Body, Mesh, NeoHookean, Scene};

    /// A block of width 2 and height 1 with a V of this width and depth ½ in the middle of its top, and no support but at its bottom.
    fn notched(width: f64, is_quadratic: bool) -> Problem<2> {
        let (x, y) = (linspace(-1.0, 1.0, 80), linspace(0.0, 1.0, 20));
        let mesh = rectangle(&x, &y, Diagonals::Alternating).expect("mesh");
        // 20 columns to either side of the middle are the notch
        let bent = |[x, y]: [f64; 2]| {
            let (inner, half) = (0.5, 0.5 * width);
            let at = match x.abs() <= inner {
                true => x / inner * half,
                false => x.signum() * (half + (x.abs() - inner) / (1.0 - inner) * (1.0 - half)),
            };
            let depth = 0.5 * (1.0 - x.abs() / inner).max(0.0);
            [at, y * (1.0 - depth)]
        };
        let nodes = mesh.nodes().iter().map(|x| bent([x[0], x[1]])).collect();
        let cells = mesh.cells().flatten().copied().collect();
        let mut bent = Mesh::<2>::new(nodes, cells).expect("mesh");
        bent.name_boundary("bottom", |x| x[1] < 1e-9);
        bent.name_boundary("top", |x| x[1] > 0.45 && x[0].abs() < 1.0 - 1e-9);
        let mesh = if is_quadratic { bent.quadratic() } else { bent };
        let law = NeoHookean::new(1e3, 0.3).expect("law");
        let mut body = Body::new(mesh, law);
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let mut scene = Scene::new();
        let body = scene.add("block", body);
        scene.self_contact(body.on("top")).expect("contact");
        scene.problem().expect("a scene")
    }

    /// The rows where the sides of the notch nearly touch, after the width shrank to a twentieth, with a force on those higher than `from`.
    fn closed(problem: &Problem<2>, from: f64) -> Solution {
        let mut u = vec![0.0; problem.energy().dofs()];
        for (j, (node, component)) in place_of_unknowns(problem).into_iter().enumerate() {
            if component == 0 {
                u[j] = -0.95 * problem.reference()[node][0];
            }
        }
        let ended = ended(problem, u, 0.0);
        let height = |key: &RowKey| problem.reference()[key.node as usize][1];
        let force = |key: &RowKey| if height(key) > from { 2.0 } else { 0.0 };
        Solution {
            lambda: ended.gaps.keys().iter().map(force).collect(),
            ..ended
        }
    }

    #[test]
    fn a_notch_that_closes_to_its_tip_is_told_and_one_that_stays_open_there_is_not() {
        for is_quadratic in [false, true] {
            let problem = notched(0.2, is_quadratic);
            let found = problem.creases(&closed(&problem, 0.0));
            let [crease] = &found[..] else {
                panic!("{is_quadratic}: {found:?}");
            };
            assert_eq!(crease.body, "block");
            // the tip is at (0, ½), and 20 facets of height 1/40 are beside it
            let [x, y] = [crease.place[0], crease.place[1]];
            assert!(
                x.abs() < 1e-3 && (0.5..0.5 + 3.0 / 40.0).contains(&y),
                "{x} {y}"
            );
            assert!((0.01..0.3).contains(&crease.share), "{}", crease.share);
            let open = problem.creases(&closed(&problem, 0.65));
            assert_eq!(open, [], "{is_quadratic}");
        }
    }

    #[test]
    fn what_touches_others_has_no_crease() {
        let solid = |low: f64| {
            let y = linspace(low, low + 1.0, 4);
            let mesh = rectangle(&linspace(0.0, 1.0, 4), &y, Diagonals::Rising).expect("mesh");
            Body::new(mesh, NeoHookean::new(1e3, 0.3).expect("law"))
        };
        let mut scene = Scene::new();
        let mut lower = solid(0.0);
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", solid(1.0));
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("contact");
        let problem = scene.problem().expect("a scene");
        let found = problem.creases(&closed(&problem, 0.0));
        assert_eq!(found, []);
    }
}
