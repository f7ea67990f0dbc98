//! The model: bodies with supports and loads, the contact pairs between them, and the contact
//! problem of a scene.

mod body;
mod contact_set;
mod contact_state;
mod courses;
mod diagnosis;
mod estimate;
mod extent;
mod handle;
mod initial_gaps;
mod kinematics;
mod phases;
mod plan;
mod preflight;
mod problem;
mod results;
mod scale;
mod scene;
mod switches;
mod tie;
pub(crate) mod work;

pub use crate::contact::{Corners, Integration, Obstacle, Projection};
pub use body::{ALL_NODES, Body, RigidMotion, name_of_nodes};
pub use contact_state::{GeometricError, Opposite, PairRecord, PairSide, PairState, Status};
pub use diagnosis::{Crease, Undetermined};
pub(crate) use estimate::CellErrors;
pub use estimate::{BodyError, ContactFacets, ErrorEstimate};
pub use handle::{BodyId, ObstacleId, Side};
pub use initial_gaps::InitialGaps;
pub use plan::ScenePlan;
pub(crate) use preflight::Report;
pub use preflight::{Finding, FindingKind, Severity};
pub use problem::Problem;
pub(crate) use problem::answers::Answers;
pub(crate) use scale::negligible;
pub use scene::{Geometry, Overlaps, Pair, Passes, Scene};
pub use tie::{Tie, TieFault, TieRecord, TiedSlave};
pub use work::{WorkRecord, WorkSource};
