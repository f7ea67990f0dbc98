//! Dead loads.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::Body;
use super::supports::some;
use crate::assembly::add_traction;
use crate::error::Error;
use crate::model::courses::{Load, Origin};
use crate::program::{Amplitude, samples};
use crate::tensor::Vector;

/// A moment of inertia of a boundary below this share of the largest one is round-off.
const ALONG: f64 = 1e-9;

impl<const D: usize> Body<D> {
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
        let forces = self.traction_forces(boundary, traction)?;
        self.add_forces(
            Origin::Traction(boundary.to_string()),
            forces,
            Amplitude::default(),
        )
    }

    /// As [`Body::traction`], times an amplitude in place of the load factor. What is not zero at load factor 0 is applied
    /// within the first step.
    ///
    /// # Errors
    /// As [`Body::traction`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn traction_in_time(
        &mut self,
        boundary: &str,
        traction: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let forces = self.traction_forces(boundary, |_| traction.into())?;
        self.add_forces(
            Origin::Traction(boundary.to_string()),
            forces,
            amplitude.into(),
        )
    }

    /// Adds a dead traction that depends on the load factor and on the reference position X (UL).
    ///
    /// # Errors
    /// As [`Body::traction`]. Values are checked at the load factors 1/16, 2/16, … 1, and at those that a run comes to.
    pub fn traction_path(
        &mut self,
        boundary: &str,
        traction: impl Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        self.traction_forces(boundary, |_| Vector::zeros())?;
        let (mesh, boundary) = (self.mesh.clone(), boundary.to_string());
        let origin = Origin::Traction(boundary.clone());
        self.add_path(origin, move |t, forces| {
            // checked above
            let facets = mesh.boundary(&boundary).unwrap_or_default();
            add_traction(&mesh, &facets, |X| traction(t, X), forces);
        })
    }

    pub(super) fn traction_forces(
        &self,
        boundary: &str,
        traction: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<Vec<f64>, Error> {
        let facets = self.facets(boundary, "traction")?;
        let mut forces = vec![0.0; self.forces.len()];
        add_traction(&self.mesh, &facets, traction, &mut forces);
        Ok(forces)
    }

    /// Adds a torque (UF·UL; in the plane one number, in space a vector) on a boundary, as a dead traction a × (X − X̄) about its centre, which has no
    /// resultant. It does not turn with the boundary.
    ///
    /// A shaft of radius ½ is twisted at its end: the nodal forces have that torque, and no resultant.
    /// ```
    /// use contact_fem::mesh::generators::cylinder;
    /// use contact_fem::{Body, LinearElastic};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mut shaft = Body::new(cylinder(0.5, 2.0, 2, 4)?, LinearElastic::new(100.0, 0.3)?);
    /// shaft.prescribe("bottom", [Some(0.0); 3])?.torque("top", &[0.0, 0.0, 0.7])?;
    /// let (mut force, mut torque) = ([0.0; 3], 0.0);
    /// for (X, f) in shaft.mesh().nodes().iter().zip(shaft.forces().chunks(3)) {
    ///     force = [0, 1, 2].map(|i| force[i] + f[i]);
    ///     torque += X[0] * f[1] - X[1] * f[0];
    /// }
    /// assert!(force.iter().all(|f| f.abs() < 1e-12) && (torque - 0.7).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Body::traction`]; another number of components, a body of revolution, and a boundary along whose line the torque is.
    pub fn torque(&mut self, boundary: &str, torque: &[f64]) -> Result<&mut Self, Error> {
        self.torque_in_time(boundary, torque, Amplitude::default())
    }

    /// As [`Body::torque`], times an amplitude in place of the load factor.
    ///
    /// # Errors
    /// As [`Body::torque`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn torque_in_time(
        &mut self,
        boundary: &str,
        torque: &[f64],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let wrong = |value, remedy| {
            Err(Error::Setting {
                name: "torque",
                value,
                remedy,
            })
        };
        Error::check_finite("torque", torque)?;
        let components = if D == 2 { 1 } else { 3 };
        if torque.len() != components {
            let count = torque.len() as f64;
            return wrong(
                count,
                "give one number in the plane, and three components in space",
            );
        }
        if self.mesh.is_of_revolution() {
            return wrong(
                torque[0],
                "a body of revolution is not twisted: leave it out",
            );
        }
        // moments of the boundary, by tractions along the first axis
        let sum = |density: &dyn Fn(&Vector<D>) -> f64| -> Result<f64, Error> {
            let field =
                |X: &Vector<D>| Vector::from_fn(|i, _| if i == 0 { density(X) } else { 0.0 });
            Ok(self.traction_forces(boundary, field)?.iter().sum())
        };
        let area = sum(&|_| 1.0)?;
        let mut centre = Vector::<D>::zeros();
        for i in 0..D {
            centre[i] = sum(&|X| X[i])? / area;
        }
        let spatial = |X: &Vector<D>| {
            let arm = X - centre;
            Vector3::from_fn(|i, _| if i < D { arm[i] } else { 0.0 })
        };
        let mut inertia = Matrix3::zeros();
        for (i, j) in (0..3).flat_map(|j| (0..=j).map(move |i| (i, j))) {
            let entry = sum(&|X| {
                let r = spatial(X);
                f64::from(u8::from(i == j)) * r.norm_squared() - r[i] * r[j]
            })?;
            (inertia[(i, j)], inertia[(j, i)]) = (entry, entry);
        }
        let moment = match D {
            2 => Vector3::new(0.0, 0.0, torque[0]),
            _ => Vector3::from_column_slice(torque),
        };
        let inverse = inertia.pseudo_inverse(ALONG * inertia.amax());
        let turn = inverse.map_or(Vector3::zeros(), |inverse| inverse * moment);
        if (inertia * turn - moment).norm() > ALONG * moment.norm() {
            return wrong(
                moment.norm(),
                "the boundary is a line along it, and cannot take it: name a wider one",
            );
        }
        let forces = self.traction_forces(boundary, |X| {
            let force = turn.cross(&spatial(X));
            Vector::from_fn(|i, _| force[i])
        })?;
        let origin = Origin::Traction(boundary.to_string());
        self.add_forces(origin, forces, amplitude.into())
    }

    /// The facets of a boundary on which something acts.
    pub(super) fn facets(
        &self,
        boundary: &str,
        what: &'static str,
    ) -> Result<Vec<&[usize]>, Error> {
        let facets = self.mesh.boundary(boundary)?;
        match facets.is_empty() {
            true => Err(Error::EmptyBoundary {
                name: boundary.to_string(),
                what,
            }),
            false => Ok(facets),
        }
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
        self.add_forces(Origin::BodyForce, forces, Amplitude::default())
    }

    /// As [`Body::body_force`], times an amplitude in place of the load factor. What is not zero at load factor 0 is applied
    /// within the first step.
    ///
    /// # Errors
    /// If a value is not finite. Values of an amplitude are checked at the times that a run comes to.
    pub fn body_force_in_time(
        &mut self,
        force: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let mut forces = vec![0.0; self.forces.len()];
        let field = |_: &Vector<D>| force.into();
        self.law.add_body_force(&self.mesh, &field, &mut forces);
        self.add_forces(Origin::BodyForce, forces, amplitude.into())
    }

    /// Adds a dead body force that depends on the load factor and on the reference position X (UL).
    ///
    /// # Errors
    /// If a value is not finite, which is checked at the load factors 1/16, 2/16, … 1, and at those that a run comes to.
    pub fn body_force_path(
        &mut self,
        force: impl Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        let (mesh, law) = (self.mesh.clone(), Arc::clone(&self.law));
        self.add_path(Origin::BodyForce, move |t, forces| {
            law.add_body_force(&mesh, &|X| force(t, X), forces);
        })
    }

    /// Adds a dead force (UF) on each of the given nodes.
    ///
    /// # Errors
    /// If a value is not finite, or a node does not exist.
    pub fn nodal_force(&mut self, nodes: &[usize], force: [f64; D]) -> Result<&mut Self, Error> {
        self.nodal_force_in_time(nodes, force, Amplitude::default())
    }

    /// As [`Body::nodal_force`], times an amplitude in place of the load factor.
    ///
    /// # Errors
    /// As [`Body::nodal_force`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn nodal_force_in_time(
        &mut self,
        nodes: &[usize],
        force: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        some("number of loaded nodes", nodes)?;
        let mut forces = vec![0.0; self.forces.len()];
        for &node in nodes {
            let Some(own) = forces.get_mut(D * node..D * (node + 1)) else {
                return Err(Error::Setting {
                    name: "node",
                    value: node as f64,
                    remedy: "name a node of this body's mesh",
                });
            };
            own.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
        }
        self.add_forces(Origin::NodalForce, forces, amplitude.into())
    }

    /// Adds the nodal forces of a load if all of them are finite.
    pub(in crate::model) fn add_forces(
        &mut self,
        origin: Origin,
        forces: Vec<f64>,
        amplitude: Amplitude,
    ) -> Result<&mut Self, Error> {
        self.always(origin.kind())?;
        Error::check_finite(origin.kind(), &forces)?;
        if amplitude.is_proportional() {
            let sums = self.proportional.iter_mut().zip(&forces);
            sums.for_each(|(sum, force)| *sum += force);
        }
        self.loads.push((origin, Load::Scaled(forces, amplitude)));
        self.forces = self.forces_at(1.0);
        Ok(self)
    }

    /// Adds forces that are computed anew at each load factor.
    pub(super) fn add_path(
        &mut self,
        origin: Origin,
        add: impl Fn(f64, &mut [f64]) + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        self.always(origin.kind())?;
        for t in samples() {
            let mut forces = vec![0.0; self.forces.len()];
            add(t, &mut forces);
            Error::check_finite(origin.kind(), &forces)?;
        }
        self.loads.push((origin, Load::Given(Arc::new(add))));
        self.forces = self.forces_at(1.0);
        Ok(self)
    }
}
