use contact_core::check;

use super::*;
use crate::assembly::StrainEnergy;
use crate::element::{Element, P1, P2};
use crate::material::NeoHookean;
use crate::mesh::generators::{Diagonals, cuboid, rectangle};

/// What a boundary's energy is tested on: which dofs are held (by X and component), and whether the pressure has a potential.
struct Case<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    boundary: &'a str,
    is_held: &'a dyn Fn(&Vector<D>, usize) -> bool,
    is_conservative: bool,
}

/// A boundary, which dofs are held, and whether the pressure on it has a potential.
type Held<'a, const D: usize> = (&'a str, &'a dyn Fn(&Vector<D>, usize) -> bool, bool);

/// Derivatives under springs and a pressure against differences, at a state with large waves.
fn compare<const D: usize, E: Element<D>>(case: &Case<'_, D>) {
    let mesh = case.mesh;
    let nodes = mesh.nodes().iter();
    let held = nodes.flat_map(|X| (0..D).map(|i| (case.is_held)(X, i)));
    let dofs = DofMap::new(&held.collect::<Vec<_>>());
    let prescribed = vec![0.07; dofs.prescribed()];
    let law = NeoHookean::new(3.0, 0.3).expect("a law");
    let body =
        StrainEnergy::<D, E, _>::new(mesh, law, dofs.clone(), prescribed, vec![0.0; dofs.len()]);
    let facets = mesh.boundary(case.boundary).expect("named");
    let springs = [Stretch::Any, Stretch::Normal].map(|s| Springs::new(mesh, &facets, 2.0, s));
    let pressed = vec![Pressed::new(mesh, &facets)];
    let mut energy = OnBoundary::new(Box::new(body), dofs, springs.to_vec(), pressed);
    energy.set_load(1.0);
    energy.set_pressures(&[1.7]);
    let u: Vec<f64> = (0..energy.dofs())
        .map(|k| 0.04 * (1.0 + 3.0 * k as f64).sin())
        .collect();
    let found = check::energy(&energy, &u, 1e-5);
    let worst = found.gradient.max(found.hessian).max(found.outside_pattern);
    assert_eq!(
        worst < 1e-7,
        case.is_conservative,
        "{found:?} of {}",
        case.boundary
    );
    // residuals at free dofs are the gradient, and their energy is the value
    let (mut forces, mut g) = (vec![0.0; energy.dofs.len()], vec![0.0; u.len()]);
    let value = energy.add_residual(&u, &mut forces);
    energy.gradient(&u, &mut g);
    assert!((value - energy.value(&u)).abs() < 1e-12 * value.abs());
    let free = (0..forces.len()).filter_map(|dof| match energy.dofs.get(dof) {
        Dof::Free(k) => Some((forces[dof] - g[k]).abs()),
        Dof::Prescribed(_) => None,
    });
    assert!(free.fold(0.0, f64::max) < 1e-12);
}

/// A strip whose top slides with its rim in planes, is clamped at its rim, is closed with the other sides, or is free.
#[test]
fn derivatives_in_the_plane() {
    let ends = |X: &Vector<2>| X[0] == 0.0 || X[0] == 2.0;
    let linear = rectangle(&[0.0, 0.9, 2.0], &[0.0, 0.8], Diagonals::Rising).expect("a mesh");
    for mut mesh in [linear.clone(), linear.quadratic()] {
        mesh.name_boundary("all", |_| true);
        let slides = |X: &Vector<2>, i: usize| i == 0 && ends(X);
        let clamped = |X: &Vector<2>, _| ends(X);
        let one_end = |X: &Vector<2>, _| X[0] == 0.0;
        let cases: [Held<2>; 4] = [
            ("top", &slides, true),
            ("top", &clamped, true),
            ("all", &one_end, true),
            ("top", &one_end, false),
        ];
        for (boundary, is_held, is_conservative) in cases {
            let mesh = &mesh;
            let case = Case {
                mesh,
                boundary,
                is_held,
                is_conservative,
            };
            match mesh.order() {
                crate::element::Order::Linear => compare::<2, P1>(&case),
                crate::element::Order::Quadratic => compare::<2, P2>(&case),
            }
        }
    }
}

/// The same of a block: its sides are planes of symmetry, which move, one of them clamped, or free.
#[test]
fn derivatives_in_space() {
    let linear = cuboid([0.0; 3], [1.0, 1.2, 0.7], [2, 1, 1]).expect("a mesh");
    let side = |X: &Vector<3>, i: usize| X[i] == 0.0 || X[i] == [1.0, 1.2][i];
    let planes = |X: &Vector<3>, i: usize| i < 2 && side(X, i);
    let mixed = |X: &Vector<3>, i: usize| X[0] == 0.0 || planes(X, i);
    let one_way = |X: &Vector<3>, i: usize| i == 0 && side(X, 0);
    for mut mesh in [linear.clone(), linear.quadratic()] {
        mesh.name_boundary("all", |_| true);
        let cases: [Held<3>; 4] = [
            ("top", &planes, true),
            ("top", &mixed, true),
            ("all", &one_way, true),
            ("top", &one_way, false),
        ];
        for (boundary, is_held, is_conservative) in cases {
            let mesh = &mesh;
            let case = Case {
                mesh,
                boundary,
                is_held,
                is_conservative,
            };
            match mesh.order() {
                crate::element::Order::Linear => compare::<3, P1>(&case),
                crate::element::Order::Quadratic => compare::<3, P2>(&case),
            }
        }
    }
}

/// The volume that the whole boundary of a body sweeps is what the body gains: 1.1 · 1.2 · 0.8 of 1.
#[test]
fn swept_volumes() {
    let mut mesh = cuboid([0.3; 3], [1.0; 3], [2, 1, 1])
        .expect("a mesh")
        .quadratic();
    mesh.name_boundary("all", |_| true);
    let pressed = Pressed::new(&mesh, &mesh.boundary("all").expect("named"));
    let factors = [0.1, 0.2, -0.2];
    let nodes = mesh.nodes().iter();
    let U: Vec<f64> = nodes
        .flat_map(|X| [0, 1, 2].map(|i| factors[i] * X[i]))
        .collect();
    for first in [0, 1, 3] {
        let volume = pressed.volume(&U, |dof| dof % 3 >= first);
        assert!((volume - (1.1 * 1.2 * 0.8 - 1.0)).abs() < 1e-14, "{volume}");
    }
}
