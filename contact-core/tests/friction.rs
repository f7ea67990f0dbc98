//! Friction between points and planes, whose answers have closed forms.

#![allow(non_snake_case)] // the symbols of the field

use std::cell::Cell;
use std::f64::consts::PI;

use contact_core::equilibrium::Solution;
use contact_core::friction::{SlipRow, SlipRows, Status};
use contact_core::gaps::{LinearGaps, Row, RowKey, Sampling};
use contact_core::linear::SymmetricPattern;
use contact_core::nlp::Bounds;
use contact_core::{
    Automatic, CondensedNewton, ContactProblem, Dependent, Energy, Equilibrium, Error, FixedPoint,
    InteriorPoint, LinearMap, LoadStepped, LoadSteps, Outcome, Phase, Reduction, State,
};

/// A spring along a direction: ½ k (a·u − e t)², where t is the load factor's program.
#[derive(Clone)]
struct Spring {
    entries: Vec<(usize, f64)>,
    stiffness: f64,
    pulled: f64,
}

/// A point before a plane, with friction: its normal and its tangential motion.
#[derive(Clone)]
struct Point {
    normal: Vec<(usize, f64)>,
    tangent: Vec<(usize, f64)>,
    friction: f64,
    bound: f64,
}

/// Springs, dead forces and points before planes, for small displacements.
#[derive(Clone)]
struct Springs {
    unknowns: usize,
    springs: Vec<Spring>,
    forces: Vec<f64>,
    points: Vec<Point>,
    /// How far springs are pulled, as a function of the load factor.
    program: fn(f64) -> f64,
    corners: Vec<f64>,
    at: f64,
    pattern: SymmetricPattern,
    bounds: Bounds,
    /// The last unknown is another one, plus this times the load factor.
    follows: Option<(usize, f64)>,
}

impl Springs {
    fn new(
        unknowns: usize,
        springs: Vec<Spring>,
        forces: Vec<f64>,
        points: Vec<Point>,
        program: fn(f64) -> f64,
    ) -> Self {
        Springs {
            pattern: SymmetricPattern::dense(unknowns),
            bounds: Bounds::default(),
            unknowns,
            springs,
            forces,
            points,
            program,
            corners: Vec::new(),
            at: 1.0,
            follows: None,
        }
    }

    fn start(&self) -> State {
        State {
            u: vec![0.0; self.unknowns],
            ..State::default()
        }
    }

    /// The pull of a spring (UF).
    fn tension(&self, k: usize, u: &[f64]) -> f64 {
        let Spring {
            entries,
            stiffness,
            pulled,
        } = &self.springs[k];
        let along: f64 = entries.iter().map(|&(j, a)| a * u[j]).sum();
        stiffness * (along + pulled * (self.program)(self.at))
    }

    fn key(i: usize) -> RowKey {
        RowKey {
            pass: 0,
            node: i as u32,
        }
    }

    /// Coulomb's law, balance and the sign of the work, from the solution's numbers alone: the largest error relative to `force`.
    fn errors(&self, solution: &Solution, last: &[f64], [force, length]: [f64; 2]) -> f64 {
        let friction = solution.friction.as_ref().expect("friction");
        let u = &solution.state.u;
        let mut left = vec![0.0; self.unknowns];
        self.gradient(u, &mut left);
        let mut worst = 0.0_f64;
        for (i, point) in self.points.iter().enumerate() {
            let (l, r) = (solution.lambda[i], friction.forces[i]);
            let along = |entries: &[(usize, f64)], v: &dyn Fn(usize) -> f64| -> f64 {
                entries.iter().map(|&(j, a)| a * v(j)).sum()
            };
            let gap = along(&point.normal, &|j| u[j]);
            let slip = along(&point.tangent, &|j| u[j] - last[j]);
            let threshold = (point.friction * l).min(point.bound);
            let excess = (r.abs() - threshold).max(-l).max(0.0);
            let backwards = (-r * slip / length).max(0.0);
            let slips_below = (threshold - r.abs()).max(0.0) * slip.abs() / length;
            let pushed_open = (l.abs() * gap / length).max(-gap / length * force);
            worst = worst
                .max(excess)
                .max(backwards)
                .max(slips_below)
                .max(pushed_open);
            point.normal.iter().for_each(|&(j, a)| left[j] -= l * a);
            point.tangent.iter().for_each(|&(j, a)| left[j] += r * a);
        }
        left.iter().fold(worst, |m, f| m.max(f.abs())) / force
    }
}

impl Energy for Springs {
    fn dofs(&self) -> usize {
        self.unknowns
    }
    fn value(&self, u: &[f64]) -> f64 {
        let springs = (0..self.springs.len()).map(|k| {
            let tension = self.tension(k, u);
            0.5 * tension * tension / self.springs[k].stiffness
        });
        let work: f64 = self.forces.iter().zip(u).map(|(f, u)| f * u).sum();
        springs.sum::<f64>() - work
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g.iter_mut().zip(&self.forces).for_each(|(g, f)| *g = -f);
        for (k, spring) in self.springs.iter().enumerate() {
            let tension = self.tension(k, u);
            spring
                .entries
                .iter()
                .for_each(|&(j, a)| g[j] += tension * a);
        }
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        for spring in &self.springs {
            for &(i, a) in &spring.entries {
                for &(j, b) in spring.entries.iter().filter(|(j, _)| *j <= i) {
                    let slot = self.pattern.slot(i, j).expect("dense");
                    values[slot] += spring.stiffness * a * b;
                }
            }
        }
    }
    fn is_quadratic(&self) -> bool {
        true
    }
}

impl ContactProblem for Springs {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        let mut gaps = LinearGaps::new(true);
        for (i, point) in self.points.iter().enumerate() {
            let row = Row {
                free: point.normal.clone(),
                ..Row::default()
            };
            gaps.push(Self::key(i), &row);
        }
        Ok(gaps)
    }
    fn has_exact_gaps(&self) -> bool {
        true
    }
    fn has_friction(&self) -> bool {
        true
    }
    fn slips(&self, _: &[f64], gaps: &LinearGaps, last: &[f64], _: f64) -> Result<SlipRows, Error> {
        let mut slips = SlipRows::default();
        for &key in gaps.keys() {
            let point = &self.points[key.node as usize];
            let before: f64 = point.tangent.iter().map(|&(j, a)| a * last[j]).sum();
            let row = SlipRow {
                free: point.tangent.clone(),
                constant: -before,
                coefficient: point.friction,
                bound: point.bound,
                ..SlipRow::default()
            };
            slips.push(key, &row);
        }
        Ok(slips)
    }
    fn reduction(&self) -> Option<Reduction> {
        let (leader, drift) = self.follows?;
        let dependent = Dependent {
            unknown: self.unknowns - 1,
            terms: vec![(leader, 1.0)],
        };
        let map = LinearMap::new(&[self.unknowns], &[dependent]).expect("a map");
        Some(Reduction {
            map: map.into(),
            constants: vec![drift * self.at],
            held: vec![true],
        })
    }
}

impl LoadStepped for Springs {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.at = factor;
        Ok(())
    }
    fn corners(&self) -> Vec<f64> {
        self.corners.clone()
    }
}

fn solve(problem: &Springs) -> Solution {
    let solution = Automatic::default().solve_from(problem, problem.start());
    solution.expect("valid")
}

/// Two points with springs between them: the lower one stands on a plane at the angle α, the upper one has the weight.
fn incline(alpha: f64, friction: f64, weight: f64, length: f64) -> Springs {
    let k = weight / length;
    let between = |entries| Spring {
        entries,
        stiffness: k,
        pulled: 0.0,
    };
    let springs = vec![
        between(vec![(0, -1.0), (2, 1.0)]),
        between(vec![(1, -1.0), (3, 1.0)]),
    ];
    let forces = vec![0.0, 0.0, weight * alpha.sin(), -weight * alpha.cos()];
    let point = Point {
        normal: vec![(1, 1.0)],
        tangent: vec![(0, 1.0)],
        friction,
        bound: f64::INFINITY,
    };
    Springs::new(4, springs, forces, vec![point], |_| 0.0)
}

/// A weight on an incline stays where it is iff tan α < μ, in any units, and its friction is W sin α.
#[test]
fn weights_slide_where_the_incline_is_steeper_than_the_friction() {
    for (friction, weight, length) in [
        (0.3, 1.0, 1.0),
        (1.0, 1e9, 1e-9),
        (5.0, 1e-9, 1e9),
        (0.01, 1e3, 1e-3),
    ] {
        let alpha = f64::atan(friction);
        for off in [1e-6, 1e-2, 0.5] {
            let angle = alpha * (1.0 - off);
            let problem = incline(angle, friction, weight, length);
            let solution = solve(&problem);
            assert_eq!(solution.outcome, Outcome::Converged, "{friction} {off}");
            let held = solution.friction.as_ref().expect("friction");
            let force = weight * angle.sin();
            assert!(
                (held.forces[0] / force - 1.0).abs() < 1e-7,
                "{friction} {off}"
            );
            // what is left of the complementarity, off by the margin of the force
            let moved = solution.state.u[0].abs() / length;
            assert!(moved * off < 1e-8, "it slides by {moved}");
            assert!(problem.errors(&solution, &[0.0; 4], [weight, length]) < 1e-6);
        }
        for off in [1e-6, 1e-2, 0.2] {
            let solution = solve(&incline(alpha + off, friction, weight, length));
            assert_ne!(solution.outcome, Outcome::Converged, "{friction} {off}");
        }
    }
}

/// A cord of straight pieces around a drum, with the angle θ between one and the next. Its first piece is held, and its last one pulled.
fn belt(pieces: usize, angle: f64, friction: f64, force: f64, length: f64) -> Springs {
    let turn = angle / (pieces - 1) as f64;
    let along = |k: usize| {
        let at = (k as f64 - 0.5) * turn;
        [at.cos(), -at.sin()]
    };
    let springs = (0..pieces).map(|k| {
        let [x, y] = along(k);
        let mut entries = Vec::new();
        if k > 0 {
            entries.extend([(2 * k - 2, -x), (2 * k - 1, -y)]);
        }
        if k + 1 < pieces {
            entries.extend([(2 * k, x), (2 * k + 1, y)]);
        }
        Spring {
            entries,
            stiffness: force / length,
            pulled: if k + 1 == pieces { length } else { 0.0 },
        }
    });
    let points = (0..pieces - 1).map(|i| {
        let at = i as f64 * turn;
        Point {
            normal: vec![(2 * i, at.sin()), (2 * i + 1, at.cos())],
            tangent: vec![(2 * i, at.cos()), (2 * i + 1, -at.sin())],
            friction,
            bound: f64::INFINITY,
        }
    });
    let unknowns = 2 * (pieces - 1);
    let forces = vec![0.0; unknowns];
    Springs::new(unknowns, springs.collect(), forces, points.collect(), |t| t)
}

/// The tension of a belt on a drum grows by (1 + μ tan θ/2)/(1 − μ tan θ/2) where it turns by θ, which tends to e^{μθ}.
#[test]
fn belts_on_drums_transmit_exponentially_more() {
    for (pieces, angle, friction, force, length) in [
        (9, PI, 0.3, 1.0, 1.0),
        (33, PI, 0.3, 1e9, 1e-6),
        (65, 3.0 * PI, 0.2, 1e-9, 1e6),
        (65, PI, 1.0, 1.0, 1.0),
        (5, 0.5 * PI, 0.0, 1.0, 1.0),
    ] {
        let problem = belt(pieces, angle, friction, force, length);
        let solution = solve(&problem);
        assert_eq!(solution.outcome, Outcome::Converged, "{pieces} {friction}");
        let u = &solution.state.u;
        let turns = (pieces - 1) as f64;
        let t = friction * (0.5 * angle / turns).tan();
        let exact = ((1.0 + t) / (1.0 - t)).powf(turns);
        let found = problem.tension(pieces - 1, u) / problem.tension(0, u);
        assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
        let limit = (friction * angle).exp();
        if pieces > 30 {
            assert!((found / limit - 1.0).abs() < 5e-3, "{found} {limit}");
        }
        let start = vec![0.0; u.len()];
        assert!(problem.errors(&solution, &start, [force, length]) < 1e-6);
        let held = solution.friction.as_ref().expect("friction");
        let all = held.statuses(u);
        let expected = match friction > 0.0 {
            true => Status::Slip,
            false => Status::Open,
        };
        assert!(all.into_iter().all(|status| status == expected));
    }
}

/// A point that the force N presses on a plane is pulled to and fro by a spring.
fn slider(friction: f64, bound: f64) -> Springs {
    let pull = Spring {
        entries: vec![(0, -1.0)],
        stiffness: 10.0,
        pulled: 1.0,
    };
    // something gives way below the point, too
    let below = Spring {
        entries: vec![(1, 1.0)],
        stiffness: 10.0,
        pulled: 0.0,
    };
    let point = Point {
        normal: vec![(1, 1.0)],
        tangent: vec![(0, 1.0)],
        friction,
        bound,
    };
    let program = |t: f64| match t {
        t if t <= 1.0 => t,
        t if t <= 3.0 => 2.0 - t,
        t => t - 4.0,
    };
    let mut slider = Springs::new(2, vec![pull, below], vec![0.0, -5.0], vec![point], program);
    slider.corners = vec![1.0, 3.0];
    slider
}

/// A loop of forces against pulls has the area 4 F (a − F/k), which is what friction takes, whatever the increments.
#[test]
fn loops_of_loading_have_the_area_that_friction_takes() {
    // F = μN, or the bound
    for (friction, bound, full) in [(0.4, f64::INFINITY, 2.0), (2.0, 1.5, 1.5)] {
        for increments in [1, 2, 7, 40] {
            let mut problem = slider(friction, bound);
            let steps = LoadSteps {
                phases: vec![
                    Phase::new("up", 1.0, increments),
                    Phase::new("down", 3.0, increments),
                    Phase::new("back", 5.0, increments),
                ],
                ..LoadSteps::default()
            };
            let start = problem.start();
            let (mut taken, mut last) = (0.0, start.u.clone());
            let (mut ends, mut before) = (Vec::new(), None);
            let run = steps.run(&mut problem, &mut Automatic::default(), start, |step| {
                let friction = step.solution.friction.as_ref().expect("friction");
                let work = friction.dissipated(&step.solution.state.u, before.as_ref());
                before = Some(friction.clone());
                assert!(work > -1e-9, "friction takes {work}");
                let left = step.problem.errors(step.solution, &last, [full, 1.0]);
                assert!(left < 1e-6, "{left:e} at {}", step.factor);
                if step.factor > 1.0 {
                    taken += work;
                }
                last.clone_from(&step.solution.state.u);
                let is_end = [1.0, 3.0, 5.0].contains(&step.factor);
                if is_end {
                    ends.push(step.problem.tension(0, &last));
                }
                std::ops::ControlFlow::Continue(())
            });
            let run = run.expect("valid");
            assert!(
                run.ending == contact_core::Ending::Complete,
                "{:?}",
                run.ending
            );
            let area = 4.0 * full * (1.0 - full / 10.0);
            assert!((taken / area - 1.0).abs() < 1e-5, "{taken} {area}");
            for (end, expected) in ends.iter().zip([full, -full, full]) {
                assert!((end - expected).abs() < 1e-5, "{end} {expected}");
            }
        }
    }
}

/// Unknowns that follow others slip with these, and with what the constants of another load add.
#[test]
fn unknowns_that_follow_others_slip_with_them() {
    let drift = 0.25;
    // the slip is that of the last unknown, which is the first plus the drift
    let mut tied = slider(0.4, f64::INFINITY);
    tied.unknowns = 3;
    tied.forces.push(0.0);
    tied.pattern = SymmetricPattern::dense(3);
    tied.points[0].tangent = vec![(2, 1.0)];
    tied.follows = Some((0, drift));
    let steps = LoadSteps {
        increments: 10,
        ..LoadSteps::default()
    };
    let start = tied.start();
    let mut slips = 0.0;
    let run = steps.run(&mut tied, &mut Automatic::default(), start, |step| {
        let friction = step.solution.friction.as_ref().expect("friction");
        assert_eq!(friction.rows.matrix().columns(), 3, "over all unknowns");
        slips += friction.rows.slips(&step.solution.state.u)[0];
        std::ops::ControlFlow::Continue(())
    });
    let run = run.expect("valid");
    assert!(
        run.ending == contact_core::Ending::Complete,
        "{:?}",
        run.ending
    );
    let u = &run.state.u;
    assert!((u[2] - u[0] - drift).abs() < 1e-12);
    // the plane is slower than the pull, so that the force is full in the end, with the sign of the slip
    assert!((tied.tension(0, u) - 2.0).abs() < 1e-5, "{u:?}");
    assert!((slips - u[2]).abs() < 1e-9, "{slips} {u:?}");
}

/// A slider that has left its plane when a stop is requested: the second search for slips ends by the request.
struct Stopped {
    sliders: Springs,
    searches: Cell<usize>,
}

impl ContactProblem for Stopped {
    fn energy(&self) -> &dyn Energy {
        &self.sliders
    }
    fn bounds(&self) -> &Bounds {
        self.sliders.bounds()
    }
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        match self.searches.get() {
            0 => self.sliders.linearize_gaps(u, sampling),
            _ => Ok(LinearGaps::new(true)),
        }
    }
    fn has_friction(&self) -> bool {
        true
    }
    fn slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error> {
        self.searches.set(self.searches.get() + 1);
        match self.searches.get() {
            1 => self.sliders.slips(u, gaps, last, from),
            _ => Err(Error::Interrupted),
        }
    }
}

/// A stop while slips are searched ends as one, with the rows and multipliers of the iterate before.
#[test]
fn a_stop_in_the_search_for_slips_is_an_outcome() {
    let sliders = slider(0.4, f64::INFINITY);
    let start = sliders.start();
    let stopped = Stopped {
        sliders,
        searches: Cell::new(0),
    };
    let solution = CondensedNewton::default().solve_from(&stopped, start);
    let solution = solution.expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Interrupted);
    assert_eq!(solution.lambda.len(), solution.gaps.len());
    let friction = solution.friction.expect("friction");
    assert_eq!(friction.forces.len(), friction.rows.len());
}

/// What the fixed point does not treat, and what no law of friction is, is told by name.
#[test]
fn refusals_name_what_they_refuse() {
    let problem = slider(0.4, f64::INFINITY);
    let told = |result: Result<Solution, Error>| result.expect_err("refused").to_string();
    let start = || problem.start();
    let text = told(contact_core::Literal::default().solve_from(&problem, start()));
    assert!(text.contains("contact with friction"), "{text}");
    let penalty = contact_core::Penalty::default();
    let text = told(FixedPoint::with(penalty).solve_from(&problem, start()));
    assert!(text.contains("InteriorPoint"), "{text}");
    for (friction, bound, word) in [
        (-0.1, 1.0, "-0.1"),
        (f64::NAN, 1.0, "NaN"),
        (0.1, -2.0, "-2"),
    ] {
        let mut problem = slider(0.4, f64::INFINITY);
        problem.points[0].friction = friction;
        problem.points[0].bound = bound;
        let text = told(Automatic::default().solve_from(&problem, problem.start()));
        assert!(text.contains("friction") && text.contains(word), "{text}");
    }
    let mut twice = SlipRows::default();
    (0..2).for_each(|_| twice.push(Springs::key(3), &SlipRow::default()));
    let text = twice.check(1).expect_err("refused").to_string();
    assert!(text.contains("node 3"), "{text}");
}

/// A ladder of the length 1 on a floor, against a wall: two points and a stiff rod, with the weight 1 in its middle.
struct Ladder {
    angle: f64,
    friction: [f64; 2],
    pattern: SymmetricPattern,
    bounds: Bounds,
}

impl Ladder {
    const STIFFNESS: f64 = 1e5;

    /// Where the foot is, and the top: x of the foot, y of the foot, x of the top, y of the top.
    fn places(&self, u: &[f64]) -> [f64; 4] {
        let (sin, cos) = self.angle.sin_cos();
        [cos + u[0], u[1], u[2], sin + u[3]]
    }

    fn rod(&self, u: &[f64]) -> ([f64; 2], f64) {
        let [x, y, a, b] = self.places(u);
        let d = [a - x, b - y];
        (d, d[0].hypot(d[1]))
    }
}

impl Energy for Ladder {
    fn dofs(&self) -> usize {
        4
    }
    fn value(&self, u: &[f64]) -> f64 {
        let stretch = self.rod(u).1 - 1.0;
        0.5 * Self::STIFFNESS * stretch * stretch + 0.5 * (u[1] + u[3])
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        let (d, l) = self.rod(u);
        let pull = Self::STIFFNESS * (l - 1.0) / l;
        g.copy_from_slice(&[
            -pull * d[0],
            -pull * d[1] + 0.5,
            pull * d[0],
            pull * d[1] + 0.5,
        ]);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        let (d, l) = self.rod(u);
        let (k, pull) = (Self::STIFFNESS, Self::STIFFNESS * (l - 1.0) / l);
        let entry = |i: usize, j: usize| {
            let unit = [d[i % 2] / l, d[j % 2] / l];
            let same = if i % 2 == j % 2 { pull } else { 0.0 };
            let sign = if i / 2 == j / 2 { 1.0 } else { -1.0 };
            sign * (same + (k - pull) * unit[0] * unit[1])
        };
        for (value, (i, j)) in values.iter_mut().zip(self.pattern.iter()) {
            *value = entry(i, j);
        }
    }
}

impl ContactProblem for Ladder {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        let mut gaps = LinearGaps::new(true);
        for (i, unknown) in [1, 2].into_iter().enumerate() {
            let free = vec![(unknown, 1.0)];
            gaps.push(
                Springs::key(i),
                &Row {
                    free,
                    ..Row::default()
                },
            );
        }
        Ok(gaps)
    }
    fn has_exact_gaps(&self) -> bool {
        true
    }
    fn has_friction(&self) -> bool {
        true
    }
    fn slips(&self, _: &[f64], gaps: &LinearGaps, last: &[f64], _: f64) -> Result<SlipRows, Error> {
        let mut slips = SlipRows::default();
        for (i, unknown) in [0, 3].into_iter().enumerate() {
            let row = SlipRow {
                free: vec![(unknown, 1.0)],
                constant: -last[unknown],
                coefficient: self.friction[i],
                ..SlipRow::default()
            };
            slips.push(gaps.keys()[i], &row);
        }
        Ok(slips)
    }
}

/// A ladder stands iff its angle to the floor has tan θ > (1 − μ_floor μ_wall)/(2 μ_floor). Where both ends have friction, forces are not
/// determined by balance alone, and near the limit the fixed point lets the ladder go: it is tried three tenths above it.
#[test]
fn ladders_stand_where_they_are_steep_enough() {
    let fixed_point = &mut FixedPoint::<InteriorPoint>::default();
    ladders(fixed_point, [1.01, 1.3, 1.3]);
}

/// Newton's method holds ladders up to their limit.
#[test]
fn ladders_stand_up_to_their_limit_by_newtons_method() {
    ladders(&mut CondensedNewton::default(), [1.001; 3]);
}

fn ladders(solver: &mut dyn Equilibrium, near: [f64; 3]) {
    for (friction, near) in [[0.5, 0.0], [0.4, 0.3], [0.2, 0.6]].into_iter().zip(near) {
        let least = (1.0 - friction[0] * friction[1]) / (2.0 * friction[0]);
        for (share, stands) in [(1.3, true), (near, true), (0.99, false), (0.7, false)] {
            let ladder = Ladder {
                angle: (share * least).atan(),
                friction,
                pattern: SymmetricPattern::dense(4),
                bounds: Bounds::default(),
            };
            let start = State {
                u: vec![0.0; 4],
                ..State::default()
            };
            let solution = solver.solve_from(&ladder, start);
            let solution = solution.expect("valid");
            let moved = solution.state.u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            let found = solution.outcome == Outcome::Converged && moved < 1e-2;
            assert_eq!(
                found, stands,
                "{friction:?} {share}: {:?} {moved}",
                solution.outcome
            );
        }
    }
}
