//! The balance of the forces between each two bodies by themselves.

use contact_core::LinearGaps;

use super::state::{moment_about, over};
use super::worse;
use crate::model::{Problem, Projection};
use crate::tensor::Vector;

/// The largest imbalances of the forces between two bodies.
pub(super) struct Balance {
    /// |Σ f| / Σ |f|.
    pub sum: f64,
    /// |Σ x ∧ f| / Σ |x − c| |f| with the middle c of the forces; `None` where feet are closest points, and around an axis.
    pub moment: Option<f64>,
}

/// Of the forces between each two bodies, where their nodes are at `x`; forces below `noticed` (UF) are none.
pub(super) fn of_pairs<const D: usize>(
    problem: &Problem<D>,
    x: &[Vector<D>],
    (gaps, lambda): (&LinearGaps, &[f64]),
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
        let Some(forces) = problem.forces_of((gaps, lambda), is_own) else {
            continue;
        };
        let magnitude: f64 = forces.iter().map(Vector::norm).sum();
        let sum: Vector<D> = forces.iter().sum();
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
