//! Rows and contact forces vary continuously with the state.
//!
//! Where rows jump, there may be no equilibrium between the two sides of the jump. Every scene here is brought to an
//! equilibrium with forces, its rows are evaluated at states on lines through it, and their changes between neighbouring
//! states have to fall with the distance of these, down to 1e-8 of the line. Jumps below some 1e-7 are not seen.
//!
//! Jumps that are known are told with their sizes: a test fails, too, when one of them is mended.

mod line;
mod points;

use std::fmt::Write;

use contact_core::{Automatic, Ending};
use contact_fem::contact::Projection;
use contact_fem::element::Order::{self, Linear, Quadratic};
use contact_fem::model::{Geometry, Integration};
use contact_fem::{Phase, Scene, Simulation};
use ipopt_contact_scenes::ball::Ball;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::blocks::Blocks;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::hertz::{self, Hertz};
use ipopt_contact_scenes::ironing::{self, Ironing};
use ipopt_contact_scenes::{arch, cantilevers, hairpin, sliding_disc};
use line::Line;

const GAUSS: Integration = Integration::Gauss(4);
const EXACT: Integration = Integration::Exact;
const INTEGRATIONS: [Integration; 2] = [GAUSS, EXACT];
const ORDERS: [Order; 2] = [Linear, Quadratic];

/// The largest jump on so many random lines through the equilibrium at the end of these phases, 0 if there is none, and all of them in words.
/// Contact is searched at current positions.
fn largest_jump<const D: usize>(
    mut scene: Scene<D>,
    integration: Integration,
    phases: &[Phase],
    lines: u64,
) -> (f64, String) {
    scene.integration = Some(integration);
    scene.geometry = Some(Geometry::Current);
    let mut problem = scene.problem().expect("valid scene");
    let mut simulation = Simulation::solved_by(Automatic::default(), 1);
    simulation.load_steps.phases = phases.to_vec();
    let history = simulation.run(&mut problem).expect("no misuse");
    assert_eq!(history.run.ending, Ending::Complete);
    let equilibrium = history.run.solution.as_ref().expect("converged");
    assert!(equilibrium.lambda.iter().any(|l| *l > 0.0), "forces act");
    let (mut largest, mut told) = (0.0, String::new());
    for seed in 0..lines {
        let mut line = Line::random(&problem, equilibrium, seed);
        for (kind, jump) in line.jumps() {
            let place = points::told(&problem, &line, &jump);
            let _ = writeln!(told, "line {seed}, {kind:?}: {place}");
            largest = jump.size.max(largest);
        }
    }
    (largest, told)
}

fn assert_continuous<const D: usize>(
    scene: Scene<D>,
    integration: Integration,
    steps: usize,
    lines: u64,
) {
    let phases = [Phase::new("load", 1.0, steps)];
    let (size, told) = largest_jump(scene, integration, &phases, lines);
    assert!(size == 0.0, "{integration:?}\n{told}");
}

/// The largest jump is as large as told, within a factor of ten: which one is found depends on the last digits of the state.
fn assert_jumps<const D: usize>(
    scene: Scene<D>,
    integration: Integration,
    steps: usize,
    lines: u64,
    expected: f64,
) {
    let phases = [Phase::new("load", 1.0, steps)];
    let (size, told) = largest_jump(scene, integration, &phases, lines);
    let is_known = (0.1 * expected..10.0 * expected).contains(&size);
    assert!(
        is_known,
        "{integration:?}: {size:.3e} instead of {expected:.3e}\n{told}"
    );
}

fn discs(order: Order) -> Scene<2> {
    let fineness = Fineness::scaled(24);
    let scene = match order {
        Linear => disc_in_disc::scene(fineness, Roles::default()),
        Quadratic => disc_in_disc::quadratic_scene(fineness, Roles::default()),
    };
    scene.expect("a scene")
}

/// The battery can fail: the closest point jumps from facet to facet.
#[test]
fn closest_points_jump() {
    let mut scene = discs(Linear);
    scene.projection = Projection::Closest;
    assert_jumps(scene, GAUSS, 20, 3, 2.36e-3);
}

#[test]
fn disc_in_disc() {
    for order in ORDERS {
        for integration in INTEGRATIONS {
            assert_continuous(discs(order), integration, 20, 2);
        }
    }
}

#[test]
fn cylinder_on_a_block() {
    let fineness = hertz::Fineness {
        in_contact: 4.0,
        on_arc: 12,
    };
    for order in ORDERS {
        for integration in INTEGRATIONS {
            let scene = Hertz::new(fineness, order).scene().expect("a scene");
            assert_continuous(scene, integration, 2, 2);
        }
    }
}

#[test]
fn a_die_that_slides() {
    let phases = ironing::phases(4, 8);
    for order in ORDERS {
        for integration in INTEGRATIONS {
            let scene = Ironing::new(order, 18).scene().expect("a scene");
            let (size, told) = largest_jump(scene, integration, &phases, 3);
            assert!(size == 0.0, "{order:?} {integration:?}\n{told}");
        }
    }
}

#[test]
fn an_arch_and_a_sliding_disc() {
    for integration in INTEGRATIONS {
        assert_continuous(arch::scene(1).expect("a scene"), integration, 4, 3);
        let scene = sliding_disc::scene(3, 0.7).expect("a scene");
        assert_continuous(scene, integration, 10, 3);
    }
}

fn blocks(divisions: [usize; 2], order: Order) -> Blocks {
    Blocks {
        large_strains: true,
        ..Blocks::new(divisions, order, EXACT)
    }
}

/// Both surfaces end at the same places. Where feet are the closest points, a Gauss point that passes the rim of the master enters
/// or leaves its rows at once, with its whole weight.
#[test]
fn rims_in_the_plane() {
    for order in ORDERS {
        let scene = || blocks([3, 4], order).plane().expect("a scene");
        for integration in INTEGRATIONS {
            assert_continuous(scene(), integration, 1, 3);
        }
        let mut jumps = scene();
        jumps.projection = Projection::Closest;
        assert_jumps(jumps, GAUSS, 1, 3, 0.5);
    }
}

/// The arms' ends are rims.
#[test]
fn a_hairpin_on_itself() {
    let hairpin = |fine| hairpin::scene(fine, true).expect("a scene");
    assert_continuous(hairpin(2), GAUSS, 10, 1);
    assert_continuous(hairpin(1), EXACT, 10, 1);
}

#[test]
fn a_ball_on_a_plane() {
    for order in ORDERS {
        let ball = Ball {
            in_contact: 1,
            order,
        };
        assert_continuous(ball.scene().expect("a scene"), GAUSS, 1, 1);
    }
    let ball = Ball {
        in_contact: 1,
        order: Linear,
    };
    assert_continuous(ball.scene().expect("a scene"), EXACT, 1, 1);
}

/// The ends of the arms touch.
///
/// Known jump of exact integration: a sliver of a piece that is opposite the edge at the end of an arm belongs to one facet there or to the next, and the
/// integrand is no polynomial round an edge.
#[test]
fn a_hairpin_in_space() {
    let scene = || hairpin::scene_in_space(1, 1).expect("a scene");
    let phases = [Phase::new("load", 0.99, 10)];
    let (size, told) = largest_jump(scene(), GAUSS, &phases, 1);
    assert!(size == 0.0, "{told}");
    assert_jumps(scene(), EXACT, 10, 1, 2.66e-5);
}

#[test]
fn rims_in_space() {
    for order in ORDERS {
        for integration in INTEGRATIONS {
            let scene = blocks([1, 2], order).space().expect("a scene");
            assert_continuous(scene, integration, 1, 1);
        }
    }
}

#[test]
fn beams_and_cantilevers() {
    for integration in INTEGRATIONS {
        let beams = Beams::new(1, Linear, Law::NeoHookean);
        assert_continuous(beams.scene().expect("a scene"), integration, 2, 1);
        let cantilevers = cantilevers::scene([4, 2, 2]).expect("a scene");
        assert_continuous(cantilevers, integration, 2, 1);
    }
}
