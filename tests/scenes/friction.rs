//! Coulomb's friction between bodies in the plane, against closed forms and balance.

use contact_core::friction::{Friction, SlipRows};
use contact_core::gaps::{RowKey, Sampling};
use contact_core::{
    Condensed, CondensedNewton, ContactProblem, Ending, Equilibrium, FixedPoint, InteriorPoint,
    LoadStepped, Phase,
};
use contact_fem::certificate::{Certificate, Condition, Limits};
use contact_fem::mesh::generators::{Diagonals, graded, linspace, rectangle};
use contact_fem::model::{Geometry, Passes, Problem};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, Mesh, Motion, NeoHookean, Obstacle, Scene, Simulation,
};

const YOUNG: f64 = 100.0;

fn mesh(x: [f64; 2], y: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let [xs, ys] = [(x, cells[0]), (y, cells[1])].map(|(x, n)| linspace(x[0], x[1], n));
    rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh")
}

fn body(mesh: Mesh<2>, is_linear: bool) -> Body<2> {
    match is_linear {
        true => Body::new(mesh, LinearElastic::new(YOUNG, 0.3).expect("a law")),
        false => Body::new(mesh, NeoHookean::new(YOUNG, 0.3).expect("a law")),
    }
}

fn certified(history: &History<2>) -> Certificate {
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&Limits::default()), "{certificate}");
    certificate
}

fn is_complete(history: &History<2>) -> bool {
    history.run.ending == Ending::Complete
}

/// What varies of a scene.
#[derive(Clone, Copy, Debug)]
struct Kind {
    is_linear: bool,
    is_quadratic: bool,
    swaps: bool,
    passes: Passes,
    geometry: Geometry,
}

const KINDS: [Kind; 6] = {
    let usual = Kind {
        is_linear: false,
        is_quadratic: false,
        swaps: false,
        passes: Passes::Both,
        geometry: Geometry::Current,
    };
    [
        usual,
        Kind {
            swaps: true,
            ..usual
        },
        Kind {
            is_quadratic: true,
            ..usual
        },
        Kind {
            passes: Passes::FirstIsSlave,
            ..usual
        },
        Kind {
            is_linear: true,
            geometry: Geometry::Reference,
            ..usual
        },
        Kind {
            is_linear: true,
            is_quadratic: true,
            ..usual
        },
    ]
};

/// An amplitude with these values at the times 0, 1, 2 ...
fn program(values: &[f64]) -> Amplitude {
    let pairs = values
        .iter()
        .enumerate()
        .map(|(t, value)| (t as f64, *value));
    Amplitude::table(&pairs.collect::<Vec<_>>()).expect("a table")
}

/// A block of width 1 on a plate, pushed down by a fiftieth and then drawn aside; meshes do not match. A plate that is held everywhere
/// stays plane.
fn drawn(kind: Kind, is_held: bool, friction: f64, aside: &[f64]) -> Problem<2> {
    let finished = |mesh: Mesh<2>| match kind.is_quadratic {
        true => mesh.quadratic(),
        false => mesh,
    };
    let plate = finished(mesh([-1.0, 2.0], [-1.0, 0.0], [13, 4]));
    let block = finished(mesh([0.0, 1.0], [0.0, 1.0], [5, 4]));
    let (mut plate, mut block) = (body(plate, kind.is_linear), body(block, kind.is_linear));
    match is_held {
        true => plate.prescribe_all([Some(0.0); 2]),
        false => plate.prescribe("bottom", [Some(0.0); 2]),
    }
    .expect("a support");
    let mut down = vec![1.0; aside.len()];
    down[0] = 0.0;
    block
        .prescribe_in_time("top", [None, Some(-0.02)], program(&down))
        .expect("a support");
    block
        .prescribe_in_time("top", [Some(1.0), None], program(aside))
        .expect("a support");
    let mut scene = Scene::new();
    scene.geometry = Some(kind.geometry);
    let (below, above) = match kind.swaps {
        false => {
            let below = scene.add("plate", plate).on("top");
            (below, scene.add("block", block).on("bottom"))
        }
        true => {
            let above = scene.add("block", block).on("bottom");
            (scene.add("plate", plate).on("top"), above)
        }
    };
    scene
        .contact_in_passes(above.clone(), below.clone(), kind.passes)
        .expect("a pair");
    scene
        .contact_friction(&below, &above, friction)
        .expect("a pair");
    scene.problem().expect("a problem")
}

fn phases(count: usize, increments: usize) -> Simulation {
    let phases = (1..=count).map(|k| Phase::new(format!("{k}"), k as f64, increments));
    Simulation::in_phases(phases)
}

fn run(problem: &mut Problem<2>, simulation: &mut Simulation, what: &str) -> History<2> {
    let history = simulation.run(problem).expect("no misuse");
    assert!(is_complete(&history), "{what}: {}", history.run.ending);
    history
}

/// A block on a plane that does not give way slips as a whole where it is drawn far enough: what draws it is μ times what presses it,
/// whatever the law, the cells, the order of the bodies and the passes.
#[test]
fn drawn_blocks_slip_at_the_coefficient_times_the_pressure() {
    for kind in KINDS {
        for friction in [0.1, 0.6] {
            let what = format!("{kind:?} {friction}");
            let mut problem = drawn(kind, true, friction, &[0.0, 0.0, 0.1]);
            let history = run(&mut problem, &mut phases(2, 5), &what);
            let last = history.last().expect("a step");
            let block = if kind.swaps { 0 } else { 1 };
            let [aside, down] = last.reactions[block].into();
            let found = aside / down.abs() / friction;
            // normals of the block's own side lean where its corners lift off; rows on the block have those of the plane
            let leans = match kind.passes {
                Passes::Both => 2e-2,
                _ => 1e-4,
            };
            assert!((found - 1.0).abs() < leans, "{what}: {aside} {down}");
            certified(&history);
            let pair = &last.pairs[0];
            assert!((pair.friction.norm() / pair.resultant.norm() / friction - 1.0).abs() < 1e-4);
            // the forces on a body are all that it feels
            assert!(
                (last.contact_forces[block] + last.reactions[block]).norm() < 1e-6 * down.abs()
            );
        }
    }
}

/// Work is stored, or taken by friction, up to what the steps of the rules leave out, on a plate that gives way, too. Both fall with the increments.
#[test]
fn work_is_stored_or_taken_by_friction() {
    let lost = |increments: usize| {
        let mut problem = drawn(KINDS[0], false, 0.3, &[0.0, 0.0, 0.1, -0.1]);
        let history = run(&mut problem, &mut phases(3, increments), "work");
        certified(&history);
        let last = history.last().expect("a step");
        for pair in history.steps.windows(2) {
            assert!(pair[1].dissipated > pair[0].dissipated - 1e-9);
        }
        assert!(last.dissipated > 0.01, "{}", last.dissipated);
        let lost = (last.work() - last.stored_energy - last.dissipated).abs();
        lost / last.dissipated
    };
    let [coarse, fine] = [5, 20].map(lost);
    assert!(fine < 0.02 && fine < 0.5 * coarse, "{coarse} {fine}");
}

/// A block on an incline stays iff tan α < μ, held by friction alone.
#[test]
fn blocks_slide_where_the_incline_is_steeper_than_the_friction() {
    let friction = 0.3;
    for kind in [KINDS[0], KINDS[2], KINDS[5]] {
        for (share, stays) in [(0.5, true), (0.95, true), (1.05, false)] {
            let alpha = f64::atan(share * friction);
            let block = mesh([0.0, 1.0], [0.0, 0.5], [6, 3]);
            let block = if kind.is_quadratic {
                block.quadratic()
            } else {
                block
            };
            let mut block = body(block, kind.is_linear);
            block
                .body_force([alpha.sin(), -alpha.cos()])
                .expect("a load");
            let mut scene = Scene::new();
            scene.geometry = Some(kind.geometry);
            let side = scene.add("block", block).on("bottom");
            let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
            let plane = scene.obstacle("plane", side, plane).expect("a side");
            scene.obstacle_friction(plane, friction).expect("friction");
            let mut problem = scene.problem().expect("a problem");
            let history = Simulation::with_increments(2)
                .run(&mut problem)
                .expect("no misuse");
            assert_eq!(is_complete(&history), stays, "{kind:?} {share}");
            if stays {
                certified(&history);
                let [aside, down] = history.last().expect("a step").obstacle_forces[0].into();
                assert!((aside / 0.5 - alpha.sin()).abs() < 1e-6, "{aside}");
                assert!((down / 0.5 + alpha.cos()).abs() < 1e-6, "{down}");
            }
        }
    }
}

/// A plane that moves under a pressed block drags it by μ times the force, and does the work that friction takes.
#[test]
fn moving_obstacles_drag_along() {
    for kind in [KINDS[0], KINDS[2], KINDS[4]] {
        let friction = 0.4;
        let block = mesh([0.0, 1.0], [0.0, 1.0], [5, 4]);
        let block = if kind.is_quadratic {
            block.quadratic()
        } else {
            block
        };
        let mut block = body(block, kind.is_linear);
        let down = program(&[0.0, 1.0, 1.0]);
        block
            .prescribe_in_time("top", [Some(0.0), Some(-0.02)], down)
            .expect("a support");
        let mut scene = Scene::new();
        scene.geometry = Some(kind.geometry);
        let side = scene.add("block", block).on("bottom");
        let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
        let aside = Motion::translation([1.0, 0.0]);
        let plane = plane.moving(aside.expect("a way").driven_by(program(&[0.0, 0.0, 0.5])));
        let plane = scene.obstacle("belt", side, plane).expect("a side");
        scene.obstacle_friction(plane, friction).expect("friction");
        let mut problem = scene.problem().expect("a problem");
        let history = run(&mut problem, &mut phases(2, 10), "belt");
        certified(&history);
        let last = history.last().expect("a step");
        let [aside, down] = last.obstacle_forces[0].into();
        // the block holds the belt back
        assert!(
            (aside / down / friction - 1.0).abs() < 1e-4,
            "{aside} {down}"
        );
        let lost = last.work() - last.stored_energy - last.dissipated;
        // the first of ten steps begins to slip somewhere on its way, and the rules of both works are off by half of it at most
        assert!(
            lost.abs() < 0.5 / 10.0 * last.dissipated,
            "{lost} {}",
            last.dissipated
        );
    }
}

/// Friction of 0 is none: nothing of it is looked at, and another solver is taken.
#[test]
fn no_friction_is_free() {
    let mut problem = drawn(KINDS[0], false, 0.0, &[0.0, 0.0, 0.1]);
    let history = run(&mut problem, &mut phases(2, 5), "without");
    let certificate = certified(&history);
    for condition in [
        Condition::FrictionLaw,
        Condition::FrictionSlip,
        Condition::RemeasuredFriction,
    ] {
        assert_eq!(certificate.left(condition), None);
    }
    let last = history.last().expect("a step");
    assert_eq!(
        (last.attempt.solver(), last.dissipated),
        (Some("newton"), 0.0)
    );
    assert!(history.run.solution.expect("a solution").friction.is_none());
}

/// Bodies that friction holds everywhere move as those that are tied: both ends of a bar of two halves are drawn aside, and pressed by more than
/// friction needs.
#[test]
fn what_sticks_is_as_if_it_were_tied() {
    let half = |x: [f64; 2], cells: usize| body(mesh(x, [0.0, 1.0], [4, cells]), false);
    let built = |is_tied: bool| {
        let (mut left, mut right) = (half([0.0, 1.0], 4), half([1.0, 2.0], 5));
        left.prescribe("left", [Some(0.0); 2]).expect("a support");
        let press = program(&[0.0, 1.0, 1.0]);
        right
            .prescribe_in_time("right", [Some(-0.05), None], press)
            .expect("a support");
        let aside = program(&[0.0, 0.0, 1.0]);
        right
            .prescribe_in_time("right", [None, Some(0.02)], aside)
            .expect("a support");
        let mut scene = Scene::new();
        scene.geometry = Some(Geometry::Current);
        let left = scene.add("left", left).on("right");
        let right = scene.add("right", right).on("left");
        if is_tied {
            scene.tie(left, right).expect("a tie");
        } else {
            scene.contact(left.clone(), right.clone()).expect("a pair");
            scene.contact_friction(&left, &right, 5.0).expect("a pair");
        }
        let mut problem = scene.problem().expect("a problem");
        let history = run(&mut problem, &mut phases(2, 2), "bar");
        history.last().expect("a step").reactions[0]
    };
    let [sticks, tied] = [false, true].map(built);
    assert!(
        (sticks - tied).norm() < 2e-3 * tied.norm(),
        "{sticks} {tied}"
    );
}

/// The result is that of the bodies in the other order, whatever the mesh of either.
#[test]
fn the_order_of_bodies_does_not_matter() {
    let ends = [KINDS[0], KINDS[1]].map(|kind| {
        let mut problem = drawn(kind, false, 0.3, &[0.0, 0.0, 0.1]);
        let history = run(&mut problem, &mut phases(2, 5), "order");
        let last = history.last().expect("a step");
        let block = if kind.swaps { 0 } else { 1 };
        (last.energy, last.dissipated, last.reactions[block])
    });
    let [(e, d, r), (energy, dissipated, reaction)] = ends;
    assert!((e - energy).abs() < 1e-6 * energy && (d - dissipated).abs() < 1e-6 * d);
    assert!(
        (r - reaction).norm() < 1e-6 * reaction.norm(),
        "{r} {reaction}"
    );
}

/// Faults of the forces of friction do not pass the certificate.
#[test]
fn faults_of_friction_are_not_certified() {
    let mut problem = drawn(KINDS[0], false, 0.3, &[0.0, 0.0, 0.1]);
    let history = run(&mut problem, &mut phases(2, 5), "faults");
    let solution = history.run.solution.expect("a solution");
    let judged = |fault: &dyn Fn(&mut Friction)| {
        let mut spoiled = solution.clone();
        fault(spoiled.friction.as_mut().expect("friction"));
        let certificate = Certificate::new(&problem, &spoiled);
        let entries = certificate.entries(&Limits::default());
        let beyond = entries.filter(|entry| !entry.holds());
        beyond.map(|entry| entry.name).collect::<Vec<_>>()
    };
    assert_eq!(judged(&|_| {}), Vec::<&str>::new());
    let scaled =
        |by: f64| judged(&move |own: &mut Friction| own.forces.iter_mut().for_each(|r| *r *= by));
    assert!(scaled(1.01).contains(&"friction_law"));
    for by in [0.99, 0.0, -1.0] {
        let found = scaled(by);
        let names = ["friction_slip", "stationarity"];
        assert!(
            names.iter().all(|name| found.contains(name)),
            "{by}: {found:?}"
        );
    }
    // rows along which friction acts that are a hundredth too long
    let longer = judged(&|own: &mut Friction| {
        let mut rows = SlipRows::default();
        for (i, key) in own.rows.keys().iter().enumerate() {
            let mut row = own.rows.row(i);
            row.free.iter_mut().for_each(|(_, a)| *a *= 1.01);
            rows.push(*key, &row);
        }
        own.rows = rows;
    });
    assert!(longer.contains(&"remeasured_friction"), "{longer:?}");
    // a solution that says nothing of friction
    let mut silent = solution.clone();
    silent.friction = None;
    assert!(!Certificate::new(&problem, &silent).holds(&Limits::default()));
}

/// Friction in space, below 0 and of what there is not is refused by name.
#[test]
fn refusals_name_the_value() {
    let mut scene = Scene::new();
    let [below, above] = [0.0, 1.0].map(|y| {
        let block = body(mesh([0.0, 1.0], [y, y + 1.0], [2, 2]), true);
        scene.add(format!("block at {y}"), block)
    });
    let sides = [below.on("top"), above.on("bottom")];
    let said = |result: Result<(), Error>| result.expect_err("refused").to_string();
    let text = said(scene.contact_friction(&sides[0], &sides[1], 0.3));
    assert!(text.contains("block at 0"), "{text}");
    scene
        .contact(sides[0].clone(), sides[1].clone())
        .expect("a pair");
    for wrong in [-0.1, f64::NAN, f64::INFINITY] {
        let text = said(scene.contact_friction(&sides[1], &sides[0], wrong));
        let names = ["friction", &wrong.to_string()];
        assert!(names.iter().all(|name| text.contains(name)), "{text}");
    }
    let mut scene = ipopt_contact_scenes::cantilevers::scene([4, 2, 2]).expect("a scene");
    let pair = scene.pairs()[0].clone();
    scene
        .contact_friction(&pair.first, &pair.second, 0.25)
        .expect("a pair");
    let text = scene.problem().err().expect("refused").to_string();
    assert!(
        text.contains("0.25") && text.contains("in the plane"),
        "{text}"
    );
}

/// Cattaneo's and Mindlin's contact: a round body is pressed on a plane one of the same law, by P on a half-width a, and drawn aside by Q. The middle
/// sticks, to c = a √(1 − Q/μP), and the traction along the surface is a share 1 − √(c² − x²)/√(a² − x²) of μp there. Both bodies are 30 a
/// deep.
#[test]
fn the_middle_of_a_round_contact_sticks() {
    // nodes scatter; with 8 facets in a it is 18 % with linear cells
    let [linear, quadratic] = [false, true].map(error_of_tractions);
    assert!(
        linear.abs() < 0.1 && quadratic.abs() < 0.02,
        "{linear} {quadratic}"
    );
}

/// The relative error of the mean traction in the middle half, after the zones are checked; facets are a/16 and a/14.
fn error_of_tractions(is_quadratic: bool) -> f64 {
    let (young, poisson, friction, radius) = (1.0, 0.3, 0.3, 1.0);
    // forces of corners and of nodes between them scatter
    let (most_that_sticks, scatter) = if is_quadratic {
        (0.9, 0.1)
    } else {
        (0.6, 1e-3)
    };
    let a = 0.02;
    let block = |first: f64, is_upper: bool| {
        let half = graded(0.0, 30.0 * a, first, 26).expect("a line");
        let left = half[1..].iter().rev().map(|x| -x);
        let xs: Vec<f64> = left.chain(half.iter().copied()).collect();
        let ys: Vec<f64> = half.iter().rev().map(|y| -y).collect();
        let ys = if is_upper { &half } else { &ys };
        let mesh = rectangle(&xs, ys, Diagonals::Alternating).expect("a mesh");
        let round = |x: &Vector<2>| {
            let rise = 0.5 * x[0] * x[0] / radius;
            let share = if is_upper {
                1.0 - x[1] / (30.0 * a)
            } else {
                0.0
            };
            Vector::<2>::new(x[0], x[1] + share * rise)
        };
        let mesh = mesh.mapped(round).expect("a mesh");
        let mesh = if is_quadratic { mesh.quadratic() } else { mesh };
        Body::new(mesh, LinearElastic::new(young, poisson).expect("a law"))
    };
    let (mut lower, mut upper) = (block(a / 16.0, false), block(a / 14.0, true));
    lower
        .prescribe("bottom", [Some(0.0); 2])
        .expect("a support");
    upper
        .prescribe_in_time("top", [None, Some(-1.2e-3)], program(&[0.0, 1.0, 1.0]))
        .expect("a support");
    upper
        .prescribe_in_time("top", [Some(3e-4), None], program(&[0.0, 0.0, 1.0]))
        .expect("a support");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower).on("top");
    let upper = scene.add("upper", upper).on("bottom");
    scene.contact(lower.clone(), upper.clone()).expect("a pair");
    scene
        .contact_friction(&lower, &upper, friction)
        .expect("a pair");
    let mut problem = scene.problem().expect("a problem");
    let history = run(&mut problem, &mut phases(2, 4), "round");
    certified(&history);
    let last = history.last().expect("a step");
    let [aside, down] = last.reactions[1].into();
    let (pressed, drawn) = (-down, aside);
    let modulus = 0.5 * young / (1.0 - poisson * poisson);
    let a = (4.0 * pressed * radius / (std::f64::consts::PI * modulus)).sqrt();
    let c = a * (1.0 - drawn / (friction * pressed)).sqrt();
    let solution = history.run.solution.expect("a solution");
    let normal = problem.contact_forces(&solution.gaps, &solution.lambda);
    let all = problem.surface_forces(&solution);
    let (mut found, mut expected) = (0.0, 0.0);
    for &node in problem.surfaces()[0].nodes() {
        let x = problem.reference()[node][0].abs();
        let (along, most) = ((all[node] - normal[node])[0], friction * normal[node][1]);
        let share = along / most;
        if x < 0.5 * a {
            found += along.abs();
            expected += most.abs() * (1.0 - ((c * c - x * x) / (a * a - x * x)).sqrt());
            assert!(
                share.abs() < most_that_sticks,
                "{} a sticks: {share}",
                x / a
            );
        } else if 0.8 * a < x && x < a {
            assert!(
                (share.abs() - 1.0).abs() < scatter,
                "{} a slips: {share}",
                x / a
            );
        }
    }
    let middle: f64 = c / a;
    assert!((middle - 0.67).abs() < 0.02, "{middle} of a is the middle");
    found / expected - 1.0
}

/// All three ways to solve end in the same state where contact is small and in the reference geometry.
#[test]
fn three_solvers_end_in_the_same_state() {
    fn end<S: Equilibrium>(solver: S) -> (f64, f64, Vector<2>) {
        let mut problem = drawn(KINDS[4], false, 0.3, &[0.0, 0.0, 0.04, -0.02]);
        let phases = (1..=3).map(|k| Phase::new(format!("{k}"), k as f64, 4));
        let mut simulation = Simulation::solved_by(solver, 1);
        simulation.load_steps.phases = phases.collect();
        let history = simulation.run(&mut problem).expect("no misuse");
        assert!(is_complete(&history), "{}", history.run.ending);
        certified(&history);
        let last = history.last().expect("a step");
        (last.energy, last.dissipated, last.reactions[1])
    }
    let (energy, dissipated, reaction) = end(Condensed::default());
    assert!(dissipated > 0.1 * energy, "{dissipated} {energy}");
    let newton = end(CondensedNewton::default());
    let fixed_point = FixedPoint::<InteriorPoint> {
        tolerance: 1e-8,
        ..FixedPoint::default()
    };
    // thresholds end when forces change by less than 1e-6 of the largest
    for (other, accuracy) in [(newton, 1e-7), (end(fixed_point), 1e-4)] {
        let (e, d, r) = other;
        assert!((e - energy).abs() < accuracy * energy, "{e} {energy}");
        assert!(
            (d - dissipated).abs() < accuracy * dissipated,
            "{d} {dissipated}"
        );
        assert!(
            (r - reaction).norm() < accuracy * reaction.norm(),
            "{r} {reaction}"
        );
    }
}

/// A ball that turns under a pressed block drags it by μ times the force, also where one step turns it by more than slips may be chords of: the step
/// is cut.
#[test]
fn steps_that_turn_an_obstacle_far_are_cut() {
    let friction = 0.4;
    let mut block = body(mesh([-0.5, 0.5], [1.0, 1.6], [8, 4]), false);
    let down = program(&[0.0, 1.0, 1.0]);
    block
        .prescribe_in_time("top", [Some(0.0), Some(-0.05)], down)
        .expect("a support");
    let mut scene = Scene::new();
    let side = scene.add("block", block).on("bottom");
    let ball = Obstacle::ball([0.0; 2], 1.0).expect("a ball");
    let turn = Motion::<2>::rotation([0.0; 2], 5.0).expect("a way");
    let ball = ball.moving(turn.driven_by(program(&[0.0, 0.0, 1.0])));
    let ball = scene.obstacle("ball", side, ball).expect("a side");
    scene.obstacle_friction(ball, friction).expect("friction");
    let mut problem = scene.problem().expect("a problem");
    let history = run(&mut problem, &mut phases(2, 1), "ball");
    certified(&history);
    assert!(history.run.cuts() > 0);
    let pair = &history.last().expect("a step").pairs[0];
    // its top goes to the left
    assert!(pair.friction[0] < 0.0, "{}", pair.friction);
    let share = pair.friction.norm() / pair.resultant.norm() / friction;
    assert!((share - 1.0).abs() < 1e-2, "{share}");
}

/// A slender column bows at its Euler load, whether or not another body rubs on a floor meanwhile.
#[test]
fn columns_beside_friction_bow() {
    let bow = |friction: f64| {
        let column = mesh([0.0, 1.0], [0.0, 20.0], [2, 40]).quadratic();
        let mut column = body(column, false);
        for (side, down) in [("bottom", 0.0), ("top", -0.6)] {
            column
                .prescribe(side, [Some(0.0), Some(down)])
                .expect("a support");
        }
        let mut block = body(mesh([10.0, 11.0], [0.0, 0.5], [4, 2]), false);
        block
            .prescribe("top", [Some(0.05), Some(-0.01)])
            .expect("a support");
        let mut scene = Scene::new();
        scene.add("column", column);
        let side = scene.add("block", block).on("bottom");
        let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
        let plane = scene.obstacle("floor", side, plane).expect("a side");
        scene.obstacle_friction(plane, friction).expect("friction");
        let mut problem = scene.problem().expect("a problem");
        let history = run(&mut problem, &mut Simulation::with_increments(5), "column");
        certified(&history);
        let displacements = problem.displacements(&history.run.state.u);
        let aside = displacements.iter().map(|u| u[0].abs());
        aside.fold(0.0, f64::max)
    };
    // straight, nothing moves aside by more than the block's 0.05
    let [with, without] = [0.3, 0.0].map(bow);
    assert!(
        without > 1.0 && (with / without - 1.0).abs() < 1e-3,
        "{with} {without}"
    );
}

/// Forces of friction vary as their differences say, on a plate and on a ball, in the middle of a step.
#[test]
fn forces_of_friction_vary_as_their_differences() {
    let mut drawn = drawn(KINDS[0], false, 0.3, &[0.0, 0.05]);
    let mut block = body(mesh([-0.5, 0.5], [0.996, 1.6], [8, 4]), false);
    block.prescribe("top", [Some(0.0); 2]).expect("a support");
    let mut scene = Scene::new();
    let side = scene.add("block", block).on("bottom");
    let ball = Obstacle::ball([0.0; 2], 1.0).expect("a ball");
    let ball = scene.obstacle("ball", side, ball).expect("a side");
    scene.obstacle_friction(ball, 0.4).expect("friction");
    let mut ball = scene.problem().expect("a problem");
    for problem in [&mut drawn, &mut ball] {
        problem.set_load(0.5).expect("a load");
        let n = problem.dofs().free();
        let field = |size: f64, turn: f64| -> Vec<f64> {
            (1..=n)
                .map(|j| size * (turn * (j * j) as f64).sin())
                .collect()
        };
        let (rest, u, d) = (vec![0.0; n], field(0.005, 1.3), field(0.5, 2.7));
        let rows = |u: &[f64]| {
            let forward = problem.linearize_gaps(u, Sampling::Nodes).expect("rows");
            forward.and(
                problem
                    .linearize_reversed(u, Sampling::Nodes)
                    .expect("rows"),
            )
        };
        let gaps = rows(&u);
        let z: Vec<f64> = (0..gaps.len()).map(|i| (1.0 + i as f64).sin()).collect();
        let forces = |u: &[f64]| {
            let gaps = rows(u);
            let slips = problem.slips(u, &gaps, &rest, 0.0).expect("slips");
            let of = |key: &RowKey| {
                gaps.keys()
                    .iter()
                    .position(|own| own == key)
                    .expect("a row")
            };
            let against: Vec<f64> = slips.keys().iter().map(|key| -z[of(key)]).collect();
            let mut all = vec![0.0; n];
            slips.add_forces(&against, &mut all);
            all
        };
        let asked: Vec<Option<f64>> = z.iter().map(|z| Some(*z)).collect();
        let variation = problem.vary_slips(&u, &gaps, &asked).expect("a variation");
        let mut change = vec![0.0; n];
        for (i, j, value) in variation.expect("rows that vary").stiffness() {
            change[i] += value * d[j];
        }
        let t = 1e-7;
        let at = |t: f64| forces(&u.iter().zip(&d).map(|(u, d)| u + t * d).collect::<Vec<_>>());
        let (ahead, behind) = (at(t), at(-t));
        let largest = change.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for (j, change) in change.iter().enumerate() {
            let difference = (ahead[j] - behind[j]) / (2.0 * t);
            assert!(
                (difference - change).abs() < 1e-5 * largest,
                "{j}: {difference} {change}"
            );
        }
        assert!(largest > 0.1, "{largest}");
    }
}

/// A pair that keeps a distance has no friction: what turns with both bodies would count as a slip.
#[test]
fn friction_beside_a_distance_is_refused() {
    let mut scene = Scene::new();
    let [below, above] = [0.0, 1.1].map(|y| {
        let mut block = body(mesh([0.0, 1.0], [y, y + 1.0], [2, 2]), true);
        block.prescribe("left", [Some(0.0); 2]).expect("a support");
        scene.add(format!("block at {y}"), block)
    });
    let sides = [below.on("top"), above.on("bottom")];
    scene
        .contact(sides[0].clone(), sides[1].clone())
        .expect("a pair");
    scene
        .contact_offset(&sides[0], &sides[1], 0.1)
        .expect("a pair");
    scene
        .contact_friction(&sides[0], &sides[1], 0.3)
        .expect("a pair");
    let text = scene.problem().err().expect("refused").to_string();
    assert!(text.contains("offset of a pair with friction"), "{text}");
}
