//! The weak non-penetration constraints, step by step:
//! [`surface`] → [`moving`] with its [`normals`] → [`cut`] → [`search`] with its [`projection`] →
//! [`stencil`] → [`rows`]; derivatives that follow the projection: [`gap`].

mod clip;
pub mod cut;
pub mod gap;
pub mod motion;
pub mod moving;
pub mod normals;
pub mod pressure;
pub mod projection;
pub mod rows;
pub mod search;
pub mod stencil;
pub mod surface;
mod tree;
pub mod variation;

pub use cut::Integration;
pub use gap::MovingGap;
pub use moving::Moving;
pub use rows::Pass;
pub use search::Master;
pub use stencil::Stencil;
pub use surface::Surface;
