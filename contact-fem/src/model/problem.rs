//! The contact problem of a checked scene.

pub(crate) mod answers;
mod steps;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use contact_core::equilibrium::Solution;
use contact_core::friction::SlipRows;
use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, DirectSum, Energy, Error, GapVariation, Reduction, RowKey, Scale, Separable,
    Stop,
};

use super::body::Holding;
use super::contact_set::ContactSet;
use super::kinematics::Kinematics;
use super::preflight::{self, Setup};
use super::tie::Ties;
use super::{BodyId, Finding, Geometry, InitialGaps, Scene, scale};
use crate::assembly::{BodyEnergy, Dof, DofMap};
use crate::audit::Audit;
use crate::contact::{Pass, Surface};
#[cfg(any(feature = "plot", feature = "vtk"))]
use crate::program::Pose;
use crate::tensor::Vector;

/// The contact problem of a scene at one load: energy over the free dofs of all bodies, and the
/// weak non-penetration constraints of all passes.
///
/// Nodes and dofs of the bodies follow each other in the order of the bodies.
pub struct Problem<const D: usize> {
    pub(super) scene: Scene<D>,
    pub(super) energy: DirectSum<Box<dyn BodyEnergy<D>>>,
    pub(super) kinematics: Kinematics<D>,
    pub(super) contact: ContactSet<D>,
    pub(super) ties: Ties<D>,
    /// Whether supports alone hold each body.
    pub(super) held: Vec<bool>,
    /// What held the bodies before the present phase, if something else does in it.
    pub(super) last_held: Option<Vec<Holding<D>>>,
    pub(super) scale: Scale,
    pub(super) audit: Audit<D>,
    /// [`Audit::depths`] in the reference configuration of bodies with a pair, if their overlaps are resolved or adjusted.
    overlaps_at_rest: BTreeMap<[usize; 2], [f64; 2]>,
    /// `None`: prescribed displacements are eliminated, not unknowns.
    bounds: Bounds,
    pub(super) findings: Vec<Finding>,
    /// What the last state is left with, see [`Problem::residual`].
    pub(super) residuals: Mutex<Option<Residuals>>,
}

/// ∂E/∂U of all bodies, and E, at a load factor and a state.
pub(super) struct Residuals {
    pub load: f64,
    pub u: Vec<f64>,
    pub forces: Arc<Vec<Vec<f64>>>,
    pub energy: f64,
}

impl<const D: usize> Problem<D> {
    /// # Errors
    /// Boundaries that cannot be tied.
    pub(super) fn new(mut scene: Scene<D>, geometry: Geometry) -> Result<Self, crate::Error> {
        let kinematics = Kinematics::new(scene.bodies());
        let ties = Ties::new(&scene, &kinematics)?;
        ties.preload(&mut scene, &kinematics)?;
        let energies: Vec<_> = scene.bodies().iter().map(|body| body.energy()).collect();
        let audit = Audit::new(&scene, &kinematics.X);
        let contact = ContactSet::new(&scene, scene.pairs(), geometry, &kinematics, &audit);
        let length = kinematics.diagonal();
        let lengths = (length, contact.smallest_facet(length));
        let mut overlaps_at_rest = match scene.initial_gaps {
            InitialGaps::Refuse if ties.is_empty() => BTreeMap::new(),
            _ => audit.depths(&kinematics.X),
        };
        let takes = scene.initial_gaps != InitialGaps::Refuse;
        overlaps_at_rest
            .retain(|bodies, _| takes && contact.is_pair(*bodies) || ties.join(*bodies));
        Ok(Problem {
            scale: scale::estimate(
                &scene,
                geometry,
                &energies,
                lengths,
                contact.resolved_overlap(),
            ),
            energy: DirectSum::new(energies),
            held: preflight::held(&scene),
            last_held: None,
            audit,
            overlaps_at_rest,
            scene,
            kinematics,
            contact,
            ties,
            bounds: Bounds::default(),
            findings: Vec::new(),
            residuals: Mutex::new(None),
        })
    }

    /// What the checks of a built problem need.
    pub(super) fn setup(&self) -> Setup<'_, D> {
        Setup {
            scene: &self.scene,
            pairs: self.scene.pairs(),
            kinematics: &self.kinematics,
            contact: &self.contact,
            ties: &self.ties,
            audit: &self.audit,
        }
    }

    /// The warnings and notes of the checks, see [`Scene::preflight`]; warnings come first.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The same, to tell them in other words or to add others.
    pub fn findings_mut(&mut self) -> &mut Vec<Finding> {
        &mut self.findings
    }

    /// As [`Problem::findings`], for a run in `increments` equal load increments. A step longer than the search
    /// radius is then a warning; where no step is, the finding is left out.
    pub fn findings_in(&self, increments: usize) -> Vec<Finding> {
        preflight::at_increments(&self.findings, increments)
    }

    /// The units in which the problem's numbers are O(1).
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// The scene from which the problem was built.
    pub fn scene(&self) -> &Scene<D> {
        &self.scene
    }

    /// The energies of the bodies.
    pub fn body_energies(&self) -> &[Box<dyn BodyEnergy<D>>] {
        self.energy.parts()
    }

    /// The present load factor.
    pub fn load(&self) -> f64 {
        self.kinematics.factor
    }

    /// Where contact is looked for.
    pub fn geometry(&self) -> Geometry {
        self.contact.geometry
    }

    /// Reference positions X of all nodes (UL).
    pub fn reference(&self) -> &[Vector<D>] {
        &self.kinematics.X
    }

    /// The number of the first node of a body.
    ///
    /// # Panics
    /// If the scene has no such body.
    pub fn first_node(&self, body: impl Into<BodyId>) -> usize {
        self.nodes(body).start
    }

    /// The nodes of a body.
    ///
    /// # Panics
    /// If the scene has no such body.
    pub fn nodes(&self, body: impl Into<BodyId>) -> std::ops::Range<usize> {
        self.kinematics.nodes(body.into().index())
    }

    /// Free and prescribed dofs of all bodies.
    pub fn dofs(&self) -> &DofMap {
        &self.kinematics.dofs
    }

    /// Whether `u` has one finite value for each free unknown.
    pub fn is_state(&self, u: &[f64]) -> bool {
        u.len() == self.dofs().free() && u.iter().all(|value| value.is_finite())
    }

    /// `u` or, where it is [none](Problem::is_state), unknowns that are no numbers.
    pub(super) fn state<'a>(&self, u: &'a [f64]) -> Cow<'a, [f64]> {
        match self.is_state(u) {
            true => Cow::Borrowed(u),
            false => Cow::Owned(vec![f64::NAN; self.dofs().free()]),
        }
    }

    /// The free unknowns of given displacements of all nodes (UL), which [`Problem::displacements`] gives back: a result of another
    /// program as [`LoadSteps::guess`](contact_core::LoadSteps::guess). Prescribed components are left out.
    ///
    /// # Errors
    /// Another number of nodes, or values that are not finite.
    pub fn unknowns(&self, displacements: &[Vector<D>]) -> Result<Vec<f64>, crate::Error> {
        let all: Vec<f64> = displacements.iter().flatten().copied().collect();
        contact_core::Error::check_vector("the displacements", &all, self.dofs().len())?;
        let free = all.into_iter().enumerate();
        let is_free = |dof: usize| matches!(self.dofs().get(dof), Dof::Free(_));
        Ok(free
            .filter(|(dof, _)| is_free(*dof))
            .map(|(_, u)| u)
            .collect())
    }

    /// The displacements of all nodes (UL) from the free unknowns, at the present load; NaN at free unknowns if `u` is
    /// [no state](Problem::is_state).
    pub fn displacements(&self, u: &[f64]) -> Vec<Vector<D>> {
        self.kinematics.displacements(&self.state(u))
    }

    /// The positions x = X + u of all nodes (UL), likewise.
    pub fn positions(&self, u: &[f64]) -> Vec<Vector<D>> {
        self.kinematics.positions(&self.state(u))
    }

    /// The contact surfaces.
    pub fn surfaces(&self) -> &[Arc<Surface<D>>] {
        &self.contact.surfaces
    }

    /// The passes: every pair once or in both roles, and then every side on an obstacle. Obstacles are numbered as masters
    /// after the surfaces.
    pub fn passes(&self) -> &[Pass] {
        &self.contact.passes
    }

    /// The obstacle of a pass, by its number; `None` of a pass between surfaces.
    pub fn obstacle_of(&self, pass: Pass) -> Option<usize> {
        self.contact.obstacle_of(pass).map(|(index, _)| index)
    }

    /// The obstacles that count at a load factor, with their numbers and where their motion has taken them.
    #[cfg(any(feature = "plot", feature = "vtk"))]
    pub(crate) fn obstacles_at(
        &self,
        load: f64,
    ) -> impl Iterator<Item = (usize, &crate::Obstacle<D>, Pose<D>)> {
        let all = self.scene.obstacles().iter().enumerate();
        let present = all.filter(move |(index, _)| self.scene.obstacle_counts_at(*index, load));
        present.map(move |(index, obstacle)| (index, obstacle, obstacle.pose(load)))
    }

    /// The bodies of slave and master, by their numbers; obstacles are numbered after the bodies.
    pub(crate) fn bodies_of(&self, pass: Pass) -> [usize; 2] {
        self.contact.bodies_of(pass)
    }

    /// The smallest height of a body's cells in the reference configuration, of quadratic ones that of their parts (UL), and its
    /// volume (UL², UL³; of revolution that of the half-plane).
    pub(crate) fn height_and_volume(&self, body: usize) -> [f64; 2] {
        self.audit.height_and_volume(body)
    }

    /// Whether there are passes between two bodies.
    pub(crate) fn is_pair(&self, bodies: [usize; 2]) -> bool {
        self.contact.is_pair(bodies)
    }

    /// The depth of the deepest overlap of two bodies in the reference configuration (UL).
    pub(crate) fn depth_at_rest(&self, [a, b]: [usize; 2]) -> f64 {
        let of_both = |bodies: [usize; 2]| bodies == [a, b] || bodies == [b, a];
        let overlaps = self.audit.overlaps(&self.kinematics.X).into_iter();
        let own = overlaps.filter(|overlap| of_both(overlap.bodies));
        own.map(|overlap| overlap.depth).fold(0.0, f64::max)
    }

    /// The search radius of integration points (UL).
    pub(crate) fn reach(&self) -> f64 {
        self.contact.reach
    }

    /// How deep a body starts inside other bodies, or has them inside (UL).
    pub(crate) fn deepest_fit(&self, body: usize) -> f64 {
        self.contact.deepest_fit(body)
    }

    /// The coefficient of friction of a row; 0 if there is no such pass.
    pub(crate) fn friction_of(&self, key: &RowKey) -> f64 {
        let pass = self.passes().get(key.pass as usize);
        pass.map_or(0.0, |pass| self.contact.friction(*pass))
    }

    /// Whether the pass of this number counts at the present load factor. One that there is not is missed.
    pub(crate) fn counts(&self, number: Option<usize>) -> bool {
        let pass = number.and_then(|k| self.passes().get(k));
        pass.is_none_or(|pass| self.contact.is_on(*pass))
    }

    /// The pass with exchanged roles; `None` if its master is an obstacle.
    pub(crate) fn turned(&self, pass: Pass) -> Option<Pass> {
        self.contact.turned(pass)
    }

    /// The number of nodes of slave surfaces that may have a row, over all passes.
    pub fn contact_nodes(&self) -> usize {
        self.contact.contact_nodes()
    }

    /// Whether the rows are linear by definition: a single solve suffices, without a fixed-point
    /// iteration.
    pub fn is_exact(&self) -> bool {
        self.contact.is_exact()
    }

    /// Whether a row's key identifies the same row in every iteration and load step. The numbers of
    /// integration points do not where facets are cut.
    pub fn has_lasting_names(&self, sampling: Sampling) -> bool {
        self.contact.has_lasting_names(sampling)
    }

    /// The number of times that normals and search trees of all surfaces were built: once for each
    /// state, or once in all in [`Geometry::Reference`].
    pub fn searches_built(&self) -> usize {
        self.contact.built()
    }

    /// The number of states at which penetrations were looked for.
    pub fn penetrations_searched(&self) -> usize {
        self.contact.inside_searched()
    }

    /// The passes none of whose points has been projected, since no displacement so far could close a row of them.
    pub fn unsearched_passes(&self) -> usize {
        self.contact.unsearched()
    }

    /// What is left at load factor `load` of the overlap with which two bodies of a pair started: its relative depth, and its
    /// share of the thickness. 0 if initial overlaps are refused; no bound while their pairs do not count, and where a tie moves them into each
    /// other.
    pub(crate) fn granted(&self, [a, b]: [usize; 2], load: f64) -> [f64; 2] {
        if self.contact.lets_through([a, b], load) || self.ties.jump([a, b], &self.scene) {
            return [f64::MAX; 2];
        }
        let left = match self.are_tied([a, b]) {
            true => 1.0,
            false => self.scene.initial_gaps.share_left(load),
        };
        let initial = self.overlaps_at_rest.get(&[a.min(b), a.max(b)]);
        initial.map_or([0.0; 2], |depths| depths.map(|depth| left * depth))
    }

    /// The rows c(u) = C u + c₀ with projections and normals frozen at `u`.
    ///
    /// # Errors
    /// A `u` of the wrong length or with values that are not finite.
    pub fn rows(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, crate::Error> {
        self.rows_of(self.passes(), u, sampling)
    }

    /// As [`Problem::rows`], for any passes over the problem's surfaces. Those that do not count at the present load factor have
    /// no rows.
    ///
    /// # Errors
    /// As [`Problem::rows`], and if there is no such surface.
    pub fn rows_of(
        &self,
        passes: &[Pass],
        u: &[f64],
        sampling: Sampling,
    ) -> Result<LinearGaps, crate::Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let surfaces = self.surfaces().len();
        let masters = surfaces + self.scene.obstacles().len();
        let wrong = |pass: &Pass| match (pass.slave < surfaces, pass.master < masters) {
            (true, true) => None,
            (false, _) => Some(pass.slave),
            (_, false) => Some(pass.master),
        };
        match passes.iter().find_map(wrong) {
            Some(last) => Err(crate::Error::Setting {
                name: "pass",
                value: last as f64,
                remedy: "name surfaces of this problem, numbered from 0 as in `Problem::surfaces`, or as master an obstacle after them",
            }),
            None => {
                let numbered = passes.iter().copied().enumerate();
                Ok(self.unstopped_rows(numbered, u, sampling))
            }
        }
    }

    /// The rows of numbered passes, whatever is requested meanwhile.
    fn unstopped_rows(
        &self,
        passes: impl Iterator<Item = (usize, Pass)>,
        u: &[f64],
        sampling: Sampling,
    ) -> LinearGaps {
        let rows = self
            .contact
            .rows(passes, &self.kinematics, u, sampling, None);
        // nothing stops it
        rows.unwrap_or_else(|| LinearGaps::new(self.contact.is_exact()))
    }

    /// The rows, if the signed distances that they were computed from are numbers.
    fn with_distances(&self, rows: LinearGaps, u: &[f64]) -> Result<LinearGaps, Error> {
        let obstacles = self.scene.obstacles();
        let wrong = |i: &usize| !rows.constant()[*i].is_finite();
        let mut wrong = (0..rows.len()).filter(wrong);
        let first = match obstacles.iter().any(|obstacle| obstacle.is_given()) {
            true => wrong.next(),
            false => None,
        };
        let Some(row) = first else { return Ok(rows) };
        let key = rows.keys()[row];
        let pass = self.passes().get(key.pass as usize).copied();
        match pass.and_then(|pass| self.obstacle_of(pass)) {
            Some(index) => {
                let x = self.positions(u);
                let at = match rows.sampling() {
                    Sampling::Nodes => x.get(key.node as usize),
                    Sampling::Points => None,
                };
                Err(crate::Error::ObstacleDistance {
                    obstacle: self.scene.obstacle_names()[index].clone(),
                    what: "distance",
                    value: rows.constant()[row],
                    x: at.map_or(Vec::new(), |x| x.iter().copied().collect()),
                }
                .into())
            }
            None => Ok(rows),
        }
    }

    /// The rows of both roles at u, one for each contact node, of the passes that `is_searched` tells.
    fn linearize_where(
        &self,
        u: &[f64],
        is_searched: impl Fn(Pass) -> bool,
    ) -> Result<LinearGaps, Error> {
        Error::check_vector("u", u, self.dofs().free())?;
        let stop = self.contact.stop.as_ref();
        let of = |reversed| {
            let passes = self.contact.passes_in(reversed);
            let passes = passes.filter(|(_, pass)| is_searched(*pass));
            let rows = self
                .contact
                .rows(passes, &self.kinematics, u, Sampling::Nodes, stop);
            rows.ok_or(Error::Interrupted)
        };
        self.with_distances(of(false)?.and(of(true)?), u)
    }

    /// As [`Problem::rows_of`], at a state, without passes that are open at `u` for sure.
    pub(crate) fn rows_at(&self, passes: &[Pass], u: &[f64], sampling: Sampling) -> LinearGaps {
        let moved = self.kinematics.largest(u);
        let numbered = passes.iter().copied().enumerate();
        let numbered = numbered.filter(|(_, pass)| self.contact.is_near(*pass, moved));
        self.unstopped_rows(numbered, u, sampling)
    }
}

// As `Answers` has them, whose code is compiled with this crate.
impl<const D: usize> ContactProblem for Problem<D> {
    fn energy(&self) -> &dyn Energy {
        self.answers().energy()
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn has_exact_gaps(&self) -> bool {
        self.is_exact()
    }

    fn scale(&self) -> Option<Scale> {
        Some(self.scale)
    }

    fn extent(&self) -> f64 {
        let nodes = self.kinematics.X.iter();
        nodes.fold(0.0, |most: f64, X| most.max(X.amax()))
    }

    fn prescribed_magnitude(&self) -> f64 {
        self.answers().prescribed_magnitude()
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.answers().linearize_gaps(u, sampling)
    }

    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.answers().linearize_reversed(u, sampling)
    }

    fn linearize_near(&self, u: &[f64], moved: f64) -> Result<LinearGaps, Error> {
        self.answers().linearize_near(u, moved)
    }

    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.answers().vary_gaps(u, gaps, lambda)
    }

    fn has_friction(&self) -> bool {
        self.contact.has_friction()
    }

    fn slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error> {
        self.answers().slips(u, gaps, last, from)
    }

    fn vary_slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.answers().vary_slips(u, gaps, forces)
    }

    fn separable(&self) -> Option<&dyn Separable> {
        Some(self.answers().separable())
    }

    fn reduction(&self) -> Option<Reduction> {
        self.answers().reduction()
    }

    fn watch(&mut self, stop: Option<&Stop>) {
        self.contact.stop = stop.cloned();
    }

    fn diagnose(&self, solution: &Solution) -> Option<String> {
        self.answers().diagnose(solution)
    }
}

impl<const D: usize> Separable for Problem<D> {
    fn bodies(&self) -> Vec<&dyn Energy> {
        let energies = self.energy.parts().iter();
        energies.map(|energy| energy as &dyn Energy).collect()
    }

    fn is_held(&self, b: usize) -> bool {
        self.held[b]
    }

    fn passes(&self) -> Vec<[usize; 2]> {
        let bodies = self.scene.bodies().len();
        let of_pass = |pass: &Pass| match self.bodies_of(*pass) {
            // obstacles are numbered after the bodies
            [slave, master] if master >= bodies => [slave; 2],
            both => both,
        };
        self.contact.passes.iter().map(of_pass).collect()
    }

    fn linearize_among(&self, u: &[f64], among: &[bool]) -> Result<LinearGaps, Error> {
        let is_own = |pass: &Pass| {
            let [slave, master] = self.bodies_of(*pass);
            among[slave] && among.get(master) != Some(&false)
        };
        self.linearize_where(u, |pass| is_own(&pass))
    }
}

#[cfg(test)]
mod tests {
    use contact_core::LoadStepped;

    use super::*;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::{Body, NeoHookean};

    fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Body<2> {
        let [xs, ys] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
        Body::new(mesh, NeoHookean::new(1.0, 0.3).expect("law"))
    }

    /// A block of height 4 whose top goes up by 8, at load ¾.
    fn stretched() -> Problem<2> {
        let mut body = block([0.0, 0.0], [3.0, 4.0], [3, 4]);
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        body.prescribe("top", [None, Some(8.0)]).expect("support");
        let mut scene = Scene::new();
        scene.add("block", body);
        let mut problem = scene.problem().expect("a problem");
        problem.set_load(0.75).expect("load");
        problem
    }

    /// From load ½ to ¾, the nodes of the block go up by half of their height, and nothing moves aside.
    #[test]
    fn starts_are_lifted_by_what_the_load_adds() {
        let problem = stretched();
        let u = vec![0.1; problem.dofs().free()];
        let lifted = problem.lift(&u, 0.5);
        let increments = problem.displacements(&lifted);
        for (node, X) in problem.reference().iter().enumerate() {
            for (i, expected) in [0.1, 0.1 + 0.5 * X[1]].into_iter().enumerate() {
                if let crate::assembly::Dof::Free(_) = problem.dofs().get(2 * node + i) {
                    assert!((increments[node][i] - expected).abs() < 1e-12, "{node} {i}");
                }
            }
        }
    }

    /// States of other lengths and without numbers go through nothing, and are not lifted to numbers.
    #[test]
    fn what_is_no_state() {
        let problem = stretched();
        let free = problem.dofs().free();
        let rest = vec![0.0; free];
        for u in [vec![], vec![0.0; free - 1], vec![f64::NAN; free]] {
            assert!(problem.tunnels(&u, &rest, 0.0).is_none());
            assert!(problem.tunnels(&rest, &u, 0.0).is_none());
            assert!(!problem.lift(&u, 0.0).iter().all(|value| value.is_finite()));
        }
    }

    /// A bar whose nodes are all prescribed goes through a plate from one load to the next: the way
    /// begins where the last load had it.
    #[test]
    fn ways_begin_at_the_load_of_the_last_state() {
        let mut plate = block([0.0, 0.0], [1.0, 0.1], [9, 1]);
        plate.prescribe("left", [Some(0.0); 2]).expect("support");
        let mut bar = block([0.3, 0.2], [0.4, 0.05], [2, 1]);
        bar.prescribe_all([Some(0.0), Some(-1.0)]).expect("motion");
        let mut scene = Scene::new();
        scene.add("plate", plate);
        scene.add("bar", bar);
        let mut problem = scene.problem().expect("a problem");
        let u = vec![0.0; problem.dofs().free()];
        for (load, from, passes) in [(0.6, 0.0, true), (0.9, 0.6, false), (0.05, 0.0, false)] {
            problem.set_load(load).expect("load");
            let passage = problem.tunnels(&u, &u, from);
            assert_eq!(passage.is_some(), passes, "{load} from {from}: {passage:?}");
        }
    }
}
