//! The keys of a scene file.

use std::fmt;
use std::path::PathBuf;

use serde::Deserialize;

use super::laws::{Law, RegionKeys};
use super::run::{Departure, Solver};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Keys {
    pub(super) increments: Option<usize>,
    #[serde(default)]
    pub(super) phase: Vec<PhaseKeys>,
    pub(super) solver: Option<Solver>,
    pub(super) tolerance: Option<f64>,
    pub(super) departures: Option<Vec<Departure>>,
    pub(super) goes_on: Option<bool>,
    pub(super) max_iterations: Option<usize>,
    pub(super) ipopt_tolerance: Option<f64>,
    pub(super) points: Option<usize>,
    pub(super) geometry: Option<Where>,
    pub(super) reach: Option<f64>,
    pub(super) body: Vec<BodyKeys>,
    #[serde(default)]
    pub(super) contact: Vec<ContactKeys>,
    #[serde(default)]
    pub(super) obstacle: Vec<ObstacleKeys>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Where {
    Reference,
    Current,
}

/// A phase of the run, and bounds of adaptive steps in it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct PhaseKeys {
    pub(super) name: String,
    pub(super) until: f64,
    pub(super) increments: usize,
    pub(super) least_step: Option<f64>,
    pub(super) largest_step: Option<f64>,
}

/// A constant, or pairs of time and value with straight lines between them.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum AmplitudeKeys {
    Constant(f64),
    Table(Vec<(f64, f64)>),
}

/// One motion; several follow one another.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionKeys {
    pub(super) translation: Option<Vec<f64>>,
    pub(super) rotation: Option<f64>,
    pub(super) centre: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) axis: Vec<f64>,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct BodyKeys {
    pub(super) name: String,
    pub(super) mesh: PathBuf,
    pub(super) region: Option<Name>,
    #[serde(default)]
    pub(super) quadratic: bool,
    #[serde(default)]
    pub(super) averaged_volumes: bool,
    pub(super) law: Law,
    pub(super) young: Option<f64>,
    pub(super) poisson: Option<f64>,
    pub(super) share: Option<f64>,
    pub(super) terms: Option<Vec<[f64; 2]>>,
    #[serde(default)]
    pub(super) laws: Vec<RegionKeys>,
    #[serde(default)]
    pub(super) plane_stress: bool,
    #[serde(default)]
    pub(super) symmetry: Vec<Name>,
    #[serde(default)]
    pub(super) supports: Vec<SupportKeys>,
    #[serde(default)]
    pub(super) tractions: Vec<TractionKeys>,
    #[serde(default)]
    pub(super) pressures: Vec<PressureKeys>,
    #[serde(default)]
    pub(super) foundations: Vec<FoundationKeys>,
    pub(super) body_force: Option<Vec<f64>>,
    pub(super) body_force_amplitude: Option<AmplitudeKeys>,
}

/// A label or a name.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Name {
    Label(i64),
    Name(String),
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Name::Label(label) => write!(f, "{label}"),
            Name::Name(name) => f.write_str(name),
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportKeys {
    pub(super) on: Option<Name>,
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    pub(super) z: Option<f64>,
    #[serde(default)]
    pub(super) motion: Vec<MotionKeys>,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TractionKeys {
    pub(super) on: Name,
    pub(super) force: Vec<f64>,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PressureKeys {
    pub(super) on: Name,
    pub(super) pressure: f64,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct FoundationKeys {
    pub(super) on: Name,
    pub(super) stiffness: f64,
    #[serde(default)]
    pub(super) normal_only: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct ContactKeys {
    pub(super) first: SideKeys,
    pub(super) second: SideKeys,
    pub(super) passes: Option<PassKeys>,
    pub(super) during: Option<Vec<[f64; 2]>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PassKeys {
    Both,
    FirstIsSlave,
    SecondIsSlave,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct ObstacleKeys {
    pub(super) name: String,
    pub(super) half_space: Option<HalfSpace>,
    pub(super) ball: Option<Ball>,
    pub(super) cavity: Option<Ball>,
    pub(super) cylinder: Option<Cylinder>,
    pub(super) bore: Option<Cylinder>,
    pub(super) cuboid: Option<Cuboid>,
    #[serde(default)]
    pub(super) motion: Vec<MotionKeys>,
    pub(super) during: Option<Vec<[f64; 2]>>,
    pub(super) on: Vec<SideKeys>,
}

/// A body and one of its boundaries.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Vec<Name>")]
pub(super) struct SideKeys {
    pub(super) body: String,
    pub(super) boundary: Name,
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
pub(super) struct HalfSpace {
    pub(super) point: Vec<f64>,
    pub(super) normal: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ball {
    pub(super) centre: Vec<f64>,
    pub(super) radius: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Cylinder {
    pub(super) point: Vec<f64>,
    #[serde(default)]
    pub(super) axis: Vec<f64>,
    pub(super) radius: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Cuboid {
    pub(super) low: Vec<f64>,
    pub(super) high: Vec<f64>,
}
