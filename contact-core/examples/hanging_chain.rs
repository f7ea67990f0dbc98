//! A hanging chain: min Σ ℓ (yₖ + yₖ₊₁)/2 over the joints (xₖ, yₖ), subject to |Δₖ|² = ℓ² for each of its links Δₖ.
//!
//! It shows the Ipopt driver on a problem that has nothing to do with contact. As links become many, the chain becomes
//! the catenary y = a cosh(x/a): sag and horizontal tension converge with the square of the links' length, and the
//! tension of a link is 2 ℓ λₖ. Run it with `cargo run -p contact-core --example hanging_chain`.

use contact_core::{
    ipopt::{Options, Solver, Start, Status},
    nlp::{Bounds, Nlp, Pattern, Structure},
};

/// Distance of the two ends, which are level, and length of the chain, of weight 1 a length.
const SPAN: f64 = 1.0;
const LENGTH: f64 = 1.5;

struct Chain {
    links: usize,
}

impl Chain {
    /// ℓ
    fn link(&self) -> f64 {
        LENGTH / self.links as f64
    }

    /// Joint k has the unknowns 2k and 2k + 1; equal bounds fix the ends.
    fn structure(&self) -> Structure {
        let unknowns = 2 * (self.links + 1);
        let mut bounds = Bounds::free(unknowns);
        for (i, end) in [
            (0, 0.0),
            (1, 0.0),
            (unknowns - 2, SPAN),
            (unknowns - 1, 0.0),
        ] {
            (bounds.lower[i], bounds.upper[i]) = (end, end);
        }
        let square = self.link().powi(2);
        let lengths = Bounds::uniform(self.links, square, square);
        let jacobian = (0..self.links)
            .flat_map(|k| (2 * k..2 * k + 4).map(move |i| (k, i)))
            .collect();
        let neighbours = (0..2 * self.links).map(|i| (i + 2, i));
        let hessian: Pattern = (0..unknowns).map(|i| (i, i)).chain(neighbours).collect();
        Structure::new(bounds, lengths, jacobian, Some(hessian)).expect("the chain is well formed")
    }

    /// A parabola of about the right length.
    fn start(&self) -> Vec<f64> {
        (0..=self.links)
            .map(|k| k as f64 / self.links as f64)
            .flat_map(|s| [SPAN * s, -2.0 * s * (1.0 - s)])
            .collect()
    }

    /// Sag, horizontal tension and iterations.
    fn hang(&mut self) -> (f64, f64, usize) {
        let mut solver = Solver::new(self.structure(), &Options::new().tol(1e-10))
            .expect("Ipopt knows the option");
        let start = self.start();
        let solution = solver
            .solve(self, &Start::at(&start))
            .expect("the start is finite");
        assert_eq!(solution.status, Status::Solved);
        let sag = -solution.x[self.links + 1]; // y of the joint in the middle
        let lambda = solution.multipliers.expect("it is solved").constraints;
        let tensions: Vec<f64> = (0..self.links)
            .map(|k| 2.0 * lambda[k] * (solution.x[2 * k + 2] - solution.x[2 * k]))
            .collect();
        let tension = tensions[0];
        assert!(
            tensions.iter().all(|t| (t - tension).abs() < 1e-7),
            "no horizontal load"
        );
        (sag, tension, solution.statistics.iterations)
    }
}

/// Δₖ of every link.
fn links(x: &[f64]) -> impl Iterator<Item = [f64; 2]> + '_ {
    (2..x.len())
        .step_by(2)
        .map(|i| [x[i] - x[i - 2], x[i + 1] - x[i - 1]])
}

impl Nlp for Chain {
    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        let heights = (0..self.links).map(|k| (x[2 * k + 1] + x[2 * k + 3]) / 2.0);
        heights.sum::<f64>() * self.link()
    }

    fn gradient(&mut self, _x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        for k in 0..self.links {
            gradient[2 * k + 1] += self.link() / 2.0;
            gradient[2 * k + 3] += self.link() / 2.0;
        }
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        for (g, [dx, dy]) in g.iter_mut().zip(links(x)) {
            *g = dx * dx + dy * dy;
        }
    }

    fn jacobian(&mut self, x: &[f64], _new_x: bool, values: &mut [f64]) {
        for (row, [dx, dy]) in values.chunks_exact_mut(4).zip(links(x)) {
            row.copy_from_slice(&[-2.0 * dx, -2.0 * dy, 2.0 * dx, 2.0 * dy]);
        }
    }

    fn hessian(
        &mut self,
        _x: &[f64],
        _new_x: bool,
        _objective_factor: f64, // f is linear
        multipliers: &[f64],
        values: &mut [f64],
    ) {
        let (diagonal, neighbours) = values.split_at_mut(2 * (self.links + 1));
        for i in 0..2 * self.links {
            let second = 2.0 * multipliers[i / 2];
            diagonal[i] += second;
            diagonal[i + 2] += second;
            neighbours[i] = -second;
        }
    }
}

/// Sag and horizontal tension a of the catenary, from 2 a sinh(span / 2a) = length by bisection.
fn catenary() -> (f64, f64) {
    let (mut low, mut high) = (0.01, 100.0);
    for _ in 0..200 {
        let a: f64 = 0.5 * (low + high);
        if 2.0 * a * (SPAN / (2.0 * a)).sinh() > LENGTH {
            low = a;
        } else {
            high = a;
        }
    }
    (low * ((SPAN / (2.0 * low)).cosh() - 1.0), low)
}

fn main() {
    let (sag, tension) = catenary();
    println!("links  iterations         sag     error     tension     error");
    let mut errors = Vec::new();
    for links in [8, 16, 32, 64, 128] {
        let (s, t, iterations) = Chain { links }.hang();
        println!(
            "{links:5}  {iterations:10}  {s:10.7}  {:8.1e}  {t:10.7}  {:8.1e}",
            s - sag,
            t - tension
        );
        errors.push([(s - sag).abs(), (t - tension).abs()]);
    }
    println!("catenary           {sag:10.7}            {tension:10.7}");
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(&pair[1]) {
            let rate = (coarse / fine).log2();
            assert!((rate - 2.0).abs() < 0.1, "rate {rate} instead of 2");
        }
    }
    assert!(errors.iter().all(|[s, t]| s.max(*t) < 0.01));
}

/// The example is a test, too.
#[test]
fn converges_to_the_catenary() {
    main();
}
