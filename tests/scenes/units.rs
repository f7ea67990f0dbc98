//! The same scene in other units takes the same iterations to the same result.

use crate::common::{UNITS, relative, run};
use contact_fem::simulation::History;
use ipopt_contact_scenes::disc_in_disc;

/// A coarse disc-in-disc with lengths times `length` and moduli times `modulus`.
fn scaled(length: f64, modulus: f64) -> History<2> {
    let scene = disc_in_disc::in_units(length, modulus).expect("a scene");
    run(&mut scene.problem().expect("valid scene"), 10, 1e-7)
}

#[test]
fn results_and_iterations_do_not_depend_on_units() {
    let reference = scaled(1.0, 1.0);
    for (length, modulus) in UNITS {
        let other = scaled(length, modulus);
        assert_eq!(other.steps.len(), reference.steps.len());
        for (a, b) in other.steps.iter().zip(&reference.steps) {
            let (fine, coarse) = (a.attempt.cost, b.attempt.cost);
            assert_eq!(a.attempt.iterations.len(), b.attempt.iterations.len());
            assert_eq!(fine.inner_iterations, coarse.inner_iterations);
            assert!((a.energy / (modulus * length * length) - b.energy).abs() < 1e-7 * 300.0);
            let force = a.reactions[0][1] / (modulus * length);
            assert!((force - b.reactions[0][1]).abs() < 1e-6 * 1000.0);
        }
        let last = (
            other.steps.last().expect("steps"),
            reference.steps.last().expect("steps"),
        );
        assert!(relative(last.0.energy / (modulus * length * length), last.1.energy) < 1e-8);
    }
}
