//! Planted states, each with one violation whose size is known by hand.

use contact_core::equilibrium::Solution;
use contact_core::gaps::{Row, Sampling};
use contact_core::{ContactProblem, LinearGaps, LoadStepped, Multipliers, Outcome};
use contact_core::{RowKey, State};

use super::*;
use crate::assembly::Dof;
use crate::mesh::generators::{Diagonals, linspace, rectangle};
use crate::model::{InitialGaps, Integration, Passes, Problem, Scene};
use crate::tensor::Vector;
use crate::{Body, LinearElastic, Mesh, NeoHookean};

/// Two blocks of 1 by 1 with sides of `cells` cells; the upper one is `gap` above the lower one.
struct Blocks {
    cells: [usize; 2],
    gap: f64,
    passes: Passes,
    integration: Option<Integration>,
    initial_gaps: InitialGaps,
    is_linear: bool,
}

impl Default for Blocks {
    fn default() -> Self {
        Blocks {
            cells: [3, 3],
            gap: 0.0,
            passes: Passes::Both,
            integration: None,
            initial_gaps: InitialGaps::Refuse,
            is_linear: true,
        }
    }
}

/// Young's modulus; Poisson's ratio is 0.
const E: f64 = 50.0;

impl Blocks {
    /// With supports and loads as `prepare` makes them. The left sides are at x = 7.
    fn problem(&self, prepare: impl Fn([&mut Body<2>; 2])) -> Problem<2> {
        let block = |k: usize, y: f64| {
            let [xs, ys] = [7.0, y].map(|from| linspace(from, from + 1.0, self.cells[k]));
            let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
            match self.is_linear {
                true => Body::new(mesh, LinearElastic::new(E, 0.0).expect("law")),
                false => Body::new(mesh, NeoHookean::new(E, 0.0).expect("law")),
            }
        };
        let (mut lower, mut upper) = (block(0, 0.0), block(1, 1.0 + self.gap));
        prepare([&mut lower, &mut upper]);
        let mut scene = Scene::new();
        scene.integration = self.integration;
        scene.initial_gaps = self.initial_gaps;
        let lower = scene.add("lower", lower).on("top");
        let upper = scene.add("upper", upper).on("bottom");
        scene
            .contact_in_passes(lower, upper, self.passes)
            .expect("a pair");
        scene.problem().expect("a problem")
    }

    /// The lower block held at its bottom, the upper one pushed down by `push` at its top.
    fn held(&self, push: f64) -> Problem<2> {
        self.problem(|[lower, upper]| {
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            let pushed = [Some(0.0), Some(-push)];
            upper.prescribe("top", pushed).expect("support");
        })
    }
}

/// The free components of a displacement field of body and position.
fn field(problem: &Problem<2>, at: impl Fn(usize, &Vector<2>) -> [f64; 2]) -> Vec<f64> {
    let mut u = vec![0.0; problem.dofs().free()];
    for body in 0..2 {
        for node in problem.nodes(body) {
            let value = at(body, &problem.reference()[node]);
            for (i, value) in value.into_iter().enumerate() {
                if let Dof::Free(k) = problem.dofs().get(2 * node + i) {
                    u[k] = value;
                }
            }
        }
    }
    u
}

fn rest(problem: &Problem<2>) -> Vec<f64> {
    vec![0.0; problem.dofs().free()]
}

/// The free unknown of a component of the node at this place of a body.
fn unknown(problem: &Problem<2>, body: usize, place: [f64; 2], component: usize) -> usize {
    let near = |a: &usize| (problem.reference()[*a] - Vector::from(place)).norm() < 1e-9;
    let node = problem.nodes(body).find(near).expect("a node");
    match problem.dofs().get(2 * node + component) {
        Dof::Free(k) => k,
        Dof::Prescribed(_) => panic!("prescribed"),
    }
}

fn state(u: Vec<f64>, gaps: LinearGaps, lambda: Vec<f64>) -> Solution {
    Solution {
        outcome: Outcome::Converged,
        energy: 0.0,
        state: State {
            u,
            multipliers: Multipliers::new(&gaps, &lambda),
        },
        gaps,
        lambda,
        history: Vec::new(),
        failed: Vec::new(),
        curvature: None,
        flickering: Vec::new(),
        held: Vec::new(),
        softest: None,
        friction: None,
    }
}

/// The residual of a condition, which applies.
fn left(problem: &Problem<2>, solution: &Solution, condition: Condition) -> f64 {
    let certificate = Certificate::new(problem, solution);
    certificate.left(condition).expect("applies")
}

fn assert_left(problem: &Problem<2>, solution: &Solution, condition: Condition, expected: f64) {
    let left = left(problem, solution, condition);
    let close = (left - expected).abs() <= 1e-8 * expected.abs() + 1e-11;
    assert!(close, "{condition:?}: {left} instead of {expected}");
}

/// Rows of one entry each, on the free unknowns `k`, with these forces.
fn single_rows(entries: &[(&[(usize, f64)], f64)]) -> (LinearGaps, Vec<f64>) {
    let mut gaps = LinearGaps::new(true);
    for (node, (free, _)) in entries.iter().enumerate() {
        let key = RowKey {
            pass: 0,
            node: node as u32,
        };
        let row = Row {
            free: free.to_vec(),
            ..Row::default()
        };
        gaps.push(key, &row);
    }
    (gaps, entries.iter().map(|(_, force)| *force).collect())
}

/// Blocks under a uniform stress t: the strain is t/E in both, and each of two passes carries half
/// of the force. Half of the load is half of it all.
#[test]
fn an_exact_state_leaves_round_off() {
    for (passes, share) in [(Passes::Both, 0.5), (Passes::SecondIsSlave, 1.0)] {
        let t = 3.0;
        let blocks = Blocks {
            passes,
            ..Blocks::default()
        };
        let mut problem = blocks.problem(|[lower, upper]| {
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            upper.prescribe("left", [Some(0.0), None]).expect("support");
            upper.traction("top", [0.0, -t]).expect("load");
        });
        for load in [0.5, 1.0] {
            problem.set_load(load).expect("load");
            let u = field(&problem, |_, X| [0.0, -load * t / E * X[1]]);
            let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
            let lambda = gaps.weights().iter().map(|a| load * t * share * a);
            let lambda = lambda.collect();
            let certificate = Certificate::new(&problem, &state(u, gaps, lambda));
            let by_solvers = [
                Condition::OtherSide,
                Condition::Held,
                Condition::Instability,
                Condition::FrictionLaw,
                Condition::FrictionSlip,
                Condition::RemeasuredFriction,
                Condition::VirtualWork,
            ];
            for condition in Condition::all().filter(|c| !by_solvers.contains(c)) {
                // strains are of order 0.06
                let least = match condition {
                    Condition::SmallStrain => 0.1,
                    Condition::EnergySlope => 1e-8,
                    _ => 1e-10,
                };
                let left = certificate.left(condition).expect("applies");
                assert!(left <= least, "{passes:?} {load} {condition:?}: {left}");
            }
            assert!(certificate.holds(&Limits::default()), "{certificate}");
        }
    }
}

/// Two blocks under a uniform stress, whose rows go by each other's names, are open by a hundredth, or push with half of the weight on the
/// master. Whatever shares their search sees no fault in them; the second measurement does, and sees none in sound rows.
#[test]
fn rows_that_are_not_those_of_the_surfaces() {
    let t = 3.0;
    let problem = Blocks::default().problem(|[lower, upper]| {
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        upper.prescribe("left", [Some(0.0), None]).expect("support");
        upper.traction("top", [0.0, -t]).expect("load");
    });
    let u = field(&problem, |_, X| [0.0, -t / E * X[1]]);
    let mut problem = problem;
    problem.set_load(1.0).expect("load");
    let sound = problem.rows(&u, Sampling::Nodes).expect("a state");
    let lambda: Vec<f64> = sound.weights().iter().map(|a| 0.5 * t * a).collect();
    let with = |change: &dyn Fn(usize, &mut Row) -> RowKey| {
        let mut gaps = LinearGaps::new(true);
        for i in 0..sound.len() {
            let mut row = sound.row(i);
            let key = change(i, &mut row);
            gaps.push(key, &row);
        }
        Certificate::new(&problem, &state(u.clone(), gaps, lambda.clone()))
    };
    let keys = sound.keys();
    let (forces, areas) = (Condition::RemeasuredForces, Condition::RemeasuredAreas);
    let left = |certificate: &Certificate, of: Condition| certificate.left(of).expect("applies");
    let limits = Limits::default();
    let as_it_is = with(&|i, _| keys[i]);
    assert!(left(&as_it_is, forces) < 1e-6 && left(&as_it_is, areas) < 1e-9);
    let renamed = with(&|i, _| keys[(i + 1) % keys.len()]);
    assert!(left(&renamed, forces) > limits.of(forces), "{renamed}");
    assert!(left(&renamed, areas) > limits.of(areas), "{renamed}");
    let halved = with(&|i, row| {
        let entries = row.free.iter_mut().filter(|(_, c)| *c < 0.0);
        entries.for_each(|(_, c)| *c *= 0.5);
        keys[i]
    });
    assert!(left(&halved, forces) > limits.of(forces), "{halved}");
    assert!(left(&halved, Condition::PairBalance) > 0.1, "{halved}");
    assert!(left(&halved, Condition::EnergySlope) > limits.of(Condition::EnergySlope));
    let heavy = with(&|i, row| {
        row.weight *= 1.5;
        keys[i]
    });
    assert!((left(&heavy, areas) - 0.5).abs() < 1e-9, "{heavy}");
}

/// Forces p a_i across an open gap h, while nothing is strained. The largest force on a node is
/// p a_i of an inner node, on either body.
#[test]
fn forces_across_an_open_gap() {
    let (h, p) = (1e-3, 0.7);
    for passes in [Passes::FirstIsSlave, Passes::SecondIsSlave] {
        let blocks = Blocks {
            gap: h,
            passes,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let u = rest(&problem);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let pushed: Vec<f64> = gaps.weights().iter().map(|a| p * a).collect();
        let pulled = pushed.iter().map(|force| -force).collect();
        let pushed = state(u.clone(), gaps.clone(), pushed);
        let scale = problem.scale();
        assert!(scale.resolution < 0.1 * scale.length);
        let complementarity = h / scale.resolution;
        assert_left(
            &problem,
            &pushed,
            Condition::Complementarity,
            complementarity,
        );
        // nothing but the contact force acts on a node of the surface
        assert_left(&problem, &pushed, Condition::Stationarity, 1.0);
        assert_left(&problem, &pushed, Condition::Adhesion, 0.0);
        assert_left(&problem, &pushed, Condition::ActionReaction, 0.0);
        assert_left(&problem, &pushed, Condition::Moment, 0.0);
        let pulled = state(u, gaps, pulled);
        assert_left(&problem, &pulled, Condition::Adhesion, 1.0);
    }
}

/// One node of either body is out of place, in a scene without any force. What it is pulled back
/// with is the difference of energies, and the unit is the smallest one.
#[test]
fn one_node_out_of_place() {
    let blocks = Blocks {
        gap: 1e-3,
        ..Blocks::default()
    };
    let problem = blocks.held(0.1);
    let third = 1.0 / 3.0;
    for (body, place) in [(0, [7.0 + third, 2.0 * third]), (1, [7.0 + third, 1.001])] {
        let mut u = rest(&problem);
        let k = unknown(&problem, body, place, 0);
        u[k] = 1e-5;
        let energy = |k: usize, step: f64| {
            let mut moved = u.clone();
            moved[k] += step;
            problem.energy().value(&moved)
        };
        let slope = |k: usize| (energy(k, 1e-7) - energy(k, -1e-7)) / 2e-7;
        let most = (0..u.len()).map(|k| slope(k).abs()).fold(0.0, f64::max);
        let scale = problem.scale();
        let noticed = 1e-4 * scale.energy / scale.length;
        assert!(most < noticed && most > 1e-3 * noticed, "{most} {noticed}");
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let found = left(
            &problem,
            &state(u.clone(), gaps, lambda),
            Condition::Stationarity,
        );
        assert!(
            (found / (most / noticed) - 1.0).abs() < 1e-6,
            "body {body}: {found} instead of {}",
            most / noticed
        );
    }
}

/// A force of 3 up and one of 1 down that nothing answers.
#[test]
fn forces_without_reaction() {
    let problem = Blocks::default().held(0.1);
    let a = unknown(&problem, 0, [7.0, 1.0], 1);
    let b = unknown(&problem, 1, [8.0, 1.0], 1);
    let (gaps, lambda) = single_rows(&[(&[(a, 1.0)], 3.0), (&[(b, -1.0)], 1.0)]);
    let alone = state(rest(&problem), gaps, lambda);
    assert_left(&problem, &alone, Condition::ActionReaction, 2.0 / 4.0);
}

/// Two opposite forces of 2 at opposite corners: their moment is 2 times 1, of 2 · 2 · ½ at most.
/// In the current geometry the arm is that of the moved corner.
#[test]
fn a_couple() {
    for (is_linear, moved) in [(true, 0.0), (true, 0.2), (false, 0.2)] {
        let blocks = Blocks {
            is_linear,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let a = unknown(&problem, 0, [7.0, 1.0], 1);
        let b = unknown(&problem, 1, [8.0, 1.0], 1);
        let mut u = rest(&problem);
        u[unknown(&problem, 1, [8.0, 1.0], 0)] = moved;
        let (gaps, lambda) = single_rows(&[(&[(a, 1.0), (b, -1.0)], 2.0)]);
        // the blocks have 16 nodes each, and their common centre is half-way between the corners
        let moved = if is_linear { 0.0 } else { moved };
        let centre = 0.5 + moved / 32.0;
        let moment = 2.0 * (1.0 + moved);
        let most = 2.0 * centre + 2.0 * (1.0 + moved - centre);
        let couple = state(u, gaps, lambda);
        assert_left(&problem, &couple, Condition::ActionReaction, 0.0);
        assert_left(&problem, &couple, Condition::Moment, moment / most);
    }
}

/// A couple whose ends are not in line with the centre: forces of 1 along y at the sides of the lower
/// block, ⅔ below the centre. In the current geometry one of them is moved aside by 0.2, and the centre
/// of all 32 nodes with it.
#[test]
fn a_couple_beside_the_centre() {
    for (is_linear, moved) in [(true, 0.0), (true, 0.2), (false, 0.2)] {
        let blocks = Blocks {
            is_linear,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let [a, b] = [7.0, 8.0].map(|x| unknown(&problem, 0, [x, 1.0 / 3.0], 1));
        let mut u = rest(&problem);
        u[unknown(&problem, 0, [8.0, 1.0 / 3.0], 0)] = moved;
        let (gaps, lambda) = single_rows(&[(&[(a, 1.0), (b, -1.0)], 1.0)]);
        let moved = if is_linear { 0.0 } else { moved };
        let (centre, below) = (0.5 + moved / 32.0, 2.0 / 3.0f64);
        let arms = below.hypot(centre) + below.hypot(1.0 + moved - centre);
        let couple = state(u, gaps, lambda);
        assert_left(&problem, &couple, Condition::Moment, (1.0 + moved) / arms);
    }
}

/// A traction of (4, −3) on top, which nothing holds yet: at any load, all of it is left.
#[test]
fn a_load_that_nothing_carries() {
    let mut problem = Blocks::default().problem(|[lower, upper]| {
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let bottom = upper.mesh().boundary_nodes("bottom").expect("named");
        let left = upper.mesh().nodes()[bottom[0]];
        assert!((left - Vector::<2>::new(7.0, 1.0)).norm() < 1e-9);
        upper
            .prescribe_nodes(&bottom[..1], [Some(0.0), None])
            .expect("support");
        upper.traction("top", [4.0, -3.0]).expect("load");
    });
    for load in [0.5, 1.0] {
        problem.set_load(load).expect("load");
        let u = rest(&problem);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let still = state(u, gaps, lambda);
        assert_left(&problem, &still, Condition::Balance, 1.0);
        assert_left(&problem, &still, Condition::Stationarity, 1.0);
    }
}

/// What a facet of this length moves by: the unit of weak gaps on the surface of such facets.
fn unit(problem: &Problem<2>, facet: f64) -> f64 {
    let scale = problem.scale();
    scale.resolution / scale.area * facet
}

/// The upper block without its support, moved down by `by`.
fn lowered(problem: &Problem<2>, by: f64) -> Vec<f64> {
    field(problem, |body, _| [0.0, if body == 1 { -by } else { 0.0 }])
}

/// Four cells on two, moved into them: every depth is that of a block, in units of the slave's
/// facets; the other side has facets of half the length.
#[test]
fn blocks_inside_each_other() {
    let d = 1e-3;
    for (passes, facets) in [
        (Passes::FirstIsSlave, [0.5, 0.25]),
        (Passes::SecondIsSlave, [0.25, 0.5]),
    ] {
        let blocks = Blocks {
            cells: [2, 4],
            passes,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let u = lowered(&problem, d);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let deep = state(u, gaps, lambda);
        let [own, other] = facets.map(|facet| d / unit(&problem, facet));
        assert_left(&problem, &deep, Condition::WeakPenetration, own);
        assert_left(&problem, &deep, Condition::OtherSide, other);
        assert_left(&problem, &deep, Condition::NodalPenetration, d / facets[0]);
    }
}

/// A depth of a tenth of a facet is an overlap whoever is the slave, and unopposed unless forces that
/// can be noticed push the bodies apart.
#[test]
fn overlaps_with_and_without_a_force() {
    let facet = 1.0 / 3.0;
    for passes in [Passes::FirstIsSlave, Passes::SecondIsSlave, Passes::Both] {
        let blocks = Blocks {
            passes,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let u = lowered(&problem, 0.1 * facet);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let scale = problem.scale();
        let noticed = 1e-4 * scale.energy / scale.length;
        for (force, unopposed) in [(0.0, 0.1), (0.9 * noticed, 0.1), (1.1 * noticed, 0.0)] {
            let mut lambda = vec![0.0; gaps.len()];
            lambda[1] = force;
            let deep = state(u.clone(), gaps.clone(), lambda);
            assert_left(&problem, &deep, Condition::Overlap, 0.1);
            assert_left(&problem, &deep, Condition::Unopposed, unopposed);
        }
    }
}

/// Bodies that start in each other by a tenth of a facet: half of that is granted at half the load.
#[test]
fn what_is_left_of_an_initial_overlap_is_granted() {
    let facet = 1.0 / 3.0;
    let blocks = Blocks {
        gap: -0.1 * facet,
        initial_gaps: InitialGaps::Resolve,
        ..Blocks::default()
    };
    let mut problem = blocks.held(0.0);
    for load in [0.0, 0.5, 1.0] {
        problem.set_load(load).expect("load");
        let u = rest(&problem);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let deep = state(u, gaps, lambda);
        assert_left(&problem, &deep, Condition::Overlap, 0.1 * load);
        assert_left(&problem, &deep, Condition::NodalPenetration, 0.1 * load);
    }
}

/// Rows that the solver has not: they are closed up to 2e-3 of what a facet moves by.
#[test]
fn rows_that_the_solver_has_not() {
    let blocks = Blocks {
        passes: Passes::FirstIsSlave,
        ..Blocks::default()
    };
    let problem = blocks.held(0.1);
    for (open, closed) in [(-1.0, 2.0), (0.0, 2.0), (1e-3, 2.0), (3e-3, 0.0)] {
        let u = lowered(&problem, -open * unit(&problem, 1.0 / 3.0));
        let all = problem.rows(&u, Sampling::Nodes).expect("a state");
        assert_eq!(all.len(), 4);
        let mut gaps = LinearGaps::new(true);
        for i in [0, 3] {
            gaps.push(all.keys()[i], &all.row(i));
        }
        let solution = state(u, gaps, vec![0.0; 2]);
        assert_left(&problem, &solution, Condition::Closed, closed);
        assert_left(&problem, &solution, Condition::Dropped, 2.0);
    }
}

/// Points without lasting names: the one of the least area is missing, or it alone is there.
#[test]
fn points_that_the_solver_has_not() {
    let blocks = Blocks {
        cells: [2, 3],
        passes: Passes::FirstIsSlave,
        integration: Some(Integration::Exact),
        ..Blocks::default()
    };
    let problem = blocks.held(0.1);
    let u = rest(&problem);
    let all = problem.rows(&u, Sampling::Points).expect("a state");
    let total: f64 = all.weights().iter().sum();
    assert!((total - 1.0).abs() < 1e-12, "the block is 1 wide: {total}");
    let rows = 0..all.len();
    let least = rows.min_by(|&i, &j| all.weights()[i].total_cmp(&all.weights()[j]));
    let least = least.expect("points");
    for (keep_it, closed) in [(None, 0.0), (Some(false), 1.0), (Some(true), 1.0)] {
        let mut gaps = LinearGaps::new(true).sampled_at(Sampling::Points);
        for i in 0..all.len() {
            if keep_it.is_none_or(|keep| keep == (i == least)) {
                gaps.push(all.keys()[i], &all.row(i));
            }
        }
        let lambda = vec![0.0; gaps.len()];
        let solution = state(u.clone(), gaps, lambda);
        assert_left(&problem, &solution, Condition::Closed, closed);
        // the nodes of the surface all have a row, whatever points the solver has
        assert_left(&problem, &solution, Condition::Dropped, 0.0);
        let certificate = Certificate::new(&problem, &solution);
        assert_eq!(certificate.left(Condition::Drift), None);
    }
}

/// The solver's rows are longer than those at the state by a hundredth.
#[test]
fn rows_that_have_changed() {
    let problem = Blocks::default().held(0.1);
    let u = rest(&problem);
    let now = problem.rows(&u, Sampling::Nodes).expect("a state");
    let mut gaps = LinearGaps::new(true);
    for (i, key) in now.keys().iter().enumerate() {
        let mut row = now.row(i);
        let entries = row.free.iter_mut().chain(&mut row.prescribed);
        entries.for_each(|(_, c)| *c *= 1.01);
        gaps.push(*key, &row);
    }
    let lambda = now.weights().iter().map(|a| 20.0 * a).collect();
    let solution = state(u, gaps, lambda);
    assert_left(&problem, &solution, Condition::Drift, 0.01 / 1.01);
}

/// A node pulled across its neighbours turns triangles over, also where the law does not mind.
#[test]
fn triangles_turned_over() {
    for is_linear in [true, false] {
        let blocks = Blocks {
            is_linear,
            ..Blocks::default()
        };
        let problem = blocks.held(0.1);
        let third = 1.0 / 3.0;
        let mut u = rest(&problem);
        u[unknown(&problem, 0, [7.0 + third, third], 0)] = 0.6;
        let x = problem.positions(&u);
        let mut turned = 0.0;
        for body in 0..2 {
            let first = problem.first_node(body);
            let mesh: &Mesh<2> = problem.scene().bodies()[body].mesh();
            for cell in mesh.cells() {
                let [a, b, c] = [0, 1, 2].map(|k| x[first + cell[k]]);
                let (e, f) = (b - a, c - a);
                turned += f64::from(u8::from(e[0] * f[1] - e[1] * f[0] <= 0.0));
            }
        }
        assert!(turned > 1.0);
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let folded = state(u, gaps, lambda);
        assert_left(&problem, &folded, Condition::Inverted, turned);
    }
}

/// The upper block is turned by 0.3: the strain of a linear law is √2 (1 − cos), the rotation the sine.
#[test]
fn a_block_turned_as_a_whole() {
    let (sin, cos) = 0.3f64.sin_cos();
    let turn = |X: &Vector<2>| {
        let (x, y) = (X[0] - 7.5, X[1] - 3.0);
        [cos * x - sin * y - x, sin * x + cos * y - y]
    };
    for is_linear in [true, false] {
        let blocks = Blocks {
            is_linear,
            gap: 1.0,
            ..Blocks::default()
        };
        let mut problem = blocks.problem(|[lower, upper]| {
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            let top = upper.mesh().boundary_nodes("top").expect("named");
            for node in top {
                let value = turn(&upper.mesh().nodes()[node]).map(Some);
                upper.prescribe_nodes(&[node], value).expect("support");
            }
        });
        problem.set_load(1.0).expect("load");
        let u = field(&problem, |body, X| match body {
            0 => [0.0; 2],
            _ => turn(X),
        });
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![0.0; gaps.len()];
        let turned = state(u, gaps, lambda);
        match is_linear {
            true => assert_left(&problem, &turned, Condition::SmallStrain, sin),
            false => assert_eq!(
                Certificate::new(&problem, &turned).left(Condition::SmallStrain),
                None
            ),
        }
    }
}

/// Nothing is certified of a solution that is not one of the problem, or not finite.
#[test]
fn solutions_of_another_kind_have_no_residuals() {
    let problem = Blocks::default().held(0.1);
    let u = rest(&problem);
    let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
    let lambda = vec![0.0; gaps.len()];
    let sound = state(u, gaps, lambda);
    let spoilt: [fn(&mut Solution); 7] = [
        |s| s.state.u.push(0.0),
        |s| s.state.u.truncate(5),
        |s| s.lambda.push(0.0),
        |s| s.lambda.truncate(2),
        |s| s.state.u[3] = f64::NAN,
        |s| s.lambda[3] = f64::INFINITY,
        |s| {
            let of_no_pass = RowKey { pass: 9, node: 0 };
            s.gaps.push(of_no_pass, &s.gaps.row(0));
            s.lambda.push(0.0);
        },
    ];
    assert!(Certificate::new(&problem, &sound).holds(&Limits::default()));
    for spoil in spoilt {
        let mut solution = sound.clone();
        spoil(&mut solution);
        let certificate = Certificate::new(&problem, &solution);
        for condition in Condition::all() {
            let left = certificate.left(condition);
            assert!(left.is_some_and(f64::is_nan), "{condition:?}: {left:?}");
        }
        assert!(!certificate.holds(&Limits::default()));
    }
}
