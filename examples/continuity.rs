//! A row that jumps, and the paper's iteration with it: the disc-in-disc with 50 segments around the hole, at load 0.84.
//!
//! ```text
//! cargo run --release --example continuity
//! ```
//!
//! With 4 Gauss points a segment, the discs are solved up to load 0.83. Then
//!
//! - `cycle.svg` shows the changes of the paper's plain iteration at load 0.84, with feet at the closest points and along normals;
//! - `entry.svg` shows one entry of C(u) on the line between the two states that the iteration with closest points comes back to.
//!
//! Both are in `out/continuity`; `docs/continuity.md` explains them.

use std::collections::BTreeMap;
use std::path::Path;

use ipopt_contact::contact_core::gaps::Sampling;
use ipopt_contact::contact_core::{
    Acceleration, ContactProblem, Equilibrium, FixedPoint, InteriorPoint, LoadStepped, State,
};
use ipopt_contact::contact_fem::output::picture::{Curve, Curves};
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};

const BOTH: [(Projection, &str); 2] = [
    (Projection::Closest, "closest points"),
    (Projection::AlongNormals, "along normals"),
];
/// The line is sampled at so many places.
const SAMPLES: usize = 400;

fn main() -> Result<(), Failure> {
    let out = Path::new("out/continuity");
    std::fs::create_dir_all(out)?;
    cycle()?.save(out.join("cycle.svg"))?;
    entry()?.save(out.join("entry.svg"))?;
    println!("cycle.svg and entry.svg are in {}", out.display());
    Ok(())
}

/// The discs with the paper's Gauss points.
fn discs(projection: Projection) -> Result<Problem<2>, Failure> {
    let mut scene = disc_in_disc::scene(Fineness::scaled(50), Roles::default())?;
    scene.points_as_in_the_paper();
    scene.projection = projection;
    Ok(scene.problem()?)
}

/// The equilibrium at `load`, in increments of 0.01.
fn equilibrium(problem: &mut Problem<2>, load: f64) -> Result<State, Failure> {
    let increments = (load * 100.0).round() as usize;
    let history = Simulation::in_phases([Phase::new("push", load, increments)]).run(problem)?;
    match history.is_complete() {
        true => Ok(history.run.state),
        false => Err(format!("no equilibrium at {load}").into()),
    }
}

/// Algorithm 2 as it is in the paper.
fn paper(iterations: usize) -> FixedPoint<InteriorPoint> {
    let mut paper = FixedPoint::with(InteriorPoint::default());
    paper.acceleration = Acceleration::Plain;
    paper.tolerance = 1e-8;
    paper.max_iterations = iterations;
    paper
}

/// The relative change of u in each iteration of Algorithm 2.
fn cycle() -> Result<Curves, Failure> {
    let mut curves = Vec::new();
    for (projection, name) in BOTH {
        let mut problem = discs(projection)?;
        let start = equilibrium(&mut problem, 0.83)?;
        problem.set_load(0.84)?;
        let solution = paper(60).solve_from(&problem, start)?;
        println!("{name}: {}", solution.outcome);
        let errors = solution.history.iter().enumerate();
        curves.push(Curve {
            name: name.into(),
            points: errors
                .map(|(k, at)| (k as f64 + 1.0, at.error.log10()))
                .collect(),
        });
    }
    Ok(Curves {
        title: "The plain iteration at load 0.84".into(),
        x_label: "iteration".into(),
        y_label: "log10 of the relative change of u".into(),
        curves,
    })
}

/// The entries of C(u) by pass, node and unknown.
type Entries = BTreeMap<(u32, u32, usize), f64>;

fn entries(problem: &Problem<2>, u: &[f64]) -> Result<Entries, Failure> {
    let forward = problem.linearize_gaps(u, Sampling::Nodes)?;
    let rows = forward.and(problem.linearize_reversed(u, Sampling::Nodes)?);
    let mut entries = Entries::new();
    for (i, key) in rows.keys().iter().enumerate() {
        for (j, c) in rows.row(i).free {
            entries.insert((key.pass, key.node, j), c);
        }
    }
    Ok(entries)
}

/// The entry that jumps most with closest points between the two states of their cycle, with both projections.
fn entry() -> Result<Curves, Failure> {
    let mut problem = discs(Projection::Closest)?;
    let start = equilibrium(&mut problem, 0.83)?;
    problem.set_load(0.84)?;
    let one = paper(60).solve_from(&problem, start)?.state;
    let other = paper(1).solve_from(&problem, one.clone())?.state;
    let mut sampled = Vec::new();
    for (projection, _) in BOTH {
        let mut problem = discs(projection)?;
        problem.set_load(0.84)?;
        let at = |k: usize| {
            let t = k as f64 / SAMPLES as f64;
            let u = one.u.iter().zip(&other.u);
            let u: Vec<f64> = u.map(|(a, b)| a * (1.0 - t) + b * t).collect();
            entries(&problem, &u)
        };
        sampled.push((0..=SAMPLES).map(at).collect::<Result<Vec<_>, _>>()?);
    }
    let value = |entries: &Entries, key| entries.get(key).copied().unwrap_or(0.0);
    let jump = |all: &[Entries], key| {
        let changes = all
            .windows(2)
            .map(|two| (value(&two[1], key) - value(&two[0], key)).abs());
        changes.fold(0.0, f64::max)
    };
    let keys = sampled[0][0].keys();
    let by_jump = keys.max_by(|a, b| jump(&sampled[0], a).total_cmp(&jump(&sampled[0], b)));
    let key = *by_jump.ok_or("no rows")?;
    let curves = BOTH.iter().zip(&sampled).map(|((_, name), all)| {
        println!(
            "{name}: the entry changes by {:.1e} at most from place to place",
            jump(all, &key)
        );
        let values = all.iter().enumerate();
        let values = values.map(|(k, c)| (k as f64 / SAMPLES as f64, value(c, &key)));
        Curve {
            name: (*name).into(),
            points: values.collect(),
        }
    });
    Ok(Curves {
        title: "One entry of C(u) between the two states of the cycle".into(),
        x_label: "share of the way, which is 1e-5 of the displacement".into(),
        y_label: "entry".into(),
        curves: curves.collect(),
    })
}
