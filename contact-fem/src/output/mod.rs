//! Output formats, each behind a cargo feature.
//!
//! | module | feature | what |
//! |---|---|---|
//! | [`snapshot`] | always | the fields of one state: displacement, pressure, stress |
//! | `vtk` | `vtk` | a `.vtu` file a step and a `.pvd` file over all of them, for ParaView |
//! | `history` | `csv` | a table of the steps and a table of the iterations |
//! | `picture` | `plot` | deformed meshes and curves as SVG |
//! | `record` | `record` | a run that makes all of these, shows progress and stops on Ctrl-C |
//! | `compare` | `record` | the differences between two results, recorded or left by a script of FreeFEM |
//!
//! A file gets its name when it is complete, or grows by whole lines: the files of an interrupted
//! run are readable.

#[cfg(feature = "record")]
pub mod compare;
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
