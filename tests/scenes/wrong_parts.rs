//! Laws and methods that are wrong: what they give is not certified.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use contact_core::method::{Method, Minimum, Subproblem};
use contact_core::{Ending, InteriorPoint, Retry, State};
use contact_fem::material::Deformation;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::simulation::History;
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{Body, Error, LinearElastic, Material, NeoHookean, Scene, Simulation};
use ipopt_contact_scenes::pair;

/// A block on another one, pressed by 5 %.
fn pressed(law: impl Material<2>) -> Scene<2> {
    let block = |y: f64, n: usize| {
        let mesh = rectangle(
            &linspace(0.0, 1.0, n),
            &linspace(y, y + 1.0, n),
            Diagonals::Rising,
        );
        Body::new(mesh.expect("mesh"), law.clone())
    };
    let (mut lower, mut upper) = (block(0.0, 3), block(1.0, 4));
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    upper
        .prescribe("top", [Some(0.0), Some(-0.1)])
        .expect("support");
    pair((lower, "top"), (upper, "bottom")).expect("surfaces")
}

/// Whether a run says that it is right: complete, and every certificate holds.
fn claims(history: &History<2>) -> bool {
    let certificate = history.certificate();
    history.is_complete() && certificate.is_some_and(|c| c.holds(&Default::default()))
}

/// A law that is right but for its tangent, and for the energies from one of its evaluations on.
#[derive(Clone)]
struct Wrong<M> {
    law: M,
    tangent: f64,
    calls: Arc<AtomicUsize>,
    from: usize,
    energy: f64,
}

impl<M: Material<2>> Material<2> for Wrong<M> {
    const QUADRATIC: bool = M::QUADRATIC;
    const NEEDS_POSITIVE_J: bool = M::NEEDS_POSITIVE_J;

    fn energy_density(&self, at: &Deformation<2>) -> f64 {
        match self.calls.fetch_add(1, Ordering::Relaxed) >= self.from {
            true => self.energy,
            false => self.law.energy_density(at),
        }
    }
    fn stress(&self, at: &Deformation<2>) -> Matrix<2> {
        self.law.stress(at)
    }
    fn contraction(&self, at: &Deformation<2>) -> impl Fn(&Vector<2>, &Vector<2>) -> Matrix<2> {
        let A = self.law.contraction(at);
        let tangent = self.tangent;
        move |a, b| A(a, b) * tangent
    }
    fn cauchy_stress(&self, at: &Deformation<2>) -> (Matrix<2>, f64) {
        self.law.cauchy_stress(at)
    }
}

fn right<M>(law: M) -> Wrong<M> {
    Wrong {
        law,
        tangent: 1.0,
        calls: Arc::default(),
        from: usize::MAX,
        energy: f64::NAN,
    }
}

/// A scene with the law is refused, by names.
fn refused(law: impl Material<2>, expected: &str) {
    match pressed(law).problem().err() {
        Some(Error::LawDiffers {
            body, what, error, ..
        }) => {
            assert_eq!((body.as_str(), what), ("first", expected));
            assert!(!(error <= 0.1), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

/// Tangents and energies that are none of the law's are refused. With a tangent 1e12 times too large nothing would move, and
/// all that is left of the forces would be small against the stiffness.
#[test]
fn laws_with_wrong_derivatives_are_refused() {
    fn of(law: impl Material<2>) {
        for tangent in [1e-12, 1e-6, 0.5, 3.0, 1e3, 1e6, 1e12, -1.0, f64::NAN] {
            refused(
                Wrong {
                    tangent,
                    ..right(law.clone())
                },
                "tangent",
            );
        }
        for energy in [0.0, f64::NAN] {
            refused(
                Wrong {
                    energy,
                    from: 0,
                    ..right(law.clone())
                },
                "stress",
            );
        }
        // close enough to converge, and sound
        let law = Wrong {
            tangent: 1.0001,
            ..right(law)
        };
        assert!(pressed(law).problem().is_ok());
    }
    of(NeoHookean::new(1e3, 0.3).expect("law"));
    of(LinearElastic::new(1e3, 0.3).expect("law"));
}

/// A law whose energies are no numbers from one of its last evaluations on: no step with such an energy is a result.
#[test]
fn energies_that_are_no_numbers_at_the_end() {
    fn of(law: impl Material<2>) {
        let count = right(law.clone());
        let calls = count.calls.clone();
        let mut problem = pressed(count).problem().expect("sound");
        let sound = Simulation::with_increments(2)
            .run(&mut problem)
            .expect("run");
        assert!(claims(&sound));
        let sound = sound.last().expect("complete").energy;
        let total = calls.load(Ordering::Relaxed);
        for energy in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for before in (1..200).step_by(7) {
                let from = total - before.min(total / 2);
                let law = Wrong {
                    from,
                    energy,
                    ..right(law.clone())
                };
                let mut problem = pressed(law).problem().expect("sound so far");
                let history = Simulation::with_increments(2)
                    .run(&mut problem)
                    .expect("run");
                assert!(history.steps.iter().all(|step| step.energy.is_finite()));
                if claims(&history) {
                    // the last evaluations are not used; without them, the energy is that of the solver
                    let energy = history.last().expect("complete").energy;
                    assert!((energy - sound).abs() <= 1e-12 * sound, "{energy}");
                }
            }
        }
    }
    of(NeoHookean::new(1e3, 0.3).expect("law"));
    of(LinearElastic::new(1e3, 0.3).expect("law"));
}

/// Poisson's ratios up to those that round-off forbids: what is certified is in balance, by a sum of its own.
#[test]
fn incompressibility_up_to_round_off() {
    for below in [1e-4, 1e-6, 1e-8, 1e-9, 1.2e-10] {
        let nu = 0.5 - below;
        let scenes = [
            pressed(NeoHookean::new(1e3, nu).expect("law")),
            pressed(LinearElastic::new(1e3, nu).expect("law")),
        ];
        for scene in scenes {
            let mut problem = scene.problem().expect("sound");
            let mut simulation = Simulation::with_increments(2);
            simulation.load_steps.budget.factorizations = Some(2000);
            let history = simulation.run(&mut problem).expect("run");
            if claims(&history) {
                let [lower, upper] = [0, 1].map(|k| history.last().expect("complete").reactions[k]);
                let left = (lower + upper).norm() / lower.norm();
                assert!(left < 1e-5, "{nu}: {lower} and {upper}");
            }
        }
    }
    let refused = [
        0.5 - 1e-10,
        0.5 - 1e-12,
        0.499_999_999_999_999_9,
        0.499_999_999_999_999_94,
        -1.0 + 1e-10,
        -0.999_999_999_999_999_9,
    ];
    for nu in refused {
        let error = NeoHookean::new(1e3, nu).expect_err("hidden by round-off");
        assert!(matches!(error, Error::ModuliApart { .. }), "{error}");
        assert!(LinearElastic::new(1e3, nu).is_err());
    }
}

/// A method whose minima are spoilt from one of its calls on.
struct Spoilt<F> {
    method: InteriorPoint,
    calls: usize,
    at: usize,
    spoil: F,
}

impl<F: Fn(&mut Minimum)> Method for Spoilt<F> {
    fn minimize(
        &mut self,
        subproblem: &Subproblem<'_>,
        start: &State,
    ) -> Result<Minimum, contact_core::Error> {
        let mut minimum = self.method.minimize(subproblem, start)?;
        if self.calls >= self.at {
            (self.spoil)(&mut minimum);
        }
        self.calls += 1;
        Ok(minimum)
    }
}

/// Methods that return no numbers, other lengths, or another energy, from any of their calls on, the last one included.
#[test]
fn methods_that_return_nonsense() {
    type Spoil<'a> = &'a dyn Fn(&mut Minimum);
    for large in [true, false] {
        let run = |at: usize, spoil: Spoil<'_>| {
            let scene = match large {
                true => pressed(NeoHookean::new(1e3, 0.3).expect("law")),
                false => pressed(LinearElastic::new(1e3, 0.3).expect("law")),
            };
            let mut problem = scene.problem().expect("sound");
            let mut method = Spoilt {
                method: InteriorPoint::default(),
                calls: 0,
                at,
                spoil,
            };
            let history = Simulation::solved_by(Retry::with(&mut method), 2).run(&mut problem);
            (method.calls, history)
        };
        let (total, sound) = run(usize::MAX, &|_| ());
        let sound = sound.expect("run");
        assert!(claims(&sound));
        let energies: Vec<f64> = sound.steps.iter().map(|step| step.energy).collect();
        for at in 0..total {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let spoils: [Spoil<'_>; 3] = [
                    &|minimum| minimum.energy = bad,
                    &|minimum| minimum.u[1] = bad,
                    &|minimum| minimum.lambda.fill(bad),
                ];
                for spoil in spoils {
                    let history = run(at, spoil).1.expect("no error");
                    assert!(!history.is_complete(), "{}", history.run.ending);
                    // what has converged before is kept
                    let kept = history.steps.iter().map(|step| step.energy);
                    assert!(kept.zip(&energies).all(|(a, b)| a == *b));
                }
            }
            let shorter: [Spoil<'_>; 2] = [&|minimum| minimum.u.truncate(5), &|minimum| {
                minimum.lambda.truncate(1)
            }];
            for spoil in shorter {
                match run(at, spoil).1 {
                    Ok(history) => {
                        assert!(matches!(history.run.ending, Ending::Failed { .. }));
                        assert_eq!(history.steps.len(), 1);
                        assert_eq!(history.steps[0].energy, energies[0]);
                    }
                    Err(error) => assert!(error.to_string().contains("length"), "{error}"),
                }
            }
            // the energy is computed from u, whatever the method says
            let history = run(at, &|minimum| minimum.energy *= 2.0)
                .1
                .expect("no error");
            assert_eq!(history.last().expect("complete").energy, energies[1]);
        }
    }
}
