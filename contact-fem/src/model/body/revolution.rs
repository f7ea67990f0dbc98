//! Bodies of revolution.

use std::sync::Arc;

use super::Body;
use super::law::{Law, rest_moduli_of, slopes_of};
use crate::assembly::{
    BodyEnergy, Laws, QuadraticEnergy, Revolution, StrainEnergy, add_body_force,
};
use crate::element::{Element, Order, P1, RingP2};
use crate::error::Error;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// A law of space in a body of revolution.
struct RevolvedLaw<E, M>(E, Laws<M>);

/// Bodies of revolution about the axis r = 0: the mesh is the half of their section with r = x₁ ≥ 0, z = x₂ is the height, and
/// displacements are (u_r, u_z); nothing is twisted.
impl Body<2> {
    /// A body of revolution of a law of space. Its elements have the order of its mesh.
    ///
    /// The law takes F with the stretch 1 + u_r/R around the axis; it must be isotropic, or have the half-plane as a plane of
    /// symmetry. Nodes with r = 0 are held there, u_r = 0.
    ///
    /// Energies, volumes and all forces are those of the whole circumference, 2π: tractions, pressures and body forces are
    /// per area and per volume and are integrated with 2πR; a force on a node ([`Body::nodal_force`]) is the total on its
    /// circle; reactions and contact forces are such totals as well. Their components along z are resultants; those along r point
    /// away from the axis all around, add up to nothing, and tell how much a ring is pushed in all. Rows of contact are gaps
    /// weighted with 2πR, multipliers are forces, and pressures are per area. Obstacles are profiles in the half-plane, such as a
    /// plane z = c, a ball with its centre on the axis or a cylinder about it.
    ///
    /// All bodies of a scene are of revolution, or none is. The one rigid motion is that along the axis.
    ///
    /// A thick tube under a pressure inside, whose ends do not move along the axis, by Lamé:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let section = rectangle(&linspace(1.0, 2.0, 32), &[0.0, 0.1], Diagonals::Rising)?.quadratic();
    /// let mut tube = Body::of_revolution(section, LinearElastic::new(100.0, 0.25)?)?;
    /// tube.symmetry("bottom")?.symmetry("top")?.pressure("left", 3.0)?;
    /// let mut scene = Scene::new();
    /// scene.add("tube", tube);
    /// let mut problem = scene.problem()?;
    /// let history = Simulation::with_increments(1).run(&mut problem)?;
    /// // p a² (1 + ν)/E/(b² − a²) ((1 − 2ν) r + b²/r) at r = a
    /// let lame = 3.0 * 1.25 / 100.0 / 3.0 * (0.5 + 4.0);
    /// let solution = history.run.solution.expect("a solution");
    /// let inside = problem.displacements(&solution.state.u)[0][0];
    /// assert!((inside / lame - 1.0).abs() < 1e-5);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Error::NegativeRadius`]: a node with r < 0 by more than round-off.
    pub fn of_revolution(mesh: Mesh<2>, law: impl Material<3>) -> Result<Self, Error> {
        Self::revolved(mesh, |_| Ok(law.into()))
    }

    /// As [`Body::of_revolution`], with regions of laws of their own, as [`Body::with_laws`].
    ///
    /// # Errors
    /// As [`Body::of_revolution`]; a region that does not exist, and a cell in none of them or in several.
    pub fn of_revolution_with_laws<M: Material<3>>(
        mesh: Mesh<2>,
        laws: impl IntoIterator<Item = (impl AsRef<str>, M)>,
    ) -> Result<Self, Error> {
        Self::revolved(mesh, |mesh| match mesh.order() {
            Order::Linear => Laws::of_regions::<2, P1>(mesh, laws),
            Order::Quadratic => Laws::of_regions::<2, RingP2>(mesh, laws),
        })
    }

    /// As [`Body::of_revolution`], with a law that varies with the reference position (r, z) (UL), as [`Body::graded`].
    ///
    /// # Errors
    /// As [`Body::of_revolution`]; those of `law`.
    pub fn of_revolution_graded<M: Material<3>>(
        mesh: Mesh<2>,
        law: impl Fn(&Vector<2>) -> Result<M, Error>,
    ) -> Result<Self, Error> {
        Self::revolved(mesh, |mesh| match mesh.order() {
            Order::Linear => Laws::graded::<2, P1>(mesh, law),
            Order::Quadratic => Laws::graded::<2, RingP2>(mesh, law),
        })
    }

    fn revolved<M: Material<3>>(
        mesh: Mesh<2>,
        laws: impl FnOnce(&Mesh<2>) -> Result<Laws<M>, Error>,
    ) -> Result<Self, Error> {
        let (mesh, axis) = mesh.revolved()?;
        let laws = laws(&mesh)?;
        let law: Arc<dyn Law<2>> = match mesh.order() {
            Order::Linear => Arc::new(RevolvedLaw(P1, laws)),
            Order::Quadratic => Arc::new(RevolvedLaw(RingP2, laws)),
        };
        let mut body = Body::of(mesh, law);
        if !axis.is_empty() {
            body.hold(("nodes on the axis", &axis), [Some(0.0), None], 0)?;
        }
        Ok(body)
    }

    /// The reference volume of a body of revolution (UL³), and of a body of the plane its area (UL²).
    pub fn volume(&self) -> f64 {
        self.mesh.revolved_volume()
    }
}

impl<E: Element<2>, M: Material<3>> Law<2> for RevolvedLaw<E, M> {
    fn is_small_strain(&self) -> bool {
        M::QUADRATIC
    }

    fn locks(&self) -> bool {
        E::ORDER == Order::Linear
    }

    fn rest_moduli(&self) -> (f64, f64) {
        rest_moduli_of(self.1.all())
    }

    fn slopes(&self) -> [f64; 2] {
        slopes_of(self.1.all())
    }

    fn energy(&self, body: &Body<2>) -> Box<dyn BodyEnergy<2>> {
        let (dofs, prescribed) = body.eliminated();
        let (mesh, forces) = (&body.mesh, body.forces.clone());
        let energy = StrainEnergy::<2, E, M, Revolution>::with_kinematics(
            mesh, &self.1, dofs, prescribed, forces,
        );
        match M::QUADRATIC {
            true => Box::new(QuadraticEnergy::new(energy)),
            false => Box::new(energy),
        }
    }

    fn add_body_force(
        &self,
        mesh: &Mesh<2>,
        force: &dyn Fn(&Vector<2>) -> Vector<2>,
        forces: &mut [f64],
    ) {
        add_body_force::<2, E>(mesh, force, forces);
    }
}
