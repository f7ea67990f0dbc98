//! The disc-in-disc of section 6.1.

use super::{Family, Kind, Quantity, Scope};
use crate::Failure;
use crate::case::{Case, Formulation, Points, Variant};
use crate::measure::Solved;
use crate::record::Measured;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};

const NAME: &str = "disc-in-disc";
/// Load increments, on every mesh the same.
const INCREMENTS: usize = 20;

fn run(case: &Case) -> Result<Measured, Failure> {
    let fineness = Fineness::scaled(case.level);
    let solved = Solved::new(case, INCREMENTS, || {
        disc_in_disc::scene(fineness, Roles::default())
    })?;
    // facets of the hole
    let h = std::f64::consts::TAU * 0.7 / case.level as f64;
    let mut measured = solved.measured(h);
    if let (Some(_), Some(step)) = (solved.solution(), solved.history.steps.last()) {
        let reaction = step.reactions[0][1];
        let values = [
            ("energy".into(), step.energy),
            ("reaction".into(), reaction),
        ];
        measured.values.extend(values);
    }
    Ok(measured)
}

const QUANTITIES: &[Quantity] = &[
    Quantity::new("energy", "energy", Kind::Other).against_refined("energy"),
    Quantity::new("reaction", "reaction of the support", Kind::Force).against_refined("reaction"),
];

fn cases(scope: Scope) -> Vec<Case> {
    let levels: &[usize] = scope.pick(&[16, 24, 32], &[16, 24, 32, 48, 64, 96, 128]);
    let at = |level: &usize| Case::new(NAME, 1, *level);
    let mut cases: Vec<Case> = levels.iter().map(at).collect();
    cases.extend(levels.iter().map(|k| at(k).with_points(Points::Exact)));
    let plain = |case: Case| Case {
        variant: Variant::Plain,
        ..case
    };
    // further ones take long to find out that the plain iteration does not converge
    let coarse = &levels[..scope.pick(2, 4)];
    cases.extend(coarse.iter().map(|k| plain(at(k))));
    let middle = scope.pick(24, 32);
    for method in [Formulation::PenalizedSlack, Formulation::Penalty] {
        cases.push(at(&middle).with_method(method));
    }
    cases.extend(
        levels
            .iter()
            .map(|k| at(k).with_method(Formulation::Automatic)),
    );
    let tolerances: &[f64] = scope.pick(&[1e-2, 1e-4], &[1e-2, 1e-3, 1e-4, 1e-8]);
    for &tolerance in tolerances {
        let case = Case {
            tolerance,
            ..at(&middle)
        };
        cases.extend([case.clone(), plain(case)]);
    }
    cases
}

/// In the plane.
pub fn family() -> Family {
    Family {
        name: NAME,
        title: "Disc-in-disc",
        about: "Section 6.1 of the paper: a disc is pushed by 1.125 through the ring around it, neo-Hookean, linear \
            elements, in 20 increments. Mesh, integration, method, fixed-point variant and TOLER vary.",
        reference: "The same scene on the finest mesh, computed by this command with method (7), Anderson \
            acceleration and Gauss points, in the same 20 increments, so that errors are those of the mesh alone.",
        theory: "The energy of linear elements is of order 2 where the solution is smooth; here two polygons slide \
            on each other, whose gaps are of order 2, too, and come and go with how their corners meet: curves are \
            not smooth.",
        causes: "Plain iterations, as in the paper, may fall into cycles or crawl where integration points change facets, and no \
            TOLER below the amplitude helps; halving the load step often enough does not either. Coarse polygons \
            overestimate the energy, out of any asymptotic range.",
        size: "the facet of the hole",
        quantities: QUANTITIES,
        claims: &[],
        cases,
        refined: Some(|scope| Case::new(NAME, 1, scope.pick(64, 256))),
        run: |case, _| run(case),
    }
}
