//! The contact patch test.

use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::prelude::*;

use super::{Bound, Claim, Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points};
use crate::measure::Solved;
use crate::norms;
use crate::record::Measured;
use ipopt_contact_scenes::blocks::{Blocks, deviation, exact};

fn run<const D: usize>(
    case: &Case,
    scene: impl FnOnce() -> Result<Scene<D>, Error>,
) -> Result<Measured, Failure>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let solved = Solved::new(case, 1, scene)?;
    let mut measured = solved.measured(1.0 / case.level as f64);
    if solved.solution().is_some() {
        let [stress, moved] = deviation(&solved.problem, &solved.displacements());
        let (_, exact) = exact(&solved.problem);
        let surfaces = solved.problem.surfaces().iter().zip(solved.pressures()?);
        let pressure =
            surfaces.map(|(surface, p)| norms::of_pressure(surface, &p, |_| exact.norm()));
        let errors = [
            ("stress".into(), stress),
            ("pressure".into(), pressure.fold(0.0, f64::max)),
            ("displacement".into(), moved),
        ];
        measured.errors.extend(errors);
    }
    Ok(measured)
}

/// n cells on the edge of the lower block, about twice as many on the upper one's.
fn blocks(case: &Case) -> Blocks {
    let n = case.level;
    let integration = case.integration().unwrap_or_else(|| {
        let points = if case.degree == 1 { 4 } else { 12 };
        Integration::Gauss(points)
    });
    Blocks::new([n, 2 * n + 1], case.order(), integration)
}

/// Gauss points and exact integration, with gap times force left as by default and at 1e-12.
const QUANTITIES: &[Quantity] = &[
    Quantity::new("stress", "stress, largest", Kind::Pressure),
    Quantity::new("pressure", "pressure, L²", Kind::Other),
    Quantity::new("displacement", "displacement, largest", Kind::Displacement),
];

// constant, and off by what the Gauss points of the constraints and Ipopt leave
const CLAIMS: &[Claim] = &[
    Claim {
        quantity: "pressure",
        degree: 1,
        bound: Bound::Finest(1e-3),
    },
    Claim {
        quantity: "pressure",
        degree: 2,
        bound: Bound::Finest(1e-3),
    },
];

fn cases(scope: Scope) -> Vec<Case> {
    let levels: &[usize] = scope.pick(&[4, 8, 16], &[4, 8, 16, 32]);
    let mut cases = Vec::new();
    for points in [Points::Gauss, Points::Exact] {
        for complementarity in [InteriorPoint::default().complementarity, 1e-12] {
            let ladder = ladder("patch", levels, levels).into_iter();
            cases.extend(ladder.map(|case| Case {
                points,
                complementarity,
                ..case
            }));
        }
    }
    for method in [Formulation::PenalizedSlack, Formulation::Penalty] {
        cases.push(Case::new("patch", 1, 8).with_method(method));
    }
    cases
}

/// In the plane.
pub fn family() -> Family {
    Family {
        name: "patch",
        title: "Contact patch test",
        about: "Two blocks without lateral contraction, on meshes of n and 2n + 1 cells an edge, one pressed on the \
            other. Mesh, order, integration, method and what Ipopt may leave of gap times force vary. The largest \
            error of a stress component in a cell and of a displacement of a node are measured, and of the contact pressure on \
            the two surfaces the larger error.",
        reference: "Exact: the stress is the same everywhere, and the elements contain that state.",
        theory: "No error of approximation: what is left is that of the constraints' integration, of what the \
            solver leaves of gap times force, and round-off. Curves need not fall.",
        causes: "Where there is nothing to approximate, curves show what the solver leaves. Both passes on quadratic meshes \
            depend on each other up to what one mesh resolves and the other does not, squared; round-off is that much \
            larger there.",
        size: "1/n, the edge over the lower block's cells",
        quantities: QUANTITIES,
        claims: CLAIMS,
        cases,
        refined: None,
        run: |case, _| run(case, || blocks(case).plane()),
    }
}
