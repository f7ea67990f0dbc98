//! Scenes with one thing otherwise, for comparisons with another program.

use std::fmt;

use contact_fem::model::{Geometry, Passes};

use super::keys::{PassKeys, ProjectionKeys, Where};
use super::{Error, SceneFile, Solver};

/// What may be otherwise in another program's scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Gauss points of each facet and direction.
    Points(usize),
    /// Feet at the closest points.
    Closest,
    /// The roles of all contacts.
    Passes(Passes),
    /// Where contact is looked for.
    Geometry(Geometry),
    /// The solver's tolerance.
    Tolerance(f64),
    /// Load increments, of each phase where there are some.
    Increments(usize),
    /// Sides of quadratic elements that are straight, as in FreeFEM.
    Straight,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Change::Points(points) => write!(f, "points = {points}"),
            Change::Closest => f.write_str("projection = closest"),
            Change::Passes(Passes::Both) => f.write_str("passes = both"),
            Change::Passes(Passes::FirstIsSlave) => f.write_str("passes = first-is-slave"),
            Change::Passes(Passes::SecondIsSlave) => f.write_str("passes = second-is-slave"),
            Change::Geometry(Geometry::Reference) => f.write_str("geometry = reference"),
            Change::Geometry(Geometry::Current) => f.write_str("geometry = current"),
            Change::Tolerance(tolerance) => write!(f, "tolerance = {tolerance:e}"),
            Change::Increments(increments) => write!(f, "increments = {increments}"),
            Change::Straight => f.write_str("straight sides"),
        }
    }
}

impl SceneFile {
    /// The scene with one thing otherwise.
    pub fn changed(&self, change: Change) -> Self {
        let mut file = self.clone();
        let keys = &mut file.keys;
        match change {
            Change::Points(points) => {
                keys.points = Some(points);
                keys.integration = None;
            }
            Change::Closest => keys.projection = Some(ProjectionKeys::Closest),
            Change::Passes(passes) => {
                let passes = match passes {
                    Passes::Both => PassKeys::Both,
                    Passes::FirstIsSlave => PassKeys::FirstIsSlave,
                    Passes::SecondIsSlave => PassKeys::SecondIsSlave,
                };
                keys.contact
                    .iter_mut()
                    .for_each(|contact| contact.passes = Some(passes));
            }
            Change::Geometry(Geometry::Reference) => keys.geometry = Some(Where::Reference),
            Change::Geometry(Geometry::Current) => keys.geometry = Some(Where::Current),
            Change::Tolerance(tolerance) => keys.tolerance = Some(tolerance),
            Change::Increments(increments) => match keys.phase.is_empty() {
                true => keys.increments = Some(increments),
                false => keys
                    .phase
                    .iter_mut()
                    .for_each(|p| p.increments = increments),
            },
            Change::Straight => file.is_straight = true,
        }
        file
    }

    /// The scene to be solved as the paper's script does: by [`Solver::Literal`], with 4 points and feet at the closest
    /// points if the file does not say otherwise, in the increments of the file, those that do not converge included unless it has `goes-on = false`.
    ///
    /// # Errors
    /// A file that asks for another solver.
    pub fn literal(&self) -> Result<Self, Error> {
        if let Some(solver) = self.keys.solver {
            if ![Solver::Literal, Solver::Automatic].contains(&solver) {
                return Err(self.place().key("solver").wrong(format!(
                        "its `solver` is {solver}, which is not the script's: leave the key out, or do not ask for literal"
                    )));
            }
        }
        let mut file = self.clone();
        file.keys.solver = Some(Solver::Literal);
        if file.keys.integration.is_none() {
            file.keys.points.get_or_insert(4);
        }
        file.keys.projection.get_or_insert(ProjectionKeys::Closest);
        file.keys.goes_on.get_or_insert(true);
        Ok(file)
    }
}
