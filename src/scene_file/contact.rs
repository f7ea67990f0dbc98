//! Contact of a scene file.

use contact_fem::Scene;
use contact_fem::model::{BodyId, Passes, Side, Tie, TiedSlave};

use super::keys::{ContactKeys, PassKeys, SideKeys, TiedSlaveKeys};
use super::place::Place;
use super::program::amplitude;
use super::{Error, SceneFile};

/// The bodies of a scene by name.
pub(super) struct Bodies<'a> {
    pub(super) names: Vec<&'a str>,
    pub(super) ids: Vec<BodyId>,
}

impl Bodies<'_> {
    /// A body by its name, which is at `place`.
    pub(super) fn named(&self, place: &Place<'_>, body: &str) -> Result<BodyId, Error> {
        match self.names.iter().position(|name| *name == body) {
            Some(k) => Ok(self.ids[k]),
            None => Err(place.wrong(format!(
                "there is no body `{body}`: there are {:?}",
                self.names
            ))),
        }
    }

    /// A boundary of a body of the scene, at `place`.
    pub(super) fn side<const D: usize>(
        &self,
        scene: &Scene<D>,
        place: &Place<'_>,
        side: &SideKeys,
    ) -> Result<Side, Error> {
        let body = self.named(place, &side.body)?;
        let name = side.boundary.to_string();
        place.of(scene.bodies()[body.index()].mesh().boundary(&name))?;
        Ok(body.on(name))
    }
}

impl SideKeys {
    fn is(&self, other: &SideKeys) -> bool {
        self.body == other.body && self.boundary.to_string() == other.boundary.to_string()
    }
}

impl SceneFile {
    pub(super) fn add_contacts<const D: usize>(
        &self,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        for (k, keys) in self.keys.contact.iter().enumerate() {
            let place = self.contact_place(k);
            let mut before = self.keys.contact[..k].iter();
            if let Some(other) = before.position(|other| other.is_of(keys)) {
                let line = self.contact_place(other).line();
                return Err(place.wrong(format!(
                    "contact {}, line {line}, has these sides already: leave one of them out",
                    other + 1
                )));
            }
            keys.add(&place, scene, bodies)?;
        }
        Ok(())
    }

    pub(super) fn contact_place(&self, k: usize) -> Place<'_> {
        let name = format!("contact {}", k + 1);
        self.place().part("contact", k, name)
    }

    pub(super) fn tie_place(&self, k: usize) -> Place<'_> {
        self.place().part("tie", k, format!("tie {}", k + 1))
    }

    pub(super) fn add_ties<const D: usize>(
        &self,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        for (k, keys) in self.keys.tie.iter().enumerate() {
            let place = self.tie_place(k);
            if keys.amplitude.is_some() && keys.jump.is_none() && keys.preload.is_none() {
                let what =
                    "is the course of a `jump` or a `preload`, and there is none: leave it out";
                return Err(place.key("amplitude").wrong(what));
            }
            let tie = Tie {
                first: bodies.side(scene, &place.key("first"), &keys.first)?,
                second: bodies.side(scene, &place.key("second"), &keys.second)?,
                slave: match keys.slave {
                    None | Some(TiedSlaveKeys::Finer) => TiedSlave::Finer,
                    Some(TiedSlaveKeys::First) => TiedSlave::First,
                    Some(TiedSlaveKeys::Second) => TiedSlave::Second,
                },
                tolerance: keys.tolerance.unwrap_or(Tie::TOLERANCE),
                jump: match &keys.jump {
                    None => Vec::new(),
                    Some(jump) => place.key("jump").vector::<D>(jump)?.to_vec(),
                },
                preload: match &keys.preload {
                    None => Vec::new(),
                    Some(force) => place.key("preload").vector::<D>(force)?.to_vec(),
                },
                amplitude: amplitude(&place.key("amplitude"), keys.amplitude.as_ref())?,
            };
            place.of(scene.tie_as(tie))?;
        }
        Ok(())
    }
}

impl ContactKeys {
    /// The two sides that may touch.
    fn sides(&self) -> Option<[&SideKeys; 2]> {
        match (&self.first, &self.second, &self.itself) {
            (Some(first), Some(second), _) => Some([first, second]),
            (None, None, Some(side)) => Some([side, side]),
            _ => None,
        }
    }

    /// Whether two contacts have the same sides.
    fn is_of(&self, other: &ContactKeys) -> bool {
        match (self.sides(), other.sides()) {
            (Some([a, b]), Some([c, d])) => (a.is(c) && b.is(d)) || (a.is(d) && b.is(c)),
            _ => false,
        }
    }

    /// All sides that it names.
    pub(super) fn all_sides(&self) -> impl Iterator<Item = &SideKeys> {
        let named = [&self.first, &self.second, &self.itself];
        named.into_iter().flatten().chain(&self.surfaces)
    }

    fn add<const D: usize>(
        &self,
        place: &Place<'_>,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        if let (Some(_), true) = (self.passes, self.first.is_none()) {
            let what = "`passes` is for `first` and `second`: leave it out";
            return Err(place.key("passes").wrong(what));
        }
        if let (Some(_), true) = (self.offset, self.first.is_none()) {
            let what = "`offset` is for `first` and `second`: leave it out";
            return Err(place.key("offset").wrong(what));
        }
        if let (Some(_), false) = (self.friction, self.surfaces.is_empty()) {
            let what = "`friction` is for `first` and `second`, or for `self`: leave it out";
            return Err(place.key("friction").wrong(what));
        }
        if let (Some(_), true) = (&self.during, self.first.is_none()) {
            let what = "`during` is for `first` and `second`: leave it out";
            return Err(place.key("during").wrong(what));
        }
        match (&self.first, &self.second, &self.itself, &self.surfaces[..]) {
            (Some(first), Some(second), None, []) if first.is(second) => {
                let what = format!(
                    "`first` and `second` are one boundary: give `self = [\"{}\", …]` in their place if it may touch itself, or name \
                     another one",
                    second.body
                );
                Err(place.key("second").wrong(what))
            }
            (Some(first), Some(second), None, []) => {
                let first = bodies.side(scene, &place.key("first"), first)?;
                let second = bodies.side(scene, &place.key("second"), second)?;
                let passes = match self.passes {
                    None | Some(PassKeys::Both) => Passes::Both,
                    Some(PassKeys::FirstIsSlave) => Passes::FirstIsSlave,
                    Some(PassKeys::SecondIsSlave) => Passes::SecondIsSlave,
                };
                let sides = [first.clone(), second.clone()];
                place.of(scene.contact_in_passes(first, second, passes))?;
                if let Some(offset) = self.offset {
                    let at = place.key("offset");
                    at.of(scene.contact_offset(&sides[0], &sides[1], offset))?;
                }
                if let Some(friction) = self.friction {
                    let at = place.key("friction");
                    at.of(scene.contact_friction(&sides[0], &sides[1], friction))?;
                }
                if let Some(during) = &self.during {
                    let at = place.key("during");
                    at.of(scene.contact_during(&sides[0], &sides[1], &during.0))?;
                }
                Ok(())
            }
            (None, None, Some(side), []) => {
                let at = place.key("self");
                let side = bodies.side(scene, &at, side)?;
                at.of(scene.self_contact(side.clone()))?;
                match self.friction {
                    None => Ok(()),
                    Some(friction) => {
                        let at = place.key("friction");
                        at.of(scene.contact_friction(&side, &side, friction))
                    }
                }
            }
            (None, None, None, [_, ..]) => {
                for (k, side) in self.surfaces.iter().enumerate() {
                    let at = place.entry("surfaces", k);
                    let side = bodies.side(scene, &at, side)?;
                    at.of(scene.contact_surface(side))?;
                }
                Ok(())
            }
            _ => Err(place.wrong(
                "give it `first` and `second`, or `self` alone for what may touch itself, or `surfaces` alone for what may \
                 touch anything of another body",
            )),
        }
    }
}
