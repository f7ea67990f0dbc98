//! x
#![cfg(feature = "ipopt")]
#![allow(missing_docs)]

mod collection;
#[path = "../common/mod.rs"]
mod common;
mod hyper_dual;
mod kkt;
mod problem;

use contact_core::ipopt::{Options, Solver, Start};
use contact_core::nlp::Nlp;
use kkt::Residuals;

#[test]
fn statements() {
    for p in collection::all() {
        let mut p = *p;
        for x in p.minimisers {
            let f = p.objective(x, true);
            let mut g = vec![0.0; p.m()];
            p.constraints(x, true, &mut g);
            let viol = g
                .iter()
                .zip(p.g_bounds)
                .map(|(g, b)| (b.0 - g).max(g - b.1).max(0.0))
                .fold(0.0, f64::max);
            let e = (f - p.optimum).abs() / p.optimum.abs().max(1.0);
            eprintln!(
                "{} f {f:.10e} f* {:.10e} err {e:.1e} viol {viol:.1e} {}",
                p.name,
                p.optimum,
                if e > 1e-6 || viol > 1e-4 { "<<<<" } else { "" }
            );
        }
    }
}

#[test]
fn solve() {
    for exact in [true, false] {
        for p in collection::all() {
            let mut p = *p;
            let mut s = Solver::new(p.structure(exact), &Options::new()).unwrap();
            let r = s.solve(&mut p.clone(), &Start::at(p.start)).unwrap();
            let e = (r.objective - p.optimum) / p.optimum.abs().max(1.0);
            let dx = p
                .minimisers
                .iter()
                .map(|m| {
                    m.iter()
                        .zip(&r.x)
                        .map(|(a, b)| (a - b).abs())
                        .fold(0.0, f64::max)
                        / m.iter().fold(1.0, |a: f64, b| a.max(b.abs()))
                })
                .fold(f64::INFINITY, f64::min);
            let k = r.multipliers.as_ref().map(|m| Residuals::at(p, &r.x, m));
            let flag = if !r.status.is_solved() || e.abs() > 1e-6 || dx > 1e-5 {
                "<<<<"
            } else {
                ""
            };
            eprintln!(
                "{} {} {:?} it {} f {:.9e} err {e:.1e} dx {dx:.1e} {flag}",
                if exact { "EX" } else { "LM" },
                p.name,
                r.status,
                r.statistics.iterations,
                r.objective
            );
            if !flag.is_empty() {
                eprintln!("      x = {:?}", r.x);
            }
            if let Some(k) = k {
                eprintln!(
                    "      stat {:.1e} viol {:.1e} out {:.1e} sign {:.1e} compl {:.1e}",
                    k.stationarity, k.violation, k.outside, k.sign, k.complementarity
                );
            }
        }
    }
}
