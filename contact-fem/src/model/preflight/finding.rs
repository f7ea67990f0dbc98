//! What the checks of a scene find.

use std::fmt;

use crate::error::Error;
use crate::tensor::Vector;

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Worth knowing; a sound scene may have it.
    Note,
    /// The scene can be solved, but its result may not be what was meant.
    Warning,
    /// [`Scene::problem`](super::super::Scene::problem) refuses the scene.
    Error,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum FindingKind {
    /// A name, a setting or a number of the input is not valid.
    Input,
    /// A boundary has no facets.
    EmptyBoundary,
    /// A rigid motion of a part is free. The value is the number of free motions.
    FreeMotion,
    /// Nothing but contact holds rigid motions of a part. The value is their number.
    HeldByContact,
    /// Neither supports nor contact hold rigid motions of a part. The value is their number.
    HeldByNothing,
    /// Parts of a body can turn against each other. The value is the number of such motions.
    Mechanism,
    /// Bodies start inside each other. The value is the depth (UL), for bodies without a contact pair as
    /// a share of what the mesh resolves there.
    Interference,
    /// Bodies without a contact pair are moved into each other. The value is the depth (UL).
    Undeclared,
    /// Surfaces of a pair are too far apart. The value is their distance (UL).
    OutOfReach,
    /// Surfaces of a pair do not face each other. The value is the largest −n·n̄ of their normals.
    FacingAway,
    /// The averaged normal at a node points into the body of a facet. The value is the cosine of their angle.
    InwardNormal,
    /// Nodes of a body lie on each other and are not joined. The value is the number of such pairs.
    OpenSeam,
    /// The material between two contact facets is thin. The value is its thickness, divided by the facet's length.
    ThinBody,
    /// A cell is a sliver. The value is its longest edge, divided by its smallest height.
    Sliver,
    /// A body is so far from the origin that its coordinates are rounded. The value is by how much, as a share of a cell's smallest height.
    FarFromOrigin,
    /// Quadratic contact facets are straight along a curve. The value is the largest angle between two of them (degrees).
    StraightFacets,
    /// Tied boundaries are not in one place. The value is their distance (UL).
    TiedApart,
    /// The facets of two surfaces differ in size. The value is the ratio of their lengths.
    MeshRatio,
    /// Linear elements lock. The value is Poisson's ratio.
    Locking,
    /// Surfaces are moved along each other by more than a facet, with contact at the reference positions. The value is
    /// that displacement, divided by the facet's length.
    BeyondFacet,
    /// A law for small strains meets a rotation. The value is the angle in degrees.
    Rotation,
    /// Laws of two kinds are in contact, and no geometry was chosen.
    Geometry,
    /// A step is longer than the search radius. The value is the motion of a step (UL).
    LongStep,
    /// Nothing is prescribed but zero, and nothing is loaded; or a load acts on held nodes alone.
    Unloaded,
    /// A load or a prescribed displacement is lost in round-off. The value is a ratio of displacements.
    RoundOff,
    /// Bodies differ in size or stiffness as units do. The value is the ratio.
    Units,
    /// In a scene of revolution, what looks like one thing in the half-plane is another one around the axis, such as a ball beside it.
    /// The value of such a ball is the radius of the ring (UL).
    Revolution,
}

/// A finding of [`Scene::preflight`](super::super::Scene::preflight).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What it is about.
    pub kind: FindingKind,
    /// The names of the bodies, and of obstacles.
    pub bodies: Vec<String>,
    /// A point of the reference configuration (UL), where there is one.
    pub place: Option<Vec<f64>>,
    /// The value found, in the unit that the kind states; NaN where there is none.
    pub value: f64,
    /// The limit of the value; NaN where there is none.
    pub limit: f64,
    /// What is found, in words.
    pub what: String,
    /// What to do about it.
    pub remedy: String,
}

impl Finding {
    /// A finding without place, value and words, about bodies or obstacles of these names.
    pub fn new(severity: Severity, kind: FindingKind, bodies: &[&String]) -> Self {
        Finding {
            severity,
            kind,
            bodies: bodies.iter().map(|name| (*name).clone()).collect(),
            place: None,
            value: f64::NAN,
            limit: f64::NAN,
            what: String::new(),
            remedy: String::new(),
        }
    }

    /// With a place (UL).
    pub(super) fn at<const D: usize>(mut self, x: &Vector<D>) -> Self {
        self.place = Some(x.iter().copied().collect());
        self
    }

    /// With a value and its limit.
    pub(super) fn measured(mut self, value: f64, limit: f64) -> Self {
        (self.value, self.limit) = (value, limit);
        self
    }

    /// With words: what is found, and what to do about it.
    #[must_use]
    pub fn says(mut self, what: String, remedy: impl Into<String>) -> Self {
        (self.what, self.remedy) = (what, remedy.into());
        self
    }

    /// The finding of an error. The remedy is what follows the last `: ` or `; ` of its message.
    pub(super) fn of(error: &Error) -> Self {
        let (kind, bodies): (_, &[&String]) = match error {
            Error::Unsupported { body, .. } => (FindingKind::FreeMotion, &[body]),
            Error::Unmerged { body, .. } => (FindingKind::OpenSeam, &[body]),
            Error::Tie { .. } => (FindingKind::TiedApart, &[]),
            Error::NoSupport => (FindingKind::FreeMotion, &[]),
            Error::Overlap { slave, master, .. } => (FindingKind::Interference, &[slave, master]),
            Error::Crossing { first, second, .. } => (FindingKind::Interference, &[first, second]),
            Error::InsideObstacle { body, obstacle, .. } => {
                (FindingKind::Interference, &[body, obstacle])
            }
            Error::ObstacleDistance { obstacle, .. } => (FindingKind::Input, &[obstacle]),
            Error::GeometryNotChosen { small, large } => (FindingKind::Geometry, &[small, large]),
            Error::Negligible { .. } => (FindingKind::RoundOff, &[]),
            Error::Excessive { body, .. } => (FindingKind::Units, &[body]),
            Error::MixedRevolution { revolved, plane } => (FindingKind::Input, &[revolved, plane]),
            Error::BodyExists { name, .. } => (FindingKind::Input, &[name]),
            _ => (FindingKind::Input, &[]),
        };
        let message = error.to_string();
        let split = message.rfind(": ").max(message.rfind("; "));
        let (what, remedy) = message.split_at(split.unwrap_or(message.len()));
        let finding = Finding::new(Severity::Error, kind, bodies);
        let mut finding =
            finding.says(what.to_string(), remedy.trim_start_matches([':', ';', ' ']));
        match error {
            Error::Unsupported { free, .. } => finding.measured(*free as f64, 0.0),
            Error::Overlap {
                x, gap, tolerance, ..
            } => {
                finding.place = Some(x.clone());
                finding.measured(-gap, *tolerance)
            }
            Error::Crossing {
                x,
                depth,
                tolerance,
                ..
            } => {
                finding.place = Some(x.clone());
                finding.measured(*depth, *tolerance)
            }
            Error::InsideObstacle {
                x,
                depth,
                tolerance,
                ..
            } => {
                finding.place = Some(x.clone());
                finding.measured(*depth, *tolerance)
            }
            Error::ObstacleDistance { x, value, .. } => {
                finding.place = Some(x.clone());
                finding.measured(*value, f64::NAN)
            }
            Error::Negligible { share, limit, .. } | Error::Excessive { share, limit, .. } => {
                finding.measured(*share, *limit)
            }
            Error::Setting { value, .. } | Error::NotFinite { value, .. } => {
                finding.measured(*value, f64::NAN)
            }
            _ => finding,
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        })
    }
}

/// The severity, what is found and what to do.
impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.severity, self.what, self.remedy)
    }
}
