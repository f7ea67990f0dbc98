//! Hertz's contact of a cylinder on a block, in plane strain.

use ipopt_contact::contact_core::equilibrium::Solution;
use ipopt_contact::contact_fem::tensor::Vector;

use super::{Bound, Claim, Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points};
use crate::exact::{HalfPlanes, Pair};
use crate::measure::Solved;
use crate::norms;
use crate::record::Measured;
use crate::refined::{Place, Refined};
use ipopt_contact_scenes::hertz::{Fineness, Hertz, RADIUS};

const NAME: &str = "hertz-2d";
const PUBLISHED: &str = "hertz-2d-published";

/// The share of the published load that is small enough for Hertz's theory.
const SMALL: f64 = 1.0 / 64.0;

/// The published case, or a small load on meshes that grow more slowly from its smaller contact.
fn hertz(case: &Case) -> Hertz {
    let published = Hertz::new(Fineness::family(case.level), case.order());
    match case.family == PUBLISHED {
        true => published,
        false => Hertz {
            force: SMALL * published.force,
            fineness: published.fineness.map(|fineness| Fineness {
                on_arc: 4 * case.level,
                ..fineness
            }),
            ..published
        },
    }
}

fn run(case: &Case, place: &Place) -> Result<Measured, Failure> {
    let hertz = hertz(case);
    let solved = Solved::new(case, 1, || hertz.scene())?;
    let mut measured = solved.measured(hertz.facets()[0]);
    let Some(solution) = solved.solution() else {
        return Ok(measured);
    };
    let reference = half_planes(&hertz);
    let contact = Contact::new(&reference, &solved, solution)?;
    measured.errors.extend(contact.errors(&hertz, &reference));
    measured.values.extend(contact.values(&hertz, &reference));
    let u = solved.displacements();
    let energy = solved.history.steps.last().map(|step| step.energy);
    let energy = energy.map(|energy| ("energy".to_string(), energy));
    measured.values.extend(energy);
    if place.is_refined {
        place.save(case, &u)?;
        return Ok(measured);
    }
    let kept = place.load()?;
    // quadratic meshes half as fine as the refined one at most, whose own error would else count
    if case.degree * case.level <= kept.case.level {
        let refined = Refined::new(self::hertz(&kept.case).scene()?, &kept)?;
        let exact = |body: usize, X: &_| refined.at(body, X);
        let [l2, h1] = norms::of_displacement(&solved.problem, &u, &[0, 1], exact);
        let near = |body: usize, X: &Vector<2>| match X.norm() < NEAR * hertz.half_width() {
            true => exact(body, X),
            false => None,
        };
        let [_, h1_near] = norms::of_displacement(&solved.problem, &u, &[0, 1], near);
        let errors = [("l2", l2), ("h1", h1), ("h1, near", h1_near)];
        let errors = errors.map(|(name, error)| (name.to_string(), error));
        measured.errors.extend(errors);
    }
    Ok(measured)
}

/// The neighbourhood of the contact in which an error is taken by itself, in half-widths from the centre.
const NEAR: f64 = 4.0;

/// The same contact without Hertz's parabola and vertical normals.
fn half_planes(hertz: &Hertz) -> HalfPlanes {
    HalfPlanes::new(&Pair {
        radius: RADIUS,
        force: hertz.force,
        modulus: hertz.contact_modulus(),
        mismatch: hertz.mismatch(),
    })
}

/// What theory speaks of, on the surfaces of cylinder and block.
struct Contact {
    /// The peak of the reference's profile when it carries the same force within 0.6 a, and the pressure at the
    /// central node (UF/UL²).
    peak: [f64; 2],
    node: [f64; 2],
    /// The peak of the recovered pressure, likewise.
    recovered: [f64; 2],
    /// The half-width (UL), of the second moment of the nodal forces: a²/4 for a half-ellipse.
    half_width: [f64; 2],
    /// The relative error of the pressure in L².
    profile: [f64; 2],
}

impl Contact {
    fn new(
        reference: &HalfPlanes,
        solved: &Solved<2>,
        solution: &Solution,
    ) -> Result<Self, Failure> {
        let problem = &solved.problem;
        let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
        let (p0, a) = (reference.peak(), reference.half_width());
        let mut contact = Contact {
            peak: [0.0; 2],
            node: [0.0; 2],
            recovered: [0.0; 2],
            half_width: [0.0; 2],
            profile: [0.0; 2],
        };
        let fields = solved
            .pressures()?
            .into_iter()
            .zip(solved.consistent_pressures()?);
        for (surface, (pressure, consistent)) in problem.surfaces().iter().zip(fields) {
            let x = |&node: &usize| problem.reference()[node][0];
            let body = surface.body();
            let mut nodes = surface.nodes().iter().zip(&consistent);
            let centre = nodes.find(|(node, _)| x(node).abs() < 1e-9 * a);
            let (_, node) = centre.ok_or("no node in the centre of contact")?;
            let exact = |X: &Vector<2>| reference.pressure(X[0]);
            let shape = |X: &Vector<2>| exact(X) / p0;
            let moment = |power: i32| -> f64 {
                let nodes = surface.nodes().iter();
                nodes
                    .map(|node| forces[*node][1] * x(node).powi(power))
                    .sum()
            };
            contact.node[body] = *node;
            contact.peak[body] = norms::amplitude(surface, &consistent, shape, |X| X[0] <= 0.6 * a);
            contact.recovered[body] =
                norms::amplitude(surface, &pressure, shape, |X| X[0] <= 0.6 * a);
            contact.half_width[body] = 2.0 * (moment(2) / moment(0)).sqrt();
            contact.profile[body] = norms::of_pressure(surface, &pressure, exact);
        }
        Ok(contact)
    }

    /// Of the two surfaces the worse.
    fn errors(&self, hertz: &Hertz, reference: &HalfPlanes) -> [(String, f64); 7] {
        let worse = |values: [f64; 2], exact: f64| {
            let [a, b] = values.map(|value| (value / exact - 1.0).abs());
            a.max(b)
        };
        let [a, b] = self.profile;
        let (peak, width) = (reference.peak(), reference.half_width());
        [
            ("p0", worse(self.peak, peak)),
            ("p0, node", worse(self.node, peak)),
            ("p0, recovered", worse(self.recovered, peak)),
            ("a", worse(self.half_width, width)),
            ("pressure", a.max(b)),
            ("p0, hertz", worse(self.peak, hertz.peak_pressure())),
            ("a, hertz", worse(self.half_width, hertz.half_width())),
        ]
        .map(|(name, error)| (name.to_string(), error))
    }

    fn values(&self, hertz: &Hertz, reference: &HalfPlanes) -> [(String, f64); 10] {
        [
            ("p0 at the node, cylinder", self.node[0]),
            ("p0 at the node, block", self.node[1]),
            ("p0, cylinder", self.peak[0]),
            ("p0, block", self.peak[1]),
            ("a, cylinder", self.half_width[0]),
            ("a, block", self.half_width[1]),
            ("p0, half-planes", reference.peak()),
            ("a, half-planes", reference.half_width()),
            ("p0, hertz", hertz.peak_pressure()),
            ("a, hertz", hertz.half_width()),
        ]
        .map(|(name, value)| (name.to_string(), value))
    }
}

const QUANTITIES: &[Quantity] = &[
    Quantity::new("p0", "peak of the consistent pressure", Kind::Pressure),
    Quantity::new(
        "p0, recovered",
        "peak of the recovered pressure",
        Kind::Other,
    ),
    Quantity::new("pressure", "pressure, L²", Kind::Pressure).of_orders(1.0, 1.0),
    Quantity::new("a", "half-width, a", Kind::Other),
    Quantity::new(
        "p0, node",
        "consistent pressure at the central node",
        Kind::Other,
    ),
    Quantity::new("h1", "displacement, H¹", Kind::Gradient).of_orders(1.0, 1.5),
    Quantity::new("h1, near", "displacement within 4 a, H¹", Kind::Other).of_orders(1.0, 1.5),
    Quantity::new("l2", "displacement, L²", Kind::Displacement).of_orders(2.0, 2.5),
    Quantity::new("energy", "energy", Kind::Other).against_refined("energy"),
    Quantity::new("p0, hertz", "peak pressure against Hertz's", Kind::Other),
    Quantity::new("a, hertz", "half-width against Hertz's", Kind::Other),
];

fn cases(scope: Scope) -> Vec<Case> {
    let (p1, p2): (&[usize], &[usize]) = scope.pick(
        (&[4, 8, 16], &[3, 5, 10]),
        (&[4, 8, 16, 32], &[4, 6, 10, 20]),
    );
    let mut cases = ladder(NAME, p1, p2);
    let exact = ladder(NAME, p1, p2).into_iter();
    cases.extend(exact.map(|case| case.with_points(Points::Exact)));
    let default = ladder(NAME, p1, p2).into_iter();
    cases.extend(default.map(|case| case.with_method(Formulation::Automatic)));
    let methods: &[Formulation] =
        scope.pick(&[], &[Formulation::PenalizedSlack, Formulation::Penalty]);
    // on coarse meshes: they take hundreds of iterations
    for (degree, level) in [(1, 8), (2, 4)] {
        let case = || Case::new(NAME, degree, level);
        cases.extend(methods.iter().map(|&method| case().with_method(method)));
    }
    let tolerances: &[f64] = scope.pick(&[1e-1, 1e-4], &[1e-1, 1e-2, 1e-4, 1e-6, 1e-10]);
    for (degree, level) in [(1, 16), (2, 10)] {
        cases.extend(tolerances.iter().map(|&complementarity| Case {
            complementarity,
            ..Case::new(NAME, degree, level)
        }));
    }
    cases
}

/// The published case, with default settings alone.
fn published_cases(scope: Scope) -> Vec<Case> {
    let (p1, p2): (&[usize], &[usize]) = scope.pick(
        (&[4, 8, 16], &[3, 6, 12]),
        (&[4, 8, 16, 32, 64], &[4, 8, 16, 32]),
    );
    ladder(PUBLISHED, p1, p2)
}

const ABOUT: &str = "A half-cylinder of radius 50 (E = 210) on a block (E = 70), ν = 0.3, pressed by 7/64 a unit of \
    thickness; their right halves, on meshes graded towards the contact. Mesh, order, integration, method and what Ipopt \
    may leave of gap times force vary. Peak pressure p₀, of the reference's profile that carries the same force over the \
    facets within 0.6 a; the pressure at the central node for comparison; half-width a = 2 √(Σ f x² / Σ f) of the nodal \
    forces f; pressure in L²; displacement, everywhere and within 4 a of the centre; energy. Of the two bodies the larger \
    error.";
const REFERENCE: &str = "Two half-planes with the true circle, whose gaps and forces are along the circle's normals, as \
    those of the small-strain scene are where the block's nodes are held off the cylinder: an integral equation in one \
    unknown, solved by a series of Chebyshev polynomials to the order of (a/R)², without a mesh. Hertz's p₀ = √(P \
    E*/(πR)) and a = √(4PR/(πE*)) have a parabola and vertical normals and are compared with by themselves. The \
    displacement is compared with that of the finest quadratic mesh, computed by this command (P2, Gauss points, method \
    (7)) and interpolated, quadratic meshes being at most half as fine; energies are, too.";
const THEORY: &str = "u is in H^s for s < 5/2, as at every end of a contact zone: order 1 (P1) and 3/2 (P2) in H¹ on \
    uniform meshes, and no order beyond 1 of the pressure in L², whose profile is a square root at its end. These \
    meshes are graded and halved as a whole; the end of the zone is elsewhere in its facet on each of them, for which \
    pressures scatter. Surfaces shorten where they are pressed, by (1 + ν)(1 − 2ν) p/E, the softer one more; along \
    inclined normals that closes gaps. To first order in η = p₀ times the difference of (1 + ν)(1 − 2ν)/E, Hertz's a \
    grows by 4η/(3π) and p₀ falls by 0.477 η: both errors of Hertz's theory go with the square root of the load. Bodies \
    that end, and a clamped base, are left out of both theories.";

const CAUSES: &str = "The end of the zone lies elsewhere in its facet on each mesh: p₀, a and the pressure go up and down \
    with that, around a falling trend, so that their orders mean little on so few meshes. Errors against Hertz's own p₀ \
    and a level off at the difference of the two theories. Where quadratic elements fall short of order 3/2 in H¹, compare \
    the order within 4 a of the centre: the clamped corners of the block and the coarse cells around are what it gains. \
    The rest is the contact's, most on meshes where a is off; in the manufactured problem, where the zone ends at the same \
    place of its facet on all meshes, quadratic elements do have that order.";

/// In the plane: with a small load, and the published case.
pub fn families() -> [Family; 2] {
    let small = Family {
        name: NAME,
        title: "Hertz, cylinder on a block, plane strain",
        about: ABOUT,
        reference: REFERENCE,
        theory: THEORY,
        causes: CAUSES,
        size: "the facet in the centre of contact",
        quantities: QUANTITIES,
        claims: CLAIMS,
        cases,
        refined: Some(|scope| Case::new(NAME, 2, scope.pick(20, 40))),
        run,
    };
    let published = Family {
        name: PUBLISHED,
        title: "Hertz, the published load",
        about: "As before with the published load of 7, for which Hertz's theory says p₀ = 1.6034 and a = 2.779, and \
            default settings. Errors against Hertz's own are larger than with the small load.",
        claims: CLAIMS,
        cases: published_cases,
        refined: Some(|scope| Case::new(PUBLISHED, 2, scope.pick(20, 40))),
        ..small
    };
    [small, published]
}

const CLAIMS: &[Claim] = &[
    Claim {
        quantity: "p0",
        degree: 2,
        bound: Bound::Finest(1e-3),
    },
    Claim {
        quantity: "a",
        degree: 2,
        bound: Bound::Finest(1e-2),
    },
    Claim {
        quantity: "h1",
        degree: 1,
        bound: Bound::Order(0.95),
    },
    Claim {
        quantity: "pressure",
        degree: 1,
        bound: Bound::Order(0.75),
    },
    // orders of quadratic elements follow where the zone ends in its facet
    Claim {
        quantity: "pressure",
        degree: 2,
        bound: Bound::Order(0.7),
    },
    Claim {
        quantity: "pressure",
        degree: 2,
        bound: Bound::Finest(0.025),
    },
    Claim {
        quantity: "p0, recovered",
        degree: 2,
        bound: Bound::Finest(5e-3),
    },
];
