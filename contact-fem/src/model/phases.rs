//! Supports that begin and end where phases do.

use contact_core::LoadStepped;
use contact_core::energy::DirectSum;
use contact_core::equilibrium::Solution;

use super::body::Holding;
use super::kinematics::Kinematics;
use super::preflight::{self, Report};
use super::switches::phases;
use super::work::External;
use super::{Problem, scale};
use crate::error::Error;

impl<const D: usize> Problem<D> {
    /// Whether some supports do not hold at all times.
    pub(crate) fn is_switched(&self) -> bool {
        self.scene.bodies().iter().any(|body| body.is_switched())
    }

    /// Lets those supports hold that do in the phase from `from` to `until`, and returns the free unknowns at `u`, where the
    /// last phase ended with a solution; `None` if the same dofs are free as before.
    pub(super) fn switch_supports(
        &mut self,
        [from, until]: [f64; 2],
        u: &[f64],
        solution: Option<&Solution>,
    ) -> Result<Option<Vec<f64>>, contact_core::Error> {
        if !self.is_switched() {
            return Ok(None);
        }
        self.set_load(from)?;
        let U = self.displacements(u);
        let mut stored = 0.0;
        let mut reactions = match solution {
            Some(_) => (*self.residuals(u)).clone(),
            None => vec![Vec::new(); self.scene.bodies().len()],
        };
        if let Some(solution) = solution {
            let contact = self.surface_forces(solution);
            stored = External::new(self, u, (&contact, &[])).stored(self.energy_at(u));
            for (body, own) in reactions.iter_mut().enumerate() {
                let contact = contact[self.nodes(body)].iter().flatten();
                own.iter_mut().zip(contact).for_each(|(r, c)| *r -= c);
            }
        }
        let held = self.holdings();
        let mut changed = vec![false; held.len()];
        for (index, own) in reactions.iter_mut().enumerate() {
            let nodes = self.nodes(index);
            let displaced: Vec<f64> = U[nodes].iter().flatten().copied().collect();
            own.resize(displaced.len(), 0.0);
            let body = &mut self.scene.bodies_mut()[index];
            if body.is_switched() {
                changed[index] = body.switch_supports([from, until], &displaced, own);
            }
        }
        self.let_soften(stored);
        self.last_held = None;
        let unknowns = match changed.contains(&true) {
            true => {
                self.last_held = Some(held);
                self.rebuild(&changed);
                Some(self.unknowns(&U)?)
            }
            false => None,
        };
        self.forget_residuals();
        self.set_load(from)?;
        Ok(unknowns)
    }

    /// Makes springs of what supports leave that let go bodies at large strains; those halfway through the phase would store as much as
    /// the bodies have `stored` (UF·UL), if they carried the reactions.
    fn let_soften(&mut self, stored: f64) {
        let length = self.scale.length;
        let bodies = self.scene.bodies_mut().iter_mut();
        let yielding: Vec<_> = bodies.filter(|body| !body.is_small_strain()).collect();
        let sum: f64 = yielding.iter().map(|body| body.sum_released()).sum();
        let stiffness = 0.5 * sum / stored;
        let is_usable = stiffness > 0.0 && stiffness.is_finite();
        let stiffness = if is_usable { stiffness } else { 1.0 / length };
        for body in yielding {
            if body.sum_released() > 0.0 {
                body.soften(stiffness);
            }
        }
    }

    /// Lets the bodies be held as before the last [`Problem::switch_supports`] that changed something.
    pub(super) fn switch_back(&mut self) {
        let Some(held) = self.last_held.take() else {
            return;
        };
        let bodies = self.scene.bodies_mut().iter_mut().zip(held);
        bodies.for_each(|(body, held)| body.hold_again(held));
        let changed: Vec<bool> = self
            .scene
            .bodies()
            .iter()
            .map(|b| b.is_switched())
            .collect();
        self.rebuild(&changed);
        self.forget_residuals();
    }

    /// Lets the supports hold that do from the beginning, at the load factor 0.
    pub(crate) fn rest(&mut self) -> Result<(), Error> {
        if self.is_switched() {
            let rest = vec![0.0; self.dofs().free()];
            self.switch_supports([0.0, f64::MIN_POSITIVE], &rest, None)?;
            self.last_held = None;
        }
        Ok(())
    }

    /// Checks that supports, pairs and obstacles are switched where phases end, and that each counts in some phase; `ends` are the
    /// load factors at which phases end.
    pub(super) fn check_switches(&self, ends: &[f64]) -> Result<(), Error> {
        let scene = &self.scene;
        let supports = scene.bodies().iter().zip(scene.names());
        let supports = supports.flat_map(|(body, name)| {
            let all = body.switched();
            all.map(move |(boundary, during)| {
                (
                    format!("the support on `{boundary}` of body `{name}`"),
                    during,
                )
            })
        });
        let contact = scene.switched().iter();
        let contact = contact.map(|(what, during)| (scene.name_of_switched(what), during));
        let last = ends.last().copied().unwrap_or(0.0);
        for (what, during) in supports.chain(contact) {
            if !during.begins_before(last) {
                return Err(Error::NeverCounts { what, last });
            }
            for [from, until] in phases(ends) {
                if let Some(at) = during.within([from, until]) {
                    return Err(Error::SwitchWithinPhase {
                        what,
                        at,
                        from,
                        until,
                    });
                }
            }
        }
        Ok(())
    }

    /// Checks the supports of each phase of a run; `ends` are the load factors at which phases end.
    pub(super) fn check_supports(&mut self, ends: &[f64]) -> Result<(), Error> {
        for body in self.scene.bodies() {
            body.check_agreement(ends)?;
        }
        if !self.is_switched() {
            return Ok(());
        }
        let held = self.holdings();
        let mut checked = Ok(());
        for phase in phases(ends) {
            let [from, until] = phase;
            for body in self.scene.bodies_mut() {
                let nothing = vec![0.0; body.prescribed().len()];
                if body.is_switched() {
                    body.switch_supports(phase, &nothing, &nothing);
                }
            }
            let mut report = Report::default();
            preflight::supports_of_phase(&self.scene, self.scene.pairs(), &mut report);
            let found = report
                .accepted()
                .map(|_| ())
                .map_err(|error| Error::InPhase {
                    from,
                    until,
                    error: Box::new(error),
                });
            checked = checked.and(found);
            if checked.is_err() {
                break;
            }
        }
        let bodies = self.scene.bodies_mut().iter_mut().zip(held);
        bodies.for_each(|(body, held)| body.hold_again(held));
        checked
    }

    fn holdings(&self) -> Vec<Holding<D>> {
        self.scene
            .bodies()
            .iter()
            .map(|body| body.holding())
            .collect()
    }

    /// Takes the free and prescribed dofs of the bodies as they are now, of which some have changed.
    fn rebuild(&mut self, changed: &[bool]) {
        let energies = std::mem::replace(&mut self.energy, DirectSum::new(Vec::new()));
        let energies = energies.into_parts().into_iter();
        let all = energies.zip(self.scene.bodies()).zip(changed);
        let energies: Vec<_> = all
            .map(|((energy, body), changed)| match changed {
                true => body.energy(),
                false => energy,
            })
            .collect();
        let geometry = self.contact.geometry;
        self.kinematics = Kinematics::new(self.scene.bodies());
        let length = self.kinematics.diagonal();
        let lengths = (length, self.contact.smallest_facet(length));
        let overlap = self.contact.resolved_overlap();
        self.scale = scale::estimate(&self.scene, geometry, &energies, lengths, overlap);
        self.energy = DirectSum::new(energies);
        self.held = preflight::held(&self.scene);
    }
}
