//! A neo-Hookean block under a rigid plate.

use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::material::{Deformation, Material};
use ipopt_contact::contact_fem::tensor::{Matrix, Vector};
use ipopt_contact::prelude::*;

use super::{Bound, Claim, Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points, Variant};
use crate::measure::Solved;
use crate::norms;
use crate::record::Measured;
use ipopt_contact_scenes::pair;

const NAME: &str = "block";
/// Young's modulus (UF/UL²) and Poisson's ratio.
const MODULI: [f64; 2] = [1000.0, 0.3];
/// How far the plate goes down (UL); the block is one high.
const PRESSED: f64 = 0.3;
/// In so many increments.
const INCREMENTS: usize = 3;

/// The homogeneous state: F = diag(stretch, 1 − PRESSED) with P₁₁ = 0.
struct Homogeneous {
    F: Matrix<2>,
    /// The pressure on the reference area, −P₂₂ (UF/UL²).
    pressure: f64,
}

impl Homogeneous {
    /// By bisection on P₁₁, which grows with the stretch.
    fn new() -> Result<Self, Error> {
        let law = NeoHookean::new(MODULI[0], MODULI[1])?;
        let F = |stretch: f64| Matrix::<2>::new(stretch, 0.0, 0.0, 1.0 - PRESSED);
        let (mut low, mut high) = (1.0, 2.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            match law.stress(&Deformation::new(F(middle)))[(0, 0)] < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        Ok(Homogeneous {
            F: F(low),
            pressure: -law.stress(&Deformation::new(F(low)))[(1, 1)],
        })
    }

    fn displacement(&self, X: &Vector<2>) -> (Vector<2>, Matrix<2>) {
        let gradient = self.F - Matrix::identity();
        (gradient * X, gradient)
    }
}

/// The block (0, 1)² slides on its left and bottom sides; the plate overhangs.
fn scene(case: &Case) -> Result<Scene<2>, Error> {
    let n = case.level;
    let grid = linspace(0.0, 1.0, n);
    let mut mesh = rectangle(&grid, &grid, Diagonals::Rising)?;
    if case.degree == 2 {
        mesh = mesh.quadratic();
    }
    let mut block = Body::new(mesh, NeoHookean::new(MODULI[0], MODULI[1])?);
    block.prescribe("left", [Some(0.0), None])?;
    block.prescribe("bottom", [None, Some(0.0)])?;
    let xs = linspace(-0.5, 2.0, 2 * n + n.div_ceil(2) + 1);
    let plate = rectangle(&xs, &[1.0, 1.25], Diagonals::Rising)?;
    let mut plate = Body::new(plate, NeoHookean::new(MODULI[0], MODULI[1])?);
    plate.prescribe_all([Some(0.0), Some(-PRESSED)])?;
    pair((block, "top"), (plate, "bottom"))
}

fn run(case: &Case) -> Result<Measured, Failure> {
    let solved = Solved::new(case, INCREMENTS, || scene(case))?;
    let mut measured = solved.measured(1.0 / case.level as f64);
    if solved.solution().is_none() {
        return Ok(measured);
    }
    let exact = Homogeneous::new()?;
    let field = |_: usize, X: &Vector<2>| Some(exact.displacement(X));
    let u = solved.displacements();
    let [l2, h1] = norms::of_displacement(&solved.problem, &u, &[0], field);
    let surfaces = solved.problem.surfaces().iter().zip(solved.pressures()?);
    for (surface, nodal) in surfaces.filter(|(surface, _)| surface.body() == 0) {
        // on the current area, which has grown by the stretch along the plate
        let error = norms::of_pressure(surface, &nodal, |_| exact.pressure / exact.F[(0, 0)]);
        measured.errors.insert("pressure".into(), error);
    }
    let step = solved.history.steps.last().ok_or("no step")?;
    // on the top, one unit of length
    let force = (step.reactions[0][1] / exact.pressure - 1.0).abs();
    let errors = [
        ("l2".into(), l2),
        ("h1".into(), h1),
        ("force".into(), force),
    ];
    measured.errors.extend(errors);
    Ok(measured)
}

const QUANTITIES: &[Quantity] = &[
    Quantity::new("pressure", "pressure, L²", Kind::Pressure),
    Quantity::new("force", "force on the plate", Kind::Force),
    Quantity::new("h1", "displacement, H¹", Kind::Gradient),
    Quantity::new("l2", "displacement, L²", Kind::Displacement),
];

fn cases(scope: Scope) -> Vec<Case> {
    let levels: &[usize] = scope.pick(&[4, 8, 16], &[4, 8, 16, 32, 64]);
    let mut cases = ladder(NAME, levels, levels);
    let exact = ladder(NAME, levels, levels).into_iter();
    cases.extend(exact.map(|case| case.with_points(Points::Exact)));
    for degree in [1, 2] {
        let case = || Case::new(NAME, degree, 8);
        for method in [Formulation::PenalizedSlack, Formulation::Penalty] {
            cases.push(case().with_method(method));
        }
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
            for variant in [Variant::Plain, Variant::Anderson] {
                cases.push(Case {
                    tolerance,
                    variant,
                    ..case()
                });
            }
        }
    }
    cases
}

/// In the plane.
pub fn family() -> Family {
    Family {
        name: NAME,
        title: "Neo-Hookean block, pressed",
        about: "A neo-Hookean block (E = 1000, ν = 0.3) is pressed by 30 % of its height under a rigid plate, and \
            spreads below it. Mesh, order, integration, method, fixed-point variant and TOLER vary; three increments.",
        reference: "Homogeneous: F = diag(stretch, 0.7) with the stretch for which the lateral stress vanishes, by \
            bisection on the law's own stress.",
        theory: "No error of approximation, as in the patch test, but through large strains: what is left is that of \
            integration, of TOLER and of gap times force. Curves need not fall.",
        causes: "Penalties stop at a finite μ, which leaves an error that no finer mesh takes away. What (7) leaves of gap times \
            force is its error: surfaces are flat, so that TOLER and acceleration change no more than that.",
        size: "1/n, the block's edge over its cells",
        quantities: QUANTITIES,
        // constant, so exact up to what Ipopt leaves
        claims: &[
            Claim {
                quantity: "pressure",
                degree: 1,
                bound: Bound::Finest(1e-5),
            },
            Claim {
                quantity: "pressure",
                degree: 2,
                bound: Bound::Finest(1e-5),
            },
        ],
        cases,
        refined: None,
        run: |case, _| run(case),
    }
}

#[cfg(test)]
mod tests {
    use ipopt_contact::contact_fem::material::Lame;

    use super::*;

    /// P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ by components, from the formula.
    #[test]
    fn the_state_is_in_equilibrium() {
        let Lame { lambda, mu } = Lame::new(MODULI[0], MODULI[1]).expect("moduli");
        let state = Homogeneous::new().expect("a state");
        let [a, b] = [state.F[(0, 0)], state.F[(1, 1)]];
        let P = |f: f64| mu * (f - 1.0 / f) + lambda * (a * b).ln() / f;
        assert!(P(a).abs() < 1e-10 && a > 1.0 && b == 0.7, "{a} {b}");
        assert!((P(b) + state.pressure).abs() < 1e-10 && state.pressure > 0.0);
    }
}
