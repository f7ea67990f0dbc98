//! A problem of one's own, without units of its own: an elastic cord around a cylinder, of any stiffness and size.

#![allow(non_snake_case)] // the symbols of the field

use std::ops::ControlFlow;

use contact_core::gaps::{LinearGaps, Row, RowKey, Sampling};
use contact_core::ipopt::Options;
use contact_core::linear::SymmetricPattern;
use contact_core::nlp::Bounds;
use contact_core::{
    Automatic, ContactProblem, Ending, Energy, Equilibrium, Error, InteriorPoint, LoadStepped,
    LoadSteps, Retry, Scale, State,
};

/// A cord of `SEGMENTS` springs with ends on a circle, 30° below its middle; it is stretched by its shrinking rest lengths. The
/// unknowns are the positions of the other nodes, or their displacements from the start.
struct Cord {
    of_positions: bool,
    /// E A (UF) and the radius (UL).
    stiffness: f64,
    radius: f64,
    rest: f64,
    pattern: SymmetricPattern,
    bounds: Bounds,
    scale: Option<Scale>,
}

const SEGMENTS: usize = 16;
/// The angle between the ends, around the top.
const ANGLE: f64 = 240.0 * std::f64::consts::PI / 180.0;
/// The largest strain.
const STRAIN: f64 = 0.25;

impl Cord {
    fn new(of_positions: bool, stiffness: f64, radius: f64) -> Self {
        let unknowns = 2 * (SEGMENTS - 1);
        Cord {
            of_positions,
            stiffness,
            radius,
            rest: 0.0,
            pattern: SymmetricPattern::dense(unknowns),
            bounds: Bounds::free(unknowns),
            scale: None,
        }
    }

    /// The chord of one of `SEGMENTS` equal pieces.
    fn chord(&self) -> f64 {
        2.0 * self.radius * (0.5 * ANGLE / SEGMENTS as f64).sin()
    }

    fn on_circle(&self, share: f64, radius: f64) -> [f64; 2] {
        let angle = ANGLE * (share - 0.5);
        [radius * angle.sin(), radius * angle.cos()]
    }

    /// Node k of all, the ends included.
    fn node(&self, u: &[f64], k: usize) -> [f64; 2] {
        match k {
            0 => self.on_circle(0.0, self.radius),
            SEGMENTS => self.on_circle(1.0, self.radius),
            k if self.of_positions => [u[2 * k - 2], u[2 * k - 1]],
            k => {
                let [x, y] = self.at_start(k);
                [x + u[2 * k - 2], y + u[2 * k - 1]]
            }
        }
    }

    /// Unevenly spaced, and off the cylinder.
    fn at_start(&self, k: usize) -> [f64; 2] {
        let share = (k as f64 / SEGMENTS as f64).powf(1.1);
        self.on_circle(share, 1.1 * self.radius)
    }

    fn start(&self) -> State {
        let positions = (1..SEGMENTS).flat_map(|k| self.at_start(k));
        let share = f64::from(u8::from(self.of_positions));
        State {
            u: positions.map(|x| share * x).collect(),
            ..State::default()
        }
    }

    /// The cord slides without friction, so that all segments are equally long.
    fn exact(&self) -> f64 {
        let rest = self.chord() / (1.0 + STRAIN);
        SEGMENTS as f64 * 0.5 * self.stiffness / rest * (self.chord() - rest).powi(2)
    }

    /// Δ, its length, and the number of the segment.
    fn segments<'a>(&'a self, u: &'a [f64]) -> impl Iterator<Item = ([f64; 2], f64, usize)> + 'a {
        (0..SEGMENTS).map(move |k| {
            let (a, b) = (self.node(u, k), self.node(u, k + 1));
            let d = [b[0] - a[0], b[1] - a[1]];
            (d, d[0].hypot(d[1]), k)
        })
    }
}

impl Energy for Cord {
    fn dofs(&self) -> usize {
        2 * (SEGMENTS - 1)
    }
    fn value(&self, u: &[f64]) -> f64 {
        let stretched = self.segments(u).map(|(_, l, _)| (l - self.rest).powi(2));
        0.5 * self.stiffness / self.rest * stretched.sum::<f64>()
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g.fill(0.0);
        for (d, l, k) in self.segments(u) {
            let force = self.stiffness / self.rest * (l - self.rest) / l;
            for i in 0..2 {
                if k > 0 {
                    g[2 * k - 2 + i] -= force * d[i];
                }
                if k + 1 < SEGMENTS {
                    g[2 * k + i] += force * d[i];
                }
            }
        }
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        for (d, l, k) in self.segments(u) {
            let stiffness = self.stiffness / self.rest;
            let own: [usize; 2] = [k, k + 1];
            for (p, a) in own.iter().enumerate() {
                for (q, b) in own.iter().enumerate() {
                    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        let inside = |n: usize| (1..SEGMENTS).contains(&n);
                        let sign = if p == q { 1.0 } else { -1.0 };
                        let direct = f64::from(u8::from(i == j)) * (1.0 - self.rest / l);
                        let along = self.rest / l * d[i] * d[j] / (l * l);
                        let value = sign * stiffness * (direct + along);
                        if inside(*a) && inside(*b) && 2 * a + i >= 2 * b + j {
                            let slot = self.pattern.slot(2 * a - 2 + i, 2 * b - 2 + j);
                            values[slot.expect("a neighbour")] += value;
                        }
                    }
                }
            }
        }
    }
}

impl ContactProblem for Cord {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        let mut gaps = LinearGaps::new(false);
        for k in 1..SEGMENTS {
            let x = self.node(u, k);
            let r = x[0].hypot(x[1]);
            let key = RowKey {
                pass: 0,
                node: k as u32,
            };
            let n = [x[0] / r, x[1] / r];
            let X = self.node(&[0.0; 2 * (SEGMENTS - 1)], k);
            let row = Row {
                free: vec![(2 * k - 2, n[0]), (2 * k - 1, n[1])],
                constant: n[0] * X[0] + n[1] * X[1] - self.radius,
                ..Row::default()
            };
            gaps.push(key, &row);
        }
        Ok(gaps)
    }
    fn scale(&self) -> Option<Scale> {
        self.scale
    }
}

impl LoadStepped for Cord {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.rest = self.chord() / (1.0 + STRAIN * factor);
        Ok(())
    }
}

fn run(cord: &mut Cord, solver: &mut dyn Equilibrium) -> (Ending, f64) {
    cord.set_load(0.0).expect("a load");
    let start = cord.start();
    let steps = LoadSteps {
        increments: 4,
        ..LoadSteps::default()
    };
    let run = steps.run(cord, solver, start, |_| ControlFlow::Continue(()));
    let run = run.expect("no misuse");
    let energy = run.solution.map_or(f64::NAN, |solution| solution.energy);
    (run.ending, energy / cord.exact() - 1.0)
}

#[test]
fn cords_of_any_stiffness_and_size() {
    for of_positions in [true, false] {
        for radius in [1e-3, 1.0, 1e3] {
            for decade in -8..=8 {
                let stiffness = 5.0 * 10f64.powi(decade);
                let mut cord = Cord::new(of_positions, stiffness, radius);
                let solvers: [Box<dyn Equilibrium>; 2] = [
                    Box::new(Automatic::default()),
                    Box::new(Retry::<InteriorPoint>::default()),
                ];
                for mut solver in solvers {
                    let name = solver.choice(&cord).solver;
                    let (ending, error) = run(&mut cord, &mut *solver);
                    let case =
                        format!("{name}, {of_positions}, EA {stiffness:e}, radius {radius:e}");
                    assert_eq!(ending, Ending::Complete, "{case}");
                    assert!(error.abs() < 1e-8, "{case}: {error:.1e}");
                }
            }
        }
    }
}

/// What units of 1 do to a soft and small cord: why they are not the default.
#[test]
fn units_that_do_not_fit() {
    let mut cord = Cord::new(true, 5e-6, 1e-3);
    cord.scale = Some(Scale::default());
    let (_, error) = run(&mut cord, &mut Retry::<InteriorPoint>::default());
    assert!(!(error.abs() < 1e-3), "{error:.1e}");
}

#[test]
fn an_estimate_by_hand() {
    let mut cord = Cord::new(true, 2.0, 3.0);
    cord.set_load(1.0).expect("a load");
    let start = cord.start();
    let scale = Scale::estimate(&cord, &start.u).expect("finite");
    let largest = start.u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    assert_eq!(scale.length, largest);
    // two springs at each node; along the cord each has EA/ℓ, across it less
    let stiffness = scale.energy / scale.length.powi(2);
    let spring = 2.0 / cord.rest;
    assert!(
        stiffness > 0.1 * spring && stiffness < 2.0 * spring,
        "{stiffness}"
    );
    assert!(Scale::estimate(&cord, &start.u[1..]).is_err());
    let own = Scale {
        length: 7.0,
        ..Scale::default()
    };
    cord.scale = Some(own);
    assert_eq!(Scale::of(&cord, &start.u).expect("its own"), own);
}

/// A failure of Ipopt tells the units.
#[test]
fn failures_name_the_units() {
    let mut cord = Cord::new(true, 2.0, 3.0);
    let method = InteriorPoint {
        options: Options::new().with("max_iter", 1),
        ..InteriorPoint::default()
    };
    let (ending, _) = run(&mut cord, &mut Retry::with(method));
    let text = ending.to_string();
    // the joint on top of the start is 1.1 radii from the centre
    assert!(text.contains("in units of 3.3e0 for lengths"), "{text}");
}
