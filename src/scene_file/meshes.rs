//! Meshes of a scene file: from files, or by the library's generators.

use std::any::Any;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use contact_fem::mesh::generators::{
    Diagonals, annulus, cuboid, cuboid_graded, cylinder, disc, eighth_sphere, equilateral_disc,
    extrude, graded, half_disc, hemisphere, linspace, quarter_disc, rectangle, sphere,
};
use contact_fem::{Mesh, MeshFile};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::Error;
use super::place::Place;

/// A file, or a mesh that the library makes.
#[derive(Clone, Debug)]
pub(super) enum MeshKeys {
    File(PathBuf),
    Made(Made),
}

/// A mesh by one of the library's generators.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) enum Made {
    Rectangle(RectangleKeys),
    Annulus(AnnulusKeys),
    Disc(DiscKeys),
    EquilateralDisc(EquilateralDiscKeys),
    HalfDisc(SectorKeys),
    QuarterDisc(SectorKeys),
    Cuboid(CuboidKeys),
    CuboidGraded(CuboidGradedKeys),
    Cylinder(CylinderKeys),
    Sphere(SphereKeys),
    Hemisphere(SphereKeys),
    EighthSphere(SphereKeys),
    Extrude(ExtrudeKeys),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RectangleKeys {
    pub(super) x: Grid,
    pub(super) y: Grid,
    #[serde(default)]
    pub(super) diagonals: DiagonalKeys,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnnulusKeys {
    pub(super) radii: Grid,
    pub(super) segments: usize,
    #[serde(default)]
    pub(super) diagonals: DiagonalKeys,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DiscKeys {
    pub(super) radius: f64,
    pub(super) segments: usize,
    pub(super) rings: usize,
    #[serde(default)]
    pub(super) phase: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EquilateralDiscKeys {
    pub(super) radius: f64,
    pub(super) rings: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SectorKeys {
    pub(super) radii: Grid,
    pub(super) angles: Grid,
    #[serde(default)]
    pub(super) diagonals: DiagonalKeys,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CuboidKeys {
    pub(super) low: [f64; 3],
    pub(super) size: [f64; 3],
    pub(super) divisions: [usize; 3],
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CuboidGradedKeys {
    pub(super) x: Grid,
    pub(super) y: Grid,
    pub(super) z: Grid,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CylinderKeys {
    pub(super) radius: f64,
    pub(super) height: f64,
    pub(super) rings: usize,
    pub(super) layers: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereKeys {
    pub(super) radius: f64,
    pub(super) shells: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExtrudeKeys {
    pub(super) plane: Box<MeshKeys>,
    pub(super) z: Grid,
    pub(super) caps: [String; 2],
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DiagonalKeys {
    #[default]
    Rising,
    Falling,
    Alternating,
}

/// The values of a grid: a list, or equal or graded steps.
#[derive(Clone, Debug)]
pub(super) enum Grid {
    Values(Vec<f64>),
    Steps(StepsKeys),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepsKeys {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) count: usize,
    pub(super) first: Option<f64>,
    pub(super) last: Option<f64>,
}

impl Grid {
    /// Its values, which ascend.
    pub(super) fn values(&self, place: &Place<'_>) -> Result<Vec<f64>, Error> {
        let values = match self {
            Grid::Values(values) => values.clone(),
            Grid::Steps(steps) => return steps.values(place),
        };
        if values.len() < 2 {
            let count = values.len();
            return Err(place.wrong(format!(
                "a grid needs two values at least, and it has {count}: add others"
            )));
        }
        match values.windows(2).find(|pair| pair[1] <= pair[0]) {
            Some(pair) => Err(place.wrong(format!(
                "the values of a grid must ascend, and {} follows {}: sort them",
                pair[1], pair[0]
            ))),
            None => Ok(values),
        }
    }
}

impl StepsKeys {
    fn values(&self, place: &Place<'_>) -> Result<Vec<f64>, Error> {
        let StepsKeys {
            from, to, count, ..
        } = *self;
        if to <= from {
            let what =
                format!("a grid must ascend, and it goes from {from} to {to}: exchange them");
            return Err(place.key("to").wrong(what));
        }
        if count == 0 {
            let what = "a grid needs one step at least, and `count` is 0";
            return Err(place.key("count").wrong(what));
        }
        match (self.first, self.last) {
            (None, None) => match linspace(from, to, count) {
                values if values.is_empty() => Err(place.key("count").wrong(format!(
                    "a grid has 10⁸ steps at most, and `count` is {count}: choose fewer"
                ))),
                values => Ok(values),
            },
            (Some(first), None) => place.of(graded(from, to, first, count)),
            (None, Some(last)) => {
                // the same steps backwards, whose first one is the last
                let mut values = match graded(to, from, last, count) {
                    Err(contact_fem::Error::Setting { name: "first", .. }) => {
                        return Err(place.key("last").wrong(format!(
                            "the last step {last} must be positive and shorter than the whole length, and with {count} steps, none \
                             may be a thousand times as long as the next: choose another one"
                        )));
                    }
                    values => place.of(values)?,
                };
                values.reverse();
                Ok(values)
            }
            (Some(_), Some(_)) => Err(place.key("last").wrong(
                "a grid has its `first` or its `last` step, not both: leave one of them out",
            )),
        }
    }
}

impl MeshKeys {
    /// The file that it comes from, if it does.
    pub(super) fn file(&self) -> Option<&Path> {
        match self {
            MeshKeys::File(path) => Some(path),
            MeshKeys::Made(Made::Extrude(keys)) => keys.plane.file(),
            MeshKeys::Made(_) => None,
        }
    }

    /// The dimension of its cells.
    pub(super) fn dimension(&self, place: &Place<'_>, folder: &Path) -> Result<usize, Error> {
        match self {
            MeshKeys::File(path) => {
                let file = place.of(MeshFile::read(folder.join(path)))?;
                let kinds = file.elements().iter().map(|block| block.kind.dimension());
                Ok(kinds.max().unwrap_or(0))
            }
            MeshKeys::Made(made) => Ok(match made {
                Made::Rectangle(_)
                | Made::Annulus(_)
                | Made::Disc(_)
                | Made::EquilateralDisc(_)
                | Made::HalfDisc(_)
                | Made::QuarterDisc(_) => 2,
                _ => 3,
            }),
        }
    }

    /// All bodies of a file as one mesh, whose regions they are; or the mesh that is made, which has none. Nodes at most `merge` apart (UL)
    /// become one.
    pub(super) fn with_regions<const D: usize>(
        &self,
        place: &Place<'_>,
        folder: &Path,
        merge: Option<f64>,
    ) -> Result<Found<D>, Error> {
        match self {
            MeshKeys::File(path) => {
                let file = place.of(read(&folder.join(path), merge))?;
                Ok(Found::Mesh(Box::new(place.of(file.with_regions())?)))
            }
            MeshKeys::Made(_) => self.mesh(place, folder, (None, None)),
        }
    }

    /// The one body of a file, or the mesh that is made; `None` if the file has several and `region` names none, or if the mesh
    /// has another dimension. Nodes at most `merge` apart (UL) become one.
    pub(super) fn mesh<const D: usize>(
        &self,
        place: &Place<'_>,
        folder: &Path,
        (region, merge): (Option<&str>, Option<f64>),
    ) -> Result<Found<D>, Error> {
        match self {
            MeshKeys::File(path) => {
                let file = place.of(read(&folder.join(path), merge))?;
                if let Some(region) = region {
                    return Ok(Found::Mesh(Box::new(place.of(file.body(region))?)));
                }
                let mut all = place.of(file.bodies::<D>())?;
                Ok(match all.len() {
                    1 => Found::Mesh(Box::new(all.swap_remove(0).1)),
                    _ => Found::Regions(all.into_iter().map(|(name, _)| name).collect()),
                })
            }
            MeshKeys::Made(made) => {
                let mesh: Box<dyn Any> = made.mesh(place, folder)?;
                Ok(mesh.downcast().map_or(Found::OtherDimension, Found::Mesh))
            }
        }
    }
}

fn read(path: &Path, merge: Option<f64>) -> Result<MeshFile, contact_fem::Error> {
    let file = MeshFile::read(path)?;
    match merge {
        Some(distance) => file.merged(distance),
        None => Ok(file),
    }
}

/// What a mesh key leads to.
pub(super) enum Found<const D: usize> {
    Mesh(Box<Mesh<D>>),
    /// A file with these bodies, of which none is named.
    Regions(Vec<String>),
    OtherDimension,
}

impl Made {
    /// Its key.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Made::Rectangle(_) => "rectangle",
            Made::Annulus(_) => "annulus",
            Made::Disc(_) => "disc",
            Made::EquilateralDisc(_) => "equilateral-disc",
            Made::HalfDisc(_) => "half-disc",
            Made::QuarterDisc(_) => "quarter-disc",
            Made::Cuboid(_) => "cuboid",
            Made::CuboidGraded(_) => "cuboid-graded",
            Made::Cylinder(_) => "cylinder",
            Made::Sphere(_) => "sphere",
            Made::Hemisphere(_) => "hemisphere",
            Made::EighthSphere(_) => "eighth-sphere",
            Made::Extrude(_) => "extrude",
        }
    }

    /// A `Mesh<2>` or a `Mesh<3>`.
    fn mesh(&self, place: &Place<'_>, folder: &Path) -> Result<Box<dyn Any>, Error> {
        fn of<const D: usize>(
            place: &Place<'_>,
            mesh: Result<Mesh<D>, contact_fem::Error>,
        ) -> Result<Box<dyn Any>, Error> {
            Ok(Box::new(place.of(mesh)?))
        }
        let at = &place.key(self.name());
        let grid = |key: &'static str, grid: &Grid| grid.values(&at.key(key));
        match self {
            Made::Rectangle(keys) => {
                let (x, y) = (grid("x", &keys.x)?, grid("y", &keys.y)?);
                of(at, rectangle(&x, &y, keys.diagonals.into()))
            }
            Made::Annulus(keys) => {
                let radii = grid("radii", &keys.radii)?;
                of(at, annulus(&radii, keys.segments, keys.diagonals.into()))
            }
            Made::Disc(keys) => of(at, disc(keys.radius, keys.segments, keys.rings, keys.phase)),
            Made::EquilateralDisc(keys) => of(at, equilateral_disc(keys.radius, keys.rings)),
            Made::HalfDisc(keys) | Made::QuarterDisc(keys) => {
                let radii = grid("radii", &keys.radii)?;
                let angles = grid("angles", &keys.angles)?;
                let make = match self {
                    Made::HalfDisc(_) => half_disc,
                    _ => quarter_disc,
                };
                of(at, make(&radii, &angles, keys.diagonals.into()))
            }
            Made::Cuboid(keys) => of(at, cuboid(keys.low, keys.size, keys.divisions)),
            Made::CuboidGraded(CuboidGradedKeys { x, y, z }) => {
                let (x, y, z) = (grid("x", x)?, grid("y", y)?, grid("z", z)?);
                of(at, cuboid_graded(&x, &y, &z))
            }
            Made::Cylinder(keys) => of(
                at,
                cylinder(keys.radius, keys.height, keys.rings, keys.layers),
            ),
            Made::Sphere(keys) => of(at, sphere(keys.radius, keys.shells)),
            Made::Hemisphere(keys) => of(at, hemisphere(keys.radius, keys.shells)),
            Made::EighthSphere(keys) => of(at, eighth_sphere(keys.radius, keys.shells)),
            Made::Extrude(keys) => {
                let [low, high] = &keys.caps;
                let plane = at.key("plane");
                match keys.plane.mesh::<2>(&plane, folder, (None, None))? {
                    Found::Mesh(mesh) => {
                        let z = grid("z", &keys.z)?;
                        of(at, extrude(&mesh, &z, [low, high]))
                    }
                    _ => Err(plane.wrong(
                        "is no one mesh in the plane: give a file of one body, or a table such as `rectangle`",
                    )),
                }
            }
        }
    }
}

impl From<DiagonalKeys> for Diagonals {
    fn from(keys: DiagonalKeys) -> Self {
        match keys {
            DiagonalKeys::Rising => Diagonals::Rising,
            DiagonalKeys::Falling => Diagonals::Falling,
            DiagonalKeys::Alternating => Diagonals::Alternating,
        }
    }
}

/// The one entry of a table, which says what `has` one.
pub(super) fn only<'de, T: Deserialize<'de>, M: MapAccess<'de>>(
    mut map: M,
    has: &str,
) -> Result<T, M::Error> {
    let one = T::deserialize(MapAccessDeserializer::new(&mut map))?;
    match map.next_key::<String>()? {
        None => Ok(one),
        Some(other) => Err(M::Error::custom(format!(
            "{has}, and there is `{other}` beside another one: leave one of them out"
        ))),
    }
}

/// A string or a list where the one is meant, a table where the other is: unlike untagged enums, it keeps what is wrong
/// within either, with its line.
struct Either<S, T> {
    expects: &'static str,
    of: PhantomData<(S, T)>,
}

impl<'de> Visitor<'de> for Either<PathBuf, Made> {
    type Value = MeshKeys;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expects)
    }

    fn visit_str<E>(self, path: &str) -> Result<MeshKeys, E> {
        Ok(MeshKeys::File(path.into()))
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<MeshKeys, M::Error> {
        only(map, "a mesh that is made has one generator").map(MeshKeys::Made)
    }
}

impl<'de> Visitor<'de> for Either<Vec<f64>, StepsKeys> {
    type Value = Grid;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expects)
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<Grid, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(Grid::Values)
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Grid, M::Error> {
        StepsKeys::deserialize(MapAccessDeserializer::new(map)).map(Grid::Steps)
    }
}

impl<'de> Deserialize<'de> for MeshKeys {
    fn deserialize<De: Deserializer<'de>>(from: De) -> Result<Self, De::Error> {
        from.deserialize_any(Either::<PathBuf, Made> {
            expects: "the name of a file, or a table such as { rectangle = { x = [0, 1], y = [0, 1] } }",
            of: PhantomData,
        })
    }
}

impl<'de> Deserialize<'de> for Grid {
    fn deserialize<De: Deserializer<'de>>(from: De) -> Result<Self, De::Error> {
        from.deserialize_any(Either::<Vec<f64>, StepsKeys> {
            expects: "a list of values, or a table such as { from = 0, to = 1, count = 4 }",
            of: PhantomData,
        })
    }
}
