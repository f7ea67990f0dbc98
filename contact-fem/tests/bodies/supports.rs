//! Supports that hold in some phases alone.

use std::ops::ControlFlow;

use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::{Geometry, Problem};
use contact_fem::simulation::{History, StepRecord};
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, Motion, NeoHookean, Obstacle, Phase, Scene, Simulation,
};

type Declare<'a> = &'a dyn Fn(&mut Body<2>) -> Result<(), Error>;
type Point = contact_fem::tensor::Vector<2>;

const E: f64 = 100.0;

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2], small: bool) -> Body<2> {
    let [xs, ys] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
    let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
    match small {
        true => Body::new(mesh, LinearElastic::new(E, 0.3).expect("a law")),
        false => Body::new(mesh, NeoHookean::new(E, 0.3).expect("a law")),
    }
}

/// A bar of 4 by 1 that is held at its left end.
fn bar(small: bool) -> Body<2> {
    let mut bar = block([0.0; 2], [4.0, 1.0], [8, 2], small);
    bar.prescribe("left", [Some(0.0); 2]).expect("held");
    bar
}

fn alone(body: Body<2>) -> Problem<2> {
    let mut scene = Scene::new();
    scene.add("bar", body);
    scene.problem().expect("a problem")
}

fn run(problem: &mut Problem<2>, phases: &[(f64, usize)]) -> History<2> {
    let named = |&(until, increments): &(f64, usize)| {
        Phase::new(format!("until {until}"), until, increments)
    };
    let mut simulation = Simulation::in_phases(phases.iter().map(named));
    let history = simulation.run(problem).expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("a step");
    assert!(certificate.holds(&Limits::default()), "{certificate}");
    history
}

fn largest(u: &[Point]) -> f64 {
    u.iter().map(|u| u.norm()).fold(0.0, f64::max)
}

fn reaction(record: &StepRecord<2>, boundary: &str) -> Point {
    let mut own = record.support_reactions.iter();
    own.find(|(side, _)| side.boundary == boundary)
        .expect("known")
        .1
}

/// The reactions (UF) of all dofs of the only body.
fn nodal_reactions(problem: &Problem<2>, u: &[f64]) -> Vec<f64> {
    let mut forces = problem.residual(0, u);
    let free = problem.scene().bodies()[0].prescribed().iter();
    let free = forces
        .iter_mut()
        .zip(free)
        .filter(|(_, held)| held.is_none());
    free.for_each(|(force, _)| *force = 0.0);
    forces
}

/// A block in rollers is squeezed by a fifth of its height between plates that it sticks to, and let go. Forces at the corners of
/// the plate are of either sign; as dead forces they turned blocks of quadratic cells over.
#[test]
fn a_squeezed_block_comes_back() {
    for (is_quadratic, increments) in [(false, 4), (true, 1), (true, 4), (true, 16), (true, 64)] {
        let grid = linspace(0.0, 1.0, 4);
        let mesh = rectangle(&grid, &grid, Diagonals::Rising).expect("a mesh");
        let mesh = if is_quadratic { mesh.quadratic() } else { mesh };
        let mut body = Body::new(mesh, NeoHookean::new(E, 0.3).expect("a law"));
        let rollers = body.symmetry("left").and_then(|b| b.symmetry("bottom"));
        rollers
            .expect("sides")
            .during(&[[0.0, 1.0]], |body| {
                body.prescribe("top", [Some(0.0), Some(-0.2)])
            })
            .expect("switched");
        let mut problem = alone(body);
        let history = run(&mut problem, &[(1.0, 4), (2.0, increments)]);
        let [pressed, free] = [&history.steps[3], history.last().expect("a step")];
        assert!(pressed.stored_energy > 1.0);
        let moved = largest(&problem.displacements(&history.run.state.u));
        assert!(moved < 1e-9, "{is_quadratic} {increments}: {moved}");
        assert!(free.stored_energy < 1e-9 * pressed.stored_energy);
        // its support took back what it gave, up to the trapezoidal rule's error
        let unstored = free.work().abs() / pressed.stored_energy;
        println!("{is_quadratic} {increments}: {unstored:.3}");
        if increments == 64 {
            assert!(unstored < 0.02, "{unstored}");
        }
    }
}

/// Supports that share a corner agree at all times of a run, or from when the later one begins.
#[test]
fn supports_agree_at_all_times() {
    let later = || Amplitude::table(&[(1.0, 0.0), (2.0, 1.0)]).expect("a table");
    let told = |declare: &dyn Fn(&mut Body<2>) -> Result<(), Error>| -> Option<String> {
        let mut body = block([0.0; 2], [1.0, 1.0], [3, 3], false);
        body.symmetry("left").expect("a side");
        if let Err(why) = declare(&mut body) {
            return Some(why.to_string());
        }
        let mut problem = alone(body);
        let phases = [Phase::new("wait", 1.0, 1), Phase::new("move", 2.0, 2)];
        let run = Simulation::in_phases(phases).run(&mut problem);
        run.err().map(|why| why.to_string())
    };
    let top = [Some(0.2), Some(0.0)];
    let refused = told(&|body| body.prescribe_in_time("top", top, later()).map(|_| ()));
    let why = refused.expect("the corner is held, and moves");
    assert!(
        why.contains("`left` and on `top`: 0 and 0.2 at load factor 2"),
        "{why}"
    );
    let along = Motion::<2>::translation([0.2, 0.0])
        .expect("a motion")
        .driven_by(later());
    let refused = told(&|body| {
        let motion = along.clone();
        body.prescribe("bottom", [None, Some(0.0)])?;
        body.during(&[[1.0, 2.0]], |body| body.prescribe_motion("top", motion))
            .map(|_| ())
    });
    assert!(refused.is_some_and(|why| why.contains("0 and 0.2 at load factor 2")));
    // the corner moves along what holds it
    let down = Motion::<2>::translation([0.0, -0.2]).expect("a motion");
    let down = down.driven_by(later());

    let accepted = told(&|body| {
        let motion = down.clone();
        body.prescribe("bottom", [None, Some(0.0)])?;
        body.during(&[[1.0, 2.0]], |body| body.prescribe_motion("top", motion))
            .map(|_| ())
    });
    assert_eq!(accepted, None);
}

/// What lets go of a body at large strains are springs: |r| k (1 − s)/s in the share s of the phase, and k = Σ |r|/2W.
#[test]
fn springs_that_soften() {
    let mut body = bar(false);
    body.during(&[[0.0, 1.0]], |bar| {
        bar.prescribe("right", [Some(0.6), Some(0.2)])
    })
    .expect("switched");
    let mut problem = alone(body);
    let phases = [(1.0, 2), (3.0, 8)];
    let phases = phases.map(|(until, increments)| Phase::new(until.to_string(), until, increments));
    let mut simulation = Simulation::in_phases(phases);
    let end = problem.scene().bodies()[0].mesh().boundary_nodes("right");
    let end = end.expect("a side");
    let (mut springs, mut held) = (Vec::new(), Vec::new());
    let mut off = Vec::new();
    let history = simulation.run_observed(&mut problem, |step| {
        let (problem, u) = (step.problem, &step.solution.state.u);
        let moved = problem.displacements(u);
        let (t, record) = (step.record.factor, &step.record);
        if t == 1.0 {
            let reactions = nodal_reactions(problem, u);
            let sizes = end
                .iter()
                .map(|&a| reactions[2 * a].hypot(reactions[2 * a + 1]));
            let sizes: Vec<f64> = sizes.collect();
            let k = 0.5 * sizes.iter().sum::<f64>() / record.stored_energy;
            springs = sizes.iter().map(|size| k * size).collect();
            held = moved;
        } else if t > 1.0 && t < 3.0 {
            let s = 0.5 * (t - 1.0);
            let forces = end.iter().zip(&springs);
            let forces = forces.map(|(&a, k)| (held[a] - moved[a]) * (k * (1.0 - s) / s));
            let force: Point = forces.sum();
            off.push((reaction(record, "right") - force).norm() / force.norm());
        }
        ControlFlow::Continue(())
    });
    assert!(history.expect("a run").is_complete());
    assert_eq!(off.len(), 7);
    assert!(off.iter().all(|off| *off < 1e-6), "{off:?}");
}

/// A block that is strained evenly comes back evenly, with quadratic cells in the plane and around an axis.
#[test]
fn even_strains_fade_evenly() {
    for is_revolved in [false, true] {
        let grid = linspace(0.0, 1.0, 6);
        let mesh = rectangle(&grid, &grid, Diagonals::Rising).expect("a mesh");
        let law = NeoHookean::new(E, 0.3).expect("a law");
        let mut body = match is_revolved {
            true => Body::of_revolution(mesh.quadratic(), law).expect("a body"),
            false => Body::new(mesh.quadratic(), law),
        };
        if !is_revolved {
            body.symmetry("left").expect("a side");
        }
        body.symmetry("bottom").expect("a side");
        body.during(&[[0.0, 1.0]], |body| {
            body.prescribe("top", [None, Some(-0.3)])
        })
        .expect("switched");
        let mut problem = alone(body);
        let top = problem.scene().bodies()[0].mesh().boundary_nodes("top");
        let top = top.expect("a side");
        let phases = [Phase::new("squeeze", 1.0, 3), Phase::new("let go", 2.0, 4)];
        let mut heights = Vec::new();
        let history = Simulation::in_phases(phases).run_observed(&mut problem, |step| {
            let moved = step.problem.displacements(&step.solution.state.u);
            let range = top
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &a| {
                    [low.min(moved[a][1]), high.max(moved[a][1])]
                });
            heights.push(range);
            ControlFlow::Continue(())
        });
        assert!(history.expect("a run").is_complete());
        for [low, high] in &heights[3..] {
            assert!(high - low < 1e-8, "{is_revolved}: {heights:?}");
        }
        let means: Vec<f64> = heights[2..].iter().map(|[low, _]| *low).collect();
        assert!(means.is_sorted(), "{means:?}");
        assert!(-0.25 < means[2] && means[2] < -0.05, "{means:?}");
    }
}

/// A boundary that was bent is turned by half a turn, as it is: all distances between its nodes stay.
#[test]
fn a_motion_that_begins_later() {
    let mut body = bar(false);
    body.traction_in_time(
        "top",
        [0.0, -0.3],
        Amplitude::table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]).expect("a table"),
    )
    .expect("loaded");
    let half = Motion::<2>::rotation([4.0, 0.5], 0.5).expect("a motion");
    let later = Amplitude::table(&[(1.0, 0.4), (2.0, 1.4)]).expect("a table");
    let half = half.driven_by(later);
    body.during(&[[1.0, 2.0]], |bar| bar.prescribe_motion("right", half))
        .expect("switched");
    let mut problem = alone(body);
    let end = problem.scene().bodies()[0]
        .mesh()
        .boundary_nodes("right")
        .expect("a side");
    let mut places = Vec::new();
    let mut simulation =
        Simulation::in_phases([Phase::new("load", 1.0, 2), Phase::new("turn", 2.0, 4)]);
    let history = simulation.run_observed(&mut problem, |step| {
        let x = step.problem.positions(&step.solution.state.u);
        places.push(end.iter().map(|&a| x[a]).collect::<Vec<_>>());
        ControlFlow::Continue(())
    });
    assert!(history.expect("a run").is_complete());
    let [before, after] = [1, 5].map(|step| &places[step]);
    let start = &problem.reference()[end[0]];
    assert!(
        (before[0] - start).norm() > 0.05,
        "it was moved before: {}",
        before[0]
    );
    let (sin, cos) = 0.5_f64.sin_cos();
    for (x, now) in before.iter().zip(after) {
        let arm = x - Point::new(4.0, 0.5);
        let turned = Point::new(
            4.0 + cos * arm[0] - sin * arm[1],
            0.5 + sin * arm[0] + cos * arm[1],
        );
        assert!((now - turned).norm() < 1e-12, "{now} {turned}");
    }
}

/// A bar is clamped at both ends, drawn and bent, and its right end is let go: it is what it was. On the way its reaction falls,
/// and what has been done to the bar is what it stores.
fn let_go(small: bool, by: f64) {
    let mut body = bar(small);
    let ends = [Some(by), Some(0.5 * by)];
    body.during(&[[0.0, 1.0]], |bar| bar.prescribe("right", ends))
        .expect("switched");
    let mut problem = alone(body);
    let phases = [(1.0, 4), (2.0, 8)];
    let history = run(&mut problem, &phases);
    let [drawn, half, free] = [3, 7, 11].map(|step| &history.steps[step]);
    let full = reaction(drawn, "right");
    assert!(full[0] > 0.5 * E * by / 4.0, "{full}");
    let share = reaction(half, "right").norm() / full.norm();
    match small {
        true => assert!((reaction(half, "right") - 0.5 * full).norm() < 1e-12 * full.norm()),
        false => assert!(0.2 < share && share < 0.8, "{share}"),
    }
    for end in ["left", "right"] {
        assert!(reaction(free, end).norm() < 1e-9 * full.norm(), "{end}");
    }
    for record in &history.steps {
        let sum = reaction(record, "left") + reaction(record, "right");
        assert!(sum.norm() < 1e-8 * full.norm(), "{}: {sum}", record.factor);
        assert!((record.reaction(0) - sum).norm() < 1e-12 * full.norm());
        let left = (record.work() - record.stored_energy).abs();
        let rule = if small { 1e-11 } else { 0.02 };
        assert!(
            left < rule * drawn.stored_energy,
            "{}: {left}",
            record.factor
        );
    }
    let moved = problem.displacements(&history.run.state.u);
    assert!(largest(&moved) < 1e-9, "{}", largest(&moved));
    assert!(free.stored_energy < 1e-9 * drawn.stored_energy);
    // at once, too
    let abrupt = run(&mut problem, &[(1.0, 4), (2.0, 1)]);
    let moved = problem.displacements(&abrupt.run.state.u);
    assert!(largest(&moved) < 1e-9, "{}", largest(&moved));
    // the problem begins anew in each run
    let again = run(&mut problem, &phases);
    assert_eq!(again.run.state.u, history.run.state.u);
    assert_eq!(again.steps[5].energy, history.steps[5].energy);
}

#[test]
fn a_linear_bar_that_is_let_go() {
    let_go(true, 0.01);
}

#[test]
fn a_rubber_bar_that_is_let_go() {
    let_go(false, 1.0);
}

/// Held in place while it is loaded, and let go, a beam above a floor ends as one that was never held.
#[test]
fn held_while_it_is_loaded() {
    for (small, load, limit) in [(true, 0.02, 1e-10), (false, 0.4, 1e-8)] {
        let end = |holds: bool| {
            let mut beam = bar(small);
            beam.traction_in_time(
                "top",
                [0.0, -load],
                Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)]).expect("a table"),
            )
            .expect("loaded");
            if holds {
                beam.during(&[[0.0, 1.0]], |beam| {
                    beam.prescribe("right", [Some(0.0); 2])?
                        .prescribe("bottom", [None, Some(0.0)])
                })
                .expect("switched");
            }
            let mut scene = Scene::new();
            let beam = scene.add("beam", beam);
            let gap = if small { 0.002 } else { 0.1 };
            let floor = Obstacle::half_space([0.0, -gap], [0.0, 1.0]).expect("a floor");
            let side = beam.on("bottom");
            let floor = scene.obstacle("floor", side, floor).expect("a side");
            let mut problem = scene.problem().expect("a problem");
            let history = run(&mut problem, &[(1.0, 2), (2.0, 6)]);
            let last = history.last().expect("a step");
            let first = &history.steps[1];
            assert_eq!(first.obstacle_force(floor)[1] == 0.0, holds, "{holds}");
            let pushed = last.obstacle_force(floor)[1];
            assert!(pushed < -load, "{pushed}");
            if holds {
                assert_eq!(reaction(last, "right").norm(), 0.0);
            }
            (
                problem.displacements(&history.run.state.u),
                reaction(last, "left"),
            )
        };
        let [(held, by), (never, expected)] = [true, false].map(end);
        let differences: Vec<_> = held.iter().zip(&never).map(|(a, b)| a - b).collect();
        let off = largest(&differences) / largest(&never);
        println!("small {small}: {off:.1e}");
        assert!(off < limit, "{off}");
        assert!((by - expected).norm() < limit * expected.norm());
    }
}

/// A bar without lateral strain is drawn by σ = 2, held where it is while σ goes, moved on, and let go.
#[test]
fn a_support_takes_over_where_nodes_are() {
    let mesh =
        rectangle(&linspace(0.0, 4.0, 5), &[0.0, 0.5, 1.0], Diagonals::Rising).expect("a mesh");
    let mut bar = Body::new(mesh, LinearElastic::new(E, 0.0).expect("a law"));
    bar.symmetry("left")
        .expect("a side")
        .symmetry("bottom")
        .expect("a side");
    let there_and_back = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]).expect("a table");
    bar.traction_in_time("right", [2.0, 0.0], there_and_back)
        .expect("loaded");
    // at rest from 1 to 2, and by 0.05 a unit of time from 2 to 3
    bar.during(&[[1.0, 2.0]], |bar| {
        bar.prescribe("right", [Some(0.0), None])
    })
    .expect("switched");
    bar.during(&[[2.0, 3.0]], |bar| {
        bar.prescribe("right", [Some(0.05), None])
    })
    .expect("switched");
    let mut problem = alone(bar);
    let mut places = Vec::new();
    let mut simulation = Simulation::in_phases((1..=4).map(|k| Phase::new("", f64::from(k), 2)));
    let history = simulation.run_observed(&mut problem, |step| {
        let moved = step.problem.displacements(&step.solution.state.u);
        places.push(largest(&moved));
        ControlFlow::Continue(())
    });
    let history = history.expect("a run");
    assert!(history.is_complete());
    assert!(
        history
            .certificate()
            .expect("steps")
            .holds(&Limits::default())
    );
    let drawn = 2.0 * 4.0 / E;
    let expected = [
        0.5 * drawn,
        drawn,
        drawn,
        drawn,
        drawn + 0.025,
        drawn + 0.05,
        0.5 * (drawn + 0.05),
        0.0,
    ];
    for ((place, expected), record) in places.iter().zip(expected).zip(&history.steps) {
        assert!(
            (place - expected).abs() < 1e-12,
            "{}: {place} {expected}",
            record.factor
        );
    }
    let by_support = [
        0.0,
        0.0,
        1.0,
        2.0,
        2.0 + 0.025 * E / 4.0,
        2.0 + 0.05 * E / 4.0,
        0.5 * (2.0 + 0.05 * E / 4.0),
        0.0,
    ];
    for (record, expected) in history.steps.iter().zip(by_support) {
        let force = reaction(record, "right");
        assert!(
            (force[0] - expected).abs() < 1e-10,
            "{}: {force}",
            record.factor
        );
        assert!(
            (record.work() - record.stored_energy).abs() < 1e-12,
            "{}",
            record.factor
        );
    }
}

/// A component that another support holds stays held, and corners of both are counted once.
#[test]
fn what_other_supports_hold_stays() {
    let mut body = bar(true);
    body.during(&[[0.0, 1.0]], |bar| {
        bar.prescribe("bottom", [Some(0.0), Some(0.0)])
    })
    .expect("switched");
    let mut problem = alone(body);
    let free = problem.dofs().free();
    let history = run(&mut problem, &[(1.0, 1), (2.0, 1)]);
    // 9 nodes of the bottom, one of them at the left
    assert_eq!(problem.dofs().free(), free + 16);
    assert_eq!(history.run.state.u.len(), free + 16);
    let moved = problem.displacements(&history.run.state.u);
    assert_eq!(largest(&moved), 0.0);
}

/// A run that is stopped where a phase begins ends with the state and the unknowns of the phase before.
#[test]
fn stopped_where_supports_let_go() {
    let mut body = bar(false);
    body.during(&[[0.0, 1.0]], |bar| {
        bar.prescribe("right", [Some(0.4), None])
    })
    .expect("switched");
    let mut problem = alone(body);
    let free = problem.dofs().free();
    let phases = [Phase::new("draw", 1.0, 2), Phase::new("let go", 2.0, 2)];
    let mut simulation = Simulation::in_phases(phases);
    let stop = simulation.load_steps.stop.clone();
    let mut drawn = Vec::new();
    let history = simulation.run_observed(&mut problem, |step| {
        if step.record.factor == 1.0 {
            stop.request();
            drawn = step.problem.displacements(&step.solution.state.u);
        }
        ControlFlow::Continue(())
    });
    let history = history.expect("a run");
    assert!(!history.is_complete());
    assert_eq!((history.run.factor, problem.load()), (1.0, 1.0));
    assert_eq!(
        (problem.dofs().free(), history.run.state.u.len()),
        (free, free)
    );
    assert_eq!(problem.displacements(&history.run.state.u), drawn);
    let solution = history.run.solution.as_ref().expect("a solution");
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let reactions = problem.reactions(&solution.state.u, &forces);
    assert_eq!(reactions, history.steps[1].reactions);
}

/// What cannot be is refused before anything is solved, by a name.
#[test]
fn wrong_switches() {
    let refused = |declare: Declare<'_>| {
        let mut body = bar(true);
        body.during(&[[0.0, 1.0]], |body| declare(body).map(|()| body))
            .err()
            .expect("refused")
    };
    let loads: [Declare<'_>; 5] = [
        &|body| body.traction("top", [0.0, 1.0]).map(|_| ()),
        &|body| body.body_force_path(|_, _| Point::zeros()).map(|_| ()),
        &|body| body.pressure("top", 1.0).map(|_| ()),
        &|body| body.foundation("right", 1.0).map(|_| ()),
        &|body| body.during(&[[0.0, 1.0]], |body| Ok(body)).map(|_| ()),
    ];
    for declare in loads {
        let error = refused(declare);
        assert!(matches!(error, Error::NotSwitched { .. }), "{error}");
    }
    for wrong in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::NAN]] {
        let told = bar(true)
            .during(&[wrong], |body| Ok(body))
            .err()
            .expect("no interval");
        assert!(told.to_string().contains("end of the interval"), "{told}");
    }
    // two values are a conflict where both may hold
    let twice = |second: [f64; 2]| {
        let mut body = bar(true);
        body.during(&[[0.0, 2.0]], |bar| {
            bar.prescribe("right", [Some(0.1), None])
        })
        .expect("switched");
        body.during(&[second], |bar| bar.prescribe("right", [Some(0.2), None]))
            .map(|_| ())
    };
    assert!(matches!(twice([1.0, 3.0]), Err(Error::Conflict { .. })));
    twice([2.0, 3.0]).expect("one after the other");
    // one that begins later holds nodes where the other one has brought them to
    let to_rest = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)]).expect("a table");
    let mut body = bar(true);
    body.prescribe_in_time("right", [Some(0.1), None], to_rest)
        .expect("held");
    let still = [Some(0.0), None];
    body.during(&[[1.0, 2.0]], |bar| bar.prescribe("right", still))
        .expect("at rest");
    let early = body.during(&[[0.5, 2.0]], |bar| bar.prescribe("right", still));
    assert!(matches!(early, Err(Error::Conflict { .. })));

    let phases = |ends: &[f64]| {
        let named = |&until: &f64| Phase::new("", until, 1);
        Simulation::in_phases(ends.iter().map(named).collect::<Vec<_>>())
    };
    let mut body = bar(true);
    body.during(&[[0.0, 1.0]], |bar| {
        bar.prescribe("right", [Some(0.1), None])
    })
    .expect("switched");
    let mut problem = alone(body);
    let error = phases(&[0.5, 2.0])
        .run(&mut problem)
        .expect_err("no phase ends at 1");
    assert!(
        matches!(error, Error::SwitchWithinPhase { at: 1.0, .. }),
        "{error}"
    );
    assert!(
        error.to_string().contains("`right` of body `bar`"),
        "{error}"
    );
    run(&mut problem, &[(0.5, 1), (1.0, 1)]);

    let mut body = block([0.0; 2], [1.0, 1.0], [2, 2], true);
    body.during(&[[0.0, 1.0]], |body| body.prescribe("left", [Some(0.0); 2]))
        .expect("switched");
    let mut problem = alone(body);
    run(&mut problem, &[(1.0, 1)]);
    let error = phases(&[1.0, 2.0])
        .run(&mut problem)
        .expect_err("nothing holds it then");
    assert!(
        matches!(&error, Error::InPhase { until: 2.0, .. }),
        "{error}"
    );
    run(&mut problem, &[(1.0, 1)]);
}

/// A die that is moved as a whole and then let go, under a weight, rests on a block as one that was let go at once.
#[test]
fn a_body_that_is_brought_into_place() {
    for small in [true, false] {
        let weight = if small { 0.05 } else { 2.0 };
        let end = |brought: bool| {
            let mut lower = block([0.0; 2], [2.0, 1.0], [6, 3], small);
            lower.prescribe("bottom", [Some(0.0); 2]).expect("held");
            let gap = if brought { 0.2 } else { 0.0 };
            let mut upper = block([0.5, 1.0 + gap], [1.0, 1.0], [4, 3], small);
            upper.prescribe("left", [Some(0.0), None]).expect("guided");
            let later = match brought {
                true => Amplitude::table(&[(1.0, 0.0), (2.0, 1.0)]).expect("a table"),
                false => Amplitude::default(),
            };
            upper
                .traction_in_time("top", [0.0, -weight], later)
                .expect("loaded");
            if brought {
                let down = Motion::translation([0.0, -0.2]).expect("a motion");
                upper
                    .during(&[[0.0, 1.0]], |upper| upper.prescribe_motion_of_all(down))
                    .expect("switched");
            }
            let mut scene = Scene::new();
            scene.geometry = Some(Geometry::Current);
            let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
            scene
                .contact(lower.on("top"), upper.on("bottom"))
                .expect("a pair");
            let mut problem = scene.problem().expect("a problem");
            let phases = match brought {
                true => &[(1.0, 1), (2.0, 4)][..],
                false => &[(1.0, 4)],
            };
            let history = run(&mut problem, phases);
            let last = history.last().expect("a step");
            assert!((last.contact_force(upper)[1] - weight).abs() < 1e-8 * weight);
            let x = problem.positions(&history.run.state.u);
            problem.nodes(upper).map(|node| x[node]).collect::<Vec<_>>()
        };
        let [brought, there] = [true, false].map(end);
        let off: Vec<Point> = brought.iter().zip(&there).map(|(a, b)| a - b).collect();
        println!("small {small}: {:.1e}", largest(&off));
        assert!(largest(&off) < 1e-8, "{:.1e}", largest(&off));
    }
}
