//! Bodies that act on each other or do not: results are those of the whole, and each group is solved by itself.

use super::*;
use crate::{DirectSum, Separable};

/// Hardening springs in a row, each pulled by a load of its own, with stops between neighbours:
/// E = Σ ½ k u² + ¼ u⁴ − f u, and u_a ≤ u_b + gap.
struct Row {
    springs: DirectSum<Spring>,
    gaps: Vec<f64>,
    held: Vec<bool>,
    bounds: Bounds,
    is_separable: bool,
}

struct Spring {
    stiffness: f64,
    /// 1, or 0 of a linear spring.
    hardening: f64,
    load: f64,
    pattern: SymmetricPattern,
}

impl Energy for Spring {
    fn dofs(&self) -> usize {
        1
    }
    fn is_quadratic(&self) -> bool {
        self.hardening == 0.0
    }
    fn value(&self, u: &[f64]) -> f64 {
        let u = u[0];
        0.5 * self.stiffness * u * u + 0.25 * self.hardening * u.powi(4) - self.load * u
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g[0] = self.stiffness * u[0] + self.hardening * u[0].powi(3) - self.load;
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        values[0] = self.stiffness + 3.0 * self.hardening * u[0] * u[0];
    }
}

/// Springs of (stiffness, load) with these gaps between them.
fn row(springs: &[(f64, f64)], gaps: &[f64]) -> Row {
    let spring = |&(stiffness, load): &(f64, f64)| Spring {
        stiffness,
        hardening: 1.0,
        load,
        pattern: SymmetricPattern::diagonal(1),
    };
    Row {
        springs: DirectSum::new(springs.iter().map(spring).collect()),
        gaps: gaps.to_vec(),
        held: springs.iter().map(|spring| spring.0 > 0.01).collect(),
        bounds: Bounds::default(),
        is_separable: true,
    }
}

impl Row {
    fn rows(&self, among: impl Fn(usize) -> bool) -> LinearGaps {
        let mut gaps = LinearGaps::new(false);
        for (k, &gap) in self.gaps.iter().enumerate() {
            if among(k) && among(k + 1) {
                let row = crate::gaps::Row {
                    free: vec![(k, -1.0), (k + 1, 1.0)],
                    constant: gap,
                    ..crate::gaps::Row::default()
                };
                let (pass, node) = (k as u32, 0);
                gaps.push(RowKey { pass, node }, &row);
            }
        }
        gaps
    }

    fn solve(&self) -> Solution {
        let mut solver = CondensedNewton::default();
        let start = at(&vec![0.0; self.springs.dofs()]);
        let solution = solver.solve_from(self, start).expect("a valid problem");
        assert_eq!(solution.outcome, Outcome::Converged);
        solution
    }

    /// The solution, which is that of all springs as one.
    fn solved(mut self) -> Solution {
        let by_groups = self.solve();
        self.is_separable = false;
        let whole = self.solve();
        assert_near(&by_groups.state.u, &whole.state.u, 1e-12);
        assert_near(&by_groups.lambda, &whole.lambda, 1e-10);
        assert_eq!(by_groups.gaps.keys(), whole.gaps.keys());
        assert!((by_groups.energy - whole.energy).abs() < 1e-12);
        by_groups
    }
}

impl Separable for Row {
    fn bodies(&self) -> Vec<&dyn Energy> {
        let springs = self.springs.parts().iter();
        springs.map(|spring| spring as &dyn Energy).collect()
    }
    fn is_held(&self, b: usize) -> bool {
        self.held[b]
    }
    fn passes(&self) -> Vec<[usize; 2]> {
        (0..self.gaps.len()).map(|k| [k, k + 1]).collect()
    }
    fn linearize_among(&self, _: &[f64], among: &[bool]) -> Result<LinearGaps, Error> {
        Ok(self.rows(|body| among[body]))
    }
}

impl ContactProblem for Row {
    fn energy(&self) -> &dyn Energy {
        &self.springs
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(self.rows(|_| true))
    }
    fn separable(&self) -> Option<&dyn Separable> {
        self.is_separable.then_some(self)
    }
}

/// The root of k u + u³ = f, by bisection.
fn alone(stiffness: f64, load: f64) -> f64 {
    let (mut low, mut high) = (-10.0, 10.0);
    for _ in 0..100 {
        let u = 0.5 * (low + high);
        match stiffness * u + u * u * u > load {
            true => high = u,
            false => low = u,
        }
    }
    low
}

fn entries(solution: &Solution) -> u64 {
    solution.cost().factor_entries
}

#[test]
fn springs_that_stay_apart_are_solved_by_themselves() {
    let springs = [(2.0, 3.0), (1.0, 0.1), (5.0, -2.0), (1.0, 0.0)];
    let solution = row(&springs, &[10.0, 10.0, 10.0]).solved();
    let expected: Vec<f64> = springs.iter().map(|&(k, f)| alone(k, f)).collect();
    assert_near(&solution.state.u, &expected, 1e-12);
    assert_eq!(solution.gaps.len(), 3, "rows that are open are there");
    // as many factors as each spring takes by itself; none of the one without a load
    let each = springs
        .iter()
        .map(|&spring| entries(&row(&[spring], &[]).solve()));
    let each: Vec<u64> = each.collect();
    assert_eq!(entries(&solution), each[..3].iter().sum::<u64>());
}

/// Two that touch from the start move together; those beside them do not notice.
#[test]
fn springs_that_touch_are_solved_together() {
    let solution = row(&[(1.0, 2.0), (1.0, 0.5), (3.0, 1.0)], &[0.0, 5.0]).solved();
    let together = alone(1.0, 1.25); // 2 k u + 2 u³ = 2.5
    assert_near(
        &solution.state.u,
        &[together, together, alone(3.0, 1.0)],
        1e-12,
    );
    assert_near(&solution.lambda, &[2.0 - 1.25, 0.0], 1e-10);
    let pair = entries(&row(&[(1.0, 2.0), (1.0, 0.5)], &[0.0]).solve());
    let third = entries(&row(&[(3.0, 1.0)], &[]).solve());
    assert_eq!(entries(&solution), pair + third);
}

/// The first spring comes to the second by 1, which is moved against the third by that.
#[test]
fn springs_that_come_into_reach_of_each_other_are_joined() {
    let solution = row(
        &[(0.1, 30.0), (1.0, 0.1), (1.0, 0.1), (1.0, 0.2)],
        &[1.0, 0.5, 100.0],
    )
    .solved();
    let u = &solution.state.u;
    assert!((u[0] - u[1] - 1.0).abs() < 1e-9 && (u[1] - u[2] - 0.5).abs() < 1e-9);
    assert!(solution.lambda[0] > 1.0 && solution.lambda[1] > 1.0 && solution.lambda[2] == 0.0);
    assert!((u[3] - alone(1.0, 0.2)).abs() < 1e-12);
}

/// Each of ten pushes the next: more than are joined one after the other.
#[test]
fn all_may_be_joined() {
    let mut springs = vec![(0.1, 0.0); 10];
    springs[0].1 = 200.0;
    let solution = row(&springs, &[0.01; 9]).solved();
    assert!(
        solution.lambda.iter().all(|l| *l > 1.0),
        "{:?}",
        solution.lambda
    );
}

/// What supports do not hold is solved with its neighbours at once, whether it touches them or not.
#[test]
fn loose_springs_are_not_solved_without_their_neighbours() {
    let springs = [(1e-3, 1.0), (1.0, 0.0), (2.0, 1.0)];
    let solution = row(&springs, &[0.5, 9.0]).solved();
    let together = entries(&row(&springs[..2], &[0.5]).solve());
    let third = entries(&row(&springs[2..], &[]).solve());
    assert_eq!(entries(&solution), together + third);
}

/// The next load step takes over the factors of the groups.
#[test]
fn factors_of_groups_are_kept() {
    let springs = row(&[(1.0, 2.0), (1.0, 0.5), (3.0, 1.0)], &[0.0, 5.0]);
    let mut solver = CondensedNewton::default();
    let first = solver
        .solve_from(&springs, at(&[0.0; 3]))
        .expect("a valid problem");
    assert!(first.cost().factorizations > 0);
    let again = solver.solve_from(&springs, first.state.clone());
    assert_eq!(again.expect("a valid problem").cost().factorizations, 0);
}

/// A linear spring pushes a hardening one: its factor has one entry, and so has each of the other's.
#[test]
fn a_linear_body_is_factored_once_beside_another() {
    let mut pair = row(&[(1.0, 20.0), (1.0, 0.0)], &[0.0]);
    pair.springs.parts_mut()[0].hardening = 0.0;
    let solution = pair.solve();
    let [u, v] = solution.state.u[..] else {
        panic!("two unknowns")
    };
    assert!((u - v).abs() < 1e-9 && (u - alone(2.0, 20.0)).abs() < 1e-9);
    let cost = solution.cost();
    assert!(cost.factorizations > 1, "{cost:?}");
    assert_eq!(cost.factor_entries, 1 + cost.factorizations as u64);
}
