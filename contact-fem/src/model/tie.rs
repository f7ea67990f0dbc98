//! Ties: surfaces of two bodies, with meshes of their own, that stay together.
//!
//! The displacements of one side, the slave, are eliminated: they are a mortar interpolation of those of the other one, with
//! constant coefficients (see [`contact::tie`](crate::contact::tie)). Solvers get the other displacements alone, by
//! [`contact_core::reduction`].

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

use contact_core::{Dependent, LinearMap, Reduction};

use super::kinematics::Kinematics;
use super::preflight;
use super::{BodyId, Problem, Scene, Side};
use crate::assembly::Dof;
use crate::contact::tie::Tied;
use crate::contact::{Master, Projection, Surface};
use crate::error::Error;
use crate::model::courses::Origin;
use crate::program::Amplitude;
use crate::tensor::Vector;

/// The side of a tie whose displacements follow those of the other one. It must lie on the other side as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TiedSlave {
    /// The side with the smaller facets, unless only the other one can be.
    #[default]
    Finer,
    /// The first side.
    First,
    /// The second side.
    Second,
}

/// Two boundaries of different bodies that stay together, but for a given jump j of displacements from the first to the second: in the weak
/// sense, ∫ ψ_i (u₂ − u₁ − j) = 0 over the reference configuration for the nodes i of one side.
#[derive(Clone, Debug)]
pub struct Tie {
    /// One boundary.
    pub first: Side,
    /// The other one.
    pub second: Side,
    /// Which of them follows.
    pub slave: TiedSlave,
    /// The largest distance between the boundaries in the reference configuration, as a share of the larger facet size.
    /// 0.05 by default: chords of curved boundaries are apart.
    pub tolerance: f64,
    /// The displacement of the second side relative to the first (UL), one component for each direction; none by default. Where a bolt is cut
    /// in two, it draws the halves into each other, which preloads the bolt by that shortening.
    pub jump: Vec<f64>,
    /// A force of the second side's body on the first's (UF), one component for each direction, in place of a jump; none by default. Along it the
    /// sides move against each other, as a whole, by whatever the force takes ([`TieRecord::jump`]). Across it they stay together, by whatever
    /// force that takes: [`TieRecord::force`] has the preload along its direction, and that reaction across. Where a bolt is
    /// cut in two, it preloads the bolt by that force, whatever else acts on it.
    pub preload: Vec<f64>,
    /// The course of the jump, or of the preload, in time; proportional by default.
    pub amplitude: Amplitude,
}

impl Tie {
    /// The share by which sides may be apart, see [`Tie::tolerance`].
    pub const TOLERANCE: f64 = 0.05;
    /// So much of each facet of the slave must lie on the master.
    const COVERED: f64 = 0.99;

    /// With the finer side as slave, and the default tolerance.
    pub fn new(first: Side, second: Side) -> Self {
        Tie {
            first,
            second,
            slave: TiedSlave::default(),
            tolerance: Tie::TOLERANCE,
            jump: Vec::new(),
            preload: Vec::new(),
            amplitude: Amplitude::proportional(),
        }
    }

    /// Whether its sides are moved against each other by a given way.
    pub(super) fn jumps(&self) -> bool {
        self.jump.iter().any(|part| *part != 0.0)
    }

    /// Its preload: how large it is (UF), and a vector of length 1 along it; `None` without one.
    pub(super) fn drawn<const D: usize>(&self) -> Option<(f64, Vector<D>)> {
        let force = Vector::<D>::from_fn(|i, _| self.preload.get(i).copied().unwrap_or(0.0));
        // without the squares of large or small numbers
        let largest = force.amax();
        let norm = largest * (force / largest).norm();
        (norm > 0.0).then(|| (norm, force / norm))
    }

    /// Whether its sides move against each other.
    fn moves(&self) -> bool {
        self.jumps() || self.preload.iter().any(|part| *part != 0.0)
    }

    /// The factor of the jump at a load factor; before the first step nothing is displaced.
    pub(super) fn factor(&self, load: f64) -> f64 {
        match load == 0.0 {
            true => 0.0,
            false => self.amplitude.at(load),
        }
    }

    /// Whether these are its sides.
    pub(super) fn is_between(&self, first: &Side, second: &Side) -> bool {
        [&self.first, &self.second] == [first, second]
            || [&self.second, &self.first] == [first, second]
    }
}

/// Why two boundaries cannot be tied.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TieFault {
    /// Both belong to one body.
    OneBody,
    /// They are a contact pair, too.
    Contact,
    /// They were tied before.
    Twice,
    /// A support along a direction holds one of their bodies.
    Inclined,
    /// One of their bodies is rigid.
    Rigid,
    /// Nothing of the slave can move along a preload.
    Immovable,
    /// Their bodies are of revolution.
    Revolution,
    /// A support of one of their bodies does not hold in all phases.
    Switched,
    /// They are too far apart.
    Apart {
        /// A point of one side (UL).
        x: Vec<f64>,
        /// Its distance from the other one (UL).
        distance: f64,
        /// The largest that is accepted (UL).
        limit: f64,
    },
    /// A facet of one side does not lie on the other one.
    Uncovered {
        /// Its centre (UL).
        x: Vec<f64>,
        /// The share of it that does.
        share: f64,
    },
    /// All nodes of a facet of the slave, and those around it, are prescribed, or belong to other ties.
    Held {
        /// Its centre (UL).
        x: Vec<f64>,
    },
}

impl fmt::Display for TieFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TieFault::OneBody => {
                f.write_str("they belong to one body: tie boundaries of two bodies")
            }
            TieFault::Contact => f.write_str(
                "they are a contact pair, too: tied boundaries do not part, leave out the pair",
            ),
            TieFault::Twice => f.write_str("they are tied already: leave out one of the ties"),
            TieFault::Inclined => f.write_str(
                "a support along a direction holds one of the bodies, which ties do not know: turn the scene so that it is along \
                 an axis, or let contact take the place of the tie",
            ),
            TieFault::Immovable => f.write_str(
                "all that could move along the preload is prescribed or belongs to other ties: leave out what prescribes it, or take a jump",
            ),
            TieFault::Rigid => f.write_str(
                "one of the bodies is rigid, which ties do not know: give it a stiff law, or let contact take the place of the tie",
            ),
            TieFault::Revolution => f.write_str(
                "their bodies are of revolution, whose rings have no ties: mesh them as one body with `of_revolution_with_laws`",
            ),
            TieFault::Switched => f.write_str(
                "a support of one of the bodies does not hold in all phases, which ties do not know: let it hold in all, or let \
                 contact take the place of the tie",
            ),
            TieFault::Apart { x, distance, limit } => write!(
                f,
                "they are {distance:.3e} apart at {x:?} against the {limit:.3e} that is granted: move the bodies to each \
                 other, refine curved boundaries, or raise `Tie::tolerance`"
            ),
            TieFault::Uncovered { x, share } => write!(
                f,
                "only {share:.3} of the slave's facet at {x:?} has a counterpart: let the other side be the slave, or \
                 divide the boundary so that one side lies on the other as a whole"
            ),
            TieFault::Held { x } => write!(
                f,
                "all nodes of the slave's facet at {x:?} and around it are prescribed or belong to other ties, so that nothing \
                 is left to follow: let the other side be the slave, refine the mesh there, or leave out what prescribes them"
            ),
        }
    }
}

/// A dof that follows others: Σ c u of the dofs of all bodies.
pub(super) struct Follower {
    pub dof: usize,
    pub terms: Vec<(usize, f64)>,
    /// What is added to them where the tie's jump has the factor 1 (UL).
    pub jump: f64,
}

/// The dof of a slave that does not follow, so that its side may move along a preload. Its motion tells how far the side has moved: the jump is
/// (u − Σ c u)/share.
struct Released {
    dof: usize,
    /// What it would follow, and how much it would move by itself with a jump of 1.
    terms: Vec<(usize, f64)>,
    share: f64,
}

impl Released {
    /// The dofs by which the jump is measured, with their coefficients.
    fn measure(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let own = std::iter::once((self.dof, 1.0 / self.share));
        own.chain(self.terms.iter().map(|(dof, c)| (*dof, -c / self.share)))
    }

    /// The jump for displacements of all dofs (UL).
    fn jump(&self, u: impl Fn(usize) -> f64) -> f64 {
        self.measure().map(|(dof, c)| c * u(dof)).sum()
    }
}

/// Lets all followers whose jump is not 0 follow one of them instead, the one that moves most with the jump.
fn release(followers: &mut Vec<Follower>) -> Option<Released> {
    let moves = followers.iter().map(|own| own.jump.abs());
    let most = moves.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let (place, _) = most.filter(|(_, share)| *share > 0.0)?;
    let Follower { dof, terms, jump } = followers.remove(place);
    let released = Released {
        dof,
        terms,
        share: jump,
    };
    for own in followers.iter_mut().filter(|own| own.jump != 0.0) {
        let share = own.jump / released.share;
        let mut terms: BTreeMap<usize, f64> = BTreeMap::from([(dof, share)]);
        let less = released.terms.iter().map(|(other, c)| (other, -share * c));
        for (other, c) in own.terms.iter().map(|(other, c)| (other, *c)).chain(less) {
            *terms.entry(*other).or_insert(0.0) += c;
        }
        terms.retain(|_, c| *c != 0.0);
        (own.terms, own.jump) = (terms.into_iter().collect(), 0.0);
    }
    Some(released)
}

/// A tie with its interpolation.
struct Built<const D: usize> {
    /// The bodies of its first and its second side.
    bodies: [usize; 2],
    /// Whether the first side follows.
    is_first_slave: bool,
    followers: Vec<Follower>,
    /// Of a tie with a preload.
    released: Option<Released>,
    /// The number of the tie in the scene.
    number: usize,
    /// The largest distance between the sides (UL), and where.
    apart: (f64, Vector<D>),
    /// The larger facet size (UL).
    size: f64,
}

/// How far the sides of a tie are apart in the reference configuration.
pub(super) struct Apart<const D: usize> {
    pub bodies: [usize; 2],
    /// The largest distance, and where (UL).
    pub distance: f64,
    pub at: Vector<D>,
    /// The larger facet size (UL).
    pub size: f64,
}

/// What a tie transmits.
#[derive(Clone, Debug, PartialEq)]
pub struct TieRecord<const D: usize> {
    /// One boundary.
    pub first: Side,
    /// The other one.
    pub second: Side,
    /// The resultant of the forces of the second side's body on the first side's (UF).
    pub force: Vector<D>,
    /// How far the second side has moved relative to the first (UL): by the given jump, or by the preload.
    pub jump: Vector<D>,
}

/// What a dependent unknown has besides the unknowns that it follows.
struct Constant {
    /// (prescribed dof, coefficient).
    terms: Vec<(usize, f64)>,
    tie: usize,
    jump: f64,
}

/// All ties of a scene.
pub(super) struct Ties<const D: usize> {
    ties: Vec<Built<D>>,
    map: Option<Arc<LinearMap>>,
    /// (prescribed dof, coefficient) of each dependent unknown, and its jump with the number of its tie.
    prescribed: Vec<Constant>,
    held: Vec<bool>,
}

impl<const D: usize> Default for Ties<D> {
    fn default() -> Self {
        Ties {
            ties: Vec::new(),
            map: None,
            prescribed: Vec::new(),
            held: Vec::new(),
        }
    }
}

impl<const D: usize> Ties<D> {
    /// # Errors
    /// The first tie that cannot be, see [`TieFault`].
    pub fn new(scene: &Scene<D>, kinematics: &Kinematics<D>) -> Result<Self, Error> {
        if scene.ties().is_empty() {
            return Ok(Ties::default());
        }
        let surfaces: Vec<[Arc<Surface<D>>; 2]> = scene
            .ties()
            .iter()
            .map(|tie| [&tie.first, &tie.second].map(|side| surface(scene, kinematics, side)))
            .collect();
        let mut ties = Vec::new();
        for (k, tie) in scene.ties().iter().enumerate() {
            for side in [&tie.first, &tie.second] {
                let body = &scene.bodies()[side.body.index()];
                if body.is_switched() {
                    return Err(fault_of(scene, tie, TieFault::Switched));
                }
                if body.mesh().is_of_revolution() {
                    return Err(fault_of(scene, tie, TieFault::Revolution));
                }
                if body.is_rigid() {
                    return Err(fault_of(scene, tie, TieFault::Rigid));
                }
                if !body.ties().is_empty() {
                    return Err(fault_of(scene, tie, TieFault::Inclined));
                }
            }
            let [a, b] = &surfaces[k];
            let is_first_finer = a.facet_size() < b.facet_size();
            let orders: &[bool] = match (tie.slave, is_first_finer) {
                (TiedSlave::First, _) => &[true],
                (TiedSlave::Second, _) => &[false],
                (TiedSlave::Finer, true) => &[true, false],
                (TiedSlave::Finer, false) => &[false, true],
            };
            let others = surfaces.iter().enumerate().filter(|(other, _)| *other != k);
            let others = others.flat_map(|(_, both)| both.iter().flat_map(|s| s.nodes()));
            let others: BTreeSet<usize> = others.copied().collect();
            let mut first = None;
            let mut found = None;
            for &is_first_slave in orders {
                match built((k, tie), [a, b], is_first_slave, kinematics, &others) {
                    Ok(tie) => {
                        found = Some(tie);
                        break;
                    }
                    Err(fault) => {
                        first.get_or_insert(fault);
                    }
                }
            }
            match (found, first) {
                (Some(tie), _) => ties.push(tie),
                (None, Some(fault)) => return Err(fault_of(scene, tie, fault)),
                (None, None) => {}
            }
        }
        let dofs = &kinematics.dofs;
        let (mut dependents, mut prescribed) = (Vec::new(), Vec::new());
        let followers = ties
            .iter()
            .flat_map(|tie| tie.followers.iter().map(move |own| (tie, own)));
        for (tie, follower) in followers {
            let Dof::Free(unknown) = dofs.get(follower.dof) else {
                continue;
            };
            let (mut terms, mut held) = (Vec::new(), Vec::new());
            for &(dof, c) in &follower.terms {
                match dofs.get(dof) {
                    Dof::Free(j) => terms.push((j, c)),
                    Dof::Prescribed(j) => held.push((j, c)),
                }
            }
            dependents.push(Dependent { unknown, terms });
            prescribed.push(Constant {
                terms: held,
                tie: tie.number,
                jump: follower.jump,
            });
        }
        let free = |id: BodyId| {
            let nodes = kinematics.nodes(id.index());
            let own = D * nodes.start..D * nodes.end;
            own.filter(|&dof| matches!(dofs.get(dof), Dof::Free(_)))
                .count()
        };
        let parts: Vec<usize> = scene.ids().map(free).collect();
        let map = LinearMap::new(&parts, &dependents)?;
        let held = preflight::held(scene);
        // along a preload, one half of a bolt is held by the other no more
        let is_drawn = |b: usize| {
            let drawn = ties.iter().filter(|tie| tie.released.is_some());
            drawn.flat_map(|tie| tie.bodies).any(|body| body == b)
        };
        Ok(Ties {
            held: map
                .groups()
                .map(|bodies| bodies.iter().all(|&b| held[b] && !is_drawn(b)))
                .collect(),
            ties,
            prescribed,
            map: Some(Arc::new(map)),
        })
    }

    /// The reduction at these prescribed displacements (UL), with the jumps of the scene's ties at a load factor.
    pub fn reduction(
        &self,
        prescribed: &[f64],
        (scene, load): (&Scene<D>, f64),
    ) -> Option<Reduction> {
        let map = Arc::clone(self.map.as_ref()?);
        let factors: Vec<f64> = scene.ties().iter().map(|tie| tie.factor(load)).collect();
        let constant = |own: &Constant| {
            let held = own.terms.iter().map(|(j, c)| c * prescribed[*j]);
            held.sum::<f64>() + factors[own.tie] * own.jump
        };
        Some(Reduction {
            map,
            constants: self.prescribed.iter().map(constant).collect(),
            held: self.held.clone(),
        })
    }

    pub fn is_empty(&self) -> bool {
        self.ties.is_empty()
    }

    /// Whether a tie joins these bodies.
    pub fn join(&self, [a, b]: [usize; 2]) -> bool {
        let is_own = |tie: &Built<D>| tie.bodies == [a, b] || tie.bodies == [b, a];
        self.ties.iter().any(is_own)
    }

    /// Adds the preloads of all ties to the loads of their bodies: forces on the dofs by which their jumps are measured.
    pub fn preload(&self, scene: &mut Scene<D>, kinematics: &Kinematics<D>) -> Result<(), Error> {
        for tie in &self.ties {
            let own = scene.ties()[tie.number].clone();
            let (Some(released), Some((force, _))) = (&tie.released, own.drawn::<D>()) else {
                continue;
            };
            let sides = [&own.first, &own.second];
            let mut of_sides =
                sides.map(|side| vec![0.0; D * kinematics.nodes(side.body.index()).len()]);
            for (dof, c) in released.measure() {
                let is_second = usize::from(kinematics.nodes(tie.bodies[1]).contains(&(dof / D)));
                let first = D * kinematics.nodes(tie.bodies[is_second]).start;
                of_sides[is_second][dof - first] -= force * c;
            }
            for (side, forces) in sides.into_iter().zip(of_sides) {
                let body = &mut scene.bodies_mut()[side.body.index()];
                let origin = Origin::Preload(side.boundary.clone());
                body.add_forces(origin, forces, own.amplitude.clone())?;
            }
        }
        Ok(())
    }

    /// How far the second side of each tie has moved relative to the first, for displacements of all dofs (UL).
    fn jumps(&self, (scene, load): (&Scene<D>, f64), u: impl Fn(usize) -> f64) -> Vec<Vector<D>> {
        let of_tie = |tie: &Built<D>| {
            let own = &scene.ties()[tie.number];
            match (&tie.released, own.drawn::<D>()) {
                (Some(released), Some((_, along))) => along * released.jump(&u),
                _ => {
                    let given = |i: usize| own.jump.get(i).copied().unwrap_or(0.0);
                    Vector::from_fn(|i, _| given(i) * own.factor(load))
                }
            }
        };
        self.ties.iter().map(of_tie).collect()
    }

    /// Whether a tie joins these bodies whose sides are moved against each other.
    pub fn jump(&self, [a, b]: [usize; 2], scene: &Scene<D>) -> bool {
        let is_own = |tie: &&Built<D>| tie.bodies == [a, b] || tie.bodies == [b, a];
        self.ties
            .iter()
            .filter(is_own)
            .any(|tie| scene.ties()[tie.number].moves())
    }

    /// How far the sides of each tie are apart.
    pub fn apart(&self) -> impl Iterator<Item = Apart<D>> + '_ {
        self.ties.iter().map(|tie| Apart {
            bodies: tie.bodies,
            distance: tie.apart.0,
            at: tie.apart.1,
            size: tie.size,
        })
    }

    /// The bodies, those that follow after those that they follow where ties do not go round; and for each the dofs that
    /// follow, with the number of their tie.
    pub fn in_order(&self, bodies: usize) -> Vec<(usize, Vec<(usize, &Follower)>)> {
        let mut masters = vec![BTreeSet::new(); bodies];
        for tie in &self.ties {
            let [master, slave] = match tie.is_first_slave {
                true => [tie.bodies[1], tie.bodies[0]],
                false => tie.bodies,
            };
            masters[slave].insert(master);
        }
        let mut order = Vec::new();
        let mut left: BTreeSet<usize> = (0..bodies).collect();
        while let Some(&any) = left.first() {
            let is_ready = |b: &&usize| masters[**b].iter().all(|master| !left.contains(master));
            let next = left.iter().find(is_ready).copied().unwrap_or(any);
            left.remove(&next);
            let own = self
                .ties
                .iter()
                .filter(|tie| tie.bodies[usize::from(!tie.is_first_slave)] == next);
            let own = own.flat_map(|tie| tie.followers.iter().map(|own| (tie.number, own)));
            order.push((next, own.collect()));
        }
        order
    }

    /// The forces of ties on all nodes (UF), where `rest` tells ∂E/∂U − Cᵀλ of a dof.
    fn forces(&self, rest: impl Fn(usize) -> f64, forces: &mut [Vector<D>]) {
        for follower in self.ties.iter().flat_map(|tie| &tie.followers) {
            let force = rest(follower.dof);
            forces[follower.dof / D][follower.dof % D] += force;
            for (dof, c) in &follower.terms {
                forces[dof / D][dof % D] -= c * force;
            }
        }
    }

    /// The work conjugates of the jumps: for each tie that has one the forces (UF), where `rest` tells ∂E/∂U − Cᵀλ of a dof, along the jumps at
    /// the factor 1 (UF·UL).
    pub fn along_jumps(&self, scene: &Scene<D>, rest: impl Fn(usize) -> f64) -> Vec<(usize, f64)> {
        let jumping = self
            .ties
            .iter()
            .filter(|tie| scene.ties()[tie.number].jumps());
        let along = |tie: &Built<D>| {
            let followers = tie.followers.iter();
            let sum = followers.map(|own| own.jump * rest(own.dof)).sum();
            (tie.number, sum)
        };
        jumping.map(along).collect()
    }

    /// The resultant of each tie on its first side (UF), likewise, with its preload at the load factor.
    fn resultants(
        &self,
        (scene, load): (&Scene<D>, f64),
        rest: impl Fn(usize) -> f64,
        nodes: impl Fn(usize) -> std::ops::Range<usize>,
    ) -> Vec<Vector<D>> {
        let of_tie = |tie: &Built<D>| {
            let declared = &scene.ties()[tie.number];
            let drawn = declared.drawn::<D>();
            let mut sum = Vector::<D>::zeros();
            if let (Some(released), Some((force, _))) = (&tie.released, drawn) {
                let first = nodes(tie.bodies[0]);
                let of_first = released
                    .measure()
                    .filter(|(dof, _)| first.contains(&(dof / D)));
                for (dof, c) in of_first {
                    sum[dof % D] -= force * declared.factor(load) * c;
                }
            }
            let (slave, sign) = match tie.is_first_slave {
                true => (tie.bodies[0], 1.0),
                false => (tie.bodies[1], -1.0),
            };
            let own = nodes(slave);
            for follower in &tie.followers {
                let force = rest(follower.dof);
                let terms = follower.terms.iter();
                for (dof, c) in terms.filter(|(dof, _)| !own.contains(&(dof / D))) {
                    sum[dof % D] += sign * c * force;
                }
            }
            sum
        };
        self.ties.iter().map(of_tie).collect()
    }
}

impl<const D: usize> Problem<D> {
    /// The forces of ties on all nodes (UF), with which the bodies are in equilibrium at `u` under these contact forces;
    /// `None` without ties.
    pub fn tie_forces(&self, u: &[f64], contact_forces: &[Vector<D>]) -> Option<Vec<Vector<D>>> {
        if self.ties.is_empty() || contact_forces.len() != self.reference().len() {
            return None;
        }
        let residuals = self.residuals(u).concat();
        let mut forces = vec![Vector::zeros(); self.reference().len()];
        let rest = |dof: usize| residuals[dof] - contact_forces[dof / D][dof % D];
        self.ties.forces(rest, &mut forces);
        Some(forces)
    }

    /// Contact forces with those of ties.
    pub(crate) fn with_tie_forces<'a>(
        &self,
        u: &[f64],
        contact_forces: &'a [Vector<D>],
    ) -> std::borrow::Cow<'a, [Vector<D>]> {
        match self.tie_forces(u, contact_forces) {
            None => contact_forces.into(),
            Some(own) => {
                let both = own.iter().zip(contact_forces);
                both.map(|(tie, contact)| tie + contact).collect()
            }
        }
    }

    /// What each tie transmits at `u` under these contact forces, in the order of declaration.
    pub fn tie_records(&self, u: &[f64], contact_forces: &[Vector<D>]) -> Vec<TieRecord<D>> {
        if self.ties.is_empty() || contact_forces.len() != self.reference().len() {
            return Vec::new();
        }
        let residuals = self.residuals(u).concat();
        let rest = |dof: usize| residuals[dof] - contact_forces[dof / D][dof % D];
        let at = (&self.scene, self.load());
        let forces = self
            .ties
            .resultants(at, rest, |body| self.kinematics.nodes(body));
        let U = self.displacements(u);
        let jumps = self.ties.jumps(at, |dof| U[dof / D][dof % D]);
        let named = self.scene.ties().iter().zip(forces.into_iter().zip(jumps));
        named
            .map(|(tie, (force, jump))| TieRecord {
                first: tie.first.clone(),
                second: tie.second.clone(),
                force,
                jump,
            })
            .collect()
    }

    /// Whether a tie joins these bodies.
    pub(crate) fn are_tied(&self, bodies: [usize; 2]) -> bool {
        self.ties.join(bodies)
    }
}

fn fault_of<const D: usize>(scene: &Scene<D>, tie: &Tie, why: TieFault) -> Error {
    Error::Tie {
        first: scene.name_of_side(&tie.first),
        second: scene.name_of_side(&tie.second),
        why,
    }
}

/// Checks what can be told of ties without surfaces.
pub(super) fn check<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    for (k, tie) in scene.ties().iter().enumerate() {
        let is_same = |other: &Tie| other.is_between(&tie.first, &tie.second);
        let is_pair = |pair: &super::Pair| tie.is_between(&pair.first, &pair.second);
        let fault = match () {
            () if tie.first.body == tie.second.body => TieFault::OneBody,
            () if scene.ties()[..k].iter().any(is_same) => TieFault::Twice,
            () if scene.pairs().iter().any(is_pair) => TieFault::Contact,
            () => continue,
        };
        return Err(fault_of(scene, tie, fault));
    }
    Ok(())
}

fn surface<const D: usize>(
    scene: &Scene<D>,
    kinematics: &Kinematics<D>,
    side: &Side,
) -> Arc<Surface<D>> {
    let body = side.body.index();
    let mesh = scene.bodies()[body].mesh();
    let first = kinematics.nodes(body).start;
    // the side was checked when the tie was declared
    let facets = mesh.boundary(&side.boundary).unwrap_or_default();
    let facets = facets.into_iter();
    let facets: Vec<Vec<usize>> = facets
        .map(|nodes| nodes.iter().map(|a| a + first).collect())
        .collect();
    let facets = facets.iter().map(Vec::as_slice);
    Arc::new(Surface::new(body, mesh.order(), facets, &kinematics.X))
}

fn built<const D: usize>(
    (number, tie): (usize, &Tie),
    [first, second]: [&Arc<Surface<D>>; 2],
    is_first_slave: bool,
    kinematics: &Kinematics<D>,
    others: &BTreeSet<usize>,
) -> Result<Built<D>, TieFault> {
    let [slave, master] = match is_first_slave {
        true => [first, second],
        false => [second, first],
    };
    let size = slave.facet_size().max(master.facet_size());
    let master = Master::new(master, &kinematics.X, Projection::Closest);
    let limit = tie.tolerance * size;
    let tied = Tied::new(slave, &master, size.max(limit));
    let place = |x: &Vector<D>| x.iter().copied().collect();
    let (distance, x) = tied.apart;
    if distance > limit {
        return Err(TieFault::Apart {
            x: place(&x),
            distance,
            limit,
        });
    }
    let (share, x) = tied.covered;
    if !(share >= Tie::COVERED) {
        return Err(TieFault::Uncovered {
            x: place(&x),
            share,
        });
    }
    let dofs = &kinematics.dofs;
    let drawn = tie.drawn::<D>();
    let mut followers = Vec::new();
    let mut known: BTreeMap<Vec<bool>, Vec<crate::contact::tie::Interpolated>> = BTreeMap::new();
    for i in 0..D {
        let is_out = |node: usize| {
            others.contains(&node) || matches!(dofs.get(D * node + i), Dof::Prescribed(_))
        };
        let out: Vec<bool> = slave.nodes().iter().map(|&node| is_out(node)).collect();
        if !known.contains_key(&out) {
            let own = tied.interpolation(is_out);
            let own = own.map_err(|x| TieFault::Held { x: place(&x) })?;
            known.insert(out.clone(), own);
        }
        let part = match &drawn {
            Some((_, along)) => along[i],
            None => tie.jump.get(i).copied().unwrap_or(0.0),
        };
        let jump = if is_first_slave { -part } else { part };
        followers.extend(known[&out].iter().map(|own| {
            let of_master = own
                .terms
                .iter()
                .filter(|(node, _)| !slave.nodes().contains(node));
            let share: f64 = of_master.map(|(_, c)| c).sum();
            Follower {
                dof: D * own.node + i,
                terms: own
                    .terms
                    .iter()
                    .map(|&(node, c)| (D * node + i, c))
                    .collect(),
                jump: share * jump,
            }
        }));
    }
    let released = match drawn {
        Some(_) => Some(release(&mut followers).ok_or(TieFault::Immovable)?),
        None => None,
    };
    Ok(Built {
        bodies: [first.body(), second.body()],
        is_first_slave,
        followers,
        released,
        number,
        apart: tied.apart,
        size,
    })
}
