//! The balance of the forces between each two bodies by themselves.

use contact_core::equilibrium::Solution;

use super::state::{moment_about, over};
use super::worse;
use crate::model::{Problem, Projection};
use crate::tensor::Vector;

/// The largest imbalances of the forces between two bodies.
pub(super) struct Balance {
    /// |Σ f| / Σ |f|, with friction in the first sum.
    pub sum: f64,
    /// |Σ x ∧ f| / Σ |x − c| |f| with the middle c of the forces, without friction, which acts at both ends of a gap; `None` where feet are closest points, and around an axis.
    pub moment: Option<f64>,
}

/// Of the forces between each two bodies, where their nodes are at `x`; forces below `noticed` (UF) are none.
pub(super) fn of_pairs<const D: usize>(
    problem: &Problem<D>,
    x: &[Vector<D>],
    solution: &Solution,
    noticed: f64,
) -> Balance {
    let bodies = |pass: &crate::contact::Pass| {
        let [a, b] = problem.bodies_of(*pass);
        [a.min(b), a.max(b)]
    };
    let passes = problem.passes().iter();
    let between = passes.filter(|pass| problem.obstacle_of(**pass).is_none());
    let mut pairs: Vec<[usize; 2]> = between.map(bodies).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let has_moment = problem.scene().projection == Projection::AlongNormals
        && !problem.scene().is_of_revolution();
    let mut balance = Balance {
        sum: 0.0,
        moment: has_moment.then_some(0.0),
    };
    for pair in pairs {
        let is_own = |pass: &crate::contact::Pass| {
            bodies(pass) == pair && problem.obstacle_of(*pass).is_none()
        };
        let rows = (&solution.gaps, &solution.lambda[..]);
        let Some(forces) = problem.forces_of(rows, is_own) else {
            continue;
        };
        let friction = problem.forces_of_friction(solution.friction.as_ref(), is_own);
        let magnitude: f64 = forces.iter().map(Vector::norm).sum();
        let sum: Vector<D> = forces.iter().chain(friction.iter().flatten()).sum();
        balance.sum = worse(balance.sum, over(sum.norm(), magnitude.max(noticed)));
        if magnitude > noticed {
            let weighted = x.iter().zip(&forces).map(|(x, f)| x * f.norm());
            let centre = weighted.sum::<Vector<D>>() / magnitude;
            let own = moment_about(&centre, x, &forces);
            balance.moment = balance.moment.map(|moment| worse(moment, own));
        }
    }
    balance
}
