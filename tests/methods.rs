//! The three methods on the same scenes.

#![allow(non_snake_case)] // the symbols of the field

#[path = "../examples/support/beams.rs"]
#[allow(dead_code)]
mod beams;
mod common;
#[path = "../examples/support/hairpin.rs"]
#[allow(dead_code)]
mod hairpin;

use common::{Order, disc_in_disc, run_with};
use contact_core::InteriorPoint;
use contact_core::method::{Method, PenalizedSlack, Penalty};
use contact_fem::scene::{Passes, Problem};

fn solve<const D: usize>(
    name: &str,
    mut problem: Problem<D>,
    increments: usize,
    tol: f64,
    method: &mut dyn Method,
) {
    let t = std::time::Instant::now();
    let history = run_with(method, &mut problem, increments, tol);
    let e = history.steps.last().map_or(0.0, |s| s.energy);
    let its: usize = history
        .steps
        .iter()
        .map(|s| {
            s.attempt
                .iterations
                .iter()
                .map(|i| i.effort.iterations)
                .sum::<usize>()
        })
        .sum();
    let fps: usize = history
        .steps
        .iter()
        .map(|s| s.attempt.iterations.len())
        .sum();
    println!(
        "ZZ {name} {:?} E {e} ipopt {its} fp {fps} {:.2}s",
        history.run.outcome,
        t.elapsed().as_secs_f64()
    );
    println!("ZZ   {:?}", history.certificate());
}
#[test]
fn table() {
    let disc = || disc_in_disc(32, Passes::Both, Order::RingFirst);
    solve("ip", disc(), 20, 1e-6, &mut InteriorPoint::default());
    solve("ip", disc(), 20, 1e-8, &mut InteriorPoint::default());
    solve(
        "ip1",
        disc_in_disc(32, Passes::FirstIsSlave, Order::RingFirst),
        20,
        1e-6,
        &mut InteriorPoint::default(),
    );
    solve(
        "hairpin",
        hairpin::scene(3, true).unwrap().problem().unwrap(),
        8,
        1e-6,
        &mut InteriorPoint::default(),
    );
    solve(
        "hairpin",
        hairpin::scene_in_space(2, 2).unwrap().problem().unwrap(),
        8,
        1e-6,
        &mut InteriorPoint::default(),
    );
    solve(
        "slack default",
        disc(),
        20,
        1e-6,
        &mut PenalizedSlack::default(),
    );
    solve("penalty default", disc(), 20, 1e-6, &mut Penalty::default());
}
