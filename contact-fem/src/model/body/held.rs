//! Supports that hold in some phases alone.

use std::collections::BTreeMap;

use super::{Body, Supports};
use crate::error::Error;
use crate::model::switches::{During, phases};
use crate::program::samples;
use crate::tensor::unit_vector;

/// The supports of a body as they were declared, and which of them hold it.
#[derive(Clone, Default)]
pub(in crate::model) struct Declarations {
    all: Vec<Declared>,
    /// When those hold that are declared now, within [`Body::during`].
    current: Option<During>,
    /// Of each dof the declaration that holds it now; empty while all hold at all times.
    by: Vec<Option<usize>>,
    /// What supports that have let go leave for the next phase.
    fading: Fading,
}

#[derive(Clone)]
struct Declared {
    /// Its boundary, by its place among [`Body::support_names`].
    name: usize,
    /// Dofs in ascending order, with their values and courses.
    held: Vec<(usize, (f64, usize))>,
    /// `None`: at all times.
    during: Option<During>,
}

impl Declared {
    /// Since when it holds at `t`, the load factor 0 or a later one; `None` if it does not.
    fn since(&self, t: f64) -> Option<f64> {
        match &self.during {
            None => Some(0.0),
            Some(during) => Some(during.beginning(t)?.max(0.0)),
        }
    }
}

/// Supports of one component may differ by this share of the mesh's size.
const SAME: f64 = 1e-12;
const ALWAYS: [f64; 2] = [0.0, f64::INFINITY];

/// What supports that have let go do within a phase.
#[derive(Clone, Default)]
struct Fading {
    span: [f64; 2],
    released: Vec<Released>,
    /// The stiffness, halfway, of the springs that they become, for each unit of reaction (1/UL); `None`: they become forces, which fall
    /// in equal shares.
    stiffness: Option<f64>,
}

/// A dof that a support has let go.
#[derive(Clone)]
struct Released {
    dof: usize,
    /// Its displacement (UL) and the reaction (UF) when the phase began.
    place: f64,
    reaction: f64,
    /// The magnitude of the reaction of the node's components that are let go (UF).
    share: f64,
    /// The number of the boundary's name.
    name: usize,
}

impl Fading {
    /// What is left of the phase at `t`, from 1 to 0.
    fn left(&self, t: f64) -> f64 {
        let [from, until] = self.span;
        ((until - t) / (until - from)).clamp(0.0, 1.0)
    }

    /// The stiffness of the springs at `t`, for each unit of reaction (1/UL): it falls from infinity to zero. It is 0 without springs, and
    /// where the phase begins.
    fn stiffness_at(&self, t: f64) -> f64 {
        match (self.stiffness, self.left(t)) {
            (Some(halfway), left) if left < 1.0 => halfway * left / (1.0 - left),
            _ => 0.0,
        }
    }

    /// The force (UF) of a released dof at `t` and the displacement `u` (UL).
    fn force(&self, own: &Released, t: f64, u: f64) -> f64 {
        match self.stiffness {
            Some(_) => self.stiffness_at(t) * own.share * (own.place - u),
            None => self.left(t) * own.reaction,
        }
    }
}

/// What holds a body in a phase, to be put back.
pub(in crate::model) struct Holding<const D: usize> {
    supports: Supports<D>,
    prescribed: Vec<Option<f64>>,
    support_of: Vec<Option<usize>>,
    by: Vec<Option<usize>>,
    fading: Fading,
}

impl Declarations {
    /// Whether supports hold that are declared now for some phases alone, or such were declared before.
    fn is_switched(&self) -> bool {
        self.current.is_some() || self.all.iter().any(|own| own.during.is_some())
    }

    /// The values of a dof by declarations that hold together with those that are declared now, and from when until when.
    fn beside(&self, dof: usize) -> impl Iterator<Item = ((f64, usize), [f64; 2])> {
        let spans = |own: &Declared| -> Vec<[f64; 2]> {
            match (&own.during, &self.current) {
                (Some(own), Some(now)) => own.common(now).collect(),
                (Some(one), None) | (None, Some(one)) => one.intervals().collect(),
                (None, None) => vec![ALWAYS],
            }
        };
        let all = self.all.iter().filter_map(move |own| {
            let place = own.held.binary_search_by_key(&dof, |(dof, _)| *dof);
            place.ok().map(|place| (own.held[place].1, spans(own)))
        });
        all.flat_map(|(value, spans)| spans.into_iter().map(move |span| (value, span)))
    }
}

impl<const D: usize> Body<D> {
    /// Supports that hold at some load factors t alone, those with `from` < t ≤ `to` for one of the `intervals`: in the phases
    /// that begin at `from` and end at `to`, which may be infinite. `supports` declares them, by [`Body::prescribe`] and
    /// whatever else prescribes displacements.
    ///
    /// A support that begins later than the run takes nodes where they are, and moves them by what its values grow from then on:
    /// zero holds them in place. A rigid motion goes on from there, so that the boundary keeps the shape that it has.
    ///
    /// A support that ends lets go over the next phase. Until the end of that phase, what it still does counts as its reaction.
    /// On a body of small strains, its reaction falls to zero in equal shares. On any other, it becomes springs, one for each
    /// component of a node that it held, fixed where the node was: |r| k (1 − s)/s is their stiffness at a node with the reaction r in the share s
    /// of the phase. It falls from infinity to zero, and halfway, springs that carried the reactions would store as much energy as the
    /// bodies did: k = Σ |r|/2W. All would be stretched alike, so that a body that is strained evenly comes back evenly. Springs cannot turn
    /// a body over, as forces that keep their direction can. Where another support holds the same component, it stays held.
    ///
    /// A bar is drawn by 0.1, and its end is let go:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, NeoHookean, Phase, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = rectangle(&linspace(0.0, 4.0, 8), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
    /// let mut bar = Body::new(mesh, NeoHookean::new(200.0, 0.3)?);
    /// bar.prescribe("left", [Some(0.0), Some(0.0)])?;
    /// bar.during(&[[0.0, 1.0]], |bar| bar.prescribe("right", [Some(0.1), Some(0.0)]))?;
    /// let mut scene = Scene::new();
    /// let bar = scene.add("bar", bar);
    /// let mut problem = scene.problem()?;
    /// let phases = [Phase::new("draw", 1.0, 2), Phase::new("let go", 2.0, 2)];
    /// let history = Simulation::in_phases(phases).run(&mut problem)?;
    /// let [drawn, free] = [1, 3].map(|step| &history.steps[step]);
    /// assert!(drawn.stored_energy > 0.1 && free.stored_energy < 1e-9);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// An interval whose end is not beyond its beginning, numbers that are not, and what `supports` answers: two values for a
    /// component at the same time, and loads, foundations and supports along other directions than axes, which are not switched. A run whose phases do not
    /// end where supports are switched is refused before it begins, and so is one in a phase of which nothing holds a body.
    pub fn during(
        &mut self,
        intervals: &[[f64; 2]],
        supports: impl FnOnce(&mut Self) -> Result<&mut Self, Error>,
    ) -> Result<&mut Self, Error> {
        self.always("`during`")?;
        if self.is_rigid() {
            return Err(Error::NotRigid {
                what: "a support that does not hold at all times",
                remedy: "let forces with an amplitude take its place",
            });
        }
        let name = "end of the interval in which a support holds";
        self.declared.current = Some(During::new(intervals, name)?);
        let held = supports(self).map(|_| ());
        self.declared.current = None;
        held.map(|()| self)
    }

    /// # Errors
    /// Within [`Body::during`].
    pub(super) fn always(&self, what: &'static str) -> Result<(), Error> {
        match self.declared.current {
            None => Ok(()),
            Some(_) => Err(Error::NotSwitched { what }),
        }
    }

    /// Whether some supports do not hold at all times.
    pub(in crate::model) fn is_switched(&self) -> bool {
        self.declared.is_switched()
    }

    /// Where a value of a dof differs from that of a support which holds together with one that is declared now: the load factor, and
    /// both values, or by what they have grown since the later one begins.
    pub(super) fn differs(&self, dof: usize, value: (f64, usize)) -> Option<(f64, [f64; 2])> {
        let is_led = self.is_rigid() || self.slides(dof / D);
        let beside: Vec<_> = match self.is_switched() || is_led {
            true => self.declared.beside(dof).collect(),
            false => {
                let known = self.supports.values[dof].into_iter();
                known.map(|known| (known, ALWAYS)).collect()
            }
        };
        let differ = |(known, [from, until]): ((f64, usize), [f64; 2])| {
            let since = from.max(0.0);
            let span = [since, until.min(since + 1.0)];
            self.differ_in(dof, [known, value], since, span)
        };
        beside.into_iter().find_map(differ)
    }

    /// The last load factor from `from` to `until` at which two values of a dof differ, and both, or by what they have grown `since`.
    fn differ_in(
        &self,
        dof: usize,
        values: [(f64, usize); 2],
        since: f64,
        [from, until]: [f64; 2],
    ) -> Option<(f64, [f64; 2])> {
        let grown = |value, t| {
            let course = |t| self.supports.course_at(dof, value, t);
            match since > 0.0 {
                true => course(t) - course(since),
                false => course(t),
            }
        };
        let times = samples().rev().map(|share| from + (until - from) * share);
        let all = times.map(|t| (t, values.map(|value| grown(value, t))));
        let mut other = all.filter(|(_, [a, b])| a != b).peekable();
        other.peek()?;
        let (low, high) = self.mesh.bounding_box();
        let same = SAME * (high - low).norm();
        // numbers that are none differ
        other.find(|(_, [a, b])| !((a - b).abs() <= same))
    }

    /// Adds a support of a boundary, by its number, and lets it hold if it does from the beginning.
    pub(super) fn declare(&mut self, name: usize, mut held: Vec<(usize, (f64, usize))>) {
        held.sort_unstable_by_key(|(dof, _)| *dof);
        held.dedup_by_key(|(dof, _)| *dof);
        let during = self.declared.current.clone();
        self.declared.all.push(Declared { name, held, during });
        if self.is_switched() {
            self.let_hold(&self.holders(0.0));
        } else if let Some(last) = self.declared.all.last() {
            for &(dof, value) in &last.held {
                self.prescribed[dof] = Some(self.supports.value(dof, value, 1.0));
                self.supports.values[dof] = Some(value);
                self.support_of[dof].get_or_insert(name);
            }
        }
    }

    /// The value, course and boundary's number of a support that holds a dof at all times.
    pub(super) fn declared_at_all_times(&self, dof: usize) -> Option<((f64, usize), usize)> {
        let mut always = self.declared.all.iter().filter(|own| own.during.is_none());
        always.find_map(|own| {
            let place = own.held.binary_search_by_key(&dof, |(dof, _)| *dof);
            place.ok().map(|place| (own.held[place].1, own.name))
        })
    }

    /// Whether a support holds a component of a node in some phases alone.
    pub(super) fn is_switched_at(&self, node: usize) -> bool {
        let dofs = D * node..D * (node + 1);
        let mut switched = self.declared.all.iter().filter(|own| own.during.is_some());
        switched.any(|own| own.held.iter().any(|(dof, _)| dofs.contains(dof)))
    }

    /// Of each dof the declaration that holds it at `t`.
    fn holders(&self, t: f64) -> Vec<Option<usize>> {
        let mut by = vec![None; self.prescribed.len()];
        for (k, own) in self.declared.all.iter().enumerate() {
            if own.during.as_ref().is_none_or(|during| during.has(t)) {
                for (dof, _) in &own.held {
                    by[*dof].get_or_insert(k);
                }
            }
        }
        by
    }

    fn let_hold(&mut self, by: &[Option<usize>]) {
        for (dof, holder) in by.iter().enumerate() {
            if self.slides(dof / D) {
                continue;
            }
            let own = holder.map(|k| &self.declared.all[k]);
            let value = own.and_then(|own| {
                let place = own.held.binary_search_by_key(&dof, |(dof, _)| *dof);
                place.ok().map(|place| own.held[place].1)
            });
            self.support_of[dof] = own.map(|own| own.name);
            self.supports.values[dof] = value;
            self.prescribed[dof] = value.map(|value| self.supports.value(dof, value, 1.0));
        }
        self.declared.by = by.to_vec();
    }

    /// Lets those supports hold that do in a phase. `U` and `reactions` are displacements (UL) and reactions (UF) of all dofs where it
    /// begins. Returns whether others dofs are held than before, or from other places.
    pub(in crate::model) fn switch_supports(
        &mut self,
        span: [f64; 2],
        U: &[f64],
        reactions: &[f64],
    ) -> bool {
        let [from, until] = span;
        self.declared.fading = Fading::default();
        let by = self.holders(0.5 * (from + until));
        let before = std::mem::take(&mut self.declared.by);
        let was_begun = !self.supports.begun.is_empty();
        if from == 0.0 {
            self.supports.begun.clear();
        } else if by == before {
            self.declared.by = by;
            return false;
        }
        let mut released = Vec::new();
        for (dof, (now, then)) in by.iter().zip(&before).enumerate() {
            if now == then || from == 0.0 {
                continue;
            }
            self.supports.begun.remove(&dof);
            match (now, then) {
                (Some(_), _) => {
                    self.supports.begun.insert(dof, (U[dof], from));
                }
                (None, Some(then)) => released.push(Released {
                    dof,
                    place: U[dof],
                    reaction: reactions[dof],
                    share: 0.0,
                    name: self.declared.all[*then].name,
                }),
                _ => {}
            }
        }
        let mut shares = BTreeMap::new();
        for own in &released {
            let share = shares.entry(own.dof / D).or_insert(0.0_f64);
            *share = share.hypot(own.reaction);
        }
        let share = |own: &mut Released| own.share = shares[&(own.dof / D)];
        released.iter_mut().for_each(share);
        released.retain(|own| own.share > 0.0);
        let is_other = by != before || was_begun;
        self.let_hold(&by);
        self.declared.fading = Fading {
            span,
            released,
            stiffness: None,
        };
        is_other
    }

    /// Σ |r| over the reactions (UF) of nodes that supports let go in this phase.
    pub(in crate::model) fn sum_released(&self) -> f64 {
        let released = self.declared.fading.released.iter();
        // of each node the share of one of its components
        released
            .map(|own| own.reaction * own.reaction / own.share)
            .sum()
    }

    /// Whether what they leave are springs.
    pub(crate) fn softens(&self) -> bool {
        self.declared.fading.stiffness.is_some()
    }

    /// Lets what they leave be springs, of a stiffness halfway through the phase for each unit of reaction (1/UL).
    pub(in crate::model) fn soften(&mut self, halfway: f64) {
        self.declared.fading.stiffness = Some(halfway);
    }

    /// The springs that they leave: dofs, their displacements when the phase began (UL), and their reactions (UF).
    pub(super) fn softening(&self) -> Vec<(usize, f64, f64)> {
        let fading = &self.declared.fading;
        let released = fading.stiffness.iter().flat_map(|_| &fading.released);
        released
            .map(|own| (own.dof, own.place, own.share))
            .collect()
    }

    /// Their stiffness at a load factor, for each unit of reaction (1/UL).
    pub(in crate::model) fn softening_stiffness(&self, factor: f64) -> f64 {
        self.declared.fading.stiffness_at(factor)
    }

    /// Changes supports, or leaves them as they are.
    pub(super) fn or_not(
        &mut self,
        change: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<&mut Self, Error> {
        let (held, rollers) = (self.holding(), self.rollers.clone());
        let (names, declared) = (self.supported.len(), self.declared.all.len());
        let changed = change(self);
        if changed.is_err() {
            self.hold_again(held);
            self.rollers = rollers;
            self.supported.truncate(names);
            self.declared.all.truncate(declared);
        }
        changed.map(|()| self)
    }

    /// What holds the body now.
    pub(in crate::model) fn holding(&self) -> Holding<D> {
        Holding {
            supports: self.supports.clone(),
            prescribed: self.prescribed.clone(),
            support_of: self.support_of.clone(),
            by: self.declared.by.clone(),
            fading: self.declared.fading.clone(),
        }
    }

    /// Lets the body be held as it was.
    pub(in crate::model) fn hold_again(&mut self, holding: Holding<D>) {
        self.supports = holding.supports;
        self.prescribed = holding.prescribed;
        self.support_of = holding.support_of;
        self.declared.by = holding.by;
        self.declared.fading = holding.fading;
    }

    /// The supports that do not hold at all times: the name of each one's boundary or nodes, and when it holds.
    pub(in crate::model) fn switched(&self) -> impl Iterator<Item = (&str, &During)> {
        let all = self.declared.all.iter();
        all.filter_map(|own| Some((self.supported[own.name].as_str(), own.during.as_ref()?)))
    }

    /// Checks that supports that hold a component together agree, in the phases that end at `ends`: in their values, or where one of them
    /// began later, in what these have grown by since.
    ///
    /// # Errors
    /// [`Error::Conflict`].
    pub(in crate::model) fn check_agreement(&self, ends: &[f64]) -> Result<(), Error> {
        phases(ends).try_for_each(|span| self.check_agreement_in(span))
    }

    fn check_agreement_in(&self, [from, until]: [f64; 2]) -> Result<(), Error> {
        // of each dof the first support that holds it, since when, and its value
        let mut first = vec![None; self.prescribed.len()];
        let all = self.declared.all.iter();
        let holding = all.filter_map(|own| Some((own, own.since(0.5 * (from + until))?)));
        for (own, since) in holding {
            for &(dof, value) in &own.held {
                let Some((other, earlier, others)) = first[dof] else {
                    first[dof] = Some((own, since, value));
                    continue;
                };
                let since = since.max(earlier);
                let found = self.differ_in(dof, [others, value], since, [from, until]);
                if let Some((at, values)) = found {
                    let on = [other, own].map(|own| self.supported[own.name].as_str());
                    let place = (dof / D, unit_vector(dof % D));
                    return Err(self.conflict(place, on, values, at));
                }
            }
        }
        Ok(())
    }

    /// What supports that have let go still do at a load factor and the displacements U of all dofs (UL): dofs, forces (UF) and
    /// the numbers of the boundaries' names.
    pub(crate) fn fading(
        &self,
        factor: f64,
        U: &[f64],
    ) -> impl Iterator<Item = (usize, f64, usize)> {
        let fading = &self.declared.fading;
        let released = fading.released.iter();
        released.map(move |own| (own.dof, fading.force(own, factor, U[own.dof]), own.name))
    }

    /// The potential of these forces (UF·UL): what springs store, or −f·U.
    pub(in crate::model) fn potential_of_fading(&self, factor: f64, U: &[f64]) -> f64 {
        let fading = &self.declared.fading;
        let released = fading.released.iter();
        let terms = released.map(|own| {
            let (u, force) = (U[own.dof], fading.force(own, factor, U[own.dof]));
            match fading.stiffness {
                Some(_) => 0.5 * force * (own.place - u),
                None => -force * u,
            }
        });
        terms.sum()
    }

    /// Adds those that do not depend on displacements to the forces on all dofs (UF).
    pub(super) fn add_fading_forces(&self, factor: f64, forces: &mut [f64]) {
        let fading = &self.declared.fading;
        if fading.stiffness.is_none() {
            let released = fading.released.iter();
            released.for_each(|own| forces[own.dof] += fading.force(own, factor, own.place));
        }
    }

    /// The largest displacement (UL) that supports prescribe at a time, whether they hold then or not.
    pub(super) fn largest_prescribed(&self, t: f64) -> f64 {
        let largest = |m: f64, u: f64| m.max(u.abs());
        if !self.is_switched() {
            return self.prescribed_at(t).into_iter().fold(0.0, largest);
        }
        let all = self.declared.all.iter().flat_map(|own| &own.held);
        let values = all.map(|&(dof, value)| self.supports.course_at(dof, value, t));
        values.fold(0.0, largest)
    }
}
