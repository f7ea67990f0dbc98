//! Scenes without a solution, or without the one that the model could find: the run says so, and why.

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::{Body, LinearElastic, NeoHookean, Scene};

use crate::Failure;
use crate::extremes::{Case, Truth};

pub(super) fn all() -> Vec<Case> {
    vec![
        undeclared(),
        strained(),
        bent(),
        carried(),
        unheld(),
        overlapping(1e-3, 0.0),
        overlapping(0.2, 0.0),
    ]
}

fn block(
    low: [f64; 2],
    size: [f64; 2],
    cells: [usize; 2],
) -> Result<contact_fem::Mesh<2>, Failure> {
    let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
    let mut mesh = rectangle(&line(0), &line(1), Diagonals::Alternating)?;
    mesh.name_boundary("left half", |x| {
        x[1] == low[1] + size[1] && x[0] <= low[0] + 0.5 * size[0]
    });
    Ok(mesh)
}

/// A block slides onto a part of the floor that is not declared, and sinks in.
fn undeclared() -> Case {
    let scene = || -> Result<Scene<2>, Failure> {
        let law = NeoHookean::new(1e3, 0.3)?;
        let mut floor = Body::new(block([0.0, -1.0], [4.0, 1.0], [8, 2])?, law);
        floor.prescribe("bottom", [Some(0.0); 2])?;
        let mut upper = Body::new(block([0.5, 0.02], [1.0, 1.0], [3, 3])?, law);
        upper.prescribe("top", [Some(2.2), Some(-0.4)])?;
        Ok(crate::pair((floor, "left half"), (upper, "bottom"))?)
    };
    let truth = Truth::Refused(&["declare"]);
    Case::plane(
        "onto an undeclared surface".into(),
        "undeclared",
        scene,
        truth,
    )
    .increments(10)
    .quick()
}

/// A linear block pressed by one and a half of its height.
fn strained() -> Case {
    let scene = || -> Result<Scene<2>, Failure> {
        let mut block = Body::new(
            block([0.0; 2], [1.0; 2], [4, 4])?,
            LinearElastic::new(1e3, 0.3)?,
        );
        block.prescribe("bottom", [Some(0.0); 2])?;
        block.prescribe("top", [Some(0.0), Some(-1.5)])?;
        Ok(crate::alone(block))
    };
    let truth = Truth::Refused(&["certificate"]);
    Case::plane(
        "linear block pressed through itself".into(),
        "linear law",
        scene,
        truth,
    )
    .quick()
}

/// A linear cantilever whose tip moves by many lengths.
fn bent() -> Case {
    let scene = || -> Result<Scene<2>, Failure> {
        let mut beam = Body::new(
            block([0.0; 2], [8.0, 1.0], [16, 2])?,
            LinearElastic::new(1e3, 0.3)?,
        );
        beam.prescribe("left", [Some(0.0); 2])?;
        beam.traction("top", [0.0, -10.0])?;
        Ok(crate::alone(beam))
    };
    let truth = Truth::Refused(&["certificate"]);
    Case::plane(
        "linear cantilever bent by many lengths".into(),
        "linear law",
        scene,
        truth,
    )
    .quick()
}

/// A linear block is carried into another without declared contact.
fn carried() -> Case {
    let scene = || -> Result<Scene<2>, Failure> {
        let law = LinearElastic::new(1e3, 0.3)?;
        let mut wall = Body::new(block([3.0, 0.0], [1.0; 2], [4, 4])?, law);
        wall.prescribe("bottom", [Some(0.0); 2])?;
        let mut cart = Body::new(block([0.0; 2], [1.0; 2], [4, 4])?, law);
        cart.prescribe("bottom", [Some(2.5), Some(0.0)])?;
        Ok(Scene::of(vec![wall, cart]))
    };
    let truth = Truth::Refused(&["certificate"]);
    Case::plane(
        "linear block carried into another".into(),
        "linear law",
        scene,
        truth,
    )
    .quick()
}

/// A body that nothing holds.
fn unheld() -> Case {
    let scene = || -> Result<Scene<2>, Failure> {
        let law = NeoHookean::new(1e3, 0.3)?;
        let mut floor = Body::new(block([0.0, -1.0], [4.0, 1.0], [8, 2])?, law);
        floor.prescribe("bottom", [Some(0.0); 2])?;
        let mut free = Body::new(block([1.0, 3.0], [1.0; 2], [2, 2])?, law);
        free.body_force([1.0, 0.0])?;
        Ok(Scene::of(vec![floor, free]))
    };
    let truth = Truth::Refused(&["rigidly"]);
    Case::plane("a body that nothing holds".into(), "unheld", scene, truth).quick()
}

/// Bodies that start inside each other by a share of their size.
fn overlapping(depth: f64, press: f64) -> Case {
    let scene = move || -> Result<Scene<2>, Failure> {
        let law = NeoHookean::new(1e3, 0.3)?;
        let mut lower = Body::new(block([0.0, -1.0], [1.0; 2], [20, 20])?, law);
        lower.prescribe("bottom", [Some(0.0); 2])?;
        let mut upper = Body::new(block([0.0, -depth], [1.0; 2], [20, 20])?, law);
        upper.prescribe("top", [Some(0.0), Some(-press)])?;
        Ok(crate::pair((lower, "top"), (upper, "bottom"))?)
    };
    let truth = match depth > 0.01 {
        true => Truth::Refused(&["inside"]),
        // within the tolerance for overlaps, which presses the bodies apart
        false => Truth::Values(Box::new(|_, history| {
            let last = history.last();
            let [lower, upper] = [0, 1].map(|k| last.map_or(f64::NAN, |step| step.reactions[k][1]));
            vec![crate::extremes::Check::relative(
                "force", lower, -upper, 1e-6,
            )]
        })),
    };
    Case::plane(
        format!("bodies that start inside each other by {depth:e}"),
        "initial overlap",
        scene,
        truth,
    )
    .quick()
}
