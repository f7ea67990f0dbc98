//! Tied boundaries that are not quite in one place.

use super::limits::{TIED_APART, TOUCHES};
use super::{Finding, FindingKind, Report, Setup, Severity};

/// Finds ties whose sides are apart: a note, or a warning where bodies may turn and the tie is stretched by that.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let names = setup.scene.names();
    for tied in setup.ties.apart() {
        let share = tied.distance / tied.size;
        if !(share > TOUCHES) {
            continue;
        }
        let mut bodies = tied.bodies.iter().map(|&b| &setup.scene.bodies()[b]);
        let turns = !bodies.all(crate::model::Body::is_small_strain);
        let severity = match turns && share > TIED_APART {
            true => Severity::Warning,
            false => Severity::Note,
        };
        let [first, second] = tied.bodies.map(|b| &names[b]);
        let finding = Finding::new(severity, FindingKind::TiedApart, &[first, second]);
        let finding = finding
            .at(&tied.at)
            .measured(tied.distance, TIED_APART * tied.size);
        report.add(finding.says(
            format!(
                "the tied boundaries of bodies `{first}` and `{second}` are {:.3e} apart; displacements are equal across the \
                 gap, so that a rotation stretches what is tied by about the gap times its angle",
                tied.distance
            ),
            "leave the bodies there if only chords of curved surfaces are apart and rotations are small; otherwise move the bodies to each \
             other, or refine the surfaces",
        ));
    }
}
