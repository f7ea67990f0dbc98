//! Motions against the search radius.

use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::model::{Body, Geometry, Scene};
use crate::tensor::Vector;

/// Finds pairs whose bodies are moved further than the search radius. How many increments that takes is known
/// before a run, whether it has them is not: [`at_increments`] tells.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    if setup.contact.geometry == Geometry::Reference {
        return;
    }
    let reach = setup.contact.reach;
    for pair in setup.pairs {
        let bodies = [&pair.first, &pair.second].map(|side| side.body.index());
        let motion = relative_motion(setup.scene, bodies);
        if motion > reach {
            let names = bodies.map(|body| &setup.scene.names()[body]);
            let finding = Finding::new(Severity::Note, FindingKind::LongStep, &names);
            let finding = finding.measured(motion, reach);
            let increments = (motion / reach).ceil();
            report.add(finding.says(
                format!(
                    "bodies `{}` and `{}` are moved {motion:.3e} against each other, further than the search \
                     radius of {reach:.3e}",
                    names[0], names[1]
                ),
                format!("take {increments} load increments or more, or set `Scene::reach`"),
            ));
        }
    }
}

/// The findings of a run in so many increments: a step that is longer than the search radius is a warning, and
/// a shorter one no finding.
pub(in crate::model) fn at_increments(findings: &[Finding], increments: usize) -> Vec<Finding> {
    let now = |finding: &Finding| {
        let mut finding = finding.clone();
        if finding.kind == FindingKind::LongStep {
            finding.value /= increments.max(1) as f64;
            if finding.value <= finding.limit {
                return None;
            }
            finding.severity = Severity::Warning;
        }
        Some(finding)
    };
    let mut findings: Vec<Finding> = findings.iter().filter_map(now).collect();
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

/// The load factors at which what is prescribed to two bodies is looked at, see [`Body::times`].
pub(super) fn times<const D: usize>(bodies: [&Body<D>; 2]) -> Vec<f64> {
    let mut times = bodies.map(Body::times).concat();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// The largest relative displacement (UL) of two bodies that is prescribed at any load factor; a body without prescribed
/// displacements along an axis counts as at rest along it.
pub(super) fn relative_motion<const D: usize>(scene: &Scene<D>, bodies: [usize; 2]) -> f64 {
    let bodies = bodies.map(|body| &scene.bodies()[body]);
    let motions = times(bodies)
        .into_iter()
        .map(|t| relative_motion_at(bodies, t));
    motions.fold(0.0, f64::max)
}

/// The same at the load factor `t`.
fn relative_motion_at<const D: usize>(bodies: [&Body<D>; 2], t: f64) -> f64 {
    let [first, second] = bodies.map(|body| {
        let values = body.prescribed_values(t);
        let range = |i: usize| {
            let values = values.iter().skip(i).step_by(D).flatten();
            let range = |(low, high): (f64, f64), v: &f64| (low.min(*v), high.max(*v));
            match values.fold((f64::INFINITY, f64::NEG_INFINITY), range) {
                (low, high) if low <= high => (low, high),
                _ => (0.0, 0.0),
            }
        };
        std::array::from_fn::<_, D, _>(range)
    });
    let apart = |i: usize| (first[i].1 - second[i].0).max(second[i].1 - first[i].0);
    Vector::<D>::from_fn(|i, _| apart(i)).norm()
}
