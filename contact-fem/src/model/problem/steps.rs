//! The problem at one load after the other.

use contact_core::equilibrium::Solution;
use contact_core::load_steps::Passage;
use contact_core::{Error, LoadStepped};

use super::Problem;

impl<const D: usize> LoadStepped for Problem<D> {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.answers_mut().set_load(factor)
    }

    fn check_phases(&mut self, ends: &[f64]) -> Result<(), Error> {
        self.answers_mut().check_phases(ends)
    }

    fn corners(&self) -> Vec<f64> {
        self.answers().corners()
    }

    fn begin(
        &mut self,
        span: [f64; 2],
        u: &[f64],
        solution: Option<&Solution>,
    ) -> Result<Option<Vec<f64>>, Error> {
        self.answers_mut().begin(span, u, solution)
    }

    fn take_back(&mut self) {
        self.answers_mut().take_back();
    }

    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<Passage> {
        self.answers().tunnels(u, last, from)
    }

    fn hold(&self, solution: &Solution) -> Option<String> {
        self.answers().hold(solution)
    }

    fn unplanned(&self, u: &[f64]) -> Option<String> {
        self.answers().unplanned(u)
    }

    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        self.answers().lift(u, from)
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
