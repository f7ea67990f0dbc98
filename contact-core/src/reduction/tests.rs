use super::*;
use crate::gaps::Sampling;
use crate::nlp::Bounds;
use crate::quadratic::{Entries, QuadraticProgram};
use crate::{Condensed, CondensedNewton, Energy, LinearGaps, check};

/// A quadratic program some of whose unknowns depend on others.
struct Joined {
    all: QuadraticProgram,
    reduction: Reduction,
}

impl ContactProblem for Joined {
    fn energy(&self) -> &dyn Energy {
        self.all.energy()
    }
    fn bounds(&self) -> &Bounds {
        self.all.bounds()
    }
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.all.linearize_gaps(u, sampling)
    }
    fn has_exact_gaps(&self) -> bool {
        true
    }
    fn reduction(&self) -> Option<Reduction> {
        Some(self.reduction.clone())
    }
}

fn entries(rows: usize, columns: usize, values: &[(usize, usize, f64)]) -> Entries {
    Entries {
        rows,
        columns,
        values: values.to_vec(),
    }
}

/// ½ u₀² + ½ u₁² − 6 u₀ with u₁ = 2 u₀ + 1 ≤ `wall`: without the wall u₀ = 0.8.
fn joined(wall: f64) -> Joined {
    let stiffness = entries(2, 2, &[(0, 0, 1.0), (1, 1, 1.0)]);
    let row = entries(1, 2, &[(0, 1, -1.0)]);
    let bounds = Bounds::free(2);
    let all = QuadraticProgram::new(&stiffness, &[-6.0, 0.0], &row, &[wall], &bounds);
    let follows = Dependent {
        unknown: 1,
        terms: vec![(0, 2.0)],
    };
    let map = LinearMap::new(&[2], &[follows]).expect("a map");
    Joined {
        all: all.expect("a program"),
        reduction: Reduction {
            map: Arc::new(map),
            constants: vec![1.0],
            held: vec![true],
        },
    }
}

#[test]
fn dependent_unknowns_follow() {
    for (wall, u, lambda) in [(9.0, [0.8, 2.6], 0.0), (2.0, [0.5, 2.0], 0.75)] {
        let problem = joined(wall);
        let solvers: [&mut dyn Equilibrium; 2] =
            [&mut Condensed::new(), &mut CondensedNewton::default()];
        for solver in solvers {
            let solution = solver
                .solve_from(&problem, problem.all.start())
                .expect("a solve");
            let found = &solution.state.u;
            assert!(
                found.iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-12),
                "{found:?}"
            );
            // the rows are those over all unknowns
            assert_eq!(solution.gaps.entries().collect::<Vec<_>>(), [(0, 1, -1.0)]);
            assert!(
                (solution.lambda[0] - lambda).abs() < 1e-12,
                "{:?}",
                solution.lambda
            );
        }
    }
}

/// Solvers that are called by themselves would take dependent unknowns for independent ones.
#[test]
fn solvers_refuse_dependent_unknowns() {
    let problem = joined(9.0);
    let start = problem.all.start();
    let (stop, lifted) = (crate::Stop::new(), || problem.all.start());
    let context = StepContext::single(&start, &lifted, &stop);
    let solvers: [&mut dyn Equilibrium; 2] =
        [&mut Condensed::new(), &mut CondensedNewton::default()];
    for solver in solvers {
        let solved = solver.solve(&problem, start.clone(), &context);
        assert!(matches!(solved, Err(Error::Untreated { .. })), "{solved:?}");
    }
}

/// Three parts, of which the last follows the first: v has these two before the other one.
#[test]
fn unknowns_by_groups() {
    let follows = |unknown, terms: &[(usize, f64)]| Dependent {
        unknown,
        terms: terms.to_vec(),
    };
    let map = LinearMap::new(&[2, 1, 2], &[follows(3, &[(0, 0.5), (1, 0.25), (0, 0.25)])]);
    let map = map.expect("a map");
    assert_eq!(map.groups().collect::<Vec<_>>(), [&[0, 2][..], &[1]]);
    let u = map.expanded(&[1.0, 2.0, 3.0, 4.0], &[10.0]);
    assert_eq!(u, [1.0, 2.0, 4.0, 0.75 + 0.5 + 10.0, 3.0]);
    assert_eq!(map.restricted(&u), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(
        map.transposed(&[1.0, 1.0, 1.0, 4.0, 1.0]),
        [4.0, 2.0, 1.0, 1.0]
    );
    for wrong in [
        vec![follows(3, &[(0, 1.0)]), follows(3, &[(1, 1.0)])],
        vec![follows(3, &[(4, 1.0)]), follows(4, &[(1, 1.0)])],
        vec![follows(5, &[(0, 1.0)])],
        vec![follows(3, &[(7, 1.0)])],
        vec![follows(3, &[(0, f64::NAN)])],
    ] {
        assert!(LinearMap::new(&[2, 1, 2], &wrong).is_err(), "{wrong:?}");
    }
}

/// Σ (u_i⁴/4 + u_i u_j of neighbours), whose Hessian is tridiagonal.
struct Chain(crate::linear::SymmetricPattern);

impl Energy for Chain {
    fn dofs(&self) -> usize {
        self.0.dim()
    }
    fn value(&self, u: &[f64]) -> f64 {
        let own: f64 = u.iter().map(|u| u.powi(4) / 4.0).sum();
        own + u.windows(2).map(|p| p[0] * p[1]).sum::<f64>()
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        for i in 0..u.len() {
            let before = if i > 0 { u[i - 1] } else { 0.0 };
            g[i] = u[i].powi(3) + before + u.get(i + 1).copied().unwrap_or(0.0);
        }
    }
    fn hessian_pattern(&self) -> &crate::linear::SymmetricPattern {
        &self.0
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        for (value, (i, j)) in values.iter_mut().zip(self.0.iter()) {
            *value = if i == j { 3.0 * u[i] * u[i] } else { 1.0 };
        }
    }
}

/// Gradient and Hessian of E(T v + t) against differences, where terms meet each other in the Hessian.
#[test]
fn derivatives_of_a_group() {
    let entries: Vec<_> = (0..4)
        .map(|i| (i, i))
        .chain((0..3).map(|i| (i + 1, i)))
        .collect();
    let (pattern, _) = crate::linear::SymmetricPattern::from_entries(4, &entries).expect("entries");
    let (one, other) = (Chain(pattern.clone()), Chain(pattern));
    let follows = [
        Dependent {
            unknown: 1,
            terms: vec![(0, 0.5), (2, -1.5), (6, 0.25)],
        },
        Dependent {
            unknown: 5,
            terms: vec![(0, 2.0), (4, 0.3)],
        },
    ];
    let map = LinearMap::new(&[4, 4], &follows).expect("a map");
    let parts: [&dyn Energy; 2] = [&one, &other];
    let plan = Part::new(&map, &map.groups[0], &parts);
    let constants = [0.1, -0.2];
    let energy = energy::GroupEnergy::new(&map, (&map.groups[0], &plan), &parts, &constants);
    let v = [0.3, -0.7, 1.1, 0.4, -0.9, 0.6];
    let u = map.expanded(&v, &constants);
    let sum = one.value(&u[..4]) + other.value(&u[4..]);
    assert!((energy.value(&v) - sum).abs() < 1e-14);
    let found = check::energy(&energy, &v, 1e-5);
    let largest = found.gradient.max(found.hessian).max(found.outside_pattern);
    assert!(largest < 1e-7, "{found:?}");
}
