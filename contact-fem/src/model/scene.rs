//! Scenes: named bodies and contact pairs.

use contact_core::memory;

use super::contact_set::ContactSet;
use super::kinematics::Kinematics;
use super::preflight::{self, Report, Setup};
use super::switches::{During, Switched};
use super::tie::{Tie, Ties};
use super::{
    Body, BodyId, Corners, Finding, InitialGaps, Integration, Obstacle, ObstacleId, Problem,
    Projection, Side,
};
use crate::audit::Audit;
use crate::element::Order;
use crate::error::Error;
use crate::instances::instance;
use crate::tensor::Vector;

/// The roles of the two surfaces of a contact pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Passes {
    /// Two passes, each surface once slave and once master: the symmetric form (5).
    #[default]
    Both,
    /// One pass with the first surface as slave, form (4); for comparison with the symmetric form.
    FirstIsSlave,
    /// One pass with the second surface as slave.
    SecondIsSlave,
}

/// What happens to a load step in [`Geometry::Current`] at whose end bodies are deep inside each
/// other or themselves, deeper than [`Overlap::LIMIT`](crate::audit::Overlap::LIMIT). The certificate
/// of such a state does not hold in either case. What is left of an overlap that [`InitialGaps`] takes is not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlaps {
    /// It is rejected and cut back, whether the surfaces are declared for contact or not.
    #[default]
    Refused,
    /// It is accepted unless the surfaces are declared, as for bodies that are meant to pass through each other.
    Allowed,
}

/// The positions at which contact is searched and the constraints are linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// The reference positions X: normals, closest points and integration points are fixed, the
    /// constraints are linear, and a single solve replaces the fixed-point iteration. It requires,
    /// with any law, displacements and rotations that are small against the facets.
    Reference,
    /// The current positions x = X + u, by the fixed-point iteration. The energy of a small-strain
    /// law is not invariant under rotations: bodies with such a law may move far, but should
    /// stretch and rotate little.
    Current,
}

/// Two surfaces that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// One surface.
    pub first: Side,
    /// The other one.
    pub second: Side,
    /// The roles.
    pub passes: Passes,
    /// The distance that the surfaces keep, such as the thickness of a coating or a sheet between them (UL).
    pub offset: f64,
    /// The coefficient of friction μ.
    pub friction: f64,
}

/// Bodies, contact pairs and obstacles; [`Scene::problem`] checks them and builds the contact problem.
///
/// ```
/// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
/// use contact_fem::{Body, LinearElastic, Scene};
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let block = |y| rectangle(&linspace(0.0, 1.0, 4), &linspace(y, y + 1.0, 4), Diagonals::Rising);
/// let mut lower = Body::new(block(0.0)?, LinearElastic::new(210.0, 0.0)?);
/// lower.prescribe("bottom", [Some(0.0), Some(0.0)])?;
/// let mut upper = Body::new(block(1.0)?, LinearElastic::new(210.0, 0.0)?);
/// upper.prescribe("top", [Some(0.0), Some(-0.01)])?;
///
/// let mut scene = Scene::new();
/// let lower = scene.add("lower block", lower);
/// let upper = scene.add("upper block", upper);
/// scene.contact(lower.on("top"), upper.on("bottom"))?;
/// let mut problem = scene.problem()?;
///
/// # #[cfg(feature = "ipopt")]
/// # {
/// let history = contact_fem::Simulation::with_increments(1).run(&mut problem)?;
/// let step = &history.steps[0];
/// // E times the strain, on a width of 1; what holds one block pushes the other
/// assert!((step.reaction(lower)[1] - 210.0 * 0.01 / 2.0).abs() < 1e-5);
/// assert!((step.reaction(lower) + step.reaction(upper)).norm() < 1e-9);
/// # }
/// # Ok(())
/// # }
/// ```
///
/// A clone is a scene of its own: studies change a clone by [`Scene::body_mut`] and run it.
#[derive(Clone)]
pub struct Scene<const D: usize> {
    bodies: Vec<Body<D>>,
    names: Vec<String>,
    pairs: Vec<Pair>,
    surfaces: Vec<Side>,
    ties: Vec<Tie>,
    obstacles: Vec<Obstacle<D>>,
    obstacle_names: Vec<String>,
    /// The sides that an obstacle may hold, with the number of the obstacle.
    obstructed: Vec<(Side, usize)>,
    /// The coefficient of friction of each obstacle.
    obstacle_frictions: Vec<f64>,
    /// The pairs and obstacles that do not count at all times.
    switched: Vec<(Switched, During)>,
    /// The quadrature of the constraints. By default [`Integration::Exact`] in the plane, and in space 4 Gauss points for each
    /// facet and direction; with quadratic elements, whose pressures are more sensitive to quadrature errors, 8. Gauss points do
    /// not resolve the edges of the facets of the other
    /// surface: in flat contact of non-matching meshes the error is about 0.1 % of the stress, with
    /// one pass more. [`Integration::Exact`] resolves them. Obstacles have no facets: on them, it means Gauss points, 4 with linear
    /// elements, and with quadratic ones 12 in the plane and 8 in space.
    pub integration: Option<Integration>,
    /// Where the points of one surface have their feet on the other. [`Projection::AlongNormals`] by default.
    pub projection: Projection,
    /// The positions at which contact is searched. By default [`Geometry::Reference`] if all laws
    /// are small-strain laws, else [`Geometry::Current`]. If bodies with laws of both kinds are in
    /// contact pairs, it must be set.
    pub geometry: Option<Geometry>,
    /// The search radius of an integration point (UL). By default a tenth of the scene's diagonal,
    /// and the whole diagonal in [`Geometry::Reference`], where the positions do not change. A
    /// point without another surface in its search radius does not count; a row without a point
    /// that counts is left out.
    pub reach: Option<f64>,
    /// The largest overlap of bodies in the reference configuration that is accepted where
    /// [`Scene::initial_gaps`] refuses overlaps, as a share of the facet size: polygons of touching curves
    /// overlap slightly. 0.05 by default.
    pub overlap_tolerance: f64,
    /// Whether sharp corners and edges have rows of their own. [`Corners::AsNeeded`] by default.
    pub corners: Corners,
    /// What becomes of contact surfaces that overlap in the reference configuration.
    pub initial_gaps: InitialGaps,
    /// What happens to a load step at whose end bodies are deep inside each other or themselves.
    pub overlaps: Overlaps,
}

impl<const D: usize> Default for Scene<D> {
    fn default() -> Self {
        Scene {
            bodies: Vec::new(),
            names: Vec::new(),
            pairs: Vec::new(),
            surfaces: Vec::new(),
            ties: Vec::new(),
            obstacles: Vec::new(),
            obstacle_names: Vec::new(),
            obstructed: Vec::new(),
            obstacle_frictions: Vec::new(),
            switched: Vec::new(),
            integration: None,
            projection: Projection::default(),
            geometry: None,
            reach: None,
            overlap_tolerance: 0.05,
            corners: Corners::default(),
            initial_gaps: InitialGaps::default(),
            overlaps: Overlaps::default(),
        }
    }
}

impl<const D: usize> Scene<D> {
    /// A scene without bodies.
    pub fn new() -> Self {
        Self::default()
    }

    /// A scene of these bodies, named by their numbers.
    pub fn of(bodies: Vec<Body<D>>) -> Self {
        let mut scene = Self::new();
        for (index, body) in bodies.into_iter().enumerate() {
            scene.add(index.to_string(), body);
        }
        scene
    }

    /// Adds a body under a unique name. Errors and results refer to the body by this name.
    pub fn add(&mut self, name: impl Into<String>, body: Body<D>) -> BodyId {
        self.bodies.push(body);
        self.names.push(name.into());
        BodyId(self.bodies.len() - 1)
    }

    /// The bodies, in the order of addition.
    pub fn bodies(&self) -> &[Body<D>] {
        &self.bodies
    }

    /// A body, to be supported, loaded or made of otherwise than before: in a clone of the scene, for a study.
    ///
    /// A bar that is twice as stiff takes twice the force.
    /// ```
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// let mesh = rectangle(&linspace(0.0, 4.0, 8), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
    /// let mut bar = Body::new(mesh.clone(), LinearElastic::new(100.0, 0.0)?);
    /// bar.symmetry("left")?.symmetry("bottom")?.prescribe("right", [Some(0.04), None])?;
    /// let mut scene = Scene::new();
    /// let id = scene.add("bar", bar);
    ///
    /// let mut stiffer = scene.clone();
    /// stiffer.body_mut(id).take_law(Body::new(mesh, LinearElastic::new(200.0, 0.0)?))?;
    /// for (scene, force) in [(scene, 1.0), (stiffer, 2.0)] {
    ///     let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    ///     let last = history.last().expect("one step");
    ///     assert!((last.energy - 0.5 * force * 0.04).abs() < 1e-12);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Panics
    /// If the handle is one of another scene, with more bodies.
    pub fn body_mut(&mut self, body: BodyId) -> &mut Body<D> {
        &mut self.bodies[body.0]
    }

    /// The bodies, to be held otherwise.
    pub(super) fn bodies_mut(&mut self) -> &mut [Body<D>] {
        &mut self.bodies
    }

    /// The handles of all bodies, in the order of addition.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = BodyId> + use<D> {
        (0..self.bodies.len()).map(BodyId)
    }

    /// The names of the bodies, in the order of addition.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The names of the bodies that do not deform, likewise.
    pub fn rigid_names(&self) -> Vec<String> {
        let named = self.bodies.iter().zip(&self.names);
        let rigid = named.filter(|(body, _)| body.is_rigid());
        rigid.map(|(_, name)| name.clone()).collect()
    }

    /// The pairs declared so far.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Declares that two boundaries may touch. The pair is symmetric: exchanging the boundaries
    /// does not change the result. Both may belong to one body.
    ///
    /// # Errors
    /// If a body or boundary does not exist, or a boundary has no facets.
    pub fn contact(&mut self, first: Side, second: Side) -> Result<(), Error> {
        self.contact_in_passes(first, second, Passes::Both)
    }

    /// As [`Scene::contact`], with the given roles.
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn contact_in_passes(
        &mut self,
        first: Side,
        second: Side,
        passes: Passes,
    ) -> Result<(), Error> {
        let pair = Pair {
            first: self.checked(first)?,
            second: self.checked(second)?,
            passes,
            offset: 0.0,
            friction: 0.0,
        };
        self.pairs.push(pair);
        Ok(())
    }

    /// Declares that a boundary may touch itself, as that of a strip that is bent until its sides
    /// meet.
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn self_contact(&mut self, side: Side) -> Result<(), Error> {
        self.contact(side.clone(), side)
    }

    /// Ties two boundaries of different bodies: they stay together, whatever acts, although their meshes do not match. The
    /// displacements of the side with the smaller facets follow those of the other one, on which it must lie as a whole.
    ///
    /// A bar of two tied halves, drawn by σ = 2:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let half = |x, ny| rectangle(&linspace(x, x + 1.0, 3), &linspace(0.0, 1.0, ny), Diagonals::Rising);
    /// let law = LinearElastic::new(200.0, 0.0)?;
    /// let (mut left, mut right) = (Body::new(half(0.0, 2)?, law), Body::new(half(1.0, 3)?, law));
    /// left.prescribe("left", [Some(0.0), Some(0.0)])?;
    /// right.traction("right", [2.0, 0.0])?;
    ///
    /// let mut scene = Scene::new();
    /// let (left, right) = (scene.add("left half", left), scene.add("right half", right));
    /// scene.tie(left.on("right"), right.on("left"))?;
    /// let mut problem = scene.problem()?;
    /// let history = Simulation::with_increments(1).run(&mut problem)?;
    /// // the right half pulls the left one by σ times the height
    /// assert!((history.steps[0].ties[0].force[0] - 2.0).abs() < 1e-10);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If a body or boundary does not exist, or a boundary has no facets. Whether the boundaries can be tied is checked with
    /// the scene, see [`TieFault`](super::TieFault).
    pub fn tie(&mut self, first: Side, second: Side) -> Result<(), Error> {
        self.tie_as(Tie::new(first, second))
    }

    /// As [`Scene::tie`], with a choice of the side that follows and of the distance that is accepted.
    ///
    /// # Errors
    /// As [`Scene::tie`], a tolerance that is negative or no number, a jump or a preload that is not finite or of another dimension, and both of them.
    pub fn tie_as(&mut self, tie: Tie) -> Result<(), Error> {
        if !(tie.tolerance >= 0.0 && tie.tolerance.is_finite()) {
            return Err(Error::Setting {
                name: "tie tolerance",
                value: tie.tolerance,
                remedy: "choose a share of the facet size, at least 0",
            });
        }
        Error::check_finite("jump of a tie", &tie.jump)?;
        if !(tie.jump.is_empty() || tie.jump.len() == D) {
            return Err(Error::Setting {
                name: "number of components of the jump of a tie",
                value: tie.jump.len() as f64,
                remedy: "give one for each direction, or none",
            });
        }
        Error::check_finite("preload of a tie", &tie.preload)?;
        if !(tie.preload.is_empty() || tie.preload.len() == D) {
            return Err(Error::Setting {
                name: "number of components of the preload of a tie",
                value: tie.preload.len() as f64,
                remedy: "give one for each direction, or none",
            });
        }
        if tie.jumps() && tie.drawn::<D>().is_some() {
            return Err(Error::Setting {
                name: "preload of a tie beside its jump",
                value: tie
                    .preload
                    .iter()
                    .fold(0.0, |most: f64, f| most.max(f.abs())),
                remedy: "give the force or the way, and the run tells the other one",
            });
        }
        let tie = Tie {
            first: self.checked(tie.first)?,
            second: self.checked(tie.second)?,
            ..tie
        };
        self.ties.push(tie);
        Ok(())
    }

    /// The ties, in the order of declaration.
    pub fn ties(&self) -> &[Tie] {
        &self.ties
    }

    /// Declares that each of these boundaries may touch those of all other bodies: every two of
    /// them that belong to different bodies become a pair, in addition to those declared by
    /// [`Scene::contact`].
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn contact_surface(&mut self, side: Side) -> Result<(), Error> {
        let side = self.checked(side)?;
        if !self.surfaces.contains(&side) {
            self.surfaces.push(side);
        }
        Ok(())
    }

    /// Declares that a boundary may touch a rigid obstacle, which has no body, under a name that no body or other obstacle
    /// has. Its rows are those of one pass with the boundary as slave; normals and gaps are those of the obstacle itself.
    ///
    /// A block of height 1 and width 2 under its weight, on a rigid plane without friction:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Obstacle, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = rectangle(&linspace(0.0, 2.0, 8), &linspace(0.0, 1.0, 4), Diagonals::Rising)?;
    /// let mut block = Body::new(mesh, LinearElastic::new(1000.0, 0.3)?);
    /// block.prescribe("left", [Some(0.0), None])?.body_force([0.0, -5.0])?;
    ///
    /// let mut scene = Scene::new();
    /// let block = scene.add("block", block);
    /// let floor = scene.obstacle("floor", block.on("bottom"), Obstacle::half_space([0.0; 2], [0.0, 1.0])?)?;
    /// let mut problem = scene.problem()?;
    /// let history = Simulation::with_increments(1).run(&mut problem)?;
    /// let force = history.steps[0].obstacle_force(floor);
    /// assert!((force[1] + 10.0).abs() < 1e-9);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the body or boundary does not exist, or the boundary has no facets. Names are checked with those of bodies.
    pub fn obstacle(
        &mut self,
        name: impl Into<String>,
        side: Side,
        obstacle: Obstacle<D>,
    ) -> Result<ObstacleId, Error> {
        let side = self.checked(side)?;
        let id = self.obstacles.len();
        self.obstacles.push(obstacle);
        self.obstacle_names.push(name.into());
        self.obstructed.push((side, id));
        self.obstacle_frictions.push(0.0);
        Ok(ObstacleId(id))
    }

    /// Declares that another boundary may touch an obstacle of this scene.
    ///
    /// # Errors
    /// As [`Scene::obstacle`], and if there is no such obstacle.
    pub fn contact_obstacle(&mut self, side: Side, obstacle: ObstacleId) -> Result<(), Error> {
        let side = self.checked(side)?;
        self.checked_obstacle(obstacle)?;
        let declared = (side, obstacle.0);
        if !self.obstructed.contains(&declared) {
            self.obstructed.push(declared);
        }
        Ok(())
    }

    /// Lets the contact of two boundaries count at some load factors t alone, those with `from` < t ≤ `to` for one of the
    /// `intervals`: in the phases that end at `to` and begin at `from`. A phase must end where something is switched. `to` may be
    /// infinite.
    ///
    /// While a pair does not count, it has no rows, no forces and no gaps, and its bodies may overlap, which neither the
    /// certificate nor the ending of a load step holds against them. Where it counts again, the load step must part them.
    ///
    /// # Errors
    /// Boundaries that are no pair, an interval whose end is not beyond its beginning, and numbers that are not. A run refuses
    /// intervals that begin or end within a phase ([`Error::SwitchWithinPhase`]) or meet none ([`Error::NeverCounts`]).
    pub fn contact_during(
        &mut self,
        first: &Side,
        second: &Side,
        intervals: &[[f64; 2]],
    ) -> Result<(), Error> {
        let both = [first, second];
        let is_named = |pair: &Pair| {
            [&pair.first, &pair.second] == both || [&pair.second, &pair.first] == both
        };
        if !self.all_pairs()?.iter().any(is_named) {
            return Err(Error::NoPair {
                first: self.name_of_side(first),
                second: self.name_of_side(second),
            });
        }
        let pair = Switched::Pair(first.clone(), second.clone());
        self.switch(pair, intervals)
    }

    /// Lets the surfaces of a pair keep a distance (UL): gaps are measured from there. A coating or a sheet of that thickness between the bodies,
    /// which has no mesh and does not give way, as one on each side, half as thick.
    ///
    /// Two blocks with a sheet of 0.1 between them, pressed by what makes the gap of 0.1 one of 0.08:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let block = |y| rectangle(&linspace(0.0, 1.0, 4), &linspace(y, y + 1.0, 4), Diagonals::Rising);
    /// let law = LinearElastic::new(200.0, 0.0)?;
    /// let (mut lower, mut upper) = (Body::new(block(0.0)?, law), Body::new(block(1.1)?, law));
    /// lower.symmetry("bottom")?.symmetry("left")?;
    /// upper.symmetry("left")?.prescribe("top", [None, Some(-0.02)])?;
    ///
    /// let mut scene = Scene::new();
    /// let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    /// let sides = [lower.on("top"), upper.on("bottom")];
    /// scene.contact(sides[0].clone(), sides[1].clone())?;
    /// scene.contact_offset(&sides[0], &sides[1], 0.1)?;
    /// let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    /// // both are shortened by 0.01
    /// assert!((history.steps[0].reaction(lower)[1] - 200.0 * 0.01).abs() < 1e-6);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Boundaries that are no pair declared by name, one boundary with itself, and a distance that is negative or no number. [`Scene::problem`] refuses
    /// distances of more than a quarter of [`Scene::reach`], where that is set, and bodies that start closer than they keep, unless [`Scene::initial_gaps`]
    /// takes that.
    pub fn contact_offset(
        &mut self,
        first: &Side,
        second: &Side,
        offset: f64,
    ) -> Result<(), Error> {
        if !(offset >= 0.0 && offset.is_finite()) {
            return Err(Error::Setting {
                name: "offset of a pair",
                value: offset,
                remedy: "choose a distance, at least 0",
            });
        }
        match self.named_pair(first, second).filter(|_| first != second) {
            Some(pair) => {
                pair.offset = offset;
                Ok(())
            }
            None => Err(self.no_pair(first, second)),
        }
    }

    /// Gives a pair friction by Coulomb's law, |t| ≤ μ p: where the surfaces stick, the traction t along them is what holds them; where they slip,
    /// it is μ p, against the slip. In the plane and of revolution (`docs/friction.md`).
    ///
    /// A block that is pressed onto a plate, and drawn along it until it slips:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Amplitude, Body, LinearElastic, Scene, Simulation};
    /// # use contact_core::Phase;
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let block = |y| rectangle(&linspace(0.0, 1.0, 2), &linspace(y, y + 1.0, 2), Diagonals::Rising);
    /// let law = LinearElastic::new(100.0, 0.0)?;
    /// let (mut lower, mut upper) = (Body::new(block(0.0)?, law), Body::new(block(1.0)?, law));
    /// lower.prescribe_all([Some(0.0); 2])?;
    /// // down by 0.02 in the first phase, and aside by 0.05 in the second
    /// let [down, aside] = [[0.0, 1.0, 1.0], [0.0, 0.0, 1.0]].map(|of| Amplitude::table(&[(0.0, of[0]), (1.0, of[1]), (2.0, of[2])]));
    /// upper.prescribe_in_time("top", [None, Some(-0.02)], down?)?;
    /// upper.prescribe_in_time("top", [Some(0.05), None], aside?)?;
    ///
    /// let mut scene = Scene::new();
    /// let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    /// let sides = [lower.on("top"), upper.on("bottom")];
    /// scene.contact(sides[0].clone(), sides[1].clone())?;
    /// scene.contact_friction(&sides[0], &sides[1], 0.3)?;
    /// # #[cfg(feature = "ipopt")]
    /// # {
    /// let phases = [Phase::new("pressed", 1.0, 1), Phase::new("drawn", 2.0, 4)];
    /// let history = Simulation::in_phases(phases).run(&mut scene.problem()?)?;
    /// let [aside, down] = history.steps[4].reaction(upper).into();
    /// assert!((aside / -down - 0.3).abs() < 1e-5, "it slips");
    /// # }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Boundaries that are no pair declared by name, and a coefficient that is negative or no number. [`Scene::problem`] refuses friction in space.
    pub fn contact_friction(
        &mut self,
        first: &Side,
        second: &Side,
        friction: f64,
    ) -> Result<(), Error> {
        check_friction(friction)?;
        match self.named_pair(first, second) {
            Some(pair) => {
                pair.friction = friction;
                Ok(())
            }
            None => Err(self.no_pair(first, second)),
        }
    }

    /// As [`Scene::contact_friction`], for all contact with an obstacle. A moving obstacle drags along what sticks to it.
    ///
    /// # Errors
    /// An obstacle that there is not; else as [`Scene::contact_friction`].
    pub fn obstacle_friction(&mut self, obstacle: ObstacleId, friction: f64) -> Result<(), Error> {
        check_friction(friction)?;
        self.checked_obstacle(obstacle)?;
        self.obstacle_frictions[obstacle.0] = friction;
        Ok(())
    }

    /// The coefficient of friction of each obstacle.
    pub(crate) fn obstacle_frictions(&self) -> &[f64] {
        &self.obstacle_frictions
    }

    /// The pair of these boundaries, in either order.
    fn named_pair(&mut self, first: &Side, second: &Side) -> Option<&mut Pair> {
        let both = [first, second];
        let is_named = |pair: &&mut Pair| {
            [&pair.first, &pair.second] == both || [&pair.second, &pair.first] == both
        };
        self.pairs.iter_mut().find(is_named)
    }

    fn no_pair(&self, first: &Side, second: &Side) -> Error {
        Error::NoPair {
            first: self.name_of_side(first),
            second: self.name_of_side(second),
        }
    }

    /// As [`Scene::contact_during`], for all contact with an obstacle.
    ///
    /// # Errors
    /// An obstacle that there is not; else as [`Scene::contact_during`].
    pub fn obstacle_during(
        &mut self,
        obstacle: ObstacleId,
        intervals: &[[f64; 2]],
    ) -> Result<(), Error> {
        self.checked_obstacle(obstacle)?;
        self.switch(Switched::Obstacle(obstacle.0), intervals)
    }

    fn switch(&mut self, what: Switched, intervals: &[[f64; 2]]) -> Result<(), Error> {
        let during = During::new(intervals, "end of the interval in which contact counts")?;
        self.switched.retain(|(known, _)| *known != what);
        self.switched.push((what, during));
        Ok(())
    }

    /// What is switched, as errors call it.
    pub(super) fn name_of_switched(&self, what: &Switched) -> String {
        match what {
            Switched::Pair(first, second) => {
                let [first, second] = [first, second].map(|side| self.name_of_side(side));
                format!("the contact of {first} with {second}")
            }
            Switched::Obstacle(index) => format!("obstacle `{}`", self.obstacle_names[*index]),
        }
    }

    /// A boundary and its body, as errors call it.
    pub(crate) fn name_of_side(&self, side: &Side) -> String {
        match self.names.get(side.body.index()) {
            Some(name) => format!("`{}` of body `{name}`", side.boundary),
            None => format!("`{}` of body {}", side.boundary, side.body.index()),
        }
    }

    /// The pairs and obstacles that do not count at all times, and when they do.
    pub(super) fn switched(&self) -> &[(Switched, During)] {
        &self.switched
    }

    /// Whether the bodies are ones of revolution.
    pub(crate) fn is_of_revolution(&self) -> bool {
        let mut bodies = self.bodies.iter();
        bodies.any(|body| body.mesh().is_of_revolution())
    }

    /// The number of the first node of each body where nodes of all bodies count one after the other, and the number of all nodes.
    pub(crate) fn first_nodes(&self) -> Vec<usize> {
        let mut first = vec![0];
        let counts = self.bodies.iter().map(|body| body.mesh().nodes().len());
        counts.for_each(|count| first.push(first[first.len() - 1] + count));
        first
    }

    /// Whether contact with an obstacle counts at a load factor.
    #[cfg(any(feature = "plot", feature = "vtk"))]
    pub(crate) fn obstacle_counts_at(&self, obstacle: usize, load: f64) -> bool {
        let of_it = |what: &Switched| *what == Switched::Obstacle(obstacle);
        let mut own = self.switched.iter().filter(|(what, _)| of_it(what));
        own.all(|(_, during)| during.has(load))
    }

    /// The obstacles, in the order of declaration.
    pub fn obstacles(&self) -> &[Obstacle<D>] {
        &self.obstacles
    }

    /// The names of the obstacles, in the order of declaration.
    pub fn obstacle_names(&self) -> &[String] {
        &self.obstacle_names
    }

    /// The sides that an obstacle may hold, with the obstacle's number.
    pub(crate) fn obstructed(&self) -> &[(Side, usize)] {
        &self.obstructed
    }

    /// The longest jump of a tie (UL).
    pub(super) fn longest_jump(&self) -> f64 {
        let jumps = self
            .ties
            .iter()
            .map(|tie| tie.jump.iter().map(|part| part * part).sum::<f64>());
        jumps.fold(0.0, f64::max).sqrt()
    }

    /// The longest way (UL) on which obstacles take the corners of the box around a body that they may hold, up to load
    /// factor 1.
    pub(super) fn obstacle_way(&self) -> f64 {
        let way = |(side, obstacle): &(Side, usize)| {
            let Some(body) = self.bodies.get(side.body.index()) else {
                return 0.0;
            };
            let (low, high) = body.mesh().bounding_box();
            let corner =
                |k: usize| Vector::from_fn(|i, _| if k >> i & 1 == 0 { low[i] } else { high[i] });
            let start = self.obstacles[*obstacle].pose(0.0);
            let times = self.obstacles[*obstacle].times().into_iter();
            let poses = times.map(|t| self.obstacles[*obstacle].pose(t));
            let ways = poses.flat_map(|pose| {
                (0..1 << D).map(move |k| (pose.place(&corner(k)) - start.place(&corner(k))).norm())
            });
            ways.filter(|way| way.is_finite()).fold(0.0, f64::max)
        };
        self.obstructed.iter().map(way).fold(0.0, f64::max)
    }

    /// The name of a body, or of an obstacle: these are numbered after the bodies.
    pub(crate) fn name_of(&self, index: usize) -> &String {
        match index.checked_sub(self.names.len()) {
            None => &self.names[index],
            Some(obstacle) => &self.obstacle_names[obstacle],
        }
    }

    /// "body `name`" or "obstacle `name`", likewise.
    pub(crate) fn called(&self, index: usize) -> String {
        let what = if index < self.names.len() {
            "body"
        } else {
            "obstacle"
        };
        format!("{what} `{}`", self.name_of(index))
    }

    /// Whether a side may touch all other such sides, by [`Scene::contact_surface`].
    pub(super) fn is_general(&self, side: &Side) -> bool {
        self.surfaces.contains(side)
    }

    /// The declared pairs, and those that follow from the declared surfaces and were not declared
    /// themselves.
    fn all_pairs(&self) -> Result<Vec<Pair>, Error> {
        let mut pairs = self.pairs.clone();
        let first_body = self.surfaces.first().map(|surface| surface.body);
        if first_body.is_some() && self.surfaces.iter().all(|s| Some(s.body) == first_body) {
            return Err(Error::Setting {
                name: "contact_surface",
                value: self.surfaces.len() as f64,
                remedy: "declare surfaces of two bodies at least, or `self_contact`",
            });
        }
        for (k, second) in self.surfaces.iter().enumerate() {
            let others = self.surfaces[..k].iter();
            for first in others.filter(|first| first.body != second.body) {
                let both = [first, second];
                let is_named =
                    |pair: &Pair| both.contains(&&pair.first) && both.contains(&&pair.second);
                let is_tied = self.ties.iter().any(|tie| tie.is_between(first, second));
                if !is_tied && !pairs.iter().any(is_named) {
                    pairs.push(Pair {
                        first: first.clone(),
                        second: second.clone(),
                        passes: Passes::Both,
                        offset: 0.0,
                        friction: 0.0,
                    });
                }
            }
        }
        Ok(pairs)
    }

    fn checked_obstacle(&self, obstacle: ObstacleId) -> Result<(), Error> {
        match obstacle.0 < self.obstacles.len() {
            true => Ok(()),
            false => Err(Error::Setting {
                name: "obstacle",
                value: obstacle.0 as f64,
                remedy: "use a handle that this scene's `obstacle` returned",
            }),
        }
    }

    /// The side, if it exists and has facets.
    fn checked(&self, side: Side) -> Result<Side, Error> {
        let body = side.body.index();
        let owner = self.bodies.get(body).ok_or(Error::UnknownBody {
            body,
            bodies: self.bodies.len(),
        })?;
        match owner.mesh().boundary(&side.boundary)?.is_empty() {
            true => Err(Error::EmptySurface {
                body: self.names[body].clone(),
                boundary: side.boundary,
            }),
            false => Ok(side),
        }
    }

    /// Integrates the constraints as the paper does: at Gauss points, of the default number, with their feet at the closest points.
    pub fn points_as_in_the_paper(&mut self) {
        self.integration = Some(Integration::Gauss(self.default_points()));
        self.projection = Projection::Closest;
    }

    /// The quadrature of the constraints: the one that was set, or the default.
    pub(crate) fn integration(&self) -> Integration {
        let by_default = match D {
            2 => Integration::Exact,
            _ => Integration::Gauss(self.default_points()),
        };
        self.integration.unwrap_or(by_default)
    }

    /// The number of Gauss points on obstacles, for each facet and direction.
    pub(super) fn obstacle_points(&self) -> usize {
        match self.integration {
            Some(Integration::Gauss(points)) => points,
            _ => self.default_points(),
        }
    }

    fn default_points(&self) -> usize {
        let is_quadratic = |body: &Body<D>| body.mesh().order() == Order::Quadratic;
        match (self.bodies.iter().any(is_quadratic), D) {
            (false, _) => 4,
            (true, 2) => 12,
            (true, _) => 8,
        }
    }

    /// The positions at which contact is searched: those that were set, or the default.
    ///
    /// # Errors
    /// If a scene with contact pairs has bodies with small-strain and with other laws, whether they are
    /// in a pair or not, and no geometry was set.
    fn geometry(&self, pairs: &[Pair]) -> Result<Geometry, Error> {
        let body_of = |small: bool| {
            let mut bodies = self.bodies.iter().zip(&self.names);
            bodies.find(|(body, _)| !body.is_rigid() && body.is_small_strain() == small)
        };
        match (self.geometry, body_of(true), body_of(false)) {
            (Some(chosen), _, _) => Ok(chosen),
            (None, _, None) => Ok(Geometry::Reference),
            (None, Some((_, small)), Some((_, large)))
                if !pairs.is_empty() || !self.obstructed.is_empty() =>
            {
                Err(Error::GeometryNotChosen {
                    small: small.clone(),
                    large: large.clone(),
                })
            }
            (None, _, Some(_)) => Ok(Geometry::Current),
        }
    }

    /// Checks the scene without solving: what is wrong, what may not be meant, and what is worth
    /// knowing, the worst first. Findings of [`Severity::Error`](super::Severity::Error) are those for which
    /// [`Scene::problem`] refuses the scene. The checks cost much less than one factorisation.
    ///
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::model::{FindingKind, Severity};
    /// use contact_fem::{Body, LinearElastic, Scene};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let block = |y| rectangle(&linspace(0.0, 1.0, 4), &linspace(y, y + 1.0, 4), Diagonals::Rising);
    /// let mut lower = Body::new(block(0.0)?, LinearElastic::new(210.0, 0.3)?);
    /// lower.prescribe("bottom", [Some(0.0), Some(0.0)])?;
    /// let mut upper = Body::new(block(1.0)?, LinearElastic::new(210.0, 0.49)?);
    /// upper.traction("top", [0.0, -1.0])?;
    ///
    /// let mut scene = Scene::new();
    /// let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    /// scene.contact(lower.on("top"), upper.on("bottom"))?;
    /// let findings = scene.preflight();
    /// for finding in &findings {
    ///     println!("{finding}");
    /// }
    /// let found = findings.iter().map(|finding| (finding.severity, finding.kind));
    /// let held = [FindingKind::HeldByNothing, FindingKind::HeldByContact].map(|kind| (Severity::Note, kind));
    /// let locks = (Severity::Warning, FindingKind::Locking);
    /// assert_eq!(found.collect::<Vec<_>>(), [locks, held[0], held[1]]);
    /// assert_eq!(findings[1].what, "neither supports nor contact hold body `upper`: translation x");
    /// assert_eq!(findings[2].what, "only contact holds body `upper`: translation y, rotation");
    /// # Ok(())
    /// # }
    /// ```
    pub fn preflight(&self) -> Vec<Finding> {
        self.report().into_findings()
    }

    /// All errors for which [`Scene::problem`] refuses the scene, in the order of the findings of [`Scene::preflight`].
    pub fn errors(&self) -> Vec<Error> {
        self.report().into_errors()
    }

    fn report(&self) -> Report {
        instance().report(self)
    }

    /// Makes all checks.
    pub(crate) fn examine(&self) -> Report {
        let mut report = Report::default();
        let pairs = report.take(self.all_pairs());
        let declared = pairs.as_deref().unwrap_or(&self.pairs);
        if !preflight::without_surfaces(self, declared, &mut report) {
            return report;
        }
        let geometry = report.take(self.geometry(declared));
        let kinematics = Kinematics::new(&self.bodies);
        let ties = report.take(Ties::new(self, &kinematics));
        let geometry = geometry.unwrap_or(Geometry::Current);
        let audit = Audit::new(self, &kinematics.X);
        preflight::with_surfaces(
            &Setup {
                scene: self,
                pairs: declared,
                contact: &ContactSet::new(self, declared, geometry, &kinematics, &audit),
                audit: &audit,
                kinematics: &kinematics,
                ties: &ties.unwrap_or_default(),
            },
            &mut report,
        );
        report
    }

    /// Checks the scene and builds its contact problem, at load factor 0. Warnings and notes of the checks are
    /// [`Problem::findings`].
    ///
    /// # Errors
    /// If a check before the solve fails: an empty or repeated name, a body without support, bodies
    /// that overlap, a setting out of range, laws of two kinds without a choice of geometry, loads that round-off hides.
    /// [`Scene::preflight`] finds all of them at once.
    pub fn problem(self) -> Result<Problem<D>, Error> {
        instance().problem(self)
    }

    /// [`Scene::problem`].
    pub(crate) fn build(mut self) -> Result<Problem<D>, Error> {
        self.pairs = self.all_pairs()?;
        let mut report = Report::default();
        preflight::without_surfaces(&self, &self.pairs, &mut report);
        let mut report = report.accepted()?;
        let needed = self.assembly_bytes();
        if needed > LARGE {
            memory::check("the assembly of the scene", needed)
                .map_err(contact_core::Error::from)?;
        }
        let geometry = self.geometry(&self.pairs)?;
        let mut problem = Problem::new(self, geometry)?;
        preflight::with_surfaces(&problem.setup(), &mut report);
        problem.findings = report.accepted()?.into_findings();
        Ok(problem)
    }

    /// What the problem of the scene takes at least: the entries of the cells' matrices, with their places.
    fn assembly_bytes(&self) -> u64 {
        let of_body = |body: &Body<D>| {
            let mesh = body.mesh();
            let dofs = (0..mesh.len().min(1)).map(|k| D * mesh.cell(k).len());
            let dofs: usize = dofs.sum();
            (mesh.len() * (dofs * (dofs + 1) / 2)) as u64 * ENTRY
        };
        self.bodies().iter().map(of_body).sum()
    }
}

/// Bytes for each entry of a cell's matrix, as measured on quadratic tetrahedra. From so many bytes in all on, what the
/// system has left is looked at first.
const ENTRY: u64 = 44;
const LARGE: u64 = 32 << 20;
/// The largest coefficient of friction.
const MOST_FRICTION: f64 = 1e3;

fn check_friction(friction: f64) -> Result<(), Error> {
    match (0.0..=MOST_FRICTION).contains(&friction) {
        true => Ok(()),
        false => Err(Error::Setting {
            name: "friction",
            value: friction,
            remedy: "choose a coefficient from 0 to 1000; what sticks in any case is tied",
        }),
    }
}
