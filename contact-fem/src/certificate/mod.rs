//! Certificates of convergence: how well a converged step satisfies the conditions of a solution,
//! evaluated independently of the solver.

mod balance;
#[cfg(test)]
mod planted;
mod remeasured;
mod slope;
mod state;

use std::fmt;

use crate::audit::Overlap;

/// A condition that a solution satisfies. Its residual is dimensionless.
///
/// Lengths are divided by the mean facet size around a node. Weak gaps are divided by the expected
/// displacement of such a facet, that is by its size times
/// [`Scale::resolution`](contact_core::Scale) over the smallest facet: stiff bodies move by a small
/// part of their facets, and may not penetrate by more. Forces are divided by the largest force on
/// a node of the same body, whether from contact, supports or loads, but at least by 1e-4 of the
/// energy of [`Scale`](contact_core::Scale) over its length, since there are hardly any forces when
/// bodies begin to touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Condition {
    /// No contact node is inside another surface: the largest depth, over all passes of the scene.
    /// Weak constraints allow small penetrations, larger ones at corners.
    NodalPenetration,
    /// No weak gap is negative: max(−c_i) over all rows at the state, of all passes of the scene.
    WeakPenetration,
    /// Contact pressures are compressive: max(−λ_i).
    Adhesion,
    /// Forces act at closed gaps only: max |λ_i c_i|, with
    /// [`Scale::resolution`](contact_core::Scale) as the unit of length.
    Complementarity,
    /// The energy is stationary: max |∇E − Cᵀλ| over the free unknowns, with the solver's rows.
    Stationarity,
    /// Another iteration would not change the forces: max |Cᵀλ − C'ᵀλ|, with C' the rows at the
    /// state. `None` if rows of the two cannot be matched by their keys, as in method (39) with
    /// exact integration.
    Drift,
    /// Contact forces are in equilibrium: |Σ Cᵀλ| over all bodies, divided by Σ |Cᵀλ|. Rows on obstacles are left out: an
    /// obstacle takes the force that it gives.
    ActionReaction,
    /// All forces are in equilibrium: |Σ reactions + Σ loads + Σ forces of obstacles| divided by the largest resultant of reactions, loads
    /// or contact forces on a body; the reactions that results tell are those. Forces on nodes are no unit: in nearly incompressible bodies they are large and cancel.
    Balance,
    /// No element is inverted: the number of quadrature points with J ≤ 0 or, if that is larger, of
    /// [simplices](crate::audit) whose volume is not positive, or of quadratic cells in which J > 0 is not
    /// shown everywhere; also in bodies with a law for small strains.
    Inverted,
    /// The solver had every closed row: the number of closed constraints present at the solution
    /// but missing from the solver's rows. A row is closed if its gap is below the default limit of
    /// the weak penetration. For method (39) with exact integration, whose points have no
    /// persistent numbers: the number of passes in which the solver's closed points cover less area
    /// than those at the solution, by more than 1e-4 of it.
    Closed,
    /// As [`Condition::WeakPenetration`], over the passes that the scene leaves out, without a
    /// limit: the penetration that a single pass admits on the other surface. `None` if every pair
    /// has both passes.
    OtherSide,
    /// The number of contact nodes without a row, without a limit. In method (39), whose rows are
    /// points, the rows at the state count.
    Dropped,
    /// No exteriors overlap, whether declared for contact or not: the
    /// [relative depth](crate::audit::Overlap::relative) of the worst overlap at X + u, found without
    /// the contact search.
    Overlap,
    /// Nothing overlaps without a force: the relative depth of the worst overlap of bodies between
    /// which no contact force acts. Weak constraints allow that where facets are as large as the bodies. The
    /// limit is twice what corners that begin to touch leave in the project's own scenes.
    Unopposed,
    /// Laws for small strains are used at small strains: the largest strain or rotation in bodies
    /// with such a law. Their error is of the order of this number; beyond the limit not even the
    /// first digit is right. `None` without such bodies.
    SmallStrain,
    /// Contact forces between bodies have no moment, without a limit: |Σ x ∧ Cᵀλ| divided by Σ |x − c| |Cᵀλ|. Forces
    /// along averaged normals have one on finite facets.
    Moment,
    /// Nothing holds a body in place but supports and contact: the forces that hold motions which neither resists
    /// ([`Solution::held`](contact_core::equilibrium::Solution::held)), Σ |f| on a body, divided by Σ |Cᵀλ| on it, or by the sum of all loads
    /// if that is less and not zero. Averaged normals leave such forces on finite facets; a body that slides or tips needs larger ones. `None` where there are none.
    Held,
    /// The equilibrium is stable, as far as it was examined: the curvature of the energy along the softest motion that closed rows permit, if
    /// it is negative, relative to the solver's matrix ([`Solution::curvature`](contact_core::equilibrium::Solution::curvature)). Where motions are
    /// held, one that deforms bodies is measured by their stiffness at rest, and a rigid one counts where its curvature is not weak. `None` where
    /// it was not examined.
    Instability,
    /// As [`Condition::WeakPenetration`], by gaps that are measured a second time from the meshes alone: own search, feet, normals and
    /// quadrature. To the unit is added what the gap varies by within the row, of which two rules differ by a share: with the sine s of
    /// [`Condition::VirtualWork`] by 0.1 + 150 s², with quadratic cells by 50 + 1000 s², with closest points and exact integration in space by 250. Rows with
    /// less than a tenth of their test function opposite the master are not judged (less than 0.99 with closest points and exact integration in space). What the solver's own gaps are off by is
    /// left to [`Condition::WeakPenetration`]. At the ends of phases, as the five that follow, [`Condition::EnergySlope`] and [`Condition::Inertia`].
    RemeasuredPenetration,
    /// As [`Condition::Complementarity`], by the difference of the same gaps from the solver's.
    RemeasuredComplementarity,
    /// As [`Condition::Closed`], by the same gaps: the number of rows that are closed beyond doubt and that the solver did not have.
    RemeasuredClosed,
    /// Rows weigh their surface: the largest relative difference of the area a_i of a row, whose points all count in full,
    /// from that of the second measurement. 0 with closest points, and with exact integration in space.
    RemeasuredAreas,
    /// Forces act where contact is, along its normals: the largest difference on a node of the solver's Cᵀλ from the forces which the
    /// same λ mean by the second measurement. Quadratures differ on chords by about the square of the sine of the angle in
    /// [`Condition::VirtualWork`]. The unit, as a share of the largest force on the body, is 1e-4 and a twentieth of the largest such square around the node; with
    /// quadratic cells 1e-2 and half of the square; with closest points 0.5. `None` with exact integration in space, and in method (39), whose multipliers belong to points.
    RemeasuredForces,
    /// Forces are the slope of gaps: |v·Cᵀλ − ∂/∂v Σ λ_i c_i|, the largest over rigid motions v of the first body of each pair and two waves of both. The
    /// c_i are those of the second measurement, with feet and normals that follow v. Rows hold feet and normals, and leave out by how
    /// much averaged normals are inclined to the facets: the unit is 1.3 Σ |v| |Cᵀλ| times the mean sine of that angle, which falls with the
    /// facets, and 2e-3 (1e-2 with quadratic cells, 5e-2 with closest points). `None` likewise, and with contact at the reference positions.
    VirtualWork,
    /// Contact forces are the slope of the energy: |v·Cᵀλ − ∂E/∂v| divided by |v|, along a random direction v of each body. The slope is taken from
    /// differences of the energy's value. `None` where displacements are too small for that.
    EnergySlope,
    /// As [`Condition::ActionReaction`], of each two bodies by themselves: the largest.
    PairBalance,
    /// As [`Condition::Moment`], of each two bodies by themselves, about the middle of their forces: the largest. Feet along normals
    /// leave none. `None` with closest points ([`Projection::Closest`](crate::model::Projection)) and around an axis.
    PairMoment,
    /// Bodies without contact between them stay apart: the largest depth of an overlap of two that have no pair, beyond that at the
    /// start, divided by the largest displacement or, if that is less, by the shortest side of the box around either body. What chords of round
    /// surfaces leave at the place is taken from the depth.
    Undeclared,
    /// The equilibrium is stable, by the inertia of a tangent that the certificate assembles: the energy's Hessian, whose product is compared
    /// with differences of gradients, and the slopes of contact forces by differences of the second measurement. The tangent is factored on the
    /// motions that rows with a force permit. The residual is 0 if no motion that deforms bodies releases more than the default limit, or
    /// else the most that one releases. Its unit is the sum of the forces on a body's nodes, divided by the extent of the body, times the mean
    /// square of the motion. Rigid motions are left to [`Condition::Held`] and
    /// [`Condition::Instability`]. `None` in method (39), and with friction.
    Inertia,
    /// Friction is at most what contact allows: the largest |Tᵀr| − |T|ᵀμλ of a free unknown, r and λ being the solver's forces along and against the
    /// surfaces, and μ the scene's. Where rows of both roles hold a place, how they share λ is not unique, but this sum is. `None` without friction, as the
    /// two that follow.
    FrictionLaw,
    /// Surfaces slip where the law's limit is reached, against the force: how far the work of friction in the last load step, Σ r Δs, is from the largest
    /// that contact allows, Σ μλ |Δs|, of each two surfaces, as a share of the latter, or of Σ μλ times
    /// [`Scale::resolution`](contact_core::Scale) if that is larger. The slips Δs are those of rows at the state itself.
    FrictionSlip,
    /// As [`Condition::RemeasuredForces`], of friction: the solver's −Tᵀr against the forces along the surface that the same r mean by the second
    /// measurement.
    RemeasuredFriction,
}

/// One line of the table of conditions.
struct Line {
    condition: Condition,
    name: &'static str,
    /// Limits suit the default tolerance of the fixed-point iteration, 1e-6; those of weak
    /// penetration and complementarity are twice the residual that penalties leave by default.
    limit: f64,
    /// Whether the residual contains the round-off in forces at the scene's strains.
    sees_roundoff: bool,
}

const fn line(condition: Condition, name: &'static str, limit: f64) -> Line {
    Line {
        condition,
        name,
        limit,
        sees_roundoff: matches!(
            condition,
            Condition::Stationarity | Condition::Drift | Condition::Balance
        ),
    }
}

/// The table of conditions from which limits, files and summaries are generated, in the order of
/// [`Condition`].
const TABLE: [Line; 32] = [
    line(Condition::NodalPenetration, "nodal_penetration", 0.2),
    line(Condition::WeakPenetration, "weak_penetration", 2e-3),
    line(Condition::Adhesion, "adhesion", 1e-9),
    line(Condition::Complementarity, "complementarity", 2e-3),
    line(Condition::Stationarity, "stationarity", 1e-6),
    line(Condition::Drift, "drift", 1e-4),
    line(Condition::ActionReaction, "action_reaction", 1e-9),
    line(Condition::Balance, "balance", 1e-6),
    line(Condition::Inverted, "inverted", 0.0),
    line(Condition::Closed, "closed", 0.0),
    line(Condition::OtherSide, "other_side", f64::INFINITY),
    line(Condition::Dropped, "dropped", f64::INFINITY),
    line(Condition::Overlap, "overlap", Overlap::<2>::LIMIT),
    line(Condition::Unopposed, "unopposed", 0.1),
    line(Condition::SmallStrain, "small_strain", 0.5),
    line(Condition::Moment, "moment", f64::INFINITY),
    line(Condition::Held, "held", 2e-2),
    line(Condition::Instability, "instability", 1e-3),
    line(
        Condition::RemeasuredPenetration,
        "remeasured_penetration",
        2e-4,
    ),
    line(
        Condition::RemeasuredComplementarity,
        "remeasured_complementarity",
        2e-4,
    ),
    line(Condition::RemeasuredClosed, "remeasured_closed", 0.0),
    line(Condition::RemeasuredAreas, "remeasured_areas", 1e-4),
    line(Condition::RemeasuredForces, "remeasured_forces", 1.0),
    line(Condition::VirtualWork, "virtual_work", 1.0),
    line(Condition::EnergySlope, "energy_slope", 1e-5),
    line(Condition::PairBalance, "pair_balance", 1e-9),
    line(Condition::PairMoment, "pair_moment", 1e-3),
    line(Condition::Undeclared, "undeclared", 0.05),
    line(Condition::Inertia, "inertia", 0.01),
    line(Condition::FrictionLaw, "friction_law", 1e-5),
    line(Condition::FrictionSlip, "friction_slip", 1e-3),
    line(Condition::RemeasuredFriction, "remeasured_friction", 1.0),
];

impl Condition {
    /// All conditions, in the order of files and summaries.
    pub fn all() -> impl ExactSizeIterator<Item = Condition> {
        TABLE.iter().map(|line| line.condition)
    }

    /// The condition's name in files and summaries.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].name
    }
}

/// The residuals of all conditions at a state. They are evaluated with a new projection at the
/// state itself, without any residual of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// The residual of each condition; `None` if the condition does not apply.
    left: [Option<f64>; TABLE.len()],
    /// The round-off in forces at the scene's strains: [`Scale::roundoff`](contact_core::Scale).
    roundoff: f64,
}

/// The largest residual of each condition with which a certificate holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits([f64; TABLE.len()]);

impl Default for Limits {
    fn default() -> Self {
        Limits(std::array::from_fn(|k| TABLE[k].limit))
    }
}

impl Limits {
    /// The limit of a condition; infinite if it has none.
    pub fn of(&self, condition: Condition) -> f64 {
        self.0[condition as usize]
    }

    /// The same limits with the given one replaced.
    #[must_use]
    pub fn with(mut self, condition: Condition, limit: f64) -> Self {
        self.0[condition as usize] = limit;
        self
    }
}

/// One line of a certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The condition's name.
    pub name: &'static str,
    /// The residual, or `None` if the condition does not apply.
    pub value: Option<f64>,
    /// The largest accepted residual.
    pub limit: f64,
}

impl Entry {
    /// Whether the residual is within the limit; NaN is not.
    pub fn holds(&self) -> bool {
        self.value.is_none_or(|value| value <= self.limit)
    }
}

/// The larger of two values; a NaN is worse than any number.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

impl Certificate {
    /// A certificate with the same residual for every condition.
    pub(crate) fn uniform(left: f64, roundoff: f64) -> Self {
        Certificate {
            left: [Some(left); TABLE.len()],
            roundoff,
        }
    }

    /// The same residuals with the given one replaced.
    #[must_use]
    pub(crate) fn with(mut self, condition: Condition, left: Option<f64>) -> Self {
        self.left[condition as usize] = left;
        self
    }

    /// The residual of a condition, or `None` if the condition does not apply.
    pub fn left(&self, condition: Condition) -> Option<f64> {
        self.left[condition as usize]
    }

    /// The round-off in forces at the scene's strains. A condition on forces is not tested below
    /// ten times this value.
    pub fn roundoff(&self) -> f64 {
        self.roundoff
    }

    /// The residuals of all conditions with their limits.
    pub fn entries(&self, limits: &Limits) -> impl ExactSizeIterator<Item = Entry> + use<> {
        let attainable = 10.0 * self.roundoff;
        let lines = TABLE.iter().zip(self.left).zip(limits.0);
        lines.map(move |((line, value), limit)| Entry {
            name: line.name,
            value,
            limit: match line.sees_roundoff {
                true => limit.max(attainable),
                false => limit,
            },
        })
    }

    /// Whether every residual is within its limit.
    pub fn holds(&self, limits: &Limits) -> bool {
        self.entries(limits).all(|entry| entry.holds())
    }

    /// The larger residual of each condition, of two certificates, as for a run of many steps.
    #[must_use]
    pub fn or_worse(self, other: Self) -> Self {
        // NaN counts as larger than any number
        let worse = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
        Certificate {
            left: std::array::from_fn(|k| match (self.left[k], other.left[k]) {
                (Some(a), Some(b)) => Some(worse(a, b)),
                (a, b) => a.or(b),
            }),
            roundoff: worse(self.roundoff, other.roundoff),
        }
    }
}

/// One line for each condition, with a mark on those beyond their limits, below a line that tells
/// whether all hold.
impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = Limits::default();
        let holds = self.holds(&limits);
        write!(f, "{}", if holds { "holds" } else { "DOES NOT HOLD" })?;
        for entry in self.entries(&limits) {
            let Entry { name, value, limit } = entry;
            match value {
                _ if limit == f64::INFINITY => {
                    let Some(value) = value else { continue };
                    write!(f, "\n    {name:<26} {value:>8.1e} without limit")?;
                }
                Some(value) => {
                    let mark = if entry.holds() { "" } else { "  <- too large" };
                    write!(f, "\n    {name:<26} {value:>8.1e} of {limit:>7.1e}{mark}")?;
                }
                None => write!(f, "\n    {name:<26} {:>8} of {limit:>7.1e}", "-")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_conditions() {
        for (k, line) in TABLE.iter().enumerate() {
            assert_eq!(line.condition as usize, k, "{}", line.name);
        }
    }

    /// A certificate does not hold if any one residual is beyond its limit or NaN.
    #[test]
    fn every_limit_counts() {
        let (limits, flawless) = (Limits::default(), Certificate::uniform(0.0, 0.0));
        assert!(flawless.holds(&limits));
        for condition in Condition::all().filter(|c| limits.of(*c).is_finite()) {
            let limit = limits.of(condition);
            let at = |left| flawless.with(condition, Some(left)).holds(&limits);
            assert!(
                at(limit) && !at(limit + 1e-9) && !at(f64::NAN),
                "{condition:?}"
            );
            let wider = limits.with(condition, 2.0);
            assert!(flawless.with(condition, Some(2.0)).holds(&wider));
        }
    }

    /// Faults that anyone would call one, each alone: half a facet deep, a hundredth of what a facet
    /// moves by, a force that pulls by a millionth of the largest. Less than penalties, tolerances and
    /// corners leave is none.
    #[test]
    fn limits_tell_faults_from_what_is_left_in_sound_states() {
        let limits = Limits::default();
        for (condition, sound, fault) in [
            (Condition::NodalPenetration, 0.1, 0.5),
            (Condition::WeakPenetration, 1e-3, 1e-2),
            (Condition::Adhesion, 0.0, 1e-6),
            (Condition::Complementarity, 1e-3, 1e-2),
            (Condition::Stationarity, 1e-8, 1e-4),
            (Condition::Drift, 1e-6, 1e-2),
            (Condition::ActionReaction, 1e-12, 1e-6),
            (Condition::Balance, 1e-8, 1e-4),
            (Condition::Inverted, 0.0, 1.0),
            (Condition::Closed, 0.0, 1.0),
            (Condition::Overlap, 0.2, 0.5),
            (Condition::Unopposed, 0.05, 0.3),
            (Condition::SmallStrain, 0.1, 1.0),
        ] {
            let with = |left| Certificate::uniform(0.0, 0.0).with(condition, Some(left));
            assert!(with(sound).holds(&limits), "{condition:?} {sound}");
            assert!(!with(fault).holds(&limits), "{condition:?} {fault}");
        }
    }

    /// Round-off widens the limits of sums of forces to ten times itself, and no others.
    #[test]
    fn round_off_widens_the_limits_of_forces_alone() {
        for (roundoff, widened) in [(1e-3, 1e-2), (1e-12, 0.0)] {
            let certificate = Certificate::uniform(0.0, roundoff);
            for entry in certificate.entries(&Limits::default()) {
                let line = TABLE.iter().find(|line| line.name == entry.name);
                let own = line.expect("named").limit;
                let sees = ["stationarity", "drift", "balance"].contains(&entry.name);
                let expected = if sees { own.max(widened) } else { own };
                assert_eq!(entry.limit, expected, "{} {roundoff}", entry.name);
            }
        }
        let [fine, coarse] = [1e-9, 1e-5].map(|roundoff| Certificate::uniform(0.0, roundoff));
        assert_eq!(fine.or_worse(coarse).roundoff(), 1e-5);
        assert_eq!(coarse.or_worse(fine).roundoff(), 1e-5);
    }

    /// NaN is worse than any number, on either side.
    #[test]
    fn nothing_is_worse_than_nan() {
        assert!(worse(f64::NAN, 1.0).is_nan());
        assert_eq!((worse(2.0, 1.0), worse(1.0, 2.0)), (2.0, 2.0));
        let residuals = [0.0, f64::NAN, 3.0];
        assert!(residuals.iter().fold(0.0, |all, r| worse(*r, all)).is_nan());
    }

    /// The larger residual of two certificates is kept, in either order, and so is NaN.
    #[test]
    fn the_worse_of_two() {
        let flawless = Certificate::uniform(0.0, 0.0);
        for condition in Condition::all() {
            for bad in [0.5, f64::NAN] {
                let worse = flawless.with(condition, Some(bad));
                for both in [worse.or_worse(flawless), flawless.or_worse(worse)] {
                    let left = both.left(condition).expect("kept");
                    assert!(
                        left == bad || bad.is_nan() && left.is_nan(),
                        "{condition:?}"
                    );
                }
            }
            let absent = flawless.with(condition, None);
            assert_eq!(absent.or_worse(flawless).left(condition), Some(0.0));
        }
    }
}
