//! How displacements of nodes deform a body: in its own space, or as one of revolution.

use std::f64::consts::TAU;

use super::CellState;
use crate::element::Element;
use crate::material::{Deformation, Material};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector, determinant, inverse_transpose, unit_vector};

/// The map from displacements of a cell's nodes to the deformation that a law `M` takes, and from its stress to nodal forces.
pub trait Kinematics<const D: usize, E: Element<D>, M>: Send + Sync + 'static {
    /// What a quadrature point is in the reference configuration.
    type Point: Send + Sync;
    /// The deformation at a point, as the law takes it.
    type At: Copy + Send + Sync;
    /// [`Material::QUADRATIC`] of the law.
    const QUADRATIC: bool;
    /// [`Material::NEEDS_POSITIVE_J`] of the law.
    const NEEDS_POSITIVE_J: bool;

    /// The points of a rule, (weight, ξ), in one cell.
    fn points_in(
        mesh: &Mesh<D>,
        cell: &E::PerNode<usize>,
        rule: &[(f64, [f64; D])],
    ) -> impl Iterator<Item = Self::Point>;
    /// The quadrature points of one cell.
    fn points(mesh: &Mesh<D>, cell: &E::PerNode<usize>) -> impl Iterator<Item = Self::Point> {
        Self::points_in(mesh, cell, E::QUADRATURE)
    }
    /// The weight of a point times the reference volume (UL², or UL³ in space and of revolution).
    fn weight(point: &Self::Point) -> f64;
    /// ∂N_a/∂X there (1/UL).
    fn gradients(point: &Self::Point) -> &E::PerNode<Vector<D>>;
    /// The undeformed state.
    fn rest() -> Self::At;
    /// The deformation there at the displacements of the cell's nodes (UL).
    fn at(point: &Self::Point, local: &E::PerNode<Vector<D>>) -> Self::At;
    /// The same for a quadratic law, which needs F alone.
    fn at_for_quadratic(point: &Self::Point, local: &E::PerNode<Vector<D>>) -> Self::At;
    /// J = det F.
    fn volume_ratio(at: &Self::At) -> f64;
    /// ψ (UF/UL²).
    fn energy_density(law: &M, at: &Self::At) -> f64;
    /// d : A : d of a change d of the displacements' gradient (UF/UL²); a radius does not change.
    fn square(law: &M, at: &Self::At, d: &Matrix<D>) -> f64;
    /// The point's share of the internal forces at the nodes (UF).
    fn forces(law: &M, at: &Self::At, point: &Self::Point) -> E::PerNode<Vector<D>>;
    /// Adds the point's share of the stiffness K_ab with b ≤ a (UF/UL).
    fn add_stiffness(
        law: &M,
        at: &Self::At,
        point: &Self::Point,
        blocks: &mut E::PerNode<E::PerNode<Matrix<D>>>,
    );
    /// Stress and volume ratio at the mean of the deformations of a cell's points.
    fn state(
        law: &M,
        points: impl Iterator<Item = Self::Point>,
        local: &E::PerNode<Vector<D>>,
    ) -> CellState<D>;
    /// E/(1 − ν²) of a law at zero strain (UF/UL²).
    fn contact_modulus(law: &M) -> f64;
}

/// Bodies in space, and sections of prismatic bodies in the plane: F = I + Σ_a u_a ⊗ ∇N_a.
#[derive(Clone, Copy, Debug)]
pub struct Cartesian;

/// Bodies of revolution, meshed in the half-plane of radius r ≥ 0 and height z, that are not twisted: a law of space takes
/// F = diag(I + Σ_a u_a ⊗ ∇N_a, 1 + u_r/R) in the axes r, z and around, and a point weighs 2πR.
#[derive(Clone, Copy, Debug)]
pub struct Revolution;

/// One quadrature point: its weight times reference volume, and ∂N_a/∂X.
#[derive(Clone, Copy)]
pub struct Point<const D: usize, E: Element<D>> {
    pub(super) weight: f64,
    pub(super) gradients: E::PerNode<Vector<D>>,
}

impl<const D: usize, E: Element<D>> Point<D, E> {
    /// F = I + Σ_a u_a ⊗ ∇N_a.
    pub(super) fn deformation(&self, local: &E::PerNode<Vector<D>>) -> Matrix<D> {
        let mut F = Matrix::<D>::identity();
        for (v, dN) in local.as_ref().iter().zip(self.gradients.as_ref()) {
            F.ger(1.0, v, dN, 1.0);
        }
        F
    }
}

pub(super) fn nodes_of<const D: usize, E: Element<D>>(cell: &[usize]) -> E::PerNode<usize> {
    let mut nodes = E::per_node(0);
    nodes.as_mut().copy_from_slice(cell);
    nodes
}

/// The points of a rule in one cell: ∂N/∂X = (∂X/∂ξ)⁻ᵀ ∂N/∂ξ.
pub(super) fn points_of<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    cell: &E::PerNode<usize>,
    rule: &[(f64, [f64; D])],
) -> impl Iterator<Item = Point<D, E>> {
    rule.iter().map(move |&(weight, xi)| {
        let mut gradients = E::shape_gradients(&Vector::from(xi));
        let mut dX = Matrix::<D>::zeros();
        for (&a, dN) in cell.as_ref().iter().zip(gradients.as_ref()) {
            dX.ger(1.0, &mesh.nodes()[a], dN, 1.0);
        }
        let inverse = inverse_transpose(&dX);
        gradients
            .as_mut()
            .iter_mut()
            .for_each(|dN| *dN = inverse * *dN);
        Point {
            weight: weight * determinant(&dX),
            gradients,
        }
    })
}

/// d : A : d.
fn double_contraction<const L: usize>(
    law: &impl Material<L>,
    at: &Deformation<L>,
    d: &Matrix<L>,
) -> f64 {
    let A = law.contraction(at);
    let axis = |i: usize| unit_vector::<L>(i);
    let term = |j: usize, l: usize| d.column(j).dot(&(A(&axis(j), &axis(l)) * d.column(l)));
    // A is symmetric
    let pairs = (0..L).flat_map(|j| (0..j).map(move |l| (j, l)));
    let mixed: f64 = pairs.map(|(j, l)| term(j, l)).sum();
    (0..L).map(|j| term(j, j)).sum::<f64>() + 2.0 * mixed
}

/// E/(1 − ν²) from λ + 2μ and μ, of which it is made.
fn plate_modulus<const L: usize>(law: &impl Material<L>) -> f64 {
    let at = Deformation::new(Matrix::identity());
    let contraction = law.contraction(&at);
    let axis = |i: usize| unit_vector::<L>(i);
    let stretched = contraction(&axis(0), &axis(0))[(0, 0)];
    let sheared = contraction(&axis(1), &axis(1))[(0, 0)];
    4.0 * sheared * (stretched - sheared) / stretched
}

impl<const D: usize, E: Element<D>, M: Material<D>> Kinematics<D, E, M> for Cartesian {
    type Point = Point<D, E>;
    type At = Deformation<D>;
    const QUADRATIC: bool = M::QUADRATIC;
    const NEEDS_POSITIVE_J: bool = M::NEEDS_POSITIVE_J;

    fn points_in(
        mesh: &Mesh<D>,
        cell: &E::PerNode<usize>,
        rule: &[(f64, [f64; D])],
    ) -> impl Iterator<Item = Self::Point> {
        points_of::<D, E>(mesh, cell, rule)
    }

    fn weight(point: &Self::Point) -> f64 {
        point.weight
    }

    fn gradients(point: &Self::Point) -> &E::PerNode<Vector<D>> {
        &point.gradients
    }

    fn rest() -> Self::At {
        Deformation::new(Matrix::identity())
    }

    fn at(point: &Self::Point, local: &E::PerNode<Vector<D>>) -> Self::At {
        Deformation::new(point.deformation(local))
    }

    fn at_for_quadratic(point: &Self::Point, local: &E::PerNode<Vector<D>>) -> Self::At {
        Deformation::of_quadratic_law(point.deformation(local))
    }

    fn volume_ratio(at: &Self::At) -> f64 {
        at.J
    }

    fn energy_density(law: &M, at: &Self::At) -> f64 {
        law.energy_density(at)
    }

    fn square(law: &M, at: &Self::At, d: &Matrix<D>) -> f64 {
        double_contraction(law, at, d)
    }

    fn forces(law: &M, at: &Self::At, point: &Self::Point) -> E::PerNode<Vector<D>> {
        let P = law.stress(at) * point.weight;
        let mut forces = E::per_node(Vector::zeros());
        let nodes = forces.as_mut().iter_mut().zip(point.gradients.as_ref());
        nodes.for_each(|(force, dN)| *force = P * dN);
        forces
    }

    fn add_stiffness(
        law: &M,
        at: &Self::At,
        point: &Self::Point,
        blocks: &mut E::PerNode<E::PerNode<Matrix<D>>>,
    ) {
        let A = law.contraction(at);
        let dN = point.gradients.as_ref();
        for (a, row) in blocks.as_mut().iter_mut().enumerate() {
            for (b, block) in row.as_mut()[..=a].iter_mut().enumerate() {
                *block += A(&dN[a], &dN[b]) * point.weight;
            }
        }
    }

    fn state(
        law: &M,
        points: impl Iterator<Item = Self::Point>,
        local: &E::PerNode<Vector<D>>,
    ) -> CellState<D> {
        let mut mean = Matrix::zeros();
        let mut volume = 0.0;
        for point in points {
            mean += point.deformation(local) * point.weight;
            volume += point.weight;
        }
        let at = Deformation::new(mean / volume);
        let (sigma, sigma_zz) = law.cauchy_stress(&at);
        CellState {
            J: at.J,
            sigma,
            sigma_zz,
        }
    }

    fn contact_modulus(law: &M) -> f64 {
        plate_modulus(law)
    }
}

/// A quadrature point of a body of revolution: that of the half-plane, which weighs 2πR, and N_a/R.
#[derive(Clone, Copy)]
pub struct RingPoint<E: Element<2>> {
    section: Point<2, E>,
    around: E::PerNode<f64>,
}

impl<E: Element<2>> RingPoint<E> {
    /// F in the axes r, z and around.
    fn deformation(&self, local: &E::PerNode<Vector<2>>) -> Matrix<3> {
        let mut F = Matrix::<3>::identity();
        let section = self.section.deformation(local);
        F.fixed_view_mut::<2, 2>(0, 0).copy_from(&section);
        for (v, share) in local.as_ref().iter().zip(self.around.as_ref()) {
            F[(2, 2)] += v[0] * share;
        }
        F
    }
}

/// A vector of the half-plane in space.
fn in_space(v: &Vector<2>) -> Vector<3> {
    Vector::<3>::new(v[0], v[1], 0.0)
}

impl<E: Element<2>, M: Material<3>> Kinematics<2, E, M> for Revolution {
    type Point = RingPoint<E>;
    type At = Deformation<3>;
    const QUADRATIC: bool = M::QUADRATIC;
    const NEEDS_POSITIVE_J: bool = M::NEEDS_POSITIVE_J;

    fn points_in(
        mesh: &Mesh<2>,
        cell: &E::PerNode<usize>,
        rule: &[(f64, [f64; 2])],
    ) -> impl Iterator<Item = Self::Point> {
        let sections = points_of::<2, E>(mesh, cell, rule);
        sections.zip(rule).map(move |(mut section, &(_, xi))| {
            let mut around = E::shapes(&Vector::from(xi));
            let shapes = cell.as_ref().iter().zip(around.as_ref());
            let R: f64 = shapes.map(|(&a, N)| mesh.nodes()[a][0] * N).sum();
            section.weight *= TAU * R;
            around.as_mut().iter_mut().for_each(|N| *N /= R);
            RingPoint { section, around }
        })
    }

    fn weight(point: &Self::Point) -> f64 {
        point.section.weight
    }

    fn gradients(point: &Self::Point) -> &E::PerNode<Vector<2>> {
        &point.section.gradients
    }

    fn rest() -> Self::At {
        Deformation::new(Matrix::identity())
    }

    fn at(point: &Self::Point, local: &E::PerNode<Vector<2>>) -> Self::At {
        Deformation::new(point.deformation(local))
    }

    fn at_for_quadratic(point: &Self::Point, local: &E::PerNode<Vector<2>>) -> Self::At {
        Deformation::of_quadratic_law(point.deformation(local))
    }

    fn volume_ratio(at: &Self::At) -> f64 {
        at.J
    }

    fn energy_density(law: &M, at: &Self::At) -> f64 {
        law.energy_density(at)
    }

    fn square(law: &M, at: &Self::At, d: &Matrix<2>) -> f64 {
        let mut whole = Matrix::<3>::zeros();
        whole.fixed_view_mut::<2, 2>(0, 0).copy_from(d);
        double_contraction(law, at, &whole)
    }

    // P ∇N_a in the half-plane, and the stress around times N_a/R along r
    fn forces(law: &M, at: &Self::At, point: &Self::Point) -> E::PerNode<Vector<2>> {
        let P = law.stress(at) * point.section.weight;
        let section = P.fixed_view::<2, 2>(0, 0).into_owned();
        let mut forces = E::per_node(Vector::<2>::zeros());
        let nodes = forces.as_mut().iter_mut();
        let gradients = point.section.gradients.as_ref();
        for ((force, dN), share) in nodes.zip(gradients).zip(point.around.as_ref()) {
            *force = section * dN;
            force[0] += P[(2, 2)] * share;
        }
        forces
    }

    // with h_a = N_a/R: A : (∇N_a ⊗ ∇N_b) + h_a e_r ⊗ c_b + h_b c_a ⊗ e_r + h_a h_b A_3333 e_r ⊗ e_r, c_a,i = A_iJ33 ∂N_a/∂X_J
    fn add_stiffness(
        law: &M,
        at: &Self::At,
        point: &Self::Point,
        blocks: &mut E::PerNode<E::PerNode<Matrix<2>>>,
    ) {
        let A = law.contraction(at);
        let e = unit_vector::<3>(2);
        let hoop = A(&e, &e)[(2, 2)];
        let mut dN = E::per_node(Vector::<3>::zeros());
        let mut mixed = E::per_node(Vector::<2>::zeros());
        let gradients = point.section.gradients.as_ref().iter();
        for ((dN, mixed), gradient) in dN.as_mut().iter_mut().zip(mixed.as_mut()).zip(gradients) {
            *dN = in_space(gradient);
            *mixed = A(dN, &e).fixed_view::<2, 1>(0, 2).into_owned();
        }
        let (dN, mixed, h) = (dN.as_ref(), mixed.as_ref(), point.around.as_ref());
        for (a, row) in blocks.as_mut().iter_mut().enumerate() {
            for (b, block) in row.as_mut()[..=a].iter_mut().enumerate() {
                let whole = A(&dN[a], &dN[b]);
                let mut own = whole.fixed_view::<2, 2>(0, 0).into_owned();
                for i in 0..2 {
                    own[(0, i)] += h[a] * mixed[b][i];
                    own[(i, 0)] += h[b] * mixed[a][i];
                }
                own[(0, 0)] += h[a] * h[b] * hoop;
                *block += own * point.section.weight;
            }
        }
    }

    fn state(
        law: &M,
        points: impl Iterator<Item = Self::Point>,
        local: &E::PerNode<Vector<2>>,
    ) -> CellState<2> {
        let mut mean = Matrix::<3>::zeros();
        let mut volume = 0.0;
        for point in points {
            mean += point.deformation(local) * point.section.weight;
            volume += point.section.weight;
        }
        let at = Deformation::new(mean / volume);
        let (sigma, _) = law.cauchy_stress(&at);
        CellState {
            J: at.J,
            sigma: sigma.fixed_view::<2, 2>(0, 0).into_owned(),
            sigma_zz: sigma[(2, 2)],
        }
    }

    fn contact_modulus(law: &M) -> f64 {
        plate_modulus(law)
    }
}
