//! Random problems: sums of simple terms with exact derivatives, in patterns that need not be tidy.

use contact_core::nlp::{Bounds, Pattern, Structure};
use fastrand::Rng;

/// A term of a function: a number times a function of one or two variables.
#[derive(Debug, Clone, Copy)]
struct Term {
    factor: f64,
    kind: Kind,
    i: usize,
    j: usize,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Constant,
    Linear,
    Product,
    Cube,
    Exponential,
    Logarithm,
    Inverse,
    Root,
}

impl Term {
    fn random(random: &mut Rng, n: usize, linear: bool) -> Self {
        let kind = match random.u32(..if linear { 5 } else { 16 }) {
            0 => Kind::Constant,
            1..5 => Kind::Linear,
            5..11 => Kind::Product,
            11 => Kind::Cube,
            12 => Kind::Exponential,
            13 => Kind::Logarithm,
            14 => Kind::Inverse,
            _ => Kind::Root,
        };
        Term {
            factor: number(random),
            kind,
            i: random.usize(..n),
            j: random.usize(..n),
        }
    }

    fn value(&self, x: &[f64]) -> f64 {
        let (a, b) = (x[self.i], x[self.j]);
        self.factor
            * match self.kind {
                Kind::Constant => 1.0,
                Kind::Linear => a,
                Kind::Product => a * b,
                Kind::Cube => a * a * a,
                Kind::Exponential => a.exp(),
                Kind::Logarithm => a.ln(),
                Kind::Inverse => 1.0 / a,
                Kind::Root => a.sqrt(),
            }
    }

    /// The derivatives with respect to both variables; the second one is of products only.
    fn slopes(&self, x: &[f64]) -> [f64; 2] {
        let (a, b) = (x[self.i], x[self.j]);
        let slopes = match self.kind {
            Kind::Constant => [0.0; 2],
            Kind::Linear => [1.0, 0.0],
            Kind::Product => [b, a],
            Kind::Cube => [3.0 * a * a, 0.0],
            Kind::Exponential => [a.exp(), 0.0],
            Kind::Logarithm => [1.0 / a, 0.0],
            Kind::Inverse => [-1.0 / (a * a), 0.0],
            Kind::Root => [0.5 / a.sqrt(), 0.0],
        };
        slopes.map(|slope| self.factor * slope)
    }

    /// What it adds to the entry (row, col) of the Hessian's lower triangle.
    fn curvature(&self, x: &[f64]) -> Option<(usize, usize, f64)> {
        let a = x[self.i];
        let value = match self.kind {
            Kind::Constant | Kind::Linear => return None,
            Kind::Product if self.i == self.j => 2.0,
            Kind::Product => 1.0,
            Kind::Cube => 6.0 * a,
            Kind::Exponential => a.exp(),
            Kind::Logarithm => -1.0 / (a * a),
            Kind::Inverse => 2.0 / (a * a * a),
            Kind::Root => -0.25 / (a * a.sqrt()),
        };
        let j = match self.kind {
            Kind::Product => self.j,
            _ => self.i,
        };
        Some((self.i.max(j), self.i.min(j), self.factor * value))
    }

    fn variables(&self) -> impl Iterator<Item = usize> {
        let count = match self.kind {
            Kind::Constant => 0,
            Kind::Product => 2,
            _ => 1,
        };
        [self.i, self.j].into_iter().take(count)
    }
}

/// Mostly of order 1.
pub fn number(random: &mut Rng) -> f64 {
    let size = match random.u32(..40) {
        0 => 0.0,
        1 => 1e-8,
        2 => 1e8,
        3 => 1e3,
        _ => 1.0,
    };
    size * (4.0 * random.f64() - 2.0)
}

/// f and g, and their patterns.
#[derive(Debug, Clone)]
pub struct Functions {
    f: Vec<Term>,
    g: Vec<Vec<Term>>,
    jacobian: Pattern,
    hessian: Option<Pattern>,
}

impl Functions {
    fn random(random: &mut Rng, n: usize, m: usize) -> Self {
        let linear = random.u32(..8) == 0;
        let mut terms = |most: usize| -> Vec<Term> {
            let count = random.usize(..=most);
            (0..count)
                .map(|_| Term::random(random, n, linear))
                .collect()
        };
        let f = terms(2 * n);
        let g: Vec<_> = (0..m).map(|_| terms(3)).collect();
        let mut jacobian = Vec::new();
        for (row, terms) in g.iter().enumerate() {
            for col in terms.iter().flat_map(Term::variables) {
                // an entry may come twice; the second one stays 0
                if !jacobian.contains(&(row, col)) || random.u32(..20) == 0 {
                    jacobian.push((row, col));
                }
            }
        }
        let mut hessian = Vec::new();
        let point = vec![1.0; n];
        let entries = f.iter().chain(g.iter().flatten());
        for (row, col, _) in entries.filter_map(|term| term.curvature(&point)) {
            if !hessian.contains(&(row, col)) {
                hessian.push((row, col));
            }
        }
        random.shuffle(&mut jacobian);
        random.shuffle(&mut hessian);
        Functions {
            f,
            g,
            jacobian: jacobian.into_iter().collect(),
            hessian: (random.u32(..5) > 0).then(|| hessian.into_iter().collect()),
        }
    }

    pub fn f(&self, x: &[f64]) -> f64 {
        self.f.iter().map(|term| term.value(x)).sum()
    }

    pub fn gradient(&self, x: &[f64], gradient: &mut [f64]) {
        for term in &self.f {
            let [a, b] = term.slopes(x);
            gradient[term.i] += a;
            gradient[term.j] += b;
        }
    }

    pub fn g(&self, x: &[f64], g: &mut [f64]) {
        for (value, terms) in g.iter_mut().zip(&self.g) {
            *value = terms.iter().map(|term| term.value(x)).sum();
        }
    }

    pub fn jacobian(&self, x: &[f64], values: &mut [f64]) {
        for (row, terms) in self.g.iter().enumerate() {
            for term in terms {
                let [a, b] = term.slopes(x);
                for (col, value) in term.variables().zip([a, b]) {
                    let place = self.jacobian.iter().position(|at| at == (row, col));
                    values[place.expect("in the pattern")] += value;
                }
            }
        }
    }

    pub fn hessian(&self, x: &[f64], sigma: f64, lambda: &[f64], values: &mut [f64]) {
        let rows = self.g.iter().zip(lambda);
        let pattern = self
            .hessian
            .as_ref()
            .expect("asked for with a pattern only");
        for (terms, factor) in rows.chain([(&self.f, &sigma)]) {
            for (row, col, value) in terms.iter().filter_map(|term| term.curvature(x)) {
                let place = pattern.iter().position(|at| at == (row, col));
                values[place.expect("in the pattern")] += factor * value;
            }
        }
    }
}

/// Bounds of all kinds, equal and far ones included.
fn bounds(random: &mut Rng, n: usize) -> Bounds {
    let (mut lower, mut upper) = (vec![], vec![]);
    let all_fixed = random.u32(..20) == 0;
    for _ in 0..n {
        let (a, width) = (number(random), number(random).abs());
        let (l, u) = match random.u32(..14) {
            _ if all_fixed => (a, a),
            0..3 => (f64::NEG_INFINITY, f64::INFINITY),
            3..6 => (a, f64::INFINITY),
            6..8 => (f64::NEG_INFINITY, a),
            8..10 => (a, a + width),
            10..12 => (a, a),
            12 => (a, a + 1e-12),
            _ => {
                let far = [1e18, 1e19, 1e20, 1e300, f64::MAX];
                (-far[random.usize(..5)], far[random.usize(..5)])
            }
        };
        lower.push(l);
        upper.push(u);
    }
    Bounds { lower, upper }
}

pub struct Problem {
    pub functions: Functions,
    pub structure: Structure,
}

impl Problem {
    pub fn random(random: &mut Rng) -> Self {
        let n = random.usize(1..7);
        let m = random.usize(..6);
        let functions = Functions::random(random, n, m);
        let (jacobian, hessian) = (functions.jacobian.clone(), functions.hessian.clone());
        let structure = Structure::new(bounds(random, n), bounds(random, m), jacobian, hessian)
            .expect("well formed")
            .with_constant_hessian(random.u32(..20) == 0)
            .with_constant_jacobian(random.u32(..20) == 0);
        Problem {
            functions,
            structure,
        }
    }

    /// Bounds for another solve of the same structure.
    pub fn other_bounds(&self, random: &mut Rng) -> (Bounds, Bounds) {
        let (n, m) = (self.structure.variables(), self.structure.constraints());
        (bounds(random, n), bounds(random, m))
    }
}
