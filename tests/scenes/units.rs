//! The same scene in other units takes the same iterations to the same result.

use crate::common::{relative, run};
use contact_fem::mesh::generators::{Diagonals, annulus, disc};
use contact_fem::simulation::History;
use contact_fem::{Body, NeoHookean, Scene};

/// A coarse disc-in-disc with lengths times `length` and moduli times `modulus`.
fn scaled(length: f64, modulus: f64) -> History<2> {
    let radii: Vec<f64> = [0.7, 0.8, 0.95, 1.2, 1.5, 2.0].map(|r| r * length).to_vec();
    let ring = annulus(&radii, 32, Diagonals::Alternating).expect("mesh");
    let mut ring = Body::new(ring, NeoHookean::new(1000.0 * modulus, 0.2).expect("law"));
    ring.prescribe("outer", [Some(0.0); 2]).expect("support");
    let inner = disc(0.6 * length, 26, 1, 0.03).expect("mesh");
    let mut inner = Body::new(inner, NeoHookean::new(2000.0 * modulus, 0.3).expect("law"));
    let down = [Some(0.0), Some(-0.6 * length)];
    inner.prescribe_all(down).expect("support");
    let mut scene = Scene::new(vec![ring, inner]);
    scene
        .contact((0, "inner"), (1, "boundary"))
        .expect("surfaces");
    run(&mut scene.problem().expect("valid scene"), 10, 1e-7)
}

#[test]
fn results_and_iterations_do_not_depend_on_units() {
    let reference = scaled(1.0, 1.0);
    // mm and N to m and N, and to something stiff and large
    for (length, modulus) in [(1e-3, 1e6), (1e3, 1e9), (1.0, 1e-6)] {
        let other = scaled(length, modulus);
        assert_eq!(other.steps.len(), reference.steps.len());
        for (a, b) in other.steps.iter().zip(&reference.steps) {
            let (fine, coarse) = (a.attempt.effort(), b.attempt.effort());
            assert_eq!(a.attempt.iterations.len(), b.attempt.iterations.len());
            assert_eq!(fine.iterations, coarse.iterations);
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
