//! The contact patch test with exact integration: meshes that do not match, flat interfaces of any
//! orientation, every pass.

use contact_core::gaps::Sampling;
use contact_core::{ContactProblem, LoadStepped, RowKey};
use contact_fem::Scene;
use contact_fem::assembly::Dof;
use contact_fem::contact::Surface;
use contact_fem::element::Order;
use contact_fem::model::{Integration, Passes};
use contact_fem::tensor::Vector;
use ipopt_contact_scenes::blocks::{Blocks, errors, exact};

const ALL_PASSES: [Passes; 3] = [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave];
const P1: Order = Order::Linear;
const P2: Order = Order::Quadratic;

/// All scenes of these divisions: elements of either degree and mixed, three orientations, every pass.
fn blocks(divisions: &[[usize; 2]], orders: &[[Order; 2]]) -> Vec<Blocks> {
    let mut all = Vec::new();
    for &divisions in divisions {
        for &orders in orders {
            for degrees in [0.0, 17.0, 45.0] {
                all.extend(ALL_PASSES.map(|passes| Blocks {
                    orders,
                    passes,
                    degrees,
                    ..Blocks::new(divisions, P1, Integration::Exact)
                }));
            }
        }
    }
    all
}

const PLANE: [[usize; 2]; 7] = [[6, 6], [5, 7], [7, 5], [4, 9], [3, 7], [2, 9], [3, 21]];
const SPACE: [[usize; 2]; 6] = [[2, 2], [2, 3], [3, 2], [3, 4], [1, 4], [1, 7]];

/// Without a solver: at the exact displacement gaps are closed, and the forces λ_i = p ∫φ_i, shared by
/// the passes, are in equilibrium with the stress at every node that is free.
fn is_solved_by_the_exact_state<const D: usize>(scene: Scene<D>, case: &Blocks) {
    let mut problem = scene.problem().expect("valid scene");
    problem.set_load(1.0).expect("load");
    let (exact, stress) = exact(&problem);
    let scalars: Vec<f64> = exact.iter().flat_map(|u| u.iter().copied()).collect();
    let mut u = vec![0.0; problem.dofs().free()];
    for (dof, value) in scalars.iter().enumerate() {
        if let Dof::Free(free) = problem.dofs().get(dof) {
            u[free] = *value;
        }
    }
    let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
    let mut c = vec![0.0; gaps.len()];
    gaps.value(&u, &mut c);
    assert_eq!(gaps.len(), problem.contact_nodes(), "{case:?}");
    assert!(c.iter().all(|c| c.abs() < 1e-14), "{case:?}: {c:?}");

    // the passes share the pressure
    let share = stress.norm() / problem.passes().len() as f64;
    let integrals: Vec<Vec<f64>> = problem
        .surfaces()
        .iter()
        .map(|s| test_integrals(s))
        .collect();
    let force = |key: &RowKey| {
        let slave = problem.passes()[key.pass as usize].slave;
        let nodes = problem.surfaces()[slave].nodes();
        let node = nodes.iter().position(|&a| a == key.node as usize);
        share * integrals[slave][node.expect("a node of the slave")]
    };
    let lambda: Vec<f64> = gaps.keys().iter().map(force).collect();
    let (mut gradient, mut forces) = (vec![0.0; u.len()], vec![0.0; u.len()]);
    problem.energy().gradient(&u, &mut gradient);
    gaps.add_forces(&lambda, &mut forces);
    let largest = lambda.iter().fold(0.0, |m: f64, l| m.max(*l));
    for (inner, contact) in gradient.iter().zip(&forces) {
        let rest = (inner - contact).abs() / largest;
        assert!(rest < 1e-12, "{case:?}: {rest:e}");
    }
}

/// ∫φ_i over the surface for each of its nodes.
fn test_integrals<const D: usize>(surface: &Surface<D>) -> Vec<f64> {
    let share = |k: usize| match (surface.test_nodes(), k) {
        // quadratic functions on a segment
        (3, 0..=1) if D == 2 => 1.0 / 6.0,
        (3, _) if D == 2 => 2.0 / 3.0,
        _ => 1.0 / D as f64,
    };
    let mut integrals = vec![0.0; surface.nodes().len()];
    for (nodes, facet) in surface.facets().zip(surface.reference()) {
        let measure = facet.normal(&Vector::repeat(1.0 / D as f64)).norm();
        for (k, &node) in nodes.iter().take(surface.test_nodes()).enumerate() {
            integrals[node] += share(k) * measure;
        }
    }
    integrals
}

const ORDERS: [[Order; 2]; 4] = [[P1, P1], [P2, P2], [P1, P2], [P2, P1]];

#[test]
fn the_exact_state_is_a_solution_in_the_plane() {
    for case in blocks(&PLANE, &ORDERS) {
        is_solved_by_the_exact_state(case.plane().expect("valid"), &case);
    }
}

#[test]
fn the_exact_state_is_a_solution_in_space() {
    for case in blocks(&SPACE, &ORDERS) {
        is_solved_by_the_exact_state(case.space().expect("valid"), &case);
    }
}

/// Stress in every cell and displacement of every node, of elements of one degree.
fn solved(case: &Blocks, [stress, displacement]: [f64; 2], allowed: f64) {
    assert!(stress <= allowed, "{case:?}: stress {stress:e}");
    assert!(displacement <= allowed, "{case:?}: {displacement:e}");
}

#[test]
fn linear_elements_in_the_plane() {
    for case in blocks(&PLANE, &[[P1, P1]]) {
        let found = errors(case.plane().expect("valid")).expect("solved");
        solved(&case, found, 1e-10);
    }
}

/// Quadratic test functions of both passes depend on each other, but for what either mesh resolves and
/// the other does not, squared: singular values of the rows go down to 5e-7 for 5 and 7 facets. What
/// round-off and barrier leave of such a combination is that much larger; the constraints themselves
/// have no error, see [`the_exact_state_is_a_solution_in_the_plane`].
#[test]
fn quadratic_elements_in_the_plane() {
    for case in blocks(&PLANE, &[[P2, P2]]) {
        let found = errors(case.plane().expect("valid")).expect("solved");
        let allowed = match case.passes {
            Passes::Both => 1e-7,
            _ => 1e-10,
        };
        solved(&case, found, allowed);
    }
}

#[test]
fn linear_elements_in_space() {
    for case in blocks(&SPACE, &[[P1, P1]]) {
        let found = errors(case.space().expect("valid")).expect("solved");
        solved(&case, found, 1e-10);
    }
}

#[test]
fn quadratic_elements_in_space() {
    let turned = |case: &Blocks| case.degrees == 17.0;
    let mut all = blocks(&SPACE[..5], &[[P2, P2]]);
    all.extend(blocks(&SPACE[5..], &[[P2, P2]]).into_iter().filter(turned));
    for case in all {
        let found = errors(case.space().expect("valid")).expect("solved");
        solved(&case, found, 1e-10);
    }
}

/// Where geometry and projections follow the displacement.
#[test]
fn large_strains() {
    for order in [P1, P2] {
        for case in blocks(&[[4, 9]], &[[order; 2]]) {
            let case = Blocks {
                large_strains: true,
                ..case
            };
            let found = errors(case.plane().expect("valid")).expect("solved");
            let allowed = match (order, case.passes) {
                (P2, Passes::Both) => 1e-7,
                _ => 1e-10,
            };
            solved(&case, found, allowed);
        }
        for case in blocks(&[[2, 3]], &[[order; 2]]) {
            let case = Blocks {
                large_strains: true,
                ..case
            };
            let found = errors(case.space().expect("valid")).expect("solved");
            solved(&case, found, 1e-10);
        }
    }
}
