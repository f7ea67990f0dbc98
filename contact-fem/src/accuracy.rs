//! Meshes that are refined until the estimated error is at most what was asked.
//!
//! [`Accuracy::reach`] asks for the scene on a mesh, solves it, and marks the cells with the largest errors; the next mesh is finer there. Scenes
//! are statements about named boundaries and regions, which finer meshes keep, so that the function that makes a scene makes the finer ones, too.

use std::collections::HashSet;
use std::time::Instant;

use contact_core::equilibrium::Solution;
use contact_core::{ContactProblem, State};

use crate::error::Error;
use crate::mesh::Mesh;
use crate::model::{ErrorEstimate, Problem};
use crate::simulation::History;
use crate::tensor::Vector;

/// What is asked, and when to give up.
///
/// A square under its own weight, to a hundredth of the energy norm:
/// ```
/// # #[cfg(feature = "ipopt")]
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use contact_fem::accuracy::{Accuracy, Ended, Solved};
/// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
/// use contact_fem::{Body, LinearElastic, Scene, Simulation};
///
/// let sides = linspace(0.0, 1.0, 2);
/// let coarse = rectangle(&sides, &sides, Diagonals::Rising)?.quadratic();
/// let reached = Accuracy::of(1e-2).reach(
///     |refinement| {
///         let mesh = refinement.of("block", coarse.clone())?;
///         let mut block = Body::new(mesh, LinearElastic::new(10.0, 0.3)?);
///         block.prescribe("bottom", [Some(0.0), Some(0.0)])?;
///         block.body_force([0.0, -1.0])?;
///         let mut scene = Scene::new();
///         scene.add("block", block);
///         let mut problem = scene.problem()?;
///         let history = Simulation::with_increments(1).run(&mut problem)?;
///         Ok::<_, contact_fem::Error>(Solved { problem, history })
///     },
///     |level| println!("{level}"),
/// )?;
/// assert!(matches!(reached.ended, Ended::Reached));
/// let last = reached.levels.last().ok_or("a level")?;
/// assert!(last.estimated_error <= 1e-2 && last.unknowns < 3000);
/// # Ok(())
/// # }
/// # #[cfg(not(feature = "ipopt"))]
/// # fn main() {}
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// The largest error in the energy norm. In the plane [`ErrorEstimate::relative`] is to be at most this, in space at most 0.7 of it.
    pub asked: f64,
    /// The most levels; 30 by default.
    pub levels: usize,
    /// No level is begun that would have more unknowns; 500 000 by default.
    pub unknowns: usize,
    /// No level is begun that would end later (s after the start), judged by how the last ones grew; 600 by default. A level that takes longer than that
    /// is not ended here: give its run a [`Budget`](contact_core::Budget).
    pub seconds: f64,
    /// The marked cells have this share of the squares of all errors (W. Dörfler, A convergent adaptive algorithm for Poisson's equation, SIAM J.
    /// Numer. Anal. 33 (1996) 1106–1124); 0.8 by default.
    pub marked: f64,
}

/// One mesh of an [`Accuracy`], solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Counts from 0.
    pub number: usize,
    /// The numbers of cells and of free displacements.
    pub cells: usize,
    /// See `cells`.
    pub unknowns: usize,
    /// The time of this level, and of all so far (s).
    pub seconds: f64,
    /// See `seconds`.
    pub seconds_so_far: f64,
    /// [`ErrorEstimate::relative`], raised by the root of `raised`.
    pub estimated_error: f64,
    /// [`ErrorEstimate::energy`] (UF·UL), raised by `raised`.
    pub estimated_energy_error: f64,
    /// The largest ratio of the energy's fall since a recent level, or of its rise since the last one, to what that level's estimate said, at least 1. Recent levels
    /// are the last one, and those with a quarter of this level's unknowns or more. Energies rise as penetration becomes less. The ratio is large at strong singularities, and grows without end where a point carries a force.
    pub raised: f64,
    /// The total energy (UF·UL).
    pub energy: f64,
    /// The fewest facets in contact of a pair with a force.
    pub contact_facets_touching: Option<usize>,
    /// The number of pairs whose contact zone facets do not resolve ([`ContactFacets::is_unresolved`](crate::model::ContactFacets::is_unresolved)).
    pub unresolved_contacts: usize,
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "level {}: {} unknowns, estimated error {:.2} %, energy {:.6e} (error {:.1e}), {:.2} s, {:.2} s so far",
            self.number,
            self.unknowns,
            100.0 * self.estimated_error,
            self.energy,
            self.estimated_energy_error,
            self.seconds,
            self.seconds_so_far
        )?;
        if self.raised > TOLD {
            write!(
                f,
                ", errors raised by {:.1} since energies change by more than estimated",
                self.raised
            )?;
        }
        match self.unresolved_contacts {
            0 => Ok(()),
            1 => write!(f, ", a contact is not resolved"),
            count => write!(f, ", {count} contacts are not resolved"),
        }
    }
}

impl Level {
    /// With its errors raised by what the levels before tell, see [`Level::raised`].
    fn raised_by(self, before: &[Level]) -> Self {
        // contact that no facet saw, and round-off, tell nothing
        let fallen = |of: &Level| of.energy - self.energy;
        let (earlier, last) = before.split_at(before.len().saturating_sub(1));
        let earlier = earlier.iter().filter(|of| 4 * of.unknowns >= self.unknowns);
        let falls = earlier.map(|of| (of, fallen(of)));
        let changes = falls.chain(last.iter().map(|of| (of, fallen(of).abs())));
        let changes = changes.filter(|(of, change)| {
            of.estimated_error > 0.0 && *change > ROUND_OFF * self.energy.abs()
        });
        let ratios = changes.map(|(of, change)| change * of.raised / of.estimated_energy_error);
        let raised = ratios.fold(1.0, f64::max);
        Level {
            raised,
            estimated_error: (self.estimated_error * raised.sqrt()).clamp(0.0, 1.0),
            estimated_energy_error: self.estimated_energy_error * raised,
            ..self
        }
    }
}

/// A level takes at most so many times what the last one took, by all that is assumed: more is a hiccup of the clock.
const MOST_GROWTH: f64 = 8.0;
/// Energies that differ by less than this share of them are the same.
const ROUND_OFF: f64 = 1e-9;
/// A factor by which errors are raised that is told.
const TOLD: f64 = 1.5;
/// The first mesh has the accuracy where its estimate is at most this share of it.
const SURE: f64 = 0.3;
/// In space a mesh has the accuracy where its estimate is at most this share of it. The share was chosen on a ball on a plane, whose estimates are 0.72 to 0.77 of
/// the true errors in the energy norm. Those of a bar and of a cantilever, which were tried afterwards, are 0.75 and more.
const SURE_IN_SPACE: f64 = 0.7;

/// The number of levels over which the error must fall, and the share below which it has fallen: each level cuts the cells with most of the error. Both
/// were chosen on a beam that rests on two nodes.
const STALLED: (usize, f64) = (8, 0.95);

/// How an [`Accuracy`] ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// The last level has the accuracy.
    Reached,
    /// The last level is not complete, for this reason.
    Incomplete(String),
    /// Another level would go beyond this limit.
    Limit(&'static str),
    /// The estimate falls no more: most of it is in this body, around this place (UL). Where a support or a force acts on a point, energies have no limit.
    Stalled {
        /// The name of the body.
        body: String,
        /// The centre of the cell with the largest error.
        place: Vec<f64>,
    },
    /// Nothing is strained at the end of the run. Bodies may not touch, or facets may be so long that they miss the contact.
    Unstrained,
    /// The estimate is no number, as where a cell is inverted.
    NoEstimate,
}

/// What came out: all levels, and the last complete one, with its problem.
pub struct Refined<const D: usize> {
    /// All complete levels.
    pub levels: Vec<Level>,
    /// How it ended.
    pub ended: Ended,
    /// The last complete level; `None` if there is none.
    pub solved: Option<Solved<D>>,
}

/// A scene on one mesh, after its run.
pub struct Solved<const D: usize> {
    /// The problem, at the load at which the run ended.
    pub problem: Problem<D>,
    /// The run.
    pub history: History<D>,
}

/// Which cells of each level's mesh are cut for the next one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refinement {
    /// The names of the bodies, as the first level has them.
    names: Vec<String>,
    /// Marks by level, body and cell.
    marks: Vec<Vec<Vec<bool>>>,
    /// The displacements of the last level at the nodes of this one (UL), body by body, component by component.
    last: Vec<f64>,
}

impl Refinement {
    /// The number of the level that it makes meshes for.
    pub fn level(&self) -> usize {
        self.marks.len()
    }

    /// The state of the last level on the meshes of this one, without forces of contact: where only the end of a run counts, it is the start of a run of one
    /// increment ([`LoadSteps::guess`](contact_core::LoadSteps::guess)). `None` on level 0, and with friction, which depends on the way.
    ///
    /// # Errors
    /// A problem whose meshes are not from [`Refinement::of`]; as [`Problem::unknowns`].
    pub fn start<const D: usize>(&self, problem: &Problem<D>) -> Result<Option<State>, Error> {
        if self.marks.is_empty() || problem.has_friction() {
            return Ok(None);
        }
        let (found, expected) = (self.last.len() / D, problem.reference().len());
        contact_core::Error::check_length_of("nodes of the refined meshes", found, expected)?;
        let U = self.last.chunks_exact(D).map(Vector::from_column_slice);
        let u = problem.unknowns(&U.collect::<Vec<_>>())?;
        Ok(Some(State {
            u,
            ..State::default()
        }))
    }

    /// The mesh of a body on this level from that of level 0, refined where cells are marked.
    ///
    /// # Errors
    /// A body that the first level did not have; another mesh than that of level 0; as [`Mesh::refined`].
    pub fn of<const D: usize>(&self, body: &str, mesh: Mesh<D>) -> Result<Mesh<D>, Error> {
        self.drawn(body, mesh, Ok)
    }

    /// As [`Refinement::of`], where `draw` moves the nodes of a new mesh to where they belong, as with [`Mesh::curved`].
    ///
    /// # Errors
    /// As [`Refinement::of`], and the errors of `draw`.
    pub fn drawn<const D: usize, E: From<Error>>(
        &self,
        body: &str,
        mesh: Mesh<D>,
        draw: impl Fn(Mesh<D>) -> Result<Mesh<D>, E>,
    ) -> Result<Mesh<D>, E> {
        if self.marks.is_empty() {
            return Ok(mesh);
        }
        let index = self.names.iter().position(|name| name == body);
        let index = index.ok_or_else(|| Error::UnknownName {
            name: body.to_string(),
            known: self.names.clone(),
        })?;
        let mut mesh = mesh;
        for level in &self.marks {
            let marked = &level[index];
            if marked.contains(&true) {
                mesh = draw(mesh.refined_where(marked)?)?;
            }
        }
        Ok(mesh)
    }
}

impl Accuracy {
    /// This share of the energy norm, with the default limits.
    pub fn of(asked: f64) -> Self {
        Accuracy {
            asked,
            levels: 30,
            unknowns: 500_000,
            seconds: 600.0,
            marked: 0.8,
        }
    }

    /// # Errors
    /// A value that is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let is_share = |value: f64| value > 0.0 && value < 1.0;
        let wrong = |name, value, remedy| {
            Err(Error::Setting {
                name,
                value,
                remedy,
            })
        };
        if !is_share(self.asked) {
            return wrong("accuracy", self.asked, "ask for a share between 0 and 1");
        }
        if !is_share(self.marked) {
            return wrong("marked", self.marked, "mark a share between 0 and 1");
        }
        match self.seconds > 0.0 {
            true => Ok(()),
            false => wrong("seconds", self.seconds, "give it some time"),
        }
    }

    /// Solves level after level by `solve`, which makes the scene with the meshes of the refinement, until the estimated error is at most
    /// what is asked, or a limit is reached. `observe` sees each complete level.
    ///
    /// # Errors
    /// Settings out of range; the errors of `solve` on the first mesh. An error on a finer mesh is [`Ended::Incomplete`].
    pub fn reach<const D: usize, E: From<Error> + std::fmt::Display>(
        &self,
        mut solve: impl FnMut(&Refinement) -> Result<Solved<D>, E>,
        mut observe: impl FnMut(&Level),
    ) -> Result<Refined<D>, E> {
        self.validate()?;
        let clock = Instant::now();
        let mut refinement = Refinement::default();
        let mut found = Refined {
            levels: Vec::new(),
            ended: Ended::NoEstimate,
            solved: None,
        };
        loop {
            let before = clock.elapsed().as_secs_f64();
            let Solved { problem, history } = match solve(&refinement) {
                Err(why) if !found.levels.is_empty() => {
                    found.ended = Ended::Incomplete(why.to_string());
                    return Ok(found);
                }
                solved => solved?,
            };
            let solution = history.run.solution.as_ref();
            let Some(solution) = solution.filter(|_| history.is_complete()) else {
                found.ended = Ended::Incomplete(history.run.ending.to_string());
                return Ok(found);
            };
            let estimate = problem.error_estimate(solution)?;
            let facets = estimate.contacts.iter().filter_map(|pair| pair.touching);
            let contacts = estimate.contacts.iter();
            let unresolved = contacts.filter(|pair| pair.is_unresolved(D)).count();
            let seconds_so_far = clock.elapsed().as_secs_f64();
            let level = Level {
                number: refinement.level(),
                cells: estimate.cells.len(),
                unknowns: problem.dofs().free(),
                seconds: seconds_so_far - before,
                seconds_so_far,
                estimated_error: estimate.relative,
                estimated_energy_error: estimate.energy,
                raised: 1.0,
                energy: solution.energy,
                contact_facets_touching: facets.min(),
                unresolved_contacts: unresolved,
            };
            let level = level.raised_by(&found.levels);
            observe(&level);
            found.levels.push(level);
            let marks = marks(&problem, solution, &estimate, self.marked)?;
            let is_marked = marks.iter().flatten().any(|marked| *marked);
            let may_touch = is_marked && found.levels.len() <= UNSTRAINED;
            refinement.names = problem.scene().names().to_vec();
            found.solved = Some(Solved { problem, history });
            let earlier = found.levels.iter().filter(|of| of.unresolved_contacts > 0);
            let is_resolved = unresolved == 0 || earlier.count() > UNRESOLVED;
            let sure = if D == 3 { SURE_IN_SPACE } else { 1.0 };
            let ended = match self.limit(&found.levels) {
                _ if level.estimated_error == 0.0 && !may_touch => Some(Ended::Unstrained),
                _ if level.estimated_error == 0.0 => None,
                // the first mesh alone tells no error of its estimate
                limit if found.levels.len() == 1 && level.estimated_error > SURE * self.asked => {
                    limit.map(Ended::Limit)
                }
                _ if level.estimated_error <= sure * self.asked && is_resolved => {
                    Some(Ended::Reached)
                }
                _ if level.estimated_error.is_nan() => Some(Ended::NoEstimate),
                _ if is_stalled(&found.levels) => Some(stalled_at(&refinement.names, &estimate)),
                limit => limit.map(Ended::Limit),
            };
            if let Some(ended) = ended {
                found.ended = ended;
                return Ok(found);
            }
            if let Some(solved) = &found.solved {
                refinement.last = carried(solved, &marks)?;
            }
            refinement.marks.push(marks);
        }
    }

    /// The limit that another level would exceed, if it grew as the last one did.
    fn limit(&self, levels: &[Level]) -> Option<&'static str> {
        let (last, before) = (levels.last()?, levels.iter().rev().nth(1));
        let grown = |of: fn(&Level) -> f64| match before {
            Some(before) => of(last) * (of(last) / of(before)).clamp(1.0, MOST_GROWTH),
            None => of(last),
        };
        let (unknowns, seconds) = (grown(|of| of.unknowns as f64), grown(|of| of.seconds));
        match levels.len() >= self.levels {
            true => Some("levels"),
            false if unknowns > self.unknowns as f64 => Some("unknowns"),
            false if last.seconds_so_far + seconds > self.seconds => Some("seconds"),
            false => None,
        }
    }
}

/// Whether the error has not fallen over many levels.
fn is_stalled(levels: &[Level]) -> bool {
    let (count, share) = STALLED;
    let (Some(last), Some(before)) = (levels.last(), levels.iter().rev().nth(count)) else {
        return false;
    };
    before.estimated_error > 0.0 && last.estimated_error >= share * before.estimated_error
}

/// Where most of the error is that falls no more.
fn stalled_at<const D: usize>(names: &[String], estimate: &ErrorEstimate<D>) -> Ended {
    let bodies = estimate.bodies.iter();
    let worst = bodies.max_by(|a, b| a.energy.total_cmp(&b.energy));
    let name = worst.and_then(|of| names.get(of.body.index()));
    Ended::Stalled {
        body: name.cloned().unwrap_or_default(),
        place: worst.map_or(Vec::new(), |of| of.place.iter().copied().collect()),
    }
}

/// The displacements at the end of a run at the nodes of the next level.
fn carried<const D: usize>(
    Solved { problem, history }: &Solved<D>,
    marks: &[Vec<bool>],
) -> Result<Vec<f64>, Error> {
    let solution = history.run.solution.as_ref();
    let U = solution.map_or(Vec::new(), |solution| {
        problem.displacements(&solution.state.u)
    });
    let mut all = Vec::new();
    for (b, (body, marked)) in problem.scene().bodies().iter().zip(marks).enumerate() {
        let mut own = U[problem.nodes(b)].to_vec();
        body.mesh().refined_with(marked, &mut own)?;
        all.extend(own.iter().flat_map(|u| u.iter().copied()));
    }
    Ok(all)
}

/// The most levels without strain, on which facets are too long to see a contact.
const UNSTRAINED: usize = 8;
/// The most levels on which a contact is not resolved that do not count for that reason: where a corner touches, more facets never do.
const UNRESOLVED: usize = 8;

/// The cells to be cut, body by body: cells with the largest errors, pressed cells of bodies that do not deform, and, where facets do not resolve a contact,
/// cells with pressed nodes and with nodes inside the other surface. Where nothing is strained, cells at nodes that are closer to another surface than
/// their facets are long.
fn marks<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
    estimate: &ErrorEstimate<D>,
    share: f64,
) -> Result<Vec<Vec<bool>>, Error> {
    let mut all = estimate.marked(share).into_iter();
    let bodies = problem.scene().bodies();
    let own = bodies
        .iter()
        .map(|body| all.by_ref().take(body.mesh().len()).collect());
    let mut marks: Vec<Vec<bool>> = own.collect();
    let is_strained = marks.iter().flatten().any(|marked| *marked);
    let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
    let states = problem.pair_states(u, gaps, lambda)?;
    let unresolved = estimate.contacts.iter().map(|pair| pair.is_unresolved(D));
    let sides = states.iter().zip(unresolved);
    let sides = sides
        .flat_map(|(state, unresolved)| state.sides.iter().map(move |side| (side, unresolved)));
    for (side, is_unresolved) in sides {
        let surface = &problem.surfaces()[side.surface];
        let body = surface.body();
        let deforms = problem.body_energies()[body].assembled_cells() > 0;
        let sizes = surface.node_sizes();
        let is_near = |k: &usize| match is_strained {
            true => {
                let is_inside = side.gaps[*k].is_some_and(|gap| gap < 0.0);
                let presses = side.pressures[*k] > 0.0;
                presses && !deforms || is_unresolved && (presses || is_inside)
            }
            false => side.gaps[*k].is_some_and(|gap| gap < sizes[*k]),
        };
        let near = (0..surface.nodes().len()).filter(is_near);
        let first = problem.first_node(body);
        let near: HashSet<usize> = near.map(|k| surface.nodes()[k] - first).collect();
        for (mark, nodes) in marks[body].iter_mut().zip(bodies[body].mesh().cells()) {
            *mark |= nodes.iter().any(|node| near.contains(node));
        }
    }
    Ok(marks)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of the energy of level k is 2⁻ᵏ, of which the estimate tells this share.
    fn levels(count: usize, told: f64) -> Vec<Level> {
        let mut levels = Vec::<Level>::new();
        for number in 0..count {
            let truth = 0.5_f64.powi(number as i32);
            let level = Level {
                number,
                cells: 0,
                unknowns: 1000 + number,
                seconds: 1.0,
                seconds_so_far: 1.0 + number as f64,
                estimated_error: (told * truth / 32.0).sqrt(),
                estimated_energy_error: told * truth,
                raised: 1.0,
                energy: 16.0 + truth,
                contact_facets_touching: None,
                unresolved_contacts: 0,
            };
            levels.push(level.raised_by(&levels));
        }
        levels
    }

    #[test]
    fn estimates_that_are_too_low_are_raised_to_what_energies_show() {
        for told in [0.01, 0.1, 0.5] {
            let levels = levels(12, told);
            for (k, level) in levels.iter().enumerate().skip(1) {
                // from level 0 to level k the energy falls by 1 − 2⁻ᵏ, of the `told` that level 0 expects
                let raised = ((1.0 - 0.5_f64.powi(k as i32)) / told).max(1.0);
                assert!((level.raised / raised - 1.0).abs() < 1e-12, "{k}");
                let truth = 0.5_f64.powi(k as i32);
                let ratio = level.estimated_energy_error / truth;
                assert!((0.49..1.01).contains(&ratio), "{told} {k}: {ratio}");
            }
        }
        // estimates that are right, or too high, stay what they are
        assert!(levels(12, 1.5).iter().all(|level| level.raised == 1.0));
    }

    #[test]
    fn coarse_levels_round_off_and_unstrained_ones_tell_nothing() {
        let base = levels(2, 0.01);
        let [first, second] = [
            base[0],
            Level {
                raised: 1.0,
                ..base[1]
            },
        ];
        let raised = |first: Level, second: Level| second.raised_by(&[first]).raised;
        assert!(raised(first, second) > 10.0);
        let coarse = Level {
            unknowns: 200,
            ..first
        };
        // the last level counts, however coarse it is
        assert!(raised(coarse, second) > 10.0);
        let unstrained = Level {
            estimated_error: 0.0,
            estimated_energy_error: 1e-30,
            ..first
        };
        assert_eq!(raised(unstrained, second), 1.0);
        let same = Level {
            energy: second.energy + 1e-10,
            estimated_energy_error: 1e-14,
            ..first
        };
        assert_eq!(raised(same, second), 1.0);
        assert_eq!(second.raised_by(&[coarse, same]).raised, 1.0);
        assert!(second.raised_by(&[first, same]).raised > 10.0);
        let higher = Level {
            energy: 20.0,
            ..second
        };
        assert!(raised(first, higher) > 10.0);
        // a rise since an earlier level tells of its penetration, not of this one's
        assert_eq!(higher.raised_by(&[first, higher]).raised, 1.0);
    }

    /// An eighth of a ball on a plane in quadratic cells, and the energy norm of the difference between its displacements on each level and those on the
    /// last, finer one. Energies tell less: penetration lowers them.
    #[cfg(feature = "ipopt")]
    #[test]
    fn estimates_in_space_are_those_of_the_energy_norm() {
        use contact_core::LoadStepped;

        use crate::mesh::generators::{eighth_sphere, onto_sphere};
        use crate::{Body, LinearElastic, Obstacle, Scene, Simulation};

        let draw = |mesh: Mesh<3>| {
            let mesh = mesh.drawn("surface", onto_sphere(1.0))?;
            mesh.curved("surface", onto_sphere(1.0))
        };
        let ball = eighth_sphere(1.0, 4).map(Mesh::quadratic).and_then(draw);
        let ball = ball.expect("a ball");
        let (mut states, mut marks) = (Vec::new(), Vec::new());
        let solve = |refinement: &Refinement| -> Result<Solved<3>, Error> {
            let mut body = Body::new(
                refinement.drawn("ball", ball.clone(), draw)?,
                LinearElastic::new(1000.0, 0.3)?,
            );
            body.prescribe("left", [Some(0.0), None, None])?;
            body.prescribe("front", [None, Some(0.0), None])?;
            body.prescribe("flat", [None, None, Some(-0.04)])?;
            let mut scene = Scene::new();
            let body = scene.add("ball", body);
            let plane = Obstacle::half_space([0.0, 0.0, -1.0], [0.0, 0.0, 1.0])?;
            scene.obstacle("plane", body.on("surface"), plane)?;
            let mut problem = scene.problem()?;
            let history = Simulation::with_increments(1).run(&mut problem)?;
            let solution = history.run.solution.as_ref().expect("it converges");
            states.push(problem.displacements(&solution.state.u));
            marks = refinement.marks.clone();
            Ok(Solved { problem, history })
        };
        let reached = Accuracy::of(0.045).reach(solve, |_| {});
        let reached = reached.expect("a sound scene");
        assert_eq!(reached.ended, Ended::Reached);
        let mut last = reached.solved.expect("a level").problem;
        last.set_load(0.0).expect("no load");
        let told = |level: &Level| level.estimated_energy_error / level.raised;
        let (finest, coarser) = reached.levels.split_last().expect("levels");
        for (k, level) in coarser.iter().enumerate() {
            let (mut mesh, mut U) = (ball.clone(), states[k].clone());
            for (n, marks) in marks.iter().enumerate() {
                let finer = match n < k {
                    true => mesh.refined_where(&marks[0]),
                    false => mesh.refined_with(&marks[0], &mut U),
                };
                mesh = finer.and_then(draw).expect("sound cells");
            }
            let apart: Vec<Vector<3>> = U
                .iter()
                .zip(&states[coarser.len()])
                .map(|(a, b)| a - b)
                .collect();
            let e = last.unknowns(&apart).expect("the same at supports");
            let truth = last.energy().value(&e) + told(finest);
            let ratio = (told(level) / truth).sqrt();
            assert!((0.7..1.3).contains(&ratio), "{k}: {ratio}");
        }
        assert!(coarser.len() > 2);
    }

    #[test]
    fn errors_that_fall_no_more_are_told() {
        assert!((1..30).all(|count| !is_stalled(&levels(count, 0.3))));
        let still = |error: f64| {
            let mut all = levels(9, 0.3);
            let falling = all.iter_mut().zip(0..);
            falling.for_each(|(level, k)| level.estimated_error = error.powi(k));
            all
        };
        assert!(is_stalled(&still(1.0)) && is_stalled(&still(0.995)) && is_stalled(&still(1.1)));
        assert!(!is_stalled(&still(0.99)) && !is_stalled(&still(0.9)));
        assert!(!is_stalled(&still(1.0)[..8]));
    }

    #[test]
    fn what_is_no_number_stays_none_and_shares_stay_below_one() {
        let levels = levels(2, 0.01);
        let unknown = Level {
            estimated_error: f64::NAN,
            ..levels[1]
        };
        assert!(unknown.raised_by(&levels[..1]).estimated_error.is_nan());
        let large = Level {
            estimated_error: 0.5,
            ..levels[1]
        };
        assert_eq!(large.raised_by(&levels[..1]).estimated_error, 1.0);
    }
}
