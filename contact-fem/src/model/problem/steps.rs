//! The problem at one load after the other.

use contact_core::equilibrium::Solution;
use contact_core::load_steps::Passage;
use contact_core::{Error, LoadStepped};

use super::Problem;
use crate::assembly::{Dof, DofMap};
use crate::audit::Overlap;
use crate::model::tie::Follower;
use crate::model::{Geometry, Overlaps, courses};

impl<const D: usize> LoadStepped for Problem<D> {
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
        // cutting a step does not change the solution of a linear scene; its certificate tells
        let overlap = match (self.contact.geometry, self.scene.overlaps) {
            (Geometry::Current, Overlaps::Refused) => {
                let now = self.audit.deep_overlap(&after, relative);
                now.or_else(|| self.audit.passage(&before, &after, of_thickness))
            }
            _ => None,
        };
        let inside = |found: Overlap<D>| {
            let [first, second] = found.bodies.map(|body| self.scene.called(body));
            let at: Vec<String> = found.at.iter().map(|x| format!("{x:.3e}")).collect();
            Passage {
                depth: found.depth,
                place: format!("{first} is inside {second} at ({})", at.join(", ")),
            }
        };
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

impl<const D: usize> Problem<D> {
    /// As [`LoadStepped::lift`], with what follows others moved along with them.
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

#[cfg(test)]
mod tests {
    use crate::certificate::Limits;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::model::Geometry;
    use crate::{Body, LinearElastic, Material, Mesh, Motion, NeoHookean, Obstacle, Scene};
    use crate::{Simulation, simulation::History};

    fn mesh(x: [f64; 3], y: [f64; 3]) -> Mesh<2> {
        let line = |[low, high, count]: [f64; 3]| linspace(low, high, count as usize);
        rectangle(&line(x), &line(y), Diagonals::Rising).expect("a mesh")
    }

    /// A body that is held on two sides, and a ball on its top that moves by `by`, in one increment.
    fn pressed(
        (mesh, law): (Mesh<2>, impl Material<2>),
        sides: [&str; 2],
        (centre, radius, by): ([f64; 2], f64, [f64; 2]),
        geometry: Geometry,
    ) -> History<2> {
        let mut body = Body::new(mesh, law);
        for side in sides {
            body.prescribe(side, [Some(0.0); 2]).expect("a support");
        }
        let mut scene = Scene::new();
        let side = scene.add("body", body).on("top");
        let ball = Obstacle::ball(centre, radius).expect("a ball");
        let ball = ball.moving(Motion::translation(by).expect("a way"));
        scene.obstacle("ball", side, ball).expect("a side");
        scene.geometry = Some(geometry);
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(1).run(&mut problem);
        history.expect("no misuse")
    }

    /// A cantilever under a ball of radius 0.1 that touches it. Rows at the reference positions hold the ball until its centre
    /// has come to where the nodes are at rest. Then they would push it out on the other side.
    #[test]
    fn obstacles_do_not_go_through_reference_positions() {
        let law = || LinearElastic::new(1e5, 0.3).expect("a law");
        let mesh = || mesh([0.0, 10.0, 40.0], [0.0, 0.2, 2.0]).quadratic();
        let run = |way: f64| {
            let ball = ([9.0, 0.3], 0.1, [0.0, -way]);
            pressed((mesh(), law()), ["left"; 2], ball, Geometry::Reference)
        };
        let history = run(0.05);
        assert!(history.is_complete(), "{}", history.run.ending);
        assert!(history.last().expect("a step").obstacle_forces[0][1] > 0.0);
        for way in [0.12, 0.2, 0.35, 0.45, 2.0] {
            let history = run(way);
            assert!(!history.is_complete(), "{way}");
            for step in &history.steps {
                let down = way * step.factor;
                assert!(down < 0.1 + 1e-9, "{way}: {down}");
                assert!(step.obstacle_forces[0][1] > 0.0, "{way}: {down}");
            }
        }
    }

    /// A ball that is smaller than the facets moves into a block, or through a beam, between the nodes: in the block it is deeper
    /// than its facets are long. The run does not say that all is well. In a block of small facets it goes on.
    #[test]
    fn obstacles_between_nodes_do_not_enter_bodies() {
        let law = || NeoHookean::new(100.0, 0.3).expect("a law");
        let is_sound = |history: &History<2>| {
            let certificate = history.certificate();
            let holds = certificate.is_none_or(|own| own.holds(&Limits::default()));
            history.is_complete() && holds
        };
        let beam = || mesh([-5.0, 5.0, 30.0], [0.0, 0.5, 3.0]);
        let block = |cells: f64| mesh([0.0, 3.0, cells], [0.0, 3.0, cells]);
        let entered = pressed(
            (block(3.0), law()),
            ["bottom"; 2],
            ([1.62, 3.2], 0.15, [0.0, -1.8]),
            Geometry::Current,
        );
        let through = |geometry: Geometry| {
            let ball = ([0.17, 0.62], 0.1, [0.0, -2.0]);
            pressed((beam(), law()), ["left", "right"], ball, geometry)
        };
        for history in [
            entered,
            through(Geometry::Current),
            through(Geometry::Reference),
        ] {
            assert!(!is_sound(&history), "{}", history.run.ending);
        }
        let sound = pressed(
            (block(12.0), law()),
            ["bottom"; 2],
            ([1.52, 3.45], 0.4, [0.0, -0.55]),
            Geometry::Current,
        );
        assert!(is_sound(&sound), "{}", sound.run.ending);
    }
}
