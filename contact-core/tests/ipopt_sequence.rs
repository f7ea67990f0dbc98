//! Runs of similar problems: warm starts pay, failures are repeated cold, and nothing of it is hidden.
#![cfg(feature = "ipopt")]

use std::ops::ControlFlow;

use contact_core::{
    ipopt::{Options, Run, Sequence, SequenceSettings, Solution, Solver, Start, Status},
    nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure},
};

use problems::{HS071_START, Hs071, Obstacle, assert_close, hs071_solver, hs071_structure};

/// Young's modulus, so large that the forces of the problem are about 1, as tolerances expect.
const E: f64 = 1e3;

/// An elastic block (ν = 0.3) of `SIZE` unit bricks above a floor that rises towards the middle, pressed down
/// by `load`. The rows say that the block, averaged around each node of its lower face, stays above the floor.
struct Block {
    load: f64,
    stiffness: Vec<f64>,
    pattern: Pattern,
    rows: Vec<(usize, usize, f64)>,
    top: Vec<usize>,
}

const SIZE: [usize; 3] = [7, 6, 4];

fn node(i: usize, j: usize, k: usize) -> usize {
    (k * (SIZE[1] + 1) + j) * (SIZE[0] + 1) + i
}

fn dofs() -> usize {
    3 * SIZE.iter().map(|n| n + 1).product::<usize>()
}

/// The stiffness of a unit brick with trilinear shape functions, by 2 × 2 × 2 Gauss points.
fn brick() -> Vec<[f64; 24]> {
    let (lambda, mu) = (E * 0.3 / (1.3 * 0.4), E / 2.6);
    let points = [0.5 - 0.75f64.sqrt() / 3.0, 0.5 + 0.75f64.sqrt() / 3.0];
    let mut k = vec![[0.0; 24]; 24];
    for q in 0..8 {
        let at = [points[q & 1], points[q >> 1 & 1], points[q >> 2]];
        let gradients: Vec<[f64; 3]> = (0..8)
            .map(|a| {
                let upper = [a & 1 == 1, a >> 1 & 1 == 1, a >> 2 == 1];
                let value = |i: usize| if upper[i] { at[i] } else { 1.0 - at[i] };
                let slope = |i: usize| if upper[i] { 1.0 } else { -1.0 };
                [
                    slope(0) * value(1) * value(2),
                    value(0) * slope(1) * value(2),
                    value(0) * value(1) * slope(2),
                ]
            })
            .collect();
        for (a, at_a) in gradients.iter().enumerate() {
            for (b, at_b) in gradients.iter().enumerate() {
                let dot: f64 = at_a.iter().zip(at_b).map(|(x, y)| x * y).sum();
                for i in 0..3 {
                    for j in 0..3 {
                        let shear = mu * at_a[j] * at_b[i] + if i == j { mu * dot } else { 0.0 };
                        k[3 * a + i][3 * b + j] += (lambda * at_a[i] * at_b[j] + shear) / 8.0;
                    }
                }
            }
        }
    }
    k
}

impl Block {
    fn new() -> Self {
        let mut entries = std::collections::BTreeMap::new();
        let k = brick();
        let [nx, ny, nz] = SIZE;
        for (i, j, l) in (0..nx * ny * nz).map(|e| (e % nx, e / nx % ny, e / (nx * ny))) {
            let corner = |a: usize| node(i + (a & 1), j + (a >> 1 & 1), l + (a >> 2));
            for (a, row) in k.iter().enumerate() {
                for (b, value) in row.iter().enumerate() {
                    let place = (3 * corner(a / 3) + a % 3, 3 * corner(b / 3) + b % 3);
                    if place.1 <= place.0 {
                        *entries.entry(place).or_insert(0.0) += value;
                    }
                }
            }
        }
        let mut rows = Vec::new();
        for (row, (i, j)) in (0..(nx + 1) * (ny + 1)).map(|r| (r, (r % (nx + 1), r / (nx + 1)))) {
            let near = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n + 1);
            let around: Vec<_> = near(i, nx)
                .flat_map(|a| near(j, ny).map(move |b| (a, b)))
                .collect();
            let weight = |(a, b): (usize, usize)| if (a, b) == (i, j) { 4.0 } else { 1.0 };
            let whole: f64 = around.iter().map(|&ab| weight(ab)).sum();
            rows.extend(
                around
                    .iter()
                    .map(|&(a, b)| (row, 3 * node(a, b, 0) + 2, weight((a, b)) / whole)),
            );
        }
        Self {
            load: 0.0,
            pattern: entries.keys().copied().collect(),
            stiffness: entries.into_values().collect(),
            rows,
            top: (0..=nx)
                .flat_map(|i| (0..=ny).map(move |j| 3 * node(i, j, nz) + 2))
                .collect(),
        }
    }

    /// Held in x at x = 0, in y at y = 0; the floor is 0.02 below at the middle and lower outwards.
    fn structure(&self) -> Structure {
        let [nx, ny, nz] = SIZE;
        let mut variables = Bounds::free(dofs());
        for k in 0..=nz {
            let left = (0..=ny).map(|j| 3 * node(0, j, k));
            let front = (0..=nx).map(|i| 3 * node(i, 0, k) + 1);
            for dof in left.chain(front) {
                variables.lower[dof] = 0.0;
                variables.upper[dof] = 0.0;
            }
        }
        let gap = |r: usize| {
            let (i, j) = (r % (nx + 1), r / (nx + 1));
            let offset = |at: usize, n: usize| (at as f64 - 0.5 * n as f64).powi(2);
            -0.02 - 0.001 * (offset(i, nx) + offset(j, ny))
        };
        let m = (nx + 1) * (ny + 1);
        let constraints = Bounds {
            lower: (0..m).map(gap).collect(),
            upper: vec![f64::INFINITY; m],
        };
        let jacobian = self.rows.iter().map(|&(i, j, _)| (i, j)).collect();
        Structure::new(variables, constraints, jacobian, Some(self.pattern.clone()))
            .expect("well formed")
            .with_constant_hessian(true)
            .with_constant_jacobian(true)
    }
}

impl Nlp for &mut Block {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let mut gradient = vec![0.0; x.len()];
        let pressed: f64 = self.top.iter().map(|&dof| self.load * x[dof]).sum();
        self.gradient(x, true, &mut gradient);
        let product: f64 = gradient.iter().zip(x).map(|(g, x)| g * x).sum();
        0.5 * (product + pressed)
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for ((row, col), value) in self.pattern.iter().zip(&self.stiffness) {
            gradient[row] += value * x[col];
            if row != col {
                gradient[col] += value * x[row];
            }
        }
        for &dof in &self.top {
            gradient[dof] += self.load;
        }
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g.fill(0.0);
        self.rows.iter().for_each(|&(i, j, v)| g[i] += v * x[j]);
    }

    fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
        values
            .iter_mut()
            .zip(&self.rows)
            .for_each(|(v, row)| *v = row.2);
    }

    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values
            .iter_mut()
            .zip(&self.stiffness)
            .for_each(|(v, k)| *v = sigma * k);
    }
}

fn median(mut counts: Vec<usize>) -> usize {
    counts.sort_unstable();
    counts[counts.len() / 2]
}

/// Quadratic problems of contact in space, load steps of 5 %.
#[test]
fn warm_starts_take_less_than_half_of_the_iterations() {
    let mut block = Block::new();
    let start = vec![0.0; dofs()];
    let settings = SequenceSettings {
        options: Options::new()
            .with("tol", 1e-12)
            .with("mu_strategy", "adaptive"),
        ..SequenceSettings::default()
    };
    let mut cold_solver = Solver::new(block.structure(), &settings.options).unwrap();
    let mut sequence = Sequence::new(block.structure(), settings, &start).unwrap();
    let (mut warm, mut cold, mut touching) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..30 {
        block.load = 1.05f64.powi(step);
        let run = sequence.solve(&mut &mut block).unwrap();
        let reference = cold_solver
            .solve(&mut &mut block, &Start::at(&start))
            .unwrap();
        assert!(
            run.solved && run.retried.is_none() && run.warm == (step > 0),
            "{step}: {run:?}"
        );
        assert_eq!(reference.status, Status::Solved);
        let size = reference.x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert_close(&run.solution.x, &reference.x, 1e-8 * size);
        // the floor carries the load
        let forces = run.solution.multipliers.expect("solved").constraints;
        let carried: f64 = -forces.iter().sum::<f64>();
        let load = block.load * block.top.len() as f64;
        assert!((carried / load - 1.0).abs() < 1e-8, "{carried} of {load}");
        touching.push(forces.iter().filter(|&&l| -l > 1e-3 * load).count());
        warm.push(run.solution.statistics.iterations);
        cold.push(reference.statistics.iterations);
    }
    println!(
        "warm {warm:?}\ncold {cold:?}\nrows that carry {touching:?}\n{}",
        sequence.totals()
    );
    assert!(
        touching[29] > touching[0] + 5,
        "contact spreads: {touching:?}"
    );
    assert_eq!(sequence.totals().warm, 29);
    assert_eq!(sequence.totals().iterations, warm.iter().sum::<usize>());
    let (warm, cold) = (median(warm.split_off(1)), median(cold));
    assert!(warm <= 4 && cold >= 9, "{warm} against {cold} iterations");
}

/// Sees the first iterate of a solve.
struct First<N> {
    nlp: N,
    seen: Option<(Vec<f64>, Multipliers)>,
    begun: Vec<Vec<f64>>,
}

impl<N: Nlp> Nlp for First<N> {
    fn begin(&mut self, x: &[f64]) {
        self.begun.push(x.to_vec());
    }
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        self.nlp.objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        self.nlp.gradient(x, new_x, gradient);
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        self.nlp.constraints(x, new_x, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        self.nlp.jacobian(x, new_x, values);
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, l: &[f64], values: &mut [f64]) {
        self.nlp.hessian(x, new_x, sigma, l, values);
    }
    fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
        if iterate.record().iteration == 0 {
            let multipliers = iterate.multipliers().expect("regular").clone();
            self.seen = Some((iterate.x().expect("there").to_vec(), multipliers));
        }
        ControlFlow::Continue(())
    }
}

/// Primal, constraint and bound multipliers are those that were given.
#[test]
fn a_warm_start_starts_there() {
    let solved: Solution = hs071_solver!()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    let multipliers = solved.multipliers.expect("solved");
    let mut solver = Solver::new(hs071_structure(), &Options::new().warm_start()).unwrap();
    let start = Start {
        x: &solved.x,
        multipliers: Some(&multipliers),
    };
    let mut nlp = First {
        nlp: Hs071,
        seen: None,
        begun: Vec::new(),
    };
    let again = solver.solve(&mut nlp, &start).unwrap();
    assert_eq!(nlp.begun.concat(), solved.x);
    let (x, seen) = nlp.seen.expect("an iterate");
    assert_close(&x, &solved.x, 1e-8);
    assert_close(&seen.constraints, &multipliers.constraints, 1e-8);
    assert_close(&seen.lower, &multipliers.lower, 1e-8);
    assert_close(&seen.upper, &multipliers.upper, 1e-8);
    assert!(again.status == Status::Solved && again.statistics.iterations <= 3);
}

/// min (x − c)² subject to x ≤ 1, which fails whenever `broken` says so of a solve by number.
struct Follow {
    c: f64,
    broken: fn(usize) -> bool,
    solves: usize,
}

impl Nlp for Follow {
    fn begin(&mut self, _: &[f64]) {
        self.solves += 1;
    }
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (x[0] - self.c).powi(2)
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = match (self.broken)(self.solves) {
            true => f64::NAN,
            false => 2.0 * (x[0] - self.c),
        };
    }
    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values[0] = 2.0 * sigma;
    }
}

fn one_variable() -> Structure {
    Structure::new(
        Bounds::uniform(1, f64::NEG_INFINITY, 1.0),
        Bounds::default(),
        Pattern::empty(),
        Some(Pattern::diagonal(1)),
    )
    .expect("well formed")
}

fn follow(broken: fn(usize) -> bool) -> Follow {
    Follow {
        c: 3.0,
        broken,
        solves: 0,
    }
}

#[test]
fn a_failed_warm_solve_is_repeated_cold_and_counted() {
    let mut sequence = Sequence::new(one_variable(), SequenceSettings::default(), &[0.0]).unwrap();
    let mut nlp = follow(|solve| solve == 2);
    let first = sequence.solve(&mut nlp).unwrap();
    assert!(first.solved && !first.warm);
    let second = sequence.solve(&mut nlp).unwrap();
    assert!(second.solved && !second.warm);
    let retried = second.retried.expect("the second solve is broken");
    assert_eq!(retried.status, Status::InvalidNumber);
    assert_close(&second.solution.x, &[1.0], 1e-7);
    let third = sequence.solve(&mut nlp).unwrap();
    assert!(third.solved && third.warm && third.retried.is_none());
    let totals = sequence.totals();
    assert_eq!((totals.problems, totals.failures), (3, 0));
    assert_eq!((totals.warm, totals.cold, totals.cold_retries), (2, 2, 1));
    assert_eq!(nlp.solves, 4);
}

/// After a problem that could not be solved, the next one starts from the last solution, not from the failure.
#[test]
fn failures_leave_no_trace_in_the_memory() {
    let mut sequence = Sequence::new(one_variable(), SequenceSettings::default(), &[0.0]).unwrap();
    let mut nlp = follow(|solve| solve == 2 || solve == 3);
    let first = sequence.solve(&mut nlp).unwrap();
    let failed = sequence.solve(&mut nlp).unwrap();
    assert!(!failed.solved && failed.retried.is_some());
    assert_eq!(failed.solution.multipliers, None, "none worth the name");
    assert_eq!(sequence.start().x, first.solution.x);
    assert_eq!(
        sequence.start().multipliers,
        first.solution.multipliers.as_ref()
    );
    let third = sequence.solve(&mut nlp).unwrap();
    assert!(third.solved && third.warm);
    assert_eq!(sequence.totals().failures, 1);
    // a failure at the very start leaves nothing to start warm from
    let mut sequence = Sequence::new(one_variable(), SequenceSettings::default(), &[0.0]).unwrap();
    let mut nlp = follow(|solve| solve == 1);
    assert!(!sequence.solve(&mut nlp).unwrap().solved);
    let second = sequence.solve(&mut nlp).unwrap();
    assert!(second.solved && !second.warm && second.retried.is_none());
}

/// A string above a floor, and multipliers so far off that a warm start from them takes more than twice the
/// iterations of a cold one.
fn lost() -> (Obstacle, Structure, Vec<f64>, Multipliers) {
    let n = 40;
    let far_off = Multipliers {
        constraints: vec![1e4; n],
        lower: vec![0.0; n],
        upper: vec![0.0; n],
    };
    let obstacle = Obstacle { n, load: 4.0 };
    (
        obstacle,
        Obstacle::structure(n, -0.1),
        vec![1.0; n],
        far_off,
    )
}

#[test]
fn iterations_that_blow_up_are_cut_short() {
    let (mut obstacle, structure, x, far_off) = lost();
    let zeros = vec![0.0; x.len()];
    let mut outcome = |settings: SequenceSettings| {
        let mut sequence = Sequence::new(structure.clone(), settings, &zeros).unwrap();
        let cold = sequence.solve(&mut obstacle).unwrap().solution;
        // The sequence goes on with problems of the same kind, so that this solve can be too long.
        sequence.restart(&x, Some(far_off.clone())).unwrap();
        let run = sequence.solve(&mut obstacle).unwrap();
        assert!(run.solved && run.warm == run.retried.is_none(), "{run:?}");
        assert_close(&run.solution.x, &cold.x, 1e-6);
        assert_eq!(sequence.totals().cold_retries, usize::from(!run.warm));
        (cold.statistics.iterations, run)
    };
    let blow_up = |blow_up| SequenceSettings {
        blow_up,
        ..SequenceSettings::default()
    };

    let (cold, run) = outcome(SequenceSettings::default());
    assert!(2 * cold < SequenceSettings::LEAST, "{cold}");
    let least = Some((Status::IterationLimit, SequenceSettings::LEAST));
    let retried = |run: &Run| {
        run.retried
            .map(|retried| (retried.status, retried.iterations))
    };
    assert_eq!(retried(&run), least);
    // A little more is not enough, three times a cold solve is.
    let factor = (SequenceSettings::LEAST + 2) as f64 / cold as f64;
    let (_, run) = outcome(blow_up(factor + 1e-6));
    assert_eq!(
        retried(&run),
        Some((Status::IterationLimit, SequenceSettings::LEAST + 2))
    );
    let (_, run) = outcome(blow_up(3.0));
    assert!(run.warm && run.solution.statistics.iterations > SequenceSettings::LEAST + 2);
}

/// How long solves of another structure take says nothing.
#[test]
fn what_blows_up_is_forgotten_with_the_structure() {
    let (mut obstacle, structure, x, far_off) = lost();
    let mut sequence = Sequence::new(one_variable(), SequenceSettings::default(), &[0.0]).unwrap();
    assert!(sequence.solve(&mut follow(|_| false)).unwrap().solved);
    sequence
        .set_structure(structure, &x, Some(far_off))
        .unwrap();
    let run = sequence.solve(&mut obstacle).unwrap();
    assert!(run.solved && run.warm && run.retried.is_none(), "{run:?}");
    assert!(run.solution.statistics.iterations > SequenceSettings::LEAST);
}

#[test]
fn another_structure_starts_cold_unless_told_otherwise() {
    let mut sequence = Sequence::new(one_variable(), SequenceSettings::default(), &[0.0]).unwrap();
    assert!(sequence.solve(&mut follow(|_| false)).unwrap().solved);
    sequence
        .set_structure(hs071_structure(), &HS071_START, None)
        .unwrap();
    let cold = sequence.solve(&mut Hs071).unwrap();
    assert!(cold.solved && !cold.warm);
    let multipliers = cold.solution.multipliers.clone();
    sequence
        .set_structure(hs071_structure(), &cold.solution.x, multipliers)
        .unwrap();
    let warm = sequence.solve(&mut Hs071).unwrap();
    assert!(warm.solved && warm.warm && warm.solution.statistics.iterations <= 3);
}

#[test]
fn a_stop_is_no_failure_to_repeat() {
    let mut sequence =
        Sequence::new(hs071_structure(), SequenceSettings::default(), &HS071_START).unwrap();
    sequence.solve(&mut Hs071).unwrap();
    let mut stopping = problems::Watched::new(Hs071, |function| match function {
        problems::Function::Iterate => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    });
    let run = sequence.solve(&mut stopping).unwrap();
    assert!(!run.solved && run.warm && run.retried.is_none());
    assert_eq!(run.solution.status, Status::StoppedByUser);
}

#[test]
fn bad_options_are_refused_at_once() {
    let settings = SequenceSettings {
        warm: Options::new().with("warm_start_bound_pusch", 1e-9),
        ..SequenceSettings::default()
    };
    let error = Sequence::new(one_variable(), settings, &[0.0]).expect_err("no such option");
    assert!(
        error.to_string().contains("warm_start_bound_pusch"),
        "{error}"
    );
}
