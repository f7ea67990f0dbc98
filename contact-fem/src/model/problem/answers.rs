//! What a problem answers to solvers and to load stepping.
//!
//! [`Problem`] hands the calls of [`ContactProblem`](contact_core::ContactProblem) and [`LoadStepped`](contact_core::LoadStepped) over to [`Answers`], whose code is
//! compiled in this crate: see [`instances`](crate::instances).

use std::collections::BTreeMap;

use contact_core::equilibrium::Solution;
use contact_core::friction::SlipRows;
use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::load_steps::Passage;
use contact_core::{Energy, Error, GapVariation, Reduction, Separable};

use super::Problem;
use crate::assembly::{Dof, DofMap};
use crate::audit::Overlap;
use crate::instances::instance;
use crate::model::tie::Follower;
use crate::model::{Geometry, Overlaps, courses, diagnosis};

/// The methods of both traits.
pub(crate) trait Answers {
    fn energy(&self) -> &dyn Energy;
    fn prescribed_magnitude(&self) -> f64;
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error>;
    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error>;
    fn linearize_near(&self, u: &[f64], moved: f64) -> Result<LinearGaps, Error>;
    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error>;
    fn slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error>;
    fn vary_slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error>;
    fn separable(&self) -> &dyn Separable;
    fn reduction(&self) -> Option<Reduction>;
    fn diagnose(&self, solution: &Solution) -> Option<String>;
    fn set_load(&mut self, factor: f64) -> Result<(), Error>;
    fn check_phases(&mut self, ends: &[f64]) -> Result<(), Error>;
    fn corners(&self) -> Vec<f64>;
    fn begin(
        &mut self,
        span: [f64; 2],
        u: &[f64],
        solution: Option<&Solution>,
    ) -> Result<Option<Vec<f64>>, Error>;
    fn take_back(&mut self);
    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<Passage>;
    fn hold(&self, solution: &Solution) -> Option<String>;
    fn unplanned(&self, u: &[f64]) -> Option<String>;
    fn lift(&self, u: &[f64], from: f64) -> Vec<f64>;
}

impl<const D: usize> Problem<D> {
    pub(super) fn answers(&self) -> &dyn Answers {
        instance().answers(self)
    }

    pub(super) fn answers_mut(&mut self) -> &mut dyn Answers {
        instance().answers_mut(self)
    }
}

/// The relative depth of two bodies, and the depth of a node in facets, from which on corners and edges get rows. Sound scenes without such rows are at most so deep, at corners. From
/// [`Overlap::LIMIT`] on, a run ends.
const DEEP: f64 = 0.2;
/// The relative depth for two bodies without a force between them: with their rows, corners would be as deep.
const UNOPPOSED: f64 = 0.05;
/// The smallest force between two bodies that keeps them apart, as a share of the scene's unit of forces.
const PUSHES: f64 = 1e-6;

impl<const D: usize> Problem<D> {
    /// An overlap in words.
    fn passage(&self, found: &Overlap<D>) -> Passage {
        let [first, second] = found.bodies.map(|body| self.scene.called(body));
        let at: Vec<String> = found.at.iter().map(|x| format!("{x:.3e}")).collect();
        Passage {
            depth: found.depth,
            place: format!("{first} is inside {second} at ({})", at.join(", ")),
        }
    }

    /// What is so deep inside that corners and edges get rows, as a clause.
    fn too_deep(&self, solution: &Solution) -> Option<String> {
        if let Some(Passage { place, depth }) = self.deep_overlap(solution) {
            return Some(format!("{place} by {depth:.2e}"));
        }
        let share = self.relative_penetration(&solution.state.u);
        (share > DEEP).then(|| format!("a node is {share:.2} facets inside another surface"))
    }

    /// The deepest overlap of two bodies that may touch, if it is deep enough.
    fn deep_overlap(&self, solution: &Solution) -> Option<Passage> {
        let mut forces: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for (key, force) in solution.gaps.keys().iter().zip(&solution.lambda) {
            let [a, b] = self.bodies_of(self.passes()[key.pass as usize]);
            *forces.entry([a.min(b), a.max(b)]).or_default() += force;
        }
        let least = PUSHES * self.scale.energy / self.scale.length;
        let beyond =
            |found: &Overlap<D>| found.relative - self.granted(found.bodies, self.load())[0];
        let is_deep = |found: &Overlap<D>| {
            let [a, b] = found.bodies;
            let force = forces.get(&[a.min(b), a.max(b)]);
            let is_pushed = force.is_some_and(|force| *force > least);
            let limit = if is_pushed { DEEP } else { UNOPPOSED };
            beyond(found) > limit && self.contact.is_pair([a, b])
        };
        let x = self.kinematics.positions(&solution.state.u);
        let found = self.audit.overlaps(&x).into_iter().filter(is_deep);
        let deepest = found.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
        Some(self.passage(&deepest))
    }
}

impl<const D: usize> Answers for Problem<D> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn prescribed_magnitude(&self) -> f64 {
        let prescribed = self.kinematics.prescribed.iter();
        let overlap = self.contact.resolved_overlap() * self.load();
        prescribed.fold(overlap, |m, v| m.max(v.abs()))
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let passes = self.contact.passes_in(false);
        let (at, stop) = (&self.kinematics, self.contact.stop.as_ref());
        let rows = self.contact.rows(passes, at, u, sampling, stop);
        self.with_distances(rows.ok_or(Error::Interrupted)?, u)
    }

    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let passes = self.contact.passes_in(true);
        let (at, stop) = (&self.kinematics, self.contact.stop.as_ref());
        let rows = self.contact.rows(passes, at, u, sampling, stop);
        rows.ok_or(Error::Interrupted)
    }

    fn linearize_near(&self, u: &[f64], moved: f64) -> Result<LinearGaps, Error> {
        self.linearize_where(u, |pass| self.contact.is_near(pass, moved))
    }

    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let variation = self.contact.variation(&self.kinematics, u, gaps, lambda)?;
        Ok(variation.map(|own| own.finish(self.dofs())))
    }

    fn slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        Error::check_vector("last", last, self.dofs().free())?;
        let then = self.kinematics.positions_at(last, from);
        let since = (&then[..], from);
        let slips = self.contact.slips(&self.kinematics, u, gaps, since);
        slips.ok_or(Error::Interrupted)
    }

    fn vary_slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let variation = self.contact.variation(&self.kinematics, u, gaps, forces)?;
        Ok(variation.map(|own| own.turned().finish(self.dofs())))
    }

    fn separable(&self) -> &dyn Separable {
        self
    }

    fn reduction(&self) -> Option<Reduction> {
        let now = (&self.scene, self.load());
        self.ties.reduction(&self.kinematics.prescribed, now)
    }

    fn diagnose(&self, solution: &Solution) -> Option<String> {
        diagnosis::cause(self, solution)
    }

    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        if !factor.is_finite() {
            return Err(Error::Setting {
                name: "load factor",
                value: factor.to_string(),
                remedy: "choose a finite number; 1 is full load",
            });
        }
        let bodies = self.scene.bodies().iter().zip(self.scene.names());
        for (body, name) in bodies {
            courses::check(body, name, factor)?;
        }
        self.contact.check(&self.scene, factor)?;
        self.kinematics.set_load(factor);
        self.contact.set_load(factor);
        self.audit.set_load(factor);
        let energies = self.energy.parts_mut().iter_mut();
        for (body, energy) in self.scene.bodies().iter().zip(energies) {
            match body.has_program() {
                true => energy.set_external(body.prescribed_at(factor), body.forces_at(factor)),
                false => energy.set_load(factor),
            }
            energy.set_pressures(&body.pressures_at(factor));
            energy.set_softening(body.softening_stiffness(factor));
        }
        Ok(())
    }

    fn check_phases(&mut self, ends: &[f64]) -> Result<(), Error> {
        self.check_switches(ends)?;
        Ok(self.check_supports(ends)?)
    }

    fn corners(&self) -> Vec<f64> {
        let bodies = self.scene.bodies().iter().flat_map(|body| body.knots());
        let obstacles = self.scene.obstacles().iter();
        bodies
            .chain(obstacles.flat_map(|own| own.knots()))
            .chain(
                self.scene
                    .ties()
                    .iter()
                    .flat_map(|tie| tie.amplitude.knots()),
            )
            .collect()
    }

    fn begin(
        &mut self,
        span: [f64; 2],
        u: &[f64],
        solution: Option<&Solution>,
    ) -> Result<Option<Vec<f64>>, Error> {
        if span[0] == 0.0 {
            self.contact.begin();
        }
        self.switch_supports(span, u, solution)
    }

    fn take_back(&mut self) {
        self.switch_back();
    }

    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<Passage> {
        if !(self.is_state(u) && self.is_state(last)) {
            return None;
        }
        let before = self.kinematics.positions_at(last, from);
        let after = self.kinematics.positions(u);
        let relative = |bodies| self.granted(bodies, self.load())[0];
        let of_thickness = |bodies| match self.contact.lets_through(bodies, self.load()) {
            true => f64::MAX,
            false => self.granted(bodies, from)[1],
        };
        if let Some((name, angle)) = self.turns(from) {
            let place = format!(
                "slips are chords, so that a step may turn an obstacle with friction by {TURNS} rad: `{name}` turns by {angle:.2} rad"
            );
            let depth = angle * self.kinematics.diagonal();
            return Some(Passage { depth, place });
        }
        // cutting a step does not change the solution of a linear scene; its certificate tells
        let overlap = match (self.contact.geometry, self.scene.overlaps) {
            (Geometry::Current, Overlaps::Refused) => {
                let now = self.audit.deep_overlap(&after, relative);
                now.or_else(|| self.audit.passage(&before, &after, of_thickness))
            }
            _ => None,
        };
        let inside = |found| self.passage(&found);
        let through = || {
            let positions = (&before[..], &after[..]);
            let depth = self.contact.tunnels(&self.kinematics, u, positions, from)?;
            let place = match self.contact.geometry {
                Geometry::Reference => {
                    "contact at the reference positions does not follow the motion, so take it at the current ones: \
                     bodies penetrate or have passed through each other"
                }
                Geometry::Current => "bodies penetrate or have passed through each other",
            };
            let place = place.to_string();
            Some(Passage { depth, place })
        };
        let between_nodes = || match self.scene.overlaps {
            Overlaps::Refused => self
                .audit
                .obstacle_passage(&before, &after, from, of_thickness),
            Overlaps::Allowed => None,
        };
        let found = overlap.map(inside).or_else(through);
        found.or_else(|| between_nodes().map(inside))
    }

    fn hold(&self, solution: &Solution) -> Option<String> {
        if !self.contact.may_hold_corners() || self.scene.overlaps == Overlaps::Allowed {
            return None;
        }
        let what = self.too_deep(solution)?;
        self.contact.hold_corners();
        Some(format!(
            "{what}, and rows of sharp corners and edges may hold it"
        ))
    }

    fn unplanned(&self, u: &[f64]) -> Option<String> {
        let pass = self.contact.unplanned(&self.kinematics, u)?;
        let [first, second] = self.bodies_of(pass).map(|body| self.scene.called(body));
        Some(format!("{first} and {second} came together"))
    }

    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        let mut lifted = self.state(u).into_owned();
        if !self.ties.is_empty() {
            self.lift_tied(from, &mut lifted);
            return lifted;
        }
        let bodies = self.scene.bodies().iter().zip(self.energy.parts());
        for (index, (body, energy)) in bodies.enumerate() {
            let [now, before] = [self.load(), from].map(|factor| body.prescribed_at(factor));
            let increments = now.iter().zip(&before).map(|(now, before)| now - before);
            let increments: Vec<f64> = increments.collect();
            if increments.iter().all(|p| *p == 0.0) {
                continue;
            }
            let (supports, increments) = body.lifted_by(increments);
            let extension = energy.extend(&supports, &increments);
            self.kinematics.add_free(index, &extension, &mut lifted);
        }
        lifted
    }
}

/// An obstacle with friction may turn by this angle (rad) in a load step.
const TURNS: f64 = 0.5;

impl<const D: usize> Problem<D> {
    /// An obstacle with friction that turns by more than [`TURNS`] from the load factor `from` to the present one, and its angle: the sum of those of ten parts of
    /// the way, of which each is below half a turn.
    fn turns(&self, from: f64) -> Option<(&str, f64)> {
        let rough = self.scene.obstacle_frictions().iter();
        let all = self.scene.obstacles().iter().zip(rough);
        let mut all = all.zip(self.scene.obstacle_names());
        all.find_map(|((obstacle, friction), name)| {
            if !(*friction > 0.0) {
                return None;
            }
            let pose = |k: u32| {
                let share = f64::from(k) / f64::from(PARTS);
                obstacle.pose(from + share * (self.load() - from)).R
            };
            let angle = |k: u32| {
                let turned = pose(k + 1) * pose(k).transpose();
                // of two directions in a plane
                turned[(1, 0)].atan2(turned[(0, 0)]).abs()
            };
            let angle: f64 = (0..PARTS).map(angle).sum();
            (angle > TURNS).then_some((name.as_str(), angle))
        })
    }
}

/// So many parts of a load step are looked at.
const PARTS: u32 = 10;

impl<const D: usize> Problem<D> {
    /// As [`Answers::lift`]; nodes that follow other nodes move along with these.
    fn lift_tied(&self, from: f64, lifted: &mut [f64]) {
        let before = lifted.to_vec();
        let dofs = &self.kinematics.dofs;
        let prescribed: Vec<f64> = {
            let bodies = self.scene.bodies().iter();
            bodies.flat_map(|body| body.prescribed_at(from)).collect()
        };
        for (index, followers) in self.ties.in_order(self.scene.bodies().len()) {
            let body = &self.scene.bodies()[index];
            let first = D * self.kinematics.nodes(index).start;
            let mut is_prescribed = body.is_prescribed();
            let mut increments = vec![0.0; is_prescribed.len()];
            let moved = |dof: usize, lifted: &[f64]| match dofs.get(dof) {
                Dof::Free(j) => lifted[j] - before[j],
                Dof::Prescribed(j) => self.kinematics.prescribed[j] - prescribed[j],
            };
            for (dof, increment) in increments.iter_mut().enumerate() {
                if is_prescribed[dof] {
                    *increment = moved(first + dof, lifted);
                }
            }
            for (tie, Follower { dof, terms, jump }) in followers {
                let tie = &self.scene.ties()[tie];
                let jumped = jump * (tie.factor(self.load()) - tie.factor(from));
                let terms = terms.iter();
                let increment = terms.map(|(j, c)| c * moved(*j, lifted)).sum::<f64>() + jumped;
                (is_prescribed[dof - first], increments[dof - first]) = (true, increment);
            }
            if increments.iter().all(|p| *p == 0.0) {
                continue;
            }
            let values = is_prescribed.iter().zip(&increments);
            let values: Vec<f64> = values.filter(|(is, _)| **is).map(|(_, p)| *p).collect();
            let extension =
                self.energy.parts()[index].extend(&DofMap::new(&is_prescribed), &values);
            self.kinematics.add_free(index, &extension, lifted);
        }
    }
}
