//! Courses in time: amplitudes, motions and phases.

use contact_core::Phase;
use contact_fem::{Amplitude, Motion};

use super::keys::{AmplitudeKeys, MotionKeys, PhaseKeys};
use super::{Error, SceneFile, of, vector};

pub(super) fn amplitude(part: &str, keys: Option<&AmplitudeKeys>) -> Result<Amplitude, Error> {
    match keys {
        None => Ok(Amplitude::proportional()),
        Some(AmplitudeKeys::Constant(value)) => Ok(Amplitude::constant(*value)),
        Some(AmplitudeKeys::Table(pairs)) => of(part, Amplitude::table(pairs)),
    }
}

/// The motions one after the other; `None` without any.
pub(super) fn motion<const D: usize>(
    part: &str,
    all: &[MotionKeys],
) -> Result<Option<Motion<D>>, Error> {
    let mut whole: Option<Motion<D>> = None;
    for keys in all {
        let wrong = |what: &str| Error::Part {
            part: part.into(),
            what: format!("its motion {what}"),
        };
        let one = match (&keys.translation, keys.rotation, &keys.centre) {
            (Some(by), None, None) if keys.axis.is_empty() => {
                of(part, Motion::translation(vector(part, "translation", by)?))?
            }
            (None, Some(angle), Some(centre)) => {
                let centre = vector(part, "centre", centre)?;
                of(part, Motion::rotation_along(&keys.axis, centre, angle))?
            }
            (None, Some(_), None) => return Err(wrong("turns about no point: give it a `centre`")),
            _ => {
                return Err(wrong(
                    "is a `translation`, or a `rotation` (radians) with a `centre`, and in space an `axis`",
                ));
            }
        };
        let one = one.driven_by(amplitude(part, keys.amplitude.as_ref())?);
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
            return Err(Error::Part {
                part: "the scene".into(),
                what,
            });
        }
        let phase = |keys: &PhaseKeys| {
            let phase = Phase::new(&keys.name, keys.until, keys.increments);
            match (keys.least_step, keys.largest_step) {
                (None, None) => Ok(phase),
                (Some(least), Some(largest)) => Ok(phase.adaptive(least, largest)),
                _ => Err(Error::Part {
                    part: format!("phase {}", keys.name),
                    what: "adaptive steps need `least-step` and `largest-step`".into(),
                }),
            }
        };
        self.keys.phase.iter().map(phase).collect()
    }
}
