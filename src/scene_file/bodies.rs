//! Bodies of a scene file: meshes, laws, supports and loads.

use contact_fem::element::{Element, P1, P2};
use contact_fem::{Body, Mesh, MeshFile, Scene};

use super::contact::Bodies;
use super::keys::{BodyKeys, SupportKeys, TractionKeys};
use super::laws;
use super::program::{amplitude, motion};
use super::{Error, SceneFile, of, vector};

impl SceneFile {
    /// Whether a quadratic body has a side that is curved by more than round-off of a file.
    ///
    /// # Errors
    /// As [`SceneFile::scene`].
    pub fn is_curved<const D: usize>(&self) -> Result<bool, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        for keys in &self.keys.body {
            if self.mesh::<D>(keys)?.is_curved(1e-9) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    pub(super) fn mesh_file(&self, body: &BodyKeys) -> Result<MeshFile, Error> {
        let part = format!("body {}", body.name);
        of(&part, MeshFile::read(self.folder.join(&body.mesh)))
    }

    /// The mesh of a body, of the order that the scene asks for.
    fn mesh<const D: usize>(&self, keys: &BodyKeys) -> Result<Mesh<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let part = format!("body {}", keys.name);
        let file = self.mesh_file(keys)?;
        let mesh = match &keys.region {
            Some(_) if !keys.laws.is_empty() => {
                let what = "its `laws` name regions of the whole mesh: leave `region` out".into();
                return Err(Error::Part { part, what });
            }
            Some(region) => of(&part, file.body::<D>(&region.to_string()))?,
            None if !keys.laws.is_empty() => of(&part, file.with_regions::<D>())?,
            None => {
                let mut all = of(&part, file.bodies::<D>())?;
                match all.len() {
                    1 => all.swap_remove(0).1,
                    _ => {
                        let names: Vec<String> = all.into_iter().map(|(name, _)| name).collect();
                        let names = names.join(", ");
                        let what = format!(
                            "its mesh has the regions {names}: choose one by `region`, or name all in `laws`"
                        );
                        return Err(Error::Part { part, what });
                    }
                }
            }
        };
        let mesh = if keys.quadratic {
            mesh.quadratic()
        } else {
            mesh
        };
        Ok(match self.is_straight {
            true => mesh.straight(),
            false => mesh,
        })
    }

    /// Adds all bodies to the scene.
    pub(super) fn add_bodies<const D: usize>(
        &self,
        scene: &mut Scene<D>,
    ) -> Result<Bodies<'_>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let (mut names, mut ids) = (Vec::new(), Vec::new());
        for keys in &self.keys.body {
            ids.push(scene.add(&keys.name, self.body(keys)?));
            names.push(keys.name.as_str());
        }
        Ok(Bodies { names, ids })
    }

    fn body<const D: usize>(&self, keys: &BodyKeys) -> Result<Body<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let part = format!("body {}", keys.name);
        // files of fields are called after the body
        if keys.name.contains(['/', '\\']) {
            let what = "a name has no `/` or `\\`, since files are called after it".into();
            return Err(Error::Part { part, what });
        }
        let mut body = laws::body(&part, keys, self.mesh(keys)?)?;
        for name in &keys.symmetry {
            of(&part, body.symmetry(&name.to_string()))?;
        }
        for support in &keys.supports {
            support.hold(&part, &mut body)?;
        }
        keys.load(&part, &mut body)?;
        keys.add_to_boundaries(&part, &mut body)?;
        Ok(body)
    }
}

impl BodyKeys {
    /// Pressures and springs, which act on boundaries where they are.
    fn add_to_boundaries<const D: usize>(
        &self,
        part: &str,
        body: &mut Body<D>,
    ) -> Result<(), Error> {
        for (k, keys) in self.pressures.iter().enumerate() {
            let part = format!("{part}, pressures, entry {}", k + 1);
            let course = amplitude(&part, keys.amplitude.as_ref())?;
            of(
                &part,
                body.pressure_in_time(&keys.on.to_string(), keys.pressure, course),
            )?;
        }
        for (k, keys) in self.foundations.iter().enumerate() {
            let on = keys.on.to_string();
            let springs = match keys.normal_only {
                true => body.normal_foundation(&on, keys.stiffness),
                false => body.foundation(&on, keys.stiffness),
            };
            of(&format!("{part}, foundations, entry {}", k + 1), springs)?;
        }
        Ok(())
    }

    /// Tractions and body force.
    fn load<const D: usize>(&self, part: &str, body: &mut Body<D>) -> Result<(), Error> {
        for TractionKeys {
            on,
            force,
            amplitude: course,
        } in &self.tractions
        {
            let force = vector(part, "force", force)?;
            let course = amplitude(part, course.as_ref())?;
            of(part, body.traction_in_time(&on.to_string(), force, course))?;
        }
        let course = amplitude(part, self.body_force_amplitude.as_ref())?;
        match &self.body_force {
            Some(force) => {
                let force = vector(part, "body-force", force)?;
                of(part, body.body_force_in_time(force, course)).map(|_| ())
            }
            None if self.body_force_amplitude.is_some() => Err(Error::Part {
                part: part.into(),
                what: "`body-force-amplitude` has no effect without `body-force`".into(),
            }),
            None => Ok(()),
        }
    }
}

impl SupportKeys {
    fn hold<const D: usize>(&self, part: &str, body: &mut Body<D>) -> Result<(), Error> {
        let wrong = |what: String| Error::Part {
            part: part.into(),
            what,
        };
        let all = [self.x, self.y, self.z];
        if D == 2 && self.z.is_some() {
            return Err(wrong("a support in the plane has no `z`".into()));
        }
        let name = self.on.as_ref().map(ToString::to_string);
        let components = std::array::from_fn(|i| all[i]);
        let moves = motion(part, &self.motion)?;
        let has_values = all.iter().any(Option::is_some);
        let what = match (has_values, &moves, &self.amplitude, &name) {
            (false, None, ..) => "holds nothing: give it x, y, z or `motion`",
            (true, Some(_), ..) => "has components and a motion: give it one of them",
            (_, Some(_), Some(_), _) => {
                "has a motion, which has amplitudes of its own: leave `amplitude` out"
            }
            (true, None, Some(_), None) => "has an amplitude: name its boundary by `on`",
            _ => "",
        };
        if !what.is_empty() {
            let place = match &name {
                Some(name) => format!("on {name}"),
                None => "without `on`".into(),
            };
            return Err(wrong(format!("its support {place} {what}")));
        }
        let held = match (name, moves) {
            (Some(name), Some(moves)) => body.prescribe_motion(&name, moves),
            (None, Some(moves)) => body.prescribe_motion_of_all(moves),
            (Some(name), None) => {
                let course = amplitude(part, self.amplitude.as_ref())?;
                body.prescribe_in_time(&name, components, course)
            }
            (None, None) => body.prescribe_all(components),
        };
        of(part, held).map(|_| ())
    }
}
