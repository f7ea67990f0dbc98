//! Scenes as text files, which the program `ipopt-contact run` solves.
//!
//! A file is TOML. Meshes are files of their own, named relative to it, in any format that [`MeshFile`] reads. Lengths and forces
//! are in the user's units. A boundary is a label (`1`) or a name (`"top"`). docs/freefem.md lists all keys.
//! ```
//! use ipopt_contact::scene_file::SceneFile;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = std::env::temp_dir().join(format!("scene-file-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//! std::fs::write(folder.join("block.msh"), "4 2 4  0 0 0  1 0 0  1 1 0  0 1 0  1 2 3 0  1 3 4 0  1 2 1  2 3 2  3 4 3  4 1 4")?;
//! let text = r#"
//!     [[body]]
//!     name = "block"
//!     mesh = "block.msh"
//!     law = "linear-elastic"
//!     young = 100.0
//!     poisson = 0.0
//!     supports = [{ on = 4, x = 0.0 }, { on = 3, y = -0.1 }]
//!
//!     [[obstacle]]
//!     name = "floor"
//!     half-space = { point = [0, 0], normal = [0, 1] }
//!     on = [["block", 1]]
//! "#;
//! let file = SceneFile::parse(text, &folder)?;
//! let history = file.simulation()?.run(&mut file.scene::<2>()?.problem()?)?;
//! // a strain of 0.1 on an area of 1
//! let last = history.last().ok_or("not converged")?;
//! assert!((last.energy - 0.5 * 100.0 * 0.1 * 0.1).abs() < 1e-9);
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok(())
//! # }
//! ```

mod run;

use std::fmt;
use std::path::{Path, PathBuf};

use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::model::{Geometry, Integration, Passes, Side};
use contact_fem::{
    Amplitude, Body, LinearElastic, Mesh, MeshFile, MooneyRivlin, Motion, NeoHookean, Obstacle,
    Scene, StVenantKirchhoff, material::Volumetric,
};
use serde::Deserialize;

pub use run::{Departure, Solver};

/// Why a scene file cannot be used. Each contains what is wrong, its value and the remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that is missing or that the system does not read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No TOML, or keys and values that a scene does not have.
    #[error("the scene file: {0}")]
    Text(#[from] toml::de::Error),
    /// A part of the scene whose values do not fit together.
    #[error("{part}: {what}")]
    Part {
        /// The body, contact or obstacle.
        part: String,
        /// What is wrong with it, and the remedy.
        what: String,
    },
    /// What the library refuses.
    #[error("{part}: {source}")]
    Refused {
        /// The body, contact or obstacle.
        part: String,
        /// Why.
        source: Box<contact_fem::Error>,
    },
}

/// The `Display` message: `main` and `unwrap` print an error by `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A scene file.
#[derive(Clone, Debug)]
pub struct SceneFile {
    folder: PathBuf,
    keys: Keys,
    /// Whether curved sides are made straight.
    is_straight: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Keys {
    increments: Option<usize>,
    #[serde(default)]
    phase: Vec<PhaseKeys>,
    solver: Option<Solver>,
    tolerance: Option<f64>,
    departures: Option<Vec<Departure>>,
    goes_on: Option<bool>,
    max_iterations: Option<usize>,
    ipopt_tolerance: Option<f64>,
    points: Option<usize>,
    geometry: Option<Where>,
    reach: Option<f64>,
    body: Vec<BodyKeys>,
    #[serde(default)]
    contact: Vec<ContactKeys>,
    #[serde(default)]
    obstacle: Vec<ObstacleKeys>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Where {
    Reference,
    Current,
}

/// A phase of the run, and bounds of adaptive steps in it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct PhaseKeys {
    name: String,
    until: f64,
    increments: usize,
    least_step: Option<f64>,
    largest_step: Option<f64>,
}

/// A constant, or pairs of time and value with straight lines between them.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum AmplitudeKeys {
    Constant(f64),
    Table(Vec<(f64, f64)>),
}

/// One motion; several follow one another.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MotionKeys {
    translation: Option<Vec<f64>>,
    rotation: Option<f64>,
    centre: Option<Vec<f64>>,
    #[serde(default)]
    axis: Vec<f64>,
    amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct BodyKeys {
    name: String,
    mesh: PathBuf,
    region: Option<Name>,
    #[serde(default)]
    quadratic: bool,
    #[serde(default)]
    averaged_volumes: bool,
    law: Law,
    young: f64,
    poisson: f64,
    share: Option<f64>,
    #[serde(default)]
    symmetry: Vec<Name>,
    #[serde(default)]
    supports: Vec<SupportKeys>,
    #[serde(default)]
    tractions: Vec<TractionKeys>,
    #[serde(default)]
    pressures: Vec<PressureKeys>,
    #[serde(default)]
    foundations: Vec<FoundationKeys>,
    body_force: Option<Vec<f64>>,
    body_force_amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Law {
    LinearElastic,
    NeoHookean,
    StVenantKirchhoff,
    MooneyRivlin,
}

/// A label or a name.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum Name {
    Label(i64),
    Name(String),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SupportKeys {
    on: Option<Name>,
    x: Option<f64>,
    y: Option<f64>,
    z: Option<f64>,
    #[serde(default)]
    motion: Vec<MotionKeys>,
    amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TractionKeys {
    on: Name,
    force: Vec<f64>,
    amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PressureKeys {
    on: Name,
    pressure: f64,
    amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct FoundationKeys {
    on: Name,
    stiffness: f64,
    #[serde(default)]
    normal_only: bool,
}

impl BodyKeys {
    /// Adds what acts on boundaries where they are.
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
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct ContactKeys {
    first: SideKeys,
    second: SideKeys,
    passes: Option<PassKeys>,
    during: Option<Vec<[f64; 2]>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PassKeys {
    Both,
    FirstIsSlave,
    SecondIsSlave,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct ObstacleKeys {
    name: String,
    half_space: Option<HalfSpace>,
    ball: Option<Ball>,
    cavity: Option<Ball>,
    cylinder: Option<Cylinder>,
    bore: Option<Cylinder>,
    cuboid: Option<Cuboid>,
    #[serde(default)]
    motion: Vec<MotionKeys>,
    during: Option<Vec<[f64; 2]>>,
    on: Vec<SideKeys>,
}

impl ObstacleKeys {
    /// The one shape that is given.
    fn shape<const D: usize>(&self, part: &str) -> Result<Obstacle<D>, Error> {
        let mut shapes = Vec::new();
        if let Some(HalfSpace { point, normal }) = &self.half_space {
            let (point, normal) = (
                vector(part, "point", point)?,
                vector(part, "normal", normal)?,
            );
            shapes.push(Obstacle::half_space(point, normal));
        }
        if let Some(Ball { centre, radius }) = &self.ball {
            shapes.push(Obstacle::ball(vector(part, "centre", centre)?, *radius));
        }
        if let Some(Ball { centre, radius }) = &self.cavity {
            shapes.push(Obstacle::cavity(vector(part, "centre", centre)?, *radius));
        }
        if let Some(round) = &self.cylinder {
            let point = vector(part, "point", &round.point)?;
            shapes.push(Obstacle::cylinder_along(&round.axis, point, round.radius));
        }
        if let Some(round) = &self.bore {
            let point = vector(part, "point", &round.point)?;
            shapes.push(Obstacle::bore_along(&round.axis, point, round.radius));
        }
        if let Some(Cuboid { low, high }) = &self.cuboid {
            let (low, high) = (vector(part, "low", low)?, vector(part, "high", high)?);
            shapes.push(Obstacle::cuboid(low, high));
        }
        match (shapes.pop(), shapes.is_empty()) {
            (Some(shape), true) => of(part, shape),
            _ => Err(Error::Part {
                part: part.into(),
                what: "give it one shape: `half-space`, `ball`, `cavity`, `cylinder`, `bore` or `cuboid`".into(),
            }),
        }
    }
}

/// A body and one of its boundaries.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Vec<Name>")]
struct SideKeys {
    body: String,
    boundary: Name,
}

impl TryFrom<Vec<Name>> for SideKeys {
    type Error = String;

    fn try_from(names: Vec<Name>) -> Result<Self, String> {
        match <[Name; 2]>::try_from(names) {
            Ok([Name::Name(body), boundary]) => Ok(SideKeys { body, boundary }),
            _ => Err("give the name of a body and one label, as [\"block\", 3]".into()),
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HalfSpace {
    point: Vec<f64>,
    normal: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ball {
    centre: Vec<f64>,
    radius: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cylinder {
    point: Vec<f64>,
    #[serde(default)]
    axis: Vec<f64>,
    radius: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    low: Vec<f64>,
    high: Vec<f64>,
}

/// What may be otherwise in another program's scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Gauss points of each facet and direction.
    Points(usize),
    /// The roles of all contacts.
    Passes(Passes),
    /// Where contact is looked for.
    Geometry(Geometry),
    /// The solver's tolerance.
    Tolerance(f64),
    /// Load increments, of each phase where there are some.
    Increments(usize),
    /// Sides of quadratic elements that are straight, as in FreeFEM.
    Straight,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Change::Points(points) => write!(f, "points = {points}"),
            Change::Passes(Passes::Both) => f.write_str("passes = both"),
            Change::Passes(Passes::FirstIsSlave) => f.write_str("passes = first-is-slave"),
            Change::Passes(Passes::SecondIsSlave) => f.write_str("passes = second-is-slave"),
            Change::Geometry(Geometry::Reference) => f.write_str("geometry = reference"),
            Change::Geometry(Geometry::Current) => f.write_str("geometry = current"),
            Change::Tolerance(tolerance) => write!(f, "tolerance = {tolerance:e}"),
            Change::Increments(increments) => write!(f, "increments = {increments}"),
            Change::Straight => f.write_str("straight sides"),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Name::Label(label) => write!(f, "{label}"),
            Name::Name(name) => f.write_str(name),
        }
    }
}

/// Names the part that an error is of.
fn of<T>(part: &str, result: Result<T, contact_fem::Error>) -> Result<T, Error> {
    result.map_err(|source| Error::Refused {
        part: part.into(),
        source: Box::new(source),
    })
}

fn vector<const D: usize>(part: &str, key: &str, values: &[f64]) -> Result<[f64; D], Error> {
    values.try_into().map_err(|_| Error::Part {
        part: part.into(),
        what: format!("`{key}` has {} components and needs {D}", values.len()),
    })
}

fn amplitude(part: &str, keys: Option<&AmplitudeKeys>) -> Result<Amplitude, Error> {
    match keys {
        None => Ok(Amplitude::proportional()),
        Some(AmplitudeKeys::Constant(value)) => Ok(Amplitude::constant(*value)),
        Some(AmplitudeKeys::Table(pairs)) => of(part, Amplitude::table(pairs)),
    }
}

/// The motions one after the other; `None` without any.
fn motion<const D: usize>(part: &str, all: &[MotionKeys]) -> Result<Option<Motion<D>>, Error> {
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

/// A body, with averaged changes of volume or without.
fn elastic<const D: usize>(
    mesh: Mesh<D>,
    law: impl Volumetric<D>,
    averaged: bool,
) -> Result<Body<D>, contact_fem::Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    match averaged {
        true => Body::with_averaged_volumes(mesh, law),
        false => Ok(Body::new(mesh, law)),
    }
}

impl SceneFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and as [`SceneFile::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, folder)
    }

    /// Reads a text whose mesh files are relative to `folder`.
    ///
    /// # Errors
    /// No TOML, an unknown key, a key that is missing, a value of the wrong kind.
    pub fn parse(text: &str, folder: impl Into<PathBuf>) -> Result<Self, Error> {
        Ok(SceneFile {
            folder: folder.into(),
            keys: toml::from_str(text)?,
            is_straight: false,
        })
    }

    /// The dimension of the first body's mesh.
    ///
    /// # Errors
    /// A file without a body, or whose mesh cannot be read.
    pub fn dimension(&self) -> Result<usize, Error> {
        let first = self.keys.body.first().ok_or_else(|| Error::Part {
            part: "the scene".into(),
            what: "it has no body: add `[[body]]`".into(),
        })?;
        let mesh = self.mesh_file(first)?;
        let kinds = mesh.elements().iter().map(|block| block.kind.dimension());
        Ok(kinds.max().unwrap_or(0))
    }

    /// The scene with one thing otherwise.
    pub fn changed(&self, change: Change) -> Self {
        let mut file = self.clone();
        let keys = &mut file.keys;
        match change {
            Change::Points(points) => keys.points = Some(points),
            Change::Passes(passes) => {
                let passes = match passes {
                    Passes::Both => PassKeys::Both,
                    Passes::FirstIsSlave => PassKeys::FirstIsSlave,
                    Passes::SecondIsSlave => PassKeys::SecondIsSlave,
                };
                keys.contact
                    .iter_mut()
                    .for_each(|contact| contact.passes = Some(passes));
            }
            Change::Geometry(Geometry::Reference) => keys.geometry = Some(Where::Reference),
            Change::Geometry(Geometry::Current) => keys.geometry = Some(Where::Current),
            Change::Tolerance(tolerance) => keys.tolerance = Some(tolerance),
            Change::Increments(increments) => match keys.phase.is_empty() {
                true => keys.increments = Some(increments),
                false => keys
                    .phase
                    .iter_mut()
                    .for_each(|p| p.increments = increments),
            },
            Change::Straight => file.is_straight = true,
        }
        file
    }

    /// The scene to be solved as the paper's script does: by [`Solver::Literal`], with 4 points if the file does not say
    /// otherwise, in the increments of the file, those that do not converge included unless it has `goes-on = false`.
    ///
    /// # Errors
    /// A file that asks for another solver.
    pub fn literal(&self) -> Result<Self, Error> {
        if let Some(solver) = self.keys.solver {
            if ![Solver::Literal, Solver::Automatic].contains(&solver) {
                return Err(Error::Part {
                    part: "the scene".into(),
                    what: format!(
                        "its `solver` is {solver}, which is not the script's: leave the key out, or do not ask for literal"
                    ),
                });
            }
        }
        let mut file = self.clone();
        file.keys.solver = Some(Solver::Literal);
        file.keys.points.get_or_insert(4);
        file.keys.goes_on.get_or_insert(true);
        Ok(file)
    }

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

    fn mesh_file(&self, body: &BodyKeys) -> Result<MeshFile, Error> {
        let part = format!("body {}", body.name);
        of(&part, MeshFile::read(self.folder.join(&body.mesh)))
    }

    /// The scene.
    ///
    /// # Errors
    /// Meshes that cannot be read or have another dimension, bodies and boundaries that there are not, and what
    /// [`Scene`] refuses.
    pub fn scene<const D: usize>(&self) -> Result<Scene<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let mut scene = Scene::new();
        let mut bodies = Vec::new();
        for keys in &self.keys.body {
            bodies.push(scene.add(&keys.name, self.body(keys)?));
        }
        let side = |part: &str, SideKeys { body, boundary }: &SideKeys| -> Result<Side, Error> {
            let index = self.keys.body.iter().position(|keys| keys.name == *body);
            let index = index.ok_or_else(|| {
                let names: Vec<&str> = self
                    .keys
                    .body
                    .iter()
                    .map(|keys| keys.name.as_str())
                    .collect();
                Error::Part {
                    part: part.into(),
                    what: format!("there is no body `{body}`: there are {names:?}"),
                }
            })?;
            Ok(bodies[index].on(boundary.to_string()))
        };
        for (k, keys) in self.keys.contact.iter().enumerate() {
            let part = format!("contact {}", k + 1);
            let (first, second) = (side(&part, &keys.first)?, side(&part, &keys.second)?);
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
        for keys in &self.keys.obstacle {
            let part = format!("obstacle {}", keys.name);
            let shape = keys.shape(&part)?;
            let shape = match motion(&part, &keys.motion)? {
                Some(motion) => shape.moving(motion),
                None => shape,
            };
            let Some((first, others)) = keys.on.split_first() else {
                let what = "`on` is empty: name the boundaries that may touch it".into();
                return Err(Error::Part { part, what });
            };
            let obstacle = scene.obstacle(&keys.name, side(&part, first)?, shape);
            let obstacle = of(&part, obstacle)?;
            for other in others {
                of(&part, scene.contact_obstacle(side(&part, other)?, obstacle))?;
            }
            if let Some(during) = &keys.during {
                let switched = scene.obstacle_during(obstacle, during);
                of(&format!("{part}, `during`"), switched)?;
            }
        }
        scene.integration = self.keys.points.map(Integration::Gauss);
        scene.geometry = self.keys.geometry.map(|geometry| match geometry {
            Where::Reference => Geometry::Reference,
            Where::Current => Geometry::Current,
        });
        scene.reach = self.keys.reach;
        Ok(scene)
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
            Some(region) => of(&part, file.body::<D>(&region.to_string()))?,
            None => {
                let mut all = of(&part, file.bodies::<D>())?;
                match all.len() {
                    1 => all.swap_remove(0).1,
                    _ => {
                        let names: Vec<String> = all.into_iter().map(|(name, _)| name).collect();
                        let names = names.join(", ");
                        let what =
                            format!("its mesh has the regions {names}: choose one by `region`");
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
        let mesh = self.mesh(keys)?;
        let (young, poisson) = (keys.young, keys.poisson);
        let averaged = keys.averaged_volumes;
        if averaged && mesh.order() == Order::Quadratic {
            let what = "`averaged-volumes` is for linear cells, and these are quadratic, which do not lock: leave it or \
                        `quadratic` out";
            return Err(Error::Part {
                part,
                what: what.into(),
            });
        }
        let mut body = match (keys.law, keys.share) {
            (Law::MooneyRivlin, Some(share)) => {
                let law = of(&part, MooneyRivlin::new(young, poisson, share))?;
                of(&part, elastic(mesh, law, averaged))?
            }
            (Law::MooneyRivlin, None) => {
                let what = "the law mooney-rivlin needs `share`".into();
                return Err(Error::Part { part, what });
            }
            (_, Some(_)) => {
                let what = "`share` is of the law mooney-rivlin: leave it out".into();
                return Err(Error::Part { part, what });
            }
            (Law::LinearElastic, None) => {
                let law = of(&part, LinearElastic::new(young, poisson))?;
                of(&part, elastic(mesh, law, averaged))?
            }
            (Law::NeoHookean, None) => {
                let law = of(&part, NeoHookean::new(young, poisson))?;
                of(&part, elastic(mesh, law, averaged))?
            }
            (Law::StVenantKirchhoff, None) if averaged => {
                let what = "`averaged-volumes` is not for st-venant-kirchhoff, whose energy has no part of the volume \
                            alone: leave it out, or take another law";
                return Err(Error::Part {
                    part,
                    what: what.into(),
                });
            }
            (Law::StVenantKirchhoff, None) => {
                Body::new(mesh, of(&part, StVenantKirchhoff::new(young, poisson))?)
            }
        };
        for name in &keys.symmetry {
            of(&part, body.symmetry(&name.to_string()))?;
        }
        for SupportKeys {
            on,
            x,
            y,
            z,
            motion: moves,
            amplitude: course,
        } in &keys.supports
        {
            if D == 2 && z.is_some() {
                let what = "a support in the plane has no `z`".into();
                return Err(Error::Part { part, what });
            }
            let all = [*x, *y, *z];
            let place = match on {
                Some(name) => format!("on {name}"),
                None => "without `on`".into(),
            };
            let components = std::array::from_fn(|i| all[i]);
            let moves = motion(&part, moves)?;
            let has_values = all.iter().any(Option::is_some);
            let what = match (has_values, &moves, course, on) {
                (false, None, ..) => "holds nothing: give it x, y, z or `motion`",
                (true, Some(_), ..) => "has components and a motion: give it one of them",
                (_, Some(_), Some(_), _) => {
                    "has a motion, which has amplitudes of its own: leave `amplitude` out"
                }
                (true, None, Some(_), None) => "has an amplitude: name its boundary by `on`",
                _ => "",
            };
            if !what.is_empty() {
                let what = format!("its support {place} {what}");
                return Err(Error::Part { part, what });
            }
            let name = on.as_ref().map(ToString::to_string);
            let held = match (name, moves) {
                (Some(name), Some(moves)) => body.prescribe_motion(&name, moves),
                (None, Some(moves)) => body.prescribe_motion_of_all(moves),
                (Some(name), None) => {
                    let course = amplitude(&part, course.as_ref())?;
                    body.prescribe_in_time(&name, components, course)
                }
                (None, None) => body.prescribe_all(components),
            };
            of(&part, held)?;
        }
        for TractionKeys {
            on,
            force,
            amplitude: course,
        } in &keys.tractions
        {
            let force = vector(&part, "force", force)?;
            let course = amplitude(&part, course.as_ref())?;
            of(&part, body.traction_in_time(&on.to_string(), force, course))?;
        }
        keys.add_to_boundaries(&part, &mut body)?;
        let course = amplitude(&part, keys.body_force_amplitude.as_ref())?;
        match &keys.body_force {
            Some(force) => {
                let force = vector(&part, "body-force", force)?;
                of(&part, body.body_force_in_time(force, course))?;
            }
            None if keys.body_force_amplitude.is_some() => {
                let what = "`body-force-amplitude` has no effect without `body-force`".into();
                return Err(Error::Part { part, what });
            }
            None => {}
        }
        Ok(body)
    }
}
