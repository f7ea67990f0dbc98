//! The three methods on the same scenes: (37) and (39) approach (7) as μ grows.

#![allow(non_snake_case)] // the symbols of the field

mod common;

use common::{Order, disc_in_disc, run_with};
use contact_core::load_steps::RunOutcome;
use contact_core::method::{Continuation, Method, PenalizedSlack, Penalty};
use contact_core::InteriorPoint;
use contact_fem::scene::Passes;

#[test]
fn table() {
    let solve = |name: &str, method: &mut dyn Method| {
        let mut problem = disc_in_disc(32, Passes::Both, Order::RingFirst);
        let t = std::time::Instant::now();
        let history = run_with(method, &mut problem, 20, 1e-8);
        let e = history.steps.last().map_or(0.0, |s| s.energy);
        let r = history.steps.last().map_or(0.0, |s| s.reactions[0][1]);
        let its: usize = history.steps.iter().map(|s| s.attempt.iterations.iter().map(|i| i.effort.iterations).sum::<usize>()).sum();
        let fps: usize = history.steps.iter().map(|s| s.attempt.iterations.len()).sum();
        println!("ZZ {name} {:?} E {e} R {r} ipopt {its} fp {fps} pen {:.2e} {:.2}s", history.run.outcome, history.steps.last().map_or(0.0, |s| s.weak_penetration), t.elapsed().as_secs_f64());
    };
    solve("ip", &mut InteriorPoint::default());
    for mu in [1e2, 1e4, 1e6, 1e8, 1e10] {
        solve(&format!("slack {mu:.0e}"), &mut PenalizedSlack::with(Continuation::fixed(mu)));
    }
    solve("slack default", &mut PenalizedSlack::default());
}
