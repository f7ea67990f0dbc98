//! One random case: a problem, options, faults of its functions, and what must hold of the result.

use std::{
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind, panic_any},
    time::{Duration, Instant},
};

use contact_core::{
    ipopt::{Error, OptionValue, Options, Scaling, Solution, Solver, Start, Status},
    nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure},
};
use fastrand::Rng;

use super::problem::{Functions, Problem, number};

/// The iteration limit, unless it is one of the random options: most of what goes wrong does so early.
fn most(random: &mut Rng) -> usize {
    if random.u32(..6) == 0 { 60 } else { 12 }
}

/// The payload of panics that are part of a case.
pub struct Intended;

/// What a function does at one of its calls, or from then on.
#[derive(Debug, Clone, Copy)]
enum Fault {
    Panic,
    Value(f64),
    Break,
}

/// The functions of a problem, faults included.
struct Faulty<'a> {
    functions: &'a Functions,
    fault: Option<Fault>,
    /// Which function has it: 0 to 5, `iterate` last.
    culprit: u32,
    /// At which of its calls.
    call: usize,
    /// Whether it stays.
    stays: bool,
    /// When the solve is stopped: slow is no finding.
    until: Instant,
}

impl Faulty<'_> {
    fn spoil(&mut self, function: u32, values: &mut [f64]) -> ControlFlow<()> {
        if function != self.culprit || self.fault.is_none() {
            return ControlFlow::Continue(());
        }
        if self.call > 0 {
            self.call -= 1;
            return ControlFlow::Continue(());
        }
        let fault = if self.stays {
            self.fault
        } else {
            self.fault.take()
        };
        match fault {
            Some(Fault::Panic) => panic_any(Intended),
            Some(Fault::Break) => ControlFlow::Break(()),
            Some(Fault::Value(value)) => {
                if let Some(last) = values.last_mut() {
                    *last = value;
                }
                ControlFlow::Continue(())
            }
            None => ControlFlow::Continue(()),
        }
    }
}

impl Nlp for Faulty<'_> {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let mut value = [self.functions.f(x)];
        let _ = self.spoil(0, &mut value);
        value[0]
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        self.functions.gradient(x, gradient);
        let _ = self.spoil(1, gradient);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        self.functions.g(x, g);
        let _ = self.spoil(2, g);
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        self.functions.jacobian(x, values);
        let _ = self.spoil(3, values);
    }
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        self.functions.hessian(x, sigma, lambda, values);
        let _ = self.spoil(4, values);
    }
    fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
        // all of it is read, as an observer would
        let _ = (iterate.x(), iterate.constraints(), iterate.multipliers());
        let _ = (iterate.slacks(), iterate.violations());
        if Instant::now() > self.until {
            return ControlFlow::Break(());
        }
        self.spoil(5, &mut [])
    }
}

/// An option of this Ipopt: its name, its default, and its words if it has any.
pub struct Known {
    name: String,
    default: OptionValue,
    words: Vec<String>,
}

/// All options of this Ipopt.
pub fn known_options() -> Vec<Known> {
    let structure = || Structure::new(Bounds::free(1), Bounds::default(), Pattern::empty(), None);
    let solver = |options: &Options| Solver::new(structure().expect("well formed"), options);
    let asked = solver(&Options::new()).expect("the defaults are valid");
    let known = |name: String| {
        let default = asked.ipopt_default(&name)?;
        let words = match (
            &default,
            solver(&Options::new().with(&name, "no such word")),
        ) {
            (OptionValue::Text(_), Err(error)) => {
                let text = error.to_string();
                let words = text.split('"').skip(3).step_by(2);
                words.map(String::from).collect()
            }
            _ => Vec::new(),
        };
        Some(Known {
            name,
            default,
            words,
        })
    };
    asked
        .ipopt_options()
        .into_iter()
        .filter_map(known)
        .collect()
}

impl Known {
    fn random_value(&self, random: &mut Rng) -> OptionValue {
        let numbers = [
            0.0, 1.0, -1.0, 2.0, 0.5, 1e-3, 1e-12, 1e-300, 1e3, 1e12, 1e30, -1e30,
        ];
        match &self.default {
            OptionValue::Text(_) => match random.choice(&self.words) {
                Some(word) => word.as_str().into(),
                None => random
                    .choice(["", "x", "no such file"])
                    .unwrap_or("")
                    .into(),
            },
            OptionValue::Number(default) => match random.bool() {
                true => (default * 10f64.powi(random.i32(-4..5))).into(),
                false => numbers[random.usize(..numbers.len())].into(),
            },
            OptionValue::Integer(default) => match random.u32(..4) {
                0 => default.saturating_add(random.i32(-2..3)).into(),
                1 => random.i32(..).into(),
                _ => random.i32(-2..12).into(),
            },
        }
    }
}

/// Some options that the solver takes for this structure.
fn options(random: &mut Rng, known: &[Known], structure: &Structure) -> Options {
    let mut options = Options::new().max_iter(most(random));
    for _ in 0..random.usize(1..6) {
        let one = &known[random.usize(..known.len())];
        let prefix = if random.u32(..8) == 0 { "resto." } else { "" };
        let name = format!("{prefix}{}", one.name);
        let with = options.clone().with(&name, one.random_value(random));
        if Solver::new(structure.clone(), &with).is_ok() {
            options = with;
        }
    }
    options
}

/// How a case is made and what it uses.
pub struct Maker {
    known: Vec<Known>,
}

impl Maker {
    /// With random options, or with Ipopt's defaults.
    pub fn new(random_options: bool) -> Self {
        let known = if random_options {
            known_options()
        } else {
            Vec::new()
        };
        Maker { known }
    }

    /// Runs the case of this seed; what is wrong with it, if anything.
    pub fn run(&self, seed: u64, tell: bool) -> Result<(), String> {
        let random = &mut Rng::with_seed(seed);
        let mut problem = Problem::random(random);
        let (n, m) = (
            problem.structure.variables(),
            problem.structure.constraints(),
        );
        let set = match self.known[..] {
            [] => Options::new().max_iter(most(random)),
            _ => options(random, &self.known, &problem.structure),
        };
        if tell {
            println!(
                "{:#?}\n{:#?}\n{set:#?}",
                problem.functions, problem.structure
            );
        }
        let mut solver = match Solver::new(problem.structure.clone(), &set) {
            Ok(solver) => solver,
            Err(why) => return Err(format!("{set:?} are refused now: {why}")),
        };
        if random.u32(..10) == 0 {
            let mut factors = |n: usize| -> Option<Vec<f64>> {
                let most = if random.u32(..4) == 0 { 300 } else { 3 };
                let one = |_| 10f64.powi(random.i32(-most..=most));
                let factors = (0..n).map(one).collect();
                random.bool().then_some(factors)
            };
            let scaling = Scaling {
                variables: factors(n),
                constraints: factors(m),
                objective: if random.bool() { 1.0 } else { -1e2 },
            };
            if tell {
                println!("{scaling:?}");
            }
            let _ = solver.set_scaling(&scaling);
        }
        for _ in 0..2 {
            self.solve(random, &mut solver, &problem, &set, tell)?;
            let (variables, constraints) = problem.other_bounds(random);
            if solver.set_bounds(variables, constraints).is_err() {
                return Err("good bounds are refused".into());
            }
            problem.structure = solver.structure().clone();
        }
        Ok(())
    }

    fn solve(
        &self,
        random: &mut Rng,
        solver: &mut Solver,
        problem: &Problem,
        set: &Options,
        tell: bool,
    ) -> Result<(), String> {
        let (n, m) = (
            problem.structure.variables(),
            problem.structure.constraints(),
        );
        let mut numbers = |n: usize| -> Vec<f64> { (0..n).map(|_| number(random)).collect() };
        let x = numbers(n);
        let multipliers = Multipliers {
            constraints: numbers(m),
            lower: numbers(n),
            upper: numbers(n),
        };
        let start = Start {
            x: &x,
            multipliers: (random.u32(..4) == 0).then_some(&multipliers),
        };
        let fault = match random.u32(..10) {
            0 => Some(Fault::Panic),
            1 => Some(Fault::Value(f64::NAN)),
            2 => Some(Fault::Value(f64::INFINITY)),
            3 => Some(Fault::Break),
            4 => Some(Fault::Value(1e308)),
            _ => None,
        };
        let mut nlp = Faulty {
            functions: &problem.functions,
            fault,
            culprit: match fault {
                Some(Fault::Break) => 5,
                _ => random.u32(..6),
            },
            call: if random.bool() { 0 } else { random.usize(..12) },
            stays: random.bool(),
            until: Instant::now() + Duration::from_secs(2),
        };
        if tell {
            let (culprit, call) = (nlp.culprit, nlp.call);
            println!(
                "{start:?}\n{fault:?} in {culprit} at {call}, stays: {}",
                nlp.stays
            );
        }
        let solved = catch_unwind(AssertUnwindSafe(|| solver.solve(&mut nlp, &start)));
        if tell {
            println!("{solved:?}");
        }
        match solved {
            Err(payload) if payload.is::<Intended>() => Ok(()),
            Err(_) => Err("a panic that nobody asked for".into()),
            Ok(Err(Error::MissingMultipliers)) if start.multipliers.is_none() => Ok(()),
            Ok(Err(why)) => Err(format!("an error: {why}")),
            // a function that changes in the course of a solve has no solution to compare with
            Ok(Ok(_)) if fault.is_some() && nlp.stays => Ok(()),
            Ok(Ok(solution)) => holds(problem, set, &solution),
        }
    }
}

/// Whether what came back is what the functions say.
fn holds(problem: &Problem, set: &Options, solution: &Solution) -> Result<(), String> {
    if !matches!(solution.status, Status::Solved | Status::FeasiblePointFound) {
        return Ok(());
    }
    let (functions, structure) = (&problem.functions, &problem.structure);
    let x = &solution.x;
    let f = functions.f(x);
    let mut g = vec![0.0; structure.constraints()];
    functions.g(x, &mut g);
    let number = |name: &str, default: f64| match set.get(name) {
        Some(&OptionValue::Number(value)) => value,
        Some(&OptionValue::Integer(value)) => value.into(),
        _ => default,
    };
    let relaxed = number("bound_relax_factor", 0.0);
    if relaxed > 1e-8 {
        // Ipopt solves another problem then
        return Ok(());
    }
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs().max(b.abs()).max(1.0);
    if !near(f, solution.objective) {
        return Err(format!(
            "solved: f = {}, but it is {f} there",
            solution.objective
        ));
    }
    if !g.iter().zip(&solution.g).all(|(a, b)| near(*a, *b)) {
        return Err(format!(
            "solved: g = {:?}, but it is {g:?} there",
            solution.g
        ));
    }
    let allowed = number("constr_viol_tol", 1e-4);
    let inside = |bounds: &Bounds, values: &[f64], allowed: f64| {
        let mut rows = bounds.lower.iter().zip(&bounds.upper).zip(values);
        let far = |bound: f64| allowed + (relaxed + 1e-8) * bound.abs().max(1.0);
        // what Ipopt takes for no bound
        rows.all(|((&l, &u), &value)| {
            let below = l <= number("nlp_lower_bound_inf", -1e19) || value >= l - far(l);
            let above = u >= number("nlp_upper_bound_inf", 1e19) || value <= u + far(u);
            below && above
        })
    };
    if !inside(structure.variable_bounds(), x, 0.0) {
        return Err(format!("solved: x = {x:?} is outside its bounds"));
    }
    if !inside(structure.constraint_bounds(), &g, allowed) {
        return Err(format!("solved: g = {g:?} is outside its bounds"));
    }
    Ok(())
}
