//! Averaged changes of volume: derivatives against differences, and homogeneous states against cells that are not averaged.

use contact_core::check;

use super::*;
use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use crate::{LinearElastic, MooneyRivlin, NeoHookean, Ogden};

fn square() -> Mesh<2> {
    let xs = linspace(0.0, 1.0, 3);
    rectangle(&xs, &xs, Diagonals::Alternating).expect("a mesh")
}

fn cube() -> Mesh<3> {
    cuboid([0.0; 3], [1.0; 3], [2, 1, 2]).expect("a mesh")
}

/// A body held on the left, with one component free at the top, and pulled; both energies of it.
fn energies<const D: usize, M: Volumetric<D>>(
    mesh: &Mesh<D>,
    law: M,
) -> (AveragedVolume<D, M>, StrainEnergy<D, P1, M>)
where
    P1: Element<D>,
{
    let count = D * mesh.nodes().len();
    let mut held = vec![false; count];
    for a in mesh.boundary_nodes("left").expect("named") {
        (0..D).for_each(|i| held[D * a + i] = true);
    }
    for a in mesh.boundary_nodes("top").expect("named") {
        held[D * a] = true;
    }
    let forces: Vec<f64> = (0..count).map(|k| (k as f64).sin()).collect();
    let dofs = DofMap::new(&held);
    let prescribed: Vec<f64> = (0..dofs.prescribed())
        .map(|k| 0.01 * (2.0 + k as f64).cos())
        .collect();
    let mut averaged =
        AveragedVolume::new(mesh, &law, dofs.clone(), prescribed.clone(), forces.clone());
    let mut plain = StrainEnergy::new(mesh, law, dofs, prescribed, forces);
    averaged.set_load(1.0);
    plain.set_load(1.0);
    (averaged, plain)
}

fn derivatives<const D: usize, M: Volumetric<D>>(mesh: &Mesh<D>, law: M)
where
    P1: Element<D>,
{
    let (averaged, plain) = energies(mesh, law);
    let waves = (0..averaged.dofs()).map(|k| 0.02 * (1.0 + k as f64).sin());
    let u: Vec<f64> = waves.collect();
    let errors = check::energy(&averaged, &u, 1e-5);
    let worst = errors
        .gradient
        .max(errors.hessian)
        .max(errors.outside_pattern);
    assert!(worst < 1e-7, "{errors:?}");
    assert!(averaged.value(&u) < plain.value(&u), "it is softer");
    let mut residual = vec![0.0; D * mesh.nodes().len()];
    let mut gradient = vec![0.0; averaged.dofs()];
    let energy = averaged.add_residual(&u, &mut residual);
    averaged.gradient(&u, &mut gradient);
    assert!((energy - averaged.value(&u)).abs() < 1e-12 * energy.abs().max(1.0));
    for (dof, force) in residual.iter().enumerate() {
        if let Dof::Free(k) = averaged.elastic.dof(dof) {
            assert!((force - gradient[k]).abs() < 1e-10 * (1.0 + force.abs()));
        }
    }
}

#[test]
fn derivatives_are_differences() {
    let mooney = MooneyRivlin::new(2.0, 0.49, 0.3).expect("a law");
    derivatives::<2, _>(&square(), NeoHookean::new(2.0, 0.49).expect("a law"));
    derivatives::<2, _>(&square(), LinearElastic::new(2.0, 0.49).expect("a law"));
    derivatives::<2, _>(&square(), mooney);
    derivatives::<3, _>(&cube(), NeoHookean::new(2.0, 0.49).expect("a law"));
    derivatives::<3, _>(&cube(), LinearElastic::new(2.0, 0.49).expect("a law"));
    derivatives::<3, _>(&cube(), mooney);
    let ogden = Ogden::new(&[[0.6, 1.3], [-0.01, -2.0]], 0.49).expect("a law");
    derivatives::<2, _>(&square(), ogden.clone());
    derivatives::<3, _>(&cube(), ogden);
}

/// Where all cells deform alike, means are the cells' own values: energy, forces and stresses are those of plain cells.
fn homogeneous<const D: usize, M: Volumetric<D>>(mesh: &Mesh<D>, law: M)
where
    P1: Element<D>,
{
    let dofs = DofMap::new(&vec![false; D * mesh.nodes().len()]);
    let none = vec![0.0; dofs.len()];
    let averaged = AveragedVolume::new(mesh, &law, dofs.clone(), Vec::new(), none.clone());
    let plain = StrainEnergy::<D, P1, M>::new(mesh, law, dofs, Vec::new(), none);
    let gradient = Matrix::<D>::from_fn(|i, j| 0.1 * (1.0 + (i + 2 * j) as f64).sin());
    let U: Vec<Vector<D>> = mesh.nodes().iter().map(|X| gradient * X).collect();
    let u: Vec<f64> = U.iter().flat_map(|u| u.iter().copied()).collect();
    let (a, b) = (averaged.value(&u), plain.value(&u));
    assert!((a - b).abs() < 1e-13 * b.abs(), "{a} {b}");
    let mut forces = [vec![0.0; u.len()], vec![0.0; u.len()]];
    averaged.gradient(&u, &mut forces[0]);
    plain.gradient(&u, &mut forces[1]);
    let largest = forces[1].iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    for (a, b) in forces[0].iter().zip(&forces[1]) {
        assert!((a - b).abs() < 1e-12 * largest, "{a} {b}");
    }
    let states = averaged.cell_states(mesh, &U);
    for (a, b) in states.iter().zip(plain.cell_states(mesh, &U)) {
        assert!((a.sigma - b.sigma).norm() < 1e-12 * b.sigma.norm());
        assert!((a.sigma_zz - b.sigma_zz).abs() < 1e-12 * b.sigma.norm());
    }
    assert_eq!(averaged.contact_modulus(), plain.contact_modulus());
}

#[test]
fn homogeneous_states_are_those_of_plain_cells() {
    let mooney = MooneyRivlin::new(2.0, 0.4, 0.3).expect("a law");
    homogeneous::<2, _>(&square(), NeoHookean::new(2.0, 0.4).expect("a law"));
    homogeneous::<2, _>(&square(), LinearElastic::new(2.0, 0.4).expect("a law"));
    homogeneous::<2, _>(&square(), mooney);
    homogeneous::<3, _>(&cube(), NeoHookean::new(2.0, 0.4).expect("a law"));
    homogeneous::<3, _>(&cube(), LinearElastic::new(2.0, 0.4).expect("a law"));
    homogeneous::<3, _>(&cube(), mooney);
}

/// Cells whose nodes are all held have stresses, too.
#[test]
fn stresses_of_held_cells() {
    let mesh = square();
    let law = NeoHookean::new(10.0, 0.4).expect("a law");
    let dofs = DofMap::new(&vec![true; 2 * mesh.nodes().len()]);
    let none = vec![0.0; dofs.len()];
    let averaged = AveragedVolume::new(&mesh, &law, dofs.clone(), none.clone(), none.clone());
    let plain = StrainEnergy::<2, P1, _>::new(&mesh, law, dofs, none.clone(), none);
    let U: Vec<Vector<2>> = mesh.nodes().iter().map(|X| X * -0.1).collect();
    let states = averaged.cell_states(&mesh, &U);
    for (a, b) in states.iter().zip(plain.cell_states(&mesh, &U)) {
        assert!((a.sigma - b.sigma).norm() < 1e-12 * b.sigma.norm());
    }
}
