//! What scenes cost beside what they need: factorisations and searches are counted, and results compared with those of the
//! cheapest ways to them.

use contact_core::{Equilibrium, LoadStepped};
use contact_fem::model::Problem;
use contact_fem::simulation::{DefaultSolver, History};
use contact_fem::{LeftOut, Simulation};
use ipopt_contact_scenes::needs::floor::{self, Floor};
use ipopt_contact_scenes::needs::kept::{self, Keep};
use ipopt_contact_scenes::needs::{Build, Case, Way, all, blocks_alone};

use crate::common::relative;

const COARSE: usize = 5;

fn case(name: &str) -> Case {
    let found = all(COARSE).into_iter().find(|case| case.name == name);
    found.expect("a case")
}

/// A run of a case, and its floor at full load.
struct Compared<const D: usize> {
    problem: Problem<D>,
    history: History<D>,
    floor: Option<Floor>,
}

fn compared<const D: usize>(case: &Case, scene: contact_fem::Scene<D>) -> Compared<D> {
    let mut problem = scene.problem().expect("a problem");
    let mut simulation = Simulation::with_increments(case.increments);
    let history = simulation.run(&mut problem).expect("no misuse");
    assert!(
        history.is_complete(),
        "{}: {}",
        case.name,
        history.run.ending
    );
    let floor = match case.way {
        Way::Linear => Some(floor::linear(&mut problem, case.increments)),
        Way::Newton => Some(floor::newton(&mut problem, case.increments)),
        Way::Pair => None,
    };
    let floor = floor.map(|floor| floor.unwrap_or_else(|why| panic!("{}: {why}", case.name)));
    Compared {
        problem,
        history,
        floor,
    }
}

fn agrees<const D: usize>(case: &Case, scene: contact_fem::Scene<D>) {
    let Compared {
        problem,
        history,
        floor,
    } = compared(case, scene);
    let Some(floor) = floor else { return };
    let last = history.last().expect("a step");
    let apart = (last.energy - floor.energy).abs();
    // bodies that do not touch store nothing, up to round-off of their motion
    let bound = 1e-9 * floor.energy.abs().max(1e-6 * problem.scale().energy);
    assert!(
        apart <= bound,
        "{}: {apart:e} in energy, bound {bound:e}",
        case.name
    );
    let forces = problem.contact_forces(&floor.gaps, &floor.lambda);
    let reactions = problem.reactions(&floor.u, &forces);
    // supports of one body may cancel
    let of_problem = problem.scale().energy / problem.scale().length;
    let reaction = reactions.iter().map(|r| r.norm());
    let size = reaction.fold(of_problem, f64::max);
    for (a, b) in last.reactions.iter().zip(&reactions) {
        let apart = (a - b).norm() / size;
        assert!(apart < 1e-7, "{}: {apart:e} in reactions", case.name);
    }
}

#[test]
fn results_are_those_of_the_floors() {
    for case in all(COARSE) {
        match &case.scene {
            Build::Plane(scene) => agrees(&case, scene().expect("a scene")),
            Build::Space(scene) => agrees(&case, scene().expect("a scene")),
        }
    }
}

fn is_that_of_the_whole<const D: usize>(
    case: &Case,
    scene: &dyn Fn() -> Result<contact_fem::Scene<D>, contact_fem::Error>,
) {
    let run = compared(case, scene().expect("a scene"));
    let mut whole = scene().expect("a scene");
    Keep::ALL.prepare(&mut whole);
    let mut whole = whole.problem().expect("a problem");
    let history = Keep::ALL.simulation(case.increments).run(&mut whole);
    let history = history.expect("no misuse");
    let name = case.name;
    assert!(history.is_complete(), "{name}: {}", history.run.ending);
    assert_eq!(LeftOut::new(&whole, &history).factorizations, 0, "{name}");
    assert_eq!(whole.unsearched_passes(), 0, "{name}");
    let steps = [&run.history, &history].map(|history| history.last().expect("a step"));
    let (energy, reactions) = kept::apart(&run.problem, steps);
    assert!(energy <= 1e-9, "{name}: {energy:e} in energy");
    assert!(reactions < 1e-7, "{name}: {reactions:e} in reactions");
}

/// Runs that keep all passes, groups, starts and factorisations have the same results.
#[test]
fn nothing_is_lost_by_leaving_out() {
    for case in all(COARSE) {
        match &case.scene {
            Build::Plane(scene) => is_that_of_the_whole(&case, scene),
            Build::Space(scene) => is_that_of_the_whole(&case, scene),
        }
    }
}

/// Factorisations and condensed problems of a run.
fn counts(name: &str) -> (usize, usize) {
    fn of<const D: usize>(case: &Case, scene: contact_fem::Scene<D>) -> (usize, usize) {
        let run = compared(case, scene);
        let cost = run.history.run.cost();
        (cost.factorizations, cost.solves)
    }
    let case = case(name);
    match &case.scene {
        Build::Plane(scene) => of(&case, scene().expect("a scene")),
        Build::Space(scene) => of(&case, scene().expect("a scene")),
    }
}

#[test]
fn linear_bodies_are_factored_once() {
    for name in ["1a", "1b", "1p", "3a", "3d", "8a"] {
        assert_eq!(counts(name), (1, 0), "{name}");
    }
    for name in ["5", "5a", "7", "8b", "9ll", "10", "30b"] {
        let (factorizations, solves) = counts(name);
        assert_eq!(factorizations, 1, "{name}");
        assert!(solves > 0, "{name}");
    }
}

/// What is at equilibrium stays there: without a factorisation by the solver that found it, with one by a new solver.
#[test]
fn solved_problems_are_solved_again() {
    for (name, by_new) in [("1a", 1), ("9ll", 1), ("2a", 1), ("3m", 1)] {
        let case = case(name);
        let Build::Plane(scene) = &case.scene else {
            unreachable!()
        };
        let mut problem = scene().expect("a scene").problem().expect("a problem");
        let mut simulation = Simulation::with_increments(1);
        let history = simulation.run(&mut problem).expect("no misuse");
        let state = &history.run.state;
        for (by, solver, most) in [
            ("the same", &mut simulation.solver, 0),
            ("a new one", &mut DefaultSolver::default(), by_new),
        ] {
            let again = solver.solve_from(&problem, state.clone());
            let again = again.expect("no misuse");
            let cost = again.cost();
            assert!(
                cost.factorizations <= most,
                "{name} by {by}: {} factorisations",
                cost.factorizations
            );
            let energy = history.last().expect("a step").energy;
            assert!(relative(again.energy, energy) < 1e-12, "{name} by {by}");
        }
    }
}

/// The trees are built once, and penetrations are looked for once at each state that is accepted.
#[test]
fn states_are_searched_once() {
    let case = case("8b");
    let Build::Plane(scene) = &case.scene else {
        unreachable!()
    };
    let mut problem = scene().expect("a scene").problem().expect("a problem");
    let before = problem.penetrations_searched();
    let history = Simulation::with_increments(10).run(&mut problem);
    assert!(history.expect("no misuse").is_complete());
    assert_eq!(problem.searches_built(), 1);
    assert_eq!(problem.penetrations_searched() - before, 10);
}

/// Energies of linear bodies follow the load without another assembly.
#[test]
fn loads_scale() {
    let case = case("1p");
    let Build::Space(scene) = &case.scene else {
        unreachable!()
    };
    let mut problem = scene().expect("a scene").problem().expect("a problem");
    let floor = floor::linear(&mut problem, 1).expect("a floor");
    problem.set_load(0.5).expect("load");
    let half: Vec<f64> = floor.u.iter().map(|u| 0.5 * u).collect();
    let energy = contact_core::ContactProblem::energy(&problem).value(&half);
    assert!(relative(energy, 0.25 * floor.energy) < 1e-12);
}

/// What was left out is counted: passes between bodies that stay apart, and factors that later load steps took over.
#[test]
fn savings_are_counted() {
    let left_out = |name: &str| {
        let case = case(name);
        let Build::Plane(scene) = &case.scene else {
            unreachable!()
        };
        let run = compared(&case, scene().expect("a scene"));
        (
            run.problem.passes().len(),
            LeftOut::new(&run.problem, &run.history),
        )
    };
    let (passes, left) = left_out("10b");
    // three sides of each body meet those of all others; only those of the first two are near
    assert_eq!(passes, 2 * 9 * 45);
    assert!((passes - 18..passes).contains(&left.passes), "{left:?}");
    assert_eq!(left.factorizations, 0);
    let (_, left) = left_out("8a");
    assert_eq!((left.passes, left.factorizations), (0, 99));
}

/// Ten bodies of which two touch: factors have as many entries as the two take together, and each of the others by itself,
/// and so do energy and reactions.
#[test]
fn groups_are_solved_by_themselves() {
    let run = |scene: contact_fem::Scene<2>| {
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(1).run(&mut problem);
        let history = history.expect("no misuse");
        assert!(history.is_complete(), "{}", history.run.ending);
        let entries = history.run.cost().factor_entries;
        let last = history.last().expect("a step").clone();
        assert!(
            last.certificate.holds(&Default::default()),
            "{}",
            last.certificate
        );
        (entries, last)
    };
    let blocks = |blocks| run(blocks_alone(blocks, COARSE).expect("a scene"));
    let (entries, all) = blocks(0..10);
    let groups = std::iter::once(0..2).chain((2..10).map(|k| k..k + 1));
    let groups: Vec<_> = groups.map(blocks).collect();
    assert_eq!(entries, groups.iter().map(|group| group.0).sum::<u64>());
    let energy: f64 = groups.iter().map(|group| group.1.energy).sum();
    assert!(relative(all.energy, energy) < 1e-9);
    let alone = groups.iter().flat_map(|group| &group.1.reactions);
    for (a, b) in all.reactions.iter().zip(alone) {
        assert!((a - b).norm() < 1e-7 * b.norm(), "{a} {b}");
    }
    assert!(all.contact_force(0usize)[0] < -1.0);
}
