//! Bodies that nothing but contact holds, and columns that do not stand, against weights, statics and Euler.

use contact_fem::certificate::{Condition, Limits};
use contact_fem::element::{Element, P1, P2};
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::simulation::History;
use contact_fem::{Body, Mesh, NeoHookean, Scene, Simulation};
use ipopt_contact_scenes::Failure;

use crate::common::relative;

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Result<Mesh<2>, Failure> {
    let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
    Ok(rectangle(&line(0), &line(1), Diagonals::Alternating)?)
}

fn rubber<const D: usize>(mesh: Mesh<D>, young: f64) -> Result<Body<D>, Failure>
where
    P1: Element<D>,
    P2: Element<D>,
{
    Ok(Body::new(mesh, NeoHookean::new(young, 0.3)?))
}

/// Unit blocks of weight ½ (UF) on a floor from x = −1 to 2 that is as soft as they are.
struct Stack {
    high: usize,
    /// The left side of the blocks.
    left: f64,
    /// The angle of the weight from the vertical.
    tilt: f64,
    floor: [usize; 2],
    cells: [usize; 2],
    is_quadratic: bool,
}

impl Default for Stack {
    fn default() -> Self {
        Stack {
            high: 1,
            left: 0.0,
            tilt: 0.0,
            floor: [15, 5],
            cells: [6, 6],
            is_quadratic: false,
        }
    }
}

const WEIGHT: f64 = 0.5;

impl Stack {
    fn scene(&self) -> Result<Scene<2>, Failure> {
        let order = |mesh: Mesh<2>| match self.is_quadratic {
            true => mesh.quadratic(),
            false => mesh,
        };
        let mut scene = Scene::new();
        let mut floor = rubber(order(block([-1.0, -1.0], [3.0, 1.0], self.floor)?), 100.0)?;
        floor.prescribe("bottom", [Some(0.0); 2])?;
        let mut below = scene.add("floor", floor);
        for k in 0..self.high {
            let cells = [self.cells[0] + k % 2, self.cells[1]];
            let mesh = order(block([self.left, k as f64], [1.0; 2], cells)?);
            let mut upper = rubber(mesh, 100.0)?;
            let (sin, cos) = self.tilt.sin_cos();
            upper.body_force([WEIGHT * sin, -WEIGHT * cos])?;
            let upper = scene.add(format!("block {k}"), upper);
            scene.contact(below.on("top"), upper.on("bottom"))?;
            below = upper;
        }
        Ok(scene)
    }

    fn run(&self) -> History<2> {
        run(self.scene().expect("valid"), 1)
    }
}

fn run<const D: usize>(scene: Scene<D>, increments: usize) -> History<D> {
    let mut problem = scene.problem().expect("valid");
    let history = Simulation::with_increments(increments).run(&mut problem);
    history.expect("no misuse")
}

fn is_certified<const D: usize>(history: &History<D>) -> bool {
    let holds =
        |certificate: &contact_fem::certificate::Certificate| certificate.holds(&Limits::default());
    history.is_complete() && history.certificate().as_ref().is_some_and(holds)
}

/// The share of the contact forces that held a body.
fn held<const D: usize>(history: &History<D>) -> f64 {
    let certificate = history.certificate().expect("steps");
    certificate.left(Condition::Held).unwrap_or(0.0)
}

/// Blocks stay where they are on any mesh, and the floor carries them.
#[test]
fn blocks_rest_on_each_other() {
    let mut largest = 0.0_f64;
    for (k, high) in [1, 1, 1, 2, 3, 3, 4, 5].into_iter().enumerate() {
        let stack = Stack {
            high,
            left: 0.37 * k as f64 % 0.8 - 0.4,
            floor: [9 + 2 * k, 3 + k % 4],
            cells: [3 + 5 * k % 7, 4 + k % 3],
            is_quadratic: k % 3 == 2,
            ..Stack::default()
        };
        let history = stack.run();
        let ending = &history.run.ending;
        assert!(
            is_certified(&history),
            "{k}: {ending} {:?}",
            history.certificate()
        );
        let last = history.last().expect("steps");
        let carried = last.reactions[0][1];
        // what holds the blocks may have a part along their weight
        let off = relative(carried, WEIGHT * high as f64);
        assert!(off < 1e-5 + held(&history), "{k}: {carried}");
        assert!(history.run.cost().outer_iterations < 150, "{k}");
        largest = largest.max(held(&history));
    }
    println!("held by {largest:.1e} of the contact forces at most");
    assert!(largest < 1e-2, "{largest}");
}

/// A block whose centre is inside the edge of the floor stays; one whose centre is beyond it tips.
#[test]
fn a_block_tips_over_the_edge() {
    for (left, stays) in [(1.2, true), (1.6, false), (1.75, false)] {
        let history = Stack {
            left,
            ..Stack::default()
        }
        .run();
        assert_eq!(
            is_certified(&history),
            stays,
            "{left}: {}",
            history.run.ending
        );
    }
}

/// A block on a slope needs friction of its tangent to stay: so much holds it where that is little; and no more than that.
#[test]
fn a_block_on_a_slope() {
    for degrees in [0.3_f64, 0.6] {
        let history = Stack {
            tilt: degrees.to_radians(),
            ..Stack::default()
        }
        .run();
        assert!(is_certified(&history), "{degrees}: {}", history.run.ending);
        let (held, needed) = (held(&history), degrees.to_radians().tan());
        assert!(relative(held, needed) < 0.1, "{degrees}: {held} {needed}");
    }
    for degrees in [2.0_f64, 10.0] {
        let history = Stack {
            tilt: degrees.to_radians(),
            ..Stack::default()
        }
        .run();
        assert!(!is_certified(&history), "{degrees}");
    }
}

#[test]
fn a_block_rests_in_space() {
    for (across, is_quadratic) in [(2, false), (3, false), (2, true)] {
        let scene = || -> Result<Scene<3>, Failure> {
            let body = |low: [f64; 3], size: [f64; 3], cells: [usize; 3]| {
                let mut mesh = cuboid(low, size, cells)?;
                if is_quadratic {
                    mesh = mesh.quadratic();
                }
                mesh.name_boundary("lower", |x| x[2] == low[2]);
                mesh.name_boundary("upper", |x| x[2] == low[2] + size[2]);
                rubber(mesh, 100.0)
            };
            let mut scene = Scene::new();
            let mut floor = body([-1.0, -1.0, -1.0], [3.0, 3.0, 1.0], [5, 5, 2])?;
            floor.prescribe("lower", [Some(0.0); 3])?;
            let floor = scene.add("floor", floor);
            let mut upper = body([0.1, 0.2, 0.0], [1.0; 3], [across, across, 2])?;
            upper.body_force([0.0, 0.0, -1.0])?;
            let upper = scene.add("block", upper);
            scene.contact(floor.on("upper"), upper.on("lower"))?;
            Ok(scene)
        };
        let history = run(scene().expect("valid"), 1);
        assert!(is_certified(&history), "{across}: {}", history.run.ending);
        let carried = history.last().expect("steps").reactions[0][2];
        assert!(relative(carried, 1.0) < 1e-5, "{across}: {carried}");
    }
}

/// A clamped column beside a wall, pressed to ten times its Euler load. Straight, it would store E w h (δ/h)²/2 and more; it bows
/// when it passes that load, and leaves the straight state for good.
#[test]
fn a_straight_column_bows() {
    const HEIGHT: f64 = 10.0;
    const WIDTH: f64 = 0.4;
    const YOUNG: f64 = 1e3;
    const PUSH: f64 = 0.5;
    for increments in [8, 20] {
        let scene = || -> Result<Scene<2>, Failure> {
            let mut scene = Scene::new();
            let mesh = block([-0.5 * WIDTH, 0.0], [WIDTH, HEIGHT], [4, 80])?;
            let mut column = Body::new(mesh, NeoHookean::new(YOUNG, 0.0)?);
            column.prescribe("bottom", [Some(0.0); 2])?;
            column.prescribe("top", [Some(0.0), Some(-PUSH)])?;
            let column = scene.add("column", column);
            let mut wall = Body::new(
                block([0.5, 2.0], [1.0, 6.0], [3, 24])?,
                NeoHookean::new(1e4, 0.3)?,
            );
            wall.prescribe("right", [Some(0.0); 2])?;
            let wall = scene.add("wall", wall);
            scene.contact(column.on("right"), wall.on("left"))?;
            Ok(scene)
        };
        let history = run(scene().expect("valid"), increments);
        assert!(
            is_certified(&history),
            "{increments}: {}",
            history.run.ending
        );
        let last = history.last().expect("steps");
        let straight = 0.5 * YOUNG * WIDTH * PUSH * PUSH / HEIGHT;
        assert!(last.energy < 0.5 * straight, "{} {straight}", last.energy);
        // below a tenth of the push it is straight, by Euler's 4 π² E I/h²
        let euler =
            4.0 * std::f64::consts::PI.powi(2) * YOUNG * WIDTH.powi(3) / 12.0 / HEIGHT.powi(2);
        let first = &history.steps[0];
        let stored = 0.5 * YOUNG * WIDTH * (PUSH / increments as f64).powi(2) / HEIGHT;
        let load = YOUNG * WIDTH * PUSH / increments as f64 / HEIGHT;
        if load < euler {
            assert!(
                relative(first.energy, stored) < 0.02,
                "{} {stored}",
                first.energy
            );
        }
    }
}

/// A column that stands on a rigid floor or carries a loose block, far beyond Greenhill's and Euler's loads: straight, it is no stable
/// equilibrium, and what holds bodies in place does not hold a bow.
#[test]
fn slender_columns_do_not_stand() {
    const YOUNG: f64 = 1e3;
    const HEIGHT: f64 = 10.0;
    let column = |cells: [usize; 2]| -> Result<Body<2>, Failure> {
        let mesh = block([-0.25, 0.0], [0.5, HEIGHT], cells)?;
        Ok(Body::new(mesh, NeoHookean::new(YOUNG, 0.0)?))
    };
    // q h³ = 7.84 E I
    let greenhill = 7.84 * YOUNG * 0.5_f64.powi(3) / 12.0 / HEIGHT.powi(3);
    for (times, stands) in [(0.3, true), (2.5, false), (4.0, false)] {
        let scene = || -> Result<Scene<2>, Failure> {
            let mut scene = Scene::new();
            let mut floor = rubber(block([-2.0, -1.0], [4.0, 1.0], [12, 3])?, 1e5)?;
            floor.prescribe("bottom", [Some(0.0); 2])?;
            let floor = scene.add("floor", floor);
            let mut column = column([2, 40])?;
            column.body_force([0.0, -2.0 * times * greenhill])?;
            let column = scene.add("column", column);
            scene.contact(floor.on("top"), column.on("bottom"))?;
            Ok(scene)
        };
        let history = run(scene().expect("valid"), 1);
        assert_eq!(
            is_certified(&history),
            stands,
            "{times}: {}",
            history.run.ending
        );
    }
    let euler =
        std::f64::consts::PI.powi(2) * YOUNG * 0.5_f64.powi(3) / 12.0 / (4.0 * HEIGHT * HEIGHT);
    for times in [2.0, 6.0] {
        let scene = || -> Result<Scene<2>, Failure> {
            let mut scene = Scene::new();
            let mut column = column([4, 60])?;
            column.prescribe("bottom", [Some(0.0); 2])?;
            let column = scene.add("column", column);
            let mut load = rubber(block([-1.0, HEIGHT], [2.0, 0.5], [9, 3])?, 1e4)?;
            load.body_force([0.0, -times * euler])?;
            let load = scene.add("load", load);
            scene.contact(column.on("top"), load.on("bottom"))?;
            Ok(scene)
        };
        let history = run(scene().expect("valid"), 1);
        assert!(!is_certified(&history), "{times}");
    }
}

/// A block that a wide press pushes against a wall: what holds it is compared with its weight, too, not with the press alone. Where the
/// certificate holds, floor and press carry the weight.
#[test]
fn a_pressed_block_is_carried() {
    let weight = 0.4;
    let mut certified = 0;
    for (cells, is_quadratic) in [([5, 5], false), ([6, 4], false), ([5, 5], true)] {
        let scene = || -> Result<Scene<2>, Failure> {
            let order = |mesh: Mesh<2>| match is_quadratic {
                true => mesh.quadratic(),
                false => mesh,
            };
            let mut scene = Scene::new();
            let mut floor = rubber(order(block([-2.0, -1.0], [8.0, 1.0], [24, 3])?), 100.0)?;
            floor.prescribe("bottom", [Some(0.0); 2])?;
            let floor = scene.add("floor", floor);
            let mut middle = rubber(order(block([0.0, 0.0], [1.0, 1.0], cells)?), 100.0)?;
            middle.body_force([0.0, -weight])?;
            let middle = scene.add("block", middle);
            let mut press = rubber(order(block([-1.0, 0.2], [0.99, 0.6], [4, 3])?), 1e3)?;
            press.prescribe("left", [Some(0.12), Some(0.0)])?;
            let press = scene.add("press", press);
            let mut wall = rubber(order(block([1.05, 0.05], [0.5, 1.2], [2, 7])?), 1e5)?;
            wall.prescribe("right", [Some(0.0); 2])?;
            let wall = scene.add("wall", wall);
            scene.contact(floor.on("top"), middle.on("bottom"))?;
            scene.contact(press.on("right"), middle.on("left"))?;
            scene.contact(wall.on("left"), middle.on("right"))?;
            Ok(scene)
        };
        let history = run(scene().expect("valid"), 4);
        if is_certified(&history) {
            let reactions = &history.last().expect("steps").reactions;
            let carried: f64 = reactions.iter().map(|r| r[1]).sum();
            // by the limit of what holds
            assert!(
                relative(carried, weight) < 0.02 + 1e-5,
                "{cells:?}: {carried}"
            );
            certified += 1;
        }
    }
    assert!(certified > 0);
}
