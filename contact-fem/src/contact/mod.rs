//! The weak non-penetration constraints, step by step:
//! [`surface`] → [`cut`] → [`search`] → [`projection`] → [`normals`] → [`gaps`].

mod clip;
pub mod cut;
pub mod gaps;
pub mod motion;
pub mod normals;
pub mod pressure;
pub mod projection;
pub mod search;
pub mod surface;

pub use cut::Integration;
pub use gaps::Pass;
pub use search::Master;
pub use surface::Surface;
