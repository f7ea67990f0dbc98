//! Bodies: mesh, material law, supports and loads.

use crate::assembly::{
    BodyEnergy, DofMap, QuadraticEnergy, StrainEnergy, add_body_force, add_traction,
};
use crate::element::{Element, Order, P1, P2};
use crate::error::Error;
use crate::material::{Deformation, Material, conformance};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector, unit_vector};

/// An elastic body: a mesh, a material law, prescribed displacements and loads.
///
/// ```
/// use contact_fem::mesh::generators::cuboid;
/// use contact_fem::{Body, NeoHookean};
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let beam = cuboid([0.0; 3], [4.0, 1.0, 1.0], [8, 2, 2])?;
/// let mut beam = Body::new(beam.quadratic(), NeoHookean::new(1000.0, 0.3)?);
/// beam.prescribe("left", [Some(0.0); 3])?;
/// beam.traction("right", [0.0, 0.0, -2.5])?;
///
/// // nodal forces have the resultant of the traction, on an area of 1, and its moment about X = (0, ½, ½)
/// let (mut force, mut moment) = ([0.0; 3], 0.0);
/// for (X, f) in beam.mesh().nodes().iter().zip(beam.forces().chunks(3)) {
///     force = [0, 1, 2].map(|i| force[i] + f[i]);
///     moment += X[0] * f[2] - (X[2] - 0.5) * f[0];
/// }
/// assert!(force[0].abs() + force[1].abs() + (force[2] + 2.5).abs() < 1e-12);
/// assert!((moment + 4.0 * 2.5).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub struct Body<const D: usize> {
    mesh: Mesh<D>,
    law: Box<dyn Law<D>>,
    /// The displacement prescribed for each dof at full load (UL), if any.
    prescribed: Vec<Option<f64>>,
    /// Nodal forces at full load (UF).
    forces: Vec<f64>,
}

impl<const D: usize> Body<D> {
    /// A body without supports and loads; its elements have the order of its mesh.
    pub fn new(mesh: Mesh<D>, material: impl Material<D>) -> Self
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let dofs = D * mesh.nodes().len();
        Body {
            law: match mesh.order() {
                Order::Linear => Box::new(ElasticLaw(P1, material)),
                Order::Quadratic => Box::new(ElasticLaw(P2, material)),
            },
            mesh,
            prescribed: vec![None; dofs],
            forces: vec![0.0; dofs],
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// Prescribes the displacement components (UL, at full load) of all nodes of a boundary;
    /// components that are `None` stay free.
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, a value is not finite, or a dof is prescribed twice with
    /// different values.
    pub fn prescribe(
        &mut self,
        boundary: &str,
        components: [Option<f64>; D],
    ) -> Result<&mut Self, Error> {
        let nodes = self.mesh.boundary_nodes(boundary)?;
        if nodes.is_empty() {
            return Err(Error::EmptyBoundary {
                name: boundary.to_string(),
                what: "support",
            });
        }
        self.prescribe_nodes(&nodes, components)
    }

    /// As [`Body::prescribe`], for every node of the body. The body then moves rigidly, and none of
    /// its cells is assembled.
    ///
    /// # Errors
    /// As [`Body::prescribe`].
    pub fn prescribe_all(&mut self, components: [Option<f64>; D]) -> Result<&mut Self, Error> {
        let nodes: Vec<usize> = (0..self.mesh.nodes().len()).collect();
        self.prescribe_nodes(&nodes, components)
    }

    /// As [`Body::prescribe`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe`], and if a node does not exist.
    pub fn prescribe_nodes(
        &mut self,
        nodes: &[usize],
        components: [Option<f64>; D],
    ) -> Result<&mut Self, Error> {
        let given = components.iter().flatten();
        Error::check_finite("prescribed displacement", given)?;
        let count = self.mesh.nodes().len();
        for &node in nodes {
            if node >= count {
                return Err(Error::Setting {
                    name: "node",
                    value: node as f64,
                    remedy: "name a node of this body's mesh",
                });
            }
            for (component, value) in components.iter().enumerate() {
                let Some(second) = *value else { continue };
                let slot = &mut self.prescribed[D * node + component];
                match *slot {
                    Some(first) if first != second => {
                        return Err(Error::Conflict {
                            node,
                            component,
                            first,
                            second,
                        });
                    }
                    _ => *slot = Some(second),
                }
            }
        }
        Ok(self)
    }

    /// Adds a dead traction (force per reference area, UF/UL in the plane, UF/UL² in space) on a
    /// boundary.
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, or a value is not finite.
    pub fn traction(&mut self, boundary: &str, traction: [f64; D]) -> Result<&mut Self, Error> {
        self.traction_field(boundary, |_| traction.into())
    }

    /// As [`Body::traction`], for a traction that depends on the reference position X.
    ///
    /// # Errors
    /// As [`Body::traction`].
    pub fn traction_field(
        &mut self,
        boundary: &str,
        traction: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<&mut Self, Error> {
        let facets = self.mesh.boundary(boundary)?;
        if facets.is_empty() {
            return Err(Error::EmptyBoundary {
                name: boundary.to_string(),
                what: "traction",
            });
        }
        let mut forces = vec![0.0; self.forces.len()];
        add_traction(&self.mesh, &facets, traction, &mut forces);
        self.add_forces("traction", &forces)
    }

    /// Adds a dead body force (force per reference volume, UF/UL² in the plane, UF/UL³ in space).
    ///
    /// # Errors
    /// If a value is not finite.
    pub fn body_force(&mut self, force: [f64; D]) -> Result<&mut Self, Error> {
        self.body_force_field(|_| force.into())
    }

    /// As [`Body::body_force`], for a force that depends on the reference position X.
    ///
    /// # Errors
    /// As [`Body::body_force`].
    pub fn body_force_field(
        &mut self,
        force: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<&mut Self, Error> {
        let mut forces = vec![0.0; self.forces.len()];
        self.law.add_body_force(&self.mesh, &force, &mut forces);
        self.add_forces("body force", &forces)
    }

    /// Adds the nodal forces of the load `name` if all of them are finite.
    fn add_forces(&mut self, name: &'static str, forces: &[f64]) -> Result<&mut Self, Error> {
        Error::check_finite(name, forces)?;
        let sums = self.forces.iter_mut().zip(forces);
        sums.for_each(|(sum, force)| *sum += force);
        Ok(self)
    }

    /// The displacement prescribed for each dof at full load (UL), if any.
    pub fn prescribed(&self) -> &[Option<f64>] {
        &self.prescribed
    }

    /// The nodal forces at full load (all dofs, UF).
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Whether the law is a small-strain law, that is linear in the displacement gradient.
    pub fn is_small_strain(&self) -> bool {
        self.law.is_small_strain()
    }

    /// How much the law's stress differs from the derivative of its energy, and its tangent from that of its stress, see
    /// [`conformance::slopes`].
    pub(super) fn law_slopes(&self) -> [f64; 2] {
        self.law.slopes()
    }

    /// The shear modulus and the modulus of stretching without lateral strain (UF/UL²) at rest, along the
    /// first two axes.
    pub(crate) fn rest_moduli(&self) -> (f64, f64) {
        self.law.rest_moduli()
    }

    /// For each dof, whether it is prescribed.
    pub(super) fn is_prescribed(&self) -> Vec<bool> {
        self.prescribed.iter().map(Option::is_some).collect()
    }

    /// The displacements prescribed at full load (UL), in ascending order of the dofs.
    pub(super) fn prescribed_values(&self) -> Vec<f64> {
        self.prescribed.iter().flatten().copied().collect()
    }

    /// The energy over the free dofs, at load factor 0.
    pub(super) fn energy(&self) -> Box<dyn BodyEnergy<D>> {
        self.law.energy(self)
    }
}

/// Erases the types of element and material.
trait Law<const D: usize>: Send + Sync {
    fn is_small_strain(&self) -> bool;
    fn rest_moduli(&self) -> (f64, f64);
    fn slopes(&self) -> [f64; 2];
    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>>;
    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    );
}

struct ElasticLaw<E, M>(E, M);

impl<const D: usize, E: Element<D>, M: Material<D>> Law<D> for ElasticLaw<E, M> {
    fn is_small_strain(&self) -> bool {
        M::QUADRATIC
    }

    fn rest_moduli(&self) -> (f64, f64) {
        let rest = Deformation::new(Matrix::identity());
        let contraction = self.1.contraction(&rest);
        let along = |axis: usize| {
            let e = unit_vector(axis);
            contraction(&e, &e)[(0, 0)]
        };
        (along(1), along(0))
    }

    fn slopes(&self) -> [f64; 2] {
        conformance::slopes(&self.1)
    }

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let dofs = DofMap::new(&body.is_prescribed());
        let prescribed = body.prescribed_values();
        let (law, forces) = (self.1.clone(), body.forces.clone());
        let energy = StrainEnergy::<D, E, M>::new(&body.mesh, law, dofs, prescribed, forces);
        match M::QUADRATIC {
            true => Box::new(QuadraticEnergy::new(energy)),
            false => Box::new(energy),
        }
    }

    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    ) {
        add_body_force::<D, E>(mesh, force, forces);
    }
}
