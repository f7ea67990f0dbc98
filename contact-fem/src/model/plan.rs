//! What is known of a scene before its run.

use std::collections::BTreeMap;
use std::fmt;

use contact_core::{Energy, Separable};

use super::{BodyId, Problem};

/// What a scene leaves to be found, as it is known before the run. Solvers rely on it.
///
/// | part | what relies on it | how it is checked |
/// |---|---|---|
/// | `groups` | no row acts between two of them, so that they are solved by themselves | the audit of every state looks at all bodies |
/// | `apart` | no contact is searched between them while displacements are smaller | the ways of their surfaces after each load step, and rows where these may meet; the step is solved again if one is closed |
/// | `held` | within a group, such bodies are solved by themselves as long as no common row acts on them | rows between them after each solve, which is repeated for both together where one overlaps |
/// | `linear` | their stiffness is assembled and factored once | the values are compared before they are factored |
/// | `rigid` | no cell is assembled, and all nodes follow a few unknowns | – |
/// | `prescribed` | they have no unknowns | – |
/// | `at_rest` | they take no solve: nothing moves or loads them, and nothing can touch them | their forces, in each load step |
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScenePlan {
    /// The bodies that contact can join, group by group; a body that no pair names is one by itself.
    pub groups: Vec<Vec<BodyId>>,
    /// Pairs of bodies, and the displacement (UL) below which no row between them closes. It is known at small strains without
    /// an own [`Scene::reach`](crate::Scene::reach).
    pub apart: Vec<([BodyId; 2], f64)>,
    /// The bodies that supports alone hold.
    pub held: Vec<BodyId>,
    /// The bodies with a law for small strains.
    pub linear: Vec<BodyId>,
    /// The bodies that do not deform, whose unknowns are their rigid motions.
    pub rigid: Vec<BodyId>,
    /// The bodies whose nodes are all prescribed.
    pub prescribed: Vec<BodyId>,
    /// The bodies that stay as they are: supports hold them in place, and neither loads nor contact nor ties act on them.
    pub at_rest: Vec<BodyId>,
}

impl<const D: usize> Problem<D> {
    /// What is known before a run.
    pub fn plan(&self) -> ScenePlan {
        let energies = self.body_energies();
        let of = |is: &dyn Fn(usize) -> bool| -> Vec<BodyId> {
            let bodies = (0..energies.len()).filter(|&b| is(b));
            bodies.map(BodyId::from).collect()
        };
        let moves = |b: usize| energies[b].dofs() > 0;
        let mut first: Vec<usize> = (0..energies.len()).collect();
        let ties = || self.scene.ties().iter();
        let tied = ties().map(|tie| [&tie.first, &tie.second].map(|side| side.body.index()));
        for [a, b] in Separable::passes(self).into_iter().chain(tied.clone()) {
            // what is prescribed joins nothing
            if moves(a) && moves(b) {
                let (kept, other) = (first[a].min(first[b]), first[a].max(first[b]));
                let joined = first.iter_mut().filter(|first| **first == other);
                joined.for_each(|first| *first = kept);
            }
        }
        let mut open = BTreeMap::<[usize; 2], f64>::new();
        let mut touched = vec![false; energies.len()];
        for pass in self.passes() {
            let bodies = self.bodies_of(*pass);
            for body in bodies {
                touched.get_mut(body).into_iter().for_each(|t| *t = true);
            }
            let [a, b] = bodies;
            let least = open.entry([a.min(b), a.max(b)]).or_insert(f64::INFINITY);
            *least = least.min(self.contact.open_below(*pass));
        }
        tied.flatten().for_each(|body| touched[body] = true);
        let apart = open.into_iter().filter(|(_, below)| *below > 0.0);
        let is_at_rest = |b: usize| {
            let body = &self.scene.bodies()[b];
            let is_still = !body.has_program() && body.largest() == (0.0, 0.0);
            is_still && self.is_held(b) && !touched[b]
        };
        let groups = (0..energies.len()).filter(|&b| first[b] == b && moves(b));
        ScenePlan {
            groups: groups.map(|g| of(&|b| first[b] == g && moves(b))).collect(),
            apart: apart
                .map(|(bodies, below)| (bodies.map(BodyId::from), below))
                .collect(),
            held: of(&|b| self.is_held(b)),
            linear: of(&|b| energies[b].is_quadratic() && !self.scene.bodies()[b].is_rigid()),
            rigid: of(&|b| moves(b) && self.scene.bodies()[b].is_rigid()),
            prescribed: of(&|b| !moves(b)),
            at_rest: of(&is_at_rest),
        }
    }
}

/// "1 body", "2 bodies".
fn counted(count: usize) -> String {
    match count {
        1 => "1 body".into(),
        _ => format!("{count} bodies"),
    }
}

impl fmt::Display for ScenePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bodies: usize = self.groups.iter().map(Vec::len).sum();
        let largest = self.groups.iter().map(Vec::len).max().unwrap_or(0);
        f.write_str(&counted(bodies + self.prescribed.len()))?;
        let kinds = [
            (self.linear.len(), "with a law for small strains"),
            (self.rigid.len(), "rigid"),
            (self.prescribed.len(), "prescribed at all nodes"),
            (self.held.len(), "held without contact"),
        ];
        let kinds = kinds.into_iter().filter(|(count, _)| *count > 0);
        kinds
            .zip([": ", ", ", ", ", ", "])
            .try_for_each(|((count, kind), before)| write!(f, "{before}{count} {kind}"))?;
        match (self.groups.len(), largest) {
            (_, 0 | 1) => f.write_str("; each is solved by itself")?,
            (1, _) => write!(f, "; contact or ties may join {}", counted(largest))?,
            (groups, _) => write!(
                f,
                "; contact or ties may join {} to {groups} groups, of {} at most",
                counted(bodies),
                counted(largest)
            )?,
        }
        match self.at_rest.len() {
            0 => {}
            1 => f.write_str("; 1 body stays as it is")?,
            count => write!(f, "; {count} bodies stay as they are")?,
        }
        let below = self.apart.iter().map(|(_, below)| *below);
        match (below.reduce(f64::min), self.apart.len()) {
            (None, _) => Ok(()),
            (Some(below), 1) => write!(
                f,
                "; 1 pair of bodies stays open while displacements are below {below:.1e}"
            ),
            (Some(below), count) => write!(
                f,
                "; {count} pairs of bodies stay open while displacements are below {below:.1e}"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use contact_core::{Equilibrium, LoadStepped, Outcome, State};

    use super::*;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::model::contact_set::WAY;
    use crate::simulation::{DefaultSolver, Simulation};
    use crate::tensor::Vector;
    use crate::{Body, LinearElastic, NeoHookean, Scene};

    /// A held linear block, a loose neo-Hookean one on it, a tool above, and a second block under the tool.
    #[test]
    fn plans_tell_what_is_known() {
        let mesh = |x: f64, y: f64| {
            let [xs, ys] = [x, y].map(|low| linspace(low, low + 1.0, 2));
            rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
        };
        let soft = || NeoHookean::new(1.0, 0.3).expect("a law");
        let mut base = Body::new(mesh(0.0, 0.0), LinearElastic::new(1.0, 0.3).expect("a law"));
        base.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let loose = Body::new(mesh(0.0, 1.0), soft());
        let mut tool = Body::new(mesh(0.0, 2.0), soft());
        tool.prescribe_all([Some(0.0), Some(-0.1)]).expect("moved");
        let mut beside = Body::new(mesh(3.0, 1.0), soft());
        beside.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        scene.geometry = Some(crate::model::Geometry::Current);
        let base = scene.add("base", base);
        let loose = scene.add("loose", loose);
        let tool = scene.add("tool", tool);
        let beside = scene.add("beside", beside);
        scene
            .contact(base.on("top"), loose.on("bottom"))
            .expect("a pair");
        scene
            .contact(loose.on("top"), tool.on("bottom"))
            .expect("a pair");
        scene
            .contact(beside.on("top"), tool.on("right"))
            .expect("a pair");
        let plan = scene.problem().expect("a problem").plan();
        assert_eq!(plan.groups, [vec![base, loose], vec![beside]]);
        assert_eq!(plan.held, [base, tool, beside]);
        assert_eq!(plan.linear, [base]);
        assert_eq!(plan.prescribed, [tool]);
        let told = "4 bodies: 1 with a law for small strains, 1 prescribed at all nodes, 3 held without contact; contact or ties may \
                    join 3 bodies to 2 groups, of 2 bodies at most";
        assert_eq!(plan.to_string(), told);
    }

    /// Three linear blocks of ten by ten cells: one above the other with a gap of 0.2, pushed down by `push`, and one aside.
    fn blocks(push: f64) -> Problem<2> {
        let block = |x: f64, y: f64, side: &str, push: f64| {
            let [xs, ys] = [x, y].map(|low| linspace(low, low + 1.0, 10));
            let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
            let mut block = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("a law"));
            let pushed = [Some(0.0), Some(-push)];
            block.prescribe(side, pushed).expect("a support");
            block
        };
        let mut scene = Scene::new();
        let lower = scene.add("lower", block(0.0, 0.0, "bottom", 0.0));
        let upper = scene.add("upper", block(0.0, 1.2, "top", push));
        scene.add("aside", block(3.0, 0.0, "bottom", 0.0));
        let pair = scene.contact(lower.on("top"), upper.on("bottom"));
        pair.expect("a pair");
        scene.problem().expect("a problem")
    }

    #[test]
    fn plans_tell_how_far_bodies_may_move() {
        let plan = blocks(0.01).plan();
        assert_eq!(plan.at_rest, [BodyId::from(2)]);
        let [(pair, below)] = plan.apart[..] else {
            panic!("{plan}");
        };
        assert_eq!(pair, [0, 1].map(BodyId::from));
        // a gap of 0.2 between facets of 0.1
        assert!((below - 0.1 / 8.0).abs() < 1e-12, "{below}");
        let told = "1 body stays as it is; 1 pair of bodies stays open while displacements are below 1.2e-2";
        assert!(plan.to_string().ends_with(told), "{plan}");
    }

    /// Blocks that are planned as out of reach of each other are pushed together.
    #[test]
    fn plans_that_do_not_hold_are_given_up() {
        let sound = Simulation::with_increments(2).run(&mut blocks(0.25));
        let sound = sound.expect("no misuse");
        let mut problem = blocks(0.25);
        problem.contact.way = 1e-3;
        assert!(problem.plan().apart[0].1 > 99.0);
        // a solver that believes it leaves one block within the other
        problem.set_load(1.0).expect("a load");
        let start = State {
            u: vec![0.0; problem.dofs().free()],
            ..State::default()
        };
        let believed = DefaultSolver::default().solve_from(&problem, start);
        let believed = believed.expect("no misuse");
        assert_eq!(believed.outcome, Outcome::Converged);
        assert!(believed.gaps.is_empty());
        let depth = problem.audit(&believed.state.u).expect("a state").overlaps[0].depth;
        assert!((depth - 0.05).abs() < 1e-9, "{depth}");

        let run = Simulation::with_increments(2).run(&mut problem);
        let run = run.expect("no misuse");
        assert!(run.is_complete(), "{}", run.run.ending);
        // at half of the load there is still a gap
        let refuted: Vec<usize> = run.run.attempts.iter().map(|a| a.failed.len()).collect();
        assert_eq!(refuted, [0, 1]);
        let failed = &run.run.attempts[1].failed[0];
        assert!(matches!(failed.outcome, Outcome::Unplanned(_)), "{failed}");
        let told = "condensed: body `lower` and body `upper` came together; constraints that had been left out are added";
        assert_eq!(failed.to_string(), told);
        let [a, b] = [&run, &sound].map(|run| run.last().expect("a step"));
        assert!((a.energy - b.energy).abs() < 1e-12 * b.energy);
        assert!(
            a.certificate.holds(&Default::default()),
            "{}",
            a.certificate
        );
        assert!(b.contact_force(0usize)[1] < -0.01);
        assert!(problem.plan().apart.is_empty());
    }

    /// Bodies that come closer than planned without touching are no fault.
    #[test]
    fn plans_hold_as_long_as_nothing_touches() {
        let mut problem = blocks(0.18);
        problem.contact.way = 1e-3;
        let run = Simulation::with_increments(1).run(&mut problem);
        let run = run.expect("no misuse");
        assert!(run.is_complete());
        assert!(run.run.attempts[0].failed.is_empty());
        assert_eq!(problem.plan().apart.len(), 1);
    }

    /// A quadratic facet that is fifty times as long as the others, and curved so that it is above all nodes by 0.09, comes to a
    /// block above it that no node comes to: what the plan leaves out changes nothing.
    #[test]
    fn curved_facets_beyond_their_nodes_are_met() {
        let problem = |way: f64| {
            let law = || LinearElastic::new(1.0, 0.3).expect("a law");
            let mut xs = vec![0.0];
            xs.extend(linspace(1.0, 3.0, 100));
            let mesh = rectangle(&xs, &linspace(0.0, 1.0, 2), Diagonals::Rising);
            let high = |x: f64| {
                if x <= 1.0 {
                    1.0 + 2.8 * x - 1.8 * x * x
                } else {
                    2.0
                }
            };
            let curved = |X: &Vector<2>| Vector::<2>::new(X[0], X[1] * high(X[0]));
            let mesh = mesh.expect("a mesh").quadratic().mapped(curved);
            let mut lower = Body::new(mesh.expect("a mesh"), law());
            lower
                .prescribe("bottom", [Some(0.0); 2])
                .expect("a support");
            let (xs, ys) = (linspace(0.5, 1.1, 30), linspace(2.0899, 2.2899, 10));
            let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
            let mut upper = Body::new(mesh.quadratic(), law());
            let pushed = [Some(0.0), Some(-0.005)];
            upper.prescribe("top", pushed).expect("a support");
            let mut scene = Scene::new();
            let lower = scene.add("lower", lower);
            let upper = scene.add("upper", upper);
            let pair = scene.contact(lower.on("top"), upper.on("bottom"));
            pair.expect("a pair");
            let mut problem = scene.problem().expect("a problem");
            problem.contact.way = way;
            problem
        };
        // planned, planned wrongly, and all searched
        let [planned, wrongly, all] = [WAY, 1e-3, 1e9].map(|way| {
            let run = Simulation::with_increments(1).run(&mut problem(way));
            run.expect("no misuse").last().expect("a step").clone()
        });
        assert!(all.contact_force(0usize)[1] < -1e-3);
        for some in [planned, wrongly] {
            assert!(
                (some.energy / all.energy - 1.0).abs() < 1e-9,
                "{}",
                some.energy
            );
        }
    }
}
