//! Courses in time: amplitudes, motions and phases.

use contact_core::Phase;
use contact_fem::{Amplitude, Motion};

use super::keys::{AmplitudeKeys, MotionKeys, PhaseKeys};
use super::place::Place;
use super::{Error, SceneFile};

/// The amplitude at `place`; without one, in proportion to the load factor.
pub(super) fn amplitude(
    place: &Place<'_>,
    keys: Option<&AmplitudeKeys>,
) -> Result<Amplitude, Error> {
    match keys {
        None => Ok(Amplitude::proportional()),
        Some(AmplitudeKeys::Constant(value)) => Ok(Amplitude::constant(*value)),
        Some(AmplitudeKeys::Table(pairs)) => place.of(Amplitude::table(pairs)),
    }
}

/// The motions one after the other; `None` without any.
pub(super) fn motion<const D: usize>(
    place: &Place<'_>,
    all: &[MotionKeys],
) -> Result<Option<Motion<D>>, Error> {
    let mut whole: Option<Motion<D>> = None;
    for (k, keys) in all.iter().enumerate() {
        let at = place.entry("motion", k);
        let wrong = |what: &str| at.wrong(format!("its motion {what}"));
        let one = match (&keys.translation, keys.rotation, &keys.centre) {
            (Some(by), None, None) if keys.axis.is_empty() => {
                let at = at.key("translation");
                at.of(Motion::translation(at.vector(by)?))?
            }
            (None, Some(angle), Some(centre)) => {
                let centre = at.key("centre").vector(centre)?;
                at.of(Motion::rotation_along(&keys.axis, centre, angle))?
            }
            (None, Some(_), None) => return Err(wrong("turns about no point: give it a `centre`")),
            _ => {
                return Err(wrong(
                    "is a `translation`, or a `rotation` (radians) with a `centre`, and in space an `axis`",
                ));
            }
        };
        let course = amplitude(&at.key("amplitude"), keys.amplitude.as_ref())?;
        let one = one.driven_by(course);
        whole = Some(match whole {
            Some(before) => before.then(one),
            None => one,
        });
    }
    Ok(whole)
}

impl SceneFile {
    /// The phases of the run, without which it has one.
    pub(super) fn phases(&self) -> Result<Vec<Phase>, Error> {
        if let (Some(increments), false) = (self.keys.increments, self.keys.phase.is_empty()) {
            let what = format!(
                "`increments = {increments}` has no effect where there are phases: give each its own"
            );
            return Err(self.place().key("increments").wrong(what));
        }
        let phase = |(k, keys): (usize, &PhaseKeys)| {
            let phase = Phase::new(&keys.name, keys.until, keys.increments);
            match (keys.least_step, keys.largest_step) {
                (None, None) => Ok(phase),
                (Some(least), Some(largest)) => Ok(phase.adaptive(least, largest)),
                _ => {
                    let name = format!("phase {}", keys.name);
                    let place = self.place().part("phase", k, name);
                    Err(place.wrong("adaptive steps need `least-step` and `largest-step`"))
                }
            }
        };
        self.keys.phase.iter().enumerate().map(phase).collect()
    }
}
