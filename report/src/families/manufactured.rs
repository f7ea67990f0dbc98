//! Signorini problems whose solution is known: the loads are chosen so that it is one.

use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::contact::Surface;
use ipopt_contact::contact_fem::element::{Element, FacetRule, P1, P2};
use ipopt_contact::contact_fem::tensor::unit_vector;
use ipopt_contact::prelude::*;

use super::{Bound, Claim, Family, Kind, Quantity, Scope, ladder};
use crate::Failure;
use crate::case::{Case, Formulation, Points};
use crate::exact::{Field, Waves, ZoneEnd};
use crate::measure::Solved;
use crate::norms;
use crate::record::Measured;
use crate::refined::Place;
use ipopt_contact_scenes::pair;

/// A box of this many cells from `low` with these edges.
type Block<const D: usize> = fn([f64; D], [f64; D], [usize; D]) -> Result<Mesh<D>, Error>;

/// A box above the rigid plane X_D = 0 under the loads of a field, and where it is held.
struct Setup<'a, const D: usize> {
    field: &'a dyn Field<D>,
    /// The corner and the edges of the box (UL).
    low: [f64; D],
    size: [f64; D],
    /// Sides and the components of u that are prescribed there.
    supports: &'a [(&'a str, [bool; D])],
    block: Block<D>,
}

impl<const D: usize> Setup<'_, D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    /// The sides with the axis that they are normal to and the sign of their normal, the contact surface left out.
    fn sides() -> Vec<(&'static str, usize, f64)> {
        let mut sides = vec![("left", 0, -1.0), ("right", 0, 1.0), ("top", D - 1, 1.0)];
        if D == 3 {
            sides.extend([("front", 1, -1.0), ("back", 1, 1.0)]);
        }
        sides
    }

    /// Cells of size 1/n.
    fn divisions(&self, n: usize) -> [usize; D] {
        self.size.map(|edge| (edge * n as f64).round() as usize)
    }

    fn scene(&self, case: &Case) -> Result<Scene<D>, Error> {
        let n = case.level;
        // the plane's facets are smaller by a fifth or so, so that nodes do not meet
        let (mut low, mut size) = (self.low, self.size);
        (low[D - 1], size[D - 1]) = (-0.25, 0.25);
        let mut divisions = self.divisions(n + n.div_ceil(5));
        divisions[D - 1] = 1;
        let mut plane = Body::new((self.block)(low, size, divisions)?, self.field.law()?);
        plane.prescribe_all([Some(0.0); D])?;
        pair((self.body(case)?, "bottom"), (plane, "top"))
    }

    fn body(&self, case: &Case) -> Result<Body<D>, Error> {
        let mut mesh = (self.block)(self.low, self.size, self.divisions(case.level))?;
        if case.degree == 2 {
            mesh = mesh.quadratic();
        }
        let law = self.field.law()?;
        let mut body = Body::new(mesh, law);
        for (side, axis, sign) in Self::sides() {
            let support = self.supports.iter().find(|(name, _)| *name == side);
            let held = support.map_or([false; D], |(_, held)| *held);
            for node in body.mesh().boundary_nodes(side)? {
                let (u, _) = self.field.jet(&body.mesh().nodes()[node]);
                let value = |i: usize| held[i].then_some(u[i]);
                body.prescribe_nodes(&[node], std::array::from_fn(value))?;
            }
            let normal = unit_vector::<D>(axis) * sign;
            body.traction_field(side, |X| self.field.stress(&law, X) * normal)?;
        }
        body.body_force_field(|X| self.field.body_force(X))?;
        Ok(body)
    }

    fn run(&self, case: &Case) -> Result<Measured, Failure> {
        let solved = Solved::new(case, 1, || self.scene(case))?;
        let mut measured = solved.measured(1.0 / case.level as f64);
        let Some(solution) = solved.solution() else {
            return Ok(measured);
        };
        let (problem, law) = (&solved.problem, self.field.law()?);
        let u = solved.displacements();
        let exact = |_: usize, X: &_| Some(self.field.jet(X));
        let [l2, h1] = norms::of_displacement(problem, &u, &[0], exact);
        let pressure = |X: &_| self.field.pressure(&law, X);
        let surfaces = problem.surfaces().iter().zip(solved.pressures()?);
        for (surface, nodal) in surfaces.filter(|(surface, _)| surface.body() == 0) {
            let error = norms::of_pressure(surface, &nodal, pressure);
            measured.errors.insert("pressure".into(), error);
            let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
            let force: f64 = problem.nodes(0).map(|a| forces[a][D - 1]).sum();
            let exact = resultant(surface, pressure);
            measured
                .errors
                .insert("force".into(), (force / exact - 1.0).abs());
        }
        measured
            .errors
            .extend([("l2".into(), l2), ("h1".into(), h1)]);
        Ok(measured)
    }
}

/// ∫ p ds over a surface.
fn resultant<const D: usize>(
    surface: &Surface<D>,
    pressure: impl Fn(&ipopt_contact::contact_fem::tensor::Vector<D>) -> f64,
) -> f64 {
    let rule = FacetRule::<D>::gauss(8);
    let facets = surface.reference().iter().flat_map(|facet| {
        let points = rule.points().iter();
        points.map(|(weight, lambda)| {
            weight * facet.normal(lambda).norm() * pressure(&facet.point(lambda))
        })
    });
    facets.sum()
}

fn rectangle_of(low: [f64; 2], size: [f64; 2], divisions: [usize; 2]) -> Result<Mesh<2>, Error> {
    let grid = |i: usize| linspace(low[i], low[i] + size[i], divisions[i]);
    rectangle(&grid(0), &grid(1), Diagonals::Rising)
}

/// Where the contact zone ends. n cells a unit of length, n being 1 more than a multiple of 3, have it at a third of a
/// cell; meshes that have it elsewhere scatter around the same order.
const X0: f64 = 1.0 / 3.0;

fn smooth<const D: usize>(case: &Case, block: Block<D>) -> Result<Measured, Failure>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let only = |axis: usize| std::array::from_fn(|i| i == axis);
    Setup {
        field: &Waves::new(),
        low: [0.0; D],
        size: [1.0; D],
        supports: &[("left", only(0)), ("front", only(1))],
        block,
    }
    .run(case)
}

fn zone<const D: usize>(case: &Case, block: Block<D>) -> Result<Measured, Failure>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let (mut low, mut size) = ([0.0; D], [1.0; D]);
    (low[0], size[0]) = (-1.0, 2.0);
    let across = std::array::from_fn(|i| i == 1);
    Setup {
        field: &ZoneEnd { x0: X0 },
        low,
        size,
        supports: &[("top", [true; D]), ("front", across), ("back", across)],
        block,
    }
    .run(case)
}

/// P1 and P2 with Gauss points and exact integration.
fn ladders(family: &str, p1: &[usize], p2: &[usize]) -> Vec<Case> {
    let ladder = ladder(family, p1, p2);
    let exact = ladder.iter().cloned();
    let exact = exact.map(|case| case.with_points(Points::Exact));
    ladder.iter().cloned().chain(exact).collect()
}

/// The same, and the other two methods on one mesh each.
fn cases(family: &str, p1: &[usize], p2: &[usize]) -> Vec<Case> {
    let middle = [(1, p1[1]), (2, p2[1])];
    let methods = [Formulation::PenalizedSlack, Formulation::Penalty];
    let others = middle.into_iter().flat_map(|(degree, level)| {
        methods.map(|method| Case::new(family, degree, level).with_method(method))
    });
    ladders(family, p1, p2).into_iter().chain(others).collect()
}

const SIZE: &str = "1/n, the edge of the box over its cells";
const ABOUT_SMOOTH: &str = "An elastic box is pressed on a rigid plane all over its bottom by a body force and \
    tractions that belong to a smooth displacement. Mesh, order, integration and method vary; the plane's mesh does \
    not match the box's.";
const REFERENCE_SMOOTH: &str = "The displacement is a sum of products of sines and cosines; stress, body force, \
    tractions and pressure are derived from it by formula. A test checks the formulas against differences, and \
    Signorini's conditions.";
const THEORY_SMOOTH: &str = "u is smooth and the contact zone is the whole bottom: the error of the best \
    approximation, order 1 and 2 in H¹, 2 and 3 in L². The resultant follows from the loads alone, so that its error \
    is that of their quadrature.";
const ABOUT_ZONE: &str = "An elastic box on a rigid plane touches it left of x₀ and lifts off beyond. x₀ is at a \
    third of an element of every mesh. Mesh, order, integration and method vary.";
const REFERENCE_ZONE: &str = "Westergaard's stress function Z = i c √z, z = x − x₀ + i y, an exact solution of plane \
    elasticity with p = c √(x₀ − x) in contact and a gap ~ (x − x₀)^{3/2} beyond; no body force. A test checks it \
    against differences, and Signorini's conditions.";
const THEORY_ZONE: &str = "u is in H^s for s < 5/2 and no more, the regularity that every contact zone with an end \
    inside has: order 1 (P1) and 3/2 (P2) in H¹ on uniform meshes, the best that is possible. In L² not more than \
    that plus 1. The pressure, with its √, is in H^s for s < 1: no order beyond 1.";

const CAUSES_SMOOTH: &str = "The error of the force is soon that of round-off and of what the solver leaves, and does not \
    fall further. In space meshes are coarse: orders are on their way to those of theory.";
const CAUSES_ZONE: &str = "Where the pressure's square root ends, single facets carry most of its error; on coarse meshes \
    linear elements recover it with less than order 1. The force is a mean, whose error may change sign. In space \
    no bound is set for quadratic elements: time allows few and coarse meshes, whose order in H¹, where there is one, is \
    on its way to theory's.";

const SMOOTH: &[Quantity] = &[
    Quantity::new("h1", "displacement, H¹", Kind::Gradient).of_orders(1.0, 2.0),
    Quantity::new("l2", "displacement, L²", Kind::Displacement).of_orders(2.0, 3.0),
    Quantity::new("pressure", "pressure, L²", Kind::Pressure).of_orders(1.0, 2.0),
    Quantity::new("force", "contact force", Kind::Force),
];
const ZONE: &[Quantity] = &[
    Quantity::new("h1", "displacement, H¹", Kind::Gradient).of_orders(1.0, 1.5),
    Quantity::new("l2", "displacement, L²", Kind::Displacement).of_orders(2.0, 2.5),
    Quantity::new("pressure", "pressure, L²", Kind::Pressure).of_orders(1.0, 1.0),
    Quantity::new("force", "contact force", Kind::Force),
];

const fn order(quantity: &'static str, degree: usize, order: f64) -> Claim {
    Claim {
        quantity,
        degree,
        bound: Bound::Order(order),
    }
}

const SMOOTH_CLAIMS: &[Claim] = &[
    order("h1", 1, 0.95),
    order("l2", 1, 1.9),
    order("pressure", 1, 1.7),
    order("h1", 2, 1.9),
    order("pressure", 2, 1.9),
];
/// Meshes in space are too coarse for more.
const SMOOTH_CLAIMS_IN_SPACE: &[Claim] = &[
    order("h1", 1, 0.95),
    order("pressure", 1, 1.7),
    order("h1", 2, 1.9),
    order("pressure", 2, 1.4),
];
const ZONE_CLAIMS_IN_SPACE: &[Claim] = &[order("h1", 1, 0.95), order("pressure", 1, 0.9)];
const ZONE_CLAIMS: &[Claim] = &[
    order("h1", 1, 0.95),
    order("l2", 1, 1.9),
    order("pressure", 1, 0.9),
    order("h1", 2, 1.45),
    order("pressure", 2, 0.9),
];

/// In the plane: smooth, and with a zone that ends inside.
pub fn plane() -> [Family; 2] {
    let smooth = Family {
        name: "smooth-2d",
        title: "Manufactured, smooth, in the plane",
        about: ABOUT_SMOOTH,
        reference: REFERENCE_SMOOTH,
        theory: THEORY_SMOOTH,
        causes: CAUSES_SMOOTH,
        size: SIZE,
        quantities: SMOOTH,
        claims: SMOOTH_CLAIMS,
        cases: |scope| {
            let (p1, p2): (&[usize], &[usize]) = scope.pick(
                (&[8, 16, 32, 64], &[4, 8, 16, 32]),
                (&[8, 16, 32, 64, 128, 256], &[4, 8, 16, 32, 64, 128]),
            );
            cases("smooth-2d", p1, p2)
        },
        refined: None,
        run: |case, _: &Place| smooth::<2>(case, rectangle_of),
    };
    let zone = Family {
        name: "zone-2d",
        title: "Manufactured, contact zone ends inside, in the plane",
        about: ABOUT_ZONE,
        reference: REFERENCE_ZONE,
        theory: THEORY_ZONE,
        causes: CAUSES_ZONE,
        quantities: ZONE,
        claims: ZONE_CLAIMS,
        cases: |scope| {
            let (p1, p2): (&[usize], &[usize]) = scope.pick(
                (&[7, 13, 25, 49], &[4, 7, 13, 25]),
                (&[7, 13, 25, 49, 97, 193], &[4, 7, 13, 25, 49, 97]),
            );
            cases("zone-2d", p1, p2)
        },
        run: |case, _: &Place| zone::<2>(case, rectangle_of),
        ..smooth
    };
    [smooth, zone]
}

/// The same in space.
pub fn space() -> [Family; 2] {
    let [smooth_in_plane, zone_in_plane] = plane();
    [
        Family {
            name: "smooth-3d",
            title: "Manufactured, smooth, in space",
            claims: SMOOTH_CLAIMS_IN_SPACE,
            cases: |scope| {
                let (p1, p2): (&[usize], &[usize]) = scope.pick(
                    (&[4, 6, 8], &[2, 3, 4]),
                    (&[4, 6, 8, 12, 16], &[2, 3, 4, 6, 8]),
                );
                cases("smooth-3d", p1, p2)
            },
            run: |case, _: &Place| smooth::<3>(case, cuboid),
            ..smooth_in_plane
        },
        Family {
            name: "zone-3d",
            title: "Manufactured, contact zone ends inside, in space",
            claims: ZONE_CLAIMS_IN_SPACE,
            cases: |scope| {
                let (p1, p2): (&[usize], &[usize]) =
                    scope.pick((&[4, 7, 10], &[1, 4]), (&[4, 7, 10, 13, 16], &[1, 4, 7]));
                // penalties take dozens of iterations
                match scope {
                    Scope::Quick => ladders("zone-3d", p1, p2),
                    Scope::Full => cases("zone-3d", p1, p2),
                }
            },
            run: |case, _: &Place| zone::<3>(case, cuboid),
            ..zone_in_plane
        },
    ]
}
