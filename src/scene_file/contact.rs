//! Contact of a scene file.

use contact_fem::Scene;
use contact_fem::model::{BodyId, Passes, Side};

use super::keys::{PassKeys, SideKeys};
use super::{Error, SceneFile, of};

/// The bodies of a scene by name.
pub(super) struct Bodies<'a> {
    pub(super) names: Vec<&'a str>,
    pub(super) ids: Vec<BodyId>,
}

impl Bodies<'_> {
    /// A boundary of a body, which `part` names.
    pub(super) fn side(&self, part: &str, side: &SideKeys) -> Result<Side, Error> {
        let SideKeys { body, boundary } = side;
        match self.names.iter().position(|name| name == body) {
            Some(k) => Ok(self.ids[k].on(boundary.to_string())),
            None => Err(Error::Part {
                part: part.into(),
                what: format!("there is no body `{body}`: there are {:?}", self.names),
            }),
        }
    }
}

impl SceneFile {
    pub(super) fn add_contacts<const D: usize>(
        &self,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        for (k, keys) in self.keys.contact.iter().enumerate() {
            let part = format!("contact {}", k + 1);
            let first = bodies.side(&part, &keys.first)?;
            let second = bodies.side(&part, &keys.second)?;
            let passes = match keys.passes {
                None | Some(PassKeys::Both) => Passes::Both,
                Some(PassKeys::FirstIsSlave) => Passes::FirstIsSlave,
                Some(PassKeys::SecondIsSlave) => Passes::SecondIsSlave,
            };
            let sides = [first.clone(), second.clone()];
            of(&part, scene.contact_in_passes(first, second, passes))?;
            if let Some(during) = &keys.during {
                let switched = scene.contact_during(&sides[0], &sides[1], during);
                of(&format!("{part}, `during`"), switched)?;
            }
        }
        Ok(())
    }
}
