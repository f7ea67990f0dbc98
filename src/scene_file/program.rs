//! Courses in time: amplitudes, motions and phases.

use contact_core::{LoadSteps, Phase};
use contact_fem::{Amplitude, Motion};

use super::keys::{AmplitudeKeys, Motions};
use super::place::Place;
use super::{Error, SceneFile};

/// The amplitude at `place`; without one, in proportion to time.
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
    all: &Motions,
) -> Result<Option<Motion<D>>, Error> {
    let mut whole: Option<Motion<D>> = None;
    for (k, keys) in all.0.iter().enumerate() {
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
        let mut phases = Vec::new();
        for (k, keys) in self.keys.phase.iter().enumerate() {
            let name = format!("phase {}", keys.name);
            let place = self.place().part("phase", k, name);
            let mut before = self.keys.phase[..k].iter();
            if before.any(|other| other.name == keys.name) {
                let what = "a phase before it has this name: give it another one, by which tables tell them apart";
                return Err(place.key("name").wrong(what));
            }
            let phase = Phase::new(&keys.name, keys.until, keys.increments);
            phases.push(match (keys.least_step, keys.largest_step) {
                (None, None) => phase,
                (Some(least), Some(largest)) => phase.adaptive(least, largest),
                (Some(_), None) => {
                    let what = "adaptive steps need `largest-step`, too: give it, or leave `least-step` out";
                    return Err(place.key("least-step").wrong(what));
                }
                (None, Some(_)) => {
                    let what = "adaptive steps need `least-step`, too: give it, or leave `largest-step` out";
                    return Err(place.key("largest-step").wrong(what));
                }
            });
            // those before are sound
            let steps = LoadSteps {
                phases: phases.clone(),
                ..LoadSteps::default()
            };
            if let Err(why) = steps.validate() {
                let key = match &why {
                    contact_core::Error::Setting { name, .. } => match *name {
                        "phase until" => "until",
                        "phase least step" => "least-step",
                        "phase largest step" => "largest-step",
                        _ => "increments",
                    },
                    _ => "until",
                };
                return place.key(key).of(Err(why.into()));
            }
        }
        Ok(phases)
    }
}

impl AmplitudeKeys {
    /// Whether it has the same value at all times from `from` to `to`.
    pub(super) fn is_constant(&self, [from, to]: [f64; 2]) -> bool {
        let AmplitudeKeys::Table(pairs) = self else {
            return true;
        };
        // that the table is sound was checked
        let Ok(amplitude) = Amplitude::table(pairs) else {
            return false;
        };
        let within = pairs.iter().map(|(t, _)| *t);
        let mut within = within.filter(|t| (from..=to).contains(t)).chain([to]);
        within.all(|t| amplitude.at(t) == amplitude.at(from))
    }
}
