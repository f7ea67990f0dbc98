//! Scenes: bodies, their supports and loads, and which surfaces may touch.

mod body;
mod check;
mod overlap;
mod problem;

pub use body::Body;
pub use problem::Problem;

pub use crate::contact::Integration;
use crate::element::Order;
use crate::error::Error;

/// A contact surface as a user names it: body and boundary.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SurfaceName {
    /// The body's index in the scene.
    pub body: usize,
    /// The name of a boundary of its mesh.
    pub boundary: String,
}

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

/// Two surfaces that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// One surface.
    pub first: SurfaceName,
    /// The other one.
    pub second: SurfaceName,
    /// In which roles.
    pub passes: Passes,
}

/// Bodies and contact pairs; [`Scene::problem`] checks it and makes it solvable.
pub struct Scene<const D: usize> {
    bodies: Vec<Body<D>>,
    pairs: Vec<Pair>,
    surfaces: Vec<SurfaceName>,
    /// How the constraints are integrated: by default at 4 Gauss points a facet and direction; with
    /// quadratic elements, whose pressures suffer more, at 12 in the plane and 8 in space. They do
    /// not see where facets of the other surface end, which costs about 0.1 % of the stress in flat
    /// contact of meshes that do not match, and more with one pass; [`Integration::Exact`] does.
    pub integration: Integration,
    /// How far an integration point looks for the other surface (UL). By default a tenth of the
    /// scene's diagonal, and all of it in small-strain scenes, whose geometry stays where it is.
    /// Points out of reach do not count; nor do rows none of whose points does.
    pub reach: Option<f64>,
    /// How deep bodies may overlap before any load, as a share of the facet size; polygons of
    /// touching curves overlap by a little. 0.05 by default.
    pub overlap_tolerance: f64,
    /// Does what could be left out, for comparison: prescribed dofs stay as fixed unknowns, cells
    /// that cannot deform are assembled, no row is out of reach whatever `reach` is, stiffness is
    /// evaluated in every iteration, and the fixed point goes on until exact rows are seen not to
    /// change. `false` by default; the result is the same to solver tolerance, unless `reach` left
    /// out what does touch.
    pub keep_everything: bool,
}

impl<const D: usize> Scene<D> {
    /// A scene of these bodies, without contact so far.
    pub fn new(bodies: Vec<Body<D>>) -> Self {
        let quadratic = |body: &Body<D>| body.mesh().order() == Order::Quadratic;
        let gauss_points = match (bodies.iter().any(quadratic), D) {
            (false, _) => 4,
            (true, 2) => 12,
            (true, _) => 8,
        };
        Scene {
            bodies,
            pairs: Vec::new(),
            surfaces: Vec::new(),
            integration: Integration::Gauss(gauss_points),
            reach: None,
            overlap_tolerance: 0.05,
            keep_everything: false,
        }
    }

    /// The bodies.
    pub fn bodies(&self) -> &[Body<D>] {
        &self.bodies
    }

    /// The pairs declared so far.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Declares that two boundaries, each given as (body, boundary name), may touch. Neither is
    /// slave or master: swapping them changes nothing. Both may belong to one body.
    ///
    /// # Errors
    /// A body or boundary that does not exist, a boundary without facets.
    pub fn contact(&mut self, first: (usize, &str), second: (usize, &str)) -> Result<(), Error> {
        self.contact_in_passes(first, second, Passes::Both)
    }

    /// As [`Scene::contact`], in the roles given.
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn contact_in_passes(
        &mut self,
        first: (usize, &str),
        second: (usize, &str),
        passes: Passes,
    ) -> Result<(), Error> {
        let pair = Pair {
            first: self.surface_name(first)?,
            second: self.surface_name(second)?,
            passes,
        };
        self.pairs.push(pair);
        Ok(())
    }

    /// Declares that a boundary may touch itself, as a strip that closes on itself does.
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn self_contact(&mut self, body: usize, boundary: &str) -> Result<(), Error> {
        self.contact((body, boundary), (body, boundary))
    }

    /// Declares that a boundary may touch any other body's: every two of these surfaces that belong
    /// to different bodies become a pair, beside those named by [`Scene::contact`].
    ///
    /// # Errors
    /// As [`Scene::contact`].
    pub fn contact_surface(&mut self, body: usize, boundary: &str) -> Result<(), Error> {
        let surface = self.surface_name((body, boundary))?;
        if !self.surfaces.contains(&surface) {
            self.surfaces.push(surface);
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

    fn surface_name(&self, (body, boundary): (usize, &str)) -> Result<SurfaceName, Error> {
        let owner = self.bodies.get(body).ok_or(Error::UnknownBody {
            body,
            bodies: self.bodies.len(),
        })?;
        if owner.mesh().boundary(boundary)?.is_empty() {
            return Err(Error::EmptySurface {
                body,
                boundary: boundary.to_string(),
            });
        }
        Ok(SurfaceName {
            body,
            boundary: boundary.to_string(),
        })
    }

    /// Checks the scene and makes the contact problem of it, at no load.
    ///
    /// # Errors
    /// Everything that can be known to be wrong before a solve: bodies that nothing holds, bodies
    /// that overlap, settings out of range.
    pub fn problem(mut self) -> Result<Problem<D>, Error> {
        self.pair_surfaces()?;
        check::settings(&self)?;
        check::loads(&self)?;
        check::supports(&self)?;
        let problem = Problem::new(self);
        overlap::check(&problem)?;
        Ok(problem)
    }
}
