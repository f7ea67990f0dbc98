//! The keys of a scene file.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};

use super::laws::Law;
use super::meshes::{MeshKeys, only};
use super::run::{Departure, Solver};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Keys {
    pub(super) increments: Option<usize>,
    #[serde(default)]
    pub(super) phase: Vec<PhaseKeys>,
    pub(super) solver: Option<Solver>,
    pub(super) tolerance: Option<f64>,
    pub(super) max_leaps: Option<usize>,
    pub(super) departures: Option<Vec<Departure>>,
    pub(super) goes_on: Option<bool>,
    pub(super) max_iterations: Option<usize>,
    pub(super) ipopt_tolerance: Option<f64>,
    pub(super) method: Option<Formulation>,
    pub(super) complementarity: Option<f64>,
    pub(super) penetration: Option<f64>,
    pub(super) acceleration: Option<Combine>,
    pub(super) depth: Option<usize>,
    #[serde(default)]
    pub(super) ipopt: BTreeMap<String, OptionKeys>,
    pub(super) points: Option<usize>,
    pub(super) integration: Option<IntegrationKeys>,
    pub(super) projection: Option<ProjectionKeys>,
    pub(super) corners: Option<CornerKeys>,
    pub(super) initial_gaps: Option<InitialGapKeys>,
    pub(super) overlap_tolerance: Option<f64>,
    pub(super) overlaps: Option<OverlapKeys>,
    pub(super) geometry: Option<Where>,
    pub(super) reach: Option<f64>,
    pub(super) body: Vec<BodyKeys>,
    #[serde(default)]
    pub(super) contact: Vec<ContactKeys>,
    #[serde(default)]
    pub(super) tie: Vec<TieKeys>,
    #[serde(default)]
    pub(super) obstacle: Vec<ObstacleKeys>,
    #[serde(default)]
    pub(super) output: OutputKeys,
}

/// What is recorded.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct OutputKeys {
    pub(super) name: Option<String>,
    pub(super) vtu_every: Option<usize>,
    pub(super) picture: Option<String>,
    pub(super) half_way: Option<bool>,
    pub(super) reaction: Option<ReactionKeys>,
}

/// The force that the summary calls `reaction`: that of the supports of these bodies along a direction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReactionKeys {
    pub(super) of: Vec<String>,
    pub(super) on: Option<Name>,
    pub(super) along: Vec<f64>,
}

/// How Ipopt states every subproblem.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Formulation {
    InteriorPoint,
    PenalizedSlack,
    Penalty,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Combine {
    Plain,
    Anderson,
}

/// As in a file.
impl fmt::Display for Formulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Formulation::InteriorPoint => "interior-point",
            Formulation::PenalizedSlack => "penalized-slack",
            Formulation::Penalty => "penalty",
        })
    }
}

/// As in a file.
impl fmt::Display for Combine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Combine::Plain => "plain",
            Combine::Anderson => "anderson",
        })
    }
}

/// The value of an option of Ipopt.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "an option of Ipopt is a whole number, a number or a text"
)]
pub(super) enum OptionKeys {
    Integer(i32),
    Number(f64),
    Text(String),
}

/// As `points`, but not at Gauss points.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "IntegrationValue")]
pub(super) enum IntegrationKeys {
    Exact,
}

/// What may stand there by mistake, too.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "`integration` is the word `\"exact\"`")]
enum IntegrationValue {
    Points(i64),
    Word(String),
}

impl TryFrom<IntegrationValue> for IntegrationKeys {
    type Error = String;

    fn try_from(value: IntegrationValue) -> Result<Self, String> {
        match value {
            IntegrationValue::Word(word) if word == "exact" => Ok(IntegrationKeys::Exact),
            IntegrationValue::Word(word) => Err(format!(
                "unknown integration `{word}`: take `\"exact\"`, or `points = 4` for Gauss points"
            )),
            IntegrationValue::Points(points) => Err(format!(
                "`integration = {points}`: take `points = {points}` for Gauss points, or `integration = \"exact\"`"
            )),
        }
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ProjectionKeys {
    AlongNormals,
    Closest,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum CornerKeys {
    AsNeeded,
    Held,
    Weak,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum InitialGapKeys {
    Refuse,
    Resolve,
    Adjust,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OverlapKeys {
    Refused,
    Allowed,
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
#[serde(
    untagged,
    expecting = "an amplitude is a number, or a list of pairs of time and value, as [[0, 0], [1, 1]]"
)]
pub(super) enum AmplitudeKeys {
    Constant(f64),
    Table(Vec<(f64, f64)>),
}

/// Pairs of times; a pair alone needs no list around it.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Vec<TimeKeys>")]
pub(super) struct DuringKeys(pub(super) Vec<[f64; 2]>);

#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "`during` is a pair of times, as [0, 1], or a list of pairs, as [[0, 1], [2, 3]]"
)]
pub(super) enum TimeKeys {
    Time(f64),
    Pair([f64; 2]),
}

impl TryFrom<Vec<TimeKeys>> for DuringKeys {
    type Error = &'static str;

    fn try_from(times: Vec<TimeKeys>) -> Result<Self, &'static str> {
        if let [TimeKeys::Time(from), TimeKeys::Time(to)] = times[..] {
            return Ok(DuringKeys(vec![[from, to]]));
        }
        let pair = |time: TimeKeys| match time {
            TimeKeys::Pair(pair) => Some(pair),
            TimeKeys::Time(_) => None,
        };
        let pairs: Option<Vec<[f64; 2]>> = times.into_iter().map(pair).collect();
        pairs
            .filter(|pairs| !pairs.is_empty())
            .map(DuringKeys)
            .ok_or(
                "`during` is a pair of times, as [0, 1], or a list of pairs, as [[0, 1], [2, 3]]",
            )
    }
}

/// Motions, of which each follows the one before; one alone needs no list around it.
#[derive(Clone, Debug, Default)]
pub(super) struct Motions(pub(super) Vec<MotionKeys>);

/// Takes a list or a table. Unlike an untagged enum, it keeps what is wrong within either, with its line.
struct OneOrMore;

impl<'de> Visitor<'de> for OneOrMore {
    type Value = Motions;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a motion such as { translation = [0, 1] }, or a list of motions")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<Motions, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(Motions)
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Motions, M::Error> {
        let one = MotionKeys::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Motions(vec![one]))
    }
}

impl<'de> Deserialize<'de> for Motions {
    fn deserialize<De: serde::Deserializer<'de>>(from: De) -> Result<Self, De::Error> {
        from.deserialize_any(OneOrMore)
    }
}

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
    pub(super) mesh: MeshKeys,
    pub(super) region: Option<Name>,
    pub(super) merge_nodes: Option<f64>,
    #[serde(default)]
    pub(super) quadratic: bool,
    #[serde(default)]
    pub(super) curved: Vec<CurvedKeys>,
    pub(super) translated: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) boundaries: BTreeMap<String, BoundaryKeys>,
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
    pub(super) revolution: bool,
    #[serde(default)]
    pub(super) symmetry: Vec<Name>,
    #[serde(default)]
    pub(super) supports: Vec<SupportKeys>,
    #[serde(default)]
    pub(super) tractions: Vec<TractionKeys>,
    #[serde(default)]
    pub(super) torques: Vec<TorqueKeys>,
    #[serde(default)]
    pub(super) pressures: Vec<PressureKeys>,
    #[serde(default)]
    pub(super) forces: Vec<ForceKeys>,
    #[serde(default)]
    pub(super) foundations: Vec<FoundationKeys>,
    pub(super) body_force: Option<Vec<f64>>,
    pub(super) body_force_amplitude: Option<AmplitudeKeys>,
}

/// The constants of a region, of the body's law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionKeys {
    pub(super) region: Name,
    pub(super) young: Option<f64>,
    pub(super) poisson: Option<f64>,
    pub(super) share: Option<f64>,
    pub(super) terms: Option<Vec<[f64; 2]>>,
}

/// A label or a name.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a boundary or a region is a label, as 1, or a name, as \"top\""
)]
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
    pub(super) at: Option<Vec<Vec<f64>>>,
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    pub(super) z: Option<f64>,
    pub(super) along: Option<Vec<f64>>,
    pub(super) by: Option<f64>,
    #[serde(default)]
    pub(super) motion: Motions,
    pub(super) amplitude: Option<AmplitudeKeys>,
    pub(super) during: Option<DuringKeys>,
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
pub(super) struct TorqueKeys {
    pub(super) on: Name,
    pub(super) torque: TorqueValue,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

/// A number in the plane, a vector in space.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum TorqueValue {
    InPlane(f64),
    InSpace(Vec<f64>),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ForceKeys {
    pub(super) at: Vec<Vec<f64>>,
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
    pub(super) first: Option<SideKeys>,
    pub(super) second: Option<SideKeys>,
    pub(super) passes: Option<PassKeys>,
    pub(super) offset: Option<f64>,
    pub(super) friction: Option<f64>,
    pub(super) during: Option<DuringKeys>,
    #[serde(rename = "self")]
    pub(super) itself: Option<SideKeys>,
    #[serde(default)]
    pub(super) surfaces: Vec<SideKeys>,
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
pub(super) struct TieKeys {
    pub(super) first: SideKeys,
    pub(super) second: SideKeys,
    pub(super) slave: Option<TiedSlaveKeys>,
    pub(super) tolerance: Option<f64>,
    pub(super) jump: Option<Vec<f64>>,
    pub(super) preload: Option<Vec<f64>>,
    pub(super) amplitude: Option<AmplitudeKeys>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum TiedSlaveKeys {
    Finer,
    First,
    Second,
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
    pub(super) polygon: Option<Vec<Vec<f64>>>,
    pub(super) surface: Option<MeshKeys>,
    #[serde(default)]
    pub(super) motion: Motions,
    pub(super) friction: Option<f64>,
    pub(super) during: Option<DuringKeys>,
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
            _ => Err("a side is the name of a body and one boundary of it, a label or a name, as [\"block\", 3]".into()),
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

/// A boundary whose middle nodes move onto a circle, a sphere or, along an axis, a cylinder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurvedKeys {
    pub(super) on: Name,
    pub(super) radius: f64,
    pub(super) centre: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) axis: Vec<f64>,
}

/// Where a boundary is: the facets of others, or those with all corners in a place, or that look in a direction.
#[derive(Clone, Debug)]
pub(super) enum BoundaryKeys {
    Of(Vec<Name>),
    In(Region),
}

/// As a table.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Region {
    Plane(HalfSpace),
    Box(Cuboid),
    Ball(Ball),
    Cylinder(Cylinder),
    Normal(NormalKeys),
    Smooth(SmoothKeys),
}

/// The facets that look in a direction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NormalKeys {
    pub(super) direction: Vec<f64>,
    pub(super) within: f64,
}

/// The facets around a place, up to a bend.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SmoothKeys {
    pub(super) from: Vec<f64>,
    pub(super) angle: f64,
}

/// Takes a list or a table. Unlike an untagged enum, it keeps what is wrong within either, with its line.
struct Anywhere;

impl<'de> Visitor<'de> for Anywhere {
    type Value = BoundaryKeys;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of boundaries, or a table such as { plane = { point = [0, 0], normal = [0, 1] } }")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<BoundaryKeys, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(BoundaryKeys::Of)
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<BoundaryKeys, M::Error> {
        only(map, "a boundary is where one table takes its facets from").map(BoundaryKeys::In)
    }
}

impl<'de> Deserialize<'de> for BoundaryKeys {
    fn deserialize<De: serde::Deserializer<'de>>(from: De) -> Result<Self, De::Error> {
        from.deserialize_any(Anywhere)
    }
}
