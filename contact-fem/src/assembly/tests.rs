//! Energies of meshes: values kept between evaluations do not affect the results.

use super::*;
use crate::element::{Element, P1, P2};
use crate::material::{Deformation, LinearElastic, Material, NeoHookean};
use crate::mesh::generators::{Diagonals, linspace, rectangle};

fn square(n: usize) -> Mesh<2> {
    let xs = linspace(0.0, 1.0, n + 1);
    rectangle(&xs, &xs, Diagonals::Alternating).expect("valid")
}

/// A square held on the left and pulled down on the right, at full load.
fn cantilever<E: Element<2>, M: Material<2>>(mesh: &Mesh<2>, law: M) -> StrainEnergy<2, E, M> {
    let dofs = 2 * mesh.nodes().len();
    let (mut held, mut forces) = (vec![false; dofs], vec![0.0; dofs]);
    for a in mesh.boundary_nodes("left").expect("named") {
        (held[2 * a], held[2 * a + 1]) = (true, true);
    }
    for a in mesh.boundary_nodes("right").expect("named") {
        forces[2 * a + 1] = -3.0;
    }
    let dofs = DofMap::new(&held);
    let prescribed = (0..dofs.prescribed()).map(|k| 0.001 * k as f64).collect();
    let mut energy = StrainEnergy::new(mesh, law, dofs, prescribed, forces);
    energy.set_load(1.0);
    energy
}

fn waves(n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|k| size * (1.0 + k as f64).sin()).collect()
}

/// Domain, value, gradient and Hessian as one vector.
fn all(energy: &dyn Energy, u: &[f64]) -> Vec<f64> {
    let (mut d, mut g) = (vec![0.0; energy.domain_len()], vec![0.0; energy.dofs()]);
    let mut values = vec![0.0; energy.hessian_pattern().len()];
    energy.domain(u, &mut d);
    energy.gradient(u, &mut g);
    energy.hessian(u, &mut values);
    [d, g, values, vec![energy.value(u)]].concat()
}

/// Earlier evaluations have no effect: at another u, other loads, an inadmissible u.
#[test]
fn evaluations_depend_on_nothing_before() {
    let mesh = square(3).quadratic();
    let law = NeoHookean::new(1000.0, 0.3).expect("valid");
    let fresh = || cantilever::<P2, _>(&mesh, law);
    let mut energy = fresh();
    let n = energy.dofs();
    let [u, v, folded] = [0.004, 0.008, 3.0].map(|size| waves(n, size));
    let (at_u, at_v) = (all(&fresh(), &u), all(&fresh(), &v));
    assert!(at_u.iter().chain(&at_v).all(|value| value.is_finite()));
    assert!(all(&energy, &u) == at_u);
    assert!(all(&energy, &v) == at_v);
    assert_eq!(energy.value(&folded), f64::INFINITY);
    assert_eq!(energy.value(&u), at_u[at_u.len() - 1]);
    energy.set_load(0.5);
    let mut half = fresh();
    half.set_load(0.5);
    let at_half = all(&energy, &u);
    assert!(at_half == all(&half, &u) && at_half != at_u);
    assert_eq!(energy.value(&vec![f64::NAN; n]), f64::INFINITY);
    energy.set_load(1.0);
    assert!(all(&energy, &u) == at_u);
}

/// On a quadratic cell under u = (a x², 0), J = 1 + 2 a x at every quadrature point.
#[test]
fn volume_ratios_of_all_points() {
    let nodes = vec![
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [0.5, 0.0],
        [0.5, 0.5],
        [0.0, 0.5],
    ];
    let mesh = Mesh::of_order(crate::element::Order::Quadratic, nodes, (0..6).collect());
    let mesh = mesh.expect("one cell");
    let law = NeoHookean::new(1000.0, 0.3).expect("valid");
    let dofs = DofMap::new(&[false; 12]);
    let energy = StrainEnergy::<2, P2, _>::new(&mesh, law, dofs, Vec::new(), vec![0.0; 12]);
    let a = 0.2;
    let u: Vec<f64> = mesh
        .nodes()
        .iter()
        .flat_map(|X| [a * X[0] * X[0], 0.0])
        .collect();
    let points = <P2 as Element<2>>::QUADRATURE;
    let mut J = vec![0.0; energy.domain_len()];
    energy.domain(&u, &mut J);
    assert_eq!(J.len(), points.len());
    for (J, (_, xi)) in J.iter().zip(points) {
        // the cell is the reference cell
        assert!((J - (1.0 + 2.0 * a * xi[0])).abs() < 1e-14, "{J} at {xi:?}");
    }
}

/// A square under u = ε (X, 0), half of whose load is set: its residual is that of the strain, less half
/// of the forces.
#[test]
fn residuals_have_the_present_load() {
    let mesh = square(2);
    let law = LinearElastic::new(3.0, 0.0).expect("valid");
    let forces: Vec<f64> = (0..2 * mesh.nodes().len()).map(|k| k as f64).collect();
    let dofs = DofMap::new(&vec![false; forces.len()]);
    let mut energy = StrainEnergy::<2, P1, _>::new(&mesh, law, dofs, Vec::new(), forces.clone());
    energy.set_load(0.5);
    let epsilon = 0.01;
    let u: Vec<f64> = mesh
        .nodes()
        .iter()
        .flat_map(|X| [epsilon * X[0], 0.0])
        .collect();
    let mut residual = vec![0.0; forces.len()];
    energy.add_residual(&u, &mut residual);
    for (a, X) in mesh.nodes().iter().enumerate() {
        // E ε on the sides x = 0 and x = 1, of three facets each, half of a facet's at their ends
        let share = if X[1] == 0.0 || X[1] == 1.0 {
            1.0 / 6.0
        } else {
            1.0 / 3.0
        };
        let pull = match X[0] {
            0.0 => -3.0 * epsilon * share,
            1.0 => 3.0 * epsilon * share,
            _ => 0.0,
        };
        let expected = [pull - 0.5 * forces[2 * a], -0.5 * forces[2 * a + 1]];
        for i in 0..2 {
            assert!((residual[2 * a + i] - expected[i]).abs() < 1e-14, "{a} {i}");
        }
    }
}

/// Second derivatives of the energy are differences of its gradient, for a law whose tangent is not
/// that at rest, on cells whose nodes are in any order.
fn hessian_is_the_difference_of_gradients<E: Element<2>>(mesh: &Mesh<2>) {
    let energy = cantilever::<E, _>(mesh, NeoHookean::new(1000.0, 0.3).expect("valid"));
    let n = energy.dofs();
    let u = waves(n, 0.01);
    let mut values = vec![0.0; energy.hessian_pattern().len()];
    energy.hessian(&u, &mut values);
    let mut full = vec![0.0; n * n];
    for ((i, j), value) in energy.hessian_pattern().iter().zip(values) {
        (full[n * i + j], full[n * j + i]) = (value, value);
    }
    let gradient = |j: usize, step: f64| {
        let (mut moved, mut g) = (u.clone(), vec![0.0; n]);
        moved[j] += step;
        energy.gradient(&moved, &mut g);
        g
    };
    let step = 1e-6;
    for j in 0..n {
        for (i, (a, b)) in gradient(j, step).iter().zip(gradient(j, -step)).enumerate() {
            let difference = (a - b) / (2.0 * step);
            assert!((full[n * i + j] - difference).abs() < 1e-3, "{i} {j}");
        }
    }
}

#[test]
fn hessians_are_differences_of_gradients() {
    hessian_is_the_difference_of_gradients::<P1>(&square(3));
    hessian_is_the_difference_of_gradients::<P2>(&square(2).quadratic());
}

/// A square that moves as a whole by t (2, −3), partly prescribed and partly free, under forces t f: the
/// energy is −t² times the work of f on the way.
#[test]
fn the_energy_has_the_work_on_all_dofs() {
    let mesh = square(2);
    let n = mesh.nodes().len();
    let held: Vec<bool> = (0..2 * n).map(|k| k % 3 == 0).collect();
    let forces: Vec<f64> = (0..2 * n).map(|k| 1.0 + k as f64).collect();
    let way = |dof: usize| if dof % 2 == 0 { 2.0 } else { -3.0 };
    let of = |held_ones: bool| {
        let dofs = (0..2 * n).filter(|k| held[*k] == held_ones);
        dofs.map(way).collect::<Vec<f64>>()
    };
    let work: f64 = (0..2 * n).map(|k| forces[k] * way(k)).sum();
    let law = NeoHookean::new(1000.0, 0.3).expect("valid");
    let dofs = DofMap::new(&held);
    let mut energy = StrainEnergy::<2, P1, _>::new(&mesh, law, dofs, of(true), forces);
    for t in [0.5, 1.0] {
        energy.set_load(t);
        let u: Vec<f64> = of(false).iter().map(|way| t * way).collect();
        let value = energy.value(&u);
        assert!((value + t * t * work).abs() < 1e-9, "{t}: {value}");
    }
}

/// With one free node in the middle, the cells around it are assembled, and no others. Its stiffness is
/// the second difference of the energy.
#[test]
fn cells_around_a_single_free_node_are_assembled() {
    let mesh = square(3);
    let middle = mesh.nodes().iter().position(|X| X[0] > 0.2 && X[1] > 0.2);
    let middle = middle.expect("inside");
    let held: Vec<bool> = (0..2 * mesh.nodes().len())
        .map(|k| k / 2 != middle)
        .collect();
    let dofs = DofMap::new(&held);
    let prescribed = vec![0.0; dofs.prescribed()];
    let law = LinearElastic::new(3.0, 0.0).expect("valid");
    let forces = vec![0.0; held.len()];
    let energy = StrainEnergy::<2, P1, _>::new(&mesh, law, dofs, prescribed, forces);
    let around = mesh.cells().filter(|cell| cell.contains(&middle)).count();
    assert_eq!(energy.assembled_cells(), around);
    let second = |i: usize| {
        let mut u = vec![0.0; 2];
        u[i] = 1.0;
        2.0 * energy.value(&u)
    };
    let larger = second(0).max(second(1));
    assert!((energy.typical_stiffness() - larger).abs() < 1e-12);
}

/// The median of the diagonal of ∇²E, of a strip whose cells become stiffer along it.
#[test]
fn the_typical_stiffness_is_a_median() {
    let xs = [0.0, 1.0, 1.5, 1.7, 1.75, 1.76];
    let mesh = rectangle(&xs, &[0.0, 1.0], Diagonals::Rising).expect("valid");
    let law = LinearElastic::new(3.0, 0.0).expect("valid");
    let n = 2 * mesh.nodes().len();
    let dofs = DofMap::new(&vec![false; n]);
    let energy = StrainEnergy::<2, P1, _>::new(&mesh, law, dofs, Vec::new(), vec![0.0; n]);
    let second = |i: usize| {
        let mut u = vec![0.0; n];
        u[i] = 1.0;
        2.0 * energy.value(&u)
    };
    let mut all: Vec<f64> = (0..n).map(second).collect();
    all.sort_by(f64::total_cmp);
    let found = energy.typical_stiffness();
    // as many are smaller as are larger
    assert!(all[n / 2 - 1] - 1e-9 <= found && found <= all[n / 2] + 1e-9);
    assert!(all[n - 1] > 2.0 * found);
}

/// On the quadratic cell X = ξ (1 + a ξ), Y = η, the field u = ξ² has the mean slope
/// ∫ 2 ξ dξ dη / ∫ (1 + 2 a ξ) dξ dη = ⅓ / (½ + a/3).
#[test]
fn means_over_curved_cells_are_weighted_with_volume() {
    let xi = [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [0.5, 0.0],
        [0.5, 0.5],
        [0.0, 0.5],
    ];
    let a = 0.4;
    let nodes = xi.map(|[x, y]| [x * (1.0 + a * x), y]).to_vec();
    let mesh = Mesh::of_order(crate::element::Order::Quadratic, nodes, (0..6).collect());
    let mesh = mesh.expect("one cell");
    let law = NeoHookean::new(1000.0, 0.3).expect("valid");
    let dofs = DofMap::new(&[false; 12]);
    let energy = StrainEnergy::<2, P2, _>::new(&mesh, law, dofs, Vec::new(), vec![0.0; 12]);
    let U: Vec<Vector<2>> = xi
        .iter()
        .map(|[x, _]| Vector::<2>::new(x * x, 0.0))
        .collect();
    let states = energy.cell_states(&mesh, &U);
    let expected = 1.0 + 1.0 / 3.0 / (0.5 + a / 3.0);
    assert!((states[0].J - expected).abs() < 1e-13, "{}", states[0].J);
}

/// A law that panics if the stretch of its first component is too large.
#[derive(Clone)]
struct Panics(NeoHookean);

impl Material<2> for Panics {
    const QUADRATIC: bool = false;
    const NEEDS_POSITIVE_J: bool = true;
    fn energy_density(&self, at: &Deformation<2>) -> f64 {
        assert!(at.F[(0, 0)] < 1.5, "out of the law's range");
        self.0.energy_density(at)
    }
    fn stress(&self, at: &Deformation<2>) -> Matrix<2> {
        self.0.stress(at)
    }
    fn contraction(&self, at: &Deformation<2>) -> impl Fn(&Vector<2>, &Vector<2>) -> Matrix<2> {
        self.0.contraction(at)
    }
    fn cauchy_stress(&self, at: &Deformation<2>) -> (Matrix<2>, f64) {
        self.0.cauchy_stress(at)
    }
}

#[test]
fn a_law_that_panics_leaves_a_usable_energy() {
    let law = NeoHookean::new(1000.0, 0.3).expect("valid");
    let energy = cantilever::<P1, _>(&square(3), Panics(law));
    let [u, stretched] = [0.004, 3.0].map(|size| waves(energy.dofs(), size));
    let panicked =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| energy.value(&stretched)));
    assert!(panicked.is_err());
    let expected = all(&cantilever::<P1, _>(&square(3), law), &u);
    assert!(all(&energy, &u) == expected);
}

/// A linear law with stress and energy at rest.
#[derive(Clone)]
struct Prestressed(LinearElastic);

impl Material<2> for Prestressed {
    const QUADRATIC: bool = true;
    const NEEDS_POSITIVE_J: bool = false;

    fn energy_density(&self, at: &Deformation<2>) -> f64 {
        7.0 + 20.0 * (at.F.trace() - 2.0) + self.0.energy_density(at)
    }
    fn stress(&self, at: &Deformation<2>) -> Matrix<2> {
        20.0 * Matrix::identity() + self.0.stress(at)
    }
    fn contraction(&self, at: &Deformation<2>) -> impl Fn(&Vector<2>, &Vector<2>) -> Matrix<2> {
        self.0.contraction(at)
    }
    fn cauchy_stress(&self, at: &Deformation<2>) -> (Matrix<2>, f64) {
        self.0.cauchy_stress(at)
    }
}

#[test]
fn a_quadratic_energy_is_its_strain_energy() {
    let mesh = square(4);
    let law = Prestressed(LinearElastic::new(1000.0, 0.3).expect("valid"));
    let mut elastic = cantilever::<P1, _>(&mesh, law.clone());
    let mut quadratic = QuadraticEnergy::new(cantilever::<P1, _>(&mesh, law));
    for load in [1.0, 0.4, 0.0] {
        elastic.set_load(load);
        quadratic.set_load(load);
        let u = waves(elastic.dofs(), 0.1);
        let (expected, found) = (all(&elastic, &u), all(&quadratic, &u));
        let size = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        assert_eq!(expected.len(), found.len());
        let mut pairs = expected.iter().zip(found);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-13 * size), "{load}");
    }
}

/// For each dof of a square, whether it is prescribed: x on all of the boundary, y on the left and
/// the right.
fn supports(mesh: &Mesh<2>) -> DofMap {
    let mut taken = vec![false; 2 * mesh.nodes().len()];
    for (side, both) in [
        ("left", true),
        ("right", true),
        ("bottom", false),
        ("top", false),
    ] {
        for a in mesh.boundary_nodes(side).expect("named") {
            taken[2 * a] = true;
            taken[2 * a + 1] |= both;
        }
    }
    DofMap::new(&taken)
}

/// The values of a nodal field at the prescribed dofs.
fn at_supports(supports: &DofMap, field: &[f64]) -> Vec<f64> {
    let prescribed = |dof: &usize| matches!(supports.get(*dof), Dof::Prescribed(_));
    (0..field.len())
        .filter(prescribed)
        .map(|dof| field[dof])
        .collect()
}

/// v_x = 1 + 2x − y, prescribed on all of the boundary, and v_y = 3x − 1, which has no flux through
/// bottom and top, are harmonic.
#[test]
fn harmonic_fields_are_their_own_extension() {
    let law = NeoHookean::new(1.0, 0.0).expect("valid");
    for mesh in [square(5), square(3).quadratic()] {
        let energy: Box<dyn BodyEnergy<2>> = match mesh.order() {
            crate::element::Order::Linear => Box::new(cantilever::<P1, _>(&mesh, law)),
            crate::element::Order::Quadratic => Box::new(cantilever::<P2, _>(&mesh, law)),
        };
        let field = |x: &Vector<2>| [1.0 + 2.0 * x[0] - x[1], 3.0 * x[0] - 1.0];
        let field: Vec<f64> = mesh.nodes().iter().flat_map(field).collect();
        let supports = supports(&mesh);
        // the factors of the first increment are reused for the others
        for factor in [1.0, -0.5, 0.0, 1e-3] {
            let values: Vec<f64> = at_supports(&supports, &field)
                .iter()
                .map(|v| factor * v)
                .collect();
            let extended = energy.extend(&supports, &values);
            assert!(
                extended
                    .iter()
                    .zip(&field)
                    .all(|(v, f)| (v - factor * f).abs() < 1e-13)
            );
        }
        // other supports: y is prescribed nowhere and stays; x as before
        let mut taken = vec![false; field.len()];
        (0..mesh.nodes().len())
            .for_each(|a| taken[2 * a] = matches!(supports.get(2 * a), Dof::Prescribed(_)));
        let others = DofMap::new(&taken);
        let extended = energy.extend(&others, &at_supports(&others, &field));
        for (k, (v, f)) in extended.iter().zip(&field).enumerate() {
            let expected = if k % 2 == 0 { *f } else { 0.0 };
            assert!((v - expected).abs() < 1e-13);
        }
    }
}
