//! scratch
use contact_core::*;
use contact_fem::mesh::generators::*;
use contact_fem::*;
use std::ops::ControlFlow;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tol: f64 = std::env::args().nth(1).map_or(1e-8, |s| s.parse().unwrap());
    let inc: usize = std::env::args().nth(2).map_or(100, |s| s.parse().unwrap());
    let n: usize = std::env::args().nth(3).map_or(64, |s| s.parse().unwrap());
    let layers = (12 * n) / 64;
    let radii: Vec<f64> = (0..=layers)
        .map(|k| 0.7 + 1.3 * (k as f64 / layers as f64).powf(1.3))
        .collect();
    let mut ring = Body::new(annulus(&radii, n)?, NeoHookean::new(1000.0, 0.0)?);
    ring.prescribe("outer", [Some(0.0), Some(0.0)])?;
    let mut inner = Body::new(
        disc(0.6, 52 * n / 64, 1, 0.03)?,
        NeoHookean::new(2000.0, 0.3)?,
    );
    inner.prescribe_all([Some(0.0), Some(-1.125)])?;
    let mut scene = Scene::new(vec![ring, inner]);
    scene.contact((0, "inner"), (1, "boundary"))?;
    let mut problem = scene.problem()?;
    let mut sim = Simulation::with_increments(inc);
    sim.load_steps.fixed_point.tolerance = tol;
    let mut method = InteriorPoint::default();
    for a in std::env::args().skip(4) {
        let (k, v) = a.split_once('=').unwrap();
        match k {
            "tol" => method.tolerance = v.parse()?,
            "compl" => method.complementarity = v.parse()?,
            _ => {
                if let Ok(i) = v.parse::<i32>() {
                    method.options.set(k, i);
                } else {
                    match v.parse::<f64>() {
                        Ok(x) => {
                            method.options.set(k, x);
                        }
                        Err(_) => {
                            method.options.set(k, v);
                        }
                    }
                }
            }
        }
    }
    let t = std::time::Instant::now();
    let h = sim.run(&mut problem, &mut method, |s| {
        let r = s.record;
        let e = r.attempt.effort();
        println!("{:.3} E {:.6} R {:.4} J {:.3} pen {:.1e} {:.1e} fp {} it {} fac {} val {} retr {} cb {:.2} opt {:.2} proj {:.3} errs {:?}", r.factor, r.energy, r.reactions[0][1], r.min_j, r.penetration, r.weak_penetration, r.attempt.iterations.len(), e.iterations, e.factorizations, e.values, e.cold_retries, e.callbacks, e.optimizer, r.attempt.projection(), r.attempt.iterations.iter().map(|i| format!("{:.0e}/{}", i.error, i.effort.iterations)).collect::<Vec<_>>().join(" "));
        ControlFlow::Continue(())
    })?;
    let mut e = contact_core::method::Effort::default();
    for a in &h.run.attempts {
        e += a.effort();
        if a.outcome != contact_core::fixed_point::Outcome::Converged {
            println!("{} {} {}", a.from, a.to, a.outcome);
        }
    }
    println!(
        "{:?} cuts {} {:?} fp {} wall {:?}",
        h.run.outcome,
        h.run.cuts(),
        e,
        h.run
            .attempts
            .iter()
            .map(|a| a.iterations.len())
            .sum::<usize>(),
        t.elapsed()
    );
    Ok(())
}
