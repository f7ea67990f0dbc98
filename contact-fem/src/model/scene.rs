//! Scenes: bodies by name, and which of their boundaries may touch.

use super::{Body, BodyId, Integration, Problem, Side, overlap, preflight};
use crate::element::Order;
use crate::error::Error;

/// Which roles a pair of surfaces plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Passes {
    /// Each surface once slave and once master: the symmetric form (5).
    #[default]
    Both,
    /// Only the first surface is slave, form (4); kept to show the difference.
    FirstIsSlave,
    /// Only the second surface is slave.
    SecondIsSlave,
}

/// At which positions contact is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// At the reference positions X: normals, closest points and integration points stay where they
    /// are, the constraints are linear, and one solve takes the place of the fixed point. For
    /// displacements and rotations that are small against the facets, whatever the law.
    Reference,
    /// At the current positions x = X + u, by the fixed point. With a law for small strains, whose
    /// energy does not follow rotations, bodies should stretch and rotate little, but may move far.
    Current,
}

/// Two surfaces that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// One surface.
    pub first: Side,
    /// The other one.
    pub second: Side,
    /// In which roles.
    pub passes: Passes,
}

/// Bodies and contact pairs; [`Scene::problem`] checks it and makes it solvable.
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
pub struct Scene<const D: usize> {
    bodies: Vec<Body<D>>,
    names: Vec<String>,
    pairs: Vec<Pair>,
    surfaces: Vec<Side>,
    /// How the constraints are integrated: by default at 4 Gauss points a facet and direction; with
    /// quadratic elements, whose pressures suffer more, at 12 in the plane and 8 in space. They do
    /// not see where facets of the other surface end, which costs about 0.1 % of the stress in flat
    /// contact of meshes that do not match, and more with one pass; [`Integration::Exact`] does.
    pub integration: Option<Integration>,
    /// At which positions contact is looked for. By default [`Geometry::Reference`] if all laws are
    /// for small strains, else [`Geometry::Current`]. Where laws of both kinds meet contact, it must
    /// be chosen.
    pub geometry: Option<Geometry>,
    /// How far an integration point looks for the other surface (UL). By default a tenth of the
    /// scene's diagonal, and all of it in [`Geometry::Reference`], where nothing comes nearer.
    /// Points out of reach do not count; nor do rows none of whose points does.
    pub reach: Option<f64>,
    /// How deep bodies may overlap before any load, as a share of the facet size; polygons of
    /// touching curves overlap by a little. 0.05 by default.
    pub overlap_tolerance: f64,
}

impl<const D: usize> Default for Scene<D> {
    fn default() -> Self {
        Scene {
            bodies: Vec::new(),
            names: Vec::new(),
            pairs: Vec::new(),
            surfaces: Vec::new(),
            integration: None,
            geometry: None,
            reach: None,
            overlap_tolerance: 0.05,
        }
    }
}

impl<const D: usize> Scene<D> {
    /// A scene without bodies so far.
    pub fn new() -> Self {
        Self::default()
    }

    /// A scene of these bodies, which are called by their numbers.
    pub fn of(bodies: Vec<Body<D>>) -> Self {
        let mut scene = Self::new();
        for (index, body) in bodies.into_iter().enumerate() {
            scene.add(index.to_string(), body);
        }
        scene
    }

    /// Adds a body under a name that no other one has. Errors and results call it by that name.
    pub fn add(&mut self, name: impl Into<String>, body: Body<D>) -> BodyId {
        self.bodies.push(body);
        self.names.push(name.into());
        BodyId(self.bodies.len() - 1)
    }

    /// The bodies, in the order in which they were added.
    pub fn bodies(&self) -> &[Body<D>] {
        &self.bodies
    }

    /// All bodies' handles, in the order in which they were added.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = BodyId> + use<D> {
        (0..self.bodies.len()).map(BodyId)
    }

    /// The bodies' names, in the order in which they were added.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The pairs declared so far.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Declares that two boundaries may touch. Neither is slave or master: swapping them changes
    /// nothing. Both may belong to one body.
    ///
    /// # Errors
    /// A body or boundary that does not exist, a boundary without facets.
    pub fn contact(&mut self, first: Side, second: Side) -> Result<(), Error> {
        self.contact_in_passes(first, second, Passes::Both)
    }

    /// As [`Scene::contact`], in the roles given.
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
        };
        self.pairs.push(pair);
        Ok(())
    }

    /// Declares that a boundary may touch itself, as a strip that closes on itself does.
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn self_contact(&mut self, side: Side) -> Result<(), Error> {
        self.contact(side.clone(), side)
    }

    /// Declares that a boundary may touch any other body's: every two of these surfaces that belong
    /// to different bodies become a pair, beside those named by [`Scene::contact`].
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

    /// Pairs of the declared surfaces that were not named.
    fn pair_surfaces(&mut self) -> Result<(), Error> {
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
                if !self.pairs.iter().any(is_named) {
                    self.pairs.push(Pair {
                        first: first.clone(),
                        second: second.clone(),
                        passes: Passes::Both,
                    });
                }
            }
        }
        Ok(())
    }

    /// A side that exists and has facets.
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

    /// How the constraints are integrated: as chosen, or by default.
    pub(super) fn integration(&self) -> Integration {
        let is_quadratic = |body: &Body<D>| body.mesh().order() == Order::Quadratic;
        let by_default = match (self.bodies.iter().any(is_quadratic), D) {
            (false, _) => 4,
            (true, 2) => 12,
            (true, _) => 8,
        };
        self.integration.unwrap_or(Integration::Gauss(by_default))
    }

    /// At which positions contact is looked for: as chosen, or by default.
    ///
    /// # Errors
    /// If laws for small strains and others meet contact, and nothing was chosen.
    pub(super) fn geometry(&self) -> Result<Geometry, Error> {
        let body_of = |small: bool| {
            let mut bodies = self.bodies.iter().zip(&self.names);
            bodies.find(|(body, _)| body.is_small_strain() == small)
        };
        match (self.geometry, body_of(true), body_of(false)) {
            (Some(chosen), _, _) => Ok(chosen),
            (None, _, None) => Ok(Geometry::Reference),
            (None, Some((_, small)), Some((_, large))) if !self.pairs.is_empty() => {
                Err(Error::GeometryNotChosen {
                    small: small.clone(),
                    large: large.clone(),
                })
            }
            (None, _, Some(_)) => Ok(Geometry::Current),
        }
    }

    /// Checks the scene and makes the contact problem of it, at no load.
    ///
    /// # Errors
    /// Everything that can be known to be wrong before a solve: names that are empty or given twice,
    /// bodies that nothing holds, bodies that overlap, settings out of range, laws of two kinds
    /// without a choice of geometry.
    pub fn problem(mut self) -> Result<Problem<D>, Error> {
        self.pair_surfaces()?;
        preflight::names(&self)?;
        preflight::settings(&self)?;
        preflight::loads(&self)?;
        preflight::supports(&self)?;
        let geometry = self.geometry()?;
        let problem = Problem::new(self, geometry);
        overlap::check(&problem)?;
        Ok(problem)
    }
}
