//! Estimates against known errors: fields that cells represent have none, and a smooth field has the error of its interpolation.

use super::super::{AveragedVolume, BodyEnergy, DofMap, Laws, Revolution, StrainEnergy};
use super::*;
use crate::element::{P1, P2, RingP2};
use crate::material::{LinearElastic, NeoHookean};
use crate::mesh::generators::{Diagonals, cuboid, eighth_sphere, rectangle};

const LAMBDA: f64 = 3.0;
const MU: f64 = 2.0;

/// With λ = 3 and μ = 2.
fn law() -> LinearElastic {
    let (E, nu) = (MU * (3.0 * LAMBDA + 2.0 * MU) / (LAMBDA + MU), 0.3);
    LinearElastic::new(E, nu).expect("a law")
}

/// Nodes of a mesh of about `n` cells a side are displaced by up to a tenth of a cell, without order.
fn shaken<const D: usize>(mesh: Mesh<D>, n: usize) -> Mesh<D> {
    let noise = |X: &Vector<D>, i: usize| {
        let weights = [12.9898, 78.233, 37.719];
        let phase: f64 = X.iter().zip(weights).map(|(x, w)| x * w).sum();
        ((phase + i as f64) * 43758.5453).sin()
    };
    let is_inside = |x: f64| 1e-9 < x && x < 1.0 - 1e-9;
    let moved = |X: &Vector<D>| {
        let shift = |i: usize| match is_inside(X[i]) {
            true => 0.1 / n as f64 * noise(X, i),
            false => 0.0,
        };
        X + Vector::from_fn(|i, _| shift(i))
    };
    mesh.mapped(moved).expect("sound cells")
}

fn square(n: usize) -> Mesh<2> {
    let sides: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
    let mesh = rectangle(&sides, &sides, Diagonals::Alternating);
    shaken(mesh.expect("a mesh"), n)
}

fn cube(n: usize) -> Mesh<3> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3]);
    shaken(mesh.expect("a mesh"), n)
}

fn free<const D: usize>(mesh: &Mesh<D>) -> DofMap {
    DofMap::new(&vec![false; D * mesh.nodes().len()])
}

fn errors<const D: usize, E: Element<D>>(mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError>
where
    LinearElastic: crate::Material<D>,
{
    let forces = vec![0.0; D * mesh.nodes().len()];
    let energy = StrainEnergy::<D, E, _>::new(mesh, law(), free(mesh), Vec::new(), forces);
    energy.cell_errors(mesh, U)
}

/// Sums of squares and of energies.
fn sums(errors: &[CellError]) -> [f64; 2] {
    errors.iter().fold([0.0; 2], |[square, energy], error| {
        [square + error.square, energy + error.energy]
    })
}

/// A smooth field and its gradient.
fn wave<const D: usize>(X: &Vector<D>) -> (Vector<D>, Matrix<D>) {
    let rate = [1.3, 0.9, 1.1];
    let phase = |i: usize| 0.4 * i as f64 + (0..D).map(|j| rate[(i + j) % 3] * X[j]).sum::<f64>();
    (
        Vector::from_fn(|i, _| phase(i).sin()),
        Matrix::from_fn(|i, j| rate[(i + j) % 3] * phase(i).cos()),
    )
}

/// λ (tr d)² + 2μ |sym d|².
fn density<const D: usize>(d: &Matrix<D>) -> f64 {
    let symmetric = (d + d.transpose()) * 0.5;
    LAMBDA * d.trace().powi(2) + 2.0 * MU * symmetric.norm_squared()
}

/// The square of the error of interpolation of the wave, by quadrature of its own.
fn truth<const D: usize, E: Element<D>>(mesh: &Mesh<D>, U: &[Vector<D>]) -> f64 {
    let of_point = |cell: &[usize], weight: f64, xi: &Vector<D>| {
        let gradients = E::shape_gradients(xi);
        let (mut dX, mut du) = (Matrix::<D>::zeros(), Matrix::<D>::zeros());
        for (&a, dN) in cell.iter().zip(gradients.as_ref()) {
            dX += mesh.nodes()[a] * dN.transpose();
            du += U[a] * dN.transpose();
        }
        let shapes = E::shapes(xi);
        let nodes = cell.iter().zip(shapes.as_ref());
        let X: Vector<D> = nodes.map(|(&a, N)| mesh.nodes()[a] * *N).sum();
        let inverse = dX.try_inverse().expect("a sound cell");
        weight * crate::tensor::determinant(&dX) * density(&(wave(&X).1 - du * inverse))
    };
    let cells = mesh.cells().map(|cell| {
        let points = degree_5::<D>();
        points
            .map(|(weight, xi)| of_point(cell, weight, &xi))
            .sum::<f64>()
    });
    cells.sum()
}

fn field<const D: usize>(mesh: &Mesh<D>, u: impl Fn(&Vector<D>) -> Vector<D>) -> Vec<Vector<D>> {
    mesh.nodes().iter().map(u).collect()
}

#[test]
fn what_cells_represent_has_no_error() {
    fn check<const D: usize, E: Element<D>>(mesh: &Mesh<D>)
    where
        LinearElastic: crate::Material<D>,
    {
        let slope = Matrix::<D>::from_fn(|i, j| 0.3 + i as f64 - 0.7 * j as f64);
        let bend = |X: &Vector<D>| match E::ORDER {
            Order::Linear => 0.0,
            Order::Quadratic => X[0] * X[1] - 0.4 * X[D - 1].powi(2),
        };
        let U = field(mesh, |X| slope * X + Vector::repeat(bend(X)));
        let [square, energy] = sums(&errors::<D, E>(mesh, &U));
        assert!(square < 1e-22 * energy, "{square:e} of {energy:e}");
        // the density of what is linear is constant
        if E::ORDER == Order::Linear {
            assert!((energy - 0.5 * density(&slope)).abs() < 1e-12 * energy);
        }
    }
    check::<2, P1>(&square(5));
    check::<3, P1>(&cube(3));
    check::<2, P2>(&square(4).quadratic());
    check::<3, P2>(&cube(2).quadratic());
}

#[test]
fn errors_of_smooth_fields_are_estimated_closely() {
    fn check<const D: usize, E: Element<D>>(mesh: &Mesh<D>, within: [f64; 2])
    where
        LinearElastic: crate::Material<D>,
    {
        let U = field(mesh, |X| wave(X).0);
        let [square, energy] = sums(&errors::<D, E>(mesh, &U));
        let ratio = (square / truth::<D, E>(mesh, &U)).sqrt();
        assert!(within[0] < ratio && ratio < within[1], "{ratio}");
        assert!(square < 0.1 * energy);
    }
    check::<2, P1>(&square(12), [0.9, 1.1]);
    check::<2, P1>(&square(4), [0.8, 1.2]);
    check::<3, P1>(&cube(6), [0.8, 1.2]);
    check::<2, P2>(&square(8).quadratic(), [0.9, 1.2]);
    check::<3, P2>(&cube(4).quadratic(), [0.9, 1.3]);
}

/// An eighth of a ball, bisected around its pole again and again: corners there have cells of many sizes around them, and on the edges of the ball few.
#[test]
fn errors_of_graded_meshes_are_estimated_closely() {
    fn check<E: Element<3>>(mesh: Mesh<3>) {
        let mut mesh = mesh;
        for round in 1..=4 {
            let pole = Vector::<3>::new(0.0, 0.0, -1.0);
            let centre = |k: usize| {
                let corners = mesh.corners(k).iter().map(|&a| mesh.nodes()[a]);
                corners.sum::<Vector<3>>() / 4.0
            };
            let is_near = |k: usize| (centre(k) - pole).norm() < 1.2 * 0.6_f64.powi(round);
            let marked: Vec<bool> = (0..mesh.len()).map(is_near).collect();
            mesh = mesh.refined_where(&marked).expect("sound cells");
            let U = field(&mesh, |X| wave(X).0);
            let [square, _] = sums(&errors::<3, E>(&mesh, &U));
            let ratio = (square / truth::<3, E>(&mesh, &U)).sqrt();
            assert!((0.7..1.4).contains(&ratio), "{round}: {ratio}");
        }
    }
    let ball = || eighth_sphere(1.0, 4).expect("a mesh");
    check::<P1>(ball());
    check::<P2>(ball().quadratic());
}

/// The stress of a bar of two materials is the same everywhere, its strain is not.
#[test]
fn strains_may_jump_between_parts() {
    let mesh = rectangle(
        &[0.0, 0.5, 1.0, 1.5, 2.0],
        &[0.0, 0.5, 1.0],
        Diagonals::Rising,
    );
    let mut mesh = mesh.expect("a mesh");
    mesh.name_region("soft", |X| X[0] < 1.0);
    mesh.name_region("stiff", |X| X[0] > 1.0);
    let of = |E: f64| LinearElastic::new(E, 0.0).expect("a law");
    let laws = Laws::of_regions::<2, P1>(&mesh, [("soft", of(1.0)), ("stiff", of(4.0))]);
    let forces = vec![0.0; 2 * mesh.nodes().len()];
    let energy = StrainEnergy::<2, P1, _>::with_laws(
        &mesh,
        &laws.expect("laws"),
        free(&mesh),
        Vec::new(),
        forces.clone(),
    );
    let stretched =
        |X: &Vector<2>| Vector::<2>::new(X[0].min(1.0) + 0.25 * (X[0] - 1.0).max(0.0), 0.0);
    let U = field(&mesh, stretched);
    let [square, stored] = sums(&energy.cell_errors(&mesh, &U));
    assert!((stored - (0.5 + 0.125)).abs() < 1e-14, "{stored}");
    assert!(square < 1e-28, "{square:e}");
    // with one law the same field is wrong
    let one = StrainEnergy::<2, P1, _>::new(&mesh, of(1.0), free(&mesh), Vec::new(), forces);
    let [square, stored] = sums(&one.cell_errors(&mesh, &U));
    assert!(square > 0.01 * stored, "{square:e} of {stored:e}");
}

/// A cell is no error where nothing can move, and its gradients count for no other.
#[test]
fn held_cells_have_none() {
    let mesh = rectangle(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0], Diagonals::Rising).expect("a mesh");
    let held: Vec<bool> = mesh.nodes().iter().map(|X| X[0] < 1.5).collect();
    let held: Vec<bool> = held.iter().flat_map(|&held| [held; 2]).collect();
    let dofs = DofMap::new(&held);
    let none = vec![0.0; dofs.prescribed()];
    let forces = vec![0.0; held.len()];
    let energy = StrainEnergy::<2, P1, _>::new(&mesh, law(), dofs, none, forces);
    let U = field(&mesh, |X| Vector::<2>::new((X[0] - 1.0).max(0.0), 0.0));
    let errors = energy.cell_errors(&mesh, &U);
    assert_eq!(errors[..2], [CellError::default(); 2]);
    let [square, stored] = sums(&errors);
    assert!(square < 1e-28 && stored > 1.0, "{square:e} of {stored:e}");
}

/// A body of revolution that is stretched by a along the radius, and so around, and by b along the axis.
#[test]
fn bodies_of_revolution_have_their_energy_and_no_error() {
    let mesh = rectangle(&[0.0, 0.4, 1.0], &[0.0, 0.7, 1.0], Diagonals::Rising).expect("a mesh");
    let (mesh, _) = mesh.quadratic().revolved().expect("a half-plane");
    let (a, b) = (0.02, -0.01);
    let U = field(&mesh, |X| Vector::<2>::new(a * X[0], b * X[1]));
    let forces = vec![0.0; 2 * mesh.nodes().len()];
    let energy = StrainEnergy::<2, RingP2, _, Revolution>::with_kinematics(
        &mesh,
        &law().into(),
        free(&mesh),
        Vec::new(),
        forces,
    );
    let [square, stored] = sums(&energy.cell_errors(&mesh, &U));
    let strain = Matrix::<3>::from_diagonal(&Vector::<3>::new(a, a, b));
    let expected = 0.5 * std::f64::consts::PI * density(&strain);
    assert!(
        (stored - expected).abs() < 1e-12 * expected,
        "{stored} for {expected}"
    );
    assert!(square < 1e-24 * stored, "{square:e} of {stored:e}");
}

/// Averaged changes of volume store what the energy says, and have no error where they are uniform.
#[test]
fn averaged_volumes_have_their_energy() {
    let (mesh, law) = (square(4), NeoHookean::new(10.0, 0.49).expect("a law"));
    let forces = vec![0.0; 2 * mesh.nodes().len()];
    let averaged = AveragedVolume::<2, _>::new(&mesh, &law, free(&mesh), Vec::new(), forces);
    let slope = Matrix::<2>::new(0.1, 0.05, -0.02, -0.07);
    let uniform = field(&mesh, |X| slope * X);
    let [square, stored] = sums(&averaged.cell_errors(&mesh, &uniform));
    assert!(square < 1e-24 * stored, "{square:e} of {stored:e}");
    let waves = field(&mesh, |X| wave(X).0 * 0.05);
    for U in [uniform, waves] {
        let [square, stored] = sums(&averaged.cell_errors(&mesh, &U));
        let all: Vec<f64> = U.iter().flat_map(|v| v.iter().copied()).collect();
        let expected = contact_core::Energy::value(&averaged, &all)
            - contact_core::Energy::value(&averaged, &vec![0.0; all.len()]);
        assert!(
            (stored - expected).abs() < 1e-12 * expected,
            "{stored} for {expected}"
        );
        assert!(square < 0.2 * stored);
    }
}

/// u = (x²/2, 0) changes volumes by x. Between the nodes the pressure k x is linear, in a cell of legs h it is constant: the square of what is between
/// them, by 1/k, is k h²/18 a volume. The rest of the law is the same for both k.
#[test]
fn pressures_of_averaged_volumes_have_an_error() {
    let n = 32;
    let sides: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
    let mesh = rectangle(&sides, &sides, Diagonals::Rising).expect("a mesh");
    let U = field(&mesh, |X| Vector::<2>::new(0.5 * X[0] * X[0], 0.0));
    let of = |poisson: f64| {
        // μ = 1
        let law = LinearElastic::new(2.0 * (1.0 + poisson), poisson).expect("a law");
        let k = crate::material::Volumetric::<2>::split(&law).1;
        let forces = vec![0.0; 2 * mesh.nodes().len()];
        let averaged = AveragedVolume::<2, _>::new(&mesh, &law, free(&mesh), Vec::new(), forces);
        [k, sums(&averaged.cell_errors(&mesh, &U))[0]]
    };
    let [[k, square], [larger_k, larger]] = [0.3, 0.45].map(of);
    let expected = (larger_k - k) / (18.0 * (n * n) as f64);
    let ratio = (larger - square) / expected;
    // cells along the sides have nodes with a mean of their own
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
}

/// Where there are fewer cells than a fit needs, it has a lower degree.
#[test]
fn few_cells_are_fitted_as_far_as_they_can() {
    let one = |order: Order| {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mesh = Mesh::<2>::new(nodes, vec![0, 1, 2]).expect("a cell");
        match order {
            Order::Linear => mesh,
            Order::Quadratic => mesh.quadratic(),
        }
    };
    for mesh in [one(Order::Linear), one(Order::Quadratic)] {
        let U = field(&mesh, |X| wave(X).0);
        let found = match mesh.order() {
            Order::Linear => errors::<2, P1>(&mesh, &U),
            Order::Quadratic => errors::<2, P2>(&mesh, &U),
        };
        let [square, energy] = sums(&found);
        // one gradient, or a linear one: the fit is that of the cell
        assert!(square < 1e-24 * energy, "{square:e} of {energy:e}");
    }
}

/// d : A : d is the second derivative of ψ along d.
#[test]
fn squares_are_second_differences_of_the_law() {
    use super::super::Cartesian;
    use crate::material::{Deformation, Material};

    let law = NeoHookean::new(10.0, 0.3).expect("a law");
    let F = Matrix::<3>::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.2);
    let d = Matrix::<3>::new(0.3, -0.6, 0.2, 0.8, 0.1, -0.4, 0.5, 0.7, -0.9);
    let at = |t: f64| law.energy_density(&Deformation::new(F + d * t));
    let h = 1e-4;
    let expected = (at(h) - 2.0 * at(0.0) + at(-h)) / (h * h);
    let here = Deformation::new(F);
    let found = <Cartesian as Kinematics<3, P1, NeoHookean>>::square(&law, &here, &d);
    assert!(
        (found - expected).abs() < 1e-6 * expected.abs(),
        "{found} for {expected}"
    );
}
