//! Scenes as text files, which the program `ipopt-contact run` solves.
//!
//! A file is TOML. Meshes are files of their own, named relative to it, in any format that [`MeshFile`](contact_fem::MeshFile) reads. Lengths and forces
//! are in the user's units. A boundary is a label (`1`) or a name (`"top"`). docs/scene_files.md lists all keys.
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

mod bodies;
mod changes;
mod contact;
mod hints;
mod keys;
mod laws;
mod meshes;
mod obstacles;
mod place;
mod program;
mod record;
mod rounds;
mod run;
mod tables;
mod told;
mod words;

use std::any::Any;
use std::fmt;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use contact_fem::Scene;
use contact_fem::accuracy::Refinement;
use contact_fem::element::{Element, P1, P2};
use contact_fem::model::{Corners, Geometry, InitialGaps, Integration, Overlaps, Projection};

use keys::{CornerKeys, InitialGapKeys, IntegrationKeys, Keys, OverlapKeys, ProjectionKeys, Where};
use place::Place;

pub use changes::Change;
pub use run::{Departure, Solver};
pub use words::in_keys;

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
    #[error("the scene file: {told}")]
    Text {
        /// The place, what is wrong there, and what may be meant.
        told: String,
        /// What the parser says.
        source: toml::de::Error,
    },
    /// A part of the scene whose values do not fit together.
    #[error("{part}: {what}")]
    Part {
        /// The body, contact or obstacle, with its line, and the key.
        part: String,
        /// What is wrong with it, and the remedy.
        what: String,
    },
    /// What the library refuses.
    #[error("{part}: {}", in_keys(&source.to_string()))]
    Refused {
        /// The body, contact or obstacle, with its line, and the key.
        part: String,
        /// Why.
        source: Box<contact_fem::Error>,
    },
}

impl Error {
    /// A text that is no TOML or no scene.
    fn no_scene(text: &str, source: toml::de::Error) -> Self {
        Error::Text {
            told: hints::told_with_hint(text, &source),
            source,
        }
    }
}

/// More bytes than this are no scene: meshes are files of their own.
const MOST: u64 = 1 << 24;

/// The text of a file, a pipe or a device, which may have no end.
fn text(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    let read = File::open(path)?.take(MOST + 1).read_to_string(&mut text)?;
    if read as u64 > MOST {
        let why =
            format!("a scene file has at most {MOST} bytes: keep meshes in files of their own");
        return Err(std::io::Error::new(ErrorKind::FileTooLarge, why));
    }
    Ok(text)
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
    /// As it was read, for the lines that errors name.
    text: String,
    keys: Keys,
    /// Whether curved sides are made straight.
    is_straight: bool,
    /// How the meshes differ from the meshes that the file names.
    refinement: Refinement,
}

impl SceneFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and as [`SceneFile::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = text(path).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of(&text, folder.into())
    }

    /// Reads a text whose mesh files are relative to `folder`.
    ///
    /// # Errors
    /// No TOML, an unknown key, a key that is missing, a value of the wrong kind, a number that is not finite.
    pub fn parse(text: &str, folder: impl Into<PathBuf>) -> Result<Self, Error> {
        Self::of(text, folder.into())
    }

    fn of(text: &str, folder: PathBuf) -> Result<Self, Error> {
        let keys = toml::from_str(text).map_err(|why| Error::no_scene(text, why))?;
        place::check_numbers(text)?;
        Ok(SceneFile {
            folder,
            text: text.into(),
            keys,
            is_straight: false,
            refinement: Refinement::default(),
        })
    }

    /// The same scene on refined meshes. Its boundaries are the file's, cut into smaller facets; `curved` ones are drawn
    /// onto their curves again.
    pub fn refined(&self, refinement: &Refinement) -> Self {
        SceneFile {
            refinement: refinement.clone(),
            ..self.clone()
        }
    }

    /// The dimension of the first body's mesh, 2 or 3.
    ///
    /// # Errors
    /// A file without a body, or whose mesh cannot be read, or has neither triangles nor tetrahedra.
    pub fn dimension(&self) -> Result<usize, Error> {
        let Some(first) = self.keys.body.first() else {
            let what = "it has no body: add `[[body]]`";
            return Err(self.place().wrong(what));
        };
        let at = self.body_place(0).key("mesh");
        match first.mesh.dimension(&at, &self.folder)? {
            dimension @ (2 | 3) => Ok(dimension),
            dimension => {
                let file = first.mesh.file().unwrap_or(Path::new("")).display();
                Err(at.wrong(format!(
                    "`{file}` has no cells of a dimension above {dimension}: give a mesh of triangles or tetrahedra"
                )))
            }
        }
    }

    fn place(&self) -> Place<'_> {
        Place::top(&self.text)
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
        // compiled here, not in each program that reads scenes
        let scene: Box<dyn Any> = match D {
            2 => Box::new(self.plane_scene()),
            _ => Box::new(self.space_scene()),
        };
        *scene
            .downcast()
            .expect("elements have two or three dimensions")
    }

    fn plane_scene(&self) -> Result<Scene<2>, Error> {
        self.build()
    }

    fn space_scene(&self) -> Result<Scene<3>, Error> {
        self.build()
    }

    fn build<const D: usize>(&self) -> Result<Scene<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let mut scene = Scene::new();
        let bodies = self.add_bodies(&mut scene)?;
        self.add_contacts(&mut scene, &bodies)?;
        self.add_ties(&mut scene, &bodies)?;
        self.add_obstacles(&mut scene, &bodies)?;
        scene.integration = self.integration()?;
        scene.geometry = self.keys.geometry.map(|geometry| match geometry {
            Where::Reference => Geometry::Reference,
            Where::Current => Geometry::Current,
        });
        scene.reach = self.keys.reach;
        if let Some(projection) = self.keys.projection {
            scene.projection = match projection {
                ProjectionKeys::AlongNormals => Projection::AlongNormals,
                ProjectionKeys::Closest => Projection::Closest,
            };
        }
        if let Some(corners) = self.keys.corners {
            scene.corners = match corners {
                CornerKeys::AsNeeded => Corners::AsNeeded,
                CornerKeys::Held => Corners::Held,
                CornerKeys::Weak => Corners::Weak,
            };
        }
        if let Some(tolerance) = self.keys.overlap_tolerance {
            scene.overlap_tolerance = tolerance;
        }
        scene.initial_gaps = match self.keys.initial_gaps {
            None | Some(InitialGapKeys::Refuse) => InitialGaps::Refuse,
            Some(InitialGapKeys::Resolve) => InitialGaps::Resolve,
            Some(InitialGapKeys::Adjust) => InitialGaps::Adjust,
        };
        scene.overlaps = match self.keys.overlaps {
            None | Some(OverlapKeys::Refused) => Overlaps::Refused,
            Some(OverlapKeys::Allowed) => Overlaps::Allowed,
        };
        Ok(scene)
    }

    fn integration(&self) -> Result<Option<Integration>, Error> {
        match (self.keys.points, self.keys.integration) {
            (Some(points), Some(IntegrationKeys::Exact)) => Err(self.place().key("points").wrong(format!(
                "`points = {points}` has no effect with `integration = \"exact\"`: leave one of them out"
            ))),
            (None, Some(IntegrationKeys::Exact)) => Ok(Some(Integration::Exact)),
            (points, None) => Ok(points.map(Integration::Gauss)),
        }
    }
}
