//! What the library tells, with the place in the file that it is about, and in the words of a file.

use contact_fem::element::{Element, P1, P2};
use contact_fem::model::{Finding, FindingKind, Problem, Severity};
use contact_fem::{Error as Refused, Scene};

use super::keys::{BodyKeys, Name, SupportKeys};
use super::place::Place;
use super::{Error, SceneFile, in_keys};

impl SceneFile {
    /// The problem of the scene, with findings that name their places in the file.
    ///
    /// # Errors
    /// As [`SceneFile::scene`] and [`Scene::problem`].
    pub fn problem<const D: usize>(&self) -> Result<Problem<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let problem = self.scene::<D>()?.problem();
        let mut problem = problem.map_err(|why| self.refused(why))?;
        let findings = problem.findings_mut();
        findings.iter_mut().for_each(|own| *own = self.told(own));
        findings.extend(self.revolved_motions());
        Ok(problem)
    }

    /// All that is wrong with a scene of this file: the errors for which [`SceneFile::problem`] refuses it.
    pub fn errors<const D: usize>(&self, scene: &Scene<D>) -> Vec<Error> {
        let errors = scene.errors().into_iter();
        errors.map(|why| self.refused(why)).collect()
    }

    /// An error of the library about the scene or its run, with its place in the file.
    pub fn refused(&self, error: Refused) -> Error {
        self.place_of(&error).refused(error)
    }

    /// A finding, with its place in the file and in the words of a file.
    pub fn told(&self, finding: &Finding) -> Finding {
        let place = self.place_of_finding(finding).named();
        let mut told = finding.clone();
        told.what = format!("{place}: {}", in_keys(&finding.what));
        told.remedy = in_keys(&finding.remedy).into_owned();
        told
    }

    /// Notes motions of bodies of revolution that are rigid in the half-plane alone.
    fn revolved_motions(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for (k, body) in self.keys.body.iter().enumerate() {
            if !body.revolution {
                continue;
            }
            for (j, support) in body.supports.iter().enumerate() {
                let is_rigid = support.motion.0.iter().all(|motion| {
                    let way = motion.translation.as_ref().and_then(|way| way.first());
                    motion.rotation.is_none() && way.is_none_or(|r| *r == 0.0)
                });
                if is_rigid {
                    continue;
                }
                let place = self.body_place(k).entry("supports", j).key("motion");
                let note = Finding::new(Severity::Note, FindingKind::Revolution, &[&body.name]);
                findings.push(note.says(
                    format!(
                        "{}: the motion is not along the axis alone: around the axis, it widens, narrows or turns inside out what it moves",
                        place.named()
                    ),
                    "leave it as it is if that is meant; otherwise move it along z, the axis, alone",
                ));
            }
        }
        findings
    }

    /// The later one of two supports on these boundaries of one body, if only one body has such.
    fn supports_on(&self, on: &[String; 2]) -> Place<'_> {
        let last = |body: &BodyKeys| {
            let is_on = |name: &String| {
                let mut all = body.supports.iter();
                all.rposition(|own| own.may_be_called(name))
            };
            let [first, second] = [is_on(&on[0])?, is_on(&on[1])?];
            Some(first.max(second))
        };
        let bodies = self.keys.body.iter().enumerate();
        let mut found = bodies.filter_map(|(k, body)| Some((k, last(body)?)));
        match (found.next(), found.next()) {
            (Some((k, j)), None) => self.body_place(k).entry("supports", j),
            _ => self.place(),
        }
    }

    fn place_of(&self, error: &Refused) -> Place<'_> {
        match error {
            Refused::InPhase { error, .. } => self.place_of(error),
            Refused::BodyExists {
                bodies: [_, body], ..
            }
            | Refused::UnnamedBody { body } => self.body_place(*body).key("name"),
            Refused::UnnamedObstacle { obstacle } => self.obstacle_place(*obstacle).key("name"),
            Refused::ObstacleExists { name } => {
                let mut all = self.keys.obstacle.iter();
                let last = all.rposition(|keys| keys.name == *name);
                last.map_or_else(|| self.place(), |k| self.obstacle_place(k).key("name"))
            }
            Refused::MixedRevolution { plane, .. } => self.of_body(plane).key("revolution"),
            Refused::Excessive { body, what, .. } => match what.contains("displacement") {
                true => self.of_body(body).key("supports"),
                false => self.of_body(body),
            },
            Refused::FarFromOrigin { body, .. } => self.of_body(body).key("mesh"),
            Refused::LawDiffers { body, .. } => self.of_body(body).key("law"),
            Refused::GeometryNotChosen { large, .. } => self.of_body(large).key("law"),
            Refused::FreeRim { body, boundary, .. } => self.load_on(body, "pressures", boundary),
            Refused::Tie { first, second, .. } => self.of_tie(&format!("{first} and {second}")),
            Refused::ObstacleDistance { obstacle, .. } => self.of_obstacle(obstacle),
            Refused::InsideObstacle { obstacle, .. } => self.of_obstacle(obstacle),
            Refused::Overlap {
                slave: a,
                master: b,
                ..
            }
            | Refused::Crossing {
                first: a,
                second: b,
                ..
            } => {
                let names = [a.clone(), b.clone()];
                let between = self.contact_of(&names, "");
                between.unwrap_or_else(|| self.of_body(b).key("mesh"))
            }
            Refused::Conflict { on, .. } => self.supports_on(on),
            Refused::Unsupported { body, .. } => self.of_body(body).key("supports"),
            Refused::NoSupport | Refused::NothingFree => self.body_place(0).key("supports"),
            Refused::SwitchWithinPhase { what, .. } | Refused::NeverCounts { what, .. } => {
                self.switched(what)
            }
            Refused::Setting { name, .. } => match *name {
                "reach" => self.place().key("reach"),
                "integration" => self.place().key("points"),
                "overlap_tolerance" => self.place().key("overlap-tolerance"),
                "contact_surface" => {
                    let mut all = self.keys.contact.iter();
                    let first = all.position(|keys| !keys.surfaces.is_empty());
                    first.map_or_else(|| self.place(), |k| self.contact_place(k).key("surfaces"))
                }
                _ => self.place(),
            },
            Refused::NotFinite { what, .. } => match quoted(what, "body") {
                Some(body) if what.contains("prescribed") => self.of_body(body).key("supports"),
                Some(body) => self.of_body(body),
                None => self.place(),
            },
            Refused::Core(contact_core::Error::Untreated { .. }) => self.place().key("solver"),
            Refused::Core(contact_core::Error::Setting { name, .. }) => {
                self.place().key(match *name {
                    "max_iterations" => "max-iterations",
                    "ipopt_tolerance" => "ipopt-tolerance",
                    "increments" => "increments",
                    "complementarity" => "complementarity",
                    "penetration" => "penetration",
                    "tolerance" => "tolerance",
                    _ => "solver",
                })
            }
            Refused::Core(contact_core::Error::Ipopt(_)) => self.place().key("ipopt"),
            _ => self.place(),
        }
    }

    fn place_of_finding(&self, finding: &Finding) -> Place<'_> {
        use FindingKind as Kind;
        let (bodies, what) = (&finding.bodies, &finding.what);
        let has_name = |name: &str| bodies.iter().any(|own| own == name);
        let mut obstacles = self.keys.obstacle.iter();
        if let Some(k) = obstacles.position(|keys| has_name(&keys.name)) {
            return self.obstacle_place(k);
        }
        if finding.kind == Kind::TiedApart {
            let mut all = self.keys.tie.iter();
            let is_own = |body: &str| has_name(body);
            let own = all.position(|tie| is_own(&tie.first.body) && is_own(&tie.second.body));
            return own.map_or_else(|| self.place(), |k| self.tie_place(k));
        }
        let Some(first) = bodies.first() else {
            return self.place();
        };
        let key = match finding.kind {
            Kind::FacingAway
            | Kind::OutOfReach
            | Kind::MeshRatio
            | Kind::LongStep
            | Kind::BeyondFacet
            | Kind::InwardNormal
            | Kind::Interference => {
                let between = self.contact_of(bodies, what);
                return between.unwrap_or_else(|| self.of_body(first));
            }
            Kind::EmptyBoundary => "boundaries",
            Kind::FreeMotion | Kind::HeldByContact | Kind::HeldByNothing | Kind::Mechanism => {
                "supports"
            }
            Kind::OpenSeam
            | Kind::ThinBody
            | Kind::Sliver
            | Kind::FarFromOrigin
            | Kind::StraightFacets => "mesh",
            Kind::Locking | Kind::Rotation => "law",
            Kind::Unloaded => {
                let load = [
                    ("traction", "tractions"),
                    ("pressure", "pressures"),
                    ("nodal force", "forces"),
                ];
                let on = quoted(what, "on").unwrap_or_default();
                return match load.iter().find(|(kind, _)| what.contains(kind)) {
                    Some((_, key)) => self.load_on(first, key, on),
                    None => self.of_body(first).key("body-force"),
                };
            }
            _ => return self.of_body(first),
        };
        self.of_body(first).key(key)
    }

    /// A body by its name.
    fn of_body(&self, name: &str) -> Place<'_> {
        let mut all = self.keys.body.iter();
        let own = all.position(|keys| keys.name == name);
        own.map_or_else(|| self.place(), |k| self.body_place(k))
    }

    fn of_obstacle(&self, name: &str) -> Place<'_> {
        let mut all = self.keys.obstacle.iter();
        let own = all.position(|keys| keys.name == name);
        own.map_or_else(|| self.place(), |k| self.obstacle_place(k))
    }

    /// The load of a body on a boundary.
    fn load_on(&self, body: &str, key: &'static str, boundary: &str) -> Place<'_> {
        let on = |keys: &BodyKeys| -> Vec<String> {
            let names: Vec<&Name> = match key {
                "pressures" => keys.pressures.iter().map(|own| &own.on).collect(),
                "tractions" => keys.tractions.iter().map(|own| &own.on).collect(),
                _ => Vec::new(),
            };
            names.into_iter().map(ToString::to_string).collect()
        };
        let place = self.of_body(body);
        let mut all = self.keys.body.iter();
        let names = all.find(|keys| keys.name == body).map(on);
        let own = names.and_then(|names| names.iter().position(|name| name == boundary));
        match own {
            Some(k) => place.entry(key, k),
            None => place.key(key),
        }
    }

    /// The last tie that a text names both sides of: of two that tie the same, the second one is too many.
    fn of_tie(&self, text: &str) -> Place<'_> {
        let mut all = self.keys.tie.iter();
        let is_own = |tie: &super::keys::TieKeys| {
            [&tie.first, &tie.second]
                .iter()
                .all(|side| text.contains(&format!("`{}` of body `{}`", side.boundary, side.body)))
        };
        let own = all.rposition(is_own);
        own.map_or_else(|| self.place(), |k| self.tie_place(k))
    }

    /// The contact of these bodies, of several the one whose boundaries a text names.
    fn contact_of(&self, bodies: &[String], text: &str) -> Option<Place<'_>> {
        let all = self.keys.contact.iter().enumerate();
        let own = all.filter(|(_, keys)| {
            let is_named = |body: &String| keys.all_sides().any(|side| side.body == *body);
            bodies.iter().all(is_named)
        });
        let named = |(_, keys): &(usize, &super::keys::ContactKeys)| {
            let sides = keys.all_sides();
            sides
                .filter(|side| text.contains(&format!("`{}`", side.boundary)))
                .count()
        };
        let mut best: Option<(usize, usize)> = None;
        for own in own {
            let count = named(&own);
            if best.is_none_or(|(_, most)| count > most) {
                best = Some((own.0, count));
            }
        }
        best.map(|(k, _)| self.contact_place(k))
    }

    /// What is switched, as errors call it.
    fn switched(&self, what: &str) -> Place<'_> {
        if let Some(name) = quoted(what, "obstacle") {
            return self.of_obstacle(name).key("during");
        }
        if what.starts_with("the contact") {
            let all = self.keys.contact.iter().enumerate();
            let mut own = all.filter(|(_, keys)| {
                let mut sides = keys.all_sides();
                keys.during.is_some()
                    && sides.all(|side| {
                        what.contains(&format!("`{}` of body `{}`", side.boundary, side.body))
                    })
            });
            return match own.next() {
                Some((k, _)) => self.contact_place(k).key("during"),
                None => self.place(),
            };
        }
        let body = quoted(what, "body").unwrap_or_default();
        let on = quoted(what, "on").unwrap_or_default();
        let place = self.of_body(body);
        let mut all = self.keys.body.iter();
        let supports = all
            .find(|keys| keys.name == body)
            .map(|keys| &keys.supports);
        let switched = supports.into_iter().flatten().enumerate();
        let switched = switched.filter(|(_, support)| support.during.is_some());
        let mut own = switched.filter(|(_, support)| support.may_be_called(on));
        let on_boundary = |(_, support): &(usize, &SupportKeys)| support.on.is_some();
        match (own.next(), own.next()) {
            (Some(first), second) if second.is_none() || on_boundary(&first) => {
                place.entry("supports", first.0).key("during")
            }
            _ => place.key("supports"),
        }
    }
}

/// What is between backquotes behind a word.
fn quoted<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("{word} `"))?;
    rest.split('`').next()
}
