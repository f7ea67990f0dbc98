//! The work of supports, and the energy that bodies store of it.

use ipopt_contact::contact_fem::StepRecord;

use super::{Bound, Claim, Family, Kind, Quantity, Scope};
use crate::Failure;
use crate::case::{Case, Formulation};
use crate::measure::Solved;
use crate::record::Measured;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::sliding_disc;

const DISCS: &str = "work-discs";
const SLIDING: &str = "work-sliding";
/// The families' own meshes: segments of the hole, and cells of the floor's height.
const SEGMENTS: usize = 48;
const CELLS: usize = 12;
/// The way of the disc along the floor (UL).
const ALONG: f64 = 1.5;

fn run(case: &Case) -> Result<Measured, Failure> {
    let solved = Solved::new(case, case.level, || match case.family == DISCS {
        true => {
            let fineness = Fineness::scaled(case.mesh.unwrap_or(SEGMENTS));
            disc_in_disc::scene(fineness, Roles::default())
        }
        false => sliding_disc::scene(case.mesh.unwrap_or(CELLS), ALONG),
    })?;
    let mut measured = solved.measured(1.0 / case.level as f64);
    if let (Some(_), Some(step)) = (solved.solution(), solved.history.steps.last()) {
        let (work, stored) = (StepRecord::work(step), step.stored_energy);
        measured
            .errors
            .insert("leak".into(), (work / stored - 1.0).abs());
        measured.values.insert("leak".into(), work / stored - 1.0);
        // the refined run is one on the family's own mesh
        if case.mesh.is_none() {
            measured.values.insert("work".into(), work);
        }
    }
    Ok(measured)
}

const QUANTITIES: &[Quantity] = &[
    Quantity::new("leak", "work that is not stored", Kind::Other),
    Quantity::new("work", "work, against many increments", Kind::Other)
        .against_refined("work")
        .of_orders(2.0, 2.0),
];

/// By increments: the own mesh by (7), and all meshes by the default solver.
fn cases(family: &str, scope: Scope) -> Vec<Case> {
    let levels: &[usize] = scope.pick(&[10, 20, 40], &[10, 20, 40, 80, 160]);
    let meshes: &[usize] = match family == DISCS {
        true => scope.pick(&[24], &[24, 96]),
        false => scope.pick(&[6], &[6, 12, 24]),
    };
    let own = levels.iter().map(|level| Case::new(family, 1, *level));
    let by_default = |case: Case| case.with_method(Formulation::Automatic);
    let mut cases: Vec<Case> = own.clone().collect();
    cases.extend(own.clone().map(by_default));
    for mesh in meshes {
        let on = |case: Case| Case {
            mesh: Some(*mesh),
            ..by_default(case)
        };
        cases.extend(own.clone().map(on));
    }
    cases
}

fn refined(family: &str, scope: Scope) -> Case {
    Case::new(family, 1, scope.pick(160, 640)).with_method(Formulation::Automatic)
}

const CLAIMS: &[Claim] = &[
    Claim {
        quantity: "leak",
        degree: 1,
        bound: Bound::Finest(1e-2),
    },
    Claim {
        quantity: "work",
        degree: 1,
        bound: Bound::Order(1.5),
    },
];

/// In the plane: two scenes with much sliding.
pub fn families() -> [Family; 2] {
    let discs = Family {
        name: DISCS,
        title: "Work and stored energy, disc-in-disc",
        about: "Without friction, bodies store the work of supports and loads. The disc-in-disc on several meshes (segments of the \
            hole), in more and more increments, which the level counts: the work that the stored energy lacks or exceeds, \
            over the stored energy, and the work against that of many increments.",
        reference: "Work is the sum over the increments of reactions times displacements by the trapezoidal rule; the energy \
            is that of the last state. The reference of the work is the family's own mesh in four times as many increments.",
        theory: "The trapezoidal rule's error is of order 2 in the increment. What is left then is the mesh's: contact forces act along \
            averaged normals at the state itself, which differ from the gradient of the gaps there by how much the polygons turn \
            at their corners.",
        causes: "Both have signs of their own, so that the leak may pass through zero between two numbers of increments and \
            levels off at the mesh's part.",
        size: "the increment, over the whole load",
        quantities: QUANTITIES,
        claims: CLAIMS,
        cases: |scope| cases(DISCS, scope),
        refined: Some(|scope| refined(DISCS, scope)),
        run: |case, _| run(case),
    };
    let sliding = Family {
        name: SLIDING,
        title: "Work and stored energy, a disc along a block",
        about: "As before: a neo-Hookean disc is pressed on a block of the same law by 0.15 and moved along it by 1.5, \
            three times its radius, on several meshes (cells of the block's height).",
        cases: |scope| cases(SLIDING, scope),
        refined: Some(|scope| refined(SLIDING, scope)),
        ..discs
    };
    [discs, sliding]
}
