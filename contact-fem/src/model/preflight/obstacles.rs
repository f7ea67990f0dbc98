//! Obstacles: whether their distances are such, where they are, and what starts inside them.

use std::collections::BTreeMap;

use super::limits::{FACES, SLOPE_OF_DISTANCE, TOUCHES};
use super::overlap::accepted;
use super::steps::relative_motion;
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::audit::Overlap;
use crate::contact::obstacle::Placed;
use crate::error::Error;
use crate::model::{Geometry, InitialGaps};
use crate::tensor::Vector;

/// Checks distances, and that no body starts inside an obstacle by more than the tolerance; finds obstacles that are out of
/// reach, or that a boundary faces away from.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    rings(setup, report);
    let obstacles = setup.contact.obstacles.iter();
    let names = setup.scene.obstacle_names();
    let mut is_sound = true;
    for (index, (obstacle, name)) in obstacles.zip(names).enumerate() {
        is_sound &= report
            .take(distances(setup, index, obstacle, name))
            .is_some();
    }
    if is_sound && report.take(inside(setup)).is_some() {
        started_inside(setup, report);
        reached(setup, report);
    }
}

/// Notes what obstacles are around the axis of a scene of revolution, if that is not what their keys say of the plane: a ball beside
/// the axis is a ring, and what moves along r widens.
fn rings<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    if !setup.scene.is_of_revolution() {
        return;
    }
    let obstacles = setup.scene.obstacles().iter();
    for (obstacle, name) in obstacles.zip(setup.scene.obstacle_names()) {
        let finding = || Finding::new(Severity::Note, FindingKind::Revolution, &[name]);
        if let Some(centre) = obstacle.ring() {
            let radius = centre[0];
            report.add(finding().at(&centre).measured(radius, 0.0).says(
                format!(
                    "the centre of obstacle `{name}` is beside the axis, at r = {radius:.3e}: around the axis it is a ring, and no ball"
                ),
                "leave it there if a ring is meant; otherwise put the centre on the axis, r = 0",
            ));
        }
        if obstacle.leaves_axis() {
            report.add(finding().says(
                format!(
                    "obstacle `{name}` does not move along the axis alone: around the axis it widens, narrows or turns inside out, as no \
                     rigid tool does"
                ),
                "leave it as it is if that is meant; otherwise move it along z, the axis, alone",
            ));
        }
    }
}

/// Checks that the distance to an obstacle is finite at the nodes that may touch it, and has the slope of a distance.
fn distances<const D: usize>(
    setup: &Setup<'_, D>,
    index: usize,
    obstacle: &Placed<D>,
    name: &str,
) -> Result<(), Error> {
    let passes = setup.contact.passes.iter();
    let own = passes.filter(|pass| {
        let of = setup.contact.obstacle_of(**pass);
        of.is_some_and(|(other, _)| other == index)
    });
    let mut slopes = Vec::new();
    for x in own.flat_map(|pass| setup.contact.surfaces[pass.slave].reference_nodes()) {
        let refused = |value: f64, what| {
            Err(Error::ObstacleDistance {
                obstacle: name.to_string(),
                what,
                value,
                x: x.iter().copied().collect(),
            })
        };
        let distance = obstacle.distance(x);
        if !distance.is_finite() {
            return refused(distance, "distance");
        }
        let slope = obstacle.slope(x).norm();
        // no distance grows faster than the way; where it has a kink, differences find less
        if !(slope <= 1.0 + SLOPE_OF_DISTANCE) {
            return refused(slope, "slope of the distance");
        }
        slopes.push((slope, x));
    }
    slopes.sort_by(|a, b| a.0.total_cmp(&b.0));
    match slopes.get(slopes.len() / 2) {
        Some(&(slope, x)) if obstacle.obstacle().is_given() && slope < 1.0 - SLOPE_OF_DISTANCE => {
            Err(Error::ObstacleDistance {
                obstacle: name.to_string(),
                what: "slope of the distance",
                value: slope,
                x: x.iter().copied().collect(),
            })
        }
        _ => Ok(()),
    }
}

/// The worst overlap of each body with each obstacle, as the audit sees it.
fn overlaps<const D: usize>(setup: &Setup<'_, D>) -> Vec<Overlap<D>> {
    let bodies = setup.scene.bodies().len();
    let mut worst: BTreeMap<[usize; 2], Overlap<D>> = BTreeMap::new();
    let overlaps = setup.audit.overlaps(&setup.kinematics.X).into_iter();
    for overlap in overlaps.filter(|overlap| overlap.bodies[1] >= bodies) {
        let kept = worst.entry(overlap.bodies).or_insert(overlap);
        if overlap.depth > kept.depth {
            *kept = overlap;
        }
    }
    worst.into_values().collect()
}

/// The overlap that is accepted there (UL).
fn tolerance<const D: usize>(setup: &Setup<'_, D>, overlap: &Overlap<D>) -> f64 {
    let fit = setup.contact.fit(overlap.bodies);
    (accepted(setup.scene) * overlap.depth / overlap.relative).max(fit)
}

/// Checks that no body starts deeper inside an obstacle, which counts from the start, than the tolerance.
fn inside<const D: usize>(setup: &Setup<'_, D>) -> Result<(), Error> {
    let overlaps = overlaps(setup).into_iter();
    let mut now = overlaps.filter(|overlap| !setup.contact.lets_through(overlap.bodies, 0.0));
    let too_deep = now.find(|overlap| overlap.depth > tolerance(setup, overlap));
    match too_deep {
        Some(overlap) => Err(Error::InsideObstacle {
            body: setup.scene.name_of(overlap.bodies[0]).clone(),
            obstacle: setup.scene.name_of(overlap.bodies[1]).clone(),
            x: overlap.at.iter().copied().collect(),
            depth: overlap.depth,
            tolerance: tolerance(setup, &overlap),
        }),
        None => Ok(()),
    }
}

/// Notes what starts less deep inside an obstacle.
fn started_inside<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    for overlap in overlaps(setup) {
        if overlap.relative <= TOUCHES {
            continue;
        }
        let [body, obstacle] = overlap.bodies.map(|index| setup.scene.name_of(index));
        let kind = FindingKind::Interference;
        let note = Finding::new(Severity::Note, kind, &[body, obstacle]).at(&overlap.at);
        let is_later = setup.contact.lets_through(overlap.bodies, 0.0);
        let becomes = match setup.scene.initial_gaps {
            _ if is_later => "where the obstacle begins to count, it pushes the body out",
            InitialGaps::Refuse => "the first load step pushes the body out",
            InitialGaps::Resolve => "the load pushes the body out step by step",
            InitialGaps::Adjust => "the overlap stays and causes no force",
        };
        let note = note.measured(overlap.depth, tolerance(setup, &overlap));
        report.add(note.says(
            format!(
                "body `{body}` starts {:.3e} inside obstacle `{obstacle}`; {becomes}",
                overlap.depth
            ),
            "leave the two there if an interference fit is meant, or if only chords of curved surfaces overlap; otherwise move one of them",
        ));
    }
}

/// Finds obstacles that a boundary does not face, or does not reach.
fn reached<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    for pass in &setup.contact.passes {
        let Some((_, obstacle)) = setup.contact.obstacle_of(*pass) else {
            continue;
        };
        let surface = &setup.contact.surfaces[pass.slave];
        let [body, other] = setup.contact.bodies_of(*pass);
        let names = [body, other].map(|index| setup.scene.name_of(index));
        let nodes = surface
            .reference_nodes()
            .iter()
            .zip(surface.reference_normals());
        let seen = nodes.map(|(x, n)| (obstacle.distance(x), -n.dot(&obstacle.normal(x)), x));
        let seen: Vec<(f64, f64, &Vector<D>)> = seen.collect();
        let Some(&(distance, _, x)) = seen.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        let faces = seen
            .iter()
            .fold(-1.0, |most: f64, (_, faces, _)| most.max(*faces));
        let finding = |kind| Finding::new(Severity::Warning, kind, &names).at(x);
        let what = format!("obstacle `{}`", names[1]);
        let (reach, motion) = match setup.contact.geometry {
            Geometry::Reference => (setup.contact.reach, 0.0),
            Geometry::Current => (
                setup.contact.reach,
                relative_motion(setup.scene, [body, body]) + setup.scene.obstacle_way(),
            ),
        };
        if faces < FACES {
            report.add(
                finding(FindingKind::FacingAway)
                    .measured(faces, FACES)
                    .says(
                        format!(
                            "no node of the boundary of body `{}` on {what} faces it",
                            names[0]
                        ),
                        "check the boundary, and which side of the obstacle is its outside",
                    ),
            );
        } else if distance > reach + motion {
            report.add(finding(FindingKind::OutOfReach).measured(distance, reach).says(
                format!(
                    "{what} is {distance:.3e} away from body `{}`, further than the search radius of {reach:.3e} and \
                     what is prescribed: loads alone could bring them together",
                    names[0]
                ),
                "set `Scene::reach`, move them together, or leave out the obstacle",
            ));
        }
    }
}
