//! Laws of bodies, without the types of element and material.

use super::Body;
use crate::assembly::{
    AveragedVolume, BodyEnergy, Laws, QuadraticEnergy, StrainEnergy, add_body_force,
};
use crate::element::{Element, Order, P1};
use crate::material::{Deformation, Material, Volumetric, conformance};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector, unit_vector};

/// Of a law that varies from point to point, about so many are checked.
const SAMPLED: usize = 1000;

/// Erases the types of element and material.
pub(super) trait Law<const D: usize>: Send + Sync {
    fn is_small_strain(&self) -> bool;
    fn locks(&self) -> bool;
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

pub(super) struct ElasticLaw<E, M>(pub E, pub Laws<M>);

/// The same with averaged changes of volume.
pub(super) struct AveragedLaw<M>(pub M);

/// See [`Body::rest_moduli`].
fn rest_moduli<const D: usize>(law: &impl Material<D>) -> (f64, f64) {
    let rest = Deformation::new(Matrix::identity());
    let contraction = law.contraction(&rest);
    let along = |axis: usize| {
        let e = unit_vector(axis);
        contraction(&e, &e)[(0, 0)]
    };
    (along(1), along(0))
}

/// The same of several laws.
pub(super) fn rest_moduli_of<const D: usize>(laws: &[impl Material<D>]) -> (f64, f64) {
    let mut all = laws.iter().map(rest_moduli);
    let first = all.next().unwrap_or((f64::NAN, f64::NAN));
    all.fold(first, |(shear, longitudinal), own| {
        let ratio = (longitudinal / shear).max(own.1 / own.0);
        let softer = shear.min(own.0);
        (softer, softer * ratio)
    })
}

/// See [`Body::law_slopes`].
pub(super) fn slopes_of<const D: usize>(laws: &[impl Material<D>]) -> [f64; 2] {
    let sampled = laws.iter().step_by(laws.len().div_ceil(SAMPLED));
    let nan_max = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    sampled
        .map(conformance::slopes)
        .fold([0.0; 2], |worst, own| {
            std::array::from_fn(|k| nan_max(own[k], worst[k]))
        })
}

impl<const D: usize, E: Element<D>, M: Material<D>> Law<D> for ElasticLaw<E, M> {
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

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let (dofs, prescribed) = body.eliminated();
        let (mesh, forces) = (&body.mesh, body.forces.clone());
        let energy = StrainEnergy::<D, E, M>::with_laws(mesh, &self.1, dofs, prescribed, forces);
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

impl<const D: usize, M: Volumetric<D>> Law<D> for AveragedLaw<M>
where
    P1: Element<D>,
{
    fn is_small_strain(&self) -> bool {
        M::QUADRATIC
    }

    fn locks(&self) -> bool {
        false
    }

    fn rest_moduli(&self) -> (f64, f64) {
        rest_moduli(&self.0)
    }

    fn slopes(&self) -> [f64; 2] {
        conformance::slopes(&self.0)
    }

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let (dofs, prescribed) = body.eliminated();
        let forces = body.forces.clone();
        Box::new(AveragedVolume::new(
            &body.mesh, &self.0, dofs, prescribed, forces,
        ))
    }

    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    ) {
        add_body_force::<D, P1>(mesh, force, forces);
    }
}
