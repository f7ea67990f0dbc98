//! The iteration at one load: steps of Newton's method, and when they end.

use std::time::Instant;

use super::super::condensed::halt::Halt;
use super::super::{StepContext, relative_change};
use super::CLOSED;
use super::linearization::Linearization;
use super::point::Point;
use super::slips::is_of_slips;
use super::stability::{Softest, dot};
use super::step::{Accuracy, Step};
use super::tangent::Tangent;
use super::trial::{HALVINGS, Trial};
use super::watchdog::Watchdog;
use crate::{ContactProblem, Cost, Multipliers, RowKey, State};

/// A small step with a larger shift of the diagonal, relative to K's, does not show convergence.
const SHIFT: f64 = 1e-5;
/// Corrections of a step below this share of the displacements are not needed, nor corrections below a tenth of the tolerance.
const NEGLIGIBLE: f64 = 1e-11;
/// The iteration also ends after a step of up to so many tolerances, relative to the displacements, if the state after the step is an
/// equilibrium to this share of the tolerance.
const NEARLY: f64 = 1e2;
const CLEARLY: f64 = 1e-2;
/// What a step may leave of the complementarity, as a share of the displacements: usually so little that the next state shows an
/// equilibrium.
const INDEPENDENT: f64 = 1e-11;
/// The round-off of gaps, as a share of the largest coordinate.
const ROUNDOFF: f64 = 4.0 * f64::EPSILON;
/// More than so many steps show that rows nearly depend on each other. The rows of both bodies do where the side of one lies flat on a facet of
/// the other. They contradict each other by what is of second order in a step. To satisfy all of them takes far larger changes of the
/// multipliers, and these lead to the next contradiction. Later steps therefore leave so many tolerances, and equilibria may have gaps of so many. The
/// three numbers were chosen on dies that slide on slabs.
const USUAL: usize = 10;
const DEPENDENT: f64 = 10.0;
const GAPS: f64 = 30.0;
/// Equilibria are examined where the sum of the multipliers has grown by this factor.
const GROWN: f64 = 2.0;
/// They are examined, too, where the curvature along the softest motion is below this share of what it was.
const FLATTER: f64 = 0.7;
/// An unstable equilibrium is left by this share of the displacements, and then by so many steps with frozen rows: they
/// lead away from it, where Newton's lead back.
const PUSH: f64 = 0.05;
const FROZEN: usize = 8;
/// So many are left at one load.
const LEAVES: usize = 3;

/// The iteration at one load.
pub(super) struct Iterate<'a> {
    pub(super) problem: &'a dyn ContactProblem,
    pub(super) at: &'a mut Point,
    pub(super) watchdog: Watchdog,
    /// Lower bound on the size of the displacements (UL), and bound on their relative change.
    pub(super) least: f64,
    pub(super) tolerance: f64,
    /// The unit of lengths (UL).
    pub(super) unit: f64,
    /// The length of the last step, unshortened (UL).
    pub(super) length: Option<f64>,
    /// The multipliers of the iterate before.
    pub(super) before: Multipliers,
    /// The sum of the multipliers of the last equilibrium that was examined (UF), and its curvature in this load step.
    pub(super) examined: f64,
    pub(super) curvature: Option<f64>,
    /// See [`Kept::watched`].
    pub(super) watched: Option<(Vec<f64>, f64)>,
    /// The softest motion, as examined in the last steps towards an equilibrium; `None` if the steps are longer.
    pub(super) softest: Option<Softest>,
    /// The least curvature, relative to S, if the last steps have shown it to be positive although S has a shifted diagonal.
    pub(super) stable: Option<f64>,
    /// Whether a phase begins or ends with this load step.
    pub(super) is_end: bool,
    /// Whether supports alone do not hold some body.
    pub(super) floats: bool,
    /// The stiffness of springs (n, UF/UL); empty without.
    pub(super) springs: &'a [f64],
    /// The unstable equilibrium that was left last, with its curvature.
    pub(super) unstable: Option<(Point, f64)>,
    /// How many were left.
    pub(super) left: usize,
    /// Where it was left for.
    pub(super) beside: Option<State>,
    /// The number of steps at this load.
    pub(super) steps: usize,
    /// The number of steps with frozen rows to come.
    pub(super) frozen: usize,
    pub(super) context: &'a StepContext<'a>,
}

/// How an iteration went.
pub(super) struct Moved {
    /// The relative change of u.
    pub(super) error: f64,
    /// Whether the iteration has converged.
    pub(super) is_over: bool,
}

impl Moved {
    fn on(error: f64) -> Self {
        Moved {
            error,
            is_over: false,
        }
    }
}

impl Iterate<'_> {
    /// Whether it takes so long that rows may nearly depend on each other.
    fn has_dependent_rows(&self) -> bool {
        self.steps > USUAL && self.at.slips.contacts() > 1
    }

    /// What a step may leave of the complementarity, and an equilibrium of the gaps beside its own bound, as shares of the displacements.
    fn gaps(&self) -> [f64; 2] {
        let roundoff = ROUNDOFF * self.problem.extent() / self.at.size(self.least);
        let shares = match self.has_dependent_rows() {
            true => [DEPENDENT, GAPS].map(|tolerances| tolerances * self.tolerance),
            false => [INDEPENDENT, 0.0],
        };
        shares.map(|share| share.max(roundoff))
    }

    /// The change of u below which a step is small: where steps leave gaps, they are no more accurate than these.
    fn small(&self) -> f64 {
        match self.has_dependent_rows() {
            true => DEPENDENT * self.tolerance,
            false => self.tolerance,
        }
    }

    /// The rows of contact that the last step opened or closed.
    pub(super) fn switched(&self) -> Vec<RowKey> {
        let mut all = self.at.state.multipliers.switched(&self.before);
        all.retain(|key| !is_of_slips(*key));
        all
    }

    /// Moves by one step of Newton's method, or back to the best state.
    pub(super) fn moved(&mut self, tangent: &mut Tangent, cost: &mut Cost) -> Result<Moved, Halt> {
        self.steps += 1;
        // that of this step
        let stable = self.stable;
        let trial = match self.trial(tangent, cost) {
            // away from the best state, what fails may be the state
            Err(Halt::Failed(why)) => match self.watchdog.retreat() {
                Some(best) => {
                    self.go_back_to(best, tangent);
                    return Ok(Moved::on(f64::INFINITY));
                }
                None => return Err(Halt::Failed(why)),
            },
            trial => trial?,
        };
        let error = relative_change(&trial.u, &self.at.state.u, self.least);
        let now = State {
            multipliers: Multipliers::new(&self.at.gaps, &trial.lambda),
            u: trial.u,
        };
        self.before = std::mem::replace(&mut self.at.state, now).multipliers;
        let clock = Instant::now();
        self.at.project(self.problem, self.context)?;
        cost.projection += clock.elapsed().as_secs_f64();
        // a shortened step makes small changes far from a solution
        let whole = error / trial.share;
        if whole < NEARLY * self.tolerance && trial.varies {
            let is_small = whole < self.tolerance;
            // too stiff an S underestimates how far the forces that are left would move a row
            let holds_an_open_row = tangent.holds_an_open_row(|key| self.at.lets_go(key));
            let ratio = tangent.ratio().max(1.0);
            let bound = match holds_an_open_row {
                false if is_small => self.tolerance.max(CLOSED),
                false if whole < self.small() => self.tolerance / ratio,
                _ => CLEARLY * self.tolerance / ratio,
            };
            let bound = bound * stable.unwrap_or(1.0);
            let bounds = [bound, bound.max(self.gaps()[1])];
            let measures = (bounds, self.unit, self.least);
            if let Some(left) = self.at.equilibrium(self.problem, tangent, measures, cost)? {
                let can_leave = self.left < LEAVES && self.springs.is_empty();
                let softest = self.softest.take().filter(Softest::is_unstable);
                if let Some(softest) = softest.filter(|_| can_leave) {
                    self.leave(&softest, tangent)?;
                    return Ok(Moved::on(error));
                }
                // so does a shifted diagonal, unless it is known by how much
                if tangent.shift() <= SHIFT || stable.is_some() {
                    return Ok(Moved {
                        error: if is_small { error } else { left },
                        is_over: true,
                    });
                }
            } else if is_small && holds_an_open_row {
                tangent.forget();
            }
        }
        let whole = match tangent.shift() > 0.0 {
            true => None,
            false => Some(whole),
        };
        if let Some(best) = self
            .watchdog
            .judge(self.at, trial.energy, trial.share, whole)
        {
            self.go_back_to(best, tangent);
        }
        Ok(Moved::on(error))
    }

    /// Leaves an unstable equilibrium along its softest motion.
    fn leave(&mut self, softest: &Softest, tangent: &mut Tangent) -> Result<(), Halt> {
        self.unstable = Some((self.at.clone(), softest.curvature));
        self.left += 1;
        let energy = self.problem.energy();
        let from = self.at.state.u.clone();
        let mut length = PUSH * self.at.size(self.least);
        let mut value = f64::INFINITY;
        for _ in 0..HALVINGS {
            let moved = from.iter().zip(&softest.motion);
            self.at.state.u = moved.map(|(u, v)| u + length * v).collect();
            value = energy.value(&self.at.state.u);
            if value.is_finite() {
                break;
            }
            length *= 0.5;
        }
        self.beside = Some(self.at.state.clone());
        self.at.project(self.problem, self.context)?;
        self.watchdog = Watchdog::new(self.at, value);
        self.length = None;
        self.frozen = FROZEN;
        tangent.stiffen();
        Ok(())
    }

    fn go_back_to(&mut self, best: Point, tangent: &mut Tangent) {
        *self.at = best;
        self.length = None;
        tangent.forget();
    }

    /// The end of Newton's step from here, shortened as far as it must be.
    fn trial(&mut self, tangent: &mut Tangent, cost: &mut Cost) -> Result<Trial, Halt> {
        let (state, size) = (&self.at.state, self.at.size(self.least));
        let varies = self.frozen == 0;
        let mut here = Linearization::new(self.problem, self.at, varies, self.context.stop, cost)?;
        here.springs = self.springs;
        here.is_stable = self.stable.is_some();
        self.frozen = self.frozen.saturating_sub(1);
        let accuracy = Accuracy {
            before: self.length.take(),
            negligible: NEGLIGIBLE.min(0.1 * self.tolerance) * size,
            gaps: self.gaps()[0],
        };
        let step = loop {
            match Step::new(&here, tangent, size, &accuracy, self.context.stop, cost) {
                Err(Halt::Failed(_)) if !tangent.is_fresh() => tangent.forget(),
                Ok(step) if !step.is_settled && !tangent.is_fresh() => tangent.forget(),
                Ok(step) if !step.is_settled && tangent.raise() => {}
                step => break step?,
            }
        };
        self.length = Some(step.length);
        let limit = self.watchdog.limit();
        let mut trial = Trial::new(self.problem.energy(), &here, state, &step, limit, cost)?;
        trial.varies = varies;
        let error = relative_change(&trial.u, &state.u, self.least);
        tangent.moved(error, step.corrections);
        let pushed: f64 = step.lambda.iter().sum();
        let is_last = error / trial.share < NEARLY * self.tolerance && varies;
        if !is_last {
            (self.softest, self.stable) = (None, None);
        }
        // a matrix that is not positive definite may show an unstable equilibrium, or a motion that nothing resists
        let is_flat = tangent.shift() > SHIFT;
        if is_last && (is_flat && !self.floats || !is_flat && self.is_due(&here, pushed)) {
            let held = here.slips.holding(&step.lambda);
            let rows = (&step.condensed, &held[..]);
            self.softest = Softest::new(&here, tangent, rows, self.floats, self.context.stop)?;
            self.curvature = self.softest.as_ref().map(|softest| softest.curvature);
            let asked = self.softest.as_ref().filter(|_| is_flat && !self.floats);
            self.stable = asked.and_then(Softest::stable);
            self.examined = pushed;
            self.watched = self.softest.as_ref().map(|softest| {
                let v = softest.motion.clone();
                let curvature = dot(&v, &here.curvature(&v));
                (v, curvature)
            });
        }
        Ok(trial)
    }

    /// Whether the equilibrium is to be examined, where the sum of the multipliers is `pushed`: at the ends of phases, where that sum has
    /// grown, and where the energy has become flatter along the motion that was the softest.
    fn is_due(&self, here: &Linearization<'_>, pushed: f64) -> bool {
        let flattens = |(v, then): &(Vec<f64>, f64)| !(dot(v, &here.curvature(v)) > FLATTER * then);
        let may_lose = pushed > 0.0 || !self.problem.energy().is_quadratic();
        let grows = !(pushed <= GROWN * self.examined);
        may_lose && (self.is_end || self.unstable.is_some() || grows)
            || self.watched.as_ref().is_some_and(flattens)
    }
}
