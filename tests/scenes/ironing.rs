//! A die that is pressed into a slab and slid along it: how even that is, and where the work goes.

use contact_core::Automatic;
use contact_fem::Simulation;
use contact_fem::element::Order;
use contact_fem::simulation::History;
use ipopt_contact_scenes::ironing::{self, Evenness, Ironing};
use ipopt_contact_scenes::tight;

/// All steps, none of which is cut or left to the fixed point, under a tight certificate.
fn slid(order: Order, steps: usize) -> (History<2>, Evenness) {
    let scene = Ironing::new(order, 36).scene().expect("a scene");
    let mut problem = scene.problem().expect("a sound scene");
    let mut simulation = Simulation::solved_by(Automatic::default(), 1);
    simulation.load_steps.phases = ironing::phases(steps.div_ceil(5), steps).to_vec();
    let history = simulation.run(&mut problem).expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    assert_eq!(history.run.cuts(), 0);
    let mut attempts = history.run.attempts.iter();
    assert!(attempts.all(|attempt| attempt.failed.is_empty()));
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    let evenness = Evenness::of(&history).expect("the end of the slide");
    (history, evenness)
}

/// The slab pulls the die towards its end on either side of its middle, alike, and the wobble on the way is small.
fn assert_even(history: &History<2>, evenness: &Evenness) {
    assert!(evenness.wobble < 3e-3, "{evenness}");
    assert!((0.01..0.02).contains(&evenness.range), "{evenness}");
    let along = |factor: f64| {
        let mut steps = history.steps.iter();
        let step = steps.find(|step| step.factor == factor);
        ironing::force(step.expect("a step"))[0] / evenness.normal
    };
    let ([left, middle, right], most) = ([1.0, 1.5, 2.0].map(along), 2.0 * evenness.wobble);
    assert!(left > 0.01 && right < -0.01, "{left} {right}");
    assert!(
        (left + right).abs() < most && middle.abs() < most,
        "{left} {middle} {right}"
    );
}

#[test]
fn linear_elements_slide_evenly_and_store_the_work() {
    let [(coarse, one), (fine, two)] = [20, 40].map(|steps| slid(Order::Linear, steps));
    assert_even(&coarse, &one);
    assert_even(&fine, &two);
    // the trapezoidal rule is of second order in the steps
    assert!(two.lost.abs() < 5e-3, "{two}");
    let ratio = one.lost / two.lost;
    assert!((3.0..6.0).contains(&ratio), "{ratio}");
}

#[test]
fn quadratic_elements_slide_evenly() {
    let (history, evenness) = slid(Order::Quadratic, 20);
    assert_even(&history, &evenness);
    assert!(evenness.lost.abs() < 2e-2, "{evenness}");
}
