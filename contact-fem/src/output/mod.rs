//! Files for people and programs, each format behind a cargo feature.
//!
//! | module | feature | what |
//! |---|---|---|
//! | [`snapshot`] | always | the fields of one state: displacement, pressure, stress |
//! | `vtk` | `vtk` | a `.vtu` file a step and a `.pvd` file over all of them, for ParaView |
//! | `history` | `csv` | a table of the steps and a table of the fixed-point iterations |
//! | `picture` | `plot` | deformed meshes and curves as SVG |
//! | `record` | `record` | a run that makes all of these, shows progress and stops on Ctrl-C |
//!
//! Files appear under their names only once they are complete, or grow by whole lines: whatever a
//! run leaves when it is interrupted can be read.

#[cfg(feature = "csv")]
pub mod history;
#[cfg(feature = "plot")]
pub mod picture;
#[cfg(feature = "record")]
pub mod record;
pub mod snapshot;
#[cfg(feature = "vtk")]
pub mod vtk;

pub use snapshot::Snapshot;

#[cfg(any(feature = "csv", feature = "plot", feature = "vtk"))]
mod file;
