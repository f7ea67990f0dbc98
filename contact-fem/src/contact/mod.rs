//! The weak non-penetration constraints, step by step:
//! [`surface`] → [`moving`] with its [`normals`] → [`cut`] → [`search`] with its [`projection`], and what is seen (`seen.rs`) →
//! [`stencil`] → [`rows`]; derivatives that follow the projection: [`gap`]. On a rigid [`obstacle`], distances take the place
//! of the search.

mod along_normals;
mod clip;
mod closed_surface;
pub mod corner;
pub mod cut;
pub mod edge;
pub mod gap;
pub mod motion;
pub mod moving;
pub mod normals;
pub mod obstacle;
#[cfg(planted)]
mod planted;
pub mod pressure;
pub mod projection;
mod rim;
pub mod rows;
pub mod search;
mod seen;
pub mod stencil;
pub mod surface;
pub mod tie;
mod tree;
pub mod variation;
mod weighing;

pub use corner::Corners;
pub use cut::Integration;
pub use gap::MovingGap;
pub use moving::Moving;
pub use obstacle::Obstacle;
pub use projection::Projection;
pub use rows::Pass;
pub use search::Master;
pub use stencil::{Against, Stencil};
pub use surface::Surface;
