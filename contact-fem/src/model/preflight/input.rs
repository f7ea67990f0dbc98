//! Names, settings, numbers and boundaries.

use super::limits::SLOPE;
use super::{Finding, FindingKind, Report, Severity};
use crate::error::Error;
use crate::model::contact_set::OFFSET;
use crate::model::{Integration, Scene};

/// Checks that every body and every obstacle has a name of its own.
pub(super) fn names<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    for (body, name) in scene.names().iter().enumerate() {
        if name.is_empty() {
            return Err(Error::UnnamedBody { body });
        }
        if let Some(first) = scene.names()[..body].iter().position(|other| other == name) {
            return Err(Error::BodyExists {
                name: name.clone(),
                bodies: [first, body],
            });
        }
    }
    for (obstacle, name) in scene.obstacle_names().iter().enumerate() {
        if name.is_empty() {
            return Err(Error::UnnamedObstacle { obstacle });
        }
        let others = scene.names().iter();
        let mut others = others.chain(&scene.obstacle_names()[..obstacle]);
        if others.any(|other| other == name) {
            return Err(Error::ObstacleExists { name: name.clone() });
        }
    }
    Ok(())
}

/// Checks that all bodies are of revolution, or none.
pub(super) fn kinds<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let first = |is_revolved: bool| {
        let mut bodies = scene.bodies().iter().zip(scene.names());
        bodies.find(|(body, _)| body.mesh().is_of_revolution() == is_revolved)
    };
    match (first(true), first(false)) {
        (Some((_, revolved)), Some((_, plane))) => Err(Error::MixedRevolution {
            revolved: revolved.clone(),
            plane: plane.clone(),
        }),
        _ => Ok(()),
    }
}

/// Checks that the settings are within their ranges.
pub(super) fn settings<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let setting = |name, value, remedy| {
        Err(Error::Setting {
            name,
            value,
            remedy,
        })
    };
    if scene.bodies().is_empty() {
        return setting("bodies", 0.0, "a scene needs at least one body");
    }
    if let Some(Integration::Gauss(points)) = scene.integration {
        if !(1..=64).contains(&points) {
            return setting("integration", points as f64, "choose 1 to 64 Gauss points");
        }
    }
    match scene.reach {
        Some(reach) if reach.is_nan() || reach <= 0.0 => {
            setting("reach", reach, "a positive length, or None for the default")
        }
        _ if !scene.overlap_tolerance.is_finite() || scene.overlap_tolerance < 0.0 => setting(
            "overlap_tolerance",
            scene.overlap_tolerance,
            "a finite share of the facet size, 0 or more",
        ),
        _ => Ok(()),
    }
}

/// Checks that the surfaces of pairs see each other from the distance that they keep.
pub(super) fn offsets<const D: usize>(scene: &Scene<D>, reach: f64) -> Result<(), Error> {
    let offsets = scene.pairs().iter().map(|pair| pair.offset);
    match offsets.fold(0.0, f64::max) {
        // up to round-off of the default radius
        offset if offset > reach * OFFSET * (1.0 + f64::EPSILON) => Err(Error::Setting {
            name: "offset of a pair",
            value: offset,
            remedy: "raise `Scene::reach` to four times it at least: points see other surfaces within that radius",
        }),
        _ => Ok(()),
    }
}

/// Checks that nothing has friction in space, and no pair friction beside a distance that its surfaces keep: a turn of both would count as a slip.
pub(super) fn frictions<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let pairs = scene.pairs().iter().map(|pair| pair.friction);
    let obstacles = scene.obstacle_frictions().iter().copied();
    let largest = pairs.chain(obstacles).fold(0.0, f64::max);
    if largest > 0.0 && D == 3 {
        return Err(Error::Setting {
            name: "friction in space",
            value: largest,
            remedy: "leave it out, or take a section of the scene: friction is solved in the plane and of revolution",
        });
    }
    let mut pairs = scene.pairs().iter();
    match pairs.find(|pair| pair.friction > 0.0 && pair.offset > 0.0) {
        Some(pair) => Err(Error::Setting {
            name: "offset of a pair with friction",
            value: pair.offset,
            remedy: "leave one of them out: where both bodies turn, slips would count the turn of what is between them",
        }),
        None => Ok(()),
    }
}

/// Checks that the sum of the nodal forces is finite.
pub(super) fn forces<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let mut bodies = scene.bodies().iter().zip(scene.names());
    bodies.try_for_each(|(body, name)| {
        let what = format!("the sum of the nodal forces of body `{name}`");
        Error::check_finite(&what, body.forces())
    })
}

/// Checks that stresses and tangents of laws are derivatives: scales and certificates take a tangent's word for the stiffness.
pub(super) fn laws<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let mut bodies = scene.bodies().iter().zip(scene.names());
    bodies.try_for_each(|(body, name)| {
        if body.prescribed().iter().all(Option::is_some) {
            return Ok(());
        }
        let [stress, tangent] = body.law_slopes();
        let differs = |what, of, error| {
            let body = name.clone();
            Err(Error::LawDiffers {
                body,
                what,
                of,
                error,
            })
        };
        match (stress, tangent) {
            (error, _) if !(error <= SLOPE) => differs("stress", "energy", error),
            (_, error) if !(error <= SLOPE) => differs("tangent", "stress", error),
            _ => Ok(()),
        }
    })
}

/// Finds boundaries without facets.
pub(super) fn boundaries<const D: usize>(scene: &Scene<D>, report: &mut Report) {
    for (body, name) in scene.bodies().iter().zip(scene.names()) {
        let mesh = body.mesh();
        let is_empty = |boundary: &&str| mesh.boundary(boundary).is_ok_and(|f| f.is_empty());
        for boundary in mesh.boundary_names().filter(is_empty) {
            let finding = Finding::new(Severity::Warning, FindingKind::EmptyBoundary, &[name]);
            report.add(finding.measured(0.0, 1.0).says(
                format!("boundary `{boundary}` of body `{name}` has no facets"),
                "check the predicate that names it: it must hold at all corners of a facet, up to the \
                 round-off of their coordinates",
            ));
        }
    }
}
