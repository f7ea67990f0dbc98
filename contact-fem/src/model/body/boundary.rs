//! What acts on a body's boundary where it is: elastic foundations, and pressures that follow it.

use super::{Body, Origin};
use crate::assembly::{BodyEnergy, OnBoundary, Pressed, Springs, Stretch};
use crate::error::Error;
use crate::program::Amplitude;

/// Springs on the facets of a boundary.
#[derive(Clone)]
pub(in crate::model) struct Foundation {
    pub boundary: String,
    pub springs: Springs,
}

/// A pressure on the facets of a boundary, which follows them.
#[derive(Clone)]
pub(in crate::model) struct Pressure<const D: usize> {
    pub boundary: String,
    pressed: Pressed<D>,
    /// The pressure at amplitude 1 (UF/UL in the plane, UF/UL² in space).
    value: f64,
    amplitude: Amplitude,
}

impl<const D: usize> Pressure<D> {
    /// The pressure at a load factor; 0 at the load factor 0, before the first step.
    fn at(&self, factor: f64) -> f64 {
        match factor == 0.0 {
            true => 0.0,
            false => self.value * self.amplitude.at(factor),
        }
    }

    /// The times of the table of its amplitude.
    pub(super) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.amplitude.knots()
    }

    pub(super) fn is_proportional(&self) -> bool {
        self.amplitude.is_proportional()
    }

    /// Adds the forces on the body (UF) at the displacements U of all its dofs (UL) to `forces`, and returns their potential,
    /// p V (UF·UL); `is_free` tells which dofs are free.
    pub fn add_forces(
        &self,
        factor: f64,
        U: &[f64],
        forces: &mut [f64],
        is_free: impl Fn(usize) -> bool,
    ) -> f64 {
        let p = self.at(factor);
        if p == 0.0 {
            return 0.0;
        }
        self.pressed.add_areas(U, -p, forces);
        p * self.pressed.volume(U, is_free)
    }
}

impl<const D: usize> Body<D> {
    /// Puts a boundary on springs that are fixed to the ground and resist displacements in all directions: k u per reference
    /// area, with the stiffness k in UF/UL³ in space, in UF/UL² in the plane.
    ///
    /// A body that only springs hold is held. Their forces count as reactions, by the name of the boundary, and their energy
    /// ½ ∫ k |u|² dA belongs to E.
    ///
    /// A bar on springs, drawn by 2 at its other end; the springs give way by 2/50, and the bar by 4 · 2/100:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = rectangle(&linspace(0.0, 4.0, 8), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
    /// let mut bar = Body::new(mesh, LinearElastic::new(100.0, 0.0)?);
    /// bar.foundation("left", 50.0)?.traction("right", [2.0, 0.0])?;
    /// let mut scene = Scene::new();
    /// let bar = scene.add("bar", bar);
    /// let mut problem = scene.problem()?;
    /// let history = Simulation::with_increments(1).run(&mut problem)?;
    /// assert!((history.steps[0].reaction(bar)[0] + 2.0).abs() < 1e-9);
    /// assert!((history.steps[0].stored_energy - 0.5 * 2.0 * 0.08).abs() < 1e-9, "without the springs");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, or the stiffness is not positive.
    pub fn foundation(&mut self, boundary: &str, stiffness: f64) -> Result<&mut Self, Error> {
        self.add_foundation(boundary, stiffness, Stretch::Any)
    }

    /// As [`Body::foundation`], with springs along the outward normal N of the reference configuration alone: k (u·N) N per
    /// reference area. They push and pull, and let the boundary slide.
    ///
    /// # Errors
    /// As [`Body::foundation`].
    pub fn normal_foundation(
        &mut self,
        boundary: &str,
        stiffness: f64,
    ) -> Result<&mut Self, Error> {
        self.add_foundation(boundary, stiffness, Stretch::Normal)
    }

    fn add_foundation(
        &mut self,
        boundary: &str,
        stiffness: f64,
        stretch: Stretch,
    ) -> Result<&mut Self, Error> {
        self.always("foundation")?;
        let facets = self.facets(boundary, "foundation")?;
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            return Err(Error::Setting {
                name: "stiffness of a foundation",
                value: stiffness,
                remedy: "choose a positive number, force by length cubed in space and by length squared in the plane",
            });
        }
        let springs = Springs::new(&self.mesh, &facets, stiffness, stretch);
        self.foundations.push(Foundation {
            boundary: boundary.to_string(),
            springs,
        });
        Ok(self)
    }

    /// Presses a boundary by a pressure (UF/UL²) against its outward normal.
    ///
    /// It follows the boundary: it acts on the present area along the present normal, −p n da. Under a law for small strains
    /// areas and normals are those of the reference configuration, as everything else.
    ///
    /// A pressure that follows has a potential, p times the volume that the boundary sweeps, where the rim of the boundary is
    /// closed, held, or slides in planes perpendicular to an axis. Scenes whose rims are free are refused.
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, or the pressure is not finite. [`Scene::problem`](crate::Scene::problem) tells of rims that are free,
    /// since supports may come later.
    pub fn pressure(&mut self, boundary: &str, pressure: f64) -> Result<&mut Self, Error> {
        self.pressure_in_time(boundary, pressure, Amplitude::default())
    }

    /// As [`Body::pressure`], times an amplitude in place of the load factor. What is not zero at load factor 0 is applied
    /// within the first step.
    ///
    /// # Errors
    /// As [`Body::pressure`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn pressure_in_time(
        &mut self,
        boundary: &str,
        pressure: f64,
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        self.always("pressure")?;
        let pressed = Pressed::new(&self.mesh, &self.facets(boundary, "pressure")?);
        Error::check_finite("pressure", &[pressure])?;
        if self.is_small_strain() {
            let mut forces = vec![0.0; self.forces.len()];
            pressed.add_areas(&vec![0.0; forces.len()], -pressure, &mut forces);
            let origin = Origin::Pressure(boundary.to_string());
            return self.add_forces(origin, forces, amplitude.into());
        }
        self.pressures.push(Pressure {
            boundary: boundary.to_string(),
            pressed,
            value: pressure,
            amplitude: amplitude.into(),
        });
        Ok(self)
    }

    /// Whether forces on its boundary depend on displacements.
    pub(crate) fn acts_on_boundary(&self) -> bool {
        !(self.foundations.is_empty() && self.pressures.is_empty())
    }

    /// The springs on boundaries.
    pub(in crate::model) fn foundations(&self) -> &[Foundation] {
        &self.foundations
    }

    /// What its springs oppose: for each a list of dofs and their shares, not empty.
    pub(in crate::model) fn stretches(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        let all = self.foundations.iter();
        all.flat_map(|own| own.springs.stretches().iter().map(Vec::as_slice))
    }

    /// The pressures that follow boundaries.
    pub(in crate::model) fn pressures(&self) -> &[Pressure<D>] {
        &self.pressures
    }

    /// Their values at a load factor (UF/UL in the plane, UF/UL² in space).
    pub(in crate::model) fn pressures_at(&self, factor: f64) -> Vec<f64> {
        self.pressures.iter().map(|own| own.at(factor)).collect()
    }

    /// The forces of foundations on all dofs at the displacements U of all dofs (UF).
    pub(crate) fn foundation_forces(&self, U: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; self.forces.len()];
        for own in &self.foundations {
            own.springs.add_forces(U, &mut forces);
        }
        forces.iter_mut().for_each(|force| *force = -*force);
        forces
    }

    /// Adds the forces of pressures that follow, likewise, to `forces`.
    pub(crate) fn add_pressures(&self, factor: f64, U: &[f64], forces: &mut [f64]) {
        for own in &self.pressures {
            own.pressed.add_areas(U, -own.at(factor), forces);
        }
    }

    /// Σ |f| of the pressures that follow, in the reference configuration (UF).
    pub(super) fn sum_of_pressures(&self, factor: f64) -> f64 {
        if self.pressures.is_empty() {
            return 0.0;
        }
        let mut forces = vec![0.0; self.forces.len()];
        let zero = forces.clone();
        self.add_pressures(factor, &zero, &mut forces);
        forces.iter().map(|f| f.abs()).sum()
    }

    /// The energy of the body with what acts on its boundary.
    pub(super) fn with_boundary(&self, body: Box<dyn BodyEnergy<D>>) -> Box<dyn BodyEnergy<D>> {
        let softening = self.softening();
        if !self.acts_on_boundary() && softening.is_empty() {
            return body;
        }
        let (dofs, _) = self.eliminated();
        let springs = self.foundations.iter().map(|own| own.springs.clone());
        let pressed = self.pressures.iter().map(|own| own.pressed.clone());
        let energy = OnBoundary::new(body, dofs, springs.collect(), pressed.collect());
        Box::new(energy.with_softening(softening))
    }
}
