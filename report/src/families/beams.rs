//! The three beams of section 6.2.

use super::{Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points};
use crate::measure::Solved;
use crate::record::Measured;
use ipopt_contact_scenes::beams::{self, Beams, Law, SIDE};

const NAME: &str = "three-beams";

fn run(case: &Case) -> Result<Measured, Failure> {
    let beams = Beams::new(case.level, case.order(), Law::SmallStrain);
    let solved = Solved::new(case, 1, || beams.scene())?;
    let mut measured = solved.measured(SIDE / case.level as f64);
    if solved.solution().is_none() {
        return Ok(measured);
    }
    let (problem, u) = (&solved.problem, solved.displacements());
    let tip = -beams::tip(problem, &u, 0)[2];
    let mut nodal = vec![0.0; u.len()];
    for (surface, pressure) in problem.surfaces().iter().zip(solved.pressures()?) {
        let own = surface.nodes().iter().zip(pressure);
        own.for_each(|(&node, p)| nodal[node] += p);
    }
    let [low, high] = [0, 1].map(|below| beams::mid_span_pressure(problem, &nodal, below));
    let step = solved.history.steps.last().ok_or("no step")?;
    let force = step.contact_forces[0][2];
    let values = [
        ("tip", tip),
        ("p, low", low),
        ("p, high", high),
        ("force", -force),
        ("energy", step.energy),
    ];
    measured
        .values
        .extend(values.map(|(name, value)| (name.to_string(), value)));
    let of_theory = [
        ("tip, beam theory", tip, TIP),
        ("p, beam theory", low, PRESSURE),
    ];
    let errors =
        of_theory.map(|(name, value, exact)| (name.to_string(), (value / exact - 1.0).abs()));
    measured.errors.extend(errors);
    Ok(measured)
}

/// The tip's deflection by Timoshenko's theory with a third of the load on each beam: q L⁴/(8 E I) + q L²/(2 κ G A)
/// with κ = 5/6 and G = E/2 (UL).
const TIP: f64 = {
    let q = beams::LOAD * SIDE / 3.0;
    let (L, E, area) = (beams::LENGTH, beams::YOUNG, SIDE * SIDE);
    let bending = q * L * L * L * L / (8.0 * E * area * area / 12.0);
    bending + q * L * L / (2.0 * 5.0 / 6.0 * 0.5 * E * area)
};
/// The pressure on the lowest beam, a third of the load (UF/UL²).
const PRESSURE: f64 = beams::LOAD / 3.0;

const QUANTITIES: &[Quantity] = &[
    Quantity::new("tip", "deflection of the tip", Kind::Displacement)
        .against_refined("tip")
        .of_orders(2.0, 3.0),
    Quantity::new(
        "p, low",
        "mid-span pressure on the lowest beam",
        Kind::Pressure,
    )
    .against_refined("p, low"),
    Quantity::new("force", "contact force on the lowest beam", Kind::Force)
        .against_refined("force"),
    Quantity::new("energy", "energy", Kind::Other).against_refined("energy"),
    Quantity::new("tip, beam theory", "tip against beam theory", Kind::Other),
    Quantity::new(
        "p, beam theory",
        "mid-span pressure against beam theory",
        Kind::Other,
    ),
];

fn cases(scope: Scope) -> Vec<Case> {
    let (p1, p2): (&[usize], &[usize]) =
        scope.pick((&[1, 2, 3], &[1, 2]), (&[1, 2, 3, 4, 6, 8], &[1, 2, 3, 4]));
    let mut cases = ladder(NAME, p1, p2);
    let exact = ladder(NAME, p1, p2).into_iter();
    cases.extend(exact.map(|case| case.with_points(Points::Exact)));
    let default = ladder(NAME, p1, p2).into_iter();
    cases.extend(default.map(|case| case.with_method(Formulation::Automatic)));
    let coarse = || [(1, 2), (2, 1)].into_iter();
    cases.extend(coarse().map(|(degree, level)| {
        Case::new(NAME, degree, level).with_method(Formulation::PenalizedSlack)
    }));
    // (39) takes hundreds of iterations on quadratic beams
    let few = coarse().take(scope.pick(1, 2));
    cases.extend(
        few.map(|(degree, level)| Case::new(NAME, degree, level).with_method(Formulation::Penalty)),
    );
    cases
}

/// In space.
pub fn family() -> Family {
    Family {
        name: NAME,
        title: "Three beams",
        about: "Section 6.2 of the paper in small strain: three cantilevers on top of each other, the top one \
            loaded. Cells are twice as long as high. Mesh, order, integration and method vary. The tip's deflection, \
            the pressure and the force on the lowest beam are measured.",
        reference: "The same scene on the finest quadratic mesh, computed by this command with method (7) and Gauss \
            points; and Timoshenko's beam theory with a third of the load on each beam: the tip comes down by q L⁴/(8 \
            E I) + q L²/(2 κ G A) = 25.92, the lowest pressure is 33.3.",
        theory: "Linear tetrahedra are far too stiff in bending, order 2 at best. At the clamped end's edges \
            stress is singular, which limits quadratic ones. Beam theory knows neither of these nor how pressure \
            varies near the ends: errors against it level off at its own.",
        causes: "Linear elements lock in bending; with 1 to 4 of them across a beam their orders are not yet those of fine \
            meshes. The force follows how few facets share the pressure near the clamped end.",
        size: "the side of a section over its cells",
        quantities: QUANTITIES,
        claims: &[],
        cases,
        refined: Some(|scope| Case::new(NAME, 2, scope.pick(3, 6))),
        run: |case, _| run(case),
    }
}
