//! The weak non-penetration constraints, step by step:
//! [`surface`] → [`search`] → [`projection`] → [`normals`] → [`gaps`].

pub mod gaps;
pub mod normals;
pub mod pressure;
pub mod projection;
pub mod search;
pub mod surface;

pub use gaps::Pass;
pub use search::Master;
pub use surface::Surface;
