//! Bodies that start inside each other.

use super::limits::TOUCHES;
use super::{Finding, FindingKind, Report, Setup, Severity, overlap};
use crate::audit::Overlap;
use crate::model::{InitialGaps, Overlaps};

/// Checks that no bodies start deeper inside each other than the tolerance, and finds those that start less deep or
/// have no contact pair.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let inside = overlap::deepest(setup);
    let is_refused = report.take(overlap::check(setup, &inside)).is_none();
    let names = setup.scene.names();
    if is_refused {
        return;
    }
    for (a, b, found) in inside {
        let size = found.size;
        if found.depth > TOUCHES * size {
            let tolerance = overlap::granted(setup, [a, b], size);
            let note = Finding::new(
                Severity::Note,
                FindingKind::Interference,
                &[&names[a], &names[b]],
            );
            let note = note.at(&found.x).measured(found.depth, tolerance);
            let (becomes, remedy) = match setup.scene.initial_gaps {
                _ if setup.contact.lets_through([a, b], 0.0) => (
                    "where their contact begins to count, the load pushes the bodies apart if the rest of the overlap is within a fifth of the facets",
                    "leave the bodies there if they are apart by then; otherwise move them apart",
                ),
                InitialGaps::Refuse => (
                    "the first load step pushes the bodies apart",
                    "leave the bodies there if only chords of curved surfaces overlap; otherwise move them apart",
                ),
                InitialGaps::Resolve => (
                    "the load pushes the bodies apart step by step",
                    "leave the bodies there if an interference fit is meant; otherwise move them apart",
                ),
                InitialGaps::Adjust => (
                    "the overlap stays and causes no force",
                    "leave the bodies there if they are to touch; otherwise move them apart",
                ),
            };
            report.add(note.says(
                format!(
                    "body `{}` starts {:.3e} inside body `{}`; {becomes}",
                    names[a], found.depth, names[b]
                ),
                remedy,
            ));
        }
    }
    let is_taken = |bodies: [usize; 2]| {
        setup.scene.initial_gaps != InitialGaps::Refuse && setup.contact.is_pair(bodies)
    };
    // of obstacles, another check tells
    let is_obstacle = |[_, second]: [usize; 2]| second >= names.len();
    let granted = |bodies| match is_taken(bodies) || is_obstacle(bodies) {
        true => f64::INFINITY,
        false => 0.0,
    };
    let found = match setup.scene.overlaps {
        Overlaps::Refused => setup.audit.deep_overlap(&setup.kinematics.X, granted),
        Overlaps::Allowed => None,
    };
    if let Some(overlap) = found {
        let [first, second] = overlap.bodies.map(|body| &names[body]);
        let finding = Finding::new(
            Severity::Warning,
            FindingKind::Interference,
            &[first, second],
        );
        let finding = finding.at(&overlap.at);
        report.add(finding.measured(overlap.relative, Overlap::<D>::LIMIT).says(
            format!(
                "body `{first}` starts {:.3e} inside body `{second}` where no contact pair parts them",
                overlap.depth
            ),
            "move them apart, or set `Scene::overlaps` if they are to pass through each other",
        ));
    } else if setup.scene.overlaps == Overlaps::Refused {
        report.take(overlap::check_others(setup));
    }
}
