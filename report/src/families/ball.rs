//! Hertz's contact of a ball on a rigid plane.

use ipopt_contact::contact_core::equilibrium::Solution;
use ipopt_contact::contact_fem::tensor::Vector;

use super::{Bound, Claim, Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points};
use crate::measure::Solved;
use crate::norms;
use crate::record::Measured;
use ipopt_contact_scenes::ball::{Ball, CONTACT_RADIUS};

const NAME: &str = "hertz-3d";

fn run(case: &Case) -> Result<Measured, Failure> {
    let ball = Ball {
        in_contact: case.level,
        order: case.order(),
    };
    let solved = Solved::new(case, 1, || ball.scene())?;
    let mut measured = solved.measured(ball.facet());
    if let Some(solution) = solved.solution() {
        add_errors(&solved, solution, &mut measured)?;
    }
    Ok(measured)
}

/// Of the ball's surface: the plane's is not elastic.
fn add_errors(
    solved: &Solved<3>,
    solution: &Solution,
    measured: &mut Measured,
) -> Result<(), Failure> {
    let problem = &solved.problem;
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let (p0, a) = (Ball::peak_pressure(), CONTACT_RADIUS);
    let profile = |r: f64| p0 * (1.0 - (r / a).powi(2)).max(0.0).sqrt();
    let fields = solved
        .pressures()?
        .into_iter()
        .zip(solved.consistent_pressures()?);
    let surfaces = problem.surfaces().iter().zip(fields);
    for (surface, (pressure, consistent)) in surfaces.filter(|(surface, _)| surface.body() == 0) {
        let r = |node: usize| problem.reference()[node].xy().norm();
        let mut nodes = surface.nodes().iter().zip(&consistent);
        let centre = nodes.find(|(node, _)| r(**node) < 1e-9 * a);
        let (_, node) = centre.ok_or("no node in the centre of contact")?;
        let shape = |X: &Vector<3>| profile(X.xy().norm()) / p0;
        let peak = norms::amplitude(surface, &consistent, shape, |X| X.xy().norm() <= 0.6 * a);
        let recovered = norms::amplitude(surface, &pressure, shape, |X| X.xy().norm() <= 0.6 * a);
        let moment = |power: i32| -> f64 {
            let nodes = surface.nodes().iter();
            nodes
                .map(|&node| forces[node][2] * r(node).powi(power))
                .sum()
        };
        let radius = (2.5 * moment(2) / moment(0)).sqrt();
        let pressure = norms::of_pressure(surface, &pressure, |X| profile(X.xy().norm()));
        let errors = [
            ("p0", (peak / p0 - 1.0).abs()),
            ("p0, recovered", (recovered / p0 - 1.0).abs()),
            ("p0, node", (node / p0 - 1.0).abs()),
            ("a", (radius / a - 1.0).abs()),
            ("pressure", pressure),
        ];
        let named = |(name, value): (&str, f64)| (name.to_string(), value);
        measured.errors.extend(errors.map(named));
        measured
            .values
            .extend([("p0", peak), ("p0, node", *node), ("a", radius)].map(named));
    }
    Ok(())
}

const QUANTITIES: &[Quantity] = &[
    Quantity::new("p0", "peak of the consistent pressure", Kind::Pressure),
    Quantity::new(
        "p0, recovered",
        "peak of the recovered pressure",
        Kind::Other,
    ),
    Quantity::new("pressure", "pressure, L²", Kind::Pressure).of_orders(1.0, 1.0),
    Quantity::new("a", "contact radius, a", Kind::Other),
    Quantity::new(
        "p0, node",
        "consistent pressure at the central node",
        Kind::Other,
    ),
];

fn cases(scope: Scope) -> Vec<Case> {
    let (p1, p2): (&[usize], &[usize]) =
        scope.pick((&[2, 3, 4], &[2, 3]), (&[2, 3, 4, 6, 8], &[2, 3, 4]));
    let mut cases = ladder(NAME, p1, p2);
    // the finest ones once are enough
    let exact = ladder(NAME, &p1[..p1.len() - 1], &p2[..p2.len() - 2]).into_iter();
    cases.extend(exact.map(|case| case.with_points(Points::Exact)));
    let others: &[(usize, usize)] = scope.pick(&[], &[(1, 2)]);
    for &(degree, level) in others {
        for method in [Formulation::PenalizedSlack, Formulation::Penalty] {
            cases.push(Case::new(NAME, degree, level).with_method(method));
        }
    }
    cases
}

/// In space.
pub fn family() -> Family {
    Family {
        name: NAME,
        title: "Hertz, ball on a plane",
        about: "An elastic ball of radius 50 (E = 210, ν = 0.3), cut to a square prism of side 60 and height 30, is \
            pressed on a rigid plane so that a = 2.5 by theory; a quarter of it, on a grid graded towards the \
            contact. Mesh, order, integration and method vary. Peak pressure p₀, of the Hertzian profile that carries the same force over \
            the facets within 0.6 a; the pressure at the central node for comparison; contact radius a = √(5/2 Σ \
            f r² / Σ f) of the nodal forces f, which is exact for Hertz's profile, and pressure in L².",
        reference: "a³ = 3FR/(4E*), p₀ = 3F/(2πa²) and p₀ √(1 − r²/a²): Hertz's theory of a half-space with a \
            parabolic surface, not of this body.",
        theory: "No order beyond 1 of the pressure in L², whose profile is a square root at its end. What Hertz's \
            theory leaves out is a floor.",
        causes: "Few facets are in contact, and each carries one or two facets' worth of error at the end of the zone. Single \
            nodes, the central one above all, alternate with how many triangles meet there; the force over many facets \
            does not. On the coarsest meshes no facet lies within 0.6 a, and there is no p₀.",
        size: "the facet in the centre of contact",
        quantities: QUANTITIES,
        claims: &[
            Claim {
                quantity: "p0",
                degree: 2,
                bound: Bound::Finest(1e-2),
            },
            Claim {
                quantity: "p0, recovered",
                degree: 2,
                bound: Bound::Finest(5e-2),
            },
            Claim {
                quantity: "pressure",
                degree: 1,
                bound: Bound::Order(0.8),
            },
            Claim {
                quantity: "pressure",
                degree: 2,
                bound: Bound::Finest(0.10),
            },
        ],
        cases,
        refined: None,
        run: |case, _| run(case),
    }
}
