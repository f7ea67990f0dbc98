//! Bodies that start inside each other.

use super::limits::TOUCHES;
use super::{Finding, FindingKind, Report, Setup, Severity, overlap};
use crate::audit::Overlap;
use crate::model::Overlaps;

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
            let tolerance = setup.scene.overlap_tolerance * size;
            let note = Finding::new(
                Severity::Note,
                FindingKind::Interference,
                &[&names[a], &names[b]],
            );
            let note = note.at(&found.x).measured(found.depth, tolerance);
            report.add(note.says(
                format!(
                    "body `{}` starts {:.3e} inside body `{}`; the first load step pushes it out",
                    names[a], found.depth, names[b]
                ),
                "nothing, if chords of curved surfaces overlap so; otherwise move the bodies apart",
            ));
        }
    }
    let deep = |overlap: &Overlap<D>| overlap.relative > Overlap::<D>::LIMIT;
    let found = match setup.scene.overlaps {
        Overlaps::Refused => setup.audit.overlap(&setup.kinematics.X).filter(deep),
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
    }
}
