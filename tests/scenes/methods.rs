//! The three methods for step 5 on the same scenes: the interior point (7), the penalised slack
//! (37) and the penalty (39).

use crate::common::{UNITS, disc_in_disc, relative, run, run_with};
use contact_core::Ending;
use contact_core::gaps::Sampling;
use contact_core::method::{Continuation, Method, Minimum, PenalizedSlack, Penalty, Subproblem};
use contact_core::{
    ContactProblem, Equilibrium, FixedPoint, InteriorPoint, LinearGaps, LoadStepped, Scale, State,
};
use contact_core::{Outcome, equilibrium::Solution};
use contact_core::{Retry, Solved, Stop};
use contact_fem::element;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::{Integration, Passes, Problem};
use contact_fem::{Body, LinearElastic, Simulation};
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::disc_in_disc::{self, Roles};
use ipopt_contact_scenes::hertz::{Fineness, Hertz};
use ipopt_contact_scenes::pair;
use ipopt_contact_scenes::studies::pointwise::{Pointwise, order};

/// Penalty factors at which errors fall as they do for μ → ∞.
const MUS: [f64; 3] = [1e8, 1e10, 1e12];

const ALL_PASSES: [Passes; 3] = [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave];

fn coarse_hertz() -> Hertz {
    Hertz::new(Fineness::family(5), element::Order::Linear)
}

fn small_beams(order: element::Order) -> Problem<3> {
    let beams = Beams::new(1, order, Law::SmallStrain);
    let scene = beams.scene().expect("a scene");
    scene.problem().expect("valid scene")
}

fn problem_of(hertz: Hertz) -> Problem<2> {
    let scene = hertz.scene().expect("a scene");
    scene.problem().expect("valid scene")
}

/// The fixed point at full load from displacements `u`.
fn solved<const D: usize>(
    problem: &mut Problem<D>,
    method: &mut dyn Method,
    u: Vec<f64>,
) -> Solution {
    problem.set_load(1.0).expect("load");
    let mut fixed_point = FixedPoint {
        tolerance: 1e-7,
        ..FixedPoint::with(method)
    };
    let start = State {
        u,
        ..State::default()
    };
    let solution = fixed_point.solve_from(problem, start).expect("solved");
    assert_eq!(solution.outcome, Outcome::Converged);
    solution
}

/// As [`solved`], from rest.
fn from_rest<const D: usize>(problem: &mut Problem<D>, method: &mut dyn Method) -> Solution {
    let rest = vec![0.0; problem.energy().dofs()];
    solved(problem, method, rest)
}

/// max |a − b| over max |b|.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let apart = largest(&mut a.iter().zip(b).map(|(a, b)| (a - b).abs()));
    apart / largest(&mut b.iter().map(|b| b.abs()))
}

fn assert_order_one_half(what: &str, differences: &[(f64, f64)]) {
    let k = order(differences);
    assert!(
        (0.45..0.55).contains(&k),
        "{what}: order {k} of {differences:?}"
    );
}

/// At full load, from `start`: energies below the limit's, and both energies and displacements tend
/// to it at order 1/2 in μ.
fn assert_tends<const D: usize>(
    problem: &mut Problem<D>,
    limit: &Solution,
    start: &[f64],
    method: impl Fn(Continuation) -> Box<dyn Method>,
) {
    let (mut energies, mut displacements) = (Vec::new(), Vec::new());
    for mu in MUS {
        let mut method = method(Continuation::fixed(mu));
        let found = solved(problem, &mut *method, start.to_vec());
        assert!(found.energy < limit.energy, "what gives way stores less");
        energies.push((mu, relative(found.energy, limit.energy)));
        displacements.push((mu, distance(&found.state.u, &limit.state.u)));
    }
    assert_order_one_half("energy", &energies);
    assert_order_one_half("displacements", &displacements);
}

/// (37) → (7), from (7)'s solution or from rest.
fn assert_slacks_converge<const D: usize>(problem: &mut Problem<D>, start: &[f64]) {
    let limit = solved(problem, &mut InteriorPoint::default(), start.to_vec());
    let slack = |continuation| Box::new(PenalizedSlack::with(continuation)) as Box<dyn Method>;
    assert_tends(problem, &limit, start, slack);
}

/// (39) → (7) with a constraint at every integration point, from the solution of that.
fn assert_penalties_converge<const D: usize>(problem: &mut Problem<D>) {
    let limit = from_rest(problem, &mut Pointwise::default());
    let penalty = |continuation| Box::new(Penalty::with(continuation)) as Box<dyn Method>;
    assert_tends(problem, &limit, &limit.state.u, penalty);
}

#[test]
fn penalised_slacks_tend_to_the_interior_point_at_order_one_half() {
    let mut problem = problem_of(coarse_hertz());
    let rest = vec![0.0; problem.energy().dofs()];
    assert_slacks_converge(&mut problem, &rest);

    for order in [element::Order::Linear, element::Order::Quadratic] {
        let mut problem = small_beams(order);
        let rest = vec![0.0; problem.energy().dofs()];
        assert_slacks_converge(&mut problem, &rest);
    }

    let mut problem = disc_in_disc(16, Roles::default());
    let history = run(&mut problem, 5, 1e-6);
    assert_slacks_converge(&mut problem, &history.run.state.u);
}

/// Bodies that give way by s_i where contact pushes with λ_i store Σ λ_i s_i less; the slope of
/// μ E₀ η(s/L) is the force at s = L √(λ L / (3 μ E₀)). With one pass λ is unique, so that (7)
/// alone foretells what (37) lets through and what that is worth.
#[test]
fn what_a_penalised_slack_lets_through_is_foretold_by_the_interior_point() {
    for passes in [Passes::FirstIsSlave, Passes::SecondIsSlave] {
        let mut problem = problem_of(Hertz {
            passes,
            ..coarse_hertz()
        });
        let Scale { length, energy, .. } = problem.scale();
        let exact = from_rest(&mut problem, &mut InteriorPoint::default());
        let mu = 1e10;
        let slacks = exact
            .lambda
            .iter()
            .map(|l| length * (l * length / (3.0 * mu * energy)).sqrt());
        let work: f64 = exact
            .lambda
            .iter()
            .zip(slacks.clone())
            .map(|(l, s)| l * s)
            .sum();

        let mut method = PenalizedSlack::with(Continuation::fixed(mu));
        let found = from_rest(&mut problem, &mut method);
        assert!(relative(exact.energy - found.energy, work) < 1e-3);
        let mut c = vec![0.0; found.gaps.len()];
        found.gaps.value(&found.state.u, &mut c);
        let deepest = slacks.clone().fold(0.0, f64::max);
        for (c, s) in c.iter().zip(slacks).filter(|(_, s)| *s > 0.1 * deepest) {
            assert!(relative(-c, s) < 1e-2, "{c} for {s}");
        }
    }
}

/// The same for (39) with one point a facet, where Σ w_i η is what an integral is to be: forces λ_i
/// are balanced at L √(λ L A / (3 μ E₀ w_i)), A being the area that integrals are measured in.
#[test]
fn what_a_penalty_lets_through_is_foretold_by_its_limit() {
    for passes in [Passes::FirstIsSlave, Passes::SecondIsSlave] {
        let mut problem = problem_of(Hertz {
            passes,
            integration: Some(Integration::Gauss(1)),
            ..coarse_hertz()
        });
        let Scale {
            length,
            energy,
            area,
            ..
        } = problem.scale();
        let limit = from_rest(&mut problem, &mut Pointwise::default());
        let mu = 1e10;
        let slack = |l: f64, w: f64| length * (l * length * area / (3.0 * mu * energy * w)).sqrt();
        let rows = limit.lambda.iter().zip(limit.gaps.weights());
        let work: f64 = rows.map(|(&l, &w)| l * slack(l, w)).sum();
        let found = from_rest(&mut problem, &mut Penalty::with(Continuation::fixed(mu)));
        assert!(relative(limit.energy - found.energy, work) < 1e-3);
    }
}

#[test]
fn penalties_tend_to_their_pointwise_limit_at_order_one_half() {
    let mut problem = problem_of(coarse_hertz());
    assert_penalties_converge(&mut problem);
    let mut problem = small_beams(element::Order::Linear);
    assert_penalties_converge(&mut problem);
}

/// Through large strains as well, for rows that are the same: the fixed point on the projections of
/// points may end elsewhere from elsewhere.
#[test]
fn penalties_tend_to_their_pointwise_limit_through_large_strains() {
    let mut problem = disc_in_disc(16, Roles::default());
    let state = run(&mut problem, 5, 1e-6).run.state;
    let gaps = problem.rows(&state.u, Sampling::Points).expect("a state");
    let minimum = |method: &mut dyn Method| minimum(&problem, &gaps, method, &state.u);
    let limit = minimum(&mut InteriorPoint::default());
    let difference = |mu: f64| {
        let found = minimum(&mut Penalty::with(Continuation::fixed(mu)));
        (mu, relative(found.energy, limit.energy))
    };
    assert_order_one_half("energy", &MUS.map(difference));
}

/// One subproblem, from displacements `u`.
fn minimum<const D: usize>(
    problem: &Problem<D>,
    gaps: &LinearGaps,
    method: &mut dyn Method,
    u: &[f64],
) -> Minimum {
    let subproblem = Subproblem {
        energy: problem.energy(),
        bounds: problem.bounds(),
        gaps,
        scale: problem.scale(),
        change: 1.0,
        accuracy: 0.0,
        stop: &Stop::new(),
    };
    let start = State {
        u: u.to_vec(),
        ..State::default()
    };
    let minimum = method.minimize(&subproblem, &start).expect("solved");
    assert_eq!(minimum.solved, Solved::Optimal);
    minimum
}

/// Points over-constrain a mesh: gaps that are nowhere negative have no negative means, so that the
/// energy can only be larger. How much goes away with the mesh, whatever points and passes.
#[test]
fn the_pointwise_limit_tends_to_the_interior_point_as_meshes_are_refined() {
    let integrations = [
        Integration::Gauss(2),
        Integration::Gauss(4),
        Integration::Exact,
    ];
    for integration in integrations {
        for passes in ALL_PASSES {
            let excess = [3, 6, 12].map(|fineness| {
                let mut problem = problem_of(Hertz {
                    passes,
                    integration: Some(integration),
                    ..Hertz::new(Fineness::family(fineness), element::Order::Linear)
                });
                let nodes = from_rest(&mut problem, &mut InteriorPoint::default()).energy;
                let points = from_rest(&mut problem, &mut Pointwise::default()).energy;
                (points - nodes) / nodes.abs()
            });
            let [coarse, medium, fine] = excess;
            let falls = coarse > 1.6 * medium && medium > 1.6 * fine && fine > 0.0;
            assert!(falls, "{integration:?}, {passes:?}: {excess:?}");
        }
    }
}

/// With default settings nothing is deeper than `penetration` says, and the energy is off by no
/// more than contact forces do in work over that depth.
fn assert_within_documented_penetration<const D: usize>(
    problem: &Problem<D>,
    exact: f64,
    found: &Solution,
) {
    let allowed = Continuation::default().penetration * problem.scale().resolution;
    let mut c = vec![0.0; found.gaps.len()];
    found.gaps.value(&found.state.u, &mut c);
    let deepest = c.iter().fold(0.0, |depth: f64, c| depth.max(-c));
    assert!(deepest < 1.001 * allowed, "{deepest} of {allowed}");
    let work = allowed * found.lambda.iter().sum::<f64>();
    let less = exact - found.energy;
    assert!(less > 0.0 && less < 1.01 * work, "{less} of {work}");
}

#[test]
fn continuation_ends_within_the_documented_penetration() {
    let mut problem = problem_of(coarse_hertz());
    let exact = from_rest(&mut problem, &mut InteriorPoint::default()).energy;
    let found = from_rest(&mut problem, &mut PenalizedSlack::default());
    assert_within_documented_penetration(&problem, exact, &found);
    let exact = from_rest(&mut problem, &mut Pointwise::default()).energy;
    let found = from_rest(&mut problem, &mut Penalty::default());
    assert_within_documented_penetration(&problem, exact, &found);

    let mut problem = small_beams(element::Order::Quadratic);
    let exact = from_rest(&mut problem, &mut InteriorPoint::default()).energy;
    let found = from_rest(&mut problem, &mut PenalizedSlack::default());
    assert_within_documented_penetration(&problem, exact, &found);

    let mut problem = disc_in_disc(16, Roles::default());
    let history = run(&mut problem, 5, 1e-7);
    let exact = history.run.solution.expect("converged").energy;
    let history = run_with(&mut PenalizedSlack::default(), &mut problem, 5, 1e-7);
    let found = history.run.solution.expect("converged");
    assert_within_documented_penetration(&problem, exact, &found);
}

/// What every test of all methods runs.
fn all_methods() -> [(&'static str, Box<dyn Method>); 3] {
    [
        ("(7)", Box::new(InteriorPoint::default())),
        ("(37)", Box::new(PenalizedSlack::default())),
        ("(39)", Box::new(Penalty::default())),
    ]
}

/// The displacements of cylinder and block, one after the other.
fn cylinder_and_block(problem: &Problem<2>, u: &[f64], swapped: bool) -> Vec<f64> {
    let all = problem.displacements(u);
    let bodies = if swapped { [1, 0] } else { [0, 1] };
    let nodes = bodies.into_iter().flat_map(|body| problem.nodes(body));
    nodes.flat_map(|a| [all[a][0], all[a][1]]).collect()
}

#[test]
fn every_method_in_any_passes_whichever_body_comes_first() {
    for (name, mut method) in all_methods() {
        let mut energies = Vec::new();
        for passes in ALL_PASSES {
            let ends = [false, true].map(|swapped| {
                let mut problem = problem_of(Hertz {
                    passes,
                    swapped,
                    ..coarse_hertz()
                });
                let found = from_rest(&mut problem, method.as_mut());
                let u = cylinder_and_block(&problem, &found.state.u, swapped);
                (found.energy, u)
            });
            let [(e1, u1), (e2, u2)] = &ends;
            assert!(relative(*e1, *e2) < 1e-9, "{name} {passes:?}: {e1} {e2}");
            let apart = distance(u1, u2);
            assert!(apart < 1e-8, "{name} {passes:?}: {apart}");
            energies.push(*e1);
        }
        // the same contact within what the mesh makes of it
        assert!(relative(energies[1], energies[0]) < 5e-3, "{name}");
        assert!(relative(energies[2], energies[0]) < 5e-3, "{name}");
    }
}

#[test]
fn every_method_through_large_strains_in_any_passes_whichever_body_comes_first() {
    for (name, mut method) in all_methods() {
        for passes in ALL_PASSES {
            let ends = [false, true].map(|swapped| {
                let roles = Roles { swapped, passes };
                let mut problem = disc_in_disc(24, roles);
                let history = run_with(method.as_mut(), &mut problem, 10, 1e-7);
                let outcome = &history.run.ending;
                assert_eq!(*outcome, Ending::Complete, "{name} {passes:?}");
                let last = history.steps.last().expect("steps");
                (last.energy, last.reaction(roles.ring())[1])
            });
            let [(e1, r1), (e2, r2)] = ends;
            assert!(relative(e1, e2) < 1e-6, "{name} {passes:?}: {e1} {e2}");
            assert!(relative(r1, r2) < 1e-6, "{name} {passes:?}: {r1} {r2}");
        }
    }
}

#[test]
fn results_and_iterations_do_not_depend_on_units() {
    let methods: [&dyn Fn() -> Box<dyn Method>; 2] =
        [&|| Box::new(PenalizedSlack::default()), &|| {
            Box::new(Penalty::default())
        }];
    for method in methods {
        let run = |length, modulus| {
            let scene = disc_in_disc::in_units(length, modulus).expect("a scene");
            let mut problem = scene.problem().expect("valid scene");
            let history = run_with(method().as_mut(), &mut problem, 10, 1e-7);
            assert_eq!(history.run.ending, Ending::Complete);
            let attempts = history.steps.iter().map(|step| &step.attempt);
            let counts = attempts.map(|a| (a.iterations.len(), a.cost.inner_iterations));
            let energy = history.steps.last().expect("steps").energy;
            (energy / (modulus * length * length), counts.collect())
        };
        let (reference, iterations): (f64, Vec<_>) = run(1.0, 1.0);
        for (length, modulus) in UNITS {
            let (energy, same) = run(length, modulus);
            assert_eq!(iterations, same);
            assert!(relative(energy, reference) < 1e-8);
        }
    }
}

/// Two blocks of half a length each, `GAP` apart; a pressure moves the upper one, which nothing
/// holds but its symmetry, through the gap and presses both together.
fn blocks() -> Problem<2> {
    let block = |low: f64, columns: usize| {
        let (xs, ys) = (linspace(0.0, 1.0, columns), linspace(low, low + 0.5, 2));
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
        let mut body = Body::new(mesh, LinearElastic::new(YOUNG, 0.0).expect("law"));
        body.prescribe("left", [Some(0.0), None]).expect("symmetry");
        body
    };
    let (mut lower, mut upper) = (block(0.0, 4), block(0.5 + GAP, 5));
    lower
        .prescribe("bottom", [None, Some(0.0)])
        .expect("support");
    upper.traction("top", [0.0, -PRESSURE]).expect("load");
    let mut scene = pair((lower, "top"), (upper, "bottom")).expect("surfaces");
    scene.integration = Some(Integration::Exact);
    scene.problem().expect("valid scene")
}

const YOUNG: f64 = 210.0;
const PRESSURE: f64 = 10.0;
const GAP: f64 = 0.02;

#[test]
fn no_result_of_the_penalty_depends_on_its_move_limit() {
    let mut problem = blocks();
    let default = GAP.max(problem.scale().length);
    let limits = [None, Some(0.1), Some(1.0), Some(10.0), Some(1e-3)];
    let all = limits.map(|share| {
        let mut method = Penalty {
            move_limit: share.map(|share| share * default),
            ..Penalty::default()
        };
        let found = from_rest(&mut problem, &mut method);
        // the top goes down by the gap and what both blocks are shortened by
        let u = problem.displacements(&found.state.u);
        let top = problem.nodes(1).map(|a| u[a][1]).fold(0.0, f64::min);
        let allowed = method.penalization.continuation.penetration * problem.scale().resolution;
        let exact = -GAP - PRESSURE / YOUNG;
        let left = exact - top;
        assert!(left.abs() < 1.001 * allowed, "{share:?}: {top} for {exact}");
        found.state.u
    });
    for other in &all[1..] {
        let apart = distance(other, &all[0]);
        assert!(apart < 1e-9, "{apart}");
    }
}

/// Newton's method with the curvature of η halves what is wrong with a slack in each iteration: 37
/// of them in each of these solves but for the secants that foretell its force.
#[test]
fn warm_solves_at_a_large_penalty_take_few_iterations() {
    let mut problem = disc_in_disc(16, Roles::default());
    let history = run(&mut problem, 5, 1e-6);
    let mut method = PenalizedSlack::with(Continuation::fixed(1e12));
    let found = solved(&mut problem, &mut method, history.run.state.u);
    let iterations: Vec<usize> = found
        .history
        .iter()
        .map(|i| i.cost.inner_iterations)
        .collect();
    assert!(iterations.iter().all(|&n| n <= 20), "{iterations:?}");
}

/// Bodies that touch to begin with have no gap that tells how far they will move.
#[test]
fn the_move_limit_does_not_hold_up_bodies_that_touch() {
    let mut problem = small_beams(element::Order::Linear);
    let found = from_rest(&mut problem, &mut Penalty::with(Continuation::fixed(1e4)));
    let cost = found.history[0].cost;
    assert!(cost.solves <= 5, "{} solves", cost.solves);
}

/// A setting that would silently be another one is refused by its name.
#[test]
fn settings_are_checked() {
    let interior_point = |tolerance, complementarity| InteriorPoint {
        tolerance,
        complementarity,
        ..InteriorPoint::default()
    };
    let mut slack = PenalizedSlack::default();
    slack.penalization.tolerance = f64::NAN;
    let penalty = Penalty {
        move_limit: Some(1e-9),
        ..Penalty::default()
    };
    let refused: [(Box<dyn Method>, &str); 5] = [
        (Box::new(interior_point(f64::NAN, 1e-8)), "tolerance"),
        (Box::new(interior_point(1e-12, 0.0)), "complementarity"),
        (
            Box::new(interior_point(1e-12, f64::INFINITY)),
            "complementarity",
        ),
        (Box::new(slack), "tolerance"),
        (Box::new(penalty), "move_limit"),
    ];
    for (method, name) in refused {
        let run = Simulation::solved_by(Retry::with(method), 1).run(&mut blocks());
        let error = run.expect_err("refused").to_string();
        assert!(error.contains(name), "{error}");
    }
}

/// A method that went up to a large μ and is then told a smaller one solves with that.
#[test]
fn a_method_that_is_used_again_takes_the_mu_it_is_told() {
    let mut problem = blocks();
    let mut method = PenalizedSlack::with(Continuation::fixed(1e12));
    let stiff = from_rest(&mut problem, &mut method);
    let weak = Continuation::fixed(1e4);
    let expected = from_rest(&mut problem, &mut PenalizedSlack::with(weak));
    method.penalization.continuation = weak;
    let again = FixedPoint::with(method).solve_from(&problem, stiff.state.clone());
    let again = again.expect("no misuse").energy;
    assert!(relative(again, expected.energy) < 1e-9);
    assert!(relative(again, stiff.energy) > 1e-6);
}
